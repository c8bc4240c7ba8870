/* Want of memory is a status: the process lives, and objects are as they were and can be used. */
#define _DEFAULT_SOURCE
#include "harness.h"
#include "scene.h"

#include <malloc.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static const rlim_t MEGABYTE = 1 << 20;

/* Lets the process have so many bytes more than it has; all it can get when negative. */
static void allow(long long bytes)
{
    struct rlimit limit;
    long long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");

    EXPECT(file != NULL && fscanf(file, "%lld", &pages) == 1);
    if (file != NULL)
        fclose(file);
    getrlimit(RLIMIT_AS, &limit);
    limit.rlim_cur = limit.rlim_max;
    if (bytes >= 0)
        limit.rlim_cur = (rlim_t)(pages * sysconf(_SC_PAGESIZE) + bytes);
    EXPECT_INT(setrlimit(RLIMIT_AS, &limit), 0);
}

/* The stack grows into the address space, too: let it have grown before any limit. */
static void use_stack(void)
{
    volatile char room[1 << 20];

    memset((char *)room, 1, sizeof room);
    EXPECT_INT(room[sizeof room / 2], 1);
}

static perion_status block(int64_t edge, perion_points **points)
{
    const double lower[] = {0.0, 0.0, 0.0};
    const double upper[] = {(double)edge, (double)edge, (double)edge};

    return perion_points_create_block(3, lower, upper, 1.0, points);
}

static void a_block_that_does_not_fit_is_refused(void)
{
    static const int64_t edges[] = {100, 200, 500, 1000, 1600};
    perion_points *points;
    int64_t count = 0;

    for (size_t k = 0; k < sizeof edges / sizeof edges[0]; ++k) {
        SEAL(points);
        allow(32 * (long long)MEGABYTE);
        EXPECT_STATUS(PERION_ERROR_MEMORY, block(edges[k], &points));
        EXPECT_SAID("perion_points_create_block: out of memory");
        EXPECT_SEALED(points);
    }
    EXPECT_OK(block(20, &points));
    EXPECT_OK(perion_points_count(points, &count));
    EXPECT_INT(count, 8000);
    EXPECT_OK(perion_points_destroy(&points));
    allow(-1);
}

static void a_simulation_that_does_not_fit_is_refused(void)
{
    perion_points *points = NULL;
    perion_model *model = scene_model();
    perion_simulation *simulation;
    int64_t count = 0;

    EXPECT_OK(block(80, &points));
    SEAL(simulation);
    allow(24 * (long long)MEGABYTE);
    EXPECT_REFUSED(PERION_ERROR_MEMORY, "bytes", perion_simulation_create(points, model, &simulation));
    EXPECT_SEALED(simulation);
    EXPECT_OK(perion_points_count(points, &count));
    EXPECT_INT(count, 512000);
    allow(-1);
    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_points_destroy(&points));
}

/* Families that do not fit: each call that needs them says so, and with more memory each works. */
static void families_that_do_not_fit_are_built_later(void)
{
    static double velocity[3 * 64000];
    perion_points *points = NULL;
    perion_model *model = scene_model();
    perion_simulation *simulation = NULL;
    double stable = -1.0;
    int64_t steps = -1;
    perion_energy energy;

    perion_energy_init(&energy, sizeof(perion_energy));
    EXPECT_OK(block(40, &points));
    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    EXPECT_OK(perion_simulation_set_threads(simulation, 2));
    allow(4 * (long long)MEGABYTE);
    EXPECT_REFUSED(PERION_ERROR_MEMORY, "bytes", perion_simulation_step(simulation, 0.5, 1));
    EXPECT_REFUSED(PERION_ERROR_MEMORY, "bytes",
                   perion_simulation_stable_time_step(simulation, &stable));
    EXPECT_REFUSED(PERION_ERROR_MEMORY, "bytes", perion_simulation_energy(simulation, &energy));
    EXPECT_REAL(stable, -1.0);
    EXPECT_OK(perion_simulation_step_count(simulation, &steps));
    EXPECT_INT(steps, 0);
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, velocity, 3 * 64000));
    allow(-1);
    EXPECT_OK(perion_simulation_step(simulation, 0.5, 2));
    EXPECT_OK(perion_simulation_energy(simulation, &energy));
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_points_destroy(&points));
}

/* Memory that is freed goes back at once, and threads set none aside, so that limits bite. */
static void keep_no_memory(void)
{
    EXPECT(mallopt(M_ARENA_MAX, 1) == 1);
    EXPECT(mallopt(M_MMAP_THRESHOLD, 1 << 16) == 1);
    EXPECT(mallopt(M_TRIM_THRESHOLD, 1 << 16) == 1);
}

static void note(int *short_of_memory, perion_status status)
{
    *short_of_memory += status == PERION_ERROR_MEMORY;
    /* Threads that could not be started are a matter of state. */
    EXPECT(status == PERION_OK || status == PERION_ERROR_MEMORY || status == PERION_ERROR_STATE
           || status == PERION_ERROR_NULL);
}

/* A life within so many bytes; gives how often they were too few. */
static int live_within(long long bytes)
{
    static double values[3 * 8000];
    static const int64_t pair[] = {0, 1};
    static const double half = 0.5;
    perion_points *points = NULL;
    perion_model *model = scene_model();
    perion_simulation *simulation = NULL;
    double stable;
    int short_of_memory = 0;

    allow(bytes);
    note(&short_of_memory, block(20, &points));
    note(&short_of_memory, perion_simulation_create(points, model, &simulation));
    note(&short_of_memory, perion_simulation_set_threads(simulation, 2));
    note(&short_of_memory, perion_simulation_prescribe(simulation, "all", 3, 0, 1e-3));
    note(&short_of_memory, perion_simulation_set_bond_integrity(simulation, 1, pair, &half));
    note(&short_of_memory, perion_simulation_stable_time_step(simulation, &stable));
    note(&short_of_memory, perion_simulation_step(simulation, 0.5, 2));
    note(&short_of_memory, perion_simulation_break_bonds(simulation, 1, pair));
    note(&short_of_memory, perion_simulation_get(simulation, 8, values, 3 * 8000));
    note(&short_of_memory, perion_simulation_get(simulation, 12, values, 8000));
    note(&short_of_memory, perion_simulation_commit(simulation, 0.5));
    note(&short_of_memory, perion_simulation_evaluate(simulation));
    allow(-1);
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT_OK(perion_points_destroy(&points));
    EXPECT_OK(perion_model_destroy(&model));
    return short_of_memory;
}

/* Limits all the way from too little for anything to enough for all. */
static void wherever_memory_ends_the_process_lives(void)
{
    int short_of_memory = 0, enough = 0;

    for (int k = 1; k <= 200; ++k) {
        int refused = live_within(k * (long long)MEGABYTE / 16);
        short_of_memory += refused > 0;
        enough += refused == 0;
    }
    EXPECT(short_of_memory > 30);
    EXPECT(enough > 30);
}

int main(void)
{
    harness_begin();
    use_stack();
    keep_no_memory();
    a_block_that_does_not_fit_is_refused();
    a_simulation_that_does_not_fit_is_refused();
    families_that_do_not_fit_are_built_later();
    wherever_memory_ends_the_process_lives();
    return harness_end();
}
