/* Bad inputs to points. */
#include "bad.h"

enum { COUNT = 4 };
static const double corners[3 * COUNT] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
static const double volumes[COUNT] = {1.0, 1.0, 1.0, 1.0};
static perion_points *made;

/* A refusal that makes nothing. */
#define MAKE_NOTHING(status, fragment, call)    \
    do {                                        \
        SEAL(made);                             \
        EXPECT_REFUSED(status, fragment, call); \
        EXPECT_SEALED(made);                    \
    } while (0)

static void create_takes_counts_that_fit(void)
{
    static const int32_t dimensions[] = {0, 1, 4, -3, INT32_MAX, INT32_MIN};

    for (size_t k = 0; k < sizeof dimensions / sizeof dimensions[0]; ++k)
        MAKE_NOTHING(ARGUMENT, "dimension",
                     perion_points_create(dimensions[k], COUNT, corners, 3, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "count", perion_points_create(3, 0, corners, 3, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "count", perion_points_create(3, -1, corners, 3, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "count", perion_points_create(3, INT64_MIN, corners, 3, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "count", perion_points_create(3, INT64_MAX, corners, 0, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "count", perion_points_create(2, 1LL << 40, corners, 0, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "coordinates",
                 perion_points_create(3, INT64_MAX, corners, 3, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "coordinates",
                 perion_points_create(3, COUNT, corners, INT64_MAX, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "coordinates",
                 perion_points_create(3, COUNT, corners, INT64_MAX / 4, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "stride", perion_points_create(3, COUNT, corners, 2, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "stride", perion_points_create(3, COUNT, corners, 0, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "stride", perion_points_create(3, COUNT, corners, -3, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "stride", perion_points_create(3, COUNT, corners, INT64_MIN, volumes, &made));
}

static void create_takes_pointers_that_lead_somewhere(void)
{
    MAKE_NOTHING(NULLED, "coordinates", perion_points_create(3, COUNT, NULL, 3, volumes, &made));
    MAKE_NOTHING(NULLED, "volumes", perion_points_create(3, COUNT, corners, 3, NULL, &made));
    EXPECT_REFUSED(NULLED, "points", perion_points_create(3, COUNT, corners, 3, volumes, NULL));
    MAKE_NOTHING(ARGUMENT, "coordinates",
                 perion_points_create(3, 1, MISALIGNED(double), 3, volumes, &made));
    MAKE_NOTHING(ARGUMENT, "volumes",
                 perion_points_create(3, 1, corners, 3, MISALIGNED(double), &made));
    EXPECT_REFUSED(ARGUMENT, "points",
                   perion_points_create(3, 1, corners, 3, volumes, MISALIGNED(perion_points *)));
}

static void create_takes_numbers_that_make_sense(void)
{
    static const double wild[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300};
    static const double empty[] = {NAN, INFINITY, -INFINITY, 0.0, -0.0, -1.0};
    double coordinates[3 * COUNT], own[COUNT];

    for (size_t k = 0; k < sizeof wild / sizeof wild[0]; ++k) {
        for (int n = 0; n < 3 * COUNT; ++n)
            coordinates[n] = n == 7 ? wild[k] : corners[n];
        MAKE_NOTHING(ARGUMENT, "coordinates",
                     perion_points_create(3, COUNT, coordinates, 3, volumes, &made));
        EXPECT_SAID("point 2, axis 1");
    }
    for (size_t k = 0; k < sizeof empty / sizeof empty[0]; ++k) {
        for (int n = 0; n < COUNT; ++n)
            own[n] = n == 3 ? empty[k] : 1.0;
        MAKE_NOTHING(ARGUMENT, "volumes", perion_points_create(3, COUNT, corners, 3, own, &made));
        EXPECT_SAID("point 3");
    }
    for (int n = 0; n < 3 * COUNT; ++n)
        coordinates[n] = corners[n % 9];
    coordinates[9] = -0.0;
    MAKE_NOTHING(ARGUMENT, "coordinates",
                 perion_points_create(3, COUNT, coordinates, 3, volumes, &made));
    EXPECT_SAID("points 0 and 3");
}

static void a_block_takes_a_box_and_a_spacing(void)
{
    static const double zero[] = {0.0, 0.0, 0.0}, one[] = {1.0, 1.0, 1.0}, far[] = {1e9, 1e9, 1e9};
    static const double flat[] = {1.0, 0.0, 1.0}, wrong[] = {1.0, NAN, 1.0}, open[] = {INFINITY, 1.0, 1.0};
    static const double spacings[] = {0.0, -1.0, NAN, INFINITY, -INFINITY, 3.0, 1e300};

    MAKE_NOTHING(ARGUMENT, "dimension", perion_points_create_block(1, zero, one, 0.5, &made));
    MAKE_NOTHING(ARGUMENT, "dimension", perion_points_create_block(4, NULL, NULL, 0.5, &made));
    MAKE_NOTHING(ARGUMENT, "dimension", perion_points_create_block(INT32_MIN, zero, one, 0.5, &made));
    MAKE_NOTHING(NULLED, "lower", perion_points_create_block(3, NULL, one, 0.5, &made));
    MAKE_NOTHING(NULLED, "upper", perion_points_create_block(3, zero, NULL, 0.5, &made));
    EXPECT_REFUSED(NULLED, "points", perion_points_create_block(3, zero, one, 0.5, NULL));
    MAKE_NOTHING(ARGUMENT, "lower",
                 perion_points_create_block(3, MISALIGNED(double), one, 0.5, &made));
    MAKE_NOTHING(ARGUMENT, "upper",
                 perion_points_create_block(3, zero, MISALIGNED(double), 0.5, &made));
    MAKE_NOTHING(ARGUMENT, "upper", perion_points_create_block(3, one, zero, 0.5, &made));
    MAKE_NOTHING(ARGUMENT, "upper", perion_points_create_block(3, zero, flat, 0.5, &made));
    MAKE_NOTHING(ARGUMENT, "upper", perion_points_create_block(3, zero, wrong, 0.5, &made));
    MAKE_NOTHING(ARGUMENT, "upper", perion_points_create_block(3, zero, open, 0.5, &made));
    MAKE_NOTHING(ARGUMENT, "lower", perion_points_create_block(3, wrong, one, 0.5, &made));
    for (size_t k = 0; k < sizeof spacings / sizeof spacings[0]; ++k)
        MAKE_NOTHING(ARGUMENT, "spacing", perion_points_create_block(3, zero, one, spacings[k], &made));
    MAKE_NOTHING(ARGUMENT, "spacing", perion_points_create_block(3, zero, one, 1e-300, &made));
    MAKE_NOTHING(ARGUMENT, "count", perion_points_create_block(3, zero, far, 1.0, &made));
}

/* Numbers of 1e17 are 16 apart: points at a spacing of 1 would fall together. */
static void a_block_takes_a_spacing_that_its_corners_can_resolve(void)
{
    static const double lower[] = {1e17, 0.0}, upper[] = {1e17 + 64.0, 1.0};

    MAKE_NOTHING(ARGUMENT, "spacing", perion_points_create_block(2, lower, upper, 1.0, &made));
}

static perion_points *some(void)
{
    perion_points *points = NULL;

    EXPECT_OK(perion_points_create(3, COUNT, corners, 3, volumes, &points));
    return points;
}

static void horizons_are_lengths(void)
{
    static const double bad[] = {0.0, -1.0, NAN, INFINITY, -INFINITY};
    double horizons[COUNT] = {1.0, 1.0, 1.0, 1.0};
    perion_points *points = some();

    EXPECT_REFUSED(NULLED, "points", perion_points_set_horizons(NULL, COUNT, horizons));
    EXPECT_REFUSED(NULLED, "horizons", perion_points_set_horizons(points, COUNT, NULL));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_set_horizons(points, COUNT - 1, horizons));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_set_horizons(points, 0, NULL));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_set_horizons(points, -1, horizons));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_set_horizons(points, INT64_MIN, horizons));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_set_horizons(points, INT64_MAX, horizons));
    EXPECT_REFUSED(ARGUMENT, "horizons",
                   perion_points_set_horizons(points, COUNT, MISALIGNED(double)));
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; ++k) {
        horizons[1] = bad[k];
        EXPECT_REFUSED(ARGUMENT, "horizons", perion_points_set_horizons(points, COUNT, horizons));
        EXPECT_SAID("point 1");
    }
    EXPECT_OK(perion_points_destroy(&points));
}

static void readers_take_the_right_lengths(void)
{
    perion_points *points = some();
    double out[3 * COUNT];
    int64_t count;
    int32_t dimension;

    SEAL(out);
    SEAL(count);
    SEAL(dimension);
    EXPECT_REFUSED(NULLED, "points", perion_points_count(NULL, &count));
    EXPECT_REFUSED(NULLED, "count", perion_points_count(points, NULL));
    EXPECT_REFUSED(ARGUMENT, "count", perion_points_count(points, MISALIGNED(int64_t)));
    EXPECT_REFUSED(ARGUMENT, "points", perion_points_count(NO_HANDLE(perion_points), &count));
    EXPECT_REFUSED(ARGUMENT, "points", perion_points_count(MISALIGNED(perion_points), &count));
    EXPECT_REFUSED(NULLED, "points", perion_points_dimension(NULL, &dimension));
    EXPECT_REFUSED(NULLED, "dimension", perion_points_dimension(points, NULL));
    EXPECT_REFUSED(ARGUMENT, "dimension", perion_points_dimension(points, MISALIGNED(int32_t)));
    EXPECT_REFUSED(NULLED, "points", perion_points_get_coordinates(NULL, out, 3 * COUNT));
    EXPECT_REFUSED(NULLED, "coordinates", perion_points_get_coordinates(points, NULL, 3 * COUNT));
    EXPECT_REFUSED(ARGUMENT, "length", perion_points_get_coordinates(points, out, COUNT));
    EXPECT_REFUSED(ARGUMENT, "length", perion_points_get_coordinates(points, out, -1));
    EXPECT_REFUSED(ARGUMENT, "length", perion_points_get_coordinates(points, out, INT64_MAX));
    EXPECT_REFUSED(ARGUMENT, "coordinates",
                   perion_points_get_coordinates(points, MISALIGNED(double), 3 * COUNT));
    EXPECT_REFUSED(NULLED, "points", perion_points_get_volumes(NULL, out, COUNT));
    EXPECT_REFUSED(NULLED, "volumes", perion_points_get_volumes(points, NULL, COUNT));
    EXPECT_REFUSED(ARGUMENT, "length", perion_points_get_volumes(points, out, 0));
    EXPECT_REFUSED(ARGUMENT, "length", perion_points_get_volumes(points, out, INT64_MIN));
    EXPECT_SEALED(out);
    EXPECT_SEALED(count);
    EXPECT_SEALED(dimension);
    EXPECT_OK(perion_points_destroy(&points));
}

static void only_points_are_destroyed_as_points(void)
{
    perion_model *model = scene_model();
    perion_points *disguised = (perion_points *)(void *)model;
    int64_t count;

    SEAL(count);
    EXPECT_REFUSED(ARGUMENT, "points", perion_points_destroy(&disguised));
    EXPECT((void *)disguised == (void *)model);
    EXPECT_REFUSED(ARGUMENT, "points", perion_points_count(disguised, &count));
    EXPECT_SEALED(count);
    disguised = NO_HANDLE(perion_points);
    EXPECT_REFUSED(ARGUMENT, "points", perion_points_destroy(&disguised));
    EXPECT_OK(perion_model_destroy(&model));
}

static void files_have_names(void)
{
    MAKE_NOTHING(NULLED, "path", perion_points_read(NULL, &made));
    MAKE_NOTHING(ARGUMENT, "path", perion_points_read(latin1, &made));
    MAKE_NOTHING(ARGUMENT, "path", perion_points_read(endless, &made));
    MAKE_NOTHING(PERION_ERROR_IO, "''", perion_points_read("", &made));
    MAKE_NOTHING(PERION_ERROR_IO, "/dev/zero", perion_points_read("/dev/zero", &made));
    EXPECT_REFUSED(NULLED, "points", perion_points_read("none.txt", NULL));
}

void bad_points(void)
{
    create_takes_counts_that_fit();
    files_have_names();
    create_takes_pointers_that_lead_somewhere();
    create_takes_numbers_that_make_sense();
    a_block_takes_a_box_and_a_spacing();
    a_block_takes_a_spacing_that_its_corners_can_resolve();
    horizons_are_lengths();
    readers_take_the_right_lengths();
    only_points_are_destroyed_as_points();
}
