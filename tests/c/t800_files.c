/* Files for ParaView: single states and series. The directory to write to is the first argument. */
#include "harness.h"
#include "scene.h"

#include <stdio.h>
#include <string.h>

static char path[4096];
static const char *directory;

static const char *in_directory(const char *name)
{
    snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

/* Whether the first 4000 bytes of a file have a text in them. */
static int file_has(const char *name, const char *text)
{
    char start[4001] = {0};
    FILE *file = fopen(in_directory(name), "rb");

    if (file == NULL)
        return 0;
    size_t length = fread(start, 1, 4000, file);
    fclose(file);
    for (size_t k = 0; k < length; ++k)
        if (start[k] == '\0')
            start[k] = ' ';
    return strstr(start, text) != NULL;
}

static void every_field_can_be_written(void)
{
    perion_simulation *simulation = scene_simulation();

    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 1));
    EXPECT_OK(perion_simulation_write_vtk(simulation, in_directory("all.vtu"), SCENE_FIELDS,
                                          scene_fields));
    EXPECT(file_has("all.vtu", "NumberOfPoints=\"384\""));
    EXPECT(file_has("all.vtu", "Name=\"time_step_estimate\""));
    EXPECT(file_has("all.vtu", "Name=\"cauchy_stress\" NumberOfComponents=\"9\""));
    EXPECT_OK(perion_simulation_write_vtk(simulation, in_directory("none.vtu"), 0, NULL));
    EXPECT(file_has("none.vtu", "NumberOfPoints=\"384\""));
    EXPECT(!file_has("none.vtu", "damage"));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void a_series_counts_its_files(void)
{
    static const perion_field damage = PERION_FIELD_DAMAGE;
    perion_simulation *simulation = scene_simulation();

    for (int k = 0; k < 3; ++k) {
        EXPECT_OK(perion_simulation_write_series(simulation, in_directory("run.pvd"), 1, &damage));
        EXPECT_OK(perion_simulation_step(simulation, 0.5, 1));
    }
    EXPECT(file_has("run_000002.vtu", "Name=\"damage\""));
    EXPECT(file_has("run.pvd", "timestep=\"0.5\" part=\"0\" file=\"run_000001.vtu\""));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

/* A write that fails leaves the file of an earlier one and the series as they were. */
static void a_refused_write_leaves_the_older_file(void)
{
    static const perion_field twice[] = {PERION_FIELD_DAMAGE, PERION_FIELD_DAMAGE};
    static const perion_field acceleration = PERION_FIELD_ACCELERATION;
    perion_simulation *simulation = scene_simulation();

    EXPECT_OK(perion_simulation_write_vtk(simulation, in_directory("old.vtu"), 1, twice));
    EXPECT_REFUSED(PERION_ERROR_ARGUMENT, "fields",
                   perion_simulation_write_vtk(simulation, in_directory("old.vtu"), 2, twice));
    EXPECT(file_has("old.vtu", "Name=\"damage\""));
    EXPECT_REFUSED(PERION_ERROR_STATE, "evaluate",
                   perion_simulation_write_vtk(simulation, in_directory("old.vtu"), 1, &acceleration));
    EXPECT(file_has("old.vtu", "Name=\"damage\""));
    EXPECT_REFUSED(PERION_ERROR_STATE, "evaluate",
                   perion_simulation_write_series(simulation, in_directory("s.pvd"), 1, &acceleration));
    EXPECT_OK(perion_simulation_write_series(simulation, in_directory("s.pvd"), 1, twice));
    EXPECT(file_has("s.pvd", "s_000000.vtu"));
    EXPECT(!file_has("s.pvd", "s_000001.vtu"));
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

int main(int argc, char **argv)
{
    directory = argc > 1 ? argv[1] : ".";
    harness_begin();
    every_field_can_be_written();
    a_series_counts_its_files();
    a_refused_write_leaves_the_older_file();
    return harness_end();
}
