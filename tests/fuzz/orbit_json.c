/* Fuzz target: orbits read from JSON. The first byte says which part of the file is asked for.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const parts[] = {"", ":1", ":2", ":12", ":PD1", ":0", ":", ":x"};
    static const char hdf5[] = "\x89HDF\r\n\x1a\n";
    char path[128], source[160];
    saltus_start start;
    saltus_scene scene;
    saltus_message message = {.text = ""};
    /* HDF5 files have a target of their own. */
    if (size < 1 || (size > 8 && memcmp(data + 1, hdf5, 8) == 0))
        return 0;
    fuzz_write(fuzz_path(path), data + 1, size - 1);
    snprintf(source, sizeof source, "%s%s", path, parts[data[0] % (sizeof parts / sizeof parts[0])]);
    saltus_status status = saltus_start_read(source, NULL, &start, &message);
    remove(path);
    fuzz_check_refusal(status, &message);
    if (status != SALTUS_OK)
        return 0;
    fuzz_check(start.dimension > 0 && start.dimension <= SALTUS_SCENE_STATE_MAX &&
                   (start.periods > 0 || start.rests),
               "an orbit without a state or a period is taken");
    fuzz_check(saltus_scene_load("fig7d", &scene, &message) == SALTUS_OK, message.text);
    fuzz_check_refusal(saltus_start_apply(&start, source, &scene, &message), &message);
    saltus_start_release(&start);
    return 0;
}
