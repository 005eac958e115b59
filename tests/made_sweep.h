/* Made-up sweeps as files, for tests of what is drawn of them: every row and cloud is known, no trajectory is
 * run.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_MADE_SWEEP_H
#define SALTUS_TESTS_MADE_SWEEP_H

#include "check.h"

enum { MADE_SEEDS = 4, MADE_DIMENSION = 10, MADE_POINTS = 6000 };

/* One place's result, to be filled in: `rows` first, then the clouds of one seed after the other. */
typedef struct made_place {
    long long place, point;
    saltus_pass pass;
    int seeds, dimension;
    saltus_sweep_row row[MADE_SEEDS];
    long long turning_count[MADE_SEEDS], impact_count[MADE_SEEDS], strobe_count[MADE_SEEDS];
    double turning[MADE_POINTS], strobe[MADE_POINTS];
    saltus_sweep_impact impact[MADE_POINTS];
    double state[MADE_SEEDS * MADE_DIMENSION]; /* at the end, one seed after the other */
} made_place;

typedef void made_fill(made_place *place);

static inline saltus_sweep_row made_periodic(int impacts, int periods) {
    return (saltus_sweep_row){
        .verdict = SALTUS_PERIODIC, .impacts = impacts, .periods = periods, .lyapunov = NAN};
}

static inline saltus_sweep_row made_other(int verdict) {
    return (saltus_sweep_row){
        .verdict = verdict, .attractor = verdict == SALTUS_FAILED ? -1 : 0, .lyapunov = NAN};
}

/* Write the sweep or the basins of a scene; places from `done` on are left out. */
static inline void made_write_as(bool basins, const char *path, const saltus_scene *scene,
                                 const saltus_axis *axes, int count, const saltus_sweep_options *options,
                                 made_fill *fill, long long done) {
    saltus_message message = {.text = ""};
    saltus_sweep *sweep = NULL;
    saltus_sweep_output *output = NULL;
    check_ok(saltus_sweep_new(scene, axes, count, options, &sweep, &message), &message);
    check_ok(saltus_sweep_output_open(path, sweep, basins, false, NULL, &output, &message), &message);
    long long points = saltus_sweep_points(sweep), places = points * saltus_sweep_pass_count(sweep);
    made_place *m = calloc(1, sizeof *m);
    assert_non_null(m);
    for (long long k = 0; k < places && k < done; k++) {
        *m = (made_place){.place = k,
                          .point = k % points,
                          .pass = saltus_sweep_pass_at(sweep, (int)(k / points)),
                          .seeds = options->seeds,
                          .dimension = saltus_sweep_dimension(sweep)};
        assert_true(m->dimension <= MADE_DIMENSION && m->seeds <= MADE_SEEDS);
        fill(m);
        const saltus_sweep_result result = {.place = k,
                                            .rows = m->row,
                                            .states = m->state,
                                            .turning_counts = m->turning_count,
                                            .impact_counts = m->impact_count,
                                            .strobe_counts = m->strobe_count,
                                            .turning = m->turning,
                                            .impacts = m->impact,
                                            .strobes = m->strobe};
        check_ok(saltus_sweep_output_take(output, &result, &message), &message);
    }
    check_ok(saltus_sweep_output_close(output, &message), &message);
    saltus_sweep_free(sweep);
    free(m);
}

static inline void made_write(const char *path, const saltus_scene *scene, const saltus_axis *axes, int count,
                              const saltus_sweep_options *options, made_fill *fill, long long done) {
    made_write_as(false, path, scene, axes, count, options, fill, done);
}

static inline saltus_sweep_file made_read(const char *path) {
    saltus_message message = {.text = ""};
    saltus_sweep_file file;
    check_ok(saltus_sweep_file_read(path, &file, &message), &message);
    return file;
}

#endif
