/* A motion in a few lines for people.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/record.h"

#include "record/describe.h"

#include <math.h>
#include <string.h>

enum { event_lines = 12, leading = 4 };

void saltus_put_word(FILE *file, const char *word) {
    fprintf(file, "  %-14s", word);
}

void saltus_put_scene(FILE *file, const saltus_scene *scene, const saltus_system *system) {
    const saltus_spec *spec = saltus_system_spec(system);
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    if (scene->title[0])
        fprintf(file, "  %s\n", scene->title);
    saltus_put_word(file, saltus_model_name(spec->model));
    const char *separator = "";
    for (int k = 0; k < count; k++)
        if (saltus_parameter_shown(spec, k)) {
            fprintf(file, "%s%s = %.10g", separator, p[k].name, spec->parameters[k]);
            separator = ", ";
        }
    fputc('\n', file);
    for (int s = 0; s < spec->stop_count; s++) {
        const saltus_stop *stop = &spec->stops[s];
        fprintf(file, "  stop %-9d", s + 1);
        saltus_put_place(file, spec, s, 10);
        const char *law = saltus_restitution_law(spec, s);
        char r[32];
        snprintf(r, sizeof r, "%.10g", stop->r);
        fprintf(file, ", d = %.10g, r = %s, %s\n", stop->d, law ? law : r,
                stop->sides == SALTUS_BOTH    ? "both sides"
                : stop->sides == SALTUS_UPPER ? "upper side"
                                              : "lower side");
    }
}

static const char *plural(long long count) {
    return count == 1 ? "" : "s";
}

/* Of an orbit with a period of its own. */
static void put_cycle(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    if (motion->impacts < 0)
        fprintf(file, "complete chatter with %d sticking interval%s", motion->sticking_intervals,
                plural(motion->sticking_intervals));
    else
        fprintf(file, "%lld impact%s", motion->impacts, plural(motion->impacts));
    fprintf(file, " in %d return%s to the section, ", motion->periods, plural(motion->periods));
    saltus_put_section(file, system);
    fprintf(file, "; period %.13g\n", motion->period);
    if (motion->reason[0])
        fprintf(file, "  %-14s%s\n", "", motion->reason);
}

static void put_motion(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    saltus_put_word(file, "motion");
    if (!saltus_verdict_settled(motion->verdict))
        fprintf(file, "%s\n", motion->reason);
    else if (motion->verdict == SALTUS_EQUILIBRIUM)
        fputs("at rest, clear of every stop\n", file);
    else if (motion->verdict == SALTUS_HELD)
        fputs("in contact for good\n", file);
    else if (motion->trivial_multiplier != 0)
        put_cycle(file, system, motion);
    else if (motion->impacts < 0)
        fprintf(file, "complete chatter with %d sticking interval%s in %d forcing period%s\n",
                motion->sticking_intervals, plural(motion->sticking_intervals), motion->periods,
                plural(motion->periods));
    else
        fprintf(file, "%lld impact%s in %d forcing period%s, %.6g per response cycle%s\n", motion->impacts,
                plural(motion->impacts), motion->periods, plural(motion->periods),
                saltus_impacts_per_response(system, motion),
                saltus_notation_of(system)->response == 2 ? " (2 T)" : "");
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
        fprintf(file, " (in %lld periods%s)", motion->counted,
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

/* Number of impacts on one face in a row, from event k on. */
static int run_length(const saltus_motion *motion, int k) {
    int length = 0;
    while (k + length < motion->event_count && motion->events[k + length].kind == SALTUS_IMPACT &&
           motion->events[k + length].face == motion->events[k].face)
        length++;
    return length;
}

/* A long run of impacts on one face (a chatter) takes three lines: two impacts and what became of the others.
 */
static void put_events(FILE *file, const saltus_system *system, const saltus_motion *motion) {
    int lines = 0, k = 0;
    bool brief = motion->event_count > event_lines;
    while (k < motion->event_count && lines < event_lines) {
        int run = run_length(motion, k);
        if (!brief || run <= 3) {
            put_event(file, system, &motion->events[k++]);
            lines++;
            continue;
        }
        put_event(file, system, &motion->events[k]);
        put_event(file, system, &motion->events[k + 1]);
        const saltus_event *first = &motion->events[k + 2], *last = &motion->events[k + run - 1];
        fprintf(file, "    ... %d more impacts until tau/T = %.7f, velocity before impact %.4g to %.4g\n",
                run - 2, saltus_time_periods(last->time), first->velocity_before, last->velocity_before);
        k += run;
        lines += 3;
    }
    if (k < motion->event_count)
        fprintf(file, "    ... and %d more event%s\n", motion->event_count - k,
                plural(motion->event_count - k));
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
    if (!motion->stable)
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
                "not checked: the smallest multipliers are not resolved; trace and restitution give %.10g\n",
                motion->sum_rule);
    else
        fprintf(file, "log moduli add up to %.10g; trace and restitution give %.10g (difference %.1e)\n",
                motion->log_volume, motion->sum_rule, motion->log_volume - motion->sum_rule);
}

/* What else is known of a motion without a period. */
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
    fprintf(file, "  %-14s%.7g to %.7g", "displacement", motion->smallest, motion->largest);
    if (!isnan(motion->rms))
        fprintf(file, ", root mean square %.7g", motion->rms);
    fputc('\n', file);
    if (motion->transient) {
        fprintf(file, "  %-14s%lld period%s simulated", "settled", motion->transient,
                plural(motion->transient));
    } else
        saltus_put_word(file, "orbit");
    if (motion->verdict == SALTUS_PERIODIC || !motion->transient)
        fprintf(file, "%sresidual %.1e after %d Newton step%s", motion->transient ? "; " : "",
                motion->residual, motion->iterations, plural(motion->iterations));
    fprintf(file, " (%s)\n", saltus_integrator_used(system, motion->integrator));
}
