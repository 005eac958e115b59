/* Scenes and starts from JSON, by the names of their keys.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene.h"

#include <string.h>

decimal shortest_decimal(double value) {
    decimal shortest = {""};
    for (int digits = 15; digits <= 17 && (digits == 15 || strtod(shortest.text, NULL) != value); digits++)
        snprintf(shortest.text, sizeof shortest.text, "%.*g", digits, value);
    return shortest;
}

/* The place after `"key":`, or NULL. */
static const char *place(const char *text, const char *key) {
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(text, quoted);
    return at ? at + strlen(quoted) : NULL;
}

/* The next number, in quotation marks or not; the place moves on. Without marks it is what a double was
 * written from: the shortest decimal that is read as the same double, 0.1 for 0.10000000000000001. */
static real next(const char **at) {
    *at += strcspn(*at, "+-.0123456789");
    char *end;
    bool marked = (*at)[-1] == '"';
    double value = strtod(*at, &end);
    real exact = real_read(marked ? *at : shortest_decimal(value).text);
    *at = end;
    return exact;
}

static bool number(const char *text, const char *key, real *value) {
    const char *at = place(text, key);
    if (at)
        *value = next(&at);
    return at != NULL;
}

static bool whole(const char *text, const char *key, int *value) {
    real read;
    bool there = number(text, key, &read);
    if (there)
        *value = (int)read;
    return there;
}

static bool word(const char *text, const char *key, const char *wanted) {
    const char *at = place(text, key);
    return at && strncmp(at, " \"", 2) == 0 && strncmp(at + 2, wanted, strlen(wanted)) == 0;
}

static const char *read_parameters(const char *text, model *m) {
    bool there = whole(text, "N", &m->modes) && number(text, "omega", &m->omega);
    if (m->pipe)
        there = there && number(text, "alpha", &m->alpha) && number(text, "beta", &m->beta) &&
                number(text, "kappa", &m->kappa) && number(text, "u0", &m->u0) &&
                number(text, "sigma", &m->sigma);
    else
        there = there && number(text, "m", &m->m) && number(text, "c", &m->c) && number(text, "k", &m->k) &&
                number(text, "F", &m->F) && number(text, "F0", &m->F0);
    if (!there)
        return "a parameter is missing";
    real maxwell = 0;
    if (!m->pipe && number(text, "kz", &maxwell) && maxwell != 0)
        return "the Maxwell element is not known here";
    return m->modes < 1 || m->modes > (m->pipe ? model_modes : 1) ? "too many modes or masses" : NULL;
}

/* One stop, or none. Saltus writes the keys of a single stop twice, the second time in a list. */
static const char *read_stop(const char *text, model *m) {
    const char *list = place(text, "stops"), *first = place(list ? list : text, "sides");
    if (!first)
        return NULL;
    if (place(first, "sides"))
        return "more than one stop";
    real weight = 1;
    if (number(text, "weight", &weight) && weight != 1)
        return "a weight other than 1";
    bool both = word(text, "sides", "both");
    m->stop.upper = both || word(text, "sides", "upper");
    m->stop.lower = both || word(text, "sides", "lower");
    bool there = number(text, "d", &m->stop.d) && number(text, "r", &m->stop.r) &&
                 (!m->pipe || number(text, "xi", &m->stop.xi));
    return there ? NULL : "a key of the stop is missing";
}

const char *scene_read(const char *text, model *m, int *periods, int *impacts, real *state) {
    *m = (model){.pipe = word(text, "model", "pipe")};
    *impacts = -1;
    if (!m->pipe && !word(text, "model", "oscillator"))
        return "no model that is known here";
    const char *trouble = read_parameters(text, m);
    if (!trouble)
        trouble = read_stop(text, m);
    const char *at = place(text, "state");
    if (!trouble && (!at || !whole(text, "periods", periods)))
        trouble = "no state or no number of periods";
    if (trouble)
        return trouble;
    if (*periods < 1 || *periods > passage_periods)
        return "too many periods";
    const char *counted = place(text, "impacts");
    if (counted && strncmp(counted, " null", 5) != 0)
        whole(text, "impacts", impacts);
    for (int i = 0; i < 2 * m->modes; i++)
        state[i] = next(&at);
    model_prepare(m);
    return NULL;
}

bool scene_read_matrix(const char *text, int n, real *matrix) {
    const char *at = place(text, "monodromy_over_periods");
    for (int i = 0; at && i < n * n; i++)
        matrix[i] = next(&at);
    return at != NULL;
}
