/* Private: what the parts of the sweep's engine share.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SWEEP_PRIVATE_H
#define SALTUS_SWEEP_PRIVATE_H

#include "saltus/sweep.h"

#include "flow/effort.h"
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
    bool moves_start;      /* an axis is an entry of the initial state */
    saltus_system *system; /* of the point with the most terms */
};

/* sweep.c */
/* The system at a point. Errors: those of saltus_system_new. */
saltus_status saltus_sweep_system(const saltus_sweep *sweep, long long point, saltus_system **system,
                                  saltus_message *message);

/* watch.c: what a trajectory does while it is recorded. */
/* Clouds of points, in the order of their bits SALTUS_KEEP_... and of a packed result. */
enum { SALTUS_CLOUD_TURNING, SALTUS_CLOUD_IMPACTS, SALTUS_CLOUD_STROBES, SALTUS_CLOUDS };

typedef struct saltus_cloud {
    void *entries;
    size_t count, room;
} saltus_cloud;

/* Bytes of one entry of a cloud, for states of so many numbers. */
size_t saltus_cloud_entry(int which, int dimension);

typedef struct saltus_watch {
    saltus_lap lap; /* counts, extremes, mean square */
    unsigned keep;  /* of SALTUS_KEEP_... */
    saltus_time begin, touched;
    bool touching;
    int heading;    /* sign of the observed velocity */
    double contact; /* periods in contact */
    bool counts;    /* its returns are the section points, not what is at phase 0 */
    saltus_crossings returns;
    double largest_speed;
    saltus_cloud clouds[SALTUS_CLOUDS];
    bool sound; /* no cloud has run out of memory */
} saltus_watch;

/* Begin at a section point, or where returns to the section are counted; `square`: the flow's integral of the
 * observed displacement's square there. Clouds keep their memory. */
void saltus_watch_begin(saltus_watch *watch, const saltus_system *system, unsigned keep, bool counts,
                        saltus_time time, const double *state, bool touching, double square);
/* `state` is that of now, for the events of contacts. */
void saltus_watch_event(saltus_watch *watch, const saltus_event *event, const double *state, bool touching);
/* Returns to the section of the lane that is watched, after an event, a target reached included. */
void saltus_watch_returns(saltus_watch *watch, const saltus_flow *flow, int lane, const saltus_event *event,
                          const double *state);
/* A section point; not the last one of the recording, which would be counted twice. */
void saltus_watch_section(saltus_watch *watch, const double *state);
/* The section points are those of an orbit, which has been gone around, the one at its begin last. */
void saltus_watch_orbit(saltus_watch *watch, const double *points, int periods);
/* The measures of the recording, from its begin to `end`, where it is at `state`; `square` as at the begin.
 */
void saltus_watch_measure(saltus_watch *watch, saltus_time end, const double *state, double square,
                          saltus_sweep_row *row);
void saltus_watch_close(saltus_watch *watch);

/* job.c: the tasks under way in one thread, and what comes out of them. */
typedef struct saltus_cell {
    saltus_sweep_row row;
    double *state; /* at the end, n */
    double *orbit; /* periodic, with several seeds: section points, periods x n */
    saltus_cloud clouds[SALTUS_CLOUDS];
} saltus_cell;

typedef struct saltus_job {
    const saltus_sweep *sweep;
    long long task;
    int length, seeds, assigned; /* seeds handed to lanes */
    int finished;                /* seeds whose whole line is done */
    int holders;                 /* trajectories, and the worker as long as it hands its seeds out */
    int *missing;                /* per place: seeds still to come */
    saltus_cell *cells;          /* [place][seed] */
} saltus_job;

saltus_job *saltus_job_open(const saltus_sweep *sweep, long long task);
void saltus_job_free(saltus_job *job);
/* Put a trajectory's outcome into its cell, which takes the watch's clouds over; true when the place is
 * complete, to be handed out with saltus_job_emit. False in *sound when there is no memory. */
bool saltus_job_put(saltus_job *job, int place, int seed, const saltus_sweep_row *row, const double *state,
                    const double *orbit, saltus_watch *watch, bool *sound);
/* Tell distinct attractors apart, hand the place out and free its cells. */
saltus_status saltus_job_emit(saltus_job *job, int place, const saltus_system *system,
                              const saltus_sweep_feed *feed, saltus_message *message);

/* trajectory.c: one seed in a lane, on its way along the places of a task. */
typedef enum saltus_stage {
    SALTUS_STAGE_TRANSIENT, /* not looked at */
    SALTUS_STAGE_SETTLING,
    SALTUS_STAGE_RECORDING,
    SALTUS_STAGE_ORBIT,    /* once around a periodic orbit */
    SALTUS_STAGE_MEASURING /* its exponent, with a tangent vector */
} saltus_stage;

/* How it goes on. */
typedef enum saltus_next {
    SALTUS_NEXT_GO_ON,
    SALTUS_NEXT_MEASURE, /* its exponent is wanted: it needs a lane with a tangent vector */
    SALTUS_NEXT_DONE     /* this place is over, the row being filled */
} saltus_next;

/* Whether it has settled. */
typedef struct saltus_proof {
    saltus_settling settling;
    bool disturbed;         /* to prove stability, ... */
    double *undisturbed;    /* ... from this state ... */
    long long disturbed_at; /* ... at this cycle */
    int recurring;          /* the period that recurs, ... */
    long long waited;       /* ... for so many periods */
    double trend[2];        /* how well it recurred when last looked at, and before */
    long long patience;     /* periods until Newton's method is asked */
    long long ask_again;    /* not before this cycle, where iteration cannot tell the period */
    double *orbit;          /* section points of the settled orbit, longest x n */
    saltus_visits visits;   /* without forcing: returns to the section */
    saltus_rest_look rest;  /* whether it comes to a rest, however slowly */
    double exponent;        /* the largest of the orbit that Newton's method has found without forcing */
} saltus_proof;

/* The exponent under way. */
typedef struct saltus_measuring {
    saltus_arena arena;
    saltus_growth growth;
    saltus_average average; /* of the growth per period */
    long long samples;      /* periods measured; below zero the vector still turns into what grows */
    long long run_end;      /* samples at which they are weighed next */
    long long deadline;     /* cycle by which a period must have shown; 0: there need not be one */
    long long steps;        /* of the flow until the first sample */
    bool given;             /* the verdict is there: nothing but the exponent is lacking */
    double *points;         /* section points, `count` of them, n each; behind their room the growths,
                            or without forcing the times when they came */
    long long count, asked; /* `asked`: of how many last told whether it is one */
} saltus_measuring;

typedef struct saltus_sweep_trajectory {
    const saltus_sweep *sweep;
    saltus_job *job; /* NULL: the lane rests */
    int seed, place;
    saltus_system *system;
    saltus_flow *flow;
    int lane;
    saltus_flow_info before; /* of the flow before it was last started anew */
    saltus_effort effort;    /* of what Newton's method is asked on the way */
    double *state;           /* now */
    saltus_random random;
    saltus_stage stage;
    long long stage_end; /* cycle at which the stage ends */
    saltus_proof proof;
    saltus_watch watch, round;  /* what is recorded; once around the orbit where that comes later */
    saltus_watch *active;       /* of these, or NULL */
    saltus_measuring measuring; /* with SALTUS_KEEP_LYAPUNOV */
    saltus_sweep_row row;
    bool starved; /* out of memory */
} saltus_sweep_trajectory;

bool saltus_sweep_trajectory_open(saltus_sweep_trajectory *trajectory, const saltus_sweep *sweep);
void saltus_sweep_trajectory_close(saltus_sweep_trajectory *trajectory);
/* The grid's point at which it is. */
long long saltus_sweep_trajectory_point(const saltus_sweep_trajectory *trajectory);
/* Periods since it began. */
long long saltus_sweep_trajectory_cycle(const saltus_sweep_trajectory *trajectory);
/* Its steps, impacts and other contact events since it began. */
saltus_flow_info saltus_sweep_trajectory_information(const saltus_sweep_trajectory *trajectory);
/* Seed its random numbers by the sweep's seed, the point and `which` alone, whatever else runs. */
void saltus_sweep_trajectory_seed(saltus_sweep_trajectory *trajectory, int which);
/* Go on from another state at the same time. False when the flow cannot. */
bool saltus_sweep_trajectory_continue(saltus_sweep_trajectory *trajectory, const double *state);
/* Go on from another state and time of a system without forcing that counts by another time. False when the
 * flow cannot. */
bool saltus_sweep_trajectory_count_by(saltus_sweep_trajectory *trajectory, double period, saltus_time time,
                                      const double *state);
/* Go on in another lane. False when the flow cannot. */
bool saltus_sweep_trajectory_move(saltus_sweep_trajectory *trajectory, saltus_flow *flow, int lane);
/* A verdict has been reached, or none will be. */
void saltus_sweep_trajectory_settle(saltus_sweep_trajectory *trajectory, saltus_verdict verdict, int periods);
/* In a lane with a tangent vector, set it to the one last normalised: a start takes it away, and it must not
 * grow for ever. */
void saltus_sweep_trajectory_restore_tangent(saltus_sweep_trajectory *trajectory);

/* judge.c */
/* What a trajectory has settled on; pending: it goes on. */
typedef struct saltus_judgement {
    saltus_verdict verdict;
    int periods;
    int recurs; /* the least period that recurs roughly, or 0 */
} saltus_judgement;

/* Without forcing: count by the mean time between returns from now on, where these still come; *counts says
 * so. False when the flow cannot go on. */
bool saltus_sweep_trajectory_count_returns(saltus_sweep_trajectory *trajectory, bool *counts);
/* A trajectory begins to settle. */
void saltus_sweep_trajectory_begin_settling(saltus_sweep_trajectory *trajectory);
/* Judge a trajectory at a section point; the points of an orbit go to proof.orbit. It may be disturbed, and
 * it may be moved onto an orbit that Newton's method has found. */
saltus_judgement saltus_sweep_trajectory_judge(saltus_sweep_trajectory *trajectory);

/* exponent.c */
/* The largest exponent of a row that has settled, from the multipliers of the orbit at its state. False where
 * Newton's method does not find the orbit there. */
bool saltus_sweep_trajectory_exponent(saltus_sweep_trajectory *trajectory);

/* measure.c */
/* Measure the exponent, from where the trajectory is, in a lane of a flow with one tangent vector that has
 * been given its system; it may be the lane that it is in. Aims it. False when it cannot go on there: the row
 * stays as it is. */
bool saltus_sweep_trajectory_measure(saltus_sweep_trajectory *trajectory, saltus_flow *flow, int lane);
/* What follows from an event of a trajectory that is measured; *section: at a section point. */
saltus_next saltus_measuring_follow(saltus_sweep_trajectory *trajectory, const saltus_event *event,
                                    bool *section);
/* Without forcing: an event on its way, a target reached included, after which the flow is at t->state. */
void saltus_sweep_trajectory_take(saltus_sweep_trajectory *trajectory, const saltus_event *event);
/* One more period. */
saltus_next saltus_measuring_add(saltus_sweep_trajectory *trajectory);

/* stages.c: what it goes through. */
/* Place it at its task's present place, in a lane of a flow that has been given its system, and aim it. False
 * when it cannot start: the row says so. */
bool saltus_sweep_trajectory_start(saltus_sweep_trajectory *trajectory, saltus_flow *flow, int lane);
/* What follows from an event of its lane; where it goes on, the lane has been aimed again. */
saltus_next saltus_sweep_trajectory_follow(saltus_sweep_trajectory *trajectory, const saltus_event *event);
/* There is no system, or no initial state, at its place: a row that has failed. */
void saltus_sweep_trajectory_refuse(saltus_sweep_trajectory *trajectory);
/* The flow gave up. */
void saltus_sweep_trajectory_fail(saltus_sweep_trajectory *trajectory);

#endif
