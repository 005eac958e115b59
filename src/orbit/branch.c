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
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { values_max = 1000 };

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
    if (o->value_count < 0 || o->value_count > values_max)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d values asked for: at most %d are possible",
                           o->value_count, values_max);
    return SALTUS_OK;
}

saltus_status saltus_branch_add_start(saltus_branch *b, const saltus_branch_start *start,
                                      saltus_message *message) {
    saltus_branch_start *grown = realloc(b->starts, ((size_t)b->start_count + 1) * sizeof *grown),
                        *place = NULL;
    if (grown) {
        b->starts = grown;
        place = &grown[b->start_count];
        *place = *start;
        size_t n = (size_t)b->n, unknowns = (size_t)start->unknowns;
        place->state = calloc(n, sizeof *place->state);
        place->tangent = start->tangent ? calloc(unknowns, sizeof *place->tangent) : NULL;
        if (place->state && (place->tangent || !start->tangent)) {
            memcpy(place->state, start->state, n * sizeof *start->state);
            if (start->tangent)
                memcpy(place->tangent, start->tangent, unknowns * sizeof *start->tangent);
            b->start_count++;
            return SALTUS_OK;
        }
        free(place->state);
        free(place->tangent);
    }
    return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
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
        status = saltus_pursuit_new(&b->spec, &b->direction, b->origin, b->unit, &b->options.orbit,
                                    &b->pursuit, message);
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
    saltus_pursuit_free(b->pursuit);
    saltus_flow_free(b->flow);
    saltus_system_free(b->system);
    saltus_lap_close(&b->lap);
    free(b->state);
    free(b->first);
    free(b);
}

saltus_status saltus_branch_end(saltus_branch *b, const saltus_solution *s, double accuracy,
                                const char *reason, saltus_message *message) {
    b->running = false;
    return saltus_branch_emit(b, s, SALTUS_POINT_EP, accuracy, NULL, reason, message);
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

/* A special point between `here` and `next`; a regular one where the branch may have come back to its begin.
 */
typedef struct find {
    saltus_point_kind kind;
    saltus_test test;
    double target, ahead, accuracy;
} find;

static bool crosses(double a, double c) {
    return isfinite(a) && isfinite(c) && a != 0 && a * c <= 0;
}

/* Locate one; insert in order of arclength. */
static int add_find(saltus_branch *b, find *finds, int count, saltus_point_kind kind, saltus_test test,
                    double target) {
    double far =
        test == SALTUS_TEST_VALUE ? saltus_pursuit_value(b->pursuit, b->next.u) - target : b->next.test[test];
    find f = {.kind = kind, .test = test, .target = target};
    b->target = target;
    b->here.test[SALTUS_TEST_VALUE] = saltus_pursuit_value(b->pursuit, b->here.u) - target;
    if (!crosses(b->here.test[test], far))
        return count;
    double near = b->here.test[test];
    if (far == 0)
        f.ahead = b->next.ahead;
    else if (saltus_branch_locate(b, test, b->next.ahead, far, &f.accuracy))
        f.ahead = b->trial.ahead;
    else if (kind == SALTUS_POINT_BP) /* singular there: found by interpolation later */
        f.ahead = b->next.ahead * near / (near - far);
    else
        return count;
    int k = count;
    for (; k > 0 && finds[k - 1].ahead > f.ahead; k--)
        finds[k] = finds[k - 1];
    finds[k] = f;
    return count + 1;
}

bool saltus_branch_pair_on_circle(const saltus_branch *b, const saltus_solution *s) {
    for (int i = 0; i < b->n; i++)
        if (fabs(s->multipliers[i].log_modulus) < 1e-6 && s->multipliers[i].im != 0)
            return true;
    return false;
}

static saltus_status give_join(saltus_branch *b, const find *f, saltus_message *message) {
    static const char reason[] = "joins the orbits of half the period";
    double value, accuracy = f->accuracy;
    bool sharp = saltus_branch_flip_of_half(b, &value, &accuracy);
    saltus_status status = saltus_branch_survey(b, &b->trial, message);
    if (status == SALTUS_OK)
        status = saltus_branch_emit(b, &b->trial, SALTUS_POINT_PD, accuracy, NULL, reason, message);
    if (status == SALTUS_OK && sharp)
        b->queue[b->queue_count - 1].value[0] = value;
    if (status == SALTUS_OK)
        status = saltus_branch_end(b, &b->trial, NAN, reason, message);
    if (status == SALTUS_OK && sharp)
        b->queue[b->queue_count - 1].value[0] = value;
    return status;
}

/* Whether `trial` is where the branch joins that of half the period. So near to it the equations say little
 * about where; a flip of half the period in this very place tells. */
static bool is_join(saltus_branch *b) {
    double apart = saltus_branch_half_distance(b, &b->trial, false), value, accuracy;
    double here = saltus_pursuit_value(b->pursuit, b->trial.u);
    return apart < 1e-4 || (apart < 2e-2 && saltus_branch_flip_of_half(b, &value, &accuracy) &&
                            fabs(value - here) < 1e-6 * b->unit);
}

/* Whether `trial`, a fold, is where orbits that are not their own mirror images become so: the branch of
 * symmetric orbits. */
static bool is_own_image(saltus_branch *b) {
    bool shift;
    if (!saltus_system_mirror_symmetric(b->system, &shift))
        return false;
    double apart = saltus_branch_half_distance(b, &b->trial, true);
    return apart < 1e-3 && apart < 0.05 * saltus_branch_half_distance(b, &b->here, true);
}

static saltus_status give_image(saltus_branch *b, const find *f, saltus_message *message) {
    static const char reason[] = "joins the orbits that are their own mirror images";
    saltus_status status = saltus_branch_survey(b, &b->trial, message);
    if (status == SALTUS_OK)
        status = saltus_branch_emit(b, &b->trial, SALTUS_POINT_BP, f->accuracy, NULL, reason, message);
    return status == SALTUS_OK ? saltus_branch_end(b, &b->trial, NAN, reason, message) : status;
}

/* The point found becomes `trial` again. */
static bool revisit(saltus_branch *b, find *f) {
    saltus_message ignored;
    if (f->kind == SALTUS_POINT_BP && saltus_branch_crossing(b, f->ahead, &f->accuracy))
        return true;
    return saltus_branch_visit(b, f->ahead, &b->trial, &ignored) == SALTUS_OK;
}

static saltus_status give_find(saltus_branch *b, find *f, saltus_message *message) {
    b->target = f->target;
    if (!revisit(b, f))
        return SALTUS_OK;
    saltus_status status = saltus_branch_survey(b, &b->trial, message);
    if (status != SALTUS_OK)
        return status;
    if (f->kind == SALTUS_POINT_NS && !saltus_branch_pair_on_circle(b, &b->trial))
        return SALTUS_OK;
    if (f->kind == SALTUS_POINT_LP || f->kind == SALTUS_POINT_BP) {
        if (is_join(b))
            return give_join(b, f, message);
        if (is_own_image(b))
            return give_image(b, f, message);
        status = saltus_branch_survey(b, &b->trial, message);
        if (status != SALTUS_OK)
            return status;
    }
    if (b->options.locus && b->options.locus == f->kind)
        return saltus_locus_capture(b, -1, message);
    if (f->kind == SALTUS_POINT_REGULAR && !saltus_branch_is_first(b))
        return status;
    if (f->kind == SALTUS_POINT_REGULAR) {
        /* The other way from the same start leads around the same branch. */
        b->start_next += b->start_next == 1 && b->start_count > 1 && b->starts[1].heading;
        return saltus_branch_end(b, &b->trial, f->accuracy, "the branch is closed: it has come back",
                                 message);
    }
    if (f->kind == SALTUS_POINT_EP)
        return saltus_branch_end(b, &b->trial, f->accuracy, "end of the parameter's range", message);
    status = saltus_branch_emit(b, &b->trial, f->kind, f->accuracy, NULL, NULL, message);
    if (status == SALTUS_OK && (f->kind == SALTUS_POINT_PD || f->kind == SALTUS_POINT_BP))
        status = saltus_branch_switch(b, f->kind, message);
    return status;
}

/* All special points of the step, in order; the end of the range is one. At the begin of a branch that was
 * switched to, the determinants are zero to rounding and tell nothing. */
static saltus_status give_finds(saltus_branch *b, int *given, saltus_message *message) {
    find finds[7 + values_max];
    int count = 0;
    saltus_status status = SALTUS_OK;
    if (!b->fresh) {
        count = add_find(b, finds, count, SALTUS_POINT_LP, SALTUS_TEST_FOLD, 0);
        count = add_find(b, finds, count, SALTUS_POINT_PD, SALTUS_TEST_FLIP, 0);
        count = add_find(b, finds, count, SALTUS_POINT_BP, SALTUS_TEST_BRANCH, 0);
        count = add_find(b, finds, count, SALTUS_POINT_NS, SALTUS_TEST_PAIR, 0);
    }
    count = add_find(b, finds, count, SALTUS_POINT_EP, SALTUS_TEST_VALUE, b->options.low[0]);
    count = add_find(b, finds, count, SALTUS_POINT_EP, SALTUS_TEST_VALUE, b->options.high[0]);
    if (b->first_count && b->points > 10)
        count = add_find(b, finds, count, SALTUS_POINT_REGULAR, SALTUS_TEST_VALUE, b->first_value);
    for (int k = 0; k < b->options.value_count; k++)
        count = add_find(b, finds, count, SALTUS_POINT_UZ, SALTUS_TEST_VALUE, b->options.values[k]);
    for (int k = 0; k < count && status == SALTUS_OK && b->running; k++)
        status = give_find(b, &finds[k], message);
    *given = count;
    return status;
}

void saltus_solution_swap(saltus_solution *a, saltus_solution *c) {
    saltus_solution swap = *a;
    *a = *c;
    *c = swap;
}

void saltus_branch_remember(saltus_branch *b) {
    saltus_lap_label(&b->lap, b->last_label);
    b->last_impacts = saltus_lap_impacts(&b->lap);
    b->last_sticks = saltus_lap_sticking(&b->lap);
}

/* Special points do not count, unless there is no end of them. */
static bool has_enough(const saltus_branch *b) {
    return b->points >= b->options.points || b->made >= 3 * b->options.points;
}

saltus_status saltus_branch_accept(saltus_branch *b, saltus_message *message) {
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
    saltus_status status = saltus_pursuit_evaluate(b->pursuit, b->here.u, message);
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
        status = give_finds(b, &given, message);
    if (status != SALTUS_OK || !b->running)
        return status;
    adapt_step(b);
    if (breached) {
        saltus_solution_swap(&b->next, &b->trial);
        return saltus_branch_change(b, accuracy, message);
    }
    if (given)
        status = saltus_branch_survey(b, &b->next, message);
    bool completes = b->last_label[0] && saltus_lap_impacts(&b->lap) < 0 && b->last_impacts >= 0;
    if (status == SALTUS_OK)
        status = settle_label(b, message);
    if (status == SALTUS_OK)
        status = saltus_branch_accept(b, message);
    return status == SALTUS_OK && completes && b->running ? saltus_branch_retrace(b, message) : status;
}

saltus_status saltus_branch_finish_change(saltus_branch *b, saltus_message *message) {
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
        status = give_finds(b, &given, message);
    if (status != SALTUS_OK || !b->running)
        return status;
    if (given)
        status = saltus_branch_survey(b, &b->next, message);
    return status == SALTUS_OK ? saltus_branch_accept(b, message) : status;
}

static saltus_status begin(saltus_branch *b, const saltus_branch_start *start, saltus_message *message) {
    return start->locus ? saltus_locus_begin(b, start, message) : saltus_branch_begin(b, start, message);
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
