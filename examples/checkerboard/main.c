/*
 * A checkerboard of displacements: which formulations see it, and what it costs in each.
 *
 * Points of a cube of steel are displaced so that the sign changes from point to point, by a thousandth
 * of their spacing: Partmann et al. 2026, section 4.4. A gradient averaged over a family does not see such
 * a mode, and the correspondence formulations store no energy in it, not even where a penalty resists it.
 * The bond-associated quadrature and bonds themselves do see it. The window in the middle, 40 points
 * along an edge in the paper, is two horizons from every face: all families that count there are full.
 *
 * Usage: checkerboard [points along the window, 16] [profile, checkerboard_c.csv]
 *                     [output files, checkerboard_c]
 *
 * In order: points, then for each formulation: model, simulation, a state set by hand, its fields, a
 * file. Nothing moves. Units are m, s and kg. The same program stands beside this one in Fortran and in
 * Rust; all three print the same hash.
 */
#include <perion.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Layers of points around the window: families reach three, and those of neighbours three more. */
enum { BUFFER = 6, FORMS = 7 };

static const char *const formulations[FORMS] = {
    "correspondence",
    "correspondence_silling",
    "correspondence_wan",
    "bond_associated_quadrature",
    "bond_associated_quadrature",
    "bond_associated_quadrature",
    "bond_based",
};
static const char *const influences[FORMS] = {
    "constant", "constant", "constant", "constant", "inverse", "cubic_spline", "",
};

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

/* A fingerprint of the bits of numbers. */
static int64_t hash_values(int64_t hash, const double *values, int64_t length)
{
    for (int64_t k = 0; k < length; ++k) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        hash = (hash * 65599 + (int64_t)(bits & 0xffffffffu)) % 1099511627689;
        hash = (hash * 65599 + (int64_t)(bits >> 32)) % 1099511627689;
    }
    return hash;
}

static void write_file(const perion_simulation *body, const char *files, int form)
{
    static const perion_field fields[] = {PERION_FIELD_STRAIN_ENERGY_DENSITY,
                                          PERION_FIELD_STABILIZATION_ENERGY_DENSITY,
                                          PERION_FIELD_DISPLACEMENT};
    const char *joint = influences[form][0] == '\0' ? "" : "_";
    char path[500];
    const int length = snprintf(path, sizeof path, "%s_%s%s%s.vtu", files, formulations[form],
                                joint, influences[form]);

    if (length < 0 || length >= (int)sizeof path) {
        fprintf(stderr, "'%s' is too long for the name of a file\n", files);
        exit(1);
    }
    check(perion_simulation_write_vtk(body, path, sizeof fields / sizeof fields[0], fields));
}

/* A row for each point on the line through the middle and a column for each formulation; the first line
 * names them. */
static void write_profile(const char *path, const double *profiles, int64_t size, double spacing)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "x (m)");
    for (int form = 0; form < FORMS; ++form)
        fprintf(file, ",%s %s (kJ/m3)", formulations[form], influences[form]);
    fprintf(file, "\n");
    for (int64_t point = 0; point < size; ++point) {
        fprintf(file, "%8.4f", (double)(point - size / 2) * spacing);
        for (int form = 0; form < FORMS; ++form)
            fprintf(file, ",%11.5f", 1e-3 * profiles[form * size + point]);
        fprintf(file, "\n");
    }
    if (fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

int main(int argc, char **argv)
{
    const double pi = 3.14159265358979323846;
    const double spacing = 0.025;             /* m */
    const double horizon = 3.015 * spacing;   /* m */
    const double amplitude = 1e-3 * spacing;  /* m */
    const int64_t window = argc > 1 ? atoi(argv[1]) : 16;
    const char *profile = argc > 2 ? argv[2] : "checkerboard_c.csv";
    const char *files = argc > 3 ? argv[3] : "checkerboard_c";
    const int64_t size = window + 2 * BUFFER, half = size / 2;

    perion_points *points = NULL;
    int64_t count, hash = 0;

    if (window < 2) {
        fprintf(stderr, "at least 2 points along the window are needed\n");
        return 1;
    }

    /* The points: a block that is shifted by half a spacing, so that coordinates are whole spacings. */
    const double face = -((double)half + 0.5) * spacing;
    const double far_face = face + (double)size * spacing;
    const double lower[] = {face, face, face}, upper[] = {far_face, far_face, far_face};
    check(perion_points_create_block(3, lower, upper, spacing, &points));
    check(perion_points_count(points, &count));
    printf("%lld points, %lld along the window\n", (long long)count, (long long)window);

    /* The displacement: each component alternates along the other two axes. */
    double *displacement = numbers(3 * count);
    check(perion_points_get_coordinates(points, displacement, 3 * count));
    for (int64_t point = 0; point < count; ++point) {
        double *u = &displacement[3 * point];
        const double x = cos(pi * u[0] / spacing);
        const double y = cos(pi * u[1] / spacing);
        const double z = cos(pi * u[2] / spacing);
        u[0] = amplitude * y * z;
        u[1] = amplitude * x * z;
        u[2] = amplitude * x * y;
    }

    printf("strain energy density in the window (kJ/m3)                     penalty\n");
    printf("                                          middle     least  greatest    middle\n");
    double *energy = numbers(count), *penalty = numbers(count);
    double *profiles = numbers(FORMS * size);
    for (int form = 0; form < FORMS; ++form) {
        perion_model *steel = NULL;
        perion_simulation *body = NULL;

        check(perion_model_create(formulations[form], &steel));
        check(perion_model_set(steel, "youngs_modulus", 210e9)); /* Pa */
        check(perion_model_set(steel, "density", 8000.0));       /* kg/m3 */
        check(perion_model_set(steel, "horizon", horizon));
        /* Bonds alone have Poisson's ratio 1/4, and no influence function. */
        if (influences[form][0] != '\0') {
            check(perion_model_set(steel, "poissons_ratio", 0.25));
            check(perion_model_choose(steel, "influence", influences[form]));
        }

        check(perion_simulation_create(points, steel, &body));
        check(perion_simulation_set(body, PERION_FIELD_DISPLACEMENT, displacement, 3 * count));
        check(perion_simulation_get(body, PERION_FIELD_STRAIN_ENERGY_DENSITY, energy, count));
        check(perion_simulation_get(body, PERION_FIELD_STABILIZATION_ENERGY_DENSITY, penalty,
                                    count));
        if (files[0] != '\0')
            write_file(body, files, form);
        check(perion_simulation_destroy(&body));
        check(perion_model_destroy(&steel));

        /* x runs fastest in a block of points, then y. */
        double least = INFINITY, greatest = 0.0;
        for (int64_t z = BUFFER; z < BUFFER + window; ++z)
            for (int64_t y = BUFFER; y < BUFFER + window; ++y)
                for (int64_t x = BUFFER; x < BUFFER + window; ++x) {
                    least = fmin(least, energy[x + size * (y + size * z)]);
                    greatest = fmax(greatest, energy[x + size * (y + size * z)]);
                }
        const int64_t line = size * (half + size * half), middle = line + half;
        memcpy(&profiles[form * size], &energy[line], (size_t)size * sizeof *energy);
        printf("%-26s %-12s%9.4f %9.4f %9.4f %9.4f\n", formulations[form], influences[form],
               1e-3 * energy[middle], 1e-3 * least, 1e-3 * greatest, 1e-3 * penalty[middle]);
        hash = hash_values(hash, energy, count);
        hash = hash_values(hash, penalty, count);
    }
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (profile[0] != '\0')
        write_profile(profile, profiles, size, spacing);

    free(profiles);
    free(penalty);
    free(energy);
    free(displacement);
    check(perion_points_destroy(&points));
    return 0;
}
