/* The verdict on a motion without a period: quasi-periodic, chaotic, on its way to something else, or not to
 * be told.
 *
 * Several trajectories on the motion measure its largest exponent together, in runs that are doubled. Chaotic
 * is what has a positive exponent by three standard errors over the whole run and by two in each half of it,
 * while none of the trajectories has left for a regular motion: long transients are chaotic as long as they
 * last, and a trajectory that has left is betrayed by tangent vectors that shrink. A negative exponent means
 * that nothing irregular goes on and a period will show. A largest exponent of zero belongs to a torus if the
 * section points fill closed curves and have a spectrum of lines.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/ensemble.h"
#include "motion/evidence.h"
#include "motion/motion.h"
#include "motion/stable_orbit.h"
#include "saltus/series.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    trajectories = 8,
    spread = 400,    /* periods over which they start */
    first_run = 500, /* samples; then doubled */
    chunk = 250,     /* samples between looks at who has left */
    assertion = 8,   /* chaos is asserted from this part of the periods that may be measured */
    least_torus = 1000,
    points_kept = 4096,
    check_periods = 1000, /* in which a trajectory that seems to have left must show its period */
    longest_laminar = 16
};

typedef struct judge {
    const saltus_system *system;
    const saltus_classify_options *options;
    saltus_lyapunov_options how;
    saltus_ensemble ensemble;
    saltus_motion *motion;
    double *points;
    int n;
    bool searched; /* for stable orbits */
    bool stopped;  /* by the caller */
} judge;

/* In so many times of separation, -ln 1e-16, neighbours come apart from rounding to the motion's extent. */
static const double apart = 37;

/* Whether the run is long enough to assert chaos. Before neighbours have come apart it may be all about one
 * unstable orbit, which the trajectories leave slowly. */
static bool is_enough(const judge *j, long long samples, double exponent) {
    return samples >= j->options->measure / assertion / trajectories &&
           exponent * saltus_system_period(j->system) * (double)samples >= apart;
}

static long long points_there(const judge *j) {
    long long samples = saltus_ensemble_samples(&j->ensemble);
    return samples < points_kept ? samples : points_kept;
}

/* Has a trajectory that contracts come to a regular motion? */
static saltus_status look_at(judge *j, int member, bool *left, saltus_message *message) {
    saltus_classify_options options = *j->options;
    saltus_motion regular = {0};
    saltus_evidence *evidence = &j->motion->evidence;
    options.transient = check_periods;
    options.progress = NULL;
    saltus_status status = saltus_motion_find_period(j->system, saltus_ensemble_state(&j->ensemble, member),
                                                     &options, false, &regular, message);
    if (status == SALTUS_OK && saltus_verdict_settled(regular.verdict)) {
        *left = true;
        evidence->left++;
        snprintf(evidence->left_for, sizeof evidence->left_for, "%s", regular.label);
    }
    saltus_motion_clear(&regular);
    return status;
}

/* Trajectories whose tangent vectors have shrunk, while those of the others grow. */
static saltus_status look_who_left(judge *j, bool *left, saltus_message *message) {
    double mean = saltus_ensemble_exponent(&j->ensemble, 0, false).mean;
    saltus_status status = SALTUS_OK;
    *left = false;
    for (int m = 0; m < trajectories && mean > 0 && status == SALTUS_OK && !*left; m++)
        if (j->ensemble.member[m].recent <= 0)
            status = look_at(j, m, left, message);
    return status;
}

static bool remember(judge *j) {
    saltus_evidence *evidence = &j->motion->evidence;
    int count = evidence->history_count;
    if ((count & (count - 1)) == 0) {
        saltus_lyapunov_progress *grown =
            realloc(evidence->history, (size_t)(count ? 2 * count : 1) * sizeof *grown);
        if (!grown)
            return false;
        evidence->history = grown;
    }
    saltus_estimate now = saltus_ensemble_exponent(&j->ensemble, 0, saltus_ensemble_regular(&j->ensemble));
    double time = (double)saltus_ensemble_periods(&j->ensemble) * saltus_system_period(j->system);
    evidence->history[evidence->history_count++] =
        (saltus_lyapunov_progress){time, now.mean, now.standard_error};
    return true;
}

/* One run more, looking now and then. */
static saltus_status run_on(judge *j, long long samples, bool *left, saltus_message *message) {
    saltus_status status = SALTUS_OK;
    *left = false;
    for (long long done = 0; done < samples && status == SALTUS_OK && !*left && !j->stopped; done += chunk) {
        status = saltus_ensemble_run(&j->ensemble, chunk, message);
        if (status == SALTUS_OK && !remember(j))
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the exponent's history");
        if (status == SALTUS_OK)
            status = look_who_left(j, left, message);
        j->stopped = j->options->progress &&
                     !j->options->progress(j->options->context, saltus_ensemble_periods(&j->ensemble),
                                           j->options->measure);
    }
    return status;
}

static saltus_status ask_points(judge *j, saltus_message *message) {
    return saltus_evidence_of_points(j->system, j->points, points_there(j), &j->motion->evidence, message);
}

/* Is there a stable orbit among the points? */
static saltus_status find_stable_orbit(judge *j, saltus_message *message) {
    saltus_evidence *evidence = &j->motion->evidence;
    saltus_motion orbit = {0};
    bool found;
    saltus_status status = saltus_stable_orbit_among(j->system, &j->how.flow, j->points, points_there(j),
                                                     &orbit, &found, message);
    if (status == SALTUS_OK && found)
        snprintf(evidence->stable_orbit, sizeof evidence->stable_orbit, "%s", orbit.label);
    saltus_motion_clear(&orbit);
    j->searched = true;
    return status;
}

/* Chaos among whose points there is a stable orbit may be a transient that has not ended yet: it is followed
 * for as long as may be, and not asserted. */
static saltus_status doubt_chaos(judge *j, saltus_outcome *result, saltus_message *message) {
    saltus_status status = j->searched ? SALTUS_OK : find_stable_orbit(j, message);
    if (j->motion->evidence.stable_orbit[0])
        *result = SALTUS_OUTCOME_GOES_ON;
    return status;
}

static saltus_status decide(judge *j, saltus_outcome *result, saltus_message *message) {
    const saltus_ensemble *e = &j->ensemble;
    long long samples = saltus_ensemble_samples(e);
    saltus_runs runs = {.all = saltus_ensemble_exponent(e, 0, saltus_ensemble_regular(e)),
                        .first = saltus_ensemble_half(e, 0, 0),
                        .second = saltus_ensemble_half(e, 0, 1),
                        .period = saltus_system_period(j->system),
                        .lost = saltus_ensemble_lost(e) >= j->n};
    saltus_status status = SALTUS_OK;
    runs.enough = is_enough(j, samples, runs.all.mean);
    *result = saltus_runs_weigh(&runs);
    bool suspected = *result == SALTUS_OUTCOME_TORUS && samples >= least_torus;
    if (suspected || *result == SALTUS_OUTCOME_CHAOS)
        status = ask_points(j, message);
    *result = saltus_runs_conclude(&runs, *result, &j->motion->evidence);
    if (status == SALTUS_OK && *result == SALTUS_OUTCOME_CHAOS)
        status = doubt_chaos(j, result, message);
    return status;
}

/* Runs, each as long as all before it, until there is an outcome or no time is left. */
static saltus_status run_trial(judge *j, saltus_outcome *result, saltus_message *message) {
    long long samples = first_run, most = j->options->measure / trajectories;
    saltus_status status = saltus_ensemble_place(&j->ensemble, j->motion->state, message);
    *result = SALTUS_OUTCOME_GOES_ON;
    while (status == SALTUS_OK && *result == SALTUS_OUTCOME_GOES_ON && !j->stopped &&
           saltus_ensemble_samples(&j->ensemble) + samples <= most) {
        bool left;
        status = run_on(j, samples, &left, message);
        if (j->stopped)
            break;
        if (status == SALTUS_OK && left)
            *result = SALTUS_OUTCOME_LEFT;
        else if (status == SALTUS_OK)
            status = decide(j, result, message);
        samples = saltus_ensemble_samples(&j->ensemble);
    }
    if (status == SALTUS_OK && *result == SALTUS_OUTCOME_GOES_ON && points_there(j) >= SALTUS_SERIES_LEAST)
        status = ask_points(j, message);
    return status;
}

/* Intermittent is what stays near a periodic motion for much longer than the time in which neighbours
 * separate. */
static void find_intermittency(judge *j) {
    saltus_evidence *evidence = &j->motion->evidence;
    double separation = 1 / (j->motion->lyapunov * saltus_system_period(j->system)),
           weights[SALTUS_STATE_MAX];
    for (int i = 0; i < j->n; i++)
        weights[i] = 1 / saltus_system_scale(j->system)[i];
    saltus_series_points points = {j->points, weights, points_there(j), j->n};
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
    saltus_estimate all = saltus_ensemble_exponent(e, 0, saltus_ensemble_regular(e));
    bool lost = saltus_ensemble_lost(e) >= j->n;
    long long impacts = 0;
    j->motion->lyapunov = lost ? -INFINITY : all.mean;
    j->motion->lyapunov_error = lost ? 0 : all.standard_error;
    for (int half = 0; half < 2; half++) {
        saltus_estimate part = saltus_ensemble_half(e, 0, half);
        evidence->half[half] = part.mean;
        evidence->half_errors[half] = part.standard_error;
    }
    for (int m = 0; m < trajectories; m++)
        impacts += saltus_flow_information(e->flows[m / e->width], m % e->width).impacts -
                   e->member[m].begin.impacts;
    evidence->periods = saltus_ensemble_periods(e);
    evidence->members = trajectories;
    evidence->impacts_per_period = (double)impacts / (double)evidence->periods;
}

static void tell_chaos(saltus_motion *m) {
    const saltus_evidence *e = &m->evidence;
    int used = snprintf(
        m->reason, sizeof m->reason,
        "largest exponent %.4g +- %.1g per unit of time over %lld periods, positive in both halves of "
        "the run; none of %d trajectories has come to a period or to rest",
        m->lyapunov, m->lyapunov_error, e->periods, e->members);
    if (e->laminar_period && used < (int)sizeof m->reason)
        snprintf(m->reason + used, sizeof m->reason - (size_t)used,
                 "; intermittent: %.0f %% of the time near a motion of period %d T, up to %lld periods at a "
                 "stretch",
                 100 * e->laminar, e->laminar_period, e->longest_phase);
}

/* What is lacking, and what run would decide: standard errors fall with the square root of the time. */
static void tell_undecided(saltus_motion *m, double period) {
    const saltus_evidence *e = &m->evidence;
    double short_by = SALTUS_SIGNIFICANT * m->lyapunov_error / fmax(fabs(m->lyapunov), 1e-3 / period),
           needed = 1.2 * (double)e->periods * fmax(short_by * short_by, 2), rate = m->lyapunov * period;
    bool positive = m->lyapunov > SALTUS_SIGNIFICANT * m->lyapunov_error;
    if (e->stable_orbit[0])
        snprintf(m->reason, sizeof m->reason,
                 "largest exponent %.4g +- %.1g per unit of time over %lld periods, but there is a stable %s "
                 "orbit "
                 "amid the motion: a chaotic transient that may end on it, or chaos beside it; measuring "
                 "some %.1e "
                 "periods would tell (--measure)",
                 m->lyapunov, m->lyapunov_error, e->periods, e->stable_orbit, 10.0 * (double)e->periods);
    else if (positive && (double)e->periods * rate < apart * e->members)
        snprintf(
            m->reason, sizeof m->reason,
            "largest exponent %.3g +- %.1g per unit of time over %lld periods, in which neighbours have not "
            "come apart: chaos, or an unstable orbit that is left slowly; measuring some %.1e periods would "
            "tell (--measure)",
            m->lyapunov, m->lyapunov_error, e->periods, 1.2 * apart * e->members / rate);
    else if (!isfinite(m->lyapunov_error))
        snprintf(m->reason, sizeof m->reason,
                 "no period was found, and %lld periods are too few for an exponent", e->periods);
    else
        snprintf(
            m->reason, sizeof m->reason,
            "largest exponent %.3g +- %.1g per unit of time over %lld periods is not told from zero (halves "
            "%.3g and %.3g), the section points %s; measuring some %.1e periods would tell (--measure)",
            m->lyapunov, m->lyapunov_error, e->periods, e->half[0], e->half[1],
            e->curves ? "fill closed curves" : "fill no closed curve", needed);
}

static void tell(judge *j, saltus_outcome result) {
    saltus_motion *m = j->motion;
    saltus_evidence *e = &m->evidence;
    tell_exponent(j);
    memcpy(m->state, saltus_ensemble_state(&j->ensemble, 0), (size_t)j->n * sizeof *m->state);
    if (result == SALTUS_OUTCOME_CHAOS) {
        m->verdict = SALTUS_CHAOTIC;
        find_intermittency(j);
        tell_chaos(m);
    } else if (result == SALTUS_OUTCOME_TORUS && saltus_system_forced(j->system)) {
        m->verdict = SALTUS_QUASIPERIODIC;
        snprintf(m->reason, sizeof m->reason,
                 "largest exponent %.1e +- %.0e per unit of time, next to zero; the section points "
                 "fill %d "
                 "closed curve%s, all but %.1e of their variance is in lines",
                 m->lyapunov, m->lyapunov_error, e->curves, e->curves == 1 ? "" : "s", e->broadband);
    } else if (result == SALTUS_OUTCOME_TORUS)
        snprintf(
            m->reason, sizeof m->reason,
            "a self-sustained oscillation: the scene is not forced, and the motion has a period of its own "
            "that omega does not give (largest exponent %.1e +- %.0e); set omega to its frequency",
            m->lyapunov, m->lyapunov_error);
    else if (result == SALTUS_OUTCOME_LEFT)
        snprintf(
            m->reason, sizeof m->reason,
            "a chaotic transient: exponent %.3g while it lasts, but a neighbouring trajectory has come to %s "
            "within %lld periods; a longer --transient would show this one do so",
            m->lyapunov, e->left_for, saltus_ensemble_samples(&j->ensemble));
    else if (result == SALTUS_OUTCOME_REGULAR && isinf(m->lyapunov))
        snprintf(m->reason, sizeof m->reason,
                 "nothing irregular: every perturbation dies in lasting contacts, so that a period longer "
                 "than %d T, "
                 "or one that is reached slowly, must show; a longer --transient or --longest would find it",
                 j->options->longest);
    else if (result == SALTUS_OUTCOME_REGULAR)
        snprintf(
            m->reason, sizeof m->reason,
            "nothing irregular: largest exponent %.4g +- %.1g per unit of time, so that a period longer than "
            "%d T, or one that is reached slowly, must show; a longer --transient or --longest would find it",
            m->lyapunov, m->lyapunov_error, j->options->longest);
    else
        tell_undecided(m, saltus_system_period(j->system));
}

saltus_status saltus_motion_judge(const saltus_system *system, const saltus_classify_options *options,
                                  saltus_motion *motion, bool *regular, bool *stopped,
                                  saltus_message *message) {
    judge j = {.system = system,
               .options = options,
               .how = saltus_lyapunov_defaults(),
               .motion = motion,
               .n = saltus_system_dimension(system)};
    saltus_outcome result = SALTUS_OUTCOME_GOES_ON;
    *regular = false;
    j.how.flow.integrator = options->flow.integrator;
    j.how.flow.stop = options->flow.stop;
    j.how.flow.rtol = fmax(j.how.flow.rtol, options->flow.rtol);
    j.how.flow.atol = fmax(j.how.flow.atol, options->flow.atol);
    j.how.members = trajectories;
    j.how.transient = spread;
    saltus_motion_forget_evidence(motion);
    j.points = calloc((size_t)j.n * points_kept, sizeof *j.points);
    saltus_status status = j.points
                               ? saltus_ensemble_open(&j.ensemble, system, &j.how, message)
                               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the section points");
    if (status == SALTUS_OK) {
        j.ensemble.points = j.points;
        j.ensemble.room = points_kept;
        status = run_trial(&j, &result, message);
    }
    if (status == SALTUS_OK && saltus_ensemble_periods(&j.ensemble) > 0)
        tell(&j, result);
    *regular = result == SALTUS_OUTCOME_REGULAR || result == SALTUS_OUTCOME_LEFT;
    *stopped = j.stopped;
    saltus_ensemble_close(&j.ensemble);
    free(j.points);
    return status;
}
