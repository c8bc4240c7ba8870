/* Bad views, and calls while views are on loan. */
#include "bad.h"
#include "calls.h"

#define state_of scene_state_of

/* A view with a size and a filling that must stay. */
static perion_view sealed(int64_t struct_size)
{
    perion_view view;

    SEAL(view);
    view.struct_size = struct_size;
    return view;
}

static void expect_no_view(const perion_view *view, int64_t struct_size)
{
    perion_view untouched = sealed(struct_size);

    EXPECT(view->data == untouched.data && view->slot == untouched.slot);
    EXPECT(view->count == untouched.count && view->generation == untouched.generation);
    EXPECT_INT(view->struct_size, struct_size);
}

static void views_are_of_fields_that_can_be_lent(perion_simulation *simulation)
{
    scene_state state = state_of(simulation);
    perion_view view = sealed(sizeof view);

    for (int k = 0; k < SCENE_FIELDS; ++k) {
        perion_field field = scene_fields[k];
        if (field == PERION_FIELD_DISPLACEMENT || field == PERION_FIELD_VELOCITY)
            continue;
        if (field != PERION_FIELD_BODY_FORCE)
            REFUSE(UNSUPPORTED, "lent", perion_simulation_borrow(simulation, field, &view));
        if (field != PERION_FIELD_ACCELERATION && field != PERION_FIELD_INTERNAL_FORCE)
            REFUSE(UNSUPPORTED, "lent", perion_simulation_borrow_const(simulation, field, &view));
    }
    REFUSE(ARGUMENT, "field", perion_simulation_borrow(simulation, 99, &view));
    REFUSE(ARGUMENT, "field", perion_simulation_borrow_const(simulation, -1, &view));
    expect_no_view(&view, sizeof view);
    scene_state_free(&state);
}

static void views_have_room(perion_simulation *simulation)
{
    static const int64_t sizes[] = {0, -1, 8, sizeof(perion_view) - 8, INT64_MIN, INT64_MAX};
    const perion_field field = PERION_FIELD_VELOCITY;
    scene_state state = state_of(simulation);

    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; ++k) {
        perion_view view = sealed(sizes[k]);
        REFUSE(ARGUMENT, "struct_size of 'view'", perion_simulation_borrow(simulation, field, &view));
        REFUSE(ARGUMENT, "struct_size of 'view'",
               perion_simulation_borrow_const(simulation, field, &view));
        REFUSE(ARGUMENT, "struct_size of 'view'", perion_simulation_return(simulation, &view));
        expect_no_view(&view, sizes[k]);
    }
    REFUSE(NULLED, "view", perion_simulation_borrow(simulation, field, NULL));
    REFUSE(NULLED, "view", perion_simulation_borrow_const(simulation, field, NULL));
    REFUSE(NULLED, "view", perion_simulation_return(simulation, NULL));
    REFUSE(ARGUMENT, "view",
           perion_simulation_borrow(simulation, field, MISALIGNED(perion_view)));
    scene_state_free(&state);
}

static void views_need_a_simulation(void)
{
    perion_view view = sealed(sizeof view);

    EXPECT_REFUSED(NULLED, "simulation",
                   perion_simulation_borrow(NULL, PERION_FIELD_VELOCITY, &view));
    EXPECT_REFUSED(NULLED, "simulation",
                   perion_simulation_borrow_const(NULL, PERION_FIELD_VELOCITY, &view));
    EXPECT_REFUSED(NULLED, "simulation", perion_simulation_return(NULL, &view));
    expect_no_view(&view, sizeof view);
}

static void stale_fields_are_not_lent(void)
{
    perion_simulation *simulation = scene_simulation();
    scene_state state = state_of(simulation);
    perion_view view = sealed(sizeof view);

    REFUSE(STATE, "acceleration",
           perion_simulation_borrow_const(simulation, PERION_FIELD_ACCELERATION, &view));
    REFUSE(STATE, "internal_force",
           perion_simulation_borrow_const(simulation, PERION_FIELD_INTERNAL_FORCE, &view));
    expect_no_view(&view, sizeof view);
    scene_state_free(&state);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* Until a view is returned nothing changes the simulation, whatever the view; looking is fine. */
static void what_is_lent_does_not_change(perion_simulation *simulation, int writable)
{
    perion_view view;
    scene_state state;

    perion_view_init(&view, sizeof(perion_view));
    EXPECT_OK(perion_simulation_evaluate(simulation));
    if (writable)
        EXPECT_OK(perion_simulation_borrow(simulation, PERION_FIELD_BODY_FORCE, &view));
    else
        EXPECT_OK(perion_simulation_borrow_const(simulation, PERION_FIELD_DISPLACEMENT, &view));
    state = state_of(simulation);
    expect_of_all(changing_calls, changing_call_count, simulation, STATE);
    EXPECT(scene_is(&state, state_of(simulation)));
    if (!writable)
        expect_of_all(looking_calls, looking_call_count, simulation, PERION_OK);
    scene_state_free(&state);
    EXPECT_OK(perion_simulation_return(simulation, &view));
}

static void views_are_returned_once(perion_simulation *simulation)
{
    perion_view view, copy, other;
    scene_state state;

    perion_view_init(&view, sizeof(perion_view));
    perion_view_init(&other, sizeof(perion_view));
    EXPECT_REFUSED(ARGUMENT, "view", perion_simulation_return(simulation, &view));
    EXPECT_OK(perion_simulation_borrow(simulation, PERION_FIELD_VELOCITY, &view));
    EXPECT_OK(perion_simulation_borrow_const(simulation, PERION_FIELD_VELOCITY, &other));
    state = state_of(simulation);
    copy = view;
    copy.generation += 1000;
    REFUSE(ARGUMENT, "view", perion_simulation_return(simulation, &copy));
    copy.generation = INT64_MIN;
    REFUSE(ARGUMENT, "view", perion_simulation_return(simulation, &copy));
    copy = view;
    EXPECT_OK(perion_simulation_return(simulation, &view));
    REFUSE(ARGUMENT, "view", perion_simulation_return(simulation, &view));
    REFUSE(ARGUMENT, "view", perion_simulation_return(simulation, &copy));
    EXPECT_OK(perion_simulation_return(simulation, &other));
    scene_state_free(&state);
}

/* Views of two simulations are alike but for whose they are. */
static void views_go_back_to_where_they_came_from(void)
{
    perion_simulation *one = scene_simulation(), *other = scene_simulation();
    perion_view of_one, of_other;

    perion_view_init(&of_one, sizeof(perion_view));
    perion_view_init(&of_other, sizeof(perion_view));
    EXPECT_OK(perion_simulation_borrow(one, PERION_FIELD_VELOCITY, &of_one));
    EXPECT_OK(perion_simulation_borrow(other, PERION_FIELD_VELOCITY, &of_other));
    EXPECT_REFUSED(ARGUMENT, "view", perion_simulation_return(other, &of_one));
    EXPECT_OK(perion_simulation_return(one, &of_one));
    EXPECT_OK(perion_simulation_return(other, &of_other));
    EXPECT_OK(perion_simulation_evaluate(one));
    EXPECT_OK(perion_simulation_evaluate(other));
    EXPECT_OK(perion_simulation_destroy(&one));
    EXPECT_OK(perion_simulation_destroy(&other));
}

static void what_is_returned_is_finite(perion_simulation *simulation)
{
    static const perion_field fields[] = {PERION_FIELD_DISPLACEMENT, PERION_FIELD_VELOCITY,
                                          PERION_FIELD_BODY_FORCE};
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    perion_view view;

    perion_view_init(&view, sizeof(perion_view));
    for (int field = 0; field < 3; ++field) {
        for (int k = 0; k < 3; ++k) {
            double *place, kept;
            EXPECT_OK(perion_simulation_borrow(simulation, fields[field], &view));
            place = view.data + (view.slot ? view.slot[77] : 77) * view.point_stride;
            kept = *place;
            *place = bad[k];
            EXPECT_REFUSED(PERION_ERROR_NUMERIC, "view", perion_simulation_return(simulation, &view));
            EXPECT_SAID("point 77, axis 0");
            EXPECT_REFUSED(STATE, "view", perion_simulation_evaluate(simulation));
            *place = kept;
            EXPECT_OK(perion_simulation_return(simulation, &view));
        }
    }
    EXPECT_OK(perion_simulation_evaluate(simulation));
}

void bad_views(void)
{
    perion_simulation *simulation = bad_running();

    views_are_of_fields_that_can_be_lent(simulation);
    views_have_room(simulation);
    views_need_a_simulation();
    stale_fields_are_not_lent();
    what_is_lent_does_not_change(simulation, 1);
    what_is_lent_does_not_change(simulation, 0);
    views_are_returned_once(simulation);
    views_go_back_to_where_they_came_from();
    what_is_returned_is_finite(simulation);
    EXPECT_OK(perion_simulation_destroy(&simulation));
}
