/*
 * A bar is set spinning about its axis and twists by more than half a turn: large rotations without drift.
 *
 * After Partmann et al. 2026, section 4.5: a bar of 0.1 x 0.1 x 1 m, held at its lower end, starts with a
 * spin about its axis that grows from 0 at the held end to 150 1/s at the free one, along a quarter of a
 * sine. That is the lowest mode of torsion. The law of Saint Venant and Kirchhoff knows rotations, so
 * nothing else is needed for them, and correspondence stays calm as long as the motion is smooth.
 *
 * The paper names neither the material nor the end. Steel would turn by two degrees; here it is a soft
 * rubber, E = 2.5 MPa, nu = 1/4, 1000 kg/m3, which turns by more than half a turn. The run ends after half
 * a period, when the bar is back. The angle in equation 4.58 is taken to go all the way round.
 *
 * The stiffness against torsion is measured on the bar itself, as the energy that it takes to twist it: a
 * gradient averaged over families that the surface cuts is that of a place further inside, and so a bar of
 * few horizons is much softer than its material.
 *
 * Usage: twist [points across, 6; 30 in the paper] [curve, twist_c.csv] [output file, twist_c.pvd]
 *
 * In order: points and sets, model, simulation, a state set by hand, conditions, step, results. Units are
 * m, s and kg. The same program stands beside this one in Fortran and in Rust; all three print the same
 * hash.
 */
#include <perion.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RECORDS = 200 };

static const double pi = 3.14159265358979323846;
static const double degrees = 57.29577951308232; /* in a radian */

/* What is recorded. */
typedef struct record {
    double time, angle, drift, determinant; /* s, rad, a share of the energy, without unit */
} record;

/* Every call that can fail returns a status; the text says what went wrong and what to do. */
static void check(perion_status status)
{
    if (status != PERION_OK) {
        fprintf(stderr, "%s: %s\n", perion_status_string(status), perion_last_error());
        exit(1);
    }
}

static void *room(int64_t count, size_t size)
{
    void *memory = calloc((size_t)count, size);

    if (memory == NULL) {
        fprintf(stderr, "there is no memory for %lld numbers\n", (long long)count);
        exit(1);
    }
    return memory;
}

/* The energy per length of the layer in the middle when the bar is twisted by hand and its sections are
 * warped as those of a square are, c x y (x^2 - y^2). */
static double twisted_energy(perion_simulation *bar, const double *places, int64_t count,
                             double twisting, double warping, double spacing)
{
    double *displacement = room(3 * count, sizeof *displacement);
    double density;

    for (int64_t point = 0; point < count; ++point) {
        const double *place = &places[3 * point];
        const double x = place[0], y = place[1], z = place[2];
        displacement[3 * point] = -twisting * y * z;
        displacement[3 * point + 1] = twisting * x * z;
        displacement[3 * point + 2] = twisting * (warping * x * y * (x * x - y * y));
    }
    check(perion_simulation_set(bar, PERION_FIELD_DISPLACEMENT, displacement, 3 * count));
    check(perion_simulation_sum(bar, PERION_FIELD_STRAIN_ENERGY_DENSITY, "middle", &density));
    memset(displacement, 0, (size_t)(3 * count) * sizeof *displacement);
    check(perion_simulation_set(bar, PERION_FIELD_DISPLACEMENT, displacement, 3 * count));
    free(displacement);
    return density * spacing * spacing;
}

/* Least determinant of the tensors of all points. */
static double least_determinant(const double *tensors, int64_t count)
{
    double least = INFINITY;

    for (int64_t point = 0; point < count; ++point) {
        const double *f = &tensors[9 * point];
        least = fmin(least, f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) +
                                f[2] * (f[3] * f[7] - f[4] * f[6]));
    }
    return least;
}

/* The curve of the angle over time, with the names of its axes in the first line. */
static void write_curve(const char *path, const record *curve)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "time (ms),angle (degrees)\n%10.4f,%12.5f\n", 0.0, 0.0);
    for (int k = 0; k < RECORDS; ++k)
        fprintf(file, "%10.4f,%12.5f\n", 1e3 * curve[k].time, degrees * curve[k].angle);
    if (fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

/* A fingerprint of the bits of a field. */
static int64_t hash_field(int64_t hash, const perion_simulation *simulation, perion_field field,
                          int64_t length)
{
    double *values = room(length, sizeof *values);

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
    static const perion_field fields[] = {PERION_FIELD_REFERENCE_POSITION,
                                          PERION_FIELD_DISPLACEMENT,
                                          PERION_FIELD_VON_MISES_STRESS};
    const double width = 0.1, length = 1.0;          /* m */
    const double modulus = 2.5e6, density = 1000.0;  /* Pa, kg/m3 */
    const double spin = 150.0;                       /* rad/s */
    const int across = argc > 1 ? atoi(argv[1]) : 6;
    const char *path = argc > 2 ? argv[2] : "twist_c.csv";
    const char *series = argc > 3 ? argv[3] : "twist_c.pvd";

    perion_points *points = NULL;
    perion_model *rubber = NULL;
    perion_simulation *bar = NULL;
    perion_energy energy;
    record curve[RECORDS];
    int64_t count, watched_count, hash = 0;
    double stable;

    if (across < 4) {
        fprintf(stderr, "at least 4 points across are needed\n");
        return 1;
    }

    /* The points: a block, its axis the z axis. Its ends are named, three layers to hold, one to watch. */
    const double spacing = width / across;
    const double half = 0.5 * width, end = 0.5 * length;
    const double lower[] = {-half, -half, -end}, upper[] = {half, half, end};
    const double held_upper[] = {half, half, 3 * spacing - end};
    const double free_lower[] = {-half, -half, end - spacing};
    const double middle_lower[] = {-half, -half, 0.0}, middle_upper[] = {half, half, spacing};
    check(perion_points_create_block(3, lower, upper, spacing, &points));
    check(perion_points_add_set_box(points, "held", lower, held_upper));
    check(perion_points_add_set_box(points, "free", free_lower, upper));
    check(perion_points_add_set_box(points, "middle", middle_lower, middle_upper));
    check(perion_points_count(points, &count));
    check(perion_points_set_size(points, "free", &watched_count));
    int64_t *watched = room(watched_count, sizeof *watched);
    double *places = room(3 * count, sizeof *places);
    check(perion_points_get_set(points, "free", watched_count, watched));
    check(perion_points_get_coordinates(points, places, 3 * count));

    /* The material: a soft rubber, of Saint Venant and Kirchhoff, the default. */
    check(perion_model_create("correspondence", &rubber));
    check(perion_model_set(rubber, "youngs_modulus", modulus));
    check(perion_model_set(rubber, "poissons_ratio", 0.25));
    check(perion_model_set(rubber, "density", density));
    check(perion_model_set(rubber, "horizon", 3.015 * spacing));
    check(perion_simulation_create(points, rubber, &bar));
    check(perion_points_destroy(&points));
    check(perion_model_destroy(&rubber));

    /* The stiffness against torsion, from a small twist: the energy is least for the warping that the bar
     * takes. */
    const double twisting = 1e-4; /* rad/m */
    const double warping = 1.0 / (half * half);
    const double less = twisted_energy(bar, places, count, twisting, -warping, spacing);
    const double plain = twisted_energy(bar, places, count, twisting, 0.0, spacing);
    const double more = twisted_energy(bar, places, count, twisting, warping, spacing);
    const double slope = 0.5 * (more - less), curvature = 0.5 * (more + less) - plain;
    const double stiffness =
        2 * (plain - slope * slope / (4 * curvature)) / (twisting * twisting);

    /* The spin, counted from just above the held layers: equations 4.58 and 4.59. */
    double *velocity = room(3 * count, sizeof *velocity);
    for (int64_t point = 0; point < count; ++point) {
        const double *place = &places[3 * point];
        const double height = place[2] + end - 3.01 * spacing;
        const double rate = spin * sin(pi / (2 * length) * height);
        velocity[3 * point] = -rate * place[1];
        velocity[3 * point + 1] = rate * place[0];
    }
    check(perion_simulation_set(bar, PERION_FIELD_VELOCITY, velocity, 3 * count));
    free(velocity);
    for (int axis = 0; axis < 3; ++axis)
        check(perion_simulation_prescribe(bar, "held", PERION_QUANTITY_VELOCITY, axis, 0.0));

    /* Linear torsion of what is free: waves of it run at sqrt(stiffness/inertia), and a quarter of a
     * period takes them once along the bar. The material alone would make it 0.1406 mu width^4 stiff. */
    const double shear_modulus = modulus / 2.5;
    const double section = width * width;
    const double material_stiffness = 0.1406 * shear_modulus * (section * section);
    const double inertia = density * (section * section) / 6 * (1.0 - 1.0 / (across * across));
    const double quarter = (length - 3 * spacing) / sqrt(stiffness / inertia);
    const double linear = spin * quarter / (0.5 * pi);

    /* Stepping, through half a period, with a look at the bar 200 times. Shear makes this law stiffer: a
     * tenth of the step that is stable now is kept back. */
    check(perion_simulation_stable_time_step(bar, &stable));
    const double interval = 2 * quarter / RECORDS;
    const int64_t steps = (int64_t)ceil(interval / (0.9 * stable));
    printf("%lld points, %lld steps of %.4f ms\n", (long long)count, (long long)(RECORDS * steps),
           1e3 * interval / (double)steps);
    printf("   time ms  angle deg  kinetic J  elastic J  least det F\n");
    perion_energy_init(&energy, sizeof(perion_energy));
    check(perion_simulation_energy(bar, &energy));
    const double given = energy.kinetic;
    double *positions = room(3 * count, sizeof *positions);
    double *gradients = room(9 * count, sizeof *gradients);
    double angle = 0.0, drift = 0.0, least = INFINITY, shortening = 0.0;
    record turn = {0};
    for (int number = 1; number <= RECORDS; ++number) {
        record *now = &curve[number - 1];
        check(perion_simulation_step(bar, interval / (double)steps, steps));
        check(perion_simulation_get(bar, PERION_FIELD_POSITION, positions, 3 * count));
        check(perion_simulation_get(bar, PERION_FIELD_DEFORMATION_GRADIENT, gradients, 9 * count));

        /* The angle of the free end: that of the rotation in its plane that fits its points best. */
        double cosines = 0.0, sines = 0.0, height = 0.0;
        for (int64_t k = 0; k < watched_count; ++k) {
            const double *place = &places[3 * watched[k]], *position = &positions[3 * watched[k]];
            cosines += place[0] * position[0] + place[1] * position[1];
            sines += place[0] * position[1] - place[1] * position[0];
            height += position[2];
        }
        /* Between two looks it turns by less than half a turn. */
        const double turned = atan2(sines, cosines) - angle;
        angle += turned - 2 * pi * round(turned / (2 * pi));

        check(perion_simulation_energy(bar, &energy));
        check(perion_simulation_time(bar, &now->time));
        now->angle = angle;
        now->drift = (energy.kinetic + energy.elastic) / given - 1;
        now->determinant = least_determinant(gradients, count);
        drift = fmax(drift, fabs(now->drift));
        least = fmin(least, now->determinant);
        if (angle > turn.angle) {
            turn = *now;
            shortening = 1 - (height / (double)watched_count + end) / (length - 0.5 * spacing);
        }
        if (number % 10 == 0) {
            printf("%10.3f %10.3f %10.4f %10.4f %12.6f\n", 1e3 * now->time, degrees * angle,
                   energy.kinetic, energy.elastic, now->determinant);
            if (series[0] != '\0')
                check(perion_simulation_write_series(bar, series, sizeof fields / sizeof fields[0],
                                                     fields));
        }
    }

    /* Results. */
    printf("stiffness       %10.4f N m2\n", stiffness);
    printf("  material      %10.4f N m2\n", material_stiffness);
    printf("greatest angle  %10.3f degrees\n", degrees * turn.angle);
    printf("  linear        %10.3f degrees\n", degrees * linear);
    printf("  its time      %10.4f ms\n", 1e3 * turn.time);
    printf("  linear        %10.4f ms\n", 1e3 * quarter);
    printf("  bar shorter by%10.4f %%\n", 100 * shortening);
    printf("energy given    %10.4f J\n", given);
    printf("largest drift   %10.4f %%\n", 100 * drift);
    printf("least det F     %10.6f\n", least);
    hash = hash_field(hash, bar, PERION_FIELD_DISPLACEMENT, 3 * count);
    hash = hash_field(hash, bar, PERION_FIELD_VELOCITY, 3 * count);
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (path[0] != '\0')
        write_curve(path, curve);

    free(gradients);
    free(positions);
    free(places);
    free(watched);
    check(perion_simulation_destroy(&bar));
    return 0;
}
