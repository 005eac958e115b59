/* Private: the formats of a record.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_IO_RECORD_H
#define SALTUS_IO_RECORD_H

#include "saltus/io.h"

/* A record with what explains it. */
typedef struct saltus_source {
    const saltus_record *record;
    const saltus_scene *scene;
    const saltus_system *system;
    const saltus_flow_options *options;
} saltus_source;

/* Comment lines and one row per sample; failures are left in the file's error flag. */
void saltus_record_csv(const saltus_source *source, FILE *file);
/* An HDF5 file, made in memory and then written. Errors: SALTUS_IO (HDF5 failed), SALTUS_NO_MEMORY. */
saltus_status saltus_record_hdf5(const saltus_source *source, FILE *file, saltus_message *message);

#endif
