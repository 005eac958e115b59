/* How threads and ranks share a sweep. Tasks are handed out by a counter that all of them see. Results go to
 * the first rank, which alone writes the file while its own threads compute too. In each rank one more thread
 * attends to signals, packets and progress.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "run_sweep.h"

#include "base/progress.h"
#include "cli.h"
#include "interrupt.h"
#include "progress.h"
#include "ranks.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Returned by the feed to end the sweep; the exchange holds the reason. */
static const saltus_status dropped = SALTUS_NO_CONVERGENCE;

/* Bytes of results on their way above which computing threads wait. */
static const size_t sending_max = 64u << 20;

/* What is counted over all ranks: tasks handed out, ranks but the first that have their first tasks, ranks
 * that stop before the end, ranks but the first whose last result is delivered, and the results that those
 * have sent. */
enum { COUNT_TASKS, COUNT_MET, COUNT_STOPS, COUNT_LEFT, COUNT_SENT };

/* The tasks of this rank. */
typedef struct sweep_queue {
    unsigned char *settled; /* one bit for each task done by an earlier run; NULL: none */
    long long next, end;    /* numbers that this rank has been given and not yet used */
    long long tasks;
    long long longest; /* first task that is a line of points; lines take longest, so they are handed out
                          first */
    bool met;          /* this rank has its first tasks; on the first rank: all others have */
} sweep_queue;

/* Results on their way to the first rank. */
typedef struct sweep_mail {
    ranks_outbox sending;
    long long sent, received;
    bool told; /* the ranks know that this one stops */
} sweep_mail;

/* The first rank's file and counts of its contents. */
typedef struct sweep_sink {
    pthread_mutex_t writing; /* held while writing, which may take long */
    saltus_sweep_output *output;
    sweep_tally tally;
    long long computed;  /* trajectories */
    atomic_llong points; /* points in the file, those of earlier runs included */
} sweep_sink;

/* How a rank has prepared or ended its part. */
typedef struct rank_outcome {
    saltus_status status;
    saltus_message message;
} rank_outcome;

/* What the threads of a rank share. */
typedef struct sweep_exchange {
    const saltus_sweep *sweep; /* NULL if this rank failed to make it */
    int ranks, here;
    rank_outcome *all;           /* room on the first rank for those of all */
    progress bar;                /* of the attending thread */
    volatile sig_atomic_t *stop; /* computing threads read it without the lock */
    pthread_mutex_t lock;        /* held to use what follows but `sink`, and anything of ranks.h */
    pthread_cond_t changed;
    bool finished; /* this rank's computing threads have ended */
    saltus_status status;
    saltus_message message;
    ranks_counters counters;
    sweep_queue queue;
    sweep_mail mail;
    sweep_sink sink;
} sweep_exchange;

saltus_status sweep_tally_add(sweep_tally *tally, const saltus_sweep_row *row, saltus_message *message) {
    char label[32];
    saltus_sweep_label(row, label);
    int k = 0;
    while (k < tally->count && strcmp(tally->classes[k].label, label) != 0)
        k++;
    if (k == tally->room) {
        int room = 2 * tally->room + 16;
        sweep_class *more = realloc(tally->classes, (size_t)room * sizeof *more);
        if (!more)
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the names of motions");
        tally->classes = more;
        tally->room = room;
    }
    if (k == tally->count) {
        tally->classes[tally->count++] = (sweep_class){.count = 0};
        memcpy(tally->classes[k].label, label, sizeof label);
    }
    tally->classes[k].count++;
    return SALTUS_OK;
}

static int more_frequent(const void *a, const void *b) {
    const sweep_class *x = a, *y = b;
    return x->count != y->count ? (x->count < y->count ? 1 : -1) : strcmp(x->label, y->label);
}

void sweep_tally_sort(sweep_tally *tally) {
    if (tally->count)
        qsort(tally->classes, (size_t)tally->count, sizeof *tally->classes, more_frequent);
}

void sweep_tally_clear(sweep_tally *tally) {
    free(tally->classes);
    *tally = (sweep_tally){0};
}

/* Stop all threads; the first failure is kept as the reason. */
static void stop_all(sweep_exchange *exchange, saltus_status status, const saltus_message *message) {
    pthread_mutex_lock(&exchange->lock);
    if (exchange->status == SALTUS_OK && status != SALTUS_OK) {
        exchange->status = status;
        exchange->message = *message;
    }
    *exchange->stop = 1;
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
}

/* Write a result into the file. */
static saltus_status write_result(sweep_exchange *exchange, const saltus_sweep_result *result,
                                  saltus_message *message) {
    sweep_sink *sink = &exchange->sink;
    const int seeds = saltus_sweep_choices(exchange->sweep)->seeds;
    saltus_status status = SALTUS_OK;
    pthread_mutex_lock(&sink->writing);
    if (!saltus_sweep_output_has(sink->output, result->place)) {
        status = saltus_sweep_output_take(sink->output, result, message);
        for (int s = 0; s < seeds && status == SALTUS_OK; s++)
            status = sweep_tally_add(&sink->tally, &result->rows[s], message);
        sink->computed += status == SALTUS_OK ? seeds : 0;
        sink->points += status == SALTUS_OK;
    }
    pthread_mutex_unlock(&sink->writing);
    return status;
}

/* The next task; -1: none, or stop. The first rank waits until every other rank has its first tasks. */
static long long next_task(void *context) {
    enum { usual_lanes = 8, at_a_time = 4 };
    sweep_exchange *exchange = context;
    sweep_queue *queue = &exchange->queue;
    const saltus_sweep_options *how = saltus_sweep_choices(exchange->sweep);
    /* Approximate number of trajectories that this rank computes at a time. */
    const int hands = (how->lanes ? how->lanes : usual_lanes) * (how->threads ? how->threads : 1);
    long long task = -1;
    pthread_mutex_lock(&exchange->lock);
    while (!*exchange->stop && exchange->here == 0 && !queue->met)
        pthread_cond_wait(&exchange->changed, &exchange->lock);
    while (task < 0 && !*exchange->stop) {
        if (queue->next >= queue->end) {
            /* Further numbers of tasks: several at a time while plenty remain, towards the end one, so that
             * no rank is idle there. */
            const long long share = (queue->tasks - queue->end) / (2 * exchange->ranks),
                            most = at_a_time * hands;
            const long long wish = exchange->here == 0 || share < 1 ? 1 : share < most ? share : most;
            queue->next = ranks_count_up(&exchange->counters, COUNT_TASKS, wish);
            queue->end = queue->next + wish < queue->tasks ? queue->next + wish : queue->tasks;
            if (exchange->here > 0 && !queue->met)
                ranks_count_up(&exchange->counters, COUNT_MET, 1);
            queue->met |= exchange->here > 0;
        }
        if (queue->next >= queue->end)
            break;
        task = (queue->longest + queue->next++) % queue->tasks;
        if (queue->settled && queue->settled[task / 8] >> task % 8 & 1)
            task = -1;
    }
    pthread_mutex_unlock(&exchange->lock);
    return task;
}

/* Keep a result, even if the run is being stopped: the first rank writes it, others send it there and wait
 * while too many are on their way. */
static saltus_status take_result(void *context, const saltus_sweep_result *result, saltus_message *message) {
    sweep_exchange *exchange = context;
    sweep_mail *mail = &exchange->mail;
    const size_t size = exchange->here > 0 ? saltus_sweep_packed_size(exchange->sweep, result) : 0;
    void *bytes = size ? malloc(size) : NULL;
    saltus_status status = SALTUS_OK;
    if (exchange->here == 0)
        status = write_result(exchange, result, message);
    else if (!bytes)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a result of %zu bytes", size);
    else
        saltus_sweep_pack(exchange->sweep, result, bytes);
    pthread_mutex_lock(&exchange->lock);
    if (bytes) {
        while (mail->sending.bytes > sending_max && !*exchange->stop)
            pthread_cond_wait(&exchange->changed, &exchange->lock);
        status = ranks_send(&mail->sending, bytes, size, message);
        mail->sent += status == SALTUS_OK;
    }
    const bool stopped = *exchange->stop;
    pthread_mutex_unlock(&exchange->lock);
    if (status != SALTUS_OK)
        stop_all(exchange, status, message);
    return stopped || status != SALTUS_OK ? dropped : SALTUS_OK;
}

/* On the first rank: write a result of another one, if one has arrived and no thread is writing. */
static bool receive_result(sweep_exchange *exchange) {
    ranks_packet packet = {.bytes = NULL};
    saltus_sweep_result result;
    saltus_message message = {.text = ""};
    saltus_status status = SALTUS_OK;
    if (pthread_mutex_trylock(&exchange->sink.writing) != 0)
        return false;
    pthread_mutex_unlock(&exchange->sink.writing);
    pthread_mutex_lock(&exchange->lock);
    const bool arrived = ranks_receive(&packet), sound = exchange->status == SALTUS_OK;
    exchange->mail.received += arrived;
    pthread_mutex_unlock(&exchange->lock);
    if (arrived && !saltus_sweep_unpack(exchange->sweep, packet.bytes, packet.size, &result))
        status =
            saltus_fail(&message, SALTUS_BAD_INPUT,
                        "process %d of those started together runs another sweep or version", packet.from);
    else if (arrived && sound)
        status = write_result(exchange, &result, &message);
    if (status != SALTUS_OK)
        stop_all(exchange, status, &message);
    free(packet.bytes);
    return arrived;
}

/* Tell the other ranks that this one stops, or learn that another one does; free what has been delivered.
 * True when this rank's part is over: no thread computes, and no result is on its way. */
static bool look_around(sweep_exchange *exchange) {
    sweep_mail *mail = &exchange->mail;
    ranks_counters *counters = &exchange->counters;
    pthread_mutex_lock(&exchange->lock);
    if (*exchange->stop && !mail->told)
        ranks_count_up(counters, COUNT_STOPS, 1);
    else if (!mail->told)
        *exchange->stop = ranks_count_up(counters, COUNT_STOPS, 0) > 0;
    mail->told = *exchange->stop;
    const int others = exchange->ranks - 1;
    if (exchange->here == 0 && !exchange->queue.met)
        exchange->queue.met = ranks_count_up(counters, COUNT_MET, 0) == others;
    bool over = ranks_delivered(&mail->sending) && exchange->finished;
    if (exchange->here == 0)
        over = over && ranks_count_up(counters, COUNT_LEFT, 0) == others &&
               ranks_count_up(counters, COUNT_SENT, 0) == mail->received;
    else if (over) {
        ranks_count_up(counters, COUNT_SENT, mail->sent);
        ranks_count_up(counters, COUNT_LEFT, 1);
    }
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
    return over;
}

/* Handle signals, packets and progress until this rank's part is over. */
static void *attend(void *context) {
    static const double nap = 1e-4, longest_nap = 2e-3, alone = 0.1;
    sweep_exchange *exchange = context;
    const bool together = exchange->ranks > 1;
    double pause = nap;
    for (bool over = false; !over;) {
        bool busy = false;
        if (interrupt_asked())
            stop_all(exchange, SALTUS_OK, NULL);
        while (together && exchange->here == 0 && receive_result(exchange))
            busy = true;
        over = look_around(exchange);
        if (exchange->here == 0)
            progress_show(&exchange->bar, exchange->sink.points);
        pause = busy ? nap : pause < longest_nap ? 2 * pause : pause;
        if (!over && !busy) {
            /* Wait until the threads have ended, or for the given time. */
            struct timespec until;
            clock_gettime(CLOCK_MONOTONIC, &until);
            long nanoseconds = until.tv_nsec + (long)(1e9 * (together ? pause : alone));
            until.tv_sec += nanoseconds / 1000000000;
            until.tv_nsec = nanoseconds % 1000000000;
            pthread_mutex_lock(&exchange->lock);
            if (!exchange->finished || together)
                pthread_cond_timedwait(&exchange->changed, &exchange->lock, &until);
            pthread_mutex_unlock(&exchange->lock);
        }
    }
    return NULL;
}

/* Collect how all ranks have fared; the first rank gets the reason of any failure. */
static saltus_status gather(const sweep_exchange *exchange, saltus_status status, saltus_message *message) {
    const rank_outcome own = {status, *message}, *all = exchange->all;
    ranks_gather(&own, sizeof own, exchange->all);
    for (int k = 1; k < exchange->ranks && exchange->here == 0 && status == SALTUS_OK; k++) {
        status = all[k].status;
        if (status != SALTUS_OK)
            saltus_fail(message, status, "process %d of those started together: %.440s", k,
                        all[k].message.text[0] ? all[k].message.text : "failed");
    }
    return status;
}

/* Compute this rank's part. */
static saltus_status compute(sweep_exchange *exchange, saltus_message *message) {
    pthread_t thread;
    const saltus_sweep_feed feed = {.context = exchange, .next = next_task, .take = take_result};
    const bool attended = pthread_create(&thread, NULL, attend, exchange) == 0;
    saltus_status status = attended
                               ? saltus_sweep_run(exchange->sweep, &feed, message)
                               : saltus_fail(message, SALTUS_NO_MEMORY, "no further thread can be started");
    if (status != SALTUS_OK && status != dropped)
        stop_all(exchange, status, message);
    pthread_mutex_lock(&exchange->lock);
    exchange->finished = true;
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
    if (attended)
        pthread_join(thread, NULL);
    else
        attend(exchange);
    *message = exchange->message;
    return exchange->status;
}

/* On the first rank: open the file before anything is computed, and mark the tasks done by an earlier run. */
static saltus_status open_output(sweep_exchange *exchange, const sweep_order *order,
                                 saltus_message *message) {
    const saltus_sweep *sweep = exchange->sweep;
    sweep_queue *queue = &exchange->queue;
    sweep_sink *sink = &exchange->sink;
    saltus_status status = saltus_sweep_output_open(order->path, sweep, order->basins, order->resume,
                                                    order->origin, &sink->output, message);
    for (long long task = 0; task < queue->tasks && status == SALTUS_OK && queue->settled; task++) {
        int length = saltus_sweep_task_length(sweep, task), there = 0;
        for (int k = 0; k < length; k++)
            there += saltus_sweep_output_has(sink->output, saltus_sweep_task_place(sweep, task, k));
        sink->points += there;
        if (there == length)
            queue->settled[task / 8] |= (unsigned char)(1u << task % 8);
    }
    return status;
}

/* Run a sweep from the preparations of all ranks to the completed file; returns the exit code, the same on
 * all. */
static int run_exchange(sweep_exchange *exchange, const sweep_order *order, saltus_status status,
                        saltus_message *message, sweep_report *report) {
    const bool first = exchange->here == 0;
    const char *where = order->to_stdout ? "standard output" : order->path;
    sweep_queue *queue = &exchange->queue;
    saltus_message closing = {.text = ""};
    /* Before the ranks meet: find the longest tasks, and make room for the list of those done by an earlier
     * run. */
    if (status == SALTUS_OK) {
        queue->tasks = saltus_sweep_tasks(order->sweep);
        while (queue->longest < queue->tasks && saltus_sweep_task_length(order->sweep, queue->longest) == 1)
            queue->longest++;
        queue->settled = order->resume ? calloc((size_t)queue->tasks / 8 + 1, 1) : NULL;
        if (order->resume && !queue->settled)
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the list of tasks");
    }
    /* A signal arrived before the start: leave the file as it is. */
    if (status == SALTUS_OK && interrupt_asked())
        status = saltus_fail(message, SALTUS_INTERRUPTED, "interrupted");
    status = gather(exchange, status, message);
    if (status == SALTUS_OK && first)
        status = open_output(exchange, order, message);
    const bool begun = ranks_agree(status == SALTUS_OK);
    const long long places =
        begun ? saltus_sweep_points(order->sweep) * saltus_sweep_pass_count(order->sweep) : 0;
    double begin = saltus_seconds();
    progress_begin(&exchange->bar, order->quiet, places, exchange->sink.points);
    if (begun) {
        if (queue->settled)
            ranks_share(queue->settled, (size_t)queue->tasks / 8 + 1);
        ranks_counters_open(&exchange->counters);
        status = gather(exchange, compute(exchange, message), message);
    }
    report->seconds = saltus_seconds() - begin;
    progress_wipe(&exchange->bar, "writing ...");
    saltus_status written = saltus_sweep_output_close(exchange->sink.output, &closing);
    progress_wipe(&exchange->bar, NULL);
    report->tally = exchange->sink.tally;
    report->computed = exchange->sink.computed;
    int code = CLI_DONE;
    if (first && status != SALTUS_OK)
        code = cli_report_cause(status, message);
    else if (first && written != SALTUS_OK)
        code = cli_report_cause(written, &closing);
    else if (first && exchange->sink.points < places)
        code = cli_refuse(CLI_FAILED, "interrupted; %s holds %lld of %lld points so far%s", where,
                          (long long)exchange->sink.points, places,
                          order->to_stdout ? "" : ", --resume goes on");
    code = ranks_agree(code);
    if (begun)
        ranks_counters_close(&exchange->counters);
    return code;
}

int run_sweep(const sweep_order *order, saltus_status status, const saltus_message *reason,
              sweep_report *report) {
    saltus_message message = *reason;
    pthread_condattr_t clock;
    *report = (sweep_report){.first = ranks_here() == 0, .ranks = ranks_count()};
    if (order->sweep)
        report->rows = saltus_sweep_rows(order->sweep);
    sweep_exchange *exchange = calloc(1, sizeof *exchange);
    int code = CLI_FAILED;
    if (exchange)
        exchange->all = calloc((size_t)report->ranks, sizeof *exchange->all);
    if (exchange && exchange->all) {
        exchange->sweep = order->sweep;
        exchange->ranks = report->ranks;
        exchange->here = ranks_here();
        exchange->stop = order->stop;
        pthread_condattr_init(&clock);
        pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
        pthread_cond_init(&exchange->changed, &clock);
        pthread_condattr_destroy(&clock);
        pthread_mutex_init(&exchange->lock, NULL);
        pthread_mutex_init(&exchange->sink.writing, NULL);
        code = run_exchange(exchange, order, status, &message, report);
        free(exchange->queue.settled);
        pthread_mutex_destroy(&exchange->sink.writing);
        pthread_mutex_destroy(&exchange->lock);
        pthread_cond_destroy(&exchange->changed);
    } else
        fprintf(stderr, "saltus: no memory\n");
    if (exchange)
        free(exchange->all);
    free(exchange);
    return code;
}
