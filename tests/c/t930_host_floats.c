/*
 * A host with an unusual floating-point environment: traps for division by zero, invalid operations and
 * overflow, rounding upward, subnormal numbers flushed to zero, the inexact flag up. No call fires a
 * trap, results have the bits of the default environment, and each call leaves the environment as it was.
 */
#define _GNU_SOURCE
#include "harness.h"
#include "scene.h"

#include <fenv.h>
#include <math.h>

static const int traps = FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW;

/* Modes and sticky flags. */
typedef struct environment {
    unsigned vector;
    unsigned short control, status;
    int rounding, flags, traps;
} environment;

static environment environment_now(void)
{
    environment now = {0, 0, 0, fegetround(), fetestexcept(FE_ALL_EXCEPT), fegetexcept()};

#ifdef __x86_64__
    now.vector = __builtin_ia32_stmxcsr();
    __asm__ volatile("fnstcw %0" : "=m"(now.control));
    __asm__ volatile("fnstsw %0" : "=m"(now.status));
#endif
    return now;
}

static int same_environment(const environment *a, const environment *b)
{
    return a->vector == b->vector && a->control == b->control && a->status == b->status
           && a->rounding == b->rounding && a->flags == b->flags && a->traps == b->traps;
}

static void make_hostile(void)
{
    feclearexcept(FE_ALL_EXCEPT);
    feenableexcept(traps);
    fesetround(FE_UPWARD);
#ifdef __x86_64__
    __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x8040u | 0x20u);
#endif
}

/* A call that succeeds and leaves the environment alone. */
#define KEEPS(call)                                    \
    do {                                               \
        environment before = environment_now(), after; \
        perion_status status = (call);                 \
        after = environment_now();                     \
        EXPECT(same_environment(&before, &after));     \
        EXPECT_OK(status);                             \
    } while (0)

/* What callbacks are to find. */
typedef struct expected {
    environment host;
    int calls;
    const perion_simulation *simulation;
} expected;

static int drive(void *user, double time, int64_t count, const double *reference_positions,
                 double *values)
{
    static const double speeds[] = {0.0625, 0.03125};
    expected *own = user;
    environment now = environment_now();

    (void)time;
    (void)reference_positions;
    EXPECT(same_environment(&own->host, &now));
    ++own->calls;
    for (int64_t k = 0; k < count; ++k)
        values[k] = speeds[k % 2];
    return 0;
}

static int watch(void *user, int64_t done, int64_t total, double time)
{
    expected *own = user;
    environment now = environment_now();
    double energy[SCENE_COUNT];

    (void)done;
    (void)total;
    (void)time;
    EXPECT(same_environment(&own->host, &now));
    KEEPS(perion_simulation_get(own->simulation, PERION_FIELD_STRAIN_ENERGY_DENSITY, energy,
                                SCENE_COUNT));
    return 0;
}

static void note(void *user, perion_log_level level, const char *message)
{
    expected *own = user;
    environment now = environment_now();

    (void)level;
    (void)message;
    EXPECT(same_environment(&own->host, &now));
}

static void set_up(perion_simulation *simulation, expected *own)
{
    static const double times[] = {0.0, 3.0, 7.0}, values[] = {0.0, 0.1, 0.3};
    static const double crack[] = {6.1, -1.0, 1.3, 6.3, 3.1, 1.3, 6.2, 3.0, 2.9};
    static const int64_t pairs[] = {0, 1, 1, 2};
    static const double integrity[] = {0.3, 1e-310};

    KEEPS(perion_simulation_break_crossing(simulation, 3, crack));
    KEEPS(perion_simulation_set_bond_integrity(simulation, 2, pairs, integrity));
    KEEPS(perion_simulation_prescribe_table(simulation, "right", PERION_QUANTITY_DISPLACEMENT, 1, 3,
                                            times, values));
    KEEPS(perion_simulation_prescribe_function(simulation, "left", PERION_QUANTITY_VELOCITY, 2, drive,
                                               own));
    KEEPS(perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_BODY_FORCE, 1, 1e-310));
    KEEPS(perion_simulation_set_progress(simulation, watch, own));
    KEEPS(perion_simulation_set_log(simulation, note, own));
}

static void look_at_everything(perion_simulation *simulation)
{
    static double values[SCENE_ROOM];
    static const perion_field some[] = {PERION_FIELD_DAMAGE, PERION_FIELD_TIME_STEP_ESTIMATE};
    perion_energy energy;
    perion_health health;
    perion_memory memory;
    perion_view view;
    int64_t count;
    double sum[3];

    perion_energy_init(&energy, sizeof(perion_energy));
    perion_health_init(&health, sizeof(perion_health));
    perion_memory_init(&memory, sizeof(perion_memory));
    perion_view_init(&view, sizeof(perion_view));
    for (int k = 0; k < SCENE_FIELDS; ++k) {
        KEEPS(perion_simulation_get(simulation, scene_fields[k], values, scene_numbers(scene_fields[k])));
    }
    KEEPS(perion_simulation_energy(simulation, &energy));
    KEEPS(perion_simulation_health(simulation, &health));
    EXPECT(health.broken_bonds > 100);
    KEEPS(perion_simulation_memory(simulation, &memory));
    KEEPS(perion_simulation_bond_count(simulation, &count));
    KEEPS(perion_simulation_sum(simulation, PERION_FIELD_REACTION, "left", sum));
    KEEPS(perion_simulation_borrow(simulation, PERION_FIELD_VELOCITY, &view));
    KEEPS(perion_simulation_return(simulation, &view));
    KEEPS(perion_simulation_write_vtk(simulation, "floats.vtu", 2, some));
}

static void fail_on_purpose(perion_simulation *simulation)
{
    static const double bad[] = {NAN};
    environment before = environment_now(), after;

    EXPECT_REFUSED(PERION_ERROR_ARGUMENT, "time_step", perion_simulation_step(simulation, bad[0], 1));
    EXPECT_REFUSED(PERION_ERROR_ARGUMENT, "value",
                   perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_VELOCITY, 0, bad[0]));
    EXPECT_REFUSED(PERION_ERROR_NULL, "simulation", perion_simulation_evaluate(NULL));
    after = environment_now();
    EXPECT(same_environment(&before, &after));
}

/* Points that lie in one place once deformed, infinite forces: all of it inside the library. */
static void overflow_inside(perion_simulation *simulation)
{
    static double speed[SCENE_LENGTH];
    environment before, after;
    perion_status status;

    for (int k = 0; k < SCENE_LENGTH; ++k)
        speed[k] = k % 2 ? 1e300 : -1e300;
    KEEPS(perion_simulation_set(simulation, PERION_FIELD_VELOCITY, speed, SCENE_LENGTH));
    before = environment_now();
    status = perion_simulation_step(simulation, 0.5, 3);
    after = environment_now();
    EXPECT_INT(status, PERION_ERROR_NUMERIC);
    EXPECT(same_environment(&before, &after));
}

static scene_state run(void)
{
    perion_simulation *simulation = scene_simulation();
    expected own = {environment_now(), 0, simulation};
    double stable = 0.0;
    scene_state result;

    scene_throw(simulation);
    set_up(simulation, &own);
    KEEPS(perion_simulation_stable_time_step(simulation, &stable));
    EXPECT(stable > 0.5);
    KEEPS(perion_simulation_step(simulation, 0.5, 15));
    KEEPS(perion_simulation_step(simulation, 1.5, 1));
    EXPECT(own.calls > 16);
    KEEPS(perion_simulation_commit(simulation, 0.25));
    KEEPS(perion_simulation_evaluate(simulation));
    look_at_everything(simulation);
    KEEPS(perion_simulation_evaluate(simulation));
    result = scene_state_of(simulation);
    fail_on_purpose(simulation);
    overflow_inside(simulation);
    KEEPS(perion_simulation_destroy(&simulation));
    return result;
}

int main(void)
{
    scene_state usual, hostile;
    environment wanted, found;

    harness_begin();
    usual = run();
    make_hostile();
    wanted = environment_now();
    hostile = run();
    found = environment_now();
    fesetenv(FE_DFL_ENV);
    EXPECT_INT(wanted.traps, traps);
    EXPECT_INT(wanted.rounding, FE_UPWARD);
    EXPECT(wanted.flags != 0);
    EXPECT(same_environment(&wanted, &found));
    EXPECT(scene_is(&usual, hostile));
    scene_state_free(&usual);
    return harness_end();
}
