/* Callbacks that stop, fail, call back and change the floating-point environment. */
#include "calls.h"
#include "harness.h"
#include "scene.h"

#include <fenv.h>
#include <math.h>
#include <string.h>

enum { STEPS = 12, STOP = 5 };

/* What a callback is to do, and with what. */
typedef struct order {
    perion_simulation *simulation;
    int calls;
    int stop_at;
    double value;
} order;

/* Makes the steps of the scene from its start, the left end driven by a function. */
static perion_simulation *start(perion_function function, perion_progress progress, order *given)
{
    perion_simulation *simulation = scene_simulation();

    given->simulation = simulation;
    scene_throw(simulation);
    if (function != NULL)
        EXPECT_OK(perion_simulation_prescribe_function(
            simulation, "left", PERION_QUANTITY_DISPLACEMENT, 0, function, given));
    EXPECT_OK(perion_simulation_set_progress(simulation, progress, given));
    return simulation;
}

static int64_t steps_made(const perion_simulation *simulation)
{
    int64_t count = -1;

    EXPECT_OK(perion_simulation_step_count(simulation, &count));
    return count;
}

static int drive(void *user, double time, int64_t count, const double *reference_positions,
                 double *values)
{
    order *given = user;

    (void)reference_positions;
    for (int64_t k = 0; k < count; ++k)
        values[k] = -0.0625 * time;
    if (++given->calls != given->stop_at)
        return 0;
    values[3] = given->value;
    return isnan(given->value) || isinf(given->value) ? 0 : 1;
}

static int watch(void *user, int64_t done, int64_t total, double time)
{
    order *given = user;

    (void)total;
    (void)time;
    ++given->calls;
    return done == given->stop_at ? -1 : 0;
}

/* What an undisturbed run comes to. */
static scene_state undisturbed(perion_function function)
{
    order given = {NULL, 0, 0, 0.0};
    perion_simulation *simulation = start(function, NULL, &given);
    scene_state result;

    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS));
    result = scene_result_of(simulation);
    EXPECT_OK(perion_simulation_destroy(&simulation));
    return result;
}

static void expect_end(perion_simulation *simulation, const scene_state *wanted)
{
    EXPECT_INT(steps_made(simulation), STEPS);
    EXPECT(scene_is(wanted, scene_result_of(simulation)));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void a_run_stopped_by_its_watcher_goes_on(void)
{
    order given = {NULL, 0, STOP, 0.0};
    perion_simulation *simulation = start(NULL, watch, &given);
    scene_state wanted = undisturbed(NULL);

    EXPECT_REFUSED(PERION_ERROR_INTERRUPTED, "step 5 of 12",
                   perion_simulation_step(simulation, scene_time_step, STEPS));
    EXPECT_INT(steps_made(simulation), STOP);
    EXPECT_INT(given.calls, STOP);
    given.stop_at = 0;
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS - STOP));
    expect_end(simulation, &wanted);
    scene_state_free(&wanted);
}

static void a_run_stopped_by_its_function_goes_on(double value, perion_status status)
{
    order given = {NULL, 0, STOP, value};
    perion_simulation *simulation = start(drive, NULL, &given);
    scene_state wanted = undisturbed(drive);

    EXPECT_REFUSED(status, "the function that prescribes the displacement of set 'left', axis 0",
                   perion_simulation_step(simulation, scene_time_step, STEPS));
    EXPECT_INT(steps_made(simulation), STOP - 1);
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS - STOP + 1));
    expect_end(simulation, &wanted);
    scene_state_free(&wanted);
}

static void expect_no_destroy(order *given)
{
    perion_simulation *copy = given->simulation;

    EXPECT_REFUSED(PERION_ERROR_STATE, "simulation", perion_simulation_destroy(&copy));
    EXPECT(copy == given->simulation);
}

static int change_and_look(void *user, int64_t done, int64_t total, double time)
{
    order *given = user;

    (void)done;
    (void)total;
    (void)time;
    expect_of_all(changing_calls, changing_call_count, given->simulation, PERION_ERROR_STATE);
    expect_of_all(looking_calls, looking_call_count, given->simulation, PERION_OK);
    expect_no_destroy(given);
    return 0;
}

static int change_and_look_within_a_step(void *user, double time, int64_t count,
                                         const double *reference_positions, double *values)
{
    order *given = user;
    perion_view view;

    perion_view_init(&view, sizeof(perion_view));
    expect_of_all(changing_calls, changing_call_count, given->simulation, PERION_ERROR_STATE);
    expect_of_all(looking_calls, looking_call_count, given->simulation, PERION_ERROR_STATE);
    EXPECT_REFUSED(PERION_ERROR_STATE, "simulation",
                   perion_simulation_borrow_const(given->simulation, PERION_FIELD_VELOCITY, &view));
    expect_no_destroy(given);
    return drive(user, time, count, reference_positions, values);
}

static void callbacks_cannot_change_what_calls_them(void)
{
    order given = {NULL, 0, 0, 0.0};
    perion_simulation *simulation = start(drive, change_and_look, &given);
    scene_state wanted = undisturbed(drive);

    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS));
    expect_end(simulation, &wanted);
    simulation = start(change_and_look_within_a_step, NULL, &given);
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS));
    expect_end(simulation, &wanted);
    scene_state_free(&wanted);
}

static int upset(void)
{
    fesetround(FE_DOWNWARD);
    feraiseexcept(FE_ALL_EXCEPT);
    return 0;
}

static int upset_after_a_step(void *user, int64_t done, int64_t total, double time)
{
    (void)user;
    (void)done;
    (void)total;
    (void)time;
    return upset();
}

static int upset_within_a_step(void *user, double time, int64_t count,
                               const double *reference_positions, double *values)
{
    fesetround(FE_TONEAREST);
    drive(user, time, count, reference_positions, values);
    return upset();
}

static void what_callbacks_do_to_the_environment_is_theirs(void)
{
    order given = {NULL, 0, 0, 0.0};
    perion_simulation *simulation = start(upset_within_a_step, upset_after_a_step, &given);
    scene_state wanted = undisturbed(drive);

    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS));
    EXPECT_INT(fegetround(), FE_DOWNWARD);
    EXPECT_INT(fetestexcept(FE_ALL_EXCEPT), FE_ALL_EXCEPT);
    fesetenv(FE_DFL_ENV);
    expect_end(simulation, &wanted);
    scene_state_free(&wanted);
}

static int step_another(void *user, int64_t done, int64_t total, double time)
{
    order *given = user;

    (void)done;
    (void)total;
    (void)time;
    EXPECT_OK(perion_simulation_step(given->simulation, scene_time_step, 1));
    return 0;
}

static void a_callback_may_step_another_simulation(void)
{
    order given = {NULL, 0, 0, 0.0}, nested = {NULL, 0, 0, 0.0};
    perion_simulation *other = start(drive, watch, &nested);
    perion_simulation *simulation = start(drive, step_another, &given);
    scene_state wanted = undisturbed(drive);

    given.simulation = other;
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS));
    expect_end(simulation, &wanted);
    expect_end(other, &wanted);
    scene_state_free(&wanted);
}

static perion_view kept;

static int keep_a_view(void *user, int64_t done, int64_t total, double time)
{
    order *given = user;

    (void)total;
    (void)time;
    if (done == STOP)
        EXPECT_OK(perion_simulation_borrow_const(given->simulation, PERION_FIELD_DISPLACEMENT, &kept));
    return 0;
}

/* What is on loan does not change until it is returned: the run ends where the view was lent. */
static void a_view_lent_to_a_callback_ends_the_run(void)
{
    order given = {NULL, 0, 0, 0.0};
    perion_simulation *simulation = start(NULL, keep_a_view, &given);
    scene_state wanted = undisturbed(NULL);

    perion_view_init(&kept, sizeof(perion_view));
    EXPECT_REFUSED(PERION_ERROR_STATE, "view",
                   perion_simulation_step(simulation, scene_time_step, STEPS));
    EXPECT_INT(steps_made(simulation), STOP);
    EXPECT_OK(perion_simulation_return(simulation, &kept));
    EXPECT_OK(perion_simulation_set_progress(simulation, NULL, NULL));
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS - steps_made(simulation)));
    expect_end(simulation, &wanted);
    scene_state_free(&wanted);
}

static void complain(void *user, perion_log_level level, const char *message)
{
    order *given = user;

    (void)level;
    EXPECT(strlen(message) > 0);
    expect_of_all(changing_calls, changing_call_count, given->simulation, PERION_ERROR_STATE);
    expect_of_all(looking_calls, looking_call_count, given->simulation, PERION_ERROR_STATE);
    expect_no_destroy(given);
    ++given->calls;
}

/* A log that is told of a large step comes to nothing with what it calls. */
static void a_log_cannot_call_the_simulation_that_tells_it(void)
{
    order given = {NULL, 0, 0, 0.0};
    perion_simulation *simulation = start(NULL, NULL, &given);
    double stable = 0.0;

    EXPECT_OK(perion_simulation_stable_time_step(simulation, &stable));
    EXPECT_OK(perion_simulation_set_log(simulation, complain, &given));
    EXPECT_OK(perion_simulation_step(simulation, 1.25 * stable, 1));
    EXPECT_INT(given.calls, 1);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

int main(void)
{
    harness_begin();
    a_run_stopped_by_its_watcher_goes_on();
    a_run_stopped_by_its_function_goes_on(0.0, PERION_ERROR_INTERRUPTED);
    a_run_stopped_by_its_function_goes_on(NAN, PERION_ERROR_NUMERIC);
    a_run_stopped_by_its_function_goes_on(-INFINITY, PERION_ERROR_NUMERIC);
    callbacks_cannot_change_what_calls_them();
    what_callbacks_do_to_the_environment_is_theirs();
    a_callback_may_step_another_simulation();
    a_view_lent_to_a_callback_ends_the_run();
    a_log_cannot_call_the_simulation_that_tells_it();
    return harness_end();
}
