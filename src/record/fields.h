/* Private: what is told of each kind of result, once for all forms of files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_FIELDS_H
#define SALTUS_RECORD_FIELDS_H

#include "base/field.h"
#include "saltus/record.h"

/* A point of a branch, as a row of /points. Lengths refer to the counts below. */
typedef struct saltus_point_row {
    saltus_branch_point point;
    long long event_first;
} saltus_point_row;
enum { SALTUS_COUNT_DIMENSION, SALTUS_COUNT_PARAMETERS, SALTUS_COUNT_STOPS };
extern const saltus_field_table saltus_point_fields;

/* An event of an orbit or a trajectory, as a row of /events. */
typedef struct saltus_event_row {
    saltus_event_kind kind; /* impact, stick or release */
    int stop, side;
    double time, phase, velocity_before, velocity_after, displacement;
    long long row; /* trajectories: just before it */
} saltus_event_row;
/* Those of branches lack the last one. */
extern const saltus_field_table saltus_event_fields, saltus_trajectory_event_fields;
/* What JSON tells of an event, and of the touch of a point of a branch (saltus_point_row). */
extern const saltus_field_table saltus_told_event_fields, saltus_grazing_fields;
/* The face of a stop, counted from 1, on a side; -1: there is none. */
int saltus_face_of(const saltus_system *system, int stop, int side);
saltus_event_row saltus_event_row_of(const saltus_system *system, const saltus_event *event);
/* The event of a row that was read; false when there is no such face or time. */
bool saltus_event_of_row(const saltus_system *system, const saltus_event_row *row, saltus_event *event);

/* What JSON tells of any motion (saltus_motion) that a single value tells. */
extern const saltus_field_table saltus_motion_fields;
/* What JSON tells of a motion without a period (saltus_evidence), of Lyapunov exponents beside the exponents
 * themselves (saltus_lyapunov; the counts are its dimension and its members), and of a line of a spectrum
 * (saltus_spectral_line). */
enum { SALTUS_COUNT_MEMBERS = 1 };
extern const saltus_field_table saltus_evidence_fields, saltus_exponent_fields, saltus_spectral_line_fields;
/* Of saltus_spectrum: what is told of every kind, of those that move, of lines, of densities. */
extern const saltus_field_table saltus_spectrum_fields[4];

/* Samples of a trajectory, and its stroboscopic points. */
extern const saltus_field_table saltus_sample_fields, saltus_strobe_fields;

/* A trajectory of a sweep, and what is computed from it when it is written. */
typedef struct saltus_sweep_line {
    saltus_sweep_row row;
    char label[SALTUS_LABEL_MAX];
} saltus_sweep_line;
/* As written, and those that are read back. */
extern const saltus_field_table saltus_line_fields, saltus_row_fields;
/* An int for each point of a pass: the number of distinct attractors. */
extern const saltus_field_table saltus_distinct_fields;

/* What is kept beside the rows: of each row entries first ... first + count - 1. */
typedef struct saltus_span {
    long long first, count;
} saltus_span;
extern const saltus_field_table saltus_span_fields;
enum { SALTUS_CLOUDS = 3 };
typedef struct saltus_cloud_kind {
    const char *group, *description;
    unsigned keep;
    saltus_field_table fields; /* of an entry: a double, an impact, a state */
    size_t bytes;              /* of an entry; 0: those of a state */
} saltus_cloud_kind;
extern const saltus_cloud_kind saltus_clouds[SALTUS_CLOUDS];

/* The entries of a cloud of a file, and which are each row's; all NULL where they were not kept. sweep_csv.c
 */
typedef struct saltus_sweep_entries {
    const long long *first, *count;
    const void *values;
} saltus_sweep_entries;
saltus_sweep_entries saltus_sweep_entries_of(const saltus_sweep_file *file, int cloud);

/* An attractor of basins; first and count are of its points. */
typedef struct saltus_attractor_row {
    char label[SALTUS_LABEL_MAX];
    long long impacts, periods, stable, first, count;
    double largest_multiplier;
} saltus_attractor_row;
extern const saltus_field_table saltus_attractor_fields, saltus_attractor_point_fields;

#endif
