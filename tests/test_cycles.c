/* Orbits of unforced scenes, whose period is unknown: against published and independent numbers, closed
 * asymptotics, and properties of every such orbit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "json.h"

#include "command.h"

#include "saltus/scene.h"

/* A built-in scene with settings; the caller clears it. */
static saltus_scene scene_with(const char *name, const char *const *settings, int count) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load(name, &scene, &message), &message);
    for (int k = 0; k < count; k++)
        check_ok(saltus_scene_set(&scene, settings[k], &message), &message);
    return scene;
}

static saltus_motion classified(const saltus_scene *scene) {
    saltus_message message = {.text = ""};
    saltus_classify_options options = saltus_classify_defaults();
    saltus_system *system = NULL;
    saltus_motion motion;
    double state[SALTUS_STATE_MAX];
    check_ok(saltus_system_new(&scene->spec, &system, &message), &message);
    check_ok(saltus_scene_state(scene, system, state, &message), &message);
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    saltus_system_free(system);
    return motion;
}

static saltus_motion motion_of(const char *name, const char *setting) {
    saltus_scene scene = scene_with(name, &setting, setting ? 1 : 0);
    saltus_motion motion = classified(&scene);
    saltus_scene_clear(&scene);
    return motion;
}

/* Properties of every orbit with its own period. */
static void check_cycle(const saltus_motion *m) {
    assert_int_equal(m->verdict, SALTUS_PERIODIC);
    assert_int_equal(m->multiplier_count, m->dimension - 1);
    check_near(m->trivial_multiplier, 1, 1e-9);
    assert_true(m->period > 0 && m->periods >= 1);
    if (!isnan(m->log_volume))
        check_near(m->log_volume, m->sum_rule, 1e-7 * fmax(1, fabs(m->sum_rule)));
    check_near(m->lyapunov, m->multipliers[0].log_modulus / m->period, 1e-12);
}

/* Flow rate, period and impact speed of the valve's one-impact orbits from independent programs; below the
 * first flip they return after one maximum. */
static void the_valve_agrees_with_independent_programs(void **unused) {
    (void)unused;
    static const struct {
        const char *setting;
        int returns;
        double period, speed;
    } known[] = {{"q=6.8", 2, 4.9985607773, 2.2943885887},
                 {"q=5.8", 1, 2.3094547137, 2.3455759709},
                 {"q=5.05", 1, 2.1645752428, 2.8623205880},
                 {"q=3.05", 1, 1.7290763308, 3.3598248190}};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        saltus_motion m = motion_of("relief-valve", known[k].setting);
        check_cycle(&m);
        assert_true(m.stable && m.impacts == 1);
        assert_int_equal(m.periods, known[k].returns);
        check_near(m.period, known[k].period, 1.5e-10);
        assert_int_equal(m.event_count, 1);
        check_near(-m.events[0].velocity_before, known[k].speed, 1.5e-10);
        /* The state is the highest maximum: the lift is at rest, and the impact comes later. */
        check_near(m.state[1], 0, 1e-9);
        check_near(m.state[0], m.largest, 1e-9);
        double time = saltus_time_periods(m.events[0].time);
        assert_true(time > 0 && time < 1);
        saltus_motion_clear(&m);
    }
}

static void the_valve_has_no_period_where_it_is_chaotic(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_motion m = motion_of("relief-valve", "q=7.05");
    assert_int_equal(m.verdict, SALTUS_CHAOTIC);
    assert_true(isnan(m.period) && m.trivial_multiplier == 0 && m.lyapunov > 0.05);
    saltus_motion_clear(&m);
}

/* Period and multiplier to the order of mu^4: T = 2 pi (1 + mu^2/16 - 5 mu^4/3072), amplitude 2; by the sum
 * rule the multiplier is exp of the integral of mu (1 - x^2), -mu T to the first order. For large mu the
 * period's terms of Dorodnitsyn: mu (3 - 2 ln 2) + 7.0143 mu^(-1/3). */
static void van_der_pol_follows_its_asymptotics(void **unused) {
    (void)unused;
    static const double small[] = {0.02, 0.05, 0.1};
    for (int k = 0; k < 3; k++) {
        char setting[32];
        double mu = small[k];
        snprintf(setting, sizeof setting, "mu=%g", mu);
        saltus_motion m = motion_of("van-der-pol", setting);
        check_cycle(&m);
        check_near(m.period, 2 * M_PI * (1 + mu * mu / 16 - 5 * pow(mu, 4) / 3072), 10 * pow(mu, 6));
        check_near(m.largest, 2, mu * mu / 50);
        check_near(m.multipliers[0].log_modulus, -2 * M_PI * mu, 2 * mu * mu * mu);
        assert_int_equal(m.mirror, SALTUS_MIRROR_SELF);
        saltus_motion_clear(&m);
    }
    saltus_motion m = motion_of("van-der-pol", "mu=100");
    check_cycle(&m);
    check_near(m.period, 100 * (3 - 2 * log(2)) + 7.0143 * pow(100, -1.0 / 3), 0.15);
    saltus_motion_clear(&m);
}

/* Period and multipliers do not depend on the choice of the section. */
static void sections_do_not_matter(void **unused) {
    (void)unused;
    static const char *const of_what[] = {"observe=q1", "observe=q2", "observe=support"};
    saltus_motion m[3];
    for (int k = 0; k < 3; k++) {
        const char *settings[] = {"u=7.97", of_what[k]};
        saltus_scene scene = scene_with("flutter", settings, 2);
        m[k] = classified(&scene);
        saltus_scene_clear(&scene);
        check_cycle(&m[k]);
        assert_int_equal(m[k].periods, 2);
        assert_int_equal(m[k].mirror, SALTUS_MIRROR_PAIR);
        check_near(m[k].period, m[0].period, 1e-10);
        for (int i = 0; i < 2; i++)
            check_near(m[k].multipliers[i].re, m[0].multipliers[i].re, 1e-10);
    }
    for (int k = 0; k < 3; k++)
        saltus_motion_clear(&m[k]);
}

/* The nontrivial multipliers are those of differences of the flow over one period. */
static void multipliers_agree_with_differences(void **unused) {
    (void)unused;
    const double step = 1e-5;
    saltus_message message = {.text = ""};
    saltus_scene scene = scene_with("relief-valve", (const char *const[]){"q=3.05"}, 1);
    saltus_motion m = classified(&scene);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *system = NULL;
    saltus_flow *flow = NULL;
    saltus_event event;
    double trace = 0, sum = m.trivial_multiplier;
    saltus_spec_set_omega(&scene.spec, 2 * M_PI / m.period);
    check_ok(saltus_system_new(&scene.spec, &system, &message), &message);
    check_ok(saltus_flow_single(system, 0, &options, &flow, &message), &message);
    for (int i = 0; i < 3; i++) {
        double ends[2];
        for (int side = 0; side < 2; side++) {
            double state[3] = {m.state[0], m.state[1], m.state[2]}, end[3];
            state[i] += side ? step : -step;
            check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, &message), &message);
            check_ok(saltus_flow_advance(flow, (saltus_time){1, 0}, 0, &event, &message), &message);
            saltus_flow_state(flow, 0, end);
            ends[side] = end[i];
        }
        trace += (ends[1] - ends[0]) / (2 * step);
    }
    for (int k = 0; k < m.multiplier_count; k++)
        sum += m.multipliers[k].re;
    check_near(trace, sum, 1e-7);
    saltus_flow_free(flow);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
    saltus_motion_clear(&m);
}

/* All points of the branch in a parameter through the orbit on which a scene settles. */
static branch_record branch_of(const char *name, const char *setting, saltus_branch_options options) {
    saltus_scene scene = scene_with(name, &setting, 1);
    saltus_motion m = classified(&scene);
    check_cycle(&m);
    saltus_spec_set_omega(&scene.spec, 2 * M_PI / m.period);
    options.orbit.free_period = true;
    branch_record record = branch_run(&scene.spec, m.periods, m.state, &options);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->kind == SALTUS_POINT_HB || (p->kind == SALTUS_POINT_EP && strstr(p->reason, "equilibrium")))
            continue;
        assert_int_equal(p->multiplier_count, p->dimension - 1);
        check_near(p->trivial_multiplier, 1, 1e-9);
        check_near(2 * M_PI / saltus_spec_omega(&p->spec), p->period, 1e-12 * p->period);
    }
    saltus_scene_clear(&scene);
    saltus_motion_clear(&m);
    return record;
}

static const saltus_branch_point *special(const branch_record *record, saltus_point_kind kind, int number) {
    for (int k = 0; k < record->count; k++)
        if (record->point[k].kind == kind && --number == 0)
            return &record->point[k];
    fail_msg("there is no such %s", saltus_point_word(kind));
    return NULL;
}

/* Where the valve's limit cycle is born, by Hurwitz' condition for its equilibria, and, from an independent
 * program, where it grazes its seat. */
static void the_valves_cycle_is_born_and_grazes(void **unused) {
    (void)unused;
    branch_record record = branch_of("relief-valve", "q=8", branch_along("q", 7.3, 8.6));
    const saltus_branch_point *hopf = special(&record, SALTUS_POINT_HB, 1),
                              *grazing = special(&record, SALTUS_POINT_GR, 1);
    check_near(hopf->value[0], 8.49111763518332712, hopf->accuracy);
    assert_true(hopf->accuracy < 5e-14);
    check_near(hopf->period, 2 * M_PI / 3.090708847974, 1e-11);
    check_near(hopf->state[0], 2.41031323768665016, 1e-13);
    check_near(grazing->value[0], 7.557210971877, 1e-11);
    check_near(grazing->period, 2.656012147475, 1e-11);
    assert_string_equal(grazing->label, "0/1");
    assert_string_equal(grazing->label_after, "1/1");
    branch_forget(&record);
}

/* Published: the flutter of two modes loses its symmetry and doubles its period repeatedly; the distances of
 * the flips shrink by Feigenbaum's ratio. */
static void flutter_goes_through_a_cascade(void **unused) {
    (void)unused;
    saltus_branch_options options = branch_along("u", 6.9, 8.03);
    options.direction = 1;
    options.switches = 6;
    branch_record record = branch_of("flutter", "u=7", options);
    double flip[5];
    const saltus_branch_point *fork = special(&record, SALTUS_POINT_BP, 1);
    check_near(fork->value[0], 7.5714222765, 1e-9);
    check_near(fork->period, 0.4297443980, 1e-9);
    for (int k = 0; k < 5; k++) {
        const saltus_branch_point *at = special(&record, SALTUS_POINT_PD, k + 1);
        flip[k] = at->value[0];
        if (k < 2)
            check_near(at->period, k ? 0.8827107165 : 0.4405179263, 1e-9);
        if (k)
            assert_true(flip[k] > flip[k - 1]);
    }
    check_near(flip[0], 7.9492913690, 1e-9);
    check_near(flip[1], 8.0119458082, 1e-9);
    assert_true(flip[4] < 8.03);
    check_near((flip[3] - flip[2]) / (flip[4] - flip[3]), 4.669, 0.1);
    branch_forget(&record);
}

/* Downwards the flutter dies at a Hopf point: there the equilibrium has a pair of imaginary eigenvalues,
 * whose frequency is the cycle's. */
static void a_hopf_point_is_one_of_the_equilibrium(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_branch_options options = branch_along("u", 6, 7.1);
    options.direction = -1;
    branch_record record = branch_of("flutter", "u=7", options);
    const saltus_branch_point *hopf = special(&record, SALTUS_POINT_HB, 1);
    check_near(hopf->value[0], 6.27078414, 1e-8);
    saltus_system *system = NULL;
    saltus_equilibrium rest = {0};
    saltus_equilibrium_options how = saltus_equilibrium_defaults();
    double zero[4] = {0}, closest = INFINITY, frequency = 0;
    char setting[40];
    snprintf(setting, sizeof setting, "u=%.17g", hopf->value[0]);
    saltus_scene scene = scene_with("flutter", (const char *const[]){setting}, 1);
    check_ok(saltus_system_new(&scene.spec, &system, &message), &message);
    check_ok(saltus_equilibrium_find(system, zero, &how, &rest, &message), &message);
    for (int k = 0; k < 4; k++)
        if (rest.eigenvalues[k].im > 0 && fabs(rest.eigenvalues[k].re) < closest) {
            closest = fabs(rest.eigenvalues[k].re);
            frequency = rest.eigenvalues[k].im;
        }
    check_near(closest, 0, 1e-8);
    check_near(2 * M_PI / hopf->period, frequency, 1e-6);
    saltus_equilibrium_clear(&rest);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
    branch_forget(&record);
}

/* Commands pass orbits on in files. */
static void files_keep_the_period(void **state) {
    fixture *f = *state;
    char *text = told(f, "orbit relief-valve --set q=7.05 --periods 1 --json");
    json *orbit = json_read(text);
    double period = json_number_at(orbit, "period");
    assert_true(json_number_at(orbit, "periods") == 1 && period > 2 && period < 3);
    check_near(json_number_at(orbit, "trivial_multiplier"), 1, 1e-9);
    FILE *file = fopen(path_in(f, "orbit.json"), "w");
    fputs(text, file);
    fclose(file);
    free(text);
    text = told(f, "orbit relief-valve --from orbit.json --json");
    json *again = json_read(text);
    check_near(json_number_at(again, "period"), period, 1e-12);
    json_free(again);
    free(text);
    free(told(f, "continue relief-valve --from orbit.json --in q=6:7.1 -o branch.h5"));
    text = told(f, "orbit relief-valve --from branch.h5:PD1 --json");
    again = json_read(text);
    check_near(json_number_at(again, "parameters.q"), 6.06651453982, 1e-10);
    check_near(json_number_at(again, "multipliers.0.0"), -1, 1e-6);
    json_free(again);
    free(text);
    /* An interrupted and resumed run gives the same file. */
    free(told(f, "continue relief-valve --from orbit.json --in q=6:7.1 --points 20 -o cut.h5"));
    free(told(f, "diagnose relief-valve --from orbit.json -o sheet.png"));
    free(told(f, "simulate relief-valve --from orbit.json --periods 3 -o run.csv"));
    free(told(f, "lyapunov relief-valve --from orbit.json"));
    json_free(orbit);
}

/* A mass with impacts, beside another that always rests on its own stop: the cycle is the same as beside a
 * wall in that place. It is found again from its section point, which lies on the first stop. */
static void what_rests_beside_a_cycle_does_not_matter(void **unused) {
    (void)unused;
    static const char *const texts[] = {
        "model:\n"
        "  parameters: {e: 0.7, y0: 0.1}\n"
        "  motion: {x: e*(1 - x^2)*x' - x + 0.25*(x - y0) + 0.4}\n"
        "stop: {coordinate: x, d: 0.3, r: 0.57, sides: upper}\n"
        "initial: {x: -0.6}\n",
        "model:\n"
        "  parameters: {e: 0.7, y0: 0.1}\n"
        "  motion: {x: e*(1 - x^2)*x' - x + 0.25*(x - y) + 0.4, y: -3 - 2*y - 0.2*y' + 0.25*(x - y)}\n"
        "stops:\n"
        "  - {coordinate: x, d: 0.3, r: 0.57, sides: upper}\n"
        "  - {coordinate: y, d: -y0, r: 0.4, sides: lower}\n"
        "initial: {x: -0.6, y: 2}\n"};
    saltus_message message = {.text = ""};
    for (int k = 0; k < 4; k++) {
        saltus_motion m[2];
        char place[32];
        snprintf(place, sizeof place, "y0=%g", 0.1 * k - 0.1);
        for (int rests = 0; rests < 2; rests++) {
            saltus_scene scene;
            saltus_orbit orbit;
            saltus_orbit_options options = saltus_orbit_defaults();
            check_ok(saltus_scene_parse(texts[rests], strlen(texts[rests]), "text", &scene, &message),
                     &message);
            check_ok(saltus_scene_set(&scene, place, &message), &message);
            m[rests] = classified(&scene);
            assert_true(rests == m[rests].sticks);
            assert_string_equal(m[rests].label, "1/1");
            saltus_spec_set_omega(&scene.spec, 2 * M_PI / m[rests].period);
            saltus_system *system = build(&scene.spec);
            options.free_period = true;
            check_ok(saltus_orbit_find(system, 1, m[rests].state, &options, &orbit, &message), &message);
            check_near(2 * M_PI / orbit.omega, m[rests].period, 1e-10);
            saltus_orbit_clear(&orbit);
            saltus_system_free(system);
            saltus_scene_clear(&scene);
        }
        check_near(m[1].period, m[0].period, 1e-10);
        check_near(m[1].multipliers[0].re, m[0].multipliers[0].re, 1e-9);
        saltus_motion_clear(&m[0]);
        saltus_motion_clear(&m[1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_valve_agrees_with_independent_programs),
        cmocka_unit_test(the_valve_has_no_period_where_it_is_chaotic),
        cmocka_unit_test(van_der_pol_follows_its_asymptotics),
        cmocka_unit_test(sections_do_not_matter),
        cmocka_unit_test(multipliers_agree_with_differences),
        cmocka_unit_test(the_valves_cycle_is_born_and_grazes),
        cmocka_unit_test(flutter_goes_through_a_cascade),
        cmocka_unit_test(a_hopf_point_is_one_of_the_equilibrium),
        cmocka_unit_test(what_rests_beside_a_cycle_does_not_matter),
        cmocka_unit_test_setup_teardown(files_keep_the_period, open_fixture, close_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
