/* Building and checking systems: what all models have in common.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/system.h"

#include "system/spectrum.h"
#include "system/state.h"

#include <float.h>
#include <gsl/gsl_math.h>
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

/* `fault`: of which stop the value is; `owner` begins the sentence. */
static saltus_status check_range(const saltus_parameter *p, saltus_fault fault, const char *owner,
                                 double value, saltus_message *message) {
    bool low = p->open_min ? !(value > p->min) : !(value >= p->min);
    bool high = p->open_max ? !(value < p->max) : !(value <= p->max);
    fault.key = p->name;
    if (p->integer && value != floor(value))
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%s%s = %g: must be a whole number (%s)",
                              owner, p->name, value, p->meaning);
    if (low || high)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%s%s = %g: must be %s %g and %s %g (%s)",
                              owner, p->name, value, p->open_min ? "greater than" : "at least", p->min,
                              p->open_max ? "less than" : "at most", p->max, p->meaning);
    return SALTUS_OK;
}

static saltus_status check_stop(const saltus_spec *spec, int s, saltus_message *message) {
    const saltus_stop *stop = &spec->stops[s];
    const double values[] = {
        [SALTUS_STOP_XI] = stop->xi, [SALTUS_STOP_D] = stop->d, [SALTUS_STOP_R] = stop->r};
    const bool by_xi = strcmp(spec->model->stop_key, "xi") == 0,
               weighed = strcmp(spec->model->stop_key, "weight") == 0;
    saltus_fault fault = {.key = "weight", .stop = s + 1};
    char owner[32] = "";
    if (spec->stop_count > 1)
        snprintf(owner, sizeof owner, "stop %d: ", s + 1);
    for (int k = by_xi ? SALTUS_STOP_XI : SALTUS_STOP_D; k < SALTUS_STOP_NUMBERS; k++) {
        saltus_status status = check_range(&stop_parameters[k], fault, owner, values[k], message);
        if (status != SALTUS_OK)
            return status;
    }
    if (weighed && !(isfinite(stop->weight[0]) && isfinite(stop->weight[1])))
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%sweight: must be finite numbers", owner);
    if (weighed && stop->weight[0] == 0 && stop->weight[1] == 0)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                              "%sweight = [0, 0]: a stop must limit at least one mass", owner);
    fault.key = "sides";
    if (stop->sides < SALTUS_UPPER || stop->sides > SALTUS_BOTH)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%ssides: must be upper, lower or both",
                              owner);
    fault.key = "d";
    if (stop->sides == SALTUS_BOTH && !(stop->d > 0))
        return saltus_fail_at(
            message, SALTUS_BAD_INPUT, fault,
            "%sd = %g: must be greater than 0 with sides: both (no room is left between the stops)", owner,
            stop->d);
    return SALTUS_OK;
}

static saltus_status check_spec(const saltus_spec *spec, saltus_message *message) {
    if (!spec->model)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = "model"}, "model: missing");
    if (spec->stop_count < 0 || spec->stop_count > SALTUS_STOPS_MAX)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = "stops"},
                              "stops: %d given, at most %d are possible", spec->stop_count, SALTUS_STOPS_MAX);
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < spec->model->parameter_count && status == SALTUS_OK; k++)
        status = check_range(&spec->model->parameters[k], (saltus_fault){.stop = 0}, "", spec->parameters[k],
                             message);
    for (int s = 0; s < spec->stop_count && status == SALTUS_OK; s++)
        status = check_stop(spec, s, message);
    return status;
}

static void reserve(saltus_system *system) {
    const saltus_model *model = system->spec.model;
    saltus_arena *arena = &system->arena;
    size_t n = (size_t)system->dof;
    for (int s = 0; s < system->spec.stop_count; s++) {
        system->stop_normal[s] = saltus_arena_doubles(arena, n);
        system->stop_impulse[s] = saltus_arena_doubles(arena, n);
    }
    system->inverse_mass = saltus_arena_doubles(arena, n * n);
    system->observer = saltus_arena_doubles(arena, n);
    system->scale = saltus_arena_doubles(arena, (size_t)system->dimension);
    system->damping = saltus_arena_doubles(arena, n);
    system->stiffness = saltus_arena_doubles(arena, n);
    saltus_spectrum_reserve(system);
    saltus_coefficients *c = &system->coefficients;
    c->rows = model->rows;
    c->couplings = model->couplings;
    for (int r = 0; r < c->rows; r++)
        c->row[r] = saltus_arena_doubles(arena, n);
    for (int m = 0; m < c->couplings; m++)
        c->coupling[m] = saltus_arena_doubles(arena, n * n);
    if (model->reserve)
        model->reserve(system);
}

/* Each stop's b = M^-1 n / (n M^-1 n), the direction of a unit normal impulse, and its faces. */
static void build_contacts(saltus_system *system) {
    int n = system->dof;
    for (int s = 0; s < system->spec.stop_count; s++) {
        const saltus_stop *stop = &system->spec.stops[s];
        const double *normal = system->stop_normal[s];
        double *impulse = system->stop_impulse[s], compliance = 0;
        for (int i = 0; i < n; i++) {
            impulse[i] = 0;
            for (int j = 0; j < n; j++)
                impulse[i] += system->inverse_mass[i * n + j] * normal[j];
            compliance += normal[i] * impulse[i];
        }
        for (int i = 0; i < n; i++)
            impulse[i] /= compliance;
        for (int side = 1; side >= -1; side -= 2)
            if (stop->sides & (side > 0 ? SALTUS_UPPER : SALTUS_LOWER)) {
                if (system->spec.model->by_speed && system->spec.model->by_speed(&system->spec, s))
                    system->by_speed |= 1u << system->face_count;
                system->faces[system->face_count++] =
                    (saltus_face){s, side, stop->d - side * system->offset[s], stop->r};
            }
    }
}

/* The factor f with n_a = f n_b, or 0 when the two normals are not parallel. */
static double parallel(const double *a, const double *b, int n) {
    double aa = 0, ab = 0, bb = 0;
    for (int i = 0; i < n; i++) {
        aa += a[i] * a[i];
        ab += a[i] * b[i];
        bb += b[i] * b[i];
    }
    return ab * ab > (1 - 1e-12) * aa * bb ? ab / bb : 0;
}

/* Faces on the same coordinate must leave room between them, and none may repeat another. */
static saltus_status check_faces(const saltus_system *system, saltus_message *message) {
    const saltus_fault fault = {.key = "stops"};
    for (int f = 0; f < system->face_count; f++)
        for (int g = 0; g < f; g++) {
            saltus_face a = system->faces[f], b = system->faces[g];
            double factor = parallel(system->stop_normal[a.stop], system->stop_normal[b.stop], system->dof);
            if (factor == 0)
                continue;
            if (a.side * b.side * factor > 0 && fabs(a.d - fabs(factor) * b.d) <= 1e-9 * fabs(a.d))
                return saltus_fail_at(
                    message, SALTUS_BAD_INPUT, fault,
                    "stops %d and %d limit the same coordinate on the same side; keep one of them",
                    b.stop + 1, a.stop + 1);
            if (a.side * b.side * factor < 0 && !(a.d / fabs(factor) + b.d > 0))
                return saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                                      "stops %d and %d: d = %g and d = %g leave no room between them",
                                      b.stop + 1, a.stop + 1, b.d, a.d);
        }
    return SALTUS_OK;
}

static saltus_status build_normals(saltus_system *system, saltus_message *message) {
    for (int s = 0; s < system->spec.stop_count; s++) {
        const saltus_stop *stop = &system->spec.stops[s];
        double size = 0;
        system->spec.model->normal(&system->spec, system->dof, stop, system->stop_normal[s]);
        for (int i = 0; i < system->dof; i++)
            size = fmax(size, fabs(system->stop_normal[s][i]));
        if (system->dof && isnan(system->stop_normal[s][0]))
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the system");
        if (size < 1e-6)
            return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = "xi", .stop = s + 1},
                                  "stop %d: xi = %g: no mode moves there; a stop needs a place that moves",
                                  s + 1, stop->xi);
    }
    return SALTUS_OK;
}

bool saltus_system_stop_observed(const saltus_system *system, int stop) {
    return memcmp(system->stop_normal[stop], system->observer,
                  (size_t)system->dof * sizeof *system->observer) == 0;
}

static void observe_stop(saltus_system *system, int stop) {
    const saltus_spec *spec = &system->spec;
    system->observed_stop = stop;
    memcpy(system->observer, system->stop_normal[stop], (size_t)system->dof * sizeof *system->observer);
    system->observed = saltus_stop_text(spec, stop, SALTUS_STOP_COORDINATE);
    if (spec->model->notation.structure == SALTUS_STRUCTURE_LINE)
        system->observed_place = spec->stops[stop].xi;
}

static void observe_place(saltus_system *system, double xi) {
    double state[SALTUS_STATE_MAX] = {0};
    for (int i = 0; i < system->dof; i++) {
        state[i] = 1;
        system->observer[i] = saltus_system_shape(system, state, xi);
        state[i] = 0;
    }
    system->observed_place = xi;
}

/* Entry i of the state. Of separate bodies in a built-in model the row itself tells how it is called. */
static void observe_entry(saltus_system *system, int i) {
    const saltus_model *model = system->spec.model;
    memset(system->observer, 0, (size_t)system->dof * sizeof *system->observer);
    system->observer[i] = 1;
    system->observed_entry = saltus_system_state_name(system, i);
    if (model->text || model->notation.structure == SALTUS_STRUCTURE_LINE)
        system->observed = system->observed_entry.text;
}

/* What is observed where the scene does not say it. */
static void observe_default(saltus_system *system) {
    const saltus_model *model = system->spec.model;
    if (saltus_system_observable_count(system) > 0 && model->observable_row(system, 0, system->observer)) {
        system->observed = saltus_system_observable_name(system, 0);
        system->observable = 0;
    } else if (system->spec.stop_count > 0)
        observe_stop(system, 0);
    else if (model->notation.structure == SALTUS_STRUCTURE_LINE)
        observe_place(system, 0.5);
    else if (system->dof > 0)
        observe_entry(system, 0);
}

/* What could be observed, by name. */
static saltus_status refuse_observer(const saltus_system *system, saltus_fault fault,
                                     saltus_message *message) {
    const int stops = system->spec.stop_count, quantities = saltus_system_observable_count(system);
    char names[SALTUS_NAMES_MAX], stop[48] = "", observed[200] = "";
    if (stops)
        snprintf(stop, sizeof stop, ", stops (%s%d)", stops > 1 ? "stop1 to stop" : "stop", stops);
    for (int k = 0; k < quantities; k++) {
        const size_t used = strlen(observed);
        snprintf(observed + used, sizeof observed - used, "%s%s", k ? ", " : ", quantities of the scene (",
                 saltus_system_observable_name(system, k));
    }
    return saltus_fail_at(
        message, SALTUS_BAD_INPUT, fault, "observe = %s: must be one of the displacements (%s)%s%s%s%s",
        system->spec.observe, saltus_system_list_names(system, system->dof, names), stop, observed,
        quantities ? ")" : "",
        system->spec.model->notation.structure == SALTUS_STRUCTURE_LINE ? ", places on the line (0 < xi < 1)"
                                                                        : "");
}

/* The observed displacement: an observed quantity of a text, stop2, a displacement by its name, or a place on
 * a line. */
static saltus_status choose_observer(saltus_system *system, saltus_message *message) {
    const saltus_spec *spec = &system->spec;
    const saltus_fault fault = {.key = "observe"};
    const bool line = spec->model->notation.structure == SALTUS_STRUCTURE_LINE;
    const char *name = spec->observe;
    char *end;
    int number;
    if (!name[0]) {
        observe_default(system);
        return SALTUS_OK;
    }
    for (int k = 0; k < saltus_system_observable_count(system); k++)
        if (strcmp(name, saltus_system_observable_name(system, k)) == 0) {
            system->observed = name;
            system->observable = k;
            return spec->model->observable_row(system, k, system->observer)
                       ? SALTUS_OK
                       : saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                                        "observe = %s: is no sum of displacements; choose one that is", name);
        }
    if (saltus_key_numbered(name, "stop", &number) && number > 0 && number <= spec->stop_count) {
        observe_stop(system, number - 1);
        return SALTUS_OK;
    }
    const int entry = saltus_system_state_index(system, name);
    if (entry >= 0 && entry < system->dof) {
        observe_entry(system, entry);
        return SALTUS_OK;
    }
    const double xi = strtod(name, &end);
    if (line && *end == '\0' && xi > 0 && xi < 1) {
        observe_place(system, xi);
        return SALTUS_OK;
    }
    return refuse_observer(system, fault, message);
}

/* Whether every face has its mirror image among the faces. */
static bool faces_symmetric(const saltus_system *system) {
    bool symmetric = true;
    for (int f = 0; f < system->face_count; f++) {
        bool found = false;
        for (int g = 0; g < system->face_count; g++) {
            saltus_face a = system->faces[f], b = system->faces[g];
            bool same =
                a.r == b.r && (a.stop == b.stop || !((system->by_speed >> f | system->by_speed >> g) & 1));
            found |= a.side == -b.side && a.d == b.d && same &&
                     parallel(system->stop_normal[a.stop], system->stop_normal[b.stop], system->dof) == 1;
        }
        symmetric &= found;
    }
    return symmetric;
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

saltus_status saltus_system_new(const saltus_spec *spec, saltus_system **system, saltus_message *message) {
    *system = NULL;
    int dof = 0, extra = 0;
    saltus_spec full = *spec;
    saltus_status status = check_spec(spec, message);
    if (status == SALTUS_OK)
        status = spec->model->shape(spec, &dof, &extra, message);
    if (status == SALTUS_OK && spec->model->complete) {
        spec->model->complete(&full);
        status = check_spec(&full, message);
    }
    if (status != SALTUS_OK)
        return status;

    saltus_system *made = calloc(1, sizeof *made);
    if (!made)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the system");
    made->spec = full;
    saltus_model_retain(full.model);
    made->dof = dof;
    made->extra = extra;
    made->dimension = 2 * dof + extra;
    made->omega = saltus_spec_omega(spec);
    made->observed_place = NAN;
    made->observed_stop = made->observable = -1;
    made->period = spec->model->forcing < 0 && !spec->clock ? 1 : 2 * M_PI / made->omega;
    reserve(made);
    if (!saltus_arena_open(&made->arena)) {
        saltus_model_release(full.model);
        free(made);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the system");
    }
    reserve(made);
    status = build_normals(made, message);
    if (status == SALTUS_OK) {
        spec->model->build(made);
        build_contacts(made);
        made->mirror = made->mirror && faces_symmetric(made);
        status = check_faces(made, message);
    }
    if (status == SALTUS_OK)
        status = choose_observer(made, message);
    if (status == SALTUS_OK) {
        made->observed_row = 0;
        while (made->observed_row < made->spec.stop_count &&
               !saltus_system_stop_observed(made, made->observed_row))
            made->observed_row++;
    }
    if (status != SALTUS_OK) {
        saltus_system_free(made);
        made = NULL;
    }
    *system = made;
    return status;
}

saltus_status saltus_system_clocked(const saltus_system *system, double omega, saltus_system **clocked,
                                    saltus_message *message) {
    saltus_spec spec = system->spec;
    saltus_spec_set_omega(&spec, omega);
    return saltus_system_new(&spec, clocked, message);
}

void saltus_system_free(saltus_system *system) {
    if (!system)
        return;
    saltus_model_release(system->spec.model);
    saltus_arena_close(&system->arena);
    free(system);
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
        if (!(difference <= limit)) /* what is no number is not near anything */
            return INFINITY;
        largest = fmax(largest, difference);
    }
    return largest;
}
double saltus_system_observed_place(const saltus_system *system) {
    return system->observed_place;
}
const double *saltus_system_observer(const saltus_system *system) {
    return system->observer;
}
double saltus_system_observed(const saltus_system *system, const double *vector) {
    double sum = 0;
    for (int i = 0; i < system->dof; i++)
        sum = fma(system->observer[i], vector[i], sum);
    return sum;
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

bool saltus_system_keeps_volume(const saltus_system *system) {
    enum { places = 3 }; /* that no rule picks out */
    const double rounding = 1e-13;
    double state[SALTUS_STATE_MAX];
    bool kept = true;
    for (int f = 0; f < system->face_count; f++)
        kept &= system->faces[f].r == 1;
    for (int k = 0; k < places && kept; k++) {
        for (int i = 0; i < system->dimension; i++)
            state[i] = system->scale[i] * (0.2 + 0.1 * sin(1.7 * k + 2.3 * i + 0.4));
        kept = fabs(saltus_system_trace(system, state, 0.3 * k)) <= rounding * system->rate;
    }
    return kept;
}

bool saltus_system_conservative(const saltus_system *system) {
    return !system->forced && saltus_system_keeps_volume(system);
}

double saltus_system_fastest_decay(const saltus_system *system) {
    return system->decay;
}

/* Names of all models: by what an entry is, and which of its kind. */
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

const char *saltus_system_observed_name(const saltus_system *system) {
    return system->observed;
}

const char *saltus_system_observable_name(const saltus_system *system, int k) {
    const saltus_model *model = system->spec.model;
    return model->observable ? model->observable(model, k) : NULL;
}

int saltus_system_observable_count(const saltus_system *system) {
    int count = 0;
    while (saltus_system_observable_name(system, count))
        count++;
    return count;
}

void saltus_system_observe(const saltus_system *system, const double *state, double phase, double *values) {
    if (system->spec.model->observe)
        system->spec.model->observe(system, state, phase, values);
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

/* Of separate bodies: side by side, joined by straight lines. */
double saltus_system_shape(const saltus_system *system, const double *state, double xi) {
    if (system->spec.model->deflection)
        return system->spec.model->deflection(system, state, xi);
    double place = xi * system->dof;
    int left = (int)fmin(floor(place), system->dof - 1);
    double a = left == 0 ? 0 : state[left - 1], b = state[left];
    return a + (b - a) * (place - left);
}

/* How far a face's coordinate moves beside the modes, for margins: a stop near a support sees little. */
static double face_reach(const saltus_system *system, int face) {
    const double *normal = system->stop_normal[system->faces[face].stop];
    double reach = 0;
    for (int i = 0; i < system->dof; i++)
        reach = fmax(reach, fabs(normal[i]));
    return fmin(reach, 1);
}

/* A small displacement, moved along the impulse of the face it violates most until it keeps a margin from all
 * of them. The margin shrinks, for stops that leave little room. */
static saltus_status find_state(const saltus_system *system, double *state, saltus_message *message) {
    enum { corrections = 2000 };
    memset(state, 0, (size_t)system->dimension * sizeof *state);
    state[0] = 0.2 * system->scale[0];
    if (system->dof > 1)
        state[1] = 0.1 * system->scale[1];
    double margin = 0.05 * system->scale[0];
    for (int k = 0; k < corrections; k++) {
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
            return SALTUS_OK;
        saltus_face face = system->faces[worst];
        double excess = saltus_system_gap(system, worst, state) + 1.5 * margin * face_reach(system, worst);
        for (int i = 0; i < system->dof; i++)
            state[i] -= face.side * excess * system->stop_impulse[face.stop][i];
        margin *= 0.99;
    }
    return saltus_fail(
        message, SALTUS_BAD_INPUT,
        "the stops contradict each other: no displacement satisfies all clearances; give another d");
}

saltus_status saltus_system_default_state(const saltus_system *system, double *state,
                                          saltus_message *message) {
    saltus_status status = find_state(system, state, message);
    if (status != SALTUS_OK || !system->spec.model->start)
        return status;
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
            return saltus_fail(
                message, SALTUS_BAD_INPUT,
                "initial state: the displacement %.6g at stop %d is beyond its %s side (d = %g)",
                face.side * (saltus_system_gap(system, f, state) + face.d), face.stop + 1,
                face.side > 0 ? "upper" : "lower", face.d);
    }
    return SALTUS_OK;
}
