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

/* A linear map of velocities that acts at a set of faces: v -> v - sum_k push_k (pull_k . v). With the
 * restitution in the pull rows it is the impact law of these faces, without it the projection that a lasting
 * contact applies to accelerations. Directions point towards the stops. */
typedef struct saltus_contact_map {
    unsigned faces; /* as bits */
    int count;      /* of them */
    int face[SALTUS_FACES_MAX];
    double *push, *pull; /* [count][dof], storage for SALTUS_FACES_MAX of them */
    double *change;      /* pull rows of the derivative: `pull` where no restitution depends on the speed */
    double *change_rows; /* storage for other ones; NULL in maps of lasting contacts */
    double speed[SALTUS_FACES_MAX], r[SALTUS_FACES_MAX]; /* of the faces; r = 0 where they do not rebound */
    double inverse[SALTUS_FACES_MAX *
                   SALTUS_FACES_MAX]; /* of n_k . push_j: shares gaps out among the directions */
} saltus_contact_map;

/* A direction in parameter space that a parameter column follows, and how the system changes along it. */
typedef struct saltus_parameter_column {
    saltus_direction direction;
    saltus_variation variation;
} saltus_parameter_column;

/* What is known of a face's gap at the start of a step, more exactly than n.q - d tells near contact: the
 * first `touch` coefficients of the gap's series vanish; or, with `shadow`, its value and rate carried over
 * from the last step. A contact that holds lets go where its force pulls by more than `pull`. */
typedef struct saltus_face_state {
    int touch;
    bool shadow;
    double gap, rate, pull;
} saltus_face_state;

/* Where a lane shall go. */
typedef struct saltus_target {
    saltus_time since, until; /* since: coasting only */
    unsigned watch;
    bool aimed;               /* under way */
    bool coasting;            /* events are prescribed from outside: none is searched for */
    saltus_extreme *extremes; /* coasting: where largest gaps and smallest forces are collected, or NULL */
} saltus_target;

/* The last step of a lane, or the one under way. */
typedef struct saltus_step {
    saltus_time begin;
    double length;
    bool calm;  /* at its begin no face was touched, close or held */
    bool turns; /* the observed velocity may have a zero in it; told where turning points are watched */
    bool lands; /* it ends at the target */
} saltus_step;

/* The first event of a step; kind SALTUS_STEP and the step's end when there is none. */
typedef struct saltus_first_event {
    double time; /* since the step's begin */
    saltus_event_kind kind;
    int face;
} saltus_first_event;

/* A degree of series, and the longest step that is stable with it. */
typedef struct saltus_pace {
    int degree;
    double limit;
} saltus_pace;

/* One trajectory: its place in time, its contacts, and what it has to report. What every step looks at comes
 * first and lies close together. */
typedef struct saltus_lane {
    const saltus_system *system;
    saltus_time now;
    saltus_target target;
    saltus_step step;
    saltus_flow_info info;
    double flight;     /* time to the next impact of a chatter, else infinite */
    double brief;      /* what takes no longer is reached with fewer orders than `degree` */
    double cycle_from; /* the steps counted within this period begin at this phase */
    int cycle_steps;   /* so many */
    int cycle_events;  /* contact events within this period */
    int idle_events;   /* events since time last moved on */
    int degree;        /* of its series where nothing ends its steps before */
    int queued;
    saltus_status failure;
    bool settled;             /* tangent vectors hold no transients any more */
    bool turned;              /* the observer's velocity is zero now, by a turning event */
    bool ended;               /* the pending event, or the failure, waits to be fetched */
    saltus_event pending;     /* event at the step's end; kind SALTUS_STEP when there is none */
    double last_speed;        /* of the last contact event */
    double *delay;            /* per column: d (event time) / d column of the last event */
    saltus_pace first, later; /* where tangent vectors hold transients at first, and once these have gone */
    saltus_face_state face[SALTUS_FACES_MAX];
    saltus_contact_map hold;              /* faces in lasting contact */
    saltus_event queue[SALTUS_FACES_MAX]; /* impacts in the same instant as the pending one */
    saltus_message why;                   /* of the failure */
} saltus_lane;

/* Collocation and series in turns, where a system is stiff. Collocation's steps are as long as what lasts
 * allows; series are cheaper between events that follow each other closely, and as long as an impact's
 * boundary layers last, which collocation would resolve by several short steps. */
typedef struct saltus_mixture {
    double worth; /* from this length on a step of collocation costs less than the series' steps; 0: always */
    bool known;   /* how long the layers last from here on: */
    double layers;
} saltus_mixture;

struct saltus_flow {
    saltus_arena arena;
    saltus_flow_options options;
    const saltus_kernel *kernel, *narrow;
    int lanes, dimension, dof, extra;
    saltus_lane *lane;
    saltus_work work;    /* all lanes: jets of the step */
    bool shortened;      /* the degrees of some lanes are below their own (flight.c) */
    saltus_fixed fixed;  /* and what has been compiled for them */
    saltus_work *probe;  /* one narrow work per lane, for single points */
    saltus_radau *radau; /* collocation, in a flow of one lane; NULL: series alone */
    saltus_mixture mixture;
    bool collocated; /* the step under way */
    saltus_parameter_column parameter[SALTUS_DIRECTIONS_MAX];
    bool transients;         /* of tangent vectors are all there is to them */
    double period_steps_max; /* a period of more steps is not followed to its end */
    /* Scratch in plain layout, for one lane at a time where it starts or has an event. */
    double *state, *tangents;   /* dimension, columns * dimension */
    double *before, *after;     /* fields on the two sides of an event */
    double *trial;              /* a state */
    saltus_contact_map scratch; /* a map under trial */
};

/* time.c */
/* SALTUS_BAD_INPUT where a time is no number of periods. */
saltus_status saltus_time_check(saltus_time time, saltus_message *message);
saltus_time saltus_time_after(saltus_time time, double periods);
/* b - a in periods. */
static inline double saltus_time_between(saltus_time a, saltus_time b) {
    return (double)(b.cycle - a.cycle) + (b.phase - a.phase);
}

/* flow.c */
/* Put a lane at a time and state with nothing known of its contacts, tangent vectors as at a start. */
void saltus_flow_restart(saltus_flow *flow, int lane, saltus_time time, const double *state);
/* While a contact holds, rounding must not lift the state off the stop; tangent vectors neither. */
void saltus_flow_keep_contacts(saltus_flow *flow, int lane);

/* prescribed.c */
/* What is done after a step that another one follows. */
typedef saltus_status saltus_step_function(void *context, saltus_message *message);
/* saltus_flow_coast, of which every step is told (`after` may be NULL). Errors: those of `after`, too. */
saltus_status saltus_flow_coast_by_steps(saltus_flow *flow, int lane, saltus_time until,
                                         saltus_extreme *extremes, saltus_step_function *after, void *context,
                                         saltus_message *message);

/* flight.c */
/* Expand the series of all lanes to the degrees that their steps need, and measure how far they reach. */
void saltus_flow_expand(saltus_flow *flow);
/* The longest time that a series of two orders less than a degree surely covers, though all motion be as fast
 * as the linear part can make it. */
double saltus_flow_brief(const saltus_system *system, int degree, double rtol);

/* mixture.c */
/* The next step of a flow that has both: from the state and phase in the stepping work to its jets and step,
 * by the way that costs less. Errors: SALTUS_STALLED when no step of collocation converges. */
saltus_status saltus_flow_mix(saltus_flow *flow);
/* A start or an event: no step follows from those before. */
void saltus_flow_break(saltus_flow *flow, bool start);

/* lane.c */
/* A lane's state (column 0) or tangent vector from or into the rows of the stepping work; all of them into
 * the flow's state and tangents and back. */
void saltus_lane_gather(const saltus_flow *flow, int lane, int column, double *vector);
void saltus_lane_scatter(saltus_flow *flow, int lane, int column, const double *vector);
void saltus_lane_gather_all(saltus_flow *flow, int lane);
void saltus_lane_scatter_all(saltus_flow *flow, int lane);

/* contact_map.c */
/* The map of a set of faces; false if their normals are dependent. Faces in `elastic` rebound with their
 * restitution at the velocity (NULL where `elastic` is 0). */
bool saltus_contact_map_build(const saltus_system *system, unsigned faces, unsigned elastic,
                              const double *velocity, saltus_contact_map *map);
void saltus_contact_map_apply(const saltus_contact_map *map, int dof, double *velocity);
/* The derivative of that: what the map makes of a small change of the velocity that it was built at. */
void saltus_contact_map_carry(const saltus_contact_map *map, int dof, double *change);
/* The derivative of a map along a direction: push and pull of the map's layout. */
void saltus_contact_map_vary(const saltus_system *system, const saltus_contact_map *map, unsigned elastic,
                             const saltus_variation *variation, double *push, double *pull);
/* Take what is too much at each face of a map off displacements or velocities. */
void saltus_contact_map_share_out(const saltus_contact_map *map, int dof, const double *excess,
                                  double *vector);
/* Bring a state exactly onto the faces of a map without restitution: gaps and normal velocities zero. */
void saltus_contact_map_settle(const saltus_system *system, const saltus_contact_map *map, double *state);
/* Normal velocity or acceleration towards a face. */
double saltus_face_normal(const saltus_system *system, int face, const double *vector);
/* Put a map into a lane's rows of a work's first `slots` contacts; those beyond the map's do nothing. */
void saltus_contact_map_publish(const saltus_contact_map *map, saltus_work *work, int lane, int slots);

/* probe.c */
/* Series to `order` of a state at one point with given contacts, in the lane's narrow work. */
saltus_work *saltus_probe_at(saltus_flow *flow, int lane, const double *state, double phase,
                             const saltus_contact_map *hold, int order);
/* Field at a state with given contacts. */
void saltus_field_at(saltus_flow *flow, int lane, const double *state, double phase,
                     const saltus_contact_map *hold, double *derivative);

/* contact.c */
/* Decide, for faces touched with zero normal velocity (resting), which of them hold; set hold and touch. */
void saltus_contacts_rest(saltus_flow *flow, int lane, unsigned resting);
/* Impact on a face, its event; complete chatter; tangent vectors. `acceleration`: towards the face just
 * before, infinite where it is not known. */
saltus_status saltus_contacts_impact(saltus_flow *flow, int lane, int face, double acceleration,
                                     saltus_event *event);
/* Let go of a face whose force has come to zero; false if at the state itself it still presses. */
bool saltus_contacts_release(saltus_flow *flow, int lane, int face);
/* Change the lasting contacts: faces that hold from now on; false, and none holds, if they cannot hold
 * together. */
bool saltus_contacts_set(saltus_flow *flow, int lane, unsigned contacts);
/* Put a lane's held contacts into the rows of the stepping work. */
void saltus_contacts_publish(saltus_flow *flow, int lane);

/* direction.c */
/* Bring the stored directions into the works, for the system that lane 0 has now. */
void saltus_directions_load(saltus_flow *flow);
/* How the projection of lane 0's held contacts changes: into the stepping work. */
void saltus_directions_publish(saltus_flow *flow);
/* At the end of a step of a real length: parameter columns from fixed time since the step's begin to fixed
 * phase. */
void saltus_columns_rephase(saltus_flow *flow, int lane, double step);
/* Bring a tangent vector onto the held contacts' constraints, as a state is (saltus_contact_map_settle). */
void saltus_column_settle(saltus_flow *flow, int lane, int column);
/* How a face's gap answers to a tangent vector: n . delta_q, and for a parameter column the change of the
 * stop itself. */
double saltus_column_gap(const saltus_flow *flow, int lane, int face, int column);
/* How side * n.vector answers to a tangent vector under which `vector` (length dof) changes by `delta`. */
double saltus_column_normal(const saltus_flow *flow, int lane, int face, int column, const double *vector,
                            const double *delta);
/* A tangent vector through the velocity law of a contact map at a fixed time: DP delta, and for a parameter
 * column the change of the law; `velocity` is the trajectory's before it, faces in `elastic` rebound. */
void saltus_column_impact(saltus_flow *flow, int lane, const saltus_contact_map *map, unsigned elastic,
                          const double *velocity, int column);
/* How the observer's row itself changes with a tangent vector, times a vector: zero but for a column of a
 * parameter that is in it. */
double saltus_column_observer(const saltus_flow *flow, int column, const double *vector);

/* events.c */
/* When a face that a lane is close to will be reached, from the first few orders of its gap's series alone;
 * infinite when none seems to be. */
double saltus_events_forecast(const saltus_flow *flow, int lane);
/* The first event of a lane on the step just expanded, within `step`, where there may be one. */
saltus_first_event saltus_events_first(saltus_flow *flow, int lane, double step);
/* The acceleration of a row of the gap series, which `observer` makes of the displacements, at a time since
 * the begin of the step just expanded. */
double saltus_events_acceleration(const saltus_flow *flow, int lane, int row, const double *observer,
                                  double since);
/* Carry the faces' gap knowledge to the end of the step; false if a gap has opened beyond its stop (a lost
 * impact). */
bool saltus_events_carry(saltus_flow *flow, int lane, double step, int event_face, double *gap);

#endif
