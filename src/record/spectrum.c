/* Spectra as a few lines for people, as one JSON object and as CSV.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/json.h"

#include <math.h>
#include <stdlib.h>

enum { strongest_lines = 10 };

static const double faintest = -220; /* decibels; weaker lines are rounding errors */

/* The first spectrum that is not constant; NULL if there is none. */
static const saltus_spectrum *moving(const saltus_spectra *spectra) {
    for (int k = 0; k < spectra->count; k++)
        if (spectra->spectra[k].kind != SALTUS_SPECTRUM_CONSTANT)
            return &spectra->spectra[k];
    return NULL;
}

void saltus_spectra_method(const saltus_spectra *spectra, char *text, size_t room) {
    const saltus_spectrum *s = moving(spectra);
    if (s && s->kind == SALTUS_SPECTRUM_LINES)
        snprintf(text, room, "%d orbit%s of %d T, %d samples a period", s->orbits, saltus_plural(s->orbits),
                 s->periods, spectra->per_period);
    else if (s)
        snprintf(
            text, room,
            "%lld T, %d samples a period; %lld segment%s of %lld T (Welch, Hann window, half overlapping)",
            spectra->analysed, spectra->per_period, s->segments, saltus_plural(s->segments),
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

/* The strongest lines up to the highest trustworthy frequency. */
static void put_lines(FILE *file, const saltus_spectrum *s) {
    const saltus_spectral_line *picked[strongest_lines];
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
    if (count == 0)
        fputs(s->line_count ? "    no line below that frequency\n"
                            : "    no line stands out of the continuum\n",
              file);
    else
        fprintf(file, "    %14s  %16s  %10s  %9s  %10s\n", "line: f/omega", "amplitude", "phase", "dB",
                "share");
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
    if (count && count < s->line_count)
        fprintf(file, "    ... the %d strongest\n", count);
}

void saltus_write_spectra_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                               const saltus_motion *motion, const saltus_spectra *spectra) {
    char verdict[64], method[256];
    saltus_motion_summary(motion, verdict);
    saltus_spectra_method(spectra, method, sizeof method);
    fprintf(file, "%s: %s\n", scene->name, verdict);
    saltus_put_scene(file, scene, system);
    fprintf(file, "  %-14s%s\n", "analysed", method);
    for (int k = 0; k < spectra->count; k++) {
        const saltus_spectrum *s = &spectra->spectra[k];
        const saltus_state_name name = saltus_quantity_name(system, spectra->quantities[k]);
        if (s->kind == SALTUS_SPECTRUM_CONSTANT) {
            fprintf(file, "  %-14sdoes not move: %.10g throughout\n", name.text, s->mean);
            continue;
        }
        fprintf(file, "  %-14smean %.10g, total power %.10g, broadband fraction %.3g\n", name.text, s->mean,
                s->variance, s->broadband);
        if (s->kind == SALTUS_SPECTRUM_LINES) {
            char part[16] = "";
            if (s->periods > 1)
                snprintf(part, sizeof part, "/%d", s->periods);
            fprintf(file, "    lines at multiples of omega%s, bins every omega/%d", part,
                    s->periods * s->orbits);
            if (s->orbits > 1)
                fprintf(file, "; between the lines at most %.2g of the highest", s->between);
            fputc('\n', file);
        } else
            fprintf(file,
                    "    resolution omega/%lld; %.3g degrees of freedom: %g %% band from %.2f to %.2f dB "
                    "about the density\n",
                    s->segment_periods, s->degrees, 100 * s->confidence, 10 * log10(s->low),
                    10 * log10(s->high));
        if (isnan(s->trustworthy))
            fputs("    aliasing was not looked at\n", file);
        else
            fprintf(file,
                    "    highest trustworthy frequency %.6g omega (aliasing below 1 %%), of %.6g sampled\n",
                    s->trustworthy, s->per_period / 2.0);
        put_lines(file, s);
    }
}

void saltus_write_spectra_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                               const saltus_motion *motion, const saltus_spectra *spectra) {
    static const char *const kinds[] = {[SALTUS_SPECTRUM_CONSTANT] = "constant",
                                        [SALTUS_SPECTRUM_LINES] = "lines",
                                        [SALTUS_SPECTRUM_WELCH] = "density"};
    char method[256];
    saltus_spectra_method(spectra, method, sizeof method);
    saltus_json_begin(file, scene);
    saltus_json_text(file, "label", motion->label);
    fprintf(file, ", \"periods\": %d, \"analysed_periods\": %lld, \"samples_per_period\": %d",
            spectra->periods, spectra->analysed, spectra->per_period);
    saltus_json_text(file, "method", method);
    saltus_json_key(file, "spectra");
    for (int q = 0; q < spectra->count; q++) {
        const saltus_spectrum *s = &spectra->spectra[q];
        fprintf(file, "%s{\"quantity\": \"%s\"", q ? ", " : "[",
                saltus_quantity_name(system, spectra->quantities[q]).text);
        saltus_json_text(file, "kind", kinds[s->kind]);
        saltus_json_member(file, "mean", s->mean);
        saltus_json_member(file, "total_power", s->variance);
        if (s->kind != SALTUS_SPECTRUM_CONSTANT) {
            saltus_json_member(file, "broadband_fraction", s->broadband);
            saltus_json_member(file, "highest_trustworthy", s->trustworthy);
            saltus_json_member(file, "resolution", s->resolution);
            saltus_json_member(file, "parseval", s->parseval);
        }
        if (s->kind == SALTUS_SPECTRUM_LINES) {
            fprintf(file, ", \"orbits\": %d", s->orbits);
            saltus_json_member(file, "between_lines", s->between);
        } else if (s->kind == SALTUS_SPECTRUM_WELCH) {
            fprintf(file, ", \"segments\": %lld, \"segment_periods\": %lld", s->segments, s->segment_periods);
            saltus_json_member(file, "degrees_of_freedom", s->degrees);
            saltus_json_member(file, "confidence", s->confidence);
            saltus_json_member(file, "band_low", s->low);
            saltus_json_member(file, "band_high", s->high);
        }
        fputs(", \"lines\": [", file);
        for (long long k = 0; k < s->line_count && !(s->lines[k].frequency > s->trustworthy); k++) {
            const saltus_spectral_line *line = &s->lines[k];
            fputs(k ? ", {" : "{", file);
            if (line->harmonic)
                fprintf(file, "\"harmonic\": %lld, ", line->harmonic);
            fputs("\"frequency_over_omega\": ", file);
            saltus_json_value(file, line->frequency);
            saltus_json_member(file, "amplitude", line->amplitude);
            saltus_json_member(file, "phase", line->phase);
            saltus_json_member(file, "decibels", line->decibels);
            saltus_json_member(file, "share", line->share);
            fputc('}', file);
        }
        fputs("]}", file);
    }
    fputc(']', file);
    saltus_json_end(file, saltus_system_spec(system), saltus_integrator_used(system, motion->integrator));
}

static void put_header(const saltus_spectra_source *source, FILE *file) {
    const saltus_spectra *spectra = source->spectra;
    char method[256], a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX], c[SALTUS_NUMBER_MAX], d[SALTUS_NUMBER_MAX];
    saltus_spectra_method(spectra, method, sizeof method);
    saltus_put_table_head(file, "spectrum", source->scene, source->motion->label,
                          saltus_system_spec(source->system));
    fputs("# options: ", file);
    saltus_put_tolerances(file, source->system, source->flow);
    fprintf(file, "\n# analysed: %s\n", method);
    for (int k = 0; k < spectra->count; k++) {
        const saltus_spectrum *s = &spectra->spectra[k];
        const saltus_state_name whole = saltus_quantity_name(source->system, spectra->quantities[k]);
        const char *name = whole.text;
        fprintf(file, "# %s: mean = %s, total power = %s", name, saltus_number(s->mean, a),
                saltus_number(s->variance, b));
        if (s->kind != SALTUS_SPECTRUM_CONSTANT)
            fprintf(file,
                    ", broadband fraction = %s\n# %s: highest trustworthy frequency = %s omega (aliasing "
                    "below 1 %%)",
                    saltus_number(s->broadband, c), name, saltus_number(s->trustworthy, d));
        if (s->kind == SALTUS_SPECTRUM_CONSTANT)
            fputs(", does not move\n", file);
        else if (s->kind == SALTUS_SPECTRUM_LINES)
            fprintf(file, "; largest between the lines = %s of the highest\n", saltus_number(s->between, a));
        else
            fprintf(file, "; degrees of freedom = %s (half at both ends), confidence = %s\n",
                    saltus_number(s->degrees, a), saltus_number(s->confidence, b));
        for (long long i = 0; i < s->line_count && s->kind == SALTUS_SPECTRUM_WELCH; i++)
            fprintf(file, "# %s line: frequency_over_omega = %s, amplitude = %s, phase = %s, share = %s\n",
                    name, saltus_number(s->lines[i].frequency, a), saltus_number(s->lines[i].amplitude, b),
                    saltus_number(s->lines[i].phase, c), saltus_number(s->lines[i].share, d));
    }
    fputs("# a line is amplitude * cos(frequency_over_omega * omega * time + phase), time from section phase "
          "0\n"
          "# a density (psd) is one-sided: its integral over frequency_over_omega is the total power; low "
          "and high bound its confidence band\n"
          "# dB: of an amplitude over the highest line's, of a density over its peak's\n",
          file);
}

void saltus_put_spectra_table(const saltus_spectra_source *source, FILE *file) {
    const saltus_spectra *spectra = source->spectra;
    const saltus_spectrum *first = moving(spectra);
    const bool lines = first && first->kind == SALTUS_SPECTRUM_LINES;
    const long long rows = !first ? 0 : lines ? first->line_count : first->bins;
    double peak[SALTUS_QUANTITIES_MAX] = {0};
    put_header(source, file);
    fputs(lines ? "harmonic,frequency_over_omega" : "frequency_over_omega", file);
    for (int k = 0; k < spectra->count; k++) {
        const saltus_spectrum *s = &spectra->spectra[k];
        const saltus_state_name whole = saltus_quantity_name(source->system, spectra->quantities[k]);
        const char *name = whole.text;
        for (long long b = 0; b < s->bins; b++)
            peak[k] = fmax(peak[k], s->density[b]);
        if (s->kind == SALTUS_SPECTRUM_LINES)
            fprintf(file, ",%s_amplitude,%s_phase,%s_dB", name, name, name);
        if (s->kind == SALTUS_SPECTRUM_WELCH)
            fprintf(file, ",%s_psd,%s_psd_low,%s_psd_high,%s_dB", name, name, name, name);
    }
    fputc('\n', file);
    for (long long row = 0; row < rows && !ferror(file); row++) {
        if (lines)
            fprintf(file, "%lld,", first->lines[row].harmonic);
        saltus_put_number(file, lines ? first->lines[row].frequency : (double)row * first->resolution);
        for (int k = 0; k < spectra->count; k++) {
            const saltus_spectrum *s = &spectra->spectra[k];
            if (s->kind == SALTUS_SPECTRUM_LINES) {
                const saltus_spectral_line *line = &s->lines[row];
                saltus_put_numbers(file, (const double[]){line->amplitude, line->phase, line->decibels}, 3);
            } else if (s->kind == SALTUS_SPECTRUM_WELCH) {
                const double density = s->density[row];
                saltus_put_numbers(file,
                                   (const double[]){density, s->low * density, s->high * density,
                                                    10 * log10(density / peak[k])},
                                   4);
            }
        }
        fputc('\n', file);
    }
}
