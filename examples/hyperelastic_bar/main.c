/*
 * A bar of a hyperelastic material is drawn out: the total and the updated Lagrangian form against the exact answer.
 *
 * After Bergel and Li 2016, example II: a bar of 0.1 x 0.1 x 1 with lambda = 200 and mu = 20 of Saint Venant
 * and Kirchhoff, held along its axis at the bottom, under a traction at the top. A stretch of 1 + s needs
 * the traction E s (1 + s)(1 + s/2): the displacement of 0.01 that the paper compares with belongs to 0.590575. The
 * traction of 14 that it names belongs to 0.1857.
 *
 * The weak forms are solved: the strong ones leave no surface free of traction. The layer that is held lies
 * outside the length, so that it and the last layer are a length apart.
 *
 * Usage: hyperelastic_bar [traction, 0.590575] [points across, 5] [loads on the way, 4]
 *                         [curves, hyperelastic_bar_c.csv] [output files, hyperelastic_bar_c]
 *
 * In order: points and sets, then for each formulation: model, simulation, conditions, equilibria, a file.
 * Numbers have no units. The same program stands beside this one in Fortran and in Rust; all three print the same
 * hash.
 */
#include <perion.h>

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FORMS = 2, MOST = 100 };

static const double lambda = 200.0, mu = 20.0, density = 1.4;
static const double width = 0.1, length = 1.0;
static const char *const forms[FORMS] = {"total_lagrangian", "updated_lagrangian"};

/* Every call that can fail returns a status; the text says what went wrong and what to do. */
static void check(perion_status status)
{
    if (status != PERION_OK) {
        fprintf(stderr, "%s: %s\n", perion_status_string(status), perion_last_error());
        exit(1);
    }
}

/* The points: a block, its axis the z axis. */
static perion_points *column(int across)
{
    const double h = width / across;
    const double lower[] = {0.0, 0.0, -h}, upper[] = {width, width, length};
    const double floor[] = {width, width, 0.0}, ceiling[] = {0.0, 0.0, length - h};
    const double corner[] = {h, h, 0.0}, other[] = {width - h, 0.0, -h}, guide[] = {width, h, 0.0};
    perion_points *points = NULL;

    check(perion_points_create_block(3, lower, upper, h, &points));
    check(perion_points_add_set_box(points, "bottom", lower, floor));
    check(perion_points_add_set_box(points, "top", ceiling, upper));
    check(perion_points_add_set_box(points, "pin", lower, corner));
    check(perion_points_add_set_box(points, "guide", other, guide));
    return points;
}

/* The displacement of the top, exactly. */
static double exact(double modulus, double traction)
{
    double s = 0.0;

    for (int k = 0; k < 50; ++k)
        s -= (modulus * s * (1.0 + s) * (1.0 + 0.5 * s) - traction)
             / (modulus * (1.0 + 3.0 * s + 1.5 * s * s));
    return length * s;
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

/* A row for each load; the first line names the columns. */
static void write_curves(const char *path, double traction, int loads,
                         double tops[FORMS][MOST + 1], const double *answers)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "traction,total Lagrangian,updated Lagrangian,exact\n");
    for (int k = 0; k <= loads; ++k)
        fprintf(file, "%10.6f,%11.7f,%11.7f,%11.7f\n", traction * k / loads, tops[0][k], tops[1][k],
                answers[k]);
    if (fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

int main(int argc, char **argv)
{
    const double traction = argc > 1 ? atof(argv[1]) : 0.590575;
    const int across = argc > 2 ? atoi(argv[2]) : 5;
    const int loads = argc > 3 ? atoi(argv[3]) : 4;
    const char *curves = argc > 4 ? argv[4] : "hyperelastic_bar_c.csv";
    const char *files = argc > 5 ? argv[5] : "hyperelastic_bar_c";
    const double modulus = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
    double tops[FORMS][MOST + 1] = {{0.0}}, answers[MOST + 1] = {0.0};
    int64_t count, size, hash = 0;

    if (!(traction > 0.0) || across < 3 || loads < 1 || loads > MOST) {
        fprintf(stderr, "a traction above 0, at least 3 points across and 1 to %d loads are needed\n",
                MOST);
        return 1;
    }
    perion_points *points = column(across);
    check(perion_points_count(points, &count));
    check(perion_points_set_size(points, "top", &size));
    printf("%lld points, a traction of %9.6f\n", (long long)count, traction);
    for (int k = 1; k <= loads; ++k)
        answers[k] = exact(modulus, traction * k / loads);

    for (int form = 0; form < FORMS; ++form) {
        perion_model *rubber = NULL;
        perion_simulation *bar = NULL;
        perion_solve_options options;
        perion_report report;
        int64_t forces = 0;

        check(perion_model_create(forms[form], &rubber));
        check(perion_model_set(rubber, "youngs_modulus", modulus));
        check(perion_model_set(rubber, "poissons_ratio", lambda / (2.0 * (lambda + mu))));
        check(perion_model_set(rubber, "density", density));
        check(perion_model_set(rubber, "horizon", 2.015 * (width / across)));
        check(perion_simulation_create(points, rubber, &bar));
        perion_model_destroy(&rubber);

        /* The bottom is free to narrow; single points keep the bar from moving as a whole. */
        check(perion_simulation_prescribe(bar, "bottom", PERION_QUANTITY_DISPLACEMENT, 2, 0.0));
        check(perion_simulation_prescribe(bar, "pin", PERION_QUANTITY_DISPLACEMENT, 0, 0.0));
        check(perion_simulation_prescribe(bar, "pin", PERION_QUANTITY_DISPLACEMENT, 1, 0.0));
        check(perion_simulation_prescribe(bar, "guide", PERION_QUANTITY_DISPLACEMENT, 1, 0.0));

        /* Equilibria under growing loads. */
        perion_solve_options_init(&options, sizeof(perion_solve_options));
        options.tolerance = 1e-6;
        for (int k = 1; k <= loads; ++k) {
            double moved[3];
            check(perion_simulation_prescribe(bar, "top", PERION_QUANTITY_TRACTION, 2,
                                              traction * k / loads));
            perion_report_init(&report, sizeof(perion_report));
            check(perion_simulation_solve(bar, &options, &report));
            forces += report.evaluations;
            check(perion_simulation_sum(bar, PERION_FIELD_DISPLACEMENT, "top", moved));
            tops[form][k] = moved[2] / (double)size;
        }
        printf("%-19s %10.6f %10.4f %% %6lld forces\n", forms[form], tops[form][loads],
               100.0 * (tops[form][loads] / answers[loads] - 1.0), (long long)forces);
        hash = hash_field(hash, bar, PERION_FIELD_DISPLACEMENT, 3 * count);
        if (files[0] != '\0') {
            const perion_field fields[] = {PERION_FIELD_DISPLACEMENT, PERION_FIELD_CAUCHY_STRESS};
            char path[600];
            snprintf(path, sizeof path, "%s_%s.vtu", files, forms[form]);
            check(perion_simulation_write_vtk(bar, path, 2, fields));
        }
        check(perion_simulation_destroy(&bar));
    }
    perion_points_destroy(&points);

    printf("exact               %10.6f\n", answers[loads]);
    printf("  linear            %10.6f\n", length * traction / modulus);
    printf("Young's modulus     %10.6f\n", modulus);
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (curves[0] != '\0')
        write_curves(curves, traction, loads, tops, answers);
    return 0;
}
