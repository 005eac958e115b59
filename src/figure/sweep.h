/* Private: a figure of a sweep being drawn.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_SWEEP_H
#define SALTUS_FIGURE_SWEEP_H

#include "figure/branch.h"
#include "figure/raster.h"

/* The values of an axis in ascending order, each with a cell that extends halfway to its neighbours. Cell
 * edges are values, or logarithms of values on a logarithmic axis. */
typedef struct saltus_cells {
    const char *key;
    bool logarithmic;
    int count;
    int *order;         /* the axis's index of each cell */
    double *edge;       /* cell k lies between edge[k] and edge[k + 1] */
    saltus_range range; /* the values shown */
    int first, end;     /* the cells whose values are shown */
} saltus_cells;

/* The axis is logarithmic if it is spaced so or if requested, and all values are positive. */
bool saltus_cells_open(saltus_cells *cells, const saltus_axis *axis, bool logarithmic);
void saltus_cells_close(saltus_cells *cells);
/* Convert between a value and its position in the range shown, from 0 to 1. */
double saltus_cells_part(const saltus_cells *cells, double value);
double saltus_cells_value(const saltus_cells *cells, double part);
/* The position of edge k in the range shown. */
double saltus_cells_edge(const saltus_cells *cells, int k);
/* The cells shown by one of `pixels` pixels: those with their middle in it, otherwise the one that contains
 * it. False if there is none. */
bool saltus_cells_at(const saltus_cells *cells, int pixels, int pixel, int *first, int *last);

/* Textures, as bits; they distinguish colours that look alike without red. */
enum { SALTUS_DOTS = 1, SALTUS_BARS = 2, SALTUS_POSTS = 4 };

/* How a class is painted. */
typedef struct saltus_paint {
    uint32_t colour;
    unsigned texture;
} saltus_paint;

/* The paint of a motion, the same in all figures. It depends only on verdict and n/p (impacts -1: complete
 * chatter): hue and texture show the period, lightness the number of impacts. */
saltus_paint saltus_class_paint(int verdict, int impacts, int periods);
/* The colour of a paint at a place of the page, in units. */
uint32_t saltus_paint_at(saltus_paint paint, int x, int y);

/* A class of rows with the same motion: n/p, held, ... */
typedef struct saltus_sweep_class {
    char label[32];
    int verdict, impacts, periods;
    int first;    /* its place in the order in which the rows meet the classes */
    double share; /* of all rows */
    saltus_paint paint;
} saltus_sweep_class;

typedef struct saltus_classes {
    saltus_sweep_class *list; /* the most frequent first */
    int count;
    int *of_row;
} saltus_classes;

/* The classes of all rows; false without memory. To be closed also then. */
bool saltus_classes_open(saltus_classes *classes, const saltus_sweep_file *sweep);
void saltus_classes_close(saltus_classes *classes);

typedef struct saltus_sweep_page {
    saltus_page paper;
    const saltus_sweep_file *sweep;
    const saltus_sweep_view *wish;
    const char *path;
    saltus_view view;
    const saltus_system *system;
    saltus_cells x, y; /* the first axis and, on maps, the second */
    saltus_range up;   /* range of the numbers shown, on the vertical axis or as colours */
    bool logarithmic;  /* `up` is a logarithmic axis */
    bool asked;        /* the caller requested the range `up` */
    long long shown;   /* points of a cloud that are shown */
    long long below;   /* numbers at or below 0, which a logarithmic axis does not reach */
    bool sides;        /* impact speeds are signed */
    bool swap;         /* diagrams: the parameter is vertical */
    double *observers; /* rows that map displacements to the observed one: a single row, or one for each value
                          of the axis */
    int observer_count;
    saltus_classes classes;
    saltus_frame frame;
    saltus_plot_page over; /* branches, of no or some files, and labels drawn over the figure */
} saltus_sweep_page;

/* The word of a view in --view. */
const char *saltus_view_word(saltus_view view);
/* Whether a view shows clouds of points, which need a single axis. */
bool saltus_view_is_cloud(saltus_view view);
/* The number that a view shows for a row; NAN if there is none. */
double saltus_sweep_measure(saltus_view view, const saltus_sweep_row *row);
/* Whether any row has the exponent -infinity because all directions are lost. */
bool saltus_sweep_any_lost(const saltus_sweep_page *page);
/* The grid point at a cell of each axis of a map, and the fraction of its cell that is shown, from 0 to 1. */
long long saltus_sweep_point(const saltus_sweep_page *page, int column, int row);
double saltus_sweep_shown(const saltus_sweep_page *page, int column, int row);
/* The number of rows of a grid point, passes times seeds, and the k-th of them. */
int saltus_sweep_visits(const saltus_sweep_file *sweep);
long long saltus_sweep_visit(const saltus_sweep_file *sweep, long long point, int k);

/* sweep_page.c: texts and legend entries. */
void saltus_sweep_caption(saltus_sweep_page *page);
void saltus_sweep_name_measure(const saltus_sweep_page *page, saltus_line *line);
/* Ranges of the second axes for a raster of this size. */
void saltus_sweep_put_raster_ranges(FILE *file, int width, int height);
/* Range, scale, tics and title of an axis ("x" or "y"). */
void saltus_sweep_put_axis(const saltus_sweep_page *page, const char *axis, const saltus_cells *cells);
/* A legend entry: a square of paint, hatched if requested, with text beside it and figures at the right
 * end. */
void saltus_sweep_put_entry(const saltus_sweep_page *page, double x, double y, saltus_paint paint,
                            bool hatched, const char *text, const char *figures);
/* The text of a class in a legend. */
void saltus_sweep_word_class(const saltus_sweep_class *c, char label[64]);
/* Pixels of a raster per page unit. */
int saltus_sweep_fineness(const saltus_sweep_page *page);

/* sweep_cloud.c, sweep_strip.c, sweep_map.c: the figures. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_sweep_put_diagram(saltus_sweep_page *page, saltus_message *message);
saltus_status saltus_sweep_put_map(saltus_sweep_page *page, saltus_message *message);
/* The classes along the axis as a strip with names, one band per pass, as a complete panel. */
bool saltus_sweep_put_strip(const saltus_sweep_page *page, saltus_frame frame);
/* A legend for the classes shown whose names did not fit into a strip as long as `frame`, from `top`
 * downwards and as wide as that; drawn only if `drawn`. Returns the height of its rows; -1: no memory. */
double saltus_sweep_put_strip_legend(const saltus_sweep_page *page, saltus_frame frame, double top,
                                     bool drawn);

#endif
