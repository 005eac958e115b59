/* Step control of the stiff integrator.
 *
 * The unknowns of a step are the accelerations at the nodes. One sweep evaluates the field at all nodes side
 * by side and corrects the accelerations by what the linear part, taken at rest and at the phase of the
 * step's middle, makes of the residual (collocation.h). What is left over is the cubic term and the change of
 * the pulsation within the step: mild couplings, whose error falls like (h L)^k / k! with the number of
 * sweeps. The sweeps end in the collocation solution whatever the linear part was.
 *
 * Dense output is the polynomial of degree 15 through the accelerations, integrated twice exactly. Its last
 * Legendre coefficients tell how well it represents the solution inside the step, where events are located on
 * it; the values at the step's end are far more accurate (order 31). After an impact every mode of the pipe
 * has a boundary layer of its own length; the first step follows from the rates and sizes of these layers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/radau.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { nodes = SALTUS_RADAU_NODES, bins = 8, slots_max = 256, sweeps_max = 40, attempts_max = 60 };

struct saltus_radau {
    saltus_arena arena;
    const saltus_system *system;
    const saltus_kernel *field;
    const saltus_collocation_kernel *kernel;
    saltus_collocation *method;
    saltus_stages stages;
    saltus_work work[SALTUS_RADAU_CHUNKS_MAX];
    int all, extra, rows; /* columns with the trajectory; rows of 16 in the arrays below */
    int steady;           /* columns with the trajectory but without parameter columns */
    double omega_unit, shortest, tolerance_tangent;
    double *a;  /* node values: accelerations [column][mode][16], then rates of extra states */
    double *e0; /* extra states at the start: [column][extra] */
    double *e;  /* their node values: [column][extra][16] */
    double *legendre, *last, *powers; /* coefficients: of this step, of the guess, of powers */
    double *extrapolation;            /* 16 x 16 */
    double *damp, *stiff;             /* the field's linear part at rest: [bin of the phase][mode][mode] */
    double *factors;                  /* [slot][mode][mode][16] */
    int slots, held[slots_max];       /* which factors a slot holds: key, from 1 */
    int order[SALTUS_MODES_MAX];
    double *tolerance;  /* [column], in units of displacement */
    double *unit;       /* [column]: rounding */
    double *size;       /* [column]: at the step's start */
    double proposal;    /* step to try; 0 after a reset */
    int steps, bounces; /* since the last impact; impacts since the reset */
    bool follows;       /* `last` holds a polynomial that goes on: its step, its start */
    double last_step, last_phase;
};

/* The larger; a NaN wins. */
static inline double larger(double a, double b) {
    return a >= b || isnan(a) ? a : b;
}

static void reserve(saltus_radau *r, int columns) {
    saltus_arena *arena = &r->arena;
    saltus_stages *s = &r->stages;
    size_t n = (size_t)s->dof, all = (size_t)columns + 1, rows = (size_t)r->rows * nodes;
    size_t faces = (size_t)r->system->face_count;
    r->method = (saltus_collocation *)(void *)saltus_arena_doubles(arena, sizeof *r->method / sizeof(double));
    s->method = r->method;
    r->a = s->a = saltus_arena_doubles(arena, rows);
    r->legendre = saltus_arena_doubles(arena, rows);
    r->last = saltus_arena_doubles(arena, rows);
    r->powers = saltus_arena_doubles(arena, rows);
    r->e0 = saltus_arena_doubles(arena, all * (size_t)r->extra);
    r->e = saltus_arena_doubles(arena, all * (size_t)r->extra * nodes);
    r->extrapolation = saltus_arena_doubles(arena, nodes * nodes);
    r->tolerance = saltus_arena_doubles(arena, all);
    r->unit = saltus_arena_doubles(arena, all);
    r->size = saltus_arena_doubles(arena, all);
    s->q0 = saltus_arena_doubles(arena, all * n);
    s->v0 = saltus_arena_doubles(arena, all * n);
    s->hat = saltus_arena_doubles(arena, n * nodes);
    r->damp = saltus_arena_doubles(arena, bins * n * n);
    r->stiff = saltus_arena_doubles(arena, bins * n * n);

    r->factors = saltus_arena_doubles(arena, (size_t)r->slots * n * n * nodes);

    s->push = saltus_arena_doubles(arena, faces * n);
    s->pull = saltus_arena_doubles(arena, faces * n);
    s->reply = saltus_arena_doubles(arena, faces * n * nodes);
    s->schur = saltus_arena_doubles(arena, faces * faces * nodes);
    s->change = saltus_arena_doubles(arena, all * 2);
}

/* The field at rest but for one displacement or velocity of the trajectory, in all bins of the phase side by
 * side. */
static void expand_bins(saltus_radau *r, int mode, double displacement, double velocity) {
    for (int k = 0; k < r->stages.chunks; k++) {
        saltus_work *w = &r->work[k];
        for (int l = 0; l < w->lanes; l++) {
            w->phase[l] = ((k * w->lanes + l) % bins + 0.5) / bins;
            w->xq[mode * w->lanes + l] = displacement;
            w->xv[mode * w->lanes + l] = velocity;
        }
        r->field->expand(w, 1);
        for (int l = 0; l < w->lanes; l++)
            w->xq[mode * w->lanes + l] = w->xv[mode * w->lanes + l] = 0;
    }
}

/* What expand_bins left, for one bin and mode. */
static double bin_value(const saltus_radau *r, int bin, int mode) {
    int lanes = r->stages.lanes;
    return r->stages.field[bin / lanes][mode * lanes + bin % lanes];
}

/* The linear part by differences from rest; it only steers the iteration. */
static void find_linear_part(saltus_radau *r) {
    int n = r->stages.dof;
    double *rest = r->factors;
    for (int k = 0; k < r->stages.chunks; k++) {
        saltus_work *w = &r->work[k];
        size_t row = (size_t)w->row, extra = (size_t)w->extra_row;
        memset(w->xq, 0, (size_t)r->all * row * sizeof(double));
        memset(w->xv, 0, (size_t)r->all * row * sizeof(double));
        memset(w->xe, 0, (size_t)r->all * extra * sizeof(double));
        w->contacts = 0;
    }
    expand_bins(r, 0, 0, 0);
    for (int b = 0; b < bins; b++)
        for (int i = 0; i < n; i++)
            rest[b * n + i] = bin_value(r, b, i);
    for (int j = 0; j < n; j++) {
        double small = 1e-5 * r->system->scale[j];
        expand_bins(r, j, 0, 1);
        for (int b = 0; b < bins; b++)
            for (int i = 0; i < n; i++)
                r->damp[(b * n + i) * n + j] = bin_value(r, b, i) - rest[b * n + i];
        expand_bins(r, j, small, 0);
        for (int b = 0; b < bins; b++)
            for (int i = 0; i < n; i++)
                r->stiff[(b * n + i) * n + j] = (bin_value(r, b, i) - rest[b * n + i]) / small;
    }
}

/* Modes that couple to those of the other parity only are eliminated parity by parity, which saves half the
 * work. */
static void order_modes(saltus_radau *r) {
    int n = r->stages.dof, place = 0;
    bool alternate = true;
    for (int b = 0; b < bins; b++)
        for (int i = 0; i < n; i++)
            for (int j = i % 2; j < n; j += 2)
                if (i != j)
                    alternate &= r->damp[(b * n + i) * n + j] == 0 && r->stiff[(b * n + i) * n + j] == 0;
    for (int parity = 0; parity < 2; parity++)
        for (int i = parity; i < n; i += 2)
            r->order[place++] = i;
    r->stages.order = r->order;
    r->stages.uncoupled = alternate ? (n + 1) / 2 : 0;
}

static saltus_status open_works(saltus_radau *r, int columns, int directions) {
    saltus_stages *s = &r->stages;
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < s->chunks && status == SALTUS_OK; k++) {
        saltus_work *w = &r->work[k];
        status = saltus_work_open(w, r->field, r->system, 1, columns, directions);
        if (status != SALTUS_OK)
            break;
        s->row = (size_t)w->row;
        s->q[k] = w->xq;
        s->v[k] = w->xv;
        s->field[k] = w->v + saltus_work_jet(w, 1, 0);
    }
    return status;
}

/* As many sets of factors as fit into 8 MiB, within limits. */
static int count_slots(int dof) {
    int slots = (1 << 20) / (dof * dof * nodes);
    return slots < 16 ? 16 : slots > slots_max ? slots_max : slots;
}

void saltus_radau_retune(saltus_radau *radau, const saltus_system *system) {
    radau->system = system;
    radau->omega_unit = system->scale[system->dof] / system->scale[0];
    radau->shortest = 1e-4 / system->rate;
    for (int k = 0; k < radau->stages.chunks; k++) {
        saltus_work *w = &radau->work[k];
        saltus_work_forget(w);
        for (int l = 0; l < w->lanes; l++)
            radau->field->load(w, l, system);
        w->stops = 0;
    }
    find_linear_part(radau);
    order_modes(radau);
    memset(radau->held, 0, sizeof radau->held);
    saltus_radau_reset(radau);
}

void saltus_radau_vary(saltus_radau *radau, int direction, const saltus_variation *variation) {
    for (int k = 0; k < radau->stages.chunks; k++)
        for (int l = 0; l < radau->work[k].lanes; l++)
            radau->field->vary(&radau->work[k], l, direction, variation);
}

saltus_status saltus_radau_open(saltus_radau **radau, const saltus_system *system, int columns,
                                int directions, const saltus_work *tolerances) {
    *radau = NULL;
    const saltus_kernel *field = saltus_kernel_find(system->spec.model->name, 0);
    saltus_radau *r = calloc(1, sizeof *r);
    if (!r || !field) {
        free(r);
        return r ? SALTUS_STALLED : SALTUS_NO_MEMORY;
    }
    r->system = system;
    r->field = field;
    r->kernel = saltus_collocation_find(field->lanes);
    r->all = columns + 1;
    r->extra = system->extra;
    r->rows = r->all * (system->dof + system->extra);
    r->steady = r->all - directions;
    r->tolerance_tangent = tolerances->tolerance_tangent;
    r->stages = (saltus_stages){
        .dof = system->dof, .columns = columns, .lanes = field->lanes, .chunks = nodes / field->lanes};
    r->slots = count_slots(system->dof);
    reserve(r, columns);
    saltus_status status = saltus_arena_open(&r->arena) ? SALTUS_OK : SALTUS_NO_MEMORY;
    if (status == SALTUS_OK) {
        reserve(r, columns);
        status = open_works(r, columns, directions);
    }
    if (status == SALTUS_OK && !saltus_collocation_build(r->method))
        status = SALTUS_STALLED;
    if (status != SALTUS_OK) {
        saltus_radau_close(r);
        return status;
    }
    saltus_radau_retune(r, system);
    *radau = r;
    return SALTUS_OK;
}

void saltus_radau_close(saltus_radau *radau) {
    if (!radau)
        return;
    for (int k = 0; k < radau->stages.chunks; k++)
        saltus_work_close(&radau->work[k]);
    saltus_arena_close(&radau->arena);
    free(radau);
}

void saltus_radau_reset(saltus_radau *radau) {
    radau->proposal = 0;
    radau->follows = false;
    radau->bounces = radau->steps = 0;
}

void saltus_radau_impact(saltus_radau *radau) {
    radau->proposal = 0;
    radau->follows = false;
    radau->bounces++;
}

/* Rows of the flow's work into all lanes of one of the stages'. */
static void spread_rows(const saltus_work *work, const double *from, const saltus_work *w, double *to,
                        int rows) {
    for (int m = 0; m < rows; m++)
        for (int i = 0; i < w->dof; i++)
            for (int l = 0; l < w->lanes; l++)
                to[m * w->row + i * w->stride + l] = from[m * work->row + i * work->stride];
}

void saltus_radau_publish(saltus_radau *radau, const saltus_work *work) {
    saltus_stages *s = &radau->stages;
    int contacts = work->contacts, varied = work->tilts ? work->directions * contacts : 0;
    s->contacts = contacts;
    for (int m = 0; m < contacts; m++)
        for (int i = 0; i < s->dof; i++) {
            s->push[m * s->dof + i] = work->push[m * work->row + i * work->stride];
            s->pull[m * s->dof + i] = work->pull[m * work->row + i * work->stride];
        }
    for (int k = 0; k < s->chunks; k++) {
        saltus_work *w = &radau->work[k];
        w->contacts = contacts;
        spread_rows(work, work->push, w, w->push, contacts);
        spread_rows(work, work->pull, w, w->pull, contacts);
        spread_rows(work, work->vary_push, w, w->vary_push, varied);
        spread_rows(work, work->vary_pull, w, w->vary_pull, varied);
    }
}

/* The start of a step from the flow's work, and the tolerances there. */
static void take_start(saltus_radau *r, const saltus_work *work) {
    saltus_stages *s = &r->stages;
    for (int c = 0; c < r->all; c++) {
        double size = 0;
        for (int i = 0; i < s->dof; i++) {
            double q = work->xq[c * work->row + i], v = work->xv[c * work->row + i];
            s->q0[c * s->dof + i] = q;
            s->v0[c * s->dof + i] = v;
            size = fmax(size, fmax(fabs(q), fabs(v) / r->omega_unit));
        }
        for (int i = 0; i < r->extra; i++) {
            double e = work->xe[c * work->extra_row + i];
            r->e0[c * r->extra + i] = e;
            size = fmax(size, fabs(e));
        }
        r->tolerance[c] =
            c ? work->tolerance_tangent * size : work->tolerance_absolute + work->tolerance_relative * size;
        r->unit[c] = DBL_EPSILON * size;
        r->size[c] = size;
    }
}

/* The longest first step that resolves every mode's boundary layer. Its size follows from the acceleration at
 * the start; a layer exp(-z s) is represented on [0, 1] to 1.3e-11 (z / 6)^13 of its size, near z = 6. */
static double first_step(saltus_radau *r, double phase) {
    saltus_stages *s = &r->stages;
    saltus_work *w = &r->work[0];
    for (int l = 0; l < s->lanes; l++) {
        w->phase[l] = phase;
        w->elapsed[l] = 0;
        for (int c = 0; c < r->all; c++) {
            for (int i = 0; i < s->dof; i++) {
                w->xq[c * w->row + i * s->lanes + l] = s->q0[c * s->dof + i];
                w->xv[c * w->row + i * s->lanes + l] = s->v0[c * s->dof + i];
            }
            for (int i = 0; i < r->extra; i++)
                w->xe[c * w->extra_row + i * s->lanes + l] = r->e0[c * r->extra + i];
        }
    }
    r->field->expand(w, 1);
    double step = r->system->period;
    for (int c = 0; c < r->all; c++)
        for (int i = 0; i < s->dof && (c < r->steady || r->size[c] > 0); i++) {
            double half = 0.5 * r->system->damping[i], inside = half * half - r->system->stiffness[i];
            double rate = inside > 0 ? half + sqrt(inside) : sqrt(r->system->stiffness[i]);
            double size = fabs(s->field[0][c * w->row + i * s->lanes]) / (rate * r->omega_unit);
            double turns =
                size > 0 && rate > 0 ? 5.5 * pow(r->tolerance[c] / (1.3e-11 * size), 1.0 / 13) : 20;
            turns = fmin(fmax(turns, 2), 20);
            if (rate * step > turns)
                step = turns / rate;
        }
    return step;
}

/* Steps lie on a grid, period 2^(-k / 4), so that factors serve again. */
static double grid_step(const saltus_radau *r, int k) {
    return r->system->period * exp2(-0.25 * k);
}

/* The shortest grid step of at least, or the longest of at most, a length. */
static int grid_above(const saltus_radau *r, double step) {
    return (int)fmax(0, floor(4 * log2(r->system->period / step)));
}

static int grid_below(const saltus_radau *r, double step) {
    return (int)fmax(0, ceil(4 * log2(r->system->period / step) - 1e-9));
}

/* A step that covers what is left to the target, or half of that so that no sliver remains: the flow cuts it
 * there. */
static int fit_step(const saltus_radau *r, double proposal, double limit) {
    int k = grid_below(r, fmax(proposal, r->shortest));
    limit = fmax(limit, r->shortest);
    for (int parts = 1; parts <= 2; parts++)
        if (grid_step(r, k) * parts >= limit)
            return grid_above(r, limit / parts);
    return k;
}

/* Legendre's polynomials at the nodes of a step that begins at `start` and is `ratio` as long as theirs. */
static void fill_extrapolation(saltus_radau *r, double start, double ratio, int count) {
    double *p = r->extrapolation, x[nodes];
    for (int j = 0; j < nodes; j++) {
        x[j] = 2 * (start + ratio * r->method->node[j]) - 1;
        p[j] = 1;
        p[nodes + j] = x[j];
    }
    for (int k = 1; k + 1 < count; k++) {
        double *row = p + (k + 1) * nodes, a = (2 * k + 1.0) / (k + 1), b = k / (k + 1.0);
        for (int j = 0; j < nodes; j++)
            row[j] = a * x[j] * row[j - nodes] - b * row[j - 2 * nodes];
    }
    memset(p + count * nodes, 0, (size_t)((nodes - count) * nodes) * sizeof *p);
}

/* Node values of the guess's polynomial, from `start` of its step on. Where it is extrapolated, high orders
 * would only carry noise: each is kept while its terms fall. */
static void guess_stages(saltus_radau *r, double start, double step) {
    double ratio = step / r->last_step, far[nodes], largest = INFINITY;
    int count = 1;
    saltus_legendre_values(start + ratio, nodes, far);
    double size[nodes] = {0};
    for (int i = 0; i < r->rows; i++)
        for (int k = 0; k < nodes; k++)
            size[k] = larger(size[k], fabs(r->last[i * nodes + k]));
    for (int k = 1; k < nodes; k++)
        if (size[k] * fabs(far[k]) < largest) {
            largest = size[k] * fabs(far[k]);
            count = k + 1;
        }
    fill_extrapolation(r, start, ratio, count);
    r->kernel->apply(r->last, r->rows, r->extrapolation, r->a);
}

/* Extra states: e = e0 + h S E; the largest change of a column's. */
static double integrate_extra(saltus_radau *r, int c, double step) {
    int lanes = r->stages.lanes;
    double change = 0;
    const double *rates = r->a + (size_t)(r->all * r->stages.dof + c * r->extra) * nodes;
    double *e = r->e + c * r->extra * nodes;
    r->kernel->apply(rates, r->extra, r->method->integral[0], e);
    for (int i = 0; i < r->extra; i++)
        for (int j = 0; j < nodes; j++) {
            saltus_work *w = &r->work[j / lanes];
            double *place = &w->xe[c * w->extra_row + i * lanes + j % lanes];
            double value = fma(step, e[i * nodes + j], r->e0[c * r->extra + i]);
            change = fmax(change, fabs(value - *place));
            *place = value;
        }
    return change;
}

static void take_rates(saltus_radau *r, int c) {
    int lanes = r->stages.lanes;
    double *rates = r->a + (size_t)(r->all * r->stages.dof + c * r->extra) * nodes;
    for (int i = 0; i < r->extra; i++)
        for (int j = 0; j < nodes; j++) {
            const saltus_work *w = &r->work[j / lanes];
            rates[i * nodes + j] = w->e[saltus_work_extra_jet(w, 1, c) + (size_t)(i * lanes + j % lanes)];
        }
}

/* A parameter column starts at zero: its size is what it grows to within the step. */
static void judge_size(saltus_radau *r, int c) {
    double size = r->size[c];
    for (int k = 0; k < r->stages.chunks; k++) {
        const saltus_work *w = &r->work[k];
        for (int i = 0; i < w->row; i++)
            size = larger(size,
                          larger(fabs(w->xq[c * w->row + i]), fabs(w->xv[c * w->row + i]) / r->omega_unit));
        for (int i = 0; i < w->extra_row; i++)
            size = larger(size, fabs(w->xe[c * w->extra_row + i]));
    }
    r->tolerance[c] = r->tolerance_tangent * size;
    r->unit[c] = DBL_EPSILON * size;
}

/* The field's arguments from the node values; the largest change in units of what the columns may be off. */
static double integrate(saltus_radau *r) {
    double largest = 0;
    for (int c = 0; c < r->all; c++) {
        const double *change = r->stages.change + 2 * c;
        r->kernel->integrate(&r->stages, c);
        double size = fmax(change[0], change[1] / r->omega_unit);
        if (r->extra)
            size = fmax(size, integrate_extra(r, c, r->stages.step));
        if (c >= r->steady)
            judge_size(r, c);
        double allowed = fmax(0.2 * r->tolerance[c], 8 * r->unit[c]);
        if (size > 0)
            largest = fmax(largest, size / fmax(allowed, DBL_MIN));
    }
    return largest;
}

/* Sweeps until the next one would change nothing that matters. */
static bool converge(saltus_radau *r, long long *evaluations) {
    saltus_stages *s = &r->stages;
    double before = INFINITY;
    int growths = 0;
    integrate(r);
    for (int sweep = 0; sweep < sweeps_max; sweep++) {
        for (int k = 0; k < s->chunks; k++)
            r->field->expand(&r->work[k], 1);
        *evaluations += nodes;
        for (int c = 0; c < r->all; c++) {
            r->kernel->correct(s, c);
            take_rates(r, c);
        }
        double change = integrate(r), rate = sweep ? change / before : 1;
        if (change <= 1 || (rate < 0.3 && change * rate <= 1))
            return true;
        growths += rate > 1;
        if (!(change < 1e300) || growths > 3)
            return false;
        before = change;
    }
    return false;
}

/* Largest Legendre coefficients of each order over the modes, as errors of velocities and extra states, in
 * units of the tolerance. */
static void measure(const saltus_radau *r, double *error) {
    const saltus_stages *s = &r->stages;
    memset(error, 0, nodes * sizeof *error);
    for (int c = 0; c < r->all; c++) {
        double size[nodes] = {0}, tolerance = r->tolerance[c] + DBL_MIN;
        const double *row = r->legendre + (size_t)(c * s->dof) * nodes;
        for (int i = 0; i < s->dof; i++, row += nodes)
            for (int k = 0; k < nodes; k++)
                size[k] = larger(size[k], fabs(row[k]));
        for (int k = 0; k < nodes; k++)
            size[k] /= r->omega_unit;
        row = r->legendre + (size_t)(r->all * s->dof + c * r->extra) * nodes;
        for (int i = 0; i < r->extra; i++, row += nodes)
            for (int k = 0; k < nodes; k++)
                size[k] = larger(size[k], fabs(row[k]));
        for (int k = 0; k < nodes; k++)
            error[k] = larger(error[k], s->step * size[k] / (tolerance * (4 * k + 2)));
    }
}

/* How far the polynomial is from the solution, in units of the tolerance. */
static double estimate(const double *error) {
    return larger(error[nodes - 1], 0.2 * error[nodes - 2]);
}

/* By how much the next step may be longer. Where the last coefficients are lost in rounding they would say
 * too little; then they are judged by the decay of those before. */
static double growth(const double *error) {
    const double goal = 2, noise = 1e-2;
    int last = nodes - 1;
    double expected = estimate(error);
    while (last > 5 && error[last] < noise)
        last--;
    if (last < nodes - 2 && error[2] > error[last]) {
        double decay = pow(error[last] / error[2], 1.0 / (last - 2));
        expected = error[last] * pow(decay, nodes - 1 - last);
    }
    return expected > 1e-18 ? fmin(4, pow(goal / expected, 1.0 / nodes)) : 4;
}

/* One column's jets: the accelerations' powers of time, integrated exactly. */
static void emit_column(const saltus_radau *r, saltus_work *work, int c, const double *scale) {
    const saltus_stages *s = &r->stages;
    for (int i = 0; i < s->dof; i++) {
        const double *powers = r->powers + (size_t)(c * s->dof + i) * nodes;
        double *q = work->q + saltus_work_jet(work, 0, c) + i, *v = work->v + saltus_work_jet(work, 0, c) + i;
        size_t order = saltus_work_jet(work, 1, 0);
        q[0] = s->q0[c * s->dof + i];
        q[order] = v[0] = s->v0[c * s->dof + i];
        for (int k = 0; k < nodes; k++) {
            double a = powers[k] * scale[k] / (k + 1);
            v[(size_t)(k + 1) * order] = a;
            q[(size_t)(k + 2) * order] = a / (k + 2);
        }
        v[(size_t)SALTUS_RADAU_DEGREE * order] = 0;
    }
    for (int i = 0; i < r->extra; i++) {
        const double *powers = r->powers + (size_t)(r->all * s->dof + c * r->extra + i) * nodes;
        for (int k = 0; k < nodes; k++)
            work->e[saltus_work_extra_jet(work, k + 1, c) + (size_t)i] = powers[k] * scale[k] / (k + 1);
        work->e[saltus_work_extra_jet(work, 0, c) + (size_t)i] = r->e0[c * r->extra + i];
        work->e[saltus_work_extra_jet(work, SALTUS_RADAU_DEGREE, c) + (size_t)i] = 0;
    }
}

static void emit_gaps(saltus_work *work) {
    for (int stop = 0; stop < work->stops; stop++) {
        const double *normal = work->normal + (size_t)stop * (size_t)work->row;
        double *gap = work->gap + (size_t)stop * (size_t)(work->order + 2);
        for (int k = 0; k <= SALTUS_RADAU_DEGREE; k++) {
            const double *q = work->q + saltus_work_jet(work, k, 0);
            double sum = 0;
            for (int i = 0; i < work->dof; i++)
                sum += normal[i] * q[i];
            gap[k] = sum;
        }
    }
}

static void emit_forces(saltus_radau *r, saltus_work *work, const double *scale) {
    int lanes = r->stages.lanes;
    for (int m = 0; m < work->contacts; m++) {
        double values[nodes], legendre[nodes];
        double *force = work->force + (size_t)m * (size_t)(work->order + 2);
        for (int j = 0; j < nodes; j++) {
            const saltus_work *w = &r->work[j / lanes];
            values[j] = w->force[(size_t)m * (size_t)(w->order + 2) * (size_t)lanes + (size_t)(j % lanes)];
        }
        for (int k = 0; k < nodes; k++) {
            legendre[k] = 0;
            for (int j = 0; j < nodes; j++)
                legendre[k] = fma(values[j], r->method->legendre[j][k], legendre[k]);
        }
        for (int k = 0; k < nodes; k++) {
            double sum = 0;
            for (int j = k; j < nodes; j++)
                sum = fma(legendre[j], r->method->monomial[j][k], sum);
            force[k] = sum * scale[k];
        }
        force[nodes] = force[nodes + 1] = 0;
    }
}

static void emit(saltus_radau *r, saltus_work *work) {
    double scale[nodes], step = r->stages.step;
    scale[0] = 1;
    for (int k = 1; k < nodes; k++)
        scale[k] = scale[k - 1] / step;
    r->kernel->apply(r->legendre, r->rows, r->method->monomial[0], r->powers);
    for (int c = 0; c < r->all; c++)
        emit_column(r, work, c, scale);
    emit_gaps(work);
    emit_forces(r, work, scale);
    work->step[0] = step;
}

/* Factors of the linear part at the middle of the step. They depend on the two numbers in the key alone. */
static void take_factors(saltus_radau *r, double phase, int k) {
    saltus_stages *s = &r->stages;
    size_t size = (size_t)(s->dof * s->dof);
    double middle = phase + 0.5 * s->step / r->system->period;
    int bin = (int)(bins * (middle - floor(middle))) % bins, key = 1 + k * bins + bin,
        slot = (k + 37 * bin) % r->slots;
    s->lu = r->factors + (size_t)slot * size * nodes;
    if (r->held[slot] != key) {
        s->damp = r->damp + (size_t)bin * size;
        s->stiff = r->stiff + (size_t)bin * size;
        r->kernel->factor(s);
        r->held[slot] = key;
    }
    if (s->contacts)
        r->kernel->factor_contacts(s);
}

static void begin_attempt(saltus_radau *r, double phase, int k) {
    saltus_stages *s = &r->stages;
    s->step = grid_step(r, k);
    for (int j = 0; j < nodes; j++) {
        double there = phase + r->method->node[j] * s->step / r->system->period;
        r->work[j / s->lanes].phase[j % s->lanes] = there - floor(there);
        r->work[j / s->lanes].elapsed[j % s->lanes] = r->method->node[j] * s->step;
    }
    take_factors(r, phase, k);
}

/* Where in the last step this one starts, if it does: the flow may have cut that one short. */
static double start_in_last(const saltus_radau *r, double phase) {
    double passed = phase - r->last_phase;
    return (passed - floor(passed)) * r->system->period / r->last_step;
}

static void keep_as_guess(saltus_radau *r, double phase) {
    double *swap = r->last;
    r->last = r->legendre;
    r->legendre = swap;
    r->last_step = r->stages.step;
    r->last_phase = phase;
    r->follows = true;
}

/* The first step of a new trajectory, or after an impact. Impacts of a chatter come at shorter and shorter
 * times, so there a step need not be longer than the last time between two of them. */
static void propose_first(saltus_radau *r, double phase, long long *evaluations) {
    r->proposal = first_step(r, phase);
    *evaluations += r->stages.lanes;
    if (r->bounces > 1 && r->steps == 1) {
        double interval = start_in_last(r, phase) * r->last_step;
        if (interval > 0)
            r->proposal = fmin(r->proposal, 1.1 * interval);
    }
    r->steps = 0;
}

/* Converge and judge one step; *scale is how much shorter the next attempt should be when this one fails. */
static bool attempt_step(saltus_radau *r, double phase, int k, bool follows, double *errors, double *scale,
                         long long *evaluations) {
    const double accept = 30;
    begin_attempt(r, phase, k);
    double start = follows ? start_in_last(r, phase) : 0;
    if (follows && start < 1.5)
        guess_stages(r, start, r->stages.step);
    else
        memset(r->a, 0, (size_t)r->rows * nodes * sizeof(double));
    *scale = 0;
    if (!converge(r, evaluations))
        return false;
    r->kernel->apply(r->a, r->rows, r->method->legendre[0], r->legendre);
    measure(r, errors);
    double error = estimate(errors);
    if (!isfinite(error))
        return false;
    *scale = fmin(0.8, fmax(0.1, pow(1 / fmax(error, 1), 1.0 / nodes)));
    return error <= accept;
}

/* Whether the step's polynomial holds numbers up to its end. Its coefficients are powers of time and may be
 * too large for that where the nodes are not. */
static bool ends_finite(const saltus_work *work, int dof) {
    double sum = 0;
    for (int i = 0; i < dof; i++) {
        double q = 0, v = 0;
        for (int k = SALTUS_RADAU_DEGREE; k >= 0; k--) {
            size_t place = saltus_work_jet(work, k, 0) + (size_t)i;
            q = fma(q, work->step[0], work->q[place]);
            v = fma(v, work->step[0], work->v[place]);
        }
        sum += fabs(q) + fabs(v);
    }
    return isfinite(sum);
}

saltus_status saltus_radau_step(saltus_radau *radau, saltus_work *work, double limit,
                                long long *evaluations) {
    double phase = work->phase[0], errors[nodes], scale = 0;
    take_start(radau, work);
    if (radau->proposal == 0)
        propose_first(radau, phase, evaluations);
    int k = fit_step(radau, radau->proposal, limit);
    bool follows = radau->follows, done = false;
    for (int attempt = 0; attempt < attempts_max; attempt++) {
        done = attempt_step(radau, phase, k, follows, errors, &scale, evaluations);
        if (done)
            break;
        /* A polynomial that is only too coarse guesses the shorter step well. */
        follows = scale > 0;
        if (follows)
            keep_as_guess(radau, phase);
        radau->proposal = scale > 0 ? scale * radau->stages.step : 0.5 * radau->stages.step;
        k = grid_below(radau, radau->proposal);
    }
    if (!done)
        return SALTUS_STALLED;
    emit(radau, work);
    if (!ends_finite(work, radau->stages.dof))
        return SALTUS_STALLED;
    double step = radau->stages.step, grown = step * growth(errors);
    radau->proposal = step < radau->proposal ? fmax(radau->proposal, grown) : grown;
    radau->steps++;
    keep_as_guess(radau, phase);
    return SALTUS_OK;
}
