/* Derivatives of the state along an orbit by the unknowns.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/response.h"

#include <math.h>
#include <string.h>

void saltus_response_reserve(saltus_response *r, saltus_arena *arena) {
    const size_t n = (size_t)r->n, size = n * (size_t)r->unknowns;
    r->tangents = saltus_arena_doubles(arena, n * (n + (size_t)r->directions));
    r->answer = saltus_arena_doubles(arena, size);
    r->next = saltus_arena_doubles(arena, size);
}

/* Copy the flow's parameter columns into the matrix. */
static void take_parameters(const saltus_response *r, double *answer) {
    for (int d = 0; d < r->directions; d++)
        for (int i = 0; i < r->n && r->place[d] >= 0; i++)
            answer[i * r->unknowns + r->place[d]] = r->tangents[(r->n + d) * r->n + i];
}

void saltus_response_start(saltus_response *r, saltus_flow *flow, int first) {
    saltus_flow_tangents(flow, 0, r->tangents);
    memset(r->answer, 0, (size_t)(r->n * r->unknowns) * sizeof *r->answer);
    for (int i = 0; i < r->n; i++)
        for (int k = 0; k < r->n; k++)
            r->answer[i * r->unknowns + first + k] = r->tangents[k * r->n + i];
    take_parameters(r, r->answer);
}

void saltus_response_begin_piece(saltus_response *r, saltus_flow *flow) {
    const int n = r->n;
    memset(r->tangents, 0, (size_t)(n * (n + r->directions)) * sizeof *r->tangents);
    for (int i = 0; i < n; i++)
        r->tangents[i * n + i] = 1;
    for (int d = 0; d < r->directions; d++)
        for (int i = 0; i < n && r->place[d] >= 0; i++)
            r->tangents[(n + d) * n + i] = r->answer[i * r->unknowns + r->place[d]];
    saltus_flow_set_tangents(flow, 0, r->tangents);
}

void saltus_response_end_piece(saltus_response *r, saltus_flow *flow) {
    const int n = r->n, m = r->unknowns;
    saltus_flow_tangents(flow, 0, r->tangents);
    memset(r->next, 0, (size_t)(n * m) * sizeof *r->next);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < n; i++) {
            const double a = r->tangents[k * n + i];
            for (int j = 0; j < r->plain; j++)
                r->next[i * m + j] = fma(a, r->answer[k * m + j], r->next[i * m + j]);
        }
    take_parameters(r, r->next);
    double *swap = r->answer;
    r->answer = r->next;
    r->next = swap;
}

void saltus_response_mark(const saltus_response *r, const double *gradient, double rate, double scale,
                          int own, double *row) {
    memset(row, 0, (size_t)r->unknowns * sizeof *row);
    for (int i = 0; i < r->n; i++)
        for (int j = 0; j < r->plain; j++)
            row[j] = fma(gradient[i] / scale, r->answer[i * r->unknowns + j], row[j]);
    for (int d = 0; d < r->directions; d++)
        if (r->place[d] >= 0)
            row[r->place[d]] = gradient[r->n + d] / scale;
    row[own] += rate / scale;
}
