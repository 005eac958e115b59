/* Has a trajectory settled, and on which period?
 *
 * Points at phase 0 are compared with those p periods earlier, for every p up to the longest looked for; all
 * distances are relative to the system's scales. A period p is reached to within a limit when
 * - the last p + 2 points recur after p periods to better than `recurrence`,
 * - the remaining distance to the orbit is below the limit. It is estimated from how the recurrences shrink
 *   and turn from cycle to cycle: if they show the multiplier lambda, a recurrence of size s leaves the
 *   distance s |lambda| / |1 - lambda|,
 * - the last two cycles have equally many impacts and equally many other contact events.
 * If a proper divisor of p recurs too but gets no closer, the orbit may just have doubled its period, or be
 * about to and be approached slowly: iteration cannot tell which, and the period is in doubt.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/settle.h"

#include "orbit/lap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { seldom = 8 };
static const double recurrence = 1e-3;
static const double rounding = 1e-13; /* smaller recurrences are noise: their ratios mean nothing */
static const double slower =
    10; /* times the limit: within it a divisor of the period is reached too, beyond it is in doubt */
static const double least_ratio = 0.01; /* no faster shrinking per cycle is assumed, ... */
static const double worth_a_look = 200; /* ... so a recurrence above 200 limits leaves more than the limit */
static const double least_turn = 1e-6;  /* squared sine of the angle between recurrences that turn */
static const double at_rest = 1e-9;
static const double beside_impact = 1e-5; /* points nearer to an impact in the section lie after it */

bool saltus_settling_open(saltus_settling *s, int dimension, int longest) {
    int size = 4 * longest + 8;
    *s = (saltus_settling){.n = dimension, .longest = longest, .size = size};
    s->points = calloc((size_t)size * (size_t)dimension, sizeof *s->points);
    s->weight = calloc((size_t)dimension, sizeof *s->weight);
    s->impacts = calloc((size_t)size, sizeof *s->impacts);
    s->contact = calloc((size_t)size, sizeof *s->contact);
    s->streak = calloc((size_t)longest + 1, sizeof *s->streak);
    return s->points && s->weight && s->impacts && s->contact && s->streak;
}

void saltus_settling_close(saltus_settling *s) {
    free(s->points);
    free(s->weight);
    free(s->impacts);
    free(s->contact);
    free(s->streak);
    *s = (saltus_settling){0};
}

void saltus_settling_reset(saltus_settling *s, const saltus_system *system, double rtol) {
    const double *scale = saltus_system_scale(system);
    s->system = system;
    s->reach = saltus_system_forced(system) ? fmax(beside_impact, 100 * rtol) : 0;
    s->count = s->looked = 0;
    s->last = -1;
    for (int i = 0; i < s->n; i++)
        s->weight[i] = 1 / scale[i];
    memset(s->streak, 0, ((size_t)s->longest + 1) * sizeof *s->streak);
}

/* fmax without a function call: comparisons dominate the cost of a point. */
static inline double larger(double a, double b) {
    return b > a ? b : a;
}

/* Largest weighted difference; INFINITY once it is above `limit`. */
static double distance(const saltus_settling *s, const double *a, const double *b, double limit) {
    double largest = 0;
    for (int i = 0; i < s->n; i++) {
        double difference = fabs(a[i] - b[i]) * s->weight[i];
        if (!(difference <= limit))
            return INFINITY;
        largest = larger(largest, difference);
    }
    return largest;
}

/* Whether all weighted differences are below `recurrence`. */
static bool recurs(const saltus_settling *s, const double *a, const double *b) {
    for (int i = 0; i < s->n; i++)
        if (!(fabs(a[i] - b[i]) * s->weight[i] < recurrence))
            return false;
    return true;
}

void saltus_settling_add(saltus_settling *s, const double *state, long long impacts,
                         long long contact_events) {
    s->last = s->last + 1 < s->size ? s->last + 1 : 0;
    double *point = s->points + (size_t)s->last * (size_t)s->n;
    memcpy(point, state, (size_t)s->n * sizeof *state);
    if (s->reach > 0)
        impacts += saltus_section_point(s->system, point, s->reach, point, NULL);
    s->impacts[s->last] = impacts;
    s->contact[s->last] = contact_events;
    s->count++;
}

/* Bring the streaks up to date with the points added since the last look, but no farther than is asked for.
 */
static void look(saltus_settling *s) {
    const long long added = s->count - s->looked;
    const double *last = saltus_settling_point(s, 0);
    if (added == 0)
        return;
    for (int p = 1; p <= s->longest && p < s->count; p++) {
        int run = recurs(s, last, saltus_settling_point(s, p));
        while (run > 0 && run < added && run < p + 2 && run + p < s->count &&
               recurs(s, saltus_settling_point(s, run), saltus_settling_point(s, run + p)))
            run++;
        s->streak[p] = run == added ? s->streak[p] + run : run;
    }
    s->looked = s->count;
}

/* Largest distance between points p apart, over the last `points` points; INFINITY once it is above `limit`.
 */
static double recurrence_over(const saltus_settling *s, int p, int points, double limit) {
    double largest = 0;
    for (int k = 0; k < points && largest < INFINITY; k++)
        largest =
            larger(largest, distance(s, saltus_settling_point(s, k), saltus_settling_point(s, k + p), limit));
    return largest;
}

/* Scaled entry i of how much a point differs from another. */
static double recurred(const saltus_settling *s, const double *now, const double *before, int i) {
    return (now[i] - before[i]) * s->weight[i];
}

/* Scalar products of the recurrences of the last cycle (0) and of the two before it (1, 2). */
typedef struct products {
    double p00, p01, p02, p11, p12, p22;
} products;

/* Remaining distance if the recurrences spiral: fit each as a times the previous one plus b times the one
 * before that, and sum those to come. 0 if they turn too little to determine a and b, or if the fit does not
 * shrink. */
static double spiral_left(const saltus_settling *s, int p, const products *r) {
    double determinant = r->p11 * r->p22 - r->p12 * r->p12, largest = 0;
    if (!(determinant > least_turn * r->p11 * r->p22))
        return 0;
    double a = (r->p01 * r->p22 - r->p02 * r->p12) / determinant,
           b = (r->p02 * r->p11 - r->p01 * r->p12) / determinant;
    if (!(fabs(b) < 1 && fabs(a) < 1 - b))
        return 0;
    for (int k = 0; k < p; k++) {
        const double *x0 = saltus_settling_point(s, k), *x1 = saltus_settling_point(s, k + p),
                     *x2 = saltus_settling_point(s, k + 2 * p);
        for (int i = 0; i < s->n; i++) {
            const double r0 = recurred(s, x0, x1, i), r1 = recurred(s, x1, x2, i);
            largest = larger(largest, fabs((a + b) * r0 + b * r1));
        }
    }
    return largest / (1 - a - b);
}

/* Estimated distance to the orbit of period p; INFINITY if `shrinking` is required and the recurrences do not
 * shrink, or if it is surely above `limit`. */
static double distance_left(const saltus_settling *s, int p, bool shrinking, double limit) {
    /* Largest entries of the recurrences of the last cycle and of the two before it. */
    double now = 0, before = 0, first = 0;
    for (int k = 0; k < p; k++) {
        const double *x0 = saltus_settling_point(s, k), *x1 = saltus_settling_point(s, k + p),
                     *x2 = saltus_settling_point(s, k + 2 * p), *x3 = saltus_settling_point(s, k + 3 * p);
        for (int i = 0; i < s->n; i++) {
            now = larger(now, fabs(recurred(s, x0, x1, i)));
            before = larger(before, fabs(recurred(s, x1, x2, i)));
            first = larger(first, fabs(recurred(s, x2, x3, i)));
        }
    }
    if (now <= rounding)
        return now;
    double ratio = now / before;
    if (before > rounding && before / first > ratio)
        ratio = before / first;
    if (shrinking && !(ratio < 1))
        return INFINITY;
    const double reached = now * fmax(ratio, least_ratio);
    /* Twice: for rounding. */
    if (reached > 2 * limit * (1 + ratio))
        return INFINITY;
    products r = {0};
    for (int k = 0; k < p; k++) {
        const double *x0 = saltus_settling_point(s, k), *x1 = saltus_settling_point(s, k + p),
                     *x2 = saltus_settling_point(s, k + 2 * p), *x3 = saltus_settling_point(s, k + 3 * p);
        for (int i = 0; i < s->n; i++) {
            const double r0 = recurred(s, x0, x1, i), r1 = recurred(s, x1, x2, i),
                         r2 = recurred(s, x2, x3, i);
            r.p00 += r0 * r0;
            r.p01 += r0 * r1;
            r.p02 += r0 * r2;
            r.p11 += r1 * r1;
            r.p12 += r1 * r2;
            r.p22 += r2 * r2;
        }
    }
    double cosine = r.p00 > 0 && r.p11 > 0 ? r.p01 / sqrt(r.p00) / sqrt(r.p11) : 1,
           across = 1 - 2 * ratio * cosine + ratio * ratio;
    return fmax(reached / sqrt(fmax(across, 1e-30)), spiral_left(s, p, &r));
}

/* Growth of a counter over p periods that ended `back` periods ago. */
static long long difference_over(const saltus_settling *s, const long long *counter, int p, int back) {
    return counter[saltus_settling_place(s, back)] - counter[saltus_settling_place(s, back + p)];
}

static bool reached(const saltus_settling *s, int p, double limit) {
    if (s->streak[p] < p + 2 || s->count < 4 * p + 2)
        return false;
    /* If a proper divisor of p recurs, it is usually reached first: then look at p only at every eighth
     * point. */
    for (int part = 1; part <= p / 2 && s->count % seldom != 0; part++)
        if (p % part == 0 && s->streak[part] >= part + 2)
            return false;
    return difference_over(s, s->impacts, p, 0) == difference_over(s, s->impacts, p, p) &&
           difference_over(s, s->contact, p, 0) == difference_over(s, s->contact, p, p) &&
           recurrence_over(s, p, p, worth_a_look * limit) < INFINITY &&
           distance_left(s, p, true, limit) <= limit;
}

int saltus_settling_period(saltus_settling *s, double limit, bool *doubt) {
    *doubt = false;
    look(s);
    for (int p = 1; p <= s->longest; p++) {
        bool shorter = false; /* the orbit of a proper divisor is near too */
        if (!reached(s, p, limit))
            continue;
        for (int part = 1; part <= p / 2 && !*doubt; part++)
            if (p % part == 0 && recurrence_over(s, part, p, recurrence) < recurrence) {
                shorter = true;
                *doubt = distance_left(s, part, false, slower * limit) > slower * limit;
            }
        if (*doubt || !shorter)
            return p;
    }
    return 0;
}

long long saltus_settling_impacts(const saltus_settling *s, int period) {
    return difference_over(s, s->impacts, period, 0);
}

long long saltus_settling_contacts(const saltus_settling *s, int period) {
    return difference_over(s, s->contact, period, 0);
}

double saltus_settling_recurrence(const saltus_settling *s, int period) {
    return recurrence_over(s, period, period, INFINITY);
}

double saltus_settling_closest(const saltus_settling *s) {
    double closest = INFINITY;
    for (int p = 1; p <= s->longest && 2 * p + 2 < s->count; p++)
        closest = fmin(closest, recurrence_over(s, p, p + 2, INFINITY));
    return closest;
}

int saltus_settling_candidate(saltus_settling *s) {
    look(s);
    for (int p = 1; p <= s->longest; p++)
        if (s->streak[p] >= p + 2)
            return p;
    return 0;
}

bool saltus_settling_rests(const saltus_settling *s) {
    return s->count > 4 && recurrence_over(s, 1, 3, at_rest) < INFINITY &&
           difference_over(s, s->impacts, 3, 0) == 0 && difference_over(s, s->contact, 3, 0) == 0;
}
