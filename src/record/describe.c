/* Words and numbers shared by the writers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"

#include "flow/options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void saltus_put_number(FILE *file, double value) {
    char text[SALTUS_NUMBER_MAX];
    fputs(saltus_number(value, text), file);
}

void saltus_put_numbers(FILE *file, const double *values, int count) {
    for (int i = 0; i < count; i++) {
        fputc(',', file);
        saltus_put_number(file, values[i]);
    }
}

const char *saltus_plural(long long count) {
    return count == 1 ? "" : "s";
}

const saltus_word saltus_event_words[] = {{"reached", SALTUS_REACHED},
                                          {"turning", SALTUS_TURNING},
                                          {"step", SALTUS_STEP},
                                          {"impact", SALTUS_IMPACT},
                                          {"stick", SALTUS_STICK},
                                          {"release", SALTUS_RELEASE},
                                          {NULL, 0}};
const saltus_word saltus_side_words[] = {
    {"upper", SALTUS_UPPER}, {"lower", SALTUS_LOWER}, {"both", SALTUS_BOTH}, {NULL, 0}};

const char *saltus_event_word(saltus_event_kind kind) {
    const char *word = saltus_word_of(saltus_event_words, (int)kind);
    return word ? word : "unknown";
}

const char *saltus_side_word(int side) {
    return side > 0 ? "upper" : "lower";
}

const char *saltus_sides_word(saltus_sides sides) {
    return saltus_word_of(saltus_side_words, (int)sides);
}

const char *saltus_integrator_used(const saltus_system *system, saltus_integrator asked) {
    return asked == SALTUS_AUTOMATIC ? saltus_system_integrator(system)
                                     : saltus_word_of(saltus_integrator_words, (int)asked);
}

double saltus_event_after(const saltus_event *event) {
    return event->kind == SALTUS_STICK ? 0 : event->velocity_after;
}

void saltus_motion_summary(const saltus_motion *motion, char text[64]) {
    bool known = saltus_verdict_settled(motion->verdict) &&
                 (motion->multiplier_count > 0 || motion->eigenvalue_count > 0);
    snprintf(text, 64, "%s%s", motion->label, !known ? "" : motion->stable ? ", stable" : ", unstable");
}

const saltus_notation *saltus_notation_of(const saltus_system *system) {
    return saltus_model_notation(saltus_system_spec(system)->model);
}

double saltus_impacts_per_response(const saltus_system *system, const saltus_motion *motion) {
    if (motion->verdict != SALTUS_PERIODIC || motion->impacts < 0 || motion->periods < 1)
        return NAN;
    return saltus_notation_of(system)->response * (double)motion->impacts / motion->periods;
}

bool saltus_parameter_shown(const saltus_spec *spec, int k) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    /* Optional elements of built-in models (parameters with default 0) are omitted while they are 0. */
    bool absent = spec->parameters[k] == 0 && p[k].fallback == 0 && !saltus_model_text(spec->model);
    return saltus_spec_matters(spec, k) && !absent;
}

void saltus_put_table_head(FILE *file, const char *what, const saltus_scene *scene, const char *motion,
                           const saltus_spec *spec) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    fprintf(file, "# Saltus " SALTUS_VERSION " %s\n# scene: %s\n", what, scene->name);
    if (scene->title[0])
        fprintf(file, "# title: %s\n", scene->title);
    if (motion)
        fprintf(file, "# motion: %s\n", motion);
    fprintf(file, "# model: %s\n# parameters: ", saltus_model_name(spec->model));
    for (int k = 0; k < count; k++) {
        fprintf(file, "%s%s = ", k ? ", " : "", p[k].name);
        saltus_put_number(file, spec->parameters[k]);
    }
    if (spec->observe[0])
        fprintf(file, ", observe = %s", spec->observe);
    for (int s = 0; s < spec->stop_count; s++) {
        fprintf(file, "\n# stop %d: ", s + 1);
        saltus_put_stop(file, spec, s);
    }
    fputc('\n', file);
}

void saltus_put_tolerances(FILE *file, const saltus_system *system, const saltus_flow_options *flow) {
    char rtol[SALTUS_NUMBER_MAX], atol[SALTUS_NUMBER_MAX];
    fprintf(file, "rtol = %s, atol = %s, integrator = %s (%s)", saltus_number(flow->rtol, rtol),
            saltus_number(flow->atol, atol), saltus_word_of(saltus_integrator_words, (int)flow->integrator),
            saltus_integrator_used(system, flow->integrator));
}

void saltus_put_stop_place(FILE *file, const saltus_spec *spec, int stop, int digits) {
    int count;
    char text[SALTUS_NUMBER_MAX];
    const double *place = saltus_stop_place(spec->model, &spec->stops[stop], &count);
    const char *coordinate = saltus_stop_text(spec, stop, SALTUS_STOP_COORDINATE);
    if (coordinate) {
        fprintf(file, "coordinate = %s", coordinate);
        return;
    }
    fprintf(file, "%s = %s", saltus_model_stop_key(spec->model), count > 1 ? "[" : "");
    for (int k = 0; k < count; k++)
        fprintf(file, "%s%s", k ? ", " : "", saltus_number_of(place[k], digits, text));
    fputs(count > 1 ? "]" : "", file);
}

void saltus_put_stop(FILE *file, const saltus_spec *spec, int stop) {
    const saltus_stop *s = &spec->stops[stop];
    char d[SALTUS_NUMBER_MAX], r[SALTUS_NUMBER_MAX];
    saltus_put_stop_place(file, spec, stop, 17);
    const char *law = saltus_restitution_law(spec, stop);
    fprintf(file, ", d = %s, r = %s, sides = %s", saltus_number(s->d, d), law ? law : saltus_number(s->r, r),
            saltus_sides_word(s->sides));
}

void saltus_put_eigenvalues(FILE *file, const saltus_eigenvalue *eigenvalues, int count, bool held) {
    enum { leading = 4 };
    int unstable = 0;
    fprintf(file, "  %-14s", "eigenvalues");
    for (int k = 0, shown = 0; k < count && shown < leading; k++, shown++) {
        fprintf(file, "%s%.6g", shown ? ", " : "", eigenvalues[k].re);
        if (eigenvalues[k].im != 0)
            fprintf(file, " +- %.6gi", fabs(eigenvalues[k].im));
        k += eigenvalues[k].im != 0;
    }
    for (int k = 0; k < count; k++)
        unstable += eigenvalues[k].re > 0;
    fprintf(file, "%s%s", count ? "" : "none", count > leading ? ", ..." : "");
    if (unstable)
        fprintf(file, "; %d with a positive real part", unstable);
    fputs(held ? " (of the motion that keeps in contact)\n" : "\n", file);
}

bool saltus_multiplier_pair(const saltus_motion *motion, int k) {
    const saltus_multiplier *m = &motion->multipliers[k];
    return k + 1 < motion->multiplier_count && m->im != 0 && fabs(m[1].im + m->im) <= 1e-9 * fabs(m->im) &&
           fabs(m[1].re - m->re) <= 1e-9 * (fabs(m->re) + fabs(m->im));
}

bool saltus_key_means(const char *key, const char *name, int s) {
    size_t length = strlen(name);
    return strncmp(key, name, length) == 0 && (!key[length] || atoi(key + length) == s + 1);
}

void saltus_put_word(FILE *file, const char *word) {
    fprintf(file, "  %-14s", word);
}

void saltus_put_scene(FILE *file, const saltus_scene *scene, const saltus_system *system) {
    const saltus_spec *spec = saltus_system_spec(system);
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    if (scene->title[0])
        fprintf(file, "  %s\n", scene->title);
    saltus_put_word(file, saltus_model_name(spec->model));
    const char *separator = "";
    for (int k = 0; k < count; k++)
        if (saltus_parameter_shown(spec, k)) {
            fprintf(file, "%s%s = %.10g", separator, p[k].name, spec->parameters[k]);
            separator = ", ";
        }
    fputc('\n', file);
    for (int s = 0; s < spec->stop_count; s++) {
        const saltus_stop *stop = &spec->stops[s];
        fprintf(file, "  stop %-9d", s + 1);
        saltus_put_stop_place(file, spec, s, 10);
        const char *law = saltus_restitution_law(spec, s);
        char r[32];
        snprintf(r, sizeof r, "%.10g", stop->r);
        fprintf(file, ", d = %.10g, r = %s, %s\n", stop->d, law ? law : r,
                stop->sides == SALTUS_BOTH    ? "both sides"
                : stop->sides == SALTUS_UPPER ? "upper side"
                                              : "lower side");
    }
}
