/* See scene.h. */
#include "scene.h"

#include "harness.h"

#include <stdlib.h>
#include <string.h>

const perion_field scene_fields[SCENE_FIELDS] = {
    PERION_FIELD_REFERENCE_POSITION,
    PERION_FIELD_POSITION,
    PERION_FIELD_DISPLACEMENT,
    PERION_FIELD_VELOCITY,
    PERION_FIELD_ACCELERATION,
    PERION_FIELD_INTERNAL_FORCE,
    PERION_FIELD_BODY_FORCE,
    PERION_FIELD_REACTION,
    PERION_FIELD_VOLUME,
    PERION_FIELD_DENSITY,
    PERION_FIELD_DAMAGE,
    PERION_FIELD_STRAIN_ENERGY_DENSITY,
    PERION_FIELD_STABILIZATION_ENERGY_DENSITY,
    PERION_FIELD_DISSIPATED_ENERGY_DENSITY,
    PERION_FIELD_DEFORMATION_GRADIENT,
    PERION_FIELD_STRAIN,
    PERION_FIELD_FIRST_PIOLA_STRESS,
    PERION_FIELD_CAUCHY_STRESS,
    PERION_FIELD_VON_MISES_STRESS,
    PERION_FIELD_DILATATION,
    PERION_FIELD_NEIGHBOR_COUNT,
    PERION_FIELD_TIME_STEP_ESTIMATE,
    PERION_FIELD_PLASTIC_STRAIN,
    PERION_FIELD_EQUIVALENT_PLASTIC_STRAIN,
    PERION_FIELD_SHAPE_TENSOR,
    PERION_FIELD_MIXED_SHAPE_TENSOR,
    PERION_FIELD_DEFORMED_SHAPE_TENSOR,
};

const double scene_time_step = 0.5;

perion_points *scene_points(void)
{
    static const double lower[] = {0.0, 0.0, 0.0}, upper[] = {12.0, 8.0, 4.0};
    static const double left[] = {1.0, 8.0, 4.0}, right[] = {11.0, 0.0, 0.0};
    perion_points *points = NULL;

    EXPECT_OK(perion_points_create_block(3, lower, upper, 1.0, &points));
    EXPECT_OK(perion_points_add_set_box(points, "left", lower, left));
    EXPECT_OK(perion_points_add_set_box(points, "right", right, upper));
    return points;
}

perion_model *scene_model(void)
{
    perion_model *model = NULL;

    EXPECT_OK(perion_model_create("bond_based", &model));
    EXPECT_OK(perion_model_set(model, "density", 1.0));
    EXPECT_OK(perion_model_set(model, "youngs_modulus", 1.0));
    EXPECT_OK(perion_model_set(model, "horizon", 2.1));
    EXPECT_OK(perion_model_set(model, "critical_stretch", 0.05));
    return model;
}

perion_simulation *scene_simulation(void)
{
    perion_points *points = scene_points();
    perion_model *model = scene_model();
    perion_simulation *simulation = NULL;

    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    EXPECT_OK(perion_simulation_set_threads(simulation, 2));
    EXPECT_OK(perion_points_destroy(&points));
    EXPECT_OK(perion_model_destroy(&model));
    return simulation;
}

void scene_throw(perion_simulation *simulation)
{
    static double velocity[SCENE_LENGTH];

    for (int point = 0; point < SCENE_COUNT; ++point) {
        double x = point % 12 < 6 ? -1.0 : 1.0;
        velocity[3 * point] = 0.0625 * x;
        velocity[3 * point + 1] = 0.015625 * (point % 5);
        velocity[3 * point + 2] = 0.0078125 * (point % 7);
    }
    EXPECT_OK(perion_simulation_set(simulation, PERION_FIELD_VELOCITY, velocity, SCENE_LENGTH));
}

static void append(scene_state *state, const void *data, size_t bytes)
{
    unsigned char *grown = realloc(state->data, state->bytes + bytes);

    if (grown == NULL)
        abort();
    memcpy(grown + state->bytes, data, bytes);
    state->data = grown;
    state->bytes += bytes;
}

int64_t scene_numbers(perion_field field)
{
    switch (field) {
    case PERION_FIELD_DEFORMATION_GRADIENT:
    case PERION_FIELD_STRAIN:
    case PERION_FIELD_FIRST_PIOLA_STRESS:
    case PERION_FIELD_CAUCHY_STRESS:
    case PERION_FIELD_PLASTIC_STRAIN:
    case PERION_FIELD_SHAPE_TENSOR:
    case PERION_FIELD_MIXED_SHAPE_TENSOR:
    case PERION_FIELD_DEFORMED_SHAPE_TENSOR:
        return 9 * SCENE_COUNT;
    default:
        return field <= PERION_FIELD_REACTION ? SCENE_LENGTH : SCENE_COUNT;
    }
}

static void append_field(scene_state *state, const perion_simulation *simulation, perion_field field)
{
    double values[SCENE_ROOM] = {0.0};
    perion_status status = perion_simulation_get(simulation, field, values, scene_numbers(field));

    append(state, &status, sizeof status);
    append(state, values, sizeof values);
}

static void append_bonds(scene_state *state, const perion_simulation *simulation)
{
    int64_t count = 0, *pairs;
    double *stretch, *integrity;
    size_t room;

    if (perion_simulation_bond_count(simulation, &count) != PERION_OK)
        return;
    room = (size_t)count;
    pairs = calloc(2 * room + 1, sizeof *pairs);
    stretch = calloc(room + 1, sizeof *stretch);
    integrity = calloc(room + 1, sizeof *integrity);
    if (pairs == NULL || stretch == NULL || integrity == NULL)
        abort();
    EXPECT_OK(perion_simulation_get_bonds(simulation, count, pairs, stretch, integrity, &count));
    append(state, pairs, 2 * room * sizeof *pairs);
    append(state, stretch, room * sizeof *stretch);
    append(state, integrity, room * sizeof *integrity);
    free(pairs);
    free(stretch);
    free(integrity);
}

static void append_clock(scene_state *state, const perion_simulation *simulation)
{
    double time = 0.0;
    int64_t steps = 0;
    perion_memory memory;

    perion_memory_init(&memory, sizeof(perion_memory));
    EXPECT_OK(perion_simulation_time(simulation, &time));
    EXPECT_OK(perion_simulation_step_count(simulation, &steps));
    EXPECT_OK(perion_simulation_memory(simulation, &memory));
    append(state, &time, sizeof time);
    append(state, &steps, sizeof steps);
    append(state, &memory, sizeof memory);
}

scene_state scene_early_state_of(const perion_simulation *simulation)
{
    scene_state state = {NULL, 0};

    append_clock(&state, simulation);
    append_field(&state, simulation, PERION_FIELD_POSITION);
    append_field(&state, simulation, PERION_FIELD_VELOCITY);
    append_field(&state, simulation, PERION_FIELD_ACCELERATION);
    append_field(&state, simulation, PERION_FIELD_BODY_FORCE);
    return state;
}

scene_state scene_state_of(const perion_simulation *simulation)
{
    scene_state state = {NULL, 0};
    perion_energy energy;
    perion_health health;

    perion_energy_init(&energy, sizeof(perion_energy));
    perion_health_init(&health, sizeof(perion_health));
    for (int k = 0; k < SCENE_FIELDS; ++k)
        append_field(&state, simulation, scene_fields[k]);
    append_bonds(&state, simulation);
    append_clock(&state, simulation);
    EXPECT_OK(perion_simulation_energy(simulation, &energy));
    EXPECT_OK(perion_simulation_health(simulation, &health));
    append(&state, &energy, sizeof energy);
    append(&state, &health, sizeof health);
    return state;
}

scene_state scene_result_of(perion_simulation *simulation)
{
    scene_state state = {NULL, 0};

    EXPECT_OK(perion_simulation_evaluate(simulation));
    append_field(&state, simulation, PERION_FIELD_DISPLACEMENT);
    append_field(&state, simulation, PERION_FIELD_VELOCITY);
    append_field(&state, simulation, PERION_FIELD_ACCELERATION);
    append_field(&state, simulation, PERION_FIELD_REACTION);
    append_field(&state, simulation, PERION_FIELD_DAMAGE);
    append_field(&state, simulation, PERION_FIELD_DISSIPATED_ENERGY_DENSITY);
    return state;
}

int scene_is(const scene_state *known, scene_state state)
{
    int same = known->bytes == state.bytes && memcmp(known->data, state.data, state.bytes) == 0;

    scene_state_free(&state);
    return same;
}

void scene_state_free(scene_state *state)
{
    free(state->data);
    state->data = NULL;
    state->bytes = 0;
}
