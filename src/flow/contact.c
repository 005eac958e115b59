/* Contacts: impact law, complete chatter, sticking, release, and what they do to tangent vectors.
 *
 * Impact: Newton's law for all faces that take part (model.md, section 2). Which faces receive an impulse is
 * the solution of a complementarity problem, found by trying the few subsets in order of size: impulses push,
 * and no face without one is left closing.
 *
 * Complete chatter (Nordmark & Piiroinen, Nonlinear Dynamics 58 (2009) 85-106): impacts are simulated one by
 * one until the rest of the sequence is negligible. With outgoing speed v, contact acceleration a > 0 of the
 * state projected on the stop, the sequence lasts 2 v / (a (1 - r)) and rises no further than v^2 / (2 a)
 * from the stop; when v^2 / (a (1 - r)) is below the tolerance in displacement, the velocity is projected on
 * n.q' = 0 and the contact holds from the same instant. The impulses act along one direction, to which the
 * rest of the state is blind but for the small excursion; its integral over the sequence is of third order in
 * v (the mean of the normal velocity vanishes between contacts), so the remaining error is v^3 in the state
 * and v^2 in its derivative.
 *
 * With r = 1 the bounces never end; under pressure only the flow's own damping lowers them, ever more slowly.
 * There the contact holds once the bounces, v^2 / (2 a) high, are below the tolerance in displacement.
 *
 * Tangent vectors pass every event by the saltation matrix S = DP + (f+ - DP f-) (n, 0)^T / (n.q'-). The end
 * of a chatter is the same formula with r = 0 and the sticking field as f+; release has no jump in the field,
 * so S = 1.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include "base/bits.h"

#include <float.h>
#include <math.h>
#include <string.h>

void saltus_contacts_publish(saltus_flow *flow, int lane) {
    int slots = 0;
    for (int l = 0; l < flow->lanes; l++)
        slots = flow->lane[l].hold.count > slots ? flow->lane[l].hold.count : slots;
    saltus_contact_map_publish(&flow->lane[lane].hold, &flow->work, lane,
                               flow->lane[lane].system->face_count);
    flow->work.contacts = slots;
    if (flow->options.directions)
        saltus_directions_publish(flow);
    if (flow->radau)
        saltus_radau_publish(flow->radau, &flow->work);
}

/* Coefficient k of the gap's series at the probe's point: side * n.q_k. */
static double gap_coefficient(const saltus_system *system, const saltus_work *probe, int face, int k) {
    saltus_face f = system->faces[face];
    return f.side * probe->gap[(size_t)f.stop * (size_t)(probe->order + 2) + (size_t)k];
}

/* What rounding may make of that coefficient. */
static double rounding_of_gap(const saltus_system *system, const saltus_work *probe, int face, int k) {
    double size = 0;
    for (int i = 0; i < system->dof; i++)
        size += fabs(system->stop_normal[system->faces[face].stop][i] *
                     probe->q[saltus_work_jet(probe, k, 0) + (size_t)i]);
    return 1e-12 * size;
}

/* Whether a face touched with zero velocity is pressed: the sign of the first coefficient of its gap's
 * series, from the second order on, that stands out of rounding. */
static bool pressed(const saltus_system *system, const saltus_work *probe, int face, int order) {
    for (int k = 2; k <= order; k++) {
        double value = gap_coefficient(system, probe, face, k);
        if (fabs(value) > rounding_of_gap(system, probe, face, k))
            return value > 0;
    }
    return true;
}

/* The subset of `resting` whose contacts hold: all of its contact forces push, no other resting face closes.
 */
static unsigned holding_subset(saltus_flow *flow, int lane, unsigned resting) {
    enum { order = 5 };
    saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    int total = saltus_count_bits(resting);
    for (int size = 0; size <= total; size++)
        for (unsigned subset = 0; subset <= resting; subset++) {
            if ((subset & resting) != subset || saltus_count_bits(subset) != size ||
                !saltus_contact_map_build(system, subset, 0, &flow->scratch))
                continue;
            saltus_work *probe =
                saltus_probe_at(flow, lane, self->state, self->now.phase, &flow->scratch, order);
            bool valid = true;
            for (int k = 0; k < flow->scratch.count; k++)
                valid &= probe->force[(size_t)k * (size_t)(probe->order + 2)] >= 0;
            for (int f = 0; f < system->face_count; f++)
                if (resting & ~subset & 1u << f)
                    valid &= !pressed(system, probe, f, order);
            if (valid)
                return subset;
        }
    return resting;
}

void saltus_contacts_rest(saltus_flow *flow, int lane, unsigned resting) {
    saltus_lane *self = &flow->lane[lane];
    unsigned held = resting ? holding_subset(flow, lane, resting) : 0;
    if (held == 0 && self->hold.count == 0 && resting == 0 && flow->work.contacts == 0)
        return;
    if (!saltus_contact_map_build(self->system, held, 0, &self->hold)) {
        held = 0;
        self->hold.count = 0;
    }
    self->contacts = held;
    for (int f = 0; f < self->system->face_count; f++)
        if (resting & ~held & 1u << f)
            self->face[f] = (saltus_face_state){.touch = 2};
    saltus_contacts_publish(flow, lane);
}

/* Faces that the state touches: held ones, the one being hit, and others whose gap is zero to rounding. */
static unsigned touched_faces(const saltus_lane *self, int hit) {
    unsigned touched = self->contacts | 1u << hit;
    for (int f = 0; f < self->system->face_count; f++)
        if (saltus_system_gap_sign(self->system, f, self->state) >= 0)
            touched |= 1u << f;
    return touched;
}

/* Touched faces that the velocity closes: these rebound. The others, held or receding, at most keep from
 * closing. */
static unsigned closing_faces(const saltus_lane *self, int hit, unsigned touched) {
    unsigned closing = 1u << hit;
    for (int f = 0; f < self->system->face_count; f++)
        if (touched & ~self->contacts & 1u << f &&
            saltus_face_normal(self->system, f, self->state + self->system->dof) > 0)
            closing |= 1u << f;
    return closing;
}

/* Newton's law at the touched faces: the smallest set of impulses, among them one at the hit face, that all
 * push and leave no touched face closing. `forced`: the one at the hit face need not push. The map is left in
 * `map`; false when there is none. */
static bool impact_map(const saltus_lane *self, int hit, bool forced, unsigned touched, unsigned closing,
                       const double *velocity, saltus_contact_map *map) {
    const saltus_system *system = self->system;
    double after[SALTUS_MODES_MAX];
    int n = system->dof;
    for (int size = 1; size <= saltus_count_bits(touched); size++)
        for (unsigned subset = 1; subset <= touched; subset++) {
            if ((subset & touched) != subset || saltus_count_bits(subset) != size || !(subset >> hit & 1) ||
                !saltus_contact_map_build(system, subset, subset & closing, map))
                continue;
            bool valid = true;
            for (int k = 0; k < map->count; k++)
                valid &= saltus_dot(map->pull + k * n, velocity, n) >= 0 || (forced && map->face[k] == hit);
            memcpy(after, velocity, (size_t)n * sizeof *after);
            saltus_contact_map_apply(map, n, after);
            double tiny = 64 * DBL_EPSILON * sqrt(saltus_dot(velocity, velocity, n));
            for (int f = 0; f < system->face_count; f++)
                if (touched & ~subset & 1u << f)
                    valid &= saltus_face_normal(system, f, after) <= tiny;
            if (valid)
                return true;
        }
    return false;
}

/* The impact of the touched faces. Where several close at once the push at one may be all that it takes to
 * open the one that was found: then `hit` becomes that face. A hit face that rounding makes recede is hit all
 * the same. */
static bool solve_impact(const saltus_lane *self, int *hit, unsigned touched, unsigned closing,
                         const double *velocity, saltus_contact_map *map) {
    if (impact_map(self, *hit, false, touched, closing, velocity, map))
        return true;
    for (int f = 0; f < self->system->face_count; f++)
        if (closing >> f & 1 && f != *hit && impact_map(self, f, false, touched, closing, velocity, map)) {
            *hit = f;
            return true;
        }
    return impact_map(self, *hit, true, touched, closing, velocity, map);
}

/* S delta = DP delta + (f+ - DP f-) (n.delta_q) / (n.q'-) for every tangent vector. `velocity` is the
 * trajectory's before the impact. */
static void saltate(saltus_flow *flow, int lane, int face, double speed, const saltus_contact_map *map,
                    unsigned elastic, const double *velocity) {
    saltus_lane *self = &flow->lane[lane];
    int n = flow->dof, dimension = flow->dimension;
    double *jump = self->before;
    /* DP leaves displacements alone: only the acceleration part of f- is mapped. */
    saltus_contact_map_apply(map, n, jump + n);
    for (int i = 0; i < dimension; i++)
        jump[i] = self->after[i] - self->before[i];
    for (int c = 0; c < flow->options.columns; c++) {
        double *delta = self->tangents + c * dimension;
        double delay = saltus_column_gap(flow, lane, face, c) / speed;
        self->delay[c] = -delay;
        saltus_column_impact(flow, lane, map, elastic, velocity, c);
        for (int i = 0; i < dimension; i++)
            delta[i] = fma(delay, jump[i], delta[i]);
    }
}

/* Whether impulses at the faces of a map do not meet: none changes the velocity at another. */
static bool apart(const saltus_contact_map *map) {
    for (int k = 0; k < map->count; k++)
        for (int j = 0; j < map->count; j++)
            if (j != k && fabs(map->inverse[k * map->count + j]) > 1e-14)
                return false;
    return true;
}

/* Impacts in one instant that do not meet: each has a delay of its own, and a tangent vector passes one after
 * the other, the hit face's last, whose delay is the event's. `map` is their common map, all of them rebound.
 */
static void saltate_apart(saltus_flow *flow, int lane, int hit, const saltus_contact_map *map,
                          const double *velocity) {
    saltus_lane *self = &flow->lane[lane];
    int n = flow->dof;
    double before[SALTUS_MODES_MAX];
    memcpy(self->trial, self->state, (size_t)flow->dimension * sizeof(double));
    memcpy(self->trial + n, velocity, (size_t)n * sizeof(double));
    for (int turn = 0; turn < 2; turn++)
        for (int k = 0; k < map->count; k++) {
            if ((map->face[k] == hit) != turn)
                continue;
            saltus_contact_map one = {.count = 1,
                                      .face = {map->face[k]},
                                      .push = map->push + k * n,
                                      .pull = map->pull + k * n,
                                      .inverse = {1}};
            double speed = saltus_face_normal(self->system, map->face[k], self->trial + n);
            memcpy(before, self->trial + n, (size_t)n * sizeof *before);
            saltus_contact_map_apply(&one, n, self->trial + n);
            saltus_field_at(flow, lane, self->trial, self->now.phase, NULL, self->after);
            saltate(flow, lane, map->face[k], speed, &one, 1u << map->face[k], before);
            memcpy(self->before, self->after, (size_t)flow->dimension * sizeof(double));
        }
}

/* The displacement at a face that counts as nothing beside the state. At a stop near a support the modes move
 * by much more than the coordinate that it limits. */
static double displacement_tolerance(const saltus_flow *flow, int lane, int face, double *size) {
    const saltus_lane *self = &flow->lane[lane];
    const double *normal = self->system->stop_normal[self->system->faces[face].stop];
    const double unit = flow->work.omega_unit[lane];
    *size = 0;
    for (int i = 0; i < flow->dof; i++)
        *size = fmax(*size, fmax(fabs(self->state[i]), fabs(self->state[flow->dof + i]) / unit));
    double reach = fmin(1, sqrt(saltus_dot(normal, normal, flow->dof)));
    return 0.1 * reach * (flow->options.atol + flow->options.rtol * *size);
}

/* Whether a rebound is slow enough that its chatter could end here, judged by a bound on accelerations alone:
 * saves the closer look at every ordinary impact. */
static bool may_end_chatter(const saltus_flow *flow, int lane, int face, double rebound) {
    const saltus_lane *self = &flow->lane[lane];
    double size, tolerance = displacement_tolerance(flow, lane, face, &size), rate = self->system->rate;
    double bound = flow->dof * rate * (rate + flow->work.omega_unit[lane]) * size,
           r = self->system->faces[face].r;
    return rebound * rebound <= tolerance * bound * (r < 1 ? 1 - r : 2);
}

/* Held faces that an impact at another lets go: they recede, and would rise further than the tolerance. A
 * contact cannot pull. `probe` is the series of the state with the contacts held. */
static unsigned leaving_faces(const saltus_flow *flow, int lane, const saltus_work *probe) {
    const saltus_lane *self = &flow->lane[lane];
    unsigned leaving = 0;
    for (int k = 0; k < self->hold.count; k++) {
        int face = self->hold.face[k];
        double force = probe->force[(size_t)k * (size_t)(probe->order + 2)], size;
        double away = -saltus_face_normal(self->system, face, self->state + self->system->dof);
        if (away > 0 && away * away > 2 * displacement_tolerance(flow, lane, face, &size) * force)
            leaving |= 1u << face;
    }
    return leaving;
}

/* Remaining time of a chatter that may be cut short here; negative if it may not. `self->trial` receives the
 * state with the normal velocity removed, `leaving` the held faces that do not keep theirs at zero. */
static double chatter_remainder(saltus_flow *flow, int lane, int face, double rebound, unsigned *leaving) {
    saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    double r = system->faces[face].r, size, tolerance = displacement_tolerance(flow, lane, face, &size);
    const saltus_work *now = saltus_probe_at(flow, lane, self->state, self->now.phase, &self->hold, 2);
    double acceleration = 2 * gap_coefficient(system, now, face, 2);
    *leaving = leaving_faces(flow, lane, now);
    memcpy(self->trial, self->state, (size_t)flow->dimension * sizeof(double));
    if (!saltus_contact_map_build(system, (self->contacts & ~*leaving) | 1u << face, 0, &flow->scratch))
        return -1;
    saltus_contact_map_apply(&flow->scratch, flow->dof, self->trial + flow->dof);
    const saltus_contact_map *hold = &self->hold;
    if (*leaving && saltus_contact_map_build(system, self->contacts & ~*leaving, 0, &flow->scratch))
        hold = &flow->scratch;
    const saltus_work *probe = saltus_probe_at(flow, lane, self->trial, self->now.phase, hold, 3);
    double a = 2 * gap_coefficient(system, probe, face, 2),
           jerk = 6 * gap_coefficient(system, probe, face, 3);
    if (!(a > 0) || rebound * rebound > tolerance * a * (r < 1 ? 1 - r : 2))
        return -1;
    if (r == 1)
        return 0;
    double remainder = rebound > 0 ? 2 * rebound / (a * (1 - r)) : 0;
    bool steady = fabs(jerk) * remainder <= 0.1 * a && fabs(acceleration - a) <= 0.1 * a;
    return rebound == 0 || steady ? remainder : -1;
}

/* Faces of `touched` that rest after the impact: no normal velocity out of rounding. */
static unsigned resting_faces(const saltus_lane *self, unsigned touched, double tiny) {
    const saltus_system *system = self->system;
    unsigned resting = 0;
    for (int f = 0; f < system->face_count; f++) {
        const double *normal = system->stop_normal[system->faces[f].stop];
        double reach = fmin(1, sqrt(saltus_dot(normal, normal, system->dof)));
        if (touched >> f & 1 &&
            fabs(saltus_face_normal(system, f, self->state + system->dof)) <= tiny * reach)
            resting |= 1u << f;
    }
    return resting;
}

static saltus_event impact_event(const saltus_lane *self, int face, double speed) {
    saltus_face f = self->system->faces[face];
    return (saltus_event){.kind = SALTUS_IMPACT,
                          .face = face,
                          .time = self->now,
                          .velocity_before = f.side * speed,
                          .velocity_after = -f.side * f.r * speed,
                          .displacement = f.side * f.d};
}

/* Every closing face that receives an impulse is an impact of its own; those beside the hit one are queued.
 */
static void record_impacts(saltus_lane *self, int hit, unsigned rebounding, saltus_event *event) {
    const double *velocity = self->state + self->system->dof;
    self->queued = 0;
    for (int f = 0; f < self->system->face_count; f++) {
        double speed = saltus_face_normal(self->system, f, velocity);
        if (!(rebounding >> f & 1) && f != hit)
            continue;
        if (f == hit)
            *event = impact_event(self, f, speed > 0 ? speed : 0);
        else
            self->queue[self->queued++] = impact_event(self, f, speed);
        if (speed > 0) {
            self->info.impacts++;
            self->info.log_volume += 2 * log(self->system->faces[f].r);
        }
    }
}

/* After an impact all velocities are new: what is known of the gaps' rates from the step before must follow.
 */
static void refresh_rates(saltus_lane *self) {
    for (int f = 0; f < self->system->face_count; f++)
        if (self->face[f].shadow)
            self->face[f].rate = saltus_face_normal(self->system, f, self->state + self->system->dof);
}

/* Take the impact without rebound if its chatter ends here; then decide which touched faces hold. Returns the
 * time left to the accumulation point, negative if the impact rebounds. */
static double end_chatter_and_rest(saltus_flow *flow, int lane, int face, unsigned touched, double rebound,
                                   unsigned *leaving) {
    saltus_lane *self = &flow->lane[lane];
    int n = flow->dof;
    double tiny = 64 * DBL_EPSILON * sqrt(saltus_dot(self->state + n, self->state + n, n));
    double remainder = may_end_chatter(flow, lane, face, rebound)
                           ? chatter_remainder(flow, lane, face, rebound, leaving)
                           : -1;
    if (remainder >= 0) {
        memcpy(self->state, self->trial, (size_t)flow->dimension * sizeof(double));
        tiny *= 16;
    }
    unsigned resting = resting_faces(self, touched, tiny) | (remainder >= 0 ? 1u << face : 0);
    for (int f = 0; f < self->system->face_count; f++)
        if (touched >> f & 1)
            self->face[f] = (saltus_face_state){.touch = 1};
    saltus_contacts_rest(flow, lane, resting);
    saltus_contact_map_settle(self->system, &self->hold, self->state);
    refresh_rates(self);
    return remainder;
}

static int lowest_face(unsigned faces) {
    int face = 0;
    while (!(faces >> face & 1))
        face++;
    return face;
}

saltus_status saltus_contacts_impact(saltus_flow *flow, int lane, int face, saltus_event *event) {
    saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    saltus_contact_map *map = &flow->scratch;
    int n = flow->dof;
    unsigned touched = touched_faces(self, face), closing = closing_faces(self, face, touched), impulses = 0;
    unsigned held_before = self->contacts, leaving = 0;
    if (!solve_impact(self, &face, touched, closing, self->state + n, map))
        return SALTUS_STALLED;
    for (int k = 0; k < map->count; k++)
        impulses |= 1u << map->face[k];
    double velocity_before[SALTUS_MODES_MAX];
    memcpy(velocity_before, self->state + n, (size_t)n * sizeof *velocity_before);
    if (flow->options.columns)
        saltus_field_at(flow, lane, self->state, self->now.phase, &self->hold, self->before);
    record_impacts(self, face, impulses & closing, event);
    saltus_contact_map_apply(map, n, self->state + n);

    double speed = fabs(event->velocity_before), rebound = system->faces[face].r * speed;
    double remainder = end_chatter_and_rest(flow, lane, face, touched, rebound, &leaving);
    unsigned elastic = impulses & closing & ~(remainder >= 0 ? 1u << face : 0);
    if (flow->options.columns && speed > 0) {
        unsigned kept = remainder >= 0 ? held_before & ~leaving : 0;
        if (!saltus_contact_map_build(system, impulses | kept, elastic, map))
            return SALTUS_STALLED;
        if (map->count > 1 && !(held_before | self->contacts) && elastic == (impulses | kept) && apart(map)) {
            saltate_apart(flow, lane, face, map, velocity_before);
        } else {
            saltus_field_at(flow, lane, self->state, self->now.phase, &self->hold, self->after);
            saltate(flow, lane, face, speed, map, elastic, velocity_before);
        }
    }
    unsigned caught = self->contacts & ~held_before;
    if (caught) {
        self->info.sticks++;
        event->kind = SALTUS_STICK;
        if (caught >> face & 1) {
            event->velocity_after = 0;
        } else {
            self->queue[self->queued++] = impact_event(self, face, speed);
            event->face = lowest_face(caught);
            event->velocity_before = event->velocity_after = 0;
            event->displacement = system->faces[event->face].side * system->faces[event->face].d;
        }
        event->time = saltus_time_after(self->now, remainder > 0 ? remainder / system->period : 0);
    }
    return SALTUS_OK;
}

bool saltus_contacts_set(saltus_flow *flow, int lane, unsigned contacts) {
    saltus_lane *self = &flow->lane[lane];
    bool built = saltus_contact_map_build(self->system, contacts, 0, &self->hold);
    if (!built)
        self->hold.count = 0;
    self->contacts = contacts;
    saltus_contacts_publish(flow, lane);
    return built;
}

/* The force's zero is found on the step's polynomial, as exact as the tolerance; whether the contact lets go
 * is decided by the acceleration at the state itself, so that the gap that follows begins as the flow will.
 */
bool saltus_contacts_release(saltus_flow *flow, int lane, int face) {
    saltus_lane *self = &flow->lane[lane];
    const unsigned contacts = self->contacts;
    saltus_contacts_set(flow, lane, contacts & ~(1u << face));
    const saltus_work *probe = saltus_probe_at(flow, lane, self->state, self->now.phase, &self->hold, 2);
    bool moved = self->now.phase != self->begin.phase || self->now.cycle != self->begin.cycle;
    if (moved &&
        gap_coefficient(self->system, probe, face, 2) > rounding_of_gap(self->system, probe, face, 2)) {
        saltus_contacts_set(flow, lane, contacts);
        return false;
    }
    self->info.releases++;
    self->face[face] = (saltus_face_state){.touch = 2};
    return true;
}
