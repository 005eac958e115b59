/* A record as comma-separated values.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/describe.h"
#include "io/record.h"

static void put_header(const saltus_source *source, FILE *file) {
    const saltus_system *system = source->system;
    const saltus_spec *spec = saltus_system_spec(system);
    const saltus_flow_options *o = source->options;
    char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX];
    fprintf(file, "# Saltus " SALTUS_VERSION " trajectory\n# scene: %s\n", source->scene->name);
    if (source->scene->title[0])
        fprintf(file, "# title: %s\n", source->scene->title);
    fprintf(file, "# model: %s\n# parameters: ", saltus_model_name(spec->model));
    saltus_put_parameters(file, spec);
    for (int s = 0; s < spec->stop_count; s++) {
        fprintf(file, "\n# stop %d: ", s + 1);
        saltus_put_stop(file, spec, s);
    }
    fprintf(file, "\n# options: rtol = %s, atol = %s, integrator = %s (%s), order = %d\n",
            saltus_number(o->rtol, a), saltus_number(o->atol, b), saltus_integrator_word(o->integrator),
            saltus_integrator_used(system, o->integrator), o->order);
    fprintf(file, "# time_over_T: time from the start of the recording in forcing periods T = %s\n",
            saltus_number(saltus_system_period(system), a));
    fputs("# displacement, velocity: observed coordinate and its rate (contact coordinate of the first stop; "
          "without "
          "a stop the pipe's midpoint or mass 1)\n"
          "# q1.., v1..: displacements of the modes or masses and their rates; z1..: further states\n"
          "# stop, side, event: an impact, stick or release, on the row just before it; the row just after "
          "an impact or "
          "a stick follows with the same time\n",
          file);
}

static void put_columns(const saltus_system *system, FILE *file) {
    fputs("time_over_T,displacement,velocity", file);
    for (int i = 1; i <= saltus_system_dof(system); i++)
        fprintf(file, ",q%d", i);
    for (int i = 1; i <= saltus_system_dof(system); i++)
        fprintf(file, ",v%d", i);
    for (int i = 1; i <= saltus_system_extra(system); i++)
        fprintf(file, ",z%d", i);
    fputs(",stop,side,event\n", file);
}

void saltus_record_csv(const saltus_source *source, FILE *file) {
    const saltus_record *r = source->record;
    long long event = 0;
    put_header(source, file);
    put_columns(source->system, file);
    for (long long row = 0; row < r->samples && !ferror(file); row++) {
        const double observed[] = {r->displacement[row], r->velocity[row]};
        saltus_put_number(file, r->time[row]);
        for (int i = 0; i < 2 + r->dimension; i++) {
            fputc(',', file);
            saltus_put_number(file, i < 2 ? observed[i] : r->states[row * r->dimension + i - 2]);
        }
        if (event < r->event_count && r->event_rows[event] == row) {
            saltus_face face = saltus_system_face(source->system, r->events[event].face);
            fprintf(file, ",%d,%s,%s\n", face.stop + 1, saltus_side_word(face.side),
                    saltus_event_word(r->events[event].kind));
            event++;
        } else
            fputs(",,,\n", file);
    }
}
