/* Equilibria: a bar is pulled, solved and relaxed, and what cannot stand is told. */
#include "harness.h"
#include "scene.h"

#include <math.h>
#include <string.h>

/* The bar of the scene, which cannot break, its left end held, its right end under a traction. */
static perion_simulation *pulled(double traction)
{
    perion_points *points = scene_points();
    perion_model *model = scene_model();
    perion_simulation *simulation = NULL;

    EXPECT_OK(perion_model_choose(model, "damage", "none"));
    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    for (int32_t axis = 0; axis < 3; ++axis)
        EXPECT_OK(perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_DISPLACEMENT, axis, 0.0));
    EXPECT_OK(perion_simulation_prescribe(simulation, "right", PERION_QUANTITY_TRACTION, 0, traction));
    EXPECT_OK(perion_points_destroy(&points));
    EXPECT_OK(perion_model_destroy(&model));
    return simulation;
}

static double end_of(const perion_simulation *simulation)
{
    double sum[3] = {0.0, 0.0, 0.0};

    EXPECT_OK(perion_simulation_sum(simulation, PERION_FIELD_DISPLACEMENT, "right", sum));
    return sum[0] / SCENE_LAYER;
}

static void solved_and_relaxed_bars_agree(void)
{
    perion_simulation *solved = pulled(1e-3), *relaxed = pulled(1e-3);
    perion_relax_options options;
    perion_report report;
    double residuals[8], energies[4000], reaction[3] = {0.0, 0.0, 0.0};

    perion_report_init(&report, sizeof(perion_report));
    report.residuals_or_null = residuals;
    report.residual_capacity = 2;
    SEAL(residuals[2]);
    EXPECT_OK(perion_simulation_solve(solved, NULL, &report));
    EXPECT_INT(report.steps, 1);
    EXPECT(report.residual_count >= 2 && residuals[0] > residuals[1] && report.residual <= 1e-8);
    EXPECT_SEALED(residuals[2]);
    EXPECT(report.residuals_or_null == residuals && report.residual_capacity == 2);
    EXPECT(report.evaluations > 5 && report.evaluations < 200 && report.iterations >= 1);
    EXPECT_REAL(report.share, 1.0);
    EXPECT(fabs(report.external_work / report.elastic - 1.0) < 1e-2);
    EXPECT_OK(perion_simulation_sum(solved, PERION_FIELD_REACTION, "left", reaction));
    EXPECT(fabs(reaction[0] / (-1e-3 * SCENE_LAYER) - 1.0) < 1e-6);
    perion_relax_options_init(&options, sizeof(perion_relax_options));
    options.tolerance = 1e-9;
    report.residuals_or_null = NULL;
    report.energies_or_null = energies;
    report.residual_capacity = 4000;
    EXPECT_OK(perion_simulation_relax(relaxed, &options, &report));
    EXPECT(report.iterations > 50 && report.residual <= 1e-9);
    EXPECT(report.energies_or_null == energies);
    /* At rest, on its way, and next to rest. */
    EXPECT(report.residual_count > 50 && report.residual_count <= 4000);
    EXPECT_REAL(energies[0], 0.0);
    EXPECT(energies[1] > 0.5 && energies[report.residual_count - 1] <= 1e-9);
    EXPECT(fabs(end_of(relaxed) / end_of(solved) - 1.0) < 1e-6);
    EXPECT_OK(perion_simulation_destroy(&solved));
    EXPECT_OK(perion_simulation_destroy(&relaxed));
}

typedef struct heard {
    int calls, stop;
} heard;

static int listen(void *user, int64_t done, int64_t total, double time)
{
    heard *notes = (heard *)user;

    (void)done;
    (void)total;
    (void)time;
    return ++notes->calls == notes->stop;
}

static void load_steps_are_told_of_and_can_be_stopped(void)
{
    perion_simulation *simulation = pulled(1e-3);
    perion_solve_options options;
    perion_report report;
    heard notes = {0, 2};
    double half;

    perion_report_init(&report, sizeof(perion_report));
    perion_solve_options_init(&options, sizeof(perion_solve_options));
    options.load_steps = 4;
    EXPECT_OK(perion_simulation_set_progress(simulation, listen, &notes));
    EXPECT_REFUSED(PERION_ERROR_INTERRUPTED, "progress",
                   perion_simulation_solve(simulation, &options, &report));
    EXPECT_INT(report.steps, 2);
    EXPECT(report.share > 0.4 && report.share < 1.0);
    half = end_of(simulation);
    notes.stop = 0;
    EXPECT_OK(perion_simulation_solve(simulation, &options, &report));
    EXPECT(end_of(simulation) > half && report.steps >= 2);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void relaxing_is_told_of_and_can_be_stopped(void)
{
    perion_simulation *simulation = pulled(1e-3), *other = pulled(1e-3);
    perion_report report;
    heard notes = {0, 7};
    scene_state state;

    perion_report_init(&report, sizeof(perion_report));
    EXPECT_OK(perion_simulation_evaluate(simulation));
    state = scene_state_of(simulation);
    EXPECT_OK(perion_simulation_set_progress(simulation, listen, &notes));
    EXPECT_REFUSED(PERION_ERROR_INTERRUPTED, "progress",
                   perion_simulation_relax(simulation, NULL, &report));
    EXPECT_INT(report.steps, 0);
    EXPECT_INT(report.residual_count, 7);
    EXPECT(scene_is(&state, scene_state_of(simulation)));
    scene_state_free(&state);
    /* Watched or not, it is the same motion. */
    notes.calls = notes.stop = 0;
    EXPECT_OK(perion_simulation_relax(simulation, NULL, &report));
    EXPECT_INT(report.steps, 1);
    EXPECT_INT(notes.calls, report.iterations + 1);
    EXPECT_OK(perion_simulation_relax(other, NULL, NULL));
    EXPECT(end_of(simulation) == end_of(other));
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT_OK(perion_simulation_destroy(&other));
}

static void what_nothing_holds_is_told(void)
{
    perion_simulation *simulation = pulled(1e-3);
    perion_report report;
    scene_state state;

    perion_report_init(&report, sizeof(perion_report));
    for (int32_t axis = 0; axis < 3; ++axis)
        EXPECT_OK(perion_simulation_release(simulation, "left", PERION_QUANTITY_DISPLACEMENT, axis));
    EXPECT_OK(perion_simulation_evaluate(simulation));
    state = scene_state_of(simulation);
    EXPECT_REFUSED(PERION_ERROR_CONVERGENCE, "residuals",
                   perion_simulation_solve(simulation, NULL, &report));
    EXPECT_INT(report.steps, 0);
    EXPECT(report.cuts > 3 && report.residual_count > 3);
    EXPECT(scene_is(&state, scene_state_of(simulation)));
    scene_state_free(&state);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void areas_that_are_given_make_the_force(void)
{
    perion_simulation *simulation = pulled(1e-3);
    double areas[SCENE_LAYER], sum[3] = {0.0, 0.0, 0.0};

    for (int k = 0; k < SCENE_LAYER; ++k)
        areas[k] = 3.0;
    EXPECT_OK(perion_simulation_set_surface_areas(simulation, "right", SCENE_LAYER, areas));
    EXPECT_OK(perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_sum(simulation, PERION_FIELD_BODY_FORCE, NULL, sum));
    EXPECT(fabs(sum[0] / (3e-3 * SCENE_LAYER) - 1.0) < 1e-12);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

int main(void)
{
    harness_begin();
    solved_and_relaxed_bars_agree();
    load_steps_are_told_of_and_can_be_stopped();
    relaxing_is_told_of_and_can_be_stopped();
    what_nothing_holds_is_told();
    areas_that_are_given_make_the_force();
    return harness_end();
}
