/* Processes that mpirun or srun started together, called ranks, and packets between them. A packet is sent
 * and received without waiting; whoever waits sleeps in between, so that no core is lost to it. Without MPI,
 * and for a program started alone, there is one rank and there are no packets.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_RANKS_H
#define SALTUS_TOOLS_RANKS_H

#include "saltus/status.h"

#include <stdbool.h>
#include <stddef.h>

/* Take part, where several ranks were started. All but the first fall silent: what goes wrong on them is told
 * by packet. False after a message. To be called before the program has threads. */
bool ranks_join(void);
/* At the end of the program, whether joined or not. */
void ranks_leave(void);
/* How many there are, and which of them this is, from 0. */
int ranks_count(void);
int ranks_here(void);
/* The first rank's number, on all of them, once all have called this. Without other ranks the number itself.
 */
int ranks_agree(int number);
/* Threads that each should use: the cores of this machine are shared by the ranks on it. 0: started alone. */
int ranks_threads(void);

typedef struct ranks_packet {
    int from;
    size_t size;
    void *bytes; /* to be freed by the receiver */
} ranks_packet;

/* Packets on their way out. Zeroed, it is empty. */
typedef struct ranks_outbox {
    struct ranks_outgoing *first;
    size_t bytes;
} ranks_outbox;

/* Send a copy of `size` bytes. Packets of one kind, a small number from 0, arrive in the order in which they
 * were sent. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT (over 2 GB). */
saltus_status ranks_send(ranks_outbox *outbox, int to, int kind, const void *bytes, size_t size,
                         saltus_message *message);
/* The same with bytes from malloc that become the outbox's, also on error. */
saltus_status ranks_send_own(ranks_outbox *outbox, int to, int kind, void *bytes, size_t size,
                             saltus_message *message);
/* Forget what has been delivered; true when nothing is left. */
bool ranks_delivered(ranks_outbox *outbox);
/* Receive a packet of a kind, if one has arrived. */
bool ranks_receive(int kind, ranks_packet *packet);

#endif
