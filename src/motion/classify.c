/* Classification of a motion (model.md, section 4): what its trajectory settles on, or else what it is
 * without a period.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/options.h"
#include "motion/search.h"

#include <math.h>

enum {
    patience = 10 /* a motion without a period is judged after this part of the time it may take to settle */
};

/* Nothing irregular goes on in the motion: look for longer periods than were asked for. */
static saltus_status find_long_period(saltus_search *s, saltus_motion *motion, saltus_message *message) {
    saltus_classify_options options = *s->options;
    saltus_motion found = {0};
    long long before = motion->transient;
    options.longest = SALTUS_LONGEST_PERIOD;
    options.transient = 8 * SALTUS_LONGEST_PERIOD;
    options.progress.show = NULL;
    saltus_status status =
        saltus_motion_find_period(s->system, motion->state, &options, true, &found, message);
    if (status == SALTUS_OK && saltus_verdict_settled(found.verdict)) {
        saltus_motion_clear(motion);
        *motion = found;
        motion->transient += before;
    } else
        saltus_motion_clear(&found);
    return status;
}

/* No period so far: judge the motion; if it should settle, give it the rest of the time. */
static saltus_status judge(saltus_search *s, saltus_motion *motion, saltus_message *message) {
    const saltus_classify_options *o = s->options;
    saltus_outcome outcome;
    saltus_flow_state(s->flow, 0, motion->state);
    saltus_status status = saltus_motion_judge(s->system, o, motion, &outcome, message);
    bool regular = outcome == SALTUS_OUTCOME_REGULAR || outcome == SALTUS_OUTCOME_LEFT;
    if (status != SALTUS_OK || motion->verdict != SALTUS_UNDECIDED)
        return status;
    if (s->settling.count < o->transient)
        status = saltus_search_run(s, o->transient, motion, message);
    if (status != SALTUS_OK || s->found || motion->verdict != SALTUS_UNDECIDED)
        return status;
    saltus_flow_state(s->flow, 0, motion->state);
    if (regular && motion->evidence.left == 0)
        status = find_long_period(s, motion, message);
    if (status == SALTUS_OK && regular && motion->verdict == SALTUS_UNDECIDED)
        motion->verdict = motion->evidence.left ? SALTUS_TRANSIENT : SALTUS_LONG_PERIOD;
    return status;
}

saltus_status saltus_motion_classify(const saltus_system *system, const double *state,
                                     const saltus_classify_options *options, saltus_motion *motion,
                                     bool *stopped, saltus_message *message) {
    saltus_search s = {.system = system, .options = options};
    *motion = (saltus_motion){0};
    *stopped = false;
    saltus_status status = saltus_options_check(&saltus_classify_table, options, message);
    if (status != SALTUS_OK)
        return status;
    long long early = options->measure && options->transient > patience * SALTUS_FIRST_BLOCK
                          ? options->transient / patience
                          : options->transient;
    status = saltus_search_open(&s, state, motion, message);
    if (status == SALTUS_OK)
        status = saltus_search_run(&s, early, motion, message);
    bool open = status == SALTUS_OK && !s.found && motion->verdict == SALTUS_UNDECIDED && !s.stopped;
    if (open && options->measure)
        status = judge(&s, motion, message);
    if (open && saltus_stop_asked(options->flow.stop) && !saltus_verdict_settled(motion->verdict)) {
        /* Flows that are being stopped prove nothing. */
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
    /* The extremes of a motion without a period are measured without a verdict, too. */
    if (status == SALTUS_OK && motion->verdict == SALTUS_UNDECIDED && !judged && !s.stopped)
        status = saltus_motion_survey(system, s.flow, motion, message);
    *stopped = s.stopped;
    saltus_search_close(&s);
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
