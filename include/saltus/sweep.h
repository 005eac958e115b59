/* Sweeps: many independent trajectories over grids of parameters and initial states.
 *
 * A sweep visits the points of a grid over one or two keys. At each point one or several trajectories (seeds)
 * run until they have settled, are classified, and are then recorded for some periods. The result of each is
 * one row of numbers and, on request, clouds of turning points, impacts or section points. Trajectories run
 * side by side in SIMD lanes on all cores; a lane that has finished takes the next trajectory at once. The
 * numbers are the same for any number of lanes, threads and processes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SWEEP_H
#define SALTUS_SWEEP_H

#include "saltus/motion.h"
#include "saltus/scene.h"

SALTUS_API_BEGIN

enum { SALTUS_AXES_MAX = 2, SALTUS_AXIS_KEY_MAX = 32 };

typedef enum saltus_spacing { SALTUS_LINEAR, SALTUS_LOGARITHMIC, SALTUS_LIST } saltus_spacing;

/* The values of one key, in the order in which passes up visit them. */
typedef struct saltus_axis {
    char key[SALTUS_AXIS_KEY_MAX]; /* as in --set: a parameter, d, r, xi (d1, ...), or an entry of the initial
                                      state */
    saltus_spacing spacing;
    int count;          /* >= 1 */
    double low, high;   /* first and last value, of a list too */
    const double *list; /* SALTUS_LIST: `count` values owned by the caller; otherwise NULL */
} saltus_axis;

/* The k-th value, 0 <= k < count; both ends are exact. */
double saltus_axis_value(const saltus_axis *axis, int k);
/* Read "key=low:high:count", "key=low:high:count:log" or "key=v1,v2,...". For a list *list is allocated and
 * must be freed by the caller (NULL for a grid). Errors: SALTUS_BAD_INPUT with the text and what would be
 * right, SALTUS_NO_MEMORY. */
saltus_status saltus_axis_read(const char *text, saltus_axis *axis, double **list, saltus_message *message);

/* How trajectories start. A pass is one visit of the whole grid. */
typedef enum saltus_pass {
    SALTUS_PASS_RESET, /* each point from the initial state of its seed */
    SALTUS_PASS_UP,    /* along the first axis, each point from the final state of the one before */
    SALTUS_PASS_DOWN,  /* the same in the reverse order of the first axis */
    SALTUS_PASSES
} saltus_pass;

/* Results kept in addition to the standard rows, as bits. */
enum {
    SALTUS_KEEP_TURNING = 1,      /* observed displacement where its velocity reverses, impacts included */
    SALTUS_KEEP_IMPACTS = 2,      /* phase, speed and face of each impact */
    SALTUS_KEEP_STROBOSCOPIC = 4, /* the state at phase 0 */
    SALTUS_KEEP_LYAPUNOV = 8      /* in the row: the largest exponent, with a verdict on motions without a
                                     period */
};

typedef struct saltus_sweep_options {
    saltus_flow_options flow; /* columns and directions are set by the sweep; `stop` ends a run with the
                                 results taken so far; default rtol is 1e-10 and atol 1e-14 */
    unsigned keep;            /* bits SALTUS_KEEP_...; default 0 */
    unsigned passes;          /* bits 1 << saltus_pass; default SALTUS_PASS_RESET alone */
    int seeds; /* initial states per point: the first is the scene's own, the others are random; default 1 */
    unsigned long seed; /* default 0 */
    /* Adaptive: recording begins as soon as the least period is certain and the distance from the orbit is at
     * most the larger of 1e-10 and 10 flow.rtol, relative to the system's scales. It covers one orbit; if no
     * period is certain after `transient` periods, `record` periods. Not adaptive: `transient` periods are
     * run and `record` periods recorded, whatever the motion; towards the end of a long transient, and
     * otherwise after the record, a small disturbance proves that an orbit is stable. */
    bool adaptive;               /* default true */
    long long transient, record; /* default 2000 and 100 */
    long long measure;  /* with SALTUS_KEEP_LYAPUNOV: most periods for measuring the exponent of a motion
                           without a period; 0: none; default 32000 */
    long long lifetime; /* periods; chaos is asserted only if its mean lifetime is at least this with 95 %
                           confidence, which needs three times as many measured periods; otherwise the row is
                           irregular; default 10000 */
    int longest;        /* longest period looked for, 1 to 256; default 20 */
    int lanes;          /* at most; 0: as many as the processor has; default 0 */
    int threads;        /* at most; 0: as many as there are cores; default 0 */
} saltus_sweep_options;

/* The defaults stated beside the options. */
saltus_sweep_options saltus_sweep_defaults(void);

/* A scene, axes and options, checked together. Running does not change it. */
typedef struct saltus_sweep saltus_sweep;

/* Lists of the axes are copied. Errors: SALTUS_BAD_INPUT (key unknown to the scene or integer-valued, values
 * out of range, ...), SALTUS_NO_MEMORY. */
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
/* Number of grid points, the product of the axes' counts; the first axis varies fastest. */
long long saltus_sweep_points(const saltus_sweep *sweep);
/* Number of passes, and the k-th of them. */
int saltus_sweep_pass_count(const saltus_sweep *sweep);
saltus_pass saltus_sweep_pass_at(const saltus_sweep *sweep, int k);
/* "reset", "up" or "down". */
const char *saltus_pass_word(saltus_pass pass);
/* Rows of the whole sweep: pass_count x points x seeds. Row ((k * points) + point) * seeds + seed belongs to
 * the k-th pass. */
long long saltus_sweep_rows(const saltus_sweep *sweep);
/* The scene with the grid's values at a point. */
saltus_status saltus_sweep_scene_at(const saltus_sweep *sweep, long long point, saltus_scene *scene,
                                    saltus_message *message);

/* The results of one trajectory. Measured values refer to once around the orbit of a periodic motion, and
 * otherwise to the recorded periods. */
typedef struct saltus_sweep_row {
    int verdict;   /* saltus_verdict; motions without a period are irregular unless SALTUS_KEEP_LYAPUNOV is
                      set */
    int impacts;   /* periodic: n per orbit, -1 with complete chatter; otherwise 0 */
    int periods;   /* periodic: p, forcing periods or returns to the section */
    int sticking;  /* periodic: sticking intervals per orbit */
    int attractor; /* index among the distinct attractors met at this point in this pass, numbered from 0 in
                      order of seeds; all chaotic motions of a point count as one, and so do all
                      quasi-periodic, all unsettled and all undecided ones; -1: failed */
    long long settled;         /* periods until the verdict; without forcing in units of time */
    long long settled_impacts; /* impacts until the verdict */
    long long recorded;        /* periods recorded; without forcing returns to the section, here and below */
    double largest, smallest;  /* observed displacement; NAN where nothing was recorded */
    double rms;                /* root mean square of the observed displacement */
    double impact_rate;        /* impacts simulated one by one, per forcing period */
    double largest_speed;      /* largest impact speed; 0 without impacts */
    double contact_fraction;   /* fraction of the time in contact */
    double lyapunov; /* largest exponent per unit of time; NAN if not requested, -INFINITY if all directions
                        are lost */
    double lyapunov_error;    /* standard error; 0 if the exponent comes from an orbit's multipliers */
    double lifetime_at_least; /* lower bound of the mean lifetime of chaos, in periods, with 95 % confidence;
                                 NAN unless a positive exponent was measured */
    double period;            /* periodic: period of the orbit in units of time; otherwise NAN */
} saltus_sweep_row;

/* A row with nothing but a verdict: attractor -1, numbers NAN. */
saltus_sweep_row saltus_sweep_row_of(saltus_verdict verdict);
/* "4/4", "chatter/2", "held", "chaotic", ... as in saltus_motion. */
void saltus_sweep_label(const saltus_sweep_row *row, char label[SALTUS_LABEL_MAX]);

typedef struct saltus_sweep_impact {
    double phase; /* in [0, 1) */
    double speed; /* n.q' before the impact, with the sign of saltus_event */
    int face;
} saltus_sweep_impact;

/* All seeds at one point in one pass, passed on as soon as they are finished. */
typedef struct saltus_sweep_result {
    long long place; /* pass_index * points + point; its rows begin at place * seeds */
    const saltus_sweep_row *rows;
    const double *states; /* seeds x dimension: final states, at phase 0 */
    /* Clouds: entries of all seeds, one seed after the other. */
    const long long *turning_counts, *impact_counts, *strobe_counts; /* entries per seed */
    const double *turning;
    const saltus_sweep_impact *impacts;
    const double *strobes; /* dimension numbers for each entry */
} saltus_sweep_result;

/* The caller's source of work and receiver of results. Tasks are numbered 0 ... saltus_sweep_tasks - 1: a
 * task is one point of a reset pass, or a whole line along the first axis of a pass up or down. The functions
 * are called by one thread at a time. */
typedef struct saltus_sweep_feed {
    void *context;
    /* The next task, or -1 when there is none; NULL: each task once, in order. */
    long long (*next)(void *context);
    /* Receive a result. Any status other than SALTUS_OK ends the run with that status. */
    saltus_status (*take)(void *context, const saltus_sweep_result *result, saltus_message *message);
    /* Called when all results of a task have been taken; may be NULL. */
    void (*done)(void *context, long long task);
} saltus_sweep_feed;

/* The number of tasks: the points of each pass that starts anew, and the lines along the first axis of the
 * others. */
long long saltus_sweep_tasks(const saltus_sweep *sweep);
/* A task has saltus_sweep_task_length places; the k-th one is saltus_sweep_task_place. */
int saltus_sweep_task_length(const saltus_sweep *sweep, long long task);
long long saltus_sweep_task_place(const saltus_sweep *sweep, long long task, int k);
/* Run tasks until none is left or options.flow.stop asks to stop. Progress shows in the results that the feed
 * receives. Failed trajectories become rows with the verdict SALTUS_FAILED. Errors: what `take` returned,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_sweep_run(const saltus_sweep *sweep, const saltus_sweep_feed *feed,
                               saltus_message *message);

/* Compute one row again, 0 <= number < saltus_sweep_rows: `state` receives the trajectory's final state, at
 * phase 0, which lies on the row's motion. In a pass up or down the line is computed up to it. Errors:
 * SALTUS_INTERRUPTED if options.flow.stop asks to stop, SALTUS_NO_MEMORY. */
saltus_status saltus_sweep_row_again(const saltus_sweep *sweep, long long number, saltus_sweep_row *row,
                                     double *state, saltus_message *message);

/* A result as one block of bytes, for files and for messages between processes on machines of the same
 * kind. */
size_t saltus_sweep_packed_size(const saltus_sweep *sweep, const saltus_sweep_result *result);
void saltus_sweep_pack(const saltus_sweep *sweep, const saltus_sweep_result *result, void *bytes);
/* The result's arrays point into `bytes`, which must be aligned as for a double. False if the block does not
 * fit the sweep. */
bool saltus_sweep_unpack(const saltus_sweep *sweep, const void *bytes, size_t size,
                         saltus_sweep_result *result);

/* Collects the attractors over a whole plane of initial states. */
typedef struct saltus_basins saltus_basins;

/* The sweep's axes must be entries of the initial state. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_basins_new(const saltus_sweep *sweep, saltus_basins **basins, saltus_message *message);
void saltus_basins_free(saltus_basins *basins);
/* The attractor of a settled row, numbered in the order of first occurrence. The row's state is compared with
 * the known orbits; if it is on none of them its orbit is found by Newton's method. -1: undecided or
 * failed. */
saltus_status saltus_basins_sort(saltus_basins *basins, const saltus_sweep_row *row, const double *state,
                                 int *attractor, saltus_message *message);
int saltus_basins_count(const saltus_basins *basins);
const saltus_motion *saltus_basins_motion(const saltus_basins *basins, int attractor);

SALTUS_API_END
#endif
