/* Private: building blocks of JSON objects.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_JSON_H
#define SALTUS_RECORD_JSON_H

#include "record/describe.h"
#include "saltus/record.h"

/* The first and the last members of every result object; `integrator` may be NULL. */
void saltus_json_begin(FILE *file, const saltus_scene *scene);
void saltus_json_end(FILE *file, const saltus_spec *spec, const char *integrator);

/* The members of a table, separated by commas and preceded by `begin`. */
void saltus_json_fields(FILE *file, const char *begin, const saltus_field_table *table, const int *counts,
                        const void *record);

/* A number; null if JSON cannot represent it. */
void saltus_json_value(FILE *file, double value);
/* Further members of an object, each preceded by a comma. Numbers that JSON cannot represent become null. */
void saltus_json_key(FILE *file, const char *key);
void saltus_json_member(FILE *file, const char *key, double value);
void saltus_json_text(FILE *file, const char *key, const char *text);
void saltus_json_list(FILE *file, const char *key, const double *vector, int length);
/* A list of rows of numbers `stride` numbers apart, such as pairs of real and imaginary part; `rows` may be
 * NULL if there are none. */
void saltus_json_rows(FILE *file, const char *key, const void *rows, int count, int length, int stride);
/* The members `contact_force` with an entry for each face (null without `force`; `gap` may be NULL),
 * `events`, and `multipliers` with `log_moduli`. */
void saltus_json_contact_force(FILE *file, const saltus_system *system, const double *force,
                               const double *gap);
void saltus_json_events(FILE *file, const saltus_system *system, const saltus_event *events, int count);
void saltus_json_multipliers(FILE *file, const saltus_multiplier *multipliers, int count);

#endif
