/* Bad inputs to fields. */
#include "bad.h"

#define state_of scene_state_of

static const perion_field no_fields[] = {0, 29, 1000, -1, INT32_MAX, INT32_MIN};
enum { NO_FIELDS = sizeof no_fields / sizeof no_fields[0] };

static const int64_t bad_lengths[] = {0, 1, SCENE_LENGTH - 1, SCENE_LENGTH + 1, -1, INT64_MIN, INT64_MAX};
enum { BAD_LENGTHS = sizeof bad_lengths / sizeof bad_lengths[0] };

static double zeros[SCENE_ROOM];

static void fields_are_got_whole(perion_simulation *simulation)
{
    double out[SCENE_LENGTH];
    scene_state state = state_of(simulation);

    for (int k = 0; k < NO_FIELDS; ++k)
        REFUSE_OUTPUT(out, ARGUMENT, "field",
                      perion_simulation_get(simulation, no_fields[k], out, SCENE_LENGTH));
    for (int k = 0; k < BAD_LENGTHS; ++k)
        REFUSE_OUTPUT(out, ARGUMENT, "length",
                      perion_simulation_get(simulation, PERION_FIELD_POSITION, out, bad_lengths[k]));
    REFUSE_OUTPUT(out, ARGUMENT, "length",
                  perion_simulation_get(simulation, PERION_FIELD_DAMAGE, out, SCENE_LENGTH));
    REFUSE_OUTPUT(out, NULLED, "simulation",
                  perion_simulation_get(NULL, PERION_FIELD_POSITION, out, SCENE_LENGTH));
    REFUSE(NULLED, "values",
           perion_simulation_get(simulation, PERION_FIELD_POSITION, NULL, SCENE_LENGTH));
    REFUSE(ARGUMENT, "values",
           perion_simulation_get(simulation, PERION_FIELD_POSITION, MISALIGNED(double), SCENE_LENGTH));
    REFUSE_OUTPUT(out, ARGUMENT, "simulation",
                  perion_simulation_get(NO_HANDLE(perion_simulation), PERION_FIELD_POSITION, out,
                                        SCENE_LENGTH));
    scene_state_free(&state);
}

static void fields_are_set_whole_and_finite(perion_simulation *simulation)
{
    static const perion_field settable[] = {PERION_FIELD_DISPLACEMENT, PERION_FIELD_POSITION,
                                            PERION_FIELD_VELOCITY, PERION_FIELD_BODY_FORCE};
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    scene_state state = state_of(simulation);

    for (int k = 0; k < NO_FIELDS; ++k)
        REFUSE(ARGUMENT, "field", perion_simulation_set(simulation, no_fields[k], zeros, SCENE_LENGTH));
    for (int field = 0; field < 4; ++field) {
        for (int k = 0; k < BAD_LENGTHS; ++k)
            REFUSE(ARGUMENT, "length",
                   perion_simulation_set(simulation, settable[field], zeros, bad_lengths[k]));
        REFUSE(NULLED, "values", perion_simulation_set(simulation, settable[field], NULL, SCENE_LENGTH));
        REFUSE(ARGUMENT, "values",
               perion_simulation_set(simulation, settable[field], MISALIGNED(double), SCENE_LENGTH));
        REFUSE(NULLED, "simulation",
               perion_simulation_set(NULL, settable[field], zeros, SCENE_LENGTH));
        for (int k = 0; k < 3; ++k) {
            zeros[SCENE_LENGTH - 2] = bad[k];
            REFUSE(ARGUMENT, "of point 383, axis 1, is",
                   perion_simulation_set(simulation, settable[field], zeros, SCENE_LENGTH));
            zeros[SCENE_LENGTH - 2] = 0.0;
        }
    }
    scene_state_free(&state);
}

static void what_is_computed_cannot_be_set(perion_simulation *simulation)
{
    scene_state state = state_of(simulation);

    for (int k = 0; k < SCENE_FIELDS; ++k) {
        perion_field field = scene_fields[k];
        int64_t length = scene_numbers(field);
        if (field == PERION_FIELD_DISPLACEMENT || field == PERION_FIELD_POSITION
            || field == PERION_FIELD_VELOCITY || field == PERION_FIELD_BODY_FORCE)
            continue;
        REFUSE(UNSUPPORTED, "field", perion_simulation_set(simulation, field, zeros, length));
        REFUSE(UNSUPPORTED, "field",
               perion_simulation_set_strided(simulation, "left", field, zeros, SCENE_LAYER, 3));
    }
    scene_state_free(&state);
}

/* The arguments that both strided calls share. */
static void refuse_strided(perion_simulation *simulation, perion_status status, const char *fragment,
                           const char *set, perion_field field, int64_t count, int64_t stride)
{
    double values[SCENE_LAYER * 3] = {0.0};
    scene_state state = state_of(simulation);

    REFUSE_OUTPUT(values, status, fragment,
                  perion_simulation_get_strided(simulation, set, field, values, count, stride));
    SEAL(values);
    REFUSE(status, fragment,
           perion_simulation_set_strided(simulation, set, field, values, count, stride));
    scene_state_free(&state);
}

static void sets_counts_and_strides_fit(perion_simulation *simulation)
{
    static const int64_t counts[] = {0, 1, SCENE_LAYER - 1, SCENE_COUNT, -1, INT64_MIN, INT64_MAX};
    static const int64_t strides[] = {0, 2, -3, INT64_MIN, INT64_MAX};
    const perion_field field = PERION_FIELD_VELOCITY;

    for (size_t k = 0; k < sizeof counts / sizeof counts[0]; ++k)
        refuse_strided(simulation, ARGUMENT, "count", "left", field, counts[k], 3);
    for (size_t k = 0; k < sizeof strides / sizeof strides[0]; ++k)
        refuse_strided(simulation, ARGUMENT, "stride", "left", field, SCENE_LAYER, strides[k]);
    refuse_strided(simulation, ARGUMENT, "stride", NULL, field, SCENE_COUNT, 1);
    refuse_strided(simulation, ARGUMENT, "values", "left", field, SCENE_LAYER, INT64_MAX / 32);
    refuse_strided(simulation, ARGUMENT, "field", "left", 99, SCENE_LAYER, 3);
    refuse_strided(simulation, ARGUMENT, "set", "lef", field, SCENE_LAYER, 3);
    refuse_strided(simulation, ARGUMENT, "set", latin1, field, SCENE_LAYER, 3);
    refuse_strided(simulation, ARGUMENT, "set", endless, field, SCENE_LAYER, 3);
}

static void strided_calls_take_pointers(perion_simulation *simulation)
{
    const perion_field field = PERION_FIELD_VELOCITY;
    double values[SCENE_LAYER * 3] = {0.0};
    scene_state state = state_of(simulation);

    values[4] = NAN;
    REFUSE(NULLED, "simulation",
           perion_simulation_get_strided(NULL, "left", field, values, SCENE_LAYER, 3));
    REFUSE(NULLED, "values",
           perion_simulation_get_strided(simulation, "left", field, NULL, SCENE_LAYER, 3));
    REFUSE(ARGUMENT, "values",
           perion_simulation_get_strided(simulation, "left", field, MISALIGNED(double), SCENE_LAYER, 3));
    REFUSE(NULLED, "simulation",
           perion_simulation_set_strided(NULL, "left", field, values, SCENE_LAYER, 3));
    REFUSE(NULLED, "values",
           perion_simulation_set_strided(simulation, "left", field, NULL, SCENE_LAYER, 3));
    REFUSE(ARGUMENT, "values",
           perion_simulation_set_strided(simulation, "left", field, MISALIGNED(double), SCENE_LAYER, 3));
    REFUSE(ARGUMENT, "'values': velocity of point 12, axis 1, is NaN",
           perion_simulation_set_strided(simulation, "left", field, values, SCENE_LAYER, 3));
    scene_state_free(&state);
}

static void sums_are_of_fields_and_sets(perion_simulation *simulation)
{
    double sum[3];
    scene_state state = state_of(simulation);

    for (int k = 0; k < NO_FIELDS; ++k)
        REFUSE_OUTPUT(sum, ARGUMENT, "field",
                      perion_simulation_sum(simulation, no_fields[k], NULL, sum));
    REFUSE_OUTPUT(sum, ARGUMENT, "set",
                  perion_simulation_sum(simulation, PERION_FIELD_VOLUME, "up", sum));
    REFUSE_OUTPUT(sum, ARGUMENT, "set",
                  perion_simulation_sum(simulation, PERION_FIELD_VOLUME, latin1, sum));
    REFUSE_OUTPUT(sum, NULLED, "simulation",
                  perion_simulation_sum(NULL, PERION_FIELD_VOLUME, NULL, sum));
    REFUSE(NULLED, "components",
           perion_simulation_sum(simulation, PERION_FIELD_VOLUME, NULL, NULL));
    REFUSE(ARGUMENT, "components",
           perion_simulation_sum(simulation, PERION_FIELD_VOLUME, NULL, MISALIGNED(double)));
    scene_state_free(&state);
}

static void operators_take_whole_finite_fields(perion_simulation *simulation)
{
    static const perion_operator no_operators[] = {0, 5, -1, INT32_MAX, INT32_MIN};
    static double field[SCENE_LENGTH];
    double out[3 * SCENE_LENGTH];
    scene_state state = state_of(simulation);
    const perion_operator operator = PERION_OPERATOR_REFERENCE_UNDEFORMED;

    for (int k = 0; k < 5; ++k) {
        REFUSE_OUTPUT(out, ARGUMENT, "operator",
                      perion_simulation_gradient(simulation, no_operators[k], 3, field, out));
        REFUSE_OUTPUT(out, ARGUMENT, "operator",
                      perion_simulation_divergence(simulation, no_operators[k], 3, field, out));
    }
    for (int components = -2; components < 1; ++components) {
        REFUSE_OUTPUT(out, ARGUMENT, "components",
                      perion_simulation_gradient(simulation, operator, components, field, out));
        REFUSE_OUTPUT(out, ARGUMENT, "components",
                      perion_simulation_divergence(simulation, operator, components, field, out));
    }
    REFUSE_OUTPUT(out, ARGUMENT, "multiple of the dimension",
                  perion_simulation_divergence(simulation, operator, 2, field, out));
    REFUSE_OUTPUT(out, NULLED, "simulation", perion_simulation_gradient(NULL, operator, 3, field, out));
    REFUSE_OUTPUT(out, NULLED, "simulation", perion_simulation_divergence(NULL, operator, 3, field, out));
    REFUSE_OUTPUT(out, ARGUMENT, "simulation",
                  perion_simulation_gradient(NO_HANDLE(perion_simulation), operator, 3, field, out));
    REFUSE_OUTPUT(out, NULLED, "field", perion_simulation_gradient(simulation, operator, 3, NULL, out));
    REFUSE_OUTPUT(out, ARGUMENT, "field",
                  perion_simulation_divergence(simulation, operator, 3, MISALIGNED(double), out));
    REFUSE(NULLED, "result", perion_simulation_gradient(simulation, operator, 3, field, NULL));
    REFUSE(ARGUMENT, "result",
           perion_simulation_divergence(simulation, operator, 3, field, MISALIGNED(double)));
    field[7] = NAN;
    REFUSE_OUTPUT(out, ARGUMENT, "'field' of point 2, component 1, is NaN",
                  perion_simulation_gradient(simulation, operator, 3, field, out));
    field[7] = 0.0;
    scene_state_free(&state);
}

/* What depends on an evaluation is not shown when it is out of date. */
static void stale_fields_are_not_shown(void)
{
    perion_simulation *simulation = scene_simulation();
    double out[SCENE_LENGTH];
    scene_state state;

    EXPECT_OK(perion_simulation_prescribe(simulation, "left", PERION_QUANTITY_BODY_FORCE, 0, 1.0));
    state = state_of(simulation);
    REFUSE_OUTPUT(out, STATE, "acceleration",
                  perion_simulation_get(simulation, PERION_FIELD_ACCELERATION, out, SCENE_LENGTH));
    REFUSE_OUTPUT(out, STATE, "reaction",
                  perion_simulation_get(simulation, PERION_FIELD_REACTION, out, SCENE_LENGTH));
    REFUSE_OUTPUT(out, STATE, "body_force",
                  perion_simulation_get(simulation, PERION_FIELD_BODY_FORCE, out, SCENE_LENGTH));
    REFUSE_OUTPUT(out, STATE, "reaction",
                  perion_simulation_sum(simulation, PERION_FIELD_REACTION, "left", out));
    scene_state_free(&state);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

void bad_fields(void)
{
    perion_simulation *simulation = bad_running();

    fields_are_got_whole(simulation);
    fields_are_set_whole_and_finite(simulation);
    what_is_computed_cannot_be_set(simulation);
    sets_counts_and_strides_fit(simulation);
    strided_calls_take_pointers(simulation);
    sums_are_of_fields_and_sets(simulation);
    operators_take_whole_finite_fields(simulation);
    stale_fields_are_not_shown();
    EXPECT_OK(perion_simulation_destroy(&simulation));
}
