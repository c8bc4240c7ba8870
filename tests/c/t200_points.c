/* Points: from the host's arrays and as blocks, their sets, horizons and end. */
#include "harness.h"

#include <math.h>

/* Five points of a plane in the first two of four numbers a point. */
enum { COUNT = 5, STRIDE = 4 };
static const double places[COUNT * STRIDE] = {
    0.0, 0.0, 9.0, 9.0, 1.0, 0.0, 9.0, 9.0, 2.0, 0.5, 9.0, 9.0, 0.0, 1.0, 9.0, 9.0, 1.0, 1.0, 9.0, 9.0,
};
static const double areas[COUNT] = {1.0, 0.5, 0.25, 2.0, 4.0};

static perion_points *from_arrays(void)
{
    perion_points *points = NULL;

    EXPECT_OK(perion_points_create(2, COUNT, places, STRIDE, areas, &points));
    return points;
}

static void arrays_with_a_stride_are_packed(void)
{
    perion_points *points = from_arrays();
    double coordinates[2 * COUNT], volumes[COUNT];
    int64_t count = 0;
    int32_t dimension = 0;

    EXPECT_OK(perion_points_count(points, &count));
    EXPECT_OK(perion_points_dimension(points, &dimension));
    EXPECT_INT(count, COUNT);
    EXPECT_INT(dimension, 2);
    EXPECT_OK(perion_points_get_coordinates(points, coordinates, 2 * COUNT));
    EXPECT_OK(perion_points_get_volumes(points, volumes, COUNT));
    for (int point = 0; point < COUNT; ++point) {
        EXPECT_REAL(coordinates[2 * point], places[STRIDE * point]);
        EXPECT_REAL(coordinates[2 * point + 1], places[STRIDE * point + 1]);
        EXPECT_REAL(volumes[point], areas[point]);
    }
    EXPECT_OK(perion_points_destroy(&points));
    EXPECT(points == NULL);
}

/* The last point needs no room behind its coordinates. */
static void the_last_stride_may_be_short(void)
{
    double tight[] = {0.0, 0.0, 9.0, 1.0, 0.0};
    perion_points *points = NULL;

    EXPECT_OK(perion_points_create(2, 2, tight, 3, areas, &points));
    EXPECT_OK(perion_points_destroy(&points));
}

static void a_block_runs_along_x_first(void)
{
    const double lower[] = {1.0, 2.0, 3.0}, upper[] = {2.5, 3.0, 3.5};
    double coordinates[18], volumes[6];
    perion_points *points = NULL;
    int64_t count = 0;

    EXPECT_OK(perion_points_create_block(3, lower, upper, 0.5, &points));
    EXPECT_OK(perion_points_count(points, &count));
    EXPECT_INT(count, 6);
    EXPECT_OK(perion_points_get_coordinates(points, coordinates, 18));
    EXPECT_OK(perion_points_get_volumes(points, volumes, 6));
    for (int point = 0; point < 6; ++point) {
        EXPECT_REAL(coordinates[3 * point], 1.25 + 0.5 * (point % 3));
        EXPECT_REAL(coordinates[3 * point + 1], point < 3 ? 2.25 : 2.75);
        EXPECT_REAL(coordinates[3 * point + 2], 3.25);
        EXPECT_REAL(volumes[point], 0.125);
    }
    EXPECT_OK(perion_points_destroy(&points));
}

static void sets_keep_their_order(void)
{
    const int64_t indices[] = {4, 0, 2};
    int64_t got[COUNT] = {0}, size = 0;
    perion_points *points = from_arrays();

    EXPECT_OK(perion_points_add_set(points, "three", 3, indices));
    EXPECT_OK(perion_points_set_size(points, "three", &size));
    EXPECT_INT(size, 3);
    EXPECT_OK(perion_points_get_set(points, "three", 3, got));
    for (int k = 0; k < 3; ++k)
        EXPECT_INT(got[k], indices[k]);
    EXPECT_OK(perion_points_set_size(points, "all", &size));
    EXPECT_INT(size, COUNT);
    EXPECT_OK(perion_points_get_set(points, "all", COUNT, got));
    for (int k = 0; k < COUNT; ++k)
        EXPECT_INT(got[k], k);
    EXPECT_OK(perion_points_destroy(&points));
}

static void a_box_holds_its_faces_and_may_be_open(void)
{
    const double lower[] = {1.0, -INFINITY}, upper[] = {INFINITY, 0.5};
    int64_t got[2] = {0}, size = 0;
    perion_points *points = from_arrays();

    EXPECT_OK(perion_points_add_set_box(points, "\xc3\xa9t\xc3\xa9", lower, upper));
    EXPECT_OK(perion_points_set_size(points, "\xc3\xa9t\xc3\xa9", &size));
    EXPECT_INT(size, 2);
    EXPECT_OK(perion_points_get_set(points, "\xc3\xa9t\xc3\xa9", 2, got));
    EXPECT_INT(got[0], 1);
    EXPECT_INT(got[1], 2);
    EXPECT_OK(perion_points_destroy(&points));
}

/* With horizons of their own, points see as far as these reach: the row 0-1 of length 1, and no more. */
static void horizons_replace_that_of_the_model(void)
{
    const double horizons[COUNT] = {1.01, 0.1, 0.1, 0.1, 0.1};
    double neighbors[COUNT] = {0.0};
    perion_points *points = from_arrays();
    perion_model *model = NULL;
    perion_simulation *simulation = NULL;
    int64_t bonds = 0;

    EXPECT_OK(perion_points_set_horizons(points, COUNT, horizons));
    EXPECT_OK(perion_model_create("bond_based", &model));
    EXPECT_OK(perion_model_set(model, "density", 1.0));
    EXPECT_OK(perion_model_set(model, "youngs_modulus", 1.0));
    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_NEIGHBOR_COUNT, neighbors, COUNT));
    EXPECT_REAL(neighbors[0], 2.0);
    EXPECT_REAL(neighbors[1], 0.0);
    EXPECT_OK(perion_simulation_bond_count(simulation, &bonds));
    EXPECT_INT(bonds, 2);
    EXPECT_OK(perion_simulation_destroy(&simulation));
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_points_destroy(&points));
}

static void nothing_can_be_destroyed(void)
{
    perion_points *points = NULL;

    EXPECT_OK(perion_points_destroy(NULL));
    EXPECT_OK(perion_points_destroy(&points));
    points = from_arrays();
    EXPECT_OK(perion_points_destroy(&points));
    EXPECT_OK(perion_points_destroy(&points));
}

int main(void)
{
    harness_begin();
    arrays_with_a_stride_are_packed();
    the_last_stride_may_be_short();
    a_block_runs_along_x_first();
    sets_keep_their_order();
    a_box_holds_its_faces_and_may_be_open();
    horizons_replace_that_of_the_model();
    nothing_can_be_destroyed();
    return harness_end();
}
