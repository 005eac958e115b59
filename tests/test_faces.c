/* Several faces, and which events are reported: uncoupled masses keep their own events, every impulse pushes,
 * a watcher receives exactly what it watches.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes.h"
#include "stress_field.h"

#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

enum { events_max = 4000, watch_all = SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING };

typedef struct account {
    int count;
    saltus_event event[events_max];
    double when[events_max]; /* the flow's own time; before that of a stick if chatter is cut off */
    saltus_flow_info info;
    double state[scene_dimension_max];
} account;

static void record(const saltus_spec *spec, const scene *start, double periods, unsigned watch, account *a) {
    saltus_system *system = build(spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = open_flow(system, &options, start->phase, start->state);
    a->count = 0;
    for (;;) {
        assert_true(a->count < events_max);
        saltus_event *event = &a->event[a->count];
        *event = advance(flow, start->phase + periods, watch);
        a->when[a->count] = saltus_time_periods(saltus_flow_time(flow, 0));
        if (event->kind == SALTUS_REACHED)
            break;
        a->count++;
    }
    a->info = saltus_flow_information(flow, 0);
    saltus_flow_state(flow, 0, a->state);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

static void same_event(const saltus_event *a, const saltus_event *b, double tolerance) {
    assert_int_equal(a->kind, b->kind);
    check_near(saltus_time_periods(a->time), saltus_time_periods(b->time), tolerance);
    check_near(a->velocity_before, b->velocity_before, tolerance);
    check_near(a->velocity_after, b->velocity_after, tolerance);
    check_near(a->displacement, b->displacement, tolerance);
}

/* One mass with its own stop, on the given side. */
typedef struct lone_mass {
    double m, c, k, force, load, weight, d, r;
    saltus_sides sides;
    double x, v;
} lone_mass;

static scene lone_scene(const lone_mass *mass, double omega) {
    scene s = {.spec = oscillator_spec(mass->c, mass->k, mass->force, omega), .state = {mass->x, mass->v}};
    set_parameter(&s.spec, "m", mass->m);
    set_parameter(&s.spec, "F0", mass->load);
    scene_stop(&s, mass->d, mass->r, mass->sides)->weight[0] = mass->weight;
    return s;
}

/* Both masses in one scene, without spring or damper between them. */
static scene pair_scene(const lone_mass *mass, double omega) {
    scene s = lone_scene(&mass[0], omega);
    set_parameter(&s.spec, "N", 2);
    set_parameter(&s.spec, "k2", 0);
    set_parameter(&s.spec, "m2", mass[1].m);
    set_parameter(&s.spec, "F2", mass[1].force);
    set_parameter(&s.spec, "F02", mass[1].load);
    saltus_stop *stop = scene_stop(&s, mass[1].d, mass[1].r, mass[1].sides);
    stop->weight[0] = 0;
    stop->weight[1] = mass[1].weight;
    s.state[1] = mass[1].x;
    s.state[2] = mass[0].v;
    s.state[3] = mass[1].v;
    return s;
}

/* Each face's events, one by one. Where chatter is cut off depends on the tolerance, and so on the other
 * mass: of its last impacts only the end is compared. */
static void check_own(const account *both, int first, const account *lone) {
    int k = 0;
    double last = -1;
    for (int j = 0; j < lone->count; j++) {
        const saltus_event *own = &lone->event[j];
        if (own->kind == SALTUS_IMPACT && fabs(own->velocity_before) < 1e-3)
            continue;
        while (k < both->count &&
               (both->event[k].face - first != own->face || both->event[k].kind != own->kind ||
                (own->kind == SALTUS_IMPACT && fabs(both->event[k].velocity_before) < 1e-3)))
            k++;
        if (k == both->count)
            fail_msg("event %d at %.12g periods is missing", j, saltus_time_periods(own->time));
        saltus_event told = both->event[k++];
        if (own->kind == SALTUS_STICK)
            told.velocity_before = own->velocity_before;
        same_event(&told, own, own->kind == SALTUS_IMPACT ? 1e-9 : 1e-7);
        assert_true(both->when[k - 1] >= last);
        last = both->when[k - 1];
    }
}

static int told_of(const account *a, saltus_event_kind kind, double speed) {
    int count = 0;
    for (int k = 0; k < a->count; k++)
        count += a->event[k].kind == kind && fabs(a->event[k].velocity_before) >= speed;
    return count;
}

static void masses_apart_keep_their_own_events(void **unused) {
    (void)unused;
    static const lone_mass rows[][2] = {/* Both chatter, stick and are released in every period. */
                                        {{1.4, 2.5, 1.3, 1.8, 0.4, 2, 0.2, 0.3, SALTUS_UPPER, 0.02, 0.3},
                                         {0.7, 0, 0, 0.4, -0.35, 0.8, 0.1, 0.1, SALTUS_LOWER, -0.03, 0.1}},
                                        {{1.4, 2.5, 1.3, 1.8, 0.4, 2, 0.2, 0, SALTUS_UPPER, 0.02, 0.3},
                                         {0.7, 0, 0, 0.4, 0.35, -1.5, 0.3, 0, SALTUS_LOWER, -0.03, 0.1}},
                                        {{1, 0.1, 1, 0.8, 0, 1, 0.3, 0.8, SALTUS_BOTH, 0.02, 0.3},
                                         {0.7, 0, 0, 0.9, -0.5, 0.8, 0.2, 0.9, SALTUS_LOWER, 0.3, 0.1}}};
    static account both, lone[2];
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        const double omega = 0.6, periods = 3;
        scene pair = pair_scene(rows[k], omega);
        record(&pair.spec, &pair, periods, SALTUS_WATCH_CONTACT, &both);
        for (int i = 0; i < 2; i++) {
            scene s = lone_scene(&rows[k][i], omega);
            record(&s.spec, &s, periods, SALTUS_WATCH_CONTACT, &lone[i]);
            for (int j = 0; j < 2; j++)
                check_near(both.state[2 * j + i], lone[i].state[j], 1e-9);
        }
        check_own(&both, 0, &lone[0]);
        check_own(&both, rows[k][0].sides == SALTUS_BOTH ? 2 : 1, &lone[1]);
        assert_int_equal(told_of(&both, SALTUS_IMPACT, 1e-3),
                         told_of(&lone[0], SALTUS_IMPACT, 1e-3) + told_of(&lone[1], SALTUS_IMPACT, 1e-3));
        assert_int_equal(told_of(&both, SALTUS_STICK, 0), both.info.sticks);
        assert_int_equal(told_of(&both, SALTUS_RELEASE, 0), both.info.releases);
        assert_true(both.info.sticks == lone[0].info.sticks + lone[1].info.sticks);
        assert_true(both.info.releases == lone[0].info.releases + lone[1].info.releases);
        for (int i = 0; i < 2 && k < 2; i++)
            assert_true(lone[i].info.sticks >= 2 && lone[i].info.releases >= 2);
    }
}

/* Two equal masses meet their stops in the same instant: each face has its impact, at that time. */
static void impacts_in_one_instant_are_all_told(void **unused) {
    (void)unused;
    static const lone_mass row[2] = {{1, 0, 0, 0.8, 0.1, 1, 0.3, 0.7, SALTUS_BOTH, 0.02, 0.3},
                                     {1, 0, 0, 0.8, 0.1, 1, 0.3, 0.7, SALTUS_BOTH, 0.02, 0.3}};
    static account both, lone;
    const double omega = 1.1;
    scene pair = pair_scene(row, omega), s = lone_scene(&row[0], omega);
    record(&pair.spec, &pair, 6, SALTUS_WATCH_IMPACT, &both);
    record(&s.spec, &s, 6, SALTUS_WATCH_IMPACT, &lone);
    assert_true(lone.count > 6);
    assert_int_equal(both.count, 2 * lone.count);
    assert_int_equal(both.info.impacts, 2 * lone.info.impacts);
    check_near(both.info.log_volume, 2 * lone.info.log_volume, 1e-12);
    for (int k = 0; k < lone.count; k++) {
        const saltus_event *first = &both.event[2 * k], *second = first + 1;
        assert_int_equal(first->face / 2 + second->face / 2, 1);
        assert_true(first->face % 2 == lone.event[k].face && second->face % 2 == lone.event[k].face);
        assert_true(first->time.cycle == second->time.cycle && first->time.phase == second->time.phase);
        same_event(first, &lone.event[k], 1e-10);
        same_event(second, &lone.event[k], 1e-10);
    }
    /* Without watching impacts none is reported. */
    record(&pair.spec, &pair, 6, SALTUS_WATCH_TURNING | SALTUS_WATCH_RELEASE, &both);
    for (int k = 0; k < both.count; k++)
        assert_int_equal(both.event[k].kind, SALTUS_TURNING);
    check_near(both.state[0], both.state[1], 1e-12);
}

/* In the same instant one mass rebounds and the other sticks: both are reported. */
static void a_rebound_and_a_catch_in_one_instant_are_told(void **unused) {
    (void)unused;
    static account both, lone[2];
    for (int caught = 0; caught < 2; caught++) {
        lone_mass row[2] = {{1, 0, 0, 0.1, 0.5, 1, 0.3, 0.7, SALTUS_UPPER, 0.02, 0.3},
                            {1, 0, 0, 0.1, 0.5, 1, 0.3, 0.7, SALTUS_UPPER, 0.02, 0.3}};
        row[caught].r = 0;
        scene pair = pair_scene(row, 1.1);
        record(&pair.spec, &pair, 1, SALTUS_WATCH_CONTACT, &both);
        for (int i = 0; i < 2; i++) {
            scene s = lone_scene(&row[i], 1.1);
            record(&s.spec, &s, 1, SALTUS_WATCH_CONTACT, &lone[i]);
            check_own(&both, i, &lone[i]);
        }
        assert_true(both.when[0] == both.when[1]);
        /* An impact that ends in sticking is reported once, as the stick or separately. */
        for (int i = 0; i < 3; i++) {
            const account *a = i < 2 ? &lone[i] : &both;
            assert_int_equal(told_of(a, SALTUS_IMPACT, 1e-300) + told_of(a, SALTUS_STICK, 1e-300),
                             a->info.impacts);
        }
        assert_int_equal(told_of(&both, SALTUS_STICK, 0), both.info.sticks);
    }
}

/* The second of two simultaneous impacts waits for the next run only: if that does not watch impacts it is
 * not reported later, and neither is one that nobody watched. */
static void a_waiting_impact_is_not_told_late(void **unused) {
    (void)unused;
    static const lone_mass row[2] = {{1, 0, 0, 0.8, 0.1, 1, 0.3, 0.7, SALTUS_BOTH, 0.02, 0.3},
                                     {1, 0, 0, 0.8, 0.1, 1, 0.3, 0.7, SALTUS_BOTH, 0.02, 0.3}};
    scene s = pair_scene(row, 1.1);
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    for (int way = 0; way < 2; way++) {
        saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
        double first = saltus_time_periods(advance(flow, 6, SALTUS_WATCH_IMPACT).time);
        if (way == 1) {
            saltus_flow_free(flow);
            flow = open_flow(system, &options, s.phase, s.state);
        }
        assert_int_equal(advance(flow, first + 1e-3, SALTUS_WATCH_RELEASE).kind, SALTUS_REACHED);
        saltus_event event = advance(flow, 6, SALTUS_WATCH_IMPACT);
        assert_int_equal(event.kind, SALTUS_IMPACT);
        assert_true(saltus_time_periods(event.time) > first + 1e-3);
        saltus_flow_free(flow);
    }
    saltus_system_free(system);
}

/* Whether a watcher receives an event: watching impacts includes the end of their sequence, where contact
 * begins. */
static bool told(unsigned watch, saltus_event_kind kind) {
    return watch >> kind & 1 || (kind == SALTUS_STICK && watch & SALTUS_WATCH_IMPACT);
}

static void a_watcher_is_told_of_what_it_watches(void **unused) {
    (void)unused;
    static account all, some;
    int sticks = 0, releases = 0;
    for (int name = 0; name < scenes; name++) {
        scene s = scene_of((scene_name)name);
        record(&s.spec, &s, 4, watch_all, &all);
        for (unsigned bits = 0; bits < 16; bits++) {
            const unsigned watch = bits << SALTUS_IMPACT;
            int seen = 0;
            record(&s.spec, &s, 4, watch, &some);
            for (int k = 0; k < all.count; k++) {
                if (!told(watch, all.event[k].kind))
                    continue;
                assert_true(seen < some.count);
                same_event(&some.event[seen], &all.event[k], 1e-7);
                assert_int_equal(some.event[seen++].face, all.event[k].face);
            }
            assert_int_equal(seen, some.count);
            assert_true(some.info.impacts == all.info.impacts && some.info.sticks == all.info.sticks &&
                        some.info.releases == all.info.releases);
        }
        sticks += (int)all.info.sticks;
        releases += (int)all.info.releases;
    }
    assert_true(sticks > 10 && releases > 10);
}

/* The flow's counts agree with its reported events. An impact without speed is reported but has no
 * impulse. */
static void counts_are_those_of_the_events(void **unused) {
    (void)unused;
    static account all;
    for (int name = 0; name < scenes; name++) {
        scene s = scene_of((scene_name)name);
        long long impacts = 0, sticks = 0, releases = 0;
        double volume = 0;
        record(&s.spec, &s, 6, SALTUS_WATCH_CONTACT, &all);
        saltus_system *system = build(&s.spec);
        for (int k = 0; k < all.count; k++) {
            const saltus_event *event = &all.event[k];
            saltus_face face = saltus_system_face(system, event->face);
            bool hit = event->kind != SALTUS_RELEASE && event->velocity_before != 0;
            impacts += hit;
            sticks += event->kind == SALTUS_STICK;
            releases += event->kind == SALTUS_RELEASE;
            volume += hit ? 2 * log(face.r) : 0;
            check_near(event->displacement, face.side * face.d, 1e-15);
            if (event->kind != SALTUS_RELEASE)
                assert_true(event->velocity_before * face.side >= 0);
            check_near(event->velocity_after,
                       event->kind == SALTUS_IMPACT ? -face.r * event->velocity_before : 0, 1e-14);
        }
        assert_true(all.info.impacts == impacts && all.info.sticks == sticks &&
                    all.info.releases == releases);
        if (isfinite(volume))
            check_near(all.info.log_volume, volume, 1e-9 * (1 + fabs(volume)));
        else
            assert_true(all.info.log_volume == volume);
        saltus_system_free(system);
    }
}

/* A start in a corner of two or three stops, with any velocity: the change of momentum is a sum of pushes, no
 * face is left closing, displacements are unchanged. */
static void check_corner(const stress_model *m, const saltus_system *system,
                         const saltus_flow_options *options, const double *state) {
    const int n = m->dof;
    double after[64], change[64], impulse[SALTUS_FACES_MAX], speed = 0;
    saltus_flow *flow = open_flow(system, options, 0.1, state);
    saltus_flow_state(flow, 0, after);
    assert_memory_equal(after, state, (size_t)n * sizeof *state);
    for (int i = 0; i < n; i++) {
        change[i] = after[n + i] - state[n + i];
        speed += fabs(state[n + i]);
    }
    int hits = 0;
    assert_true(stress_reactions(m, (1u << m->face_count) - 1, change, impulse));
    for (int f = 0; f < m->face_count; f++) {
        const double before = stress_normal(m, f, state + n), rate = stress_normal(m, f, after + n);
        assert_true(impulse[f] <= 1e-9 * speed); /* reactions cancel the change */
        assert_true(rate <= 1e-9 * speed);
        hits += impulse[f] < -1e-9 * speed;
        /* With one impulse, Newton's law holds at its face. */
        bool alone = impulse[f] < -1e-9 * speed;
        for (int g = 0; g < m->face_count; g++)
            alone &= g == f || impulse[g] > -1e-9 * speed;
        if (alone && before > 0)
            check_near(rate, -m->face[f].r * before, 1e-9 * speed);
    }
    stress_react(m, impulse, change);
    for (int i = 0; i < n; i++)
        check_near(change[i], 0, 1e-9 * speed);
    saltus_flow_info info = saltus_flow_information(flow, 0);
    assert_true((info.impacts > 0) == (hits > 0));
    saltus_flow_free(flow);
}

static void every_impulse_pushes(void **unused) {
    (void)unused;
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    for (int trial = 0; trial < 300; trial++) {
        const bool pipe = trial % 3 == 0;
        scene s = pipe ? scene_pipe(3, 20) : scene_chain(0.1, 1, 0.5, 1);
        stress_model m;
        double state[scene_dimension_max] = {0}, angle = 2 * M_PI * gsl_rng_uniform(rng);
        for (int k = 0; k < (pipe && trial % 2 ? 3 : 2); k++) {
            angle += 0.4 + 2.3 * gsl_rng_uniform(rng); /* not parallel */
            saltus_stop *stop = scene_stop(&s, 0, gsl_rng_uniform(rng), k % 2 ? SALTUS_LOWER : SALTUS_UPPER);
            stop->xi = 0.2 + 0.27 * k + 0.05 * gsl_rng_uniform(rng);
            stop->weight[0] = cos(angle);
            stop->weight[1] = sin(angle);
        }
        saltus_system *system = build(&s.spec);
        saltus_flow_options options = saltus_flow_defaults();
        stress_model_read(&m, &s.spec);
        for (int i = 0; i < m.dof; i++)
            state[m.dof + i] = gsl_ran_gaussian(rng, 1);
        check_corner(&m, system, &options, state);
        saltus_system_free(system);
    }
    gsl_rng_free(rng);
}

/* While a face holds, the state stays on it and the force pushes; it is the one that the equations of motion
 * require, per modal mass, for any length of the normal. */
static void a_held_state_stays_on_its_stop(void **unused) {
    (void)unused;
    static const double weights[] = {1, 2, -0.3, 7};
    for (int k = 0; k < 10; k++)
        for (int integrator = SALTUS_TAYLOR; integrator <= SALTUS_MIXED; integrator++) {
            scene s = k < 4   ? scene_mass(0.1, 1, 0.2, 0.9)
                      : k < 7 ? scene_chain(0.1, 1, 0.2, 0.9)
                              : scene_pipe(1 + k % 3, 20);
            stress_model m;
            saltus_flow_options options = saltus_flow_defaults();
            double x[scene_dimension_max], a[64], size[64], reaction[SALTUS_FACES_MAX],
                forces[SALTUS_FACES_MAX];
            const double weight = weights[k % 4];
            set_parameter(&s.spec, k < 7 ? "F0" : "sigma", k < 7 ? (weight > 0 ? 2 : -2) : 0.02);
            scene_stop(&s, k < 7 ? 0.1 : 0.004, 0.5, SALTUS_UPPER)->weight[0] = weight;
            s.spec.stops[0].weight[1] = k < 4 ? 0 : 0.4;
            s.spec.stops[0].xi = 0.31;
            stress_model_read(&m, &s.spec);
            const int n = m.dof;
            memset(s.state, 0, sizeof s.state);
            s.state[0] = m.face[0].d / m.face[0].normal[0];
            saltus_system *system = build(&s.spec);
            options.integrator = (saltus_integrator)integrator;
            saltus_flow *flow = open_flow(system, &options, 0, s.state);
            assert_int_equal(saltus_flow_contacts(flow, 0), 1);
            for (int p = 1; p <= 40 && saltus_flow_contacts(flow, 0); p++) {
                advance(flow, 0.05 * p, SALTUS_WATCH_RELEASE);
                saltus_flow_state(flow, 0, x);
                saltus_flow_forces(flow, 0, forces);
                if (!saltus_flow_contacts(flow, 0))
                    break;
                check_near(stress_gap(&m, 0, x), 0, 1e-15);
                check_near(stress_normal(&m, 0, x + n), 0, 1e-14);
                stress_field(&m, saltus_flow_time(flow, 0).phase, x, a, size);
                assert_true(stress_reactions(&m, 1, a, reaction));
                check_near(forces[0], reaction[0], 1e-9 * (1 + fabs(reaction[0])));
                assert_true(forces[0] > 0);
                for (int f = 1; f < SALTUS_FACES_MAX; f++)
                    assert_true(forces[f] == 0);
                /* The field includes the contact. */
                double field[scene_dimension_max];
                saltus_flow_field(flow, 0, field);
                stress_react(&m, reaction, a);
                for (int i = 0; i < n; i++) {
                    check_near(field[i], x[n + i], 0);
                    check_near(field[n + i], a[i], 1e-10 * (1 + size[i]));
                }
            }
            saltus_flow_free(flow);
            saltus_system_free(system);
        }
}

/* Two faces with oblique normals are held at once: both hold, and the forces are the joint reactions. */
static void two_held_faces_share_the_load(void **unused) {
    (void)unused;
    for (int k = 0; k < 2; k++) {
        scene s = k ? scene_chain(0.1, 1, 0.5, 1) : scene_pipe(4, 20);
        stress_model m;
        saltus_flow_options options = saltus_flow_defaults();
        saltus_message message = {.text = ""};
        double x[scene_dimension_max], a[64], size[64], reaction[SALTUS_FACES_MAX], forces[SALTUS_FACES_MAX];
        double field[scene_dimension_max];
        scene_stop(&s, 0.01, 0.5, SALTUS_UPPER)->xi = 0.4;
        scene_stop(&s, 0.02, 0.5, SALTUS_LOWER)->xi = 0.55;
        s.spec.stops[0].weight[1] = 0.5;
        s.spec.stops[1].weight[1] = -0.7;
        stress_model_read(&m, &s.spec);
        const int n = m.dof;
        saltus_system *system = build(&s.spec);
        saltus_flow *flow = NULL;
        check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message), &message);
        check_ok(saltus_flow_place(flow, 0, (saltus_time){0, 0.1}, s.state, 3, &message), &message);
        for (int step = 0; step < 5; step++) {
            if (step > 0)
                check_ok(saltus_flow_coast(flow, 0, (saltus_time){0, 0.1 + 0.1 * step}, NULL, &message),
                         &message);
            saltus_flow_state(flow, 0, x);
            saltus_flow_forces(flow, 0, forces);
            saltus_flow_field(flow, 0, field);
            stress_field(&m, saltus_flow_time(flow, 0).phase, x, a, size);
            assert_true(stress_reactions(&m, 3, a, reaction));
            stress_react(&m, reaction, a);
            for (int f = 0; f < 2; f++) {
                check_near(stress_gap(&m, f, x), 0, 1e-15);
                check_near(stress_normal(&m, f, x + n), 0, 1e-13);
                check_near(forces[f], reaction[f], 1e-9 * (1 + fabs(reaction[f])));
            }
            for (int i = 0; i < n; i++)
                check_near(field[n + i], a[i], 1e-9 * (1 + size[i]));
        }
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* Two uncoupled balls, hit in the same instant or shortly after each other: each impact is as without the
 * other ball. */
static void tangents_of_balls_apart_stay_apart(void **unused) {
    (void)unused;
    for (int kind = 0; kind < 4; kind++) {
        const double r[2] = {0.45, kind % 2 ? 0.8 : 0.45}, phase = 0.1;
        double whole[16], delays[4];
        saltus_spec both = oscillator_spec(0, 0, 1.3, 1);
        set_parameter(&both, "N", 2);
        set_parameter(&both, "k2", 0);
        set_parameter(&both, "F0", -1);
        set_parameter(&both, "F2", 1.3);
        set_parameter(&both, "F02", -1);
        set_parameter(&both, "m2", kind / 2 ? 2 : 1);
        if (kind / 2) {
            set_parameter(&both, "F2", 2.6);
            set_parameter(&both, "F02", -2);
        }
        for (int b = 0; b < 2; b++) {
            add_stop(&both, 0, r[b], SALTUS_LOWER);
            both.stops[b].weight[0] = !b;
            both.stops[b].weight[1] = b;
        }
        saltus_system *system = build(&both);
        saltus_flow_options options = saltus_flow_defaults();
        options.columns = 4;
        saltus_flow *flow = open_flow(system, &options, phase, (double[]){0.2, 0.2, -0.3, -0.3});
        saltus_event event = advance(flow, phase + 1, SALTUS_WATCH_IMPACT);
        assert_int_equal(event.kind, SALTUS_IMPACT);
        assert_int_equal(saltus_flow_information(flow, 0).impacts, 2);
        saltus_flow_delays(flow, 0, delays);
        saltus_flow_tangents(flow, 0, whole);
        saltus_flow_free(flow);
        saltus_system_free(system);
        for (int b = 0; b < 2; b++) {
            saltus_spec alone = oscillator_spec(0, 0, 1.3, 1);
            double own[4], delay[2];
            set_parameter(&alone, "F0", -1);
            add_stop(&alone, 0, r[b], SALTUS_LOWER);
            system = build(&alone);
            options.columns = 2;
            flow = open_flow(system, &options, phase, (double[]){0.2, -0.3});
            advance(flow, phase + 1, SALTUS_WATCH_IMPACT);
            saltus_flow_tangents(flow, 0, own);
            saltus_flow_delays(flow, 0, delay);
            saltus_flow_free(flow);
            saltus_system_free(system);
            for (int c = 0; c < 2; c++) {
                check_near(delays[b + 2 * c], b == event.face ? delay[c] : 0, 1e-11);
                for (int i = 0; i < 2; i++) {
                    check_near(whole[(b + 2 * c) * 4 + b + 2 * i], own[2 * c + i], 1e-11);
                    check_near(whole[(b + 2 * c) * 4 + !b + 2 * i], 0, 1e-11);
                }
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(masses_apart_keep_their_own_events),
        cmocka_unit_test(impacts_in_one_instant_are_all_told),
        cmocka_unit_test(a_rebound_and_a_catch_in_one_instant_are_told),
        cmocka_unit_test(a_waiting_impact_is_not_told_late),
        cmocka_unit_test(two_held_faces_share_the_load),
        cmocka_unit_test(a_watcher_is_told_of_what_it_watches),
        cmocka_unit_test(counts_are_those_of_the_events),
        cmocka_unit_test(every_impulse_pushes),
        cmocka_unit_test(tangents_of_balls_apart_stay_apart),
        cmocka_unit_test(a_held_state_stays_on_its_stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
