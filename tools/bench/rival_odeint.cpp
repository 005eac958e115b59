/* The integrators of Boost.Odeint on a structure with rigid stops.
 *
 * A state is an array of fixed size, for which the library unrolls its sums, and the derivative at a step's
 * end is handed to the next step; with tangent vectors it is a vector. Steps, the search for events and the
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

/* What both methods share: the step's two ends, of which `now` is the index of the later one. */
template <class vector> struct trajectory {
    scene_field *field;
    vector state[2], derivative[2], trial, trial_rate;
    int now = 0;
    double start = 0, tau = 0;

    explicit trajectory(scene_field *f) : field(f) {
        for (int k = 0; k < 2; k++) {
            make_room(state[k], f->count);
            make_room(derivative[k], f->count);
        }
        make_room(trial, f->count);
        make_room(trial_rate, f->count);
    }
};

/* Dormand and Prince's method of order five: the derivative at a step's end comes with the step, the state
 * within it from the dense output. */
template <class vector> class dopri5 {
    using stepper = odeint::runge_kutta_dopri5<vector>;
    using controlled = typename odeint::result_of::make_controlled<stepper>::type;
    controlled control;

  public:
    explicit dopri5(double tolerance) : control(odeint::make_controlled(tolerance, tolerance, stepper())) {}

    bool attempt(trajectory<vector> &t, double &length) {
        const int old = 1 - t.now;
        return control.try_step(rate<vector>{t.field}, t.state[old], t.derivative[old], t.tau, t.state[t.now],
                                t.derivative[t.now], length) == odeint::success;
    }

    void within(trajectory<vector> &t, double length) {
        const int old = 1 - t.now;
        control.stepper().calc_state(t.start + length, t.trial, t.state[old], t.derivative[old], t.start,
                                     t.state[t.now], t.derivative[t.now], t.tau);
    }
};

/* Fehlberg's method of order eight. */
template <class vector> class fehlberg78 {
    using stepper = odeint::runge_kutta_fehlberg78<vector>;
    using controlled = typename odeint::result_of::make_controlled<stepper>::type;
    controlled control;

  public:
    explicit fehlberg78(double tolerance)
        : control(odeint::make_controlled(tolerance, tolerance, stepper())) {}

    bool attempt(trajectory<vector> &t, double &length) {
        const int old = 1 - t.now;
        if (control.try_step(rate<vector>{t.field}, t.state[old], t.derivative[old], t.tau, t.state[t.now],
                             length) != odeint::success)
            return false;
        rate<vector>{t.field}(t.state[t.now], t.derivative[t.now], t.tau);
        return true;
    }

    void within(trajectory<vector> &t, double length) {
        const int old = 1 - t.now;
        control.stepper().do_step(rate<vector>{t.field}, t.state[old], t.derivative[old], t.start, t.trial,
                                  length);
    }
};

template <template <class> class method, class vector> struct run {
    method<vector> steps;
    trajectory<vector> path;
};

template <template <class> class method, class vector> bool again(void *stepper, double length) {
    auto *r = static_cast<run<method, vector> *>(stepper);
    r->steps.within(r->path, length);
    rate<vector>{r->path.field}(r->path.trial, r->path.trial_rate, r->path.start + length);
    return true;
}

template <template <class> class method, class vector> rival_step last_step(run<method, vector> &r) {
    trajectory<vector> &t = r.path;
    const int old = 1 - t.now;
    rival_step step;
    step.field = t.field;
    step.start = t.start;
    step.length = t.tau - t.start;
    step.begin = t.state[old].data();
    step.begin_rate = t.derivative[old].data();
    step.end = t.state[t.now].data();
    step.end_rate = t.derivative[t.now].data();
    step.trial = t.trial.data();
    step.trial_rate = t.trial_rate.data();
    step.again = again<method, vector>;
    step.stepper = &r;
    return step;
}

/* One step, shorter than wanted where the error asks for it; false when no length is short enough. */
template <template <class> class method, class vector>
bool take_step(run<method, vector> &r, double end, double wanted, bool shortened, double &usual) {
    trajectory<vector> &t = r.path;
    const bool last = t.tau + wanted >= end;
    double length = last ? end - t.tau : wanted;
    t.start = t.tau;
    t.now = 1 - t.now;
    bool whole = last;
    for (int failures = 0; !r.steps.attempt(t, length); failures++, whole = false)
        if (failures == 500)
            return false;
    if (whole)
        t.tau = end;
    usual = (shortened || last) && length < usual ? usual : length;
    return true;
}

template <template <class> class method, class vector>
bool integrate(run<method, vector> &r, double end, rival_result *result) {
    trajectory<vector> &t = r.path;
    double usual = t.field->first_step, due = INFINITY;
    t.tau = 0;
    std::copy(t.field->vector, t.field->vector + t.field->count, t.state[t.now].begin());
    rate<vector>{t.field}(t.state[t.now], t.derivative[t.now], t.tau);
    while (t.tau < end) {
        const bool shortened = flight_allowance * due < usual;
        if (!take_step(r, end, shortened ? flight_allowance * due : usual, shortened, usual))
            return false;
        result->steps++;
        rival_step step = last_step(r);
        const int event = step_events(&step, &t.tau, &due, result);
        if (event < 0)
            return false;
        if (event > 0)
            rate<vector>{t.field}(t.state[t.now], t.derivative[t.now], t.tau);
    }
    return true;
}

template <template <class> class method, class vector>
bool repeat(scene_field *field, int periods, double tolerance, rival_result *result) {
    run<method, vector> r{method<vector>(tolerance), trajectory<vector>(field)};
    const bool done = run_repeatedly(
        field, periods, result,
        [](void *it, double end, rival_result *found) {
            return integrate(*static_cast<run<method, vector> *>(it), end, found);
        },
        &r);
    hand_out(field, r.path.state[r.path.now].data(), result);
    return done;
}

template <template <class> class method>
bool run_odeint(const saltus_spec *spec, const double *state0, int periods, double tolerance,
                rival_result *result) {
    scene_field *field = begin(spec, state0, tolerance, result);
    bool done = false;
    if (!field)
        return false;
    try {
        switch (field->count) {
        case 2:
            done = repeat<method, std::array<double, 2>>(field, periods, tolerance, result);
            break;
        case 10:
            done = repeat<method, std::array<double, 10>>(field, periods, tolerance, result);
            break;
        case 40:
            done = repeat<method, std::array<double, 40>>(field, periods, tolerance, result);
            break;
        default:
            done = repeat<method, std::vector<double>>(field, periods, tolerance, result);
        }
    } catch (const std::bad_alloc &) {
    }
    free(field);
    return done;
}

} // namespace

extern "C" bool rival_odeint_dopri5(const saltus_spec *spec, const double *state0, int periods,
                                    double tolerance, rival_result *result) {
    return run_odeint<dopri5>(spec, state0, periods, tolerance, result);
}

extern "C" bool rival_odeint_fehlberg78(const saltus_spec *spec, const double *state0, int periods,
                                        double tolerance, rival_result *result) {
    return run_odeint<fehlberg78>(spec, state0, periods, tolerance, result);
}

extern "C" const char *rival_odeint_version(void) {
    return BOOST_LIB_VERSION;
}
