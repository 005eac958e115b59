/* Private: what makes a system ask for too much.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_CAUSE_H
#define SALTUS_SYSTEM_CAUSE_H

#include "saltus/system.h"

/* The likely cause of very many steps or of a motion beyond all scales, with its value: the parameter
 * farthest from its default, a pre-load, a clearance, or a number of masses or modes. */
enum { SALTUS_CAUSE_MAX = 120 };
const char *saltus_system_cause(const saltus_system *system, char cause[SALTUS_CAUSE_MAX]);

#endif
