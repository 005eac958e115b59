/* Private: a figure of a sweep while it is being drawn.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_SWEEP_H
#define SALTUS_FIGURE_SWEEP_H

#include "figure/branch.h"
#include "figure/raster.h"

/* The values of an axis in ascending order, each with a cell that reaches half way to its neighbours. Places
 * are values, or their logarithms where these are equally spaced. */
typedef struct saltus_cells {
    const char *key;
    bool logarithmic;
    int count;
    int *order;         /* the axis's index of each cell */
    double *edge;       /* places: cell k lies between edge[k] and edge[k + 1] */
    saltus_range range; /* of values, what is shown */
} saltus_cells;

/* Places are logarithms where the axis is so, or where that is asked for and all values are positive. */
bool saltus_cells_open(saltus_cells *cells, const saltus_axis *axis, bool logarithmic);
void saltus_cells_close(saltus_cells *cells);
/* Where a value lies in the range shown, from 0 to 1, and the value there. */
double saltus_cells_part(const saltus_cells *cells, double value);
double saltus_cells_value(const saltus_cells *cells, double part);
/* The edge k as a part of the range shown. */
double saltus_cells_edge(const saltus_cells *cells, int k);
/* The cells that a pixel out of `pixels` shows: those with their middle in it, or the one that it lies in.
 * False when there is none. */
bool saltus_cells_at(const saltus_cells *cells, int pixels, int pixel, int *first, int *last);

/* Textures, as bits: what tells colours apart that look alike to those who do not see red. */
enum { SALTUS_DOTS = 1, SALTUS_BARS = 2, SALTUS_POSTS = 4 };

/* How a class is painted. */
typedef struct saltus_paint {
    uint32_t colour;
    unsigned texture;
} saltus_paint;

/* One look for a motion in all figures, by its verdict and n/p alone (impacts -1: complete chatter): the hue
 * and the texture tell the period, the lightness the number of impacts. SALTUS_BEYOND is a verdict, too: a
 * start beyond a stop. */
enum { SALTUS_BEYOND = SALTUS_VERDICTS };
saltus_paint saltus_class_paint(int verdict, int impacts, int periods);
/* The colour at a place of the page, in units, of what is painted so. */
uint32_t saltus_paint_at(saltus_paint paint, int x, int y);

/* A class of rows with the same motion: n/p, held, ... */
typedef struct saltus_sweep_class {
    char label[32];
    int verdict, impacts, periods;
    double share; /* of all rows */
    saltus_paint paint;
} saltus_sweep_class;

typedef struct saltus_classes {
    saltus_sweep_class *list; /* the most frequent first */
    int count;
    int *of_row;
} saltus_classes;

bool saltus_classes_open(saltus_classes *classes, const saltus_sweep_file *sweep);
void saltus_classes_close(saltus_classes *classes);

typedef struct saltus_sweep_page {
    saltus_page paper;
    const saltus_sweep_file *sweep;
    const saltus_sweep_view *wish;
    const char *path, *figure;
    saltus_view view;
    const saltus_system *system;
    saltus_cells x, y; /* of the first axis and, on maps, of the second */
    saltus_range up;   /* of the numbers shown: up the page, or as colours */
    bool logarithmic;  /* `up` is a logarithmic axis */
    bool asked;        /* `up` is the range that was asked for */
    bool sides;        /* impact speeds are signed */
    double *observers; /* rows that give the observed displacement: one, or one for each value of the axis */
    int observer_count;
    saltus_classes classes;
    saltus_frame frame;
    const saltus_plot_page *branches; /* over a diagram, or NULL */
} saltus_sweep_page;

/* Word of a view, as of --view. */
const char *saltus_view_word(saltus_view view);
/* Whether a view shows clouds of points: over one axis only. */
bool saltus_view_is_cloud(saltus_view view);
/* The number that a view tells of a row; NAN where there is none. */
double saltus_sweep_measure(saltus_view view, const saltus_sweep_row *row);
/* Whether all directions are lost anywhere: an exponent of -infinity. */
bool saltus_sweep_any_lost(const saltus_sweep_page *page);
/* The verdict of a row; SALTUS_BEYOND where it failed because the scene's start is beyond a stop there. */
int saltus_sweep_verdict(const saltus_sweep_file *sweep, long long row);
/* The point at a cell of each axis of a map, and how much of its cell is shown, from 0 to 1. */
long long saltus_sweep_point(const saltus_sweep_page *page, int column, int row);
double saltus_sweep_shown(const saltus_sweep_page *page, int column, int row);
/* The rows of a point: the k-th of passes times seeds. */
int saltus_sweep_visits(const saltus_sweep_file *sweep);
long long saltus_sweep_visit(const saltus_sweep_file *sweep, long long point, int k);
/* The class that most of a point's rows have, those not computed left aside; *several: it has more than one
 * attractor. */
int saltus_sweep_class_at(const saltus_sweep_page *page, long long point, bool *several);

/* sweep_page.c: words. */
void saltus_sweep_caption(saltus_sweep_page *page);
void saltus_sweep_name_measure(const saltus_sweep_page *page, saltus_line *line);
/* Ranges of the second axes for a raster of that size. */
void saltus_sweep_put_raster_ranges(FILE *file, int width, int height);
/* Range, scale, tics and name of an axis ("x" or "y"). */
void saltus_sweep_put_axis(const saltus_sweep_page *page, const char *axis, const saltus_cells *cells);
/* A square of paint with words beside it, as an entry of a legend, and figures at its right end; hatched with
 * lines where asked for. The entry's width in units goes to the figures' end. */
void saltus_sweep_put_entry(const saltus_sweep_page *page, double x, double y, saltus_paint paint,
                            bool hatched, const char *text, const char *figures);
/* Words for a class in a legend. */
void saltus_sweep_word_class(const saltus_sweep_file *sweep, const saltus_sweep_class *c, char label[64]);
/* Pixels of a raster for each unit of the page. */
int saltus_sweep_fineness(const saltus_sweep_page *page);

/* sweep_cloud.c, sweep_strip.c, sweep_map.c: the figures. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_sweep_put_diagram(saltus_sweep_page *page, saltus_message *message);
saltus_status saltus_sweep_put_map(saltus_sweep_page *page, saltus_message *message);
/* The classes along the axis, one band for each pass, with labels; the strip's panel is drawn whole. */
bool saltus_sweep_put_strip(const saltus_sweep_page *page, saltus_frame frame);
/* The classes that occur in what is shown and have too little room in the strip for their names, in a legend
 * from a height down, if it is to be drawn; the height of its rows. False when there is no memory. */
bool saltus_sweep_put_strip_legend(const saltus_sweep_page *page, saltus_frame strip, double top, bool drawn,
                                   double *height);

#endif
