/* SPDX-License-Identifier: GPL-3.0-or-later */
#define _GNU_SOURCE
#include "ranks.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef SALTUS_WITH_MPI
#include <mpi.h>
#include <sched.h>
#include <signal.h>
#include <time.h>
#endif

static long number_in(const char *variable) {
    const char *text = getenv(variable);
    return text ? strtol(text, NULL, 10) : 0;
}

/* Number of ranks according to the environment variables of Open MPI, MPICH, MVAPICH and Slurm. */
static long announced(void) {
    static const char *const sizes[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE",
                                        "SLURM_STEP_NUM_TASKS"};
    long most = 1;
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
        if (number_in(sizes[k]) > most)
            most = number_in(sizes[k]);
    return most;
}

/* The first rank speaks, as far as the environment tells which it is. */
static bool refuse(long count, const char *why) {
    static const char *const places[] = {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK",
                                         "MV2_COMM_WORLD_RANK", "SLURM_PROCID"};
    size_t k = 0;
    while (k < sizeof places / sizeof places[0] && !getenv(places[k]))
        k++;
    if (k == sizeof places / sizeof places[0] || number_in(places[k]) == 0)
        fprintf(stderr, "saltus: started as %ld processes together, but %s\n", count, why);
    return false;
}

#ifdef SALTUS_WITH_MPI

struct ranks_outgoing {
    MPI_Request request;
    void *bytes;
    size_t size;
    struct ranks_outgoing *next;
};

static bool joined(void) {
    int begun = 0, ended = 0;
    MPI_Initialized(&begun);
    MPI_Finalized(&ended);
    return begun && !ended;
}

bool ranks_join(void) {
    sigset_t all, usual;
    int level = 0;
    long count = announced();
    if (count < 2 && !getenv("PMIX_RANK"))
        return true;
    /* Threads started by the MPI library must not receive signals meant for this program's threads. */
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &usual);
    const bool started = MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &level) == MPI_SUCCESS;
    pthread_sigmask(SIG_SETMASK, &usual, NULL);
    if (!started)
        return refuse(count, "MPI could not be started");
    if (count > 1 && ranks_count() == 1)
        return refuse(count, "MPI knows of one only: the launcher is not that of the MPI library in use");
    if (level < MPI_THREAD_SERIALIZED && ranks_count() > 1)
        return refuse(count, "this MPI library cannot be used by a program with threads");
    /* Silence all ranks but the first; if that fails, refuse to run. */
    if (ranks_here() > 0 && (!freopen("/dev/null", "w", stdout) || !freopen("/dev/null", "w", stderr)))
        return refuse(count, "/dev/null cannot be opened");
    return true;
}

void ranks_leave(void) {
    if (joined())
        MPI_Finalize();
}

int ranks_count(void) {
    int count = 1;
    if (joined())
        MPI_Comm_size(MPI_COMM_WORLD, &count);
    return count;
}

int ranks_here(void) {
    int here = 0;
    if (joined())
        MPI_Comm_rank(MPI_COMM_WORLD, &here);
    return here;
}

#ifdef __linux__
/* Number of cores available to this process, and to all ranks on its machine together. */
static void count_cores(MPI_Comm machine, int *own, int *all) {
    cpu_set_t mine, ours;
    CPU_ZERO(&mine);
    sched_getaffinity(0, sizeof mine, &mine);
    MPI_Allreduce(&mine, &ours, (int)sizeof mine, MPI_UNSIGNED_CHAR, MPI_BOR, machine);
    *own = CPU_COUNT(&mine);
    *all = CPU_COUNT(&ours);
}
#else
static void count_cores(MPI_Comm machine, int *own, int *all) {
    (void)machine;
    *own = *all = 1;
}
#endif

/* Wait without using the processor. */
static void wait_for(MPI_Request *request) {
    const struct timespec nap = {0, 1000000};
    int done = 0;
    for (MPI_Test(request, &done, MPI_STATUS_IGNORE); !done; MPI_Test(request, &done, MPI_STATUS_IGNORE))
        nanosleep(&nap, NULL);
}

void ranks_share(void *bytes, size_t size) {
    MPI_Request request;
    if (!joined())
        return;
    MPI_Ibcast(bytes, (int)size, MPI_BYTE, 0, MPI_COMM_WORLD, &request);
    wait_for(&request);
}

void ranks_gather(const void *own, size_t size, void *all) {
    MPI_Request request;
    if (!joined()) {
        memcpy(all, own, size);
        return;
    }
    MPI_Igather(own, (int)size, MPI_BYTE, all, (int)size, MPI_BYTE, 0, MPI_COMM_WORLD, &request);
    wait_for(&request);
}

_Static_assert(sizeof(MPI_Win) <= sizeof(void *), "a window's handle is a pointer or a number");

void ranks_counters_open(ranks_counters *counters) {
    long long *kept;
    MPI_Win window;
    *counters = (ranks_counters){.window = NULL};
    if (ranks_count() == 1)
        return;
    const MPI_Aint room = ranks_here() == 0 ? (MPI_Aint)sizeof counters->alone : 0;
    MPI_Win_allocate(room, (int)sizeof *kept, MPI_INFO_NULL, MPI_COMM_WORLD, &kept, &window);
    if (room)
        memset(kept, 0, sizeof counters->alone);
    MPI_Win_lock_all(0, window);
    MPI_Win_sync(window);
    MPI_Barrier(MPI_COMM_WORLD);
    memcpy(&counters->window, &window, sizeof window);
}

void ranks_counters_close(ranks_counters *counters) {
    MPI_Win window;
    memcpy(&window, &counters->window, sizeof window);
    if (ranks_count() == 1)
        return;
    MPI_Win_unlock_all(window);
    MPI_Win_free(&window);
}

long long ranks_count_up(ranks_counters *counters, int which, long long by) {
    MPI_Win window;
    long long before = counters->alone[which];
    memcpy(&window, &counters->window, sizeof window);
    counters->alone[which] += by;
    if (ranks_count() == 1)
        return before;
    MPI_Fetch_and_op(&by, &before, MPI_LONG_LONG, 0, which, MPI_SUM, window);
    MPI_Win_flush(0, window);
    return before;
}

int ranks_threads(void) {
    MPI_Comm machine;
    int neighbours = 1, own = 1, all = 1;
    if (ranks_count() == 1)
        return 0;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
    MPI_Comm_size(machine, &neighbours);
    count_cores(machine, &own, &all);
    MPI_Comm_free(&machine);
    int share = all / neighbours;
    return share < 1 ? 1 : share < own ? share : own;
}

saltus_status ranks_send(ranks_outbox *outbox, void *bytes, size_t size, saltus_message *message) {
    struct ranks_outgoing *outgoing = malloc(sizeof *outgoing);
    if (!outgoing || size > INT_MAX) {
        free(outgoing);
        free(bytes);
        if (size > INT_MAX)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "a result of %zu bytes is too large to be sent between processes", size);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a message between processes");
    }
    *outgoing = (struct ranks_outgoing){.bytes = bytes, .size = size, .next = outbox->first};
    MPI_Isend(bytes, (int)size, MPI_BYTE, 0, 0, MPI_COMM_WORLD, &outgoing->request);
    outbox->first = outgoing;
    outbox->bytes += size;
    return SALTUS_OK;
}

bool ranks_delivered(ranks_outbox *outbox) {
    for (struct ranks_outgoing **place = &outbox->first; *place;) {
        struct ranks_outgoing *outgoing = *place;
        int done = 0;
        MPI_Test(&outgoing->request, &done, MPI_STATUS_IGNORE);
        if (done) {
            *place = outgoing->next;
            outbox->bytes -= outgoing->size;
            free(outgoing->bytes);
            free(outgoing);
        } else
            place = &outgoing->next;
    }
    return !outbox->first;
}

bool ranks_receive(ranks_packet *packet) {
    MPI_Status status;
    int waiting = 0, size = 0;
    if (ranks_count() == 1)
        return false;
    MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &waiting, &status);
    if (!waiting)
        return false;
    MPI_Get_count(&status, MPI_BYTE, &size);
    *packet = (ranks_packet){.from = status.MPI_SOURCE, .size = (size_t)size};
    packet->bytes = malloc(packet->size ? packet->size : 1);
    /* Without memory for a message this rank can neither go on nor tell the others. */
    if (!packet->bytes)
        MPI_Abort(MPI_COMM_WORLD, 1);
    MPI_Recv(packet->bytes, size, MPI_BYTE, status.MPI_SOURCE, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return true;
}

#else

bool ranks_join(void) {
    return announced() < 2 || refuse(announced(), "this saltus was built without MPI: on Debian, install "
                                                  "libopenmpi-dev and openmpi-bin, then build it again");
}

void ranks_leave(void) {}

int ranks_count(void) {
    return 1;
}

int ranks_here(void) {
    return 0;
}

void ranks_share(void *bytes, size_t size) {
    (void)bytes, (void)size;
}

void ranks_gather(const void *own, size_t size, void *all) {
    memcpy(all, own, size);
}

void ranks_counters_open(ranks_counters *counters) {
    *counters = (ranks_counters){.window = NULL};
}

void ranks_counters_close(ranks_counters *counters) {
    (void)counters;
}

long long ranks_count_up(ranks_counters *counters, int which, long long by) {
    counters->alone[which] += by;
    return counters->alone[which] - by;
}

int ranks_threads(void) {
    return 0;
}

saltus_status ranks_send(ranks_outbox *outbox, void *bytes, size_t size, saltus_message *message) {
    (void)outbox, (void)size;
    free(bytes);
    return saltus_fail(message, SALTUS_BAD_INPUT, "this saltus was built without MPI");
}

bool ranks_delivered(ranks_outbox *outbox) {
    (void)outbox;
    return true;
}

bool ranks_receive(ranks_packet *packet) {
    (void)packet;
    return false;
}

#endif

int ranks_agree(int number) {
    ranks_share(&number, sizeof number);
    return number;
}
