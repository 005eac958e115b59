/* Lyapunov exponents as one JSON object.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/options.h"
#include "record/fields.h"
#include "record/json.h"
#include "record/lyapunov_words.h"

#include <math.h>
#include <string.h>

/* All options but the order of the series and the number of exponents, which the result tells. */
static void put_options(FILE *file, const saltus_lyapunov_options *o) {
    saltus_json_key(file, "options");
    for (int k = 0; k < saltus_lyapunov_table.count; k++) {
        const saltus_field *field = &saltus_lyapunov_table.options[k].field;
        const saltus_field_table one = {field, 1};
        if (strcmp(field->name, "order") != 0 && strcmp(field->name, "exponents") != 0)
            saltus_json_fields(file, k ? ", " : "{", &one, NULL, o);
    }
    fputc('}', file);
}

static void put_exponents(FILE *file, const saltus_lyapunov *l) {
    bool finite = isfinite(l->exponents[0]);
    saltus_json_member(file, "largest", l->exponents[0]);
    saltus_json_member(file, "standard_error", finite ? l->standard_errors[0] : NAN);
    saltus_json_text(file, "sign", saltus_sense_word(saltus_lyapunov_sense(l)));
    saltus_json_list(file, "exponents", l->exponents, l->count);
    /* null for the exponents that have none because they are -infinity */
    double errors[SALTUS_STATE_MAX];
    for (int k = 0; k < l->count; k++)
        errors[k] = isfinite(l->exponents[k]) ? l->standard_errors[k] : NAN;
    saltus_json_list(file, "standard_errors", errors, l->count);
}

void saltus_write_lyapunov_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                const saltus_lyapunov_options *options, const saltus_lyapunov *l) {
    fputs("{\"version\": \"" SALTUS_VERSION "\"", file);
    saltus_json_text(file, "scene", scene->name);
    put_exponents(file, l);
    saltus_json_fields(file, ", ", &saltus_exponent_fields, (const int[]){l->dimension, l->members}, l);
    put_options(file, options);
    saltus_json_parameters(file, saltus_system_spec(system));
    saltus_json_text(file, "integrator", saltus_integrator_used(system, options->flow.integrator));
    fputs("}\n", file);
}
