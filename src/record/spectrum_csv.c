/* Spectra as comma-separated values.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/spectrum.h"

#include "record/describe.h"

#include <math.h>

static void put_quantity(FILE *file, const saltus_spectrum *s, const char *name) {
    char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX], c[SALTUS_NUMBER_MAX], d[SALTUS_NUMBER_MAX];
    fprintf(file, "# %s: mean = %s, total power = %s", name, saltus_number(s->mean, a),
            saltus_number(s->variance, b));
    if (s->kind == SALTUS_SPECTRUM_CONSTANT) {
        fputs(", does not move\n", file);
        return;
    }
    fprintf(file,
            ", broadband fraction = %s\n# %s: highest trustworthy frequency = %s omega (aliasing below 1 %%)",
            saltus_number(s->broadband, c), name, saltus_number(s->trustworthy, d));
    if (s->kind == SALTUS_SPECTRUM_LINES) {
        fprintf(file, "; largest between the lines = %s of the highest\n", saltus_number(s->between, a));
        return;
    }
    fprintf(file, "; degrees of freedom = %s (half at both ends), confidence = %s\n",
            saltus_number(s->degrees, a), saltus_number(s->confidence, b));
    for (long long k = 0; k < s->line_count; k++)
        fprintf(file, "# %s line: frequency_over_omega = %s, amplitude = %s, phase = %s, share = %s\n", name,
                saltus_number(s->lines[k].frequency, a), saltus_number(s->lines[k].amplitude, b),
                saltus_number(s->lines[k].phase, c), saltus_number(s->lines[k].share, d));
}

static void put_header(const saltus_spectra_source *source, FILE *file) {
    char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX], method[256];
    saltus_spectra_method(source->spectra, method, sizeof method);
    saltus_put_table_head(file, "spectrum", source->scene, source->motion->label,
                          saltus_system_spec(source->system));
    fprintf(file, "# options: rtol = %s, atol = %s, integrator = %s (%s)\n# analysed: %s\n",
            saltus_number(source->flow->rtol, a), saltus_number(source->flow->atol, b),
            saltus_integrator_word(source->flow->integrator),
            saltus_integrator_used(source->system, source->flow->integrator), method);
    for (int k = 0; k < source->spectra->count; k++) {
        put_quantity(file, &source->spectra->spectra[k],
                     saltus_quantity_name(source->system, source->spectra->quantities[k]).text);
    }
    fputs("# a line is amplitude * cos(frequency_over_omega * omega * time + phase), time from section phase "
          "0\n"
          "# a density (psd) is one-sided: its integral over frequency_over_omega is the total power; low "
          "and high bound its confidence band\n"
          "# dB: of an amplitude over the highest line's, of a density over its peak's\n",
          file);
}

static void put_value(FILE *file, double value) {
    fputc(',', file);
    saltus_put_number(file, value);
}

static void put_columns(const saltus_spectra_source *source, bool lines, FILE *file) {
    const saltus_spectra *spectra = source->spectra;
    fputs(lines ? "harmonic,frequency_over_omega" : "frequency_over_omega", file);
    for (int k = 0; k < spectra->count; k++) {
        const saltus_state_name whole = saltus_quantity_name(source->system, spectra->quantities[k]);
        const char *name = whole.text;
        if (spectra->spectra[k].kind == SALTUS_SPECTRUM_LINES)
            fprintf(file, ",%s_amplitude,%s_phase,%s_dB", name, name, name);
        if (spectra->spectra[k].kind == SALTUS_SPECTRUM_WELCH)
            fprintf(file, ",%s_psd,%s_psd_low,%s_psd_high,%s_dB", name, name, name, name);
    }
    fputc('\n', file);
}

void saltus_put_spectra_table(const saltus_spectra_source *source, FILE *file) {
    const saltus_spectra *spectra = source->spectra;
    double peak[SALTUS_QUANTITIES_MAX] = {0};
    const saltus_spectrum *first = NULL;
    for (int k = spectra->count - 1; k >= 0; k--) {
        for (long long b = 0; b < spectra->spectra[k].bins; b++)
            peak[k] = fmax(peak[k], spectra->spectra[k].density[b]);
        if (spectra->spectra[k].kind != SALTUS_SPECTRUM_CONSTANT)
            first = &spectra->spectra[k];
    }
    bool lines = first && first->kind == SALTUS_SPECTRUM_LINES;
    long long rows = !first ? 0 : lines ? first->line_count : first->bins;
    put_header(source, file);
    put_columns(source, lines, file);
    for (long long row = 0; row < rows && !ferror(file); row++) {
        if (lines)
            fprintf(file, "%lld,", first->lines[row].harmonic);
        saltus_put_number(file, lines ? first->lines[row].frequency : (double)row * first->resolution);
        for (int k = 0; k < spectra->count; k++) {
            const saltus_spectrum *s = &spectra->spectra[k];
            if (s->kind == SALTUS_SPECTRUM_LINES) {
                put_value(file, s->lines[row].amplitude);
                put_value(file, s->lines[row].phase);
                put_value(file, s->lines[row].decibels);
            } else if (s->kind == SALTUS_SPECTRUM_WELCH) {
                put_value(file, s->density[row]);
                put_value(file, s->low * s->density[row]);
                put_value(file, s->high * s->density[row]);
                put_value(file, 10 * log10(s->density[row] / peak[k]));
            }
        }
        fputc('\n', file);
    }
}
