/* Private: pictures made of pixels, which gnuplot sets into axes of lines and letters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_RASTER_H
#define SALTUS_FIGURE_RASTER_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* Four bytes a pixel (red, green, blue, opacity), the lowest row first. */
typedef struct saltus_raster {
    int width, height;
    unsigned char *pixels;
} saltus_raster;

/* A transparent raster of a pixel at least; false when there is no memory. */
bool saltus_raster_open(saltus_raster *raster, int width, int height);
void saltus_raster_close(saltus_raster *raster);
/* A colour is 0xRRGGBB. */
void saltus_raster_set(saltus_raster *raster, int x, int y, uint32_t colour, double opacity);
/* One element of a plot command, filling the axes named, whose ranges must be [0:width] and [0:height]. The
 * bytes must follow after the command's line. */
void saltus_raster_element(FILE *script, const saltus_raster *raster, const char *axes);
void saltus_raster_bytes(FILE *script, const saltus_raster *raster);
/* How many pixels differ from their left neighbour: what a compressed file grows with. */
long long saltus_raster_changes(const saltus_raster *raster);

/* The colour of that lightness (0 to 1), chroma and hue (degrees) in Ottosson's Oklab, in which equal steps
 * look equal; the chroma is lowered where a screen cannot show it. */
uint32_t saltus_colour(double lightness, double chroma, double hue);
/* Colours for numbers from 0 to 1: dark to light, and two sides of a middle at 1/2. */
uint32_t saltus_colour_ramp(double part);
uint32_t saltus_colour_sides(double part);
/* Between two colours: the first one at part 0. */
uint32_t saltus_colour_mix(uint32_t a, uint32_t b, double part);
/* Whether black letters are easier to read on it than white ones. */
bool saltus_colour_light(uint32_t colour);

/* Points counted per pixel; each counts as its share of the points of its trajectory. */
typedef struct saltus_tally {
    int width, height;
    float *cover;  /* how much of the pixel is covered by points */
    float *weight; /* parts of all points in it, spread as they cover pixels */
} saltus_tally;

bool saltus_tally_open(saltus_tally *tally, int width, int height);
void saltus_tally_close(saltus_tally *tally);
/* A point from `left` to `right` around height `y`, `thick` pixels high; edges need not be whole numbers. */
void saltus_tally_add(saltus_tally *tally, double left, double right, double y, double thick, double part);
/* Paint the tally: opacity grows with the logarithm of the density, so that single points of a long
 * trajectory stay visible and places visited often are dark. */
void saltus_tally_paint(const saltus_tally *tally, uint32_t colour, saltus_raster *raster);

#endif
