/*
 * Every formulation on one small body, and a fingerprint of all bits there are after some steps. The same
 * program stands beside this one in Fortran and in Rust. All numbers that go in are exact in binary.
 */
#include <perion.h>

#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT = 5 * 4 * 3, STEPS = 5 };

static void check(perion_status status)
{
    if (status != PERION_OK) {
        fprintf(stderr, "%s: %s\n", perion_status_string(status), perion_last_error());
        exit(1);
    }
}

static uint64_t hash_field(uint64_t hash, const perion_simulation *simulation, perion_field field,
                           int64_t length)
{
    double values[3 * COUNT];

    check(perion_simulation_get(simulation, field, values, length));
    for (int64_t k = 0; k < length; ++k) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        hash = (hash * 65599 + (bits & 0xffffffffu)) % 1099511627689u;
        hash = (hash * 65599 + (bits >> 32)) % 1099511627689u;
    }
    return hash;
}

static perion_points *cloud(void)
{
    static const double left[2][3] = {{-1, -1, -1}, {0.5, 9, 9}};
    static const double right[2][3] = {{3.5, -1, -1}, {9, 9, 9}};
    double coordinates[3 * COUNT], volumes[COUNT];
    perion_points *points = NULL;

    for (int point = 0; point < COUNT; ++point) {
        const int place[] = {point % 5, point / 5 % 4, point / 20};
        for (int axis = 0; axis < 3; ++axis) {
            int jitter = (point * 7919 + axis * 104729) % 257 - 128;
            coordinates[3 * point + axis] = (1024 * place[axis] + jitter) / 1024.0;
        }
        volumes[point] = (896 + point * 31 % 256) / 1024.0;
    }
    check(perion_points_create(3, COUNT, coordinates, 3, volumes, &points));
    check(perion_points_add_set_box(points, "left", left[0], left[1]));
    check(perion_points_add_set_box(points, "right", right[0], right[1]));
    return points;
}

static void run(const char *formulation)
{
    static const perion_field vectors[] = {PERION_FIELD_DISPLACEMENT, PERION_FIELD_VELOCITY,
                                           PERION_FIELD_INTERNAL_FORCE};
    static const perion_field scalars[] = {PERION_FIELD_STRAIN_ENERGY_DENSITY,
                                           PERION_FIELD_VON_MISES_STRESS, PERION_FIELD_DAMAGE};
    perion_points *points = cloud();
    perion_model *model = NULL;
    perion_simulation *simulation = NULL;
    perion_health health;
    double velocity[3 * COUNT];
    uint64_t hash = 0;

    check(perion_model_create(formulation, &model));
    check(perion_model_set(model, "density", 1.25));
    check(perion_model_set(model, "youngs_modulus", 1.5));
    check(perion_model_set(model, "poissons_ratio", 0.25));
    check(perion_model_set(model, "horizon", 2.25));
    check(perion_model_set(model, "critical_stretch", 1.0 / 128));
    check(perion_simulation_create(points, model, &simulation));
    for (int component = 0; component < 3 * COUNT; ++component)
        velocity[component] = (component * 13 % 64 - 32) / 1024.0;
    check(perion_simulation_set(simulation, PERION_FIELD_VELOCITY, velocity, 3 * COUNT));
    check(perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_VELOCITY, 0, -1.0 / 64));
    check(perion_simulation_prescribe(simulation, "right", PERION_QUANTITY_VELOCITY, 0, 1.0 / 64));
    check(perion_simulation_step(simulation, 1.0 / 16, STEPS));
    for (int k = 0; k < 3; ++k)
        hash = hash_field(hash, simulation, vectors[k], 3 * COUNT);
    for (int k = 0; k < 3; ++k)
        hash = hash_field(hash, simulation, scalars[k], COUNT);
    perion_health_init(&health, sizeof health);
    check(perion_simulation_health(simulation, &health));
    printf("%s %010" PRIX64 " %" PRId64 "\n", formulation, hash, health.broken_bonds);
    check(perion_simulation_destroy(&simulation));
    check(perion_model_destroy(&model));
    check(perion_points_destroy(&points));
}

int main(void)
{
    for (int64_t index = 0; index < perion_formulation_count(); ++index)
        run(perion_formulation_name(index));
    return 0;
}
