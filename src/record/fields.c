/* Names, units, meanings and locations of all values in each kind of result.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/fields.h"

#include "branch/point.h"
#include "motion/motion.h"
#include "record/describe.h"

#include <math.h>
#include <stddef.h>

/* Lengths of rows that are known only at run time. */
enum {
    OF_DIMENSION = -1 - SALTUS_COUNT_DIMENSION,
    OF_PARAMETERS = -1 - SALTUS_COUNT_PARAMETERS,
    OF_STOPS = -1 - SALTUS_COUNT_STOPS,
    OF_OBSERVED = -1 - SALTUS_COUNT_OBSERVED
};

#define POINT(member, unit, meaning, ...)                                                                    \
    SALTUS_MEMBER(saltus_point_row, point.member, #member, unit, meaning, __VA_ARGS__)
#define POINT_AS(name, member, unit, meaning, ...)                                                           \
    SALTUS_MEMBER(saltus_point_row, point.member, name, unit, meaning, __VA_ARGS__)

/* xi, weight[2], d and r of a stop are stored as five consecutive numbers. */
_Static_assert(offsetof(saltus_stop, r) == 4 * sizeof(double), "a stop begins with five numbers");

static const saltus_field point_fields[] = {
    POINT(kind, "1", "regular, or the label of a special point", SALTUS_CHOICE, .words = saltus_point_words),
    POINT(branch, "1", "number of the branch: 0 up from the start, 1 down, 2 ... switched to", SALTUS_INT),
    POINT(parent, "1", "the branch that a switched one left, otherwise -1", SALTUS_INT),
    POINT(step, "1", "counted along the branch", SALTUS_INT),
    POINT(locus, "1", "loci: what this curve is of, LP, PD, NS, BP, GR, HB or BE; otherwise regular",
          SALTUS_CHOICE, .words = saltus_point_words),
    POINT(arclength, "1", "along the branch", SALTUS_REAL),
    POINT(value, "1", "continued parameters key1, key2 (NaN without a second one)", SALTUS_REAL, 2),
    POINT(heading, "1", "change of value[0] with arclength", SALTUS_REAL),
    POINT_AS("parameters", spec.parameters, "1", "all parameters, in the order of the attribute names",
             SALTUS_REAL, OF_PARAMETERS),
    POINT_AS("stops", spec.stops, "1", "xi, weight1, weight2, d, r of each stop", SALTUS_REAL, OF_STOPS, 5,
             .stride = sizeof(saltus_stop)),
    POINT(periods, "1",
          "p, forcing periods of one orbit; without forcing its returns to the section; 0: equilibrium",
          SALTUS_INT),
    POINT(period, "1", "of one orbit, in units of time; HB: of the cycles born there; otherwise NaN",
          SALTUS_REAL),
    POINT(impacts, "1", "n, impacts of one orbit; -1 with complete chatter", SALTUS_LONG),
    POINT(sticking_intervals, "1", "of one orbit", SALTUS_INT),
    POINT_AS("motion", label, "1", "name of the motion, n/p", SALTUS_TEXT, SALTUS_LABEL_MAX),
    POINT_AS("motion_after", label_after, "1", "name beyond the point, where it changes", SALTUS_TEXT,
             SALTUS_LABEL_MAX),
    POINT(reason, "1", "why the branch ends, or what changes", SALTUS_TEXT, SALTUS_REASON_MAX),
    POINT(state, "1", "q, q', further states at phase 0", SALTUS_REAL, OF_DIMENSION, .indirect = true),
    POINT(multipliers, "1",
          "real and imaginary part, by decreasing modulus; of equilibria (periods 0) eigenvalues, by "
          "decreasing real part",
          SALTUS_REAL, OF_DIMENSION, 2, .indirect = true, .stride = sizeof(saltus_multiplier)),
    POINT_AS("log_moduli", multipliers, "1",
             "natural logarithms of their moduli; -inf: exactly zero, NaN: not known; of equilibria the "
             "real parts",
             SALTUS_REAL, OF_DIMENSION, .indirect = true, .inner = offsetof(saltus_multiplier, log_modulus),
             .stride = sizeof(saltus_multiplier)),
    POINT(trivial_multiplier, "1", "without forcing: along the flow, none of the others; otherwise 0",
          SALTUS_REAL),
    POINT(lyapunov_coefficient, "1",
          "HB of equilibria: the first one in Kuznetsov's normalisation; negative: stable cycles are born",
          SALTUS_REAL),
    POINT(unstable, "1",
          "multipliers not inside the unit circle, -1: not known; eigenvalues with a positive real part; at "
          "LP, PD, NS, BP, HB without those that are critical",
          SALTUS_INT),
    POINT(stable, "1", "whether there are none, nor any in between", SALTUS_FLAG),
    POINT(admissible, "1", "whether the flow with its events closes on the orbit", SALTUS_FLAG),
    POINT(residual, "1", "scaled, at the last evaluation; a Newton step from there ends in rounding",
          SALTUS_REAL),
    POINT(iterations, "1", "Newton steps", SALTUS_INT),
    POINT(log_volume, "1", "sum of the log moduli", SALTUS_REAL),
    POINT(sum_rule, "1", "what the trace of the Jacobian and the restitutions make it", SALTUS_REAL),
    POINT(accuracy, "1", "special points: bound on the error of value[0]", SALTUS_REAL),
    POINT(grazing_time, "T", "GR: time of the touch from phase 0; NaN where none is known", SALTUS_REAL),
    POINT(grazing_stop, "1", "GR, BE: number of the stop that is touched, from 1; 0: none", SALTUS_INT),
    POINT(grazing_side, "1", "GR, BE: its side, +1 upper, -1 lower; 0: none", SALTUS_INT),
    POINT(contact_force, "1",
          "held: smallest contact force over the orbit (pipe: per modal mass); NaN elsewhere", SALTUS_REAL),
    SALTUS_MEMBER(saltus_point_row, event_first, "event_first", "1",
                  "the orbit's first row of /events, from 0", SALTUS_LONG),
    POINT(event_count, "1", "number of its rows", SALTUS_INT),
};
const saltus_field_table saltus_point_fields = SALTUS_TABLE(point_fields);

#define EVENT(member, unit, meaning, ...)                                                                    \
    SALTUS_MEMBER(saltus_event_row, member, #member, unit, meaning, __VA_ARGS__)

static const saltus_field event_fields[] = {
    EVENT(kind, "1", "impact, stick or release", SALTUS_CHOICE,
          .words = saltus_event_words + SALTUS_CONTACT_EVENTS),
    EVENT(stop, "1", "number of the stop, from 1", SALTUS_INT),
    EVENT(side, "1", "+1 upper, -1 lower", SALTUS_INT),
    EVENT(time, "T", "time from phase 0; a stick: where the impacts accumulate", SALTUS_REAL),
    EVENT(phase, "T", "of the forcing, in [0, 1)", SALTUS_REAL),
    EVENT(velocity_before, "1", "normal velocity n.q' just before", SALTUS_REAL),
    EVENT(velocity_after, "1", "normal velocity n.q' just after", SALTUS_REAL),
    EVENT(displacement, "1", "of the contact coordinate", SALTUS_REAL),
    EVENT(row, "1", "row of /trajectory just before the event, from 0", SALTUS_LONG),
};
const saltus_field_table saltus_trajectory_event_fields = SALTUS_TABLE(event_fields);
const saltus_field_table saltus_event_fields = {event_fields, sizeof event_fields / sizeof *event_fields - 1};

int saltus_face_of(const saltus_system *system, int stop, int side) {
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        if (face.stop + 1 == stop && face.side == side)
            return f;
    }
    return -1;
}

saltus_event_row saltus_event_row_of(const saltus_system *system, const saltus_event *event) {
    saltus_face face = saltus_system_face(system, event->face);
    return (saltus_event_row){.kind = event->kind,
                              .stop = face.stop + 1,
                              .side = face.side,
                              .time = saltus_time_periods(event->time),
                              .phase = event->time.phase,
                              .velocity_before = event->velocity_before,
                              .velocity_after = event->velocity_after,
                              .displacement = event->displacement};
}

bool saltus_event_of_row(const saltus_system *system, const saltus_event_row *row, saltus_event *event) {
    int face = saltus_face_of(system, row->stop, row->side);
    if (face < 0 || !(fabs(row->time) < 1e15) || !(row->phase >= 0 && row->phase < 1))
        return false;
    *event = (saltus_event){.kind = row->kind,
                            .face = face,
                            .time = {llround(row->time - row->phase), row->phase},
                            .velocity_before = row->velocity_before,
                            .velocity_after = row->velocity_after,
                            .displacement = row->displacement};
    return true;
}

/* Each column is an array of its own, so the field needs no offset. */
#define COLUMN(called, measured_in, means, ...)                                                              \
    { .name = called, .unit = measured_in, .meaning = means, .type = __VA_ARGS__ }

static const saltus_field sample_fields[] = {
    COLUMN("time", "T", "time from the start of the recording in T: forcing periods, where there is forcing",
           SALTUS_REAL),
    COLUMN("states", "1", "displacements q, velocities q', further states, one row per sample", SALTUS_REAL,
           OF_DIMENSION),
    COLUMN("displacement", "1", "observed displacement (observe; else the first stop's coordinate)",
           SALTUS_REAL),
    COLUMN("velocity", "1", "rate of the observed displacement", SALTUS_REAL),
    COLUMN("observed", "1", "what the scene observes, in the order of the attribute names", SALTUS_REAL,
           OF_OBSERVED),
};
const saltus_field_table saltus_sample_fields = SALTUS_TABLE(sample_fields);

static const saltus_field strobe_fields[] = {
    COLUMN("states", "1", "states at phase 0 of the forcing, one row per recorded period, row k at time k",
           SALTUS_REAL, OF_DIMENSION)};
const saltus_field_table saltus_strobe_fields = SALTUS_TABLE(strobe_fields);

#define ROW(member, unit, meaning, ...)                                                                      \
    SALTUS_MEMBER(saltus_sweep_line, row.member, #member, unit, meaning, __VA_ARGS__)

static const saltus_field line_fields[] = {
    ROW(verdict, "1", "what the trajectory settled on; pending: not computed", SALTUS_CHOICE,
        .words = saltus_verdict_words),
    ROW(impacts, "1", "n, impacts of one orbit; -1 with complete chatter; 0 where not periodic", SALTUS_INT),
    ROW(periods, "1", "p, forcing periods of one orbit, or its returns to the section; 0 where not periodic",
        SALTUS_INT),
    ROW(sticking, "1", "sticking intervals of one orbit", SALTUS_INT),
    ROW(attractor, "1",
        "which of the distinct attractors met at this point, from 0; in basins, which row of /attractors; "
        "-1: none",
        SALTUS_INT),
    ROW(settled, "T", "forcing periods until the verdict, without forcing units of time", SALTUS_LONG),
    ROW(settled_impacts, "1", "impacts until the verdict", SALTUS_LONG),
    ROW(recorded, "T", "forcing periods, or returns to the section, recorded", SALTUS_LONG),
    ROW(largest, "1",
        "largest observed displacement, of one orbit where periodic, else of the recording; NaN without one",
        SALTUS_REAL),
    ROW(smallest, "1", "smallest observed displacement, of the same; NaN without one", SALTUS_REAL),
    ROW(rms, "1", "root mean square of the observed displacement, about zero", SALTUS_REAL),
    ROW(impact_rate, "1/T",
        "impacts per forcing period, or return to the section, those simulated one by one", SALTUS_REAL),
    ROW(largest_speed, "1", "largest speed of an impact; 0 without any", SALTUS_REAL),
    ROW(contact_fraction, "1", "part of the time in contact", SALTUS_REAL),
    ROW(lyapunov, "1",
        "largest Lyapunov exponent per unit of time; NaN where not asked for, -inf where all directions are "
        "lost",
        SALTUS_REAL),
    ROW(lyapunov_error, "1", "its standard error; 0 where an orbit's multipliers give it", SALTUS_REAL),
    ROW(lifetime_at_least, "T",
        "mean lifetime of chaos that is exceeded with 95 % confidence; NaN without a positive exponent",
        SALTUS_REAL),
    ROW(period, "1", "period of one orbit in units of time; NaN where not periodic", SALTUS_REAL),
    SALTUS_MEMBER(saltus_sweep_line, label, "label", "1", "name of the motion, n/p where it is periodic",
                  SALTUS_TEXT, SALTUS_LABEL_MAX),
};
const saltus_field_table saltus_line_fields = SALTUS_TABLE(line_fields);
const saltus_field_table saltus_row_fields = {line_fields, sizeof line_fields / sizeof *line_fields - 1};

static const saltus_field distinct_fields[] = {
    COLUMN("attractors", "1", "number of distinct attractors met at this point in this pass", SALTUS_INT)};
const saltus_field_table saltus_distinct_fields = SALTUS_TABLE(distinct_fields);

static const saltus_field span_fields[] = {
    SALTUS_MEMBER(saltus_span, first, "first", "1", "the row's first entry, from 0", SALTUS_LONG),
    SALTUS_MEMBER(saltus_span, count, "count", "1", "number of the row's entries", SALTUS_LONG)};
const saltus_field_table saltus_span_fields = SALTUS_TABLE(span_fields);

static const saltus_field turning_fields[] = {
    COLUMN("displacement", "1", "observed displacement where its velocity reverses", SALTUS_REAL)};
static const saltus_field impact_fields[] = {
    SALTUS_MEMBER(saltus_sweep_impact, phase, "phase", "T", "of the forcing, in [0, 1)", SALTUS_REAL),
    SALTUS_MEMBER(saltus_sweep_impact, speed, "speed", "1", "normal velocity n.q' just before", SALTUS_REAL),
    SALTUS_MEMBER(saltus_sweep_impact, face, "face", "1", "which one-sided contact, from 0", SALTUS_INT)};
static const saltus_field state_fields[] = {
    COLUMN("state", "1", "q, q', further states", SALTUS_REAL, OF_DIMENSION)};

const saltus_cloud_kind saltus_clouds[SALTUS_CLOUDS] = {
    {"turning", "turning points of the observed displacement", SALTUS_KEEP_TURNING,
     SALTUS_TABLE(turning_fields), sizeof(double)},
    {"impacts", "impacts", SALTUS_KEEP_IMPACTS, SALTUS_TABLE(impact_fields), sizeof(saltus_sweep_impact)},
    {"stroboscopic", "states at phase 0", SALTUS_KEEP_STROBOSCOPIC, SALTUS_TABLE(state_fields), 0},
};

#define ATTRACTOR(member, meaning, ...)                                                                      \
    SALTUS_MEMBER(saltus_attractor_row, member, #member, "1", meaning, __VA_ARGS__)

static const saltus_field attractor_fields[] = {
    ATTRACTOR(label, "name of the motion, n/p", SALTUS_TEXT, SALTUS_LABEL_MAX),
    ATTRACTOR(impacts, "n, impacts of one orbit; -1 with complete chatter", SALTUS_LONG),
    ATTRACTOR(periods, "p, forcing periods of one orbit, or its returns to the section; 0 where at rest",
              SALTUS_LONG),
    ATTRACTOR(stable, "1 where all multipliers are inside the unit circle", SALTUS_LONG),
    ATTRACTOR(first, "the orbit's first entry of state, from 0", SALTUS_LONG),
    ATTRACTOR(count, "number of its entries", SALTUS_LONG),
    ATTRACTOR(largest_multiplier, "modulus of the largest multiplier; NaN where it has none", SALTUS_REAL),
};
const saltus_field_table saltus_attractor_fields = SALTUS_TABLE(attractor_fields);

static const saltus_field attractor_point_fields[] = {COLUMN(
    "state", "1", "q, q', further states of the orbits' points at phase 0", SALTUS_REAL, OF_DIMENSION)};
const saltus_field_table saltus_attractor_point_fields = SALTUS_TABLE(attractor_point_fields);

#define EVIDENCE(member, name, unit, meaning, ...)                                                           \
    SALTUS_MEMBER(saltus_evidence, member, name, unit, meaning, __VA_ARGS__)

static const saltus_field evidence_fields[] = {
    EVIDENCE(periods, "periods", "T", "measured by all trajectories together", SALTUS_LONG),
    EVIDENCE(members, "members", "1", "trajectories", SALTUS_INT),
    EVIDENCE(half, "halves", "1", "largest exponent from the first and the second half", SALTUS_REAL, 2),
    EVIDENCE(half_errors, "half_errors", "1", "their standard errors", SALTUS_REAL, 2),
    EVIDENCE(zero_one, "zero_one_test", "1", "about 0 for regular motion, 1 for chaos", SALTUS_REAL),
    EVIDENCE(zero_one_quartiles, "zero_one_quartiles", "1", "of the test", SALTUS_REAL, 2),
    EVIDENCE(dimension, "correlation_dimension", "1", "of the section points", SALTUS_REAL),
    EVIDENCE(dimension_error, "correlation_dimension_error", "1", "its standard error", SALTUS_REAL),
    EVIDENCE(broadband, "broadband", "1", "part of the section points' variance outside lines", SALTUS_REAL),
    EVIDENCE(curves, "closed_curves", "1", "that the section points fill; 0: they do not", SALTUS_INT),
    EVIDENCE(impacts_per_period, "impacts_per_period", "1/T", "impacts", SALTUS_REAL),
    EVIDENCE(laminar, "laminar", "1", "part of the time spent near a periodic motion", SALTUS_REAL),
    EVIDENCE(lifetime_at_least, "lifetime_at_least", "T",
             "mean lifetime of chaos that is exceeded with 95 % confidence", SALTUS_REAL),
    EVIDENCE(lifetime, "lifetime", "T", "mean lifetime by the times of escape", SALTUS_REAL),
    EVIDENCE(laminar_period, "laminar_period", "T", "of this period; 0: no intermittency", SALTUS_INT),
    EVIDENCE(longest_phase, "longest_phase", "T", "longest of these laminar phases", SALTUS_LONG),
    EVIDENCE(left, "left", "1", "trajectories that left for a regular motion", SALTUS_INT),
    EVIDENCE(left_for, "left_for", "1", "its label", SALTUS_TEXT, 32),
    EVIDENCE(stable_orbit, "stable_orbit", "1", "label of a stable orbit amid the chaos", SALTUS_TEXT, 32),
};
const saltus_field_table saltus_evidence_fields = SALTUS_TABLE(evidence_fields);

#define EXPONENTS(member, name, unit, meaning, ...)                                                          \
    SALTUS_MEMBER(saltus_lyapunov, member, name, unit, meaning, __VA_ARGS__)

static const saltus_field exponent_fields[] = {
    EXPONENTS(dimension, "dimension", "1", "of the state", SALTUS_INT),
    EXPONENTS(lost, "lost", "1", "exponents that are -infinity", SALTUS_INT),
    EXPONENTS(sum, "sum", "1", "of all exponents", SALTUS_REAL),
    EXPONENTS(sum_rule, "sum_rule", "1", "what the trace and the restitutions make it", SALTUS_REAL),
    EXPONENTS(kaplan_yorke, "kaplan_yorke", "1", "dimension in the stroboscopic section", SALTUS_REAL),
    EXPONENTS(impacts_per_period, "impacts_per_period", "1/T", "impacts", SALTUS_REAL),
    EXPONENTS(sticks_per_period, "sticks_per_period", "1/T", "begins of contact", SALTUS_REAL),
    EXPONENTS(period, "period", "1", "T", SALTUS_REAL),
    EXPONENTS(time, "time", "1", "measured by all trajectories together", SALTUS_REAL),
    EXPONENTS(periods, "periods", "T", "the same in forcing periods, without forcing in units of time",
              SALTUS_LONG),
    EXPONENTS(transient, "transient", "T", "periods before it", SALTUS_LONG),
    EXPONENTS(half, "halves", "1", "largest exponent from the first and the second half", SALTUS_REAL, 2),
    EXPONENTS(half_errors, "half_errors", "1", "their standard errors", SALTUS_REAL, 2),
    EXPONENTS(independent, "independent", "1", "independent values it rests on", SALTUS_REAL),
    EXPONENTS(members, "members", "1", "trajectories that share the work", SALTUS_INT),
    EXPONENTS(member_exponents, "member_exponents", "1", "largest exponent of each", SALTUS_REAL,
              -1 - SALTUS_COUNT_MEMBERS, .indirect = true),
    EXPONENTS(agree, "agree", "1", "their scatter fits their standard errors", SALTUS_FLAG),
    EXPONENTS(precise, "precise", "1", "the precision asked for was reached", SALTUS_FLAG),
    EXPONENTS(slow, "slow", "1", "the run ended because its error hardly falls with time", SALTUS_FLAG),
    EXPONENTS(state, "state", "1", "of the first trajectory at the end", SALTUS_REAL, OF_DIMENSION,
              .indirect = true),
};
const saltus_field_table saltus_exponent_fields = SALTUS_TABLE(exponent_fields);
