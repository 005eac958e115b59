/* saltus_branch_bench: cost and accuracy of a branch of periodic orbits.
 *
 * The family of data/reference/fig7d.json over omega = 35 to 56, continued in both directions, with
 * multipliers and a run of the event-driven flow at every point. Time is CPU time, the median of repeated
 * runs. Newton steps include those of rejected steps and of locating special points. Residual and sum rule
 * are from the same runs. An argument names the folder of the reference.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "clock.h"
#include "reference.h"

#include "saltus/branch.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>

enum { repeats = 3 };

/* One measured run. */
typedef struct measured {
    double seconds;
    long points, special, iterations, evaluations;
    long ruled; /* points with all multipliers resolved */
    double residual, sum_rule;
} measured;

static void count_iteration(void *context, int iteration, double residual, const char *what) {
    measured *m = context;
    (void)residual;
    (void)what;
    m->evaluations++;
    m->iterations += iteration > 0;
}

static bool run(const reference *r, double step_max, measured *m) {
    saltus_branch_options options = saltus_branch_defaults();
    saltus_message message = {.text = ""};
    saltus_branch *branch = NULL;
    const saltus_branch_point *point = NULL;
    *m = (measured){0};
    snprintf(options.key[0], sizeof options.key[0], "omega");
    options.low[0] = 35;
    options.high[0] = 56;
    options.step_max = step_max;
    options.orbit.history = count_iteration;
    options.orbit.context = m;
    double begin = processor_seconds();
    saltus_status status = saltus_branch_new(&r->spec, r->periods, r->states[0], &options, &branch, &message);
    while (status == SALTUS_OK) {
        status = saltus_branch_step(branch, &point, &message);
        if (!point)
            break;
        m->points++;
        m->special += point->kind != SALTUS_POINT_REGULAR;
        m->residual = fmax(m->residual, point->residual);
        /* At grazing the monodromy matrix is unbounded. */
        const double off = fabs(point->log_volume - point->sum_rule);
        if (point->kind != SALTUS_POINT_GR && !isnan(off)) {
            m->ruled++;
            m->sum_rule = fmax(m->sum_rule, off);
        }
    }
    m->seconds = processor_seconds() - begin;
    saltus_branch_free(branch);
    if (status != SALTUS_OK)
        fprintf(stderr, "saltus_branch_bench: %s\n", message.text);
    return status == SALTUS_OK;
}

static bool measure(const reference *r, double step_max) {
    measured m;
    double seconds[repeats];
    for (int k = 0; k < repeats; k++) {
        if (!run(r, step_max, &m))
            return false;
        seconds[k] = m.seconds;
    }
    gsl_sort(seconds, 1, repeats);
    double total = gsl_stats_median_from_sorted_data(seconds, 1, repeats), points = (double)m.points;
    printf("| %g | %ld | %ld | %.2f | %.2f | %.1f | %.1f | %.1e | %.1e (%ld) |\n", step_max, m.points,
           m.special, total, 1e3 * total / points, (double)m.iterations / points,
           (double)m.evaluations / points, m.residual, m.sum_rule, m.ruled);
    return true;
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
    bool measured_all = measure(&r, 0.02) && measure(&r, 0.006);
    free(r.text);
    return measured_all ? 0 : 1;
}
