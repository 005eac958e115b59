/* Spectra in a few lines for people, and as one JSON object.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/spectrum.h"

#include "record/fields.h"
#include "record/json.h"

#include <math.h>
#include <stdlib.h>

enum { strongest_lines = 10 };

static const double faintest = -220; /* decibels: below, lines are rounding */

/* The first spectrum that moves; NULL if none does. */
static const saltus_spectrum *moving(const saltus_spectra *spectra) {
    for (int k = 0; k < spectra->count; k++)
        if (spectra->spectra[k].kind != SALTUS_SPECTRUM_CONSTANT)
            return &spectra->spectra[k];
    return NULL;
}

void saltus_spectra_method(const saltus_spectra *spectra, char *text, size_t room) {
    const saltus_spectrum *s = moving(spectra);
    if (s && s->kind == SALTUS_SPECTRUM_LINES)
        snprintf(text, room, "%d orbits of %d T, %d samples a period", s->orbits, s->periods,
                 spectra->per_period);
    else if (s)
        snprintf(
            text, room,
            "%lld T, %d samples a period; %lld segment%s of %lld T (Welch, Hann window, half overlapping)",
            spectra->analysed, spectra->per_period, s->segments, s->segments == 1 ? "" : "s",
            s->segment_periods);
    else
        snprintf(text, room, "%lld T, %d samples a period", spectra->analysed, spectra->per_period);
}

static int by_amplitude(const void *a, const void *b) {
    const saltus_spectral_line *p = *(const saltus_spectral_line *const *)a,
                               *q = *(const saltus_spectral_line *const *)b;
    return p->amplitude == q->amplitude ? (p->frequency > q->frequency) - (p->frequency < q->frequency)
                                        : (p->amplitude < q->amplitude) - (p->amplitude > q->amplitude);
}

/* The strongest lines up to the highest trustworthy frequency; how many. */
static int pick_lines(const saltus_spectrum *s, const saltus_spectral_line *picked[strongest_lines]) {
    int count = 0;
    for (long long k = 0; k < s->line_count; k++) {
        const saltus_spectral_line *line = &s->lines[k];
        if (line->frequency > s->trustworthy || !(line->decibels > faintest))
            continue;
        if (count < strongest_lines)
            picked[count++] = line;
        else if (by_amplitude(&line, &picked[count - 1]) < 0)
            picked[count - 1] = line;
        qsort(picked, (size_t)count, sizeof *picked, by_amplitude);
    }
    return count;
}

static void put_lines(FILE *file, const saltus_spectrum *s) {
    const saltus_spectral_line *picked[strongest_lines];
    int count = pick_lines(s, picked);
    if (count == 0) {
        fputs(s->line_count ? "    no line below that frequency\n"
                            : "    no line stands out of the continuum\n",
              file);
        return;
    }
    fprintf(file, "    %14s  %16s  %10s  %9s  %10s\n", "line: f/omega", "amplitude", "phase", "dB", "share");
    for (int k = 0; k < count; k++) {
        const saltus_spectral_line *line = picked[k];
        char name[32];
        if (line->harmonic && s->periods > 1)
            snprintf(name, sizeof name, "%lld/%d = %.6g", line->harmonic, s->periods, line->frequency);
        else
            snprintf(name, sizeof name, "%.9g", line->frequency);
        fprintf(file, "    %14s  %16.10g  %10.6f  %9.3f  %10.3g\n", name, line->amplitude, line->phase,
                line->decibels, line->share);
    }
    if (count < s->line_count)
        fprintf(file, "    ... the %d strongest\n", count);
}

static void put_spectrum(FILE *file, const saltus_spectrum *s, const char *name) {
    if (s->kind == SALTUS_SPECTRUM_CONSTANT) {
        fprintf(file, "  %-14sdoes not move: %.10g throughout\n", name, s->mean);
        return;
    }
    fprintf(file, "  %-14smean %.10g, total power %.10g, broadband fraction %.3g\n", name, s->mean,
            s->variance, s->broadband);
    if (s->kind == SALTUS_SPECTRUM_LINES) {
        char part[16] = "";
        if (s->periods > 1)
            snprintf(part, sizeof part, "/%d", s->periods);
        fprintf(file, "    lines at multiples of omega%s, bins every omega/%d", part, s->periods * s->orbits);
        if (s->orbits > 1)
            fprintf(file, "; between the lines at most %.2g of the highest", s->between);
        fputc('\n', file);
    } else
        fprintf(file,
                "    resolution omega/%lld; %.3g degrees of freedom: %g %% band from %.2f to %.2f dB about "
                "the density\n",
                s->segment_periods, s->degrees, 100 * s->confidence, 10 * log10(s->low), 10 * log10(s->high));
    if (isnan(s->trustworthy))
        fputs("    aliasing was not looked at\n", file);
    else
        fprintf(file, "    highest trustworthy frequency %.6g omega (aliasing below 1 %%), of %.6g sampled\n",
                s->trustworthy, s->per_period / 2.0);
    put_lines(file, s);
}

void saltus_write_spectra_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                               const saltus_motion *motion, const saltus_spectra *spectra) {
    char verdict[64], method[256];
    saltus_motion_summary(motion, verdict);
    saltus_spectra_method(spectra, method, sizeof method);
    fprintf(file, "%s: %s\n", scene->name, verdict);
    saltus_put_scene(file, scene, system);
    fprintf(file, "  %-14s%s\n", "analysed", method);
    for (int k = 0; k < spectra->count; k++)
        put_spectrum(file, &spectra->spectra[k], saltus_quantity_name(system, spectra->quantities[k]).text);
}

/* JSON */

static void put_line_json(FILE *file, const saltus_spectral_line *line, bool first) {
    fputs(first ? "{" : ", {", file);
    if (line->harmonic)
        fprintf(file, "\"harmonic\": %lld, ", line->harmonic);
    saltus_json_fields(file, "", &saltus_spectral_line_fields, NULL, line);
    fputc('}', file);
}

static void put_spectrum_json(FILE *file, const saltus_spectrum *s, const char *name) {
    const bool lines = s->kind == SALTUS_SPECTRUM_LINES;
    fprintf(file, "{\"quantity\": \"%s\", \"kind\": \"%s\"", name,
            lines                              ? "lines"
            : s->kind == SALTUS_SPECTRUM_WELCH ? "density"
                                               : "constant");
    saltus_json_fields(file, ", ", &saltus_spectrum_fields[0], NULL, s);
    if (s->kind != SALTUS_SPECTRUM_CONSTANT) {
        saltus_json_fields(file, ", ", &saltus_spectrum_fields[1], NULL, s);
        saltus_json_fields(file, ", ", &saltus_spectrum_fields[lines ? 2 : 3], NULL, s);
    }
    fputs(", \"lines\": [", file);
    for (long long k = 0; k < s->line_count && !(s->lines[k].frequency > s->trustworthy); k++)
        put_line_json(file, &s->lines[k], k == 0);
    fputs("]}", file);
}

void saltus_write_spectra_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                               const saltus_motion *motion, const saltus_spectra *spectra) {
    char method[256];
    saltus_spectra_method(spectra, method, sizeof method);
    fputs("{\"version\": \"" SALTUS_VERSION "\"", file);
    saltus_json_text(file, "scene", scene->name);
    saltus_json_text(file, "label", motion->label);
    fprintf(file, ", \"periods\": %d, \"analysed_periods\": %lld, \"samples_per_period\": %d",
            spectra->periods, spectra->analysed, spectra->per_period);
    saltus_json_text(file, "method", method);
    saltus_json_key(file, "spectra");
    for (int k = 0; k < spectra->count; k++) {
        fputs(k ? ", " : "[", file);
        put_spectrum_json(file, &spectra->spectra[k],
                          saltus_quantity_name(system, spectra->quantities[k]).text);
    }
    fputc(']', file);
    saltus_json_parameters(file, saltus_system_spec(system));
    saltus_json_text(file, "integrator", saltus_integrator_used(system, motion->integrator));
    fputs("}\n", file);
}
