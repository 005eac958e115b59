/* Private: the columns of a branch file, one table for writing and for reading.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_BRANCH_COLUMNS_H
#define SALTUS_RECORD_BRANCH_COLUMNS_H

#include "record/hdf5.h"
#include "saltus/record.h"

/* What one entry of a column is. */
typedef enum saltus_element {
    SALTUS_ELEMENT_REAL,
    SALTUS_ELEMENT_INT,
    SALTUS_ELEMENT_LONG,
    SALTUS_ELEMENT_FLAG,
    SALTUS_ELEMENT_POINT, /* saltus_point_kind */
    SALTUS_ELEMENT_EVENT, /* saltus_event_kind */
    SALTUS_ELEMENT_LABEL, /* text */
    SALTUS_ELEMENT_REASON
} saltus_element;

/* How many entries a row of a column has. */
typedef enum saltus_width {
    SALTUS_WIDTH_ONE,
    SALTUS_WIDTH_TWO,
    SALTUS_WIDTH_STATE,       /* dimension */
    SALTUS_WIDTH_MULTIPLIERS, /* dimension x 2 */
    SALTUS_WIDTH_PARAMETERS,
    SALTUS_WIDTH_STOPS /* stops x SALTUS_STOP_VALUES */
} saltus_width;

enum { SALTUS_STOP_VALUES = 5 };

/* Numbers that the widths depend on. */
typedef struct saltus_branch_shape {
    int dimension, parameters, stops;
} saltus_branch_shape;

/* One row of /points: a point, and the parts of it that are kept in another form. */
typedef struct saltus_point_row {
    saltus_branch_point point;
    long long event_first;
    double stops[SALTUS_STOPS_MAX][SALTUS_STOP_VALUES];
    double *multipliers, *log_moduli;
} saltus_point_row;

/* One row of /events. */
typedef struct saltus_event_row {
    saltus_event_kind kind;
    int stop, side;
    double time, phase, velocity_before, velocity_after, displacement;
} saltus_event_row;

typedef struct saltus_branch_column {
    const char *name, *units, *description;
    saltus_element element;
    saltus_width width;
    size_t offset; /* into the row */
    bool indirect; /* a pointer to the values stands there */
} saltus_branch_column;

enum { SALTUS_POINT_COLUMNS = 32, SALTUS_EVENT_COLUMNS = 8 };
extern const saltus_branch_column saltus_point_columns[SALTUS_POINT_COLUMNS];
extern const saltus_branch_column saltus_event_columns[SALTUS_EVENT_COLUMNS];

void saltus_column_widths(const saltus_branch_column *column, saltus_branch_shape shape, int width[2]);
/* Bytes of one row of a column in memory. */
size_t saltus_column_bytes(const saltus_branch_column *column, saltus_branch_shape shape);
/* Type of its entries in memory and, when `stored`, in the file; to be closed. */
hid_t saltus_column_type(saltus_h5 *w, const saltus_branch_column *column, bool stored);
/* Where a row keeps the column's values. */
void *saltus_column_values(const saltus_branch_column *column, void *row);

/* The options of a continuation as attributes. */
typedef struct saltus_branch_setting {
    const char *name;
    enum { SALTUS_SETTING_REAL, SALTUS_SETTING_INT, SALTUS_SETTING_KEY } kind;
    size_t offset; /* into saltus_branch_options */
} saltus_branch_setting;

enum { SALTUS_BRANCH_SETTINGS = 19 };
extern const saltus_branch_setting saltus_branch_settings[SALTUS_BRANCH_SETTINGS];

/* The values of a stop in the order of the columns, and back. */
void saltus_stop_values(const saltus_stop *stop, double values[SALTUS_STOP_VALUES]);
void saltus_stop_from_values(const double values[SALTUS_STOP_VALUES], saltus_stop *stop);

#endif
