/* Bad inputs to driving, results and files. */
#include "bad.h"

#define state_of scene_state_of

static void steps_are_of_a_sensible_size(perion_simulation *simulation)
{
    static const double bad[] = {0.0, -0.0, -0.5, NAN, INFINITY, -INFINITY, 1e30, 1e300, -1e-300};
    double stable = 0.0;
    scene_state state;

    EXPECT_OK(perion_simulation_stable_time_step(simulation, &stable));
    state = state_of(simulation);
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; ++k) {
        REFUSE(ARGUMENT, "time_step", perion_simulation_step(simulation, bad[k], 1));
        REFUSE(ARGUMENT, "time_step", perion_simulation_step(simulation, bad[k], 0));
    }
    REFUSE(ARGUMENT, "at most 10 times", perion_simulation_step(simulation, 10.001 * stable, 1));
    REFUSE(ARGUMENT, "steps", perion_simulation_step(simulation, scene_time_step, -1));
    REFUSE(ARGUMENT, "steps", perion_simulation_step(simulation, scene_time_step, INT64_MIN));
    REFUSE(NULLED, "simulation", perion_simulation_step(NULL, scene_time_step, 1));
    REFUSE(ARGUMENT, "simulation",
           perion_simulation_step(NO_HANDLE(perion_simulation), scene_time_step, 1));
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 0));
    EXPECT(scene_is(&state, state_of(simulation)));
    scene_state_free(&state);
}

static void a_run_to_a_time_is_of_sensible_options(perion_simulation *simulation)
{
    static const double late[] = {NAN, INFINITY, -INFINITY, -1.0};
    static const double shares[] = {-0.1, 1.000001, NAN, INFINITY, -INFINITY};
    static const double lengths[] = {-1.0, -1e-300, NAN, -INFINITY};
    static const int64_t counts[] = {-1, INT64_MIN};
    perion_advance_options options;
    perion_report report;
    double time, until;
    scene_state state;

    EXPECT_OK(perion_simulation_time(simulation, &time));
    until = time + scene_time_step;
    state = state_of(simulation);
    SEAL(report);
    report.struct_size = sizeof report;
    for (int k = 0; k < 4; ++k)
        REFUSE(ARGUMENT, "until", perion_simulation_advance(simulation, time + late[k], NULL, &report));
    for (int k = 0; k < 5; ++k) {
        perion_advance_options_init(&options, sizeof(perion_advance_options));
        options.safety = shares[k];
        REFUSE(ARGUMENT, "safety", perion_simulation_advance(simulation, until, &options, &report));
    }
    for (int k = 0; k < 4; ++k) {
        perion_advance_options_init(&options, sizeof(perion_advance_options));
        options.largest_time_step = lengths[k];
        REFUSE(ARGUMENT, "largest_time_step",
               perion_simulation_advance(simulation, until, &options, &report));
    }
    for (int k = 0; k < 2; ++k) {
        perion_advance_options_init(&options, sizeof(perion_advance_options));
        options.interval = counts[k];
        REFUSE(ARGUMENT, "interval", perion_simulation_advance(simulation, until, &options, &report));
    }
    options.struct_size = 0;
    REFUSE(ARGUMENT, "struct_size of 'advance_options'",
           perion_simulation_advance(simulation, until, &options, &report));
    EXPECT_SEALED(report.steps);
    report.struct_size = 7;
    REFUSE(ARGUMENT, "struct_size of 'report'",
           perion_simulation_advance(simulation, until, NULL, &report));
    REFUSE(NULLED, "simulation", perion_simulation_advance(NULL, until, NULL, NULL));
    REFUSE(ARGUMENT, "report",
           perion_simulation_advance(simulation, until, NULL, MISALIGNED(perion_report)));
    EXPECT_OK(perion_simulation_advance(simulation, time, NULL, NULL));
    EXPECT(scene_is(&state, state_of(simulation)));
    scene_state_free(&state);
    perion_advance_options_init(NULL, sizeof(perion_advance_options));
    perion_report_init(NULL, sizeof(perion_report));
}

static void clocks_are_finite(perion_simulation *simulation)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    scene_state state = state_of(simulation);
    double out;
    int64_t count;

    for (int k = 0; k < 3; ++k) {
        REFUSE(ARGUMENT, "time", perion_simulation_set_time(simulation, bad[k]));
        REFUSE(ARGUMENT, "time_step", perion_simulation_commit(simulation, bad[k]));
    }
    REFUSE(ARGUMENT, "time_step", perion_simulation_commit(simulation, -1.0));
    REFUSE(NULLED, "simulation", perion_simulation_commit(NULL, 1.0));
    REFUSE(NULLED, "simulation", perion_simulation_evaluate(NULL));
    REFUSE(NULLED, "simulation", perion_simulation_set_time(NULL, 1.0));
    REFUSE_OUTPUT(out, NULLED, "simulation", perion_simulation_time(NULL, &out));
    REFUSE(NULLED, "time", perion_simulation_time(simulation, NULL));
    REFUSE(ARGUMENT, "time", perion_simulation_time(simulation, MISALIGNED(double)));
    REFUSE_OUTPUT(count, NULLED, "simulation", perion_simulation_step_count(NULL, &count));
    REFUSE(NULLED, "count", perion_simulation_step_count(simulation, NULL));
    REFUSE_OUTPUT(out, NULLED, "simulation", perion_simulation_stable_time_step(NULL, &out));
    REFUSE(NULLED, "time_step", perion_simulation_stable_time_step(simulation, NULL));
    REFUSE(ARGUMENT, "time_step",
           perion_simulation_stable_time_step(simulation, MISALIGNED(double)));
    REFUSE(NULLED, "simulation", perion_simulation_set_progress(NULL, NULL, NULL));
    REFUSE(NULLED, "simulation", perion_simulation_set_log(NULL, NULL, NULL));
    scene_state_free(&state);
}

static void a_clock_does_not_run_over(perion_simulation *simulation)
{
    static const double late = 1.7e308;
    scene_state state;

    EXPECT_OK(perion_simulation_set_time(simulation, late));
    EXPECT_OK(perion_simulation_evaluate(simulation));
    state = state_of(simulation);
    REFUSE(ARGUMENT, "time_step", perion_simulation_commit(simulation, late));
    scene_state_free(&state);
    EXPECT_OK(perion_simulation_set_time(simulation, 6.0));
    EXPECT_OK(perion_simulation_evaluate(simulation));
}

static void structs_know_their_size(perion_simulation *simulation)
{
    static const int64_t sizes[] = {0, -1, 7, INT64_MIN, INT64_MAX, 1 << 20};
    perion_energy energy;
    perion_health health;
    perion_memory memory;
    scene_state state = state_of(simulation);

    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; ++k) {
        SEAL(energy);
        SEAL(health);
        SEAL(memory);
        energy.struct_size = health.struct_size = memory.struct_size = sizes[k];
        REFUSE(ARGUMENT, "struct_size of 'energy'", perion_simulation_energy(simulation, &energy));
        REFUSE(ARGUMENT, "struct_size of 'health'", perion_simulation_health(simulation, &health));
        REFUSE(ARGUMENT, "struct_size of 'memory'", perion_simulation_memory(simulation, &memory));
        EXPECT_SEALED(energy.kinetic);
        EXPECT_SEALED(health.isolated_points);
        EXPECT_SEALED(memory.points);
    }
    REFUSE(NULLED, "energy", perion_simulation_energy(simulation, NULL));
    REFUSE(NULLED, "health", perion_simulation_health(simulation, NULL));
    REFUSE(NULLED, "memory", perion_simulation_memory(simulation, NULL));
    REFUSE(ARGUMENT, "energy", perion_simulation_energy(simulation, MISALIGNED(perion_energy)));
    perion_energy_init(&energy, sizeof(perion_energy));
    perion_health_init(&health, sizeof(perion_health));
    perion_memory_init(&memory, sizeof(perion_memory));
    REFUSE(NULLED, "simulation", perion_simulation_energy(NULL, &energy));
    REFUSE(NULLED, "simulation", perion_simulation_health(NULL, &health));
    REFUSE(NULLED, "simulation", perion_simulation_memory(NULL, &memory));
    scene_state_free(&state);
}

static void files_can_be_written_where_they_are_named(perion_simulation *simulation)
{
    static const perion_field good[] = {PERION_FIELD_DAMAGE, PERION_FIELD_VELOCITY};
    static const perion_field twice[] = {PERION_FIELD_DAMAGE, PERION_FIELD_DAMAGE}, wrong[] = {3, 99};
    scene_state state = state_of(simulation);

#define VTK(status, fragment, path, count, fields) \
    REFUSE(status, fragment, perion_simulation_write_vtk(simulation, path, count, fields))
#define SERIES(status, fragment, path, count, fields) \
    REFUSE(status, fragment, perion_simulation_write_series(simulation, path, count, fields))
    VTK(PERION_ERROR_IO, "no/such/directory/a.vtu", "no/such/directory/a.vtu", 2, good);
    VTK(PERION_ERROR_IO, "/proc", "/proc/a.vtu", 2, good);
    VTK(PERION_ERROR_IO, "/", "/tmp", 2, good);
    VTK(NULLED, "path", NULL, 2, good);
    VTK(ARGUMENT, "path", "", 2, good);
    VTK(ARGUMENT, "path", latin1, 2, good);
    VTK(ARGUMENT, "path", endless, 2, good);
    VTK(NULLED, "fields", "bad.vtu", 2, NULL);
    VTK(ARGUMENT, "fields", "bad.vtu", 2, twice);
    VTK(ARGUMENT, "fields", "bad.vtu", 2, wrong);
    VTK(ARGUMENT, "count", "bad.vtu", -1, good);
    VTK(ARGUMENT, "count", "bad.vtu", INT64_MIN, good);
    VTK(ARGUMENT, "count", "bad.vtu", INT64_MAX, good);
    VTK(ARGUMENT, "fields", "bad.vtu", 1, MISALIGNED(perion_field));
    SERIES(PERION_ERROR_IO, "no/such/directory/a", "no/such/directory/a.pvd", 2, good);
    SERIES(NULLED, "pvd_path", NULL, 2, good);
    SERIES(ARGUMENT, "pvd_path", "bad.vtu", 2, good);
    SERIES(ARGUMENT, "pvd_path", "bad", 2, good);
    SERIES(ARGUMENT, "pvd_path", ".pvd", 2, good);
    SERIES(ARGUMENT, "pvd_path", "", 2, good);
    SERIES(ARGUMENT, "pvd_path", latin1, 2, good);
    SERIES(ARGUMENT, "fields", "bad.pvd", 2, twice);
    SERIES(ARGUMENT, "fields", "bad.pvd", 2, wrong);
    SERIES(NULLED, "fields", "bad.pvd", 1, NULL);
    SERIES(ARGUMENT, "count", "bad.pvd", -2, good);
#undef VTK
#undef SERIES
    EXPECT_REFUSED(NULLED, "simulation", perion_simulation_write_vtk(NULL, "bad.vtu", 2, good));
    EXPECT_REFUSED(NULLED, "simulation", perion_simulation_write_series(NULL, "bad.pvd", 2, good));
    scene_state_free(&state);
}

/* A horizon below the spacing is told of by the first call that needs neighbours, and by each again. */
static void a_horizon_reaches_a_neighbour(void)
{
    perion_points *points = scene_points();
    perion_model *model = scene_model();
    perion_simulation *simulation = NULL;
    double out = -1.0;

    EXPECT_OK(perion_model_set(model, "horizon", 0.9));
    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    for (int k = 0; k < 2; ++k) {
        EXPECT_REFUSED(ARGUMENT, "horizon", perion_simulation_evaluate(simulation));
        EXPECT_REFUSED(ARGUMENT, "horizon", perion_simulation_step(simulation, 0.5, 1));
        EXPECT_REFUSED(ARGUMENT, "horizon", perion_simulation_stable_time_step(simulation, &out));
        EXPECT_REFUSED(ARGUMENT, "horizon",
                       perion_simulation_sum(simulation, PERION_FIELD_DAMAGE, NULL, &out));
    }
    EXPECT_REAL(out, -1.0);
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_points_destroy(&points));
}

/* A motion beyond all numbers stops the run; with the state put right, it goes on as if it had not been. */
static void a_run_that_leaves_the_numbers_can_be_put_right(void)
{
    static double velocity[SCENE_LENGTH], displacement[SCENE_LENGTH];
    perion_simulation *simulation = bad_running(), *other = bad_running();
    perion_energy energy;
    scene_state state;

    perion_energy_init(&energy, sizeof(perion_energy));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, velocity, SCENE_LENGTH));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, displacement, SCENE_LENGTH));
    for (int k = 0; k < 3; ++k) {
        double kept = velocity[30];
        velocity[30] = 1e300;
        EXPECT_OK(perion_simulation_set(simulation, PERION_FIELD_VELOCITY, velocity, SCENE_LENGTH));
        velocity[30] = kept;
        EXPECT_REFUSED(PERION_ERROR_NUMERIC, "is not finite",
                       perion_simulation_step(simulation, scene_time_step, 5));
        EXPECT_OK(perion_simulation_set(simulation, PERION_FIELD_VELOCITY, velocity, SCENE_LENGTH));
    }
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 8));
    EXPECT_OK(perion_simulation_step(other, scene_time_step, 8));
    state = scene_result_of(other);
    EXPECT(scene_is(&state, scene_result_of(simulation)));
    EXPECT_OK(perion_simulation_energy(simulation, &energy));
    EXPECT(isfinite(energy.closure_error));
    scene_state_free(&state);
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT_OK(perion_simulation_destroy(&other));
}

static void only_simulations_are_destroyed_as_simulations(void)
{
    perion_points *points = scene_points();
    perion_simulation *disguised = (perion_simulation *)(void *)points;

    EXPECT_REFUSED(ARGUMENT, "simulation", perion_simulation_destroy(&disguised));
    EXPECT((void *)disguised == (void *)points);
    EXPECT_REFUSED(ARGUMENT, "simulation", perion_simulation_evaluate(disguised));
    EXPECT_OK(perion_points_destroy(&points));
}

void bad_drive(void)
{
    perion_simulation *simulation = bad_running();

    steps_are_of_a_sensible_size(simulation);
    a_run_to_a_time_is_of_sensible_options(simulation);
    clocks_are_finite(simulation);
    a_clock_does_not_run_over(simulation);
    structs_know_their_size(simulation);
    files_can_be_written_where_they_are_named(simulation);
    a_horizon_reaches_a_neighbour();
    a_run_that_leaves_the_numbers_can_be_put_right();
    only_simulations_are_destroyed_as_simulations();
    EXPECT_OK(perion_simulation_destroy(&simulation));
}
