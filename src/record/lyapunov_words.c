/* Exponents in numbers and words.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/lyapunov_words.h"

#include <math.h>
#include <stdio.h>

static int clamped(double value, int low, int high) {
    return value < low ? low : value > high ? high : (int)value;
}

/* Power of ten of a number's first digit once it is rounded to two digits. */
static int leading_power(double number) {
    double power = floor(log10(number));
    return (int)(number / pow(10, power) >= 9.95 ? power + 1 : power);
}

saltus_uncertain saltus_uncertain_text(double value, double error) {
    saltus_uncertain text;
    const size_t room = sizeof text.value;
    if (!isfinite(value) || !isfinite(error) || !(error > 0)) {
        if (isinf(value))
            snprintf(text.value, room, "%sinfinity", value < 0 ? "-" : "");
        else
            snprintf(text.value, room, "%.6g", value);
        snprintf(text.error, room, "%s", error == 0 ? "0" : "unknown");
        return text;
    }
    int first = leading_power(error), last = first - 1;
    double size = fmax(fabs(value), error);
    if (size >= 1e-3 && size < 1e6) {
        int decimals = clamped(-last, 0, 15);
        snprintf(text.value, room, "%.*f", decimals, value);
        if (first >= -4)
            snprintf(text.error, room, "%.*f", decimals, error);
        else
            snprintf(text.error, room, "%.1e", error);
        return text;
    }
    double lead = value == 0 ? first : floor(log10(fabs(value)));
    snprintf(text.value, room, "%.*e", clamped(lead - last, 0, 15), value);
    snprintf(text.error, room, "%.1e", error);
    return text;
}

saltus_sense saltus_lyapunov_sense(const saltus_lyapunov *l) {
    double exponent = l->exponents[0], error = l->standard_errors[0];
    if (exponent == -INFINITY)
        return SALTUS_SENSE_MEET;
    if (fabs(exponent) > 3 * error)
        return exponent > 0 ? SALTUS_SENSE_SEPARATE : SALTUS_SENSE_APPROACH;
    return l->precise ? SALTUS_SENSE_KEEP : SALTUS_SENSE_UNRESOLVED;
}

const char *saltus_sense_word(saltus_sense sense) {
    static const char *const words[] = {"positive", "negative", "zero", "unresolved", "lost"};
    return words[sense];
}

const char *saltus_lost_words(const saltus_system *system) {
    for (int f = 0; f < saltus_system_face_count(system); f++)
        if (saltus_system_face(system, f).r == 0)
            return "lost in lasting contacts or impacts without rebound";
    return "lost in lasting contacts";
}
