/* Private: maps of sweeps over two axes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_SWEEP_MAP_H
#define SALTUS_FIGURE_SWEEP_MAP_H

#include "figure/sweep.h"

/* The cells of one axis shown by a pixel; first = -1: none. */
typedef struct saltus_pixel_cells {
    int first, last;
} saltus_pixel_cells;

/* One kind of result on a map, and its legend entry. */
typedef struct saltus_map_kind {
    char label[64], figures[48];
    char name[32]; /* written into its regions; "" for none */
    saltus_paint paint;
    double count; /* number of its points, each weighted by the visible fraction of its cell */
    int place;    /* in the legend, from 0; -1: left out */
} saltus_map_kind;

typedef struct saltus_sweep_map {
    saltus_sweep_page *page;
    saltus_raster raster;
    saltus_pixel_cells *columns, *rows; /* per pixel column and row of the raster */
    /* One entry for each point of the grid: */
    int *kind;     /* discrete maps: index into `kinds` */
    float *number; /* numeric maps: the number shown, NAN for none; basins: fraction of white, 0 to 1 */
    unsigned char *several; /* whether the point has more than one attractor */
    bool any_several;       /* at a visible point */
    saltus_map_kind *kinds;
    int kind_count;
    bool shaded;        /* basins are paler where the motion settles faster */
    int legend_rows;    /* of a legend below the map; 0: the legend is beside it */
    saltus_range range; /* of the colour scale */
    bool logarithmic, clipped;
} saltus_sweep_map;

/* Whether a kind is a periodic motion on a map of classes. */
bool saltus_sweep_map_periodic(const saltus_sweep_map *map, int kind);
/* sweep_kinds.c: find what the view shows: `kinds`, `kind` and `several`, or `number` with its range. False
 * if out of memory. */
bool saltus_sweep_map_open(saltus_sweep_map *map);

#endif
