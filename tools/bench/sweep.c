/* saltus_sweep_bench: the sweep of Figure 6 in omega, by Saltus and by other libraries' integrators.
 *
 * 1,000 values of omega in [0.5, 55], each from the default state: 300 periods to settle, then 100 recorded,
 * with impact times to be accurate to 1e-8 T. Every program runs at the tolerance at which its event error
 * has that size: the 90th percentile, over the omegas with periodic motion, of the largest difference between
 * its impact times in the last period and those of Saltus at rtol 1e-13 (--calibrate shows how the tolerances
 * were found). CPU times are given, with wall times beside them.
 *
 * An omega counts as periodic if two runs with tight tolerances settle to the same motion before the recorded
 * periods begin. There a program is right if it finds as many impacts as these runs. Otherwise its transient,
 * chaotic for many omegas, may have led it to another motion: it then continues from its own settled state
 * period by period, and each count is compared with that of Saltus at rtol 1e-13 from the same state. Only if
 * these differ has an impact been lost or invented.
 *
 * Saltus takes part twice: as its flow, which does exactly the work of the other libraries, and as its
 * sweeps, which also determine the motion (n/p) and its measures. A second table shows the cost of optional
 * results of a sweep.
 *
 * Options: --rivals adds the other libraries, with --part k only on every k-th omega (their times are then
 * scaled by the simulated time); --check compares all counts with runs at rtol 1e-13 with steps of at most
 * 1e-3, on every k-th omega; --calibrate, with --rivals also for the other libraries.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep.h"

#include <limits.h>
#include <math.h>
#include <string.h>

const char program_name[] = "saltus_sweep_bench";

enum { own_repeats = 3, rows_max = 16 };

/* Of Saltus: that of the comparison, and the usual one. */
#define OWN_TOLERANCE 5e-8
#define USUAL_TOLERANCE 1e-10
static const double capped_step = 1e-3;

/* Reference times in seconds for the ratios of the first table. */
typedef struct measures {
    double flow, engine;
} measures;

static void print_head(void) {
    printf("| program | rtol | CPU s | wall s | / flow | / sweep | event error / T: median | 90 %% | max | "
           "right counts | elsewhere | wrong | steps | evaluations |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
}

static void print_judgement(const row *r) {
    if (r->judged >= 0)
        printf(" %.1e | %.1e | %.1e | %d of %d | %d | %d |", r->median, r->high, r->worst, r->right,
               r->judged, r->elsewhere, r->wrong);
    else
        printf(" - | - | - | - | - | - |");
}

static void print_row(const row *r, measures unit) {
    printf("| %s | %.1e | %.3f | %.3f | %.2f | %.2f |", r->program->name, r->program->rtol, r->cost.seconds,
           r->cost.wall, r->cost.seconds / unit.flow, r->cost.seconds / unit.engine);
    print_judgement(r);
    if (r->cost.steps > 0)
        printf(" %.3g | %.3g |\n", (double)r->cost.steps / r->cost.share,
               (double)r->cost.evaluations / r->cost.share);
    else
        printf(" - | - |\n");
    fflush(stdout);
}

/* The rivals that are built in, at the tolerances that reach the required event error according to
 * --calibrate. */
static int list_rivals(program *list) {
    static const struct {
        const char *key, *name;
        double rtol;
    } chosen[] = {{"dopri5", "Odeint dopri5, dense output", 3.7e-9},
                  {"fehlberg78", "Odeint Fehlberg 7(8)", 6.5e-9},
                  {"gsl", "GSL rk8pd", 3.2e-8},
                  {"arkode", "SUNDIALS ARKODE 8(7)", 2.5e-8}};
    int count = 0;
    for (size_t c = 0; c < sizeof chosen / sizeof chosen[0]; c++)
        for (int k = 0; k < saltus_rival_count; k++)
            if (strcmp(saltus_rivals[k].key, chosen[c].key) == 0)
                list[count++] =
                    (program){chosen[c].name, program_rival, chosen[c].rtol, .rival = &saltus_rivals[k]};
    return count;
}

enum { every_cloud = SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC };

/* The library's sweeps. */
static const program engines[] = {
    {"impacts kept, all lanes", program_engine, OWN_TOLERANCE, .threads = 1, .keep = SALTUS_KEEP_IMPACTS},
    {"one lane", program_engine, OWN_TOLERANCE, .lanes = 1, .threads = 1, .keep = SALTUS_KEEP_IMPACTS},
    {"two threads", program_engine, OWN_TOLERANCE, .threads = 2, .keep = SALTUS_KEEP_IMPACTS},
    {"without the stop", program_engine, OWN_TOLERANCE, .unstopped = true, .threads = 1,
     .keep = SALTUS_KEEP_IMPACTS},
    {"nothing kept: class and measures", program_engine, OWN_TOLERANCE, .threads = 1},
    {"turning points, impacts, section points kept", program_engine, OWN_TOLERANCE, .threads = 1,
     .keep = every_cloud},
    {"adaptive, class and measures", program_engine, OWN_TOLERANCE, .threads = 1, .adaptive = true},
    {"default tolerance, all clouds", program_engine, USUAL_TOLERANCE, .threads = 1, .keep = every_cloud},
    {"default tolerance, adaptive, class and measures", program_engine, USUAL_TOLERANCE, .threads = 1,
     .adaptive = true}};
enum { engine_count = sizeof engines / sizeof engines[0] };

/* Every program at several tolerances. */
static void calibrate(sweep *s, bool rivals) {
    static const int orders[] = {0, 8, 9, 10, 12};
    enum { own = sizeof orders / sizeof *orders };
    program list[own + rows_max];
    char names[own][32];
    const int lanes = saltus_flow_width(s->stopped[0], SALTUS_AUTOMATIC, LLONG_MAX);
    for (int k = 0; k < own; k++) {
        snprintf(names[k], sizeof names[k], orders[k] ? "Saltus, order %d" : "Saltus, automatic", orders[k]);
        list[k] = (program){names[k], program_flow, .lanes = lanes, .order = orders[k]};
    }
    const int count = own + (rivals ? list_rivals(list + own) : 0);
    print_head();
    for (int k = 0; k < count; k++) {
        const double first = k < own ? 6.5 : 7, spacing = k < own ? 0.25 : 0.5;
        for (double digits = first; digits < first + 2.01; digits += spacing) {
            row r;
            list[k].rtol = pow(10, -digits);
            sweep_measure(s, &list[k], 1, k < own ? own_repeats : 1, &r);
            print_row(&r, (measures){1, 1});
        }
    }
}

/* Compare every count of impacts at the benchmark's tolerance with runs whose steps are too short to miss an
 * impact. */
static bool check(sweep *s) {
    const int lanes = saltus_flow_width(s->stopped[0], SALTUS_AUTOMATIC, LLONG_MAX);
    const program capped = {.rtol = exact, .lanes = lanes, .step_max = capped_step};
    program list[] = {{"flow", program_flow, OWN_TOLERANCE, .lanes = lanes}, engines[0]};
    const bool all = s->count == omegas_max;
    int wrong = 0;
    own_sweep(s->stopped, s->count, &capped, s->reference);
    list[1].name = "sweep";
    for (int k = 0; k < (all ? 2 : 1); k++) {
        row r;
        sweep_measure(s, &list[k], 1, 1, &r);
        printf("Counts of impacts, %s at rtol %.1e against rtol %.0e with steps of at most %g: of %d "
               "periodic omegas %d right, %d on another motion with every impact confirmed, %d wrong.\n",
               list[k].name, OWN_TOLERANCE, exact, capped_step, r.judged, r.right, r.elsewhere, r.wrong);
        wrong += r.wrong;
    }
    return wrong == 0;
}

/* The first table. Ratios refer to the first rows of the flow and of the sweeps. */
static void table_of_programs(sweep *s, bool rivals, int lanes, const row *flows, int flow_count,
                              const row *sweeps) {
    program others[rows_max], own = *sweeps->program;
    row other[rows_max], beside = *sweeps;
    const int count = rivals ? list_rivals(others) : 0;
    const measures unit = {flows->cost.seconds, sweeps->cost.seconds};
    const row *best = other;
    own.name = "Saltus sweep, impacts kept, all lanes";
    beside.program = &own;
    print_head();
    for (int k = 0; k < flow_count; k++)
        print_row(&flows[k], unit);
    print_row(&beside, unit);
    for (int k = 0; k < count; k++) {
        sweep_measure(s, &others[k], 1, 1, &other[k]);
        print_row(&other[k], unit);
        best = other[k].cost.seconds < best->cost.seconds ? &other[k] : best;
    }
    if (count > 0)
        printf("\nThe fastest of the other libraries, %s, takes %.2f times as long as Saltus' flow on one "
               "core and %.2f times as long as its sweep.\n",
               best->program->name, best->cost.seconds / unit.flow, best->cost.seconds / unit.engine);
    printf("\nFlow: %d lanes take 1/%.2f of the time of one lane.\n\n", lanes,
           flows[1].cost.seconds / unit.flow);
    /* Time per order of a lane's series, with all overhead. */
    for (int k = 0; k < flow_count; k++) {
        const sweep_cost *cost = &flows[k].cost;
        printf("%s: %.1f orders in a step, %.2f ns an order.\n", flows[k].program->name,
               (double)cost->evaluations / (double)cost->steps,
               1e9 * cost->seconds / (double)cost->evaluations);
    }
}

static void compare(sweep *s, bool rivals) {
    const int lanes = saltus_flow_width(s->stopped[0], SALTUS_AUTOMATIC, LLONG_MAX), flows = 3;
    program list[2 * rows_max] = {
        {"Saltus flow, all lanes", program_flow, OWN_TOLERANCE, .lanes = lanes},
        {"Saltus flow, one lane", program_flow, OWN_TOLERANCE, .lanes = 1},
        {"Saltus flow, all lanes, no stop", program_flow, OWN_TOLERANCE, .unstopped = true, .lanes = lanes}};
    row rows[2 * rows_max], *sweeps = rows + flows;
    memcpy(list + flows, engines, sizeof engines);
    sweep_measure(s, list, flows + engine_count, own_repeats, rows);
    table_of_programs(s, rivals, lanes, rows, flows, sweeps);
    printf("\n| sweep | rtol | CPU s | wall s | ratio | trajectories/s | event error / T: median | 90 %% | "
           "max | right counts | elsewhere | wrong | right n/p |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
    for (int k = 0; k < engine_count; k++) {
        const row *r = &sweeps[k];
        printf("| %s | %.1e | %.3f | %.3f | %.2f | %.0f |", r->program->name, r->program->rtol,
               r->cost.seconds, r->cost.wall, r->cost.seconds / sweeps->cost.seconds,
               s->count / r->cost.wall);
        print_judgement(r);
        if (!r->program->unstopped)
            printf(" %d of %d |\n", r->labels, s->periodic);
        else
            printf(" - |\n");
        fflush(stdout);
    }
    printf("\nSweep: %d lanes take 1/%.2f of the time of one lane, two threads 1/%.2f of the wall time of "
           "one.\n",
           lanes, sweeps[1].cost.seconds / sweeps->cost.seconds, sweeps->cost.wall / sweeps[2].cost.wall);
}

int main(int count, char **arguments) {
    static sweep s;
    int part = 4;
    bool done = true, rivals = false, checking = false, calibrating = false;
    for (int k = 1; k < count; k++)
        if (strcmp(arguments[k], "--part") == 0 && k + 1 < count && atoi(arguments[k + 1]) > 0)
            part = atoi(arguments[++k]);
        else if (strcmp(arguments[k], "--rivals") == 0)
            rivals = true;
        else if (strcmp(arguments[k], "--check") == 0)
            checking = true;
        else if (strcmp(arguments[k], "--calibrate") == 0)
            calibrating = true;
        else {
            fprintf(stderr, "usage: saltus_sweep_bench [--part k] [--rivals] [--check] [--calibrate]\n");
            return 2;
        }
    s.part = checking ? 1 : part;
    sweep_build(&s, checking ? part : 1);
    sweep_make_reference(&s);
    printf("%d of %d omegas, %d of them with a periodic motion", s.count, omegas_max, s.periodic);
    if (s.part > 1 && rivals)
        printf("; other libraries on every %dth, times and counts of work scaled by the time simulated",
               s.part);
    printf(".\n\n");
    if (calibrating)
        calibrate(&s, rivals);
    else if (checking)
        done = check(&s);
    else
        compare(&s, rivals);
    sweep_tear_down(&s);
    return done ? 0 : 1;
}
