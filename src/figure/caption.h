/* Private: lines of text for figures, in gnuplot's enhanced text inside single quotes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_CAPTION_H
#define SALTUS_FIGURE_CAPTION_H

#include "record/lyapunov_words.h"

#include <stddef.h>

/* Text under construction; what does not fit is cut off. */
typedef struct saltus_line {
    char text[1024];
    size_t length;
} saltus_line;

void saltus_line_add(saltus_line *l, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;
/* ";  " behind what there is already, if there is anything. */
void saltus_line_next(saltus_line *l);
/* Text from a user's file: everything that enhanced text or a quoted string would take for a command is
 * escaped. */
void saltus_line_plain(saltus_line *l, const char *text);
/* A number, formatted by one conversion, with a true minus sign. */
void saltus_line_number(saltus_line *l, const char *format, double value);
/* The name of an entry of the state. */
void saltus_line_state(saltus_line *line, const saltus_system *system, int entry);
/* The symbol of a parameter: a Greek letter or an italic Latin one, digits as subscripts. */
void saltus_line_symbol(saltus_line *l, const char *name);
/* What a parameter means, followed by its symbol; the bare symbol where the meaning is a formula. */
void saltus_line_parameter(saltus_line *l, const saltus_spec *spec, const char *key);
/* Name of an axis that shows the observed displacement, or its rate. */
void saltus_line_observed(saltus_line *l, const saltus_system *system, bool velocity);
/* "0.756 ± 0.008" in gnuplot's enhanced text. */
void saltus_line_uncertain(saltus_line *line, saltus_uncertain number);
/* Model, parameters and stops, without the keys (NULL: none) that vary in the figure. */
void saltus_line_parameters(saltus_line *l, const saltus_system *system, const char *const varied[2]);
/* How many bytes of enhanced text fit into a line of so many letters: up to a blank outside braces, after a
 * comma or semicolon where there is one in the second half of the line. */
size_t saltus_line_piece(const char *text, int letters);
/* How many letters of a text are shown. */
int saltus_line_letters(const char *text);

#endif
