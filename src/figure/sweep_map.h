/* Private: maps of sweeps over two axes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_SWEEP_MAP_H
#define SALTUS_FIGURE_SWEEP_MAP_H

#include "figure/sweep.h"

/* The cells of one axis that a pixel shows; first is -1 where there is none. */
typedef struct saltus_pixel_cells {
    int first, last;
} saltus_pixel_cells;

/* What a map shows at a point, as an entry of its legend. */
typedef struct saltus_map_kind {
    char label[64], figures[48];
    char name[32]; /* written into its regions; "" for none */
    saltus_paint paint;
    double count; /* of its points, as far as their cells are shown */
    int place;    /* in the legend, from 0; -1: it has none */
} saltus_map_kind;

typedef struct saltus_sweep_map {
    saltus_sweep_page *page;
    saltus_raster raster;
    saltus_pixel_cells *columns, *rows; /* per pixel of the raster */
    /* One of each for every point of the grid. */
    int *kind;              /* discrete: index into `kinds` */
    float *number;          /* scalar: what is shown, NAN for nothing; basins: how pale, 0 to 1 */
    unsigned char *several; /* more than one attractor */
    bool any_several;       /* of a point that is shown */
    saltus_map_kind *kinds;
    int kind_count;
    bool shaded;        /* basins are paler where the motion settles soon */
    int legend_rows;    /* of a legend below the map; 0: it stands beside it */
    saltus_range range; /* of the colours */
    bool logarithmic, clipped;
} saltus_sweep_map;

/* Whether a kind is a periodic motion of a map of classes. */
bool saltus_sweep_map_periodic(const saltus_sweep_map *map, int kind);
/* sweep_kinds.c: fill `kinds`, `kind`, `number` and `several`. False when there is no memory. */
bool saltus_sweep_map_classes(saltus_sweep_map *map);
bool saltus_sweep_map_counts(saltus_sweep_map *map);
bool saltus_sweep_map_basins(saltus_sweep_map *map);
/* The orbits of basins as points of the plane: data before the plot, elements in it. */
void saltus_sweep_map_put_orbits(const saltus_sweep_map *map);
void saltus_sweep_map_put_orbit_elements(const saltus_sweep_map *map);

/* sweep_scalar.c: numbers, their colours and the bar that explains them. */
bool saltus_sweep_map_numbers(saltus_sweep_map *map);
uint32_t saltus_sweep_map_colour(const saltus_sweep_map *map, double number);
bool saltus_sweep_map_put_bar(const saltus_sweep_map *map);

#endif
