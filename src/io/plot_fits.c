/* Whether branches of periodic orbits belong over the diagram of a sweep.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whether two numbers are the same but for rounding. */
static bool same(double a, double b) {
    return fabs(a - b) <= 1e-9 * fmax(fabs(a), fabs(b));
}

/* Whether a key of --set, which may end in the number of a stop, is `name` of stop s. */
static bool means(const char *key, const char *name, int s) {
    size_t length = strlen(name);
    return strncmp(key, name, length) == 0 && (!key[length] || atoi(key + length) == s + 1);
}

/* The first parameter other than the key in which two systems of one structure differ; NULL: none. */
static const char *difference(const saltus_spec *a, const saltus_spec *b, const char *key) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(a->model, &count);
    for (int k = 0; k < count; k++)
        if (strcmp(p[k].name, key) != 0 && !same(a->parameters[k], b->parameters[k]))
            return p[k].name;
    for (int s = 0; s < a->stop_count; s++) {
        const saltus_stop *stop = &a->stops[s], *other = &b->stops[s];
        if (!means(key, "d", s) && !same(stop->d, other->d))
            return "d";
        if (!means(key, "r", s) && !same(stop->r, other->r))
            return "r";
        if (!means(key, "xi", s) && !same(stop->xi, other->xi))
            return "xi";
        if (stop->sides != other->sides)
            return "sides";
    }
    return NULL;
}

saltus_status saltus_plot_fits(const saltus_branch_file *file, const saltus_spec *spec, const char *key,
                               const char *path, saltus_message *message) {
    if (file->options.locus != SALTUS_POINT_REGULAR || strcmp(file->options.key[0], key) != 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: %s in %s, the sweep is over %s", path,
                           file->options.locus != SALTUS_POINT_REGULAR ? "are special points"
                                                                       : "are periodic orbits",
                           file->options.key[0], key);
    if (file->spec.model != spec->model || file->spec.stop_count != spec->stop_count)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is of another structure than the sweep (model or stops differ)", path);
    const char *name = difference(&file->spec, spec, key);
    if (name)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: has another %s than the sweep", path, name);
    return SALTUS_OK;
}
