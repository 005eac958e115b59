/* How branches of periodic orbits begin.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/boundary.h"
#include "branch/hopf.h"
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
    if (status == SALTUS_OK && cycle)
        status = saltus_orbits_tune(o, at_start, orbit.omega, message);
    if (status == SALTUS_OK)
        status =
            saltus_sequence_make(o->flow, orbit.periods, cycle, start.state, &lap, &start.sequence, message);
    saltus_system_free(clocked);
    for (int heading = 1; heading >= -1 && status == SALTUS_OK; heading -= 2)
        if (t->trail->options->direction * heading >= 0) {
            start.heading = heading;
            status = saltus_starts_add(t->starts, o->n, &start, message);
        }
    saltus_orbit_clear(&orbit);
    saltus_lap_close(&lap);
    return status;
}

/* Where no branch can be begun at a start that was switched to, one point says why. */
static saltus_status give_up(saltus_trace *t, const saltus_branch_start *start, const char *why,
                             saltus_message *message) {
    saltus_message ignored;
    t->trail->following = false;
    saltus_status status = saltus_solution_place(&t->orbits, &start->sequence, &start->parameter,
                                                 start->state, false, t->here, &ignored);
    if (status == SALTUS_OK)
        status = saltus_solution_survey(&t->orbits, t->here, &ignored);
    if (!start->origin || status != SALTUS_OK)
        return status == SALTUS_NO_MEMORY ? saltus_branch_no_memory(message) : SALTUS_OK;
    char reason[SALTUS_REASON_MAX];
    snprintf(reason, sizeof reason, "nothing was found to follow from this %s: %.100s",
             saltus_point_word(start->origin), why);
    return saltus_trace_end(t, t->here, 0, reason, message);
}

/* The first point of a branch: regular, with what was asked for at its value. */
static saltus_status give_first(saltus_trace *t, const saltus_branch_start *start, saltus_message *message) {
    saltus_status status = saltus_trace_give(t, t->here, (saltus_notice){.accuracy = NAN}, message);
    t->trail->regular = 1;
    for (int k = 0; k < t->trail->options->value_count && status == SALTUS_OK && t->trail->following; k++)
        if (t->trail->options->values[k] == t->here->value)
            status = saltus_trace_give(t, t->here, (saltus_notice){.kind = SALTUS_POINT_UZ}, message);
    double bound = start->heading > 0 ? t->range[1] : t->range[0];
    if (status == SALTUS_OK && start->heading && t->here->parameter[0] == bound && t->trail->following)
        status = saltus_trace_give(
            t, t->here, (saltus_notice){.kind = SALTUS_POINT_EP, .reason = saltus_range_ends}, message);
    return status;
}

/* Keep the section points of `here` as those of the branch's first orbit. */
static saltus_status keep_first(saltus_trace *t, saltus_message *message) {
    saltus_message ignored;
    saltus_lap_close(&t->first);
    t->first_value = t->here->value;
    saltus_status status =
        saltus_orbits_tune(&t->orbits, t->here->parameter, t->here->sequence.omega, message);
    if (status != SALTUS_OK)
        return status;
    saltus_status around = t->here->sequence.omega > 0
                               ? saltus_cycle_around(&t->orbits, t->here, &t->first, &ignored)
                               : saltus_lap_around(&t->first, t->orbits.flow, t->here->survey.lap.points,
                                                   t->here->sequence.periods, &ignored);
    return around == SALTUS_NO_MEMORY ? saltus_branch_no_memory(message) : SALTUS_OK;
}

/* `out` becomes a small cycle on the branch that begins at an equilibrium. */
static saltus_status place_small(saltus_orbits *o, const saltus_branch_start *start, saltus_solution *out,
                                 saltus_message *message) {
    static const double apart[2][4] = {{1e-3, 1e-4, 1e-2, 1e-5}, {1e-2, 3e-3, 3e-2, 1e-3}};
    const bool hopf = start->origin == SALTUS_POINT_HB;
    saltus_status status = SALTUS_NO_CONVERGENCE;
    for (int k = 0; k < 4 && status != SALTUS_OK && status != SALTUS_NO_MEMORY; k++)
        status = saltus_orbits_noted(o, hopf ? saltus_hopf_cycle(o, start, apart[1][k], out, message)
                                             : saltus_boundary_cycle(o, start, apart[0][k], out, message));
    return status;
}

/* `here` becomes the orbit that a branch begins at. The first of all is cut into more and more segments where
 * Newton's method fails: between prescribed impacts rounding may grow far more than along the motion, on
 * which impacts come earlier or later. */
static saltus_status place_first(saltus_trace *t, const saltus_branch_start *start, saltus_message *why) {
    saltus_orbits *o = &t->orbits;
    saltus_sequence sequence = start->sequence;
    int order[SALTUS_MARKS_MAX];
    saltus_status status =
        saltus_solution_place(o, &sequence, &start->parameter, start->state, !start->tangent, t->here, why);
    for (int cuts = 2;
         start->parent < 0 && cuts <= SALTUS_CUTS_MAX && status != SALTUS_OK && status != SALTUS_NO_MEMORY;
         cuts *= 2) {
        saltus_sequence_turn(&start->sequence, start->sequence.base, cuts, &sequence, order);
        status = saltus_solution_place(o, &sequence, &start->parameter, start->state, true, t->here, why);
    }
    return status;
}

saltus_status saltus_trace_start(saltus_trace *t, const saltus_branch_start *start, saltus_message *message) {
    saltus_orbits *o = &t->orbits;
    saltus_message why = {.text = ""};
    int order[SALTUS_MARKS_MAX];
    saltus_trail_begin(t->trail, t->starts->begun - 1, start->parent, start->depth, start->tangent != NULL);
    t->returns = -1;
    t->births.count = 0;
    saltus_lap_close(&t->first);
    if (start->origin == SALTUS_POINT_HB || start->origin == SALTUS_POINT_BE) {
        saltus_status found = place_small(o, start, t->here, &why);
        if (found == SALTUS_OK)
            found = saltus_solution_survey(o, t->here, &why);
        if (found == SALTUS_OK)
            found = give_first(t, start, message);
        if (found == SALTUS_OK)
            return keep_first(t, message);
        return found == SALTUS_NO_MEMORY ? saltus_branch_no_memory(message)
                                         : give_up(t, start, why.text, message);
    }
    if (start->grazes) {
        bool found =
            saltus_change_pass(o, &start->sequence, &start->parameter, start->state, NULL, t->here, t->next);
        if (found)
            return saltus_trace_accept(t, true, false, NULL, message);
        return give_up(t, start, "the flow follows no such orbit", message);
    }
    saltus_status status = place_first(t, start, &why);
    if (status == SALTUS_OK)
        status = saltus_solution_survey(o, t->here, &why);
    if (status == SALTUS_NO_MEMORY)
        return saltus_branch_no_memory(message);
    if (status != SALTUS_OK && start->parent < 0)
        return saltus_fail(message, status, "no branch begins at this orbit: %.200s", why.text);
    if (status != SALTUS_OK) {
        t->trail->following = false;
        return SALTUS_OK;
    }
    if (start->tangent)
        memcpy(t->here->at.tangent, start->tangent, (size_t)start->unknowns * sizeof *start->tangent);
    else
        saltus_solution_head(t->here, start->heading);
    status = give_first(t, start, message);
    if (status == SALTUS_OK)
        status = keep_first(t, message);
    if (status == SALTUS_OK && !start->tangent)
        saltus_solution_reframe(o, true, false, t->here, t->trial, order);
    return status;
}
