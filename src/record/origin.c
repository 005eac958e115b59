/* The origin of results, in HDF5 files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/rows.h"

#include <stdlib.h>
#include <string.h>

/* Longer texts cannot come from Saltus. */
static const size_t most = 1 << 22;

bool saltus_h5_origin_keep(saltus_origin *kept, const saltus_origin *origin) {
    const saltus_origin told = origin ? *origin : (saltus_origin){NULL, NULL, NULL};
    *kept = (saltus_origin){told.command ? strdup(told.command) : NULL, told.date ? strdup(told.date) : NULL,
                            told.scene ? strdup(told.scene) : NULL};
    return !told.command == !kept->command && !told.date == !kept->date && !told.scene == !kept->scene;
}

void saltus_h5_origin_clear(saltus_origin *kept) {
    free((char *)kept->command);
    free((char *)kept->date);
    free((char *)kept->scene);
    *kept = (saltus_origin){NULL, NULL, NULL};
}

/* Texts are datasets with a checksum, because attributes hold at most 64 KiB. */
static void put_text(saltus_h5 *w, const char *name, const char *meaning, const char *text) {
    const saltus_h5_shape shape = {.rank = 1, .size = {1}, .part = {1}};
    if (!text || !w->sound)
        return;
    hid_t type = saltus_h5_text_type(strlen(text) + 1, true), space = H5Screate_simple(1, shape.size, NULL);
    hid_t list = saltus_h5_storage(w, &shape, type, NULL), set = -1;
    if (w->sound && type >= 0 && space >= 0)
        set = H5Dcreate2(w->file, name, type, space, H5P_DEFAULT, list, H5P_DEFAULT);
    if (saltus_h5_note(w, set >= 0 && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) >= 0)) {
        saltus_h5_text(w, set, "units", "1");
        saltus_h5_text(w, set, "description", meaning);
    }
    saltus_h5_close(set);
    saltus_h5_close(list);
    saltus_h5_close(space);
    saltus_h5_close(type);
}

void saltus_h5_put_origin(saltus_h5 *w, const saltus_origin *origin) {
    put_text(w, "command", "command line, but for what the results do not depend on", origin->command);
    put_text(w, "date", "when the run began", origin->date);
    put_text(w, "scene_text", "the scene before the command line changed it", origin->scene);
}

/* The text of a dataset, to be freed; NULL if it is absent. */
static char *get_text(hid_t file, const char *name, bool *memory) {
    hid_t set = H5Lexists(file, name, H5P_DEFAULT) > 0 ? H5Dopen2(file, name, H5P_DEFAULT) : -1;
    hid_t type = set >= 0 ? H5Dget_type(set) : -1, space = set >= 0 ? H5Dget_space(set) : -1, wanted = -1;
    size_t size = type >= 0 && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0
                      ? H5Tget_size(type)
                      : 0;
    char *text = NULL;
    if (size > 0 && size <= most && space >= 0 && H5Sget_simple_extent_npoints(space) == 1) {
        text = calloc(size + 1, 1);
        *memory = *memory && text;
        wanted = saltus_h5_text_type(size + 1, false);
    }
    if (text && (wanted < 0 || H5Dread(set, wanted, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) < 0)) {
        free(text);
        text = NULL;
    }
    saltus_h5_close(wanted);
    saltus_h5_close(space);
    saltus_h5_close(type);
    saltus_h5_close(set);
    return text;
}

saltus_status saltus_h5_origin_take_over(saltus_origin *kept, const char *path, saltus_message *message) {
    saltus_message reason = {.text = ""};
    saltus_h5_reader reader = {.path = path, .message = &reason};
    bool memory = true;
    if (saltus_h5_reader_open(&reader) != SALTUS_OK)
        return SALTUS_OK;
    saltus_h5_origin_clear(kept);
    kept->command = get_text(reader.file, "command", &memory);
    kept->date = get_text(reader.file, "date", &memory);
    kept->scene = get_text(reader.file, "scene_text", &memory);
    saltus_h5_reader_close(&reader);
    return memory ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for reading %s", path);
}
