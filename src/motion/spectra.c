/* Spectra of motions: sampling on the dense output at exact fractions of the forcing period.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/effort.h"
#include "motion/options.h"
#include "saltus/spectrum.h"

#include "signal/spectrum.h"
#include "system/system.h"

#include <gsl/gsl_integration.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    orbits_wanted = 8,
    orbit_periods_max = 512, /* a long orbit is sampled fewer times, to stay below this; at least twice */
    irregular_periods = 2048,
    segment_part = 16, /* a segment is this part of the periods */
    pilot_periods = 128,
    pilot_segment = 8,
    pilot_samples_max = 1 << 21, /* of one orbit */
    per_period_min = 256,
    per_period_exact = 2048, /* of orbits with corners: third derivatives then alias less than 1e-11 */
    per_period_max = 16384,
    irregular_per_period_max = 2048,
    step_points = 12 /* of Gauss-Legendre quadrature, in a step of the integrator */
};

static const double reach_of_lines = 32, reach_of_density = 16; /* times omega */
static const double rounding = 1e-12, rest_rounding = 1e-8;     /* of the scale of a quantity */

/* A first-order state, a weighted sum of positions or of velocities, or any quantity that a text observes. */
typedef struct observable {
    bool velocity;
    int entry; /* index in the state of a first-order state; -1: another quantity */
    int text;  /* index among those that the text observes, if it is no sum of positions; -1: another one */
    double weight[SALTUS_STATE_MAX];
    double scale;
} observable;

/* The tools for sampling; only the flows' positions change. */
typedef struct sampler {
    saltus_flow *flow, *probe; /* probe: evaluates the field just before an event */
    gsl_integration_glfixed_table *table;
    double period;
    int dof, quantities;
    observable quantity[SALTUS_QUANTITIES_MAX];
    double *observed; /* room for all that the text observes */
} sampler;

/* The samples of all quantities. */
typedef struct recording {
    int per_period;
    long long count;
    double *samples; /* per quantity `count` samples, then as many of a velocity's primitive */
    saltus_list corners[SALTUS_QUANTITIES_MAX];
    /* Time so far, and the integrals over it of each quantity minus its initial value, and of the square of
     * that. */
    double begin[SALTUS_QUANTITIES_MAX], time;
    saltus_sum integral[SALTUS_QUANTITIES_MAX], square[SALTUS_QUANTITIES_MAX];
} recording;

saltus_status saltus_quantity_parse(const saltus_system *system, const char *word, saltus_quantity *quantity,
                                    saltus_message *message) {
    int dof = saltus_system_dof(system);
    char names[SALTUS_NAMES_MAX];
    *quantity = (saltus_quantity){0, strcmp(word, "velocity") == 0};
    if (quantity->velocity || strcmp(word, "displacement") == 0)
        return SALTUS_OK;
    const int observed = saltus_system_observable_count(system),
              entry = saltus_system_state_index(system, word),
              place = entry < 0 ? saltus_system_observable_index(system, word) : -1;
    int length = 0;
    if (place >= 0) {
        quantity->coordinate = -1 - place;
        return SALTUS_OK;
    }
    if (entry < 0) {
        char also[200] = "";
        for (int k = 0; k < observed && length < (int)sizeof also; k++)
            length += snprintf(also + length, sizeof also - (size_t)length, ", %s",
                               saltus_system_observable_name(system, k));
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.40s: must be displacement, velocity, or one of %s%s",
                           word, saltus_system_list_names(system, saltus_system_dimension(system), names),
                           also);
    }
    *quantity = (saltus_quantity){(entry < dof ? entry : entry - dof) + 1, entry >= dof && entry < 2 * dof};
    return SALTUS_OK;
}

/* The index in the state of a quantity; not for the observed displacement or velocity. */
static int entry_of(const saltus_system *system, saltus_quantity quantity) {
    const int dof = saltus_system_dof(system), k = quantity.coordinate - 1;
    return quantity.velocity || k >= dof ? k + dof : k;
}

saltus_state_name saltus_quantity_name(const saltus_system *system, saltus_quantity quantity) {
    if (quantity.coordinate > 0)
        return saltus_system_state_name(system, entry_of(system, quantity));
    saltus_state_name name;
    snprintf(name.text, sizeof name.text, "%s",
             quantity.coordinate < 0 ? saltus_system_observable_name(system, -1 - quantity.coordinate)
             : quantity.velocity     ? "velocity"
                                     : "displacement");
    return name;
}

void saltus_spectra_clear(saltus_spectra *spectra) {
    for (int k = 0; k < SALTUS_QUANTITIES_MAX; k++)
        saltus_spectrum_clear(&spectra->spectra[k]);
    *spectra = (saltus_spectra){0};
}

static saltus_status open_sampler(sampler *s, const saltus_system *system,
                                  const saltus_spectrum_options *options, saltus_message *message) {
    const double *scale = saltus_system_scale(system), *observer = saltus_system_observer(system);
    const int dof = saltus_system_dof(system);
    *s = (sampler){.quantities = options->quantity_count, .dof = dof, .period = saltus_system_period(system)};
    s->observed = malloc((size_t)(saltus_system_observable_count(system) + 1) * sizeof *s->observed);
    if (!s->observed)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a spectrum");
    for (int k = 0; k < s->quantities; k++) {
        const saltus_quantity *wanted = &options->quantities[k];
        observable *quantity = &s->quantity[k];
        quantity->velocity = wanted->velocity;
        quantity->entry = wanted->coordinate > dof ? entry_of(system, *wanted) : -1;
        quantity->text = -1;
        if (quantity->entry >= 0)
            quantity->scale = scale[quantity->entry];
        else if (wanted->coordinate < 0) {
            const int observed = -1 - wanted->coordinate;
            if (!system->spec.model->observable_row(system, observed, quantity->weight)) {
                /* No sum of positions. Its size is not known: at a state of the usual size. */
                memset(quantity->weight, 0, sizeof quantity->weight);
                saltus_system_observe(system, scale, 0, s->observed);
                quantity->text = observed;
                quantity->scale = isfinite(s->observed[observed]) ? fabs(s->observed[observed]) : 0;
            }
        } else if (wanted->coordinate > 0)
            quantity->weight[wanted->coordinate - 1] = 1;
        else
            memcpy(quantity->weight, observer, (size_t)dof * sizeof *observer);
        for (int i = 0; i < dof; i++)
            quantity->scale += fabs(quantity->weight[i]) * scale[(wanted->velocity ? dof : 0) + i];
    }
    s->table = gsl_integration_glfixed_table_alloc(step_points);
    saltus_status status = s->table ? saltus_flow_single(system, 0, &options->flow, &s->flow, message)
                                    : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a spectrum");
    return status == SALTUS_OK ? saltus_flow_single(system, 0, &options->flow, &s->probe, message) : status;
}

static void clear_recording(recording *r) {
    free(r->samples);
    for (int k = 0; k < SALTUS_QUANTITIES_MAX; k++)
        free(r->corners[k].items);
}

/* The weighted sum of quantity k, of positions or of velocities. */
static double weigh(const sampler *s, int k, const double *numbers) {
    double value = 0;
    for (int i = 0; i < s->dof; i++)
        value += s->quantity[k].weight[i] * numbers[i];
    return value;
}

static double quantity_of(const sampler *s, int k, double phase, const double *state) {
    const observable *quantity = &s->quantity[k];
    if (quantity->text >= 0) {
        saltus_system_observe(saltus_flow_system(s->flow, 0), state, phase, s->observed);
        return s->observed[quantity->text];
    }
    return quantity->entry >= 0 ? state[quantity->entry]
                                : weigh(s, k, quantity->velocity ? state + s->dof : state);
}

static void take_sample(const sampler *s, recording *r, long long number, const double *state) {
    for (int k = 0; k < s->quantities; k++) {
        double *sample = r->samples + 2 * k * r->count + number;
        *sample = quantity_of(s, k, (double)(number % r->per_period) / r->per_period, state);
        if (s->quantity[k].velocity)
            sample[r->count] = weigh(s, k, state) / s->period;
    }
}

/* Add the flow's last step to the integrals. Steps end at events, so the integrand is smooth and jumps,
 * which disturb samples, do no harm here. */
static void integrate(const sampler *s, recording *r) {
    const double length = saltus_flow_step_length(s->flow, 0), end = saltus_flow_time(s->flow, 0).phase;
    r->time += length;
    for (size_t point = 0; point < step_points; point++) {
        double at, weight, state[SALTUS_STATE_MAX];
        gsl_integration_glfixed_point(0, length, point, &at, &weight, s->table);
        saltus_flow_dense(s->flow, 0, at, state);
        const double phase = end - (length - at) / s->period;
        for (int k = 0; k < s->quantities; k++) {
            double value = quantity_of(s, k, phase - floor(phase), state) - r->begin[k];
            saltus_sum_add(&r->integral[k], weight * value);
            saltus_sum_add(&r->square[k], weight * value * value);
        }
    }
}

/* Record an event as a corner: of displacements by the jumps of velocity and acceleration, of first-order
 * states by the jump of their rate. `contacts` are those held before the event. */
static saltus_status take_corner(const sampler *s, recording *r, unsigned contacts, saltus_message *message) {
    const int dof = s->dof;
    saltus_time now = saltus_flow_time(s->flow, 0);
    double before[SALTUS_STATE_MAX], after[SALTUS_STATE_MAX],
        rate_before[SALTUS_STATE_MAX] = {0}, rate[SALTUS_STATE_MAX] = {0}, jump[SALTUS_STATE_MAX],
        bend[SALTUS_STATE_MAX];
    saltus_flow_state_at(s->flow, 0, now, before);
    saltus_flow_state(s->flow, 0, after);
    saltus_status status = saltus_flow_place(s->probe, 0, now, before, contacts, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_field(s->probe, 0, rate_before);
    saltus_flow_field(s->flow, 0, rate);
    for (int i = 0; i < dof; i++) {
        jump[i] = after[dof + i] - before[dof + i];
        bend[i] = rate[dof + i] - rate_before[dof + i];
    }
    for (int k = 0; k < s->quantities; k++) {
        const int entry = s->quantity[k].entry;
        if (s->quantity[k].text >= 0)
            continue;
        const double unit = s->quantity[k].velocity ? 1 : s->period;
        saltus_corner *corner = saltus_list_add(&r->corners[k], sizeof *corner);
        if (!corner)
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the corners of a motion");
        *corner = (saltus_corner){.time = saltus_time_periods(now),
                                  .slope = entry >= 0 ? s->period * (rate[entry] - rate_before[entry])
                                                      : unit * weigh(s, k, jump),
                                  .bend = unit * s->period * weigh(s, k, bend)};
    }
    return SALTUS_OK;
}

/* Sample `periods` forcing periods, starting anew from the same state, at phase 0, for each `stretch` of
 * them. The recording is to be cleared. */
static saltus_status sample(const sampler *s, const double *state, long long periods, long long stretch,
                            int per_period, recording *r, saltus_message *message) {
    enum { watch = SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT };
    *r = (recording){.per_period = per_period, .count = periods * per_period};
    r->samples = calloc(2 * (size_t)s->quantities * (size_t)r->count, sizeof *r->samples);
    if (!r->samples)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %lld samples", r->count);
    saltus_status status = SALTUS_OK;
    for (long long done = 0; status == SALTUS_OK && done + stretch <= periods; done += stretch) {
        const long long end = (done + stretch) * per_period;
        long long next = done * per_period;
        saltus_event event = {.kind = SALTUS_STEP};
        double now[SALTUS_STATE_MAX];
        status = saltus_flow_start(s->flow, 0, (saltus_time){done, 0}, state, message);
        if (status != SALTUS_OK)
            break;
        saltus_flow_state(s->flow, 0, now);
        for (int k = 0; k < s->quantities && next == 0; k++)
            r->begin[k] = quantity_of(s, k, 0, now);
        take_sample(s, r, next++, now);
        long long steps = saltus_flow_information(s->flow, 0).steps;
        while (status == SALTUS_OK && event.kind != SALTUS_REACHED) {
            const unsigned contacts = saltus_flow_contacts(s->flow, 0);
            status = saltus_flow_advance(s->flow, (saltus_time){done + stretch, 0}, watch, &event, message);
            if (status != SALTUS_OK)
                break;
            const long long made = saltus_flow_information(s->flow, 0).steps;
            if (made != steps)
                integrate(s, r);
            steps = made;
            for (; next < end; next++) {
                const saltus_time time = {next / per_period, (double)(next % per_period) / per_period};
                if (saltus_flow_state_at(s->flow, 0, time, now) > 0)
                    break;
                take_sample(s, r, next, now);
            }
            if (1u << event.kind & SALTUS_WATCH_CONTACT)
                status = take_corner(s, r, contacts, message);
        }
    }
    return status;
}

static saltus_signal signal_of(const sampler *s, const recording *r, int k, bool resting) {
    const double *samples = r->samples + 2 * k * r->count, mean = saltus_sum_of(r->integral[k]) / r->time;
    return (saltus_signal){.samples = samples,
                           .primitive = s->quantity[k].velocity ? samples + r->count : NULL,
                           .variance = fmax(saltus_sum_of(r->square[k]) / r->time - mean * mean, 0),
                           .corners = r->corners[k].items,
                           .corner_count = r->corners[k].count,
                           .count = r->count,
                           .per_period = r->per_period,
                           .rounding = s->quantity[k].scale * (resting ? rest_rounding : rounding)};
}

/* Choose the smallest number of samples per period with spectra that are trustworthy up to the wanted
 * frequency, by trial on a densely sampled pilot: one orbit, or some periods of a motion without one. */
static saltus_status choose_samples(const sampler *s, const double *state, int orbit,
                                    const saltus_spectrum_options *options, int *per_period,
                                    saltus_message *message) {
    const int periods = orbit ? orbit : pilot_periods;
    int most = orbit ? per_period_max : irregular_per_period_max;
    double reach = options->reach > 0 ? options->reach : orbit ? reach_of_lines : reach_of_density;
    recording pilot;
    while (orbit && most > per_period_min && (long long)most * orbit > pilot_samples_max)
        most /= 2;
    saltus_status status = sample(s, state, periods, periods, most, &pilot, message);
    *per_period =
        orbit && pilot.corners[0].count > 0 && most > per_period_exact ? per_period_exact : per_period_min;
    double *thinned = malloc(2 * (size_t)pilot.count * sizeof *thinned);
    if (status == SALTUS_OK && !thinned)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a spectrum");
    for (int k = 0; k < s->quantities && status == SALTUS_OK; k++)
        for (;; *per_period *= 2) {
            const saltus_signal dense = signal_of(s, &pilot, k, options->resting),
                                thin = saltus_signal_thinned(&dense, most / *per_period, thinned);
            saltus_spectrum spectrum = {0};
            status = orbit ? saltus_signal_orbits(&thin, orbit, &spectrum, message)
                           : saltus_signal_density(&thin, pilot_segment, 0.95, &spectrum, message);
            const bool trusted = spectrum.kind == SALTUS_SPECTRUM_CONSTANT || spectrum.trustworthy >= reach;
            saltus_spectrum_clear(&spectrum);
            if (status != SALTUS_OK || trusted || *per_period == most)
                break;
        }
    free(thinned);
    clear_recording(&pilot);
    return status;
}

static saltus_status check_options(const saltus_system *system, int periods, const saltus_spectrum_options *o,
                                   saltus_message *message) {
    if (o->quantity_count < 1 || o->quantity_count > SALTUS_QUANTITIES_MAX)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d quantities: must be 1 to %d", o->quantity_count,
                           SALTUS_QUANTITIES_MAX);
    const int most = saltus_system_dimension(system) - saltus_system_dof(system);
    for (int k = 0; k < o->quantity_count; k++)
        if (o->quantities[k].coordinate < -saltus_system_observable_count(system) ||
            o->quantities[k].coordinate > most ||
            (o->quantities[k].coordinate < 0 && o->quantities[k].velocity))
            return saltus_fail(message, SALTUS_BAD_INPUT, "coordinate %d: must be %d to %d",
                               o->quantities[k].coordinate, -saltus_system_observable_count(system), most);
    if (o->per_period % 4)
        return saltus_fail(message, SALTUS_BAD_INPUT, "per_period = %d: must be a multiple of 4",
                           o->per_period);
    if (periods < 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "periods = %d: must be at least 0", periods);
    return saltus_options_check(&saltus_spectrum_table, o, message);
}

/* Periods to analyse, and the length of Welch's segments: 0 for whole orbits. */
static saltus_status plan_lengths(int orbit, const saltus_spectrum_options *o, long long *periods,
                                  long long *segment, saltus_message *message) {
    bool whole = orbit > 0 && o->segment == 0;
    *periods = o->periods ? o->periods : irregular_periods;
    *segment = o->segment ? o->segment : *periods / segment_part > 1 ? *periods / segment_part : 1;
    if (whole) {
        int orbits = orbit_periods_max / orbit;
        orbits = orbits > orbits_wanted ? orbits_wanted : orbits < 2 ? 2 : orbits;
        *periods = o->periods ? o->periods / orbit * orbit : (long long)orbits * orbit;
        *segment = 0;
        if (*periods < 2LL * orbit)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "periods = %lld: the motion's period is %d T, two orbits take %d", o->periods,
                               orbit, 2 * orbit);
    }
    if (*segment > *periods)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "segment = %lld: must not be longer than the %lld periods analysed", *segment,
                           *periods);
    if (*periods > SALTUS_SAMPLES_MAX / (o->per_period ? o->per_period : per_period_min))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%lld periods with %d%s samples each: must be %d samples together at most",
                           *periods, o->per_period ? o->per_period : per_period_min,
                           o->per_period ? "" : " or more", SALTUS_SAMPLES_MAX);
    return SALTUS_OK;
}

saltus_status saltus_spectra_run(const saltus_system *system, const double *state, int periods,
                                 const saltus_spectrum_options *options, saltus_spectra *spectra,
                                 saltus_message *message) {
    *spectra = (saltus_spectra){.count = options->quantity_count, .periods = periods};
    long long length = 0, segment = 0;
    int per_period = options->per_period;
    sampler with = {.flow = NULL};
    recording record = {.samples = NULL};
    saltus_spectrum_options how = *options;
    saltus_effort effort;
    how.flow = saltus_effort_begin(&options->flow, system, &effort);
    saltus_status status = check_options(system, periods, options, message);
    if (status == SALTUS_OK)
        status = plan_lengths(periods, options, &length, &segment, message);
    if (status == SALTUS_OK)
        status = open_sampler(&with, system, &how, message);
    if (status == SALTUS_OK && per_period == 0)
        status = choose_samples(&with, state, segment ? 0 : periods, options, &per_period, message);
    while (options->per_period == 0 && per_period > per_period_min &&
           length > SALTUS_SAMPLES_MAX / per_period)
        per_period /= 2;
    if (status == SALTUS_OK)
        status = sample(&with, state, length, options->anew && periods > 0 ? periods : length, per_period,
                        &record, message);
    for (int k = 0; k < with.quantities && status == SALTUS_OK; k++) {
        saltus_signal signal = signal_of(&with, &record, k, options->resting);
        saltus_spectrum *spectrum = &spectra->spectra[k];
        status = segment ? saltus_signal_welch(&signal, segment, options->confidence, spectrum, message)
                         : saltus_signal_orbits(&signal, periods, spectrum, message);
    }
    clear_recording(&record);
    free(with.observed);
    saltus_flow_free(with.flow);
    saltus_flow_free(with.probe);
    if (with.table)
        gsl_integration_glfixed_table_free(with.table);
    if (status != SALTUS_OK) {
        saltus_spectra_clear(spectra);
        return status;
    }
    memcpy(spectra->quantities, options->quantities, sizeof spectra->quantities);
    spectra->analysed = length;
    spectra->per_period = per_period;
    return SALTUS_OK;
}

saltus_status saltus_motion_spectra(const saltus_system *system, const saltus_motion *motion,
                                    const saltus_spectrum_options *options, saltus_spectra *spectra,
                                    saltus_message *message) {
    saltus_spectrum_options fitting = *options;
    bool rests =
        motion->verdict == SALTUS_EQUILIBRIUM || (motion->verdict == SALTUS_HELD && motion->periods == 0);
    bool closed = motion->verdict == SALTUS_PERIODIC || motion->verdict == SALTUS_HELD;
    int periods = rests ? 1 : closed ? motion->periods : 0;
    fitting.resting = options->resting || rests;
    fitting.anew = options->anew || (closed && !motion->stable);
    return saltus_spectra_run(system, motion->state, periods, &fitting, spectra, message);
}
