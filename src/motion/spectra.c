/* Spectra of motions: sampling on the dense output at exact fractions of the forcing period.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/options.h"
#include "saltus/spectrum.h"

#include "signal/spectrum.h"
#include "system/system.h"

#include <gsl/gsl_integration.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    orbits_wanted = 8,
    orbit_periods_max = 512, /* of long orbits fewer, so that these are not exceeded; two in any case */
    irregular_periods = 2048,
    segment_part = 16, /* of the periods is the length of a segment */
    pilot_periods = 128,
    pilot_segment = 8,
    pilot_samples_max = 1 << 21, /* of one orbit */
    per_period_min = 256,
    per_period_exact = 2048, /* of orbits with corners: what third derivatives alias is then below 1e-11 */
    per_period_max = 16384,
    irregular_per_period_max = 2048,
    step_points = 12 /* of Gauss and Legendre, in a step of the integrator */
};

static const double reach_of_lines = 32, reach_of_density = 16; /* times omega */
static const double rounding = 1e-12, rest_rounding = 1e-8;     /* of the scale of a quantity */

typedef struct sampler {
    saltus_flow *flow, *probe; /* probe: of what the field was before an event */
    double period;
    int quantities, dof;
    bool velocity[SALTUS_QUANTITIES_MAX];
    int extra[SALTUS_QUANTITIES_MAX]; /* the first-order state that the quantity is, as an entry; -1: none */
    double row[SALTUS_QUANTITIES_MAX][SALTUS_STATE_MAX]; /* times positions or velocities: the quantity */
    double scale[SALTUS_QUANTITIES_MAX];
    double *samples; /* quantities x (count, and as many of a velocity's primitive) */
    long long count, next;
    /* Each quantity less what it begins with, and the square of that, integrated over the steps until now. */
    gsl_integration_glfixed_table *table;
    double begin[SALTUS_QUANTITIES_MAX], time;
    saltus_sum integral[SALTUS_QUANTITIES_MAX], square[SALTUS_QUANTITIES_MAX];
    long long steps;
    saltus_corner *corners[SALTUS_QUANTITIES_MAX];
    long long corner_count, corner_room;
    int per_period;
    bool anew;
} sampler;

saltus_status saltus_quantity_parse(const saltus_system *system, const char *word, saltus_quantity *quantity,
                                    saltus_message *message) {
    int dof = saltus_system_dof(system);
    char names[SALTUS_NAMES_MAX];
    *quantity = (saltus_quantity){0, strcmp(word, "velocity") == 0};
    if (quantity->velocity || strcmp(word, "displacement") == 0)
        return SALTUS_OK;
    int entry = saltus_system_state_index(system, word);
    if (entry < 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.40s: must be displacement, velocity, or one of %s",
                           word, saltus_system_list_names(system, saltus_system_dimension(system), names));
    *quantity = (saltus_quantity){(entry < dof ? entry : entry - dof) + 1, entry >= dof && entry < 2 * dof};
    return SALTUS_OK;
}

/* The entry of the state that a quantity is, which must not be the observed one. */
static int entry_of(const saltus_system *system, saltus_quantity quantity) {
    const int dof = saltus_system_dof(system), k = quantity.coordinate - 1;
    return quantity.velocity || k >= dof ? k + dof : k;
}

saltus_state_name saltus_quantity_name(const saltus_system *system, saltus_quantity quantity) {
    if (quantity.coordinate > 0)
        return saltus_system_state_name(system, entry_of(system, quantity));
    saltus_state_name name;
    snprintf(name.text, sizeof name.text, "%s", quantity.velocity ? "velocity" : "displacement");
    return name;
}

void saltus_spectra_clear(saltus_spectra *spectra) {
    for (int k = 0; k < SALTUS_QUANTITIES_MAX; k++)
        saltus_spectrum_clear(&spectra->spectra[k]);
    *spectra = (saltus_spectra){0};
}

/* Sampling */

static saltus_status open_sampler(sampler *self, const saltus_system *system,
                                  const saltus_spectrum_options *options, saltus_message *message) {
    const double *scale = saltus_system_scale(system), *observer = saltus_system_observer(system);
    const int dof = saltus_system_dof(system);
    *self = (sampler){.quantities = options->quantity_count,
                      .dof = dof,
                      .period = saltus_system_period(system),
                      .anew = options->anew};
    for (int k = 0; k < self->quantities; k++) {
        const saltus_quantity *quantity = &options->quantities[k];
        self->velocity[k] = quantity->velocity;
        self->extra[k] = quantity->coordinate > dof ? entry_of(system, *quantity) : -1;
        if (self->extra[k] >= 0)
            self->scale[k] = scale[self->extra[k]];
        else if (quantity->coordinate > 0)
            self->row[k][quantity->coordinate - 1] = 1;
        else
            memcpy(self->row[k], observer, (size_t)dof * sizeof *self->row[k]);
        for (int i = 0; i < dof; i++)
            self->scale[k] += fabs(self->row[k][i]) * scale[(quantity->velocity ? dof : 0) + i];
    }
    self->table = gsl_integration_glfixed_table_alloc(step_points);
    saltus_status status = self->table ? saltus_flow_single(system, 0, &options->flow, &self->flow, message)
                                       : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a spectrum");
    return status == SALTUS_OK ? saltus_flow_single(system, 0, &options->flow, &self->probe, message)
                               : status;
}

static void close_sampler(sampler *self) {
    saltus_flow_free(self->flow);
    saltus_flow_free(self->probe);
    if (self->table)
        gsl_integration_glfixed_table_free(self->table);
    free(self->samples);
    for (int k = 0; k < SALTUS_QUANTITIES_MAX; k++)
        free(self->corners[k]);
}

/* Quantity k of positions or velocities. */
static double weigh(const sampler *self, int k, const double *numbers) {
    double value = 0;
    for (int i = 0; i < self->dof; i++)
        value += self->row[k][i] * numbers[i];
    return value;
}

static double quantity_of(const sampler *self, int k, const double *state) {
    return self->extra[k] >= 0 ? state[self->extra[k]]
                               : weigh(self, k, self->velocity[k] ? state + self->dof : state);
}

static void take_sample(sampler *self, const double *state) {
    for (int k = 0; k < self->quantities; k++) {
        double *sample = self->samples + 2 * k * self->count + self->next;
        *sample = quantity_of(self, k, state);
        if (self->velocity[k])
            sample[self->count] = weigh(self, k, state) / self->period;
    }
}

/* The flow's last step, if there was one, adds to the integrals. Between events everything is smooth, so that
 * jumps do not matter to these as they do to samples. */
static void integrate(sampler *self) {
    const double length = saltus_flow_step_length(self->flow, 0);
    const long long made = saltus_flow_information(self->flow, 0).steps;
    if (made == self->steps)
        return;
    self->steps = made;
    self->time += length;
    for (size_t point = 0; point < step_points; point++) {
        double at, weight, state[SALTUS_STATE_MAX];
        gsl_integration_glfixed_point(0, length, point, &at, &weight, self->table);
        saltus_flow_dense(self->flow, 0, at, state);
        for (int k = 0; k < self->quantities; k++) {
            double value = quantity_of(self, k, state) - self->begin[k];
            saltus_sum_add(&self->integral[k], weight * value);
            saltus_sum_add(&self->square[k], weight * value * value);
        }
    }
}

static double variance_of(const sampler *self, int k) {
    double mean = (self->integral[k].value + self->integral[k].rest) / self->time;
    return fmax((self->square[k].value + self->square[k].rest) / self->time - mean * mean, 0);
}

/* The samples in the flow's last step, up to sample `end`, which is not taken. */
static void take_samples(sampler *self, long long end) {
    double state[SALTUS_STATE_MAX];
    for (; self->next < end; self->next++) {
        saltus_time time = {self->next / self->per_period,
                            (double)(self->next % self->per_period) / self->per_period};
        int order = saltus_flow_state_at(self->flow, 0, time, state);
        if (order > 0)
            return;
        take_sample(self, state);
    }
}

static bool make_room_for_corner(sampler *self) {
    if (self->corner_count < self->corner_room)
        return true;
    long long room = self->corner_room ? 2 * self->corner_room : 64;
    for (int k = 0; k < self->quantities; k++) {
        saltus_corner *larger = realloc(self->corners[k], (size_t)room * sizeof *larger);
        if (!larger)
            return false;
        self->corners[k] = larger;
    }
    self->corner_room = room;
    return true;
}

/* An event is a corner of every displacement: what velocities and accelerations gain at it, the contacts
 * before it given; and of every first-order state, whose rate gains. */
static saltus_status take_corner(sampler *self, unsigned contacts, saltus_message *message) {
    saltus_time now = saltus_flow_time(self->flow, 0);
    double before[SALTUS_STATE_MAX], after[SALTUS_STATE_MAX],
        field[SALTUS_STATE_MAX] = {0}, gain[2][SALTUS_STATE_MAX], rate[SALTUS_STATE_MAX];
    saltus_flow_state_at(self->flow, 0, now, before);
    saltus_flow_state(self->flow, 0, after);
    saltus_status status = saltus_flow_place(self->probe, 0, now, before, contacts, message);
    if (status == SALTUS_OK && !make_room_for_corner(self))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the corners of a motion");
    if (status != SALTUS_OK)
        return status;
    saltus_flow_field(self->probe, 0, field);
    memcpy(rate, field, sizeof rate);
    for (int i = 0; i < self->dof; i++) {
        gain[0][i] = after[self->dof + i] - before[self->dof + i];
        gain[1][i] = -field[self->dof + i];
    }
    saltus_flow_field(self->flow, 0, field);
    for (int i = 0; i < self->dof; i++)
        gain[1][i] += field[self->dof + i];
    for (int k = 0; k < self->quantities; k++) {
        double unit = self->velocity[k] ? 1 : self->period;
        self->corners[k][self->corner_count] =
            (saltus_corner){.time = saltus_time_periods(now),
                            .slope = unit * weigh(self, k, gain[0]),
                            .bend = unit * self->period * weigh(self, k, gain[1])};
        if (self->extra[k] >= 0)
            self->corners[k][self->corner_count].slope =
                self->period * (field[self->extra[k]] - rate[self->extra[k]]);
    }
    self->corner_count++;
    return SALTUS_OK;
}

/* Sample from a state at phase 0, from sample `next` to sample `end`. */
static saltus_status run_stretch(sampler *self, const double *state, long long end, saltus_message *message) {
    enum { watch = SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT };
    saltus_time start = {self->next / self->per_period, 0}, until = {end / self->per_period, 0};
    saltus_event event = {.kind = SALTUS_STEP};
    saltus_status status = saltus_flow_start(self->flow, 0, start, state, message);
    if (status == SALTUS_OK) {
        double now[SALTUS_STATE_MAX];
        saltus_flow_state(self->flow, 0, now);
        for (int k = 0; k < self->quantities && self->next == 0; k++)
            self->begin[k] = quantity_of(self, k, now);
        self->steps = saltus_flow_information(self->flow, 0).steps;
        take_sample(self, now);
        self->next++;
    }
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED) {
        unsigned contacts = saltus_flow_contacts(self->flow, 0);
        status = saltus_flow_advance(self->flow, until, watch, &event, message);
        if (status != SALTUS_OK)
            break;
        bool contact = 1u << event.kind & SALTUS_WATCH_CONTACT;
        integrate(self);
        take_samples(self, end);
        if (contact)
            status = take_corner(self, contacts, message);
    }
    return status;
}

/* Sample `periods` forcing periods; `orbit` > 0: an orbit's length, for starting it anew. */
static saltus_status sample(sampler *self, const double *state, long long periods, int orbit, int per_period,
                            saltus_message *message) {
    self->per_period = per_period;
    self->count = periods * per_period;
    self->next = 0;
    self->time = 0;
    memset(self->integral, 0, sizeof self->integral);
    memset(self->square, 0, sizeof self->square);
    free(self->samples);
    self->corner_count = 0;
    self->samples = calloc(2 * (size_t)self->quantities * (size_t)self->count, sizeof *self->samples);
    if (!self->samples)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %lld samples", self->count);
    long long stretch = self->anew && orbit > 0 ? (long long)orbit * per_period : self->count;
    saltus_status status = SALTUS_OK;
    for (long long end = stretch; status == SALTUS_OK && end <= self->count; end += stretch)
        status = run_stretch(self, state, end, message);
    return status;
}

static saltus_signal signal_of(const sampler *self, int k, bool resting) {
    const double *samples = self->samples + 2 * k * self->count;
    return (saltus_signal){.samples = samples,
                           .primitive = self->velocity[k] ? samples + self->count : NULL,
                           .variance = variance_of(self, k),
                           .corners = self->corners[k],
                           .corner_count = self->corner_count,
                           .count = self->count,
                           .per_period = self->per_period,
                           .rounding = self->scale[k] * (resting ? rest_rounding : rounding)};
}

/* How far the samples of a quantity, thinned out to `per_period`, can be trusted; INFINITY where nothing
 * moves. `samples` is overwritten. */
static saltus_status trust(saltus_signal signal, double *samples, int per_period, int orbit, double *upto,
                           saltus_message *message) {
    saltus_spectrum spectrum = {0};
    saltus_signal thinned = saltus_signal_thinned(&signal, signal.per_period / per_period, samples);
    saltus_status status = orbit ? saltus_signal_orbits(&thinned, orbit, &spectrum, message)
                                 : saltus_signal_density(&thinned, pilot_segment, 0.95, &spectrum, message);
    *upto = spectrum.kind == SALTUS_SPECTRUM_CONSTANT ? INFINITY : spectrum.trustworthy;
    saltus_spectrum_clear(&spectrum);
    return status;
}

/* As few samples a period as make the spectra trustworthy up to the wanted frequency, from one orbit or a few
 * periods with many samples. */
static saltus_status choose_samples(sampler *self, const double *state, int orbit,
                                    const saltus_spectrum_options *options, int *per_period,
                                    saltus_message *message) {
    int most = orbit ? per_period_max : irregular_per_period_max;
    double reach = options->reach > 0 ? options->reach : orbit ? reach_of_lines : reach_of_density;
    while (orbit && most > per_period_min && (long long)most * orbit > pilot_samples_max)
        most /= 2;
    saltus_status status = sample(self, state, orbit ? orbit : pilot_periods, 0, most, message);
    *per_period =
        orbit && self->corner_count > 0 && most > per_period_exact ? per_period_exact : per_period_min;
    double *thinned = malloc(2 * (size_t)self->count * sizeof *thinned);
    if (status == SALTUS_OK && !thinned)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a spectrum");
    for (int k = 0; k < self->quantities && status == SALTUS_OK; k++)
        for (double upto = 0; status == SALTUS_OK; *per_period *= 2) {
            status = trust(signal_of(self, k, options->resting), thinned, *per_period, orbit, &upto, message);
            if (status != SALTUS_OK || upto >= reach || *per_period == most)
                break;
        }
    free(thinned);
    return status;
}

/* Checks and lengths */

static saltus_status check_options(const saltus_system *system, int periods, const saltus_spectrum_options *o,
                                   saltus_message *message) {
    if (o->quantity_count < 1 || o->quantity_count > SALTUS_QUANTITIES_MAX)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d quantities: must be 1 to %d", o->quantity_count,
                           SALTUS_QUANTITIES_MAX);
    const int most = saltus_system_dimension(system) - saltus_system_dof(system);
    for (int k = 0; k < o->quantity_count; k++)
        if (o->quantities[k].coordinate < 0 || o->quantities[k].coordinate > most)
            return saltus_fail(message, SALTUS_BAD_INPUT, "coordinate %d: must be 0 to %d",
                               o->quantities[k].coordinate, most);
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
    sampler self = {.flow = NULL};
    saltus_status status = check_options(system, periods, options, message);
    if (status == SALTUS_OK)
        status = plan_lengths(periods, options, &length, &segment, message);
    if (status == SALTUS_OK)
        status = open_sampler(&self, system, options, message);
    if (status == SALTUS_OK && per_period == 0)
        status = choose_samples(&self, state, segment ? 0 : periods, options, &per_period, message);
    while (options->per_period == 0 && per_period > per_period_min &&
           length > SALTUS_SAMPLES_MAX / per_period)
        per_period /= 2;
    if (status == SALTUS_OK)
        status = sample(&self, state, length, periods, per_period, message);
    for (int k = 0; k < self.quantities && status == SALTUS_OK; k++) {
        saltus_signal signal = signal_of(&self, k, options->resting);
        saltus_spectrum *spectrum = &spectra->spectra[k];
        status = segment ? saltus_signal_welch(&signal, segment, options->confidence, spectrum, message)
                         : saltus_signal_orbits(&signal, periods, spectrum, message);
    }
    close_sampler(&self);
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
