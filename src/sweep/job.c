/* The tasks in progress in one thread: the results of their trajectories, kept until all seeds of a place
 * are there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <stdlib.h>
#include <string.h>

saltus_job *saltus_job_open(const saltus_sweep *sweep, long long task) {
    saltus_job *job = calloc(1, sizeof *job);
    if (!job)
        return NULL;
    int length = saltus_sweep_task_length(sweep, task), seeds = sweep->options.seeds;
    *job = (saltus_job){.sweep = sweep, .task = task, .seeds = seeds};
    job->missing = malloc((size_t)length * sizeof *job->missing);
    job->cells = calloc((size_t)length * (size_t)seeds, sizeof *job->cells);
    if (!job->missing || !job->cells) {
        saltus_job_free(job);
        return NULL;
    }
    for (job->length = 0; job->length < length; job->length++)
        job->missing[job->length] = seeds;
    return job;
}

static void clear_cell(saltus_cell *cell) {
    free(cell->state);
    free(cell->orbit);
    for (int k = 0; k < SALTUS_CLOUDS; k++)
        free(cell->clouds[k].entries);
    *cell = (saltus_cell){0};
}

void saltus_job_free(saltus_job *job) {
    if (!job)
        return;
    for (int k = 0; k < job->length * job->seeds; k++)
        clear_cell(&job->cells[k]);
    free(job->missing);
    free(job->cells);
    free(job);
}

static double *copy(const double *values, size_t count, bool *sound) {
    double *made = malloc(count * sizeof *made);
    if (made)
        memcpy(made, values, count * sizeof *made);
    else
        *sound = false;
    return made;
}

bool saltus_job_put(saltus_job *job, int place, int seed, const saltus_sweep_row *row, const double *state,
                    const double *orbit, saltus_watch *watch, bool *sound) {
    saltus_cell *cell = &job->cells[place * job->seeds + seed];
    size_t n = (size_t)job->sweep->dimension;
    *sound = watch->sound;
    cell->row = *row;
    cell->state = copy(state, n, sound);
    if (job->seeds > 1 && row->verdict == SALTUS_PERIODIC)
        cell->orbit = copy(orbit, n * (size_t)row->periods, sound);
    memcpy(cell->clouds, watch->clouds, sizeof cell->clouds);
    memset(watch->clouds, 0, sizeof watch->clouds);
    return --job->missing[place] == 0;
}

static saltus_ending ending_of(const saltus_cell *cell) {
    return (saltus_ending){(saltus_verdict)cell->row.verdict, cell->row.periods, cell->state, cell->orbit};
}

/* Number the attractors in the order in which seeds first ended on them; -1 for a seed without a motion. */
static void number_attractors(saltus_cell *cells, int seeds, const saltus_system *system) {
    int found = 0;
    for (int s = 0; s < seeds; s++) {
        saltus_ending ending = ending_of(&cells[s]);
        int attractor = saltus_verdict_nothing(ending.verdict) ? -1 : found;
        for (int k = 0; k < s && attractor == found; k++) {
            saltus_ending earlier = ending_of(&cells[k]);
            if (saltus_same_attractor(system, &earlier, &ending, SALTUS_SAME_POINT))
                attractor = cells[k].row.attractor;
        }
        cells[s].row.attractor = attractor;
        found += attractor == found;
    }
}

/* Concatenate a cloud of all seeds; `counts` receives their numbers of entries. NULL without memory. */
static void *gather(const saltus_cell *cells, int seeds, int which, int n, long long *counts) {
    size_t size = saltus_cloud_entry(which, n), total = 0, at = 0;
    for (int s = 0; s < seeds; s++)
        total += (size_t)(counts[s] = (long long)cells[s].clouds[which].count);
    char *all = malloc(total ? total * size : 1);
    for (int s = 0; s < seeds && all; s++) {
        const saltus_cloud *cloud = &cells[s].clouds[which];
        if (cloud->count)
            memcpy(all + at, cloud->entries, cloud->count * size);
        at += cloud->count * size;
    }
    return all;
}

saltus_status saltus_job_emit(saltus_job *job, int place, const saltus_system *system,
                              const saltus_sweep_feed *feed, saltus_message *message) {
    const int seeds = job->seeds, n = job->sweep->dimension;
    saltus_cell *cells = job->cells + place * seeds;
    saltus_sweep_row *rows = malloc((size_t)seeds * sizeof *rows);
    double *states = malloc((size_t)seeds * (size_t)n * sizeof *states);
    long long *counts = malloc((size_t)(SALTUS_CLOUDS * seeds) * sizeof *counts);
    void *clouds[SALTUS_CLOUDS] = {NULL};
    bool sound = rows && states && counts;
    number_attractors(cells, seeds, system);
    for (int s = 0; s < seeds && sound; s++) {
        rows[s] = cells[s].row;
        memcpy(states + s * n, cells[s].state, (size_t)n * sizeof *states);
    }
    for (int k = 0; k < SALTUS_CLOUDS && sound; k++) {
        clouds[k] = gather(cells, seeds, k, n, counts + k * seeds);
        sound = clouds[k];
    }
    saltus_status status = SALTUS_OK;
    if (sound) {
        saltus_sweep_result result = {.place = saltus_sweep_task_place(job->sweep, job->task, place),
                                      .rows = rows,
                                      .states = states,
                                      .turning_counts = counts + SALTUS_CLOUD_TURNING * seeds,
                                      .impact_counts = counts + SALTUS_CLOUD_IMPACTS * seeds,
                                      .strobe_counts = counts + SALTUS_CLOUD_STROBES * seeds,
                                      .turning = clouds[SALTUS_CLOUD_TURNING],
                                      .impacts = clouds[SALTUS_CLOUD_IMPACTS],
                                      .strobes = clouds[SALTUS_CLOUD_STROBES]};
        status = feed->take(feed->context, &result, message);
    } else
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the results of a sweep");
    for (int k = 0; k < SALTUS_CLOUDS; k++)
        free(clouds[k]);
    free(rows);
    free(states);
    free(counts);
    for (int s = 0; s < seeds; s++)
        clear_cell(&cells[s]);
    return status;
}
