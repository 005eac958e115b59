/* Locates the special points of a branch of Saltus anew in 128 bits, with nothing of Saltus in it:
 *
 *   saltus continue pipe --set N=1 omega=30 --in u0=4:5 --json -o b.h5 | precise_points u0 [most]
 *
 * Of the lines PD, LP, NS and GR, `most` at most, spread over the branch, each becomes the zero of the
 * orbit's equations and one more: a multiplier -1 or 1, a pair of modulus 1, a highest gap of zero. A line
 * for each says how far off the value was and what accuracy was stated; status 1 where one was further off
 * than that.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene.h"

#include <string.h>

enum { iterations_most = 14, unknowns_most = model_dimension + 1, line_most = 1 << 20 };

typedef struct problem {
    model m;
    step stepper;
    passage p;
    real *parameter; /* of m */
    char kind[3];
    int periods, n;
} problem;

static real *place_of(model *m, const char *key) {
    const struct {
        const char *key;
        real *place;
    } keys[] = {{"alpha", &m->alpha}, {"beta", &m->beta},   {"kappa", &m->kappa}, {"u0", &m->u0},
                {"sigma", &m->sigma}, {"omega", &m->omega}, {"d", &m->stop.d},    {"r", &m->stop.r},
                {"xi", &m->stop.xi},  {"c", &m->c},         {"k", &m->k},         {"F", &m->F},
                {"F0", &m->F0}};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        if (strcmp(keys[k].key, key) == 0)
            return keys[k].place;
    return NULL;
}

/* What makes the orbit special: zero at the point. */
static bool special(const problem *q, const real *matrix, real *value) {
    const int n = q->n;
    complex_real a[model_dimension * model_dimension], mu[model_dimension];
    if (strcmp(q->kind, "GR") == 0) {
        *value = q->p.height;
        return *value > -1;
    }
    for (int i = 0; i < n * n; i++)
        a[i] = matrix[i];
    if (!eigenvalues(n, a, mu))
        return false;
    real nearest = HUGE_VAL, target = strcmp(q->kind, "PD") == 0 ? -1 : 1;
    for (int i = 0; i < n; i++) {
        bool pair = strcmp(q->kind, "NS") == 0;
        real off = pair ? real_modulus(mu[i]) - 1 : real_modulus(mu[i] - target);
        if ((pair && imaginary_part(mu[i]) == 0) || real_abs(off) >= nearest)
            continue;
        nearest = real_abs(off);
        *value = pair ? off : real_part(mu[i]) - target;
    }
    return nearest < HUGE_VAL;
}

/* The equations at the unknowns: the state and the parameter. */
static const char *evaluate(problem *q, const real *unknowns, real *equations) {
    real matrix[model_dimension * model_dimension];
    const int n = q->n;
    *q->parameter = unknowns[n];
    model_prepare(&q->m);
    const char *trouble = passage_run(&q->p, &q->stepper, q->periods, true, unknowns);
    if (trouble)
        return trouble;
    for (int i = 0; i < n; i++) {
        equations[i] = q->p.x[i] - unknowns[i];
        for (int j = 0; j < n; j++)
            matrix[i * n + j] = q->p.x[n * (1 + j) + i];
    }
    return special(q, matrix, &equations[n]) ? NULL : "no multiplier, or no touch";
}

/* Newton's method with differences, which lose less than their own step beside 34 digits. */
static const char *locate(problem *q, real *unknowns) {
    const int n = q->n + 1;
    real equations[unknowns_most], beside[unknowns_most], a[unknowns_most * unknowns_most];
    real last = HUGE_VAL;
    for (int k = 0; k < iterations_most; k++) {
        const char *trouble = evaluate(q, unknowns, equations);
        for (int j = 0; j < n && !trouble; j++) {
            real kept = unknowns[j], apart = real_pow(10, -16) * real_max(real_abs(kept), real_pow(10, -3));
            unknowns[j] += apart;
            trouble = evaluate(q, unknowns, beside);
            unknowns[j] = kept;
            for (int i = 0; i < n; i++)
                a[i * n + j] = (beside[i] - equations[i]) / apart;
        }
        if (trouble)
            return trouble;
        if (!shoot_solve(n, a, equations))
            return "the point is not isolated";
        for (int j = 0; j < n; j++)
            unknowns[j] -= equations[j];
        real moved = real_abs(equations[n - 1] / unknowns[n - 1]);
        if (moved < real_pow(10, -20) || (moved < real_pow(10, -17) && moved > last / 10))
            return NULL;
        last = moved;
    }
    return "Newton's method finds no point";
}

static bool number_after(const char *text, const char *key, double *value) {
    const char *at = strstr(text, key);
    return at && sscanf(at + strlen(key), "%lf", value) == 1;
}

/* One line of the branch; false where the point is further off than was stated, or cannot be located. */
static bool check(const char *line, const char *key) {
    static problem q;
    real unknowns[unknowns_most];
    int impacts;
    double value = 0, accuracy = 0, touch = 0;
    const char *label = strstr(line, "\"label\": \"");
    q = (problem){.periods = 0};
    const char *trouble = scene_read(line, &q.m, &q.periods, &impacts, unknowns);
    if (!trouble && !(number_after(line, "\"values\": [", &value) &&
                      number_after(line, "\"accuracy\": ", &accuracy) && (q.parameter = place_of(&q.m, key))))
        trouble = "no value, accuracy or parameter";
    memcpy(q.kind, label + strlen("\"label\": \""), 2);
    if (!trouble && strcmp(q.kind, "GR") == 0) {
        if (!number_after(strstr(line, "\"grazing\"") ? strstr(line, "\"grazing\"") : "",
                          "\"time_over_T\": ", &touch))
            trouble = "no touch";
        q.p.touch[0] = (real)touch;
        q.p.touch[1] = (real)(touch < 0.5 * q.periods ? touch + 0.5 * q.periods : touch - 0.5 * q.periods);
        q.p.around = real_pow(10, -5);
    }
    if (!trouble && !step_open(&q.stepper, &q.m, real_columns, real_pow(10, -28), 2 * q.m.modes + 1))
        trouble = "no memory";
    if (!trouble) {
        q.n = 2 * q.m.modes;
        unknowns[q.n] = *q.parameter;
        trouble = locate(&q, unknowns);
        step_close(&q.stepper);
    }
    if (trouble) {
        printf("%s %.16g: %s\n", q.kind, value, trouble);
        return false;
    }
    double off = fabs((double)(unknowns[q.n] - (real)value));
    real slowest = HUGE_VAL;
    for (int k = 0; k < q.p.impact_count; k++)
        slowest = real_min(slowest, real_abs(q.p.impacts[k].speed));
    printf("%s %.16g off %.1e stated %.1e slowest %.1e%s\n", q.kind, value, off, accuracy, (double)slowest,
           off <= accuracy ? "" : " WRONG");
    return off <= accuracy;
}

static bool is_wanted(const char *line) {
    static const char *const kinds[] = {"PD", "LP", "NS", "GR"};
    const char *label = strstr(line, "\"label\": \"");
    for (size_t k = 0; label && k < sizeof kinds / sizeof kinds[0]; k++)
        if (strncmp(label + strlen("\"label\": \""), kinds[k], 2) == 0)
            return strstr(line, "\"impacts\": null") == NULL &&
                   strstr(line, "\"sticking_intervals\": 0") != NULL;
    return false;
}

int main(int count, char **words) {
    if (count < 2 || count > 3) {
        fputs("precise_points PARAMETER [most] < points of a branch, as JSON\n", stderr);
        return 2;
    }
    char **lines = calloc(10000, sizeof *lines), *line = malloc(line_most);
    int wanted = 0, most = count > 2 ? atoi(words[2]) : 10000;
    bool right = lines && line;
    while (right && wanted < 10000 && fgets(line, line_most, stdin))
        if (is_wanted(line)) {
            lines[wanted] = malloc(strlen(line) + 1);
            right = lines[wanted] != NULL;
            if (right)
                strcpy(lines[wanted++], line);
        }
    for (int k = 0, checked = 0; k < wanted; k++)
        if ((long)k * most / wanted >= checked && checked < most) {
            right &= check(lines[k], words[1]);
            checked++;
        }
    for (int k = 0; k < wanted; k++)
        free(lines[k]);
    free(lines);
    free(line);
    return right ? 0 : 1;
}
