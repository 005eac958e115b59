/* Step control of the stiff integrator.
 *
 * The unknowns of a step are the accelerations at the nodes. One sweep evaluates the field at all nodes side
 * by side and corrects the accelerations by solving the linear part for the residual (collocation.h); this
 * linear part is taken at rest, at the phase of the step's middle. The cubic term and the change of the
 * pulsation within the step remain: mild couplings, whose error falls like (h L)^k / k! with the number k of
 * sweeps. The sweeps converge to the collocation solution whatever the linear part is. Where the damping
 * itself changes with the state, as along a relaxation oscillation, a part taken at rest would keep steps to
 * the fast time; if the sweeps of equations from text converge slowly, it is taken anew where the motion is.
 *
 * Dense output is the polynomial of degree 15 through the accelerations, integrated twice exactly. Its last
 * Legendre coefficients tell how well it represents the solution inside the step, where events are located on
 * it; the values at the step's end are far more accurate (order 31). After an impact every mode of the pipe
 * has a boundary layer of its own length; the first step follows from the rates and sizes of these layers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/radau.h"

#include "base/dense.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    nodes = SALTUS_RADAU_NODES,
    bins = 8,
    slots_max = 256,
    sweeps_max = 40,
    sweeps_many = 10, /* of a step whose linear part fits badly */
    attempts_max = 60
};

/* The field's linear part at rest in each bin of the phase, and those of its factors that were needed. */
typedef struct factor_cache {
    double *damp, *stiff; /* [bin][mode][mode] */
    double *factors;      /* [slot][mode][mode][16] */
    int slots;
    int held[slots_max]; /* key of the factors in a slot; 0: none */
} factor_cache;

/* The last step's polynomial, which guesses the next: Legendre coefficients, length and begin of its step. */
typedef struct last_polynomial {
    double *legendre;
    double step, phase;
    bool known;
} last_polynomial;

/* What a column's errors are measured by. */
typedef struct column_scale {
    double size;      /* at the step's start */
    double tolerance; /* in units of displacement */
    double unit;      /* size of rounding errors */
} column_scale;

struct saltus_radau {
    saltus_arena arena;
    /* Set when opened or retuned. */
    const saltus_system *system;
    const saltus_kernel *field;
    const saltus_collocation_kernel *kernel;
    int all, extra, rows; /* columns including the trajectory; rows of 16 in the arrays below */
    int steady;           /* the columns without parameter columns */
    double omega_unit, shortest;
    saltus_tolerance tolerance;
    /* The step. */
    saltus_stages stages;
    saltus_work work[SALTUS_RADAU_CHUNKS_MAX];
    double *a;                 /* node values: accelerations [column][mode][16], then rates of extra states */
    double *e0;                /* extra states at the start: [column][extra] */
    double *e;                 /* extra states at the nodes: [column][extra][16] */
    double *legendre, *powers; /* coefficients of this step's polynomial */
    column_scale *column;
    /* Kept from step to step. */
    factor_cache cache;
    last_polynomial last;
    double proposal;    /* step to try; 0 after a reset */
    int steps, bounces; /* since the last impact; impacts since the reset */
    int sweeps;         /* of the last attempt */
    bool moved;         /* the linear part is not that at rest */
};

/* The larger; a NaN wins. */
static inline double larger(double a, double b) {
    return a >= b || isnan(a) ? a : b;
}

static void reserve(saltus_radau *r) {
    saltus_arena *arena = &r->arena;
    saltus_stages *s = &r->stages;
    size_t n = (size_t)s->dof, all = (size_t)r->all, rows = (size_t)r->rows * nodes;
    size_t extra = (size_t)r->extra, faces = (size_t)r->system->face_count;
    s->method = (void *)saltus_arena_doubles(arena, sizeof *s->method / sizeof(double));
    r->column = (void *)saltus_arena_doubles(arena, all * sizeof *r->column / sizeof(double));
    r->a = s->a = saltus_arena_doubles(arena, rows);
    r->legendre = saltus_arena_doubles(arena, rows);
    r->last.legendre = saltus_arena_doubles(arena, rows);
    r->powers = saltus_arena_doubles(arena, rows);
    r->e0 = saltus_arena_doubles(arena, all * extra);
    r->e = saltus_arena_doubles(arena, all * extra * nodes);
    s->q0 = saltus_arena_doubles(arena, all * n);
    s->v0 = saltus_arena_doubles(arena, all * n);
    s->hat = saltus_arena_doubles(arena, n * nodes);
    s->change = saltus_arena_doubles(arena, all * 2);
    r->cache.damp = saltus_arena_doubles(arena, bins * n * n);
    r->cache.stiff = saltus_arena_doubles(arena, bins * n * n);
    r->cache.factors = saltus_arena_doubles(arena, (size_t)r->cache.slots * n * n * nodes);
    s->contact.push = saltus_arena_doubles(arena, faces * n);
    s->contact.pull = saltus_arena_doubles(arena, faces * n);
    s->contact.reply = saltus_arena_doubles(arena, faces * n * nodes);
    s->contact.schur = saltus_arena_doubles(arena, faces * faces * nodes);
}

/* Where the linear part is taken: displacements, velocities and extra states; NULL: at rest. */
typedef struct linear_place {
    const double *q, *v, *e;
} linear_place;

/* The field near a place, with one displacement or velocity of the trajectory changed, in all bins of the
 * phase side by side: value [bin][mode]. */
static void field_near(saltus_radau *r, const linear_place *place, int mode, double displacement,
                       double velocity, double *value) {
    const int n = r->stages.dof;
    for (int k = 0; k < r->stages.chunks; k++) {
        saltus_work *w = &r->work[k];
        for (int l = 0; l < w->lanes; l++) {
            w->lane->phase[l] = ((k * w->lanes + l) % bins + 0.5) / bins;
            for (int i = 0; i < n && place; i++) {
                w->state.q[i * w->lanes + l] = place->q[i];
                w->state.v[i * w->lanes + l] = place->v[i];
            }
            for (int i = 0; i < r->extra && place; i++)
                w->state.e[saltus_work_extra_place(w, 0, 0, i, l)] = place->e[i];
            w->state.q[mode * w->lanes + l] += displacement;
            w->state.v[mode * w->lanes + l] += velocity;
        }
        r->field->expand(w, 0, 1);
        for (int l = 0; l < w->lanes && !place; l++)
            w->state.q[mode * w->lanes + l] = w->state.v[mode * w->lanes + l] = 0;
        for (int l = 0; l < w->lanes && k * w->lanes + l < bins; l++)
            for (int i = 0; i < n; i++)
                value[(k * w->lanes + l) * n + i] = r->stages.field[k][i * w->lanes + l];
    }
}

/* The linear part by differences from a place; it only steers the iteration. If modes couple only to those of
 * the other parity, they are eliminated parity by parity, which saves half the work. */
static void find_linear_part(saltus_radau *r, const linear_place *place) {
    saltus_linear_part *linear = &r->stages.linear;
    int n = r->stages.dof, rank = 0;
    double rest[bins * SALTUS_MODES_MAX], moved[bins * SALTUS_MODES_MAX];
    int held[SALTUS_RADAU_CHUNKS_MAX];
    bool alternate = true;
    /* Contacts have unknowns of their own. */
    for (int k = 0; k < r->stages.chunks; k++) {
        held[k] = r->work[k].hold.count;
        r->work[k].hold.count = 0;
        if (!place)
            saltus_work_clear_states(&r->work[k]);
    }
    field_near(r, place, 0, 0, 0, rest);
    for (int j = 0; j < n; j++) {
        const double *scale = r->system->scale, small = 1e-5 * scale[j],
                     slow = place ? 1e-5 * scale[n + j] : 1;
        field_near(r, place, j, 0, slow, moved);
        for (int k = 0; k < bins * n; k++)
            r->cache.damp[k * n + j] = (moved[k] - rest[k]) / slow;
        field_near(r, place, j, small, 0, moved);
        for (int k = 0; k < bins * n; k++)
            r->cache.stiff[k * n + j] = (moved[k] - rest[k]) / small;
    }
    for (int k = 0; k < bins * n; k++)
        for (int j = k % n % 2; j < n; j += 2)
            if (j != k % n)
                alternate &= r->cache.damp[k * n + j] == 0 && r->cache.stiff[k * n + j] == 0;
    for (int parity = 0; parity < 2; parity++)
        for (int i = parity; i < n; i += 2)
            linear->order[rank++] = i;
    linear->uncoupled = alternate ? (n + 1) / 2 : 0;
    for (int k = 0; k < r->stages.chunks; k++)
        r->work[k].hold.count = held[k];
    memset(r->cache.held, 0, sizeof r->cache.held);
    r->moved = place != NULL;
}

void saltus_radau_retune(saltus_radau *radau, const saltus_system *system) {
    radau->system = system;
    radau->omega_unit = system->scale[system->dof] / system->scale[0];
    radau->shortest = 1e-4 / system->rate;
    for (int k = 0; k < radau->stages.chunks; k++) {
        saltus_work *w = &radau->work[k];
        saltus_work_forget(w);
        const saltus_damping damping = saltus_system_damping(system, NULL, w->order);
        for (int l = 0; l < w->lanes; l++)
            radau->field->load(w, l, system, w->order, damping);
        w->stops = 0;
    }
    find_linear_part(radau, NULL);
    saltus_radau_reset(radau);
}

void saltus_radau_vary(saltus_radau *radau, int direction, const saltus_variation *variation) {
    for (int k = 0; k < radau->stages.chunks; k++)
        for (int l = 0; l < radau->work[k].lanes; l++)
            radau->field->vary(&radau->work[k], l, direction, variation);
}

saltus_status saltus_radau_open(saltus_radau **radau, const saltus_system *system, int columns,
                                int directions, saltus_tolerance tolerance) {
    const int room = (1 << 20) / (system->dof * system->dof * nodes); /* sets of factors in 8 MiB */
    const saltus_kernel *field = saltus_kernel_find(system->spec.model->kernel, 0);
    *radau = NULL;
    saltus_radau *r = calloc(1, sizeof *r);
    if (!r)
        return SALTUS_NO_MEMORY;
    r->system = system;
    r->field = field;
    r->kernel = saltus_collocation_find(field->lanes);
    r->all = columns + 1;
    r->extra = system->extra;
    r->rows = r->all * (system->dof + system->extra);
    r->steady = r->all - directions;
    r->tolerance = tolerance;
    r->stages = (saltus_stages){.dof = system->dof, .lanes = field->lanes, .chunks = nodes / field->lanes};
    r->cache.slots = room < 16 ? 16 : room > slots_max ? slots_max : room;
    reserve(r);
    saltus_status status = saltus_arena_open(&r->arena) ? SALTUS_OK : SALTUS_NO_MEMORY;
    if (status == SALTUS_OK) {
        reserve(r);
        status = saltus_collocation_build(r->stages.method) ? SALTUS_OK : SALTUS_STALLED;
    }
    for (int k = 0; k < r->stages.chunks && status == SALTUS_OK; k++) {
        saltus_work *w = &r->work[k];
        status = saltus_work_open(w, field, system, 1, columns, directions, tolerance);
        if (status != SALTUS_OK)
            break;
        r->stages.row = (size_t)w->row;
        r->stages.q[k] = w->state.q;
        r->stages.v[k] = w->state.v;
        r->stages.field[k] = w->jet.v + saltus_work_place(w, 1, 0, 0, 0);
    }
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
    if (radau->moved)
        find_linear_part(radau, NULL);
    radau->proposal = 0;
    radau->last.known = false;
    radau->bounces = radau->steps = 0;
}

void saltus_radau_impact(saltus_radau *radau) {
    radau->proposal = 0;
    radau->last.known = false;
    radau->bounces++;
}

/* Copy rows of the flow's work into all lanes of one of the stages' works. */
static void spread_rows(const saltus_work *work, const double *from, const saltus_work *w, double *to,
                        int rows) {
    for (int m = 0; m < rows; m++)
        for (int i = 0; i < w->dof; i++)
            for (int l = 0; l < w->lanes; l++)
                to[saltus_work_place(w, 0, m, i, l)] = from[m * work->row + i];
}

void saltus_radau_publish(saltus_radau *radau, const saltus_work *work) {
    saltus_stages *s = &radau->stages;
    int contacts = work->hold.count, varied = work->vary.tilts ? work->directions * contacts : 0;
    s->contact.count = contacts;
    for (int m = 0; m < contacts; m++)
        for (int i = 0; i < s->dof; i++) {
            s->contact.push[m * s->dof + i] = work->hold.push[m * work->row + i];
            s->contact.pull[m * s->dof + i] = work->hold.pull[m * work->row + i];
        }
    for (int k = 0; k < s->chunks; k++) {
        saltus_work *w = &radau->work[k];
        w->hold.count = contacts;
        spread_rows(work, work->hold.push, w, w->hold.push, contacts);
        spread_rows(work, work->hold.pull, w, w->hold.pull, contacts);
        spread_rows(work, work->vary.push, w, w->vary.push, varied);
        spread_rows(work, work->vary.pull, w, w->vary.pull, varied);
    }
}

/* Take the start of a step from the flow's work, and set the columns' tolerances. */
static void take_start(saltus_radau *r, const saltus_work *work) {
    saltus_stages *s = &r->stages;
    for (int c = 0; c < r->all; c++) {
        double size = 0;
        for (int i = 0; i < s->dof; i++) {
            double q = work->state.q[c * work->row + i], v = work->state.v[c * work->row + i];
            s->q0[c * s->dof + i] = q;
            s->v0[c * s->dof + i] = v;
            size = fmax(size, fmax(fabs(q), fabs(v) / r->omega_unit));
        }
        for (int i = 0; i < r->extra; i++) {
            double e = work->state.e[c * r->extra + i];
            r->e0[c * r->extra + i] = e;
            size = fmax(size, fabs(e));
        }
        const saltus_tolerance t = r->tolerance;
        r->column[c] = (column_scale){.size = size,
                                      .tolerance = c ? t.tangent * size : t.absolute + t.relative * size,
                                      .unit = DBL_EPSILON * size};
    }
}

/* The field at the step's start, in all lanes of the first chunk. */
static void find_start_field(saltus_radau *r, double phase) {
    saltus_stages *s = &r->stages;
    saltus_work *w = &r->work[0];
    for (int l = 0; l < s->lanes; l++) {
        w->lane->phase[l] = phase;
        w->lane->elapsed[l] = 0;
        for (int c = 0; c < r->all; c++) {
            for (int i = 0; i < s->dof; i++) {
                w->state.q[saltus_work_place(w, 0, c, i, l)] = s->q0[c * s->dof + i];
                w->state.v[saltus_work_place(w, 0, c, i, l)] = s->v0[c * s->dof + i];
            }
            for (int i = 0; i < r->extra; i++)
                w->state.e[saltus_work_extra_place(w, 0, c, i, l)] = r->e0[c * r->extra + i];
        }
    }
    r->field->expand(w, 0, 1);
}

/* The boundary layer of a mode in the trajectory or a tangent vector. */
typedef struct boundary_layer {
    double rate, size; /* rate of decay; size in units of the tolerance, from the acceleration at the start */
} boundary_layer;

static boundary_layer layer_of(const saltus_radau *r, int c, int i) {
    const double half = 0.5 * r->system->damping[i], inside = half * half - r->system->stiffness[i];
    const double rate = inside > 0 ? half + sqrt(inside) : sqrt(r->system->stiffness[i]);
    const double size = fabs(r->stages.field[0][saltus_work_place(&r->work[0], 0, c, i, 0)]) /
                        (rate * r->omega_unit * r->column[c].tolerance);
    const bool counts = rate > 0 && size > 0 && (c < r->steady || r->column[c].size > 0);
    return (boundary_layer){.rate = rate, .size = counts ? size : 0};
}

/* How many decay times of a layer a step may cover and still resolve it: exp(-z s) is represented on [0, 1]
 * to 1.3e-11 (z / 6)^13 of its size, near z = 6. */
enum { turns_least = 2, turns_most = 20 };
static double resolved_turns(double size) {
    return fmin(fmax(5.5 * pow(1.3e-11 * size, -1.0 / 13), turns_least), turns_most);
}

/* The longest first step that resolves every mode's boundary layer. */
static double first_step(saltus_radau *r, double phase) {
    double step = r->system->period;
    find_start_field(r, phase);
    for (int c = 0; c < r->all; c++)
        for (int i = 0; i < r->stages.dof; i++) {
            const boundary_layer layer = layer_of(r, c, i);
            if (layer.size > 0 && layer.rate * step > turns_least)
                step = fmin(step, resolved_turns(layer.size) / layer.rate);
        }
    return step;
}

double saltus_radau_layers(saltus_radau *radau, const saltus_work *work, double step,
                           long long *evaluations) {
    double last = 0;
    take_start(radau, work);
    find_start_field(radau, work->lane->phase[0]);
    *evaluations += radau->stages.lanes;
    for (int c = 0; c < radau->all; c++)
        for (int i = 0; i < radau->stages.dof; i++) {
            const boundary_layer layer = layer_of(radau, c, i);
            if (layer.size > 1 && layer.rate * step > turns_least &&
                layer.rate * step > resolved_turns(layer.size))
                last = fmax(last, log(layer.size) / layer.rate);
        }
    radau->proposal = step;
    return last;
}

/* Step lengths lie on a grid, period * 2^(-k / 4), so that factors can be used again. */
static double grid_step(const saltus_radau *r, int k) {
    return r->system->period * exp2(-0.25 * k);
}

/* The longest grid step not above `step`. */
static int grid_below(const saltus_radau *r, double step) {
    return (int)fmax(0, ceil(4 * log2(r->system->period / step) - 1e-9));
}

/* The grid step to try. If what is left to the target, or half of it, is within the proposal, it is the
 * shortest that covers that, so that no sliver remains; the flow cuts it at the target. */
static int fit_step(const saltus_radau *r, double proposal, double left) {
    int k = grid_below(r, fmax(proposal, r->shortest));
    left = fmax(left, r->shortest);
    for (int parts = 1; parts <= 2; parts++)
        if (grid_step(r, k) * parts >= left)
            return (int)fmax(0, floor(4 * log2(r->system->period / (left / parts))));
    return k;
}

/* Guess node values from the last step's polynomial, `start` of its length after its begin. High orders only
 * add noise where it is extrapolated: each is kept while its terms fall. */
static void guess_stages(saltus_radau *r, double start, double step) {
    _Alignas(64) saltus_node_matrix values; /* of Legendre's polynomials: [k][node] */
    double ratio = step / r->last.step, far[nodes], x[nodes], largest = INFINITY, size[nodes] = {0};
    int count = 1;
    saltus_legendre_values(start + ratio, nodes, far);
    for (int i = 0; i < r->rows; i++)
        for (int k = 0; k < nodes; k++)
            size[k] = larger(size[k], fabs(r->last.legendre[i * nodes + k]));
    for (int k = 1; k < nodes; k++)
        if (size[k] * fabs(far[k]) < largest) {
            largest = size[k] * fabs(far[k]);
            count = k + 1;
        }
    for (int j = 0; j < nodes; j++) {
        x[j] = 2 * (start + ratio * r->stages.method->node[j]) - 1;
        values[0][j] = 1;
        values[1][j] = x[j];
    }
    for (int k = 1; k + 1 < count; k++) {
        const double rise = (2 * k + 1.0) / (k + 1), fall = k / (k + 1.0);
        for (int j = 0; j < nodes; j++)
            values[k + 1][j] = rise * x[j] * values[k][j] - fall * values[k - 1][j];
    }
    memset(values[count], 0, (size_t)(nodes - count) * sizeof *values);
    r->kernel->apply(r->last.legendre, r->rows, values[0], r->a);
}

/* A column's rates of extra states in an array of node values; they follow all accelerations. */
static double *rates_of(const saltus_radau *r, double *rows, int c) {
    return rows + (size_t)(r->all * r->stages.dof + c * r->extra) * nodes;
}

/* Extra states e = e0 + h S E from their rates E; returns a column's largest change. */
static double integrate_extra(saltus_radau *r, int c, double step) {
    int lanes = r->stages.lanes;
    double change = 0, *e = r->e + c * r->extra * nodes;
    r->kernel->apply(rates_of(r, r->a, c), r->extra, r->stages.method->integral[0], e);
    for (int i = 0; i < r->extra; i++)
        for (int j = 0; j < nodes; j++) {
            saltus_work *w = &r->work[j / lanes];
            double *place = &w->state.e[saltus_work_extra_place(w, 0, c, i, j % lanes)];
            double value = fma(step, e[i * nodes + j], r->e0[c * r->extra + i]);
            change = fmax(change, fabs(value - *place));
            *place = value;
        }
    return change;
}

static void take_rates(saltus_radau *r, int c) {
    int lanes = r->stages.lanes;
    double *rates = rates_of(r, r->a, c);
    for (int i = 0; i < r->extra; i++)
        for (int j = 0; j < nodes; j++) {
            const saltus_work *w = &r->work[j / lanes];
            rates[i * nodes + j] = w->jet.e[saltus_work_extra_place(w, 1, c, i, j % lanes)];
        }
}

/* A parameter column starts at zero, so its size is the largest within the step. */
static void judge_size(saltus_radau *r, int c) {
    double size = r->column[c].size;
    for (int k = 0; k < r->stages.chunks; k++) {
        const saltus_work *w = &r->work[k];
        const double *q = w->state.q + c * w->row, *v = w->state.v + c * w->row;
        for (int i = 0; i < w->row; i++)
            size = larger(size, larger(fabs(q[i]), fabs(v[i]) / r->omega_unit));
        for (int i = 0; i < w->extra * w->lanes; i++)
            size = larger(size, fabs(w->state.e[c * w->extra * w->lanes + i]));
    }
    r->column[c].tolerance = r->tolerance.tangent * size;
    r->column[c].unit = DBL_EPSILON * size;
}

/* The field's arguments from the node values; returns their largest change over their column's allowance. */
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
        double allowed = fmax(0.2 * r->column[c].tolerance, 8 * r->column[c].unit);
        if (size > 0)
            largest = fmax(largest, size / fmax(allowed, DBL_MIN));
    }
    return largest;
}

/* Sweep until the next sweep would change nothing that matters. */
static bool converge(saltus_radau *r, long long *evaluations) {
    saltus_stages *s = &r->stages;
    double before = INFINITY;
    int growths = 0;
    integrate(r);
    for (int sweep = 0; sweep < sweeps_max; sweep++) {
        r->sweeps = sweep + 1;
        for (int k = 0; k < s->chunks; k++)
            r->field->expand(&r->work[k], 0, 1);
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

/* The largest Legendre coefficients of each order over modes and columns, as errors of velocities and extra
 * states in units of the tolerance. */
static void measure(const saltus_radau *r, double *error) {
    const saltus_stages *s = &r->stages;
    memset(error, 0, nodes * sizeof *error);
    for (int c = 0; c < r->all; c++) {
        double size[nodes] = {0}, tolerance = r->column[c].tolerance + DBL_MIN;
        const double *row = r->legendre + (size_t)(c * s->dof) * nodes;
        for (int i = 0; i < s->dof; i++, row += nodes)
            for (int k = 0; k < nodes; k++)
                size[k] = larger(size[k], fabs(row[k]));
        for (int k = 0; k < nodes; k++)
            size[k] /= r->omega_unit;
        row = rates_of(r, r->legendre, c);
        for (int i = 0; i < r->extra; i++, row += nodes)
            for (int k = 0; k < nodes; k++)
                size[k] = larger(size[k], fabs(row[k]));
        for (int k = 0; k < nodes; k++)
            error[k] = larger(error[k], s->step * size[k] / (tolerance * (4 * k + 2)));
    }
}

/* The polynomial's error in units of the tolerance. */
static double estimate(const double *error) {
    return larger(error[nodes - 1], 0.2 * error[nodes - 2]);
}

/* The factor by which the next step may be longer. Last coefficients that are lost in rounding are judged by
 * the decay of those before. */
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

/* One column's jets: the accelerations as powers of time, integrated exactly. */
static void emit_column(const saltus_radau *r, saltus_work *work, int c, const double *scale) {
    const saltus_stages *s = &r->stages;
    const size_t order = saltus_work_place(work, 1, 0, 0, 0);
    for (int i = 0; i < s->dof; i++) {
        const double *powers = r->powers + (size_t)(c * s->dof + i) * nodes;
        double *q = work->jet.q + saltus_work_place(work, 0, c, i, 0),
               *v = work->jet.v + saltus_work_place(work, 0, c, i, 0);
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
        const double *powers = rates_of(r, r->powers, c) + i * nodes;
        double *e = work->jet.e;
        e[saltus_work_extra_place(work, 0, c, i, 0)] = r->e0[c * r->extra + i];
        for (int k = 0; k < nodes; k++)
            e[saltus_work_extra_place(work, k + 1, c, i, 0)] = powers[k] * scale[k] / (k + 1);
        e[saltus_work_extra_place(work, SALTUS_RADAU_DEGREE, c, i, 0)] = 0;
    }
}

static void emit_gaps(saltus_work *work) {
    for (int stop = 0; stop < work->stops; stop++)
        for (int k = 0; k <= SALTUS_RADAU_DEGREE; k++) {
            const double *normal = work->loaded.normal + stop * work->row;
            const double *q = work->jet.q + saltus_work_place(work, k, 0, 0, 0);
            double sum = 0;
            for (int i = 0; i < work->dof; i++)
                sum += normal[i] * q[i];
            work->gap[saltus_work_series_place(work, stop, k, 0)] = sum;
        }
}

static void emit_forces(const saltus_radau *r, saltus_work *work, const double *scale) {
    const saltus_collocation *method = r->stages.method;
    int lanes = r->stages.lanes;
    for (int m = 0; m < work->hold.count; m++) {
        double legendre[nodes] = {0};
        double *force = work->hold.force + saltus_work_series_place(work, m, 0, 0);
        for (int j = 0; j < nodes; j++) {
            const saltus_work *w = &r->work[j / lanes];
            double value = w->hold.force[saltus_work_series_place(w, m, 0, j % lanes)];
            for (int k = 0; k < nodes; k++)
                legendre[k] = fma(value, method->legendre[j][k], legendre[k]);
        }
        for (int k = 0; k < nodes; k++) {
            double sum = 0;
            for (int j = k; j < nodes; j++)
                sum = fma(legendre[j], method->monomial[j][k], sum);
            force[k] = sum * scale[k];
        }
        force[nodes] = force[nodes + 1] = 0;
    }
}

/* Write the step's polynomial into the flow's work. */
static void emit(saltus_radau *r, saltus_work *work) {
    double scale[nodes], step = r->stages.step;
    scale[0] = 1;
    for (int k = 1; k < nodes; k++)
        scale[k] = scale[k - 1] / step;
    r->kernel->apply(r->legendre, r->rows, r->stages.method->monomial[0], r->powers);
    for (int c = 0; c < r->all; c++)
        emit_column(r, work, c, scale);
    emit_gaps(work);
    emit_forces(r, work, scale);
    work->lane->step[0] = step;
}

/* Factors of the linear part at the step's middle; they depend only on the two numbers in the key. */
static void take_factors(saltus_radau *r, double phase, int k) {
    saltus_stages *s = &r->stages;
    factor_cache *cache = &r->cache;
    size_t size = (size_t)(s->dof * s->dof);
    double middle = phase + 0.5 * s->step / r->system->period;
    int bin = (int)(bins * (middle - floor(middle))) % bins, key = 1 + k * bins + bin,
        slot = (k + 37 * bin) % cache->slots;
    s->linear.lu = cache->factors + (size_t)slot * size * nodes;
    if (cache->held[slot] != key) {
        s->linear.damp = cache->damp + (size_t)bin * size;
        s->linear.stiff = cache->stiff + (size_t)bin * size;
        r->kernel->factor(s);
        cache->held[slot] = key;
    }
    if (s->contact.count)
        r->kernel->factor_contacts(s);
}

/* Where this step starts, in lengths of the last step from its begin: below 1 if the flow cut that short. */
static double start_in_last(const saltus_radau *r, double phase) {
    double passed = phase - r->last.phase;
    return (passed - floor(passed)) * r->system->period / r->last.step;
}

static void keep_as_guess(saltus_radau *r, double phase) {
    double *legendre = r->legendre;
    r->legendre = r->last.legendre;
    r->last = (last_polynomial){.legendre = legendre, .step = r->stages.step, .phase = phase, .known = true};
}

/* Propose the first step of a new trajectory or after an impact. The intervals between a chatter's impacts
 * become shorter and shorter, so there it need not be much longer than the last one. */
static void propose_first(saltus_radau *r, double phase, long long *evaluations) {
    r->proposal = first_step(r, phase);
    *evaluations += r->stages.lanes;
    if (r->bounces > 1 && r->steps == 1) {
        double interval = start_in_last(r, phase) * r->last.step;
        if (interval > 0)
            r->proposal = fmin(r->proposal, 1.1 * interval);
    }
    r->steps = 0;
}

/* Try one step and judge it. If it fails, *scale is the factor for the next attempt; 0: nothing converged. */
static bool attempt_step(saltus_radau *r, double phase, int k, bool follows, double *errors, double *scale,
                         long long *evaluations) {
    const double accept = 30;
    saltus_stages *s = &r->stages;
    s->step = grid_step(r, k);
    for (int j = 0; j < nodes; j++) {
        saltus_lane_numbers *at = r->work[j / s->lanes].lane;
        double there = phase + s->method->node[j] * s->step / r->system->period;
        at->phase[j % s->lanes] = there - floor(there);
        at->elapsed[j % s->lanes] = s->method->node[j] * s->step;
    }
    take_factors(r, phase, k);
    double start = follows ? start_in_last(r, phase) : 0;
    if (follows && start < 1.5)
        guess_stages(r, start, s->step);
    else
        memset(r->a, 0, (size_t)r->rows * nodes * sizeof(double));
    *scale = 0;
    if (!converge(r, evaluations))
        return false;
    r->kernel->apply(r->a, r->rows, s->method->legendre[0], r->legendre);
    measure(r, errors);
    double error = estimate(errors);
    if (!isfinite(error))
        return false;
    *scale = fmin(0.8, fmax(0.1, pow(1 / fmax(error, 1), 1.0 / nodes)));
    return error <= accept;
}

/* Whether displacements and velocities are finite at the end of the step's polynomial. Its coefficients of
 * powers of time may overflow where the node values do not. */
static bool ends_finite(const saltus_work *work) {
    double sum = 0;
    for (int i = 0; i < work->dof; i++) {
        double q = 0, v = 0;
        for (int k = SALTUS_RADAU_DEGREE; k >= 0; k--) {
            size_t place = saltus_work_place(work, k, 0, i, 0);
            q = fma(q, work->lane->step[0], work->jet.q[place]);
            v = fma(v, work->lane->step[0], work->jet.v[place]);
        }
        sum += fabs(q) + fabs(v);
    }
    return isfinite(sum);
}

/* Take the linear part anew at the start of the step. */
static void linearise_here(saltus_radau *radau, long long *evaluations) {
    const saltus_stages *s = &radau->stages;
    const linear_place here = {s->q0, s->v0, radau->e0};
    find_linear_part(radau, &here);
    const size_t numbers = (size_t)(bins * s->dof * s->dof);
    if (!saltus_dense_finite(radau->cache.damp, numbers) || !saltus_dense_finite(radau->cache.stiff, numbers))
        find_linear_part(radau, NULL);
    *evaluations += (2 * s->dof + 1) * nodes;
}

saltus_status saltus_radau_step(saltus_radau *radau, saltus_work *work, long long *evaluations) {
    double phase = work->lane->phase[0], errors[nodes], scale = 0;
    take_start(radau, work);
    if (radau->proposal == 0)
        propose_first(radau, phase, evaluations);
    int k = fit_step(radau, radau->proposal, work->lane->left[0]), attempt = 0;
    bool follows = radau->last.known, fits = !radau->system->tape;
    while (!attempt_step(radau, phase, k, follows, errors, &scale, evaluations)) {
        if (++attempt == attempts_max)
            return SALTUS_STALLED;
        if (scale == 0 && !fits) {
            fits = true;
            linearise_here(radau, evaluations);
            continue;
        }
        /* A polynomial that is merely too coarse is a good guess for the shorter step. */
        follows = scale > 0;
        if (follows)
            keep_as_guess(radau, phase);
        radau->proposal = scale > 0 ? scale * radau->stages.step : 0.5 * radau->stages.step;
        k = grid_below(radau, radau->proposal);
    }
    emit(radau, work);
    if (!ends_finite(work))
        return SALTUS_STALLED;
    double step = radau->stages.step, grown = step * growth(errors);
    radau->proposal = step < radau->proposal ? fmax(radau->proposal, grown) : grown;
    if (radau->sweeps > sweeps_many && !fits)
        linearise_here(radau, evaluations);
    radau->steps++;
    keep_as_guess(radau, phase);
    return SALTUS_OK;
}
