/* A blind census of verdicts. Random points of the pipe are classified as by `saltus classify`. Verdicts on
 * motions without a period are compared with eight neighbouring trajectories followed ten times as long, side
 * by side in the lanes of a sweep. The table has one line for each point, with the counts at the end.
 *
 * saltus_census POINTS SEED TABLE.csv
 *
 * The k-th point depends only on the seed and k. A row is written as soon as it is known, and points already
 * in the table are skipped, so an interrupted census can continue.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "bench/clock.h"
#include "bench/must.h"
#include "saltus/saltus.h"

#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <math.h>
#include <string.h>

const char program_name[] = "saltus_census";

enum { line_max = 512 };
enum { followers = 8, times_as_long = 10, least_followed = 40000 };
static const double apart = 1e-6; /* difference in a displacement between successive followers */

/* Observations from the followers. */
typedef struct witness {
    int settled;            /* number of followers that settled */
    char label[32];         /* label of the motion they settled on */
    double watched;         /* total periods of all followers until they settled */
    double exponent, error; /* for motions called quasi-periodic or long-period */
} witness;

typedef struct counts {
    int points, of[SALTUS_VERDICTS], wrong;
    int bounds, bounds_above; /* number of lifetime bounds, and of bounds that exceed the observed lifetime */
    double *chaotic_seconds;
} counts;

static saltus_scene draw(unsigned long seed, int k, char text[128]) {
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    saltus_message message = {.text = ""};
    saltus_scene scene;
    gsl_rng_set(rng, seed * 1000003UL + (unsigned long)k);
    double omega = 2 + 53 * gsl_rng_uniform(rng), d = 0.002 + 0.044 * gsl_rng_uniform(rng),
           r = 0.3 + 0.7 * gsl_rng_uniform(rng);
    int modes = 1 + (int)gsl_rng_uniform_int(rng, 5), both = (int)gsl_rng_uniform_int(rng, 2);
    snprintf(text, 128, "N=%d omega=%.6f d=%.6f r=%.4f sides=%s", modes, omega, d, r,
             both ? "both" : "upper");
    must(saltus_scene_load("pipe", &scene, &message), &message);
    char words[128];
    memcpy(words, text, sizeof words);
    for (char *rest = words, *word; (word = strtok_r(rest, " ", &rest));)
        must(saltus_scene_set(&scene, word, &message), &message);
    gsl_rng_free(rng);
    return scene;
}

static saltus_status take_row(void *context, const saltus_sweep_result *result, saltus_message *message) {
    (void)message;
    witness *seen = context;
    const saltus_sweep_row *row = result->rows;
    seen->watched += (double)row->settled;
    if (saltus_verdict_settled((saltus_verdict)row->verdict)) {
        seen->settled++;
        saltus_sweep_label(row, seen->label);
    }
    return SALTUS_OK;
}

/* Follow neighbours of a state on the motion, each until it settles or its time is up. */
static witness follow(const saltus_scene *scene, const saltus_motion *motion, long long periods) {
    witness seen = {.exponent = NAN, .error = NAN};
    double starts[followers];
    saltus_scene there = *scene;
    saltus_axis axis = {.key = "q1", .spacing = SALTUS_LIST, .count = followers, .list = starts};
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_message message = {.text = ""};
    saltus_sweep *sweep;
    there.initial_count = motion->dimension;
    memcpy(there.initial, motion->state, (size_t)motion->dimension * sizeof *motion->state);
    /* Displace away from the stop, which the state may touch. */
    for (int k = 0; k < followers; k++)
        starts[k] = motion->state[0] * (1 - apart * (k + 1));
    axis.low = starts[0];
    axis.high = starts[followers - 1];
    options.transient = periods;
    options.longest = 64;
    options.threads = 1;
    const saltus_sweep_feed feed = {.context = &seen, .take = take_row};
    must(saltus_sweep_new(&there, &axis, 1, &options, &sweep, &message), &message);
    must(saltus_sweep_run(sweep, &feed, &message), &message);
    saltus_sweep_free(sweep);
    return seen;
}

/* The verdict of a motion without a period; SALTUS_PERIODIC for any settled motion. */
static saltus_verdict verdict_of(const char *label) {
    for (int v = 0; v < SALTUS_VERDICTS; v++)
        if (!saltus_verdict_settled((saltus_verdict)v) &&
            strcmp(saltus_verdict_word((saltus_verdict)v), label) == 0)
            return (saltus_verdict)v;
    return SALTUS_PERIODIC;
}

static const char head[] = "point,scene,verdict,seconds,exponent,error,lifetime_at_least,followers_settled,"
                           "on,periods_followed,exponent_followed,error_followed,judgement\n";

/* Count a line of the table. */
static void count(counts *c, char *line) {
    enum { label = 2, seconds = 3, lifetime = 6, settled = 7, watched = 9, judgement = 12, columns };
    char *cells[columns];
    line[strcspn(line, "\n")] = '\0';
    for (int k = 0; k < columns; k++) {
        char *cell = strsep(&line, ",");
        cells[k] = cell ? cell : "";
    }
    const saltus_verdict verdict = verdict_of(cells[label]);
    const double bound = atof(cells[lifetime]);
    if (verdict == SALTUS_CHAOTIC)
        c->chaotic_seconds[c->of[SALTUS_CHAOTIC]] = atof(cells[seconds]);
    c->of[verdict]++;
    c->points++;
    c->wrong += cells[judgement][0] != '\0';
    if (verdict == SALTUS_PERIODIC || isnan(bound))
        return;
    const int ended = atoi(cells[settled]);
    c->bounds++;
    c->bounds_above += ended && bound > atof(cells[watched]) / ended;
}

/* Classify a point and write its line of the table. */
static void look(unsigned long seed, int k, char line[line_max]) {
    char text[128];
    saltus_scene scene = draw(seed, k, text);
    saltus_message message = {.text = ""};
    saltus_system *system;
    saltus_motion motion;
    witness seen = {.exponent = NAN, .error = NAN};
    double state[SALTUS_STATE_MAX];
    saltus_classify_options options = saltus_classify_defaults();
    must(saltus_system_new(&scene.spec, &system, &message), &message);
    must(saltus_scene_state(&scene, system, state, &message), &message);
    const double begin = processor_seconds();
    must(saltus_classify(system, state, &options, &motion, &message), &message);
    const double seconds = processor_seconds() - begin;
    if (!saltus_verdict_settled(motion.verdict)) {
        long long each = motion.evidence.periods / followers * times_as_long;
        each = each < least_followed ? least_followed : each;
        seen = follow(&scene, &motion, each);
        if (motion.verdict == SALTUS_QUASIPERIODIC || motion.verdict == SALTUS_LONG_PERIOD) {
            saltus_lyapunov_options exactly = saltus_lyapunov_defaults();
            saltus_lyapunov result;
            exactly.periods = each * followers;
            exactly.precision = 1e-9;
            must(saltus_lyapunov_run(system, motion.state, &exactly, &result, &message), &message);
            seen.exponent = result.exponents[0];
            seen.error = result.standard_errors[0];
            saltus_lyapunov_clear(&result);
        }
    }
    const bool regular = seen.settled > 0;
    const bool wrong = motion.verdict == SALTUS_CHAOTIC ? regular
                       : motion.verdict == SALTUS_QUASIPERIODIC
                           ? regular || !(fabs(seen.exponent) <= 3 * seen.error)
                           : motion.verdict == SALTUS_LONG_PERIOD && seen.exponent > 3 * seen.error;
    snprintf(line, line_max, "%d,%s,%s,%.2f,%.6g,%.2g,%.0f,%d,%s,%.0f,%.6g,%.2g,%s\n", k, text, motion.label,
             seconds, motion.lyapunov, motion.lyapunov_error, motion.evidence.lifetime_at_least, seen.settled,
             seen.label, seen.watched, seen.exponent, seen.error, wrong ? "wrong" : "");
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

static void summarise(counts *c) {
    int open = c->of[SALTUS_UNDECIDED] + c->of[SALTUS_IRREGULAR], chaotic = c->of[SALTUS_CHAOTIC];
    gsl_sort(c->chaotic_seconds, 1, (size_t)chaotic);
    printf("%d points: %d periodic or at rest", c->points, c->of[SALTUS_PERIODIC]);
    for (int v = 0; v < SALTUS_VERDICTS; v++)
        if (c->of[v] && v != SALTUS_PERIODIC)
            printf(", %d %s", c->of[v], saltus_verdict_word((saltus_verdict)v));
    printf("; %d wrong; %.1f %% undecided or irregular; %d of %d bounds of lifetimes above what the "
           "followers show; median time of a chaotic verdict %.2f s\n",
           c->wrong, 100.0 * open / c->points, c->bounds_above, c->bounds,
           chaotic ? c->chaotic_seconds[chaotic / 2] : 0);
}

int main(int argc, char **argv) {
    int points = argc == 4 ? atoi(argv[1]) : 0;
    char line[line_max];
    if (points < 1) {
        fputs("usage: saltus_census POINTS SEED TABLE.csv\n", stderr);
        return 2;
    }
    unsigned long seed = strtoul(argv[2], NULL, 10);
    FILE *table = fopen(argv[3], "a+");
    if (!table) {
        perror(argv[3]);
        return EXIT_FAILURE;
    }
    bool *known = must_allocate((size_t)points, sizeof *known), empty = true, broken = false;
    counts c = {.chaotic_seconds = must_allocate((size_t)points, sizeof *c.chaotic_seconds)};
    rewind(table);
    while (fgets(line, sizeof line, table)) {
        empty = false;
        broken = !strchr(line, '\n');
        const int k = broken || line[0] < '0' || line[0] > '9' ? -1 : atoi(line);
        if (k < 0 || k >= points || known[k])
            continue;
        known[k] = true;
        count(&c, line);
    }
    if (empty || broken)
        fputs(empty ? head : "\n", table);
    for (int k = 0; k < points; k++)
        if (!known[k]) {
            look(seed, k, line);
            fputs(line, table);
            fflush(table);
            count(&c, line);
        }
    summarise(&c);
    free(c.chaotic_seconds);
    free(known);
    return fclose(table) ? EXIT_FAILURE : EXIT_SUCCESS;
}
