/* The observed displacement: a displacement, a stop's coordinate, a place on a line, or a quantity of a text.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/state.h"
#include "system/system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *saltus_system_observed_name(const saltus_system *system) {
    return system->observer.name;
}

const char *saltus_system_observable_name(const saltus_system *system, int k) {
    const saltus_model *model = system->spec.model;
    return model->observable ? model->observable(model, k) : NULL;
}

int saltus_system_observable_count(const saltus_system *system) {
    int count = 0;
    while (saltus_system_observable_name(system, count))
        count++;
    return count;
}

int saltus_system_observable_index(const saltus_system *system, const char *name) {
    int k = saltus_system_observable_count(system) - 1;
    while (k >= 0 && strcmp(name, saltus_system_observable_name(system, k)) != 0)
        k--;
    return k;
}

void saltus_system_observe(const saltus_system *system, const double *state, double phase, double *values) {
    if (system->spec.model->observe)
        system->spec.model->observe(system, state, phase, values);
}

double saltus_system_observed_place(const saltus_system *system) {
    return system->observer.place;
}
const double *saltus_system_observer(const saltus_system *system) {
    return system->observer.row;
}
double saltus_system_observed(const saltus_system *system, const double *vector) {
    double sum = 0;
    for (int i = 0; i < system->dof; i++)
        sum = fma(system->observer.row[i], vector[i], sum);
    return sum;
}
bool saltus_system_stop_observed(const saltus_system *system, int stop) {
    return memcmp(system->stop_normal[stop], system->observer.row,
                  (size_t)system->dof * sizeof *system->observer.row) == 0;
}

static void observe_stop(saltus_system *system, int stop) {
    const saltus_spec *spec = &system->spec;
    system->observer.stop = stop;
    memcpy(system->observer.row, system->stop_normal[stop],
           (size_t)system->dof * sizeof *system->observer.row);
    system->observer.name = saltus_stop_text(spec, stop, SALTUS_STOP_COORDINATE);
    if (spec->model->notation.structure == SALTUS_STRUCTURE_LINE)
        system->observer.place = spec->stops[stop].xi;
}

static void observe_place(saltus_system *system, double xi) {
    double state[SALTUS_STATE_MAX] = {0};
    for (int i = 0; i < system->dof; i++) {
        state[i] = 1;
        system->observer.row[i] = saltus_system_shape(system, state, xi);
        state[i] = 0;
    }
    system->observer.place = xi;
}

/* Observe entry i of the state. In a built-in model of separate bodies the row itself implies the name. */
static void observe_entry(saltus_system *system, int i) {
    const saltus_model *model = system->spec.model;
    memset(system->observer.row, 0, (size_t)system->dof * sizeof *system->observer.row);
    system->observer.row[i] = 1;
    system->observer.entry = saltus_system_state_name(system, i);
    if (model->text || model->notation.structure == SALTUS_STRUCTURE_LINE)
        system->observer.name = system->observer.entry.text;
}

/* Choose by name: an observed quantity of a text, stop2, a displacement, or a place on a line. A name that is
 * none of these is refused with a list of what could be observed. */
static saltus_status observe_named(saltus_system *system, const char *name, saltus_message *message) {
    const saltus_model *model = system->spec.model;
    const saltus_fault fault = {.key = "observe"};
    char *end;
    int number;
    const int quantity = saltus_system_observable_index(system, name), stops = system->spec.stop_count;
    const bool line = model->notation.structure == SALTUS_STRUCTURE_LINE;
    if (quantity >= 0) {
        system->observer.name = name;
        system->observer.quantity = quantity;
        return model->observable_row(system, quantity, system->observer.row)
                   ? SALTUS_OK
                   : saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                                    "observe = %s: is no sum of displacements; choose one that is", name);
    }
    const int entry = saltus_system_state_index(system, name);
    const double xi = strtod(name, &end);
    if (saltus_key_numbered(name, "stop", &number) && number > 0 && number <= stops) {
        observe_stop(system, number - 1);
        return SALTUS_OK;
    }
    if (entry >= 0 && entry < system->dof) {
        observe_entry(system, entry);
        return SALTUS_OK;
    }
    if (line && *end == '\0' && xi > 0 && xi < 1) {
        observe_place(system, xi);
        return SALTUS_OK;
    }
    char names[SALTUS_NAMES_MAX], stop[48] = "", observed[200] = "";
    if (stops)
        snprintf(stop, sizeof stop, ", stops (%s%d)", stops > 1 ? "stop1 to stop" : "stop", stops);
    const int quantities = saltus_system_observable_count(system);
    for (int k = 0; k < quantities; k++) {
        const size_t used = strlen(observed);
        snprintf(observed + used, sizeof observed - used, "%s%s", k ? ", " : ", quantities of the scene (",
                 saltus_system_observable_name(system, k));
    }
    return saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                          "observe = %s: must be one of the displacements (%s)%s%s%s%s", name,
                          saltus_system_list_names(system, system->dof, names), stop, observed,
                          quantities ? ")" : "", line ? ", places on the line (0 < xi < 1)" : "");
}

saltus_status saltus_observer_choose(saltus_system *system, saltus_message *message) {
    const saltus_model *model = system->spec.model;
    saltus_observer *o = &system->observer;
    saltus_status status = SALTUS_OK;
    o->stop = o->quantity = -1;
    o->place = NAN;
    if (system->spec.observe[0])
        status = observe_named(system, system->spec.observe, message);
    else if (saltus_system_observable_count(system) > 0 && model->observable_row(system, 0, o->row)) {
        o->name = saltus_system_observable_name(system, 0);
        o->quantity = 0;
    } else if (system->spec.stop_count > 0)
        observe_stop(system, 0);
    else if (model->notation.structure == SALTUS_STRUCTURE_LINE)
        observe_place(system, 0.5);
    else if (system->dof > 0)
        observe_entry(system, 0);
    while (o->first < system->spec.stop_count && !saltus_system_stop_observed(system, o->first))
        o->first++;
    return status;
}
