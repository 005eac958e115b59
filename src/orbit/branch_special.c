/* Special points on a step: found by the signs of tests, located, given out in their order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include <math.h>

/* A special point between `here` and `next`; a regular one where the branch may have come back to its begin.
 */
typedef struct find {
    saltus_point_kind kind;
    saltus_test test;
    double target, ahead, accuracy;
} find;

static bool crosses(double a, double c) {
    return isfinite(a) && isfinite(c) && a != 0 && a * c <= 0;
}

/* Locate one; insert in order of arclength. */
static int add_find(saltus_branch *b, find *finds, int count, saltus_point_kind kind, saltus_test test,
                    double target) {
    double far = test == SALTUS_TEST_VALUE ? saltus_shooting_value(b->shooting, b->next.u) - target
                                           : b->next.test[test];
    find f = {.kind = kind, .test = test, .target = target};
    b->target = target;
    b->here.test[SALTUS_TEST_VALUE] = saltus_shooting_value(b->shooting, b->here.u) - target;
    if (!crosses(b->here.test[test], far))
        return count;
    double near = b->here.test[test];
    if (far == 0)
        f.ahead = b->next.ahead;
    else if (saltus_branch_locate(b, test, b->next.ahead, far, &f.accuracy))
        f.ahead = b->trial.ahead;
    else if (kind == SALTUS_POINT_BP) /* singular there: found by interpolation later */
        f.ahead = b->next.ahead * near / (near - far);
    else
        return count;
    int k = count;
    for (; k > 0 && finds[k - 1].ahead > f.ahead; k--)
        finds[k] = finds[k - 1];
    finds[k] = f;
    return count + 1;
}

static saltus_status give_join(saltus_branch *b, const find *f, saltus_message *message) {
    static const char reason[] = "joins the orbits of half the period";
    double value, accuracy = f->accuracy;
    bool sharp = saltus_branch_flip_of_half(b, &value, &accuracy);
    saltus_status status = saltus_branch_survey(b, &b->trial, message);
    if (status == SALTUS_OK)
        status = saltus_branch_emit(b, &b->trial, SALTUS_POINT_PD, accuracy, NULL, reason, message);
    if (status == SALTUS_OK && sharp)
        b->queue[b->queue_count - 1].value[0] = value;
    if (status == SALTUS_OK)
        status = saltus_branch_end(b, &b->trial, NAN, reason, message);
    if (status == SALTUS_OK && sharp)
        b->queue[b->queue_count - 1].value[0] = value;
    return status;
}

/* Whether `trial` is where the branch joins that of half the period. So near to it the equations say little
 * about where; a flip of half the period in this very place tells. */
static bool is_join(saltus_branch *b) {
    double apart = saltus_branch_half_distance(b, &b->trial, false), value, accuracy;
    double here = saltus_shooting_value(b->shooting, b->trial.u);
    return apart < 1e-4 || (apart < 2e-2 && saltus_branch_flip_of_half(b, &value, &accuracy) &&
                            fabs(value - here) < 1e-6 * b->unit);
}

/* Whether `trial`, a fold, is where orbits that are not their own mirror images become so: the branch of
 * symmetric orbits. */
static bool is_own_image(saltus_branch *b) {
    bool shift;
    if (!saltus_system_mirror_symmetric(b->system, &shift))
        return false;
    double apart = saltus_branch_half_distance(b, &b->trial, true);
    return apart < 1e-3 && apart < 0.05 * saltus_branch_half_distance(b, &b->here, true);
}

static saltus_status give_image(saltus_branch *b, const find *f, saltus_message *message) {
    static const char reason[] = "joins the orbits that are their own mirror images";
    saltus_status status = saltus_branch_survey(b, &b->trial, message);
    if (status == SALTUS_OK)
        status = saltus_branch_emit(b, &b->trial, SALTUS_POINT_BP, f->accuracy, NULL, reason, message);
    return status == SALTUS_OK ? saltus_branch_end(b, &b->trial, NAN, reason, message) : status;
}

/* The point found becomes `trial` again. */
static bool revisit(saltus_branch *b, find *f) {
    saltus_message ignored;
    if (f->kind == SALTUS_POINT_BP && saltus_branch_crossing(b, f->ahead, &f->accuracy))
        return true;
    return saltus_branch_visit(b, f->ahead, &b->trial, &ignored) == SALTUS_OK;
}

/* Whether the orbit just walked is the one that the branch began with. */
static bool is_first(const saltus_branch *b) {
    return saltus_orbit_passes(b->system, b->first, b->first_count, b->lap.points, SALTUS_SAME_POINT);
}

static saltus_status give_find(saltus_branch *b, find *f, saltus_message *message) {
    b->target = f->target;
    if (!revisit(b, f))
        return SALTUS_OK;
    saltus_status status = saltus_branch_survey(b, &b->trial, message);
    if (status != SALTUS_OK)
        return status;
    if (f->kind == SALTUS_POINT_NS && !saltus_branch_pair_on_circle(b, &b->trial))
        return SALTUS_OK;
    if (f->kind == SALTUS_POINT_LP || f->kind == SALTUS_POINT_BP) {
        if (is_join(b))
            return give_join(b, f, message);
        if (is_own_image(b))
            return give_image(b, f, message);
        status = saltus_branch_survey(b, &b->trial, message);
        if (status != SALTUS_OK)
            return status;
    }
    if (b->options.locus && b->options.locus == f->kind)
        return saltus_branch_capture(b, -1, message);
    if (f->kind == SALTUS_POINT_REGULAR && !is_first(b))
        return status;
    if (f->kind == SALTUS_POINT_REGULAR) {
        /* The other way from the same start leads around the same branch. */
        b->start_next += b->start_next == 1 && b->start_count > 1 && b->starts[1].heading;
        return saltus_branch_end(b, &b->trial, f->accuracy, "the branch is closed: it has come back",
                                 message);
    }
    if (f->kind == SALTUS_POINT_EP)
        return saltus_branch_end(b, &b->trial, f->accuracy, "end of the parameter's range", message);
    status = saltus_branch_emit(b, &b->trial, f->kind, f->accuracy, NULL, NULL, message);
    if (status == SALTUS_OK && (f->kind == SALTUS_POINT_PD || f->kind == SALTUS_POINT_BP))
        status = saltus_branch_switch(b, f->kind, message);
    return status;
}

saltus_status saltus_branch_special_points(saltus_branch *b, int *given, saltus_message *message) {
    find finds[7 + SALTUS_BRANCH_VALUES_MAX];
    int count = 0;
    saltus_status status = SALTUS_OK;
    /* At the begin of a branch that was switched to, the determinants are zero to rounding and tell nothing.
     */
    if (!b->fresh) {
        count = add_find(b, finds, count, SALTUS_POINT_LP, SALTUS_TEST_FOLD, 0);
        count = add_find(b, finds, count, SALTUS_POINT_PD, SALTUS_TEST_FLIP, 0);
        count = add_find(b, finds, count, SALTUS_POINT_BP, SALTUS_TEST_BRANCH, 0);
        count = add_find(b, finds, count, SALTUS_POINT_NS, SALTUS_TEST_PAIR, 0);
    }
    count = add_find(b, finds, count, SALTUS_POINT_EP, SALTUS_TEST_VALUE, b->options.low[0]);
    count = add_find(b, finds, count, SALTUS_POINT_EP, SALTUS_TEST_VALUE, b->options.high[0]);
    if (b->first_count && b->points > 10)
        count = add_find(b, finds, count, SALTUS_POINT_REGULAR, SALTUS_TEST_VALUE, b->first_value);
    for (int k = 0; k < b->options.value_count; k++)
        count = add_find(b, finds, count, SALTUS_POINT_UZ, SALTUS_TEST_VALUE, b->options.values[k]);
    for (int k = 0; k < count && status == SALTUS_OK && b->running; k++)
        status = give_find(b, &finds[k], message);
    *given = count;
    return status;
}
