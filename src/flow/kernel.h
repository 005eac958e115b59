/* The stepping kernel: Taylor jets of one or several trajectories side by side.
 *
 * A jet holds the Taylor coefficients, in time, of displacements q, velocities v and extra states e of one
 * trajectory and of its tangent vectors (columns). The coefficients follow from the vector field order by
 * order (automatic differentiation; Jorba & Zou, Experimental Mathematics 14 (2005) 99-117), so the step's
 * polynomial is its dense output at the step's own accuracy, and events are located on it without another
 * evaluation of the field.
 *
 * The kernel is compiled once per model, instruction set and width. Width 1 puts the modes of one trajectory
 * into packs; the wide kernel puts one trajectory into each element of a pack. Every operation on an element
 * is the same in both, in the same order, so the results are equal bit for bit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_KERNEL_H
#define SALTUS_FLOW_KERNEL_H

#include "base/memory.h"
#include "base/simd.h"
#include "system/spectrum.h"
#include "system/system.h"

enum { SALTUS_LANES_MAX = SALTUS_PACK_MAX, SALTUS_QUIET_STEPS = 1000 };

typedef struct saltus_kernel saltus_kernel;

/* Tolerances of a step's error: relative to the state's norm, absolute in displacements, and relative to a
 * tangent vector's norm. */
typedef struct saltus_tolerance {
    double relative, absolute, tangent;
} saltus_tolerance;

/* Displacements, velocities and extra states of the trajectory (column 0) and of its tangent vectors. A row
 * holds one value per mode and lane, element i of lane l at i * lanes + l; the narrow kernel pads rows of q
 * and v to whole packs. States are [column][row], jets [order][column][row]. */
typedef struct saltus_state_rows {
    double *q, *v, *e;
} saltus_state_rows;

/* One number per lane. Every array has the length of the longest pack, so that all are aligned. */
typedef struct saltus_lane_numbers {
    /* of the lane's system */
    double period[SALTUS_LANES_MAX];     /* of the forcing */
    double degree[SALTUS_LANES_MAX];     /* of its series; at most the work's `order` */
    double limit[SALTUS_LANES_MAX];      /* largest step */
    double damped[SALTUS_LANES_MAX];     /* the same if the last two orders of its series are damped, ... */
    double last[SALTUS_LANES_MAX];       /* ... the last one by this factor ... */
    double before[SALTUS_LANES_MAX];     /* ... and the one before it by this one */
    double reach[SALTUS_LANES_MAX];      /* the one of these two limits that holds now */
    double omega_unit[SALTUS_LANES_MAX]; /* velocities divided by it compare with displacements */
    double clearance[SALTUS_FACES_MAX][SALTUS_LANES_MAX];
    /* of the point of expansion */
    double phase[SALTUS_LANES_MAX];   /* in [0,1) */
    double elapsed[SALTUS_LANES_MAX]; /* time since the step's begin */
    double left[SALTUS_LANES_MAX];    /* time left to the target; zero if the lane is not under way */
    /* of lanes that the kernel takes on by itself (quiet.h) */
    double quiet[SALTUS_LANES_MAX];  /* negative: the lane is one of them */
    double cycles[SALTUS_LANES_MAX]; /* to the target: whole periods from the present one, ... */
    double until[SALTUS_LANES_MAX];  /* ... and the phase in that period */
    double flight[SALTUS_LANES_MAX]; /* estimated time to the next impact, or infinite */
    double brief[SALTUS_LANES_MAX];  /* this near to either the lane is quiet no longer, ... */
    double taken[SALTUS_LANES_MAX];  /* ... nor after SALTUS_QUIET_STEPS such steps */
    double from[SALTUS_LANES_MAX];   /* phase at the last step's begin */
    /* of the step */
    double step[SALTUS_LANES_MAX];                     /* longest within the tolerance */
    double advance[SALTUS_LANES_MAX];                  /* where to evaluate */
    double passing[SALTUS_LANES_MAX];                  /* the planned `advance` in periods */
    double margin[SALTUS_FACES_MAX][SALTUS_LANES_MAX]; /* negative: the face surely stays open */
    double near[SALTUS_LANES_MAX];                     /* negative: all faces surely stay open */
    double turning[SALTUS_LANES_MAX]; /* negative: an observed velocity surely has no zero in the step */
} saltus_lane_numbers;

/* The loaded systems, in the kernel's layout. */
typedef struct saltus_loaded {
    unsigned terms;
    double *normal; /* [stop][row] */
    double *scalar; /* [scalar][lane] */
    double *rows;   /* [coefficient row][row] */
    double *coupling[SALTUS_COUPLINGS_MAX];
    double *table;                    /* model's constants per order: [table][order][lane] */
    const saltus_tape *tape;          /* of systems from text, otherwise NULL; equal in all lanes */
    double *weights;                  /* the tape's numbers: [weight][lane] */
    saltus_operation_function *value; /* evaluates the tape's functions */
} saltus_loaded;

/* Stops and sides, common to all lanes. */
typedef struct saltus_work_faces {
    int count;
    saltus_face face[SALTUS_FACES_MAX];
} saltus_work_faces;

/* Orders of the forcing's series that matter. */
typedef struct saltus_forcing_orders {
    int lane[SALTUS_LANES_MAX];
    int most;
} saltus_forcing_orders;

/* The model's intermediate series. */
typedef struct saltus_model_series {
    size_t drive_size;
    double *drive;  /* shared by all columns: [drive][order][lane] */
    double *ahead;  /* rows begun for the next order: [ahead][column][row] */
    double *series; /* the others: [series][column][order][lane] */
} saltus_model_series;

/* Contacts that hold. Slots beyond a lane's own contacts hold zeros. */
typedef struct saltus_holding {
    int count;
    double *push;  /* directions of contact impulses: [contact][row] */
    double *pull;  /* rows that give contact accelerations: [contact][row] */
    double *force; /* series of contact accelerations: [contact][order][lane] */
} saltus_holding;

/* For parameter columns: the derivatives of what a kernel loads along each direction (saltus_variation). */
typedef struct saltus_varied {
    int orders;      /* orders of the forcing's derivatives that matter */
    bool tilts;      /* contact projections depend on a direction */
    double *scalar;  /* [direction][scalar][lane] */
    double *rows;    /* [direction][coefficient row][row] */
    double *weights; /* [direction][weight][lane] */
    double *drive;   /* model's series: [direction][series][order][lane] */
    double *push;    /* [direction][contact][row] */
    double *pull;    /* [direction][contact][row] */
    double *force;   /* at the order being expanded: [direction][contact][lane] */
} saltus_varied;

/* All data of one kernel instance. */
typedef struct saltus_work {
    saltus_arena arena;
    /* Set when the work is opened. */
    int dof, extra, lanes, columns;
    int order;      /* of the longest series that fits */
    int directions; /* the last of the columns: parameter columns */
    int row;        /* doubles in a row of q or v */
    int order_span; /* orders reserved for table and drive: a whole number of packs */
    saltus_tolerance tolerance;
    /* Set when systems, directions and contacts are loaded. */
    int degree_least, degree_most; /* over the lanes */
    int stops;                     /* rows of the gap series */
    saltus_loaded loaded;
    saltus_forcing_orders forcing;
    saltus_work_faces faces;
    saltus_holding hold;
    saltus_varied vary;
    /* The step. */
    saltus_lane_numbers *lane;
    saltus_state_rows state; /* at the step's start (in) and at `advance` (out) */
    saltus_state_rows jet;
    double *gap; /* series of normal . q: [stop][order][lane] */
    saltus_model_series model;
} saltus_work;

struct saltus_kernel {
    const char *model;
    int lanes; /* 1 or the width of a pack */
    /* Compiler options of its instruction set. */
    const char *flags;
    /* Reserve all arrays in the work's arena; the sizes must be set. */
    void (*reserve)(saltus_work *work);
    /* Load a system's coefficients into a lane; its series will have `degree`, its steps at most `limit`. */
    void (*load)(saltus_work *work, int lane, const saltus_system *system, int degree,
                 saltus_damping damping);
    /* Load the derivative of a lane's coefficients along a direction. */
    void (*vary)(saltus_work *work, int lane, int direction, const saltus_variation *variation);
    /* States -> jets, gap and force series up to order `to`. `from` must be even: orders up to it are there
     * already; 0: none are. */
    void (*expand)(saltus_work *work, int from, int to);
    /* Jets of the lanes' degrees -> step of each lane. */
    void (*measure)(saltus_work *work);
    /* `step` and `left` -> `advance`, `passing`, `margin` and `near`: how far to go, and which lanes may meet
     * a stop. */
    void (*plan)(saltus_work *work);
    /* Let the planned step's time pass in quiet lanes that meet nothing in it: these, as bits, are returned,
     * and in *quiet those of them whose next step may be left to the kernel too. */
    unsigned (*pass)(saltus_work *work, unsigned *quiet);
    /* `measure`, `plan`, `pass` and, if all of `lanes` pass, `evaluate` in one, without the wait for numbers
     * that are stored and loaded again. */
    unsigned (*proceed)(saltus_work *work, unsigned lanes, unsigned *quiet);
    /* A row of the gap series and `advance` -> `turning`. */
    void (*bound_velocity)(saltus_work *work, int row);
    /* Jets of the lanes' degrees -> states at `advance`. */
    void (*evaluate)(saltus_work *work);
    /* The integral of the square of a lane's row of the gap series over `advance`; long steps of collocation
     * need more `pieces` than one. */
    double (*integrate_square)(const saltus_work *work, int row, int lane, int pieces);
};

/* The kernel for a model at width 1, or at this machine's SIMD width (lanes = 0), for the best instruction
 * set that was built and that the processor has. The environment variable SALTUS_ISA (x86-64, x86-64-v3,
 * x86-64-v4) can force a lower one. NULL if there is none. */
const saltus_kernel *saltus_kernel_find(const char *model, int lanes);
/* SALTUS_BAD_INPUT if SALTUS_ISA is set but names no instruction set. */
saltus_status saltus_kernel_check(saltus_message *message);

/* Allocate a work for a kernel, with series up to `order`; the last `directions` of the columns are parameter
 * columns. Sizes come from the system's shape. */
saltus_status saltus_work_open(saltus_work *work, const saltus_kernel *kernel, const saltus_system *system,
                               int order, int columns, int directions, saltus_tolerance tolerance);
/* Forget the loaded systems' terms and orders of the forcing, and the directions, before systems are loaded
 * anew. */
void saltus_work_forget(saltus_work *work);
/* Zero the states with their padding, so that nothing remains of a trajectory that has overflowed. */
void saltus_work_clear_states(saltus_work *work);
void saltus_work_close(saltus_work *work);

/* The place of element i of a column's row at one order of a jet; below, the same for extra states. A state
 * is like order 0. */
static inline size_t saltus_work_place(const saltus_work *work, int order, int column, int i, int lane) {
    return ((size_t)order * (size_t)(1 + work->columns) + (size_t)column) * (size_t)work->row +
           (size_t)(i * work->lanes + lane);
}

static inline size_t saltus_work_extra_place(const saltus_work *work, int order, int column, int i,
                                             int lane) {
    return (((size_t)order * (size_t)(1 + work->columns) + (size_t)column) * (size_t)work->extra +
            (size_t)i) *
               (size_t)work->lanes +
           (size_t)lane;
}

/* To be called when lanes' degrees have changed. */
static inline void saltus_work_settle_degrees(saltus_work *work) {
    double least = work->lane->degree[0], most = least;
    for (int l = 1; l < work->lanes; l++) {
        const double degree = work->lane->degree[l];
        least = degree < least ? degree : least;
        most = degree > most ? degree : most;
    }
    work->degree_least = (int)least;
    work->degree_most = (int)most;
}

/* The place of a coefficient in the gap series of a stop or in the force series of a contact. */
static inline size_t saltus_work_series_place(const saltus_work *work, int which, int order, int lane) {
    return ((size_t)which * (size_t)(work->order + 2) + (size_t)order) * (size_t)work->lanes + (size_t)lane;
}

#endif
