/* The journal of a sweep: results in the order in which they come.
 *
 *     head     magic, a mark that tells byte order and format, the length and checksum of what follows; the
 *              text of everything that the results depend on (sweep_identity.c), padded to 8 bytes
 *     records  length, checksum, a result as packed by saltus_sweep_pack, padded to 8 bytes; to the end
 *
 * A record is written in one call as soon as its result is computed, so a killed run loses no result. When a
 * journal is resumed, everything from the first incomplete record on is cut off: after a kill or a full disk
 * at most the last record. If a result is stored twice, the first one counts. Memory holds only the offset of
 * each place's record, 8 bytes per place; results are read back one at a time.
 *
 * Two runs writing to one journal would destroy it, so the file is locked while it is open. Without resuming,
 * an existing journal is replaced, and so is the file made from it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/output.h"
#include "record/sweep_output.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct head {
    char magic[8];
    uint64_t mark, length, check;
} head;

typedef struct prefix {
    uint64_t length, check;
} prefix;

static const char magic[8] = "SALTUSJ\n";
static const uint64_t mark = 0x0102030405060704u; /* the last byte is the format's number */

static size_t padded(size_t length) {
    return (length + 7) / 8 * 8;
}

/* A checksum over 64-bit words that detects any change in a single word; it starts from `length`. */
static uint64_t checksum(const unsigned char *bytes, size_t length) {
    uint64_t hash = 0xcbf29ce484222325u ^ length;
    for (size_t k = 0; k < padded(length); k += sizeof hash) {
        uint64_t word;
        memcpy(&word, bytes + k, sizeof word);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    }
    return hash;
}

static saltus_status no_memory(const saltus_journal *j, saltus_message *message) {
    return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the results in %s", j->path);
}

static bool make_room(unsigned char **block, size_t *room, size_t needed) {
    if (needed <= *room)
        return true;
    size_t wanted = needed + needed / 2;
    unsigned char *grown = realloc(*block, wanted);
    if (!grown)
        return false;
    *block = grown;
    *room = wanted;
    return true;
}

/* Read the bytes [begin, begin + length), which must exist in the file. They last until the next call. */
static saltus_status look(saltus_journal *j, long long begin, size_t length, const unsigned char **bytes,
                          saltus_message *message) {
    if (!make_room(&j->read, &j->read_room, length))
        return no_memory(j, message);
    *bytes = j->read;
    return saltus_read_at(j->file, j->read, length, begin) == length
               ? SALTUS_OK
               : saltus_fail(message, SALTUS_IO, "%s: cannot be read back: %s", j->path, strerror(errno));
}

/* Whether a complete record begins at `begin`; *bytes then points to its contents. */
static saltus_status look_at_record(saltus_journal *j, long long begin, bool *whole, size_t *length,
                                    const unsigned char **bytes, saltus_message *message) {
    enum { usual = 1024 }; /* most records are no longer and take one reading */
    prefix p;
    const long long left = j->end - begin - (long long)sizeof p;
    *whole = false;
    if (left < 0)
        return SALTUS_OK;
    saltus_status status =
        look(j, begin, j->end - begin < usual ? (size_t)(j->end - begin) : usual, bytes, message);
    if (status != SALTUS_OK)
        return status;
    memcpy(&p, *bytes, sizeof p);
    if (p.length == 0 || p.length > (uint64_t)left || padded(p.length) > (uint64_t)left)
        return SALTUS_OK;
    if (sizeof p + padded(p.length) > usual)
        status = look(j, begin, sizeof p + padded(p.length), bytes, message);
    *bytes += sizeof p;
    *length = (size_t)p.length;
    *whole = status == SALTUS_OK && checksum(*bytes, *length) == p.check;
    return status;
}

/* Register the position of a result. */
static void enter(saltus_journal *j, const saltus_sweep_result *result, long long begin) {
    const long long *const counts[SALTUS_CLOUDS] = {result->turning_counts, result->impact_counts,
                                                    result->strobe_counts};
    if (j->offset[result->place])
        return;
    j->offset[result->place] = begin;
    j->found++;
    for (int c = 0; c < SALTUS_CLOUDS; c++)
        for (int s = 0; s < saltus_sweep_choices(j->sweep)->seeds; s++)
            j->total[c] += counts[c][s];
}

/* Check that the journal belongs to this sweep, and find its results. *there stays false if the file is
 * shorter than this sweep's head: its own head is then incomplete, or it belongs to another sweep and holds
 * no result. */
static saltus_status take_up(saltus_journal *j, const char *identity, bool *there, saltus_message *message) {
    const unsigned char *bytes = NULL;
    head h = {.length = 0};
    size_t part = j->end < (long long)sizeof h ? (size_t)j->end : sizeof h;
    saltus_status status = look(j, 0, part, &bytes, message);
    if (status != SALTUS_OK)
        return status;
    memcpy(&h, bytes, part);
    if (memcmp(h.magic, magic, part < sizeof magic ? part : sizeof magic) != 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: is not a journal of a sweep", j->path);
    long long left = j->end - (long long)sizeof h;
    if (left >= 0 && h.mark != mark)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%s: was written by another version, or on another kind of machine", j->path);
    if (j->end < (long long)(sizeof h + padded(strlen(identity))))
        return SALTUS_OK;
    if (h.length > (uint64_t)left || padded((size_t)h.length) > (uint64_t)left)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: is damaged at its begin", j->path);
    *there = true;
    size_t room = padded((size_t)h.length);
    status = look(j, sizeof h, room, &bytes, message);
    char *text = status == SALTUS_OK ? calloc(1, (size_t)h.length + 1) : NULL;
    if (status == SALTUS_OK && !text)
        status = no_memory(j, message);
    if (status == SALTUS_OK && checksum(bytes, (size_t)h.length) != h.check)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "%s: is damaged at its begin", j->path);
    if (status == SALTUS_OK) {
        memcpy(text, bytes, (size_t)h.length);
        status = saltus_sweep_identity_compare(j->path, text, identity, message);
    }
    free(text);
    /* Find the results, and cut off everything from the first incomplete record. */
    long long begin = (long long)(sizeof h + room);
    for (bool whole = true; whole && status == SALTUS_OK;) {
        saltus_sweep_result result;
        size_t length = 0;
        status = look_at_record(j, begin, &whole, &length, &bytes, message);
        if (status != SALTUS_OK || !whole)
            break;
        if (saltus_sweep_unpack(j->sweep, bytes, length, &result)) {
            enter(j, &result, begin);
            begin += (long long)(sizeof(prefix) + padded(length));
        } else
            status = saltus_fail(message, SALTUS_BAD_INPUT, "%s: holds a result that does not fit the sweep",
                                 j->path);
    }
    if (status == SALTUS_OK && begin < j->end && ftruncate(j->file, (off_t)begin) != 0)
        status = saltus_fail(message, SALTUS_IO, "%s: its damaged end cannot be cut off: %s", j->path,
                             strerror(errno));
    j->end = status == SALTUS_OK ? begin : j->end;
    return status;
}

saltus_status saltus_journal_open(saltus_journal *journal, const char *path, const saltus_sweep *sweep,
                                  const char *identity, bool resume, bool *there, saltus_message *message) {
    long long places = saltus_sweep_pass_count(sweep) * saltus_sweep_points(sweep);
    struct stat facts, named;
    *there = false;
    *journal = (saltus_journal){.sweep = sweep, .file = -1, .places = places};
    journal->path = strdup(path);
    journal->offset = calloc((size_t)places, sizeof *journal->offset);
    saltus_status status = SALTUS_OK;
    if (!journal->path || !journal->offset)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the results in %s", path);
    /* Before this run has locked the file, the run that held it may remove it: then the path no longer names
     * the same file. */
    bool locked = false;
    for (int k = 0; k < 100 && status == SALTUS_OK && !locked; k++) {
        if (journal->file >= 0)
            close(journal->file);
        journal->made = access(path, F_OK) != 0;
        journal->file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (journal->file < 0 || fstat(journal->file, &facts) != 0)
            status = saltus_fail(message, SALTUS_IO, "%s cannot be written: %s", path, strerror(errno));
        else if (!S_ISREG(facts.st_mode))
            status = saltus_fail(message, SALTUS_BAD_INPUT, "%s: is not a plain file", path);
        else if (flock(journal->file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
            status = saltus_fail(message, SALTUS_IO, "%s: is in use by another run", path);
        else
            locked = stat(path, &named) == 0 && named.st_ino == facts.st_ino && named.st_dev == facts.st_dev;
    }
    if (status == SALTUS_OK && !locked)
        status = saltus_fail(message, SALTUS_IO, "%s: is removed again and again", path);
    journal->end = status == SALTUS_OK ? facts.st_size : 0;
    if (status == SALTUS_OK && resume && journal->end)
        status = take_up(journal, identity, there, message);
    if (status != SALTUS_OK)
        saltus_journal_close(journal, false);
    return status;
}

saltus_status saltus_journal_begin(saltus_journal *journal, const char *identity, saltus_message *message) {
    size_t length = strlen(identity), whole = sizeof(head) + padded(length);
    unsigned char *bytes = calloc(1, whole);
    if (!bytes)
        return no_memory(journal, message);
    memcpy(bytes + sizeof(head), identity, length);
    head h = {.mark = mark, .length = length, .check = checksum(bytes + sizeof h, length)};
    memcpy(h.magic, magic, sizeof magic);
    memcpy(bytes, &h, sizeof h);
    bool sound = ftruncate(journal->file, 0) == 0 && saltus_write_at(journal->file, bytes, whole, 0);
    int reason = errno;
    free(bytes);
    journal->end = (long long)whole;
    return sound
               ? SALTUS_OK
               : saltus_fail(message, SALTUS_IO, "%s cannot be written: %s", journal->path, strerror(reason));
}

saltus_status saltus_journal_add(saltus_journal *journal, const saltus_sweep_result *result,
                                 saltus_message *message) {
    saltus_sweep_result packed;
    prefix p = {.length = saltus_sweep_packed_size(journal->sweep, result)};
    size_t whole = sizeof p + padded(p.length);
    if (!make_room(&journal->record, &journal->record_room, whole))
        return no_memory(journal, message);
    unsigned char *bytes = journal->record + sizeof p;
    memset(bytes + p.length, 0, padded(p.length) - p.length);
    saltus_sweep_pack(journal->sweep, result, bytes);
    if (!saltus_sweep_unpack(journal->sweep, bytes, p.length, &packed))
        return saltus_fail(message, SALTUS_BAD_INPUT, "place %lld: its result does not fit the sweep",
                           result->place);
    p.check = checksum(bytes, p.length);
    memcpy(journal->record, &p, sizeof p);
    if (saltus_write_at(journal->file, journal->record, whole, journal->end)) {
        enter(journal, result, journal->end);
        journal->end += (long long)whole;
        return SALTUS_OK;
    }
    int reason = errno;
    /* If this fails too, the next record overwrites the rest, or resuming cuts it off. */
    (void)!ftruncate(journal->file, (off_t)journal->end);
    return saltus_fail(
        message, SALTUS_IO,
        "%s: nothing more can be written: %s; the results up to here are kept, --resume goes on from them",
        journal->path, strerror(reason));
}

void saltus_journal_close(saltus_journal *journal, bool discard) {
    if (journal->path && journal->file >= 0) {
        if (discard)
            unlink(journal->path);
        close(journal->file);
    }
    free(journal->path);
    free(journal->offset);
    free(journal->read);
    free(journal->record);
    *journal = (saltus_journal){.file = -1};
}

saltus_status saltus_sweep_stream_read(saltus_sweep_stream *stream, long long place,
                                       saltus_message *message) {
    saltus_journal *j = stream->journal;
    const int seeds = saltus_sweep_choices(stream->sweep)->seeds;
    const bool there = j->offset[place] != 0;
    saltus_sweep_result *result = &stream->result;
    saltus_status status = SALTUS_OK;
    stream->distinct = 0;
    *result = (saltus_sweep_result){.rows = NULL};
    if (there) {
        const unsigned char *bytes = NULL;
        size_t length = 0;
        bool whole = false;
        status = look_at_record(j, j->offset[place], &whole, &length, &bytes, message);
        if (status == SALTUS_OK &&
            (!whole || !saltus_sweep_unpack(j->sweep, bytes, length, result) || result->place != place))
            status = saltus_fail(message, SALTUS_IO, "%s: was changed while it was in use", j->path);
    }
    for (int s = 0; s < seeds && status == SALTUS_OK; s++) {
        saltus_sweep_line *line = &stream->lines[s];
        saltus_sweep_row *row = &line->row;
        *row = there ? result->rows[s] : saltus_sweep_row_of(SALTUS_PENDING);
        /* All NaNs get the same bits, so that equal results give equal files. */
        for (int k = 0; k < saltus_row_fields.count; k++) {
            const saltus_field *field = &saltus_row_fields.fields[k];
            if (field->type == SALTUS_REAL && isnan(saltus_field_number(field, line)))
                saltus_field_set_number(field, NAN, line);
        }
        saltus_sweep_label(row, line->label);
        if (there && row->attractor >= stream->distinct && row->attractor < seeds)
            stream->distinct = row->attractor + 1;
        if (there && stream->basins && !stream->complete)
            row->attractor = -1;
        else if (there && stream->basins)
            status = saltus_basins_sort(stream->basins, row,
                                        result->states + (size_t)s * saltus_sweep_dimension(stream->sweep),
                                        &row->attractor, message);
    }
    return status;
}

const void *saltus_sweep_stream_cloud(const saltus_sweep_stream *stream, int cloud,
                                      const long long **counts) {
    const saltus_sweep_result *result = &stream->result;
    const long long *const count[SALTUS_CLOUDS] = {result->turning_counts, result->impact_counts,
                                                   result->strobe_counts};
    const void *const entries[SALTUS_CLOUDS] = {result->turning, result->impacts, result->strobes};
    *counts = count[cloud];
    return entries[cloud];
}
