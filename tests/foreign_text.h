/* Texts that another program might have put into an HDF5 file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_FOREIGN_TEXT_H
#define SALTUS_TESTS_FOREIGN_TEXT_H

#include "check.h"

#include <hdf5.h>

/* How a text is stored: in as many bytes as it has, in more of them, with a NUL or without, in a heap. */
typedef enum foreign_form {
    FOREIGN_TIGHT,
    FOREIGN_WIDE,
    FOREIGN_PADDED,
    FOREIGN_HEAP,
    FOREIGN_FORMS
} foreign_form;

/* Replace an attribute by a text; NULL: by nothing. */
static inline void foreign_text(const char *path, const char *group, const char *name, const char *text,
                                foreign_form form) {
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), owner = H5Gopen2(file, group, H5P_DEFAULT);
    assert_true(H5Adelete(owner, name) >= 0);
    if (text) {
        char wide[600];
        size_t length = strlen(text), size = form == FOREIGN_TIGHT  ? length
                                             : form == FOREIGN_WIDE ? 600
                                                                    : length + 9;
        hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
        assert_true(length < sizeof wide && H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
        memset(wide, 0, sizeof wide);
        memcpy(wide, text, length);
        assert_true(H5Tset_size(type, form == FOREIGN_HEAP ? H5T_VARIABLE : size) >= 0);
        if (form == FOREIGN_TIGHT || form == FOREIGN_PADDED)
            assert_true(H5Tset_strpad(type, H5T_STR_NULLPAD) >= 0);
        hid_t attribute = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
        assert_true(H5Awrite(attribute, type, form == FOREIGN_HEAP ? (const void *)&text : wide) >= 0);
        H5Aclose(attribute);
        H5Sclose(space);
        H5Tclose(type);
    }
    H5Gclose(owner);
    H5Fclose(file);
}

/* Replace a column of texts by one of equal texts of another length. */
static inline void foreign_column(const char *path, const char *name, const char *text) {
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), set = H5Dopen2(file, name, H5P_DEFAULT);
    hid_t there = H5Dget_space(set), type = H5Tcopy(H5T_C_S1);
    const hsize_t rows = (hsize_t)H5Sget_simple_extent_npoints(there);
    hid_t space = H5Screate_simple(1, &rows, NULL);
    size_t size = strlen(text) + 1;
    char *texts = calloc((size_t)rows, size);
    assert_non_null(texts);
    for (size_t k = 0; k < rows; k++)
        memcpy(texts + k * size, text, size);
    assert_true(H5Tset_size(type, size) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
    H5Dclose(set);
    assert_true(H5Ldelete(file, name, H5P_DEFAULT) >= 0);
    set = H5Dcreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts) >= 0);
    H5Dclose(set);
    H5Sclose(space);
    H5Sclose(there);
    H5Tclose(type);
    H5Fclose(file);
    free(texts);
}

/* Open the file with each of its texts at the top as long as there is room for, and a byte longer; in all the
 * ways of storing it; and without it. `read` tells the status, and the text as it was read into `again`. */
static inline void foreign_check(const char *path, const void *bytes, size_t length, const char *name,
                                 size_t most,
                                 saltus_status (*read)(const char *path, const char *name, char again[600],
                                                       saltus_message *message)) {
    for (int more = 0; more < 3; more++)
        for (int form = 0; form < FOREIGN_FORMS; form++) {
            char text[600], again[600] = "", limit[80];
            saltus_message message = {.text = ""};
            FILE *file = fopen(path, "wb");
            assert_true(file && fwrite(bytes, 1, length, file) == length);
            fclose(file);
            for (size_t k = 0; k < most + 1; k++)
                text[k] = (char)('a' + k % 26);
            text[most + (more == 1)] = '\0';
            foreign_text(path, "/", name, more == 2 ? NULL : text, (foreign_form)form);
            saltus_status status = read(path, name, again, &message);
            if (more == 0 && form != FOREIGN_HEAP) {
                check_ok(status, &message);
                assert_string_equal(again, text);
                continue;
            }
            assert_int_equal(status, SALTUS_BAD_INPUT);
            snprintf(limit, sizeof limit,
                     "its attribute %s must be a text of fixed length with at most %d bytes", name,
                     (int)most);
            if (!strstr(message.text, limit) || strncmp(message.text, path, strlen(path)) != 0)
                fail_msg("\"%s\" does not say \"%s\"", message.text, limit);
        }
}

#endif
