/* Private: the parts of a flow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_PRIVATE_H
#define SALTUS_FLOW_PRIVATE_H

#include "flow/effort.h"
#include "flow/fixed.h"
#include "flow/isolate.h"
#include "flow/kernel.h"
#include "flow/radau.h"
#include "saltus/flow.h"

/* The linear map of velocities v -> v - sum_k push_k (pull_k . v) at a set of faces. With the restitution in
 * the pull rows it is the impact law of these faces, without it the projection of accelerations by lasting
 * contacts. Directions point towards the stops. */
typedef struct saltus_contact_map {
    unsigned faces; /* as bits */
    int count;      /* number of faces */
    int face[SALTUS_FACES_MAX];
    double *push, *pull; /* [count][dof]; room for SALTUS_FACES_MAX rows */
    double *change; /* pull rows of the map's derivative; `pull` if no restitution depends on the speed */
    double *change_rows; /* storage for `change` otherwise; NULL in maps of lasting contacts */
    double speed[SALTUS_FACES_MAX], r[SALTUS_FACES_MAX]; /* per face; r = 0 where it does not rebound */
    double inverse[SALTUS_FACES_MAX *
                   SALTUS_FACES_MAX]; /* of n_k . push_j: shares gaps out among the directions */
} saltus_contact_map;

/* The direction in parameter space of a parameter column, and the system's derivative along it. */
typedef struct saltus_parameter_column {
    saltus_direction direction;
    saltus_variation variation;
} saltus_parameter_column;

/* A face's gap at the start of a step, known more exactly than n.q - d near contact: the first `touch`
 * coefficients of its series vanish, or, with `shadow`, value and rate come from the last step's polynomial.
 * A held face lets go where its force pulls by more than `pull`. */
typedef struct saltus_face_state {
    int touch;
    bool shadow;
    double gap, rate, pull;
} saltus_face_state;

/* Takes a turning point of the observed displacement: its place, and the sign of the velocity after it. */
typedef void saltus_turning_function(void *context, double displacement, int heading);

/* What takes a lane's turning points, which then are no events. */
typedef struct saltus_turnings {
    saltus_turning_function *take; /* NULL: turning points are events */
    void *context;                 /* its first argument */
    const double *low, *high;      /* those between these two may be left out; NULL: none */
} saltus_turnings;

/* What a lane runs to. */
typedef struct saltus_target {
    saltus_time since, until; /* since: where a coast began */
    unsigned watch;
    saltus_turnings turnings;
    bool aimed;               /* to be advanced by the next saltus_flow_run */
    bool coasting;            /* events are prescribed: none is searched for */
    saltus_extreme *extremes; /* coasting: collects the largest gaps and the smallest forces; may be NULL */
} saltus_target;

/* A lane's last step, or the one being made. */
typedef struct saltus_step {
    saltus_time begin;
    double length;
    bool calm;  /* no face was touched, close or held at its begin */
    bool turns; /* the observed velocity may have a zero in it; set only if turning points are watched */
    bool lands; /* it ends at the target */
} saltus_step;

/* The first event of a step; without one, kind SALTUS_STEP and the step's end. */
typedef struct saltus_first_event {
    double time; /* since the step's begin */
    saltus_event_kind kind;
    int face;
} saltus_first_event;

/* A degree of the series, and the longest step that is stable with it. */
typedef struct saltus_pace {
    int degree;
    double limit;
} saltus_pace;

/* One trajectory. What every step reads comes first and lies close together. */
typedef struct saltus_lane {
    const saltus_system *system;
    saltus_time now;
    saltus_target target;
    saltus_step step;
    saltus_flow_info info;
    double flight;     /* estimated time to the next impact after a rebound, else infinite */
    double brief;      /* flights and targets up to this time need fewer orders than `degree` */
    double cycle_from; /* phase in this period from which cycle_steps counts */
    int cycle_steps;
    int cycle_events; /* contact events in this period */
    int idle_events;  /* contact events since time last advanced */
    int degree;       /* of its series, unless an event or the target will end the step early */
    int queued;
    saltus_status failure;
    bool settled;              /* the tangent vectors' transients have died away */
    bool turned;               /* the last step ended at a turning point: the observed velocity is zero */
    bool passing;              /* the same for a turning point that was no event */
    bool ended;                /* `pending` or `failure` waits to be reported */
    saltus_event pending;      /* event at the step's end; kind SALTUS_STEP: none */
    double volume, log_volume; /* of the last impact: its share of the sum rule's product; the logarithm */
    double last_speed;         /* of the last contact event */
    double *delay;             /* per column: d (event time) / d column of the last event */
    saltus_pace first, later;  /* used while tangent vectors hold transients, and afterwards */
    saltus_face_state face[SALTUS_FACES_MAX];
    saltus_contact_map hold;              /* faces in lasting contact */
    saltus_event queue[SALTUS_FACES_MAX]; /* impacts in the same instant as `pending`, still to be reported */
    saltus_message why;                   /* of the failure */
} saltus_lane;

/* The choice between collocation and series in a stiff system. Collocation's steps are as long as the slow
 * motion allows. Series are cheaper between closely spaced events and during an impact's boundary layers,
 * which collocation would resolve by several short steps. */
typedef struct saltus_mixture {
    double worth; /* collocation is cheaper for steps of at least this length; 0: always */
    bool known;   /* `layers` is set */
    double layers;
} saltus_mixture;

struct saltus_flow {
    saltus_arena arena;
    saltus_flow_options options;
    const saltus_kernel *kernel, *narrow;
    int lanes, dimension, dof, extra;
    saltus_lane *lane;
    saltus_work work;               /* jets of the step of all lanes */
    unsigned quiet;                 /* lanes that the kernel takes on in the next step (quiet.h) */
    unsigned due;                   /* of the aimed lanes, no others have anything to report */
    unsigned turning;               /* lanes that watch turning points as events, ... */
    unsigned observed;              /* ... and those that pass them to a function, ... */
    int observer[SALTUS_LANES_MAX]; /* ... and the rows of the gap series in which they do */
    bool shortened;                 /* some lanes' degrees in `work` are not their own (flight.c) */
    saltus_fixed fixed;             /* the kernel compiled for this system, if any */
    saltus_work *probe;             /* one narrow work per lane, for the field at single points */
    saltus_radau *radau;            /* collocation, in flows of one lane; NULL: series only */
    saltus_mixture mixture;
    bool collocated; /* the step being made is one of collocation */
    saltus_parameter_column parameter[SALTUS_DIRECTIONS_MAX];
    bool transients; /* the tangent vectors hold transients when set (saltus_flow_expect_transients) */
    double period_steps_max; /* the run fails in a period that would need more */
    /* Scratch in plain layout, for one lane at a time, at its start or at an event. */
    double *state, *tangents;   /* dimension, columns * dimension */
    double *before, *after;     /* fields just before and after an event */
    double *trial;              /* a state */
    saltus_contact_map scratch; /* a map being tried */
};

/* The lanes of a flow but for some, as bits. */
static inline unsigned saltus_lanes_but(const saltus_flow *flow, unsigned some) {
    return ((1u << flow->lanes) - 1) & ~some;
}

/* time.c */
/* SALTUS_BAD_INPUT unless the phase is a finite number of at most 1e15. */
saltus_status saltus_time_check(saltus_time time, saltus_message *message);
saltus_time saltus_time_after(saltus_time time, double periods);
/* b - a in periods. */
static inline double saltus_time_between(saltus_time a, saltus_time b) {
    return (double)(b.cycle - a.cycle) + (b.phase - a.phase);
}

/* flow.c */
/* saltus_flow_aim with a function that takes the turning points, if they are watched: each step's in order of
 * time, before the step's event is reported. They end no step, so the motion is that of an unwatched lane. */
void saltus_flow_aim_observed(saltus_flow *flow, int lane, saltus_time until, unsigned watch,
                              saltus_turnings turnings);
/* Reset a lane to a time and state without contacts; tangent vectors as at a start. */
void saltus_flow_restart(saltus_flow *flow, int lane, saltus_time time, const double *state);
/* Project flow->state and flow->tangents onto the constraints of the held contacts, so that rounding does not
 * lift them off the stops. */
void saltus_flow_keep_contacts(saltus_flow *flow, int lane);

/* prescribed.c */
/* Called after each step of a coast but the last. */
typedef saltus_status saltus_step_function(void *context, saltus_message *message);
/* saltus_flow_coast that calls `after` (may be NULL) between steps. Errors: also those of `after`. */
saltus_status saltus_flow_coast_by_steps(saltus_flow *flow, int lane, saltus_time until,
                                         saltus_extreme *extremes, saltus_step_function *after, void *context,
                                         saltus_message *message);

/* flight.c */
/* Expand the series of all lanes to the degrees that their steps need. False: to their full degrees, and how
 * far they reach has not been measured yet. */
bool saltus_flow_expand(saltus_flow *flow);
/* The longest time that a series of order `degree` - 2 surely covers within rtol, even for motion at the
 * highest rate of the linear part. */
double saltus_flow_brief(const saltus_system *system, int degree, double rtol);

/* mixture.c */
/* Make the next step of a flow with collocation: from the state and phase in the stepping work to its jets
 * and step, by collocation or by series, whichever costs less. Errors: SALTUS_STALLED if no step of
 * collocation converges. */
saltus_status saltus_flow_mix(saltus_flow *flow);
/* To be called at a start (`start`) or an event: the next step must not extrapolate from earlier ones. */
void saltus_flow_break(saltus_flow *flow, bool start);

/* lane.c */
/* Copy a lane's state (column 0) or tangent vector from (gather) or to (scatter) the rows of the stepping
 * work; _all: the state and all tangent vectors, to or from flow->state and flow->tangents. */
void saltus_lane_gather(const saltus_flow *flow, int lane, int column, double *vector);
void saltus_lane_scatter(saltus_flow *flow, int lane, int column, const double *vector);
void saltus_lane_gather_all(saltus_flow *flow, int lane);
void saltus_lane_scatter_all(saltus_flow *flow, int lane);

/* contact_map.c */
/* Build the map of a set of faces; false if their normals are dependent. Faces in `elastic` rebound with
 * their restitution at the velocity (NULL if `elastic` is 0). */
bool saltus_contact_map_build(const saltus_system *system, unsigned faces, unsigned elastic,
                              const double *velocity, saltus_contact_map *map);
void saltus_contact_map_apply(const saltus_contact_map *map, int dof, double *velocity);
/* The map's derivative at the velocity that it was built for, applied to a change of velocity. */
void saltus_contact_map_carry(const saltus_contact_map *map, int dof, double *change);
/* The derivative of a map's rows along a direction; `push` and `pull` have the map's layout. */
void saltus_contact_map_vary(const saltus_system *system, const saltus_contact_map *map, unsigned elastic,
                             const saltus_variation *variation, double *push, double *pull);
/* Lower the normal components of displacements or velocities at the map's faces by `excess` (length count),
 * along the push directions. */
void saltus_contact_map_share_out(const saltus_contact_map *map, int dof, const double *excess,
                                  double *vector);
/* Bring a state exactly onto the faces of a map without restitution: gaps and normal velocities zero. */
void saltus_contact_map_settle(const saltus_system *system, const saltus_contact_map *map, double *state);
/* Normal velocity or acceleration towards a face. */
double saltus_face_normal(const saltus_system *system, int face, const double *vector);
/* Copy a map into a lane's rows of a work's first `slots` contacts; slots beyond its count become zero. */
void saltus_contact_map_publish(const saltus_contact_map *map, saltus_work *work, int lane, int slots);

/* probe.c */
/* Expand a state with given contacts to `order`, in the lane's narrow work, which is returned. */
saltus_work *saltus_probe_at(saltus_flow *flow, int lane, const double *state, double phase,
                             const saltus_contact_map *hold, int order);
/* Field at a state with given contacts. */
void saltus_field_at(saltus_flow *flow, int lane, const double *state, double phase,
                     const saltus_contact_map *hold, double *derivative);

/* contact.c */
/* Decide which of the faces touched with zero normal velocity (`resting`) hold; sets `hold` and `touch`. */
void saltus_contacts_rest(saltus_flow *flow, int lane, unsigned resting);
/* Apply an impact on a face to flow->state and flow->tangents, end its chatter if it is complete, and fill in
 * the event. `acceleration` is that towards the face just before, infinite if unknown. Errors:
 * SALTUS_STALLED; the lane's `why` may tell the cause. */
saltus_status saltus_contacts_impact(saltus_flow *flow, int lane, int face, double acceleration,
                                     saltus_event *event);
/* Release a face whose force has fallen to zero; false if it still presses at the state itself. */
bool saltus_contacts_release(saltus_flow *flow, int lane, int face);
/* Set the faces in lasting contact; if they cannot hold together, none holds and the result is false. */
bool saltus_contacts_set(saltus_flow *flow, int lane, unsigned contacts);
/* Copy a lane's held contacts into the rows of the stepping work. */
void saltus_contacts_publish(saltus_flow *flow, int lane);

/* direction.c */
/* Load the stored directions into the works, for lane 0's present system. */
void saltus_directions_load(saltus_flow *flow);
/* Put the derivative of lane 0's contact projection along each direction into the stepping work. */
void saltus_directions_publish(saltus_flow *flow);
/* At the end of a step (length in units of time): turn parameter columns from derivatives at fixed time since
 * the step's begin into derivatives at fixed phase. */
void saltus_columns_rephase(saltus_flow *flow, int lane, double step);
/* Project a tangent vector onto the held contacts' constraints, as saltus_contact_map_settle a state. */
void saltus_column_settle(saltus_flow *flow, int lane, int column);
/* The change of a face's gap along a tangent vector: n . delta_q, and for a parameter column the change of
 * the stop itself. */
double saltus_column_gap(const saltus_flow *flow, int lane, int face, int column);
/* The change of side * n.vector along a tangent vector that changes `vector` (length dof) by `delta`. */
double saltus_column_normal(const saltus_flow *flow, int lane, int face, int column, const double *vector,
                            const double *delta);
/* Take a tangent vector through a contact map at fixed time: DP delta, and for a parameter column the change
 * of the map. `velocity` is the trajectory's before the impact; faces in `elastic` rebound. */
void saltus_column_impact(saltus_flow *flow, int lane, const saltus_contact_map *map, unsigned elastic,
                          const double *velocity, int column);
/* The change of the observer's row along a tangent vector, times `vector`: zero but for columns of parameters
 * on which the row depends. */
double saltus_column_observer(const saltus_flow *flow, int column, const double *vector);

/* events.c */
/* When a face that the lane has just left or is close to will be reached, estimated from the first orders of
 * its gap's series; infinite if never. */
double saltus_events_forecast(const saltus_flow *flow, int lane);
/* The first event of a lane within `step` of the step just expanded. */
saltus_first_event saltus_events_first(saltus_flow *flow, int lane, double step);
/* Pass the turning points within the step just made to the lane's function. */
void saltus_events_turnings(saltus_flow *flow, int lane);
/* The acceleration of row `row` of the gap series (`observer` . q) at a time since the begin of the step just
 * expanded. */
double saltus_events_acceleration(const saltus_flow *flow, int lane, int row, const double *observer,
                                  double since);
/* Carry what is known of the faces' gaps to the end of the step; false, with the gap in *gap, if one has
 * passed its stop (a lost impact). */
bool saltus_events_carry(saltus_flow *flow, int lane, double step, int event_face, double *gap);

/* Whether series are the fastest for tangent vectors that restart again and again, each time with transient
 * layers in the fast modes, after which little time is left for collocation. A step of collocation costs such
 * vectors the more the larger the system is (measured on pipes of 8 to 20 modes and on chains of masses). */
bool saltus_flow_restarts_in_series(const saltus_system *system, saltus_integrator integrator);

#endif
