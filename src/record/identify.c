/* Identifies a file by its first bytes, a table by its comments, and an HDF5 file by two attributes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/hdf5.h"
#include "saltus/record.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

bool saltus_h5_is_locus(hid_t file) {
    char second[SALTUS_KEY_MAX] = "";
    hid_t group = saltus_h5_find_group(file, "continuation");
    const bool there = group >= 0 && saltus_h5_get_text(group, "key2", second, sizeof second) && second[0];
    saltus_h5_close(group);
    return there;
}

saltus_file_facts saltus_file_identify(const char *path) {
    static const struct {
        const char *begin, *kind;
    } known[] = {{"\x89HDF\r\n\x1a\n", "hdf5"},
                 {"\x89PNG\r\n", "picture"},
                 {"%PDF-", "picture"},
                 {"<?xml", "picture"},
                 {"<svg", "picture"}};
    saltus_file_facts facts = {.kind = "", .complete = true};
    char head[48] = "";
    struct stat there;
    /* Do not consume a pipe, which can be read only once. */
    FILE *file = stat(path, &there) == 0 && S_ISREG(there.st_mode) ? fopen(path, "rb") : NULL;
    if (!file)
        return facts;
    size_t length = fread(head, 1, sizeof head - 1, file);
    if (length == 0)
        strcpy(facts.kind, "empty");
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
        if (length >= strlen(known[k].begin) && memcmp(head, known[k].begin, strlen(known[k].begin)) == 0)
            strcpy(facts.kind, known[k].kind);
    /* Texts of Saltus name their kind after the version: "# Saltus 0.1.0 sweep" is a sweep's table, "# Saltus
     * 0.1.0: a figure" a gnuplot script. */
    char version[16] = "", kind[26] = "";
    if (sscanf(head, "# Saltus %15s %25[A-Za-z ]", version, kind) == 2) {
        snprintf(facts.kind, sizeof facts.kind, strchr(version, ':') ? "script" : "%s table", kind);
        /* The comments at its head say whether it was interrupted. */
        char *line = NULL;
        size_t room = 0;
        rewind(file);
        while (facts.complete && getline(&line, &room, file) > 0 && line[0] == '#')
            facts.complete = strcmp(line, "# complete: 0\n") != 0;
        free(line);
    }
    fclose(file);
    facts.hdf5 = strcmp(facts.kind, "hdf5") == 0;
    if (!facts.hdf5)
        return facts;
    saltus_h5_reader reader = {.path = path};
    long long complete = 1;
    if (saltus_h5_reader_open(&reader) == SALTUS_OK) {
        if (!saltus_h5_get_text(reader.file, "kind", facts.kind, sizeof facts.kind))
            facts.kind[0] = '\0';
        /* Files without `complete` are written in one piece. */
        if (saltus_h5_get_integer(reader.file, "complete", &complete))
            facts.complete = complete != 0;
        facts.locus = strcmp(facts.kind, "branch") == 0 && saltus_h5_is_locus(reader.file);
    }
    saltus_h5_reader_close(&reader);
    return facts;
}
