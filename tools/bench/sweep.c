/* saltus_sweep_bench: the sweep of Figure 6 in omega, by Saltus and by other libraries' integrators.
 *
 * 1,000 values of omega in [0.5, 55], each from the default state, 300 periods to settle and 100 recorded,
 * impact times wanted to 1e-8 T. Every program runs at the tolerance at which its event error is that: the
 * 90th percentile, over the omegas whose motion is periodic, of the largest difference of the impacts' times
 * in the motion's last period from Saltus' at rtol 1e-13 (--calibrate shows how the tolerances were found).
 * Times are the CPU's, wall time stands beside them.
 *
 * An omega counts as periodic where two runs with tight tolerances settle to the same motion before the
 * recorded periods begin. A program has the right count there if it finds as many impacts as these runs.
 * Where it does not, it may have been led to another motion by its transient, which is chaotic for many
 * omegas: it then goes on from its own settled state period by period, and each of its counts is compared
 * with that of Saltus at rtol 1e-13 from the same state. Only where these differ has an impact been lost or
 * invented.
 *
 * Options: --rivals adds the other libraries, on every k-th omega only with --part k (their times are then
 * scaled by the time simulated); --check compares all counts with those of steps of at most 1e-3 at rtol
 * 1e-13, on every k-th omega; --calibrate.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "peak.h"
#include "sweep_own.h"
#include "sweep_rivals.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { omegas_max = 1000, own_repeats = 3, rows_max = 16, rival_events_max = 1 << 20 };

static const double own_tolerance = 5e-8, exact = 1e-13, more_exact = 3e-14;
/* In the scale of the states: what settled motions repeat to. */
static const double settled_to = 1e-8;
static const double capped_step = 1e-3;

/* The omegas of this run, and the motions that all programs are compared with. */
typedef struct sweep {
    int count;
    saltus_system *stopped[omegas_max], *unstopped[omegas_max];
    motion reference[omegas_max], found[omegas_max];
    int period[omegas_max]; /* 0: not periodic, or not the same in both tight runs */
    int periodic;
    int part;            /* rivals take every part-th omega */
    rival_event *events; /* room for a rival's */
} sweep;

/* A program of the table: another library's integrator (atol is as large as rtol), or Saltus where `run` is
 * NULL. */
typedef struct program {
    const char *name;
    rival_run run;
    double tolerance;
    own_request request;
    bool stopped;
} program;

/* A line of the table. */
typedef struct row {
    const program *program;
    sweep_cost cost;
    double share;                        /* of the simulated time that was measured */
    double median, high, worst;          /* event error in T */
    int right, elsewhere, wrong, judged; /* omegas by their count of impacts, where there was one */
} row;

static saltus_status build(sweep *s, int part, saltus_message *message) {
    saltus_scene scene;
    saltus_status status = saltus_scene_load("fig6", &scene, message);
    for (int k = 0; k < omegas_max && status == SALTUS_OK; k += part, s->count++) {
        char assignment[64];
        snprintf(assignment, sizeof assignment, "omega=%.17g", 0.5 + 54.5 * k / (omegas_max - 1));
        status = saltus_scene_set(&scene, assignment, message);
        if (status == SALTUS_OK)
            status = saltus_system_new(&scene.spec, &s->stopped[s->count], message);
        saltus_spec unstopped = scene.spec;
        unstopped.stop_count = 0;
        if (status == SALTUS_OK)
            status = saltus_system_new(&unstopped, &s->unstopped[s->count], message);
    }
    s->events = malloc(rival_events_max * sizeof *s->events);
    return status == SALTUS_OK && !s->events ? SALTUS_NO_MEMORY : status;
}

static void tear_down(sweep *s) {
    for (int k = 0; k < s->count; k++) {
        saltus_system_free(s->stopped[k]);
        saltus_system_free(s->unstopped[k]);
        motion_free(&s->reference[k]);
        motion_free(&s->found[k]);
    }
    free(s->events);
}

static bool with_strobe(motion *motions, int count) {
    for (int k = 0; k < count; k++)
        if (!(motions[k].strobe = malloc((recorded_periods + 1) * sizeof *motions[k].strobe)))
            return false;
    return true;
}

/* The motions to compare with, and which of them are periodic. */
static saltus_status make_reference(sweep *s, saltus_message *message) {
    own_request request = {.lanes = saltus_flow_width(s->stopped[0]),
                           .threads = 1,
                           .rtol = exact,
                           .impacts = true,
                           .strobe = true};
    sweep_cost cost;
    if (!with_strobe(s->reference, s->count) || !with_strobe(s->found, s->count))
        return SALTUS_NO_MEMORY;
    saltus_status status = own_sweep(s->stopped, s->count, &request, s->reference, &cost, message);
    request.rtol = more_exact;
    if (status == SALTUS_OK)
        status = own_sweep(s->stopped, s->count, &request, s->found, &cost, message);
    for (int k = 0; k < s->count && status == SALTUS_OK; k++) {
        const double *scale = saltus_system_scale(s->stopped[k]);
        double error;
        const int period = motion_period(&s->reference[k], scale, settled_to);
        if (period > 0 && motion_period(&s->found[k], scale, settled_to) == period &&
            motion_agrees(&s->reference[k], period, &s->found[k], &error))
            s->period[k] = period;
        s->periodic += s->period[k] > 0;
    }
    return status;
}

static rival_pipe pipe_of(const saltus_system *system) {
    const saltus_spec *spec = saltus_system_spec(system);
    const saltus_stop *stop = &spec->stops[0];
    return (rival_pipe){.modes = (int)saltus_spec_get(spec, "N"),
                        .alpha = saltus_spec_get(spec, "alpha"),
                        .beta = saltus_spec_get(spec, "beta"),
                        .kappa = saltus_spec_get(spec, "kappa"),
                        .u0 = saltus_spec_get(spec, "u0"),
                        .sigma = saltus_spec_get(spec, "sigma"),
                        .omega = saltus_spec_get(spec, "omega"),
                        .xi = stop->xi,
                        .d = stop->d,
                        .r = stop->r};
}

/* One period of a program's motion. */
static bool one_period(sweep *s, const program *p, const saltus_system *system, const double *state,
                       double *end, int *impacts) {
    if (!p->run)
        return own_period(system, &p->request, state, end, impacts, NULL) == SALTUS_OK;
    const rival_pipe pipe = pipe_of(system);
    rival_result result = {.events = s->events, .capacity = rival_events_max, .state = end};
    const bool done = p->run(&pipe, state, 1, p->tolerance, p->tolerance, &result) == RIVAL_OK;
    *impacts = 0;
    for (int k = 0; k < result.count && k < result.capacity; k++)
        *impacts += s->events[k].kind == RIVAL_IMPACT;
    return done;
}

/* Whether a program, on its way from its own settled state, counts every period as exact integration does. */
static bool counts_its_own(sweep *s, const program *p, int omega) {
    const own_request request = {.rtol = exact};
    double state[motion_dimension], next[motion_dimension], exact_next[motion_dimension];
    memcpy(state, s->found[omega].settled, sizeof state);
    for (int k = 0; k < recorded_periods; k++) {
        int impacts, exact_impacts;
        if (!one_period(s, p, s->stopped[omega], state, next, &impacts) ||
            own_period(s->stopped[omega], &request, state, exact_next, &exact_impacts, NULL) != SALTUS_OK ||
            impacts != exact_impacts)
            return false;
        memcpy(state, next, sizeof state);
    }
    return true;
}

/* Fills a row's errors and counts from the motions found. */
static void judge(sweep *s, const program *p, row *r) {
    static double errors[omegas_max];
    size_t count = 0;
    r->judged = 0;
    for (int k = 0; k < s->count; k += p->run ? s->part : 1) {
        double error = NAN;
        if (s->period[k] == 0)
            continue;
        r->judged++;
        if (motion_agrees(&s->reference[k], s->period[k], &s->found[k], &error))
            r->right++;
        else if (counts_its_own(s, p, k))
            r->elsewhere++;
        else
            r->wrong++;
        if (!isnan(error))
            errors[count++] = error;
    }
    if (count == 0)
        return;
    gsl_sort(errors, 1, count);
    r->median = gsl_stats_quantile_from_sorted_data(errors, 1, count, 0.5);
    r->high = gsl_stats_quantile_from_sorted_data(errors, 1, count, 0.9);
    r->worst = errors[count - 1];
}

static bool run_own(sweep *s, const program *p, int repeats, row *r) {
    saltus_message message = {""};
    r->cost.seconds = r->cost.wall = INFINITY;
    for (int k = 0; k < repeats; k++) {
        sweep_cost cost;
        if (own_sweep(p->stopped ? s->stopped : s->unstopped, s->count, &p->request, s->found, &cost,
                      &message) != SALTUS_OK) {
            fprintf(stderr, "saltus_sweep_bench: %s: %s\n", p->name, message.text);
            return false;
        }
        cost.seconds = fmin(cost.seconds, r->cost.seconds);
        cost.wall = fmin(cost.wall, r->cost.wall);
        r->cost = cost;
    }
    return true;
}

static void keep_recorded(const rival_result *result, motion *m) {
    for (int k = 0; k < result->count && k < result->capacity; k++) {
        const rival_event *e = &result->events[k];
        if (e->kind == RIVAL_IMPACT)
            motion_add_impact(m, e->time_over_T, e->normal_velocity);
        m->sticks += e->kind == RIVAL_STICK;
    }
    m->failed = m->failed || result->count > result->capacity;
}

/* The forcing is periodic, so that the recorded periods may begin at time 0 again. */
static void run_rival(sweep *s, const program *p, row *r) {
    double start[SALTUS_SCENE_STATE_MAX], end[motion_dimension], simulated = 0, all = 0;
    for (int k = 0; k < s->count; k++)
        all += saltus_system_period(s->stopped[k]);
    for (int k = 0; k < s->count; k += s->part) {
        simulated += saltus_system_period(s->stopped[k]);
        const rival_pipe pipe = pipe_of(s->stopped[k]);
        const int periods[2] = {settling_periods, recorded_periods};
        motion *m = &s->found[k];
        motion_clear(m);
        saltus_system_default_state(s->stopped[k], start, NULL);
        memcpy(m->settled, start, sizeof m->settled);
        for (int stage = 0; stage < 2; stage++) {
            rival_result result = {
                .events = s->events, .capacity = stage ? rival_events_max : 0, .state = stage ? end : start};
            memcpy(end, m->settled, sizeof end);
            m->failed |= p->run(&pipe, end, periods[stage], p->tolerance, p->tolerance, &result) != RIVAL_OK;
            if (stage)
                keep_recorded(&result, m);
            else
                memcpy(m->settled, start, sizeof m->settled);
            r->cost.seconds += result.cpu_seconds;
            r->cost.steps += result.steps;
            r->cost.evaluations += result.field_evaluations;
        }
    }
    r->share = simulated / all;
    r->cost.seconds /= r->share;
    r->cost.wall = r->cost.seconds;
}

/* Saltus' own time is the shortest of `repeats` runs. */
static bool measure(sweep *s, const program *p, int repeats, row *r) {
    *r = (row){.program = p, .judged = -1, .share = 1, .median = NAN, .high = NAN, .worst = NAN};
    if (p->run)
        run_rival(s, p, r);
    else if (!run_own(s, p, repeats, r))
        return false;
    if (p->stopped && (p->run || p->request.impacts))
        judge(s, p, r);
    return true;
}

static void print_head(void) {
    printf(
        "| program | rtol | CPU s | wall s | ratio | event error / T: median | 90 %% | max | right counts | "
        "elsewhere | wrong | steps | evaluations |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
}

static void print_row(const row *r, double own_seconds) {
    printf("| %s | %.1e | %.3f | %.3f | %.2f |", r->program->name, r->program->tolerance, r->cost.seconds,
           r->cost.wall, r->cost.seconds / own_seconds);
    if (r->judged >= 0)
        printf(" %.1e | %.1e | %.1e | %d of %d | %d | %d |", r->median, r->high, r->worst, r->right,
               r->judged, r->elsewhere, r->wrong);
    else
        printf(" - | - | - | - | - | - |");
    printf(" %.3g | %.3g |\n", (double)r->cost.steps / r->share, (double)r->cost.evaluations / r->share);
    fflush(stdout);
}

static program own_program(const char *name, int lanes, int threads, bool stopped, bool impacts) {
    return (program){
        .name = name,
        .tolerance = own_tolerance,
        .stopped = stopped,
        .request = {.lanes = lanes, .threads = threads, .rtol = own_tolerance, .impacts = impacts}};
}

/* The rivals' tolerances are those at which --calibrate shows the event error wanted. */
static int list_rivals(program *list) {
    int count = 0;
#ifdef SALTUS_WITH_ODEINT
    list[count++] =
        (program){.name = "Odeint dopri5, dense output", .run = sweep_odeint_dopri5, .tolerance = 3.7e-9};
    list[count++] =
        (program){.name = "Odeint Fehlberg 7(8)", .run = sweep_odeint_fehlberg78, .tolerance = 6.5e-9};
#endif
    for (int k = 0; k < saltus_rival_count; k++)
        if (strstr(saltus_rivals[k].name, "GSL"))
            list[count++] = (program){.name = "GSL rk8pd", .run = saltus_rivals[k].run, .tolerance = 3.2e-8};
        else if (strstr(saltus_rivals[k].name, "ARKODE"))
            list[count++] =
                (program){.name = "SUNDIALS ARKODE 8(7)", .run = saltus_rivals[k].run, .tolerance = 2.5e-8};
    for (int k = 0; k < count; k++)
        list[k].stopped = true;
    return count;
}

static bool calibrate(sweep *s) {
    program list[rows_max];
    row r;
    list[0] = own_program("Saltus, all lanes", saltus_flow_width(s->stopped[0]), 1, true, true);
    const int count = 1 + list_rivals(list + 1);
    print_head();
    for (int k = 0; k < count; k++)
        for (double digits = 7; digits < 9.1; digits += 0.5) {
            list[k].tolerance = list[k].request.rtol = pow(10, -digits);
            if (!measure(s, &list[k], 1, &r))
                return false;
            print_row(&r, 1);
        }
    return true;
}

/* Every count of impacts at the benchmark's tolerance against steps too short to jump over anything. */
static bool check(sweep *s) {
    const int lanes = saltus_flow_width(s->stopped[0]);
    const own_request capped = {
        .lanes = lanes, .threads = 1, .rtol = exact, .impacts = true, .step_max = capped_step};
    const program own = own_program("Saltus, all lanes", lanes, 1, true, true);
    saltus_message message = {""};
    sweep_cost cost;
    row r;
    if (own_sweep(s->stopped, s->count, &capped, s->reference, &cost, &message) != SALTUS_OK) {
        fprintf(stderr, "saltus_sweep_bench: steps of at most %g: %s\n", capped_step, message.text);
        return false;
    }
    if (!measure(s, &own, 1, &r))
        return false;
    printf("Counts of impacts at rtol %.1e against rtol %.0e with steps of at most %g: of %d periodic omegas "
           "%d right, %d on another motion with every impact confirmed, %d wrong.\n",
           own_tolerance, exact, capped_step, r.judged, r.right, r.elsewhere, r.wrong);
    return r.wrong == 0;
}

static bool compare(sweep *s, bool rivals) {
    const int lanes = saltus_flow_width(s->stopped[0]);
    program list[rows_max] = {own_program("Saltus, all lanes", lanes, 1, true, true),
                              own_program("Saltus, one lane", 1, 1, true, true),
                              own_program("Saltus, all lanes, two threads", lanes, 2, true, true),
                              own_program("Saltus, all lanes, no stop", lanes, 1, false, true),
                              own_program("Saltus, all lanes, counts only", lanes, 1, true, false)};
    enum { own_rows = 5 };
    row rows[rows_max] = {{0}};
    const char *instructions;
    const int count = own_rows + (rivals ? list_rivals(list + own_rows) : 0);
    int best = -1;
    print_head();
    for (int k = 0; k < count; k++) {
        if (!measure(s, &list[k], own_repeats, &rows[k]))
            return false;
        print_row(&rows[k], rows[0].cost.seconds);
        if (k >= own_rows && (best < 0 || rows[k].cost.seconds < rows[best].cost.seconds))
            best = k;
    }
    const double seconds = rows[0].cost.seconds, peak = bench_peak(&instructions);
    printf(
        "\n%d lanes take 1/%.2f of the time of one lane; two threads 1/%.2f of the wall time of one; without "
        "a stop %.2f of the time with it; counts alone %.2f of the time of impacts.\n",
        lanes, rows[1].cost.seconds / seconds, rows[0].cost.wall / rows[2].cost.wall,
        rows[3].cost.seconds / seconds, rows[4].cost.seconds / seconds);
    if (best >= 0)
        printf("The fastest of the other libraries, %s, takes %.2f times as long as Saltus on one core.\n",
               list[best].name, rows[best].cost.seconds / seconds);
    printf("Peak of this core (%s): %.1f GFlop/s.\n", instructions, 1e-9 * peak);
    return true;
}

int main(int count, char **arguments) {
    static sweep s;
    saltus_message message = {""};
    int part = 4;
    bool rivals = false, checking = false, calibrating = false;
    for (int k = 1; k < count; k++)
        if (strcmp(arguments[k], "--part") == 0 && k + 1 < count && atoi(arguments[k + 1]) > 0) {
            part = atoi(arguments[++k]);
        } else if (strcmp(arguments[k], "--rivals") == 0) {
            rivals = true;
        } else if (strcmp(arguments[k], "--check") == 0) {
            checking = true;
        } else if (strcmp(arguments[k], "--calibrate") == 0) {
            calibrating = true;
        } else {
            fprintf(stderr, "usage: saltus_sweep_bench [--part k] [--rivals] [--check] [--calibrate]\n");
            return 2;
        }
    s.part = checking ? 1 : part;
    saltus_status status = build(&s, checking ? part : 1, &message);
    if (status == SALTUS_OK)
        status = make_reference(&s, &message);
    if (status != SALTUS_OK) {
        fprintf(stderr, "saltus_sweep_bench: %s\n", message.text);
        tear_down(&s);
        return 1;
    }
    printf("%d of %d omegas, %d of them with a periodic motion", s.count, omegas_max, s.periodic);
    if (s.part > 1 && (rivals || calibrating))
        printf("; other libraries on every %dth, times and counts of work scaled by the time simulated",
               s.part);
    printf(".\n\n");
    const bool done = calibrating ? calibrate(&s) : checking ? check(&s) : compare(&s, rivals);
    tear_down(&s);
    return done ? 0 : 1;
}
