/*
 * A plate of glass cracks and branches: the boundary tension test of Partmann et al. 2026, section 5.3.
 *
 * A plate of 100 x 40 x 4 mm has a crack from its left edge to its centre. At time 0 a tension of 1 MPa
 * is put on its upper and lower edge and held. The crack starts to run and splits in two.
 *
 * Usage: branching [points along the plate, 200] [output file, branching_c.pvd]
 *
 * What a host program does with Perion, in order: points, sets, model, simulation, conditions, step,
 * results. The same program stands beside this one in Fortran and in Rust; all three print the same
 * hash, because the results are the same to the last bit.
 */
#include <perion.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Every call that can fail returns a status; the text says what went wrong and what to do. */
static void check(perion_status status)
{
    if (status != PERION_OK) {
        fprintf(stderr, "%s: %s\n", perion_status_string(status), perion_last_error());
        exit(1);
    }
}

/* What the progress callback below needs. */
typedef struct watch {
    const perion_simulation *simulation;
    const char *series;
    struct timespec start;
    int shown;
} watch;

static double seconds_since(const struct timespec *start)
{
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return difftime(now.tv_sec, start->tv_sec) + 1e-9 * (double)(now.tv_nsec - start->tv_nsec);
}

/* Perion calls this after each step. It may look at the simulation and write files; a result other than
 * 0 stops the run. It must return: no exit, no longjmp. */
static int show_progress(void *user, int64_t done, int64_t total, double time)
{
    static const perion_field fields[] = {PERION_FIELD_DAMAGE, PERION_FIELD_DISPLACEMENT,
                                          PERION_FIELD_VELOCITY,
                                          PERION_FIELD_STRAIN_ENERGY_DENSITY};
    watch *watching = user;
    int twentieth = (int)(20 * done / total);
    double elapsed;

    if (twentieth == watching->shown)
        return 0;
    watching->shown = twentieth;
    if (watching->series[0] != '\0' &&
        perion_simulation_write_series(watching->simulation, watching->series,
                                       sizeof fields / sizeof fields[0], fields) != PERION_OK) {
        fprintf(stderr, "%s\n", perion_last_error());
        return 1;
    }
    elapsed = seconds_since(&watching->start);
    printf("step %5lld of %lld, %5.1f us, %6.1f s left\n", (long long)done, (long long)total,
           1e6 * time, elapsed * (double)(total - done) / (double)done);
    fflush(stdout);
    return 0;
}

/* A fingerprint of the bits of a field. */
static int64_t hash_field(int64_t hash, const perion_simulation *simulation, perion_field field,
                          int64_t length)
{
    double *values = malloc((size_t)length * sizeof *values);

    if (values == NULL)
        exit(1);
    check(perion_simulation_get(simulation, field, values, length));
    for (int64_t k = 0; k < length; ++k) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        hash = (hash * 65599 + (int64_t)(bits & 0xffffffffu)) % 1099511627689;
        hash = (hash * 65599 + (int64_t)(bits >> 32)) % 1099511627689;
    }
    free(values);
    return hash;
}

int main(int argc, char **argv)
{
    const double length = 0.1, height = 0.04, depth = 0.004; /* metres */
    const double end_time = 50e-6;                           /* seconds */
    const double traction = 1e6;                             /* pascals */
    const int along = argc > 1 ? atoi(argv[1]) : 200;
    const char *series = argc > 2 ? argv[2] : "branching_c.pvd";

    perion_points *points = NULL;
    perion_model *glass = NULL;
    perion_simulation *simulation = NULL;
    perion_energy energy;
    perion_health health;
    watch watching = {0};
    int64_t count, steps, hash = 0;
    double stable;

    if (along < 10) {
        fprintf(stderr, "at least 10 points along the plate are needed\n");
        return 1;
    }

    /* The points: a block, its lower left corner in the middle of the left edge. One layer of points
     * along the upper edge and one along the lower are named, to pull on them. */
    const double spacing = length / along;
    const double lower[] = {0.0, -height / 2, 0.0}, upper[] = {length, height / 2, depth};
    const double below_top[] = {0.0, height / 2 - spacing, 0.0};
    const double above_bottom[] = {length, spacing - height / 2, depth};
    check(perion_points_create_block(3, lower, upper, spacing, &points));
    check(perion_points_add_set_box(points, "top", below_top, upper));
    check(perion_points_add_set_box(points, "bottom", lower, above_bottom));
    check(perion_points_count(points, &count));

    /* The material: soda-lime glass. Bond-based peridynamics takes one elastic constant, since its
     * Poisson's ratio is 1/4. The energy release rate tells when bonds break. */
    check(perion_model_create("bond_based", &glass));
    check(perion_model_set(glass, "youngs_modulus", 32e9));
    check(perion_model_set(glass, "density", 2440.0));
    check(perion_model_set(glass, "horizon", 3.015 * spacing));
    check(perion_model_set(glass, "critical_energy_release_rate", 0.75));

    /* The simulation keeps copies, so points and model can go. */
    check(perion_simulation_create(points, glass, &simulation));
    perion_points_destroy(&points);
    perion_model_destroy(&glass);

    /* The crack that is there from the start: a rectangle across which all bonds are broken. */
    const double crack[] = {0.0,        0.0, 0.0,   length / 2, 0.0, 0.0,
                            length / 2, 0.0, depth, 0.0,        0.0, depth};
    check(perion_simulation_break_crossing(simulation, 4, crack));

    /* The tension, as a body force on the named layers, whose bonds may not break. */
    const double body_force = traction / spacing;
    check(perion_simulation_prescribe(simulation, "top", PERION_QUANTITY_BODY_FORCE, 1, body_force));
    check(perion_simulation_prescribe(simulation, "bottom", PERION_QUANTITY_BODY_FORCE, 1,
                                      -body_force));
    check(perion_simulation_forbid_failure(simulation, "top"));
    check(perion_simulation_forbid_failure(simulation, "bottom"));

    /* Stepping: the library knows a step that is stable, and half of it where cracks stretch bonds. */
    check(perion_simulation_stable_time_step(simulation, &stable));
    steps = (int64_t)ceil(end_time / (0.5 * stable));
    printf("%lld points, %lld steps of %6.4f us\n", (long long)count, (long long)steps,
           1e6 * end_time / (double)steps);
    watching.simulation = simulation;
    watching.series = series;
    timespec_get(&watching.start, TIME_UTC);
    check(perion_simulation_set_progress(simulation, show_progress, &watching));
    check(perion_simulation_step(simulation, end_time / (double)steps, steps));

    /* Results. */
    perion_energy_init(&energy, sizeof(perion_energy));
    perion_health_init(&health, sizeof(perion_health));
    check(perion_simulation_energy(simulation, &energy));
    check(perion_simulation_health(simulation, &health));
    printf("broken bonds    %lld of %lld\n", (long long)health.broken_bonds,
           (long long)health.bonds);
    printf("external work   %10.6f mJ\n", 1e3 * energy.external_work);
    printf("kinetic energy  %10.6f mJ\n", 1e3 * energy.kinetic);
    printf("elastic energy  %10.6f mJ\n", 1e3 * energy.elastic);
    printf("dissipated      %10.6f mJ\n", 1e3 * energy.dissipated);
    printf("closure error   %10.6f %% of the work\n",
           1e2 * energy.closure_error / energy.external_work);
    hash = hash_field(hash, simulation, PERION_FIELD_DISPLACEMENT, 3 * count);
    hash = hash_field(hash, simulation, PERION_FIELD_VELOCITY, 3 * count);
    hash = hash_field(hash, simulation, PERION_FIELD_DAMAGE, count);
    printf("hash            %010llX\n", (unsigned long long)hash);

    check(perion_simulation_destroy(&simulation));
    return 0;
}
