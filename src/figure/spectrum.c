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
    const saltus_spectrum *s;
    saltus_quantity quantity;
    const saltus_page *page;
    int number;        /* from 1 */
    bool lines;        /* of a periodic motion; otherwise a density */
    double peak;       /* highest density */
    double between;    /* decibels of the largest value between the lines; -infinity: unknown */
    double low_end;    /* end of the axis of low frequencies */
    double low_floor;  /* lowest decibels there */
    double floor;      /* lowest decibels of the whole spectrum */
    double begin, end; /* of the logarithmic axis */
} row;

static double decibels(double ratio, double factor) {
    return ratio > 0 ? fmax(least, factor * log10(ratio)) : least;
}

/* The lowest decibels drawn of frequencies up to `end`, if they are below `lowest`; of lines those above a
 * limit. */
static double lowest_of(const row *r, double lowest, double limit, double end) {
    const saltus_spectrum *s = r->s;
    for (long long l = 0; l < s->line_count && r->lines; l++)
        if (s->lines[l].frequency <= end && s->lines[l].decibels > limit)
            lowest = fmin(lowest, s->lines[l].decibels);
    for (long long b = 1; b < s->bins && !r->lines && (double)b * s->resolution <= end; b++)
        lowest = fmin(lowest, decibels(s->low * s->density[b] / r->peak, 10));
    return lowest;
}

static row make_row(const saltus_page *page, const saltus_spectra *spectra, int k, int number) {
    const saltus_spectrum *s = &spectra->spectra[k];
    row r = {.s = s,
             .quantity = spectra->quantities[k],
             .page = page,
             .number = number,
             .lines = s->kind == SALTUS_SPECTRUM_LINES,
             .between = -INFINITY,
             .end = s->per_period / 2.0};
    r.begin = r.lines ? 0.8 / s->periods : s->resolution;
    if (r.lines && s->between > 0 && isfinite(s->between))
        r.between = decibels(s->between, 20);
    double last = 4;
    for (long long b = 0; b < s->bins; b++)
        r.peak = fmax(r.peak, s->density[b]);
    for (long long l = 0; l < s->line_count; l++)
        if (s->lines[l].decibels > -60)
            last = fmax(last, s->lines[l].frequency);
    for (long long b = 1; b < s->bins && !r.lines; b++)
        if (s->density[b] > 1e-6 * r.peak)
            last = fmax(last, (double)b * s->resolution);
    /* The low frequencies end where no line is within 60 dB of the highest, between 4 and 16 omega; floors
     * are below the lowest value drawn, but not below the resolution of double precision. */
    r.low_end = fmin(fmin(16, r.end), ceil(last + 0.25));
    const double lowest =
        lowest_of(&r, r.between > deep ? r.between : 0, deep, r.lines ? s->trustworthy : INFINITY);
    r.floor = fmax(deep, 20 * floor((lowest - 10) / 20));
    r.low_floor = fmax(shallow, 20 * floor((lowest_of(&r, -20, shallow, r.low_end) - 10) / 20));
    return r;
}

/* The cell of the logarithmic axis that contains a frequency; the page resolves one mark per cell. */
static double cell_of(double frequency) {
    return floor(cells_per_octave * log2(frequency));
}

/* All low frequencies, or of the `whole` spectrum the highest line or the mean density of each cell: of a
 * line frequency, height, and whether it is a multiple of the forcing frequency; of a density its band too.
 */
static void put_data(const row *r, bool whole) {
    const saltus_spectrum *s = r->s;
    const double end = whole ? INFINITY : r->low_end;
    fprintf(r->page->file, "$%s%d << EOD\n", whole ? "whole" : "low", r->number);
    for (long long k = 0; k < s->line_count && r->lines && s->lines[k].frequency <= end;) {
        const saltus_spectral_line *highest = &s->lines[k++];
        const double cell = cell_of(highest->frequency);
        for (; k < s->line_count && whole && cell_of(s->lines[k].frequency) == cell; k++)
            if (s->lines[k].amplitude > highest->amplitude)
                highest = &s->lines[k];
        fprintf(r->page->file, "%.9g %.6g %d\n", highest->frequency, fmax(highest->decibels, least),
                s->periods > 1 && highest->harmonic % s->periods == 0);
    }
    for (long long k = whole; k < s->bins && !r->lines && (double)k * s->resolution <= end;) {
        const long long first = k;
        const double cell = cell_of((double)k * s->resolution);
        double sum = s->density[k++];
        for (; k < s->bins && whole && cell_of((double)k * s->resolution) == cell; k++)
            sum += s->density[k];
        const double density = sum / (double)(k - first);
        fprintf(r->page->file, "%.9g %.6g %.6g %.6g\n", 0.5 * s->resolution * (double)(first + k - 1),
                decibels(density / r->peak, 10), decibels(s->low * density / r->peak, 10),
                decibels(s->high * density / r->peak, 10));
    }
    fputs("EOD\n", r->page->file);
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

/* Small marks at the upper edge for strong lines above a continuum, except where they would touch the mark of
 * a stronger line. */
static void put_strong_lines(const row *r) {
    const saltus_spectrum *s = r->s;
    const double near = 0.015 * r->low_end;
    for (long long k = 0; k < s->line_count && !r->lines; k++) {
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
}

/* The panel of low frequencies or of the whole spectrum: a datablock drawn by the template. */
static void draw(const row *r, bool whole, saltus_frame frame, int letter, const saltus_line *heading) {
    const saltus_spectrum *s = r->s;
    const saltus_page *page = r->page;
    const double floor = whole ? r->floor : r->low_floor, end = whole ? r->end : r->low_end;
    const saltus_range across = {whole ? r->begin : 0, end};
    saltus_page_panel(page, frame, letter, "%s", heading->text);
    saltus_page_axis(page, "x", frame, whole, "frequency / {/:Italic ω}", across);
    saltus_page_axis(page, "y", frame, false,
                     r->lines ? "amplitude, dB of the highest" : "power density, dB of its peak",
                     (saltus_range){floor, -0.04 * floor});
    fprintf(page->file, "set ytics %d\n", floor < -240 ? 60 : floor < -120 ? 40 : floor < -60 ? 20 : 10);
    if (!whole) {
        fprintf(page->file, "set xtics %g\nset mxtics 2\n",
                frame.right - frame.left < 200 ? fmax(1, saltus_page_tic_step(across, 5))
                : end <= 10                    ? 1.0
                                               : 2.0);
        put_strong_lines(r);
    } else if (r->between > floor)
        fprintf(page->file,
                "set arrow from graph 0, first %.6g to graph 1, first %.6g nohead front dt (6,5) lc rgb "
                "'#505050' lw 1.2\n",
                r->between, r->between);
    saltus_page_number(page, "Edge", fmin(s->trustworthy, 1e9));
    saltus_page_number(page, "Grey", fmin(fmax(s->trustworthy, r->begin), 1e9));
    saltus_page_number(page, "Begin", r->begin);
    saltus_page_number(page, "End", end);
    saltus_page_number(page, "Floor", floor);
    saltus_page_number(page, "Stems", whole ? 24.0 / (s->periods > 0 ? s->periods : 1) : r->end);
    saltus_page_number(page, "Dot", whole ? 0.4 : 0.7);
    /* The name of the edge stands beside it, on the side with more room. */
    const double beside = whole ? log(end / s->trustworthy) / log(end / r->begin) : 1 - s->trustworthy / end;
    char name[32];
    snprintf(name, sizeof name, "$%s%d", whole ? "whole" : "low", r->number);
    saltus_page_text(page, "EdgeName", "%.3g {/:Italic ω}", s->trustworthy);
    saltus_page_text(page, "EdgeSide", "%s offset %s0.5,0", beside < 0.25 ? "right" : "left",
                     beside < 0.25 ? "-" : "");
    saltus_page_template(page, "spectrum");
    if (r->lines)
        fprintf(page->file, "plot %s @Stems0, %s @Dots0, %s @Stems1, %s @Dots1\n", name, name, name, name);
    else
        fprintf(page->file, "plot %s @Band, %s @Curve\n", name, name);
    saltus_page_template(page, "close");
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

/* The heading of the panel of low frequencies, or of the whole spectrum. */
static void add_heading(saltus_line *heading, const row *r, const saltus_system *system, bool whole) {
    const saltus_spectrum *s = r->s;
    if (whole) {
        saltus_line_add(heading, "%s", r->lines ? "all lines" : "the whole density");
        if (s->orbits > 1 && r->between > r->floor)
            saltus_line_add(heading, "; dashed: largest between them");
        else if (s->orbits > 1 && isfinite(r->between))
            saltus_line_add(heading, "; between them below −%.0f dB", floor(-r->between));
        saltus_line_add(heading, "%s", s->trustworthy < r->end ? "; grey: not trustworthy" : "");
        return;
    }
    if (r->quantity.coordinate < 0)
        saltus_line_plain(heading, saltus_quantity_name(system, r->quantity).text);
    else if (r->quantity.coordinate == 0)
        saltus_line_observed(heading, system, r->quantity.velocity);
    else {
        if (!saltus_model_text(saltus_system_spec(system)->model))
            saltus_line_add(heading, "%s %d, ", saltus_notation_of(system)->part, r->quantity.coordinate);
        add_coordinate(heading, system, r->quantity);
    }
    if (r->lines && s->periods > 1)
        saltus_line_add(heading, ":  lines at multiples of {/:Italic ω}/%d; squares: of {/:Italic ω}",
                        s->periods);
    else if (r->lines)
        saltus_line_add(heading, ":  lines at multiples of {/:Italic ω}");
    else
        saltus_line_add(heading, ":  density; pale: %g %% confidence%s", 100 * s->confidence,
                        saltus_spectrum_has_strong_lines(s) ? "; ▾ strong lines" : "");
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
            rows[count] = make_row(page, source->spectra, k, count + 1);
            count++;
        }
    put_caption(source, page);
    const double words = saltus_page_caption_height(page);
    const bool narrow = saltus_page_narrow(page);
    if (page->free_height && count)
        page->height = narrow ? page->width * 1.3 * count : page->width * 0.7 + words;
    saltus_page_begin(page);
    for (int k = 0; k < count; k++) {
        put_data(&rows[k], false);
        put_data(&rows[k], true);
    }
    fputs("set multiplot\n", page->file);
    saltus_page_caption(page);
    /* Each of two quantities has one row of the page; a single one uses both rows, the low frequencies on
     * top. On a narrow page each panel has a row. */
    const int columns = count > 1 && !narrow ? 2 : 1, cells = 2 * count;
    for (int cell = 0; cell < cells; cell++) {
        saltus_frame frame = saltus_page_cell(page, cell, 1, columns, (cells + columns - 1) / columns);
        const row *r = &rows[cell / 2];
        saltus_line heading = {.length = 0};
        add_heading(&heading, r, source->system, cell % 2);
        draw(r, cell % 2, frame, cell, &heading);
    }
    if (count == 0) {
        saltus_page_text(page, "Reason", "nothing moves: there is no spectrum");
        fputs("unset border\n", page->file);
        saltus_page_template(page, "nothing");
    }
    fputs("unset multiplot\n", page->file);
}

void saltus_spectrum_low_data(const saltus_page *page, const saltus_spectra *spectra) {
    row r = make_row(page, spectra, 0, 1);
    put_data(&r, false);
}

void saltus_spectrum_low_panel(const saltus_page *page, const saltus_spectra *spectra, saltus_frame frame,
                               int letter, const saltus_line *heading) {
    row r = make_row(page, spectra, 0, 1);
    draw(&r, false, frame, letter, heading);
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
