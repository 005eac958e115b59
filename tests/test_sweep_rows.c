/* A sweep's rows and clouds agree with a trajectory run from the row's own state and counted again here:
 * extremes, speeds, rates, contact, turning points, impacts, section points, orbits, periods.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_check.h"

enum { dimension_max = 16, samples = 256, listed_max = 4000 };

/* A trajectory, observed by dense samples of its displacement and by its contact events. */
typedef struct recount {
    const saltus_system *system;
    double largest, smallest, speed, contact, since; /* `since`: begin of the present contact, or -1 */
    long long impacts, sticks;
    bool chatter;
    int turnings, listed, sections;
    double turning[listed_max], section[listed_max], end[dimension_max];
    saltus_sweep_impact impact[listed_max];
    double x, v, at; /* observed at the last sample; v = 0: held on the observed stop */
} recount;

static double observed(const saltus_system *system, const double *vector) {
    const double *observer = saltus_system_observer(system);
    double sum = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        sum += observer[i] * vector[i];
    return sum;
}

static void see(recount *r, double x) {
    r->largest = fmax(r->largest, x);
    r->smallest = fmin(r->smallest, x);
}

static void list_turning(recount *r, double x) {
    assert_true(r->turnings < listed_max);
    r->turning[r->turnings++] = x;
}

/* From the last sample to the next one in free flight: a sign change of the velocity is a turning point. */
static void look(recount *r, double at, double x, double v, bool flight) {
    double duration = (at - r->at) * saltus_system_period(r->system);
    if (flight && r->v * v < 0) {
        double part = r->v / (r->v - v), turn = r->x + 0.5 * part * duration * r->v;
        see(r, turn);
        list_turning(r, turn);
    }
    see(r, x);
    r->at = at;
    r->x = x;
    r->v = v;
}

/* The observed velocity before an impulse along a stop's normal. */
static double velocity_before(const recount *r, const saltus_event *event, const double *state) {
    const double *observer = saltus_system_observer(r->system),
                 *normal =
                     saltus_system_stop_normal(r->system, saltus_system_face(r->system, event->face).stop);
    double along = 0, square = 0;
    for (int i = 0; i < saltus_system_dof(r->system); i++) {
        along += observer[i] * normal[i];
        square += normal[i] * normal[i];
    }
    return observed(r->system, state + saltus_system_dof(r->system)) +
           along / square * (event->velocity_before - event->velocity_after);
}

static void contact_event(recount *r, const saltus_event *event, const double *state, bool touching) {
    double at = saltus_time_periods(event->time), x = observed(r->system, state),
           before = velocity_before(r, event, state),
           after = observed(r->system, state + saltus_system_dof(r->system));
    saltus_face face = saltus_system_face(r->system, event->face);
    bool own = face.stop == 0, strikes = event->kind != SALTUS_RELEASE && event->velocity_before != 0;
    /* A complete chatter is skipped: its turning points are not reported. */
    look(r, at, x, before, r->v != 0 && !(event->kind == SALTUS_STICK && face.r > 0));
    if (strikes) {
        assert_true(r->listed < listed_max);
        r->impact[r->listed++] =
            (saltus_sweep_impact){event->time.phase, event->velocity_before, event->face};
        r->speed = fmax(r->speed, fabs(event->velocity_before));
        r->impacts++;
        if (own || before * after < 0)
            list_turning(r, x);
    }
    r->v = own && event->kind != SALTUS_IMPACT ? 0 : after;
    r->sticks += event->kind == SALTUS_STICK;
    r->chatter |= event->kind == SALTUS_STICK && face.r > 0;
    if (touching && r->since < 0)
        r->since = at;
    else if (!touching && r->since >= 0) {
        r->contact += at - r->since;
        r->since = -1;
    }
}

static void recount_from(recount *r, const saltus_system *system, const saltus_flow_options *options,
                         const double *start, long long periods) {
    const int n = saltus_system_dimension(system), dof = saltus_system_dof(system);
    saltus_flow *flow = open_flow(system, options, 0, start);
    double state[dimension_max];
    *r = (recount){.system = system, .largest = -INFINITY, .smallest = INFINITY};
    bool held = saltus_flow_contacts(flow, 0) != 0;
    r->since = held ? 0 : -1;
    r->x = observed(system, start);
    r->v = held ? 0 : observed(system, start + dof);
    see(r, r->x);
    for (long long k = 0; k < periods * samples; k++) {
        double until = (double)(k + 1) / samples;
        if (k % samples == 0) {
            saltus_flow_state(flow, 0, state);
            assert_true((r->sections + 1) * n <= listed_max);
            memcpy(r->section + r->sections++ * n, state, (size_t)n * sizeof *state);
        }
        for (saltus_event event = advance(flow, until, SALTUS_WATCH_CONTACT); event.kind != SALTUS_REACHED;
             event = advance(flow, until, SALTUS_WATCH_CONTACT)) {
            saltus_flow_state(flow, 0, state);
            contact_event(r, &event, state, saltus_flow_contacts(flow, 0) != 0);
        }
        saltus_flow_state(flow, 0, state);
        unsigned contacts = saltus_flow_contacts(flow, 0);
        bool own = false;
        for (int f = 0; f < saltus_system_face_count(system); f++)
            own |= (contacts >> f & 1) && saltus_system_face(system, f).stop == 0;
        look(r, until, observed(system, state), own ? 0 : observed(system, state + dof), r->v != 0 && !own);
    }
    if (r->since >= 0)
        r->contact += (double)periods - r->since;
    memcpy(r->end, state, (size_t)n * sizeof *state);
    saltus_flow_free(flow);
}

static double scaled(const saltus_system *system, const double *a, const double *b) {
    const double *scale = saltus_system_scale(system);
    double largest = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        largest = fmax(largest, fabs(a[i] - b[i]) / scale[i]);
    return largest;
}

static void check_measures(const single *s, const recount *r, const saltus_system *system) {
    const saltus_sweep_row *row = s->result.rows;
    const double unit = saltus_system_scale(system)[0], length = (double)row->recorded,
                 fast = saltus_system_scale(system)[saltus_system_dof(system)];
    check_near(row->largest, r->largest, 1e-4 * unit);
    check_near(row->smallest, r->smallest, 1e-4 * unit);
    check_near(row->largest_speed, r->speed, 1e-6 * fast);
    check_near(row->impact_rate, (double)r->impacts / length, 1e-12);
    check_near(row->contact_fraction, r->contact / length, 1e-7);
}

/* The last arcs of a chatter are lower than rounding: only higher ones are compared. */
static int next_turning(const recount *r, const double *turning, int k, int count, double unit) {
    double stop = saltus_system_face_count(r->system)
                      ? saltus_system_face(r->system, 0).d * saltus_system_face(r->system, 0).side
                      : 0;
    while (r->chatter && k < count && fabs(turning[k] - stop) < 1e-9 * unit)
        k++;
    return k;
}

static void check_turning(const recount *r, const double *turning, int count, double unit) {
    int j = next_turning(r, r->turning, 0, r->turnings, unit), k = next_turning(r, turning, 0, count, unit);
    while (j < r->turnings && k < count) {
        check_near(turning[k], r->turning[j], 1e-4 * unit);
        j = next_turning(r, r->turning, j + 1, r->turnings, unit);
        k = next_turning(r, turning, k + 1, count, unit);
    }
    assert_int_equal(count - k, r->turnings - j);
}

static void check_clouds(const single *s, const recount *r, const saltus_system *system) {
    const saltus_sweep_result *result = &s->result;
    const double unit = saltus_system_scale(system)[0],
                 fast = saltus_system_scale(system)[saltus_system_dof(system)];
    int n = saltus_system_dimension(system);
    assert_int_equal(result->impact_counts[0], r->listed);
    for (int k = 0; k < r->listed; k++) {
        check_near(result->impacts[k].phase, r->impact[k].phase, 1e-6);
        check_near(result->impacts[k].speed, r->impact[k].speed, 1e-6 * fast);
        assert_int_equal(result->impacts[k].face, r->impact[k].face);
    }
    /* At rest the sign of the velocity is rounding. */
    if (result->rows->verdict != SALTUS_EQUILIBRIUM)
        check_turning(r, result->turning, (int)result->turning_counts[0], unit);
    assert_int_equal(result->strobe_counts[0], r->sections);
    for (int k = 0; k < r->sections; k++)
        check_near(scaled(system, result->strobes + k * n, r->section + k * n), 0, 1e-6);
}

/* Recount what was recorded, from its first section point on. */
static void check_recorded(const single *s) {
    static recount r;
    const saltus_sweep_row *row = s->result.rows;
    saltus_system *system = system_at(s->sweep, 0);
    recount_from(&r, system, &saltus_sweep_choices(s->sweep)->flow, s->result.strobes, row->recorded);
    check_clouds(s, &r, system);
    check_measures(s, &r, system);
    if (saltus_sweep_choices(s->sweep)->adaptive)
        check_near(scaled(system, s->result.states, r.end), 0, 1e-6);
    if (row->verdict == SALTUS_PERIODIC && row->recorded == row->periods) {
        assert_int_equal(row->impacts, r.chatter ? -1 : r.impacts);
        assert_int_equal(row->sticking, r.sticks);
        check_near(scaled(system, r.end, s->result.strobes), 0, 1e-6);
    }
    saltus_system_free(system);
}

typedef struct motion_case {
    const char *scene, *settings, *key;
    double value;
    const char *label;
    bool far; /* a first stop out of reach, with the observed coordinate */
} motion_case;

/* One stop, both, none, another stop than the observed one; chatter within a period and across the section;
 * restitution zero; contact from begin to end; rest; chaos. */
static const motion_case motions[] = {
    {"impact-oscillator", "", "omega", 1.3, "1/1", false},
    {"impact-oscillator", "sides=lower", "omega", 1.3, "1/1", false},
    {"impact-oscillator", "sides=both d=0.6 r=0.7", "omega", 0.7, NULL, false},
    {"impact-oscillator", "free", "omega", 0.7, "0/1", false},
    {"impact-oscillator", "r=0 d=0.2", "omega", 0.9, NULL, false},
    {"impact-oscillator", "c=0.02 d=0.016", "omega", 3.04396, NULL, false},
    {"two-mass", "", "omega", 1.68, "1/1", false},
    {"two-mass", "", "omega", 1.68, "1/1", true},
    {"two-mass", "weight=0,1 sides=both r=0.6", "omega", 0.65, NULL, true},
    {"two-mass", "r=0", "omega", 0.9, NULL, true},
    {"two-mass", "weight=0,1 sides=both r=0.6", "omega", 0.65, NULL, false},
    {"vibrating-table", "r=0.3", "F", 1.4, "chatter/1", false},
    {"vibrating-table", "r=0.3", "F", -1.4, "chatter/1", false},
    {"vibrating-table", "r=0", "F", 1.3, NULL, false},
    {"vibrating-table", "r=0.5", "F", 0.7, "held", false},
    {"impact-pair", "", "d", 1.5, NULL, false},
    {"pipe", "N=2 d=0.03", "omega", 20, NULL, false},
    {"pipe", "N=1 sigma=0 omega=20", "d", 0.05, "equilibrium", false},
    {"chatter", "N=2", "d", 0.025, NULL, false},
};

static saltus_scene motion_scene(const motion_case *c) {
    saltus_scene scene = scene_of(c->scene, c->settings);
    if (c->far) {
        scene.spec.stops[1] = scene.spec.stops[0];
        scene.spec.stops[0] = saltus_stop_defaults();
        scene.spec.stops[0].d = 10;
        scene.spec.stop_count = 2;
    }
    return scene;
}

static saltus_sweep_options everything(void) {
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC;
    options.transient = 400;
    options.record = 5;
    options.threads = 1;
    options.flow.rtol = 1e-12; /* a chaotic motion multiplies errors by 1e5 within the record */
    return options;
}

static void rows_equal_a_recount(void **unused) {
    (void)unused;
    for (size_t k = 0; k < sizeof motions / sizeof motions[0]; k++) {
        saltus_scene scene = motion_scene(&motions[k]);
        saltus_sweep_options options = everything();
        single s = run_single(&scene, motions[k].key, motions[k].value, &options);
        print_message("%s %s %s: %lld settled %lld impacts\n", motions[k].scene, motions[k].settings, s.label,
                      s.result.rows->settled, s.result.rows->settled_impacts);
        if (motions[k].label)
            assert_string_equal(s.label, motions[k].label);
        const saltus_sweep_row *row = s.result.rows;
        if (row->periods || row->verdict == SALTUS_IRREGULAR)
            assert_int_equal(row->recorded, row->periods ? row->periods : 5);
        check_recorded(&s);
        close_single(&s);
    }
}

/* The same over a fixed time; if the motion is certain, both ways agree. */
static void fixed_rows_equal_a_recount_too(void **unused) {
    (void)unused;
    for (size_t k = 0; k < sizeof motions / sizeof motions[0]; k++) {
        saltus_scene scene = motion_scene(&motions[k]);
        saltus_sweep_options options = everything(), waiting = everything();
        options.adaptive = false;
        options.transient = 300;
        options.record = 12;
        single fixed = run_single(&scene, motions[k].key, motions[k].value, &options),
               adaptive = run_single(&scene, motions[k].key, motions[k].value, &waiting);
        const saltus_sweep_row *f = fixed.result.rows, *a = adaptive.result.rows;
        assert_int_equal(f->recorded, 12);
        assert_true(f->settled >= 312);
        check_recorded(&fixed);
        if (saltus_verdict_settled(f->verdict) && saltus_verdict_settled(a->verdict) &&
            strcmp(fixed.label, adaptive.label) == 0) {
            bool whole = a->periods == 0 || 12 % a->periods == 0;
            assert_int_equal(f->impacts, a->impacts);
            assert_int_equal(f->sticking, a->sticking);
            if (whole) {
                check_near(f->largest, a->largest, 1e-6);
                check_near(f->smallest, a->smallest, 1e-6);
                check_near(f->largest_speed, a->largest_speed, 1e-5);
                check_near(f->contact_fraction, a->contact_fraction, 1e-6);
                check_near(f->impact_rate, a->impact_rate, 1e-12);
            }
        }
        if (motions[k].label)
            assert_string_equal(fixed.label, motions[k].label);
        close_single(&fixed);
        close_single(&adaptive);
    }
}

/* Turning points that are not kept need not be computed, but for those that extend the range. */
static void rows_do_not_depend_on_what_is_kept(void **unused) {
    (void)unused;
    for (size_t k = 0; k < 2 * sizeof motions / sizeof motions[0]; k++) {
        const motion_case *c = &motions[k / 2];
        saltus_scene scene = motion_scene(c);
        saltus_sweep_options all = everything();
        all.adaptive = k % 2;
        all.transient = all.adaptive ? 400 : 60;
        all.record = 40;
        saltus_sweep_options none = all;
        none.keep = 0;
        single kept = run_single(&scene, c->key, c->value, &all),
               bare = run_single(&scene, c->key, c->value, &none);
        assert_memory_equal(kept.result.rows, bare.result.rows, sizeof *kept.result.rows);
        close_single(&kept);
        close_single(&bare);
    }
}

/* A motion without a certain period is recorded after its transient: the time from the scene's initial state
 * to the first section point recorded, with all impacts on the way counted. */
static void the_way_to_the_verdict_is_counted(void **unused) {
    (void)unused;
    static const motion_case ways[] = {
        {"impact-oscillator", "c=0.02 d=0.016 q1=-0.3 v1=0.2", "omega", 3.04396, NULL, false},
        {"impact-pair", "", "d", 1.5, NULL, false},
        {"vibrating-table", "r=0.3", "F", 1.4, NULL, false},
        {"impact-oscillator", "r=0 d=0.2", "omega", 0.9, NULL, false},
        {"impact-oscillator", "sides=both d=0.6", "omega", 0.7, NULL, false}};
    static recount r;
    for (size_t k = 0; k < sizeof ways / sizeof ways[0]; k++)
        for (long long transient = 1; transient <= 5; transient += 2)
            for (int adaptive = 0; adaptive < 2; adaptive++) {
                saltus_scene scene = scene_of(ways[k].scene, ways[k].settings);
                saltus_sweep_options options = everything();
                saltus_message message = {.text = ""};
                double start[dimension_max];
                options.adaptive = adaptive;
                options.transient = transient;
                options.record = 3;
                single s = run_single(&scene, ways[k].key, ways[k].value, &options);
                saltus_system *system = system_at(s.sweep, 0);
                if (scene.initial_count)
                    memcpy(start, scene.initial, sizeof start);
                else
                    check_ok(saltus_system_default_state(system, start, &message), &message);
                recount_from(&r, system, &options.flow, start, transient);
                check_near(scaled(system, s.result.strobes, r.end), 0, 1e-4);
                if (adaptive) {
                    assert_int_equal(s.result.rows->verdict, SALTUS_IRREGULAR);
                    assert_int_equal(s.result.rows->settled, transient);
                    assert_int_equal(s.result.rows->settled_impacts, r.impacts);
                }
                saltus_system_free(system);
                close_single(&s);
            }
}

/* A trajectory that starts on its orbit, and is slightly disturbed to prove stability, has the orbit's number
 * of impacts per period until the verdict. Held from the start, it has none: the disturbance does not lift it
 * off its stop, for any length of the normal. */
static void a_start_on_the_orbit_counts_the_orbit(void **unused) {
    (void)unused;
    static const motion_case orbits[] = {
        {"impact-oscillator", "", "omega", 1.3, NULL, false},
        {"impact-oscillator", "sides=both d=0.6 r=0.7", "omega", 0.7, NULL, false},
        {"two-mass", "", "omega", 1.68, NULL, false},
        {"fig3", "", "omega", 14, NULL, false},
        {"vibrating-table", "r=0.5", "F", 0.7, "held", false},
        {"pipe", "N=1 omega=10 xi=0.3", "d", 0.005, "held", false},
        {"pipe", "N=3 xi=0.4 sigma=0.01 r=0.5", "d", 0.005, "held", false},
        {"pipe", "N=2 xi=0.6 sigma=0.002 r=0.5", "d", 0.005, "held", false},
        {"pipe", "N=3 sigma=0 omega=10", "d", 0.01, "held", false},
        {"two-mass", "F=0.02 d=-0.2", "omega", 1.1, "held", false}};
    for (size_t k = 0; k < sizeof orbits / sizeof orbits[0]; k++) {
        saltus_scene scene = scene_of(orbits[k].scene, orbits[k].settings);
        saltus_sweep_options options = everything();
        options.transient = 1500;
        single first = run_single(&scene, orbits[k].key, orbits[k].value, &options);
        if (!saltus_verdict_settled(first.result.rows->verdict))
            fail_msg("%s %s: %s", orbits[k].scene, orbits[k].settings, first.label);
        scene.initial_count = saltus_sweep_dimension(first.sweep);
        memcpy(scene.initial, first.result.states, (size_t)scene.initial_count * sizeof *scene.initial);
        single again = run_single(&scene, orbits[k].key, orbits[k].value, &options);
        const saltus_sweep_row *row = again.result.rows;
        assert_string_equal(first.label, again.label);
        if (orbits[k].label)
            assert_string_equal(again.label, orbits[k].label);
        double expected = row->periods ? (double)(row->impacts * row->settled) / row->periods : 0;
        check_near((double)row->settled_impacts, expected, row->periods ? 1.001 * row->impacts : 0);
        assert_true(row->settled <= first.result.rows->settled);
        close_single(&first);
        close_single(&again);
    }
}

/* A row computed again, in any pass and of any seed, is the same to the last bit, with the state it ended in.
 */
static void a_row_can_be_computed_again(void **unused) {
    (void)unused;
    static const struct {
        const char *scene, *axis;
        unsigned passes, keep;
    } cases[] = {{"impact-oscillator", "omega=0.75:0.85:5",
                  1u << SALTUS_PASS_RESET | 1u << SALTUS_PASS_UP | 1u << SALTUS_PASS_DOWN,
                  SALTUS_KEEP_LYAPUNOV | SALTUS_KEEP_TURNING},
                 {"duffing", "x=0:0.4:3", 1u << SALTUS_PASS_RESET, 0}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        saltus_message message = {.text = ""};
        saltus_sweep_options options = saltus_sweep_defaults();
        options.passes = cases[c].passes;
        options.keep = cases[c].keep;
        options.seeds = 3;
        options.transient = 200;
        options.record = 20;
        saltus_scene scene = scene_of(cases[c].scene, "");
        saltus_sweep *sweep = sweep_of(&scene, cases[c].axis, NULL, &options);
        outcome all = open_outcome(sweep);
        run_part(&all, 0, 1);
        const int n = saltus_sweep_dimension(sweep);
        for (long long k = 0; k < saltus_sweep_rows(sweep); k++) {
            double state[SALTUS_SCENE_STATE_MAX];
            saltus_sweep_row row;
            const saltus_sweep_result known = result_at(&all, k / options.seeds);
            check_ok(saltus_sweep_row_again(sweep, k, &row, state, &message), &message);
            const long long seed = k % options.seeds;
            assert_memory_equal(&row, &known.rows[seed], sizeof row);
            assert_memory_equal(state, known.states + seed * n, (size_t)n * sizeof *state);
        }
        close_outcome(&all);
        saltus_sweep_free(sweep);
        saltus_scene_clear(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_equal_a_recount),
        cmocka_unit_test(fixed_rows_equal_a_recount_too),
        cmocka_unit_test(rows_do_not_depend_on_what_is_kept),
        cmocka_unit_test(the_way_to_the_verdict_is_counted),
        cmocka_unit_test(a_start_on_the_orbit_counts_the_orbit),
        cmocka_unit_test(a_row_can_be_computed_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
