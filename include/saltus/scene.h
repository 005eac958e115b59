/* Scenes: YAML files and `key=value` settings that describe a system.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SCENE_H
#define SALTUS_SCENE_H

#include "saltus/system.h"

SALTUS_API_BEGIN

enum { SALTUS_SCENE_STATE_MAX = SALTUS_STATE_MAX };

/* A scene as read: plain values owned by the caller, to be changed with saltus_scene_set. saltus_system_new
 * builds a system from `spec`. */
typedef struct saltus_scene {
    char name[128];  /* built-in name, or file name without folder and ending, cut off after 127 bytes */
    char title[160]; /* one line for figures and listings; may be empty */
    saltus_spec spec;
    int initial_count;                      /* entries of `initial`; 0: the system's default state */
    double initial[SALTUS_SCENE_STATE_MAX]; /* q, q', extra states at section phase 0; a NAN stands for the
                                               entry of the system's default state */
} saltus_scene;

/* Read a YAML scene file, or a built-in scene if `source` is the name of one (such names contain no '/' and
 * no '.'). Errors: SALTUS_BAD_INPUT (message: file, line or key, value, what would be right), SALTUS_IO
 * (cannot be read). */
saltus_status saltus_scene_load(const char *source, saltus_scene *scene, saltus_message *message);
/* Read a scene from text; messages call it `origin`. */
saltus_status saltus_scene_parse(const char *text, size_t length, const char *origin, saltus_scene *scene,
                                 saltus_message *message);
/* Release the model of a scene that defines its own equations. Systems keep the model as long as they need
 * it; copies of the scene or of its specification stay valid only as long as the scene or a system made from
 * them exists. A zeroed scene is accepted. */
void saltus_scene_clear(saltus_scene *scene);
/* Apply one `key=value`: a parameter of the model, `observe` (saltus_spec), or d, r, xi, sides, weight of the
 * stops. With several stops `d=` sets all of them and `d1=`, `d2=`, ... the first, second, ... one. `q1=`,
 * `v1=`, ..., or the names from a text model (saltus_system_state_name), set entries of the initial state; if
 * the scene gives no initial state the other entries keep the system's default. The scene is unchanged on
 * error. */
saltus_status saltus_scene_set(saltus_scene *scene, const char *assignment, saltus_message *message);
/* Whether setting `later` leaves nothing of what `earlier` has set: they name the same value (q1 and x, d and
 * d1 of the only stop), or `later` that of all stops and `earlier` one of them (d2 and then d), or `later`
 * takes the stops away. Both are keys of saltus_scene_set, alone or with "=value"; `scene` has all
 * settings. */
bool saltus_scene_overrides(const saltus_scene *scene, const char *later, const char *earlier);
/* Choose the section of a scene of equations without forcing, like its key `section`: "maxima", "impact: 1,
 * side: lower", "zero: x - 1, direction: up", with or without braces. Earlier copies of the scene are then
 * valid only as long as systems made from them exist. The scene is unchanged on error. Errors:
 * SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_scene_set_section(saltus_scene *scene, const char *section, saltus_message *message);
/* The initial state of a scene at section phase 0, in the system built from its `spec`; open entries are
 * those of saltus_system_default_state. `state` has length saltus_system_dimension. Errors: SALTUS_BAD_INPUT
 * if the scene's state has another number of entries or lies beyond a stop, or if no default state is
 * found. */
saltus_status saltus_scene_state(const saltus_scene *scene, const saltus_system *system, double *state,
                                 saltus_message *message);

/* Set a numeric key of a specification: a parameter, or d, r, xi, d1, ... saltus_spec_get reads it back. The
 * specification is unchanged on error. Errors: SALTUS_BAD_INPUT (unknown key, value out of range). */
saltus_status saltus_spec_set(saltus_spec *spec, const char *key, double value, saltus_message *message);

/* The built-in scenes, in the order of listing. Static storage; NULL beyond the last. */
int saltus_scene_builtin_count(void);
const char *saltus_scene_builtin_name(int k);
const char *saltus_scene_builtin_text(int k);

SALTUS_API_END
#endif
