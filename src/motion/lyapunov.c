/* Lyapunov exponents: measured by several trajectories until they are precise enough, or taken from the
 * multipliers of a periodic orbit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/lyapunov.h"

#include "base/progress.h"
#include "flow/effort.h"
#include "motion/ensemble.h"
#include "motion/evidence.h"
#include "motion/options.h"
#include "saltus/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    least_samples = 200,
    shortest_chunk = 25,
    longest_chunk = 5000,
    chunks_per_run = 20,
    doublings = 3,   /* of a run, over which its standard error should fall to a third */
    worth_a_try = 16 /* a run may last this part of the periods before it must show that its error falls */
};
static const double precise_enough = 1e-6; /* standard error per period */
static const double halves_apart = 4;      /* standard errors between a run's halves: it drifts above, ... */
static const double halves_agree = 3;      /* ... and may end below */
static const double falls = 0.6; /* an error above this part of that three doublings before does not fall */

static saltus_status check(const saltus_system *system, const saltus_lyapunov_options *o,
                           saltus_message *message) {
    int n = saltus_system_dimension(system);
    double part = o->interval > 0 && o->interval <= 1 ? 1 / o->interval : o->interval;
    saltus_status status = saltus_options_check(&saltus_lyapunov_table, o, message);
    if (status != SALTUS_OK)
        return status;
    if (o->exponents > n)
        return saltus_fail(message, SALTUS_BAD_INPUT, "exponents = %d: the scene has %d, 0 asks for all",
                           o->exponents, n);
    if (!(part <= 1000000 && fabs(part - floor(part + 0.5)) < 1e-6 * part + 1e-300))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "interval = %g: must be a whole number of periods or a whole part of one, such as "
                           "0.25",
                           o->interval);
    double least = least_samples * fmax(1, floor(o->interval)) * o->members;
    if (!((double)o->periods >= least))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "periods = %lld: must be at least %.0f, %d intervals of %g periods for each of %d "
                           "trajectories",
                           o->periods, least, least_samples, fmax(1, o->interval), o->members);
    return SALTUS_OK;
}

static bool open_result(saltus_lyapunov *l, int dimension, int count, int members) {
    *l = (saltus_lyapunov){.dimension = dimension, .count = count, .members = members};
    l->exponents = calloc((size_t)count, sizeof *l->exponents);
    l->standard_errors = calloc((size_t)count, sizeof *l->standard_errors);
    l->state = calloc((size_t)dimension, sizeof *l->state);
    l->member_exponents = calloc((size_t)members, sizeof *l->member_exponents);
    l->history = calloc(SALTUS_HISTORY_ROOM, sizeof *l->history);
    return l->exponents && l->standard_errors && l->state && l->member_exponents && l->history;
}

void saltus_lyapunov_clear(saltus_lyapunov *l) {
    free(l->exponents);
    free(l->standard_errors);
    free(l->state);
    free(l->member_exponents);
    free(l->history);
    *l = (saltus_lyapunov){0};
}

/* Difference between the exponents of the run's halves; *errors: in standard errors. */
static double drift(const saltus_ensemble *e, double *errors) {
    saltus_estimate first = saltus_ensemble_part(e, 0, 0.5), second = saltus_ensemble_part(e, 0.5, 1);
    double apart = fabs(first.mean - second.mean);
    *errors = apart > 0 ? apart / hypot(first.standard_error, second.standard_error) : 0;
    return apart;
}

static bool all_lost(const saltus_ensemble *e) {
    return saltus_ensemble_lost(e) >= e->n;
}

/* Whether the exponent is as precise as required, and halves and trajectories agree to that precision. */
static bool is_precise(const saltus_ensemble *e, const saltus_estimate *now, long long least) {
    double period = saltus_system_period(e->system), errors, apart = drift(e, &errors),
           target = fmax(e->options->precision * fabs(now->mean), precise_enough / period);
    return all_lost(e) || (e->member[0].samples >= least && now->standard_error <= target &&
                           (errors < halves_agree || apart <= target) && saltus_ensemble_agrees(e, target));
}

/* Complete the averages' batches, so that all results refer to the same time. */
static saltus_status complete_batches(saltus_ensemble *e, saltus_message *message) {
    const saltus_average *average = &e->member[0].averages[0];
    long long missing = average->open ? average->size - average->open : 0;
    return missing ? saltus_ensemble_run(e, missing, message) : SALTUS_OK;
}

/* Measure until the largest exponent is as precise as required. A run that still drifts is discarded as
 * transient; the new measurement lasts at least as long. Dear periods count more than once. Where neighbours
 * separate in bursts between quiet stretches of all lengths, the error hardly falls as the run grows: the
 * run ends when two looks in turn have shown that. */
static saltus_status measure(saltus_ensemble *e, saltus_lyapunov *l, saltus_message *message) {
    const saltus_lyapunov_options *o = e->options;
    /* A short run may take what the usual one does. */
    const double most = fmax((double)o->periods, (double)saltus_lyapunov_defaults().periods),
                 allowed = SALTUS_EFFORT_MEASURED * most, before = o->flow.effort->total;
    long long spent = 0, least = least_samples, next_look = least_samples,
              each = (long long)e->member[0].growth.whole * e->members; /* periods per sample */
    saltus_status status = SALTUS_OK;
    bool stopped = false;
    double errors_seen[64]; /* at looks, each after twice the time of the one before */
    int looks = 0;
    while (status == SALTUS_OK && !stopped && !l->precise && !l->slow) {
        long long done = e->member[0].samples, left = (o->periods - spent) / each;
        const double part = fmin(fmax((double)(done / chunks_per_run), shortest_chunk), longest_chunk);
        const long long chunk = (long long)fmin(part, (double)left);
        if (chunk < 1)
            break;
        status = saltus_ensemble_run(e, chunk, message);
        if (status != SALTUS_OK)
            break;
        const long long worth = (long long)((double)o->periods * (o->flow.effort->total - before) / allowed);
        spent = worth > spent + chunk * each ? worth : spent + chunk * each;
        done += chunk;
        saltus_estimate now = saltus_ensemble_largest(e);
        saltus_ensemble_record(e, now, l->history, &l->history_count);
        saltus_progress_show(o->progress, (double)spent, (double)o->periods);
        stopped = e->stopped || saltus_stop_asked(e->stop);
        bool look = done >= next_look;
        double errors;
        if (look)
            next_look = 2 * done;
        drift(e, &errors);
        if (look && errors > halves_apart && (o->periods - spent) / each >= done) {
            saltus_ensemble_forget(e);
            least = next_look = done;
            l->history_count = looks = 0;
        } else if (is_precise(e, &now, least)) {
            /* The precision must also hold with complete batches, which are the result. */
            status = complete_batches(e, message);
            spent += (e->member[0].samples - done) * each;
            now = saltus_ensemble_largest(e);
            l->precise = status == SALTUS_OK && is_precise(e, &now, least);
        } else if (look) {
            errors_seen[looks++] = now.standard_error;
            l->slow = spent > o->periods / worth_a_try && looks > doublings + 1 &&
                      now.mean > SALTUS_SIGNIFICANT * now.standard_error &&
                      errors_seen[looks - 1] > falls * errors_seen[looks - 1 - doublings] &&
                      errors_seen[looks - 2] > falls * errors_seen[looks - 2 - doublings];
        }
    }
    if (status == SALTUS_OK)
        status = complete_batches(e, message);
    if (status == SALTUS_OK) {
        const saltus_estimate now = saltus_ensemble_largest(e);
        l->precise = is_precise(e, &now, least);
        saltus_ensemble_record(e, now, l->history, &l->history_count);
    }
    l->interrupted = stopped && !l->precise;
    return status;
}

/* Kaplan-Yorke dimension: how many exponents add up to zero, the last one counted in part. An exponent
 * within three of its errors of zero counts as zero. */
static double kaplan_yorke(const saltus_lyapunov *l) {
    double sum = 0;
    for (int k = 0; k < l->count; k++) {
        double exponent = fabs(l->exponents[k]) <= 3 * l->standard_errors[k] ? 0 : l->exponents[k];
        if (sum + exponent < 0)
            return k + (isfinite(exponent) ? sum / fabs(exponent) : 0);
        sum += exponent;
    }
    return l->count == l->dimension ? l->count : NAN;
}

/* The exponents, rates of impacts and sticks, and both sides of the sum rule, by the same averages over the
 * same time. */
static void tell(const saltus_ensemble *e, saltus_lyapunov *l) {
    const bool regular = saltus_ensemble_regular(e), all = all_lost(e);
    l->lost = saltus_ensemble_lost(e);
    for (int c = 0; c < e->columns; c++) {
        saltus_estimate estimate =
            c == 0 ? saltus_ensemble_largest(e) : saltus_ensemble_exponent(e, c, regular);
        bool lost = c >= e->n - l->lost;
        l->exponents[c] = lost ? -INFINITY : estimate.mean;
        l->standard_errors[c] = lost ? 0 : estimate.standard_error;
        if (c == 0)
            l->independent = estimate.independent;
    }
    for (int half = 0; half < 2; half++) {
        saltus_estimate part = saltus_ensemble_part(e, 0.5 * half, 0.5 * half + 0.5);
        l->half[half] = all ? -INFINITY : part.mean;
        l->half_errors[half] = all ? 0 : part.standard_error;
    }
    for (int m = 0; m < e->members; m++) {
        const saltus_member *self = &e->member[m];
        const saltus_flow_info now = saltus_flow_information(self->flow, self->lane);
        const double periods = (double)l->periods;
        l->member_exponents[m] = all ? -INFINITY : saltus_ensemble_member(e, m, 0, regular).mean;
        l->impacts_per_period += (double)(now.impacts - self->begin.impacts) / periods;
        l->sticks_per_period += (double)(now.sticks - self->begin.sticks) / periods;
    }
    l->agree = all || saltus_ensemble_agrees(e, e->options->precision * fabs(l->exponents[0]));
    l->sum = l->sum_rule = NAN;
    if (l->count < l->dimension || l->lost)
        return;
    l->sum = 0;
    for (int c = 0; c < l->count; c++)
        l->sum += l->exponents[c];
    l->sum_rule = saltus_ensemble_exponent(e, e->columns, regular).mean;
    /* The difference counts as error of the smallest exponent, which is the most difficult to measure. */
    if (!isnan(l->sum_rule))
        l->standard_errors[l->count - 1] = hypot(l->standard_errors[l->count - 1], l->sum - l->sum_rule);
}

saltus_status saltus_lyapunov_run(const saltus_system *system, const double *state,
                                  const saltus_lyapunov_options *options, saltus_lyapunov *lyapunov,
                                  saltus_message *message) {
    saltus_ensemble ensemble = {0};
    saltus_lyapunov_options how = *options;
    saltus_effort effort;
    *lyapunov = (saltus_lyapunov){0};
    saltus_status status = check(system, options, message);
    how.flow = saltus_effort_begin(&options->flow, system, &effort);
    how.flow.stop = NULL; /* chunks are always completed, so that an interrupted run has a result */
    if (status == SALTUS_OK)
        status = saltus_ensemble_open(&ensemble, system, &how, 0, message);
    ensemble.stop = options->flow.stop;
    if (status == SALTUS_OK && !open_result(lyapunov, ensemble.n, ensemble.columns, ensemble.members))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the exponents");
    if (status == SALTUS_OK)
        status = saltus_ensemble_place(&ensemble, state, message);
    if (status == SALTUS_OK)
        status = measure(&ensemble, lyapunov, message);
    if (status == SALTUS_OK) {
        lyapunov->period = saltus_system_period(system);
        lyapunov->periods = saltus_ensemble_periods(&ensemble);
        lyapunov->time = (double)lyapunov->periods * lyapunov->period;
        lyapunov->transient = ensemble.transient;
        memcpy(lyapunov->state, ensemble.member[0].state, (size_t)ensemble.n * sizeof *lyapunov->state);
        tell(&ensemble, lyapunov);
        /* Sort exponents by decreasing value if they differ by more than their errors; lost ones come last.
         */
        double *exponents = lyapunov->exponents, *errors = lyapunov->standard_errors;
        for (int i = 1; i < lyapunov->count; i++)
            for (int j = i; j > 0 && exponents[j] > exponents[j - 1] + hypot(errors[j], errors[j - 1]); j--) {
                const double exponent = exponents[j], error = errors[j];
                exponents[j] = exponents[j - 1];
                errors[j] = errors[j - 1];
                exponents[j - 1] = exponent;
                errors[j - 1] = error;
            }
        lyapunov->kaplan_yorke = kaplan_yorke(lyapunov);
    } else
        saltus_lyapunov_clear(lyapunov);
    saltus_ensemble_close(&ensemble);
    return status;
}

/* From the multipliers; without forcing the zero along the flow is among the exponents. */
static void take_orbit(const saltus_motion *motion, const saltus_flow_options *flow, saltus_lyapunov *l) {
    const int multipliers = motion->multiplier_count;
    /* How accurately the logarithms are known. The orbit itself is known to Newton's residual over the
     * distance of the nearest multiplier from 1, at a fold to the residual's square root, and its multipliers
     * no better. */
    const double of_logarithms = 1e-10; /* as saltus_multipliers_stable takes it */
    double nearest = INFINITY, error = of_logarithms + motion->periods * flow->rtol;
    for (int k = 0; k < multipliers; k++)
        nearest = fmin(nearest, hypot(1 - motion->multipliers[k].re, motion->multipliers[k].im));
    error += fmin(motion->residual / nearest, sqrt(motion->residual));
    if (motion->trivial_multiplier)
        error = fmax(error, fabs(log(fabs(motion->trivial_multiplier))));
    bool along = motion->trivial_multiplier != 0; /* the zero is yet to come */
    for (int k = 0, m = 0; k < l->count; k++) {
        const bool zero = along && (m == multipliers || !(motion->multipliers[m].log_modulus > 0));
        const double logarithm = zero ? 0 : motion->multipliers[m++].log_modulus;
        along = along && !zero;
        l->exponents[k] = logarithm / l->time;
        l->standard_errors[k] = isnan(logarithm) ? NAN : isfinite(logarithm) ? error / l->time : 0;
    }
    for (int m = 0; m < multipliers; m++)
        l->lost += motion->multipliers[m].log_modulus == -INFINITY;
    l->sum_rule = motion->sticks ? NAN : motion->sum_rule / l->time;
    if (l->count < l->dimension)
        return;
    l->sum = motion->log_volume / l->time;
    if (isfinite(l->sum - l->sum_rule))
        l->standard_errors[l->count - 1] = hypot(l->standard_errors[l->count - 1], l->sum - l->sum_rule);
}

/* From the eigenvalues. Directions that a lasting contact takes away are lost. */
static void take_rest(const saltus_motion *motion, saltus_lyapunov *l) {
    const double rounding = 1e-12; /* as saltus_eigenvalues_growing takes it */
    double largest = 0, sum = 0;
    for (int k = 0; k < motion->eigenvalue_count; k++) {
        largest = fmax(largest, hypot(motion->eigenvalues[k].re, motion->eigenvalues[k].im));
        sum += motion->eigenvalues[k].re;
    }
    for (int k = 0; k < l->count; k++) {
        const bool lost = k >= motion->eigenvalue_count;
        l->exponents[k] = lost ? -INFINITY : motion->eigenvalues[k].re;
        l->standard_errors[k] = lost ? 0 : rounding * largest;
    }
    l->lost = l->dimension - motion->eigenvalue_count;
    l->sum = l->count == l->dimension && !l->lost ? sum : NAN;
}

saltus_status saltus_motion_exponents(const saltus_system *system, const saltus_motion *motion,
                                      const saltus_flow_options *flow, int count, saltus_lyapunov *l,
                                      saltus_message *message) {
    const bool orbit = motion->periods > 0;
    const int all = orbit                 ? motion->multiplier_count + (motion->trivial_multiplier != 0)
                    : motion->eigenvalues ? motion->dimension
                                          : 0;
    *l = (saltus_lyapunov){0};
    if (count < 1 || count > all)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d exponents of a motion of period %d: there are %d",
                           count, motion->periods, all);
    if (!open_result(l, motion->dimension, count, 1)) {
        saltus_lyapunov_clear(l);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d exponents", count);
    }
    l->members = 0;
    l->sum = l->sum_rule = l->kaplan_yorke = l->independent = NAN;
    l->period = saltus_system_period(system);
    l->time = motion->periods * l->period;
    l->periods = motion->periods;
    l->agree = l->precise = true;
    memcpy(l->state, motion->state, (size_t)motion->dimension * sizeof *l->state);
    if (orbit) {
        l->impacts_per_period = motion->impacts < 0 ? INFINITY : (double)motion->impacts / motion->periods;
        l->sticks_per_period = (double)motion->sticking_intervals / motion->periods;
        take_orbit(motion, flow, l);
    } else
        take_rest(motion, l);
    l->half[0] = l->half[1] = l->exponents[0];
    return SALTUS_OK;
}
