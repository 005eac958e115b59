/* Continuation of periodic orbits.
 *
 * Pseudo-arclength steps (curve.h) on the equations of a prescribed sequence of events (solution.h). Test
 * functions are compared at both ends of a step; each zero is located and given out (special.h). A breach (an
 * impact of zero speed, a free maximum on a stop, a contact force of zero) ends the sequence: the branch
 * continues with another one (change.h). The event-driven flow has the last word on every point.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/born.h"
#include "branch/ending.h"
#include "branch/sequence.h"
#include "branch/trace.h"
#include "orbit/lap.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* End the branch at a solution on a border of the range, with the exact value of the border. */
static void end_at_border(saltus_trace *t, saltus_solution *s, double ahead) {
    const bool upper = s->parameter[0] == t->range[1];
    s->value = upper ? t->trail->options->high[0] : t->trail->options->low[0];
    saltus_trace_end(t, s, ahead, t->trail->ends[0][upper]);
}

/* Whether a solution is so close to a border of the range that rounding hides the others up to there, as
 * where a stop leaves no room and all motion ends, or where impacts hardly rebound. */
static bool is_by_border(const saltus_trace *t, const saltus_solution *s) {
    const double close = 1e-8;
    return fmin(fabs(s->parameter[0] - t->range[0]), fabs(s->parameter[0] - t->range[1])) < close;
}

/* End the branch at such a solution, with the exact value of the border. */
static bool end_by_border(saltus_trace *t, saltus_solution *s) {
    const bool upper = s->parameter[0] > 0.5 * (t->range[0] + t->range[1]);
    const bool ends = is_by_border(t, s);
    if (ends) {
        s->value = upper ? t->trail->options->high[0] : t->trail->options->low[0];
        saltus_trace_end(t, s, s->at.ahead, t->trail->ends[0][upper]);
    }
    return ends;
}

/* Keep the branches that leave at `at` for later. */
static void add_starts(saltus_trace *t, const saltus_solution *at, saltus_point_kind kind,
                       const saltus_sequence *beyond) {
    saltus_trail *trail = t->trail;
    const saltus_branch_start like = saltus_trail_leaving(trail);
    saltus_message why = {.text = ""};
    if (!saltus_trail_switches(trail))
        return;
    const saltus_status status = saltus_starts_leave(&t->orbits, at, kind, beyond, &like, t->starts, &why);
    if (saltus_orbits_noted(&t->orbits, status) != SALTUS_OK)
        snprintf(saltus_trail_last(trail)->reason, SALTUS_REASON_MAX,
                 "not switched to what leaves here: %.120s", why.text);
}

/* The requested locus begins at `at`; no more of this branch is needed. `beyond` as for its start. */
static void find(saltus_trace *t, const saltus_solution *at, const saltus_sequence *beyond) {
    saltus_locus_starts_begin(&t->orbits, t->trail->options->locus, at, beyond, t->found);
    t->trail->following = false;
}

/* At the parameter value of the branch's first orbit: if `s` is that orbit, the branch is closed and ends. */
static void give_return(saltus_trace *t, const saltus_solution *s, saltus_notice what) {
    if (!saltus_trace_same_orbit(t, s, &t->first))
        return;
    /* The other direction from the same start leads around the same branch. */
    if (t->starts->begun == 1 && t->starts->count > 0 && t->starts->start[0].heading) {
        saltus_branch_start other = saltus_starts_take(t->starts);
        saltus_branch_start_clear(&other);
    }
    what.kind = SALTUS_POINT_EP;
    what.reason = "the branch is closed: it has come back";
    saltus_trace_give(t, s, what);
}

/* At a pitchfork the parameter turns back exactly where the other branch crosses. Of a fold and a branch
 * point that cannot be told apart only the branch point is given out: the equations are singular there, so
 * that so close to it orbits may be found on either branch. */
static bool is_pitchfork(const saltus_branch_point *last, const saltus_special *special, double arclength) {
    const double singular = 1e-5;
    return ((last->kind == SALTUS_POINT_LP && special->kind == SALTUS_POINT_BP) ||
            (last->kind == SALTUS_POINT_BP && special->kind == SALTUS_POINT_LP)) &&
           isfinite(last->accuracy + special->accuracy) &&
           (fabs(last->value[0] - special->value) <= last->accuracy + special->accuracy ||
            fabs(last->arclength - arclength) < singular);
}

/* Where a branch leaves another one its parameter may turn, too: a fold so close to there that it cannot be
 * told from it. So may be the branch point itself. */
static bool is_start(const saltus_trace *t, const saltus_special *special) {
    const double close = 1e-3, same = 1e-7, along = t->trail->arclength + special->ahead;
    return t->trail->parent >= 0 && ((special->kind == SALTUS_POINT_LP && along < close &&
                                      fabs(special->value - t->first_value) <= special->accuracy) ||
                                     (special->kind == SALTUS_POINT_BP && along < same && t->trail->fresh));
}

/* An end that another branch may share: give it out as the special point that it is, and then as the end. */
static void give_shared_end(saltus_trace *t, const saltus_solution *at, saltus_notice what) {
    char reason[SALTUS_REASON_MAX];
    if (what.kind == SALTUS_POINT_PD || what.kind == SALTUS_POINT_BP)
        saltus_trace_follow_joined(t, at, what.kind, *what.value);
    saltus_trace_give(t, at, what);
    if (!t->trail->following)
        return;
    saltus_trace_drop_starts(t);
    if (what.kind == SALTUS_POINT_HB) {
        saltus_cycle_tell_shrinking(&t->orbits, at, reason);
        what.reason = reason;
    }
    what.kind = SALTUS_POINT_EP;
    saltus_trace_give(t, at, what);
}

/* `trial` becomes the orbit at a special point of the step from `here` to `next`. False if it is none. Where
 * cycles shrink to an equilibrium it is the Hopf point; if that was not found, the end says only that they
 * shrink. */
static bool visit_special(saltus_trace *t, const saltus_hopf_ahead *hopf, saltus_special *special) {
    saltus_orbits *o = &t->orbits;
    bool is_one = hopf && hopf->is_one;
    if (special->kind != SALTUS_POINT_HB) {
        is_one = !special->lost && saltus_special_visit(o, t->here, t->next->at.ahead, special, t->trial);
    } else if (is_one) {
        SALTUS_SWAP(t->trial, t->other);
        const bool found = hopf->shrunk.found && saltus_cycle_shrink(o, &hopf->shrunk, t->trial);
        special->kind = found ? SALTUS_POINT_HB : SALTUS_POINT_EP;
        special->value = t->trial->value;
        special->accuracy = found ? o->family.unit[0] * hopf->shrunk.accuracy : NAN;
    }
    return is_one && saltus_cycle_folds(o, t->here, special, t->trial);
}

/* Give out a point where other branches leave, and keep these for later; `beyond`: the sequence beyond
 * grazing (NULL: there none are sought). Where a branch that has been followed joins this one, there are no
 * others; if it has led on along this one, the branch ends. */
static void give_branching(saltus_trace *t, const saltus_solution *at, saltus_notice what,
                           const saltus_sequence *beyond) {
    char reason[SALTUS_REASON_MAX];
    int other = -1;
    const double value = what.value ? *what.value : at->value;
    const bool branches =
        what.kind == SALTUS_POINT_PD || what.kind == SALTUS_POINT_BP || what.kind == SALTUS_POINT_GR;
    const bool known = (branches || what.kind == SALTUS_POINT_CH) &&
                       saltus_trace_was_joined(t, at, what.kind, value, &other);
    if (known && other >= 0) {
        snprintf(reason, sizeof reason, "this %s is on branch %d", saltus_point_word(what.kind), other);
        what.kind = SALTUS_POINT_EP;
        what.reason = reason;
        what.addition = NULL;
    }
    saltus_trace_give(t, at, what);
    if (branches && !known && (what.kind != SALTUS_POINT_GR || beyond))
        add_starts(t, at, what.kind, beyond);
}

/* Give out one special point of the step from `here` to `next`. */
static void give_special(saltus_trace *t, const saltus_hopf_ahead *hopf, saltus_special *special) {
    const bool is_one = visit_special(t, hopf, special);
    /* Where nothing is lost at the end of the range, as where r = 1, pairs come to the circle but do not
     * cross it: rounding decides on which side they are. */
    const double place = t->trial->parameter[0];
    const bool at_border = fmin(fabs(place - t->range[0]), fabs(place - t->range[1])) < saltus_at_border;
    if (!is_one || (special->kind == SALTUS_POINT_NS && at_border) || is_start(t, special))
        return;
    if (t->trail->options->locus && t->trail->options->locus == special->kind &&
        (!special->end || special->kind == SALTUS_POINT_HB)) {
        find(t, t->trial, NULL);
        return;
    }
    const saltus_notice what = {.kind = special->kind,
                                .ahead = special->ahead,
                                .accuracy = special->accuracy,
                                .reason = special->end,
                                .joins = special->end != NULL,
                                .value = &special->value};
    saltus_branch_point *last = saltus_trail_last(t->trail);
    if (last && is_pitchfork(last, special, t->trail->arclength + special->ahead)) {
        if (special->kind == SALTUS_POINT_LP)
            return;
        saltus_trail_drop_last(t->trail);
    }
    if (special->kind == SALTUS_POINT_REGULAR)
        give_return(t, t->trial, what);
    else if (special->end)
        give_shared_end(t, t->trial, what);
    else
        give_branching(t, t->trial, what, NULL);
}

/* How close the multipliers come to the unit circle, in the logarithm of their modulus. */
static double off_circle(const saltus_survey *survey) {
    double off = INFINITY;
    for (int k = 0; k < survey->multiplier_count; k++)
        off = fmin(off, fabs(survey->multipliers[k].log_modulus));
    return off;
}

/* A step may leap from one curve to another where these turn sharply beside one another. They then seem to
 * cross, although no orbit there is a branch point. Whether they do, or special points cannot be reached or
 * may be `hidden`, or one that cannot be told from a fold or branch point may lie just beyond the step's end,
 * so that the step is to be repeated with a shorter one, which may tell. */
static bool seek_leap(saltus_trace *t, const saltus_hopf_ahead *hopf, const saltus_special *specials,
                      int count, bool hidden) {
    const double least = 1e-5, short_enough = 1e-3, close = 1e-4, shorter = 0.7, rounding = 1e-7,
                 clear = 1e-4;
    const saltus_special *last = count > 0 ? &specials[count - 1] : NULL;
    const bool at_end = last && (last->kind == SALTUS_POINT_LP || last->kind == SALTUS_POINT_BP) &&
                        t->next->at.ahead - last->ahead < close;
    /* Nor does a row belong where rounding decides on which side of the circle a multiplier is. */
    const bool marginal = off_circle(&t->next->survey) < rounding && off_circle(&t->here->survey) > clear;
    for (int k = 0; k < count; k++)
        hidden = hidden || specials[k].lost;
    bool again =
        ((hidden || at_end) && t->next->at.ahead > short_enough) || (marginal && t->next->at.ahead > least);
    for (int k = 0; k < count && !again && t->next->at.ahead > least; k++) {
        saltus_special special = specials[k];
        bool is_one = true;
        if (special.kind == SALTUS_POINT_BP)
            is_one = visit_special(t, hopf, &special);
        else if (special.kind != SALTUS_POINT_HB && !special.lost)
            is_one = saltus_solution_visit(&t->orbits, t->here, special.ahead, t->trial);
        again = !is_one || (special.kind == SALTUS_POINT_BP && !isfinite(special.accuracy));
    }
    if (again)
        t->trail->step = (at_end || marginal ? shorter : 0.5) * t->next->at.ahead;
    return again;
}

/* Tell at `next` that the step has a special point which was not reached, so that it is not passed over. */
static void tell_lost(saltus_trace *t, saltus_point_kind kind) {
    char reason[SALTUS_REASON_MAX];
    const char *key = t->trail->options->key[0];
    snprintf(reason, sizeof reason,
             "between %s = %.12g and %.12g is a %s by its test, but no orbit is found there", key,
             t->here->value, t->next->value, saltus_point_word(kind));
    saltus_trace_give(t, t->next,
                      (saltus_notice){.ahead = t->next->at.ahead, .accuracy = NAN, .reason = reason});
    saltus_trail_shown(t->trail, t->next->at.ahead);
}

/* Give out all special points of the step from `here` to `next` that lie more than `first` ahead, in order;
 * or, if it `may_repeat`, return false: the step is to be repeated instead, with a shorter one. `hopf` may be
 * NULL. */
static bool give_specials(saltus_trace *t, const saltus_hopf_ahead *hopf, double first, bool may_repeat) {
    const saltus_branch_options *options = t->trail->options;
    saltus_special specials[SALTUS_BRANCH_VALUES_MAX + 10];
    saltus_special wanted[SALTUS_BRANCH_VALUES_MAX + 1];
    saltus_point_kind lost = SALTUS_POINT_REGULAR;
    bool hidden;
    int asked = 0;
    for (; asked < options->value_count; asked++)
        wanted[asked] = (saltus_special){
            .kind = SALTUS_POINT_UZ, .test = SALTUS_TEST_VALUE, .target = options->values[asked]};
    if (t->first.points && t->trail->regular > 10)
        wanted[asked++] = (saltus_special){.test = SALTUS_TEST_VALUE, .target = t->first_value};
    const int count = saltus_special_find(&t->orbits, t->here, t->next, t->trail->fresh,
                                          hopf && hopf->found ? &hopf->special : NULL, wanted, asked,
                                          specials, &hidden, t->trial);
    if (may_repeat && seek_leap(t, hopf, specials, count, hidden))
        return false;
    for (int k = 0; k < count && t->trail->following; k++)
        if (specials[k].ahead > first) {
            give_special(t, hopf, &specials[k]);
            lost = specials[k].lost ? specials[k].kind : lost;
        }
    if (lost && t->trail->following)
        tell_lost(t, lost);
    return true;
}

/* The same up to `last`, where `trial` ends the branch or changes its events; `next` becomes the orbit there.
 */
static bool give_specials_before(saltus_trace *t, double first, double last) {
    const double least = 1e-7;
    saltus_orbits *o = &t->orbits;
    saltus_orbits_reshape(o, t->here);
    if (!(last - first > least) || !saltus_solution_visit(o, t->here, last, t->other) ||
        saltus_orbits_noted(o, saltus_solution_survey(o, t->other, NULL)) != SALTUS_OK)
        return true;
    SALTUS_SWAP(t->next, t->other);
    SALTUS_SWAP(t->trial, t->other);
    const bool given = give_specials(t, NULL, first, first == 0) && t->trail->following;
    SALTUS_SWAP(t->trial, t->other);
    return given;
}

/* The notice of a change of events, at this distance and parameter value (NULL: the solution's). */
static saltus_notice notice_of(const saltus_change *change, double ahead, const double *value) {
    return (saltus_notice){.kind = change->kind,
                           .ahead = ahead,
                           .accuracy = change->accuracy,
                           .reason = change->reason,
                           .after = change->after,
                           .value = value,
                           .change = true};
}

/* How far `b` is ahead of `a` along its tangent. */
static double distance_ahead(const saltus_curve_point *a, const saltus_curve_point *b) {
    double ahead = 0;
    for (int j = 0; j < a->unknowns; j++)
        ahead += a->tangent[j] * (b->u[j] - a->u[j]);
    return ahead;
}

/* The branch goes on at `spare`, beyond the change at `trial`: give out the special points on the way back
 * from there to the change, as far as the flow follows that. `same`: both have the same sequence; `distance`:
 * the arclength between. */
static void give_specials_beyond(saltus_trace *t, bool same, double distance) {
    const double least = 1e-5, flat = 1e-3;
    saltus_orbits *o = &t->orbits;
    const saltus_curve_point *before = &t->trial->at;
    const double apart = fabs(t->spare->parameter[0] - t->trial->parameter[0]);
    bool found = false;
    same = same && before->unknowns == t->spare->at.unknowns;
    for (double back = apart / fmax(fabs(saltus_solution_heading(t->spare)), flat); back > least && !found;
         back *= 0.5)
        found = saltus_solution_visit(o, t->spare, -back, t->here) && t->here->worst.value < 0 &&
                !saltus_curve_strays(&t->spare->at, &t->here->at) &&
                !(same && distance_ahead(before, &t->here->at) < 0) &&
                saltus_orbits_noted(o, saltus_solution_survey(o, t->here, NULL)) == SALTUS_OK &&
                t->here->survey.follows;
    if (!found)
        return;
    const double ahead = distance_ahead(&t->here->at, &t->spare->at);
    if (!saltus_solution_visit(o, t->here, ahead, t->next) ||
        saltus_orbits_noted(o, saltus_solution_survey(o, t->next, NULL)) != SALTUS_OK)
        return;
    t->trail->arclength += fmax(ahead - distance, 0) - ahead;
    give_specials(t, NULL, 0, false);
    t->trail->arclength += ahead;
    saltus_survey_follow(&t->spare->survey, &t->here->survey, -ahead);
    saltus_orbits_reshape(o, t->spare);
}

/* Give out the change at `trial`, unless it is REGULAR; `spare`, this far along, becomes `here`, unless that
 * is an orbit of a shorter period. */
static void go_over(saltus_trace *t, saltus_notice what, double distance) {
    char after[SALTUS_LABEL_MAX];
    const double value = what.value ? *what.value : t->trial->value;
    const bool changes = what.kind != SALTUS_POINT_REGULAR;
    const bool joins =
        what.kind == SALTUS_POINT_CH && saltus_trace_joins_part(t, t->trial, t->spare, value, after);
    what.after = joins ? after : what.after;
    if (changes)
        give_branching(t, t->trial, what, NULL);
    if (joins && t->trail->following)
        saltus_trace_end(t, t->trial, what.ahead, "joins orbits of a part of the period");
    if (!t->trail->following)
        return;
    saltus_trail_jump(t->trail, distance);
    t->trail->fresh = false;
    give_specials_beyond(t, !changes, distance - what.ahead);
    if (!t->trail->following)
        return;
    t->spare->at.ahead = 0;
    SALTUS_SWAP(t->here, t->spare);
    saltus_trace_give(t, t->here, (saltus_notice){.accuracy = NAN});
    t->trail->regular++;
}

/* Where births of impacts accumulate, continue the branch beyond them with complete chatter. False if no such
 * orbits were found; `far` as for saltus_change_complete. */
static bool complete_run(saltus_trace *t, bool far) {
    saltus_change change;
    if (!saltus_change_complete(&t->orbits, t->here, &t->births, far, t->range, t->trial, t->spare, t->other,
                                &change))
        return false;
    t->births.count = 0;
    go_over(t, notice_of(&change, 0, NULL), change.distance);
    return true;
}

/* Leap over a change of events that only the event-driven flow sees, somewhere before `ahead`. Special points
 * as far as `first` were given out. */
static void leap(saltus_trace *t, double first, double ahead, saltus_leap kind, const char *why) {
    saltus_change change;
    for (int pass = 0; pass < 2; pass++) {
        saltus_change_leap(&t->orbits, t->here, ahead, kind, why, t->range, t->trial, t->spare, t->other,
                           &change);
        if (pass || change.after[0] || t->births.count < saltus_births_length)
            break;
        /* Rounding may hide the last births before chatter completes. If this fails the leap is repeated,
         * since the attempt has overwritten its result. */
        if (complete_run(t, true))
            return;
    }
    const bool ends = !change.after[0];
    if (!isnan(change.accuracy) && !give_specials_before(t, first, t->trial->at.ahead))
        return;
    if (!ends)
        saltus_orbits_reshape(&t->orbits, t->spare);
    saltus_notice what = notice_of(&change, t->trial->at.ahead, change.value != 0 ? &change.value : NULL);
    if (ends)
        what.addition = "; beyond it no orbit of this period was found";
    if (isnan(change.accuracy))
        saltus_trace_end(t, t->here, 0, why);
    else if (change.at_border)
        end_at_border(t, t->spare, t->trial->at.ahead);
    else if (ends && (kind == SALTUS_LEAP_EVENTS || t->trial->survey.impacts < 0) &&
             end_by_border(t, t->trial))
        return;
    else if (ends)
        give_shared_end(t, t->trial, what);
    else
        go_over(t, what, t->trial->at.ahead + change.distance);
}

/* Whether an orbit grazes at the end of a run of impacts with hardly any speed: chatter almost completes. */
static bool ends_run(const saltus_solution *s) {
    const double slow = 1e-8, near = 1e-3;
    for (int k = 0; k < s->breach_count; k++) {
        const saltus_breach *b = &s->breaches[k];
        if (b->kind == SALTUS_BREACH_SPEED && b->face == s->worst.face && b->value > -slow &&
            b->time < s->worst.time && s->worst.time - b->time < near)
            return true;
    }
    return false;
}

/* Whether the impact that has lost its speed ends a short flight that began with a release: then the flight
 * is about to vanish, and the contacts before and after it to become one. */
static bool ends_flight(const saltus_solution *s) {
    const double near = 1e-3;
    const saltus_sequence *sequence = &s->sequence;
    bool ends = false;
    for (int k = 0; k < sequence->count && s->worst.kind == SALTUS_BREACH_SPEED && !ends; k++) {
        const saltus_mark *mark = &sequence->mark[k];
        const double after = s->worst.time - mark->time;
        ends = mark->kind == SALTUS_RELEASE && mark->face == s->worst.face &&
               after - sequence->periods * floor(after / sequence->periods) < near;
    }
    return ends;
}

void saltus_trace_leave_grazing(saltus_trace *t) {
    saltus_hopf_ahead hopf;
    saltus_cycle_seek_hopf(&t->orbits, t->here, t->next, t->other, t->trial, &hopf);
    give_specials(t, &hopf, 0, false);
    if (t->trail->following)
        saltus_trace_accept(t, true, NULL);
}

/* The branch goes on from the grazing at `next`, in `spare` with the sequence `beyond` it, to `trial`. */
static void go_beyond(saltus_trace *t, const saltus_sequence *beyond) {
    const saltus_solution *at = t->next;
    t->trail->arclength += at->at.ahead;
    saltus_births_note(&t->births, beyond->count > at->sequence.count, at->parameter[0]);
    SALTUS_SWAP(t->here, t->spare);
    SALTUS_SWAP(t->next, t->trial);
    t->trail->step = fmax(t->next->at.ahead, 0.25 * t->trail->step);
    saltus_trace_leave_grazing(t);
    if (t->trail->following && t->births.count == saltus_births_length)
        complete_run(t, false);
}

/* Beyond grazing at `next`, to a point a little further on. */
static void graze(saltus_trace *t, double accuracy) {
    saltus_orbits *o = &t->orbits;
    saltus_solution *at = t->next;
    saltus_sequence beyond;
    saltus_change change;
    saltus_notice what = {
        .kind = SALTUS_POINT_GR, .ahead = at->at.ahead, .accuracy = accuracy, .change = true};
    bool doubled;
    const bool images = saltus_trace_joins_images(t, at);
    const int parts = images ? 1 : saltus_trace_parts(t, at);
    const bool joins = images || parts > 1;
    what.grazing = saltus_trace_touch(at, images ? 2 : parts);
    what.accuracy += saltus_special_doubt(o, SALTUS_TEST_BREACH, at);
    saltus_change_graze(o, t->here, at, &beyond, t->spare, t->trial, &change);
    /* Rounding hides further impacts: leap to where chatter is complete. */
    const bool run = !change.reason || ends_run(at) || t->births.count > 2;
    if (change.kind == SALTUS_POINT_EP && !joins && (run || ends_flight(at))) {
        saltus_orbits_reshape(o, t->here);
        leap(t, at->at.ahead, 2 * at->at.ahead, run ? SALTUS_LEAP_RUN : SALTUS_LEAP_EVENTS,
             run ? "grazings follow one another ever more closely" : "the contact changes");
        return;
    }
    if (t->trail->options->locus == SALTUS_POINT_GR && !images && !saltus_change_in_family(o, at, &doubled)) {
        find(t, at, &beyond);
        return;
    }
    bool goes_on = change.kind == SALTUS_POINT_GR && !joins;
    if (goes_on && saltus_special_halves(o, t->trial)) {
        saltus_trace_end(t, at, at->at.ahead,
                         "rounding hides how the halves of the orbit differ beyond a grazing");
        return;
    }
    what.reason = joins ? NULL : change.reason;
    what.after = goes_on ? change.after : NULL;
    what.addition = goes_on && change.turns_back ? "; the branch turns back (non-smooth fold)" : NULL;
    if (joins) {
        saltus_trace_follow_grazing(t, at, parts);
        saltus_trace_give(t, at, what);
    } else {
        give_branching(t, at, what, &beyond);
    }
    if (!t->trail->following)
        return;
    if (joins)
        saltus_trace_drop_starts(t);
    if (!goes_on) {
        static const char *const joined[] = {
            "joins the orbits of a part of the period at their grazing",
            "joins the orbits that are their own mirror images at their grazing",
            "joins the orbits of half the period at their grazing",
            "joins the orbits of a third of the period at their grazing",
            "joins the orbits of a quarter of the period at their grazing"};
        saltus_trace_end(t, at, at->at.ahead,
                         joins ? joined[parts < 5 ? parts : 0]
                               : "grazing: no orbit of this period goes on with other events");
        return;
    }
    go_beyond(t, &beyond);
}

/* Accept a step without breach. Changes of contacts where the sequence is left to the flow are located; of
 * the many impacts in the tail of a long run, which come and go all the time, only the number is given. */
static void settle(saltus_trace *t) {
    const saltus_survey *before = &t->here->survey, *after = &t->next->survey;
    bool known = before->label[0], same = !known || strcmp(before->label, after->label) == 0;
    bool chatter = known && (before->impacts < 0) != (after->impacts < 0);
    saltus_change change = {.kind = SALTUS_POINT_REGULAR};
    if ((chatter || (known && before->sticking_intervals != after->sticking_intervals)) &&
        (!saltus_change_within(&t->orbits, t->here, t->next, t->trial, &change) || is_by_border(t, t->trial)))
        change.kind = SALTUS_POINT_REGULAR;
    double value = t->trial->value;
    saltus_notice what = notice_of(&change, t->trial->at.ahead, &value);
    bool retraced = chatter && after->impacts < 0 &&
                    saltus_change_retrace(&t->orbits, t->next, t->spare, t->other, &value, &what.accuracy);
    if (retraced) {
        t->spare->at.ahead = t->next->at.ahead;
        SALTUS_SWAP(t->next, t->spare);
    }
    if (change.kind != SALTUS_POINT_REGULAR)
        saltus_trace_give(t, t->trial, what);
    if (t->trail->following)
        saltus_trace_accept(t, !retraced, same ? NULL : "impacts in the tail of a long run come or go");
}

/* The length of a shorter step that ends on an orbit with a breach although `next` has none, as on a border
 * of the range where impacts do not rebound; found by approaching `next`. 0: there is none. */
static double hidden_breach(saltus_trace *t) {
    enum { halvings = 10 };
    double rest = t->next->at.ahead;
    for (int k = 0; k < halvings; k++) {
        rest *= 0.5;
        if (saltus_solution_visit(&t->orbits, t->here, t->next->at.ahead - rest, t->trial) &&
            t->trial->worst.value > 0 && t->trial->worst.kind == SALTUS_BREACH_GAP)
            return t->next->at.ahead - rest;
    }
    return 0;
}

/* End the branch of cycles at `at` if the period changes while the parameter stands still, as at a homoclinic
 * orbit, or if the branch was `lost` in such a place. */
static bool end_at_saddle(saltus_trace *t, const saltus_solution *at, double ahead, bool lost) {
    char reason[SALTUS_REASON_MAX];
    const bool ends =
        saltus_cycle_tell_saddle(&t->orbits, at, lost, t->trail->options->key[0], t->spare, reason);
    if (ends)
        saltus_trace_end(t, at, ahead, reason);
    return ends;
}

/* Whether a forced orbit along which the parameter stands still is isolated all the same: all its multipliers
 * are inside the unit circle, as after chatter, which ends in the same way whatever came before.
 * Perturbations may grow without bound up to there. */
static bool is_sensitive(const saltus_solution *s) {
    return s->sequence.omega == 0 && s->survey.walked && s->survey.multiplier_count > 0 &&
           s->survey.unstable == 0 && hypot(s->survey.multipliers[0].re, s->survey.multipliers[0].im) < 0.9;
}

/* End the branch on the step to `next` where cycles with impacts shrink to an equilibrium on a stop, where
 * two equilibria are born on the cycles, or where the parameter stands still, in a family of orbits or near a
 * saddle. */
static bool find_end(saltus_trace *t) {
    const double still = 1e-10; /* only rounding is left */
    saltus_orbits *o = &t->orbits;
    saltus_solution *next = t->next;
    char reason[SALTUS_REASON_MAX] = "the orbits of one value of the parameter form a family";
    saltus_zero zero;
    double value;
    if (saltus_boundary_reach(o, t->here, next, t->trial, &zero, &value)) {
        saltus_solution_survey(o, t->trial, NULL);
        if (!give_specials_before(t, 0, 0.999 * zero.ahead))
            return true;
        give_shared_end(t, t->trial,
                        (saltus_notice){.kind = SALTUS_POINT_BE,
                                        .ahead = zero.ahead,
                                        .accuracy = zero.accuracy,
                                        .reason = "the orbit shrinks to an equilibrium on a stop",
                                        .value = &value,
                                        .grazing = &t->trial->breaches[0]});
        return true;
    }
    if (!saltus_cycle_tell_birth(o, t->here, next, t->range, t->trail->options->key[0], reason)) {
        if (!(fabs(saltus_solution_heading(t->here)) < still && fabs(saltus_solution_heading(next)) < still))
            return false;
        if (end_at_saddle(t, next, next->at.ahead, false))
            return true;
        if (!saltus_cycle_of_family(next))
            return false;
        if (is_sensitive(next)) {
            if (end_by_border(t, next))
                return true;
            snprintf(reason, sizeof reason,
                     "rounding hides the parameter, on which the orbit depends %.2g-fold",
                     1 / fabs(saltus_solution_heading(next)));
        }
    }
    saltus_trace_end(t, next, next->at.ahead, reason);
    return true;
}

/* If all impacts of a cycle lose their speed at once, continue with the cycle without impacts. */
static bool fade(saltus_trace *t) {
    saltus_orbits *o = &t->orbits;
    const saltus_zero zero = saltus_cycle_fades(o, t->here, t->next, t->range, t->trial, t->spare, t->other);
    if (!zero.found)
        return false;
    const double heading = saltus_solution_heading(t->here);
    char after[SALTUS_LABEL_MAX];
    saltus_solution_label(o, t->spare, after);
    saltus_notice what = {.kind = SALTUS_POINT_GR,
                          .ahead = fabs((t->trial->parameter[0] - t->here->parameter[0]) / heading),
                          .accuracy = zero.accuracy + saltus_special_doubt(o, SALTUS_TEST_BREACH, t->trial),
                          .reason = "impacts die",
                          .after = after,
                          .change = true,
                          .grazing = &t->trial->worst};
    if (!give_specials_before(t, 0, 0.999 * what.ahead))
        return true;
    saltus_orbits_reshape(o, t->spare);
    t->births.count = 0;
    saltus_solution_head(t->spare, heading);
    saltus_solution_survey(o, t->trial, NULL);
    go_over(t, what, what.ahead + zero.ahead);
    return true;
}

/* Whether the first step of a branch, for which no bend is known yet, has led to another curve of the same
 * events: halved again and again until the curve hardly turns, it does not lead to the same places. */
static bool jumps(saltus_trace *t) {
    const double close = 1e-6, straight = 0.99, least = 1e-5;
    const saltus_curve_point *here = &t->here->at, *far = &t->next->at, *reached = &t->other->at;
    saltus_solution *middle = t->trial, *free = t->spare;
    while (far->ahead > least && saltus_dot(here->tangent, far->tangent, here->unknowns) < straight) {
        double rest = 0, apart = 0;
        if (!saltus_solution_visit(&t->orbits, t->here, 0.5 * far->ahead, middle))
            return true;
        for (int j = 0; j < here->unknowns; j++)
            rest += middle->at.tangent[j] * (far->u[j] - middle->at.u[j]);
        if (!saltus_solution_visit(&t->orbits, middle, rest, t->other))
            return true;
        for (int j = 0; j < here->unknowns; j++)
            apart = hypot(apart, far->u[j] - reached->u[j]);
        if (apart > close * far->ahead)
            return true;
        far = &middle->at;
        SALTUS_SWAP(middle, free);
    }
    return false;
}

/* Whether the step to `next` was too long to see what it passed, and is to be repeated with a shorter one. If
 * it cannot be shorter the branch may end. `hopf` becomes the Hopf point ahead, with its orbit as `other`. */
static bool look_back(saltus_trace *t, saltus_hopf_ahead *hopf) {
    const double least = 1e-5;
    saltus_orbits *o = &t->orbits;
    const bool shorter = t->next->at.ahead > least;
    const bool alike = t->trail->fresh && saltus_special_halves(o, t->next);
    bool again =
        shorter && (alike || saltus_special_strays(o, t->here, t->next) || (t->trail->fresh && jumps(t)));
    if (!again && alike) {
        saltus_trace_end(t, t->here, 0, "rounding hides how the halves of the orbit differ");
        return false;
    }
    if (!again) {
        const bool misses = saltus_cycle_seek_hopf(o, t->here, t->next, t->other, t->trial, hopf);
        if (misses && !shorter && !hopf->found)
            saltus_trace_end(t, t->here, 0, "the curve cannot be told from the equilibria near it");
        again = shorter && misses;
    }
    /* A touch exactly where the orbit is cut open would not be seen. */
    const bool hides = !again && shorter && saltus_solution_base_beyond(o, t->next);
    if (!again && !hides)
        return false;
    t->trail->step = 0.5 * t->next->at.ahead;
    if (hides) {
        saltus_orbits_reshape(o, t->here);
        saltus_solution_reframe(o, false, true, t->here, t->trial, NULL);
    }
    return true;
}

/* If the slowest impact is expected to lose its speed within the step, go there at once: `next` becomes that
 * orbit, unless something else comes first. A step that is repeated with a shorter one must not end there
 * again. */
static bool step_to_grazing(saltus_trace *t, saltus_zero *breach) {
    const double still = 1e-9;
    const saltus_solution *next = t->next;
    const double expected = t->here->grazes_ahead, step = t->trail->step;
    if (!(expected > 0 && expected < step))
        return false;
    *breach = saltus_solution_graze(&t->orbits, t->here, t->next);
    return breach->found && breach->ahead > 0 && breach->ahead < step && next->parameter[0] > t->range[0] &&
           next->parameter[0] < t->range[1] && fabs(next->worst.value) < still &&
           saltus_solution_touch(next)->kind == SALTUS_BREACH_SPEED;
}

/* `next` becomes the first orbit of the step with a breach of zero, if it is found, unless it is that orbit;
 * *reached as in saltus_curve_step. At grazing itself it is chance whether the flow meets the impact, so the
 * survey is that of an orbit just before, the nearest one that the flow follows. */
static saltus_status cut_at_breach(saltus_trace *t, saltus_zero *breach, int *reached,
                                   saltus_message *message) {
    const double least = 1e-7, most = 1e-5;
    saltus_orbits *o = &t->orbits;
    if (!breach->found) {
        *breach = saltus_solution_zero(o, SALTUS_TEST_BREACH, 0, t->here, t->next, t->trial);
        if (!breach->found)
            return SALTUS_OK;
        SALTUS_SWAP(t->next, t->trial);
    }
    *reached = -1;
    for (int k = 0; k < 2; k++)
        if (fabs(t->next->parameter[0] - t->range[k]) < saltus_at_border) {
            t->next->parameter[0] = t->range[k];
            *reached = 0;
        }
    saltus_status status = SALTUS_OK;
    bool surveyed = false;
    for (double back = least; back <= most && status == SALTUS_OK && !(surveyed && t->next->survey.follows);
         back *= 10) {
        if (t->next->at.ahead <= 10 * back ||
            !saltus_solution_visit(o, t->here, t->next->at.ahead - back, t->trial))
            break;
        status = saltus_solution_survey(o, t->trial, message);
        SALTUS_SWAP(t->trial->survey, t->next->survey);
        surveyed = true;
    }
    return surveyed ? status : saltus_solution_survey(o, t->next, message);
}

/* No step could be made, for this reason. If Newton's method was left with a residual that may be rounding,
 * or errors of the flow grow too much along the segments, go on from the same orbit in more of them;
 * otherwise the branch ends here or leaps over a change of events. At the start of a branch that leaves
 * another one the equations are singular, so that only its own segments give the tangent. */
static void go_on_lost(saltus_trace *t, saltus_status reason, const char *why) {
    static const char tail[] =
        "impacts in the tail of a long run come or go, so that the next orbit is not found";
    const double visible = 1e-9;
    saltus_trail *trail = t->trail;
    const saltus_equations *e = t->orbits.equations;
    const double growth = t->here->growth;
    const bool rounds = growth * t->orbits.options.flow.rtol > visible;
    char grows[SALTUS_REASON_MAX];
    snprintf(grows, sizeof grows,
             "errors of the flow grow %.1g-fold along it, so that the next orbit is not found", growth);
    if (reason == SALTUS_NO_CONVERGENCE)
        why = rounds ? grows : saltus_sequence_has_tail(&t->here->sequence) ? tail : why;
    if (reason == SALTUS_NO_CONVERGENCE &&
        (e->size < 1e3 * e->tolerance || (rounds && !(trail->fresh && trail->parent >= 0))) &&
        saltus_solution_refine(&t->orbits, t->here, t->trial, NULL))
        trail->step = trail->options->step;
    else if (!end_at_saddle(t, t->here, 0, true))
        leap(t, 0, 2 * trail->step, SALTUS_LEAP_LOST, why);
}

/* The longest step from a solution. For a cycle the states at all cuts count in the arclength; scale the step
 * so that it is the length of their mean. */
static double longest_step(const saltus_trace *t, const saltus_solution *s) {
    return (s->sequence.omega > 0 ? sqrt(s->sequence.cuts) : 1) * t->trail->options->step_max;
}

/* A step along the curve, to `next`. Newton's effort sets the next step's length; at the greatest length
 * Jacobians are saved instead. Most such points are regular and surveyed, so their cocycle is collected on
 * the way, as it is at all points of small systems, where that costs little. */
static saltus_status step_ahead(saltus_trace *t, const saltus_curve_bound *bound, int *reached,
                                saltus_message *message) {
    saltus_orbits *o = &t->orbits;
    const bool steady = t->trail->step >= longest_step(t, t->here);
    o->equations->hasty = steady;
    const bool collects = o->collects && (steady || !o->equations->measure);
    saltus_shooting_collect(o->shooting, collects ? &o->cocycle : NULL);
    saltus_status status = saltus_curve_step(o->equations, &t->here->at, &t->trail->step, bound, 1,
                                             &t->next->at, reached, message);
    o->equations->hasty = false;
    saltus_shooting_collect(o->shooting, NULL);
    o->cocycle.given = o->cocycle.given && *reached < 0;
    return status;
}

/* Go on from the surveyed orbit of a step to `next`, which is a `breach` that was sought and located, or
 * `breached` is false; `reached` as in saltus_curve_step. */
static void go_on(saltus_trace *t, bool breached, const saltus_zero *breach, int reached,
                  const saltus_hopf_ahead *hopf) {
    static const char changed[] = "events change";
    const saltus_survey *before = &t->here->survey;
    saltus_trail *trail = t->trail;
    const saltus_breach_kind kind = t->next->worst.kind;
    if (breached && !breach->found) {
        leap(t, 0, t->next->at.ahead, SALTUS_LEAP_EVENTS, changed);
        return;
    }
    if (find_end(t))
        return;
    if (!breached && !t->next->survey.follows) {
        const bool free = before->impacts >= 0 && before->sticking_intervals == 0;
        const double hidden = free && reached >= 0 ? hidden_breach(t) : 0;
        if (hidden == 0)
            leap(t, 0, t->next->at.ahead, SALTUS_LEAP_EVENTS, changed);
        else
            trail->step = hidden;
        return;
    }
    if (breached && reached < 0 && (kind == SALTUS_BREACH_HOLD || kind == SALTUS_BREACH_FORCE)) {
        leap(t, 0, t->next->at.ahead, SALTUS_LEAP_EVENTS, "the contact changes");
        return;
    }
    if (!give_specials(t, hopf, 0, true) || !trail->following)
        return;
    trail->step = saltus_curve_next_step(trail->step, t->next->at.iterations, longest_step(t, t->next));
    if (reached >= 0)
        end_at_border(t, t->next, t->next->at.ahead);
    else if (breached)
        graze(t, breach->accuracy);
    else
        settle(t);
}

saltus_status saltus_trace_advance(saltus_trace *t, saltus_message *message) {
    saltus_orbits *o = &t->orbits;
    saltus_trail *trail = t->trail;
    const saltus_curve_bound bound = {o->equations->count, t->range[0], t->range[1]};
    saltus_zero breach = {.accuracy = NAN};
    saltus_message why = {.text = ""};
    saltus_hopf_ahead hopf;
    int reached = -1;
    const bool grazes = step_to_grazing(t, &breach);
    breach.found = grazes;
    saltus_status status = grazes ? SALTUS_OK : step_ahead(t, &bound, &reached, &why);
    if (status == SALTUS_OK && !grazes)
        status = saltus_solution_see(o, t->next, &why);
    if (saltus_orbits_noted(o, status) != SALTUS_OK) {
        go_on_lost(t, status, why.text);
        return SALTUS_OK;
    }
    const bool fades = trail->options->locus == SALTUS_POINT_REGULAR && fade(t);
    if (fades || look_back(t, &hopf) || !trail->following)
        return SALTUS_OK;
    const bool breached = grazes || t->next->worst.value > 0;
    status = breached ? cut_at_breach(t, &breach, &reached, &why) : saltus_solution_survey(o, t->next, &why);
    /* Along a border that the parameter's domain does not contain rounding may lead to it. */
    if (status == SALTUS_BAD_INPUT)
        leap(t, 0, t->next->at.ahead, SALTUS_LEAP_EVENTS, why.text);
    else if (status == SALTUS_OK)
        go_on(t, breached, &breach, reached, &hopf);
    else
        return saltus_fail(message, status, "%s", why.text);
    return SALTUS_OK;
}
