/* Limits of branches and searches: refusals of each wrong input, limits on either side, what remains after an
 * interruption, and places where a branch cannot go on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"

#include <float.h>

/* Two masses without stops. */
static saltus_spec free_masses(void) {
    saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 1.3);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "c2", 0.15);
    set_parameter(&spec, "F2", 0.2);
    return spec;
}

static const double rest[4] = {0};

static saltus_branch *open_branch(const saltus_spec *spec, const saltus_branch_options *options) {
    saltus_message message = {.text = ""};
    saltus_branch *branch = NULL;
    check_ok(saltus_branch_new(spec, 1, rest, options, &branch, &message), &message);
    return branch;
}

static void check_refused(const saltus_branch_options *options, const char *sentence) {
    saltus_spec spec = free_masses();
    saltus_message message = {.text = ""};
    saltus_branch *branch = NULL;
    assert_int_equal(saltus_branch_new(&spec, 1, rest, options, &branch, &message), SALTUS_BAD_INPUT);
    assert_null(branch);
    assert_string_equal(message.text, sentence);
}

/* A refusal names the offending numbers; values just within the limits are accepted. */
static void refusals_name_their_numbers(void **unused) {
    (void)unused;
    static double values[1001];
    saltus_spec spec = free_masses();
    saltus_branch_options fine = branch_along("omega", 1, 1.5), bad = fine;
    bad.low[0] = 1.4;
    check_refused(&bad, "omega=1.4:1.5: the range must hold the start, omega = 1.3");
    bad.high[0] = 1.25;
    check_refused(&bad, "omega=1.4:1.25: the range must go from low to high");
    bad = fine;
    bad.step = 0.03;
    check_refused(&bad, "step = 0.03, step_max = 0.02: must be in this order");
    bad.step_max = 1.01;
    check_refused(&bad, "step_max = 1.01: must be greater than 0 and at most 1");
    bad = fine;
    bad.points = 0;
    check_refused(&bad, "points = 0: must be from 1 to 10000000");
    bad = fine;
    bad.values = values;
    bad.value_count = -1;
    check_refused(&bad, "-1 values asked for: at most 1000 are possible");
    bad.value_count = 1001;
    check_refused(&bad, "1001 values asked for: at most 1000 are possible");
    bad = fine;
    bad.locus = SALTUS_POINT_LP;
    snprintf(bad.key[1], sizeof bad.key[1], "k");
    bad.low[1] = 1.1;
    bad.high[1] = 1.2;
    check_refused(&bad, "k=1.1:1.2: the range must hold the start, k = 1");
    bad.low[1] = 1.3;
    check_refused(&bad, "k=1.3:1.2: the range must go from low to high");
    bad.low[1] = 1 - DBL_MAX;
    bad.high[1] = INFINITY;
    check_refused(&bad, "k=-1.79769e+308:inf: the range must be finite");
    snprintf(bad.key[1], sizeof bad.key[1], "omega");
    check_refused(&bad, "omega and omega: a curve needs two parameters, not one twice");
    bad.locus = SALTUS_POINT_CH;
    check_refused(&bad, "locus = 6: must be none, LP, PD, NS, BP, GR, HB or BE");
    bad = fine;
    bad.low[0] = -INFINITY;
    check_refused(&bad, "omega=-inf:1.5: the range must be finite");
    for (int periods = -1; periods <= 0; periods++) {
        saltus_message message = {.text = ""};
        saltus_branch *branch = (saltus_branch *)1;
        assert_int_equal(saltus_branch_new(&spec, periods, rest, &fine, &branch, &message), SALTUS_BAD_INPUT);
        assert_null(branch);
        assert_non_null(strstr(message.text, "periods ="));
    }
    fine.values = values; /* none in the range */
    fine.value_count = 1000;
    fine.points = 1;
    fine.step = fine.step_max = 1;
    branch_record record = branch_run(&spec, 1, rest, &fine);
    assert_int_equal(record.count, 2); /* one point each way, its end */
    branch_forget(&record);
    /* The start may lie on a border of the range. */
    for (int up = 0; up < 2; up++) {
        saltus_branch_options border = branch_along("omega", up ? 1.2 : 1.3, up ? 1.3 : 1.4);
        saltus_branch_free(open_branch(&spec, &border));
    }
    assert_string_equal(saltus_point_word(SALTUS_POINT_KINDS), "");
    assert_string_equal(saltus_point_word((saltus_point_kind)-1), "");
    static const char *const words[] = {"",      "LP",    "PD",    "NS",    "BP",    "GR",    "CH",
                                        "ST",    "UZ",    "EP",    "HB",    "BE",    "CP",    "GR-LP",
                                        "GR-PD", "GR-NS", "GR-GR", "GR-BP", "CH-GR", "R1",    "R2",
                                        "R3",    "R4",    "BT",    "GH",    "GPD",   "LP-PD", "PD-NS"};
    for (int k = 0; k < SALTUS_POINT_KINDS; k++)
        assert_string_equal(saltus_point_word((saltus_point_kind)k), words[k]);
}

/* The default options. */
static void branches_have_their_defaults(void **unused) {
    (void)unused;
    saltus_branch_options o = saltus_branch_defaults();
    saltus_orbit_options orbit = saltus_orbit_defaults();
    assert_true(o.step == 0.005 && o.step_max == 0.02 && o.points == 2000);
    assert_true(o.direction == 0 && o.switches == 0 && o.value_count == 0 && !o.values);
    assert_true(o.locus == SALTUS_POINT_REGULAR && !o.key[0][0] && !o.key[1][0]);
    assert_true(o.orbit.iterations == orbit.iterations && o.orbit.tolerance == orbit.tolerance &&
                o.orbit.flow.rtol == orbit.flow.rtol && o.orbit.segments == 0 && !o.orbit.history);
}

/* A finished branch stays finished; the caller's specification, state and options are not changed. */
static void what_is_done_stays_done(void **unused) {
    (void)unused;
    saltus_spec spec = free_masses();
    saltus_message message = {.text = ""};
    saltus_branch_options options = branch_along("omega", 1.2, 1.4);
    double state[4] = {0};
    branch_record whole = branch_run(&spec, 1, state, &options);
    saltus_branch *branch = NULL;
    check_ok(saltus_branch_new(&spec, 1, state, &options, &branch, &message), &message);
    memset(&spec, 0, sizeof spec);
    memset(&options, 0, sizeof options);
    state[0] = NAN;
    branch_record record = branch_collect(branch, branch_points_max);
    assert_int_equal(record.count, whole.count);
    for (int k = 0; k < record.count; k++)
        assert_memory_equal(record.point[k].state, whole.point[k].state, 4 * sizeof(double));
    for (int again = 0; again < 2; again++) {
        const saltus_branch_point *point = &record.point[0];
        check_ok(saltus_branch_step(branch, &point, &message), &message);
        assert_null(point);
    }
    saltus_branch_free(branch);
    saltus_branch_free(NULL);
    branch_forget(&whole);
    branch_forget(&record);
}

/* A request to stop is noticed between points, and also before there is an orbit. When it is withdrawn the
 * branch goes on as if nothing had happened. */
static void interrupted_and_gone_on(void **unused) {
    (void)unused;
    volatile sig_atomic_t stop = 0;
    saltus_spec spec = free_masses();
    saltus_message message = {.text = ""};
    saltus_branch_options options = branch_along("omega", 1, 1.5);
    branch_record whole = branch_run(&spec, 1, rest, &options);
    options.orbit.flow.stop = &stop;
    saltus_branch *branch = open_branch(&spec, &options);
    int refused = 0;
    for (int k = 0; k < whole.count; k++) {
        const saltus_branch_point *point = &whole.point[0];
        stop = k % 3 == 1;
        saltus_status status = saltus_branch_step(branch, &point, &message);
        if (stop && status != SALTUS_OK) {
            assert_int_equal(status, SALTUS_INTERRUPTED);
            assert_string_equal(message.text, "interrupted");
            assert_null(point);
            refused++;
            stop = 0;
            status = saltus_branch_step(branch, &point, &message);
        }
        check_ok(status, &message);
        assert_non_null(point);
        assert_int_equal(point->kind, whole.point[k].kind);
        assert_true(point->value[0] == whole.point[k].value[0]);
        assert_memory_equal(point->state, whole.point[k].state, 4 * sizeof *point->state);
    }
    assert_true(refused > 5);
    saltus_branch_free(branch);
    stop = 1;
    assert_int_equal(saltus_branch_new(&spec, 1, rest, &options, &branch, &message), SALTUS_INTERRUPTED);
    assert_null(branch);
    branch_forget(&whole);
}

/* A branch ignores the section phase of a search and the tangent columns of a flow. */
static void options_that_do_not_matter(void **unused) {
    (void)unused;
    saltus_spec spec = free_masses();
    saltus_branch_options options = branch_along("omega", 1, 1.5);
    branch_record one = branch_run(&spec, 1, rest, &options);
    options.orbit.phase = 0.37;
    options.orbit.flow.columns = 3;
    branch_record other = branch_run(&spec, 1, rest, &options);
    assert_int_equal(one.count, other.count);
    for (int k = 0; k < one.count; k++) {
        assert_true(one.point[k].value[0] == other.point[k].value[0]);
        assert_memory_equal(one.point[k].state, other.point[k].state, 4 * sizeof(double));
    }
    branch_forget(&one);
    branch_forget(&other);
}

/* Saved numbers with one changed, or truncated, are refused or accepted. What is accepted can be continued:
 * no number read leads out of bounds. */
static void damaged_numbers_are_refused(void **unused) {
    (void)unused;
    static const double wrong[] = {NAN, INFINITY, -1, 0.5, 1e9, 1e300};
    saltus_spec spec = free_masses();
    saltus_message message = {.text = ""};
    saltus_branch_options options = branch_along("omega", 1, 1.5);
    const saltus_branch_point *point;
    double *numbers;
    int count, kept, refused = 0, taken = 0;
    saltus_branch *branch = open_branch(&spec, &options);
    for (int k = 0; k < 3; k++)
        check_ok(saltus_branch_step(branch, &point, &message), &message);
    check_ok(saltus_branch_save(branch, &numbers, &count, &message), &message);
    saltus_branch_free(branch);
    assert_true(count > 30);
    for (int k = 0; k < count; k++) {
        branch = open_branch(&spec, &options);
        assert_int_equal(saltus_branch_resume(branch, numbers, k, &kept, &message), SALTUS_BAD_INPUT);
        saltus_branch_free(branch);
        for (size_t w = 0; w < sizeof wrong / sizeof wrong[0]; w++) {
            double was = numbers[k];
            numbers[k] = wrong[w];
            branch = open_branch(&spec, &options);
            saltus_status status = saltus_branch_resume(branch, numbers, count, &kept, &message);
            assert_true(status == SALTUS_OK || status == SALTUS_BAD_INPUT);
            refused += status != SALTUS_OK;
            taken += status == SALTUS_OK;
            if (status == SALTUS_OK)
                saltus_branch_step(branch, &point, &message);
            saltus_branch_free(branch);
            numbers[k] = was;
        }
    }
    assert_true(refused > taken && taken > 0);
    branch = open_branch(&spec, &options);
    check_ok(saltus_branch_resume(branch, numbers, count, &kept, &message), &message);
    assert_int_equal(kept, 3);
    saltus_branch_free(branch);
    free(numbers);
}

/* Resumed after any of its points, a network of curves has the same next points to the last bit, also if the
 * very next one is of codimension two. */
static void gone_on_with_after_every_point(void **unused) {
    (void)unused;
    enum { points_max = 400, ahead = 3, numbers = 3 };
    static const char *const settings[] = {"c=0.12504", "F=1.1739",  "F0=0.11951",
                                           "d=0.42605", "r=0.40661", "omega=2.0486"};
    static double seen[points_max][numbers], *saved[points_max];
    static int saved_count[points_max];
    saltus_scene scene = {0};
    saltus_message message = {.text = ""};
    saltus_motion motion = {0};
    const saltus_classify_options how = saltus_classify_defaults();
    const saltus_branch_point *point = NULL;
    double start[4];
    check_ok(saltus_scene_load("impact-oscillator", &scene, &message), &message);
    for (size_t k = 0; k < sizeof settings / sizeof settings[0]; k++)
        check_ok(saltus_scene_set(&scene, settings[k], &message), &message);
    saltus_system *system = build(&scene.spec);
    check_ok(saltus_scene_state(&scene, system, start, &message), &message);
    check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
    saltus_branch_options options = branch_along("omega", 1.2292, 3.2778);
    strcpy(options.key[1], "d");
    options.low[1] = 0.12782;
    options.high[1] = 0.85211;
    options.locus = SALTUS_POINT_LP;
    options.switches = 1;
    options.step_max = 0.05;
    int count = 0, tried = 0, corners = 0;
    for (int from = -1; from < count; from++) {
        saltus_branch *branch = NULL;
        if (from >= 0 && saved_count[from] == 0)
            continue;
        check_ok(saltus_branch_new(&scene.spec, motion.periods, motion.state, &options, &branch, &message),
                 &message);
        int next = 0;
        if (from >= 0)
            check_ok(saltus_branch_resume(branch, saved[from], saved_count[from], &next, &message), &message);
        for (int k = 0; from < 0 || k < ahead; k++, next++) {
            check_ok(saltus_branch_step(branch, &point, &message), &message);
            if (!point)
                break;
            const double told[numbers] = {point->value[0], point->value[1], point->arclength};
            assert_true(next < points_max);
            if (from < 0) {
                memcpy(seen[next], told, sizeof told);
                check_ok(saltus_branch_save(branch, &saved[next], &saved_count[next], &message), &message);
                count = next + 1;
            } else {
                assert_memory_equal(seen[next], told, sizeof told);
                corners += k == 0 && point->kind >= SALTUS_POINT_CP;
            }
        }
        tried += from >= 0;
        saltus_branch_free(branch);
    }
    assert_true(tried > 100 && corners > 5);
    for (int k = 0; k < count; k++)
        free(saved[k]);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

/* What a run has taken beyond the usual goes with it: of a branch into forcing that is ever slower, gone on
 * with before it is given up, the same is kept as of the whole run, and the end is the same. */
static void a_run_gone_on_with_has_taken_as_much(void **unused) {
    (void)unused;
    enum { points_max = 200, back = 3 };
    skip_where_slow();
    saltus_scene scene = {0};
    saltus_message message = {.text = ""};
    saltus_motion motion = {0};
    const saltus_classify_options how = saltus_classify_defaults();
    const saltus_branch_point *point = NULL;
    double start[2], *saved[points_max] = {NULL};
    int saved_count[points_max] = {0}, count = 0;
    char reason[sizeof point->reason] = "";
    check_ok(saltus_scene_load("duffing", &scene, &message), &message);
    saltus_system *system = build(&scene.spec);
    check_ok(saltus_scene_state(&scene, system, start, &message), &message);
    check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
    const saltus_branch_options options = branch_along("omega", 1e-9, 1.2);
    for (int again = 0; again < 2; again++) {
        saltus_branch *branch = NULL;
        int next = 0;
        check_ok(saltus_branch_new(&scene.spec, motion.periods, motion.state, &options, &branch, &message),
                 &message);
        if (again)
            check_ok(
                saltus_branch_resume(branch, saved[count - back], saved_count[count - back], &next, &message),
                &message);
        do {
            double *numbers;
            int number_count;
            check_ok(saltus_branch_step(branch, &point, &message), &message);
            assert_true(point && next < points_max);
            check_ok(saltus_branch_save(branch, &numbers, &number_count, &message), &message);
            if (again) {
                assert_int_equal(number_count, saved_count[next]);
                assert_memory_equal(numbers, saved[next], (size_t)number_count * sizeof *numbers);
                free(numbers);
            } else {
                saved[next] = numbers;
                saved_count[next] = number_count;
            }
            next++;
        } while (!strstr(point->reason, "given up: "));
        if (again) {
            assert_int_equal(next, count);
            assert_string_equal(point->reason, reason);
        }
        count = next;
        snprintf(reason, sizeof reason, "%s", point->reason);
        saltus_branch_free(branch);
    }
    for (int k = 0; k < count; k++)
        free(saved[k]);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

/* A requested value that a step meets exactly is reported there, and the rest of the run is unchanged. */
static void values_met_exactly(void **unused) {
    (void)unused;
    saltus_spec spec = free_masses();
    saltus_branch_options options = branch_along("omega", 1, 1.5);
    branch_record plain = branch_run(&spec, 1, rest, &options);
    double values[2] = {plain.point[4].value[0], plain.point[7].value[0]};
    options.values = values;
    options.value_count = 2;
    branch_record record = branch_run(&spec, 1, rest, &options);
    int found = 0;
    for (int k = 0, i = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->kind == SALTUS_POINT_UZ) {
            assert_true(fabs(p->value[0] - values[found]) < 1e-13);
            assert_true(p->accuracy >= 0 && p->accuracy < 1e-12);
            found++;
            continue;
        }
        check_near(p->value[0], plain.point[i].value[0], 1e-12);
        assert_int_equal(p->kind, plain.point[i++].kind);
    }
    assert_int_equal(found, 2);
    branch_forget(&plain);
    branch_forget(&record);
}

/* However long steps may be, they follow the curve: they are cut where it turns, and grow where Newton's
 * method converges easily. */
static void long_steps_follow_the_curve(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 0.5);
    saltus_system *system = build(&spec);
    const double *scale = saltus_system_scale(system);
    saltus_branch_options options = branch_along("omega", 0.2, 2);
    options.direction = 1;
    options.step = 0.01;
    options.step_max = 0.3;
    branch_record record = branch_run(&spec, 1, rest, &options);
    assert_true(record.count > 20);
    for (int k = 1; k + 1 < record.count; k++) {
        const saltus_branch_point *a = &record.point[k - 1], *b = a + 1, *c = a + 2;
        double square = pow((b->value[0] - a->value[0]) / 1.8, 2), ahead = b->arclength - a->arclength,
               next = c->arclength - b->arclength;
        for (int i = 0; i < 2; i++)
            square += pow((b->state[i] - a->state[i]) / scale[i], 2);
        assert_true(ahead <= sqrt(square) * (1 + 1e-9));
        assert_true(ahead >= 0.96 * sqrt(square));
        if (c->kind != SALTUS_POINT_REGULAR)
            continue;
        /* Up to halvings. */
        double ratio = log2(next / ahead / (b->iterations <= 3 ? 1.5 : b->iterations > 5 ? 0.6 : 1));
        assert_true(ratio < 1e-9);
        double capped = log2(next / options.step_max);
        check_near(fmin(fabs(ratio - round(ratio)), fabs(capped - round(capped))), 0, 1e-9);
    }
    branch_forget(&record);
    saltus_system_free(system);
}

/* A mass without rebound rests on its table until the table falls faster than the mass. Then it flies once a
 * period and comes to rest again, until it lands while the table throws it off; that orbit flips. */
static void a_dead_mass_leaves_its_table(void **unused) {
    (void)unused;
    static const saltus_point_kind kinds[] = {SALTUS_POINT_ST, SALTUS_POINT_ST, SALTUS_POINT_PD};
    const double values[] = {1, hypot(1, M_PI), (double)closed_table_flip(1, 0)};
    static const char *const before[] = {"held", "1/1", "1/1"};
    static const int sticks[] = {0, 1, 0};
    saltus_spec spec = oscillator_spec(0, 0, 0.8, 1);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, 0, 0, SALTUS_LOWER);
    saltus_branch_options options = branch_along("F", 0.5, 4);
    options.direction = 1;
    branch_record record = branch_run(&spec, 1, rest, &options);
    for (int k = 0, from = 0; k < 3; k++) {
        const saltus_branch_point *point = branch_next_special(&record, 0, &from);
        assert_true(point && point->kind == kinds[k]);
        check_near(point->value[0], values[k], 1e-9);
        assert_string_equal(point->label, before[k]);
        assert_string_equal(point->label_after, k < 2 ? "1/1" : "");
        assert_int_equal(point->sticking_intervals, sticks[k]);
        /* The bracket is halved in arclength, to 1e-12; the accuracy is that width in the parameter, plus the
         * flow's tolerance and rounding. */
        double flow = options.orbit.flow.rtol * 3.5 + DBL_EPSILON * values[k];
        double width = (point->accuracy - flow) / fabs(point->heading);
        assert_true(k == 2 || (width > 1e-13 && width < 1.001e-12));
    }
    int part = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        part += p->kind == SALTUS_POINT_ST;
        if (p->kind == SALTUS_POINT_REGULAR) {
            assert_true(p->admissible);
            assert_int_equal(p->sticking_intervals, part == 1);
            assert_int_equal(p->event_count, part == 0 ? 0 : part == 1 ? 2 : 1);
        }
    }
    assert_string_equal(record.point[record.count - 1].reason, "end of the parameter's range");
    branch_forget(&record);
}

/* With rebound it comes to rest by complete chatter. Where that is no longer complete the impacts die one by
 * one, and orbits with the last one have the fold and the flip of the closed form. */
static void the_impacts_of_a_table_die_one_by_one(void **unused) {
    (void)unused;
    const long double r = 0.3L;
    saltus_spec spec = oscillator_spec(0, 0, 0.8, 1);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, 0, (double)r, SALTUS_LOWER);
    saltus_branch_options options = branch_along("F", 0.7, 3);
    options.direction = 1;
    branch_record record = branch_run(&spec, 1, rest, &options);
    int from = 0, impacts;
    const saltus_branch_point *point = branch_next_special(&record, 0, &from);
    assert_true(point && point->kind == SALTUS_POINT_CH);
    check_near(point->value[0], 1, 1e-9);
    assert_string_equal(point->label, "held");
    point = branch_next_special(&record, 0, &from);
    assert_true(point && point->kind == SALTUS_POINT_CH);
    assert_string_equal(point->label, "chatter/1");
    assert_int_equal(sscanf(point->label_after, "%d/1", &impacts), 1);
    assert_true(impacts > 5);
    const saltus_branch_point *fold = NULL, *flip = NULL;
    while ((point = branch_next_special(&record, 0, &from))) {
        char label[SALTUS_LABEL_MAX];
        snprintf(label, sizeof label, "%d/1", impacts);
        assert_string_equal(point->label, label);
        assert_int_equal(point->impacts, impacts);
        if (point->kind == SALTUS_POINT_GR) {
            assert_non_null(strstr(point->reason, "an impact dies"));
            snprintf(label, sizeof label, "%d/1", --impacts);
            assert_string_equal(point->label_after, label);
        }
        fold = point->kind == SALTUS_POINT_LP ? point : fold;
        flip = point->kind == SALTUS_POINT_PD ? point : flip;
    }
    assert_int_equal(impacts, 1);
    assert_true(fold && flip);
    check_near(fold->value[0], (double)closed_table_fold(1, r), 1e-9);
    check_near(flip->value[0], (double)closed_table_flip(1, r), 1e-9);
    branch_forget(&record);
}

/* A mass without a spring that a steady force pulls away from its stop has no equilibrium: from a guess on
 * the stop the contact force is the reason, from elsewhere that every position is possible. */
static void nothing_to_rest_on(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 0, 0, 1);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, 0.4, 0.5, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_equilibrium_options options = saltus_equilibrium_defaults();
    for (int touches = 0; touches < 2; touches++) {
        saltus_message message = {.text = ""};
        saltus_equilibrium e;
        const double guess[2] = {touches ? 0.4 : 0.1, 0};
        assert_int_equal(saltus_equilibrium_find(system, guess, &options, &e, &message),
                         touches ? SALTUS_NO_CONVERGENCE : SALTUS_SINGULAR);
        assert_non_null(strstr(message.text, touches ? "contact forces push" : "not isolated"));
        assert_null(e.state);
    }
    saltus_system_free(system);
}

/* The straight pipe with pulsating flow buckles to either side, even if a stop far away on one side makes the
 * scene asymmetric: branches leave both ways, to orbits that mirror each other. */
static void straight_pipe_buckles_both_ways(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(1, 20);
    const double values[] = {3.3, 3.4};
    double state[2][2][2];
    int seen[2][2] = {{0}};
    set_parameter(&spec, "u0", 3);
    add_stop(&spec, 1, 0.5, SALTUS_UPPER);
    saltus_branch_options options = branch_along("u0", 2.9, 3.45);
    options.direction = 1;
    options.switches = 1;
    options.values = values;
    options.value_count = 2;
    for (int segments = 1; segments <= 3; segments += 2) {
        options.orbit.segments = segments;
        branch_record record = branch_run(&spec, 1, rest, &options);
        int from = 0;
        const saltus_branch_point *crossing = branch_next_special(&record, 0, &from);
        assert_true(crossing && crossing->kind == SALTUS_POINT_BP);
        check_near(crossing->multipliers[0].re, 1, 1e-7);
        memset(seen, 0, sizeof seen);
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            assert_in_range(p->branch, 0, 2);
            assert_int_equal(p->parent, p->branch ? 0 : -1);
            if (p->branch && p->step == 0) {
                check_near(p->value[0], crossing->value[0], 1e-9);
                assert_int_equal(p->iterations, 0); /* no correction is needed */
            }
            if (p->branch == 0)
                assert_true(p->state[0] == 0 && p->stable == (p->value[0] < crossing->value[0]));
            for (int v = 0; v < 2 && p->kind == SALTUS_POINT_UZ && p->branch; v++)
                if (fabs(p->value[0] - values[v]) < 1e-12) {
                    memcpy(state[p->branch - 1][v], p->state, 2 * sizeof(double));
                    seen[p->branch - 1][v]++;
                    assert_true(p->stable && p->admissible);
                }
        }
        for (int v = 0; v < 2; v++) {
            assert_true(seen[0][v] == 1 && seen[1][v] == 1);
            for (int i = 0; i < 2; i++)
                check_near(state[0][v][i], -state[1][v][i], 1e-10);
            assert_true(fabs(state[0][v][0]) > 1e-3);
        }
        branch_forget(&record);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refusals_name_their_numbers),
        cmocka_unit_test(branches_have_their_defaults),
        cmocka_unit_test(what_is_done_stays_done),
        cmocka_unit_test(interrupted_and_gone_on),
        cmocka_unit_test(options_that_do_not_matter),
        cmocka_unit_test(damaged_numbers_are_refused),
        cmocka_unit_test(gone_on_with_after_every_point),
        cmocka_unit_test(a_run_gone_on_with_has_taken_as_much),
        cmocka_unit_test(values_met_exactly),
        cmocka_unit_test(long_steps_follow_the_curve),
        cmocka_unit_test(a_dead_mass_leaves_its_table),
        cmocka_unit_test(the_impacts_of_a_table_die_one_by_one),
        cmocka_unit_test(nothing_to_rest_on),
        cmocka_unit_test(straight_pipe_buckles_both_ways),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
