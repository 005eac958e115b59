/* Private: the parts of a sheet, and panels that other figures share with it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_SHEET_H
#define SALTUS_FIGURE_SHEET_H

#include "figure/page.h"

#include <stddef.h>

/* convergence.c: how the estimate of the largest exponent converged. */
/* The history of an estimate and its final value; owned by the caller. */
typedef struct saltus_course {
    const saltus_lyapunov_progress *history;
    int count;
    double exponent, standard_error;
} saltus_course;

/* Write the datablock $convergence: time, exponent, standard error. It must precede the panel in the
 * script. */
void saltus_course_data(const saltus_page *page, const saltus_course *course);
/* Draw the panel in a frame, with its key above the right end; the caller adds a heading. Leaves no gnuplot
 * settings behind for the next panel. */
void saltus_course_panel(const saltus_page *page, const saltus_system *system, const saltus_course *course,
                         saltus_frame frame);

/* spectrum.c. */
/* The low frequencies of the first spectrum, which must not be constant, as a panel of another figure: its
 * datablock $low1, and the panel in a frame with a heading after the letter 'a' + letter. Leaves no gnuplot
 * settings behind for the next panel. */
void saltus_spectrum_low_data(const saltus_page *page, const saltus_spectra *spectra);
void saltus_spectrum_low_panel(const saltus_page *page, const saltus_spectra *spectra, saltus_frame frame,
                               int letter, const saltus_line *heading);
/* Whether any line above a continuum is strong enough to be marked. */
bool saltus_spectrum_has_strong_lines(const saltus_spectrum *spectrum);

/* A side of a stop as it is drawn. */
typedef struct saltus_sheet_face {
    int stop, side;  /* as in saltus_face */
    double place;    /* its clearance, with the sign of its side */
    bool observed;   /* it limits the observed displacement */
    bool hit;        /* its impacts have a look; of few faces all have one */
    unsigned colour; /* of its impacts */
    int sign;        /* gnuplot's for them: a triangle that points to its side */
} saltus_sheet_face;

typedef struct saltus_sheet {
    const saltus_page *page;
    const saltus_system *system;
    const saltus_motion *motion;
    const saltus_trajectory *record;
    const saltus_trajectory *section; /* source of section points and impact map */
    const saltus_spectra *spectra;    /* the first is shown; NULL: none, or it is constant */
    saltus_course course;     /* of the largest exponent, finite numbers only; count 0: not measured */
    bool orbit;               /* shows one closed orbit; otherwise a stretch of trajectory */
    bool strong;              /* few, distinguishable curves, drawn with strong lines */
    long long rows;           /* rows of the record that are shown */
    long long events;         /* events among the rows shown */
    long long history_rows;   /* rows of the time history, from the first one on */
    long long history_events; /* events of the time history */
    long long mapped;         /* events of `section` in the impact map */
    long long contacts;       /* intervals of lasting contact in the time history */
    saltus_range displacement, velocity;
    saltus_range shape; /* of the structure's shapes over the rows shown */
    saltus_sheet_face faces[2 * SALTUS_STOPS_MAX];
    int face_count;
} saltus_sheet;

/* sheet_data.c: choose what is shown of a motion, or show a whole record. */
void saltus_sheet_choose(saltus_sheet *sheet);
void saltus_sheet_choose_all(saltus_sheet *sheet);
/* Write the data as datablocks of the script; counts the contacts and measures the shapes. */
void saltus_sheet_data(saltus_sheet *sheet);
/* Only the data of portrait and history. */
void saltus_sheet_record_data(saltus_sheet *sheet);
/* Whether time is in forcing periods, with a point at the beginning of each, as on every sheet. */
bool saltus_sheet_timed(const saltus_sheet *sheet);
/* The periods over which the structure's shapes are spread. */
double saltus_sheet_shape_time(const saltus_sheet *sheet);
/* Number of impacts among the first `events` events of a record. */
long long saltus_sheet_impacts(const saltus_trajectory *record, long long events);
/* Observed displacement and velocity of stroboscopic point k of a record. */
void saltus_sheet_strobe(const saltus_sheet *sheet, const saltus_trajectory *record, long long k,
                         double point[2]);
/* sheet_caption.c: the header lines, in gnuplot's enhanced text. */
void saltus_sheet_caption(const saltus_sheet *sheet, const saltus_scene *scene, saltus_page *page);

#endif
