/* Where other branches begin: at flips, branch points and grazing; and the first points of loci.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

saltus_status saltus_branch_add_start(saltus_branch *b, const saltus_branch_start *start,
                                      saltus_message *message) {
    saltus_branch_start *grown = realloc(b->starts, ((size_t)b->start_count + 1) * sizeof *grown),
                        *place = NULL;
    if (grown) {
        b->starts = grown;
        place = &grown[b->start_count];
        *place = *start;
        size_t n = (size_t)b->n, unknowns = (size_t)start->unknowns;
        place->state = calloc(n, sizeof *place->state);
        place->tangent = start->tangent ? calloc(unknowns, sizeof *place->tangent) : NULL;
        if (place->state && (place->tangent || !start->tangent)) {
            memcpy(place->state, start->state, n * sizeof *start->state);
            if (start->tangent)
                memcpy(place->tangent, start->tangent, unknowns * sizeof *start->tangent);
            b->start_count++;
            return SALTUS_OK;
        }
        free(place->state);
        free(place->tangent);
    }
    return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
}

saltus_status saltus_branch_capture(saltus_branch *b, int mark, saltus_message *message) {
    saltus_sequence sequence;
    saltus_shooting_extract(b->shooting, b->trial.u, &sequence, b->state);
    saltus_branch_start start = {.sequence = sequence,
                                 .value = saltus_shooting_value(b->shooting, b->trial.u),
                                 .state = b->state,
                                 .tangent = b->trial.tangent,
                                 .unknowns = b->trial.unknowns,
                                 .parent = -1,
                                 .locus = true,
                                 .mark = mark};
    saltus_status status = SALTUS_OK;
    saltus_branch_drop_queue(b);
    b->running = false;
    b->locus.on = true;
    b->start_next = b->start_count;
    for (int heading = 1; heading >= -1 && status == SALTUS_OK; heading -= 2)
        if (b->options.direction * heading >= 0) {
            start.heading = heading;
            status = saltus_branch_add_start(b, &start, message);
        }
    return status;
}

/* The orbit gone through twice. */
static void double_sequence(const saltus_sequence *s, saltus_sequence *twice) {
    *twice = *s;
    twice->periods = 2 * s->periods;
    twice->count = 2 * s->count;
    for (int k = 0; k < s->count; k++) {
        twice->mark[s->count + k] = s->mark[k];
        twice->mark[s->count + k].time += s->periods;
    }
}

/* The flip's determinant of the orbit at a parameter value, relative to the first one asked for. */
static bool flip_at(saltus_shooting *half, double value, double *u, double *reference, double *test) {
    int sign, iterations, m = saltus_shooting_unknowns(half);
    double log_modulus;
    saltus_message ignored;
    u[m - 1] += (value - saltus_shooting_value(half, u)) / saltus_shooting_scale(half)[m - 1];
    if (saltus_shooting_correct(half, u, NULL, NULL, false, &iterations, &ignored) != SALTUS_OK)
        return false;
    saltus_shooting_flip(half, &sign, &log_modulus);
    if (isnan(*reference))
        *reference = log_modulus;
    *test = sign * exp(log_modulus - *reference);
    return true;
}

/* Secants in the parameter. */
static bool secants_to_flip(saltus_shooting *half, double *u, double unit, double *value, double *accuracy) {
    enum { secants_max = 12 };
    double reference = NAN, last = *value, now = last + 1e-5 * unit, before, test;
    if (!flip_at(half, last, u, &reference, &before))
        return false;
    for (int k = 0; k < secants_max; k++) {
        if (!flip_at(half, now, u, &reference, &test) || test == before)
            return false;
        double next = now - test * (now - last) / (test - before);
        *accuracy = fabs(next - now);
        last = now;
        before = test;
        now = next;
        if (!(fabs(now - *value) < 1e-3 * unit))
            return false;
        if (*accuracy < 1e-12 * unit) {
            *value = now;
            return true;
        }
    }
    return false;
}

bool saltus_branch_flip_of_half(saltus_branch *b, double *value, double *accuracy) {
    saltus_sequence sequence;
    saltus_shooting *half = NULL;
    saltus_message ignored;
    saltus_shooting_extract(b->shooting, b->trial.u, &sequence, b->state);
    *value = saltus_shooting_value(b->shooting, b->trial.u);
    if (sequence.count % 2)
        return false;
    sequence.cuts = 1;
    sequence.periods /= 2;
    sequence.count /= 2;
    double *u = calloc((size_t)(b->n + sequence.count + 1), sizeof *u);
    saltus_status status = u ? saltus_shooting_new(&b->spec, &b->direction, b->origin, b->unit,
                                                   &b->options.orbit, &half, &ignored)
                             : SALTUS_NO_MEMORY;
    if (status == SALTUS_OK)
        status = saltus_shooting_shape(half, &sequence, &ignored);
    if (status == SALTUS_OK)
        status = saltus_shooting_fill(half, *value, b->state, u, &ignored);
    bool found =
        saltus_branch_noted(b, status) == SALTUS_OK && secants_to_flip(half, u, b->unit, value, accuracy);
    saltus_shooting_free(half);
    free(u);
    return found;
}

saltus_status saltus_branch_switch_grazing(saltus_branch *b, const saltus_sequence *more,
                                           const saltus_sequence *less, double value, double *state,
                                           saltus_message *message) {
    saltus_sequence mixed = *more;
    if (b->depth >= b->options.switches || more->count != less->count + 1 ||
        more->count + less->count > SALTUS_MARKS_MAX)
        return SALTUS_OK;
    mixed.cuts = 1;
    mixed.periods = 2 * more->periods;
    mixed.count = more->count + less->count;
    for (int k = 0; k < less->count; k++) {
        mixed.mark[more->count + k] = less->mark[k];
        mixed.mark[more->count + k].time += more->periods;
    }
    saltus_branch_start start = {.sequence = mixed,
                                 .value = value,
                                 .state = state,
                                 .grazes = true,
                                 .parent = b->number,
                                 .depth = b->depth + 1};
    return saltus_branch_add_start(b, &start, message);
}

/* The old tangent, of a sequence with `cuts` cuts, among the unknowns without them. */
static void join_tangent(const saltus_sequence *s, int cuts, const double *old, int n, double *tangent) {
    memcpy(tangent, old, (size_t)n * sizeof *old);
    memcpy(tangent + n, old + cuts * n, (size_t)(s->count + 1) * sizeof *old);
}

/* In the null plane, the unit vector that leaves the old branch: at flips and pitchforks the one along which
 * the parameter does not change, which is the new branch's tangent; otherwise that across the old tangent. */
static void leaving(const double *plane, const double *old, int m, bool pitchfork, double *out) {
    double a = 0, c = 0, size = 0;
    for (int j = pitchfork ? m - 1 : 0; j < m; j++) {
        a += plane[j] * (pitchfork ? 1 : old[j]);
        c += plane[m + j] * (pitchfork ? 1 : old[j]);
    }
    for (int j = 0; j < m; j++) {
        out[j] = c * plane[j] - a * plane[m + j];
        size = hypot(size, out[j]);
    }
    for (int j = 0; j < m; j++)
        out[j] /= size;
}

/* `cuts` is how many the old branch has where this is not a flip or pitchfork. */
static saltus_status leave(saltus_branch *b, const saltus_sequence *sequence, int cuts, bool pitchfork,
                           saltus_message *message) {
    saltus_shooting *shooting = NULL;
    int m = b->n + sequence->count + 1;
    double values[2], *work = calloc(5 * (size_t)m, sizeof *work);
    double *u = work, *plane = work + m, *old = work + 3 * (size_t)m, *tangent = work + 4 * (size_t)m;
    double value = saltus_shooting_value(b->shooting, b->trial.u);
    saltus_status status =
        work ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    if (status == SALTUS_OK)
        status = saltus_shooting_new(&b->spec, &b->direction, b->origin, b->unit, &b->options.orbit,
                                     &shooting, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_shape(shooting, sequence, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_fill(shooting, value, b->state, u, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_evaluate(shooting, u, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_null_plane(shooting, plane, values, message);
    if (status == SALTUS_OK) {
        if (!pitchfork)
            join_tangent(sequence, cuts, b->trial.tangent, b->n, old);
        leaving(plane, old, m, pitchfork, tangent);
        saltus_branch_start start = {.sequence = *sequence,
                                     .value = value,
                                     .state = b->state,
                                     .tangent = tangent,
                                     .unknowns = m,
                                     .parent = b->number,
                                     .depth = b->depth + 1};
        status = saltus_branch_add_start(b, &start, message);
        for (int j = 0; j < m; j++)
            tangent[j] = -tangent[j];
        if (!pitchfork && status == SALTUS_OK)
            status = saltus_branch_add_start(b, &start, message);
    }
    saltus_shooting_free(shooting);
    free(work);
    return status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
}

saltus_status saltus_branch_switch(saltus_branch *b, saltus_point_kind kind, saltus_message *message) {
    saltus_sequence here, twice;
    bool shift, mirror = saltus_system_mirror_symmetric(b->system, &shift);
    saltus_shooting_extract(b->shooting, b->trial.u, &here, b->state);
    int cuts = here.cuts;
    here.cuts = 1;
    if (b->depth >= b->options.switches || 2 * here.count > SALTUS_MARKS_MAX)
        return SALTUS_OK;
    if (kind == SALTUS_POINT_BP)
        return leave(b, &here, cuts, mirror, message);
    double_sequence(&here, &twice);
    return leave(b, &twice, cuts, true, message);
}
