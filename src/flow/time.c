/* Time in forcing periods.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include <math.h>

double saltus_time_periods(saltus_time time) {
    return (double)time.cycle + time.phase;
}

saltus_time saltus_time_after(saltus_time time, double periods) {
    double phase = time.phase + periods;
    if (phase >= 0 && phase < 1)
        return (saltus_time){time.cycle, phase};
    double whole = floor(phase);
    return (saltus_time){time.cycle + (long long)whole, phase - whole};
}
