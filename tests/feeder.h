/* What takes a sweep's results in the tests: the context is the output that they go to.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_FEEDER_H
#define SALTUS_TESTS_FEEDER_H

#include "saltus/saltus.h"

static inline saltus_status take_result(void *output, const saltus_sweep_result *result,
                                        saltus_message *message) {
    return saltus_sweep_output_take(output, result, message);
}

#endif
