/* Distinct attractors from random initial states.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"
#include "signal/random.h"

#include <stdlib.h>

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
        /* The next initial state's share of what is left, but at least what it takes to assert chaos. */
        const long long share = left / (seeds - k), least = 4 * options->lifetime,
                        wanted = share > least ? share : least;
        how.measure = wanted < options->measure ? wanted : options->measure;
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
    if (status != SALTUS_OK)
        saltus_attractors_clear(attractors);
    /* Most frequent first; among equals the order of discovery. */
    for (int i = 1; i < attractors->count; i++)
        for (int j = i; j > 0 && attractors->shares[j] > attractors->shares[j - 1]; j--) {
            const saltus_motion motion = attractors->motions[j];
            const int share = attractors->shares[j];
            attractors->motions[j] = attractors->motions[j - 1];
            attractors->shares[j] = attractors->shares[j - 1];
            attractors->motions[j - 1] = motion;
            attractors->shares[j - 1] = share;
        }
    return status;
}

void saltus_attractors_clear(saltus_attractors *attractors) {
    for (int k = 0; k < attractors->count; k++)
        saltus_motion_clear(&attractors->motions[k]);
    free(attractors->motions);
    free(attractors->shares);
    *attractors = (saltus_attractors){0};
}
