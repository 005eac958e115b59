/* What branch.h says of a point and of a run, found anew from the point's own parameters and state by the
 * event-driven flow, by a search, and by counting.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_BRANCH_RECOUNT_H
#define SALTUS_TESTS_BRANCH_RECOUNT_H

#include "branch_check.h"

enum { recount_room = 256 };

/* One orbit as the flow runs it. */
typedef struct recount {
    saltus_event event[recount_room];
    int count, impacts, sticks;
    bool chatter; /* a contact begins though impacts rebound */
    bool held;
    double log_restitution; /* sum of 2 ln r */
    double gap;             /* scaled distance of the end from the begin */
    char label[SALTUS_LABEL_MAX];
} recount;

static inline double recount_distance(const saltus_system *system, const double *a, const double *b) {
    const double *scale = saltus_system_scale(system);
    double largest = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        largest = fmax(largest, fabs(a[i] - b[i]) / scale[i]);
    return largest;
}

static inline recount recount_orbit(const saltus_system *system, int periods, const double *state) {
    saltus_flow_options options = saltus_flow_defaults();
    recount out = {.count = 0};
    double end[SALTUS_SCENE_STATE_MAX];
    saltus_flow *flow = open_flow(system, &options, 0, state);
    for (;;) {
        saltus_event event = advance(flow, periods, SALTUS_WATCH_CONTACT);
        if (event.kind == SALTUS_REACHED)
            break;
        double r = saltus_system_face(system, event.face).r;
        assert_true(out.count < recount_room);
        out.event[out.count++] = event;
        out.sticks += event.kind == SALTUS_STICK;
        out.chatter |= event.kind == SALTUS_STICK && r > 0;
        out.impacts += event.kind == SALTUS_IMPACT || (event.kind == SALTUS_STICK && r == 0);
        if (event.kind == SALTUS_IMPACT)
            out.log_restitution += 2 * log(r);
    }
    out.held = out.count == 0 && saltus_flow_contacts(flow, 0) != 0;
    saltus_flow_state(flow, 0, end);
    out.gap = recount_distance(system, end, state);
    saltus_flow_free(flow);
    if (out.held)
        snprintf(out.label, sizeof out.label, "held");
    else if (out.chatter)
        snprintf(out.label, sizeof out.label, "chatter/%d", periods);
    else
        snprintf(out.label, sizeof out.label, "%d/%d", out.impacts, periods);
    return out;
}

/* The events of one orbit, times in periods from phase 0, in order; impacts of a burst that ends in a contact
 * come as the flow's tolerance has them, so there only the contacts count. */
static inline void recount_events(const saltus_branch_point *p, const saltus_system *system,
                                  const recount *again) {
    const double speed = saltus_system_scale(system)[saltus_system_dof(system)];
    double last = 0;
    if (!again->chatter)
        assert_int_equal(p->event_count, again->count);
    for (int k = 0, j = 0; k < p->event_count; k++) {
        const saltus_event *e = &p->events[k];
        double time = saltus_time_periods(e->time);
        assert_true(time >= last && time < p->periods);
        assert_true(e->time.phase >= 0 && e->time.phase < 1);
        last = time;
        if (again->chatter && e->kind == SALTUS_IMPACT)
            continue;
        while (again->chatter && j < again->count && again->event[j].kind == SALTUS_IMPACT)
            j++;
        assert_true(j < again->count);
        const saltus_event *a = &again->event[j++];
        assert_int_equal(e->kind, a->kind);
        assert_int_equal(e->face, a->face);
        check_near(time, saltus_time_periods(a->time), 1e-6);
        check_near(e->velocity_before, a->velocity_before, 1e-6 * speed);
        check_near(e->velocity_after, a->velocity_after, 1e-6 * speed);
        check_near(e->displacement, a->displacement, 1e-9);
    }
}

/* Multipliers by a search from another section point, and what is counted of them. */
static inline void recount_multipliers(const saltus_branch_point *p, const saltus_system *system,
                                       const recount *again) {
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    int unstable = 0;
    bool large = p->multipliers[0].log_modulus > log(1e3);
    double sum = 0;
    for (int i = 0; i < p->dimension; i++) {
        double log_modulus = p->multipliers[i].log_modulus;
        unstable += log_modulus >= -1e-10;
        sum += isinf(log_modulus) ? 0 : log_modulus;
        assert_true(i == 0 || !(log_modulus > p->multipliers[i - 1].log_modulus));
    }
    assert_int_equal(p->unstable, unstable);
    /* Where a multiplier is on the unit circle nothing is stable, whatever rounding makes of it. */
    bool critical = p->kind == SALTUS_POINT_LP || p->kind == SALTUS_POINT_PD || p->kind == SALTUS_POINT_BP ||
                    p->kind == SALTUS_POINT_NS;
    assert_int_equal(p->stable, unstable == 0 && !critical);
    check_near(p->log_volume, sum, 1e-9 * (1 + fabs(sum)));
    if (large)
        return;
    check_ok(saltus_orbit_find(system, p->periods, p->state, &options, &orbit, &message), &message);
    check_near(recount_distance(system, orbit.state, p->state), 0, 1e-7);
    for (int i = 0; i < p->dimension; i++) {
        double size = hypot(orbit.multipliers[0].re, orbit.multipliers[0].im),
               near = 1e-5 * (1 + size * size);
        check_near(p->multipliers[i].re, orbit.multipliers[i].re, near);
        check_near(fabs(p->multipliers[i].im), fabs(orbit.multipliers[i].im), near);
    }
    if (!orbit.sticks) {
        double trace =
            saltus_system_trace(system, p->state, 0); /* of a linear oscillator: everywhere the same */
        double rule = again->log_restitution + trace * p->periods * saltus_system_period(system);
        check_near(p->sum_rule, rule, 1e-7 * (1 + fabs(rule)));
        check_near(p->log_volume, rule, 1e-6 * (1 + fabs(rule)));
    }
    saltus_orbit_clear(&orbit);
}

/* A point at which nothing special happens. */
static inline void recount_point(const saltus_branch_point *p) {
    saltus_system *system = build(&p->spec);
    recount again = recount_orbit(system, p->periods, p->state);
    assert_int_equal(p->dimension, saltus_system_dimension(system));
    assert_true(p->admissible);
    check_near(again.gap, 0, 1e-7);
    assert_string_equal(p->label, again.label);
    assert_int_equal(p->impacts, again.chatter ? -1 : again.impacts);
    assert_int_equal(p->sticking_intervals, again.sticks);
    check_near(p->residual, 0, 1e-12);
    assert_in_range(p->iterations, 0, 20);
    recount_events(p, system, &again);
    recount_multipliers(p, system, &again);
    saltus_system_free(system);
}

/* A zero of a test function: the multiplier that makes the point, found anew. */
static inline void recount_special(const saltus_branch_point *p) {
    saltus_system *system = build(&p->spec);
    recount again = recount_orbit(system, p->periods, p->state);
    int critical = 0;
    const saltus_multiplier *mu = p->multipliers;
    for (int i = 1; i < p->dimension; i++)
        if (fabs(mu[i].log_modulus) < fabs(mu[critical].log_modulus))
            critical = i;
    bool joins = p->kind == SALTUS_POINT_PD && p->reason[0];
    double slowest = INFINITY;
    for (int k = 0; k < again.count; k++)
        if (again.event[k].kind == SALTUS_IMPACT)
            slowest = fmin(slowest, fabs(again.event[k].velocity_before));
    /* Almost at grazing multipliers are hardly determined. */
    bool known = slowest > 1e-4 * saltus_system_scale(system)[saltus_system_dof(system)];
    check_near(known ? mu[critical].log_modulus : 0, 0, 1e-3);
    if (p->kind == SALTUS_POINT_NS)
        assert_true(fabs(mu[critical].im) > 1e-3);
    else if (known)
        check_near(mu[critical].re, p->kind == SALTUS_POINT_PD && !joins ? -1 : 1, 1e-3);
    check_near(again.gap, 0, 1e-6);
    assert_string_equal(p->label, again.label);
    saltus_system_free(system);
}

/* What is counted of the multipliers, and the volume that they leave, at special points too: those of grazing
 * are the orbit's just before, with the impacts that the label counts. The rule is tried where all stops have
 * the same restitution.
 */
static inline void recount_volume(const saltus_branch_point *p) {
    int unstable = 0;
    bool zeros = false;
    double sum = 0;
    for (int i = 0; i < p->dimension; i++) {
        double log_modulus = p->multipliers[i].log_modulus;
        if (isnan(log_modulus))
            return;
        /* Of a pair the one with the positive imaginary part comes first. */
        assert_true(i == 0 || p->multipliers[i - 1].log_modulus != log_modulus ||
                    p->multipliers[i - 1].im >= p->multipliers[i].im);
        zeros |= isinf(log_modulus);
        unstable += log_modulus >= -1e-10;
        sum += isinf(log_modulus) ? 0 : log_modulus;
    }
    /* Where a multiplier is on the unit circle nothing is stable, whatever rounding makes of it, and it is
     * not counted. */
    bool critical = p->kind == SALTUS_POINT_LP || p->kind == SALTUS_POINT_PD || p->kind == SALTUS_POINT_BP ||
                    p->kind == SALTUS_POINT_NS;
    const bool leaves = p->parent >= 0 && p->step == 0; /* at such a place, too */
    if (!critical && !leaves && p->kind != SALTUS_POINT_EP) {
        assert_int_equal(p->unstable, unstable);
        assert_int_equal(p->stable, unstable == 0);
    }
    assert_false(critical && p->stable);
    /* Without it one multiplier was lost in errors and taken from the rule. */
    if (!isnan(p->log_volume))
        check_near(p->log_volume, sum, 1e-9 * (1 + fabs(sum)));
    if (zeros || p->impacts < 0 || p->kind == SALTUS_POINT_EP || strncmp(p->reason, "joins", 5) == 0)
        return;
    for (int k = 0; k < p->spec.stop_count; k++)
        if (p->spec.stops[k].r != p->spec.stops[0].r)
            return;
    saltus_system *system = build(&p->spec);
    double rule = saltus_system_trace(system, p->state, 0) * p->periods * saltus_system_period(system);
    if (p->impacts)
        rule += (double)p->impacts * 2 * log(p->spec.stops[0].r);
    /* Beside a grazing the flow may meet the impact or not. */
    if (p->kind == SALTUS_POINT_GR && fabs(p->sum_rule - rule) > 1e-3)
        rule -= (p->sum_rule < rule ? -1 : 1) * 2 * log(p->spec.stops[0].r);
    check_near(p->sum_rule, rule, 1e-6 * (1 + fabs(rule)));
    check_near(sum, rule, 1e-5 * (1 + fabs(rule)));
    saltus_system_free(system);
}

/* The touch at grazing is where the flow is at a stop, with next to no speed. */
static inline void recount_touch(const saltus_branch_point *p) {
    assert_int_equal(p->grazing_stop != 0, p->grazing_side != 0);
    assert_int_equal(p->grazing_stop == 0, isnan(p->grazing_time));
    if (!p->grazing_stop)
        return;
    assert_int_equal(p->kind, SALTUS_POINT_GR);
    assert_true(p->grazing_time >= 0 && p->grazing_time < p->periods);
    saltus_system *system = build(&p->spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = open_flow(system, &options, 0, p->state);
    double state[SALTUS_SCENE_STATE_MAX], place = 0, speed = 0;
    const double *normal = saltus_system_stop_normal(system, p->grazing_stop - 1),
                 *scale = saltus_system_scale(system);
    int dof = saltus_system_dof(system);
    while (advance(flow, p->grazing_time, SALTUS_WATCH_CONTACT).kind != SALTUS_REACHED)
        ;
    saltus_flow_state(flow, 0, state);
    for (int i = 0; i < dof; i++) {
        place += normal[i] * state[i];
        speed += normal[i] * state[dof + i];
    }
    check_near(place, p->grazing_side * p->spec.stops[p->grazing_stop - 1].d, 1e-7 * scale[0]);
    check_near(speed, 0, 1e-4 * scale[dof]);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A branch that has come back to a special point changes there as it did before, or the other way round. */
static inline void recount_closure(const branch_record *record, int end) {
    const saltus_branch_point *p = &record->point[end];
    bool found = false;
    for (int k = 0; k < end; k++) {
        const saltus_branch_point *q = &record->point[k];
        found |= q->branch == p->branch && fabs(q->value[0] - p->value[0]) < 1e-6 * fabs(p->value[0]) &&
                 ((strcmp(q->label, p->label) == 0 && strcmp(q->label_after, p->label_after) == 0) ||
                  (strcmp(q->label, p->label_after) == 0 && strcmp(q->label_after, p->label) == 0));
    }
    assert_true(found);
}

/* What holds of every point, whatever its kind. */
static inline void recount_place(const branch_record *record, const saltus_branch_options *options, int k) {
    const saltus_branch_point *p = &record->point[k];
    saltus_direction direction;
    saltus_message message = {.text = ""};
    double value, unit = options->high[0] - options->low[0];
    check_ok(saltus_spec_direction(&p->spec, options->key[0], &direction, &value, &message), &message);
    /* Joins and ends of chatter are given at a place that is known better than the orbit found beside it. */
    bool beside = p->kind == SALTUS_POINT_CH || strcmp(p->label_after, "held") == 0 ||
                  strncmp(p->reason, "joins", 5) == 0;
    check_near(value, p->value[0], beside ? 1e-4 * unit : 1e-12 * (1 + fabs(value)));
    assert_true(p->value[0] >= options->low[0] - 1e-9 * unit &&
                p->value[0] <= options->high[0] + 1e-9 * unit);
    assert_true(isnan(p->value[1]));
    recount_touch(p);
    recount_volume(p);
    assert_true(fabs(p->heading) <= unit * (1 + 1e-9));
    bool bracketed = p->kind != SALTUS_POINT_REGULAR && p->kind != SALTUS_POINT_EP;
    if (bracketed)
        assert_true(p->accuracy >= 0 && p->accuracy < 1e-7 * unit);
    if (p->kind == SALTUS_POINT_REGULAR)
        assert_true(isnan(p->accuracy));
    bool changes = p->kind == SALTUS_POINT_GR || p->kind == SALTUS_POINT_CH || p->kind == SALTUS_POINT_ST;
    bool closed = strstr(p->reason, "has come back to this") != NULL;
    assert_true(changes || closed || !p->label_after[0]);
    if (closed)
        recount_closure(record, k);
    if (p->kind == SALTUS_POINT_EP)
        assert_true(p->reason[0] && (k + 1 == record->count || record->point[k + 1].branch != p->branch));
}

/* From one point to the next on the same branch. */
static inline void recount_step(const saltus_branch_point *a, const saltus_branch_point *b,
                                const saltus_branch_options *options) {
    double unit = options->high[0] - options->low[0], ahead = b->arclength - a->arclength;
    assert_int_equal(b->parent, a->parent);
    assert_int_equal(b->step, a->step + (a->kind == SALTUS_POINT_REGULAR));
    assert_true(ahead >= -1e-12 && ahead <= options->step_max + 1e-2);
    assert_true(fabs(b->value[0] - a->value[0]) <= unit * (ahead + 1e-9));
    if (a->label_after[0] && b->kind != SALTUS_POINT_EP)
        assert_string_equal(b->label, a->label_after);
    /* At a change of events the flow sees one side or the other by chance; what is told is the side before.
     */
    bool changes = b->kind == SALTUS_POINT_GR || b->kind == SALTUS_POINT_CH || b->kind == SALTUS_POINT_ST;
    if (changes && a->kind == SALTUS_POINT_REGULAR) {
        assert_string_equal(b->label, a->label);
        assert_true(b->impacts == a->impacts && b->sticking_intervals == a->sticking_intervals);
    }
    if (a->kind == SALTUS_POINT_REGULAR && b->kind == SALTUS_POINT_REGULAR) {
        /* Somewhere on the way d value / d arclength is the mean. */
        double mean = (b->value[0] - a->value[0]) / ahead;
        assert_true(mean >= fmin(a->heading, b->heading) - 0.05 * unit);
        assert_true(mean <= fmax(a->heading, b->heading) + 0.05 * unit);
    }
}

/* Between two regular points of one sequence as many multipliers pass the unit circle as are told of, and at
 * the only special point between them the lower number is outside. The first point of a branch that was
 * switched to has one on the circle. */
static inline void recount_crossings(const branch_record *record) {
    const saltus_branch_point *last = NULL, *between = NULL;
    int single = 0, pairs = 0;
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *p = &record->point[k];
        between = p->kind ? p : between;
        bool changes = p->kind == SALTUS_POINT_GR || p->kind == SALTUS_POINT_CH || p->kind == SALTUS_POINT_ST;
        single += p->kind == SALTUS_POINT_LP || p->kind == SALTUS_POINT_PD || p->kind == SALTUS_POINT_BP;
        pairs += p->kind == SALTUS_POINT_NS;
        if (changes || p->kind == SALTUS_POINT_EP)
            last = NULL;
        if (p->kind != SALTUS_POINT_REGULAR)
            continue;
        if (last && strcmp(last->label, p->label) == 0 && last->admissible && p->admissible) {
            int passed = abs(p->unstable - last->unstable);
            assert_true((passed - single) % 2 == 0 && passed <= single + 2 * pairs);
            if (single + pairs == 1)
                assert_int_equal(between->unstable,
                                 p->unstable < last->unstable ? p->unstable : last->unstable);
        }
        last = p->parent >= 0 && p->step == 0 ? NULL : p;
        single = pairs = 0;
    }
}

/* All of a run; every so many regular points in full. */
static inline void recount_run(const branch_record *record, const saltus_branch_options *options, int every) {
    recount_crossings(record);
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *p = &record->point[k], *before = k ? p - 1 : NULL;
        recount_place(record, options, k);
        if (!before || before->branch != p->branch) {
            bool nothing = p->parent >= 0 && strncmp(p->reason, "nothing was found to follow", 27) == 0;
            assert_int_equal(p->kind, nothing ? SALTUS_POINT_EP : SALTUS_POINT_REGULAR);
            assert_int_equal(p->step, 0);
            assert_true(p->parent < p->branch);
            assert_true(!before || (before->kind == SALTUS_POINT_EP && p->branch > before->branch));
            assert_true(p->parent >= 0 || fabs(p->arclength) == 0);
        } else {
            recount_step(before, p, options);
        }
        if (p->kind == SALTUS_POINT_UZ ||
            (p->kind == SALTUS_POINT_REGULAR && p->step % every == 0 && p->step))
            recount_point(p);
        if (p->kind == SALTUS_POINT_LP || p->kind == SALTUS_POINT_PD || p->kind == SALTUS_POINT_NS ||
            p->kind == SALTUS_POINT_BP)
            recount_special(p);
    }
}

#endif
