/* Curves of solutions, by pseudo-arclength.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/curve.h"

#include <gsl/gsl_errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double step_min = 1e-7, turn_min = 0.92; /* least cosine between tangents a step apart */

saltus_status saltus_branch_no_memory(saltus_message *message) {
    return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
}

double saltus_scaled_in(saltus_scaled number, double exponent) {
    return number.mantissa * exp(fmin(number.exponent - exponent, 600));
}

bool saltus_curve_reserve(saltus_curve_point *point, int unknowns) {
    double **arrays[] = {&point->u, &point->tangent, &point->bend};
    point->unknowns = unknowns;
    point->bent = false;
    for (int k = 0; k < 3 && unknowns > point->room; k++) {
        double *grown = realloc(*arrays[k], (k == 2 ? 2 : 1) * (size_t)unknowns * sizeof *grown);
        if (!grown)
            return false;
        *arrays[k] = grown;
    }
    point->room = unknowns > point->room ? unknowns : point->room;
    return true;
}

bool saltus_curve_copy(const saltus_curve_point *point, saltus_curve_point *copy) {
    const size_t size = (size_t)point->unknowns * sizeof *point->u;
    if (!saltus_curve_reserve(copy, point->unknowns))
        return false;
    memcpy(copy->u, point->u, size);
    memcpy(copy->tangent, point->tangent, size);
    copy->ahead = point->ahead;
    return true;
}

void saltus_curve_clear(saltus_curve_point *point) {
    free(point->u);
    free(point->tangent);
    free(point->bend);
    *point = (saltus_curve_point){0};
}

void saltus_curve_turn(saltus_curve_point *point) {
    for (int j = 0; j < point->unknowns; j++)
        point->tangent[j] = -point->tangent[j];
    point->crossing.mantissa = -point->crossing.mantissa;
    point->bent = false;
}

void saltus_curve_bend(const saltus_curve_point *before, saltus_curve_point *point) {
    double apart = 0;
    for (int j = 0; j < point->unknowns; j++)
        apart = hypot(apart, point->u[j] - before->u[j]);
    for (int j = 0; j < point->unknowns; j++) {
        double aside = before->u[j] - point->u[j] + apart * point->tangent[j];
        double turn = before->tangent[j] - point->tangent[j];
        double cube = (turn + 2 * aside / apart) / (apart * apart);
        point->bend[j] = aside / (apart * apart) + cube * apart;
        point->bend[point->unknowns + j] = cube;
    }
    point->bent = apart > 0;
}

/* The left null vector (m numbers, of which the last is 0) of the Jacobian last evaluated, whose null plane
 * contains `other`; a: room for m x m. */
static saltus_status find_left(const saltus_equations *e, const double *other, double *a, double *left) {
    const int m = e->unknowns;
    double value;
    for (int k = 0; k < m * m; k++)
        a[k] = k % m < e->count ? e->jacobian[k % m * m + k / m] : other[k / m];
    return saltus_dense_null_vectors(a, m, m, 1, left, &value);
}

/* The derivative along v of w' J, to `out` (m), as a difference to both sides of u. */
static saltus_status bend_along(saltus_equations *e, const double *u, const double *v, const double *w,
                                double *aside, double *out, saltus_message *message) {
    const double apart = 1e-5;
    const int m = e->unknowns;
    saltus_status status = SALTUS_OK;
    memset(out, 0, (size_t)m * sizeof *out);
    for (int side = -1; side <= 1 && status == SALTUS_OK; side += 2) {
        for (int j = 0; j < m; j++)
            aside[j] = u[j] + side * apart * v[j];
        status = saltus_equations_evaluate(e, aside, message);
        for (int k = 0; k < e->count * m && status == SALTUS_OK; k++)
            out[k % m] += side * 0.5 / apart * w[k / m] * e->jacobian[k];
    }
    return status;
}

saltus_status saltus_curve_leaving(saltus_equations *e, const double *u, const double *along, double *leaving,
                                   double *singular, saltus_message *message) {
    const double apart = 1e-5, nothing = 1e-8;
    const int m = e->unknowns, c = e->count;
    double values[2] = {0}, form[2] = {0}, *a = calloc((size_t)(m * (m + 4)), sizeof *a);
    double *one = a ? a + m * m : NULL, *other = one ? one + m : NULL, *left = one ? other + m : NULL,
           *aside = one ? left + m : NULL;
    saltus_status status = a ? saltus_equations_evaluate(e, u, message) : SALTUS_NO_MEMORY;
    if (status == SALTUS_OK)
        status = saltus_null_plane(e, one, values, message);
    const double turn =
        status == SALTUS_OK ? atan2(saltus_dot(other, along, m), saltus_dot(one, along, m)) : 0;
    for (int j = 0; j < m && status == SALTUS_OK; j++) {
        const double first = one[j], second = other[j];
        one[j] = cos(turn) * first + sin(turn) * second;
        other[j] = cos(turn) * second - sin(turn) * first;
    }
    if (status == SALTUS_OK)
        status = find_left(e, other, a, left);
    for (int side = -1; side <= 1 && status == SALTUS_OK; side += 2) {
        for (int j = 0; j < m; j++)
            aside[j] = u[j] + side * apart * other[j];
        status = saltus_equations_evaluate(e, aside, message);
        for (int i = 0; i < c && status == SALTUS_OK; i++) {
            form[0] += side * left[i] * saltus_dot(e->jacobian + i * m, one, m);
            form[1] += side * left[i] * saltus_dot(e->jacobian + i * m, other, m);
        }
    }
    const bool told = fabs(form[0]) > nothing * (fabs(form[1]) + 2 * apart);
    for (int j = 0; j < m && status == SALTUS_OK; j++)
        leaving[j] = other[j] - (told ? 0.5 * form[1] / form[0] : 0) * one[j];
    if (status == SALTUS_OK)
        saltus_make_unit(leaving, m);
    if (singular)
        *singular = values[1];
    free(a);
    return status == SALTUS_NO_MEMORY ? saltus_branch_no_memory(message) : status;
}

/* The search for a crossing: borders, solutions of the bordered systems, and room. */
typedef struct settling {
    saltus_dense_lu lu;
    double *matrix, *plane, *b, *v, *w, *step, *aside;
    double off; /* the unknown that multiplies b */
} settling;

/* Newton's step from the point last evaluated. */
static saltus_status settling_step(saltus_equations *e, settling *s, const double *u) {
    const int m = e->unknowns, c = e->count, size = m + 1;
    saltus_status status = SALTUS_OK;
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++)
            s->matrix[i * size + j] = i < c   ? (j < m ? e->jacobian[i * m + j] : s->b[i])
                                      : j < m ? s->plane[(i - c) * m + j]
                                              : 0;
    memset(s->v, 0, 3 * (size_t)size * sizeof *s->v);
    s->v[c] = s->v[size + c + 1] = s->w[m] = 1;
    if (!saltus_dense_factor(&s->lu, s->matrix))
        return SALTUS_SINGULAR;
    saltus_dense_resolve(&s->lu, false, 2, s->v);
    saltus_dense_resolve(&s->lu, true, 1, s->w);
    for (int i = 0; i < c; i++)
        s->step[i] = -e->residual[i] - s->off * s->b[i];
    for (int k = 0; k < 2 && status == SALTUS_OK; k++) {
        s->step[c + k] = s->v[k * size + m];
        status = bend_along(e, u, s->v + k * size, s->w, s->aside, s->matrix + (c + k) * size, NULL);
        s->matrix[(c + k) * size + m] = 0;
    }
    if (status == SALTUS_OK && !saltus_dense_factor(&s->lu, s->matrix))
        return SALTUS_SINGULAR;
    if (status == SALTUS_OK)
        saltus_dense_resolve(&s->lu, false, 1, s->step);
    return status;
}

saltus_status saltus_curve_settle(saltus_equations *e, double *u, double *error) {
    enum { rounds = 8 };
    const double sharp = 1e-9, nothing = 1e-14;
    const int m = e->unknowns, size = m + 1;
    double values[2], best = INFINITY;
    settling s = {.matrix = calloc((size_t)(size * (size + 8)), sizeof *s.matrix)};
    if (!s.matrix || !saltus_dense_lu_open(&s.lu, size)) {
        free(s.matrix);
        return SALTUS_NO_MEMORY;
    }
    s.v = s.matrix + size * size;
    s.w = s.v + 2 * size;
    s.plane = s.w + size;
    s.b = s.plane + 2 * size;
    s.step = s.b + size;
    s.aside = s.step + size;
    saltus_status status = saltus_equations_evaluate(e, u, NULL);
    if (status == SALTUS_OK)
        status = saltus_null_plane(e, s.plane, values, NULL);
    if (status == SALTUS_OK)
        status = find_left(e, s.plane + m, s.matrix, s.b);
    for (int round = 0; round < rounds && status == SALTUS_OK && best > nothing; round++) {
        status = settling_step(e, &s, u);
        const double length = saltus_length(s.step, m);
        if (status != SALTUS_OK || !(length < best))
            break;
        best = length;
        *error = fabs(s.step[m - 1]);
        s.off += s.step[m];
        for (int j = 0; j < m; j++)
            u[j] += s.step[j];
        status = saltus_equations_evaluate(e, u, NULL);
    }
    saltus_dense_lu_close(&s.lu);
    free(s.matrix);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(e, u, NULL);
    if (status == SALTUS_OK && !(best < sharp && e->size <= e->tolerance))
        return SALTUS_NO_CONVERGENCE;
    return status;
}

double saltus_curve_interpolate(const double *x, const double *y, int count) {
    double p[8];
    memcpy(p, y, (size_t)count * sizeof *p);
    for (int level = 1; level < count; level++)
        for (int k = 0; k + level < count; k++)
            p[k] = (x[k + level] * p[k] - x[k] * p[k + 1]) / (x[k + level] - x[k]);
    return p[0];
}

void saltus_curve_align(saltus_curve_point *point, const double *guide) {
    if (saltus_dot(guide, point->tangent, point->unknowns) < 0)
        saltus_curve_turn(point);
}

saltus_status saltus_curve_orient(saltus_equations *e, const double *guide, saltus_curve_point *point,
                                  saltus_message *message) {
    int sign, m = point->unknowns;
    double values[2], *plane = guide ? NULL : calloc(2 * (size_t)m, sizeof *plane);
    saltus_status status = SALTUS_OK;
    if (!guide)
        status = plane ? saltus_null_plane(e, plane, values, message) : saltus_branch_no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_curve_tangent(e, guide ? guide : plane, point->tangent, &sign,
                                      &point->crossing.exponent, message);
    free(plane);
    point->crossing.mantissa = status == SALTUS_OK ? sign : NAN;
    point->residual = e->size;
    return status;
}

/* Unknown j this far ahead, along the tangent and the bend. */
static double place_ahead(const saltus_curve_point *from, int j, double ahead) {
    const double straight = fma(ahead, from->tangent[j], from->u[j]);
    return from->bent ? straight + ahead * ahead * fma(ahead, from->bend[from->unknowns + j], from->bend[j])
                      : straight;
}

/* The point straight ahead to to->tangent, which is free until the tangent is known, and the prediction along
 * the bend to to->u. */
static void predict(const saltus_curve_point *from, double ahead, saltus_curve_point *to) {
    for (int j = 0; j < from->unknowns; j++) {
        to->tangent[j] = fma(ahead, from->tangent[j], from->u[j]);
        to->u[j] = place_ahead(from, j, ahead);
    }
    to->ahead = ahead;
}

/* Correct a prediction in the hyperplane through the point straight ahead. */
static saltus_status correct(saltus_equations *e, const saltus_curve_point *from, const double *normal,
                             saltus_curve_point *to, saltus_message *message) {
    saltus_status status = saltus_newton(e, to->u, normal, to->tangent, false, &to->iterations, message);
    return status == SALTUS_OK ? saltus_curve_orient(e, from->tangent, to, message) : status;
}

saltus_status saltus_curve_visit(saltus_equations *e, const saltus_curve_point *from, double ahead,
                                 saltus_curve_point *to, saltus_message *message) {
    if (!saltus_curve_reserve(to, from->unknowns))
        return saltus_branch_no_memory(message);
    predict(from, ahead, to);
    return correct(e, from, from->tangent, to, message);
}

saltus_status saltus_curve_meet(saltus_equations *e, const saltus_curve_point *from, int k, double value,
                                saltus_curve_point *to, saltus_message *message) {
    int m = from->unknowns;
    double ahead = (value - from->u[k]) / from->tangent[k];
    double *normal = calloc((size_t)m, sizeof *normal);
    if (!normal || !saltus_curve_reserve(to, m)) {
        free(normal);
        return saltus_branch_no_memory(message);
    }
    normal[k] = 1;
    predict(from, ahead, to);
    /* Meet the value exactly: the equations may not be defined beyond it. There are few such points, and the
     * equations may be singular there, so each iteration uses its own Jacobian. */
    const bool hasty = e->hasty;
    e->hasty = false;
    to->u[k] = to->tangent[k] = value;
    saltus_status status = correct(e, from, normal, to, message);
    e->hasty = hasty;
    free(normal);
    to->u[k] = value; /* Newton's last step may have left a rounding */
    to->ahead = saltus_dot(to->u, from->tangent, m) - saltus_dot(from->u, from->tangent, m);
    return status;
}

saltus_status saltus_curve_revisit(saltus_equations *e, const saltus_curve_point *from, double ahead,
                                   saltus_curve_point *point) {
    const double least = 1e-4; /* in shorter steps rounding would bend the curve */
    const double rest = (ahead - point->ahead) / saltus_dot(from->tangent, point->tangent, from->unknowns);
    if (point->ahead > least)
        saltus_curve_bend(from, point);
    double off = 0; /* of the plane in which the point lies, because the curve bends */
    for (int j = 0; j < from->unknowns; j++) {
        point->u[j] = place_ahead(point, j, rest);
        point->tangent[j] = fma(ahead, from->tangent[j], from->u[j]);
        off += from->tangent[j] * (point->u[j] - point->tangent[j]);
    }
    for (int j = 0; j < from->unknowns; j++)
        point->u[j] -= off * from->tangent[j];
    point->ahead = ahead;
    point->bent = false;
    return correct(e, from, from->tangent, point, NULL);
}

bool saltus_curve_strays(const saltus_curve_point *from, const saltus_curve_point *to) {
    const double far = 1.08, least = 1e-6;
    double distance = 0;
    for (int j = 0; j < to->unknowns; j++)
        distance = hypot(distance, to->u[j] - from->u[j]);
    return distance > far * fabs(to->ahead) + least;
}

/* The point at which unknown k equals `value` although the equations are singular there: extrapolated from
 * points before it, and judged by its residual. */
static saltus_status approach(saltus_equations *e, const saltus_curve_point *from, int k, double value,
                              saltus_curve_point *to, saltus_message *message) {
    enum { samples = 6 };
    int m = from->unknowns;
    double apart = 1e-2 * (from->u[k] - value), place[samples], *u = calloc((size_t)(m * samples), sizeof *u);
    saltus_status status = u ? SALTUS_OK : saltus_branch_no_memory(message);
    for (int j = 0; j < samples && status == SALTUS_OK; j++) {
        place[j] = (samples - j) * apart;
        status = saltus_curve_meet(e, from, k, value + place[j], to, message);
        for (int i = 0; i < m; i++)
            u[i * samples + j] = to->u[i];
    }
    /* The tangent remains that of the last of these points. */
    for (int i = 0; i < m && status == SALTUS_OK; i++)
        to->u[i] = saltus_curve_interpolate(place, u + (ptrdiff_t)i * samples, samples);
    free(u);
    if (status != SALTUS_OK)
        return status;
    to->u[k] = value;
    to->ahead = saltus_dot(to->u, from->tangent, m) - saltus_dot(from->u, from->tangent, m);
    to->crossing.mantissa = NAN;
    status = saltus_equations_evaluate(e, to->u, message);
    to->residual = e->size;
    if (status == SALTUS_OK && !(e->size <= e->tolerance))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "the branch does not reach the border");
    return status;
}

/* Whether a step needs no repetition: it has led on along the curve without a large turn, or has failed in a
 * way that no shorter step can mend. */
static bool is_done(saltus_status status, const saltus_curve_point *from, double step,
                    const saltus_curve_point *to) {
    if (status != SALTUS_OK)
        return status == SALTUS_NO_MEMORY || status == SALTUS_INTERRUPTED;
    return to->ahead > 0 && to->ahead < 2 * step &&
           saltus_dot(from->tangent, to->tangent, to->unknowns) > turn_min;
}

/* Whether a value is outside a bound; *border: on which side. */
static bool is_outside(const saltus_curve_bound *bound, double value, double *border) {
    *border = value < bound->low ? bound->low : bound->high;
    return value < bound->low || value > bound->high;
}

/* The border of a bound towards which the curve leads. */
static double border_ahead(const saltus_curve_bound *bound, const saltus_curve_point *from) {
    return from->tangent[bound->unknown] > 0 ? bound->high : bound->low;
}

/* One attempt at a step: a full step, or one to the first border on the way. */
static saltus_status attempt(saltus_equations *e, const saltus_curve_point *from, double step,
                             const saltus_curve_bound *bounds, int bound_count, saltus_curve_point *to,
                             int *reached, saltus_message *message) {
    double first = step, border;
    *reached = -1;
    for (int b = 0; b < bound_count; b++) {
        int k = bounds[b].unknown;
        if (is_outside(&bounds[b], fma(step, from->tangent[k], from->u[k]), &border) &&
            (border - from->u[k]) / from->tangent[k] <= first) {
            first = (border - from->u[k]) / from->tangent[k];
            *reached = b;
        }
    }
    const saltus_curve_bound *met = *reached < 0 ? NULL : &bounds[*reached];
    saltus_status status =
        met ? saltus_curve_meet(e, from, met->unknown, border_ahead(met, from), to, message)
            : saltus_curve_visit(e, from, step, to, message);
    /* The curve bends: it may cross a border that its tangent does not cross, or crosses later. */
    for (int b = 0; b < bound_count && status == SALTUS_OK; b++)
        if (b != *reached && is_outside(&bounds[b], to->u[bounds[b].unknown], &border)) {
            *reached = b;
            status = saltus_curve_meet(e, from, bounds[b].unknown, border, to, message);
        }
    return status;
}

saltus_status saltus_curve_step(saltus_equations *e, const saltus_curve_point *from, double *step,
                                const saltus_curve_bound *bounds, int bound_count, saltus_curve_point *to,
                                int *reached, saltus_message *message) {
    for (;; *step *= 0.5) {
        saltus_status status = attempt(e, from, *step, bounds, bound_count, to, reached, message);
        if (is_done(status, from, *step, to))
            return status;
        if (*reached >= 0) {
            const saltus_curve_bound *bound = &bounds[*reached];
            status = approach(e, from, bound->unknown, border_ahead(bound, from), to, message);
            if (is_done(status, from, *step, to))
                return status;
        }
        if (*step < step_min)
            return status == SALTUS_OK
                       ? saltus_fail(message, SALTUS_NO_CONVERGENCE, "the branch has a corner")
                       : status;
    }
}

double saltus_curve_next_step(double step, int iterations, double largest) {
    double factor = iterations <= 3 ? 1.5 : iterations > 5 ? 0.6 : 1;
    return fmin(factor * step, largest);
}

bool saltus_curve_dips(const double place[3], const double value[3], double deep, double *lowest) {
    const double first = (value[1] - value[0]) / (place[1] - place[0]),
                 second = (value[2] - value[1]) / (place[2] - place[1]),
                 bend = (second - first) / (place[2] - place[0]), reach = bend * (place[2] - place[1]);
    const double side = value[1] > 0 ? 1 : -1, least = fmin(side * value[1], side * value[2]);
    const bool turns = least > 0 && side * (second - reach) < 0 && side * (second + reach) > 0;
    *lowest = turns ? place[1] - (second - reach) / (2 * bend) : NAN;
    return turns && side * value[1] - (second - reach) * (second - reach) / (4 * fabs(bend)) < deep * least;
}

/* The search for a zero. */
typedef struct search {
    saltus_curve_function *function;
    void *context;
    const double *ends, *values; /* ends of the first bracket, and the values there */
    double value;                /* the last value computed */
    bool failed;
} search;

static double value_at(double ahead, void *context) {
    search *s = context;
    for (int k = 0; k < 2; k++)
        if (ahead == s->ends[k])
            return s->values[k];
    s->failed = s->failed || !s->function(s->context, ahead, &s->value) || !isfinite(s->value);
    return s->failed ? 0 : s->value;
}

bool saltus_curve_zero(gsl_root_fsolver *solver, saltus_curve_function *function, void *context,
                       const double ends[2], const double values[2], double *place, double *width) {
    enum { evaluations_max = 60 };
    search s = {.function = function, .context = context, .ends = ends, .values = values, .value = values[1]};
    gsl_function called = {.function = value_at, .params = &s};
    *width = INFINITY;
    /* A product might underflow. */
    if (!((values[0] < 0 && values[1] > 0) || (values[0] > 0 && values[1] < 0)))
        return false;
    bool going =
        gsl_root_fsolver_set(solver, &called, fmin(ends[0], ends[1]), fmax(ends[0], ends[1])) == GSL_SUCCESS;
    for (int k = 0; k < evaluations_max && going && !s.failed; k++) {
        going = gsl_root_fsolver_iterate(solver) == GSL_SUCCESS;
        *place = gsl_root_fsolver_root(solver);
        *width = gsl_root_fsolver_x_upper(solver) - gsl_root_fsolver_x_lower(solver);
        going = going && *width > 1e-13 * fmax(1, fabs(*place)) && s.value != 0;
    }
    if (s.value == 0)
        *width = 0;
    return !s.failed;
}

bool saltus_curve_cross(saltus_curve_function *function, void *context, const saltus_curve_point *from,
                        const saltus_curve_point *at, double middle, double apart, double *work,
                        double *ahead, double *spread) {
    enum { samples = 6 };
    static const double place[samples] = {-1, 1, -2, 2, -3, 3};
    const int m = from->unknowns;
    double test[samples], *u = work + m;
    for (int k = 0; k < samples; k++) {
        if (!function(context, middle + place[k] * apart, &test[k]))
            return false;
        for (int j = 0; j < m; j++)
            u[j * samples + k] = at->u[j];
        if (k % 2 && !(test[k] * test[k - 1] < 0))
            return false;
    }
    *ahead = 0;
    for (int j = 0; j < m; j++) {
        work[j] = saltus_curve_interpolate(test, u + (ptrdiff_t)j * samples, samples);
        *ahead += (work[j] - from->u[j]) * from->tangent[j];
    }
    *spread =
        fabs(work[m - 1] - saltus_curve_interpolate(test, u + (ptrdiff_t)(m - 1) * samples, samples - 2));
    return true;
}

saltus_status saltus_curve_crossing(saltus_equations *e, saltus_curve_function *function, void *context,
                                    const saltus_curve_point *from, double ahead, double reach, bool settles,
                                    saltus_curve_point *at, double *accuracy) {
    enum { passes = 6 };
    /* At distance d from the place, where the equations are singular, points are known to rounding / d. */
    const double sharp = 1e-11, rounding = 1e-14;
    const size_t m = (size_t)from->unknowns;
    double spread, error, apart = 0.1 * reach, *work = calloc(8 * m, sizeof *work),
                          *best = work ? work + 7 * m : NULL;
    bool found = false, settled = false;
    saltus_status status = work ? SALTUS_NO_CONVERGENCE : SALTUS_NO_MEMORY;
    *accuracy = INFINITY;
    /* Come closer until Newton's method for a crossing converges. At an equilibrium more curves of orbits
     * meet than two: there come closer until the result is accurate enough, or rounding, which grows towards
     * the place, outweighs the curvature. */
    for (int pass = 0; pass < passes && status != SALTUS_NO_MEMORY && !settled; pass++) {
        if ((pass > 1 && !(*accuracy > sharp)) ||
            !saltus_curve_cross(function, context, from, at, ahead, apart, work, &ahead, &spread))
            break;
        const double known = fmax(spread, rounding / fabs(apart));
        if (pass > 1 && !(known < *accuracy))
            break;
        found = pass > 0;
        *accuracy = known;
        memcpy(best, work, m * sizeof *best);
        if (found && settles)
            status = saltus_curve_settle(e, work, &error);
        double moved = 0;
        for (size_t j = 0; j < m; j++)
            moved = hypot(moved, work[j] - best[j]);
        settled = status == SALTUS_OK && moved < apart;
        if (settled) {
            memcpy(best, work, m * sizeof *best);
            *accuracy = error;
        }
        apart = pass == 0 ? fmin(4e-4, apart) : apart / 4;
    }
    at->ahead = 0;
    for (size_t j = 0; j < m && found; j++) {
        at->u[j] = best[j];
        at->ahead += (best[j] - from->u[j]) * from->tangent[j];
    }
    if (found && status != SALTUS_NO_MEMORY)
        status = saltus_equations_evaluate(e, at->u, NULL);
    free(work);
    return status;
}
