/* The equations of an orbit with one more that makes it special.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/extended.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void saltus_extended_close(saltus_extended *x) {
    saltus_arena_close(&x->arena);
    x->arena = (saltus_arena){0};
    saltus_dense_lu_close(&x->lu);
    saltus_dense_lu_close(&x->equations.lu);
}

saltus_status saltus_extended_shape(saltus_extended *x, saltus_message *message) {
    const int count = x->orbits.equations->count;
    const size_t m = (size_t)count + 2, c = (size_t)count,
                 k = (size_t)(x->kind == SALTUS_POINT_GR ? 0 : x->copies), order = k * (c + 1);
    saltus_extended_close(x);
    do {
        saltus_equations_reserve(&x->equations, count + 2 + x->extra, &x->arena);
        x->matrix = saltus_arena_doubles(&x->arena, order * order);
        x->right = saltus_arena_doubles(&x->arena, order);
        x->left = saltus_arena_doubles(&x->arena, k * order);
        x->b = saltus_arena_doubles(&x->arena, k * c);
        x->c = saltus_arena_doubles(&x->arena, k * c);
        x->folding[0] = saltus_arena_doubles(&x->arena, c);
        x->folding[1] = saltus_arena_doubles(&x->arena, c);
        x->aside = saltus_arena_doubles(&x->arena, m);
        x->along = saltus_arena_doubles(&x->arena, k * c * m);
        x->fresh = saltus_arena_doubles(&x->arena, k * c * m);
        x->anchor = saltus_arena_doubles(&x->arena, m);
        x->points = saltus_arena_doubles(&x->arena, (SALTUS_SAMPLES_MOST + 2) * (m + (size_t)x->extra));
        x->kept = saltus_arena_doubles(&x->arena, 3 * (m + (size_t)x->extra));
    } while (saltus_arena_again(&x->arena));
    if (!x->arena.base || (order && !saltus_dense_lu_open(&x->lu, (int)order)) ||
        !saltus_dense_lu_open(&x->equations.lu, count + 2 + x->extra))
        return saltus_branch_no_memory(message);
    x->differs = x->folds = false;
    return SALTUS_OK;
}

saltus_status saltus_extended_open_other(const saltus_extended *x, saltus_extended *other) {
    const size_t c = (size_t)x->orbits.equations->count,
                 size = x->kind == SALTUS_POINT_GR ? 0 : (size_t)x->copies * c;
    *other = *x;
    other->arena = (saltus_arena){0};
    other->lu = other->equations.lu = (saltus_dense_lu){0};
    other->equations.self = other;
    saltus_status status = saltus_orbits_open_other(&x->orbits, &other->orbits);
    if (status == SALTUS_OK)
        status = saltus_shooting_shape(other->orbits.shooting, &x->orbits.shooting->sequence, NULL);
    if (status == SALTUS_OK)
        status = saltus_extended_shape(other, NULL);
    if (status != SALTUS_OK)
        return saltus_orbits_noted(&other->orbits, status);
    memcpy(other->b, x->b, size * sizeof *x->b);
    memcpy(other->c, x->c, size * sizeof *x->c);
    memcpy(other->anchor, x->anchor, (c + 2) * sizeof *x->anchor);
    for (int k = 0; k < 2; k++)
        memcpy(other->folding[k], x->folding[k], c * sizeof *x->b);
    other->folds = x->folds;
    return SALTUS_OK;
}

void saltus_extended_close_other(saltus_extended *x, saltus_extended *other) {
    x->orbits.starved |= other->orbits.starved;
    saltus_extended_close(other);
    saltus_orbits_close(&other->orbits);
}

/* A without borders, in real form, in rows of `stride` numbers: the closing rows get 1 - e^{i theta} times
 * the state at the base added. Where orbits that are their own mirror images fold, too, it is made regular
 * for those. */
static void fill_singular(const saltus_extended *x, double theta, double *a, int stride) {
    const saltus_equations *e = x->orbits.equations;
    int c = e->count, n = x->orbits.n, row = saltus_shooting_closing_row(x->orbits.shooting);
    const bool turns = x->kind == SALTUS_POINT_NS;
    const double re = x->kind == SALTUS_POINT_PD ? 2
                      : turns                    ? 1 - cos(theta)
                                                 : 0,
                 im = turns ? -sin(theta) : 0;
    for (int k = 0; k < x->copies; k++) {
        for (int i = 0; i < c; i++)
            for (int j = 0; j < x->copies * c; j++)
                a[(k * c + i) * stride + j] = j / c == k ? e->jacobian[i * e->unknowns + j % c] : 0;
        for (int i = 0; i < n; i++) {
            a[(k * c + row + i) * stride + k * c + i] += re;
            if (x->copies == 2)
                a[(k * c + row + i) * stride + (1 - k) * c + i] += k ? im : -im;
        }
    }
    for (int i = 0; i < c && x->folds; i++)
        for (int j = 0; j < c; j++)
            a[i * stride + j] += x->folding[1][i] * x->folding[0][j];
}

/* Where the parts of a vector of unknowns, or of equations, that belong to two halves of an orbit which is
 * its own mirror image tell whether it is of the kind that is followed: they are alike then, the states of a
 * branch point as well as the times of a fold. Returns their length, 0: they do not tell. */
static int halves_of(const saltus_extended *x, int *first) {
    const saltus_sequence *s = &x->orbits.shooting->sequence;
    const bool folds = x->kind == SALTUS_POINT_LP && s->count % 2 == 0;
    *first = folds ? x->orbits.n * s->cuts : 0;
    return !x->mirrored ? 0 : folds ? s->count / 2 : x->kind == SALTUS_POINT_BP ? x->orbits.n : 0;
}

/* The null vector of a matrix of `size` rows, which is overwritten. Where orbits that are their own mirror
 * images fold as well as others branch off, that of the kind that is followed; `folding` becomes the other
 * one, and *folds says that there is one. */
static saltus_status find_null(const saltus_extended *x, double *a, int size, double *out, double *folding,
                               bool *folds) {
    const double singular = 1e-6;
    int first;
    const int half = halves_of(x, &first), count = half ? 2 : 1;
    double values[2] = {0, INFINITY}, *both = x->fresh;
    const saltus_status status = saltus_dense_null_vectors(a, size, size, count, both, values);
    if (status == SALTUS_OK)
        memcpy(out, both, (size_t)size * sizeof *out);
    *folds = status == SALTUS_OK && values[1] < singular;
    if (*folds) {
        const double *one = both + first, *other = one + size;
        const double turn = atan2(saltus_dot(one, other + half, half) + saltus_dot(other, one + half, half),
                                  saltus_dot(one, one + half, half) - saltus_dot(other, other + half, half)) /
                            2;
        for (int i = 0; i < size; i++) {
            out[i] = cos(turn) * both[i] + sin(turn) * both[size + i];
            folding[i] = cos(turn) * both[size + i] - sin(turn) * both[i];
        }
    }
    return status;
}

saltus_status saltus_extended_choose(saltus_extended *x, double theta, saltus_message *message) {
    int size = x->copies * x->orbits.equations->count;
    bool folds[2];
    double *a = x->matrix;
    x->folds = false;
    saltus_status status = SALTUS_OK;
    for (int side = 0; side < 2 && status == SALTUS_OK; side++) {
        fill_singular(x, theta, a, size);
        for (int i = 0; i < size && side; i++)
            for (int j = 0; j < i; j++)
                SALTUS_SWAP(a[i * size + j], a[j * size + i]);
        status = find_null(x, a, size, side ? x->b : x->c, x->folding[side], &folds[side]);
    }
    x->folds = status == SALTUS_OK && folds[0] && folds[1];
    return status == SALTUS_OK
               ? status
               : saltus_fail(message, status,
                             status == SALTUS_NO_MEMORY ? "no memory for a locus"
                                                        : "no null vectors at the first point");
}

/* Solve the bordered systems at the point last evaluated: v, g and w. */
static bool solve_bordered(saltus_extended *x, double theta) {
    int c = x->orbits.equations->count, k = x->copies, size = k * c, order = size + k;
    double *m = x->matrix;
    fill_singular(x, theta, m, order);
    for (int i = 0; i < size; i++) {
        m[i * order + size] = x->b[i];
        m[size * order + i] = x->c[i];
        if (k == 2) { /* the same times i */
            m[i * order + size + 1] = i < c ? -x->b[i + c] : x->b[i - c];
            m[(size + 1) * order + i] = i < c ? -x->c[i + c] : x->c[i - c];
        }
    }
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++)
            m[(size + i) * order + size + j] = 0;
    if (!saltus_dense_factor(&x->lu, m))
        return false;
    memset(x->right, 0, (size_t)order * sizeof(double));
    memset(x->left, 0, (size_t)(k * order) * sizeof(double));
    x->right[size] = 1;
    for (int i = 0; i < k; i++)
        x->left[i * order + size + i] = 1;
    saltus_dense_resolve(&x->lu, false, 1, x->right);
    saltus_dense_resolve(&x->lu, true, k, x->left);
    return true;
}

/* The scaled speed of the slowest prescribed impact of the orbit last evaluated, but for those that graze. */
static double slowest_impact(const saltus_extended *x) {
    const double nothing = 1e-9;
    const saltus_breaches *breaches = &x->orbits.shooting->breaches;
    double slowest = INFINITY;
    for (int k = 0; k < breaches->count; k++)
        if (breaches->items[k].kind == SALTUS_BREACH_SPEED && fabs(breaches->items[k].value) > nothing)
            slowest = fmin(slowest, fabs(breaches->items[k].value));
    return slowest;
}

/* A' v at u, by central differences of the Jacobian along v, of second order or, if `sharp`, of fourth. An
 * impact's derivatives change over distances like its speed. Near changes of events there may be no orbits to
 * difference with; the last A' v is then good enough. */
static saltus_status renew_along(saltus_extended *x, const double *u, saltus_message *message) {
    static const double place[] = {1, -1, 2, -2}, share[] = {8. / 12, -8. / 12, -1. / 12, 1. / 12};
    const double apart = (x->sharp ? 10 : 1) * fmin(1e-4, 0.5 * slowest_impact(x));
    saltus_equations *e = x->orbits.equations;
    const int c = e->count, m = e->unknowns, places = x->sharp ? 4 : 2;
    const size_t size = (size_t)(x->copies * c * m);
    saltus_status status = SALTUS_OK;
    memset(x->fresh, 0, size * sizeof *x->fresh);
    for (int k = 0; k < x->copies * places && status == SALTUS_OK; k++) {
        const double *v = x->right + k / places * c;
        double *out = x->fresh + k / places * c * m;
        const double by = place[k % places], length = saltus_length(v, c),
                     factor = (x->sharp ? share[k % places] : 0.5 * by) * length / apart;
        memcpy(x->aside, u, (size_t)m * sizeof *u);
        for (int j = 0; j < c; j++)
            x->aside[j] += by * apart * v[j] / length;
        status = saltus_equations_evaluate(e, x->aside, message);
        for (int j = 0; j < c * m && status == SALTUS_OK; j++)
            out[j] += factor * e->jacobian[j];
    }
    if (status == SALTUS_NO_MEMORY || status == SALTUS_INTERRUPTED || (status != SALTUS_OK && !x->differs))
        return status;
    if (status == SALTUS_OK)
        memcpy(x->along, x->fresh, size * sizeof *x->along);
    x->differs = true;
    return SALTUS_OK;
}

/* The rows of g: its value and gradient, from v, w and A' v. */
static void fill_special(saltus_extended *x, const double *u) {
    const saltus_equations *orbit = x->orbits.equations;
    int c = orbit->count, m = orbit->unknowns, k = x->copies, order = k * (c + 1),
        own = x->equations.unknowns;
    int n = x->orbits.n, row = saltus_shooting_closing_row(x->orbits.shooting);
    for (int i = 0; i < k; i++) {
        const double *w = x->left + i * order;
        double *gradient = x->equations.jacobian + (c + i) * own;
        x->equations.residual[c + i] = x->right[k * c + i];
        memset(gradient, 0, (size_t)own * sizeof *gradient);
        for (int r = 0; r < k * c; r++)
            for (int j = 0; j < m; j++)
                gradient[j] -= w[r] * x->along[r * m + j];
        if (x->kind != SALTUS_POINT_NS)
            continue;
        double sine = sin(u[m]), cosine = cos(u[m]);
        for (int j = 0; j < n; j++) {
            double re = x->right[j], im = x->right[c + j];
            gradient[m] -=
                w[row + j] * (sine * re + cosine * im) + w[c + row + j] * (sine * im - cosine * re);
        }
    }
}

/* Of an orbit that is its own mirror image the image of the impact without speed has none either: its gap, a
 * maximum, would tell its time only to the root of a residual. It is half the period later. */
static void time_image(saltus_extended *x, const double *u, int own) {
    const double near = 1e-4;
    const saltus_sequence *s = &x->orbits.shooting->sequence;
    const int first = own - x->mark;
    const double scale = x->orbits.shooting->scale[own];
    for (int k = 0; k < s->count; k++) {
        const double later = s->mark[k].time - s->mark[x->mark].time,
                     half = copysign(0.5 * s->periods, later);
        if (s->mark[k].face == s->mark[x->mark].face || !(fabs(later - half) < near))
            continue;
        double *row = x->equations.jacobian + (first + k) * x->equations.unknowns;
        memset(row, 0, (size_t)x->equations.unknowns * sizeof *row);
        row[first + k] = 1;
        row[own] = -1;
        x->equations.residual[first + k] = u[first + k] - u[own] - half / scale;
    }
}

saltus_status saltus_extended_evaluate(void *self, const double *u, saltus_message *message) {
    saltus_extended *x = self;
    saltus_equations *orbit = x->orbits.equations;
    const int c = orbit->count, m = orbit->unknowns, own = x->equations.unknowns;
    const double *speed =
        x->kind == SALTUS_POINT_GR ? saltus_shooting_speed_row(x->orbits.shooting, x->mark) : NULL;
    saltus_status status = saltus_equations_evaluate(orbit, u, message);
    if (status != SALTUS_OK)
        return status;
    memset(x->equations.jacobian, 0, (size_t)(x->equations.count * own) * sizeof(double));
    for (int i = 0; i < c; i++) {
        x->equations.residual[i] = orbit->residual[i];
        memcpy(x->equations.jacobian + i * own, orbit->jacobian + i * m, (size_t)m * sizeof(double));
    }
    if (speed) {
        /* g is the entry of the Jacobian that is the impact's speed. */
        const int entry = x->orbits.n * x->orbits.shooting->sequence.cuts + x->mark;
        x->equations.residual[c] = orbit->jacobian[entry * m + entry];
        memcpy(x->equations.jacobian + c * own, speed, (size_t)m * sizeof(double));
        if (x->mirrored)
            time_image(x, u, entry);
        return SALTUS_OK;
    }
    if (!solve_bordered(x, x->extra ? u[m] : 0))
        return saltus_fail(message, SALTUS_SINGULAR, "the bordered matrix is singular");
    status = renew_along(x, u, message);
    if (status != SALTUS_OK)
        return status;
    fill_special(x, u);
    if (x->kind == SALTUS_POINT_BP) {
        double *still = x->equations.jacobian + (c + 1) * own;
        x->equations.residual[c + 1] = 0;
        for (int i = 0; i < c; i++) {
            x->equations.residual[i] += u[m] * x->b[i];
            x->equations.jacobian[i * own + m] = x->b[i];
        }
        /* A symmetric orbit is at minus its beginning half a period later; what branches off is not. Without
         * that symmetry the orbit must not move along c. */
        for (int i = 0; i < (x->mirrored ? x->orbits.n : c); i++) {
            double other = x->mirrored ? u[x->orbits.n + i] : -x->anchor[i];
            x->equations.residual[c + 1] += x->c[i] * (u[i] + other);
            still[i] = x->c[i];
            if (x->mirrored)
                still[x->orbits.n + i] = x->c[i];
        }
    }
    return SALTUS_OK;
}

void saltus_extended_renew(saltus_extended *x, const double *u) {
    int c = x->orbits.equations->count, size = x->copies * c;
    if (x->kind == SALTUS_POINT_GR)
        return;
    const double right = saltus_length(x->right, size), left = saltus_length(x->left, size);
    for (int i = 0; i < size; i++) {
        x->c[i] = x->right[i] / right;
        x->b[i] = x->left[i] / left;
    }
    memcpy(x->anchor, u, (size_t)(c + 2) * sizeof *u);
}

double saltus_extended_double(const saltus_extended *x, double *rounding) {
    const double digits = 1e-12;
    const int c = x->orbits.equations->count, row = saltus_shooting_closing_row(x->orbits.shooting);
    *rounding = digits * saltus_length(x->left, c) * saltus_length(x->right, c);
    return saltus_dot(x->left + row, x->right, x->orbits.n);
}

bool saltus_extended_strays(const saltus_extended *x) {
    int first;
    const int half = halves_of(x, &first);
    return half && saltus_dot(x->right + first, x->right + first + half, half) < 0;
}

double saltus_extended_cusp(const saltus_extended *x) {
    const int c = x->orbits.equations->count;
    return saltus_dot(x->equations.jacobian + (ptrdiff_t)c * x->equations.unknowns, x->right, c);
}

saltus_status saltus_extended_criticality(saltus_extended *x, const double *u, double apart, double *value) {
    enum { arm = 4 };
    static const double first[arm] = {4. / 5, -1. / 5, 4. / 105, -1. / 280},
                        second[arm] = {8. / 5, -1. / 5, 8. / 315, -1. / 560}, centre = -205. / 72;
    saltus_equations *e = x->orbits.equations;
    const int c = e->count, m = e->unknowns;
    const bool flips = x->kind == SALTUS_POINT_PD;
    const double *v = x->right, *w = x->left;
    const double length = saltus_length(v, c);
    double cubic = 0, *work = calloc((size_t)(c * c + 2 * c + 1), sizeof *work);
    saltus_dense_lu lu = {.n = 0};
    if (!work || !saltus_dense_lu_open(&lu, c)) {
        free(work);
        return SALTUS_NO_MEMORY;
    }
    double *matrix = work, *square = work + c * c, *mixed = square + c + 1;
    saltus_status status = SALTUS_OK;
    for (int k = -arm; k <= arm && status == SALTUS_OK; k++) {
        const double slope = k == 0 ? 0 : (k < 0 ? -1 : 1) * first[abs(k) - 1] / apart,
                     bend = (k == 0 ? centre : second[abs(k) - 1]) / (apart * apart);
        memcpy(x->aside, u, (size_t)m * sizeof *u);
        for (int j = 0; j < c; j++)
            x->aside[j] += k * apart * v[j] / length;
        status = saltus_equations_evaluate(e, x->aside, NULL);
        for (int i = 0; i < c && status == SALTUS_OK; i++) {
            double along = 0;
            for (int j = 0; j < c; j++) {
                along += e->jacobian[i * m + j] * v[j] / length;
                mixed[j] += slope * w[i] * e->jacobian[i * m + j];
                if (k == 0)
                    matrix[i * c + j] = e->jacobian[i * m + j];
            }
            square[i] -= 0.5 * slope * along;
            cubic += bend * w[i] * along;
        }
    }
    if (status == SALTUS_OK && flips && !saltus_dense_factor(&lu, matrix))
        status = SALTUS_SINGULAR; /* a flip with a multiplier 1 */
    if (status == SALTUS_OK) {
        /* At a branch point F' is A itself, and s has no part along c. */
        saltus_dense_resolve(flips ? &lu : &x->lu, false, 1, square);
        *value = cubic / 6;
        for (int j = 0; j < c; j++)
            *value += mixed[j] * square[j];
    }
    saltus_dense_lu_close(&lu);
    free(work);
    return status;
}
