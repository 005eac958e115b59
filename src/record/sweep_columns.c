/* What the columns of a sweep's tables are called, what they mean and where their values are.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/sweep_columns.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define REAL SALTUS_ENTRY_REAL
#define INT SALTUS_ENTRY_INT
#define LONG SALTUS_ENTRY_LONG
#define ROW(member) offsetof(saltus_sweep_row, member)
#define IMPACT(member) offsetof(saltus_sweep_impact, member)

const saltus_sweep_column saltus_sweep_columns[SALTUS_SWEEP_COLUMNS] = {
    {"verdict", "1", "what the trajectory settled on; pending: not computed", SALTUS_ENTRY_VERDICT,
     ROW(verdict)},
    {"impacts", "1", "n, impacts of one orbit; -1 with complete chatter; 0 where not periodic", INT,
     ROW(impacts)},
    {"periods", "1", "p, forcing periods of one orbit; 0 where not periodic", INT, ROW(periods)},
    {"sticking", "1", "sticking intervals of one orbit", INT, ROW(sticking)},
    {"attractor", "1",
     "which of the distinct attractors met at this point, from 0; in basins, which row of /attractors; -1: "
     "none",
     INT, ROW(attractor)},
    {"settled", "T", "forcing periods until the verdict", LONG, ROW(settled)},
    {"settled_impacts", "1", "impacts until the verdict", LONG, ROW(settled_impacts)},
    {"recorded", "T", "forcing periods recorded", LONG, ROW(recorded)},
    {"largest", "1", "largest observed displacement of the recording; NaN without one", REAL, ROW(largest)},
    {"smallest", "1", "smallest observed displacement of the recording; NaN without one", REAL,
     ROW(smallest)},
    {"impact_rate", "1/T", "impacts per forcing period, those simulated one by one", REAL, ROW(impact_rate)},
    {"largest_speed", "1", "largest speed of an impact; 0 without any", REAL, ROW(largest_speed)},
    {"contact_fraction", "1", "part of the time in contact", REAL, ROW(contact_fraction)},
    {"lyapunov", "1",
     "largest Lyapunov exponent per unit of time; NaN where not asked for, -inf where all directions are "
     "lost",
     REAL, ROW(lyapunov)},
    {"lyapunov_error", "1", "its standard error; 0 where an orbit's multipliers give it", REAL,
     ROW(lyapunov_error)},
};

const saltus_sweep_cloud saltus_sweep_clouds[SALTUS_CLOUDS] = {
    {"turning",
     "turning points of the observed displacement",
     SALTUS_KEEP_TURNING,
     1,
     {{"displacement", "1", "observed displacement where its velocity reverses", REAL, 0}},
     sizeof(double)},
    {"impacts",
     "impacts",
     SALTUS_KEEP_IMPACTS,
     3,
     {{"phase", "T", "of the forcing, in [0, 1)", REAL, IMPACT(phase)},
      {"speed", "1", "normal velocity n.q' just before", REAL, IMPACT(speed)},
      {"face", "1", "which one-sided contact, from 0", INT, IMPACT(face)}},
     sizeof(saltus_sweep_impact)},
    {"stroboscopic",
     "states at phase 0",
     SALTUS_KEEP_STROBOSCOPIC,
     1,
     {{"state", "1", "q, q', further states", REAL, 0}},
     0},
};

const saltus_sweep_column saltus_sweep_distinct = {
    "attractors", "1", "number of distinct attractors met at this point in this pass", INT, 0};
const saltus_sweep_column saltus_sweep_first = {"first", "1", "the row's first entry, from 0", LONG, 0};
const saltus_sweep_column saltus_sweep_count = {"count", "1", "number of the row's entries", LONG, 0};

const saltus_sweep_column saltus_attractor_columns[SALTUS_ATTRACTOR_COLUMNS] = {
    {"impacts", "1", "n, impacts of one orbit; -1 with complete chatter", LONG, 0},
    {"periods", "1", "p, forcing periods of one orbit; 0 where at rest", LONG, 0},
    {"stable", "1", "1 where all multipliers are inside the unit circle", LONG, 0},
    {"first", "1", "the orbit's first entry of state, from 0", LONG, 0},
    {"count", "1", "number of its entries", LONG, 0},
    {"largest_multiplier", "1", "modulus of the largest multiplier; NaN where it has none", REAL, 0},
};

size_t saltus_entry_bytes(saltus_sweep_entry entry) {
    static const size_t bytes[] = {sizeof(double), sizeof(int), sizeof(long long), sizeof(int)};
    return bytes[entry];
}

hid_t saltus_entry_type(saltus_h5 *w, saltus_sweep_entry entry, bool stored) {
    const char *words[SALTUS_VERDICTS];
    switch (entry) {
    case SALTUS_ENTRY_REAL:
        return H5Tcopy(stored ? H5T_IEEE_F64LE : H5T_NATIVE_DOUBLE);
    case SALTUS_ENTRY_INT:
        return H5Tcopy(stored ? H5T_STD_I32LE : H5T_NATIVE_INT);
    case SALTUS_ENTRY_LONG:
        return H5Tcopy(stored ? H5T_STD_I64LE : H5T_NATIVE_LLONG);
    case SALTUS_ENTRY_VERDICT:
        for (int k = 0; k < SALTUS_VERDICTS; k++)
            words[k] = saltus_verdict_word(k);
        return saltus_h5_enumeration(w, H5T_NATIVE_INT, words, NULL, SALTUS_VERDICTS);
    }
    return -1;
}

const char *const saltus_keep_words[] = {"turning", "impacts", "stroboscopic", "lyapunov", NULL};
const char *const saltus_pass_words[] = {"reset", "up", "down", NULL};
const char *const saltus_spacing_words[] = {"linear", "logarithmic", "list", NULL};

const char *saltus_words_join(const char *const *words, unsigned bits, char *text) {
    size_t used = 0;
    text[0] = '\0';
    for (int k = 0; words[k]; k++)
        if (bits >> k & 1)
            used += (size_t)snprintf(text + used, SALTUS_WORDS_MAX - used, "%s%s", used ? "," : "", words[k]);
    return text;
}

bool saltus_words_split(const char *text, const char *const *words, unsigned *bits) {
    *bits = 0;
    while (*text) {
        size_t length = strcspn(text, ",");
        int k = 0;
        while (words[k] && (strlen(words[k]) != length || strncmp(words[k], text, length) != 0))
            k++;
        if (!words[k])
            return false;
        *bits |= 1u << k;
        text += length + (text[length] == ',');
    }
    return true;
}
