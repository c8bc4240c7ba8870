/* Several threads: distinct handles are free, one handle is for one at a time, and const calls overlap. */
#include "calls.h"
#include "harness.h"
#include "scene.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

enum { ROUNDS = 40 };

typedef struct worker {
    perion_simulation *simulation;
    atomic_int *running;
    int refused, wrong;
    int64_t steps;
} worker;

/* What flies about need not have an equilibrium that solve and relax could find. */
static void note(worker *own, perion_status status)
{
    own->refused += status == PERION_ERROR_STATE;
    own->wrong += status != PERION_OK && status != PERION_ERROR_STATE
                  && status != PERION_ERROR_CONVERGENCE;
}

static int nod(void *user, int64_t done, int64_t total, double time)
{
    (void)user;
    (void)done;
    (void)total;
    (void)time;
    return 0;
}

static void *step_on(void *user)
{
    worker *own = user;

    for (int k = 0; k < ROUNDS; ++k)
        note(own, perion_simulation_step(own->simulation, scene_time_step, 5));
    atomic_store(own->running, 0);
    return NULL;
}

/* One thread steps while another makes every call there is: each succeeds or is refused. */
static void calls_into_a_running_step_are_refused_or_made(int watched)
{
    atomic_int running = 1;
    worker stepper = {scene_simulation(), &running, 0, 0, 0}, caller = stepper;
    pthread_t thread;

    scene_throw(stepper.simulation);
    EXPECT_OK(perion_simulation_evaluate(stepper.simulation));
    if (watched)
        EXPECT_OK(perion_simulation_set_progress(stepper.simulation, nod, NULL));
    EXPECT_INT(pthread_create(&thread, NULL, step_on, &stepper), 0);
    while (atomic_load(&running)) {
        for (int k = 0; k < looking_call_count; ++k)
            note(&caller, looking_calls[k].make(caller.simulation));
        for (int k = 0; k < changing_call_count; ++k)
            if (strcmp(changing_calls[k].name, "release") != 0
                && strcmp(changing_calls[k].name, "set_progress") != 0)
                note(&caller, changing_calls[k].make(caller.simulation));
    }
    EXPECT_INT(pthread_join(thread, NULL), 0);
    EXPECT_INT(stepper.wrong, 0);
    EXPECT_INT(caller.wrong, 0);
    EXPECT(caller.refused > 0);
    EXPECT_OK(perion_simulation_evaluate(stepper.simulation));
    EXPECT_OK(perion_simulation_destroy(&stepper.simulation));
}

static void *look_on(void *user)
{
    worker *own = user;
    double values[SCENE_COUNT];

    for (int k = 0; k < ROUNDS; ++k) {
        perion_health health;
        perion_health_init(&health, sizeof(perion_health));
        own->wrong += perion_simulation_health(own->simulation, &health) != PERION_OK;
        own->wrong += perion_simulation_get(own->simulation, PERION_FIELD_DAMAGE, values, SCENE_COUNT)
                      != PERION_OK;
        own->steps += health.bonds;
    }
    return NULL;
}

/* The first of them builds the families; the others wait for it. */
static void const_calls_overlap_from_the_first_on(void)
{
    worker lookers[4];
    pthread_t threads[4];
    perion_simulation *simulation = scene_simulation();
    int64_t bonds = 0;

    for (int k = 0; k < 4; ++k) {
        lookers[k] = (worker){simulation, NULL, 0, 0, 0};
        EXPECT_INT(pthread_create(&threads[k], NULL, look_on, &lookers[k]), 0);
    }
    for (int k = 0; k < 4; ++k)
        EXPECT_INT(pthread_join(threads[k], NULL), 0);
    EXPECT_OK(perion_simulation_bond_count(simulation, &bonds));
    for (int k = 0; k < 4; ++k) {
        EXPECT_INT(lookers[k].wrong, 0);
        EXPECT_INT(lookers[k].steps, ROUNDS * bonds);
    }
    EXPECT_OK(perion_simulation_destroy(&simulation));
}

static void *live(void *user)
{
    worker *own = user;

    own->wrong += perion_simulation_set_threads(own->simulation, 3) != PERION_OK;
    own->wrong += perion_simulation_step(own->simulation, scene_time_step, 20) != PERION_OK;
    own->wrong += perion_simulation_evaluate(own->simulation) != PERION_OK;
    return NULL;
}

static void distinct_handles_do_not_meet(void)
{
    worker livers[4];
    pthread_t threads[4];
    scene_state result;

    for (int k = 0; k < 4; ++k) {
        livers[k] = (worker){scene_simulation(), NULL, 0, 0, 0};
        scene_throw(livers[k].simulation);
    }
    for (int k = 0; k < 4; ++k)
        EXPECT_INT(pthread_create(&threads[k], NULL, live, &livers[k]), 0);
    for (int k = 0; k < 4; ++k)
        EXPECT_INT(pthread_join(threads[k], NULL), 0);
    result = scene_result_of(livers[0].simulation);
    for (int k = 0; k < 4; ++k) {
        EXPECT_INT(livers[k].wrong, 0);
        EXPECT(scene_is(&result, scene_result_of(livers[k].simulation)));
        EXPECT_OK(perion_simulation_destroy(&livers[k].simulation));
    }
    scene_state_free(&result);
}

static void *fail(void *user)
{
    const char **text = user;

    text[0] = perion_last_error()[0] == '\0' ? "empty" : "not empty";
    perion_simulation_evaluate(NULL);
    text[1] = strstr(perion_last_error(), "perion_simulation_evaluate") ? "own" : "another's";
    return NULL;
}

static void each_thread_has_its_own_last_error(void)
{
    const char *texts[2] = {"", ""};
    pthread_t thread;

    EXPECT_REFUSED(PERION_ERROR_NULL, "simulation", perion_simulation_commit(NULL, 0.0));
    EXPECT_INT(pthread_create(&thread, NULL, fail, texts), 0);
    EXPECT_INT(pthread_join(thread, NULL), 0);
    EXPECT_TEXT(texts[0], "empty");
    EXPECT_TEXT(texts[1], "own");
    EXPECT_TEXT(perion_last_error(), "perion_simulation_commit: argument 'simulation' is NULL");
}

int main(void)
{
    harness_begin();
    calls_into_a_running_step_are_refused_or_made(0);
    calls_into_a_running_step_are_refused_or_made(1);
    const_calls_overlap_from_the_first_on();
    distinct_handles_do_not_meet();
    each_thread_has_its_own_last_error();
    return harness_end();
}
