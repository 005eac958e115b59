/* How ranks share a sweep. The first rank gives out tasks in batches, each smaller than what would leave the
 * others without work at the end, and receives results; it computes with its own threads meanwhile. A rank
 * asks for more before it runs out. Nobody waits for a letter without sleeping.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_desk.h"

#include "cli.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    LETTER_READY,  /* to the first: status and message of its preparations */
    LETTER_WISH,   /* to the first: how many tasks are wanted (int) */
    LETTER_TASKS,  /* from the first: tasks; none: there are no more */
    LETTER_RESULT, /* to the first: a packed result */
    LETTER_LEFT,   /* to the first: how the run ended (parting) */
    LETTER_ORDER   /* from the first: what to do (int[2]: order, exit code) */
};

enum { ORDER_GO, ORDER_GIVE_UP, ORDER_STOP, ORDER_PART };

/* How a rank's run ended. */
typedef struct parting {
    long long sent; /* results */
    int status, interrupted;
    saltus_message message;
} parting;

static void nap(void) {
    struct timespec pause = {0, 1000000};
    nanosleep(&pause, NULL);
}

/* Out of memory for a few bytes: the letter is lost, and the run with it. */
static void send_letter(sweep_desk *desk, int to, int kind, const void *bytes, size_t size) {
    saltus_message message = {""};
    saltus_status status = ranks_send(&desk->mail, to, kind, bytes, size, &message);
    if (status != SALTUS_OK)
        sweep_desk_stop(desk, status, &message);
}

static void send_order(sweep_desk *desk, int to, int what, int code) {
    int order[2] = {what, code};
    send_letter(desk, to, LETTER_ORDER, order, sizeof order);
}

/* A number from a letter of whole numbers; 0 where it has no such. */
static int number_of(const ranks_letter *letter, size_t k) {
    int number = 0;
    if (letter->size >= (k + 1) * sizeof number)
        memcpy(&number, (const char *)letter->bytes + k * sizeof number, sizeof number);
    return number;
}

static void read_parting(const ranks_letter *letter, parting *told) {
    *told = (parting){.status = SALTUS_OK};
    if (letter->size == sizeof *told)
        memcpy(told, letter->bytes, sizeof *told);
    told->message.text[sizeof told->message.text - 1] = '\0';
}

static saltus_message name_rank(int rank, const saltus_message *reason) {
    saltus_message message;
    saltus_fail(&message, SALTUS_OK, "process %d of those started together: %.440s", rank,
                reason->text[0] ? reason->text : "failed");
    return message;
}

saltus_status sweep_ranks_gather(sweep_desk *desk, saltus_status status, saltus_message *message) {
    ranks_letter letter;
    if (desk->here > 0) {
        parting own = {.status = status, .message = *message};
        send_letter(desk, 0, LETTER_READY, &own, sizeof own);
        return status;
    }
    for (int heard = 1; heard < desk->ranks;) {
        parting told;
        if (!ranks_receive(LETTER_READY, &letter)) {
            nap();
            continue;
        }
        heard++;
        read_parting(&letter, &told);
        if (status == SALTUS_OK && told.status != SALTUS_OK) {
            status = (saltus_status)told.status;
            *message = name_rank(letter.from, &told.message);
        }
        free(letter.bytes);
    }
    return status;
}

/* The next order of the first rank other than to stop; its exit code in *code. */
static int wait_for_order(sweep_desk *desk, int *code) {
    ranks_letter letter;
    for (;;) {
        bool delivered = ranks_delivered(&desk->mail);
        if (!ranks_receive(LETTER_ORDER, &letter)) {
            nap();
            continue;
        }
        int order = number_of(&letter, 0);
        *code = number_of(&letter, 1);
        free(letter.bytes);
        if (order != ORDER_STOP && delivered)
            return order;
    }
}

bool sweep_ranks_begin(sweep_desk *desk, saltus_status status, int *code) {
    if (desk->here > 0)
        return wait_for_order(desk, code) == ORDER_GO;
    *code = cli_code(status);
    for (int k = 1; k < desk->ranks; k++)
        send_order(desk, k, status == SALTUS_OK ? ORDER_GO : ORDER_GIVE_UP, *code);
    while (!ranks_delivered(&desk->mail))
        nap();
    return status == SALTUS_OK;
}

/* A rank has been heard of since the run began. The caller holds the lock. */
static void meet(sweep_desk *desk, int rank) {
    desk->met += !desk->known[rank].met;
    desk->known[rank].met = true;
}

/* A rank's next tasks: as many as it wishes while there are plenty, at last one by one. */
static void answer_wish(sweep_desk *desk, int rank, int wish) {
    long long tasks[SWEEP_INBOX_MAX];
    pthread_mutex_lock(&desk->lock);
    long long share = desk->open / (2 * desk->ranks);
    int most = wish < SWEEP_INBOX_MAX ? wish : SWEEP_INBOX_MAX;
    if (share < most)
        most = share > 0 ? (int)share : 1;
    int count = sweep_desk_tasks(desk, tasks, most);
    meet(desk, rank);
    pthread_cond_broadcast(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
    send_letter(desk, rank, LETTER_TASKS, tasks, (size_t)count * sizeof *tasks);
}

static void accept_result(sweep_desk *desk, const ranks_letter *letter) {
    saltus_sweep_result result;
    saltus_message message = {""};
    saltus_status status = SALTUS_OK;
    desk->received++;
    if (!saltus_sweep_unpack(desk->sweep, letter->bytes, letter->size, &result))
        status =
            saltus_fail(&message, SALTUS_BAD_INPUT,
                        "process %d of those started together runs another sweep or version", letter->from);
    else if (sweep_desk_sound(desk))
        status = sweep_desk_take(desk, &result, &message);
    if (status != SALTUS_OK)
        sweep_desk_stop(desk, status, &message);
}

static void see_off(sweep_desk *desk, const ranks_letter *letter) {
    parting told;
    read_parting(letter, &told);
    desk->left++;
    desk->known[letter->from].left = true;
    desk->due += told.sent;
    if (told.status != SALTUS_OK) {
        saltus_message message = name_rank(letter->from, &told.message);
        sweep_desk_stop(desk, (saltus_status)told.status, &message);
    } else if (told.interrupted)
        sweep_desk_stop(desk, SALTUS_OK, NULL);
    pthread_mutex_lock(&desk->lock);
    meet(desk, letter->from);
    pthread_cond_broadcast(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
}

/* Results while the file is free to take them; otherwise they wait, and wishes are answered first. */
static bool receive_results(sweep_desk *desk) {
    ranks_letter letter;
    bool busy = false, any = true;
    while (any && pthread_mutex_trylock(&desk->writing) == 0) {
        pthread_mutex_unlock(&desk->writing);
        any = ranks_receive(LETTER_RESULT, &letter);
        if (any) {
            accept_result(desk, &letter);
            free(letter.bytes);
            busy = true;
        }
    }
    return busy;
}

static bool serve_first(sweep_desk *desk) {
    ranks_letter letter;
    bool busy = false;
    while (ranks_receive(LETTER_WISH, &letter)) {
        answer_wish(desk, letter.from, number_of(&letter, 0));
        free(letter.bytes);
        busy = true;
    }
    busy |= receive_results(desk);
    while (ranks_receive(LETTER_LEFT, &letter)) {
        see_off(desk, &letter);
        free(letter.bytes);
        busy = true;
    }
    pthread_mutex_lock(&desk->lock);
    bool tell = desk->stopped && !desk->told;
    pthread_mutex_unlock(&desk->lock);
    for (int k = 1; k < desk->ranks && tell; k++)
        if (!desk->known[k].left)
            send_order(desk, k, ORDER_STOP, 0);
    desk->told |= tell;
    ranks_delivered(&desk->mail);
    return busy;
}

/* What waits to be sent or is on its way; a thread that waits for it to shrink is told. */
static void measure_outbox(sweep_desk *desk) {
    pthread_mutex_lock(&desk->lock);
    size_t before = desk->outbox_bytes;
    desk->outbox_bytes = desk->mail.bytes;
    for (const sweep_parcel *parcel = desk->outbox; parcel; parcel = parcel->next)
        desk->outbox_bytes += parcel->size;
    if (desk->outbox_bytes < before)
        pthread_cond_broadcast(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
}

/* Send what the computing threads have put out. */
static bool empty_outbox(sweep_desk *desk) {
    saltus_message message = {""};
    saltus_status status = SALTUS_OK;
    pthread_mutex_lock(&desk->lock);
    sweep_parcel *parcel = desk->outbox;
    desk->outbox = NULL;
    desk->outbox_end = &desk->outbox;
    pthread_mutex_unlock(&desk->lock);
    bool busy = parcel;
    while (parcel) {
        sweep_parcel *next = parcel->next;
        if (status == SALTUS_OK)
            status = ranks_send_own(&desk->mail, 0, LETTER_RESULT, parcel->bytes, parcel->size, &message);
        else
            free(parcel->bytes);
        desk->sent += status == SALTUS_OK;
        free(parcel);
        parcel = next;
    }
    ranks_delivered(&desk->mail);
    if (status != SALTUS_OK)
        sweep_desk_stop(desk, status, &message);
    measure_outbox(desk);
    return busy;
}

/* Ask for tasks while there are still some to do. */
static void wish_for_tasks(sweep_desk *desk) {
    int wish = 4 * desk->hands < SWEEP_INBOX_MAX / 2 ? 4 * desk->hands : SWEEP_INBOX_MAX / 2;
    pthread_mutex_lock(&desk->lock);
    bool ask = !desk->asked && !desk->dry && !desk->stopped && desk->count <= wish / 4;
    desk->asked |= ask;
    pthread_mutex_unlock(&desk->lock);
    if (ask)
        send_letter(desk, 0, LETTER_WISH, &wish, sizeof wish);
}

static void accept_tasks(sweep_desk *desk, const ranks_letter *letter) {
    size_t count = letter->size / sizeof(long long);
    pthread_mutex_lock(&desk->lock);
    for (size_t k = 0; k < count && desk->count < SWEEP_INBOX_MAX; k++) {
        int place = (desk->first + desk->count++) % SWEEP_INBOX_MAX;
        memcpy(&desk->inbox[place], (const char *)letter->bytes + k * sizeof(long long), sizeof(long long));
    }
    desk->asked = false;
    desk->dry |= count == 0;
    pthread_cond_broadcast(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
}

static bool serve_other(sweep_desk *desk) {
    ranks_letter letter;
    bool busy = empty_outbox(desk);
    wish_for_tasks(desk);
    while (ranks_receive(LETTER_TASKS, &letter)) {
        accept_tasks(desk, &letter);
        free(letter.bytes);
        busy = true;
    }
    /* During the run there is but one order: to stop. */
    while (ranks_receive(LETTER_ORDER, &letter)) {
        free(letter.bytes);
        pthread_mutex_lock(&desk->lock);
        desk->stopped = true;
        pthread_cond_broadcast(&desk->changed);
        pthread_mutex_unlock(&desk->lock);
        busy = true;
    }
    return busy;
}

bool sweep_ranks_serve(sweep_desk *desk) {
    return desk->here == 0 ? serve_first(desk) : serve_other(desk);
}

bool sweep_ranks_over(sweep_desk *desk) {
    bool delivered = ranks_delivered(&desk->mail);
    pthread_mutex_lock(&desk->lock);
    bool over = desk->here == 0 ? desk->left == desk->ranks - 1 && desk->received == desk->due
                                : !desk->outbox && !desk->asked;
    pthread_mutex_unlock(&desk->lock);
    return over && delivered;
}

int sweep_ranks_part(sweep_desk *desk, int code) {
    if (desk->here > 0) {
        parting own = {.sent = desk->sent,
                       .status = desk->status,
                       .interrupted = desk->interrupted,
                       .message = desk->message};
        send_letter(desk, 0, LETTER_LEFT, &own, sizeof own);
        wait_for_order(desk, &code);
        return code;
    }
    for (int k = 1; k < desk->ranks; k++)
        send_order(desk, k, ORDER_PART, code);
    while (!ranks_delivered(&desk->mail))
        nap();
    return code;
}
