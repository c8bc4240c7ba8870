/* Bad inputs to the setting up of simulations. */
#include "bad.h"

static perion_simulation *made;
static const double lower[] = {0.0, 0.0, 0.0}, upper[] = {6.0, 3.0, 3.0};

/* What two settings of a model, if any, are refused for by create. */
static void refused_with(int32_t dimension, const char *fragment, const char *key, double value,
                         const char *other, double other_value)
{
    perion_points *points = NULL;
    perion_model *model = scene_model();

    EXPECT_OK(perion_points_create_block(dimension, lower, upper, 1.0, &points));
    EXPECT_OK(perion_model_set(model, key, value));
    if (other != NULL)
        EXPECT_OK(perion_model_set(model, other, other_value));
    SEAL(made);
    EXPECT_REFUSED(ARGUMENT, fragment, perion_simulation_create(points, model, &made));
    EXPECT_SEALED(made);
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_points_destroy(&points));
}

static void what_a_model_holds_fits_together(void)
{
    refused_with(3, "critical_energy_release_rate", "critical_energy_release_rate", 1.0, NULL, 0.0);
    refused_with(3, "elastic", "bulk_modulus", 1.0, "shear_modulus", 1.0);
    refused_with(3, "Poisson", "poissons_ratio", 0.3, NULL, 0.0);
    refused_with(2, "Poisson", "poissons_ratio", 0.3, NULL, 0.0);
    refused_with(3, "Poisson", "shear_modulus", 0.5, NULL, 0.0);
    refused_with(3, "thickness", "thickness", 0.1, NULL, 0.0);
}

static void a_plane_is_for_two_dimensions(void)
{
    perion_points *points = scene_points();
    perion_model *model = scene_model();

    EXPECT_OK(perion_model_choose(model, "plane", "stress"));
    SEAL(made);
    EXPECT_REFUSED(ARGUMENT, "plane", perion_simulation_create(points, model, &made));
    EXPECT_SEALED(made);
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_points_destroy(&points));
}

static void a_model_is_complete(void)
{
    static const char *const needed[] = {"density", "horizon", "youngs_modulus"};
    static const char *const named[] = {"density", "horizon", "elastic constant"};
    perion_points *points = scene_points();

    for (int missing = 0; missing < 3; ++missing) {
        perion_model *model = NULL;
        EXPECT_OK(perion_model_create("bond_based", &model));
        for (int k = 0; k < 3; ++k)
            if (k != missing)
                EXPECT_OK(perion_model_set(model, needed[k], 2.1));
        SEAL(made);
        EXPECT_REFUSED(ARGUMENT, named[missing], perion_simulation_create(points, model, &made));
        EXPECT_OK(perion_model_set(model, needed[missing], 2.1));
        EXPECT_OK(perion_model_choose(model, "damage", "critical_stretch"));
        EXPECT_REFUSED(ARGUMENT, "damage", perion_simulation_create(points, model, &made));
        EXPECT_SEALED(made);
        EXPECT_OK(perion_model_destroy(&model));
    }
    EXPECT_OK(perion_points_destroy(&points));
}

static void create_takes_live_handles(void)
{
    perion_points *points = scene_points();
    perion_model *model = scene_model();

    SEAL(made);
    EXPECT_REFUSED(NULLED, "points", perion_simulation_create(NULL, model, &made));
    EXPECT_REFUSED(NULLED, "model", perion_simulation_create(points, NULL, &made));
    EXPECT_REFUSED(NULLED, "simulation", perion_simulation_create(points, model, NULL));
    EXPECT_REFUSED(ARGUMENT, "simulation",
                   perion_simulation_create(points, model, MISALIGNED(perion_simulation *)));
    EXPECT_REFUSED(ARGUMENT, "points",
                   perion_simulation_create((perion_points *)(void *)model, model, &made));
    EXPECT_REFUSED(ARGUMENT, "model",
                   perion_simulation_create(points, (perion_model *)(void *)points, &made));
    EXPECT_SEALED(made);
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_points_destroy(&points));
}

/* Before set-up has ended: what can be told without ending it stays, and so does the motion after. */
#define state_of scene_early_state_of

static void materials_are_complete_and_for_sets(perion_simulation *simulation)
{
    scene_state state = state_of(simulation);
    perion_model *model = scene_model(), *empty = NULL;

    EXPECT_OK(perion_model_create("bond_based", &empty));
    REFUSE(NULLED, "simulation", perion_simulation_assign_model(NULL, "left", model));
    REFUSE(NULLED, "set", perion_simulation_assign_model(simulation, NULL, model));
    REFUSE(NULLED, "model", perion_simulation_assign_model(simulation, "left", NULL));
    REFUSE(ARGUMENT, "set 'lft'; did you mean 'left'?",
           perion_simulation_assign_model(simulation, "lft", model));
    REFUSE(ARGUMENT, "set", perion_simulation_assign_model(simulation, latin1, model));
    REFUSE(ARGUMENT, "model", perion_simulation_assign_model(simulation, "left", empty));
    REFUSE(ARGUMENT, "model",
           perion_simulation_assign_model(simulation, "left", NO_HANDLE(perion_model)));
    EXPECT_OK(perion_model_choose(model, "plane", "strain"));
    REFUSE(ARGUMENT, "plane", perion_simulation_assign_model(simulation, "left", model));
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_model_destroy(&empty));
    scene_state_free(&state);
}

static void interfaces_stand_between_sets(perion_simulation *simulation)
{
    static const double bad[] = {0.0, -1.0, NAN, INFINITY, -INFINITY};
    scene_state state = state_of(simulation);

    REFUSE(NULLED, "simulation", perion_simulation_set_interface(NULL, "left", "right", 1.0));
    REFUSE(NULLED, "set_a", perion_simulation_set_interface(simulation, NULL, "right", 1.0));
    REFUSE(NULLED, "set_b", perion_simulation_set_interface(simulation, "left", NULL, 1.0));
    REFUSE(ARGUMENT, "set", perion_simulation_set_interface(simulation, "up", "right", 1.0));
    REFUSE(ARGUMENT, "set 'rigth'; did you mean 'right'?",
           perion_simulation_set_interface(simulation, "left", "rigth", 1.0));
    REFUSE(ARGUMENT, "set_b", perion_simulation_set_interface(simulation, "left", latin1, 1.0));
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; ++k)
        REFUSE(ARGUMENT, "critical_energy_release_rate",
               perion_simulation_set_interface(simulation, "left", "right", bad[k]));
    scene_state_free(&state);
}

static void protection_and_threads(perion_simulation *simulation)
{
    static const int32_t bad[] = {0, -1, 4097, 100000, INT32_MAX, INT32_MIN};
    scene_state state = state_of(simulation);

    REFUSE(NULLED, "simulation", perion_simulation_forbid_failure(NULL, "left"));
    REFUSE(NULLED, "set", perion_simulation_forbid_failure(simulation, NULL));
    REFUSE(ARGUMENT, "set 'lleft'; did you mean 'left'?",
           perion_simulation_forbid_failure(simulation, "lleft"));
    REFUSE(NULLED, "simulation", perion_simulation_set_threads(NULL, 1));
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; ++k)
        REFUSE(ARGUMENT, "threads", perion_simulation_set_threads(simulation, bad[k]));
    scene_state_free(&state);
}

static void pairs_are_of_two_points(perion_simulation *simulation)
{
    static const int64_t wrong[][2] = {{0, 384}, {384, 0}, {-1, 0}, {0, INT64_MIN}, {INT64_MAX, 0}, {5, 5}};
    static const int64_t good[] = {0, 1, 1, 2};
    static const double bad[] = {-0.5, 1.5, NAN, INFINITY, -INFINITY};
    double values[] = {0.5, 0.5};
    scene_state state = state_of(simulation);

    REFUSE(NULLED, "simulation", perion_simulation_break_bonds(NULL, 1, good));
    REFUSE(NULLED, "pairs", perion_simulation_break_bonds(simulation, 1, NULL));
    REFUSE(ARGUMENT, "pairs", perion_simulation_break_bonds(simulation, 1, MISALIGNED(int64_t)));
    REFUSE(ARGUMENT, "count", perion_simulation_break_bonds(simulation, -1, good));
    REFUSE(ARGUMENT, "count", perion_simulation_break_bonds(simulation, INT64_MIN, good));
    REFUSE(ARGUMENT, "count", perion_simulation_break_bonds(simulation, INT64_MAX, good));
    REFUSE(ARGUMENT, "count", perion_simulation_break_bonds(simulation, INT64_MAX / 4, good));
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        REFUSE(ARGUMENT, "pairs'[0]", perion_simulation_break_bonds(simulation, 1, wrong[k]));
        REFUSE(ARGUMENT, "pairs'[0]",
               perion_simulation_set_bond_integrity(simulation, 1, wrong[k], values));
    }
    REFUSE(NULLED, "simulation", perion_simulation_set_bond_integrity(NULL, 2, good, values));
    REFUSE(NULLED, "pairs", perion_simulation_set_bond_integrity(simulation, 2, NULL, values));
    REFUSE(NULLED, "values", perion_simulation_set_bond_integrity(simulation, 2, good, NULL));
    REFUSE(ARGUMENT, "values",
           perion_simulation_set_bond_integrity(simulation, 2, good, MISALIGNED(double)));
    REFUSE(ARGUMENT, "count", perion_simulation_set_bond_integrity(simulation, -2, good, values));
    REFUSE(ARGUMENT, "count", perion_simulation_set_bond_integrity(simulation, INT64_MAX, good, values));
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; ++k) {
        values[1] = bad[k];
        REFUSE(ARGUMENT, "values'[1]",
               perion_simulation_set_bond_integrity(simulation, 2, good, values));
    }
    scene_state_free(&state);
}

static void cracks_are_planar_and_have_an_extent(perion_simulation *simulation)
{
    static const double line[] = {0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0};
    static const double spot[] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    static const double bow[] = {0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0};
    static const double warped[] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.5};
    static const double wild[] = {NAN, INFINITY, -INFINITY, 1e300};
    double vertices[] = {6.0, 0.0, 0.0, 6.0, 8.0, 0.0, 6.0, 0.0, 4.0};
    scene_state state = state_of(simulation);

    REFUSE(NULLED, "simulation", perion_simulation_break_crossing(NULL, 3, vertices));
    REFUSE(NULLED, "vertices", perion_simulation_break_crossing(simulation, 3, NULL));
    REFUSE(ARGUMENT, "vertices", perion_simulation_break_crossing(simulation, 1, MISALIGNED(double)));
    REFUSE(ARGUMENT, "vertex_count", perion_simulation_break_crossing(simulation, 0, NULL));
    REFUSE(ARGUMENT, "vertex_count", perion_simulation_break_crossing(simulation, 2, vertices));
    REFUSE(ARGUMENT, "vertex_count", perion_simulation_break_crossing(simulation, -3, vertices));
    REFUSE(ARGUMENT, "vertex_count", perion_simulation_break_crossing(simulation, INT64_MIN, vertices));
    REFUSE(ARGUMENT, "vertex_count", perion_simulation_break_crossing(simulation, INT64_MAX, vertices));
    REFUSE(ARGUMENT, "vertices",
           perion_simulation_break_crossing(simulation, INT64_MAX / 3, vertices));
    REFUSE(ARGUMENT, "vertices", perion_simulation_break_crossing(simulation, 3, line));
    REFUSE(ARGUMENT, "vertices", perion_simulation_break_crossing(simulation, 3, spot));
    REFUSE(ARGUMENT, "vertices", perion_simulation_break_crossing(simulation, 4, bow));
    REFUSE(ARGUMENT, "vertices", perion_simulation_break_crossing(simulation, 4, warped));
    for (size_t k = 0; k < sizeof wild / sizeof wild[0]; ++k) {
        vertices[4] = wild[k];
        REFUSE(ARGUMENT, "vertex 1", perion_simulation_break_crossing(simulation, 3, vertices));
    }
    scene_state_free(&state);
}
#undef state_of

static void bonds_are_listed_whole_or_not_at_all(perion_simulation *simulation)
{
    int64_t count, pairs[8];
    double stretch[8];
#define state_of scene_state_of
    scene_state state = state_of(simulation);

    SEAL(pairs);
    SEAL(stretch);
    REFUSE_OUTPUT(count, NULLED, "simulation",
                  perion_simulation_get_bonds(NULL, 0, NULL, NULL, NULL, &count));
    REFUSE(NULLED, "count", perion_simulation_get_bonds(simulation, 4, pairs, stretch, NULL, NULL));
    REFUSE_OUTPUT(count, ARGUMENT, "capacity",
                  perion_simulation_get_bonds(simulation, 4, pairs, stretch, NULL, &count));
    REFUSE_OUTPUT(count, ARGUMENT, "capacity",
                  perion_simulation_get_bonds(simulation, -1, pairs, stretch, NULL, &count));
    REFUSE_OUTPUT(count, ARGUMENT, "pairs",
                  perion_simulation_get_bonds(simulation, INT64_MAX, MISALIGNED(int64_t), NULL, NULL,
                                              &count));
    REFUSE(NULLED, "count", perion_simulation_bond_count(simulation, NULL));
    REFUSE(NULLED, "count", perion_simulation_point_count(simulation, NULL));
    REFUSE_OUTPUT(count, NULLED, "simulation", perion_simulation_point_count(NULL, &count));
    REFUSE(NULLED, "dimension", perion_simulation_dimension(simulation, NULL));
    REFUSE(NULLED, "simulation", perion_simulation_dimension(NULL, (int32_t[]){0}));
    REFUSE_OUTPUT(count, NULLED, "simulation", perion_simulation_bond_count(NULL, &count));
    EXPECT_SEALED(pairs);
    EXPECT_SEALED(stretch);
    scene_state_free(&state);
#undef state_of
}

/* The refused calls have left nothing behind: the bar moves as one on which none was made. */
static void expect_the_motion_of_an_untouched_one(perion_simulation *simulation)
{
    perion_simulation *other = bad_running();
    scene_state state = scene_state_of(other);

    scene_throw(simulation);
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 12));
    EXPECT(scene_is(&state, scene_state_of(simulation)));
    scene_state_free(&state);
    EXPECT_OK(perion_simulation_destroy(&other));
}

void bad_setup(void)
{
    perion_simulation *simulation;

    what_a_model_holds_fits_together();
    a_plane_is_for_two_dimensions();
    a_model_is_complete();
    create_takes_live_handles();
    simulation = scene_simulation();
    materials_are_complete_and_for_sets(simulation);
    interfaces_stand_between_sets(simulation);
    protection_and_threads(simulation);
    pairs_are_of_two_points(simulation);
    cracks_are_planar_and_have_an_extent(simulation);
    expect_the_motion_of_an_untouched_one(simulation);
    bonds_are_listed_whole_or_not_at_all(simulation);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}
