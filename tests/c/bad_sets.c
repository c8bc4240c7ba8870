/* Bad inputs to sets of points. */
#include "bad.h"

enum { COUNT = 384 };
static const int64_t good[] = {3, 1, 2};

/* The sets of the points are what they were: "all", "left" and "right". */
static void expect_sets_alone(const perion_points *points)
{
    static const char *const refused[] = {"new", "box", "left2", "d"};
    int64_t size;

    for (size_t k = 0; k < sizeof refused / sizeof refused[0]; ++k)
        EXPECT(perion_points_set_size(points, refused[k], &size) == ARGUMENT);
    EXPECT_OK(perion_points_set_size(points, "left", &size));
    EXPECT_INT(size, SCENE_LAYER);
    EXPECT_OK(perion_points_set_size(points, "all", &size));
    EXPECT_INT(size, COUNT);
}

static void names_are_short_text_of_their_own(perion_points *points)
{
    EXPECT_REFUSED(NULLED, "name", perion_points_add_set(points, NULL, 3, good));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set(points, "", 3, good));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set(points, " new", 3, good));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set(points, "ne\nw", 3, good));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set(points, latin1, 3, good));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set(points, endless, 3, good));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set(points, long_name, 3, good));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set(points, "all", 3, good));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set(points, "left", 3, good));
}

static void members_are_points_given_once(perion_points *points)
{
    static const int64_t twice[] = {3, 1, 3}, below[] = {0, -1, 1}, least[] = {INT64_MIN, 0, 1};
    static const int64_t beyond[] = {0, 1, COUNT}, most[] = {0, INT64_MAX, 1};

    EXPECT_REFUSED(NULLED, "points", perion_points_add_set(NULL, "new", 3, good));
    EXPECT_REFUSED(NULLED, "indices", perion_points_add_set(points, "new", 3, NULL));
    EXPECT_REFUSED(ARGUMENT, "indices", perion_points_add_set(points, "new", 1, MISALIGNED(int64_t)));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_add_set(points, "new", 0, good));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_add_set(points, "new", 0, NULL));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_add_set(points, "new", -1, good));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_add_set(points, "new", INT64_MIN, good));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_add_set(points, "new", INT64_MAX, good));
    EXPECT_REFUSED(ARGUMENT, "indices'[2]", perion_points_add_set(points, "new", 3, twice));
    EXPECT_REFUSED(ARGUMENT, "indices'[1]", perion_points_add_set(points, "new", 3, below));
    EXPECT_REFUSED(ARGUMENT, "indices'[0]", perion_points_add_set(points, "new", 3, least));
    EXPECT_REFUSED(ARGUMENT, "indices'[2]", perion_points_add_set(points, "new", 3, beyond));
    EXPECT_REFUSED(ARGUMENT, "indices'[1]", perion_points_add_set(points, "new", 3, most));
}

/* More indices than points are refused by their number, before any of them is read. */
static void a_set_has_no_more_members_than_there_are_points(perion_points *points)
{
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_add_set(points, "new", 1LL << 58, good));
}

static void boxes_hold_points(perion_points *points)
{
    static const double zero[] = {0.0, 0.0, 0.0}, one[] = {1.0, 1.0, 1.0};
    static const double away[] = {100.0, 100.0, 100.0}, farther[] = {101.0, 101.0, 101.0};
    static const double wrong[] = {0.5, NAN, 0.5};

    EXPECT_REFUSED(NULLED, "points", perion_points_add_set_box(NULL, "box", zero, one));
    EXPECT_REFUSED(NULLED, "name", perion_points_add_set_box(points, NULL, zero, one));
    EXPECT_REFUSED(NULLED, "lower", perion_points_add_set_box(points, "box", NULL, one));
    EXPECT_REFUSED(NULLED, "upper", perion_points_add_set_box(points, "box", zero, NULL));
    EXPECT_REFUSED(ARGUMENT, "lower",
                   perion_points_add_set_box(points, "box", MISALIGNED(double), one));
    EXPECT_REFUSED(ARGUMENT, "lower", perion_points_add_set_box(points, "box", one, zero));
    EXPECT_REFUSED(ARGUMENT, "lower", perion_points_add_set_box(points, "box", wrong, one));
    EXPECT_REFUSED(ARGUMENT, "upper", perion_points_add_set_box(points, "box", zero, wrong));
    EXPECT_REFUSED(ARGUMENT, "'lower'", perion_points_add_set_box(points, "box", away, farther));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set_box(points, "", zero, one));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set_box(points, "right", zero, one));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_add_set_box(points, latin1, zero, one));
}

static void sets_are_read_by_name_and_size(const perion_points *points)
{
    int64_t size, indices[SCENE_LAYER];

    SEAL(size);
    SEAL(indices);
    EXPECT_REFUSED(NULLED, "points", perion_points_set_size(NULL, "left", &size));
    EXPECT_REFUSED(NULLED, "name", perion_points_set_size(points, NULL, &size));
    EXPECT_REFUSED(NULLED, "count", perion_points_set_size(points, "left", NULL));
    EXPECT_REFUSED(ARGUMENT, "set", perion_points_set_size(points, "lefd", &size));
    EXPECT_SAID("did you mean 'left'?");
    EXPECT_REFUSED(ARGUMENT, "set", perion_points_set_size(points, "", &size));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_set_size(points, latin1, &size));
    EXPECT_REFUSED(ARGUMENT, "name", perion_points_set_size(points, endless, &size));
    EXPECT_REFUSED(NULLED, "points", perion_points_get_set(NULL, "left", SCENE_LAYER, indices));
    EXPECT_REFUSED(NULLED, "name", perion_points_get_set(points, NULL, SCENE_LAYER, indices));
    EXPECT_REFUSED(NULLED, "indices", perion_points_get_set(points, "left", SCENE_LAYER, NULL));
    EXPECT_REFUSED(ARGUMENT, "set", perion_points_get_set(points, "center", SCENE_LAYER, indices));
    EXPECT_SAID("known are left, right, all");
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_get_set(points, "left", SCENE_LAYER - 1, indices));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_get_set(points, "left", 0, indices));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_get_set(points, "left", -1, indices));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_get_set(points, "left", INT64_MAX, indices));
    EXPECT_REFUSED(ARGUMENT, "indices",
                   perion_points_get_set(points, "left", SCENE_LAYER, MISALIGNED(int64_t)));
    EXPECT_SEALED(size);
    EXPECT_SEALED(indices);
}

static void names_of_sets_are_asked_for_with_room(const perion_points *points)
{
    char name[PERION_NAME_CAPACITY];
    int64_t count;

    SEAL(name);
    SEAL(count);
    EXPECT_REFUSED(NULLED, "points", perion_points_set_count(NULL, &count));
    EXPECT_REFUSED(NULLED, "count", perion_points_set_count(points, NULL));
    EXPECT_REFUSED(NULLED, "points", perion_points_get_set_name(NULL, 0, name, sizeof name));
    EXPECT_REFUSED(NULLED, "name", perion_points_get_set_name(points, 0, NULL, sizeof name));
    EXPECT_REFUSED(ARGUMENT, "index", perion_points_get_set_name(points, -1, name, sizeof name));
    EXPECT_REFUSED(ARGUMENT, "index", perion_points_get_set_name(points, 2, name, sizeof name));
    EXPECT_SAID("below the number of sets, 2");
    EXPECT_REFUSED(ARGUMENT, "index", perion_points_get_set_name(points, INT64_MAX, name, sizeof name));
    EXPECT_REFUSED(ARGUMENT, "capacity", perion_points_get_set_name(points, 0, name, 4));
    EXPECT_SAID("have 5 bytes");
    EXPECT_REFUSED(ARGUMENT, "capacity", perion_points_get_set_name(points, 0, name, 0));
    EXPECT_REFUSED(ARGUMENT, "capacity", perion_points_get_set_name(points, 0, name, -1));
    EXPECT_SEALED(name);
    EXPECT_SEALED(count);
}

void bad_sets(void)
{
    perion_points *points = scene_points();

    names_are_short_text_of_their_own(points);
    members_are_points_given_once(points);
    a_set_has_no_more_members_than_there_are_points(points);
    boxes_hold_points(points);
    sets_are_read_by_name_and_size(points);
    names_of_sets_are_asked_for_with_room(points);
    expect_sets_alone(points);
    EXPECT_OK(perion_points_destroy(&points));
}
