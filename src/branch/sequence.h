/* Private: edits of event sequences. Nothing here computes an orbit.
 *
 * Every edit gives in `order` (may be NULL) the former index of each mark of the new sequence, -1 for new
 * ones, so that what belongs to a mark can follow it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_SEQUENCE_H
#define SALTUS_BRANCH_SEQUENCE_H

#include "orbit/shooting.h"

/* The sequence beyond grazing: impacts whose speed has fallen to zero are removed, free maxima that touch a
 * stop become impacts. Returns what happens in words ("an impact is born"); NULL: nothing, since the maximum
 * is too close to an impact to be distinguished from that impact's own touch. */
const char *saltus_sequence_graze(const saltus_sequence *old, const saltus_breach *breaches, int count,
                                  saltus_sequence *fresh, int *order);
/* The sequence without the marks that are `gone`. */
void saltus_sequence_without(const saltus_sequence *old, const bool gone[SALTUS_MARKS_MAX],
                             saltus_sequence *fresh, int *order);
/* Once around one orbit, then around another with the same base and period, or the same again; false if there
 * are too many marks. */
bool saltus_sequence_join(const saltus_sequence *first, const saltus_sequence *second,
                          saltus_sequence *fresh);

/* Without forcing: count the times of an orbit by half their unit where an odd number of units makes the
 * orbit, so that its halves are seen. */
void saltus_sequence_even(saltus_sequence *sequence);
/* The first of equal `parts` of an orbit that are alike. */
saltus_sequence saltus_sequence_part(const saltus_sequence *sequence, int parts);

/* How far, in periods, the marks are from repeating after each of `parts` equal parts of the orbit;
 * `mirrored`: on the other face. INFINITY if faces or kinds do not repeat, or if there are no marks to
 * compare. */
double saltus_sequence_repeats(const saltus_sequence *sequence, int parts, bool mirrored);

/* Whether chatter completes in the piece after a driven mark k: the next mark of its face is the release. */
bool saltus_sequence_completes(const saltus_sequence *sequence, int k);
/* Whether the flow finds other events than those that complete chatter: the tail of a long run. */
bool saltus_sequence_has_tail(const saltus_sequence *sequence);

/* The middle of the longest free flight between two marks, where nothing is left to the flow; the present
 * base if there is none. */
double saltus_sequence_amid_flight(const saltus_sequence *sequence);
/* The base, or another one where an event is near it or half an orbit later: then the middle of the longest
 * interval without events in both halves. */
double saltus_sequence_amid_halves(const saltus_sequence *sequence);
/* The sequence cut open at a time within the orbit, with up to `cuts` cuts in free flight. */
void saltus_sequence_turn(const saltus_sequence *old, double base, int cuts, saltus_sequence *fresh,
                          int *order);

/* A better way to cut an orbit into unknowns: the base in the middle of the longest free flight if an event
 * has come near the present one, up to `cuts` cuts in free flight, and with `trims` the tail of a long run of
 * ever slower impacts (orbit/sequence.h) left to the flow. `speed` belongs to the marks. False: it is good as
 * it is. */
bool saltus_sequence_reframe(const saltus_sequence *old, const double *speed, int cuts, bool trims,
                             saltus_sequence *fresh, int *order);

/* Convert a vector of the old sequence's unknowns (states of n numbers, times, `parameters`) to those of the
 * new sequence; what has no counterpart is zero. Without `order` the marks are the same. If the period is an
 * unknown and the base moves, only differences of the times are kept, which do not depend on the base. */
void saltus_sequence_carry(const saltus_sequence *old, const double *vector, const saltus_sequence *fresh,
                           const int *order, int n, int parameters, double *out);

#endif
