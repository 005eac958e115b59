/* Reference files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene.h"

#include <string.h>

static const char method[] =
    "Gragg's midpoint rule, extrapolated; impacts by Newton's method on trial steps; ",
                  newton[] =
                      "Newton on the period map until the residual (displacements; velocities over omega) no "
                      "longer falls; monodromy by variational equations with saltation matrices",
                  order[] =
                      "Made by tests/precise. Order of state: q_1..q_N, q_1'..q_N'. Stroboscopic section at "
                      "tau = 0 (mod T).";

static void write_parameter(FILE *file, const char *key, real value, const char *tail) {
    fprintf(file, "\"%s\": %s%s", key, shortest_decimal((double)value).text, tail);
}

static void write_real(FILE *file, const char *head, real value, const char *tail) {
    char text[64];
    real_print(text, sizeof text, 25, value);
    fprintf(file, "%s\"%s\"%s", head, text, tail);
}

static void write_stop(FILE *file, const model *m) {
    if (!m->stop.upper && !m->stop.lower) {
        fputs("\n },\n", file);
        return;
    }
    fputs(",\n  \"stop\": {\n   ", file);
    if (m->pipe)
        write_parameter(file, "xi", m->stop.xi, ",\n   ");
    write_parameter(file, "d", m->stop.d, ",\n   ");
    write_parameter(file, "r", m->stop.r, ",\n   ");
    const char *sides = m->stop.upper && m->stop.lower ? "both" : m->stop.upper ? "upper" : "lower";
    fprintf(file, "\"sides\": \"%s\"\n  }\n },\n", sides);
}

static void write_scene(FILE *file, const model *m) {
    const struct {
        const char *key;
        real value;
    } pipe[] = {{"sigma", m->sigma},
                {"alpha", m->alpha},
                {"beta", m->beta},
                {"kappa", m->kappa},
                {"u0", m->u0}},
      oscillator[] = {{"m", m->m}, {"c", m->c}, {"k", m->k}, {"F", m->F}, {"F0", m->F0}};
    fprintf(file, " \"scene\": {\n  \"model\": \"%s\",\n  \"N\": %d,\n", m->pipe ? "pipe" : "oscillator",
            m->modes);
    for (int k = 0; k < 5; k++) {
        fputs("  ", file);
        write_parameter(file, m->pipe ? pipe[k].key : oscillator[k].key,
                        m->pipe ? pipe[k].value : oscillator[k].value, ",\n");
    }
    fputs("  ", file);
    write_parameter(file, "omega", m->omega, "");
    write_stop(file, m);
}

static void write_vector(FILE *file, int n, const real *x, const char *indent) {
    for (int i = 0; i < n; i++)
        write_real(file, indent, x[i], i < n - 1 ? ",\n" : "\n");
}

static void write_states(FILE *file, const model *m, int periods, const passage *p) {
    const int n = 2 * m->modes;
    if (m->stop.upper || m->stop.lower) {
        write_real(file, " \"stop_displacement\": ", model_contact(m, p->section[0]), ",\n");
        write_real(file, " \"stop_velocity\": ", model_contact(m, p->section[0] + m->modes), ",\n");
    }
    fputs(" \"state\": [\n", file);
    write_vector(file, n, p->section[0], "  ");
    fputs(" ],\n \"section_states\": [\n", file);
    for (int k = 0; k < periods; k++) {
        fputs("  [\n", file);
        write_vector(file, n, p->section[k], "   ");
        fputs(k < periods - 1 ? "  ],\n" : "  ]\n", file);
    }
    fputs(" ],\n", file);
}

static void write_events(FILE *file, const passage *p) {
    fputs(" \"events\": [", file);
    for (int k = 0; k < p->impact_count; k++) {
        const impact *hit = &p->impacts[k];
        fprintf(file, "%s\n  {\n   \"event\": \"impact\",\n   \"side\": \"%s\",\n", k ? "," : "",
                hit->side > 0 ? "upper" : "lower");
        write_real(file, "   \"time_over_T\": ", hit->time, ",\n");
        write_real(file, "   \"normal_velocity_before\": ", hit->speed, "\n  }");
    }
    fputs("\n ],\n", file);
}

/* The largest four; a pair is not split. What is rounding beside the largest is not listed. */
static void write_multipliers(FILE *file, int n, const complex_real *values) {
    int count = 0;
    while (count < n && count < 4 &&
           real_modulus(values[count]) > real_pow(10, -15) * real_modulus(values[0]))
        count++;
    if (count == 4 && n > 4 && imaginary_part(values[3]) > 0)
        count = real_modulus(values[4]) > 0 ? 5 : 4;
    fputs(" \"multipliers_dominant\": [", file);
    for (int k = 0; k < count; k++) {
        real im = imaginary_part(values[k]), negligible = real_pow(10, -20) * real_modulus(values[k]);
        char text[2][64];
        real_print(text[0], sizeof text[0], 19, real_part(values[k]));
        real_print(text[1], sizeof text[1], 19, real_abs(im) > negligible ? im : (real)0);
        fprintf(file, "%s\n  [\"%s\", \"%s\"]", k ? "," : "", text[0], text[1]);
    }
    fputs("\n ],\n", file);
}

static void write_monodromy(FILE *file, int n, const real *matrix) {
    fputs(" \"monodromy_over_periods\": [\n", file);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            fprintf(file, "%s%.17g%s", j ? "" : "  [", (double)matrix[i * n + j],
                    j < n - 1   ? ", "
                    : i < n - 1 ? "],\n"
                                : "]\n");
    fputs(" ],\n", file);
}

static bool write_spectrum(FILE *file, int n, const real *matrix) {
    complex_real a[model_dimension * model_dimension], values[model_dimension];
    for (int i = 0; i < n * n; i++)
        a[i] = matrix[i];
    bool found = eigenvalues(n, a, values);
    if (found)
        write_multipliers(file, n, values);
    return found;
}

bool scene_write(FILE *file, const orbit *o) {
    const int n = 2 * o->model->modes, impacts = o->passage->impact_count;
    fputs("{\n", file);
    write_scene(file, o->model);
    fprintf(file, " \"periods\": %d,\n \"sticking_intervals\": 0,\n", o->periods);
    fprintf(file, " \"label\": \"%d/%d\",\n \"impacts\": %d,\n", impacts, o->periods, impacts);
    fputs(" \"section_phase\": 0,\n", file);
    write_states(file, o->model, o->periods, o->passage);
    write_events(file, o->passage);
    bool found = write_spectrum(file, n, o->matrix);
    write_monodromy(file, n, o->matrix);
    fprintf(file, " \"residual\": %.1e,\n \"bits\": %d,\n", (double)o->residual, real_bits);
    fprintf(file, " \"how\": \"%s%s%s. %s\"\n}\n", method, newton,
            o->known ? ", in long double arithmetic (17 digits)" : "", order);
    return found && !ferror(file);
}
