/* The state from which a run can go on, as numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/archive.h"

#include "base/bits.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { periods_max = 10000000 };

void saltus_archive_real(saltus_archive *a, double *value) {
    if (a->reading) {
        a->sound = a->sound && a->at < a->count;
        *value = a->sound ? a->given[a->at++] : 0;
        return;
    }
    if (a->count == a->room && !a->starved) {
        size_t room = a->room ? 2 * a->room : 256;
        double *grown = realloc(a->made, room * sizeof *grown);
        a->starved = !grown;
        a->made = grown ? grown : a->made;
        a->room = grown ? room : a->room;
    }
    if (!a->starved)
        a->made[a->count++] = *value;
}

void saltus_archive_finite(saltus_archive *a, double *values, size_t count) {
    for (size_t k = 0; k < count; k++) {
        saltus_archive_real(a, &values[k]);
        if (a->reading && !isfinite(values[k])) {
            a->sound = false;
            values[k] = 0;
        }
    }
}

long long saltus_archive_whole(saltus_archive *a, long long value, long long low, long long high) {
    double number = (double)value;
    saltus_archive_real(a, &number);
    if (!a->reading)
        return value;
    a->sound = a->sound && number >= (double)low && number <= (double)high && number == floor(number);
    return a->sound ? (long long)number : low;
}

size_t saltus_archive_length(saltus_archive *a, size_t length, size_t each) {
    long long left = a->reading ? (long long)((a->count - a->at) / each) : LLONG_MAX;
    return (size_t)saltus_archive_whole(a, (long long)length, 0, left);
}

bool saltus_archive_flag(saltus_archive *a, bool value) {
    return saltus_archive_whole(a, value, 0, 1);
}

saltus_point_kind saltus_archive_kind(saltus_archive *a, saltus_point_kind kind, unsigned among) {
    kind = (saltus_point_kind)saltus_archive_whole(a, kind, 0, SALTUS_POINT_KINDS - 1);
    a->sound = a->sound && among >> kind & 1;
    return kind;
}

void saltus_archive_label(saltus_archive *a, char label[SALTUS_LABEL_MAX]) {
    int length = (int)saltus_archive_whole(a, (long long)strlen(label), 0, SALTUS_LABEL_MAX - 1);
    for (int k = 0; k < length; k++)
        label[k] = (char)saltus_archive_whole(a, label[k], 1, CHAR_MAX);
    label[length] = 0;
}

/* Check memory that reading has allocated; false without it. */
static bool found(saltus_archive *a, const void *memory) {
    a->starved = a->starved || !memory;
    a->sound = a->sound && memory;
    return a->sound;
}

void *saltus_archive_list(saltus_archive *a, void *things, int *count, size_t size, size_t each) {
    const size_t length = saltus_archive_length(a, (size_t)*count, each);
    if (!a->reading)
        return things;
    free(things);
    things = a->sound ? calloc(length + 1, size) : NULL;
    *count = a->sound && found(a, things) ? (int)length : 0;
    return things;
}

static saltus_event_kind event_kind(saltus_archive *a, saltus_event_kind kind) {
    kind = (saltus_event_kind)saltus_archive_whole(a, kind, 0, 64);
    a->sound = a->sound && (kind == SALTUS_IMPACT || kind == SALTUS_STICK || kind == SALTUS_RELEASE);
    return kind;
}

static int face_number(saltus_archive *a, int face) {
    return (int)saltus_archive_whole(a, face, 0, a->faces > 0 ? a->faces - 1 : 0);
}

/* A set of faces, as bits. */
static unsigned faces_held(saltus_archive *a, unsigned contacts) {
    return (unsigned)saltus_archive_whole(a, contacts, 0, (1LL << a->faces) - 1);
}

/* Check a time on an orbit; those of marks may lie slightly beyond its end. */
static void check_time(saltus_archive *a, const saltus_sequence *s, double time) {
    a->sound = a->sound && (!a->reading || (time >= -1 && time <= 2.0 * s->periods + 1));
}

static void orbit_time(saltus_archive *a, const saltus_sequence *s, double *time) {
    saltus_archive_finite(a, time, 1);
    check_time(a, s, *time);
}

void saltus_archive_sequence(saltus_archive *a, saltus_sequence *s) {
    s->periods = (int)saltus_archive_whole(a, s->periods, 1, periods_max);
    orbit_time(a, s, &s->base);
    s->contacts = faces_held(a, s->contacts);
    s->driven = saltus_archive_flag(a, s->driven);
    s->count = (int)saltus_archive_whole(a, s->count, 0, SALTUS_MARKS_MAX);
    for (int k = 0; k < s->count; k++) {
        s->mark[k].kind = event_kind(a, s->mark[k].kind);
        s->mark[k].face = face_number(a, s->mark[k].face);
        orbit_time(a, s, &s->mark[k].time);
        s->mark[k].driven = saltus_archive_flag(a, s->mark[k].driven);
    }
    s->cuts = (int)saltus_archive_whole(a, s->cuts, 1, SALTUS_CUTS_MAX);
    for (int k = 0; k < s->cuts; k++)
        orbit_time(a, s, &s->cut[k]);
    saltus_archive_finite(a, &s->omega, 1);
    if (s->omega > 0) {
        saltus_archive_finite(a, s->anchor, (size_t)a->n);
        saltus_archive_finite(a, s->across, (size_t)a->n);
        saltus_archive_finite(a, &s->speed, 1);
    }
}

void saltus_archive_scaled(saltus_archive *a, saltus_scaled *number) {
    saltus_archive_real(a, &number->mantissa);
    saltus_archive_real(a, &number->exponent);
}

void saltus_archive_point(saltus_archive *a, saltus_curve_point *point) {
    size_t unknowns = saltus_archive_length(a, (size_t)point->unknowns, 2);
    a->sound = a->sound && unknowns > 0;
    if (a->reading && (!a->sound || !saltus_curve_reserve(point, (int)unknowns))) {
        a->starved = a->starved || a->sound;
        a->sound = false;
        return;
    }
    saltus_archive_finite(a, point->u, unknowns);
    saltus_archive_finite(a, point->tangent, unknowns);
    point->bent = saltus_archive_flag(a, point->bent);
    if (point->bent)
        saltus_archive_finite(a, point->bend, 2 * unknowns);
    saltus_archive_finite(a, &point->ahead, 1);
    point->iterations = (int)saltus_archive_whole(a, point->iterations, 0, INT_MAX);
    saltus_archive_real(a, &point->residual);
    saltus_archive_scaled(a, &point->crossing);
}

static void archive_breach(saltus_archive *a, const saltus_sequence *s, saltus_breach *breach) {
    breach->kind = (saltus_breach_kind)saltus_archive_whole(a, breach->kind, 0, SALTUS_BREACH_HOLD);
    saltus_archive_real(a, &breach->value);
    breach->mark = (int)saltus_archive_whole(a, breach->mark, 0, s->count);
    breach->face = face_number(a, breach->face);
    saltus_archive_finite(a, &breach->time, 1);
}

static void archive_survey(saltus_archive *a, saltus_survey *survey) {
    saltus_lap *lap = &survey->lap;
    survey->follows = saltus_archive_flag(a, survey->follows);
    survey->walked = saltus_archive_flag(a, survey->walked);
    survey->impacts = saltus_archive_whole(a, survey->impacts, -1, 1LL << 50);
    survey->sticking_intervals = (int)saltus_archive_whole(a, survey->sticking_intervals, 0, INT_MAX);
    saltus_archive_label(a, survey->label);
    for (int i = 0; i < a->n && a->sound; i++) {
        saltus_archive_real(a, &survey->multipliers[i].re);
        saltus_archive_real(a, &survey->multipliers[i].im);
        saltus_archive_real(a, &survey->multipliers[i].log_modulus);
    }
    survey->multiplier_count = (int)saltus_archive_whole(a, survey->multiplier_count, 0, a->n);
    survey->unstable = (int)saltus_archive_whole(a, survey->unstable, -1, a->n);
    saltus_archive_real(a, &survey->trivial);
    saltus_archive_real(a, &survey->log_volume);
    saltus_archive_real(a, &survey->sum_rule);
    for (int k = 0; k < 3; k++) {
        saltus_archive_real(a, &survey->circle[k]);
        saltus_archive_real(a, &survey->past[k]);
    }
    saltus_archive_real(a, &survey->past_place);
    lap->keeps_events = true;
    lap->periods = (int)saltus_archive_whole(a, lap->periods, 0, periods_max);
    lap->contact_events = saltus_archive_whole(a, lap->contact_events, 0, 1LL << 50);
    lap->contacts = faces_held(a, lap->contacts);
    lap->events = saltus_archive_list(a, lap->events, &lap->event_count, sizeof *lap->events, 7);
    lap->event_room = a->reading ? lap->event_count : lap->event_room;
    for (int k = 0; k < lap->event_count; k++) {
        saltus_event *event = &lap->events[k];
        event->kind = event_kind(a, event->kind);
        event->face = face_number(a, event->face);
        event->time.cycle = saltus_archive_whole(a, event->time.cycle, -(1LL << 50), 1LL << 50);
        saltus_archive_finite(a, &event->time.phase, 1);
        saltus_archive_real(a, &event->velocity_before);
        saltus_archive_real(a, &event->velocity_after);
        saltus_archive_real(a, &event->displacement);
    }
    if (!saltus_archive_flag(a, lap->points != NULL))
        return;
    if (a->reading && a->sound && !saltus_lap_reserve(lap, 1, a->n))
        found(a, NULL);
    if (a->sound)
        saltus_archive_finite(a, lap->points, (size_t)a->n);
}

void saltus_archive_solution(saltus_archive *a, const saltus_orbits *o, saltus_solution *s) {
    saltus_archive_point(a, &s->at);
    a->sound = a->sound && (!a->reading || s->at.unknowns == o->equations->unknowns);
    if (a->reading && a->sound)
        saltus_shooting_extract(o->shooting, s->at.u, &s->sequence, s->state);
    for (int k = 0; k < s->sequence.count; k++)
        check_time(a, &s->sequence, s->sequence.mark[k].time);
    saltus_archive_finite(a, s->parameter, 2);
    saltus_archive_finite(a, &s->value, 1);
    saltus_archive_scaled(a, &s->flip);
    saltus_archive_real(a, &s->onward);
    saltus_archive_real(a, &s->speed);
    saltus_archive_real(a, &s->growth);
    saltus_archive_real(a, &s->grazes_ahead);
    s->breaches = saltus_archive_list(a, s->breaches, &s->breach_count, sizeof *s->breaches, 5);
    s->breach_room = a->reading ? s->breach_count : s->breach_room;
    for (int k = 0; k < s->breach_count; k++) {
        const saltus_breach *breach = &s->breaches[k];
        archive_breach(a, &s->sequence, &s->breaches[k]);
        const bool between = breach->kind == SALTUS_BREACH_GAP || breach->kind == SALTUS_BREACH_FORCE;
        a->sound = a->sound && (between || breach->mark < s->sequence.count);
    }
    archive_breach(a, &s->sequence, &s->worst);
    archive_survey(a, &s->survey);
}

saltus_status saltus_archive_rest(saltus_archive *a, saltus_rests *r, saltus_rest *rest,
                                  saltus_message *message) {
    const unsigned contacts = faces_held(a, r->contacts);
    const int held = saltus_count_bits(contacts);
    saltus_archive_point(a, &rest->at);
    saltus_archive_finite(a, rest->state, (size_t)a->n);
    a->sound = a->sound && rest->at.unknowns == r->width + held + r->family.parameters;
    if (!a->sound)
        return SALTUS_OK;
    saltus_status status = SALTUS_OK;
    if (a->reading)
        status = saltus_rests_shape(r, contacts, rest->state, rest->at.u + r->width + held, message);
    if (status != SALTUS_OK)
        return status;
    saltus_archive_finite(a, r->row_scale, (size_t)r->width);
    for (int i = 0; i < r->width; i++)
        a->sound = a->sound && r->row_scale[i] > 0;
    return a->reading && a->sound ? saltus_rest_see(r, rest, message) : SALTUS_OK;
}

void saltus_archive_orbits(saltus_archive *a, saltus_orbits *o) {
    if (o->options.free_period)
        saltus_archive_finite(a, &o->cocycle.wanted, 1);
}

void saltus_archive_shape(saltus_archive *a, saltus_shooting *shooting) {
    saltus_sequence sequence = shooting->sequence;
    saltus_archive_sequence(a, &sequence);
    if (!a->reading || !a->sound)
        return;
    saltus_status status = saltus_shooting_shape(shooting, &sequence, NULL);
    a->sound = status == SALTUS_OK;
    a->starved = a->starved || status == SALTUS_NO_MEMORY;
}

void saltus_archive_starts(saltus_archive *a, saltus_starts *starts) {
    enum { numbers_min = 18 }; /* per start */
    const unsigned kinds =
        saltus_orbit_loci | 1u << SALTUS_POINT_HB | 1u << SALTUS_POINT_BE | 1u << SALTUS_POINT_REGULAR;
    if (a->reading)
        saltus_starts_clear(starts);
    starts->begun = (int)saltus_archive_whole(a, starts->begun, 0, INT_MAX / 2);
    starts->start = saltus_archive_list(a, starts->start, &starts->count, sizeof *starts->start, numbers_min);
    for (int k = 0; k < starts->count; k++) {
        saltus_branch_start *start = &starts->start[k];
        saltus_archive_sequence(a, &start->sequence);
        saltus_archive_finite(a, start->parameter, 2);
        const bool lies = saltus_archive_flag(a, start->states > 0),
                   along = saltus_archive_flag(a, start->unknowns > 0);
        start->states = lies ? start->sequence.cuts * a->n : 0;
        start->unknowns = along ? saltus_sequence_unknowns(&start->sequence, a->n) + 1 : 0;
        const size_t numbers = (size_t)(start->states + start->unknowns);
        double *own = a->reading ? calloc(numbers + 1, sizeof *own) : (double *)start->state;
        start->state = own;
        start->tangent = own ? own + start->states : NULL;
        if (found(a, own))
            saltus_archive_finite(a, own, numbers);
        start->heading = (int)saltus_archive_whole(a, start->heading, -1, 1);
        start->parent = (int)saltus_archive_whole(a, start->parent, -1, INT_MAX);
        start->depth = (int)saltus_archive_whole(a, start->depth, 0, INT_MAX);
        start->place = (int)saltus_archive_whole(a, start->place, 0, INT_MAX);
        start->origin = saltus_archive_kind(a, start->origin, ~0u);
        start->kind = saltus_archive_kind(a, start->kind, kinds);
        start->mark = (int)saltus_archive_whole(a, start->mark, 0, SALTUS_MARKS_MAX - 1);
        saltus_archive_finite(a, &start->theta, 1);
        start->one_way = saltus_archive_flag(a, start->one_way);
        start->leaves = saltus_archive_flag(a, start->leaves);
        start->done = saltus_archive_flag(a, start->done);
        a->sound = a->sound && (lies || start->done) &&
                   (start->kind != SALTUS_POINT_GR || start->mark < start->sequence.count) &&
                   (start->origin != SALTUS_POINT_BE || start->mark < a->faces);
    }
}
