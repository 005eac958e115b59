/* A flow under watch: every step's dense output is sampled and held against the equations of stress_field.h.
 *
 * Each invariant keeps its largest violation in units of what rounding and the tolerance allow, so that a
 * value above 1 is a failure whatever the scene's sizes are:
 *   gap      no stop is passed, at the step's end or between
 *   contact  a face that holds stays on its stop, and its force does not pull
 *   motion   every step solves the equations of motion: x(h) - x(0) = integral of the field along it
 *   impact   q stays, n.q' becomes -r n.q' (0 where the contact holds), the rest of q' answers to impulses
 * along the normals alone; chatter ends when it has become small, and only under pressure energy   energy =
 * energy at the start + work of damping, flow and forcing - losses of the impacts
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_STRESS_WATCH_H
#define SALTUS_TESTS_STRESS_WATCH_H

#include "stress_field.h"

#include <float.h>
#include <gsl/gsl_integration.h>

enum { stress_samples = 24 };

typedef enum stress_invariant {
    stress_is_gap,
    stress_is_contact,
    stress_is_motion,
    stress_is_impact,
    stress_is_energy,
    stress_invariants
} stress_invariant;

static const char *const stress_names[stress_invariants] = {"gap", "contact", "motion", "impact", "energy"};

typedef struct stress_watch {
    stress_model model;
    saltus_system *system;
    saltus_flow *flow;
    saltus_flow_options options;
    gsl_integration_glfixed_table *rule;
    double worst[stress_invariants], when[stress_invariants];
    double omega_unit;
    double energy, balance; /* now; what is not accounted for */
    double throughput;      /* all energy that was exchanged */
    double largest_energy;  /* the highest so far */
    double doubt;           /* what the tolerances of the steps leave open in the energy */
    long long steps;
    bool grown;                            /* beyond all bounds: nothing more can be said */
    unsigned held;                         /* faces that held during the step at hand */
    double unit[SALTUS_FACES_MAX];         /* what rounding makes of the faces' gaps, so far */
    double speed, length;                  /* the largest so far */
    double before[stress_dimension_max];   /* state at the step's end, its event not yet applied */
    double after[stress_dimension_max];    /* state now */
    double residual[stress_dimension_max]; /* x(h) - x(0) - integral of the field */
    double path[stress_dimension_max];     /* integral of the moduli of the field's terms */
    saltus_message message;
} stress_watch;

static inline double stress_now(const stress_watch *w) {
    return saltus_time_periods(saltus_flow_time(w->flow, 0));
}

static inline void stress_note(stress_watch *w, stress_invariant k, double violation) {
    if (violation > w->worst[k] || isnan(violation)) {
        w->worst[k] = isnan(violation) ? INFINITY : violation;
        w->when[k] = stress_now(w);
    }
}

static inline double stress_size(const stress_watch *w, const double *x) {
    double size = 0;
    for (int i = 0; i < w->model.dof; i++)
        size = fmax(size, fmax(fabs(x[i]), fabs(x[w->model.dof + i]) / w->omega_unit));
    return w->model.extra ? fmax(size, fabs(x[2 * w->model.dof])) : size;
}

/* What a step may be wrong by, in displacements. */
static inline double stress_tolerance(const stress_watch *w, const double *x) {
    return w->options.atol + (w->options.rtol + 8 * DBL_EPSILON) * stress_size(w, x);
}

static inline bool stress_explicit(const stress_watch *w) {
    return w->options.integrator == SALTUS_TAYLOR ||
           (w->options.integrator == SALTUS_AUTOMATIC &&
            strcmp(saltus_system_integrator(w->system), "taylor") == 0);
}

static inline void stress_watch_close(stress_watch *w) {
    saltus_flow_free(w->flow);
    saltus_system_free(w->system);
    gsl_integration_glfixed_table_free(w->rule);
}

/* Build and start; what is refused is told in `message`. To be closed in any case. */
static inline saltus_status stress_watch_open(stress_watch *w, const saltus_spec *spec,
                                              const saltus_flow_options *options, double phase,
                                              const double *state) {
    memset(w, 0, sizeof *w);
    w->options = *options;
    w->length = w->speed = DBL_MIN;
    w->rule = gsl_integration_glfixed_table_alloc(stress_samples);
    saltus_status status = saltus_system_new(spec, &w->system, &w->message);
    if (status != SALTUS_OK)
        return status;
    stress_model_read(&w->model, spec);
    const double *scale = saltus_system_scale(w->system);
    w->omega_unit = scale[w->model.dof] / scale[0];
    status = saltus_flow_new((const saltus_system *[]){w->system}, 1, options, &w->flow, &w->message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(w->flow, 0, (saltus_time){0, phase}, state, &w->message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_state(w->flow, 0, w->after);
    w->energy = w->largest_energy = stress_energy(&w->model, w->after);
    return SALTUS_OK;
}

/* Steps are taken with more than the tolerance: by the stiff integrator up to 30 times. */
static inline double stress_excess(const stress_watch *w) {
    return stress_explicit(w) ? 1 : 30;
}

/* The free field's accelerations at a sample, contacts applied; the forces that hold must push. */
static inline void stress_sample_field(stress_watch *w, double phase, const double *x, double *a,
                                       double *size) {
    const stress_model *m = &w->model;
    double reaction[SALTUS_FACES_MAX];
    stress_field(m, phase, x, a, size);
    if (!w->held || !stress_reactions(m, w->held, a, reaction))
        return;
    for (int f = 0; f < m->face_count; f++) {
        if (!(w->held >> f & 1))
            continue;
        double terms = 0, moved = 0;
        for (int i = 0; i < m->dof; i++) {
            terms += fabs(m->face[f].normal[i]) * size[i];
            moved += fabs(m->face[f].normal[i]) * (stress_tolerance(w, x) + 64 * DBL_EPSILON * w->length);
        }
        moved *= gsl_pow_2(w->omega_unit + stress_rate(m, stress_size(w, x)));
        double allowed =
            16384 * DBL_EPSILON * terms + 8 * stress_excess(w) * (w->options.rtol * terms + moved);
        stress_note(w, stress_is_contact, -reaction[f] * stress_compliance(m, f, f) / (allowed + DBL_MIN));
        stress_note(w, stress_is_contact, fabs(stress_gap(m, f, x)) / (16384 * w->unit[f]));
    }
    stress_react(m, reaction, a);
}

static inline void stress_sample_gaps(stress_watch *w, const double *x, double *largest) {
    for (int f = 0; f < w->model.face_count; f++) {
        double gap = stress_gap(&w->model, f, x);
        largest[f] = fmax(largest[f], gap);
        if (!(w->held >> f & 1))
            stress_note(w, stress_is_gap, gap / (128 * w->unit[f]));
    }
}

/* Between the samples a gap may stand higher: the parabola through the highest sample and its neighbours. */
static inline void stress_sample_peaks(stress_watch *w, const double *since, double gaps[][SALTUS_FACES_MAX],
                                       int count) {
    double x[stress_dimension_max], ignored[SALTUS_FACES_MAX] = {0};
    for (int f = 0; f < w->model.face_count; f++)
        for (int k = 1; k + 1 < count; k++) {
            double a = gaps[k - 1][f], b = gaps[k][f], c = gaps[k + 1][f];
            if (b < a || b < c)
                continue;
            double l = since[k] - since[k - 1], r = since[k + 1] - since[k];
            double slope = (r * (b - a) / l + l * (c - b) / r) / (l + r);
            double curvature = ((c - b) / r - (b - a) / l) * 2 / (l + r);
            double top = since[k] - (curvature < 0 ? slope / curvature : 0);
            saltus_flow_dense(w->flow, 0, fmin(fmax(top, since[k - 1]), since[k + 1]), x);
            stress_sample_gaps(w, x, ignored);
        }
}

/* Add one quadrature point's share to the step's integrals. */
static inline void stress_sample_motion(stress_watch *w, double phase, double weight, const double *x,
                                        double *work) {
    const stress_model *m = &w->model;
    double a[stress_dof_max], size[stress_dof_max], parts;
    stress_sample_field(w, phase, x, a, size);
    *work += weight * stress_power(m, phase, x, &parts);
    w->throughput += weight * parts;
    for (int i = 0; i < m->dof; i++) {
        w->residual[i] -= weight * x[m->dof + i];
        w->residual[m->dof + i] -= weight * a[i];
        w->path[i] += weight * fabs(x[m->dof + i]);
        w->path[m->dof + i] += weight * size[i];
    }
    if (m->extra) {
        w->residual[2 * m->dof] -= weight * stress_extra_rate(m, x);
        w->path[2 * m->dof] += weight * (fabs(m->kz * x[m->dof]) + fabs(x[2 * m->dof] / m->tz));
    }
}

static inline void stress_judge_motion(stress_watch *w, double step, const double *begin) {
    const stress_model *m = &w->model;
    double size = fmax(stress_size(w, begin), stress_size(w, w->before)), work = 0, force = 0;
    double tolerance = 8 * stress_excess(w) * (w->options.atol + (w->options.rtol + 8 * DBL_EPSILON) * size);
    tolerance *= 1 + step * (w->omega_unit + stress_rate(m, size));
    for (int i = 0; i < m->dimension; i++) {
        double unit = i < m->dof ? 1 : i < 2 * m->dof ? w->omega_unit : fmax(1, m->kz);
        double residual = w->residual[i] + w->before[i] - begin[i];
        double rounding = w->path[i] + (i < m->dof ? w->length : i < 2 * m->dof ? w->speed : 0);
        stress_note(w, stress_is_motion,
                    fabs(residual) / (unit * tolerance + 262144 * DBL_EPSILON * rounding + 1e-300));
        if (i >= m->dof)
            continue;
        work +=
            stress_mass(m, i) * (w->path[m->dof + i] / step + w->omega_unit * fabs(w->before[m->dof + i]));
        force += sqrt(stress_mass(m, i)) * w->path[m->dof + i];
    }
    w->doubt += tolerance * work + 512 * DBL_EPSILON * w->speed * force;
}

/* The stiff integrator's polynomials of degree 15 are Legendre's in powers of time: their last terms, as
 * large as the tolerance, are sums of terms (3 + sqrt 8)^15 = 3e11 times as large, which leaves 7e-5 of the
 * tolerance to rounding. */
static inline double stress_series_noise(const stress_watch *w) {
    return DBL_EPSILON + (stress_explicit(w) ? 0 : 7e-5 * w->options.rtol);
}

/* What rounding makes of gaps and velocities follows from the largest that have occurred: what was lost at a
 * large displacement is not found again at a small one. */
static inline void stress_take_units(stress_watch *w, double samples[][stress_dimension_max], int count) {
    const stress_model *m = &w->model;
    const double noise = stress_series_noise(w), step = saltus_flow_step_length(w->flow, 0);
    double a[stress_dof_max], size[stress_dof_max];
    stress_field(m, saltus_flow_step_begin(w->flow, 0).phase, samples[0], a, size);
    for (int f = 0; f < m->face_count; f++) {
        double moved = 0;
        for (int i = 0; i < m->dof; i++)
            moved += fabs(m->face[f].normal[i]) * (step * fabs(samples[0][m->dof + i]) +
                                                   step * step * size[i] + (w->held ? w->length : 0));
        w->unit[f] = fmax(w->unit[f], DBL_EPSILON * moved);
    }
    for (int k = 0; k < count; k++) {
        w->speed = fmax(w->speed, sqrt(2 * stress_kinetic(m, samples[k] + m->dof)));
        for (int i = 0; i < m->dof; i++)
            w->length = fmax(w->length, fabs(samples[k][i]));
        for (int f = 0; f < m->face_count; f++)
            w->unit[f] = fmax(w->unit[f], noise * stress_gap_size(m, f, samples[k]) + DBL_MIN);
    }
}

/* All of the last step but its event. */
static inline void stress_sample_step(stress_watch *w) {
    enum { count = stress_samples + 2 };
    double step = saltus_flow_step_length(w->flow, 0), since[count], weight[count], work = 0;
    double gaps[count][SALTUS_FACES_MAX], samples[count][stress_dimension_max];
    double phase = saltus_flow_step_begin(w->flow, 0).phase, period = saltus_system_period(w->system);
    memset(w->residual, 0, sizeof w->residual);
    memset(w->path, 0, sizeof w->path);
    for (int k = 0; k < count; k++) {
        since[k] = k ? step : 0;
        if (k > 0 && k < count - 1)
            gsl_integration_glfixed_point(0, step, (size_t)k - 1, &since[k], &weight[k], w->rule);
        saltus_flow_dense(w->flow, 0, since[k], samples[k]);
    }
    const double *begin = samples[0];
    stress_take_units(w, samples, count);
    memcpy(w->before, samples[count - 1], sizeof w->before);
    for (int k = 0; k < count; k++) {
        for (int f = 0; f < SALTUS_FACES_MAX; f++)
            gaps[k][f] = -INFINITY;
        stress_sample_gaps(w, samples[k], gaps[k]);
        if (k > 0 && k < count - 1)
            stress_sample_motion(w, phase + since[k] / period, weight[k], samples[k], &work);
    }
    if (!(step > 0))
        return;
    stress_sample_peaks(w, since, gaps, stress_samples + 2);
    stress_judge_motion(w, step, begin);
    double energy = stress_energy(&w->model, w->before);
    w->balance += energy - w->energy - work;
    w->energy = energy;
}

/* Faces that the state before an event touches. */
static inline unsigned stress_touched(const stress_watch *w, int hit) {
    unsigned touched = w->held | 1u << hit;
    for (int f = 0; f < w->model.face_count; f++)
        if (stress_gap(&w->model, f, w->before) > -64 * w->unit[f])
            touched |= 1u << f;
    return touched;
}

/* A face that begins to hold must be pressed, and what is left of its chatter must be small. */
static inline void stress_judge_stick(stress_watch *w, int face, double rebound) {
    const stress_model *m = &w->model;
    double a[stress_dof_max], size[stress_dof_max], terms = 0, r = m->face[face].r;
    stress_field(m, saltus_flow_time(w->flow, 0).phase, w->after, a, size);
    for (int i = 0; i < m->dof; i++)
        terms += fabs(m->face[face].normal[i]) * size[i];
    double press = stress_normal(m, face, a), height = rebound * rebound;
    double tolerance = fmax(stress_tolerance(w, w->before), stress_tolerance(w, w->after));
    stress_note(w, stress_is_impact, -press / (64 * DBL_EPSILON * terms + 1e-300));
    if (rebound > 0)
        stress_note(w, stress_is_impact,
                    height / (tolerance * fmax(press, 0) * (r < 1 ? 1 - r : 2) + 1e-300));
}

/* Where chatter ends at one face, the rebound that is dropped there moves the others. */
static inline double stress_slack(const stress_watch *w, int face) {
    const stress_model *m = &w->model;
    unsigned caught = saltus_flow_contacts(w->flow, 0) & ~w->held;
    double slack = 0;
    for (int f = 0; f < m->face_count; f++)
        if (caught >> f & 1 && f != face)
            slack += fabs(stress_compliance(m, f, face)) / stress_compliance(m, f, f) * m->face[f].r *
                     fmax(stress_normal(m, f, w->before + m->dof), 0);
    return 2 * slack;
}

/* A held face may be kept where an impact elsewhere would let it rise by less than the tolerance. */
static inline double stress_hop(const stress_watch *w, int face) {
    const stress_model *m = &w->model;
    double a[stress_dof_max], size[stress_dof_max], force[SALTUS_FACES_MAX];
    stress_field(m, saltus_flow_time(w->flow, 0).phase, w->before, a, size);
    if (!(w->held >> face & 1) || !stress_reactions(m, w->held, a, force))
        return 0;
    return sqrt(2 * stress_tolerance(w, w->before) * fmax(force[face], 0) * stress_compliance(m, face, face));
}

/* One face's part in an event: rates before and after, its impulse. Returns the energy that it takes. */
static inline double stress_judge_face(stress_watch *w, int face, double impulse, double rounding) {
    const stress_model *m = &w->model;
    unsigned holds = saltus_flow_contacts(w->flow, 0), caught = holds & ~w->held;
    double before = stress_normal(m, face, w->before + m->dof);
    double after = stress_normal(m, face, w->after + m->dof);
    double compliance = stress_compliance(m, face, face), r = m->face[face].r;
    double unit = rounding * sqrt(compliance) * w->speed + stress_slack(w, face);
    bool hit = impulse * compliance > unit && !(w->held >> face & 1), rests = holds >> face & 1;
    double expected = hit && !rests ? -r * fmax(before, 0) : 0;
    stress_note(w, stress_is_impact, -impulse * compliance / (unit + stress_hop(w, face)));
    if (w->held >> face & 1)
        stress_note(w, stress_is_impact, after / unit);
    if (hit || rests)
        stress_note(w, stress_is_impact, fabs(after - expected) / unit);
    if (caught >> face & 1 && m->face_count == 1)
        stress_judge_stick(w, face, r * fmax(before, 0));
    double kept = rests ? 0 : r;
    return hit ? 0.5 * (1 - kept * kept) * before * before / compliance : 0;
}

/* The state before and after an event at the step's end. */
static inline void stress_judge_event(stress_watch *w, int hit) {
    const stress_model *m = &w->model;
    const int n = m->dof;
    unsigned touched = stress_touched(w, hit);
    double change[stress_dof_max], reaction[SALTUS_FACES_MAX], largest = 0, loss = 0, rest = 0;
    int impulses = 0;
    for (int i = 0; i < n; i++) {
        change[i] = w->after[n + i] - w->before[n + i];
        rest = fmax(rest, fabs(w->after[i] - w->before[i]));
    }
    stress_note(w, stress_is_impact, rest / (65536 * stress_series_noise(w) * w->length));
    const double energy = stress_energy(m, w->after), change_of_energy = energy - w->energy;
    w->throughput += fabs(change_of_energy);
    w->energy = energy;
    if (!stress_reactions(m, touched, change, reaction))
        return;
    for (int f = 0; f < m->face_count; f++)
        impulses += reaction[f] < 0;
    const double rounding = (impulses > 1 ? 65536 : 1024) * stress_series_noise(w);
    for (int f = 0; f < m->face_count; f++)
        if (touched >> f & 1)
            loss += stress_judge_face(w, f, -reaction[f], rounding);
    stress_react(m, reaction, change);
    for (int i = 0; i < n; i++) {
        double unit = rounding * w->speed / sqrt(stress_mass(m, i));
        largest = fmax(largest, fabs(change[i]) / unit);
    }
    stress_note(w, stress_is_impact, largest);
    stress_note(w, stress_is_impact, fabs(stress_gap(m, hit, w->before)) / (1024 * w->unit[hit]));
    w->balance += impulses == 1 ? change_of_energy + loss : 0;
}

/* Each step may be wrong by its tolerance, as far as that moves the energy. */
static inline void stress_judge_energy(stress_watch *w) {
    w->largest_energy = fmax(w->largest_energy, fabs(w->energy));
    double allowed = DBL_EPSILON * (double)(16 + w->steps) * (w->largest_energy + w->throughput);
    stress_note(w, stress_is_energy, fabs(w->balance) / (w->doubt + allowed + 1e-300));
}

/* One step, or one event in the same instant as the last. Ends at `until`. */
static inline saltus_status stress_watch_step(stress_watch *w, saltus_time until, saltus_event *event) {
    w->held = saltus_flow_contacts(w->flow, 0);
    long long steps = saltus_flow_information(w->flow, 0).steps;
    saltus_status status =
        saltus_flow_advance(w->flow, until, SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT, event, &w->message);
    if (status != SALTUS_OK || saltus_flow_information(w->flow, 0).steps == steps)
        return status;
    w->steps++;
    saltus_flow_state(w->flow, 0, w->after);
    w->grown = !(stress_size(w, w->after) < 1e30);
    if (w->grown)
        return status;
    stress_sample_step(w);
    if (event->kind == SALTUS_IMPACT || event->kind == SALTUS_STICK)
        stress_judge_event(w, event->face);
    else
        w->energy = stress_energy(&w->model, w->after);
    stress_judge_energy(w);
    return status;
}

/* Until a time, `steps` more steps at most (0: without bound). */
static inline saltus_status stress_watch_run(stress_watch *w, double periods, long long steps) {
    saltus_event event = {.kind = SALTUS_STEP};
    double whole = floor(periods);
    saltus_status status = SALTUS_OK;
    const long long last = w->steps + steps;
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED && !w->grown &&
           (steps == 0 || w->steps < last))
        status = stress_watch_step(w, (saltus_time){(long long)whole, periods - whole}, &event);
    return status;
}

#endif
