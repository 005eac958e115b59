/* What the tests share: cmocka, tolerances that print both numbers, systems in one call.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_CHECK_H
#define SALTUS_TESTS_CHECK_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "saltus/saltus.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define check_near(value, expected, tolerance) check_near_at(value, expected, tolerance, __FILE__, __LINE__)
#define check_ok(status, message) check_ok_at(status, message, __FILE__, __LINE__)

static inline void check_near_at(double value, double expected, double tolerance, const char *file,
                                 int line) {
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s:%d: %.17g should be %.17g, difference %.3g beyond %.3g", file, line, value, expected,
                 value - expected, tolerance);
}

static inline void check_ok_at(saltus_status status, const saltus_message *message, const char *file,
                               int line) {
    if (status != SALTUS_OK)
        fail_msg("%s:%d: %s: %s", file, line, saltus_status_name(status), message->text);
}

/* Long ways through code that shorter tests go through, too, are left out where everything is slow. */
static inline void skip_where_slow(void) {
    if (getenv("SALTUS_SANITIZED"))
        skip();
}

/* SALTUS_LONG_TESTS=1: more cases, and the longest ways. */
static inline bool long_version(void) {
    return getenv("SALTUS_LONG_TESTS") != NULL;
}

static inline void skip_unless_long(void) {
    if (!long_version())
        skip();
}

static inline void set_parameter(saltus_spec *spec, const char *name, double value) {
    int k = saltus_model_parameter_index(spec->model, name);
    assert_true(k >= 0);
    spec->parameters[k] = value;
}

static inline saltus_spec pipe_spec(double modes, double omega) {
    saltus_spec spec = saltus_spec_defaults(saltus_model_find("pipe"));
    set_parameter(&spec, "N", modes);
    set_parameter(&spec, "omega", omega);
    return spec;
}

static inline saltus_spec oscillator_spec(double c, double k, double force, double omega) {
    saltus_spec spec = saltus_spec_defaults(saltus_model_find("oscillator"));
    set_parameter(&spec, "c", c);
    set_parameter(&spec, "k", k);
    set_parameter(&spec, "F", force);
    set_parameter(&spec, "omega", omega);
    return spec;
}

static inline void add_stop(saltus_spec *spec, double d, double r, saltus_sides sides) {
    saltus_stop stop = saltus_stop_defaults();
    stop.d = d;
    stop.r = r;
    stop.sides = sides;
    spec->stops[spec->stop_count++] = stop;
}

static inline saltus_system *build(const saltus_spec *spec) {
    saltus_message message = {.text = ""};
    saltus_system *system = NULL;
    check_ok(saltus_system_new(spec, &system, &message), &message);
    return system;
}

/* A flow of one lane, started. */
static inline saltus_flow *open_flow(const saltus_system *system, const saltus_flow_options *options,
                                     double phase, const double *state) {
    saltus_message message = {.text = ""};
    saltus_flow *flow = NULL;
    check_ok(saltus_flow_new(&system, 1, options, &flow, &message), &message);
    check_ok(saltus_flow_start(flow, 0, (saltus_time){0, phase}, state, &message), &message);
    return flow;
}

static inline saltus_event advance(saltus_flow *flow, double periods, unsigned watch) {
    saltus_message message = {.text = ""};
    saltus_event event;
    double whole = floor(periods);
    check_ok(
        saltus_flow_advance(flow, (saltus_time){(long long)whole, periods - whole}, watch, &event, &message),
        &message);
    return event;
}

#endif
