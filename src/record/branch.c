/* Branches for people, as tables of their special points, and for programs, with each point as a line of
 * JSON.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/fields.h"
#include "record/json.h"

#include <math.h>
#include <string.h>

/* Widths of the table's columns; 0: as wide as its text. */
enum { row_width = 7, label_width = 5, value_width = 14, motion_width = 16 };
enum { multiplier_width = 24, beyond_width = 8 };

static bool is_locus(const saltus_branch_file *file) {
    return file->options.locus != SALTUS_POINT_REGULAR;
}

static const char *stability(const saltus_branch_point *point) {
    return point->stable ? "stable" : "unstable";
}

/* The largest multiplier and all others with a modulus above 1/2, only one of each complex pair; of an
 * equilibrium the first eigenvalue and all others with a non-negative real part. */
static void name_multipliers(const saltus_branch_point *point, char *text, size_t room) {
    static const char more[] = ", ...";
    const double well_inside = point->periods ? log(0.5) : -1e-12;
    size_t used = 0;
    text[0] = '\0';
    const int count = point->periods ? point->dimension : point->multiplier_count;
    for (int k = 0; k < count; k++) {
        const saltus_multiplier *m = &point->multipliers[k];
        char one[64];
        if (isnan(m->re) || (k > 0 && !(m->log_modulus > well_inside)))
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

/* One line of the table, without trailing blanks. */
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

static void put_point(FILE *out, const saltus_branch_file *file, int row) {
    const double rounding = 1e-11;
    const saltus_branch_point *point = &file->points[row], *next = point + 1;
    const bool changes = point->label_after[0] && strcmp(point->label, point->label_after) != 0;
    row_text line = {.length = 0};
    char text[SALTUS_REASON_MAX + 64], multipliers[96] = "";
    snprintf(text, sizeof text, "%7d", row + 1);
    add(&line, row_width, text);
    add(&line, label_width, saltus_point_word(point->kind));
    for (int k = 0; k < 1 + is_locus(file); k++) {
        int length = snprintf(text, sizeof text, "%.12g", point->value[k]);
        if (k == 0 && point->accuracy > rounding * fabs(point->value[0]))
            snprintf(text + length, sizeof text - (size_t)length, " +- %.0e", point->accuracy);
        add(&line, value_width, text);
    }
    snprintf(text, sizeof text, "%s%s%s", point->label, changes ? " -> " : "",
             changes ? point->label_after : "");
    add(&line, motion_width, text);
    /* On one side of grazing the multipliers have no limit, so they are omitted. */
    if (point->kind != SALTUS_POINT_GR && point->locus != SALTUS_POINT_GR)
        name_multipliers(point, multipliers, sizeof multipliers);
    add(&line, multiplier_width, multipliers);
    /* Stability beyond a special point is that of the next point, unless that is special too. */
    bool known = row + 1 < file->point_count && next->branch == point->branch &&
                 (next->kind == SALTUS_POINT_REGULAR || next->kind == SALTUS_POINT_UZ);
    if (!is_locus(file))
        add(&line, beyond_width, known ? stability(next) : "");
    /* The reason, and the smallest force of a permanent contact unless it releases. */
    size_t length = (size_t)snprintf(text, sizeof text, "%s", point->reason);
    if (!isnan(point->contact_force) && !point->label_after[0])
        snprintf(text + length, sizeof text - length, "%sleast contact force %.4g", length ? "; " : "",
                 point->contact_force);
    add(&line, 0, text);
    put_line(out, &line);
}

void saltus_write_branch_text(FILE *out, const saltus_branch_file *file) {
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
    for (int row = 0; row < file->point_count; row++) {
        const saltus_branch_point *point = &file->points[row];
        if (row == 0 || point->branch != point[-1].branch) {
            fprintf(out, "branch %d, ", point->branch);
            if (point->parent >= 0)
                fprintf(out, "off branch %d, ", point->parent);
            else if (!is_locus(file))
                fputs(point->heading < 0 ? "down " : "up ", out);
            fprintf(out, "from %s = %.12g", file->options.key[0], point->value[0]);
            if (is_locus(file))
                fprintf(out, ", %s = %.12g: %s of %s\n", file->options.key[1], point->value[1],
                        saltus_point_word(point->locus), point->label);
            else
                fprintf(out, ": %s, %s\n", point->label, stability(point));
        }
        /* All special points, on a locus only those of another kind than the locus, and regular ones with a
         * remark. */
        if (point->kind == SALTUS_POINT_REGULAR ? point->reason[0] : point->kind != point->locus)
            put_point(out, file, row);
    }
}

/* The members of a point that `names` lists ("step, heading"), in that order, each preceded by a comma. */
static void put_named(FILE *file, const char *names, const saltus_branch_point *point) {
    const saltus_point_row row = {.point = *point};
    const int counts[] = {point->dimension, 0, 0};
    for (const char *name = names; *name; name += strspn(name, ", ")) {
        const size_t length = strcspn(name, ",");
        for (int k = 0; k < saltus_point_fields.count; k++) {
            const saltus_field_table one = {&saltus_point_fields.fields[k], 1};
            if (strlen(one.fields->name) == length && memcmp(one.fields->name, name, length) == 0)
                saltus_json_fields(file, ", ", &one, counts, &row);
        }
        name += length;
    }
}

void saltus_write_point_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                             const saltus_branch_point *point) {
    saltus_json_begin(file, scene);
    put_named(file, "branch", point);
    saltus_json_member(file, "parent", point->parent < 0 ? NAN : point->parent);
    put_named(file, "step", point);
    saltus_json_text(file, "locus", saltus_point_word(point->locus));
    saltus_json_text(file, "label", saltus_point_word(point->kind));
    saltus_json_list(file, "values", point->value, isnan(point->value[1]) ? 1 : 2);
    put_named(file, "heading, arclength, motion, motion_after", point);
    saltus_json_member(file, "impacts", point->impacts < 0 ? NAN : (double)point->impacts);
    put_named(file, "periods, period, sticking_intervals, stable", point);
    saltus_json_member(file, "unstable", point->unstable < 0 ? NAN : point->unstable);
    put_named(file, "admissible, state", point);
    saltus_json_events(file, system, point->events, point->event_count);
    put_named(file, "contact_force", point);
    if (point->grazing_stop) {
        fprintf(file, ", \"grazing\": {\"side\": \"%s\", \"stop\": %d", saltus_side_word(point->grazing_side),
                point->grazing_stop);
        saltus_json_member(file, "time_over_T", point->grazing_time);
    }
    fputs(point->grazing_stop ? "}" : ", \"grazing\": null", file);
    if (point->periods)
        saltus_json_multipliers(file, point->multipliers, point->multiplier_count);
    else
        saltus_json_rows(file, "eigenvalues", point->multipliers, point->multiplier_count, 2,
                         sizeof *point->multipliers / sizeof(double));
    if (!isnan(point->lyapunov_coefficient))
        put_named(file, "lyapunov_coefficient", point);
    if (point->trivial_multiplier != 0)
        put_named(file, "trivial_multiplier", point);
    put_named(file, "log_volume, sum_rule, residual, iterations", point);
    saltus_json_member(file, "accuracy",
                       point->kind != SALTUS_POINT_REGULAR || point->accuracy > 0 ? point->accuracy : NAN);
    put_named(file, "reason", point);
    saltus_json_end(file, &point->spec, NULL);
}
