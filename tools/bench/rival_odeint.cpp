/* The integrators of Boost.Odeint on a structure with rigid stops.
 *
 * A state is an array of fixed size, for which the library unrolls its sums, and the derivative at a step's
 * end is handed to the next step; with tangent vectors it is a vector. Runs, the search for events and the
 * impact law are those of the other libraries' integrators (rival_step.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "rival_step.h"

#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <boost/version.hpp>
#include <new>
#include <vector>

namespace {

namespace odeint = boost::numeric::odeint;

/* Dormand and Prince's method of order five, Fehlberg's of order eight. */
template <class vector> using dopri5 = odeint::runge_kutta_dopri5<vector>;
template <class vector> using fehlberg78 = odeint::runge_kutta_fehlberg78<vector>;

template <class vector> struct rate {
    scene_field *field;
    void operator()(const vector &state, vector &derivative, double tau) const {
        scene_rate(field, tau, state.data(), derivative.data());
    }
};

template <size_t size> void make_room(std::array<double, size> &, size_t) {}
void make_room(std::vector<double> &v, size_t count) {
    v.resize(count);
}

/* A run; `now` is the index of the last step's later end. */
template <class stepper, class vector> struct run {
    typename odeint::result_of::make_controlled<stepper>::type control;
    rate<vector> field;
    vector state[2], derivative[2], trial, trial_rate;
    int now = 0;
    double tau = 0; /* at the later end */
    rival_step step{};

    run(scene_field *f, double tolerance)
        : control(odeint::make_controlled(tolerance, tolerance, stepper())), field{f} {
        for (vector *v : {&state[0], &state[1], &derivative[0], &derivative[1], &trial, &trial_rate})
            make_room(*v, f->count);
        step.field = f;
        step.trial = trial.data();
        step.trial_rate = trial_rate.data();
        step.end = state[now].data();
    }
};

/* One attempt at a step. The derivative at its end comes with the step of dopri5. */
template <class vector> bool attempt(run<dopri5<vector>, vector> &r, double &tau, double &length) {
    const int old = 1 - r.now;
    return r.control.try_step(r.field, r.state[old], r.derivative[old], tau, r.state[r.now],
                              r.derivative[r.now], length) == odeint::success;
}

template <class vector> bool attempt(run<fehlberg78<vector>, vector> &r, double &tau, double &length) {
    const int old = 1 - r.now;
    if (r.control.try_step(r.field, r.state[old], r.derivative[old], tau, r.state[r.now], length) !=
        odeint::success)
        return false;
    r.field(r.state[r.now], r.derivative[r.now], tau);
    return true;
}

/* The state within the last step: from the dense output of dopri5, or by a shorter step. */
template <class vector> void within(run<dopri5<vector>, vector> &r, double length) {
    const int old = 1 - r.now;
    r.control.stepper().calc_state(r.step.start + length, r.trial, r.state[old], r.derivative[old],
                                   r.step.start, r.state[r.now], r.derivative[r.now], r.tau);
}

template <class vector> void within(run<fehlberg78<vector>, vector> &r, double length) {
    const int old = 1 - r.now;
    r.control.stepper().do_step(r.field, r.state[old], r.derivative[old], r.step.start, r.trial, length);
}

template <class any_run> void restart(void *stepper, double tau) {
    auto &r = *static_cast<any_run *>(stepper);
    r.field(r.state[r.now], r.derivative[r.now], tau);
}

/* One step, shorter than wanted where the error asks for it; false when no length is short enough. Time and
 * length are copies, so that the compiler knows that no write to a state changes them. */
template <class any_run> bool take(void *stepper, double *tau, double end, double *length) {
    auto &r = *static_cast<any_run *>(stepper);
    const bool last = *tau + *length >= end;
    const int old = r.now;
    double time = *tau, tried = last ? end - time : *length;
    bool whole = last;
    r.now = 1 - old;
    for (int failures = 0; !attempt(r, time, tried); failures++, whole = false)
        if (failures == 500)
            return false;
    *tau = r.tau = whole ? end : time;
    *length = last ? std::max(tried, *length) : tried;
    r.step.length = r.tau - r.step.start;
    r.step.begin = r.state[old].data();
    r.step.begin_rate = r.derivative[old].data();
    r.step.end = r.state[r.now].data();
    r.step.end_rate = r.derivative[r.now].data();
    return true;
}

template <class any_run> bool again(void *stepper, double length) {
    auto &r = *static_cast<any_run *>(stepper);
    within(r, length);
    r.field(r.trial, r.trial_rate, r.step.start + length);
    return true;
}

template <template <class> class method, class vector>
bool repeat(scene_field *field, int periods, double tolerance, rival_result *result) {
    using this_run = run<method<vector>, vector>;
    this_run r(field, tolerance);
    r.step.stepper = &r;
    r.step.restart = restart<this_run>;
    r.step.take = take<this_run>;
    r.step.again = again<this_run>;
    return run_repeatedly(field, periods, result, take_steps, &r.step);
}

template <template <class> class method>
bool run_any_size(scene_field *field, int periods, double tolerance, rival_result *result) {
    switch (field->count) {
    case 2:
        return repeat<method, std::array<double, 2>>(field, periods, tolerance, result);
    case 10:
        return repeat<method, std::array<double, 10>>(field, periods, tolerance, result);
    case 40:
        return repeat<method, std::array<double, 40>>(field, periods, tolerance, result);
    default:
        return repeat<method, std::vector<double>>(field, periods, tolerance, result);
    }
}

} // namespace

extern "C" bool rival_odeint(int which, const saltus_spec *spec, const double *state0, int periods,
                             double tolerance, rival_result *result) {
    scene_field *field = begin(spec, state0, tolerance, result);
    bool done = false;
    if (!field)
        return false;
    try {
        done = which == odeint_dopri5 ? run_any_size<dopri5>(field, periods, tolerance, result)
                                      : run_any_size<fehlberg78>(field, periods, tolerance, result);
    } catch (const std::bad_alloc &) {
    }
    free(field);
    return done;
}

extern "C" const char *rival_odeint_version(void) {
    return BOOST_LIB_VERSION;
}
