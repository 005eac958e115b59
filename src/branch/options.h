/* Private: options of a continuation.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_OPTIONS_H
#define SALTUS_BRANCH_OPTIONS_H

#include "base/field.h"
#include "orbit/shooting.h"
#include "saltus/branch.h"

/* Values of the parameter that may be asked for. */
enum { SALTUS_BRANCH_VALUES_MAX = 1000 };

/* Of saltus_branch_options, `values` excepted. */
extern const saltus_option_table saltus_branch_table;

/* Whether the options are in range and belong to the specification. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_branch_check(const saltus_branch_options *options, const saltus_spec *spec,
                                  saltus_message *message);
/* The family of scenes along one or both parameters of the options, which are checked: their values at the
 * specification (`origin`), and the borders of their ranges in their unknowns. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_branch_family(const saltus_spec *spec, const saltus_branch_options *options,
                                   int parameters, saltus_family *family, double *origin, double border[][2],
                                   saltus_message *message);

#endif
