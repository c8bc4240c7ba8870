/* Fields: copies in and out, sets and strides, sums, and views. */
#include "harness.h"
#include "scene.h"

#include <math.h>

#include <string.h>

static double values[SCENE_LENGTH], again[SCENE_LENGTH], room[SCENE_ROOM];

static void fill_with_places(double *field, double scale)
{
    for (int k = 0; k < SCENE_LENGTH; ++k)
        field[k] = scale * (k % 61);
}

static void what_is_set_can_be_got(void)
{
    static const perion_field settable[] = {PERION_FIELD_DISPLACEMENT, PERION_FIELD_VELOCITY,
                                            PERION_FIELD_BODY_FORCE, PERION_FIELD_POSITION};
    perion_simulation *simulation = scene_simulation();

    fill_with_places(values, 0.0009765625);
    for (int k = 0; k < 4; ++k) {
        EXPECT_OK(perion_simulation_set(simulation, settable[k], values, SCENE_LENGTH));
        EXPECT_OK(perion_simulation_get(simulation, settable[k], again, SCENE_LENGTH));
        EXPECT(memcmp(values, again, sizeof values) == 0);
    }
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, again, SCENE_LENGTH));
    EXPECT_REAL(again[0], values[0] - 0.5);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void every_field_is_known_after_an_evaluation(void)
{
    perion_simulation *simulation = scene_simulation();

    scene_throw(simulation);
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 12));
    EXPECT_OK(perion_simulation_evaluate(simulation));
    for (int k = 0; k < SCENE_FIELDS; ++k) {
        int64_t length = scene_numbers(scene_fields[k]);
        int finite = 1;
        EXPECT_OK(perion_simulation_get(simulation, scene_fields[k], room, length));
        for (int64_t place = 0; place < length; ++place)
            finite &= room[place] - room[place] == 0.0;
        EXPECT(finite);
    }
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* Positions have the gradient I and the divergence 3. The field may lie in the room of the result. */
static void operators_differentiate_the_hosts_fields(void)
{
    static double gradient[3 * SCENE_LENGTH];
    perion_simulation *simulation = scene_simulation();
    int right = 1;

    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_REFERENCE_POSITION, gradient, SCENE_LENGTH));
    EXPECT_OK(perion_simulation_divergence(simulation, PERION_OPERATOR_CURRENT_DEFORMED, 3, gradient, values));
    EXPECT_OK(perion_simulation_gradient(simulation, PERION_OPERATOR_REFERENCE_UNDEFORMED, 3, gradient,
                                         gradient));
    for (int k = 0; k < 3 * SCENE_LENGTH; ++k)
        right &= fabs(gradient[k] - (k % 9 % 4 == 0 ? 1.0 : 0.0)) < 1e-12;
    for (int k = 0; k < SCENE_LENGTH / 3; ++k)
        right &= fabs(values[k] - 3.0) < 1e-12;
    EXPECT(right);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* A stride of 5 leaves two numbers of each point alone. */
static void strides_leave_what_is_between_alone(void)
{
    double layer[5 * SCENE_LAYER], read[5 * SCENE_LAYER];
    perion_simulation *simulation = scene_simulation();

    for (int k = 0; k < 5 * SCENE_LAYER; ++k) {
        layer[k] = k;
        read[k] = -1.0;
    }
    EXPECT_OK(perion_simulation_set_strided(simulation, "right", PERION_FIELD_VELOCITY, layer,
                                            SCENE_LAYER, 5));
    EXPECT_OK(perion_simulation_get_strided(simulation, "right", PERION_FIELD_VELOCITY, read,
                                            SCENE_LAYER, 5));
    for (int k = 0; k < 5 * SCENE_LAYER; ++k)
        EXPECT_REAL(read[k], k % 5 < 3 ? layer[k] : -1.0);
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, values, SCENE_LENGTH));
    EXPECT_REAL(values[0], 0.0);
    EXPECT_REAL(values[3 * (12 * 7 + 11) + 1], 36.0);
    EXPECT_OK(perion_simulation_get_strided(simulation, NULL, PERION_FIELD_VELOCITY, again, SCENE_COUNT,
                                            3));
    EXPECT(memcmp(values, again, sizeof values) == 0);
    EXPECT_OK(perion_simulation_set_strided(simulation, NULL, PERION_FIELD_DISPLACEMENT, values,
                                            SCENE_COUNT, 3));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* A shear of x by y: row 0, column 1 of F, whole, of a set with a stride, and summed. */
static void tensors_lie_row_after_row(void)
{
    double layer[10 * SCENE_LAYER], sum[9];
    perion_simulation *simulation = scene_simulation();

    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_POSITION, values, SCENE_LENGTH));
    for (int k = 0; k < SCENE_LENGTH; ++k)
        again[k] = k % 3 == 0 ? 0.0625 * values[k + 1] : 0.0;
    EXPECT_OK(perion_simulation_set(simulation, PERION_FIELD_DISPLACEMENT, again, SCENE_LENGTH));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_DEFORMATION_GRADIENT, room, SCENE_ROOM));
    for (int k = 0; k < SCENE_ROOM; ++k) {
        double expected = k % 9 == 1 ? 0.0625 : k % 9 % 4 == 0 ? 1.0 : 0.0;
        EXPECT(fabs(room[k] - expected) < 1e-13);
    }
    for (int k = 0; k < 10 * SCENE_LAYER; ++k)
        layer[k] = -7.0;
    EXPECT_OK(perion_simulation_get_strided(simulation, "left", PERION_FIELD_STRAIN, layer, SCENE_LAYER,
                                            10));
    for (int k = 0; k < SCENE_LAYER; ++k) {
        EXPECT(fabs(layer[10 * k + 1] - 0.03125) < 1e-13 && fabs(layer[10 * k + 3] - 0.03125) < 1e-13);
        EXPECT_REAL(layer[10 * k + 9], -7.0);
    }
    EXPECT_OK(perion_simulation_sum(simulation, PERION_FIELD_DEFORMATION_GRADIENT, "left", sum));
    EXPECT(fabs(sum[1] - 0.0625 * SCENE_LAYER) < 1e-11 && fabs(sum[3]) < 1e-11);
    EXPECT_REFUSED(PERION_ERROR_UNSUPPORTED, "stress_33",
                   perion_simulation_get(simulation, PERION_FIELD_STRESS_33, values, SCENE_COUNT));
    EXPECT_REFUSED(PERION_ERROR_UNSUPPORTED, "stress_33",
                   perion_simulation_sum(simulation, PERION_FIELD_STRESS_33, NULL, sum));
    EXPECT_REFUSED(PERION_ERROR_ARGUMENT, "length",
                   perion_simulation_get(simulation, PERION_FIELD_STRAIN, room, SCENE_LENGTH));
    EXPECT_REFUSED(PERION_ERROR_ARGUMENT, "stride",
                   perion_simulation_get_strided(simulation, "left", PERION_FIELD_STRAIN, layer,
                                                 SCENE_LAYER, 8));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void sums_run_over_sets(void)
{
    double sum[3] = {0.0}, volume = 0.0;
    perion_simulation *simulation = scene_simulation();

    EXPECT_OK(perion_simulation_sum(simulation, PERION_FIELD_VOLUME, NULL, &volume));
    EXPECT_REAL(volume, SCENE_COUNT);
    EXPECT_OK(perion_simulation_sum(simulation, PERION_FIELD_VOLUME, "left", &volume));
    EXPECT_REAL(volume, SCENE_LAYER);
    EXPECT_OK(perion_simulation_sum(simulation, PERION_FIELD_REFERENCE_POSITION, "left", sum));
    EXPECT_REAL(sum[0], 0.5 * SCENE_LAYER);
    EXPECT_REAL(sum[1], 4.0 * SCENE_LAYER);
    EXPECT_REAL(sum[2], 2.0 * SCENE_LAYER);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* Component c of the host's point p. */
static double *component(const perion_view *view, int64_t point, int64_t c)
{
    int64_t place = view->slot ? view->slot[point] : point;

    return view->data + place * view->point_stride + c * view->component_stride;
}

static void a_view_is_the_librarys_own_memory(void)
{
    perion_view view;
    perion_simulation *simulation = scene_simulation();

    perion_view_init(&view, sizeof(perion_view));
    EXPECT_INT(view.struct_size, sizeof view);
    EXPECT(view.data == NULL && view.generation == 0);
    EXPECT_OK(perion_simulation_borrow(simulation, PERION_FIELD_DISPLACEMENT, &view));
    EXPECT_INT(view.count, SCENE_COUNT);
    EXPECT_INT(view.components, 3);
    fill_with_places(values, 0.0009765625);
    for (int64_t k = 0; k < SCENE_LENGTH; ++k)
        *component(&view, k / 3, k % 3) = values[k];
    EXPECT_OK(perion_simulation_return(simulation, &view));
    EXPECT(view.data == NULL && view.slot == NULL && view.generation == 0);
    EXPECT_INT(view.struct_size, sizeof view);
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, again, SCENE_LENGTH));
    EXPECT(memcmp(values, again, sizeof values) == 0);
    EXPECT_OK(perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_ACCELERATION, again, SCENE_LENGTH));
    EXPECT_OK(perion_simulation_borrow_const(simulation, PERION_FIELD_ACCELERATION, &view));
    for (int64_t k = 0; k < SCENE_LENGTH; ++k)
        values[k] = *component(&view, k / 3, k % 3);
    EXPECT(memcmp(values, again, sizeof values) == 0);
    EXPECT_OK(perion_simulation_return(simulation, &view));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* The same loads by set and by view, on bodies at rest, give the same motion. */
static void a_view_does_what_set_does(void)
{
    perion_view view;
    perion_simulation *one = scene_simulation(), *other = scene_simulation();
    scene_state result;

    perion_view_init(&view, sizeof(perion_view));
    fill_with_places(values, 0.00048828125);
    EXPECT_OK(perion_simulation_set(one, PERION_FIELD_BODY_FORCE, values, SCENE_LENGTH));
    EXPECT_OK(perion_simulation_borrow(other, PERION_FIELD_BODY_FORCE, &view));
    for (int64_t k = 0; k < SCENE_LENGTH; ++k)
        *component(&view, k / 3, k % 3) = values[k];
    EXPECT_OK(perion_simulation_return(other, &view));
    EXPECT_OK(perion_simulation_step(one, scene_time_step, 10));
    EXPECT_OK(perion_simulation_step(other, scene_time_step, 10));
    result = scene_result_of(one);
    EXPECT(scene_is(&result, scene_result_of(other)));
    scene_state_free(&result);
    EXPECT_OK(perion_simulation_destroy(&one));
    EXPECT_OK(perion_simulation_destroy(&other));
}

static void two_fields_can_be_lent_at_once(void)
{
    perion_view place, speed;
    perion_simulation *simulation = scene_simulation();

    perion_view_init(&place, sizeof(perion_view));
    perion_view_init(&speed, sizeof(perion_view));
    EXPECT_OK(perion_simulation_borrow(simulation, PERION_FIELD_DISPLACEMENT, &place));
    EXPECT_OK(perion_simulation_borrow(simulation, PERION_FIELD_VELOCITY, &speed));
    EXPECT(place.data != speed.data && place.generation != speed.generation);
    EXPECT_OK(perion_simulation_return(simulation, &place));
    EXPECT_REFUSED(PERION_ERROR_STATE, "view", perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_return(simulation, &speed));
    EXPECT_OK(perion_simulation_evaluate(simulation));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* What was lent to read only is looked at when it comes back. */
static void what_was_lent_to_read_is_not_written(void)
{
    perion_simulation *simulation = scene_simulation();
    perion_view view;
    double kept;

    perion_view_init(&view, sizeof(perion_view));
    EXPECT_OK(perion_simulation_borrow_const(simulation, PERION_FIELD_VELOCITY, &view));
    kept = view.data[4];
    view.data[4] = (double)INFINITY;
    EXPECT_REFUSED(PERION_ERROR_NUMERIC, "velocity of point", perion_simulation_return(simulation, &view));
    view.data[4] = kept;
    EXPECT_OK(perion_simulation_return(simulation, &view));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

int main(void)
{
    harness_begin();
    what_is_set_can_be_got();
    every_field_is_known_after_an_evaluation();
    operators_differentiate_the_hosts_fields();
    strides_leave_what_is_between_alone();
    tensors_lie_row_after_row();
    sums_run_over_sets();
    a_view_is_the_librarys_own_memory();
    a_view_does_what_set_does();
    two_fields_can_be_lent_at_once();
    what_was_lent_to_read_is_not_written();
    return harness_end();
}
