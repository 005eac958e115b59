/* Edits of event sequences, on random ones, without integration, so that every rule can be checked exactly.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "made_equations.h"

#include "branch/sequence.h"
#include "orbit/sequence.h"

enum { faces = 4, trials = 400 };

static int below(unsigned long long *seed, int count) {
    return (int)(0.5 * (made_random(seed) + 1) * count);
}

/* Ordered times within an orbit, apart from each other and from its ends. */
static void make_times(saltus_sequence *s, int count, unsigned long long *seed) {
    double sum = 0, gap[SALTUS_MARKS_MAX + 1], time = s->base;
    for (int k = 0; k <= count; k++)
        sum += gap[k] = 1.02 + made_random(seed);
    for (int k = 0; k < count; k++)
        s->mark[k].time = time += gap[k] / sum * s->periods;
    s->count = count;
}

/* Impacts, some of them driven, and on face 0 contacts that begin, directly or by chatter, and end. */
static saltus_sequence random_sequence(unsigned long long *seed, int most) {
    saltus_sequence s = {.periods = 1 + below(seed, 5), .cuts = 1};
    s.base = s.cut[0] = 0.5 * (made_random(seed) + 1) * s.periods;
    make_times(&s, below(seed, most + 1), seed);
    bool holds = false;
    for (int k = 0; k < s.count; k++) {
        saltus_mark *mark = &s.mark[k];
        mark->kind = SALTUS_IMPACT;
        mark->face = 1 + below(seed, faces - 1);
        if (below(seed, 4) == 0 && (holds || k + 1 < s.count)) {
            mark->face = 0;
            mark->driven = !holds && below(seed, 2);
            mark->kind = holds ? SALTUS_RELEASE : mark->driven ? SALTUS_IMPACT : SALTUS_STICK;
            holds = !holds;
        } else if (!holds && below(seed, 8) == 0 && k + 1 < s.count) {
            mark->driven = true;
        }
    }
    if (holds) /* the contact must end before the orbit does */
        s.mark[s.count - 1] = (saltus_mark){SALTUS_RELEASE, 0, s.mark[s.count - 1].time, false};
    return s;
}

static bool same_mark(const saltus_mark *a, const saltus_mark *b) {
    return a->kind == b->kind && a->face == b->face && a->time == b->time && a->driven == b->driven;
}

static void check_same(const saltus_sequence *a, const saltus_sequence *b) {
    assert_true(a->periods == b->periods && a->base == b->base && a->contacts == b->contacts &&
                a->driven == b->driven && a->cuts == b->cuts);
    assert_int_equal(a->count, b->count);
    for (int k = 0; k < a->count; k++)
        assert_true(same_mark(&a->mark[k], &b->mark[k]));
    assert_memory_equal(a->cut, b->cut, (size_t)a->cuts * sizeof *a->cut);
}

/* Marks are in order and within the orbit. */
static void check_ordered(const saltus_sequence *s) {
    assert_true(s->base >= 0 && s->base < s->periods);
    for (int k = 0; k < s->count; k++) {
        assert_true(s->mark[k].time >= (k ? s->mark[k - 1].time : s->base));
        assert_true(s->mark[k].time <= s->base + s->periods);
    }
}

/* A mark of the old sequence is the same event, up to whole orbits. Returns how many marks are new. */
static int check_order(const saltus_sequence *old, const saltus_sequence *fresh, const int *order) {
    int made = 0;
    for (int k = 0; k < fresh->count; k++) {
        made += order[k] < 0;
        if (order[k] < 0)
            continue;
        assert_true(order[k] < old->count);
        const saltus_mark *was = &old->mark[order[k]], *is = &fresh->mark[k];
        assert_true(was->kind == is->kind && was->face == is->face);
        check_near(remainder(is->time - was->time, old->periods), 0, 1e-14 * old->periods);
        for (int j = 0; j < k; j++)
            assert_int_not_equal(order[j], order[k]);
    }
    return made;
}

/* Dying marks are in the old sequence, born ones are not; other observations do not matter. */
typedef struct change {
    saltus_breach breach[3 * SALTUS_MARKS_MAX + 64];
    int count, dead, born;
} change;

static void see(change *c, saltus_breach_kind kind, double value, int mark, int face, double time) {
    c->breach[c->count++] = (saltus_breach){kind, value, mark, face, time};
}

/* A random change: some impacts lose their speed, some maxima touch, others only come near. */
static change random_change(const saltus_sequence *s, int births, unsigned long long *seed) {
    change c = {.count = 0};
    for (int k = 0; k < s->count; k++) {
        const saltus_mark *mark = &s->mark[k];
        if (mark->kind == SALTUS_RELEASE) {
            see(&c, SALTUS_BREACH_HOLD, 0, k, mark->face, mark->time);
            continue;
        }
        bool dies = mark->kind == SALTUS_IMPACT && !mark->driven && below(seed, 3) == 0;
        c.dead += dies;
        see(&c, SALTUS_BREACH_SPEED, dies ? 5e-8 * made_random(seed) : -1e-3 * (k + 1), k, mark->face,
            mark->time);
        /* An impact's own touch is not another one. */
        if (below(seed, 2))
            see(&c, SALTUS_BREACH_GAP, 1e-9 * made_random(seed), k, mark->face,
                mark->time + 1e-6 * made_random(seed));
    }
    for (int k = 0; k < births; k++) {
        double time = s->base + (k + 0.5 + 0.3 * made_random(seed)) * s->periods / births;
        bool near_mark = false;
        for (int j = 0; j < s->count; j++)
            near_mark |= fabs(s->mark[j].time - time) < 1e-4;
        bool touches = !near_mark && below(seed, 2);
        c.born += touches;
        see(&c, SALTUS_BREACH_GAP, touches ? 5e-8 * made_random(seed) : -1e-5, 0, 1 + below(seed, faces - 1),
            time);
        see(&c, SALTUS_BREACH_FORCE, 0, 0, 0, time);
    }
    return c;
}

static const char *words_of(const change *c) {
    return c->born && c->dead ? "impacts are born and die"
           : c->born > 1      ? "impacts are born"
           : c->born          ? "an impact is born"
           : c->dead > 1      ? "impacts die"
                              : "an impact dies";
}

/* Grazing removes impacts without speed and inserts touches, and nothing else; seen from the other side
 * grazing undoes it. */
static void grazing_undoes_grazing(void **state) {
    (void)state;
    unsigned long long seed = 1;
    int counts[2][2] = {{0}};
    for (int trial = 0; trial < trials; trial++) {
        saltus_sequence old = random_sequence(&seed, 20), fresh, again;
        change c = random_change(&old, below(&seed, 6), &seed), back = {.count = 0};
        int order[SALTUS_MARKS_MAX], order_back[SALTUS_MARKS_MAX], k = 0;
        const char *words = saltus_sequence_graze(&old, c.breach, c.count, &fresh, order);
        assert_int_equal(fresh.count, old.count - c.dead + c.born);
        check_ordered(&fresh);
        assert_int_equal(check_order(&old, &fresh, order), c.born);
        counts[c.dead > 0][c.born > 0]++;
        if (c.dead + c.born)
            assert_string_equal(words, words_of(&c));
        else
            assert_null(words);
        /* Remaining marks keep their order. */
        for (int j = 0, last = -1; j < fresh.count; j++)
            if (order[j] >= 0) {
                assert_true(order[j] > last);
                last = order[j];
            }
        /* Born ones die, dead ones touch. */
        for (int j = 0; j < fresh.count; j++)
            if (fresh.mark[j].kind != SALTUS_RELEASE)
                see(&back, SALTUS_BREACH_SPEED, order[j] < 0 ? 0 : -1, j, fresh.mark[j].face,
                    fresh.mark[j].time);
        for (int j = 0; j < old.count; j++) {
            while (k < fresh.count && order[k] < 0)
                k++;
            if (k < fresh.count && order[k] == j)
                k++;
            else
                see(&back, SALTUS_BREACH_GAP, 0, j, old.mark[j].face, old.mark[j].time);
        }
        saltus_sequence_graze(&fresh, back.breach, back.count, &again, order_back);
        check_same(&again, &old);
        assert_int_equal(check_order(&fresh, &again, order_back), c.dead);
        for (int j = 0; j < again.count; j++)
            assert_true(order_back[j] < 0 || order[order_back[j]] == j);
    }
    for (int j = 0; j < 4; j++)
        assert_true(counts[j / 2][j % 2] > 10);
}

/* A touch at the place of an impact is that impact's; on another stop it is an additional one. */
static void own_touches_are_no_births(void **state) {
    (void)state;
    saltus_sequence old = {.periods = 1, .cuts = 1}, fresh;
    int order[SALTUS_MARKS_MAX];
    old.count = 1;
    old.mark[0] = (saltus_mark){SALTUS_IMPACT, 1, 0.5, false};
    for (int other = 0; other < 2; other++)
        for (int dies = 0; dies < 2; dies++) {
            saltus_breach breach[2] = {{SALTUS_BREACH_GAP, 0, 0, 1 + other, 0.5},
                                       {SALTUS_BREACH_SPEED, dies ? 0 : -0.1, 0, 1, 0.5}};
            saltus_sequence_graze(&old, breach, 2, &fresh, order);
            assert_int_equal(fresh.count, 1 - dies + other);
        }
}

/* The number of marks is limited: touches that do not fit are not born, and nothing is lost. */
static void births_end_with_the_room(void **state) {
    (void)state;
    unsigned long long seed = 2;
    saltus_sequence old = {.periods = 2, .cuts = 1}, fresh;
    int order[SALTUS_MARKS_MAX];
    make_times(&old, SALTUS_MARKS_MAX - 2, &seed);
    for (int k = 0; k < old.count; k++)
        old.mark[k].kind = SALTUS_IMPACT;
    change c = {.count = 0};
    for (int k = 0; k < 6; k++)
        see(&c, SALTUS_BREACH_GAP, 0, 0, 1, 0.1 + 0.3 * k);
    saltus_sequence_graze(&old, c.breach, c.count, &fresh, order);
    assert_int_equal(fresh.count, SALTUS_MARKS_MAX);
    check_ordered(&fresh);
    assert_int_equal(check_order(&old, &fresh, order), 2);
}

/* A sequence traversed twice repeats, up to the shift of one of its events, and not on other faces; one that
 * hits the faces alternately is mirrored. */
static void check_repeats(const saltus_sequence *twice, int half, unsigned long long *seed) {
    saltus_sequence moved = *twice;
    if (half == 0) {
        assert_true(isinf(saltus_sequence_repeats(twice, 2, false)));
        return;
    }
    check_near(saltus_sequence_repeats(twice, 2, false), 0, 1e-14 * twice->periods);
    assert_true(isinf(saltus_sequence_repeats(twice, 2, true)));
    assert_true(half % 2 == 0 || isinf(saltus_sequence_repeats(twice, 4, false)));
    moved.mark[below(seed, moved.count)].time += 1e-3;
    check_near(saltus_sequence_repeats(&moved, 2, false), 1e-3, 1e-14 * twice->periods);
    moved = *twice;
    for (int k = half; k < moved.count; k++)
        moved.mark[k].face += faces;
    check_near(saltus_sequence_repeats(&moved, 2, true), 0, 1e-14 * twice->periods);
    assert_true(isinf(saltus_sequence_repeats(&moved, 2, false)));
}

/* Two orbits in a row: the marks of the first at their times, those of the second an orbit later. */
static void orbits_are_joined(void **state) {
    (void)state;
    unsigned long long seed = 3;
    for (int trial = 0; trial < trials; trial++) {
        saltus_sequence first = random_sequence(&seed, 15), second = first, both, twice;
        if (trial % 2)
            make_times(&second, below(&seed, 12), &seed);
        first.cuts = 1 + below(&seed, 3);
        assert_true(saltus_sequence_join(&first, &second, &both));
        assert_true(both.periods == 2 * first.periods && both.base == first.base && both.cuts == 1 &&
                    both.cut[0] == both.base);
        assert_int_equal(both.count, first.count + second.count);
        check_ordered(&both);
        for (int k = 0; k < both.count; k++) {
            saltus_mark part = k < first.count ? first.mark[k] : second.mark[k - first.count];
            part.time += k < first.count ? 0 : first.periods;
            assert_true(same_mark(&both.mark[k], &part));
        }
        assert_true(saltus_sequence_join(&first, &first, &twice));
        check_repeats(&twice, first.count, &seed);
    }
    saltus_sequence large = {.periods = 1, .cuts = 1, .count = SALTUS_MARKS_MAX / 2}, fresh;
    assert_true(saltus_sequence_join(&large, &large, &fresh));
    large.count++;
    assert_false(saltus_sequence_join(&large, &large, &fresh));
    saltus_sequence small = {.periods = 1, .cuts = 1, .count = SALTUS_MARKS_MAX / 2 - 1};
    assert_true(saltus_sequence_join(&large, &small, &fresh));
    assert_int_equal(fresh.count, SALTUS_MARKS_MAX);
}

/* Whether a contact holds at a time, or the flow finds its own events. */
static bool is_bound(const saltus_sequence *s, double time) {
    bool holds = s->contacts != 0, driven = s->driven;
    for (int k = 0; k < s->count && s->mark[k].time <= time; k++) {
        if (s->mark[k].face == 0)
            holds = s->mark[k].kind != SALTUS_RELEASE;
        driven = s->mark[k].driven;
    }
    return holds || driven;
}

/* The distance of a time from the nearest mark, or end of the orbit, as a share of the flight there. */
static double share_of_flight(const saltus_sequence *s, double time) {
    double before = time - s->base, after = s->base + s->periods - time;
    for (int k = 0; k < s->count; k++)
        if (s->mark[k].time <= time)
            before = fmin(before, time - s->mark[k].time);
        else
            after = fmin(after, s->mark[k].time - time);
    return fmin(before, after) / (before + after);
}

/* An orbit cut elsewhere is the same cycle of the same events. The base is in free flight if the old one was;
 * cuts are in order, in free flight and apart from marks; cutting again changes nothing. */
static void reframing_keeps_the_cycle(void **state) {
    (void)state;
    unsigned long long seed = 4;
    int changed = 0, moved = 0, cut = 0;
    for (int trial = 0; trial < 4 * trials; trial++) {
        saltus_sequence old = random_sequence(&seed, 12), fresh, again;
        double speed[SALTUS_MARKS_MAX];
        int order[SALTUS_MARKS_MAX], unused[SALTUS_MARKS_MAX], cuts = 1 + below(&seed, 5);
        for (int k = 0; k < old.count; k++)
            speed[k] = 0.5 + made_random(&seed) / 4;
        /* Move the first or the last event close to the base. */
        if (trial % 3 == 1 && old.count)
            old.mark[0].time = old.base + 1e-3 * (old.mark[0].time - old.base);
        if (trial % 3 == 2 && old.count)
            old.mark[old.count - 1].time = old.base + old.periods - 1e-9;
        bool better = saltus_sequence_reframe(&old, speed, cuts, trial % 2, &fresh, order);
        check_ordered(&fresh);
        assert_true(fresh.count == old.count && fresh.periods == old.periods);
        assert_int_equal(check_order(&old, &fresh, order), 0);
        for (int k = 0; k < fresh.count; k++) {
            assert_int_equal(order[k], (order[0] + k) % old.count);
            assert_true(fresh.mark[k].driven == old.mark[order[k]].driven);
        }
        assert_true(fresh.cut[0] == fresh.base && fresh.cuts <= cuts && fresh.cuts >= 1);
        for (int j = 0; j < fresh.cuts; j++) {
            assert_true(j == 0 || fresh.cut[j] > fresh.cut[j - 1]);
            assert_true(fresh.cut[j] < fresh.base + fresh.periods);
            if (j)
                assert_true(!is_bound(&fresh, fresh.cut[j]) && share_of_flight(&fresh, fresh.cut[j]) > 0.05);
        }
        if (fresh.base != old.base) {
            double flight = 0;
            moved++;
            assert_true(better);
            /* The base is in the middle of the longest free flight. */
            for (int k = 0; k < old.count; k++) {
                double next = k + 1 < old.count ? old.mark[k + 1].time : old.mark[0].time + old.periods;
                if (!is_bound(&old, old.mark[k].time))
                    flight = fmax(flight, next - old.mark[k].time);
            }
            double before = fresh.mark[0].time - fresh.base;
            double after = fresh.base + fresh.periods - fresh.mark[fresh.count - 1].time;
            check_near(before, flight / 2, 1e-12);
            check_near(after, flight / 2, 1e-12);
        }
        assert_true(better || fresh.base == old.base);
        changed += better;
        cut += fresh.cuts > 1;
        if (better) {
            double carried[SALTUS_MARKS_MAX];
            for (int k = 0; k < fresh.count; k++)
                carried[k] = speed[order[k]];
            assert_false(saltus_sequence_reframe(&fresh, carried, cuts, trial % 2, &again, unused));
        }
    }
    assert_true(changed > 100 && moved > 50 && cut > 100);
}

/* The tail of a long run of ever slower impacts on one face is left to the flow: the first ones are kept, the
 * last one kept is driven, and marks behind the run remain. */
static void tails_are_trimmed(void **state) {
    (void)state;
    int trimmed = 0;
    for (int length = 2; length < 60; length++)
        for (int trims = 0; trims < 2; trims++) {
            saltus_sequence old = {.periods = 1, .cuts = 1}, fresh;
            double speed[SALTUS_MARKS_MAX];
            int order[SALTUS_MARKS_MAX];
            old.count = length + 2;
            for (int k = 0; k < old.count; k++) {
                old.mark[k].time = 0.2 + 0.6 * k / old.count;
                bool other = k == 0 || k == old.count - 1;
                old.mark[k].kind = SALTUS_IMPACT;
                old.mark[k].face = other ? 2 : 1;
                speed[k] = other ? 1 : exp(-0.3 * k);
            }
            bool better = saltus_sequence_reframe(&old, speed, 1, trims, &fresh, order);
            int gone = old.count - fresh.count;
            trimmed += gone > 0;
            assert_true(gone == 0 || (trims && better));
            assert_int_equal(check_order(&old, &fresh, order), 0);
            for (int k = 0; k < old.count; k++) {
                int at = 0;
                while (at < fresh.count && order[at] != k)
                    at++;
                bool tail = gone && k > old.count - 2 - gone && k < old.count - 1;
                assert_int_equal(at == fresh.count, tail);
                if (!tail)
                    assert_int_equal(fresh.mark[at].driven, gone && k == old.count - 2 - gone);
            }
        }
    assert_true(trimmed > 10 && trimmed < 58);
}

/* Unknowns move with their marks, states with their cuts, parameters stay; new ones are zero. */
static void vectors_follow_their_marks(void **state) {
    (void)state;
    unsigned long long seed = 6;
    for (int trial = 0; trial < trials; trial++) {
        saltus_sequence old = random_sequence(&seed, 12), fresh;
        int order[SALTUS_MARKS_MAX], n = 1 + below(&seed, 6), parameters = 1 + below(&seed, 2);
        double speed[SALTUS_MARKS_MAX] = {0}, vector[400], out[400];
        change c = random_change(&old, below(&seed, 4), &seed);
        bool grazes = trial % 2;
        if (trial % 4 < 2)
            for (int j = 1; j < 3; j++)
                old.cut[old.cuts++] = old.base + j * old.periods / 3.0;
        if (grazes)
            saltus_sequence_graze(&old, c.breach, c.count, &fresh, order);
        else
            saltus_sequence_reframe(&old, speed, 1 + below(&seed, 4), false, &fresh, order);
        for (int j = 0; j < 400; j++) {
            vector[j] = 2 + made_random(&seed);
            out[j] = NAN;
        }
        saltus_sequence_carry(&old, vector, &fresh, order, n, parameters, out);
        for (int j = 0; j < fresh.cuts; j++) {
            /* A state is kept if all cuts, or at least the base, are the same. */
            bool same = fresh.base == old.base && j == 0;
            same |= grazes;
            bool may = j < old.cuts && fresh.base == old.base && fresh.cut[j] == old.cut[j];
            for (int i = 0; i < n; i++) {
                assert_true(out[j * n + i] == 0 || (may && out[j * n + i] == vector[j * n + i]));
                assert_true(!same || out[j * n + i] != 0);
            }
        }
        const double *times = out + fresh.cuts * n, *old_times = vector + old.cuts * n;
        for (int k = 0; k < fresh.count; k++)
            assert_true(times[k] == (order[k] < 0 ? 0 : old_times[order[k]]));
        for (int d = 0; d < parameters; d++)
            assert_true(times[fresh.count + d] == old_times[old.count + d]);
        assert_true(isnan(times[fresh.count + parameters]));
    }
}

/* Where an orbit is cut into halves no event is near the cuts; its base stays if none is. */
static void halves_are_cut_away_from_marks(void **state) {
    (void)state;
    saltus_sequence s = {.base = 0.53, .periods = 1, .count = 1, .mark = {{SALTUS_IMPACT, 0, 1.03, false}}};
    assert_true(fabs(saltus_sequence_amid_halves(&s) - 1.28) < 1e-15);
    s.mark[0].time = 0.8;
    assert_true(saltus_sequence_amid_halves(&s) == s.base);
    s = (saltus_sequence){.base = 0,
                          .periods = 2,
                          .count = 3,
                          .mark = {{SALTUS_IMPACT, 0, 0.2, false},
                                   {SALTUS_IMPACT, 1, 1, false},
                                   {SALTUS_IMPACT, 0, 1.2, false}}};
    assert_true(fabs(saltus_sequence_amid_halves(&s) - 0.6) < 1e-15 ||
                fabs(saltus_sequence_amid_halves(&s) - 1.6) < 1e-15);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grazing_undoes_grazing),     cmocka_unit_test(own_touches_are_no_births),
        cmocka_unit_test(births_end_with_the_room),   cmocka_unit_test(orbits_are_joined),
        cmocka_unit_test(reframing_keeps_the_cycle),  cmocka_unit_test(tails_are_trimmed),
        cmocka_unit_test(vectors_follow_their_marks), cmocka_unit_test(halves_are_cut_away_from_marks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
