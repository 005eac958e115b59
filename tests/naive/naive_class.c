/* Classes of the naive method: NOT FOR USE, see naive.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "naive_class.h"

#include <math.h>
#include <stdlib.h>

static const double free_tolerance = 1e-3, least_tolerance = 0.05, most_tolerance = 0.25, jitters = 4;
static const double velocity_unit = 10; /* of velocities, times the scale of displacements */
static const double beyond = 1e3;       /* no pipe gets that far, in units of the scale */
static const double nearly_always = 0.9;

/* Counters at the section points. */
typedef struct watch {
    long long impacts[naive_watched + 1], contacts[naive_watched + 1], held[naive_watched + 1],
        steps[naive_watched + 1];
} watch;

static double distance(const naive_class *class, int a, int b, double scale) {
    return fmax(fabs(class->points[a][0] - class->points[b][0]) / scale,
                fabs(class->points[a][1] - class->points[b][1]) / (velocity_unit * scale));
}

static double recurrence_of(const naive_class *class, int p, double scale) {
    double largest = 0;
    for (int k = p; k <= naive_watched; k++)
        largest = fmax(largest, distance(class, k, k - p, scale));
    return largest;
}

/* Impacts per p periods, if that is a whole number but for one impact that is counted early or late; -1 if
 * not. */
static int count_of(const long long *counter, int p) {
    int cycles = naive_watched / p;
    long long all = counter[cycles * p] - counter[0], n = llround((double)all / cycles);
    return llabs(all - n * cycles) <= 1 ? (int)n : -1;
}

static void find_period(naive_class *class, const watch *w, double tolerance, double scale) {
    for (int p = 1; p <= naive_longest && class->periods == 0; p++) {
        class->recurrence = recurrence_of(class, p, scale);
        int n = count_of(w->impacts, p);
        bool lasting = w->contacts[naive_watched] > w->contacts[0] || class->held;
        if (class->recurrence > tolerance || (n < 0 && !lasting))
            continue;
        class->periods = p;
        class->impacts = lasting ? -1 : n;
    }
}

static void judge(const naive_runner *runner, int lane, const watch *w, double scale, naive_class *class) {
    const naive_tally *tally = &runner->tally[lane];
    double impacts = (double)(w->impacts[naive_watched] - w->impacts[0]);
    double steps = (double)(w->steps[naive_watched] - w->steps[0]);
    double speed = fmax(tally->largest_speed, velocity_unit * scale);
    double jitter = jitters * (1 + runner->pipe.r) * speed * runner->h / scale;
    double tolerance = impacts > 0 ? fmin(fmax(jitter, least_tolerance), most_tolerance) : free_tolerance;
    for (int k = 0; k <= naive_watched; k++)
        class->finite &= fabs(class->points[k][0]) < beyond * scale;
    class->rate = impacts / naive_watched;
    class->contact = (double)(w->held[naive_watched] - w->held[0]) / steps;
    class->held = class->contact >= nearly_always;
    class->speed = tally->largest_speed;
    class->deepest = tally->deepest;
    if (class->finite)
        find_period(class, w, tolerance, scale);
}

static void note(const naive_runner *runner, double time, int k, watch watches[naive_lanes],
                 naive_class classes[naive_lanes]) {
    naive_states states = naive_states_at(runner, time);
    for (int l = 0; l < naive_lanes; l++) {
        watches[l].impacts[k] = runner->tally[l].impacts;
        watches[l].contacts[k] = runner->tally[l].contacts;
        watches[l].held[k] = runner->tally[l].held_steps;
        watches[l].steps[k] = runner->step;
        classes[l].points[k][0] = naive_displacement(&runner->pipe, &states, l);
        classes[l].points[k][1] = naive_velocity(&runner->pipe, &states, l);
    }
}

void naive_classify(const naive_pipe *pipe, double h, bool divides, const double *states, int warm,
                    double scale, naive_class classes[naive_lanes]) {
    naive_runner runner;
    watch watches[naive_lanes];
    const double period = 2 * acos(-1) / pipe->omega;
    naive_begin(&runner, pipe, divides ? period / ceil(period / h) : h);
    for (int l = 0; l < naive_lanes; l++) {
        naive_put(&runner, l, states + (size_t)l * (size_t)(2 * pipe->modes));
        classes[l] = (naive_class){.finite = true};
    }
    naive_run_until(&runner, warm * period);
    for (int l = 0; l < naive_lanes; l++)
        runner.tally[l].largest_speed = 0;
    for (int k = 0; k <= naive_watched; k++) {
        naive_run_until(&runner, (warm + k) * period);
        note(&runner, (warm + k) * period, k, watches, classes);
    }
    for (int l = 0; l < naive_lanes; l++)
        judge(&runner, l, &watches[l], scale, &classes[l]);
}
