/* The promises of flow.h: defaults and limits, dense output, fields and tangent fields, interruptions, lanes
 * of the oscillator side by side, error in proportion to the tolerance.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes.h"
#include "stress_field.h"

#include <limits.h>

enum { widest = 16 };

static void defaults_are_as_stated(void **unused) {
    (void)unused;
    saltus_flow_options o = saltus_flow_defaults();
    assert_true(o.rtol == 1e-13 && o.atol == 1e-16 && o.integrator == SALTUS_AUTOMATIC && o.order == 0);
    assert_true(o.columns == 0 && o.directions == 0 && o.stop == NULL);
    assert_true(saltus_time_periods((saltus_time){-3, 0.25}) == -2.75);
    saltus_flow_free(NULL);
}

/* The phase of a time is in [0, 1), however the time was given. */
static void phases_are_told_within_a_period(void **unused) {
    (void)unused;
    static const struct {
        saltus_time given, told;
    } rows[] = {{{3, 1}, {4, 0}}, {{3, 1.75}, {4, 0.75}}, {{3, -0.25}, {2, 0.75}}, {{-1, 0.5}, {-1, 0.5}}};
    scene s = scene_of(scene_two_sided_mass);
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = open_flow(system, &options, 0, s.state);
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_message message = {.text = ""};
        check_ok(saltus_flow_start(flow, 0, rows[k].given, s.state, &message), &message);
        saltus_time now = saltus_flow_time(flow, 0);
        assert_true(now.cycle == rows[k].told.cycle && now.phase == rows[k].told.phase);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

static bool accepted(const saltus_system *system, const saltus_flow_options *options, const char *word) {
    saltus_message message = {.text = ""};
    saltus_flow *flow = (saltus_flow *)1;
    saltus_status status = saltus_flow_new((const saltus_system *[]){system}, 1, options, &flow, &message);
    assert_true(status == SALTUS_OK || status == SALTUS_BAD_INPUT);
    assert_true((status == SALTUS_OK) == (flow != NULL));
    saltus_flow *unexplained = NULL;
    assert_int_equal(saltus_flow_new((const saltus_system *[]){system}, 1, options, &unexplained, NULL),
                     status);
    saltus_flow_free(unexplained);
    if (status != SALTUS_OK && !strstr(message.text, word))
        fail_msg("\"%s\" does not name %s", message.text, word);
    if (status == SALTUS_OK)
        assert_int_equal(saltus_flow_columns(flow), options->columns);
    saltus_flow_free(flow);
    return status == SALTUS_OK;
}

static void limits_are_as_stated(void **unused) {
    (void)unused;
    static const struct {
        const char *word;
        double value;
        bool right;
    } rows[] = {{"rtol", 1e-15, true},    {"rtol", 1e-3, true},      {"rtol", 0.99e-15, false},
                {"rtol", 1.01e-3, false}, {"rtol", NAN, false},      {"rtol", -1e-9, false},
                {"atol", 0, true},        {"atol", -1e-30, false},   {"atol", NAN, false},
                {"atol", 1, true},        {"atol", 1.01, false},     {"order", 8, true},
                {"order", 40, true},      {"order", 7, false},       {"order", 41, false},
                {"order", -8, false},     {"columns", 256, true},    {"columns", 0, true},
                {"columns", 257, false},  {"columns", -1, false},    {"directions", 3, true},
                {"directions", 4, false}, {"directions", -1, false}, {"integrator", -1, false},
                {"integrator", 0, true},  {"integrator", 3, true},   {"integrator", 4, false}};
    scene s = scene_of(scene_two_sided_mass);
    saltus_system *system = build(&s.spec);
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_flow_options o = saltus_flow_defaults();
        const double value = rows[k].value;
        if (strcmp(rows[k].word, "rtol") == 0)
            o.rtol = value;
        else if (strcmp(rows[k].word, "atol") == 0)
            o.atol = value;
        else if (strcmp(rows[k].word, "order") == 0)
            o.order = (int)value;
        else if (strcmp(rows[k].word, "columns") == 0)
            o.columns = (int)value;
        else if (strcmp(rows[k].word, "directions") == 0) {
            o.directions = (int)value;
            o.columns = 4;
        } else
            o.integrator = (saltus_integrator)(int)value;
        if (accepted(system, &o, rows[k].word) != rows[k].right)
            fail_msg("%s = %g", rows[k].word, value);
    }
    saltus_flow_options o = saltus_flow_defaults();
    o.columns = 1;
    o.directions = 2; /* more directions than columns */
    assert_false(accepted(system, &o, "directions"));
    saltus_system_free(system);
}

/* The width is that of the instruction set in use: the one named, or the processor's if that is lower. */
static void widths_follow_the_instruction_set(void **unused) {
    (void)unused;
#if defined(__x86_64__)
    static const char *const names[] = {"x86-64", "x86-64-v3", "x86-64-v4"};
    if (!SALTUS_ALL_ISAS)
        skip();
    const char *forced = getenv("SALTUS_ISA");
    char *before = forced ? strdup(forced) : NULL;
    saltus_spec specs[] = {oscillator_spec(0.1, 1, 1, 1), pipe_spec(3, 20)}, stiff = pipe_spec(20, 20);
    saltus_system *stiff_system = build(&stiff);
    __builtin_cpu_init();
    const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"),
               v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512cd");
    double state[3][6];
    for (size_t k = 0; k < 2; k++) {
        saltus_system *system = build(&specs[k]);
        for (int level = 0; level < 3; level++) {
            setenv("SALTUS_ISA", names[level], 1);
            assert_int_equal(saltus_flow_width(system, SALTUS_AUTOMATIC, LLONG_MAX), level == 2 && v4   ? 8
                                                                                     : level >= 1 && v3 ? 4
                                                                                                        : 2);
            assert_int_equal(saltus_flow_width(stiff_system, SALTUS_AUTOMATIC, LLONG_MAX), 1);
            assert_int_equal(saltus_flow_width(system, SALTUS_AUTOMATIC, 1), 1);
            saltus_flow_options options = saltus_flow_defaults();
            saltus_flow *flow = open_flow(system, &options, 0.1, (double[]){0.02, 0.01, 0, 0.1, -0.1, 0});
            advance(flow, 2, 0);
            saltus_flow_state(flow, 0, state[level]);
            saltus_flow_free(flow);
            for (int i = 0; i < saltus_system_dimension(system); i++)
                check_near(state[level][i], state[0][i], 1e-10);
        }
        unsetenv("SALTUS_ISA");
        assert_int_equal(saltus_flow_width(system, SALTUS_AUTOMATIC, LLONG_MAX), v4 ? 8 : v3 ? 4 : 2);
        saltus_system_free(system);
    }
    saltus_system_free(stiff_system);
    if (before)
        setenv("SALTUS_ISA", before, 1);
    free(before);
#endif
}

/* Dense output covers the last step: at its ends it gives the states there, inside it the states of a flow
 * that stops there, and its slope is the field. */
static void dense_output_is_the_motion(void **unused) {
    (void)unused;
    for (int name = 0; name < scenes; name++)
        for (int integrator = SALTUS_TAYLOR; integrator <= SALTUS_RADAU; integrator++) {
            scene s = scene_of((scene_name)name);
            saltus_system *system = build(&s.spec);
            saltus_flow_options options = saltus_flow_defaults();
            const int n = saltus_system_dimension(system);
            const double period = saltus_system_period(system);
            double before[scene_dimension_max], now[scene_dimension_max], inside[scene_dimension_max];
            options.integrator = (saltus_integrator)integrator;
            saltus_flow *flow = open_flow(system, &options, s.phase, s.state), *other = NULL;
            for (int k = 0; k < 12; k++) {
                saltus_flow_state(flow, 0, before);
                saltus_time begin = saltus_flow_time(flow, 0);
                unsigned contacts = saltus_flow_contacts(flow, 0);
                saltus_event event = advance(flow, 9, SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT);
                const double step = saltus_flow_step_length(flow, 0);
                saltus_time from = saltus_flow_step_begin(flow, 0);
                assert_true(step > 0 && from.cycle == begin.cycle && from.phase == begin.phase);
                check_near(saltus_time_periods(saltus_flow_time(flow, 0)) - saltus_time_periods(from),
                           step / period, 1e-14 * (1 + saltus_time_periods(from)));
                saltus_flow_dense(flow, 0, 0, inside);
                for (int i = 0; i < n; i++)
                    check_near(inside[i], before[i], 1e-15 * (1 + fabs(before[i])));
                saltus_flow_dense(flow, 0, step, inside);
                saltus_flow_state(flow, 0, now);
                for (int i = 0; i < n && event.kind == SALTUS_STEP; i++)
                    check_near(inside[i], now[i], 1e-9 * (1e-3 + fabs(now[i])));
                if (contacts == 0) {
                    saltus_message message = {.text = ""};
                    double middle = saltus_time_periods(from) + 0.6 * step / period, whole = floor(middle);
                    if (!other)
                        check_ok(
                            saltus_flow_new((const saltus_system *[]){system}, 1, &options, &other, &message),
                            &message);
                    check_ok(saltus_flow_place(other, 0, from, before, 0, &message), &message);
                    check_ok(saltus_flow_coast(other, 0, (saltus_time){(long long)whole, middle - whole},
                                               NULL, &message),
                             &message);
                    saltus_flow_dense(flow, 0, 0.6 * step, inside);
                    saltus_flow_state(other, 0, now);
                    for (int i = 0; i < n; i++)
                        check_near(inside[i], now[i], 1e-9 * (1e-2 + fabs(now[i])));
                }
            }
            saltus_flow_free(other);
            saltus_flow_free(flow);
            saltus_system_free(system);
        }
}

/* The field is that of the equations of motion, and with the identity as columns the tangent field is its
 * derivative by columns; while a contact holds, both include the contact. */
static void fields_and_their_derivatives(void **unused) {
    (void)unused;
    for (int name = 0; name < scenes; name++)
        for (int held = 0; held < 2; held++) {
            scene s = scene_of((scene_name)name);
            stress_model m;
            saltus_system *system = build(&s.spec);
            const int n = saltus_system_dimension(system), dof = saltus_system_dof(system);
            if (held && saltus_system_face_count(system) == 0) {
                saltus_system_free(system);
                continue;
            }
            saltus_flow_options options = saltus_flow_defaults();
            saltus_message message = {.text = ""};
            saltus_flow *flow = NULL;
            double x[scene_dimension_max], f[scene_dimension_max], a[64], size[64],
                reaction[SALTUS_FACES_MAX];
            double jacobian[scene_dimension_max * scene_dimension_max], above[scene_dimension_max],
                below[scene_dimension_max];
            options.columns = n;
            stress_model_read(&m, &s.spec);
            check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message),
                     &message);
            check_ok(saltus_flow_place(flow, 0, (saltus_time){2, s.phase}, s.state, (unsigned)held, &message),
                     &message);
            saltus_flow_state(flow, 0, x);
            saltus_flow_field(flow, 0, f);
            stress_field(&m, s.phase, x, a, size);
            if (held && stress_reactions(&m, 1, a, reaction))
                stress_react(&m, reaction, a);
            for (int i = 0; i < dof; i++) {
                check_near(f[i], x[dof + i], 0);
                check_near(f[dof + i], a[i], 1e-11 * (1 + size[i]));
            }
            if (m.extra)
                check_near(f[2 * dof], stress_extra_rate(&m, x), 1e-14);
            assert_true(saltus_system_forced(system) ==
                        (s.spec.parameters[0] > 0 && name != scene_steady_pipe));
            saltus_flow_tangent_field(flow, 0, jacobian);
            for (int c = 0; c < n; c++) {
                /* The projection of the field applies to every state, on the stop or not. */
                double h = 1e-6, y[scene_dimension_max], g[64];
                memcpy(y, x, sizeof y);
                y[c] = x[c] + h;
                stress_field(&m, s.phase, y, above, size);
                double z = m.extra ? stress_extra_rate(&m, y) : 0;
                y[c] = x[c] - h;
                stress_field(&m, s.phase, y, below, size);
                z -= m.extra ? stress_extra_rate(&m, y) : 0;
                for (int i = 0; i < dof; i++)
                    g[i] = (above[i] - below[i]) / (2 * h);
                if (held && stress_reactions(&m, 1, g, reaction))
                    stress_react(&m, reaction, g);
                for (int i = 0; i < dof; i++) {
                    check_near(jacobian[c * n + i], c == dof + i, 0);
                    check_near(jacobian[c * n + dof + i], g[i], 1e-5 * (10 + fabs(g[i])));
                }
                if (m.extra)
                    check_near(jacobian[c * n + 2 * dof], z / (2 * h), 1e-7);
            }
            saltus_flow_free(flow);
            saltus_system_free(system);
        }
}

/* Steps and field evaluations are counted. */
static void work_is_counted(void **unused) {
    (void)unused;
    for (int name = 0; name < scenes; name++) {
        scene s = scene_of((scene_name)name);
        saltus_system *system = build(&s.spec);
        saltus_flow_options options = saltus_flow_defaults();
        for (int order = 10; order <= 20; order += 10) {
            options.order = order;
            saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
            long long steps = 0;
            for (;;) {
                saltus_event event = advance(flow, 2, SALTUS_WATCH_STEP);
                steps += event.kind == SALTUS_STEP;
                saltus_flow_info info = saltus_flow_information(flow, 0);
                assert_true(info.field_evaluations == order * info.steps);
                if (event.kind == SALTUS_REACHED)
                    break;
                assert_true(info.steps == steps);
            }
            assert_true(saltus_flow_information(flow, 0).steps == steps + 1);
            saltus_flow_free(flow);
        }
        options = saltus_flow_defaults();
        options.integrator = SALTUS_RADAU;
        saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
        advance(flow, 1, 0);
        assert_true(saltus_flow_information(flow, 0).field_evaluations >=
                    16 * saltus_flow_information(flow, 0).steps);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* A chatter's flights need fewer orders than with a requested order; the result is the same within the
 * tolerance. */
static void short_flights_take_few_orders(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 10);
    add_stop(&spec, 0.025, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    const int n = saltus_system_dimension(system);
    double start[scene_dimension_max], state[2][scene_dimension_max];
    saltus_message message = {.text = ""};
    saltus_flow_info info[2];
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = 1e-10;
    options.atol = 1e-13;
    check_ok(saltus_system_default_state(system, start, &message), &message);
    for (int asked = 0; asked < 2; asked++) {
        saltus_flow *flow = open_flow(system, &options, 0, start);
        advance(flow, 1, SALTUS_WATCH_STEP);
        options.order = (int)saltus_flow_information(flow, 0).field_evaluations;
        advance(flow, 20, 0);
        saltus_flow_state(flow, 0, state[asked]);
        info[asked] = saltus_flow_information(flow, 0);
        saltus_flow_free(flow);
    }
    assert_true(info[0].sticks > 5 && info[0].sticks == info[1].sticks);
    assert_true(info[1].field_evaluations == options.order * info[1].steps);
    assert_true((double)info[0].field_evaluations < 0.8 * (double)(options.order * info[0].steps));
    for (int i = 0; i < n; i++)
        check_near(state[0][i], state[1][i], 100 * options.rtol * saltus_system_scale(system)[i]);
    saltus_system_free(system);
}

/* The order chosen from the tolerance costs little more than the best one, for the pipe on which it was
 * measured. A step of a series of products costs about the square of its order. */
static void the_order_is_chosen_well(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 20);
    saltus_system *system = build(&spec);
    const double state[10] = {0.02, 0.01};
    for (int digits = 5; digits <= 14; digits += 3) {
        double best = INFINITY, chosen = 0;
        for (int order = 0; order <= 40; order += order ? 2 : 8) {
            saltus_flow_options options = saltus_flow_defaults();
            options.rtol = pow(10, -digits);
            options.order = order;
            saltus_flow *flow = open_flow(system, &options, 0, state);
            advance(flow, 10, 0);
            saltus_flow_info info = saltus_flow_information(flow, 0);
            double evaluations = (double)info.field_evaluations,
                   cost = evaluations * evaluations / (double)info.steps;
            best = order ? fmin(best, cost) : best;
            chosen = order ? chosen : cost;
            saltus_flow_free(flow);
        }
        if (!(chosen <= 1.35 * best))
            fail_msg("rtol 1e-%d: %.3g times the cost of the best order", digits, chosen / best);
    }
    saltus_system_free(system);
}

/* A run that is asked to stop returns after its last step, still aimed. Without the request it goes on from
 * there and ends as if never interrupted. */
static void an_interrupted_run_goes_on(void **unused) {
    (void)unused;
    volatile sig_atomic_t stop = 0;
    scene s = scene_of(scene_two_sided_mass);
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_event event;
    double whole[2], parts[2];
    int lane = 7;
    options.stop = &stop;
    saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
    advance(flow, 3, 0);
    saltus_flow_state(flow, 0, whole);
    saltus_flow_free(flow);
    flow = open_flow(system, &options, s.phase, s.state);
    saltus_flow_aim(flow, 0, (saltus_time){3, 0}, SALTUS_WATCH_IMPACT);
    check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
    saltus_time there = saltus_flow_time(flow, 0);
    stop = 1;
    saltus_flow_aim(flow, 0, (saltus_time){3, 0}, 0);
    for (int again = 0; again < 2; again++)
        assert_int_equal(saltus_flow_run(flow, &lane, &event, &message), SALTUS_INTERRUPTED);
    assert_non_null(strstr(message.text, "interrupted"));
    assert_true(saltus_flow_time(flow, 0).cycle == there.cycle &&
                saltus_flow_time(flow, 0).phase == there.phase);
    stop = 0;
    check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
    assert_int_equal(event.kind, SALTUS_REACHED);
    saltus_flow_state(flow, 0, parts);
    assert_memory_equal(parts, whole, sizeof whole);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Everything that can be asked of a lane, as a list of numbers. */
static int tell(saltus_flow *flow, int lane, double *out) {
    const saltus_system *system = saltus_flow_system(flow, lane);
    const int n = saltus_system_dimension(system), columns = saltus_flow_columns(flow);
    saltus_flow_info info = saltus_flow_information(flow, lane);
    double *at = out;
    saltus_flow_state(flow, lane, at);
    saltus_flow_tangents(flow, lane, at += n);
    saltus_flow_delays(flow, lane, at += columns * n);
    saltus_flow_dense(flow, lane, 0.3 * saltus_flow_step_length(flow, lane), at += columns);
    saltus_flow_field(flow, lane, at += n);
    saltus_flow_forces(flow, lane, at += n);
    at += SALTUS_FACES_MAX;
    const double more[] = {(double)info.steps,
                           (double)info.impacts,
                           (double)info.sticks,
                           (double)info.releases,
                           (double)info.field_evaluations,
                           info.log_volume,
                           (double)saltus_flow_contacts(flow, lane),
                           saltus_time_periods(saltus_flow_time(flow, lane)),
                           saltus_time_periods(saltus_flow_step_begin(flow, lane)),
                           saltus_flow_step_length(flow, lane)};
    memcpy(at, more, sizeof more);
    return (int)(at - out) + (int)(sizeof more / sizeof more[0]);
}

enum { told_max = 400, lane_events_max = 400 };

typedef struct lane_log {
    int count;
    saltus_event event[lane_events_max];
    double last[told_max];
} lane_log;

static scene varied(scene_name name, int k) {
    scene s = scene_of(name);
    set_parameter(&s.spec, "omega", saltus_spec_get(&s.spec, "omega") * (1 + 0.03 * k));
    for (int i = 0; i < s.spec.stop_count; i++)
        s.spec.stops[i].d *= 1 + 0.02 * k;
    for (int i = 0; i < scene_dimension_max; i++)
        s.state[i] *= 1 - 0.04 * k;
    return s;
}

static const unsigned lane_watch = SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING;

/* Lanes of one flow do exactly what single flows would do, and report the same. */
static void lanes_are_flows_of_their_own(void **unused) {
    (void)unused;
    static lane_log alone[widest], together[widest];
    for (int name = 0; name < scenes; name++) {
        scene s[widest];
        saltus_system *systems[widest];
        const saltus_system *list[widest];
        saltus_flow_options options = saltus_flow_defaults();
        saltus_message message = {.text = ""};
        saltus_event event;
        options.columns = 2;
        options.integrator = SALTUS_TAYLOR;
        for (int l = 0; l < widest; l++) {
            s[l] = varied((scene_name)name, l);
            list[l] = systems[l] = build(&s[l].spec);
        }
        const int width = saltus_flow_width(systems[0], SALTUS_AUTOMATIC, LLONG_MAX),
                  used = width > 2 ? width - 1 : width;
        for (int l = 0; l < used; l++) {
            saltus_flow *flow = open_flow(systems[l], &options, s[l].phase, s[l].state);
            alone[l].count = 0;
            for (;;) {
                check_ok(
                    saltus_flow_advance(flow, (saltus_time){2, 0.1 * (l % 10)}, lane_watch, &event, &message),
                    &message);
                if (event.kind == SALTUS_REACHED)
                    break;
                alone[l].event[alone[l].count++] = event;
            }
            tell(flow, 0, alone[l].last);
            saltus_flow_free(flow);
            together[l].count = 0;
        }
        saltus_flow *flow = NULL;
        check_ok(saltus_flow_new(list, used, &options, &flow, &message), &message);
        for (int l = 0; l < used; l++) {
            assert_ptr_equal(saltus_flow_system(flow, l), systems[l]);
            check_ok(saltus_flow_start(flow, l, (saltus_time){0, s[l].phase}, s[l].state, &message),
                     &message);
            saltus_flow_aim(flow, l, (saltus_time){2, 0.1 * (l % 10)}, lane_watch);
        }
        for (int done = 0; done < used;) {
            int lane = -1;
            check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
            assert_true(lane >= 0 && lane < used);
            if (event.kind == SALTUS_REACHED) {
                int length = tell(flow, lane, together[lane].last);
                assert_true(length <= told_max);
                for (int i = 0; i < length; i++)
                    if (!(together[lane].last[i] == alone[lane].last[i]))
                        fail_msg("scene %d, lane %d, number %d: %.17g and %.17g", name, lane, i,
                                 together[lane].last[i], alone[lane].last[i]);
                done++;
                continue;
            }
            together[lane].event[together[lane].count++] = event;
            saltus_flow_aim(flow, lane, (saltus_time){2, 0.1 * (lane % 10)}, lane_watch);
        }
        for (int l = 0; l < used; l++) {
            assert_int_equal(together[l].count, alone[l].count);
            for (int k = 0; k < alone[l].count; k++) {
                const saltus_event *a = &alone[l].event[k], *b = &together[l].event[k];
                assert_true(a->kind == b->kind && a->face == b->face && a->time.cycle == b->time.cycle &&
                            a->time.phase == b->time.phase && a->velocity_before == b->velocity_before &&
                            a->velocity_after == b->velocity_after && a->displacement == b->displacement);
            }
        }
        /* The tangent field of every lane is that of a single flow. */
        double field[told_max], own[told_max], state[scene_dimension_max], tangents[told_max];
        const int n = saltus_system_dimension(systems[0]);
        for (int l = 0; l < used; l++) {
            saltus_flow *single = NULL;
            saltus_time now = saltus_flow_time(flow, l);
            saltus_flow_state(flow, l, state);
            saltus_flow_tangents(flow, l, tangents);
            saltus_flow_tangent_field(flow, l, field);
            check_ok(saltus_flow_new(&list[l], 1, &options, &single, &message), &message);
            check_ok(saltus_flow_place(single, 0, now, state, saltus_flow_contacts(flow, l), &message),
                     &message);
            saltus_flow_set_tangents(single, 0, tangents);
            saltus_flow_tangent_field(single, 0, own);
            for (int i = 0; i < 2 * n; i++)
                check_near(field[i], own[i], 1e-11 * (1 + fabs(own[i])));
            saltus_flow_free(single);
        }
        saltus_flow_free(flow);
        for (int l = 0; l < widest; l++)
            saltus_system_free(systems[l]);
    }
}

/* Systems that cannot run side by side are refused. */
static void unlike_lanes_are_refused(void **unused) {
    (void)unused;
    scene s = scene_of(scene_two_sided_mass), t[5] = {s, s, s, s, scene_of(scene_struck_pipe)};
    t[0].spec.stops[0].sides = SALTUS_UPPER;
    set_parameter(&t[1].spec, "N", 2);
    set_parameter(&t[2].spec, "kz", 1);
    set_parameter(&t[3].spec, "F", 0); /* other terms */
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    for (int k = 0; k < 5; k++) {
        saltus_flow *flow = (saltus_flow *)1;
        saltus_system *other = build(&t[k].spec);
        const saltus_system *both[] = {system, other};
        assert_int_equal(saltus_flow_new(both, 2, &options, &flow, &message), SALTUS_BAD_INPUT);
        assert_null(flow);
        both[1] = system;
        check_ok(saltus_flow_new(both, 2, &options, &flow, &message), &message);
        assert_int_equal(saltus_flow_retune(flow, 1, other, &message), SALTUS_BAD_INPUT);
        saltus_flow_free(flow);
        check_ok(saltus_flow_new(both, 1, &options, &flow, &message), &message);
        assert_int_equal(saltus_flow_retune(flow, 0, other, &message), k == 3 ? SALTUS_OK : SALTUS_BAD_INPUT);
        saltus_flow_free(flow);
        saltus_system_free(other);
    }
    const saltus_system *many[widest + 1];
    for (int l = 0; l <= widest; l++)
        many[l] = system;
    saltus_flow *flow = NULL;
    const int width = saltus_flow_width(system, SALTUS_AUTOMATIC, LLONG_MAX);
    assert_int_equal(saltus_flow_new(many, width + 1, &options, &flow, &message), SALTUS_BAD_INPUT);
    static const int none[] = {0, -1};
    char range[40];
    snprintf(range, sizeof range, "from 1 to %d", width);
    assert_non_null(strstr(message.text, range));
    for (int k = 0; k < 2; k++) {
        assert_int_equal(saltus_flow_new(many, none[k], &options, &flow, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, range));
        assert_null(flow);
    }
    options.integrator = SALTUS_RADAU;
    assert_int_equal(saltus_flow_new(many, 2, &options, &flow, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "from 1 to 1"));
    saltus_system_free(system);
}

/* A lane whose motion grows without bound fails alone; the other reaches its target as a single flow
 * would. */
static void a_failing_lane_leaves_the_others_alone(void **unused) {
    (void)unused;
    saltus_spec spec[2];
    saltus_system *systems[2];
    const saltus_system *list[2];
    const double start[2] = {1e-3, 0};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_event event;
    for (int l = 0; l < 2; l++) {
        spec[l] = pipe_spec(1, 3);
        set_parameter(&spec[l], "kappa", 0);
        set_parameter(&spec[l], "u0", l ? 2 : 90);
        list[l] = systems[l] = build(&spec[l]);
    }
    double alone[2], state[2];
    saltus_flow *flow = open_flow(systems[1], &options, 0, start);
    advance(flow, 3, 0);
    saltus_flow_state(flow, 0, alone);
    saltus_flow_free(flow);
    check_ok(saltus_flow_new(list, 2, &options, &flow, &message), &message);
    for (int l = 0; l < 2; l++) {
        check_ok(saltus_flow_start(flow, l, (saltus_time){0, 0}, start, &message), &message);
        saltus_flow_aim(flow, l, (saltus_time){3, 0}, 0);
    }
    int failed = 0, reached = 0;
    for (int k = 0; k < 2; k++) {
        int lane = -1;
        saltus_status status = saltus_flow_run(flow, &lane, &event, &message);
        failed += status == SALTUS_STALLED && lane == 0 && strstr(message.text, "periods");
        if (status == SALTUS_OK && lane == 1) {
            saltus_flow_state(flow, 1, state);
            assert_memory_equal(state, alone, sizeof alone);
            reached++;
        }
    }
    assert_true(failed == 1 && reached == 1);
    /* The failed lane stays where it failed, and can be started anew. */
    saltus_time there = saltus_flow_time(flow, 0);
    assert_true(saltus_time_periods(there) > 0 && saltus_time_periods(there) < 3);
    int lane = -1;
    saltus_flow_aim(flow, 1, (saltus_time){4, 0}, 0);
    check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
    assert_true(lane == 1 && saltus_flow_time(flow, 0).phase == there.phase);
    check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, &message), &message);
    saltus_flow_aim(flow, 0, (saltus_time){0, 0.125}, 0);
    check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
    assert_true(lane == 0 && event.kind == SALTUS_REACHED);
    saltus_flow_free(flow);
    saltus_system_free(systems[0]);
    saltus_system_free(systems[1]);
}

/* A motion that grows without bound ends before its state overflows: with either integrator the lane stays at
 * the last time with a finite state, however often it is asked to go on, and can be started anew. */
static void what_flies_away_stays_where_numbers_end(void **unused) {
    (void)unused;
    static const int modes[] = {1, 3, 12};
    for (int k = 0; k < 6; k++) {
        const int n = 2 * modes[k % 3];
        const double start[24] = {1e-3};
        double there[24], state[24], largest = 0;
        saltus_spec spec = pipe_spec(modes[k % 3], 3);
        set_parameter(&spec, "kappa", 0);
        set_parameter(&spec, "u0", 90);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        options.integrator = k < 3 ? SALTUS_TAYLOR : SALTUS_RADAU;
        saltus_flow *flow = open_flow(system, &options, 0, start);
        saltus_time time = {0, 0};
        for (int again = 0; again < 3; again++) {
            saltus_message message = {.text = ""};
            saltus_event event;
            assert_int_equal(saltus_flow_advance(flow, (saltus_time){5, 0}, 0, &event, &message),
                             SALTUS_STALLED);
            assert_true(message.text[0]);
            saltus_flow_state(flow, 0, again ? state : there);
            if (again) {
                assert_memory_equal(state, there, (size_t)n * sizeof *state);
                assert_true(saltus_flow_time(flow, 0).phase == time.phase);
            }
            time = saltus_flow_time(flow, 0);
        }
        assert_true(saltus_time_periods(time) > 0 && saltus_time_periods(time) < 5);
        for (int i = 0; i < n; i++) {
            assert_true(isfinite(there[i]));
            largest = fmax(largest, fabs(there[i]));
        }
        assert_true(largest > 1e200);
        saltus_message message = {.text = ""};
        check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, &message), &message);
        advance(flow, 0.01, 0);
        saltus_flow_state(flow, 0, state);
        saltus_flow_free(flow);
        flow = open_flow(system, &options, 0, start);
        advance(flow, 0.01, 0);
        saltus_flow_state(flow, 0, there);
        assert_memory_equal(state, there, (size_t)n * sizeof *state);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* A lane that was reported stays where it is while others run, until it is aimed again; then it goes on as if
 * it had not waited. */
static void a_lane_waits_until_it_is_aimed_again(void **unused) {
    (void)unused;
    scene s[2] = {varied(scene_two_sided_mass, 0), varied(scene_two_sided_mass, 1)};
    saltus_system *systems[2] = {build(&s[0].spec), build(&s[1].spec)};
    const saltus_system *list[2] = {systems[0], systems[1]};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_event event;
    saltus_flow *flow = NULL;
    double state[2], now[2], tangents[4], later[4], alone[2];
    int lane = -1;
    options.columns = 2;
    saltus_flow *single = open_flow(systems[0], &options, s[0].phase, s[0].state);
    advance(single, 0.75, 0);
    advance(single, 2, 0);
    saltus_flow_state(single, 0, alone);
    saltus_flow_free(single);
    check_ok(saltus_flow_new(list, 2, &options, &flow, &message), &message);
    for (int l = 0; l < 2; l++) {
        check_ok(saltus_flow_start(flow, l, (saltus_time){0, s[l].phase}, s[l].state, &message), &message);
        saltus_flow_aim(flow, l, (saltus_time){l ? 3 : 0, l ? 0 : 0.75}, 0);
    }
    check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
    assert_int_equal(lane, 0);
    saltus_flow_state(flow, 0, state);
    saltus_flow_tangents(flow, 0, tangents);
    saltus_flow_info info = saltus_flow_information(flow, 0);
    check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
    assert_int_equal(lane, 1);
    saltus_flow_state(flow, 0, now);
    saltus_flow_tangents(flow, 0, later);
    assert_memory_equal(now, state, sizeof now);
    assert_memory_equal(later, tangents, sizeof later);
    assert_true(saltus_flow_time(flow, 0).cycle == 0 && saltus_flow_time(flow, 0).phase == 0.75);
    assert_true(saltus_flow_information(flow, 0).steps == info.steps);
    saltus_flow_aim(flow, 0, (saltus_time){2, 0}, 0);
    check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
    assert_int_equal(lane, 0);
    saltus_flow_state(flow, 0, now);
    assert_memory_equal(now, alone, sizeof now);
    saltus_flow_free(flow);
    saltus_system_free(systems[0]);
    saltus_system_free(systems[1]);
}

/* A lane that is started again is reset: no counts, no contact, no force at any face, tangent vectors of the
 * identity, parameter columns zero. */
static void a_started_lane_begins_anew(void **unused) {
    (void)unused;
    for (int name = 0; name < scenes; name++) {
        scene s = scene_of((scene_name)name);
        saltus_system *system = build(&s.spec);
        const int n = saltus_system_dimension(system);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_message message = {.text = ""};
        saltus_direction direction;
        double columns[scene_columns_max * scene_dimension_max], forces[SALTUS_FACES_MAX];
        options.directions = 1;
        options.columns = n + 1;
        check_ok(saltus_spec_direction(&s.spec, "omega", &direction, NULL, &message), &message);
        saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
        saltus_flow_set_directions(flow, &direction);
        for (int again = 0; again < 2; again++) {
            check_ok(saltus_flow_start(flow, 0, (saltus_time){0, s.phase}, s.state, &message), &message);
            saltus_flow_info info = saltus_flow_information(flow, 0);
            assert_true(info.steps == 0 && info.field_evaluations == 0 && info.impacts == 0 &&
                        info.sticks == 0 && info.releases == 0 && info.log_volume == 0);
            for (int f = 0; f < SALTUS_FACES_MAX; f++)
                forces[f] = NAN;
            saltus_flow_forces(flow, 0, forces);
            assert_int_equal(saltus_flow_contacts(flow, 0), 0);
            for (int f = 0; f < SALTUS_FACES_MAX; f++)
                assert_true(forces[f] == 0);
            saltus_flow_tangents(flow, 0, columns);
            for (int i = 0; i < options.columns * n; i++)
                assert_true(columns[i] == (i / n == i % n));
            advance(flow, 2, 0);
            assert_true(saltus_flow_information(flow, 0).steps > 0);
        }
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* At a start on a stop and moving into it, the impact also acts on the tangent vectors: they are the
 * derivatives of later states by displacements towards the inside. */
static void an_impact_at_the_start_acts_on_tangents(void **unused) {
    (void)unused;
    const double step = 1e-6, on[2] = {0.3, 0.5};
    saltus_spec spec = oscillator_spec(0.1, 1, 0.8, 1.1);
    add_stop(&spec, 0.3, 0.7, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double columns[4], end[2], beside[2];
    options.columns = 2;
    saltus_flow *flow = open_flow(system, &options, 0.2, on);
    assert_true(saltus_flow_information(flow, 0).impacts == 1);
    for (int later = 0; later < 2; later++) {
        if (later)
            advance(flow, 0.4, 0);
        saltus_flow_state(flow, 0, end);
        saltus_flow_tangents(flow, 0, columns);
        for (int c = 0; c < 2; c++) {
            double moved[2] = {on[0], on[1]};
            if (c == 0 && !later)
                continue; /* the disturbed start has no impact yet */
            moved[c] -= step;
            saltus_flow *other = open_flow(system, &options, 0.2, moved);
            if (later)
                advance(other, 0.4, 0);
            saltus_flow_state(other, 0, beside);
            for (int i = 0; i < 2; i++)
                check_near(columns[2 * c + i], (end[i] - beside[i]) / step, 1e-4);
            saltus_flow_free(other);
        }
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A time that is not a finite number is refused, as a start and as a target. The lane stays as it was and
 * goes on to a valid target. */
static void times_are_numbers(void **unused) {
    (void)unused;
    static const double wrong[] = {NAN, INFINITY, -INFINITY, 1e16};
    scene s = scene_of(scene_two_sided_mass);
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_event event;
    double whole[2], state[2], now[2];
    saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
    advance(flow, 1.5, 0);
    saltus_flow_state(flow, 0, state);
    advance(flow, 2.5, 0);
    saltus_flow_state(flow, 0, whole);
    saltus_flow_free(flow);
    flow = open_flow(system, &options, s.phase, s.state);
    advance(flow, 1.5, 0);
    for (int k = 0; k < 4; k++) {
        saltus_time time = {2, wrong[k]};
        assert_int_equal(saltus_flow_start(flow, 0, time, s.state, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, "phase = "));
        message.text[0] = 0;
        assert_int_equal(saltus_flow_advance(flow, time, 0, &event, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, "phase = "));
        saltus_flow_state(flow, 0, now);
        assert_memory_equal(now, state, sizeof now);
        assert_true(saltus_flow_time(flow, 0).cycle == 1 && saltus_flow_time(flow, 0).phase == 0.5);
    }
    advance(flow, 2.5, 0);
    saltus_flow_state(flow, 0, now);
    assert_memory_equal(now, whole, sizeof now);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A run is given up once a period is seen to need more steps than allowed, and not otherwise. */
static void steps_are_limited(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(2, 10);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_event event;
    const double state[4] = {1e-3};
    saltus_flow *flow = open_flow(system, &options, 0, state);
    check_ok(saltus_flow_advance(flow, (saltus_time){1, 0}, 0, &event, &message), &message);
    double steps = (double)saltus_flow_information(flow, 0).steps;
    for (int fewer = 0; fewer < 3; fewer++) {
        saltus_flow_limit_steps(flow, fewer == 0 ? 2 * steps : fewer == 1 ? 0.5 * steps : 0);
        check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, &message), &message);
        saltus_status status = saltus_flow_advance(flow, (saltus_time){1, 0}, 0, &event, &message);
        assert_int_equal(status, fewer == 1 ? SALTUS_STALLED : SALTUS_OK);
        if (fewer == 1)
            assert_true((double)saltus_flow_information(flow, 0).steps < 0.5 * steps + 2);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Bounces on a stop with r = 1, too fast to advance time, do not go on for ever: the flow reports time, gap
 * and speed, and stays there. */
static void bounces_without_end_are_told(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 0, 0, 0.01);
    set_parameter(&spec, "F0", 0.01);
    add_stop(&spec, 0, 1, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_event event;
    const double state[2] = {0, 1e-17};
    options.atol = 0;
    options.rtol = 1e-15;
    saltus_flow *flow = open_flow(system, &options, 0.9, state);
    assert_int_equal(saltus_flow_advance(flow, (saltus_time){1, 0}, 0, &event, &message), SALTUS_STALLED);
    assert_non_null(strstr(message.text, "0.9 periods"));
    assert_non_null(strstr(message.text, "gap 0, speed 1e-17"));
    assert_true(saltus_flow_time(flow, 0).cycle == 0);
    check_near(saltus_flow_time(flow, 0).phase, 0.9, 1e-12);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* The error over free flight follows the tolerance: never far above it, and not far below, which would mean
 * steps shorter than needed. */
static void errors_follow_the_tolerance(void **unused) {
    (void)unused;
    static const scene_name names[] = {scene_free_pipe, scene_free_chain, scene_two_sided_mass};
    for (int k = 0; k < 12; k++)
        for (int integrator = SALTUS_TAYLOR; integrator <= SALTUS_RADAU; integrator++) {
            scene s = varied(names[k % 3], k);
            saltus_flow_options options = saltus_flow_defaults();
            if (integrator == SALTUS_RADAU && k % 3 == 1)
                continue; /* a Maxwell element: this tolerance is too loose for it */
            s.spec.stop_count = 0;
            saltus_system *system = build(&s.spec);
            double exact[scene_dimension_max], state[scene_dimension_max], middle = 0;
            const double *scale = saltus_system_scale(system);
            const int n = saltus_system_dimension(system);
            options.rtol = 1e-15;
            options.atol = 0;
            saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
            advance(flow, 3, 0);
            saltus_flow_state(flow, 0, exact);
            saltus_flow_free(flow);
            for (int digits = 4; digits <= 11; digits++) {
                double error = 0;
                options.rtol = pow(10, -digits);
                options.integrator = (saltus_integrator)integrator;
                flow = open_flow(system, &options, s.phase, s.state);
                advance(flow, 3, 0);
                saltus_flow_state(flow, 0, state);
                saltus_flow_free(flow);
                for (int i = 0; i < n; i++)
                    error = fmax(error, fabs(state[i] - exact[i]) / scale[i]);
                middle += log10(error / options.rtol + 1e-9) / 8;
                if (!(error <= 20 * options.rtol))
                    fail_msg("scene %d, integrator %d: error %.3g at rtol %g", k, integrator, error,
                             options.rtol);
            }
            /* The mean, in powers of ten. */
            assert_true(middle < 0.5 && (integrator == SALTUS_RADAU || middle > -1.9));
            saltus_system_free(system);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_as_stated),
        cmocka_unit_test(phases_are_told_within_a_period),
        cmocka_unit_test(limits_are_as_stated),
        cmocka_unit_test(widths_follow_the_instruction_set),
        cmocka_unit_test(dense_output_is_the_motion),
        cmocka_unit_test(fields_and_their_derivatives),
        cmocka_unit_test(work_is_counted),
        cmocka_unit_test(short_flights_take_few_orders),
        cmocka_unit_test(the_order_is_chosen_well),
        cmocka_unit_test(an_interrupted_run_goes_on),
        cmocka_unit_test(lanes_are_flows_of_their_own),
        cmocka_unit_test(unlike_lanes_are_refused),
        cmocka_unit_test(a_failing_lane_leaves_the_others_alone),
        cmocka_unit_test(what_flies_away_stays_where_numbers_end),
        cmocka_unit_test(a_lane_waits_until_it_is_aimed_again),
        cmocka_unit_test(a_started_lane_begins_anew),
        cmocka_unit_test(an_impact_at_the_start_acts_on_tangents),
        cmocka_unit_test(times_are_numbers),
        cmocka_unit_test(steps_are_limited),
        cmocka_unit_test(bounces_without_end_are_told),
        cmocka_unit_test(errors_follow_the_tolerance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
