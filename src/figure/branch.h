/* Private: a bifurcation diagram being drawn.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_BRANCH_H
#define SALTUS_FIGURE_BRANCH_H

#include "figure/page.h"

/* How a curve is drawn between two points. A locus is drawn as stable where it bounds stable orbits: no
 * multiplier is outside the unit circle except those that make the point special. */
typedef enum saltus_stroke {
    SALTUS_STROKE_STABLE,
    SALTUS_STROKE_UNSTABLE,
    SALTUS_STROKE_FOREIGN
} saltus_stroke;
enum { SALTUS_STROKES = 3, SALTUS_HUES = 7 };

/* One of the values that a diagram shows of a point: several are the speeds of all impacts of an orbit, or
 * the displacements at its turning points. */
typedef struct saltus_plot_visit {
    double time, value; /* time in periods from phase 0 */
    int face;           /* of the impact; -1: none */
    int next;           /* the visit of the next row that continues this one; -1: none */
    bool begins;        /* no visit of the row before leads to this one */
} saltus_plot_visit;

/* A point of a branch as it is drawn. */
typedef struct saltus_plot_row {
    const saltus_branch_point *point;
    int file;
    /* By kind on loci, by file if there are several, otherwise by the number of switches that led here. */
    int hue;
    double x, y;          /* its mark, as values of the axes */
    bool marked;          /* not marked are points of a locus' own kind and ends at the limits of the range */
    bool joined;          /* to the next row, which is of the same branch */
    saltus_stroke stroke; /* to the next row */
    saltus_plot_visit *visits;
    int count;     /* of visits */
    int strongest; /* which event is the largest impact; -1: there is none */
} saltus_plot_row;

/* Branch files drawn over each other in one pair of axes. */
typedef struct saltus_plot_page {
    const saltus_page *paper;
    saltus_frame frame;              /* of the panel */
    const saltus_branch_file *files; /* all with the same keys in the same order */
    int count;
    const saltus_system *system; /* of the first file's start */
    bool locus;                  /* loci over two parameters */
    bool turning;                /* displacements at turning points instead of `show` */
    bool swap;                   /* exchange the axes: the parameter is vertical */
    bool rests, orbits, cycles;  /* there are equilibria; orbits; orbits with their own periods */
    bool over_sweep;             /* drawn over a map or a cloud: names get a white ground, loci a white rim */
    bool logarithmic[2];         /* horizontal and vertical axis */
    saltus_show show;
    const saltus_plot_options *options; /* NULL: drawn over a sweep */
    const saltus_plot_label *labels;
    int label_count;
    const char *keys[2]; /* what the horizontal and the vertical axis show, as a label's place calls it */
    saltus_range x, y;
    saltus_plot_row *rows; /* the points of all files */
    int row_count;
} saltus_plot_page;

/* branch_rows.c: make the rows of all files; free them with saltus_plot_close. Errors: SALTUS_NO_MEMORY,
 * those of building systems and flows. */
saltus_status saltus_plot_open(saltus_plot_page *page, saltus_message *message);
void saltus_plot_close(saltus_plot_page *page);
/* Whether the parameters of a row lie in the ranges shown. */
bool saltus_plot_shown(const saltus_plot_page *page, const saltus_plot_row *row);
/* Whether also the numbers of a row count for the axis of what is measured. At a grazing point the speed is a
 * rounding error, which no logarithmic axis has to reach. */
bool saltus_plot_measured(const saltus_plot_page *page, const saltus_plot_row *row);
/* Convert coordinates of the axes, or a visit of a row, into page units from the panel's lower left corner.
 */
void saltus_plot_place(const saltus_plot_page *page, double x, double y, double place[2]);
void saltus_plot_place_visit(const saltus_plot_page *page, const saltus_plot_row *row, int v,
                             double place[2]);
/* Distance of a place from the segment between two others. */
double saltus_plot_distance(const double at[2], const double a[2], const double b[2]);
/* The range of the first parameter, or of the other coordinate (`measure`), over all points shown. */
saltus_range saltus_plot_range(const saltus_plot_page *page, bool measure);
/* The kind of special point whose locus has this hue. */
saltus_point_kind saltus_plot_locus(int hue);

/* The k-th value of a system: first the parameters, then the values of each stop, then the sides of each;
 * false beyond the last. */
typedef struct saltus_plot_value {
    char key[SALTUS_KEY_MAX]; /* of --set */
    double value;
    int stop;     /* -1: a parameter */
    bool sides;   /* the sides of a stop */
    bool on_axis; /* an axis ("": none) varies it */
} saltus_plot_value;
bool saltus_plot_value_of(const saltus_spec *spec, int k, const char *const axes[2], saltus_plot_value *v);
/* The rank-th value (from 0) in which the files differ, other than those of the axes, as a key of --set;
 * "" if there are fewer. */
void saltus_plot_difference(const saltus_plot_page *page, int rank, char key[SALTUS_KEY_MAX]);
/* Add ", key = value" for each parameter in which the files differ, and the sides of stops if they do;
 * branches of equal systems are told apart by the number of their file. */
void saltus_plot_add_differences(const saltus_plot_page *page, int file, saltus_line *line);
/* Exchange the two parameters of a locus. */
void saltus_plot_turn(saltus_branch_file *file);
/* Whether the axis of this key is to be logarithmic. */
bool saltus_plot_logarithmic(const saltus_figure_options *look, const char *key);
/* The range requested for a key; NULL: none. */
const saltus_plot_part *saltus_plot_part_of(const saltus_plot_part *parts, int count, const char *key);
/* branch_curves.c: elements of an open plot command: curves, marks, and their legend entries. */
void saltus_plot_elements(const saltus_plot_page *page);
/* The legend below the caption, for a panel of this width: the height of its rows, which are written only if
 * `put`. */
double saltus_plot_legend(const saltus_plot_page *page, double width, bool put);
/* branch_data.c: the datablocks $curve_HUE_STROKE, $marks_KIND and, for loci, $signs_HUE. */
bool saltus_plot_data(const saltus_plot_page *page);
/* branch_labels.c: check that the labels asked for have their places in what the axes show. */
saltus_status saltus_plot_check_labels(const saltus_plot_page *page, saltus_message *message);
/* Names of regions, n/p along the branches and names of special points, as gnuplot labels.
 * If `block` is not NULL it is called with the frame of each name, mark and curve, in units from the panel's
 * lower left corner. */
typedef void saltus_plot_block(void *context, saltus_frame taken);
void saltus_plot_labels(const saltus_plot_page *page, saltus_plot_block *block, void *context);

#endif
