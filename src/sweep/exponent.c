/* The largest exponent of a trajectory that has settled.
 *
 * Newton steps confirm the orbit at the state reached. If a step hardly moves the state, the derivative
 * around the orbit, which the step needs anyway, also gives the multipliers. If rounding hides the largest
 * multiplier in that derivative, or the steps stay large, shooting (saltus_orbit_find) computes it, which
 * takes five times as long, and much longer with many impacts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "orbit/fixed_point.h"

#include <math.h>
#include <string.h>

enum {
    steps_max = 3,
    shooting_impacts = 100 /* for an orbit with more, measuring the exponent is faster */
};
static const double own_orbit = 1e-6; /* the orbit is no farther away, relative to the system's scales */
static const double on_orbit = 1e-9;  /* a step this small ends the iteration */

/* Whether the state lies beside an impact in the very section: there rounding decides how often the impact is
 * met in a period. */
static bool is_beside_impact(const saltus_sweep_trajectory *t) {
    const double reach = saltus_section_reach(t->sweep->options.flow.rtol);
    const int dof = saltus_system_dof(t->system);
    double back[SALTUS_STATE_MAX], after[SALTUS_STATE_MAX];
    memcpy(back, t->state, (size_t)t->sweep->dimension * sizeof *back);
    for (int i = dof; i < 2 * dof; i++)
        back[i] = -back[i];
    return saltus_section_point(t->system, t->state, reach, after, NULL) > 0 ||
           saltus_section_point(t->system, back, reach, after, NULL) > 0;
}

static double by_steps(saltus_sweep_trajectory *t, int periods) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_fixed_point f;
    double logarithm = NAN, length = INFINITY, gone = 0;
    options.integrator = t->sweep->options.flow.integrator;
    saltus_status status = saltus_fixed_point_open(&f, t->system, periods, &options, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    if (status == SALTUS_OK)
        memcpy(f.state, t->state, (size_t)f.n * sizeof *f.state);
    for (int k = 0; k < steps_max && status == SALTUS_OK && length > on_orbit && gone < own_orbit; k++) {
        length = saltus_fixed_point_residual(&f) < INFINITY ? saltus_fixed_point_step(&f) : INFINITY;
        gone += length;
    }
    if (length <= on_orbit && gone < own_orbit)
        logarithm = saltus_fixed_point_multiplier(&f);
    saltus_fixed_point_close(&f);
    return logarithm;
}

static double by_shooting(saltus_sweep_trajectory *t, int periods) {
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_orbit orbit = {0};
    shooting.flow.integrator = t->sweep->options.flow.integrator;
    saltus_status status = saltus_orbit_find(t->system, periods, t->state, &shooting, &orbit, NULL);
    bool own = status == SALTUS_OK && saltus_orbit_passes(t->system, orbit.state, 1, t->state, own_orbit);
    double logarithm = own ? orbit.multipliers[0].log_modulus : NAN;
    t->starved |= status == SALTUS_NO_MEMORY;
    saltus_orbit_clear(&orbit);
    return logarithm;
}

bool saltus_sweep_trajectory_exponent(saltus_sweep_trajectory *t) {
    int periods = t->row.periods > 0 ? t->row.periods : 1;
    if (!saltus_system_forced(t->system) && t->row.verdict == SALTUS_PERIODIC) {
        t->row.lyapunov = t->proof.exponent;
        t->row.lyapunov_error = 0;
        return true;
    }
    double logarithm = is_beside_impact(t) ? NAN : by_steps(t, periods);
    if (isnan(logarithm) && saltus_settling_impacts(&t->proof.settling, periods) <= shooting_impacts)
        logarithm = by_shooting(t, periods);
    if (isnan(logarithm))
        return false;
    t->row.lyapunov = logarithm / (periods * saltus_system_period(t->system));
    t->row.lyapunov_error = 0;
    return true;
}
