/* How many steps a question may take: ordinary scenes never come near the limit, extreme ones end soon and
 * name the cause.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"

#include "flow/effort.h"
#include "system/system.h"

static saltus_scene built_in(const char *name) {
    saltus_scene scene;
    saltus_message message;
    check_ok(saltus_scene_load(name, &scene, &message), &message);
    return scene;
}

/* The effort that classifying a scene takes beyond the usual, and its status. */
static saltus_status classify(const saltus_scene *scene, const saltus_classify_options *options,
                              double *spent, saltus_message *message) {
    saltus_system *system = NULL;
    saltus_motion motion = {0};
    saltus_effort effort;
    double state[SALTUS_STATE_MAX];
    saltus_classify_options how = *options;
    saltus_status status = saltus_system_new(&scene->spec, &system, message);
    if (status == SALTUS_OK)
        status = saltus_scene_state(scene, system, state, message);
    check_ok(status, message);
    how.flow = saltus_effort_begin(&options->flow, system, &effort);
    status = saltus_classify(system, state, &how, &motion, message);
    *spent = effort.spent;
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return status;
}

/* The built-in scenes use at most a hundredth of it, whatever their verdict. */
static void healthy_scenes_spend_next_to_nothing(void **state) {
    (void)state;
    skip_where_slow();
    saltus_classify_options how = saltus_classify_defaults();
    how.transient = 1000;
    how.measure = 4000;
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        saltus_message message = {.text = ""};
        saltus_scene scene = built_in(saltus_scene_builtin_name(k));
        double spent;
        check_ok(classify(&scene, &how, &spent, &message), &message);
        if (!(spent < 0.01 * SALTUS_EFFORT_MOST))
            fail_msg("%s: %.3g steps beyond the usual", saltus_scene_builtin_name(k), spent);
        saltus_scene_clear(&scene);
    }
}

/* A relaxation oscillation with a period of hundreds or thousands of units of time, in stiff steps, also
 * stays within it. The period is known for great mu: (3 - 2 ln 2) mu + 7.01432 mu^(-1/3) - O(ln mu / mu). */
static void slow_cycles_are_found(void **state) {
    static const double strengths[] = {100, 300, 1000};
    (void)state;
    skip_where_slow();
    for (size_t k = 0; k < sizeof strengths / sizeof strengths[0]; k++) {
        saltus_classify_options how = saltus_classify_defaults();
        const double mu = strengths[k], period = (3 - 2 * log(2)) * mu + 7.01432 / cbrt(mu);
        saltus_message message = {.text = ""};
        saltus_scene scene = built_in("van-der-pol");
        saltus_system *system = NULL;
        saltus_motion motion = {0};
        saltus_effort effort;
        char setting[32];
        snprintf(setting, sizeof setting, "mu=%g", mu);
        check_ok(saltus_scene_set(&scene, setting, &message), &message);
        check_ok(saltus_system_new(&scene.spec, &system, &message), &message);
        const double start[2] = {0.5, 0};
        how.flow = saltus_effort_begin(&how.flow, system, &effort);
        check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
        check_near(motion.period, period, 2 * log(mu) / mu);
        assert_int_equal(motion.multiplier_count, 1);
        check_near(motion.multipliers[0].log_modulus, motion.sum_rule, 1e-6 * fabs(motion.sum_rule));
        assert_true(effort.spent < 0.2 * SALTUS_EFFORT_MOST);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* For slower and slower forcing there is an answer or, from some frequency on, a message that names it, never
 * more effort. */
static void slow_forcing_is_named(void **state) {
    static const char *const names[] = {"pipe", "impact-oscillator", "duffing"};
    (void)state;
    skip_where_slow();
    saltus_classify_options how = saltus_classify_defaults();
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        bool given_up = false;
        for (int e = 2; e <= 6; e += 4) {
            saltus_message message = {.text = ""};
            saltus_scene scene = built_in(names[k]);
            char setting[32], words[40];
            double spent, omega = pow(10, -e);
            snprintf(setting, sizeof setting, "omega=%g", omega);
            snprintf(words, sizeof words, "omega = %.6g is too small", omega);
            check_ok(saltus_scene_set(&scene, setting, &message), &message);
            const saltus_status status = classify(&scene, &how, &spent, &message);
            if (status == SALTUS_OK ? given_up : !strstr(message.text, words))
                fail_msg("%s, %s: %s", names[k], setting, message.text);
            assert_true(spent <= SALTUS_EFFORT_MOST + 100);
            given_up |= status != SALTUS_OK;
            saltus_scene_clear(&scene);
        }
        assert_true(given_up);
    }
}

/* A flow with an effort that any flow has used up goes no further; without it, it does. */
static void a_used_up_effort_ends_all_flows(void **state) {
    (void)state;
    saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 1);
    saltus_system *system = NULL;
    saltus_message message = {.text = ""};
    saltus_effort effort;
    double start[2] = {0, 0};
    check_ok(saltus_system_new(&spec, &system, &message), &message);
    saltus_flow_options none = saltus_flow_defaults(), options = saltus_effort_begin(&none, system, &effort);
    check_ok(saltus_motion_settle(system, &options, 10, start, &message), &message);
    assert_true(effort.spent < 100);
    check_near(saltus_effort_begin(&options, system, &(saltus_effort){0}).effort->spent, effort.spent, 0);
    effort.spent = SALTUS_EFFORT_MOST + 1;
    assert_int_equal(saltus_motion_settle(system, &options, 1, start, &message), SALTUS_STALLED);
    assert_non_null(strstr(message.text, "given up: "));
    check_ok(saltus_motion_settle(system, &none, 1, start, &message), &message);
    /* What a step costs, with columns, less the allowance of its time. */
    effort = (saltus_effort){.period = 2};
    saltus_effort_add(&effort, 0, 2, 0, false);
    check_near(effort.spent, 1, 0);
    saltus_effort_add(&effort, 0, 2, 3, false);
    check_near(effort.spent, 5, 0);
    saltus_effort_add(&effort, 1.0 / SALTUS_EFFORT_USUAL, 2, 7, false);
    check_near(effort.spent, 5, 1e-12);
    saltus_effort_add(&effort, 0, 2, 0, true);
    check_near(effort.spent, 17, 1e-12);
    saltus_effort_add(&effort, 1.0 / SALTUS_EFFORT_USUAL_STIFF, 2, 7, true);
    check_near(effort.spent, 17, 1e-12);
    saltus_effort_add(&effort, 1, 2, 0, false);
    check_near(effort.spent, 0, 0);
    /* Each point of a branch subtracts its allowance. */
    effort.spent = 1.5 * SALTUS_EFFORT_AT_POINT;
    saltus_effort_next_point(&effort);
    check_near(effort.spent, 0.5 * SALTUS_EFFORT_AT_POINT, 0);
    saltus_effort_next_point(&effort);
    check_near(effort.spent, 0, 0);
    /* If no period is set, step counts refer to each system's own. */
    check_near(saltus_effort_period(&effort, 3), 2, 0);
    effort.period = 0;
    check_near(saltus_effort_period(&effort, 3), 3, 0);
    saltus_system_free(system);
}

/* Many steps per period are reported with their cause, even if a single period could be followed. */
static void stiff_elements_are_named(void **state) {
    (void)state;
    skip_where_slow();
    saltus_classify_options how = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_scene scene = built_in("two-mass");
    double spent;
    check_ok(saltus_scene_set(&scene, "kz=1e6", &message), &message);
    assert_int_equal(classify(&scene, &how, &spent, &message), SALTUS_STALLED);
    assert_non_null(strstr(message.text, "kz = 1e+06 is too great"));
    assert_true(spent <= SALTUS_EFFORT_MOST + 100);
    saltus_scene_clear(&scene);
}

/* Without damping no orbit attracts, or so slowly that no trajectory would be seen to come to it: such
 * motions are not measured to the end. What a longer run does decide it still does. */
static void undamped_motions_are_measured_as_far_as_that_tells(void **state) {
    static const struct {
        const char *settings[3], *reason;
        saltus_verdict verdict;
        long long periods;
    } cases[] = {{{"N=2", "alpha=0", "sigma=0"}, "volumes are kept", SALTUS_UNDECIDED, 32000},
                 {{"N=3", "alpha=0", "sigma=0"}, "volumes are kept", SALTUS_UNDECIDED, 32000},
                 {{"N=3", "alpha=1e-6", "r=0.95"}, "a stable 0/1 orbit lies", SALTUS_TRANSIENT, 32000},
                 {{"N=3", "alpha=0", "sides=none"}, "none of 8 trajectories", SALTUS_CHAOTIC, 32000}};
    (void)state;
    skip_where_slow();
    saltus_classify_options how = saltus_classify_defaults();
    assert_true(how.measure > 200000);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_scene scene = built_in("pipe");
        saltus_message message = {.text = ""};
        saltus_system *system = NULL;
        saltus_motion motion;
        double start[SALTUS_STATE_MAX];
        for (int i = 0; i < 3; i++)
            check_ok(saltus_scene_set(&scene, cases[k].settings[i], &message), &message);
        check_ok(saltus_system_new(&scene.spec, &system, &message), &message);
        check_ok(saltus_scene_state(&scene, system, start, &message), &message);
        check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
        if (motion.verdict != cases[k].verdict || !strstr(motion.reason, cases[k].reason) ||
            motion.evidence.periods != cases[k].periods)
            fail_msg("case %zu: %s: %s (%lld periods)", k, motion.label, motion.reason,
                     motion.evidence.periods);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* A clearance far below the motion's size does not set its scale: the motion is that without clearance, and
 * is found as quickly. */
static void tiny_clearances_are_no_scale(void **state) {
    static const char *const cases[][2] = {{"relief-valve", "1e-300"},
                                           {"relief-valve", "1e-6"},
                                           {"relief-valve", "0"},
                                           {"impact-oscillator", "1e-300"},
                                           {"impact-oscillator", "1e-9"},
                                           {"impact-oscillator", "0"},
                                           {"chain", "1e-300"},
                                           {"chain", "1e-9"},
                                           {"chain", "0"}};
    fixture *f = *state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char line[80];
        snprintf(line, sizeof line, "classify %s --set d=%s", cases[k][0], cases[k][1]);
        char *out = told(f, line);
        if (!strstr(out, k < 3   ? "relief-valve: 1/1, stable"
                         : k < 6 ? "impact-oscillator: 2/1, stable"
                                 : "chain: 2/2, stable"))
            fail_msg("%s: %s", line, out);
        free(out);
    }
}

/* If the flow preserves volumes no orbit attracts; a stable orbit amid chaos is sought only where one can
 * exist. */
static void volumes_are_kept_or_not(void **state) {
    static const struct {
        const char *name, *settings[2];
        bool kept;
    } cases[] = {{"pipe", {"alpha=0", "sides=none"}, true},   {"pipe", {"alpha=0", "r=1"}, true},
                 {"pipe", {"alpha=0", "r=0.9"}, false},       {"pipe", {"alpha=1e-6", "r=1"}, false},
                 {"impact-oscillator", {"c=0", "r=1"}, true}, {"duffing", {"c=0", "r=0.8"}, false}};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_message message = {.text = ""};
        saltus_scene scene = built_in(cases[k].name);
        saltus_system *system = NULL;
        for (int i = 0; i < 2; i++)
            check_ok(saltus_scene_set(&scene, cases[k].settings[i], &message), &message);
        check_ok(saltus_system_new(&scene.spec, &system, &message), &message);
        if (saltus_system_keeps_volume(system) != cases[k].kept)
            fail_msg("%s, %s, %s", cases[k].name, cases[k].settings[0], cases[k].settings[1]);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* A branch into too slow forcing ends there with a message that names it; its points are kept. */
static void branches_end_where_they_take_too_much(void **state) {
    fixture *f = *state;
    skip_where_slow();
    char *out = told(f, "continue impact-oscillator --in omega=1e-9:1 -o branch.h5 --force");
    const char *flip = strstr(out, "PD"), *end = strstr(out, "given up: ");
    assert_non_null(flip);
    if (!end || end < flip || !strstr(end, "omega = ") || !strstr(end, " is too small"))
        fail_msg("%s", out);
    free(out);
}

/* Whatever is asked of a scene ends with the sentence that names what was too much. */
static void every_command_names_what_was_too_much(void **state) {
    static const struct {
        const char *line, *part;
    } cases[] = {{"simulate duffing --set omega=1e-6 --periods 1 --quiet -o x.csv --force",
                  "omega = 1e-06 is too small"},
                 {"simulate relief-valve --set beta=1e6 --periods 20 --quiet -o x.csv --force",
                  "beta = 1e+06 is too "},
                 {"orbit bouncing-ball --set k=1e6 --periods 1 --quiet", "k = 1e+06 is too great"},
                 {"lyapunov relief-valve --set kappa=1e6 --quiet", "kappa = 1e+06 is too great"},
                 {"classify van-der-pol --set mu=1e300", "mu = 1e+300 is too great"},
                 {"classify two-mass --set k2=1e12", "k2 = 1e+12 is too great"},
                 {"classify impact-pair --set d=1e-300", "d = 1e-300 is too small a clearance"},
                 {"classify impact-damper --set d=1e-12", "d = 1e-12 is too small a clearance"},
                 {"classify relief-valve --set delta=1e12 q=1e12",
                  "q = 1e+12 is too great, or delta = 1e+12 is too great"},
                 {"classify flutter --set u=1e-6 gamma=-1e3",
                  ": u = 1e-06 is too small, or gamma = -1000 is too great"},
                 /* There is no second mass. */
                 {"classify impact-oscillator --set F02=1e12 omega=1e-6", ": omega = 1e-06 is too small"},
                 {"classify two-stops --set d1=1e-300 k=1e12",
                  "d1 = 1e-300 is too small a clearance, or k = 1e+12 is too great"},
                 {"classify pipe --set N=64 alpha=0 sigma=0.5", "N = 64 is too great"},
                 {"diagnose vibrating-table --set omega=1e-300 -o x.svg", "omega = 1e-300 is too small"},
                 {"classify duffing --set c=1e300", "c = 1e+300 is too great"},
                 {"lyapunov two-mass --set m=1e-300 --quiet", "m = 1e-300 is too small"},
                 {"diagnose duffing --set omega=1e-6 -o x.svg --quiet", "omega = 1e-06 is too small"},
                 {"spectrum duffing --set omega=1e-6 --quiet", "omega = 1e-06 is too small"}};
    fixture *f = *state;
    skip_where_slow();
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const int status = run(f, cases[k].line);
        char *err = said(f, "err");
        if (status != 1 || strncmp(err, "saltus: ", 8) != 0 || !strstr(err, cases[k].part))
            fail_msg("%s: exit status %d: %s", cases[k].line, status, err);
        free(err);
    }
}

/* Orbits of which a period takes more steps than a search spends, or that are millions of times as large as
 * the clearance which is their scale, are found as soon as they are all but reached. */
static void orbits_of_extreme_scenes_are_found(void **state) {
    static const char *const cases[][3] = {{"gear-rattle", "omega=1e-6", "gear-rattle: chatter/1, stable"},
                                           {"impact-pair", "omega=1e-6", "impact-pair: chatter/1, stable"},
                                           {"chain", "F=-1e6", "chain: 2/2, stable"},
                                           {"chain", "F=1e4", "chain: 2/2, stable"},
                                           {"chain", "d=1e-6", "chain: 2/2, stable"}};
    fixture *f = *state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char line[80];
        snprintf(line, sizeof line, "classify %s --set %s", cases[k][0], cases[k][1]);
        char *out = told(f, line);
        const char *settled = strstr(out, "settled");
        if (!strstr(out, cases[k][2]) || !settled || strtol(settled + 7, NULL, 10) > 400)
            fail_msg("%s: %s", line, out);
        free(out);
    }
}

/* Verdicts that rounding or strong damping might have hidden: an impact in the very section of a resonant
 * oscillator does not double its period; creeping along a slow manifold is no rest; clearances that are never
 * met are no scale; a box much larger in its motion than the ball's room is no pre-load. */
static void extreme_scenes_are_not_mistaken(void **state) {
    static const char *const cases[][2] = {
        {"impact-oscillator --set c=0", "impact-oscillator: 1/1, stable"},
        {"impact-oscillator --set c=1e-12", "impact-oscillator: 1/1, stable"},
        {"van-der-pol --set mu=1e12", "van-der-pol: undecided"},
        {"van-der-pol --set mu=1e6", "van-der-pol: undecided"},
        {"impact-damper --set F=1e3", "impact-damper: chatter/1, stable"},
        {"impact-damper --set d=1e-6", "impact-damper: chatter/1, stable"},
        {"duffing --set d=1e3", "duffing: 0/7, stable"},
        {"duffing --set d=1e6", "duffing: 0/7, stable"},
        {"duffing --set d=1e9", "duffing: 0/7, stable"},
        /* As light a mass as may be: its own motion dies at once, and it creeps along. */
        {"impact-oscillator --set m=1e-5", "impact-oscillator: 0/1, stable"},
        {"impact-oscillator --set m=1e-6", "impact-oscillator: 0/1, stable"},
        {"impact-oscillator --set m=3e-7", "impact-oscillator: 0/1, stable"},
        {"impact-oscillator --set m=1e-9", "impact-oscillator: 0/1, stable"},
        {"light.yaml", "light: 0/1, stable"},
        {"light.yaml --set m=1e-5", "light: 0/1, stable"}};
    fixture *f = *state;
    skip_where_slow();
    FILE *light = fopen(path_in(f, "light.yaml"), "w");
    assert_non_null(light);
    fputs("model:\n  parameters: {m: 1e-6, c: 0.1, k: 1, F: 0.5, omega: 1}\n"
          "  motion: {x: (F*cos(omega*t) - c*x' - k*x)/m}\n  forcing: omega\n"
          "stop: {coordinate: x, d: 1, r: 0.8}\n",
          light);
    fclose(light);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char line[80];
        snprintf(line, sizeof line, "classify %s", cases[k][0]);
        char *out = told(f, line);
        if (strncmp(out, cases[k][1], strlen(cases[k][1])) != 0)
            fail_msg("%s: %s", line, out);
        free(out);
    }
}

/* Relaxation oscillations whose cycle is many thousand units of time long are waited for; their periods are
 * (3 - 2 ln 2) mu + 7.01432 mu^(-1/3) - 2 ln(mu)/(3 mu) + ... Where double precision ends, this is said. */
static void slow_relaxation_is_a_cycle(void **state) {
    fixture *f = *state;
    skip_where_slow();
    static const double strengths[] = {5000, 20000, 50000};
    for (int k = 0; k < 3; k++) {
        const double mu = strengths[k];
        char line[96];
        snprintf(line, sizeof line, "classify van-der-pol --set mu=%g", mu);
        char *out = told(f, line), *period = strstr(out, "; period ");
        if (strncmp(out, "van-der-pol: 0/1, stable", 24) != 0 || !period)
            fail_msg("%s: %s", line, out);
        check_near(strtod(period + 9, NULL),
                   (3 - 2 * log(2)) * mu + 7.01432 / cbrt(mu) - 2 * log(mu) / (3 * mu), 1e-3);
        free(out);
    }
    char *out = told(f, "classify van-der-pol --set mu=80000 --transient 1000000");
    if (strncmp(out, "van-der-pol: undecided", 22) != 0 || !strstr(out, " units of time apart, repeat to "))
        fail_msg("%s", out);
    free(out);
}

/* What an undecided verdict says would tell does so: here as long a transient as it names, where the cycle is
 * so slow that it has hardly been seen to repeat. */
static void what_would_tell_tells(void **state) {
    fixture *f = *state;
    skip_where_slow();
    static const int strengths[] = {280, 300};
    for (int k = 0; k < 2; k++) {
        char line[96];
        snprintf(line, sizeof line, "classify van-der-pol --set mu=%d --transient 64", strengths[k]);
        char *out = told(f, line), *hint = strstr(out, "--transient ");
        if (strncmp(out, "van-der-pol: undecided", 22) != 0 ||
            !strstr(out, " returns to the section within ") || !hint)
            fail_msg("%s: %s", line, out);
        snprintf(line, sizeof line, "classify van-der-pol --set mu=%d --transient %ld", strengths[k],
                 strtol(hint + 12, NULL, 10));
        free(out);
        out = told(f, line);
        if (strncmp(out, "van-der-pol: 0/1, stable", 24) != 0)
            fail_msg("%s: %s", line, out);
        free(out);
    }
}

/* Sweeps and basins fail as classification does only if all of their trajectories fail. */
static void sweeps_say_why_all_have_failed(void **state) {
    static const struct {
        const char *line, *part;
    } cases[] = {
        {"sweep pipe --over d=-5,-6 --quiet -o x.h5", "a pre-load of this size is too much"},
        {"sweep pipe --over d=-5,-6 --transient 100 --quiet --json -o x.csv", "a pre-load of this size "},
        {"basins pipe --set d=-5 --over q1=-6,-7 --over v1=0,1 --quiet -o x.csv --force", "a pre-load of "},
        {"sweep relief-valve --over q=1e10,2e10 --quiet -o x.h5 --force", "q = 1e+10 is too great"},
        {"sweep impact-oscillator --over omega=1e-7,2e-7 --quiet -o x.h5 --force", "omega = 1e-07 is too "}};
    fixture *f = *state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const int status = run(f, cases[k].line);
        char *err = said(f, "err");
        if (status != 1 || strncmp(err, "saltus: no trajectory could be followed; the first: ", 52) != 0 ||
            !strstr(err, cases[k].part))
            fail_msg("%s: exit status %d: %s", cases[k].line, status, err);
        free(err);
    }
    free(told(f, "sweep impact-oscillator --over omega=1e-7,1 --quiet -o x.h5 --force"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(healthy_scenes_spend_next_to_nothing),
        cmocka_unit_test(slow_cycles_are_found),
        cmocka_unit_test(slow_forcing_is_named),
        cmocka_unit_test(stiff_elements_are_named),
        cmocka_unit_test(undamped_motions_are_measured_as_far_as_that_tells),
        cmocka_unit_test(volumes_are_kept_or_not),
        cmocka_unit_test_setup_teardown(tiny_clearances_are_no_scale, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(every_command_names_what_was_too_much, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(orbits_of_extreme_scenes_are_found, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(extreme_scenes_are_not_mistaken, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(slow_relaxation_is_a_cycle, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(what_would_tell_tells, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(branches_end_where_they_take_too_much, open_fixture, close_fixture),
        cmocka_unit_test(a_used_up_effort_ends_all_flows),
        cmocka_unit_test_setup_teardown(sweeps_say_why_all_have_failed, open_fixture, close_fixture)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
