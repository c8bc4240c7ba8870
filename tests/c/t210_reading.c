/* Points from files: text, meshes, what the library has written, and files that are not what they should be. */
#include "harness.h"
#include "scene.h"

#include <stdio.h>
#include <string.h>

static char path[4096];

static const char *in_place(const char *place, const char *name)
{
    snprintf(path, sizeof path, "%s/%s", place, name);
    return path;
}

static const char *written(const char *place, const char *name, const char *text)
{
    FILE *file = fopen(in_place(place, name), "wb");

    EXPECT(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
    return path;
}

static void expect_set(const perion_points *points, const char *name, int64_t expected)
{
    int64_t size = 0;

    EXPECT_OK(perion_points_set_size(points, name, &size));
    EXPECT_INT(size, expected);
}

static void text_has_a_point_a_line(const char *place)
{
    double coordinates[9], volumes[3];
    char name[PERION_NAME_CAPACITY];
    perion_points *points = NULL;
    int64_t count = 0;

    EXPECT_OK(perion_points_read(written(place, "cloud.txt",
                                         "# x y z block volume\n"
                                         "0 0 0 1 0.5\n"
                                         "1.0d0, 0, 0, 2, 0.25  ! of Fortran\n\n"
                                         "0 1 0 1 0.125\n"),
                                 &points));
    EXPECT_OK(perion_points_count(points, &count));
    EXPECT_INT(count, 3);
    EXPECT_OK(perion_points_get_coordinates(points, coordinates, 9));
    EXPECT_OK(perion_points_get_volumes(points, volumes, 3));
    EXPECT_REAL(coordinates[3], 1.0);
    EXPECT_REAL(volumes[1], 0.25);
    EXPECT_OK(perion_points_set_count(points, &count));
    EXPECT_INT(count, 2);
    EXPECT_OK(perion_points_get_set_name(points, 1, name, sizeof name));
    EXPECT_TEXT(name, "block_2");
    EXPECT_OK(perion_points_get_set_name(points, 0, name, 8));
    EXPECT_TEXT(name, "block_1");
    expect_set(points, "block_1", 2);
    EXPECT_OK(perion_points_destroy(&points));
}

static void a_mesh_has_a_point_an_element(const char *place)
{
    double volume = 0.0, coordinates[3];
    perion_points *points = NULL;

    EXPECT_OK(perion_points_read(written(place, "cell.inp",
                                         "*Node\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n"
                                         "*Element, type=C3D4, elset=body\n10,1,2,3,4\n"
                                         "*Nset, nset=tip\n4\n"),
                                 &points));
    EXPECT_OK(perion_points_get_volumes(points, &volume, 1));
    EXPECT_NEAR(volume, 1.0 / 6.0, 1e-16);
    EXPECT_OK(perion_points_get_coordinates(points, coordinates, 3));
    EXPECT_REAL(coordinates[2], 0.25);
    expect_set(points, "body", 1);
    expect_set(points, "tip", 1);
    EXPECT_OK(perion_points_destroy(&points));
}

/* Written and read again, the points are where they were moved to, to the last bit. */
static void what_was_written_can_be_read(const char *place)
{
    static const perion_field fields[] = {PERION_FIELD_VOLUME};
    double moved[3 * SCENE_COUNT], read[3 * SCENE_COUNT];
    perion_simulation *simulation = scene_simulation();
    perion_points *points = NULL;
    int64_t count = 0;
    int32_t dimension = 0;

    scene_throw(simulation);
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 3));
    EXPECT_OK(perion_simulation_write_vtk(simulation, in_place(place, "moved.vtu"), 1, fields));
    EXPECT_OK(perion_points_read(path, &points));
    EXPECT_OK(perion_simulation_point_count(simulation, &count));
    EXPECT_OK(perion_simulation_dimension(simulation, &dimension));
    EXPECT_INT(count, SCENE_COUNT);
    EXPECT_INT(dimension, 3);
    EXPECT_OK(perion_simulation_get(simulation, PERION_FIELD_POSITION, moved, 3 * SCENE_COUNT));
    EXPECT_OK(perion_points_get_coordinates(points, read, 3 * SCENE_COUNT));
    EXPECT(memcmp(moved, read, sizeof moved) == 0);
    EXPECT_OK(perion_points_destroy(&points));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* A refusal makes nothing, and says where and what. */
static void refuse(perion_status status, const char *file, const char *where, const char *what)
{
    perion_points *points;

    SEAL(points);
    EXPECT_REFUSED(status, where, perion_points_read(file, &points));
    EXPECT_SAID(what);
    EXPECT_SEALED(points);
}

static void what_is_wrong_is_said_with_its_line(const char *place)
{
    refuse(PERION_ERROR_FORMAT, written(place, "bad.txt", "0 0 0 1\n1 0 0 x\n"), "bad.txt', line 2",
           "expected a positive number as volume, found 'x'");
    refuse(PERION_ERROR_FORMAT, written(place, "bad.inp", "*Node\n1,0,0\n*Element, type=C3D4\n5,1,2,3\n"),
           "bad.inp', line 5", "expected 1 more nodes");
    refuse(PERION_ERROR_UNSUPPORTED, written(place, "bad.inp", "*Include, input=other.inp\n"),
           "bad.inp', line 1", "'*Include, input=other.inp' is not read");
    refuse(PERION_ERROR_FORMAT, written(place, "bad.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n"),
           "bad.msh', line 5", "a number of blocks");
    refuse(PERION_ERROR_FORMAT, written(place, "bad.vtu", "<VTKFile type='UnstructuredGrid'>\n<Piece/>\n"),
           "bad.vtu', line 2", "NumberOfPoints");
    refuse(PERION_ERROR_IO, in_place(place, "none.msh"), "none.msh", "cannot be read");
    refuse(PERION_ERROR_IO, place, place, "is not a file");
}

int main(int argc, char **argv)
{
    const char *place = argc > 1 ? argv[1] : ".";

    harness_begin();
    text_has_a_point_a_line(place);
    a_mesh_has_a_point_an_element(place);
    what_was_written_can_be_read(place);
    what_is_wrong_is_said_with_its_line(place);
    return harness_end();
}
