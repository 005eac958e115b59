/* Claims about one motion: Figures 3 and 7, from many random initial states.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "trial.h"

#include "bench/reference.h"

/* The paper's statement on a motion, and an independent orbit for comparison. */
typedef struct point {
    const char *claim, *scene, *label, *reference;
    int seeds, quick;
} point;

static const point points[] = {{"F3", "fig3", "2/2", "sdof14", 100, 20},
                               {"F7b", "fig7b", "4/5", "fig7b", 100, 20},
                               {"F7d", "fig7d", "4/4", "fig7d", 100, 20},
                               {"F7a", "fig7a", "chaotic", NULL, 6, 2},
                               {"F7c", "fig7c", "chaotic", NULL, 6, 2}};

static void describe(const saltus_attractors *attractors, FILE *file) {
    fprintf(file, "%d random initial states (Gaussian with the system's scales) lead to ", attractors->seeds);
    for (int k = 0; k < attractors->count; k++) {
        const saltus_motion *m = &attractors->motions[k];
        fprintf(file, "%s%s (%d", k ? ", " : "", m->label, attractors->shares[k]);
        if (m->multiplier_count)
            fprintf(file, ", largest multiplier modulus %.4f", exp(m->multipliers[0].log_modulus));
        fprintf(file, "%s)", m->mirror == SALTUS_MIRROR_PAIR ? ", one of a mirror pair" : "");
    }
    fprintf(file, ".\n");
}

/* Fraction of the initial states that lead to the claimed motion. */
static double share_of(const saltus_attractors *attractors, const char *label) {
    int fit = 0;
    for (int k = 0; k < attractors->count; k++)
        fit += strcmp(attractors->motions[k].label, label) == 0 ? attractors->shares[k] : 0;
    return (double)fit / attractors->seeds;
}

/* The orbit, beside the independent one. */
static void tell_orbit(const point *p, const saltus_attractors *attractors, FILE *numbers, FILE *prose) {
    const saltus_motion *first = &attractors->motions[0];
    reference r;
    if (first->multiplier_count)
        fprintf(numbers, ", stable, largest multiplier modulus %.4f", exp(first->multipliers[0].log_modulus));
    describe(attractors, prose);
    if (!reference_read("data/reference", p->reference, &r))
        fprintf(prose, "The reference data/reference/%s.json is not here to compare with.\n", p->reference);
    else if (first->multiplier_count && first->periods == r.periods) {
        /* From its first section point, or the mirror image of that, to the nearest one of the motion. */
        double nearest = INFINITY, state[16];
        for (int k = 0; k < 2 * first->periods; k++) {
            for (int i = 0; i < r.n; i++)
                state[i] = (k % 2 ? -1 : 1) * first->section_states[k / 2 * first->dimension + i];
            nearest = fmin(nearest, reference_distance(&r, state, 0));
        }
        fprintf(prose,
                "Against the independent 128-bit orbit data/reference/%s.json (%s): section points agree "
                "to %.1e, the largest multiplier's modulus is %.10f, there %.10f.\n",
                p->reference, r.label, nearest, exp(first->multipliers[0].log_modulus),
                hypot(r.multipliers[0][0], r.multipliers[0][1]));
    }
    if (strcmp(p->claim, "F7b") == 0)
        fputs("What the paper's own method makes of this scene depends on its step: see the table of "
              "steps.\n",
              prose);
    if (strcmp(p->claim, "F3") == 0)
        fprintf(prose,
                "The paper counts in response cycles of 2 T: its 2/1 is 2/2 in forcing periods, %lld "
                "impact on one stop and %lld on the other.\n",
                first->impacts_by_face[0], first->impacts_by_face[1]);
}

static void tell_chaos(const saltus_system *system, const saltus_attractors *attractors, bool quick,
                       FILE *numbers, FILE *prose) {
    const saltus_motion *first = &attractors->motions[0];
    fprintf(numbers, "; largest exponent %.4f +- %.4f", first->lyapunov, first->lyapunov_error);
    describe(attractors, prose);
    fprintf(prose,
            "The largest exponent is %.4f +- %.4f over %lld periods (halves %.4f and %.4f); "
            "correlation dimension of the section points %.2f +- %.2f; 0-1 test %.3f.",
            first->lyapunov, first->lyapunov_error, first->evidence.periods, first->evidence.half[0],
            first->evidence.half[1], first->evidence.dimension, first->evidence.dimension_error,
            first->evidence.zero_one);
    /* All exponents, for the Kaplan-Yorke dimension in the section. */
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    saltus_lyapunov lyapunov;
    saltus_message message = {.text = ""};
    options.exponents = 0;
    options.periods = quick ? 4000 : 16000;
    must(saltus_lyapunov_run(system, first->state, &options, &lyapunov, &message), &message);
    fprintf(prose,
            " All exponents over %lld periods: largest %.4f +- %.4f, second %.3f, Kaplan-Yorke "
            "dimension of the section %.3f; their sum %.5f against %.5f from trace and restitution.\n",
            lyapunov.periods, lyapunov.exponents[0], lyapunov.standard_errors[0], lyapunov.exponents[1],
            lyapunov.kaplan_yorke, lyapunov.sum, lyapunov.sum_rule);
    saltus_lyapunov_clear(&lyapunov);
}

trial_verdict trial_judge_point(const trial_claim *claim, trial_bench *bench, FILE *numbers, FILE *prose) {
    const point *p = points;
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_attractors attractors;
    saltus_message message = {.text = ""};
    const saltus_classify_options options = saltus_classify_defaults();
    while (strcmp(p->claim, claim->id) != 0)
        p++;
    /* All attractors reached from random initial states. */
    must(saltus_scene_load(p->scene, &scene, &message), &message);
    must(saltus_system_new(&scene.spec, &system, &message), &message);
    must(saltus_attractors_find(system, bench->quick ? p->quick : p->seeds, 1, &options, &attractors,
                                &message),
         &message);
    const char *label = attractors.motions[0].label;
    const double share = share_of(&attractors, p->label);
    fprintf(numbers, "%s from %.0f %% of %d initial states", label, 100 * share_of(&attractors, label),
            attractors.seeds);
    if (p->reference)
        tell_orbit(p, &attractors, numbers, prose);
    else
        tell_chaos(system, &attractors, bench->quick, numbers, prose);
    saltus_attractors_clear(&attractors);
    saltus_system_free(system);
    return trial_verdict_of(&share, 1);
}
