/* Bad inputs to the search for equilibrium. */
#include "bad.h"

#define state_of scene_state_of

static void solving_is_of_sensible_options(perion_simulation *simulation)
{
    static const double shares[] = {-0.1, 1.000001, NAN, INFINITY, -INFINITY};
    static const double ends[] = {-1.0, NAN, INFINITY, -INFINITY};
    perion_solve_options options;
    perion_report report;
    double residuals[4];
    scene_state state = state_of(simulation);

    SEAL(report);
    report.struct_size = sizeof report;
    report.residuals_or_null = NULL;
    report.energies_or_null = NULL;
    for (int k = 0; k < 5; ++k) {
        perion_solve_options_init(&options, sizeof(perion_solve_options));
        options.tolerance = shares[k];
        REFUSE(ARGUMENT, "tolerance", perion_simulation_solve(simulation, &options, &report));
        options.tolerance = 0.0;
        options.smallest_load_step = shares[k];
        REFUSE(ARGUMENT, "smallest_load_step", perion_simulation_solve(simulation, &options, &report));
    }
    for (int k = 0; k < 4; ++k) {
        perion_solve_options_init(&options, sizeof(perion_solve_options));
        options.time_end = ends[k];
        REFUSE(ARGUMENT, "time_end", perion_simulation_solve(simulation, &options, &report));
    }
#define NO_COUNT(member)                                                                   \
    do {                                                                                   \
        perion_solve_options_init(&options, sizeof(perion_solve_options));                 \
        options.member = -1;                                                               \
        REFUSE(ARGUMENT, #member, perion_simulation_solve(simulation, &options, &report)); \
    } while (0)
    NO_COUNT(load_steps);
    NO_COUNT(iterations);
    NO_COUNT(products);
    NO_COUNT(breaks);
    NO_COUNT(krylov);
    NO_COUNT(preconditioner);
    perion_solve_options_init(&options, sizeof(perion_solve_options));
    options.krylov = 4;
    REFUSE(ARGUMENT, "krylov", perion_simulation_solve(simulation, &options, &report));
    options.krylov = 0;
    options.preconditioner = 3;
    REFUSE(ARGUMENT, "preconditioner", perion_simulation_solve(simulation, &options, &report));
    options.struct_size = 0;
    REFUSE(ARGUMENT, "struct_size of 'solve_options'",
           perion_simulation_solve(simulation, &options, &report));
    EXPECT_SEALED(report.steps);
    report.residuals_or_null = residuals;
    report.residual_capacity = -1;
    REFUSE(ARGUMENT, "residual_capacity", perion_simulation_solve(simulation, NULL, &report));
    report.residuals_or_null = NULL;
    report.energies_or_null = residuals;
    REFUSE(ARGUMENT, "residual_capacity", perion_simulation_relax(simulation, NULL, &report));
    EXPECT_SEALED(report.steps);
    report.struct_size = 7;
    REFUSE(ARGUMENT, "struct_size of 'report'", perion_simulation_solve(simulation, NULL, &report));
    REFUSE(ARGUMENT, "report", perion_simulation_solve(simulation, NULL, MISALIGNED(perion_report)));
    REFUSE(NULLED, "simulation", perion_simulation_solve(NULL, NULL, NULL));
    REFUSE(ARGUMENT, "simulation",
           perion_simulation_solve(NO_HANDLE(perion_simulation), NULL, NULL));
    scene_state_free(&state);
    perion_solve_options_init(NULL, sizeof(perion_solve_options));
}

static void relaxing_is_of_sensible_options(perion_simulation *simulation)
{
    static const double shares[] = {-0.1, 1.000001, NAN, INFINITY, -INFINITY};
    perion_relax_options options;
    perion_report report;
    scene_state state = state_of(simulation);

    SEAL(report);
    report.struct_size = sizeof report;
    report.residuals_or_null = NULL;
    report.energies_or_null = NULL;
    for (int k = 0; k < 5; ++k) {
        perion_relax_options_init(&options, sizeof(perion_relax_options));
        options.tolerance = shares[k];
        REFUSE(ARGUMENT, "tolerance", perion_simulation_relax(simulation, &options, &report));
        options.tolerance = 0.0;
        options.energy_tolerance = shares[k];
        REFUSE(ARGUMENT, "energy_tolerance", perion_simulation_relax(simulation, &options, &report));
    }
    perion_relax_options_init(&options, sizeof(perion_relax_options));
    options.steps = -1;
    REFUSE(ARGUMENT, "steps", perion_simulation_relax(simulation, &options, &report));
    options.steps = 0;
    options.ramp = -1;
    REFUSE(ARGUMENT, "ramp", perion_simulation_relax(simulation, &options, &report));
    options.ramp = 0;
    options.breaks = INT64_MIN;
    REFUSE(ARGUMENT, "breaks", perion_simulation_relax(simulation, &options, &report));
    options.struct_size = 0;
    REFUSE(ARGUMENT, "struct_size of 'relax_options'",
           perion_simulation_relax(simulation, &options, &report));
    EXPECT_SEALED(report.steps);
    report.struct_size = 7;
    REFUSE(ARGUMENT, "struct_size of 'report'", perion_simulation_relax(simulation, NULL, &report));
    REFUSE(NULLED, "simulation", perion_simulation_relax(NULL, NULL, NULL));
    scene_state_free(&state);
    perion_relax_options_init(NULL, sizeof(perion_relax_options));
}

static void what_moves_is_not_at_rest(perion_simulation *simulation)
{
    EXPECT_OK(perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_VELOCITY, 0, 1.0));
    EXPECT_REFUSED(STATE, "velocity is prescribed on set 'left'",
                   perion_simulation_solve(simulation, NULL, NULL));
    EXPECT_REFUSED(STATE, "velocity is prescribed on set 'left'",
                   perion_simulation_relax(simulation, NULL, NULL));
    EXPECT_OK(perion_simulation_release(simulation, "left", PERION_QUANTITY_VELOCITY, 0));
}

void bad_statics(void)
{
    perion_simulation *simulation = bad_running();

    solving_is_of_sensible_options(simulation);
    relaxing_is_of_sensible_options(simulation);
    what_moves_is_not_at_rest(simulation);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}
