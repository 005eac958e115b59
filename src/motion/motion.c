/* Motions: opening, clearing, and the options of shooting for their orbits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"

#include <math.h>
#include <stdlib.h>

/* Newton's residual cannot fall below what the flow's tolerance allows. */
saltus_orbit_options saltus_motion_shooting(const saltus_classify_options *options) {
    saltus_orbit_options shooting = saltus_orbit_defaults();
    shooting.flow = options->flow;
    shooting.tolerance = fmax(1e-12, 100 * options->flow.rtol);
    return shooting;
}

void saltus_motion_forget_evidence(saltus_motion *m) {
    free(m->evidence.history);
    m->evidence = (saltus_evidence){.half = {NAN, NAN},
                                    .half_errors = {NAN, NAN},
                                    .zero_one = NAN,
                                    .zero_one_quartiles = {NAN, NAN},
                                    .dimension = NAN,
                                    .dimension_error = NAN,
                                    .broadband = NAN,
                                    .impacts_per_period = NAN,
                                    .lifetime_at_least = NAN,
                                    .lifetime = NAN};
}

bool saltus_motion_open(const saltus_system *system, const saltus_flow_options *flow, saltus_motion *motion) {
    *motion = (saltus_motion){.verdict = SALTUS_UNDECIDED,
                              .dimension = saltus_system_dimension(system),
                              .period = NAN,
                              .lyapunov = NAN,
                              .lyapunov_error = NAN,
                              .integrator = flow->integrator,
                              .face_count = saltus_system_face_count(system)};
    saltus_motion_forget_evidence(motion);
    motion->state = calloc((size_t)motion->dimension, sizeof *motion->state);
    return motion->state;
}

void saltus_motion_clear(saltus_motion *motion) {
    free(motion->state);
    free(motion->section_states);
    free(motion->events);
    free(motion->multipliers);
    free(motion->eigenvalues);
    free(motion->evidence.history);
    *motion = (saltus_motion){0};
}
