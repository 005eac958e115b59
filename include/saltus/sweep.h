/* Sweeps: many independent trajectories over grids of parameters and initial states.
 *
 * A sweep visits the points of a grid of one or two keys. At each point one or several trajectories (seeds)
 * run until they have settled, are classified, and are recorded for some periods; what is kept of each is one
 * row of numbers and, where asked for, clouds of turning points, impacts or section points. Trajectories run
 * side by side in SIMD lanes on all cores; a lane that is done takes the next trajectory at once. Every
 * number is the same for any number of lanes, threads and processes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SWEEP_H
#define SALTUS_SWEEP_H

#include "saltus/motion.h"
#include "saltus/scene.h"

SALTUS_API_BEGIN

enum { SALTUS_AXES_MAX = 2, SALTUS_AXIS_KEY_MAX = 32 };

typedef enum saltus_spacing { SALTUS_LINEAR, SALTUS_LOGARITHMIC, SALTUS_LIST } saltus_spacing;

/* The values that one key takes, in the order in which `carry` follows them. */
typedef struct saltus_axis {
    char key[SALTUS_AXIS_KEY_MAX]; /* as in --set: a parameter, d, r, xi (d1, ...), or an entry of the initial
                                      state */
    saltus_spacing spacing;
    int count;          /* >= 1 */
    double low, high;   /* first and last value; of a list its first and last entry */
    const double *list; /* SALTUS_LIST: count values, the caller's; otherwise NULL */
} saltus_axis;

/* The k-th value, 0 <= k < count; both ends are exact. */
double saltus_axis_value(const saltus_axis *axis, int k);
/* Read "key=low:high:count", "key=low:high:count:log" or "key=v1,v2,...". A list is allocated: *list is to be
 * freed by the caller (NULL for a grid). Errors: SALTUS_BAD_INPUT with the text and what would be right,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_axis_read(const char *text, saltus_axis *axis, double **list, saltus_message *message);

/* How trajectories start. A pass is one visit of the whole grid. */
typedef enum saltus_pass {
    SALTUS_PASS_RESET, /* every point from the initial state of its seed */
    SALTUS_PASS_UP,    /* along the first axis, each point from the end of the one before it */
    SALTUS_PASS_DOWN,  /* the same against the order of the first axis */
    SALTUS_PASSES
} saltus_pass;

/* What is kept beside the rows. */
enum {
    SALTUS_KEEP_TURNING = 1,      /* observed displacement where its velocity reverses, impacts included */
    SALTUS_KEEP_IMPACTS = 2,      /* phase, speed and face of each impact */
    SALTUS_KEEP_STROBOSCOPIC = 4, /* the state at phase 0 */
    SALTUS_KEEP_LYAPUNOV = 8 /* the largest exponent, in the row, and with it a verdict on motions without
                                a period */
};

typedef struct saltus_sweep_options {
    saltus_flow_options flow; /* columns and directions are the sweep's own business; `stop` ends a run
                                 with what has been taken so far; rtol is 1e-10 and atol 1e-14 by default */
    unsigned keep;            /* bits of what a row holds (SALTUS_KEEP_...); default 0 */
    unsigned passes;          /* bits 1 << saltus_pass; default SALTUS_PASS_RESET alone */
    int seeds; /* initial states per point; the first is the scene's own, the others are random; default 1 */
    unsigned long seed; /* default 0 */
    /* Adaptive: a trajectory is recorded as soon as its least period is certain and the orbit is no farther
     * away than the larger of 1e-10 and 10 flow.rtol, relative to the system's scales; over one orbit, or
     * where none is certain after `transient` periods, over `record` of them. Otherwise `transient` periods
     * are run and `record` recorded whatever the motion. */
    bool adaptive;               /* default true */
    long long transient, record; /* default 2000 and 100 */
    long long measure;  /* with SALTUS_KEEP_LYAPUNOV: periods at most over which the exponent of a motion
                           without a period is measured; 0: not at all; default 32000 */
    long long lifetime; /* periods: chaos is asserted where its mean lifetime is at least this, with 95 %
                           confidence; three times as many must be measured, or the row is irregular; default
                           10000 */
    int longest;        /* longest period looked for, 1 to 256; default 20 */
    int lanes;          /* at most; 0: as many as the processor has; default 0 */
    int threads;        /* at most; 0: as many as there are cores; default 0 */
} saltus_sweep_options;

/* As told beside the options. */
saltus_sweep_options saltus_sweep_defaults(void);

/* A sweep is made of a scene, its axes and its options, checked together; it is not changed by running. */
typedef struct saltus_sweep saltus_sweep;

/* The lists of the axes are copied. Errors: SALTUS_BAD_INPUT (a key that the scene does not have or that is a
 * whole number, values outside their range, ...), SALTUS_NO_MEMORY. */
saltus_status saltus_sweep_new(const saltus_scene *scene, const saltus_axis *axes, int axis_count,
                               const saltus_sweep_options *options, saltus_sweep **sweep,
                               saltus_message *message);
/* NULL is accepted. */
void saltus_sweep_free(saltus_sweep *sweep);
const saltus_scene *saltus_sweep_scene(const saltus_sweep *sweep);
int saltus_sweep_axis_count(const saltus_sweep *sweep);
const saltus_axis *saltus_sweep_axis(const saltus_sweep *sweep, int axis);
const saltus_sweep_options *saltus_sweep_choices(const saltus_sweep *sweep);
/* Length of a state vector, the same at all points. */
int saltus_sweep_dimension(const saltus_sweep *sweep);
/* Points of the grid: the product of the axes' counts; the first axis runs fastest. */
long long saltus_sweep_points(const saltus_sweep *sweep);
/* Number of passes, and the k-th of them. */
int saltus_sweep_pass_count(const saltus_sweep *sweep);
saltus_pass saltus_sweep_pass_at(const saltus_sweep *sweep, int k);
/* "reset", "up" or "down". */
const char *saltus_pass_word(saltus_pass pass);
/* Rows of the whole sweep: pass_count x points x seeds. Row ((k * points) + point) * seeds + seed belongs to
 * the k-th pass. */
long long saltus_sweep_rows(const saltus_sweep *sweep);
/* The scene at a point: its parameters are those of the grid. */
saltus_status saltus_sweep_scene_at(const saltus_sweep *sweep, long long point, saltus_scene *scene,
                                    saltus_message *message);

/* What is told of one trajectory. Measures are of the recorded periods. */
typedef struct saltus_sweep_row {
    int verdict;   /* saltus_verdict; quasi-periodic, chaotic, transient, long-period and undecided only with
                      SALTUS_KEEP_LYAPUNOV: a motion without a period is irregular otherwise */
    int impacts;   /* periodic: n per orbit, -1 where complete chatter makes it infinite; otherwise 0 */
    int periods;   /* periodic: p, forcing periods or returns to the section */
    int sticking;  /* periodic: sticking intervals per orbit */
    int attractor; /* which of the distinct attractors met at this point in this pass, from 0 by seeds; all
                      chaotic motions of a point count as one, and so do all quasi-periodic, all unsettled
                      and all undecided ones; -1: failed */
    long long settled;         /* periods until the verdict; without forcing units of time */
    long long settled_impacts; /* impacts on the way */
    long long recorded;        /* periods recorded; here and below returns to the section without forcing */
    double largest, smallest;  /* observed displacement; NAN where nothing was recorded */
    double rms;                /* its root mean square */
    double impact_rate;        /* impacts per forcing period, those simulated one by one */
    double largest_speed;      /* of an impact; 0 without any */
    double contact_fraction;   /* part of the time in contact */
    double lyapunov;       /* largest exponent per unit of time; NAN where not asked for, -INFINITY where all
                              directions are lost */
    double lyapunov_error; /* its standard error; 0 where an orbit's multipliers give it */
    double lifetime_at_least; /* of chaos, in periods, with 95 % confidence; NAN where no positive exponent
                                 was measured */
    double period;            /* periodic: of the orbit, in units of time; otherwise NAN */
} saltus_sweep_row;

/* A row of which nothing but the verdict is known: no attractor, numbers NAN. */
saltus_sweep_row saltus_sweep_row_of(saltus_verdict verdict);
/* "4/4", "chatter/2", "held", "chaotic", ... as in saltus_motion. */
void saltus_sweep_label(const saltus_sweep_row *row, char label[SALTUS_LABEL_MAX]);

typedef struct saltus_sweep_impact {
    double phase; /* in [0, 1) */
    double speed; /* n.q' before, signed as in saltus_event */
    int face;
} saltus_sweep_impact;

/* All seeds at one point of one pass, handed out as soon as they are done. */
typedef struct saltus_sweep_result {
    long long place; /* pass_index * points + point; its rows are place * seeds ... */
    const saltus_sweep_row *rows;
    const double *states; /* seeds x dimension: at phase 0 at the end */
    /* Clouds, one seed after the other. */
    const long long *turning_counts, *impact_counts, *strobe_counts; /* per seed */
    const double *turning;
    const saltus_sweep_impact *impacts;
    const double *strobes; /* x dimension */
} saltus_sweep_result;

/* Where work comes from and goes to. Tasks are numbered 0 ... saltus_sweep_tasks - 1: a task is a point of a
 * reset pass, or a whole line along the first axis of a pass up or down. Both functions are called by one
 * thread at a time. */
typedef struct saltus_sweep_feed {
    void *context;
    /* The next task, or -1 when there is none. */
    long long (*next)(void *context);
    /* Take a result. Returning another status than SALTUS_OK ends the run with it. */
    saltus_status (*take)(void *context, const saltus_sweep_result *result, saltus_message *message);
    /* A task's results have all been taken; may be NULL. */
    void (*done)(void *context, long long task);
} saltus_sweep_feed;

long long saltus_sweep_tasks(const saltus_sweep *sweep);
/* The places of a task: `count` of them, the k-th being the result of saltus_sweep_task_place. */
int saltus_sweep_task_length(const saltus_sweep *sweep, long long task);
long long saltus_sweep_task_place(const saltus_sweep *sweep, long long task, int k);
/* Run tasks until there are none, or options.flow.stop says so; the feed hears of each result, which tells
 * how far it is. Trajectories that fail become rows that say so. Errors: what `take` returned,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_sweep_run(const saltus_sweep *sweep, const saltus_sweep_feed *feed,
                               saltus_message *message);

/* A result as one block of bytes, for files and messages between processes of one kind of machine. */
size_t saltus_sweep_packed_size(const saltus_sweep *sweep, const saltus_sweep_result *result);
void saltus_sweep_pack(const saltus_sweep *sweep, const saltus_sweep_result *result, void *bytes);
/* The result's arrays point into `bytes`, which must be aligned as for a double. False when the block does
 * not fit the sweep. */
bool saltus_sweep_unpack(const saltus_sweep *sweep, const void *bytes, size_t size,
                         saltus_sweep_result *result);

/* Attractors over a whole plane of initial states. */
typedef struct saltus_basins saltus_basins;

/* The sweep's axes must be entries of the initial state. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_basins_new(const saltus_sweep *sweep, saltus_basins **basins, saltus_message *message);
void saltus_basins_free(saltus_basins *basins);
/* Which attractor a settled row belongs to, in the order of first calls: the orbit of the row's state is
 * compared with the orbits known, and found by Newton's method where it is none of them. -1: undecided or
 * failed. */
saltus_status saltus_basins_sort(saltus_basins *basins, const saltus_sweep_row *row, const double *state,
                                 int *attractor, saltus_message *message);
int saltus_basins_count(const saltus_basins *basins);
const saltus_motion *saltus_basins_motion(const saltus_basins *basins, int attractor);

SALTUS_API_END
#endif
