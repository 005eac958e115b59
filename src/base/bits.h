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

/* The subset of `set` that follows `subset`. The order is by size, then by value, from the empty subset to
 * the whole set; nothing follows the whole set. */
static inline unsigned saltus_next_subset(unsigned set, unsigned subset) {
    unsigned packed = 0, next = 0;
    int members = 0, size = saltus_count_bits(subset);
    for (unsigned rest = set; rest; rest &= rest - 1, members++)
        if (subset & rest & -rest)
            packed |= 1u << members;
    if (packed) { /* Gosper's hack: the next number with as many bits */
        const unsigned low = packed & -packed, up = packed + low;
        next = up | ((packed ^ up) >> 2) / low;
    }
    if (!packed || next >> members)
        next = (1u << (size + 1)) - 1;
    unsigned found = 0;
    for (unsigned rest = set; rest; rest &= rest - 1, next >>= 1)
        if (next & 1)
            found |= rest & -rest;
    return found;
}

#endif
