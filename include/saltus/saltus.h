/* All of Saltus' public headers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SALTUS_H
#define SALTUS_SALTUS_H

#include "saltus/average.h"
#include "saltus/branch.h"
#include "saltus/equilibrium.h"
#include "saltus/figure.h"
#include "saltus/flow.h"
#include "saltus/harvest.h"
#include "saltus/lyapunov.h"
#include "saltus/map.h"
#include "saltus/motion.h"
#include "saltus/orbit.h"
#include "saltus/record.h"
#include "saltus/scene.h"
#include "saltus/series.h"
#include "saltus/signal.h"
#include "saltus/spectrum.h"
#include "saltus/status.h"
#include "saltus/sweep.h"
#include "saltus/system.h"
#include "saltus/trajectory.h"

#endif
