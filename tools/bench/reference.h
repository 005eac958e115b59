/* Reads reference orbits from data/reference for tests and benchmarks, only the keys needed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_REFERENCE_H
#define SALTUS_TOOLS_REFERENCE_H

#include "saltus/saltus.h"
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { reference_events = 512, reference_periods = 16, reference_dimension = 128 };

typedef struct reference {
    saltus_spec spec;
    char label[32];
    int periods, sticking, n, event_count;
    double states[reference_periods][reference_dimension]; /* section_states */
    char kind[reference_events];
    double time[reference_events], speed[reference_events]; /* speed: of impacts */
    int multiplier_count;
    double multipliers[reference_dimension][2];
    double monodromy[reference_dimension][reference_dimension];
} reference;

/* A number, quoted or not; NAN if there is none. */
static inline double reference_number(const saltus_node *node) {
    return node && node->text ? strtod(node->text, NULL) : NAN;
}

/* Copy a list of lists of numbers into a matrix of `rows` rows, and say how many there are. */
static inline int reference_matrix(const saltus_node *list, int rows, int columns, double *matrix) {
    int count = 0;
    for (const saltus_node *row = list ? list->first : NULL; row && count < rows; row = row->next, count++) {
        const saltus_node *entry = row->first;
        for (int i = 0; i < columns && entry; i++, entry = entry->next)
            matrix[count * columns + i] = reference_number(entry);
    }
    return count;
}

/* Read folder/name.json; false if it cannot be read. */
static inline bool reference_read(const char *folder, const char *name, reference *r) {
    char path[1024];
    saltus_source source = {.origin = path, .language = "JSON"};
    saltus_document document = {.root = NULL};
    saltus_scene scene;
    char *text;
    *r = (reference){.periods = 0};
    snprintf(path, sizeof path, "%s/%s.json", folder, name);
    bool read = saltus_read_file(path, &text, &source.length, NULL) == SALTUS_OK;
    source.text = text;
    read = read && saltus_document_read(&source, &document) == SALTUS_OK;
    const saltus_node *root = document.root, *described = saltus_node_member(root, "scene");
    read = read && described && saltus_scene_read(&source, described, false, &scene) == SALTUS_OK;
    if (read) {
        const saltus_node *label = saltus_node_member(root, "label"),
                          *events = saltus_node_member(root, "events");
        r->spec = scene.spec;
        r->n = 2 * (int)saltus_spec_get(&r->spec, "N");
        r->periods = (int)reference_number(saltus_node_member(root, "periods"));
        r->sticking = (int)reference_number(saltus_node_member(root, "sticking_intervals"));
        snprintf(r->label, sizeof r->label, "%s", label && label->text ? label->text : "");
        const int states = reference_matrix(saltus_node_member(root, "section_states"), reference_periods,
                                            reference_dimension, &r->states[0][0]);
        read = r->n <= reference_dimension && states > 0 && states == r->periods;
        reference_matrix(saltus_node_member(root, "monodromy_over_periods"), reference_dimension,
                         reference_dimension, &r->monodromy[0][0]);
        r->multiplier_count = reference_matrix(saltus_node_member(root, "multipliers_dominant"),
                                               reference_dimension, 2, &r->multipliers[0][0]);
        for (const saltus_node *e = events ? events->first : NULL; e && r->event_count < reference_events;
             e = e->next) {
            const saltus_node *kind = saltus_node_member(e, "event");
            r->kind[r->event_count] = kind && kind->text ? kind->text[0] : '\0';
            r->time[r->event_count] = reference_number(saltus_node_member(e, "time_over_T"));
            r->speed[r->event_count++] = reference_number(saltus_node_member(e, "normal_velocity_before"));
        }
    }
    saltus_document_close(&document);
    free(text);
    return read;
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
