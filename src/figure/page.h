/* Private: a page of a figure under way: gnuplot's script with its data, in one style and of the size asked
 * for.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_PAGE_H
#define SALTUS_FIGURE_PAGE_H

#include "figure/caption.h"
#include "saltus/figure.h"

#include <stdint.h>

enum { SALTUS_CAPTION_LINES = 8 };

/* Lengths on a page are in units of which a letter of the usual size takes 17.3 in height, whatever the size
 * of the page: one of 1600 by 1200 units is the usual one, a column of a journal has 522. */
typedef struct saltus_page {
    FILE *file; /* gnuplot's script */
    const char *path;
    saltus_figure_options look;
    double width, height;
    bool free_height; /* no height was asked for: the figure chooses it before the page begins */
    double top;       /* lower edge of the caption */
    saltus_line caption[SALTUS_CAPTION_LINES]; /* the heading first */
    const char *colour[SALTUS_CAPTION_LINES];
    int caption_lines;
} saltus_page;

/* A rectangle of the page in its units, from the lower left corner. */
typedef struct saltus_frame {
    double left, right, bottom, top;
} saltus_frame;

/* The numbers that an axis goes over. */
typedef struct saltus_range {
    double low, high;
} saltus_range;

/* Widen a range to hold a value, or by a part of its width; an empty range gets a width from `scale`. */
void saltus_range_add(saltus_range *range, double value);
void saltus_range_pad(saltus_range *range, double part, double scale);
/* The range of a logarithmic axis of measured values ends ten decades below the largest: less is rounding. */
void saltus_range_floor(saltus_range *range);

/* Where a value lies in a range, from 0 to 1, by logarithms where it is of a logarithmic axis, and the value
 * there. */
double saltus_range_part(saltus_range range, bool logarithmic, double value);
double saltus_range_value(saltus_range range, bool logarithmic, double part);

/* A page without anything on it; `look` NULL: the usual one. Errors: those of the check, SALTUS_IO. */
saltus_status saltus_page_open(saltus_page *page, const char *path, const saltus_figure_options *look,
                               saltus_message *message);
/* The terminal and the style. A narrow page whose height is free, on which a caption has many lines, is given
 * room for it, and no page more than a journal has. What comes after is the caption, data and panels. */
void saltus_page_begin(saltus_page *page);
/* Draw the page unless `status` is an error, keep its script where that is asked for, and close it. Returns
 * `status` or SALTUS_IO with gnuplot's complaint. */
saltus_status saltus_page_close(saltus_page *page, saltus_status status, saltus_message *message);

/* The caption, told before the page begins: the figure's heading, with the name of the program in a corner,
 * and lines below it. All of it is left out where no heading is wanted; a title that was asked for stands in
 * place of the figure's own. Colours are static. */
void saltus_page_heading(saltus_page *page, const saltus_line *own);
void saltus_page_words(saltus_page *page, const saltus_line *line, const char *colour);
/* The heading, and below it a scene's title, parameters and stops. */
void saltus_page_scene(saltus_page *page, const saltus_line *own, const char *title,
                       const saltus_system *system);
/* Put it, once the page has begun. */
void saltus_page_caption(saltus_page *page);

/* Ask for a legend of so many rows below the caption. */
void saltus_page_legend(const saltus_page *page, int rows);

/* Whether a page is too narrow for panels beside each other in the usual type: a column of a journal. */
bool saltus_page_narrow(const saltus_page *page);
/* The height for panels below the caption: of the page asked for, or of a journal's. */
double saltus_page_room(const saltus_page *page);

/* What is left of the page for a panel that stays that far below the caption. */
saltus_frame saltus_page_rest(const saltus_page *page, double below);
/* The frame of a panel in a grid of so many columns and rows, from a cell (from the upper left, row by row)
 * on over so many columns. */
saltus_frame saltus_page_cell(const saltus_page *page, int cell, int span, int columns, int rows);
/* Place the panel, with a heading behind the letter ('a' + letter), in several lines where the page is
 * narrow.
 */
void saltus_page_panel(const saltus_page *page, saltus_frame frame, int letter, const char *heading);
/* Place the panel; where there is no room for it the script ends with a sentence that says so. */
void saltus_page_frame(const saltus_page *page, saltus_frame frame);
/* A label at a place of the page, as text and style of `set label`. */
void saltus_page_label(const saltus_page *page, const char *text, double x, double y, const char *style);
/* Name and range of an axis ("x", "y" or "y2") of a panel, perhaps a logarithmic one; on a page of a size
 * asked for a long name is put in small type. */
void saltus_page_axis(const saltus_page *page, const char *axis, saltus_frame panel, bool logarithmic,
                      const char *name, saltus_range range);
/* A round distance of tics of which there are so many at most. */
double saltus_page_tic_step(saltus_range range, double tics);
/* Variables of the script, for the templates: a number, and a text without single quotes around it. */
void saltus_page_number(const saltus_page *page, const char *name, double value);
void saltus_page_text(const saltus_page *page, const char *name, const char *text);
/* The fixed part of a figure: the file of that name with the ending .gp. */
void saltus_page_template(const saltus_page *page, const char *name);
/* The same, after which nothing of the panel stays for the next one. */
void saltus_page_draw(const saltus_page *page, const char *name);

/* gnuplot.c: run gnuplot on a script (read from its beginning) that draws to standard output; what it draws,
 * complete, in *picture, the caller's to close. The user's own start-up files are not read. Errors: SALTUS_IO
 * with gnuplot's complaint; *picture is NULL then. */
saltus_status saltus_gnuplot_run(FILE *script, FILE **picture, saltus_message *message);

/* The templates, in no order; made by the build. */
typedef struct saltus_template {
    const char *name, *text;
} saltus_template;
extern const saltus_template saltus_templates[];
extern const int saltus_template_count;

#endif
