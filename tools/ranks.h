/* Ranks, which are processes started together by mpirun or srun, and packets between them. Packets are sent
 * and received without blocking, and waiting is done by sleeping, which leaves all cores free. Without MPI,
 * or if the program was started alone, there is one rank and there are no packets.
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
/* Returns the first rank's number on all ranks, after all have called it; with a single rank, `number`. */
int ranks_agree(int number);
/* Number of threads that each rank should use: the ranks on a machine share its cores. 0: started alone. */
int ranks_threads(void);

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

/* Send a copy of `size` bytes. Packets of the same kind, a small number from 0, arrive in the order of
 * sending. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT (over 2 GB). */
saltus_status ranks_send(ranks_outbox *outbox, int to, int kind, const void *bytes, size_t size,
                         saltus_message *message);
/* The same without a copy: the outbox takes ownership of `bytes` (from malloc), also on error. */
saltus_status ranks_send_own(ranks_outbox *outbox, int to, int kind, void *bytes, size_t size,
                             saltus_message *message);
/* Free delivered packets; true if none is left. */
bool ranks_delivered(ranks_outbox *outbox);
/* Receive a packet of this kind, if one has arrived. */
bool ranks_receive(int kind, ranks_packet *packet);

#endif
