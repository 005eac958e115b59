/* Private: the columns of a sweep's tables, the same for HDF5 and CSV, writing and reading.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_SWEEP_COLUMNS_H
#define SALTUS_RECORD_SWEEP_COLUMNS_H

#include "record/hdf5.h"
#include "saltus/sweep.h"

/* What one entry of a column is. */
typedef enum saltus_sweep_entry {
    SALTUS_ENTRY_REAL,
    SALTUS_ENTRY_INT,
    SALTUS_ENTRY_LONG,
    SALTUS_ENTRY_VERDICT /* an int, by its word */
} saltus_sweep_entry;

typedef struct saltus_sweep_column {
    const char *name, *units, *description;
    saltus_sweep_entry entry;
    size_t offset; /* into the row, impact, ... */
} saltus_sweep_column;

enum { SALTUS_SWEEP_COLUMNS = 15 };
/* Of saltus_sweep_row. */
extern const saltus_sweep_column saltus_sweep_columns[SALTUS_SWEEP_COLUMNS];

/* What is kept beside the rows. */
enum { SALTUS_CLOUDS = 3, SALTUS_CLOUD_COLUMNS_MAX = 3 };
typedef struct saltus_sweep_cloud {
    const char *group, *description;
    unsigned keep;
    int count; /* of columns; one whose entries are states has the width of the state */
    saltus_sweep_column columns[SALTUS_CLOUD_COLUMNS_MAX];
    size_t stride; /* from one entry to the next in memory; 0: that of a state */
} saltus_sweep_cloud;
extern const saltus_sweep_cloud saltus_sweep_clouds[SALTUS_CLOUDS];

/* Columns that are made when the file is written. */
extern const saltus_sweep_column saltus_sweep_distinct, saltus_sweep_first, saltus_sweep_count;
/* Columns of /attractors that are made in the same way. */
enum { SALTUS_ATTRACTOR_COLUMNS = 6 };
extern const saltus_sweep_column saltus_attractor_columns[SALTUS_ATTRACTOR_COLUMNS];

size_t saltus_entry_bytes(saltus_sweep_entry entry);
/* Type of an entry in memory and, when `stored`, in the file; to be closed. */
hid_t saltus_entry_type(saltus_h5 *w, saltus_sweep_entry entry, bool stored);

/* The words for what is kept, for passes and for spacings, each list in the order of its bits or values and
 * ended by NULL. */
extern const char *const saltus_keep_words[], *const saltus_pass_words[], *const saltus_spacing_words[];
/* The words of the bits that are set, "turning,impacts"; `text` holds SALTUS_WORDS_MAX bytes. */
enum { SALTUS_WORDS_MAX = 64 };
const char *saltus_words_join(const char *const *words, unsigned bits, char *text);
/* The reverse; false when there is another word. */
bool saltus_words_split(const char *text, const char *const *words, unsigned *bits);

#endif
