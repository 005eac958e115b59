/* The figure of spectra: for each quantity the low frequencies and, on a logarithmic axis, all frequencies.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sheet.h"

#include "record/describe.h"
#include "record/output.h"

#include <math.h>
#include <string.h>

enum { cells_per_octave = 96 };

/* Lowest decibels shown: of the low frequencies, of all frequencies, and the limit of the latter. */
static const double shallow = -100, deep = -200, least = -340;

/* One quantity's spectrum on the page. */
typedef struct row {
    const saltus_spectra_source *source;
    const saltus_spectrum *s;
    saltus_quantity quantity;
    const saltus_page *page;
    int number;        /* from 1 */
    double peak;       /* highest density */
    double low_end;    /* end of the axis of low frequencies */
    double low_floor;  /* lowest decibels there */
    double floor;      /* lowest decibels of the whole spectrum */
    double begin, end; /* of the logarithmic axis */
} row;

static double decibels(double ratio, double factor) {
    return ratio > 0 ? fmax(least, factor * log10(ratio)) : least;
}

/* Frequency and height of a line, and whether it is a multiple of the forcing frequency. */
static void put_line(const row *r, const saltus_spectral_line *line) {
    bool forced = r->s->periods > 1 && line->harmonic % r->s->periods == 0;
    fprintf(r->page->file, "%.9g %.6g %d\n", line->frequency, fmax(line->decibels, least), forced);
}

static void put_bin(const row *r, double frequency, double density) {
    const saltus_spectrum *s = r->s;
    fprintf(r->page->file, "%.9g %.6g %.6g %.6g\n", frequency, decibels(density / r->peak, 10),
            decibels(s->low * density / r->peak, 10), decibels(s->high * density / r->peak, 10));
}

static row make_row(const saltus_spectra_source *source, int k, int number, const saltus_page *page) {
    const saltus_spectrum *s = &source->spectra->spectra[k];
    const bool lines = s->kind == SALTUS_SPECTRUM_LINES, density = s->kind == SALTUS_SPECTRUM_WELCH;
    row r = {.source = source,
             .s = s,
             .quantity = source->spectra->quantities[k],
             .page = page,
             .number = number,
             .begin = lines ? 0.8 / s->periods : s->resolution,
             .end = s->per_period / 2.0};
    for (long long b = 0; b < s->bins; b++)
        r.peak = fmax(r.peak, s->density[b]);
    const double between = s->between > 0 && isfinite(s->between) ? decibels(s->between, 20) : least;
    double last = 4, lowest = lines && between > deep ? between : 0;
    for (long long l = 0; l < s->line_count; l++) {
        if (s->lines[l].decibels > -60)
            last = fmax(last, s->lines[l].frequency);
        if (lines && s->lines[l].frequency <= s->trustworthy && s->lines[l].decibels > deep)
            lowest = fmin(lowest, s->lines[l].decibels);
    }
    for (long long b = 1; b < s->bins && density; b++) {
        if (s->density[b] > 1e-6 * r.peak)
            last = fmax(last, (double)b * s->resolution);
        lowest = fmin(lowest, decibels(s->low * s->density[b] / r.peak, 10));
    }
    /* The low frequencies end where no line is within 60 dB of the highest, between 4 and 16 omega; floors
     * are below the lowest value drawn, but not below the resolution of double precision. */
    r.low_end = fmin(fmin(16, r.end), ceil(last + 0.25));
    r.floor = fmax(deep, 20 * floor((lowest - 10) / 20));
    lowest = -20;
    for (long long l = 0; l < s->line_count && lines && s->lines[l].frequency <= r.low_end; l++)
        if (s->lines[l].decibels > shallow)
            lowest = fmin(lowest, s->lines[l].decibels);
    for (long long b = 1; b < s->bins && density && (double)b * s->resolution <= r.low_end; b++)
        lowest = fmin(lowest, decibels(s->low * s->density[b] / r.peak, 10));
    r.low_floor = fmax(shallow, 20 * floor((lowest - 10) / 20));
    return r;
}

static void put_low_data(const row *r) {
    const saltus_spectrum *s = r->s;
    fprintf(r->page->file, "$low%d << EOD\n", r->number);
    if (s->kind == SALTUS_SPECTRUM_LINES)
        for (long long k = 0; k < s->line_count && s->lines[k].frequency <= r->low_end; k++)
            put_line(r, &s->lines[k]);
    else
        for (long long k = 0; k < s->bins && (double)k * s->resolution <= r->low_end; k++)
            put_bin(r, (double)k * s->resolution, s->density[k]);
    fputs("EOD\n", r->page->file);
}

/* The cell of the logarithmic axis that contains a frequency; the page resolves one mark per cell. */
static double cell_of(double frequency) {
    return floor(cells_per_octave * log2(frequency));
}

/* The highest line or the mean density of each cell. */
static void put_whole_data(const row *r) {
    const saltus_spectrum *s = r->s;
    fprintf(r->page->file, "$whole%d << EOD\n", r->number);
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
    fputs("EOD\n", r->page->file);
}

static void open_panel(const row *r, saltus_frame frame, int letter, const saltus_line *heading,
                       saltus_range across, bool logarithmic, double floor) {
    double step = floor < -240 ? 60 : floor < -120 ? 40 : floor < -60 ? 20 : 10;
    saltus_page_panel(r->page, frame, letter, heading->text);
    saltus_page_axis(r->page, "x", frame, logarithmic, "frequency / {/:Italic ω}", across);
    saltus_page_axis(r->page, "y", frame, false,
                     r->s->kind == SALTUS_SPECTRUM_LINES ? "amplitude, dB of the highest"
                                                         : "power density, dB of its peak",
                     (saltus_range){floor, -0.04 * floor});
    fprintf(r->page->file, "set ytics %g\n", step);
}

/* Draw the template: a datablock, its axis up to `end` and down to `floor`, with stems up to a frequency and
 * dots of a given size. */
static void plot(const row *r, const char *block, double end, double floor, double stems, double dot) {
    char name[32], edge[64];
    snprintf(name, sizeof name, "$%s%d", block, r->number);
    snprintf(edge, sizeof edge, "%.3g {/:Italic ω}", r->s->trustworthy);
    const struct {
        const char *name;
        double value;
    } numbers[] = {{"Edge", fmin(r->s->trustworthy, 1e9)},
                   {"Grey", fmin(fmax(r->s->trustworthy, r->begin), 1e9)},
                   {"Begin", r->begin},
                   {"End", end},
                   {"Floor", floor},
                   {"Stems", stems},
                   {"Dot", dot}};
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
        saltus_page_number(r->page, numbers[k].name, numbers[k].value);
    saltus_page_text(r->page, "EdgeName", edge);
    /* Write it beside the edge, on the side with more room. */
    const double beside = strcmp(block, "low") == 0 ? 1 - r->s->trustworthy / end
                                                    : log(end / r->s->trustworthy) / log(end / r->begin);
    saltus_page_text(r->page, "EdgeSide", beside < 0.25 ? "right offset -0.5,0" : "left offset 0.5,0");
    saltus_page_template(r->page, "spectrum");
    if (r->s->kind == SALTUS_SPECTRUM_LINES)
        fprintf(r->page->file, "plot %s @Stems0, %s @Dots0, %s @Stems1, %s @Dots1\n", name, name, name, name);
    else
        fprintf(r->page->file, "plot %s @Band, %s @Curve\n", name, name);
    saltus_page_template(r->page, "close");
}

/* Whether a line above a continuum holds a visible part of the power. */
static bool is_strong(const saltus_spectrum *s, const saltus_spectral_line *line) {
    return line->decibels > -60 && 0.5 * line->amplitude * line->amplitude > 1e-3 * s->variance;
}

bool saltus_spectrum_has_strong_lines(const saltus_spectrum *s) {
    bool any = false;
    for (long long k = 0; k < s->line_count; k++)
        any = any || is_strong(s, &s->lines[k]);
    return any;
}

static void draw_low(const row *r, saltus_frame frame, int letter, const saltus_line *heading) {
    const saltus_spectrum *s = r->s;
    const saltus_range across = {0, r->low_end};
    double floor = r->low_floor, width = frame.right - frame.left, near = 0.015 * r->low_end;
    open_panel(r, frame, letter, heading, across, false, floor);
    fprintf(r->page->file, "set xtics %g\nset mxtics 2\n",
            width < 200        ? fmax(1, saltus_page_tic_step(across, 5))
            : r->low_end <= 10 ? 1.0
                               : 2.0);
    /* Small marks at the upper edge for strong lines above a continuum, except where they would touch the
     * mark of a stronger line. */
    for (long long k = 0; k < s->line_count && s->kind == SALTUS_SPECTRUM_WELCH; k++) {
        const saltus_spectral_line *line = &s->lines[k];
        bool marked = line->frequency < r->low_end && is_strong(s, line);
        for (long long other = 0; other < s->line_count && marked; other++)
            marked = !(fabs(s->lines[other].frequency - line->frequency) < near &&
                       s->lines[other].amplitude > line->amplitude);
        if (marked)
            fprintf(r->page->file,
                    "set label '▾' at %.9g, graph 1 center offset 0,0.35 front tc rgb '#c44e2a' font ',11'\n",
                    line->frequency);
    }
    plot(r, "low", r->low_end, floor, r->end, 0.7);
}

/* The symbol of a coordinate or its rate. */
static void add_coordinate(saltus_line *line, const saltus_system *system, saltus_quantity quantity) {
    if (saltus_model_text(saltus_system_spec(system)->model))
        saltus_line_state(line, system,
                          saltus_system_state_index(system, saltus_quantity_name(system, quantity).text));
    else
        saltus_line_add(line, "{/:Italic %s}%s_{%d}", saltus_notation_of(system)->coordinate,
                        quantity.velocity ? "′" : "", quantity.coordinate);
}

static void put_low(const row *r, saltus_frame frame, int letter) {
    const saltus_spectrum *s = r->s;
    const saltus_system *system = r->source->system;
    saltus_line heading = {.length = 0};
    if (r->quantity.coordinate < 0)
        saltus_line_plain(&heading, saltus_quantity_name(system, r->quantity).text);
    else if (r->quantity.coordinate == 0)
        saltus_line_observed(&heading, system, r->quantity.velocity);
    else {
        if (!saltus_model_text(saltus_system_spec(system)->model))
            saltus_line_add(&heading, "%s %d, ", saltus_notation_of(system)->part, r->quantity.coordinate);
        add_coordinate(&heading, system, r->quantity);
    }
    if (s->kind == SALTUS_SPECTRUM_LINES && s->periods > 1)
        saltus_line_add(&heading, ":  lines at multiples of {/:Italic ω}/%d; red squares: of {/:Italic ω}",
                        s->periods);
    else if (s->kind == SALTUS_SPECTRUM_LINES)
        saltus_line_add(&heading, ":  lines at multiples of {/:Italic ω}");
    else
        saltus_line_add(&heading, ":  density; pale: %g %% confidence%s", 100 * s->confidence,
                        saltus_spectrum_has_strong_lines(s) ? "; ▾ strong lines" : "");
    draw_low(r, frame, letter, &heading);
}

static void put_whole(const row *r, saltus_frame frame, int letter) {
    const saltus_spectrum *s = r->s;
    saltus_line heading = {.length = 0};
    double between = s->kind == SALTUS_SPECTRUM_LINES && s->between > 0 && isfinite(s->between)
                         ? decibels(s->between, 20)
                         : -INFINITY;
    bool dashed = between > r->floor;
    saltus_line_add(&heading, "%s", s->kind == SALTUS_SPECTRUM_LINES ? "all lines" : "the whole density");
    if (s->orbits > 1 && dashed)
        saltus_line_add(&heading, "; dashed: largest between them");
    else if (s->orbits > 1 && isfinite(between))
        saltus_line_add(&heading, "; between them below −%.0f dB", floor(-between));
    if (s->trustworthy < r->end)
        saltus_line_add(&heading, "; grey: not trustworthy");
    open_panel(r, frame, letter, &heading, (saltus_range){r->begin, r->end}, true, r->floor);
    if (dashed)
        fprintf(r->page->file,
                "set arrow from graph 0, first %.6g to graph 1, first %.6g nohead front dt (6,5) lc rgb "
                "'#505050' lw 1.2\n",
                between, between);
    plot(r, "whole", r->end, r->floor, 24.0 / (s->periods > 0 ? s->periods : 1), 0.4);
}

static void put_caption(const saltus_spectra_source *source, saltus_page *page) {
    char verdict[64], method[256];
    saltus_line *head = saltus_page_scene(page, source->scene->title, source->system),
                *analysed = saltus_page_words(page, "#202020"),
                *findings = saltus_page_words(page, "#202020");
    saltus_motion_summary(source->motion, verdict);
    saltus_spectra_method(source->spectra, method, sizeof method);
    saltus_line_plain(head, source->scene->name);
    saltus_line_add(head, ":  spectrum,  ");
    saltus_line_plain(head, verdict);
    saltus_line_plain(analysed, method);
    for (int k = 0; k < source->spectra->count; k++) {
        const saltus_spectrum *s = &source->spectra->spectra[k];
        saltus_line_next(findings);
        const saltus_quantity quantity = source->spectra->quantities[k];
        if (quantity.coordinate <= 0)
            saltus_line_plain(findings, saltus_quantity_name(source->system, quantity).text);
        else
            add_coordinate(findings, source->system, quantity);
        saltus_line_add(findings, ": ");
        if (s->kind == SALTUS_SPECTRUM_CONSTANT) {
            saltus_line_number(findings, "%.6g", s->mean);
            saltus_line_add(findings, " throughout");
        } else {
            saltus_line_number(findings, "total power %.4g", s->variance);
            saltus_line_number(findings, ", broadband fraction %.2g", s->broadband);
        }
    }
}

static void put_script(const saltus_spectra_source *source, saltus_page *page) {
    row rows[SALTUS_QUANTITIES_MAX];
    int count = 0;
    for (int k = 0; k < source->spectra->count; k++)
        if (source->spectra->spectra[k].kind != SALTUS_SPECTRUM_CONSTANT) {
            rows[count] = make_row(source, k, count + 1, page);
            count++;
        }
    put_caption(source, page);
    const double words = saltus_page_caption_height(page);
    const bool narrow = saltus_page_narrow(page);
    if (page->free_height && count)
        page->height = narrow ? page->width * 1.3 * count : page->width * 0.7 + words;
    saltus_page_begin(page);
    for (int k = 0; k < count; k++) {
        put_low_data(&rows[k]);
        put_whole_data(&rows[k]);
    }
    fputs("set multiplot\n", page->file);
    saltus_page_caption(page);
    /* Each of two quantities has one row of the page; a single one uses both rows, the low frequencies on
     * top. On a narrow page each panel has a row. */
    const int columns = count > 1 && !narrow ? 2 : 1, cells = 2 * count;
    for (int cell = 0; cell < cells; cell++) {
        saltus_frame frame = saltus_page_cell(page, cell, 1, columns, (cells + columns - 1) / columns);
        (cell % 2 ? put_whole : put_low)(&rows[cell / 2], frame, cell);
    }
    if (count == 0) {
        saltus_page_text(page, "Reason", "nothing moves: there is no spectrum");
        fputs("unset border\n", page->file);
        saltus_page_template(page, "nothing");
    }
    fputs("unset multiplot\n", page->file);
}

void saltus_spectrum_low_data(const saltus_spectra_source *source, const saltus_page *page) {
    row r = make_row(source, 0, 1, page);
    put_low_data(&r);
}

void saltus_spectrum_low_panel(const saltus_spectra_source *source, const saltus_page *page,
                               saltus_frame frame, int letter, const saltus_line *heading) {
    row r = make_row(source, 0, 1, page);
    draw_low(&r, frame, letter, heading);
}

saltus_status saltus_write_spectra(const char *path, const saltus_scene *scene, const saltus_system *system,
                                   const saltus_flow_options *flow, const saltus_motion *motion,
                                   const saltus_spectra *spectra, const saltus_figure_options *look,
                                   saltus_message *message) {
    const saltus_spectra_source source = {scene, system, motion, spectra, flow};
    saltus_output output;
    saltus_page page;
    saltus_status status;
    if (saltus_path_ends(path, ".csv")) {
        status = saltus_output_open(&output, path, message);
        if (status != SALTUS_OK)
            return status;
        saltus_put_spectra_table(&source, output.file);
        return saltus_output_close(&output, SALTUS_OK, message);
    }
    status = saltus_page_open(&page, path, look, message);
    if (status != SALTUS_OK)
        return status;
    put_script(&source, &page);
    return saltus_page_close(&page, SALTUS_OK, message);
}
