/* Tables of struct members, each declared once with its name, meaning and place. Files, the command line, its
 * help and the checks of options are made from these tables. A table stands beside the functions that own the
 * struct.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_FIELD_H
#define SALTUS_BASE_FIELD_H

#include "saltus/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef enum saltus_field_type {
    SALTUS_REAL,    /* double */
    SALTUS_INT,     /* int */
    SALTUS_LONG,    /* long long */
    SALTUS_NATURAL, /* unsigned long */
    SALTUS_FLAG,    /* bool */
    SALTUS_CHOICE,  /* an enumeration, or an int with its values: one of `words` */
    SALTUS_SET,     /* unsigned: bits, each with one of `words` */
    SALTUS_TEXT     /* characters in the struct, NUL-terminated */
} saltus_field_type;

/* A word for a value of a choice or for a bit of a set. Lists end with a NULL word. */
typedef struct saltus_word {
    const char *word;
    int value;
} saltus_word;

/* One member. A member with several entries is a list, or a matrix whose rows are `width` entries each. */
typedef struct saltus_field {
    const char *name;   /* in files; on the command line with '-' in place of '_' */
    const char *symbol; /* in formulas and on axes; NULL: the name */
    const char *unit;   /* "1", "T" (forcing periods), "1/T" */
    const char *meaning;
    size_t offset; /* into the struct */
    saltus_field_type type;
    /* Number of entries. 0: a single value. -k: the k-th of the counts that the caller passes at run time.
     * For a text: its bytes, including the NUL. */
    int length;
    int width;                /* entries per row of a matrix; 0: not a matrix */
    const saltus_word *words; /* for a choice or a set */
    bool indirect;            /* at `offset` is a pointer to the entries */
    size_t inner;             /* indirect: bytes from the pointer's target to the first entry */
    size_t stride;            /* bytes from one entry or row to the next; 0: contiguous */
} saltus_field;

/* The field of a member. After the meaning come the type and any further designated initialisers. */
#define SALTUS_MEMBER(struct_type, member, called, measured_in, means, ...)                                  \
    {                                                                                                        \
        .name = called, .unit = measured_in, .meaning = means, .offset = offsetof(struct_type, member),      \
        .type = __VA_ARGS__                                                                                  \
    }

/* The members of one kind of struct, in the order in which they are written. */
typedef struct saltus_field_table {
    const saltus_field *fields;
    int count;
} saltus_field_table;

/* A table (pointer and count) made of an array of fields or options. */
#define SALTUS_TABLE(array)                                                                                  \
    { array, sizeof(array) / sizeof(array)[0] }

/* A member of an options struct. */
typedef struct saltus_option {
    saltus_field field;
    double fallback;      /* default: a number, the value of a choice, or the bits of a set */
    double low, high;     /* admissible range of real and whole numbers, ... */
    bool above, below;    /* ... without its lower or upper end */
    bool automatic;       /* 0 is admissible too: the program chooses */
    const char *flag;     /* on the command line, such as "--step-max"; NULL: not available there */
    const char *argument; /* name of its value in the help; NULL: a flag without value */
    bool apart;           /* results do not depend on it, so result files do not record it */
} saltus_option;

typedef struct saltus_option_table {
    const saltus_option *options;
    int count;
} saltus_option_table;

enum { SALTUS_NUMBER_MAX = 32, SALTUS_FIELD_TEXT_MAX = 256 };

/* Write a number that reads back exactly, with '.' in any locale. `text` has SALTUS_NUMBER_MAX bytes. */
const char *saltus_number(double value, char *text);
/* The same, rounded to `digits` significant digits. */
const char *saltus_number_of(double value, int digits, char *text);
/* Complete a text begun by open_memstream (`file` NULL: that failed). Returns it, to be freed; NULL if memory
 * was lacking. */
char *saltus_close_text(FILE *file, char **text);
/* Write text as a JSON string, with quotation marks. */
void saltus_put_string(FILE *file, const char *text);

/* The word for a value, or NULL. */
const char *saltus_word_of(const saltus_word *words, int value);
/* The value of a word of `length` characters; false when there is no such word. */
bool saltus_word_value(const saltus_word *words, const char *word, size_t length, int *value);

/* Bytes of one entry in memory; for a text, of the whole text. */
size_t saltus_field_bytes(const saltus_field *field);
/* Shape of a field: length[0] and length[1] are its `length` and `width`, with negative lengths replaced by
 * the counts. Returns the total number of entries. `counts` may be NULL if no length is negative. */
size_t saltus_field_shape(const saltus_field *field, const int *counts, int length[2]);
/* Copy all entries from a struct into a contiguous array, and back. */
void saltus_field_pack(const saltus_field *field, const int *counts, const void *record, void *entries);
void saltus_field_unpack(const saltus_field *field, const int *counts, const void *entries, void *record);

/* A single value of any type but real and text, as a whole number: 0 or 1 for a flag, a choice's value, a
 * set's bits. */
long long saltus_field_whole(const saltus_field *field, const void *record);
/* The reverse. Returns false and writes nothing if the value is out of the type's range or has no word. */
bool saltus_field_set_whole(const saltus_field *field, long long value, void *record);
/* A single value of any type but text, as a number, and the reverse. */
double saltus_field_number(const saltus_field *field, const void *record);
bool saltus_field_set_number(const saltus_field *field, double value, void *record);
/* A single value as text that reads back exactly: "1e-10", "yes" or "no", "taylor", a set's words joined by
 * commas. */
const char *saltus_field_text(const saltus_field *field, const void *record,
                              char text[SALTUS_FIELD_TEXT_MAX]);
/* The reverse. Returns false and writes nothing if the text is not a value of the field's type. */
bool saltus_field_read(const saltus_field *field, const char *text, void *record);

/* The option with that name, or NULL. */
const saltus_option *saltus_option_find(const saltus_option_table *table, const char *name);
/* Set all options to their defaults. */
void saltus_options_fill(const saltus_option_table *table, void *record);
/* A phrase for the admissible values: "must be from 1 to 256", "must be automatic, taylor or radau". */
const char *saltus_option_demand(const saltus_option *option, char text[SALTUS_FIELD_TEXT_MAX]);
/* Whether the option's value in `record` is admissible. */
bool saltus_option_admits(const saltus_option *option, const void *record);
/* Returns SALTUS_BAD_INPUT, with a message, at the first option whose value is not admissible. */
saltus_status saltus_options_check(const saltus_option_table *table, const void *record,
                                   saltus_message *message);

#endif
