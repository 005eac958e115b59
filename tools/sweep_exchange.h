/* Data shared by the threads of a rank while a sweep runs: tasks, results, and whether to stop. It connects
 * the computing threads with the attending thread, which handles signals, progress and packets.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_SWEEP_EXCHANGE_H
#define SALTUS_TOOLS_SWEEP_EXCHANGE_H

#include "ranks.h"
#include "run_sweep.h"

#include <pthread.h>
#include <stdatomic.h>

enum { SWEEP_INBOX_MAX = 4096 };

/* A packed result to be sent to the first rank. */
typedef struct sweep_packed {
    void *bytes;
    size_t size;
    struct sweep_packed *next;
} sweep_packed;

/* Tasks not yet handed out, on the first rank. */
typedef struct sweep_queue {
    unsigned char *settled; /* one bit for each task done by an earlier run; NULL: none */
    long long next, tasks, open;
    long long longest; /* first task that is a line of points; lines take longest, so they are handed out
                          first */
    int met;           /* other ranks that have asked for tasks, or left */
} sweep_queue;

/* Tasks and unsent results of a rank other than the first. */
typedef struct sweep_mail {
    long long inbox[SWEEP_INBOX_MAX];
    int first, count;
    bool asked, dry; /* asked: for more tasks; dry: there are no more */
    sweep_packed *outbox, **outbox_end;
    size_t outbox_bytes; /* including packets being sent */
} sweep_mail;

/* The first rank's file and counts of its contents. */
typedef struct sweep_sink {
    pthread_mutex_t writing; /* held while writing, which may take long */
    saltus_sweep_output *output;
    sweep_tally tally;
    long long computed;  /* trajectories */
    atomic_llong points; /* points in the file, those of earlier runs included */
} sweep_sink;

typedef struct sweep_exchange {
    const saltus_sweep *sweep; /* NULL if this rank failed to make it */
    int ranks, here;
    volatile sig_atomic_t *stop; /* computing threads read it without the lock */
    pthread_mutex_t lock;        /* protects everything below except `sink` */
    pthread_cond_t changed;
    bool interrupted;
    bool finished; /* this rank's computing threads have ended */
    saltus_status status;
    saltus_message message;
    sweep_queue queue;
    sweep_mail mail;
    sweep_sink sink;
} sweep_exchange;

/* State of another rank, as known to the first. */
typedef struct sweep_rank {
    bool met, left;
} sweep_rank;

/* A rank's packets to other ranks and its knowledge of them; used by one thread at a time. */
typedef struct sweep_link {
    sweep_exchange *exchange;
    ranks_outbox sending;
    long long sent;          /* results sent */
    long long received, due; /* results received, and number sent by ranks that have left */
    int left;
    sweep_rank *known; /* per rank */
    bool told;         /* the others have been told to stop */
} sweep_link;

/* In run_sweep.c. */
/* Take up to `most` of the remaining tasks; returns their number. The caller holds the lock. */
int sweep_exchange_tasks(sweep_exchange *exchange, long long *tasks, int most);
/* Stop all threads; the first failure is kept as the reason. */
void sweep_exchange_stop(sweep_exchange *exchange, saltus_status status, const saltus_message *message);
/* Write a result into the file. */
saltus_status sweep_exchange_take(sweep_exchange *exchange, const saltus_sweep_result *result,
                                  saltus_message *message);

/* In sweep_ranks.c: the exchange between ranks. */
/* Collect the outcome of the preparations on all ranks; the first rank gets the reason of any failure. */
saltus_status sweep_ranks_gather(sweep_link *link, saltus_status status, saltus_message *message);
/* Whether the run begins, which the first rank decides by its status. If not, *code is the exit code. */
bool sweep_ranks_begin(sweep_link *link, saltus_status status, int *code);
/* Receive and send packets; true if there was any. */
bool sweep_ranks_exchange(sweep_link *link);
/* Whether the attending thread may end, once this rank's computing threads have. */
bool sweep_ranks_over(sweep_link *link);
/* On the first rank: release the others. On the others: report the end of the results to the first rank and
 * wait until it has completed the file. Returns the exit code of the first rank. */
int sweep_ranks_end(sweep_link *link, int code);

#endif
