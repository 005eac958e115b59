/* Results with many motions: attractors from many initial states, and the orbits along a trajectory.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "saltus/record.h"

#include <math.h>

void saltus_write_attractors(FILE *file, const saltus_scene *scene, const saltus_system *system,
                             const saltus_attractors *attractors, bool json) {
    static const char *const mirror[] = {"", "its own mirror image", "one of a mirror pair", ""};
    const int seeds = attractors->seeds;
    const bool cut = seeds < attractors->asked;
    if (json)
        fprintf(file, "{\"version\": \"" SALTUS_VERSION "\", %s\"seeds\": %d, \"attractors\": [",
                cut ? "\"complete\": false, " : "", seeds);
    else
        fprintf(file, "%s: %d attractor%s from %d random initial states%s\n", scene->name, attractors->count,
                saltus_plural(attractors->count), seeds, cut ? " (interrupted)" : "");
    for (int k = 0; k < attractors->count; k++) {
        const saltus_motion *motion = &attractors->motions[k];
        const int share = attractors->shares[k];
        char verdict[64];
        if (json) {
            fprintf(file, "%s{\"share\": %d, \"motion\": ", k ? ", " : "", share);
            saltus_write_motion_json(file, scene, system, motion);
            fputc('}', file);
            continue;
        }
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
    if (json)
        fputs("]}\n", file);
}

void saltus_write_harvest_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                               const saltus_harvest *harvest) {
    fprintf(file, "%s: %d periodic orbit%s from %lld close return%s in %lld period%s\n", scene->name,
            harvest->count, saltus_plural(harvest->count), harvest->candidates,
            saltus_plural(harvest->candidates), harvest->periods, saltus_plural(harvest->periods));
    saltus_put_scene(file, scene, system);
    if (harvest->count)
        fprintf(file, "%5s  %-12s %9s  %11s  %9s\n%5s  %-12s %9s  %11s\n", "", "n/p", "largest",
                "outside the", "residual", "", "", "|mu|", "unit circle");
    for (int k = 0; k < harvest->count; k++) {
        const saltus_harvest_orbit *o = &harvest->orbits[k];
        char name[SALTUS_LABEL_MAX];
        saltus_orbit_label(o->impacts, o->orbit.periods, name);
        fprintf(file, "%5d  %-12s %9.3g  %11d  %9.1e", k + 1, name, exp(o->orbit.multipliers[0].log_modulus),
                saltus_multipliers_unstable(o->orbit.multipliers, o->orbit.multiplier_count),
                o->orbit.residual);
        if (o->mirror == k)
            fputs("  its own mirror image", file);
        else if (o->mirror >= 0)
            fprintf(file, "  mirror image of %d", o->mirror + 1);
        fputc('\n', file);
    }
}
