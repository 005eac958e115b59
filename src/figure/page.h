/* Private: a page of a figure being drawn: gnuplot's script with its data, in a common style and in the
 * requested size.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_PAGE_H
#define SALTUS_FIGURE_PAGE_H

#include "figure/caption.h"
#include "saltus/figure.h"

#include <stdint.h>

enum { SALTUS_CAPTION_LINES = 8 };

/* The width and height that the panel that lacks most lacks, and the number of rows of panels; `bottom` is
 * that of the last panel. */
typedef struct saltus_lack {
    double width, height, bottom;
    int rows;
} saltus_lack;

/* Lengths on a page are in units such that type of the usual 13 points is 17.3 units high on any page. The
 * default page has 1600 by 1200 units, a column of a journal is 522 units wide. */
typedef struct saltus_page {
    FILE *file; /* gnuplot's script */
    const char *path;
    saltus_figure_options look;
    double width, height;
    bool free_height;           /* no height was requested: the figure chooses it before the page begins */
    double top;                 /* lower edge of the caption */
    saltus_lack lack, *lacking; /* what panels lack, to be written while they are drawn */
    saltus_line caption[SALTUS_CAPTION_LINES]; /* the heading first */
    const char *colour[SALTUS_CAPTION_LINES];
    int caption_lines;
    saltus_line unseen; /* takes lines that are not wanted */
} saltus_page;

/* A rectangle on the page, in units from the lower left corner. */
typedef struct saltus_frame {
    double left, right, bottom, top;
} saltus_frame;

/* The range of an axis. */
typedef struct saltus_range {
    double low, high;
} saltus_range;

/* Extend a range to include a value, or by a fraction of its width on both sides; an empty range gets a width
 * from `scale`. */
void saltus_range_add(saltus_range *range, double value);
void saltus_range_pad(saltus_range *range, double part, double scale);
/* For logarithmic axes of measured values: cut the range off ten decades below the largest value; smaller
 * values are rounding errors. */
void saltus_range_floor(saltus_range *range);

/* Convert between a value and its position in a range, from 0 to 1, on a linear or logarithmic axis. */
double saltus_range_part(saltus_range range, bool logarithmic, double value);
double saltus_range_value(saltus_range range, bool logarithmic, double part);

/* Open an empty page; `look` may be NULL. Errors: those of saltus_figure_check, SALTUS_IO. */
saltus_status saltus_page_open(saltus_page *page, const char *path, const saltus_figure_options *look,
                               saltus_message *message);
/* Write the terminal and the style. A narrow page with free height is made higher for a caption of many
 * lines, up to the height of a journal's page. Caption, data and panels follow. */
void saltus_page_begin(saltus_page *page);
/* Draw the page unless `status` is an error, keep its script if requested, and close it. Returns `status`,
 * SALTUS_BAD_INPUT if its panels have no room, or SALTUS_IO with gnuplot's error message. */
saltus_status saltus_page_close(saltus_page *page, saltus_status status, saltus_message *message);

/* The caption, written before the page begins: the next line of it, to be filled by the caller and left out
 * if it stays empty. Colours must be static strings. */
saltus_line *saltus_page_words(saltus_page *page, const char *colour);
/* The heading, with the program's name in a corner; the first line. A title in `look` replaces it. */
saltus_line *saltus_page_heading(saltus_page *page);
/* The heading, to be filled, above a scene's title, parameters and stops. */
saltus_line *saltus_page_scene(saltus_page *page, const char *title, const saltus_system *system);
/* The height of the caption as it stands. */
double saltus_page_caption_height(saltus_page *page);
/* Draw the caption, after saltus_page_begin. */
void saltus_page_caption(saltus_page *page);

/* Place a legend of `rows` rows below the caption. */
void saltus_page_legend(const saltus_page *page, int rows);

/* Whether the page, such as a column of a journal, is too narrow for panels side by side in the usual
 * type. */
bool saltus_page_narrow(const saltus_page *page);
/* The size of type of about `size` points: on paper, where thirteen are eight points, none is smaller than
 * seven. */
double saltus_page_type(const saltus_page *page, double size);
/* The width of enhanced text in type of `size` points, in units. */
double saltus_page_width(const char *text, double size);
/* The height available for panels below the caption, on the requested page or on a journal's page. */
double saltus_page_room(saltus_page *page);

void saltus_page_graph_label(const saltus_page *page, const saltus_line *text, double x, double y,
                             int decimals, const char *style, ...) __attribute__((format(printf, 6, 7)));

/* The frame of a panel that fills the page from `below` units under the caption. */
saltus_frame saltus_page_rest(const saltus_page *page, double below);
/* The frame of a panel in a grid of columns and rows that occupies `span` columns from `cell` on (counted
 * from the upper left, row by row). */
saltus_frame saltus_page_cell(const saltus_page *page, int cell, int span, int columns, int rows);
/* Set the margins of a panel and write its heading, formatted like printf, after the letter 'a' + letter, in
 * several lines on a narrow page. */
void saltus_page_panel(const saltus_page *page, saltus_frame frame, int letter, const char *heading, ...)
    __attribute__((format(printf, 4, 5)));
/* Set the margins of a panel, which needs at least this height; a page on which a panel lacks room is refused
 * when it is closed. */
void saltus_page_frame(const saltus_page *page, saltus_frame frame, double least);
enum { SALTUS_PANEL_LEAST = 75 }; /* the height of a panel that can be read */
/* A label in enhanced text at a place of the page, or of the panel as parts of its width and height, with so
 * many decimals, and the style of `set label`, formatted like printf. */
void saltus_page_label(const saltus_page *page, const char *text, double x, double y, const char *style, ...)
    __attribute__((format(printf, 5, 6)));
/* Title, range and scale of a panel's axis ("x", "y" or "y2"); on a page of a requested size long titles are
 * set in smaller type. */
void saltus_page_axis(const saltus_page *page, const char *axis, saltus_frame panel, bool logarithmic,
                      const char *name, saltus_range range);
/* A round step that gives at most `tics` tics, and the letters of the longest number at such tics. */
double saltus_page_tic_step(saltus_range range, double tics);
size_t saltus_page_tic_letters(saltus_range range, double step);
/* Set variables of the script for the templates: a number, or a text formatted like printf. */
void saltus_page_number(const saltus_page *page, const char *name, double value);
void saltus_page_text(const saltus_page *page, const char *name, const char *text, ...)
    __attribute__((format(printf, 3, 4)));
/* Write the fixed part of a figure, the template NAME.gp. */
void saltus_page_template(const saltus_page *page, const char *name);
/* The same, followed by a reset of the panel's settings. */
void saltus_page_draw(const saltus_page *page, const char *name);

/* gnuplot.c: run gnuplot on a script (read from its beginning) that draws to standard output. *picture
 * receives the complete output and is the caller's to close. The user's start-up files are not read. Errors:
 * SALTUS_IO with gnuplot's error message; *picture is then NULL. */
saltus_status saltus_gnuplot_run(FILE *script, FILE **picture, saltus_message *message);

/* The templates, in no particular order; generated by the build. */
typedef struct saltus_template {
    const char *name, *text;
} saltus_template;
extern const saltus_template saltus_templates[];
extern const int saltus_template_count;

#endif
