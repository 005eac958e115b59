/* Points of codimension two on a locus.
 *
 * A curve of folds has a cusp where the second derivative along the null vector vanishes. Multipliers on the
 * unit circle are double (R1, R2) where left and right null vectors are orthogonal. On a Neimark-Sacker curve
 * the angle tells the resonances. Each of these curves ends where another impact dies or is born. A curve of
 * grazing passes through points where the orbit with the grazing impact (one side of the curve), or without
 * it (the other side), is special too.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/corner.h"

#include "branch/sequence.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whether a breach belongs to the grazing impact that is followed, or to its mirror image. */
static bool is_own(const saltus_extended *x, const saltus_solution *s, const saltus_breach *breach) {
    const double near = 1e-4;
    const saltus_mark *own = &s->sequence.mark[x->mark];
    bool touch = breach->face == own->face && fabs(breach->time - own->time) < near;
    /* On a symmetric orbit the mirror image of the impact grazes too. */
    bool image = x->mirrored && breach->face != own->face &&
                 fabs(fabs(breach->time - own->time) - 0.5 * s->sequence.periods) < near;
    return touch || image || (breach->mark == x->mark && breach->kind == SALTUS_BREACH_SPEED);
}

/* The marks at which the orbit has that impact and its image; returns how many. */
static int own_marks(const saltus_extended *x, const saltus_solution *s, int *marks) {
    int count = 0;
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].kind == SALTUS_BREACH_SPEED && is_own(x, s, &s->breaches[k]))
            marks[count++] = s->breaches[k].mark;
    return count;
}

static const saltus_breach *worst_of(const saltus_extended *x, const saltus_solution *s) {
    const saltus_breach *worst = NULL;
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].value > (worst ? worst->value : -1) &&
            !(x->kind == SALTUS_POINT_GR && is_own(x, s, &s->breaches[k])))
            worst = &s->breaches[k];
    return worst;
}

/* The breach of an impact without speed at which a maximum of the gap is; NULL: none. */
static const saltus_breach *slow_impact(const saltus_solution *s, const saltus_breach *gap) {
    const double near = 1e-4, slow = 1e-5;
    for (int k = 0; k < s->breach_count; k++) {
        const saltus_breach *impact = &s->breaches[k];
        if (impact->kind == SALTUS_BREACH_SPEED && impact->face == gap->face &&
            fabs(impact->time - gap->time) < near && fabs(impact->value) < slow)
            return impact;
    }
    return NULL;
}

const saltus_breach *saltus_corner_touch(const saltus_extended *x, const saltus_solution *s) {
    const double together = 1e-7;
    const saltus_breach *worst = worst_of(x, s);
    const saltus_breach *impact = worst && worst->kind == SALTUS_BREACH_GAP ? slow_impact(s, worst) : NULL;
    if (impact)
        worst = impact;
    /* Between equal stops an orbit whose impacts die becomes symmetric, and touches the other stop, too. */
    for (int k = 0; k < s->breach_count && worst && worst->kind == SALTUS_BREACH_SPEED; k++)
        if (x->kind != SALTUS_POINT_GR && s->breaches[k].kind == SALTUS_BREACH_GAP &&
            fabs(s->breaches[k].value) < together && !slow_impact(s, &s->breaches[k]))
            worst = &s->breaches[k];
    return worst;
}

double saltus_corner_breach(const saltus_extended *x, const saltus_solution *s) {
    const saltus_breach *worst = worst_of(x, s);
    return worst ? worst->value : -1;
}

int saltus_corner_multipliers(saltus_orbits *o, saltus_shooting *shooting, double *re, double *im) {
    const double shift = 0.5, infinite = 1e-9;
    int n = o->n, m = shooting->equations.unknowns, row = saltus_shooting_closing_row(shooting), count = 0;
    saltus_dense_lu *lu = saltus_shooting_factor(shooting, 1 - shift);
    double real[SALTUS_STATE_MAX], imaginary[SALTUS_STATE_MAX],
        largest = 0, *columns = calloc((size_t)(n * (m + n)), sizeof *columns),
        *inverse = columns ? columns + n * m : NULL;
    bool sound = columns && lu->sign;
    o->starved |= !columns;
    for (int i = 0; i < n && sound; i++)
        columns[i * m + row + i] = 1;
    if (sound)
        saltus_dense_resolve(lu, false, n, columns);
    for (int i = 0; i < n && sound; i++)
        for (int j = 0; j < n; j++)
            inverse[i * n + j] = columns[j * m + i];
    sound = sound && saltus_dense_eigenvalues(inverse, n, real, imaginary);
    for (int i = 0; i < n && sound; i++)
        largest = fmax(largest, hypot(real[i], imaginary[i]));
    for (int i = 0; i < n && sound; i++) {
        double square = real[i] * real[i] + imaginary[i] * imaginary[i];
        if (!(sqrt(square) > infinite * largest))
            continue;
        re[count] = shift + real[i] / square;
        im[count++] = -imaginary[i] / square;
    }
    free(columns);
    return count;
}

/* Signed distance of a multiplier from the unit circle, relative to its modulus if that exceeds 1. */
static double off_circle(double re, double im) {
    const double modulus = hypot(re, im);
    return (modulus - 1) / fmax(1, modulus);
}

/* Insert a number if it is among those closest to the unit circle. */
static void keep_close(saltus_close *close, double re, double im) {
    const double own = fabs(off_circle(re, im));
    int at = close->count;
    close->count += close->count < SALTUS_CLOSE_MAX;
    for (; at > 0 && own < fabs(off_circle(close->re[at - 1], close->im[at - 1])); at--)
        if (at < SALTUS_CLOSE_MAX) {
            close->re[at] = close->re[at - 1];
            close->im[at] = close->im[at - 1];
        }
    if (at < SALTUS_CLOSE_MAX) {
        close->re[at] = re;
        close->im[at] = im;
    }
}

void saltus_corner_still(const saltus_orbits *o, saltus_shooting *shooting, int mark) {
    saltus_equations *e = &shooting->equations;
    const int entry = o->n * shooting->sequence.cuts + mark;
    e->jacobian[entry * e->unknowns + entry] = 0;
}

enum { of_fold, of_flip, of_pair, of_orbit };

/* The functions of the orbit last evaluated by the shooting, on a curve of grazing, at fixed parameters: the
 * determinant of the equations, the same for an orbit that closes on minus its beginning, and the product of
 * mu_i mu_j - 1 over all pairs of finite multipliers. The last is zero where a pair is on the unit circle or
 * two real multipliers have the product 1, and as smooth as the equations. */
static void measure_orbit(saltus_orbits *o, saltus_shooting *shooting, saltus_locus_test tests[of_orbit]) {
    const double on = 1e-6, nothing = 1e-10,
                 infinite = 1e6; /* larger: infinite, but for the residual speed at grazing */
    saltus_locus_test *pair = &tests[of_pair];
    double re[SALTUS_STATE_MAX], im[SALTUS_STATE_MAX], size = 0, angle = 0, least = INFINITY;
    const int all = saltus_corner_multipliers(o, shooting, re, im);
    int count = 0;
    tests[of_fold].value = saltus_orbits_closing(shooting, false);
    tests[of_flip].value = saltus_orbits_closing(shooting, true);
    for (int i = 0; i < all; i++) {
        if (hypot(re[i], im[i]) > infinite)
            continue;
        if (im[i] > 0 && fabs(off_circle(re[i], im[i])) < on)
            pair->theta = atan2(im[i], re[i]);
        keep_close(&pair->single, re[i], im[i]);
        for (int j = 0; j < count; j++) {
            const double real = re[i] * re[j] - im[i] * im[j], imaginary = re[i] * im[j] + im[i] * re[j];
            const double off = fmax(hypot(real - 1, imaginary), DBL_MIN);
            size += log(off);
            least = fmin(least, off / fmax(1, hypot(real, imaginary)));
            angle += atan2(imaginary, real - 1);
            if (imaginary == 0)
                keep_close(&pair->product, real, 0);
        }
        re[count] = re[i];
        im[count++] = im[i];
    }
    if (count > 1)
        pair->value = (saltus_scaled){cos(angle) < 0 ? -1 : 1, size};
    /* Without damping and impacts a pair is on the circle all along the curve. */
    if (count > 1)
        pair->quiet = size + log(nothing / least);
}

/* The distance of a number from the nearest of others, relative to the larger modulus of both, or to `least`;
 * and the distance of that one from the unit circle, *off. */
static double nearest_of(const saltus_close *there, double re, double im, double least, double *off) {
    const double own = fmax(least, hypot(re, im));
    double nearest = INFINITY;
    for (int j = 0; j < there->count; j++) {
        const double apart =
            hypot(re - there->re[j], im - there->im[j]) / fmax(own, hypot(there->re[j], there->im[j]));
        if (apart < nearest) {
            nearest = apart;
            *off = off_circle(there->re[j], there->im[j]);
        }
    }
    return nearest;
}

/* Whether numbers have moved so far from here to there that one on the same side of the unit circle at both
 * may have crossed it and come back. With `turns`, for multipliers, also whether one has turned or grown so
 * much that functions of them all may change sign and back: under slow forcing multipliers turn with each
 * free oscillation in the period. */
static bool may_return(const saltus_close *here, const saltus_close *there, bool turns) {
    const double little = 1e-2, far = 0.4, nothing = 1e-3;
    for (int i = 0; i < here->count; i++) {
        const double re = here->re[i], im = here->im[i], off = off_circle(re, im);
        double off_there = 0, ignored;
        const double moved = nearest_of(there, re, im, 1, &off_there);
        if (moved > little && off * off_there > 0 && fmin(fabs(off), fabs(off_there)) < moved)
            return true;
        if (turns && hypot(re, im) > nothing && nearest_of(there, re, im, 0, &ignored) > far)
            return true;
    }
    return false;
}

bool saltus_corner_hides(const saltus_locus_test *a, const saltus_locus_test *b) {
    return may_return(&a->single, &b->single, true) || may_return(&b->single, &a->single, true) ||
           may_return(&a->product, &b->product, false) || may_return(&b->product, &a->product, false);
}

/* Counts of numbers inside the unit circle and on it: at 1, at -1 and elsewhere. */
typedef struct tally {
    int inside, at_one, at_minus_one, aside;
} tally;

static tally tally_of(const saltus_close *c) {
    const double on = 1e-5;
    tally t = {0};
    for (int i = 0; i < c->count; i++) {
        const double off = off_circle(c->re[i], c->im[i]);
        if (fabs(off) > on)
            t.inside += off < 0;
        else
            ++*(fabs(c->im[i]) > on ? &t.aside : c->re[i] > 0 ? &t.at_one : &t.at_minus_one);
    }
    return t;
}

/* Each fold or flip takes one multiplier through the circle, each pair two. Those on the circle may have come
 * from either side, and functions that are zero there have no sign. */
bool saltus_corner_misses(const saltus_locus_test *a, const saltus_locus_test *b, int count) {
    for (int k = 0; k < count; k++) {
        if (a[k].kind != SALTUS_POINT_GR_NS || a[k].breach || !isfinite(a[k].value.mantissa) ||
            !isfinite(b[k].value.mantissa))
            continue;
        const tally from = tally_of(&a[k].single), to = tally_of(&b[k].single);
        const int low = to.inside - from.inside - from.at_one - from.at_minus_one - from.aside,
                  high = to.inside + to.at_one + to.at_minus_one + to.aside - from.inside;
        int single = 0;
        bool told = true, explained = false;
        for (int j = 0; j < count; j++) {
            const bool fold = a[j].kind == SALTUS_POINT_GR_LP || a[j].kind == SALTUS_POINT_GR_BP,
                       flip = a[j].kind == SALTUS_POINT_GR_PD;
            if (!(fold || flip) || a[j].breach || a[j].without != a[k].without)
                continue;
            if (fold ? from.at_one + to.at_one : from.at_minus_one + to.at_minus_one)
                continue;
            told = told && !(a[j].value.exponent < a[j].quiet) && !(b[j].value.exponent < b[j].quiet);
            single += a[j].value.mantissa * b[j].value.mantissa < 0;
        }
        const bool pair = from.aside || to.aside || a[k].value.mantissa * b[k].value.mantissa < 0;
        for (int d = low; d <= high; d++)
            explained = explained || ((d - single) % 2 == 0 && abs(d) <= single + 2 * pair);
        if (told && !explained)
            return true;
    }
    return false;
}

saltus_sequence saltus_corner_without(const saltus_extended *x, const saltus_solution *s) {
    bool gone[SALTUS_MARKS_MAX] = {false};
    int own[SALTUS_MARKS_MAX];
    saltus_sequence less;
    for (int k = own_marks(x, s, own) - 1; k >= 0; k--)
        gone[own[k]] = true;
    saltus_sequence_without(&s->sequence, gone, &less, NULL);
    return less;
}

/* Of an orbit that is its own mirror image, cut in halves, the equations fall apart: into those of changes
 * that keep it so, which are singular at a fold, and of those that do not, singular at a branch point. */
static void measure_halves(saltus_orbits *o, saltus_shooting *shooting, saltus_locus_test tests[2]) {
    const saltus_equations *e = &shooting->equations;
    const int n = o->n, marks = shooting->sequence.count / 2, size = n + marks, m = e->unknowns,
              row = n - saltus_shooting_closing_row(shooting), period = shooting->count - 1;
    double *a = calloc((size_t)((size + 1) * (size + 1)), sizeof *a);
    saltus_dense_lu lu = {.n = 0};
    bool room = a;
    for (int k = 0; k < 2 && room; k++) {
        const double sign = k ? -1 : 1;
        /* If the period is an unknown, it and the equation for it are the last, but keep the orbit so. */
        const bool free_period = k == 0 && shooting->sequence.omega > 0;
        const int order = size + free_period;
        for (int i = 0; i < order; i++) {
            const double *from = e->jacobian + (i < n ? row + i : i < size ? n + i : period) * m;
            for (int j = 0; j < size; j++)
                a[i * order + j] = j < n ? from[j] - sign * from[n + j] : from[n + j] + sign * from[size + j];
            if (free_period)
                a[i * order + size] = from[period];
        }
        room = saltus_dense_lu_open(&lu, order);
        if (room) {
            saltus_dense_factor(&lu, a);
            tests[k].kind = k ? SALTUS_POINT_GR_BP : SALTUS_POINT_GR_LP;
            tests[k].value = (saltus_scaled){lu.sign, lu.log_modulus};
        }
        saltus_dense_lu_close(&lu);
    }
    free(a);
    o->starved |= !room;
}

/* The first two functions for an orbit that is its own mirror image: a multiplier passes 1 twice over where
 * one of half the orbit passes 1 or -1, and does not pass -1. They stay as they are if that fails. */
static void measure_mirrored(saltus_extended *x, const saltus_solution *s, bool without,
                             saltus_locus_test tests[2]) {
    const double together = 1e-4;
    saltus_orbits *o = &x->orbits;
    const saltus_sequence old = without ? saltus_corner_without(x, s) : s->sequence;
    int order[SALTUS_MARKS_MAX], own[SALTUS_MARKS_MAX];
    saltus_sequence halves;
    saltus_shooting *shooting = NULL;
    saltus_sequence_turn(&old, saltus_sequence_amid_halves(&old), 1, &halves, order);
    halves.cuts = 2;
    halves.cut[1] = halves.base + 0.5 * halves.periods;
    if (halves.count > 0 && !(saltus_sequence_repeats(&halves, 2, true) < together))
        return;
    const saltus_status status = saltus_orbits_evaluate(o, s, &halves, &shooting, NULL);
    const int count = status == SALTUS_OK && !without ? own_marks(x, s, own) : 0;
    for (int k = 0; k < count; k++)
        for (int j = 0; j < halves.count; j++)
            if (order[j] == own[k])
                saltus_corner_still(o, shooting, j);
    if (saltus_orbits_noted(o, status) == SALTUS_OK)
        measure_halves(o, shooting, tests);
    saltus_shooting_free(shooting);
}

/* The functions of a planar cycle with the grazing impact. The impulse is along the flow: there the
 * determinants are zero at any place, and their signs rounding. But the one multiplier beside that along the
 * flow is that without the impact, from the multipliers `without`, times r^2, and at 1 cycles with the impact
 * fold. */
static void measure_planar(const saltus_extended *x, const saltus_solution *s, const saltus_close *without,
                           saltus_locus_test tests[of_orbit]) {
    const double nothing = 1e-11;
    double multiplier = without->count == 1 ? without->re[0] : NAN;
    int own[SALTUS_MARKS_MAX];
    for (int k = own_marks(x, s, own) - 1; k >= 0; k--)
        multiplier *= pow(saltus_system_rebound(x->orbits.system, s->sequence.mark[own[k]].face, 0).r, 2);
    for (int k = 0; k < of_orbit; k++)
        tests[k].value = (saltus_scaled){k == of_fold ? multiplier - 1 : NAN, 0};
    tests[of_fold].quiet = log(nothing);
}

/* The six functions of an orbit on a curve of grazing, three with the grazing impact and three without; NAN
 * if they cannot be computed. */
static void measure_grazing(saltus_extended *x, const saltus_solution *s, saltus_locus_test *corners) {
    static const saltus_point_kind kinds[of_orbit] = {SALTUS_POINT_GR_LP, SALTUS_POINT_GR_PD,
                                                      SALTUS_POINT_GR_NS};
    saltus_locus_test tests[2][of_orbit];
    saltus_shooting *shooting = NULL;
    for (int without = 0; without < 2; without++)
        for (int k = 0; k < of_orbit; k++)
            tests[without][k] = (saltus_locus_test){
                .kind = kinds[k], .value = {NAN, 0}, .without = without, .theta = k == of_pair ? NAN : 0};
    int own[SALTUS_MARKS_MAX];
    for (int k = own_marks(x, s, own) - 1; k >= 0; k--)
        saltus_corner_still(&x->orbits, x->orbits.shooting, own[k]);
    const saltus_sequence less = saltus_corner_without(x, s);
    const saltus_status status = saltus_orbits_evaluate(&x->orbits, s, &less, &shooting, NULL);
    if (saltus_orbits_noted(&x->orbits, status) == SALTUS_OK)
        measure_orbit(&x->orbits, shooting, tests[1]);
    measure_orbit(&x->orbits, x->orbits.shooting, tests[0]);
    saltus_shooting_free(shooting);
    for (int without = 0; without < 2 && x->mirrored && x->orbits.system->mirror; without++)
        measure_mirrored(x, s, without, tests[without]);
    /* Determinants with and without the impact are of similar size if neither is zero. If complete chatter
     * after the impact loses all its effects, the determinant with it is only rounding. */
    for (int k = 0; k < 4; k++)
        tests[k / 2][k % 2].quiet = tests[1 - k / 2][k % 2].value.exponent + log(1e-9);
    if (s->sequence.omega > 0 && x->orbits.n == 2)
        measure_planar(x, s, &tests[1][of_pair].single, tests[0]);
    memcpy(corners, tests[0], 2 * sizeof *corners);
    memcpy(corners + 2, tests[1], 3 * sizeof *corners);
    corners[5] = tests[0][of_pair];
}

static saltus_locus_test smooth(saltus_point_kind kind, double value, bool ends) {
    return (saltus_locus_test){.kind = kind, .value = {value, 0}, .ends = ends};
}

static saltus_locus_test double_multiplier(const saltus_extended *x, saltus_point_kind kind) {
    double rounding;
    saltus_locus_test test = smooth(kind, saltus_extended_double(x, &rounding), false);
    test.quiet = log(rounding);
    return test;
}

bool saltus_corner_is_rounding(const saltus_locus_test *test) {
    return test->quiet != 0 && log(fabs(test->value.mantissa)) + test->value.exponent < test->quiet;
}

int saltus_corner_measure(saltus_extended *x, const saltus_curve_point *point, const saltus_solution *s,
                          saltus_locus_test *corners) {
    static const saltus_point_kind grazing[] = {[SALTUS_POINT_LP] = SALTUS_POINT_GR_LP,
                                                [SALTUS_POINT_PD] = SALTUS_POINT_GR_PD,
                                                [SALTUS_POINT_NS] = SALTUS_POINT_GR_NS,
                                                [SALTUS_POINT_BP] = SALTUS_POINT_GR_BP,
                                                [SALTUS_POINT_GR] = SALTUS_POINT_GR_GR};
    const double theta = x->extra ? point->u[point->unknowns - 1] : 0;
    int count = 1;
    corners[0] = smooth(grazing[x->kind], saltus_corner_breach(x, s), true);
    corners[0].breach = true;
    switch (x->kind) {
    case SALTUS_POINT_LP:
        corners[count++] = smooth(SALTUS_POINT_CP, saltus_extended_cusp(x), false);
        corners[count++] = double_multiplier(x, SALTUS_POINT_R1);
        break;
    case SALTUS_POINT_PD:
        corners[count++] = double_multiplier(x, SALTUS_POINT_R2);
        break;
    case SALTUS_POINT_NS:
        corners[count++] = smooth(SALTUS_POINT_R1, theta, true);
        /* The multipliers of an orbit that is its own mirror image are squares of those of its half. Where
         * their pair meets at -1 that of the half is at a quarter, and the curve goes on until that meets at
         * -1: there others branch off (BP). */
        corners[count] = x->mirrored ? smooth(SALTUS_POINT_R1, theta - 2 * M_PI, true)
                                     : smooth(SALTUS_POINT_R2, theta - M_PI, true);
        corners[count++].theta = x->mirrored ? 2 * M_PI : M_PI;
        corners[count++] = smooth(SALTUS_POINT_R3, cos(theta) + 0.5, false);
        corners[count++] = smooth(SALTUS_POINT_R4, cos(theta), false);
        break;
    case SALTUS_POINT_GR:
        measure_grazing(x, s, corners + 1);
        count = 7;
        break;
    default:
        break;
    }
    return count;
}

/* Whether another branch crosses at an orbit with a multiplier 1: then the equations with both parameters
 * have not the full rank either, as the left null vector is across what the parameters do, up to rounding:
 * after a long run of impacts, most of that vector lies in their times, which parameters hardly move. */
static bool is_branch_point(saltus_extended *x, const saltus_solution *s, bool without) {
    const double across = 1e-8;
    saltus_sequence sequence = without ? saltus_corner_without(x, s) : s->sequence;
    saltus_shooting *shooting = NULL;
    double value, *a = NULL;
    saltus_status status = saltus_orbits_evaluate(&x->orbits, s, &sequence, &shooting, NULL);
    bool branches = status == SALTUS_OK;
    if (status == SALTUS_OK) {
        const saltus_equations *e = &shooting->equations;
        const int c = e->count, m = e->unknowns;
        a = calloc((size_t)(c * (c + 1)), sizeof *a);
        double *left = a ? a + c * c : NULL;
        for (int i = 0; i < c * c && a; i++)
            a[i] = e->jacobian[i % c * m + i / c];
        status = a ? saltus_dense_null_vectors(a, c, c, 1, left, &value) : SALTUS_NO_MEMORY;
        branches = status == SALTUS_OK;
        for (int k = c; k < m && branches; k++) {
            double along = 0, size = 0;
            for (int i = 0; i < c; i++) {
                along += left[i] * e->jacobian[i * m + k];
                size += fabs(left[i] * e->jacobian[i * m + k]);
            }
            branches = fabs(along) <= across * size;
        }
    }
    saltus_shooting_free(shooting);
    free(a);
    saltus_orbits_noted(&x->orbits, status);
    return branches;
}

bool saltus_corner_ends_chatter(const saltus_solution *s, const saltus_breach *breach) {
    int k = breach->mark - 1;
    if (breach->kind != SALTUS_BREACH_HOLD)
        return false;
    while (k >= 0 && s->sequence.mark[k].face != breach->face)
        k--;
    return k < 0 || s->sequence.mark[k].kind != SALTUS_STICK;
}

saltus_point_kind saltus_corner_tell(saltus_extended *x, const saltus_locus_test *corner,
                                     const saltus_solution *s) {
    const saltus_breach *worst = worst_of(x, s);
    saltus_point_kind kind = corner->kind;
    if (corner->breach && worst && (worst->kind == SALTUS_BREACH_HOLD || worst->kind == SALTUS_BREACH_FORCE))
        kind = !saltus_corner_ends_chatter(s, worst) ? SALTUS_POINT_ST
               : x->kind == SALTUS_POINT_GR          ? SALTUS_POINT_CH_GR
                                                     : SALTUS_POINT_CH;
    if (x->kind == SALTUS_POINT_GR && kind == SALTUS_POINT_GR_LP &&
        !(x->mirrored && x->orbits.system->mirror) && is_branch_point(x, s, corner->without))
        kind = SALTUS_POINT_GR_BP;
    return kind;
}
