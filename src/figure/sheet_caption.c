/* Texts of a sheet, in gnuplot's enhanced text inside single quotes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sheet.h"
#include "record/describe.h"

#include <math.h>
#include <string.h>

/* Description of a motion without a period. */
static void add_irregular(saltus_line *l, const saltus_motion *m) {
    const saltus_evidence *e = &m->evidence;
    if (m->verdict != SALTUS_CHAOTIC && m->verdict != SALTUS_QUASIPERIODIC) {
        /* Append plain text with "+-" replaced by the plus-minus sign. */
        const char *text = m->reason;
        for (const char *sign; (sign = strstr(text, " +- ")); text = sign + 4) {
            saltus_line before = {.length = 0};
            saltus_line_add(&before, "%.*s", (int)(sign - text), text);
            saltus_line_plain(l, before.text);
            saltus_line_add(l, " ± ");
        }
        saltus_line_plain(l, text);
        return;
    }
    saltus_line_add(l, "largest exponent ");
    saltus_line_uncertain(l, m->lyapunov, m->lyapunov_error);
    saltus_line_add(l, " per unit of time, %s;  measured over %lld periods by %d trajectories",
                    m->verdict == SALTUS_CHAOTIC                 ? "positive in both halves of the run"
                    : fabs(m->lyapunov) <= 3 * m->lyapunov_error ? "zero within its error"
                                                                 : "next to zero",
                    e->periods, e->members);
    if (e->curves > 0)
        saltus_line_add(l, ";  section points fill %d closed curve%s", e->curves, saltus_plural(e->curves));
}

/* The exponent of an orbit, from its largest multiplier; of other motions further numbers behind the verdict.
 */
static void add_evidence(saltus_line *l, const saltus_motion *m) {
    const saltus_evidence *e = &m->evidence;
    if (m->verdict == SALTUS_PERIODIC && !isnan(m->lyapunov)) {
        saltus_line_add(l, "largest exponent ln|{/:Italic μ}_1|/");
        if (m->periods > 1)
            saltus_line_add(l, "(%d {/:Italic T}) = ", m->periods);
        else
            saltus_line_add(l, "{/:Italic T} = ");
        if (isfinite(m->lyapunov))
            saltus_line_number(l, "%.4g", m->lyapunov);
        else
            saltus_line_add(l, "−∞");
        saltus_line_add(l, " per unit of time");
    }
    if (saltus_verdict_settled(m->verdict) || e->periods == 0)
        return;
    if (m->verdict != SALTUS_QUASIPERIODIC && isfinite(e->half[0]) && isfinite(e->half[1])) {
        saltus_line_add(l, "exponent in the halves of the run ");
        saltus_line_uncertain(l, e->half[0], e->half_errors[0]);
        saltus_line_add(l, " and ");
        saltus_line_uncertain(l, e->half[1], e->half_errors[1]);
    }
    if (isfinite(e->zero_one))
        saltus_line_number(saltus_line_next(l), "0–1 test %.3f", e->zero_one);
    if (isfinite(e->dimension)) {
        saltus_line_add(saltus_line_next(l), "correlation dimension ");
        saltus_line_uncertain(l, e->dimension, e->dimension_error);
    }
    if (isfinite(e->broadband)) {
        const bool small = e->broadband > 0 && e->broadband < 1e-3;
        saltus_line_number(saltus_line_next(l), small ? "broadband fraction %.1e" : "broadband fraction %.2g",
                           e->broadband);
    }
    if (e->lifetime_at_least > 0)
        saltus_line_add(saltus_line_next(l), "mean lifetime at least %.0f {/:Italic T}",
                        e->lifetime_at_least);
    if (isfinite(e->impacts_per_period)) /* complete chatter has no number */
        saltus_line_number(saltus_line_next(l), "%.4g impacts per {/:Italic T}", e->impacts_per_period);
}

/* What the motion is, and the leading multipliers; a complex pair is written once, with its modulus. */
static void add_motion(saltus_line *l, const saltus_sheet *sheet) {
    enum { leading = 4 };
    const saltus_motion *m = sheet->motion;
    const bool settled = saltus_verdict_settled(m->verdict);
    if (!settled)
        add_irregular(l, m);
    else if (m->verdict == SALTUS_EQUILIBRIUM)
        saltus_line_add(l, "at rest, clear of every stop");
    else if (m->verdict == SALTUS_HELD)
        saltus_line_add(l, "in contact for good");
    else if (m->impacts < 0)
        saltus_line_add(l, "complete chatter, %d sticking interval%s in %d {/:Italic T}",
                        m->sticking_intervals, saltus_plural(m->sticking_intervals), m->periods);
    else if (m->impacts == 0)
        saltus_line_add(l, "no impact in %d {/:Italic T}", m->periods);
    else {
        saltus_line_add(l, "%lld impact%s in %d {/:Italic T}, ", m->impacts, saltus_plural(m->impacts),
                        m->periods);
        saltus_line_number(l, "%.4g per response cycle", saltus_impacts_per_response(sheet->system, m));
        saltus_line_add(l, "%s", saltus_notation_of(sheet->system)->response == 2 ? " 2{/:Italic T}" : "");
    }
    if (m->trivial_multiplier != 0) {
        saltus_line_number(l, ";  period %.8g", m->period);
        saltus_line_add(l, ", {/:Italic T} is the mean time between maxima");
    }
    if (m->verdict == SALTUS_PERIODIC && m->mirror != SALTUS_MIRROR_NONE)
        saltus_line_add(l, ";  %s",
                        m->mirror == SALTUS_MIRROR_SELF ? "its own mirror image" : "one of a mirror pair");
    for (int k = 0; k < m->multiplier_count && k < leading && settled; k++) {
        const saltus_multiplier *f = &m->multipliers[k];
        bool pair = saltus_multiplier_pair(m, k);
        saltus_line_add(l, "%s", k ? ",  " : ";  Floquet multipliers ");
        saltus_line_number(l, "%.4g", f->re);
        if (f->im != 0) {
            saltus_line_add(l, " %s ", pair ? "±" : f->im < 0 ? "−" : "+");
            saltus_line_number(l, "%.4g", fabs(f->im));
            saltus_line_number(l, "{/:Italic i} (modulus %.4g)", exp(f->log_modulus));
        }
        k += pair;
    }
    saltus_line_add(l, "%s", settled && m->multiplier_count > leading ? ", …" : "");
}

void saltus_sheet_caption(const saltus_sheet *sheet, const saltus_scene *scene, saltus_page *page) {
    const saltus_motion *m = sheet->motion;
    const bool settled = saltus_verdict_settled(m->verdict);
    char text[256];
    saltus_line *head = saltus_page_scene(page, scene->title, sheet->system);
    saltus_motion_summary(m, text);
    saltus_line_plain(head, scene->name);
    saltus_line_add(head, ":  ");
    saltus_line_plain(head, text);
    add_motion(saltus_page_words(page, "#202020"), sheet);
    saltus_line *evidence = saltus_page_words(page, "#202020"), *phases = saltus_page_words(page, "#202020"),
                *stretch = saltus_page_words(page, "#606060");
    add_evidence(evidence, m);
    if (!settled && m->evidence.laminar_period) {
        saltus_line_add(phases, "intermittent: %.0f %% of the time near a motion of period ",
                        100 * m->evidence.laminar);
        if (m->evidence.laminar_period > 1)
            saltus_line_add(phases, "%d ", m->evidence.laminar_period);
        saltus_line_add(phases, "{/:Italic T}, up to %lld periods at a stretch", m->evidence.longest_phase);
    }
    /* Which part of a motion without a closed orbit is shown. */
    if (sheet->orbit)
        return;
    saltus_line_number(stretch, "shown: %.6g periods",
                       sheet->record->time[sheet->rows - 1] - sheet->record->time[0]);
    if (!settled)
        saltus_line_add(stretch, ", section %lld", sheet->section->strobes);
    if (sheet->spectra) {
        saltus_spectra_method(sheet->spectra, text, sizeof text);
        saltus_line_add(stretch, ";  spectrum from ");
        saltus_line_plain(stretch, text);
    }
}
