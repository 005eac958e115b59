/* Private: what exponents and section points say about a motion without a period.
 *
 * One rule for all who measure. A run is weighed by its exponent: saltus_runs_weigh. That says that the
 * motion is regular, or that it may be a torus or chaos; then its section points are asked, which has the
 * last word: saltus_runs_ask_points. A driver decides how long its runs are and which points it has.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_EVIDENCE_H
#define SALTUS_MOTION_EVIDENCE_H

#include "saltus/motion.h"

/* Standard errors by which an exponent must differ from zero. */
#define SALTUS_SIGNIFICANT 3.0

typedef enum saltus_outcome {
    SALTUS_OUTCOME_OPEN, /* not decided yet */
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

/* How much is asked of section points. */
typedef enum saltus_opinions {
    SALTUS_OPINIONS_TORUS, /* what tells a torus: broadband part, and closed curves where that is small */
    SALTUS_OPINIONS_ALL    /* these in any case, 0-1 test and dimension */
} saltus_opinions;

/* What the exponent says. A torus is only suspected: the section points must be asked. */
saltus_outcome saltus_runs_weigh(const saltus_runs *runs);
/* Fill the evidence with what `count` section points (dimension numbers each, SALTUS_SERIES_LEAST at least)
 * say, and revise the outcome by it. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT. */
saltus_status saltus_runs_ask_points(const saltus_runs *runs, const saltus_system *system,
                                     const double *points, long long count, saltus_opinions opinions,
                                     saltus_evidence *evidence, saltus_outcome *outcome,
                                     saltus_message *message);

#endif
