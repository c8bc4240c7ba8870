/*
 * A tensile test: a flat specimen of PMMA with a hole in its middle is pulled until it breaks.
 *
 * The specimen is 120 mm long, 3 mm thick and 12 mm wide where it is narrow; its mesh was written by
 * Gmsh. One grip is held and the other is pulled at 0.5 m/s, slowly enough for the specimen to stay in
 * balance until it breaks beside the hole.
 *
 * Usage: specimen [mesh, examples/specimen/specimen.msh] [curve, specimen_c.csv]
 *                 [output file, specimen_c.pvd]
 *
 * In order: points and sets from the mesh, model, simulation, conditions, step, results. Perion takes
 * any units that fit together: here mm, ms and g, and so m/s, N, MPa and mJ. The same program stands
 * beside this one in Fortran and in Rust; all three print the same hash.
 */
#include <perion.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RECORDS = 200 };

/* What is recorded in the test. */
typedef struct record {
    double displacement;  /* how far the right grip has come, mm */
    double force;         /* on the right grip, N */
    double left_force;    /* on the left grip, N: the same backwards, as long as there is balance */
    double kinetic_share; /* kinetic over elastic energy: small, as long as there is balance */
    double dissipated;    /* spent on broken bonds, mJ */
} record;

/* Every call that can fail returns a status; the text says what went wrong and what to do. */
static void check(perion_status status)
{
    if (status != PERION_OK) {
        fprintf(stderr, "%s: %s\n", perion_status_string(status), perion_last_error());
        exit(1);
    }
}

static double *numbers(int64_t count)
{
    double *values = calloc((size_t)count, sizeof *values);

    if (values == NULL) {
        fprintf(stderr, "there is no memory for %lld numbers\n", (long long)count);
        exit(1);
    }
    return values;
}

/* The area of all points. */
static double area_of(const perion_points *points, int64_t count)
{
    double *areas = numbers(count), sum = 0.0;

    check(perion_points_get_volumes(points, areas, count));
    for (int64_t point = 0; point < count; ++point)
        sum += areas[point];
    free(areas);
    return sum;
}

/* The sum of the first component of a field over a set. */
static double sum_along(const perion_simulation *simulation, perion_field field, const char *set)
{
    double components[2];

    check(perion_simulation_sum(simulation, field, set, components));
    return components[0];
}

static void write_series(const perion_simulation *simulation, const char *series)
{
    static const perion_field fields[] = {PERION_FIELD_DAMAGE, PERION_FIELD_DISPLACEMENT,
                                          PERION_FIELD_STRAIN_ENERGY_DENSITY};

    if (series[0] != '\0')
        check(perion_simulation_write_series(simulation, series, sizeof fields / sizeof fields[0],
                                             fields));
}

/* The curve of force over displacement, with the names of its axes in the first line. */
static void write_curve(const char *path, const record *curve)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "displacement (mm),force (N)\n%10.6f,%12.4f\n", 0.0, 0.0);
    for (int number = 0; number < RECORDS; ++number)
        fprintf(file, "%10.6f,%12.4f\n", curve[number].displacement, curve[number].force);
    if (fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

/* A fingerprint of the bits of a field. */
static int64_t hash_field(int64_t hash, const perion_simulation *simulation, perion_field field,
                          int64_t length)
{
    double *values = numbers(length);

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
    const double thickness = 3.0;                         /* mm */
    const double speed = 0.5, ramp = 0.3, end_time = 0.72; /* mm/ms, ms, ms */
    const char *mesh = argc > 1 ? argv[1] : "examples/specimen/specimen.msh";
    const char *path = argc > 2 ? argv[2] : "specimen_c.csv";
    const char *series = argc > 3 ? argv[3] : "specimen_c.pvd";

    perion_points *points = NULL;
    perion_model *pmma = NULL;
    perion_simulation *simulation = NULL;
    perion_energy energy;
    perion_health health;
    record curve[RECORDS];
    int64_t count, grip_points, hash = 0;
    double stable;

    /* The points: one for each element of the mesh, with its area, at its centroid. The mesh names the
     * elements in the grips; the sets of their points have these names. */
    check(perion_points_read(mesh, &points));
    check(perion_points_count(points, &count));
    check(perion_points_set_size(points, "right_grip", &grip_points));
    const double spacing = sqrt(area_of(points, count) / (double)count);

    /* The material: PMMA, which breaks without yielding. In plane stress bond-based peridynamics has a
     * Poisson's ratio of 1/3, which is near to that of PMMA. */
    check(perion_model_create("bond_based", &pmma));
    check(perion_model_choose(pmma, "plane", "stress"));
    check(perion_model_set(pmma, "thickness", thickness));
    check(perion_model_set(pmma, "youngs_modulus", 3200.0));            /* MPa */
    check(perion_model_set(pmma, "density", 1.18e-3));                  /* g/mm3 */
    check(perion_model_set(pmma, "horizon", 3.0 * spacing));            /* mm */
    check(perion_model_set(pmma, "critical_energy_release_rate", 0.5)); /* N/mm */

    /* The simulation keeps copies, so points and model can go. */
    check(perion_simulation_create(points, pmma, &simulation));
    perion_points_destroy(&points);
    perion_model_destroy(&pmma);

    /* The left grip is held, the right one is pulled. Its speed grows smoothly, so that the specimen is
     * not struck: a table of times and velocities. */
    const double times[] = {0.0, 0.25 * ramp, 0.5 * ramp, 0.75 * ramp, ramp};
    const double speeds[] = {0.0, 0.15625 * speed, 0.5 * speed, 0.84375 * speed, speed};
    check(perion_simulation_prescribe(simulation, "left_grip", PERION_QUANTITY_VELOCITY, 0, 0.0));
    check(perion_simulation_prescribe(simulation, "left_grip", PERION_QUANTITY_VELOCITY, 1, 0.0));
    check(perion_simulation_prescribe_table(simulation, "right_grip", PERION_QUANTITY_VELOCITY, 0, 5,
                                            times, speeds));
    check(perion_simulation_prescribe(simulation, "right_grip", PERION_QUANTITY_VELOCITY, 1, 0.0));
    check(perion_simulation_forbid_failure(simulation, "left_grip"));
    check(perion_simulation_forbid_failure(simulation, "right_grip"));

    /* Stepping, with a look at the specimen 200 times: how far its right grip has come, and the force on
     * it, which is the sum of what holds its points. */
    check(perion_simulation_stable_time_step(simulation, &stable));
    const double interval = end_time / RECORDS;
    const int64_t steps = (int64_t)ceil(interval / (0.5 * stable));
    const double time_step = interval / (double)steps;
    printf("%lld points, %.4f mm apart\n", (long long)count, spacing);
    printf("%lld steps of %.4f us\n", (long long)(RECORDS * steps), 1e3 * time_step);
    printf("   time us  displacement mm    force N\n");
    perion_energy_init(&energy, sizeof(perion_energy));
    for (int number = 0; number < RECORDS; ++number) {
        record *now = &curve[number];
        check(perion_simulation_step(simulation, time_step, steps));
        check(perion_simulation_energy(simulation, &energy));
        now->displacement = sum_along(simulation, PERION_FIELD_DISPLACEMENT, "right_grip") /
                            (double)grip_points;
        now->force = sum_along(simulation, PERION_FIELD_REACTION, "right_grip");
        now->left_force = sum_along(simulation, PERION_FIELD_REACTION, "left_grip");
        now->kinetic_share = energy.kinetic / energy.elastic;
        now->dissipated = energy.dissipated;
        if ((number + 1) % 10 == 0) {
            double time;
            check(perion_simulation_time(simulation, &time));
            printf("%10.1f %16.4f %10.2f\n", 1e3 * time, now->displacement, now->force);
            write_series(simulation, series);
        }
    }

    /* Results. The stiffness is the slope of the line through the origin that fits the first half of the
     * way to the greatest force. */
    int intact = 0, peak = 0;
    double products = 0.0, squares = 0.0;
    for (int number = 0; number < RECORDS; ++number) {
        if (curve[number].dissipated == 0.0)
            intact = number;
        if (curve[number].force > curve[peak].force)
            peak = number;
    }
    for (int number = 0; number < RECORDS; ++number)
        if (curve[number].displacement < 0.5 * curve[peak].displacement) {
            products += curve[number].force * curve[number].displacement;
            squares += curve[number].displacement * curve[number].displacement;
        }
    perion_health_init(&health, sizeof(perion_health));
    check(perion_simulation_health(simulation, &health));
    printf("stiffness       %10.2f N/mm\n", products / squares);
    printf("intact up to    %10.4f mm\n", curve[intact].displacement);
    printf("  force         %10.2f N\n", curve[intact].force);
    printf("  left grip     %10.2f N\n", curve[intact].left_force);
    printf("  kinetic       %10.4f %% of the elastic energy\n", 100 * curve[intact].kinetic_share);
    printf("greatest force  %10.2f N\n", curve[peak].force);
    printf("  displacement  %10.4f mm\n", curve[peak].displacement);
    printf("broken bonds    %10lld of %lld\n", (long long)health.broken_bonds,
           (long long)health.bonds);
    printf("external work   %10.4f mJ\n", energy.external_work);
    printf("kinetic energy  %10.4f mJ\n", energy.kinetic);
    printf("elastic energy  %10.4f mJ\n", energy.elastic);
    printf("dissipated      %10.4f mJ\n", energy.dissipated);
    printf("closure error   %10.4f %% of the work\n",
           100 * energy.closure_error / energy.external_work);
    hash = hash_field(hash, simulation, PERION_FIELD_DISPLACEMENT, 2 * count);
    hash = hash_field(hash, simulation, PERION_FIELD_VELOCITY, 2 * count);
    hash = hash_field(hash, simulation, PERION_FIELD_DAMAGE, count);
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (path[0] != '\0')
        write_curve(path, curve);

    check(perion_simulation_destroy(&simulation));
    return 0;
}
