/* The one-page diagnosis of a motion: four panels drawn by gnuplot from a script that holds its own data.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/sheet.h"

#include "io/describe.h"
#include "io/gnuplot.h"
#include "io/output.h"

#include <errno.h>
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

/* Places on the page, in parts of its width and height. */
static const double left_column[2] = {0.078, 0.478}, right_column[2] = {0.573, 0.973};

typedef struct rows_of_panels {
    double low[2], high[2]; /* begin and end of each */
} rows_of_panels;

static void put_style(FILE *file) {
    fputs("set encoding utf8\n"
          "set border 3 lc rgb '#606060' lw 1\n"
          "set tics out nomirror scale 0.6 tc rgb '#303030'\n"
          "set grid lt 1 lc rgb '#eeeeee' lw 1 back\n"
          "set key off\n"
          "set minussign\n"
          "set style fill solid 1 noborder\n"
          "set palette defined (0 '#3b2a6b', 0.25 '#33628d', 0.5 '#21908d', 0.75 '#5cb85c', 1 '#d4b020')\n"
          "unset colorbox\n",
          file);
}

/* Begin a panel: its place, heading and axes. */
static void open_panel(FILE *file, const double across[2], const double up[2], char letter,
                       const char *heading) {
    fprintf(file,
            "set lmargin at screen %g\nset rmargin at screen %g\nset bmargin at screen %g\nset tmargin at "
            "screen %g\n",
            across[0], across[1], up[0], up[1]);
    fprintf(file,
            "set label 99 '{/:Bold (%c)}  %s' at graph 0, graph 1 offset 0,1.1 left front tc rgb '#202020'\n",
            letter, heading);
}

static void put_axes(FILE *file, const char *x, saltus_range across, const char *y, saltus_range up) {
    fprintf(file, "set xlabel '%s'\nset xrange [%.9g:%.9g]\n", x, across.low, across.high);
    fprintf(file, "set ylabel '%s' offset -0.6,0\nset yrange [%.9g:%.9g]\n", y, up.low, up.high);
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
        if (!saltus_sheet_observes(sheet, face.stop) || !(d > range.low && d < range.high))
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
static void put_portrait(const saltus_sheet *sheet, const double up[2]) {
    char x[160], y[160];
    saltus_sheet_displacement_name(sheet, x, sizeof x);
    saltus_sheet_velocity_name(sheet, y, sizeof y);
    open_panel(sheet->file, left_column, up, 'a',
               "phase portrait, dots at {/:Italic τ} = 0 (mod {/:Italic T})");
    put_axes(sheet->file, x, sheet->displacement, y, sheet->velocity);
    put_stops(sheet, true);
    fputs("plot ", sheet->file);
    if (saltus_sheet_impacts(sheet) > 0)
        fprintf(sheet->file, "$jumps using 1:2 with lines lc rgb '%s' lw 1.5, \\\n     ",
                sheet->orbit ? STRIKE : "#d8c44e2a");
    fprintf(sheet->file, "$orbit using 2:3 with lines lc rgb '%s' lw %s, \\\n", sheet->orbit ? TRACE : THIN,
            sheet->orbit ? "2" : "0.7");
    fprintf(sheet->file,
            "     $strobe using 1:2 with points pt 7 ps %s lc rgb '#ffffff', \\\n"
            "     $strobe using 1:2 with points pt 7 ps %s lc rgb '" STROBE "'\n",
            sheet->orbit ? "1.5" : "0.6", sheet->orbit ? "1.0" : "0.5");
    close_panel(sheet->file);
}

static const char *history_heading(const saltus_sheet *sheet) {
    bool struck = saltus_sheet_impacts(sheet) > 0;
    if (sheet->contacts && !struck)
        return "time history; bars: contact";
    if (sheet->contacts)
        return sheet->orbit ? "one orbit; dots: impacts, bar: contact"
                            : "time history; dots: impacts, bars: contact";
    if (struck)
        return sheet->orbit ? "one orbit; dots: impacts" : "time history; dots: impacts";
    return sheet->orbit ? "one orbit" : "time history";
}

static void put_history(const saltus_sheet *sheet, const double up[2]) {
    const saltus_record *r = sheet->record;
    saltus_range time = {r->time[sheet->recent], r->time[sheet->rows - 1]};
    char name[160];
    saltus_sheet_displacement_name(sheet, name, sizeof name);
    open_panel(sheet->file, right_column, up, 'b', history_heading(sheet));
    put_axes(sheet->file, "time {/:Italic τ}/{/:Italic T}", time, name, sheet->displacement);
    put_stops(sheet, false);
    fprintf(sheet->file, "plot $history using 1:2 with lines lc rgb '" TRACE "' lw %s",
            sheet->orbit ? "2" : "1.3");
    if (saltus_sheet_impacts(sheet) > 0)
        fputs(", \\\n     $impacts using 1:2 with points pt 7 ps 0.75 lc rgb '" STRIKE "'", sheet->file);
    if (sheet->contacts)
        fputs(", \\\n     $contacts using 1:2 with lines lc rgb '" HOLD "' lw 8", sheet->file);
    fputc('\n', sheet->file);
    close_panel(sheet->file);
}

/* Marks of the impact map: colour by stop, triangle by side. */
static void put_impact_marks(const saltus_sheet *sheet, bool logarithmic) {
    static const char *const colour[SALTUS_STOPS_MAX] = {STRIKE, TRACE, "#2f8f6f", "#8a5aa0"};
    const char *separator = "plot ", *value = logarithmic ? "abs($4)" : "$4";
    bool many = sheet->events > 400;
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        fprintf(sheet->file,
                "%s$impacts using ($5 == %d && $6 == %d ? $3 : NaN):(%s) with points pt %d ps %s lc rgb "
                "'%s%s' title "
                "'stop %d, %s side'",
                separator, face.side, face.stop + 1, value, face.side > 0 ? 9 : 11, many ? "0.5" : "1.3",
                many ? "#60" : "#", colour[face.stop] + 1, face.stop + 1, saltus_side_word(face.side));
        separator = ", \\\n     ";
    }
    fputc('\n', sheet->file);
}

/* Chatter spans decades of speed, which a logarithmic axis shows. */
static void put_impact_map(const saltus_sheet *sheet, const double up[2]) {
    const saltus_record *r = sheet->record;
    saltus_range size = {INFINITY, 0}, signed_range = {0, 0}, phase = {0, 1};
    for (long long k = 0; k < sheet->events; k++) {
        double velocity = r->events[k].velocity_before;
        if (r->events[k].kind == SALTUS_RELEASE || velocity == 0)
            continue;
        saltus_range_add(&size, fabs(velocity));
        saltus_range_add(&signed_range, velocity);
    }
    bool logarithmic = size.high > 1e3 * size.low;
    saltus_range_pad(&signed_range, 0.08, 1);
    if (signed_range.high < 0.08 * (signed_range.high - signed_range.low))
        signed_range.high = fmax(signed_range.high, 0);
    open_panel(sheet->file, left_column, up, 'c', "impacts");
    if (logarithmic) {
        size = (saltus_range){size.low / 3, size.high * 3};
        fputs("set logscale y\nset format y '10^{%T}'\n", sheet->file);
    }
    put_axes(sheet->file, "phase {/:Italic τ}/{/:Italic T} (mod 1)", phase,
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
static void put_multipliers(const saltus_sheet *sheet, const double across[2], const double up[2],
                            char letter) {
    enum { page_width = 1600, page_height = 1200 };
    double reach = 1.15, aspect = (across[1] - across[0]) * page_width / ((up[1] - up[0]) * page_height);
    for (int k = 0; k < sheet->motion->multiplier_count; k++)
        reach = fmax(reach, 1.15 * fmax(fabs(sheet->motion->multipliers[k].re) / aspect,
                                        fabs(sheet->motion->multipliers[k].im)));
    saltus_range imaginary = {-reach, reach}, real = {-reach * aspect, reach * aspect};
    open_panel(sheet->file, across, up, letter, "Floquet multipliers and the unit circle");
    put_axes(sheet->file, "real part", real, "imaginary part", imaginary);
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

static void put_shapes(const saltus_sheet *sheet, const double up[2]) {
    const double across[2] = {right_column[0], right_column[1] - 0.045};
    saltus_range range = shape_range(sheet), unit = {0, 1};
    open_panel(sheet->file, across, up, 'd', "shapes of the pipe; grey: all that it sweeps");
    put_axes(sheet->file, "position {/:Italic ξ}", unit, "displacement {/:Italic η}", range);
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        put_block(sheet->file, saltus_system_spec(sheet->system)->stops[face.stop].xi, face.side * face.d,
                  face.side, range, 10 + f);
    }
    fprintf(sheet->file,
            "set colorbox user origin screen %g,%g size 0.010,%g noborder\nset cbtics scale "
            "0.4 offset -0.6,0\n"
            "set cblabel '{/:Italic τ}/{/:Italic T}' offset -0.4,0 rotate by 0\n",
            across[1] + 0.012, up[0], up[1] - up[0]);
    if (sheet->orbit)
        fprintf(sheet->file, "set cbrange [0:%d]\n", sheet->motion->periods);
    fputs("plot $envelope using 1:2:3 with filledcurves fc rgb '#f0f0f0', \\\n"
          "     $shapes using 1:2:3 with lines palette lw 1.6\nunset colorbox\n",
          sheet->file);
    close_panel(sheet->file);
}

static void put_masses(const saltus_sheet *sheet, const double up[2]) {
    const saltus_record *r = sheet->record;
    const saltus_spec *spec = saltus_system_spec(sheet->system);
    saltus_range x1 = {INFINITY, -INFINITY}, x2 = {INFINITY, -INFINITY};
    for (long long row = 0; row < sheet->rows; row++) {
        saltus_range_add(&x1, r->states[row * r->dimension]);
        saltus_range_add(&x2, r->states[row * r->dimension + 1]);
    }
    saltus_range_pad(&x1, 0.08, saltus_system_scale(sheet->system)[0]);
    saltus_range_pad(&x2, 0.08, saltus_system_scale(sheet->system)[1]);
    open_panel(sheet->file, right_column, up, 'd', "both masses; grey: stops");
    put_axes(sheet->file, "displacement {/:Italic x}_1", x1, "displacement {/:Italic x}_2", x2);
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

static void put_folded(const saltus_sheet *sheet, const double across[2], const double up[2], char letter) {
    saltus_range phase = {0, 1};
    char name[160];
    saltus_sheet_displacement_name(sheet, name, sizeof name);
    open_panel(sheet->file, across, up, letter, "all periods on top of each other");
    put_axes(sheet->file, "phase {/:Italic τ}/{/:Italic T} (mod 1)", phase, name, sheet->displacement);
    put_stops(sheet, false);
    fprintf(sheet->file, "plot $folded using 1:2 with lines lc rgb '%s' lw %s\n", sheet->orbit ? TRACE : THIN,
            sheet->orbit ? "2" : "0.7");
    close_panel(sheet->file);
}

/* Which panels a motion gets: what it has, and nothing twice. */
static void put_panels(const saltus_sheet *sheet, double top) {
    double gap = 0.128, bottom = 0.078, height = (top - 0.05 - bottom - gap) / 2;
    const double lower[2] = {bottom, bottom + height},
                 upper[2] = {bottom + height + gap, bottom + 2 * height + gap};
    bool struck = saltus_sheet_impacts(sheet) > 0;
    bool multipliers = sheet->motion->kind != SALTUS_UNDECIDED && sheet->motion->multiplier_count > 0;
    bool shown = !struck && multipliers;
    put_portrait(sheet, upper);
    put_history(sheet, upper);
    if (struck)
        put_impact_map(sheet, lower);
    else if (multipliers)
        put_multipliers(sheet, left_column, lower, 'c');
    else
        put_folded(sheet, left_column, lower, 'c');
    if (saltus_is_pipe(sheet->system))
        put_shapes(sheet, lower);
    else if (saltus_system_dof(sheet->system) > 1)
        put_masses(sheet, lower);
    else if (multipliers && !shown)
        put_multipliers(sheet, right_column, lower, 'd');
    else
        put_folded(sheet, right_column, lower, 'd');
}

/* Ranges of the first two panels, with the stops near the motion. */
static void find_ranges(saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    saltus_range x = {INFINITY, -INFINITY}, v = x;
    for (long long row = 0; row < sheet->rows; row++) {
        saltus_range_add(&x, r->displacement[row]);
        saltus_range_add(&v, r->velocity[row]);
    }
    double width = x.high - x.low;
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        double d = face.side * face.d;
        if (saltus_sheet_observes(sheet, face.stop) && d > x.low - 0.6 * width && d < x.high + 0.6 * width)
            saltus_range_add(&x, d);
    }
    const double *scale = saltus_system_scale(sheet->system);
    saltus_range_pad(&x, 0.07, scale[0]);
    saltus_range_pad(&v, 0.07, scale[saltus_system_dof(sheet->system)]);
    sheet->displacement = x;
    sheet->velocity = v;
}

/* One closed orbit where the motion has one and the record covers it; otherwise the record, its last part if
 * it is long, with the last 20 periods as time history. */
static void choose_rows(saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    double end = r->time[r->samples - 1], span = 20;
    int periods = sheet->motion->periods;
    sheet->orbit = sheet->motion->kind != SALTUS_UNDECIDED && periods > 0 && end >= periods;
    sheet->rows = r->samples < SALTUS_SHEET_ROWS_MAX ? r->samples : SALTUS_SHEET_ROWS_MAX;
    if (sheet->orbit)
        for (sheet->rows = 1; sheet->rows < r->samples && r->time[sheet->rows] <= periods;)
            sheet->rows++;
    end = r->time[sheet->rows - 1];
    while (!sheet->orbit && r->time[sheet->recent] < end - span)
        sheet->recent++;
    while (sheet->events < r->event_count && r->event_rows[sheet->events] + 1 < sheet->rows)
        sheet->events++;
    find_ranges(sheet);
}

/* The script; `picture` is the file that it draws to, NULL for standard output. */
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
          "' at screen 0.985,0.012 right tc rgb '#909090' font ',9' front\n",
          sheet->file);
    put_panels(sheet, top);
    fputs("unset multiplot\n", sheet->file);
}

/* The record as .h5 and the script beside it as .gp. */
static saltus_status keep_data(saltus_sheet *sheet, const saltus_flow_options *options, const char *path,
                               const char *data, saltus_message *message) {
    saltus_status status =
        saltus_record_write(sheet->record, sheet->scene, sheet->system, options, data, message);
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
                                 const saltus_motion *motion, const saltus_record *record,
                                 const saltus_flow_options *options, const char *path, const char *data,
                                 saltus_message *message) {
    if (!saltus_gnuplot_terminal(path))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .png, .pdf or .svg", path);
    if (data && !saltus_path_ends(data, ".h5"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .h5", data);
    if (record->samples < 2 || record->dimension != saltus_system_dimension(system))
        return saltus_fail(message, SALTUS_BAD_INPUT, "the record does not belong to the system");
    saltus_sheet sheet = {.scene = scene, .system = system, .motion = motion, .record = record};
    choose_rows(&sheet);
    saltus_status status = data ? keep_data(&sheet, options, path, data, message) : SALTUS_OK;
    if (status != SALTUS_OK)
        return status;
    sheet.file = saltus_nameless_file();
    if (!sheet.file)
        return saltus_fail(message, SALTUS_IO, "no temporary file can be made: %s", strerror(errno));
    write_script(&sheet, path, false);
    status = saltus_gnuplot_draw(sheet.file, path, message);
    fclose(sheet.file);
    return status;
}
