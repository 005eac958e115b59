/* Refines a periodic orbit of Saltus to about 30 digits, with nothing of Saltus in it: reference orbits.
 *
 *   saltus orbit fig2 --set omega=42 --periods 4 --json | precise_orbit - > free5.json
 *
 * Options: --columns k (of the extrapolation), --disturb x (the start, relative): two runs that differ in
 * them show how many digits are right. --matrix: Newton's method with the file's monodromy_over_periods,
 * without variational equations; for large systems, where the matrix comes from precise_orbit_long.
 * --check x: instead of writing, see that the orbit found is that of the file within x.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene.h"

#include <string.h>

typedef struct settings {
    const char *path;
    int columns;
    double disturb, check;
    bool known;
} settings;

static bool read_settings(int count, char **words, settings *s) {
    *s = (settings){.columns = real_columns};
    for (int k = 1; k < count; k++)
        if (strcmp(words[k], "--columns") == 0 && k + 1 < count)
            s->columns = atoi(words[++k]);
        else if (strcmp(words[k], "--disturb") == 0 && k + 1 < count)
            s->disturb = atof(words[++k]);
        else if (strcmp(words[k], "--check") == 0 && k + 1 < count)
            s->check = atof(words[++k]);
        else if (strcmp(words[k], "--matrix") == 0)
            s->known = true;
        else if (!s->path)
            s->path = words[k];
        else
            return false;
    return s->path && s->columns >= 2 && s->columns <= step_columns;
}

static char *read_text(const char *path) {
    enum { longest = 1 << 20 };
    FILE *file = strcmp(path, "-") == 0 ? stdin : fopen(path, "rb");
    char *text = calloc(1, longest);
    if (!file || !text || fread(text, 1, longest - 1, file) == 0) {
        free(text);
        text = NULL;
    }
    if (file && file != stdin)
        fclose(file);
    return text;
}

/* Write the orbit, or compare it with what the file said. */
static const char *conclude(const settings *s, const orbit *o, const real *start, const real *state) {
    if (s->check == 0)
        return scene_write(stdout, o) ? NULL : "no multipliers, or the output cannot be written";
    real difference[model_dimension];
    for (int i = 0; i < 2 * o->model->modes; i++)
        difference[i] = state[i] - start[i];
    double distance = (double)shoot_distance(o->model, difference);
    fprintf(stderr, "distance from the file's orbit %.1e\n", distance);
    return distance <= s->check ? NULL : "the orbit is not that of the file";
}

static const char *refine(const settings *s, const char *text, passage *p) {
    model m;
    step stepper;
    int periods, impacts;
    real start[model_dimension], state[model_dimension], matrix[model_dimension * model_dimension];
    const char *trouble = scene_read(text, &m, &periods, &impacts, start);
    if (trouble)
        return trouble;
    const int n = 2 * m.modes;
    for (int i = 0; i < n; i++)
        state[i] = start[i] * (1 + (i % 2 ? -1 : 1) * (real)s->disturb);
    if (s->known && !scene_read_matrix(text, n, matrix))
        return "no matrix";
    if (!step_open(&stepper, &m, s->columns, real_tolerance(), n + 1))
        return "no memory";
    orbit o = {.model = &m, .periods = periods, .passage = p, .matrix = matrix, .known = s->known};
    trouble = shoot(&stepper, periods, state, p, matrix, s->known, &o.residual);
    if (!trouble && p->stick_count)
        trouble = "orbits that stick are no references";
    if (!trouble && impacts >= 0 && impacts != p->impact_count)
        trouble = "not as many impacts as the start says";
    if (!trouble)
        trouble = conclude(s, &o, start, state);
    step_close(&stepper);
    return trouble;
}

int main(int count, char **words) {
    settings s;
    if (!read_settings(count, words, &s)) {
        fputs("precise_orbit START.json|- [--columns 2..24] [--disturb x] [--matrix] [--check x]\n", stderr);
        return 2;
    }
    char *text = read_text(s.path);
    passage *p = calloc(1, sizeof *p);
    const char *trouble = text && p ? refine(&s, text, p) : "the start cannot be read";
    if (trouble)
        fprintf(stderr, "precise_orbit: %s\n", trouble);
    free(p);
    free(text);
    return trouble ? 1 : 0;
}
