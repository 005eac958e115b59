/* The numbers of a sheet, as datablocks inside gnuplot's script.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/describe.h"
#include "io/sheet.h"

#include <math.h>
#include <string.h>

void saltus_range_add(saltus_range *range, double value) {
    if (!isfinite(value))
        return;
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

void saltus_range_pad(saltus_range *range, double part, double scale) {
    double width = range->high - range->low, middle = 0.5 * (range->low + range->high);
    double size = fmax(scale, fabs(middle));
    if (!(width > 1e-6 * size)) {
        range->low = middle - size;
        range->high = middle + size;
        width = 2 * size;
    }
    range->low -= part * width;
    range->high += part * width;
}

bool saltus_sheet_observes(const saltus_sheet *sheet, int s) {
    const double *a = saltus_system_stop_normal(sheet->system, s), *b = saltus_system_observer(sheet->system);
    return memcmp(a, b, (size_t)saltus_system_dof(sheet->system) * sizeof *a) == 0;
}

long long saltus_sheet_impacts(const saltus_sheet *sheet) {
    long long count = 0;
    for (long long k = 0; k < sheet->events; k++)
        count += sheet->record->events[k].kind != SALTUS_RELEASE;
    return count;
}

/* Rows of the trajectory; an empty line where the velocity jumps. */
static void put_rows(const saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    long long event = 0;
    fputs("$orbit << EOD\n# tau/T displacement velocity\n", sheet->file);
    for (long long row = 0; row < sheet->rows; row++) {
        fprintf(sheet->file, "%.9g %.9g %.9g\n", r->time[row], r->displacement[row], r->velocity[row]);
        while (event < r->event_count && r->event_rows[event] < row)
            event++;
        if (event < r->event_count && r->event_rows[event] == row && r->events[event].kind != SALTUS_RELEASE)
            fputc('\n', sheet->file);
    }
    fputs("EOD\n$history << EOD\n# tau/T displacement\n", sheet->file);
    for (long long row = sheet->recent; row < sheet->rows; row++)
        fprintf(sheet->file, "%.9g %.9g\n", r->time[row], r->displacement[row]);
    fputs("EOD\n", sheet->file);
}

static void put_impacts(const saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    fputs("$jumps << EOD\n# displacement velocity, before and after each impact\n", sheet->file);
    for (long long k = 0; k < sheet->events; k++) {
        long long row = r->event_rows[k];
        if (r->events[k].kind != SALTUS_RELEASE)
            fprintf(sheet->file, "%.9g %.9g\n%.9g %.9g\n\n", r->displacement[row], r->velocity[row],
                    r->displacement[row + 1], r->velocity[row + 1]);
    }
    fputs("EOD\n$impacts << EOD\n# tau/T displacement phase velocity-before side stop\n", sheet->file);
    for (long long k = 0; k < sheet->events; k++) {
        const saltus_event *event = &r->events[k];
        saltus_face face = saltus_system_face(sheet->system, event->face);
        if (event->kind != SALTUS_RELEASE)
            fprintf(sheet->file, "%.9g %.9g %.9g %.9g %d %d\n", r->time[r->event_rows[k]],
                    r->displacement[r->event_rows[k]], event->time.phase, event->velocity_before, face.side,
                    face.stop + 1);
    }
    fputs("EOD\n", sheet->file);
}

static void put_contact(saltus_sheet *sheet, double begin, double end, double displacement) {
    fprintf(sheet->file, "%.9g %.9g\n%.9g %.9g\n\n", begin, displacement, end, displacement);
    sheet->contacts++;
}

/* Whether a face holds throughout what is shown, so that no event tells of it. */
static bool holds_throughout(const saltus_sheet *sheet, int f) {
    const saltus_record *r = sheet->record;
    double scale = 1e-10 * saltus_system_scale(sheet->system)[0];
    return sheet->events == 0 && fabs(saltus_system_gap(sheet->system, f, r->states)) < scale &&
           fabs(saltus_system_gap(sheet->system, f, r->states + (sheet->rows - 1) * r->dimension)) < scale &&
           fabs(r->velocity[sheet->rows / 2]) < scale;
}

/* Intervals of lasting contact: begin and end of each, cut off at the ends of what is shown. */
static void put_contacts(saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    double end = r->time[sheet->rows - 1];
    fputs("$contacts << EOD\n# tau/T displacement, at the begin and the end of each contact\n", sheet->file);
    for (int f = 0; f < saltus_system_face_count(sheet->system); f++) {
        saltus_face face = saltus_system_face(sheet->system, f);
        bool holds = holds_throughout(sheet, f), met = false;
        double begin = r->time[0], displacement = face.side * face.d;
        for (long long k = 0; k < sheet->events; k++) {
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
    fputs("EOD\n", sheet->file);
}

/* Stroboscopic points of what is shown: rows whose time is a whole number of periods. The end of a closed
 * orbit is its begin. */
static void put_strobes(const saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    const double *observer = saltus_system_observer(sheet->system);
    int n = saltus_system_dof(sheet->system);
    fputs("$strobe << EOD\n# displacement velocity tau/T\n", sheet->file);
    for (long long k = 0; k < r->strobes && (double)k < r->time[sheet->rows - 1]; k++) {
        const double *state = r->strobe_states + k * r->dimension;
        double x = 0, v = 0;
        for (int i = 0; i < n; i++) {
            x += observer[i] * state[i];
            v += observer[i] * state[n + i];
        }
        fprintf(sheet->file, "%.9g %.9g %lld\n", x, v, k);
    }
    fputs("EOD\n", sheet->file);
}

static void put_multipliers(const saltus_sheet *sheet) {
    fputs("$multipliers << EOD\n# real imaginary\n", sheet->file);
    for (int k = 0; k < sheet->motion->multiplier_count; k++)
        fprintf(sheet->file, "%.9g %.9g\n", sheet->motion->multipliers[k].re,
                sheet->motion->multipliers[k].im);
    fputs("EOD\n", sheet->file);
}

static double place(int point) {
    return (double)point / (SALTUS_SHEET_POINTS - 1);
}

/* Largest and smallest displacement at each place over the rows shown. */
static void envelope(const saltus_sheet *sheet, saltus_range range[SALTUS_SHEET_POINTS]) {
    long long stride = 1 + (sheet->rows - sheet->recent) / 4000;
    for (int j = 0; j < SALTUS_SHEET_POINTS; j++) {
        range[j] = (saltus_range){INFINITY, -INFINITY};
        for (long long row = sheet->recent; row < sheet->rows; row += stride) {
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

/* Shapes at equal distances of time over one orbit, or over the last two periods. */
static void put_shapes(const saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    saltus_range range[SALTUS_SHEET_POINTS];
    double end = r->time[sheet->rows - 1];
    double begin = sheet->orbit ? r->time[0] : fmax(r->time[sheet->recent], end - 2);
    long long row = 0;
    fputs("$shapes << EOD\n# xi displacement tau/T\n", sheet->file);
    for (int k = 0; k < SALTUS_SHEET_SHAPES; k++) {
        double time = begin + (end - begin) * k / SALTUS_SHEET_SHAPES;
        while (row + 1 < sheet->rows && r->time[row] < time - 1e-9)
            row++;
        for (int j = 0; j < SALTUS_SHEET_POINTS; j++)
            fprintf(sheet->file, "%.4f %.6g %.6g\n", place(j),
                    saltus_system_shape(sheet->system, r->states + row * r->dimension, place(j)),
                    r->time[row]);
        fputc('\n', sheet->file);
    }
    envelope(sheet, range);
    fputs("EOD\n$envelope << EOD\n# xi smallest largest\n", sheet->file);
    for (int j = 0; j < SALTUS_SHEET_POINTS; j++)
        fprintf(sheet->file, "%.4f %.6g %.6g\n", place(j), range[j].low, range[j].high);
    fputs("EOD\n", sheet->file);
}

/* Displacements of two masses, a row each. */
static void put_masses(const saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    fputs("$masses << EOD\n# x1 x2 tau/T\n", sheet->file);
    for (long long row = 0; row < sheet->rows; row++)
        fprintf(sheet->file, "%.9g %.9g %.9g\n", r->states[row * r->dimension],
                r->states[row * r->dimension + 1], r->time[row]);
    fputs("EOD\n", sheet->file);
}

/* Displacement against the phase of the forcing; an empty line where the phase starts anew. */
static void put_folded(const saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    fputs("$folded << EOD\n# phase displacement\n", sheet->file);
    for (long long row = 0; row < sheet->rows; row++) {
        double whole = floor(r->time[row]);
        if (row && r->time[row] == whole)
            fprintf(sheet->file, "1 %.9g\n\n", r->displacement[row]);
        fprintf(sheet->file, "%.9g %.9g\n", r->time[row] - whole, r->displacement[row]);
    }
    fputs("EOD\n", sheet->file);
}

void saltus_sheet_data(saltus_sheet *sheet) {
    put_rows(sheet);
    put_impacts(sheet);
    put_contacts(sheet);
    put_strobes(sheet);
    put_multipliers(sheet);
    if (saltus_is_pipe(sheet->system))
        put_shapes(sheet);
    else if (saltus_system_dof(sheet->system) > 1)
        put_masses(sheet);
    put_folded(sheet);
}
