/* Costs, event errors and counts of impacts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>
#include <limits.h>
#include <math.h>
#include <string.h>

static const double more_exact = 3e-14;
/* In the scale of the states: a motion that repeats to this is settled. */
static const double settled_to = 1e-8;

void sweep_build(sweep *s, int part) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    must(saltus_scene_load("fig6", &scene, &message), &message);
    for (int k = 0; k < omegas_max; k += part, s->count++) {
        char assignment[64];
        snprintf(assignment, sizeof assignment, "omega=%.17g", saltus_axis_value(&sweep_axis, k));
        must(saltus_scene_set(&scene, assignment, &message), &message);
        must(saltus_system_new(&scene.spec, &s->stopped[s->count], &message), &message);
        saltus_spec unstopped = scene.spec;
        unstopped.stop_count = 0;
        must(saltus_system_new(&unstopped, &s->unstopped[s->count], &message), &message);
    }
    s->events = must_allocate(rival_events_max, sizeof *s->events);
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

void sweep_make_reference(sweep *s) {
    program tight = {.lanes = saltus_flow_width(s->stopped[0], SALTUS_AUTOMATIC, LLONG_MAX),
                     .rtol = exact,
                     .strobe = true};
    for (int k = 0; k < 2 * s->count; k++) {
        motion *m = k < s->count ? &s->reference[k] : &s->found[k - s->count];
        m->strobe = must_allocate(recorded_periods + 1, sizeof *m->strobe);
    }
    own_sweep(s->stopped, s->count, &tight, s->reference);
    tight.rtol = more_exact;
    own_sweep(s->stopped, s->count, &tight, s->found);
    for (int k = 0; k < s->count; k++) {
        const double *scale = saltus_system_scale(s->stopped[k]);
        double error;
        const int period = motion_period(&s->reference[k], scale, settled_to);
        if (period > 0 && motion_period(&s->found[k], scale, settled_to) == period &&
            motion_agrees(&s->reference[k], period, &s->found[k], false, &error))
            s->period[k] = period;
        s->periodic += s->period[k] > 0;
    }
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
            same = p->rival->run(p->rival->which, saltus_system_spec(system), state, 1, p->rtol, &result);
        else
            same = own_period(system, p, state, next, &impacts) == SALTUS_OK;
        for (int e = 0; e < result.count && e < result.capacity; e++)
            impacts += s->events[e].kind == RIVAL_IMPACT;
        same = same && own_period(system, &tight, state, exact_next, &exact_impacts) == SALTUS_OK &&
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

void sweep_measure(sweep *s, const program *list, int count, int repeats, row *rows) {
    for (int k = 0; k < count * repeats; k++) {
        const program *p = &list[k % count];
        row *r = &rows[k % count];
        const bool engine = p->kind == program_engine, judged = k / count == repeats - 1 && !p->unstopped;
        const sweep_cost cost = program_run(s, p);
        if (k < count)
            *r = (row){.program = p, .cost = cost, .judged = -1, .median = NAN, .high = NAN, .worst = NAN};
        r->cost.seconds = fmin(r->cost.seconds, cost.seconds);
        r->cost.wall = fmin(r->cost.wall, cost.wall);
        r->labels = 0;
        for (int o = 0; o < s->count && judged && engine; o++)
            r->labels += s->period[o] > 0 && s->found[o].orbit_periods == s->period[o] &&
                         s->found[o].orbit_impacts == motion_orbit_impacts(&s->reference[o], s->period[o]);
        /* Only programs that record all impacts can be judged. */
        if (judged && (!engine || (!p->adaptive && p->keep & SALTUS_KEEP_IMPACTS)))
            judge(s, p, r);
    }
}
