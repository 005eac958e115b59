/* Private: how a scene's text becomes plain values.
 *
 *     text -> tree of values (document.c) -> numbers, stops, initial state, trial system (read.c)
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SCENE_PRIVATE_H
#define SALTUS_SCENE_PRIVATE_H

#include "base/word.h"
#include "saltus/scene.h"
#include "scene/document.h"

/* The keys of a stop, in this order everywhere. */
enum { stop_xi, stop_d, stop_r, stop_sides, stop_weight, stop_coordinate, stop_keys };
extern const char *const saltus_stop_keys[stop_keys];

/* The lists of an initial state, in the order of the state vector. */
enum { initial_q, initial_v, initial_z, initial_lists };
extern const char *const saltus_initial_keys[initial_lists];

/* Turn a mapping with the keys of a scene into a checked scene, which has no name yet. Keys that no scene has
 * are refused, or passed over where `others` says that the mapping holds more than a scene. The scene is
 * unchanged on error. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_scene_read(const saltus_source *source, const saltus_node *root, bool others,
                                saltus_scene *scene);

/* The model that a mapping of equations, which may stand in another text (`place`), describes for a scene,
 * with the stops' coordinates; to be released. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_scene_read_text(const saltus_source *source, const saltus_node *root,
                                     const saltus_source *place, const saltus_node *equations,
                                     const saltus_model **model);
/* The same where the scene's `model` is the path of a file, relative to the scene's own. Errors: SALTUS_IO
 * too. */
saltus_status saltus_scene_read_model_file(const saltus_source *source, const saltus_node *root,
                                           const saltus_model **model);

/* The contents of a file that is no larger than a scene may be, to be freed. Errors: SALTUS_IO,
 * SALTUS_BAD_INPUT (too large), SALTUS_NO_MEMORY. */
saltus_status saltus_read_file(const char *path, char **text, size_t *length, saltus_message *message);

enum { SALTUS_MODEL_TEXT_MAX = 60000 }; /* bytes of a model in a file */
/* The model that saltus_model_text describes. Errors as above. */
saltus_status saltus_model_of_text(const char *text, const saltus_model **model, saltus_message *message);

/* The same model with another section, as saltus_scene_set_section has it. */
saltus_status saltus_model_with_section(const saltus_model *model, const char *section,
                                        const saltus_model **made, saltus_message *message);

/* A number or an expression of numbers that is the whole string. NULL when it is one, else what it must be
 * ("must be a number"). */
const char *saltus_read_number(const char *text, double *value);
/* The same up to the first of the characters `ends` that stands in no parentheses, or the end of the text:
 * where the number ends; NULL when it is none. */
const char *saltus_read_number_until(const char *text, const char *ends, double *value);
/* Likewise the value of a stop's key other than weight; it goes to the stop. */
const char *saltus_read_stop(saltus_stop *stop, int key, const char *text);

/* A value between quotation marks for a message: control characters replaced, long ones cut. */
typedef struct saltus_quoted {
    char text[56];
} saltus_quoted;
saltus_quoted saltus_quote(const char *text);

/* A list of words for a message: "a, b, c". */
typedef struct saltus_words {
    char text[320];
} saltus_words;
saltus_words saltus_words_of(const char *const *words, int count);
void saltus_words_add(saltus_words *words, const char *word);

/* Complain about a key that is none of `keys`: name the nearest one, or all. */
saltus_status saltus_unknown_key(const saltus_source *source, int line, const char *key,
                                 const char *const *keys, int count);

/* The keys that may stand at the top level of a scene of this model, or of any model when it is NULL. */
enum { SALTUS_TOP_KEYS_MAX = SALTUS_PARAMETERS_MAX + 6 };
int saltus_top_keys(const saltus_model *model, const char **keys);
/* The keys of this model's stops: xi or weight, then the common ones. */
int saltus_model_stop_keys(const saltus_model *model, const char **keys);
/* Whether a key of stops is one of this model: it is not where another key, xi or weight, places them. */
bool saltus_model_has_stop_key(const saltus_model *model, int key);

/* Built-in scenes, generated from data/scenes. */
typedef struct saltus_builtin {
    const char *name;
    const char *text; /* ends with NUL */
    size_t length;    /* without it */
} saltus_builtin;
extern const saltus_builtin saltus_builtins[];
extern const int saltus_builtin_count;

#endif
