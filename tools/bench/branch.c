/* saltus_branch_bench: cost and accuracy of a branch of periodic orbits.
 *
 * The family of data/reference/fig7d.json over omega = 35 to 56, continued in both directions, with
 * multipliers and a run of the event-driven flow at every point. Time is CPU time, the median of repeated
 * runs. Newton steps include those of rejected steps and of locating special points. Residual and sum rule
 * are from the same runs. An argument names the folder of the reference.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "clock.h"
#include "must.h"
#include "reference.h"

#include "saltus/branch.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>

const char program_name[] = "saltus_branch_bench";

enum { repeats = 3 };

/* What Newton's method took in a run. */
typedef struct effort {
    long iterations, evaluations;
} effort;

static void count_iteration(void *context, int iteration, double residual, const char *what) {
    effort *e = context;
    (void)residual;
    (void)what;
    e->evaluations++;
    e->iterations += iteration > 0;
}

/* Print the line of a largest step. */
static void measure(const reference *r, double step_max) {
    saltus_branch_options options = saltus_branch_defaults();
    saltus_message message = {.text = ""};
    effort spent;
    double seconds[repeats], residual = 0, sum_rule = 0;
    long points = 0, special = 0, ruled = 0; /* ruled: with all multipliers resolved */
    snprintf(options.key[0], sizeof options.key[0], "omega");
    options.low[0] = 35;
    options.high[0] = 56;
    options.step_max = step_max;
    options.orbit.history = count_iteration;
    options.orbit.context = &spent;
    for (int k = 0; k < repeats; k++) {
        saltus_branch *branch = NULL;
        const saltus_branch_point *point = NULL;
        const double begin = processor_seconds();
        spent = (effort){0, 0};
        points = special = ruled = 0;
        must(saltus_branch_new(&r->spec, r->periods, r->states[0], &options, &branch, &message), &message);
        for (;;) {
            must(saltus_branch_step(branch, &point, &message), &message);
            if (!point)
                break;
            points++;
            special += point->kind != SALTUS_POINT_REGULAR;
            residual = fmax(residual, point->residual);
            /* At grazing the monodromy matrix is unbounded. */
            const double off = fabs(point->log_volume - point->sum_rule);
            if (point->kind != SALTUS_POINT_GR && !isnan(off)) {
                ruled++;
                sum_rule = fmax(sum_rule, off);
            }
        }
        seconds[k] = processor_seconds() - begin;
        saltus_branch_free(branch);
    }
    gsl_sort(seconds, 1, repeats);
    const double total = gsl_stats_median_from_sorted_data(seconds, 1, repeats), each = (double)points;
    printf("| %g | %ld | %ld | %.2f | %.2f | %.1f | %.1f | %.1e | %.1e (%ld) |\n", step_max, points, special,
           total, 1e3 * total / each, (double)spent.iterations / each, (double)spent.evaluations / each,
           residual, sum_rule, ruled);
}

int main(int count, char **arguments) {
    reference r;
    if (!reference_read(count > 1 ? arguments[1] : "data/reference", "fig7d", &r)) {
        fprintf(stderr, "saltus_branch_bench: cannot read fig7d.json\n");
        return 1;
    }
    printf("**A branch of periodic orbits with multipliers** (fig7d's family, omega = 35 to 56; CPU)\n\n"
           "| largest step | points | special | total, s | per point, ms | Newton steps per point | orbits "
           "computed per point | largest residual | largest error of the sum rule (points) |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
    measure(&r, 0.02);
    measure(&r, 0.006);
    return 0;
}
