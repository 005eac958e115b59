/* Touches of a stop at which more than the speed is zero. The method stands in flat.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/flat.h"

#include "branch/sequence.h"

#include <math.h>
#include <string.h>

/* The events of an orbit that are near together as one impact each; which one each of them belongs to goes to
 * `part`. */
static saltus_sequence gather(const saltus_sequence *whole, int part[SALTUS_MARKS_MAX]) {
    const double near = 0.01;
    saltus_sequence few = *whole;
    few.driven = false;
    few.cuts = 1;
    few.count = 0;
    for (int k = 0; k < whole->count; k++) {
        const saltus_mark *own = &whole->mark[k], *before = &whole->mark[k > 0 ? k - 1 : 0];
        if (k == 0 || own->face != before->face || own->time - before->time > near)
            few.mark[few.count++] =
                (saltus_mark){.kind = SALTUS_IMPACT, .face = own->face, .time = own->time};
        part[k] = few.count - 1;
    }
    return few;
}

/* The touch `mark`, if complete chatter follows it, as the mere beginning of the contact. */
static bool gather_landing(const saltus_sequence *whole, int mark, saltus_sequence *few) {
    const double near = 0.01;
    const saltus_mark *touch = &whole->mark[mark];
    bool gone[SALTUS_MARKS_MAX] = {false};
    int last = mark;
    while (!whole->mark[last].driven && last + 1 < whole->count &&
           whole->mark[last + 1].face == touch->face && whole->mark[last + 1].kind == SALTUS_IMPACT &&
           whole->mark[last + 1].time - touch->time < near)
        gone[++last] = true;
    saltus_sequence_without(whole, gone, few, NULL);
    few->mark[mark].kind = SALTUS_STICK;
    few->mark[mark].driven = false;
    return whole->mark[last].driven && !whole->driven && saltus_sequence_completes(whole, last);
}

/* The equations of an orbit with, for some of its marks, g' = g'' = 0, and g''' = 0. They are as many as the
 * unknowns, or more and hold together where the orbit is one of a family. */
typedef struct flat {
    saltus_shooting *shooting;
    saltus_equations *e;
    int rows, marks, first; /* first: unknown and equation of the first mark */
    int derivatives;        /* that are zero */
    double *u, *a;          /* rows x (unknowns + 1): the Jacobian, and the residuals behind it */
    double *normal, *right;
    saltus_dense_lu lu;
    saltus_arena arena;
} flat;

/* Evaluate at f->u. Derivatives by time, in units of the period over 2 pi, are differences of the gap's own
 * row along the mark's time. */
static saltus_status evaluate(flat *f, double apart) {
    static const double share[3][5] = {{1. / 12, -8. / 12, 0, 8. / 12, -1. / 12},
                                       {-1. / 12, 16. / 12, -30. / 12, 16. / 12, -1. / 12},
                                       {-0.5, 1, 0, -1, 0.5}};
    const int c = f->e->count, m = f->e->unknowns, width = m + 1;
    const double *scale = f->shooting->scale;
    memset(f->a, 0, (size_t)(f->rows * width) * sizeof *f->a);
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < f->marks && status == SALTUS_OK; k++) {
        const int own = f->first + k;
        const double unit = scale[own] * 2 * M_PI, middle = f->u[own];
        for (int j = 0; j < 5 && status == SALTUS_OK; j++) {
            f->u[own] = middle + (j - 2) * apart / unit;
            status = saltus_equations_evaluate(f->e, f->u, NULL);
            const double *row = f->e->jacobian + own * m;
            for (int d = 0; d < f->derivatives && status == SALTUS_OK; d++) {
                double *out = f->a + (c + f->derivatives * k + d) * width;
                for (int i = 0; i < m; i++)
                    out[i] += share[d][j] / pow(apart, d + 1) * row[i];
                out[m] += d        ? share[d - 1][j] / pow(apart, d) * row[own] / unit
                          : j == 2 ? row[own] / unit
                                   : 0;
            }
        }
        f->u[own] = middle;
    }
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(f->e, f->u, NULL);
    for (int i = 0; i < c && status == SALTUS_OK; i++) {
        memcpy(f->a + i * width, f->e->jacobian + i * m, (size_t)m * sizeof *f->a);
        f->a[i * width + m] = f->e->residual[i];
    }
    return status;
}

/* Gauss and Newton's method. */
static bool solve(saltus_orbits *o, flat *f, double apart) {
    enum { iterations = 12 };
    const double still = 1e-12, zero = 1e-8;
    const int m = f->e->unknowns, width = m + 1;
    double moved = INFINITY;
    bool found = false;
    for (int k = 0; k < iterations && moved > still; k++) {
        if (saltus_orbits_noted(o, evaluate(f, apart)) != SALTUS_OK)
            return false;
        memset(f->normal, 0, (size_t)(m * m) * sizeof *f->normal);
        memset(f->right, 0, (size_t)m * sizeof *f->right);
        double size = 0;
        for (int r = 0; r < f->rows; r++) {
            const double *row = f->a + r * width;
            size = fmax(size, fabs(row[m]));
            for (int i = 0; i < m; i++) {
                f->right[i] -= row[i] * row[m];
                for (int j = 0; j < m; j++)
                    f->normal[i * m + j] += row[i] * row[j];
            }
        }
        if (!saltus_dense_factor(&f->lu, f->normal))
            return found;
        saltus_dense_resolve(&f->lu, false, 1, f->right);
        moved = hypot(f->right[m - 2], f->right[m - 1]);
        for (int i = 0; i < m; i++)
            f->u[i] += f->right[i];
        found = size < zero;
    }
    return found;
}

/* f->u becomes the orbit's unknowns, found with two widths of the differences; *doubt: how far these are
 * apart in the plane. */
static bool find_flat(saltus_orbits *o, flat *f, double *doubt) {
    const double apart = 1e-3;
    const int m = f->e->unknowns;
    bool found = true;
    double other[2];
    for (int k = 2; k > 0 && found; k--) {
        other[0] = f->u[m - 2];
        other[1] = f->u[m - 1];
        found = solve(o, f, k * apart);
    }
    *doubt = hypot(f->u[m - 2] - other[0], f->u[m - 1] - other[1]);
    return found;
}

/* `at` becomes the orbit found. */
static saltus_status take_over(saltus_extended *x, const flat *f, saltus_locus_point *at) {
    saltus_sequence few;
    double state[SALTUS_STATE_MAX];
    const size_t m = (size_t)f->e->unknowns;
    saltus_shooting_extract(f->shooting, f->u, &few, state);
    saltus_status status =
        saltus_solution_place(&x->orbits, &few, f->u + f->e->count, state, false, &at->orbit, NULL);
    if (status == SALTUS_OK)
        status = saltus_solution_survey(&x->orbits, &at->orbit, NULL);
    if (status == SALTUS_OK && !saltus_curve_reserve(&at->at, (int)m))
        status = SALTUS_NO_MEMORY;
    if (status == SALTUS_OK) {
        memcpy(at->at.u, f->u, m * sizeof *f->u);
        memset(at->at.tangent, 0, m * sizeof *f->u);
    }
    return status;
}

/* Make room for the equations of f->shooting. */
static bool open_flat(saltus_orbits *o, flat *f) {
    f->e = &f->shooting->equations;
    const size_t m = (size_t)f->e->unknowns;
    f->rows = f->e->count + f->derivatives * f->marks;
    do {
        f->u = saltus_arena_doubles(&f->arena, m);
        f->a = saltus_arena_doubles(&f->arena, (size_t)f->rows * (m + 1));
        f->normal = saltus_arena_doubles(&f->arena, m * m);
        f->right = saltus_arena_doubles(&f->arena, m);
    } while (saltus_arena_again(&f->arena));
    const bool room = f->arena.base && saltus_dense_lu_open(&f->lu, (int)m);
    o->starved |= !room;
    return room;
}

/* The orbit of f, with this sequence, that is next to `here` becomes `at`. */
static bool seek(saltus_extended *x, flat *f, const saltus_sequence *few, const saltus_locus_point *here,
                 saltus_locus_point *at) {
    const double near = 1e-3;
    double doubt;
    const saltus_status status = saltus_orbits_shoot(&x->orbits, &here->orbit, few, &f->shooting, NULL);
    bool found = saltus_orbits_noted(&x->orbits, status) == SALTUS_OK && open_flat(&x->orbits, f);
    if (found) {
        memcpy(f->u, f->e->trial, (size_t)f->e->unknowns * sizeof *f->u);
        found = find_flat(&x->orbits, f, &doubt) &&
                saltus_orbits_noted(&x->orbits, take_over(x, f, at)) == SALTUS_OK &&
                saltus_locus_leads(x, here, near, at);
    }
    if (found)
        at->doubt = doubt;
    saltus_dense_lu_close(&f->lu);
    saltus_arena_close(&f->arena);
    saltus_shooting_free(f->shooting);
    return found;
}

const char *saltus_flat_touch(saltus_extended *x, const saltus_locus_point *here, saltus_locus_point *at) {
    const double slow = 1e-3;
    const saltus_solution *s = &here->orbit;
    int part[SALTUS_MARKS_MAX];
    double slowest, fastest;
    saltus_sequence few = gather(&s->sequence, part);
    saltus_solution_speed_range(s, &slowest, &fastest);
    flat all = {.marks = few.count, .first = x->orbits.n, .derivatives = 3};
    if (fastest <= slow && few.count > 0 && !few.contacts && !(few.omega > 0) &&
        seek(x, &all, &few, here, at)) {
        x->mark = x->kind == SALTUS_POINT_GR ? part[x->mark] : 0;
        return "all its impacts shrink to a touch at which the acceleration is zero, too";
    }
    flat one = {.marks = 1, .first = x->orbits.n * s->sequence.cuts + x->mark, .derivatives = 2};
    return x->kind == SALTUS_POINT_GR && gather_landing(&s->sequence, x->mark, &few) &&
                   seek(x, &one, &few, here, at)
               ? "the touch and the chatter after it shrink to the begin of a contact without acceleration"
               : NULL;
}
