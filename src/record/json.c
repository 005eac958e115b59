/* A motion as one JSON object.
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

void saltus_json_vector(FILE *file, const double *vector, int length) {
    fputc('[', file);
    for (int i = 0; i < length; i++) {
        fputs(i ? ", " : "", file);
        saltus_json_value(file, vector[i]);
    }
    fputc(']', file);
}

void saltus_json_list(FILE *file, const char *key, const double *vector, int length) {
    saltus_json_key(file, key);
    saltus_json_vector(file, vector, length);
}

static void put_field(FILE *file, const saltus_field *field, const int *counts, const void *record) {
    char text[SALTUS_FIELD_TEXT_MAX];
    double list[SALTUS_STATE_MAX];
    int length[2];
    size_t entries = saltus_field_shape(field, counts, length);
    if (length[0] && entries <= SALTUS_STATE_MAX) {
        saltus_field_pack(field, counts, record, list);
        saltus_json_vector(file, list, (int)entries);
    } else if (field->type == SALTUS_REAL)
        saltus_json_value(file, saltus_field_number(field, record));
    else if (field->type == SALTUS_FLAG)
        fputs(saltus_field_whole(field, record) ? "true" : "false", file);
    else if (field->words || field->type == SALTUS_TEXT)
        saltus_put_string(file, saltus_field_text(field, record, text));
    else
        fputs(saltus_field_text(field, record, text), file);
}

void saltus_json_fields(FILE *file, const char *begin, const saltus_field_table *table, const int *counts,
                        const void *record) {
    for (int k = 0; k < table->count; k++) {
        fprintf(file, "%s\"%s\": ", k ? ", " : begin, table->fields[k].name);
        put_field(file, &table->fields[k], counts, record);
    }
}

void saltus_json_named(FILE *file, const char *names, const saltus_field_table *table, const int *counts,
                       const void *record) {
    for (const char *name = names; *name; name += strspn(name, ", ")) {
        size_t length = strcspn(name, ",");
        for (int k = 0; k < table->count; k++) {
            const saltus_field_table one = {&table->fields[k], 1};
            if (strlen(one.fields->name) == length && memcmp(one.fields->name, name, length) == 0)
                saltus_json_fields(file, ", ", &one, counts, record);
        }
        name += length;
    }
}

/* Rows of numbers, one after the other. */
static void put_rows(FILE *file, const char *key, const double *rows, int count, int length) {
    fprintf(file, ", \"%s\": [", key);
    for (int k = 0; k < count; k++) {
        fputs(k ? ", " : "", file);
        saltus_json_vector(file, rows + (size_t)k * (size_t)length, length);
    }
    fputc(']', file);
}

/* The names of the state's entries, where the scene gives them. */
static void put_state_names(FILE *file, const saltus_system *system) {
    if (!saltus_model_text(saltus_system_spec(system)->model))
        return;
    saltus_json_key(file, "state_names");
    for (int i = 0; i < saltus_system_dimension(system); i++) {
        fputs(i ? ", " : "[", file);
        saltus_put_string(file, saltus_system_state_name(system, i).text);
    }
    fputc(']', file);
}

static void put_states(FILE *file, const saltus_motion *motion) {
    saltus_json_key(file, "state");
    if (motion->state)
        saltus_json_vector(file, motion->state, motion->dimension);
    else
        fputs("null", file);
    put_rows(file, "section_states", motion->section_states, motion->section_states ? motion->periods : 0,
             motion->dimension);
}

/* Complete chatter makes them infinite: how many are simulated one by one depends on the tolerance. */
static void put_impact_counts(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    if (motion->impacts < 0) {
        fputs(", \"impacts_by_side\": null, \"impacts_by_stop\": null", file);
        return;
    }
    int stops = saltus_system_spec(system)->stop_count;
    long long sides[2] = {0, 0}, by_stop[SALTUS_STOPS_MAX][2] = {{0}};
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        sides[face.side < 0] += motion->impacts_by_face[f];
        by_stop[face.stop][face.side < 0] += motion->impacts_by_face[f];
    }
    fprintf(file,
            ", \"impacts_by_side\": {\"upper\": %lld, \"lower\": %lld}, \"impacts_counted_over\": %lld, "
            "\"impacts_by_stop\": [",
            sides[0], sides[1], motion->counted);
    for (int s = 0; s < stops; s++)
        fprintf(file, "%s{\"stop\": %d, \"upper\": %lld, \"lower\": %lld}", s ? ", " : "", s + 1,
                by_stop[s][0], by_stop[s][1]);
    fputc(']', file);
}

void saltus_json_events(FILE *file, const saltus_system *system, const saltus_event *events, int count) {
    fputs(", \"events\": [", file);
    for (int k = 0; k < count; k++) {
        const saltus_event *event = &events[k];
        const char *word = saltus_event_word(event->kind);
        saltus_face face = saltus_system_face(system, event->face);
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
    double pairs[SALTUS_STATE_MAX][2] = {{0}}, moduli[SALTUS_STATE_MAX] = {0};
    for (int k = 0; k < count; k++) {
        pairs[k][0] = multipliers[k].re;
        pairs[k][1] = multipliers[k].im;
        moduli[k] = multipliers[k].log_modulus;
    }
    put_rows(file, "multipliers", pairs[0], count, 2);
    saltus_json_list(file, "log_moduli", moduli, count);
}

void saltus_json_eigenvalues(FILE *file, const saltus_eigenvalue *eigenvalues, int count) {
    double pairs[SALTUS_STATE_MAX][2] = {{0}};
    for (int k = 0; k < count; k++) {
        pairs[k][0] = eigenvalues[k].re;
        pairs[k][1] = eigenvalues[k].im;
    }
    put_rows(file, "eigenvalues", pairs[0], count, 2);
}

static void put_sum_rule(FILE *file, const saltus_motion *motion) {
    if (motion->sticks || motion->multiplier_count == 0) {
        fputs(", \"sum_rule\": null", file);
        return;
    }
    fputs(", \"sum_rule\": {\"multipliers\": ", file);
    saltus_json_value(file, motion->log_volume);
    saltus_json_member(file, "trace_and_restitution", motion->sum_rule);
    saltus_json_member(file, "difference", motion->log_volume - motion->sum_rule);
    fputc('}', file);
}

void saltus_json_contact_force(FILE *file, const saltus_system *system, const double *force,
                               const double *gap) {
    if (!force) {
        fputs(", \"contact_force\": null", file);
        return;
    }
    fputs(", \"contact_force\": [", file);
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        fprintf(file, "%s{\"stop\": %d, \"side\": \"%s\"", f ? ", " : "", face.stop + 1,
                saltus_side_word(face.side));
        saltus_json_member(file, "force", force[f]);
        if (gap)
            saltus_json_member(file, "gap", gap[f]);
        fputc('}', file);
    }
    fputc(']', file);
}

/* The keys of a stop, first without a comma before it. */
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
        saltus_json_vector(file, place, count);
    saltus_json_member(file, "d", stop->d);
    saltus_json_member(file, "r", stop->r);
    saltus_json_text(file, "sides", saltus_sides_word(stop->sides));
}

void saltus_json_parameters(FILE *file, const saltus_spec *spec) {
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
}

static void put_evidence(FILE *file, const saltus_motion *motion) {
    const saltus_evidence *e = &motion->evidence;
    if (e->periods == 0) {
        fputs(", \"evidence\": null", file);
        return;
    }
    saltus_json_fields(file, ", \"evidence\": {", &saltus_evidence_fields, NULL, e);
    fputc('}', file);
}

static void put_motion(FILE *file, const char *names, const saltus_motion *motion) {
    saltus_json_named(file, names, &saltus_motion_fields, NULL, motion);
}

void saltus_write_motion_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                              const saltus_motion *motion) {
    const bool settled = saltus_verdict_settled(motion->verdict);
    fputs("{\"version\": \"" SALTUS_VERSION "\"", file);
    saltus_json_text(file, "scene", scene->name);
    put_motion(file, "label,kind", motion);
    saltus_json_member(file, "impacts", motion->impacts >= 0 && settled ? (double)motion->impacts : NAN);
    put_motion(file, "periods,sticking_intervals,period", motion);
    put_impact_counts(file, system, motion);
    saltus_json_member(file, "impacts_per_response", saltus_impacts_per_response(system, motion));
    put_state_names(file, system);
    put_states(file, motion);
    saltus_json_events(file, system, motion->events, motion->event_count);
    saltus_json_multipliers(file, motion->multipliers, motion->multiplier_count);
    if (motion->eigenvalues)
        saltus_json_eigenvalues(file, motion->eigenvalues, motion->eigenvalue_count);
    if (motion->trivial_multiplier != 0)
        put_motion(file, "trivial_multiplier", motion);
    put_motion(file, "stable,mirror,residual", motion);
    put_sum_rule(file, motion);
    put_motion(file, "lyapunov,lyapunov_standard_error", motion);
    if (!settled)
        saltus_json_member(file, "lifetime_at_least", motion->evidence.lifetime_at_least);
    put_evidence(file, motion);
    saltus_json_contact_force(file, system, motion->verdict == SALTUS_HELD ? motion->contact_force : NULL,
                              NULL);
    put_motion(file, "largest_displacement,smallest_displacement,rms_displacement,transient", motion);
    saltus_json_text(file, "reason", motion->reason);
    saltus_json_parameters(file, saltus_system_spec(system));
    saltus_json_text(file, "integrator", saltus_integrator_used(system, motion->integrator));
    fputs("}\n", file);
}
