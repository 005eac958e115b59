/* The longest step that the linear part allows.
 *
 * For q' = lambda q a Taylor step h multiplies by T(h lambda), where T is the exponential's Taylor
 * polynomial. Fast modes that have decayed stay small only while |T| <= 1. With longer steps they grow out of
 * rounding until the error estimate notices them and shortens the steps, at random. Along rays from the
 * origin this bound grows nearly linearly with the order, by 0.37 to 0.5 per order, but it depends on the ray
 * (order 12: 4.4 along the imaginary axis, 5.2 along the real axis, 7.2 in between). So it is determined
 * along the rays of the system's own eigenvalues. Undamped modes need not be held down: near the imaginary
 * axis a growth of a hundredth of a percent per step is tolerated, which the error estimate handles.
 *
 * Where these steps are far within the tolerance, longer ones become stable if the last two coefficients,
 * which hardly matter then, are made smaller: T with z^11/11! times 0.81 and z^12/12! times 0.47 reaches 7.9
 * instead of 5.8 on the ray of a pipe's fastest mode. (Stabilised explicit Runge-Kutta methods do the same
 * with their stages; Abdulle, "Explicit stabilized Runge-Kutta methods", 2015.)
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/spectrum.h"

#include "base/dense.h"

#include <math.h>

void saltus_spectrum_reserve(saltus_system *system) {
    const size_t rates = (size_t)(system->dof + system->extra), dimension = (size_t)system->dimension;
    system->linear = system->dimension <= SALTUS_SPECTRUM_MAX
                         ? saltus_arena_doubles(&system->arena, rates * dimension)
                         : NULL;
}

/* Eigenvalues of the uncoupled modes, the roots of s^2 + damping s + stiffness, scaled up to the bound
 * `rate`. */
static void find_of_modes(const saltus_system *system, saltus_eigenvalues *e) {
    double largest = 0;
    for (int i = 0; i < system->dof; i++) {
        const double half = 0.5 * system->damping[i], inside = half * half - system->stiffness[i];
        const double root = sqrt(fabs(inside));
        for (int k = 0; k < 2; k++) {
            e->real[2 * i + k] = (inside > 0 ? (k ? root : -root) : 0) - half;
            e->imaginary[2 * i + k] = inside > 0 ? 0 : k ? root : -root;
            largest = fmax(largest, hypot(e->real[2 * i + k], e->imaginary[2 * i + k]));
        }
    }
    const double scale = largest > 0 ? fmax(1, system->rate / largest) : 0;
    e->count = 2 * system->dof;
    for (int i = 0; i < e->count; i++) {
        e->real[i] *= scale;
        e->imaginary[i] *= scale;
    }
}

void saltus_system_eigenvalues(const saltus_system *system, saltus_eigenvalues *e) {
    const int n = system->dof, dimension = system->dimension;
    double matrix[SALTUS_SPECTRUM_MAX * SALTUS_SPECTRUM_MAX];
    /* The transposed matrix has the same eigenvalues. */
    for (int i = 0; i < dimension && system->linear; i++)
        for (int j = 0; j < dimension; j++)
            matrix[i * dimension + j] = i < n ? j == n + i : system->linear[(i - n) * dimension + j];
    e->count = dimension;
    if (!system->linear || !saltus_dense_eigenvalues(matrix, dimension, e->real, e->imaginary))
        find_of_modes(system, e);
}

/* Points on a ray that are evaluated together: a single one is a chain of dependent operations. */
enum { beside = 8 };

/* |T(z)|^2 for the Taylor polynomial T of the exponential, its last two coefficients damped. */
static void squares_of_polynomial(int order, const saltus_damping *d, const double real[beside],
                                  const double imaginary[beside], double square[beside]) {
    double a[beside], b[beside];
    for (int i = 0; i < beside; i++) {
        a[i] = 1;
        b[i] = 0;
    }
    for (int k = order; k > 0; k--) {
        const double inverse = (k == order ? d->last / d->before : k == order - 1 ? d->before : 1) / k;
        for (int i = 0; i < beside; i++) {
            const double next = 1 + (real[i] * a[i] - imaginary[i] * b[i]) * inverse;
            b[i] = (real[i] * b[i] + imaginary[i] * a[i]) * inverse;
            a[i] = next;
        }
    }
    for (int i = 0; i < beside; i++)
        square[i] = a[i] * a[i] + b[i] * b[i];
}

/* How far along the ray of an eigenvalue, up to `limit`, the polynomial stays within 1. A mode that grows at
 * rest is limited elsewhere and counts as damped, but one step may amplify rounding at most exp(6) times. */
static double reach(int order, const saltus_damping *d, double real, double imaginary, double limit) {
    /* Closer to the origin no admissible order lets anything grow. */
    static const double quiet = 2.5, stride = 1.02, tolerated = 1.0002, lift = 6;
    const double modulus = hypot(real, imaginary);
    limit = real * limit > lift ? lift / real : limit;
    if (!(modulus * limit > quiet))
        return limit;
    for (double next = quiet / modulus; next < limit;) {
        double step[beside], x[beside], y[beside], square[beside];
        for (int i = 0; i < beside; i++, next *= stride) {
            step[i] = next;
            x[i] = -next * fabs(real);
            y[i] = next * imaginary;
        }
        squares_of_polynomial(order, d, x, y, square);
        for (int i = 0; i < beside; i++)
            if (step[i] < limit && square[i] > tolerated)
                return step[i] / stride;
    }
    return limit;
}

/* The least reach of all eigenvalues. */
static double reach_of_all(const saltus_eigenvalues *e, int order, const saltus_damping *d, double limit) {
    for (int i = 0; e && i < e->count; i++)
        if (e->imaginary[i] >= 0)
            limit = reach(order, d, e->real[i], e->imaginary[i], limit);
    return limit;
}

/* Orders above 14 serve tolerances near rounding, which longer steps would amplify: terms of the series are
 * as large as exp(step * rate) and cancel. */
static double rough_limit(const saltus_system *system, int order) {
    const double turns = 6, limit = (order > 14 ? turns : order) / system->rate;
    return system->spec.model->forcing >= 0 ? fmin(limit, turns / system->omega) : limit;
}

static const saltus_damping none = {.before = 1, .last = 1};

double saltus_system_step_limit(const saltus_system *system, const saltus_eigenvalues *e, int order) {
    return reach_of_all(e, order, &none, rough_limit(system, order));
}

/* The factors were found by search: with them |T| stays below 0.95 beyond |z| = 3 as far as possible, on rays
 * at these angles in degrees from the positive real axis; in between they change almost linearly. */
saltus_damping saltus_system_damping(const saltus_system *system, const saltus_eigenvalues *e, int order) {
    enum { least = 8, orders = 4, rays = 6, first_ray = 100, between = 15 };
    static const double factors[orders][rays][2] = {
        {{0.706, 0.626}, {0.740, 0.488}, {0.760, 0.395}, {0.766, 0.340}, {0.761, 0.293}, {0.745, 0.265}},
        {{0.750, 0.640}, {0.770, 0.515}, {0.793, 0.433}, {0.801, 0.376}, {0.799, 0.335}, {0.786, 0.306}},
        {{0.760, 0.650}, {0.796, 0.539}, {0.815, 0.460}, {0.823, 0.405}, {0.823, 0.365}, {0.814, 0.339}},
        {{0.790, 0.690}, {0.810, 0.560}, {0.829, 0.478}, {0.838, 0.424}, {0.840, 0.388}, {0.833, 0.364}}};
    const double plain = saltus_system_step_limit(system, e, order);
    saltus_damping d = {.before = 1, .last = 1, .plain = plain, .limit = plain};
    double fastest = 0, angle = 0;
    for (int i = 0; e && i < e->count; i++) {
        const double modulus = hypot(e->real[i], e->imaginary[i]);
        if (modulus > fastest) {
            fastest = modulus;
            angle = atan2(fabs(e->imaginary[i]), e->real[i]) * 180 / M_PI;
        }
    }
    if (order % 2 || order < least || order >= least + 2 * orders || angle < first_ray)
        return d;
    const double place = fmin((angle - first_ray) / between, rays - 1);
    const int ray = place < rays - 2 ? (int)place : rays - 2;
    const double(*f)[2] = factors[(order - least) / 2] + ray, share = place - ray;
    d.before = f[0][0] + share * (f[1][0] - f[0][0]);
    d.last = f[0][1] + share * (f[1][1] - f[0][1]);
    d.limit = fmax(plain, reach_of_all(e, order, &d, rough_limit(system, order)));
    return d;
}

bool saltus_system_outruns(const saltus_system *system, const saltus_eigenvalues *e, int order,
                           double angle) {
    /* Angular frequency of the fastest lasting motion: modes, less their damping, and twice the forcing's. */
    double ringing = system->forced ? 2 * system->omega : 0;
    for (int i = 0; i < e->count; i++) {
        const double modulus = hypot(e->real[i], e->imaginary[i]);
        ringing = fmax(ringing, modulus + fmin(e->real[i], 0));
    }
    return ringing > 0 && ringing * reach_of_all(e, order, &none, 2 * angle / ringing) <= angle;
}
