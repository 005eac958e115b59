/* Reads reference orbits from data/reference for tests and benchmarks, only the keys needed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_REFERENCE_H
#define SALTUS_TOOLS_REFERENCE_H

#include "saltus/saltus.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { reference_events = 512, reference_periods = 16, reference_dimension = 128 };

typedef struct reference {
    char *text;
    saltus_spec spec;
    char label[32];
    int periods, sticking, n, event_count;
    double states[reference_periods][reference_dimension]; /* section_states */
    char kind[reference_events];
    double time[reference_events], speed[reference_events];
    int multiplier_count;
    double multipliers[reference_dimension][2];
    double monodromy[reference_dimension][reference_dimension];
} reference;

/* The place after `"key":`, from `from` on; NULL if there is none. */
static inline const char *find_key(const char *from, const char *key) {
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(from, quoted);
    return at ? at + strlen(quoted) : NULL;
}

/* Read the next number, quoted or not, and advance *at past it. */
static inline double next_number(const char **at) {
    *at += strcspn(*at, "+-0123456789");
    char *end;
    double value = strtod(*at, &end);
    *at = end;
    return value;
}

static inline double number_at(const char *from, const char *key) {
    const char *at = find_key(from, key);
    return at ? next_number(&at) : NAN;
}

/* Read the scene: model (default pipe), parameters by name, stop. */
static inline void read_scene(reference *r) {
    const char *scene = find_key(r->text, "scene"), *end = find_key(r->text, "periods"), *at;
    const char *model = find_key(scene, "model");
    int count;
    bool oscillator = model && model < end && strncmp(model + strspn(model, " \""), "oscillator", 10) == 0;
    r->spec = saltus_spec_defaults(saltus_model_find(oscillator ? "oscillator" : "pipe"));
    const saltus_parameter *parameters = saltus_model_parameters(r->spec.model, &count);
    for (int k = 0; k < count; k++)
        if ((at = find_key(scene, parameters[k].name)) && at < end)
            r->spec.parameters[k] = next_number(&at);
    r->n = 2 * (int)saltus_spec_get(&r->spec, "N");
    const char *place = find_key(scene, "stop");
    if (!place || place > end || place[strspn(place, " ")] != '{')
        return;
    saltus_stop *stop = &r->spec.stops[r->spec.stop_count++];
    *stop = saltus_stop_defaults();
    if ((at = find_key(place, "xi")) && at < end)
        stop->xi = next_number(&at);
    stop->d = number_at(place, "d");
    stop->r = number_at(place, "r");
    const char *sides = find_key(place, "sides");
    if (sides && sides < end)
        stop->sides = strncmp(sides, " \"both\"", 7) == 0    ? SALTUS_BOTH
                      : strncmp(sides, " \"lower\"", 8) == 0 ? SALTUS_LOWER
                                                             : SALTUS_UPPER;
}

static inline void read_events(reference *r) {
    const char *at = find_key(r->text, "events"), *end = strchr(at, ']');
    while ((at = find_key(at, "event")) && at < end && r->event_count < reference_events) {
        at = strchr(at, '"') + 1;
        r->kind[r->event_count] = *at;
        r->time[r->event_count] = number_at(at, "time_over_T");
        if (*at == 'i')
            r->speed[r->event_count] = number_at(at, "normal_velocity_before");
        r->event_count++;
    }
}

static inline void read_multipliers(reference *r) {
    const char *at = find_key(r->text, "multipliers_dominant"), *end = strstr(at, "\n ]");
    while (r->multiplier_count < reference_dimension) {
        const char *next = strchr(at, '[');
        at = next ? next + 1 : end;
        if (at >= end)
            break;
        if (*at == '\n')
            continue;
        r->multipliers[r->multiplier_count][0] = next_number(&at);
        r->multipliers[r->multiplier_count++][1] = next_number(&at);
    }
}

/* Read folder/name.json; false if it cannot be read. Free `text` afterwards. */
static inline bool reference_read(const char *folder, const char *name, reference *r) {
    enum { longest = 1 << 20 };
    char path[1024];
    *r = (reference){.text = calloc(1, longest)};
    snprintf(path, sizeof path, "%s/%s.json", folder, name);
    FILE *file = fopen(path, "rb");
    bool read = file && r->text && fread(r->text, 1, longest - 1, file) > 0;
    if (file)
        fclose(file);
    if (!read || !find_key(r->text, "scene") || !find_key(r->text, "section_states"))
        return false;
    read_scene(r);
    r->periods = (int)number_at(r->text, "periods");
    if (r->n > reference_dimension || r->periods > reference_periods)
        return false;
    r->sticking = (int)number_at(r->text, "sticking_intervals");
    sscanf(find_key(r->text, "label"), " \"%31[^\"]", r->label);
    const char *at = find_key(r->text, "section_states");
    for (int p = 0; p < r->periods; p++)
        for (int i = 0; i < r->n; i++)
            r->states[p][i] = next_number(&at);
    at = find_key(r->text, "monodromy_over_periods");
    for (int i = 0; i < r->n; i++)
        for (int j = 0; j < r->n; j++)
            r->monodromy[i][j] = next_number(&at);
    if (find_key(r->text, "events"))
        read_events(r);
    if (find_key(r->text, "multipliers_dominant"))
        read_multipliers(r);
    return true;
}

/* Velocities are weighted by 1/100. */
static inline double reference_distance(const reference *r, const double *state, int point) {
    double largest = 0;
    for (int i = 0; i < r->n; i++)
        largest = fmax(largest, fabs(state[i] - r->states[point][i]) * (i < r->n / 2 ? 1 : 0.01));
    return largest;
}

/* Relative to the orbit's largest displacement and its largest velocity at the section. */
static inline double reference_error(const reference *r, const double *state, int point) {
    double largest = 0;
    for (int half = 0; half < 2; half++) {
        double error = 0, size = 0;
        for (int i = half * r->n / 2; i < (half + 1) * r->n / 2; i++) {
            error = fmax(error, fabs(state[i] - r->states[point][i]));
            for (int p = 0; p < r->periods; p++)
                size = fmax(size, fabs(r->states[p][i]));
        }
        largest = fmax(largest, error / size);
    }
    return largest;
}

#endif
