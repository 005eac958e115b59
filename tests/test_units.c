/* One motion in other units of length, time and mass, powers of two: only the units change, to the last bit,
 * with either integrator. No threshold may depend on the size of numbers in a unit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes.h"

typedef struct units {
    double length, time, mass;
} units;

static const units others[] = {{0x1p-30, 1, 1}, {0x1p24, 1, 1},           {1, 0x1p-12, 1},
                               {1, 0x1p10, 1},  {1, 1, 0x1p-18},          {1, 1, 0x1p12},
                               {0x1p-43, 1, 1}, {0x1p9, 0x1p-7, 0x1p-13}, {0x1p-11, 0x1p5, 0x1p6}};
enum { other_count = sizeof others / sizeof others[0], events_max = 25 };

static void scale_parameter(saltus_spec *spec, const char *name, double unit) {
    set_parameter(spec, name, unit * saltus_spec_get(spec, name));
}

/* An oscillator's scene in other units. */
static scene in_units(scene s, const units *u) {
    static const char *const masses[] = {"m", "m2"}, *const dampers[] = {"c", "c2"},
                             *const springs[] = {"k", "k2", "kz"}, *const loads[] = {"F", "F0", "F2", "F02"};
    const double speed = u->length / u->time, spring = u->mass / (u->time * u->time);
    for (int k = 0; k < 2; k++) {
        scale_parameter(&s.spec, masses[k], u->mass);
        scale_parameter(&s.spec, dampers[k], u->mass / u->time);
    }
    for (int k = 0; k < 3; k++)
        scale_parameter(&s.spec, springs[k], spring);
    for (int k = 0; k < 4; k++)
        scale_parameter(&s.spec, loads[k], spring * u->length);
    scale_parameter(&s.spec, "tz", u->time);
    scale_parameter(&s.spec, "omega", 1 / u->time);
    for (int k = 0; k < s.spec.stop_count; k++)
        s.spec.stops[k].d *= u->length;
    const int n = (int)saltus_spec_get(&s.spec, "N");
    for (int i = 0; i < n; i++) {
        s.state[i] *= u->length;
        s.state[n + i] *= speed;
    }
    s.state[2 * n] *= spring * u->length;
    return s;
}

/* The unit of a component of the state. */
static double unit_of(const units *u, int dof, int i) {
    return i < dof       ? u->length
           : i < 2 * dof ? u->length / u->time
                         : u->mass * u->length / (u->time * u->time);
}

/* How much two numbers may differ, in the first unit. */
static double slack;

/* In another unit of length or mass: not at all. By rounding in one of time, on which steps depend by a root,
 * in one of mass if a force is part of the state, and with the stiff integrator, which finds its linear part
 * by differences. */
static double slack_of(scene s, const units *u, bool stiff) {
    const bool force = saltus_spec_get(&s.spec, "kz") > 0;
    return stiff || u->time != 1 || (u->mass != 1 && force) ? 1e-9 : 0;
}

static void same_time(saltus_time a, saltus_time b) {
    const double apart = (double)(b.cycle - a.cycle) + (b.phase - a.phase);
    if (!(fabs(apart) <= slack))
        fail_msg("%lld + %.17g periods in one unit, %lld + %.17g in the other", a.cycle, a.phase, b.cycle,
                 b.phase);
}

static void same_number(double one, double other, double unit) {
    if (!(fabs(other / unit - one) <= slack * (1 + fabs(one))) && other != unit * one)
        fail_msg("%.17g times %g is not %.17g", one, unit, other);
}

/* States, tangent vectors and contact forces of two flows. */
static void same_place(saltus_flow *const flow[2], const units *u, int dof, int n, int columns) {
    double state[2][scene_dimension_max], tangents[2][scene_dimension_max * scene_columns_max],
        forces[2][SALTUS_FACES_MAX] = {{0}};
    for (int k = 0; k < 2; k++) {
        saltus_flow_state(flow[k], 0, state[k]);
        saltus_flow_tangents(flow[k], 0, tangents[k]);
        saltus_flow_forces(flow[k], 0, forces[k]);
    }
    same_time(saltus_flow_time(flow[0], 0), saltus_flow_time(flow[1], 0));
    for (int i = 0; i < n; i++)
        same_number(state[0][i], state[1][i], unit_of(u, dof, i));
    for (int c = 0; c < columns; c++)
        for (int i = 0; i < n; i++)
            same_number(tangents[0][c * n + i], tangents[1][c * n + i],
                        unit_of(u, dof, i) / unit_of(u, dof, c));
    assert_int_equal(saltus_flow_contacts(flow[0], 0), saltus_flow_contacts(flow[1], 0));
    for (int f = 0; f < saltus_system_face_count(saltus_flow_system(flow[0], 0)); f++)
        same_number(forces[0][f], forces[1][f], u->mass * u->length / (u->time * u->time));
}

/* Events and states along the way. */
static void same_events(saltus_flow *const flow[2], const units *u, int dof, int n, int columns) {
    const double speed = u->length / u->time;
    for (int k = 0; k < events_max; k++) {
        saltus_event e[2];
        for (int j = 0; j < 2; j++)
            e[j] = advance(flow[j], 6, SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING);
        same_time(e[0].time, e[1].time);
        assert_int_equal(e[0].kind, e[1].kind);
        same_place(flow, u, dof, n, columns);
        if (e[0].kind == SALTUS_REACHED)
            break;
        assert_int_equal(e[0].face, e[1].face);
        same_number(e[0].displacement, e[1].displacement, u->length);
        if (e[0].kind == SALTUS_TURNING)
            same_number(e[0].velocity_before, e[1].velocity_before, speed / u->time);
        else
            same_number(e[0].velocity_before, e[1].velocity_before, speed);
    }
    const saltus_flow_info one = saltus_flow_information(flow[0], 0),
                           other = saltus_flow_information(flow[1], 0);
    assert_true(slack > 0 || (one.steps == other.steps && one.field_evaluations == other.field_evaluations));
}

static void events_are_the_same_in_any_units(void **unused) {
    (void)unused;
    for (int name = scene_two_sided_mass; name < scenes; name++)
        for (int k = 0; k < other_count + 2; k++) { /* all with one integrator, the last two with the other */
            const bool stiff = k >= other_count;
            const units *u = &others[stiff ? k - 2 : k];
            saltus_flow_options options = saltus_flow_defaults();
            saltus_system *system[2];
            saltus_flow *flow[2];
            options.atol = 0;
            options.integrator = stiff ? SALTUS_RADAU : SALTUS_TAYLOR;
            slack = slack_of(scene_of((scene_name)name), u, stiff);
            for (int j = 0; j < 2; j++) {
                scene s = scene_of((scene_name)name);
                if (j)
                    s = in_units(s, u);
                system[j] = build(&s.spec);
                options.columns = saltus_system_dimension(system[j]);
                flow[j] = open_flow(system[j], &options, s.phase, s.state);
            }
            same_events(flow, u, saltus_system_dof(system[0]), options.columns, options.columns);
            for (int j = 0; j < 2; j++) {
                saltus_flow_free(flow[j]);
                saltus_system_free(system[j]);
            }
        }
}

/* A coast through no event, in several pieces: the largest gap of each face and its time. */
static void coasts_are_the_same_in_any_units(void **unused) {
    (void)unused;
    for (int name = scene_two_sided_mass; name < scenes; name++)
        for (int k = 0; k < other_count + 2; k++) {
            const bool stiff = k >= other_count;
            const units *u = &others[stiff ? k - 2 : k];
            saltus_flow_options options = saltus_flow_defaults();
            saltus_extreme extremes[2][SALTUS_FACES_MAX];
            saltus_message message = {.text = ""};
            int faces = 0;
            options.atol = 0;
            options.integrator = stiff ? SALTUS_RADAU : SALTUS_TAYLOR;
            slack = slack_of(scene_of((scene_name)name), u, stiff);
            for (int piece = 1; piece <= 16; piece += 5) {
                for (int j = 0; j < 2; j++) {
                    scene s = scene_of((scene_name)name);
                    if (j)
                        s = in_units(s, u);
                    saltus_system *system = build(&s.spec);
                    saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
                    faces = saltus_system_face_count(system);
                    for (int f = 0; f < faces; f++)
                        extremes[j][f] = (saltus_extreme){.value = -INFINITY, .inner = -INFINITY};
                    check_ok(saltus_flow_coast(flow, 0,
                                               (saltus_time){(piece + 4) / 12, (piece + 4) % 12 / 12.0},
                                               extremes[j], &message),
                             &message);
                    saltus_flow_free(flow);
                    saltus_system_free(system);
                }
                for (int f = 0; f < faces; f++) {
                    same_number(extremes[0][f].value, extremes[1][f].value, u->length);
                    same_number(extremes[0][f].inner, extremes[1][f].inner, u->length);
                    if (extremes[0][f].value > -INFINITY)
                        same_time(extremes[0][f].time, extremes[1][f].time);
                    if (extremes[0][f].inner > -INFINITY)
                        same_time(extremes[0][f].inner_time, extremes[1][f].inner_time);
                }
            }
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(events_are_the_same_in_any_units),
        cmocka_unit_test(coasts_are_the_same_in_any_units),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
