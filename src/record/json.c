/* Building blocks of JSON objects.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/json.h"

#include "record/fields.h"

#include <math.h>
#include <string.h>

void saltus_json_value(FILE *file, double value) {
    if (isfinite(value))
        saltus_put_number(file, value);
    else
        fputs("null", file);
}

static void put_vector(FILE *file, const double *vector, int length) {
    fputc('[', file);
    for (int i = 0; i < length; i++) {
        fputs(i ? ", " : "", file);
        saltus_json_value(file, vector[i]);
    }
    fputc(']', file);
}

void saltus_json_key(FILE *file, const char *key) {
    fprintf(file, ", \"%s\": ", key);
}

void saltus_json_member(FILE *file, const char *key, double value) {
    saltus_json_key(file, key);
    saltus_json_value(file, value);
}

void saltus_json_text(FILE *file, const char *key, const char *text) {
    saltus_json_key(file, key);
    saltus_put_string(file, text);
}

void saltus_json_list(FILE *file, const char *key, const double *vector, int length) {
    saltus_json_key(file, key);
    put_vector(file, vector, length);
}

void saltus_json_rows(FILE *file, const char *key, const void *rows, int count, int length, int stride) {
    const double *row = rows;
    saltus_json_key(file, key);
    fputc('[', file);
    for (int k = 0; k < count; k++, row += stride) {
        fputs(k ? ", " : "", file);
        put_vector(file, row, length);
    }
    fputc(']', file);
}

void saltus_json_fields(FILE *file, const char *begin, const saltus_field_table *table, const int *counts,
                        const void *record) {
    for (int k = 0; k < table->count; k++) {
        const saltus_field *field = &table->fields[k];
        char text[SALTUS_FIELD_TEXT_MAX];
        double list[SALTUS_STATE_MAX];
        int length[2];
        size_t entries = saltus_field_shape(field, counts, length);
        fprintf(file, "%s\"%s\": ", k ? ", " : begin, field->name);
        if (length[0] && entries <= SALTUS_STATE_MAX) {
            saltus_field_pack(field, counts, record, list);
            put_vector(file, list, (int)entries);
        } else if (field->type == SALTUS_REAL)
            saltus_json_value(file, saltus_field_number(field, record));
        else if (field->type == SALTUS_FLAG)
            fputs(saltus_field_whole(field, record) ? "true" : "false", file);
        else if (field->words || field->type == SALTUS_TEXT)
            saltus_put_string(file, saltus_field_text(field, record, text));
        else
            fputs(saltus_field_text(field, record, text), file);
    }
}

void saltus_json_events(FILE *file, const saltus_system *system, const saltus_event *events, int count) {
    saltus_json_key(file, "events");
    fputc('[', file);
    for (int k = 0; k < count; k++) {
        const saltus_event *event = &events[k];
        const saltus_face face = saltus_system_face(system, event->face);
        const char *word = saltus_event_word(event->kind);
        fprintf(file, "%s{\"event\": \"%s\", \"type\": \"%s\", \"side\": \"%s\", \"stop\": %d", k ? ", " : "",
                word, word, saltus_side_word(face.side), face.stop + 1);
        saltus_json_member(file, "time_over_T", saltus_time_periods(event->time));
        saltus_json_member(file, "phase", event->time.phase);
        saltus_json_member(file, "normal_velocity_before", event->velocity_before);
        saltus_json_member(file, "normal_velocity_after", saltus_event_after(event));
        fputc('}', file);
    }
    fputc(']', file);
}

void saltus_json_multipliers(FILE *file, const saltus_multiplier *multipliers, int count) {
    double moduli[SALTUS_STATE_MAX] = {0};
    for (int k = 0; k < count; k++)
        moduli[k] = multipliers[k].log_modulus;
    saltus_json_rows(file, "multipliers", multipliers, count, 2, sizeof *multipliers / sizeof(double));
    saltus_json_list(file, "log_moduli", moduli, count);
}

void saltus_json_contact_force(FILE *file, const saltus_system *system, const double *force,
                               const double *gap) {
    saltus_json_key(file, "contact_force");
    fputs(force ? "[" : "null", file);
    for (int f = 0; f < saltus_system_face_count(system) && force; f++) {
        saltus_face face = saltus_system_face(system, f);
        fprintf(file, "%s{\"stop\": %d, \"side\": \"%s\"", f ? ", " : "", face.stop + 1,
                saltus_side_word(face.side));
        saltus_json_member(file, "force", force[f]);
        if (gap)
            saltus_json_member(file, "gap", gap[f]);
        fputc('}', file);
    }
    fputs(force ? "]" : "", file);
}

/* The members of a stop, without a comma before the first. */
static void put_stop(FILE *file, const saltus_spec *spec, int s) {
    const saltus_stop *stop = &spec->stops[s];
    const char *coordinate = saltus_stop_text(spec, s, SALTUS_STOP_COORDINATE);
    int count;
    const double *place = saltus_stop_place(spec->model, stop, &count);
    fprintf(file, "\"%s\": ", saltus_model_stop_key(spec->model));
    if (coordinate)
        saltus_put_string(file, coordinate);
    else if (count == 1)
        saltus_json_value(file, *place);
    else
        put_vector(file, place, count);
    saltus_json_member(file, "d", stop->d);
    saltus_json_member(file, "r", stop->r);
    saltus_json_text(file, "sides", saltus_sides_word(stop->sides));
}

void saltus_json_begin(FILE *file, const saltus_scene *scene) {
    fputs("{\"version\": \"" SALTUS_VERSION "\"", file);
    saltus_json_text(file, "scene", scene->name);
}

void saltus_json_end(FILE *file, const saltus_spec *spec, const char *integrator) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    fputs(", \"parameters\": {\"model\": ", file);
    if (saltus_model_text(spec->model))
        fputs(saltus_model_text(spec->model), file);
    else
        saltus_put_string(file, saltus_model_name(spec->model));
    for (int k = 0; k < count; k++)
        saltus_json_member(file, p[k].name, spec->parameters[k]);
    if (spec->observe[0])
        saltus_json_text(file, "observe", spec->observe);
    if (spec->stop_count) {
        fputs(", ", file);
        put_stop(file, spec, 0);
    }
    fputs(", \"stops\": [", file);
    for (int s = 0; s < spec->stop_count; s++) {
        fputs(s ? ", {" : "{", file);
        put_stop(file, spec, s);
        fputc('}', file);
    }
    fputs("]}", file);
    if (integrator)
        saltus_json_text(file, "integrator", integrator);
    fputs("}\n", file);
}
