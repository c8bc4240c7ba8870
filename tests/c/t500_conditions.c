/* Conditions: constants, tables, functions and values on sets, and their release. */
#include "harness.h"
#include "scene.h"

#include <string.h>

static double displacement[SCENE_LENGTH], velocity[SCENE_LENGTH];

static void read_motion(const perion_simulation *simulation)
{
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, displacement, SCENE_LENGTH));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, velocity, SCENE_LENGTH));
}

static void constants_hold_their_sets(void)
{
    perion_simulation *simulation = scene_simulation();

    scene_throw(simulation);
    EXPECT_OK(perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_DISPLACEMENT, 0, 0.25));
    EXPECT_OK(perion_simulation_prescribe(simulation, "right", PERION_QUANTITY_VELOCITY, 2, 0.5));
    EXPECT_OK(perion_simulation_step(simulation, 0.5, 4));
    read_motion(simulation);
    for (int row = 0; row < SCENE_COUNT; row += 12) {
        EXPECT_REAL(displacement[3 * row], 0.25);
        EXPECT_REAL(displacement[3 * (row + 11) + 2], 1.0);
        EXPECT_REAL(velocity[3 * (row + 11) + 2], 0.5);
    }
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void tables_are_linear_between_their_times(void)
{
    static const double times[] = {0.0, 2.0, 3.0}, values[] = {0.0, 0.5, 0.25};
    static const double expected[] = {0.125, 0.25, 0.375, 0.5, 0.375, 0.25, 0.25, 0.25};
    perion_simulation *simulation = scene_simulation();

    EXPECT_OK(perion_simulation_prescribe_table(simulation, "left", PERION_QUANTITY_DISPLACEMENT, 1, 3,
                                                times, values));
    for (int step = 0; step < 8; ++step) {
        EXPECT_OK(perion_simulation_step(simulation, 0.5, 1));
        read_motion(simulation);
        EXPECT_REAL(displacement[1], expected[step]);
    }
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* What a function was asked. */
typedef struct asked {
    double times[16];
    int calls;
    int64_t count;
    double first_places[SCENE_LAYER * 3];
} asked;

static int ramp(void *user, double time, int64_t count, const double *reference_positions,
                double *values)
{
    asked *notes = user;

    notes->times[notes->calls++ % 16] = time;
    notes->count = count;
    memcpy(notes->first_places, reference_positions, 3 * (size_t)count * sizeof(double));
    for (int64_t k = 0; k < count; ++k)
        values[k] = time * reference_positions[3 * k + 1];
    return 0;
}

static void functions_are_asked_along_time(perion_quantity quantity, int calls, const double *times)
{
    asked notes = {{0.0}, 0, 0, {0.0}};
    perion_simulation *simulation = scene_simulation();

    EXPECT_OK(perion_simulation_set_time(simulation, 1.0));
    EXPECT_OK(perion_simulation_prescribe_function(simulation, "left", quantity, 0, ramp, &notes));
    EXPECT_OK(perion_simulation_step(simulation, 0.5, 2));
    EXPECT_INT(notes.calls, calls);
    for (int k = 0; k < calls; ++k)
        EXPECT_REAL(notes.times[k], times[k]);
    EXPECT_INT(notes.count, SCENE_LAYER);
    for (int k = 0; k < SCENE_LAYER; ++k) {
        EXPECT_REAL(notes.first_places[3 * k], 0.5);
        EXPECT_REAL(notes.first_places[3 * k + 1], 0.5 + k % 8);
        EXPECT_REAL(notes.first_places[3 * k + 2], 0.5 + k / 8);
    }
    read_motion(simulation);
    if (quantity == PERION_QUANTITY_DISPLACEMENT)
        EXPECT_REAL(displacement[3 * 12], 2.0 * 1.5);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void functions_are_asked_once_for_each_time(void)
{
    static const double ends[] = {1.5, 2.0}, middles[] = {1.25, 1.5, 1.75, 2.0};
    static const double loads[] = {1.0, 1.5, 2.0};

    functions_are_asked_along_time(PERION_QUANTITY_DISPLACEMENT, 2, ends);
    functions_are_asked_along_time(PERION_QUANTITY_VELOCITY, 4, middles);
    functions_are_asked_along_time(PERION_QUANTITY_BODY_FORCE, 3, loads);
}

static void values_follow_the_order_of_the_set(void)
{
    double values[SCENE_LAYER];
    perion_simulation *simulation = scene_simulation();

    for (int k = 0; k < SCENE_LAYER; ++k)
        values[k] = 0.001953125 * k;
    EXPECT_OK(perion_simulation_prescribe_values(simulation, "right", PERION_QUANTITY_DISPLACEMENT, 0,
                                                 SCENE_LAYER, values));
    memset(values, 0, sizeof values);
    EXPECT_OK(perion_simulation_step(simulation, 0.5, 2));
    read_motion(simulation);
    for (int k = 0; k < SCENE_LAYER; ++k)
        EXPECT_REAL(displacement[3 * (12 * k + 11)], 0.001953125 * k);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static double body_force_on_the_first_point(perion_simulation *simulation)
{
    double force[SCENE_LENGTH];

    EXPECT_OK(perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_BODY_FORCE, force, SCENE_LENGTH));
    return force[2];
}

static void body_forces_add_and_are_released(void)
{
    perion_simulation *simulation = scene_simulation();

    EXPECT_OK(perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_BODY_FORCE, 2, 1.0));
    EXPECT_OK(perion_simulation_prescribe(simulation, "all", PERION_QUANTITY_BODY_FORCE, 2, 4.0));
    EXPECT_REAL(body_force_on_the_first_point(simulation), 5.0);
    EXPECT_OK(perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_BODY_FORCE, 2, 2.0));
    EXPECT_REAL(body_force_on_the_first_point(simulation), 6.0);
    EXPECT_OK(perion_simulation_release(simulation, "all", PERION_QUANTITY_BODY_FORCE, 2));
    EXPECT_REAL(body_force_on_the_first_point(simulation), 2.0);
    EXPECT_OK(perion_simulation_release(simulation, "left", PERION_QUANTITY_BODY_FORCE, 2));
    EXPECT_REAL(body_force_on_the_first_point(simulation), 0.0);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void the_last_motion_wins(void)
{
    perion_simulation *simulation = scene_simulation();

    EXPECT_OK(perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_DISPLACEMENT, 0, 1.0));
    EXPECT_OK(perion_simulation_prescribe(simulation, "all", PERION_QUANTITY_VELOCITY, 0, 0.25));
    EXPECT_REFUSED(PERION_ERROR_ARGUMENT, "set",
                   perion_simulation_release(simulation, "left", PERION_QUANTITY_DISPLACEMENT, 0));
    EXPECT_OK(perion_simulation_step(simulation, 0.5, 1));
    read_motion(simulation);
    EXPECT_REAL(displacement[0], 0.125);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

int main(void)
{
    harness_begin();
    constants_hold_their_sets();
    tables_are_linear_between_their_times();
    functions_are_asked_once_for_each_time();
    values_follow_the_order_of_the_set();
    body_forces_add_and_are_released();
    the_last_motion_wins();
    return harness_end();
}
