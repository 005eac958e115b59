/* How branches of periodic orbits begin.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/born.h"
#include "branch/sequence.h"
#include "branch/trace.h"
#include "orbit/poincare.h"
#include "orbit/returns.h"
#include "orbit/sequence.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

saltus_status saltus_trace_begin(saltus_trace *t, int periods, const double *state, saltus_message *message) {
    saltus_orbits *o = &t->orbits;
    saltus_orbit orbit = {0};
    saltus_lap lap = {.keeps_events = true};
    saltus_orbit_options options = o->options;
    options.phase = 0;
    options.flow.stop = t->trail->options->orbit.flow.stop;
    const bool cycle = o->options.free_period;
    saltus_branch_start start = {.parent = -1};
    saltus_system *clocked = NULL;
    const double at_start[2] = {0};
    saltus_status status =
        cycle ? saltus_cycle_polish(o->system, state, &options, &orbit, &clocked, &lap, message)
              : saltus_return_polish(o->flow, periods, state, &options, &orbit, &lap, message);
    start.state = orbit.state;
    start.states = o->n;
    /* A cycle that comes from flips has two, four, .. of the clock's periods, so that the place is seen where
     * it joins shorter ones; it may have lost or won a return since. */
    const int turns = cycle && lap.periods > 0 ? lap.periods & -lap.periods : orbit.periods;
    if (status == SALTUS_OK && cycle)
        status = saltus_orbits_tune(o, at_start, orbit.omega * turns, message);
    if (status == SALTUS_OK)
        status = saltus_sequence_make(o->flow, turns, cycle, orbit.state, &lap, &start.sequence, message);
    if (status == SALTUS_OK)
        saltus_sequence_even(&start.sequence);
    saltus_system_free(clocked);
    if (status == SALTUS_OK)
        saltus_starts_add_ways(t->starts, &start, t->trail->options->direction, &o->starved);
    saltus_orbit_clear(&orbit);
    saltus_lap_close(&lap);
    return status == SALTUS_OK && o->starved ? saltus_branch_no_memory(message) : status;
}

/* If no branch can begin at a start that was switched to, give out one point that says why. */
static void give_up(saltus_trace *t, const saltus_branch_start *start, const char *why) {
    t->trail->following = false;
    if (saltus_solution_restore(&t->orbits, &start->sequence, start->parameter, start->state, false, t->here,
                                NULL) != SALTUS_OK ||
        saltus_solution_survey(&t->orbits, t->here, NULL) != SALTUS_OK || !start->origin)
        return;
    char reason[SALTUS_REASON_MAX];
    snprintf(reason, sizeof reason, "nothing was found to follow from this %s: %.100s",
             saltus_point_word(start->origin), why);
    saltus_trace_end(t, t->here, 0, reason);
}

/* Whether a branch begins with small cycles at an equilibrium. */
static bool is_small(const saltus_branch_start *start) {
    return start->origin == SALTUS_POINT_HB || start->origin == SALTUS_POINT_BE;
}

/* The cycle of a start at a Hopf point, at distance `apart` from the equilibrium along its tangent; not
 * surveyed, with a tangent away from the equilibrium. */
static saltus_status hopf_cycle(saltus_orbits *o, const saltus_branch_start *start, double apart,
                                saltus_solution *out, saltus_message *message) {
    saltus_equations *e = o->equations;
    double normal[SALTUS_STATE_MAX + 2] = {0}, place[SALTUS_STATE_MAX + 2];
    memcpy(normal, start->tangent, (size_t)o->n * sizeof *normal);
    saltus_status status = saltus_hopf_aside(o, start->parameter, start->state, start->tangent, apart,
                                             &start->sequence, out, message);
    if (status != SALTUS_OK)
        return status;
    memcpy(place, out->at.u, (size_t)e->unknowns * sizeof *place);
    status = saltus_newton(e, out->at.u, normal, place, true, &out->at.iterations, message);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(e, out->at.u, message);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, out, message);
    return status == SALTUS_OK ? saltus_curve_orient(e, normal, &out->at, message) : status;
}

/* `here` becomes the first orbit of a branch; at an equilibrium that is a small cycle. For the first branch
 * of a run, the orbit is cut into more and more segments while Newton's method fails: between prescribed
 * impacts rounding may grow far more than along the motion, on which impacts come earlier or later. Chatter
 * lets an orbit close whatever happened before, so that it may be stable although errors grow without
 * bound up to there: then the guess is far away in spite of its small residual. */
static saltus_status place_first(saltus_trace *t, const saltus_branch_start *start, saltus_message *why) {
    static const double apart[2][4] = {{1e-3, 1e-4, 1e-2, 1e-5}, {1e-2, 3e-3, 3e-2, 1e-3}};
    saltus_orbits *o = &t->orbits;
    saltus_solution *here = t->here;
    saltus_sequence sequence = start->sequence;
    saltus_status status = SALTUS_NO_CONVERGENCE;
    const double visible = 1e-7; /* in half an orbit; the other half adds to it */
    double growth = 0;
    if (is_small(start)) {
        const bool hopf = start->origin == SALTUS_POINT_HB;
        saltus_branch_start even = *start;
        saltus_sequence_even(&even.sequence);
        for (int k = 0; k < 4 && status != SALTUS_OK; k++)
            status = saltus_orbits_noted(o, hopf ? hopf_cycle(o, &even, apart[1][k], here, why)
                                                 : saltus_boundary_cycle(o, &even, apart[0][k], here, why));
        return status;
    }
    if (start->unknowns)
        return saltus_solution_restore(o, &sequence, start->parameter, start->state, false, here, why);
    const int most = start->parent < 0 ? SALTUS_CUTS_MAX : 1;
    o->equations->bold = start->parent < 0;
    for (int cuts = 1; cuts <= most && status != SALTUS_OK; cuts *= 2) {
        if (cuts > 1)
            saltus_sequence_turn(&start->sequence, start->sequence.base, cuts, &sequence, NULL);
        status = saltus_solution_place(o, &sequence, start->parameter, start->state, true, here, why);
        if (cuts > 1 && status == SALTUS_NO_CONVERGENCE && isfinite(o->equations->size))
            growth = fmax(growth, saltus_shooting_growth(o->shooting));
    }
    o->equations->bold = false;
    if (status == SALTUS_NO_CONVERGENCE && growth * o->options.flow.rtol > visible)
        return saltus_fail(
            why, status,
            "errors of the flow grow %.1g-fold or more along it, so that it is not known where it is",
            growth);
    return status;
}

/* Give out the first point of a branch as a regular point, and again as UZ if it lies at a requested value.
 * Keep its section points, to notice when the branch comes back to it. */
static void give_first(saltus_trace *t, const saltus_branch_start *start) {
    const saltus_branch_options *options = t->trail->options;
    const saltus_solution *here = t->here;
    const int side = start->heading > 0;
    /* What branches off a flip is of twice the period; what a branch has joined there is not. */
    saltus_trace_give(
        t, here,
        (saltus_notice){.origin = start->unknowns && !is_small(start) ? start->origin : SALTUS_POINT_REGULAR,
                        .joins = start->place == 0,
                        .accuracy = NAN});
    t->trail->regular = 1;
    for (int k = 0; k < options->value_count && t->trail->following; k++)
        if (options->values[k] == here->value)
            saltus_trace_give(t, here, (saltus_notice){.kind = SALTUS_POINT_UZ});
    if (start->heading && here->parameter[0] == t->range[side] && t->trail->following)
        saltus_trace_give(t, here,
                          (saltus_notice){.kind = SALTUS_POINT_EP, .reason = t->trail->ends[0][side]});
    t->first_value = here->value;
    saltus_solution_section(&t->orbits, here, here->survey.lap.points, &t->first);
}

saltus_status saltus_trace_start(saltus_trace *t, const saltus_branch_start *start, saltus_message *message) {
    saltus_orbits *o = &t->orbits;
    saltus_message why = {.text = ""};
    const bool small = is_small(start);
    saltus_trail_begin(t->trail, t->starts->begun - 1, start->parent, start->depth, start->unknowns > 0);
    t->returns = -1;
    t->births.count = 0;
    saltus_lap_close(&t->first);
    if (start->origin == SALTUS_POINT_GR) {
        if (saltus_change_pass(o, &start->sequence, start->parameter, start->state, NULL, t->here, t->next))
            saltus_trace_leave_grazing(t);
        else if (saltus_change_bars(o, t->here, t->next))
            t->trail->following = false;
        else
            give_up(t, start, "the flow follows no such orbit");
        return SALTUS_OK;
    }
    saltus_status status = place_first(t, start, &why);
    if (status == SALTUS_OK)
        status = saltus_solution_survey(o, t->here, &why);
    if (status != SALTUS_OK && start->parent < 0 && !small)
        return saltus_fail(message, status, "no branch begins at this orbit: %.200s", why.text);
    if (status != SALTUS_OK) {
        t->trail->following = false;
        if (small)
            give_up(t, start, why.text);
        return SALTUS_OK;
    }
    if (start->unknowns && !small)
        memcpy(t->here->at.tangent, start->tangent, (size_t)start->unknowns * sizeof *start->tangent);
    else if (!small)
        saltus_solution_head(t->here, start->heading);
    give_first(t, start);
    if (!start->unknowns)
        saltus_solution_reframe(o, true, false, t->here, t->trial, NULL);
    return SALTUS_OK;
}
