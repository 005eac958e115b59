/* The numbers of a sheet: which ones are shown, and their datablocks in gnuplot's script.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sheet.h"
#include "record/describe.h"

#include <math.h>

enum { shapes = 16, places = 96 }; /* drawn of the structure, and along it */

long long saltus_sheet_impacts(const saltus_trajectory *record, long long events) {
    long long count = 0;
    for (long long k = 0; k < events; k++)
        count += record->events[k].kind != SALTUS_RELEASE;
    return count;
}

/* How each side of a stop is drawn, and the ranges of the phase portrait, extended to stops near the motion.
 */
static void find_faces(saltus_sheet *sheet) {
    /* None is the blue of the trajectory, in which a jump of the velocity could not be told from motion. */
    static const unsigned colours[] = {0xc44e2a, 0x1f9e89, 0x8a5aa0, 0xb08a00,
                                       0x1c1c1c, 0x4aa3c7, 0xa03060, 0x94b447};
    enum { count = sizeof colours / sizeof colours[0] };
    const saltus_trajectory *r = sheet->section ? sheet->section : sheet->record;
    const long long events = sheet->section ? sheet->mapped : sheet->events;
    int shown = 0;
    sheet->face_count = saltus_system_face_count(sheet->system);
    for (int f = 0; f < sheet->face_count; f++) {
        const saltus_face own = saltus_system_face(sheet->system, f);
        saltus_sheet_face *face = &sheet->faces[f];
        *face = (saltus_sheet_face){.stop = own.stop,
                                    .side = own.side,
                                    .place = own.side * own.d,
                                    .observed = saltus_system_stop_observed(sheet->system, own.stop),
                                    .hit = sheet->face_count <= count,
                                    .colour = colours[shown % count]};
        for (long long k = 0; k < events && !face->hit; k++)
            face->hit = r->events[k].face == f && r->events[k].kind != SALTUS_RELEASE &&
                        r->events[k].velocity_before != 0;
        /* Once all colours are used they repeat with open signs. */
        face->sign = (own.side > 0 ? 9 : 11) - shown / count % 2;
        shown += face->hit;
    }
    const double *scale = saltus_system_scale(sheet->system);
    saltus_range x = {INFINITY, -INFINITY}, v = x;
    for (long long row = 0; row < sheet->rows; row++) {
        saltus_range_add(&x, sheet->record->displacement[row]);
        saltus_range_add(&v, sheet->record->velocity[row]);
    }
    const double width = x.high - x.low;
    for (int f = 0; f < sheet->face_count; f++) {
        const double d = sheet->faces[f].place;
        if (sheet->faces[f].observed && d > x.low - 0.6 * width && d < x.high + 0.6 * width)
            saltus_range_add(&x, d);
    }
    saltus_range_pad(&x, 0.07, scale[0]);
    saltus_range_pad(&v, 0.07, scale[saltus_system_dof(sheet->system)]);
    sheet->displacement = x;
    sheet->velocity = v;
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
    find_faces(sheet);
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
    find_faces(sheet);
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
    for (int f = 0; f < sheet->face_count; f++) {
        /* A face may hold throughout the time history, which then has no event of it. */
        bool met = false, holds = sheet->history_events == 0 &&
                                  fabs(saltus_system_gap(sheet->system, f, r->states)) < still &&
                                  fabs(saltus_system_gap(sheet->system, f, last)) < still &&
                                  fabs(r->velocity[sheet->history_rows / 2]) < still;
        double begin = r->time[0], displacement = sheet->faces[f].place;
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

bool saltus_sheet_timed(const saltus_sheet *sheet) {
    return sheet->motion || saltus_system_forced(sheet->system);
}

double saltus_sheet_shape_time(const saltus_sheet *sheet) {
    const double end = sheet->record->time[sheet->rows - 1] - sheet->record->time[0];
    return sheet->orbit ? end : fmin(end, 2);
}

/* Shapes at equal time steps over one orbit, or over the first two periods, and the largest and the smallest
 * displacement at each place over the rows shown. */
static void put_shapes(saltus_sheet *sheet) {
    const saltus_trajectory *r = sheet->record;
    FILE *file = sheet->page->file;
    const double length = saltus_sheet_shape_time(sheet);
    long long row = 0;
    sheet->shape = (saltus_range){0, 0};
    fputs("$shapes << EOD\n# xi displacement tau/T\n", file);
    for (int k = 0; k < shapes; k++) {
        const double time = r->time[0] + length * k / shapes;
        while (row + 1 < sheet->rows && r->time[row] < time - 1e-9)
            row++;
        for (int j = 0; j < places; j++) {
            const double place = (double)j / (places - 1);
            fprintf(file, "%.4f %.6g %.6g\n", place,
                    saltus_system_shape(sheet->system, r->states + row * r->dimension, place), r->time[row]);
        }
        fputc('\n', file);
    }
    fputs("EOD\n$envelope << EOD\n# xi smallest largest\n", file);
    for (int j = 0; j < places; j++) {
        const double place = (double)j / (places - 1);
        saltus_range swept = {INFINITY, -INFINITY};
        for (row = 0; row < sheet->rows; row += 1 + sheet->rows / 4000)
            saltus_range_add(&swept,
                             saltus_system_shape(sheet->system, r->states + row * r->dimension, place));
        fprintf(file, "%.4f %.6g %.6g\n", place, swept.low, swept.high);
        saltus_range_add(&sheet->shape, swept.low);
        saltus_range_add(&sheet->shape, swept.high);
    }
    fputs("EOD\n", file);
}

void saltus_sheet_record_data(saltus_sheet *sheet) {
    /* Rows of the trajectory; an empty line where the velocity jumps. */
    const saltus_trajectory *r = sheet->record;
    FILE *file = sheet->page->file;
    long long event = 0;
    fputs("$orbit << EOD\n# tau/T displacement velocity\n", file);
    for (long long row = 0; row < sheet->rows; row++) {
        fprintf(file, "%.9g %.9g %.9g\n", r->time[row], r->displacement[row], r->velocity[row]);
        while (event < r->event_count && r->event_rows[event] < row)
            event++;
        if (event < r->event_count && r->event_rows[event] == row && r->events[event].kind != SALTUS_RELEASE)
            fputc('\n', file);
    }
    fputs("EOD\n$history << EOD\n# tau/T displacement\n", file);
    for (long long row = 0; row < sheet->history_rows; row++)
        fprintf(file, "%.9g %.9g\n", r->time[row], r->displacement[row]);
    fputs("EOD\n$jumps << EOD\n# displacement velocity colour, before and after each impact\n", file);
    const unsigned faint = sheet->strong ? 0 : 0xd8000000; /* transparency */
    for (long long k = 0; k < sheet->events; k++) {
        const long long row = r->event_rows[k];
        const unsigned colour = faint | sheet->faces[r->events[k].face].colour;
        if (r->events[k].kind != SALTUS_RELEASE)
            fprintf(file, "%.9g %.9g %u\n%.9g %.9g %u\n\n", r->displacement[row], r->velocity[row], colour,
                    r->displacement[row + 1], r->velocity[row + 1], colour);
    }
    fputs("EOD\n$impacts << EOD\n# tau/T displacement sign colour\n", file);
    for (long long k = 0; k < sheet->history_events; k++) {
        const saltus_sheet_face *face = &sheet->faces[r->events[k].face];
        if (r->events[k].kind != SALTUS_RELEASE)
            fprintf(file, "%.9g %.9g %d %u\n", r->time[r->event_rows[k]], r->displacement[r->event_rows[k]],
                    face->sign, face->colour);
    }
    fputs("EOD\n$impact_map << EOD\n# phase velocity-before side stop\n", file);
    for (long long k = 0; k < sheet->mapped; k++) {
        const saltus_event *mapped = &sheet->section->events[k];
        const saltus_sheet_face *face = &sheet->faces[mapped->face];
        if (mapped->kind != SALTUS_RELEASE)
            fprintf(file, "%.9g %.9g %d %d\n", mapped->time.phase, mapped->velocity_before, face->side,
                    face->stop + 1);
    }
    fputs("EOD\n", file);
    put_contacts(sheet);
    /* Stroboscopic points of the part shown: rows at whole numbers of periods. The end of a closed orbit
     * equals its beginning and is omitted. */
    double point[2];
    fputs("$strobe << EOD\n# displacement velocity tau/T\n", file);
    for (long long k = 0; k < r->strobes && saltus_sheet_timed(sheet) && (double)k < r->time[sheet->rows - 1];
         k++) {
        saltus_sheet_strobe(sheet, r, k, point);
        fprintf(file, "%.9g %.9g %lld\n", point[0], point[1], k);
    }
    fputs("EOD\n", file);
}

void saltus_sheet_data(saltus_sheet *sheet) {
    const saltus_motion *m = sheet->motion;
    const saltus_trajectory *r = sheet->record;
    FILE *file = sheet->page->file;
    saltus_sheet_record_data(sheet);
    if (saltus_verdict_settled(m->verdict)) {
        fputs("$multipliers << EOD\n# real imaginary\n", file);
        for (int k = 0; k < m->multiplier_count; k++)
            fprintf(file, "%.9g %.9g\n", m->multipliers[k].re, m->multipliers[k].im);
    } else {
        fputs("$section << EOD\n# displacement velocity\n", file);
        for (long long k = 0; k < sheet->section->strobes; k++) {
            double point[2];
            saltus_sheet_strobe(sheet, sheet->section, k, point);
            fprintf(file, "%.9g %.9g\n", point[0], point[1]);
        }
    }
    fputs("EOD\n", file);
    if (saltus_notation_of(sheet->system)->structure == SALTUS_STRUCTURE_LINE)
        put_shapes(sheet);
    else if (saltus_system_dof(sheet->system) > 1) {
        fputs("$masses << EOD\n# x1 x2 tau/T\n", file);
        for (long long row = 0; row < sheet->rows; row++)
            fprintf(file, "%.9g %.9g %.9g\n", r->states[row * r->dimension],
                    r->states[row * r->dimension + 1], r->time[row]);
        fputs("EOD\n", file);
    }
    if (sheet->spectra)
        saltus_spectrum_low_data(sheet->page, sheet->spectra);
    if (sheet->course.count > 0)
        saltus_course_data(sheet->page, &sheet->course);
}
