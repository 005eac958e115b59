/* Branches of equilibria of unforced scenes: folds, branch points, Hopf points and contacts with stops as in
 * closed forms and independent programs; cycles that leave, loci in two parameters, files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "json.h"

#include "command.h"

#include "saltus/scene.h"

/* A scene with one equation of motion and parameters; the caller clears it. */
static saltus_scene scene_of(const char *parameters, const char *motion, const char *rest) {
    char text[800];
    saltus_scene scene;
    saltus_message message = {.text = ""};
    int length = snprintf(text, sizeof text, "model:\n  parameters: {%s}\n  motion: {x: %s}\n%s", parameters,
                          motion, rest);
    check_ok(saltus_scene_parse(text, (size_t)length, "test", &scene, &message), &message);
    return scene;
}

static saltus_scene built_in(const char *name, const char *setting) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load(name, &scene, &message), &message);
    check_ok(saltus_scene_set(&scene, setting, &message), &message);
    return scene;
}

/* The branches through the equilibrium near the scene's initial state; clears the scene. */
static branch_record follow(saltus_scene *scene, const saltus_branch_options *options) {
    saltus_message message = {.text = ""};
    saltus_system *system = build(&scene->spec);
    double state[SALTUS_STATE_MAX];
    check_ok(saltus_scene_state(scene, system, state, &message), &message);
    branch_record record = branch_run(&scene->spec, 0, state, options);
    saltus_system_free(system);
    return record;
}

/* Each equilibrium of a branch is the one that Newton's method finds there, with its eigenvalues, which add
 * up to the trace. */
static void check_rests(const branch_record *record) {
    saltus_message message = {.text = ""};
    saltus_equilibrium_options how = saltus_equilibrium_defaults();
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *p = &record->point[k];
        bool singular = p->kind == SALTUS_POINT_LP || p->kind == SALTUS_POINT_BP ||
                        p->kind == SALTUS_POINT_BE || p->locus || fabs(p->heading) < 1e-3;
        saltus_equilibrium rest = {0};
        double sum = 0;
        for (int i = 0; i < p->multiplier_count; i++)
            singular = singular || hypot(p->multipliers[i].re, p->multipliers[i].im) < 1e-6;
        if (p->periods || singular)
            continue;
        saltus_system *system = build(&p->spec);
        check_ok(saltus_equilibrium_find(system, p->state, &how, &rest, &message), &message);
        check_near(saltus_system_distance(system, rest.state, p->state), 0, 1e-10);
        assert_int_equal(rest.eigenvalue_count, p->multiplier_count);
        for (int i = 0; i < p->multiplier_count; i++) {
            check_near(p->multipliers[i].re, rest.eigenvalues[i].re, 1e-8);
            check_near(fabs(p->multipliers[i].im), fabs(rest.eigenvalues[i].im), 1e-8);
            sum += p->multipliers[i].re;
        }
        check_near(p->log_volume, sum, 1e-12 * fmax(1, fabs(sum)));
        if (!isnan(p->sum_rule))
            check_near(p->log_volume, p->sum_rule, 1e-10 * fmax(1, fabs(sum)));
        assert_string_equal(p->label, rest.contacts ? "held" : "equilibrium");
        if (p->kind != SALTUS_POINT_HB)
            assert_int_equal(p->stable, rest.stable);
        if (rest.contacts)
            check_near(p->contact_force, rest.contact_force[0], 1e-10);
        saltus_equilibrium_clear(&rest);
        saltus_system_free(system);
    }
}

static const saltus_branch_point *special(const branch_record *record, saltus_point_kind kind, int number) {
    for (int k = 0; k < record->count; k++)
        if (record->point[k].kind == kind && --number == 0)
            return &record->point[k];
    fail_msg("there is no such %s", saltus_point_word(kind));
    return NULL;
}

static int count_of(const branch_record *record, saltus_point_kind kind) {
    int count = 0;
    for (int k = 0; k < record->count; k++)
        count += record->point[k].kind == kind;
    return count;
}

/* x = +-sqrt(mu): a fold at 0, the upper half stable. */
static void a_fold_is_where_two_equilibria_meet(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("mu: {default: 1}", "mu - x^2 - x'", "initial: {x: 0.5}\n");
    saltus_branch_options options = branch_along("mu", -0.5, 1);
    options.direction = -1;
    branch_record record = follow(&scene, &options);
    check_rests(&record);
    assert_int_equal(count_of(&record, SALTUS_POINT_LP), 1);
    const saltus_branch_point *fold = special(&record, SALTUS_POINT_LP, 1);
    check_near(fold->value[0], 0, 1e-13);
    check_near(fold->state[0], 0, 1e-9);
    assert_true(fold->accuracy < 1e-10);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        check_near(p->state[0] * p->state[0], p->value[0], 1e-12);
        if (p->kind == SALTUS_POINT_REGULAR)
            assert_int_equal(p->stable, p->state[0] > 0);
    }
    check_near(record.point[record.count - 1].state[0], -1, 1e-12);
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

/* x = 0 and x = +-sqrt(mu), and the transcritical crossing of x = 0 and x = mu. */
static void branches_leave_at_branch_points(void **unused) {
    (void)unused;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        saltus_scene scene =
            scene_of("mu: {default: -1}", mirrored ? "mu*x - x^3 - x'" : "mu*x - x^2 - x'", "");
        saltus_branch_options options = branch_along("mu", -1, 1);
        options.direction = 1;
        options.switches = 1;
        branch_record record = follow(&scene, &options);
        check_rests(&record);
        const saltus_branch_point *fork = special(&record, SALTUS_POINT_BP, 1);
        check_near(fork->value[0], 0, fork->accuracy);
        assert_true(fork->accuracy < 1e-13);
        int switched = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            double x = p->state[0], mu = p->value[0];
            if (p->branch == 0) {
                check_near(x, 0, 1e-12);
                continue;
            }
            assert_int_equal(p->parent, 0);
            check_near(mirrored ? x * x : x, mu, 1e-10);
            switched += fabs(x) > 0.1;
        }
        assert_true(switched > 20);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* The cycles of a linear oscillator are born on neither side; rounding of its terms decides nothing. */
static void hopf_points_of_linear_motion_are_not_decided(void **unused) {
    (void)unused;
    static const char *const motions[] = {"mu*x' - x", "mu*x' - 1.7*x + 0.3", "mu*x' - x/3",
                                          "mu*x' - 17*x - 1"};
    for (size_t k = 0; k < sizeof motions / sizeof motions[0]; k++) {
        saltus_scene scene = scene_of("mu: {default: -0.3}", motions[k], "");
        saltus_branch_options options = branch_along("mu", -0.3, 0.5);
        options.direction = 1;
        branch_record record = follow(&scene, &options);
        assert_non_null(strstr(special(&record, SALTUS_POINT_HB, 1)->reason, "criticality not decided"));
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* x'' = mu x' - w^2 x + a x^2 + b x x' + s x^2 x' at mu = 0: by averaging (Guckenheimer & Holmes, 3.4.11) the
 * amplitude of x has r' = mu r / 2 + (s + a b / w^2) r^3 / 8, and with an eigenvector (1, i w) of unit length
 * the first Lyapunov coefficient is (s + a b / w^2) / (2 w (1 + w^2)). */
static void hopf_points_have_the_coefficient_of_the_normal_form(void **unused) {
    (void)unused;
    static const double cases[][4] = {{1, 0, 0, -1},     {1, 0, 0, 1},          {2, 0, 0, -0.5},
                                      {1, 0.5, 0.4, -1}, {1.5, -0.7, 0.9, 0.2}, {0.5, 0.3, 0.2, -1}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const double w = cases[k][0], a = cases[k][1], b = cases[k][2], s = cases[k][3];
        char motion[200];
        snprintf(motion, sizeof motion, "mu*x' - %g*x + %g*x^2 + %g*x*x' + %g*x^2*x'", w * w, a, b, s);
        saltus_scene scene = scene_of("mu: {default: -0.2}", motion, "");
        saltus_branch_options options = branch_along("mu", -0.2, 0.2);
        options.direction = 1;
        options.switches = 1;
        options.points = 60;
        branch_record record = follow(&scene, &options);
        check_rests(&record);
        const saltus_branch_point *hopf = special(&record, SALTUS_POINT_HB, 1);
        const double cubic = s + a * b / (w * w);
        check_near(hopf->value[0], 0, 1e-12);
        check_near(2 * M_PI / hopf->period, w, 1e-12);
        check_near(hopf->lyapunov_coefficient, cubic / (2 * w * (1 + w * w)), 1e-10);
        assert_non_null(strstr(hopf->reason, cubic < 0 ? "supercritical" : "subcritical"));
        assert_false(hopf->stable);
        /* The cycles born there have the side, amplitude and stability that the coefficient predicts. */
        int cycles = 0;
        for (int i = 0; i < record.count; i++) {
            const saltus_branch_point *p = &record.point[i];
            if (p->branch != 1 || p->kind != SALTUS_POINT_REGULAR)
                continue;
            assert_int_equal(p->parent, 0);
            assert_int_equal(p->stable, cubic < 0);
            const double mu = -cubic * p->state[0] * p->state[0] / 4;
            if (++cycles == 1) {
                check_near(p->value[0], mu, 0.05 * fabs(mu));
                check_near(p->period, hopf->period, 1e-3);
            }
        }
        assert_true(cycles > 20);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* Two oscillators that begin to flutter within one step. */
static void hopf_points_close_together_are_told_apart(void **unused) {
    (void)unused;
    static const char text[] = "model:\n  parameters: {mu: {default: -0.5}}\n  motion:\n"
                               "    x: mu*x' - x^2*x' - x\n    y: (mu - 0.0003)*y' - y^2*y' - 2*y\n";
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_parse(text, sizeof text - 1, "test", &scene, &message), &message);
    saltus_branch_options options = branch_along("mu", -0.5, 0.5);
    options.direction = 1;
    branch_record record = follow(&scene, &options);
    check_rests(&record);
    assert_int_equal(count_of(&record, SALTUS_POINT_HB), 2);
    for (int k = 0; k < 2; k++) {
        const saltus_branch_point *hopf = special(&record, SALTUS_POINT_HB, k + 1);
        check_near(hopf->value[0], k ? 0.0003 : 0, 1e-11);
        assert_true(hopf->accuracy < 1e-9);
        check_near(2 * M_PI / hopf->period, k ? sqrt(2) : 1, 1e-12);
    }
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

/* From independent programs: Hopf points of the valve and of flutter; then the valve's cycles up to
 * grazing. */
static void hopf_points_agree_with_independent_programs(void **unused) {
    (void)unused;
    saltus_scene scene = built_in("relief-valve", "q=9");
    saltus_branch_options options = branch_along("q", 7.3, 9.5);
    options.direction = -1;
    options.switches = 1;
    branch_record record = follow(&scene, &options);
    check_rests(&record);
    const saltus_branch_point *hopf = special(&record, SALTUS_POINT_HB, 1);
    check_near(hopf->value[0], 8.491117635183, 2e-12);
    check_near(hopf->state[0], 2.410313237687, 2e-12);
    check_near(2 * M_PI / hopf->period, 3.090708847974, 2e-12);
    assert_true(hopf->accuracy < 1e-10 && hopf->lyapunov_coefficient < 0);
    const saltus_branch_point *grazing = special(&record, SALTUS_POINT_GR, 1);
    assert_true(grazing->branch == 1 && grazing->parent == 0);
    check_near(grazing->value[0], 7.557210971877, 1e-11);
    check_near(grazing->period, 2.656012147475, 1e-11);
    branch_forget(&record);
    saltus_scene_clear(&scene);
    scene = built_in("flutter", "u=5");
    options = branch_along("u", 5, 7);
    options.direction = 1;
    record = follow(&scene, &options);
    check_rests(&record);
    hopf = special(&record, SALTUS_POINT_HB, 1);
    check_near(hopf->value[0], 6.27078414, 5e-9);
    check_near(2 * M_PI / hopf->period, 14.496704, 5e-7);
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

/* A pinned pipe buckles at the flow velocities pi and 2 pi (Paidoussis, Fluid-Structure Interactions 1, 3.4);
 * one of the buckled shapes comes to rest on the stop. */
static void a_pipe_buckles_onto_its_stop(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_scene scene = built_in("pipe", "sigma=0");
    check_ok(saltus_scene_set(&scene, "u0=1", &message), &message);
    saltus_branch_options options = branch_along("u0", 1, 7);
    options.direction = 1;
    options.switches = 1;
    branch_record record = follow(&scene, &options);
    check_rests(&record);
    for (int k = 1; k <= 2; k++) {
        const saltus_branch_point *fork = special(&record, SALTUS_POINT_BP, k);
        check_near(fork->value[0], k * M_PI, fork->accuracy);
        assert_true(fork->accuracy < 1e-12);
    }
    const saltus_branch_point *meets = special(&record, SALTUS_POINT_BE, 1);
    saltus_system *system = build(&meets->spec);
    check_near(saltus_system_gap(system, 0, meets->state), 0, 1e-14);
    assert_true(meets->parent == 0 && meets->value[0] > M_PI);
    saltus_system_free(system);
    int held = 0;
    for (int k = 0; k < record.count; k++)
        held += strcmp(record.point[k].label, "held") == 0 && record.point[k].contact_force > 0;
    assert_true(held > 5);
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

static const char stop[] = "stop: {coordinate: x, d: 0.5, r: 0.8, sides: upper}\n";

/* A mass pushed against a stop: x = F up to d, then the stop takes F - d. A mass that the stop keeps from
 * falling: for F > -d there is the contact force F + d and, unstable, x = -F; both end at -d. */
static void equilibria_meet_stops_and_leave_them(void **unused) {
    (void)unused;
    for (int falls = 0; falls < 2; falls++) {
        saltus_scene scene = scene_of("F: {default: -1}", falls ? "x - 0.5*x' + F" : "-x - 0.5*x' + F", stop);
        saltus_message message = {.text = ""};
        saltus_branch_options options = branch_along("F", -1, 1);
        options.direction = falls ? -1 : 1;
        if (falls)
            check_ok(saltus_scene_set(&scene, "F=1", &message), &message);
        check_ok(saltus_scene_set(&scene, falls ? "x=0.5" : "x=0", &message), &message);
        branch_record record = follow(&scene, &options);
        check_rests(&record);
        assert_int_equal(count_of(&record, SALTUS_POINT_BE), 1);
        const saltus_branch_point *meets = special(&record, SALTUS_POINT_BE, 1);
        check_near(meets->value[0], falls ? -0.5 : 0.5, 1e-13);
        check_near(meets->state[0], 0.5, 1e-13);
        assert_true(meets->grazing_stop == 1 && meets->grazing_side == 1 && meets->accuracy < 1e-10);
        assert_string_equal(meets->label, falls ? "held" : "equilibrium");
        assert_string_equal(meets->label_after, falls ? "equilibrium" : "held");
        assert_int_equal(strstr(meets->reason, "non-smooth fold") != NULL, falls);
        int held = 0, clear = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            if (p->kind == SALTUS_POINT_BE)
                continue;
            const bool holds = strcmp(p->label, "held") == 0;
            check_near(p->state[0], holds ? 0.5 : falls ? -p->value[0] : p->value[0], 1e-12);
            if (holds)
                check_near(p->contact_force, falls ? p->value[0] + 0.5 : p->value[0] - 0.5, 1e-12);
            assert_int_equal(p->stable, holds || !falls);
            held += holds;
            clear += !holds;
        }
        assert_true(held > 10 && clear > 10);
        check_near(record.point[record.count - 1].value[0], 1, 1e-13);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* x'' = b1 + b2 x + x^2 - x x' (Bogdanov-Takens; Kuznetsov, 8.4): the cycle born at b1 = 0 ends at a
 * homoclinic orbit. Near there the period grows with the logarithm of the distance in b1, by the saddle's
 * eigenvalue. */
static void cycles_end_at_a_homoclinic_orbit(void **unused) {
    (void)unused;
    saltus_scene scene =
        scene_of("b1: {default: 0.1}, b2: {default: -1}", "b1 + b2*x + x^2 - x*x'", "initial: {x: 0.1}\n");
    saltus_branch_options options = branch_along("b1", -0.5, 0.2);
    options.direction = -1;
    options.switches = 1;
    options.orbit.tolerance = 1e-11; /* the accuracy of a flow with the usual tolerance */
    branch_record record = follow(&scene, &options);
    check_rests(&record);
    const saltus_branch_point *last = &record.point[record.count - 1];
    double period = 0, distance = 1;
    assert_true(last->kind == SALTUS_POINT_EP && last->branch == 1);
    const char *told = strstr(last->reason, "homoclinic: the period grows without bound, here ");
    assert_non_null(told);
    assert_int_equal(sscanf(told, "homoclinic: the period grows without bound, here %lf at a distance of %lf",
                            &period, &distance),
                     2);
    check_near(period, last->period, 1e-4);
    assert_true(distance > 0 && distance < 1e-6 && period > 30);
    const double b1 = last->value[0], x = 0.5 * (1 + sqrt(1 - 4 * b1)), pull = 2 * x - 1;
    const double escape = -0.5 * x + sqrt(0.25 * x * x + pull);
    const saltus_branch_point *far = NULL, *near = NULL;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->branch == 1 && p->period > 18 && !far)
            far = p;
        if (p->branch == 1 && p->period > 24 && !near)
            near = p;
    }
    assert_true(far && near);
    check_near(escape * (near->period - far->period), log((far->value[0] - b1) / (near->value[0] - b1)),
               0.05);
    /* The cycle's distance from the saddle follows from the time it spends there. */
    assert_true(fabs(log(distance)) > 0.4 * escape * period && fabs(log(distance)) < escape * period);
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

/* Where homoclinic orbits are: from shooting along the saddle's unstable direction, bisected (fixed steps of
 * the classical Runge-Kutta method). With a stop that cycles hit; of cycles that pass two mirrored saddles;
 * and of cycles so unstable that the flow leaves them, of the equations above in reversed time. */
static void the_law_of_the_period_tells_where_it_has_no_bound(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char mu[] = "mu: {default: 1.05}", wells[] = "x - x^3 + (mu - x^2)*x'";
    static const char hit[] = "stop: {coordinate: x, d: 1.25, r: 0.8, sides: upper}\ninitial: {x: 1}\n";
    static const struct {
        const char *parameters, *motion, *rest, *key;
        double low, high, there;
    } cases[] = {
        {mu, wells, hit, "mu", 0.5, 1.1, 0.7615917721027815},
        {mu, "-x + x^3 + (mu - x^2)*x'", "initial: {x: 0}\n", "mu", -0.1, 1.1, 0.20116822890462913},
        {"b1: {default: 0.1}, b2: {default: -1}", "b1 + b2*x + x^2 + x*x'", "initial: {x: 0.1}\n", "b1", -0.5,
         0.2, -0.21360219841525466},
    };
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        saltus_scene scene = scene_of(cases[c].parameters, cases[c].motion, cases[c].rest);
        saltus_branch_options options = branch_along(cases[c].key, cases[c].low, cases[c].high);
        options.switches = 1;
        branch_record record = follow(&scene, &options);
        const char *told = NULL;
        double there, accuracy;
        for (int k = 0; k < record.count; k++)
            told = strncmp(record.point[k].reason, "homoclinic", 10) == 0 ? record.point[k].reason : told;
        assert_non_null(told);
        assert_int_equal(sscanf(strrchr(told, '='), "= %lf +- %lf", &there, &accuracy), 2);
        assert_true(accuracy < 1e-11);
        check_near(there, cases[c].there, accuracy);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* Along a curve on which a rest touches a stop, at x = 1/2, its stability changes where mu = x^2, and where
 * it folds, k = 3 x^2. From there the curves of Hopf points, mu = F^2, and of folds, F = - 2 (k/3)^(3/2), are
 * followed on the side of the stop on which the mass is. */
static void curves_of_rests_on_a_stop_tell_where_stability_changes(void **unused) {
    (void)unused;
    static const char half[] = "stop: {coordinate: x, d: 0.5, r: 0.8, sides: upper}\n";
    static const struct {
        const char *parameters, *motion, *rest, *key;
        saltus_point_kind kind;
        double low, high, there[2];
    } cases[] = {{"F: {default: 0.3}, mu: {default: 0.02}",
                  "F - x + (mu - x^2)*x'",
                  "initial: {x: 0.3}\n",
                  "mu",
                  SALTUS_POINT_HB,
                  0.2,
                  0.8,
                  {0.5, 0.25}},
                 {"F: {default: -0.1}, k: {default: 0.2}",
                  "F + k*x - x^3 - 0.2*x'",
                  "initial: {x: -0.5}\n",
                  "k",
                  SALTUS_POINT_LP,
                  -0.4,
                  0.8,
                  {-0.25, 0.75}}};
    for (int c = 0; c < 2; c++) {
        char rest[160];
        snprintf(rest, sizeof rest, "%s%s", half, cases[c].rest);
        saltus_scene scene = scene_of(cases[c].parameters, cases[c].motion, rest);
        saltus_branch_options options = branch_along("F", cases[c].low, cases[c].high);
        snprintf(options.key[1], sizeof options.key[1], "%s", cases[c].key);
        options.low[1] = 0;
        options.high[1] = 1;
        options.locus = SALTUS_POINT_BE;
        options.switches = 1;
        branch_record record = follow(&scene, &options);
        int met = 0, beyond = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            if (p->locus == cases[c].kind) {
                const double F = p->value[0], other = p->value[1];
                check_near(F, c ? -2 * pow(fmax(other, 0) / 3, 1.5) : sqrt(other), 1e-9);
                if (beyond++ == 0) {
                    check_near(F, cases[c].there[0], 1e-11);
                    check_near(other, cases[c].there[1], 1e-11);
                }
                assert_true(other < cases[c].there[1] + 1e-11);
                assert_int_equal(p->branch, 2);
                continue;
            }
            if (p->kind != cases[c].kind) {
                assert_true(p->kind == SALTUS_POINT_BE || p->kind == SALTUS_POINT_EP);
                continue;
            }
            check_near(p->value[0], cases[c].there[0], 1e-11);
            check_near(p->value[1], cases[c].there[1], 1e-11);
            met++;
        }
        assert_int_equal(met, 1);
        assert_true(beyond > 20);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* Known curves in two parameters: Hopf points of the same equations on b1 = 0, which end at b2 = 0; folds at
 * b1 = b2^2 / 4; a cusp at 0; a generalised Hopf point at b = 0; a stop that is met at F = d. */
static void loci_are_where_they_are_known(void **unused) {
    (void)unused;
    static const char held[] = "stop: {coordinate: x, d: 0.5, sides: upper}\ninitial: {x: 0.5}\n";
    static const char takens[] = "b1 + b2*x + x^2 - x*x'";
    static const struct {
        const char *parameters, *motion, *rest;
        saltus_point_kind kind, corner;
        const char *key[2];
        double low[2], high[2];
    } cases[] = {
        {"b1: {default: 0.1}, b2: {default: -1}",
         takens,
         "initial: {x: 0.1}\n",
         SALTUS_POINT_HB,
         SALTUS_POINT_BT,
         {"b1", "b2"},
         {-0.5, -2},
         {0.5, 2}},
        {"b1: {default: 0.1}, b2: {default: -1}",
         takens,
         "initial: {x: 0.1}\n",
         SALTUS_POINT_LP,
         SALTUS_POINT_BT,
         {"b1", "b2"},
         {-0.5, -2},
         {2, 2}},
        {"mu: {default: 0}, nu: {default: 1}",
         "mu + nu*x - x^3 - x'",
         "initial: {x: 1}\n",
         SALTUS_POINT_LP,
         SALTUS_POINT_CP,
         {"mu", "nu"},
         {-2, -1},
         {2, 2}},
        {"a: {default: -0.5}, b: {default: -1, min: -2, max: 2}",
         "a*x' + b*x^2*x' - x^4*x' - x",
         "",
         SALTUS_POINT_HB,
         SALTUS_POINT_GH,
         {"a", "b"},
         {-0.5, -2},
         {0.5, 2}},
        {"F: {default: -1}",
         "-x - 0.5*x' + F",
         stop,
         SALTUS_POINT_BE,
         SALTUS_POINT_REGULAR,
         {"F", "d"},
         {-1, 0.1},
         {2, 1}},
        {"F: {default: 1}",
         "x - 0.5*x' + F",
         held,
         SALTUS_POINT_BE,
         SALTUS_POINT_REGULAR,
         {"F", "d"},
         {-1, 0.1},
         {1.5, 0.9}},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_scene scene = scene_of(cases[k].parameters, cases[k].motion, cases[k].rest);
        saltus_branch_options options = branch_along(cases[k].key[0], cases[k].low[0], cases[k].high[0]);
        snprintf(options.key[1], sizeof options.key[1], "%s", cases[k].key[1]);
        options.low[1] = cases[k].low[1];
        options.high[1] = cases[k].high[1];
        options.locus = cases[k].kind;
        branch_record record = follow(&scene, &options);
        assert_true(record.count > 20);
        double least = INFINITY, most = -INFINITY;
        for (int i = 0; i < record.count; i++) {
            const saltus_branch_point *p = &record.point[i];
            const double first = p->value[0], second = p->value[1];
            assert_int_equal(p->locus, cases[k].kind);
            assert_int_equal(p->periods, 0);
            check_near(k == 1   ? first - second * second / 4
                       : k == 2 ? first * first - 4 * second * second * second / 27
                       : k == 4 ? first - second
                       : k == 5 ? first + second
                                : first,
                       0, 1e-9);
            if (k == 0 && second < -0.01)
                check_near(2 * M_PI / p->period, sqrt(-second), 1e-9);
            least = fmin(least, second);
            most = fmax(most, second);
        }
        check_near(least, k == 2 ? 0 : cases[k].low[1], k == 2 ? 1e-3 : 1e-12);
        check_near(most, k == 0 ? 0 : cases[k].high[1], k == 0 ? 1e-9 : k == 2 ? 0.2 : 1e-12);
        if (cases[k].corner) {
            const saltus_branch_point *corner = special(&record, cases[k].corner, 1);
            check_near(corner->value[0], 0, 1e-9);
            check_near(corner->value[1], 0, k == 2 ? 1e-6 : 1e-9);
        }
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* Where two eigenvalues are zero the curve of Hopf points ends on that of folds, b1 = b2^2/4, which goes on
 * both ways: from either of them the other is followed, once. Further eigenvalues have no effect. */
static void curves_meet_where_two_eigenvalues_are_zero(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const motion[] = {"b1 + b2*x + x^2 - x*x'",
                                         "b1 + b2*x + x^2 - x*x', y: -2*y' - 3*y + x"};
    for (int k = 0; k < 8; k++) {
        const saltus_point_kind own = k & 1 ? SALTUS_POINT_LP : SALTUS_POINT_HB;
        saltus_scene scene =
            scene_of("b1: {default: 0.1}, b2: {default: -1}", motion[k / 2 % 2], "initial: {x: 0.1}\n");
        saltus_branch_options options = branch_along("b1", -0.5, 2);
        snprintf(options.key[1], sizeof options.key[1], "b2");
        options.low[1] = -2;
        options.high[1] = 2;
        options.locus = own;
        options.switches = k < 4 ? 1 : 3;
        branch_record record = follow(&scene, &options);
        double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
        int starts = 0;
        for (int i = 0; i < record.count; i++) {
            const saltus_branch_point *p = &record.point[i];
            const bool folds = p->locus == SALTUS_POINT_LP;
            check_near(p->value[0], folds ? p->value[1] * p->value[1] / 4 : 0, 1e-9);
            assert_true(folds || p->locus == SALTUS_POINT_HB);
            assert_int_equal(p->parent < 0, p->locus == own);
            least[folds] = fmin(least[folds], p->value[1]);
            most[folds] = fmax(most[folds], p->value[1]);
            starts += p->parent >= 0 && p->branch != p[-1].branch;
            if (!folds && p->value[1] < -0.01)
                check_near(2 * M_PI / p->period, sqrt(-p->value[1]), 1e-9);
        }
        check_near(least[0], -2, 1e-12);
        check_near(most[0], 0, 1e-9);
        check_near(least[1], -2, 1e-12);
        check_near(most[1], 2, 1e-12);
        assert_int_equal(starts, own == SALTUS_POINT_HB ? 2 : 1);
        assert_int_equal(count_of(&record, SALTUS_POINT_BT), 1);
        assert_int_equal(count_of(&record, SALTUS_POINT_CP), 0);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* From the curve of folds the one of Hopf points, a = 0, was switched to, and followed on both ways from the
 * generalised Hopf point, which is not passed again. `a` is the parameter with this index. */
static void check_hopf_curve(const branch_record *record, int a) {
    int ends = 0, curves = 0;
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *p = &record->point[k];
        if (p->locus != SALTUS_POINT_HB)
            continue;
        check_near(p->value[a], 0, 1e-9);
        assert_true(p->kind == SALTUS_POINT_HB || p->kind == SALTUS_POINT_EP);
        assert_in_range(p->parent, 0, 1);
        curves += p->step == 0;
        ends += p->kind == SALTUS_POINT_EP && (p->value[!a] == -1 || p->value[!a] == 2);
    }
    assert_true(curves == 2 && ends == 2);
}

/* Cycles of radius r with a + b r^2 - r^4 = 0 fold where a = -b^2/4, r^2 = b/2, and shrink to nothing where
 * the curve of Hopf points, a = 0, has its first Lyapunov coefficient zero. From the Hopf points their curve
 * is followed from there, and from such a cycle it ends there, with steps of any length, interrupted or not.
 */
static void folding_cycles_grow_from_a_generalised_hopf_point(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const motion[] = {"x'*(a + b*(x^2 + x'^2) - (x^2 + x'^2)^2) - x",
                                         "x'*(a + b*(x^2 + x'^2) - (x^2 + x'^2)^2) - x, y: -2*y' - 3*y + x"};
    static const double step_max[] = {0.05, 0.02, 0.01};
    const double rest[4] = {0};
    for (int k = 0; k < 6; k++) {
        saltus_scene scene = scene_of("a: {default: -0.1}, b: {default: 1}", motion[k % 2], "");
        saltus_branch_options options = branch_along("a", -0.5, 0.5);
        snprintf(options.key[1], sizeof options.key[1], "b");
        options.low[1] = -1;
        options.high[1] = 2;
        options.locus = SALTUS_POINT_HB;
        options.switches = 1;
        options.step_max = step_max[k / 2];
        branch_record record = branch_run(&scene.spec, 0, rest, &options);
        const saltus_branch_point *cycle = NULL;
        double most = 0;
        for (int i = 0; i < record.count; i++) {
            const saltus_branch_point *p = &record.point[i];
            const bool folds = p->locus == SALTUS_POINT_LP;
            const double b = p->value[1];
            check_near(p->value[0], folds ? -b * b / 4 : 0, 1e-9);
            if (!folds)
                continue;
            assert_true(p->kind == SALTUS_POINT_LP || p->kind == SALTUS_POINT_EP);
            check_near(p->period, 2 * M_PI, 1e-8);
            check_near(hypot(p->state[0], p->state[k % 2 ? 2 : 1]), sqrt(b / 2), 1e-6);
            most = fmax(most, b);
            cycle = cycle || p->step < 10 ? cycle : p;
        }
        check_near(most, sqrt(2), 1e-9);
        assert_int_equal(count_of(&record, SALTUS_POINT_GH), 1);
        assert_non_null(cycle);
        options.locus = SALTUS_POINT_LP;
        options.orbit.free_period = true;
        branch_record back = branch_run(&cycle->spec, 1, cycle->state, &options);
        assert_int_equal(count_of(&back, SALTUS_POINT_GH), 1);
        assert_int_equal(count_of(&back, SALTUS_POINT_CP), 0);
        check_hopf_curve(&back, 0);
        for (int i = 0; i < back.count; i++)
            if (back.point[i].kind == SALTUS_POINT_GH) {
                check_near(back.point[i].value[0], 0, 1e-10);
                check_near(back.point[i].value[1], 0, 1e-10);
                assert_int_equal(back.point[i + 1].kind, SALTUS_POINT_EP);
            }
        if (k < 2) {
            assert_true(branch_check_resumed(&cycle->spec, 1, cycle->state, &options, 7) > 3);
            saltus_branch_options turned = options;
            for (int i = 0; i < 2; i++) {
                memcpy(turned.key[i], options.key[1 - i], sizeof turned.key[i]);
                turned.low[i] = options.low[1 - i];
                turned.high[i] = options.high[1 - i];
            }
            branch_record other = branch_run(&cycle->spec, 1, cycle->state, &turned);
            check_hopf_curve(&other, 1);
            branch_forget(&other);
        }
        options.orbit.free_period = false;
        options.locus = SALTUS_POINT_HB;
        if (k < 2)
            assert_true(branch_check_resumed(&scene.spec, 0, rest, &options, 7) > 3);
        branch_forget(&back);
        branch_forget(&record);
        saltus_scene_clear(&scene);
    }
}

/* Where the motion becomes linear all cycles belong to one place, which has no curve of folds: none is
 * followed along them, nor cusps found on it. */
static void cycles_of_linear_motion_have_no_curve_of_folds(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("a: {default: -0.1}, b: {default: 1}", "a*x' + b*x^2*x' - x", "");
    saltus_branch_options options = branch_along("a", -0.5, 0.5);
    snprintf(options.key[1], sizeof options.key[1], "b");
    options.low[1] = -1;
    options.high[1] = 2;
    options.locus = SALTUS_POINT_HB;
    options.switches = 1;
    branch_record record = follow(&scene, &options);
    assert_int_equal(count_of(&record, SALTUS_POINT_GH), 1);
    assert_int_equal(count_of(&record, SALTUS_POINT_CP), 0);
    int folds = 0;
    for (int k = 0; k < record.count; k++)
        folds += record.point[k].locus == SALTUS_POINT_LP;
    assert_in_range(folds, 1, 5);
    assert_string_equal(record.point[record.count - 1].reason,
                        "the orbits of one value of the parameters form a family");
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

/* Van der Pol's oscillator, pushed aside to x = a, loses its stability at a = 1. That curve ends where the
 * equilibrium meets the stop, at d = 1, and at once where it begins on a border of the range. The curve of
 * equilibria at the stop, a = d, passes through, to both sides. */
static void a_curve_of_hopf_points_ends_on_a_stop(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("mu: {default: 0.5}, a: {default: 0.5}", "mu*(1 - x^2)*x' - x + a",
                                  "stop: {coordinate: x, d: 1.5, r: 0.7}\n");
    saltus_branch_options options = branch_along("a", 0, 2);
    snprintf(options.key[1], sizeof options.key[1], "d");
    options.low[1] = 0.1;
    options.high[1] = 1.5;
    options.locus = SALTUS_POINT_HB;
    options.switches = 1;
    branch_record record = follow(&scene, &options);
    int ends = 0, touching = 0;
    double least = INFINITY, most = -INFINITY;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->locus == SALTUS_POINT_BE) {
            check_near(p->value[0], p->value[1], 1e-12);
            assert_true(p->branch == 2 || p->branch == 3);
            least = fmin(least, p->value[1]);
            most = fmax(most, p->value[1]);
            touching++;
            continue;
        }
        check_near(p->value[0], 1, 1e-12);
        if (p->kind != SALTUS_POINT_EP)
            continue;
        check_near(p->value[1], ++ends == 1 ? 1.5 : 1, 1e-12);
        assert_string_equal(p->reason,
                            ends == 1 ? "end of the parameters' range" : "the equilibrium meets a stop");
    }
    assert_int_equal(ends, 2);
    assert_true(touching > 10 && least == 0.1 && most == 1.5);
    branch_forget(&record);
    saltus_system *system = build(&scene.spec);
    saltus_message message = {.text = ""};
    double state[SALTUS_STATE_MAX];
    check_ok(saltus_scene_state(&scene, system, state, &message), &message);
    assert_true(branch_check_resumed(&scene.spec, 0, state, &options, 3) > 3);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

/* A run that is cut short goes on with the same points to the last bit: equilibria with the cycles and mirror
 * images that leave them, over a stop, and along loci. */
static void runs_are_resumed_to_the_last_bit(void **unused) {
    (void)unused;
    saltus_scene scene = built_in("relief-valve", "q=9");
    saltus_branch_options options = branch_along("q", 8.3, 9.5);
    saltus_system *system = build(&scene.spec);
    saltus_message message = {.text = ""};
    double state[SALTUS_STATE_MAX];
    options.switches = 1;
    check_ok(saltus_scene_state(&scene, system, state, &message), &message);
    assert_true(branch_check_resumed(&scene.spec, 0, state, &options, 15) > 3);
    options.locus = SALTUS_POINT_HB;
    snprintf(options.key[1], sizeof options.key[1], "kappa");
    options.low[1] = 1;
    options.high[1] = 1.5;
    assert_true(branch_check_resumed(&scene.spec, 0, state, &options, 5) > 3);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
    scene = scene_of("F: {default: -1}", "-x - 0.5*x' + F", stop);
    options = branch_along("F", -1, 1);
    const double rest[2] = {-1, 0};
    assert_true(branch_check_resumed(&scene.spec, 0, rest, &options, 15) > 3);
    saltus_scene_clear(&scene);
    scene = scene_of("mu: {default: -1}", "mu*x - x^2 - x'", "");
    options = branch_along("mu", -1, 1);
    options.switches = 1;
    const double zero[2] = {0};
    assert_true(branch_check_resumed(&scene.spec, 0, zero, &options, 15) > 3);
    saltus_scene_clear(&scene);
    scene = scene_of("b1: {default: 0.1}, b2: {default: -1}", "b1 + b2*x + x^2 - x*x'", "");
    options = branch_along("b1", -0.5, 2);
    snprintf(options.key[1], sizeof options.key[1], "b2");
    options.low[1] = -2;
    options.high[1] = 2;
    options.locus = SALTUS_POINT_LP;
    options.switches = 1;
    const double near_rest[2] = {0.1, 0};
    assert_true(branch_check_resumed(&scene.spec, 0, near_rest, &options, 5) > 3);
    saltus_scene_clear(&scene);
}

/* A scene at rest is reported with its eigenvalues, in contact those of the motion with contacts held. */
static void rests_are_classified_with_their_eigenvalues(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_classify_options options = saltus_classify_defaults();
    for (int held = 0; held < 2; held++) {
        saltus_scene scene = scene_of("F: {default: -1}", "-x - 0.5*x' + F", stop);
        check_ok(saltus_scene_set(&scene, held ? "F=2" : "F=-1", &message), &message);
        check_ok(saltus_scene_set(&scene, "x=0", &message), &message);
        saltus_system *system = build(&scene.spec);
        saltus_motion motion;
        double state[2];
        check_ok(saltus_scene_state(&scene, system, state, &message), &message);
        check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
        assert_int_equal(motion.verdict, held ? SALTUS_HELD : SALTUS_EQUILIBRIUM);
        assert_non_null(motion.eigenvalues);
        assert_int_equal(motion.eigenvalue_count, held ? 0 : 2);
        assert_true(motion.stable && motion.multiplier_count == 0);
        for (int k = 0; k < motion.eigenvalue_count; k++) {
            check_near(motion.eigenvalues[k].re, -0.25, 1e-14);
            check_near(motion.eigenvalues[k].im, (k ? -1 : 1) * sqrt(1 - 0.0625), 1e-14);
        }
        if (held)
            check_near(motion.contact_force[0], 1.5, 1e-12);
        else
            check_near(motion.lyapunov, -0.25, 1e-14);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

static void write_text(fixture *f, const char *name, const char *text) {
    FILE *file = fopen(path_in(f, name), "w");
    fputs(text, file);
    fclose(file);
}

/* Commands pass equilibria on; a branch begins at the first value of its range. */
static void commands_hand_equilibria_on(void **state) {
    fixture *f = *state;
    char *text = told(f, "classify relief-valve --set q=9 --json");
    json *motion = json_read(text);
    assert_true(json_number_at(motion, "periods") == 0 && json_number_at(motion, "eigenvalues.0.0") < 0);
    write_text(f, "rest.json", text);
    json_free(motion);
    free(text);
    free(told(f, "classify relief-valve --set q=9"));
    text = told(f, "continue relief-valve --from rest.json --in q=8:9.5 -o branch.h5");
    assert_non_null(strstr(text, "supercritical"));
    free(text);
    text = told(f, "orbit relief-valve --from branch.h5:HB1 --json");
    json *rest = json_read(text);
    check_near(json_number_at(rest, "parameters.q"), 8.491117635183, 2e-12);
    check_near(json_number_at(rest, "eigenvalues.0.0"), 0, 1e-10);
    json_free(rest);
    free(text);
    write_text(f, "scene.yaml",
               "model:\n  parameters: {mu: {default: 3}}\n  motion: {x: mu - x^3 - x'}\ninitial: {x: 1}\n");
    text = told(f, "continue scene.yaml --in mu=1:8 --at 8 --json -o cube.h5");
    *strchr(text, '\n') = '\0';
    json *first = json_read(text);
    assert_true(json_number_at(first, "values.0") == 1);
    check_near(json_number_at(first, "state.0"), 1, 1e-12);
    assert_int_equal(run(f, "continue scene.yaml --in mu=1:8 -o cube.h5 --resume"), 0);
    json_free(first);
    free(text);
    free(told(f, "export branch.h5 -o branch.csv"));
    free(told(f, "plot branch.h5 -o branch.svg"));
    free(told(f, "plot branch.h5 --show period -o period.svg"));
    /* Cycles that shrink to the equilibrium lead to the same curve. */
    text = told(f, "continue relief-valve --set q=8.3 --in q=8:8.8 --direction up --locus HB --and "
                   "kappa=1.2:1.3 -o locus.h5");
    assert_non_null(strstr(text, "from q = 8.49111763518, kappa = 1.25: HB of equilibrium"));
    free(text);
    assert_int_equal(run(f, "continue relief-valve --from rest.json --in q=8:9.5 --periods 2 -o no.h5"), 2);
    assert_int_equal(
        run(f, "continue relief-valve --from rest.json --in q=8:9.5 --locus PD --and kappa=1:2 -o no.h5"), 2);
    char *errors = said(f, "err");
    assert_non_null(strstr(errors, "locus = PD"));
    free(errors);
    assert_int_equal(
        run(f, "continue impact-oscillator --in omega=0.9:1.1 --locus HB --and d=0.9:1.1 -o no.h5"), 2);
}

/* Without damping eigenvalues stay on the imaginary axis and never cross it. */
static void undamped_rests_have_no_hopf_points(void **unused) {
    (void)unused;
    saltus_scene scene =
        scene_of("k: {default: 1}", "-k*x - x^3 + 0.3*y, y: -2*y + 0.3*x", "initial: {x: 0, y: 0}\n");
    saltus_branch_options options = branch_along("k", 0.5, 3);
    branch_record record = follow(&scene, &options);
    assert_true(record.count > 20);
    for (int k = 0; k < record.count; k++)
        assert_true(record.point[k].kind != SALTUS_POINT_HB);
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(undamped_rests_have_no_hopf_points),
        cmocka_unit_test(a_fold_is_where_two_equilibria_meet),
        cmocka_unit_test(branches_leave_at_branch_points),
        cmocka_unit_test(hopf_points_of_linear_motion_are_not_decided),
        cmocka_unit_test(hopf_points_have_the_coefficient_of_the_normal_form),
        cmocka_unit_test(hopf_points_close_together_are_told_apart),
        cmocka_unit_test(hopf_points_agree_with_independent_programs),
        cmocka_unit_test(a_pipe_buckles_onto_its_stop),
        cmocka_unit_test(equilibria_meet_stops_and_leave_them),
        cmocka_unit_test(cycles_end_at_a_homoclinic_orbit),
        cmocka_unit_test(the_law_of_the_period_tells_where_it_has_no_bound),
        cmocka_unit_test(curves_of_rests_on_a_stop_tell_where_stability_changes),
        cmocka_unit_test(loci_are_where_they_are_known),
        cmocka_unit_test(curves_meet_where_two_eigenvalues_are_zero),
        cmocka_unit_test(folding_cycles_grow_from_a_generalised_hopf_point),
        cmocka_unit_test(cycles_of_linear_motion_have_no_curve_of_folds),
        cmocka_unit_test(a_curve_of_hopf_points_ends_on_a_stop),
        cmocka_unit_test(runs_are_resumed_to_the_last_bit),
        cmocka_unit_test(rests_are_classified_with_their_eigenvalues),
        cmocka_unit_test_setup_teardown(commands_hand_equilibria_on, open_fixture, close_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
