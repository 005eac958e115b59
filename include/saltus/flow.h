/* The event-driven flow of a system with rigid stops.
 *
 * A flow advances trajectories through free flight, impacts, complete chatter, sticking and release, to a
 * tolerance, with tangent vectors as extra columns of the same integration. The contract on events stands at
 * the head of src/flow/flow.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_H
#define SALTUS_FLOW_H

#include "saltus/system.h"

#include <signal.h>

SALTUS_API_BEGIN

/* Time, counted in forcing periods: (cycle + phase) T with 0 <= phase < 1. The forcing depends on the phase
 * alone, so a section does not drift however many periods pass. */
typedef struct saltus_time {
    long long cycle;
    double phase;
} saltus_time;

/* cycle + phase as one number. */
double saltus_time_periods(saltus_time time);
/* The same the other way: phase in [0, 1). */
saltus_time saltus_time_of(double periods);
/* Negative, 0 or positive as `a` is before, at or after `b`. */
int saltus_time_compare(saltus_time a, saltus_time b);

enum { SALTUS_DIRECTIONS_MAX = 3 };

typedef enum saltus_integrator {
    SALTUS_AUTOMATIC, /* the choice made when the system was built */
    SALTUS_TAYLOR,    /* explicit Taylor series of high order: not stiff */
    SALTUS_RADAU,     /* implicit collocation at 16 Radau points, linear part solved exactly: stiff */
    SALTUS_MIXED      /* collocation for long steps, series for short ones: stiff, and the fastest there */
} saltus_integrator;

typedef struct saltus_flow_options {
    double rtol; /* local error of a step relative to the state's norm, 1e-15 to 1e-3; default 1e-13 */
    double atol; /* the same, absolute, in displacements, 0 to 1; default 1e-16 */
    saltus_integrator integrator; /* default SALTUS_AUTOMATIC */
    int order;   /* Taylor order, 8 to 40; default 0: chosen from rtol, lower where stability bounds the steps
                  */
    int columns; /* tangent vectors carried along, 0 to 256; default 0 */
    /* How many of them, the last ones, are parameter columns: derivatives of the state with respect to a
     * parameter at fixed phase, 0 to SALTUS_DIRECTIONS_MAX (saltus_flow_set_directions). */
    int directions; /* default 0 */
    /* Where it points to a number other than 0, which a signal handler or another thread may have put there,
     * no further step is made: the call under way returns SALTUS_INTERRUPTED, or what it has so far where its
     * description says so. NULL: nobody will ask to stop. */
    const volatile sig_atomic_t *stop; /* default NULL */
    /* What the flows of one question cost together. Searches of which nobody can say how long they take
     * (saltus_classify, saltus_lyapunov_run, ...) keep one where this is NULL, and end with SALTUS_STALLED
     * where the scene takes far too many steps in each of its periods. */
    struct saltus_effort *effort; /* default NULL */
} saltus_flow_options;

/* As told beside the options. */
saltus_flow_options saltus_flow_defaults(void);

typedef enum saltus_event_kind {
    SALTUS_REACHED, /* the target time */
    SALTUS_IMPACT,
    SALTUS_STICK,   /* complete chatter or an impact without rebound ended: the contact holds from here */
    SALTUS_RELEASE, /* the contact force fell through zero */
    SALTUS_TURNING, /* the observed displacement's velocity passed through zero */
    SALTUS_STEP     /* one step was made (asked for to sample the dense output) */
} saltus_event_kind;

/* Which events end an advance, as bits; impacts and contacts are always handled, watched or not. */
enum {
    SALTUS_WATCH_IMPACT = 1 << SALTUS_IMPACT,
    SALTUS_WATCH_STICK = 1 << SALTUS_STICK,
    SALTUS_WATCH_RELEASE = 1 << SALTUS_RELEASE,
    SALTUS_WATCH_TURNING = 1 << SALTUS_TURNING,
    SALTUS_WATCH_STEP = 1 << SALTUS_STEP,
    SALTUS_WATCH_CONTACT = SALTUS_WATCH_IMPACT | SALTUS_WATCH_STICK | SALTUS_WATCH_RELEASE
};

/* Why an advance ended. */
typedef struct saltus_event {
    saltus_event_kind kind;
    int face;               /* contact events: which face; otherwise -1 */
    saltus_time time;       /* for a stick: the accumulation point of the impacts */
    double velocity_before; /* n.q' just before (signed as n.q': positive towards an upper stop); turning:
                               acceleration */
    double velocity_after;  /* n.q' just after */
    double displacement;    /* of the observer (turning) or of the contact coordinate */
} saltus_event;

/* What a flow has done since it was started. */
typedef struct saltus_flow_info {
    long long steps;             /* steps of the integrator */
    long long field_evaluations; /* orders expanded in series, nodes evaluated in collocation */
    long long impacts, sticks, releases;
    double log_volume; /* sum of 2 ln r over the impacts: the impacts' share of the sum rule */
    double square; /* integral of the observed displacement's square over the time, in units of T, in which
                      turning points were watched; of the step's polynomials exactly */
} saltus_flow_info;

typedef struct saltus_flow saltus_flow;

/* Create a workspace for one trajectory (lanes = 1) or for several side by side. `systems` holds `lanes`
 * systems of one model and size; they must outlive the flow. All memory is allocated here. lanes: 1, or up to
 * saltus_flow_width(). Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_flow_new(const saltus_system *const *systems, int lanes,
                              const saltus_flow_options *options, saltus_flow **flow,
                              saltus_message *message);
/* The same for one trajectory with `columns` tangent vectors, none of them a parameter column, whatever the
 * options say of columns and directions. */
saltus_status saltus_flow_single(const saltus_system *system, int columns, const saltus_flow_options *options,
                                 saltus_flow **flow, saltus_message *message);
/* NULL is accepted. */
void saltus_flow_free(saltus_flow *flow);
/* Number of trajectories that run side by side for a system on this processor: 1 with an integrator that uses
 * collocation. Where the choice is automatic they run on series side by side as long as that is the fastest
 * way for many of them, even where a single one is chosen to be mixed. */
int saltus_flow_width(const saltus_system *system, saltus_integrator integrator);
const saltus_system *saltus_flow_system(const saltus_flow *flow, int lane);
int saltus_flow_columns(const saltus_flow *flow);

/* Place a lane at a time and state (length dimension), resting or approaching contacts resolved. The state
 * must be beyond no stop and all numbers finite (SALTUS_BAD_INPUT). Tangent vectors become the first columns
 * of the identity matrix, parameter columns zero; an impact at the start acts on them as on the state. */
saltus_status saltus_flow_start(saltus_flow *flow, int lane, saltus_time time, const double *state,
                                saltus_message *message);
/* The directions of the parameter columns (`options.directions` of them), for lane 0 of a flow of one lane.
 * A parameter column is the derivative of the state with respect to the direction's number at fixed phase,
 * times counted in periods: with omega among the parameters the period changes too. It starts at zero, and
 * passes impacts, sticking and release with the derivatives of the impact law and of the stop's place. */
void saltus_flow_set_directions(saltus_flow *flow, const saltus_direction *directions);
/* A run through a period that would take more steps of the integrator than this, as the first of them show,
 * ends with SALTUS_STALLED; 0: the usual 1e8, with an effort 8e4. */
void saltus_flow_limit_steps(saltus_flow *flow, double per_period);
/* Tangent vectors that are set anew hold transients of the fastest modes at first, where accuracy bounds the
 * steps and stability does not: series of the order that suits the tolerance are faster then, until these
 * have died away. For one that was chosen (`order` = 0); lasts as long as the flow. */
void saltus_flow_expect_transients(saltus_flow *flow);
/* Give a lane another system of the same model and shape (the same stops, other values). The lane must be
 * started or placed again. */
saltus_status saltus_flow_retune(saltus_flow *flow, int lane, const saltus_system *system,
                                 saltus_message *message);
/* Set or read tangent vectors: `columns` vectors of length dimension, one after the other. */
void saltus_flow_set_tangents(saltus_flow *flow, int lane, const double *tangents);
void saltus_flow_tangents(const saltus_flow *flow, int lane, double *tangents);
/* The state (length dimension) and time of a lane now. */
void saltus_flow_state(const saltus_flow *flow, int lane, double *state);
saltus_time saltus_flow_time(const saltus_flow *flow, int lane);
/* The time derivative of the state now, contacts held; for section derivatives. */
void saltus_flow_field(saltus_flow *flow, int lane, double *derivative);
/* How the time of the last impact, stick or turning event answers to each tangent vector: d time / d column
 * (length columns). With it a tangent vector becomes one of the event's section. */
void saltus_flow_delays(const saltus_flow *flow, int lane, double *delays);
/* Contact force n.a/(n.M^-1 n), with a the free acceleration, of each face (length SALTUS_FACES_MAX); zero
 * where nothing holds. Of the pipe, whose modal masses are 1, it is counted per modal mass, (n.f)/(n.n); with
 * masses it is the force. */
void saltus_flow_forces(saltus_flow *flow, int lane, double *forces);
/* Faces now in lasting contact, as bits. */
unsigned saltus_flow_contacts(const saltus_flow *flow, int lane);
saltus_flow_info saltus_flow_information(const saltus_flow *flow, int lane);

/* Give a lane its next target: advance to time `until` (not before now) or to the first watched event. Where
 * that time is not a finite number the next run says so: SALTUS_BAD_INPUT. */
void saltus_flow_aim(saltus_flow *flow, int lane, saltus_time until, unsigned watch);
/* Advance all aimed lanes until one of them has reached its target; that lane must be aimed again before it
 * moves. Errors: SALTUS_STALLED with the time in the message, at a stop with gap and speed too; the lane
 * named in *lane stays where it is, and the others go on with the next call. SALTUS_INTERRUPTED: the lanes
 * stand where they were at their last step, aimed as they were. */
saltus_status saltus_flow_run(saltus_flow *flow, int *lane, saltus_event *event, saltus_message *message);
/* aim and run for lane 0. */
saltus_status saltus_flow_advance(saltus_flow *flow, saltus_time until, unsigned watch, saltus_event *event,
                                  saltus_message *message);

/* Prescribed events: flows that take a sequence of events as given instead of finding it, for orbits whose
 * event times are unknowns. Stops are no obstacle to them; lanes = 1. */

/* The largest value of a quantity that must stay below zero. */
typedef struct saltus_extreme {
    double value; /* -INFINITY: there is no maximum, which is also what it begins with */
    saltus_time time;
    double inner; /* the same but for the first 1e-6 and the last 1e-4 periods of a way, in which the impacts
                     that it begins and ends with may touch */
    saltus_time inner_time;
} saltus_extreme;

/* Place a lane at a time and state with the given faces in lasting contact, wherever the stops are. Tangent
 * vectors become the first columns of the identity matrix, parameter columns zero. Errors: SALTUS_STALLED
 * where these contacts cannot hold together, SALTUS_BAD_INPUT (a time that is not finite, a face that there
 * is not). */
saltus_status saltus_flow_place(saltus_flow *flow, int lane, saltus_time time, const double *state,
                                unsigned contacts, saltus_message *message);
/* Advance to a time through no event. For each face (SALTUS_FACES_MAX entries, may be NULL) the largest local
 * maximum on the way: of the gap where the face is free, of minus the contact force n.f where it holds;
 * `extremes` is only raised, so that it can collect over several calls. Errors: SALTUS_NO_CONVERGENCE where
 * the time lies before now, those of saltus_flow_run. */
saltus_status saltus_flow_coast(saltus_flow *flow, int lane, saltus_time until, saltus_extreme *extremes,
                                saltus_message *message);

/* A prescribed event: what it asks of the state before it, and what a change of its time does. */
typedef struct saltus_strike {
    double equation;           /* to be zero: the gap (impact, stick) or the contact force n.f (release) */
    double equation_rate;      /* its time derivative: n.q' or d(n.f)/dt */
    double *equation_gradient; /* per column (length columns; the caller's) */
    double speed;              /* n.q' before */
    double *shift; /* d(state after, at a fixed later time) / d(time of the event): DP f- - f+ (length
                      dimension; the caller's) */
} saltus_strike;

/* Apply a prescribed event now: SALTUS_IMPACT rebounds at the face, SALTUS_STICK makes it hold,
 * SALTUS_RELEASE lets go. Tangent vectors pass at the fixed time of the event. The flow may then coast on or
 * advance. Errors: SALTUS_STALLED where the event cannot be: what does not hold lets go, contacts exclude
 * each other. */
saltus_status saltus_flow_strike(saltus_flow *flow, int lane, saltus_event_kind kind, int face,
                                 saltus_strike *strike, saltus_message *message);

/* Dense output: the last step of a lane covers [begin, now]; the state at a time in it, to the step's own
 * accuracy. `since` is the time since the step's begin, in units of time (not of T). A step of any lane ends
 * the dense output of all others. */
double saltus_flow_step_length(const saltus_flow *flow, int lane);
saltus_time saltus_flow_step_begin(const saltus_flow *flow, int lane);
void saltus_flow_dense(const saltus_flow *flow, int lane, double since, double *state);
/* The same at a time, not before the step's begin: negative within the step, 0 at its end, where it is the
 * state before the event that may wait there, positive, and no state, beyond it. */
int saltus_flow_state_at(const saltus_flow *flow, int lane, saltus_time time, double *state);
/* The time derivative of the tangent vectors now (`columns` vectors of length dimension), contacts held: of
 * the first columns of the identity, the Jacobian of the vector field by columns. Dense output of the last
 * step is lost. */
void saltus_flow_tangent_field(saltus_flow *flow, int lane, double *derivatives);

/* A column of a flow beside differences of whole runs. */
typedef struct saltus_column_check {
    char name[40];     /* the entry of the state or the key of --set that the column is the derivative by */
    double difference; /* the largest, relative to the column, in the system's scales; NAN: not compared,
                          because neighbouring runs pass other events or are not possible */
    bool agrees;
} saltus_column_check;
enum { SALTUS_COLUMN_CHECKS_MAX = SALTUS_STATE_MAX + SALTUS_PARAMETERS_MAX + 3 * SALTUS_STOPS_MAX };

/* Compare the tangent vectors of all entries of the state, and the columns of all parameters and properties
 * of stops that can be varied, with extrapolated differences. The run begins at phase 0 in `state` and ends
 * shortly after its first contact, where one comes within ten periods, else after a quarter of one. A column
 * agrees to 1e-6. `checks` has room for SALTUS_COLUMN_CHECKS_MAX; *count of them are filled in. Errors: those
 * of saltus_flow_new and saltus_flow_run for the run itself. */
saltus_status saltus_columns_check(const saltus_system *system, const double *state,
                                   saltus_column_check *checks, int *count, saltus_message *message);

SALTUS_API_END
#endif
