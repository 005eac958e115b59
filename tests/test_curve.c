/* Curves of solutions by pseudo-arclength, for equations with known curves.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "made_equations.h"

#include "branch/curve.h"

#include "allocations.h"

#include <errno.h>
#include <gsl/gsl_errno.h>

static int lacking_from = -1, allocations; /* the first allocation to fail; -1: none */

static bool refuse(void) {
    bool lacks = lacking_from >= 0 && allocations++ >= lacking_from;
    if (lacks)
        errno = ENOMEM;
    return lacks;
}

static const double pi = 3.14159265358979323846;

/* A known point of a curve, with its tangent on the side of `guide`; NULL: either side. */
static void place(made *m, const double *u, const double *guide, saltus_curve_point *point) {
    saltus_message message = {.text = ""};
    assert_true(saltus_curve_reserve(point, m->e.unknowns));
    memcpy(point->u, u, (size_t)m->e.unknowns * sizeof *u);
    check_ok(saltus_equations_evaluate(&m->e, u, &message), &message);
    check_ok(saltus_curve_orient(&m->e, guide, point, &message), &message);
}

static void swap(saltus_curve_point *a, saltus_curve_point *b) {
    saltus_curve_point kept = *a;
    *a = *b;
    *b = kept;
}

static double dot(const double *a, const double *b, int count) {
    double sum = 0;
    for (int j = 0; j < count; j++)
        sum += a[j] * b[j];
    return sum;
}

/* A tangent has unit length and the curve's direction, on the guide's side. */
static void points_have_tangents(void **state) {
    (void)state;
    unsigned long long seed = 1;
    for (int unknowns = 3; unknowns <= made_unknowns_max; unknowns += 2)
        for (int way = -1; way <= 1; way++) {
            made m;
            saltus_curve_point point = {0};
            double u[made_unknowns_max], exact[made_unknowns_max], guide[made_unknowns_max];
            made_open_helix(&m, unknowns, &seed);
            made_helix_at(unknowns, 3 * made_random(&seed), u, exact);
            for (int j = 0; j < unknowns; j++)
                guide[j] = way * exact[j] + 0.1 * made_random(&seed);
            place(&m, u, way ? guide : NULL, &point);
            double sign = way ? way : copysign(1, dot(exact, point.tangent, unknowns));
            for (int j = 0; j < unknowns; j++)
                check_near(point.tangent[j], sign * exact[j], 1e-12);
            check_near(point.residual, 0, 1e-14);
            double before = point.crossing.mantissa;
            assert_true(before == 1 || before == -1);
            saltus_curve_turn(&point);
            assert_true(point.crossing.mantissa == -before && !point.bent);
            check_near(dot(exact, point.tangent, unknowns), -sign, 1e-12);
            saltus_curve_clear(&point);
            made_close(&m);
        }
}

/* The point at a distance a along the tangent of the unit circle is at the angle asin a. */
static void a_point_ahead_is_on_its_hyperplane(void **state) {
    (void)state;
    made m;
    saltus_curve_point from = {0}, to = {0};
    saltus_message message = {.text = ""};
    made_open(&m, 2, made_ellipse, 1, 1);
    for (int k = 0; k < 24; k++) {
        double angle = 2 * pi * k / 24 + 0.1, u[2] = {cos(angle), sin(angle)}, guide[2] = {-u[1], u[0]};
        place(&m, u, guide, &from);
        for (double ahead = -0.6; ahead < 0.7; ahead += 0.2) {
            check_ok(saltus_curve_visit(&m.e, &from, ahead, &to, &message), &message);
            double there = angle + asin(ahead);
            check_near(to.u[0], cos(there), 1e-14);
            check_near(to.u[1], sin(there), 1e-14);
            /* The tangent of the last evaluation, accurate to the tolerance. */
            check_near(to.tangent[0], -sin(there), m.e.tolerance);
            check_near(to.tangent[1], cos(there), m.e.tolerance);
            assert_true(to.ahead == ahead);
        }
        /* The circle has no point that far ahead. */
        assert_int_not_equal(saltus_curve_visit(&m.e, &from, 1.2, &to, &message), SALTUS_OK);
    }
    saltus_curve_clear(&from);
    saltus_curve_clear(&to);
    made_close(&m);
}

/* Visited again from a point nearby, it is the same point, with less effort; the copy of a point has its
 * place. */
static void points_are_visited_again(void **state) {
    (void)state;
    made m;
    saltus_curve_point from = {0}, plain = {0}, again = {0};
    saltus_message message = {.text = ""};
    made_open(&m, 2, made_ellipse, 1, 1);
    double u[2] = {1, 0}, guide[2] = {0, 1};
    place(&m, u, guide, &from);
    check_ok(saltus_curve_visit(&m.e, &from, 0.3, &plain, &message), &message);
    assert_true(saltus_curve_copy(&plain, &again));
    assert_true(again.u[0] == plain.u[0] && again.tangent[1] == plain.tangent[1] && again.ahead == 0.3);
    for (double apart = 0.1; apart > 1e-9; apart /= 10)
        for (int side = -1; side <= 1; side += 2) {
            const double ahead = 0.3 + side * apart;
            check_ok(saltus_curve_visit(&m.e, &from, ahead, &plain, &message), &message);
            made_count(&m, 0, SALTUS_OK);
            check_ok(saltus_curve_revisit(&m.e, &from, ahead, &again), &message);
            assert_true(apart > 2e-6 || m.evaluations == 1);
            assert_true(again.ahead == ahead && !again.bent);
            check_near(again.u[0], sqrt(1 - ahead * ahead), 1e-14);
            check_near(again.u[1], ahead, 1e-14);
            check_near(again.tangent[0], plain.tangent[0], m.e.tolerance);
        }
    assert_int_not_equal(saltus_curve_revisit(&m.e, &from, 1.2, &again), SALTUS_OK);
    saltus_curve_clear(&from);
    saltus_curve_clear(&plain);
    saltus_curve_clear(&again);
    made_close(&m);
}

/* The length of an ellipse, by many chords. */
static double ellipse_length(double a, double b) {
    double sum = 0;
    enum { chords = 200000 };
    for (int k = 0; k < chords; k++) {
        double s = 2 * pi * k / chords, t = 2 * pi * (k + 1) / chords;
        sum += hypot(a * (cos(t) - cos(s)), b * (sin(t) - sin(s)));
    }
    return sum;
}

/* Once around an ellipse: all points lie on it, the direction never reverses, both folds are passed, no
 * crossing is found, and the length is the ellipse's less what chords cut off. */
static void around_an_ellipse(void **state) {
    (void)state;
    static const double sizes[][2] = {{1, 1}, {2, 0.5}, {0.3, 3}};
    for (int k = 0; k < 3; k++)
        for (int bends = 0; bends < 2; bends++) {
            made m;
            saltus_curve_point here = {0}, next = {0};
            saltus_message message = {.text = ""};
            double a = sizes[k][0], b = sizes[k][1], start[2] = {a * cos(1), b * sin(1)},
                   guide[2] = {-start[1], start[0]}, length = 0, step = 0.01, turned = 0;
            int reached, folds = 0;
            made_open(&m, 2, made_ellipse, a, b);
            place(&m, start, guide, &here);
            while (turned < 2 * pi && length < 100) {
                check_ok(saltus_curve_step(&m.e, &here, &step, NULL, 0, &next, &reached, &message), &message);
                assert_int_equal(reached, -1);
                check_near(hypot(next.u[0] / a, next.u[1] / b), 1, 1e-11);
                double normal[2] = {next.u[0] / (a * a), next.u[1] / (b * b)};
                check_near(dot(next.tangent, normal, 2) / hypot(normal[0], normal[1]), 0,
                           100 * m.e.tolerance);
                check_near(hypot(next.tangent[0], next.tangent[1]), 1, 1e-14);
                assert_true(dot(here.tangent, next.tangent, 2) > 0.92);
                assert_true(next.u[0] * next.tangent[1] - next.u[1] * next.tangent[0] > 0);
                assert_true(next.crossing.mantissa == here.crossing.mantissa);
                assert_true(next.ahead > 0 && next.ahead <= 0.1);
                folds += next.tangent[1] * here.tangent[1] < 0;
                double angle = atan2(next.u[1] / b, next.u[0] / a) - atan2(here.u[1] / b, here.u[0] / a);
                turned += angle < -pi ? angle + 2 * pi : angle;
                length += next.ahead;
                step = saltus_curve_next_step(step, next.iterations, 0.1);
                if (bends)
                    saltus_curve_bend(&here, &next);
                swap(&here, &next);
            }
            assert_int_equal(folds, 2);
            double whole = ellipse_length(a, b);
            assert_true(length < whole + 0.1 && length > 0.98 * whole);
            saltus_curve_clear(&here);
            saltus_curve_clear(&next);
            made_close(&m);
        }
}

/* Helices in many unknowns lead to the places of their formula, with known length. */
static void along_helices(void **state) {
    (void)state;
    unsigned long long seed = 3;
    for (int unknowns = 3; unknowns <= made_unknowns_max; unknowns += 2) {
        made m;
        saltus_curve_point here = {0}, next = {0};
        saltus_message message = {.text = ""};
        double u[made_unknowns_max], tangent[made_unknowns_max], speed = 1, length = 0, step = 0.02;
        int reached;
        made_open_helix(&m, unknowns, &seed);
        for (int k = 1; 2 * k < unknowns; k++)
            speed += k * k;
        made_helix_at(unknowns, 0, u, tangent);
        place(&m, u, tangent, &here);
        while (here.u[unknowns - 1] < 2) {
            check_ok(saltus_curve_step(&m.e, &here, &step, NULL, 0, &next, &reached, &message), &message);
            made_helix_at(unknowns, next.u[unknowns - 1], u, tangent);
            check_near(made_apart(next.u, u, unknowns), 0, 1e-12);
            check_near(made_apart(next.tangent, tangent, unknowns), 0, 1e-12);
            length += next.ahead;
            step = saltus_curve_next_step(step, next.iterations, 0.02);
            saltus_curve_bend(&here, &next);
            swap(&here, &next);
        }
        /* A step is shorter than its arc by about the curvature's square times its cube over 6. */
        double arc = sqrt(speed) * here.u[unknowns - 1];
        assert_true(length < arc && length > arc * (1 - 0.02 * 0.02 * 10));
        saltus_curve_clear(&here);
        saltus_curve_clear(&next);
        made_close(&m);
    }
}

/* A step is halved until the tangents at its ends are nearly parallel: on a circle until asin of it is below
 * the angle with cosine 0.92, and no further. */
static void steps_follow_the_bend(void **state) {
    (void)state;
    made m;
    saltus_curve_point from = {0}, to = {0};
    saltus_message message = {.text = ""};
    int reached;
    for (double radius = 0.01; radius < 100; radius *= 3) {
        double u[2] = {radius, 0}, guide[2] = {0, 1}, step = 1, longest = sin(acos(0.92)) * radius;
        made_open(&m, 2, made_ellipse, radius, radius);
        place(&m, u, guide, &from);
        check_ok(saltus_curve_step(&m.e, &from, &step, NULL, 0, &to, &reached, &message), &message);
        assert_true(step == to.ahead && step < longest);
        assert_true(step == 1 || 2 * step > longest);
        assert_true(exp2(round(log2(step))) == step);
        made_close(&m);
    }
    saltus_curve_clear(&from);
    saltus_curve_clear(&to);
}

/* The distance of the prediction at `ahead` from the helix. */
static double missed(made *m, const saltus_curve_point *from, double ahead, saltus_curve_point *to) {
    saltus_message message = {.text = ""};
    double on[made_unknowns_max], tangent[made_unknowns_max], best = INFINITY;
    int n = m->e.unknowns;
    made_count(m, 0, SALTUS_OK);
    check_ok(saltus_curve_visit(&m->e, from, ahead, to, &message), &message);
    /* The nearest point of the helix, from the one of the same height. */
    double s = m->first[n - 1];
    for (int k = 0; k < 30; k++) {
        made_helix_at(n, s, on, tangent);
        best = fmin(best, made_apart(m->first, on, n));
        double along = 0;
        for (int j = 0; j < n; j++)
            along += (m->first[j] - on[j]) * tangent[j];
        s += along * tangent[n - 1];
    }
    return best;
}

/* Straight predictions miss the curve by the square of the step, curved ones by its fourth power. */
static void order_of_predictions(void **state) {
    (void)state;
    unsigned long long seed = 4;
    for (int unknowns = 3; unknowns <= 7; unknowns += 2)
        for (int bends = 0; bends < 2; bends++) {
            made m;
            saltus_curve_point from = {0}, before = {0}, to = {0};
            double u[made_unknowns_max], tangent[made_unknowns_max], last = 0;
            made_open_helix(&m, unknowns, &seed);
            for (double step = 0.1; step > 0.02; step /= 2) {
                made_helix_at(unknowns, 0.3, u, tangent);
                place(&m, u, tangent, &from);
                made_helix_at(unknowns, 0.3 - step, u, tangent);
                place(&m, u, tangent, &before);
                from.bent = false;
                if (bends)
                    saltus_curve_bend(&before, &from);
                double ahead = made_apart(from.u, before.u, unknowns), miss = missed(&m, &from, ahead, &to);
                if (last > 0)
                    check_near(log2(last / miss), bends ? 4 : 2, 0.2);
                last = miss;
            }
            saltus_curve_clear(&from);
            saltus_curve_clear(&before);
            saltus_curve_clear(&to);
            made_close(&m);
        }
}

/* Where the curve meets a value of one unknown. */
static void curves_meet_borders(void **state) {
    (void)state;
    made m;
    saltus_curve_point from = {0}, to = {0};
    saltus_message message = {.text = ""};
    double u[2] = {2 * cos(0.7), 0.5 * sin(0.7)}, guide[2] = {-1, 0};
    made_open(&m, 2, made_ellipse, 2, 0.5);
    place(&m, u, guide, &from);
    for (int k = 0; k < 2; k++)
        for (double off = -0.04; off < 0.05; off += 0.02) {
            double value = u[k] + off, other;
            check_ok(saltus_curve_meet(&m.e, &from, k, value, &to, &message), &message);
            assert_true(to.u[k] == value);
            other = k ? 2 * sqrt(1 - 4 * value * value) : 0.5 * sqrt(1 - value * value / 4);
            check_near(to.u[1 - k], other, 1e-13);
            check_near(to.ahead, dot(to.u, from.tangent, 2) - dot(from.u, from.tangent, 2), 1e-15);
        }
    /* The ellipse has no such point. */
    assert_int_not_equal(saltus_curve_meet(&m.e, &from, 1, 0.6, &to, &message), SALTUS_OK);
    saltus_curve_clear(&from);
    saltus_curve_clear(&to);
    made_close(&m);
}

/* Follow a curve from a point to a bound; returns the number of steps. */
static int follow_to_border(made *m, const double *u, const double *guide, double step,
                            const saltus_curve_bound *bounds, int count, saltus_curve_point *end,
                            int *reached) {
    saltus_curve_point here = {0};
    saltus_message message = {.text = ""};
    double longest = step;
    int steps = 0;
    place(m, u, guide, &here);
    *reached = -1;
    while (*reached < 0 && steps < 1000) {
        check_ok(saltus_curve_step(&m->e, &here, &step, bounds, count, end, reached, &message), &message);
        for (int b = 0; b < count; b++) {
            double value = end->u[bounds[b].unknown];
            assert_true(value >= bounds[b].low && value <= bounds[b].high);
            assert_int_equal(*reached == b, value == bounds[b].low || value == bounds[b].high);
        }
        step = saltus_curve_next_step(step, end->iterations, longest);
        swap(&here, end);
        steps++;
    }
    assert_true(*reached >= 0);
    swap(&here, end);
    saltus_curve_clear(&here);
    return steps;
}

/* A step across a border ends on it, to the last bit, and says which; also if the curve bends out while its
 * tangent stays inside. */
static void steps_end_on_borders(void **state) {
    (void)state;
    unsigned long long seed = 5;
    made m;
    saltus_curve_point end = {0};
    int reached, seen[2][2] = {{0}};
    for (int k = 0; k < 200; k++) {
        /* Out of a box along a parabola that is bent one way or the other. */
        double a = 3 * made_random(&seed), low = -1 - made_random(&seed) / 2,
               high = 1 + made_random(&seed) / 2, rise = 0.4 + 0.38 * made_random(&seed),
               x = 0.9 * made_random(&seed) * fmin(fmin(-low, high), sqrt(rise / fabs(a))),
               u[2] = {x, a * x * x}, guide[2] = {made_random(&seed), 0},
               step = 0.02 + 0.5 * fabs(made_random(&seed));
        saltus_curve_bound bounds[2] = {{0, low, high}, {1, -rise, rise}};
        made_open(&m, 2, made_parabola, a, 0);
        int steps = follow_to_border(&m, u, guide, step, bounds, 2, &end, &reached);
        /* Where it leaves, by its formula. */
        double side = copysign(1, guide[0]), wall = side > 0 ? bounds[0].high : bounds[0].low,
               top = a > 0 ? bounds[1].high : bounds[1].low, there = side * sqrt(top / a);
        bool through_wall = fabs(wall) < fabs(there);
        assert_int_equal(reached, through_wall ? 0 : 1);
        if (through_wall)
            assert_true(end.u[0] == wall);
        else
            assert_true(end.u[1] == top);
        check_near(end.u[0], through_wall ? wall : there, 1e-11);
        check_near(end.u[1], a * end.u[0] * end.u[0], 1e-11);
        assert_true(end.ahead > 0 && steps < 400);
        seen[reached][side > 0]++;
        made_close(&m);
    }
    assert_true(seen[0][0] > 5 && seen[0][1] > 5 && seen[1][0] > 5 && seen[1][1] > 5);
    saltus_curve_clear(&end);
}

/* A branch with a fold just before a border does not end there, with one just beyond it does. */
static void folds_near_borders(void **state) {
    (void)state;
    for (int e = 2; e < 9; e++)
        for (int beyond = 0; beyond < 2; beyond++) {
            made m;
            saltus_curve_point end = {0};
            double apart = (beyond ? 1 : -1) * pow(10, -e), u[2] = {-0.3, -0.09}, guide[2] = {1, 0};
            saltus_curve_bound bounds[2] = {{0, -1, 0.5}, {1, -1, -apart}};
            int reached;
            made_open(&m, 2, made_parabola, -1, 0);
            follow_to_border(&m, u, guide, 0.1, bounds, 2, &end, &reached);
            assert_int_equal(reached, beyond);
            check_near(end.u[0], beyond ? -sqrt(apart) : 0.5, 1e-9);
            saltus_curve_clear(&end);
            made_close(&m);
        }
}

/* Along the line or the parabola through their crossing: the test changes its sign there, and only there. */
static void crossings_change_the_sign(void **state) {
    (void)state;
    for (int parabola = 0; parabola < 2; parabola++) {
        made m;
        saltus_curve_point from = {0}, before = {0}, to = {0};
        saltus_message message = {.text = ""};
        double guide[2] = {1, parabola ? -0.5 : 0.5}, last = -0.15;
        int changes = 0;
        made_open(&m, 2, made_crossing, 1, 2);
        /* Here only the curvature tells the curves apart. */
        for (int k = 0; k < 2; k++) {
            double x = k ? -0.15 : -0.2, u[2] = {1 + x, 2 + (parabola ? x * x : x / 2)};
            place(&m, u, guide, k ? &from : &before);
        }
        saltus_curve_bend(&before, &from);
        double sign = from.crossing.mantissa;
        /* The curves also cross at a + 1/2. */
        while (last < 0.2) {
            check_ok(saltus_curve_visit(&m.e, &from, 0.013, &to, &message), &message);
            double x = to.u[0] - 1;
            check_near(to.u[1] - 2, parabola ? x * x : x / 2, 1e-11);
            if (to.crossing.mantissa != sign) {
                changes++;
                assert_true(last <= 0 && x >= 0);
            }
            assert_true(x > last);
            sign = to.crossing.mantissa;
            last = x;
            saltus_curve_bend(&from, &to);
            swap(&from, &to);
        }
        assert_int_equal(changes, 1);
        saltus_curve_clear(&from);
        saltus_curve_clear(&before);
        saltus_curve_clear(&to);
        made_close(&m);
    }
}

/* Numbers in place of determinants: scaled, and cut where they would overflow. */
static void determinants_are_scaled(void **state) {
    (void)state;
    saltus_scaled number = {-1, 700};
    check_near(saltus_scaled_in(number, 699), -exp(1), 1e-15);
    check_near(saltus_scaled_in(number, 700), -1, 0);
    check_near(saltus_scaled_in(number, 1e4), 0, 1e-300);
    number.exponent = 1e6;
    assert_true(isfinite(saltus_scaled_in(number, 0)) && saltus_scaled_in(number, 0) < -1e200);
}

/* Steps end at a corner, as close to it as the shortest allowed. */
static void corners_end_curves(void **state) {
    (void)state;
    for (int way = -1; way <= 1; way += 2) {
        made m;
        saltus_curve_point here = {0}, next = {0};
        saltus_message message = {.text = ""};
        double u[2] = {0.4 - 0.37 * way, -0.1 + 0.185}, guide[2] = {way, -1}, step = 0.1;
        int reached, steps = 0;
        saltus_status status = SALTUS_OK;
        made_open(&m, 2, made_corner, 0.4, -0.1);
        place(&m, u, guide, &here);
        for (; status == SALTUS_OK && steps < 100; steps++) {
            status = saltus_curve_step(&m.e, &here, &step, NULL, 0, &next, &reached, &message);
            if (status == SALTUS_OK) {
                assert_true(way * (next.u[0] - 0.4) < 0);
                check_near(next.u[1] + 0.1, fabs(next.u[0] - 0.4) / 2, 1e-12);
                swap(&here, &next);
            }
        }
        assert_int_equal(status, SALTUS_NO_CONVERGENCE);
        assert_non_null(strstr(message.text, "corner"));
        check_near(here.u[0], 0.4, 1e-6);
        saltus_curve_clear(&here);
        saltus_curve_clear(&next);
        made_close(&m);
    }
}

/* Steps also end where nothing can be evaluated, with the error of the evaluation. */
static void places_without_value_end_curves(void **state) {
    (void)state;
    made m;
    saltus_curve_point here = {0}, next = {0};
    saltus_message message = {.text = ""};
    double u[2] = {-1, 0.25}, guide[2] = {1, 0}, step = 0.1;
    int reached, steps = 0;
    saltus_status status = SALTUS_OK;
    made_open(&m, 2, made_parabola, 0.25, 0);
    m.border = 0.123;
    place(&m, u, guide, &here);
    for (; status == SALTUS_OK && steps < 100; steps++) {
        status = saltus_curve_step(&m.e, &here, &step, NULL, 0, &next, &reached, &message);
        if (status == SALTUS_OK)
            swap(&here, &next);
    }
    assert_int_equal(status, SALTUS_STALLED);
    assert_non_null(strstr(message.text, "border"));
    assert_true(here.u[0] <= 0.123 && here.u[0] > 0.123 - 1e-6);
    saltus_curve_clear(&here);
    saltus_curve_clear(&next);
    made_close(&m);
}

/* Lack of memory ends a step at once, in any evaluation or allocation, and so does an interruption: no
 * shorter step is tried. */
static void lack_of_memory(void **state) {
    (void)state;
    made m;
    saltus_curve_point from = {0};
    saltus_message message = {.text = ""};
    double u[2] = {0, 1}, guide[2] = {1, 0};
    saltus_curve_bound bound = {0, -2, 0.05};
    int reached, told = 0, made_it = 0;
    made_open(&m, 2, made_ellipse, 1, 1);
    place(&m, u, guide, &from);
    for (int k = 2; k < 24; k++) {
        saltus_curve_point to = {0};
        double step = 0.1;
        int failing = k / 4 + 1, bounded = k / 2 % 2;
        saltus_status failure = k % 2 ? SALTUS_NO_MEMORY : SALTUS_INTERRUPTED;
        made_count(&m, failing, failure);
        saltus_status status =
            saltus_curve_step(&m.e, &from, &step, &bound, bounded, &to, &reached, &message);
        if (m.evaluations < failing) {
            assert_int_equal(status, SALTUS_OK);
            made_it++;
        } else {
            assert_int_equal(status, failure);
            assert_int_equal(m.evaluations, failing);
            assert_true(step == 0.1);
            told++;
        }
        saltus_curve_clear(&to);
    }
    assert_true(told >= 8 && made_it >= 4);
    made_count(&m, 0, SALTUS_OK);
    for (int bounded = 0; bounded < 2; bounded++)
        for (int k = 0, ended = 0; !ended; k++) {
            saltus_curve_point to = {0};
            double step = 0.1;
            lacking_from = k;
            allocations = 0;
            saltus_status status =
                saltus_curve_step(&m.e, &from, &step, &bound, bounded, &to, &reached, &message);
            lacking_from = -1;
            ended = allocations <= k;
            assert_int_equal(status, ended ? SALTUS_OK : SALTUS_NO_MEMORY);
            assert_true(step == 0.1);
            saltus_curve_clear(&to);
            assert_true(k < 50 && (k > 1 || !ended));
        }
    lacking_from = allocations = 0;
    saltus_status status = saltus_curve_orient(&m.e, NULL, &from, &message);
    lacking_from = -1;
    assert_int_equal(status, SALTUS_NO_MEMORY);
    saltus_curve_clear(&from);
    made_close(&m);
}

/* The lack of a tangent is reported. */
static void crossings_have_no_tangent(void **state) {
    (void)state;
    made m;
    saltus_curve_point point = {0};
    saltus_message message = {.text = ""};
    double u[2] = {1, 2}, guide[2] = {1, 0};
    made_open(&m, 2, made_crossing, 1, 2);
    assert_true(saltus_curve_reserve(&point, 2));
    memcpy(point.u, u, sizeof u);
    check_ok(saltus_equations_evaluate(&m.e, u, &message), &message);
    assert_int_equal(saltus_curve_orient(&m.e, guide, &point, &message), SALTUS_SINGULAR);
    assert_true(isnan(point.crossing.mantissa));
    saltus_curve_clear(&point);
    made_close(&m);
}

/* The hyperbola x y = b: two curves cross only if b is zero. */
static void hyperbola(const made *m, const double *u, double *residual, double *jacobian) {
    residual[0] = u[0] * u[1] - m->b;
    jacobian[0] = u[1];
    jacobian[1] = u[0];
}

/* Newton's method leads to where curves cross, though the equations are singular there, and says so where
 * they only come near one another, or where memory is lacking. */
static void crossings_are_settled(void **state) {
    (void)state;
    saltus_message message = {.text = ""};
    double error;
    made m;
    made_open(&m, 2, made_crossing, 1, 2);
    for (int k = 0; k < 16; k++) {
        double u[2] = {1 + 0.03 * cos(k), 2 + 0.03 * sin(k)};
        check_ok(saltus_curve_settle(&m.e, u, &error), &message);
        check_near(u[0], 1, 1e-14);
        check_near(u[1], 2, 1e-14);
        assert_true(error < 1e-8);
        check_near(m.e.size, 0, 1e-15);
    }
    saltus_status status = SALTUS_NO_MEMORY;
    int failed = 0;
    for (lacking_from = 0; status == SALTUS_NO_MEMORY; lacking_from++) {
        double u[2] = {1.01, 2.02};
        allocations = 0;
        status = saltus_curve_settle(&m.e, u, &error);
        failed += status == SALTUS_NO_MEMORY;
    }
    lacking_from = -1;
    assert_int_equal(status, SALTUS_OK);
    assert_true(failed > 1);
    made_close(&m);
    for (int k = 0; k < 3; k++) {
        double u[2] = {0.01, -0.02};
        made_open(&m, 2, hyperbola, 0, (k - 1) * 1e-4);
        status = saltus_curve_settle(&m.e, u, &error);
        assert_int_equal(status, k == 1 ? SALTUS_OK : SALTUS_NO_CONVERGENCE);
        made_close(&m);
    }
}

/* A function with known zeros, and where it fails. */
typedef struct known {
    int kind, calls;
    double zero, fails;
    bool none; /* NAN instead of a failure */
} known;

static bool known_at(void *context, double ahead, double *value) {
    known *k = context;
    double x = ahead - k->zero;
    k->calls++;
    *value = k->kind == 0 ? x : k->kind == 1 ? sin(3 * x) + x * x : k->kind == 2 ? x * x * x : expm1(40 * x);
    if (!(fabs(ahead) < fabs(k->fails)))
        *value = NAN;
    return k->none || fabs(ahead) < fabs(k->fails);
}

/* Zeros to the last bits, forwards and backwards, and their accuracy. */
static void zeros_are_located(void **state) {
    (void)state;
    unsigned long long seed = 6;
    int exact = 0;
    gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
    for (int n = 0; n < 400; n++) {
        double end = made_random(&seed), ends[] = {0, end}, values[2], place_of, width;
        known k = {.kind = n % 4, .zero = end * (0.5 + 0.49 * made_random(&seed)), .fails = INFINITY};
        known_at(&k, 0, &values[0]);
        known_at(&k, end, &values[1]);
        if (!(values[0] * values[1] < 0))
            continue;
        k.calls = 0;
        assert_true(saltus_curve_zero(solver, known_at, &k, ends, values, &place_of, &width));
        assert_in_range(k.calls, 1, 60);
        /* A zero of third order is only found to where the value underflows. */
        check_near(place_of, k.zero, k.kind == 2 ? 1e-5 : 1e-13);
        assert_true(width >= 0 && width <= fabs(end));
        double value;
        known_at(&k, place_of, &value);
        assert_int_equal(width == 0, value == 0);
        exact += width == 0;
    }
    assert_true(exact > 10);
    gsl_root_fsolver_free(solver);
}

/* Signs count however small the values at the ends are. */
static void zeros_between_tiny_values(void **state) {
    (void)state;
    static const double sizes[] = {1e-300, 1e-30, 1, 1e300};
    gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            for (int sign = -1; sign <= 1; sign += 2) {
                known k = {.zero = 0.3, .fails = INFINITY};
                const double ends[] = {0, 1}, values[] = {-sizes[i], sign * sizes[j]};
                double place_of = NAN, width;
                bool found = saltus_curve_zero(solver, known_at, &k, ends, values, &place_of, &width);
                if (found != (sign > 0))
                    fail_msg("%g to %g: %s", values[0], values[1], found ? "found" : "not found");
            }
    gsl_root_fsolver_free(solver);
}

/* No zero without a change of sign, or if a value fails or is not finite. */
static void zeros_that_cannot_be_had(void **state) {
    (void)state;
    gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
    double place_of, width;
    static const double ends[] = {0, 1}, far[] = {-1, 100},
                        values[][2] = {{1, 1}, {-1, -1}, {0, 1}, {1, 0}, {NAN, 1}, {-1, NAN}, {0, 0}};
    for (size_t n = 0; n < sizeof values / sizeof values[0]; n++) {
        known k = {.zero = 0.5, .fails = INFINITY};
        assert_false(saltus_curve_zero(solver, known_at, &k, ends, values[n], &place_of, &width));
        assert_int_equal(k.calls, 0);
    }
    for (int none = 0; none < 2; none++) {
        known k = {.kind = 3, .zero = 0.5, .fails = 0.1, .none = none};
        assert_false(saltus_curve_zero(solver, known_at, &k, ends, far, &place_of, &width));
    }
    gsl_root_fsolver_free(solver);
}

/* Easy steps lengthen the next one, hard ones shorten it, up to the longest allowed. */
static void steps_go_by_effort(void **state) {
    (void)state;
    for (int iterations = 0; iterations < 12; iterations++) {
        double next = saltus_curve_next_step(0.01, iterations, 1);
        assert_true(iterations <= 3 ? next > 0.01 : iterations > 5 ? next < 0.01 : next == 0.01);
        assert_true(next > 0.004 && next < 0.025);
        assert_true(saltus_curve_next_step(0.01, iterations, 0.005) == fmin(next, 0.005));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_have_tangents),
        cmocka_unit_test(a_point_ahead_is_on_its_hyperplane),
        cmocka_unit_test(points_are_visited_again),
        cmocka_unit_test(around_an_ellipse),
        cmocka_unit_test(along_helices),
        cmocka_unit_test(steps_follow_the_bend),
        cmocka_unit_test(order_of_predictions),
        cmocka_unit_test(curves_meet_borders),
        cmocka_unit_test(steps_end_on_borders),
        cmocka_unit_test(folds_near_borders),
        cmocka_unit_test(crossings_change_the_sign),
        cmocka_unit_test(determinants_are_scaled),
        cmocka_unit_test(corners_end_curves),
        cmocka_unit_test(places_without_value_end_curves),
        cmocka_unit_test(lack_of_memory),
        cmocka_unit_test(crossings_have_no_tangent),
        cmocka_unit_test(crossings_are_settled),
        cmocka_unit_test(zeros_are_located),
        cmocka_unit_test(zeros_between_tiny_values),
        cmocka_unit_test(zeros_that_cannot_be_had),
        cmocka_unit_test(steps_go_by_effort),
    };
    gsl_set_error_handler_off();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
