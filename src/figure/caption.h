/* Private: lines of text for figures, in gnuplot's enhanced text, and how text enters a script.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_CAPTION_H
#define SALTUS_FIGURE_CAPTION_H

#include "record/describe.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

/* Text under construction; excess text is cut off. */
typedef struct saltus_line {
    char text[4096];
    size_t length;
} saltus_line;

/* Append to the text. */
void saltus_line_add(saltus_line *l, const char *format, ...) __attribute__((format(printf, 2, 3)));
void saltus_line_add_list(saltus_line *l, const char *format, va_list arguments);
/* Append a separator ";  " unless the line is empty; returns the line. */
saltus_line *saltus_line_next(saltus_line *l);
/* Text from a user's file, as it stands: what would be markup in enhanced text is escaped. */
void saltus_line_plain(saltus_line *l, const char *text);
/* A number formatted with one conversion, also amid a few words, with a minus sign and an exponent as a power
 * of ten: the way for all numbers that may be small or large. */
void saltus_line_number(saltus_line *l, const char *format, double value);
/* The name of an entry of the state. */
void saltus_line_state(saltus_line *line, const saltus_system *system, int entry);
/* "symbol = value" of a parameter. */
void saltus_line_value(saltus_line *l, const char *name, double value);
/* The symbol of a parameter: a Greek letter or an italic Latin one, digits as subscripts. */
void saltus_line_symbol(saltus_line *l, const char *name);
/* The meaning of a parameter and its symbol; only the symbol if the meaning is a formula. */
void saltus_line_parameter(saltus_line *l, const saltus_spec *spec, const char *key);
/* Axis title for the observed displacement, or its velocity. */
void saltus_line_observed(saltus_line *l, const saltus_system *system, bool velocity);
/* "0.756 ± 0.008". */
void saltus_line_uncertain(saltus_line *line, double value, double error);
/* Model, parameters and stops, except the keys (may be NULL) that vary in the figure. */
void saltus_line_parameters(saltus_line *l, const saltus_system *system, const char *const varied[2]);
/* The width of enhanced text in DejaVu Sans, in heights of its type; letters of an index count as full ones.
 */
double saltus_line_width(const char *text);
/* How many bytes of enhanced text fit into a line of that width: up to a blank outside braces and
 * short parentheses and not beside a ±, preferably after a comma or semicolon in the second half of the line.
 */
size_t saltus_line_piece(const char *text, double width);
/* The only way for text into a script: write `length` bytes of enhanced text as a string in single quotes.
 * Nothing in the text can end the string or begin a command: quotes are doubled, control characters and bytes
 * that are no UTF-8 are left out, and braces are balanced. */
void saltus_put_quoted(FILE *script, const char *text, size_t length);

#endif
