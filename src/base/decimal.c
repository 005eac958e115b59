/* Numbers as text that reads back exactly: what "%.17g" of the C locale writes, several times as fast, since
 * tables of millions of numbers are mostly made of that.
 *
 * A number m 2^e has the decimal digits of m 10^p 2^e with p chosen so that 17 stand before the point. For
 * the sizes that occur in tables m 5^p fits into 128 bits, so that the product is exact and so is its
 * rounding; other numbers are left to the C library.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/field.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { digits_all = 17, most_power = 31 }; /* m < 2^53 and 5^31 < 2^73 */

__extension__ typedef unsigned __int128 wide;

/* 10^16 and 10^17, between which the digits lie as a whole number. */
static const uint64_t least = 10000000000000000u, above = 100000000000000000u;

/* The whole number nearest to m 10^p 2^e, ties to even; false if that cannot be told exactly here. */
static bool scale(uint64_t m, int e, int p, uint64_t *number) {
    /* Powers of five, and of 5^8. */
    static const uint64_t few[] = {1, 5, 25, 125, 625, 3125, 15625, 78125},
                          many[] = {1, 390625, 152587890625, 59604644775390625};
    const int shift = -(e + p);
    if (p < 0 || p > most_power || shift <= 0 || shift > 126)
        return false;
    const wide product = (wide)m * few[p % 8] * many[p / 8];
    const wide whole = product >> shift, rest = product - (whole << shift), half = (wide)1 << (shift - 1);
    if (whole > above)
        return false;
    *number = (uint64_t)whole + (rest > half || (rest == half && (whole & 1)));
    return true;
}

/* The digits of a positive number and the power of ten of the first; false if they are not found here. */
static bool find_digits(double value, uint64_t *number, int *power) {
    int e;
    const uint64_t m = (uint64_t)ldexp(frexp(value, &e), 53);
    /* 10^power <= value, or one less: then there are 18 digits. */
    *power = (int)floor((e - 1) * 0.30102999566398120);
    if (!scale(m, e - 53, digits_all - 1 - *power, number))
        return false;
    if (*number < above)
        return *number >= least;
    ++*power;
    return scale(m, e - 53, digits_all - 1 - *power, number) && *number >= least && *number < above;
}

const char *saltus_number_of(double value, int digits, char *text) {
    snprintf(text, SALTUS_NUMBER_MAX, "%.*g", digits, isnan(value) ? NAN : value);
    char *comma = strchr(text, ',');
    if (comma)
        *comma = '.';
    return text;
}

const char *saltus_number(double value, char *text) {
    uint64_t number;
    int power;
    char all[digits_all + 1], *at = text;
    if (!isfinite(value) || value == 0 || !find_digits(fabs(value), &number, &power))
        return saltus_number_of(value, digits_all, text);
    int count = digits_all;
    /* Two halves, whose digits do not wait for each other. */
    uint32_t first = (uint32_t)(number / 1000000000), last = (uint32_t)(number % 1000000000);
    for (int k = 8; k > 0; k--, first /= 10, last /= 10) {
        all[8 + k] = (char)('0' + last % 10);
        all[k - 1] = (char)('0' + first % 10);
    }
    all[8] = (char)('0' + last);
    while (count > 1 && all[count - 1] == '0')
        count--;
    if (signbit(value))
        *at++ = '-';
    if (power < -4 || power >= digits_all) {
        *at++ = all[0];
        if (count > 1)
            *at++ = '.';
        memcpy(at, all + 1, (size_t)count - 1);
        sprintf(at + count - 1, "e%+03d", power);
        return text;
    }
    /* Digits before the point, or zeros after it. */
    const int before = power < 0 ? 0 : power + 1;
    if (power < 0) {
        memcpy(at, "0.000", 5);
        at += 1 - power;
    }
    for (int k = 0; k < count || k < before; k++) {
        if (k == before && before)
            *at++ = '.';
        *at++ = k < count ? all[k] : '0';
    }
    *at = '\0';
    return text;
}
