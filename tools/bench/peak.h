/* The largest rate of floating-point operations that one core of this machine reaches.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_PEAK_H
#define SALTUS_BENCH_PEAK_H

/* Operations per second (a fused multiply-add is two) of independent fused multiply-adds in double precision,
 * with the widest instructions of this processor, whose name `instructions` receives. Takes about a tenth of
 * a second. */
double bench_peak(const char **instructions);

#endif
