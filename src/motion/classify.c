/* Classification of a motion (model.md, section 4): what its trajectory settles on, or what kind of motion
 * without a period it is.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/effort.h"
#include "motion/options.h"
#include "motion/search.h"
#include "system/system.h"

#include <math.h>
#include <stdio.h>

enum {
    patience = 10 /* a motion without a period is judged after a tenth of the time it may take to settle */
};

/* Replace the motion by the one found, if that is settled; otherwise clear the latter. */
static void take(saltus_motion *motion, saltus_motion *found) {
    long long before = motion->transient;
    if (!saltus_verdict_settled(found->verdict)) {
        saltus_motion_clear(found);
        return;
    }
    saltus_motion_clear(motion);
    *motion = *found;
    motion->transient += before;
}

/* The motion is regular: look for longer periods than were asked for. */
static saltus_status find_long_period(saltus_search *s, saltus_motion *motion, saltus_message *message) {
    saltus_classify_options options = *s->options;
    saltus_motion found = {0};
    options.longest = SALTUS_LONGEST_PERIOD;
    options.transient = 8 * SALTUS_LONGEST_PERIOD;
    options.progress.show = NULL;
    const bool forced = saltus_system_forced(s->system);
    saltus_status status = SALTUS_OK;
    if (forced)
        status = saltus_motion_find_locked(s->system, &options, motion->state, &found, message);
    if (status == SALTUS_OK && !saltus_verdict_settled(found.verdict)) {
        saltus_motion_clear(&found);
        status = saltus_motion_find_period(s->system, motion->state, &options, true, &found, message);
    }
    take(motion, &found);
    if (status != SALTUS_OK || !forced || motion->lyapunov != -INFINITY ||
        motion->verdict != SALTUS_UNDECIDED)
        return status;
    /* Lasting contacts wipe out all differences. */
    status = saltus_motion_find_contact(s->system, s->options, motion, &found, message);
    take(motion, &found);
    return status;
}

/* Without forcing a unit of time may be a small part of a cycle, and then takes hardly a step: wait for as
 * many returns as show a period, while that is cheap. */
static saltus_status await_returns(saltus_search *s, saltus_motion *motion, saltus_message *message) {
    enum { enough = 8, patient = 20 };
    const long long most = patient * s->options->transient;
    saltus_status status = SALTUS_OK;
    while (status == SALTUS_OK && !s->found && !s->stopped && motion->verdict == SALTUS_UNDECIDED &&
           s->visits.settling.count < enough && s->settling.count < most &&
           saltus_flow_information(s->flow, 0).steps < most)
        status = saltus_search_run(s, s->settling.count + s->options->transient / patience, motion, message);
    return status;
}

/* No period so far: judge the motion, and if it should settle, give it the rest of the time: less where
 * neighbours separate and periods are dear, each of which then counts more than once. The search so far has
 * taken `steps`. Without forcing periods are counted by the mean time between returns. */
static saltus_status judge(saltus_search *s, double steps, saltus_motion *motion, saltus_message *message) {
    const saltus_classify_options *o = s->options;
    const double dear = fmax(1, steps / (double)s->settling.count / SALTUS_EFFORT_MEASURED);
    const bool forced = saltus_system_forced(s->system);
    saltus_outcome outcome;
    saltus_system *counted = NULL;
    saltus_flow_state(s->flow, 0, motion->state);
    saltus_status status = SALTUS_OK;
    if (!forced)
        status = saltus_visits_count(&s->visits, s->system, &counted, message);
    if (status != SALTUS_OK)
        return status;
    if (counted)
        o->flow.effort->period = saltus_system_period(counted);
    status = saltus_motion_judge(counted ? counted : s->system, o, motion, &outcome, message);
    saltus_system_free(counted);
    if (status == SALTUS_OK && motion->verdict == SALTUS_QUASIPERIODIC && forced) {
        /* The motion is a torus only if it is not locked. */
        saltus_motion found = {0};
        status = saltus_motion_find_locked(s->system, o, motion->state, &found, message);
        take(motion, &found);
        return status;
    }
    bool open = motion->verdict == SALTUS_UNDECIDED || motion->verdict == SALTUS_IRREGULAR;
    if (status != SALTUS_OK || !open)
        return status;
    const bool attracts = !forced || !saltus_system_keeps_volume(s->system);
    const double share = outcome == SALTUS_OUTCOME_SHORT ? 1 / dear : 1;
    if (attracts && (double)s->settling.count < share * (double)o->transient)
        status = saltus_search_run(s, (long long)(share * (double)o->transient), motion, message);
    if (status != SALTUS_OK || s->found || motion->verdict != SALTUS_UNDECIDED)
        return status;
    saltus_flow_state(s->flow, 0, motion->state);
    if (outcome == SALTUS_OUTCOME_REGULAR)
        status = find_long_period(s, motion, message);
    bool regular = outcome == SALTUS_OUTCOME_REGULAR || outcome == SALTUS_OUTCOME_LEFT;
    if (status == SALTUS_OK && regular && motion->verdict == SALTUS_UNDECIDED)
        motion->verdict = outcome == SALTUS_OUTCOME_LEFT ? SALTUS_TRANSIENT : SALTUS_LONG_PERIOD;
    return status;
}

/* Add to the reason of an unforced motion that nothing attracts, or that the section is not met, or not often
 * enough for a period to be seen: then a longer measurement would tell nothing. */
static void explain_unforced(saltus_search *s, saltus_motion *motion) {
    enum { few = 12, enough = 25 }; /* returns */
    const bool settled = saltus_verdict_settled(motion->verdict), chaotic = motion->verdict == SALTUS_CHAOTIC,
               open = !settled && !chaotic;
    const long long returns = s->visits.settling.count;
    const double unit = saltus_system_period(s->system), passed = (double)s->settling.count * unit;
    const double missed = (double)s->settling.count - (returns > 1 ? saltus_visits_last(&s->visits) : 0);
    double recurrence, period;
    char before[sizeof motion->reason];
    snprintf(before, sizeof before, "%s", motion->reason);
    if (saltus_system_conservative(s->system) && motion->verdict != SALTUS_EQUILIBRIUM &&
        motion->verdict != SALTUS_HELD)
        snprintf(motion->reason, sizeof motion->reason,
                 "conservative (no damping, r = 1): nothing attracts, and orbits form continua%s%.200s",
                 settled   ? "; this is the one that the trajectory is on"
                 : chaotic ? "; "
                           : "; saltus orbit finds one beside a trajectory",
                 chaotic ? before : "");
    else if (!settled && saltus_search_recurs(s, &recurrence, &period))
        snprintf(motion->reason, sizeof motion->reason,
                 "returns to the section, %.9g units of time apart, repeat to %.1g, but the flow is so stiff "
                 "that rounding keeps Newton's method from confirming the orbit in double precision",
                 period, recurrence);
    else if (open && missed > 0.5 * (double)s->settling.count)
        snprintf(motion->reason, sizeof motion->reason,
                 "the trajectory does not return to its section within %lld units of time; another section "
                 "(--section), a longer --transient or both would count its orbit",
                 (long long)(missed * unit));
    else if (open && returns > 1 && returns < few)
        snprintf(motion->reason, sizeof motion->reason,
                 "only %lld returns to the section within %.6g units of time, too few for a period to show; "
                 "--transient %.0f would tell",
                 returns, passed, ceil(enough * (double)s->settling.count / (double)returns));
}

saltus_status saltus_motion_classify(const saltus_system *system, const double *state,
                                     const saltus_classify_options *options, saltus_motion *motion,
                                     bool *stopped, saltus_message *message) {
    saltus_classify_options own = *options;
    saltus_effort effort;
    saltus_search s = {.system = system, .options = &own};
    *motion = (saltus_motion){0};
    *stopped = false;
    saltus_status status = saltus_options_check(&saltus_classify_table, options, message);
    if (status != SALTUS_OK)
        return status;
    own.flow = saltus_effort_begin(&options->flow, system, &effort);
    long long early = options->measure && options->transient > patience * SALTUS_FIRST_BLOCK
                          ? options->transient / patience
                          : options->transient;
    const double before = own.flow.effort->total;
    status = saltus_search_open(&s, state, motion, message);
    if (status == SALTUS_OK)
        status = saltus_search_run(&s, early, motion, message);
    if (status == SALTUS_OK && !saltus_system_forced(system))
        status = await_returns(&s, motion, message);
    bool open = status == SALTUS_OK && !s.found && motion->verdict == SALTUS_UNDECIDED && !s.stopped;
    /* Returns that repeat to rounding leave nothing to measure. */
    double recurrence, period;
    const bool repeats =
        open && !saltus_system_forced(system) && saltus_search_recurs(&s, &recurrence, &period);
    if (open && options->measure && !repeats)
        status = judge(&s, own.flow.effort->total - before, motion, message);
    if (open && saltus_stop_asked(options->flow.stop) && !saltus_verdict_settled(motion->verdict)) {
        /* Results of flows that were stopped prove nothing. */
        saltus_motion_forget_evidence(motion);
        motion->verdict = SALTUS_UNDECIDED;
        motion->lyapunov = motion->lyapunov_error = NAN;
        s.stopped = true;
        status = SALTUS_OK;
    }
    bool judged = motion->evidence.periods > 0 && !s.found && !saltus_verdict_settled(motion->verdict);
    if (status == SALTUS_OK && judged)
        status = saltus_motion_survey(system, s.flow, motion, message);
    else if (status == SALTUS_OK && !(saltus_verdict_settled(motion->verdict) && motion->multiplier_count))
        status = saltus_search_conclude(&s, motion, message);
    /* A motion that was not judged is irregular; its extremes are measured too. */
    if (status == SALTUS_OK && motion->verdict == SALTUS_UNDECIDED && !judged && !s.stopped && !repeats) {
        motion->verdict = SALTUS_IRREGULAR;
        status = saltus_motion_survey(system, s.flow, motion, message);
    }
    if (status == SALTUS_OK && !saltus_system_forced(system) && !s.stopped)
        explain_unforced(&s, motion);
    *stopped = s.stopped;
    saltus_search_close(&s);
    /* If an attempt ran out of steps, it might have been the one to decide. */
    if (status == SALTUS_OK && !*stopped)
        status = saltus_effort_check(own.flow.effort, system, message);
    if (status != SALTUS_OK)
        saltus_motion_clear(motion);
    return status;
}

saltus_status saltus_classify(const saltus_system *system, const double *state,
                              const saltus_classify_options *options, saltus_motion *motion,
                              saltus_message *message) {
    bool stopped;
    return saltus_motion_classify(system, state, options, motion, &stopped, message);
}
