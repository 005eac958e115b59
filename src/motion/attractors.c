/* Distinct attractors from random initial states.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"
#include "signal/random.h"

#include <stdlib.h>

/* Periods over which the next initial state may be measured: its share of what is left, but at least what it
 * takes to assert chaos, and at most options->measure. */
static long long share_of(const saltus_classify_options *options, long long left, int seeds) {
    long long share = left / seeds, least = 4 * options->lifetime;
    share = share > least ? share : least;
    return share < options->measure ? share : options->measure;
}

/* Count a motion with its attractor, or add it as a new one. */
static void sort_in(const saltus_system *system, saltus_attractors *found, saltus_motion *motion) {
    saltus_ending ending = saltus_motion_ending(motion);
    for (int k = 0; k < found->count; k++) {
        saltus_ending known = saltus_motion_ending(&found->motions[k]);
        if (saltus_same_attractor(system, &known, &ending, SALTUS_SAME_POINT)) {
            found->shares[k]++;
            saltus_motion_clear(motion);
            return;
        }
    }
    found->motions[found->count] = *motion;
    found->shares[found->count++] = 1;
}

/* Most frequent first; among equals the order of discovery. */
static void order_by_share(saltus_attractors *found) {
    for (int i = 1; i < found->count; i++)
        for (int j = i; j > 0 && found->shares[j] > found->shares[j - 1]; j--) {
            saltus_motion motion = found->motions[j];
            int share = found->shares[j];
            found->motions[j] = found->motions[j - 1];
            found->shares[j] = found->shares[j - 1];
            found->motions[j - 1] = motion;
            found->shares[j - 1] = share;
        }
}

/* Turns the progress of one classification into that of all initial states. */
typedef struct seeds_told {
    saltus_progress to;
    double before, all;
} seeds_told;

static void show_part(void *context, double done, double all) {
    static const double nearly = 0.99; /* the rest follows when the motion is sorted in */
    const seeds_told *told = context;
    saltus_progress_show(told->to, told->before + nearly * done / all, told->all);
}

saltus_status saltus_attractors_find(const saltus_system *system, int seeds, unsigned long seed,
                                     const saltus_classify_options *options, saltus_attractors *attractors,
                                     saltus_message *message) {
    *attractors = (saltus_attractors){.seeds = seeds, .asked = seeds};
    if (seeds < 1 || seeds > 1000000)
        return saltus_fail(message, SALTUS_BAD_INPUT, "seeds = %d: must be from 1 to 1000000", seeds);
    double state[SALTUS_STATE_MAX];
    seeds_told told = {.to = options->progress, .all = seeds};
    saltus_classify_options how = *options;
    long long left = options->measure;
    how.progress = (saltus_progress){show_part, &told};
    saltus_random random;
    gsl_rng *rng = saltus_random_seed(&random, seed);
    attractors->motions = calloc((size_t)seeds, sizeof *attractors->motions);
    attractors->shares = calloc((size_t)seeds, sizeof *attractors->shares);
    saltus_status status = SALTUS_OK;
    if (!attractors->motions || !attractors->shares)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d seeds", seeds);
    for (int k = 0; k < attractors->seeds && status == SALTUS_OK; k++) {
        saltus_motion motion = {0};
        bool stopped = false;
        told.before = k;
        saltus_progress_show(options->progress, k, seeds);
        how.measure = share_of(options, left, seeds - k);
        status = saltus_state_random(system, rng, state, message);
        if (status == SALTUS_OK)
            status = saltus_motion_classify(system, state, &how, &motion, &stopped, message);
        left -= motion.evidence.periods < left ? motion.evidence.periods : left;
        stopped |= status == SALTUS_INTERRUPTED;
        if (stopped)
            attractors->seeds = k + saltus_verdict_settled(motion.verdict);
        if (status == SALTUS_INTERRUPTED)
            status = SALTUS_OK;
        /* A classification that was stopped before it settled tells nothing about the attractor. */
        if (status == SALTUS_OK && k < attractors->seeds)
            sort_in(system, attractors, &motion);
        else
            saltus_motion_clear(&motion);
    }
    if (status == SALTUS_OK)
        order_by_share(attractors);
    else
        saltus_attractors_clear(attractors);
    return status;
}

void saltus_attractors_clear(saltus_attractors *attractors) {
    for (int k = 0; k < attractors->count; k++)
        saltus_motion_clear(&attractors->motions[k]);
    free(attractors->motions);
    free(attractors->shares);
    *attractors = (saltus_attractors){0};
}
