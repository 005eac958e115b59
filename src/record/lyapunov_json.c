/* Lyapunov exponents as one JSON object.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/json.h"
#include "record/lyapunov_words.h"

#include <math.h>

static void put_truth(FILE *file, const char *key, bool value) {
    saltus_json_key(file, key);
    fputs(value ? "true" : "false", file);
}

static void put_options(FILE *file, const saltus_lyapunov_options *o) {
    saltus_json_key(file, "options");
    fprintf(file, "{\"transient\": %lld, \"periods\": %lld, \"members\": %d, \"seed\": %lu", o->transient,
            o->periods, o->members, o->seed);
    saltus_json_member(file, "precision", o->precision);
    saltus_json_member(file, "interval", o->interval);
    saltus_json_member(file, "rtol", o->flow.rtol);
    saltus_json_member(file, "atol", o->flow.atol);
    saltus_json_text(file, "integrator", saltus_integrator_word(o->flow.integrator));
    fputc('}', file);
}

static void put_exponents(FILE *file, const saltus_lyapunov *l) {
    bool finite = isfinite(l->exponents[0]);
    saltus_json_member(file, "largest", l->exponents[0]);
    saltus_json_member(file, "standard_error", finite ? l->standard_errors[0] : NAN);
    saltus_json_text(file, "sign", saltus_sense_word(saltus_lyapunov_sense(l)));
    saltus_json_list(file, "exponents", l->exponents, l->count);
    /* null for the exponents that have none because they are -infinity */
    saltus_json_key(file, "standard_errors");
    for (int k = 0; k < l->count; k++) {
        fputs(k ? ", " : "[", file);
        saltus_json_value(file, isfinite(l->exponents[k]) ? l->standard_errors[k] : NAN);
    }
    fputc(']', file);
    fprintf(file, ", \"dimension\": %d, \"lost\": %d", l->dimension, l->lost);
    saltus_json_member(file, "sum", l->sum);
    saltus_json_member(file, "sum_rule", l->sum_rule);
    saltus_json_member(file, "kaplan_yorke", l->kaplan_yorke);
}

void saltus_write_lyapunov_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                const saltus_lyapunov_options *options, const saltus_lyapunov *l) {
    fputs("{\"version\": \"" SALTUS_VERSION "\"", file);
    saltus_json_text(file, "scene", scene->name);
    put_exponents(file, l);
    saltus_json_member(file, "impacts_per_period", l->impacts_per_period);
    saltus_json_member(file, "sticks_per_period", l->sticks_per_period);
    saltus_json_member(file, "period", l->period);
    saltus_json_member(file, "time", l->time);
    fprintf(file, ", \"periods\": %lld, \"transient\": %lld", l->periods, l->transient);
    saltus_json_list(file, "halves", l->half, 2);
    saltus_json_list(file, "half_errors", l->half_errors, 2);
    saltus_json_member(file, "independent", l->independent);
    fprintf(file, ", \"members\": %d", l->members);
    saltus_json_list(file, "member_exponents", l->member_exponents, l->members);
    put_truth(file, "agree", l->agree);
    put_truth(file, "precise", l->precise);
    saltus_json_list(file, "state", l->state, l->dimension);
    put_options(file, options);
    saltus_json_parameters(file, saltus_system_spec(system));
    saltus_json_text(file, "integrator", saltus_integrator_used(system, options->flow.integrator));
    fputs("}\n", file);
}
