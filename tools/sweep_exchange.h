/* What the threads of a rank exchange while a sweep runs: what there is to do, what has come in, whether to
 * stop. The threads that compute and one that attends to signals, progress and packets meet at it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_SWEEP_EXCHANGE_H
#define SALTUS_TOOLS_SWEEP_EXCHANGE_H

#include "ranks.h"
#include "run_sweep.h"

#include <pthread.h>
#include <stdatomic.h>

enum { SWEEP_INBOX_MAX = 4096 };

/* A packed result on its way to the first rank. */
typedef struct sweep_packed {
    void *bytes;
    size_t size;
    struct sweep_packed *next;
} sweep_packed;

/* The first rank's tasks that nobody has been given yet. */
typedef struct sweep_queue {
    unsigned char *settled; /* a bit for each task that an earlier run did; NULL: none */
    long long next, tasks, open;
    long long longest; /* the first task that is a line of points: lines take longest and come first */
    int met;           /* ranks that have asked for tasks, or left */
} sweep_queue;

/* Another rank's tasks to do and results to send. */
typedef struct sweep_mail {
    long long inbox[SWEEP_INBOX_MAX];
    int first, count;
    bool asked, dry; /* for more tasks; there are no more */
    sweep_packed *outbox, **outbox_end;
    size_t outbox_bytes; /* with those on their way */
} sweep_mail;

/* The first rank's file, and what has gone into it. */
typedef struct sweep_sink {
    pthread_mutex_t writing; /* writing may take its time */
    saltus_sweep_output *output;
    sweep_tally tally;
    long long computed;  /* trajectories */
    atomic_llong points; /* that are there, those of earlier runs too */
} sweep_sink;

typedef struct sweep_exchange {
    const saltus_sweep *sweep; /* NULL where this rank could not make one */
    int ranks, here;
    volatile sig_atomic_t *stop; /* read by the threads that compute without the lock */
    pthread_mutex_t lock;        /* of all that follows but the sink */
    pthread_cond_t changed;
    bool interrupted;
    bool finished; /* this rank's threads have come to an end */
    saltus_status status;
    saltus_message message;
    sweep_queue queue;
    sweep_mail mail;
    sweep_sink sink;
} sweep_exchange;

/* What the first rank knows of another. */
typedef struct sweep_rank {
    bool met, left;
} sweep_rank;

/* A rank's packets to others, and what it knows of theirs; of one thread at a time. */
typedef struct sweep_link {
    sweep_exchange *exchange;
    ranks_outbox sending;
    long long sent;          /* results */
    long long received, due; /* results of other ranks, and how many those that left have sent */
    int left;
    sweep_rank *known; /* per rank */
    bool told;         /* the others know that it is to stop */
} sweep_link;

/* run_sweep.c */
/* Take up to `most` of the tasks that are left; returns how many. The caller holds the lock. */
int sweep_exchange_tasks(sweep_exchange *exchange, long long *tasks, int most);
/* Stop, with the first reason that there was. */
void sweep_exchange_stop(sweep_exchange *exchange, saltus_status status, const saltus_message *message);
/* A result into the file. */
saltus_status sweep_exchange_take(sweep_exchange *exchange, const saltus_sweep_result *result,
                                  saltus_message *message);

/* sweep_ranks.c: the same over several ranks. */
/* How the preparations went on all ranks: the first learns why one is not ready. */
saltus_status sweep_ranks_gather(sweep_link *link, saltus_status status, saltus_message *message);
/* Whether the run begins; the first rank decides by its status. If not, the exit code goes to *code. */
bool sweep_ranks_begin(sweep_link *link, saltus_status status, int *code);
/* Read and write packets. True when something was done. */
bool sweep_ranks_exchange(sweep_link *link);
/* Whether the attending thread may end, once this rank's own threads have. */
bool sweep_ranks_over(sweep_link *link);
/* The other ranks: tell the first that nothing more will come, and wait until it has the file. The exit code
 * is that of the first. The first rank: let them go. */
int sweep_ranks_end(sweep_link *link, int code);

#endif
