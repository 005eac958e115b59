/* saltus_bench: error against cost of one trajectory, Saltus' integrators beside those of other libraries.
 *
 * Every row is measured in the same run on the same machine against the 128-bit orbits of data/reference: the
 * largest error of the impact times (in T), of the state after the orbit (velocities count a hundredth), the
 * median CPU time of repeated runs, and the evaluations of the vector field (for Taylor series: orders). The
 * summary compares times at equal error by interpolation in the logarithms.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "reference.h"
#include "rivals.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>
#include <time.h>

enum { events_max = 512, rows_max = 24, repeats = 15, methods_max = 6 };

/* One measured run. */
typedef struct row {
    double rtol, time_error, state_error, seconds, evaluations;
    bool done;
} row;

static double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double median(double *values, size_t count) {
    gsl_sort(values, 1, count);
    return gsl_stats_median_from_sorted_data(values, 1, count);
}

/* Errors of impact times in order, as far as the reference lists them; a missing impact is an error of a
 * period. */
static double impact_error(const reference *r, const double *times, int count) {
    double worst = 0;
    int k = 0;
    for (int e = 0; e < r->event_count; e++)
        if (r->kind[e] == 'i') {
            worst = fmax(worst, k < count ? fabs(times[k] - r->time[e]) : 1);
            k++;
        }
    return worst;
}

static bool run_saltus(const reference *r, const saltus_system *system, saltus_integrator integrator,
                       double rtol, row *out) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {""};
    saltus_flow *flow = NULL;
    saltus_event event;
    double times[events_max], state[SALTUS_SCENE_STATE_MAX], seconds[repeats];
    int count = 0;
    options.rtol = rtol;
    options.atol = 1e-3 * rtol;
    options.integrator = integrator;
    if (saltus_flow_new(&system, 1, &options, &flow, &message) != SALTUS_OK)
        return false;
    for (int k = 0; k < repeats; k++) {
        enum { batch = 20 };
        double start = cpu_seconds();
        for (int b = 0; b < batch; b++) {
            count = 0;
            saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, r->states[0], &message);
            do {
                if (status == SALTUS_OK)
                    status = saltus_flow_advance(flow, (saltus_time){r->periods, 0}, SALTUS_WATCH_IMPACT,
                                                 &event, &message);
                if (status != SALTUS_OK) {
                    saltus_flow_free(flow);
                    return false;
                }
                if (event.kind == SALTUS_IMPACT && count < events_max)
                    times[count++] = saltus_time_periods(event.time);
            } while (event.kind != SALTUS_REACHED);
        }
        seconds[k] = (cpu_seconds() - start) / batch;
    }
    saltus_flow_state(flow, 0, state);
    *out = (row){.rtol = rtol,
                 .time_error = impact_error(r, times, count),
                 .state_error = reference_distance(r, state, 0),
                 .seconds = median(seconds, repeats),
                 .evaluations = (double)saltus_flow_information(flow, 0).field_evaluations,
                 .done = true};
    saltus_flow_free(flow);
    return true;
}

static bool run_rival(const reference *r, const rival *method, double rtol, row *out) {
    const double *p = r->spec.parameters;
    const saltus_stop *stop = &r->spec.stops[0];
    rival_pipe pipe = {.modes = (int)p[0],
                       .alpha = p[1],
                       .beta = p[2],
                       .kappa = p[3],
                       .u0 = p[4],
                       .sigma = p[5],
                       .omega = p[6],
                       .xi = stop->xi,
                       .d = stop->d,
                       .r = stop->r};
    rival_event events[events_max];
    double times[events_max], state[16], seconds[repeats];
    rival_result result = {.events = events, .capacity = events_max, .state = state};
    for (int k = 0; k < repeats; k++) {
        result.count = 0;
        if (method->run(&pipe, r->states[0], r->periods, rtol, rtol, &result) != RIVAL_OK)
            return false;
        seconds[k] = result.cpu_seconds;
    }
    int count = 0;
    for (int k = 0; k < result.count && k < events_max; k++)
        if (events[k].kind == RIVAL_IMPACT)
            times[count++] = events[k].time_over_T;
    *out = (row){.rtol = rtol,
                 .time_error = impact_error(r, times, count),
                 .state_error = reference_distance(r, state, 0),
                 .seconds = median(seconds, repeats),
                 .evaluations = (double)result.field_evaluations,
                 .done = true};
    return true;
}

/* Time at which a method reaches an error, interpolated between the two measured rows around it; NaN outside.
 */
static double time_at_error(const row *rows, int count, double error) {
    for (int k = 0; k + 1 < count; k++) {
        if (!rows[k].done || !rows[k + 1].done || rows[k].time_error < error ||
            rows[k + 1].time_error > error)
            continue;
        double a = log(rows[k].time_error), b = log(rows[k + 1].time_error);
        double w = a == b ? 0 : (log(error) - a) / (b - a);
        return exp((1 - w) * log(rows[k].seconds) + w * log(rows[k + 1].seconds));
    }
    return NAN;
}

/* Every measured row. */
static void print_rows(const char *name, const row *rows, int count) {
    for (int k = 0; k < count; k++)
        if (rows[k].done)
            printf("| %s | %.0e | %.1e | %.1e | %.1f | %.0f |\n", name, rows[k].rtol, rows[k].time_error,
                   rows[k].state_error, 1e6 * rows[k].seconds, rows[k].evaluations);
}

static void print_all(const char *const *names, row (*rows)[rows_max], int methods, int count) {
    printf("| method | rtol | event error / T | state error | CPU us | evaluations |\n"
           "| --- | --- | --- | --- | --- | --- |\n");
    for (int m = 0; m < methods; m++)
        print_rows(names[m], rows[m], count);
}

/* Event error and time at a few tolerances, a line a method. */
static void print_overview(const char *const *names, row (*rows)[rows_max], int methods, int count) {
    enum { first = 2, step = 2, last = 8 };
    printf("| event error in CPU time |");
    for (int k = first; k <= last && k < count; k += step)
        printf(" rtol %.0e |", rows[0][k].rtol);
    printf("\n| --- |");
    for (int k = first; k <= last && k < count; k += step)
        printf(" --- |");
    for (int m = 0; m < methods; m++) {
        printf("\n| %s |", names[m]);
        for (int k = first; k <= last && k < count; k += step)
            if (!rows[m][k].done)
                printf(" failed |");
            else if (rows[m][k].time_error < 0.5)
                printf(" %.1e T in %.0f us |", rows[m][k].time_error, 1e6 * rows[m][k].seconds);
            else
                printf(" impacts missing, %.0f us |", 1e6 * rows[m][k].seconds);
    }
    printf("\n");
}

static void print_summary(const char *const *names, row (*rows)[rows_max], int methods, int count) {
    static const double errors[] = {1e-6, 1e-8, 1e-9, 1e-10, 1e-12};
    printf("\n| time at equal event error |");
    for (size_t e = 0; e < sizeof errors / sizeof errors[0]; e++)
        printf(" %.0e T |", errors[e]);
    printf("\n| --- |");
    for (size_t e = 0; e < sizeof errors / sizeof errors[0]; e++)
        printf(" --- |");
    for (int m = 0; m < methods; m++) {
        printf("\n| %s |", names[m]);
        for (size_t e = 0; e < sizeof errors / sizeof errors[0]; e++) {
            double own = time_at_error(rows[0], count, errors[e]),
                   time = time_at_error(rows[m], count, errors[e]);
            if (isnan(time))
                printf(" - |");
            else
                printf(" %.1f us (%.1f x) |", 1e6 * time, time / own);
        }
    }
    printf("\n");
}

static bool compare(const char *folder, const char *name, bool all) {
    static row rows[methods_max][rows_max];
    const char *names[methods_max] = {"Saltus Taylor", "Saltus Radau"};
    reference r;
    saltus_system *system = NULL;
    saltus_message message = {""};
    int methods = 2, count = 0;
    if (!reference_read(folder, name, &r) || saltus_system_new(&r.spec, &system, &message) != SALTUS_OK) {
        fprintf(stderr, "saltus_bench: %s/%s.json cannot be read as a reference orbit\n", folder, name);
        return false;
    }
    printf("\n**%s** (%s, %d T)\n\n", name, r.label, r.periods);
    for (int digits = 4; digits <= 14; digits++, count++) {
        double rtol = pow(10, -digits);
        memset(&rows[0][count], 0, sizeof rows[0][count]);
        memset(&rows[1][count], 0, sizeof rows[1][count]);
        run_saltus(&r, system, SALTUS_TAYLOR, rtol, &rows[0][count]);
        run_saltus(&r, system, SALTUS_RADAU, rtol, &rows[1][count]);
        for (int m = 0; m < saltus_rival_count && m + 2 < methods_max; m++) {
            names[m + 2] = saltus_rivals[m].name;
            rows[m + 2][count].done = false;
            run_rival(&r, &saltus_rivals[m], rtol, &rows[m + 2][count]);
            methods = m + 3;
        }
    }
    (all ? print_all : print_overview)(names, rows, methods, count);
    print_summary(names, rows, methods, count);
    saltus_system_free(system);
    free(r.text);
    return true;
}

/* Median CPU time of one forcing period after the transient at omega = 42, with a stop at d = 0.035 or
 * without, and the impacts per period. */
static double period_cost(int modes, bool stop, double *impacts) {
    enum { settle = 100, measured = 40, runs = 5 };
    saltus_spec spec = saltus_spec_defaults(saltus_model_find("pipe"));
    saltus_system *system = NULL;
    saltus_message message = {""};
    saltus_flow *flow = NULL;
    saltus_event event;
    saltus_flow_options options = saltus_flow_defaults();
    double state[SALTUS_SCENE_STATE_MAX], seconds[runs];
    spec.parameters[0] = modes;
    spec.stops[0] = saltus_stop_defaults();
    spec.stops[0].d = 0.035;
    spec.stop_count = stop;
    bool ready =
        saltus_system_new(&spec, &system, &message) == SALTUS_OK &&
        saltus_system_default_state(system, state, &message) == SALTUS_OK &&
        saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message) == SALTUS_OK &&
        saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, &message) == SALTUS_OK &&
        saltus_flow_advance(flow, (saltus_time){settle, 0}, 0, &event, &message) == SALTUS_OK;
    long long before = ready ? saltus_flow_information(flow, 0).impacts : 0;
    for (int k = 0; k < runs && ready; k++) {
        double start = cpu_seconds();
        ready = saltus_flow_advance(flow, (saltus_time){settle + measured * (k + 1), 0}, 0, &event,
                                    &message) == SALTUS_OK;
        seconds[k] = (cpu_seconds() - start) / measured;
    }
    if (ready)
        *impacts = (double)(saltus_flow_information(flow, 0).impacts - before) / (runs * measured);
    else
        fprintf(stderr, "saltus_bench: N = %d: %s\n", modes, message.text);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return ready ? median(seconds, runs) : NAN;
}

static void scale_with_modes(void) {
    static const int modes[] = {5, 10, 20, 32};
    double base[2] = {0, 0};
    printf("\n**Cost per forcing period against the number of modes** (omega = 42, rtol 1e-13; CPU us)\n\n"
           "| N | (N/5)^2.5 | no stop | ratio | stop at d = 0.035 | ratio | impacts per period |\n"
           "| --- | --- | --- | --- | --- | --- | --- |\n");
    for (size_t k = 0; k < sizeof modes / sizeof modes[0]; k++) {
        double impacts[2] = {0, 0}, seconds[2];
        for (int stop = 0; stop < 2; stop++) {
            seconds[stop] = period_cost(modes[k], stop, &impacts[stop]);
            if (k == 0)
                base[stop] = seconds[stop];
        }
        printf("| %d | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f |\n", modes[k], pow(modes[k] / 5.0, 2.5),
               1e6 * seconds[0], seconds[0] / base[0], 1e6 * seconds[1], seconds[1] / base[1], impacts[1]);
    }
}

int main(int count, char **arguments) {
    const char *folder = "data/reference";
    bool all = false;
    for (int k = 1; k < count; k++)
        if (strcmp(arguments[k], "--all") == 0)
            all = true;
        else
            folder = arguments[k];
    if (!compare(folder, "fig7d", all) || !compare(folder, "chatter25", all))
        return 1;
    scale_with_modes();
    return 0;
}
