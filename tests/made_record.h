/* A trajectory made up of a few numbers and a list of what happens in it, and the page that is drawn of it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_MADE_RECORD_H
#define SALTUS_TESTS_MADE_RECORD_H

#include "figure_folder.h"

enum { rows_most = 700, events_most = 24, states_most = 8, per_period = 24 };

static const double digits = 1e-8; /* numbers are written with nine digits */

/* A record that depends on a few numbers alone. */
typedef struct made_up {
    saltus_trajectory record;
    double time[rows_most], states[rows_most * states_most], displacement[rows_most], velocity[rows_most];
    double strobes[32 * states_most];
    saltus_event events[events_most];
    long long event_rows[events_most];
} made_up;

/* Something that happens in it. */
typedef struct happening {
    double time;
    saltus_event_kind kind;
    int face;
} happening;

static inline double observed(const saltus_system *system, const double *part) {
    double sum = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        sum += saltus_system_observer(system)[i] * part[i];
    return sum;
}

static inline double *add_row(made_up *m, const saltus_system *system, double time) {
    int n = saltus_system_dof(system), dimension = saltus_system_dimension(system);
    saltus_trajectory *r = &m->record;
    double *x = m->states + r->samples * dimension;
    assert_true(r->samples < rows_most && dimension <= states_most);
    for (int i = 0; i < n; i++) {
        x[i] = (0.031 + 0.003 * i) * cos(6.283 * time + i + 0.1 * time);
        x[n + i] = -(0.2 + 0.07 * i) * sin(6.283 * time + i + 0.1 * time);
    }
    m->time[r->samples] = time;
    m->displacement[r->samples] = observed(system, x);
    m->velocity[r->samples] = observed(system, x + n);
    r->samples++;
    return x;
}

static inline void add_event(made_up *m, const saltus_system *system, const happening *h) {
    saltus_face face = saltus_system_face(system, h->face);
    saltus_trajectory *r = &m->record;
    long long row = r->samples;
    double speed = face.side * (0.4 + 0.03 * (double)r->event_count);
    add_row(m, system, h->time);
    m->displacement[row] = face.side * face.d;
    m->velocity[row] = speed;
    if (h->kind != SALTUS_RELEASE) {
        add_row(m, system, h->time);
        m->displacement[row + 1] = face.side * face.d;
        m->velocity[row + 1] = h->kind == SALTUS_STICK ? 0 : -face.r * speed;
    }
    m->event_rows[r->event_count] = row;
    m->events[r->event_count++] =
        (saltus_event){.kind = h->kind,
                       .face = h->face,
                       .time = {(long long)h->time, h->time - floor(h->time)},
                       .velocity_before = h->kind == SALTUS_RELEASE ? 0 : speed,
                       .velocity_after = h->kind == SALTUS_IMPACT ? -face.r * speed : 0,
                       .displacement = face.side * face.d};
}

static inline void make_record(made_up *m, const saltus_system *system, int periods, const happening *list,
                               int count) {
    *m = (made_up){.record = {.dimension = saltus_system_dimension(system),
                              .time = m->time,
                              .states = m->states,
                              .displacement = m->displacement,
                              .velocity = m->velocity,
                              .events = m->events,
                              .event_rows = m->event_rows,
                              .strobe_states = m->strobes}};
    int next = 0;
    for (int k = 0; k <= periods * per_period; k++) {
        double time = (double)k / per_period;
        while (next < count && list[next].time < time)
            add_event(m, system, &list[next++]);
        double *x = add_row(m, system, time);
        if (k % per_period == 0 && k < periods * per_period)
            memcpy(m->strobes + m->record.strobes++ * m->record.dimension, x,
                   (size_t)m->record.dimension * sizeof *x);
    }
}

static inline saltus_scene scene_of(const saltus_system *system) {
    saltus_scene scene = {.spec = *saltus_system_spec(system)};
    strcpy(scene.name, "made_up");
    strcpy(scene.title, "it's {made} up");
    return scene;
}

static inline figure draw(const saltus_system *system, const saltus_diagnosis *diagnosis) {
    saltus_message message = {.text = ""};
    char path[path_size];
    saltus_scene scene = scene_of(system);
    saltus_flow_options options = saltus_flow_defaults();
    check_ok(saltus_write_sheet(path_in("sheet.svg", path), &scene, system, &options, diagnosis, NULL, NULL,
                                &message),
             &message);
    figure f = figure_taken(folder);
    assert_true(figure_begins(f.terminal, "svg "));
    figure_check_page(&f);
    return f;
}

/* A periodic motion of p periods with two multipliers. */
static saltus_multiplier pair_of_multipliers[2] = {{0.3, 0.4, -0.6931471805599453},
                                                   {0.3, -0.4, -0.6931471805599453}};

static inline saltus_motion orbit_of(int periods) {
    saltus_motion motion = {.verdict = SALTUS_PERIODIC,
                            .periods = periods,
                            .impacts = 3,
                            .stable = true,
                            .multipliers = pair_of_multipliers,
                            .multiplier_count = 2,
                            .lyapunov = -0.0625};
    snprintf(motion.label, sizeof motion.label, "3/%d", periods);
    return motion;
}

static inline saltus_motion irregular(void) {
    saltus_motion motion = {.verdict = SALTUS_UNDECIDED, .lyapunov = NAN, .lyapunov_error = NAN};
    strcpy(motion.label, "undecided");
    strcpy(motion.reason, "exponent 0.1 +- 0.2 and 0.3 +- 0.4 so far");
    return motion;
}

static inline saltus_system *between_stops(double d) {
    saltus_spec spec = oscillator_spec(0.125, 1.75, 1.5, 0.625);
    add_stop(&spec, d, 0.75, SALTUS_BOTH);
    return build(&spec);
}

static const happening two_impacts[] = {{0.2, SALTUS_IMPACT, 0},
                                        {0.7, SALTUS_IMPACT, 1},
                                        {1.26, SALTUS_IMPACT, 0},
                                        {1.8, SALTUS_IMPACT, 1},
                                        {2.3, SALTUS_IMPACT, 0}};

#endif
