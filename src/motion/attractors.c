/* Distinct attractors from random initial states.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/motion.h"

#include "motion/motion.h"
#include "motion/verdict.h"

#include <stdlib.h>

/* Count a motion with its attractor, or take it over as a new one. */
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

/* A caller who has once refused to go on is not asked again. */
typedef struct caller {
    const saltus_classify_options *options;
    bool refused;
} caller;

static bool ask(void *context, long long periods, long long at_most) {
    caller *self = context;
    const saltus_classify_options *o = self->options;
    self->refused = self->refused || !o->progress(o->context, periods, at_most);
    return !self->refused;
}

saltus_status saltus_attractors_find(const saltus_system *system, int seeds, unsigned long seed,
                                     const saltus_classify_options *options, saltus_attractors *attractors,
                                     saltus_message *message) {
    *attractors = (saltus_attractors){.seeds = seeds};
    caller self = {.options = options};
    saltus_classify_options asking = *options;
    asking.progress = options->progress ? ask : NULL;
    asking.context = &self;
    if (seeds < 1 || seeds > 1000000)
        return saltus_fail(message, SALTUS_BAD_INPUT, "seeds = %d: must be from 1 to 1000000", seeds);
    double state[SALTUS_STATE_MAX];
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    attractors->motions = calloc((size_t)seeds, sizeof *attractors->motions);
    attractors->shares = calloc((size_t)seeds, sizeof *attractors->shares);
    saltus_status status = SALTUS_OK;
    if (!rng || !attractors->motions || !attractors->shares)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d seeds", seeds);
    else
        gsl_rng_set(rng, seed);
    for (int k = 0; k < attractors->seeds && status == SALTUS_OK; k++) {
        saltus_motion motion = {0};
        status = saltus_state_random(system, rng, state, message);
        if (status == SALTUS_OK)
            status = saltus_classify(system, state, &asking, &motion, message);
        /* A classification that was interrupted before it settled says nothing of an attractor. */
        bool asked_to = self.refused || saltus_motion_stopped(&options->flow),
             stopped = asked_to && !saltus_verdict_settled(motion.verdict);
        if (status == SALTUS_INTERRUPTED || (status == SALTUS_OK && stopped)) {
            saltus_motion_clear(&motion);
            attractors->seeds = k;
            status = SALTUS_OK;
            break;
        }
        if (status == SALTUS_OK)
            sort_in(system, attractors, &motion);
        if (self.refused)
            attractors->seeds = k + 1;
    }
    if (rng)
        gsl_rng_free(rng);
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
