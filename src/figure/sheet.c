/* The one-page diagnosis of a motion: up to six panels, drawn by gnuplot from a script that contains the
 * data. And the figure of a recorded trajectory: phase portrait and time history of the whole record.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sheet.h"

#include "record/describe.h"
#include "record/output.h"
#include "record/trajectory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Draws a panel in its frame; `letter` is the number of its letter. */
typedef void panel(const saltus_sheet *sheet, saltus_frame frame, int letter);

enum { panels_most = 6 };

static void put_axes(const saltus_sheet *sheet, saltus_frame frame, const char *x, saltus_range across,
                     const char *y, saltus_range up, bool logarithmic) {
    saltus_page_axis(sheet->page, "x", frame, false, x, across);
    saltus_page_axis(sheet->page, "y", frame, logarithmic, y, up);
    if (!saltus_page_narrow(sheet->page))
        fprintf(sheet->page->file, "set xtics %.9g\n",
                saltus_page_tic_step(across, (frame.right - frame.left) / 100 + 1.5));
}

/* Axes for the observed displacement and its velocity. */
static void put_observed(const saltus_sheet *sheet, saltus_frame frame, saltus_range x, saltus_range v) {
    saltus_line displacement = {.length = 0}, velocity = {.length = 0};
    saltus_line_observed(&displacement, sheet->system, false);
    saltus_line_observed(&velocity, sheet->system, true);
    put_axes(sheet, frame, displacement.text, x, velocity.text, v, false);
}

/* Stops of the observed coordinate within its range: a line at the clearance, grey beyond it. `vertical`: the
 * lines are vertical, as displacement is the horizontal axis. */
static void put_stops(const saltus_sheet *sheet, bool vertical) {
    const saltus_range range = sheet->displacement;
    FILE *file = sheet->page->file;
    const char *place =
        vertical ? "from %.9g, graph 0 to %.9g, graph 1" : "from graph 0, first %.9g to graph 1, first %.9g";
    for (int f = 0; f < sheet->face_count; f++) {
        const double d = sheet->faces[f].place;
        if (!sheet->faces[f].observed || !(d > range.low && d < range.high))
            continue;
        fputs("set object rectangle ", file);
        fprintf(file, place, d, sheet->faces[f].side > 0 ? range.high : range.low);
        fputs(" back fc rgb '#e2e2e2' fs solid noborder\nset arrow ", file);
        fprintf(file, place, d, d);
        fputs(" nohead back lc rgb '#808080' lw 1.5\n", file);
    }
}

/* Variables that control the templates. */
static void put_facts(const saltus_sheet *sheet, long long events) {
    saltus_page_number(sheet->page, "Impacts", (double)saltus_sheet_impacts(sheet->record, events));
    saltus_page_number(sheet->page, "Contacts", (double)sheet->contacts);
    saltus_page_number(sheet->page, "Orbit", sheet->strong);
    saltus_page_number(sheet->page, "Settled",
                       sheet->motion ? saltus_verdict_settled(sheet->motion->verdict) : sheet->strong);
}

static void put_portrait(const saltus_sheet *sheet, saltus_frame frame, int letter) {
    if (saltus_sheet_timed(sheet))
        saltus_page_panel(sheet->page, frame, letter,
                          "phase portrait, dots at {/:Italic %s} = 0 (mod {/:Italic T})",
                          saltus_notation_of(sheet->system)->time);
    else
        saltus_page_panel(sheet->page, frame, letter, "phase portrait");
    put_observed(sheet, frame, sheet->displacement, sheet->velocity);
    put_stops(sheet, true);
    put_facts(sheet, sheet->events);
    saltus_page_draw(sheet->page, "portrait");
}

static void put_history(const saltus_sheet *sheet, saltus_frame frame, int letter) {
    const saltus_trajectory *r = sheet->record;
    const bool struck = saltus_sheet_impacts(r, sheet->history_events) > 0;
    saltus_range time = {r->time[0], r->time[sheet->history_rows - 1]};
    saltus_line name = {.length = 0};
    char elapsed[64];
    saltus_line_observed(&name, sheet->system, false);
    saltus_page_panel(sheet->page, frame, letter, "%s%s%s",
                      sheet->orbit && (struck || !sheet->contacts) ? "one orbit" : "time history",
                      struck ? "; marks: impacts" : "",
                      !sheet->contacts ? ""
                      : !struck        ? "; bars: contact"
                      : sheet->orbit   ? ", bar: contact"
                                       : ", bars: contact");
    snprintf(elapsed, sizeof elapsed, "time {/:Italic %s}%s", saltus_notation_of(sheet->system)->time,
             saltus_sheet_timed(sheet) ? "/{/:Italic T}" : "");
    put_axes(sheet, frame, elapsed, time, name.text, sheet->displacement, false);
    put_stops(sheet, false);
    put_facts(sheet, sheet->history_events);
    saltus_page_draw(sheet->page, "history");
}

/* The section points of a long record, in axes fitted to them. */
static void put_section(const saltus_sheet *sheet, saltus_frame frame, int letter) {
    const double *scale = saltus_system_scale(sheet->system);
    long long count = sheet->section->strobes;
    saltus_range x = {INFINITY, -INFINITY}, v = x;
    for (long long k = 0; k < count; k++) {
        double point[2];
        saltus_sheet_strobe(sheet, sheet->section, k, point);
        saltus_range_add(&x, point[0]);
        saltus_range_add(&v, point[1]);
    }
    saltus_range_pad(&x, 0.06, scale[0]);
    saltus_range_pad(&v, 0.06, scale[saltus_system_dof(sheet->system)]);
    saltus_page_panel(sheet->page, frame, letter, "stroboscopic section, %lld points", count);
    put_observed(sheet, frame, x, v);
    saltus_page_draw(sheet->page, "section");
}

/* Marks of the impact map: one colour and sign for each side of a stop. Where the marks are small the legend
 * has larger ones. */
static void put_impact_marks(const saltus_sheet *sheet, bool logarithmic) {
    const char *separator = "plot ", *value = logarithmic ? "abs($2)" : "$2";
    const char *size = sheet->mapped > 400 ? "0.5" : sheet->mapped > 60 ? "0.8" : "1.3";
    const bool small = sheet->mapped > 60;
    FILE *file = sheet->page->file;
    for (int part = 0; part < 1 + small; part++)
        for (int f = 0; f < sheet->face_count; f++) {
            const saltus_sheet_face *face = &sheet->faces[f];
            if (!face->hit)
                continue;
            fputs(separator, file);
            separator = ", \\\n     ";
            if (part == 0)
                fprintf(file,
                        "$impact_map using ($3 == %d && $4 == %d ? $1 : NaN):(%s) with points pt %d ps %s lc "
                        "rgb '%s%06x' ",
                        face->side, face->stop + 1, value, face->sign, size,
                        sheet->mapped > 400 ? "#60" : "#", face->colour);
            else
                fprintf(file, "NaN with points pt %d ps 1.3 lc rgb '#%06x' ", face->sign, face->colour);
            if (small && part == 0)
                fputs("notitle", file);
            else
                fprintf(file, "title 'stop %d, %s%s'", face->stop + 1, saltus_side_word(face->side),
                        saltus_page_narrow(sheet->page) ? "" : " side");
        }
    fputc('\n', file);
}

/* The speeds of chatter span decades, so they get a logarithmic axis. */
static void put_impact_map(const saltus_sheet *sheet, saltus_frame frame, int letter) {
    const saltus_trajectory *r = sheet->section;
    char phase_name[64];
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
    bool narrow = saltus_page_narrow(sheet->page);
    const bool cut = sheet->mapped < r->event_count;
    if (sheet->face_count > 1 && !narrow) /* the legend is beside the panel; on a narrow page above it */
        frame.right -= 156;
    if (sheet->orbit)
        saltus_page_panel(sheet->page, frame, letter, "impacts");
    else
        saltus_page_panel(sheet->page, frame, letter, "impacts of %.*g {/:Italic T}", cut ? 4 : 6,
                          cut ? r->time[r->event_rows[sheet->mapped - 1]] : r->time[r->samples - 1]);
    if (sheet->face_count > 1 && narrow) {
        frame.top -= 8;
        for (int f = 0; f < sheet->face_count; f++)
            frame.top -= 19 * sheet->faces[f].hit;
        saltus_page_frame(sheet->page, frame, SALTUS_PANEL_LEAST);
    }
    if (logarithmic) {
        saltus_range_floor(&size);
        size = (saltus_range){size.low / 3, size.high * 3};
    }
    snprintf(phase_name, sizeof phase_name, "phase {/:Italic %s}/{/:Italic T} (mod 1)",
             saltus_notation_of(sheet->system)->time);
    put_axes(sheet, frame, phase_name, phase,
             logarithmic ? "impact speed |{/:Bold n·q′}|" : "velocity before impact, {/:Bold n·q′}",
             logarithmic ? size : signed_range, logarithmic);
    if (sheet->face_count > 1)
        fprintf(sheet->page->file,
                "set key at graph %s left %s vertical Left reverse samplen 0.5 width -2 font "
                "',%.4g' textcolor rgb '#303030'\n",
                narrow ? "0, graph 1.01" : "1.02, graph 1.02", narrow ? "bottom" : "top",
                saltus_page_type(sheet->page, 11));
    put_impact_marks(sheet, logarithmic);
    saltus_page_template(sheet->page, "close");
}

/* Multipliers and the unit circle, with equal scales on both axes. */
static void put_multipliers(const saltus_sheet *sheet, saltus_frame frame, int letter) {
    double aspect = (frame.right - frame.left) / (frame.top - frame.bottom);
    double reach = 1.15 * fmax(1, 1 / aspect);
    for (int k = 0; k < sheet->motion->multiplier_count; k++)
        reach = fmax(reach, 1.15 * fmax(fabs(sheet->motion->multipliers[k].re) / aspect,
                                        fabs(sheet->motion->multipliers[k].im)));
    saltus_range imaginary = {-reach, reach}, real = {-reach * aspect, reach * aspect};
    saltus_page_panel(sheet->page, frame, letter, "Floquet multipliers and the unit circle");
    put_axes(sheet, frame, "real part", real, "imaginary part", imaginary, false);
    saltus_page_draw(sheet->page, "multipliers");
}

/* Stops are blocks with their tips at (xi, d), if they are near enough to the motion. */
static void put_shapes(const saltus_sheet *sheet, saltus_frame frame, int letter) {
    const double across = 0.025, up = 0.09; /* half width of a block; its height as a fraction of the range */
    saltus_range range = sheet->shape, unit = {0, 1}, time = {0, saltus_sheet_shape_time(sheet)};
    FILE *file = sheet->page->file;
    const saltus_spec *spec = saltus_system_spec(sheet->system);
    const saltus_notation *n = saltus_notation_of(sheet->system);
    char displacement[64];
    double width = range.high - range.low, least = range.low - width, most = range.high + width;
    for (int f = 0; f < sheet->face_count; f++) {
        const double d = sheet->faces[f].place;
        if (d > least && d < most)
            saltus_range_add(&range, d + sheet->faces[f].side * 0.12 * width);
    }
    saltus_range_pad(&range, 0.05, saltus_system_scale(sheet->system)[0]);
    snprintf(displacement, sizeof displacement, "displacement {/:Italic %s}", n->displacement);
    saltus_page_panel(sheet->page, frame, letter, "shapes of the %.40s; grey: all swept",
                      saltus_model_name(spec->model));
    frame.right -= saltus_page_narrow(sheet->page) ? 62 : 80; /* for the scale of time */
    saltus_page_frame(sheet->page, frame, SALTUS_PANEL_LEAST);
    put_axes(sheet, frame, "position {/:Italic ξ}", unit, displacement, range, false);
    for (int f = 0; f < sheet->face_count; f++) {
        const saltus_sheet_face *face = &sheet->faces[f];
        const double xi = spec->stops[face->stop].xi, d = face->place,
                     end = d + up * (range.high - range.low) * face->side;
        if (d > range.low && d < range.high)
            fprintf(
                file,
                "set object %d polygon from %.6g,%.6g to %.6g,%.6g to %.6g,%.6g to %.6g,%.6g front fc rgb "
                "'#808080' fs solid 1 border lc rgb '#505050'\n",
                10 + f, xi, d, xi + across, end, xi - across, end, xi, d);
    }
    double place = (frame.right + 19.2) / sheet->page->width, height = sheet->page->height;
    fprintf(file,
            "set colorbox user origin screen %g,%g size %g,%g noborder\n"
            "set label '{/:Italic %s}/{/:Italic T}' at screen %g, graph 0 offset 0,-1.05 tc rgb '#303030'\n"
            "set cbrange [0:%g]\nset cbtics %g scale 0.4 offset -0.6,0\n",
            place, frame.bottom / height, 16 / sheet->page->width, (frame.top - frame.bottom) / height,
            n->time, place, time.high, saltus_page_tic_step(time, 5));
    saltus_page_draw(sheet->page, "shapes");
}

/* The normal of a stop, if a face is a line in the plane of the first two displacements, so that no other
 * displacement enters; otherwise NULL. */
static const double *normal_in_plane(const saltus_sheet *sheet, int face) {
    const double *w = saltus_system_stop_normal(sheet->system, sheet->faces[face].stop);
    for (int i = 2; i < saltus_system_dof(sheet->system); i++)
        if (w[i] != 0)
            return NULL;
    return w;
}

static void put_masses(const saltus_sheet *sheet, saltus_frame frame, int letter) {
    const saltus_trajectory *r = sheet->record;
    const bool named = saltus_model_text(saltus_system_spec(sheet->system)->model);
    FILE *file = sheet->page->file;
    saltus_line name[2] = {{.length = 0}, {.length = 0}};
    saltus_range x[2];
    for (int k = 0; k < 2; k++) {
        x[k] = (saltus_range){INFINITY, -INFINITY};
        for (long long row = 0; row < sheet->rows; row++)
            saltus_range_add(&x[k], r->states[row * r->dimension + k]);
        saltus_range_pad(&x[k], 0.08, saltus_system_scale(sheet->system)[k]);
        saltus_line_add(&name[k], "displacement ");
        if (named)
            saltus_line_state(&name[k], sheet->system, k);
        else
            saltus_line_add(&name[k], "{/:Italic %s}_%d", saltus_notation_of(sheet->system)->displacement,
                            k + 1);
    }
    bool stops = false;
    for (int f = 0; f < sheet->face_count; f++)
        stops = stops || normal_in_plane(sheet, f);
    saltus_page_panel(sheet->page, frame, letter, "%s%s",
                      named || !stops ? "two displacements" : "both masses", stops ? "; grey: stops" : "");
    put_axes(sheet, frame, name[0].text, x[0], name[1].text, x[1], false);
    fputs("set parametric\nset trange [-1:1]\nplot ", file);
    for (int f = 0; f < sheet->face_count; f++) {
        const double *w = normal_in_plane(sheet, f);
        if (!w)
            continue;
        const double square = w[0] * w[0] + w[1] * w[1], d = sheet->faces[f].place / square,
                     far = (fabs(d) * sqrt(square) + fabs(x[0].high) + fabs(x[0].low) + fabs(x[1].high) +
                            fabs(x[1].low)) /
                           sqrt(square);
        fprintf(file, "(%.9g) + (%.9g)*t, (%.9g) + (%.9g)*t with lines lc rgb '#808080' lw 1.5, \\\n     ",
                d * w[0], -w[1] * far * 2, d * w[1], w[0] * far * 2);
    }
    fprintf(file, "$masses using 1:2 with lines %s\nunset parametric\n",
            sheet->orbit ? "lc rgb '#2c5f8a' lw 2" : "lc rgb '#a02c5f8a' lw 1");
    saltus_page_template(sheet->page, "close");
}

static void put_spectrum(const saltus_sheet *sheet, saltus_frame frame, int letter) {
    const saltus_spectrum *s = &sheet->spectra->spectra[0];
    saltus_line heading = {.length = 0};
    bool forcing = false; /* whether multiples of the forcing frequency are among the visible lines */
    for (long long k = 0; k < s->line_count && s->kind == SALTUS_SPECTRUM_LINES; k++)
        forcing = forcing || (s->lines[k].harmonic % s->periods == 0 && s->lines[k].decibels > -100);
    saltus_line_observed(&heading, sheet->system, false);
    if (s->kind == SALTUS_SPECTRUM_WELCH)
        saltus_line_add(&heading, "; %g %% band%s", 100 * s->confidence,
                        saltus_spectrum_has_strong_lines(s) ? "; ▾ lines" : "");
    else if (s->periods == 1)
        saltus_line_add(&heading, ": multiples of {/:Italic ω}");
    else if (forcing)
        saltus_line_add(&heading, "; squares: multiples of {/:Italic ω}");
    else
        saltus_line_add(&heading, ": multiples of {/:Italic ω}/%d", s->periods);
    saltus_spectrum_low_panel(sheet->page, sheet->spectra, frame, letter, &heading);
}

/* The panel is lower to make room for the key below the heading. */
static void put_convergence(const saltus_sheet *sheet, saltus_frame frame, int letter) {
    saltus_page_panel(sheet->page, frame, letter, "convergence of the largest exponent");
    frame.top -= 62;
    saltus_course_panel(sheet->page, sheet->system, &sheet->course, frame);
}

/* Choose the panels by what is known of the motion. The structure's shapes are shown only if there is room,
 * as there always is for an orbit. */
static int choose_panels(const saltus_sheet *sheet, panel *chosen[panels_most]) {
    bool line = saltus_notation_of(sheet->system)->structure == SALTUS_STRUCTURE_LINE,
         settled = saltus_verdict_settled(sheet->motion->verdict);
    bool multipliers = settled && sheet->motion->multiplier_count > 0;
    int count = 0, last = (sheet->spectra != NULL) + (sheet->course.count > 0);
    chosen[count++] = put_portrait;
    chosen[count++] = put_history;
    if (!settled)
        chosen[count++] = put_section;
    if (saltus_sheet_impacts(sheet->section, sheet->mapped) > 0)
        chosen[count++] = put_impact_map;
    if (count + last < panels_most && (line || saltus_system_dof(sheet->system) > 1))
        chosen[count++] = line ? put_shapes : put_masses;
    if (sheet->spectra)
        chosen[count++] = put_spectrum;
    if (sheet->course.count > 0)
        chosen[count++] = put_convergence;
    if (multipliers)
        chosen[count++] = put_multipliers;
    return count;
}

static void put_script(saltus_sheet *sheet, const saltus_scene *scene, saltus_page *page) {
    const double low = 300; /* lower panels, with heading and axis, cannot be read */
    panel *chosen[panels_most];
    sheet->page = page;
    saltus_sheet_caption(sheet, scene, page);
    /* Columns of the grid: panels must be wide enough and, on a narrow page, high enough to be read. If the
     * number of panels is odd the time history takes two columns. */
    const int count = choose_panels(sheet, chosen), wanted = count > 4 ? 3 : count > 1 ? 2 : 1;
    const bool narrow = saltus_page_narrow(page), high = saltus_page_room(page) / count >= low;
    const int most = page->width >= 1500 ? 3
                     : narrow && high    ? 1
                                         : 2,
              columns = wanted < most ? wanted : most;
    const bool wide = columns > 1 && count % 2;
    const int rows = (count + wide + columns - 1) / columns;
    const double words = saltus_page_caption_height(page);
    if (page->free_height)
        page->height = rows * (page->width / columns * 0.62 + (narrow && columns > 1 ? 190 : 110)) + 60 +
                       (narrow ? 0 : words);
    saltus_page_begin(page);
    saltus_sheet_data(sheet);
    fputs("set multiplot\n", page->file);
    if (narrow && columns > 1)
        fprintf(page->file, "set tics font ',%.4g'\n", saltus_page_type(page, 11));
    saltus_page_caption(page);
    if (wide && columns == 2) { /* the time history takes two cells, so it must begin a row */
        chosen[1] = chosen[2];
        chosen[2] = put_history;
    }
    for (int k = 0, cell = 0; k < count; k++) {
        const int span = wide && chosen[k] == put_history ? 2 : 1;
        chosen[k](sheet, saltus_page_cell(page, cell, span, columns, rows), k);
        cell += span;
    }
    fputs("unset multiplot\n", page->file);
}

saltus_status saltus_write_sheet(const char *path, const saltus_scene *scene, const saltus_system *system,
                                 const saltus_flow_options *options, const saltus_diagnosis *diagnosis,
                                 const saltus_figure_options *look, const char *data,
                                 saltus_message *message) {
    const saltus_trajectory *record = diagnosis->record, *section = diagnosis->section;
    int n = saltus_system_dimension(system);
    if (data && !saltus_path_ends(data, ".h5"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .h5", data);
    if (record->samples < 2 || record->dimension != n || (section && section->dimension != n))
        return saltus_fail(message, SALTUS_BAD_INPUT, "the record does not belong to the system");
    bool settled = saltus_verdict_settled(diagnosis->motion->verdict);
    const saltus_spectra *spectra = diagnosis->spectra;
    saltus_sheet sheet = {.system = system,
                          .motion = diagnosis->motion,
                          .record = record,
                          .section = section && !settled ? section : record};
    if (spectra && spectra->count > 0 && spectra->spectra[0].kind != SALTUS_SPECTRUM_CONSTANT)
        sheet.spectra = spectra;
    saltus_sheet_choose(&sheet);
    saltus_page page;
    saltus_status status = saltus_page_open(&page, path, look, message);
    if (status != SALTUS_OK)
        return status;
    char script[4096]; /* path of the script, beside the data */
    const bool beside = data && !page.look.script;
    if (beside && snprintf(script, sizeof script, "%.*s.gp", (int)(strlen(data) - strlen(".h5")), data) >=
                      (int)sizeof script)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "%.200s...: the name is too long", data);
    if (beside)
        page.look.script = script;
    if (status == SALTUS_OK && data)
        status = saltus_write_trajectory(data, scene, system, options, record, NULL, message);
    if (status == SALTUS_OK)
        put_script(&sheet, scene, &page);
    return saltus_page_close(&page, status, message);
}

/* Below the caption, which side of which stop has which sign, if there are several. */
static void put_faces(const saltus_sheet *sheet, saltus_page *page) {
    const double entry = 130, row = 22, begin = saltus_page_narrow(page) ? 18 : 54,
                 type = saltus_page_type(page, 11);
    const int columns = (int)((page->width - begin) / entry);
    int count = 0;
    for (int f = 0; f < sheet->face_count && sheet->face_count > 1; f++) {
        const saltus_sheet_face *face = &sheet->faces[f];
        char text[64];
        if (!face->hit)
            continue;
        const double x = begin + count % columns * entry, y = page->top - 6 - count / columns * row;
        saltus_page_label(page, "", x, y, "point pt %d ps 1.1 lc rgb '#%06x' front", face->sign,
                          face->colour);
        snprintf(text, sizeof text, "stop %d, %s", face->stop + 1, saltus_side_word(face->side));
        saltus_page_label(page, text, x + 12, y, "left front font ',%.4g' tc rgb '#303030'", type);
        count++;
    }
    page->top -= count ? 4 + (count + columns - 1) / columns * row : 0;
}

saltus_status saltus_plot_trajectory(const char *figure, const char *path, const saltus_figure_options *look,
                                     saltus_message *message) {
    saltus_trajectory_file file = {.system = NULL};
    saltus_page page;
    saltus_status status = saltus_figure_check(figure, look, message);
    if (status == SALTUS_OK)
        status = saltus_trajectory_file_read(path, &file, message);
    if (status == SALTUS_OK)
        status = saltus_page_open(&page, figure, look, message);
    if (status == SALTUS_OK) {
        /* Panels side by side; on a narrow page one above the other. */
        saltus_sheet sheet = {.page = &page, .system = file.system, .record = &file.record};
        const bool narrow = saltus_page_narrow(&page);
        const int columns = narrow ? 1 : 2, rows = narrow ? 2 : 1;
        saltus_sheet_choose_all(&sheet);
        saltus_line *head = saltus_page_scene(&page, file.head.title, file.system);
        saltus_line_plain(head, file.head.scene);
        saltus_line_number(head, ":  trajectory over %.6g ",
                           file.record.time[file.record.samples - 1] - file.record.time[0]);
        saltus_line_add(head, "%s", saltus_system_forced(file.system) ? "{/:Italic T}" : "units of time");
        if (file.record.interrupted)
            saltus_line_add(head, "  (interrupted)");
        if (page.free_height) /* a narrow page is made higher for its caption when it begins */
            page.height =
                page.width * (narrow ? 1.5 : 0.5) + (narrow ? 0 : saltus_page_caption_height(&page));
        saltus_page_begin(&page);
        saltus_sheet_record_data(&sheet);
        fputs("set multiplot\n", page.file);
        saltus_page_caption(&page);
        put_faces(&sheet, &page);
        put_portrait(&sheet, saltus_page_cell(&page, 0, 1, columns, rows), 0);
        put_history(&sheet, saltus_page_cell(&page, 1, 1, columns, rows), 1);
        fputs("unset multiplot\n", page.file);
        status = saltus_page_close(&page, SALTUS_OK, message);
    }
    saltus_trajectory_file_clear(&file);
    return status;
}
