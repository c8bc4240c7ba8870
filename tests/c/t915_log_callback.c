/*
 * A log callback that looks at its simulation while that is being built by a const call: it gets a
 * result or a refusal, and does not hang.
 */
#define _POSIX_C_SOURCE 200809L
#include "calls.h"
#include "harness.h"

#include <stdio.h>
#include <unistd.h>

typedef struct watcher {
    perion_simulation *simulation;
    int calls;
} watcher;

static void look(void *user, perion_log_level level, const char *message)
{
    watcher *own = user;

    (void)message;
    EXPECT_INT(level, PERION_LOG_LEVEL_WARNING);
    ++own->calls;
    for (int k = 0; k < looking_call_count; ++k) {
        perion_status status = looking_calls[k].make(own->simulation);
        EXPECT(status != PERION_ERROR_INTERNAL && status != PERION_ERROR_POISONED);
    }
}

/* Two points that see each other and one that stands alone, of which the log is told. */
static perion_simulation *with_an_isolated_point(void)
{
    static const double places[] = {0.0, 0.0, 1.0, 0.0, 9.0, 9.0}, volumes[] = {1.0, 1.0, 1.0};
    perion_points *points = NULL;
    perion_model *model = NULL;
    perion_simulation *simulation = NULL;

    EXPECT_OK(perion_points_create(2, 3, places, 2, volumes, &points));
    EXPECT_OK(perion_model_create("bond_based", &model));
    EXPECT_OK(perion_model_set(model, "density", 1.0));
    EXPECT_OK(perion_model_set(model, "youngs_modulus", 1.0));
    EXPECT_OK(perion_model_set(model, "horizon", 1.5));
    EXPECT_OK(perion_simulation_create(points, model, &simulation));
    EXPECT_OK(perion_points_destroy(&points));
    EXPECT_OK(perion_model_destroy(&model));
    return simulation;
}

int main(void)
{
    watcher own = {NULL, 0};
    perion_health health;

    harness_begin();
    alarm(20);
    own.simulation = with_an_isolated_point();
    perion_health_init(&health, sizeof(perion_health));
    EXPECT_OK(perion_simulation_set_log(own.simulation, look, &own));
    EXPECT_OK(perion_simulation_health(own.simulation, &health));
    EXPECT_INT(health.isolated_points, 1);
    EXPECT_INT(health.first_isolated_point, 2);
    EXPECT_INT(own.calls, 1);
    EXPECT_OK(perion_simulation_destroy(&own.simulation));
    return harness_end();
}
