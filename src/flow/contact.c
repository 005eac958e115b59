/* Contacts: impact law, complete chatter, sticking, release, and their effect on tangent vectors.
 *
 * Impact: Newton's law for all faces that take part (model.md, section 2). Which faces receive an impulse is
 * the solution of a complementarity problem, found by trying the few subsets in order of size: impulses push,
 * and no face without one is left closing.
 *
 * Complete chatter (Nordmark & Piiroinen, Nonlinear Dynamics 58 (2009) 85-106): impacts are simulated one by
 * one until the rest of the sequence is negligible. With outgoing speed v, contact acceleration a > 0 of the
 * state projected on the stop, the sequence lasts 2 v / (a (1 - r)) and rises no further than v^2 / (2 a)
 * from the stop; when v^2 / (a (1 - r)) is below the tolerance in displacement, the velocity is projected on
 * n.q' = 0 and the contact holds from the same instant. The impulses act along one direction and affect the
 * rest of the state only through the small excursion, whose integral over the sequence is of third order in v
 * (the mean of the normal velocity vanishes between contacts). So the remaining error is v^3 in the state and
 * v^2 in its derivative.
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
#include "base/dense.h"

#include <float.h>
#include <math.h>
#include <string.h>

void saltus_contacts_publish(saltus_flow *flow, int lane) {
    const saltus_lane *self = &flow->lane[lane];
    int slots = 0;
    for (int l = 0; l < flow->lanes; l++)
        slots = flow->lane[l].hold.count > slots ? flow->lane[l].hold.count : slots;
    saltus_contact_map_publish(&self->hold, &flow->work, lane, self->system->face_count);
    flow->work.hold.count = slots;
    if (flow->options.directions)
        saltus_directions_publish(flow);
    if (flow->radau)
        saltus_radau_publish(flow->radau, &flow->work);
}

/* Coefficient k of the gap's series at the probe's point: side * n.q_k. */
static double gap_coefficient(const saltus_system *system, const saltus_work *probe, int face, int k) {
    saltus_face f = system->faces[face];
    return f.side * probe->gap[saltus_work_series_place(probe, f.stop, k, 0)];
}

/* A bound on the rounding error of that coefficient. */
static double rounding_of_gap(const saltus_system *system, const saltus_work *probe, int face, int k) {
    const double *normal = system->stop_normal[system->faces[face].stop];
    double size = 0;
    for (int i = 0; i < system->dof; i++)
        size += fabs(normal[i] * probe->jet.q[saltus_work_place(probe, k, 0, i, 0)]);
    return 1e-12 * size;
}

/* Whether a face touched with zero normal velocity is pressed: the sign of the first coefficient, from order
 * 2 on, of its gap's series that exceeds rounding. */
static bool pressed(const saltus_system *system, const saltus_work *probe, int face, int order) {
    for (int k = 2; k <= order; k++) {
        double value = gap_coefficient(system, probe, face, k);
        if (fabs(value) > rounding_of_gap(system, probe, face, k))
            return value > 0;
    }
    return true;
}

/* The subset of `resting` that holds: all its contact forces push and no other resting face closes. */
static unsigned holding_subset(saltus_flow *flow, int lane, unsigned resting) {
    enum { order = 5 };
    const saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    for (unsigned subset = 0;; subset = saltus_next_subset(resting, subset)) {
        bool valid = saltus_contact_map_build(system, subset, 0, NULL, &flow->scratch);
        if (valid) {
            const saltus_work *probe =
                saltus_probe_at(flow, lane, flow->state, self->now.phase, &flow->scratch, order);
            for (int k = 0; k < flow->scratch.count; k++)
                valid &= probe->hold.force[saltus_work_series_place(probe, k, 0, 0)] >= 0;
            for (int f = 0; f < system->face_count; f++)
                valid &= !(resting & ~subset & 1u << f) || !pressed(system, probe, f, order);
        }
        if (valid || subset == resting)
            return subset;
    }
}

void saltus_contacts_rest(saltus_flow *flow, int lane, unsigned resting) {
    saltus_lane *self = &flow->lane[lane];
    unsigned held = resting ? holding_subset(flow, lane, resting) : 0;
    if (held == 0 && self->hold.count == 0 && resting == 0 && flow->work.hold.count == 0)
        return;
    saltus_contact_map_build(self->system, held, 0, NULL, &self->hold);
    for (int f = 0; f < self->system->face_count; f++)
        if (resting & ~self->hold.faces & 1u << f)
            self->face[f] = (saltus_face_state){.touch = 2};
    saltus_contacts_publish(flow, lane);
}

/* Touched faces: held ones, the one being hit, and others whose gap is zero to rounding. */
static unsigned touched_faces(const saltus_lane *self, const double *state, int hit) {
    unsigned touched = self->hold.faces | 1u << hit;
    for (int f = 0; f < self->system->face_count; f++)
        if (saltus_system_gap_sign(self->system, f, state) >= 0)
            touched |= 1u << f;
    return touched;
}

/* Touched faces that close and so rebound. The others, held or receding, are only kept from closing. */
static unsigned closing_faces(const saltus_lane *self, const double *velocity, int hit, unsigned touched) {
    unsigned closing = 1u << hit;
    for (int f = 0; f < self->system->face_count; f++)
        if (touched & ~self->hold.faces & 1u << f && saltus_face_normal(self->system, f, velocity) > 0)
            closing |= 1u << f;
    return closing;
}

/* Newton's law at the touched faces: the smallest set of impulses, among them one at the hit face, that all
 * push and leave no touched face closing. With `forced` the one at the hit face may pull. The result is in
 * `map`; false if there is none. */
static bool impact_map(const saltus_system *system, int hit, bool forced, unsigned touched, unsigned closing,
                       const double *velocity, saltus_contact_map *map) {
    double after[SALTUS_MODES_MAX];
    const int n = system->dof;
    for (unsigned subset = 1u << hit;; subset = saltus_next_subset(touched, subset)) {
        bool valid =
            subset >> hit & 1 && saltus_contact_map_build(system, subset, subset & closing, velocity, map);
        if (valid) {
            for (int k = 0; k < map->count; k++)
                valid &= saltus_dot(map->pull + k * n, velocity, n) >= 0 || (forced && map->face[k] == hit);
        }
        if (valid && touched & ~subset) {
            const double tiny = 64 * DBL_EPSILON * sqrt(saltus_dot(velocity, velocity, n));
            memcpy(after, velocity, (size_t)n * sizeof *after);
            saltus_contact_map_apply(map, n, after);
            for (int f = 0; f < system->face_count; f++)
                valid &= !(touched & ~subset & 1u << f) || saltus_face_normal(system, f, after) <= tiny;
        }
        if (valid || subset == touched)
            return valid;
    }
}

/* The impact of the touched faces. If several close at once, the impulse at another face may open the hit
 * one: then *hit becomes that face. A hit face that recedes by rounding is hit nevertheless. */
static bool solve_impact(const saltus_system *system, int *hit, unsigned touched, unsigned closing,
                         const double *velocity, saltus_contact_map *map) {
    if (impact_map(system, *hit, false, touched, closing, velocity, map))
        return true;
    for (int f = 0; f < system->face_count; f++)
        if (closing >> f & 1 && f != *hit && impact_map(system, f, false, touched, closing, velocity, map)) {
            *hit = f;
            return true;
        }
    return impact_map(system, *hit, true, touched, closing, velocity, map);
}

/* S delta = DP delta + (f+ - DP f-) (n.delta_q) / (n.q'-) for every tangent vector, with f- in flow->before
 * (overwritten) and f+ in flow->after. `velocity` is the trajectory's before the impact. */
static void saltate(saltus_flow *flow, int lane, int face, double speed, const saltus_contact_map *map,
                    unsigned elastic, const double *velocity) {
    int n = flow->dof, dimension = flow->dimension;
    double *jump = flow->before;
    /* DP leaves displacements alone: only the acceleration part of f- is mapped. */
    saltus_contact_map_carry(map, n, jump + n);
    for (int i = 0; i < dimension; i++)
        jump[i] = flow->after[i] - flow->before[i];
    for (int c = 0; c < flow->options.columns; c++) {
        double *delta = flow->tangents + c * dimension;
        double delay = saltus_column_gap(flow, lane, face, c) / speed;
        flow->lane[lane].delay[c] = -delay;
        saltus_column_impact(flow, lane, map, elastic, velocity, c);
        for (int i = 0; i < dimension; i++)
            delta[i] = fma(delay, jump[i], delta[i]);
    }
}

/* Whether the faces of a map are independent: no impulse changes the normal velocity at another face. */
static bool apart(const saltus_contact_map *map) {
    for (int k = 0; k < map->count; k++)
        for (int j = 0; j < map->count; j++)
            if (j != k && fabs(map->inverse[k * map->count + j]) > 1e-14)
                return false;
    return true;
}

/* Simultaneous impacts on independent faces, each with its own delay: a tangent vector passes them one by
 * one, the hit face last, whose delay is the event's. `map` is their common map; all rebound. */
static void saltate_apart(saltus_flow *flow, int lane, int hit, const saltus_contact_map *map,
                          const double *velocity) {
    const saltus_lane *self = &flow->lane[lane];
    int n = flow->dof;
    double before[SALTUS_MODES_MAX];
    memcpy(flow->trial, flow->state, (size_t)flow->dimension * sizeof(double));
    memcpy(flow->trial + n, velocity, (size_t)n * sizeof(double));
    for (int turn = 0; turn < 2; turn++)
        for (int k = 0; k < map->count; k++) {
            const int face = map->face[k];
            if ((face == hit) != turn)
                continue;
            saltus_contact_map one = {.faces = 1u << face,
                                      .count = 1,
                                      .face = {face},
                                      .push = map->push + k * n,
                                      .pull = map->pull + k * n,
                                      .change = map->change + k * n,
                                      .speed = {map->speed[k]},
                                      .r = {map->r[k]},
                                      .inverse = {1}};
            double speed = saltus_face_normal(self->system, face, flow->trial + n);
            memcpy(before, flow->trial + n, (size_t)n * sizeof *before);
            saltus_contact_map_apply(&one, n, flow->trial + n);
            saltus_field_at(flow, lane, flow->trial, self->now.phase, &self->hold, flow->after);
            saltate(flow, lane, face, speed, &one, 1u << face, before);
            memcpy(flow->before, flow->after, (size_t)flow->dimension * sizeof(double));
        }
}

/* The size of a lane's state: largest displacement, or velocity over its unit. */
static double state_size(const saltus_flow *flow, int lane) {
    const double unit = flow->work.lane->omega_unit[lane];
    double size = 0;
    for (int i = 0; i < flow->dof; i++) {
        const double displacement = fabs(flow->state[i]), velocity = fabs(flow->state[flow->dof + i]) / unit;
        size = displacement > size ? displacement : size;
        size = velocity > size ? velocity : size;
    }
    return size;
}

/* The displacement at a face that is negligible for a state of a size. */
static double displacement_tolerance(const saltus_flow *flow, int lane, int face, double size) {
    const saltus_system *system = flow->lane[lane].system;
    return 0.1 * system->stop_reach[system->faces[face].stop] *
           (flow->options.atol + flow->options.rtol * size);
}

/* Held faces released by an impact on another: they recede and would rise beyond the tolerance. A contact
 * cannot pull. `probe` is the series of the state with the contacts held. */
static unsigned leaving_faces(const saltus_flow *flow, int lane, double size, const saltus_work *probe) {
    const saltus_lane *self = &flow->lane[lane];
    unsigned leaving = 0;
    for (int k = 0; k < self->hold.count; k++) {
        int face = self->hold.face[k];
        double force = probe->hold.force[saltus_work_series_place(probe, k, 0, 0)];
        double away = -saltus_face_normal(self->system, face, flow->state + flow->dof);
        if (away > 0 && away * away > 2 * displacement_tolerance(flow, lane, face, size) * force)
            leaving |= 1u << face;
    }
    return leaving;
}

/* Whether and how a chatter may be ended. */
typedef struct chatter_end {
    double remainder; /* time left to the accumulation point; negative: it goes on */
    unsigned leaving; /* held faces that do not keep their normal velocity at zero */
} chatter_end;

/* Whether the chatter that begins with this rebound may be ended here; flow->trial receives the state with
 * the normal velocity removed. */
static chatter_end end_of_chatter(saltus_flow *flow, int lane, int face, double rebound, double pressure) {
    const saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    const double size = state_size(flow, lane), r = system->faces[face].r;
    const double tolerance = displacement_tolerance(flow, lane, face, size), slack = r < 1 ? 1 - r : 2;
    chatter_end end = {-1, 0};
    /* A bound on the acceleration rules this out for ordinary impacts without a closer look. */
    const double bound =
        fmin(flow->dof * system->rate * (system->rate + flow->work.lane->omega_unit[lane]) * size, pressure);
    if (!(rebound * rebound <= tolerance * bound * slack))
        return end;
    const saltus_work *now = saltus_probe_at(flow, lane, flow->state, self->now.phase, &self->hold, 2);
    double acceleration = 2 * gap_coefficient(system, now, face, 2);
    end.leaving = leaving_faces(flow, lane, size, now);
    const unsigned kept = self->hold.faces & ~end.leaving;
    if (!saltus_contact_map_build(system, kept | 1u << face, 0, NULL, &flow->scratch))
        return end;
    memcpy(flow->trial, flow->state, (size_t)flow->dimension * sizeof(double));
    saltus_contact_map_apply(&flow->scratch, flow->dof, flow->trial + flow->dof);
    const saltus_contact_map *hold = &self->hold;
    if (end.leaving && saltus_contact_map_build(system, kept, 0, NULL, &flow->scratch))
        hold = &flow->scratch;
    const saltus_work *probe = saltus_probe_at(flow, lane, flow->trial, self->now.phase, hold, 3);
    double a = 2 * gap_coefficient(system, probe, face, 2),
           jerk = 6 * gap_coefficient(system, probe, face, 3);
    if (!(a > 0) || rebound * rebound > tolerance * a * slack)
        return end;
    double remainder = rebound > 0 && r != 1 ? 2 * rebound / (a * (1 - r)) : 0;
    bool steady = fabs(jerk) * remainder <= 0.1 * a && fabs(acceleration - a) <= 0.1 * a;
    if (r == 1 || rebound == 0 || steady)
        end.remainder = remainder;
    return end;
}

static saltus_event impact_event(const saltus_lane *self, int face, double speed) {
    saltus_face f = self->system->faces[face];
    return (saltus_event){.kind = SALTUS_IMPACT,
                          .face = face,
                          .time = self->now,
                          .velocity_before = f.side * speed,
                          .velocity_after =
                              -f.side * saltus_system_rebound(self->system, face, speed).r * speed,
                          .displacement = f.side * f.d};
}

/* Each closing face that receives an impulse has its own impact event. The hit face's is returned, the others
 * are queued. */
static saltus_event record_impacts(saltus_lane *self, int hit, unsigned rebounding, const double *velocity) {
    saltus_event event = {0};
    self->queued = 0;
    for (int f = 0; f < self->system->face_count; f++) {
        if (!(rebounding >> f & 1) && f != hit)
            continue;
        double speed = saltus_face_normal(self->system, f, velocity);
        if (f == hit)
            event = impact_event(self, f, speed > 0 ? speed : 0);
        else
            self->queue[self->queued++] = impact_event(self, f, speed);
        if (speed > 0) {
            self->info.impacts++;
            const saltus_rebound rebound = saltus_system_rebound(self->system, f, speed);
            const double volume = rebound.r * fabs(rebound.slope);
            if (volume != self->volume || volume == 0) { /* a constant restitution needs but one logarithm */
                self->volume = volume;
                self->log_volume = log(rebound.r) + log(fabs(rebound.slope));
            }
            self->info.log_volume += self->log_volume;
        }
    }
    return event;
}

/* Remove the rebound if its chatter ends here; then decide which touched faces hold. */
static chatter_end end_chatter_and_rest(saltus_flow *flow, int lane, int face, unsigned touched,
                                        double rebound, double pressure) {
    saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    const double *velocity = flow->state + flow->dof;
    double tiny = 64 * DBL_EPSILON * sqrt(saltus_dot(velocity, velocity, flow->dof));
    chatter_end end = end_of_chatter(flow, lane, face, rebound, pressure);
    unsigned resting = 0;
    if (end.remainder >= 0) {
        memcpy(flow->state, flow->trial, (size_t)flow->dimension * sizeof(double));
        tiny *= 16;
        resting = 1u << face;
    }
    /* Touched faces rest if their normal velocity is zero to rounding. */
    for (int f = 0; f < system->face_count; f++)
        if (touched >> f & 1) {
            if (fabs(saltus_face_normal(system, f, velocity)) <=
                tiny * system->stop_reach[system->faces[f].stop])
                resting |= 1u << f;
            self->face[f] = (saltus_face_state){.touch = 1};
        }
    saltus_contacts_rest(flow, lane, resting);
    saltus_contact_map_settle(system, &self->hold, flow->state);
    /* The velocities have changed, so the gap rates carried from the last step must follow. */
    for (int f = 0; f < system->face_count; f++)
        if (self->face[f].shadow)
            self->face[f].rate = saltus_face_normal(system, f, velocity);
    return end;
}

/* Whether the restitutions of an impact are between 0 and 1; otherwise sets the lane's `why`. */
static bool sound_rebounds(saltus_lane *self, const saltus_contact_map *map) {
    for (int k = 0; k < map->count; k++)
        if (!(map->r[k] >= 0 && map->r[k] <= 1)) {
            saltus_fail(
                &self->why, SALTUS_STALLED,
                "the motion ends at %.15g periods: the restitution of stop %d is %.6g at the closing speed "
                "%.6g; it must be from 0 to 1",
                saltus_time_periods(self->now), self->system->faces[map->face[k]].stop + 1, map->r[k],
                map->speed[k]);
            return false;
        }
    return true;
}

/* A bound on the acceleration towards a face after an impact on it alone has removed the normal velocity
 * `speed`, from the acceleration `before`. The field is smooth, so both are close for small speeds. */
static double pressure_bound(const saltus_flow *flow, int lane, int face, double before, double speed) {
    const saltus_system *system = flow->lane[lane].system;
    return 2 * fabs(before) + flow->dof * system->rate * system->stop_reply[system->faces[face].stop] * speed;
}

saltus_status saltus_contacts_impact(saltus_flow *flow, int lane, int face, double acceleration,
                                     saltus_event *event) {
    saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    saltus_contact_map *map = &flow->scratch;
    double *velocity = flow->state + flow->dof, velocity_before[SALTUS_MODES_MAX];
    const unsigned touched = touched_faces(self, flow->state, face),
                   closing = closing_faces(self, velocity, face, touched), held_before = self->hold.faces;
    if (!solve_impact(system, &face, touched, closing, velocity, map))
        return SALTUS_STALLED;
    if (system->by_speed && !sound_rebounds(self, map))
        return SALTUS_STALLED;
    const unsigned impulses = map->faces;
    memcpy(velocity_before, velocity, (size_t)flow->dof * sizeof *velocity);
    if (flow->options.columns)
        saltus_field_at(flow, lane, flow->state, self->now.phase, &self->hold, flow->before);
    *event = record_impacts(self, face, impulses & closing, velocity);
    saltus_contact_map_apply(map, flow->dof, velocity);

    const double speed = fabs(event->velocity_before),
                 rebound = saltus_system_rebound(system, face, speed).r * speed;
    const bool alone = touched == 1u << face;
    self->flight = acceleration > 0 ? 2 * rebound / acceleration : INFINITY;
    const double pressure = alone ? pressure_bound(flow, lane, face, acceleration, speed) : INFINITY;
    const chatter_end end = end_chatter_and_rest(flow, lane, face, touched, rebound, pressure);
    if (end.remainder >= 0 && system->by_speed >> face & 1 && system->faces[face].r == 1)
        return saltus_fail(
            &self->why, SALTUS_STALLED,
            "the motion ends at %.15g periods: the restitution of stop %d tends to 1 for small closing "
            "speeds, which has no lasting contact; its limit must be below 1",
            saltus_time_periods(self->now), system->faces[face].stop + 1);
    if (flow->options.columns && speed > 0) {
        const bool ends = end.remainder >= 0;
        const unsigned elastic = impulses & closing & ~(ends ? 1u << face : 0),
                       all = impulses | (ends ? held_before & ~end.leaving : 0);
        if (!saltus_contact_map_build(system, all, elastic, velocity_before, map))
            return SALTUS_STALLED;
        if (map->count > 1 && !(held_before | self->hold.faces) && elastic == all && apart(map)) {
            saltate_apart(flow, lane, face, map, velocity_before);
        } else {
            saltus_field_at(flow, lane, flow->state, self->now.phase, &self->hold, flow->after);
            saltate(flow, lane, face, speed, map, elastic, velocity_before);
        }
    }
    const unsigned caught = self->hold.faces & ~held_before;
    if (caught) {
        self->info.sticks++;
        event->kind = SALTUS_STICK;
        event->velocity_after = 0;
        event->time = saltus_time_after(self->now, end.remainder > 0 ? end.remainder / system->period : 0);
        if (!(caught >> face & 1)) {
            self->queue[self->queued++] = impact_event(self, face, speed);
            for (event->face = 0; !(caught >> event->face & 1);)
                event->face++;
            event->velocity_before = 0;
            event->displacement = system->faces[event->face].side * system->faces[event->face].d;
        }
    }
    return SALTUS_OK;
}

bool saltus_contacts_set(saltus_flow *flow, int lane, unsigned contacts) {
    saltus_lane *self = &flow->lane[lane];
    bool built = saltus_contact_map_build(self->system, contacts, 0, NULL, &self->hold);
    saltus_contacts_publish(flow, lane);
    return built;
}

/* Whether the step was too short to change the state by more than rounding. */
static bool stands_still(saltus_flow *flow, int lane) {
    const saltus_lane *self = &flow->lane[lane];
    const double *scale = saltus_system_scale(self->system);
    saltus_field_at(flow, lane, flow->state, self->now.phase, &self->hold, flow->after);
    for (int i = 0; i < flow->dimension; i++)
        if (fabs(flow->after[i]) * self->step.length >
            DBL_EPSILON * fmax(fabs(flow->state[i]), 1e-3 * scale[i]))
            return false;
    return true;
}

/* The force's zero comes from the step's polynomial and is exact to the tolerance; the acceleration at the
 * state itself decides the release, so that the gap begins as the flow will continue it. If the step was too
 * short to change the state, a remaining pressure is rounding: then the contact holds until its force pulls
 * by several times as much. */
bool saltus_contacts_release(saltus_flow *flow, int lane, int face) {
    const double distinct = 4;
    saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    const saltus_face f = system->faces[face];
    const unsigned contacts = self->hold.faces;
    const bool moved = self->now.phase != self->step.begin.phase || self->now.cycle != self->step.begin.cycle,
               still = moved && stands_still(flow, lane);
    saltus_contacts_set(flow, lane, contacts & ~(1u << face));
    const saltus_work *probe = saltus_probe_at(flow, lane, flow->state, self->now.phase, &self->hold, 2);
    const double pressing = gap_coefficient(system, probe, face, 2);
    if (moved && pressing > rounding_of_gap(system, probe, face, 2)) {
        const double reply =
            saltus_dot(system->stop_normal[f.stop], system->stop_impulse[f.stop], system->dof);
        saltus_contacts_set(flow, lane, contacts);
        if (still)
            self->face[face].pull = fmax(2 * self->face[face].pull, distinct * 2 * pressing / reply);
        return false;
    }
    self->info.releases++;
    self->face[face] = (saltus_face_state){.touch = 2};
    return true;
}
