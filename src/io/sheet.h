/* Private: the parts of a sheet.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_IO_SHEET_H
#define SALTUS_IO_SHEET_H

#include "saltus/io.h"

#include <stddef.h>

typedef struct saltus_range {
    double low, high;
} saltus_range;

typedef struct saltus_sheet {
    FILE *file; /* gnuplot's script */
    const saltus_scene *scene;
    const saltus_system *system;
    const saltus_motion *motion;
    const saltus_record *record;
    bool orbit;         /* one closed orbit is shown; otherwise a stretch of trajectory */
    long long rows;     /* rows of the record that are shown */
    long long events;   /* events that are shown */
    long long recent;   /* first row of the time history */
    long long contacts; /* intervals of lasting contact among what is shown */
    saltus_range displacement, velocity;
} saltus_sheet;

/* sheet_data.c: datablocks of the script; counts the contacts. */
void saltus_sheet_data(saltus_sheet *sheet);
/* Number of impacts shown. */
long long saltus_sheet_impacts(const saltus_sheet *sheet);
/* Whether stop s limits the observed coordinate itself. */
bool saltus_sheet_observes(const saltus_sheet *sheet, int s);
/* Widen a range to hold a value, or by a part of its width; an empty range gets a width from `scale`. */
void saltus_range_add(saltus_range *range, double value);
void saltus_range_pad(saltus_range *range, double part, double scale);
/* Range of the structure's shapes over the rows shown. */
saltus_range saltus_sheet_shape_range(const saltus_sheet *sheet);

/* sheet_caption.c: the header lines, as labels, and the names of axes, in gnuplot's enhanced text. The
 * caption's lower edge, in parts of the page's height. */
double saltus_sheet_caption(const saltus_sheet *sheet);
void saltus_sheet_displacement_name(const saltus_sheet *sheet, char *text, size_t room);
void saltus_sheet_velocity_name(const saltus_sheet *sheet, char *text, size_t room);

enum { SALTUS_SHEET_SHAPES = 16, SALTUS_SHEET_POINTS = 96, SALTUS_SHEET_ROWS_MAX = 60000 };

#endif
