/* The one-page diagnosis of a motion: up to six panels drawn by gnuplot from a script that holds its own
 * data.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sheet.h"

#include "figure/caption.h"
#include "figure/convergence.h"
#include "figure/gnuplot.h"
#include "figure/spectrum.h"
#include "record/describe.h"
#include "record/output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TRACE "#2c5f8a"
#define THIN "#a02c5f8a" /* TRACE, mostly transparent */
#define STRIKE "#c44e2a"
#define STROBE "#1c1c1c"
#define STOP "#e2e2e2"
#define EDGE "#808080"
#define HOLD "#e0a010"

/* Where a panel is, in parts of the page's width and height. */
typedef struct place {
    double across[2], up[2];
    char letter;
} place;

typedef void panel(const saltus_sheet *sheet, const place *at);

enum { panels_most = 6 };

static void put_style(FILE *file) {
    saltus_put_style(file, "eeeeee");
    fputs("set style fill solid 1 noborder\n"
          "set palette defined (0 '#3b2a6b', 0.25 '#33628d', 0.5 '#21908d', 0.75 '#5cb85c', 1 '#d4b020')\n"
          "unset colorbox\n",
          file);
}

/* Begin a panel: its place and heading. */
static void open_panel(FILE *file, const place *at, const char *heading) {
    saltus_put_margins(file, at->across, at->up);
    fprintf(
        file,
        "set label 99 '{/:Bold (%c)}  %s' at screen %g, screen %g offset 0,1.1 left front tc rgb '#202020'\n",
        at->letter, heading, at->across[0], at->up[1]);
}

/* A round distance of tics whose numbers have room beside each other. */
static double tic_step(saltus_range range, double tics) {
    static const double round[] = {1, 2, 5, 10};
    double least = (range.high - range.low) / tics;
    double power = pow(10, floor(log10(least)));
    int k = 0;
    while (k < 3 && round[k] * power < least)
        k++;
    return round[k] * power;
}

static void put_axes(FILE *file, const place *at, const char *x, saltus_range across, const char *y,
                     saltus_range up) {
    fprintf(file, "set xlabel '%s'\nset xrange [%.9g:%.9g]\nset xtics %.9g\n", x, across.low, across.high,
            tic_step(across, 16 * (at->across[1] - at->across[0]) + 1.5));
    fprintf(file, "set ylabel '%s' offset -0.4,0\nset yrange [%.9g:%.9g]\n", y, up.low, up.high);
}

static void close_panel(FILE *file) {
    fputs("unset label\nunset object\nunset arrow\nunset logscale\nset format '% h'\nset xtics auto\nset "
          "ytics auto\n",
          file);
}

/* The stops of the observed coordinate that lie in its range: grey beyond the clearance, a line at it.
 * `vertical`: the displacement is drawn across the page. */
static void put_stops(const saltus_sheet *sheet, bool vertical) {
    saltus_range range = sheet->displacement;
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        double d = face.side * face.d, end = face.side > 0 ? range.high : range.low;
        if (!saltus_stop_observed(sheet->system, face.stop) || !(d > range.low && d < range.high))
            continue;
        if (vertical)
            fprintf(sheet->file,
                    "set object rectangle from %.9g, graph 0 to %.9g, graph 1 back fc rgb '" STOP
                    "' fs solid noborder\n"
                    "set arrow from %.9g, graph 0 to %.9g, graph 1 nohead back lc rgb '" EDGE "' lw 1.5\n",
                    d, end, d, d);
        else
            fprintf(sheet->file,
                    "set object rectangle from graph 0, first %.9g to graph 1, first %.9g back fc rgb '" STOP
                    "' fs solid noborder\nset arrow from graph 0, first %.9g to graph 1, first %.9g nohead "
                    "back lc rgb '" EDGE "' lw 1.5\n",
                    d, end, d, d);
    }
}

/* Velocity jumps as dashes, the trajectory, and its stroboscopic points with a white rim. */
static void put_portrait(const saltus_sheet *sheet, const place *at) {
    bool settled = saltus_verdict_settled(sheet->motion->verdict);
    char x[160], y[160];
    saltus_observed_name(sheet->system, false, x, sizeof x);
    saltus_observed_name(sheet->system, true, y, sizeof y);
    open_panel(sheet->file, at, "phase portrait, dots at {/:Italic τ} = 0 (mod {/:Italic T})");
    put_axes(sheet->file, at, x, sheet->displacement, y, sheet->velocity);
    put_stops(sheet, true);
    fputs("plot ", sheet->file);
    if (saltus_sheet_impacts(sheet->record, sheet->events) > 0)
        fprintf(sheet->file, "$jumps using 1:2 with lines lc rgb '%s' lw 1.5, \\\n     ",
                sheet->orbit ? STRIKE : "#d8c44e2a");
    fprintf(sheet->file, "$orbit using 2:3 with lines lc rgb '%s' lw %s, \\\n", sheet->orbit ? TRACE : THIN,
            sheet->orbit ? "2" : "0.7");
    fprintf(sheet->file,
            "     $strobe using 1:2 with points pt 7 ps %s lc rgb '#ffffff', \\\n"
            "     $strobe using 1:2 with points pt 7 ps %s lc rgb '" STROBE "'\n",
            settled ? "1.5" : "0.6", settled ? "1.0" : "0.5");
    close_panel(sheet->file);
}

static void put_history(const saltus_sheet *sheet, const place *at) {
    const saltus_trajectory *r = sheet->record;
    saltus_range time = {r->time[0], r->time[sheet->history_rows - 1]};
    char name[160];
    saltus_observed_name(sheet->system, false, name, sizeof name);
    open_panel(sheet->file, at, saltus_sheet_history_heading(sheet));
    put_axes(sheet->file, at, "time {/:Italic τ}/{/:Italic T}", time, name, sheet->displacement);
    put_stops(sheet, false);
    fprintf(sheet->file, "plot $history using 1:2 with lines lc rgb '" TRACE "' lw %s",
            sheet->orbit ? "2" : "1.3");
    if (saltus_sheet_impacts(sheet->record, sheet->history_events) > 0)
        fputs(", \\\n     $impacts using 1:2 with points pt 7 ps 0.75 lc rgb '" STRIKE "'", sheet->file);
    if (sheet->contacts)
        fputs(", \\\n     $contacts using 1:2 with lines lc rgb '" HOLD "' lw 8", sheet->file);
    fputc('\n', sheet->file);
    close_panel(sheet->file);
}

/* The section points of a long record, in their own range. */
static void put_section(const saltus_sheet *sheet, const place *at) {
    const double *scale = saltus_system_scale(sheet->system);
    long long count = sheet->section->strobes;
    saltus_range x = {INFINITY, -INFINITY}, v = x;
    char heading[96], across[160], up[160];
    for (long long k = 0; k < count; k++) {
        double point[2];
        saltus_sheet_strobe(sheet, sheet->section, k, point);
        saltus_range_add(&x, point[0]);
        saltus_range_add(&v, point[1]);
    }
    saltus_range_pad(&x, 0.06, scale[0]);
    saltus_range_pad(&v, 0.06, scale[saltus_system_dof(sheet->system)]);
    snprintf(heading, sizeof heading, "stroboscopic section, %lld points", count);
    saltus_observed_name(sheet->system, false, across, sizeof across);
    saltus_observed_name(sheet->system, true, up, sizeof up);
    open_panel(sheet->file, at, heading);
    put_axes(sheet->file, at, across, x, up, v);
    fputs("plot $section using 1:2 with points pt 7 ps 0.25 lc rgb '" STROBE "'\n", sheet->file);
    close_panel(sheet->file);
}

/* Marks of the impact map: colour by stop, triangle by side. */
static void put_impact_marks(const saltus_sheet *sheet, bool logarithmic) {
    static const char *const colour[SALTUS_STOPS_MAX] = {STRIKE, TRACE, "#2f8f6f", "#8a5aa0"};
    const char *separator = "plot ", *value = logarithmic ? "abs($2)" : "$2";
    const char *size = sheet->mapped > 400 ? "0.5" : sheet->mapped > 60 ? "0.8" : "1.3";
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        fprintf(sheet->file,
                "%s$impact_map using ($3 == %d && $4 == %d ? $1 : NaN):(%s) with points pt %d ps %s lc rgb "
                "'%s%s' title "
                "'stop %d, %s side'",
                separator, face.side, face.stop + 1, value, face.side > 0 ? 9 : 11, size,
                sheet->mapped > 400 ? "#60" : "#", colour[face.stop] + 1, face.stop + 1,
                saltus_side_word(face.side));
        separator = ", \\\n     ";
    }
    fputc('\n', sheet->file);
}

/* Chatter spans decades of speed, which a logarithmic axis shows. */
static void put_impact_map(const saltus_sheet *sheet, const place *at) {
    const saltus_trajectory *r = sheet->section;
    char heading[96];
    saltus_range size = {INFINITY, 0}, signed_range = {0, 0}, phase = {0, 1};
    for (long long k = 0; k < sheet->mapped; k++) {
        double velocity = r->events[k].velocity_before;
        if (r->events[k].kind == SALTUS_RELEASE || velocity == 0)
            continue;
        saltus_range_add(&size, fabs(velocity));
        saltus_range_add(&signed_range, velocity);
    }
    bool logarithmic = size.high > 1e3 * size.low;
    saltus_range_pad(&signed_range, 0.08, 1);
    saltus_sheet_impacts_heading(sheet, heading, sizeof heading);
    open_panel(sheet->file, at, heading);
    if (logarithmic) {
        size = (saltus_range){size.low / 3, size.high * 3};
        fputs("set logscale y\nset format y '10^{%T}'\n", sheet->file);
    }
    put_axes(sheet->file, at, "phase {/:Italic τ}/{/:Italic T} (mod 1)", phase,
             logarithmic ? "impact speed |{/:Bold n·q′}|" : "velocity before impact, {/:Bold n·q′}",
             logarithmic ? size : signed_range);
    if (saltus_system_face_count(sheet->system) > 1)
        fputs("set key at graph 1, graph 1.03 right bottom horizontal samplen 0.5 width -2 font ',11' "
              "textcolor rgb '#303030'\n",
              sheet->file);
    put_impact_marks(sheet, logarithmic);
    fputs("set key off\n", sheet->file);
    close_panel(sheet->file);
}

/* Multipliers and the unit circle, with equal scales on both axes. */
static void put_multipliers(const saltus_sheet *sheet, const place *at) {
    enum { page_width = 1600, page_height = 1200 };
    double aspect = (at->across[1] - at->across[0]) * page_width / ((at->up[1] - at->up[0]) * page_height);
    double reach = 1.15 * fmax(1, 1 / aspect);
    for (int k = 0; k < sheet->motion->multiplier_count; k++)
        reach = fmax(reach, 1.15 * fmax(fabs(sheet->motion->multipliers[k].re) / aspect,
                                        fabs(sheet->motion->multipliers[k].im)));
    saltus_range imaginary = {-reach, reach}, real = {-reach * aspect, reach * aspect};
    open_panel(sheet->file, at, "Floquet multipliers and the unit circle");
    put_axes(sheet->file, at, "real part", real, "imaginary part", imaginary);
    fputs("set object circle at 0,0 size first 1 back fillstyle empty border lc rgb '" EDGE "' lw 1.5\n"
          "plot $multipliers using 1:2 with points pt 7 ps 1.3 lc rgb '" TRACE "'\n",
          sheet->file);
    close_panel(sheet->file);
}

/* A stop as a block with its tip at (xi, d). */
static void put_block(FILE *file, double xi, double d, int side, saltus_range range, int number) {
    double height = 0.09 * (range.high - range.low) * side, width = 0.025;
    if (!(d > range.low && d < range.high))
        return;
    fprintf(file,
            "set object %d polygon from %.6g,%.6g to %.6g,%.6g to %.6g,%.6g to %.6g,%.6g front fc rgb '" EDGE
            "' fs solid 1 border lc rgb '#505050'\n",
            number, xi, d, xi + width, d + height, xi - width, d + height, xi, d);
}

/* Stops in the picture of the shapes, where they are near enough to be seen with the pipe. */
static saltus_range shape_range(const saltus_sheet *sheet) {
    saltus_range range = saltus_sheet_shape_range(sheet);
    double width = range.high - range.low;
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        double d = face.side * face.d;
        if (d > range.low - width && d < range.high + width)
            saltus_range_add(&range, d + face.side * 0.12 * width);
    }
    saltus_range_pad(&range, 0.05, saltus_system_scale(sheet->system)[0]);
    return range;
}

static void put_shapes(const saltus_sheet *sheet, const place *at) {
    const place beside = {{at->across[0], at->across[1] - 0.05}, {at->up[0], at->up[1]}, at->letter};
    saltus_range range = shape_range(sheet), unit = {0, 1}, time = {0, saltus_sheet_shape_time(sheet)};
    const saltus_notation *n = saltus_notation_of(sheet->system);
    char heading[96], displacement[64];
    snprintf(heading, sizeof heading, "shapes of the %.40s; grey: all swept",
             saltus_model_name(saltus_system_spec(sheet->system)->model));
    snprintf(displacement, sizeof displacement, "displacement {/:Italic %s}", n->displacement);
    open_panel(sheet->file, &beside, heading);
    put_axes(sheet->file, &beside, "position {/:Italic ξ}", unit, displacement, range);
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        put_block(sheet->file, saltus_system_spec(sheet->system)->stops[face.stop].xi, face.side * face.d,
                  face.side, range, 10 + f);
    }
    fprintf(sheet->file,
            "set colorbox user origin screen %g,%g size 0.010,%g noborder\n"
            "set label '{/:Italic %s}/{/:Italic T}' at screen %g, graph 0 offset 0,-1.05 tc rgb '#303030'\n",
            beside.across[1] + 0.012, at->up[0], at->up[1] - at->up[0], n->time, beside.across[1] + 0.012);
    fprintf(sheet->file, "set cbrange [0:%g]\nset cbtics %g scale 0.4 offset -0.6,0\n", time.high,
            tic_step(time, 5));
    fputs("plot $envelope using 1:2:3 with filledcurves fc rgb '#f0f0f0', \\\n"
          "     $shapes using 1:2:3 with lines palette lw 1.6\nunset colorbox\n",
          sheet->file);
    close_panel(sheet->file);
}

static void put_masses(const saltus_sheet *sheet, const place *at) {
    const saltus_trajectory *r = sheet->record;
    const saltus_spec *spec = saltus_system_spec(sheet->system);
    saltus_range x1 = {INFINITY, -INFINITY}, x2 = {INFINITY, -INFINITY};
    for (long long row = 0; row < sheet->rows; row++) {
        saltus_range_add(&x1, r->states[row * r->dimension]);
        saltus_range_add(&x2, r->states[row * r->dimension + 1]);
    }
    saltus_range_pad(&x1, 0.08, saltus_system_scale(sheet->system)[0]);
    saltus_range_pad(&x2, 0.08, saltus_system_scale(sheet->system)[1]);
    open_panel(sheet->file, at, "both masses; grey: stops");
    put_axes(sheet->file, at, "displacement {/:Italic x}_1", x1, "displacement {/:Italic x}_2", x2);
    fputs("set parametric\nset trange [-1:1]\nplot ", sheet->file);
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        const double *w = spec->stops[face.stop].weight;
        double square = w[0] * w[0] + w[1] * w[1], d = face.side * face.d / square;
        double far = (fabs(d) * sqrt(square) + fabs(x1.high) + fabs(x1.low) + fabs(x2.high) + fabs(x2.low)) /
                     sqrt(square);
        fprintf(sheet->file,
                "(%.9g) + (%.9g)*t, (%.9g) + (%.9g)*t with lines lc rgb '" EDGE "' lw 1.5, \\\n     ",
                d * w[0], -w[1] * far * 2, d * w[1], w[0] * far * 2);
    }
    fprintf(sheet->file, "$masses using 1:2 with lines lc rgb '%s' lw %s\nunset parametric\n",
            sheet->orbit ? TRACE : THIN, sheet->orbit ? "2" : "1");
    close_panel(sheet->file);
}

static void put_spectrum(const saltus_sheet *sheet, const place *at) {
    const saltus_spectra_source source = {.system = sheet->system, .spectra = sheet->spectra};
    saltus_line heading = {.length = 0};
    saltus_sheet_spectrum_heading(sheet, &heading);
    saltus_spectrum_low_panel(&source, sheet->file, at->across, at->up, at->letter - 'a', &heading);
}

/* The panel is lower, to leave room for the key below the heading, and narrower where exponents are so small
 * that their numbers are long. */
static void put_convergence(const saltus_sheet *sheet, const place *at) {
    place lower = {{at->across[0], at->across[1]}, {at->up[0], at->up[1] - 0.052}, at->letter};
    double size = 0;
    for (int k = 0; k < sheet->course.count; k++)
        size = fmax(size, fabs(sheet->course.history[k].exponent) + sheet->course.history[k].standard_error);
    if (size < 1e-3)
        lower.across[0] += 0.025;
    open_panel(sheet->file, at, "convergence of the largest exponent");
    saltus_course_panel(sheet->file, sheet->system, &sheet->course, lower.across, lower.up);
    close_panel(sheet->file);
}

/* Which panels a motion gets: a panel for everything that is known of it. The structure's shapes come only
 * where that leaves room for them, which it always does for an orbit. */
static int choose_panels(const saltus_sheet *sheet, panel *chosen[panels_most]) {
    bool line = saltus_notation_of(sheet->system)->structure == SALTUS_STRUCTURE_LINE,
         settled = saltus_verdict_settled(sheet->motion->verdict);
    bool multipliers = settled && sheet->motion->multiplier_count > 0;
    int count = 0, last = (sheet->spectrum != NULL) + (sheet->course.count > 0);
    chosen[count++] = put_portrait;
    chosen[count++] = put_history;
    if (!settled)
        chosen[count++] = put_section;
    if (saltus_sheet_impacts(sheet->section, sheet->mapped) > 0)
        chosen[count++] = put_impact_map;
    if (count + last < panels_most && (line || saltus_system_dof(sheet->system) > 1))
        chosen[count++] = line ? put_shapes : put_masses;
    if (sheet->spectrum)
        chosen[count++] = put_spectrum;
    if (sheet->course.count > 0)
        chosen[count++] = put_convergence;
    if (multipliers)
        chosen[count++] = put_multipliers;
    return count;
}

/* Two rows, of three columns where there are more than four panels. With an odd number the time history takes
 * two columns. */
static void put_panels(const saltus_sheet *sheet, double top) {
    panel *chosen[panels_most];
    int count = choose_panels(sheet, chosen), columns = count > 4 ? 3 : 2, cell = 0;
    double left = columns == 3 ? 0.08 : 0.078, width = columns == 3 ? 0.239 : 0.4,
           beside = columns == 3 ? 0.088 : 0.095, below = 0.128, bottom = 0.086,
           height = count > 2 ? (top - 0.05 - bottom - below) / 2 : top - 0.05 - bottom;
    if (count == 3) {
        chosen[1] = chosen[2];
        chosen[2] = put_history;
    }
    for (int k = 0; k < count; k++) {
        int column = cell % columns, row = cell / columns;
        int span = chosen[k] == put_history && count % 2 ? 2 : 1;
        double x = left + column * (width + beside),
               y = bottom + (count > 2 ? 1 - row : 0) * (height + below);
        const place at = {{x, x + span * width + (span - 1) * beside}, {y, y + height}, (char)('a' + k)};
        chosen[k](sheet, &at);
        cell += span;
    }
}

/* The script; a standalone one names the file that it draws to. */
static void write_script(saltus_sheet *sheet, const char *path, bool standalone) {
    const char *name = saltus_path_name(path);
    fprintf(sheet->file,
            "# Saltus " SALTUS_VERSION ": diagnosis of a motion; `gnuplot THIS_FILE` draws it\n");
    fprintf(sheet->file, "set terminal %s\n", saltus_gnuplot_terminal(path));
    if (standalone) {
        fputs("set output '", sheet->file);
        for (const char *c = name; *c; c++)
            fprintf(sheet->file, *c == '\'' ? "''" : "%c", *c);
        fputs("'\n", sheet->file);
    }
    saltus_sheet_data(sheet);
    put_style(sheet->file);
    fputs("set multiplot\n", sheet->file);
    double top = saltus_sheet_caption(sheet);
    fputs("set label 'Saltus " SALTUS_VERSION
          "' at screen 0.985,0.01 right tc rgb '#909090' font ',9' front\n",
          sheet->file);
    put_panels(sheet, top);
    fputs("unset multiplot\n", sheet->file);
}

/* The record as .h5 and the script beside it as .gp. */
static saltus_status keep_data(saltus_sheet *sheet, const saltus_flow_options *options, const char *path,
                               const char *data, saltus_message *message) {
    saltus_status status =
        saltus_write_trajectory(sheet->record, sheet->scene, sheet->system, options, data, message);
    if (status != SALTUS_OK)
        return status;
    size_t stem = strlen(data) - strlen(".h5");
    char *script = malloc(stem + sizeof ".gp");
    if (!script)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a file name");
    memcpy(script, data, stem);
    memcpy(script + stem, ".gp", sizeof ".gp");
    saltus_output output;
    status = saltus_output_open(&output, script, message);
    if (status == SALTUS_OK) {
        sheet->file = output.file;
        write_script(sheet, path, true);
        status = saltus_output_close(&output, SALTUS_OK, message);
    }
    free(script);
    return status;
}

saltus_status saltus_write_sheet(const saltus_scene *scene, const saltus_system *system,
                                 const saltus_diagnosis *diagnosis, const saltus_flow_options *options,
                                 const char *path, const char *data, saltus_message *message) {
    const saltus_trajectory *record = diagnosis->record, *section = diagnosis->section;
    int n = saltus_system_dimension(system);
    if (!saltus_gnuplot_terminal(path))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .png, .pdf or .svg", path);
    if (data && !saltus_path_ends(data, ".h5"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .h5", data);
    if (record->samples < 2 || record->dimension != n || (section && section->dimension != n))
        return saltus_fail(message, SALTUS_BAD_INPUT, "the record does not belong to the system");
    bool settled = saltus_verdict_settled(diagnosis->motion->verdict);
    const saltus_spectra *spectra = diagnosis->spectra;
    saltus_sheet sheet = {.scene = scene,
                          .system = system,
                          .motion = diagnosis->motion,
                          .record = record,
                          .section = section && !settled ? section : record,
                          .spectra = spectra};
    if (spectra && spectra->count > 0 && spectra->spectra[0].kind != SALTUS_SPECTRUM_CONSTANT)
        sheet.spectrum = &spectra->spectra[0];
    saltus_sheet_choose(&sheet);
    saltus_status status = data ? keep_data(&sheet, options, path, data, message) : SALTUS_OK;
    if (status != SALTUS_OK)
        return status;
    status = saltus_gnuplot_open(&sheet.file, message);
    if (status != SALTUS_OK)
        return status;
    write_script(&sheet, path, false);
    return saltus_gnuplot_draw(sheet.file, path, message);
}
