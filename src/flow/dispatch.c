/* Choose the kernel for a model on this processor; open works for it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/kernel.h"
#include "flow/kernel_list.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define DECLARE(model, isa, width) extern const saltus_kernel saltus_kernel_##model##_##isa##_##width;
SALTUS_KERNELS(DECLARE)

typedef enum { isa_base, isa_v3, isa_v4 } isa_level;

#define ENTRY(model, isa, width) {isa_##isa, &saltus_kernel_##model##_##isa##_##width},
static const struct {
    isa_level isa;
    const saltus_kernel *kernel;
} kernels[] = {SALTUS_KERNELS(ENTRY)};

static isa_level processor_level(void) {
#if defined(__x86_64__)
    __builtin_cpu_init();
    bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
              __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
              __builtin_cpu_supports("avx512cd");
    return v4 ? isa_v4 : v3 ? isa_v3 : isa_base;
#else
    return isa_base;
#endif
}

static const char *const isa_names[] = {
    [isa_base] = "x86-64", [isa_v3] = "x86-64-v3", [isa_v4] = "x86-64-v4"};
enum { isa_count = sizeof isa_names / sizeof isa_names[0] };

/* The level named by SALTUS_ISA, or isa_count if it names none. */
static int forced_level(const char *forced) {
    int level = 0;
    while (level < isa_count && strcmp(forced, isa_names[level]) != 0)
        level++;
    return level;
}

saltus_status saltus_kernel_check(saltus_message *message) {
    const char *forced = getenv("SALTUS_ISA");
    if (forced && forced_level(forced) == isa_count)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "SALTUS_ISA = %.40s: must be x86-64, x86-64-v3 or x86-64-v4", forced);
    return SALTUS_OK;
}

const saltus_kernel *saltus_kernel_find(const char *model, int lanes) {
    const char *forced = getenv("SALTUS_ISA");
    const int level = processor_level(), cap = forced ? forced_level(forced) : level;
    const saltus_kernel *best = NULL;
    /* A model's kernels are listed from the lowest instruction set up. */
    for (size_t k = 0; k < sizeof kernels / sizeof kernels[0]; k++) {
        const saltus_kernel *kernel = kernels[k].kernel;
        const int isa = kernels[k].isa;
        if (strcmp(kernel->model, model) == 0 && (lanes == 1) == (kernel->lanes == 1) && isa <= level &&
            isa <= cap)
            best = kernel;
    }
    return best;
}

saltus_status saltus_work_open(saltus_work *work, const saltus_kernel *kernel, const saltus_system *system,
                               int order, int columns, int directions, saltus_tolerance tolerance) {
    *work = (saltus_work){.dof = system->dof,
                          .extra = system->extra,
                          .order = order,
                          .columns = columns,
                          .directions = directions,
                          .tolerance = tolerance,
                          .stops = system->spec.stop_count + 1, /* one more row: the observed displacement */
                          .loaded.tape = system->tape,
                          .hold.count = system->face_count};
    kernel->reserve(work);
    if (!saltus_arena_open(&work->arena))
        return SALTUS_NO_MEMORY;
    kernel->reserve(work);
    work->hold.count = 0;
    work->stops = system->spec.stop_count;
    return SALTUS_OK;
}

void saltus_work_forget(saltus_work *work) {
    work->loaded.terms = 0;
    work->forcing.most = work->vary.orders = 0;
    work->vary.tilts = false;
    memset(work->model.drive, 0, work->model.drive_size * sizeof *work->model.drive);
}

void saltus_work_clear_states(saltus_work *work) {
    size_t rows = ((size_t)work->columns + 1) * (size_t)work->row * sizeof(double);
    memset(work->state.q, 0, rows);
    memset(work->state.v, 0, rows);
    memset(work->state.e, 0, saltus_work_extra_place(work, 1, 0, 0, 0) * sizeof(double));
}

void saltus_work_close(saltus_work *work) {
    saltus_arena_close(&work->arena);
}
