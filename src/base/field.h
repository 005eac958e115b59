/* Members of structs, declared once: what each is called, what it means, and where it is. Files, the command
 * line, its help and the checks of options are made from these tables; a table stands beside the functions
 * that own the struct.
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
    SALTUS_CHOICE,  /* an enumeration, or an int that takes its values: one of `words` */
    SALTUS_SET,     /* unsigned: bits, each with one of `words` */
    SALTUS_TEXT     /* characters in the struct, with a NUL */
} saltus_field_type;

/* A word for a value of a choice or for a bit of a set; a list of them ends with NULL. */
typedef struct saltus_word {
    const char *word;
    int value;
} saltus_word;

/* One member. A member with several entries is a list, or a matrix whose rows are `width` entries each. */
typedef struct saltus_field {
    const char *name;   /* in files; on the command line with '-' in place of '_' */
    const char *symbol; /* in formulas and at axes; NULL: the name */
    const char *unit;   /* "1", "T" (forcing periods), "1/T" */
    const char *meaning;
    size_t offset; /* into the struct */
    saltus_field_type type;
    /* Entries: 0: a single value. Negative, -k: as many as the k-th of the counts that belong to a table at
     * run time. Of a text: its bytes, the NUL among them. */
    int length;
    int width;                /* entries of a row of a matrix; 0: no matrix */
    const saltus_word *words; /* of a choice or a set */
    bool indirect;            /* at `offset` is a pointer to the entries */
    size_t inner;             /* indirect: bytes from there to the first entry */
    size_t stride;            /* bytes from one entry or row to the next one; 0: they follow each other */
} saltus_field;

/* The field of a member: what follows the meaning is the type, then what else is to be said. */
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

/* The table of an array of fields, or of options. */
#define SALTUS_TABLE(array)                                                                                  \
    { array, sizeof(array) / sizeof(array)[0] }

/* A member of an options struct. */
typedef struct saltus_option {
    saltus_field field;
    double fallback;      /* default; the value of a choice, the bits of a set */
    double low, high;     /* of real and whole numbers: admissible range, ... */
    bool above, below;    /* ... whose ends do not belong to it */
    bool automatic;       /* 0 is admissible too: the program chooses */
    const char *flag;     /* on the command line: "--step-max"; NULL: cannot be chosen there */
    const char *argument; /* how its value is called in the help; NULL: a flag */
    bool apart;           /* the results do not depend on it, so it is not in their files */
} saltus_option;

typedef struct saltus_option_table {
    const saltus_option *options;
    int count;
} saltus_option_table;

enum { SALTUS_NUMBER_MAX = 32, SALTUS_FIELD_TEXT_MAX = 256 };

/* A number that reads back as the same one, with a '.' whatever the locale; `text` holds SALTUS_NUMBER_MAX
 * bytes. */
const char *saltus_number(double value, char *text);
/* The same, rounded to so many digits. */
const char *saltus_number_of(double value, int digits, char *text);
/* Text as a string of JSON, in quotation marks. */
void saltus_put_string(FILE *file, const char *text);

/* The word for a value; NULL when it has none. */
const char *saltus_word_of(const saltus_word *words, int value);
/* The value of a word of `length` characters; false when there is no such word. */
bool saltus_word_value(const saltus_word *words, const char *word, size_t length, int *value);

/* Bytes of one entry in memory; of a text, all of it. */
size_t saltus_field_bytes(const saltus_field *field);
/* Entries of a row of a table: length[0] and length[1] as in a field, with the counts put in; how many
 * entries that are together. `counts` may be NULL where no length is negative. */
size_t saltus_field_shape(const saltus_field *field, const int *counts, int length[2]);
/* Copy all entries from a struct to consecutive ones, and back. */
void saltus_field_pack(const saltus_field *field, const int *counts, const void *record, void *entries);
void saltus_field_unpack(const saltus_field *field, const int *counts, const void *entries, void *record);

/* A single value of any type but real and text, as a whole number: 0 or 1, the choice's value, the bits. */
long long saltus_field_whole(const saltus_field *field, const void *record);
/* The reverse; false, and nothing is written, when the member cannot take the value: one out of its type's
 * range, a choice or bits without a word. */
bool saltus_field_set_whole(const saltus_field *field, long long value, void *record);
/* A single value of any type but text, and the reverse. */
double saltus_field_number(const saltus_field *field, const void *record);
bool saltus_field_set_number(const saltus_field *field, double value, void *record);
/* A single value as text, which reads back as the same one: "1e-10", "yes" or "no", "taylor", the words of a
 * set with commas between them. */
const char *saltus_field_text(const saltus_field *field, const void *record,
                              char text[SALTUS_FIELD_TEXT_MAX]);
/* The reverse; false, and nothing is written, when the text is no value of that type. */
bool saltus_field_read(const saltus_field *field, const char *text, void *record);

/* The option of that name; NULL when there is none. */
const saltus_option *saltus_option_find(const saltus_option_table *table, const char *name);
/* Give all options their defaults. */
void saltus_options_fill(const saltus_option_table *table, void *record);
/* What a value must be: "must be from 1 to 256", "must be automatic, taylor or radau". */
const char *saltus_option_demand(const saltus_option *option, char text[SALTUS_FIELD_TEXT_MAX]);
/* Whether a value is as it must be. */
bool saltus_option_admits(const saltus_option *option, const void *record);
/* SALTUS_BAD_INPUT with a sentence about the first option that is not as it must be. */
saltus_status saltus_options_check(const saltus_option_table *table, const void *record,
                                   saltus_message *message);

#endif
