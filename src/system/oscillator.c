/* Directly forced linear oscillator with one or two masses in a chain (support - mass 1 - mass 2):
 *
 *   m x1'' + c x1' + k x1 + c2 (x1' - x2') + k2 (x1 - x2) + z = F cos(omega t) + F0
 *   m2 x2'' + c2 (x2' - x1') + k2 (x2 - x1)                   = F2 cos(omega t) + F02
 *   z' = kz x1' - z / tz        (a Maxwell element beside the first spring, when kz > 0: a first-order state)
 *
 * The classic impact oscillators are special cases: bouncing ball (k = c = 0, F0 = -g, and in the frame of a
 * vibrating table F), impact pair (k = c = 0, two-sided stop).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/oscillator.h"
#include "system/lasting.h"
#include "system/system.h"

#include <gsl/gsl_math.h>
#include <math.h>

enum { p_N, p_m, p_c, p_k, p_F, p_F0, p_m2, p_c2, p_k2, p_F2, p_F02, p_kz, p_tz, p_omega };

static const saltus_parameter parameters[] = {
    [p_N] = {"N", true, 1, 1, 2, false, false, "number of masses; more: equations, saltus help text", NULL,
             0},
    [p_m] = {"m", false, 1, 0, 1e12, true, false, "mass 1", NULL, 0},
    [p_c] = {"c", false, 0, 0, 1e9, false, false, "damper from the support to mass 1", NULL, 0},
    [p_k] = {"k", false, 1, 0, 1e12, false, false, "spring from the support to mass 1", NULL, 0},
    [p_F] = {"F", false, 0, -1e12, 1e12, false, false, "force amplitude on mass 1, F cos(omega t)", NULL, 0},
    [p_F0] = {"F0", false, 0, -1e12, 1e12, false, false, "constant load on mass 1", NULL, 0},
    [p_m2] = {"m2", false, 1, 0, 1e12, true, false, "mass 2 (N = 2)", "N", 1},
    [p_c2] = {"c2", false, 0, 0, 1e9, false, false, "damper between the masses (N = 2)", "N", 1},
    [p_k2] = {"k2", false, 1, 0, 1e12, false, false, "spring between the masses (N = 2)", "N", 1},
    [p_F2] = {"F2", false, 0, -1e12, 1e12, false, false, "force amplitude on mass 2 (N = 2)", "N", 1},
    [p_F02] = {"F02", false, 0, -1e12, 1e12, false, false, "constant load on mass 2 (N = 2)", "N", 1},
    [p_kz] = {"kz", false, 0, 0, 1e12, false, false,
              "stiffness of the Maxwell element beside spring 1; 0: none", NULL, 0},
    [p_tz] = {"tz", false, 1, 0, 1e9, true, false, "relaxation time of the Maxwell element", "kz", 0},
    [p_omega] = {"omega", false, 1, 0, 1e5, true, false, "forcing frequency, T = 2 pi / omega", NULL, 0},
};

static saltus_status shape(const saltus_spec *spec, int *dof, int *extra, saltus_message *message) {
    *dof = (int)spec->parameters[p_N];
    *extra = spec->parameters[p_kz] > 0 ? 1 : 0;
    if (*dof == 1)
        for (int s = 0; s < spec->stop_count; s++)
            if (spec->stops[s].weight[1] != 0)
                return saltus_fail_at(
                    message, SALTUS_BAD_INPUT, (saltus_fault){.key = "weight", .stop = s + 1},
                    "stop %d: weight names mass 2, but the oscillator has one mass (N = 1)", s + 1);
    return SALTUS_OK;
}

static void normal(const saltus_spec *spec, int dof, const saltus_stop *stop, double *n) {
    (void)spec;
    for (int i = 0; i < dof; i++)
        n[i] = stop->weight[i];
}

/* The rows of K, C, F and F0, scaled by a number for each mass. They are linear in the parameters, so with
 * rates of parameters the same lines give the derivative along a direction. */
static void fill_rows(const double *p, int dof, double scale[2], double *const *row) {
    bool two = dof == 2;
    double k[2][2] = {{p[p_k] + (two ? p[p_k2] : 0), -p[p_k2]}, {-p[p_k2], p[p_k2]}};
    double d[2][2] = {{p[p_c] + (two ? p[p_c2] : 0), -p[p_c2]}, {-p[p_c2], p[p_c2]}};
    double force[2] = {p[p_F], p[p_F2]}, load[2] = {p[p_F0], p[p_F02]};
    for (int i = 0; i < dof; i++) {
        row[oscillator_k1][i] = scale[i] * k[i][0];
        row[oscillator_k2][i] = two ? scale[i] * k[i][1] : 0;
        row[oscillator_c1][i] = scale[i] * d[i][0];
        row[oscillator_c2][i] = two ? scale[i] * d[i][1] : 0;
        row[oscillator_force][i] = scale[i] * force[i];
        row[oscillator_load][i] = scale[i] * load[i];
    }
}

/* The larger of M^-1 C's largest eigenvalue and the Maxwell rate; energy decays at most twice as fast. */
static double decay_bound(const saltus_system *system) {
    double *const *row = system->coefficients.row;
    double decay = row[oscillator_c1][0];
    if (system->dof == 2) {
        double mean = 0.5 * (decay + row[oscillator_c2][1]), half = 0.5 * (decay - row[oscillator_c2][1]);
        decay = mean + sqrt(half * half + row[oscillator_c2][0] * row[oscillator_c1][1]);
    }
    return system->extra ? fmax(decay, system->coefficients.scalar[oscillator_rate_z]) : decay;
}

/* A typical length of the motion: the smallest clearance, else the forced response. A clearance that is tiny
 * beside the response counts only between two sides. */
static double typical_length(const saltus_system *system) {
    const double *p = system->spec.parameters;
    bool between;
    double length = saltus_least_clearance(system, &between);
    const double force = fabs(p[p_F]) + fabs(p[p_F0]),
                 response = force / (p[p_k] + p[p_m] * gsl_pow_2(p[p_omega]));
    if (length == 0 || (!between && isfinite(response) && length < SALTUS_NO_CLEARANCE * response))
        length = response;
    return length > 0 && isfinite(length) ? length : 1;
}

/* M^-1 K, M^-1 C and the Maxwell element. */
static void fill_linear(saltus_system *system) {
    double *const *row = system->coefficients.row;
    const double *p = system->spec.parameters;
    const int n = system->dof, dimension = system->dimension;
    for (int i = 0; i < n; i++) {
        double *rates = system->linear + i * dimension;
        for (int j = 0; j < n; j++) {
            rates[j] = -row[j ? oscillator_k2 : oscillator_k1][i];
            rates[n + j] = -row[j ? oscillator_c2 : oscillator_c1][i];
        }
        if (system->extra)
            rates[2 * n] = -row[oscillator_maxwell][i];
    }
    if (system->extra) {
        system->linear[n * dimension + n] = p[p_kz];
        system->linear[n * dimension + 2 * n] = -1 / p[p_tz];
    }
}

static void build(saltus_system *system) {
    const double *p = system->spec.parameters;
    saltus_coefficients *c = &system->coefficients;
    bool two = system->dof == 2;
    system->forced = p[p_F] != 0 || (two && p[p_F2] != 0);
    c->terms = (system->forced ? SALTUS_TERM_FORCED : 0) | (two ? SALTUS_TERM_COUPLED : 0) |
               (system->extra ? SALTUS_TERM_EXTRA : 0);
    c->scalar[oscillator_kz] = p[p_kz];
    c->scalar[oscillator_rate_z] = 1 / p[p_tz];
    c->scalar[oscillator_omega] = p[p_omega];
    double inverse[2] = {1 / p[p_m], 1 / p[p_m2]}, stiffness = 0, damping = 0, lasting = p[p_omega],
           length = typical_length(system);
    fill_rows(p, system->dof, inverse, c->row);
    for (int i = 0; i < system->dof; i++) {
        c->row[oscillator_maxwell][i] = i == 0 ? inverse[0] : 0;
        system->damping[i] = c->row[i == 0 ? oscillator_c1 : oscillator_c2][i];
        system->stiffness[i] = c->row[i == 0 ? oscillator_k1 : oscillator_k2][i];
        system->inverse_mass[i * system->dof + i] = inverse[i];
        stiffness = fmax(stiffness, 2 * system->stiffness[i]);
        damping = fmax(damping, 2 * system->damping[i]);
        lasting = fmax(lasting, saltus_lasting_rate(2 * system->stiffness[i], 2 * system->damping[i]));
        system->scale[i] = length;
        system->scale[system->dof + i] = length * fmax(p[p_omega], sqrt(system->stiffness[i]));
    }
    fill_linear(system);
    if (system->extra)
        system->scale[2 * system->dof] = length * p[p_kz];
    system->rate = fmax(fmax(sqrt(stiffness + p[p_kz] / p[p_m]), damping),
                        fmax(p[p_omega], system->extra ? 1 / p[p_tz] : 0));
    system->decay = decay_bound(system);
    system->stiffness_ratio = damping / (200 * lasting);
    system->mirror = p[p_F0] == 0 && (!two || p[p_F02] == 0);
    system->mirror_shift = system->forced;
}

/* M^-1 K changes by M^-1 dK - M^-1 dM M^-1 K, and the other rows likewise. */
static void vary(const saltus_system *system, const saltus_direction *direction,
                 saltus_variation *variation) {
    const double *p = system->spec.parameters, *rate = direction->parameter;
    const double mass[2] = {rate[p_m] / p[p_m], rate[p_m2] / p[p_m2]};
    double inverse[2] = {1 / p[p_m], 1 / p[p_m2]};
    saltus_coefficients *c = &variation->coefficients;
    c->scalar[oscillator_kz] = rate[p_kz];
    c->scalar[oscillator_rate_z] = -rate[p_tz] / gsl_pow_2(p[p_tz]);
    c->scalar[oscillator_omega] = rate[p_omega];
    fill_rows(rate, system->dof, inverse, c->row);
    for (int i = 0; i < system->dof; i++) {
        for (int row = 0; row < oscillator_rows; row++)
            c->row[row][i] -= mass[i] * system->coefficients.row[row][i];
        variation->inverse_mass[i * system->dof + i] = -mass[i] * inverse[i];
    }
}

static const char *obstacle(const saltus_spec *spec, int parameter) {
    return parameter == p_kz && spec->parameters[p_kz] == 0
               ? "without the Maxwell element the state has no force z to differentiate"
               : NULL;
}

static double trace(const saltus_system *system, const double *state, double phase) {
    (void)phase;
    (void)state;
    double sum = 0;
    for (int i = 0; i < system->dof; i++)
        sum -= system->damping[i];
    if (system->extra)
        sum -= system->coefficients.scalar[oscillator_rate_z];
    return sum;
}

const saltus_model saltus_oscillator = {
    .name = "oscillator",
    .kernel = "oscillator",
    .summary = "directly forced linear oscillator, one or two masses",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof parameters[0],
    .notation = {.structure = SALTUS_STRUCTURE_BODIES,
                 .displacement = "x",
                 .coordinate = "x",
                 .part = "mass",
                 .time = "t",
                 .response = 1},
    .stop_key = "weight",
    .stop_place = offsetof(saltus_stop, weight),
    .stop_numbers = 2,
    .forcing = p_omega,
    .shape = shape,
    .normal = normal,
    .rows = oscillator_rows,
    .build = build,
    .vary = vary,
    .obstacle = obstacle,
    .trace = trace,
};
