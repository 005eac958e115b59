/* A motion as one JSON object.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/io.h"

#include "io/describe.h"

#include <math.h>
#include <string.h>

/* A number, or null where JSON has none. */
static void put_value(FILE *file, double value) {
    if (isfinite(value))
        saltus_put_number(file, value);
    else
        fputs("null", file);
}

static void put_string(FILE *file, const char *text) {
    fputc('"', file);
    for (const unsigned char *c = (const unsigned char *)text; *c; c++)
        if (*c == '"' || *c == '\\')
            fprintf(file, "\\%c", *c);
        else if (*c < 0x20 || *c == 0x7f)
            fprintf(file, "\\u%04x", *c);
        else
            fputc(*c, file);
    fputc('"', file);
}

/* Members after the first begin with a comma. */
static void put_key(FILE *file, const char *key) {
    fprintf(file, ", \"%s\": ", key);
}

static void put_member(FILE *file, const char *key, double value) {
    put_key(file, key);
    put_value(file, value);
}

static void put_text(FILE *file, const char *key, const char *text) {
    put_key(file, key);
    put_string(file, text);
}

static void put_vector(FILE *file, const double *vector, int length) {
    fputc('[', file);
    for (int i = 0; i < length; i++) {
        fputs(i ? ", " : "", file);
        put_value(file, vector[i]);
    }
    fputc(']', file);
}

static void put_states(FILE *file, const saltus_motion *motion) {
    put_key(file, "state");
    if (motion->state)
        put_vector(file, motion->state, motion->dimension);
    else
        fputs("null", file);
    put_key(file, "section_states");
    fputc('[', file);
    for (int k = 0; motion->section_states && k < motion->periods; k++) {
        fputs(k ? ", " : "", file);
        put_vector(file, motion->section_states + k * motion->dimension, motion->dimension);
    }
    fputc(']', file);
}

static void put_impact_counts(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    int stops = saltus_system_spec(system)->stop_count;
    long long sides[2] = {0, 0}, by_stop[SALTUS_STOPS_MAX][2] = {{0}};
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        sides[face.side < 0] += motion->impacts_by_face[f];
        by_stop[face.stop][face.side < 0] += motion->impacts_by_face[f];
    }
    put_key(file, "impacts_by_side");
    fprintf(file, "{\"upper\": %lld, \"lower\": %lld}", sides[0], sides[1]);
    put_key(file, "impacts_by_stop");
    fputc('[', file);
    for (int s = 0; s < stops; s++)
        fprintf(file, "%s{\"stop\": %d, \"upper\": %lld, \"lower\": %lld}", s ? ", " : "", s + 1,
                by_stop[s][0], by_stop[s][1]);
    fputc(']', file);
}

static void put_events(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    put_key(file, "events");
    fputc('[', file);
    for (int k = 0; k < motion->event_count; k++) {
        const saltus_event *event = &motion->events[k];
        const char *word = saltus_event_word(event->kind);
        saltus_face face = saltus_system_face(system, event->face);
        fprintf(file, "%s{\"event\": \"%s\", \"type\": \"%s\", \"side\": \"%s\", \"stop\": %d", k ? ", " : "",
                word, word, saltus_side_word(face.side), face.stop + 1);
        put_member(file, "time_over_T", saltus_time_periods(event->time));
        put_member(file, "phase", event->time.phase);
        put_member(file, "normal_velocity_before", event->velocity_before);
        put_member(file, "normal_velocity_after", saltus_event_after(event));
        fputc('}', file);
    }
    fputc(']', file);
}

static void put_multipliers(FILE *file, const saltus_motion *motion) {
    put_key(file, "multipliers");
    fputc('[', file);
    for (int k = 0; k < motion->multiplier_count; k++) {
        const double pair[2] = {motion->multipliers[k].re, motion->multipliers[k].im};
        fputs(k ? ", " : "", file);
        put_vector(file, pair, 2);
    }
    fputs("], \"log_moduli\": [", file);
    for (int k = 0; k < motion->multiplier_count; k++) {
        fputs(k ? ", " : "", file);
        put_value(file, motion->multipliers[k].log_modulus);
    }
    fputc(']', file);
}

static void put_sum_rule(FILE *file, const saltus_motion *motion) {
    put_key(file, "sum_rule");
    if (motion->sticks || motion->multiplier_count == 0) {
        fputs("null", file);
        return;
    }
    fputs("{\"multipliers\": ", file);
    put_value(file, motion->log_volume);
    put_member(file, "trace_and_restitution", motion->sum_rule);
    put_member(file, "difference", motion->log_volume - motion->sum_rule);
    fputc('}', file);
}

static void put_contact_force(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    put_key(file, "contact_force");
    if (motion->kind != SALTUS_HELD) {
        fputs("null", file);
        return;
    }
    fputc('[', file);
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        fprintf(file, "%s{\"stop\": %d, \"side\": \"%s\"", f ? ", " : "", face.stop + 1,
                saltus_side_word(face.side));
        put_member(file, "force", motion->contact_force[f]);
        fputc('}', file);
    }
    fputc(']', file);
}

/* The keys of a stop, first without a comma before it. */
static void put_stop(FILE *file, const saltus_stop *stop, bool pipe) {
    if (pipe) {
        fputs("\"xi\": ", file);
        put_value(file, stop->xi);
    } else {
        fputs("\"weight\": ", file);
        put_vector(file, stop->weight, 2);
    }
    put_member(file, "d", stop->d);
    put_member(file, "r", stop->r);
    put_text(file, "sides", saltus_sides_word(stop->sides));
}

static void put_parameters(FILE *file, const saltus_system *system) {
    const saltus_spec *spec = saltus_system_spec(system);
    bool pipe = saltus_is_pipe(system);
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    put_key(file, "parameters");
    fputs("{\"model\": ", file);
    put_string(file, saltus_model_name(spec->model));
    for (int k = 0; k < count; k++)
        put_member(file, p[k].name, spec->parameters[k]);
    if (spec->stop_count) {
        fputs(", ", file);
        put_stop(file, &spec->stops[0], pipe);
    }
    put_key(file, "stops");
    fputc('[', file);
    for (int s = 0; s < spec->stop_count; s++) {
        fputs(s ? ", {" : "{", file);
        put_stop(file, &spec->stops[s], pipe);
        fputc('}', file);
    }
    fputs("]}", file);
}

void saltus_write_motion_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                              const saltus_motion *motion) {
    static const char *const mirror[] = {"none", "self", "pair"};
    fputs("{\"version\": \"" SALTUS_VERSION "\"", file);
    put_text(file, "scene", scene->name);
    put_text(file, "label", motion->label);
    put_text(file, "kind", saltus_kind_word(motion->kind));
    bool counted = motion->impacts >= 0 && motion->kind != SALTUS_UNDECIDED;
    put_member(file, "impacts", counted ? (double)motion->impacts : NAN);
    fprintf(file, ", \"periods\": %d, \"sticking_intervals\": %d", motion->periods,
            motion->sticking_intervals);
    put_impact_counts(file, system, motion);
    put_member(file, "impacts_per_response", saltus_impacts_per_response(system, motion));
    put_states(file, motion);
    put_events(file, system, motion);
    put_multipliers(file, motion);
    fprintf(file, ", \"stable\": %s, \"mirror\": \"%s\"", motion->stable ? "true" : "false",
            mirror[motion->mirror]);
    put_member(file, "residual", motion->residual);
    put_sum_rule(file, motion);
    put_contact_force(file, system, motion);
    put_member(file, "largest_displacement", motion->largest);
    put_member(file, "smallest_displacement", motion->smallest);
    fprintf(file, ", \"transient\": %lld", motion->transient);
    put_text(file, "reason", motion->reason);
    put_parameters(file, system);
    put_text(file, "integrator", saltus_system_integrator(system));
    fputs("}\n", file);
}
