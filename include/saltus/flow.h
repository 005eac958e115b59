/* The event-driven flow of a system with rigid stops.
 *
 * A flow advances trajectories through free flight, impacts, complete chatter, sticking and release, to a
 * given tolerance; tangent vectors are extra columns of the same integration. The contract on events stands
 * at the head of src/flow/flow.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_H
#define SALTUS_FLOW_H

#include "saltus/system.h"

#include <signal.h>

SALTUS_API_BEGIN

/* Time, counted in forcing periods: (cycle + phase) T with 0 <= phase < 1. The forcing depends on the phase
 * alone, so sections do not drift, however many periods pass. */
typedef struct saltus_time {
    long long cycle;
    double phase;
} saltus_time;

/* cycle + phase as one number. */
double saltus_time_periods(saltus_time time);
/* The inverse: phase in [0, 1). */
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
    int order;   /* Taylor order, 8 to 40; default 0: chosen from rtol, lower where stability bounds the
                    steps */
    int columns; /* tangent vectors integrated along with the state, 0 to 256; default 0 */
    /* The last `directions` of these columns are parameter columns: derivatives of the state by a parameter
     * at fixed phase, 0 to SALTUS_DIRECTIONS_MAX (saltus_flow_set_directions). */
    int directions; /* default 0 */
    /* Stop request: as soon as the number it points to is not 0 (set by a signal handler or another thread,
     * say), no further step is made and the call returns SALTUS_INTERRUPTED, or its partial result where so
     * described. NULL: never. */
    const volatile sig_atomic_t *stop; /* default NULL */
    /* Steps counted over all flows that answer one question. Searches of unknown length (saltus_classify,
     * saltus_lyapunov_run, ...) use their own count if this is NULL. They fail with SALTUS_STALLED if the
     * scene takes far too many steps per period. */
    struct saltus_effort *effort; /* default NULL */
} saltus_flow_options;

/* The defaults stated beside the options. */
saltus_flow_options saltus_flow_defaults(void);

typedef enum saltus_event_kind {
    SALTUS_REACHED, /* the target time */
    SALTUS_IMPACT,
    SALTUS_STICK,   /* complete chatter, or an impact without rebound, has ended in lasting contact */
    SALTUS_RELEASE, /* the contact force fell to zero */
    SALTUS_TURNING, /* the velocity of the observed displacement passed through zero */
    SALTUS_STEP     /* one step was made; watched to sample the dense output */
} saltus_event_kind;

/* Which events end an advance, as bits. Impacts and contacts are always handled, watched or not. */
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
    saltus_time time;       /* for a stick: when the impacts accumulate */
    double velocity_before; /* n.q' just before (positive towards an upper stop); turning: acceleration */
    double velocity_after;  /* n.q' just after */
    double displacement;    /* observed (turning), or the stop's contact coordinate */
} saltus_event;

/* Counters and sums of a flow since it was started. */
typedef struct saltus_flow_info {
    long long steps;             /* steps of the integrator */
    long long field_evaluations; /* orders expanded (series), nodes evaluated (collocation) */
    long long impacts, sticks, releases;
    double log_volume; /* sum of ln r + ln |d(r speed)/d speed| over the impacts, 2 ln r for a constant
                          restitution: their share of the sum rule */
    double square; /* integral of the squared observed displacement over time in units of T; only over times
                      when turning points were watched */
} saltus_flow_info;

typedef struct saltus_flow saltus_flow;

/* Create a workspace for one trajectory (lanes = 1) or for several side by side, at most saltus_flow_width.
 * `systems` holds `lanes` systems of one model and size, which must outlive the flow. All memory is allocated
 * here. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_flow_new(const saltus_system *const *systems, int lanes,
                              const saltus_flow_options *options, saltus_flow **flow,
                              saltus_message *message);
/* The same for one trajectory with `columns` tangent vectors and no parameter columns, whatever
 * options->columns and options->directions are. */
saltus_status saltus_flow_single(const saltus_system *system, int columns, const saltus_flow_options *options,
                                 saltus_flow **flow, saltus_message *message);
/* NULL is accepted. */
void saltus_flow_free(saltus_flow *flow);
/* How many of a number of trajectories of a system run side by side on this processor; 1 for integrators that
 * use collocation, and for so many modes, or so few trajectories, that one trajectory at a time is the
 * fastest. With SALTUS_AUTOMATIC, many trajectories use series side by side where that is the fastest for
 * many, even if a single one would use SALTUS_MIXED. */
int saltus_flow_width(const saltus_system *system, saltus_integrator integrator, long long trajectories);
const saltus_system *saltus_flow_system(const saltus_flow *flow, int lane);
int saltus_flow_columns(const saltus_flow *flow);

/* Start a lane from a time and state (length dimension); contacts that rest or approach are resolved. Tangent
 * vectors become the first columns of the identity matrix, parameter columns zero; an impact at the start
 * acts on them too. Errors: SALTUS_BAD_INPUT if the state lies beyond a stop or a number is not finite. */
saltus_status saltus_flow_start(saltus_flow *flow, int lane, saltus_time time, const double *state,
                                saltus_message *message);
/* Set the directions of the parameter columns (`options.directions` of them), for lane 0 of a flow of one
 * lane. A parameter column is the derivative of the state by the direction's number at fixed phase, with
 * times in periods: if the direction includes omega, the period changes too. It starts at zero; at impacts,
 * sticking and release it includes the derivatives of the impact law and of the stop's position. */
void saltus_flow_set_directions(saltus_flow *flow, const saltus_direction *directions);
/* Set the largest number of steps per period. A run whose first steps predict more ends with SALTUS_STALLED.
 * 0: the usual 1e8, or 8e4 with an effort. */
void saltus_flow_limit_steps(saltus_flow *flow, double per_period);
/* Choose the Taylor order for fresh tangent vectors. They first contain transients of the fastest modes,
 * during which accuracy and not stability bounds the steps, so the order that suits the tolerance is faster
 * until these have decayed. Has an effect only with `order` = 0; lasts as long as the flow. */
void saltus_flow_expect_transients(saltus_flow *flow);
/* Give a lane another system of the same model with the same number and kind of stops. The lane must be
 * started or placed again. */
saltus_status saltus_flow_retune(saltus_flow *flow, int lane, const saltus_system *system,
                                 saltus_message *message);
/* Set or read the tangent vectors: `columns` vectors of length dimension, one after the other. */
void saltus_flow_set_tangents(saltus_flow *flow, int lane, const double *tangents);
void saltus_flow_tangents(const saltus_flow *flow, int lane, double *tangents);
/* The present state (length dimension) and time of a lane. */
void saltus_flow_state(const saltus_flow *flow, int lane, double *state);
saltus_time saltus_flow_time(const saltus_flow *flow, int lane);
/* The present time derivative of the state, contacts held; for section derivatives. */
void saltus_flow_field(saltus_flow *flow, int lane, double *derivative);
/* Derivative of the time of the last impact, stick or turning event by each tangent vector (length columns).
 * It projects a tangent vector onto the event's section. */
void saltus_flow_delays(const saltus_flow *flow, int lane, double *delays);
/* Contact force n.a/(n.M^-1 n) of each face (length SALTUS_FACES_MAX), with the free acceleration a; zero
 * where no contact holds. For the pipe, with modal masses 1, it is per modal mass, (n.f)/(n.n); for masses it
 * is the force. */
void saltus_flow_forces(saltus_flow *flow, int lane, double *forces);
/* Faces in lasting contact now, as bits. */
unsigned saltus_flow_contacts(const saltus_flow *flow, int lane);
saltus_flow_info saltus_flow_information(const saltus_flow *flow, int lane);

/* Give a lane its next target: the time `until` (not before now) or the first watched event. If the time is
 * not finite, the next run fails with SALTUS_BAD_INPUT. */
void saltus_flow_aim(saltus_flow *flow, int lane, saltus_time until, unsigned watch);
/* Advance all aimed lanes until one has reached its target; that lane must be aimed again before it moves.
 * Errors: SALTUS_STALLED, with the time (at a stop also gap and speed) in the message: the lane *lane stays
 * where it is and the next call continues the others. SALTUS_INTERRUPTED: all lanes keep their last step and
 * their target. */
saltus_status saltus_flow_run(saltus_flow *flow, int *lane, saltus_event *event, saltus_message *message);
/* saltus_flow_aim and saltus_flow_run for lane 0. */
saltus_status saltus_flow_advance(saltus_flow *flow, saltus_time until, unsigned watch, saltus_event *event,
                                  saltus_message *message);

/* Prescribed events: the flow follows a given sequence of events instead of detecting it, for orbits whose
 * event times are unknowns. Stops do not obstruct the motion; lanes = 1. */

/* The maximum of a quantity that must stay below zero. */
typedef struct saltus_extreme {
    double value; /* -INFINITY: no maximum; also the initial value */
    saltus_time time;
    double inner; /* the same without the first 1e-6 and the last 1e-4 periods of a segment, where the impacts
                     at its ends touch the stop */
    saltus_time inner_time;
} saltus_extreme;

/* Place a lane at a time and state with the given faces in lasting contact, regardless of gaps. Tangent
 * vectors become the first columns of the identity matrix, parameter columns zero. Errors: SALTUS_STALLED if
 * the contacts cannot hold together, SALTUS_BAD_INPUT (time not finite, no such face). */
saltus_status saltus_flow_place(saltus_flow *flow, int lane, saltus_time time, const double *state,
                                unsigned contacts, saltus_message *message);
/* Advance to a time, ignoring events. `extremes` (SALTUS_FACES_MAX entries, may be NULL) collects for each
 * face the largest local maximum on the way: of the gap of a free face, of minus the contact force n.f of a
 * holding one. Values are only raised, so they can be collected over several calls. Errors:
 * SALTUS_NO_CONVERGENCE if the time lies before now, those of saltus_flow_run. */
saltus_status saltus_flow_coast(saltus_flow *flow, int lane, saltus_time until, saltus_extreme *extremes,
                                saltus_message *message);

/* Linearisation of a prescribed event: its condition on the state before, and the effect of a shift of its
 * time. */
typedef struct saltus_strike {
    double equation;           /* must be zero: the gap (impact, stick) or the contact force n.f (release) */
    double equation_rate;      /* its time derivative: n.q' or d(n.f)/dt */
    double *equation_gradient; /* by each tangent vector (length columns; owned by the caller) */
    double speed;              /* n.q' before */
    double speed_rate;         /* its time derivative: n.q'' before */
    double *speed_gradient;    /* by each tangent vector, as equation_gradient; NULL: not wanted */
    double *shift; /* d(state after, at a fixed later time) / d(event time): DP f- - f+ (length dimension;
                      owned by the caller) */
} saltus_strike;

/* Apply a prescribed event now: SALTUS_IMPACT rebounds at the face, SALTUS_STICK starts a contact,
 * SALTUS_RELEASE ends it. Tangent vectors are mapped with the event time held fixed. The flow may then coast
 * or advance. Errors: SALTUS_STALLED if the event is impossible (release of a face that does not hold,
 * contacts that exclude each other). */
saltus_status saltus_flow_strike(saltus_flow *flow, int lane, saltus_event_kind kind, int face,
                                 saltus_strike *strike, saltus_message *message);

/* Dense output: the last step of a lane covers [begin, now], and saltus_flow_dense gives the state within it
 * to the step's own accuracy. `since` counts from the step's begin in units of time (not of T). A step of any
 * lane ends the dense output of all others. */
double saltus_flow_step_length(const saltus_flow *flow, int lane);
saltus_time saltus_flow_step_begin(const saltus_flow *flow, int lane);
void saltus_flow_dense(const saltus_flow *flow, int lane, double since, double *state);
/* The same at a time not before the step's start. Returns a negative number within the step; 0 at its end,
 * where the state is that before any pending event; a positive number, and no state, beyond it. */
int saltus_flow_state_at(const saltus_flow *flow, int lane, saltus_time time, double *state);
/* Time derivative of the tangent vectors now (`columns` vectors of length dimension), contacts held. If these
 * are the columns of the identity it is the Jacobian of the vector field. Ends the dense output of the last
 * step. */
void saltus_flow_tangent_field(saltus_flow *flow, int lane, double *derivatives);

/* One column of a flow, compared with differences of whole runs. */
typedef struct saltus_column_check {
    char name[40];     /* what the column is the derivative by: an entry of the state or a key of --set */
    double difference; /* the largest one, relative to the column, in the system's scales; NAN: not compared,
                          because neighbouring runs pass other events or are impossible */
    bool agrees;
} saltus_column_check;
enum { SALTUS_COLUMN_CHECKS_MAX = SALTUS_STATE_MAX + SALTUS_PARAMETERS_MAX + 3 * SALTUS_STOPS_MAX };

/* Compare the tangent vectors of all entries of the state, and the columns of all parameters and stop
 * properties that can vary, with extrapolated differences. The run begins at phase 0 in `state` and ends
 * shortly after its first contact if one comes within ten periods, else after a quarter of a period. A column
 * agrees to 1e-6. `checks` has room for SALTUS_COLUMN_CHECKS_MAX entries, of which *count are filled. `stop`
 * as in the options of flows. Errors: those of saltus_flow_new and saltus_flow_run for the run itself,
 * SALTUS_INTERRUPTED. */
saltus_status saltus_columns_check(const saltus_system *system, const double *state,
                                   const volatile sig_atomic_t *stop, saltus_column_check *checks, int *count,
                                   saltus_message *message);

SALTUS_API_END
#endif
