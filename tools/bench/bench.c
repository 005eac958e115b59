/* saltus_bench: error against cost of one trajectory, Saltus' integrators beside those of other libraries,
 * and what each feature costs.
 *
 * Every row is measured in the same run on the same machine from a reference orbit of data/reference once
 * around it: the largest error of the impact times (in T), the relative error of the state, the median CPU
 * time of repeated runs, the evaluations of the vector field (for Taylor series: orders), and the error of
 * the leading multipliers with the CPU time when tangent vectors are carried along.
 *
 * usage: saltus_bench [--quick] [--only problem] [--to folder] [--cost-only] [--modes] [folder of references]
 * Tables go to `folder` (work-precision.csv, cost.csv, README.md), a summary to the standard output. With
 * --modes the only output is a table of pipes with few to many modes (modes.c).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "bench.h"

const char program_name[] = "saltus_bench";

typedef struct request {
    const char *references, *to, *only;
    bool quick, cost_only, modes;
    effort effort;
} request;

static const char *const known[][2] = {
    {"fig7d", "pipe, five modes, one impact in a period (4/4)"},
    {"chatter25", "pipe that comes to rest on its stop by complete chatter"},
    {"free5", "pipe, five modes, no stop"},
    {"modes20", "pipe, twenty modes: stiff"},
    {"two-sided", "oscillator between two stops"},
    {"near-grazing", "an impact of very low speed"},
    {"sdof14", "pipe, one mode, two stops"},
};

static void measure_all(const request *q, results *r) {
    for (int p = 0; p < r->problem_count; p++)
        for (int t = 0; t < r->tolerance_count; t++)
            r->conditions[p][t] = measure_condition(&r->problems[p], r->tolerances[t]);
    for (int p = 0; p < r->problem_count; p++)
        for (int m = 0; m < r->method_count; m++) {
            const method *method = r->methods[m];
            const problem *problem = &r->problems[p];
            const double before = processor_seconds();
            for (int t = 0; t < r->tolerance_count; t++) {
                const double rtol = r->tolerances[t];
                const int digits = (int)lround(-log10(rtol));
                const bool below_their_range = !method->own && rtol < 0.5e-14;
                if (below_their_range || (method->stiff && !problem->stiff))
                    continue;
                /* Where a rival's variational equations would take minutes, only a few tolerances are
                 * measured. The implicit rival has none and uses differences. */
                const derivative how = !method->own && problem->orbit.n > 20 && digits % 4 != 0
                                           ? derivative_none
                                       : method->tangents ? derivative_tangents
                                                          : derivative_differences;
                r->measures[p][m][t] = measure_method(problem, method, rtol, how, &q->effort);
            }
            fprintf(stderr, "%s, %s: %.1f s\n", problem->name, method->name, processor_seconds() - before);
        }
}

static void write_page(FILE *page, const results *r, const cost_table *costs) {
    fprintf(page, "# Error against run time, and what each feature costs\n\nMade by `tools/bench.sh`.\n\n");
    report_machine(page, "- ");
    fprintf(page, "\nRuns start on a reference orbit of `../reference` and go once around it. Problems:\n\n");
    for (int p = 0; p < r->problem_count; p++)
        fprintf(page, "- %s: %s; %s, %d T, integrator chosen: %s\n", r->problems[p].name, r->problems[p].what,
                r->problems[p].orbit.label, r->problems[p].orbit.periods, r->problems[p].integrator);
    fprintf(page,
            "\nOne problem alone, without touching this folder: `mkdir -p /tmp/bench && build/saltus_bench "
            "--only fig7d --to /tmp/bench data/reference`; the costs alone: `--cost-only`.\n\nEvery "
            "measurement is in [work-precision.csv](work-precision.csv) and [cost.csv](cost.csv).\n\n"
            "![](work-precision.png)\n![](work-precision-evaluations.png)\n![](work-precision-state.png)\n"
            "![](work-precision-multipliers.png)\n\n## Equal error\n\nError of the event times in T; of an "
            "orbit without impacts, relative error of the state. A dash: not reached at any tolerance. "
            "SUNDIALS looks for events on an interpolant; a dip beyond a stop that is shallower than the "
            "interpolant's error stays unseen, as in near-grazing.\n\n");
    report_summary(page, r);
    report_details(page, r);
    fprintf(page, "## Asked and got\n\n");
    report_asked(page, r);
    fprintf(page, "## Costs\n\n");
    cost_print(page, costs);
}

static bool write_all(const request *q, const results *r, const cost_table *costs) {
    static const char *const names[] = {"cost.csv", "work-precision.csv", "README.md"};
    bool done = true;
    for (int k = 0; k < (q->cost_only ? 1 : 3); k++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", q->to, names[k]);
        FILE *file = fopen(path, "w");
        done = done && file;
        if (!file) {
            fprintf(stderr, "saltus_bench: %s cannot be written\n", path);
            continue;
        }
        if (k < 2)
            report_machine(file, "# ");
        if (k == 0)
            cost_csv(file, costs);
        else if (k == 1)
            report_csv(file, r);
        else
            write_page(file, r, costs);
        done = !ferror(file) && done;
        done = fclose(file) == 0 && done;
    }
    return done;
}

static bool read_arguments(int count, char **arguments, request *q) {
    *q = (request){.references = "data/reference", .to = ".", .effort = {15, 0.08, 1.0}};
    for (int k = 1; k < count; k++)
        if (strcmp(arguments[k], "--quick") == 0)
            q->quick = true;
        else if (strcmp(arguments[k], "--cost-only") == 0)
            q->cost_only = true;
        else if (strcmp(arguments[k], "--modes") == 0)
            q->modes = true;
        else if (strcmp(arguments[k], "--only") == 0 && k + 1 < count)
            q->only = arguments[++k];
        else if (strcmp(arguments[k], "--to") == 0 && k + 1 < count)
            q->to = arguments[++k];
        else if (arguments[k][0] != '-')
            q->references = arguments[k];
        else
            return false;
    if (q->quick)
        q->effort = (effort){3, 0.01, 0.2};
    return true;
}

int main(int count, char **arguments) {
    static cost_table costs;
    static results r;
    request q;
    if (!read_arguments(count, arguments, &q)) {
        fprintf(stderr, "usage: saltus_bench [--quick] [--only problem] [--cost-only] [--modes] "
                        "[--to folder] [folder of references]\n");
        return 2;
    }
    for (int k = 0; k < own_method_count; k++)
        r.methods[r.method_count++] = &own_methods[k];
    for (int k = 0; k < saltus_rival_count && r.method_count < methods_max; k++)
        r.methods[r.method_count++] = &saltus_rivals[k];
    if (q.modes) {
        modes_print(r.methods, r.method_count);
        return 0;
    }
    for (int digits = 3; digits <= 15; digits += q.quick ? 3 : 1)
        r.tolerances[r.tolerance_count++] = pow(10, -digits);
    for (size_t k = 0; k < sizeof known / sizeof known[0] && !q.cost_only; k++) {
        problem *p = &r.problems[r.problem_count];
        if (q.only && strcmp(q.only, known[k][0]) != 0)
            continue;
        if (problem_open(q.references, known[k][0], known[k][1], p))
            r.problem_count++;
        else
            fprintf(stderr, "saltus_bench: %s/%s.json cannot be read: left out\n", q.references, known[k][0]);
    }
    measure_all(&q, &r);
    if (!q.only)
        cost_measure(&costs, q.quick);
    const bool done = write_all(&q, &r, &costs);
    printf("\n");
    report_summary(stdout, &r);
    report_worst(stdout, &r);
    cost_print(stdout, &costs);
    return done ? 0 : 1;
}
