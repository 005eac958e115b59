/* The attractors found from many initial states, for people and for programs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/record.h"

#include "record/describe.h"

#include <math.h>

static void put_motion(FILE *file, const saltus_motion *motion, int share, int seeds) {
    static const char *const mirror[] = {"", "its own mirror image", "one of a mirror pair", ""};
    char verdict[64];
    saltus_motion_summary(motion, verdict);
    fprintf(file, "  %5d  %5.1f %%  %-22s", share, 100.0 * share / seeds, verdict);
    if (motion->multiplier_count)
        fprintf(file, "  largest |mu| %.6f", exp(motion->multipliers[0].log_modulus));
    if (saltus_verdict_settled(motion->verdict))
        fprintf(file, "  displacement %.6g to %.6g  %s", motion->smallest, motion->largest,
                mirror[motion->mirror]);
    else if (!isnan(motion->lyapunov))
        fprintf(file, "  largest exponent %.4g +- %.1g", motion->lyapunov, motion->lyapunov_error);
    fputc('\n', file);
}

void saltus_write_attractors(FILE *file, const saltus_scene *scene, const saltus_system *system,
                             const saltus_attractors *attractors, bool json) {
    if (json)
        fprintf(file, "{\"version\": \"" SALTUS_VERSION "\", \"seeds\": %d, \"attractors\": [",
                attractors->seeds);
    else
        fprintf(file, "%s: %d attractor%s from %d random initial states\n", scene->name, attractors->count,
                attractors->count == 1 ? "" : "s", attractors->seeds);
    for (int k = 0; k < attractors->count; k++)
        if (json) {
            fprintf(file, "%s{\"share\": %d, \"motion\": ", k ? ", " : "", attractors->shares[k]);
            saltus_write_motion_json(file, scene, system, &attractors->motions[k]);
            fputc('}', file);
        } else
            put_motion(file, &attractors->motions[k], attractors->shares[k], attractors->seeds);
    if (json)
        fputs("]}\n", file);
}
