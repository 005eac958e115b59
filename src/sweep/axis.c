/* Axes of a sweep: their values, and reading them from text.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/sweep.h"

#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { axis_values_max = 10000000 };

double saltus_axis_value(const saltus_axis *axis, int k) {
    if (axis->list)
        return axis->list[k];
    if (k == 0 || axis->count == 1)
        return axis->low;
    if (k == axis->count - 1)
        return axis->high;
    double part = (double)k / (axis->count - 1);
    return axis->spacing == SALTUS_LOGARITHMIC ? axis->low * pow(axis->high / axis->low, part)
                                               : axis->low + (axis->high - axis->low) * part;
}

static saltus_status refuse(const char *text, const char *what, saltus_message *message) {
    return saltus_fail(message, SALTUS_BAD_INPUT,
                       "%.100s: %s; write key=low:high:count, key=low:high:count:log or key=v1,v2,...", text,
                       what);
}

static saltus_status read_grid(const char *text, const char *values, saltus_axis *axis,
                               saltus_message *message) {
    double count = 0;
    const char *end = saltus_read_number_until(values, ":", &axis->low);
    if (!end || *end != ':')
        return refuse(text, "the first value is no number", message);
    end = saltus_read_number_until(end + 1, ":", &axis->high);
    if (!end || *end != ':')
        return refuse(text, "a grid needs a last value and a count", message);
    end = saltus_read_number_until(end + 1, ":", &count);
    bool logarithmic = end && strcmp(end, ":log") == 0;
    if (end && *end == ':' && !logarithmic)
        return refuse(text, "after the count only log can stand", message);
    if (!end || (*end && !logarithmic) || count != floor(count) || count < 2 || count > axis_values_max)
        return refuse(text, "the count must be a whole number from 2 to 10000000", message);
    axis->count = (int)count;
    axis->spacing = logarithmic ? SALTUS_LOGARITHMIC : SALTUS_LINEAR;
    if (!isfinite(axis->low) || !isfinite(axis->high) || axis->low == axis->high)
        return refuse(text, "the ends must be two different finite numbers", message);
    if (logarithmic && !(axis->low > 0 && axis->high > 0))
        return refuse(text, "a logarithmic grid needs ends above zero", message);
    return SALTUS_OK;
}

static saltus_status read_list(const char *text, const char *values, saltus_axis *axis, double **list,
                               saltus_message *message) {
    size_t room = 1, count = 0;
    for (const char *c = values; *c; c++)
        room += *c == ',';
    double *numbers = malloc(room * sizeof *numbers);
    if (!numbers)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the values of %.100s", text);
    for (const char *end = values - 1; count == 0 || *end;) {
        end = saltus_read_number_until(end + 1, ",", &numbers[count++]);
        if (!end) {
            free(numbers);
            return refuse(text, "the values must be finite numbers with commas between them", message);
        }
    }
    axis->spacing = SALTUS_LIST;
    axis->count = (int)count;
    axis->low = numbers[0];
    axis->high = numbers[count - 1];
    axis->list = *list = numbers;
    return SALTUS_OK;
}

saltus_status saltus_axis_read(const char *text, saltus_axis *axis, double **list, saltus_message *message) {
    const char *equals = strchr(text, '=');
    size_t length = equals ? (size_t)(equals - text) : 0;
    *axis = (saltus_axis){.count = 0};
    *list = NULL;
    if (length == 0 || length >= sizeof axis->key)
        return refuse(text, "no key stands before an equals sign", message);
    memcpy(axis->key, text, length);
    return strchr(equals, ':') ? read_grid(text, equals + 1, axis, message)
                               : read_list(text, equals + 1, axis, list, message);
}
