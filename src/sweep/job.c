/* The tasks under way in one thread: the outcomes of their trajectories, kept until all seeds of a place are
 * there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "motion/verdict.h"

#include <stdlib.h>
#include <string.h>

saltus_job *saltus_job_open(const saltus_sweep *sweep, long long task) {
    saltus_job *job = calloc(1, sizeof *job);
    if (!job)
        return NULL;
    job->sweep = sweep;
    job->task = task;
    job->length = saltus_sweep_task_length(sweep, task);
    job->seeds = sweep->options.seeds;
    job->missing = malloc((size_t)job->length * sizeof *job->missing);
    job->cells = calloc((size_t)job->length * (size_t)job->seeds, sizeof *job->cells);
    if (!job->missing || !job->cells) {
        free(job->missing);
        free(job->cells);
        free(job);
        return NULL;
    }
    for (int k = 0; k < job->length; k++)
        job->missing[k] = job->seeds;
    return job;
}

static void clear_cell(saltus_cell *cell) {
    free(cell->state);
    free(cell->orbit);
    free(cell->turning);
    free(cell->strobes);
    free(cell->impacts);
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

/* A copy of some numbers; NULL for none of them. */
static double *copy(const double *values, size_t count, bool *sound) {
    double *made = count ? malloc(count * sizeof *made) : NULL;
    if (made)
        memcpy(made, values, count * sizeof *made);
    *sound = *sound && (made || !count);
    return made;
}

bool saltus_job_put(saltus_job *job, int place, int seed, const saltus_sweep_row *row, const double *state,
                    const double *orbit, const saltus_watch *watch, bool *sound) {
    saltus_cell *cell = &job->cells[place * job->seeds + seed];
    size_t n = (size_t)job->sweep->dimension;
    *sound = watch->sound;
    cell->row = *row;
    cell->state = copy(state, n, sound);
    if (job->seeds > 1 && row->verdict == SALTUS_PERIODIC)
        cell->orbit = copy(orbit, n * (size_t)row->periods, sound);
    cell->turning = copy(watch->turning.values, watch->turning.count, sound);
    cell->strobes = copy(watch->strobes.values, watch->strobes.count, sound);
    cell->impacts = copy(watch->impacts.values, watch->impacts.count, sound);
    cell->turning_count = (long long)watch->turning.count;
    cell->strobe_count = (long long)(watch->strobes.count / n);
    cell->impact_count = (long long)(watch->impacts.count / 3);
    return --job->missing[place] == 0;
}

static saltus_ending ending_of(const saltus_cell *cell) {
    return (saltus_ending){(saltus_verdict)cell->row.verdict, cell->row.periods, cell->state, cell->orbit};
}

/* Whether an earlier seed has ended on the attractor of this one. */
static bool is_known(const saltus_cell *earlier, const saltus_cell *cell, const saltus_system *system) {
    saltus_ending a = ending_of(earlier), b = ending_of(cell);
    return earlier->row.attractor >= 0 && saltus_same_attractor(system, &a, &b, SALTUS_SAME_POINT);
}

static void number_attractors(saltus_cell *cells, int seeds, const saltus_system *system) {
    int found = 0;
    for (int s = 0; s < seeds; s++) {
        int first = 0;
        cells[s].row.attractor = cells[s].row.verdict == SALTUS_FAILED ? -1 : found;
        if (cells[s].row.attractor < 0)
            continue;
        while (first < s && !is_known(&cells[first], &cells[s], system))
            first++;
        if (first < s)
            cells[s].row.attractor = cells[first].row.attractor;
        else
            found++;
    }
}

/* What a result is made of, in arrays that hold all seeds one after the other. */
typedef struct bundle {
    saltus_sweep_row *rows;
    long long *counts; /* turning, impacts, strobes: seeds each */
    double *states, *turning, *strobes;
    saltus_sweep_impact *impacts;
} bundle;

static void free_bundle(bundle *b) {
    free(b->rows);
    free(b->counts);
    free(b->states);
    free(b->turning);
    free(b->strobes);
    free(b->impacts);
}

static void *room(long long count, size_t size, bool *sound) {
    void *made = malloc(count ? (size_t)count * size : 1);
    *sound = *sound && made;
    return made;
}

static bool open_bundle(bundle *b, const saltus_cell *cells, int seeds, size_t n) {
    long long turning = 0, impacts = 0, strobes = 0;
    bool sound = true;
    for (int s = 0; s < seeds; s++) {
        turning += cells[s].turning_count;
        impacts += cells[s].impact_count;
        strobes += cells[s].strobe_count;
    }
    *b = (bundle){.rows = room(seeds, sizeof *b->rows, &sound),
                  .counts = room(3 * seeds, sizeof *b->counts, &sound),
                  .states = room(seeds, n * sizeof *b->states, &sound),
                  .turning = room(turning, sizeof *b->turning, &sound),
                  .strobes = room(strobes, n * sizeof *b->strobes, &sound),
                  .impacts = room(impacts, sizeof *b->impacts, &sound)};
    return sound;
}

static void append(double *to, const double *from, size_t count) {
    if (count)
        memcpy(to, from, count * sizeof *to);
}

static void fill_bundle(bundle *b, const saltus_cell *cells, int seeds, size_t n) {
    size_t turning = 0, impacts = 0, strobes = 0;
    for (int s = 0; s < seeds; s++) {
        const saltus_cell *c = &cells[s];
        b->rows[s] = c->row;
        append(b->states + (size_t)s * n, c->state, n);
        append(b->turning + turning, c->turning, (size_t)c->turning_count);
        append(b->strobes + strobes * n, c->strobes, (size_t)c->strobe_count * n);
        for (long long k = 0; k < c->impact_count; k++)
            b->impacts[impacts + (size_t)k] =
                (saltus_sweep_impact){c->impacts[3 * k], c->impacts[3 * k + 1], (int)c->impacts[3 * k + 2]};
        turning += (size_t)(b->counts[s] = c->turning_count);
        impacts += (size_t)(b->counts[seeds + s] = c->impact_count);
        strobes += (size_t)(b->counts[2 * seeds + s] = c->strobe_count);
    }
}

saltus_status saltus_job_emit(saltus_job *job, int place, const saltus_system *system,
                              const saltus_sweep_feed *feed, saltus_message *message) {
    saltus_cell *cells = job->cells + place * job->seeds;
    size_t n = (size_t)job->sweep->dimension;
    bundle b = {0};
    saltus_status status = SALTUS_OK;
    number_attractors(cells, job->seeds, system);
    if (!open_bundle(&b, cells, job->seeds, n))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the results of a sweep");
    if (status == SALTUS_OK) {
        fill_bundle(&b, cells, job->seeds, n);
        saltus_sweep_result result = {.place = saltus_sweep_task_place(job->sweep, job->task, place),
                                      .rows = b.rows,
                                      .states = b.states,
                                      .turning_counts = b.counts,
                                      .impact_counts = b.counts + job->seeds,
                                      .strobe_counts = b.counts + 2 * job->seeds,
                                      .turning = b.turning,
                                      .impacts = b.impacts,
                                      .strobes = b.strobes};
        status = feed->take(feed->context, &result, message);
    }
    free_bundle(&b);
    for (int s = 0; s < job->seeds; s++)
        clear_cell(&cells[s]);
    return status;
}
