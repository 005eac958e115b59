/* The feed of a sweep: tasks come from it and results go to it, one thread at a time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "base/progress.h"

static void lock(saltus_schedule *schedule) {
#ifdef _OPENMP
    omp_set_lock(&schedule->lock);
#else
    (void)schedule;
#endif
}

static void unlock(saltus_schedule *schedule) {
#ifdef _OPENMP
    omp_unset_lock(&schedule->lock);
#else
    (void)schedule;
#endif
}

void saltus_schedule_begin(saltus_schedule *schedule, const saltus_sweep_feed *feed,
                           const volatile sig_atomic_t *stop, saltus_message *message) {
    schedule->feed = feed;
    schedule->stop = stop;
    schedule->status = SALTUS_OK;
    schedule->message = message;
#ifdef _OPENMP
    omp_init_lock(&schedule->lock);
#endif
}

saltus_status saltus_schedule_end(saltus_schedule *schedule) {
#ifdef _OPENMP
    omp_destroy_lock(&schedule->lock);
#endif
    return (saltus_status)schedule->status;
}

long long saltus_schedule_next(saltus_schedule *schedule) {
    lock(schedule);
    long long task = schedule->status == SALTUS_OK ? schedule->feed->next(schedule->feed->context) : -1;
    unlock(schedule);
    return task;
}

void saltus_schedule_emit(saltus_schedule *schedule, saltus_job *job, int place,
                          const saltus_system *system) {
    lock(schedule);
    if (schedule->status == SALTUS_OK)
        schedule->status = saltus_job_emit(job, place, system, schedule->feed, schedule->message);
    unlock(schedule);
}

void saltus_schedule_done(saltus_schedule *schedule, long long task) {
    lock(schedule);
    if (schedule->status == SALTUS_OK && schedule->feed->done)
        schedule->feed->done(schedule->feed->context, task);
    unlock(schedule);
}

void saltus_schedule_fail(saltus_schedule *schedule, saltus_status status, const char *why) {
    lock(schedule);
    if (schedule->status == SALTUS_OK)
        schedule->status = saltus_fail(schedule->message, status, "%s", why);
    unlock(schedule);
}

bool saltus_schedule_open(saltus_schedule *schedule) {
    return !saltus_stop_asked(schedule->stop) &&
           atomic_load_explicit(&schedule->status, memory_order_relaxed) == SALTUS_OK;
}
