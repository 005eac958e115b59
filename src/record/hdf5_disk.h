/* Private: HDF5 files made on disk, for those that do not fit into memory.
 *
 * HDF5's own driver for files does not survive a full disk: what it could not write it tries to write again
 * when the file is closed, fails, and leaves the library in a state that ends in a crash. Here a failing
 * write is noted, nothing more is written, and HDF5 is not told, so that it can be closed in order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_HDF5_DISK_H
#define SALTUS_RECORD_HDF5_DISK_H

#include "record/hdf5.h"

typedef struct saltus_h5_disk {
    int descriptor; /* -1: not open */
    int reason;     /* errno of the first failure, otherwise 0 */
    hid_t driver;   /* kept while the file is open; negative: none */
} saltus_h5_disk;

/* A new file in place of the contents of the one at `path`, which must exist. */
void saltus_h5_disk_create(saltus_h5 *w, saltus_h5_disk *disk, const char *path);
/* Complete the file, add the seal and close it; with `durable` wait until it is on the disk. w->sound and
 * disk->reason tell whether it is as it should be. */
void saltus_h5_disk_finish(saltus_h5 *w, saltus_h5_disk *disk, bool durable);

#endif
