/* Private: reading the file of a trajectory, and its samples as a table.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_TRAJECTORY_H
#define SALTUS_RECORD_TRAJECTORY_H

#include "record/hdf5.h"

typedef struct saltus_trajectory_file {
    saltus_h5_head head;
    saltus_system *system;       /* of the file's parameters */
    saltus_flow_options options; /* of the flow that recorded it */
    saltus_trajectory record;
} saltus_trajectory_file;

/* Read a file of any origin; to be cleared, also after a failure. Errors: SALTUS_BAD_INPUT,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_trajectory_file_read(const char *path, saltus_trajectory_file *file,
                                          saltus_message *message);
/* A zeroed one is accepted. */
void saltus_trajectory_file_clear(saltus_trajectory_file *file);
/* Write the samples of a file as the table that saltus_write_trajectory writes of a record. Errors: those of
 * reading, SALTUS_IO. */
saltus_status saltus_write_samples(const char *to, const char *path, saltus_message *message);

#endif
