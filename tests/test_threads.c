/* Spectra from several threads at once are those of one thread, bit for bit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include <pthread.h>

enum { threads = 4, rounds = 40, samples_max = 2048, lines_max = 64 };

/* The results of one thread; they are checked after all have ended. */
typedef struct work {
    double samples[samples_max];
    double found[rounds][4];
    int failures;
} work;

/* Transforms of a new length each time: each is planned while others are planned and executed. */
static void analyse(work *w) {
    for (int r = 0; r < rounds; r++) {
        saltus_signal signal = {.samples = w->samples, .count = 64 * (2 + r % 30), .per_period = 16};
        saltus_spectrum orbits = {.kind = SALTUS_SPECTRUM_CONSTANT}, density = orbits;
        saltus_spectral_line lines[lines_max];
        int line_count = 0;
        w->failures += saltus_signal_orbits(&signal, 4, &orbits, NULL) != SALTUS_OK;
        w->failures += saltus_signal_welch(&signal, 4 + r % 4, 0.9, &density, NULL) != SALTUS_OK;
        w->failures += saltus_signal_lines(&signal, 0, lines_max, lines, &line_count, &w->found[r][2],
                                           NULL) != SALTUS_OK;
        for (long long k = 0; k < orbits.line_count; k++)
            w->found[r][0] += orbits.lines[k].amplitude * cos(orbits.lines[k].phase);
        for (long long k = 0; k < density.bins; k++)
            w->found[r][1] += density.density[k] * (double)(k + 1);
        w->found[r][3] = line_count > 0 ? lines[0].frequency : 0;
        saltus_spectrum_clear(&orbits);
        saltus_spectrum_clear(&density);
    }
}

static void *run(void *context) {
    analyse(context);
    return NULL;
}

static void fill(work *w, int which) {
    *w = (work){.failures = 0};
    for (int j = 0; j < samples_max; j++)
        w->samples[j] = cos(2 * M_PI * (0.31 + 0.1 * which) * j / 16.0) + 0.1 * sin(0.7 * j * j + which);
}

static void spectra_do_not_mind_each_other(void **unused) {
    (void)unused;
    static work together[threads], alone;
    pthread_t thread[threads];
    for (int t = 0; t < threads; t++)
        fill(&together[t], t);
    for (int t = 0; t < threads; t++)
        assert_int_equal(pthread_create(&thread[t], NULL, run, &together[t]), 0);
    for (int t = 0; t < threads; t++)
        assert_int_equal(pthread_join(thread[t], NULL), 0);
    for (int t = 0; t < threads; t++) {
        fill(&alone, t);
        analyse(&alone);
        assert_true(alone.failures == 0 && together[t].failures == 0);
        assert_memory_equal(together[t].found, alone.found, sizeof alone.found);
        assert_true(alone.found[0][0] != 0 && alone.found[0][1] > 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(spectra_do_not_mind_each_other)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
