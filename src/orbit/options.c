/* Options of shooting.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/options.h"

#include <math.h>

static const saltus_option choices[] = {SALTUS_ORBIT_CHOICES(saltus_orbit_options, )};
const saltus_option_table saltus_orbit_table = SALTUS_TABLE(choices);

saltus_orbit_options saltus_orbit_defaults(void) {
    saltus_orbit_options options = {0};
    saltus_options_fill(&saltus_orbit_table, &options);
    return options;
}
