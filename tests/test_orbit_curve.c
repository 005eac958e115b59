/* The curve of orbits with one event sequence, its special points and what follows them, for oscillators with
 * orbits in closed form; without a run of a branch.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "closed_orbits.h"

#include "branch/change.h"
#include "branch/sequence.h"
#include "branch/special.h"

#include <gsl/gsl_errno.h>

/* A family of orbits in one parameter. */
typedef struct family {
    closed_oscillator o;
    const char *key;
    saltus_orbits orbits;
} family;

static void open_family(family *f, const closed_oscillator *o, const char *key, double unit) {
    saltus_message message = {.text = ""};
    *f = (family){.o = *o, .key = key};
    saltus_orbits *orbits = &f->orbits;
    orbits->options = saltus_orbit_defaults();
    orbits->family = (saltus_family){.spec = closed_spec(o), .parameters = 1, .unit = {unit}};
    check_ok(saltus_spec_direction(&orbits->family.spec, key, &orbits->family.direction[0], &orbits->origin,
                                   &message),
             &message);
    check_ok(saltus_orbits_open(orbits, &message), &message);
}

static int face_of(const saltus_system *system, int side) {
    int f = 0;
    while (saltus_system_face(system, f).side != side)
        f++;
    return f;
}

/* The state of a closed orbit at a time (in periods) without an impact. */
static void closed_state_at(const closed_orbit *orbit, double periods, long double *x) {
    const closed_oscillator *o = &orbit->oscillator;
    long double length = o->periods * closed_period(o), time = periods * closed_period(o), last = INFINITY,
                start[2];
    int from = 0;
    for (int i = 0; i < orbit->impacts; i++) {
        long double since = fmodl(time - orbit->impact[i].time + 10 * length, length);
        if (since < last) {
            last = since;
            from = i;
        }
    }
    closed_after(o, &orbit->impact[from], start);
    closed_flight(o, orbit->impact[from].time, start, orbit->impact[from].time + last, x);
}

/* A closed orbit as a sequence, cut open in its first flight, at a share of it. */
static saltus_sequence sequence_of(const saltus_orbits *orbits, const closed_orbit *orbit, double share,
                                   double *state) {
    const closed_oscillator *o = &orbit->oscillator;
    long double period = closed_period(o), x[2];
    double first = (double)(orbit->impact[0].time / period), flight = (double)o->periods / orbit->impacts;
    saltus_sequence s = {.periods = o->periods, .count = orbit->impacts, .cuts = 1};
    s.base = s.cut[0] = fmod(first + share * flight, o->periods);
    closed_state_at(orbit, s.base, x);
    for (int i = 0; i < 2; i++)
        state[i] = (double)x[i];
    for (int i = 0; i < orbit->impacts; i++) {
        saltus_mark mark = {SALTUS_IMPACT, face_of(orbits->system, orbit->impact[i].side),
                            (double)(orbit->impact[i].time / period), false};
        mark.time += mark.time < s.base ? o->periods : 0;
        int k = i;
        for (; k > 0 && s.mark[k - 1].time > mark.time; k--)
            s.mark[k] = s.mark[k - 1];
        s.mark[k] = mark;
    }
    return s;
}

static double unknown_of(const saltus_orbits *orbits, double value) {
    return (value - orbits->origin) / orbits->family.unit[0];
}

/* Make a closed orbit a solution that heads up or down. */
static void place_closed(family *f, const closed_orbit *orbit, double share, int heading,
                         saltus_solution *out) {
    saltus_message message = {.text = ""};
    closed_oscillator o = orbit->oscillator;
    double state[2], parameter = unknown_of(&f->orbits, (double)*closed_value(&o, f->key));
    saltus_sequence s = sequence_of(&f->orbits, orbit, share, state);
    check_ok(saltus_solution_place(&f->orbits, &s, &parameter, state, true, out, &message), &message);
    if (out->at.tangent[out->at.unknowns - 1] * heading < 0)
        saltus_curve_turn(&out->at);
}

/* The closed orbit at a solution's parameter, on the sheet with the same impact speed. */
static closed_orbit closed_at(const family *f, const saltus_solution *s) {
    closed_oscillator o = f->o;
    closed_orbit orbit, nearest = {.impacts = 0};
    double speed[SALTUS_MARKS_MAX], apart = INFINITY;
    saltus_solution_speeds(&f->orbits, s, speed);
    *closed_value(&o, f->key) = s->value;
    for (int sheet = -1; sheet <= 1; sheet += 2)
        if (closed_orbit_at(&o, sheet, &orbit) && fabsl(orbit.impact[0].speed - speed[0]) < apart) {
            apart = (double)fabsl(orbit.impact[0].speed - speed[0]);
            nearest = orbit;
        }
    assert_true(nearest.impacts > 0);
    /* A lone impact may be in any of the orbit's periods. */
    long double period = closed_period(&o);
    if (nearest.impacts == 1)
        nearest.impact[0].time += period * roundl(s->sequence.mark[0].time - nearest.impact[0].time / period);
    return nearest;
}

/* Compare all that a solution holds of the orbit: state, times, speeds. */
static void check_solution(const family *f, const saltus_solution *s) {
    closed_orbit orbit = closed_at(f, s);
    double speed[SALTUS_MARKS_MAX];
    long double x[2];
    closed_state_at(&orbit, s->sequence.base, x);
    for (int i = 0; i < 2; i++)
        check_near(s->state[i], (double)x[i], 1e-10);
    saltus_solution_speeds(&f->orbits, s, speed);
    assert_int_equal(s->sequence.count, orbit.impacts);
    for (int k = 0; k < s->sequence.count; k++) {
        const saltus_mark *mark = &s->sequence.mark[k];
        int i = orbit.impacts == 2 &&
                saltus_system_face(f->orbits.system, mark->face).side != orbit.impact[0].side;
        double time = (double)(orbit.impact[i].time / closed_period(&orbit.oscillator));
        check_near(remainder(mark->time - time, s->sequence.periods), 0, 1e-10);
        check_near(speed[k], (double)orbit.impact[i].speed, 1e-10);
    }
    check_near(s->at.residual, 0, 1e-10);
    if (fabsl(orbit.margin) > 1e-6L && orbit.impact[0].speed > 1e-6L)
        assert_int_equal(s->worst.value < 0, orbit.admissible);
}

/* Oscillators with a first orbit and a parameter. */
static const struct {
    closed_example example;
    long double omega;
    const char *key;
    double unit;
} begins[] = {{closed_one_period, 1.1L, "omega", 1},      {closed_one_period, 1.1L, "F", 2},
              {closed_one_period_loaded, 1.2L, "d", 0.5}, {closed_two_periods, 0.85L, "omega", 0.3},
              {closed_two_periods_light, 0.85L, "d", 1},  {closed_mirrored, 3.6L, "omega", 2},
              {closed_mirrored, 3.52L, "r", 0.8},         {closed_mirrored_bubble, 1.2L, "omega", 3}};

enum { begin_count = sizeof begins / sizeof begins[0] };

static void open_begin(int k, family *f, closed_orbit *orbit) {
    closed_oscillator o = closed_example_of(begins[k].example);
    o.omega = begins[k].omega;
    assert_true(closed_orbit_at(&o, 1, orbit) && orbit->admissible);
    open_family(f, &o, begins[k].key, begins[k].unit);
}

/* Solutions placed on the closed orbit, corrected from nearby, and visited a little ahead and back. */
static void solutions_are_the_closed_orbits(void **state) {
    (void)state;
    for (int k = 0; k < begin_count; k++) {
        family f;
        closed_orbit orbit;
        saltus_solution s = {0}, to = {0};
        saltus_message message = {.text = ""};
        double beside[2];
        open_begin(k, &f, &orbit);
        for (double share = 0.2; share < 0.9; share += 0.3) {
            place_closed(&f, &orbit, share, 1, &s);
            check_solution(&f, &s);
            check_near(s.value, (double)*closed_value(&f.o, f.key), 0);
            double size = 0, parameter = s.parameter[0];
            for (int j = 0; j < s.at.unknowns; j++)
                size = hypot(size, s.at.tangent[j]);
            check_near(size, 1, 1e-14);
            saltus_sequence sequence = s.sequence;
            sequence.mark[0].time += 0.003;
            for (int i = 0; i < 2; i++)
                beside[i] = s.state[i] * (1 + 0.004 * (1 - 2 * i));
            check_ok(saltus_solution_place(&f.orbits, &sequence, &parameter, beside, true, &to, &message),
                     &message);
            check_solution(&f, &to);
            assert_true(to.at.iterations > 0);
            for (double ahead = -0.01; ahead < 0.011; ahead += 0.004) {
                assert_true(saltus_solution_visit(&f.orbits, &s, ahead, &to));
                assert_true((to.value - s.value) * ahead > 0);
                check_solution(&f, &to);
            }
        }
        saltus_solution_clear(&s);
        saltus_solution_clear(&to);
        saltus_orbits_close(&f.orbits);
    }
}

/* The parameter unknown of a border gives the border's value to the last bit, if any unknown does, and never
 * a value beyond. */
static void parameters_give_values_back(void **state) {
    (void)state;
    saltus_orbits o = {.origin = 0};
    unsigned long long seed = 7;
    int given = 0, beside = 0;
    for (int k = 0; k < 20000; k++) {
        double number[3];
        for (int j = 0; j < 3; j++) {
            seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
            number[j] = (double)(seed >> 11) * 0x1p-53;
        }
        o.origin = (k % 2 ? 10 : 0.1) * number[0];
        o.family.unit[0] = 0.1 + 5 * number[1];
        /* Within the range (its width is the unit), and larger than the parameter's rounding. */
        double value = (o.origin + o.family.unit[0] * (number[2] - 0.5)) * (1 + (k % 7) * 0x1p-50);
        double unit = o.family.unit[0], quotient = (value - o.origin) / unit;
        double back = o.origin + unit * saltus_orbits_border(o.origin, unit, value, k % 2), apart = INFINITY;
        for (int way = -1; way <= 1; way++) {
            double near = way ? nextafter(quotient, way * INFINITY) : quotient;
            apart = fmin(apart, fabs(o.origin + unit * near - value));
        }
        /* Where parameters are more widely spaced than values there may be none. */
        assert_int_equal(back == value, apart == 0);
        assert_true(k % 2 ? back <= value : back >= value);
        given += back == value;
        beside += back == value && o.origin + unit * quotient != value;
    }
    assert_true(given > 5000 && beside > 5);
}

/* The event-driven flow follows an admissible orbit, with the multipliers of the closed form. */
static void surveys_tell_the_multipliers(void **state) {
    (void)state;
    for (int k = 0; k < begin_count; k++) {
        family f;
        closed_orbit orbit;
        saltus_solution s = {0};
        saltus_message message = {.text = ""};
        char label[SALTUS_LABEL_MAX];
        open_begin(k, &f, &orbit);
        place_closed(&f, &orbit, 0.5, 1, &s);
        assert_false(s.survey.walked);
        check_ok(saltus_solution_survey(&f.orbits, &s, &message), &message);
        assert_true(s.survey.walked && s.survey.follows);
        assert_int_equal(s.survey.impacts, orbit.impacts);
        snprintf(label, sizeof label, "%d/%d", orbit.impacts, f.o.periods);
        assert_string_equal(s.survey.label, label);
        int unstable = 0;
        for (int i = 0; i < 2; i++) {
            double size = (double)hypotl(orbit.multiplier[i][0], orbit.multiplier[i][1]);
            check_near(s.survey.multipliers[i].re, (double)orbit.multiplier[i][0], 1e-8);
            check_near(fabs(s.survey.multipliers[i].im), (double)fabsl(orbit.multiplier[i][1]), 1e-8);
            unstable += size > 1;
        }
        assert_int_equal(s.survey.unstable, unstable);
        long double volume = 2 * orbit.impacts * logl(f.o.r) - f.o.c * f.o.periods * closed_period(&f.o);
        check_near(s.survey.log_volume, (double)volume, 1e-9);
        check_near(s.survey.sum_rule, (double)volume, 1e-12);
        check_near(s.survey.circle[2], expm1((double)volume), 1e-9);
        assert_true(fabs(saltus_pair_off_circle(&s.survey)) > 1e-6);
        saltus_solution_clear(&s);
        saltus_orbits_close(&f.orbits);
    }
}

/* The state at any time of the orbit, before and after impacts. */
static void states_in_between(void **state) {
    (void)state;
    for (int k = 0; k < begin_count; k++) {
        family f;
        closed_orbit orbit;
        saltus_solution s = {0};
        saltus_message message = {.text = ""};
        open_begin(k, &f, &orbit);
        place_closed(&f, &orbit, 0.4, 1, &s);
        for (double share = 0; share < 1; share += 0.0625) {
            double time = s.sequence.base + share * s.sequence.periods, x[2];
            long double exact[2];
            closed_state_at(&orbit, time, exact);
            check_ok(saltus_solution_state_at(&f.orbits, &s, time, x, &message), &message);
            for (int i = 0; i < 2; i++)
                check_near(x[i], (double)exact[i], 1e-10);
            /* The shooting is unchanged. */
            assert_int_equal(f.orbits.shooting->sequence.cuts, 1);
        }
        saltus_solution_clear(&s);
        saltus_orbits_close(&f.orbits);
    }
}

/* An orbit traversed twice has half its period, a mirrored one is its own image; others are neither. */
static void halves_and_images(void **state) {
    (void)state;
    for (int k = 0; k < begin_count; k++) {
        family f;
        closed_orbit orbit;
        saltus_solution s = {0}, twice = {0};
        saltus_message message = {.text = ""};
        saltus_sequence both;
        open_begin(k, &f, &orbit);
        place_closed(&f, &orbit, 0.5, 1, &s);
        assert_true(saltus_sequence_join(&s.sequence, &s.sequence, &both));
        double apart = saltus_solution_part_distance(&f.orbits, &s, 2, NULL);
        if (f.o.periods % 2)
            assert_true(isinf(apart));
        else
            assert_true(apart > 1e-2 && isfinite(apart));
        double image = saltus_solution_part_distance(&f.orbits, &s, 1, NULL);
        assert_int_equal(image < 1e-9, f.o.mirrored);
        assert_true(f.o.mirrored || image > 1e-2);
        check_ok(saltus_solution_place(&f.orbits, &both, s.parameter, s.state, true, &twice, &message),
                 &message);
        check_near(saltus_solution_part_distance(&f.orbits, &twice, 2, NULL), 0, 1e-9);
        saltus_solution_clear(&s);
        saltus_solution_clear(&twice);
        saltus_orbits_close(&f.orbits);
    }
}

/* An orbit cut open just after its impact is cut elsewhere: it remains the same, with its heading. */
static void reframed_orbits_are_the_same(void **state) {
    (void)state;
    for (int k = 0; k < begin_count; k++)
        for (int heading = -1; heading <= 1; heading += 2) {
            family f;
            closed_orbit orbit;
            saltus_solution s = {0}, scratch = {0};
            int order[SALTUS_MARKS_MAX];
            open_begin(k, &f, &orbit);
            place_closed(&f, &orbit, 0.5, heading, &s);
            double base = s.sequence.base;
            assert_false(saltus_solution_reframe(&f.orbits, true, false, &s, &scratch, order));
            assert_true(s.sequence.base == base);
            place_closed(&f, &orbit, 0.03, heading, &s);
            base = s.sequence.base;
            double slope = s.at.tangent[s.at.unknowns - 1];
            assert_true(saltus_solution_reframe(&f.orbits, true, false, &s, &scratch, order));
            assert_true(s.sequence.base != base);
            assert_true(slope * heading > 0 && s.at.tangent[s.at.unknowns - 1] * heading > 0);
            check_solution(&f, &s);
            saltus_solution_clear(&s);
            saltus_solution_clear(&scratch);
            saltus_orbits_close(&f.orbits);
        }
}

/* A special point that is known, and a place before it. */
typedef struct known_point {
    closed_example example;
    long double omega, low, high;
    int sheet, heading;
    saltus_test test;
    saltus_point_kind kind;
} known_point;

static const known_point known_points[] = {
    {closed_one_period, 1.1L, 1.5L, 1.6L, 1, 1, SALTUS_TEST_FOLD, SALTUS_POINT_LP},
    {closed_one_period, 1.1L, 0.95L, 0.97L, 1, -1, SALTUS_TEST_FLIP, SALTUS_POINT_PD},
    {closed_one_period, 0.9L, 0.65L, 0.8L, 1, -1, SALTUS_TEST_BREACH, SALTUS_POINT_GR},
    {closed_one_period_loaded, 1.2L, 1.6L, 1.7L, 1, 1, SALTUS_TEST_FOLD, SALTUS_POINT_LP},
    {closed_two_periods, 0.85L, 0.9L, 0.95L, 1, 1, SALTUS_TEST_FLIP, SALTUS_POINT_PD},
    {closed_two_periods, 0.97L, 0.985L, 0.993L, 1, 1, SALTUS_TEST_BREACH, SALTUS_POINT_GR},
    {closed_mirrored, 3.6L, 3.4L, 3.55L, 1, -1, SALTUS_TEST_CROSSING, SALTUS_POINT_BP},
    {closed_mirrored_bubble, 3.5L, 3.6L, 3.8L, 1, 1, SALTUS_TEST_FOLD, SALTUS_POINT_LP},
};

enum { known_count = sizeof known_points / sizeof known_points[0] };

static closed_orbit find_known(const known_point *p, const closed_oscillator *o) {
    closed_orbit orbit;
    bool found = p->test == SALTUS_TEST_FOLD       ? closed_fold(o, "omega", p->low, p->high, &orbit)
                 : p->test == SALTUS_TEST_FLIP     ? closed_flip(o, "omega", p->low, p->high, &orbit)
                 : p->test == SALTUS_TEST_CROSSING ? closed_pitchfork(o, "omega", p->low, p->high, &orbit)
                 : o->periods == 1                 ? closed_grazing(o, "omega", p->low, p->high, &orbit)
                                   : closed_touch(o, "omega", p->low, p->high, p->sheet, &orbit);
    if (!found)
        fail_msg("no %s of the closed orbits between %Lg and %Lg", saltus_point_word(p->kind), p->low,
                 p->high);
    return orbit;
}

static void swap(saltus_solution *a, saltus_solution *b) {
    saltus_solution kept = *a;
    *a = *b;
    *b = kept;
}

/* Step from a known orbit until a test changes sign between `from` and `to`. */
static void step_over(family *f, const known_point *p, saltus_solution *from, saltus_solution *to) {
    saltus_message message = {.text = ""};
    closed_orbit begin;
    closed_oscillator o = closed_example_of(p->example);
    double step = 0.01;
    int reached, steps = 0;
    o.omega = p->omega;
    assert_true(closed_orbit_at(&o, p->sheet, &begin) && begin.admissible);
    open_family(f, &o, "omega", 1);
    place_closed(f, &begin, 0.5, p->heading, from);
    for (;; steps++) {
        assert_true(steps < 400);
        check_ok(
            saltus_curve_step(f->orbits.equations, &from->at, &step, NULL, 0, &to->at, &reached, &message),
            &message);
        check_ok(saltus_solution_see(&f->orbits, to, &message), &message);
        if (saltus_test_value(p->test, 0, from, from) * saltus_test_value(p->test, 0, to, from) < 0)
            return;
        swap(from, to);
        step = fmin(1.5 * step, 0.01);
    }
}

/* Special points lie where the closed form has them. */
static void zeros_are_the_closed_points(void **state) {
    (void)state;
    for (int k = 0; k < known_count; k++) {
        const known_point *p = &known_points[k];
        family f;
        saltus_solution from = {0}, to = {0}, at = {0};
        step_over(&f, p, &from, &to);
        closed_orbit known = find_known(p, &f.o);
        saltus_zero zero = p->test == SALTUS_TEST_CROSSING
                               ? saltus_solution_crossing(&f.orbits, SALTUS_TEST_CROSSING, &from,
                                                          0.5 * to.at.ahead, to.at.ahead, &at)
                               : saltus_solution_zero(&f.orbits, p->test, 0, &from, &to, &at);
        if (p->test == SALTUS_TEST_CROSSING && !zero.found) {
            /* The middle of the step was too far away. */
            zero = saltus_solution_zero(&f.orbits, p->test, 0, &from, &to, &at);
            assert_true(zero.found);
            zero = saltus_solution_crossing(&f.orbits, SALTUS_TEST_CROSSING, &from, zero.ahead, to.at.ahead,
                                            &at);
        }
        assert_true(zero.found);
        assert_true(zero.ahead > 0 && zero.ahead < to.at.ahead);
        check_near(at.value, (double)known.oscillator.omega, p->test == SALTUS_TEST_CROSSING ? 2e-11 : 1e-10);

        assert_true(zero.accuracy >= 0 && zero.accuracy < 1e-9);
        saltus_solution_clear(&from);
        saltus_solution_clear(&to);
        saltus_solution_clear(&at);
        saltus_orbits_close(&f.orbits);
    }
}

/* Where an impact dies is told from two orbits before, and found from the second of them by an equation of
 * its own, however slow the impact is, and however far that is along the curve. */
static void grazing_is_found_at_once(void **state) {
    (void)state;
    const known_point *p = &known_points[2];
    family f;
    saltus_solution from = {0}, to = {0}, at = {0};
    step_over(&f, p, &from, &to);
    closed_orbit known = find_known(p, &f.o);
    for (double apart = 4e-3; apart > 1e-5; apart /= 4) {
        assert_true(saltus_solution_visit(&f.orbits, &from, -2 * apart, &to));
        assert_true(saltus_solution_visit(&f.orbits, &to, apart, &at));
        assert_true(at.grazes_ahead == 0);
        saltus_solution_expect_grazing(&at, &to);
        swap(&from, &at);
        saltus_zero zero = saltus_solution_graze(&f.orbits, &from, &at);
        assert_true(zero.found && zero.accuracy < 1e-10 && at.at.iterations <= 6);
        /* Half of the way at worst, where the curve's length is that of the impact's time. */
        assert_true(from.grazes_ahead > 0.4 * zero.ahead && from.grazes_ahead < zero.ahead);
        check_near(at.value, (double)known.oscillator.omega, 1e-11);
        check_near(at.worst.value, 0, 1e-12);
        assert_int_equal(saltus_solution_touch(&at)->kind, SALTUS_BREACH_SPEED);
        /* Where an impact becomes faster none is expected. */
        saltus_curve_turn(&to.at);
        assert_true(saltus_solution_visit(&f.orbits, &to, apart, &at));
        saltus_solution_expect_grazing(&at, &to);
        assert_true(at.grazes_ahead == 0);
    }
    saltus_solution_clear(&from);
    saltus_solution_clear(&to);
    saltus_solution_clear(&at);
    saltus_orbits_close(&f.orbits);
}

/* A requested value within a step is met to the last digits; one beyond its end is not found. */
static void values_are_met(void **state) {
    (void)state;
    family f;
    closed_orbit orbit;
    saltus_solution from = {0}, to = {0}, at = {0};
    open_begin(0, &f, &orbit);
    place_closed(&f, &orbit, 0.5, 1, &from);
    assert_true(saltus_solution_visit(&f.orbits, &from, 0.02, &to));
    for (double share = 0.05; share < 1; share += 0.15) {
        double target = from.value + share * (to.value - from.value);
        saltus_zero zero = saltus_solution_zero(&f.orbits, SALTUS_TEST_VALUE, target, &from, &to, &at);
        assert_true(zero.found);
        check_near(at.value, target, 1e-13);
        check_solution(&f, &at);
    }
    assert_false(saltus_solution_zero(&f.orbits, SALTUS_TEST_VALUE, to.value + 0.01, &from, &to, &at).found);
    saltus_solution_clear(&from);
    saltus_solution_clear(&to);
    saltus_solution_clear(&at);
    saltus_orbits_close(&f.orbits);
}

/* All points on a step are found, in order: the special point and the requested values, nothing else. */
static void all_of_a_step_is_found(void **state) {
    (void)state;
    for (int k = 0; k < known_count; k++) {
        const known_point *p = &known_points[k];
        family f;
        saltus_solution from = {0}, to = {0}, at = {0};
        saltus_message message = {.text = ""};
        saltus_special found[8];
        if (p->test == SALTUS_TEST_BREACH)
            continue;
        step_over(&f, p, &from, &to);
        check_ok(saltus_solution_survey(&f.orbits, &from, &message), &message);
        /* The shooting must hold the point seen last. */
        check_ok(saltus_solution_survey(&f.orbits, &to, &message), &message);
        closed_orbit known = find_known(p, &f.o);
        const double targets[3] = {from.value + 0.6 * (to.value - from.value), from.value + 7,
                                   from.value + 0.1 * (to.value - from.value)};
        saltus_special wanted[3];
        for (int k = 0; k < 3; k++)
            wanted[k] =
                (saltus_special){.kind = SALTUS_POINT_UZ, .test = SALTUS_TEST_VALUE, .target = targets[k]};
        bool hidden;
        int count = saltus_special_find(&f.orbits, &from, &to, false, NULL, wanted, 3, found, &hidden, &at),
            special = -1;
        assert_int_equal(count, 3);
        assert_false(hidden);
        for (int j = 0; j < count; j++) {
            assert_true(j == 0 || found[j].ahead >= found[j - 1].ahead);
            assert_true(saltus_special_visit(&f.orbits, &from, to.at.ahead, &found[j], &at));
            assert_true(!found[j].end && !found[j].lost);
            if (found[j].kind == SALTUS_POINT_UZ)
                continue;
            special = j;
            assert_int_equal(found[j].kind, p->kind);
            check_near(found[j].value, (double)known.oscillator.omega, 1e-9);
            double critical = INFINITY, wanted = p->kind == SALTUS_POINT_PD ? -1 : 1;
            for (int i = 0; i < 2; i++)
                critical = fmin(critical, fabs(at.survey.multipliers[i].re - wanted));
            check_near(critical, 0, 1e-6);
        }
        assert_true(special >= 0);
        saltus_solution_clear(&from);
        saltus_solution_clear(&to);
        saltus_solution_clear(&at);
        saltus_orbits_close(&f.orbits);
    }
}

/* Where branches leave, the tangent of a start has unit length; along it neither the parameter nor the
 * equations, at a flip those of twice the orbit, change. */
static void branches_leave_along_null_vectors(void **state) {
    (void)state;
    for (int k = 0; k < known_count; k++) {
        const known_point *p = &known_points[k];
        family f;
        saltus_solution from = {0}, to = {0}, at = {0}, first = {0};
        saltus_message message = {.text = ""};
        saltus_starts starts = {0};
        saltus_branch_start like = {.parent = 3, .depth = 2};
        bool flips = p->kind == SALTUS_POINT_PD;
        if (!flips && p->kind != SALTUS_POINT_BP)
            continue;
        step_over(&f, p, &from, &to);
        saltus_zero zero = saltus_solution_zero(&f.orbits, p->test, 0, &from, &to, &at);
        assert_true(zero.found);
        if (!flips)
            assert_true(
                saltus_solution_crossing(&f.orbits, SALTUS_TEST_CROSSING, &from, zero.ahead, to.at.ahead, &at)
                    .found);
        check_ok(saltus_starts_leave(&f.orbits, &at, p->kind, NULL, &like, &starts, &message), &message);
        assert_int_equal(starts.count, 1);
        const saltus_branch_start *start = &starts.start[0];
        assert_true(start->parent == 3 && start->depth == 2 && start->origin == p->kind);
        assert_int_equal(start->sequence.periods, (1 + flips) * at.sequence.periods);
        assert_int_equal(start->sequence.count, (1 + flips) * at.sequence.count);
        check_ok(saltus_solution_restore(&f.orbits, &start->sequence, start->parameter, start->state, false,
                                         &first, &message),
                 &message);
        const saltus_equations *e = f.orbits.equations;
        assert_int_equal(start->unknowns, e->unknowns);
        double size = 0;
        for (int j = 0; j < e->unknowns; j++)
            size = hypot(size, start->tangent[j]);
        check_near(size, 1, 1e-12);
        check_near(start->tangent[e->count], 0, 1e-12);
        for (int i = 0; i < e->count; i++) {
            double sum = 0;
            for (int j = 0; j < e->unknowns; j++)
                sum += e->jacobian[i * e->unknowns + j] * start->tangent[j];
            check_near(sum, 0, 1e-5);
        }
        saltus_starts_clear(&starts);
        assert_true(starts.count == 0 && !starts.start);
        saltus_solution_clear(&from);
        saltus_solution_clear(&to);
        saltus_solution_clear(&at);
        saltus_solution_clear(&first);
        saltus_orbits_close(&f.orbits);
    }
}

/* Beyond a grazing the orbit has one impact more or less, and a further point follows the flow. Orbits of
 * twice the period may leave there. */
static void grazing_is_passed(void **state) {
    (void)state;
    int passed = 0;
    for (int k = 0; k < known_count; k++) {
        const known_point *p = &known_points[k];
        family f;
        saltus_solution from = {0}, to = {0}, at = {0}, here = {0}, next = {0};
        saltus_sequence beyond;
        saltus_change change;
        saltus_message message = {.text = ""};
        saltus_starts starts = {0};
        saltus_branch_start like = {.parent = 1};
        if (p->kind != SALTUS_POINT_GR)
            continue;
        step_over(&f, p, &from, &to);
        assert_true(saltus_solution_zero(&f.orbits, p->test, 0, &from, &to, &at).found);
        bool touch = at.worst.kind == SALTUS_BREACH_GAP;
        assert_int_equal(touch, f.o.periods == 2);
        saltus_change_graze(&f.orbits, &from, &at, &beyond, &here, &next, &change);
        assert_int_equal(change.kind, SALTUS_POINT_GR);
        assert_int_equal(beyond.count, touch ? 2 : 0);
        assert_string_equal(change.reason, touch ? "an impact is born" : "an impact dies");
        assert_string_equal(change.after, touch ? "2/2" : "0/1");
        for (int i = 0; i < 2; i++)
            check_near(here.state[i], at.state[i], 1e-12);
        check_near(here.value, at.value, 1e-14);
        assert_true(next.survey.follows && next.worst.value < 0 && change.distance > 0);
        double way = (next.value - at.value) * at.at.tangent[at.at.unknowns - 1];
        assert_int_equal(change.turns_back, way < 0);
        if (!touch) {
            closed_oscillator o = f.o;
            long double x[2];
            o.omega = next.value;
            closed_steady(&o, next.sequence.base * closed_period(&o), x);
            for (int i = 0; i < 2; i++)
                check_near(next.state[i], (double)x[i], 1e-10);
            assert_true(closed_amplitude(&o, &(long double){0}) < o.d);
        }
        check_ok(saltus_starts_leave(&f.orbits, &at, p->kind, &beyond, &like, &starts, &message), &message);
        assert_int_equal(starts.count, 1);
        assert_true(starts.start[0].origin == SALTUS_POINT_GR && starts.start[0].unknowns == 0);
        assert_int_equal(starts.start[0].sequence.periods, 2 * f.o.periods);
        assert_int_equal(starts.start[0].sequence.count, beyond.count + at.sequence.count);
        /* No such orbits are sought if two impacts appear at once. */
        at.sequence.count = beyond.count + 2;
        check_ok(saltus_starts_leave(&f.orbits, &at, p->kind, &beyond, &like, &starts, &message), &message);
        assert_int_equal(starts.count, 1);
        passed++;
        saltus_starts_clear(&starts);
        saltus_solution_clear(&from);
        saltus_solution_clear(&to);
        saltus_solution_clear(&at);
        saltus_solution_clear(&here);
        saltus_solution_clear(&next);
        saltus_orbits_close(&f.orbits);
    }
    assert_int_equal(passed, 2);
}

/* The same change without a known sequence: the last orbit before it is that of the closed form, and the next
 * has the events of the flow. If the range ends too soon there is no next one, nor if only orbits of a part
 * of the period are near. */
static void changes_are_leapt_over(void **state) {
    (void)state;
    for (int k = 0; k < known_count; k++)
        for (int ends = 0; ends < 2; ends++) {
            const known_point *p = &known_points[k];
            family f;
            saltus_solution from = {0}, to = {0}, at = {0}, here = {0}, scratch = {0};
            saltus_change change;
            if (p->kind != SALTUS_POINT_GR)
                continue;
            step_over(&f, p, &from, &to);
            closed_orbit known = find_known(p, &f.o);
            double place = unknown_of(&f.orbits, (double)known.oscillator.omega);
            const double room = ends ? 1e-7 : 0.5, range[2] = {place - room, place + room};
            const bool shorter = p->example == closed_two_periods;
            saltus_change_leap(&f.orbits, &from, to.at.ahead, SALTUS_LEAP_EVENTS, "made up", range, &at,
                               &here, &scratch, &change);
            /* The flow follows a maximum up to the stop, and an impact down to some slowness. */
            check_near(at.value, (double)known.oscillator.omega, shorter ? 1e-9 : 1e-8);
            if (shorter)
                check_near(at.value, (double)known.oscillator.omega, 100 * change.accuracy + 1e-12);
            assert_true(at.survey.follows && !(at.worst.value > 0));
            assert_int_equal(change.kind, ends || shorter ? SALTUS_POINT_EP : SALTUS_POINT_GR);
            assert_string_equal(change.after, ends || shorter ? "" : "0/1");
            if (ends || shorter) {
                assert_string_equal(change.reason, "made up");
            } else {
                assert_true(here.survey.follows && here.sequence.count == 0 && here.worst.value < 0);
                check_near((here.value - at.value) * p->heading, change.distance, 1e-9);
                assert_true(here.at.tangent[here.at.unknowns - 1] * p->heading > 0);
            }
            saltus_solution_clear(&from);
            saltus_solution_clear(&to);
            saltus_solution_clear(&at);
            saltus_solution_clear(&here);
            saltus_solution_clear(&scratch);
            saltus_orbits_close(&f.orbits);
        }
}

/* Lack of memory is remembered, whatever status follows. */
static void lack_of_memory_is_remembered(void **state) {
    (void)state;
    saltus_orbits o = {.n = 0};
    assert_int_equal(saltus_orbits_noted(&o, SALTUS_SINGULAR), SALTUS_SINGULAR);
    assert_false(o.starved);
    assert_int_equal(saltus_orbits_noted(&o, SALTUS_NO_MEMORY), SALTUS_NO_MEMORY);
    assert_int_equal(saltus_orbits_noted(&o, SALTUS_OK), SALTUS_OK);
    assert_true(o.starved);
}

/* The list keeps copies of its own, in order. */
static void starts_are_kept(void **state) {
    (void)state;
    enum { count = 20, n = 3, unknowns = 7 };
    saltus_starts starts = {0};
    bool starved = false;
    for (int k = 0; k < count; k++) {
        double at[n], tangent[unknowns];
        saltus_branch_start start = {.parameter = {k},
                                     .state = at,
                                     .tangent = tangent,
                                     .states = n,
                                     .unknowns = k % 2 ? unknowns : 0,
                                     .heading = k % 3 - 1};
        for (int i = 0; i < n; i++)
            at[i] = 10 * k + i;
        for (int j = 0; j < start.unknowns; j++)
            tangent[j] = 100 * k + j;
        start.sequence.periods = k + 1;
        saltus_starts_add(&starts, &start, &starved);
        assert_true(!starved && starts.count == k + 1);
    }
    for (int k = 0; k < count; k++) {
        /* Half of them are taken out, in order; the others are read in place. */
        saltus_branch_start taken = k < count / 2 ? saltus_starts_take(&starts) : (saltus_branch_start){0};
        const saltus_branch_start *start = k < count / 2 ? &taken : &starts.start[k - count / 2];
        assert_int_equal(starts.begun + starts.count, count);
        assert_true(start->parameter[0] == k && start->heading == k % 3 - 1 &&
                    start->sequence.periods == k + 1);
        for (int i = 0; i < n; i++)
            assert_true(start->state[i] == 10 * k + i);
        assert_int_equal(start->unknowns, k % 2 ? unknowns : 0);
        for (int j = 0; j < start->unknowns; j++)
            assert_true(start->tangent[j] == 100 * k + j);
        saltus_branch_start_clear(&taken);
    }
    assert_int_equal(starts.begun, count / 2);
    saltus_starts_clear(&starts);
    assert_true(!starts.start && starts.count == 0 && starts.begun == 0);
    saltus_starts_clear(&starts);
}

/* Event times outside the orbit are refused before the flow runs: to such late times it would take for
 * ever. */
static void times_beyond_the_orbit(void **unused) {
    (void)unused;
    const double aside[] = {-1e12, -1e-3, 1e-3, 1e12};
    closed_oscillator o = closed_example_of(closed_one_period);
    closed_orbit orbit;
    family f;
    o.omega = 1.1L;
    assert_true(closed_orbit_at(&o, 1, &orbit));
    open_family(&f, &o, "omega", 1);
    double state[2], parameter = 0;
    saltus_message message = {.text = ""};
    saltus_solution at = {.value = 0};
    saltus_sequence sequence = sequence_of(&f.orbits, &orbit, 0.5, state);
    check_ok(saltus_solution_place(&f.orbits, &sequence, &parameter, state, true, &at, &message), &message);
    double *time = &at.at.u[2], own = *time;
    for (int k = 0; k < 4; k++) {
        *time = sequence.base + (aside[k] > 0 ? sequence.periods : 0) + aside[k];
        assert_int_equal(saltus_equations_evaluate(f.orbits.equations, at.at.u, &message),
                         SALTUS_NO_CONVERGENCE);
        assert_non_null(strstr(message.text, "order"));
    }
    *time = own;
    check_ok(saltus_equations_evaluate(f.orbits.equations, at.at.u, &message), &message);
    saltus_solution_clear(&at);
    saltus_orbits_close(&f.orbits);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solutions_are_the_closed_orbits),
        cmocka_unit_test(parameters_give_values_back),
        cmocka_unit_test(surveys_tell_the_multipliers),
        cmocka_unit_test(states_in_between),
        cmocka_unit_test(halves_and_images),
        cmocka_unit_test(reframed_orbits_are_the_same),
        cmocka_unit_test(zeros_are_the_closed_points),
        cmocka_unit_test(grazing_is_found_at_once),
        cmocka_unit_test(values_are_met),
        cmocka_unit_test(all_of_a_step_is_found),
        cmocka_unit_test(branches_leave_along_null_vectors),
        cmocka_unit_test(grazing_is_passed),
        cmocka_unit_test(changes_are_leapt_over),
        cmocka_unit_test(lack_of_memory_is_remembered),
        cmocka_unit_test(starts_are_kept),
        cmocka_unit_test(times_beyond_the_orbit),
    };
    gsl_set_error_handler_off();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
