/* Tables of the work-precision measurements.
 *
 * Times at equal error are interpolated logarithmically between neighbouring tolerances, and the smallest one
 * counts. A method that is more accurate than required at every tolerance counts with its cheapest run.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "bench.h"

#include <gsl/gsl_version.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

#ifdef __clang__
#define BENCH_COMPILER __VERSION__
#else
#define BENCH_COMPILER "gcc " __VERSION__
#endif

enum { levels = 3 };
static const double errors[levels] = {1e-6, 1e-9, 1e-12};

/* Which error and which cost a table shows. */
typedef enum quantity { of_motion, of_multipliers } quantity;

/* Error and cost of a measurement; NAN where there is none. Of the motion the error is that of the impact
 * times, for an orbit without impacts that of the state. */
typedef struct shown {
    double error, cost;
} shown;

static shown shown_of(const measure *m, quantity q) {
    if (!m->done || (q == of_multipliers && m->how == derivative_none))
        return (shown){NAN, NAN};
    if (q == of_multipliers)
        return (shown){m->multiplier_error, m->derivative_seconds};
    return (shown){isnan(m->event_error) ? m->state_error : m->event_error, m->seconds};
}

static double time_at(const results *r, int p, int m, double error, quantity q) {
    shown before = {NAN, NAN};
    double best = NAN;
    for (int t = 0; t < r->tolerance_count; t++) {
        const shown now = shown_of(&r->measures[p][m][t], q);
        if (isnan(now.cost))
            continue;
        if (now.error <= error)
            best = fmin(best, now.cost);
        if (now.error <= error && now.error > 0 && !isnan(before.cost)) {
            const double a = log(before.error), b = log(now.error), w = (log(error) - a) / (b - a);
            best = fmin(best, exp((1 - w) * log(before.cost) + w * log(now.cost)));
        }
        before = now.error <= error ? (shown){NAN, NAN} : now;
    }
    return best;
}

static double best_of_ours(const results *r, int p, double error, quantity q) {
    double best = NAN;
    for (int m = 0; m < r->method_count; m++)
        if (r->methods[m]->own)
            best = fmin(best, time_at(r, p, m, error, q));
    return best;
}

void report_machine(FILE *file, const char *mark) {
    struct utsname host;
    char line[256], day[32], versions[128];
    const time_t now = time(NULL);
    struct tm parts;
    strftime(day, sizeof day, "%Y-%m-%d", gmtime_r(&now, &parts));
    saltus_rivals_versions(versions, sizeof versions);
    fprintf(file, "%smachine: ", mark);
    FILE *information = fopen("/proc/cpuinfo", "r");
    while (information && fgets(line, sizeof line, information))
        if (strncmp(line, "model name", 10) == 0 && strchr(line, ':')) {
            line[strcspn(line, "\n")] = 0;
            fprintf(file, "%s", strchr(line, ':') + 2);
            break;
        }
    if (information)
        fclose(information);
    if (uname(&host) == 0)
        fprintf(file, ", %ld processors, %s %s", sysconf(_SC_NPROCESSORS_ONLN), host.sysname, host.machine);
    fprintf(file,
            "\n%scompiler: " BENCH_COMPILER "\n%sdate: %s\n%sversions: Saltus " SALTUS_VERSION
            ", GSL " GSL_VERSION "%s\n",
            mark, mark, day, mark, versions);
}

void report_number(FILE *file, const char *format, double value, const char *after) {
    if (!isnan(value))
        fprintf(file, format, value);
    fputs(after, file);
}

void report_csv(FILE *file, const results *r) {
    fprintf(file, "problem,method,rtol,event_error_T,state_error,cpu_us,evaluations,multipliers_by,"
                  "multiplier_error,multiplier_cpu_us,multiplier_evaluations\n");
    for (int p = 0; p < r->problem_count; p++)
        for (int k = 0; k < r->method_count; k++)
            for (int t = 0; t < r->tolerance_count; t++) {
                const measure *m = &r->measures[p][k][t];
                const double none = m->how == derivative_none ? NAN : 0;
                if (!m->done)
                    continue;
                fprintf(file, "%s,%s,%.0e,", r->problems[p].name, r->methods[k]->key, m->rtol);
                report_number(file, "%.3e", m->event_error, ",");
                report_number(file, "%.3e", m->state_error, ",");
                report_number(file, "%.4g", 1e6 * m->seconds, ",");
                report_number(file, "%.0f", m->evaluations, ",");
                fprintf(file, "%s,", (const char *[]){"", "tangents", "differences"}[m->how]);
                report_number(file, "%.3e", m->multiplier_error + none, ",");
                report_number(file, "%.4g", 1e6 * m->derivative_seconds + none, ",");
                report_number(file, "%.0f", m->derivative_evaluations + none, "\n");
            }
}

/* Saltus' best times at three errors, and the times of all methods relative to them; empty where a method was
 * not run. */
static void print_ratios(FILE *file, const results *r, quantity q) {
    if (r->problem_count == 0)
        return;
    fprintf(file, "| CPU time over our best at error 1e-6 / 1e-9 / 1e-12 |");
    for (int p = 0; p < r->problem_count; p++)
        fprintf(file, " %s |", r->problems[p].name);
    fprintf(file, "\n| --- |");
    for (int p = 0; p < r->problem_count; p++)
        fprintf(file, " --- |");
    for (int m = -1; m < r->method_count; m++) {
        bool known[problems_max] = {false}, any = m < 0;
        for (int p = 0; p < r->problem_count; p++) {
            for (int t = 0; t < r->tolerance_count && m >= 0; t++)
                known[p] |= !isnan(shown_of(&r->measures[p][m][t], q).cost);
            any |= known[p];
        }
        if (!any)
            continue;
        fprintf(file, "\n| %s |", m < 0 ? "**our best, µs**" : r->methods[m]->name);
        for (int p = 0; p < r->problem_count; p++) {
            for (int e = 0; e < levels && (m < 0 || known[p]); e++) {
                const double best = best_of_ours(r, p, errors[e], q),
                             ratio = m < 0 ? 1e6 * best : time_at(r, p, m, errors[e], q) / best;
                fprintf(file, e == 0 ? " " : " / ");
                fprintf(file, isnan(ratio) ? "–" : ratio < 9.95 ? "%.1f" : "%.0f", ratio);
            }
            fprintf(file, " |");
        }
    }
    fprintf(file, "\n\n");
}

void report_summary(FILE *file, const results *r) {
    print_ratios(file, r, of_motion);
}

void report_details(FILE *file, const results *r) {
    int defeats = 0, of_one_mode = 0;
    fprintf(file, "### Multipliers\n\nThe same for an error of the two leading Floquet multipliers, the time "
                  "with tangent vectors included. Ours are carried along by the flow; the rivals integrate "
                  "the variational equations with the state and apply the saltation matrix at each impact; "
                  "CVODE BDF takes central differences of its period map.\n\n");
    print_ratios(file, r, of_multipliers);
    fprintf(file, "### Where ours is not the fastest\n\n");
    /* The cases where a rival reaches an error sooner, or is the only one to reach it. */
    for (int k = 0; k < 2 * r->problem_count * levels; k++)
        for (int m = 0; m < r->method_count; m++) {
            const quantity q = k / levels < r->problem_count ? of_motion : of_multipliers;
            const int p = k / levels % r->problem_count, e = k % levels;
            const double time = time_at(r, p, m, errors[e], q), ours = best_of_ours(r, p, errors[e], q);
            if (r->methods[m]->own || isnan(time) || time >= ours)
                continue;
            defeats++;
            of_one_mode += r->problems[p].orbit.n == 2;
            fprintf(file, "- %s, %s %.0e: %s takes %.4g µs, ours ", r->problems[p].name,
                    q == of_motion ? "error" : "multipliers' error", errors[e], r->methods[m]->name,
                    1e6 * time);
            fprintf(file, isnan(ours) ? "does not reach it\n" : "%.4g µs\n", 1e6 * ours);
        }
    if (defeats == 0)
        fprintf(file, "Nowhere in this run.\n");
    if (of_one_mode > 0)
        fprintf(file, "\nWith one mode or mass an evaluation of the vector field costs little more than its "
                      "call, while a Taylor coefficient of order k takes a product of k terms for each "
                      "nonlinearity: where little accuracy is asked, a Runge-Kutta method of order eight "
                      "needs no more evaluations than ours needs orders.\n");
    fprintf(file, "\n");
}

/* Reference for an error: the tolerance itself, or, if larger, the effect of a perturbation of the start of
 * that size. */
typedef enum yardstick { tolerance_itself, tolerance_amplified } yardstick;

/* Error of the events or of the state in units of the yardstick. */
static double factor_of(const results *r, int p, int m, int t, bool events, yardstick by) {
    const measure *at = &r->measures[p][m][t];
    const condition *c = &r->conditions[p][t];
    double asked = at->rtol;
    if (by == tolerance_amplified)
        asked = fmax(asked, events ? c->events : c->state);
    return (events ? at->event_error : at->state_error) / asked;
}

static void print_asked(FILE *file, const results *r, bool events, yardstick by) {
    fprintf(file, "| %s over %s |", events ? "error of the event times in T" : "relative error of the state",
            by == tolerance_itself ? "rtol" : "rtol or its effect");
    for (int t = 0; t < r->tolerance_count; t++)
        fprintf(file, " %.0e |", r->tolerances[t]);
    fprintf(file, "\n| --- |");
    for (int t = 0; t < r->tolerance_count; t++)
        fprintf(file, " --- |");
    fprintf(file, "\n");
    for (int p = 0; p < r->problem_count; p++)
        for (int m = 0; m < r->method_count; m++) {
            const saltus_integrator chosen = r->problems[p].stiff ? SALTUS_MIXED : SALTUS_TAYLOR;
            if (!r->methods[m]->own || (events && r->problems[p].impacts == 0))
                continue;
            fprintf(file, "| %s, %s%s |", r->problems[p].name, r->methods[m]->name,
                    r->methods[m]->which == (int)chosen ? " (chosen)" : "");
            for (int t = 0; t < r->tolerance_count; t++)
                if (r->measures[p][m][t].done)
                    fprintf(file, " %.2g |", factor_of(r, p, m, t, events, by));
                else
                    fprintf(file, " – |");
            fprintf(file, "\n");
        }
    fprintf(file, "\n");
}

void report_asked(FILE *file, const results *r) {
    fprintf(file, "Where an orbit is sensitive, near grazing above all, no integrator keeps the error at its "
                  "tolerance: the second pair of tables divides by the larger of rtol and the error that a "
                  "change of the start by rtol (of the orbit's size, each component in turn) brings about. 1 "
                  "T stands for an impact that is missing.\n\n");
    for (int by = tolerance_itself; by <= tolerance_amplified; by++) {
        print_asked(file, r, true, by);
        print_asked(file, r, false, by);
    }
    report_worst(file, r);
}

/* The largest factor, with its problem, method and tolerance. */
static void print_worst(FILE *file, const results *r, yardstick by) {
    int at[3] = {0, 0, 0};
    double worst = 0;
    for (int p = 0; p < r->problem_count; p++)
        for (int m = 0; m < r->method_count; m++)
            for (int t = 0; t < r->tolerance_count; t++) {
                if (!r->methods[m]->own || !r->measures[p][m][t].done)
                    continue;
                const double factor = fmax(factor_of(r, p, m, t, true, by), factor_of(r, p, m, t, false, by));
                if (factor > worst)
                    worst = factor, at[0] = p, at[1] = m, at[2] = t;
            }
    fprintf(file, "%.2g (%s, %s, rtol %.0e)", worst, r->problems[at[0]].name, r->methods[at[1]]->name,
            r->tolerances[at[2]]);
}

void report_worst(FILE *file, const results *r) {
    double least = INFINITY; /* error of the events of fig7d */
    if (r->problem_count == 0)
        return;
    for (int p = 0; p < r->problem_count; p++)
        for (int m = 0; m < r->method_count && strcmp(r->problems[p].name, "fig7d") == 0; m++)
            for (int t = 0; t < r->tolerance_count; t++)
                if (r->methods[m]->own && r->measures[p][m][t].done)
                    least = fmin(least, r->measures[p][m][t].event_error);
    fprintf(
        file,
        "Asked and got: over all problems, our three integrators and rtol from %.0e to %.0e, the largest "
        "ratio of the error to rtol, or to what a change of the start by rtol does where this is more, is ",
        r->tolerances[0], r->tolerances[r->tolerance_count - 1]);
    print_worst(file, r, tolerance_amplified);
    fprintf(file, ". Against rtol alone it is ");
    print_worst(file, r, tolerance_itself);
    fprintf(file, ".");
    if (isfinite(least))
        fprintf(file, " The smallest error of fig7d's impact times is %.1e T.", least);
    fprintf(file, "\n\n");
}
