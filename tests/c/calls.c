/* See calls.h. */
#include "calls.h"

#include "harness.h"
#include "scene.h"

#include <stdio.h>
#include <stdlib.h>

static perion_status assign_model(perion_simulation *simulation)
{
    perion_model *model = NULL;
    perion_status status = perion_model_create("bond_based", &model);

    if (status == PERION_OK)
        status = perion_model_set(model, "density", 1.0);
    if (status == PERION_OK)
        status = perion_model_set(model, "youngs_modulus", 1.0);
    if (status == PERION_OK)
        status = perion_model_set(model, "horizon", 2.1);
    if (status == PERION_OK)
        status = perion_simulation_assign_model(simulation, "left", model);
    perion_model_destroy(&model);
    return status;
}

static perion_status set_interface(perion_simulation *simulation)
{
    return perion_simulation_set_interface(simulation, "left", "right", 1.0);
}

static perion_status forbid_failure(perion_simulation *simulation)
{
    return perion_simulation_forbid_failure(simulation, "left");
}

static perion_status set_threads(perion_simulation *simulation)
{
    return perion_simulation_set_threads(simulation, 2);
}

static const int64_t pair[] = {0, 1};

static perion_status break_bonds(perion_simulation *simulation)
{
    return perion_simulation_break_bonds(simulation, 1, pair);
}

static perion_status break_crossing(perion_simulation *simulation)
{
    static const double triangle[] = {6.0, 0.0, 0.0, 6.0, 2.0, 0.0, 6.0, 0.0, 2.0};
    return perion_simulation_break_crossing(simulation, 3, triangle);
}

static perion_status set_bond_integrity(perion_simulation *simulation)
{
    static const double half = 0.5;
    return perion_simulation_set_bond_integrity(simulation, 1, pair, &half);
}

static perion_status prescribe(perion_simulation *simulation)
{
    return perion_simulation_prescribe(simulation, "right", PERION_QUANTITY_BODY_FORCE, 0, 1.0);
}

static perion_status release(perion_simulation *simulation)
{
    return perion_simulation_release(simulation, "right", PERION_QUANTITY_BODY_FORCE, 0);
}

static perion_status prescribe_table(perion_simulation *simulation)
{
    static const double zero = 0.0;
    return perion_simulation_prescribe_table(simulation, "right", PERION_QUANTITY_VELOCITY, 1, 1, &zero,
                                             &zero);
}

static int nothing(void *user, double time, int64_t count, const double *reference_positions,
                   double *values)
{
    (void)user;
    (void)time;
    (void)reference_positions;
    for (int64_t k = 0; k < count; ++k)
        values[k] = 0.0;
    return 0;
}

static perion_status prescribe_function(perion_simulation *simulation)
{
    return perion_simulation_prescribe_function(simulation, "right", PERION_QUANTITY_VELOCITY, 1,
                                                nothing, NULL);
}

static double zeros[SCENE_LENGTH];

static perion_status prescribe_values(perion_simulation *simulation)
{
    return perion_simulation_prescribe_values(simulation, "right", PERION_QUANTITY_VELOCITY, 1,
                                              SCENE_LAYER, zeros);
}

static perion_status set(perion_simulation *simulation)
{
    return perion_simulation_set(simulation, PERION_FIELD_VELOCITY, zeros, SCENE_LENGTH);
}

static perion_status set_strided(perion_simulation *simulation)
{
    return perion_simulation_set_strided(simulation, "left", PERION_FIELD_VELOCITY, zeros, SCENE_LAYER,
                                         3);
}

static perion_status evaluate(perion_simulation *simulation)
{
    return perion_simulation_evaluate(simulation);
}

static perion_status commit(perion_simulation *simulation)
{
    return perion_simulation_commit(simulation, 0.0);
}

static perion_status stable_time_step(perion_simulation *simulation)
{
    double time_step;
    return perion_simulation_stable_time_step(simulation, &time_step);
}

static perion_status step(perion_simulation *simulation)
{
    return perion_simulation_step(simulation, scene_time_step, 1);
}

static perion_status advance(perion_simulation *simulation)
{
    double time = 0.0;
    perion_status status = perion_simulation_time(simulation, &time);

    return status == PERION_OK ? perion_simulation_advance(simulation, time + scene_time_step, NULL, NULL) : status;
}

static perion_status solve(perion_simulation *simulation)
{
    return perion_simulation_solve(simulation, NULL, NULL);
}

static perion_status relax(perion_simulation *simulation)
{
    return perion_simulation_relax(simulation, NULL, NULL);
}

static perion_status set_surface_areas(perion_simulation *simulation)
{
    double areas[SCENE_LAYER];

    for (int k = 0; k < SCENE_LAYER; ++k)
        areas[k] = 1.0;
    return perion_simulation_set_surface_areas(simulation, "left", SCENE_LAYER, areas);
}

static perion_status set_time(perion_simulation *simulation)
{
    return perion_simulation_set_time(simulation, 0.0);
}

static perion_status set_log(perion_simulation *simulation)
{
    return perion_simulation_set_log(simulation, NULL, NULL);
}

static perion_status set_progress(perion_simulation *simulation)
{
    return perion_simulation_set_progress(simulation, NULL, NULL);
}

const scene_call changing_calls[] = {
    {"assign_model", assign_model},
    {"set_interface", set_interface},
    {"forbid_failure", forbid_failure},
    {"set_threads", set_threads},
    {"break_bonds", break_bonds},
    {"break_crossing", break_crossing},
    {"set_bond_integrity", set_bond_integrity},
    {"prescribe", prescribe},
    {"release", release},
    {"prescribe_table", prescribe_table},
    {"prescribe_function", prescribe_function},
    {"prescribe_values", prescribe_values},
    {"set", set},
    {"set_strided", set_strided},
    {"evaluate", evaluate},
    {"commit", commit},
    {"stable_time_step", stable_time_step},
    {"step", step},
    {"advance", advance},
    {"solve", solve},
    {"relax", relax},
    {"set_surface_areas", set_surface_areas},
    {"set_time", set_time},
    {"set_log", set_log},
    {"set_progress", set_progress},
};
const int changing_call_count = sizeof changing_calls / sizeof changing_calls[0];

static perion_status get(perion_simulation *simulation)
{
    double values[SCENE_ROOM];
    perion_status status = PERION_OK;

    for (int k = 0; k < SCENE_FIELDS && status == PERION_OK; ++k) {
        status = perion_simulation_get(simulation, scene_fields[k], values, scene_numbers(scene_fields[k]));
    }
    return status;
}

static perion_status get_strided(perion_simulation *simulation)
{
    double values[4 * SCENE_LAYER];
    return perion_simulation_get_strided(simulation, "left", PERION_FIELD_POSITION, values, SCENE_LAYER,
                                         4);
}

static perion_status sum(perion_simulation *simulation)
{
    double total[3];
    return perion_simulation_sum(simulation, PERION_FIELD_REACTION, "left", total);
}

static perion_status gradient(perion_simulation *simulation)
{
    static double field[SCENE_LENGTH], result[3 * SCENE_LENGTH];
    return perion_simulation_gradient(simulation, PERION_OPERATOR_CURRENT_DEFORMED, 3, field, result);
}

static perion_status divergence(perion_simulation *simulation)
{
    static double field[SCENE_LENGTH], result[SCENE_LENGTH];
    return perion_simulation_divergence(simulation, PERION_OPERATOR_REFERENCE_DEFORMED, 3, field, result);
}

static perion_status get_bonds(perion_simulation *simulation)
{
    int64_t count;
    return perion_simulation_get_bonds(simulation, 0, NULL, NULL, NULL, &count);
}

static perion_status bond_count(perion_simulation *simulation)
{
    int64_t count;
    return perion_simulation_bond_count(simulation, &count);
}

static perion_status time_now(perion_simulation *simulation)
{
    double time;
    return perion_simulation_time(simulation, &time);
}

static perion_status step_count(perion_simulation *simulation)
{
    int64_t count;
    return perion_simulation_step_count(simulation, &count);
}

static perion_status energy(perion_simulation *simulation)
{
    perion_energy energy;
    perion_energy_init(&energy, sizeof(perion_energy));
    return perion_simulation_energy(simulation, &energy);
}

static perion_status health(perion_simulation *simulation)
{
    perion_health health;
    perion_health_init(&health, sizeof(perion_health));
    return perion_simulation_health(simulation, &health);
}

static perion_status memory(perion_simulation *simulation)
{
    perion_memory memory;
    perion_memory_init(&memory, sizeof(perion_memory));
    return perion_simulation_memory(simulation, &memory);
}

static perion_status write_vtk(perion_simulation *simulation)
{
    return perion_simulation_write_vtk(simulation, "call.vtu", SCENE_FIELDS, scene_fields);
}

static perion_status write_series(perion_simulation *simulation)
{
    return perion_simulation_write_series(simulation, "call.pvd", 1, scene_fields);
}

const scene_call looking_calls[] = {
    {"get", get},
    {"get_strided", get_strided},
    {"sum", sum},
    {"gradient", gradient},
    {"divergence", divergence},
    {"get_bonds", get_bonds},
    {"bond_count", bond_count},
    {"time", time_now},
    {"step_count", step_count},
    {"energy", energy},
    {"health", health},
    {"memory", memory},
    {"write_vtk", write_vtk},
    {"write_series", write_series},
};
const int looking_call_count = sizeof looking_calls / sizeof looking_calls[0];

void expect_of_all(const scene_call *calls, int count, perion_simulation *simulation,
                   perion_status expected)
{
    for (int k = 0; k < count; ++k)
        harness_status(calls[k].make(simulation), expected, calls[k].name, __FILE__, __LINE__);
}
