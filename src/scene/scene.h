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

/* The keys of a stop; the same order is used everywhere. */
enum { stop_xi, stop_d, stop_r, stop_sides, stop_weight, stop_coordinate, stop_keys };
extern const char *const saltus_stop_keys[stop_keys];

/* The lists of an initial state, in the order of the state vector. */
enum { initial_q, initial_v, initial_z, initial_lists };
extern const char *const saltus_initial_keys[initial_lists];

/* Turn a mapping with the keys of a scene into a checked scene without a name. Unknown keys are refused, or
 * ignored if `others` says that the mapping contains more than a scene. The scene is unchanged on error.
 * Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_scene_read(const saltus_source *source, const saltus_node *root, bool others,
                                saltus_scene *scene);

/* The model that a mapping of equations describes, with the stops' coordinates from the scene; to be
 * released. The mapping may be in a text of its own, `place`. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_scene_read_text(const saltus_source *source, const saltus_node *root,
                                     const saltus_source *place, const saltus_node *equations,
                                     const saltus_model **model);
/* The same if the scene's `model` is the path of a file, relative to that of the scene. Errors: also
 * SALTUS_IO. */
saltus_status saltus_scene_read_model_file(const saltus_source *source, const saltus_node *root,
                                           const saltus_model **model);

enum { SALTUS_SCENE_BYTES_MAX = 1 << 20 };
/* Read a whole file, at most as large as a scene may be; *text is to be freed. Errors: SALTUS_IO,
 * SALTUS_BAD_INPUT (too large), SALTUS_NO_MEMORY. */
saltus_status saltus_read_file(const char *path, char **text, size_t *length, saltus_message *message);

enum { SALTUS_MODEL_TEXT_MAX = 60000 }; /* bytes of a model's text in a file */
/* The model described by a text of saltus_model_text. Errors as above. */
saltus_status saltus_model_of_text(const char *text, const saltus_model **model, saltus_message *message);

/* The same model with another section; see saltus_scene_set_section. */
saltus_status saltus_model_with_section(const saltus_model *model, const char *section,
                                        const saltus_model **made, saltus_message *message);

/* Read a number, or an expression of numbers, that fills the whole string. Returns NULL on success, otherwise
 * what the text must be ("must be a number"). */
const char *saltus_read_number(const char *text, double *value);
/* The same up to the first character of `ends` outside parentheses, or the end of the text. Returns where the
 * number ends; NULL if it is not a number. */
const char *saltus_read_number_until(const char *text, const char *ends, double *value);
/* Read the value of a stop's key other than weight into the stop. Returns as saltus_read_number. */
const char *saltus_read_stop(saltus_stop *stop, int key, const char *text);

/* A value in quotation marks for a message: control characters replaced, long values cut. */
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

/* Refuse a value that is not what is `wanted`: "a single value". */
saltus_status saltus_kind_fail(const saltus_source *source, const saltus_node *node, const char *wanted);

/* The place of a key in a list; `count`: it is not there. */
int saltus_key_index(const char *key, const char *const *keys, int count);
/* Refuse a key that is not among `keys`; the message names the nearest one, or all. */
saltus_status saltus_unknown_key(const saltus_source *source, int line, const char *key,
                                 const char *const *keys, int count);

/* The keys possible at the top level of a scene of this model, or with NULL of any model. */
enum { SALTUS_TOP_KEYS_MAX = SALTUS_PARAMETERS_MAX + 6 };
int saltus_top_keys(const saltus_model *model, const char **keys);
/* The keys of this model's stops: xi or weight, then the common ones. */
int saltus_model_stop_keys(const saltus_model *model, const char **keys);
/* Whether this model's stops have the key: each model places its stops by one of xi, weight and
 * coordinate. */
bool saltus_model_has_stop_key(const saltus_model *model, int key);

/* Built-in scenes, made by the build from data/scenes. */
typedef struct saltus_builtin {
    const char *name, *text;
} saltus_builtin;
extern const saltus_builtin saltus_builtins[];
extern const int saltus_builtin_count;

#endif
