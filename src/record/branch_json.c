/* A point of a branch as one line of JSON.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/json.h"

#include <math.h>

static const char *boolean(bool value) {
    return value ? "true" : "false";
}

static void put_motion(FILE *file, const saltus_branch_point *point) {
    saltus_json_text(file, "motion", point->label);
    saltus_json_text(file, "motion_after", point->label_after);
    saltus_json_member(file, "impacts", point->impacts < 0 ? NAN : (double)point->impacts);
    fprintf(file, ", \"periods\": %d, \"sticking_intervals\": %d", point->periods, point->sticking_intervals);
}

static void put_values(FILE *file, const saltus_branch_point *point) {
    saltus_json_key(file, "values");
    saltus_json_vector(file, point->value, isnan(point->value[1]) ? 1 : 2);
    saltus_json_member(file, "heading", point->heading);
    saltus_json_member(file, "arclength", point->arclength);
}

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

void saltus_write_point_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                             const saltus_branch_point *point) {
    fputs("{\"version\": \"" SALTUS_VERSION "\"", file);
    saltus_json_text(file, "scene", scene->name);
    fprintf(file, ", \"branch\": %d, \"parent\": ", point->branch);
    saltus_json_value(file, point->parent < 0 ? NAN : point->parent);
    fprintf(file, ", \"step\": %d", point->step);
    saltus_json_text(file, "label", saltus_point_word(point->kind));
    put_values(file, point);
    put_motion(file, point);
    fprintf(file, ", \"stable\": %s, \"unstable\": %d, \"admissible\": %s", boolean(point->stable),
            point->unstable, boolean(point->admissible));
    saltus_json_key(file, "state");
    saltus_json_vector(file, point->state, point->dimension);
    saltus_json_events(file, system, point->events, point->event_count);
    saltus_json_member(file, "contact_force", point->contact_force);
    put_grazing(file, point);
    saltus_json_multipliers(file, point->multipliers, point->dimension);
    saltus_json_member(file, "log_volume", point->log_volume);
    saltus_json_member(file, "sum_rule", point->sum_rule);
    saltus_json_member(file, "residual", point->residual);
    fprintf(file, ", \"iterations\": %d", point->iterations);
    saltus_json_member(file, "accuracy", point->kind == SALTUS_POINT_REGULAR ? NAN : point->accuracy);
    saltus_json_text(file, "reason", point->reason);
    saltus_json_parameters(file, &point->spec);
    fputs("}\n", file);
}
