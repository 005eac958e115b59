/* Continuation of periodic orbits.
 *
 * Pseudo-arclength steps (Keller, 1977) on the equations of a prescribed sequence of events: predict along
 * the tangent, correct on the hyperplane across it, adapt the step to Newton's effort and to the turn of the
 * tangent. After each step the tests of branch_private.h are compared with those before; every zero is
 * located and given out in its place. A breach, an impact of no speed, a free maximum on a stop, a contact
 * force of zero, ends the sequence: see branch_change.c. The event-driven flow has the last word on every
 * point.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include "orbit/multipliers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double step_min = 1e-7, turn_min = 0.92; /* least cosine between tangents a step apart */

saltus_branch_options saltus_branch_defaults(void) {
    return (saltus_branch_options){
        .orbit = saltus_orbit_defaults(), .step = 0.005, .step_max = 0.02, .points = 2000};
}

static saltus_status check_options(const saltus_branch_options *o, double value, saltus_message *message) {
    if (!(o->low[0] < o->high[0]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must go from low to high",
                           o->key[0], o->low[0], o->high[0]);
    if (!isfinite(o->high[0] - o->low[0]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must be finite", o->key[0],
                           o->low[0], o->high[0]);
    if (!(value >= o->low[0] && value <= o->high[0]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must hold the start, %s = %.12g",
                           o->key[0], o->low[0], o->high[0], o->key[0], value);
    if (!(o->step > 0 && o->step <= o->step_max && o->step_max <= 1))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "step = %g, step_max = %g: must be greater than 0, at most 1, and in this order",
                           o->step, o->step_max);
    if (o->points < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "points = %d: must be at least 1", o->points);
    if (o->value_count < 0 || o->value_count > SALTUS_BRANCH_VALUES_MAX)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d values asked for: at most %d are possible",
                           o->value_count, SALTUS_BRANCH_VALUES_MAX);
    return SALTUS_OK;
}

static saltus_status open_parts(saltus_branch *b, saltus_message *message) {
    saltus_status status = saltus_system_new(&b->spec, &b->system, message);
    if (status != SALTUS_OK)
        return status;
    b->n = saltus_system_dimension(b->system);
    b->state = calloc((size_t)b->n, sizeof *b->state);
    b->lap.keeps_events = true;
    if (!b->state || !saltus_lap_reserve(&b->lap, 1, b->n))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    status = saltus_flow_single(b->system, 0, &b->options.orbit.flow, &b->flow, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_new(&b->spec, &b->direction, b->origin, b->unit, &b->options.orbit,
                                     &b->shooting, message);
    return status;
}

/* The given state is made an orbit, and its sequence the start of both ways. */
static saltus_status open_starts(saltus_branch *b, int periods, const double *state,
                                 saltus_message *message) {
    saltus_orbit orbit = {0};
    saltus_orbit_options options = b->options.orbit;
    options.phase = 0;
    options.flow.stop = b->stop;
    saltus_branch_start start = {.value = b->origin, .state = b->state, .parent = -1};
    saltus_status status = saltus_orbit_find(b->system, periods, state, &options, &orbit, message);
    if (status == SALTUS_OK) {
        memcpy(b->state, orbit.state, (size_t)b->n * sizeof *b->state);
        status = saltus_sequence_make(b->flow, periods, b->state, &b->lap, &start.sequence, message);
    }
    for (int heading = 1; heading >= -1 && status == SALTUS_OK; heading -= 2)
        if (b->options.direction * heading >= 0) {
            start.heading = heading;
            status = saltus_branch_add_start(b, &start, message);
        }
    saltus_orbit_clear(&orbit);
    return status;
}

saltus_status saltus_branch_new(const saltus_spec *spec, int periods, const double *state,
                                const saltus_branch_options *options, saltus_branch **branch,
                                saltus_message *message) {
    *branch = NULL;
    saltus_branch *b = calloc(1, sizeof *b);
    if (!b)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    b->spec = *spec;
    b->options = *options;
    b->stop = options->orbit.flow.stop;
    b->options.orbit.flow.stop = NULL;
    b->unit = options->high[0] - options->low[0];
    saltus_status status = saltus_spec_direction(spec, options->key[0], &b->direction, &b->origin, message);
    if (status == SALTUS_OK)
        status = check_options(options, b->origin, message);
    if (status == SALTUS_OK && options->locus)
        status = saltus_locus_open(b, message);
    if (status == SALTUS_OK)
        status = open_parts(b, message);
    if (status == SALTUS_OK)
        status = open_starts(b, periods, state, message);
    if (status != SALTUS_OK) {
        saltus_branch_free(b);
        return status;
    }
    *branch = b;
    return status;
}

void saltus_branch_free(saltus_branch *b) {
    if (!b)
        return;
    for (int k = 0; k < b->start_count; k++) {
        free(b->starts[k].state);
        free(b->starts[k].tangent);
    }
    for (int k = b->queue_next; k < b->queue_count; k++)
        saltus_branch_point_clear(&b->queue[k]);
    saltus_branch_point_clear(&b->given);
    free(b->starts);
    free(b->queue);
    saltus_solution_clear(&b->here);
    saltus_solution_clear(&b->next);
    saltus_solution_clear(&b->trial);
    saltus_locus_close(b);
    saltus_shooting_free(b->shooting);
    saltus_flow_free(b->flow);
    saltus_system_free(b->system);
    saltus_lap_close(&b->lap);
    free(b->state);
    free(b->first);
    free(b);
}

/* Step halved until a point is found with a tangent that has not turned too far. */
static saltus_status take_step(saltus_branch *b, saltus_message *message) {
    for (;;) {
        saltus_status status = saltus_branch_visit(b, b->step, &b->next, message);
        double cosine = 0;
        for (int j = 0; j < b->here.unknowns && status == SALTUS_OK; j++)
            cosine += b->next.tangent[j] * b->here.tangent[j];
        if (status == SALTUS_NO_MEMORY || (status == SALTUS_OK && cosine > turn_min))
            return status;
        if (b->step < step_min)
            return status == SALTUS_OK
                       ? saltus_fail(message, SALTUS_NO_CONVERGENCE, "the branch has a corner")
                       : status;
        b->step *= 0.5;
    }
}

static void adapt_step(saltus_branch *b) {
    if (b->next.iterations <= 3)
        b->step *= 1.5;
    else if (b->next.iterations > 5)
        b->step *= 0.6;
    b->step = fmin(b->step, b->options.step_max);
}

/* Special points do not count, unless there is no end of them. */
static bool has_enough(const saltus_branch *b) {
    return b->points >= b->options.points || b->made >= 3 * b->options.points;
}

/* `next` becomes `here`, and a regular point where it is far enough from the last. */
static saltus_status accept(saltus_branch *b, saltus_message *message) {
    saltus_status status = SALTUS_OK;
    double apart = b->arclength + b->next.ahead - b->shown;
    if (apart >= 0.02 * b->options.step_max || b->points == 0 || b->tail_changed) {
        const char *reason = b->tail_changed ? "impacts in the tail of a long run come or go" : NULL;
        status = saltus_branch_emit(b, &b->next, SALTUS_POINT_REGULAR, NAN, NULL, reason, message);
        b->shown = b->arclength + b->next.ahead;
        b->points++;
    }
    saltus_branch_remember(b);
    b->arclength += b->next.ahead;
    saltus_solution_swap(&b->here, &b->next);
    b->here.ahead = 0;
    b->fresh = b->tail_changed = false;
    if (status == SALTUS_OK && has_enough(b))
        return saltus_branch_end(b, &b->here, NAN, "as many points as asked for", message);
    bool changed;
    return status == SALTUS_OK ? saltus_branch_reframe(b, NULL, &changed, message) : status;
}

/* Evaluate `here` again as the beginning of a step: its determinants relative to themselves. */
static saltus_status begin_step(saltus_branch *b, saltus_message *message) {
    double pair = b->here.test[SALTUS_TEST_PAIR];
    bool follows = b->here.follows;
    b->reference[0] = b->reference[1] = NAN;
    saltus_status status = saltus_shooting_evaluate(b->shooting, b->here.u, message);
    /* Where branches cross the equations leave the tangent open; it is the one that was chosen. */
    if (status == SALTUS_OK && !b->fresh)
        status = saltus_branch_test(b, &b->here, message);
    b->here.test[SALTUS_TEST_BREACH] = fmin(b->here.test[SALTUS_TEST_BREACH], -1e-300);
    b->here.test[SALTUS_TEST_PAIR] = pair;
    b->here.follows = follows;
    return status;
}

/* The step's end, or the place on the way where a breach begins. */
static bool shorten_to_breach(saltus_branch *b, double *accuracy) {
    if (!saltus_branch_locate(b, SALTUS_TEST_BREACH, b->next.ahead, b->next.test[SALTUS_TEST_BREACH],
                              accuracy))
        return false;
    saltus_solution_swap(&b->next, &b->trial);
    return true;
}

/* Contacts that begin or end where the sequence is left to the flow are located; of the many impacts in the
 * tail of a long run, which come and go all the time, only the number is told. */
static saltus_status settle_label(saltus_branch *b, saltus_message *message) {
    char label[SALTUS_LABEL_MAX];
    bool chatter = (saltus_lap_impacts(&b->lap) < 0) != (b->last_impacts < 0);
    saltus_lap_label(&b->lap, label);
    b->tail_changed = b->last_label[0] && strcmp(b->last_label, label) != 0;
    if (!b->last_label[0] || (!chatter && saltus_lap_sticking(&b->lap) == b->last_sticks))
        return SALTUS_OK;
    saltus_status status = saltus_branch_relabel(b, message);
    return status == SALTUS_OK ? saltus_branch_survey(b, &b->next, message) : status;
}

/* At grazing itself the flow meets the impact or not by chance: the multipliers are those just before. */
static saltus_status survey_before(saltus_branch *b, saltus_message *message) {
    const double back = 1e-7;
    saltus_message ignored;
    saltus_status status = SALTUS_OK;
    if (b->next.ahead > 10 * back &&
        saltus_branch_visit(b, b->next.ahead - back, &b->trial, &ignored) == SALTUS_OK) {
        status = saltus_branch_survey(b, &b->trial, message);
        memcpy(b->next.multipliers, b->trial.multipliers, (size_t)b->n * sizeof *b->trial.multipliers);
        b->next.test[SALTUS_TEST_PAIR] = b->trial.test[SALTUS_TEST_PAIR];
        b->next.unstable = b->trial.unstable;
        b->next.log_volume = b->trial.log_volume;
        b->next.sum_rule = b->trial.sum_rule;
        return status;
    }
    return saltus_branch_survey(b, &b->next, message);
}

/* The short way from a change of events at `here` to `next`, special points on it included. */
static saltus_status finish_change(saltus_branch *b, saltus_message *message) {
    double ahead = b->next.ahead;
    int given;
    b->here.test[SALTUS_TEST_PAIR] = NAN;
    saltus_message why = {""};
    saltus_status status = begin_step(b, &why);
    b->here.test[SALTUS_TEST_PAIR] = NAN;
    if (status == SALTUS_OK)
        status = saltus_branch_visit(b, ahead, &b->next, &why);
    if (status == SALTUS_OK)
        status = saltus_branch_survey(b, &b->next, message);
    else
        return saltus_branch_end(b, &b->here, NAN, why.text, message);
    if (status == SALTUS_OK)
        status = saltus_branch_special_points(b, &given, message);
    if (status != SALTUS_OK || !b->running)
        return status;
    if (given)
        status = saltus_branch_survey(b, &b->next, message);
    return status == SALTUS_OK ? accept(b, message) : status;
}

static saltus_status advance(saltus_branch *b, saltus_message *message) {
    saltus_message why = {""};
    double accuracy = NAN;
    int given = 0;
    if (has_enough(b))
        return saltus_branch_end(b, &b->here, NAN, "as many points as asked for", message);
    saltus_status status = begin_step(b, &why);
    if (status == SALTUS_OK)
        status = take_step(b, &why);
    if (status == SALTUS_NO_MEMORY)
        return saltus_fail(message, status, "%s", why.text);
    if (status != SALTUS_OK)
        return saltus_branch_leap(b, 2 * b->step, why.text, message);
    bool breached = b->next.test[SALTUS_TEST_BREACH] > 0;
    if (breached && !shorten_to_breach(b, &accuracy))
        return saltus_branch_leap(b, b->next.ahead, "events change", message);
    status = breached ? survey_before(b, message) : saltus_branch_survey(b, &b->next, message);
    bool lost = status == SALTUS_OK && !breached && !b->next.follows;
    if (lost)
        return saltus_branch_leap(b, b->next.ahead, "events change", message);
    if (status == SALTUS_OK)
        status = saltus_branch_special_points(b, &given, message);
    if (status != SALTUS_OK || !b->running)
        return status;
    adapt_step(b);
    if (breached) {
        bool goes_on;
        saltus_solution_swap(&b->next, &b->trial);
        status = saltus_branch_change(b, accuracy, &goes_on, message);
        return status == SALTUS_OK && goes_on ? finish_change(b, message) : status;
    }
    if (given)
        status = saltus_branch_survey(b, &b->next, message);
    bool completes = b->last_label[0] && saltus_lap_impacts(&b->lap) < 0 && b->last_impacts >= 0;
    if (status == SALTUS_OK)
        status = settle_label(b, message);
    if (status == SALTUS_OK)
        status = accept(b, message);
    return status == SALTUS_OK && completes && b->running ? saltus_branch_retrace(b, message) : status;
}

/* Keep the section points of the orbit just walked as those of the branch's first. */
static saltus_status keep_first(saltus_branch *b, double value, saltus_message *message) {
    int n = b->n, periods = b->lap.periods;
    saltus_event event;
    double *grown = realloc(b->first, (size_t)(n * periods) * sizeof *grown);
    if (!grown)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    b->first = grown;
    b->first_count = 1;
    b->first_value = value;
    memcpy(grown, b->lap.points, (size_t)n * sizeof *grown);
    saltus_message ignored;
    saltus_status status = saltus_flow_start(b->flow, 0, (saltus_time){0, 0}, grown, &ignored);
    for (int k = 1; k < periods && status == SALTUS_OK; k++) {
        status = saltus_flow_advance(b->flow, (saltus_time){k, 0}, 0, &event, &ignored);
        saltus_flow_state(b->flow, 0, grown + k * n);
        b->first_count += status == SALTUS_OK;
    }
    return SALTUS_OK;
}

/* Begin at a start; where there is no orbit, the branch has no point. */
static saltus_status begin_branch(saltus_branch *b, const saltus_branch_start *start,
                                  saltus_message *message) {
    b->number = b->start_next - 1;
    b->parent = start->parent;
    b->depth = start->depth;
    b->points = b->made = b->first_count = 0;
    b->arclength = b->shown = 0;
    b->step = b->options.step;
    b->fresh = start->tangent != NULL;
    b->running = true;
    saltus_message why = {""};
    saltus_status status = saltus_branch_place(b, &start->sequence, start->value, start->state,
                                               !start->tangent && !start->grazes, &why);
    if (status == SALTUS_OK && start->grazes) {
        b->running = saltus_branch_go_on(b, b->here.tangent);
        b->last_label[0] = 0;
        return b->running ? accept(b, message) : SALTUS_OK;
    }
    if (status == SALTUS_OK && start->tangent)
        memcpy(b->here.tangent, start->tangent, (size_t)start->unknowns * sizeof *start->tangent);
    else if (status == SALTUS_OK)
        saltus_solution_point(&b->here, b->here.tangent[b->here.unknowns - 1] * start->heading);
    if (status != SALTUS_OK) {
        b->running = false;
        return status == SALTUS_NO_MEMORY ? saltus_fail(message, status, "%s", why.text) : SALTUS_OK;
    }
    b->reference[0] = b->reference[1] = NAN;
    for (int k = 0; k < SALTUS_TESTS; k++)
        b->here.test[k] = -1;
    if (start->tangent == NULL)
        status = saltus_branch_test(b, &b->here, message);
    bool changed;
    if (status == SALTUS_OK)
        status = saltus_branch_survey(b, &b->here, message);
    if (status == SALTUS_OK)
        status = saltus_branch_emit(b, &b->here, SALTUS_POINT_REGULAR, NAN, NULL, NULL, message);
    for (int k = 0; k < b->options.value_count && status == SALTUS_OK; k++)
        if (b->options.values[k] == start->value)
            status = saltus_branch_emit(b, &b->here, SALTUS_POINT_UZ, 0, NULL, NULL, message);
    if (status == SALTUS_OK)
        status = keep_first(b, start->value, message);
    if (status == SALTUS_OK && !start->tangent)
        status = saltus_branch_reframe(b, NULL, &changed, message);
    b->points = 1;
    saltus_branch_remember(b);
    double bound = start->heading > 0 ? b->options.high[0] : b->options.low[0];
    if (status == SALTUS_OK && start->heading && start->value == bound)
        return saltus_branch_end(b, &b->here, 0, "end of the parameter's range", message);
    return status;
}

static saltus_status begin(saltus_branch *b, const saltus_branch_start *start, saltus_message *message) {
    return start->locus ? saltus_locus_begin(b, start, message) : begin_branch(b, start, message);
}

saltus_status saltus_branch_step(saltus_branch *b, const saltus_branch_point **point,
                                 saltus_message *message) {
    saltus_status status = SALTUS_OK;
    *point = NULL;
    saltus_branch_point_clear(&b->given);
    while (status == SALTUS_OK && b->queue_next == b->queue_count) {
        if (b->stop && *b->stop)
            return saltus_fail(message, SALTUS_INTERRUPTED, "interrupted");
        b->queue_next = b->queue_count = 0;
        if (b->running)
            status = b->locus.on ? saltus_locus_advance(b, message) : advance(b, message);
        else if (b->start_next < b->start_count)
            status = begin(b, &b->starts[b->start_next++], message);
        else if (b->options.locus && !b->locus.on)
            return saltus_fail(message, SALTUS_NO_CONVERGENCE, "no %s point was found along %s = %g to %g",
                               saltus_point_word(b->options.locus), b->options.key[0], b->options.low[0],
                               b->options.high[0]);
        else
            return SALTUS_OK;
        if (b->starved)
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
        /* While the first point of a locus is sought, the points on the way are not wanted. */
        if (b->options.locus && !b->locus.on)
            saltus_branch_drop_queue(b);
    }
    if (status != SALTUS_OK)
        return status;
    b->given = b->queue[b->queue_next++];
    *point = &b->given;
    return status;
}

/* `here` becomes the orbit of a point, heading as it did. */
static saltus_status restore(saltus_branch *b, const saltus_branch_point *point, saltus_message *message) {
    saltus_sequence sequence;
    memcpy(b->state, point->state, (size_t)b->n * sizeof *b->state);
    saltus_status status = saltus_branch_tune(b, point->value[0], message);
    if (status == SALTUS_OK)
        status = saltus_sequence_make(b->flow, point->periods, b->state, &b->lap, &sequence, message);
    if (status == SALTUS_OK)
        status = saltus_branch_place(b, &sequence, point->value[0], b->state, true, message);
    if (status != SALTUS_OK)
        return status;
    saltus_solution_point(&b->here, b->here.tangent[b->here.unknowns - 1] * point->heading);
    b->number = point->branch;
    b->parent = point->parent;
    b->arclength = b->shown = point->arclength;
    b->points = point->step + 1;
    b->step = b->options.step;
    b->fresh = false;
    b->reference[0] = b->reference[1] = NAN;
    return status;
}

static bool same_run(const saltus_branch *b, const saltus_branch_point *points, int count) {
    enum { periods_max = 100000 };
    for (int k = 0; k < count; k++) {
        const saltus_branch_point *p = &points[k];
        bool sound = p->dimension == b->n && p->spec.model == b->spec.model && p->state &&
                     p->kind >= SALTUS_POINT_REGULAR && p->kind < SALTUS_POINT_KINDS && p->branch >= 0 &&
                     p->branch < b->start_count + count && p->step >= 0 && p->periods >= 1 &&
                     p->periods <= periods_max && isfinite(p->value[0]) && isfinite(p->arclength) &&
                     isfinite(p->heading);
        for (int i = 0; i < b->n && sound; i++)
            sound = isfinite(p->state[i]);
        if (!sound)
            return false;
    }
    return count > 0;
}

saltus_status saltus_branch_resume(saltus_branch *b, const saltus_branch_point *points, int count, int *kept,
                                   saltus_message *message) {
    *kept = 0;
    if (!same_run(b, points, count))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "the points to resume from are unsound or belong to another run");
    if (b->options.locus || b->options.switches)
        return SALTUS_OK;
    int last = count - 1;
    while (last >= 0 && points[last].kind != SALTUS_POINT_REGULAR && points[last].kind != SALTUS_POINT_EP)
        last--;
    saltus_status status = SALTUS_OK;
    *kept = last + 1;
    if (last < 0)
        return status;
    if (points[last].branch >= b->start_count)
        return saltus_fail(message, SALTUS_BAD_INPUT, "the points to resume from belong to another run");
    b->start_next = points[last].branch + 1;
    if (points[last].kind == SALTUS_POINT_EP)
        return status;
    status = restore(b, &points[last], message);
    if (status == SALTUS_OK)
        status = saltus_branch_test(b, &b->here, message);
    if (status == SALTUS_OK)
        status = saltus_branch_survey(b, &b->here, message);
    saltus_branch_remember(b);
    b->running = status == SALTUS_OK;
    return status;
}
