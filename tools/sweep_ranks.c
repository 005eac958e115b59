/* How ranks share a sweep. The first rank hands out tasks in batches, small enough that no rank is idle at
 * the end, and receives results, while its own threads compute too. Other ranks ask for more tasks before
 * they run out. Waiting is always done by sleeping.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_exchange.h"

#include "cli.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    PACKET_READY,   /* to the first rank: outcome of its preparations */
    PACKET_WISH,    /* to the first rank: number of tasks wanted (int) */
    PACKET_TASKS,   /* from the first rank: tasks; an empty packet: no more */
    PACKET_RESULT,  /* to the first rank: a packed result */
    PACKET_OUTCOME, /* to the first rank: how the run ended (rank_outcome) */
    PACKET_ORDER    /* from the first rank: what to do (int[2]: order, exit code) */
};

enum { ORDER_GO, ORDER_GIVE_UP, ORDER_STOP, ORDER_END };

/* How a rank's run ended. */
typedef struct rank_outcome {
    long long sent; /* results sent */
    int status, interrupted;
    saltus_message message;
} rank_outcome;

static void nap(void) {
    struct timespec pause = {0, 1000000};
    nanosleep(&pause, NULL);
}

/* Without memory for even a small packet the packet is lost, and the run fails. */
static void send_packet(sweep_link *link, int to, int kind, const void *bytes, size_t size) {
    saltus_message message = {.text = ""};
    saltus_status status = ranks_send(&link->sending, to, kind, bytes, size, &message);
    if (status != SALTUS_OK)
        sweep_exchange_stop(link->exchange, status, &message);
}

/* Send an order to all other ranks that have not left. */
static void send_order(sweep_link *link, int what, int code) {
    const int order[2] = {what, code};
    for (int k = 1; k < link->exchange->ranks; k++)
        if (what == ORDER_END || !link->known[k].left)
            send_packet(link, k, PACKET_ORDER, order, sizeof order);
}

static void wait_for_delivery(sweep_link *link) {
    while (!ranks_delivered(&link->sending))
        nap();
}

/* The k-th integer of a packet; 0 if it is shorter. */
static int number_of(const ranks_packet *packet, size_t k) {
    int number = 0;
    if (packet->size >= (k + 1) * sizeof number)
        memcpy(&number, (const char *)packet->bytes + k * sizeof number, sizeof number);
    return number;
}

/* The outcome of another rank's preparations or run; the message names the rank. */
static rank_outcome read_outcome(const ranks_packet *packet) {
    rank_outcome told = {.status = SALTUS_OK};
    if (packet->size == sizeof told)
        memcpy(&told, packet->bytes, sizeof told);
    told.message.text[sizeof told.message.text - 1] = '\0';
    const saltus_message reason = told.message;
    saltus_fail(&told.message, SALTUS_OK, "process %d of those started together: %.440s", packet->from,
                reason.text[0] ? reason.text : "failed");
    return told;
}

saltus_status sweep_ranks_gather(sweep_link *link, saltus_status status, saltus_message *message) {
    ranks_packet packet;
    if (link->exchange->here > 0) {
        rank_outcome own = {.status = status, .message = *message};
        send_packet(link, 0, PACKET_READY, &own, sizeof own);
        return status;
    }
    for (int heard = 1; heard < link->exchange->ranks;) {
        if (!ranks_receive(PACKET_READY, &packet)) {
            nap();
            continue;
        }
        heard++;
        const rank_outcome told = read_outcome(&packet);
        if (status == SALTUS_OK && told.status != SALTUS_OK) {
            status = (saltus_status)told.status;
            *message = told.message;
        }
        free(packet.bytes);
    }
    return status;
}

/* Wait for the next order of the first rank other than ORDER_STOP; *code receives its exit code. */
static int wait_for_order(sweep_link *link, int *code) {
    ranks_packet packet;
    for (;;) {
        bool delivered = ranks_delivered(&link->sending);
        if (!ranks_receive(PACKET_ORDER, &packet)) {
            nap();
            continue;
        }
        int order = number_of(&packet, 0);
        *code = number_of(&packet, 1);
        free(packet.bytes);
        if (order != ORDER_STOP && delivered)
            return order;
    }
}

bool sweep_ranks_begin(sweep_link *link, saltus_status status, int *code) {
    if (link->exchange->here > 0)
        return wait_for_order(link, code) == ORDER_GO;
    *code = cli_code(status);
    send_order(link, status == SALTUS_OK ? ORDER_GO : ORDER_GIVE_UP, *code);
    wait_for_delivery(link);
    return status == SALTUS_OK;
}

/* Receive and process a packet of this kind, if one has arrived. */
static bool receive(sweep_link *link, int kind, void (*take)(sweep_link *, const ranks_packet *)) {
    ranks_packet packet;
    if (!ranks_receive(kind, &packet))
        return false;
    take(link, &packet);
    free(packet.bytes);
    return true;
}

/* Note that a rank has been heard from since the run began. The caller holds the lock. */
static void meet(sweep_link *link, int rank) {
    link->exchange->queue.met += !link->known[rank].met;
    link->known[rank].met = true;
    pthread_cond_broadcast(&link->exchange->changed);
}

/* Send a rank its next tasks: as many as it asked for while plenty remain, towards the end one at a time. */
static void answer_wish(sweep_link *link, const ranks_packet *packet) {
    sweep_exchange *exchange = link->exchange;
    const int wish = number_of(packet, 0);
    long long tasks[SWEEP_INBOX_MAX];
    pthread_mutex_lock(&exchange->lock);
    long long share = exchange->queue.open / (2 * exchange->ranks);
    int most = wish < SWEEP_INBOX_MAX ? wish : SWEEP_INBOX_MAX;
    if (share < most)
        most = share > 0 ? (int)share : 1;
    int count = sweep_exchange_tasks(exchange, tasks, most);
    meet(link, packet->from);
    pthread_mutex_unlock(&exchange->lock);
    send_packet(link, packet->from, PACKET_TASKS, tasks, (size_t)count * sizeof *tasks);
}

static void accept_result(sweep_link *link, const ranks_packet *packet) {
    sweep_exchange *exchange = link->exchange;
    saltus_sweep_result result;
    saltus_message message = {.text = ""};
    saltus_status status = SALTUS_OK;
    link->received++;
    pthread_mutex_lock(&exchange->lock);
    const bool sound = exchange->status == SALTUS_OK;
    pthread_mutex_unlock(&exchange->lock);
    if (!saltus_sweep_unpack(exchange->sweep, packet->bytes, packet->size, &result))
        status =
            saltus_fail(&message, SALTUS_BAD_INPUT,
                        "process %d of those started together runs another sweep or version", packet->from);
    else if (sound)
        status = sweep_exchange_take(exchange, &result, &message);
    if (status != SALTUS_OK)
        sweep_exchange_stop(exchange, status, &message);
}

static void end_rank(sweep_link *link, const ranks_packet *packet) {
    const rank_outcome told = read_outcome(packet);
    link->left++;
    link->known[packet->from].left = true;
    link->due += told.sent;
    if (told.status != SALTUS_OK || told.interrupted)
        sweep_exchange_stop(link->exchange, (saltus_status)told.status, &told.message);
    pthread_mutex_lock(&link->exchange->lock);
    meet(link, packet->from);
    pthread_mutex_unlock(&link->exchange->lock);
}

/* Whether no thread is writing. If one is, results wait and requests for tasks are answered first. */
static bool can_write(sweep_exchange *exchange) {
    if (pthread_mutex_trylock(&exchange->sink.writing) != 0)
        return false;
    pthread_mutex_unlock(&exchange->sink.writing);
    return true;
}

static bool serve_first(sweep_link *link) {
    bool busy = false;
    while (receive(link, PACKET_WISH, answer_wish))
        busy = true;
    while (can_write(link->exchange) && receive(link, PACKET_RESULT, accept_result))
        busy = true;
    while (receive(link, PACKET_OUTCOME, end_rank))
        busy = true;
    pthread_mutex_lock(&link->exchange->lock);
    bool tell = *link->exchange->stop && !link->told;
    pthread_mutex_unlock(&link->exchange->lock);
    if (tell)
        send_order(link, ORDER_STOP, 0);
    link->told |= tell;
    ranks_delivered(&link->sending);
    return busy;
}

/* Send the results of the computing threads. Threads that wait for the outbox to shrink are woken. */
static bool empty_outbox(sweep_link *link) {
    sweep_exchange *exchange = link->exchange;
    sweep_mail *mail = &exchange->mail;
    saltus_message message = {.text = ""};
    saltus_status status = SALTUS_OK;
    pthread_mutex_lock(&exchange->lock);
    sweep_packed *packed = mail->outbox;
    mail->outbox = NULL;
    mail->outbox_end = &mail->outbox;
    pthread_mutex_unlock(&exchange->lock);
    bool busy = packed;
    while (packed) {
        sweep_packed *next = packed->next;
        if (status == SALTUS_OK)
            status = ranks_send_own(&link->sending, 0, PACKET_RESULT, packed->bytes, packed->size, &message);
        else
            free(packed->bytes);
        link->sent += status == SALTUS_OK;
        free(packed);
        packed = next;
    }
    ranks_delivered(&link->sending);
    if (status != SALTUS_OK)
        sweep_exchange_stop(exchange, status, &message);
    pthread_mutex_lock(&exchange->lock);
    size_t before = mail->outbox_bytes;
    mail->outbox_bytes = link->sending.bytes;
    for (packed = mail->outbox; packed; packed = packed->next)
        mail->outbox_bytes += packed->size;
    if (mail->outbox_bytes < before)
        pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
    return busy;
}

static void accept_tasks(sweep_link *link, const ranks_packet *packet) {
    sweep_exchange *exchange = link->exchange;
    sweep_mail *mail = &exchange->mail;
    size_t count = packet->size / sizeof(long long);
    pthread_mutex_lock(&exchange->lock);
    for (size_t k = 0; k < count && mail->count < SWEEP_INBOX_MAX; k++) {
        int place = (mail->first + mail->count++) % SWEEP_INBOX_MAX;
        memcpy(&mail->inbox[place], (const char *)packet->bytes + k * sizeof(long long), sizeof(long long));
    }
    mail->asked = false;
    mail->dry |= count == 0;
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
}

/* The only order during a run is to stop. */
static void obey(sweep_link *link, const ranks_packet *packet) {
    (void)packet;
    pthread_mutex_lock(&link->exchange->lock);
    *link->exchange->stop = 1;
    pthread_cond_broadcast(&link->exchange->changed);
    pthread_mutex_unlock(&link->exchange->lock);
}

static bool serve_other(sweep_link *link) {
    enum { usual_lanes = 8, at_a_time = 4 };
    sweep_exchange *exchange = link->exchange;
    sweep_mail *mail = &exchange->mail;
    const saltus_sweep_options *how = saltus_sweep_choices(exchange->sweep);
    /* Approximate number of trajectories that this rank computes at a time. */
    const int hands = (how->lanes ? how->lanes : usual_lanes) * (how->threads ? how->threads : 1);
    const int wish = at_a_time * hands < SWEEP_INBOX_MAX / 2 ? at_a_time * hands : SWEEP_INBOX_MAX / 2;
    bool busy = empty_outbox(link);
    /* Ask for more tasks before the inbox is empty. */
    pthread_mutex_lock(&exchange->lock);
    bool ask = !mail->asked && !mail->dry && !*exchange->stop && mail->count <= wish / 4;
    mail->asked |= ask;
    pthread_mutex_unlock(&exchange->lock);
    if (ask)
        send_packet(link, 0, PACKET_WISH, &wish, sizeof wish);
    while (receive(link, PACKET_TASKS, accept_tasks))
        busy = true;
    while (receive(link, PACKET_ORDER, obey))
        busy = true;
    return busy;
}

bool sweep_ranks_exchange(sweep_link *link) {
    return link->exchange->here == 0 ? serve_first(link) : serve_other(link);
}

bool sweep_ranks_over(sweep_link *link) {
    sweep_exchange *exchange = link->exchange;
    bool delivered = ranks_delivered(&link->sending);
    pthread_mutex_lock(&exchange->lock);
    bool over = exchange->here == 0 ? link->left == exchange->ranks - 1 && link->received == link->due
                                    : !exchange->mail.outbox && !exchange->mail.asked;
    pthread_mutex_unlock(&exchange->lock);
    return over && delivered;
}

int sweep_ranks_end(sweep_link *link, int code) {
    const sweep_exchange *exchange = link->exchange;
    if (exchange->here > 0) {
        rank_outcome own = {.sent = link->sent,
                            .status = exchange->status,
                            .interrupted = exchange->interrupted,
                            .message = exchange->message};
        send_packet(link, 0, PACKET_OUTCOME, &own, sizeof own);
        wait_for_order(link, &code);
        return code;
    }
    send_order(link, ORDER_END, code);
    wait_for_delivery(link);
    return code;
}
