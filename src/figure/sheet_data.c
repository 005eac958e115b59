/* The numbers of a sheet: which ones are shown, and their datablocks in gnuplot's script.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sheet.h"
#include "record/describe.h"

#include <math.h>

long long saltus_sheet_impacts(const saltus_trajectory *record, long long events) {
    long long count = 0;
    for (long long k = 0; k < events; k++)
        count += record->events[k].kind != SALTUS_RELEASE;
    return count;
}

bool saltus_sheet_face_look(const saltus_sheet *sheet, int face, unsigned *colour, int *sign) {
    /* None is the blue of the trajectory, in which a jump of the velocity could not be told from motion. */
    static const unsigned colours[] = {0xc44e2a, 0x1f9e89, 0x8a5aa0, 0xb08a00,
                                       0x1c1c1c, 0x4aa3c7, 0xa03060, 0x94b447};
    enum { count = sizeof colours / sizeof colours[0] };
    const saltus_trajectory *r = sheet->section ? sheet->section : sheet->record;
    const long long events = sheet->section ? sheet->mapped : sheet->events;
    const bool all = saltus_system_face_count(sheet->system) <= count;
    bool hit = false;
    int shown = 0;
    for (int f = 0; f <= face; f++) {
        hit = all;
        for (long long k = 0; k < events && !hit; k++)
            hit = r->events[k].face == f && r->events[k].kind != SALTUS_RELEASE &&
                  r->events[k].velocity_before != 0;
        shown += hit && f < face;
    }
    *colour = colours[shown % count];
    /* Once all colours are used they repeat with open signs. */
    *sign = (saltus_system_face(sheet->system, face).side > 0 ? 9 : 11) - shown / count % 2;
    return hit;
}

void saltus_sheet_strobe(const saltus_sheet *sheet, const saltus_trajectory *record, long long k,
                         double point[2]) {
    const double *observer = saltus_system_observer(sheet->system),
                 *state = record->strobe_states + k * record->dimension;
    int n = saltus_system_dof(sheet->system);
    point[0] = point[1] = 0;
    for (int i = 0; i < n; i++) {
        point[0] += observer[i] * state[i];
        point[1] += observer[i] * state[n + i];
    }
}

/* Ranges of the phase portrait, extended to stops near the motion. */
static void find_ranges(saltus_sheet *sheet) {
    const saltus_trajectory *r = sheet->record;
    saltus_range x = {INFINITY, -INFINITY}, v = x;
    for (long long row = 0; row < sheet->rows; row++) {
        saltus_range_add(&x, r->displacement[row]);
        saltus_range_add(&v, r->velocity[row]);
    }
    double width = x.high - x.low;
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        double d = face.side * face.d;
        if (saltus_system_stop_observed(sheet->system, face.stop) && d > x.low - 0.6 * width &&
            d < x.high + 0.6 * width)
            saltus_range_add(&x, d);
    }
    const double *scale = saltus_system_scale(sheet->system);
    saltus_range_pad(&x, 0.07, scale[0]);
    saltus_range_pad(&v, 0.07, scale[saltus_system_dof(sheet->system)]);
    sheet->displacement = x;
    sheet->velocity = v;
}

/* Number of rows up to and including a time. */
static long long rows_until(const saltus_trajectory *r, double time) {
    long long rows = 1;
    while (rows < r->samples && r->time[rows] <= time)
        rows++;
    return rows;
}

/* Number of events whose two rows are both among the first `rows` rows. */
static long long events_within(const saltus_trajectory *r, long long rows) {
    long long events = 0;
    while (events < r->event_count && r->event_rows[events] + 1 < rows)
        events++;
    return events;
}

/* One closed orbit, if the motion is one and the record covers it; otherwise as many whole periods as the
 * picture can hold, with the first ones as time history. */
void saltus_sheet_choose(saltus_sheet *sheet) {
    enum { rows_most = 60000, history_periods = 20, mapped_most = 20000 };
    const saltus_trajectory *r = sheet->record;
    double end = r->time[r->samples - 1], history = history_periods;
    int periods = sheet->motion->periods;
    sheet->orbit = saltus_verdict_settled(sheet->motion->verdict) && periods > 0 && end >= periods;
    if (sheet->orbit)
        end = history = periods;
    else if (r->samples > rows_most && r->time[rows_most] >= 1)
        end = floor(r->time[rows_most]);
    sheet->rows = rows_until(r, end);
    sheet->history_rows = rows_until(r, fmin(end, history));
    sheet->events = events_within(r, sheet->rows);
    sheet->history_events = events_within(r, sheet->history_rows);
    sheet->mapped = sheet->section == r ? sheet->events : sheet->section->event_count;
    if (sheet->mapped > mapped_most)
        sheet->mapped = mapped_most;
    sheet->strong = sheet->orbit;
    sheet->timed = true;
    find_ranges(sheet);
    /* If the exponent is finite, the last part of its history in which all values are finite. */
    const saltus_motion *m = sheet->motion;
    const saltus_evidence *e = &m->evidence;
    int first = e->history_count;
    if (saltus_verdict_settled(m->verdict) || !isfinite(m->lyapunov) || !e->history)
        return;
    while (first > 0 && isfinite(e->history[first - 1].exponent) &&
           isfinite(e->history[first - 1].standard_error))
        first--;
    sheet->course =
        (saltus_course){e->history + first, e->history_count - first, m->lyapunov, m->lyapunov_error};
}

void saltus_sheet_choose_all(saltus_sheet *sheet) {
    enum { few = 50 }; /* periods whose curves and points can still be distinguished */
    const saltus_trajectory *r = sheet->record;
    sheet->rows = sheet->history_rows = r->samples;
    sheet->events = sheet->history_events = r->event_count;
    sheet->strong = r->time[r->samples - 1] - r->time[0] <= few;
    sheet->timed = saltus_system_forced(sheet->system);
    find_ranges(sheet);
}

static void put_contact(saltus_sheet *sheet, double begin, double end, double displacement) {
    fprintf(sheet->page->file, "%.9g %.9g\n%.9g %.9g\n\n", begin, displacement, end, displacement);
    sheet->contacts++;
}

/* Intervals of lasting contact, begin and end of each, clipped to the time history. */
static void put_contacts(saltus_sheet *sheet) {
    const saltus_trajectory *r = sheet->record;
    const double end = r->time[sheet->history_rows - 1],
                 still = 1e-10 * saltus_system_scale(sheet->system)[0],
                 *last = r->states + (sheet->history_rows - 1) * r->dimension;
    fputs("$contacts << EOD\n# tau/T displacement, at the begin and the end of each contact\n",
          sheet->page->file);
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        /* A face may hold throughout the time history, which then has no event of it. */
        bool met = false, holds = sheet->history_events == 0 &&
                                  fabs(saltus_system_gap(sheet->system, f, r->states)) < still &&
                                  fabs(saltus_system_gap(sheet->system, f, last)) < still &&
                                  fabs(r->velocity[sheet->history_rows / 2]) < still;
        double begin = r->time[0], displacement = face.side * face.d;
        for (long long k = 0; k < sheet->history_events; k++) {
            double time = r->time[r->event_rows[k]];
            if (r->events[k].face != f)
                continue;
            displacement = r->displacement[r->event_rows[k]];
            if (r->events[k].kind == SALTUS_STICK)
                begin = time;
            else if (r->events[k].kind == SALTUS_RELEASE && (holds || !met))
                put_contact(sheet, begin, time, displacement);
            holds = r->events[k].kind == SALTUS_STICK;
            met = true;
        }
        if (holds)
            put_contact(sheet, begin, end, displacement);
    }
    fputs("EOD\n", sheet->page->file);
}

static double place(int point) {
    return (double)point / (SALTUS_SHEET_POINTS - 1);
}

/* Largest and smallest displacement at each place over the rows shown. */
static void envelope(const saltus_sheet *sheet, saltus_range range[SALTUS_SHEET_POINTS]) {
    long long stride = 1 + sheet->rows / 4000;
    for (int j = 0; j < SALTUS_SHEET_POINTS; j++) {
        range[j] = (saltus_range){INFINITY, -INFINITY};
        for (long long row = 0; row < sheet->rows; row += stride) {
            const double *state = sheet->record->states + row * sheet->record->dimension;
            saltus_range_add(&range[j], saltus_system_shape(sheet->system, state, place(j)));
        }
    }
}

saltus_range saltus_sheet_shape_range(const saltus_sheet *sheet) {
    saltus_range range[SALTUS_SHEET_POINTS], whole = {0, 0};
    envelope(sheet, range);
    for (int j = 0; j < SALTUS_SHEET_POINTS; j++) {
        saltus_range_add(&whole, range[j].low);
        saltus_range_add(&whole, range[j].high);
    }
    return whole;
}

double saltus_sheet_shape_time(const saltus_sheet *sheet) {
    double end = sheet->record->time[sheet->rows - 1] - sheet->record->time[0];
    return sheet->orbit ? end : fmin(end, 2);
}

/* Shapes at equal time steps over one orbit, or over the first two periods. */
static void put_shapes(const saltus_sheet *sheet) {
    const saltus_trajectory *r = sheet->record;
    saltus_range range[SALTUS_SHEET_POINTS];
    double begin = r->time[0], length = saltus_sheet_shape_time(sheet);
    long long row = 0;
    fputs("$shapes << EOD\n# xi displacement tau/T\n", sheet->page->file);
    for (int k = 0; k < SALTUS_SHEET_SHAPES; k++) {
        double time = begin + length * k / SALTUS_SHEET_SHAPES;
        while (row + 1 < sheet->rows && r->time[row] < time - 1e-9)
            row++;
        for (int j = 0; j < SALTUS_SHEET_POINTS; j++)
            fprintf(sheet->page->file, "%.4f %.6g %.6g\n", place(j),
                    saltus_system_shape(sheet->system, r->states + row * r->dimension, place(j)),
                    r->time[row]);
        fputc('\n', sheet->page->file);
    }
    envelope(sheet, range);
    fputs("EOD\n$envelope << EOD\n# xi smallest largest\n", sheet->page->file);
    for (int j = 0; j < SALTUS_SHEET_POINTS; j++)
        fprintf(sheet->page->file, "%.4f %.6g %.6g\n", place(j), range[j].low, range[j].high);
    fputs("EOD\n", sheet->page->file);
}

void saltus_sheet_record_data(saltus_sheet *sheet) {
    /* Rows of the trajectory; an empty line where the velocity jumps. */
    const saltus_trajectory *r = sheet->record;
    long long event = 0;
    unsigned colours[2 * SALTUS_STOPS_MAX];
    int signs[2 * SALTUS_STOPS_MAX];
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++)
        saltus_sheet_face_look(sheet, f, &colours[f], &signs[f]);
    fputs("$orbit << EOD\n# tau/T displacement velocity\n", sheet->page->file);
    for (long long row = 0; row < sheet->rows; row++) {
        fprintf(sheet->page->file, "%.9g %.9g %.9g\n", r->time[row], r->displacement[row], r->velocity[row]);
        while (event < r->event_count && r->event_rows[event] < row)
            event++;
        if (event < r->event_count && r->event_rows[event] == row && r->events[event].kind != SALTUS_RELEASE)
            fputc('\n', sheet->page->file);
    }
    fputs("EOD\n$history << EOD\n# tau/T displacement\n", sheet->page->file);
    for (long long row = 0; row < sheet->history_rows; row++)
        fprintf(sheet->page->file, "%.9g %.9g\n", r->time[row], r->displacement[row]);
    fputs("EOD\n$jumps << EOD\n# displacement velocity colour, before and after each impact\n",
          sheet->page->file);
    const unsigned faint = sheet->strong ? 0 : 0xd8000000; /* transparency */
    for (long long k = 0; k < sheet->events; k++) {
        long long row = r->event_rows[k];
        if (r->events[k].kind != SALTUS_RELEASE) {
            const unsigned colour = faint | colours[r->events[k].face];
            fprintf(sheet->page->file, "%.9g %.9g %u\n%.9g %.9g %u\n\n", r->displacement[row],
                    r->velocity[row], colour, r->displacement[row + 1], r->velocity[row + 1], colour);
        }
    }
    fputs("EOD\n$impacts << EOD\n# tau/T displacement sign colour\n", sheet->page->file);
    for (long long k = 0; k < sheet->history_events; k++)
        if (r->events[k].kind != SALTUS_RELEASE)
            fprintf(sheet->page->file, "%.9g %.9g %d %u\n", r->time[r->event_rows[k]],
                    r->displacement[r->event_rows[k]], signs[r->events[k].face], colours[r->events[k].face]);
    fputs("EOD\n$impact_map << EOD\n# phase velocity-before side stop\n", sheet->page->file);
    for (long long k = 0; k < sheet->mapped; k++) {
        const saltus_event *mapped = &sheet->section->events[k];
        saltus_face face = saltus_system_face(sheet->system, mapped->face);
        if (mapped->kind != SALTUS_RELEASE)
            fprintf(sheet->page->file, "%.9g %.9g %d %d\n", mapped->time.phase, mapped->velocity_before,
                    face.side, face.stop + 1);
    }
    fputs("EOD\n", sheet->page->file);
    put_contacts(sheet);
    /* Stroboscopic points of the part shown: rows at whole numbers of periods. The end of a closed orbit
     * equals its beginning and is omitted. */
    double point[2];
    fputs("$strobe << EOD\n# displacement velocity tau/T\n", sheet->page->file);
    for (long long k = 0; k < r->strobes && sheet->timed && (double)k < r->time[sheet->rows - 1]; k++) {
        saltus_sheet_strobe(sheet, r, k, point);
        fprintf(sheet->page->file, "%.9g %.9g %lld\n", point[0], point[1], k);
    }
    fputs("EOD\n", sheet->page->file);
}

void saltus_sheet_data(saltus_sheet *sheet) {
    const saltus_motion *m = sheet->motion;
    const saltus_trajectory *r = sheet->record;
    saltus_sheet_record_data(sheet);
    if (saltus_verdict_settled(m->verdict)) {
        fputs("$multipliers << EOD\n# real imaginary\n", sheet->page->file);
        for (int k = 0; k < m->multiplier_count; k++)
            fprintf(sheet->page->file, "%.9g %.9g\n", m->multipliers[k].re, m->multipliers[k].im);
    } else {
        fputs("$section << EOD\n# displacement velocity\n", sheet->page->file);
        for (long long k = 0; k < sheet->section->strobes; k++) {
            double point[2];
            saltus_sheet_strobe(sheet, sheet->section, k, point);
            fprintf(sheet->page->file, "%.9g %.9g\n", point[0], point[1]);
        }
    }
    fputs("EOD\n", sheet->page->file);
    if (saltus_notation_of(sheet->system)->structure == SALTUS_STRUCTURE_LINE)
        put_shapes(sheet);
    else if (saltus_system_dof(sheet->system) > 1) {
        fputs("$masses << EOD\n# x1 x2 tau/T\n", sheet->page->file);
        for (long long row = 0; row < sheet->rows; row++)
            fprintf(sheet->page->file, "%.9g %.9g %.9g\n", r->states[row * r->dimension],
                    r->states[row * r->dimension + 1], r->time[row]);
        fputs("EOD\n", sheet->page->file);
    }
    if (sheet->spectrum) {
        const saltus_spectra_source source = {.system = sheet->system, .spectra = sheet->spectra};
        saltus_spectrum_low_data(&source, sheet->page);
    }
    if (sheet->course.count > 0)
        saltus_course_data(sheet->page, &sheet->course);
}
