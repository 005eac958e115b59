/* A blind census of verdicts: random points of the pipe are classified as `saltus classify` does it, and what
 * is said of motions without a period is compared with eight trajectories on them that are followed ten times
 * as long. One line of a table for each point, the counts at the end.
 *
 *     saltus_census [points [seed [first]]]    default 60 1 0
 *
 * The k-th point depends on the seed and on k alone, so a census can be made in parts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/saltus.h"

#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { followers = 8, times_as_long = 10, least_followed = 40000 };
static const double apart = 1e-6; /* of a displacement, from one follower to the next */

/* What the followers show. */
typedef struct witness {
    int settled;            /* of them, */
    char label[32];         /* on this */
    double watched;         /* periods of all until they settled */
    double exponent, error; /* of a motion that was called quasi-periodic or long-period */
} witness;

typedef struct counts {
    int points, settled, chaotic, transient, torus, long_period, irregular, undecided;
    int wrong, bounds, bounds_above; /* verdicts; lifetimes bounded, and bounds above what was seen */
    double *chaotic_seconds;
} counts;

static void give_up(const char *what, const saltus_message *message) {
    fprintf(stderr, "saltus_census: %s: %s\n", what, message->text);
    exit(EXIT_FAILURE);
}

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
    if (saltus_scene_load("pipe", &scene, &message) != SALTUS_OK)
        give_up("pipe", &message);
    char words[128];
    memcpy(words, text, sizeof words);
    for (char *rest = words, *word; (word = strtok_r(rest, " ", &rest));)
        if (saltus_scene_set(&scene, word, &message) != SALTUS_OK)
            give_up(word, &message);
    gsl_rng_free(rng);
    return scene;
}

/* A sweep of one axis hands its rows here. */
typedef struct rows {
    witness *seen;
    long long handed;
} rows;

static long long next_row(void *context) {
    rows *r = context;
    return r->handed < followers ? r->handed++ : -1;
}

static saltus_status take_row(void *context, const saltus_sweep_result *result, saltus_message *message) {
    (void)message;
    witness *seen = ((rows *)context)->seen;
    const saltus_sweep_row *row = result->rows;
    seen->watched += (double)row->settled;
    if (saltus_verdict_settled((saltus_verdict)row->verdict)) {
        seen->settled++;
        saltus_sweep_label(row, seen->label);
    }
    return SALTUS_OK;
}

/* Follow neighbours of a state on the motion, each until it settles or its time is over. */
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
    /* Away from the stop, which the state may touch. */
    for (int k = 0; k < followers; k++)
        starts[k] = motion->state[0] * (1 - apart * (k + 1));
    axis.low = starts[0];
    axis.high = starts[followers - 1];
    options.transient = periods;
    options.longest = 64;
    options.threads = 1;
    rows r = {.seen = &seen};
    saltus_sweep_feed feed = {.context = &r, .next = next_row, .take = take_row};
    saltus_status status = saltus_sweep_new(&there, &axis, 1, &options, &sweep, &message);
    if (status == SALTUS_OK)
        status = saltus_sweep_run(sweep, &feed, &message);
    if (status != SALTUS_OK)
        give_up("followers", &message);
    saltus_sweep_free(sweep);
    return seen;
}

static void measure(const saltus_system *system, const saltus_motion *motion, long long periods,
                    witness *seen) {
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    saltus_lyapunov result;
    saltus_message message = {.text = ""};
    options.periods = periods;
    options.precision = 1e-9;
    if (saltus_lyapunov_run(system, motion->state, &options, &result, &message) != SALTUS_OK)
        give_up("exponent", &message);
    seen->exponent = result.exponents[0];
    seen->error = result.standard_errors[0];
    saltus_lyapunov_clear(&result);
}

/* Count a verdict, and say whether it is wrong. */
static bool count(counts *c, const saltus_motion *m, const witness *seen, double seconds) {
    bool wrong = false;
    c->points++;
    switch (m->verdict) {
    case SALTUS_CHAOTIC:
        c->chaotic_seconds[c->chaotic++] = seconds;
        wrong = seen->settled > 0;
        break;
    case SALTUS_TRANSIENT:
        c->transient++;
        break;
    case SALTUS_QUASIPERIODIC:
        c->torus++;
        wrong = seen->settled > 0 || !(fabs(seen->exponent) <= 3 * seen->error);
        break;
    case SALTUS_LONG_PERIOD:
        c->long_period++;
        wrong = seen->exponent > 3 * seen->error;
        break;
    case SALTUS_IRREGULAR:
        c->irregular++;
        break;
    case SALTUS_UNDECIDED:
        c->undecided++;
        break;
    default:
        c->settled++;
    }
    if (!isnan(m->evidence.lifetime_at_least) && !saltus_verdict_settled(m->verdict)) {
        c->bounds++;
        c->bounds_above += seen->settled && m->evidence.lifetime_at_least > seen->watched / seen->settled;
    }
    c->wrong += wrong;
    return wrong;
}

static void census(unsigned long seed, int k, counts *c) {
    char text[128];
    saltus_scene scene = draw(seed, k, text);
    saltus_message message = {.text = ""};
    saltus_system *system;
    saltus_motion motion;
    witness seen = {.exponent = NAN, .error = NAN};
    double state[SALTUS_STATE_MAX];
    saltus_classify_options options = saltus_classify_defaults();
    if (saltus_system_new(&scene.spec, &system, &message) != SALTUS_OK ||
        saltus_scene_state(&scene, system, state, &message) != SALTUS_OK)
        give_up(text, &message);
    clock_t begin = clock();
    if (saltus_classify(system, state, &options, &motion, &message) != SALTUS_OK)
        give_up(text, &message);
    double seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
    if (!saltus_verdict_settled(motion.verdict)) {
        long long each = motion.evidence.periods / followers * times_as_long;
        each = each < least_followed ? least_followed : each;
        seen = follow(&scene, &motion, each);
        if (motion.verdict == SALTUS_QUASIPERIODIC || motion.verdict == SALTUS_LONG_PERIOD)
            measure(system, &motion, each * followers, &seen);
    }
    bool wrong = count(c, &motion, &seen, seconds);
    printf("%d,%s,%s,%.2f,%.6g,%.2g,%.0f,%d,%s,%.0f,%.6g,%.2g,%s\n", k, text, motion.label, seconds,
           motion.lyapunov, motion.lyapunov_error, motion.evidence.lifetime_at_least, seen.settled,
           seen.label, seen.watched, seen.exponent, seen.error, wrong ? "wrong" : "");
    fflush(stdout);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

int main(int argc, char **argv) {
    int points = argc > 1 ? atoi(argv[1]) : 60, first = argc > 3 ? atoi(argv[3]) : 0;
    unsigned long seed = argc > 2 ? strtoul(argv[2], NULL, 10) : 1;
    counts c = {.points = 0};
    if (argc > 4 || points < 1 || first < 0) {
        fputs("usage: saltus_census [points [seed [first]]]\n", stderr);
        return 2;
    }
    c.chaotic_seconds = calloc((size_t)points, sizeof *c.chaotic_seconds);
    if (!c.chaotic_seconds)
        return EXIT_FAILURE;
    puts("point,scene,verdict,seconds,exponent,error,lifetime_at_least,followers_settled,on,periods_followed,"
         "exponent_followed,error_followed,judgement");
    for (int k = first; k < first + points; k++)
        census(seed, k, &c);
    gsl_sort(c.chaotic_seconds, 1, (size_t)c.chaotic);
    printf(
        "# %d points: %d periodic or at rest, %d chaotic, %d transient, %d quasi-periodic, %d long-period, "
        "%d irregular, %d undecided; %d wrong; %d of %d bounds of lifetimes above what the followers show; "
        "median time of a chaotic verdict %.2f s\n",
        c.points, c.settled, c.chaotic, c.transient, c.torus, c.long_period, c.irregular, c.undecided,
        c.wrong, c.bounds_above, c.bounds, c.chaotic ? c.chaotic_seconds[c.chaotic / 2] : 0);
    free(c.chaotic_seconds);
    return 0;
}
