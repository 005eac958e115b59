/* The words of a sheet, in gnuplot's enhanced text inside single quotes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/caption.h"
#include "io/describe.h"
#include "io/sheet.h"

#include <math.h>
#include <string.h>

static void add_motion(saltus_line *l, const saltus_sheet *sheet) {
    const saltus_motion *m = sheet->motion;
    if (m->kind == SALTUS_UNDECIDED)
        saltus_line_plain(l, m->reason);
    else if (m->kind == SALTUS_EQUILIBRIUM)
        saltus_line_add(l, "at rest, clear of every stop");
    else if (m->kind == SALTUS_HELD)
        saltus_line_add(l, "in contact for good");
    else if (m->impacts < 0)
        saltus_line_add(l, "complete chatter, %d sticking interval%s in %d {/:Italic T}",
                        m->sticking_intervals, m->sticking_intervals == 1 ? "" : "s", m->periods);
    else if (m->impacts == 0)
        saltus_line_add(l, "no impact in %d {/:Italic T}", m->periods);
    else
        saltus_line_add(l, "%lld impact%s in %d {/:Italic T}, %.4g per response cycle%s", m->impacts,
                        m->impacts == 1 ? "" : "s", m->periods, saltus_impacts_per_response(sheet->system, m),
                        saltus_is_pipe(sheet->system) ? " 2{/:Italic T}" : "");
    if (m->kind == SALTUS_PERIODIC && m->mirror != SALTUS_MIRROR_NONE)
        saltus_line_add(l, ";  %s",
                        m->mirror == SALTUS_MIRROR_SELF ? "its own mirror image" : "one of a mirror pair");
}

/* The leading multipliers; a complex pair is named once, with its modulus. */
static void add_multipliers(saltus_line *l, const saltus_motion *m) {
    enum { leading = 4 };
    if (m->kind == SALTUS_UNDECIDED || m->multiplier_count == 0)
        return;
    saltus_line_add(l, ";  Floquet multipliers ");
    for (int k = 0; k < m->multiplier_count && k < leading; k++) {
        const saltus_multiplier *f = &m->multipliers[k];
        bool pair = saltus_multiplier_pair(m, k);
        saltus_line_add(l, "%s", k ? ",  " : "");
        saltus_line_number(l, "%.4g", f->re);
        if (f->im != 0)
            saltus_line_add(l, " %s %.4g{/:Italic i} (modulus %.4g)",
                            pair        ? "±"
                            : f->im < 0 ? "−"
                                        : "+",
                            fabs(f->im), exp(f->log_modulus));
        k += pair;
    }
    saltus_line_add(l, "%s", m->multiplier_count > leading ? ", …" : "");
}

/* What is shown of a motion that is no closed orbit. */
static void add_stretch(saltus_line *l, const saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    if (!sheet->orbit)
        saltus_line_add(l, ";  shown: %.6g periods", r->time[sheet->rows - 1] - r->time[0]);
}

double saltus_sheet_caption(const saltus_sheet *sheet) {
    char verdict[64];
    saltus_line head = {.length = 0}, title = {.length = 0}, parameters = {.length = 0},
                motion = {.length = 0};
    double height = 0.932;
    saltus_verdict(sheet->motion, verdict);
    saltus_line_plain(&head, sheet->scene->name);
    saltus_line_add(&head, ":  ");
    saltus_line_plain(&head, verdict);
    saltus_line_plain(&title, sheet->scene->title);
    saltus_line_parameters(&parameters, sheet->system, (const char *const[2]){NULL, NULL});
    add_motion(&motion, sheet);
    add_multipliers(&motion, sheet->motion);
    add_stretch(&motion, sheet);
    fprintf(sheet->file, "set label '{/=20:Bold %s}' at screen 0.03,0.967 left front\n", head.text);
    saltus_line_put(sheet->file, &title, "#606060", &height);
    saltus_line_put(sheet->file, &parameters, "#202020", &height);
    saltus_line_put(sheet->file, &motion, "#202020", &height);
    return height;
}

static const char *bracketed(const saltus_sheet *sheet, char *text, size_t room) {
    const saltus_spec *spec = saltus_system_spec(sheet->system);
    double xi = spec->stop_count ? spec->stops[0].xi : 0.5;
    if (xi == 0.5)
        snprintf(text, room, "(½, {/:Italic τ})");
    else
        snprintf(text, room, "(%.4g, {/:Italic τ})", xi);
    return text;
}

/* The observed coordinate of an oscillator; false when it is no single mass. */
static bool single_mass(const saltus_sheet *sheet, int *mass) {
    const double *observer = saltus_system_observer(sheet->system);
    bool two = saltus_system_dof(sheet->system) > 1;
    *mass = observer[0] == 1 ? 1 : 2;
    return two ? observer[0] + observer[1] == 1 && observer[0] * observer[1] == 0 : observer[0] == 1;
}

void saltus_sheet_displacement_name(const saltus_sheet *sheet, char *text, size_t room) {
    char place[64];
    int mass;
    if (saltus_is_pipe(sheet->system))
        snprintf(text, room, "displacement {/:Italic η}%s", bracketed(sheet, place, sizeof place));
    else if (single_mass(sheet, &mass))
        snprintf(text, room, "displacement {/:Italic x}_%d", mass);
    else
        snprintf(text, room, "contact coordinate {/:Italic g}");
}

void saltus_sheet_velocity_name(const saltus_sheet *sheet, char *text, size_t room) {
    char place[64];
    int mass;
    if (saltus_is_pipe(sheet->system))
        snprintf(text, room, "velocity ∂{/:Italic η}/∂{/:Italic τ} %s",
                 bracketed(sheet, place, sizeof place));
    else if (single_mass(sheet, &mass))
        snprintf(text, room, "velocity d{/:Italic x}_%d/d{/:Italic t}", mass);
    else
        snprintf(text, room, "velocity d{/:Italic g}/d{/:Italic t}");
}
