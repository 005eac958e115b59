/* Orbits with an impact in the very section, on whose sides the flow ends by rounding: label, multipliers and
 * mirror image against closed forms.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

static const char resonant[] = "model: oscillator\n"
                               "c: 0\nomega: 1\nF: 0.5\n"
                               "stop: {d: 1, r: 0.8}\n";

/* A ball on a vibrating table, seen from the table. */
static const char table[] = "model:\n"
                            "  parameters: {A: 0.2, phi: 0, omega: 2*pi}\n"
                            "  motion: {z: -9.81 + A*omega^2*cos(omega*t + phi)}\n"
                            "  forcing: omega\n"
                            "stop: {coordinate: z, d: 0, r: 0.5, sides: lower}\n";

/* A free mass between two walls. */
static const char pair[] = "model:\n"
                           "  parameters: {phi: 0, omega: 1}\n"
                           "  motion: {x: cos(omega*t + phi)}\n"
                           "  forcing: omega\n"
                           "stop: {coordinate: x, d: 0.5, r: 0.5, sides: both}\n";

static saltus_motion classified(const char *text, const char *assignments[], double displacement,
                                double velocity) {
    const saltus_classify_options options = saltus_classify_defaults();
    saltus_scene scene;
    saltus_system *system;
    saltus_motion motion;
    saltus_message message = {.text = ""};
    const double start[] = {displacement, velocity};
    check_ok(saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message), &message);
    for (; *assignments; assignments++)
        check_ok(saltus_scene_set(&scene, *assignments, &message), &message);
    check_ok(saltus_system_new(&scene.spec, &system, &message), &message);
    check_ok(saltus_classify(system, start, &options, &motion, &message), &message);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
    return motion;
}

/* In resonance without damping x = cos t + B sin t + (F/2) t sin t between impacts at the section's time: the
 * speeds before them are pi F/(1 + r), and an impact too late by s makes the next one early by r s: both
 * multipliers are -r. */
static void an_impact_in_the_section_is_met_once(void **unused) {
    (void)unused;
    static const double restitutions[] = {0.05, 0.12, 0.35, 0.605, 0.7, 0.75, 0.8, 0.865, 0.9, 0.95};
    for (size_t k = 0; k < sizeof restitutions / sizeof restitutions[0]; k++) {
        const double r = restitutions[k], speed = M_PI * 0.5 / (1 + r);
        char set[32];
        snprintf(set, sizeof set, "r=%.17g", r);
        saltus_motion m = classified(resonant, (const char *[]){set, NULL}, 0.9, 0);
        if (strcmp(m.label, "1/1") != 0)
            fail_msg("r = %g: %s", r, m.label);
        assert_true(m.stable);
        assert_int_equal(m.event_count, 1);
        check_near(m.events[0].velocity_before, speed, 1e-10);
        check_near(remainder(saltus_time_periods(m.events[0].time), 1), 0, 1e-10);
        check_near(m.state[0], 1, 1e-10);
        check_near(m.state[1], -r * speed, 1e-10); /* the section point lies after the impact */
        check_near(m.multipliers[0].log_modulus, log(r), 1e-6);
        check_near(m.multipliers[1].log_modulus, log(r), 1e-6);
        check_near(m.sum_rule, 2 * log(r), 1e-10);
        saltus_motion_clear(&m);
    }
}

/* The ball leaves the table with g T/2 and meets it again after T, which moves at that speed times
 * (1 - r)/(1 + r). */
static void a_ball_lands_in_the_section(void **unused) {
    (void)unused;
    static const double restitutions[] = {0.27, 0.36, 0.5, 0.7, 0.83};
    for (size_t k = 0; k < sizeof restitutions / sizeof restitutions[0]; k++) {
        const double r = restitutions[k], leaving = 9.81 / 2, own = leaving * (1 - r) / (1 + r),
                     A = 1.02 * own / (2 * M_PI);
        char amplitude[40], phi[40], set[32];
        snprintf(set, sizeof set, "r=%.17g", r);
        snprintf(amplitude, sizeof amplitude, "A=%.17g", A);
        snprintf(phi, sizeof phi, "phi=%.17g", asin(-1 / 1.02));
        saltus_motion m =
            classified(table, (const char *[]){set, amplitude, phi, NULL}, 0, 1.0001 * (leaving - own));
        if (strcmp(m.label, "1/1") != 0)
            fail_msg("r = %g: %s", r, m.label);
        assert_true(m.stable);
        assert_int_equal(m.event_count, 1);
        check_near(m.events[0].velocity_before, -leaving - own, 1e-9);
        check_near(m.state[1], leaving - own, 1e-9);
        check_near(m.log_volume, 2 * log(r), 1e-9);
        saltus_motion_clear(&m);
    }
}

/* Impacts on the two walls half a period apart: v = 2 sin(phi)/(1 - r) before them, and the phase follows
 * from the distance 2 d. Such an orbit is its own mirror image. */
static void a_symmetric_orbit_hits_in_the_section(void **unused) {
    (void)unused;
    static const double cases[][2] = {{1.844, 0.358}, {2.569, 0.85}, {2.089, 0.698}, {1.861, 0.936}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const double d = cases[k][0], r = cases[k][1], a = 2, b = -M_PI * (1 + r) / (1 - r),
                     phi = atan2(b, a) + acos(-2 * d / hypot(a, b)), speed = 2 * sin(phi) / (1 - r);
        char clearance[40], set[32], phase[40];
        snprintf(set, sizeof set, "r=%.17g", r);
        snprintf(clearance, sizeof clearance, "d=%.17g", d);
        snprintf(phase, sizeof phase, "phi=%.17g", phi);
        saltus_motion m =
            classified(pair, (const char *[]){set, clearance, phase, NULL}, d, -1.00001 * r * speed);
        if (strcmp(m.label, "2/1") != 0)
            fail_msg("d = %g, r = %g: %s", d, r, m.label);
        assert_int_equal(m.event_count, 2);
        assert_int_equal(m.impacts_by_face[0], 1);
        assert_int_equal(m.mirror, SALTUS_MIRROR_SELF);
        check_near(fabs(m.events[0].velocity_before), speed, 1e-9);
        check_near(m.state[1], -r * speed, 1e-9);
        check_near(m.log_volume, 4 * log(r), 1e-9);
        saltus_motion_clear(&m);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_impact_in_the_section_is_met_once),
        cmocka_unit_test(a_ball_lands_in_the_section),
        cmocka_unit_test(a_symmetric_orbit_hits_in_the_section),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
