/* Private: how a scene's text becomes plain values.
 *
 *     text -> strings with libcyaml (read.c) -> numbers, stops, initial state, trial system (fill.c)
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SCENE_PRIVATE_H
#define SALTUS_SCENE_PRIVATE_H

#include "saltus/scene.h"

/* A text being read, and where complaints about it go. */
typedef struct saltus_source {
    const char *text;
    size_t length;
    const char *origin;
    saltus_message *message; /* may be NULL */
} saltus_source;

/* Where a key stands: `top` is the top-level key it is below, NULL for a top-level key itself; `entry` counts
 * the items of a list from 0. */
typedef struct saltus_place {
    const char *top;
    int entry;
    const char *key;
} saltus_place;

/* The keys of a stop, in this order everywhere. */
enum { stop_xi, stop_d, stop_r, stop_sides, stop_weight, stop_keys };
extern const char *const saltus_stop_keys[stop_keys];

/* The lists of an initial state, in the order of the state vector. */
enum { initial_q, initial_v, initial_z, initial_lists };
extern const char *const saltus_initial_keys[initial_lists];

/* A stop, an initial state and a scene as strings; NULL where the text says nothing. */
typedef struct saltus_raw_stop {
    char *value[stop_weight]; /* xi, d, r, sides */
    char **weight;
    unsigned weight_count;
} saltus_raw_stop;

typedef struct saltus_raw_initial {
    char **list[initial_lists];
    unsigned count[initial_lists];
} saltus_raw_initial;

typedef struct saltus_raw_scene {
    char *model, *title;
    saltus_raw_stop *stop, *stops;
    unsigned stops_count;
    saltus_raw_initial *initial;
    char *parameter[]; /* in the order of the reading's names */
} saltus_raw_scene;

/* What libcyaml read, with the schema that frees it. */
typedef struct saltus_reading {
    saltus_raw_scene *raw;
    const char **names; /* the parameters of all models, each once */
    int name_count;
    void *schema;
} saltus_reading;

/* Read the text's strings. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY; the reading is then empty. */
saltus_status saltus_reading_open(const saltus_source *source, saltus_reading *reading);
void saltus_reading_close(saltus_reading *reading);

/* Turn strings into a checked scene. */
saltus_status saltus_scene_fill(const saltus_source *source, const saltus_reading *reading,
                                saltus_scene *scene);

/* Line of a key in the text, from 1; 0 when it is not found. `last` asks for the last of repeated keys. */
int saltus_place_line(const saltus_source *source, saltus_place place, bool last);
/* The single value behind a key; false when there is none or it does not fit. */
bool saltus_place_value(const saltus_source *source, saltus_place place, char *value, size_t size);

/* Write "origin:line: " and a sentence into the source's message; no line when it is 0, no origin when it is
 * NULL. */
saltus_status saltus_source_fail(const saltus_source *source, int line, saltus_status status,
                                 const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 4, 5)))
#endif
    ;

/* Likewise for input that is wrong at a place: with the line of its key in the text. */
saltus_status saltus_place_fail(const saltus_source *source, saltus_place place, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* "key = value: complaint". */
saltus_status saltus_value_fail(const saltus_source *source, saltus_place place, const char *value,
                                const char *complaint);

/* A number that is the whole string. NULL when it is one, else what it must be ("must be a number"). */
const char *saltus_read_number(const char *text, double *value);
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
/* The word nearest to `word` among `count`, or NULL when none is near enough to be meant. */
const char *saltus_nearest_word(const char *word, const char *const *words, int count);

/* Complain about a key that is none of `keys`: name the nearest one, or all. */
saltus_status saltus_unknown_key(const saltus_source *source, int line, const char *key,
                                 const char *const *keys, int count);

/* The keys that may stand at the top level of a scene of this model, or of any model when it is NULL. */
enum { SALTUS_TOP_KEYS_MAX = SALTUS_PARAMETERS_MAX + 5 };
int saltus_top_keys(const saltus_model *model, const char **keys);
/* The keys of this model's stops: xi or weight, then the common ones. */
int saltus_model_stop_keys(const saltus_model *model, const char **keys);
/* Where stops are placed by the model's own key, xi or weight, the other one is refused. */
saltus_status saltus_check_placing(const saltus_source *source, saltus_place place, const saltus_model *model,
                                   int key);

/* Built-in scenes, generated from data/scenes. */
typedef struct saltus_builtin {
    const char *name;
    const char *text; /* ends with NUL */
    size_t length;    /* without it */
} saltus_builtin;
extern const saltus_builtin saltus_builtins[];
extern const int saltus_builtin_count;

#endif
