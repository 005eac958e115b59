/* Time in forcing periods.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include <math.h>

double saltus_time_periods(saltus_time time) {
    return (double)time.cycle + time.phase;
}

saltus_status saltus_time_check(saltus_time time, saltus_message *message) {
    const double phase_max = 1e15; /* larger doubles hold no phase */
    if (fabs(time.phase) <= phase_max)
        return SALTUS_OK;
    return saltus_fail(message, SALTUS_BAD_INPUT,
                       "time: phase = %g: must be a number of periods, at most 1e15", time.phase);
}

saltus_time saltus_time_after(saltus_time time, double periods) {
    double phase = time.phase + periods;
    if (phase >= 0 && phase < 1)
        return (saltus_time){time.cycle, phase};
    double whole = floor(phase);
    return (saltus_time){time.cycle + (long long)whole, phase - whole};
}

saltus_time saltus_time_of(double periods) {
    double whole = floor(periods);
    return (saltus_time){(long long)whole, periods - whole};
}

int saltus_time_compare(saltus_time a, saltus_time b) {
    if (a.cycle != b.cycle)
        return a.cycle < b.cycle ? -1 : 1;
    return a.phase < b.phase ? -1 : a.phase > b.phase;
}
