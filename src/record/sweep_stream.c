/* The results of a sweep in the order of its file, read from the journal one place at a time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/sweep_output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool saltus_sweep_stream_open(saltus_sweep_stream *stream) {
    stream->rows = calloc((size_t)saltus_sweep_choices(stream->sweep)->seeds, sizeof *stream->rows);
    return stream->rows != NULL;
}

void saltus_sweep_stream_close(saltus_sweep_stream *stream) {
    free(stream->rows);
    stream->rows = NULL;
}

/* Give every NaN the same bits, so that equal results give equal files. */
static void clean(saltus_sweep_row *row) {
    double *measure[] = {&row->largest,          &row->smallest, &row->impact_rate,   &row->largest_speed,
                         &row->contact_fraction, &row->lyapunov, &row->lyapunov_error};
    for (size_t k = 0; k < sizeof measure / sizeof *measure; k++)
        if (isnan(*measure[k]))
            *measure[k] = NAN;
}

saltus_status saltus_sweep_stream_read(saltus_sweep_stream *stream, long long place,
                                       saltus_message *message) {
    int seeds = saltus_sweep_choices(stream->sweep)->seeds;
    int dimension = saltus_sweep_dimension(stream->sweep);
    stream->distinct = 0;
    if (!stream->journal->offset[place]) {
        stream->result = (saltus_sweep_result){.rows = NULL};
        for (int s = 0; s < seeds; s++)
            stream->rows[s] = saltus_sweep_row_of(SALTUS_PENDING);
        return SALTUS_OK;
    }
    saltus_status status = saltus_journal_get(stream->journal, place, &stream->result, message);
    for (int s = 0; s < seeds && status == SALTUS_OK; s++) {
        saltus_sweep_row *row = &stream->rows[s];
        *row = stream->result.rows[s];
        clean(row);
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
