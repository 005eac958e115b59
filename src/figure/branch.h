/* Private: a bifurcation diagram under way.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_BRANCH_H
#define SALTUS_FIGURE_BRANCH_H

#include "figure/caption.h"
#include "figure/gnuplot.h"
#include "saltus/figure.h"

/* Branch files over each other in one pair of axes. */
typedef struct saltus_plot_page {
    FILE *file;                      /* gnuplot's script */
    const saltus_branch_file *files; /* all with the same keys in the same order */
    int count;
    const saltus_system *system; /* of the first file's start */
    bool locus;                  /* a second parameter goes up the page */
    saltus_show show;
    const saltus_plot_options *options;
    saltus_range x, y;
} saltus_plot_page;

/* What a point shows along the page and up it, and whether it is on the page. */
bool saltus_plot_shown(const saltus_plot_page *page, const saltus_branch_point *point);
double saltus_plot_x(const saltus_branch_point *point);
double saltus_plot_y(const saltus_plot_page *page, const saltus_branch_point *point);
/* Speed of an event where it is an impact, otherwise NAN. */
double saltus_impact_speed(const saltus_event *event);

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
enum { SALTUS_STROKES = 3, SALTUS_HUES = 6 };

/* Which hue a branch has: of its kind of special point, of its file where there are several, otherwise of how
 * often it was switched. */
int saltus_plot_hue(const saltus_plot_page *page, int file, int branch);

/* The kind whose mark a kind has: points of codimension two share one, with their names beside it. */
enum { SALTUS_PLOT_MARKS = SALTUS_POINT_CP + 1 };
saltus_point_kind saltus_plot_mark(saltus_point_kind kind);

/* plot_curves.c: elements of a plot command that goes on: curves, marks, and what they are in the legend. */
void saltus_plot_curves(const saltus_plot_page *page);
void saltus_plot_marks(const saltus_plot_page *page);
void saltus_plot_legend(const saltus_plot_page *page);
/* How many things the legend explains. */
int saltus_plot_legend_entries(const saltus_plot_page *page);
/* plot_data.c: the datablocks $curve_HUE_STROKE and $marks_KIND. */
void saltus_plot_data(const saltus_plot_page *page);
/* plot_labels.c: names of regions, n/p along the branches and the names of special points, as gnuplot labels.
 */
void saltus_plot_labels(const saltus_plot_page *page);
/* The rank-th parameter (from 0) in which the files differ, other than those of the axes, as a key of --set;
 * "" where there are not so many. */
void saltus_plot_difference(const saltus_plot_page *page, int rank, char key[SALTUS_KEY_MAX]);
/* Add ", key = value" for each such parameter of a file. */
void saltus_plot_add_differences(const saltus_plot_page *page, int file, saltus_line *line);

#endif
