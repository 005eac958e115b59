/* Running a sweep on all cores: one crew per thread, one gate to the feed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <stdatomic.h>

#ifdef _OPENMP
#include <omp.h>
#endif

/* The feed, passed by one thread at a time. */
struct saltus_gate {
    const saltus_sweep_feed *feed;
    atomic_int status;
    saltus_message *message;
#ifdef _OPENMP
    omp_lock_t lock;
#endif
};

#ifdef _OPENMP
static void enter(saltus_gate *gate) {
    omp_set_lock(&gate->lock);
}
static void leave(saltus_gate *gate) {
    omp_unset_lock(&gate->lock);
}
static void install(saltus_gate *gate) {
    omp_init_lock(&gate->lock);
}
static void remove_lock(saltus_gate *gate) {
    omp_destroy_lock(&gate->lock);
}
static int most_threads(void) {
    return omp_get_max_threads();
}
#else
static void enter(saltus_gate *gate) {
    (void)gate;
}
static void leave(saltus_gate *gate) {
    (void)gate;
}
static void install(saltus_gate *gate) {
    (void)gate;
}
static void remove_lock(saltus_gate *gate) {
    (void)gate;
}
static int most_threads(void) {
    return 1;
}
#endif

long long saltus_gate_next(saltus_gate *gate) {
    enter(gate);
    long long task = gate->status == SALTUS_OK ? gate->feed->next(gate->feed->context) : -1;
    leave(gate);
    return task;
}

saltus_status saltus_gate_emit(saltus_gate *gate, saltus_job *job, int place, const saltus_system *system) {
    enter(gate);
    if (gate->status == SALTUS_OK)
        gate->status = saltus_job_emit(job, place, system, gate->feed, gate->message);
    saltus_status status = (saltus_status)gate->status;
    leave(gate);
    return status;
}

void saltus_gate_done(saltus_gate *gate, long long task) {
    enter(gate);
    if (gate->status == SALTUS_OK && gate->feed->done)
        gate->feed->done(gate->feed->context, task);
    leave(gate);
}

void saltus_gate_fail(saltus_gate *gate, saltus_status status, const char *why) {
    enter(gate);
    if (gate->status == SALTUS_OK)
        gate->status = saltus_fail(gate->message, status, "%s", why);
    leave(gate);
}

bool saltus_gate_open(saltus_gate *gate) {
    bool stopped = gate->feed->stopped && gate->feed->stopped(gate->feed->context);
    return !stopped && atomic_load_explicit(&gate->status, memory_order_relaxed) == SALTUS_OK;
}

saltus_status saltus_sweep_run(const saltus_sweep *sweep, const saltus_sweep_feed *feed,
                               saltus_message *message) {
    saltus_message own;
    saltus_gate gate = {.feed = feed, .message = message ? message : &own};
    const int threads = sweep->options.threads > 0 ? sweep->options.threads : most_threads();
    (void)threads;
    install(&gate);
#ifdef _OPENMP
#pragma omp parallel num_threads(threads)
#endif
    saltus_crew_run(sweep, &gate);
    remove_lock(&gate);
    return (saltus_status)gate.status;
}
