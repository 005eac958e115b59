/* Branches of periodic orbits: pseudo-arclength continuation in a parameter, special points, branch
 * switching, and curves of special points in two parameters.
 *
 * An orbit is followed with its sequence of events taken as given and the event times among the unknowns,
 * which is smooth where impacts are born or die; the event-driven flow then checks every point: no gap beyond
 * a stop, no contact force that pulls. Where that check fails the point of change is located, and the branch
 * goes on with the new sequence, or ends there and says why.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_H
#define SALTUS_BRANCH_H

#include "saltus/orbit.h"

SALTUS_API_BEGIN

enum { SALTUS_REASON_MAX = 160, SALTUS_KEY_MAX = 32 };

typedef enum saltus_point_kind {
    SALTUS_POINT_REGULAR,
    SALTUS_POINT_LP, /* fold: a multiplier +1, the branch turns back */
    SALTUS_POINT_PD, /* flip: a multiplier -1, orbits of twice the period branch off */
    SALTUS_POINT_NS, /* Neimark-Sacker: a complex pair crosses the unit circle */
    SALTUS_POINT_BP, /* branch point: pitchfork (mirror breaking) or transcritical crossing */
    SALTUS_POINT_GR, /* grazing: the speed of an impact falls to zero, or a free maximum touches a stop */
    SALTUS_POINT_CH, /* complete chatter begins or ends */
    SALTUS_POINT_ST, /* a sticking interval begins, splits or ends otherwise */
    SALTUS_POINT_UZ, /* a value asked for */
    SALTUS_POINT_EP, /* end of the branch; `reason` says why */
    SALTUS_POINT_HB, /* without forcing: Hopf, an orbit shrinks to an equilibrium */
    SALTUS_POINT_BE, /* without forcing: an equilibrium meets a stop, or its contact force falls to zero; an
                        orbit with impacts shrinks to it */
    /* On loci, where one condition more holds: */
    SALTUS_POINT_CP,    /* cusp: two folds meet */
    SALTUS_POINT_GR_LP, /* a fold meets grazing */
    SALTUS_POINT_GR_PD,
    SALTUS_POINT_GR_NS,
    SALTUS_POINT_GR_GR, /* two impacts graze */
    SALTUS_POINT_GR_BP,
    /* On a curve of grazing: the contact that chatter on another impact's face leads to shrinks to nothing,
     * so that the curve along which chatter completes meets this one. The equations are gap and speed of the
     * grazing impact and that the chatter completes in the very time of the release; the curve ends there. */
    SALTUS_POINT_CH_GR,
    SALTUS_POINT_R1, /* resonances: a double multiplier 1, */
    SALTUS_POINT_R2, /* a double multiplier -1, */
    SALTUS_POINT_R3, /* a pair at a third */
    SALTUS_POINT_R4, /* or a quarter of the circle */
    SALTUS_POINT_BT, /* of equilibria: two eigenvalues zero (Bogdanov-Takens), */
    SALTUS_POINT_GH, /* a first Lyapunov coefficient zero (generalised Hopf) */
    /* Where folds or tori of orbits of twice the period become those of half of it; R2 and R4 are others: */
    SALTUS_POINT_GPD,   /* a flip neither super- nor subcritical */
    SALTUS_POINT_LP_PD, /* multipliers 1 and -1 */
    SALTUS_POINT_PD_NS, /* a multiplier -1 and a pair on the unit circle */
    SALTUS_POINT_KINDS
} saltus_point_kind;

/* "", "LP", "PD", ... */
const char *saltus_point_word(saltus_point_kind kind);

/* One point of a branch. Arrays of one that saltus_branch_step gives belong to the branch and last until its
 * next step; saltus_branch_point_copy keeps it. */
typedef struct saltus_branch_point {
    saltus_point_kind kind;
    saltus_point_kind locus; /* what the points of the curve are; REGULAR: orbits, on a branch */
    int branch;              /* 0 up from the start, 1 down from it, 2 ... switched to */
    int parent;              /* switched: the branch it left; otherwise -1 */
    int step;                /* counted along the branch */
    double arclength;        /* along the branch, 0 at its start */
    double value[2];         /* of the continued parameters (the second one: loci only, otherwise NAN) */
    double heading;          /* d value[0] / d arclength */
    saltus_spec spec;        /* all parameters */
    int periods; /* p; of orbits of a period of their own the returns to the section, as in saltus_motion; 0:
                    an equilibrium */
    double period; /* in units of time; of an equilibrium that of the cycles born there (HB), otherwise NAN */
    long long impacts; /* n per orbit; -1 with complete chatter */
    int sticking_intervals;
    char label[SALTUS_LABEL_MAX];       /* "4/4", "chatter/2": as classify says it */
    char label_after[SALTUS_LABEL_MAX]; /* GR, CH, ST: n/p beyond the point; "" where the branch ends */
    int dimension;
    double *state;        /* at section phase 0, or at the highest maximum, as in saltus_motion */
    saltus_event *events; /* of one orbit, times in periods from phase 0 */
    int event_count;
    /* Room for dimension of them. Of an equilibrium its eigenvalues, by decreasing real part, which is their
     * log_modulus: of what they make of a perturbation in a unit of time. */
    saltus_multiplier *multipliers; /* where many would be far below 1e-40, as of nine modes and more, these
                                       are not resolved */
    int multiplier_count; /* dimension; of an orbit of a period of its own one less; of an equilibrium two
                             less for each contact that holds */
    double trivial_multiplier; /* of such an orbit, along the flow: 1 but for errors; otherwise 0 */
    int unstable; /* multipliers not inside the unit circle (saltus_multipliers_unstable), or eigenvalues with
                     a positive real part */
    bool stable;  /* false at LP, PD, NS, BP and HB, where one is on it */
    /* HB of equilibria: the first Lyapunov coefficient in Kuznetsov's normalisation (eigenvector of unit
     * length); negative: the cycles born there are stable as far as the pair goes. NAN elsewhere. */
    double lyapunov_coefficient;
    bool admissible; /* the event-driven flow closes on this orbit with this sequence of events */
    double residual; /* scaled, at the last evaluation; a Newton step from there ends in rounding */
    int iterations;  /* Newton steps */
    double log_volume, sum_rule; /* as in saltus_orbit */
    double accuracy;     /* special points, and where returns to the section come or go: bound on the error of
                            value[0], from the last bracket, from what a flow of ten times the tolerance finds,
                            and from rounding; NAN or 0 elsewhere */
    double grazing_time; /* BE: 0. GR: of the touch, in periods from phase 0, in [0, periods); of several the
                            worst; NAN elsewhere, and where no more is known than that the label changes */
    double contact_force; /* in contact all the time ("held"): the smallest force of its contacts over the
                             orbit, as saltus_flow_forces has them (pipe: per modal mass, (n.f)/(n.n); masses:
                             in the units of F); zero where a contact lets go; NAN elsewhere */
    int grazing_stop, grazing_side; /* GR, BE: stop from 1, side +1 or -1; 0 where grazing_time is NAN */
    char reason[SALTUS_REASON_MAX]; /* EP: why; GR, CH, ST, BE: what changes; HB: which cycles are born */
} saltus_branch_point;

typedef struct saltus_branch_options {
    saltus_orbit_options orbit;
    char key[2][SALTUS_KEY_MAX]; /* continued parameters, as in --set; the second one for loci, else "" */
    double low[2], high[2];      /* their ranges */
    double step, step_max; /* first and largest step of arclength: the parameter in units of its range, the
                              state in units of the system's scale; default 0.005 and 0.02 */
    int points;            /* at most, per branch, special points and its end among them; default 2000 */
    int direction;         /* +1 up first and only, -1 down only, 0 both; default 0 */
    int switches; /* how often to switch branches: at flips, branch points and Hopf points of equilibria,
                     where an equilibrium meets a stop to the cycles with impacts that begin there, and at
                     grazing to orbits of twice the period that graze in one half only; of loci, at points of
                     codimension two to the other curves that meet there, each of which is followed once;
                     default 0 */
    const double *values; /* where UZ points are wanted; caller's */
    int value_count;      /* how many; default 0 */
    /* LP, PD, NS, BP or GR, of equilibria LP, HB or BE: follow such points in both parameters; default
     * REGULAR, a branch in one parameter. */
    saltus_point_kind locus;
} saltus_branch_options;

/* As told beside the options; those of the orbit are saltus_orbit_defaults. */
saltus_branch_options saltus_branch_defaults(void);

typedef struct saltus_branch saltus_branch;

/* A branch through the periodic orbit near `state` (phase 0, length dimension) of p = `periods`. With a locus
 * the first point of its kind is sought along key[0], then followed. Errors: SALTUS_BAD_INPUT (unknown key,
 * range that excludes the start, ...), those of saltus_orbit_find. With options->orbit.free_period the orbits
 * have periods of their own, from that of the specification (saltus_spec_set_omega) on; `periods` is not
 * needed then. Without, and with periods = 0, the branch is one of equilibria, through that near `state`;
 * where it is switched at a Hopf point the branches of cycles come after those of equilibria. */
saltus_status saltus_branch_new(const saltus_spec *spec, int periods, const double *state,
                                const saltus_branch_options *options, saltus_branch **branch,
                                saltus_message *message);
/* NULL is accepted. */
void saltus_branch_free(saltus_branch *branch);
/* The next point, in order along each branch; *point is NULL when all is done. Special points come between
 * regular ones, at their place. Errors: SALTUS_NO_MEMORY; SALTUS_INTERRUPTED, after which the next call goes
 * on; SALTUS_NO_CONVERGENCE where a locus is asked for and key[0] leads to no point of its kind. Difficulties
 * of the continuation itself end a branch with an EP point and its reason. */
saltus_status saltus_branch_step(saltus_branch *branch, const saltus_branch_point **point,
                                 saltus_message *message);
/* A point with arrays of its own, to be cleared. Errors: SALTUS_NO_MEMORY; the copy is then empty. */
saltus_status saltus_branch_point_copy(const saltus_branch_point *point, saltus_branch_point *copy,
                                       saltus_message *message);
/* Free the arrays; a zeroed point is accepted. */
void saltus_branch_point_clear(saltus_branch_point *point);
/* What the run goes on from after the point last given out, as numbers to be stored: *state, `*count` of
 * them, the caller's to be freed. Where one step has made several points, that is known only after the last
 * of them: before, *count is 0, and what an earlier call gave holds. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_branch_save(saltus_branch *branch, double **state, int *count, saltus_message *message);
/* Go on from there, with the same points to the last bit. Call after saltus_branch_new with the run's start
 * and options, before the first step; *kept points had been given out. Errors: SALTUS_BAD_INPUT (numbers of
 * another run, or damaged ones), SALTUS_NO_MEMORY; the branch can then only be freed. */
saltus_status saltus_branch_resume(saltus_branch *branch, const double *state, int count, int *kept,
                                   saltus_message *message);

SALTUS_API_END
#endif
