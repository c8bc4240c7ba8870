/*
 * A square of points without order is let go after a stretch: do they move as one?
 *
 * After Ganzenmueller, Hiermaier and May 2015, section 5.2.1: 444 points, each with its own horizon, the distance
 * of its twelfth neighbour; plane stress, E = 1, nu = 0.3, density 1. Both edges are stretched by 10 %, and the
 * square swings. A gradient averaged over a family says little about each bond of it, and so plain
 * correspondence falls into disorder in the first contraction. With a penalty, or at quadrature points on
 * bonds, the points keep their order.
 *
 * Disorder is measured by what is left of bonds when the gradient of their family has been taken out:
 * the root mean square of |eta - F xi| over that of the lengths of bonds.
 *
 * Usage: patch [points, examples/patch/points.txt] [records, 388; 30 make a contraction]
 *              [curves, patch_c.csv] [output files, patch_c]
 *
 * In order: points with horizons, then for each formulation: model, simulation, a state set by hand, step,
 * fields, a file. Numbers have no units. The same program stands beside this one in Fortran and in Rust; all three
 * print the same hash.
 */
#include <perion.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FORMS = 3, NEAREST = 12, STEPS = 10, CONTRACTIONS = 12 };

static const double modulus = 1.0, poissons_ratio = 0.3, density = 1.0, stretch = 0.1;
static const char *const forms[FORMS] = {
    "correspondence",
    "correspondence_wan",
    "bond_associated_quadrature",
};

/* What a formulation does. */
typedef struct swing {
    double *disorder; /* one a record */
    double contractions[CONTRACTIONS], drift;
    int count;
} swing;

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

static double squared_distance(const double *places, int64_t i, int64_t j)
{
    const double x = places[2 * j] - places[2 * i], y = places[2 * j + 1] - places[2 * i + 1];

    return x * x + y * y;
}

/* The twelve nearest of each point; the horizon is the distance of the last. */
static void find_nearest(int64_t count, const double *places, int64_t *nearest, double *horizons)
{
    for (int64_t i = 0; i < count; ++i) {
        double last = 0.0;
        for (int k = 0; k < NEAREST; ++k) {
            double least = INFINITY;
            for (int64_t j = 0; j < count; ++j) {
                const double square = squared_distance(places, i, j);
                if (square > last && square < least) {
                    least = square;
                    nearest[i * NEAREST + k] = j;
                }
            }
            last = least;
        }
        horizons[i] = sqrt(last);
    }
}

/* What is left of bonds without the gradients of their families, over their length. */
static double disorder_of(int64_t count, const double *places, const int64_t *nearest, const double *now,
                          const double *gradients)
{
    double left = 0.0, lengths = 0.0;

    for (int64_t i = 0; i < count; ++i)
        for (int k = 0; k < NEAREST; ++k) {
            const int64_t j = nearest[i * NEAREST + k];
            const double *F = &gradients[4 * i];
            const double x = places[2 * j] - places[2 * i], y = places[2 * j + 1] - places[2 * i + 1];
            const double right = now[2 * j] - now[2 * i] - F[0] * x - F[1] * y;
            const double up = now[2 * j + 1] - now[2 * i + 1] - F[2] * x - F[3] * y;
            left += right * right + up * up;
            lengths += x * x + y * y;
        }
    return sqrt(left / lengths);
}

/* Mean square distance from the middle of the square, which stays where it is. */
static double size_of(int64_t count, const double *now)
{
    double squares = 0.0, middle[2] = {0.0, 0.0};

    for (int64_t i = 0; i < count; ++i)
        for (int axis = 0; axis < 2; ++axis)
            middle[axis] += now[2 * i + axis] / (double)count;
    for (int64_t i = 0; i < count; ++i)
        for (int axis = 0; axis < 2; ++axis)
            squares += (now[2 * i + axis] - middle[axis]) * (now[2 * i + axis] - middle[axis]);
    return squares / (double)count;
}

/* Goes on with a fingerprint of the bits of a field. */
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

/* A row for each record; the first line names the formulations. */
static void write_curves(const char *path, int records, double interval, const swing *swings)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "time,%s,%s,%s\n", forms[0], forms[1], forms[2]);
    for (int record = 0; record < records; ++record)
        fprintf(file, "%9.5f,%9.5f,%9.5f,%9.5f\n", interval * (record + 1), swings[0].disorder[record],
                swings[1].disorder[record], swings[2].disorder[record]);
    if (fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

int main(int argc, char **argv)
{
    const char *cloud = argc > 1 ? argv[1] : "examples/patch/points.txt";
    const int records = argc > 2 ? atoi(argv[2]) : 388;
    const char *curves = argc > 3 ? argv[3] : "patch_c.csv";
    const char *files = argc > 4 ? argv[4] : "patch_c";
    perion_points *points = NULL;
    int64_t count, hash = 0;
    swing swings[FORMS] = {{0}};

    if (records < 1) {
        fprintf(stderr, "at least one record is needed\n");
        return 1;
    }

    /* The points, with their areas, and the horizon of each. */
    check(perion_points_read(cloud, &points));
    check(perion_points_count(points, &count));
    double *places = room(2 * count, sizeof *places), *horizons = room(count, sizeof *horizons);
    double *displacement = room(2 * count, sizeof *displacement), *now = room(2 * count, sizeof *now);
    double *gradients = room(4 * count, sizeof *gradients), *areas = room(count, sizeof *areas);
    int64_t *nearest = room(NEAREST * count, sizeof *nearest);
    check(perion_points_get_coordinates(points, places, 2 * count));
    check(perion_points_get_volumes(points, areas, count));
    find_nearest(count, places, nearest, horizons);
    check(perion_points_set_horizons(points, count, horizons));

    /* A fifth of the time that a wave takes through the smallest area; speed of a wave in a plate. */
    const double wave_speed = sqrt(modulus / (1.0 - poissons_ratio * poissons_ratio) / density);
    double smallest = INFINITY;
    for (int64_t i = 0; i < count; ++i)
        smallest = fmin(smallest, areas[i]);
    const double time_step = 0.2 * sqrt(smallest) / wave_speed;
    printf("%lld points, %d steps of %.6f\n", (long long)count, records * STEPS, time_step);

    for (int form = 0; form < FORMS; ++form) {
        swing *one = &swings[form];
        perion_model *plate = NULL;
        perion_simulation *body = NULL;
        perion_energy energy;
        double before = INFINITY, last = INFINITY, last_disorder = 0.0;

        check(perion_model_create(forms[form], &plate));
        check(perion_model_choose(plate, "plane", "stress"));
        check(perion_model_set(plate, "youngs_modulus", modulus));
        check(perion_model_set(plate, "poissons_ratio", poissons_ratio));
        check(perion_model_set(plate, "density", density));
        check(perion_simulation_create(points, plate, &body));
        perion_model_destroy(&plate);

        /* Stretched, and let go. */
        for (int64_t k = 0; k < 2 * count; ++k)
            displacement[k] = stretch * places[k];
        check(perion_simulation_set(body, PERION_FIELD_DISPLACEMENT, displacement, 2 * count));
        perion_energy_init(&energy, sizeof(perion_energy));
        check(perion_simulation_energy(body, &energy));
        const double given = energy.elastic;

        one->disorder = room(records, sizeof *one->disorder);
        for (int record = 0; record < records; ++record) {
            check(perion_simulation_step(body, time_step, STEPS));
            check(perion_simulation_get(body, PERION_FIELD_POSITION, now, 2 * count));
            check(perion_simulation_get(body, PERION_FIELD_DEFORMATION_GRADIENT, gradients, 4 * count));
            check(perion_simulation_energy(body, &energy));
            one->disorder[record] = disorder_of(count, places, nearest, now, gradients);
            one->drift = fmax(one->drift, fabs((energy.kinetic + energy.elastic) / given - 1.0));

            /* A contraction is where the square is smallest. */
            const double size = size_of(count, now);
            if (last < before && last < size && one->count < CONTRACTIONS) {
                if (one->count == 0 && files[0] != '\0') {
                    const perion_field fields[] = {PERION_FIELD_DISPLACEMENT,
                                                   PERION_FIELD_VON_MISES_STRESS};
                    char path[600];
                    snprintf(path, sizeof path, "%s_%s.vtu", files, forms[form]);
                    check(perion_simulation_write_vtk(body, path, 2, fields));
                }
                one->contractions[one->count++] = last_disorder;
            }
            before = last;
            last = size;
            last_disorder = one->disorder[record];
        }
        hash = hash_field(hash, body, PERION_FIELD_DISPLACEMENT, 2 * count);
        check(perion_simulation_destroy(&body));
    }

    /* Results. */
    printf("formulation                 contractions  disorder at the first   largest  energy drift\n");
    for (int form = 0; form < FORMS; ++form) {
        double largest = 0.0;
        for (int k = 0; k < swings[form].count; ++k)
            largest = fmax(largest, swings[form].contractions[k]);
        printf("%-26s %13d %22.4f %9.4f %13.6f\n", forms[form], swings[form].count,
               swings[form].contractions[0], largest, swings[form].drift);
    }
    printf("time            %10.5f\n", time_step * STEPS * records);
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (curves[0] != '\0')
        write_curves(curves, records, time_step * STEPS, swings);

    for (int form = 0; form < FORMS; ++form)
        free(swings[form].disorder);
    free(places);
    free(horizons);
    free(displacement);
    free(now);
    free(gradients);
    free(areas);
    free(nearest);
    perion_points_destroy(&points);
    return 0;
}
