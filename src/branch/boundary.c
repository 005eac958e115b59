/* Cycles that are born where an equilibrium meets a stop.
 *
 * Near there the flow is that of its Jacobian A around the equilibrium, and the impact keeps displacements
 * and maps velocities by a matrix R, so that cycles grow with the distance of the equilibrium from the stop
 * (di Bernardo, Nordmark & Olivar, Physica D 237 (2008) 119-136). A cycle with one impact in every period T
 * returns to its state y before the impact, relative to the equilibrium: exp(A T) R y = y. Such a y exists
 * where a determinant is zero. The sign with which y closes the gap tells on which side of the stop the
 * equilibrium lies; the flight in between shows whether y is a cycle.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/born.h"

#include "branch/sequence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The linear flow and the impact, in scaled states. */
typedef struct bounce {
    int n;
    double *linear, *impact, *step, *flow, *matrix; /* n x n: A, R, exp(A h), exp(A T), exp(A T) R - 1 */
    double *room;                                   /* 2 n x n */
    double row[SALTUS_STATE_MAX];                   /* normal of the face */
    double h, end; /* step between the periods T that are tried, and the last of them */
    saltus_dense_lu lu;
} bounce;

static void multiply(int rows, int inner, int columns, const double *a, const double *b, double *out) {
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) {
            out[i * columns + j] = 0;
            for (int k = 0; k < inner; k++)
                out[i * columns + j] += a[i * inner + k] * b[k * columns + j];
        }
}

/* out = exp(A time): its series over a short time, squared repeatedly. */
static void exponential(const bounce *b, double time, double *out) {
    enum { terms = 14 };
    const int n = b->n;
    double *term = b->room, *next = b->room + n * n, norm = 0;
    for (int k = 0; k < n * n; k++)
        norm = fmax(norm, n * fabs(b->linear[k] * time));
    const int squarings = norm > 0.25 ? (int)ceil(log2(norm / 0.25)) : 0;
    const double part = ldexp(time, -squarings);
    for (int k = 0; k < n * n; k++)
        out[k] = term[k] = k % (n + 1) == 0;
    for (int j = 1; j <= terms; j++) {
        multiply(n, n, n, b->linear, term, next);
        for (int k = 0; k < n * n; k++) {
            term[k] = next[k] * part / j;
            out[k] += term[k];
        }
    }
    for (int j = 0; j < squarings; j++) {
        multiply(n, n, n, out, out, next);
        memcpy(out, next, (size_t)(n * n) * sizeof *out);
    }
}

/* The sign of the determinant of exp(A T) R - 1, from `flow`, exp(A T). `matrix` is overwritten by it. */
static int sign_of(bounce *b) {
    multiply(b->n, b->n, b->n, b->flow, b->impact, b->matrix);
    for (int i = 0; i < b->n; i++)
        b->matrix[i * b->n + i] -= 1;
    saltus_dense_factor(&b->lu, b->matrix);
    return b->lu.sign;
}

/* Find the cycle of a period: `half` (n) becomes its state half a period after the impact, in units of the
 * gap between equilibrium and stop. Returns 1 if that gap is open, -1 if negative, 0 without such a cycle. */
static int find_cycle(bounce *b, double period, double *half, bool *starved) {
    enum { looks = 256 };
    const double grazing = 1e-6;
    const int n = b->n;
    double state[SALTUS_STATE_MAX], moved[SALTUS_STATE_MAX], value;
    exponential(b, period, b->flow);
    sign_of(b);
    const saltus_status status = saltus_dense_null_vectors(b->matrix, n, n, 1, state, &value);
    *starved |= status == SALTUS_NO_MEMORY;
    if (status != SALTUS_OK)
        return 0;
    /* Choose the sign of y so that the gap closes before the impact. */
    multiply(n, n, 1, b->linear, state, moved);
    const double gap = saltus_dot(b->row, state, n), speed = saltus_dot(b->row, moved, n);
    if (fabs(gap) < grazing || fabs(speed) * period < grazing)
        return 0;
    const double unit = copysign(fabs(gap), speed);
    for (int i = 0; i < n; i++)
        state[i] /= unit;
    const double reach = saltus_dot(b->row, state, n);
    multiply(n, n, 1, b->impact, state, moved);
    memcpy(state, moved, (size_t)n * sizeof *state);
    exponential(b, period / looks, b->flow);
    for (int k = 1; k < looks; k++) {
        multiply(n, n, 1, b->flow, state, moved);
        memcpy(state, moved, (size_t)n * sizeof *state);
        if (saltus_dot(b->row, state, n) >= reach)
            return 0;
        if (2 * k == looks)
            memcpy(half, state, (size_t)n * sizeof *half);
    }
    return reach > 0 ? 1 : -1;
}

/* The matrices, and the range of periods to try: a few turns of the slowest oscillation. */
static saltus_status open_bounce(bounce *b, saltus_rests *r, const saltus_rest *at, int face) {
    enum { looks_max = 4000 };
    const double *scale = r->state_scale;
    const size_t n = (size_t)r->n;
    int count;
    b->n = r->n;
    b->linear = calloc(7 * n * n, sizeof *b->linear);
    if (!b->linear || !saltus_dense_lu_open(&b->lu, b->n))
        return SALTUS_NO_MEMORY;
    b->impact = b->linear + n * n;
    b->step = b->impact + n * n;
    b->flow = b->step + n * n;
    b->matrix = b->flow + n * n;
    b->room = b->matrix + n * n;
    saltus_status status = saltus_rests_linear(r, at->at.u, NULL, 0, b->linear, &count, NULL);
    if (status != SALTUS_OK)
        return status;
    /* At the parameters at which the Jacobian was evaluated. */
    const saltus_system *system = r->system;
    const saltus_face f = saltus_system_face(system, face);
    const double *normal = saltus_system_stop_normal(system, f.stop);
    double slowest = INFINITY, fastest = 0;
    for (int k = 0; k < at->rate_count; k++) {
        if (at->rates[k].im > 0)
            slowest = fmin(slowest, at->rates[k].im);
        fastest = fmax(fastest, hypot(at->rates[k].re, at->rates[k].im));
    }
    b->end = isfinite(slowest) ? 3 * 2 * M_PI / slowest : 0;
    b->h = fmax(0.02 / fastest, b->end / looks_max);
    const double r0 = saltus_system_restitution(system, face, 0);
    for (int i = 0; i < b->n; i++) {
        b->row[i] = i < r->dof ? f.side * normal[i] * scale[i] : 0;
        for (int j = 0; j < b->n; j++) {
            const bool velocities = i >= r->dof && i < 2 * r->dof && j >= r->dof && j < 2 * r->dof;
            b->linear[i * b->n + j] *= scale[j] / scale[i];
            b->impact[i * b->n + j] = i == j;
            if (velocities)
                b->impact[i * b->n + j] -= (1 + r0) * system->stop_impulse[f.stop][i - r->dof] *
                                           normal[j - r->dof] * scale[j] / scale[i];
        }
    }
    return SALTUS_OK;
}

/* The parameter derivatives of the gap and of the equilibrium, `along` (n, scaled); NAN if there are none. */
static double gap_slope(saltus_rests *r, const saltus_rest *at, int face, double *along, saltus_rest *near) {
    const double apart = 1e-6;
    if (saltus_rests_noted(r, saltus_rest_visit(r, at, apart, near, NULL)) != SALTUS_OK)
        return NAN;
    const double ahead = near->parameter[0] - at->parameter[0];
    for (int i = 0; i < r->n; i++)
        along[i] = (near->state[i] - at->state[i]) / r->state_scale[i] / ahead;
    return fabs(ahead) > 1e-3 * apart ? (near->gap[face] - at->gap[face]) / ahead : NAN;
}

void saltus_boundary_leave(saltus_rests *r, const saltus_rest *at, int face, const saltus_branch_start *like,
                           saltus_rest *scratch, saltus_starts *starts) {
    bounce b = {.n = 0};
    saltus_branch_start start = *like;
    double along[SALTUS_STATE_MAX], half[SALTUS_STATE_MAX], tangent[SALTUS_STATE_MAX + 3] = {0};
    if (at->contacts)
        return;
    const double slope = gap_slope(r, at, face, along, scratch);
    saltus_status status = open_bounce(&b, r, at, face);
    start.tangent = tangent;
    start.unknowns = r->n + 3; /* of a cycle with one impact; those beyond the state are unused */
    start.sequence = (saltus_sequence){.periods = 1, .cuts = 1, .count = 1};
    start.sequence.mark[0] = (saltus_mark){SALTUS_IMPACT, face, 0.5, false};
    if (status == SALTUS_OK)
        exponential(&b, b.h, b.step);
    if (status == SALTUS_OK)
        memcpy(b.flow, b.step, (size_t)(b.n * b.n) * sizeof *b.flow);
    int before = 0;
    for (int k = 1; k * b.h < b.end && isfinite(slope) && slope != 0 && status == SALTUS_OK; k++) {
        const int sign = sign_of(&b);
        if (before * sign < 0) {
            double low = (k - 1) * b.h, period = k * b.h;
            for (double middle = 0.5 * (low + period); middle > low && middle < period;
                 middle = 0.5 * (low + period)) {
                exponential(&b, middle, b.flow);
                *(sign_of(&b) == before ? &low : &period) = middle;
            }
            const int side = find_cycle(&b, period, half, &r->starved);
            start.heading = side * slope > 0 ? -1 : 1;
            for (int i = 0; i < r->n; i++)
                tangent[i] = along[i] + start.heading * fabs(slope) * half[i];
            start.sequence.omega = 2 * M_PI / period;
            if (side)
                saltus_starts_add(starts, &start, &r->starved);
            exponential(&b, k * b.h, b.flow);
        }
        before = sign;
        multiply(b.n, b.n, b.n, b.flow, b.step, b.matrix);
        memcpy(b.flow, b.matrix, (size_t)(b.n * b.n) * sizeof *b.flow);
    }
    saltus_dense_lu_close(&b.lu);
    free(b.linear);
    saltus_rests_noted(r, status);
}

/* `out` becomes the cycle of a sequence through a state near it, polished; it is anchored across the flow at
 * that state. */
static saltus_status place_across(saltus_orbits *o, saltus_sequence *sequence, double parameter,
                                  const double *state, saltus_solution *out, saltus_message *message) {
    const saltus_time base = saltus_time_of(sequence->base);
    saltus_status status = saltus_orbits_tune(o, &parameter, sequence->omega, message);
    if (status == SALTUS_OK)
        status = saltus_flow_place(o->flow, 0, base, state, sequence->contacts, message);
    if (status != SALTUS_OK)
        return status;
    saltus_sequence_anchor(sequence, o->flow, false);
    return saltus_solution_place(o, sequence, &parameter, state, true, out, message);
}

saltus_status saltus_boundary_cycle(saltus_orbits *o, const saltus_branch_start *start, double distance,
                                    saltus_solution *out, saltus_message *message) {
    const double apart = start->heading * distance;
    saltus_sequence sequence = start->sequence;
    double state[SALTUS_STATE_MAX];
    saltus_status status = saltus_shooting_shape(o->shooting, &sequence, message);
    for (int i = 0; i < o->n && status == SALTUS_OK; i++)
        state[i] = start->state[i] + apart * start->tangent[i] * o->shooting->scale[i];
    if (status == SALTUS_OK)
        status = place_across(o, &sequence, start->parameter[0] + apart, state, out, message);
    if (status == SALTUS_OK && !(saltus_solution_walk(o, out) && out->worst.value < 0 && out->survey.follows))
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "the flow follows no such orbit");
    if (status == SALTUS_OK)
        saltus_solution_head(out, start->heading);
    return status;
}

/* The scaled speed of a cycle's fastest impact; INFINITY where none is prescribed. */
static double impact_speed(const saltus_solution *s) {
    double slowest, fastest;
    return saltus_solution_speed_range(s, &slowest, &fastest) && s->sequence.omega > 0 ? fastest : INFINITY;
}

/* The state in the middle of a cycle's longest flight between impacts, a point that such cycles have in
 * common, and the sequence from there. */
static saltus_status cut_in_flight(saltus_orbits *o, const saltus_solution *s, saltus_sequence *fresh,
                                   double *state) {
    const double time = saltus_sequence_amid_flight(&s->sequence);
    saltus_sequence_turn(&s->sequence, time, 1, fresh, NULL);
    return saltus_solution_state_at(o, s, time, state, NULL);
}

bool saltus_boundary_reach(saltus_orbits *o, const saltus_solution *here, const saltus_solution *next,
                           saltus_solution *at, saltus_zero *zero, double *value) {
    enum { rounds = 5 };
    const double nearer = 0.2, small = 1e-2;
    const int n = o->n;
    double state[2][SALTUS_STATE_MAX], guess[SALTUS_STATE_MAX];
    double place[2] = {here->parameter[0], next->parameter[0]};
    double size[2] = {impact_speed(here), impact_speed(next)}, end = NAN, before = NAN;
    saltus_sequence sequence;
    if (!(size[1] < small && size[1] < size[0] && saltus_solution_way(next) < small))
        return false;
    bool sound = cut_in_flight(o, here, &sequence, state[0]) == SALTUS_OK &&
                 cut_in_flight(o, next, &sequence, state[1]) == SALTUS_OK;
    for (int k = 0; k <= rounds && sound; k++) {
        before = end;
        end = place[1] + (place[1] - place[0]) * size[1] / (size[0] - size[1]);
        if (k == rounds)
            break;
        const double to = end + nearer * (place[1] - end), ahead = (to - place[1]) / (place[1] - place[0]);
        for (int i = 0; i < n; i++)
            guess[i] = state[1][i] + ahead * (state[1][i] - state[0][i]);
        const saltus_status status = place_across(o, &sequence, to, guess, at, NULL);
        sound = saltus_orbits_noted(o, status) == SALTUS_OK && impact_speed(at) < 0.5 * size[1];
        memcpy(state[0], state[1], (size_t)n * sizeof *state[0]);
        place[0] = place[1];
        size[0] = size[1];
        place[1] = to;
        size[1] = sound ? impact_speed(at) : NAN;
        /* For the converged cycle again the state at the same place of the orbit. */
        sound = sound && cut_in_flight(o, at, &sequence, state[1]) == SALTUS_OK;
    }
    const double unit = o->family.unit[0], way = next->parameter[0] - here->parameter[0];
    *zero = (saltus_zero){.found = sound, .accuracy = unit * fabs(end - before)};
    zero->ahead = next->at.ahead * (end - here->parameter[0]) / way;
    *value = o->origin + unit * end;
    if (sound && fabs(end - before) < 1e-3 && zero->ahead > 0)
        return true;
    saltus_orbits_reshape(o, here);
    return false;
}
