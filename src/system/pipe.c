/* Pinned pipe conveying pulsating fluid (model.md, section 1): the 2020 paper's model, N Galerkin modes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/pipe.h"
#include "system/system.h"

#include <gsl/gsl_math.h>
#include <math.h>
#include <string.h>

enum { p_N, p_alpha, p_beta, p_kappa, p_u0, p_sigma, p_omega };

static const saltus_parameter parameters[] = {
    [p_N] = {"N", true, 5, 1, 64, false, false, "number of Galerkin modes", NULL, 0},
    [p_alpha] = {"alpha", false, 0.005, 0, 10, false, false, "Kelvin-Voigt material damping", NULL, 0},
    [p_beta] = {"beta", false, 0.64, 0, 1, false, true, "fluid mass over total mass", NULL, 0},
    [p_kappa] = {"kappa", false, 5000, 0, 1e9, false, false, "axial-stretching stiffness A L^2 / (2 I)", NULL,
                 0},
    [p_u0] = {"u0", false, 4.5, -100, 100, false, false, "mean flow velocity", NULL, 0},
    [p_sigma] = {"sigma", false, 0.2, -10, 10, false, false, "pulsation amplitude over mean velocity", NULL,
                 0},
    [p_omega] = {"omega", false, 42, 0, 1e5, true, false, "pulsation frequency, T = 2 pi / omega", NULL, 0},
};

static saltus_status shape(const saltus_spec *spec, int *dof, int *extra, saltus_message *message) {
    (void)message;
    *dof = (int)spec->parameters[p_N];
    *extra = 0;
    return SALTUS_OK;
}

/* sin(i pi xi): exactly zero where i xi is whole, and near these zeros as accurate as xi itself. */
static double mode_shape(int i, double xi) {
    double turns = i * xi, whole = round(turns), part = (turns - whole) + fma(i, xi, -turns);
    double sine = turns == whole ? 0.0 : sin(M_PI * part);
    return fmod(whole, 2) == 0 ? sine : -sine;
}

static void normal(const saltus_spec *spec, int dof, const saltus_stop *stop, double *n) {
    (void)spec;
    for (int i = 0; i < dof; i++)
        n[i] = mode_shape(i + 1, stop->xi);
}

/* d sin(i pi xi) / d xi */
static void tilt(int dof, const saltus_stop *stop, double *normal) {
    for (int i = 0; i < dof; i++)
        normal[i] = (i + 1) * M_PI * cos(M_PI * fmod((i + 1) * stop->xi, 2.0));
}

static void build_couplings(saltus_system *system) {
    int n = system->dof;
    double *gyroscopic = system->coefficients.coupling[pipe_gyroscopic];
    double *gradient = system->coefficients.coupling[pipe_gradient];
    for (int i = 1; i <= n; i++)
        for (int j = 1; j <= n; j++) {
            double difference = (double)i * i - (double)j * j;
            bool coupled = (i + j) % 2 == 1;
            gyroscopic[(i - 1) * n + j - 1] = coupled ? 4.0 * i * j / difference : 0.0;
            gradient[(i - 1) * n + j - 1] = coupled ? -8.0 * i * pow(j, 3) / (difference * difference) : 0.0;
        }
}

/* With the fastest flow u: q'' = - (damping + 2 sqrt(beta) u G) q' - (stiffness - lambda^2 u^2) q. */
static void fill_linear(saltus_system *system, double velocity) {
    const saltus_coefficients *c = &system->coefficients;
    const int n = system->dof;
    const double turning = 2 * c->scalar[pipe_root_beta] * velocity;
    for (int i = 0; i < n; i++) {
        double *row = system->linear + (size_t)i * (size_t)system->dimension;
        for (int j = 0; j < n; j++)
            row[n + j] = -turning * c->coupling[pipe_gyroscopic][i * n + j];
        row[i] = c->row[pipe_lambda2][i] * gsl_pow_2(velocity) - system->stiffness[i];
        row[n + i] = -system->damping[i];
    }
}

static void build(saltus_system *system) {
    const double *p = system->spec.parameters;
    saltus_coefficients *c = &system->coefficients;
    double velocity = fabs(p[p_u0]) * (1 + fabs(p[p_sigma]));
    c->terms = (p[p_sigma] != 0 && p[p_u0] != 0 ? SALTUS_TERM_FORCED : 0) |
               (p[p_kappa] != 0 ? SALTUS_TERM_CUBIC : 0) |
               (system->dof > 1 && p[p_beta] != 0 && p[p_u0] != 0 ? SALTUS_TERM_COUPLED : 0);
    /* The scalars are the parameters from alpha on, in their order, but for the root of beta. */
    memcpy(c->scalar, p + p_alpha, (pipe_omega + 1) * sizeof *p);
    c->scalar[pipe_root_beta] = sqrt(p[p_beta]);
    for (int i = 0; i < system->dof; i++) {
        double lambda2 = gsl_pow_2((i + 1) * M_PI), lambda4 = lambda2 * lambda2;
        c->row[pipe_lambda2][i] = lambda2;
        c->row[pipe_damping][i] = system->damping[i] = p[p_alpha] * lambda4;
        c->row[pipe_stiffness][i] = system->stiffness[i] = lambda4;
        system->inverse_mass[i * system->dof + i] = 1.0;
        system->scale[i] = 0.03 / gsl_pow_2(i + 1);
        system->scale[system->dof + i] = 0.3 / (i + 1);
    }
    if (system->dof > 1)
        build_couplings(system);
    if (system->linear)
        fill_linear(system, velocity);
    double top = c->row[pipe_stiffness][system->dof - 1], drag = p[p_alpha] * top;
    system->decay = drag;
    system->rate = fmax(sqrt(top), drag) + 2 * c->scalar[pipe_root_beta] * velocity * system->dof;
    system->forced = c->terms & SALTUS_TERM_FORCED;
    /* Stability limits Taylor steps to a few / drag. Collocation resolves only motion that lasts (the
     * forcing, and motions about twice as fast as the first mode), and one of its steps costs the more Taylor
     * steps the more modes there are. Impacts, which both must resolve, hardly change which is faster
     * (`saltus_bench --cost-only` measures both). */
    const double lasting = fmax(system->forced ? system->omega : 0, 2 * M_PI * M_PI);
    system->stiffness_ratio = drag / (10 * system->dof * lasting);
    system->mirror = true;
    system->mirror_shift = false;
}

static void vary(const saltus_system *system, const saltus_direction *direction,
                 saltus_variation *variation) {
    const double *rate = direction->parameter, root_beta = system->coefficients.scalar[pipe_root_beta];
    saltus_coefficients *c = &variation->coefficients;
    c->terms = rate[p_kappa] != 0 ? SALTUS_TERM_CUBIC : 0;
    memcpy(c->scalar, rate + p_alpha, (pipe_omega + 1) * sizeof *rate);
    c->scalar[pipe_root_beta] = rate[p_beta] != 0 ? rate[p_beta] / (2 * root_beta) : 0;
    for (int i = 0; i < system->dof; i++)
        c->row[pipe_damping][i] = rate[p_alpha] * system->stiffness[i];
}

static const char *obstacle(const saltus_spec *spec, int parameter) {
    return parameter == p_beta && spec->parameters[p_beta] == 0
               ? "the field depends on the root of beta, which has no derivative at 0"
               : NULL;
}

/* The cubic damping term contributes -alpha kappa sum lambda^4 q^2, which depends on the displacements. */
static double trace(const saltus_system *system, const double *state, double phase) {
    (void)phase;
    const saltus_coefficients *c = &system->coefficients;
    double sum = 0;
    for (int i = 0; i < system->dof; i++)
        sum -= c->row[pipe_damping][i] * (1 + c->scalar[pipe_kappa] * state[i] * state[i]);
    return sum;
}

static double deflection(const saltus_system *system, const double *state, double xi) {
    double sum = 0;
    for (int i = 0; i < system->dof; i++)
        sum += mode_shape(i + 1, xi) * state[i];
    return sum;
}

const saltus_model saltus_pipe = {
    .name = "pipe",
    .kernel = "pipe",
    .summary = "pinned pipe conveying pulsating fluid, N Galerkin modes",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof parameters[0],
    .notation = {.structure = SALTUS_STRUCTURE_LINE,
                 .displacement = "η",
                 .coordinate = "q",
                 .part = "mode",
                 .time = "τ",
                 .response = 2},
    .stop_key = "xi",
    .stop_place = offsetof(saltus_stop, xi),
    .stop_numbers = 1,
    .forcing = p_omega,
    .shape = shape,
    .normal = normal,
    .rows = pipe_rows,
    .couplings = pipe_couplings,
    .build = build,
    .vary = vary,
    .tilt = tilt,
    .obstacle = obstacle,
    .trace = trace,
    .deflection = deflection,
};
