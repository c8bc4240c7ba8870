/*
 * A wave in a bar: one end of a steel bar is struck, and the front runs at the speed of theory.
 *
 * The bar has 20 x 20 points across, 1 mm apart. Its end is brought to 1 m/s and kept at it. A front
 * that is long against the width of the bar runs at sqrt(E/rho). This E is measured on the bar itself,
 * as the energy that it takes to stretch it: points near the surface lack bonds, which makes a thin
 * bar softer than its material.
 *
 * Usage: wave [points along the bar, 200] [output file, wave_c.csv]
 *
 * In order: points and sets, model, simulation, a state set by hand, conditions, step, results. Units
 * are mm, ms and g, and so m/s, MPa and mJ. The same program stands beside this one in Fortran and in
 * Rust; all three print the same hash.
 */
#include <perion.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ACROSS = 20, RECORDS = 200 };

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

/* The time at which a cross-section has reached a velocity, by a line between two records. */
static double passing(const double *velocities, int along, int column, double velocity,
                      double interval)
{
    int after = 1;

    while (after < RECORDS && velocities[after * along + column] < velocity)
        ++after;
    const double early = velocities[(after - 1) * along + column];
    const double late = velocities[after * along + column];
    return interval * (after - (late - velocity) / (late - early));
}

/* A row for each record and a column for each cross-section; the first line tells what they are. */
static void write_matrix(const char *path, const double *velocities, int along, double interval)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "x (mm),%8.1f,%8.1f,t (us),%8.4f,%8.4f,axial velocity (m/s)\n", 0.5, along - 0.5,
            0.0, 1e3 * interval * RECORDS);
    for (int record = 0; record <= RECORDS; ++record)
        for (int column = 0; column < along; ++column)
            fprintf(file, "%8.4f%c", velocities[record * along + column],
                    column + 1 < along ? ',' : '\n');
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
    const double spacing = 1.0, across = ACROSS;     /* mm */
    const double density = 7.8e-3, modulus = 210e3;  /* g/mm3, MPa */
    const double speed = 1.0;                        /* mm/ms, of the struck end */
    const double rise = 40.0;                        /* mm, length of the front */
    const int along = argc > 1 ? atoi(argv[1]) : 200;
    const char *matrix = argc > 2 ? argv[2] : "wave_c.csv";

    perion_points *points = NULL;
    perion_model *steel = NULL;
    perion_simulation *bar = NULL;
    perion_energy energy;
    int64_t count, hash = 0;
    double volume, stable;

    if (along < 50) {
        fprintf(stderr, "at least 50 points along the bar are needed\n");
        return 1;
    }

    /* The points: a block, its axis the x axis. Its first layers are named, to strike them. */
    const double length = along * spacing;
    const double lower[] = {0.0, -across / 2, -across / 2};
    const double upper[] = {length, across / 2, across / 2};
    const double beyond_struck[] = {3 * spacing, across / 2, across / 2};
    check(perion_points_create_block(3, lower, upper, spacing, &points));
    check(perion_points_add_set_box(points, "struck", lower, beyond_struck));
    check(perion_points_count(points, &count));

    /* The material: steel that does not break. */
    check(perion_model_create("bond_based", &steel));
    check(perion_model_set(steel, "youngs_modulus", modulus));
    check(perion_model_set(steel, "density", density));
    check(perion_model_set(steel, "horizon", 3.015 * spacing));
    check(perion_simulation_create(points, steel, &bar));

    /* The modulus of the bar: it is stretched by hand, and narrows by Poisson's ratio 1/4 of that. Its
     * energy is 1/2 E stretch^2 volume. Then it is let go. */
    const double stretch = 1e-5;
    double *displacement = numbers(3 * count);
    check(perion_points_get_coordinates(points, displacement, 3 * count));
    for (int64_t point = 0; point < count; ++point) {
        displacement[3 * point] *= stretch;
        displacement[3 * point + 1] *= -0.25 * stretch;
        displacement[3 * point + 2] *= -0.25 * stretch;
    }
    check(perion_simulation_set(bar, PERION_FIELD_DISPLACEMENT, displacement, 3 * count));
    perion_energy_init(&energy, sizeof(perion_energy));
    check(perion_simulation_energy(bar, &energy));
    check(perion_simulation_sum(bar, PERION_FIELD_VOLUME, NULL, &volume));
    const double bar_modulus = 2 * energy.elastic / (stretch * stretch * volume);
    const double expected = sqrt(bar_modulus / density);
    memset(displacement, 0, (size_t)(3 * count) * sizeof *displacement);
    check(perion_simulation_set(bar, PERION_FIELD_DISPLACEMENT, displacement, 3 * count));
    free(displacement);
    perion_points_destroy(&points);
    perion_model_destroy(&steel);

    /* The blow: the velocity of the first layers grows smoothly, by a table of times and velocities. */
    const double ramp = rise / expected;
    const double times[] = {0.0, 0.25 * ramp, 0.5 * ramp, 0.75 * ramp, ramp};
    const double speeds[] = {0.0, 0.15625 * speed, 0.5 * speed, 0.84375 * speed, speed};
    check(perion_simulation_prescribe_table(bar, "struck", PERION_QUANTITY_VELOCITY, 0, 5, times,
                                            speeds));

    /* Stepping, until the front has been reflected at the far end. 200 times on the way the mean axial
     * velocity of each cross-section is taken: x runs fastest in a block of points. */
    check(perion_simulation_stable_time_step(bar, &stable));
    const double end_time = (1.5 * length + rise) / expected;
    const double interval = end_time / RECORDS;
    const int64_t steps = (int64_t)ceil(interval / (0.5 * stable));
    double *velocity = numbers(3 * count);
    double *velocities = numbers((RECORDS + 1) * (int64_t)along);
    printf("%lld points, %lld steps of %.4f us\n", (long long)count, (long long)(RECORDS * steps),
           1e3 * interval / (double)steps);
    for (int record = 1; record <= RECORDS; ++record) {
        double *means = &velocities[record * along];
        check(perion_simulation_step(bar, interval / (double)steps, steps));
        check(perion_simulation_get(bar, PERION_FIELD_VELOCITY, velocity, 3 * count));
        for (int64_t point = 0; point < count; ++point)
            means[point % along] += velocity[3 * point] / (across * across);
    }

    /* Results: the front is where half the speed of the blow is first reached. */
    const int near = 3 * along / 10, far = 7 * along / 10;
    const double near_time = passing(velocities, along, near, 0.5 * speed, interval);
    const double far_time = passing(velocities, along, far, 0.5 * speed, interval);
    const double measured = (far - near) * spacing / (far_time - near_time);
    check(perion_simulation_energy(bar, &energy));
    printf("modulus         %10.4f GPa\n", 1e-3 * bar_modulus);
    printf("sqrt(E/rho)     %10.2f m/s\n", expected);
    printf("front passes    %10.4f us at %d mm\n", 1e3 * near_time, near);
    printf("                %10.4f us at %d mm\n", 1e3 * far_time, far);
    printf("its speed       %10.2f m/s\n", measured);
    printf("deviation       %10.2f %%\n", 100 * (measured / expected - 1));
    printf("closure error   %10.4f %% of the work\n",
           100 * energy.closure_error / energy.external_work);
    hash = hash_field(hash, bar, PERION_FIELD_DISPLACEMENT, 3 * count);
    hash = hash_field(hash, bar, PERION_FIELD_VELOCITY, 3 * count);
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (matrix[0] != '\0')
        write_matrix(matrix, velocities, along, interval);

    free(velocity);
    free(velocities);
    check(perion_simulation_destroy(&bar));
    return 0;
}
