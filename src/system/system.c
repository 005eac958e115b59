/* Specifications and queries of a built system: the parts common to all models.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/system.h"

#include "system/state.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const saltus_parameter stop_parameters[SALTUS_STOP_NUMBERS] = {
    [SALTUS_STOP_XI] = {"xi", false, 0.5, 0, 1, true, true, "position of the stop along the pipe", NULL, 0},
    [SALTUS_STOP_D] = {"d", false, 1, -1e9, 1e9, false, false, "clearance; negative is a pre-load", NULL, 0},
    [SALTUS_STOP_R] = {"r", false, 0.9, 0, 1, false, false, "coefficient of restitution", NULL, 0},
};

const saltus_parameter *saltus_stop_parameters(int *count) {
    *count = SALTUS_STOP_NUMBERS;
    return stop_parameters;
}

saltus_stop saltus_stop_defaults(void) {
    return (saltus_stop){.xi = 0.5, .weight = {1, 0}, .d = 1, .r = 0.9, .sides = SALTUS_UPPER};
}

saltus_spec saltus_spec_defaults(const saltus_model *model) {
    saltus_spec spec = {.model = model};
    for (int k = 0; k < model->parameter_count; k++)
        spec.parameters[k] = model->parameters[k].fallback;
    return spec;
}

bool saltus_spec_matters(const saltus_spec *spec, int k) {
    const saltus_parameter *p = &spec->model->parameters[k];
    return !p->given || spec->parameters[saltus_model_parameter_index(spec->model, p->given)] > p->above;
}

bool saltus_spec_equal(const saltus_spec *a, const saltus_spec *b) {
    bool equal = saltus_model_same(a->model, b->model) && a->stop_count == b->stop_count;
    for (int k = 0; equal && k < a->model->parameter_count; k++)
        equal = a->parameters[k] == b->parameters[k];
    for (int s = 0; equal && s < a->stop_count; s++) {
        const saltus_stop *x = &a->stops[s], *y = &b->stops[s];
        equal = x->xi == y->xi && x->weight[0] == y->weight[0] && x->weight[1] == y->weight[1] &&
                x->d == y->d && x->r == y->r && x->sides == y->sides;
    }
    return equal;
}

saltus_status saltus_spec_check_poincare(const saltus_spec *spec, saltus_message *message) {
    const saltus_fault fault = {.key = "section"};
    const saltus_poincare section = spec->model->poincare;
    if (section.kind != SALTUS_POINCARE_MAXIMA && spec->model->forcing >= 0)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                              "section: the scene is forced, and its section is phase 0 of the forcing");
    if (section.kind == SALTUS_POINCARE_IMPACT && section.stop >= spec->stop_count)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                              "section: impact = %d: the scene has %d stop%s", section.stop + 1,
                              spec->stop_count, spec->stop_count == 1 ? "" : "s");
    const saltus_sides other = section.side > 0 ? SALTUS_LOWER : SALTUS_UPPER;
    if (section.kind == SALTUS_POINCARE_IMPACT && section.side && spec->stops[section.stop].sides == other)
        return saltus_fail_at(
            message, SALTUS_BAD_INPUT, fault, "section: side = %s: stop %d acts on the %s side only",
            section.side > 0 ? "upper" : "lower", section.stop + 1, section.side > 0 ? "lower" : "upper");
    return SALTUS_OK;
}

double saltus_spec_omega(const saltus_spec *spec) {
    if (spec->model->forcing >= 0)
        return spec->parameters[spec->model->forcing];
    return spec->clock ? spec->clock : 2 * M_PI;
}

void saltus_spec_set_omega(saltus_spec *spec, double omega) {
    *(spec->model->forcing >= 0 ? &spec->parameters[spec->model->forcing] : &spec->clock) = omega;
}

const saltus_spec *saltus_system_spec(const saltus_system *system) {
    return &system->spec;
}
int saltus_system_dof(const saltus_system *system) {
    return system->dof;
}
int saltus_system_extra(const saltus_system *system) {
    return system->extra;
}
int saltus_system_dimension(const saltus_system *system) {
    return system->dimension;
}
double saltus_system_period(const saltus_system *system) {
    return system->period;
}
bool saltus_system_forced(const saltus_system *system) {
    return system->forced;
}

bool saltus_system_mirror_symmetric(const saltus_system *system, bool *shift) {
    *shift = system->mirror_shift;
    return system->mirror;
}

int saltus_system_face_count(const saltus_system *system) {
    return system->face_count;
}
saltus_rebound saltus_system_rebound(const saltus_system *system, int face, double speed) {
    const saltus_face *f = &system->faces[face];
    if (system->by_speed >> face & 1)
        return system->spec.model->rebound(system, f->stop, speed);
    return (saltus_rebound){f->r, f->r};
}

double saltus_system_restitution(const saltus_system *system, int face, double speed) {
    return saltus_system_rebound(system, face, speed).r;
}

saltus_face saltus_system_face(const saltus_system *system, int face) {
    return system->faces[face];
}
const double *saltus_system_stop_normal(const saltus_system *system, int stop) {
    return system->stop_normal[stop];
}
const double *saltus_system_inverse_mass(const saltus_system *system) {
    return system->inverse_mass;
}
const double *saltus_system_scale(const saltus_system *system) {
    return system->scale;
}
double saltus_system_distance(const saltus_system *system, const double *a, const double *b) {
    return saltus_system_distance_within(system, a, b, INFINITY);
}
double saltus_system_distance_within(const saltus_system *system, const double *a, const double *b,
                                     double limit) {
    double largest = 0;
    for (int i = 0; i < system->dimension; i++) {
        double difference = fabs(a[i] - b[i]) / system->scale[i];
        if (!(difference <= limit)) /* NaN is not near anything */
            return INFINITY;
        largest = fmax(largest, difference);
    }
    return largest;
}
const char *saltus_system_integrator(const saltus_system *system) {
    return system->stiffness_ratio > 1 ? "mixed" : "taylor";
}

double saltus_system_gap(const saltus_system *system, int face, const double *state) {
    saltus_face f = system->faces[face];
    double g = 0;
    for (int i = 0; i < system->dof; i++)
        g = fma(system->stop_normal[f.stop][i], state[i], g);
    return f.side * g - f.d;
}

double saltus_system_gap_size(const saltus_system *system, int face, const double *state) {
    const double *normal = system->stop_normal[system->faces[face].stop];
    double size = fabs(system->faces[face].d);
    for (int i = 0; i < system->dof; i++)
        size += fabs(normal[i] * state[i]);
    return size;
}

double saltus_system_compliance(const saltus_system *system, int face) {
    const double *normal = system->stop_normal[system->faces[face].stop];
    double sum = 0;
    for (int i = 0; i < system->dof; i++)
        for (int j = 0; j < system->dof; j++)
            sum += normal[i] * system->inverse_mass[i * system->dof + j] * normal[j];
    return sum;
}

int saltus_system_gap_sign(const saltus_system *system, int face, const double *state) {
    double gap = saltus_system_gap(system, face, state);
    double rounding = 8 * DBL_EPSILON * saltus_system_gap_size(system, face, state);
    return (gap > rounding) - (gap < -rounding);
}

double saltus_system_trace(const saltus_system *system, const double *state, double phase) {
    return system->spec.model->trace(system, state, phase);
}

bool saltus_system_traceless(const saltus_system *system) {
    enum { places = 3 }; /* generic states */
    const double rounding = 1e-13;
    double state[SALTUS_STATE_MAX];
    bool zero = true;
    for (int k = 0; k < places && zero; k++) {
        for (int i = 0; i < system->dimension; i++)
            state[i] = system->scale[i] * (0.2 + 0.1 * sin(1.7 * k + 2.3 * i + 0.4));
        zero = fabs(saltus_system_trace(system, state, 0.3 * k)) <= rounding * system->rate;
    }
    return zero;
}

bool saltus_system_keeps_volume(const saltus_system *system) {
    for (int f = 0; f < system->face_count; f++)
        if (system->faces[f].r != 1)
            return false;
    return saltus_system_traceless(system);
}

bool saltus_system_conservative(const saltus_system *system) {
    return !system->forced && saltus_system_keeps_volume(system);
}

double saltus_system_fastest_decay(const saltus_system *system) {
    return system->decay;
}

/* Entry names in built-in models: kind (displacement, velocity, extra state) and number. */
static const char kinds[] = "qvz";

static saltus_state_name state_name(const saltus_spec *spec, int dof, int entry) {
    saltus_state_name name;
    int kind = entry < dof ? 0 : entry < 2 * dof ? 1 : 2;
    if (spec->model->state_name)
        return spec->model->state_name(spec, dof, entry);
    snprintf(name.text, sizeof name.text, "%c%d", kinds[kind], entry - kind * dof + 1);
    return name;
}

static int state_index(const saltus_spec *spec, int dof, int dimension, const char *name) {
    const int first[] = {0, dof, 2 * dof, dimension}, length = (int)strlen(name);
    const bool dotted = length > 4 && strcmp(name + length - 4, "_dot") == 0; /* x' for x_dot */
    saltus_state_name wanted;
    int number;
    snprintf(wanted.text, sizeof wanted.text, "%.*s%s", dotted ? length - 4 : length, name,
             dotted ? "'" : "");
    if (saltus_model_parameter_index(spec->model, name) >= 0)
        return -1;
    for (int i = 0; i < dimension; i++)
        if (strcmp(state_name(spec, dof, i).text, wanted.text) == 0)
            return i;
    for (int k = 0; k < 3; k++)
        if (saltus_key_numbered(name, (const char[]){kinds[k], '\0'}, &number) && number > 0 &&
            number <= first[k + 1] - first[k])
            return first[k] + number - 1;
    return -1;
}

saltus_state_name saltus_system_state_name(const saltus_system *system, int entry) {
    return state_name(&system->spec, system->dof, entry);
}

const char *saltus_system_list_names(const saltus_system *system, int count, char names[SALTUS_NAMES_MAX]) {
    enum { few = 3 };
    size_t used = 0;
    names[0] = '\0';
    for (int k = 0; k<count; k += count> few && k == 0 ? count - 1 : 1)
        used += (size_t)snprintf(names + used, SALTUS_NAMES_MAX - used, "%s%s",
                                 k == 0        ? ""
                                 : count > few ? " to "
                                               : ", ",
                                 saltus_system_state_name(system, k).text);
    return names;
}

int saltus_system_state_index(const saltus_system *system, const char *name) {
    return state_index(&system->spec, system->dof, system->dimension, name);
}

int saltus_spec_dimension(const saltus_spec *spec, int *dof) {
    saltus_spec without_stops = *spec;
    int extra = 0, displacements = 0;
    without_stops.stop_count = 0;
    if (spec->model->shape(&without_stops, &displacements, &extra, NULL) != SALTUS_OK ||
        !(2 * displacements + extra <= SALTUS_STATE_MAX))
        return -1;
    if (dof)
        *dof = displacements;
    return 2 * displacements + extra;
}

saltus_state_name saltus_spec_state_name(const saltus_spec *spec, int entry) {
    int dof = 0;
    return entry < saltus_spec_dimension(spec, &dof) ? state_name(spec, dof, entry) : (saltus_state_name){""};
}

int saltus_spec_state_index(const saltus_spec *spec, const char *name) {
    int dof = 0, dimension = saltus_spec_dimension(spec, &dof);
    return dimension < 0 ? -1 : state_index(spec, dof, dimension, name);
}

saltus_poincare saltus_system_poincare(const saltus_system *system) {
    return system->spec.model->poincare;
}

double saltus_system_poincare_value(const saltus_system *system, const double *state) {
    const saltus_model *model = system->spec.model;
    return model->poincare.kind == SALTUS_POINCARE_ZERO
               ? model->poincare.direction * model->crossing(system, state)
               : NAN;
}

char *saltus_system_right_side(const saltus_system *system, int entry) {
    return system->spec.model->right_side ? system->spec.model->right_side(system, entry) : NULL;
}

bool saltus_system_defined(const saltus_system *system, const double *state, double phase) {
    return !system->guarded || system->spec.model->defined(system, state, phase);
}

bool saltus_system_fault(const saltus_system *system, const double *state, double phase,
                         saltus_message *what) {
    return system->spec.model->fault && system->spec.model->fault(system, state, phase, what);
}

/* Separate bodies stand side by side, joined by straight lines. */
double saltus_system_shape(const saltus_system *system, const double *state, double xi) {
    if (system->spec.model->deflection)
        return system->spec.model->deflection(system, state, xi);
    double place = xi * system->dof;
    int left = (int)fmin(floor(place), system->dof - 1);
    double a = left == 0 ? 0 : state[left - 1], b = state[left];
    return a + (b - a) * (place - left);
}

/* How far a face's coordinate moves with the modes, for margins: a stop near a support moves little. */
static double face_reach(const saltus_system *system, int face) {
    const double *normal = system->stop_normal[system->faces[face].stop];
    double reach = 0;
    for (int i = 0; i < system->dof; i++)
        reach = fmax(reach, fabs(normal[i]));
    return fmin(reach, 1);
}

/* Find a small displacement: move it along the impulse of the most violated face until it keeps a margin from
 * all faces. The margin shrinks, for stops that leave little room. */
saltus_status saltus_system_default_state(const saltus_system *system, double *state,
                                          saltus_message *message) {
    enum { corrections = 2000 };
    memset(state, 0, (size_t)system->dimension * sizeof *state);
    state[0] = 0.2 * system->scale[0];
    if (system->dof > 1)
        state[1] = 0.1 * system->scale[1];
    double margin = 0.05 * system->scale[0];
    int left = corrections;
    for (; left > 0; left--, margin *= 0.99) {
        int worst = -1;
        double largest = -margin;
        for (int f = 0; f < system->face_count; f++) {
            double gap = saltus_system_gap(system, f, state) / face_reach(system, f);
            if (gap > largest) {
                largest = gap;
                worst = f;
            }
        }
        if (worst < 0)
            break;
        saltus_face face = system->faces[worst];
        double excess = saltus_system_gap(system, worst, state) + 1.5 * margin * face_reach(system, worst);
        for (int i = 0; i < system->dof; i++)
            state[i] -= face.side * excess * system->stop_impulse[face.stop][i];
    }
    if (left == 0)
        return saltus_fail(
            message, SALTUS_BAD_INPUT,
            "the stops contradict each other: no displacement satisfies all clearances; give another d");
    if (!system->spec.model->start)
        return SALTUS_OK;
    system->spec.model->start(system, state);
    return saltus_system_check_state(system, state, message);
}

saltus_status saltus_system_check_state(const saltus_system *system, const double *state,
                                        saltus_message *message) {
    for (int i = 0; i < system->dimension; i++)
        if (!isfinite(state[i]))
            return saltus_fail(message, SALTUS_BAD_INPUT, "initial state: entry %d is not a finite number",
                               i + 1);
    for (int f = 0; f < system->face_count; f++) {
        saltus_face face = system->faces[f];
        if (saltus_system_gap_sign(system, f, state) > 0)
            return saltus_fail_at(
                message, SALTUS_BAD_INPUT,
                (saltus_fault){.cause = SALTUS_CAUSE_BEYOND, .stop = face.stop + 1},
                "initial state: the displacement %.6g at stop %d is beyond its %s side (d = %g)",
                face.side * (saltus_system_gap(system, f, state) + face.d), face.stop + 1,
                face.side > 0 ? "upper" : "lower", face.d);
    }
    return SALTUS_OK;
}
