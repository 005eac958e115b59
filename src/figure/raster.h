/* Private: pictures made of pixels, which gnuplot embeds into axes drawn as vectors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_RASTER_H
#define SALTUS_FIGURE_RASTER_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* Four bytes per pixel (red, green, blue, opacity), lowest row first. */
typedef struct saltus_raster {
    int width, height;
    unsigned char *pixels;
} saltus_raster;

/* A transparent raster of at least one pixel; false if out of memory. */
bool saltus_raster_open(saltus_raster *raster, int width, int height);
void saltus_raster_close(saltus_raster *raster);
/* A colour is 0xRRGGBB. */
void saltus_raster_set(saltus_raster *raster, int x, int y, uint32_t colour, double opacity);
/* Write one element of a plot command that fills the named axes, whose ranges must be [0:width] and
 * [0:height]; saltus_raster_bytes must follow after the command's line. */
void saltus_raster_element(FILE *script, const saltus_raster *raster, const char *axes);
void saltus_raster_bytes(FILE *script, const saltus_raster *raster);
/* Number of pixels that differ from their left neighbour, a measure of the compressed file's size. */
long long saltus_raster_changes(const saltus_raster *raster);

/* A colour of given lightness (0 to 1), chroma and hue (degrees) in Ottosson's Oklab, where equal steps look
 * equal; chroma is reduced as far as a screen needs. */
uint32_t saltus_colour(double lightness, double chroma, double hue);
/* Colours for numbers from 0 to 1: from dark to light, and diverging from a middle at 1/2. */
uint32_t saltus_colour_ramp(double part);
uint32_t saltus_colour_sides(double part);
/* Interpolate between two colours; part 0 is the first. */
uint32_t saltus_colour_mix(uint32_t a, uint32_t b, double part);
/* Whether black letters are easier to read on this colour than white ones. */
bool saltus_colour_light(uint32_t colour);

#endif
