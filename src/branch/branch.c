/* A run: branches of equilibria, branches of periodic orbits, or curves of special points in two parameters,
 * each followed step by step by its own code; all give their points to one trail.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/progress.h"
#include "branch/archive.h"
#include "branch/equilibria.h"
#include "branch/locus.h"
#include "branch/options.h"
#include "branch/trace.h"
#include "flow/effort.h"

#include <limits.h>
#include <stdlib.h>

/* What the next step of a run follows. */
typedef enum run_phase {
    RUN_RESTS,      /* branches of equilibria, and then of the cycles that leave them */
    RUN_ORBITS,     /* branches of periodic orbits */
    RUN_REST_LOCUS, /* curves of special equilibria */
    RUN_LOCUS       /* curves of special orbits */
} run_phase;

struct saltus_branch {
    saltus_branch_options options;
    saltus_effort effort;              /* used if the options have none */
    const volatile sig_atomic_t *stop; /* checked between steps, never within one */
    run_phase phase;
    saltus_trail trail;
    saltus_starts starts; /* of branches of orbits */
    saltus_trace trace;
    saltus_equilibria equilibria; /* opened only where a run begins with them */
    saltus_starts loci;           /* of curves of special equilibria and orbits */
    saltus_rest_locus rest_locus; /* opened only in its phase */
    saltus_locus locus;           /* likewise */
    saltus_branch_point given;
    long long given_count;
};

/* Open a run at an equilibrium of a scene without forcing, or at an orbit. */
static saltus_status open_run(saltus_branch *b, const saltus_spec *spec, int periods, const double *state,
                              saltus_message *message) {
    const saltus_point_kind locus = b->options.locus;
    saltus_status status = saltus_branch_fit(&b->options, spec, b->trail.ends, message);
    if (status == SALTUS_OK)
        status = saltus_trace_open(&b->trace, spec, message);
    if (status != SALTUS_OK)
        return status;
    const bool forced = saltus_system_forced(b->trace.orbits.system);
    if (forced && (locus == SALTUS_POINT_HB || locus == SALTUS_POINT_BE))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "locus = %s: the scene is forced: it has no equilibria, which such points are of",
                           saltus_point_word(locus));
    if (periods != 0 || b->options.orbit.free_period || forced)
        return saltus_trace_begin(&b->trace, periods, state, message);
    b->trace.orbits.options.free_period = true;
    b->phase = RUN_RESTS;
    return saltus_equilibria_open(&b->equilibria, spec, state, message);
}

saltus_status saltus_branch_new(const saltus_spec *spec, int periods, const double *state,
                                const saltus_branch_options *options, saltus_branch **branch,
                                saltus_message *message) {
    *branch = NULL;
    saltus_branch *b = calloc(1, sizeof *b);
    if (!b)
        return saltus_branch_no_memory(message);
    b->options = *options;
    if (!b->options.orbit.flow.effort)
        b->options.orbit.flow.effort = &b->effort;
    b->stop = options->orbit.flow.stop;
    b->phase = RUN_ORBITS;
    b->trail.options = &b->options;
    b->trace.trail = b->equilibria.trail = b->rest_locus.trail = b->locus.trail = &b->trail;
    b->trace.starts = b->equilibria.cycles = &b->starts;
    b->rest_locus.starts = b->locus.starts = b->trace.found = b->equilibria.found = &b->loci;
    saltus_status status = open_run(b, spec, periods, state, message);
    if (status == SALTUS_OK)
        *branch = b;
    else
        saltus_branch_free(b);
    return status;
}

void saltus_branch_free(saltus_branch *b) {
    if (!b)
        return;
    saltus_trail_clear(&b->trail);
    saltus_starts_clear(&b->starts);
    saltus_branch_point_clear(&b->given);
    saltus_trace_close(&b->trace);
    saltus_equilibria_close(&b->equilibria);
    saltus_starts_clear(&b->loci);
    saltus_rest_locus_close(&b->rest_locus);
    saltus_locus_close(&b->locus);
    free(b);
}

/* Open the curves of special points of the present phase, with one through `first`; NULL: with none yet. */
static saltus_status open_loci(saltus_branch *b, const saltus_branch_start *first, saltus_message *message) {
    const saltus_spec *spec = &b->trace.orbits.family.spec;
    return b->phase == RUN_REST_LOCUS ? saltus_rest_locus_open(&b->rest_locus, spec, first, message)
                                      : saltus_locus_open(&b->locus, spec, first, message);
}

/* If a branch has reached the first point of the requested locus, begin the locus there. */
static saltus_status begin_locus(saltus_branch *b, saltus_message *message) {
    const saltus_branch_options *options = &b->options;
    const saltus_point_kind kind = options->locus;
    const saltus_orbits *o = &b->trace.orbits;
    const bool of_rests = b->phase == RUN_RESTS || kind == SALTUS_POINT_HB;
    saltus_message why = {.text = ""};
    if (b->loci.count == 0)
        return SALTUS_OK;
    saltus_branch_start first = saltus_starts_take(&b->loci);
    b->loci.begun = 0;
    b->phase = of_rests ? RUN_REST_LOCUS : RUN_LOCUS;
    saltus_status status = open_loci(b, &first, &why);
    if (status != SALTUS_OK)
        saltus_fail(message, status, "no curve of %s points can be begun at %s = %.12g: %.200s",
                    saltus_point_word(kind), options->key[0],
                    o->origin + o->family.unit[0] * first.parameter[0], why.text);
    saltus_branch_start_clear(&first);
    return status;
}

/* One step along the curves of special equilibria or orbits of the present phase; where none of them is left,
 * along those of the other sort that they have come to. */
static saltus_status advance_loci(saltus_branch *b, bool *more, saltus_message *message) {
    for (;;) {
        const bool of_rests = b->phase == RUN_REST_LOCUS;
        saltus_status status = of_rests ? saltus_rest_locus_step(&b->rest_locus, more, message)
                                        : saltus_locus_step(&b->locus, more, message);
        if (status != SALTUS_OK || *more || !saltus_locus_starts_next(&b->loci, !of_rests))
            return status;
        saltus_rest_locus_close(&b->rest_locus);
        saltus_locus_close(&b->locus);
        b->phase = of_rests ? RUN_LOCUS : RUN_REST_LOCUS;
        status = open_loci(b, NULL, message);
        if (status != SALTUS_OK)
            return status;
    }
}

/* One step along the branch or curve under way, or the begin of another. *more is false when all of the
 * present phase are done. */
static saltus_status advance(saltus_branch *b, bool *more, saltus_message *message) {
    const bool of_rests = b->phase == RUN_RESTS;
    saltus_starts *starts = of_rests ? &b->equilibria.starts : &b->starts;
    saltus_status status = SALTUS_OK;
    if (b->phase > RUN_ORBITS)
        return advance_loci(b, more, message);
    *more = b->trail.following || starts->count > 0;
    if (b->trail.following && of_rests) {
        saltus_equilibria_advance(&b->equilibria);
    } else if (b->trail.following) {
        status = saltus_trace_advance(&b->trace, message);
    } else if (*more) {
        saltus_branch_start start = saltus_starts_take(starts);
        status = of_rests ? saltus_equilibria_start(&b->equilibria, &start, message)
                          : saltus_trace_start(&b->trace, &start, message);
        saltus_branch_start_clear(&start);
    }
    return b->equilibria.rests.starved || b->trace.orbits.starved ? saltus_branch_no_memory(message) : status;
}

saltus_status saltus_branch_step(saltus_branch *b, const saltus_branch_point **point,
                                 saltus_message *message) {
    const saltus_branch_options *o = &b->options;
    *point = NULL;
    saltus_branch_point_clear(&b->given);
    while (!saltus_trail_take(&b->trail, &b->given)) {
        bool more, seeks = o->locus && b->phase <= RUN_ORBITS;
        if (saltus_stop_asked(b->stop))
            return saltus_fail(message, SALTUS_INTERRUPTED, "interrupted");
        saltus_effort_next_point(&b->effort);
        saltus_status status = advance(b, &more, message);
        /* While the first point of a locus is sought, points on the way are discarded; and so is what a step
         * without memory has found. */
        if (seeks || status == SALTUS_NO_MEMORY)
            saltus_trail_drop(&b->trail);
        if (status == SALTUS_OK && more && seeks)
            status = begin_locus(b, message);
        if (status != SALTUS_OK)
            return status;
        if (!more && seeks)
            return saltus_fail(message, SALTUS_NO_CONVERGENCE, "no %s point was found along %s = %g to %g",
                               saltus_point_word(o->locus), o->key[0], o->low[0], o->high[0]);
        if (!more && b->phase != RUN_RESTS)
            return SALTUS_OK;
        if (!more)
            b->phase = RUN_ORBITS;
    }
    b->given_count++;
    *point = &b->given;
    return SALTUS_OK;
}

/* Write or compare what identifies the run; false if the numbers belong to another one. */
static bool archive_identity(saltus_branch *b, saltus_archive *a) {
    const saltus_branch_options *o = &b->options;
    const saltus_spec *spec = &b->trace.orbits.family.spec;
    int parameters;
    saltus_model_parameters(spec->model, &parameters);
    /* The first number is the version of what follows. */
    const double own[] = {16,        a->n,         a->faces,    o->low[0],     o->high[0],
                          o->locus,  o->low[1],    o->high[1],  o->step,       o->step_max,
                          o->points, o->direction, o->switches, o->value_count};
    const double *numbers[] = {own, spec->parameters, o->values};
    const int counts[] = {sizeof own / sizeof own[0], parameters, o->value_count};
    bool same = true;
    for (int j = 0; j < 3; j++)
        for (int k = 0; k < counts[j]; k++) {
            double number = numbers[j][k];
            saltus_archive_real(a, &number);
            same = same && number == numbers[j][k];
        }
    return same;
}

/* Everything on which later steps depend; called between steps. Reading, the objects of the present phase are
 * created. */
static saltus_status archive_run(saltus_branch *b, saltus_archive *a, saltus_message *message) {
    static const char foreign[] = "what the run goes on from is damaged or belongs to another run";
    saltus_orbits *o = &b->trace.orbits;
    a->n = o->n;
    a->faces = saltus_system_face_count(o->system);
    a->sound = true;
    a->sound = archive_identity(b, a) && a->sound;
    b->given_count = saltus_archive_whole(a, b->given_count, 0, INT_MAX);
    double spent = b->effort.spent;
    saltus_archive_finite(a, &spent, 1);
    a->sound = a->sound && spent >= 0;
    saltus_trail_archive(&b->trail, a);
    saltus_archive_starts(a, &b->starts);
    saltus_archive_orbits(a, o);
    b->phase = (run_phase)saltus_archive_whole(a, b->phase, RUN_RESTS, RUN_LOCUS);
    saltus_status status = SALTUS_OK;
    if (b->phase > RUN_ORBITS)
        saltus_archive_starts(a, &b->loci);
    if (b->phase > RUN_ORBITS && a->reading)
        status = open_loci(b, NULL, message);
    if (b->phase == RUN_RESTS && !b->equilibria.here)
        status = saltus_equilibria_open(&b->equilibria, &o->family.spec, NULL, message);
    if (b->phase == RUN_ORBITS && b->trail.following)
        saltus_trace_archive(&b->trace, a);
    else if (status == SALTUS_OK && b->phase != RUN_ORBITS)
        status = b->phase == RUN_RESTS        ? saltus_equilibria_archive(&b->equilibria, a, message)
                 : b->phase == RUN_REST_LOCUS ? saltus_rest_locus_archive(&b->rest_locus, a, message)
                                              : saltus_locus_archive(&b->locus, a, message);
    b->effort.spent = spent; /* whatever reading has taken */
    if (status == SALTUS_NO_MEMORY || a->starved)
        return saltus_branch_no_memory(message);
    bool whole = a->sound && (!a->reading || a->at == a->count);
    return status == SALTUS_OK && whole ? status : saltus_fail(message, SALTUS_BAD_INPUT, foreign);
}

saltus_status saltus_branch_save(saltus_branch *b, double **state, int *count, saltus_message *message) {
    saltus_archive archive = {.reading = false};
    *state = NULL;
    *count = 0;
    /* There is none as long as points wait, or a locus has none yet. */
    if (saltus_trail_last(&b->trail) || b->trail.number < 0)
        return SALTUS_OK;
    saltus_status status = archive_run(b, &archive, message);
    if (status == SALTUS_OK) {
        *state = archive.made;
        *count = (int)archive.count;
    } else {
        free(archive.made);
    }
    return status;
}

saltus_status saltus_branch_resume(saltus_branch *b, const double *state, int count, int *kept,
                                   saltus_message *message) {
    saltus_archive archive = {.reading = true, .given = state, .count = (size_t)count};
    saltus_status status = archive_run(b, &archive, message);
    *kept = status == SALTUS_OK ? (int)b->given_count : 0;
    return status;
}
