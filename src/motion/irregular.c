/* The verdict on a motion without a period: quasi-periodic, chaotic, a transient, or undecided.
 *
 * Several trajectories on the motion measure its largest exponent together, in runs each as long as all
 * before it. A motion is chaotic if its exponent is positive by three standard errors over the whole run and
 * by two in each half, if no trajectory has come to a regular motion for so long that a transient of less
 * than the required mean lifetime would have ended with 95 % probability, and if no stable orbit lies amid
 * it: a long transient looks chaotic while it lasts. If a contact can wipe out all differences, none may
 * come within twenty times the measured time: after one the motion repeats. The tangent vectors of a
 * trajectory that leaves begin to shrink; the others are followed further, and the times of escape give the
 * lifetime. Where periods take many steps, trajectories are followed for the rest of the required time
 * without tangent vectors, which have to grow at its end. A negative exponent means that the motion is
 * regular and a period will appear. A zero exponent, known well, belongs to a torus if the section points
 * fill closed curves and have a spectrum of lines.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/effort.h"
#include "motion/ensemble.h"
#include "motion/evidence.h"
#include "motion/motion.h"
#include "saltus/series.h"
#include "system/system.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    trajectories = 8,
    spread = 400,      /* periods of the transient; the trajectories start along its second half */
    first_run = 500,   /* samples; each later run doubles the total */
    chunk = 250,       /* samples between checks for trajectories that have left */
    least_long = 1000, /* samples for a torus, and before the lifetime is watched without measuring */
    points_kept = 4096,
    check_periods = 1000, /* within which a trajectory that seems to have left must show its period */
    longest_laminar = 16
};

/* Where a measured period counts as so many, the rest of the lifetime is watched without measuring. */
static const double dear = 1.5;
static const double least_growth = 0.6; /* of the usual, in the mean of all: on a torus vectors hardly grow */
/* e-folding times in which what comes to an orbit is seen to do so, from the motion's extent */
static const double approach = 6;

typedef struct judge {
    const saltus_classify_options *options;
    saltus_ensemble ensemble;
    saltus_motion *motion;
    double *returns, *times; /* without forcing: the first trajectory's returns to the section, their times */
    long long return_count;
    double before;          /* the question's steps before this measurement */
    long long watched;      /* periods of all trajectories beyond those measured */
    double unmeasured;      /* the steps that these took */
    long long points_ahead; /* of the first trajectory's section points, after those measured */
    bool looked_ahead;      /* they have been tried */
    bool searched;          /* stable orbits have been searched for */
    bool unseen;            /* one was found, so slow that no trajectory would be seen to come to it */
    bool nowhere, drifts;   /* a longer run would tell no more, as the exponent drifts */
    bool traceless;         /* nothing but impacts changes volumes */
    bool sticks;            /* a contact that wipes out all differences was met */
    long long escaped[trajectories]; /* samples of each trajectory until it left; 0: it has not */
    /* Sticking may shrink tangent vectors without any escape: after a check in vain a trajectory is not
     * checked again before its samples have doubled. */
    long long next_look[trajectories];
} judge;

static long long points_there(const saltus_ensemble *e) {
    long long samples = e->member[0].samples;
    return samples < e->room ? samples : e->room;
}

static saltus_runs runs_of(const judge *j) {
    const saltus_ensemble *e = &j->ensemble;
    return (saltus_runs){.all = saltus_ensemble_largest(e),
                         .first = saltus_ensemble_part(e, 0, 0.5),
                         .second = saltus_ensemble_part(e, 0.5, 1),
                         .latest = saltus_ensemble_part(e, 0.875, 1).mean,
                         .period = saltus_system_period(e->system),
                         .watched = saltus_ensemble_periods(e) + j->watched,
                         .members = trajectories,
                         .lifetime = j->options->lifetime,
                         .lost = j->sticks || saltus_ensemble_lost(e) >= e->n};
}

/* Store the exponent, the lengths of the run and the rate of impacts. */
static void tell_exponent(judge *j) {
    const saltus_ensemble *e = &j->ensemble;
    saltus_evidence *evidence = &j->motion->evidence;
    saltus_runs runs = runs_of(j);
    long long impacts = 0, sticks = 0;
    bool rebounds = false;
    j->motion->lyapunov = runs.lost ? -INFINITY : runs.all.mean;
    j->motion->lyapunov_error = runs.lost ? 0 : runs.all.standard_error;
    evidence->half[0] = runs.first.mean;
    evidence->half[1] = runs.second.mean;
    evidence->half_errors[0] = runs.first.standard_error;
    evidence->half_errors[1] = runs.second.standard_error;
    for (int m = 0; m < trajectories; m++) {
        const saltus_flow_info now = saltus_flow_information(e->member[m].flow, e->member[m].lane);
        impacts += now.impacts - e->member[m].begin.impacts;
        sticks += now.sticks - e->member[m].begin.sticks;
    }
    for (int f = 0; f < saltus_system_face_count(e->system); f++)
        rebounds |= saltus_system_face(e->system, f).r > 0;
    evidence->periods = saltus_ensemble_periods(e);
    evidence->members = trajectories;
    /* A lasting contact on a face that rebounds follows complete chatter: infinitely many impacts. */
    evidence->impacts_per_period = sticks > 0 && rebounds ? NAN : (double)impacts / (double)evidence->periods;
}

/* How many times a measured period counts in what --measure allows. A short run may take what the usual one
 * does. */
static double dearness(const judge *j) {
    const double total = j->options->flow.effort->total - j->before - j->unmeasured,
                 measure = (double)j->options->measure,
                 most = SALTUS_EFFORT_MEASURED * fmax(measure, (double)saltus_classify_defaults().measure);
    return fmax(1, total / (double)saltus_ensemble_periods(&j->ensemble) * measure / most);
}

/* Whether a member's volumes have been kept since the measurement began: it comes to no orbit. */
static bool keeps_volume(const judge *j, const saltus_member *member) {
    return j->traceless &&
           saltus_flow_information(member->flow, member->lane).log_volume == member->begin.log_volume;
}

/* Periods watched, summed over all trajectories, each until it left. */
static double periods_watched(const judge *j) {
    double samples = 0;
    for (int m = 0; m < trajectories; m++)
        samples += (double)(j->escaped[m] ? j->escaped[m] : j->ensemble.member[m].samples);
    return samples * j->ensemble.member[0].growth.whole + (double)j->watched;
}

/* Measure one more run, and after each chunk find trajectories that have come to a regular motion, among
 * those whose tangent vectors have shrunk while the others' grow. Once one has, stop when half of them have,
 * or when chaos could have been asserted by the time: this suffices for the lifetime. */
static saltus_status run_on(judge *j, long long samples, saltus_outcome *outcome, saltus_message *message) {
    const saltus_classify_options *o = j->options;
    saltus_ensemble *e = &j->ensemble;
    saltus_evidence *evidence = &j->motion->evidence;
    saltus_classify_options check = *o;
    saltus_status status = SALTUS_OK;
    check.transient = check_periods;
    check.progress.show = NULL;
    for (long long done = 0; done < samples && status == SALTUS_OK && *outcome == SALTUS_OUTCOME_OPEN;
         done += chunk) {
        status = saltus_ensemble_run(e, chunk, message);
        if (status == SALTUS_OK)
            saltus_ensemble_record(e, saltus_ensemble_largest(e), evidence->history,
                                   &evidence->history_count);
        const bool some_leave =
            status == SALTUS_OK && (evidence->left || saltus_ensemble_exponent(e, 0, false).mean > 0);
        for (int m = 0; m < trajectories && status == SALTUS_OK && some_leave; m++) {
            const saltus_member *member = &e->member[m];
            saltus_motion regular = {0};
            if (j->escaped[m] || member->samples < j->next_look[m] || !(member->recent <= 0) ||
                keeps_volume(j, member))
                continue;
            j->next_look[m] = 2 * member->samples;
            status = saltus_motion_find_period(e->system, member->state, &check, true, &regular, message);
            if (status == SALTUS_OK && saltus_verdict_settled(regular.verdict)) {
                if (!evidence->left)
                    tell_exponent(j);
                evidence->left++;
                j->escaped[m] = member->samples - chunk / 2;
                snprintf(evidence->left_for, sizeof evidence->left_for, "%s", regular.label);
            }
            saltus_motion_clear(&regular);
        }
        if (evidence->left && (2 * evidence->left >= trajectories ||
                               saltus_lifetime_at_least(periods_watched(j), 0) >= (double)o->lifetime))
            *outcome = SALTUS_OUTCOME_LEFT;
        saltus_progress_show(o->progress, (double)saltus_ensemble_periods(e), (double)o->measure);
    }
    return status;
}

/* Look for a stable orbit amid the motion, once, unless the system conserves volume. */
static saltus_status look_for_orbit(judge *j, saltus_message *message) {
    const saltus_ensemble *e = &j->ensemble;
    saltus_track tracks[trajectories];
    saltus_motion orbit = {0};
    if (j->searched || saltus_system_keeps_volume(e->system))
        return SALTUS_OK;
    j->searched = true;
    for (int m = 0; m < trajectories; m++)
        tracks[m] = (saltus_track){e->points + m * e->room * e->n, e->growths + m * e->room, points_there(e)};
    if (!saltus_system_forced(e->system))
        tracks[0] = (saltus_track){j->returns, j->times, j->return_count};
    saltus_status status =
        saltus_stable_orbit_among(e->system, &e->options->flow, tracks, trajectories, &orbit, message);
    if (status == SALTUS_OK && saltus_verdict_settled(orbit.verdict)) {
        const double slowest = orbit.multipliers[0].log_modulus / orbit.periods;
        j->unseen = -slowest * (double)(j->options->measure / trajectories) < approach;
        snprintf(j->motion->evidence.stable_orbit, sizeof j->motion->evidence.stable_orbit, "%s",
                 orbit.label);
    }
    saltus_motion_clear(&orbit);
    return status;
}

/* Test the section points: the first trajectory's points at phase 0, or without forcing its returns. Without
 * forcing a torus has a second zero exponent besides the one along the flow; a periodic orbit has only that
 * one. */
static saltus_status ask_points(judge *j, saltus_outcome *outcome, saltus_message *message) {
    const saltus_ensemble *e = &j->ensemble;
    const bool forced = saltus_system_forced(e->system);
    const double *points = forced ? e->points : j->returns, *state = e->member[0].state;
    long long count = points_there(e) + j->points_ahead;
    if (!forced) {
        saltus_status status =
            saltus_motion_section_points(e->system, &e->options->flow, state, 2 * points_kept, points_kept,
                                         j->returns, j->times, &j->return_count, message);
        if (status != SALTUS_OK)
            return status;
        count = j->return_count;
        if (count < SALTUS_SERIES_LEAST) {
            *outcome = *outcome == SALTUS_OUTCOME_TORUS ? SALTUS_OUTCOME_OPEN : *outcome;
            return SALTUS_OK;
        }
    }
    saltus_status status = saltus_points_test(e->system, points, count, SALTUS_TESTS_ALL,
                                              &j->motion->evidence, outcome, message);
    if (status != SALTUS_OK || forced || *outcome != SALTUS_OUTCOME_TORUS)
        return status;
    saltus_lyapunov_options how = *e->options;
    saltus_lyapunov lyapunov = {0};
    how.exponents = 2;
    how.periods = saltus_ensemble_periods(e);
    status = saltus_lyapunov_run(e->system, state, &how, &lyapunov, message);
    if (status == SALTUS_OK) {
        saltus_estimate second = {.mean = lyapunov.exponents[1],
                                  .standard_error = lyapunov.standard_errors[1]};
        if (!saltus_exponent_may_be_zero(second, saltus_system_period(e->system)))
            *outcome = SALTUS_OUTCOME_OPEN;
    }
    saltus_lyapunov_clear(&lyapunov);
    return status;
}

/* Note whether a longer run would tell no more. If volumes are kept, nothing attracts and a motion does not
 * settle: in the time left either neighbours would have to come apart, or the section points, of which nearly
 * all are there, would have to fill a curve, or a drift (of the energy of a forced motion without damping)
 * would have to stop. */
static saltus_status leads_nowhere(judge *j, saltus_message *message) {
    static const double likely = 2, drifts = 8; /* errors of an exponent, of a difference of halves */
    static const double near_all = 0.9;
    const saltus_ensemble *e = &j->ensemble;
    const saltus_runs runs = runs_of(j);
    const double fastest = runs.all.mean + likely * runs.all.standard_error,
                 grows = fastest * runs.period * (double)(j->options->measure / trajectories);
    bool kept = true;
    for (int m = 0; m < trajectories; m++)
        kept &= keeps_volume(j, &e->member[m]);
    if (!kept || (double)points_there(e) < near_all * points_kept)
        return SALTUS_OK;
    j->drifts = fabs(runs.first.mean - runs.second.mean) >
                drifts * hypot(runs.first.standard_error, runs.second.standard_error);
    if (!j->drifts && !(grows < SALTUS_APART))
        return SALTUS_OK;
    saltus_outcome outcome = j->drifts ? SALTUS_OUTCOME_OPEN : SALTUS_OUTCOME_TORUS;
    saltus_status status = ask_points(j, &outcome, message);
    j->nowhere = outcome != SALTUS_OUTCOME_TORUS;
    return status;
}

/* If all but the lifetime is shown and periods are dear: the samples that are lacking, if they can be watched
 * without measuring; otherwise 0. */
static long long samples_lacking(const judge *j) {
    const saltus_member *first = &j->ensemble.member[0];
    const long long most = j->options->measure / trajectories,
                    needed = 3 * (long long)j->options->lifetime / (trajectories * first->growth.whole) + 1,
                    lacking = needed - first->samples;
    /* Without a tangent vector a period counts half. */
    const double cost = dearness(j), all = cost * ((double)first->samples + 0.5 * (double)lacking);
    const bool worth = cost >= dear && first->samples >= least_long && lacking >= 2 * chunk;
    return worth && !j->looked_ahead && all <= (double)most ? lacking : 0;
}

/* Follow the trajectories for so many samples without tangent vectors, and measure again only at their end.
 * None comes back from a regular motion, so that none has left if vectors still grow there as before;
 * otherwise the measurement goes on as if it had not been looked at. */
static saltus_status watch_on(judge *j, long long samples, saltus_outcome *outcome, saltus_message *message) {
    const saltus_ensemble *e = &j->ensemble;
    const saltus_member *first = &e->member[0];
    const long long ahead = samples - chunk, fits = e->room - first->samples;
    const double before = j->options->flow.effort->total, period = saltus_system_period(e->system),
                 usual = saltus_ensemble_largest(e).mean * period * (double)(chunk * first->growth.whole);
    double states[trajectories * SALTUS_STATE_MAX];
    double *points = calloc((size_t)(ahead * e->n), sizeof *points);
    saltus_ensemble later = {0};
    bool grow = true;
    j->looked_ahead = true;
    saltus_status status = points ? saltus_ensemble_ahead(e, ahead, states, points, message)
                                  : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for section points");
    if (status == SALTUS_OK)
        status = saltus_ensemble_open(&later, e->system, e->options, 0, message);
    if (status == SALTUS_OK)
        status = saltus_ensemble_begin(&later, states, message);
    if (status == SALTUS_OK)
        status = saltus_ensemble_run(&later, chunk, message);
    double together = 0;
    for (int m = 0; m < later.members; m++) {
        grow &= later.member[m].recent > 0;
        together += later.member[m].recent / trajectories;
    }
    if (status == SALTUS_OK && grow && together > least_growth * usual) {
        j->watched = samples * trajectories * first->growth.whole;
        j->points_ahead = ahead < fits ? ahead : fits;
        memcpy(e->points + first->samples * e->n, points, (size_t)(j->points_ahead * e->n) * sizeof *points);
        *outcome = SALTUS_OUTCOME_CHAOS;
    }
    saltus_ensemble_close(&later);
    free(points);
    j->unmeasured += j->options->flow.effort->total - before;
    return status;
}

/* Decide by the runs so far. If a stable orbit lies amid the chaos, it is a transient that has not ended
 * yet: go on for as long as allowed, to see when it ends, unless that would not be seen. */
static saltus_status decide(judge *j, saltus_outcome *outcome, saltus_message *message) {
    const saltus_evidence *evidence = &j->motion->evidence;
    saltus_ensemble *e = &j->ensemble;
    saltus_runs runs = runs_of(j);
    saltus_status status = SALTUS_OK;
    if (evidence->left)
        return SALTUS_OK;
    *outcome = saltus_runs_weigh(&runs);
    if (*outcome == SALTUS_OUTCOME_TORUS && e->member[0].samples < least_long)
        *outcome = SALTUS_OUTCOME_OPEN;
    const long long lacking = *outcome == SALTUS_OUTCOME_SHORT ? samples_lacking(j) : 0;
    if (lacking)
        status = look_for_orbit(j, message);
    if (status == SALTUS_OK && lacking && !evidence->stable_orbit[0])
        status = watch_on(j, lacking, outcome, message);
    if (status == SALTUS_OK && (*outcome == SALTUS_OUTCOME_TORUS || *outcome == SALTUS_OUTCOME_CHAOS))
        status = ask_points(j, outcome, message);
    if (status == SALTUS_OK && *outcome == SALTUS_OUTCOME_CHAOS)
        status = look_for_orbit(j, message);
    if (status == SALTUS_OK && *outcome == SALTUS_OUTCOME_CHAOS && !evidence->stable_orbit[0]) {
        /* Watch for a contact that wipes out all differences: the motion is then superstable, not chaotic.
         * Without tangent vectors watching is cheap. */
        const double *states[trajectories];
        double after[SALTUS_STATE_MAX];
        for (int m = 0; m < trajectories; m++)
            states[m] = e->member[m].state;
        status = saltus_motion_meets_contact(e->system, &e->options->flow, states, trajectories,
                                             saltus_ensemble_periods(e), after, &j->sticks, message);
        if (status == SALTUS_OK && j->sticks)
            memcpy(e->member[0].state, after, (size_t)e->n * sizeof *after);
    }
    if (j->sticks)
        *outcome = SALTUS_OUTCOME_REGULAR;
    if (*outcome == SALTUS_OUTCOME_SHORT || evidence->stable_orbit[0])
        *outcome = j->unseen ? SALTUS_OUTCOME_LEFT : SALTUS_OUTCOME_OPEN;
    if (*outcome != SALTUS_OUTCOME_CHAOS)
        j->watched = j->points_ahead = 0; /* what is measured from here on covers the same time */
    return status;
}

/* Make runs, each as long as all before it, until there is an outcome or no time is left. */
static saltus_status run_trial(judge *j, saltus_outcome *outcome, saltus_message *message) {
    saltus_ensemble *e = &j->ensemble;
    const saltus_member *first = &e->member[0];
    const saltus_evidence *evidence = &j->motion->evidence;
    long long samples = first_run, most = j->options->measure / trajectories;
    saltus_status status = saltus_ensemble_place(e, j->motion->state, message);
    while (status == SALTUS_OK && *outcome == SALTUS_OUTCOME_OPEN && samples > 0 && !j->nowhere) {
        const long long done = first->samples;
        if (done + samples > most || (done && dearness(j) * (double)(done + samples) > (double)most))
            break;
        status = run_on(j, samples, outcome, message);
        if (status == SALTUS_OK && *outcome == SALTUS_OUTCOME_OPEN)
            status = decide(j, outcome, message);
        if (status == SALTUS_OK && *outcome == SALTUS_OUTCOME_OPEN)
            status = leads_nowhere(j, message);
        samples = first->samples < most - first->samples ? first->samples : most - first->samples;
    }
    if (status != SALTUS_OK || *outcome != SALTUS_OUTCOME_OPEN)
        return status;
    saltus_runs runs = runs_of(j);
    if (evidence->left || evidence->stable_orbit[0])
        *outcome = SALTUS_OUTCOME_LEFT;
    else if (saltus_runs_weigh(&runs) == SALTUS_OUTCOME_SHORT)
        *outcome = SALTUS_OUTCOME_SHORT;
    else if (!j->nowhere && points_there(e) >= SALTUS_SERIES_LEAST)
        /* The tests of the points belong to the evidence even if they decide nothing. */
        status = ask_points(j, outcome, message);
    return status;
}

/* Append to the reason. */
__attribute__((format(printf, 2, 3))) static void say(saltus_motion *motion, const char *format, ...) {
    size_t used = strlen(motion->reason);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(motion->reason + used, sizeof motion->reason - used, format, arguments);
    va_end(arguments);
}

/* Why the motion is undecided, and how long a run would decide: standard errors fall with the square root of
 * the time. */
static void tell_undecided(const judge *j) {
    saltus_motion *m = j->motion;
    const saltus_evidence *e = &m->evidence;
    const double period = saltus_system_period(j->ensemble.system), dear = dearness(j);
    double exponent = m->lyapunov, error = m->lyapunov_error, rate = exponent * period;
    double lacking = SALTUS_SIGNIFICANT * error / fmax(fabs(exponent), 1e-3 / period),
           needed = 1.2 * dear * (double)e->periods * fmax(lacking * lacking, 2);
    if (!isfinite(error)) {
        say(m, "no period was found, and %lld periods are too few for an exponent", e->periods);
        return;
    }
    say(m, "largest exponent %.3g +- %.1g per unit of time over %lld periods", exponent, error, e->periods);
    if (j->drifts)
        say(m, " drifts (halves %.3g and %.3g)", e->half[0], e->half[1]);
    else if (exponent > SALTUS_SIGNIFICANT * error && (double)e->periods * rate >= SALTUS_APART * e->members)
        say(m, ", positive, but not the same in both halves of the run (%.3g and %.3g)", e->half[0],
            e->half[1]);
    else if (exponent > SALTUS_SIGNIFICANT * error) {
        needed = 1.2 * dear * SALTUS_APART * e->members / rate;
        say(m, ", in which neighbours have not come apart: chaos, or an unstable orbit that is left slowly");
    } else
        say(m, " is not told from zero (halves %.3g and %.3g), the section points %s", e->half[0], e->half[1],
            e->curves ? "fill closed curves" : "fill no closed curve");
    if (j->nowhere)
        say(m, "; volumes are kept and nothing attracts: up to %lld periods would tell no more (--measure)",
            j->options->measure);
    else
        say(m, "; measuring some %.1e periods would tell (--measure)", needed);
}

static void tell_transient(saltus_motion *m) {
    const saltus_evidence *e = &m->evidence;
    say(m, "a chaotic transient: exponent %.4g +- %.1g per unit of time while it lasts", m->lyapunov,
        m->lyapunov_error);
    if (e->left)
        say(m,
            "; %d of %d trajectories on it have come to %s, after %.2g periods in the mean (at least %.0f); "
            "a longer --transient would show this one do so",
            e->left, e->members, e->left_for, e->lifetime, e->lifetime_at_least);
    else
        say(m,
            "; a stable %s orbit lies amid it, on which it ends after %.0f periods or more in the mean, or "
            "beside which chaos goes on; a --transient many times as long would show which",
            e->stable_orbit, e->lifetime_at_least);
}

/* Chaos. It is intermittent if it stays near a periodic motion for much longer than neighbours take to
 * separate. */
static void tell_chaos(const judge *j) {
    const saltus_ensemble *ensemble = &j->ensemble;
    const saltus_system *system = ensemble->system;
    const bool forced = saltus_system_forced(system);
    saltus_motion *m = j->motion;
    saltus_evidence *e = &m->evidence;
    const long long without_contact = saltus_contact_watch(system, e->periods);
    double separation = 1 / (m->lyapunov * saltus_system_period(system)), weights[SALTUS_STATE_MAX];
    for (int i = 0; i < ensemble->n; i++)
        weights[i] = 1 / saltus_system_scale(system)[i];
    saltus_series_points points = {forced ? ensemble->points : j->returns, weights,
                                   forced ? points_there(ensemble) : j->return_count, ensemble->n};
    saltus_series_phases phases = saltus_series_laminar_phases(&points, longest_laminar);
    if (!(phases.laminar < 0.05 || (double)phases.longest < 10 * separation)) {
        e->laminar = phases.laminar;
        e->laminar_period = phases.period;
        e->longest_phase = phases.longest;
    }
    say(m,
        "largest exponent %.4g +- %.1g per unit of time over %lld periods, positive in both halves of "
        "the run; none of %d trajectories has come to a period or to rest",
        m->lyapunov, m->lyapunov_error, e->periods, e->members);
    if (j->watched)
        say(m, ", nor in %lld more, at whose end they still separate", j->watched);
    say(m, ": mean lifetime at least %.0f periods (95 %%)", e->lifetime_at_least);
    if (without_contact)
        say(m, "; lasting contacts that would end it come less than once in %.0f periods",
            saltus_lifetime_at_least((double)without_contact, 0));
    if (e->laminar_period)
        say(m,
            "; intermittent: %.0f %% of the time near a motion of period %d T, up to %lld periods at a "
            "stretch",
            100 * e->laminar, e->laminar_period, e->longest_phase);
}

/* Set verdict, reason, exponent and lifetime according to the outcome. */
static void tell(judge *j, saltus_outcome outcome) {
    const saltus_system *system = j->ensemble.system;
    saltus_motion *m = j->motion;
    saltus_evidence *e = &m->evidence;
    if (!e->left)
        tell_exponent(j);
    const double watched = periods_watched(j);
    if (m->lyapunov > SALTUS_SIGNIFICANT * m->lyapunov_error || e->left || e->stable_orbit[0]) {
        e->lifetime_at_least = saltus_lifetime_at_least(watched, e->left);
        e->lifetime = e->left ? watched / e->left : NAN;
    }
    memcpy(m->state, j->ensemble.member[0].state, (size_t)j->ensemble.n * sizeof *m->state);
    m->reason[0] = 0;
    switch (outcome) {
    case SALTUS_OUTCOME_CHAOS:
        m->verdict = SALTUS_CHAOTIC;
        tell_chaos(j);
        break;
    case SALTUS_OUTCOME_TORUS:
        m->verdict = SALTUS_QUASIPERIODIC;
        say(m,
            "largest exponent %.1e +- %.0e per unit of time, next to zero%s; the section points fill %d "
            "closed curve%s, all but %.1e of their variance is in lines",
            m->lyapunov, m->lyapunov_error,
            saltus_system_forced(system) ? "" : ", and so is a second one beside that of time itself",
            e->curves, e->curves == 1 ? "" : "s", e->broadband);
        break;
    case SALTUS_OUTCOME_LEFT:
        tell_transient(m);
        break;
    case SALTUS_OUTCOME_REGULAR:
        if (isinf(m->lyapunov))
            say(m, "nothing irregular: every perturbation dies in lasting contacts");
        else
            say(m, "nothing irregular: largest exponent %.4g +- %.1g per unit of time", m->lyapunov,
                m->lyapunov_error);
        say(m,
            ", so that a period longer than %d T, or one that is reached slowly, must show; a longer "
            "--transient or --longest would find it",
            j->options->longest);
        break;
    case SALTUS_OUTCOME_SHORT:
        m->verdict = SALTUS_IRREGULAR;
        say(m,
            "largest exponent %.4g +- %.1g per unit of time over %lld periods, positive, but a transient of "
            "%.0f periods would not have ended yet; measuring some %.1e periods would tell (--measure)",
            m->lyapunov, m->lyapunov_error, e->periods, e->lifetime_at_least,
            1.05 * dearness(j) * (double)e->periods * (double)j->options->lifetime / e->lifetime_at_least);
        break;
    default:
        tell_undecided(j);
    }
}

saltus_status saltus_motion_judge(const saltus_system *system, const saltus_classify_options *options,
                                  saltus_motion *motion, saltus_outcome *outcome, saltus_message *message) {
    judge j = {.options = options,
               .motion = motion,
               .before = options->flow.effort->total,
               .traceless = saltus_system_traceless(system)};
    saltus_lyapunov_options how = saltus_lyapunov_defaults();
    const size_t numbers = (size_t)points_kept * (size_t)saltus_system_dimension(system);
    *outcome = SALTUS_OUTCOME_OPEN;
    how.flow.integrator = options->flow.integrator;
    how.flow.stop = options->flow.stop;
    how.flow.effort = options->flow.effort;
    how.flow.rtol = fmax(how.flow.rtol, options->flow.rtol);
    how.flow.atol = fmax(how.flow.atol, options->flow.atol);
    how.members = trajectories;
    how.transient = spread;
    saltus_motion_forget_evidence(motion);
    j.returns = calloc(numbers, sizeof *j.returns);
    j.times = calloc(points_kept, sizeof *j.times);
    motion->evidence.history = calloc(SALTUS_HISTORY_ROOM, sizeof *motion->evidence.history);
    saltus_status status = j.returns && j.times && motion->evidence.history
                               ? saltus_ensemble_open(&j.ensemble, system, &how, points_kept, message)
                               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the section points");
    if (status == SALTUS_OK)
        status = run_trial(&j, outcome, message);
    if (status == SALTUS_OK && saltus_ensemble_periods(&j.ensemble) > 0)
        tell(&j, *outcome);
    else
        saltus_motion_forget_evidence(motion);
    saltus_ensemble_close(&j.ensemble);
    free(j.returns);
    free(j.times);
    return status;
}
