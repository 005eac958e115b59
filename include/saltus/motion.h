/* What a trajectory settles on: n/p periodic motion, chatter, an equilibrium, permanent contact, or
 * undecided.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_H
#define SALTUS_MOTION_H

#include "saltus/equilibrium.h"
#include "saltus/lyapunov.h"
#include "saltus/orbit.h"

SALTUS_API_BEGIN

/* The kind of motion found. */
typedef enum saltus_verdict {
    SALTUS_PENDING,       /* not computed yet: a row of an interrupted sweep */
    SALTUS_PERIODIC,      /* n/p, chatter included */
    SALTUS_EQUILIBRIUM,   /* at rest without contact force */
    SALTUS_HELD,          /* in permanent contact */
    SALTUS_QUASIPERIODIC, /* largest exponent zero, line spectrum, closed curves in the section */
    SALTUS_CHAOTIC, /* largest exponent positive, no escape for the required time, no stable orbit within the
                       chaotic set */
    SALTUS_LONG_PERIOD, /* largest exponent negative: a longer period, or a slow approach to an orbit */
    SALTUS_UNDECIDED,   /* no period found, and the measured exponent is not conclusive */
    SALTUS_FAILED,      /* the flow could not start, or gave up */
    SALTUS_TRANSIENT,   /* chaotic so far, but trajectories have escaped, or a stable orbit lies within the
                           chaotic set */
    SALTUS_IRREGULAR,   /* no period found; exponents not measured, or not long enough */
    SALTUS_BEYOND,      /* a row of a sweep: the scene's initial state lies beyond a stop */
    SALTUS_VERDICTS
} saltus_verdict;

/* "periodic", "equilibrium", "held", "quasi-periodic", "chaotic", "long-period", ... */
const char *saltus_verdict_word(saltus_verdict verdict);
/* Whether it is periodic, an equilibrium or held. */
bool saltus_verdict_settled(saltus_verdict verdict);
/* Whether it tells of no motion: pending, failed or beyond a stop. */
bool saltus_verdict_nothing(saltus_verdict verdict);
/* The label: "4/4" or "chatter/2" (impacts = -1) for a periodic motion, otherwise the verdict's word. */
void saltus_verdict_label(saltus_verdict verdict, long long impacts, int periods,
                          char label[SALTUS_LABEL_MAX]);

typedef enum saltus_mirror {
    SALTUS_MIRROR_NONE, /* the scene has no mirror symmetry */
    SALTUS_MIRROR_SELF, /* the orbit is its own mirror image */
    SALTUS_MIRROR_PAIR, /* one of a pair of mirror images */
    SALTUS_MIRROR_OPEN  /* not compared: the scene is symmetric, but the motion is no orbit or equilibrium */
} saltus_mirror;

typedef struct saltus_classify_options {
    saltus_flow_options flow;
    long long transient; /* longest time to settle, in periods; without forcing longer, where that is cheap,
                            while hardly any return has come; default 20000 */
    long long measure; /* most periods for measuring the largest exponent if no period is found, summed over 8
                          trajectories; 0: such a motion is called irregular; default 256000 */
    long long lifetime; /* periods; chaos is asserted only if its mean lifetime is at least this with 95 %
                           confidence, which takes three times as many periods without an escape; default
                           10000 */
    int longest;        /* longest period tried, in forcing periods; default 64 */
    /* Periods simulated until the motion has settled, then periods measured. In saltus_attractors_find:
     * initial states done, with a fraction for the current one. */
    saltus_progress progress;
} saltus_classify_options;

/* The defaults stated beside the options. */
saltus_classify_options saltus_classify_defaults(void);

/* The evidence for the verdict on a motion without a period. Numbers that were not computed are NAN. */
typedef struct saltus_evidence {
    long long periods;              /* measured, summed over the trajectories; 0: nothing was measured */
    int members;                    /* trajectories */
    double half[2], half_errors[2]; /* largest exponent from the first and the second half of the run */
    double zero_one;                /* 0-1 test: about 0 for regular motion, 1 for chaos */
    double zero_one_quartiles[2];
    double dimension, dimension_error; /* correlation dimension of the section points */
    double broadband;                  /* fraction of the section points' variance outside spectral lines */
    int curves;                /* number of closed curves that the section points fill; 0: they fill none */
    double impacts_per_period; /* NAN with complete chatter */
    double laminar;            /* fraction of the time spent near a periodic motion (intermittency) */
    int laminar_period;        /* period of that motion; 0: no intermittency */
    long long longest_phase;   /* longest of these laminar phases, in periods */
    /* Chaos may be a transient with a constant probability of ending per period. The periods watched without
     * an escape give a lower bound of its mean lifetime: M L / 3 for M trajectories of L periods each. */
    double lifetime_at_least; /* periods, with 95 % confidence; NAN where the exponent is not positive */
    double lifetime;          /* mean lifetime from the observed escapes; NAN without any */
    int left;                 /* trajectories that escaped to a regular motion */
    char left_for[32];        /* label of that motion */
    char stable_orbit[32];    /* label of a stable orbit found within the chaotic set, or "" */
    saltus_lyapunov_progress *history; /* of the largest exponent */
    int history_count;
} saltus_evidence;

/* The verdict on one trajectory, with its arrays. */
typedef struct saltus_motion {
    saltus_verdict verdict;
    char label[32];   /* "4/4", "0/1", "chatter/2", "equilibrium", "held", "quasi-periodic", "chaotic",
                         "transient", "long-period", "irregular", "undecided" */
    char reason[384]; /* motions without a period: what is known and what is lacking; for an orbit of a
                         conservative scene, that it belongs to a continuum */
    int periods; /* p, least period in forcing periods (without forcing: in returns to the section); 0 if not
                    periodic */
    double period;                               /* least period in units of time; NAN if not periodic */
    long long impacts;                           /* n per orbit; -1 with complete chatter, in any motion */
    int sticking_intervals;                      /* per orbit */
    long long impacts_by_face[SALTUS_FACES_MAX]; /* with chatter only those simulated one by one */
    long long counted; /* periods over which impacts and sticking were counted: those of the orbit, or 400
                          without a period; 0: not counted */
    int face_count;
    int dimension;
    double *state; /* q, q', extra states at section phase 0; of an orbit without forcing at its first section
                      point: the highest maximum or the fastest impact */
    double *section_states; /* periods x dimension: the orbit's stroboscopic points; without forcing its
                               returns to the section (saltus_poincare) */
    saltus_event *events;   /* of one orbit; times from its start */
    int event_count;
    saltus_multiplier *multipliers; /* multiplier_count of them, by decreasing modulus */
    int multiplier_count;
    double trivial_multiplier; /* of an orbit without forcing: the multiplier along the flow, not among the
                                  others, 1 up to errors; otherwise 0 */
    /* At an equilibrium without forcing: by decreasing real part; with contacts, of the motion that keeps
     * them. NULL elsewhere, and if the equilibrium is not isolated. */
    saltus_eigenvalue *eigenvalues;
    int eigenvalue_count;
    bool stable;
    double residual; /* of Newton's method, relative to the state's scale */
    int iterations;
    bool sticks;
    double log_volume, sum_rule; /* see saltus_orbit */
    saltus_mirror mirror;
    double contact_force[SALTUS_FACES_MAX]; /* held: contact forces at section phase 0, as in
                                               saltus_flow_forces */
    double largest, smallest; /* of the observed displacement over the orbit, or over 400 periods without one;
                                 of its last state if the search was stopped */
    double rms; /* root mean square of the observed displacement, not of its deviation from the mean; NAN if
                   the search was stopped */
    long long transient; /* periods simulated before the verdict */
    double lyapunov;     /* largest exponent per unit of time: of an orbit ln |multiplier| / (p T), otherwise
                            measured; NAN if not measured */
    double lyapunov_error;        /* standard error; 0 for an orbit */
    saltus_integrator integrator; /* as requested; automatic: the system's own choice */
    saltus_evidence evidence;     /* only for motions without a period */
} saltus_motion;

/* Settle from an initial state (length dimension, at phase 0) and classify. An undecided motion is a success
 * too; if the search is stopped the motion is undecided. On success free the arrays with saltus_motion_clear.
 * Errors: SALTUS_BAD_INPUT (state beyond a stop), those of the flow. */
saltus_status saltus_classify(const saltus_system *system, const double *state,
                              const saltus_classify_options *options, saltus_motion *motion,
                              saltus_message *message);
/* Classify a periodic orbit found by other means, stable or not. An orbit that repeats within its period is
 * described with its least period. On success free the arrays with saltus_motion_clear. Errors: those of the
 * flow; those of saltus_orbit_find if the period was reduced. */
saltus_status saltus_motion_describe(const saltus_system *system, const saltus_orbit *orbit,
                                     const saltus_classify_options *options, saltus_motion *motion,
                                     saltus_message *message);
/* Find and classify an orbit of a scene without forcing, stable or not, from a state near it that returns
 * after about the system's period (saltus_spec_set_omega). Free with saltus_motion_clear. Errors:
 * SALTUS_BAD_INPUT for a forced scene, SALTUS_NO_CONVERGENCE if there is no orbit or only an equilibrium,
 * those of the flow. */
saltus_status saltus_motion_cycle(const saltus_system *system, const double *guess,
                                  const saltus_classify_options *options, saltus_motion *motion,
                                  saltus_message *message);
/* Find and describe an equilibrium of a scene without forcing, stable or not, near a guess
 * (saltus_equilibrium_find). Free with saltus_motion_clear. Errors: those of saltus_equilibrium_find. */
saltus_status saltus_motion_equilibrium(const saltus_system *system, const double *guess,
                                        const saltus_classify_options *options, saltus_motion *motion,
                                        saltus_message *message);
/* For an orbit with its own period, use the mean time between returns as the unit that the forcing period is
 * for forced orbits. *counted receives a system with that unit, to be freed by the caller; the motion's
 * section points and event times are converted to its phase 0. Errors: those of the flow,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_motion_count_returns(const saltus_system *system, const saltus_flow_options *options,
                                          saltus_motion *motion, saltus_system **counted,
                                          saltus_message *message);
/* As saltus_motion_cycle, for an orbit of `periods` returns to the section, found by Newton's method from the
 * closest returns of the trajectory from `state` within options->transient periods. */
saltus_status saltus_motion_returning(const saltus_system *system, const double *state, int periods,
                                      const saltus_classify_options *options, saltus_motion *motion,
                                      saltus_message *message);
/* The `count` largest exponents of a periodic orbit, from its multipliers and without forcing the zero along
 * the flow, or of an equilibrium, from its eigenvalues. Nothing is measured: `members` is 0, at an
 * equilibrium `periods` and `time` too. Instead of standard errors there is how accurately the exponents are
 * known: logarithms of multipliers to 1e-10 and flow.rtol per period, less accurately where the multiplier
 * along the flow or the sum rule shows it, or where a multiplier near 1 leaves the orbit uncertain; real
 * parts of eigenvalues to 1e-12 of the largest modulus. Free with saltus_lyapunov_clear. Errors:
 * SALTUS_BAD_INPUT (neither orbit nor isolated equilibrium, count out of range), SALTUS_NO_MEMORY. */
saltus_status saltus_motion_exponents(const saltus_system *system, const saltus_motion *motion,
                                      const saltus_flow_options *flow, int count, saltus_lyapunov *lyapunov,
                                      saltus_message *message);
/* Replace a state at phase 0 by its mirror image q -> -q, followed by half a period of flow if the symmetry
 * includes that shift. Errors: SALTUS_BAD_INPUT if the scene has no mirror symmetry, those of the flow. */
saltus_status saltus_motion_mirror(const saltus_system *system, const saltus_flow_options *options,
                                   double *state, saltus_message *message);
/* Advance a state at phase 0 by whole periods. Errors: those of the flow, SALTUS_STALLED if a stop holds the
 * system far beyond the scale of its motion. */
saltus_status saltus_motion_settle(const saltus_system *system, const saltus_flow_options *options,
                                   long long periods, double *state, saltus_message *message);
/* Free the arrays; a zeroed motion is accepted. */
void saltus_motion_clear(saltus_motion *motion);

/* The distinct attractors reached from random initial states. */
typedef struct saltus_attractors {
    saltus_motion *motions; /* `count` of them, most frequent first */
    int *shares;            /* number of initial states that went to each */
    int count;
    int seeds, asked; /* initial states done, and asked for: more if the search was stopped */
} saltus_attractors;

/* Classify from `seeds` random admissible initial states: Gaussian with the system's scales (GSL's mt19937
 * from `seed`, reproducible); states beyond a stop are drawn again. Attractors are distinguished by their
 * orbits' section points. If stopped, `seeds` becomes the number of initial states done. All initial states
 * share options->measure; each may use at least four lifetimes (what it takes to assert chaos), if measure
 * allows. */
saltus_status saltus_attractors_find(const saltus_system *system, int seeds, unsigned long seed,
                                     const saltus_classify_options *options, saltus_attractors *attractors,
                                     saltus_message *message);
void saltus_attractors_clear(saltus_attractors *attractors);

SALTUS_API_END
#endif
