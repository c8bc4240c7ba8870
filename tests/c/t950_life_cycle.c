/*
 * A short life with everything that allocates: run plain and under valgrind. After the end no thread is
 * left. The directory to write to is the first argument.
 */
#define _POSIX_C_SOURCE 200809L
#include "harness.h"
#include "scene.h"

#include <dirent.h>
#include <stdio.h>
#include <time.h>

/* Threads of this process. */
static int tasks(void)
{
    DIR *list = opendir("/proc/self/task");
    int count = 0;

    if (list == NULL)
        return -1;
    for (struct dirent *entry = readdir(list); entry != NULL; entry = readdir(list))
        count += entry->d_name[0] != '.';
    closedir(list);
    return count;
}

/* A thread that has been joined may still stand in the list for a moment. */
static int tasks_become(int wanted)
{
    const struct timespec moment = {0, 1000000};

    for (int k = 0; k < 2000 && tasks() != wanted; ++k)
        nanosleep(&moment, NULL);
    return tasks() == wanted;
}

static int steady(void *user, double time, int64_t count, const double *reference_positions,
                  double *values)
{
    (void)user;
    (void)reference_positions;
    for (int64_t k = 0; k < count; ++k)
        values[k] = 0.001 * time;
    return 0;
}

static int go_on(void *user, int64_t done, int64_t total, double time)
{
    (void)user;
    (void)time;
    return done < total ? 0 : 1;
}

static void ignore(void *user, perion_log_level level, const char *message)
{
    (void)user;
    (void)level;
    (void)message;
}

static void prescribe_everything(perion_simulation *simulation)
{
    static const double times[] = {0.0, 1.0}, values[] = {0.0, 0.01};
    static const double layer[SCENE_LAYER] = {0.0};

    EXPECT_OK(perion_simulation_prescribe_function(simulation, "left", PERION_QUANTITY_VELOCITY, 0,
                                                   steady, NULL));
    EXPECT_OK(perion_simulation_prescribe_table(simulation, "right", PERION_QUANTITY_DISPLACEMENT, 0, 2,
                                                times, values));
    EXPECT_OK(perion_simulation_prescribe_values(simulation, "right", PERION_QUANTITY_BODY_FORCE, 1,
                                                 SCENE_LAYER, layer));
    EXPECT_OK(perion_simulation_prescribe(simulation, "right", PERION_QUANTITY_VELOCITY, 2, 0.0));
    EXPECT_REFUSED(PERION_ERROR_ARGUMENT, "set",
                   perion_simulation_prescribe(simulation, "wrong", PERION_QUANTITY_VELOCITY, 2, 0.0));
    EXPECT_OK(perion_simulation_release(simulation, "right", PERION_QUANTITY_VELOCITY, 2));
}

static void damage_something(perion_simulation *simulation)
{
    static const double crack[] = {6.0, 0.0, 0.0, 6.0, 4.0, 0.0, 6.0, 4.0, 4.0, 6.0, 0.0, 4.0};
    static const int64_t pairs[] = {0, 1, 1, 2};
    static const double half[] = {0.5, 0.5};

    EXPECT_OK(perion_simulation_break_crossing(simulation, 4, crack));
    EXPECT_OK(perion_simulation_break_bonds(simulation, 2, pairs));
    EXPECT_OK(perion_simulation_set_bond_integrity(simulation, 2, pairs, half));
    EXPECT_OK(perion_simulation_forbid_failure(simulation, "left"));
    EXPECT_REFUSED(PERION_ERROR_ARGUMENT, "pairs",
                   perion_simulation_break_bonds(simulation, 1, (int64_t[]){3, 3}));
}

static void borrow_something(perion_simulation *simulation)
{
    perion_view view;

    perion_view_init(&view, sizeof(perion_view));
    EXPECT_OK(perion_simulation_borrow(simulation, PERION_FIELD_BODY_FORCE, &view));
    EXPECT_OK(perion_simulation_return(simulation, &view));
    EXPECT_OK(perion_simulation_borrow_const(simulation, PERION_FIELD_VELOCITY, &view));
}

static void live_once(const char *series)
{
    static const perion_field fields[] = {PERION_FIELD_DAMAGE, PERION_FIELD_VELOCITY};
    perion_simulation *simulation = scene_simulation();
    perion_model *other = scene_model();
    scene_state state;

    EXPECT_OK(perion_simulation_assign_model(simulation, "right", other));
    EXPECT_OK(perion_model_destroy(&other));
    EXPECT_OK(perion_simulation_set_interface(simulation, "left", "right", 1.0));
    EXPECT_OK(perion_simulation_set_log(simulation, ignore, NULL));
    EXPECT_OK(perion_simulation_set_progress(simulation, go_on, NULL));
    damage_something(simulation);
    prescribe_everything(simulation);
    scene_throw(simulation);
    EXPECT_REFUSED(PERION_ERROR_INTERRUPTED, "stop",
                   perion_simulation_step(simulation, scene_time_step, 3));
    damage_something(simulation);
    EXPECT_INT(tasks(), 2);
    EXPECT_OK(perion_simulation_set_threads(simulation, 1));
    EXPECT(tasks_become(1));
    /* 384 points are two blocks to share out: more threads would have nothing to do. */
    EXPECT_OK(perion_simulation_set_threads(simulation, 3));
    EXPECT(tasks_become(2));
    EXPECT_OK(perion_simulation_write_series(simulation, series, 2, fields));
    state = scene_state_of(simulation);
    scene_state_free(&state);
    borrow_something(simulation);
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT(tasks_become(1));
}

int main(int argc, char **argv)
{
    char series[4096];

    harness_begin();
    snprintf(series, sizeof series, "%s/life.pvd", argc > 1 ? argv[1] : ".");
    live_once(series);
    live_once(series);
    return harness_end();
}
