/*
 * Bad inputs, by object. All run in one process, which lives on: each is refused with a status and a
 * text that names function and argument, writes no output and changes no object.
 */
#ifndef BAD_H
#define BAD_H

#include "harness.h"
#include "scene.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

void bad_points(void);
void bad_sets(void);
void bad_model(void);
void bad_setup(void);
void bad_conditions(void);
void bad_fields(void);
void bad_drive(void);
void bad_statics(void);
void bad_views(void);

/* Text of 5000 bytes, of 256 bytes, and not UTF-8. */
extern char endless[5001];
extern char long_name[257];
extern const char *const latin1;

/* A number that is aligned for its type, plus one byte. */
extern char misaligned_store[64];
#define MISALIGNED(type) ((type *)(void *)(misaligned_store + 1))

/* A pointer to something that is no handle. */
#define NO_HANDLE(type) ((type *)(void *)no_handle_store)
extern uint64_t no_handle_store[8];

/* A simulation that has ended its set-up, moved and broken bonds; and one on which no call was made. */
perion_simulation *bad_running(void);

/* A refusal by a simulation, which stays as it is: `state` is what it was. */
#define REFUSE(status, fragment, call)                  \
    do {                                                \
        EXPECT_REFUSED(status, fragment, call);         \
        EXPECT(scene_is(&state, state_of(simulation))); \
    } while (0)

/* The same for a call with an output. */
#define REFUSE_OUTPUT(output, status, fragment, call) \
    do {                                              \
        SEAL(output);                                 \
        REFUSE(status, fragment, call);               \
        EXPECT_SEALED(output);                        \
    } while (0)

#define NULLED PERION_ERROR_NULL
#define ARGUMENT PERION_ERROR_ARGUMENT
#define STATE PERION_ERROR_STATE
#define UNSUPPORTED PERION_ERROR_UNSUPPORTED

#endif
