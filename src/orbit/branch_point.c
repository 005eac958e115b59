/* Points of a branch as they are given out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *saltus_point_word(saltus_point_kind kind) {
    static const char *const words[] = {"", "LP", "PD", "NS", "BP", "GR", "CH", "ST", "UZ", "EP"};
    return kind >= 0 && kind < SALTUS_POINT_KINDS ? words[kind] : "";
}

void saltus_branch_point_clear(saltus_branch_point *point) {
    free(point->state);
    free(point->events);
    free(point->multipliers);
    *point = (saltus_branch_point){0};
}

void saltus_branch_drop_queue(saltus_branch *b) {
    for (int k = b->queue_next; k < b->queue_count; k++)
        saltus_branch_point_clear(&b->queue[k]);
    b->queue_count = b->queue_next = 0;
}

static saltus_branch_point *queue_place(saltus_branch *b) {
    if (b->queue_count == b->queue_room) {
        int room = b->queue_room ? 2 * b->queue_room : 8;
        saltus_branch_point *grown = realloc(b->queue, (size_t)room * sizeof *grown);
        if (!grown)
            return NULL;
        b->queue = grown;
        b->queue_room = room;
    }
    return &b->queue[b->queue_count];
}

/* Event times from section phase 0 of the orbit, in order. */
static void fold_events(saltus_event *events, int count, int periods) {
    for (int k = 0; k < count; k++)
        events[k].time.cycle = ((events[k].time.cycle % periods) + periods) % periods;
    for (int k = 1; k < count; k++)
        for (int j = k;
             j > 0 && saltus_time_periods(events[j].time) < saltus_time_periods(events[j - 1].time); j--) {
            saltus_event swap = events[j];
            events[j] = events[j - 1];
            events[j - 1] = swap;
        }
}

/* Events of an orbit that the flow does not follow: those prescribed. */
static void prescribed_events(const saltus_branch *b, const saltus_sequence *s, saltus_event *events) {
    for (int k = 0; k < s->count; k++) {
        double whole = floor(s->mark[k].time), speed = saltus_shooting_speed(b->shooting, k);
        saltus_face face = saltus_system_face(b->system, s->mark[k].face);
        events[k] = (saltus_event){.kind = s->mark[k].kind,
                                   .face = s->mark[k].face,
                                   .time = {(long long)whole, s->mark[k].time - whole},
                                   .velocity_before = face.side * speed,
                                   .displacement = face.side * face.d};
        if (s->mark[k].kind == SALTUS_IMPACT)
            events[k].velocity_after = -face.side * face.r * speed;
    }
}

static void fill_motion(saltus_branch *b, const saltus_solution *s, saltus_branch_point *point) {
    saltus_sequence sequence;
    const saltus_lap *lap = &b->lap;
    size_t n = (size_t)b->n * sizeof(double);
    saltus_shooting_extract(b->shooting, s->u, &sequence, b->state);
    point->periods = sequence.periods;
    if (s->follows) {
        point->impacts = saltus_lap_impacts(lap);
        point->sticking_intervals = saltus_lap_sticking(lap);
        point->event_count = lap->event_count;
        saltus_lap_label(lap, point->label);
        for (int k = 0; k < lap->event_count; k++)
            point->events[k] = lap->events[k];
        memcpy(point->state, lap->points, n);
    } else {
        saltus_message ignored;
        saltus_shooting_evaluate(b->shooting, s->u, &ignored);
        point->event_count = sequence.count;
        for (int k = 0; k < sequence.count; k++) {
            point->impacts += sequence.mark[k].kind != SALTUS_RELEASE;
            point->sticking_intervals += sequence.mark[k].kind == SALTUS_STICK;
        }
        saltus_orbit_label(point->impacts, sequence.periods, point->label);
        prescribed_events(b, &sequence, point->events);
        memcpy(point->state, sequence.base == 0 ? b->state : lap->points, n);
    }
    fold_events(point->events, point->event_count, sequence.periods);
}

saltus_status saltus_branch_emit(saltus_branch *b, const saltus_solution *s, saltus_point_kind kind,
                                 double accuracy, const char *after, const char *reason,
                                 saltus_message *message) {
    saltus_branch_point *point = queue_place(b);
    int events = b->lap.event_count > SALTUS_MARKS_MAX ? b->lap.event_count : SALTUS_MARKS_MAX;
    if (!point)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    *point = (saltus_branch_point){.kind = kind,
                                   .branch = b->number,
                                   .parent = b->parent,
                                   .step = b->points,
                                   .arclength = b->arclength + s->ahead,
                                   .value = {saltus_shooting_value(b->shooting, s->u), NAN},
                                   .heading = s->tangent[s->unknowns - 1] * b->unit,
                                   .spec = *saltus_system_spec(b->system),
                                   .dimension = b->n,
                                   .unstable = s->unstable,
                                   .stable = saltus_multipliers_stable(s->multipliers, b->n),
                                   .admissible = s->follows,
                                   .residual = s->residual,
                                   .iterations = s->iterations,
                                   .log_volume = s->log_volume,
                                   .sum_rule = s->sum_rule,
                                   .accuracy = accuracy,
                                   .state = calloc((size_t)b->n, sizeof(double)),
                                   .events = calloc((size_t)events, sizeof(saltus_event)),
                                   .multipliers = calloc((size_t)b->n, sizeof(saltus_multiplier))};
    if (!(point->state && point->events && point->multipliers)) {
        saltus_branch_point_clear(point);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    }
    memcpy(point->multipliers, s->multipliers, (size_t)b->n * sizeof *s->multipliers);
    fill_motion(b, s, point);
    /* At a change of events the flow sees one side or the other by chance. */
    bool change = kind == SALTUS_POINT_GR || kind == SALTUS_POINT_CH || kind == SALTUS_POINT_ST;
    if (change && b->last_label[0]) {
        memcpy(point->label, b->last_label, sizeof point->label);
        point->impacts = b->last_impacts;
        point->sticking_intervals = b->last_sticks;
    }
    snprintf(point->label_after, sizeof point->label_after, "%s", after ? after : "");
    snprintf(point->reason, sizeof point->reason, "%s", reason ? reason : "");
    b->queue_count++;
    b->made++;
    return SALTUS_OK;
}

saltus_status saltus_branch_end(saltus_branch *b, const saltus_solution *s, double accuracy,
                                const char *reason, saltus_message *message) {
    b->running = false;
    return saltus_branch_emit(b, s, SALTUS_POINT_EP, accuracy, NULL, reason, message);
}

void saltus_branch_remember(saltus_branch *b) {
    saltus_lap_label(&b->lap, b->last_label);
    b->last_impacts = saltus_lap_impacts(&b->lap);
    b->last_sticks = saltus_lap_sticking(&b->lap);
}
