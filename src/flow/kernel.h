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
#include "system/system.h"

enum { SALTUS_LANES_MAX = SALTUS_PACK_MAX };

typedef struct saltus_kernel saltus_kernel;

/* Arrays of one kernel instance. `row` doubles hold one value per mode and lane: element i of lane l stands
 * at i * stride + l. Jets are [order][column][row], column 0 being the trajectory itself. */
typedef struct saltus_work {
    saltus_arena arena;
    int dof, extra, lanes, order, columns, stops, contacts;
    int directions; /* of the columns, the last ones: parameter columns */
    int row, extra_row, stride;
    unsigned terms;
    int lane_orders[SALTUS_LANES_MAX]; /* orders of the forcing's series that matter, per lane ... */
    int forcing_orders;                /* ... and the most of them */
    int faces, face_stop[SALTUS_FACES_MAX], face_side[SALTUS_FACES_MAX];
    double *omega_unit; /* per lane: frequency that makes velocities comparable with displacements */
    double tolerance_relative, tolerance_absolute, tolerance_tangent;
    double *q, *v, *e;    /* jets */
    double *xq, *xv, *xe; /* states at the step's start (in) and at `advance` (out): [column][row] */
    double *phase;        /* in [0,1), per lane */
    double *limit;        /* largest step of each lane */
    double *step;         /* step that keeps the tolerance, per lane */
    double *left;         /* time left to the target, per lane; zero where a lane rests */
    double *advance;      /* where to evaluate, per lane */
    double *period;       /* of the forcing, per lane */
    double *passing;      /* the planned `advance` in periods, per lane */
    double *clearance;    /* of each face: [face][lane] */
    double *margin;       /* negative where a face surely stays open until `advance`: [face][lane] */
    double *near;         /* the same for all faces at once, per lane */
    double *normal;       /* [stop][row] */
    double *gap;          /* series of normal . q: [stop][order][lane] */
    double *push;         /* directions of contact impulses: [contact][row] */
    double *pull;         /* rows that give contact accelerations: [contact][row] */
    double *force;        /* series of contact accelerations: [contact][order][lane] */
    double *scalar;       /* [scalar][lane] */
    double *rows;         /* [coefficient row][row] */
    double *coupling[SALTUS_COUPLINGS_MAX];
    size_t drive_size;
    int order_span; /* orders reserved for table and drive: a whole number of packs */
    double *table;  /* model's constants per order: [table][order][lane] */
    double *drive;  /* model's scalar series that all columns share: [drive][order][lane] */
    double *ahead;  /* model's rows begun for the next order: [ahead][column][row] */
    double *series; /* model's other scalar series: [series][column][order][lane] */
    /* For parameter columns: how what stands above changes along each direction (system.h, saltus_variation).
     */
    double *elapsed;     /* time since the step's begin at the point expanded from, per lane */
    double *vary_scalar; /* [direction][scalar][lane] */
    double *vary_rows;   /* [direction][coefficient row][row] */
    double *vary_drive;  /* model's series: [direction][series][order][lane] */
    double *vary_push;   /* [direction][contact][row] */
    double *vary_pull;   /* [direction][contact][row] */
    double *vary_force;  /* at the order being expanded: [direction][contact][lane] */
    int vary_orders;     /* orders of the forcing's derivatives that matter */
    bool tilts;          /* the projections at contacts change */
} saltus_work;

struct saltus_kernel {
    const char *model;
    int lanes; /* 1 or the width of a pack */
    int pack;
    /* Reserve all arrays in the work's arena; sizes are already set. */
    void (*reserve)(saltus_work *work);
    /* Put the coefficients of a system into a lane. */
    void (*load)(saltus_work *work, int lane, const saltus_system *system);
    /* Put the derivative of a lane's coefficients along a direction into place. */
    void (*vary)(saltus_work *work, int lane, int direction, const saltus_variation *variation);
    /* States -> jets up to `order`, gap and force series. */
    void (*expand)(saltus_work *work, int order);
    /* Jets of the work's full order -> step of each lane. */
    void (*measure)(saltus_work *work);
    /* Step and what is left -> `advance`, `passing`, margins and `near`: how far to go, and which lanes may
     * meet a stop. */
    void (*plan)(saltus_work *work);
    /* Jets -> states at `advance`. */
    void (*evaluate)(saltus_work *work, int order);
};

/* The kernel for a model at width 1 or at this machine's SIMD width (0), chosen from the instruction sets
 * built in and the processor at hand. The environment variable SALTUS_ISA (x86-64, x86-64-v3, x86-64-v4) can
 * force a lower one. NULL when there is none. */
const saltus_kernel *saltus_kernel_find(const char *model, int lanes);
/* Whether SALTUS_ISA, where it is set, names an instruction set. */
saltus_status saltus_kernel_check(saltus_message *message);

/* Allocate a work for a kernel, with `directions` parameter columns among the columns. Sizes come from the
 * systems' common shape. */
saltus_status saltus_work_open(saltus_work *work, const saltus_kernel *kernel, const saltus_system *system,
                               int order, int columns, int directions);
/* Forget which terms and orders of the forcing the loaded systems have, before they are loaded anew, and with
 * them the directions. */
void saltus_work_forget(saltus_work *work);
/* Zero the states, and with them what fills up packs: a trajectory that has overflowed leaves nothing behind.
 */
void saltus_work_clear_states(saltus_work *work);
void saltus_work_close(saltus_work *work);

static inline size_t saltus_work_jet(const saltus_work *work, int order, int column) {
    return ((size_t)order * (size_t)(1 + work->columns) + (size_t)column) * (size_t)work->row;
}

static inline size_t saltus_work_extra_jet(const saltus_work *work, int order, int column) {
    return ((size_t)order * (size_t)(1 + work->columns) + (size_t)column) * (size_t)work->extra_row;
}

#endif
