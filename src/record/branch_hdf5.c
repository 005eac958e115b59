/* A branch written as an HDF5 file while it is being computed.
 *
 * All rows are kept in memory. After the first point and then every few seconds, a new file with all of them
 * is written beside the old one and renamed over it, so the file is never incomplete: a killed run leaves the
 * last exchanged file, a failed start leaves an earlier file unchanged, and other programs may read while the
 * branch grows. The pause between exchanges is proportional to their cost, which thus remains a small part of
 * the time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/options.h"

#include "base/progress.h"
#include "record/describe.h"
#include "record/fields.h"
#include "record/output.h"
#include "record/rows.h"
#include "system/system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double least_pause = 1;  /* seconds between two exchanges of the file */
static const double pause_ratio = 20; /* the pause relative to the time an exchange takes */

struct saltus_branch_output {
    saltus_branch_file head; /* without points */
    saltus_system *system;   /* of the start */
    saltus_rows points, events;
    char *path;
    saltus_origin origin;
    double written, cost; /* when the file was last exchanged, and how long that took; seconds */
};

static saltus_status put_file(saltus_h5 *w, void *context, saltus_message *message) {
    const saltus_branch_output *o = context;
    const saltus_branch_file *head = &o->head;
    const saltus_branch_options *options = &head->options;
    char names[SALTUS_PARAMETERS_MAX * SALTUS_KEY_MAX] = "";
    int count;
    size_t used = 0;
    (void)message;
    saltus_h5_put_head(w, "branch", head->scene, head->title, &head->spec, head->complete);
    saltus_h5_put_origin(w, &o->origin);
    saltus_h5_text(w, w->file, "integrator",
                   saltus_integrator_used(o->system, options->orbit.flow.integrator));
    hid_t group = saltus_h5_open_group(w, "continuation", "options of the run");
    saltus_h5_options(w, group, &saltus_branch_table, options);
    saltus_h5_reals(w, group, "values", "where points were asked for", options->values, options->value_count);
    saltus_h5_reals(w, group, "resume", "what the run goes on from; empty once it is complete", head->resume,
                    head->complete ? 0 : head->resume_count);
    saltus_h5_close(group);
    group = saltus_h5_open_group(w, "start", "the orbit that the branch was begun with");
    saltus_h5_integer(w, group, "periods", head->periods);
    if (options->orbit.free_period)
        saltus_h5_double(w, group, "period", 2 * M_PI / saltus_spec_omega(&head->spec));
    saltus_h5_reals(w, group, "state", "q, q', further states at phase 0", head->state, head->dimension);
    saltus_h5_close(group);
    group = saltus_h5_open_group(w, "points", "points of the branches, one row each, as computed");
    saltus_h5_rows(w, group, &o->points);
    /* The parameters' names make the rows readable for other programs. */
    const saltus_parameter *p = saltus_model_parameters(head->spec.model, &count);
    for (int k = 0; k < count && used < sizeof names; k++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", k ? "," : "", p[k].name);
    saltus_h5_names(w, group, "parameters", names);
    saltus_h5_close(group);
    group = saltus_h5_open_group(w, "events", "contact events of the orbits, see /points/event_first");
    saltus_h5_rows(w, group, &o->events);
    saltus_h5_close(group);
    return SALTUS_OK;
}

/* Replace the file by one with all rows so far. */
static saltus_status exchange(saltus_branch_output *o, bool complete, saltus_message *message) {
    double begin = saltus_seconds();
    o->head.complete = complete;
    saltus_status status = saltus_h5_write(o->path, false, put_file, o, message);
    o->written = saltus_seconds();
    o->cost = o->written - begin;
    return status;
}

static double *copy_reals(const double *values, int count) {
    double *copy = malloc(((size_t)count + 1) * sizeof *copy);
    if (copy && count)
        memcpy(copy, values, (size_t)count * sizeof *copy);
    return copy;
}

static void release(saltus_branch_output *o) {
    saltus_rows_clear(&o->points);
    saltus_rows_clear(&o->events);
    saltus_branch_file_clear(&o->head);
    saltus_system_free(o->system);
    saltus_h5_origin_clear(&o->origin);
    free(o->path);
    free(o);
}

saltus_status saltus_branch_output_open(const char *path, const saltus_scene *scene, int periods,
                                        const double *state, const saltus_branch_options *options,
                                        const saltus_origin *origin, saltus_branch_output **output,
                                        saltus_message *message) {
    *output = NULL;
    /* Test that the file can be written before hours of computation. */
    if (!saltus_path_ends(path, ".h5"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .h5", path);
    saltus_status status = saltus_output_test(path, true, message);
    if (status != SALTUS_OK)
        return status;
    saltus_branch_output *o = calloc(1, sizeof *o);
    if (!o)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the branch file");
    saltus_branch_file *head = &o->head;
    head->spec = scene->spec;
    saltus_model_retain(scene->spec.model);
    head->periods = periods;
    head->options = *options;
    snprintf(head->scene, sizeof head->scene, "%s", scene->name);
    snprintf(head->title, sizeof head->title, "%s", scene->title);
    bool kept = saltus_h5_origin_keep(&o->origin, origin);
    status = saltus_system_new(&scene->spec, &o->system, message);
    if (status == SALTUS_OK) {
        head->dimension = saltus_system_dimension(o->system);
        head->state = copy_reals(state, head->dimension);
        head->options.values = head->values = copy_reals(options->values, options->value_count);
        o->path = strdup(path);
        o->points = (saltus_rows){
            .kind = &saltus_point_fields,
            .counts = {
                [SALTUS_COUNT_DIMENSION] = head->dimension, [SALTUS_COUNT_STOPS] = head->spec.stop_count}};
        saltus_model_parameters(head->spec.model, &o->points.counts[SALTUS_COUNT_PARAMETERS]);
        o->events = (saltus_rows){.kind = &saltus_event_fields};
        if (!(kept && head->state && head->values && o->path))
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the branch file");
    }
    if (status == SALTUS_OK)
        *output = o;
    else
        release(o);
    return status;
}

/* Append one row, in memory, with its events. */
static saltus_status append_point(saltus_branch_output *o, const saltus_branch_point *point,
                                  saltus_message *message) {
    const saltus_point_row row = {.point = *point, .event_first = o->events.count};
    bool there = true;
    for (int k = 0; k < point->event_count && there; k++) {
        const saltus_event_row event = saltus_event_row_of(o->system, &point->events[k]);
        there = saltus_rows_add(&o->events, &event);
    }
    if (!there || !saltus_rows_add(&o->points, &row))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for another point of the branch");
    return SALTUS_OK;
}

saltus_status saltus_branch_output_add(saltus_branch_output *o, const saltus_branch_point *point,
                                       saltus_message *message) {
    saltus_status status = append_point(o, point, message);
    if (status != SALTUS_OK ||
        (o->points.count > 1 && saltus_seconds() - o->written < fmax(least_pause, pause_ratio * o->cost)))
        return status;
    return exchange(o, false, message);
}

void saltus_branch_output_resume(saltus_branch_output *o, double *numbers, int count) {
    if (count == 0) {
        free(numbers);
        return;
    }
    free(o->head.resume);
    o->head.resume = numbers;
    o->head.resume_count = count;
}

saltus_status saltus_branch_output_take_over(saltus_branch_output *o, const saltus_branch_file *earlier,
                                             int kept, saltus_message *message) {
    double *numbers = copy_reals(earlier->resume, earlier->resume_count);
    saltus_status status =
        numbers ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the branch file");
    if (status == SALTUS_OK)
        status = saltus_h5_origin_take_over(&o->origin, o->path, message);
    for (int k = 0; k < kept && status == SALTUS_OK; k++)
        status = append_point(o, &earlier->points[k], message);
    saltus_branch_output_resume(o, numbers, numbers ? earlier->resume_count : 0);
    return status == SALTUS_OK && kept ? exchange(o, false, message) : status;
}

saltus_status saltus_branch_output_close(saltus_branch_output *output, bool complete,
                                         saltus_message *message) {
    if (!output)
        return SALTUS_OK;
    saltus_status status = output->points.count ? exchange(output, complete, message) : SALTUS_OK;
    release(output);
    return status;
}
