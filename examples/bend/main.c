/*
 * A bar is bent until its ends nearly touch: large displacements and rotations, as an elastica has them.
 *
 * After Partmann et al. 2026, section 4.5: a bar of 0.2 x 0.01 x 0.01 m, E = 2.3 GPa, nu = 1/4, 1600 kg/m3,
 * with a slight curvature, here an arc of radius 2 m, so that it bends and is not just pressed. The inner
 * edges of its two ends are moved towards each other, and the bar is free to rotate about them. The horizon
 * is 0.64 widths as in the paper, 5.15 spacings with 8 points across.
 *
 * The paper takes 0.2 s for it. The lowest mode of bending swings in 15 ms, and a pull that starts gently
 * leaves it nearly at rest in 0.03 s: the height of a bent bar grows as the square root of the way of its
 * ends, so the way begins as the fourth power of time.
 *
 * The stiffness against bending is that of the best of some displacements made by hand, which the bar itself
 * undercuts. It lies far below E I: a gradient averaged over families that the surface cuts is that of a
 * place further inside. The shape of an elastica is the same for any stiffness.
 *
 * Usage: bend [points across, 4; 8 in the paper] [time in s, 0.03; 0.2 in the paper] [curve, bend_c.csv]
 *             [output file, bend_c.pvd]
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

enum { RECORDS = 200, NODES = 7 };

static const double length = 0.2, width = 0.01; /* m */
static const double arc_radius = 2.0;           /* m */

/* What is recorded. */
typedef struct record {
    double shortening, height, force; /* m, m, N */
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

/* The points: a lattice laid along an arc, one row after the other, with its middle uppermost. The lower
 * edges of its ends are named, and its section in the middle. */
static perion_points *arc(int across)
{
    const int64_t along = 20 * across, count = along * across * across;
    const double spacing = width / across;
    double *coordinates = room(3 * count, sizeof *coordinates);
    double *volumes = room(count, sizeof *volumes);
    int64_t *left = room(across, sizeof *left), *right = room(across, sizeof *right);
    int64_t *middle = room(across * across, sizeof *middle);
    perion_points *points = NULL;

    for (int64_t row = 0; row < across * across; ++row) {
        const int64_t j = row % across, k = row / across;
        const double y = ((double)j + 0.5) * spacing - 0.5 * width;
        const double z = ((double)k + 0.5) * spacing - 0.5 * width;
        const double radius = arc_radius + y;
        if (j == 0) {
            left[k] = row * along;
            right[k] = row * along + along - 1;
        }
        middle[row] = row * along + along / 2;
        for (int64_t i = 0; i < along; ++i) {
            const double angle = (((double)i + 0.5) * spacing - 0.5 * length) / arc_radius;
            double *place = &coordinates[3 * (row * along + i)];
            place[0] = radius * sin(angle);
            place[1] = radius * cos(angle) - arc_radius;
            place[2] = z;
            volumes[row * along + i] = spacing * spacing * spacing * (radius / arc_radius);
        }
    }
    check(perion_points_create(3, count, coordinates, 3, volumes, &points));
    check(perion_points_add_set(points, "left", across, left));
    check(perion_points_add_set(points, "right", across, right));
    check(perion_points_add_set(points, "middle", across * across, middle));
    free(middle);
    free(right);
    free(left);
    free(volumes);
    free(coordinates);
    return points;
}

/* The energy per length of the section in the middle when the bar is bent by hand and contracts across. */
static double bent_energy(perion_simulation *bar, const double *places, int64_t count,
                          double curvature, double contraction, double spacing)
{
    double *displacement = room(3 * count, sizeof *displacement);
    double density;

    for (int64_t point = 0; point < count; ++point) {
        const double *place = &places[3 * point];
        const double x = place[0], y = place[1], z = place[2];
        displacement[3 * point] = -curvature * x * y;
        displacement[3 * point + 1] = 0.5 * curvature * (x * x + contraction * (y * y - z * z));
        displacement[3 * point + 2] = curvature * contraction * y * z;
    }
    check(perion_simulation_set(bar, PERION_FIELD_DISPLACEMENT, displacement, 3 * count));
    check(perion_simulation_sum(bar, PERION_FIELD_STRAIN_ENERGY_DENSITY, "middle", &density));
    memset(displacement, 0, (size_t)(3 * count) * sizeof *displacement);
    check(perion_simulation_set(bar, PERION_FIELD_DISPLACEMENT, displacement, 3 * count));
    free(displacement);
    return density * spacing * spacing;
}

/* The mean of a component of the vectors of some points. */
static double mean(const double *vectors, int64_t count, const int64_t *points, int axis)
{
    double sum = 0.0;

    for (int64_t k = 0; k < count; ++k)
        sum += vectors[3 * points[k] + axis];
    return sum / (double)count;
}

/* The curve of the height over the shortening, then the force, with the names of its columns in the first
 * line. */
static void write_curve(const char *path, const record *curve)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "shortening (mm),height (mm),force (N)\n");
    for (int k = 0; k < RECORDS; ++k)
        fprintf(file, "%10.4f,%10.4f,%11.3f\n", 1e3 * curve[k].shortening, 1e3 * curve[k].height,
                curve[k].force);
    if (fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

/* A fingerprint of the bits of a field. */
static int64_t hash_field(int64_t hash, const perion_simulation *simulation, perion_field field,
                          int64_t count)
{
    double *values = room(count, sizeof *values);

    check(perion_simulation_get(simulation, field, values, count));
    for (int64_t k = 0; k < count; ++k) {
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
    static const perion_field fields[] = {PERION_FIELD_DISPLACEMENT, PERION_FIELD_VON_MISES_STRESS,
                                          PERION_FIELD_STRAIN_ENERGY_DENSITY};
    const double modulus = 2.3e9; /* Pa */
    const double gap = 0.01;      /* m, between the edges at the end */
    const int across = argc > 1 ? atoi(argv[1]) : 4;
    const double duration = argc > 2 ? atof(argv[2]) : 0.03;
    const char *path = argc > 3 ? argv[3] : "bend_c.csv";
    const char *series = argc > 4 ? argv[4] : "bend_c.pvd";

    perion_model *polymer = NULL;
    perion_simulation *bar = NULL;
    perion_energy energy;
    perion_health health;
    record curve[RECORDS];
    int64_t count, hash = 0;
    double stable;

    if (across < 3 || !(duration > 0.0 && duration <= 1.0)) {
        fprintf(stderr, "at least 3 points across and a time of at most 1 s are needed\n");
        return 1;
    }

    const double spacing = width / across;
    const int64_t section_count = (int64_t)across * across;
    perion_points *points = arc(across);
    check(perion_points_count(points, &count));
    double *places = room(3 * count, sizeof *places);
    int64_t *left = room(across, sizeof *left), *middle = room(section_count, sizeof *middle);
    check(perion_points_get_coordinates(points, places, 3 * count));
    check(perion_points_get_set(points, "left", across, left));
    check(perion_points_get_set(points, "middle", section_count, middle));

    /* The material: a polymer, of Saint Venant and Kirchhoff, the default. */
    check(perion_model_create("correspondence", &polymer));
    check(perion_model_set(polymer, "youngs_modulus", modulus));
    check(perion_model_set(polymer, "poissons_ratio", 0.25));
    check(perion_model_set(polymer, "density", 1600.0)); /* kg/m3 */
    check(perion_model_set(polymer, "horizon", 5.15 / 8.0 * width));
    check(perion_simulation_create(points, polymer, &bar));
    check(perion_points_destroy(&points));
    check(perion_model_destroy(&polymer));

    /* The stiffness against bending, from a small curvature: the energy of the section in the middle is
     * least for the contraction across that the bar takes, which in a thick bar is Poisson's ratio. */
    const double curvature = 1e-3; /* 1/m */
    const double less = bent_energy(bar, places, count, curvature, 0.0, spacing);
    const double plain = bent_energy(bar, places, count, curvature, 0.25, spacing);
    const double more = bent_energy(bar, places, count, curvature, 0.5, spacing);
    const double slope = 0.5 * (more - less), bow = 0.5 * (more + less) - plain;
    const double stiffness = 2 * (plain - slope * slope / (4 * bow)) / (curvature * curvature);
    const double section = width * width;
    const double material_stiffness = modulus * (section * section) / 12;

    /* The edges move along x alone, by a table of times and velocities: a cubic start, then a steady
     * pull. */
    static const double instants[NODES] = {0.0, 0.1, 0.2, 0.3, 0.4, 0.8, 1.0};
    static const double shares[NODES] = {0.0, 0.015625, 0.125, 0.421875, 1.0, 1.0, 0.0};
    const double start = places[3 * left[0]];
    const double speed = (-start - 0.5 * gap) / (0.60625 * duration);
    double times[NODES], inwards[NODES], backwards[NODES];
    for (int node = 0; node < NODES; ++node) {
        times[node] = instants[node] * duration;
        inwards[node] = shares[node] * speed;
        backwards[node] = -inwards[node];
    }
    check(perion_simulation_prescribe_table(bar, "left", PERION_QUANTITY_VELOCITY, 0, NODES, times,
                                            inwards));
    check(perion_simulation_prescribe_table(bar, "right", PERION_QUANTITY_VELOCITY, 0, NODES, times,
                                            backwards));
    check(perion_simulation_prescribe(bar, "left", PERION_QUANTITY_VELOCITY, 1, 0.0));
    check(perion_simulation_prescribe(bar, "right", PERION_QUANTITY_VELOCITY, 1, 0.0));

    /* Stepping, with a look at the bar 200 times. A tenth of the step that is stable now is kept back,
     * since bonds on the outer side become stiffer. */
    check(perion_simulation_stable_time_step(bar, &stable));
    const double interval = duration / RECORDS;
    const int64_t steps = (int64_t)ceil(interval / (0.9 * stable));
    printf("%lld points, %lld steps of %.4f us\n", (long long)count, (long long)(RECORDS * steps),
           1e6 * interval / (double)steps);
    printf("   time ms  shortening mm  height mm    force N  elastic J\n");
    perion_energy_init(&energy, sizeof(perion_energy));
    double *positions = room(3 * count, sizeof *positions);
    for (int number = 1; number <= RECORDS; ++number) {
        record *now = &curve[number - 1];
        double time, force[3];
        check(perion_simulation_step(bar, interval / (double)steps, steps));
        check(perion_simulation_get(bar, PERION_FIELD_POSITION, positions, 3 * count));
        check(perion_simulation_sum(bar, PERION_FIELD_REACTION, "left", force));
        check(perion_simulation_energy(bar, &energy));
        now->shortening = 2 * (mean(positions, across, left, 0) - start);
        now->height =
            mean(positions, section_count, middle, 1) - mean(positions, across, left, 1);
        now->force = force[0];
        if (number % 10 == 0) {
            check(perion_simulation_time(bar, &time));
            printf("%10.3f %14.4f %10.4f %10.3f %10.5f\n", 1e3 * time, 1e3 * now->shortening,
                   1e3 * now->height, now->force, energy.elastic);
            if (series[0] != '\0')
                check(perion_simulation_write_series(bar, series, sizeof fields / sizeof fields[0],
                                                     fields));
        }
    }

    /* Results. */
    const record *last = &curve[RECORDS - 1];
    perion_health_init(&health, sizeof(perion_health));
    check(perion_simulation_health(bar, &health));
    printf("stiffness below %10.4f N m2\n", stiffness);
    printf("  material      %10.4f N m2\n", material_stiffness);
    printf("shortening      %10.4f mm\n", 1e3 * last->shortening);
    printf("height          %10.4f mm\n", 1e3 * last->height);
    printf("force           %10.3f N\n", last->force);
    printf("least stretch   %10.5f\n", health.smallest_stretch);
    printf("kinetic energy  %10.4f %% of the elastic energy\n",
           100 * energy.kinetic / energy.elastic);
    printf("closure error   %10.4f %% of the work\n",
           100 * energy.closure_error / energy.external_work);
    hash = hash_field(hash, bar, PERION_FIELD_DISPLACEMENT, 3 * count);
    hash = hash_field(hash, bar, PERION_FIELD_VELOCITY, 3 * count);
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (path[0] != '\0')
        write_curve(path, curve);

    free(positions);
    free(middle);
    free(left);
    free(places);
    check(perion_simulation_destroy(&bar));
    return 0;
}
