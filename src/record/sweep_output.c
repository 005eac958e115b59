/* Writing the results of a sweep while it runs.
 *
 * Every result goes to the journal at once. A new file made from the journal replaces the old one at the
 * start, then every few seconds, and at the end. The pause between exchanges is proportional to their cost,
 * which thus remains a small part of the time. A CSV table is made only at the end. The journal is removed
 * when the file is complete and safe on the disk.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/sweep_output.h"

#include "base/progress.h"
#include "record/output.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double least_pause = 3;  /* seconds between two exchanges of the file */
static const double pause_ratio = 20; /* the pause relative to the time an exchange takes */

struct saltus_sweep_output {
    const saltus_sweep *sweep;
    saltus_basins *basins; /* NULL: not a basins file */
    saltus_journal journal;
    char *path;
    saltus_origin origin;
    bool table;           /* CSV */
    bool finished;        /* a complete file of this sweep exists: nothing to do */
    double written, cost; /* when the file was last exchanged, and how long that took; seconds */
};

/* Replace the file by one with all results so far. */
static saltus_status exchange(saltus_sweep_output *o, bool last, saltus_message *message) {
    double begin = saltus_seconds();
    saltus_output output;
    saltus_sweep_stream stream = {.sweep = o->sweep,
                                  .journal = &o->journal,
                                  .basins = o->basins,
                                  .origin = &o->origin,
                                  .complete = last && o->journal.found == o->journal.places};
    stream.lines = calloc((size_t)saltus_sweep_choices(o->sweep)->seeds, sizeof *stream.lines);
    if (!stream.lines)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for writing %s", o->path);
    saltus_status status = SALTUS_OK;
    if (!o->table)
        status = saltus_h5_write(o->path, stream.complete, saltus_sweep_put_hdf5, &stream, message);
    else if ((status = saltus_output_open(&output, o->path, message)) == SALTUS_OK) {
        status = saltus_sweep_put_csv(&stream, output.file, message);
        if (stream.complete && status == SALTUS_OK && fflush(output.file) == 0)
            fsync(fileno(output.file));
        status = saltus_output_close(&output, status, message);
    }
    free(stream.lines);
    o->written = saltus_seconds();
    o->cost = o->written - begin;
    return status;
}

static saltus_status open_journal(saltus_sweep_output *o, bool resume, bool exists, saltus_message *message) {
    const saltus_sweep_file head = saltus_sweep_head(o->sweep, o->basins != NULL, false);
    char *text = saltus_sweep_identity_text(&head);
    size_t room = strlen(o->path) + sizeof ".journal";
    char *path = malloc(room), *finished = NULL;
    bool there = false;
    saltus_status status = SALTUS_OK;
    if (!text || !path)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for writing %s", o->path);
    if (status == SALTUS_OK) {
        snprintf(path, room, "%s.journal", o->path);
        status = saltus_journal_open(&o->journal, path, o->sweep, text, resume, &there, message);
    }
    /* Resuming without a journal: a finished file of the same sweep is accepted; nothing is left to do. */
    if (status == SALTUS_OK && !there && resume && exists) {
        status = (o->table ? saltus_sweep_identity_csv : saltus_sweep_identity_hdf5)(o->path, &finished,
                                                                                     &o->finished, message);
        if (status == SALTUS_OK)
            status = saltus_sweep_identity_compare(o->path, finished, text, message);
        if (status == SALTUS_OK && !o->finished)
            status = saltus_fail(message, SALTUS_BAD_INPUT,
                                 "%s: is not finished, and %s.journal, from which it would go on, is not "
                                 "there; --force in place of --resume begins it anew",
                                 o->path, saltus_path_name(o->path));
    }
    if (status == SALTUS_OK && !there && !o->finished)
        status = saltus_journal_begin(&o->journal, text, message);
    free(finished);
    free(text);
    free(path);
    return status;
}

static void release(saltus_sweep_output *o, bool discard) {
    saltus_journal_close(&o->journal, discard);
    saltus_basins_free(o->basins);
    saltus_h5_origin_clear(&o->origin);
    free(o->path);
    free(o);
}

saltus_status saltus_sweep_output_open(const char *path, const saltus_sweep *sweep, bool basins, bool resume,
                                       const saltus_origin *origin, saltus_sweep_output **output,
                                       saltus_message *message) {
    static const unsigned clouds = SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC;
    const bool exists = access(path, F_OK) == 0, table = saltus_path_ends(path, ".csv");
    *output = NULL;
    /* What cannot become a file is told before hours of computation. */
    if (!table && !saltus_path_ends(path, ".h5"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .h5 or .csv", path);
    if (table && saltus_sweep_choices(sweep)->keep & clouds)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%s: turning points, impacts and stroboscopic points are kept in .h5 files only",
                           path);
    saltus_status status = saltus_output_test(path, true, message);
    if (status != SALTUS_OK)
        return status;
    saltus_sweep_output *o = calloc(1, sizeof *o);
    if (!o)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for writing %s", path);
    o->sweep = sweep;
    o->table = table;
    o->path = strdup(path);
    if (!(saltus_h5_origin_keep(&o->origin, origin) && o->path))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for writing %s", path);
    if (status == SALTUS_OK && basins)
        status = saltus_basins_new(sweep, &o->basins, message);
    if (status == SALTUS_OK)
        status = open_journal(o, resume, exists, message);
    if (status == SALTUS_OK && o->journal.found && exists && !o->table)
        status = saltus_h5_origin_take_over(&o->origin, o->path, message);
    if (status == SALTUS_OK && !o->finished && !o->table)
        status = exchange(o, false, message);
    if (status == SALTUS_OK)
        *output = o;
    else
        release(o, o->journal.made && o->journal.found == 0);
    return status;
}

bool saltus_sweep_output_has(const saltus_sweep_output *output, long long place) {
    return output->finished ||
           (place >= 0 && place < output->journal.places && output->journal.offset[place] != 0);
}

saltus_status saltus_sweep_output_take(saltus_sweep_output *output, const saltus_sweep_result *result,
                                       saltus_message *message) {
    if (saltus_sweep_output_has(output, result->place))
        return SALTUS_OK;
    saltus_status status = saltus_journal_add(&output->journal, result, message);
    if (status != SALTUS_OK || output->table ||
        saltus_seconds() - output->written < fmax(least_pause, pause_ratio * output->cost))
        return status;
    return exchange(output, false, message);
}

saltus_status saltus_sweep_output_close(saltus_sweep_output *output, saltus_message *message) {
    if (!output)
        return SALTUS_OK;
    saltus_status status = output->finished ? SALTUS_OK : exchange(output, true, message);
    bool complete = output->finished || output->journal.found == output->journal.places;
    release(output, status == SALTUS_OK && complete);
    return status;
}
