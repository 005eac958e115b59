/* Equilibria as points of a branch, and special ones between two of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/rest_point.h"

#include "branch/point.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *saltus_rest_label(unsigned contacts) {
    return contacts ? "held" : "equilibrium";
}

double saltus_rest_heading(const saltus_rest *s) {
    return s->at.tangent[s->at.unknowns - 1];
}

saltus_status saltus_rest_give(const saltus_rests *r, const saltus_rest *s, const saltus_notice *what,
                               saltus_trail *trail, saltus_message *message) {
    const saltus_rest_special *special = r->special;
    const bool touches = special && special->kind == SALTUS_POINT_BE;
    saltus_branch_point *point = saltus_trail_place(trail, message);
    if (!point)
        return SALTUS_NO_MEMORY;
    saltus_status status = saltus_point_open(point, r->n, 0, message);
    if (status != SALTUS_OK)
        return status;
    point->spec = saltus_family_spec(&r->family, s->parameter, 0);
    for (int d = 0; d < r->family.parameters; d++) {
        /* What the rounded unknown lacks to the equilibrium's value, which is exact on a border of the
         * range. */
        const double rest = s->value[d] - (r->origin[d] + r->family.unit[d] * s->parameter[d]);
        point->spec = saltus_spec_shifted(&point->spec, &r->family.direction[d], rest);
        point->value[d] = s->value[d];
    }
    point->heading = s->at.tangent[s->at.unknowns - r->family.parameters] * r->family.unit[0];
    point->locus = special ? special->kind : SALTUS_POINT_REGULAR;
    point->unstable = s->unstable;
    point->stable = s->stable && !special;
    point->admissible = true;
    point->residual = s->at.residual;
    point->iterations = s->at.iterations;
    point->sum_rule = s->trace;
    point->multiplier_count = s->rate_count;
    memcpy(point->state, s->state, (size_t)r->n * sizeof *s->state);
    for (int k = 0; k < r->n; k++)
        point->multipliers[k] = k < s->rate_count
                                    ? (saltus_multiplier){s->rates[k].re, s->rates[k].im, s->rates[k].re}
                                    : (saltus_multiplier){NAN, NAN, NAN};
    for (int k = 0; k < s->rate_count; k++)
        point->log_volume += s->rates[k].re;
    for (int f = 0; f < r->system->face_count; f++)
        if (s->contacts >> f & 1)
            point->contact_force = fmin(point->contact_force, s->force[f]);
    snprintf(point->label, sizeof point->label, "%s", saltus_rest_label(s->contacts));
    status = saltus_trail_give(trail, r->system, what, message);
    if (touches || (what->grazing && point->kind == SALTUS_POINT_BE)) {
        const saltus_face f = r->system->faces[touches ? special->face : what->grazing->face];
        point->grazing_time = 0;
        point->grazing_stop = f.stop + 1;
        point->grazing_side = f.side;
    }
    return status;
}

double saltus_rest_value(saltus_rest_asked asked, const saltus_rest *s, const saltus_rest *from) {
    switch (asked.test) {
    case SALTUS_TEST_FOLD:
        return saltus_rest_heading(s);
    case SALTUS_TEST_CROSSING:
        return saltus_scaled_in(s->at.crossing, from->at.crossing.exponent);
    case SALTUS_TEST_PAIR:
        return saltus_scaled_in(s->pairs, from->pairs.exponent);
    case SALTUS_TEST_BREACH:
        /* A step begins on the admissible side, where the contact was just made or given up. */
        return s == from ? fmin(s->breach[asked.face], -1e-300) : s->breach[asked.face];
    default:
        return s->value[0] - asked.target;
    }
}

/* A zero that is being located. */
typedef struct sought {
    saltus_rests *rests;
    saltus_rest_asked asked;
    const saltus_rest *from;
    saltus_rest *out;
} sought;

static bool value_ahead(void *context, double ahead, double *value) {
    sought *s = context;
    if (saltus_rest_visit(s->rests, s->from, ahead, s->out, NULL) != SALTUS_OK)
        return false;
    *value = saltus_rest_value(s->asked, s->out, s->from);
    return true;
}

saltus_zero saltus_rest_zero(saltus_rests *r, saltus_rest_asked asked, const saltus_rest *from,
                             const saltus_rest *to, saltus_rest *out) {
    const double apart = 1e-7;
    sought s = {r, asked, from, out};
    saltus_zero zero = {.accuracy = INFINITY};
    double width = 0, value[3], off = apart;
    const double near = saltus_rest_value(asked, from, from), far = saltus_rest_value(asked, to, from);
    zero.ahead = to->at.ahead;
    if (far != 0 &&
        !saltus_curve_zero(r->solver, value_ahead, &s, near, to->at.ahead, far, &zero.ahead, &width))
        return zero;
    /* The possible rounding error in arclength, from the scatter of points beside it. */
    if (value_ahead(&s, zero.ahead - apart, &value[0]) && value_ahead(&s, zero.ahead, &value[1]) &&
        value_ahead(&s, zero.ahead + apart, &value[2])) {
        const double slope = fabs(value[2] - value[0]) / (2 * apart);
        const double scatter = fabs(value[1]) + fabs(value[1] - 0.5 * (value[0] + value[2]));
        off = slope > 0 ? fmin(scatter / slope, apart) : apart;
    }
    off += width;
    zero.found = saltus_rest_visit(r, from, zero.ahead, out, NULL) == SALTUS_OK;
    const double heading = fabs(saltus_rest_heading(out));
    zero.accuracy = r->family.unit[0] * (off * fmax(heading, off) + DBL_EPSILON);
    return zero;
}

saltus_zero saltus_rest_crossing(saltus_rests *r, const saltus_rest *from, double ahead, double reach,
                                 saltus_rest *out) {
    enum { passes = 3 };
    sought s = {r, {.test = SALTUS_TEST_CROSSING}, from, out};
    const size_t m = (size_t)from->at.unknowns;
    double spread, apart = fmin(0.1 * reach, 4e-3), *work = calloc(7 * m, sizeof *work);
    saltus_zero zero = {.ahead = ahead, .accuracy = INFINITY};
    saltus_rests_noted(r, work ? SALTUS_OK : SALTUS_NO_MEMORY);
    for (int pass = 0; pass < passes && work; pass++) {
        if (!saltus_curve_cross(value_ahead, &s, &from->at, &out->at, zero.ahead, apart, pass > 0, work,
                                &zero.ahead, &spread))
            break;
        zero.found = pass > 0;
        zero.accuracy = r->family.unit[0] * fmax(spread, saltus_rounding_at(apart));
        apart = fmin(apart, 3e-4);
    }
    if (zero.found) {
        memcpy(out->at.u, work, m * sizeof *work);
        out->at.ahead = zero.ahead;
        saltus_status status = saltus_equations_evaluate(&r->equations, out->at.u, NULL);
        if (status == SALTUS_OK)
            status = saltus_rest_see(r, out, NULL);
        zero.found = saltus_rests_noted(r, status) == SALTUS_OK;
        out->at.residual = r->equations.size;
    }
    free(work);
    return zero;
}
