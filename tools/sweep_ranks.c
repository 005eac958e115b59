/* How ranks share a sweep. The first rank gives out tasks in batches, each smaller than what would leave the
 * others without work at the end, and receives results; it computes with its own threads meanwhile. A rank
 * asks for more before it runs out. Nobody waits for a packet without sleeping.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_exchange.h"

#include "cli.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    PACKET_READY,   /* to the first: status and message of its preparations */
    PACKET_WISH,    /* to the first: how many tasks are wanted (int) */
    PACKET_TASKS,   /* from the first: tasks; none: there are no more */
    PACKET_RESULT,  /* to the first: a packed result */
    PACKET_OUTCOME, /* to the first: how the run ended (rank_outcome) */
    PACKET_ORDER    /* from the first: what to do (int[2]: order, exit code) */
};

enum { ORDER_GO, ORDER_GIVE_UP, ORDER_STOP, ORDER_END };

/* How a rank's run ended. */
typedef struct rank_outcome {
    long long sent; /* results */
    int status, interrupted;
    saltus_message message;
} rank_outcome;

static void nap(void) {
    struct timespec pause = {0, 1000000};
    nanosleep(&pause, NULL);
}

/* Out of memory for a few bytes: the packet is lost, and the run with it. */
static void send_packet(sweep_exchange *exchange, int to, int kind, const void *bytes, size_t size) {
    saltus_message message = {.text = ""};
    saltus_status status = ranks_send(&exchange->sending, to, kind, bytes, size, &message);
    if (status != SALTUS_OK)
        sweep_exchange_stop(exchange, status, &message);
}

static void send_order(sweep_exchange *exchange, int to, int what, int code) {
    int order[2] = {what, code};
    send_packet(exchange, to, PACKET_ORDER, order, sizeof order);
}

/* A number from a packet of whole numbers; 0 where it has no such. */
static int number_of(const ranks_packet *packet, size_t k) {
    int number = 0;
    if (packet->size >= (k + 1) * sizeof number)
        memcpy(&number, (const char *)packet->bytes + k * sizeof number, sizeof number);
    return number;
}

static void read_outcome(const ranks_packet *packet, rank_outcome *told) {
    *told = (rank_outcome){.status = SALTUS_OK};
    if (packet->size == sizeof *told)
        memcpy(told, packet->bytes, sizeof *told);
    told->message.text[sizeof told->message.text - 1] = '\0';
}

static saltus_message name_rank(int rank, const saltus_message *reason) {
    saltus_message message;
    saltus_fail(&message, SALTUS_OK, "process %d of those started together: %.440s", rank,
                reason->text[0] ? reason->text : "failed");
    return message;
}

saltus_status sweep_ranks_gather(sweep_exchange *exchange, saltus_status status, saltus_message *message) {
    ranks_packet packet;
    if (exchange->here > 0) {
        rank_outcome own = {.status = status, .message = *message};
        send_packet(exchange, 0, PACKET_READY, &own, sizeof own);
        return status;
    }
    for (int heard = 1; heard < exchange->ranks;) {
        rank_outcome told;
        if (!ranks_receive(PACKET_READY, &packet)) {
            nap();
            continue;
        }
        heard++;
        read_outcome(&packet, &told);
        if (status == SALTUS_OK && told.status != SALTUS_OK) {
            status = (saltus_status)told.status;
            *message = name_rank(packet.from, &told.message);
        }
        free(packet.bytes);
    }
    return status;
}

/* The next order of the first rank other than to stop; its exit code in *code. */
static int wait_for_order(sweep_exchange *exchange, int *code) {
    ranks_packet packet;
    for (;;) {
        bool delivered = ranks_delivered(&exchange->sending);
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

bool sweep_ranks_begin(sweep_exchange *exchange, saltus_status status, int *code) {
    if (exchange->here > 0)
        return wait_for_order(exchange, code) == ORDER_GO;
    *code = cli_code(status);
    for (int k = 1; k < exchange->ranks; k++)
        send_order(exchange, k, status == SALTUS_OK ? ORDER_GO : ORDER_GIVE_UP, *code);
    while (!ranks_delivered(&exchange->sending))
        nap();
    return status == SALTUS_OK;
}

/* A rank has been heard of since the run began. The caller holds the lock. */
static void meet(sweep_exchange *exchange, int rank) {
    exchange->met += !exchange->known[rank].met;
    exchange->known[rank].met = true;
}

/* A rank's next tasks: as many as it wishes while there are plenty, at last one by one. */
static void answer_wish(sweep_exchange *exchange, int rank, int wish) {
    long long tasks[SWEEP_INBOX_MAX];
    pthread_mutex_lock(&exchange->lock);
    long long share = exchange->open / (2 * exchange->ranks);
    int most = wish < SWEEP_INBOX_MAX ? wish : SWEEP_INBOX_MAX;
    if (share < most)
        most = share > 0 ? (int)share : 1;
    int count = sweep_exchange_tasks(exchange, tasks, most);
    meet(exchange, rank);
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
    send_packet(exchange, rank, PACKET_TASKS, tasks, (size_t)count * sizeof *tasks);
}

static void accept_result(sweep_exchange *exchange, const ranks_packet *packet) {
    saltus_sweep_result result;
    saltus_message message = {.text = ""};
    saltus_status status = SALTUS_OK;
    exchange->received++;
    if (!saltus_sweep_unpack(exchange->sweep, packet->bytes, packet->size, &result))
        status =
            saltus_fail(&message, SALTUS_BAD_INPUT,
                        "process %d of those started together runs another sweep or version", packet->from);
    else if (sweep_exchange_sound(exchange))
        status = sweep_exchange_take(exchange, &result, &message);
    if (status != SALTUS_OK)
        sweep_exchange_stop(exchange, status, &message);
}

static void end_rank(sweep_exchange *exchange, const ranks_packet *packet) {
    rank_outcome told;
    read_outcome(packet, &told);
    exchange->left++;
    exchange->known[packet->from].left = true;
    exchange->due += told.sent;
    if (told.status != SALTUS_OK) {
        saltus_message message = name_rank(packet->from, &told.message);
        sweep_exchange_stop(exchange, (saltus_status)told.status, &message);
    } else if (told.interrupted)
        sweep_exchange_stop(exchange, SALTUS_OK, NULL);
    pthread_mutex_lock(&exchange->lock);
    meet(exchange, packet->from);
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
}

/* Results while the file is free to take them; otherwise they wait, and wishes are answered first. */
static bool receive_results(sweep_exchange *exchange) {
    ranks_packet packet;
    bool busy = false, any = true;
    while (any && pthread_mutex_trylock(&exchange->writing) == 0) {
        pthread_mutex_unlock(&exchange->writing);
        any = ranks_receive(PACKET_RESULT, &packet);
        if (any) {
            accept_result(exchange, &packet);
            free(packet.bytes);
            busy = true;
        }
    }
    return busy;
}

static bool serve_first(sweep_exchange *exchange) {
    ranks_packet packet;
    bool busy = false;
    while (ranks_receive(PACKET_WISH, &packet)) {
        answer_wish(exchange, packet.from, number_of(&packet, 0));
        free(packet.bytes);
        busy = true;
    }
    busy |= receive_results(exchange);
    while (ranks_receive(PACKET_OUTCOME, &packet)) {
        end_rank(exchange, &packet);
        free(packet.bytes);
        busy = true;
    }
    pthread_mutex_lock(&exchange->lock);
    bool tell = *exchange->stop && !exchange->told;
    pthread_mutex_unlock(&exchange->lock);
    for (int k = 1; k < exchange->ranks && tell; k++)
        if (!exchange->known[k].left)
            send_order(exchange, k, ORDER_STOP, 0);
    exchange->told |= tell;
    ranks_delivered(&exchange->sending);
    return busy;
}

/* What waits to be sent or is on its way; a thread that waits for it to shrink is told. */
static void measure_outbox(sweep_exchange *exchange) {
    pthread_mutex_lock(&exchange->lock);
    size_t before = exchange->outbox_bytes;
    exchange->outbox_bytes = exchange->sending.bytes;
    for (const sweep_packed *packed = exchange->outbox; packed; packed = packed->next)
        exchange->outbox_bytes += packed->size;
    if (exchange->outbox_bytes < before)
        pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
}

/* Send what the computing threads have put out. */
static bool empty_outbox(sweep_exchange *exchange) {
    saltus_message message = {.text = ""};
    saltus_status status = SALTUS_OK;
    pthread_mutex_lock(&exchange->lock);
    sweep_packed *packed = exchange->outbox;
    exchange->outbox = NULL;
    exchange->outbox_end = &exchange->outbox;
    pthread_mutex_unlock(&exchange->lock);
    bool busy = packed;
    while (packed) {
        sweep_packed *next = packed->next;
        if (status == SALTUS_OK)
            status =
                ranks_send_own(&exchange->sending, 0, PACKET_RESULT, packed->bytes, packed->size, &message);
        else
            free(packed->bytes);
        exchange->sent += status == SALTUS_OK;
        free(packed);
        packed = next;
    }
    ranks_delivered(&exchange->sending);
    if (status != SALTUS_OK)
        sweep_exchange_stop(exchange, status, &message);
    measure_outbox(exchange);
    return busy;
}

/* Ask for tasks while there are still some to do. */
static void wish_for_tasks(sweep_exchange *exchange) {
    int wish = 4 * exchange->hands < SWEEP_INBOX_MAX / 2 ? 4 * exchange->hands : SWEEP_INBOX_MAX / 2;
    pthread_mutex_lock(&exchange->lock);
    bool ask = !exchange->asked && !exchange->dry && !*exchange->stop && exchange->count <= wish / 4;
    exchange->asked |= ask;
    pthread_mutex_unlock(&exchange->lock);
    if (ask)
        send_packet(exchange, 0, PACKET_WISH, &wish, sizeof wish);
}

static void accept_tasks(sweep_exchange *exchange, const ranks_packet *packet) {
    size_t count = packet->size / sizeof(long long);
    pthread_mutex_lock(&exchange->lock);
    for (size_t k = 0; k < count && exchange->count < SWEEP_INBOX_MAX; k++) {
        int place = (exchange->first + exchange->count++) % SWEEP_INBOX_MAX;
        memcpy(&exchange->inbox[place], (const char *)packet->bytes + k * sizeof(long long),
               sizeof(long long));
    }
    exchange->asked = false;
    exchange->dry |= count == 0;
    pthread_cond_broadcast(&exchange->changed);
    pthread_mutex_unlock(&exchange->lock);
}

static bool serve_other(sweep_exchange *exchange) {
    ranks_packet packet;
    bool busy = empty_outbox(exchange);
    wish_for_tasks(exchange);
    while (ranks_receive(PACKET_TASKS, &packet)) {
        accept_tasks(exchange, &packet);
        free(packet.bytes);
        busy = true;
    }
    /* During the run there is but one order: to stop. */
    while (ranks_receive(PACKET_ORDER, &packet)) {
        free(packet.bytes);
        pthread_mutex_lock(&exchange->lock);
        *exchange->stop = 1;
        pthread_cond_broadcast(&exchange->changed);
        pthread_mutex_unlock(&exchange->lock);
        busy = true;
    }
    return busy;
}

bool sweep_ranks_exchange(sweep_exchange *exchange) {
    return exchange->here == 0 ? serve_first(exchange) : serve_other(exchange);
}

bool sweep_ranks_over(sweep_exchange *exchange) {
    bool delivered = ranks_delivered(&exchange->sending);
    pthread_mutex_lock(&exchange->lock);
    bool over = exchange->here == 0
                    ? exchange->left == exchange->ranks - 1 && exchange->received == exchange->due
                    : !exchange->outbox && !exchange->asked;
    pthread_mutex_unlock(&exchange->lock);
    return over && delivered;
}

int sweep_ranks_end(sweep_exchange *exchange, int code) {
    if (exchange->here > 0) {
        rank_outcome own = {.sent = exchange->sent,
                            .status = exchange->status,
                            .interrupted = exchange->interrupted,
                            .message = exchange->message};
        send_packet(exchange, 0, PACKET_OUTCOME, &own, sizeof own);
        wait_for_order(exchange, &code);
        return code;
    }
    for (int k = 1; k < exchange->ranks; k++)
        send_order(exchange, k, ORDER_END, code);
    while (!ranks_delivered(&exchange->sending))
        nap();
    return code;
}
