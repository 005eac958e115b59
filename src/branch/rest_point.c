/* Equilibria as points of a branch.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/rest_point.h"

#include "branch/point.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *saltus_rest_label(unsigned contacts) {
    return contacts ? "held" : "equilibrium";
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
