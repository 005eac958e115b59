/* Private: what makes a system ask for too much.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_CAUSE_H
#define SALTUS_SYSTEM_CAUSE_H

#include "saltus/system.h"

/* The likely cause of very many steps or of a motion beyond all scales, with its value: what is
 * farthest from its default or from the scale of the motion, a parameter, a pre-load or a clearance, the next
 * one beside it if that is far too; or a number of masses or modes. */
enum { SALTUS_CAUSE_MAX = 200 };
const char *saltus_system_cause(const saltus_system *system, char cause[SALTUS_CAUSE_MAX]);

#endif
