/* Where other curves of special points begin.
 *
 * Where an impact grazes on a curve of folds, flips, tori or branch points, the curve of that grazing passes
 * through, to both sides. Where the orbit on a curve of grazing is special, with or without the grazing
 * impact, the curve of such special orbits begins, on the side where it is admissible. Where two impacts
 * graze, the curve of the other one's grazing passes through; the first impact is born there, so it comes in
 * two pieces. Where a double multiplier is 1 or -1 on a curve of folds or flips, a curve of tori begins.
 *
 * Where a flip meets grazing, orbits of twice the period graze too, with one of their two impacts. Let v1 and
 * v2 be the impact speeds and D the difference of the two halves. To leading order v1^2 = n + w D and v2^2 =
 * n - w D. Without impacts D is zero, or free where the flip is; the larger of the gaps n + w D is zero on a
 * curve that differs from that of flips only in third order. With both impacts D = g (v2 - v1), so that
 * either v1 = v2 or v1 + v2 = - 2 w g: at the flip each speed is half of that, at grazing one of them is all
 * of it. In both cases the curves touch. Orbits of twice the period with one impact have their folds at
 * speeds that are not small, so no curve of these begins. A branch point of symmetric orbits is a flip of the
 * map over half a period followed by the mirror: the same holds.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/locus_starts.h"

#include "branch/change.h"
#include "branch/sequence.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void saltus_locus_starts_begin(saltus_orbits *o, saltus_point_kind kind, const saltus_solution *at,
                               const saltus_sequence *beyond, saltus_starts *starts) {
    const bool born = beyond && beyond->count > at->sequence.count;
    const saltus_sequence *more = born ? beyond : &at->sequence, *less = born ? &at->sequence : beyond;
    saltus_branch_start start = {.kind = kind, .sequence = *more, .parent = -1};
    while (less && start.mark < less->count && more->mark[start.mark].time == less->mark[start.mark].time)
        start.mark++;
    if (kind == SALTUS_POINT_HB) /* of the equilibrium */
        start.sequence = (saltus_sequence){.base = at->sequence.base,
                                           .periods = 1,
                                           .contacts = at->sequence.contacts,
                                           .omega = at->sequence.omega / at->sequence.periods};
    /* The angle of the pair on the unit circle. */
    double best = INFINITY;
    for (int i = 0; i < at->survey.multiplier_count && kind == SALTUS_POINT_NS; i++) {
        const saltus_multiplier mu = at->survey.multipliers[i];
        if (!(mu.im > 0 && fabs(mu.log_modulus) < best))
            continue;
        best = fabs(mu.log_modulus);
        start.theta = atan2(mu.im, mu.re);
    }
    saltus_starts_add_at(o, at, &start, starts);
}

/* Whether two starts belong to one curve: at the same place, with the same number of events and, in whichever
 * period of the orbit, the same grazing impact; or one with the mirror image of the other's. In a scene that
 * is its own mirror image these are `image` forcing periods apart (otherwise NAN), and the curves of orbits
 * and of their images are one. */
static bool are_one(const saltus_branch_start *a, const saltus_branch_start *b, double image) {
    const double near = 1e-6, near_time = 1e-4;
    if (a->kind != b->kind || a->leaves != b->leaves || a->sequence.contacts != b->sequence.contacts ||
        a->sequence.periods != b->sequence.periods || a->sequence.count != b->sequence.count ||
        fabs(a->parameter[0] - b->parameter[0]) > near || fabs(a->parameter[1] - b->parameter[1]) > near)
        return false;
    if (a->kind != SALTUS_POINT_GR)
        return true;
    const saltus_mark *one = &a->sequence.mark[a->mark], *other = &b->sequence.mark[b->mark];
    const double apart = one->face == other->face ? 0 : image;
    return fabs(remainder(one->time - other->time - apart, 1)) < near_time;
}

/* Whether there is such a start already, which is done then if this one is. */
static bool is_there(saltus_starts *starts, const saltus_branch_start *start, double image) {
    for (int k = 0; k < starts->count; k++)
        if (are_one(&starts->start[k], start, image)) {
            starts->start[k].done |= start->done;
            return true;
        }
    return false;
}

void saltus_locus_starts_add(saltus_starts *starts, const saltus_branch_start *start, double image,
                             bool *starved) {
    if (!is_there(starts, start, image))
        saltus_starts_add(starts, start, starved);
}

/* How many forcing periods a mirror image of an orbit is later than it; NAN: the scene has none. */
static double image_shift(const saltus_extended *x) {
    const saltus_system *system = x->orbits.system;
    return !system->mirror ? NAN : system->mirror_shift ? 0.5 : 0;
}

bool saltus_locus_starts_pass(saltus_extended *x, const saltus_solution *at, bool joins,
                              saltus_starts *starts) {
    saltus_branch_start own = {
        .kind = x->kind, .sequence = at->sequence, .mark = x->mark, .leaves = joins, .done = true};
    memcpy(own.parameter, at->parameter, sizeof own.parameter);
    const double image = image_shift(x);
    const int last = starts->begun - 1;
    const bool closes = last >= 0 && last < starts->count && are_one(&starts->start[last], &own, image);
    saltus_locus_starts_add(starts, &own, image, &x->orbits.starved);
    return closes;
}

/* A touch moved into the first `periods` periods of an orbit. */
static saltus_breach fold_touch(const saltus_sequence *s, int periods, saltus_breach touch) {
    while (touch.time >= s->base + periods)
        touch.time -= periods;
    touch.value = 0;
    touch.kind = SALTUS_BREACH_GAP;
    return touch;
}

int saltus_locus_starts_grazing(saltus_orbits *o, const saltus_solution *at, const saltus_breach *touch,
                                saltus_sequence *with) {
    const double together = 1e-7, near = 1e-4;
    int order[SALTUS_MARKS_MAX], count = 0, found = -1, periods = at->sequence.periods;
    saltus_sequence less;
    saltus_lap lap = {.system = o->system, .periods = periods};
    saltus_breach *touches = calloc((size_t)at->breach_count + 1, sizeof *touches);
    if (!touches || !saltus_lap_reserve(&lap, periods, o->n)) {
        free(touches);
        o->starved = true;
        return -1;
    }
    /* The least number of periods after which the orbit closes; that of its sequence if it cannot be told. */
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < periods && status == SALTUS_OK; k++)
        status =
            saltus_solution_state_at(o, at, at->sequence.base + k, lap.points + (size_t)(k * o->n), NULL);
    if (status == SALTUS_OK)
        periods = saltus_lap_least_period(&lap, &o->options.flow);
    saltus_lap_close(&lap);
    for (int k = 0; k < at->breach_count; k++)
        if (at->breaches[k].kind == SALTUS_BREACH_SPEED)
            touches[count++] = at->breaches[k];
    saltus_sequence_graze(&at->sequence, touches, count, &less, NULL);
    less.periods = periods;
    while (less.count > 0 && less.mark[less.count - 1].time >= less.base + periods)
        less.count--;
    saltus_breach own = fold_touch(&less, periods, *touch);
    touches[0] = own;
    count = 1;
    for (int k = 0; k < at->breach_count; k++) {
        saltus_breach other = fold_touch(&less, periods, at->breaches[k]);
        bool grazes = fabs(at->breaches[k].value) < together && at->breaches[k].kind <= SALTUS_BREACH_GAP;
        for (int j = 0; j < count; j++)
            grazes = grazes && !(touches[j].face == other.face &&
                                 fabs(remainder(touches[j].time - other.time, periods)) < near);
        if (grazes)
            touches[count++] = other;
    }
    saltus_sequence_graze(&less, touches, count, with, order);
    for (int k = 0; k < with->count; k++)
        if (order[k] < 0 && with->mark[k].face == own.face && with->mark[k].time == own.time)
            found = k;
    free(touches);
    return found;
}

/* A sequence without one of its marks; returns the new index of another one. */
static int without_mark(const saltus_sequence *old, int gone, int mark, saltus_sequence *fresh) {
    bool dead[SALTUS_MARKS_MAX] = {false};
    dead[gone] = true;
    saltus_sequence_without(old, dead, fresh, NULL);
    return mark - (gone < mark);
}

/* The mark of a sequence on a face at a time of its orbit; -1: none. */
static int mark_at(const saltus_sequence *s, int face, double time) {
    const double near = 1e-4;
    for (int k = 0; k < s->count; k++)
        if (s->mark[k].face == face && fabs(remainder(s->mark[k].time - time, s->periods)) < near)
            return k;
    return -1;
}

/* The curve of an impact's grazing in two pieces: with and without another impact that grazes too. */
static int pieces(const saltus_sequence *both, int mark, int other, saltus_branch_start *starts) {
    starts[0].kind = starts[1].kind = SALTUS_POINT_GR;
    starts[0].one_way = starts[1].one_way = true;
    starts[0].sequence = *both;
    starts[0].mark = mark;
    starts[1].mark = without_mark(both, other, mark, &starts[1].sequence);
    return 2;
}

/* The mark half an orbit away from a mark, `mirrored` on another face; -1: none. */
static int counterpart(const saltus_sequence *s, int mark, bool mirrored) {
    int found = -1;
    for (int f = 0; f < SALTUS_FACES_MAX && found < 0; f++)
        if ((f != s->mark[mark].face) == mirrored)
            found = mark_at(s, f, s->mark[mark].time + 0.5 * s->periods);
    return found;
}

/* The curve of grazing of the orbits that branch off at a flip or branch point: from the sequence of those
 * that they branch off from, and the impact in it that grazes. `without`: they branch off where it is not yet
 * born. Where mirror images branch off in a scene that is not symmetric itself, that of the image too.
 * Returns how many there are, 0 where they cannot be had. */
static int grazing_of_broken(const saltus_extended *x, const saltus_sequence *whole, int mark, bool mirrored,
                             bool without, saltus_branch_start *start) {
    start->kind = SALTUS_POINT_GR;
    start->mark = mark;
    start->leaves = true;
    start->sequence = *whole;
    if (!mirrored && !saltus_sequence_join(whole, whole, &start->sequence))
        return 0;
    const int other = counterpart(&start->sequence, mark, mirrored);
    /* Where there is no stop on the other side orbits and images touch on both ways from there. */
    start->one_way = other >= 0;
    if (other < 0)
        return mirrored;
    const saltus_sequence both = start->sequence;
    const bool twice = mirrored && !x->orbits.system->mirror;
    for (int k = 0; k <= twice; k++) {
        const int own = k ? other : mark, gone = k ? mark : other;
        if (k)
            start[1] = start[0];
        start[k].sequence = both;
        start[k].mark = without ? without_mark(&both, gone, own, &start[k].sequence) : own;
    }
    return 1 + twice;
}

/* Where orbits join those of half the period, or symmetric ones: the curve of grazing of these, and that of
 * their flips or branch points. If two impacts of theirs graze there are four pieces of curves of grazing:
 * each impact's, with and without the other. */
static int joined_curves(saltus_extended *x, const saltus_locus_test *corner, const saltus_solution *at,
                         saltus_branch_start *starts) {
    const saltus_mark *own = &at->sequence.mark[x->mark];
    const saltus_breach touch = {.face = own->face, .time = own->time};
    saltus_sequence whole;
    int mark = saltus_locus_starts_grazing(&x->orbits, at, &touch, &whole);
    if (mark < 0)
        return 0;
    bool mirrored = whole.periods == at->sequence.periods;
    int other = counterpart(&whole, mark, mirrored), repeats = at->sequence.periods / whole.periods;
    starts[0].kind = SALTUS_POINT_GR;
    starts[0].mark = mark;
    starts[0].sequence = starts[1].sequence = whole;
    for (int k = 0; k < at->breach_count && corner->kind == SALTUS_POINT_GR_GR; k++) {
        int second = mark_at(&whole, at->breaches[k].face, at->breaches[k].time);
        if (fabs(at->breaches[k].value) < 1e-7 && second >= 0 && second != mark && second != other)
            return pieces(&whole, mark, second, starts) + pieces(&whole, second, mark, starts + 2);
    }
    if (corner->kind == SALTUS_POINT_GR_GR)
        return 0;
    starts[1].kind = mirrored ? SALTUS_POINT_BP : SALTUS_POINT_PD;
    starts[1].one_way = true;
    const bool without = at->sequence.count < repeats * whole.count;
    if (without) {
        saltus_sequence less = whole;
        const int left = other >= 0 ? without_mark(&whole, other, mark, &less) : mark;
        without_mark(&less, left, 0, &starts[1].sequence);
    }
    /* The branch points of orbits with impacts need a symmetric scene. */
    const int count = 1 + (!mirrored || without || x->orbits.system->mirror);
    return count + (mirrored ? grazing_of_broken(x, &whole, mark, true, without, &starts[count]) : 0);
}

/* The curves that meet a curve of grazing at a special orbit, or one of special orbits where it ends by
 * grazing. */
static int special_curves(saltus_extended *x, const saltus_locus_test *corner, saltus_point_kind special,
                          const saltus_solution *at, saltus_branch_start *starts) {
    const saltus_breach *touch = saltus_corner_touch(x, at);
    bool grazes = x->kind == SALTUS_POINT_GR;
    bool without = grazes ? corner->without : touch && touch->kind == SALTUS_BREACH_GAP;
    saltus_sequence whole = at->sequence;
    int mark = grazes ? x->mark : touch ? saltus_locus_starts_grazing(&x->orbits, at, touch, &whole) : -1;
    if (mark < 0)
        return 0;
    starts[0].kind = grazes ? special : SALTUS_POINT_GR;
    starts[0].one_way = grazes;
    starts[0].mark = grazes ? 0 : mark;
    starts[0].sequence = grazes && without ? saltus_corner_without(x, at) : whole;
    /* The branch points of orbits with impacts need a symmetric scene. */
    const int count = !grazes || special != SALTUS_POINT_BP || without || x->orbits.system->mirror;
    /* Of orbits that close after fewer periods there it is not the flip. */
    bool breaks = whole.periods == at->sequence.periods &&
                  (special == SALTUS_POINT_PD || (special == SALTUS_POINT_BP && x->mirrored));
    return count +
           (breaks ? grazing_of_broken(x, &whole, mark, special == SALTUS_POINT_BP, without, &starts[count])
                   : 0);
}

static int curves_at(saltus_extended *x, const saltus_locus_test *corner, const saltus_solution *at,
                     saltus_branch_start *starts) {
    static const saltus_point_kind special[SALTUS_POINT_KINDS] = {[SALTUS_POINT_GR_LP] = SALTUS_POINT_LP,
                                                                  [SALTUS_POINT_GR_PD] = SALTUS_POINT_PD,
                                                                  [SALTUS_POINT_GR_NS] = SALTUS_POINT_NS,
                                                                  [SALTUS_POINT_GR_BP] = SALTUS_POINT_BP};
    saltus_branch_start *start = &starts[0];
    start->sequence = at->sequence;
    if (corner->joins && x->kind == SALTUS_POINT_GR)
        return joined_curves(x, corner, at, starts);
    if (corner->joins) {
        /* The flips of the shorter orbits and, at a double multiplier, their tori. */
        starts[0].kind = SALTUS_POINT_PD;
        starts[1].kind = SALTUS_POINT_NS;
        starts[0].sequence = starts[1].sequence = saltus_sequence_part(&at->sequence, 2);
        starts[1].theta = M_PI;
        return corner->kind == SALTUS_POINT_R2 ? 2 : 0;
    }
    if (corner->kind == SALTUS_POINT_GR_GR) {
        /* The curves of the other impact's grazing, with and without the first impact. */
        const saltus_breach *touch = saltus_corner_touch(x, at);
        const saltus_mark *first = &at->sequence.mark[x->mark];
        saltus_sequence both;
        const int other = touch ? saltus_locus_starts_grazing(&x->orbits, at, touch, &both) : -1,
                  own = other < 0 ? -1 : mark_at(&both, first->face, first->time);
        return own < 0 || both.periods != at->sequence.periods ? 0 : pieces(&both, other, own, starts);
    }
    if (corner->kind == SALTUS_POINT_GH) {
        start->kind = SALTUS_POINT_HB;
        start->sequence = (saltus_sequence){.base = at->sequence.base,
                                            .periods = 1,
                                            .contacts = at->sequence.contacts,
                                            .omega = at->sequence.omega / at->sequence.periods};
        return 1;
    }
    if (corner->kind == SALTUS_POINT_R1 || corner->kind == SALTUS_POINT_R2) {
        bool at_one = corner->kind == SALTUS_POINT_R1;
        start->kind = x->kind != SALTUS_POINT_NS ? SALTUS_POINT_NS
                      : corner->theta > M_PI     ? SALTUS_POINT_BP
                      : at_one                   ? SALTUS_POINT_LP
                                                 : SALTUS_POINT_PD;
        start->theta = at_one ? 0 : M_PI;
        return 1;
    }
    /* Two impacts of a planar cycle that graze together make its equations singular twice over. */
    const bool planar = at->sequence.omega > 0 && x->orbits.n == 2;
    if (planar && x->mirrored && x->orbits.system->mirror && x->kind == SALTUS_POINT_GR && !corner->without)
        return 0;
    start->theta = corner->theta;
    return special[corner->kind] ? special_curves(x, corner, special[corner->kind], at, starts) : 0;
}

void saltus_locus_starts_meet(saltus_extended *x, const saltus_locus_test *corner, const saltus_solution *at,
                              int parent, int depth, saltus_starts *starts) {
    saltus_branch_start fresh[4] = {{.kind = SALTUS_POINT_REGULAR}};
    int count = curves_at(x, corner, at, fresh);
    /* At an orbit of a family only its grazing is a curve, and what branches off belongs to a family if
     * orbits of twice the period form one. At R1 and R2 multipliers are double without a family. */
    bool doubled = false;
    const bool family = count > 0 && corner->kind != SALTUS_POINT_R1 && corner->kind != SALTUS_POINT_R2 &&
                        saltus_change_in_family(&x->orbits, at, &doubled);
    for (int k = 0; k < count; k++) {
        if (fresh[k].leaves ? doubled : family && fresh[k].kind != SALTUS_POINT_GR)
            continue;
        fresh[k].origin = corner->kind;
        fresh[k].parent = parent;
        fresh[k].depth = depth;
        memcpy(fresh[k].parameter, at->parameter, sizeof at->parameter);
        if (!is_there(starts, &fresh[k], image_shift(x)))
            saltus_starts_add_at(&x->orbits, at, &fresh[k], starts);
    }
}

saltus_branch_start *saltus_locus_starts_next(saltus_starts *starts, bool of_rests) {
    for (starts->begun = 1; starts->begun <= starts->count; starts->begun++) {
        saltus_branch_start *s = &starts->start[starts->begun - 1];
        const bool own = s->kind == SALTUS_POINT_HB || s->kind == SALTUS_POINT_BE ||
                         s->origin == SALTUS_POINT_BT || s->origin == SALTUS_POINT_BE;
        if (!s->done && own == of_rests)
            return s;
    }
    return NULL;
}
