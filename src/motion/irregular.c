/* The verdict on a motion without a period: quasi-periodic, chaotic, on its way to something else, or
 * undecided.
 *
 * Several trajectories on the motion measure its largest exponent together, in runs of which each is as long
 * as all before it. A motion is chaotic if its exponent is positive by three standard errors over the whole
 * run and by two in each half of it, while none of the trajectories has come to a regular motion: a long
 * transient looks chaotic as long as it lasts, and where a trajectory has left it the tangent vectors begin
 * to shrink. A negative exponent means that nothing irregular goes on and a period will show. An exponent of
 * zero belongs to a torus if the section points fill closed curves and have a spectrum of lines.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/ensemble.h"
#include "motion/evidence.h"
#include "motion/motion.h"
#include "motion/stable_orbit.h"
#include "saltus/series.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    trajectories = 8,
    spread = 400,    /* periods over which they start */
    first_run = 500, /* samples; then doubled */
    chunk = 250,     /* samples between checks whether a trajectory has left */
    assertion = 8,   /* chaos is asserted from this part of the periods that may be measured */
    least_torus = 1000,
    points_kept = 4096,
    check_periods = 1000, /* in which a trajectory that seems to have left must show its period */
    longest_laminar = 16
};

/* -ln 1e-16: after so many e-folding times neighbours have come apart from rounding to the motion's extent.
 */
static const double apart = 37;

typedef struct judge {
    const saltus_system *system;
    const saltus_classify_options *options;
    saltus_lyapunov_options how;
    saltus_ensemble ensemble;
    saltus_motion *motion;
    double *points;
    bool searched; /* for stable orbits */
} judge;

static long long points_there(const judge *j) {
    long long samples = j->ensemble.member[0].samples;
    return samples < points_kept ? samples : points_kept;
}

static saltus_runs runs_of(const judge *j) {
    const saltus_ensemble *e = &j->ensemble;
    long long samples = e->member[0].samples;
    saltus_runs runs = {.all = saltus_ensemble_largest(e),
                        .first = saltus_ensemble_half(e, 0),
                        .second = saltus_ensemble_half(e, 1),
                        .period = saltus_system_period(j->system),
                        .lost = saltus_ensemble_lost(e) >= e->n};
    /* Before neighbours have come apart all trajectories may still be near one unstable orbit, which they
     * leave slowly. */
    runs.enough = samples >= j->options->measure / assertion / trajectories &&
                  runs.all.mean * runs.period * (double)samples >= apart;
    return runs;
}

/* Has a trajectory come to a regular motion, one whose tangent vectors have shrunk while those of the others
 * grow? */
static saltus_status look_who_left(judge *j, saltus_outcome *outcome, saltus_message *message) {
    saltus_evidence *evidence = &j->motion->evidence;
    saltus_classify_options options = *j->options;
    saltus_status status = SALTUS_OK;
    options.transient = check_periods;
    options.progress.show = NULL;
    if (!(saltus_ensemble_exponent(&j->ensemble, 0, false).mean > 0))
        return SALTUS_OK;
    for (int m = 0; m < trajectories && status == SALTUS_OK && *outcome == SALTUS_OUTCOME_OPEN; m++) {
        const saltus_member *member = &j->ensemble.member[m];
        saltus_motion regular = {0};
        if (!(member->recent <= 0))
            continue;
        status = saltus_motion_find_period(j->system, member->state, &options, false, &regular, message);
        if (status == SALTUS_OK && saltus_verdict_settled(regular.verdict)) {
            *outcome = SALTUS_OUTCOME_LEFT;
            evidence->left++;
            snprintf(evidence->left_for, sizeof evidence->left_for, "%s", regular.label);
        }
        saltus_motion_clear(&regular);
    }
    return status;
}

/* One run more. Now and then it is checked whether a trajectory has left. */
static saltus_status run_on(judge *j, long long samples, saltus_outcome *outcome, saltus_message *message) {
    const saltus_classify_options *o = j->options;
    saltus_evidence *evidence = &j->motion->evidence;
    saltus_status status = SALTUS_OK;
    for (long long done = 0; done < samples && status == SALTUS_OK && *outcome == SALTUS_OUTCOME_OPEN;
         done += chunk) {
        status = saltus_ensemble_run(&j->ensemble, chunk, message);
        if (status == SALTUS_OK) {
            saltus_ensemble_record(&j->ensemble, saltus_ensemble_largest(&j->ensemble), evidence->history,
                                   &evidence->history_count);
            status = look_who_left(j, outcome, message);
        }
        saltus_progress_show(o->progress, (double)saltus_ensemble_periods(&j->ensemble), (double)o->measure);
    }
    return status;
}

/* What the runs so far say. */
static saltus_status decide(judge *j, saltus_outcome *outcome, saltus_message *message) {
    saltus_evidence *evidence = &j->motion->evidence;
    saltus_runs runs = runs_of(j);
    saltus_status status = SALTUS_OK;
    *outcome = saltus_runs_weigh(&runs);
    if (*outcome == SALTUS_OUTCOME_TORUS && j->ensemble.member[0].samples < least_torus)
        *outcome = SALTUS_OUTCOME_OPEN;
    if (*outcome == SALTUS_OUTCOME_TORUS || *outcome == SALTUS_OUTCOME_CHAOS)
        status = saltus_runs_ask_points(&runs, j->system, j->points, points_there(j), SALTUS_OPINIONS_ALL,
                                        evidence, outcome, message);
    if (status != SALTUS_OK || *outcome != SALTUS_OUTCOME_CHAOS)
        return status;
    /* With a stable orbit among its points chaos may be a transient that has not ended yet: it is not
     * asserted, and followed for as long as allowed. */
    if (!j->searched) {
        saltus_motion orbit = {0};
        bool found;
        status = saltus_stable_orbit_among(j->system, &j->how.flow, j->points, points_there(j), &orbit,
                                           &found, message);
        if (status == SALTUS_OK && found)
            snprintf(evidence->stable_orbit, sizeof evidence->stable_orbit, "%s", orbit.label);
        saltus_motion_clear(&orbit);
        j->searched = true;
    }
    if (evidence->stable_orbit[0])
        *outcome = SALTUS_OUTCOME_OPEN;
    return status;
}

/* Runs, each as long as all before it, until there is an outcome or no time is left. */
static saltus_status run_trial(judge *j, saltus_outcome *outcome, saltus_message *message) {
    const saltus_member *first = &j->ensemble.member[0];
    long long samples = first_run, most = j->options->measure / trajectories;
    saltus_status status = saltus_ensemble_place(&j->ensemble, j->motion->state, message);
    while (status == SALTUS_OK && *outcome == SALTUS_OUTCOME_OPEN && first->samples + samples <= most) {
        status = run_on(j, samples, outcome, message);
        if (status == SALTUS_OK && *outcome == SALTUS_OUTCOME_OPEN)
            status = decide(j, outcome, message);
        samples = first->samples;
    }
    if (status != SALTUS_OK || *outcome != SALTUS_OUTCOME_OPEN || points_there(j) < SALTUS_SERIES_LEAST)
        return status;
    /* What the points say is part of the evidence even where it does not decide. */
    saltus_runs runs = runs_of(j);
    return saltus_runs_ask_points(&runs, j->system, j->points, points_there(j), SALTUS_OPINIONS_ALL,
                                  &j->motion->evidence, outcome, message);
}

/* A motion is intermittent if it stays near a periodic one for much longer than the time in which neighbours
 * separate. */
static void find_intermittency(judge *j) {
    saltus_evidence *evidence = &j->motion->evidence;
    double separation = 1 / (j->motion->lyapunov * saltus_system_period(j->system)),
           weights[SALTUS_STATE_MAX];
    for (int i = 0; i < j->ensemble.n; i++)
        weights[i] = 1 / saltus_system_scale(j->system)[i];
    saltus_series_points points = {j->points, weights, points_there(j), j->ensemble.n};
    saltus_series_phases phases = saltus_series_laminar_phases(&points, longest_laminar);
    if (phases.laminar < 0.05 || (double)phases.longest < 10 * separation)
        phases = (saltus_series_phases){0};
    evidence->laminar = phases.laminar;
    evidence->laminar_period = phases.period;
    evidence->longest_phase = phases.longest;
}

static void tell_exponent(judge *j) {
    const saltus_ensemble *e = &j->ensemble;
    saltus_evidence *evidence = &j->motion->evidence;
    saltus_runs runs = runs_of(j);
    long long impacts = 0;
    j->motion->lyapunov = runs.lost ? -INFINITY : runs.all.mean;
    j->motion->lyapunov_error = runs.lost ? 0 : runs.all.standard_error;
    evidence->half[0] = runs.first.mean;
    evidence->half[1] = runs.second.mean;
    evidence->half_errors[0] = runs.first.standard_error;
    evidence->half_errors[1] = runs.second.standard_error;
    for (int m = 0; m < trajectories; m++)
        impacts += saltus_flow_information(e->member[m].flow, e->member[m].lane).impacts -
                   e->member[m].begin.impacts;
    evidence->periods = saltus_ensemble_periods(e);
    evidence->members = trajectories;
    evidence->impacts_per_period = (double)impacts / (double)evidence->periods;
}

/* Add to the reason. */
__attribute__((format(printf, 2, 3))) static void say(saltus_motion *motion, const char *format, ...) {
    size_t used = strlen(motion->reason);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(motion->reason + used, sizeof motion->reason - used, format, arguments);
    va_end(arguments);
}

/* Why it is undecided, and how long a run would decide: standard errors fall with the square root of the
 * time.
 */
static void tell_undecided(saltus_motion *m, double period) {
    const saltus_evidence *e = &m->evidence;
    double exponent = m->lyapunov, error = m->lyapunov_error, rate = exponent * period;
    double lacking = SALTUS_SIGNIFICANT * error / fmax(fabs(exponent), 1e-3 / period), needed;
    bool positive = exponent > SALTUS_SIGNIFICANT * error;
    if (!e->stable_orbit[0] && !isfinite(error)) {
        say(m, "no period was found, and %lld periods are too few for an exponent", e->periods);
        return;
    }
    say(m, e->stable_orbit[0] ? "largest exponent %.4g" : "largest exponent %.3g", exponent);
    say(m, " +- %.1g per unit of time over %lld periods", error, e->periods);
    if (e->stable_orbit[0]) {
        needed = 10.0 * (double)e->periods;
        say(m,
            ", but there is a stable %s orbit amid the motion: a chaotic transient that may end on it, or "
            "chaos beside it",
            e->stable_orbit);
    } else if (positive && (double)e->periods * rate < apart * e->members) {
        needed = 1.2 * apart * e->members / rate;
        say(m, ", in which neighbours have not come apart: chaos, or an unstable orbit that is left slowly");
    } else {
        needed = 1.2 * (double)e->periods * fmax(lacking * lacking, 2);
        say(m, " is not told from zero (halves %.3g and %.3g), the section points %s", e->half[0], e->half[1],
            e->curves ? "fill closed curves" : "fill no closed curve");
    }
    say(m, "; measuring some %.1e periods would tell (--measure)", needed);
}

static void tell(judge *j, saltus_outcome outcome) {
    saltus_motion *m = j->motion;
    saltus_evidence *e = &m->evidence;
    tell_exponent(j);
    memcpy(m->state, j->ensemble.member[0].state, (size_t)j->ensemble.n * sizeof *m->state);
    m->reason[0] = 0;
    switch (outcome) {
    case SALTUS_OUTCOME_CHAOS:
        m->verdict = SALTUS_CHAOTIC;
        find_intermittency(j);
        say(m,
            "largest exponent %.4g +- %.1g per unit of time over %lld periods, positive in both halves of "
            "the run; none of %d trajectories has come to a period or to rest",
            m->lyapunov, m->lyapunov_error, e->periods, e->members);
        if (e->laminar_period)
            say(m,
                "; intermittent: %.0f %% of the time near a motion of period %d T, up to %lld periods at a "
                "stretch",
                100 * e->laminar, e->laminar_period, e->longest_phase);
        break;
    case SALTUS_OUTCOME_TORUS:
        if (saltus_system_forced(j->system)) {
            m->verdict = SALTUS_QUASIPERIODIC;
            say(m,
                "largest exponent %.1e +- %.0e per unit of time, next to zero; the section points fill %d "
                "closed curve%s, all but %.1e of their variance is in lines",
                m->lyapunov, m->lyapunov_error, e->curves, e->curves == 1 ? "" : "s", e->broadband);
        } else
            say(m,
                "a self-sustained oscillation: the scene is not forced, and the motion has a period of its "
                "own that omega does not give (largest exponent %.1e +- %.0e); set omega to its frequency",
                m->lyapunov, m->lyapunov_error);
        break;
    case SALTUS_OUTCOME_LEFT:
        say(m,
            "a chaotic transient: exponent %.3g while it lasts, but a neighbouring trajectory has come to %s "
            "within %lld periods; a longer --transient would show this one do so",
            m->lyapunov, e->left_for, j->ensemble.member[0].samples);
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
    default:
        tell_undecided(m, saltus_system_period(j->system));
    }
}

saltus_status saltus_motion_judge(const saltus_system *system, const saltus_classify_options *options,
                                  saltus_motion *motion, saltus_outcome *outcome, saltus_message *message) {
    judge j = {.system = system, .options = options, .how = saltus_lyapunov_defaults(), .motion = motion};
    *outcome = SALTUS_OUTCOME_OPEN;
    j.how.flow.integrator = options->flow.integrator;
    j.how.flow.stop = options->flow.stop;
    j.how.flow.rtol = fmax(j.how.flow.rtol, options->flow.rtol);
    j.how.flow.atol = fmax(j.how.flow.atol, options->flow.atol);
    j.how.members = trajectories;
    j.how.transient = spread;
    saltus_motion_forget_evidence(motion);
    j.points = calloc((size_t)saltus_system_dimension(system) * points_kept, sizeof *j.points);
    motion->evidence.history = calloc(SALTUS_HISTORY_ROOM, sizeof *motion->evidence.history);
    saltus_status status = j.points && motion->evidence.history
                               ? saltus_ensemble_open(&j.ensemble, system, &j.how, message)
                               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the section points");
    if (status == SALTUS_OK) {
        j.ensemble.points = j.points;
        j.ensemble.room = points_kept;
        status = run_trial(&j, outcome, message);
    }
    if (status == SALTUS_OK && saltus_ensemble_periods(&j.ensemble) > 0)
        tell(&j, *outcome);
    else
        saltus_motion_forget_evidence(motion);
    saltus_ensemble_close(&j.ensemble);
    free(j.points);
    return status;
}
