/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "run_sweep.h"

#include "base/progress.h"
#include "cli.h"
#include "interrupt.h"
#include "progress.h"
#include "sweep_exchange.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Returned by the feed to end the sweep; the exchange holds the reason. */
static const saltus_status dropped = SALTUS_NO_CONVERGENCE;

/* Bytes of unsent results above which computing threads wait. */
static const size_t outbox_max = 64u << 20;

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

int sweep_exchange_tasks(sweep_exchange *exchange, long long *tasks, int most) {
    sweep_queue *queue = &exchange->queue;
    int count = 0;
    for (; count < most && queue->next < queue->tasks && !*exchange->stop; queue->next++) {
        long long task = (queue->longest + queue->next) % queue->tasks;
        if (!queue->settled || !(queue->settled[task / 8] >> task % 8 & 1))
            tasks[count++] = task;
    }
    queue->open -= count;
    return count;
}

void sweep_exchange_stop(sweep_exchange *exchange, saltus_status status, const saltus_message *message) {
    pthread_mutex_lock(&exchange->lock);
    if (exchange->status == SALTUS_OK && status != SALTUS_OK) {
        exchange->status = status;
        exchange->message = *message;
    }
    exchange->interrupted |= status == SALTUS_OK;
    *exchange->stop = 1;
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
}

saltus_status sweep_exchange_take(sweep_exchange *exchange, const saltus_sweep_result *result,
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

/* The next task; -1: none, or stop. May wait: the first rank until every other rank has got its first tasks,
 * the others for tasks from the first rank. */
static long long next_task(void *context) {
    sweep_exchange *exchange = context;
    sweep_mail *mail = &exchange->mail;
    long long task = -1;
    pthread_mutex_lock(&exchange->lock);
    while (!*exchange->stop &&
           (exchange->here > 0 ? mail->count == 0 && !mail->dry : exchange->queue.met < exchange->ranks - 1))
        pthread_cond_wait(&exchange->changed, &exchange->lock);
    if (exchange->here == 0)
        sweep_exchange_tasks(exchange, &task, 1);
    else if (!*exchange->stop && mail->count > 0) {
        task = mail->inbox[mail->first];
        mail->first = (mail->first + 1) % SWEEP_INBOX_MAX;
        mail->count--;
    }
    pthread_mutex_unlock(&exchange->lock);
    return task;
}

/* Put a result into the outbox; waits while it is full. */
static saltus_status post_result(sweep_exchange *exchange, const saltus_sweep_result *result,
                                 saltus_message *message) {
    sweep_mail *mail = &exchange->mail;
    size_t size = saltus_sweep_packed_size(exchange->sweep, result);
    sweep_packed *packed = malloc(sizeof *packed);
    void *bytes = malloc(size);
    if (!packed || !bytes) {
        free(packed);
        free(bytes);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a result of %zu bytes", size);
    }
    saltus_sweep_pack(exchange->sweep, result, bytes);
    *packed = (sweep_packed){.bytes = bytes, .size = size};
    pthread_mutex_lock(&exchange->lock);
    while (mail->outbox_bytes > outbox_max && !*exchange->stop)
        pthread_cond_wait(&exchange->changed, &exchange->lock);
    *mail->outbox_end = packed;
    mail->outbox_end = &packed->next;
    mail->outbox_bytes += size;
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
    return SALTUS_OK;
}

/* Keep the result even if the run is being stopped. */
static saltus_status take_result(void *context, const saltus_sweep_result *result, saltus_message *message) {
    sweep_exchange *exchange = context;
    saltus_status status =
        (exchange->here > 0 ? post_result : sweep_exchange_take)(exchange, result, message);
    if (status != SALTUS_OK)
        sweep_exchange_stop(exchange, status, message);
    pthread_mutex_lock(&exchange->lock);
    bool stopped = *exchange->stop;
    pthread_mutex_unlock(&exchange->lock);
    return stopped ? dropped : SALTUS_OK;
}

/* Arguments of the attending thread. */
typedef struct attendant {
    sweep_link *link;
    progress *bar;
} attendant;

/* Handle signals, packets and progress until this rank's threads have finished and no packet is under way. */
static void *attend(void *context) {
    static const double nap = 1e-4, longest_nap = 2e-3, alone = 0.1;
    const attendant *own = context;
    sweep_exchange *exchange = own->link->exchange;
    const bool together = exchange->ranks > 1;
    double pause = nap;
    for (bool over = false; !over;) {
        if (interrupt_asked())
            sweep_exchange_stop(exchange, SALTUS_OK, NULL);
        bool busy = together && sweep_ranks_exchange(own->link);
        pthread_mutex_lock(&exchange->lock);
        bool finished = exchange->finished;
        pthread_mutex_unlock(&exchange->lock);
        over = finished && (!together || sweep_ranks_over(own->link));
        if (exchange->here == 0)
            progress_show(own->bar, exchange->sink.points);
        pause = busy ? nap : pause < longest_nap ? 2 * pause : pause;
        if (!over && !busy) {
            /* Wait until the exchange changes, or for the given time. */
            struct timespec until;
            clock_gettime(CLOCK_MONOTONIC, &until);
            long nanoseconds = until.tv_nsec + (long)(1e9 * (together ? pause : alone));
            until.tv_sec += nanoseconds / 1000000000;
            until.tv_nsec = nanoseconds % 1000000000;
            pthread_mutex_lock(&exchange->lock);
            if (!exchange->finished || exchange->ranks > 1)
                pthread_cond_timedwait(&exchange->changed, &exchange->lock, &until);
            pthread_mutex_unlock(&exchange->lock);
        }
    }
    return NULL;
}

static saltus_status compute(sweep_link *link, progress *bar, saltus_message *message) {
    sweep_exchange *exchange = link->exchange;
    attendant own = {link, bar};
    pthread_t thread;
    if (pthread_create(&thread, NULL, attend, &own) != 0)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no further thread can be started");
    const saltus_sweep_feed feed = {.context = exchange, .next = next_task, .take = take_result};
    saltus_status status = saltus_sweep_run(exchange->sweep, &feed, message);
    if (status != SALTUS_OK && status != dropped)
        sweep_exchange_stop(exchange, status, message);
    pthread_mutex_lock(&exchange->lock);
    exchange->finished = true;
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
    pthread_join(thread, NULL);
    *message = exchange->message;
    return exchange->status;
}

/* On the first rank: open the file before anything is computed, and mark the tasks done by an earlier run. */
static saltus_status open_output(sweep_exchange *exchange, const sweep_order *order,
                                 saltus_message *message) {
    const saltus_sweep *sweep = exchange->sweep;
    sweep_queue *queue = &exchange->queue;
    sweep_sink *sink = &exchange->sink;
    queue->tasks = queue->open = saltus_sweep_tasks(sweep);
    while (queue->longest < queue->tasks && saltus_sweep_task_length(sweep, queue->longest) == 1)
        queue->longest++;
    saltus_status status = saltus_sweep_output_open(order->path, sweep, order->basins, order->resume,
                                                    order->origin, &sink->output, message);
    if (status != SALTUS_OK || !order->resume)
        return status;
    queue->settled = calloc((size_t)queue->tasks / 8 + 1, 1);
    if (!queue->settled)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the list of tasks");
    for (long long task = 0; task < queue->tasks; task++) {
        int length = saltus_sweep_task_length(sweep, task), there = 0;
        for (int k = 0; k < length; k++)
            there += saltus_sweep_output_has(sink->output, saltus_sweep_task_place(sweep, task, k));
        sink->points += there;
        if (there == length) {
            queue->settled[task / 8] |= (unsigned char)(1u << task % 8);
            queue->open--;
        }
    }
    return SALTUS_OK;
}

/* Run a sweep from the preparations of all ranks to the completed file; returns the exit code. */
static int run_exchange(sweep_link *link, const sweep_order *order, saltus_status status,
                        saltus_message *message, sweep_report *report) {
    sweep_exchange *exchange = link->exchange;
    const bool together = exchange->ranks > 1, first = exchange->here == 0;
    const char *where = order->to_stdout ? "standard output" : order->path;
    saltus_message closing = {.text = ""};
    progress bar;
    int code = CLI_FAILED;
    /* A signal arrived before the start: leave the file as it is. */
    if (status == SALTUS_OK && interrupt_asked())
        status = saltus_fail(message, SALTUS_INTERRUPTED, "interrupted");
    if (together)
        status = sweep_ranks_gather(link, status, message);
    if (status == SALTUS_OK && first)
        status = open_output(exchange, order, message);
    bool begun = together ? sweep_ranks_begin(link, status, &code) : status == SALTUS_OK;
    const long long places =
        begun ? saltus_sweep_points(order->sweep) * saltus_sweep_pass_count(order->sweep) : 0;
    double begin = saltus_seconds();
    progress_begin(&bar, order->quiet, places, exchange->sink.points);
    if (begun)
        status = compute(link, &bar, message);
    report->seconds = saltus_seconds() - begin;
    progress_wipe(&bar, "writing ...");
    saltus_status written = saltus_sweep_output_close(exchange->sink.output, &closing);
    progress_wipe(&bar, NULL);
    report->tally = exchange->sink.tally;
    report->computed = exchange->sink.computed;
    if (first && status != SALTUS_OK)
        code = cli_report_cause(status, message);
    else if (first && written != SALTUS_OK)
        code = cli_report_cause(written, &closing);
    else if (first && exchange->sink.points < places)
        code = cli_refuse(CLI_FAILED, "interrupted; %s holds %lld of %lld points so far%s", where,
                          (long long)exchange->sink.points, places,
                          order->to_stdout ? "" : ", --resume goes on");
    else if (first)
        code = CLI_DONE;
    return begun && together ? sweep_ranks_end(link, code) : code;
}

int run_sweep(const sweep_order *order, saltus_status status, const saltus_message *reason,
              sweep_report *report) {
    saltus_message message = *reason;
    pthread_condattr_t clock;
    *report = (sweep_report){.first = ranks_here() == 0, .ranks = ranks_count()};
    if (order->sweep)
        report->rows = saltus_sweep_rows(order->sweep);
    sweep_exchange *exchange = calloc(1, sizeof *exchange);
    sweep_link link = {.exchange = exchange, .known = calloc((size_t)report->ranks, sizeof *link.known)};
    int code = CLI_FAILED;
    if (exchange && link.known) {
        exchange->sweep = order->sweep;
        exchange->ranks = report->ranks;
        exchange->here = ranks_here();
        exchange->stop = order->stop;
        exchange->mail.outbox_end = &exchange->mail.outbox;
        pthread_condattr_init(&clock);
        pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
        pthread_cond_init(&exchange->changed, &clock);
        pthread_condattr_destroy(&clock);
        pthread_mutex_init(&exchange->lock, NULL);
        pthread_mutex_init(&exchange->sink.writing, NULL);
        code = run_exchange(&link, order, status, &message, report);
        for (sweep_packed *packed = exchange->mail.outbox, *next; packed; packed = next) {
            next = packed->next;
            free(packed->bytes);
            free(packed);
        }
        free(exchange->queue.settled);
        pthread_mutex_destroy(&exchange->sink.writing);
        pthread_mutex_destroy(&exchange->lock);
        pthread_cond_destroy(&exchange->changed);
    } else
        fprintf(stderr, "saltus: no memory\n");
    free(link.known);
    free(exchange);
    return code;
}
