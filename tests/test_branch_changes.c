/* How branches continue where orbits meet others or change their events, checked by general rules: which
 * orbits they are, in which order they come, and that none is taken for another.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_recount.h"

static saltus_spec small_pipe(double modes, double omega, double alpha, double u0, double sigma) {
    saltus_spec spec = pipe_spec(modes, omega);
    set_parameter(&spec, "alpha", alpha);
    set_parameter(&spec, "u0", u0);
    set_parameter(&spec, "sigma", sigma);
    return spec;
}

static const saltus_branch_point *last_of(const branch_record *record) {
    return &record->point[record->count - 1];
}

/* Of the orbit near a state, in a point's system, the multiplier nearest to a number. */
static double multiplier_near(const saltus_branch_point *point, int periods, const double *state,
                              double number) {
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {.text = ""};
    saltus_system *system = build(&point->spec);
    saltus_orbit orbit;
    double nearest = INFINITY;
    check_ok(saltus_orbit_find(system, periods, state, &options, &orbit, &message), &message);
    for (int i = 0; i < point->dimension; i++)
        if (orbit.multipliers[i].im == 0 && fabs(orbit.multipliers[i].re - number) < fabs(nearest - number))
            nearest = orbit.multipliers[i].re;
    saltus_orbit_clear(&orbit);
    saltus_system_free(system);
    return nearest;
}

/* Orbits of two periods remain so until they join those of one period at its flip, however long the steps. */
static void doubled_orbits_end_at_flips(void **unused) {
    (void)unused;
    const double steps[] = {0.005, 0.02, 0.05};
    for (int row = 0; row < 3; row++) {
        saltus_spec spec = small_pipe(1, 11.8489, 0.00455, 4.26446, 0.224);
        add_stop(&spec, 0.01642, 0.53119, SALTUS_UPPER);
        saltus_branch_options options = branch_along("r", 0.371836, 0.584313);
        options.direction = -1;
        options.step_max = options.step = steps[row];
        branch_record record = branch_run_settled(&spec, &options, "2/2");
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            assert_int_equal(p->event_count, 2);
            double apart = saltus_time_periods(p->events[1].time) - saltus_time_periods(p->events[0].time);
            if (p->kind == SALTUS_POINT_REGULAR)
                assert_true(fabs(apart - 1) > 1e-6);
        }
        const saltus_branch_point *join = last_of(&record) - 1;
        assert_int_equal(join->kind, SALTUS_POINT_PD);
        assert_string_equal(join->reason, "joins the orbits of half the period");
        check_near(multiplier_near(join, 1, join->state, -1), -1, 1e-3);
        branch_forget(&record);
    }
}

/* A buckled pipe straightens where the straight one has a multiplier 1. The parameter turns back in the same
 * place, which is one point of one kind. */
static void a_pitchfork_has_one_name(void **unused) {
    (void)unused;
    const double sigma[] = {0.1, 0.209, 0.3};
    for (int row = 0; row < 3; row++) {
        saltus_spec spec = small_pipe(2, 33.08051, 0.00425, 3.25, sigma[row]);
        add_stop(&spec, 0.05, 0.5, SALTUS_LOWER);
        saltus_branch_options options = branch_along("u0", 2.9, 3.3);
        options.direction = -1;
        branch_record record = branch_run_settled(&spec, &options, "0/1");
        const double straight[4] = {0};
        int found = 0, from = 0;
        const saltus_branch_point *point;
        while ((point = branch_next_special(&record, 0, &from)) && point->kind != SALTUS_POINT_GR) {
            assert_int_equal(point->kind, SALTUS_POINT_BP);
            check_near(multiplier_near(point, 1, straight, 1), 1, 1e-7);
            found++;
        }
        assert_int_equal(found, 1);
        branch_forget(&record);
    }
}

static saltus_spec chattering_pipe(void) {
    saltus_spec spec = small_pipe(1, 28.30537, 0.00607, 3.96774, 0.159);
    add_stop(&spec, 0.017, 0.26214, SALTUS_BOTH);
    return spec;
}

/* Orbits whose multipliers are all zero neither fold nor flip, nor turn back where an impact is born. Where
 * their chatter is no longer complete, the branch goes on to ever fewer impacts; the way back, on which they
 * are born one by one, leads to the same place. */
static void runs_of_impacts_end_where_they_begin(void **unused) {
    (void)unused;
    saltus_spec spec = chattering_pipe();
    saltus_branch_options options = branch_along("d", 0.011898, 0.022096);
    options.direction = -1;
    branch_record record = branch_run_settled(&spec, &options, "chatter/3");
    const saltus_branch_point *complete = NULL, *back = NULL;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        bool forgets = true;
        for (int i = 0; i < p->dimension; i++)
            forgets = forgets && p->multipliers[i].log_modulus == -INFINITY;
        if (p->kind == SALTUS_POINT_LP || p->kind == SALTUS_POINT_PD)
            assert_false(forgets);
        if (p->kind == SALTUS_POINT_GR && forgets)
            assert_null(strstr(p->reason, "turns back"));
        if (p->kind == SALTUS_POINT_CH) {
            assert_null(complete);
            complete = p;
        }
        if (p->kind == SALTUS_POINT_GR && complete && !back && atoi(p->label) > 4)
            assert_int_equal(atoi(p->label_after), atoi(p->label) - 1);
        if (complete && !back && p->kind == SALTUS_POINT_REGULAR && p->impacts == 4)
            back = p;
    }
    assert_true(complete && back);
    assert_string_equal(last_of(&record)->reason, "end of the parameter's range");
    options.direction = back->heading > 0 ? -1 : 1;
    branch_record run = branch_run(&back->spec, back->periods, back->state, &options);
    const saltus_branch_point *completes = NULL;
    for (int k = 0; k < run.count && !completes; k++) {
        const saltus_branch_point *p = &run.point[k];
        completes = p->kind == SALTUS_POINT_CH ? p : NULL;
        if (p->kind == SALTUS_POINT_GR)
            assert_int_equal(atoi(p->label_after), atoi(p->label) + 1);
    }
    assert_non_null(completes);
    check_near(completes->value[0], complete->value[0], completes->accuracy + complete->accuracy);
    branch_forget(&run);
    branch_forget(&record);
}

/* An orbit has two chatters: one is no longer complete for a while and completes again where births of
 * impacts accumulate; the other stays complete. */
static void one_of_two_chatters_completes(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_spec spec = small_pipe(2, 10.475, 0.004354, 4.5, 0.2);
    add_stop(&spec, 0.023229, 0.3146, SALTUS_UPPER);
    saltus_branch_options options = branch_along("omega", 8.3, 10.6);
    options.direction = -1;
    options.step_max = 0.1;
    branch_record record = branch_run_settled(&spec, &options, "chatter/4");
    int changes = 0, births = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        changes += p->kind == SALTUS_POINT_CH;
        assert_int_not_equal(p->kind, SALTUS_POINT_ST);
        assert_string_equal(p->label, "chatter/4");
        if (p->kind == SALTUS_POINT_REGULAR)
            assert_int_equal(p->sticking_intervals, changes == 1 ? 1 : 2);
        births += p->kind == SALTUS_POINT_GR && strstr(p->reason, "is born");
    }
    assert_int_equal(changes, 2);
    assert_true(births > 4);
    assert_string_equal(last_of(&record)->reason, "end of the parameter's range");
    branch_forget(&record);
}

/* Where orbits of 42 periods no longer chatter completely, orbits of 14 periods nearby still do: the branch
 * does not switch to these. */
static void other_branches_are_not_gone_on_with(void **unused) {
    (void)unused;
    saltus_spec spec = small_pipe(1, 41.90829, 0.00579, 3.84031, 0.387);
    add_stop(&spec, 0.01225, 0.396, SALTUS_BOTH);
    saltus_branch_options options = branch_along("d", 0.008572, 0.01592);
    options.direction = 1;
    branch_record record = branch_run_settled(&spec, &options, "chatter/42");
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        int first = -1, repeated = 0, releases = 0;
        for (int i = 0; i < p->event_count; i++) {
            if (p->events[i].kind != SALTUS_RELEASE)
                continue;
            double since = first < 0 ? 1
                                     : remainder(saltus_time_periods(p->events[i].time) -
                                                     saltus_time_periods(p->events[first].time),
                                                 p->periods / 3.);
            repeated += fabs(since) < 1e-6;
            first = first < 0 ? i : first;
            releases++;
        }
        assert_true(releases >= 2 && repeated < 2);
    }
    branch_forget(&record);
}

/* Where an impact grazes on orbits with a long run of impacts, or with chatter, whose impacts the prescribed
 * sequence leaves to the flow: the curve of grazing counts as the branch does where the impact has been born,
 * all impacts or none, and lists what it counts. */
static void curves_of_grazing_count_all_impacts(void **unused) {
    (void)unused;
    skip_where_slow();
    static const struct {
        const char *key[2];
        double omega, d, end, low, high;
        bool chatter;
    } rows[] = {{{"d", "omega"}, 10, 0.0252, 0.0254, 9.9, 10.1, true},
                {{"omega", "d"}, 10.6, 0.025, 10.62, 0.0249, 0.0251, false}};
    skip_where_slow();
    for (int row = 0; row < 2; row++) {
        saltus_spec spec = small_pipe(5, rows[row].omega, 0.005, 4.5, 0.2);
        add_stop(&spec, rows[row].d, 0.9, SALTUS_UPPER);
        saltus_branch_options options =
            branch_along(rows[row].key[0], row ? rows[row].omega : rows[row].d, rows[row].end);
        options.step_max = 0.1;
        options.points = 250;
        branch_record record = branch_run_settled(&spec, &options, row ? "60/2" : "chatter/2");
        int k = 1;
        while (k < record.count && (record.point[k].kind != SALTUS_POINT_GR ||
                                    !(rows[row].chatter || strstr(record.point[k].reason, "born"))))
            k++;
        assert_true(k < record.count);
        const saltus_branch_point *grazing = &record.point[k];
        assert_true((grazing->impacts < 0) == rows[row].chatter);
        options.low[0] = grazing[-1].value[0];
        snprintf(options.key[1], sizeof options.key[1], "%s", rows[row].key[1]);
        options.low[1] = rows[row].low;
        options.high[1] = rows[row].high;
        options.locus = SALTUS_POINT_GR;
        options.points = 3;
        branch_record curve = branch_run(&grazing->spec, grazing->periods, grazing->state, &options);
        assert_true(curve.count >= 3);
        for (int j = 0; j < curve.count; j++) {
            const saltus_branch_point *p = &curve.point[j];
            int impacts = 0;
            for (int i = 0; i < p->event_count; i++)
                impacts += p->events[i].kind == SALTUS_IMPACT;
            assert_int_equal(p->impacts, grazing->impacts + !rows[row].chatter);
            assert_int_equal(p->sticking_intervals, grazing->sticking_intervals);
            assert_string_equal(p->label, grazing->label_after);
            assert_true(p->impacts < 0 ? impacts > 24 : p->impacts == impacts);
        }
        branch_forget(&curve);
        branch_forget(&record);
    }
}

/* Between two times of sticking, after which all is forgotten, perturbations grow ten million times: the
 * orbit is far from the guess although that closes, and depends so strongly on the parameter that rounding
 * hides where the branch leads. */
static void a_long_transient_between_chatter(void **unused) {
    (void)unused;
    const double state[2] = {-0.0013761515305851328, -0.091762685222898};
    saltus_spec spec = small_pipe(1, 17.1748, 0.005, 4.5, 0.2);
    add_stop(&spec, 0.017, 0.568, SALTUS_UPPER);
    saltus_branch_options options = branch_along("omega", 16.66, 17.69);
    branch_record record = branch_run(&spec, 33, state, &options);
    assert_true(record.count >= 4);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        assert_string_equal(p->label, "chatter/33");
        assert_true(p->admissible && p->residual < 1e-11);
        check_near(p->value[0], 17.1748, 1e-9);
        if (p->kind == SALTUS_POINT_EP)
            assert_non_null(strstr(p->reason, "rounding hides the parameter"));
    }
    branch_forget(&record);
}

/* At restitutions near 1 all impacts of a long run matter: where chatter ceases to complete they die one by
 * one, each at a grazing where the branch turns back, to a fold and a flip, whatever the step. */
static void impacts_of_a_long_run_die_one_by_one(void **unused) {
    (void)unused;
    static const double step_max[] = {0.02, 0.05};
    static const saltus_point_kind kinds[] = {SALTUS_POINT_GR, SALTUS_POINT_LP, SALTUS_POINT_PD};
    enum { most = 25, left = 7, each = 3, count = each * (most - left) };
    double place[2][count];
    saltus_spec spec = oscillator_spec(0.17166, 1, 0.89272, 1.31806);
    add_stop(&spec, -0.67669, 0.526, SALTUS_UPPER);
    for (int run = 0; run < 2; run++) {
        saltus_branch_options options = branch_along("r", 0.5, 1);
        options.direction = 1;
        options.step_max = step_max[run];
        branch_record record = branch_run_settled(&spec, &options, "chatter/1");
        int from = 0, found = 0;
        const saltus_branch_point *point;
        while ((point = branch_next_special(&record, 0, &from)) && point->impacts != most - 1)
            if (point->kind == SALTUS_POINT_GR)
                place[run][0] = point->value[0];
        for (found = 1; point && found < count; found++, point = branch_next_special(&record, 0, &from)) {
            const int impacts = most - (found + each - 1) / each;
            const double critical = point->kind == SALTUS_POINT_PD ? -1 : 1;
            assert_int_equal(point->kind, kinds[found % each]);
            assert_int_equal(point->impacts, impacts);
            if (point->kind != SALTUS_POINT_GR)
                check_near(point->multipliers[0].re, critical, 1e-6);
            place[run][found] = point->value[0];
        }
        assert_int_equal(found, count);
        assert_null(point);
        assert_string_equal(last_of(&record)->label, "7/1");
        assert_true(last_of(&record)->value[0] == 1);
        branch_forget(&record);
    }
    for (int k = 0; k < count; k++)
        check_near(place[0][k], place[1][k], 1e-10);
}

/* The changes of sticking on a branch of the pipe between equal stops, started at a state; *last becomes a
 * copy of the last point. */
static saltus_branch_point splitting(const saltus_spec *spec, const double *state, double low, int direction,
                                     double step_max, saltus_branch_point *last) {
    saltus_branch_options options = branch_along("omega", low, 44.1);
    saltus_message message = {.text = ""};
    saltus_branch_point found;
    int changes = 0;
    options.direction = direction;
    options.step_max = step_max;
    branch_record record = branch_run(spec, 4, state, &options);
    for (int k = 0; k < record.count; k++)
        if (record.point[k].kind == SALTUS_POINT_ST && ++changes)
            check_ok(saltus_branch_point_copy(&record.point[k], &found, &message), &message);
    assert_int_equal(changes, 1);
    check_ok(saltus_branch_point_copy(last_of(&record), last, &message), &message);
    branch_forget(&record);
    return found;
}

/* Where a contact splits, the flight between its parts becomes too short to be seen before it vanishes: the
 * place is the same from both sides, and whatever the steps, all the same. */
static void a_contact_splits_at_one_place(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_scene pipe;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load("pipe", &pipe, &message), &message);
    saltus_spec spec = pipe.spec;
    set_parameter(&spec, "N", 4);
    set_parameter(&spec, "omega", 43.95);
    spec.stops[0].d = 0.014;
    spec.stops[0].r = 0.208;
    spec.stops[0].sides = SALTUS_BOTH;
    saltus_system *system = build(&spec);
    saltus_classify_options how = saltus_classify_defaults();
    saltus_motion motion;
    double start[16];
    check_ok(saltus_system_default_state(system, start, &message), &message);
    check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
    assert_string_equal(motion.label, "chatter/4");
    saltus_branch_point change[3], last[3];
    change[0] = splitting(&spec, motion.state, 43.95, 1, 0.2, &last[0]);
    change[1] = splitting(&spec, motion.state, 43.95, 1, 0.02, &last[1]);
    change[2] = splitting(&last[0].spec, last[0].state, 44, -1, 0.2, &last[2]);
    for (int k = 0; k < 3; k++) {
        assert_int_equal(change[k].sticking_intervals, k < 2 ? 4 : 3);
        assert_int_equal(last[k].sticking_intervals, k < 2 ? 3 : 4);
        assert_true(change[k].accuracy < 1e-11);
        check_near(change[k].value[0], change[0].value[0], change[k].accuracy + change[0].accuracy);
    }
    for (int k = 0; k < 3; k++) {
        saltus_branch_point_clear(&change[k]);
        saltus_branch_point_clear(&last[k]);
    }
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    saltus_scene_clear(&pipe);
}

/* Two masses, of which one hits a wall, and the stops between them. */
static const char linked[] = "model:\n"
                             "  parameters: {c: 0.174792, k: 0.865053, F: 0.53502, omega: 1.54552, m: 0.7}\n"
                             "  mass: {x: 1, y: m}\n"
                             "  motion:\n"
                             "    x: -c*x' - x - k*(x - y) + F*cos(omega*t)\n"
                             "    y: -c*y' - k*(y - x) - 0.4*y\n"
                             "  forcing: omega\n"
                             "stops:\n"
                             "  - {coordinate: x - y, d: 0.5, r: 0.7, sides: both}\n"
                             "  - {coordinate: y, d: 0.7, r: 0.6, sides: upper}\n";

/* A run from an orbit of a scene, named or told in lines, with these settings or, if `periods` is 0, from
 * what that settles on. */
static branch_record run_from(const char *scene_name, const char *settings, int periods, const double *state,
                              const saltus_branch_options *options) {
    saltus_message message = {.text = ""};
    saltus_scene scene = {.name = ""};
    saltus_classify_options how = saltus_classify_defaults();
    saltus_motion motion = {.periods = periods, .state = NULL};
    double own[SALTUS_SCENE_STATE_MAX];
    if (strchr(scene_name, '\n'))
        check_ok(saltus_scene_parse(scene_name, strlen(scene_name), "text", &scene, &message), &message);
    else
        check_ok(saltus_scene_load(scene_name, &scene, &message), &message);
    char *copy = strdup(settings), *rest = copy;
    for (char *word; (word = strtok_r(rest, " ", &rest));)
        check_ok(saltus_scene_set(&scene, word, &message), &message);
    free(copy);
    saltus_system *system = build(&scene.spec);
    check_ok(saltus_scene_state(&scene, system, own, &message), &message);
    if (!periods)
        check_ok(saltus_classify(system, own, &how, &motion, &message), &message);
    branch_record record = branch_run(&scene.spec, motion.periods, periods ? state : motion.state, options);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
    return record;
}

static branch_record run_in_steps(const char *scene_name, const char *settings, const char *key, double low,
                                  double high, int switches, double longest) {
    saltus_branch_options options = branch_along(key, low, high);
    options.switches = switches;
    options.step_max = longest;
    options.step = longest / 4;
    return run_from(scene_name, settings, 0, NULL, &options);
}

static branch_record run_scene(const char *scene_name, const char *settings, const char *key, double low,
                               double high, int switches) {
    return run_in_steps(scene_name, settings, key, low, high, switches, 0.02);
}

/* A ball on a table that moves with two harmonics. */
static const char table[] = "model:\n"
                            "  parameters: {F: 2, omega: 1}\n"
                            "  motion: {x: -1 - 0.07615*x' + F*sin(omega*t) + 0.2303*sin(2*omega*t)}\n"
                            "  forcing: omega\n"
                            "stop: {coordinate: x, d: 0, r: 0.2799, sides: lower}\n";

/* A ball on a table that moves in two harmonics. Where chatter ceases to complete there are orbits with any
 * number of impacts, many of them of other branches: the branch goes on with one close to it, or ends.
 * Islands of chatter that it enters at one end and then at the other, in another period of the orbit, are
 * visited once. */
static void branches_leave_chatter_nearby(void **unused) {
    (void)unused;
    skip_where_slow();
    branch_record record = run_scene(table, "F=2.2804", "F", 2.2804, 2.2805, 1);
    int visited = 0, left = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k], *next = p + 1;
        visited += strstr(p->reason, "this CH is on branch") != NULL;
        for (int j = 0; j < k && p->kind == SALTUS_POINT_CH; j++)
            assert_true(record.point[j].kind != SALTUS_POINT_CH ||
                        fabs(record.point[j].value[0] - p->value[0]) > 1e-12);
        if (p->kind != SALTUS_POINT_CH || p->impacts >= 0)
            continue;
        left++;
        if (p->label_after[0])
            for (int i = 0; i < p->dimension; i++)
                check_near(next->state[i], p->state[i], 1e-2);
        else
            assert_true(next->kind == SALTUS_POINT_EP && next->value[0] == p->value[0]);
    }
    assert_int_equal(left, 2);
    assert_int_equal(visited, 1);
    branch_forget(&record);
}

/* Whatever the steps, a run finds the same special points on the same branches, known as well as it says:
 * also a flip within the first step of a branch that was switched to, two flips around the place where a
 * branch turns back into itself, orbits along which perturbations grow beyond all bounds, impacts that die as
 * the orbit touches elsewhere, places where the equations are singular, branches that turn so sharply where
 * they begin that a long step would lead to other orbits of the same events, branches that turn sharply
 * beside one another, a fold just before a branch turns back into itself and none where it only does so,
 * also if a step ends there, steps that would leap to other orbits across what looks like a branch point, a
 * torus on the same step as two real multipliers with the product 1, and a flip and its reverse on one step.
 */
static void steps_do_not_matter(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char whirling[] =
        "model:\n"
        "  parameters: {e: 0.6, omega: 1.14429}\n"
        "  motion:\n"
        "    x: -0.088296*x' - x - 0.120597*y + e*omega^2*cos(omega*t)\n"
        "    y: -0.088296*y' - 1.4*y + 0.120597*x + e*omega^2*sin(omega*t) - 0.273232\n"
        "  forcing: omega\n"
        "stop: {coordinate: x, d: 0.890287, r: 0.790858, sides: both}\n";
    static const struct {
        const char *scene, *settings, *key;
        double low, high;
        int switches, branches;
        double longest; /* step, of the first run */
    } rows[] = {
        {"impact-pair", "d=1.83803 omega=1 r=0.773234", "d", 1.10282, 2.94084, 0, 2, 0.02},
        {"impact-oscillator", "d=1.2757 omega=0.999108 r=0.393093 c=0.126234 sides=both", "omega", 0.699375,
         1.39875, 2, 5, 0.02},
        {"impact-oscillator", "d=1.17242 omega=0.820691 r=0.748885 c=0 sides=both", "omega", 0.615519,
         1.10793, 2, 7, 0.02},
        {"fig7d", "omega=20.7173 d=0.0178042 r=0.375591 N=2", "omega", 20, 21.2, 1, 4, 0.02},
        {"impact-pair", "d=0.844319 omega=1 r=0.478", "r", 0.4, 0.55, 2, 10, 0.02},
        {"impact-pair", "d=0.956393 r=0.853072 c=0.0302495", "d", 0.7688, 1.11421, 0, 2, 0.1},
        {"impact-oscillator", "d=0.48 omega=0.440908 r=0.667033 c=0 sides=both", "d", 0.4, 0.55, 0, 2, 0.02},
        {"two-mass", "d=0.373239 omega=0.89146 r=0.899447 c=0.281725", "omega", 0.84119986, 1.0456735, 2, 5,
         0.04},
        {"pipe", "N=4 d=0.014 omega=43.6 r=0.208 sides=both", "omega", 43.45, 43.65, 0, 2, 0.006},
        {linked, "m=0.752731", "m", 0.2307979, 0.88908213, 0, 1, 0.04},
        {whirling, "e=0.6", "e", 0.56, 0.7, 0, 2, 0.2},
    };
    for (size_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
        branch_record record[3];
        const double range = rows[row].high - rows[row].low;
        for (int k = 0; k < 3; k++)
            record[k] = run_in_steps(rows[row].scene, rows[row].settings, rows[row].key, rows[row].low,
                                     rows[row].high, rows[row].switches, rows[row].longest / (1 << k));
        int compared = 0;
        for (int branch = 0; branch < rows[row].branches; branch++)
            for (int at[3] = {0};; compared++) {
                const saltus_branch_point *p[3];
                for (int k = 0; k < 3; k++)
                    p[k] = branch_next_special(&record[k], branch, &at[k]);
                for (int k = 1; k < 3; k++)
                    assert_int_equal(p[0] != NULL, p[k] != NULL);
                if (!p[0])
                    break;
                assert_true(p[0]->accuracy < 1e-12 * range);
                for (int k = 1; k < 3; k++) {
                    assert_int_equal(p[k]->kind, p[0]->kind);
                    assert_string_equal(p[k]->label, p[0]->label);
                    assert_string_equal(p[k]->label_after, p[0]->label_after);
                    check_near(p[k]->value[0], p[0]->value[0], p[k]->accuracy + p[0]->accuracy);
                }
            }
        assert_true(compared > 0);
        for (int k = 0; k < 3; k++)
            branch_forget(&record[k]);
    }
}

/* A flip of doubled orbits so close to where they leave those of half the period that one step passes both:
 * it is found on the way there, whatever the steps, and on the way from there. */
static void a_flip_beside_a_join_is_found(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char settings[] = "F=0.7292 omega=1.08106 d=0.941356 c=0.325636 r=0.406333 sides=both";
    branch_record from = run_scene("duffing", settings, "F", 0.728, 0.76, 1);
    const saltus_branch_point *flip = NULL, *start = NULL;
    for (int k = 0; k < from.count; k++) {
        const saltus_branch_point *p = &from.point[k];
        if (strcmp(p->label, "6/4") == 0 && p->kind == SALTUS_POINT_PD)
            flip = p;
        if (flip && !start && p->value[0] < flip->value[0] - 1e-5)
            start = p;
    }
    assert_true(flip && start);
    char there[200];
    snprintf(there, sizeof there, "%s F=%.17g", settings, start->value[0]);
    for (double longest = 0.02; longest > 0.001; longest /= 2) {
        saltus_branch_options options = branch_along("F", 0.316, 0.79);
        options.step = options.step_max = longest;
        options.direction = 1;
        branch_record record = run_from("duffing", there, start->periods, start->state, &options);
        const saltus_branch_point *join = last_of(&record) - 1, *before = join - 1;
        assert_string_equal(join->reason, "joins the orbits of half the period");
        assert_int_equal(before->kind, SALTUS_POINT_PD);
        check_near(before->value[0], flip->value[0], before->accuracy + flip->accuracy);
        branch_forget(&record);
    }
    branch_forget(&from);
    /* Without impacts; just before the join a long step does not reach the orbits of this branch. */
    static const double state[] = {-1.01881165992428, 0.7740795527839901};
    const double longest[] = {0.01, 0.03, 0.04};
    double value = 0, accuracy = 0;
    for (int k = 0; k < 3; k++) {
        saltus_branch_options options = branch_along("omega", 0.99273592, 1.9287617);
        options.step = options.step_max = longest[k];
        options.direction = 1;
        branch_record record = run_from(
            "duffing", "c=0.367876 F=0.518635 d=0.973354 omega=1.4036203405829477", 8, state, &options);
        const saltus_branch_point *join = last_of(&record) - 1, *before = join - 1;
        assert_string_equal(join->reason, "joins the orbits of half the period");
        assert_int_equal(before->kind, SALTUS_POINT_PD);
        if (k)
            check_near(before->value[0], value, accuracy + before->accuracy);
        value = before->value[0];
        accuracy = before->accuracy;
        branch_forget(&record);
    }
}

/* The only point of a kind in a record. */
static const saltus_branch_point *only_point(const branch_record *record, saltus_point_kind kind) {
    const saltus_branch_point *found = NULL;
    for (int k = 0; k < record->count; k++)
        if (record->point[k].kind == kind) {
            assert_null(found);
            found = &record->point[k];
        }
    assert_non_null(found);
    return found;
}

/* The third and the fourth branch are the last, and lead from a joined place to both borders. */
static void check_joined(const branch_record *record, const char *label, double low, double high) {
    bool ends[2] = {false, false};
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *p = &record->point[k];
        assert_true(p->branch < 4);
        if (p->branch < 2)
            continue;
        assert_string_equal(p->label, label);
        ends[0] |= p->kind == SALTUS_POINT_EP && p->value[0] == low;
        ends[1] |= p->kind == SALTUS_POINT_EP && p->value[0] == high;
    }
    assert_true(ends[0] && ends[1]);
}

/* Where a branch joins another its own equations are singular: the place is known as well as from the other
 * one, by whose equations it is located. */
static void joins_are_where_the_other_branch_says(void **unused) {
    (void)unused;
    skip_where_slow();
    static const struct {
        const char *scene, *joining, *joined, *key;
        double low, high;
        saltus_point_kind kind;
        double sharp;
    } rows[] = {
        {"fig3", "r=0.8", "r=0.5", "r", 0.4, 0.8, SALTUS_POINT_BP, 2e-11},
        {"pipe", "N=4 d=0.014 r=0.208 sides=both omega=43.6", "N=4 d=0.014 r=0.208 sides=both omega=43.49",
         "omega", 43.45, 43.65, SALTUS_POINT_BP, 1e-10},
        {"fig7d", "N=2 omega=21.3", "N=2 omega=21.1", "omega", 21, 22, SALTUS_POINT_PD, 1e-11},
    };
    for (size_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
        branch_record record[2];
        const saltus_branch_point *point[2];
        for (int k = 0; k < 2; k++) {
            record[k] = run_scene(rows[row].scene, k ? rows[row].joined : rows[row].joining, rows[row].key,
                                  rows[row].low, rows[row].high, 0);
            point[k] = only_point(&record[k], rows[row].kind);
            assert_true(point[k]->accuracy < rows[row].sharp);
        }
        assert_non_null(strstr(point[0]->reason, "joins"));
        assert_string_equal(point[1]->reason, "");
        check_near(point[0]->value[0], point[1]->value[0], point[0]->accuracy + point[1]->accuracy);
        branch_forget(&record[0]);
        branch_forget(&record[1]);
    }
}

/* A branch that is joined is followed both ways from there. */
static void joined_branches_are_followed(void **unused) {
    (void)unused;
    branch_record record = run_scene("fig3", "r=0.8", "r", 0.4, 0.8, 1);
    check_joined(&record, "2/2", 0.4, 0.8);
    branch_forget(&record);
    record = run_scene("fig7d", "N=2 omega=21.3", "omega", 21, 22, 1);
    check_joined(&record, "1/2", 21, 22);
    branch_forget(&record);
}

/* An orbit of two periods leads to those of one at a flip and at their grazing. From both ends, or from the
 * grazing alone, these are followed once. */
static void a_branch_joined_twice_is_followed_once(void **unused) {
    (void)unused;
    branch_record from = run_scene("near-grazing", "omega=0.99971 F=0.36", "F", 0.03, 0.38, 1);
    const saltus_branch_point *start = NULL;
    for (int k = 0; k < from.count; k++)
        if (!from.point[k].kind && from.point[k].value[0] < 0.0403 && strcmp(from.point[k].label, "1/2") == 0)
            start = &from.point[k];
    assert_non_null(start);
    for (int direction = -1; direction <= 0; direction++) {
        saltus_branch_options options = branch_along("F", 0.03, 0.05);
        options.direction = direction;
        options.switches = 1;
        branch_record record = branch_run(&start->spec, 2, start->state, &options);
        const saltus_branch_point *joins = NULL;
        for (int k = 0; k + 1 < record.count && !joins; k++)
            if (strstr(record.point[k + 1].reason, "half the period at their grazing"))
                joins = &record.point[k];
        assert_non_null(joins);
        int single = 0, free_flights = 0, joined = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            joined += strstr(p->reason, "joins the orbits of half the period at their grazing") &&
                      strcmp(p->label, "1/2") == 0;
            single += p->kind == SALTUS_POINT_EP && p->value[0] == 0.05 && strcmp(p->label, "1/1") == 0;
            free_flights += p->kind == SALTUS_POINT_EP && p->value[0] == 0.03 && strcmp(p->label, "0/1") == 0;
            if (p->kind == SALTUS_POINT_GR && strcmp(p->label, "1/1") == 0)
                check_near(p->value[0], joins->value[0], 1e-11);
        }
        assert_true(single == 1 && free_flights == 1 && joined == 1);
        branch_forget(&record);
    }
    branch_forget(&from);
}

/* Orbits of three and of four periods lead to one of a single period at its grazing, where the amplitude of
 * the linear oscillator is that of the stop. From there on the orbits are those of one period, with the
 * impact and without. */
static void a_third_and_a_quarter_graze(void **unused) {
    (void)unused;
    static const struct {
        int periods;
        double state[2];
        const char *share;
    } rows[] = {{3, {0.97170329628549691, 0.08027912663758354}, "a third"},
                {4, {0.99720648675969981, 0.07093817213263985}, "a quarter"}};
    const double omega = 0.878, c = 0.02, grazing = hypot(1 - omega * omega, c * omega);
    saltus_spec spec = oscillator_spec(c, 1, 1.01 * grazing, omega);
    add_stop(&spec, 1, 0.8, SALTUS_UPPER);
    for (size_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
        saltus_branch_options options = branch_along("F", 0.99 * grazing, 1.02 * grazing);
        options.switches = 1;
        branch_record record = branch_run(&spec, rows[row].periods, rows[row].state, &options);
        int joins = 0, ends = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            assert_true(p->impacts > 0 || p->periods == 1);
            ends += p->kind == SALTUS_POINT_EP && p->branch >= 2 && p->periods == 1 &&
                    p->value[0] == (p->impacts ? options.high[0] : options.low[0]);
            if (!strstr(p->reason, "at their grazing"))
                continue;
            joins++;
            assert_non_null(strstr(p->reason, rows[row].share));
            assert_int_equal(p[-1].kind, SALTUS_POINT_GR);
            check_near(p->value[0], grazing, 1e-12);
        }
        assert_int_equal(joins, 1);
        assert_int_equal(ends, 2);
        branch_forget(&record);
        /* There the curve of that orbit's grazing begins, too. */
        options.locus = SALTUS_POINT_GR;
        snprintf(options.key[1], sizeof options.key[1], "omega");
        options.low[1] = 0.86;
        options.high[1] = 0.89;
        record = branch_run(&spec, rows[row].periods, rows[row].state, &options);
        int curve = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            if (!p->locus)
                continue;
            curve++;
            assert_int_equal(p->periods, 1);
            check_near(p->value[0], hypot(1 - p->value[1] * p->value[1], c * p->value[1]), 1e-14);
        }
        assert_true(curve > 20);
        branch_forget(&record);
    }
}

/* Beside a grazing orbit of the linear oscillator, which turns by the angle 2 pi / omega in a period, one of
 * two periods with one impact is admissible if that angle is 50 degrees, and on neither side at 220 degrees:
 * then no branch is sought. */
static void doubled_orbits_are_admissible_or_not_sought(void **unused) {
    (void)unused;
    static const double omega[] = {0.878, 360. / 220};
    const double c = 0.02;
    for (int row = 0; row < 2; row++) {
        const double grazing = hypot(1 - omega[row] * omega[row], c * omega[row]);
        saltus_spec spec = oscillator_spec(c, 1, 0.95 * grazing, omega[row]);
        add_stop(&spec, 1, 0.8, SALTUS_UPPER);
        saltus_branch_options options = branch_along("F", 0.9 * grazing, 1.1 * grazing);
        options.switches = 1;
        const double part = 0.95 / grazing,
                     state[] = {part * (1 - omega[row] * omega[row]), part * c * omega[row] * omega[row]};
        branch_record record = branch_run(&spec, 1, state, &options);
        const saltus_branch_point *touch = only_point(&record, SALTUS_POINT_GR);
        check_near(touch->value[0], grazing, 1e-12);
        int doubled = 0;
        for (int k = 0; k < record.count; k++) {
            doubled += record.point[k].periods == 2;
            assert_true(record.point[k].periods == 1 || strcmp(record.point[k].label, "1/2") == 0);
            assert_null(strstr(record.point[k].reason, "nothing"));
        }
        assert_true(row ? doubled == 0 : doubled > 5);
        branch_forget(&record);
    }
}

/* After a run of impacts the halves of orbits of twice the period are all but alike. They fold and graze as
 * others do, and end where the shorter orbits flip. */
static void halves_that_are_all_but_alike(void **unused) {
    (void)unused;
    skip_where_slow();
    branch_record record = run_scene("fig7d", "r=0.739", "r", 0.7095, 0.74, 1);
    double flip[8] = {0};
    int flips = 0, joined = 0, folds = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->branch == 1 && p->kind == SALTUS_POINT_PD)
            flip[flips++] = p->value[0];
        if (p->branch < 2)
            continue;
        assert_null(strstr(p->reason, "at their grazing"));
        folds += p->kind == SALTUS_POINT_LP;
        if (p->kind != SALTUS_POINT_PD)
            continue;
        assert_string_equal(p->reason, "joins the orbits of half the period");
        check_near(p->value[0], flip[joined++], 1e-11);
    }
    assert_int_equal(flips, 6);
    assert_int_equal(joined, flips);
    assert_int_equal(folds, flips);
    branch_forget(&record);
}

/* Where hardly anything rebounds, grazings, flips and the completion of chatter lie so close together that
 * rounding hides orbits of twice the period: shorter ones do not go by their name. The branch itself goes on,
 * and not back, to where nothing rebounds. */
static void where_hardly_anything_rebounds(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char text[] =
        "model:\n"
        "  parameters: {omega: 0.986548}\n"
        "  motion: {x: -0.139236*x' - x - 0.196256*tanh(8*x') + 0.70394*cos(omega*t)}\n"
        "  forcing: omega\n"
        "stop: {coordinate: x, d: 0.655929, r: 0.7, sides: upper}\n";
    static const saltus_point_kind kinds[] = {SALTUS_POINT_GR, SALTUS_POINT_PD, SALTUS_POINT_GR,
                                              SALTUS_POINT_PD, SALTUS_POINT_CH};
    for (int k = 0; k < 2; k++) {
        saltus_branch_options options = branch_along("r", 0, 0.01);
        options.direction = -1;
        options.switches = 3;
        options.step = 0.01;
        options.step_max = k ? 0.04 : 0.02;
        branch_record record = run_from(text, "r=0.005", 0, NULL, &options);
        int at = 0, ends = 0;
        for (int j = 0; j < 5; j++)
            assert_int_equal(branch_next_special(&record, 0, &at)->kind, kinds[j]);
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            ends += p->kind == SALTUS_POINT_EP && p->branch == 0 && p->value[0] == 0;
            assert_true(p->branch < 2 || !branch_special(p));
        }
        assert_int_equal(ends, 1);
        branch_forget(&record);
    }
}

/* Impacts that rebound at all end in complete chatter where a contact follows, and r = 0 is where that ends,
 * however little of it the tolerance lets be seen. */
static void what_hardly_rebounds_chatters(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {omega: 1.1702}\n"
                               "  motion: {x: -0.2028*x' - 1.2516*x + 0.8422*cos(omega*t) - 0.0153}\n"
                               "  forcing: omega\n"
                               "stop: {coordinate: x, d: 0.1409, r: 0.7, sides: upper}\n";
    saltus_branch_options options = branch_along("r", 0, 0.01);
    options.direction = -1;
    branch_record record = run_from(text, "r=0.005", 0, NULL, &options);
    for (int j = 0; j < record.count; j++) {
        const bool rebounds = record.point[j].value[0] > 0;
        assert_string_equal(record.point[j].label, rebounds ? "chatter/1" : "1/1");
        assert_int_equal(record.point[j].kind, rebounds ? SALTUS_POINT_REGULAR : SALTUS_POINT_EP);
    }
    assert_true(record.point[record.count - 2].value[0] < 1e-7 && last_of(&record)->value[0] == 0);
    branch_forget(&record);
}

/* A value asked for within a window of the parameter that has no orbits: wide ones end the branch, narrow
 * ones lie within a step, which then tells that the value was not reached; and none takes a neighbour for it.
 */
static void values_without_orbits_are_told(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {F: 0.9, w: 1e-5, omega: 1.3}\n"
                               "  motion: {x: -0.3*x' - x + F*cos(omega*t) + 0.01*sqrt((F - 1)^2 - w^2)}\n"
                               "  forcing: omega\n"
                               "stop: {coordinate: x, d: 10, r: 0.7, sides: upper}\n";
    static const char *const settings[] = {"w=0", "w=1e-9", "w=1e-5"};
    static const double values[] = {1};
    for (int k = 0; k < 3; k++) {
        saltus_branch_options options = branch_along("F", 0.9, 1.1);
        options.values = values;
        options.value_count = 1;
        options.direction = 1;
        branch_record record = run_from(text, settings[k], 0, NULL, &options);
        int reached = 0, told = 0;
        for (int j = 1; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            if (p->kind == SALTUS_POINT_UZ) {
                check_near(p->value[0], 1, 1e-12);
                reached++;
            }
            if (strstr(p->reason, "is a UZ by its test, but no orbit is found there")) {
                assert_true(p[-1].value[0] < 1 && p->value[0] > 1);
                told++;
            }
        }
        assert_int_equal(reached, k == 0);
        assert_int_equal(told, k > 0);
        check_near(last_of(&record)->value[0], 1.1, 0);
        branch_forget(&record);
    }
}

/* A range may reach beyond where scenes exist: branches and curves end exactly there, and say why. */
static void ranges_end_where_scenes_do(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {a: 0.3, omega: 1.2}\n"
                               "  motion: {x: -0.2*x' - x + 0.5*cos(omega*t)}\n"
                               "  forcing: omega\n"
                               "stop: {coordinate: x, d: 0.3, r: 1 - 2*a, sides: upper}\n";
    static const char domain[] = "end of the parameter's domain: r = %s: must be at least 0 and at most 1";
    for (int k = 0; k < 2; k++) {
        saltus_branch_options options = branch_along(k ? "omega" : "a", k ? 0.3 : -1, k ? 1.4 : 0.3);
        options.locus = k ? SALTUS_POINT_GR : SALTUS_POINT_REGULAR;
        snprintf(options.key[1], sizeof options.key[1], "a");
        options.low[1] = -1;
        options.high[1] = 1;
        options.direction = k ? 0 : -1;
        branch_record record = run_from(text, "a=0.3", 0, NULL, &options);
        int ends = 0;
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            char why[SALTUS_REASON_MAX];
            if (p->kind != SALTUS_POINT_EP)
                continue;
            const bool dead = k && p->branch == 0;
            snprintf(why, sizeof why, domain, dead ? "-1" : "3");
            assert_ptr_equal(strstr(p->reason, why), p->reason);
            check_near(p->value[k], dead ? 0.5 : 0, 0);
            ends++;
        }
        assert_int_equal(ends, 1 + k);
        branch_forget(&record);
    }
}

/* Branches of orbits along which errors grow a million-fold or more begin in as many segments as those that
 * they leave, at flips, where branches cross, and at grazing; they go on from there. */
static void branches_leave_where_errors_grow(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {F: 0.261, omega: 0.216}\n"
                               "  motion: {x: -0.26*x' + x - x^3 + F*cos(omega*t)}\n"
                               "  forcing: omega\n"
                               "stop: {coordinate: x, d: 0.917, r: 0.31, sides: both}\n"
                               "initial: {x: 0.3}\n";
    static const double state[] = {-0.4516619234028753, 0.021802639590796896};
    saltus_branch_options options = branch_along("F", 0.25, 1);
    options.points = 13;
    options.switches = 1;
    options.direction = 1;
    branch_record record = run_from(text, "F=0.4007647247763", 1, state, &options);
    int points[3] = {0}, doubled[3] = {0};
    for (int j = 0; j < record.count; j++) {
        const saltus_branch_point *p = &record.point[j];
        points[p->branch]++;
        doubled[p->branch] += p->periods == 2 && fabs(p->multipliers[0].re) > 1e6;
        assert_true(p->kind != SALTUS_POINT_EP || !strcmp(p->reason, "as many points as asked for"));
    }
    for (int branch = 0; branch < 3; branch++) {
        assert_int_equal(points[branch], 13);
        assert_int_equal(doubled[branch] > 0, branch > 0);
    }
    branch_forget(&record);
}

/* However much errors grow around an orbit, its segments are cut again from the states at all cuts: the
 * branch goes on from where it comes down to where it turns back. There rounding hides the critical
 * multiplier, and no flip is made of it, which orbits that are their own mirror images cannot have. */
static void errors_grow_without_bound(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {omega: 0.695}\n"
                               "  motion: {x: -0.16*x' + x - x^3 + 0.339*cos(omega*t)}\n"
                               "  forcing: omega\n"
                               "stop: {coordinate: x, d: 1.271, r: 0.71, sides: both}\n"
                               "initial: {x: 0.3}\n";
    static const double state[] = {-0.799525393417654, 0.248775135032897};
    saltus_branch_options options = branch_along("omega", 0.03, 2);
    options.direction = -1;
    options.points = 90;
    options.step = options.step_max = 0.1;
    branch_record record = run_from(text, "omega=0.205623707139776", 1, state, &options);
    double lowest = 1, growth = 0;
    for (int j = 0; j < record.count; j++) {
        const saltus_branch_point *p = &record.point[j];
        lowest = fmin(lowest, p->value[0]);
        growth = fmax(growth, p->multipliers[0].re);
        assert_true(p->kind != SALTUS_POINT_PD);
        assert_true(p->kind != SALTUS_POINT_BP || (isnan(p->multipliers[0].re) && p->unstable == 0));
    }
    assert_true(growth > 1e22 && last_of(&record)->value[0] > lowest + 1e-3);
    check_near(lowest, 0.07293862834, 1e-10);
    assert_string_equal(last_of(&record)->reason, "as many points as asked for");
    branch_forget(&record);
}

/* Where impacts are born or die, too, all others rebound as the parameter there says. */
static void impacts_rebound_as_told(void **unused) {
    (void)unused;
    static const char text[] =
        "model:\n"
        "  parameters: {omega: 1.6585}\n"
        "  motion: {x: -0.378*x' - 1.7024*x + 0.9863*cos(omega*t) + 0.306*sin(2*omega*t) + 0.5256}\n"
        "  forcing: omega\n"
        "stop: {coordinate: x, d: 0.2666, r: 0.212, sides: upper}\n";
    saltus_branch_options options = branch_along("r", 0.2, 0.9);
    options.direction = 1;
    branch_record record = run_from(text, "r=0.212", 0, NULL, &options);
    int touches = 0;
    for (int j = 0; j < record.count; j++) {
        const saltus_branch_point *p = &record.point[j];
        touches += p->kind == SALTUS_POINT_GR;
        for (int k = 0; k < p->event_count; k++)
            if (p->events[k].kind == SALTUS_IMPACT)
                check_near(p->events[k].velocity_after, -p->value[0] * p->events[k].velocity_before, 1e-15);
    }
    assert_true(touches > 2);
    branch_forget(&record);
}

/* Where impacts hardly rebound, rounding hides the fourth birth of a run: chatter completes all the same, at
 * the place where it ceases to on the way back. */
static void a_short_run_completes(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {omega: 1.2}\n"
                               "  motion: {x: -0.2*x' - x + 0.5*cos(omega*t)}\n"
                               "  forcing: omega\n"
                               "stop: {coordinate: x, d: 0.3, r: 0.4, sides: upper}\n";
    double place[2] = {0};
    for (int up = 0; up < 2; up++) {
        saltus_branch_options options = branch_along("r", 0, 0.1);
        options.direction = up ? 1 : -1;
        branch_record record = run_from(text, up ? "r=0.002" : "r=0.05", 0, NULL, &options);
        for (int j = 0; j < record.count; j++)
            if (record.point[j].kind == SALTUS_POINT_CH)
                place[up] = record.point[j].value[0];
        assert_string_equal(last_of(&record)->reason, "end of the parameter's range");
        branch_forget(&record);
    }
    check_near(place[0], place[1], 1e-11);
    assert_true(place[0] > 0.008);
}

/* Births on orbits of eight periods, between whose chatters perturbations grow a hundred million times, lead
 * to chatter, too: it completes where, without any continuation, a ball that leaves the table at rest first
 * comes to rest eight periods later, and ceases to where that ball last does (closed forms between impacts in
 * 40 digits, bisection). Beyond, impacts die at places whose distances from there form a geometric sequence:
 * the orbits are those of the same branch, not others nearby. */
static void a_run_on_doubled_orbits_completes(void **unused) {
    (void)unused;
    skip_where_slow();
    static const double places[2] = {2.2828965611920476, 2.2828964617448461};
    const double state[2] = {0.003976940941260867, 0.21619228274259325};
    saltus_branch_options options = branch_along("F", 2.2494, 2.3);
    options.direction = -1;
    options.points = 250;
    branch_record record = run_from(table, "F=2.249457551590614", 8, state, &options);
    int changes = 0, deaths = 0;
    double death[4];
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->kind == SALTUS_POINT_CH) {
            assert_true(changes < 2);
            check_near(p->value[0], places[changes], 1e-13);
            changes++;
        } else if (changes == 2 && p->kind == SALTUS_POINT_GR && deaths < 4) {
            assert_non_null(strstr(p->reason, "dies"));
            death[deaths++] = p->value[0] - places[1];
        }
    }
    assert_int_equal(changes, 2);
    assert_int_equal(deaths, 4);
    check_near(death[1] / death[0], death[2] / death[1], 0.01);
    check_near(death[2] / death[1], death[3] / death[2], 0.01);
    branch_forget(&record);
}

/* Where the halves of a doubled orbit come to chatter at once, complete chatter makes them alike: the branch
 * ends at the place where the chatter of the orbits of half the period begins. */
static void chatter_joins_the_orbits_of_a_part(void **unused) {
    (void)unused;
    skip_where_slow();
    static const double states[2][2] = {{0.013248467639684161, -0.12223345472173995},
                                        {0.013248317026158337, -0.12223465585238509}};
    static const char *const from[] = {"F=2.2814090535458296", "F=2.281409053610069"};
    double place[2] = {0}, accuracy[2] = {0};
    for (int doubled = 0; doubled < 2; doubled++) {
        saltus_branch_options options = branch_along("F", 2.28, 2.3);
        options.direction = 1;
        options.points = doubled ? 300 : 65;
        branch_record record = run_from(table, from[doubled], doubled ? 8 : 4, states[doubled], &options);
        for (int k = 0; k < record.count; k++)
            if (record.point[k].kind == SALTUS_POINT_CH &&
                strcmp(record.point[k].label_after, "chatter/4") == 0) {
                place[doubled] = record.point[k].value[0];
                accuracy[doubled] = record.point[k].accuracy;
            }
        if (doubled)
            assert_string_equal(last_of(&record)->reason, "joins orbits of a part of the period");
        branch_forget(&record);
    }
    check_near(place[0], place[1], accuracy[0] + accuracy[1]);
    assert_true(place[0] > 2.28);
}

/* Close to where a branch of orbits of twice the period begins, and another impact is about to be born, that
 * branch is not left for the shorter orbits, on which other branches leave. */
static void doubled_orbits_near_the_end_of_a_run(void **unused) {
    (void)unused;
    static const char text[] =
        "model:\n"
        "  parameters: {omega: 0.74408}\n"
        "  motion: {x: -0.246586*x' - (1 + 0.146168*cos(omega*t))*sin(x) + 0.828745*cos(omega*t)}\n"
        "  forcing: omega\n"
        "stop: {coordinate: x, d: 0.90209, r: 0.675968, sides: both}\n";
    saltus_branch_options options = branch_along("r", 0, 1);
    options.switches = 1;
    options.points = 250;
    options.step = 0.0025;
    options.step_max = 0.01;
    branch_record record = run_from(text, "d=0.90209", 0, NULL, &options);
    for (int k = 0; k < record.count; k++)
        assert_true(record.point[k].kind != SALTUS_POINT_BP);
    assert_non_null(strstr(last_of(&record)->reason, "rounding"));
    branch_forget(&record);
}

/* Without losses multipliers are on the unit circle: where a range ends at r = 1 they come to it and do not
 * cross it. */
static void no_torus_begins_where_nothing_is_lost(void **unused) {
    (void)unused;
    const double lows[] = {0.2, 0.3, 0.4}, steps[] = {0.04, 0.03, 0.02};
    for (int k = 0; k < 3; k++) {
        branch_record record = run_in_steps("impact-pair", "", "r", lows[k], 1, 0, steps[k]);
        bool ends = false;
        for (int j = 0; j < record.count; j++) {
            assert_true(record.point[j].kind != SALTUS_POINT_NS);
            ends |= record.point[j].kind == SALTUS_POINT_EP && record.point[j].value[0] == 1;
        }
        assert_true(ends);
        branch_forget(&record);
    }
}

/* A second chatter of an orbit completes where it ceases to seen from the other side, wherever in the orbit's
 * periods the branch cuts it open. */
static void a_second_chatter_completes(void **unused) {
    (void)unused;
    skip_where_slow();
    double place[2], accuracy[2];
    for (int way = 0; way < 2; way++) {
        saltus_branch_options options = branch_along("r", way ? 0.4 : 0.64, way ? 0.8 : 0.648);
        options.direction = way ? -1 : 1;
        branch_record record = run_from("chatter", way ? "r=0.652" : "r=0.645", 0, NULL, &options);
        int changes = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            assert_int_not_equal(p->kind, SALTUS_POINT_ST);
            if (p->kind != SALTUS_POINT_CH)
                continue;
            place[way] = p->value[0];
            accuracy[way] = p->accuracy;
            changes++;
        }
        assert_int_equal(changes, 1);
        assert_string_equal(last_of(&record)->reason, "end of the parameter's range");
        branch_forget(&record);
    }
    check_near(place[0], place[1], accuracy[0] + accuracy[1]);
}

/* Between the grazings of a long run multipliers change so fast that rounding moves a pair off the unit
 * circle: all the same a torus begins before each flip. */
static void tori_between_the_grazings_of_a_run(void **unused) {
    (void)unused;
    skip_where_slow();
    static const saltus_point_kind kinds[] = {SALTUS_POINT_NS, SALTUS_POINT_PD, SALTUS_POINT_GR};
    saltus_branch_options options = branch_along("r", 0.8012, 0.8024);
    options.direction = 1;
    options.step_max = 0.04;
    branch_record record = run_from("fig7d", "omega=24.6295 d=0.0353832 r=0.8014", 0, NULL, &options);
    const saltus_branch_point *p;
    int at = 0, count = 0;
    for (; (p = branch_next_special(&record, 0, &at)); count++)
        assert_int_equal(p->kind, kinds[count % 3]);
    assert_int_equal(count, 9);
    branch_forget(&record);
}

/* On a step that ends at grazing, where rounding leaves only the greatest multiplier, a torus is found all
 * the same. */
static void a_torus_before_grazing(void **unused) {
    (void)unused;
    static const double state[] = {0.84566278261877137, 0.67734079573965056, 1.1289405736105789,
                                   0.9562652530732203};
    saltus_branch_options options = branch_along("m", 0.55431539, 1.5984565);
    options.direction = 1;
    options.switches = 1;
    options.points = 12;
    options.step = 0.005;
    branch_record record = run_from(
        linked, "c=0.0607469 k=0.660621 F=0.696518 omega=0.917548 m=0.6810480421033458", 1, state, &options);
    int at = 0;
    const saltus_branch_point *torus = branch_next_special(&record, 1, &at);
    assert_int_equal(torus->kind, SALTUS_POINT_NS);
    check_near(torus->value[0], 0.6812216611906, 1e-12);
    branch_forget(&record);
}

/* Towards grazing a pair leaves the unit circle, turns real, and a real one times another passes 1, all
 * within a small part of the step. */
static void a_pair_turns_real_before_grazing(void **unused) {
    (void)unused;
    static const char rods[] = "model:\n"
                               "  parameters: {z1: 0.0571, p2: -1.397, omega: 0.8606}\n"
                               "  motion:\n"
                               "    a: -2*z1*a' - a - 0.3*a^3 + 0.5679*cos(omega*t)\n"
                               "    b: -0.627*b' - 39.3129*b + 0.28395*cos(omega*t)\n"
                               "  forcing: omega\n"
                               "stop: {coordinate: a - p2*b, d: 0.4383, r: 0.5692, sides: upper}\n";
    saltus_branch_options options = branch_along("p2", -2.0168, -0.89859);
    options.direction = 1;
    options.points = 25;
    branch_record record = run_from(rods, "p2=-1.397", 0, NULL, &options);
    const saltus_branch_point *torus = NULL;
    for (int k = 0; k < record.count; k++)
        if (strcmp(record.point[k].label, "17/1") == 0 && record.point[k].kind == SALTUS_POINT_NS)
            torus = &record.point[k];
    assert_non_null(torus);
    check_near(torus->value[0], -1.293340432318, 1e-11);
    branch_forget(&record);
}

/* Where orbits of twice the period leave, the parameter turns: a fold that cannot be told from there, however
 * far it seems along the branch, is none. */
static void no_fold_is_where_a_branch_begins(void **unused) {
    (void)unused;
    saltus_branch_options options = branch_along("omega", 3.38507, 6.28657);
    options.switches = 1;
    options.points = 12;
    options.step = 0.0025;
    options.step_max = 0.01;
    branch_record record = run_from("budd-dux", "omega=4.872 d=-0.0245213 r=0.91891", 0, NULL, &options);
    int at = 0, flips = 0;
    for (const saltus_branch_point *p; (p = branch_next_special(&record, 0, &at));)
        flips += p->kind == SALTUS_POINT_PD;
    for (int k = 0; k < record.count; k++)
        assert_int_not_equal(record.point[k].kind, SALTUS_POINT_LP);
    assert_true(flips == 1 && last_of(&record)->branch > 0);
    branch_forget(&record);
}

/* Where the search for a fold leads to the other one of two branches that join, there is none. */
static void no_fold_is_on_the_other_branch(void **unused) {
    (void)unused;
    saltus_branch_options options = branch_along("omega", 0.71149678, 1.1703018);
    options.direction = 1;
    options.switches = 2;
    options.points = 530;
    options.step = options.step_max = 0.01;
    branch_record record =
        run_from("chain", "N=3 c=0.23065 omega=1.02569 d=0.216849 r=0.504962", 0, NULL, &options);
    int at = 0;
    const saltus_branch_point *join = branch_next_special(&record, 3, &at);
    assert_int_equal(join->kind, SALTUS_POINT_PD);
    assert_string_equal(join->label, "6/4");
    assert_null(branch_next_special(&record, 3, &at));
    branch_forget(&record);
}

/* Where the table only just lifts the ball off, rounding hides all orbits: nothing special is seen there but
 * the place where the ball stays down. */
static void nothing_is_named_within_rounding(void **unused) {
    (void)unused;
    branch_record record =
        run_in_steps("vibrating-table", "F=1.16165 r=0.589792", "F", 0.84731541, 1.2255505, 2, 0.02);
    int held = 0, at = 0;
    const saltus_branch_point *p;
    for (int branch = 0; branch < 2; branch++, at = 0)
        while ((p = branch_next_special(&record, branch, &at))) {
            assert_int_equal(p->kind, SALTUS_POINT_CH);
            check_near(p->value[0], 1, p->accuracy);
            held++;
        }
    assert_int_equal(held, 1);
    assert_int_equal(last_of(&record)->branch, 1);
    branch_forget(&record);
}

/* Beyond a birth whose impact is soon lost by the flow a long step leaps, and there is a fold on the way. */
static void folds_are_found_on_leaps(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_branch_options options = branch_along("omega", 0.547218, 0.702616);
    int found = 0;
    options.direction = 1;
    options.step = options.step_max = 0.1;
    options.points = 170;
    branch_record record =
        run_from("two-mass", "d=0.177159 r=0.807806 omega=0.576639 c=0.0785747", 0, NULL, &options);
    for (int k = 0; k < record.count; k++)
        found += record.point[k].kind == SALTUS_POINT_LP &&
                 fabs(record.point[k].value[0] - 0.584614829769) < 1e-11;
    assert_int_equal(found, 1);
    branch_forget(&record);
}

/* Where a branch joins orbits of half the period the row is theirs, no row beside it counts a multiplier by
 * rounding, and neither does the first one of a branch that leaves there. */
static void rows_beside_joins_count_no_rounding(void **unused) {
    (void)unused;
    saltus_branch_options options = branch_along("r", 0.483184, 1);
    int joins = 0;
    options.step = 0.02;
    options.step_max = 0.04;
    options.switches = 1;
    branch_record record =
        run_from("gear-rattle", "c=0.0735249 F0=0.0609808 A=0.886733 d=0.52657 r=0.854679 omega=1.26441", 0,
                 NULL, &options);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        assert_true(p->branch != 1 || p->unstable == 0);
        assert_true(p->parent < 0 || p->step > 0 || (p->unstable == 0 && !p->stable));
        if (p->branch != 1 || p->kind != SALTUS_POINT_PD || !strstr(p->reason, "joins"))
            continue;
        joins++;
        check_near(p->multipliers[0].re, 1, 1e-10);
    }
    assert_int_equal(joins, 1);
    branch_forget(&record);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(doubled_orbits_end_at_flips),
        cmocka_unit_test(a_pitchfork_has_one_name),
        cmocka_unit_test(runs_of_impacts_end_where_they_begin),
        cmocka_unit_test(one_of_two_chatters_completes),
        cmocka_unit_test(other_branches_are_not_gone_on_with),
        cmocka_unit_test(curves_of_grazing_count_all_impacts),
        cmocka_unit_test(a_long_transient_between_chatter),
        cmocka_unit_test(impacts_of_a_long_run_die_one_by_one),
        cmocka_unit_test(a_contact_splits_at_one_place),
        cmocka_unit_test(branches_leave_chatter_nearby),
        cmocka_unit_test(steps_do_not_matter),
        cmocka_unit_test(a_flip_beside_a_join_is_found),
        cmocka_unit_test(joins_are_where_the_other_branch_says),
        cmocka_unit_test(joined_branches_are_followed),
        cmocka_unit_test(a_branch_joined_twice_is_followed_once),
        cmocka_unit_test(a_third_and_a_quarter_graze),
        cmocka_unit_test(doubled_orbits_are_admissible_or_not_sought),
        cmocka_unit_test(halves_that_are_all_but_alike),
        cmocka_unit_test(where_hardly_anything_rebounds),
        cmocka_unit_test(what_hardly_rebounds_chatters),
        cmocka_unit_test(values_without_orbits_are_told),
        cmocka_unit_test(ranges_end_where_scenes_do),
        cmocka_unit_test(branches_leave_where_errors_grow),
        cmocka_unit_test(errors_grow_without_bound),
        cmocka_unit_test(impacts_rebound_as_told),
        cmocka_unit_test(a_short_run_completes),
        cmocka_unit_test(a_run_on_doubled_orbits_completes),
        cmocka_unit_test(chatter_joins_the_orbits_of_a_part),
        cmocka_unit_test(doubled_orbits_near_the_end_of_a_run),
        cmocka_unit_test(no_torus_begins_where_nothing_is_lost),
        cmocka_unit_test(a_second_chatter_completes),
        cmocka_unit_test(tori_between_the_grazings_of_a_run),
        cmocka_unit_test(a_torus_before_grazing),
        cmocka_unit_test(a_pair_turns_real_before_grazing),
        cmocka_unit_test(no_fold_is_where_a_branch_begins),
        cmocka_unit_test(no_fold_is_on_the_other_branch),
        cmocka_unit_test(nothing_is_named_within_rounding),
        cmocka_unit_test(folds_are_found_on_leaps),
        cmocka_unit_test(rows_beside_joins_count_no_rounding),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
