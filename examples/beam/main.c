/*
 * A beam is bent far: which formulations keep its points in line?
 *
 * After Ganzenmueller, Hiermaier and May 2015, section 5.3: E = 100 GPa, nu = 0.3, plane stress, the law of Saint Venant
 * and Kirchhoff; a beam of 8 x 1 mm is moved at its end by up to 8 mm. Where its supports are the text doesn't say. Here it
 * is half of a beam whose middle is moved across: the supports hold one point each at 8 mm from it, on the axis, which is
 * free to slide along and to turn.
 *
 * Points are out of line by their distance from the middle of their four neighbours, a root mean square over all
 * inside, in spacings. Affine motions have none of it, and a curvature k has k/4 (in 1 over spacings). Pairs of
 * points that move together, which a gradient averaged over a family does not see, have much.
 *
 * Each equilibrium is looked for by Newton's method, and from where that finds none by relaxation.
 *
 * Usage: beam [deflection in mm, 8] [points across, odd, 9] [steps, 10] [law, saint_venant_kirchhoff]
 *             [curves, beam_c.csv] [output files, beam_c]
 *
 * In order: points and sets, then for each formulation: model, simulation, conditions, equilibria, files. Units
 * are mm, N and MPa. The same program stands beside this one in Fortran and in Rust; all three print the same hash.
 */
#include <perion.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FORMS = 4, MOST = 99 };

static const double span = 16.0, height = 1.0;       /* mm */
static const double modulus = 1e5;                   /* MPa */
static const double poissons_ratio = 0.3;
static const double small = 0.01;                    /* mm, for the stiffness */

/* What is compared, and the influence functions. */
static const char *const forms[FORMS] = {"correspondence", "correspondence_silling", "correspondence_wan",
                                         "bond_associated_quadrature"};
static const char *const influences[FORMS] = {"constant", "constant", "constant", "cubic_spline"};

/* What a formulation makes of the beam. */
typedef struct beam {
    double stiffness; /* of a small deflection, over that of Timoshenko's beam */
    double solved_to; /* how far Newton's method came, in mm */
    double force;     /* what holds the middle at the end, in N */
    double out_of_line[MOST]; /* one a step, in spacings */
} beam;

/* Every call that can fail returns a status; the text says what went wrong and what to do. */
static void check(perion_status status)
{
    if (status != PERION_OK) {
        fprintf(stderr, "%s: %s\n", perion_status_string(status), perion_last_error());
        exit(1);
    }
}

/* The points: a block that has points at the supports and in the middle. */
static perion_points *lattice(double spacing)
{
    const double half = 0.5 * spacing, end = 0.5 * span + 0.5 * spacing, up = 0.5 * height;
    const double boxes[][4] = {
        {-half, -up, half, up},           {-half, -half, half, half}, {-end, -up, spacing - end, up},
        {end - spacing, -up, end, up},    {-end, -half, spacing - end, half},
        {end - spacing, -half, end, half},
    };
    const char *const names[] = {"middle", "axis", "start", "end", "left", "right"};
    const double lower[] = {-end, -up}, upper[] = {end, up};
    perion_points *points = NULL;

    check(perion_points_create_block(2, lower, upper, spacing, &points));
    for (int k = 0; k < 6; ++k)
        check(perion_points_add_set_box(points, names[k], &boxes[k][0], &boxes[k][2]));
    return points;
}

/* The mean displacement of a set across the beam. */
static double mean_across(const perion_points *points, const perion_simulation *body, const char *set)
{
    double moved[2];
    int64_t size;

    check(perion_points_set_size(points, set, &size));
    check(perion_simulation_sum(body, PERION_FIELD_DISPLACEMENT, set, moved));
    return moved[1] / (double)size;
}

/* What holds the middle. */
static double force_on(const perion_simulation *body)
{
    double reaction[2];

    check(perion_simulation_sum(body, PERION_FIELD_REACTION, "middle", reaction));
    return reaction[1];
}

/* Force over deflection of a beam that bends and shears, its shear factor that of a rectangle. */
static double timoshenko(void)
{
    const double inertia = height * height * height / 12.0;
    const double shear_factor = 10.0 * (1.0 + poissons_ratio) / (12.0 + 11.0 * poissons_ratio);
    const double shear_modulus = 0.5 * modulus / (1.0 + poissons_ratio);

    return 1.0 / (span * span * span / (48.0 * modulus * inertia)
                  + span / (4.0 * shear_factor * shear_modulus * height));
}

/* Moves the middle, by Newton's method or, where that has ended before, by relaxation. */
static void bend(const perion_points *points, perion_simulation *body, double deflection, beam *one)
{
    const double before = mean_across(points, body, "middle");

    check(perion_simulation_prescribe(body, "middle", PERION_QUANTITY_DISPLACEMENT, 1, deflection));
    if (one->solved_to == before) {
        perion_solve_options options;
        perion_status found;

        perion_solve_options_init(&options, sizeof(perion_solve_options));
        options.tolerance = 1e-6;
        options.smallest_load_step = 0.25;
        options.products = 500;
        found = perion_simulation_solve(body, &options, NULL);
        if (found != PERION_ERROR_CONVERGENCE)
            check(found);
        one->solved_to = mean_across(points, body, "middle");
        if (found == PERION_OK)
            return;
    }
    check(perion_simulation_relax(body, NULL, NULL));
}

/* How far points inside are from the middle of their four neighbours, a root mean square; x is fastest. */
static double out_of_line(const double *moved, int64_t along, int64_t across)
{
    double squares = 0.0;

    for (int64_t row = 1; row < across - 1; ++row)
        for (int64_t column = 1; column < along - 1; ++column)
            for (int axis = 0; axis < 2; ++axis) {
                const double *u = &moved[2 * (row * along + column) + axis];
                const double away = u[0] - 0.25 * (u[-2] + u[2] + u[-2 * along] + u[2 * along]);
                squares += away * away;
            }
    return sqrt(squares / (double)((across - 2) * (along - 2)));
}

/* Goes on with a fingerprint of the bits of numbers. */
static int64_t hash_values(int64_t hash, const double *values, int64_t count)
{
    for (int64_t k = 0; k < count; ++k) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        hash = (hash * 65599 + (int64_t)(bits & 0xffffffffu)) % 1099511627689;
        hash = (hash * 65599 + (int64_t)(bits >> 32)) % 1099511627689;
    }
    return hash;
}

/* A row for each deflection; the first line names the formulations. */
static void write_curves(const char *path, double deflection, int steps, const beam *beams)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "deflection (mm)");
    for (int form = 0; form < FORMS; ++form)
        fprintf(file, ",%s", forms[form]);
    for (int k = 1; k <= steps; ++k) {
        fprintf(file, "\n%8.4f", deflection * k / steps);
        for (int form = 0; form < FORMS; ++form)
            fprintf(file, ",%10.5f", beams[form].out_of_line[k - 1]);
    }
    fprintf(file, "\n");
    if (fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

int main(int argc, char **argv)
{
    const double deflection = argc > 1 ? atof(argv[1]) : 8.0;
    const int across = argc > 2 ? atoi(argv[2]) : 9;
    const int steps = argc > 3 ? atoi(argv[3]) : 10;
    const char *law = argc > 4 ? argv[4] : "saint_venant_kirchhoff";
    const char *curves = argc > 5 ? argv[5] : "beam_c.csv";
    const char *files = argc > 6 ? argv[6] : "beam_c";
    const int late = 4 * steps / 5; /* files are written here, and at the end */
    int64_t count, hash = 0;
    beam beams[FORMS] = {{0}};

    if (!(deflection > 0.0) || across < 5 || across % 2 != 1 || steps < 2 || steps > MOST) {
        fprintf(stderr, "a deflection above 0, an odd number of points across from 5 on and 2 to %d steps are needed\n",
                MOST);
        return 1;
    }
    const double spacing = height / across;
    perion_points *points = lattice(spacing);
    check(perion_points_count(points, &count));
    double *moved = calloc((size_t)(2 * count), sizeof *moved);
    if (moved == NULL) {
        fprintf(stderr, "there is no memory for %lld points\n", (long long)count);
        return 1;
    }
    printf("%lld points, %.3f mm in %d steps\n", (long long)count, deflection, steps);

    for (int form = 0; form < FORMS; ++form) {
        beam *one = &beams[form];
        perion_model *steel = NULL;
        perion_simulation *body = NULL;

        check(perion_model_create(forms[form], &steel));
        check(perion_model_choose(steel, "plane", "stress"));
        check(perion_model_choose(steel, "material", law));
        check(perion_model_choose(steel, "influence", influences[form]));
        check(perion_model_set(steel, "youngs_modulus", modulus));
        check(perion_model_set(steel, "poissons_ratio", poissons_ratio));
        check(perion_model_set(steel, "density", 7.85e-9)); /* t/mm3 */
        check(perion_model_set(steel, "horizon", 3.015 * spacing));
        check(perion_simulation_create(points, steel, &body));
        perion_model_destroy(&steel);
        check(perion_simulation_prescribe(body, "left", PERION_QUANTITY_DISPLACEMENT, 1, 0.0));
        check(perion_simulation_prescribe(body, "right", PERION_QUANTITY_DISPLACEMENT, 1, 0.0));
        check(perion_simulation_prescribe(body, "axis", PERION_QUANTITY_DISPLACEMENT, 0, 0.0));

        bend(points, body, small, one);
        const double bent = mean_across(points, body, "middle")
                            - 0.5 * (mean_across(points, body, "start") + mean_across(points, body, "end"));
        one->stiffness = force_on(body) / bent / timoshenko();
        for (int k = 1; k <= steps; ++k) {
            bend(points, body, deflection * k / steps, one);
            check(perion_simulation_get(body, PERION_FIELD_DISPLACEMENT, moved, 2 * count));
            one->out_of_line[k - 1] = out_of_line(moved, count / across, across) / spacing;
            if (files[0] != '\0' && (k == late || k == steps)) {
                const perion_field fields[] = {PERION_FIELD_DISPLACEMENT, PERION_FIELD_STRAIN};
                char path[600];
                snprintf(path, sizeof path, "%s_%s_%02d.vtu", files, forms[form], k);
                check(perion_simulation_write_vtk(body, path, 2, fields));
            }
        }
        one->force = force_on(body);
        hash = hash_values(hash, moved, 2 * count);
        check(perion_simulation_destroy(&body));
    }
    perion_points_destroy(&points);
    free(moved);

    /* Results. */
    printf("formulation                 stiffness  solved to    force  out of line  at the end\n");
    for (int form = 0; form < FORMS; ++form)
        printf("%-26s %10.4f %10.3f %8.0f %12.4f %11.4f\n", forms[form], beams[form].stiffness,
               beams[form].solved_to, beams[form].force, beams[form].out_of_line[late - 1],
               beams[form].out_of_line[steps - 1]);
    printf("out of line at  %10.3f\n", deflection * late / steps);
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (curves[0] != '\0')
        write_curves(curves, deflection, steps, beams);
    return 0;
}
