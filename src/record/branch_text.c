/* The special points of branches as tables for people.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "saltus/record.h"

#include <math.h>
#include <string.h>

enum {
    row_width = 7,
    label_width = 5,
    value_width = 14,
    motion_width = 16,
    multiplier_width = 24,
    beyond_width = 8
};

static bool is_locus(const saltus_branch_file *file) {
    return file->options.locus != SALTUS_POINT_REGULAR;
}

/* All special points; on a curve of special points only those of another kind than the curve's. */
static bool is_listed(const saltus_branch_point *point) {
    const bool told = point->trivial_multiplier != 0 && point->reason[0]; /* its returns change */
    return told || (point->kind != SALTUS_POINT_REGULAR && point->kind != point->locus);
}

/* The largest multiplier, and the others with a modulus above 1/2; of a complex pair only one. Of an
 * equilibrium the first eigenvalue, and the others with a real part that is not negative. */
static void name_multipliers(const saltus_branch_point *point, char *text, size_t room) {
    static const char more[] = ", ...";
    const double well_inside = point->periods ? log(0.5) : -1e-12;
    size_t used = 0;
    text[0] = '\0';
    const int count = point->periods ? point->dimension : point->multiplier_count;
    for (int k = 0; k < count; k++) {
        const saltus_multiplier *m = &point->multipliers[k];
        char one[64];
        if (k > 0 && !(m->log_modulus > well_inside))
            return;
        int length = snprintf(one, sizeof one, "%s%.4g", k ? ", " : "", m->re);
        if (m->im != 0)
            length += snprintf(one + length, sizeof one - (size_t)length, " +- %.4gi", fabs(m->im));
        if (used + (size_t)length + sizeof more > room) {
            memcpy(text + used, more, sizeof more);
            return;
        }
        memcpy(text + used, one, (size_t)length + 1);
        used += (size_t)length;
        k += m->im != 0;
    }
}

static const char *stability(const saltus_branch_point *point) {
    return point->stable ? "stable" : "unstable";
}

/* Stability beyond a special point: that of the next point, unless it changes there again. */
static const char *stability_beyond(const saltus_branch_file *file, int row) {
    const saltus_branch_point *here = &file->points[row], *next = here + 1;
    bool known = row + 1 < file->point_count && next->branch == here->branch &&
                 (next->kind == SALTUS_POINT_REGULAR || next->kind == SALTUS_POINT_UZ) && !is_locus(file);
    return known ? stability(next) : "";
}

/* A line of the table without blanks at its end. */
typedef struct row_text {
    char text[640];
    size_t length;
} row_text;

static void add(row_text *line, int width, const char *text) {
    size_t room = sizeof line->text - line->length;
    int length = snprintf(line->text + line->length, room, "%-*s  ", width, text);
    line->length += (size_t)length < room ? (size_t)length : room - 1;
}

static void put_line(FILE *out, row_text *line) {
    while (line->length && line->text[line->length - 1] == ' ')
        line->text[--line->length] = '\0';
    fprintf(out, "%s\n", line->text);
}

static void add_value(row_text *line, const saltus_branch_point *point, int k) {
    const double rounding = 1e-11;
    char text[48];
    int length = snprintf(text, sizeof text, "%.12g", point->value[k]);
    if (k == 0 && point->accuracy > rounding * fabs(point->value[0]))
        snprintf(text + length, sizeof text - (size_t)length, " +- %.0e", point->accuracy);
    add(line, value_width, text);
}

/* Why, and how hard a contact that holds all the time presses where it does least, unless it lets go here. */
static void add_remark(row_text *line, const saltus_branch_point *point) {
    char text[SALTUS_REASON_MAX + 64];
    size_t length = (size_t)snprintf(text, sizeof text, "%s", point->reason);
    if (!isnan(point->contact_force) && !point->label_after[0])
        snprintf(text + length, sizeof text - length, "%sleast contact force %.4g", length ? "; " : "",
                 point->contact_force);
    add(line, 0, text);
}

/* The multipliers of a grazing orbit have no limit on one of its sides, so they are left out. */
static void put_point(FILE *out, const saltus_branch_file *file, int row) {
    const saltus_branch_point *point = &file->points[row];
    row_text line = {.length = 0};
    char text[96];
    bool changes = point->label_after[0] && strcmp(point->label, point->label_after) != 0;
    snprintf(text, sizeof text, "%7d", row + 1);
    add(&line, row_width, text);
    add(&line, label_width, saltus_point_word(point->kind));
    for (int k = 0; k < 1 + is_locus(file); k++)
        add_value(&line, point, k);
    snprintf(text, sizeof text, "%s%s%s", point->label, changes ? " -> " : "",
             changes ? point->label_after : "");
    add(&line, motion_width, text);
    text[0] = '\0';
    if (point->kind != SALTUS_POINT_GR && point->locus != SALTUS_POINT_GR)
        name_multipliers(point, text, sizeof text);
    add(&line, multiplier_width, text);
    if (!is_locus(file))
        add(&line, beyond_width, stability_beyond(file, row));
    add_remark(&line, point);
    put_line(out, &line);
}

static void put_heading(FILE *out, const saltus_branch_file *file, int row) {
    const saltus_branch_options *o = &file->options;
    const saltus_branch_point *first = &file->points[row];
    const char *way = first->parent >= 0 || is_locus(file) ? "" : first->heading < 0 ? "down " : "up ";
    fprintf(out, "branch %d, ", first->branch);
    if (first->parent >= 0)
        fprintf(out, "off branch %d, ", first->parent);
    fprintf(out, "%sfrom %s = %.12g", way, o->key[0], first->value[0]);
    if (is_locus(file))
        fprintf(out, ", %s = %.12g: %s of %s\n", o->key[1], first->value[1], saltus_point_word(first->locus),
                first->label);
    else
        fprintf(out, ": %s, %s\n", first->label, stability(first));
}

static void put_columns(FILE *out, const saltus_branch_file *file) {
    bool rests = false;
    for (int row = 0; row < file->point_count; row++)
        rests = rests || file->points[row].periods == 0;
    row_text line = {.length = 0};
    add(&line, row_width, "    row");
    add(&line, label_width, "label");
    for (int k = 0; k < 1 + is_locus(file); k++)
        add(&line, value_width, file->options.key[k]);
    add(&line, motion_width, "n/p");
    add(&line, multiplier_width, rests ? "multipliers, eigenvalues" : "largest multipliers");
    if (!is_locus(file))
        add(&line, beyond_width, "beyond");
    add(&line, 0, "remark");
    put_line(out, &line);
}

void saltus_write_branch_text(FILE *out, const saltus_branch_file *file) {
    int branch = -1;
    put_columns(out, file);
    for (int row = 0; row < file->point_count; row++) {
        if (file->points[row].branch != branch)
            put_heading(out, file, row);
        branch = file->points[row].branch;
        if (is_listed(&file->points[row]))
            put_point(out, file, row);
    }
}
