/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "run_sweep.h"

#include "cli.h"
#include "interrupt.h"
#include "sweep_desk.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* What the feed returns to end the engine; the desk knows why. */
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

static bool is_settled(const sweep_desk *desk, long long task) {
    return desk->settled && (desk->settled[task / 8] >> task % 8 & 1);
}

int sweep_desk_tasks(sweep_desk *desk, long long *tasks, int most) {
    int count = 0;
    for (; count < most && desk->next < desk->tasks && !desk->stopped; desk->next++) {
        long long task = (desk->longest + desk->next) % desk->tasks;
        if (!is_settled(desk, task))
            tasks[count++] = task;
    }
    desk->open -= count;
    return count;
}

void sweep_desk_stop(sweep_desk *desk, saltus_status status, const saltus_message *message) {
    pthread_mutex_lock(&desk->lock);
    if (desk->status == SALTUS_OK && status != SALTUS_OK) {
        desk->status = status;
        desk->message = *message;
    }
    desk->interrupted |= status == SALTUS_OK;
    desk->stopped = true;
    pthread_cond_broadcast(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
}

bool sweep_desk_sound(sweep_desk *desk) {
    pthread_mutex_lock(&desk->lock);
    bool sound = desk->status == SALTUS_OK;
    pthread_mutex_unlock(&desk->lock);
    return sound;
}

saltus_status sweep_desk_take(sweep_desk *desk, const saltus_sweep_result *result, saltus_message *message) {
    int seeds = saltus_sweep_choices(desk->sweep)->seeds;
    saltus_status status = SALTUS_OK;
    pthread_mutex_lock(&desk->writing);
    bool fresh = !saltus_sweep_output_has(desk->output, result->place);
    if (fresh)
        status = saltus_sweep_output_take(desk->output, result, message);
    for (int s = 0; s < seeds && fresh && status == SALTUS_OK; s++)
        status = sweep_tally_add(&desk->tally, &result->rows[s], message);
    desk->computed += fresh && status == SALTUS_OK ? seeds : 0;
    pthread_mutex_unlock(&desk->writing);
    pthread_mutex_lock(&desk->lock);
    desk->done += fresh && status == SALTUS_OK;
    pthread_mutex_unlock(&desk->lock);
    return status;
}

/* The next task from what the first rank has sent, which may have to be waited for. */
static long long next_of_inbox(sweep_desk *desk) {
    while (!desk->stopped && desk->count == 0 && !desk->dry)
        pthread_cond_wait(&desk->changed, &desk->lock);
    if (desk->stopped || desk->count == 0)
        return -1;
    long long task = desk->inbox[desk->first];
    desk->first = (desk->first + 1) % SWEEP_INBOX_MAX;
    desk->count--;
    return task;
}

static long long next_task(void *context) {
    sweep_desk *desk = context;
    long long task = -1;
    pthread_mutex_lock(&desk->lock);
    if (desk->here > 0)
        task = next_of_inbox(desk);
    else {
        /* Every rank has its first share before this one goes on to its own. */
        while (!desk->stopped && desk->met < desk->ranks - 1)
            pthread_cond_wait(&desk->changed, &desk->lock);
        if (sweep_desk_tasks(desk, &task, 1) == 0)
            task = -1;
    }
    pthread_mutex_unlock(&desk->lock);
    return task;
}

/* A result into the outbox, once there is room. */
static saltus_status post_result(sweep_desk *desk, const saltus_sweep_result *result,
                                 saltus_message *message) {
    size_t size = saltus_sweep_packed_size(desk->sweep, result);
    sweep_parcel *parcel = malloc(sizeof *parcel);
    void *bytes = malloc(size);
    if (!parcel || !bytes) {
        free(parcel);
        free(bytes);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a result of %zu bytes", size);
    }
    saltus_sweep_pack(desk->sweep, result, bytes);
    *parcel = (sweep_parcel){.bytes = bytes, .size = size};
    pthread_mutex_lock(&desk->lock);
    while (desk->outbox_bytes > outbox_max && !desk->stopped)
        pthread_cond_wait(&desk->changed, &desk->lock);
    *desk->outbox_end = parcel;
    desk->outbox_end = &parcel->next;
    desk->outbox_bytes += size;
    pthread_cond_broadcast(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
    return SALTUS_OK;
}

/* A result that is there is kept, whatever happens after it. */
static saltus_status take_result(void *context, const saltus_sweep_result *result, saltus_message *message) {
    sweep_desk *desk = context;
    saltus_status status =
        desk->here > 0 ? post_result(desk, result, message) : sweep_desk_take(desk, result, message);
    if (status != SALTUS_OK)
        sweep_desk_stop(desk, status, message);
    pthread_mutex_lock(&desk->lock);
    bool stopped = desk->stopped;
    pthread_mutex_unlock(&desk->lock);
    return stopped ? dropped : SALTUS_OK;
}

static bool has_stopped(void *context) {
    sweep_desk *desk = context;
    return atomic_load_explicit(&desk->stopped, memory_order_relaxed);
}

/* Sleep until something changes at the desk, or for a time. */
static void rest(sweep_desk *desk, double seconds) {
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    long nanoseconds = until.tv_nsec + (long)(1e9 * seconds);
    until.tv_sec += nanoseconds / 1000000000;
    until.tv_nsec = nanoseconds % 1000000000;
    pthread_mutex_lock(&desk->lock);
    if (!desk->finished || desk->ranks > 1)
        pthread_cond_timedwait(&desk->changed, &desk->lock, &until);
    pthread_mutex_unlock(&desk->lock);
}

/* Signals, letters and progress, until this rank's threads have come to an end and nothing is under way. */
static void *attend(void *context) {
    static const double nap = 1e-4, longest_nap = 2e-3, alone = 0.1;
    sweep_desk *desk = context;
    double pause = nap;
    for (bool over = false; !over;) {
        if (interrupt_asked())
            sweep_desk_stop(desk, SALTUS_OK, NULL);
        bool busy = desk->ranks > 1 && sweep_ranks_serve(desk);
        pthread_mutex_lock(&desk->lock);
        bool finished = desk->finished;
        long long done = desk->done;
        pthread_mutex_unlock(&desk->lock);
        over = finished && (desk->ranks == 1 || sweep_ranks_over(desk));
        if (desk->here == 0)
            progress_show(&desk->progress, done);
        pause = busy ? nap : pause < longest_nap ? 2 * pause : pause;
        if (!over && !busy)
            rest(desk, desk->ranks > 1 ? pause : alone);
    }
    return NULL;
}

static saltus_status compute(sweep_desk *desk, saltus_message *message) {
    pthread_t attendant;
    if (pthread_create(&attendant, NULL, attend, desk) != 0)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no further thread can be started");
    const saltus_sweep_feed feed = {
        .context = desk, .next = next_task, .take = take_result, .stopped = has_stopped};
    saltus_status status = saltus_sweep_run(desk->sweep, &feed, message);
    if (status != SALTUS_OK && status != dropped)
        sweep_desk_stop(desk, status, message);
    pthread_mutex_lock(&desk->lock);
    desk->finished = true;
    pthread_cond_broadcast(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
    pthread_join(attendant, NULL);
    *message = desk->message;
    return desk->status;
}

/* Mark the tasks that an earlier run has done. */
static saltus_status mark_settled(sweep_desk *desk, unsigned char **marks, saltus_message *message) {
    *marks = calloc((size_t)desk->tasks / 8 + 1, 1);
    if (!*marks)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the list of tasks");
    for (long long task = 0; task < desk->tasks; task++) {
        int length = saltus_sweep_task_length(desk->sweep, task), there = 0;
        for (int k = 0; k < length; k++)
            there += saltus_sweep_output_has(desk->output, saltus_sweep_task_place(desk->sweep, task, k));
        desk->done += there;
        if (there == length) {
            (*marks)[task / 8] |= (unsigned char)(1u << task % 8);
            desk->open--;
        }
    }
    desk->settled = *marks;
    return SALTUS_OK;
}

/* The first rank opens the file before anything is computed. */
static saltus_status open_output(sweep_desk *desk, unsigned char **marks, saltus_message *message) {
    const sweep_order *order = desk->order;
    desk->tasks = desk->open = saltus_sweep_tasks(desk->sweep);
    desk->places = saltus_sweep_points(desk->sweep) * saltus_sweep_pass_count(desk->sweep);
    while (desk->longest < desk->tasks && saltus_sweep_task_length(desk->sweep, desk->longest) == 1)
        desk->longest++;
    if (desk->here > 0)
        return SALTUS_OK;
    saltus_status status = saltus_sweep_output_open(order->path, desk->sweep, order->basins, order->resume,
                                                    &desk->output, message);
    return status == SALTUS_OK && order->resume ? mark_settled(desk, marks, message) : status;
}

/* What the run has come to, on the first rank. */
static int conclude(sweep_desk *desk, saltus_status status, const saltus_message *message,
                    saltus_status written, const saltus_message *closing) {
    if (status != SALTUS_OK)
        return cli_report_cause(status, message);
    if (written != SALTUS_OK)
        return cli_report_cause(written, closing);
    if (desk->done == desk->places)
        return CLI_DONE;
    fprintf(stderr, "saltus: interrupted; %s holds %lld of %lld points so far, --resume goes on\n",
            desk->order->path, desk->done, desk->places);
    return CLI_FAILED;
}

static int run_desk(sweep_desk *desk, saltus_status status, saltus_message *message, sweep_report *report) {
    saltus_message closing = {""};
    unsigned char *marks = NULL;
    bool together = desk->ranks > 1;
    /* A signal that came before: what is in the file stays. */
    if (status == SALTUS_OK && interrupt_asked())
        status = saltus_fail(message, SALTUS_INTERRUPTED, "interrupted");
    if (together)
        status = sweep_ranks_gather(desk, status, message);
    if (status == SALTUS_OK)
        status = open_output(desk, &marks, message);
    int code = CLI_FAILED;
    bool begun = together ? sweep_ranks_begin(desk, status, &code) : status == SALTUS_OK;
    double begin = progress_clock();
    progress_begin(&desk->progress, desk->order->quiet, desk->places, desk->done);
    if (begun)
        status = compute(desk, message);
    report->seconds = progress_clock() - begin;
    progress_wipe(&desk->progress, "writing ...");
    saltus_status written = saltus_sweep_output_close(desk->output, &closing);
    progress_wipe(&desk->progress, NULL);
    if (desk->here == 0)
        code = conclude(desk, status, message, written, &closing);
    report->tally = desk->tally;
    report->computed = desk->computed;
    free(marks);
    return begun && together ? sweep_ranks_part(desk, code) : code;
}

static void free_outbox(sweep_desk *desk) {
    while (desk->outbox) {
        sweep_parcel *parcel = desk->outbox;
        desk->outbox = parcel->next;
        free(parcel->bytes);
        free(parcel);
    }
}

static void prepare_desk(sweep_desk *desk, const sweep_order *order, int ranks) {
    enum { usual_lanes = 8 };
    pthread_condattr_t clock;
    desk->order = order;
    desk->sweep = order->sweep;
    desk->ranks = ranks;
    desk->here = ranks_here();
    desk->outbox_end = &desk->outbox;
    const saltus_sweep_options *how = order->sweep ? saltus_sweep_choices(order->sweep) : NULL;
    desk->hands = (how && how->lanes ? how->lanes : usual_lanes) * (how && how->threads ? how->threads : 1);
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    pthread_cond_init(&desk->changed, &clock);
    pthread_condattr_destroy(&clock);
    pthread_mutex_init(&desk->lock, NULL);
    pthread_mutex_init(&desk->writing, NULL);
}

int run_sweep(const sweep_order *order, saltus_status status, const saltus_message *reason,
              sweep_report *report) {
    saltus_message message = *reason;
    *report = (sweep_report){.first = ranks_here() == 0, .ranks = ranks_count()};
    if (order->sweep)
        report->rows = saltus_sweep_rows(order->sweep);
    sweep_desk *desk = calloc(1, sizeof *desk);
    sweep_rank *known = calloc((size_t)report->ranks, sizeof *known);
    int code = CLI_FAILED;
    if (desk && known) {
        prepare_desk(desk, order, report->ranks);
        desk->known = known;
        code = run_desk(desk, status, &message, report);
        free_outbox(desk);
        pthread_mutex_destroy(&desk->writing);
        pthread_mutex_destroy(&desk->lock);
        pthread_cond_destroy(&desk->changed);
    } else
        fprintf(stderr, "saltus: no memory\n");
    free(known);
    free(desk);
    return code;
}
