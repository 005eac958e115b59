/* Scenes: YAML files and `key=value` settings that describe a system.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SCENE_H
#define SALTUS_SCENE_H

#include "saltus/system.h"

SALTUS_API_BEGIN

enum { SALTUS_SCENE_STATE_MAX = SALTUS_STATE_MAX };

/* A scene as read: plain values, owned by the caller, to be changed with saltus_scene_set and handed to
 * saltus_system_new as `spec`. */
typedef struct saltus_scene {
    char name[128];  /* built-in name or file name without folder and ending, at most 127 bytes of it */
    char title[160]; /* one line for figures and listings; may be empty */
    saltus_spec spec;
    int initial_count;                      /* entries of `initial`; 0: the system's default state */
    double initial[SALTUS_SCENE_STATE_MAX]; /* q then q' then extra states, at section phase 0; NAN: the entry
                                               of the system's default state */
} saltus_scene;

/* Read a YAML scene file, or a built-in scene when `source` is the name of one (no such name contains a '/'
 * or a '.'). Errors: SALTUS_BAD_INPUT (message: file, line or key, value, what would be right), SALTUS_IO
 * (cannot be read). */
saltus_status saltus_scene_load(const char *source, saltus_scene *scene, saltus_message *message);
/* Read a scene from text; `origin` names it in messages. */
saltus_status saltus_scene_parse(const char *text, size_t length, const char *origin, saltus_scene *scene,
                                 saltus_message *message);
/* Release what a scene holds: the model, where its equations stand in the scene. Systems keep it as long as
 * they need it; copies of a scene or of its specification are good as long as the scene is, or a system made
 * of them. A zeroed scene is accepted. */
void saltus_scene_clear(saltus_scene *scene);
/* Apply one `key=value`: a parameter of the model, `observe` (saltus_spec), or d, r, xi, sides, weight of the
 * stop(s). With several
 * stops `d=` sets all of them and `d1=`, `d2=`, ... the first, second, ... one. `q1=`, `v1=`, ... set entries
 * of the initial state, and so do the names of a text (saltus_system_state_name); in a scene that gives none
 * the others stay those of the system's default state. The scene is unchanged on error. */
saltus_status saltus_scene_set(saltus_scene *scene, const char *assignment, saltus_message *message);
/* Choose the section of a scene of equations without forcing, as its key `section` does: "maxima", "impact:
 * 1, side: lower", "zero: x - 1, direction: up", with or without braces. Copies of the scene made before are
 * good only as long as systems made of them are. The scene is unchanged on error. Errors: SALTUS_BAD_INPUT,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_scene_set_section(saltus_scene *scene, const char *section, saltus_message *message);
/* Where a scene's trajectory starts, at section phase 0, in the system that was built from its `spec`: the
 * scene's initial state, what it leaves open being that of saltus_system_default_state. `state` has length
 * saltus_system_dimension. Errors: SALTUS_BAD_INPUT where the scene's state has another number of entries, is
 * beyond a stop, or no default is found. */
saltus_status saltus_scene_state(const saltus_scene *scene, const saltus_system *system, double *state,
                                 saltus_message *message);

/* The same for a specification alone and a key whose value is a number: a parameter, or d, r, xi, d1, ... It
 * is unchanged on error. What has become of it: saltus_spec_get. Errors: SALTUS_BAD_INPUT (unknown key, value
 * out of its range). */
saltus_status saltus_spec_set(saltus_spec *spec, const char *key, double value, saltus_message *message);

/* The built-in scenes, in the order of listing. Static storage; NULL beyond the last. */
int saltus_scene_builtin_count(void);
const char *saltus_scene_builtin_name(int k);
const char *saltus_scene_builtin_text(int k);

SALTUS_API_END
#endif
