/* Private: edits of event sequences. Nothing here computes an orbit.
 *
 * Every edit tells in `order` where the marks of the new sequence stood in the old one, -1 for new ones, so
 * that what belongs to marks can follow them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_SEQUENCE_H
#define SALTUS_BRANCH_SEQUENCE_H

#include "orbit/shooting.h"

/* Beyond grazing: impacts whose speed has fallen to zero are taken out, free maxima that touch a stop become
 * impacts. Returns what happens in words ("an impact is born"); NULL: nothing, as a maximum is too near to an
 * impact to be told from that impact's own touch. */
const char *saltus_sequence_graze(const saltus_sequence *old, const saltus_breach *breaches, int count,
                                  saltus_sequence *fresh, int *order);
/* The orbit gone through twice; false where that are too many marks. */
bool saltus_sequence_double(const saltus_sequence *old, saltus_sequence *fresh);
/* Once around one orbit, then around the other, which has the same base and period; false as above. */
bool saltus_sequence_join(const saltus_sequence *first, const saltus_sequence *second,
                          saltus_sequence *fresh);

/* The first half of an orbit of even period whose halves are alike. */
saltus_sequence saltus_sequence_first_half(const saltus_sequence *sequence);

/* How far, in periods, the marks are from repeating after each of so many equal parts of the orbit:
 * `mirrored`, each on another face than the one a part before. INFINITY where faces or kinds do not repeat,
 * or nothing can be told as there are no marks. */
double saltus_sequence_repeats(const saltus_sequence *sequence, int parts, bool mirrored);

/* Whether impacts are left to the flow but for those that complete chatter: the tail of a long run. */
bool saltus_sequence_has_tail(const saltus_sequence *sequence);

/* The middle of the longest free flight between two marks that the flow need not find its events in; the
 * present base if there is none. */
double saltus_sequence_amid_flight(const saltus_sequence *sequence);
/* The sequence cut open at a time within the orbit, with `cuts` cuts in free flight; order: where the marks
 * stood. */
void saltus_sequence_turn(const saltus_sequence *old, double base, int cuts, saltus_sequence *fresh,
                          int *order);

/* How an orbit should be cut into unknowns: its base in the middle of the longest free flight, if an event
 * has come near the present one, `cuts` cuts in free flight, and the tail of a long run of ever slower
 * impacts (orbit/sequence.h) left to the flow if `trims`. `speed` belongs to the marks. False: it is good as
 * it is. */
bool saltus_sequence_reframe(const saltus_sequence *old, const double *speed, int cuts, bool trims,
                             saltus_sequence *fresh, int *order);

/* A vector of the old sequence's unknowns (states of n numbers, times, `parameters`) becomes one of the new
 * sequence's; what has no counterpart is zero. From another base of an orbit of a period of its own only the
 * times' differences are kept, which do not depend on the base. */
void saltus_sequence_carry(const saltus_sequence *old, const double *vector, const saltus_sequence *fresh,
                           const int *order, int n, int parameters, double *out);

#endif
