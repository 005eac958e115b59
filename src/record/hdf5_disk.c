/* HDF5 files on disk, written through a file driver that notes failed writes instead of reporting them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/hdf5.h"
#include "record/output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

/* An open file, as HDF5 hands it to the driver. */
typedef struct disk_file {
    H5FD_t base; /* must be the first member */
    saltus_h5 *w;
    haddr_t end_allocated, end;
} disk_file;

static H5FD_t *disk_open(const char *name, unsigned flags, hid_t access, haddr_t most) {
    saltus_h5 *const *w = H5Pget_driver_info(access);
    disk_file *file = w ? calloc(1, sizeof *file) : NULL;
    if (w && !file)
        (*w)->reason = ENOMEM;
    (void)name;
    (void)flags;
    (void)most;
    if (!file)
        return NULL;
    file->w = *w;
    return &file->base;
}

static herr_t disk_close(H5FD_t *base) {
    free(base);
    return 0;
}

static herr_t disk_query(const H5FD_t *base, unsigned long *features) {
    (void)base;
    *features = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

static haddr_t disk_end_allocated(const H5FD_t *base, H5FD_mem_t type) {
    (void)type;
    return ((const disk_file *)(const void *)base)->end_allocated;
}

static herr_t disk_allocate(H5FD_t *base, H5FD_mem_t type, haddr_t end) {
    (void)type;
    ((disk_file *)(void *)base)->end_allocated = end;
    return 0;
}

static haddr_t disk_end(const H5FD_t *base, H5FD_mem_t type) {
    (void)type;
    return ((const disk_file *)(const void *)base)->end;
}

/* Bytes beyond the end, or that could not be written, read as zeros. */
static herr_t disk_read(H5FD_t *base, H5FD_mem_t type, hid_t transfer, haddr_t address, size_t size,
                        void *data) {
    const disk_file *file = (const disk_file *)(void *)base;
    (void)type;
    (void)transfer;
    size_t there = saltus_read_at(file->w->descriptor, data, size, (long long)address);
    memset((unsigned char *)data + there, 0, size - there);
    return 0;
}

static herr_t disk_write(H5FD_t *base, H5FD_mem_t type, hid_t transfer, haddr_t address, size_t size,
                         const void *data) {
    disk_file *file = (disk_file *)(void *)base;
    (void)type;
    (void)transfer;
    if (address + size > file->end)
        file->end = address + size;
    if (!file->w->reason && !saltus_write_at(file->w->descriptor, data, size, (long long)address))
        file->w->reason = errno;
    return 0;
}

static herr_t disk_truncate(H5FD_t *base, hid_t transfer, hbool_t closing) {
    disk_file *file = (disk_file *)(void *)base;
    (void)transfer;
    (void)closing;
    if (!file->w->reason && file->end != file->end_allocated &&
        ftruncate(file->w->descriptor, (off_t)file->end_allocated) != 0)
        file->w->reason = errno;
    file->end = file->end_allocated;
    return 0;
}

static const H5FD_class_t disk_class = {
#if H5_VERSION_GE(1, 13, 2)
    .version = H5FD_CLASS_VERSION,
    .value = 511,
#endif
    .name = "saltus",
    .maxaddr = ((haddr_t)1 << 62) - 1,
    .fc_degree = H5F_CLOSE_STRONG,
    .fapl_size = sizeof(saltus_h5 *),
    .open = disk_open,
    .close = disk_close,
    .query = disk_query,
    .get_eoa = disk_end_allocated,
    .set_eoa = disk_allocate,
    .get_eof = disk_end,
    .read = disk_read,
    .write = disk_write,
    .truncate = disk_truncate,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
};

/* The file is of the oldest format that can hold it, for any version of HDF5. The driver must be kept alive
 * until the file is closed: HDF5 1.10 frees a driver that only the file holds before it calls its close
 * function. */
void saltus_h5_create(saltus_h5 *w, const char *path) {
    *w = (saltus_h5){.file = -1, .sound = true, .driver = -1};
    w->descriptor = open(path, O_RDWR | O_TRUNC | O_CLOEXEC);
    if (w->descriptor < 0)
        w->reason = errno;
    const hid_t access = w->reason ? -1 : H5Pcreate(H5P_FILE_ACCESS);
    w->driver = w->reason ? -1 : H5FDregister(&disk_class);
    if (access >= 0 && w->driver >= 0 && H5Pset_driver(access, w->driver, &w) >= 0 &&
        H5Pset_fclose_degree(access, H5F_CLOSE_STRONG) >= 0 &&
        H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18) >= 0)
        w->file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access);
    saltus_h5_close(access);
    saltus_h5_note(w, w->file >= 0);
}

void saltus_h5_finish(saltus_h5 *w, bool durable) {
    char seal[SALTUS_H5_SEAL + 1];
    if (w->file >= 0)
        saltus_h5_note(w, H5Fclose(w->file) >= 0);
    w->file = -1;
    if (w->driver >= 0)
        H5FDunregister(w->driver);
    w->driver = -1;
    const off_t length = w->sound && !w->reason ? lseek(w->descriptor, 0, SEEK_END) : 0;
    if (w->sound && !w->reason &&
        (length < 0 || !saltus_h5_seal(w->descriptor, length, seal) ||
         !saltus_write_at(w->descriptor, seal, SALTUS_H5_SEAL, length)))
        w->reason = errno;
    if (w->sound && !w->reason && durable && fsync(w->descriptor) != 0)
        w->reason = errno;
    if (w->descriptor >= 0 && close(w->descriptor) != 0 && !w->reason)
        w->reason = errno;
    w->descriptor = -1;
    saltus_h5_note(w, w->reason == 0);
}

saltus_status saltus_h5_write(const char *path, bool durable, saltus_h5_put *put, void *context,
                              saltus_message *message) {
    saltus_output output;
    saltus_h5_silence silence;
    saltus_h5 w;
    if (!saltus_h5_quiet(&silence))
        return saltus_fail(message, SALTUS_IO, "the HDF5 library could not be opened");
    saltus_status status = saltus_output_open(&output, path, message);
    if (status == SALTUS_OK && !output.temporary) {
        status = saltus_fail(message, SALTUS_IO, "%s: is not a plain file", path);
        status = saltus_output_close(&output, status, message);
    } else if (status == SALTUS_OK) {
        saltus_h5_create(&w, output.temporary);
        status = put(&w, context, message);
        saltus_h5_finish(&w, durable);
        if (status == SALTUS_OK && (w.starved || w.reason == ENOMEM))
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for writing %s", path);
        else if (status == SALTUS_OK && w.reason)
            status = saltus_fail(message, SALTUS_IO, "%s could not be written completely: %s", path,
                                 strerror(w.reason));
        else if (status == SALTUS_OK && !w.sound)
            status = saltus_fail(message, SALTUS_IO, "the HDF5 library could not make %s", path);
        status = saltus_output_close(&output, status, message);
    }
    saltus_h5_restore(&silence);
    return status;
}
