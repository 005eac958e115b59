/* The frame of a sweep: points, passes, tasks and places, initial states and what is carried from point to
 * point, seeds and their attractors, the feed, what is kept, options and their limits, basins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "closed_orbits.h"
#include "sweep_check.h"

#include <stdatomic.h>

static saltus_sweep_options frame_options(unsigned keep, unsigned passes, int seeds) {
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = keep;
    options.passes = passes;
    options.seeds = seeds;
    options.threads = 1;
    return options;
}

/* Nothing runs before the recording: the first section point kept is where the trajectory starts. */
static saltus_sweep_options at_once(unsigned passes, int seeds, long long record) {
    saltus_sweep_options options = frame_options(SALTUS_KEEP_STROBOSCOPIC, passes, seeds);
    options.adaptive = false;
    options.transient = 0;
    options.record = record;
    return options;
}

static outcome run_all(const saltus_sweep *sweep) {
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    return o;
}

static saltus_status make(const saltus_scene *scene, const saltus_axis *axes, int count,
                          const saltus_sweep_options *options) {
    saltus_sweep *sweep = NULL;
    saltus_message message = {""};
    saltus_status status = saltus_sweep_new(scene, axes, count, options, &sweep, &message);
    assert_true((status == SALTUS_OK) == (sweep != NULL));
    assert_true(status == SALTUS_OK || strlen(message.text) > 10);
    saltus_sweep_free(sweep);
    return status;
}

static void axes_are_even_in_values_or_in_their_logarithms(void **unused) {
    (void)unused;
    saltus_message message = {""};
    saltus_axis axis;
    double *list;
    for (int count = 2; count < 9; count++) {
        char text[64];
        snprintf(text, sizeof text, "d=3:-1:%d", count);
        check_ok(saltus_axis_read(text, &axis, &list, &message), &message);
        assert_true(axis.spacing == SALTUS_LINEAR && axis.low == 3 && axis.high == -1 && !axis.list);
        for (int k = 0; k < count; k++)
            check_near(saltus_axis_value(&axis, k), 3 - 4.0 * k / (count - 1), 1e-15);
        snprintf(text, sizeof text, "d=1e-3:50:%d:log", count);
        check_ok(saltus_axis_read(text, &axis, &list, &message), &message);
        assert_true(axis.spacing == SALTUS_LOGARITHMIC && axis.low == 1e-3 && axis.high == 50);
        for (int k = 0; k < count; k++)
            check_near(log(saltus_axis_value(&axis, k)), log(1e-3) + log(5e4) * k / (count - 1), 1e-13);
        assert_true(saltus_axis_value(&axis, count - 1) == 50);
    }
    check_ok(saltus_axis_read("d=4,-1,4,7", &axis, &list, &message), &message);
    assert_true(axis.spacing == SALTUS_LIST && axis.count == 4 && axis.list == list);
    assert_true(list[0] == 4 && list[1] == -1 && list[2] == 4 && list[3] == 7);
    free(list);
    axis = (saltus_axis){.key = "d", .count = 1, .low = 2, .high = 5};
    assert_true(saltus_axis_value(&axis, 0) == 2);
}

static void axes_are_read_up_to_their_limits(void **unused) {
    (void)unused;
    static const struct {
        const char *text;
        bool good;
    } cases[] = {{"d=0:1:2", true},          {"d=0:1:10000000", true},    {"d=0:1:10000001", false},
                 {"d=0:1:1", false},         {"abcdefghijklmno=1", true}, {"abcdefghijklmnop=1", false},
                 {"d=1e-300:1:3:log", true}, {"d=0:1:3:log", false},      {"d=1:0:3:log", false}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_message message = {""};
        saltus_axis axis;
        double *list;
        saltus_status status = saltus_axis_read(cases[k].text, &axis, &list, &message);
        if ((status == SALTUS_OK) != cases[k].good)
            fail_msg("%s: %s", cases[k].text, saltus_status_name(status));
        assert_true(status == SALTUS_OK || strstr(message.text, cases[k].text));
        free(list);
    }
}

static void options_are_taken_up_to_their_limits(void **unused) {
    (void)unused;
    const saltus_scene scene = scene_of("impact-oscillator", "");
    const saltus_axis axes[3] = {{.key = "omega", .count = 2, .low = 1, .high = 2},
                                 {.key = "d", .count = 2, .low = 1, .high = 2},
                                 {.key = "r", .count = 2, .low = 0.5, .high = 0.6}};
    const saltus_sweep_options good = saltus_sweep_defaults();
    assert_int_equal(make(&scene, axes, 0, &good), SALTUS_BAD_INPUT);
    assert_int_equal(make(&scene, axes, 1, &good), SALTUS_OK);
    assert_int_equal(make(&scene, axes, 2, &good), SALTUS_OK);
    assert_int_equal(make(&scene, axes, 3, &good), SALTUS_BAD_INPUT);
#define check_limits(member, low, high, beyond)                                                              \
    do {                                                                                                     \
        saltus_sweep_options o = good;                                                                       \
        o.member = (low);                                                                                    \
        assert_int_equal(make(&scene, axes, 1, &o), SALTUS_OK);                                              \
        o.member = (high);                                                                                   \
        assert_int_equal(make(&scene, axes, 1, &o), SALTUS_OK);                                              \
        o.member = (low)-1;                                                                                  \
        assert_int_equal(make(&scene, axes, 1, &o), SALTUS_BAD_INPUT);                                       \
        o.member = (beyond);                                                                                 \
        assert_int_equal(make(&scene, axes, 1, &o), SALTUS_BAD_INPUT);                                       \
    } while (0)
    check_limits(seeds, 1, 10000, 10001);
    check_limits(longest, 1, 256, 257);
    check_limits(passes, 1, 7, 8);
    check_limits(transient, 1, 1000000000, -5);
    check_limits(record, 1, 1000000000, -5);
    check_limits(measure, 0, 1000000000, -5);
    check_limits(lanes, 0, 64, -5);
    check_limits(threads, 0, 64, -5);
    saltus_sweep_options fixed = good;
    fixed.adaptive = false;
    fixed.transient = 0;
    assert_int_equal(make(&scene, axes, 1, &fixed), SALTUS_OK);
    fixed.transient = -1;
    assert_int_equal(make(&scene, axes, 1, &fixed), SALTUS_BAD_INPUT);
    saltus_axis none = axes[0];
    none.count = 0;
    assert_int_equal(make(&scene, &none, 1, &good), SALTUS_BAD_INPUT);
    /* A thousand million rows, and no more. */
    const saltus_axis wide[2] = {{.key = "omega", .count = 10000, .low = 1, .high = 2},
                                 {.key = "d", .count = 10, .low = 1, .high = 2}};
    saltus_sweep_options many = good;
    many.seeds = 10000;
    assert_int_equal(make(&scene, wide, 2, &many), SALTUS_OK);
    many.passes = 3;
    assert_int_equal(make(&scene, wide, 2, &many), SALTUS_BAD_INPUT);
    many.passes = 1;
    const saltus_axis wider[2] = {wide[0], {.key = "d", .count = 11, .low = 1, .high = 2}};
    assert_int_equal(make(&scene, wider, 2, &many), SALTUS_BAD_INPUT);
}

static void defaults_are_those_promised(void **unused) {
    (void)unused;
    const saltus_sweep_options o = saltus_sweep_defaults();
    assert_true(o.flow.rtol == 1e-10 && o.flow.atol == 1e-14 && o.keep == 0 && o.seeds == 1);
    assert_true(o.passes == 1u << SALTUS_PASS_RESET && o.adaptive && o.transient == 2000 && o.record == 100);
    assert_true(o.measure == 8000 && o.longest == 20 && o.lanes == 0 && o.threads == 0);
}

static void a_sweep_keeps_what_it_was_given(void **unused) {
    (void)unused;
    const saltus_scene scene = scene_of("impact-oscillator", "d=0.7");
    double values[3] = {1.5, 1.1, 1.3};
    saltus_axis axes[2] = {
        {.key = "omega", .spacing = SALTUS_LIST, .count = 3, .low = 1.5, .high = 1.3, .list = values},
        {.key = "r", .count = 4, .low = 0.9, .high = 0.6}};
    saltus_sweep_options options = frame_options(7, 6, 2);
    saltus_sweep *sweep = NULL;
    saltus_message message = {""};
    sig_atomic_t stop = 1;
    options.flow.columns = 2;
    options.flow.directions = 1;
    options.flow.stop = &stop;
    check_ok(saltus_sweep_new(&scene, axes, 2, &options, &sweep, &message), &message);
    values[0] = values[1] = values[2] = -1;
    assert_int_equal(saltus_sweep_axis_count(sweep), 2);
    assert_string_equal(saltus_sweep_axis(sweep, 0)->key, "omega");
    assert_string_equal(saltus_sweep_axis(sweep, 1)->key, "r");
    assert_int_equal(saltus_sweep_points(sweep), 12);
    assert_int_equal(saltus_sweep_pass_count(sweep), 2);
    assert_true(saltus_sweep_pass_at(sweep, 0) == SALTUS_PASS_UP);
    assert_true(saltus_sweep_pass_at(sweep, 1) == SALTUS_PASS_DOWN);
    assert_int_equal(saltus_sweep_rows(sweep), 2 * 12 * 2);
    assert_int_equal(saltus_sweep_dimension(sweep), 2);
    assert_string_equal(saltus_sweep_scene(sweep)->name, scene.name);
    assert_true(saltus_sweep_choices(sweep)->seeds == 2 && saltus_sweep_choices(sweep)->keep == 7);
    static const double omegas[3] = {1.5, 1.1, 1.3};
    for (int point = 0; point < 12; point++) {
        saltus_scene here;
        check_ok(saltus_sweep_scene_at(sweep, point, &here, &message), &message);
        assert_true(saltus_spec_get(&here.spec, "omega") == omegas[point % 3]);
        check_near(here.spec.stops[0].r, 0.9 - 0.1 * (point / 3), 1e-15);
        assert_true(here.spec.stops[0].d == 0.7);
    }
    /* Columns, directions and the stop of the flow are the sweep's own business. */
    outcome with = run_all(sweep);
    saltus_sweep_free(sweep);
    options.flow = saltus_sweep_defaults().flow;
    memcpy(values, omegas, sizeof values);
    check_ok(saltus_sweep_new(&scene, axes, 2, &options, &sweep, &message), &message);
    outcome without = run_all(sweep);
    with.sweep = sweep;
    check_same_bits(&with, &without, "columns asked for");
    close_outcome(&with);
    close_outcome(&without);
    saltus_sweep_free(sweep);
    saltus_sweep_free(NULL);
}

static void words_and_labels(void **unused) {
    (void)unused;
    static const char *const words[SALTUS_VERDICTS] = {
        "pending", NULL,          "equilibrium", "held",  "quasi-periodic",
        "chaotic", "long-period", "undecided",   "failed"};
    char label[32];
    assert_string_equal(saltus_pass_word(SALTUS_PASS_RESET), "reset");
    assert_string_equal(saltus_pass_word(SALTUS_PASS_UP), "up");
    assert_string_equal(saltus_pass_word(SALTUS_PASS_DOWN), "down");
    for (int v = 0; v < SALTUS_VERDICTS; v++) {
        saltus_sweep_row row = {.verdict = v, .impacts = 3, .periods = 2};
        saltus_sweep_label(&row, label);
        assert_string_equal(label, words[v] ? words[v] : "3/2");
        assert_true(saltus_sweep_settled(&row) ==
                    (v == SALTUS_ROW_PERIODIC || v == SALTUS_ROW_EQUILIBRIUM || v == SALTUS_ROW_HELD));
    }
    saltus_sweep_row row = {.verdict = SALTUS_ROW_PERIODIC, .impacts = -1, .periods = 5};
    saltus_sweep_label(&row, label);
    assert_string_equal(label, "chatter/5");
    row.impacts = 0;
    saltus_sweep_label(&row, label);
    assert_string_equal(label, "0/5");
}

/* Every place belongs to one task; a point of a reset pass is one, a line of another pass one in its order.
 */
static void tasks_cover_all_places_once(void **unused) {
    (void)unused;
    const saltus_scene scene = scene_of("impact-oscillator", "");
    for (unsigned passes = 1; passes < 8; passes++)
        for (int second = 0; second < 2; second++) {
            saltus_sweep_options options = frame_options(0, passes, 2);
            saltus_sweep *sweep = sweep_of(&scene, "omega=1:2:4", second ? "d=1:2:3" : NULL, &options);
            const long long points = second ? 12 : 4, lines = second ? 3 : 1;
            long long seen[3 * 12] = {0}, task = 0;
            assert_int_equal(saltus_sweep_points(sweep), points);
            for (int k = 0; k < saltus_sweep_pass_count(sweep); k++) {
                saltus_pass pass = saltus_sweep_pass_at(sweep, k);
                assert_true(passes >> pass & 1);
                for (long long t = 0; t < (pass == SALTUS_PASS_RESET ? points : lines); t++, task++) {
                    int length = pass == SALTUS_PASS_RESET ? 1 : 4;
                    assert_int_equal(saltus_sweep_task_length(sweep, task), length);
                    for (int i = 0; i < length; i++) {
                        long long along = pass == SALTUS_PASS_DOWN ? 3 - i : i,
                                  place = saltus_sweep_task_place(sweep, task, i);
                        assert_int_equal(place, k * points + (length == 1 ? t : 4 * t + along));
                        seen[place]++;
                    }
                }
            }
            assert_int_equal(saltus_sweep_tasks(sweep), task);
            for (long long p = 0; p < points * saltus_sweep_pass_count(sweep); p++)
                assert_int_equal(seen[p], 1);
            saltus_sweep_free(sweep);
        }
}

/* The state behind a stop goes back onto it along its normal. */
static void onto_the_stop(const saltus_system *system, double *state) {
    const double *normal = saltus_system_stop_normal(system, 0);
    double gap = saltus_system_gap(system, 0, state), square = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        square += normal[i] * normal[i];
    for (int i = 0; i < saltus_system_dof(system) && gap > 0; i++)
        state[i] -= saltus_system_face(system, 0).side * gap * normal[i] / square;
}

/* Rows and clouds of two results, place and number of the attractor apart. */
static void check_same_result(const saltus_sweep *sweep, const saltus_sweep_result *a,
                              const saltus_sweep_result *b) {
    saltus_sweep_result copy = *b;
    copy.place = a->place;
    size_t size = saltus_sweep_packed_size(sweep, a);
    assert_int_equal(saltus_sweep_packed_size(sweep, &copy), size);
    unsigned char *x = calloc(size, 1), *y = calloc(size, 1);
    assert_true(x && y);
    saltus_sweep_pack(sweep, a, x);
    saltus_sweep_pack(sweep, &copy, y);
    assert_memory_equal(x, y, size);
    free(x);
    free(y);
}

typedef struct line_case {
    const char *scene, *settings, *first, *second;
} line_case;

static const line_case lines[] = {{"impact-oscillator", "", "omega=1.1:1.5:4", "r=0.8,0.6"},
                                  {"impact-oscillator", "c=0.02 d=0.016", "omega=3:3.1:4", NULL},
                                  {"pipe", "N=3 omega=20", "d=0.03:-0.03:4", NULL},
                                  {"two-mass", "omega=0.5", "d=0.3:-0.3:4", NULL},
                                  {"impact-oscillator", "omega=0.5", "d=0.7:0.1:4", NULL},
                                  {"impact-oscillator", "sides=lower omega=0.5 F=-0.5", "d=0.7:0.1:4", NULL}};

/* One point of a reset pass, from a scene's own state. */
static outcome run_point(const saltus_sweep *sweep, long long point) {
    saltus_message message = {""};
    outcome one = open_outcome(sweep);
    one.first = point;
    one.step = one.tasks = 1;
    saltus_sweep_feed feed = {.context = &one, .next = next_task, .take = keep_result};
    check_ok(saltus_sweep_run(sweep, &feed, &message), &message);
    return one;
}

/* The states that trajectories along a line start from, by hand, are those they do start from; what follows
 * has the same bits as a trajectory that starts there by itself. */
static int follow_line(const line_case *c, const outcome *all, long long task, bool adaptive) {
    const saltus_sweep *sweep = all->sweep;
    const int n = saltus_sweep_dimension(sweep), count = saltus_sweep_axis(sweep, 0)->count;
    const long long points = saltus_sweep_points(sweep);
    saltus_scene own = *saltus_sweep_scene(sweep);
    saltus_sweep_options alone = *saltus_sweep_choices(sweep);
    int moves = 0;
    bool moved = false;
    alone.passes = 1u << SALTUS_PASS_RESET;
    for (int k = 0; k < count; k++) {
        long long place = saltus_sweep_task_place(sweep, task, k), point = place % points;
        saltus_sweep_result there = result_at(all, place);
        for (int i = 0; i < n && !adaptive && k > 0; i++) {
            check_near(there.strobes[i], own.initial[i], moved ? 1e-15 : 0);
            own.initial[i] = there.strobes[i];
        }
        saltus_sweep *single = sweep_of(&own, c->first, c->second, &alone);
        outcome one = run_point(single, point);
        saltus_sweep_result here = result_at(&one, point);
        if (!adaptive || !moved)
            check_same_result(sweep, &there, &here);
        own.initial_count = n;
        memcpy(own.initial, there.states, (size_t)n * sizeof *own.initial);
        if (k + 1 < count) {
            saltus_system *system = system_at(sweep, saltus_sweep_task_place(sweep, task, k + 1) % points);
            onto_the_stop(system, own.initial);
            saltus_system_free(system);
        }
        moved = memcmp(own.initial, there.states, (size_t)n * sizeof *own.initial) != 0;
        moves += moved;
        close_outcome(&one);
        saltus_sweep_free(single);
    }
    return moves;
}

/* A pass along a line is a loop by hand: each point from where the one before it ended, brought back onto the
 * stop, the first from the scene's own state. */
static void a_line_is_a_loop_by_hand(void **unused) {
    (void)unused;
    for (size_t c = 0; c < sizeof lines / sizeof lines[0]; c++)
        for (int adaptive = 0; adaptive < 2; adaptive++) {
            saltus_scene scene = scene_of(lines[c].scene, lines[c].settings);
            saltus_sweep_options options = at_once(6, 1, 7);
            int moves = 0;
            options.keep = 7;
            options.adaptive = adaptive;
            options.transient = adaptive ? 300 : 0;
            saltus_sweep *sweep = sweep_of(&scene, lines[c].first, lines[c].second, &options);
            outcome all = run_all(sweep);
            for (long long task = 0; task < saltus_sweep_tasks(sweep); task++)
                moves += follow_line(&lines[c], &all, task, adaptive);
            assert_true(c < 2 || moves > 0);
            close_outcome(&all);
            saltus_sweep_free(sweep);
        }
}

static void the_first_seed_is_the_scenes_own(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("impact-oscillator", "q1=0.25 v1=-0.5");
    saltus_sweep_options options = at_once(7, 3, 1);
    saltus_sweep *sweep = sweep_of(&scene, "omega=1:2:4", "d=1,2", &options);
    outcome o = run_all(sweep);
    for (int k = 0; k < 4 * 2 * 3; k++) {
        saltus_sweep_result result = result_at(&o, k);
        bool first = k < 8 || k % 4 == (k < 16 ? 0 : 3); /* where a line begins */
        bool own = result.strobes[0] == 0.25 && result.strobes[1] == -0.5;
        assert_true(own == first);
        for (int s = 1; s < 3; s++)
            assert_true(result.strobes[2 * s] != 0.25 && result.strobes[2 * s + 1] != -0.5);
    }
    /* What one seed does does not hang on there being others. */
    saltus_sweep_options alone = at_once(7, 1, 1);
    saltus_sweep *single = sweep_of(&scene, "omega=1:2:4", "d=1,2", &alone);
    outcome one = run_all(single);
    for (int k = 0; k < 4 * 2 * 3; k++)
        assert_memory_equal(result_at(&o, k).states, result_at(&one, k).states, 2 * sizeof(double));
    close_outcome(&one);
    saltus_sweep_free(single);
    close_outcome(&o);
    saltus_sweep_free(sweep);
}

static void an_axis_of_initial_states_sets_the_first_seeds(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("two-mass", "q2=0.125");
    saltus_sweep_options options = at_once(1, 1, 1);
    saltus_sweep *sweep = sweep_of(&scene, "v1=-1:1:5", "q1=0.1,0.3", &options);
    outcome o = run_all(sweep);
    for (int k = 0; k < 10; k++) {
        const double *start = result_at(&o, k).strobes;
        assert_true(start[0] == (k < 5 ? 0.1 : 0.3) && start[1] == 0.125);
        assert_true(start[2] == -1 + 0.5 * (k % 5) && start[3] == 0);
    }
    close_outcome(&o);
    saltus_sweep_free(sweep);
}

/* Random initial states: Gaussian with the system's scales, one like no other, the same for the same seed. */
static void seeds_are_independent(void **unused) {
    (void)unused;
    enum { seeds = 1500, points = 2, all = seeds * points };
    saltus_scene scene = scene_of("two-mass", "free");
    saltus_sweep_options options = at_once(1, seeds + 1, 1);
    static double start[3][all][4];
    for (int run = 0; run < 3; run++) {
        options.seed = run == 2 ? 7 : 6;
        saltus_sweep *sweep = sweep_of(&scene, "omega=1.6,1.7", NULL, &options);
        outcome o = run_all(sweep);
        for (int p = 0; p < points; p++)
            memcpy(start[run][p * seeds], result_at(&o, p).strobes + 4, sizeof start[run][0] * seeds);
        if (run == 0) {
            saltus_system *system = system_at(sweep, 0);
            const double *scale = saltus_system_scale(system);
            for (int i = 0; i < 4; i++) {
                double mean = 0, square = 0, fourth = 0, next = 0;
                for (int s = 0; s < all; s++) {
                    double z = start[0][s][i] / scale[i];
                    mean += z / all;
                    square += z * z / all;
                    fourth += z * z * z * z / all;
                    next += z * start[0][(s + 1) % all][(i + 1) % 4] / scale[(i + 1) % 4] / all;
                }
                check_near(mean, 0, 4 / sqrt(all));
                check_near(square, 1, 4 * sqrt(2.0 / all));
                check_near(fourth, 3, 4 * sqrt(96.0 / all));
                check_near(next, 0, 4 / sqrt(all));
            }
            saltus_system_free(system);
        }
        close_outcome(&o);
        saltus_sweep_free(sweep);
    }
    assert_memory_equal(start[0], start[1], sizeof start[0]);
    for (int s = 0; s < all; s++) {
        assert_true(start[0][s][0] != start[2][s][0]);
        for (int other = 0; other < 40 && other < s; other++)
            assert_true(start[0][s][0] != start[0][other][0]);
    }
    for (int s = 0; s < seeds; s++)
        assert_true(start[0][s][0] != start[0][seeds + s][0]);
}

/* Whether two settled trajectories are on one orbit, by the orbits that classification finds. */
static bool same_motion(const saltus_system *system, const saltus_motion *a, const saltus_motion *b) {
    if (strcmp(a->label, b->label) != 0)
        return false;
    const double *scale = saltus_system_scale(system);
    int n = a->dimension, points = a->periods ? a->periods : 1;
    for (int k = 0; k < points; k++) {
        const double *x = a->periods ? a->section_states + k * n : a->state;
        double largest = 0;
        for (int i = 0; i < n; i++)
            largest = fmax(largest, fabs(x[i] - b->state[i]) / scale[i]);
        if (largest < 1e-7)
            return true;
    }
    return false;
}

/* Numbers are dense from 0 in the order of seeds; the same orbit, whatever its phase, has the same, a mirror
 * image another; all that has not settled counts as one. */
static void attractors_are_numbered_by_orbits(void **unused) {
    (void)unused;
    enum { seeds = 16 };
    static const struct {
        const char *scene, *settings, *key;
        double value;
        int least, transient;
    } cases[] = {{"fig3", "", "omega", 14, 2, 500},
                 {"pipe", "N=1 sigma=0 omega=20 free", "d", 0, 2, 500},
                 {"near-grazing", "c=0.08 F=0.37", "omega", 0.85, 1, 2000},
                 {"impact-oscillator", "sides=both d=0.3 c=0.2 k=1 F=9 r=0.8", "omega", 3.2, 1, 400},
                 {"impact-oscillator", "c=0.4 F=1 d=0.25", "omega", 2, 1, 45},
                 {"impact-oscillator", "c=0.02 d=0.016", "omega", 3.04396, 1, 300}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        saltus_scene scene = scene_of(cases[c].scene, cases[c].settings);
        saltus_sweep_options options = frame_options(0, 1, seeds);
        options.transient = cases[c].transient;
        single s = run_single(&scene, scene.spec.stop_count ? cases[c].key : "omega",
                              scene.spec.stop_count ? cases[c].value : 20, &options);
        saltus_system *system = system_at(s.sweep, 0);
        saltus_motion motion[seeds];
        int next = 0, n = saltus_sweep_dimension(s.sweep);
        memset(motion, 0, sizeof motion);
        for (int k = 0; k < seeds; k++) {
            const saltus_sweep_row *row = &s.result.rows[k];
            int expected = next;
            if (saltus_sweep_settled(row))
                motion[k] = motion_from(system, s.result.states + k * n, 20);
            for (int j = 0; j < k && expected == next; j++) {
                bool settled = saltus_sweep_settled(row), other = saltus_sweep_settled(&s.result.rows[j]);
                if (settled && other ? same_motion(system, &motion[j], &motion[k])
                                     : s.result.rows[j].verdict == row->verdict)
                    expected = s.result.rows[j].attractor;
            }
            next += expected == next;
            if (row->attractor != expected)
                fail_msg("%s %s: seed %d has attractor %d, not %d", cases[c].scene, cases[c].settings, k,
                         row->attractor, expected);
        }
        if (next < cases[c].least)
            fail_msg("%s %s: only %d attractors", cases[c].scene, cases[c].settings, next);
        for (int k = 0; k < seeds; k++)
            saltus_motion_clear(&motion[k]);
        saltus_system_free(system);
        close_single(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_are_even_in_values_or_in_their_logarithms),
        cmocka_unit_test(axes_are_read_up_to_their_limits),
        cmocka_unit_test(options_are_taken_up_to_their_limits),
        cmocka_unit_test(defaults_are_those_promised),
        cmocka_unit_test(a_sweep_keeps_what_it_was_given),
        cmocka_unit_test(words_and_labels),
        cmocka_unit_test(tasks_cover_all_places_once),
        cmocka_unit_test(a_line_is_a_loop_by_hand),
        cmocka_unit_test(the_first_seed_is_the_scenes_own),
        cmocka_unit_test(an_axis_of_initial_states_sets_the_first_seeds),
        cmocka_unit_test(seeds_are_independent),
        cmocka_unit_test(attractors_are_numbered_by_orbits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
