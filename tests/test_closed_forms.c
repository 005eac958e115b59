/* Linear oscillators whose motion between impacts is known in closed form (data: literature on impact
 * oscillators, each case named at its test).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

/* x'' + c x' + k x = F cos(omega t): steady part plus decaying part. */
static void closed_form(double c, double k, double force, double omega, const double *x0, double t,
                        double *x) {
    double denominator = (k - omega * omega) * (k - omega * omega) + c * c * omega * omega;
    double a = force * (k - omega * omega) / denominator, b = force * c * omega / denominator;
    double decay = c / 2, frequency = sqrt(k - decay * decay);
    double y0 = x0[0] - a, v0 = x0[1] - b * omega;
    double p = y0, q = (v0 + decay * y0) / frequency, e = exp(-decay * t);
    double cosine = cos(frequency * t), sine = sin(frequency * t);
    x[0] = e * (p * cosine + q * sine) + a * cos(omega * t) + b * sin(omega * t);
    x[1] = e * (-decay * (p * cosine + q * sine) + frequency * (q * cosine - p * sine)) -
           a * omega * sin(omega * t) + b * omega * cos(omega * t);
}

static void free_flight(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.2, 3.0, 0.7, 1.3);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double start[2] = {0.4, -1.1}, state[2], exact[2], period = saltus_system_period(system);
    saltus_flow *flow = open_flow(system, &options, 0, start);
    for (int k = 1; k <= 40; k++) {
        double periods = 0.37 * k;
        advance(flow, periods, 0);
        saltus_flow_state(flow, 0, state);
        closed_form(0.2, 3.0, 0.7, 1.3, start, periods * period, exact);
        check_near(state[0], exact[0], 1e-13);
        check_near(state[1], exact[1], 1e-13);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Two masses without damping and load keep their energy; the Maxwell element adds a first-order state whose
 * linear system is checked against the matrix exponential's defining equation by halving. */
static void two_masses_keep_energy(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 2.0, 0, 1.0);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "m2", 0.5);
    set_parameter(&spec, "k2", 3.0);
    saltus_stop stop = saltus_stop_defaults();
    stop.weight[1] = -1;
    stop.d = 0.2;
    stop.r = 1;
    stop.sides = SALTUS_BOTH;
    spec.stops[spec.stop_count++] = stop;
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double x[4] = {0.1, 0.0, 0.3, -1.0};
    double energy =
        0.5 * (x[2] * x[2] + 0.5 * x[3] * x[3]) + x[0] * x[0] + 1.5 * (x[0] - x[1]) * (x[0] - x[1]);
    double momentum_energy = energy;
    saltus_flow *flow = open_flow(system, &options, 0, x);
    advance(flow, 200, 0);
    saltus_flow_state(flow, 0, x);
    energy = 0.5 * (x[2] * x[2] + 0.5 * x[3] * x[3]) + x[0] * x[0] + 1.5 * (x[0] - x[1]) * (x[0] - x[1]);
    assert_true(saltus_flow_information(flow, 0).impacts > 100);
    check_near(energy, momentum_energy, 1e-11);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A Maxwell element alone on a mass: x''' + x''/t + k x' = 0 has a closed form (one zero eigenvalue). */
static void maxwell_element(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 0, 0, 1.0);
    set_parameter(&spec, "kz", 4.0);
    set_parameter(&spec, "tz", 0.5);
    saltus_system *system = build(&spec);
    assert_int_equal(saltus_system_dimension(system), 3);
    saltus_flow_options options = saltus_flow_defaults();
    double start[3] = {0.0, 1.0, 0.0}, state[3], t = 0.3 * saltus_system_period(system);
    saltus_flow *flow = open_flow(system, &options, 0, start);
    advance(flow, 0.3, 0);
    saltus_flow_state(flow, 0, state);
    /* v' = -z, z' = 4 v - 2 z: eigenvalues -1 +/- i sqrt(3). */
    double w = sqrt(3.0), e = exp(-t);
    check_near(state[1], e * (cos(w * t) + sin(w * t) / w), 1e-13);
    check_near(state[2], e * 4 * sin(w * t) / w, 1e-13);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Period-one impact orbits of x'' + 0.1 x' + x = A cos t, x < 1, restitution 0.8 (COCO's hybrid demo). */
static void period_one_orbits(void **unused) {
    (void)unused;
    static const double rows[4][5] = {{1, 0.0759521649, 1.6957329376, -0.58429531, 0.00560035},
                                      {0.5, 0.1771123597, 0.8370160232, -0.58116589, 0.06065134},
                                      {0.2, 0.4992440673, 0.2986128521, -0.57002369, 0.12847322},
                                      {0.1001, 1.4957882153, 0.0127569343, -0.18187521, 0.55529613}};
    for (int k = 0; k < 4; k++) {
        saltus_spec spec = oscillator_spec(0.1, 1, rows[k][0], 1);
        add_stop(&spec, 1, 0.8, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        saltus_classify_options options = saltus_classify_defaults();
        saltus_message message = {.text = ""};
        saltus_motion motion;
        double start[2] = {0, 0};
        check_ok(saltus_classify(system, start, &options, &motion, &message), &message);
        assert_string_equal(motion.label, "1/1");
        check_near(2 * M_PI * motion.events[0].time.phase, rows[k][1], 1e-10);
        check_near(motion.events[0].velocity_before, rows[k][2], 1e-10);
        check_near(motion.multipliers[0].re, rows[k][3], 1e-8);
        check_near(fabs(motion.multipliers[0].im), rows[k][4], 1e-8);
        check_near(exp(motion.multipliers[0].log_modulus), 0.8 * exp(-0.1 * M_PI), 1e-10);
        check_near(motion.log_volume, motion.sum_rule, 1e-11);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* Near grazing: x'' + 0.04 x' + x = F cos(omega t) - 1, x < 0, r = 0.9, one impact in two periods; published
 * folds and flips of the impact map. Rows: omega, speed, F, impact time mod T, critical and other
 * multiplier. */
static void near_grazing_orbits(void **unused) {
    (void)unused;
    static const double rows[4][6] = {
        {0.81, 0.0653039433369, 0.3475333974123, 0.096602133165, -1, -0.435490392782},
        {0.799, 0.1240873448523, 0.3628362019809, 0.071753858269, 1, 0.431785672133},
        {0.80089, 0.0066749810816, 0.3600268471098, 0.109200274868, -1, -0.432427180987},
        {0.799741, 0.0146915666928, 0.3618288199778, 0.106143380780, 1, 0.432037432133}};
    for (int k = 0; k < 4; k++) {
        saltus_spec spec = oscillator_spec(0.04, 1, rows[k][2], rows[k][0]);
        set_parameter(&spec, "F0", -1);
        add_stop(&spec, 0, 0.9, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_section section = saltus_section_defaults();
        saltus_message message = {.text = ""};
        saltus_map *map;
        section.kind = SALTUS_SECTION_IMPACT;
        check_ok(saltus_map_new(system, &section, &options, true, &map, &message), &message);
        assert_int_equal(saltus_map_dimension(map), 3);
        double point[3] = {0, -0.9 * rows[k][1], rows[k][3]}, image[3], d[9];
        check_ok(saltus_map_reset(map, point, &message), &message);
        check_ok(saltus_map_step(map, image, NULL, &message), &message);
        check_near(image[1], point[1], 1e-9);
        check_near(image[2], point[2], 1e-9);
        saltus_map_derivative(map, d);
        /* On the section (x fixed) the map is two-dimensional: speed and time. */
        double trace = d[4] + d[8], determinant = d[4] * d[8] - d[5] * d[7];
        check_near(trace, rows[k][4] + rows[k][5], 1e-5);
        check_near(determinant, rows[k][4] * rows[k][5], 1e-5);
        saltus_map_free(map);
        saltus_system_free(system);
    }
}

/* x'' + x = cos(2.8 t), x < 0, r = 0.8 (Budd & Dux), from an impact at t = 0.5 with speed 0.5 before it. */
static void impact_sequence(void **unused) {
    (void)unused;
    static const double rows[5][2] = {{3.503043263961484, 0.639009271086486},
                                      {6.667885527840286, 0.281622310216315},
                                      {7.150593667690408, 0.175649495838635},
                                      {10.117290676709667, 0.477868786744267},
                                      {12.561241179822434, 0.133967799633770}};
    saltus_spec spec = oscillator_spec(0, 1, 1, 2.8);
    add_stop(&spec, 0, 0.8, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double start[2] = {0, -0.4}, period = saltus_system_period(system);
    saltus_flow *flow = open_flow(system, &options, 0.5 / period, start);
    for (int k = 0; k < 5; k++) {
        saltus_event event = advance(flow, 100, SALTUS_WATCH_IMPACT);
        check_near(saltus_time_periods(event.time) * period, rows[k][0], 1e-13);
        check_near(event.velocity_before, rows[k][1], 1e-13);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* The same oscillator at omega = 4.85 with the stop at 0.01 is chaotic and sometimes falls into complete
 * chatter: it must neither stall there nor stay. */
static void complete_chatter_goes_on(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 1, 4.85);
    add_stop(&spec, 0.01, 0.8, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double start[2] = {0, 0};
    saltus_flow *flow = open_flow(system, &options, 0, start);
    saltus_flow_info info = {0};
    /* A stick comes by chance, about once in 30,000 periods. */
    for (int k = 1; k <= 50 && info.sticks == 0; k++) {
        advance(flow, 20000 * k, 0);
        info = saltus_flow_information(flow, 0);
    }
    assert_true(info.sticks >= 1);
    assert_true(info.sticks == info.releases);
    assert_true(info.impacts > 10000);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A ball dropped from h = 1 comes to rest at sqrt(2 h / g) (1 + 2 e / (1 - e)). */
static void bouncing_ball(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 0, 0, 1);
    set_parameter(&spec, "F0", -9.8);
    add_stop(&spec, 0, 0.5, SALTUS_LOWER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double start[2] = {1, 0}, state[2], fall = sqrt(2 / 9.8), speed = 9.8 * fall, time = fall;
    saltus_flow *flow = open_flow(system, &options, 0, start);
    saltus_event event = advance(flow, 2, SALTUS_WATCH_CONTACT);
    for (int k = 0; event.kind == SALTUS_IMPACT; k++) {
        check_near(saltus_time_periods(event.time) * 2 * M_PI, time, 1e-14);
        check_near(event.velocity_before, -speed, 1e-13);
        speed *= 0.5;
        time += 2 * speed / 9.8;
        event = advance(flow, 2, SALTUS_WATCH_CONTACT);
    }
    assert_int_equal(event.kind, SALTUS_STICK);
    check_near(saltus_time_periods(event.time) * 2 * M_PI, 1.3552618543578767, 1e-14);
    advance(flow, 5, 0);
    saltus_flow_state(flow, 0, state);
    check_near(state[0], 0, 0);
    check_near(state[1], 0, 0);
    assert_int_equal(saltus_flow_contacts(flow, 0), 1);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

static saltus_spec table_spec(double gamma) {
    saltus_spec spec = oscillator_spec(0, 0, gamma, 1);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, 0, 0.5, SALTUS_LOWER);
    return spec;
}

/* Ball on a vibrating table, restitution 1/2: the k-period orbit with one impact flips at a known
 * acceleration. At its impact the relative speed is that of a flight of k T, at the phase where the table
 * returns the lost energy. */
static void vibrating_table(void **unused) {
    (void)unused;
    static const double flip[3] = {0, 1.526823700519, 2.370877210267};
    for (int k = 1; k <= 2; k++) {
        /* y'' = -1 + G cos t: a flight of 2 pi k from phase p with relative speed u ends on the table when
         * u = k pi + G sin p, and with speed u / e before the impact when u = 2 pi k e / (1 + e). */
        double gamma = flip[k], angle = asin(k * M_PI / 3 / gamma);
        saltus_spec spec = table_spec(gamma);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_section section = saltus_section_defaults();
        saltus_message message = {.text = ""};
        saltus_map *map;
        section.kind = SALTUS_SECTION_IMPACT;
        check_ok(saltus_map_new(system, &section, &options, true, &map, &message), &message);
        double best = INFINITY, d[9];
        for (int side = 0; side < 2; side++) {
            double p = side ? M_PI + angle : 2 * M_PI - angle, image[3];
            double point[3] = {0, k * M_PI + gamma * sin(p), p};
            check_ok(saltus_map_reset(map, point, &message), &message);
            check_ok(saltus_map_step(map, image, NULL, &message), &message);
            double error = fabs(image[1] - point[1]) + fabs(image[2] - point[2]);
            if (error < best) {
                best = error;
                saltus_map_derivative(map, d);
            }
            if (best < 1e-9)
                break;
        }
        check_near(best, 0, 1e-9);
        double trace = d[4] + d[8], determinant = d[4] * d[8] - d[5] * d[7];
        check_near(1 + trace + determinant, 0, 1e-9); /* a multiplier -1 */
        check_near(determinant, 0.25, 1e-10);         /* e^2 */
        saltus_map_free(map);
        saltus_system_free(system);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(free_flight),
        cmocka_unit_test(two_masses_keep_energy),
        cmocka_unit_test(maxwell_element),
        cmocka_unit_test(period_one_orbits),
        cmocka_unit_test(near_grazing_orbits),
        cmocka_unit_test(impact_sequence),
        cmocka_unit_test(complete_chatter_goes_on),
        cmocka_unit_test(bouncing_ball),
        cmocka_unit_test(vibrating_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
