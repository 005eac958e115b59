/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "run_sweep.h"

#include "base/progress.h"
#include "cli.h"
#include "interrupt.h"
#include "sweep_exchange.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* What the feed returns to end the engine; the exchange knows why. */
static const saltus_status dropped = SALTUS_NO_CONVERGENCE;

/* Bytes of results that may wait to be sent before the computation waits too. */
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

static bool is_settled(const sweep_exchange *exchange, long long task) {
    return exchange->settled && (exchange->settled[task / 8] >> task % 8 & 1);
}

int sweep_exchange_tasks(sweep_exchange *exchange, long long *tasks, int most) {
    int count = 0;
    for (; count < most && exchange->next < exchange->tasks && !*exchange->stop; exchange->next++) {
        long long task = (exchange->longest + exchange->next) % exchange->tasks;
        if (!is_settled(exchange, task))
            tasks[count++] = task;
    }
    exchange->open -= count;
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

bool sweep_exchange_sound(sweep_exchange *exchange) {
    pthread_mutex_lock(&exchange->lock);
    bool sound = exchange->status == SALTUS_OK;
    pthread_mutex_unlock(&exchange->lock);
    return sound;
}

saltus_status sweep_exchange_take(sweep_exchange *exchange, const saltus_sweep_result *result,
                                  saltus_message *message) {
    int seeds = saltus_sweep_choices(exchange->sweep)->seeds;
    saltus_status status = SALTUS_OK;
    pthread_mutex_lock(&exchange->writing);
    bool fresh = !saltus_sweep_output_has(exchange->output, result->place);
    if (fresh)
        status = saltus_sweep_output_take(exchange->output, result, message);
    for (int s = 0; s < seeds && fresh && status == SALTUS_OK; s++)
        status = sweep_tally_add(&exchange->tally, &result->rows[s], message);
    exchange->computed += fresh && status == SALTUS_OK ? seeds : 0;
    pthread_mutex_unlock(&exchange->writing);
    pthread_mutex_lock(&exchange->lock);
    exchange->done += fresh && status == SALTUS_OK;
    pthread_mutex_unlock(&exchange->lock);
    return status;
}

/* The next task from what the first rank has sent, which may have to be waited for. */
static long long next_of_inbox(sweep_exchange *exchange) {
    while (!*exchange->stop && exchange->count == 0 && !exchange->dry)
        pthread_cond_wait(&exchange->changed, &exchange->lock);
    if (*exchange->stop || exchange->count == 0)
        return -1;
    long long task = exchange->inbox[exchange->first];
    exchange->first = (exchange->first + 1) % SWEEP_INBOX_MAX;
    exchange->count--;
    return task;
}

static long long next_task(void *context) {
    sweep_exchange *exchange = context;
    long long task = -1;
    pthread_mutex_lock(&exchange->lock);
    if (exchange->here > 0)
        task = next_of_inbox(exchange);
    else {
        /* Every rank has its first share before this one goes on to its own. */
        while (!*exchange->stop && exchange->met < exchange->ranks - 1)
            pthread_cond_wait(&exchange->changed, &exchange->lock);
        if (sweep_exchange_tasks(exchange, &task, 1) == 0)
            task = -1;
    }
    pthread_mutex_unlock(&exchange->lock);
    return task;
}

/* A result into the outbox, once there is room. */
static saltus_status post_result(sweep_exchange *exchange, const saltus_sweep_result *result,
                                 saltus_message *message) {
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
    while (exchange->outbox_bytes > outbox_max && !*exchange->stop)
        pthread_cond_wait(&exchange->changed, &exchange->lock);
    *exchange->outbox_end = packed;
    exchange->outbox_end = &packed->next;
    exchange->outbox_bytes += size;
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
    return SALTUS_OK;
}

/* A result that is there is kept, whatever happens after it. */
static saltus_status take_result(void *context, const saltus_sweep_result *result, saltus_message *message) {
    sweep_exchange *exchange = context;
    saltus_status status = exchange->here > 0 ? post_result(exchange, result, message)
                                              : sweep_exchange_take(exchange, result, message);
    if (status != SALTUS_OK)
        sweep_exchange_stop(exchange, status, message);
    pthread_mutex_lock(&exchange->lock);
    bool stopped = *exchange->stop;
    pthread_mutex_unlock(&exchange->lock);
    return stopped ? dropped : SALTUS_OK;
}

/* Sleep until something changes at the exchange, or for a time. */
static void rest(sweep_exchange *exchange, double seconds) {
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    long nanoseconds = until.tv_nsec + (long)(1e9 * seconds);
    until.tv_sec += nanoseconds / 1000000000;
    until.tv_nsec = nanoseconds % 1000000000;
    pthread_mutex_lock(&exchange->lock);
    if (!exchange->finished || exchange->ranks > 1)
        pthread_cond_timedwait(&exchange->changed, &exchange->lock, &until);
    pthread_mutex_unlock(&exchange->lock);
}

/* Signals, packets and progress, until this rank's threads have come to an end and nothing is under way. */
static void *attend(void *context) {
    static const double nap = 1e-4, longest_nap = 2e-3, alone = 0.1;
    sweep_exchange *exchange = context;
    double pause = nap;
    for (bool over = false; !over;) {
        if (interrupt_asked())
            sweep_exchange_stop(exchange, SALTUS_OK, NULL);
        bool busy = exchange->ranks > 1 && sweep_ranks_exchange(exchange);
        pthread_mutex_lock(&exchange->lock);
        bool finished = exchange->finished;
        long long done = exchange->done;
        pthread_mutex_unlock(&exchange->lock);
        over = finished && (exchange->ranks == 1 || sweep_ranks_over(exchange));
        if (exchange->here == 0)
            progress_show(&exchange->progress, done);
        pause = busy ? nap : pause < longest_nap ? 2 * pause : pause;
        if (!over && !busy)
            rest(exchange, exchange->ranks > 1 ? pause : alone);
    }
    return NULL;
}

static saltus_status compute(sweep_exchange *exchange, saltus_message *message) {
    pthread_t attendant;
    if (pthread_create(&attendant, NULL, attend, exchange) != 0)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no further thread can be started");
    const saltus_sweep_feed feed = {.context = exchange, .next = next_task, .take = take_result};
    saltus_status status = saltus_sweep_run(exchange->sweep, &feed, message);
    if (status != SALTUS_OK && status != dropped)
        sweep_exchange_stop(exchange, status, message);
    pthread_mutex_lock(&exchange->lock);
    exchange->finished = true;
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
    pthread_join(attendant, NULL);
    *message = exchange->message;
    return exchange->status;
}

/* Mark the tasks that an earlier run has done. */
static saltus_status mark_settled(sweep_exchange *exchange, unsigned char **marks, saltus_message *message) {
    *marks = calloc((size_t)exchange->tasks / 8 + 1, 1);
    if (!*marks)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the list of tasks");
    for (long long task = 0; task < exchange->tasks; task++) {
        int length = saltus_sweep_task_length(exchange->sweep, task), there = 0;
        for (int k = 0; k < length; k++)
            there +=
                saltus_sweep_output_has(exchange->output, saltus_sweep_task_place(exchange->sweep, task, k));
        exchange->done += there;
        if (there == length) {
            (*marks)[task / 8] |= (unsigned char)(1u << task % 8);
            exchange->open--;
        }
    }
    exchange->settled = *marks;
    return SALTUS_OK;
}

/* The first rank opens the file before anything is computed. */
static saltus_status open_output(sweep_exchange *exchange, unsigned char **marks, saltus_message *message) {
    const sweep_order *order = exchange->order;
    exchange->tasks = exchange->open = saltus_sweep_tasks(exchange->sweep);
    exchange->places = saltus_sweep_points(exchange->sweep) * saltus_sweep_pass_count(exchange->sweep);
    while (exchange->longest < exchange->tasks &&
           saltus_sweep_task_length(exchange->sweep, exchange->longest) == 1)
        exchange->longest++;
    if (exchange->here > 0)
        return SALTUS_OK;
    saltus_status status = saltus_sweep_output_open(order->path, exchange->sweep, order->basins,
                                                    order->resume, order->origin, &exchange->output, message);
    return status == SALTUS_OK && order->resume ? mark_settled(exchange, marks, message) : status;
}

/* What the run has come to, on the first rank. */
static int conclude(sweep_exchange *exchange, saltus_status status, const saltus_message *message,
                    saltus_status written, const saltus_message *closing) {
    if (status != SALTUS_OK)
        return cli_report_cause(status, message);
    if (written != SALTUS_OK)
        return cli_report_cause(written, closing);
    if (exchange->done == exchange->places)
        return CLI_DONE;
    return cli_refuse(CLI_FAILED, "interrupted; %s holds %lld of %lld points so far%s",
                      exchange->order->to_stdout ? "standard output" : exchange->order->path, exchange->done,
                      exchange->places, exchange->order->to_stdout ? "" : ", --resume goes on");
}

static int run_exchange(sweep_exchange *exchange, saltus_status status, saltus_message *message,
                        sweep_report *report) {
    saltus_message closing = {.text = ""};
    unsigned char *marks = NULL;
    bool together = exchange->ranks > 1;
    /* A signal that came before: what is in the file stays. */
    if (status == SALTUS_OK && interrupt_asked())
        status = saltus_fail(message, SALTUS_INTERRUPTED, "interrupted");
    if (together)
        status = sweep_ranks_gather(exchange, status, message);
    if (status == SALTUS_OK)
        status = open_output(exchange, &marks, message);
    int code = CLI_FAILED;
    bool begun = together ? sweep_ranks_begin(exchange, status, &code) : status == SALTUS_OK;
    double begin = saltus_seconds();
    progress_begin(&exchange->progress, exchange->order->quiet, exchange->places, exchange->done);
    if (begun)
        status = compute(exchange, message);
    report->seconds = saltus_seconds() - begin;
    progress_wipe(&exchange->progress, "writing ...");
    saltus_status written = saltus_sweep_output_close(exchange->output, &closing);
    progress_wipe(&exchange->progress, NULL);
    if (exchange->here == 0)
        code = conclude(exchange, status, message, written, &closing);
    report->tally = exchange->tally;
    report->computed = exchange->computed;
    free(marks);
    return begun && together ? sweep_ranks_end(exchange, code) : code;
}

static void free_outbox(sweep_exchange *exchange) {
    while (exchange->outbox) {
        sweep_packed *packed = exchange->outbox;
        exchange->outbox = packed->next;
        free(packed->bytes);
        free(packed);
    }
}

static void open_exchange(sweep_exchange *exchange, const sweep_order *order, int ranks) {
    enum { usual_lanes = 8 };
    pthread_condattr_t clock;
    exchange->order = order;
    exchange->stop = order->stop;
    exchange->sweep = order->sweep;
    exchange->ranks = ranks;
    exchange->here = ranks_here();
    exchange->outbox_end = &exchange->outbox;
    const saltus_sweep_options *how = order->sweep ? saltus_sweep_choices(order->sweep) : NULL;
    exchange->hands =
        (how && how->lanes ? how->lanes : usual_lanes) * (how && how->threads ? how->threads : 1);
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    pthread_cond_init(&exchange->changed, &clock);
    pthread_condattr_destroy(&clock);
    pthread_mutex_init(&exchange->lock, NULL);
    pthread_mutex_init(&exchange->writing, NULL);
}

int run_sweep(const sweep_order *order, saltus_status status, const saltus_message *reason,
              sweep_report *report) {
    saltus_message message = *reason;
    *report = (sweep_report){.first = ranks_here() == 0, .ranks = ranks_count()};
    if (order->sweep)
        report->rows = saltus_sweep_rows(order->sweep);
    sweep_exchange *exchange = calloc(1, sizeof *exchange);
    sweep_rank *known = calloc((size_t)report->ranks, sizeof *known);
    int code = CLI_FAILED;
    if (exchange && known) {
        open_exchange(exchange, order, report->ranks);
        exchange->known = known;
        code = run_exchange(exchange, status, &message, report);
        free_outbox(exchange);
        pthread_mutex_destroy(&exchange->writing);
        pthread_mutex_destroy(&exchange->lock);
        pthread_cond_destroy(&exchange->changed);
    } else
        fprintf(stderr, "saltus: no memory\n");
    free(known);
    free(exchange);
    return code;
}
