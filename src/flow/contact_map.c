/* Contact maps: the effect of impulses or contact forces at a set of faces on velocities and accelerations.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include "base/dense.h"

#include <math.h>
#include <string.h>

double saltus_face_normal(const saltus_system *system, int face, const double *vector) {
    saltus_face f = system->faces[face];
    return f.side * saltus_dot(system->stop_normal[f.stop], vector, system->dof);
}

/* Rows of G^-1 R N, with G = N B and R the diagonal of `factor`. */
static void fill_rows(const saltus_system *system, const saltus_contact_map *map, const double *factor,
                      double *rows) {
    const int n = system->dof, m = map->count;
    for (int k = 0; k < m; k++)
        for (int j = 0; j < m; j++) {
            saltus_face f = system->faces[map->face[j]];
            double part = map->inverse[k * m + j] * f.side * factor[j];
            for (int i = 0; i < n; i++)
                rows[k * n + i] = (j ? rows[k * n + i] : 0) + part * system->stop_normal[f.stop][i];
        }
}

bool saltus_contact_map_build(const saltus_system *system, unsigned faces, unsigned elastic,
                              const double *velocity, saltus_contact_map *map) {
    double factor[SALTUS_FACES_MAX], slope[SALTUS_FACES_MAX];
    double gram[SALTUS_FACES_MAX * SALTUS_FACES_MAX];
    int n = system->dof, m = 0;
    for (int f = 0; f < system->face_count; f++)
        if (faces >> f & 1)
            map->face[m++] = f;
    map->count = 0;
    map->faces = 0;
    if (m == 0 || m > n)
        return m == 0;
    for (int k = 0; k < m; k++) {
        saltus_face f = system->faces[map->face[k]];
        for (int i = 0; i < n; i++)
            map->push[k * n + i] = f.side * system->stop_impulse[f.stop][i];
    }
    for (int k = 0; k < m; k++)
        for (int j = 0; j < m; j++)
            gram[k * m + j] = saltus_face_normal(system, map->face[k], map->push + j * n);
    if (!saltus_dense_inverse(gram, m, map->inverse))
        return false;
    map->count = m;
    map->faces = faces;
    /* pull_k = sum_j (N B)^-1_kj (1 + r_j) n_j, with r_j = 0 for faces that do not rebound. */
    for (int k = 0; k < m; k++) {
        const int face = map->face[k];
        saltus_rebound rebound = {0, 0};
        map->speed[k] = system->by_speed & elastic ? saltus_face_normal(system, face, velocity) : 0;
        if (elastic >> face & 1)
            rebound = saltus_system_rebound(system, face, map->speed[k] > 0 ? map->speed[k] : 0);
        map->r[k] = rebound.r;
        factor[k] = 1 + rebound.r;
        slope[k] = 1 + rebound.slope;
    }
    fill_rows(system, map, factor, map->pull);
    map->change = system->by_speed & elastic ? map->change_rows : map->pull;
    if (map->change != map->pull)
        fill_rows(system, map, slope, map->change);
    return true;
}

/* With G = N B and R the diagonal of 1 + r: pull = G^-1 R N, so d pull = G^-1 (d(R N) - dG pull). */
void saltus_contact_map_vary(const saltus_system *system, const saltus_contact_map *map, unsigned elastic,
                             const saltus_variation *variation, double *push, double *pull) {
    double change[SALTUS_FACES_MAX][SALTUS_MODES_MAX];
    int n = system->dof, m = map->count;
    for (int k = 0; k < m; k++)
        for (int i = 0; i < n; i++) {
            saltus_face f = system->faces[map->face[k]];
            push[k * n + i] = f.side * variation->impulse[f.stop][i];
        }
    for (int k = 0; k < m; k++) {
        saltus_face f = system->faces[map->face[k]];
        bool rebounds = elastic >> map->face[k] & 1;
        double varied =
            rebounds ? saltus_variation_restitution(variation, system, map->face[k], map->speed[k]) : 0;
        double whole = f.side * (1 + map->r[k]), part = f.side * varied;
        for (int i = 0; i < n; i++)
            change[k][i] = whole * variation->normal[f.stop][i] + part * system->stop_normal[f.stop][i];
        for (int j = 0; j < m; j++) {
            double gram = f.side * saltus_dot(variation->normal[f.stop], map->push + j * n, n) +
                          saltus_face_normal(system, map->face[k], push + j * n);
            for (int i = 0; i < n; i++)
                change[k][i] -= gram * map->pull[j * n + i];
        }
    }
    memset(pull, 0, (size_t)(m * n) * sizeof *pull);
    for (int k = 0; k < m; k++)
        for (int j = 0; j < m; j++)
            for (int i = 0; i < n; i++)
                pull[k * n + i] = fma(map->inverse[k * m + j], change[j][i], pull[k * n + i]);
}

void saltus_contact_map_apply(const saltus_contact_map *map, int dof, double *velocity) {
    double size[SALTUS_FACES_MAX];
    for (int k = 0; k < map->count; k++)
        size[k] = saltus_dot(map->pull + k * dof, velocity, dof);
    for (int k = 0; k < map->count; k++)
        for (int i = 0; i < dof; i++)
            velocity[i] -= size[k] * map->push[k * dof + i];
}

void saltus_contact_map_carry(const saltus_contact_map *map, int dof, double *change) {
    saltus_contact_map own = *map;
    own.pull = map->change;
    saltus_contact_map_apply(&own, dof, change);
}

void saltus_contact_map_share_out(const saltus_contact_map *map, int dof, const double *excess,
                                  double *vector) {
    for (int k = 0; k < map->count; k++) {
        double share = saltus_dot(map->inverse + k * map->count, excess, map->count);
        for (int i = 0; i < dof; i++)
            vector[i] = fma(-share, map->push[k * dof + i], vector[i]);
    }
}

void saltus_contact_map_settle(const saltus_system *system, const saltus_contact_map *map, double *state) {
    double gap[SALTUS_FACES_MAX];
    for (int k = 0; k < map->count; k++)
        gap[k] = saltus_system_gap(system, map->face[k], state);
    saltus_contact_map_share_out(map, system->dof, gap, state);
    saltus_contact_map_apply(map, system->dof, state + system->dof);
}

void saltus_contact_map_publish(const saltus_contact_map *map, saltus_work *work, int lane, int slots) {
    int n = work->dof;
    for (int k = 0; k < slots; k++)
        for (int i = 0; i < n; i++) {
            size_t place = saltus_work_place(work, 0, k, i, lane);
            work->hold.push[place] = k < map->count ? map->push[k * n + i] : 0;
            work->hold.pull[place] = k < map->count ? map->pull[k * n + i] : 0;
        }
}
