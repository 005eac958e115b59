/* Private: options of a continuation.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_OPTIONS_H
#define SALTUS_BRANCH_OPTIONS_H

#include "base/field.h"
#include "orbit/shooting.h"
#include "saltus/branch.h"

/* The most parameter values that may be asked for. */
enum { SALTUS_BRANCH_VALUES_MAX = 1000 };

/* The options of saltus_branch_options, except `values`. */
extern const saltus_option_table saltus_branch_table;

/* Check that the options are in range and fit the specification, and narrow their ranges to where scenes
 * exist: to the domains of the parameters, whose borders in rounding's reach are taken as short decimal
 * numbers. ends[parameter][side, 0 low] is why a branch ends there. Of a curve's ranges only such ends are
 * moved beyond which no scene exists whatever the other parameter. Errors: SALTUS_BAD_INPUT,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_branch_fit(saltus_branch_options *options, const saltus_spec *spec,
                                char ends[2][2][SALTUS_REASON_MAX], saltus_message *message);
/* The family of scenes along one or both parameters of checked options: `origin` gets the parameters' values
 * at the specification, `border` the borders of their ranges in their unknowns. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_branch_family(const saltus_spec *spec, const saltus_branch_options *options,
                                   int parameters, saltus_family *family, double *origin, double border[][2],
                                   saltus_message *message);

#endif
