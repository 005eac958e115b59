/* The structure of a sweep: points, passes, tasks and places, initial states and what is carried from point
 * to point, seeds and their attractors, the feed, what is recorded, options and their limits, basins.
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

/* Without a transient the first section point recorded is the trajectory's start. */
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
    saltus_message message = {.text = ""};
    saltus_status status = saltus_sweep_new(scene, axes, count, options, &sweep, &message);
    assert_true((status == SALTUS_OK) == (sweep != NULL));
    assert_true(status == SALTUS_OK || strlen(message.text) > 10);
    saltus_sweep_free(sweep);
    return status;
}

static void axes_are_even_in_values_or_in_their_logarithms(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
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
    } cases[] = {{"d=0:1:2", true},
                 {"d=0:1:10000000", true},
                 {"d=0:1:10000001", false},
                 {"d=0:1:1", false},
                 {"abcdefghijklmnopqrstuvwxyzabcde=1", true},
                 {"abcdefghijklmnopqrstuvwxyzabcdef=1", false},
                 {"d=1e-300:1:3:log", true},
                 {"d=0:1:3:log", false},
                 {"d=1:0:3:log", false}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_message message = {.text = ""};
        saltus_axis axis;
        double *list;
        saltus_status status = saltus_axis_read(cases[k].text, &axis, &list, &message);
        if ((status == SALTUS_OK) != cases[k].good)
            fail_msg("%s: %s", cases[k].text, saltus_status_name(status));
        assert_true(status == SALTUS_OK || strstr(message.text, cases[k].text));
        free(list);
    }
}

/* A refusal states the given numbers, each by its name. */
static void refusals_tell_what_was_given(void **unused) {
    (void)unused;
    const saltus_scene scene = scene_of("impact-oscillator", "");
    const saltus_axis axes[2] = {{.key = "omega", .count = 10000, .low = 1, .high = 2},
                                 {.key = "d", .count = 11, .low = 1, .high = 2}};
    const saltus_sweep_options good = saltus_sweep_defaults();
    static const char *const told[] = {"passes = 8:",
                                       "seeds = 10001: must be from 1 to 10000",
                                       "seeds = 0: must be from 1 to 10000",
                                       "transient = -7: must be from 0 to 1000000000",
                                       "record = -3: must be from 1 to 1000000000",
                                       "measure = -11:",
                                       "longest = 257: must be from 1 to 256",
                                       "lanes = -2: must be from 0 to 4096",
                                       "threads = -6: must be from 0 to 4096",
                                       "110000 points with 2 passes and 9000 seeds: more than 1000000000"};
    for (int k = 0; k < 10; k++) {
        saltus_sweep_options o = good;
        saltus_message message = {.text = ""};
        saltus_sweep *sweep = NULL;
        o.passes = k == 0 ? 8 : k == 9 ? 3 : 1;
        o.seeds = k == 1 ? 10001 : k == 2 ? 0 : k == 9 ? 9000 : 1;
        o.transient = k == 3 ? -7 : 9;
        o.record = k == 4 ? -3 : 5;
        o.measure = k == 5 ? -11 : 7;
        o.longest = k == 6 ? 257 : 3;
        o.lanes = k == 7 ? -2 : 4;
        o.threads = k == 8 ? -6 : 5;
        assert_int_equal(saltus_sweep_new(&scene, axes, 2, &o, &sweep, &message), SALTUS_BAD_INPUT);
        assert_null(sweep);
        if (!strstr(message.text, told[k]))
            fail_msg("'%s' does not say '%s'", message.text, told[k]);
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
    /* At most a thousand million rows. */
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
    assert_true(o.measure == 32000 && o.lifetime == 10000 && o.longest == 20 && o.lanes == 0 &&
                o.threads == 0);
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
    saltus_message message = {.text = ""};
    options.flow.columns = 2;
    options.flow.directions = 1;
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
    /* The caller's columns and directions of the flow are ignored. */
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
        "pending",     NULL,        "equilibrium", "held",      "quasi-periodic", "chaotic",
        "long-period", "undecided", "failed",      "transient", "irregular",      "beyond a stop"};
    char label[32];
    assert_string_equal(saltus_pass_word(SALTUS_PASS_RESET), "reset");
    assert_string_equal(saltus_pass_word(SALTUS_PASS_UP), "up");
    assert_string_equal(saltus_pass_word(SALTUS_PASS_DOWN), "down");
    for (int v = 0; v < SALTUS_VERDICTS; v++) {
        saltus_sweep_row row = {.verdict = v, .impacts = 3, .periods = 2};
        saltus_sweep_label(&row, label);
        assert_string_equal(label, words[v] ? words[v] : "3/2");
        assert_true(saltus_verdict_settled(row.verdict) ==
                    (v == SALTUS_PERIODIC || v == SALTUS_EQUILIBRIUM || v == SALTUS_HELD));
    }
    saltus_sweep_row row = {.verdict = SALTUS_PERIODIC, .impacts = -1, .periods = 5};
    saltus_sweep_label(&row, label);
    assert_string_equal(label, "chatter/5");
    row.impacts = 0;
    saltus_sweep_label(&row, label);
    assert_string_equal(label, "0/5");
}

/* Every place belongs to one task: a point of a reset pass is a task, a line of another pass is one, in the
 * pass's order. */
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

/* A state beyond a stop is moved back onto it along the stop's normal. */
static void onto_the_stop(const saltus_system *system, double *state) {
    const double *normal = saltus_system_stop_normal(system, 0);
    double gap = saltus_system_gap(system, 0, state), square = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        square += normal[i] * normal[i];
    for (int i = 0; i < saltus_system_dof(system) && gap > 0; i++)
        state[i] -= saltus_system_face(system, 0).side * gap * normal[i] / square;
}

/* Compare rows and clouds of two results, except place and number of the attractor. */
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
    saltus_message message = {.text = ""};
    outcome one = open_outcome(sweep);
    one.first = point;
    one.step = one.tasks = 1;
    saltus_sweep_feed feed = {.context = &one, .next = next_task, .take = keep_result};
    check_ok(saltus_sweep_run(sweep, &feed, &message), &message);
    return one;
}

/* Trajectories along a line start from the states computed here by hand, and continue with the bits of a
 * trajectory started there alone. */
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

/* A pass along a line, as a loop by hand: each point starts where the one before ended, brought back onto the
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
    /* A seed's trajectory does not depend on other seeds. */
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

/* The force of a Maxwell element is also an entry of the state; without one, or for another letter, there is
 * no such axis. */
static void an_axis_moves_the_force_of_a_maxwell_element(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("impact-oscillator", "kz=0.5 tz=0.25 q1=0.125 v1=-0.5");
    saltus_sweep_options options = at_once(1, 1, 1);
    saltus_sweep *sweep = sweep_of(&scene, "z1=-1:1:5", "q1=0.25,0.75", &options);
    saltus_basins *basins = NULL;
    saltus_message message = {.text = ""};
    outcome o = run_all(sweep);
    assert_int_equal(saltus_sweep_dimension(sweep), 3);
    for (int k = 0; k < 10; k++) {
        const double *start = result_at(&o, k).strobes;
        assert_true(start[0] == (k < 5 ? 0.25 : 0.75) && start[1] == -0.5 && start[2] == -1 + 0.5 * (k % 5));
    }
    check_ok(saltus_basins_new(sweep, &basins, &message), &message);
    saltus_basins_free(basins);
    close_outcome(&o);
    saltus_sweep_free(sweep);
    static const char *const keys[] = {"z1", "z2", "z0", "e1", "z", "q", "q0", "q2", "v2", ""};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        for (int element = 0; element < 2; element++) {
            saltus_scene other = scene_of("impact-oscillator", element ? "kz=0.5" : "kz=0");
            saltus_axis axis = {.count = 2, .low = 0.25, .high = 0.5};
            strcpy(axis.key, keys[k]);
            saltus_status wanted = element && k == 0 ? SALTUS_OK : SALTUS_BAD_INPUT;
            if (make(&other, &axis, 1, &options) != wanted)
                fail_msg("an axis of %s, %s element", keys[k], element ? "with" : "without");
        }
}

/* Random initial states: Gaussian with the system's scales, all different, the same for the same seed. */
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

/* Whether two settled trajectories are on the same orbit, by classification. */
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

/* Attractors are numbered from 0 without gaps in the order of seeds: the same orbit at any phase has the same
 * number, a mirror image another; all unsettled motions count as one. */
static void attractors_are_numbered_by_orbits(void **unused) {
    (void)unused;
    enum { seeds = 16 };
    static const struct {
        const char *scene, *settings, *key;
        double value;
        int least, transient;
    } cases[] = {{"fig3", "", "omega", 14, 2, 500},
                 {"pipe", "N=1 sigma=0 omega=20 free", "d", 0, 2, 500},
                 {"impact-oscillator", "F=0 omega=1 q1=-50000", "omega", 1, 2, 30},
                 {"pipe", "N=1 sigma=0 omega=20 d=0.015", "d", 0.015, 2, 500},
                 {"impact-oscillator", "q1=5", "omega", 1.3, 1, 400},
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
            if (saltus_verdict_settled(row->verdict))
                motion[k] = motion_from(system, s.result.states + k * n, 20);
            for (int j = 0; j < k && expected == next; j++) {
                bool settled = saltus_verdict_settled(row->verdict),
                     other = saltus_verdict_settled(s.result.rows[j].verdict);
                if (settled && other ? same_motion(system, &motion[j], &motion[k])
                                     : s.result.rows[j].verdict == row->verdict)
                    expected = s.result.rows[j].attractor;
            }
            if (saltus_verdict_nothing((saltus_verdict)row->verdict))
                expected = -1;
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

/* What is not requested is absent, and what is requested does not depend on the rest. */
static void only_what_is_asked_for_is_kept(void **unused) {
    (void)unused;
    const saltus_scene scene = scene_of("impact-oscillator", "");
    saltus_sweep_options options = frame_options(15, 1, 2);
    single full = run_single(&scene, "omega", 1.3, &options);
    for (unsigned keep = 0; keep < 16; keep++) {
        options.keep = keep;
        single s = run_single(&scene, "omega", 1.3, &options);
        const saltus_sweep_result *a = &s.result, *b = &full.result;
        for (int seed = 0; seed < 2; seed++) {
            assert_int_equal(a->turning_counts[seed], keep & 1 ? b->turning_counts[seed] : 0);
            assert_int_equal(a->impact_counts[seed], keep & 2 ? b->impact_counts[seed] : 0);
            assert_int_equal(a->strobe_counts[seed], keep & 4 ? b->strobe_counts[seed] : 0);
            if (keep & 8)
                assert_true(a->rows[seed].lyapunov == b->rows[seed].lyapunov);
            else
                assert_true(isnan(a->rows[seed].lyapunov) && isnan(a->rows[seed].lyapunov_error));
            assert_true(a->rows[seed].largest == b->rows[seed].largest);
        }
        assert_int_equal(b->strobe_counts[0], 1);
        if (keep & 1)
            assert_memory_equal(a->turning, b->turning, 4 * sizeof *a->turning);
        if (keep & 2)
            assert_true(a->impacts[1].phase == b->impacts[1].phase);
        if (keep & 4)
            assert_memory_equal(a->strobes, b->strobes, 4 * sizeof *a->strobes);
        close_single(&s);
    }
    close_single(&full);
}

/* A 1/2 motion is not found among periods up to 1; it is then recorded for the requested time, after the full
 * transient. */
static void longest_transient_and_record_are_heeded(void **unused) {
    (void)unused;
    const saltus_scene scene = scene_of("near-grazing", "c=0.08 F=0.37");
    for (int longest = 1; longest <= 3; longest++)
        for (int k = 0; k < 2; k++) {
            saltus_sweep_options options = frame_options(7, 1, 1);
            options.longest = longest;
            options.transient = 700 + k;
            options.record = 6 + k;
            single s = run_single(&scene, "omega", 0.85, &options);
            const saltus_sweep_row *row = s.result.rows;
            assert_string_equal(s.label, longest > 1 ? "1/2" : "irregular");
            assert_int_equal(row->recorded, longest > 1 ? 2 : 6 + k);
            assert_int_equal(s.result.strobe_counts[0], row->recorded);
            assert_true(longest > 1 ? row->settled < 700 : row->settled == 700 + k);
            close_single(&s);
        }
}

/* Other integrators and orders give other bits but the same motion. */
static void the_flows_options_are_heeded(void **unused) {
    (void)unused;
    const saltus_scene scene = scene_of("impact-oscillator", "");
    saltus_sweep_options options = frame_options(4, 1, 1);
    single usual = run_single(&scene, "omega", 1.3, &options);
    for (int k = 0; k < 4; k++) {
        saltus_sweep_options other = options;
        other.flow.integrator = k == 0 ? SALTUS_RADAU : SALTUS_AUTOMATIC;
        other.flow.order = k == 1 ? 9 : 0;
        other.flow.rtol = k == 2 ? 1e-8 : options.flow.rtol;
        other.seed = k == 3 ? 12 : options.seed;
        single s = run_single(&scene, "omega", 1.3, &other);
        assert_string_equal(s.label, usual.label);
        for (int i = 0; i < 2; i++)
            check_near(s.result.states[i], usual.result.states[i], 1e-6);
        assert_true(s.result.states[0] != usual.result.states[0]);
        close_single(&s);
    }
    close_single(&usual);
}

/* Chaos is asserted after at least an eighth of the periods that may be measured, and 500. A motion that may
 * be measured for fewer is irregular if its exponent is positive beyond doubt, otherwise undecided; without
 * measurement it has no exponent. */
static void chaos_is_measured_as_long_as_said(void **unused) {
    (void)unused;
    static const long long measures[] = {0, 100, 400, 499, 500, 900, 4000, 9000, 20000};
    const saltus_scene scene = scene_of("impact-oscillator", "c=0.02 r=0.8 d=0.0160301");
    for (size_t k = 0; k < sizeof measures / sizeof measures[0]; k++) {
        const long long most = measures[k];
        saltus_sweep_options options = frame_options(SALTUS_KEEP_LYAPUNOV, 1, 1);
        options.transient = 100;
        options.record = 10;
        options.measure = most;
        options.lifetime = options.measure / 24;
        single s = run_single(&scene, "omega", 3.04396, &options);
        const saltus_sweep_row *row = s.result.rows;
        long long measured = row->settled - 110;
        assert_int_equal(row->recorded, 10);
        if (most < 500)
            assert_true(row->verdict == SALTUS_IRREGULAR
                            ? most == 0 || row->lyapunov > 3 * row->lyapunov_error
                            : most > 0 && row->verdict == SALTUS_UNDECIDED);
        else
            /* Whether a stable orbit is found amid it depends on the points present. */
            assert_true(row->verdict == SALTUS_CHAOTIC || row->verdict == SALTUS_TRANSIENT);
        if (most == 0)
            assert_true(isnan(row->lyapunov) && isnan(row->lyapunov_error) && row->settled == 100);
        else {
            /* Before measurement the tangent vector turns into the growing direction. */
            assert_true(measured <= most + 100 && measured >= (most < 500 ? most : 500));
            assert_true(most < 500 || measured >= most / 8);
            /* It is examined each time the number of periods has doubled. */
            assert_true(measured <= 2 * (most / 8 > 500 ? most / 8 : 500) + 100);
            assert_true(row->lyapunov > 0 && row->lyapunov_error > 0 && row->lyapunov < 1);
        }
        close_single(&s);
    }
}

/* A feed that counts its callers, and checks that tasks end when their places have been handed out. */
typedef struct strict_feed {
    outcome outcome;
    atomic_int inside;
    bool clean;
    long long taken, asked, ended, stop_after;
    volatile sig_atomic_t *stop;
    int *places_left, *ends;
} strict_feed;

static void enter_feed(strict_feed *f) {
    if (atomic_fetch_add(&f->inside, 1) != 0)
        f->clean = false;
}

static long long strict_next(void *context) {
    strict_feed *f = context;
    enter_feed(f);
    long long task = next_task(&f->outcome);
    f->asked += task >= 0;
    atomic_fetch_sub(&f->inside, 1);
    return task;
}

static saltus_status strict_take(void *context, const saltus_sweep_result *result, saltus_message *message) {
    strict_feed *f = context;
    const saltus_sweep *sweep = f->outcome.sweep;
    saltus_sweep_result back;
    enter_feed(f);
    saltus_status status = keep_result(&f->outcome, result, message);
    /* Packing and unpacking changes no number. */
    f->clean = f->clean && saltus_sweep_unpack(sweep, f->outcome.block[result->place],
                                               f->outcome.size[result->place], &back);
    int seeds = saltus_sweep_choices(sweep)->seeds, n = saltus_sweep_dimension(sweep);
    long long turning = 0, impacts = 0, strobes = 0;
    for (int s = 0; s < seeds; s++) {
        const saltus_sweep_row *a = &result->rows[s], *b = &back.rows[s];
        const double x[] = {a->largest,          a->smallest, a->impact_rate,    a->largest_speed,
                            a->contact_fraction, a->lyapunov, a->lyapunov_error, a->rms},
                     y[] = {b->largest,          b->smallest, b->impact_rate,    b->largest_speed,
                            b->contact_fraction, b->lyapunov, b->lyapunov_error, b->rms};
        f->clean &= memcmp(x, y, sizeof x) == 0 && a->verdict == b->verdict && a->impacts == b->impacts &&
                    a->periods == b->periods && a->sticking == b->sticking && a->attractor == b->attractor &&
                    a->settled == b->settled && a->settled_impacts == b->settled_impacts &&
                    a->recorded == b->recorded;
        f->clean &= result->turning_counts[s] == back.turning_counts[s] &&
                    result->impact_counts[s] == back.impact_counts[s] &&
                    result->strobe_counts[s] == back.strobe_counts[s];
        turning += result->turning_counts[s];
        impacts += result->impact_counts[s];
        strobes += result->strobe_counts[s];
    }
    f->clean &= back.place == result->place &&
                memcmp(result->states, back.states, (size_t)(seeds * n) * sizeof(double)) == 0 &&
                memcmp(result->turning, back.turning, (size_t)turning * sizeof(double)) == 0 &&
                memcmp(result->strobes, back.strobes, (size_t)(strobes * n) * sizeof(double)) == 0;
    for (long long k = 0; k < impacts; k++)
        f->clean &= result->impacts[k].phase == back.impacts[k].phase &&
                    result->impacts[k].speed == back.impacts[k].speed &&
                    result->impacts[k].face == back.impacts[k].face;
    f->places_left[result->place]--;
    *f->stop |= ++f->taken >= f->stop_after;
    atomic_fetch_sub(&f->inside, 1);
    return status;
}

static void strict_done(void *context, long long task) {
    strict_feed *f = context;
    const saltus_sweep *sweep = f->outcome.sweep;
    for (int k = 0; k < saltus_sweep_task_length(sweep, task); k++)
        f->clean &= f->places_left[saltus_sweep_task_place(sweep, task, k)] == 0;
    f->ends[task]++;
    f->ended++;
}

static void the_feed_is_asked_and_told_in_order(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("fig3", "");
    for (int way = 0; way < 4; way++) {
        saltus_sweep_options options = frame_options(15, 7, 2);
        saltus_message message = {.text = ""};
        volatile sig_atomic_t stop = 0;
        options.flow.stop = &stop;
        options.threads = way % 2 ? 3 : 1;
        options.transient = 60;
        options.measure = 100;
        saltus_sweep *sweep = sweep_of(&scene, "omega=12:20:4", "d=0.03,0.035", &options);
        const long long tasks = saltus_sweep_tasks(sweep), places = 3 * 8;
        strict_feed f = {.outcome = open_outcome(sweep), .clean = true, .stop_after = way < 2 ? 1000 : 5};
        f.stop = &stop;
        f.outcome.step = 1;
        f.outcome.tasks = tasks;
        f.places_left = calloc((size_t)places, sizeof *f.places_left);
        f.ends = calloc((size_t)tasks, sizeof *f.ends);
        assert_true(f.places_left && f.ends);
        for (long long k = 0; k < places; k++)
            f.places_left[k] = 1;
        const saltus_sweep_feed feed = {&f, strict_next, strict_take, strict_done};
        check_ok(saltus_sweep_run(sweep, &feed, &message), &message);
        assert_true(f.clean);
        for (long long k = 0; k < tasks; k++)
            assert_true(f.ends[k] <= 1);
        if (way < 2) {
            assert_true(f.taken == places && f.asked == tasks && f.ended == tasks);
            for (long long k = 0; k < places; k++)
                assert_int_equal(f.places_left[k], 0);
        } else
            assert_true(f.taken >= 5 && f.taken < places && f.ended < tasks);
        free(f.places_left);
        free(f.ends);
        close_outcome(&f.outcome);
        saltus_sweep_free(sweep);
    }
}

/* More lanes and threads may be requested than exist, and than there are trajectories. */
static void lanes_and_threads_are_at_most(void **unused) {
    (void)unused;
    static const int most[][2] = {{2, 1}, {15, 1}, {16, 1}, {17, 1}, {1000, 1}, {0, 64}, {1000, 1000}};
    const saltus_scene scene = scene_of("impact-oscillator", "");
    saltus_sweep_options options = at_once(1, 2, 3);
    options.flow.rtol = 1e-6;
    saltus_sweep *sweep = sweep_of(&scene, "omega=1:2:7", "d=0.5:1:3", &options);
    options.lanes = 1;
    saltus_sweep *single = sweep_of(&scene, "omega=1:2:7", "d=0.5:1:3", &options);
    outcome reference = run_all(single);
    for (size_t k = 0; k < sizeof most / sizeof most[0]; k++) {
        options.lanes = most[k][0];
        options.threads = most[k][1];
        saltus_sweep_free(sweep);
        sweep = sweep_of(&scene, "omega=1:2:7", "d=0.5:1:3", &options);
        outcome o = run_all(sweep);
        check_same_bits(&reference, &o, "many lanes");
        close_outcome(&o);
    }
    close_outcome(&reference);
    saltus_sweep_free(single);
    saltus_sweep_free(sweep);
}

static void basins_need_a_plane_of_initial_states(void **unused) {
    (void)unused;
    static const struct {
        const char *first, *second;
        int seeds;
        bool good;
    } cases[] = {{"q1=-1:0:3", "v1=-1:1:3", 1, true},
                 {"q1=-1:0:3", NULL, 1, true},
                 {"q1=-1:0:3", "d=1:2:3", 1, false},
                 {"omega=1:2:3", "v1=-1:1:3", 1, false},
                 {"q1=-1:0:3", "v1=-1:1:3", 2, false}};
    const saltus_scene scene = scene_of("impact-oscillator", "");
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_sweep_options options = frame_options(0, 1, cases[k].seeds);
        saltus_sweep *sweep = sweep_of(&scene, cases[k].first, cases[k].second, &options);
        saltus_message message = {.text = ""};
        saltus_basins *basins = NULL;
        saltus_status status = saltus_basins_new(sweep, &basins, &message);
        assert_int_equal(status, cases[k].good ? SALTUS_OK : SALTUS_BAD_INPUT);
        assert_true(cases[k].good ? basins != NULL : !basins && strlen(message.text) > 10);
        assert_true(!basins || saltus_basins_count(basins) == 0);
        saltus_basins_free(basins);
        saltus_sweep_free(sweep);
    }
    saltus_basins_free(NULL);
}

/* Each settled row is on its attractor's orbit; attractors are numbered as they are found; other rows have
 * none. */
static int check_basins(const char *name, const char *settings, const char *first, const char *second,
                        int transient, double rtol) {
    saltus_scene scene = scene_of(name, settings);
    saltus_sweep_options options = frame_options(0, 1, 1);
    options.transient = transient;
    options.flow.rtol = rtol;
    options.flow.atol = 1e-4 * rtol;
    saltus_sweep *sweep = sweep_of(&scene, first, second, &options);
    outcome o = run_all(sweep);
    saltus_message message = {.text = ""};
    saltus_basins *basins = NULL;
    saltus_system *system = system_at(sweep, 0);
    int unsettled = 0, count = 0;
    check_ok(saltus_basins_new(sweep, &basins, &message), &message);
    for (long long k = 0; k < o.places; k++) {
        saltus_sweep_result result = result_at(&o, k);
        int attractor = -7, known = saltus_basins_count(basins);
        char label[32];
        check_ok(saltus_basins_sort(basins, result.rows, result.states, &attractor, &message), &message);
        count = saltus_basins_count(basins);
        saltus_sweep_label(result.rows, label);
        unsettled += !saltus_verdict_settled(result.rows->verdict);
        if (!saltus_verdict_settled(result.rows->verdict)) {
            assert_true(attractor == -1 && count == known);
            continue;
        }
        assert_true(attractor >= 0 && attractor <= known && count == known + (attractor == known));
        saltus_motion own = motion_from(system, result.states, 20);
        assert_true(same_motion(system, saltus_basins_motion(basins, attractor), &own));
        assert_string_equal(label, saltus_basins_motion(basins, attractor)->label);
        for (int j = 0; j < count; j++)
            assert_true(j == attractor || !same_motion(system, saltus_basins_motion(basins, j), &own));
        saltus_motion_clear(&own);
    }
    saltus_system_free(system);
    saltus_basins_free(basins);
    close_outcome(&o);
    saltus_sweep_free(sweep);
    return 100 * unsettled + count;
}

static void basins_sort_by_orbits(void **unused) {
    (void)unused;
    /* A mirror pair of period 2, whose rows end at either phase; two equilibria and trajectories on the way
     * to them; chaos beside an orbit; starts beyond the stop. */
    assert_int_equal(check_basins("fig3", "", "q1=-0.03:0.03:5", "v1=-1:1:5", 300, 1e-10), 2);
    assert_int_equal(
        check_basins("pipe", "N=1 sigma=0 omega=20 free", "q1=-0.02:0.03:5", "v1=-1:1:3", 300, 1e-10), 2);
    assert_int_equal(check_basins("fig3", "", "q1=-0.03:0.03:5", "v1=-1:1:3", 300, 1e-7), 2);
    assert_true(check_basins("fig3", "", "q1=-0.03:0.03:5", "v1=-1:1:5", 70, 1e-10) > 100);
    assert_true(check_basins("impact-oscillator", "c=0.02 d=0.016", "q1=-1:0.2:5", "v1=0,1", 300, 1e-10) >
                100);
}

/* A state that is only near an attractor still leads to it; a row that has reached no attractor, or cannot be
 * examined, belongs to none. */
static void states_near_an_attractor_belong_to_it(void **unused) {
    (void)unused;
    static const double away[] = {0, 1e-9, 9e-8, 1.1e-7, 1e-5, -1e-3};
    saltus_scene scene = scene_of("fig3", "");
    saltus_sweep_options options = frame_options(0, 1, 1);
    saltus_sweep *sweep = sweep_of(&scene, "q1=0.01:0.02:2", "v1=0:1:2", &options);
    saltus_system *system = system_at(sweep, 0);
    int n = saltus_system_dimension(system);
    saltus_message message = {.text = ""};
    saltus_basins *basins = NULL;
    double state[SALTUS_SCENE_STATE_MAX] = {0.01}, near[SALTUS_SCENE_STATE_MAX] = {0};
    const saltus_sweep_row row = {.verdict = SALTUS_PERIODIC, .periods = 2, .impacts = 2},
                           other = {.verdict = SALTUS_CHAOTIC};
    int attractor = -7;
    check_ok(saltus_basins_new(sweep, &basins, &message), &message);
    check_ok(saltus_basins_sort(basins, &other, state, &attractor, &message), &message);
    assert_true(attractor == -1 && saltus_basins_count(basins) == 0);
    check_ok(saltus_basins_sort(basins, &row, state, &attractor, &message), &message);
    assert_true(attractor == 0 && saltus_basins_count(basins) == 1);
    const saltus_motion *motion = saltus_basins_motion(basins, 0);
    assert_int_equal(motion->periods, 2);
    for (int phase = 0; phase < 2; phase++)
        for (size_t k = 0; k < sizeof away / sizeof away[0]; k++) {
            memcpy(near, saltus_basins_motion(basins, 0)->section_states + phase * n,
                   (size_t)n * sizeof *near);
            near[0] += away[k] * saltus_system_scale(system)[0];
            if (saltus_system_check_state(system, near, NULL) != SALTUS_OK)
                continue;
            attractor = -7;
            check_ok(saltus_basins_sort(basins, &row, near, &attractor, &message), &message);
            assert_true(attractor == 0 && saltus_basins_count(basins) == 1);
        }
    memset(near, 0, sizeof near);
    near[0] = 10;
    check_ok(saltus_basins_sort(basins, &row, near, &attractor, &message), &message);
    assert_true(attractor == -1 && saltus_basins_count(basins) == 1);
    saltus_basins_free(basins);
    saltus_system_free(system);
    saltus_sweep_free(sweep);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_are_even_in_values_or_in_their_logarithms),
        cmocka_unit_test(axes_are_read_up_to_their_limits),
        cmocka_unit_test(refusals_tell_what_was_given),
        cmocka_unit_test(options_are_taken_up_to_their_limits),
        cmocka_unit_test(defaults_are_those_promised),
        cmocka_unit_test(a_sweep_keeps_what_it_was_given),
        cmocka_unit_test(words_and_labels),
        cmocka_unit_test(tasks_cover_all_places_once),
        cmocka_unit_test(a_line_is_a_loop_by_hand),
        cmocka_unit_test(the_first_seed_is_the_scenes_own),
        cmocka_unit_test(an_axis_of_initial_states_sets_the_first_seeds),
        cmocka_unit_test(an_axis_moves_the_force_of_a_maxwell_element),
        cmocka_unit_test(seeds_are_independent),
        cmocka_unit_test(attractors_are_numbered_by_orbits),
        cmocka_unit_test(only_what_is_asked_for_is_kept),
        cmocka_unit_test(longest_transient_and_record_are_heeded),
        cmocka_unit_test(the_flows_options_are_heeded),
        cmocka_unit_test(chaos_is_measured_as_long_as_said),
        cmocka_unit_test(the_feed_is_asked_and_told_in_order),
        cmocka_unit_test(lanes_and_threads_are_at_most),
        cmocka_unit_test(basins_need_a_plane_of_initial_states),
        cmocka_unit_test(basins_sort_by_orbits),
        cmocka_unit_test(states_near_an_attractor_belong_to_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
