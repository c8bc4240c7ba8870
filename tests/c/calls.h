/*
 * Every call on a simulation, with arguments that are fine, in two lists: those that change it, and
 * those that only look. For tests in which it is the moment that is wrong.
 */
#ifndef CALLS_H
#define CALLS_H

#include <perion.h>

typedef struct scene_call {
    const char *name;
    perion_status (*make)(perion_simulation *simulation);
} scene_call;

/* Calls that change a simulation, but for destroy; each can be made while it is set up. */
extern const scene_call changing_calls[];
extern const int changing_call_count;

/* Calls on a const simulation, but for borrow_const; each can be made after an evaluation. */
extern const scene_call looking_calls[];
extern const int looking_call_count;

/* Makes all calls of a list and expects the status from each. */
void expect_of_all(const scene_call *calls, int count, perion_simulation *simulation,
                   perion_status expected);

#endif
