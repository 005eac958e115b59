/* Pictures made of pixels, and their colours.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/raster.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool saltus_raster_open(saltus_raster *raster, int width, int height) {
    width = width > 0 ? width : 1;
    height = height > 0 ? height : 1;
    *raster = (saltus_raster){.width = width, .height = height};
    raster->pixels = calloc((size_t)width * (size_t)height, 4);
    return raster->pixels != NULL;
}

void saltus_raster_close(saltus_raster *raster) {
    free(raster->pixels);
    *raster = (saltus_raster){0};
}

static unsigned char *pixel_at(const saltus_raster *raster, int x, int y) {
    return raster->pixels + 4 * ((size_t)y * (size_t)raster->width + (size_t)x);
}

static unsigned char part_of(uint32_t colour, int k) {
    return (unsigned char)(colour >> (16 - 8 * k) & 0xff);
}

void saltus_raster_set(saltus_raster *raster, int x, int y, uint32_t colour, double opacity) {
    unsigned char *pixel = pixel_at(raster, x, y);
    for (int k = 0; k < 3; k++)
        pixel[k] = part_of(colour, k);
    pixel[3] = (unsigned char)lround(255 * opacity);
}

void saltus_raster_element(FILE *script, const saltus_raster *raster, const char *axes) {
    fprintf(script,
            "'-' binary array=(%d,%d) dx=1 dy=1 origin=(0.5,0.5) format='%%uchar%%uchar%%uchar%%uchar' "
            "using 1:2:3:4 axes %s with rgbalpha notitle",
            raster->width, raster->height, axes);
}

void saltus_raster_bytes(FILE *script, const saltus_raster *raster) {
    fwrite(raster->pixels, 4, (size_t)raster->width * (size_t)raster->height, script);
}

long long saltus_raster_changes(const saltus_raster *raster) {
    long long count = 0;
    for (int y = 0; y < raster->height; y++)
        for (int x = 1; x < raster->width; x++) {
            const unsigned char *pixel = pixel_at(raster, x, y);
            count += memcmp(pixel, pixel - 4, 4) != 0;
        }
    return count;
}

/* Convert an Oklab colour to linear red, green and blue; returns whether a screen can show it. */
static bool linear_of(double lightness, double chroma, double hue, double linear[3]) {
    double degree = acos(-1.0) / 180, a = chroma * cos(hue * degree), b = chroma * sin(hue * degree);
    double l = lightness + 0.3963377774 * a + 0.2158037573 * b,
           m = lightness - 0.1055613458 * a - 0.0638541728 * b,
           s = lightness - 0.0894841775 * a - 1.2914855480 * b;
    l = l * l * l;
    m = m * m * m;
    s = s * s * s;
    linear[0] = 4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s;
    linear[1] = -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s;
    linear[2] = -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s;
    bool shown = true;
    for (int k = 0; k < 3; k++)
        shown = shown && linear[k] > -1e-4 && linear[k] < 1 + 1e-4;
    return shown;
}

uint32_t saltus_colour(double lightness, double chroma, double hue) {
    double linear[3];
    uint32_t colour = 0;
    lightness = fmin(fmax(lightness, 0), 1);
    for (int k = 0; k < 40 && !linear_of(lightness, chroma, hue, linear); k++)
        chroma *= 0.95;
    for (int k = 0; k < 3; k++) {
        double c = fmin(fmax(linear[k], 0), 1);
        c = c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
        colour = colour << 8 | (uint32_t)lround(255 * c);
    }
    return colour;
}

uint32_t saltus_colour_mix(uint32_t a, uint32_t b, double part) {
    uint32_t mixed = 0;
    for (int k = 0; k < 3; k++)
        mixed = mixed << 8 | (uint32_t)lround((1 - part) * part_of(a, k) + part * part_of(b, k));
    return mixed;
}

/* Interpolate at a fraction `part` of a list of equally spaced colours. */
static uint32_t between(const uint32_t *list, int count, double part) {
    double place = fmin(fmax(part, 0), 1) * (count - 1);
    int k = place >= count - 1 ? count - 2 : (int)place;
    return saltus_colour_mix(list[k], list[k + 1], place - k);
}

uint32_t saltus_colour_ramp(double part) {
    static const uint32_t viridis[] = {0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c,
                                       0x22a884, 0x44bf70, 0x7ad151, 0xbddf26, 0xfde725};
    return between(viridis, sizeof viridis / sizeof viridis[0], part);
}

uint32_t saltus_colour_sides(double part) {
    static const uint32_t sides[] = {0x123f75, 0x2f6fae, 0x76a9d3, 0xb9d5e8, 0xf4f2ee,
                                     0xf6cfa4, 0xe8964f, 0xc25d17, 0x7d3205};
    return between(sides, sizeof sides / sizeof sides[0], part);
}

bool saltus_colour_light(uint32_t colour) {
    return 0.299 * part_of(colour, 0) + 0.587 * part_of(colour, 1) + 0.114 * part_of(colour, 2) > 140;
}
