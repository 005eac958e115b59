/* Poincare maps on the flow.
 *
 * Phi carries tangent vectors to the section, f+ is the field there, and a start perturbation delta shifts
 * the time at the section by dt = delay . delta. The map's derivative is then Phi + f+ delay^T. A shift of
 * the start time by dt0 acts like the start perturbation -f0 dt0.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/map.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct saltus_map {
    saltus_arena arena;
    saltus_section section;
    saltus_flow *flow;
    bool derivative;
    int n;            /* length of the state */
    int dimension;    /* including the time, if the section has that coordinate */
    double period;    /* of the forcing */
    double *start;    /* field at the step's start */
    double *finish;   /* field at the section */
    double *tangents; /* n columns of length n */
    double *delays;
};

saltus_section saltus_section_defaults(void) {
    return (saltus_section){.kind = SALTUS_SECTION_STROBOSCOPIC, .phase = 0, .iterate = 1, .patience = 1000};
}

saltus_status saltus_map_new(const saltus_system *system, const saltus_section *section,
                             const saltus_flow_options *options, bool derivative, saltus_map **map,
                             saltus_message *message) {
    const double patience_max = 1e15;
    *map = NULL;
    if (section->kind < SALTUS_SECTION_STROBOSCOPIC || section->kind > SALTUS_SECTION_TURNING)
        return saltus_fail(message, SALTUS_BAD_INPUT, "section: must be stroboscopic, impact or turning");
    if (!(section->phase >= 0 && section->phase < 1))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "section phase = %g: must be at least 0 and less than 1", section->phase);
    if (section->iterate < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "iterate = %d: must be at least 1", section->iterate);
    if (!(section->patience > 0 && section->patience <= patience_max))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "patience = %g: must be greater than 0 and at most %g periods", section->patience,
                           patience_max);
    saltus_map *made = calloc(1, sizeof *made);
    if (!made)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the map");
    made->section = *section;
    made->derivative = derivative;
    made->n = saltus_system_dimension(system);
    made->dimension = made->n + (section->kind != SALTUS_SECTION_STROBOSCOPIC);
    made->period = saltus_system_period(system);
    saltus_status status =
        saltus_flow_single(system, derivative ? made->n : 0, options, &made->flow, message);
    const size_t n = (size_t)made->n, columns = derivative ? n : 0;
    do {
        made->start = saltus_arena_doubles(&made->arena, n);
        made->finish = saltus_arena_doubles(&made->arena, n);
        made->tangents = saltus_arena_doubles(&made->arena, columns * n);
        made->delays = saltus_arena_doubles(&made->arena, columns);
    } while (status == SALTUS_OK && saltus_arena_again(&made->arena));
    if (status == SALTUS_OK && !made->arena.base)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the map");
    if (status == SALTUS_OK)
        *map = made;
    else
        saltus_map_free(made);
    return status;
}

void saltus_map_free(saltus_map *map) {
    if (!map)
        return;
    saltus_flow_free(map->flow);
    saltus_arena_close(&map->arena);
    free(map);
}

int saltus_map_dimension(const saltus_map *map) {
    return map->dimension;
}
const saltus_flow *saltus_map_flow(const saltus_map *map) {
    return map->flow;
}

saltus_status saltus_map_reset(saltus_map *map, const double *point, saltus_message *message) {
    double phase = map->section.phase;
    if (map->dimension > map->n)
        phase = point[map->n] / map->period;
    return saltus_flow_start(map->flow, 0, (saltus_time){0, phase}, point, message);
}

/* Advance to the next section point. */
static saltus_status pass(saltus_map *map, saltus_event *event, saltus_message *message) {
    const saltus_section *section = &map->section;
    const bool timed = section->kind == SALTUS_SECTION_STROBOSCOPIC;
    saltus_time until = saltus_flow_time(map->flow, 0);
    unsigned watch = 0;
    if (timed) {
        until.cycle += until.phase >= section->phase;
        until.phase = section->phase;
    } else {
        double whole = floor(section->patience);
        until.cycle += (long long)whole;
        until.phase += section->patience - whole;
        watch = SALTUS_WATCH_IMPACT | SALTUS_WATCH_STICK;
        if (section->kind == SALTUS_SECTION_TURNING)
            watch |= SALTUS_WATCH_TURNING;
    }
    saltus_status status = saltus_flow_advance(map->flow, until, watch, event, message);
    if (status == SALTUS_OK && !timed && event->kind == SALTUS_REACHED)
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "no section point within %g periods",
                             section->patience);
    return status;
}

saltus_status saltus_map_step(saltus_map *map, double *point, saltus_event *event, saltus_message *message) {
    saltus_event last = {.kind = SALTUS_REACHED, .face = -1};
    saltus_status status = SALTUS_OK;
    if (map->derivative) {
        memset(map->tangents, 0, (size_t)(map->n * map->n) * sizeof *map->tangents);
        for (int i = 0; i < map->n; i++)
            map->tangents[i * map->n + i] = 1;
        saltus_flow_set_tangents(map->flow, 0, map->tangents);
        saltus_flow_field(map->flow, 0, map->start);
    }
    for (int k = 0; k < map->section.iterate && status == SALTUS_OK; k++)
        status = pass(map, &last, message);
    if (event)
        *event = last;
    if (status != SALTUS_OK || !point)
        return status;
    saltus_flow_state(map->flow, 0, point);
    if (map->dimension > map->n)
        point[map->n] = saltus_flow_time(map->flow, 0).phase * map->period;
    return status;
}

void saltus_map_derivative(const saltus_map *map, double *derivative) {
    int n = map->n, m = map->dimension;
    saltus_flow_tangents(map->flow, 0, map->tangents);
    if (m == n) {
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                derivative[i * n + j] = map->tangents[j * n + i];
        return;
    }
    saltus_flow_delays(map->flow, 0, map->delays);
    saltus_flow_field(map->flow, 0, map->finish);
    for (int i = 0; i < m; i++)
        derivative[i * m + n] = 0;
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++)
            derivative[i * m + j] = map->tangents[j * n + i] + map->finish[i] * map->delays[j];
        derivative[n * m + j] = map->delays[j];
        for (int i = 0; i < m; i++)
            derivative[i * m + n] -= derivative[i * m + j] * map->start[j];
    }
}
