/* Printed texts about motions: each line appears if it applies, with the motion's numbers in their places.
 * The motions are made up, with a different number in every field.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "text_lines.h"

enum { events_max = 40, multipliers_max = 6 };

typedef struct made {
    saltus_scene scene;
    saltus_system *system;
    saltus_motion motion;
    saltus_event events[events_max];
    saltus_multiplier multipliers[multipliers_max];
} made;

static saltus_multiplier multiplier(double re, double im) {
    return (saltus_multiplier){re, im, log(hypot(re, im))};
}

/* An orbit of two masses with a two-sided stop and one that is not: three faces. */
static void make(made *m) {
    *m = (made){.scene = {.name = "made", .title = "up"}};
    m->scene.spec = oscillator_spec(0.125, 2.5, 0, 1.75);
    set_parameter(&m->scene.spec, "N", 2);
    set_parameter(&m->scene.spec, "m", 3.25);
    add_stop(&m->scene.spec, 0.375, 0.625, SALTUS_BOTH);
    add_stop(&m->scene.spec, 0.875, 0.25, SALTUS_LOWER);
    m->scene.spec.stops[1].weight[0] = -0.5;
    m->scene.spec.stops[1].weight[1] = 1.5;
    m->system = build(&m->scene.spec);
    saltus_motion *motion = &m->motion;
    *motion = (saltus_motion){.verdict = SALTUS_PERIODIC,
                              .label = "11/3",
                              .reason = "because 17",
                              .periods = 3,
                              .impacts = 11,
                              .sticking_intervals = 5,
                              .impacts_by_face = {7, 2, 13},
                              .face_count = 3,
                              .dimension = 4,
                              .events = m->events,
                              .event_count = 4,
                              .multipliers = m->multipliers,
                              .multiplier_count = 4,
                              .stable = true,
                              .residual = 3.1e-13,
                              .iterations = 6,
                              .log_volume = -1.234567,
                              .sum_rule = -1.234511,
                              .mirror = SALTUS_MIRROR_PAIR,
                              .contact_force = {0.5, 1.25, 2.75},
                              .largest = 0.3125,
                              .smallest = -0.4375,
                              .rms = 0.28125,
                              .transient = 321,
                              .lyapunov = -0.0625,
                              .lyapunov_error = 0.005};
    m->multipliers[0] = multiplier(0.5, 0.25);
    m->multipliers[1] = multiplier(0.5, -0.25);
    m->multipliers[2] = multiplier(-0.375, 0);
    m->multipliers[3] = multiplier(0.125, 0);
    static const saltus_event_kind kinds[] = {SALTUS_IMPACT, SALTUS_STICK, SALTUS_RELEASE};
    for (int k = 0; k < events_max; k++)
        m->events[k] = (saltus_event){.kind = kinds[k % 3],
                                      .face = k % 3,
                                      .time = {k / 16, k / 16.0 - k / 16},
                                      .velocity_before = 0.5 + k,
                                      .velocity_after = -0.25 - k,
                                      .displacement = 0.375};
}

static void write(made *m, text_lines *lines) {
    lines_open(lines);
    saltus_write_motion_text(lines->stream, &m->scene, m->system, &m->motion);
    lines_read(lines);
}

static void check_scene(text_lines *lines) {
    lines_next(lines, "up", NULL, 0);
    lines_next(lines, "oscillator    N = 2, m = 3.25, c = 0.125, k = 2.5, m2 = 1, k2 = 1, omega = 1.75", NULL,
               0);
    lines_next(lines, "stop 1 ", "both sides", 4, 1., 0., 0.375, 0.625);
    lines_next(lines, "stop 2 ", "lower side", 4, -0.5, 1.5, 0.875, 0.25);
}

static void check_event(text_lines *lines, const made *m, int k) {
    const saltus_event *e = &m->events[k];
    static const char *const word[] = {"impact ", "stick ", "release "}, *const side[] = {"upper", "lower",
                                                                                          "lower"};
    double stop = e->face / 2 + 1, time = saltus_time_periods(e->time);
    if (e->kind == SALTUS_IMPACT)
        lines_next(lines, word[0], side[e->face], 5, stop, time, e->time.phase, e->velocity_before,
                   e->velocity_after);
    else
        lines_next(lines, word[k % 3], side[e->face], 3, stop, time, e->time.phase);
}

static void an_orbit_is_told(void **state) {
    (void)state;
    made m;
    text_lines lines;
    make(&m);
    const double modulus = hypot(0.5, 0.25);
    write(&m, &lines);
    lines_next(&lines, "made: 11/3, stable", NULL, 0);
    check_scene(&lines);
    lines_next(&lines, "motion", "impacts in", 3, 11., 3., 11. / 3);
    lines_next(&lines, "impacts", NULL, 6, 1., 7., 1., 2., 2., 13.);
    for (int k = 0; k < 4; k++)
        check_event(&lines, &m, k);
    lines_next(&lines, "multipliers", "+-", 5, 0.5, 0.25, modulus, -0.375, 0.125);
    lines_next(&lines, "sum rule", NULL, 3, -1.234567, -1.234511, -5.6e-5);
    lines_next(&lines, "exponent", "the largest", 1, -0.0625);
    lines_next(&lines, "mirror", "one of a mirror pair", 0);
    lines_next(&lines, "displacement", "root mean square", 3, -0.4375, 0.3125, 0.28125);
    lines_next(&lines, "settled", "periods simulated; residual", 3, 321., 3.1e-13, 6.);
    lines_end(&lines);
    saltus_system_free(m.system);
}

/* The singular is used for one, and what does not apply is omitted. */
static void variants_of_an_orbit_are_told(void **state) {
    (void)state;
    made m;
    text_lines lines;
    make(&m);
    saltus_motion *motion = &m.motion;
    motion->periods = 1;
    motion->impacts = 1;
    motion->event_count = 0;
    motion->mirror = SALTUS_MIRROR_SELF;
    motion->transient = 0;
    motion->iterations = 1;
    motion->stable = false;
    motion->log_volume = motion->lyapunov = NAN;
    m.scene.title[0] = '\0';
    m.multipliers[0] = multiplier(-1.5, 0.75);
    m.multipliers[1] = multiplier(1.25, -0.5); /* not its conjugate */
    m.multipliers[2] = multiplier(0.25, 0.125);
    write(&m, &lines);
    lines_next(&lines, "made: 11/3, unstable", NULL, 0);
    lines_next(&lines, "oscillator", NULL, -1);
    lines_next(&lines, "stop 1", NULL, -1);
    lines_next(&lines, "stop 2", NULL, -1);
    lines_next(&lines, "motion", "1 impact in 1 forcing period, 1 per response cycle", 3, 1., 1., 1.);
    lines_next(&lines, "impacts", NULL, -1);
    lines_next(&lines, "multipliers", "; 2 not inside the unit circle", 11, -1.5, 0.75, hypot(1.5, 0.75),
               1.25, 0.5, hypot(1.25, 0.5), 0.25, 0.125, hypot(0.25, 0.125), 0.125, 2.);
    lines_next(&lines, "sum rule", "not checked", 1, -1.234511);
    lines_next(&lines, "mirror", "its own mirror image", 0);
    lines_next(&lines, "displacement", NULL, -1);
    lines_next(&lines, "orbit", "Newton step (", 2, 3.1e-13, 1.);
    lines_end(&lines);

    motion->sum_rule = NAN;
    write(&m, &lines);
    while (strncmp(lines.at + strspn(lines.at, " "), "sum rule", 8) != 0)
        lines_next(&lines, "", NULL, -1);
    lines_next(&lines, "sum rule", "not checked: the trace is not known", 0);
    free(lines.text);

    /* Chatter: unlimited counts; some multipliers are zero. More than four multipliers are cut. */
    saltus_system_free(m.system);
    make(&m);
    motion->impacts = -1;
    strcpy(motion->label, "chatter/3");
    motion->sticks = true;
    motion->event_count = 0;
    motion->multiplier_count = 5;
    m.multipliers[4] = multiplier(0.0625, 0);
    motion->mirror = SALTUS_MIRROR_NONE;
    motion->transient = 1;
    write(&m, &lines);
    lines_next(&lines, "made: chatter/3, stable", NULL, 0);
    check_scene(&lines);
    lines_next(&lines, "motion", "5 sticking intervals in 3 forcing periods", 2, 5., 3.);
    lines_next(&lines, "impacts", "(before the chatter completes)", 6, 1., 7., 1., 2., 2., 13.);
    lines_next(&lines, "multipliers", ", ...", 5, 0.5, 0.25, hypot(0.5, 0.25), -0.375, 0.125);
    lines_next(&lines, "sum rule", "does not apply", 0);
    lines_next(&lines, "exponent", NULL, 1, -0.0625);
    lines_next(&lines, "mirror", "no mirror symmetry", 0);
    lines_next(&lines, "displacement", NULL, -1);
    lines_next(&lines, "settled", "1 period simulated; residual", 3, 1., 3.1e-13, 6.);
    lines_end(&lines);

    /* The multipliers are unknown; then the verdict does not mention stability. */
    saltus_system_free(m.system);
    make(&m);
    motion->multiplier_count = motion->event_count = 0;
    write(&m, &lines);
    lines_next(&lines, "made: 11/3", NULL, 0);
    assert_null(strstr(lines.text, "stable"));
    check_scene(&lines);
    lines_next(&lines, "motion", NULL, -1);
    lines_next(&lines, "impacts", NULL, -1);
    lines_next(&lines, "exponent", NULL, -1);
    lines_next(&lines, "mirror", NULL, 0);
    lines_next(&lines, "displacement", NULL, -1);
    lines_next(&lines, "settled", NULL, -1);
    lines_end(&lines);
    saltus_system_free(m.system);
}

static void rests_are_told(void **state) {
    (void)state;
    made m;
    text_lines lines;
    for (int held = 0; held < 2; held++) {
        make(&m);
        m.motion.verdict = held ? SALTUS_HELD : SALTUS_EQUILIBRIUM;
        strcpy(m.motion.label, held ? "held" : "equilibrium");
        m.motion.event_count = m.motion.multiplier_count = 0;
        write(&m, &lines);
        lines_next(&lines, held ? "made: held" : "made: equilibrium", NULL, 0);
        check_scene(&lines);
        lines_next(&lines, "motion", held ? "in contact for good" : "at rest", 0);
        if (held)
            lines_next(&lines, "contact force", "stop 2 lower", 6, 1., 0.5, 1., 1.25, 2., 2.75);
        lines_next(&lines, "exponent", NULL, -1);
        lines_next(&lines, "mirror", NULL, 0);
        lines_next(&lines, "displacement", NULL, -1);
        lines_next(&lines, "settled", "periods simulated (", 1, 321.);
        lines_end(&lines);
        saltus_system_free(m.system);
    }
}

static void evidence_is_told(void **state) {
    (void)state;
    made m;
    text_lines lines;
    for (int lacking = 0; lacking < 4; lacking++) {
        make(&m);
        saltus_motion *motion = &m.motion;
        motion->verdict = SALTUS_CHAOTIC;
        strcpy(motion->label, "chaotic");
        motion->event_count = motion->multiplier_count = 0;
        motion->lyapunov = lacking == 3 ? -INFINITY : 0.0625;
        motion->evidence = (saltus_evidence){.periods = lacking == 2 ? 0 : 900,
                                             .half = {0.05, 0.07},
                                             .half_errors = {0.006, 0.008},
                                             .zero_one = lacking == 3 ? NAN : 0.875,
                                             .zero_one_quartiles = {0.75, 0.9375},
                                             .dimension = lacking == 1 ? NAN : 1.25,
                                             .dimension_error = 0.5,
                                             .broadband = 0.25,
                                             .impacts_per_period = 1.125};
        write(&m, &lines);
        lines_next(&lines, "made: chaotic", NULL, 0);
        check_scene(&lines);
        lines_next(&lines, "motion", "because 17", 1, 17.);
        if (lacking == 3)
            lines_next(&lines, "exponent", "-infinity", 0);
        else if (lacking < 2)
            lines_next(&lines, "exponent", NULL, 6, 0.0625, 0.005, 0.05, 0.006, 0.07, 0.008);
        if (lacking == 0)
            lines_next(&lines, "opinions", "0-1 test", 8, 0., 1., 0.875, 0.75, 0.9375, 0.25, 1.25, 0.5);
        if (lacking == 1)
            lines_next(&lines, "opinions", "0-1 test", 6, 0., 1., 0.875, 0.75, 0.9375, 0.25);
        if (lacking != 2)
            lines_next(&lines, "impacts", "per T = ", 2, 1.125, saltus_system_period(m.system));
        lines_next(&lines, "mirror", NULL, 0);
        lines_next(&lines, "displacement", NULL, -1);
        lines_next(&lines, "settled", "periods simulated (", 1, 321.);
        lines_end(&lines);
        saltus_system_free(m.system);
    }
}

/* At most twelve lines of events; four or more impacts in a row on one face take three lines. */
static void many_events_are_cut(void **state) {
    (void)state;
    made m;
    text_lines lines;
    for (int count = 11; count < 16; count++) {
        make(&m);
        m.motion.event_count = count;
        write(&m, &lines);
        for (int k = 0; k < 7; k++)
            lines_next(&lines, "", NULL, -1);
        for (int k = 0; k < count && k < 12; k++)
            check_event(&lines, &m, k);
        if (count > 12)
            lines_next(&lines, "... and", count == 13 ? "more event" : "more events", 1, count - 12.);
        assert_true(count != 13 || !strstr(lines.text, "more events"));
        lines_next(&lines, "multipliers", NULL, -1);
        free(lines.text);
        saltus_system_free(m.system);
    }
    for (int run = 2; run < 8; run++)
        for (int brief = 0; brief < 2; brief++) {
            make(&m);
            int count = brief ? 13 : 10;
            m.motion.event_count = count;
            for (int k = 3; k < 3 + run; k++) {
                m.events[k].kind = SALTUS_IMPACT;
                m.events[k].face = 1;
            }
            if (run == 5) /* the last of them is on another face */
                m.events[7].face = 0;
            if (run == 7) /* a release is not an impact */
                m.events[8].kind = SALTUS_RELEASE;
            int length = run == 5 ? 4 : run == 7 ? 5 : run, used = 0;
            write(&m, &lines);
            for (int k = 0; k < 7; k++)
                lines_next(&lines, "", NULL, -1);
            for (int k = 0; k < count && used < 12; k++, used++) {
                if (brief && length > 3 && k == 5) {
                    const saltus_event *first = &m.events[5], *last = &m.events[2 + length];
                    lines_next(&lines, "...", "more impacts until", 4, length - 2.,
                               saltus_time_periods(last->time), first->velocity_before,
                               last->velocity_before);
                    k = 2 + length;
                    continue;
                }
                const saltus_event *e = &m.events[k];
                lines_next(&lines,
                           e->kind == SALTUS_IMPACT  ? "impact"
                           : e->kind == SALTUS_STICK ? "stick"
                                                     : "release",
                           NULL, -1);
                assert_true(!strstr(lines.text, "    ... and") || count - 3 - (length > 3) > 0);
            }
            free(lines.text);
            saltus_system_free(m.system);
        }
}

static void attractors_are_told(void **state) {
    static const saltus_verdict kinds[] = {SALTUS_PERIODIC, SALTUS_PERIODIC, SALTUS_CHAOTIC, SALTUS_UNDECIDED,
                                           SALTUS_HELD};
    static const int shares[] = {12, 11, 9, 5, 3};
    (void)state;
    made m;
    make(&m);
    saltus_motion motions[5];
    int share[5];
    memcpy(share, shares, sizeof share);
    for (int k = 0; k < 5; k++) {
        motions[k] = m.motion;
        motions[k].verdict = kinds[k];
        motions[k].smallest -= k;
        motions[k].largest += k;
        motions[k].mirror = k == 1 ? SALTUS_MIRROR_SELF : k == 4 ? SALTUS_MIRROR_NONE : SALTUS_MIRROR_PAIR;
        motions[k].multiplier_count = k < 2 ? 4 : 0;
        motions[k].lyapunov = k == 3 ? NAN : 0.0625;
    }
    saltus_attractors a = {motions, share, 5, 40, 40};
    text_lines lines;
    lines_open(&lines);
    saltus_write_attractors(lines.stream, &m.scene, m.system, &a, false);
    lines_read(&lines);
    lines_next(&lines, "made:", "5 attractors from 40 random", 2, 5., 40.);
    const double modulus = hypot(0.5, 0.25);
    lines_next(&lines, "12 ", "one of a mirror pair", 6, 30., 11., 3., modulus, -0.4375, 0.3125);
    lines_next(&lines, "11 ", "its own mirror image", 6, 27.5, 11., 3., modulus, -1.4375, 1.3125);
    lines_next(&lines, "9 ", "largest exponent", 5, 22.5, 11., 3., 0.0625, 0.005);
    lines_next(&lines, "5 ", NULL, 3, 12.5, 11., 3.);
    lines_next(&lines, "3 ", "displacement", 5, 7.5, 11., 3., -4.4375, 4.3125);
    lines_end(&lines);
    a.count = 1;
    lines_open(&lines);
    saltus_write_attractors(lines.stream, &m.scene, m.system, &a, false);
    lines_read(&lines);
    lines_next(&lines, "made: 1 attractor from", NULL, 1, 40.);
    lines_next(&lines, "12 ", NULL, -1);
    lines_end(&lines);
    saltus_system_free(m.system);
}

static void harvests_are_told(void **state) {
    (void)state;
    made m;
    make(&m);
    saltus_harvest_orbit orbits[5] = {{.impacts = 0}};
    static const int mirror[] = {-1, 2, 1, 3, 0};
    for (int k = 0; k < 5; k++) {
        orbits[k].orbit = (saltus_orbit){.dimension = 4,
                                         .periods = k + 2,
                                         .multipliers = m.multipliers,
                                         .multiplier_count = 4,
                                         .residual = 2.5e-13 * (k + 1)};
        orbits[k].impacts = k == 4 ? -1 : 20 + k;
        orbits[k].mirror = mirror[k];
    }
    m.multipliers[0] = multiplier(-3.5, 0);
    m.multipliers[1] = multiplier(1, 0);
    saltus_harvest h = {
        .orbits = orbits, .count = 5, .dimension = 4, .periods = 700, .candidates = 80, .converged = 60};
    text_lines lines;
    for (int one = 0; one < 3; one++) {
        h.count = one == 0 ? 5 : 2 - one;
        lines_open(&lines);
        saltus_write_harvest_text(lines.stream, &m.scene, m.system, &h);
        lines_read(&lines);
        lines_next(&lines, "made:", h.count == 1 ? "orbit from" : "orbits from", 3, (double)h.count, 80.,
                   700.);
        check_scene(&lines);
        if (h.count) {
            lines_next(&lines, "n/p", NULL, 0);
            lines_next(&lines, "|mu|", NULL, 0);
        }
        for (int k = 0; k < h.count; k++) {
            static const char *const words[] = {NULL, "  mirror image of 3", "  mirror image of 2",
                                                "  its own mirror image", "  mirror image of 1"};
            char head[16];
            snprintf(head, sizeof head, "%d ", k + 1);
            double residual = 2.5e-13 * (k + 1);
            if (k == 4)
                lines_next(&lines, "5  chatter/6 ", words[k], 4, 3.5, 2., residual, 1.);
            else if (mirror[k] >= 0 && mirror[k] != k)
                lines_next(&lines, head, words[k], 6, 20. + k, k + 2., 3.5, 2., residual, mirror[k] + 1.);
            else
                lines_next(&lines, head, words[k], 5, 20. + k, k + 2., 3.5, 2., residual);
            assert_true(k != 0 || lines.at[-2] != 'e');
        }
        lines_end(&lines);
    }
    saltus_system_free(m.system);
}

/* The pipe's response cycle is two forcing periods long. */
static void a_pipe_responds_in_two_periods(void **state) {
    (void)state;
    made m;
    text_lines lines;
    make(&m);
    saltus_system_free(m.system);
    m.scene.spec = pipe_spec(2, 42);
    set_parameter(&m.scene.spec, "sigma", 0);
    add_stop(&m.scene.spec, 0.035, 0.875, SALTUS_UPPER);
    m.scene.spec.stops[0].xi = 0.625;
    m.system = build(&m.scene.spec);
    m.motion.event_count = 0;
    write(&m, &lines);
    lines_next(&lines, "made:", NULL, -1);
    lines_next(&lines, "up", NULL, 0);
    lines_next(
        &lines,
        "pipe          N = 2, alpha = 0.005, beta = 0.64, kappa = 5000, u0 = 4.5, sigma = 0, omega = 42",
        NULL, 0);
    lines_next(&lines, "stop 1", "upper side", 3, 0.625, 0.035, 0.875);
    lines_next(&lines, "motion", "(2 T)", 4, 11., 3., 22. / 3, 2.);
    free(lines.text);
    saltus_system_free(m.system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_orbit_is_told),    cmocka_unit_test(variants_of_an_orbit_are_told),
        cmocka_unit_test(rests_are_told),      cmocka_unit_test(evidence_is_told),
        cmocka_unit_test(many_events_are_cut), cmocka_unit_test(attractors_are_told),
        cmocka_unit_test(harvests_are_told),   cmocka_unit_test(a_pipe_responds_in_two_periods),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
