/* Driving: steps and what the host hears of them, hosts that step themselves, energy and health. */
#include "harness.h"
#include "scene.h"

#include <string.h>

static void a_free_body_flies_straight(void)
{
    static double velocity[SCENE_LENGTH], displacement[SCENE_LENGTH];
    perion_simulation *simulation = scene_simulation();
    double time = 0.0;
    int64_t steps = 0;

    for (int k = 0; k < SCENE_LENGTH; ++k)
        velocity[k] = k % 3 == 0 ? 0.5 : 0.0;
    EXPECT_OK(perion_simulation_set(simulation, PERION_FIELD_VELOCITY, velocity, SCENE_LENGTH));
    EXPECT_OK(perion_simulation_step(simulation, 0.5, 8));
    EXPECT_OK(perion_simulation_time(simulation, &time));
    EXPECT_OK(perion_simulation_step_count(simulation, &steps));
    EXPECT_REAL(time, 4.0);
    EXPECT_INT(steps, 8);
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, displacement, SCENE_LENGTH));
    for (int k = 0; k < SCENE_LENGTH; ++k)
        EXPECT_REAL(displacement[k], k % 3 == 0 ? 2.0 : 0.0);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* What a progress callback has heard. */
typedef struct heard {
    int64_t done, total;
    double time;
    int calls;
    /* Asks to stop at this call, if it is not 0. */
    int stop;
} heard;

static int listen(void *user, int64_t done, int64_t total, double time)
{
    heard *notes = user;

    notes->done = done;
    notes->total = total;
    notes->time = time;
    return ++notes->calls == notes->stop;
}

static void progress_is_told_after_each_step(void)
{
    heard notes = {0, 0, 0.0, 0, 0};
    perion_simulation *watched = scene_simulation(), *alone = scene_simulation();
    scene_state result;

    scene_throw(watched);
    scene_throw(alone);
    EXPECT_OK(perion_simulation_set_progress(watched, listen, &notes));
    EXPECT_OK(perion_simulation_step(watched, 0.5, 6));
    EXPECT_INT(notes.calls, 6);
    EXPECT_INT(notes.done, 6);
    EXPECT_INT(notes.total, 6);
    EXPECT_REAL(notes.time, 3.0);
    EXPECT_OK(perion_simulation_set_progress(watched, NULL, NULL));
    EXPECT_OK(perion_simulation_step(watched, 0.5, 6));
    EXPECT_INT(notes.calls, 6);
    EXPECT_OK(perion_simulation_step(alone, 0.5, 12));
    result = scene_result_of(alone);
    EXPECT(scene_is(&result, scene_result_of(watched)));
    scene_state_free(&result);
    EXPECT_OK(perion_simulation_destroy(&watched));
    EXPECT_OK(perion_simulation_destroy(&alone));
}

/* The last message of a log. */
typedef struct noted {
    perion_log_level level;
    char text[256];
    int calls;
} noted;

static void note(void *user, perion_log_level level, const char *message)
{
    noted *notes = user;

    notes->level = level;
    strncpy(notes->text, message, sizeof notes->text - 1);
    ++notes->calls;
}

static void a_step_beyond_the_stable_one_is_warned_of(void)
{
    noted notes = {0, {0}, 0};
    perion_simulation *simulation = scene_simulation();
    perion_health health;
    double stable = 0.0;

    perion_health_init(&health, sizeof(perion_health));
    EXPECT_OK(perion_simulation_set_log(simulation, note, &notes));
    EXPECT_OK(perion_simulation_stable_time_step(simulation, &stable));
    EXPECT(stable > scene_time_step);
    EXPECT_OK(perion_simulation_step(simulation, stable, 1));
    EXPECT_INT(notes.calls, 0);
    EXPECT_OK(perion_simulation_step(simulation, 2.0 * stable, 1));
    EXPECT_INT(notes.calls, 1);
    EXPECT_INT(notes.level, PERION_LOG_LEVEL_WARNING);
    EXPECT(strstr(notes.text, "time step") != NULL);
    EXPECT_OK(perion_simulation_health(simulation, &health));
    EXPECT_REAL(health.time_step_ratio, 2.0);
    EXPECT_OK(perion_simulation_set_log(simulation, NULL, NULL));
    EXPECT_OK(perion_simulation_step(simulation, 2.0 * stable, 1));
    EXPECT_INT(notes.calls, 1);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void a_run_lands_on_its_time(void)
{
    heard notes = {0, 0, 0.0, 0, 0};
    perion_simulation *simulation = scene_simulation();
    perion_advance_options options;
    perion_health health;
    perion_report report;
    double stable = 0.0, time = 0.0;

    scene_throw(simulation);
    perion_health_init(&health, sizeof(perion_health));
    perion_report_init(&report, sizeof(perion_report));
    perion_advance_options_init(&options, sizeof(perion_advance_options));
    EXPECT_OK(perion_simulation_stable_time_step(simulation, &stable));
    EXPECT_OK(perion_simulation_set_progress(simulation, listen, &notes));
    EXPECT_OK(perion_simulation_advance(simulation, 3.3 * stable, NULL, &report));
    EXPECT_OK(perion_simulation_time(simulation, &time));
    EXPECT_REAL(time, 3.3 * stable);
    EXPECT_REAL(report.time, time);
    EXPECT_INT(report.steps, notes.calls);
    EXPECT_INT(notes.done, notes.total);
    EXPECT(report.steps >= 5 && report.largest_time_step <= 0.8 * report.stable_time_step);
    EXPECT(report.smallest_time_step > 0.0 && report.stable_time_step > 0.0);
    EXPECT_OK(perion_simulation_health(simulation, &health));
    EXPECT(health.time_step_ratio > 0.6 && health.time_step_ratio <= 0.8);
    EXPECT_REAL(health.stable_time_step, report.stable_time_step);
    EXPECT_INT(health.stable_step_is_guaranteed, 1);
    options.safety = 1.0;
    options.largest_time_step = 0.125 * stable;
    EXPECT_OK(perion_simulation_advance(simulation, 4.3 * stable, &options, &report));
    EXPECT(report.steps >= 8 && report.steps <= 9 && report.largest_time_step <= 0.125 * stable);
    /* Stopped on its way, it tells how far it came. */
    notes.stop = 2;
    notes.calls = 0;
    EXPECT_REFUSED(PERION_ERROR_INTERRUPTED, "progress", perion_simulation_advance(simulation, 9.0 * stable, NULL, &report));
    EXPECT_INT(report.steps, 2);
    EXPECT_OK(perion_simulation_time(simulation, &time));
    EXPECT_REAL(report.time, time);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* v += dt/2 b/rho, u += dt v, commit, v += dt/2 b/rho; the density of the scene is 1. */
static void a_host_can_step_itself(void)
{
    static double u[SCENE_LENGTH], v[SCENE_LENGTH], b[SCENE_LENGTH], wanted[SCENE_LENGTH];
    perion_simulation *own = scene_simulation(), *library = scene_simulation();
    double most = 0.0, time = 0.0;

    scene_throw(own);
    scene_throw(library);
    EXPECT_OK(perion_simulation_get(own, PERION_FIELD_VELOCITY, v, SCENE_LENGTH));
    EXPECT_OK(perion_simulation_evaluate(own));
    EXPECT_OK(perion_simulation_get(own, PERION_FIELD_INTERNAL_FORCE, b, SCENE_LENGTH));
    for (int step = 0; step < 12; ++step) {
        for (int k = 0; k < SCENE_LENGTH; ++k) {
            v[k] += 0.5 * scene_time_step * b[k];
            u[k] += scene_time_step * v[k];
        }
        EXPECT_OK(perion_simulation_set(own, PERION_FIELD_DISPLACEMENT, u, SCENE_LENGTH));
        EXPECT_OK(perion_simulation_commit(own, scene_time_step));
        EXPECT_OK(perion_simulation_evaluate(own));
        EXPECT_OK(perion_simulation_get(own, PERION_FIELD_INTERNAL_FORCE, b, SCENE_LENGTH));
        for (int k = 0; k < SCENE_LENGTH; ++k)
            v[k] += 0.5 * scene_time_step * b[k];
    }
    EXPECT_OK(perion_simulation_step(library, scene_time_step, 12));
    EXPECT_OK(perion_simulation_get(library, PERION_FIELD_DISPLACEMENT, wanted, SCENE_LENGTH));
    for (int k = 0; k < SCENE_LENGTH; ++k)
        most = most > u[k] - wanted[k] ? most : u[k] - wanted[k];
    /* The same sums in the same order: a few roundings of displacements of about 1/2 apart. */
    EXPECT_NEAR(most, 0.0, 1e-14);
    EXPECT_OK(perion_simulation_commit(own, 0.0));
    EXPECT_OK(perion_simulation_time(own, &time));
    EXPECT_REAL(time, 12 * scene_time_step);
    EXPECT_OK(perion_simulation_destroy(&own));
    EXPECT_OK(perion_simulation_destroy(&library));
}

static void energy_is_accounted_for(void)
{
    perion_simulation *simulation = scene_simulation();
    perion_energy start, end;
    perion_health health;

    perion_energy_init(&start, sizeof(perion_energy));
    perion_energy_init(&end, sizeof(perion_energy));
    perion_health_init(&health, sizeof(perion_health));
    scene_throw(simulation);
    EXPECT_OK(perion_simulation_energy(simulation, &start));
    EXPECT(start.kinetic > 0.0);
    EXPECT_REAL(start.elastic, 0.0);
    EXPECT_OK(perion_simulation_step(simulation, 0.125, 64));
    EXPECT_OK(perion_simulation_energy(simulation, &end));
    EXPECT_OK(perion_simulation_health(simulation, &health));
    EXPECT(end.dissipated > 0.0 && health.broken_bonds > 0 && end.elastic > 0.0);
    EXPECT_INT(health.isolated_points, 0);
    EXPECT_INT(health.first_isolated_point, -1);
    /* Velocity Verlet at a quarter of the stable step loses a few parts in a thousand in breaking. */
    EXPECT_NEAR(end.closure_error, 0.0, 0.02 * start.kinetic);
    EXPECT_NEAR(end.kinetic + end.elastic + end.dissipated, start.kinetic, 0.02 * start.kinetic);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void memory_grows_when_set_up_ends(void)
{
    perion_simulation *simulation = scene_simulation();
    perion_memory before, after;

    perion_memory_init(&before, sizeof(perion_memory));
    perion_memory_init(&after, sizeof(perion_memory));
    EXPECT_OK(perion_simulation_memory(simulation, &before));
    EXPECT_INT(before.bonds, 0);
    EXPECT_OK(perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_memory(simulation, &after));
    EXPECT(after.bonds > 0 && after.total > before.total);
    EXPECT_INT(after.total, after.points + after.bonds + after.state);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* A host of an older header gets what it knows of: here kinetic and elastic energy, no more. */
static void an_older_struct_is_filled_as_far_as_it_goes(void)
{
    perion_simulation *simulation = scene_simulation();
    perion_energy energy;

    perion_energy_init(&energy, sizeof(perion_energy));
    EXPECT_INT(energy.struct_size, sizeof energy);
    SEAL(energy.dissipated);
    SEAL(energy.external_work);
    energy.struct_size = (int64_t)offsetof(perion_energy, dissipated);
    scene_throw(simulation);
    EXPECT_OK(perion_simulation_energy(simulation, &energy));
    EXPECT(energy.kinetic > 0.0);
    EXPECT_REAL(energy.elastic, 0.0);
    EXPECT_SEALED(energy.dissipated);
    EXPECT_SEALED(energy.external_work);
    perion_energy_init(NULL, sizeof(perion_energy));
    perion_health_init(NULL, sizeof(perion_health));
    perion_memory_init(NULL, sizeof(perion_memory));
    perion_view_init(NULL, sizeof(perion_view));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

int main(void)
{
    harness_begin();
    a_free_body_flies_straight();
    progress_is_told_after_each_step();
    a_step_beyond_the_stable_one_is_warned_of();
    a_run_lands_on_its_time();
    a_host_can_step_itself();
    energy_is_accounted_for();
    memory_grows_when_set_up_ends();
    an_older_struct_is_filled_as_far_as_it_goes();
    return harness_end();
}
