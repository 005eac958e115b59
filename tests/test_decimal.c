/* Numbers in tables: the same text as the C library's 17 digits, which read back exactly.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "base/field.h"

#include <float.h>
#include <stdint.h>

static uint64_t state = 88172645463325252u;

static uint64_t next_word(void) {
    state ^= state << 13;
    state ^= state >> 7;
    return state ^= state << 17;
}

static void check_number(double value) {
    char text[SALTUS_NUMBER_MAX], wanted[64], *end;
    snprintf(wanted, sizeof wanted, "%.17g", isnan(value) ? NAN : value);
    assert_string_equal(saltus_number(value, text), wanted);
    const double read = strtod(text, &end);
    assert_true(*end == '\0' && (isnan(value) || memcmp(&read, &value, sizeof read) == 0));
}

/* Of any bits, of sizes as in tables, with few digits, exact ties, small and large ones. */
static void numbers_are_those_of_the_library(void **unused) {
    (void)unused;
    enum { count = 300000 };
    for (int k = 0; k < count; k++) {
        const uint64_t word = next_word();
        double any;
        memcpy(&any, &word, sizeof any);
        if (!isnan(any))
            check_number(any);
        check_number((double)(word >> 11) * 0x1p-53 - 0.5);
        check_number((double)(word >> 40) / 1000);
        check_number((double)(word % 1000) * pow(10, (int)(word >> 20 & 31) - 16));
        check_number(ldexp((double)(word >> 11), -(int)(word % 120)));
        check_number(ldexp((double)(word >> 44 | 1), -(int)(word % 64)));
        check_number(-(double)(word >> 8));
    }
}

/* Beside powers of ten, where the number of digits before the point changes, and at the ends of what there
 * is. */
static void ends_are_exact(void **unused) {
    (void)unused;
    static const double ends[] = {0.0,      -0.0,     DBL_MIN,   DBL_MAX, DBL_TRUE_MIN,
                                  -DBL_MAX, INFINITY, -INFINITY, NAN};
    for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++)
        check_number(ends[k]);
    for (int power = -30; power <= 30; power++) {
        double low = pow(10, power), high = low;
        for (int k = 0; k < 40; k++) {
            check_number(low);
            check_number(-high);
            low = nextafter(low, 0);
            high = nextafter(high, INFINITY);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_those_of_the_library),
        cmocka_unit_test(ends_are_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
