/* Branches of periodic orbits: pseudo-arclength continuation in a parameter, special points, branch
 * switching, and loci: curves of special points in two parameters.
 *
 * The continuation prescribes the sequence of events and takes the event times as unknowns, so the equations
 * stay smooth where impacts appear or disappear. The event-driven flow then checks every point: no gap may
 * pass a stop, no contact force may pull. Where the check fails, the point of change is located; the branch
 * continues with the new sequence, or ends there and says why.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_H
#define SALTUS_BRANCH_H

#include "saltus/orbit.h"

SALTUS_API_BEGIN

enum { SALTUS_REASON_MAX = 336, SALTUS_KEY_MAX = 32 };

typedef enum saltus_point_kind {
    SALTUS_POINT_REGULAR,
    SALTUS_POINT_LP, /* fold: a multiplier +1, the branch turns back */
    SALTUS_POINT_PD, /* flip: a multiplier -1, orbits of twice the period branch off */
    SALTUS_POINT_NS, /* Neimark-Sacker: a complex pair crosses the unit circle */
    SALTUS_POINT_BP, /* branch point: pitchfork (mirror breaking) or transcritical crossing */
    SALTUS_POINT_GR, /* grazing: the speed of an impact falls to zero, or a free maximum touches a stop */
    SALTUS_POINT_CH, /* complete chatter begins or ends */
    SALTUS_POINT_ST, /* a sticking interval begins, splits, or ends in another way */
    SALTUS_POINT_UZ, /* a requested value of the parameter */
    SALTUS_POINT_EP, /* end of the branch; `reason` says why */
    SALTUS_POINT_HB, /* without forcing: Hopf point, where an orbit shrinks to an equilibrium */
    SALTUS_POINT_BE, /* without forcing: an equilibrium meets a stop, or its contact force falls to zero; an
                        orbit with impacts shrinks to the equilibrium */
    /* Points of codimension two, on loci: */
    SALTUS_POINT_CP,    /* cusp: two folds meet */
    SALTUS_POINT_GR_LP, /* a fold meets grazing */
    SALTUS_POINT_GR_PD,
    SALTUS_POINT_GR_NS,
    SALTUS_POINT_GR_GR, /* two impacts graze */
    SALTUS_POINT_GR_BP,
    /* On a grazing curve: the contact that ends complete chatter on the face of another impact shrinks to
     * zero duration. There the curve on which chatter becomes complete meets the grazing curve, which ends.
     * The equations: gap and speed of the grazing impact vanish, and the chatter accumulates at the instant
     * of release. */
    SALTUS_POINT_CH_GR,
    SALTUS_POINT_R1, /* resonance 1:1, a double multiplier 1 */
    SALTUS_POINT_R2, /* resonance 1:2, a double multiplier -1 where flips and tori meet; not where the pair of
                      * an orbit that is its own mirror image passes -1, with that of its half at a quarter */
    SALTUS_POINT_R3, /* resonance 1:3, a pair at a third of the circle */
    SALTUS_POINT_R4, /* resonance 1:4, a pair at a quarter of the circle */
    SALTUS_POINT_BT, /* of equilibria: two zero eigenvalues (Bogdanov-Takens) */
    SALTUS_POINT_GH, /* of equilibria: zero first Lyapunov coefficient (generalised Hopf) */
    /* Points where a locus of folds or tori of doubled orbits joins the orbits of half the period (so do R2
     * and R4): */
    SALTUS_POINT_GPD,   /* the flip changes between super- and subcritical */
    SALTUS_POINT_LP_PD, /* multipliers 1 and -1 together */
    SALTUS_POINT_PD_NS, /* a multiplier -1 and a pair on the unit circle */
    SALTUS_POINT_KINDS
} saltus_point_kind;

/* "", "LP", "PD", ... */
const char *saltus_point_word(saltus_point_kind kind);

/* One point of a branch. saltus_branch_step returns points whose arrays belong to the branch and stay valid
 * until its next step; saltus_branch_point_copy makes a lasting copy. */
typedef struct saltus_branch_point {
    saltus_point_kind kind;
    saltus_point_kind locus; /* on a locus the kind of all its points; REGULAR on a branch */
    int branch;              /* 0: upwards from the start, 1: downwards, 2 and more: switched branches */
    int parent;              /* of a switched branch, the branch it left; otherwise -1 */
    int step;                /* counted along the branch */
    double arclength;        /* along the branch, 0 at its start */
    double value[2];         /* of the continued parameters; value[1] is NAN except on loci */
    double heading;          /* d value[0] / d arclength */
    saltus_spec spec;        /* all parameters */
    int periods; /* p, in forcing periods; without forcing in returns to the section, as in saltus_motion; 0:
                    an equilibrium */
    double period;     /* in units of time; NAN at an equilibrium; at HB of the cycles born there */
    long long impacts; /* n per orbit; -1 with complete chatter */
    int sticking_intervals;
    char label[SALTUS_LABEL_MAX];       /* "4/4", "chatter/2", as saltus_classify words it */
    char label_after[SALTUS_LABEL_MAX]; /* GR, CH, ST: the label beyond the point; "" where the branch ends */
    int dimension;
    double *state;        /* at section phase 0, or at the highest maximum, as in saltus_motion */
    saltus_event *events; /* of one orbit; times in periods from phase 0 */
    int event_count;
    /* Allocated for `dimension` entries. At an equilibrium: its eigenvalues, by decreasing real part, with
     * the real part as log_modulus too. */
    saltus_multiplier *multipliers; /* unresolved if many are far below 1e-40 (nine modes or more); at LP, PD
                                       and BP the critical one is NAN where rounding hides it; on a curve of
                                       grazing those without the impact */
    int multiplier_count; /* dimension; one less for an orbit with a period of its own; at an equilibrium two
                             less for each contact that holds; 0: not known */
    double trivial_multiplier; /* of an orbit with a period of its own: the multiplier along the flow, 1 up to
                                  errors; otherwise 0 */
    int unstable; /* number of multipliers not inside the unit circle (saltus_multipliers_unstable; -1: not
                     known), or of eigenvalues with positive real part. At LP, PD, NS, BP and HB without
                     the critical one, or pair: the lower of the numbers before and beyond */
    bool stable;  /* false at LP, PD, NS, BP and HB, where a multiplier or eigenvalue is critical */
    /* HB of equilibria: first Lyapunov coefficient in Kuznetsov's normalisation (eigenvector of unit length).
     * Negative: the critical pair does not destabilise the cycles born there. NAN elsewhere. */
    double lyapunov_coefficient;
    bool admissible; /* the event-driven flow closes on this orbit with this sequence of events */
    double residual; /* scaled, at the last evaluation; one more Newton step would only change rounding */
    int iterations;  /* Newton steps */
    double log_volume, sum_rule; /* as in saltus_orbit */
    double accuracy; /* error bound of value[0] at special points and where returns to the section appear or
                        vanish: from the last bracket, from a flow of ten times the tolerance, and from
                        rounding. At points of codimension two, where it is the same share of its range for
                        value[1], instead of a bracket from how far off a function shows its slope. NAN or 0
                        elsewhere */
    double grazing_time;  /* BE: 0. GR: when the orbit touches the stop, in periods from phase 0, in [0,
                             periods); of several touches the worst. NAN elsewhere, and where only the change
                             of label is known */
    double contact_force; /* always in contact ("held"): smallest contact force over the orbit, in the units
                             of saltus_flow_forces (pipe: per modal mass, (n.f)/(n.n); masses: units of F);
                             zero where a contact releases; NAN elsewhere */
    int grazing_stop, grazing_side; /* GR, BE: stop from 1, side +1 or -1; 0 where grazing_time is NAN */
    char reason[SALTUS_REASON_MAX]; /* EP: why; GR, CH, ST, BE: what changes; HB: which cycles are born */
} saltus_branch_point;

typedef struct saltus_branch_options {
    saltus_orbit_options orbit;
    char key[2][SALTUS_KEY_MAX]; /* continued parameters, as in --set; key[1] is "" except for loci */
    double low[2], high[2];      /* their ranges; of these the parts are taken where scenes exist */
    double step, step_max; /* first and largest step of arclength, measured with the parameter in units of its
                              range and the state in units of the system's scale; default 0.005 and 0.02 */
    int points;            /* most points per branch, special points and the end included; default 2000 */
    int direction;         /* +1: only upwards, -1: only downwards, 0: both, upwards first; default 0 */
    /* How many times in succession to switch branches. Branches switch at flips, at branch points, at Hopf
     * points of equilibria, where an equilibrium meets a stop (to the cycles with impacts born there), and at
     * grazing (to orbits of twice the period that graze in one half only). A branch that ends where it joins
     * another switches to both halves of that one. Loci switch at points of codimension two, to each other
     * curve through the point once. Default 0 */
    int switches;
    const double *values; /* where UZ points are wanted; owned by the caller */
    int value_count;      /* number of `values`; default 0 */
    /* The kind of special point to follow in both parameters: LP, PD, NS, BP or GR; of equilibria LP, HB or
     * BE. Default REGULAR: a branch in one parameter. */
    saltus_point_kind locus;
} saltus_branch_options;

/* The defaults stated beside the options, with saltus_orbit_defaults for `orbit`. */
saltus_branch_options saltus_branch_defaults(void);

typedef struct saltus_branch saltus_branch;

/* A branch through the periodic orbit of `periods` = p forcing periods near `state` (phase 0, length
 * dimension). For a locus, the first point of its kind is sought along key[0], then followed. With
 * options->orbit.free_period each orbit has its own period, starting from that of the specification
 * (saltus_spec_set_omega), and `periods` is ignored. Without it, periods = 0 asks for a branch of equilibria
 * through the one near `state`; cycles that it switches to at Hopf points follow after all equilibria.
 * Errors: SALTUS_BAD_INPUT (unknown key, range that excludes the start, ...), those of saltus_orbit_find. */
saltus_status saltus_branch_new(const saltus_spec *spec, int periods, const double *state,
                                const saltus_branch_options *options, saltus_branch **branch,
                                saltus_message *message);
/* NULL is accepted. */
void saltus_branch_free(saltus_branch *branch);
/* The next point, in order along each branch; *point is NULL at the end. Special points come in their place
 * between regular ones. Errors: SALTUS_NO_MEMORY; SALTUS_INTERRUPTED, after which the next call continues;
 * SALTUS_NO_CONVERGENCE if no point of the locus' kind is found along key[0]. Where the continuation itself
 * fails, the branch ends with an EP point that gives the reason. */
saltus_status saltus_branch_step(saltus_branch *branch, const saltus_branch_point **point,
                                 saltus_message *message);
/* Copy a point into arrays of its own; free with saltus_branch_point_clear. Errors: SALTUS_NO_MEMORY; the
 * copy is then empty. */
saltus_status saltus_branch_point_copy(const saltus_branch_point *point, saltus_branch_point *copy,
                                       saltus_message *message);
/* Free the arrays; a zeroed point is accepted. */
void saltus_branch_point_clear(saltus_branch_point *point);
/* The state of the run after the last point returned, as numbers to be stored for saltus_branch_resume:
 * *state holds `*count` of them and is the caller's to free. If one step made several points, the state is
 * known only after the last of them; until then *count is 0 and the previous saved state remains the one to
 * use. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_branch_save(saltus_branch *branch, double **state, int *count, saltus_message *message);
/* Continue from a saved state, bit for bit as if uninterrupted. Call it after saltus_branch_new with the same
 * start and options, before the first step. *kept receives the number of points returned before the state was
 * saved. Errors: SALTUS_BAD_INPUT (numbers of another run, or damaged ones), SALTUS_NO_MEMORY; the branch can
 * then only be freed. */
saltus_status saltus_branch_resume(saltus_branch *branch, const double *state, int count, int *kept,
                                   saltus_message *message);

SALTUS_API_END
#endif
