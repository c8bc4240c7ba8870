/*
 * A material of the host's own: a viscoelastic bar is stretched and held, and its force relaxes.
 *
 * The law is a standard linear solid. Beside Saint Venant and Kirchhoff's stress S(E) a second one, Q,
 * grows with it and fades: dQ/dt = g dS/dt - Q/tau. Q is what the material remembers: 6 numbers at each
 * point. All of its stress fades alike, so that equilibrium stays where it is while the bar is held, and
 * the force follows exp(-t/tau) whatever the shape of the body.
 *
 * Usage: own_material [points along the bar, 20] [output file, own_material_c.csv]
 *
 * A law is told deformations, not the time between them: the host, which chooses the time step, tells it
 * that. While it only looks, no time passes. Units are mm, ms and g, and so MPa, N and mJ. The same
 * program stands beside this one in Fortran and in Rust; all three print the same hash.
 */
#include <perion.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RECORDS = 240, STATE = 6 };

/* Every call that can fail returns a status; the text says what went wrong and what to do. */
static void check(perion_status status)
{
    if (status != PERION_OK) {
        fprintf(stderr, "%s: %s\n", perion_status_string(status), perion_last_error());
        exit(1);
    }
}

/* The law: stiffness when all has faded, how much more there is at first, and how long it takes. */
typedef struct solid {
    double lambda, mu;       /* MPa */
    double share;            /* g */
    double relaxation_time;  /* tau, ms */
    double time_step;        /* ms, from the last completed step to the one asked about; 0: none */
} solid;

/* Where a symmetric tensor has its components: 11, 22, 33, 23, 13, 12. */
static const int row[STATE] = {0, 1, 2, 1, 0, 0}, column[STATE] = {0, 1, 2, 2, 2, 1};

/* Second Piola-Kirchhoff stress of Saint Venant and Kirchhoff, and its energy. */
static double elastic(const solid *own, const double F[9], double S[STATE])
{
    double E[STATE], squares = 0;

    for (int c = 0; c < STATE; ++c) {
        double product = 0;
        for (int k = 0; k < 3; ++k)
            product += F[3 * k + row[c]] * F[3 * k + column[c]];
        E[c] = 0.5 * (product - (c < 3 ? 1 : 0));
        squares += (c < 3 ? 1 : 2) * E[c] * E[c];
    }
    const double trace = E[0] + E[1] + E[2];
    for (int c = 0; c < STATE; ++c)
        S[c] = 2 * own->mu * E[c] + (c < 3 ? own->lambda * trace : 0);
    return 0.5 * own->lambda * trace * trace + own->mu * squares;
}

/* The energy in the springs of Q: half of Q on the strain that C makes of it, over g. */
static double fading_energy(const solid *own, const double Q[STATE])
{
    const double trace = Q[0] + Q[1] + Q[2];
    double squares = 0;

    for (int c = 0; c < STATE; ++c)
        squares += (c < 3 ? 1 : 2) * Q[c] * Q[c];
    return (squares - own->lambda / (3 * own->lambda + 2 * own->mu) * trace * trace)
           / (4 * own->mu * own->share);
}

/* Answers deformation gradients: by the trapezoidal rule over a step. */
static int answer(void *user, int64_t count, const double *F0, const double *F1, const double *state0,
                  double *state1, double *P, double *W)
{
    const solid *own = user;
    const double half = 0.5 * own->time_step / own->relaxation_time;

    for (int64_t place = 0; place < count; ++place) {
        const double *F = F1 + 9 * place, *old = state0 + STATE * place;
        double *Q = state1 + STATE * place;
        double before[STATE], S[STATE], whole[9];
        elastic(own, F0 + 9 * place, before);
        W[place] = elastic(own, F, S);
        for (int c = 0; c < STATE; ++c) {
            Q[c] = ((1 - half) * old[c] + own->share * (S[c] - before[c])) / (1 + half);
            whole[3 * row[c] + column[c]] = whole[3 * column[c] + row[c]] = S[c] + Q[c];
        }
        W[place] += fading_energy(own, Q);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                double sum = 0;
                for (int k = 0; k < 3; ++k)
                    sum += F[3 * i + k] * whole[3 * k + j];
                P[9 * place + 3 * i + j] = sum;
            }
    }
    return 0;
}

static void write_curve(const char *path, const double *forces, const double *expected, double interval)
{
    FILE *file = fopen(path, "w");

    if (file == NULL) {
        perror(path);
        exit(1);
    }
    fprintf(file, "time (ms),force (N),closed form (N)\n");
    for (int record = 0; record <= RECORDS; ++record)
        fprintf(file, "%8.4f,%9.4f,%9.4f\n", interval * record, forces[record], expected[record]);
    if (fclose(file) != 0) {
        perror(path);
        exit(1);
    }
}

/* A fingerprint of the bits of a field. */
static int64_t hash_field(int64_t hash, const perion_simulation *simulation, perion_field field,
                          int64_t length)
{
    double *values = calloc((size_t)length, sizeof *values);

    if (values == NULL) {
        fprintf(stderr, "there is no memory for %lld numbers\n", (long long)length);
        exit(1);
    }
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
    const double density = 1.2e-3, modulus = 1000, ratio = 0.3; /* g/mm3, MPa */
    const double share = 1, relaxation_time = 0.5;              /* ms */
    const double ramp = 0.5, end_time = 2;                      /* ms */
    const double across = 4, grip = 2, strain = 0.01;           /* mm, mm */
    const int along = argc > 1 ? atoi(argv[1]) : 20;
    const char *curve = argc > 2 ? argv[2] : "own_material_c.csv";

    perion_points *points = NULL;
    perion_model *model = NULL;
    perion_simulation *bar = NULL;
    perion_energy energy;
    double forces[RECORDS + 1] = {0}, expected[RECORDS + 1] = {0}, stable, reaction[3];
    int64_t count, hash = 0;

    if (along < 10) {
        fprintf(stderr, "at least 10 points along the bar are needed\n");
        return 1;
    }

    /* The points: a block with a grip at each end. */
    const double length = along;
    const double lower[] = {0, 0, 0}, upper[] = {length, across, across};
    const double left[] = {grip, across, across}, right[] = {length - grip, 0, 0};
    check(perion_points_create_block(3, lower, upper, 1, &points));
    check(perion_points_add_set_box(points, "left", lower, left));
    check(perion_points_add_set_box(points, "right", right, upper));
    check(perion_points_count(points, &count));

    /* The material: a formulation that asks a law at its points, and the law. The library itself needs the
     * constants, too. */
    solid own = {0};
    own.mu = modulus / (2 * (1 + ratio));
    own.lambda = 2 * own.mu * ratio / (1 - 2 * ratio);
    own.share = share;
    own.relaxation_time = relaxation_time;
    check(perion_model_create("correspondence", &model));
    check(perion_model_set(model, "density", density));
    check(perion_model_set(model, "youngs_modulus", modulus));
    check(perion_model_set(model, "poissons_ratio", ratio));
    check(perion_model_set(model, "horizon", 2.1));
    check(perion_model_set_material_function(model, STATE, answer, &own));
    check(perion_simulation_create(points, model, &bar));
    perion_points_destroy(&points);
    perion_model_destroy(&model);

    /* The right grip starts and stops smoothly: its velocity is a triangle over time. */
    const double pull = strain * (length - 2 * grip);
    const double times[] = {0, 0.5 * ramp, ramp}, speeds[] = {0, 2 * pull / ramp, 0};
    check(perion_simulation_prescribe(bar, "left", PERION_QUANTITY_DISPLACEMENT, 0, 0));
    check(perion_simulation_prescribe_table(bar, "right", PERION_QUANTITY_VELOCITY, 0, 3, times, speeds));

    /* No time has passed yet: the law is at its stiffest. From then on it knows the step. */
    check(perion_simulation_stable_time_step(bar, &stable));
    const double interval = end_time / RECORDS;
    const int64_t steps = (int64_t)ceil(interval / (0.9 * stable));
    printf("%lld points, %lld steps of %.4f us\n", (long long)count, (long long)(RECORDS * steps),
           1e3 * interval / (double)steps);
    own.time_step = interval / (double)steps;
    for (int record = 1; record <= RECORDS; ++record) {
        check(perion_simulation_step(bar, interval / (double)steps, steps));
        check(perion_simulation_sum(bar, PERION_FIELD_REACTION, "right", reaction));
        forces[record] = reaction[0];
    }
    own.time_step = 0;

    /* Results: while the bar is held, its force is that of the elastic bar times 1 + g c exp(-t/tau), where
     * c is what the pull has left of Q. The last record says what the elastic bar bears. */
    const double x = 0.5 * ramp / relaxation_time;
    const double left_over = share * pow((1 - exp(-x)) / x, 2);
    const double faded = 1 + left_over * exp((ramp - end_time) / relaxation_time);
    const double bearing = forces[RECORDS] / faded;
    const int held = (int)(ramp / interval + 0.5);
    double worst = 0;
    for (int record = 0; record <= RECORDS; ++record) {
        const double since = interval * record - ramp;
        expected[record] = record < held ? forces[record]
                                         : bearing * (1 + left_over * exp(-since / relaxation_time));
        worst = fmax(worst, fabs(forces[record] - expected[record]) / bearing);
    }
    perion_energy_init(&energy, sizeof(perion_energy));
    check(perion_simulation_energy(bar, &energy));
    printf("force at first  %10.4f N\n", forces[held]);
    printf("force at last   %10.4f N\n", forces[RECORDS]);
    printf("E A strain      %10.4f N\n", modulus * across * across * strain);
    printf("off exp(-t/tau) %10.4f %%\n", 100 * worst);
    printf("work            %10.4f mJ\n", energy.external_work);
    printf("stored          %10.4f mJ\n", energy.elastic);
    /* What the dashpots took is not known to the library: to it that is energy that went missing. */
    printf("in the dashpots %10.4f mJ\n", -energy.closure_error);
    hash = hash_field(hash, bar, PERION_FIELD_DISPLACEMENT, 3 * count);
    hash = hash_field(hash, bar, PERION_FIELD_VELOCITY, 3 * count);
    printf("hash            %010llX\n", (unsigned long long)hash);
    if (curve[0] != '\0')
        write_curve(curve, forces, expected, interval);

    check(perion_simulation_destroy(&bar));
    return 0;
}
