/* Changes along branches of cycles, and how the branches continue.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"

#include "flow/flow.h"
#include "orbit/lap.h"
#include "saltus/scene.h"

static saltus_scene scene_from(const char *text, const char *const *settings, int count) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    for (int k = 0; k < count; k++)
        check_ok(saltus_scene_set(&scene, settings[k], &message), &message);
    return scene;
}

/* All points of the branch through the cycle on which a scene settles; *reach (may be NULL): the highest
 * displacement of that cycle. */
static branch_record branch_of(saltus_scene *scene, saltus_branch_options options, double *reach) {
    saltus_message message = {.text = ""};
    saltus_classify_options classify = saltus_classify_defaults();
    saltus_system *system = build(&scene->spec);
    saltus_motion m;
    double state[SALTUS_STATE_MAX];
    check_ok(saltus_scene_state(scene, system, state, &message), &message);
    check_ok(saltus_classify(system, state, &classify, &m, &message), &message);
    assert_int_equal(m.verdict, SALTUS_PERIODIC);
    saltus_spec_set_omega(&scene->spec, 2 * M_PI / m.period);
    options.orbit.free_period = true;
    branch_record record = branch_run(&scene->spec, m.periods, m.state, &options);
    if (reach)
        *reach = m.largest;
    saltus_motion_clear(&m);
    saltus_system_free(system);
    return record;
}

/* The number of special points of a branch, of any kind. */
static int count_special(const branch_record *record) {
    int count = 0;
    for (int k = 0; k < record->count; k++)
        count += branch_special(&record->point[k]);
    return count;
}

/* The valve's cycle touches its seat at one place, wherever the branch begins and however long its steps;
 * also if the orbit is cut open where the lift is smallest. */
static void grazing_is_met_from_everywhere(void **unused) {
    (void)unused;
    static const struct {
        const char *setting;
        double step_max;
    } starts[] = {{"q=7.6", 0.02}, {"q=7.9", 0.02}, {"q=7.9", 0.3}, {"q=8.2", 0.1}};
    for (size_t k = 0; k < sizeof starts / sizeof starts[0]; k++) {
        saltus_scene scene;
        saltus_message message = {.text = ""};
        check_ok(saltus_scene_load("relief-valve", &scene, &message), &message);
        check_ok(saltus_scene_set(&scene, starts[k].setting, &message), &message);
        saltus_branch_options options = branch_along("q", 7.5, 8.3);
        options.direction = -1;
        options.step_max = starts[k].step_max;
        branch_record record = branch_of(&scene, options, NULL);
        assert_int_equal(count_special(&record), 1);
        for (int j = 0; j < record.count; j++)
            if (branch_special(&record.point[j])) {
                assert_int_equal(record.point[j].kind, SALTUS_POINT_GR);
                check_near(record.point[j].value[0], 7.557210971877, 1e-11);
                assert_string_equal(record.point[j].label_after, "1/1");
            }
        check_near(record.point[record.count - 1].value[0], 7.5, 0);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* At a touch of the seat the cycle's one impact counts, on whichever side of it the flow sees the orbit; the
 * label agrees with the count. */
static void labels_on_a_curve_of_grazing_say_what_is_counted(void **unused) {
    (void)unused;
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load("relief-valve", &scene, &message), &message);
    check_ok(saltus_scene_set(&scene, "q=7.6", &message), &message);
    saltus_branch_options options = branch_along("q", 7.4, 7.7);
    snprintf(options.key[1], sizeof options.key[1], "delta");
    options.low[1] = 9.9;
    options.high[1] = 10.1;
    options.locus = SALTUS_POINT_GR;
    options.direction = -1;
    options.points = 60;
    branch_record record = branch_of(&scene, options, NULL);
    assert_true(record.count >= 20);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        assert_int_equal(p->impacts, 1);
        assert_int_equal(p->event_count, 1);
        assert_string_equal(p->label, "1/1");
    }
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

/* From the point's state a planar flow touches the stop after the time that is told. */
static void check_planar_touch(const saltus_branch_point *p) {
    saltus_message message = {.text = ""};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = NULL;
    double state[2];
    saltus_system *system = build(&p->spec);
    memcpy(state, p->state, sizeof state);
    check_ok(saltus_flow_single(system, 0, &options, &flow, &message), &message);
    check_ok(saltus_state_carry(flow, (saltus_time){0, 0}, saltus_time_of(fmax(0, p->grazing_time - 1e-6)),
                                state, &message),
             &message);
    check_near(state[0], p->grazing_side * p->value[0], 1e-9);
    check_near(state[1], 0, 1e-4);
    if (p->event_count)
        check_near(saltus_time_periods(p->events[0].time), p->grazing_time, 1e-9);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Van der Pol's cycle meets stops at its amplitude. Its perturbations decay in one direction only, by the
 * factor r^2 at each impact without speed: by so much the multiplier jumps, and the cycle neither folds nor
 * flips. */
static void a_planar_cycle_keeps_stable_through_grazing(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {mu: 0.5}\n"
                               "  motion: {x: mu*(1 - x^2)*x' - x}\n"
                               "stop: {coordinate: x, d: 2.2, r: 0.8, sides: both}\n"
                               "initial: {x: 1}\n";
    static const char *const sides[] = {"sides=lower", "sides=upper", "sides=both"};
    static const char *const places[] = {"d=2.2", "d=2.05"};
    for (int k = 0; k < 6; k++) {
        const int impacts = k % 3 == 2 ? 2 : 1;
        saltus_scene scene = scene_from(text, (const char *const[]){sides[k % 3], places[k / 3]}, 2);
        saltus_branch_options options = branch_along("d", 1.95, 2.3);
        options.direction = -1;
        double before = NAN, after = NAN, reach;
        branch_record record = branch_of(&scene, options, &reach);
        assert_int_equal(count_special(&record), 1);
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            if (p->kind == SALTUS_POINT_GR) {
                check_near(p->value[0], reach, p->accuracy + 1e-11);
                assert_true(p->accuracy < 1e-10);
                check_planar_touch(p);
            } else if (p->impacts == 0) {
                before = p->multipliers[0].re;
            } else if (isnan(after)) {
                assert_int_equal(p->impacts, impacts);
                after = p->multipliers[0].re;
            }
        }
        check_near(after / before, pow(0.8, 2 * impacts), 0.01);
        check_near(record.point[record.count - 1].value[0], 1.95, 0);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* The impact of a planar cycle, being along the flow, does not make a stable one fold or flip where it
 * grazes: a mass on a belt, whose friction falls with the speed, over a stop. */
static void curves_of_grazing_planar_cycles_are_plain(void **unused) {
    (void)unused;
    static const char text[] =
        "model:\n"
        "  parameters: {zeta: 0.05, v0: 0.95, mus: 0.4, vs: 0.5}\n"
        "  motion: {x: -2*zeta*x' - x + mus*tanh(50*(v0 - x'))*exp(-sqrt((v0-x')^2+0.01)/vs)}\n"
        "stop: {coordinate: x, d: 0.19, r: 0.7}\n"
        "initial: {x: 0.1}\n";
    saltus_scene scene = scene_from(text, NULL, 0);
    saltus_branch_options options = branch_along("v0", 0.9, 1.1);
    snprintf(options.key[1], sizeof options.key[1], "d");
    options.low[1] = 0.1;
    options.high[1] = 0.2;
    options.locus = SALTUS_POINT_GR;
    options.switches = 1;
    branch_record record = branch_of(&scene, options, NULL);
    int ends = 0;
    for (int j = 0; j < record.count; j++) {
        const saltus_branch_point *p = &record.point[j];
        assert_int_equal(p->locus, SALTUS_POINT_GR);
        ends += p->kind == SALTUS_POINT_EP;
        assert_true(p->kind == SALTUS_POINT_GR || p->kind == SALTUS_POINT_EP);
    }
    assert_int_equal(ends, 2);
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

/* The multiplier of the cycle below without impacts, by the classical Runge-Kutta method: the exponential of
 * what the divergence adds up to in a period, from its highest point. */
static double planar_multiplier(double v0, double top, double period) {
    enum { steps = 4000 };
    const double h = period / steps, share[] = {1, 2, 2, 1}, place[] = {0, 0.5, 0.5, 1};
    double y[3] = {top, 0, 0};
    for (int k = 0; k < steps; k++) {
        double slope[3] = {0}, sum[3] = {0};
        for (int j = 0; j < 4; j++) {
            const double x = y[0] + place[j] * h * slope[0], v = y[1] + place[j] * h * slope[1];
            slope[0] = v;
            slope[1] = -x + (v0 - 1) * v + 0.5 * v * v * v - 0.06 * pow(v, 5);
            slope[2] = v0 - 1 + 1.5 * v * v - 0.3 * pow(v, 4);
            for (int i = 0; i < 3; i++)
                sum[i] += share[j] * h / 6 * slope[i];
        }
        for (int i = 0; i < 3; i++)
            y[i] += sum[i];
    }
    return exp(y[2]);
}

/* A mass on a belt whose cycles fold. A curve of grazing passes the fold of those without impact, and where
 * each impact without speed, by the factor r^2, makes a multiplier 1: there folds of cycles with it begin. */
static void curves_of_grazing_planar_cycles_meet_folds(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char text[] = "model:\n"
                               "  parameters: {v0: 0.2}\n"
                               "  motion: {x: -x - (1 - v0)*x' + 0.5*x'^3 - 0.06*x'^5}\n"
                               "stop: {coordinate: x, d: 2.4, r: 0.985, sides: upper}\n"
                               "initial: {x': 2.2}\n";
    for (int both = 0; both < 2; both++) {
        saltus_scene scene =
            scene_from(text, (const char *const[]){both ? "sides=both" : "sides=upper", "d=2.8"}, 2);
        saltus_branch_options options = branch_along("v0", 0.05, 0.3);
        snprintf(options.key[1], sizeof options.key[1], "d");
        options.low[1] = 2.2;
        options.high[1] = 2.85;
        options.locus = SALTUS_POINT_GR;
        options.switches = 1;
        branch_record record = branch_of(&scene, options, NULL);
        int met = 0, folds = 0;
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            folds += p->kind == SALTUS_POINT_LP && p->impacts == 1;
            /* Not those with the impact, by chance. */
            if (p->kind == SALTUS_POINT_GR)
                check_near(p->multipliers[0].re, planar_multiplier(p->value[0], p->value[1], p->period),
                           2e-3);
            if (p->kind != SALTUS_POINT_GR_LP)
                continue;
            assert_true(p->accuracy < 1e-9);
            const double with = met ? pow(0.985, both ? 4 : 2) : 1;
            check_near(with * planar_multiplier(p->value[0], p->value[1], p->period), 1, 1e-9);
            met++;
        }
        assert_int_equal(met, 2);
        assert_true(both || folds > 5);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* A cycle between two stops meets both at once and goes on with both impacts, in steps of any length. */
static void symmetric_cycles_pass_grazing(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {mu: 0.1}\n"
                               "  motion: {x: mu*x' - x^2*x' - x}\n"
                               "stop: {coordinate: x, d: 0.8, r: 0.7, sides: both}\n"
                               "initial: {x: 0.1}\n";
    static const double steps[][2] = {{0.005, 0.02}, {0.05, 0.2}, {0.1, 0.3}};
    for (size_t k = 0; k < sizeof steps / sizeof steps[0]; k++) {
        saltus_scene scene = scene_from(text, NULL, 0);
        saltus_branch_options options = branch_along("mu", 0.05, 0.5);
        options.direction = 1;
        options.step = steps[k][0];
        options.step_max = steps[k][1];
        branch_record record = branch_of(&scene, options, NULL);
        assert_int_equal(count_special(&record), 1);
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            if (p->kind != SALTUS_POINT_GR)
                continue;
            /* Its highest point, the state, is at the stop. */
            check_near(p->state[0], 0.8, 1e-9);
            assert_string_equal(p->label, "0/1");
            assert_string_equal(p->label_after, "2/1");
        }
        check_near(record.point[record.count - 1].value[0], 0.5, 0);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* From the other side: the impacts of van der Pol's cycle at one stop or two lose their speed at once, for
 * steps of any length, where the cycle without them reaches the stops. The branch goes on with that cycle,
 * and neither folds nor flips, as its one multiplier is neither 1 nor -1. */
static void impacts_of_planar_cycles_die_together(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char text[] = "model:\n"
                               "  parameters: {mu: 1}\n"
                               "  motion: {x: mu*(1 - x^2)*x' - x}\n"
                               "stop: {coordinate: x, d: 2.3, r: 0.8, sides: both}\n"
                               "initial: {x: 0.1}\n";
    static const char *const strengths[] = {"mu=0.4", "mu=2"}, *const losses[] = {"r=0.5", "r=0.8", "r=0.95"};
    static const double step_max[] = {0.02, 0.1, 1};
    static const char *const sides[] = {"sides=both", "sides=upper"};
    for (int k = 0; k < 36; k++) {
        const int impacts = k % 2 ? 1 : 2;
        const char *const settings[] = {strengths[k / 18], losses[k / 6 % 3], sides[k % 2], "d=1.7"};
        saltus_branch_options options = branch_along("d", 1.6, 2.3);
        double reach;
        saltus_scene free = scene_from(text, settings, 3), scene = scene_from(text, settings, 4);
        options.direction = 1;
        branch_record record = branch_of(&free, options, &reach);
        branch_forget(&record);
        options.step_max = step_max[k / 2 % 3];
        record = branch_of(&scene, options, NULL);
        assert_int_equal(count_special(&record), 1);
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            if (p->kind == SALTUS_POINT_GR) {
                check_near(p->value[0], reach, p->accuracy + 1e-11);
                assert_true(p->accuracy < 1e-10);
                assert_string_equal(p->label_after, "0/1");
            } else {
                assert_int_equal(p->impacts, p->value[0] < reach ? impacts : 0);
            }
        }
        check_near(record.point[record.count - 1].value[0], 2.3, 0);
        branch_forget(&record);
        saltus_scene_clear(&free);
        saltus_scene_clear(&scene);
    }
}

/* The determinants vanish where the impact dies: all the same the cycle neither flips there, whatever the
 * steps, nor turns back. The other way it shrinks to the equilibrium, on the stop where that is at exactly 0.
 */
static void a_planar_cycle_dies_and_shrinks(void **unused) {
    (void)unused;
    static const char text[] =
        "model:\n"
        "  parameters: {U: 1.89899}\n"
        "  motion: {x: (0.154182*U - 0.0700834)*x' - x - 0.590972*x'^3/U - 0.28486*x^3}\n"
        "stop: {coordinate: x, d: 0.634871, r: 0.45945, sides: upper}\n"
        "initial: {x: 0.1}\n";
    for (int k = 0; k < 6; k++) {
        const bool shrinks = k > 2;
        saltus_scene scene = scene_from(text, NULL, 0);
        saltus_branch_options options = branch_along("d", shrinks ? -0.1 : 0.52880211, 1.2263325);
        options.direction = shrinks ? -1 : 1;
        options.step_max = 0.01 * (1 << k % 3);
        options.step = 0.25 * options.step_max;
        branch_record record = branch_of(&scene, options, NULL);
        assert_int_equal(count_special(&record), 1);
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            if (!branch_special(p))
                continue;
            assert_int_equal(p->kind, shrinks ? SALTUS_POINT_BE : SALTUS_POINT_GR);
            assert_string_equal(p->reason,
                                shrinks ? "the orbit shrinks to an equilibrium on a stop" : "an impact dies");
            if (shrinks)
                check_near(p->value[0], 0, p->accuracy);
        }
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* A cycle whose section points are impacts can be followed: in one turn its first impact is neither counted
 * twice nor missed. */
static void cycles_begin_at_impacts(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {mu: 0.1}\n"
                               "  motion: {x: mu*(1 - x^2)*x' - x}\n"
                               "stop: {coordinate: x, d: 1.7, r: 0.8, sides: both}\n"
                               "initial: {x: 0.1}\n";
    for (int k = 0; k < 40; k++) {
        char strength[32], loss[32];
        snprintf(strength, sizeof strength, "mu=%g", 0.1 + 0.07 * (k / 4));
        snprintf(loss, sizeof loss, "r=%g", 0.6 + 0.1 * (k % 4));
        saltus_scene scene = scene_from(text, (const char *const[]){strength, loss}, 2);
        saltus_branch_options options = branch_along("d", 1.69, 1.71);
        options.direction = 1;
        options.step = options.step_max = 1;
        branch_record record = branch_of(&scene, options, NULL);
        check_near(record.point[record.count - 1].value[0], 1.71, 0);
        assert_string_equal(record.point[0].label, "2/1");
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* On the circle of radius s, u = s cos t and w = s sin t, the displacement x is u + 2 a u w / s, s (cos t +
 * a sin 2t): it has a second maximum where a > 1/2, and u reaches 1 where s > 1. */
static const char circle[] =
    "model:\n"
    "  parameters: {a: 0.4, s: 1.2}\n"
    "  states: {u: u - w - u*(u^2 + w^2)/s^2, w: u + w - w*(u^2 + w^2)/s^2}\n"
    "  motion:\n"
    "    x: -u - 8*a*u*w/s - 2*(x' + w - 2*a*(u^2 - w^2)/s) - 3*(x - u - 2*a*u*w/s)\n"
    "initial: {x: 0.3, u: 0.5}\n";

/* Where the cycle stops or begins to meet its section is located sharply, once, and the branch goes on: from
 * either side, in short steps and long ones. */
static void returns_come_and_go(void **unused) {
    (void)unused;
    static const struct {
        const char *key, *setting, *section;
        double low, high, place, step_max;
        int below, above; /* returns */
    } cases[] = {{"a", "a=0.4", "maxima", 0.3, 0.7, 0.5, 0.02, 1, 2},
                 {"a", "a=0.6", "maxima", 0.3, 0.7, 0.5, 0.02, 1, 2},
                 {"a", "a=0.55", "maxima", 0.3, 0.7, 0.5, 0.5, 1, 2},
                 {"a", "a=0.45", "maxima", 0.3, 0.7, 0.5, 0.5, 1, 2},
                 {"s", "s=1.2", "zero: u - 1", 0.8, 1.5, 1, 0.02, 0, 1},
                 {"s", "s=1.4", "zero: u - 1", 0.8, 1.5, 1, 0.3, 0, 1},
                 {"s", "s=0.9", "maxima", 0.8, 1.5, NAN, 0.1, 1, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_scene scene = scene_from(circle, &cases[k].setting, 1);
        saltus_message message = {.text = ""};
        check_ok(saltus_scene_set_section(&scene, cases[k].section, &message), &message);
        saltus_branch_options options = branch_along(cases[k].key, cases[k].low, cases[k].high);
        options.step_max = cases[k].step_max;
        branch_record record = branch_of(&scene, options, NULL);
        int told = 0;
        double least = INFINITY, most = -INFINITY;
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            least = fmin(least, p->value[0]);
            most = fmax(most, p->value[0]);
            if (p->kind == SALTUS_POINT_REGULAR && p->reason[0]) {
                assert_non_null(strstr(p->reason, "returns to the section"));
                check_near(p->value[0], cases[k].place, 1e-11);
                assert_true(p->accuracy > 0 && p->accuracy < 1e-9);
                told++;
            } else if (cases[k].below) {
                assert_int_equal(p->periods, p->value[0] > cases[k].place ? cases[k].above : cases[k].below);
            }
        }
        assert_int_equal(told, isfinite(cases[k].place));
        assert_true(least == cases[k].low && most == cases[k].high);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* A cycle around x = s with the net negative damping m - 1/2: it is born at the Hopf point m = 1/2, with the
 * period 2 pi, stable if a < 0, otherwise unstable until it folds. The scene's third state follows x and
 * decays like e^-gt. */
static const char normal[] = "model:\n"
                             "  parameters: {m: 0.8, a: -1, g: 1.5}\n"
                             "  motion:\n"
                             "    x: (m - 0.5 + a*x'^2 - 0.7*x'^4)*x' - (x - 2*m) + 0.3*(x - 2*m)^2\n"
                             "       - 0.4*(x - 2*m)^3\n"
                             "  states: {p: (x - 2*m)^2 - g*p}\n"
                             "initial: {x: 1.7}\n";

/* The end of a branch of shrinking cycles is located by the equilibrium's own equation, to rounding, with its
 * multipliers, however long the last steps are. */
static void cycles_end_where_they_are_born(void **unused) {
    (void)unused;
    static const char *const kinds[] = {"a=-1", "a=0.6"};
    static const double step_max[] = {0.03, 0.1, 0.3, 1};
    for (int k = 0; k < 8; k++) {
        saltus_scene scene = scene_from(normal, &kinds[k / 4], 1);
        saltus_branch_options options = branch_along("m", 0.1, 1.3);
        options.direction = -1;
        options.step_max = step_max[k % 4];
        branch_record record = branch_of(&scene, options, NULL);
        const saltus_branch_point *end = &record.point[record.count - 1], *hopf = end - 1;
        assert_int_equal(end->kind, SALTUS_POINT_EP);
        assert_int_equal(hopf->kind, SALTUS_POINT_HB);
        assert_true(hopf->accuracy < 1e-12);
        check_near(hopf->value[0], 0.5, hopf->accuracy);
        check_near(hopf->period, 2 * M_PI, 1e-12);
        check_near(hopf->state[0], 1, 1e-12);
        assert_int_equal(hopf->multiplier_count, 2);
        check_near(hopf->multipliers[0].re, 1, 0);
        check_near(hopf->multipliers[1].re, exp(-1.5 * 2 * M_PI), 1e-15);
        /* On the way all orbits are cycles, with the trivial multiplier 1. */
        for (int j = 0; j < record.count - 2; j++)
            assert_true(record.point[j].trivial_multiplier > 0.999);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* Van der Pol's relaxation oscillation under a constant force passes through a canard explosion near a = 1 -
 * 1/(8 mu^2), where the cycle shrinks from its full size at almost constant parameter: on the way
 * perturbations grow and shrink by 1e10. Beyond is the Hopf point a = 1. */
static void canards_are_passed(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char text[] = "model:\n"
                               "  parameters: {a: 0.5}\n"
                               "  motion: {x: 4*(1 - x^2)*x' - x + a}\n"
                               "initial: {x: 0.1}\n";
    static const double step_max[] = {0.1, 0.5};
    for (int k = 0; k < 2; k++) {
        saltus_scene scene = scene_from(text, NULL, 0);
        saltus_branch_options options = branch_along("a", 0.3, 1.2);
        options.direction = 1;
        options.step_max = step_max[k];
        branch_record record = branch_of(&scene, options, NULL);
        const saltus_branch_point *end = &record.point[record.count - 1];
        double span = 0;
        assert_int_equal(end[-1].kind, SALTUS_POINT_HB);
        assert_int_equal(count_special(&record), 1);
        check_near(end->value[0], 1, 1e-12);
        /* The periods at both ends of the explosion, at one parameter. */
        for (int j = 0; j < record.count; j++)
            for (int i = 0; i < j; i++)
                if (fabs(record.point[j].value[0] - record.point[i].value[0]) < 1e-6)
                    span = fmax(span, fabs(record.point[j].period - record.point[i].period));
        assert_true(span > 5);
        for (int j = 0; j < record.count; j++)
            check_near(record.point[j].trivial_multiplier, 1, 1e-6);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* FitzHugh and Nagumo's equations as one of second order. Their cycles are born unstable, fold within a
 * canard explosion, and go on as the stable relaxation oscillation. From there, with any largest step, the
 * fold is the same, and the final Hopf point is that of the equilibrium. */
static void folds_within_a_canard_are_found(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char text[] = "model:\n"
                               "  parameters: {I: 0.5, a: 0.7, b: 0.8, eps: 0.08}\n"
                               "  motion:\n"
                               "    v: v'*(1 - v^2) - eps*(v + a - b*(v - v^3/3 + I - v'))\n"
                               "initial: {v: 0.1}\n";
    static const double step_max[] = {0.1, 0.3, 1};
    /* The trace at the equilibrium v: 1 - v^2 = eps b; I follows from v. */
    const double v = -sqrt(1 - 0.08 * 0.8), hopf = (v + 0.7) / 0.8 - v + v * v * v / 3;
    double fold = NAN;
    for (int k = 0; k < 3; k++) {
        saltus_scene scene = scene_from(text, NULL, 0);
        saltus_branch_options options = branch_along("I", 0.3, 0.5);
        options.direction = -1;
        options.points = 20000;
        options.step_max = step_max[k];
        branch_record record = branch_of(&scene, options, NULL);
        const saltus_branch_point *end = &record.point[record.count - 1];
        const saltus_branch_point *found = NULL;
        assert_int_equal(count_special(&record), 2);
        for (int j = 0; j < record.count; j++)
            if (record.point[j].kind == SALTUS_POINT_LP)
                found = &record.point[j];
        assert_non_null(found);
        assert_int_equal(end[-1].kind, SALTUS_POINT_HB);
        check_near(end[-1].value[0], hopf, 1e-12);
        check_near(found->value[0], k == 0 ? found->value[0] : fold, 1e-11);
        fold = found->value[0];
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* A mass on a spring with negative damping, pressed by F against a stop at 1/2; the same with another state
 * and a nonlinear spring. */
static const char pressed[] = "model:\n"
                              "  parameters: {F: 1, z: 0.05}\n"
                              "  motion: {x: 2*z*x' - x + F}\n"
                              "stop: {coordinate: x, d: 0.5, r: 0.6, sides: upper}\n"
                              "initial: {x: 0.5}\n";
static const char delayed[] = "model:\n"
                              "  parameters: {F: 1, z: 0.1}\n"
                              "  states: {w: x - 2*w}\n"
                              "  motion: {x: 2*z*x' - x + F + 0.3*w - 0.2*x^2}\n"
                              "stop: {coordinate: x, d: 0.5, r: 0.6, sides: upper}\n"
                              "initial: {x: 0.5}\n";

/* The branches of equilibria from F = 1 down, with the cycles that begin there. */
static branch_record rests_of(const char *text, const char *setting, double low) {
    saltus_message message = {.text = ""};
    saltus_scene scene = scene_from(text, &setting, 1);
    saltus_system *system = build(&scene.spec);
    double state[SALTUS_STATE_MAX];
    saltus_branch_options options = branch_along("F", low, 1);
    options.switches = 1;
    check_ok(saltus_scene_state(&scene, system, state, &message), &message);
    branch_record record = branch_run(&scene.spec, 0, state, &options);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
    return record;
}

static const saltus_branch_point *boundary_of(const branch_record *record) {
    for (int k = 0; k < record->count; k++)
        if (record->point[k].kind == SALTUS_POINT_BE)
            return &record->point[k];
    fail_msg("no equilibrium meets the stop");
    return NULL;
}

/* Measured from the equilibrium at F, with the stop D = 1/2 - F away, the mass leaves the stop with -r v and
 * is back with v after a time T, in closed form. Impacts balance the negative damping; so cycles exist on one
 * or the other side of F = 1/2, as r e^(pi z / w) is less than 1 or more, and none without it. Their area
 * changes by r^2 e^(2 z T) in a period. */
static void cycles_are_born_at_a_stop(void **unused) {
    (void)unused;
    static const struct {
        const char *setting;
        double z, r;
        int side; /* of F = 1/2; 0: no cycle */
    } cases[] = {
        {"z=0.05", 0.05, 0.6, -1}, {"z=0.2", 0.2, 0.6, 1}, {"z=-0.05", -0.05, 0.6, 0}, {"r=0", 0.05, 0, -1}};
    const size_t all = sizeof cases / sizeof cases[0], count = getenv("SALTUS_SANITIZED") ? 1 : all;
    for (size_t k = 0; k < count; k++) {
        const double z = cases[k].z, r = cases[k].r, w = sqrt(1 - z * z);
        branch_record record = rests_of(pressed, cases[k].setting, -1);
        int cycles = 0;
        check_near(boundary_of(&record)->value[0], 0.5, 1e-12);
        assert_int_equal(strstr(boundary_of(&record)->reason, "a cycle with one impact") != NULL,
                         cases[k].side != 0);
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            if (p->periods == 0)
                continue;
            const double D = 0.5 - p->value[0], T = p->period, v = p->events[0].velocity_before;
            const double c = cos(w * T), s = sin(w * T) / w, grown = exp(z * T);
            assert_true(p->impacts == 1 && p->event_count == 1 && D * cases[k].side < 0);
            check_near(grown * (D * c + (-r * v - z * D) * s) / D, 1, 1e-9);
            check_near(grown * (-r * v * c + (-r * z * v - D) * s) / v, 1, 1e-9);
            check_near(p->multipliers[0].re, r * r * grown * grown, 1e-9);
            cycles++;
        }
        assert_int_equal(cycles > 10, cases[k].side != 0);
        branch_forget(&record);
    }
}

/* From the other end the branch of cycles reaches the same place and ends there. */
static void cycles_shrink_to_an_equilibrium_on_a_stop(void **unused) {
    (void)unused;
    static const char *const texts[] = {pressed, delayed};
    static const char *const settings[] = {"z=0.05", "z=0.1"};
    for (int k = 0; k < 2; k++) {
        branch_record rests = rests_of(texts[k], settings[k], 0.3);
        const double place = boundary_of(&rests)->value[0];
        for (int far = 0; far < 2; far++) {
            saltus_scene scene =
                scene_from(texts[k], (const char *const[]){settings[k], far ? "F=0.1" : "F=0.4"}, 2);
            saltus_branch_options options = branch_along("F", 0, 1);
            options.direction = 1;
            branch_record record = branch_of(&scene, options, NULL);
            const saltus_branch_point *meets = boundary_of(&record);
            check_near(meets->value[0], place, 1e-10);
            assert_true(meets->accuracy < 1e-8);
            assert_int_equal(record.point[record.count - 1].kind, SALTUS_POINT_EP);
            assert_ptr_equal(meets, &record.point[record.count - 2]);
            /* The same cycle is born there on the branch of equilibria. */
            for (int j = 0; j < rests.count; j++)
                if (rests.point[j].periods) {
                    check_near(rests.point[j].period, meets->period, 1e-2);
                    break;
                }
            branch_forget(&record);
            saltus_scene_clear(&scene);
        }
        branch_forget(&rests);
    }
}

/* A mass with negative damping and a lagging state; the same coupled to a second mass that is always pressed
 * against its own stop and has no effect on the first. */
static const char lagging[] = "model:\n"
                              "  parameters: {F: 1, z: 0.05, c: -1.2, b: 0.18}\n"
                              "  states: {w: x - b*w}\n"
                              "  motion: {x: 2*z*x' - x + F + c*w}\n"
                              "stop: {coordinate: x, d: 0.5, r: 0.6, sides: upper}\n"
                              "initial: {x: 0.5}\n";
static const char lagging_beside[] =
    "model:\n"
    "  parameters: {F: 1, z: 0.05, c: -1.2, b: 0.18}\n"
    "  states: {w: x - b*w}\n"
    "  motion: {x: 2*z*x' - x + F + c*w + 0.3*(y - 1), y: 9 - y - 0.2*y' + 0.3*x}\n"
    "stops: [{coordinate: x, d: 0.5, r: 0.6, sides: upper}, {coordinate: y, d: 1, r: 0.6, sides: upper}]\n"
    "initial: {x: 0.5, y: 1}\n";

typedef struct several {
    const char *text;
    double z, c, b, r;
    int impacts; /* of the stable cycle born there; -1: complete chatter */
} several;

static const several born_with_several[] = {
    {lagging, 0.004, -1.231, 0.178, 0.42, 2},  {lagging, 0.197, -1.243, 0.126, 0.364, 2},
    {lagging, 0.38, -1.883, 0.115, 0.574, -1}, {lagging_beside, 0.004, -1.231, 0.178, 0.42, 2},
    {lagging, -0.8, -0.2, 1.5, 0.42, 0},
};

/* The F at which the equilibrium touches the stop. */
static double place_of(const several *s) {
    return 0.5 * (1 - s->c / s->b);
}

static saltus_scene scene_of_several(const several *s, double F) {
    char settings[5][32];
    const char *each[5];
    const double value[] = {s->z, s->c, s->b, s->r, F};
    static const char *const key[] = {"z", "c", "b", "r", "F"};
    const bool beside = s->text == lagging_beside;
    for (int k = 0; k < 5; k++) {
        snprintf(settings[k], sizeof settings[k], "%s%s=%.17g", key[k], beside && k == 3 ? "1" : "",
                 value[k]);
        each[k] = settings[k];
    }
    return scene_from(s->text, each, 5);
}

/* The free flow of the mass and the lagging state, by its power series. */
static void coast(const several *s, double F, double time, double *y) {
    const int parts = 64;
    for (int part = 0; part < parts; part++) {
        double term[3] = {y[0], y[1], y[2]};
        for (int k = 1; k < 20; k++) {
            const double next[3] = {term[1], 2 * s->z * term[1] - term[0] + s->c * term[2] + (k == 1 ? F : 0),
                                    term[0] - s->b * term[2]};
            for (int i = 0; i < 3; i++)
                y[i] += term[i] = next[i] * time / parts / k;
        }
    }
}

/* From each impact the flow leads to the next and does not meet the stop between. */
static void check_flights(const several *s, const saltus_branch_point *p) {
    enum { looks = 50 };
    const int n = p->dimension, beside = s->text == lagging_beside;
    double y[3] = {p->state[0], p->state[beside ? 2 : 1], p->state[n - 1]};
    for (int k = 0; k < p->event_count; k++) {
        const saltus_event *event = &p->events[k], *next = &p->events[(k + 1) % p->event_count];
        const double end = k + 1 < p->event_count ? saltus_time_periods(next->time) : 1;
        const double flight = p->period * (end - saltus_time_periods(event->time));
        check_near(y[0], 0.5, 1e-11);
        check_near(y[1], -s->r * event->velocity_before, 1e-11);
        for (int look = 1; look <= looks; look++) {
            coast(s, p->value[0], flight / looks, y);
            assert_true(look == looks || y[0] < 0.5);
        }
        check_near(y[1], next->velocity_before, 1e-10);
        y[1] *= -s->r;
    }
    check_near(y[2], p->state[n - 1], 1e-10);
}

/* These equations are linear, so cycles born on a stop grow in proportion to the distance from there, with
 * the same times and proportional impact speeds. */
static void cycles_of_several_impacts_are_born_at_a_stop(void **unused) {
    (void)unused;
    for (size_t k = 0; k < sizeof born_with_several / sizeof born_with_several[0]; k++) {
        const several *s = &born_with_several[k];
        const double place = place_of(s);
        saltus_message message = {.text = ""};
        saltus_scene scene = scene_of_several(s, place + 1);
        saltus_system *system = build(&scene.spec);
        saltus_branch_options options = branch_along("F", place - 1, place + 1);
        double state[SALTUS_STATE_MAX], period = NAN, speed = NAN;
        int count = 0;
        check_ok(saltus_scene_state(&scene, system, state, &message), &message);
        options.direction = -1;
        options.switches = 1;
        branch_record record = branch_run(&scene.spec, 0, state, &options);
        check_near(boundary_of(&record)->value[0], place, 1e-11);
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            if (p->periods == 0 || p->impacts != s->impacts)
                continue;
            double fastest = 0;
            for (int e = 0; e < p->event_count; e++)
                fastest = fmax(fastest, p->events[e].velocity_before);
            fastest /= place - p->value[0];
            check_near(p->period, isnan(period) ? p->period : period, 1e-8);
            check_near(fastest, isnan(speed) ? fastest : speed, 1e-7);
            period = p->period;
            speed = fastest;
            assert_true(p->stable && p->value[0] < place);
            if (s->impacts > 0)
                check_flights(s, p);
            count++;
        }
        const char *told = s->impacts < 0 ? "with chatter" : s->impacts ? "with 2 impacts" : "cycle";
        assert_int_equal(count > 10, s->impacts != 0);
        assert_int_equal(strstr(boundary_of(&record)->reason, told) != NULL, s->impacts != 0);
        /* From the other end the cycle shrinks to the same place. */
        for (int j = record.count - 1; j >= 0 && s->impacts; j--) {
            const saltus_branch_point *p = &record.point[j];
            if (p->impacts != s->impacts || p->periods == 0)
                continue;
            saltus_spec spec = p->spec;
            saltus_spec_set_omega(&spec, 2 * M_PI / p->period);
            options.direction = 1;
            options.orbit.free_period = true;
            branch_record back = branch_run(&spec, p->periods, p->state, &options);
            check_near(boundary_of(&back)->value[0], place, 1e-9);
            check_near(boundary_of(&back)->period, period, 1e-6);
            assert_ptr_equal(boundary_of(&back), &back.point[back.count - 2]);
            branch_forget(&back);
            break;
        }
        branch_forget(&record);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* On the unit circle of (u, v) the angle moves with the rate m - sin - e cos, and takes the time 2 pi /
 * sqrt(m^2 - 1 - e^2) around it, until two equilibria are born there. The mass only follows, and may hit the
 * stop. */
static void cycles_end_where_equilibria_are_born_on_them(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {m: 2, e: 0}\n"
                               "  let: {turn: m - v - e*u, pull: 1 - u^2 - v^2}\n"
                               "  states: {u: u*pull - v*turn, v: v*pull + u*turn}\n"
                               "  motion: {x: 2*u - x - x'}\n"
                               "stop: {coordinate: x, d: 9, r: 0.4, sides: upper}\n"
                               "initial: {u: 1, x: 0.1}\n";
    static const char *const settings[][2] = {{"e=0", "d=9"}, {"e=0.7", "d=9"}, {"e=-0.4", "d=0.5"}};
    for (int k = 0; k < 3; k++) {
        const double e = atof(settings[k][0] + 2), place = sqrt(1 + e * e);
        saltus_scene scene = scene_from(text, settings[k], 2);
        saltus_branch_options options = branch_along("m", 0, 16);
        options.direction = -1;
        branch_record record = branch_of(&scene, options, NULL);
        const saltus_branch_point *last = &record.point[record.count - 1];
        double told;
        for (int j = 0; j < record.count; j++) {
            const double m = record.point[j].value[0];
            check_near(record.point[j].period * sqrt(m * m - 1 - e * e), 2 * M_PI, 1e-7);
        }
        assert_true((last->impacts > 0) == (k == 2));
        assert_int_equal(sscanf(last->reason, "two equilibria are born on the orbit at m = %lf", &told), 1);
        check_near(told, place, 1e-11);
        check_near(last->value[0], place, 16e-3);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* A cycle that was found by its returns joins those of half its period at their flip; both ways along these
 * it is what it is. */
static void cycles_join_at_flips(void **unused) {
    (void)unused;
    static const char *const settings[2][3] = {{"q=5.66192", "r=0.818635", "kappa=1.3"},
                                               {"q=5.66192", "r=0.818635", "kappa=1.26"}};
    branch_record record[2];
    const saltus_branch_point *flip[2] = {NULL, NULL};
    int ends = 0;
    for (int k = 0; k < 2; k++) {
        saltus_scene scene;
        saltus_message message = {.text = ""};
        check_ok(saltus_scene_load("relief-valve", &scene, &message), &message);
        for (int j = 0; j < 3; j++)
            check_ok(saltus_scene_set(&scene, settings[k][j], &message), &message);
        saltus_branch_options options = branch_along("kappa", 1.25, 1.32);
        options.switches = 2 * (1 - k);
        record[k] = branch_of(&scene, options, NULL);
        for (int j = 0; j < record[k].count; j++) {
            const saltus_branch_point *p = &record[k].point[j];
            assert_true(p->kind != SALTUS_POINT_LP && p->kind != SALTUS_POINT_BP);
            ends += k == 0 && p->kind == SALTUS_POINT_EP && strcmp(p->label, "1/1") == 0;
            if (p->kind != SALTUS_POINT_PD)
                continue;
            assert_null(flip[k]);
            flip[k] = p;
        }
        assert_true(flip[k] && strcmp(flip[k]->label, k ? "1/1" : "2/2") == 0);
        saltus_scene_clear(&scene);
    }
    assert_int_equal(ends, 2);
    check_near(flip[0]->value[0], flip[1]->value[0], flip[0]->accuracy + flip[1]->accuracy);
    branch_forget(&record[0]);
    branch_forget(&record[1]);
}

/* A cycle that comes from a flip has won a return since, so that their number is odd: it joins those of half
 * its period all the same, and is not followed back from there. */
static void cycles_with_an_odd_number_of_returns_join_at_flips(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {lam: 0.9, c: 0.05}\n"
                               "  motion:\n"
                               "    h: -c*h' - h - lam*al - h^3\n"
                               "    al: -c*al' - 2*al + lam*h\n"
                               "stop: {coordinate: h, d: 2, r: 0.7}\n"
                               "initial: {h: 0.1}\n";
    saltus_scene scene = scene_from(text, NULL, 0);
    saltus_branch_options options = branch_along("d", 1.72, 2);
    options.direction = -1;
    options.switches = 1;
    branch_record record = branch_of(&scene, options, NULL);
    assert_string_equal(record.point[0].label, "2/3");
    double flip = NAN;
    for (int j = 0; j < record.count; j++) {
        const saltus_branch_point *p = &record.point[j];
        assert_int_not_equal(p->kind, SALTUS_POINT_BP);
        assert_true(p->branch == 0 || p->impacts < 2);
        if (p->kind == SALTUS_POINT_PD) {
            assert_int_equal(p->branch, 0);
            assert_true(isnan(flip));
            flip = p->value[0];
        } else if (p->branch > 0 && isfinite(p->multipliers[0].re) && p->value[0] == flip) {
            check_near(p->multipliers[0].re, -1, 1e-8);
        }
    }
    check_near(flip, 1.7452718251906, 1e-11);
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grazing_is_met_from_everywhere),
        cmocka_unit_test(labels_on_a_curve_of_grazing_say_what_is_counted),
        cmocka_unit_test(a_planar_cycle_keeps_stable_through_grazing),
        cmocka_unit_test(curves_of_grazing_planar_cycles_are_plain),
        cmocka_unit_test(curves_of_grazing_planar_cycles_meet_folds),
        cmocka_unit_test(symmetric_cycles_pass_grazing),
        cmocka_unit_test(impacts_of_planar_cycles_die_together),
        cmocka_unit_test(a_planar_cycle_dies_and_shrinks),
        cmocka_unit_test(cycles_begin_at_impacts),
        cmocka_unit_test(returns_come_and_go),
        cmocka_unit_test(cycles_end_where_they_are_born),
        cmocka_unit_test(canards_are_passed),
        cmocka_unit_test(folds_within_a_canard_are_found),
        cmocka_unit_test(cycles_are_born_at_a_stop),
        cmocka_unit_test(cycles_shrink_to_an_equilibrium_on_a_stop),
        cmocka_unit_test(cycles_of_several_impacts_are_born_at_a_stop),
        cmocka_unit_test(cycles_end_where_equilibria_are_born_on_them),
        cmocka_unit_test(cycles_join_at_flips),
        cmocka_unit_test(cycles_with_an_odd_number_of_returns_join_at_flips),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
