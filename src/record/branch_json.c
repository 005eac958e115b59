/* A point of a branch as one line of JSON.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/fields.h"
#include "record/json.h"

#include <math.h>

/* What touches which stop at grazing. */
static void put_grazing(FILE *file, const saltus_branch_point *point) {
    saltus_json_key(file, "grazing");
    if (!point->grazing_stop) {
        fputs("null", file);
        return;
    }
    fprintf(file, "{\"side\": \"%s\", \"stop\": %d", saltus_side_word(point->grazing_side),
            point->grazing_stop);
    saltus_json_member(file, "time_over_T", point->grazing_time);
    fputc('}', file);
}

static void put_eigenvalues(FILE *file, const saltus_branch_point *point) {
    saltus_eigenvalue eigenvalues[SALTUS_STATE_MAX];
    for (int k = 0; k < point->multiplier_count; k++)
        eigenvalues[k] = (saltus_eigenvalue){point->multipliers[k].re, point->multipliers[k].im};
    saltus_json_eigenvalues(file, eigenvalues, point->multiplier_count);
}

void saltus_write_point_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                             const saltus_branch_point *point) {
    const saltus_field_table *table = &saltus_point_fields;
    const saltus_point_row row = {.point = *point};
    const int counts[] = {point->dimension, 0, 0};
    fputs("{\"version\": \"" SALTUS_VERSION "\"", file);
    saltus_json_text(file, "scene", scene->name);
    saltus_json_named(file, "branch", table, counts, &row);
    saltus_json_member(file, "parent", point->parent < 0 ? NAN : point->parent);
    saltus_json_named(file, "step", table, counts, &row);
    saltus_json_text(file, "locus", saltus_point_word(point->locus));
    saltus_json_text(file, "label", saltus_point_word(point->kind));
    saltus_json_list(file, "values", point->value, isnan(point->value[1]) ? 1 : 2);
    saltus_json_named(file, "heading, arclength, motion, motion_after", table, counts, &row);
    saltus_json_member(file, "impacts", point->impacts < 0 ? NAN : (double)point->impacts);
    saltus_json_named(file, "periods, period, sticking_intervals, stable, unstable, admissible, state", table,
                      counts, &row);
    saltus_json_events(file, system, point->events, point->event_count);
    saltus_json_member(file, "contact_force", point->contact_force);
    put_grazing(file, point);
    if (point->periods)
        saltus_json_multipliers(file, point->multipliers, point->multiplier_count);
    else
        put_eigenvalues(file, point);
    if (!isnan(point->lyapunov_coefficient))
        saltus_json_member(file, "lyapunov_coefficient", point->lyapunov_coefficient);
    if (point->trivial_multiplier != 0)
        saltus_json_member(file, "trivial_multiplier", point->trivial_multiplier);
    saltus_json_named(file, "log_volume, sum_rule, residual, iterations", table, counts, &row);
    saltus_json_member(file, "accuracy",
                       point->kind != SALTUS_POINT_REGULAR || point->accuracy > 0 ? point->accuracy : NAN);
    saltus_json_named(file, "reason", table, counts, &row);
    saltus_json_parameters(file, &point->spec);
    fputs("}\n", file);
}
