/* The results of a sweep in the order of its file, read from the journal one place at a time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/sweep_output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool saltus_sweep_stream_open(saltus_sweep_stream *stream) {
    stream->lines = calloc((size_t)saltus_sweep_choices(stream->sweep)->seeds, sizeof *stream->lines);
    return stream->lines != NULL;
}

void saltus_sweep_stream_close(saltus_sweep_stream *stream) {
    free(stream->lines);
    stream->lines = NULL;
}

/* Complete a line. Every NaN gets the same bits, so that equal results give equal files. */
static void finish(saltus_sweep_line *line) {
    for (int k = 0; k < saltus_row_fields.count; k++) {
        const saltus_field *field = &saltus_row_fields.fields[k];
        if (field->type == SALTUS_REAL && isnan(saltus_field_number(field, line)))
            saltus_field_set_number(field, NAN, line);
    }
    saltus_sweep_label(&line->row, line->label);
}

saltus_status saltus_sweep_stream_read(saltus_sweep_stream *stream, long long place,
                                       saltus_message *message) {
    int seeds = saltus_sweep_choices(stream->sweep)->seeds;
    int dimension = saltus_sweep_dimension(stream->sweep);
    stream->distinct = 0;
    if (!stream->journal->offset[place]) {
        stream->result = (saltus_sweep_result){.rows = NULL};
        for (int s = 0; s < seeds; s++) {
            stream->lines[s].row = saltus_sweep_row_of(SALTUS_PENDING);
            finish(&stream->lines[s]);
        }
        return SALTUS_OK;
    }
    saltus_status status = saltus_journal_get(stream->journal, place, &stream->result, message);
    for (int s = 0; s < seeds && status == SALTUS_OK; s++) {
        saltus_sweep_row *row = &stream->lines[s].row;
        *row = stream->result.rows[s];
        finish(&stream->lines[s]);
        if (row->attractor >= stream->distinct && row->attractor < seeds)
            stream->distinct = row->attractor + 1;
        if (stream->basins && !stream->complete)
            row->attractor = -1;
        else if (stream->basins)
            status = saltus_basins_sort(stream->basins, row, stream->result.states + (size_t)s * dimension,
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
