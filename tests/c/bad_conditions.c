/* Bad inputs to conditions, on a simulation under way and on one that was never evaluated. */
#include "bad.h"

static const double times[] = {0.0, 1.0, 2.0}, values[SCENE_LAYER] = {0.0, 0.5, 0.25};

static int never(void *user, double time, int64_t count, const double *reference_positions,
                 double *out)
{
    (void)user;
    (void)time;
    (void)count;
    (void)reference_positions;
    (void)out;
    EXPECT(!"a refused function is called");
    return 1;
}

/* What the five functions have in common: simulation, set, quantity and axis. */
static perion_status condition(int kind, perion_simulation *simulation, const char *set,
                               perion_quantity quantity, int32_t axis)
{
    switch (kind) {
    case 0:
        return perion_simulation_prescribe(simulation, set, quantity, axis, 0.5);
    case 1:
        return perion_simulation_prescribe_table(simulation, set, quantity, axis, 3, times, values);
    case 2:
        return perion_simulation_prescribe_function(simulation, set, quantity, axis, never, NULL);
    case 3:
        return perion_simulation_prescribe_values(simulation, set, quantity, axis, SCENE_LAYER, values);
    default:
        return perion_simulation_release(simulation, set, quantity, axis);
    }
}

enum { KINDS = 5 };
static const char *const names[KINDS] = {
    "perion_simulation_prescribe(",        "perion_simulation_prescribe_table(",
    "perion_simulation_prescribe_function(", "perion_simulation_prescribe_values(",
    "perion_simulation_release(",
};

typedef scene_state (*snapshot)(const perion_simulation *);

/* A refusal of each of the five, by the function's own name. */
static void refuse_all(snapshot state_of, perion_simulation *simulation, perion_status status,
                       const char *fragment, const char *set, perion_quantity quantity, int32_t axis)
{
    scene_state state = state_of(simulation);

    for (int kind = 0; kind < KINDS; ++kind) {
        harness_refused(condition(kind, simulation, set, quantity, axis), status, fragment, names[kind],
                        __FILE__, __LINE__);
        EXPECT(scene_is(&state, state_of(simulation)));
    }
    scene_state_free(&state);
}

static void sets_quantities_and_axes_exist(snapshot state_of, perion_simulation *simulation)
{
    static const perion_quantity quantities[] = {0, 5, -1, INT32_MAX, INT32_MIN};
    static const int32_t axes[] = {3, -1, INT32_MAX, INT32_MIN};
    static const perion_quantity known[] = {PERION_QUANTITY_DISPLACEMENT, PERION_QUANTITY_VELOCITY,
                                            PERION_QUANTITY_BODY_FORCE, PERION_QUANTITY_TRACTION};

    for (size_t k = 0; k < sizeof quantities / sizeof quantities[0]; ++k)
        refuse_all(state_of, simulation, ARGUMENT, "quantity", "left", quantities[k], 0);
    for (int k = 0; k < 4; ++k) {
        for (size_t axis = 0; axis < sizeof axes / sizeof axes[0]; ++axis)
            refuse_all(state_of, simulation, ARGUMENT, "axis", "left", known[k], axes[axis]);
        refuse_all(state_of, simulation, NULLED, "set", NULL, known[k], 0);
        refuse_all(state_of, simulation, ARGUMENT, "set", "middle", known[k], 0);
        refuse_all(state_of, simulation, ARGUMENT, "did you mean 'left'?", "Left", known[k], 0);
        refuse_all(state_of, simulation, ARGUMENT, "set", "", known[k], 0);
        refuse_all(state_of, simulation, ARGUMENT, "set", latin1, known[k], 0);
        refuse_all(state_of, simulation, ARGUMENT, "set", endless, known[k], 0);
    }
    for (int kind = 0; kind < KINDS; ++kind)
        harness_refused(condition(kind, NULL, "left", 1, 0), NULLED, "simulation", names[kind],
                        __FILE__, __LINE__);
}

static void values_are_finite(snapshot state_of, perion_simulation *simulation,
                              perion_quantity quantity)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    scene_state state = state_of(simulation);
    double own[SCENE_LAYER] = {0.0};

    for (int k = 0; k < 3; ++k) {
        own[2] = bad[k];
        REFUSE(ARGUMENT, "value",
               perion_simulation_prescribe(simulation, "left", quantity, 0, bad[k]));
        REFUSE(ARGUMENT, "values'[2]",
               perion_simulation_prescribe_table(simulation, "left", quantity, 0, 3, times, own));
        REFUSE(ARGUMENT, "times'[2]",
               perion_simulation_prescribe_table(simulation, "left", quantity, 0, 3, own, values));
        REFUSE(ARGUMENT, "values'[2]",
               perion_simulation_prescribe_values(simulation, "left", quantity, 0, SCENE_LAYER, own));
    }
    scene_state_free(&state);
}

static void tables_increase(snapshot state_of, perion_simulation *simulation, perion_quantity quantity)
{
    static const double still[] = {0.0, 1.0, 1.0}, back[] = {0.0, 1.0, 0.5}, zeros[] = {-0.0, 0.0};
    scene_state state = state_of(simulation);

#define TABLE(status, fragment, count, times, values)                                               \
    REFUSE(status, fragment,                                                                        \
           perion_simulation_prescribe_table(simulation, "left", quantity, 0, count, times, values))
    TABLE(ARGUMENT, "times'[2]", 3, still, values);
    TABLE(ARGUMENT, "times'[2]", 3, back, values);
    TABLE(ARGUMENT, "times'[1]", 2, zeros, values);
    TABLE(ARGUMENT, "times", 0, times, values);
    TABLE(ARGUMENT, "times", 0, NULL, NULL);
    TABLE(ARGUMENT, "count", -1, times, values);
    TABLE(ARGUMENT, "count", INT64_MIN, times, values);
    TABLE(ARGUMENT, "count", INT64_MAX, times, values);
    TABLE(NULLED, "times", 3, NULL, values);
    TABLE(NULLED, "values", 3, times, NULL);
    TABLE(ARGUMENT, "times", 3, MISALIGNED(double), values);
    TABLE(ARGUMENT, "values", 3, times, MISALIGNED(double));
#undef TABLE
    scene_state_free(&state);
}

static void values_are_as_many_as_points(snapshot state_of, perion_simulation *simulation,
                                         perion_quantity quantity)
{
    static const int64_t counts[] = {0, 1, SCENE_LAYER - 1, SCENE_LAYER + 1, -1, INT64_MIN, INT64_MAX};
    scene_state state = state_of(simulation);

    for (size_t k = 0; k < sizeof counts / sizeof counts[0]; ++k)
        REFUSE(ARGUMENT, "count",
               perion_simulation_prescribe_values(simulation, "left", quantity, 0, counts[k], values));
    /* By their number, before any of them is read. */
    REFUSE(ARGUMENT, "count",
           perion_simulation_prescribe_values(simulation, "left", quantity, 0, 1LL << 58, values));
    REFUSE(NULLED, "values",
           perion_simulation_prescribe_values(simulation, "left", quantity, 0, SCENE_LAYER, NULL));
    REFUSE(ARGUMENT, "values",
           perion_simulation_prescribe_values(simulation, "left", quantity, 0, SCENE_LAYER,
                                              MISALIGNED(double)));
    REFUSE(NULLED, "function",
           perion_simulation_prescribe_function(simulation, "left", quantity, 0, NULL, NULL));
    scene_state_free(&state);
}

static void what_was_not_prescribed_cannot_be_released(snapshot state_of,
                                                       perion_simulation *simulation)
{
    scene_state state = state_of(simulation);

    for (perion_quantity quantity = 1; quantity <= 4; ++quantity)
        REFUSE(ARGUMENT, "set", perion_simulation_release(simulation, "left", quantity, 0));
    scene_state_free(&state);
}

static void areas_are_positive_and_one_a_point(snapshot state_of, perion_simulation *simulation)
{
    static const double bad[] = {0.0, -1.0, NAN, INFINITY};
    double areas[SCENE_LAYER];
    scene_state state = state_of(simulation);

    for (int k = 0; k < SCENE_LAYER; ++k)
        areas[k] = 1.0;
    REFUSE(ARGUMENT, "count", perion_simulation_set_surface_areas(simulation, "left", -1, areas));
    REFUSE(ARGUMENT, "32",
           perion_simulation_set_surface_areas(simulation, "left", SCENE_LAYER - 1, areas));
    REFUSE(ARGUMENT, "set",
           perion_simulation_set_surface_areas(simulation, "middle", SCENE_LAYER, areas));
    REFUSE(NULLED, "set", perion_simulation_set_surface_areas(simulation, NULL, SCENE_LAYER, areas));
    REFUSE(NULLED, "areas",
           perion_simulation_set_surface_areas(simulation, "left", SCENE_LAYER, NULL));
    REFUSE(NULLED, "simulation",
           perion_simulation_set_surface_areas(NULL, "left", SCENE_LAYER, areas));
    for (int k = 0; k < 4; ++k) {
        areas[7] = bad[k];
        REFUSE(ARGUMENT, "'areas'[7]",
               perion_simulation_set_surface_areas(simulation, "left", SCENE_LAYER, areas));
    }
    scene_state_free(&state);
}

static void refuse_everything(snapshot state_of, perion_simulation *simulation)
{
    sets_quantities_and_axes_exist(state_of, simulation);
    for (perion_quantity quantity = 1; quantity <= 4; ++quantity) {
        values_are_finite(state_of, simulation, quantity);
        tables_increase(state_of, simulation, quantity);
        values_are_as_many_as_points(state_of, simulation, quantity);
    }
    what_was_not_prescribed_cannot_be_released(state_of, simulation);
    areas_are_positive_and_one_a_point(state_of, simulation);
}

void bad_conditions(void)
{
    perion_simulation *running = bad_running(), *fresh = scene_simulation();
    scene_state state = scene_state_of(running);

    refuse_everything(scene_state_of, running);
    refuse_everything(scene_early_state_of, fresh);
    scene_throw(fresh);
    EXPECT_OK(perion_simulation_step(fresh, scene_time_step, 12));
    EXPECT(scene_is(&state, scene_state_of(fresh)));
    scene_state_free(&state);
    EXPECT_OK(perion_simulation_destroy(&running));
    EXPECT_OK(perion_simulation_destroy(&fresh));
}
