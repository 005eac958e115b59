/* Poincare maps of a system: stroboscopic, impact and turning, behind one interface.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MAP_H
#define SALTUS_MAP_H

#include "saltus/flow.h"

SALTUS_API_BEGIN

typedef enum saltus_section_kind {
    SALTUS_SECTION_STROBOSCOPIC, /* tau = (phase + k) T */
    SALTUS_SECTION_IMPACT,       /* just after an impact, or where a contact begins to hold */
    SALTUS_SECTION_TURNING /* the observed displacement's velocity changes sign, smoothly or by an impact */
} saltus_section_kind;

typedef struct saltus_section {
    saltus_section_kind kind;
    double phase;    /* stroboscopic: 0 <= phase < 1 */
    int iterate;     /* section points per step of the map, >= 1 */
    double patience; /* impact, turning: give up after this many periods without a section point; > 0 and <=
                        1e15 */
} saltus_section;

/* Stroboscopic at phase 0, first iterate, patience 1000 periods. */
saltus_section saltus_section_defaults(void);

typedef struct saltus_map saltus_map;

/* Create a map of a system, which must outlive it. With `derivative`, steps carry a full set of tangent
 * vectors; the options `columns` and `directions` are ignored. Coordinates: the state vector, and for impact
 * and turning maps also the time in [0, T) as last coordinate, which adds one to the dimension. Errors:
 * SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_map_new(const saltus_system *system, const saltus_section *section,
                             const saltus_flow_options *options, bool derivative, saltus_map **map,
                             saltus_message *message);
/* NULL is accepted. */
void saltus_map_free(saltus_map *map);
int saltus_map_dimension(const saltus_map *map);
/* The flow behind the map, for its information and contacts. */
const saltus_flow *saltus_map_flow(const saltus_map *map);

/* Start the map from a point (coordinates as above). A stroboscopic map starts at the section's phase.
 * Errors: SALTUS_BAD_INPUT (not finite, beyond a stop). */
saltus_status saltus_map_reset(saltus_map *map, const double *point, saltus_message *message);
/* One step of the map. `point` (may be NULL) receives the new point, `event` (may be NULL) the event at the
 * section. Errors: those of the flow; SALTUS_NO_CONVERGENCE if no section point comes within the patience. On
 * error `point` is unchanged. */
saltus_status saltus_map_step(saltus_map *map, double *point, saltus_event *event, saltus_message *message);
/* Derivative of the last step, d new_i / d old_j, row-major; only for a map created with `derivative`. */
void saltus_map_derivative(const saltus_map *map, double *derivative);

SALTUS_API_END
#endif
