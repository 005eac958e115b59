/* What the tests of branches share: runs kept point by point, and the special points of closed orbits in the
 * order in which a branch passes them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_BRANCH_CHECK_H
#define SALTUS_TESTS_BRANCH_CHECK_H

#include "closed_orbits.h"

#include "saltus/branch.h"

/* All points of a run, with arrays of their own. */
typedef struct branch_record {
    saltus_branch_point *point;
    int count, room;
} branch_record;

static inline void branch_keep(branch_record *record, const saltus_branch_point *point) {
    if (record->count == record->room) {
        record->room = record->room ? 2 * record->room : 256;
        record->point = realloc(record->point, (size_t)record->room * sizeof *record->point);
        assert_non_null(record->point);
    }
    /* A copy shares nothing with what it is of, and says the same. */
    saltus_message message = {.text = ""};
    saltus_branch_point *kept = &record->point[record->count++];
    size_t n = (size_t)point->dimension;
    check_ok(saltus_branch_point_copy(point, kept, &message), &message);
    assert_true(kept->state != point->state && kept->events != point->events &&
                kept->multipliers != point->multipliers);
    assert_memory_equal(kept->state, point->state, n * sizeof *kept->state);
    assert_memory_equal(kept->multipliers, point->multipliers, n * sizeof *kept->multipliers);
    for (int k = 0; k < point->event_count; k++)
        assert_memory_equal(&kept->events[k].time, &point->events[k].time, sizeof(saltus_time));
    assert_true(kept->value[0] == point->value[0] && kept->event_count == point->event_count &&
                saltus_spec_equal(&kept->spec, &point->spec) && strcmp(kept->label, point->label) == 0);
}

static inline void branch_forget(branch_record *record) {
    for (int k = 0; k < record->count; k++)
        saltus_branch_point_clear(&record->point[k]);
    free(record->point);
    *record = (branch_record){0};
}

/* The points that a branch still has to give, `most` of them at most. */
static inline branch_record branch_collect(saltus_branch *branch, int most) {
    branch_record record = {0};
    saltus_message message = {.text = ""};
    const saltus_branch_point *point;
    while (record.count < most) {
        check_ok(saltus_branch_step(branch, &point, &message), &message);
        if (!point)
            break;
        branch_keep(&record, point);
    }
    return record;
}

enum { branch_points_max = 20000 };

static inline branch_record branch_run(const saltus_spec *spec, int periods, const double *state,
                                       const saltus_branch_options *options) {
    saltus_message message = {.text = ""};
    saltus_branch *branch = NULL;
    check_ok(saltus_branch_new(spec, periods, state, options, &branch, &message), &message);
    branch_record record = branch_collect(branch, branch_points_max);
    saltus_branch_free(branch);
    return record;
}

/* A run from what a trajectory settles on. */
static inline branch_record branch_run_settled(const saltus_spec *spec, const saltus_branch_options *options,
                                               const char *label) {
    saltus_system *system = build(spec);
    saltus_classify_options how = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double state[SALTUS_SCENE_STATE_MAX];
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, &how, &motion, &message), &message);
    assert_string_equal(motion.label, label);
    int periods = motion.periods > 0 ? motion.periods : 1;
    branch_record record = branch_run(spec, periods, motion.state, options);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return record;
}

static inline saltus_branch_options branch_along(const char *key, double low, double high) {
    saltus_branch_options options = saltus_branch_defaults();
    snprintf(options.key[0], sizeof options.key[0], "%s", key);
    options.low[0] = low;
    options.high[0] = high;
    return options;
}

/* Points that say something about the orbits, not about the run. */
static inline bool branch_special(const saltus_branch_point *point) {
    return point->kind != SALTUS_POINT_REGULAR && point->kind != SALTUS_POINT_UZ &&
           point->kind != SALTUS_POINT_EP;
}

/* The next special point of a branch from index `from` on, or NULL; `from` moves beyond it. */
static inline const saltus_branch_point *branch_next_special(const branch_record *record, int branch,
                                                             int *from) {
    while (*from < record->count) {
        const saltus_branch_point *point = &record->point[(*from)++];
        if (point->branch == branch && branch_special(point))
            return point;
    }
    return NULL;
}

/* Two runs pass the same special points in the same order, with values that agree. */
static inline void branch_check_same(const branch_record *one, const branch_record *other, double tolerance) {
    for (int branch = 0; branch < 16; branch++)
        for (int i = 0, j = 0;;) {
            const saltus_branch_point *a = branch_next_special(one, branch, &i);
            const saltus_branch_point *b = branch_next_special(other, branch, &j);
            if (!a && !b)
                break;
            if (!a || !b || a->kind != b->kind)
                fail_msg("branch %d: %s at %.12g against %s at %.12g", branch,
                         a ? saltus_point_word(a->kind) : "no point", a ? a->value[0] : NAN,
                         b ? saltus_point_word(b->kind) : "no point", b ? b->value[0] : NAN);
            check_near(a->value[0], b->value[0], tolerance);
            assert_string_equal(a->label, b->label);
            assert_string_equal(a->label_after, b->label_after);
        }
}

static inline void branch_check_bytes(const void *a, const void *b, size_t size, const char *what, int row) {
    if (size && memcmp(a, b, size) != 0)
        fail_msg("row %d: %s differs", row, what);
}

/* Two points agree to the last bit in all that they tell. */
static inline void branch_check_equal(const saltus_branch_point *a, const saltus_branch_point *b, int row) {
    const int whole[2][12] = {
        {a->kind, a->locus, a->branch, a->parent, a->step, a->periods, a->sticking_intervals, a->unstable,
         a->iterations, a->grazing_stop, a->grazing_side, a->event_count},
        {b->kind, b->locus, b->branch, b->parent, b->step, b->periods, b->sticking_intervals, b->unstable,
         b->iterations, b->grazing_stop, b->grazing_side, b->event_count}};
    const double real[2][11] = {
        {a->arclength, a->value[0], a->value[1], a->heading, a->residual, a->log_volume, a->sum_rule,
         a->accuracy, a->grazing_time, (double)a->impacts, a->contact_force},
        {b->arclength, b->value[0], b->value[1], b->heading, b->residual, b->log_volume, b->sum_rule,
         b->accuracy, b->grazing_time, (double)b->impacts, b->contact_force}};
    branch_check_bytes(whole[0], whole[1], sizeof whole[0], "a whole number", row);
    for (int k = 0; k < 11; k++)
        if (!(isnan(real[0][k]) && isnan(real[1][k])) && real[0][k] != real[1][k])
            fail_msg("row %d: real number %d is %.17g and %.17g", row, k, real[0][k], real[1][k]);
    assert_int_equal(a->stable, b->stable);
    assert_int_equal(a->admissible, b->admissible);
    assert_string_equal(a->label, b->label);
    assert_string_equal(a->label_after, b->label_after);
    assert_string_equal(a->reason, b->reason);
    assert_true(saltus_spec_equal(&a->spec, &b->spec));
    branch_check_bytes(a->state, b->state, (size_t)a->dimension * sizeof *a->state, "the state", row);
    branch_check_bytes(a->multipliers, b->multipliers, (size_t)a->dimension * sizeof *a->multipliers,
                       "a multiplier", row);
    for (int k = 0; k < a->event_count; k++) {
        const saltus_event *e = &a->events[k], *f = &b->events[k];
        assert_true(e->kind == f->kind && e->face == f->face && e->time.cycle == f->time.cycle &&
                    e->time.phase == f->time.phase && e->velocity_before == f->velocity_before &&
                    e->velocity_after == f->velocity_after && e->displacement == f->displacement);
    }
}

/* What a run goes on from after each of its points; `count` 0 where that is not known. */
typedef struct branch_saved {
    double *numbers;
    int count;
} branch_saved;

/* A run interrupted after every `every`-th point, and gone on with by another, gives the same points as the
 * whole one to the last bit. Returns how often it was. */
static inline int branch_check_resumed(const saltus_spec *spec, int periods, const double *state,
                                       const saltus_branch_options *options, int every) {
    saltus_message message = {.text = ""};
    saltus_branch *branch = NULL;
    const saltus_branch_point *point;
    branch_record whole = {0};
    branch_saved *saved = calloc(branch_points_max, sizeof *saved);
    int times = 0;
    assert_non_null(saved);
    check_ok(saltus_branch_new(spec, periods, state, options, &branch, &message), &message);
    for (;;) {
        check_ok(saltus_branch_step(branch, &point, &message), &message);
        if (!point)
            break;
        assert_true(whole.count < branch_points_max);
        branch_saved *own = &saved[whole.count];
        branch_keep(&whole, point);
        check_ok(saltus_branch_save(branch, &own->numbers, &own->count, &message), &message);
        assert_true((own->numbers != NULL) == (own->count > 0));
    }
    saltus_branch_free(branch);
    for (int k = 0; k < whole.count; k++) {
        int kept = -1;
        if (k % every == 0 && saved[k].count) {
            check_ok(saltus_branch_new(spec, periods, state, options, &branch, &message), &message);
            check_ok(saltus_branch_resume(branch, saved[k].numbers, saved[k].count, &kept, &message),
                     &message);
            assert_int_equal(kept, k + 1);
            branch_record rest = branch_collect(branch, branch_points_max);
            saltus_branch_free(branch);
            assert_int_equal(kept + rest.count, whole.count);
            for (int i = 0; i < rest.count; i++)
                branch_check_equal(&rest.point[i], &whole.point[kept + i], kept + i);
            branch_forget(&rest);
            times++;
        }
        free(saved[k].numbers);
    }
    free(saved);
    branch_forget(&whole);
    return times;
}

/* A special point of closed orbits. */
typedef struct closed_special {
    saltus_point_kind kind;
    long double value;
    closed_orbit orbit;
    bool touch; /* grazing between the impacts, not at one of no speed */
} closed_special;

enum { closed_specials_max = 16, closed_cells = 100 };

/* The sheet of a branch between two folds: the larger (1) or the smaller (-1) root for the speed. */
typedef struct closed_place {
    long double value;
    int sheet, heading;
} closed_place;

static inline bool closed_on_sheet(const closed_special *s, int sheet) {
    closed_orbit orbit;
    return s->kind == SALTUS_POINT_LP || (closed_orbit_at(&s->orbit.oscillator, sheet, &orbit) &&
                                          fabsl(orbit.impact[0].speed - s->orbit.impact[0].speed) < 1e-9L);
}

/* The special points between two values, in order away from `from`. */
static inline int closed_cell(const closed_oscillator *o, const char *key, long double from, long double to,
                              int sheet, closed_special *found) {
    closed_special s[4] = {{.kind = SALTUS_POINT_LP},
                           {.kind = o->mirrored ? SALTUS_POINT_BP : SALTUS_POINT_PD},
                           {.kind = SALTUS_POINT_GR},
                           {.kind = SALTUS_POINT_GR, .touch = true}};
    bool there[4] = {closed_fold(o, key, from, to, &s[0].orbit),
                     (o->mirrored ? closed_pitchfork : closed_flip)(o, key, from, to, &s[1].orbit),
                     closed_grazing(o, key, from, to, &s[2].orbit),
                     closed_touch(o, key, from, to, sheet, &s[3].orbit)};
    int count = 0;
    for (int i = 0; i < 4; i++) {
        /* Where an impact without speed touches, that is one grazing, not two. */
        bool twice = s[i].touch && fabsl(s[i].orbit.impact[0].speed) < 1e-9L;
        if (!there[i] || twice || !closed_on_sheet(&s[i], sheet))
            continue;
        s[i].value = *closed_value(&s[i].orbit.oscillator, key);
        int k = count++;
        for (; k > 0 && fabsl(found[k - 1].value - from) > fabsl(s[i].value - from); k--)
            found[k] = found[k - 1];
        found[k] = s[i];
    }
    return count;
}

/* Walk from an orbit with the same number of impacts through folds to the first grazing, or to the end of the
 * range; `place` becomes where that is. Returns the number of special points. */
static inline int closed_walk(const closed_oscillator *start, const char *key, long double lo, long double hi,
                              closed_place *place, closed_special *list) {
    long double width = (hi - lo) / closed_cells;
    int count = 0;
    closed_oscillator o = *start;
    while (place->value > lo && place->value < hi) {
        closed_special found[4];
        long double next = fminl(fmaxl(place->value + place->heading * width, lo), hi);
        int here = closed_cell(&o, key, place->value, next, place->sheet, found);
        place->value = next;
        for (int k = 0; k < here; k++) {
            assert_true(count < closed_specials_max);
            list[count++] = found[k];
            if (found[k].kind == SALTUS_POINT_GR) {
                place->value = found[k].value;
                return count;
            }
            if (found[k].kind != SALTUS_POINT_LP)
                continue;
            place->sheet = -place->sheet;
            place->heading = -place->heading;
            place->value = found[k].value + place->heading * 1e-9L * width;
            break;
        }
    }
    return count;
}

#endif
