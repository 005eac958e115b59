/* Sets of small numbers as bits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_BITS_H
#define SALTUS_BASE_BITS_H

static inline int saltus_count_bits(unsigned bits) {
    int count = 0;
    for (; bits; bits &= bits - 1)
        count++;
    return count;
}

#endif
