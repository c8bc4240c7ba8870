/*
 * A bar under a tension: by how much each formulation errs in its length, for horizons of 2 to 7 spacings.
 *
 * After Partmann et al. 2026, section 5.1: a bar of 100 x 10 x 10 mm, E = 210 GPa, nu = 1/4, bears 200 kN.
 * Points near a surface lack bonds, and so bond_based and ordinary_state_based make a bar too soft or too
 * stiff; the bond-associated quadrature does not. Bonds and the linear solid are compared with F L/(E A), the
 * laws of Saint Venant and Kirchhoff with the stretch l of l (l^2 - 1) = 2 F/(E A).
 *
 * The load is a body force on the last layer, and a horizon of layers outside the length is clamped, as in the
 * paper; or it is a traction on both ends of a bar of twice the length, which is held along its axis in the
 * middle alone, so that the solution is exact. Its length is then that from the middle to the last layer.
 *
 * Usage: traction_bar [points across, 5] [smallest horizon in spacings, 2] [largest, 3] [formulation, all]
 *                     [load: body_force or traction, body_force] [curves, traction_bar_c.csv]
 *
 * In order, for each formulation and horizon: points and sets, model, simulation, conditions, equilibrium,
 * results. Units are m, s and kg. The same program stands beside this one in Fortran and in Rust; all three
 * print the same hash.
 */
#include <perion.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FORMS = 4, MOST = 16 };

static const double length = 0.1, width = 0.01;   /* m */
static const double modulus = 210e9, force = 2e5; /* Pa, N */

/* A formulation, its influence function, its law. */
static const struct form {
    const char *formulation, *influence;
    int is_linear;
} forms[FORMS] = {
    {"bond_based", "", 1},
    {"ordinary_state_based", "inverse", 1},
    {"correspondence", "inverse", 0},
    {"bond_associated_quadrature", "cubic_spline", 0},
};

/* Every call that can fail returns a status; the text says what went wrong and what to do. */
static void check(perion_status status)
{
    if (status != PERION_OK) {
        fprintf(stderr, "%s: %s\n", perion_status_string(status), perion_last_error());
        exit(1);
    }
}

/* The points: a block, its axis the x axis. What is loaded and what is held are named. */
static perion_points *bar_of(int across, int ratio, int is_traction)
{
    const double h = width / across;
    perion_points *points = NULL;

    if (is_traction) {
        const double end = length + 0.5 * h, lower[] = {-end, 0.0, 0.0}, upper[] = {end, width, width};
        const double left[] = {h - end, width, width}, right[] = {end - h, 0.0, 0.0};
        const double middle[] = {-0.5 * h, 0.0, 0.0}, behind[] = {0.5 * h, width, width};
        const double pin[] = {0.5 * h, h, h};
        const double far[] = {-0.5 * h, width - h, 0.0}, corner[] = {0.5 * h, width, h};
        check(perion_points_create_block(3, lower, upper, h, &points));
        check(perion_points_add_set_box(points, "start", lower, left));
        check(perion_points_add_set_box(points, "end", right, upper));
        check(perion_points_add_set_box(points, "held", middle, behind));
        check(perion_points_add_set_box(points, "pin", middle, pin));
        check(perion_points_add_set_box(points, "guide", far, corner));
    } else {
        const double lower[] = {-ratio * h, 0.0, 0.0}, upper[] = {length, width, width};
        const double wall[] = {0.0, width, width}, right[] = {length - h, 0.0, 0.0};
        check(perion_points_create_block(3, lower, upper, h, &points));
        check(perion_points_add_set_box(points, "held", lower, wall));
        check(perion_points_add_set_box(points, "end", right, upper));
    }
    return points;
}

/* The conditions. */
static void load(perion_simulation *bar, int across, int is_traction)
{
    const double stress = force / (width * width), depth = width / across;

    check(perion_simulation_prescribe(bar, "held", PERION_QUANTITY_DISPLACEMENT, 0, 0.0));
    if (is_traction) {
        check(perion_simulation_prescribe(bar, "start", PERION_QUANTITY_TRACTION, 0, -stress));
        check(perion_simulation_prescribe(bar, "end", PERION_QUANTITY_TRACTION, 0, stress));
        /* Against rigid motion. */
        check(perion_simulation_prescribe(bar, "pin", PERION_QUANTITY_DISPLACEMENT, 1, 0.0));
        check(perion_simulation_prescribe(bar, "pin", PERION_QUANTITY_DISPLACEMENT, 2, 0.0));
        check(perion_simulation_prescribe(bar, "guide", PERION_QUANTITY_DISPLACEMENT, 2, 0.0));
    } else {
        check(perion_simulation_prescribe(bar, "held", PERION_QUANTITY_DISPLACEMENT, 1, 0.0));
        check(perion_simulation_prescribe(bar, "held", PERION_QUANTITY_DISPLACEMENT, 2, 0.0));
        check(perion_simulation_prescribe(bar, "end", PERION_QUANTITY_BODY_FORCE, 0, stress / depth));
    }
}

/* The length change of a bar in tension, exactly. */
static double exact(int is_linear)
{
    const double strain = force / (width * width) / modulus;
    double stretch = 1.0;

    if (is_linear)
        return length * strain;
    for (int k = 0; k < 20; ++k)
        stretch -= (stretch * (stretch * stretch - 1.0) - 2.0 * strain) / (3.0 * stretch * stretch - 1.0);
    return length * (stretch - 1.0);
}

/* Goes on with a fingerprint of the bits of a field. */
static int64_t hash_field(int64_t hash, const perion_simulation *simulation, perion_field field,
                          int64_t values_count)
{
    double *values = calloc((size_t)values_count, sizeof *values);

    if (values == NULL) {
        fprintf(stderr, "there is no memory for %lld numbers\n", (long long)values_count);
        exit(1);
    }
    check(perion_simulation_get(simulation, field, values, values_count));
    for (int64_t k = 0; k < values_count; ++k) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        hash = (hash * 65599 + (int64_t)(bits & 0xffffffffu)) % 1099511627689;
        hash = (hash * 65599 + (int64_t)(bits >> 32)) % 1099511627689;
    }
    free(values);
    return hash;
}

/* Solves one bar: its error in percent. */
static double solve(const struct form *form, int across, int ratio, int is_traction, int64_t *hash)
{
    perion_model *steel = NULL;
    perion_simulation *bar = NULL;
    perion_report report;
    perion_points *points = bar_of(across, ratio, is_traction);
    int64_t count, size;
    double moved[3];

    check(perion_points_count(points, &count));
    check(perion_points_set_size(points, "end", &size));

    check(perion_model_create(form->formulation, &steel));
    check(perion_model_set(steel, "youngs_modulus", modulus));
    check(perion_model_set(steel, "poissons_ratio", 0.25));
    check(perion_model_set(steel, "density", 7850.0)); /* kg/m3 */
    check(perion_model_set(steel, "horizon", 1.005 * ratio * (width / across)));
    if (form->influence[0] != '\0')
        check(perion_model_choose(steel, "influence", form->influence));
    check(perion_simulation_create(points, steel, &bar));
    perion_points_destroy(&points);
    perion_model_destroy(&steel);
    load(bar, across, is_traction);

    /* Equilibrium, by Newton's method. */
    perion_report_init(&report, sizeof(perion_report));
    check(perion_simulation_solve(bar, NULL, &report));

    check(perion_simulation_sum(bar, PERION_FIELD_DISPLACEMENT, "end", moved));
    const double error = 100.0 * (moved[0] / (double)size / exact(form->is_linear) - 1.0);
    printf("%7d %9lld  %-27s%11.4f %9lld\n", ratio, (long long)count, form->formulation, error,
           (long long)report.evaluations);
    fflush(stdout);
    *hash = hash_field(*hash, bar, PERION_FIELD_DISPLACEMENT, 3 * count);
    check(perion_simulation_destroy(&bar));
    return error;
}

/* A row for each horizon, a column for each formulation; the first line names them. */
static void write_curves(const char *path, double errors[][FORMS], const int *chosen, int first,
                         int last)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "horizon (spacings)");
    for (int k = 0; k < FORMS; ++k)
        if (chosen[k])
            fprintf(file, ",%s (%%)", forms[k].formulation);
    for (int ratio = first; ratio <= last; ++ratio) {
        fprintf(file, "\n%2d", ratio);
        for (int k = 0; k < FORMS; ++k)
            if (chosen[k])
                fprintf(file, ",%11.4f", errors[ratio][k]);
    }
    fprintf(file, "\n");
    if (fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

int main(int argc, char **argv)
{
    const int across = argc > 1 ? atoi(argv[1]) : 5;
    const int first = argc > 2 ? atoi(argv[2]) : 2, last = argc > 3 ? atoi(argv[3]) : 3;
    const char *formulation = argc > 4 ? argv[4] : "all";
    const int is_traction = argc > 5 && strcmp(argv[5], "traction") == 0;
    const char *curves = argc > 6 ? argv[6] : "traction_bar_c.csv";
    double errors[MOST + 1][FORMS];
    int chosen[FORMS], any = 0;
    int64_t hash = 0;

    for (int k = 0; k < FORMS; ++k) {
        chosen[k] = strcmp(formulation, "all") == 0 || strcmp(formulation, forms[k].formulation) == 0;
        any = any || chosen[k];
    }
    if (across < 2 || first < 1 || last < first || last > MOST || !any) {
        fprintf(stderr, "at least 2 points across, horizons from 1 to %d spacings and one of\n", MOST);
        for (int k = 0; k < FORMS; ++k)
            fprintf(stderr, "  %s\n", forms[k].formulation);
        return 1;
    }

    printf("%d points, that is so many across, %s\n", across,
           is_traction ? "under a traction" : "under a body force on the last layer");
    printf("horizon    points  formulation                    error %%    forces\n");
    for (int ratio = first; ratio <= last; ++ratio)
        for (int k = 0; k < FORMS; ++k)
            if (chosen[k])
                errors[ratio][k] = solve(&forms[k], across, ratio, is_traction, &hash);
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (curves[0] != '\0')
        write_curves(curves, errors, chosen, first, last);
    return 0;
}
