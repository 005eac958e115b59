/* The ranges of the figures.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "survey.h"

#include <math.h>
#include <string.h>

static const trial_figure figures[] = {
    {"2", "fig2", NULL, "omega", 0.1, 550, 5, 10, NAN},
    {"4a", "fig4a", NULL, "d", 0.0002, 230, 5, 10, 0},
    {"4b", "fig4b", NULL, "d", 0.0002, 230, 5, 10, 0},
    {"5", "fig5", NULL, "omega", 0.1, 550, 5, 10, 0.03},
    {"6", "fig6", NULL, "omega", 0.1, 550, 5, 10, 0.035},
    {"8a", "fig8", "r=0.8", "omega", 0.2, 275, 5, 5, 0.035},
    {"8b", "fig8", "r=0.7", "omega", 0.2, 275, 5, 5, 0.035},
    {"8c", "fig8", "r=0.6", "omega", 0.2, 275, 5, 5, 0.035},
};

enum { figure_count = sizeof figures / sizeof figures[0] };

const trial_figure *trial_figure_at(int k) {
    return k >= 0 && k < figure_count ? &figures[k] : NULL;
}

const trial_figure *trial_figure_find(const char *name) {
    for (int k = 0; k < figure_count; k++)
        if (strcmp(figures[k].name, name) == 0)
            return &figures[k];
    return NULL;
}

saltus_status trial_scene(const trial_figure *figure, saltus_scene *scene, saltus_message *message) {
    saltus_status status = saltus_scene_load(figure->scene, scene, message);
    if (status == SALTUS_OK && figure->setting)
        status = saltus_scene_set(scene, figure->setting, message);
    return status;
}

saltus_status trial_scene_at(const trial_figure *figure, double value, saltus_scene *scene,
                             saltus_message *message) {
    char assignment[64];
    snprintf(assignment, sizeof assignment, "%s=%.17g", figure->key, value);
    saltus_status status = trial_scene(figure, scene, message);
    return status == SALTUS_OK ? saltus_scene_set(scene, assignment, message) : status;
}
