/* Private: a bifurcation diagram under way.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_BRANCH_H
#define SALTUS_FIGURE_BRANCH_H

#include "figure/page.h"

/* A value that an orbit shows when it passes somewhere: the speed of an impact, the displacement where it
 * turns. */
typedef struct saltus_plot_visit {
    double time, value; /* time in periods from phase 0 */
    int face;           /* that is hit; -1: none */
} saltus_plot_visit;

/* The visits of a point of a branch. */
typedef struct saltus_plot_visits {
    saltus_plot_visit *list;
    int count;
} saltus_plot_visits;

/* Branch files over each other in one pair of axes. */
typedef struct saltus_plot_page {
    const saltus_page *paper;
    saltus_frame frame;              /* of the panel */
    const saltus_branch_file *files; /* all with the same keys in the same order */
    int count;
    const saltus_system *system; /* of the first file's start */
    bool locus;                  /* a second parameter goes up the page */
    bool turning;                /* displacements where orbits turn, in place of what `show` says */
    bool amplitude;              /* of those the largest and the smallest of each orbit */
    bool swap;                   /* the parameter goes up the page and what is shown of orbits across it */
    bool over_map;               /* curves lie on colours, from which a rim lifts them off */
    bool logarithmic[2];         /* across the page, up it */
    saltus_show show;
    const saltus_plot_options *options;
    saltus_range x, y;
    saltus_plot_visits **visits; /* where orbits show several values: of each file's points, otherwise NULL */
} saltus_plot_page;

/* What a point shows across the page and up it, and whether its parameters are on the page. */
bool saltus_plot_shown(const saltus_plot_page *page, const saltus_branch_point *point);
double saltus_plot_x(const saltus_plot_page *page, const saltus_branch_point *point);
double saltus_plot_y(const saltus_plot_page *page, const saltus_branch_point *point);
/* A place of the axes in the page's units from the panel's lower left corner. */
void saltus_plot_place(const saltus_plot_page *page, double x, double y, double place[2]);
/* How far a place is from the chord between two others. */
double saltus_plot_distance(const double at[2], const double a[2], const double b[2]);
/* Find the visits where impacts or turning points are shown; the caller frees them. Errors: those of the flow
 * along orbits, SALTUS_NO_MEMORY. */
saltus_status saltus_plot_find_visits(saltus_plot_page *page, saltus_message *message);
void saltus_plot_free_visits(saltus_plot_page *page);
/* The range of the first parameter, or of what goes with it (`measure`), over the points that are shown. */
saltus_range saltus_plot_range(const saltus_plot_page *page, bool measure);
/* Whether an axis with that key is to be logarithmic. */
bool saltus_plot_logarithmic(const saltus_figure_options *look, const char *key);
/* What was asked for of a key's range; NULL: nothing. */
const saltus_plot_part *saltus_plot_part_of(const saltus_plot_part *parts, int count, const char *key);
/* Exchange the two parameters of a curve of special points. */
void saltus_plot_turn(saltus_branch_file *file);

/* Whether a point is marked: on a curve of special points those that make it are not, and no end that was to
 * be expected. The point is one of the file's. */
bool saltus_plot_marked(const saltus_branch_file *file, const saltus_branch_point *point);

/* How a curve is drawn between two points. A curve of special points is stable where it bounds stable orbits:
 * where no multiplier is outside the unit circle but those that make the point special. */
typedef enum saltus_stroke {
    SALTUS_STROKE_STABLE,
    SALTUS_STROKE_UNSTABLE,
    SALTUS_STROKE_FOREIGN
} saltus_stroke;
enum { SALTUS_STROKES = 3, SALTUS_HUES = 7 };

/* The visit of a file's point k + 1 that goes on from visit v of point k; -1: none. */
int saltus_plot_partner(const saltus_plot_page *page, int file, int k, int v);

/* How a curve goes on from a point to the next one of its branch. */
saltus_stroke saltus_plot_stroke(const saltus_branch_file *file, int from, int to);

/* Which hue a branch has: of its kind of special point, of its file where there are several, otherwise of how
 * often it was switched. */
int saltus_plot_hue(const saltus_plot_page *page, int file, int branch);
/* The kind of special point that a hue of curves of such points is of. */
saltus_point_kind saltus_plot_locus(int hue);

/* The kind whose mark a kind has: points of codimension two share one, with their names beside it. */
enum { SALTUS_PLOT_MARKS = SALTUS_POINT_CP + 1 };
saltus_point_kind saltus_plot_mark(saltus_point_kind kind);

/* branch_curves.c: elements of a plot command that goes on: curves, marks, and what they are in the legend.
 */
void saltus_plot_elements(const saltus_plot_page *page);
/* The height of a legend's rows on a page of that width, and how many there are, unless that is NULL. */
double saltus_plot_legend_height(const saltus_plot_page *page, double width, int *rows);
/* Ask for a legend below the caption; the height of its rows. */
double saltus_plot_legend_place(const saltus_plot_page *page);
/* branch_data.c: the datablocks $curve_HUE_STROKE, $marks_KIND and, along curves of special points,
 * $signs_HUE. */
bool saltus_plot_data(const saltus_plot_page *page);
/* branch_labels.c: names of regions, n/p along the branches and the names of special points, as gnuplot
 * labels. Where names, marks and curves are is told to `block`, unless that is NULL, in units from the
 * panel's lower left corner. */
typedef void saltus_plot_block(void *context, saltus_frame taken);
void saltus_plot_labels(const saltus_plot_page *page, saltus_plot_block *block, void *context);
/* The k-th value of a system, of the parameters first, then of each stop; false beyond the last. */
typedef struct saltus_plot_value {
    char key[SALTUS_KEY_MAX]; /* of --set */
    double value;
    bool on_axis; /* it is what one of the axes ("": none) goes over */
} saltus_plot_value;
bool saltus_plot_value_of(const saltus_spec *spec, int k, const char *const axes[2], saltus_plot_value *v);
/* The rank-th parameter (from 0) in which the files differ, other than those of the axes, as a key of --set;
 * "" where there are not so many. */
void saltus_plot_difference(const saltus_plot_page *page, int rank, char key[SALTUS_KEY_MAX]);
/* Add ", key = value" for each such parameter of a file. */
void saltus_plot_add_differences(const saltus_plot_page *page, int file, saltus_line *line);

#endif
