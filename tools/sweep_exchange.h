/* What the threads of a rank exchange while a sweep runs: what there is to do, what has come in, whether to
 * stop. The threads that compute and one that attends to signals, progress and packets meet at it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_SWEEP_EXCHANGE_H
#define SALTUS_TOOLS_SWEEP_EXCHANGE_H

#include "progress.h"
#include "ranks.h"
#include "run_sweep.h"

#include <pthread.h>

enum { SWEEP_INBOX_MAX = 4096 };

/* A packed result on its way to the first rank. */
typedef struct sweep_packed {
    void *bytes;
    size_t size;
    struct sweep_packed *next;
} sweep_packed;

/* What the first rank knows of another. */
typedef struct sweep_rank {
    bool met, left;
} sweep_rank;

typedef struct sweep_exchange {
    const sweep_order *order;
    const saltus_sweep *sweep;
    int ranks, here, hands; /* hands: trajectories that this rank computes at a time, about */
    pthread_mutex_t lock;   /* of all that follows up to `writing` */
    pthread_cond_t changed;
    volatile sig_atomic_t *stop; /* read by the threads that compute without the lock */
    bool interrupted;
    bool finished; /* this rank's threads have come to an end */
    saltus_status status;
    saltus_message message;
    /* The first rank: tasks not yet given to anyone, and the points that are there. */
    const unsigned char *settled; /* a bit for each task that an earlier run did; NULL: none */
    long long next, tasks, open;
    long long longest; /* the first task that is a line of points: lines take longest and come first */
    long long done, places;
    int met; /* ranks that have asked for tasks, or left */
    /* The others: tasks to do, results to send. */
    long long inbox[SWEEP_INBOX_MAX];
    int first, count;
    bool asked, dry;
    sweep_packed *outbox, **outbox_end;
    size_t outbox_bytes;
    long long sent;
    /* The first rank's file and tally, under a lock of their own: writing may take its time. */
    pthread_mutex_t writing;
    saltus_sweep_output *output;
    sweep_tally tally;
    long long computed;
    progress progress;
    /* The attending thread's. */
    ranks_outbox sending;
    long long received, due; /* results of other ranks, and how many those that left have sent */
    int left;
    sweep_rank *known; /* per rank */
    bool told;         /* the others know that it is to stop */
} sweep_exchange;

/* run_sweep.c */
/* Take up to `most` of the tasks that are left; returns how many. The caller holds the lock. */
int sweep_exchange_tasks(sweep_exchange *exchange, long long *tasks, int most);
/* Stop, with the first reason that there was. */
void sweep_exchange_stop(sweep_exchange *exchange, saltus_status status, const saltus_message *message);
/* A result into the file. */
saltus_status sweep_exchange_take(sweep_exchange *exchange, const saltus_sweep_result *result,
                                  saltus_message *message);

/* Whether nothing has failed. */
bool sweep_exchange_sound(sweep_exchange *exchange);

/* sweep_ranks.c: the same over several ranks. */
/* How the preparations went on all ranks: the first learns why one is not ready. */
saltus_status sweep_ranks_gather(sweep_exchange *exchange, saltus_status status, saltus_message *message);
/* Whether the run begins; the first rank decides by its status. If not, the exit code goes to *code. */
bool sweep_ranks_begin(sweep_exchange *exchange, saltus_status status, int *code);
/* Read and write packets. True when something was done. */
bool sweep_ranks_exchange(sweep_exchange *exchange);
/* Whether the attending thread may end, once this rank's own threads have. */
bool sweep_ranks_over(sweep_exchange *exchange);
/* The other ranks: tell the first that nothing more will come, and wait until it has the file. The exit code
 * is that of the first. The first rank: let them go. */
int sweep_ranks_end(sweep_exchange *exchange, int code);

#endif
