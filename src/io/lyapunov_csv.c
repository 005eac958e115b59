/* How the largest exponent's estimate converged, as comma-separated values.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/describe.h"
#include "io/lyapunov_plot.h"

#include <math.h>

static void put_scene(const saltus_scene *scene, const saltus_system *system, FILE *file) {
    const saltus_spec *spec = saltus_system_spec(system);
    fprintf(file, "# Saltus " SALTUS_VERSION " largest Lyapunov exponent\n# scene: %s\n", scene->name);
    if (scene->title[0])
        fprintf(file, "# title: %s\n", scene->title);
    fprintf(file, "# model: %s\n# parameters: ", saltus_model_name(spec->model));
    saltus_put_parameters(file, spec);
    for (int s = 0; s < spec->stop_count; s++) {
        fprintf(file, "\n# stop %d: ", s + 1);
        saltus_put_stop(file, spec, s);
    }
    fputc('\n', file);
}

static void put_options(const saltus_system *system, const saltus_lyapunov_options *o, FILE *file) {
    char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX];
    fprintf(file, "# options: transient = %lld, periods = %lld, members = %d, seed = %lu", o->transient,
            o->periods, o->members, o->seed);
    fprintf(file, ", precision = %s, interval = %s", saltus_number(o->precision, a),
            saltus_number(o->interval, b));
    fprintf(file, ", rtol = %s, atol = %s, integrator = %s (%s), order = %d\n",
            saltus_number(o->flow.rtol, a), saltus_number(o->flow.atol, b),
            saltus_integrator_word(o->flow.integrator), saltus_integrator_used(system, o->flow.integrator),
            o->flow.order);
}

static void put_result(const saltus_lyapunov *l, FILE *file) {
    char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX];
    bool known = isfinite(l->standard_errors[0]);
    if (isfinite(l->exponents[0]))
        fprintf(file, "# result: exponent = %s, standard_error = %s\n", saltus_number(l->exponents[0], a),
                known ? saltus_number(l->standard_errors[0], b) : "unknown");
    else
        fputs("# result: exponent = -infinity: every direction is lost for good\n", file);
    fprintf(file, "# measured: %lld periods, trajectories: %d, transient: %lld periods, T = %s\n", l->periods,
            l->members, l->transient, saltus_number(l->period, a));
    fputs("# time: measured by all trajectories together\n"
          "# exponent, standard_error: the estimate after that time, per unit of time\n"
          "time,exponent,standard_error\n",
          file);
}

void saltus_convergence_csv(const saltus_convergence *c, FILE *file) {
    const saltus_lyapunov *l = c->lyapunov;
    put_scene(c->scene, c->system, file);
    put_options(c->system, c->options, file);
    put_result(l, file);
    for (int k = 0; k < l->history_count && isfinite(l->exponents[0]); k++) {
        saltus_put_number(file, l->history[k].time);
        fputc(',', file);
        saltus_put_number(file, l->history[k].exponent);
        fputc(',', file);
        saltus_put_number(file, l->history[k].standard_error);
        fputc('\n', file);
    }
}
