/* The figure of spectra: for each quantity its low frequencies and, on a logarithmic axis, all of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/spectrum.h"

#include "figure/gnuplot.h"
#include "record/describe.h"
#include "record/output.h"

#include <math.h>

#define TRACE "#2c5f8a"
#define BAND "#c3d4e4"
#define FORCED "#c44e2a"
#define BEYOND "#ececec"
#define EDGE "#808080"

enum { cells_per_octave = 96 };

/* Decibels shown: the low frequencies, and all of them at most. */
static const double shallow = -100, deep = -320, deep_density = -200;

/* One quantity's spectrum on the page. */
typedef struct row {
    const saltus_spectra_source *source;
    const saltus_spectrum *s;
    saltus_quantity quantity;
    FILE *file;
    int number;        /* from 1 */
    double peak;       /* highest density */
    double low_end;    /* end of the axis of low frequencies */
    double floor;      /* lowest decibels of the whole spectrum */
    double begin, end; /* of the logarithmic axis */
} row;

static void add_name(const row *r, saltus_line *line) {
    char name[160];
    int k = r->quantity.coordinate;
    if (k == 0) {
        saltus_observed_name(r->source->system, r->quantity.velocity, name, sizeof name);
        saltus_line_add(line, "%s", name);
        return;
    }
    const saltus_notation *n = saltus_notation_of(r->source->system);
    saltus_line_add(line, "%s %d, {/:Italic %s}%s_{%d}", n->part, k, n->coordinate,
                    r->quantity.velocity ? "′" : "", k);
}

/* Data */

static double decibels(double ratio, double factor) {
    return ratio > 0 ? fmax(deep - 20, factor * log10(ratio)) : deep - 20;
}

/* Line k's place and height, and whether it is a multiple of the forcing frequency. */
static void put_line(const row *r, const saltus_spectral_line *line) {
    bool forced = r->s->periods > 1 && line->harmonic % r->s->periods == 0;
    fprintf(r->file, "%.9g %.6g %d\n", line->frequency, fmax(line->decibels, deep - 20), forced);
}

static void put_bin(const row *r, double frequency, double density) {
    const saltus_spectrum *s = r->s;
    fprintf(r->file, "%.9g %.6g %.6g %.6g\n", frequency, decibels(density / r->peak, 10),
            decibels(s->low * density / r->peak, 10), decibels(s->high * density / r->peak, 10));
}

static void put_low_data(const row *r) {
    const saltus_spectrum *s = r->s;
    fprintf(r->file, "$low%d << EOD\n", r->number);
    if (s->kind == SALTUS_SPECTRUM_LINES)
        for (long long k = 0; k < s->line_count && s->lines[k].frequency <= r->low_end; k++)
            put_line(r, &s->lines[k]);
    else
        for (long long k = 0; k < s->bins && (double)k * s->resolution <= r->low_end; k++)
            put_bin(r, (double)k * s->resolution, s->density[k]);
    fputs("EOD\n", r->file);
}

/* Which cell of the logarithmic axis a frequency lies in; the page does not show more than one mark for each.
 */
static double cell_of(double frequency) {
    return floor(cells_per_octave * log2(frequency));
}

/* The highest line or the mean density of each cell. */
static void put_whole_data(const row *r) {
    const saltus_spectrum *s = r->s;
    fprintf(r->file, "$whole%d << EOD\n", r->number);
    for (long long k = 0; k < s->line_count && s->kind == SALTUS_SPECTRUM_LINES;) {
        const saltus_spectral_line *highest = &s->lines[k];
        double cell = cell_of(highest->frequency);
        for (; k < s->line_count && cell_of(s->lines[k].frequency) == cell; k++)
            if (s->lines[k].amplitude > highest->amplitude)
                highest = &s->lines[k];
        put_line(r, highest);
    }
    for (long long k = 1; k < s->bins && s->kind == SALTUS_SPECTRUM_WELCH;) {
        double sum = 0, cell = cell_of((double)k * s->resolution);
        long long first = k;
        for (; k < s->bins && cell_of((double)k * s->resolution) == cell; k++)
            sum += s->density[k];
        put_bin(r, 0.5 * s->resolution * (double)(first + k - 1), sum / (double)(k - first));
    }
    fputs("EOD\n", r->file);
}

/* Ranges */

/* The low frequencies end where no line is within 60 dB of the highest, between 4 and 16 omega. */
static double find_low_end(const saltus_spectrum *s, double peak) {
    double end = 4;
    for (long long k = 0; k < s->line_count; k++)
        if (s->lines[k].decibels > -60)
            end = fmax(end, s->lines[k].frequency);
    for (long long k = 1; k < s->bins && s->kind == SALTUS_SPECTRUM_WELCH; k++)
        if (s->density[k] > 1e-6 * peak)
            end = fmax(end, (double)k * s->resolution);
    return fmin(fmin(16, s->per_period / 2.0), ceil(end + 0.25));
}

static double find_floor(const row *r) {
    const saltus_spectrum *s = r->s;
    double lowest = s->kind == SALTUS_SPECTRUM_LINES && s->between > 0 && isfinite(s->between)
                        ? decibels(s->between, 20)
                        : 0;
    for (long long k = 0; k < s->line_count && s->kind == SALTUS_SPECTRUM_LINES; k++)
        if (s->lines[k].frequency <= s->trustworthy && s->lines[k].decibels > deep)
            lowest = fmin(lowest, s->lines[k].decibels);
    for (long long k = 1; k < s->bins && s->kind == SALTUS_SPECTRUM_WELCH; k++)
        lowest = fmin(lowest, decibels(s->low * s->density[k] / r->peak, 10));
    return fmax(s->kind == SALTUS_SPECTRUM_LINES ? deep : deep_density, 20 * floor((lowest - 10) / 20));
}

static row make_row(const saltus_spectra_source *source, int k, int number, FILE *file) {
    const saltus_spectrum *s = &source->spectra->spectra[k];
    row r = {.source = source,
             .s = s,
             .quantity = source->spectra->quantities[k],
             .file = file,
             .number = number,
             .end = s->per_period / 2.0};
    for (long long b = 0; b < s->bins; b++)
        r.peak = fmax(r.peak, s->density[b]);
    r.low_end = find_low_end(s, r.peak);
    r.floor = find_floor(&r);
    r.begin = s->kind == SALTUS_SPECTRUM_LINES ? 0.8 / s->periods : s->resolution;
    return r;
}

/* Panels */

static void open_panel(const row *r, const double across[2], const double up[2], int letter,
                       const saltus_line *heading) {
    saltus_put_margins(r->file, across, up);
    fprintf(r->file,
            "set label 99 '{/:Bold (%c)}  %s' at graph 0, graph 1 offset 0,1.1 left front tc rgb '#202020'\n"
            "set xlabel 'frequency / {/:Italic ω}'\nset ylabel '%s' offset -0.4,0\n",
            'a' + letter, heading->text,
            r->s->kind == SALTUS_SPECTRUM_LINES ? "amplitude, dB of the highest"
                                                : "power density, dB of its peak");
}

static void close_panel(FILE *file) {
    fputs("unset label\nunset object\nunset arrow\nunset logscale\nset format '% h'\nset xtics auto\nset "
          "ytics auto\nunset mxtics\n",
          file);
}

/* Grey from the highest trustworthy frequency on. */
static void put_limit(const row *r, double end) {
    double edge = r->s->trustworthy;
    if (!(edge < end))
        return;
    if (edge > r->begin)
        fprintf(
            r->file,
            "set arrow from %.9g, graph 0 to %.9g, graph 1 nohead back lc rgb '" EDGE "' lw 1.5\n"
            "set label '%.3g {/:Italic ω}' at %.9g, graph 0.94 left offset 0.5,0 front tc rgb '#505050'\n",
            edge, edge, edge, edge);
    fprintf(r->file,
            "set object rectangle from %.9g, graph 0 to %.9g, graph 1 back fc rgb '" BEYOND
            "' fs solid noborder\n",
            fmax(edge, r->begin), end);
}

/* Stems from the panel's lower edge up to frequency `stems`, and a dot for each line. */
static void plot_lines(const row *r, const char *data, double floor, double stems, const char *dot) {
    static const char *const colour[] = {TRACE, FORCED};
    const char *separator = "plot ";
    for (int forced = 0; forced < 2; forced++) {
        fprintf(
            r->file,
            "%s$%s%d using ($3 == %d && $2 > %g && $1 <= %g ? $1 : NaN):(%g):(0):($2 - (%g)) with vectors "
            "nohead lc rgb '%s' lw 1.3, \\\n     $%s%d using ($3 == %d ? $1 : NaN):2 with points pt 7 ps %s "
            "lc rgb '%s'",
            separator, data, r->number, forced, floor, stems, floor, floor, colour[forced], data, r->number,
            forced, dot, colour[forced]);
        separator = ", \\\n     ";
    }
    fputc('\n', r->file);
}

static void plot_density(const row *r, const char *data) {
    fprintf(r->file,
            "plot $%s%d using 1:3:4 with filledcurves fc rgb '" BAND
            "', \\\n     $%s%d using 1:2 with lines lc rgb '" TRACE "' lw 1.3\n",
            data, r->number, data, r->number);
}

static void put_ticks(const row *r, double floor) {
    double span = -floor, step = span > 240 ? 60 : span > 120 ? 40 : span > 60 ? 20 : 10;
    fprintf(r->file, "set yrange [%g:%g]\nset ytics %g\n", floor, 0.04 * span, step);
}

/* Whether a stronger line stands so near that the marks of both would touch. */
static bool outshone(const saltus_spectrum *s, long long k, double near) {
    const saltus_spectral_line *line = &s->lines[k];
    for (long long other = 0; other < s->line_count; other++)
        if (fabs(s->lines[other].frequency - line->frequency) < near &&
            s->lines[other].amplitude > line->amplitude)
            return true;
    return false;
}

/* Small marks at the upper edge where strong lines stand out of a continuum. */
static void put_line_marks(const row *r, double end) {
    for (long long k = 0; k < r->s->line_count && r->s->kind == SALTUS_SPECTRUM_WELCH; k++) {
        const saltus_spectral_line *line = &r->s->lines[k];
        if (line->frequency < end && line->decibels > -60 && !outshone(r->s, k, 0.015 * end))
            fprintf(r->file,
                    "set label '▾' at %.9g, graph 1 center offset 0,0.35 front tc rgb '" FORCED
                    "' font ',11'\n",
                    line->frequency);
    }
}

static void draw_low(const row *r, const double across[2], const double up[2], int letter,
                     const saltus_line *heading) {
    double floor = fmax(r->floor, shallow);
    open_panel(r, across, up, letter, heading);
    fprintf(r->file, "set xrange [0:%g]\nset xtics %g\nset mxtics 2\n", r->low_end,
            r->low_end > 10 ? 2.0 : 1.0);
    put_ticks(r, floor);
    put_limit(r, r->low_end);
    put_line_marks(r, r->low_end);
    if (r->s->kind == SALTUS_SPECTRUM_LINES)
        plot_lines(r, "low", floor, r->end, "0.7");
    else
        plot_density(r, "low");
    close_panel(r->file);
}

static void put_low(const row *r, const double across[2], const double up[2], int letter) {
    const saltus_spectrum *s = r->s;
    saltus_line heading = {.length = 0};
    add_name(r, &heading);
    if (s->kind == SALTUS_SPECTRUM_LINES && s->periods > 1)
        saltus_line_add(&heading, ":  lines at multiples of {/:Italic ω}/%d; red: of {/:Italic ω}",
                        s->periods);
    else if (s->kind == SALTUS_SPECTRUM_LINES)
        saltus_line_add(&heading, ":  lines at multiples of {/:Italic ω}");
    else
        saltus_line_add(&heading, ":  density; pale: %g %% confidence%s", 100 * s->confidence,
                        s->line_count ? "; ▾ strong lines" : "");
    draw_low(r, across, up, letter, &heading);
}

static void put_whole(const row *r, const double across[2], const double up[2], int letter) {
    const saltus_spectrum *s = r->s;
    saltus_line heading = {.length = 0};
    if (s->kind == SALTUS_SPECTRUM_LINES && s->orbits > 1)
        saltus_line_add(&heading, "all lines; dashed: largest between them");
    else
        saltus_line_add(&heading, "%s", s->kind == SALTUS_SPECTRUM_LINES ? "all lines" : "the whole density");
    if (s->trustworthy < r->end)
        saltus_line_add(&heading, "; grey: not trustworthy");
    open_panel(r, across, up, letter, &heading);
    fprintf(r->file, "set logscale x\nset xrange [%.9g:%.9g]\n", r->begin, r->end);
    put_ticks(r, r->floor);
    put_limit(r, r->end);
    if (s->kind == SALTUS_SPECTRUM_LINES && s->between > 0 && isfinite(s->between))
        fprintf(r->file,
                "set arrow from graph 0, first %.6g to graph 1, first %.6g nohead front dt (6,5) lc rgb "
                "'#505050' lw 1.2\n",
                decibels(s->between, 20), decibels(s->between, 20));
    if (s->kind == SALTUS_SPECTRUM_LINES)
        plot_lines(r, "whole", r->floor, 24.0 / s->periods, "0.4");
    else
        plot_density(r, "whole");
    close_panel(r->file);
}

/* Caption */

static void add_findings(const saltus_spectra_source *source, saltus_line *line) {
    char name[16];
    for (int k = 0; k < source->spectra->count; k++) {
        const saltus_spectrum *s = &source->spectra->spectra[k];
        saltus_quantity_name(source->spectra->quantities[k], name);
        saltus_line_add(line, "%s%s: ", line->length ? ";  " : "", name);
        if (s->kind == SALTUS_SPECTRUM_CONSTANT) {
            saltus_line_number(line, "%.6g", s->mean);
            saltus_line_add(line, " throughout");
        } else
            saltus_line_add(line, "total power %.4g, broadband fraction %.2g", s->variance, s->broadband);
    }
}

/* The height of the caption's lower edge. */
static double put_caption(const saltus_spectra_source *source, FILE *file) {
    char verdict[64], method[256];
    saltus_line head = {.length = 0}, title = {.length = 0}, parameters = {.length = 0},
                analysed = {.length = 0}, findings = {.length = 0};
    double height = 0.932;
    saltus_motion_summary(source->motion, verdict);
    saltus_spectra_method(source->spectra, method, sizeof method);
    saltus_line_plain(&head, source->scene->name);
    saltus_line_add(&head, ":  spectrum,  ");
    saltus_line_plain(&head, verdict);
    saltus_line_plain(&title, source->scene->title);
    saltus_line_parameters(&parameters, source->system, (const char *const[2]){NULL, NULL});
    saltus_line_plain(&analysed, method);
    add_findings(source, &findings);
    fprintf(file, "set label '{/=20:Bold %s}' at screen 0.03,0.967 left front\n", head.text);
    saltus_line_put(file, &title, "#606060", &height);
    saltus_line_put(file, &parameters, "#202020", &height);
    saltus_line_put(file, &analysed, "#202020", &height);
    saltus_line_put(file, &findings, "#202020", &height);
    saltus_put_version(file);
    return height;
}

/* Two quantities take a row of the page each; one takes both, the low frequencies above. */
static void put_row(const row *r, int rows, double top) {
    static const double left[2] = {0.078, 0.478}, right[2] = {0.573, 0.973}, whole[2] = {0.078, 0.973};
    const double gap = 0.128, bottom = 0.078, height = (top - 0.05 - bottom - gap) / 2;
    const double lower[2] = {bottom, bottom + height},
                 upper[2] = {bottom + height + gap, bottom + 2 * height + gap};
    const double *place = r->number == 1 ? upper : lower;
    if (rows == 1) {
        put_low(r, whole, upper, 0);
        put_whole(r, whole, lower, 1);
    } else {
        put_low(r, left, place, 2 * (r->number - 1));
        put_whole(r, right, place, 2 * (r->number - 1) + 1);
    }
}

static void put_script(const saltus_spectra_source *source, const char *path, FILE *file) {
    row rows[SALTUS_QUANTITIES_MAX];
    int count = 0;
    for (int k = 0; k < source->spectra->count; k++)
        if (source->spectra->spectra[k].kind != SALTUS_SPECTRUM_CONSTANT) {
            rows[count] = make_row(source, k, count + 1, file);
            count++;
        }
    fprintf(file, "# Saltus " SALTUS_VERSION ": spectra of a motion\nset terminal %s\n",
            saltus_gnuplot_terminal(path));
    for (int k = 0; k < count; k++) {
        put_low_data(&rows[k]);
        put_whole_data(&rows[k]);
    }
    saltus_put_style(file, "e4e4e4");
    fputs("set style fill solid 1 noborder\nset multiplot\n", file);
    double top = put_caption(source, file);
    for (int k = 0; k < count; k++)
        put_row(&rows[k], count, top);
    if (count == 0)
        fputs("unset border\nunset tics\nset xrange [0:1]\nset yrange [0:1]\n"
              "set label 'nothing moves: there is no spectrum' at screen 0.5,0.5 center front tc rgb "
              "'#202020'\nplot NaN\n",
              file);
    fputs("unset multiplot\n", file);
}

void saltus_spectrum_low_data(const saltus_spectra_source *source, FILE *file) {
    row r = make_row(source, 0, 1, file);
    put_low_data(&r);
}

void saltus_spectrum_low_panel(const saltus_spectra_source *source, FILE *file, const double across[2],
                               const double up[2], int letter, const saltus_line *heading) {
    row r = make_row(source, 0, 1, file);
    draw_low(&r, across, up, letter, heading);
}

saltus_status saltus_spectra_write(const saltus_scene *scene, const saltus_system *system,
                                   const saltus_motion *motion, const saltus_spectra *spectra,
                                   const saltus_flow_options *flow, const char *path,
                                   saltus_message *message) {
    const saltus_spectra_source source = {scene, system, motion, spectra, flow};
    saltus_output output;
    FILE *script;
    saltus_status status;
    if (saltus_path_ends(path, ".csv")) {
        status = saltus_output_open(&output, path, message);
        if (status != SALTUS_OK)
            return status;
        saltus_put_spectra_table(&source, output.file);
        return saltus_output_close(&output, SALTUS_OK, message);
    }
    if (!saltus_gnuplot_terminal(path))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .png, .pdf, .svg or .csv",
                           path);
    status = saltus_gnuplot_open(&script, message);
    if (status != SALTUS_OK)
        return status;
    put_script(&source, path, script);
    return saltus_gnuplot_draw(script, path, message);
}
