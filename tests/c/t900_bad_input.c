/* Bad inputs to every function, in one process. See bad.h. */
#include "bad.h"

#include <string.h>

char endless[5001];
char long_name[257];
const char *const latin1 = "d\xe9lta";
char misaligned_store[64];
uint64_t no_handle_store[8] = {1, 2, 3};

perion_simulation *bad_running(void)
{
    perion_simulation *simulation = scene_simulation();

    scene_throw(simulation);
    EXPECT_OK(perion_simulation_step(simulation, scene_time_step, 12));
    return simulation;
}

int main(void)
{
    memset(endless, 'x', sizeof endless - 1);
    memset(long_name, 'x', sizeof long_name - 1);
    harness_begin();
    bad_points();
    bad_sets();
    bad_model();
    bad_setup();
    bad_conditions();
    bad_fields();
    bad_drive();
    bad_statics();
    bad_views();
    EXPECT(harness_refusals() >= 400);
    return harness_end();
}
