/* Locates the special points of a branch of Saltus anew in 128 bits, with nothing of Saltus in it:
 *
 *   saltus continue pipe --set N=1 omega=30 --in u0=4:5 --json -o b.h5 | precise_points u0 [most]
 *
 * Of the lines PD, LP, NS, GR, BP, CH and ST, `most` at most, spread over the branch and its kinds, each is
 * located by its own rule.
 *
 * PD, LP, NS, GR: the zero of the orbit's equations and one more: a multiplier -1 or 1, a pair of modulus 1,
 * a highest gap of zero.
 *
 * BP: two branches go through it, on one of which orbits are found on both sides: there the multiplier
 * nearest to 1 is interpolated to 1.
 *
 * ST, and CH where a contact becomes permanent: what presses on a contact in the middle of it is extrapolated
 * to nothing, from the side on which the contact is whole.
 *
 * Other CH: beyond it complete chatter ends with a contact whose length goes with a power of the distance,
 * down to ten times the accuracy that was stated; on the other side no orbit nearby has such a contact.
 *
 * A line for each says how far off the value was and what accuracy was stated; status 1 where one was further
 * off than that.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene.h"

#include <string.h>

enum { iterations_most = 14, unknowns_most = model_dimension + 1, lines_most = 10000, line_most = 1 << 20 };

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

/* The orbit at a fixed parameter, by Newton's method from `state`. */
static const char *solve(problem *q, real parameter, real *state) {
    const int n = q->n;
    real a[model_dimension * model_dimension], correction[model_dimension], last = HUGE_VAL;
    *q->parameter = parameter;
    model_prepare(&q->m);
    for (int k = 0; k < iterations_most; k++) {
        const char *trouble = passage_run(&q->p, &q->stepper, q->periods, true, state);
        if (trouble)
            return trouble;
        for (int i = 0; i < n; i++) {
            correction[i] = state[i] - q->p.x[i];
            for (int j = 0; j < n; j++)
                a[i * n + j] = q->p.x[n * (1 + j) + i] - (i == j);
        }
        if (!shoot_solve(n, a, correction))
            return "the orbit is not isolated";
        for (int i = 0; i < n; i++)
            state[i] += correction[i];
        real moved = shoot_distance(&q->m, correction);
        if (moved < real_pow(10, -22) || (moved < real_pow(10, -17) && moved > last / 10))
            return NULL;
        last = moved;
    }
    return "Newton's method finds no orbit";
}

/* Where the polynomial through so many points is zero, near the first of them. */
static real zero_of_polynomial(int count, const real *at, const real *value) {
    real result = 0;
    for (int i = 0; i < count; i++) { /* the inverse function, by Lagrange, at zero */
        real weight = 1;
        for (int j = 0; j < count; j++)
            if (j != i)
                weight *= value[j] / (value[j] - value[i]);
        result += weight * at[i];
    }
    return result;
}

/* The multiplier nearest to 1, less 1, of the orbits at four places around a branch point. */
static const char *locate_branch_point(problem *q, real *unknowns) {
    enum { places = 4 };
    static const int steps[places] = {-2, -1, 1, 2};
    const int n = q->n;
    const real value = unknowns[n], apart = real_pow(10, -7) * real_abs(value);
    real at[places], off[places], state[model_dimension], matrix[model_dimension * model_dimension];
    for (int k = 0; k < places; k++) {
        memcpy(state, unknowns, n * sizeof *state);
        at[k] = steps[k] * apart;
        const char *trouble = solve(q, value + at[k], state);
        if (trouble)
            return trouble;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                matrix[i * n + j] = q->p.x[n * (1 + j) + i];
        if (!special(q, matrix, &off[k]))
            return "no multiplier";
    }
    if ((off[1] > 0) == (off[2] > 0))
        return "the multiplier does not pass 1";
    unknowns[n] = value + zero_of_polynomial(places, at, off);
    return NULL;
}

/* The contact that is pressed least in its middle. */
static real least_pressed(const passage *p) {
    real least = HUGE_VAL;
    for (int k = 0; k < p->stick_count; k++)
        least = real_min(least, p->sticks[k].least);
    return least;
}

/* The orbits beside a split are had from one another: at the split itself rounding of the state decides
 * whether the contact holds. Orbits further away come first where they can be had. */
static bool approach_split(problem *q, real value, real apart, real *state) {
    for (int power = 2; power >= 0; power--)
        if (solve(q, value + apart * real_pow(10, power), state))
            return false;
    return true;
}

static const char *locate_split(problem *q, real *unknowns) {
    enum { places = 4 };
    const int n = q->n;
    const real value = unknowns[n], apart = real_pow(10, -6) * real_abs(value);
    real at[places], press[places], state[model_dimension];
    for (int side = -1; side <= 1; side += 2) {
        bool found = true;
        memcpy(state, unknowns, n * sizeof *state);
        if (!approach_split(q, value, side * places * apart, state))
            memcpy(state, unknowns, n * sizeof *state);
        for (int k = places - 1; k >= 0 && found; k--) {
            at[k] = side * (k + 1) * apart;
            found = !solve(q, value + at[k], state);
            press[k] = least_pressed(&q->p);
            found = found && press[k] < HUGE_VAL && (k == places - 1 || press[k] < press[k + 1]);
        }
        if (found) {
            unknowns[n] = value + zero_of_polynomial(places, at, press);
            return NULL;
        }
    }
    return "no contact that splits";
}

/* The shortest contact, one over a section as one. */
static real shortest_contact(const problem *q) {
    const passage *p = &q->p;
    real shortest = HUGE_VAL;
    for (int k = 0; k < p->stick_count; k++) {
        const stick *s = &p->sticks[k], *last = &p->sticks[p->stick_count - 1];
        real length = s->end - s->begin;
        if (s->begin == 0 && last->end == q->periods && s != last)
            length += last->end - last->begin;
        if (s->end < q->periods)
            shortest = real_min(shortest, length);
    }
    return shortest;
}

enum { decades = 8 };

/* The lengths of the shortest contacts at distances from the value that are ten times as long each, from the
 * accuracy on, on one side; 0 where there is no orbit with so many contacts as there are at most. */
static void measure_contacts(problem *q, const real *unknowns, real accuracy, int side, int *most,
                             int contacts[decades + 1], real length[decades + 1]) {
    const int n = q->n;
    real state[model_dimension];
    memcpy(state, unknowns, n * sizeof *state);
    for (int k = decades; k >= 0; k--) {
        real distance = accuracy * real_pow(10, k);
        length[k] = 0;
        contacts[k] = 0;
        if (distance > real_pow(10, -4) * real_abs(unknowns[n]))
            continue;
        if (!solve(q, unknowns[n] + side * distance, state) && shortest_contact(q) < q->periods) {
            length[k] = shortest_contact(q);
            contacts[k] = q->p.stick_count;
            *most = contacts[k] > *most ? contacts[k] : *most;
        } else
            memcpy(state, unknowns, n * sizeof *state);
    }
}

static int by_size(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* Down to where the lengths shrink by the same factor in three decades, to one part in five: by that of most.
 */
static const char *locate_completion(problem *q, real *unknowns, real accuracy) {
    const double doubt = 0.2;
    real length[2][decades + 1];
    double factor[decades], sorted[decades];
    int found[2] = {0}, contacts[2][decades + 1], count = 0, most = 0;
    for (int k = 0; k < 2; k++)
        measure_contacts(q, unknowns, accuracy, k ? 1 : -1, &most, contacts[k], length[k]);
    for (int side = 0; side < 2; side++)
        for (int k = 0; k <= decades; k++) {
            if (contacts[side][k] < most)
                length[side][k] = 0;
            found[side] += length[side][k] > 0;
        }
    if (found[0] && found[1])
        return "complete chatter on both sides";
    const real *of = length[found[1] > 0];
    for (int k = 0; k < decades; k++) {
        factor[k] = of[k] > 0 && of[k + 1] > 0 ? log((double)(of[k + 1] / of[k])) : INFINITY;
        if (isfinite(factor[k]))
            sorted[count++] = factor[k];
    }
    qsort(sorted, (size_t)count, sizeof *sorted, by_size);
    for (int k = 0, like = 0; k < decades && count > 0; k++) {
        like = fabs(factor[k] - sorted[count / 2]) < doubt ? like + 1 : 0;
        if (like == 3) {
            unknowns[q->n] += accuracy * real_pow(10, k - 2);
            return NULL;
        }
    }
    return "no complete chatter on either side";
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
    /* Where orbits of twice the period join it, the half is the one that flips. */
    if (strcmp(q.kind, "PD") == 0 && strstr(line, "joins the orbits of half the period"))
        q.periods /= 2;
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
    bool held = strstr(line, "\"motion\": \"held\"") || strstr(line, "\"motion_after\": \"held\"");
    if (!trouble) {
        q.n = 2 * q.m.modes;
        unknowns[q.n] = *q.parameter;
        trouble = strcmp(q.kind, "BP") == 0   ? locate_branch_point(&q, unknowns)
                  : strcmp(q.kind, "ST") == 0 ? locate_split(&q, unknowns)
                  : held                      ? locate_split(&q, unknowns)
                  : strcmp(q.kind, "CH") == 0 ? locate_completion(&q, unknowns, (real)accuracy)
                                              : locate(&q, unknowns);
        /* What branches off turns back where it begins. */
        if (trouble && strcmp(q.kind, "LP") == 0) {
            unknowns[q.n] = (real)value;
            trouble = scene_read(line, &q.m, &q.periods, &impacts, unknowns);
            trouble = trouble ? trouble : locate_branch_point(&q, unknowns);
        }
        step_close(&q.stepper);
    }
    if (trouble) {
        printf("%s %.16g: %s\n", q.kind, value, trouble);
        return false;
    }
    double off = fabs((double)(unknowns[q.n] - (real)value));
    bool right = off <= (strcmp(q.kind, "CH") == 0 && !held ? 11 : 1) * accuracy;
    real slowest = HUGE_VAL;
    for (int k = 0; k < q.p.impact_count; k++)
        slowest = real_min(slowest, real_abs(q.p.impacts[k].speed));
    printf("%s %.16g off %.1e stated %.1e slowest %.1e contacts %d%s\n", q.kind, value, off, accuracy,
           (double)slowest, q.p.stick_count, right ? "" : " WRONG");
    return right;
}

static const char *const kinds[] = {"BP", "CH", "ST", "NS", "PD", "LP", "GR"};
enum { kind_count = sizeof kinds / sizeof kinds[0] };

/* The kind of a line, or kind_count. */
static int kind_of(const char *line) {
    const char *label = strstr(line, "\"label\": \"");
    int k = label ? 0 : kind_count;
    while (k < kind_count && strncmp(label + strlen("\"label\": \""), kinds[k], 2) != 0)
        k++;
    return k;
}

int main(int count, char **words) {
    if (count < 2 || count > 3) {
        fputs("precise_points PARAMETER [most] < points of a branch, as JSON\n", stderr);
        return 2;
    }
    char **lines = calloc(lines_most, sizeof *lines), *line = malloc(line_most);
    int wanted = 0, left = count > 2 ? atoi(words[2]) : lines_most, of_kind[kind_count + 1] = {0};
    bool right = lines && line;
    while (right && wanted < lines_most && fgets(line, line_most, stdin))
        if (kind_of(line) < kind_count) {
            lines[wanted] = malloc(strlen(line) + 1);
            right = lines[wanted] != NULL;
            if (right)
                strcpy(lines[wanted++], line);
            of_kind[kind_of(line)]++;
        }
    for (int kind = 0; kind < kind_count; kind++) {
        int later = 0, seen = 0;
        for (int k = kind; k < kind_count; k++)
            later += of_kind[k] > 0;
        int most = later ? (left + later - 1) / later : 0, checked = 0;
        most = most < of_kind[kind] ? most : of_kind[kind];
        for (int k = 0; k < wanted && checked < most; k++)
            if (kind_of(lines[k]) == kind && (long)seen++ * most / of_kind[kind] >= checked) {
                right &= check(lines[k], words[1]);
                checked++;
            }
        left -= checked;
    }
    for (int k = 0; k < wanted; k++)
        free(lines[k]);
    free(lines);
    free(line);
    return right ? 0 : 1;
}
