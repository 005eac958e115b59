/* Results as JSON, CSV, HDF5 and figures.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_IO_H
#define SALTUS_IO_H

#include "saltus/motion.h"
#include "saltus/scene.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A motion as one JSON object and a newline; keys as in the README. Numbers round-trip. */
void saltus_write_motion_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                              const saltus_motion *motion);
/* The same for people: a few lines. */
void saltus_write_motion_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                              const saltus_motion *motion);

/* The attractors found from random initial states: shares and verdicts, as text or as one JSON object with
 * the keys `seeds` and `attractors` (a list of objects with `share` and `motion`). */
void saltus_write_attractors(FILE *file, const saltus_scene *scene, const saltus_system *system,
                             const saltus_attractors *attractors, bool json);

/* A sampled trajectory with its events and stroboscopic points. Arrays are owned by the record. */
typedef struct saltus_record {
    int dimension;
    long long samples;    /* rows of `time` and `states` */
    double *time;         /* in forcing periods from the start of the recording; never decreasing */
    double *states;       /* samples x dimension */
    double *displacement; /* observed displacement and velocity, per sample */
    double *velocity;
    saltus_event *events;  /* impacts, sticks and releases; times as above */
    long long *event_rows; /* the row just before each event; after an impact or a stick the next row is just
                              after */
    long long event_count;
    long long strobes;     /* stroboscopic points at phase 0, one per recorded period, at its begin */
    double *strobe_states; /* strobes x dimension */
} saltus_record;

/* Run `transient` periods from a state, then record `periods` periods with `per_period` samples each, the end
 * included, and one at each side of an impact. On error the record is empty. Errors: those of the flow,
 * SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_record_run(const saltus_system *system, const double *state,
                                const saltus_flow_options *options, long long transient, long long periods,
                                int per_period, saltus_record *record, saltus_message *message);
void saltus_record_clear(saltus_record *record);
/* Write a record to a .csv or .h5 file (chosen by the ending), complete or not at all. Errors:
 * SALTUS_BAD_INPUT for another ending, SALTUS_IO. */
saltus_status saltus_record_write(const saltus_record *record, const saltus_scene *scene,
                                  const saltus_system *system, const saltus_flow_options *options,
                                  const char *path, saltus_message *message);

/* The one-page diagnosis of a motion: phase portrait, time history, impact map, shapes, caption. `path` ends
 * in .png, .pdf or .svg. With `data` (a .h5 path, may be NULL) the record goes there and gnuplot's script
 * beside it, with the ending .gp. Errors: SALTUS_BAD_INPUT, SALTUS_IO (gnuplot absent or failed, file not
 * writable). */
saltus_status saltus_write_sheet(const saltus_scene *scene, const saltus_system *system,
                                 const saltus_motion *motion, const saltus_record *record,
                                 const saltus_flow_options *options, const char *path, const char *data,
                                 saltus_message *message);

#ifdef __cplusplus
}
#endif
#endif
