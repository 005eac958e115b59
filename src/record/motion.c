/* A motion, in a few lines for people and as one JSON object.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/fields.h"
#include "record/json.h"

#include <math.h>

enum { event_lines = 12, leading = 4 };

static void put_motion(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    const bool cycle = motion->trivial_multiplier != 0; /* it has a period of its own */
    saltus_put_word(file, "motion");
    if (!saltus_verdict_settled(motion->verdict)) {
        fprintf(file, "%s\n", motion->reason);
        return;
    }
    if (motion->verdict == SALTUS_EQUILIBRIUM || motion->verdict == SALTUS_HELD) {
        fputs(motion->verdict == SALTUS_HELD ? "in contact for good\n" : "at rest, clear of every stop\n",
              file);
        return;
    }
    if (motion->impacts < 0)
        fprintf(file, "complete chatter with %d sticking interval%s", motion->sticking_intervals,
                saltus_plural(motion->sticking_intervals));
    else
        fprintf(file, "%lld impact%s", motion->impacts, saltus_plural(motion->impacts));
    fprintf(file, cycle ? " in %d return%s to the section, " : " in %d forcing period%s", motion->periods,
            saltus_plural(motion->periods));
    const saltus_poincare section = saltus_system_poincare(system);
    if (cycle) {
        if (section.kind == SALTUS_POINCARE_ZERO)
            fprintf(file, "the zeros of %s, %s", section.text, section.direction > 0 ? "rising" : "falling");
        else if (section.kind == SALTUS_POINCARE_IMPACT)
            fprintf(file, "the impacts on stop %d%s", section.stop + 1,
                    section.side > 0   ? ", upper side"
                    : section.side < 0 ? ", lower side"
                                       : "");
        else
            fputs("the maxima of the displacement", file);
        fprintf(file, "; period %.13g", motion->period);
    } else if (motion->impacts >= 0)
        fprintf(file, ", %.6g per response cycle%s", saltus_impacts_per_response(system, motion),
                saltus_notation_of(system)->response == 2 ? " (2 T)" : "");
    fputc('\n', file);
    if (cycle && motion->reason[0])
        fprintf(file, "  %-14s%s\n", "", motion->reason);
}

static void put_faces(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    int faces = saltus_system_face_count(system);
    bool settled = saltus_verdict_settled(motion->verdict);
    if (faces == 0 || motion->verdict == SALTUS_EQUILIBRIUM || (!settled && !motion->counted))
        return;
    bool held = motion->verdict == SALTUS_HELD;
    saltus_put_word(file, held ? "contact force" : "impacts");
    for (int f = 0; f < faces; f++) {
        saltus_face face = saltus_system_face(system, f);
        fprintf(file, "%sstop %d %s: ", f ? ", " : "", face.stop + 1, saltus_side_word(face.side));
        if (held)
            fprintf(file, "%.6g", motion->contact_force[f]);
        else
            fprintf(file, "%lld", motion->impacts_by_face[f]);
    }
    bool modal = saltus_notation_of(system)->structure == SALTUS_STRUCTURE_LINE;
    bool cut = !held && settled && motion->impacts < 0;
    if (!settled)
        fprintf(file, " (in %lld period%s%s)", motion->counted, saltus_plural(motion->counted),
                motion->impacts < 0 ? ", of complete chatter those simulated one by one" : "");
    fputs(held && modal ? " (per modal mass)\n" : cut ? " (before the chatter completes)\n" : "\n", file);
}

static void put_event(FILE *file, const saltus_system *system, const saltus_event *event) {
    saltus_face face = saltus_system_face(system, event->face);
    fprintf(file, "    %-8s stop %d %s  tau/T = %10.7f  phase %.7f", saltus_event_word(event->kind),
            face.stop + 1, saltus_side_word(face.side), saltus_time_periods(event->time), event->time.phase);
    if (event->kind == SALTUS_IMPACT)
        fprintf(file, "  velocity %.7g -> %.7g", event->velocity_before, event->velocity_after);
    fputc('\n', file);
}

/* A long run of impacts on one face (chatter) is shortened to three lines: its first two impacts and a
 * summary of the others. */
static void put_events(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    const saltus_event *events = motion->events;
    int lines = 0, k = 0, run;
    for (; k < motion->event_count && lines < event_lines; k += run) {
        for (run = 0; k + run < motion->event_count && events[k + run].kind == SALTUS_IMPACT &&
                      events[k + run].face == events[k].face;)
            run++;
        put_event(file, system, &events[k]);
        lines++;
        if (motion->event_count <= event_lines || run <= 3) {
            run = 1;
            continue;
        }
        put_event(file, system, &events[k + 1]);
        fprintf(file, "    ... %d more impacts until tau/T = %.7f, velocity before impact %.4g to %.4g\n",
                run - 2, saltus_time_periods(events[k + run - 1].time), events[k + 2].velocity_before,
                events[k + run - 1].velocity_before);
        lines += 2;
    }
    if (k < motion->event_count)
        fprintf(file, "    ... and %d more event%s\n", motion->event_count - k,
                saltus_plural(motion->event_count - k));
}

static void put_multipliers(FILE *file, const saltus_motion *motion) {
    if (motion->multiplier_count == 0)
        return;
    saltus_put_word(file, "multipliers");
    for (int k = 0; k < motion->multiplier_count && k < leading; k++) {
        const saltus_multiplier *m = &motion->multipliers[k];
        bool pair = saltus_multiplier_pair(motion, k);
        fprintf(file, "%s%.6g", k ? ", " : "", m->re);
        if (m->im != 0)
            fprintf(file, " %s %.6gi (modulus %.6g)",
                    pair        ? "+-"
                    : m->im < 0 ? "-"
                                : "+",
                    fabs(m->im), exp(m->log_modulus));
        k += pair;
    }
    int unstable = saltus_multipliers_unstable(motion->multipliers, motion->multiplier_count);
    fprintf(file, "%s", motion->multiplier_count > leading ? ", ..." : "");
    if (unstable < 0)
        fputs("; not all are known", file);
    else if (!motion->stable)
        fprintf(file, "; %d not inside the unit circle", unstable);
    if (motion->trivial_multiplier != 0)
        fprintf(file, "; along the flow 1 %c %.1e", motion->trivial_multiplier < 1 ? '-' : '+',
                fabs(motion->trivial_multiplier - 1));
    fputc('\n', file);
    saltus_put_word(file, "sum rule");
    if (motion->sticks)
        fputs("does not apply: the motion sticks, some multipliers are exactly zero\n", file);
    else if (isnan(motion->sum_rule))
        fputs("not checked: the trace is not known\n", file);
    else if (isnan(motion->log_volume))
        fprintf(file,
                "not checked: the tangent vectors do not resolve the smallest multipliers; trace and "
                "restitution give %.10g\n",
                motion->sum_rule);
    else
        fprintf(file, "log moduli add up to %.10g; trace and restitution give %.10g (difference %.1e)\n",
                motion->log_volume, motion->sum_rule, motion->log_volume - motion->sum_rule);
}

/* The remaining evidence for a motion without a period. */
static void put_evidence(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    const saltus_evidence *e = &motion->evidence;
    if (saltus_verdict_settled(motion->verdict) || e->periods == 0)
        return;
    saltus_put_word(file, "exponent");
    if (isinf(motion->lyapunov))
        fputs("-infinity: every direction is lost in lasting contacts\n", file);
    else
        fprintf(file, "%.6g +- %.2g per unit of time; first half %.6g +- %.2g, second half %.6g +- %.2g\n",
                motion->lyapunov, motion->lyapunov_error, e->half[0], e->half_errors[0], e->half[1],
                e->half_errors[1]);
    if (!isnan(e->zero_one)) {
        fprintf(
            file,
            "  %-14s0-1 test %.3f (quartiles %.3f, %.3f), %.2g of the section points' variance outside lines",
            "opinions", e->zero_one, e->zero_one_quartiles[0], e->zero_one_quartiles[1], e->broadband);
        if (!isnan(e->dimension))
            fprintf(file, ", correlation dimension %.2f +- %.2f", e->dimension, e->dimension_error);
        fputc('\n', file);
    }
    if (e->lifetime_at_least > 0) {
        fprintf(file, "  %-14sat least %.0f periods in the mean (95 %%)", "lifetime", e->lifetime_at_least);
        if (e->lifetime > 0)
            fprintf(file, ", %.3g by the escape of %d of %d trajectories", e->lifetime, e->left, e->members);
        fputc('\n', file);
    }
    if (!isnan(e->impacts_per_period))
        fprintf(file, "  %-14s%.4g per T = %.6g\n", "impacts", e->impacts_per_period,
                saltus_system_period(system));
}

void saltus_write_motion_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                              const saltus_motion *motion) {
    static const char *const mirror[] = {
        "the scene has no mirror symmetry", "the orbit is its own mirror image",
        "the orbit is one of a mirror pair", "the scene is symmetric; no orbit is there to compare"};
    const saltus_spec *spec = saltus_system_spec(system);
    const char *observed = saltus_system_observed_name(system);
    const double place = saltus_system_observed_place(system);
    char verdict[64];
    saltus_motion_summary(motion, verdict);
    fprintf(file, "%s: %s\n", scene->name, verdict);
    saltus_put_scene(file, scene, system);
    put_motion(file, system, motion);
    put_faces(file, system, motion);
    put_events(file, system, motion);
    put_multipliers(file, motion);
    if (motion->eigenvalues)
        saltus_put_eigenvalues(file, motion->eigenvalues, motion->eigenvalue_count,
                               motion->verdict == SALTUS_HELD);
    if (saltus_verdict_settled(motion->verdict) && !isnan(motion->lyapunov))
        fprintf(file, "  %-14s%.10g per unit of time, the largest\n", "exponent", motion->lyapunov);
    put_evidence(file, system, motion);
    fprintf(file, "  %-14s%s\n", "mirror", mirror[motion->mirror]);
    /* A lower stop at zero has the displacement -0. */
    fprintf(file, "  %-14s%.7g to %.7g", "displacement", motion->smallest + 0.0, motion->largest + 0.0);
    if (!isnan(motion->rms))
        fprintf(file, ", root mean square %.7g", motion->rms);
    if (!observed && !isnan(place) && spec->observe[0])
        fprintf(file, " (at %s = %.10g)", saltus_model_stop_key(spec->model), place);
    else if (observed || spec->observe[0])
        fprintf(file, " (of %s)", observed ? observed : spec->observe);
    fputc('\n', file);
    if (motion->transient)
        fprintf(file, "  %-14s%lld period%s simulated", "settled", motion->transient,
                saltus_plural(motion->transient));
    else
        saltus_put_word(file, "orbit");
    if (motion->verdict == SALTUS_PERIODIC || !motion->transient)
        fprintf(file, "%sresidual %.1e after %d Newton step%s", motion->transient ? "; " : "",
                motion->residual, motion->iterations, saltus_plural(motion->iterations));
    fprintf(file, " (%s)\n", saltus_integrator_used(system, motion->integrator));
}

/* Complete chatter has infinitely many impacts; how many are simulated one by one depends on the
 * tolerance. */
static void put_impact_counts(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    if (motion->impacts < 0) {
        fputs(", \"impacts_by_side\": null, \"impacts_by_stop\": null", file);
        return;
    }
    int stops = saltus_system_spec(system)->stop_count;
    long long sides[2] = {0, 0}, by_stop[SALTUS_STOPS_MAX][2] = {{0}};
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        sides[face.side < 0] += motion->impacts_by_face[f];
        by_stop[face.stop][face.side < 0] += motion->impacts_by_face[f];
    }
    fprintf(file,
            ", \"impacts_by_side\": {\"upper\": %lld, \"lower\": %lld}, \"impacts_counted_over\": %lld, "
            "\"impacts_by_stop\": [",
            sides[0], sides[1], motion->counted);
    for (int s = 0; s < stops; s++)
        fprintf(file, "%s{\"stop\": %d, \"upper\": %lld, \"lower\": %lld}", s ? ", " : "", s + 1,
                by_stop[s][0], by_stop[s][1]);
    fputc(']', file);
}

void saltus_write_motion_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                              const saltus_motion *motion) {
    static const char *const mirror[] = {"none", "self", "pair", "open"};
    const saltus_spec *spec = saltus_system_spec(system);
    const saltus_evidence *e = &motion->evidence;
    const bool settled = saltus_verdict_settled(motion->verdict);
    const int n = motion->dimension;
    saltus_json_begin(file, scene);
    saltus_json_text(file, "label", motion->label);
    saltus_json_text(file, "kind", saltus_verdict_word(motion->verdict));
    saltus_json_member(file, "impacts", motion->impacts >= 0 && settled ? (double)motion->impacts : NAN);
    fprintf(file, ", \"periods\": %d, \"sticking_intervals\": %d", motion->periods,
            motion->sticking_intervals);
    saltus_json_member(file, "period", motion->period);
    put_impact_counts(file, system, motion);
    saltus_json_member(file, "impacts_per_response", saltus_impacts_per_response(system, motion));
    for (int i = 0; i < saltus_system_dimension(system) && saltus_model_text(spec->model); i++) {
        fputs(i ? ", " : ", \"state_names\": [", file);
        saltus_put_string(file, saltus_system_state_name(system, i).text);
        fputs(i == saltus_system_dimension(system) - 1 ? "]" : "", file);
    }
    if (motion->state)
        saltus_json_list(file, "state", motion->state, n);
    else
        fputs(", \"state\": null", file);
    saltus_json_rows(file, "section_states", motion->section_states,
                     motion->section_states ? motion->periods : 0, n, n);
    saltus_json_events(file, system, motion->events, motion->event_count);
    saltus_json_multipliers(file, motion->multipliers, motion->multiplier_count);
    if (motion->eigenvalues)
        saltus_json_rows(file, "eigenvalues", motion->eigenvalues, motion->eigenvalue_count, 2, 2);
    if (motion->trivial_multiplier != 0)
        saltus_json_member(file, "trivial_multiplier", motion->trivial_multiplier);
    fprintf(file, ", \"stable\": %s", motion->stable ? "true" : "false");
    saltus_json_text(file, "mirror", mirror[motion->mirror]);
    saltus_json_member(file, "residual", motion->residual);
    if (motion->sticks || motion->multiplier_count == 0)
        fputs(", \"sum_rule\": null", file);
    else {
        fputs(", \"sum_rule\": {\"multipliers\": ", file);
        saltus_json_value(file, motion->log_volume);
        saltus_json_member(file, "trace_and_restitution", motion->sum_rule);
        saltus_json_member(file, "difference", motion->log_volume - motion->sum_rule);
        fputc('}', file);
    }
    saltus_json_member(file, "lyapunov", motion->lyapunov);
    saltus_json_member(file, "lyapunov_standard_error", motion->lyapunov_error);
    if (!settled)
        saltus_json_member(file, "lifetime_at_least", e->lifetime_at_least);
    if (e->periods)
        saltus_json_fields(file, ", \"evidence\": {", &saltus_evidence_fields, NULL, e);
    fputs(e->periods ? "}" : ", \"evidence\": null", file);
    saltus_json_contact_force(file, system, motion->verdict == SALTUS_HELD ? motion->contact_force : NULL,
                              NULL);
    saltus_json_member(file, "largest_displacement", motion->largest);
    saltus_json_member(file, "smallest_displacement", motion->smallest);
    saltus_json_member(file, "rms_displacement", motion->rms);
    fprintf(file, ", \"transient\": %lld", motion->transient);
    saltus_json_text(file, "reason", motion->reason);
    saltus_json_end(file, spec, saltus_integrator_used(system, motion->integrator));
}
