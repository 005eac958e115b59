/* Branches of periodic orbits: the points that they give out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/trace.h"

#include "branch/point.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>

saltus_status saltus_trace_open(saltus_trace *t, const saltus_spec *spec, saltus_message *message) {
    const saltus_branch_options *o = t->trail->options;
    t->here = &t->solutions[0];
    t->next = &t->solutions[1];
    t->trial = &t->solutions[2];
    t->spare = &t->solutions[3];
    t->other = &t->solutions[4];
    t->orbits.options = o->orbit;
    t->orbits.options.flow.stop = NULL;
    saltus_status status =
        saltus_branch_family(spec, o, 1, &t->orbits.family, &t->orbits.origin, &t->range, message);
    return status == SALTUS_OK ? saltus_orbits_open(&t->orbits, message) : status;
}

void saltus_trace_close(saltus_trace *t) {
    for (int k = 0; k < 5; k++)
        saltus_solution_clear(&t->solutions[k]);
    saltus_lap_close(&t->first);
    saltus_orbits_close(&t->orbits);
}

static void tell_returns(const saltus_trace *t, int returns, int before, double until, char *reason) {
    snprintf(reason, SALTUS_REASON_MAX, "returns to the section: %d, were %d until %s = %.12g%s", returns,
             before, t->trail->options->key[0], until,
             returns ? "" : "; another section would count the orbit");
}

void saltus_trace_give(saltus_trace *t, const saltus_solution *s, saltus_notice what) {
    char reason[SALTUS_REASON_MAX];
    saltus_cycle_count count;
    saltus_branch_point point;
    if (!saltus_point_make(&t->orbits, s, what.change, &point, &count)) {
        t->trail->following = false;
        return;
    }
    const saltus_survey *before = &t->here->survey;
    /* Where the marks tell on which side of the change the orbit is, what they leave to the flow is counted
     * on the orbit itself. */
    const bool told = what.grazing && s->survey.walked && s->sequence.count == t->here->sequence.count;
    if (what.change && !told && before->label[0]) {
        saltus_solution_label(&t->orbits, t->here, point.label);
        point.impacts = before->impacts;
        point.sticking_intervals = before->sticking_intervals;
    }
    /* Without forcing, an orbit may lose or gain a return to its section, such as a maximum, without any
     * change of the branch: the first point behind says so, and since which parameter value. */
    const int returns = count.returns;
    if (s->sequence.omega > 0 && s->survey.walked && returns >= 0) {
        if (t->returns >= 0 && returns != t->returns && !(what.reason && what.reason[0]) && !what.addition) {
            tell_returns(t, returns, t->returns, t->counted, reason);
            what.reason = reason;
        }
        t->returns = returns;
        t->counted = what.value ? *what.value : s->value;
    }
    saltus_lap lap = {0};
    const bool known = point.periods > 1 && s->sequence.omega == 0 && saltus_trail_keeps(what.kind) &&
                       saltus_solution_section(&t->orbits, s, point.state, &lap);
    saltus_breach touch = what.grazing ? *what.grazing : (saltus_breach){.time = 0};
    touch.time = saltus_point_time(s, &count, touch.time);
    what.grazing = what.grazing ? &touch : NULL;
    saltus_trail_give(t->trail, t->orbits.system, &point, known ? lap.points : NULL, &what,
                      &t->orbits.starved);
    saltus_lap_close(&lap);
}

void saltus_trace_end(saltus_trace *t, const saltus_solution *s, double ahead, const char *reason) {
    saltus_trace_give(
        t, s, (saltus_notice){.kind = SALTUS_POINT_EP, .ahead = ahead, .accuracy = NAN, .reason = reason});
}

/* Visit `trial` at this distance along the step and return its number of returns; -1 where there is none. */
static int returns_at(saltus_trace *t, double ahead) {
    saltus_lap lap = {0};
    const bool found = saltus_solution_visit(&t->orbits, t->here, ahead, t->trial) &&
                       saltus_cycle_around(&t->orbits, t->trial, &lap);
    int returns = found ? lap.returns : -1;
    saltus_lap_close(&lap);
    return returns;
}

/* The number of returns has changed from `before` at `here` to another one at `next`, the last point given
 * out. Insert a point before it wherever a return appears or vanishes: there the section's function has an
 * extremum of value zero. Bisection on the number is enough, since the flow isolates zeros to rounding. */
static void locate_returns(saltus_trace *t, int before) {
    enum { halvings = 60 };
    const double sharp = 1e-13;
    const saltus_list *queue = &t->trail->queue;
    const int last = queue->count - 1, after = t->returns;
    double low = 0;
    int count = returns_at(t, 0);
    if (count != before)
        return;
    while (t->trail->following && count != after && t->trail->made + 1 < t->trail->options->points) {
        double high = t->next->at.ahead;
        int beyond = after;
        for (int k = 0; k < halvings && high - low > sharp && beyond >= 0; k++) {
            const double middle = 0.5 * (low + high);
            const int found = returns_at(t, middle);
            *(found == count ? &low : &high) = middle;
            beyond = found == count ? beyond : found;
        }
        /* Near its start the step may have passed another change, which has been reported already. */
        if (beyond < 0 || high < 1e-9 || returns_at(t, high) != beyond)
            break;
        const double error = t->orbits.options.flow.rtol + fabs(saltus_solution_heading(t->trial)) * sharp;
        saltus_notice what = {.ahead = high, .accuracy = error * t->orbits.family.unit[0]};
        char reason[SALTUS_REASON_MAX];
        tell_returns(t, beyond, count, t->trial->value, reason);
        what.reason = reason;
        saltus_solution_survey(&t->orbits, t->trial, NULL);
        t->returns = beyond;
        saltus_trace_give(t, t->trial, what);
        low = high;
        count = beyond;
    }
    t->returns = after;
    if (count == after)
        ((saltus_branch_point *)queue->items)[last].reason[0] = 0;
    for (int k = last; k + 1 < queue->count; k++) {
        saltus_branch_point *pair = (saltus_branch_point *)queue->items + k;
        SALTUS_SWAP(pair[0], pair[1]);
    }
}

void saltus_trace_accept(saltus_trace *t, bool bends, const char *reason) {
    if (reason || saltus_trail_wants(t->trail, t->next->at.ahead)) {
        const int returns = t->returns;
        saltus_trace_give(t, t->next,
                          (saltus_notice){.ahead = t->next->at.ahead, .accuracy = NAN, .reason = reason});
        if (bends && returns >= 0 && t->returns != returns && t->trail->following)
            locate_returns(t, returns);
        saltus_trail_shown(t->trail, t->next->at.ahead);
    }
    t->trail->arclength += t->next->at.ahead;
    t->trail->fresh = false;
    SALTUS_SWAP(t->here, t->next);
    if (bends)
        saltus_curve_bend(&t->next->at, &t->here->at);
    if (bends && t->next->survey.walked)
        saltus_survey_follow(&t->here->survey, &t->next->survey, -t->here->at.ahead);
    if (bends)
        saltus_solution_expect_grazing(t->here, t->next);
    if (t->trail->following)
        saltus_solution_reframe(&t->orbits, true, false, t->here, t->trial, NULL);
}

void saltus_trace_archive(saltus_trace *t, saltus_archive *a) {
    saltus_orbits *o = &t->orbits;
    saltus_equations *e = o->equations;
    saltus_lap *first = &t->first;
    t->births.count = (int)saltus_archive_whole(a, t->births.count, 0, saltus_births_length);
    saltus_archive_finite(a, t->births.place, (size_t)t->births.count);
    saltus_archive_finite(a, &t->first_value, 1);
    t->returns = (int)saltus_archive_whole(a, t->returns, -1, INT_MAX);
    saltus_archive_finite(a, &t->counted, 1);
    size_t periods = first->points ? (size_t)first->periods : 0;
    periods = saltus_archive_length(a, periods, (size_t)a->n);
    if (a->reading && a->sound && periods && !saltus_lap_reserve(first, (int)periods, a->n))
        a->starved = true;
    first->periods = first->points ? (int)periods : 0;
    saltus_archive_finite(a, first->points, (size_t)first->periods * (size_t)a->n);
    saltus_archive_shape(a, o->shooting);
    /* The point at which the Jacobian of the equations is known, from which the next step begins; reading,
     * they are evaluated there again. */
    if (saltus_archive_flag(a, e->known)) {
        const bool collected = saltus_archive_flag(a, saltus_shooting_collected(o->shooting, e->place));
        double *place = a->reading ? e->trial : e->place;
        saltus_archive_finite(a, place, (size_t)e->unknowns);
        if (a->reading && a->sound) {
            saltus_shooting_collect(o->shooting, collected ? &o->cocycle : NULL);
            const saltus_status status = saltus_equations_evaluate(e, place, NULL);
            saltus_shooting_collect(o->shooting, NULL);
            a->sound = status == SALTUS_OK;
            a->starved = a->starved || status == SALTUS_NO_MEMORY;
        }
    }
    saltus_archive_solution(a, o, t->here);
}
