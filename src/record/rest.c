/* An equilibrium for people and for programs, with the same keys as a motion for what they have in common.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/json.h"

#include <math.h>

static const char *label_of(const saltus_equilibrium *e) {
    return e->contacts ? "held" : "equilibrium";
}

void saltus_write_equilibrium_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                   const saltus_equilibrium *e) {
    saltus_json_begin(file, scene);
    saltus_json_text(file, "label", label_of(e));
    saltus_json_text(file, "kind", label_of(e));
    fputs(", \"impacts\": 0, \"periods\": 0, \"sticking_intervals\": 0", file);
    saltus_json_list(file, "state", e->state, e->dimension);
    saltus_json_events(file, system, NULL, 0);
    saltus_json_multipliers(file, NULL, 0);
    saltus_json_rows(file, "eigenvalues", e->eigenvalues, e->eigenvalue_count, 2, 2);
    fprintf(file, ", \"stable\": %s, \"instability\": %d", e->stable ? "true" : "false", e->instability);
    saltus_json_contact_force(file, system, e->contact_force, e->gap);
    saltus_json_member(file, "residual", e->residual);
    fprintf(file, ", \"iterations\": %d", e->iterations);
    saltus_json_end(file, saltus_system_spec(system), NULL);
}

void saltus_write_equilibrium_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                   const saltus_equilibrium *e) {
    bool modal = saltus_notation_of(system)->structure == SALTUS_STRUCTURE_LINE;
    fprintf(file, "%s: %s, %s\n", scene->name, label_of(e), e->stable ? "stable" : "unstable");
    saltus_put_scene(file, scene, system);
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        fprintf(file, "  %-14sstop %d %s: ", f ? "" : "contacts", face.stop + 1, saltus_side_word(face.side));
        if (e->contacts >> f & 1)
            fprintf(file, "held, force %.6g%s\n", e->contact_force[f], modal ? " per modal mass" : "");
        else
            fprintf(file, "free, gap %.6g\n", e->gap[f]);
    }
    saltus_put_eigenvalues(file, e->eigenvalues, e->eigenvalue_count, e->contacts);
    fprintf(file, "  %-14s", "state");
    for (int i = 0; i < saltus_system_dof(system); i++)
        fprintf(file, "%s%.10g", i ? ", " : "", e->state[i]);
    fprintf(file, "\n  %-14sresidual %.1e after %d Newton step%s\n", "rest", e->residual, e->iterations,
            saltus_plural(e->iterations));
}
