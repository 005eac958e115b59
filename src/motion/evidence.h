/* Private: what exponents and section points say about a motion without a period.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_EVIDENCE_H
#define SALTUS_MOTION_EVIDENCE_H

#include "saltus/motion.h"

/* Standard errors by which an exponent must differ from zero. */
#define SALTUS_SIGNIFICANT 3.0

typedef enum saltus_outcome {
    SALTUS_OUTCOME_GOES_ON, /* not to be told yet */
    SALTUS_OUTCOME_CHAOS,
    SALTUS_OUTCOME_TORUS,
    SALTUS_OUTCOME_REGULAR, /* nothing irregular: a period must show */
    SALTUS_OUTCOME_LEFT     /* other trajectories on the motion have come to something regular */
} saltus_outcome;

/* The largest exponent, per unit of time, from a run and from its halves. */
typedef struct saltus_runs {
    saltus_estimate all, first, second;
    double period; /* T */
    bool enough;   /* the run is long enough to assert chaos */
    bool lost;     /* nothing is left of any perturbation */
} saltus_runs;

/* What the exponent says. A torus is only suspected: the section points must be asked. */
saltus_outcome saltus_runs_weigh(const saltus_runs *runs);
/* The same outcome, given what the section points say. */
saltus_outcome saltus_runs_conclude(const saltus_runs *runs, saltus_outcome outcome,
                                    const saltus_evidence *evidence);
/* Second opinions on `count` section points (dimension numbers each, SALTUS_SERIES_LEAST at least): fills 0-1
 * test, broadband part, closed curves and dimension. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT. */
saltus_status saltus_evidence_of_points(const saltus_system *system, const double *points, long long count,
                                        saltus_evidence *evidence, saltus_message *message);

#endif
