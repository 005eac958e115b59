/* Several trajectories on one attractor measure its exponents together, in the lanes of flows. They start
 * from one trajectory, at times so far apart that each diverges from it before it would repeat what another
 * has measured.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/ensemble.h"

#include "base/progress.h"
#include "orbit/multipliers.h"
#include "system/state.h"
#include "system/system.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    align_samples = 50,  /* for random directions to turn into those that grow */
    most_aligned = 1000, /* for members to diverge from the trajectory that they start on */
    report_cycles = 64   /* of the transient, between reports of progress */
};
static const double disturbance = 1e-6, strangers = 17; /* e^17 times the disturbance exceeds the attractor */
/* Members whose scatter has a smaller probability are not on the same motion. */
static const double unlikely = 1e-4;
static const double bounds_apart = 6; /* for regular motions, whose errors are roughly bounds */

/* The order of the series, 0: the usual one. Where fast modes ring on for a hundred radians in a period,
 * longer steps of a higher order are cheaper by a fifth. */
static int order_for(const saltus_system *system, const saltus_flow_options *options) {
    enum { higher = 18 };
    static const double many_turns = 90, coarse = 1e-11; /* finer tolerances have a higher order anyway */
    double ringing = 0;
    for (int i = 0; i < system->dof; i++)
        ringing = fmax(ringing, sqrt(system->stiffness[i]) - 0.5 * system->damping[i]);
    const bool usual = options->order || options->rtol < coarse || ringing * system->period < many_turns;
    return usual ? options->order : higher;
}

saltus_status saltus_ensemble_open(saltus_ensemble *e, const saltus_system *system,
                                   const saltus_lyapunov_options *options, long long room,
                                   saltus_message *message) {
    *e = (saltus_ensemble){.system = system,
                           .options = options,
                           .n = saltus_system_dimension(system),
                           .members = options->members,
                           .room = room,
                           .width = saltus_flow_width(system, options->flow.integrator, options->members)};
    const size_t places = (size_t)e->members * (size_t)room;
    e->columns = options->exponents ? options->exponents : e->n;
    e->table = gsl_integration_glfixed_table_alloc(SALTUS_TRACE_POINTS);
    e->points = room ? calloc(places * (size_t)e->n, sizeof *e->points) : NULL;
    e->growths = room ? calloc(places, sizeof *e->growths) : NULL;
    do {
        for (int m = 0; m < e->members; m++) {
            saltus_member *self = &e->member[m];
            saltus_growth_reserve(&self->growth, &e->arena, e->n, e->columns);
            self->state = saltus_arena_doubles(&e->arena, (size_t)e->n);
            self->averages = (saltus_average *)(void *)saltus_arena_doubles(
                &e->arena, (size_t)(e->columns + 1) * sizeof *self->averages / sizeof(double));
        }
    } while (saltus_arena_again(&e->arena));
    if (!e->table || !e->arena.base || (room && !(e->points && e->growths))) {
        saltus_ensemble_close(e);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the exponents of %d trajectories",
                           options->members);
    }
    saltus_random_seed(&e->random, options->seed);
    const saltus_system *systems[SALTUS_MEMBERS_MAX];
    saltus_flow_options flow = options->flow;
    saltus_status status = SALTUS_OK;
    flow.order = order_for(system, &options->flow);
    flow.columns = e->columns;
    flow.directions = 0;
    for (int m = 0; m < e->members; m++) {
        systems[m] = system;
        saltus_growth_choose(&e->member[m].growth, system, options->interval, e->table);
    }
    for (int first = 0; first < e->members && status == SALTUS_OK; first += e->width) {
        int lanes = e->members - first < e->width ? e->members - first : e->width;
        saltus_flow **opened = &e->flows[e->flow_count++];
        status = saltus_flow_new(systems, lanes, &flow, opened, message);
        for (int l = 0; l < lanes; l++) {
            e->member[first + l].flow = *opened;
            e->member[first + l].lane = l;
        }
    }
    if (status != SALTUS_OK)
        saltus_ensemble_close(e);
    return status;
}

void saltus_ensemble_close(saltus_ensemble *e) {
    for (int f = 0; f < e->flow_count; f++)
        saltus_flow_free(e->flows[f]);
    if (e->table)
        gsl_integration_glfixed_table_free(e->table);
    saltus_arena_close(&e->arena);
    free(e->points);
    free(e->growths);
    *e = (saltus_ensemble){0};
}

/* One trajectory runs the transient. The members start from its states, evenly spaced over the second half;
 * the first member starts from the end. */
static saltus_status run_transient(saltus_ensemble *e, const double *initial, saltus_message *message) {
    const saltus_lyapunov_options *o = e->options;
    const long long spread = o->transient / 2;
    long long now = 0;
    saltus_flow *flow = NULL;
    saltus_event event;
    saltus_status status = saltus_flow_single(e->system, 0, &o->flow, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, initial, message);
    for (int m = e->members - 1; m >= 0 && status == SALTUS_OK; m--) {
        const long long place = o->transient - spread * m / e->members;
        double *state = e->member[m].state;
        saltus_flow_state(flow, 0, state);
        while (status == SALTUS_OK && now < place && !e->stopped) {
            if (now % report_cycles == 0)
                saltus_progress_show(o->progress, 0, (double)o->periods);
            e->stopped = saltus_stop_asked(e->stop);
            status = saltus_flow_advance(flow, (saltus_time){++now, 0}, 0, &event, message);
            saltus_flow_state(flow, 0, state);
            if (status == SALTUS_OK)
                status = saltus_state_bounded(e->system, state, saltus_flow_contacts(flow, 0), now, message);
        }
    }
    /* A transient that was stopped counts as far as it went. */
    e->transient = e->stopped ? now : o->transient;
    saltus_flow_free(flow);
    return status;
}

/* Start the members from their states, all but the first disturbed if asked for. Run until the tangent
 * vectors are aligned and, if neighbours separate, until the members have diverged from the trajectory that
 * they start on, which each would otherwise retrace. */
static saltus_status start(saltus_ensemble *e, bool disturbed, saltus_message *message) {
    double least, grown[SALTUS_MEMBERS_MAX] = {0};
    saltus_status status = SALTUS_OK;
    for (int m = 0; m < e->members && status == SALTUS_OK; m++) {
        saltus_member *self = &e->member[m];
        if (m > 0 && disturbed)
            saltus_state_disturb(e->system, saltus_random_rng(&e->random), disturbance, 0, self->state);
        status = saltus_flow_start(self->flow, self->lane, (saltus_time){0, 0}, self->state, message);
        if (status == SALTUS_OK)
            saltus_growth_begin(&self->growth, self->flow, self->lane, saltus_random_rng(&e->random));
    }
    for (bool again = true; status == SALTUS_OK && again;
         again = e->members > 1 && least > 1 && least < strangers && e->member[0].samples < most_aligned) {
        status = saltus_ensemble_run(e, align_samples / e->member[0].growth.whole + 1, message);
        least = INFINITY;
        for (int m = 0; m < e->members; m++)
            least = fmin(least, grown[m] += e->member[m].recent);
    }
    e->measures = true;
    saltus_ensemble_forget(e);
    return status;
}

saltus_status saltus_ensemble_place(saltus_ensemble *e, const double *state, saltus_message *message) {
    double initial[SALTUS_STATE_MAX];
    memcpy(initial, state, (size_t)e->n * sizeof *state);
    if (e->options->seed)
        saltus_state_disturb(e->system, saltus_random_rng(&e->random), disturbance, 0, initial);
    saltus_status status = run_transient(e, initial, message);
    return status == SALTUS_OK ? start(e, true, message) : status;
}

saltus_status saltus_ensemble_begin(saltus_ensemble *e, const double *states, saltus_message *message) {
    for (int m = 0; m < e->members; m++)
        memcpy(e->member[m].state, states + m * e->n, (size_t)e->n * sizeof *states);
    return start(e, false, message);
}

saltus_status saltus_ensemble_ahead(const saltus_ensemble *e, long long samples, double *states,
                                    double *points, saltus_message *message) {
    const saltus_system *systems[SALTUS_MEMBERS_MAX];
    const int whole = e->member[0].growth.whole;
    const long long periods = samples * whole;
    saltus_flow_options options = e->options->flow;
    saltus_status status = SALTUS_OK;
    options.order = order_for(e->system, &options);
    for (int m = 0; m < e->members; m++) {
        systems[m] = e->system;
        memcpy(states + m * e->n, e->member[m].state, (size_t)e->n * sizeof *states);
    }
    for (int first = 0; first < e->members && status == SALTUS_OK; first += e->width) {
        const int lanes = e->members - first < e->width ? e->members - first : e->width;
        int left = lanes, lane;
        saltus_event event;
        saltus_flow *flow = NULL;
        status = saltus_flow_new(systems, lanes, &options, &flow, message);
        for (int l = 0; l < lanes && status == SALTUS_OK; l++) {
            status = saltus_flow_start(flow, l, (saltus_time){0, 0}, states + (first + l) * e->n, message);
            saltus_flow_aim(flow, l, (saltus_time){first + l ? periods : whole, 0}, 0);
        }
        while (left > 0 && status == SALTUS_OK) {
            status = saltus_flow_run(flow, &lane, &event, message);
            if (status != SALTUS_OK)
                break;
            const long long now = saltus_flow_time(flow, lane).cycle;
            double *state = states + (first + lane) * e->n;
            saltus_flow_state(flow, lane, state);
            /* The lane of the first of all stops for each of its section points. */
            if (first + lane == 0)
                memcpy(points + (now / whole - 1) * e->n, state, (size_t)e->n * sizeof *points);
            if (now < periods)
                saltus_flow_aim(flow, lane, (saltus_time){now + whole, 0}, 0);
            else
                left--;
            status = saltus_state_bounded(e->system, state, saltus_flow_contacts(flow, lane), now, message);
        }
        saltus_flow_free(flow);
    }
    return status;
}

saltus_status saltus_ensemble_run(saltus_ensemble *e, long long samples, saltus_message *message) {
    static const double patience = 2; /* seconds */
    const long long goal = e->member[0].samples + samples;
    const bool fruitless = !e->measures || e->member[0].samples == 0;
    for (int m = 0; m < e->members; m++)
        e->member[m].recent = 0;
    for (int f = 0; f < e->flow_count; f++) {
        saltus_flow *flow = e->flows[f];
        int first = f * e->width, left = 0;
        for (int m = first; m < e->members && m < first + e->width; m++, left++)
            saltus_growth_aim(&e->member[m].growth, flow, m - first);
        while (left > 0) {
            saltus_event event;
            int lane;
            bool complete;
            /* A run without any result so far is given up if it was asked to stop some time ago, and what is
             * missing does not come soon. */
            if (fruitless && saltus_stop_asked(e->stop) && e->asked == 0)
                e->asked = saltus_seconds();
            if (fruitless && saltus_stop_asked(e->stop) && saltus_seconds() - e->asked > patience)
                return saltus_fail(message, SALTUS_INTERRUPTED, "interrupted before the first result");
            saltus_status status = saltus_flow_run(flow, &lane, &event, message);
            saltus_member *self = &e->member[first + lane];
            if (status == SALTUS_OK)
                status = saltus_growth_follow(&self->growth, flow, lane, &event, &complete, message);
            if (status == SALTUS_OK && complete) {
                const saltus_flow_info now = saltus_flow_information(flow, lane);
                for (int c = 0; c < e->columns; c++)
                    saltus_average_add(&self->averages[c], self->growth.sample[c]);
                saltus_average_add(&self->averages[e->columns],
                                   self->growth.trace + now.log_volume - self->volume);
                self->volume = now.log_volume;
                self->recent += self->growth.sample[0];
                self->samples++;
                saltus_flow_state(flow, lane, self->state);
                if (self->samples <= e->room) {
                    const long long place = (first + lane) * e->room + self->samples - 1;
                    memcpy(e->points + place * e->n, self->state, (size_t)e->n * sizeof *self->state);
                    e->growths[place] = self->growth.sample[0];
                }
                status = saltus_state_bounded(e->system, self->state, saltus_flow_contacts(flow, lane),
                                              saltus_flow_time(flow, lane).cycle, message);
            }
            if (status != SALTUS_OK)
                return status;
            if (complete && self->samples >= goal)
                left--;
            else
                saltus_growth_aim(&self->growth, flow, lane);
        }
    }
    return SALTUS_OK;
}

void saltus_ensemble_forget(saltus_ensemble *e) {
    e->transient += e->member[0].samples * e->member[0].growth.whole;
    for (int m = 0; m < e->members; m++) {
        saltus_member *self = &e->member[m];
        memset(self->averages, 0, (size_t)(e->columns + 1) * sizeof *self->averages);
        self->samples = 0;
        self->begin = saltus_flow_information(self->flow, self->lane);
        self->volume = self->begin.log_volume;
    }
}

long long saltus_ensemble_periods(const saltus_ensemble *e) {
    return e->member[0].samples * e->member[0].growth.whole * e->members;
}

int saltus_ensemble_lost(const saltus_ensemble *e) {
    int lost = 0;
    for (int m = 0; m < e->members; m++)
        lost = e->member[m].growth.lost > lost ? e->member[m].growth.lost : lost;
    return lost < e->n ? lost : e->n;
}

bool saltus_ensemble_regular(const saltus_ensemble *e) {
    for (int m = 0; m < e->members; m++)
        if (!saltus_average_estimate(&e->member[m].averages[0]).weighted)
            return false;
    return true;
}

static saltus_estimate per_time(const saltus_ensemble *e, int m, saltus_estimate estimate) {
    const saltus_member *self = &e->member[m];
    long long steps = saltus_flow_information(self->flow, self->lane).steps - self->begin.steps;
    return saltus_growth_exponent(estimate, (double)steps / (double)self->samples, e->options->flow.rtol,
                                  self->growth.whole * saltus_system_period(e->system));
}

saltus_estimate saltus_ensemble_member(const saltus_ensemble *e, int member, int column, bool weighted) {
    const saltus_average *average = &e->member[member].averages[column];
    return per_time(e, member, weighted ? saltus_average_weighted(average) : saltus_average_plain(average));
}

saltus_estimate saltus_ensemble_exponent(const saltus_ensemble *e, int column, bool weighted) {
    saltus_estimate each[SALTUS_MEMBERS_MAX] = {{0}};
    for (int m = 0; m < e->members; m++)
        each[m] = saltus_ensemble_member(e, m, column, weighted);
    saltus_estimate joint = saltus_estimates_join(each, e->members);
    if (e->members == 1)
        return joint;
    /* The members' initial directions are random and independent. Errors that no single run shows appear in
     * the scatter of the members, for instance near a resonance, where vectors turn too slowly to be
     * noticed. A scatter far beyond the known errors is as skewed as the directions and does not average
     * out. */
    static const double far_beyond = 3;
    double square = 0;
    for (int m = 0; m < e->members; m++)
        square += (each[m].mean - joint.mean) * (each[m].mean - joint.mean);
    double scatter = sqrt(square / (e->members - 1)), averaged = scatter / sqrt(e->members);
    if (averaged > far_beyond * joint.standard_error)
        joint.standard_error = scatter;
    else if (weighted)
        joint.standard_error = fmax(joint.standard_error, averaged);
    return joint;
}

void saltus_ensemble_record(const saltus_ensemble *e, saltus_estimate now, saltus_lyapunov_progress *history,
                            int *count) {
    double time = (double)saltus_ensemble_periods(e) * saltus_system_period(e->system);
    if (!isfinite(now.standard_error))
        return;
    if (*count && history[*count - 1].time >= time)
        --*count;
    if (*count == SALTUS_HISTORY_ROOM) {
        *count /= 2;
        for (int k = 0; k < *count; k++)
            history[k] = history[2 * k + 1];
    }
    history[(*count)++] = (saltus_lyapunov_progress){time, now.mean, now.standard_error};
}

saltus_estimate saltus_ensemble_part(const saltus_ensemble *e, double from, double to) {
    saltus_estimate each[SALTUS_MEMBERS_MAX] = {{0}};
    for (int m = 0; m < e->members; m++)
        each[m] = per_time(e, m, saltus_average_part(&e->member[m].averages[0], from, to));
    return saltus_estimates_join(each, e->members);
}

saltus_estimate saltus_ensemble_largest(const saltus_ensemble *e) {
    saltus_estimate largest = saltus_ensemble_exponent(e, 0, saltus_ensemble_regular(e));
    if (!(largest.mean < 0 && isfinite(largest.mean) && isfinite(largest.standard_error)))
        return largest;
    /* A negative exponent has an additional error near a fold, where the orbit is approached as slowly as
     * tangent vectors shrink. The bias from this approach decays at the rate of the exponent, so the
     * difference of the run's halves gives the bias of the whole run. The flow's errors also shift the orbit,
     * and with it the exponent. The sum is limited to the exponent's own size: it adds nothing to an exponent
     * of zero. */
    double period = saltus_system_period(e->system), length = (double)saltus_ensemble_periods(e) / e->members;
    double share = -expm1(0.5 * largest.mean * period * length);
    double apart = fabs(saltus_ensemble_part(e, 0, 0.5).mean - saltus_ensemble_part(e, 0.5, 1).mean);
    double approach = 0.5 * apart * (2 - share) / share;
    double moved = 3 * fmax(e->options->flow.rtol, 1e-15) / -expm1(largest.mean * period) / period;
    double near_fold = fmin(hypot(approach, moved), -largest.mean);
    largest.standard_error = hypot(largest.standard_error, near_fold);
    return largest;
}

bool saltus_ensemble_agrees(const saltus_ensemble *e, double tolerance) {
    if (e->members == 1)
        return true;
    bool regular = saltus_ensemble_regular(e);
    double mean = saltus_ensemble_exponent(e, 0, false).mean, square = 0, farthest = 0, spread = 0;
    for (int m = 0; m < e->members; m++) {
        saltus_estimate one = saltus_ensemble_member(e, m, 0, false);
        double apart = fabs(one.mean - mean) / one.standard_error;
        square += apart * apart;
        farthest = fmax(farthest, apart);
    }
    if (regular ? farthest < bounds_apart : !(gsl_cdf_chisq_Q(square, e->members - 1) < unlikely))
        return true;
    mean = saltus_ensemble_exponent(e, 0, regular).mean;
    for (int m = 0; m < e->members; m++)
        spread = fmax(spread, fabs(saltus_ensemble_member(e, m, 0, regular).mean - mean));
    return spread <= tolerance;
}
