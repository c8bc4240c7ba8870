/* Laws of the host's own: what they are asked, what they remember, and how they end a call. */
#include "harness.h"
#include "scene.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

enum { STEPS = 6, STATE = 2, MOST = 6 * 5 * 4 };

static const double youngs_modulus = 1.0, poissons_ratio = 0.3;

/* A law, and what it has been asked. */
typedef struct law {
    int dimension, strangers;
    int64_t calls, stop_at, spoil_at;
    pthread_t thread;
    /* Commits as the states of the last call count them: fewest and most. */
    double fewest, most;
    /* The first F0 of the last call. */
    double before[9];
} law;

static law law_of(int dimension)
{
    law made = {0};

    made.dimension = dimension;
    made.thread = pthread_self();
    return made;
}

/* Energy and first Piola-Kirchhoff stress F S of Saint Venant and Kirchhoff, as if held across in 2D. */
static double saint_venant_kirchhoff(int n, const double *F, double *P)
{
    const double mu = youngs_modulus / (2 * (1 + poissons_ratio));
    const double lambda = 2 * mu * poissons_ratio / (1 - 2 * poissons_ratio);
    double E[9], trace = 0.0, squares = 0.0;

    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            /* By H = F - I, so that small strains keep their digits. */
            double twice = F[n * i + j] + F[n * j + i] - (i == j ? 2.0 : 0.0);
            for (int k = 0; k < n; ++k)
                twice += (F[n * k + i] - (k == i)) * (F[n * k + j] - (k == j));
            E[n * i + j] = 0.5 * twice;
            squares += E[n * i + j] * E[n * i + j];
        }
    for (int i = 0; i < n; ++i)
        trace += E[n * i + i];
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            P[n * i + j] = lambda * trace * F[n * i + j];
            for (int k = 0; k < n; ++k)
                P[n * i + j] += 2 * mu * F[n * i + k] * E[n * k + j];
        }
    return 0.5 * lambda * trace * trace + mu * squares;
}

/* State: how often it was committed, and the largest energy there was. */
static int answer(void *user, int64_t count, const double *F0, const double *F1, const double *state0,
                  double *state1, double *P, double *W)
{
    law *own = user;
    const int n = own->dimension;

    if (!pthread_equal(own->thread, pthread_self()))
        ++own->strangers;
    own->fewest = own->most = state0[0];
    memcpy(own->before, F0, (size_t)(n * n) * sizeof *F0);
    for (int64_t k = 0; k < count; ++k) {
        W[k] = saint_venant_kirchhoff(n, F1 + n * n * k, P + n * n * k);
        EXPECT_REAL(state1[STATE * k], state0[STATE * k]);
        own->fewest = fmin(own->fewest, state0[STATE * k]);
        own->most = fmax(own->most, state0[STATE * k]);
        state1[STATE * k] += 1.0;
        state1[STATE * k + 1] = fmax(state0[STATE * k + 1], W[k]);
    }
    ++own->calls;
    if (own->calls == own->spoil_at)
        P[0] = NAN;
    return own->calls == own->stop_at ? -1 : 0;
}

/* Softens by the largest energy there was: half of the stiffness goes at W = 1e-3. */
static int soften(void *user, int64_t count, const double *F0, const double *F1, const double *state0,
                  double *state1, double *P, double *W)
{
    law *own = user;
    const int n = own->dimension, result = answer(user, count, F0, F1, state0, state1, P, W);

    for (int64_t k = 0; k < count; ++k) {
        const double left = 1.0 / (1.0 + 1e3 * state1[STATE * k + 1]);
        W[k] *= left;
        for (int c = 0; c < n * n; ++c)
            P[n * n * k + c] *= left;
    }
    return result;
}

static int say_nothing(void *user, int64_t count, const double *F0, const double *F1,
                       const double *state0, double *state1, double *P, double *W)
{
    law *own = user;

    (void)count;
    (void)F0;
    (void)F1;
    (void)state0;
    (void)state1;
    (void)P;
    (void)W;
    ++own->calls;
    return 0;
}

static perion_model *model_of(const char *formulation)
{
    perion_model *model = NULL;

    EXPECT_OK(perion_model_create(formulation, &model));
    EXPECT_OK(perion_model_set(model, "density", 1.0));
    EXPECT_OK(perion_model_set(model, "youngs_modulus", youngs_modulus));
    EXPECT_OK(perion_model_set(model, "poissons_ratio", poissons_ratio));
    EXPECT_OK(perion_model_set(model, "horizon", 2.1));
    return model;
}

/* A block in 3D or a plate in plane strain, sheared by waves; with the built-in law where none is given. */
static perion_simulation *waved(const char *formulation, int dimension, law *own)
{
    static const double lower[] = {0.0, 0.0, 0.0}, upper[] = {6.0, 5.0, 4.0};
    double places[3 * MOST], displacement[3 * MOST];
    perion_points *points = NULL;
    perion_model *model = model_of(formulation);
    perion_simulation *simulation = NULL;
    int64_t count = 0;

    EXPECT_OK(perion_points_create_block(dimension, lower, upper, 1.0, &points));
    EXPECT_OK(perion_points_count(points, &count));
    EXPECT_OK(perion_points_get_coordinates(points, places, count * dimension));
    if (own != NULL)
        EXPECT_OK(perion_model_set_material_function(model, STATE, answer, own));
    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    EXPECT_OK(perion_simulation_set_threads(simulation, 2));
    for (int64_t k = 0; k < count * dimension; ++k)
        displacement[k] = 0.1 * sin(1.7 * places[k] + 0.9 * (double)(k / dimension));
    EXPECT_OK(perion_simulation_set(simulation, PERION_FIELD_DISPLACEMENT, displacement,
                                    count * dimension));
    EXPECT_OK(perion_points_destroy(&points));
    EXPECT_OK(perion_model_destroy(&model));
    return simulation;
}

static double elastic_energy(const perion_simulation *simulation)
{
    perion_energy energy;

    perion_energy_init(&energy, sizeof(perion_energy));
    EXPECT_OK(perion_simulation_energy(simulation, &energy));
    return energy.elastic;
}

static void expect_as_built_in(const char *formulation, int dimension)
{
    double built_in[3 * MOST], by_host[3 * MOST], largest = 0.0, apart = 0.0;
    const int64_t numbers = dimension == 3 ? 3 * MOST : 2 * 6 * 5;
    law own = law_of(dimension);
    perion_simulation *one = waved(formulation, dimension, NULL);
    perion_simulation *other = waved(formulation, dimension, &own);

    EXPECT_OK(perion_simulation_evaluate(one));
    EXPECT_OK(perion_simulation_evaluate(other));
    EXPECT_OK(perion_simulation_get(one, PERION_FIELD_INTERNAL_FORCE, built_in, numbers));
    EXPECT_OK(perion_simulation_get(other, PERION_FIELD_INTERNAL_FORCE, by_host, numbers));
    for (int64_t k = 0; k < numbers; ++k) {
        largest = fmax(largest, fabs(built_in[k]));
        apart = fmax(apart, fabs(built_in[k] - by_host[k]));
    }
    /* F = I + H rounds strains of a tenth to some 1e-15 of them. */
    EXPECT(largest > 0.01 * youngs_modulus);
    EXPECT_NEAR(apart, 0.0, 1e-13 * largest);
    EXPECT_NEAR(elastic_energy(other), elastic_energy(one), 1e-13 * elastic_energy(one));
    EXPECT(own.calls > 0);
    EXPECT_INT(own.strangers, 0);
    if (dimension == 2) {
        EXPECT_REFUSED(PERION_ERROR_UNSUPPORTED, "material function",
                       perion_simulation_get(other, PERION_FIELD_STRESS_33, by_host, numbers / 2));
        EXPECT_REFUSED(PERION_ERROR_UNSUPPORTED, "material function",
                       perion_simulation_get(other, PERION_FIELD_VON_MISES_STRESS, by_host, numbers / 2));
    }
    EXPECT_OK(perion_simulation_destroy(&one));
    EXPECT_OK(perion_simulation_destroy(&other));
}

/* The states that the law is asked next have all seen so many commits. */
static void expect_commits(const perion_simulation *simulation, law *own, double commits)
{
    const int64_t calls = own->calls;

    elastic_energy(simulation);
    EXPECT(own->calls > calls);
    EXPECT_REAL(own->fewest, commits);
    EXPECT_REAL(own->most, commits);
}

static void states_are_kept_when_a_step_is_completed_or_committed(void)
{
    static double stress[9 * MOST];
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double before[9], stable = 0.0;
    law own = law_of(3);
    perion_simulation *simulation = waved("correspondence", 3, &own);

    EXPECT_OK(perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_CAUCHY_STRESS, stress, 9 * MOST));
    EXPECT_OK(perion_simulation_stable_time_step(simulation, &stable));
    expect_commits(simulation, &own, 0.0);
    EXPECT(memcmp(own.before, identity, sizeof identity) == 0);
    EXPECT_OK(perion_simulation_commit(simulation, 0.0));
    expect_commits(simulation, &own, 1.0);
    EXPECT(memcmp(own.before, identity, sizeof identity) != 0);
    memcpy(before, own.before, sizeof before);
    EXPECT_OK(perion_simulation_evaluate(simulation));
    expect_commits(simulation, &own, 1.0);
    EXPECT(memcmp(own.before, before, sizeof before) == 0);
    EXPECT_OK(perion_simulation_step(simulation, 0.25 * stable, STEPS));
    expect_commits(simulation, &own, 1.0 + STEPS);
    EXPECT(memcmp(own.before, before, sizeof before) != 0);
    EXPECT_INT(own.strangers, 0);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* The bar of the scene with a law that softens, as its bonds break. */
static perion_simulation *softening(law *own)
{
    perion_points *points = scene_points();
    perion_model *model = model_of("correspondence");
    perion_simulation *simulation = NULL;

    EXPECT_OK(perion_model_set(model, "critical_stretch", 0.05));
    EXPECT_OK(perion_model_set_material_function(model, STATE, soften, own));
    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    EXPECT_OK(perion_simulation_set_threads(simulation, 2));
    EXPECT_OK(perion_points_destroy(&points));
    EXPECT_OK(perion_model_destroy(&model));
    scene_throw(simulation);
    return simulation;
}

static void a_run_stopped_by_its_law_goes_on_as_if_it_had_not_been(void)
{
    static const int64_t stride = 19;
    law own = law_of(3);
    perion_simulation *simulation = softening(&own);
    scene_state wanted;
    perion_health health;
    int64_t calls, made = 0;

    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS));
    calls = own.calls;
    perion_health_init(&health, sizeof(perion_health));
    EXPECT_OK(perion_simulation_health(simulation, &health));
    EXPECT(health.broken_bonds > 0);
    wanted = scene_result_of(simulation);
    EXPECT_OK(perion_simulation_destroy(&simulation));
    /* Among the calls are those for the stable step, the forces, and what breaking bonds held. */
    for (int64_t stop = 1; stop <= calls; stop += stride) {
        own = law_of(3);
        own.stop_at = stop;
        simulation = softening(&own);
        EXPECT_REFUSED(PERION_ERROR_INTERRUPTED, "the material's function asked to stop",
                       perion_simulation_step(simulation, scene_time_step, STEPS));
        EXPECT_INT(own.calls, stop);
        EXPECT_OK(perion_simulation_step_count(simulation, &made));
        EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS - made));
        EXPECT(scene_is(&wanted, scene_result_of(simulation)));
        EXPECT_INT(own.strangers, 0);
        EXPECT_OK(perion_simulation_destroy(&simulation));
    }
    scene_state_free(&wanted);
}

/* The next call of the law ends what asks it, and all is as it was. */
#define STOPPED(call)                                                                  \
    do {                                                                               \
        own.stop_at = own.calls + 1;                                                   \
        EXPECT_REFUSED(PERION_ERROR_INTERRUPTED, "the material's function", call);     \
        EXPECT(scene_is(&state, scene_state_of(simulation)));                          \
    } while (0)

static void a_law_can_stop_whatever_asks_it(void)
{
    static double values[SCENE_ROOM];
    static const int64_t pair[] = {0, 1};
    const double half = 0.5;
    double stable = -1.0;
    perion_energy energy;
    law own = law_of(3);
    perion_simulation *simulation = softening(&own);
    scene_state state;

    perion_energy_init(&energy, sizeof(perion_energy));
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, STEPS));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, values, SCENE_LENGTH));
    values[0] += 0.01;
    EXPECT_OK(perion_simulation_set(simulation, PERION_FIELD_DISPLACEMENT, values, SCENE_LENGTH));
    state = scene_state_of(simulation);
    STOPPED(perion_simulation_evaluate(simulation));
    STOPPED(perion_simulation_energy(simulation, &energy));
    STOPPED(perion_simulation_stable_time_step(simulation, &stable));
    EXPECT_REAL(stable, -1.0);
    STOPPED(perion_simulation_get(simulation, PERION_FIELD_CAUCHY_STRESS, values, SCENE_ROOM));
    STOPPED(perion_simulation_get(simulation, PERION_FIELD_STRAIN_ENERGY_DENSITY, values, SCENE_COUNT));
    STOPPED(perion_simulation_commit(simulation, 0.0));
    STOPPED(perion_simulation_step(simulation, scene_time_step, 1));
    STOPPED(perion_simulation_get(simulation, PERION_FIELD_INTERNAL_FORCE, values, SCENE_LENGTH));
    STOPPED(perion_simulation_break_bonds(simulation, 1, pair));
    STOPPED(perion_simulation_set_bond_integrity(simulation, 1, pair, &half));
    /* Two batches say what the bonds held: this is the third, when the bond is weakened already. */
    own.stop_at = own.calls + 3;
    EXPECT_REFUSED(PERION_ERROR_INTERRUPTED, "the material's function",
                   perion_simulation_set_bond_integrity(simulation, 1, pair, &half));
    EXPECT(scene_is(&state, scene_state_of(simulation)));
    scene_state_free(&state);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void what_is_not_a_number_is_told_with_its_point(void)
{
    perion_points *points = scene_points();
    perion_model *model = model_of("correspondence");
    perion_simulation *simulation = NULL;
    law own = law_of(3);

    simulation = softening(&own);
    own.spoil_at = 1;
    EXPECT_REFUSED(PERION_ERROR_NUMERIC, "point", perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_destroy(&simulation));
    /* What a law leaves out is none. */
    EXPECT_OK(perion_model_set_material_function(model, 0, say_nothing, &own));
    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    EXPECT_REFUSED(PERION_ERROR_NUMERIC, "point 0", perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_points_destroy(&points));
}

int main(void)
{
    harness_begin();
    expect_as_built_in("correspondence", 3);
    expect_as_built_in("correspondence", 2);
    expect_as_built_in("bond_associated_quadrature", 3);
    expect_as_built_in("bond_associated_quadrature", 2);
    states_are_kept_when_a_step_is_completed_or_committed();
    a_run_stopped_by_its_law_goes_on_as_if_it_had_not_been();
    a_law_can_stop_whatever_asks_it();
    what_is_not_a_number_is_told_with_its_point();
    return harness_end();
}
