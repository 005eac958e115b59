/* What the columns of a branch file are called, what they mean and where their values are.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/branch_columns.h"

#include "record/describe.h"

#include <stddef.h>
#include <string.h>

#define REAL SALTUS_ELEMENT_REAL
#define INT SALTUS_ELEMENT_INT
#define ONE SALTUS_WIDTH_ONE
#define POINT(member) offsetof(saltus_point_row, point.member), false
#define ROW(member) offsetof(saltus_point_row, member), true

const saltus_branch_column saltus_point_columns[SALTUS_POINT_COLUMNS] = {
    {"kind", "1", "regular, or the label of a special point", SALTUS_ELEMENT_POINT, ONE, POINT(kind)},
    {"branch", "1", "number of the branch: 0 up from the start, 1 down, 2 ... switched to", INT, ONE,
     POINT(branch)},
    {"parent", "1", "the branch that a switched one left, otherwise -1", INT, ONE, POINT(parent)},
    {"step", "1", "counted along the branch", INT, ONE, POINT(step)},
    {"arclength", "1", "along the branch", REAL, ONE, POINT(arclength)},
    {"value", "1", "continued parameters key1, key2 (NaN without a second one)", REAL, SALTUS_WIDTH_TWO,
     POINT(value)},
    {"heading", "1", "change of value[0] with arclength", REAL, ONE, POINT(heading)},
    {"parameters", "1", "all parameters, in the order of the attribute names", REAL, SALTUS_WIDTH_PARAMETERS,
     POINT(spec.parameters)},
    {"stops", "1", "xi, weight1, weight2, d, r of each stop", REAL, SALTUS_WIDTH_STOPS,
     offsetof(saltus_point_row, stops), false},
    {"periods", "1", "p, forcing periods of one orbit", INT, ONE, POINT(periods)},
    {"impacts", "1", "n, impacts of one orbit; -1 with complete chatter", SALTUS_ELEMENT_LONG, ONE,
     POINT(impacts)},
    {"sticking_intervals", "1", "of one orbit", INT, ONE, POINT(sticking_intervals)},
    {"motion", "1", "name of the motion, n/p", SALTUS_ELEMENT_LABEL, ONE, POINT(label)},
    {"motion_after", "1", "name beyond the point, where it changes", SALTUS_ELEMENT_LABEL, ONE,
     POINT(label_after)},
    {"reason", "1", "why the branch ends, or what changes", SALTUS_ELEMENT_REASON, ONE, POINT(reason)},
    {"state", "1", "q, q', further states at phase 0", REAL, SALTUS_WIDTH_STATE,
     offsetof(saltus_point_row, point.state), true},
    {"multipliers", "1", "real and imaginary part, by decreasing modulus", REAL, SALTUS_WIDTH_MULTIPLIERS,
     ROW(multipliers)},
    {"log_moduli", "1", "natural logarithms of their moduli; -inf: exactly zero, NaN: not resolved", REAL,
     SALTUS_WIDTH_STATE, ROW(log_moduli)},
    {"unstable", "1", "multipliers not inside the unit circle", INT, ONE, POINT(unstable)},
    {"stable", "1", "whether all are inside", SALTUS_ELEMENT_FLAG, ONE, POINT(stable)},
    {"admissible", "1", "whether the flow with its events closes on the orbit", SALTUS_ELEMENT_FLAG, ONE,
     POINT(admissible)},
    {"residual", "1", "scaled, at the last evaluation; a Newton step from there ends in rounding", REAL, ONE,
     POINT(residual)},
    {"iterations", "1", "Newton steps", INT, ONE, POINT(iterations)},
    {"log_volume", "1", "sum of the log moduli", REAL, ONE, POINT(log_volume)},
    {"sum_rule", "1", "what the trace of the Jacobian and the restitutions make it", REAL, ONE,
     POINT(sum_rule)},
    {"accuracy", "1", "special points: bound on the error of value[0]", REAL, ONE, POINT(accuracy)},
    {"grazing_time", "T", "GR: time of the touch from phase 0; NaN where none is known", REAL, ONE,
     POINT(grazing_time)},
    {"grazing_stop", "1", "GR: number of the stop that is touched, from 1; 0: none", INT, ONE,
     POINT(grazing_stop)},
    {"grazing_side", "1", "GR: its side, +1 upper, -1 lower; 0: none", INT, ONE, POINT(grazing_side)},
    {"contact_force", "1",
     "held: smallest contact force over the orbit (pipe: per modal mass); NaN elsewhere", REAL, ONE,
     POINT(contact_force)},
    {"event_first", "1", "the orbit's first row of /events, from 0", SALTUS_ELEMENT_LONG, ONE,
     offsetof(saltus_point_row, event_first), false},
    {"event_count", "1", "number of its rows", INT, ONE, POINT(event_count)},
};

#define EVENT(member) offsetof(saltus_event_row, member), false

const saltus_branch_column saltus_event_columns[SALTUS_EVENT_COLUMNS] = {
    {"kind", "1", "impact, stick or release", SALTUS_ELEMENT_EVENT, ONE, EVENT(kind)},
    {"stop", "1", "number of the stop, from 1", INT, ONE, EVENT(stop)},
    {"side", "1", "+1 upper, -1 lower", INT, ONE, EVENT(side)},
    {"time", "T", "time from phase 0; a stick: where the impacts accumulate", REAL, ONE, EVENT(time)},
    {"phase", "T", "of the forcing, in [0, 1)", REAL, ONE, EVENT(phase)},
    {"velocity_before", "1", "normal velocity n.q' just before", REAL, ONE, EVENT(velocity_before)},
    {"velocity_after", "1", "normal velocity n.q' just after", REAL, ONE, EVENT(velocity_after)},
    {"displacement", "1", "of the contact coordinate", REAL, ONE, EVENT(displacement)},
};

#define OPTION(member) offsetof(saltus_branch_options, member)

const saltus_branch_setting saltus_branch_settings[SALTUS_BRANCH_SETTINGS] = {
    {"key1", SALTUS_SETTING_KEY, OPTION(key[0])},
    {"low1", SALTUS_SETTING_REAL, OPTION(low[0])},
    {"high1", SALTUS_SETTING_REAL, OPTION(high[0])},
    {"key2", SALTUS_SETTING_KEY, OPTION(key[1])},
    {"low2", SALTUS_SETTING_REAL, OPTION(low[1])},
    {"high2", SALTUS_SETTING_REAL, OPTION(high[1])},
    {"step", SALTUS_SETTING_REAL, OPTION(step)},
    {"step_max", SALTUS_SETTING_REAL, OPTION(step_max)},
    {"points", SALTUS_SETTING_INT, OPTION(points)},
    {"direction", SALTUS_SETTING_INT, OPTION(direction)},
    {"switches", SALTUS_SETTING_INT, OPTION(switches)},
    {"rtol", SALTUS_SETTING_REAL, OPTION(orbit.flow.rtol)},
    {"atol", SALTUS_SETTING_REAL, OPTION(orbit.flow.atol)},
    {"integrator", SALTUS_SETTING_INT, OPTION(orbit.flow.integrator)},
    {"order", SALTUS_SETTING_INT, OPTION(orbit.flow.order)},
    {"section_phase", SALTUS_SETTING_REAL, OPTION(orbit.phase)},
    {"iterations", SALTUS_SETTING_INT, OPTION(orbit.iterations)},
    {"tolerance", SALTUS_SETTING_REAL, OPTION(orbit.tolerance)},
    {"segments", SALTUS_SETTING_INT, OPTION(orbit.segments)},
};

void saltus_column_widths(const saltus_branch_column *column, saltus_branch_shape shape, int width[2]) {
    static const int second[] = {[SALTUS_WIDTH_MULTIPLIERS] = 2, [SALTUS_WIDTH_STOPS] = SALTUS_STOP_VALUES};
    const int first[] = {[SALTUS_WIDTH_ONE] = 0,
                         [SALTUS_WIDTH_TWO] = 2,
                         [SALTUS_WIDTH_STATE] = shape.dimension,
                         [SALTUS_WIDTH_MULTIPLIERS] = shape.dimension,
                         [SALTUS_WIDTH_PARAMETERS] = shape.parameters,
                         [SALTUS_WIDTH_STOPS] = shape.stops};
    width[0] = first[column->width];
    width[1] = second[column->width];
}

static size_t entry_bytes(saltus_element element) {
    switch (element) {
    case SALTUS_ELEMENT_REAL:
        return sizeof(double);
    case SALTUS_ELEMENT_INT:
        return sizeof(int);
    case SALTUS_ELEMENT_LONG:
        return sizeof(long long);
    case SALTUS_ELEMENT_FLAG:
        return sizeof(bool);
    case SALTUS_ELEMENT_POINT:
        return sizeof(saltus_point_kind);
    case SALTUS_ELEMENT_EVENT:
        return sizeof(saltus_event_kind);
    case SALTUS_ELEMENT_LABEL:
        return SALTUS_LABEL_MAX;
    case SALTUS_ELEMENT_REASON:
        return SALTUS_REASON_MAX;
    }
    return 0;
}

size_t saltus_column_bytes(const saltus_branch_column *column, saltus_branch_shape shape) {
    int width[2];
    saltus_column_widths(column, shape, width);
    return entry_bytes(column->element) * (size_t)(width[0] ? width[0] : 1) *
           (size_t)(width[1] ? width[1] : 1);
}

static hid_t text_type(saltus_h5 *w, size_t room) {
    hid_t type = H5Tcopy(H5T_C_S1);
    saltus_h5_note(w, type >= 0 && H5Tset_size(type, room) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
    return type;
}

static hid_t point_type(saltus_h5 *w, hid_t base) {
    const char *words[SALTUS_POINT_KINDS];
    for (int k = 0; k < SALTUS_POINT_KINDS; k++)
        words[k] = k == SALTUS_POINT_REGULAR ? "regular" : saltus_point_word((saltus_point_kind)k);
    return saltus_h5_enumeration(w, base, words, NULL, SALTUS_POINT_KINDS);
}

static hid_t event_type(saltus_h5 *w, hid_t base) {
    static const int kinds[] = {SALTUS_IMPACT, SALTUS_STICK, SALTUS_RELEASE};
    const char *words[3];
    for (int k = 0; k < 3; k++)
        words[k] = saltus_event_word((saltus_event_kind)kinds[k]);
    return saltus_h5_enumeration(w, base, words, kinds, 3);
}

hid_t saltus_column_type(saltus_h5 *w, const saltus_branch_column *column, bool stored) {
    static const char *const flags[] = {"FALSE", "TRUE"};
    hid_t whole = stored ? H5T_STD_I32LE : H5T_NATIVE_INT;
    switch (column->element) {
    case SALTUS_ELEMENT_REAL:
        return H5Tcopy(stored ? H5T_IEEE_F64LE : H5T_NATIVE_DOUBLE);
    case SALTUS_ELEMENT_INT:
        return H5Tcopy(whole);
    case SALTUS_ELEMENT_LONG:
        return H5Tcopy(stored ? H5T_STD_I64LE : H5T_NATIVE_LLONG);
    case SALTUS_ELEMENT_FLAG:
        return saltus_h5_enumeration(w, H5T_NATIVE_SCHAR, flags, NULL, 2);
    case SALTUS_ELEMENT_POINT:
        return point_type(w, H5T_NATIVE_INT);
    case SALTUS_ELEMENT_EVENT:
        return event_type(w, H5T_NATIVE_INT);
    case SALTUS_ELEMENT_LABEL:
    case SALTUS_ELEMENT_REASON:
        return stored ? text_type(w, entry_bytes(column->element))
                      : saltus_h5_text_memory(entry_bytes(column->element));
    }
    return -1;
}

void *saltus_column_values(const saltus_branch_column *column, void *row) {
    unsigned char *place = (unsigned char *)row + column->offset;
    if (!column->indirect)
        return place;
    void *values;
    memcpy(&values, place, sizeof values);
    return values;
}

void saltus_stop_values(const saltus_stop *stop, double values[SALTUS_STOP_VALUES]) {
    values[0] = stop->xi;
    values[1] = stop->weight[0];
    values[2] = stop->weight[1];
    values[3] = stop->d;
    values[4] = stop->r;
}

void saltus_stop_from_values(const double values[SALTUS_STOP_VALUES], saltus_stop *stop) {
    stop->xi = values[0];
    stop->weight[0] = values[1];
    stop->weight[1] = values[2];
    stop->d = values[3];
    stop->r = values[4];
}
