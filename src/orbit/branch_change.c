/* Changes of the sequence of events along a branch.
 *
 * Where an impact's speed falls to zero the impact is taken out; where a free maximum touches a stop one is
 * put in: the orbit is the same on both sides of the change, and its new tangent follows from the new
 * equations. Of the two ways along it those are admissible on which the event-driven flow follows the new
 * sequence; often it is one, and it may lead back in the parameter (a non-smooth fold). Where chatter
 * completes, or a contact ends or splits, the sequences on the two sides share no unknowns: the orbit beyond
 * is sought by shooting with the flow's own events, a little further on in the parameter.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REASON_MAX = 40 };

/* Breaches this near to zero change together, as they do on orbits that are their own mirror images. */
static const double together = 1e-7;

static void remove_mark(saltus_sequence *s, double *tangent, int n, int k) {
    for (int j = k; j + 1 < s->count; j++)
        s->mark[j] = s->mark[j + 1];
    for (int j = n + k; j < n + s->count; j++)
        tangent[j] = tangent[j + 1];
    s->count--;
}

static void insert_mark(saltus_sequence *s, double *tangent, int n, const saltus_breach *breach) {
    int k = s->count;
    for (int j = n + s->count + 1; j > n + s->count; j--)
        tangent[j] = tangent[j - 1];
    for (; k > 0 && s->mark[k - 1].time > breach->time; k--) {
        s->mark[k] = s->mark[k - 1];
        tangent[n + k] = tangent[n + k - 1];
    }
    s->mark[k] = (saltus_mark){SALTUS_IMPACT, breach->face, breach->time, false};
    tangent[n + k] = 0;
    s->count++;
}

/* A maximum at a mark is that mark's own touch. */
static bool is_own_touch(const saltus_sequence *s, const saltus_breach *breach) {
    for (int k = 0; k < s->count; k++)
        if (s->mark[k].face == breach->face && fabs(s->mark[k].time - breach->time) < 1e-5)
            return true;
    return false;
}

/* The sequence beyond grazing; `tangent` (room for all marks) is carried over. */
static void regraze(const saltus_breach *breaches, int count, int n, saltus_sequence *s, double *tangent,
                    char *reason) {
    int born = 0, dead = 0;
    const saltus_sequence before = *s;
    for (int k = count - 1; k >= 0; k--)
        if (breaches[k].kind == SALTUS_BREACH_SPEED && fabs(breaches[k].value) < together) {
            remove_mark(s, tangent, n, breaches[k].mark);
            dead++;
        }
    for (int k = 0; k < count; k++)
        if (breaches[k].kind == SALTUS_BREACH_GAP && fabs(breaches[k].value) < together &&
            !is_own_touch(&before, &breaches[k]) && s->count < SALTUS_MARKS_MAX) {
            insert_mark(s, tangent, n, &breaches[k]);
            born++;
        }
    snprintf(reason, REASON_MAX, "%s",
             born && dead ? "impacts are born and die"
             : born > 1   ? "impacts are born"
             : born       ? "an impact is born"
             : dead > 1   ? "impacts die"
                          : "an impact dies");
}

/* Whether the flow follows the new sequence a little way along the tangent; then `next` is a point there. */
static bool leads_on(saltus_branch *b, double ahead) {
    saltus_message ignored;
    b->reference[0] = b->reference[1] = NAN;
    return saltus_branch_visit(b, ahead, &b->next, &ignored) == SALTUS_OK &&
           b->next.test[SALTUS_TEST_BREACH] < 0 && saltus_branch_survey(b, &b->next, &ignored) == SALTUS_OK &&
           b->next.follows;
}

bool saltus_branch_go_on(saltus_branch *b, const double *old) {
    static const double ahead[] = {1e-4, 1e-3, 1e-5, 1e-2};
    double sense = 0;
    for (int j = 0; j < b->here.unknowns; j++)
        sense += old[j] * b->here.tangent[j];
    saltus_solution_point(&b->here, sense);
    for (size_t k = 0; k < sizeof ahead / sizeof ahead[0]; k++)
        for (int way = 0; way < 2; way++) {
            if (leads_on(b, ahead[k]))
                return true;
            saltus_solution_point(&b->here, -1);
        }
    return false;
}

static void complete_label(saltus_branch *b, size_t index, const char *reason, bool back) {
    saltus_branch_point *point = &b->queue[index];
    saltus_lap_label(&b->lap, point->label_after);
    snprintf(point->reason, sizeof point->reason, "%s%s", reason,
             back ? "; the branch turns back (non-smooth fold)" : "");
}

/* The first point of a curve of grazing: the sequence that has the impact without speed, old or new. */
static saltus_status capture_grazing(saltus_branch *b, const saltus_sequence *before,
                                     const saltus_sequence *after, double value, saltus_message *message) {
    const saltus_sequence *more = before->count > after->count ? before : after;
    const saltus_sequence *less = more == before ? after : before;
    int mark = 0;
    while (mark < less->count && more->mark[mark].time == less->mark[mark].time)
        mark++;
    saltus_status status = saltus_branch_place(b, more, value, b->state, false, message);
    if (status != SALTUS_OK)
        return status;
    saltus_solution_swap(&b->here, &b->trial);
    return saltus_branch_capture(b, mark, message);
}

saltus_status saltus_branch_change(saltus_branch *b, double accuracy, bool *goes_on,
                                   saltus_message *message) {
    *goes_on = false;
    saltus_sequence sequence, before;
    char reason[REASON_MAX];
    int count;
    saltus_breach_kind kind = b->trial.worst.kind;
    double value = saltus_shooting_value(b->shooting, b->trial.u);
    double old_heading = b->trial.tangent[b->trial.unknowns - 1];
    if (kind == SALTUS_BREACH_HOLD || kind == SALTUS_BREACH_FORCE)
        return saltus_branch_leap(b, b->trial.ahead, "the contact changes", message);
    bool joins = saltus_branch_half_distance(b, &b->trial, false) < 1e-4;
    saltus_status status = saltus_branch_walk(b, &b->trial, message);
    if (status == SALTUS_OK)
        status = saltus_branch_emit(b, &b->trial, SALTUS_POINT_GR, accuracy, NULL, NULL, message);
    if (status == SALTUS_OK && joins)
        return saltus_branch_end(b, &b->trial, NAN, "joins the orbits of half the period at their grazing",
                                 message);
    if (status == SALTUS_OK)
        status = saltus_shooting_evaluate(b->shooting, b->trial.u, message);
    double *old = calloc((size_t)b->trial.unknowns + SALTUS_MARKS_MAX, sizeof *old);
    if (status == SALTUS_OK && !old)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    if (status != SALTUS_OK) {
        free(old);
        return status;
    }
    memcpy(old, b->trial.tangent, (size_t)b->trial.unknowns * sizeof *old);
    saltus_shooting_extract(b->shooting, b->trial.u, &sequence, b->state);
    before = sequence;
    const saltus_breach *breaches = saltus_shooting_breaches(b->shooting, &count);
    regraze(breaches, count, sequence.cuts * b->n, &sequence, old, reason);
    if (b->options.locus == SALTUS_POINT_GR) {
        free(old);
        return capture_grazing(b, &before, &sequence, value, message);
    }
    bool more = sequence.count > before.count;
    status = saltus_branch_switch_grazing(b, more ? &sequence : &before, more ? &before : &sequence, value,
                                          b->state, message);
    size_t index = (size_t)b->queue_count - 1;
    b->arclength += b->trial.ahead;
    saltus_message why = {""};
    if (status == SALTUS_OK)
        status = saltus_branch_place(b, &sequence, value, b->state, false, &why);
    bool on = status == SALTUS_OK && saltus_branch_go_on(b, old);
    free(old);
    if (!on) {
        snprintf(b->queue[index].reason, SALTUS_REASON_MAX, "%s", reason);
        b->trial.ahead = 0;
        status = saltus_shooting_shape(b->shooting, &before, message);
        if (status != SALTUS_OK)
            return status;
        saltus_branch_survey(b, &b->trial, &why);
        return saltus_branch_end(b, &b->trial, NAN,
                                 "grazing: no orbit of this period goes on with other events", message);
    }
    complete_label(b, index, reason, old_heading * b->here.tangent[b->here.unknowns - 1] < 0);
    b->step = fmax(b->next.ahead, 0.25 * b->step);
    *goes_on = true;
    return SALTUS_OK;
}

/* Whether the walk has as much chatter and sticking as the last point given out. */
static bool keeps_contacts(const saltus_branch *b) {
    return (saltus_lap_impacts(&b->lap) < 0) == (b->last_impacts < 0) &&
           saltus_lap_sticking(&b->lap) == b->last_sticks;
}

/* The last point before `ahead` that the flow follows, as `trial`, with the contacts of the last point given
 * out if that is asked for; the width of the bracket. */
static double bracket_change(saltus_branch *b, double ahead, bool same_contacts) {
    enum { halvings = 50 };
    double low = 0, high = ahead;
    saltus_message ignored;
    for (int k = 0; k < halvings && fabs(high - low) > 1e-12; k++) {
        double middle = 0.5 * (low + high);
        bool sound = saltus_branch_visit(b, middle, &b->trial, &ignored) == SALTUS_OK &&
                     !(b->trial.test[SALTUS_TEST_BREACH] > 0) &&
                     saltus_branch_walk(b, &b->trial, &ignored) == SALTUS_OK && b->trial.follows &&
                     (!same_contacts || keeps_contacts(b));
        *(sound ? &low : &high) = middle;
    }
    if (saltus_branch_visit(b, low, &b->trial, &ignored) != SALTUS_OK)
        return NAN;
    saltus_branch_survey(b, &b->trial, &ignored);
    return fabs(high - low);
}

/* Shooting with the flow's own events at a parameter a little beyond; the new sequence and state at its base.
 */
static bool shoot_beyond(saltus_branch *b, double value, const double *state, const saltus_sequence *old,
                         saltus_sequence *fresh) {
    saltus_sequence driven = {.periods = old->periods, .base = old->base, .driven = true, .cuts = 1};
    saltus_message ignored;
    driven.cut[0] = old->base;
    driven.contacts = old->contacts;
    if (saltus_branch_place(b, &driven, value, state, true, &ignored) != SALTUS_OK)
        return false;
    if (saltus_branch_survey(b, &b->here, &ignored) != SALTUS_OK || !b->here.follows)
        return false;
    memcpy(b->state, b->lap.points, (size_t)b->n * sizeof *b->state);
    saltus_status status = saltus_sequence_make(b->flow, old->periods, b->state, &b->lap, fresh, &ignored);
    return saltus_branch_noted(b, status) == SALTUS_OK;
}

/* What changes between two labels and numbers of sticking intervals. */
static saltus_point_kind kind_of_change(const saltus_branch_point *before, const saltus_lap *after) {
    if ((before->impacts < 0) != (saltus_lap_impacts(after) < 0))
        return SALTUS_POINT_CH;
    return before->sticking_intervals != saltus_lap_sticking(after) ? SALTUS_POINT_ST : SALTUS_POINT_GR;
}

/* `here` is a new beginning beyond a change. */
static saltus_status resettle(saltus_branch *b, double heading, saltus_message *message) {
    saltus_solution_point(&b->here, heading * b->here.tangent[b->here.unknowns - 1]);
    b->reference[0] = b->reference[1] = NAN;
    saltus_status status = saltus_branch_test(b, &b->here, message);
    if (status == SALTUS_OK)
        status = saltus_branch_survey(b, &b->here, message);
    if (status == SALTUS_OK)
        status = saltus_branch_emit(b, &b->here, SALTUS_POINT_REGULAR, NAN, NULL, NULL, message);
    saltus_branch_remember(b);
    b->shown = b->arclength;
    b->points++;
    b->step = fmin(b->step, b->options.step);
    return status;
}

/* A leap over a difficulty of the continuation that is no change of events. */
static bool same_events(const saltus_branch_point *before, const saltus_lap *after) {
    return before->impacts == saltus_lap_impacts(after) &&
           before->sticking_intervals == saltus_lap_sticking(after);
}

/* On the side where chatter is complete its end is the place where the contact after it vanishes: sharper
 * than what the flow, with its tolerance, takes for complete. */
static void sharpen_chatter(saltus_branch *b, size_t index) {
    const double back = 1e-3;
    double width = bracket_change(b, -back, false);
    double value = isnan(width) ? NAN : saltus_shooting_value(b->shooting, b->trial.u);
    if (b->trial.ahead > -0.9 * back && fabs(value - b->queue[index].value[0]) < 1e-4 * b->unit) {
        b->queue[index].value[0] = value;
        b->queue[index].accuracy = width * fabs(b->trial.tangent[b->trial.unknowns - 1]) * b->unit;
    }
}

saltus_status saltus_branch_retrace(saltus_branch *b, saltus_message *message) {
    saltus_sequence old, fresh;
    saltus_message why = {""};
    double heading = b->here.tangent[b->here.unknowns - 1],
           value = saltus_shooting_value(b->shooting, b->here.u);
    saltus_shooting_extract(b->shooting, b->here.u, &old, b->state);
    saltus_status status = saltus_branch_walk(b, &b->here, message);
    if (status != SALTUS_OK)
        return status;
    memcpy(b->state, b->lap.points, (size_t)b->n * sizeof *b->state);
    status = saltus_sequence_make(b->flow, old.periods, b->state, &b->lap, &fresh, &why);
    if (status == SALTUS_OK)
        status = saltus_branch_place(b, &fresh, value, b->state, true, &why);
    if (status == SALTUS_OK)
        saltus_solution_point(&b->here, heading * b->here.tangent[b->here.unknowns - 1]);
    for (int k = b->queue_count - 1; k >= b->queue_next && status == SALTUS_OK; k--)
        if (b->queue[k].kind == SALTUS_POINT_CH) {
            sharpen_chatter(b, (size_t)k);
            break;
        }
    return status == SALTUS_OK || status == SALTUS_NO_MEMORY
               ? status
               : saltus_fail(message, SALTUS_NO_CONVERGENCE, "%s", why.text);
}

saltus_status saltus_branch_relabel(saltus_branch *b, saltus_message *message) {
    bool chatter = (saltus_lap_impacts(&b->lap) < 0) != (b->last_impacts < 0);
    char after[SALTUS_LABEL_MAX];
    saltus_lap_label(&b->lap, after);
    double width = bracket_change(b, b->next.ahead, true);
    if (isnan(width))
        return SALTUS_OK;
    double slope = fabs(b->trial.tangent[b->trial.unknowns - 1]) * b->unit;
    return saltus_branch_emit(b, &b->trial, chatter ? SALTUS_POINT_CH : SALTUS_POINT_ST, width * slope, after,
                              chatter ? "chatter completes or ceases to" : "a contact begins or ends",
                              message);
}

saltus_status saltus_branch_leap(saltus_branch *b, double ahead, const char *why, saltus_message *message) {
    static const double reach[] = {1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2};
    saltus_sequence old, fresh;
    double width = bracket_change(b, ahead, false);
    if (isnan(width)) {
        saltus_branch_survey(b, &b->here, message);
        return saltus_branch_end(b, &b->here, NAN, why, message);
    }
    int m = b->trial.unknowns;
    double heading = b->trial.tangent[m - 1], value = saltus_shooting_value(b->shooting, b->trial.u);
    double *base = calloc(3 * (size_t)b->n, sizeof *base), *rate = base ? base + b->n : NULL;
    double *guess = base ? base + 2 * b->n : NULL;
    if (!base)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    saltus_shooting_extract(b->shooting, b->trial.u, &old, base);
    for (int i = 0; i < b->n; i++)
        rate[i] = b->trial.tangent[i] * saltus_shooting_scale(b->shooting)[i] / heading;
    saltus_status status = saltus_branch_emit(b, &b->trial, SALTUS_POINT_GR, width * fabs(heading) * b->unit,
                                              NULL, why, message);
    size_t index = (size_t)b->queue_count - 1;
    bool found = false, nothing = false;
    for (size_t k = 0; k < sizeof reach / sizeof reach[0] && !found && status == SALTUS_OK; k++) {
        double distance = copysign(reach[k], heading), at = value + distance * b->unit;
        if (at < b->options.low[0] || at > b->options.high[0])
            break;
        for (int i = 0; i < b->n; i++)
            guess[i] = fma(distance, rate[i], base[i]);
        found = shoot_beyond(b, at, guess, &old, &fresh);
        if (found) {
            b->queue[index].kind = kind_of_change(&b->queue[index], &b->lap);
            complete_label(b, index, why, false);
            nothing = same_events(&b->queue[index], &b->lap);
            saltus_message ignored;
            found = saltus_branch_place(b, &fresh, at, b->state, true, &ignored) == SALTUS_OK;
            b->arclength += b->trial.ahead + reach[k];
        }
    }
    free(base);
    if (status != SALTUS_OK)
        return status;
    if (found && nothing)
        saltus_branch_point_clear(&b->queue[--b->queue_count]);
    if (found)
        return resettle(b, heading, message);
    b->queue[index].kind = SALTUS_POINT_EP;
    snprintf(b->queue[index].reason, SALTUS_REASON_MAX, "%s; beyond it no orbit of this period was found",
             why);
    b->running = false;
    return SALTUS_OK;
}
