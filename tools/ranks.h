/* Ranks, which are processes started together by mpirun or srun: counters that all of them see, and packets
 * to the first of them. Waiting is done by sleeping, which leaves all cores free. Without MPI, or if the
 * program was started alone, there is one rank and there are no packets. One thread at a time may use what
 * follows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_RANKS_H
#define SALTUS_TOOLS_RANKS_H

#include "saltus/status.h"

#include <stdbool.h>
#include <stddef.h>

/* Join the other ranks, if several were started. All ranks but the first become silent and report errors by
 * packet. False after a message. Call it before starting threads. */
bool ranks_join(void);
/* Call at the end of the program, joined or not. */
void ranks_leave(void);
/* The number of ranks, and the number of this one, from 0. */
int ranks_count(void);
int ranks_here(void);
/* The first rank's bytes, or number, on all ranks, after all have called it. */
void ranks_share(void *bytes, size_t size);
int ranks_agree(int number);
/* On the first rank: the blocks of all ranks, in their order, after all have called it. `all` has room for
 * them there. */
void ranks_gather(const void *own, size_t size, void *all);
/* Number of threads that each rank should use: the ranks on a machine share its cores. 0: started alone. */
int ranks_threads(void);

/* Counters from 0 that the first rank keeps for all. */
enum { RANKS_COUNTERS = 5 };
typedef struct ranks_counters {
    long long alone[RANKS_COUNTERS];
    void *window; /* with several ranks */
} ranks_counters;

/* All ranks call these together. */
void ranks_counters_open(ranks_counters *counters);
void ranks_counters_close(ranks_counters *counters);
/* Add to a counter, and return what it was before. */
long long ranks_count_up(ranks_counters *counters, int which, long long by);

typedef struct ranks_packet {
    int from;
    size_t size;
    void *bytes; /* to be freed by the receiver */
} ranks_packet;

/* Packets being sent. A zeroed one is empty. */
typedef struct ranks_outbox {
    struct ranks_outgoing *first;
    size_t bytes;
} ranks_outbox;

/* Send a packet to the first rank. The outbox takes ownership of `bytes` (from malloc), also on error.
 * Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT (over 2 GB). */
saltus_status ranks_send(ranks_outbox *outbox, void *bytes, size_t size, saltus_message *message);
/* Free delivered packets; true if none is left. */
bool ranks_delivered(ranks_outbox *outbox);
/* On the first rank: receive a packet, if one has arrived. */
bool ranks_receive(ranks_packet *packet);

#endif
