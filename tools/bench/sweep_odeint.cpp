/* The integrators of Boost.Odeint on the pipe against a stop.
 *
 * The state is an array of fixed size, for which the library unrolls its sums, and the derivative at a step's
 * end is handed to the next step. Steps, the search for events and the impact law are those of the other
 * libraries' integrators (rival_step.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_rivals.h"

#include "rival_step.h"

#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <stdexcept>
#include <utility>

namespace {

namespace odeint = boost::numeric::odeint;

using vector = std::array<double, 2 * modes_of_paper>;

struct rate {
    pipe_field *field;
    void operator()(const vector &state, vector &derivative, double tau) const {
        pipe_rate(field, tau, state.data(), derivative.data());
    }
};

/* What both methods share: the step's two ends, of which `now` is the index of the later one. */
struct trajectory {
    pipe_field *field;
    vector state[2], derivative[2], trial, trial_rate;
    int now = 0;
    double start = 0, tau = 0;
};

/* Dormand and Prince's method of order five: the derivative at a step's end comes with the step, the state
 * within it from the dense output. */
class dopri5 {
    using stepper = odeint::runge_kutta_dopri5<vector>;
    using controlled = odeint::result_of::make_controlled<stepper>::type;
    controlled control;

  public:
    dopri5(double atol, double rtol) : control(odeint::make_controlled(atol, rtol, stepper())) {}

    bool attempt(trajectory &t, double &length) {
        const int old = 1 - t.now;
        return control.try_step(rate{t.field}, t.state[old], t.derivative[old], t.tau, t.state[t.now],
                                t.derivative[t.now], length) == odeint::success;
    }

    void within(trajectory &t, double length) {
        const int old = 1 - t.now;
        control.stepper().calc_state(t.start + length, t.trial, t.state[old], t.derivative[old], t.start,
                                     t.state[t.now], t.derivative[t.now], t.tau);
    }
};

/* Fehlberg's method of order eight. */
class fehlberg78 {
    using stepper = odeint::runge_kutta_fehlberg78<vector>;
    using controlled = odeint::result_of::make_controlled<stepper>::type;
    controlled control;

  public:
    fehlberg78(double atol, double rtol) : control(odeint::make_controlled(atol, rtol, stepper())) {}

    bool attempt(trajectory &t, double &length) {
        const int old = 1 - t.now;
        if (control.try_step(rate{t.field}, t.state[old], t.derivative[old], t.tau, t.state[t.now], length) !=
            odeint::success)
            return false;
        rate{t.field}(t.state[t.now], t.derivative[t.now], t.tau);
        return true;
    }

    void within(trajectory &t, double length) {
        const int old = 1 - t.now;
        control.stepper().do_step(rate{t.field}, t.state[old], t.derivative[old], t.start, t.trial, length);
    }
};

template <class method> struct run {
    method steps;
    trajectory path;
};

template <class method> bool again(void *stepper, double length) {
    auto *r = static_cast<run<method> *>(stepper);
    r->steps.within(r->path, length);
    rate{r->path.field}(r->path.trial, r->path.trial_rate, r->path.start + length);
    return true;
}

template <class method> rival_step last_step(run<method> &r) {
    trajectory &t = r.path;
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
    step.again = again<method>;
    step.stepper = &r;
    return step;
}

template <class method> int integrate(run<method> &r, double end, rival_result *result) {
    trajectory &t = r.path;
    double usual = first_step(t.field), due = INFINITY;
    rate{t.field}(t.state[t.now], t.derivative[t.now], t.tau);
    while (t.tau < end) {
        const bool shortened = flight_allowance * due < usual;
        const double wanted = shortened ? flight_allowance * due : usual;
        const bool last = t.tau + wanted >= end;
        double length = last ? end - t.tau : wanted;
        t.start = t.tau;
        t.now = 1 - t.now;
        bool whole = last;
        for (int failures = 0; !r.steps.attempt(t, length); failures++, whole = false)
            if (failures == 500)
                return RIVAL_FAILED;
        if (whole)
            t.tau = end;
        usual = (shortened || last) && length < usual ? usual : length;
        result->steps++;
        rival_step step = last_step(r);
        const int event = step_events(&step, &t.tau, &due, result);
        if (event < 0)
            return RIVAL_FAILED;
        if (event > 0)
            rate{t.field}(t.state[t.now], t.derivative[t.now], t.tau);
    }
    return RIVAL_OK;
}

template <class method>
int run_odeint(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
               rival_result *result) {
    pipe_field *field = nullptr;
    if (pipe && pipe->modes != modes_of_paper)
        return RIVAL_BAD_ARGUMENT;
    int status = begin(pipe, state0, periods, rtol, atol, result, &field);
    if (status != RIVAL_OK)
        return status;
    run<method> r{method(atol, rtol), trajectory()};
    r.path.field = field;
    std::copy(result->state, result->state + r.path.state[0].size(), r.path.state[0].begin());
    const double before = processor_time();
    status = integrate(r, end_of_run(field, periods), result);
    result->cpu_seconds = processor_time() - before;
    result->field_evaluations = field->evaluations;
    std::copy(r.path.state[r.path.now].begin(), r.path.state[r.path.now].end(), result->state);
    free(field);
    return status;
}

} // namespace

extern "C" int sweep_odeint_dopri5(const rival_pipe *pipe, const double *state0, int periods, double rtol,
                                   double atol, rival_result *result) {
    return run_odeint<dopri5>(pipe, state0, periods, rtol, atol, result);
}

extern "C" int sweep_odeint_fehlberg78(const rival_pipe *pipe, const double *state0, int periods, double rtol,
                                       double atol, rival_result *result) {
    return run_odeint<fehlberg78>(pipe, state0, periods, rtol, atol, result);
}
