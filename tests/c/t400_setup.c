/* Setting a simulation up: materials by set, interfaces, cracks, bonds, threads. */
#include "harness.h"
#include "scene.h"

#include <stdlib.h>

static void points_and_model_may_go(void)
{
    perion_simulation *simulation = scene_simulation(), *none = NULL;

    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 1));
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT(simulation == NULL);
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT_OK(perion_simulation_destroy(&none));
    EXPECT_OK(perion_simulation_destroy(NULL));
}

static void a_set_can_have_another_material(void)
{
    perion_simulation *simulation = scene_simulation();
    perion_model *heavy = scene_model();
    double density[SCENE_COUNT];

    EXPECT_OK(perion_model_set(heavy, "density", 8.0));
    EXPECT_OK(perion_simulation_assign_model(simulation, "right", heavy));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_DENSITY, density, SCENE_COUNT));
    for (int point = 0; point < SCENE_COUNT; ++point)
        EXPECT_REAL(density[point], point % 12 == 11 ? 8.0 : 1.0);
    EXPECT_OK(perion_model_destroy(&heavy));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static int64_t broken_after_pull(void (*prepare)(perion_simulation *))
{
    perion_simulation *simulation = scene_simulation();
    perion_health health;

    perion_health_init(&health, sizeof(perion_health));
    prepare(simulation);
    scene_throw(simulation);
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 20));
    EXPECT_OK(perion_simulation_health(simulation, &health));
    EXPECT_OK(perion_simulation_destroy(&simulation));
    return health.broken_bonds;
}

static void as_it_is(perion_simulation *simulation)
{
    (void)simulation;
}

static void protect_all(perion_simulation *simulation)
{
    EXPECT_OK(perion_simulation_forbid_failure(simulation, "all"));
}

static void glue_all(perion_simulation *simulation)
{
    EXPECT_OK(perion_simulation_set_interface(simulation, "all", "all", 1e6));
}

static void protected_and_glued_bonds_hold(void)
{
    EXPECT(broken_after_pull(as_it_is) > 100);
    EXPECT_INT(broken_after_pull(protect_all), 0);
    EXPECT_INT(broken_after_pull(glue_all), 0);
}

/* Number of bonds whose integrity is as given. */
static int64_t bonds_of_integrity(const perion_simulation *simulation, double wanted)
{
    int64_t count = 0, found = 0, bonds = 0;
    double *integrity;

    EXPECT_OK(perion_simulation_get_bonds(simulation, 0, NULL, NULL, NULL, &count));
    EXPECT_OK(perion_simulation_bond_count(simulation, &bonds));
    EXPECT_INT(count, bonds);
    integrity = calloc((size_t)count + 1, sizeof *integrity);
    if (integrity == NULL)
        abort();
    EXPECT_OK(perion_simulation_get_bonds(simulation, count + 7, NULL, NULL, integrity, &count));
    for (int64_t k = 0; k < count; ++k)
        found += integrity[k] == wanted;
    free(integrity);
    return found;
}

static void bonds_break_one_by_one(void)
{
    static const int64_t pairs[] = {0, 1, 2, 1, 0, SCENE_COUNT - 1};
    static const double half[] = {0.5, 0.5, 0.5};
    perion_simulation *simulation = scene_simulation();

    EXPECT_OK(perion_simulation_break_bonds(simulation, 1, pairs));
    EXPECT_OK(perion_simulation_break_bonds(simulation, 0, NULL));
    EXPECT_INT(bonds_of_integrity(simulation, 0.0), 1);
    EXPECT_OK(perion_simulation_set_bond_integrity(simulation, 3, pairs, half));
    EXPECT_INT(bonds_of_integrity(simulation, 0.0), 1);
    EXPECT_INT(bonds_of_integrity(simulation, 0.5), 1);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* A crack through the middle cuts the bar in two. */
static void no_bond_crosses_a_crack(void)
{
    static const double crack[] = {6.0, -1.0, -1.0, 6.0, 9.0, -1.0, 6.0, 9.0, 5.0, 6.0, -1.0, 5.0};
    perion_simulation *simulation = scene_simulation();
    int64_t count = 0, *pairs, wrong = 0;
    double *integrity;

    EXPECT_OK(perion_simulation_break_crossing(simulation, 4, crack));
    EXPECT_OK(perion_simulation_bond_count(simulation, &count));
    pairs = calloc(2 * (size_t)count + 2, sizeof *pairs);
    integrity = calloc((size_t)count + 1, sizeof *integrity);
    if (pairs == NULL || integrity == NULL)
        abort();
    EXPECT_OK(perion_simulation_get_bonds(simulation, count, pairs, NULL, integrity, &count));
    for (int64_t k = 0; k < count; ++k) {
        int crosses = (pairs[2 * k] % 12 < 6) != (pairs[2 * k + 1] % 12 < 6);
        wrong += integrity[k] != (crosses ? 0.0 : 1.0);
    }
    EXPECT_INT(wrong, 0);
    free(pairs);
    free(integrity);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static scene_state run_on(int32_t threads)
{
    perion_simulation *simulation = scene_simulation();
    scene_state result;

    EXPECT_OK(perion_simulation_set_threads(simulation, threads));
    scene_throw(simulation);
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 10));
    EXPECT_OK(perion_simulation_set_threads(simulation, threads + 1));
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 10));
    result = scene_result_of(simulation);
    EXPECT_OK(perion_simulation_destroy(&simulation));
    return result;
}

static void threads_change_no_bit(void)
{
    scene_state alone = run_on(1);

    for (int32_t threads = 2; threads < 5; ++threads)
        EXPECT(scene_is(&alone, run_on(threads)));
    scene_state_free(&alone);
}

static void set_up_ends_with_the_first_step(void)
{
    perion_simulation *simulation = scene_simulation();
    perion_model *model = scene_model();

    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 1));
    EXPECT_REFUSED(PERION_ERROR_STATE, "set-up",
                   perion_simulation_assign_model(simulation, "left", model));
    EXPECT_REFUSED(PERION_ERROR_STATE, "set-up",
                   perion_simulation_set_interface(simulation, "left", "right", 1.0));
    EXPECT_OK(perion_simulation_forbid_failure(simulation, "left"));
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

int main(void)
{
    harness_begin();
    points_and_model_may_go();
    a_set_can_have_another_material();
    protected_and_glued_bonds_hold();
    bonds_break_one_by_one();
    no_bond_crosses_a_crack();
    threads_change_no_bit();
    set_up_ends_with_the_first_step();
    return harness_end();
}
