/* Private: the values of each kind of result, described once for all file formats.
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
enum { SALTUS_COUNT_DIMENSION, SALTUS_COUNT_PARAMETERS, SALTUS_COUNT_STOPS, SALTUS_COUNT_OBSERVED };
extern const saltus_field_table saltus_point_fields;

/* An event of an orbit or a trajectory, as a row of /events. */
typedef struct saltus_event_row {
    saltus_event_kind kind; /* impact, stick or release */
    int stop, side;
    double time, phase, velocity_before, velocity_after, displacement;
    long long row; /* trajectories: the sample just before it */
} saltus_event_row;
/* Events of branches have no `row`. */
extern const saltus_field_table saltus_event_fields, saltus_trajectory_event_fields;
/* Index of the face on a side of a stop, which is counted from 1; -1: none. */
int saltus_face_of(const saltus_system *system, int stop, int side);
saltus_event_row saltus_event_row_of(const saltus_system *system, const saltus_event *event);
/* Turn a row that was read into an event; false if its face or time is invalid. */
bool saltus_event_of_row(const saltus_system *system, const saltus_event_row *row, saltus_event *event);

/* JSON members of a motion without a period (saltus_evidence), and of Lyapunov exponents except the exponents
 * themselves (saltus_lyapunov; counts: dimension and members). */
enum { SALTUS_COUNT_MEMBERS = 1 };
extern const saltus_field_table saltus_evidence_fields, saltus_exponent_fields;

/* Samples of a trajectory, and its stroboscopic points. */
extern const saltus_field_table saltus_sample_fields, saltus_strobe_fields;

/* A row of a sweep, with values that are computed when it is written. */
typedef struct saltus_sweep_line {
    saltus_sweep_row row;
    char label[SALTUS_LABEL_MAX];
} saltus_sweep_line;
/* As written, and the part that is read back. */
extern const saltus_field_table saltus_line_fields, saltus_row_fields;
/* One int for each point of a pass: the number of distinct attractors. */
extern const saltus_field_table saltus_distinct_fields;

/* The entries of a row in a cloud: first ... first + count - 1. */
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

/* A cloud of a file: its entries, and those of each row; all NULL if it was not kept. In sweep_csv.c. */
typedef struct saltus_sweep_entries {
    const long long *first, *count;
    const void *values;
} saltus_sweep_entries;
saltus_sweep_entries saltus_sweep_entries_of(const saltus_sweep_file *file, int cloud);

/* An attractor of basins; first and count refer to its points. */
typedef struct saltus_attractor_row {
    char label[SALTUS_LABEL_MAX];
    long long impacts, periods, stable, first, count;
    double largest_multiplier;
} saltus_attractor_row;
extern const saltus_field_table saltus_attractor_fields, saltus_attractor_point_fields;

#endif
