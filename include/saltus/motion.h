/* What a trajectory settles on: n/p periodic motion, chatter, rest, contact for good, or not decided.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_H
#define SALTUS_MOTION_H

#include "saltus/equilibrium.h"
#include "saltus/lyapunov.h"
#include "saltus/orbit.h"

SALTUS_API_BEGIN

/* What a trajectory has come to. */
typedef enum saltus_verdict {
    SALTUS_PENDING,       /* nothing yet: a row of an interrupted sweep */
    SALTUS_PERIODIC,      /* n/p, chatter included */
    SALTUS_EQUILIBRIUM,   /* at rest without contact force */
    SALTUS_HELD,          /* in contact for good */
    SALTUS_QUASIPERIODIC, /* largest exponent zero, spectrum of lines, closed curves in the section */
    SALTUS_CHAOTIC,       /* largest exponent positive, none has left it for as long as was asked, no stable
                             orbit amid it */
    SALTUS_LONG_PERIOD,   /* exponent negative: a longer period, or one that is reached slowly */
    SALTUS_UNDECIDED,     /* no period found, and the exponent measured does not tell */
    SALTUS_FAILED,        /* the flow gave up, or the initial state is not admissible */
    SALTUS_TRANSIENT,     /* chaotic as yet, but trajectories have left it, or a stable orbit lies amid it */
    SALTUS_IRREGULAR,     /* no period found, exponents not measured, or not for long enough */
    SALTUS_VERDICTS
} saltus_verdict;

/* "periodic", "equilibrium", "held", "quasi-periodic", "chaotic", "long-period", ... */
const char *saltus_verdict_word(saltus_verdict verdict);
/* Whether it is an orbit or a rest. */
bool saltus_verdict_settled(saltus_verdict verdict);
/* "4/4", "chatter/2" (impacts = -1) of a periodic motion, otherwise the word. */
void saltus_verdict_label(saltus_verdict verdict, long long impacts, int periods,
                          char label[SALTUS_LABEL_MAX]);

typedef enum saltus_mirror {
    SALTUS_MIRROR_NONE, /* the scene has no mirror symmetry */
    SALTUS_MIRROR_SELF, /* the orbit is its own mirror image */
    SALTUS_MIRROR_PAIR, /* one of a pair */
    SALTUS_MIRROR_OPEN  /* the scene has it, but the motion is no orbit or rest whose image could be compared
                         */
} saltus_mirror;

typedef struct saltus_classify_options {
    saltus_flow_options flow;
    long long transient; /* periods to wait at most for the motion to settle; default 20000 */
    long long measure;   /* periods at most over which the largest exponent is measured where no period is
                            found, by 8 trajectories together; 0: such a motion is irregular; default 256000 */
    long long lifetime;  /* periods: chaos is asserted where its mean lifetime is at least this, with 95 %
                      confidence; that takes three times as many periods without an escape; default 10000 */
    int longest;         /* longest period tried, in forcing periods; default 64 */
    /* Periods simulated until the motion has settled, then periods measured. From saltus_attractors_find:
     * initial states done, the one under way counted by the part of its longest time. */
    saltus_progress progress;
} saltus_classify_options;

/* As told beside the options. */
saltus_classify_options saltus_classify_defaults(void);

/* What the verdict on a motion without a period rests on. Numbers are NAN where they were not computed. */
typedef struct saltus_evidence {
    long long periods;              /* measured by all trajectories together; 0: nothing was measured */
    int members;                    /* trajectories */
    double half[2], half_errors[2]; /* largest exponent from the first and the second half of the run */
    double zero_one;                /* 0-1 test: about 0 for regular motion, 1 for chaos */
    double zero_one_quartiles[2];
    double dimension, dimension_error; /* correlation dimension of the section points */
    double broadband;                  /* part of the section points' variance that is not in lines */
    int curves;                        /* closed curves that the section points fill; 0: they do not */
    double impacts_per_period;         /* NAN with complete chatter */
    double laminar;                    /* part of the time spent near a periodic motion, ... */
    int laminar_period;                /* ... of this period; 0: no intermittency */
    long long longest_phase;           /* longest of these laminar phases, in periods */
    /* Chaos may be a transient that ends by chance, at any time alike. Periods watched until trajectories
     * left it bound its mean lifetime from below: M trajectories of L periods of which none has left, by M L
     * / 3. */
    double lifetime_at_least; /* periods, with 95 % confidence; NAN where the exponent is not positive */
    double lifetime;          /* mean, from the times of escape; NAN where none has left */
    int left;                 /* trajectories that left for a regular motion, ... */
    char left_for[32];        /* ... of this label */
    char stable_orbit[32];    /* label of a stable orbit found amid the chaos, or "" */
    saltus_lyapunov_progress *history; /* of the largest exponent */
    int history_count;
} saltus_evidence;

/* The verdict on one trajectory. Arrays are owned by the motion. */
typedef struct saltus_motion {
    saltus_verdict verdict;
    char label[32];         /* "4/4", "0/1", "chatter/2", "equilibrium", "held", "quasi-periodic", "chaotic",
                               "transient", "long-period", "irregular", "undecided" */
    char reason[384];       /* motions without a period: what is known, what is lacking; of an orbit of a
                               conservative scene that it is one of a continuum */
    int periods;            /* p, least period in forcing periods, without forcing in returns to the section;
                               0 if not periodic */
    double period;          /* least period in units of time; NAN if not periodic */
    long long impacts;      /* n per orbit; -1 when complete chatter makes it infinite, in any motion */
    int sticking_intervals; /* per orbit */
    long long impacts_by_face[SALTUS_FACES_MAX]; /* with chatter those simulated one by one */
    long long counted; /* periods that these were counted over: an orbit's, or 400 of a motion without a
                          period; 0: not counted */
    int face_count;
    int dimension;
    double *state;          /* at section phase 0: q, q', extra states; of an orbit without forcing at its
                               first section point: the highest of maxima, the fastest of impacts */
    double *section_states; /* periods x dimension: the orbit's stroboscopic points, without forcing its
                               returns to the section (saltus_poincare) */
    saltus_event *events;   /* of one orbit, times from its start */
    int event_count;
    saltus_multiplier *multipliers; /* multiplier_count of them, by decreasing modulus */
    int multiplier_count;
    double trivial_multiplier; /* of an orbit without forcing that along the flow, which is none of the
                                  others: 1 but for errors; otherwise 0 */
    /* Of a rest without forcing, by decreasing real part; with a contact held those of the motion that keeps
     * it. NULL elsewhere, and where the rest is not isolated. */
    saltus_eigenvalue *eigenvalues;
    int eigenvalue_count;
    bool stable;
    double residual; /* of Newton's iteration, relative to the state's scale */
    int iterations;
    bool sticks;
    double log_volume, sum_rule; /* see saltus_orbit */
    saltus_mirror mirror;
    double contact_force[SALTUS_FACES_MAX]; /* held: at section phase 0, as saltus_flow_forces has them */
    double largest, smallest; /* of the observed displacement over the orbit, or over 400 periods of a motion
                                 without one; of its last state where the search was stopped early */
    double rms;          /* root mean square of the same, about zero; NAN where these were not gone through */
    long long transient; /* periods simulated before the verdict */
    double lyapunov;     /* largest exponent per unit of time: of an orbit ln |multiplier| / (p T), else as
                            measured; NAN where it was not */
    double lyapunov_error;        /* its standard error; 0 for an orbit's */
    saltus_integrator integrator; /* that was asked for; automatic: the system's own */
    saltus_evidence evidence;     /* of motions without a period */
} saltus_motion;

/* Settle from an initial state (length dimension, at phase 0) and classify. On success the motion's arrays
 * are owned by it: saltus_motion_clear. An undecided motion is a success too; a motion whose search was
 * stopped is undecided. Errors: SALTUS_BAD_INPUT (state beyond a stop), those of the flow. */
saltus_status saltus_classify(const saltus_system *system, const double *state,
                              const saltus_classify_options *options, saltus_motion *motion,
                              saltus_message *message);
/* What classification would say of a periodic orbit found otherwise, stable or not. An orbit that repeats
 * after a part of its period is described with its least period. The motion's arrays are owned by it:
 * saltus_motion_clear. Errors: those of the flow; those of saltus_orbit_find where the period was reduced. */
saltus_status saltus_motion_describe(const saltus_system *system, const saltus_orbit *orbit,
                                     const saltus_classify_options *options, saltus_motion *motion,
                                     saltus_message *message);
/* The orbit, stable or not, of a scene without forcing from a state on it that closes after about the
 * system's period (saltus_spec_set_omega), described as classification does. To be cleared. Errors:
 * SALTUS_BAD_INPUT for a forced scene, SALTUS_NO_CONVERGENCE where there is none or it is a rest, those of
 * the flow. */
saltus_status saltus_motion_cycle(const saltus_system *system, const double *guess,
                                  const saltus_classify_options *options, saltus_motion *motion,
                                  saltus_message *message);
/* Count an orbit with a period of its own by the mean time between its returns, as forced orbits are counted
 * by the forcing's period: *counted (the caller's) is the system for that, and the motion's section points
 * and event times become those of its phase 0. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_count_returns(const saltus_system *system, const saltus_flow_options *options,
                                          saltus_motion *motion, saltus_system **counted,
                                          saltus_message *message);
/* As saltus_motion_cycle for an orbit of so many returns to the section near the trajectory from a state,
 * found by Newton's method from its closest returns within options->transient periods. */
saltus_status saltus_motion_returning(const saltus_system *system, const double *state, int periods,
                                      const saltus_classify_options *options, saltus_motion *motion,
                                      saltus_message *message);
/* The exponents of a motion's periodic orbit, the `count` largest, from its multipliers: nothing is measured,
 * so `members` is 0 and all errors are 0. To be cleared by saltus_lyapunov_clear. Errors: SALTUS_BAD_INPUT
 * (no orbit, count out of range), SALTUS_NO_MEMORY. */
saltus_status saltus_motion_exponents(const saltus_system *system, const saltus_motion *motion, int count,
                                      saltus_lyapunov *lyapunov, saltus_message *message);
/* Replace a state at phase 0 by its mirror image, q -> -q, after half a period where the symmetry needs that
 * shift. Errors: SALTUS_BAD_INPUT where the scene has no mirror symmetry, those of the flow. */
saltus_status saltus_motion_mirror(const saltus_system *system, const saltus_flow_options *options,
                                   double *state, saltus_message *message);
/* Follow the flow from a state at phase 0 over whole periods. Errors: those of the flow, SALTUS_STALLED where
 * a stop holds the system far beyond the scale of its motion. */
saltus_status saltus_motion_settle(const saltus_system *system, const saltus_flow_options *options,
                                   long long periods, double *state, saltus_message *message);
/* Free the arrays; a zeroed motion is accepted. */
void saltus_motion_clear(saltus_motion *motion);

/* The distinct attractors reached from random initial states. */
typedef struct saltus_attractors {
    saltus_motion *motions; /* `count` of them, most frequent first */
    int *shares;            /* number of initial states that went to each */
    int count;
    int seeds;
} saltus_attractors;

/* Classify from `seeds` random admissible initial states: Gaussian with the system's scales (GSL's mt19937
 * from `seed`, reproducible), states beyond a stop drawn again. Attractors are told apart by their orbits'
 * section points. Where it is stopped, `seeds` is the number of initial states done until then.
 * options->measure is shared by all initial states, each having as much as it takes to assert chaos (four
 * lifetimes) in any case. */
saltus_status saltus_attractors_find(const saltus_system *system, int seeds, unsigned long seed,
                                     const saltus_classify_options *options, saltus_attractors *attractors,
                                     saltus_message *message);
void saltus_attractors_clear(saltus_attractors *attractors);

SALTUS_API_END
#endif
