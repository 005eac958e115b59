/* Private: what the files of this folder share.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SWEEP_PRIVATE_H
#define SALTUS_SWEEP_PRIVATE_H

#include "saltus/sweep.h"

#include "flow/flow.h"
#include "motion/growth.h"
#include "motion/motion.h"
#include "motion/visits.h"
#include "signal/random.h"

struct saltus_sweep {
    saltus_scene scene;
    saltus_axis axes[SALTUS_AXES_MAX];
    double *lists[SALTUS_AXES_MAX];
    int axis_count;
    saltus_sweep_options options;
    saltus_pass passes[SALTUS_PASSES];
    int pass_count, dimension;
    long long points;
    bool moves_start;      /* an axis varies an entry of the initial state */
    saltus_system *system; /* the system with the most terms among the points */
};

/* The system at a point of the grid, to be freed by the caller. Errors: those of saltus_system_new. */
saltus_status saltus_sweep_system(const saltus_sweep *sweep, long long point, saltus_system **system,
                                  saltus_message *message);

/* The task that computes a place. */
long long saltus_sweep_task_of(const saltus_sweep *sweep, long long place);

/* watch.c: what a trajectory does while it is recorded */
/* Clouds of points, in the order of the bits SALTUS_KEEP_... and of a packed result. */
enum { SALTUS_CLOUD_TURNING, SALTUS_CLOUD_IMPACTS, SALTUS_CLOUD_STROBES, SALTUS_CLOUDS };

typedef struct saltus_cloud {
    void *entries;
    size_t count, room;
} saltus_cloud;

/* Size in bytes of an entry of a cloud, for states of `dimension` numbers. */
size_t saltus_cloud_entry(int which, int dimension);

typedef struct saltus_watch {
    saltus_lap lap; /* counts, extremes, mean square */
    unsigned keep;  /* bits SALTUS_KEEP_... */
    saltus_time begin, touched;
    bool touching;
    int heading;    /* sign of the observed velocity after the last event */
    double contact; /* time in contact, in periods, but for the contact that holds since `touched` */
    bool counts;    /* section points are the returns to the section, not the states at phase 0 */
    saltus_crossings returns;
    double largest_speed;
    saltus_cloud clouds[SALTUS_CLOUDS];
    bool sound; /* false: a cloud has run out of memory */
} saltus_watch;

/* Begin a recording, at a section point or where returns to the section are counted. `square` is the flow's
 * integral of the squared observed displacement at that time. Clouds are emptied but keep their memory. */
void saltus_watch_begin(saltus_watch *watch, const saltus_system *system, unsigned keep, bool counts,
                        saltus_time time, const double *state, bool touching, double square);
/* Take an event, turning points included; `state` is the present one and must be set at contact events. */
void saltus_watch_event(saltus_watch *watch, const saltus_event *event, const double *state, bool touching);
/* Take a turning point of the watch that is the first argument, as a saltus_turning_function. */
void saltus_watch_turning(void *watch, double displacement, int heading);
/* Add the returns to the section that an event of the watched lane brings, a reached target included. */
void saltus_watch_returns(saltus_watch *watch, const saltus_flow *flow, int lane, const saltus_event *event,
                          const double *state);
/* Add a section point; not the one that ends the recording, which would be counted twice. */
void saltus_watch_section(saltus_watch *watch, const double *state);
/* Replace the section points by those of the orbit that was gone around, the first one last. */
void saltus_watch_orbit(saltus_watch *watch, const double *points, int periods);
/* Fill the row with the measures of the recording from its beginning to `end`, where the state is `state`;
 * `square` as in saltus_watch_begin. */
void saltus_watch_measure(saltus_watch *watch, saltus_time end, const double *state, double square,
                          saltus_sweep_row *row);
void saltus_watch_close(saltus_watch *watch);

/* job.c: the tasks in progress in one thread, and their results */
typedef struct saltus_cell {
    saltus_sweep_row row;
    double *state; /* at the end, n numbers */
    double *orbit; /* section points, periods x n, of a periodic row with several seeds; otherwise NULL */
    saltus_cloud clouds[SALTUS_CLOUDS];
} saltus_cell;

typedef struct saltus_job {
    const saltus_sweep *sweep;
    long long task;
    int length, seeds, assigned; /* `assigned`: seeds that trajectories have taken */
    int finished;                /* seeds that have passed all places */
    int holders;        /* references: by trajectories, and by the worker until all seeds are assigned */
    int *missing;       /* per place: seeds without a result yet */
    saltus_cell *cells; /* [place][seed] */
} saltus_job;

/* The results of a task being collected; NULL without memory. */
saltus_job *saltus_job_open(const saltus_sweep *sweep, long long task);
void saltus_job_free(saltus_job *job);
/* Store a trajectory's result in its cell, which takes over the watch's clouds. Returns true when all seeds
 * of the place are there and saltus_job_emit is due. *sound is false without memory. */
bool saltus_job_put(saltus_job *job, int place, int seed, const saltus_sweep_row *row, const double *state,
                    const double *orbit, saltus_watch *watch, bool *sound);
/* Number the distinct attractors at a place, pass the result to the feed and free the cells. */
saltus_status saltus_job_emit(saltus_job *job, int place, const saltus_system *system,
                              const saltus_sweep_feed *feed, saltus_message *message);

/* trajectory.c: one seed in a lane, on its way along the places of a task */
typedef enum saltus_stage {
    SALTUS_STAGE_TRANSIENT, /* runs unobserved */
    SALTUS_STAGE_PROVING,   /* at the end of a long transient: an orbit is disturbed before it is recorded */
    SALTUS_STAGE_SETTLING,
    SALTUS_STAGE_RECORDING,
    SALTUS_STAGE_ORBIT,    /* once around a periodic orbit */
    SALTUS_STAGE_MEASURING /* its exponent is measured with a tangent vector */
} saltus_stage;

/* What the worker has to do next with a trajectory. */
typedef enum saltus_next {
    SALTUS_NEXT_GO_ON,
    SALTUS_NEXT_MEASURE, /* move it to a lane with a tangent vector, to measure its exponent */
    SALTUS_NEXT_DONE     /* this place is finished and the row filled */
} saltus_next;

/* The evidence that a trajectory has settled. */
typedef struct saltus_proof {
    saltus_settling settling;
    bool disturbed;         /* it has been disturbed, to prove stability, ... */
    double *undisturbed;    /* ... from this state ... */
    long long disturbed_at; /* ... at this cycle */
    bool proven;            /* an orbit was proven stable before the recording */
    double *rejected;       /* a point of an unstable orbit that Newton's method found, ... */
    int rejected_period;    /* ... of this period; 0: none */
    long long rejected_at;  /* ... and the cycle when the trajectory passed it */
    int recurring;          /* the period that roughly recurs, ... */
    long long waited;       /* ... and the periods since it began to */
    double trend[2];        /* its recurrence at the last look and at the one before */
    long long patience;     /* periods to wait before Newton's method is tried */
    long long ask_again;  /* cycle before which Newton's method is not tried again; 0: iteration could tell */
    double *orbit;        /* section points of the settled orbit; room for longest x n */
    saltus_visits visits; /* without forcing: its returns to the section */
    saltus_rest_look rest; /* without forcing: its last look for a rest */
    double exponent;       /* without forcing: largest exponent of the orbit that Newton's method found */
} saltus_proof;

/* A measurement of the exponent. */
typedef struct saltus_measuring {
    saltus_arena arena;
    saltus_growth growth;
    saltus_average average; /* of the growth per period */
    long long samples;      /* periods measured; below zero while the vector is still aligning */
    long long run_end;      /* number of samples at which the exponent is judged next */
    long long deadline;     /* cycle by which a period must have appeared; 0: none need appear */
    long long steps;        /* the flow's steps before the first sample */
    bool given;             /* the verdict is known; only the exponent is lacking */
    double *points; /* `count` section points, n numbers each; after the room for them one number for each:
                       the vector's growth since the previous point, or without forcing the time */
    long long count, asked; /* `asked`: number of points at the last test for a torus */
} saltus_measuring;

typedef struct saltus_sweep_trajectory {
    const saltus_sweep *sweep;
    saltus_job *job; /* NULL: idle */
    int seed, place;
    saltus_system *system;
    saltus_flow *flow;
    int lane;
    saltus_flow_info before; /* counters up to the last restart of the flow */
    saltus_effort effort;    /* steps spent by Newton's method on the way */
    double *state;           /* current state */
    saltus_random random;
    saltus_stage stage;
    long long stage_end; /* cycle at which the stage ends */
    saltus_proof proof;
    saltus_watch watch, round;  /* the recording; the lap around an orbit that is found after it */
    saltus_watch *active;       /* the one of these being filled, or NULL */
    saltus_measuring measuring; /* only with SALTUS_KEEP_LYAPUNOV */
    saltus_sweep_row row;
    bool starved; /* out of memory */
} saltus_sweep_trajectory;

/* A trajectory without a job; false without memory. To be closed also then. */
bool saltus_sweep_trajectory_open(saltus_sweep_trajectory *trajectory, const saltus_sweep *sweep);
void saltus_sweep_trajectory_close(saltus_sweep_trajectory *trajectory);
/* The point of the grid where the trajectory is. */
long long saltus_sweep_trajectory_point(const saltus_sweep_trajectory *trajectory);
/* Periods since the trajectory began this place. */
long long saltus_sweep_trajectory_cycle(const saltus_sweep_trajectory *trajectory);
/* Steps, impacts and other contact events since the trajectory began this place. */
saltus_flow_info saltus_sweep_trajectory_information(const saltus_sweep_trajectory *trajectory);
/* Seed the random numbers by the sweep's seed, the point and `which`, and by nothing else. */
void saltus_sweep_trajectory_seed(saltus_sweep_trajectory *trajectory, int which);
/* Continue from another state at the same time. False if the flow cannot. */
bool saltus_sweep_trajectory_continue(saltus_sweep_trajectory *trajectory, const double *state);
/* Without forcing: count by another period, and continue from another state and time. False if it cannot. */
bool saltus_sweep_trajectory_count_by(saltus_sweep_trajectory *trajectory, double period, saltus_time time,
                                      const double *state);
/* Continue from where the trajectory was disturbed, as if that had not been. False if the flow cannot. */
bool saltus_sweep_trajectory_go_back(saltus_sweep_trajectory *trajectory);
/* Continue in another lane. False if the flow cannot. */
bool saltus_sweep_trajectory_move(saltus_sweep_trajectory *trajectory, saltus_flow *flow, int lane);
/* Store a verdict, or that there will be none, in the row, with the time and the impacts so far. */
void saltus_sweep_trajectory_settle(saltus_sweep_trajectory *trajectory, saltus_verdict verdict, int periods);
/* In a lane with a tangent vector, set it to the last normalised one: a restart of the flow removes it, and
 * unchecked it would overflow. */
void saltus_sweep_trajectory_restore_tangent(saltus_sweep_trajectory *trajectory);

/* judge.c */
/* What a trajectory has settled on; the verdict is pending while it goes on. */
typedef struct saltus_judgement {
    saltus_verdict verdict;
    int periods;
    int recurs; /* the least period that roughly recurs, or 0 */
} saltus_judgement;

/* Without forcing: count time by the mean time between returns from now on, if returns still occur
 * (*counts). False if the flow cannot continue. */
bool saltus_sweep_trajectory_count_returns(saltus_sweep_trajectory *trajectory, bool *counts);
/* Reset the patience for a trajectory that begins to settle. */
void saltus_sweep_trajectory_begin_settling(saltus_sweep_trajectory *trajectory);
/* Judge a trajectory at a section point; the section points of an orbit go to proof.orbit. The trajectory
 * may be disturbed, or moved onto an orbit that Newton's method has found. */
saltus_judgement saltus_sweep_trajectory_judge(saltus_sweep_trajectory *trajectory);

/* exponent.c: fill a settled row's exponent from the multipliers of the orbit at its state. False if
 * Newton's method does not find the orbit there. */
bool saltus_sweep_trajectory_exponent(saltus_sweep_trajectory *trajectory);

/* measure.c */
/* Start to measure the exponent from the trajectory's present state, in a lane, possibly its own, of a flow
 * with one tangent vector that has been given its system, and aim the lane. False if it cannot continue
 * there: the row stays as it is. */
bool saltus_sweep_trajectory_measure(saltus_sweep_trajectory *trajectory, saltus_flow *flow, int lane);
/* Process an event of a trajectory that is measured; *section: it is at a section point. */
saltus_next saltus_measuring_follow(saltus_sweep_trajectory *trajectory, const saltus_event *event,
                                    bool *section);
/* Without forcing: take an event, a reached target included, after which the lane is at t->state, and
 * collect the returns. */
void saltus_sweep_trajectory_take(saltus_sweep_trajectory *trajectory, const saltus_event *event);
/* Add the sample of one more period, and judge the exponent when a run is complete. */
saltus_next saltus_measuring_add(saltus_sweep_trajectory *trajectory);

/* stages.c: the stages of a trajectory */
/* Start the trajectory at its present place, in a lane of a flow that has been given its system, and aim the
 * lane. False if it cannot start: the row says so. */
bool saltus_sweep_trajectory_start(saltus_sweep_trajectory *trajectory, saltus_flow *flow, int lane);
/* Process an event of its lane; if the trajectory goes on, the lane has been aimed again. */
saltus_next saltus_sweep_trajectory_follow(saltus_sweep_trajectory *trajectory, const saltus_event *event);
/* Make a row without a motion, failed or beyond a stop: its place has no system or no initial state. */
void saltus_sweep_trajectory_refuse(saltus_sweep_trajectory *trajectory, saltus_verdict verdict);
/* The flow failed: so does the row, unless only the exponent was lacking. */
void saltus_sweep_trajectory_fail(saltus_sweep_trajectory *trajectory);

#endif
