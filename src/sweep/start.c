/* Where trajectories of a sweep begin: systems and initial states at its points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <math.h>
#include <string.h>

/* Mix bits until each of the numbers moves all of them (splitmix64's finaliser). */
static unsigned long long mix(unsigned long long x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}

void saltus_sweep_seed(gsl_rng *rng, unsigned long seed, long long point, int which) {
    unsigned long long bits = mix(mix(mix(seed) ^ (unsigned long long)point) ^ (unsigned long long)which);
    gsl_rng_set(rng, (unsigned long)(bits & 0xffffffffULL));
}

saltus_status saltus_sweep_initial(const saltus_sweep *sweep, long long point, int seed,
                                   const saltus_system *system, gsl_rng *rng, double *state,
                                   saltus_message *message) {
    if (seed > 0) {
        saltus_sweep_seed(rng, sweep->options.seed, point, seed);
        return saltus_state_random(system, rng, state, message);
    }
    if (sweep->scene.initial_count == 0 && !sweep->moves_start)
        return saltus_system_default_state(system, state, message);
    saltus_scene scene;
    saltus_status status = saltus_sweep_scene_at(sweep, point, &scene, message);
    memcpy(state, scene.initial, (size_t)sweep->dimension * sizeof *state);
    return status;
}

/* Each face that the state has passed takes back what lies beyond it, along its normal. */
void saltus_sweep_admit(const saltus_system *system, double *state) {
    enum { rounds = 8 };
    int dof = saltus_system_dof(system);
    for (int round = 0; round < rounds; round++)
        for (int f = 0; f < saltus_system_face_count(system); f++) {
            saltus_face face = saltus_system_face(system, f);
            const double *normal = saltus_system_stop_normal(system, face.stop);
            double gap = saltus_system_gap(system, f, state), square = 0;
            for (int i = 0; i < dof; i++)
                square += normal[i] * normal[i];
            for (int i = 0; i < dof && gap > 0; i++)
                state[i] -= face.side * gap / square * normal[i];
        }
}
