/* Returns of a motion without forcing to its section, and cycles counted by them.
 *
 * If an expression defines the section, each step is examined through polynomials of the expression's values
 * along the dense output. Their rises through zero are isolated (flow/isolate.h) and refined on the
 * expression itself. The sign is carried from step to step, so that a zero at a step's end or a jump at an
 * impact is neither lost nor counted twice.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/poincare.h"

#include "base/memory.h"
#include "flow/isolate.h"
#include "orbit/multipliers.h"
#include "orbit/orbit.h"
#include "system/state.h"
#include "system/system.h"

#include <gsl/gsl_poly.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

unsigned saltus_crossings_watch(const saltus_system *system) {
    switch (saltus_system_poincare(system).kind) {
    case SALTUS_POINCARE_IMPACT:
        return SALTUS_WATCH_IMPACT | SALTUS_WATCH_STICK;
    case SALTUS_POINCARE_ZERO:
        return SALTUS_WATCH_CONTACT | SALTUS_WATCH_STEP;
    default:
        return SALTUS_WATCH_IMPACT | SALTUS_WATCH_STICK | SALTUS_WATCH_TURNING;
    }
}

/* Whether an impact is a return: it reverses the observed velocity to falling, or is on the section's side.
 * It matters if it reverses that velocity at all, or is on the section's stop. */
static bool strike(saltus_crossings *r, const saltus_system *system, const saltus_event *event,
                   const double *state) {
    enum { many = 32 };
    const double rounding = 1e-12; /* relative to the velocity before, for impacts without rebound */
    const double much = 0.1, speed = fabs(event->velocity_before);
    const saltus_poincare section = saltus_system_poincare(system);
    const saltus_face face = saltus_system_face(system, event->face);
    bool is_return, matters;
    if (section.kind == SALTUS_POINCARE_IMPACT) {
        matters = face.stop == section.stop;
        is_return = matters && (section.side == 0 || section.side == face.side);
    } else {
        /* The observed velocity before it, from the velocity after it and the impulse. */
        const double after = saltus_system_observed(system, state + saltus_system_dof(system)),
                     share = saltus_system_observed(system, system->stop_impulse[face.stop]),
                     before = after - share * (event->velocity_after - event->velocity_before);
        is_return = before > 0 && after <= rounding * before;
        matters = is_return || (before < 0 && after > 0);
    }
    if (!matters)
        return false;
    const bool again = r->struck && r->face == event->face;
    if (!again)
        r->spare = r->lively = 0;
    r->spare += again && is_return;
    /* Lively is an impact unless it is slower than the previous one by much of what that one took away, which
     * is all of it in the limit of complete chatter. A cycle regains the loss, and impacts that approach a
     * cycle nearly do. */
    r->lively += again && !(speed < r->speed - much * (r->speed - r->rebound));
    r->face = event->face;
    if (r->lively == many)
        r->chatters &= ~(1u << r->face);
    r->struck = true;
    r->rises = !is_return;
    r->speed = speed;
    r->rebound = fabs(event->velocity_after);
    return is_return;
}

/* The change of the number of returns by an event. */
static int count(saltus_crossings *r, const saltus_system *system, const saltus_event *event,
                 const double *state) {
    int change = 0;
    if (event->kind == SALTUS_TURNING && saltus_system_poincare(system).kind == SALTUS_POINCARE_MAXIMA) {
        change = event->velocity_before < 0; /* a maximum */
        if (change) {
            r->struck &= r->rises;
            r->spare = r->struck ? r->spare + 1 : 0;
        }
        r->rises = false;
    } else if (saltus_event_strikes(event))
        change = strike(r, system, event, state);
    r->waits = r->spare > 0 && r->chatters >> r->face & 1;
    if (event->kind == SALTUS_STICK && r->struck && r->face == event->face) {
        change -= r->spare;
        r->spare = 0;
        r->struck = r->rises = false;
        r->chatters |= 1u << r->face;
    }
    return change;
}

enum { pieces = 4, degree = 8 }; /* pieces of a step, and degree of their polynomials */

static double value_since(const saltus_flow *flow, int lane, double since) {
    double state[SALTUS_STATE_MAX];
    saltus_flow_dense(flow, lane, since, state);
    return saltus_system_poincare_value(saltus_flow_system(flow, lane), state);
}

/* Polynomial coefficients in s in [0, 1] from values at Chebyshev-Lobatto points, by divided differences. */
static void interpolate(const double *points, const double *values, double *powers) {
    double difference[degree + 1], work[degree + 1];
    gsl_poly_dd_init(difference, points, values, degree + 1);
    gsl_poly_dd_taylor(powers, 0, difference, points, degree + 1, work);
}

/* Refine a polynomial's zero on the expression itself, by bisection if the signs around it differ. */
static double refine(const saltus_flow *flow, int lane, double guess, double begin, double end) {
    const double around = 1e-3 * (end - begin);
    double low = fmax(begin, guess - around), high = fmin(end, guess + around);
    if (!(value_since(flow, lane, low) < 0 && value_since(flow, lane, high) >= 0))
        return guess;
    for (double middle = 0.5 * (low + high); middle > low && middle < high; middle = 0.5 * (low + high))
        *(value_since(flow, lane, middle) < 0 ? &low : &high) = middle;
    return high;
}

static void add_zero(saltus_crossings *r, double since) {
    if (r->zeros < SALTUS_ZEROS_MAX)
        r->zero[r->zeros++] = since;
}

/* Examine a piece of a step: in halves if the polynomial does not follow the expression, and once more behind
 * each zero. A zero already met, such as one at the beginning (`met`), is not met again if rounding, which is
 * at least `rounding`, restores the sign. */
static void look(saltus_crossings *r, const saltus_flow *flow, int lane, double begin, double end, bool met,
                 double rounding) {
    const double close = 1e-6, shortest = 1e-3 * saltus_flow_step_length(flow, lane);
    double points[degree + 1], values[degree + 1], powers[degree + 1], root, size = 0, lowest = INFINITY;
    for (int k = 0; k <= degree; k++) {
        points[k] = 0.5 - 0.5 * cos(M_PI * k / degree);
        values[k] = value_since(flow, lane, begin + points[k] * (end - begin));
        size = fmax(size, fabs(values[k]));
        lowest = fmin(lowest, values[k]);
    }
    const double between = 0.5 * (points[degree / 2] + points[degree / 2 + 1]), middle = 0.5 * (begin + end);
    rounding = fmax(rounding, 1e-12 * size);
    if (met && lowest > -rounding) {
        r->below = false;
        return;
    }
    interpolate(points, values, powers);
    if (end - begin > shortest &&
        fabs(gsl_poly_eval(powers, degree + 1, between) -
             value_since(flow, lane, begin + between * (end - begin))) > close * size) {
        look(r, flow, lane, begin, middle, met, rounding);
        look(r, flow, lane, middle, end, false, rounding);
        return;
    }
    if (r->begun && r->below && (values[0] >= 0 || (values[0] > -rounding && values[1] >= 0))) {
        add_zero(r, begin);
        met = true;
    }
    if (r->begun && (met || !r->below) && values[0] > -rounding) {
        values[0] = fmax(values[0], rounding);
        interpolate(points, values, powers);
    }
    /* The polynomial's rounding may hide a rise at the very end. */
    const bool rises = saltus_isolate_rise(powers, degree, &root), ends_above = values[degree] >= 0;
    const double zero = rises ? refine(flow, lane, begin + root * (end - begin), begin, end) : end;
    const bool crosses = rises ? zero < end || ends_above : values[0] < 0 && ends_above;
    if (crosses)
        add_zero(r, zero);
    r->begun = true;
    r->below = values[degree] < (met || crosses ? -rounding : 0);
    if (crosses && zero > begin && zero < end && r->zeros < SALTUS_ZEROS_MAX &&
        value_since(flow, lane, zero) >= 0) {
        r->below = false;
        look(r, flow, lane, zero, end, true, rounding);
    }
}

void saltus_crossings_take(saltus_crossings *r, const saltus_flow *flow, int lane, const saltus_event *event,
                           const double *state) {
    const saltus_system *system = saltus_flow_system(flow, lane);
    r->change = r->zeros = r->told = 0;
    r->time = event->time;
    if (saltus_system_poincare(system).kind != SALTUS_POINCARE_ZERO) {
        r->change = event->kind == SALTUS_REACHED ? 0 : count(r, system, event, state);
        return;
    }
    const double length = saltus_flow_step_length(flow, lane);
    for (int k = 0; k < pieces && length > 0; k++)
        look(r, flow, lane, length * k / pieces, length * (k + 1) / pieces, false, 0);
}

/* The next change of the number of returns by the last event: 1 for a return, whose state replaces the
 * present one; negative if chatter completes, which takes back its returns but the first impact; 0: no
 * more. */
static int next_change(saltus_crossings *r, const saltus_flow *flow, int lane, double *state,
                       saltus_time *time) {
    *time = r->time;
    if (r->told < r->zeros) {
        double since = r->zero[r->told++];
        saltus_time begin = saltus_flow_step_begin(flow, lane);
        saltus_flow_dense(flow, lane, since, state);
        *time = saltus_time_of(begin.phase + since / saltus_system_period(saltus_flow_system(flow, lane)));
        time->cycle += begin.cycle;
        saltus_state_admit(saltus_flow_system(flow, lane), state);
        return 1;
    }
    int change = r->change;
    r->change = 0;
    /* Rounding must not put a section point beyond the stop that it lies on. */
    if (change > 0)
        saltus_state_admit(saltus_flow_system(flow, lane), state);
    return change;
}

bool saltus_crossings_count(saltus_crossings *r, const saltus_flow *flow, int lane, double *state,
                            saltus_time *time) {
    int change;
    while ((change = next_change(r, flow, lane, state, time)) != 0)
        if (change > 0 && !r->waits)
            return true;
    return false;
}

/* The returns of a lap, with time, rank, speed of an impact, and state. */
typedef struct section {
    saltus_crossings returns;
    const saltus_pieces *pieces; /* of the walk, which begins this much later than they count from */
    double later;
    int n;
    saltus_list rows;
    double begin; /* of the present walk */
    double cut;   /* when a contact last began outside a chatter; 0: never */
    int early;    /* number of rows before `cut` */
} section;

enum { row_time, row_rank, row_speed, row_state };

static double *row_of(const section *s, int k) {
    return (double *)s->rows.items + (size_t)k * (size_t)(s->n + row_state);
}

/* Add or take back the returns due to an event. False without memory. */
static bool note(section *s, const saltus_flow *flow, const saltus_event *event, const double *now) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    const saltus_poincare_kind kind = saltus_system_poincare(system).kind;
    const double speed = saltus_event_strikes(event) ? fabs(event->velocity_before) : 0;
    double state[SALTUS_STATE_MAX];
    saltus_time time;
    int change;
    saltus_crossings_take(&s->returns, flow, 0, event, now);
    memcpy(state, now, (size_t)s->n * sizeof *state);
    while ((change = next_change(&s->returns, flow, 0, state, &time)) != 0) {
        if (change < 0) {
            s->rows.count += change;
            continue;
        }
        double *row = saltus_list_add(&s->rows, (size_t)(s->n + row_state) * sizeof *row);
        if (!row)
            return false;
        row[row_time] = s->begin + saltus_time_periods(time);
        row[row_speed] = speed;
        /* The quantity that section points are ordered by. */
        row[row_rank] = kind == SALTUS_POINCARE_IMPACT ? fabs(event->velocity_before)
                        : kind == SALTUS_POINCARE_ZERO ? saltus_system_observed(system, state)
                                                       : saltus_event_displacement(system, event, state);
        memcpy(row + row_state, state, (size_t)s->n * sizeof *state);
    }
    return true;
}

/* Whether row a comes before row b: by rank, then by impact speed. Zeros of an expression may all have the
 * same rank: they are ordered by the first state entry in which they differ. */
static bool is_higher(const section *s, const saltus_system *system, int a, int b) {
    const double alike = 1e-6, *p = row_of(s, a), *q = row_of(s, b);
    if (saltus_system_poincare(system).kind != SALTUS_POINCARE_ZERO)
        return p[row_rank] > q[row_rank] || (p[row_rank] == q[row_rank] && p[row_speed] > q[row_speed]);
    for (int i = 0; i < s->n; i++)
        if (fabs(p[row_state + i] - q[row_state + i]) > alike * saltus_system_scale(system)[i])
            return p[row_state + i] > q[row_state + i];
    return false;
}

/* Turn the section's rows into the lap's points, beginning with the highest. */
static bool hand_over(saltus_lap *lap, const section *s, const saltus_system *system, const double *state) {
    size_t n = (size_t)s->n;
    int highest = 0;
    lap->returns = s->rows.count;
    lap->periods = s->rows.count > 0 ? s->rows.count : 1;
    if (!saltus_lap_reserve(lap, lap->periods, s->n))
        return false;
    memcpy(lap->points, state, n * sizeof *state);
    for (int k = 1; k < s->rows.count; k++)
        if (is_higher(s, system, k, highest))
            highest = k;
    for (int k = 0; k < s->rows.count; k++)
        memcpy(lap->points + (size_t)k * n, row_of(s, (highest + k) % s->rows.count) + row_state,
               n * sizeof *state);
    if (s->rows.count == 0) {
        lap->first = 0;
        return true;
    }
    /* The events' times are counted from there. */
    const double origin = fmod(row_of(s, highest)[row_time], 1);
    lap->first += origin;
    int first = 0;
    for (int k = 0; k < lap->event_count; k++) {
        const double time = saltus_time_periods(lap->events[k].time) - origin;
        first += time < 0;
        lap->events[k].time = saltus_time_of(time < 0 ? time + 1 : time);
    }
    for (int turn = 0; turn < first; turn++) {
        const saltus_event event = lap->events[0];
        memmove(lap->events, lap->events + 1, (size_t)(lap->event_count - 1) * sizeof event);
        lap->events[lap->event_count - 1] = event;
    }
    return true;
}

saltus_status saltus_cycle_leave(saltus_flow *flow, double *state, double *later, saltus_message *message) {
    const unsigned watch =
        SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING | saltus_crossings_watch(saltus_flow_system(flow, 0));
    const double own = 1e-6; /* sooner it is the event at the start itself */
    saltus_crossings returns = {0};
    saltus_event event = {.kind = SALTUS_STEP};
    saltus_time time;
    double next = 0, now[SALTUS_STATE_MAX]; /* the event reached, or the first return that it implies */
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    while (status == SALTUS_OK && next == 0) {
        status = saltus_flow_advance(flow, (saltus_time){1, 0}, watch, &event, message);
        if (status != SALTUS_OK)
            break;
        double at = event.kind == SALTUS_STEP ? 0 : saltus_time_periods(event.time);
        next = at > own ? at : 0;
        saltus_flow_state(flow, 0, now);
        saltus_crossings_take(&returns, flow, 0, &event, now);
        while (next_change(&returns, flow, 0, now, &time) != 0) {
            at = saltus_time_periods(time);
            if (at > own && (next == 0 || at < next))
                next = at;
        }
    }
    *later = 0.5 * next;
    return status == SALTUS_OK
               ? saltus_state_carry(flow, (saltus_time){0, 0}, saltus_time_of(*later), state, message)
               : status;
}

/* Walk from a state on the orbit for a time, at most a period, collecting returns and, with `lap`, events. */
static saltus_status walk(section *s, saltus_lap *lap, saltus_flow *flow, const double *start, double length,
                          saltus_message *message) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    const unsigned watch = SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING | saltus_crossings_watch(system);
    const bool chosen = saltus_system_poincare(system).kind == SALTUS_POINCARE_ZERO;
    const double now = 1e-12; /* periods: more than rounding */
    const int pieces = s->pieces ? s->pieces->count : 0;
    double state[SALTUS_STATE_MAX], time = 0;
    int piece = 0;
    saltus_event event = {.kind = SALTUS_STEP};
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, message);
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED &&
           !(event.kind == SALTUS_STICK && time >= length)) {
        while (piece < pieces && s->pieces->time[piece] - s->later <= time + now)
            piece++;
        const saltus_time until =
            piece < pieces ? saltus_time_of(s->pieces->time[piece] - s->later) : (saltus_time){1, 0};
        status = saltus_flow_advance(flow, until, watch, &event, message);
        time = saltus_time_periods(event.time);
        saltus_flow_state(flow, 0, state);
        if (status == SALTUS_OK &&
            !((!lap || saltus_lap_add(lap, &event, state)) && note(s, flow, &event, state)))
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the events of an orbit");
        if (lap && event.kind == SALTUS_STICK && s->returns.spare == 0 && !chosen) {
            s->cut = time;
            s->early = s->rows.count;
        }
        if (status == SALTUS_OK && event.kind == SALTUS_REACHED && piece < pieces) {
            event.kind = SALTUS_STEP;
            status =
                saltus_flow_start(flow, 0, until, s->pieces->state + (size_t)piece * (size_t)s->n, message);
        }
    }
    return status;
}

saltus_status saltus_lap_cycle(saltus_lap *lap, saltus_flow *flow, const double *start,
                               const saltus_pieces *pieces, saltus_message *message) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    section s = {.pieces = pieces, .n = saltus_system_dimension(system)};
    double state[SALTUS_STATE_MAX], end[SALTUS_STATE_MAX], later;
    memcpy(state, start, (size_t)s.n * sizeof *state);
    saltus_status status = saltus_cycle_leave(flow, state, &later, message);
    saltus_lap_begin(lap, system, state);
    lap->first = s.later = later;
    if (status == SALTUS_OK)
        status = walk(&s, lap, flow, state, INFINITY, message);
    if (status == SALTUS_OK) {
        lap->contacts = saltus_flow_contacts(flow, 0);
        lap->square = saltus_flow_information(flow, 0).square;
        lap->watched = 1;
        saltus_flow_state(flow, 0, end);
    }
    if (status == SALTUS_OK && s.cut != 0) {
        /* The walk may have begun amid the impacts of a chatter: follow that to the end of its contact, and
         * keep the returns after it. */
        s.begin = 1;
        status = walk(&s, NULL, flow, state, s.cut, message);
        s.rows.count -= s.early;
        if (s.rows.count > 0)
            memmove(row_of(&s, 0), row_of(&s, s.early),
                    (size_t)s.rows.count * (size_t)(s.n + row_state) * sizeof(double));
    }
    if (status == SALTUS_OK && !hand_over(lap, &s, system, start))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the points of an orbit");
    if (status == SALTUS_OK)
        memcpy(lap->end, end, (size_t)s.n * sizeof *end);
    free(s.rows.items);
    return status;
}

saltus_status saltus_cycle_polish(const saltus_system *system, const double *guess,
                                  const saltus_orbit_options *options, saltus_orbit *orbit,
                                  saltus_system **clocked, saltus_lap *lap, saltus_message *message) {
    saltus_orbit_options shooting = *options;
    saltus_flow *flow = NULL;
    const double still = 1e-9;
    double field[SALTUS_STATE_MAX] = {0}, speed = 0;
    int part = 1;
    shooting.free_period = true;
    *clocked = NULL;
    saltus_status status =
        saltus_orbit_search(system, 1, guess, &shooting, SALTUS_MULTIPLIERS_NONE, orbit, message);
    if (status == SALTUS_OK)
        status = saltus_system_clocked(system, orbit->omega, clocked, message);
    if (status == SALTUS_OK)
        status = saltus_flow_single(*clocked, 0, &options->flow, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, orbit->state, message);
    if (status == SALTUS_OK)
        saltus_flow_field(flow, 0, field);
    /* A rest closes after any time: how far would the flow go in a period at its speed at the base? */
    for (int i = 0; i < saltus_system_dimension(system) && status == SALTUS_OK; i++)
        speed =
            fmax(speed, fabs(field[i]) / saltus_system_scale(*clocked)[i] * saltus_system_period(*clocked));
    if (status == SALTUS_OK && speed < still)
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "Newton's iteration ends in a rest");
    if (status == SALTUS_OK)
        status = saltus_lap_cycle(lap, flow, orbit->state, NULL, message);
    if (status == SALTUS_OK)
        part = lap->periods / saltus_lap_least_period(lap, &options->flow);
    saltus_flow_free(flow);
    if (status == SALTUS_OK && part == 1) {
        status = saltus_orbit_multipliers(*clocked, &shooting, orbit, message);
        if (status == SALTUS_OK)
            return status;
    }
    saltus_orbit longer = *orbit;
    saltus_system *slower = *clocked;
    *orbit = (saltus_orbit){0};
    *clocked = NULL;
    saltus_system *faster = NULL;
    if (status == SALTUS_OK)
        status = saltus_system_clocked(slower, longer.omega * part, &faster, message);
    if (status == SALTUS_OK)
        status = saltus_cycle_polish(faster, longer.state, options, orbit, clocked, lap, message);
    saltus_system_free(faster);
    saltus_system_free(slower);
    saltus_orbit_clear(&longer);
    return status;
}
