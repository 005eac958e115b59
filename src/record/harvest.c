/* The orbits harvested from a trajectory, as a table for people.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "saltus/record.h"

#include <math.h>

void saltus_write_harvest_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                               const saltus_harvest *harvest) {
    fprintf(file, "%s: %d periodic orbit%s from %lld close returns in %lld periods\n", scene->name,
            harvest->count, harvest->count == 1 ? "" : "s", harvest->candidates, harvest->periods);
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
