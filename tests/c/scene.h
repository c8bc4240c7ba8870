/*
 * A body for the tests: a bar of 12 x 8 x 4 points, pulled apart so that bonds break, and its state as
 * bytes, to be compared before and after.
 */
#ifndef SCENE_H
#define SCENE_H

#include <perion.h>

#include <stddef.h>
#include <stdint.h>

enum { SCENE_COUNT = 12 * 8 * 4, SCENE_LENGTH = 3 * SCENE_COUNT, SCENE_LAYER = 8 * 4 };

/* Numbers of the widest field. */
enum { SCENE_ROOM = 9 * SCENE_COUNT };

/* All fields that a body in 3D has, for loops. */
enum { SCENE_FIELDS = 27 };
extern const perion_field scene_fields[SCENE_FIELDS];

/* How many numbers a field has. */
int64_t scene_numbers(perion_field field);

/* The points, of spacing 1, with a layer called "left" and one called "right" at the ends. */
perion_points *scene_points(void);

/* A material with moduli, density and spacing of about 1; bonds break at a stretch of 5 %. */
perion_model *scene_model(void);

/* Both brought together, on two threads, at rest and free; set-up has not ended. */
perion_simulation *scene_simulation(void);

/* Gives the points velocities that tear the bar apart within some ten steps. */
void scene_throw(perion_simulation *simulation);

/* A stable time step for the scene. */
extern const double scene_time_step;

/* What a simulation is, as far as calls can tell. */
typedef struct scene_state {
    unsigned char *data;
    size_t bytes;
} scene_state;

/* All of it; ends set-up. */
scene_state scene_state_of(const perion_simulation *simulation);

/* As far as it can be told without ending set-up. */
scene_state scene_early_state_of(const perion_simulation *simulation);

/* Fields that hosts read off: displacement, velocity, force, damage; evaluates. */
scene_state scene_result_of(perion_simulation *simulation);

/* Whether two states have the same bytes; frees the second. */
int scene_is(const scene_state *known, scene_state state);

void scene_state_free(scene_state *state);

#endif
