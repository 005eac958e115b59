/* Prescribed events: the extremes that a coast collects against dense sampling, and the derivatives that a
 * strike reports against differences of whole runs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes.h"
#include "stress_field.h"

enum { grid = 300 };

static saltus_time at(double periods) {
    double whole = floor(periods);
    return (saltus_time){(long long)whole, periods - whole};
}

static void coast(saltus_flow *flow, double until, saltus_extreme *extremes) {
    saltus_message message = {.text = ""};
    check_ok(saltus_flow_coast(flow, 0, at(until), extremes, &message), &message);
}

static saltus_flow *open_placed(const saltus_system *system, const saltus_flow_options *options, double phase,
                                const double *state, unsigned contacts) {
    saltus_message message = {.text = ""};
    saltus_flow *flow = NULL;
    check_ok(saltus_flow_new(&system, 1, options, &flow, &message), &message);
    check_ok(saltus_flow_place(flow, 0, (saltus_time){0, phase}, state, contacts, &message), &message);
    return flow;
}

static void forget(saltus_extreme *extremes) {
    for (int f = 0; f < SALTUS_FACES_MAX; f++)
        extremes[f] = (saltus_extreme){.value = -INFINITY, .inner = -INFINITY};
}

/* What must stay below zero: the gap of a free face, minus the contact force of one that holds, from the
 * equations of motion. */
static double quantity(const stress_model *m, unsigned contacts, int face, double phase, const double *x) {
    double a[stress_dof_max], size[stress_dof_max], reaction[SALTUS_FACES_MAX];
    if (!(contacts >> face & 1))
        return stress_gap(m, face, x);
    stress_field(m, phase, x, a, size);
    unsigned others = contacts & ~(1u << face);
    if (others && stress_reactions(m, others, a, reaction))
        stress_react(m, reaction, a);
    return -stress_normal(m, face, a);
}

typedef struct tops {
    double value[SALTUS_FACES_MAX];
    double force_size;
} tops;

/* The highest local maxima of a dense sampling, refined by a parabola through three samples. */
static tops sample(const scene *s, const saltus_system *system, const saltus_flow_options *options,
                   unsigned contacts, double periods) {
    stress_model m;
    tops t;
    double x[scene_dimension_max], value[3][SALTUS_FACES_MAX];
    stress_model_read(&m, &s->spec);
    for (int f = 0; f < SALTUS_FACES_MAX; f++)
        t.value[f] = -INFINITY;
    saltus_flow *flow = open_placed(system, options, s->phase, s->state, contacts);
    for (int k = 0; k <= grid; k++) {
        coast(flow, s->phase + periods * k / grid, NULL);
        saltus_flow_state(flow, 0, x);
        for (int f = 0; f < m.face_count; f++) {
            double *y = value[k % 3];
            y[f] = quantity(&m, contacts, f, saltus_flow_time(flow, 0).phase, x);
            double before = value[(k + 1) % 3][f], middle = value[(k + 2) % 3][f];
            if (k < 2 || middle < before || middle < y[f] || (middle == before && middle == y[f]))
                continue;
            double slope = 0.5 * (y[f] - before), bend = y[f] - 2 * middle + before;
            t.value[f] = fmax(t.value[f], middle - 0.5 * slope * slope / bend);
        }
    }
    saltus_flow_free(flow);
    return t;
}

/* The quantity at a time, by a separate coast. */
static double quantity_at(const scene *s, const saltus_system *system, const saltus_flow_options *options,
                          unsigned contacts, int face, saltus_time time) {
    stress_model m;
    double x[scene_dimension_max];
    stress_model_read(&m, &s->spec);
    saltus_flow *flow = open_placed(system, options, s->phase, s->state, contacts);
    coast(flow, saltus_time_periods(time), NULL);
    saltus_flow_state(flow, 0, x);
    saltus_flow_free(flow);
    return quantity(&m, contacts, face, time.phase, x);
}

/* Whether another face of the same stop is held, so that this free face does not move. */
static bool stands_still(const saltus_system *system, int face, unsigned contacts) {
    bool still = false;
    for (int g = 0; g < saltus_system_face_count(system); g++)
        still |= g != face && contacts >> g & 1 &&
                 saltus_system_face(system, g).stop == saltus_system_face(system, face).stop;
    return still;
}

static int check_extremes(const scene *s, saltus_flow_options options, unsigned contacts, double periods) {
    saltus_system *system = build(&s->spec);
    saltus_extreme whole[SALTUS_FACES_MAX], parts[SALTUS_FACES_MAX];
    tops t = sample(s, system, &options, contacts, periods);
    forget(whole);
    forget(parts);
    saltus_flow *flow = open_placed(system, &options, s->phase, s->state, contacts);
    coast(flow, s->phase + periods, whole);
    saltus_flow_free(flow);
    flow = open_placed(system, &options, s->phase, s->state, contacts);
    for (int k = 1; k <= 5; k++)
        coast(flow, k < 5 ? s->phase + 0.213 * k * periods : s->phase + periods, parts);
    saltus_flow_free(flow);
    int found = 0;
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        const double size = contacts >> f & 1 ? 30 : 0.1;
        if (stands_still(system, f, contacts))
            continue;
        /* The sampling cannot see a maximum within its first or last interval. */
        double place = (saltus_time_periods(whole[f].time) - s->phase) / periods * grid;
        bool hidden = whole[f].value > -INFINITY && (place < 1.01 || place > grid - 1.01);
        if (!hidden && t.value[f] == -INFINITY)
            assert_true(whole[f].value == -INFINITY);
        else if (!hidden)
            check_near(whole[f].value, t.value[f], 1e-4 * size);
        else
            assert_true(whole[f].value >= t.value[f] - 1e-4 * size);
        if (whole[f].value == -INFINITY)
            continue;
        found++;
        check_near(parts[f].value, whole[f].value, 1e-9 * size);
        check_near(quantity_at(s, system, &options, contacts, f, whole[f].time), whole[f].value, 1e-9 * size);
        check_near(quantity_at(s, system, &options, contacts, f, parts[f].time), whole[f].value, 1e-9 * size);
    }
    for (int f = saltus_system_face_count(system); f < SALTUS_FACES_MAX; f++)
        assert_true(whole[f].value == -INFINITY);
    saltus_system_free(system);
    return found;
}

/* Free, and with each face held; with both integrators, and with steps so long that they hold several
 * extremes; also coasts too short for any. */
static void a_coast_collects_what_a_dense_sampling_finds(void **unused) {
    (void)unused;
    static const scene_name names[] = {scene_struck_pipe,     scene_two_sided_pipe, scene_chattering_pipe,
                                       scene_two_sided_mass,  scene_struck_chain,   scene_caught_chain,
                                       scene_maxwell_mass,    scene_impact_pair,    scene_steady_pipe,
                                       scene_chattering_mass, scene_caught_pipe};
    int found = 0;
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        scene s = scene_of(names[k]);
        saltus_system *system = build(&s.spec);
        const int faces = saltus_system_face_count(system);
        saltus_system_free(system);
        static const double periods[] = {0.15, 0.4, 2.3};
        for (int j = 0; j < 9; j++) {
            saltus_flow_options options = saltus_flow_defaults();
            options.integrator = j % 3 == 1 ? SALTUS_RADAU : SALTUS_TAYLOR;
            if (j % 3 == 2) {
                options.rtol = 1e-9;
                options.order = 40;
            }
            found += check_extremes(&s, options, 0, periods[j / 3]);
            for (int f = 0; f < faces && j / 3 > 0; f++)
                found += check_extremes(&s, options, 1u << f, periods[j / 3]);
        }
    }
    assert_true(found > 40);
}

/* Extremes are only raised; a coast to the present time does nothing, one to the past is refused. */
static void a_coast_only_raises_its_extremes(void **unused) {
    (void)unused;
    scene s = scene_of(scene_two_sided_mass);
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_extreme extremes[SALTUS_FACES_MAX];
    forget(extremes);
    extremes[0] = (saltus_extreme){.value = 1e3, .time = {-7, 0.5}};
    saltus_flow *flow = open_placed(system, &options, s.phase, s.state, 0);
    coast(flow, s.phase, extremes);
    assert_true(extremes[1].value == -INFINITY && saltus_flow_information(flow, 0).steps == 0);
    coast(flow, s.phase + 2, extremes);
    assert_true(extremes[0].value == 1e3 && extremes[0].time.cycle == -7 && extremes[1].value > 0);
    assert_int_equal(saltus_flow_information(flow, 0).impacts, 0);
    assert_int_equal(saltus_flow_coast(flow, 0, at(s.phase + 1), extremes, &message), SALTUS_NO_CONVERGENCE);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A run of prescribed events: coast and strike in turn, then coast to the end. */
typedef struct program {
    int strikes;
    double time[4]; /* of the strikes, in periods */
    saltus_event_kind kind[4];
    int face[4];
    double end;
} program;

typedef struct result {
    double state[scene_dimension_max];
    saltus_strike strike[4];
    double gradient[4][scene_columns_max], speed_gradient[4][scene_columns_max],
        shift[4][scene_dimension_max];
    double
        columns[scene_columns_max * scene_dimension_max]; /* the flow's, or in the first the carried shift */
} result;

/* Run a program; with `carried` >= 0 the first tangent vector becomes that strike's shift after it. */
static void perform(const scene *s, const program *p, saltus_integrator integrator,
                    const saltus_direction *directions, int carried, result *r) {
    saltus_system *system = build(&s->spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    const int n = saltus_system_dimension(system);
    options.integrator = integrator;
    options.directions = directions ? 1 : 0;
    options.columns = n + options.directions;
    saltus_flow *flow = NULL;
    check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message), &message);
    if (directions)
        saltus_flow_set_directions(flow, directions);
    check_ok(saltus_flow_place(flow, 0, (saltus_time){0, s->phase}, s->state, 0, &message), &message);
    for (int k = 0; k < p->strikes; k++) {
        coast(flow, p->time[k], NULL);
        r->strike[k] = (saltus_strike){.equation_gradient = r->gradient[k],
                                       .speed_gradient = r->speed_gradient[k],
                                       .shift = r->shift[k]};
        check_ok(saltus_flow_strike(flow, 0, p->kind[k], p->face[k], &r->strike[k], &message), &message);
        if (k == carried) {
            memset(r->columns, 0, sizeof r->columns);
            memcpy(r->columns, r->shift[k], (size_t)n * sizeof(double));
            saltus_flow_set_tangents(flow, 0, r->columns);
        }
    }
    coast(flow, p->end, NULL);
    saltus_flow_state(flow, 0, r->state);
    saltus_flow_tangents(flow, 0, r->columns);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

static void compare(double value, double expected, double size, const char *what, int k) {
    if (!(fabs(value - expected) <= 2e-6 * (fabs(expected) + size)))
        fail_msg("%s %d: %.12g should be %.12g", what, k, value, expected);
}

/* Move each stop to where the motion sticks to it: a contact cannot begin at a distance. */
static void meet_stops(scene *s, const program *p) {
    static result r;
    program probe = *p;
    for (int k = 0; k < p->strikes; k++) {
        if (p->kind[k] != SALTUS_STICK)
            continue;
        probe.strikes = k + 1;
        probe.end = p->time[k];
        perform(s, &probe, SALTUS_TAYLOR, NULL, -1, &r);
        saltus_stop *stop = &s->spec.stops[p->face[k]];
        stop->d += r.strike[k].equation;
        stop->sides = stop->d > 0 ? stop->sides : SALTUS_UPPER;
    }
}

/* Move a release, with all later strikes, to where the force is zero, if that happens within a period after
 * the strike before. Only there is the equation's rate the same with and without the contact. */
static bool place_release(const scene *s, program *p, int k) {
    static result r;
    program probe = *p;
    const double from = p->time[k - 1] + 0.01, moved = p->time[k];
    double low = from, high = from, at_low = 0;
    for (int j = 0; j <= 60 && high == from; j++) {
        probe.strikes = k + 1;
        probe.time[k] = probe.end = from + j / 60.0;
        perform(s, &probe, SALTUS_TAYLOR, NULL, -1, &r);
        if (j > 0 && r.strike[k].equation * at_low < 0)
            high = probe.time[k];
        else
            low = probe.time[k], at_low = r.strike[k].equation;
    }
    for (int j = 0; j < 45 && high > from; j++) {
        probe.time[k] = probe.end = 0.5 * (low + high);
        perform(s, &probe, SALTUS_TAYLOR, NULL, -1, &r);
        *(r.strike[k].equation * at_low > 0 ? &low : &high) = probe.time[k];
    }
    for (int j = k; j < p->strikes && high > from; j++)
        p->time[j] += high - moved;
    p->end += high > from ? high - moved : 0;
    return high > from;
}

/* Compare a column with differences of the final state and of the strikes' equations and speeds. */
static void compare_column(const result *above, const result *below, double h, const result *r,
                           const program *p, int n, int column, double unit) {
    for (int k = 0; k < p->strikes; k++) {
        compare(r->gradient[k][column] * unit,
                (above->strike[k].equation - below->strike[k].equation) / (2 * h) * unit, 5e-2,
                "gradient of strike", k);
        compare(r->speed_gradient[k][column] * unit,
                (above->strike[k].speed - below->strike[k].speed) / (2 * h) * unit, 5e-2,
                "gradient of the speed at strike", k);
    }
    for (int i = 0; i < n; i++)
        compare(r->columns[column * n + i] * unit, (above->state[i] - below->state[i]) / (2 * h) * unit, 5e-2,
                "column of entry", i);
}

static void check_program(const scene *s, const program *p, saltus_integrator integrator, const char *keys) {
    static result r, above, below;
    saltus_system *system = build(&s->spec);
    const int n = saltus_system_dimension(system);
    const double period = saltus_system_period(system);
    perform(s, p, integrator, NULL, -1, &r);
    for (int c = 0; c < n; c++) {
        scene moved = *s;
        const double unit = saltus_system_scale(system)[c], h = 1e-5 * unit;
        moved.state[c] = s->state[c] + h;
        perform(&moved, p, integrator, NULL, -1, &above);
        moved.state[c] = s->state[c] - h;
        perform(&moved, p, integrator, NULL, -1, &below);
        compare_column(&above, &below, h, &r, p, n, c, unit);
    }
    /* Derivatives by a strike's own time. */
    for (int k = 0; k < p->strikes; k++) {
        program late = *p, early = *p;
        const double h = 1e-5;
        late.time[k] += h;
        early.time[k] -= h;
        perform(s, &late, integrator, NULL, -1, &above);
        perform(s, &early, integrator, NULL, -1, &below);
        perform(s, p, integrator, NULL, k, &r);
        if (p->kind[k] != SALTUS_RELEASE || fabs(r.strike[k].equation) < 1e-9)
            compare(r.strike[k].equation_rate * period,
                    (above.strike[k].equation - below.strike[k].equation) / (2 * h), 5e-2, "rate of strike",
                    k);
        compare(r.strike[k].speed_rate * period, (above.strike[k].speed - below.strike[k].speed) / (2 * h),
                5e-2, "rate of the speed at strike", k);
        for (int i = 0; i < n; i++)
            compare(r.columns[i] * period, (above.state[i] - below.state[i]) / (2 * h), 5e-2,
                    "carried shift of entry", i);
    }
    char key[16];
    int length;
    for (const char *from = keys; sscanf(from, "%15s%n", key, &length) == 1; from += length) {
        saltus_direction direction;
        saltus_message message = {.text = ""};
        double value;
        check_ok(saltus_spec_direction(&s->spec, key, &direction, &value, &message), &message);
        scene moved = *s;
        const double h = 1e-5 * fabs(value);
        moved.spec = saltus_spec_shifted(&s->spec, &direction, h);
        perform(&moved, p, integrator, NULL, -1, &above);
        moved.spec = saltus_spec_shifted(&s->spec, &direction, -h);
        perform(&moved, p, integrator, NULL, -1, &below);
        perform(s, p, integrator, &direction, -1, &r);
        compare_column(&above, &below, h, &r, p, n, n, fabs(value));
    }
    saltus_system_free(system);
}

/* A strike's equation and its effect at its instant: the states before and after, by a flow that stops
 * there. */
static void strikes_follow_their_laws(const scene *s, const program *p) {
    stress_model m;
    saltus_system *system = build(&s->spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    const int n = saltus_system_dof(system);
    unsigned contacts = 0;
    double before[scene_dimension_max], after[scene_dimension_max], shift[scene_dimension_max], a[64],
        size[64];
    stress_model_read(&m, &s->spec);
    saltus_flow *flow = open_placed(system, &options, s->phase, s->state, 0);
    for (int k = 0; k < p->strikes; k++) {
        const int f = p->face[k];
        saltus_strike strike = {.shift = shift};
        coast(flow, p->time[k], NULL);
        saltus_flow_state(flow, 0, before);
        stress_field(&m, saltus_flow_time(flow, 0).phase, before, a, size);
        check_ok(saltus_flow_strike(flow, 0, p->kind[k], f, &strike, &message), &message);
        saltus_flow_state(flow, 0, after);
        check_near(strike.speed, stress_normal(&m, f, before + n), 1e-10);
        double expected = p->kind[k] == SALTUS_RELEASE
                              ? -quantity(&m, contacts, f, saltus_flow_time(flow, 0).phase, before)
                              : stress_gap(&m, f, before);
        check_near(strike.equation, expected, 1e-9 * (1 + fabs(expected)));
        const double rate = stress_normal(&m, f, after + n);
        if (p->kind[k] == SALTUS_IMPACT)
            check_near(rate, -m.face[f].r * strike.speed, 1e-10);
        else if (p->kind[k] == SALTUS_STICK) {
            contacts |= 1u << f;
            check_near(rate, 0, 1e-10);
            check_near(stress_gap(&m, f, after), 0, 1e-12);
        } else {
            contacts &= ~(1u << f);
            for (int i = 0; i < 2 * n; i++)
                check_near(after[i], before[i], 1e-14);
        }
        assert_int_equal(saltus_flow_contacts(flow, 0), contacts);
        for (int g = 0; g < m.face_count; g++)
            if (contacts >> g & 1)
                check_near(stress_normal(&m, g, after + n), 0, 1e-10);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

static void strikes_answer_as_whole_runs_do(void **unused) {
    (void)unused;
    const program one = {.strikes = 4,
                         .time = {0.55, 0.8, 1.1, 1.3},
                         .kind = {SALTUS_IMPACT, SALTUS_STICK, SALTUS_RELEASE, SALTUS_IMPACT},
                         .end = 1.6};
    const program two = {.strikes = 4,
                         .time = {0.5, 0.7, 0.95, 1.2},
                         .kind = {SALTUS_STICK, SALTUS_IMPACT, SALTUS_STICK, SALTUS_RELEASE},
                         .face = {0, 1, 1, 0},
                         .end = 1.35};
    static const struct {
        scene_name name;
        bool both;
        const char *keys;
    } rows[] = {{scene_chattering_pipe, false, "alpha beta kappa u0 sigma omega d r xi"},
                {scene_two_sided_mass, false, "m c k F omega d r"},
                {scene_maxwell_mass, false, "m kz tz omega d r"},
                {scene_chattering_mass, false, "m F0 omega d1 r"},
                {scene_caught_chain, true, "m m2 k2 c2 omega d1 d2 r1"},
                {scene_struck_chain, true, "m m2 F2 F02 omega d2 r2"}};
    int released = 0;
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        scene s = scene_of(rows[k].name);
        program p = rows[k].both ? two : one;
        meet_stops(&s, &p);
        strikes_follow_their_laws(&s, &p);
        released += place_release(&s, &p, rows[k].both ? 3 : 2);
        check_program(&s, &p, SALTUS_TAYLOR, rows[k].keys);
        if (k < 3)
            check_program(&s, &p, SALTUS_RADAU, rows[k].keys);
    }
    assert_true(released >= 4);
}

/* Impossible strikes: release of a face that is not held, contacts that exclude each other. */
static void impossible_strikes_are_refused(void **unused) {
    (void)unused;
    scene s = scene_of(scene_two_sided_mass);
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    double shift[scene_dimension_max];
    saltus_strike strike = {.shift = shift};
    saltus_flow *flow = open_placed(system, &options, s.phase, s.state, 0);
    assert_int_equal(saltus_flow_strike(flow, 0, SALTUS_RELEASE, 0, &strike, &message), SALTUS_STALLED);
    assert_true(strlen(message.text) > 10);
    assert_int_equal(saltus_flow_place(flow, 0, (saltus_time){0, 0}, s.state, 3, &message), SALTUS_STALLED);
    check_ok(saltus_flow_place(flow, 0, (saltus_time){0, 0}, s.state, 2, &message), &message);
    assert_int_equal(saltus_flow_contacts(flow, 0), 2);
    for (int wrong = 0; wrong < 3; wrong++) {
        const saltus_time time = {0, wrong == 0 ? NAN : wrong == 1 ? INFINITY : 0.5};
        assert_int_equal(saltus_flow_place(flow, 0, time, s.state, wrong < 2 ? 0 : 4, &message),
                         SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, wrong < 2 ? "phase" : "contacts"));
        assert_int_equal(saltus_flow_contacts(flow, 0), 2);
    }
    assert_int_equal(saltus_flow_strike(flow, 0, SALTUS_STICK, 0, &strike, &message), SALTUS_STALLED);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A coast goes forwards: to the present time it does nothing, to an earlier one it is refused; in both cases
 * the lane is unchanged. */
static void coasts_go_forwards(void **unused) {
    (void)unused;
    scene s = scene_of(scene_two_sided_mass);
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_extreme extremes[SALTUS_FACES_MAX];
    static const saltus_time until[] = {{2, 0.25}, {2, 0.2}, {1, 0.75}, {2, NAN}};
    double before[2], after[2];
    saltus_flow *flow = open_placed(system, &options, s.phase, s.state, 0);
    coast(flow, 2.25, NULL);
    saltus_flow_state(flow, 0, before);
    for (int k = 0; k < 4; k++) {
        for (int f = 0; f < SALTUS_FACES_MAX; f++)
            extremes[f] = (saltus_extreme){.value = -INFINITY, .inner = -INFINITY};
        assert_int_equal(saltus_flow_coast(flow, 0, until[k], extremes, &message),
                         k ? SALTUS_NO_CONVERGENCE : SALTUS_OK);
        saltus_flow_state(flow, 0, after);
        assert_memory_equal(after, before, sizeof after);
        assert_true(saltus_flow_time(flow, 0).cycle == 2 && saltus_flow_time(flow, 0).phase == 0.25);
        for (int f = 0; f < SALTUS_FACES_MAX; f++)
            assert_true(extremes[f].value == -INFINITY);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A lane can be placed anywhere, with contacts: the state is put onto the held faces; tangent vectors begin
 * as columns of the identity, parameter columns at zero. */
static void a_placed_lane_begins_anew(void **unused) {
    (void)unused;
    for (int name = 0; name < scenes; name++) {
        scene s = scene_of((scene_name)name);
        saltus_system *system = build(&s.spec);
        const int n = saltus_system_dimension(system), dof = saltus_system_dof(system);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_message message = {.text = ""};
        saltus_direction direction;
        saltus_flow *flow = NULL;
        double state[scene_dimension_max], columns[scene_columns_max * scene_dimension_max];
        options.directions = 1;
        options.columns = n + 3; /* two more than the identity has */
        check_ok(saltus_spec_direction(&s.spec, "omega", &direction, NULL, &message), &message);
        check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message), &message);
        saltus_flow_set_directions(flow, &direction);
        for (int face = -1; face < saltus_system_face_count(system); face++) {
            const unsigned contacts = face < 0 ? 0 : 1u << face;
            for (int i = 0; i < n; i++)
                state[i] = 3 * s.state[i];
            check_ok(saltus_flow_place(flow, 0, (saltus_time){4, 0.9}, state, contacts, &message), &message);
            assert_int_equal(saltus_flow_contacts(flow, 0), contacts);
            assert_true(saltus_flow_time(flow, 0).cycle == 4 && saltus_flow_time(flow, 0).phase == 0.9);
            saltus_flow_state(flow, 0, columns);
            if (face < 0)
                assert_memory_equal(columns, state, (size_t)n * sizeof *state);
            else {
                check_near(saltus_system_gap(system, face, columns), 0, 1e-14);
                check_near(towards(system, face, columns + dof), 0, 1e-14);
            }
            for (int again = 0; again < 2; again++) {
                saltus_flow_tangents(flow, 0, columns);
                for (int i = 0; i < options.columns * n; i++)
                    assert_true(columns[i] == (i / n == i % n && i / n < n ? 1 : 0));
                coast(flow, 5.2, NULL);
                check_ok(saltus_flow_place(flow, 0, (saltus_time){4, 0.9}, state, contacts, &message),
                         &message);
            }
        }
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_coast_collects_what_a_dense_sampling_finds),
        cmocka_unit_test(a_coast_only_raises_its_extremes),
        cmocka_unit_test(strikes_answer_as_whole_runs_do),
        cmocka_unit_test(impossible_strikes_are_refused),
        cmocka_unit_test(coasts_go_forwards),
        cmocka_unit_test(a_placed_lane_begins_anew),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
