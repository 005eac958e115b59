/* The special points of a branch as a table for people.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/describe.h"
#include "saltus/io.h"

#include <math.h>
#include <string.h>

enum { value_width = 18, motion_width = 24, multiplier_width = 40 };

void saltus_write_special_heading(FILE *file, const saltus_branch_options *options) {
    fprintf(file, "%7s %6s  %-5s  %-*s", "row", "branch", "label", value_width, options->key[0]);
    if (options->locus != SALTUS_POINT_REGULAR)
        fprintf(file, "  %-*s", value_width, options->key[1]);
    fprintf(file, "  %-8s  %-*s  %-*s  %s\n", "accuracy", motion_width, "n/p", multiplier_width,
            "largest multipliers", "remark");
}

/* The leading multipliers; a complex pair is named once. */
static void put_multipliers(const saltus_branch_point *point, char *text, size_t room) {
    enum { leading = 2 };
    size_t used = 0;
    text[0] = '\0';
    for (int k = 0, shown = 0; k < point->dimension && shown < leading && used < room; k++, shown++) {
        const saltus_multiplier *m = &point->multipliers[k];
        bool pair = m->im != 0 && k + 1 < point->dimension;
        used += (size_t)snprintf(text + used, room - used, "%s%.5g", shown ? ", " : "", m->re);
        if (m->im != 0 && used < room)
            used += (size_t)snprintf(text + used, room - used, " +- %.5gi", fabs(m->im));
        k += pair;
    }
}

void saltus_write_special_point(FILE *file, const saltus_branch_options *options,
                                const saltus_branch_point *point, long long row) {
    char multipliers[96], motion[2 * SALTUS_LABEL_MAX + 8];
    bool changes = point->label_after[0] && strcmp(point->label, point->label_after) != 0;
    bool usual = point->kind == SALTUS_POINT_REGULAR || point->kind == options->locus;
    if (usual && (point->kind == SALTUS_POINT_REGULAR || point->step > 0))
        return;
    put_multipliers(point, multipliers, sizeof multipliers);
    snprintf(motion, sizeof motion, "%s%s%s", point->label, changes ? " -> " : "",
             changes ? point->label_after : "");
    fprintf(file, "%7lld %6d  %-5s  %-*.12g", row, point->branch, saltus_point_word(point->kind), value_width,
            point->value[0]);
    if (options->locus != SALTUS_POINT_REGULAR)
        fprintf(file, "  %-*.12g", value_width, point->value[1]);
    if (isfinite(point->accuracy) && point->accuracy > 0)
        fprintf(file, "  %-8.1e", point->accuracy);
    else
        fprintf(file, "  %-8s", "");
    fprintf(file, "  %-*s  %-*s  %s\n", motion_width, motion, multiplier_width, multipliers, point->reason);
}
