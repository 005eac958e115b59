/* The feed of a sweep: tasks come from it and results go to it, one thread at a time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "base/progress.h"

void saltus_schedule_begin(saltus_schedule *schedule, const saltus_sweep_feed *feed,
                           const volatile sig_atomic_t *stop, saltus_message *message) {
    schedule->feed = feed;
    schedule->stop = stop;
    schedule->status = SALTUS_OK;
    schedule->message = message;
    pthread_mutex_init(&schedule->lock, NULL);
}

saltus_status saltus_schedule_end(saltus_schedule *schedule) {
    pthread_mutex_destroy(&schedule->lock);
    return (saltus_status)schedule->status;
}

long long saltus_schedule_next(saltus_schedule *schedule) {
    pthread_mutex_lock(&schedule->lock);
    long long task = schedule->status == SALTUS_OK ? schedule->feed->next(schedule->feed->context) : -1;
    pthread_mutex_unlock(&schedule->lock);
    return task;
}

void saltus_schedule_emit(saltus_schedule *schedule, saltus_job *job, int place,
                          const saltus_system *system) {
    pthread_mutex_lock(&schedule->lock);
    if (schedule->status == SALTUS_OK)
        schedule->status = saltus_job_emit(job, place, system, schedule->feed, schedule->message);
    pthread_mutex_unlock(&schedule->lock);
}

void saltus_schedule_done(saltus_schedule *schedule, long long task) {
    pthread_mutex_lock(&schedule->lock);
    if (schedule->status == SALTUS_OK && schedule->feed->done)
        schedule->feed->done(schedule->feed->context, task);
    pthread_mutex_unlock(&schedule->lock);
}

void saltus_schedule_fail(saltus_schedule *schedule, saltus_status status, const char *why) {
    pthread_mutex_lock(&schedule->lock);
    if (schedule->status == SALTUS_OK)
        schedule->status = saltus_fail(schedule->message, status, "%s", why);
    pthread_mutex_unlock(&schedule->lock);
}

bool saltus_schedule_open(saltus_schedule *schedule) {
    return !saltus_stop_asked(schedule->stop) &&
           atomic_load_explicit(&schedule->status, memory_order_relaxed) == SALTUS_OK;
}
