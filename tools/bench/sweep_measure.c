/* Costs, event errors and counts of impacts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_measure.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double more_exact = 3e-14;
/* In the scale of the states: a motion that repeats to this is settled. */
static const double settled_to = 1e-8;

saltus_status sweep_build(sweep *s, int part, saltus_message *message) {
    saltus_scene scene;
    const saltus_axis axis = engine_axis();
    saltus_status status = saltus_scene_load("fig6", &scene, message);
    for (int k = 0; k < omegas_max && status == SALTUS_OK; k += part, s->count++) {
        char assignment[64];
        snprintf(assignment, sizeof assignment, "omega=%.17g", saltus_axis_value(&axis, k));
        status = saltus_scene_set(&scene, assignment, message);
        if (status == SALTUS_OK)
            status = saltus_system_new(&scene.spec, &s->stopped[s->count], message);
        saltus_spec unstopped = scene.spec;
        unstopped.stop_count = 0;
        if (status == SALTUS_OK)
            status = saltus_system_new(&unstopped, &s->unstopped[s->count], message);
    }
    s->events = malloc(rival_events_max * sizeof *s->events);
    return status == SALTUS_OK && !s->events ? SALTUS_NO_MEMORY : status;
}

void sweep_tear_down(sweep *s) {
    for (int k = 0; k < s->count; k++) {
        saltus_system_free(s->stopped[k]);
        saltus_system_free(s->unstopped[k]);
        motion_free(&s->reference[k]);
        motion_free(&s->found[k]);
    }
    free(s->events);
}

saltus_status sweep_make_reference(sweep *s, saltus_message *message) {
    program tight = {
        .lanes = saltus_flow_width(s->stopped[0], SALTUS_AUTOMATIC), .rtol = exact, .strobe = true};
    sweep_cost cost;
    for (int k = 0; k < 2 * s->count; k++) {
        motion *m = k < s->count ? &s->reference[k] : &s->found[k - s->count];
        m->strobe = malloc((recorded_periods + 1) * sizeof *m->strobe);
        if (!m->strobe)
            return SALTUS_NO_MEMORY;
    }
    saltus_status status = own_sweep(s->stopped, s->count, &tight, s->reference, &cost, message);
    tight.rtol = more_exact;
    if (status == SALTUS_OK)
        status = own_sweep(s->stopped, s->count, &tight, s->found, &cost, message);
    for (int k = 0; k < s->count && status == SALTUS_OK; k++) {
        const double *scale = saltus_system_scale(s->stopped[k]);
        double error;
        const int period = motion_period(&s->reference[k], scale, settled_to);
        if (period > 0 && motion_period(&s->found[k], scale, settled_to) == period &&
            motion_agrees(&s->reference[k], period, &s->found[k], false, &error))
            s->period[k] = period;
        s->periodic += s->period[k] > 0;
    }
    return status;
}

/* Whether a program, continued from its own settled state, finds the same count in every period as exact
 * integration. */
static bool counts_its_own(sweep *s, const program *p, int omega) {
    const program tight = {.rtol = exact};
    const saltus_system *system = s->stopped[omega];
    double state[motion_dimension], next[motion_dimension], exact_next[motion_dimension];
    bool same = true;
    memcpy(state, s->found[omega].settled, sizeof state);
    for (int k = 0; k < recorded_periods && same; k++) {
        rival_result result = {.events = s->events, .capacity = rival_events_max, .state = next};
        int impacts = 0, exact_impacts = 0;
        if (p->kind == program_rival)
            same = p->run(saltus_system_spec(system), state, 1, p->rtol, &result);
        else
            same = own_period(system, p, state, next, &impacts, NULL) == SALTUS_OK;
        for (int e = 0; e < result.count && e < result.capacity; e++)
            impacts += s->events[e].kind == RIVAL_IMPACT;
        same = same && own_period(system, &tight, state, exact_next, &exact_impacts, NULL) == SALTUS_OK &&
               impacts == exact_impacts;
        memcpy(state, next, sizeof state);
    }
    return same;
}

/* Fill in a row's errors and counts from the motions found. */
static void judge(sweep *s, const program *p, row *r) {
    static double errors[omegas_max];
    size_t count = 0;
    r->judged = 0;
    for (int k = 0; k < s->count; k += p->kind == program_rival ? s->part : 1) {
        double error = NAN;
        if (s->period[k] == 0)
            continue;
        r->judged++;
        if (motion_agrees(&s->reference[k], s->period[k], &s->found[k], p->kind == program_engine, &error))
            r->right++;
        else if (counts_its_own(s, p, k))
            r->elsewhere++;
        else
            r->wrong++;
        if (!isnan(error))
            errors[count++] = error;
    }
    if (count == 0)
        return;
    gsl_sort(errors, 1, count);
    r->median = gsl_stats_quantile_from_sorted_data(errors, 1, count, 0.5);
    r->high = gsl_stats_quantile_from_sorted_data(errors, 1, count, 0.9);
    r->worst = errors[count - 1];
}

/* The forcing is periodic, so the recorded periods may begin at time 0 again. */
static void run_rival(sweep *s, const program *p, row *r) {
    double start[SALTUS_SCENE_STATE_MAX], end[motion_dimension], simulated = 0, all = 0;
    for (int k = 0; k < s->count; k++)
        all += saltus_system_period(s->stopped[k]);
    for (int k = 0; k < s->count; k += s->part) {
        simulated += saltus_system_period(s->stopped[k]);
        const int periods[2] = {settling_periods, recorded_periods};
        motion *m = &s->found[k];
        motion_clear(m);
        saltus_system_default_state(s->stopped[k], start, NULL);
        memcpy(m->settled, start, sizeof m->settled);
        for (int stage = 0; stage < 2; stage++) {
            rival_result result = {
                .events = s->events, .capacity = stage ? rival_events_max : 0, .state = stage ? end : start};
            memcpy(end, m->settled, sizeof end);
            m->failed |= !p->run(saltus_system_spec(s->stopped[k]), end, periods[stage], p->rtol, &result);
            for (int e = 0; e < result.count && e < result.capacity; e++) {
                const rival_event *event = &result.events[e];
                if (event->kind == RIVAL_IMPACT)
                    motion_add_impact(m, event->time_over_T, event->normal_velocity);
                m->sticks += event->kind == RIVAL_STICK;
            }
            m->failed |= stage && result.count > result.capacity;
            if (!stage)
                memcpy(m->settled, start, sizeof m->settled);
            r->cost.seconds += result.cpu_seconds;
            r->cost.steps += result.steps;
            r->cost.evaluations += result.field_evaluations;
        }
    }
    r->share = simulated / all;
    r->cost.seconds /= r->share;
    r->cost.wall = r->cost.seconds;
}

bool sweep_measure(sweep *s, const program *list, int count, int repeats, row *rows) {
    for (int k = 0; k < count * repeats; k++) {
        const program *p = &list[k % count];
        row *r = &rows[k % count];
        const bool engine = p->kind == program_engine, judged = k / count == repeats - 1 && !p->unstopped;
        saltus_message message = {.text = ""};
        saltus_status status = SALTUS_OK;
        if (k < count)
            *r = (row){.program = p, .judged = -1, .share = 1, .median = NAN, .high = NAN, .worst = NAN};
        const sweep_cost before = r->cost;
        if (p->kind == program_rival)
            run_rival(s, p, r);
        else if (engine)
            status = engine_sweep(p, s->found, &r->cost, &message);
        else
            status = own_sweep(p->unstopped ? s->unstopped : s->stopped, s->count, p, s->found, &r->cost,
                               &message);
        if (status != SALTUS_OK) {
            fprintf(stderr, "saltus_sweep_bench: %s: %s\n", p->name, message.text);
            return false;
        }
        if (p->kind != program_rival && before.seconds > 0) {
            r->cost.seconds = fmin(before.seconds, r->cost.seconds);
            r->cost.wall = fmin(before.wall, r->cost.wall);
        }
        r->labels = 0;
        for (int o = 0; o < s->count && judged && engine; o++)
            r->labels += s->period[o] > 0 && s->found[o].orbit_periods == s->period[o] &&
                         s->found[o].orbit_impacts == motion_orbit_impacts(&s->reference[o], s->period[o]);
        /* Only programs that record all impacts can be judged. */
        if (judged && (!engine || (!p->adaptive && p->keep & SALTUS_KEEP_IMPACTS)))
            judge(s, p, r);
    }
    return true;
}
