/* Every built-in scene with a stop, through twenty events from its start, against a simulator that shares
 * nothing with the library: the equations written again, in long double, integrated by extrapolation of the
 * midpoint rule, impacts one by one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

typedef long double real;

enum { dof_max = 8, state_max = 2 * dof_max + 1, events_max = 20, names_max = 12 };

static const real pi = 3.14159265358979323846264338327950288L;

/* A scene for the simulator. */
typedef struct plant plant;
struct plant {
    int dof, extra;
    real p[names_max]; /* parameters in the order of the equations' names */
    real omega;        /* 0: no forcing */
    real mass[dof_max];
    real lambda2[dof_max], g[dof_max][dof_max], b[dof_max][dof_max]; /* of the pipe */
    void (*field)(const plant *self, real t, const real *x, real *rate);
    int faces;
    struct {
        real normal[dof_max], d, r; /* open while normal . q < d */
    } face[SALTUS_FACES_MAX];
    int held;  /* the face of a lasting contact; -1 */
    real step; /* short against the fastest vibration */
};

/* Sine and cosine of the forcing's phase, from those of half of it: small arguments are fast. */
typedef struct circle {
    real sine, cosine;
} circle;

static circle swing(const plant *s, real t) {
    const real turns = s->omega * t / (2 * pi), half = pi * (turns - rintl(turns));
    const real sine = sinl(half), cosine = cosl(half);
    return (circle){2 * sine * cosine, cosine * cosine - sine * sine};
}

/* The pipe (model.md, section 1): alpha, beta, kappa, u0, sigma. */
static void pipe_field(const plant *s, real t, const real *x, real *rate) {
    const real *q = x, *v = x + s->dof, root = sqrtl(s->p[1]);
    const circle pulse = swing(s, t);
    real u = s->p[3] * (1 + s->p[4] * pulse.sine), du = s->p[3] * s->p[4] * s->omega * pulse.cosine;
    real stretch = 0, power = 0;
    for (int k = 0; k < s->dof; k++) {
        stretch += s->lambda2[k] * q[k] * q[k] / 2;
        power += s->lambda2[k] * q[k] * v[k] / 2;
    }
    for (int k = 0; k < s->dof; k++) {
        const real l2 = s->lambda2[k];
        real a = -s->p[0] * l2 * l2 * v[k] - (l2 - u * u) * l2 * q[k] -
                 s->p[2] * l2 * q[k] * (stretch + 2 * s->p[0] * power);
        for (int l = 0; l < s->dof; l++)
            a -= root * (2 * u * s->g[k][l] * v[l] + du * s->b[k][l] * q[l]);
        rate[k] = v[k];
        rate[s->dof + k] = a;
    }
}

static void prepare_pipe(plant *s) {
    for (int i = 1; i <= s->dof; i++) {
        s->lambda2[i - 1] = i * i * pi * pi;
        s->b[i - 1][i - 1] = -s->lambda2[i - 1] / 2;
        for (int j = 1; j <= s->dof; j++)
            if ((i + j) % 2 == 1) {
                const real squares = i * i - j * j;
                s->g[i - 1][j - 1] = 4 * i * j / squares;
                s->b[i - 1][j - 1] = -8 * i * j * j * j / (squares * squares);
            }
    }
}

/* One or two masses in a row: k, c, kz, tz, F, F0, k2, c2, F2, F02. */
static void oscillator_field(const plant *s, real t, const real *x, real *rate) {
    const real *p = s->p, *v = x + s->dof, cosine = swing(s, t).cosine;
    real between = s->dof == 2 ? p[6] * (x[0] - x[1]) + p[7] * (v[0] - v[1]) : 0,
         z = s->extra ? x[2 * s->dof] : 0;
    rate[s->dof] = (p[4] * cosine + p[5] - p[0] * x[0] - p[1] * v[0] - between - z) / s->mass[0];
    if (s->dof == 2)
        rate[s->dof + 1] = (p[8] * cosine + p[9] + between) / s->mass[1];
    for (int k = 0; k < s->dof; k++)
        rate[k] = v[k];
    if (s->extra)
        rate[2 * s->dof] = p[2] * v[0] - z / p[3];
}

/* c, k, k3, F */
static void duffing_field(const plant *s, real t, const real *x, real *rate) {
    rate[0] = x[1];
    rate[1] = -s->p[0] * x[1] - s->p[1] * x[0] - s->p[2] * x[0] * x[0] * x[0] + s->p[3] * swing(s, t).cosine;
}

/* c, F0, A */
static void gear_field(const plant *s, real t, const real *x, real *rate) {
    rate[0] = x[1];
    rate[1] = s->p[2] * swing(s, t).sine - s->p[1] - s->p[0] * x[1];
}

/* zeta, F */
static void damper_field(const plant *s, real t, const real *x, real *rate) {
    rate[0] = x[2];
    rate[1] = x[3];
    rate[2] = s->p[1] * swing(s, t).cosine - x[0] - 2 * s->p[0] * x[2];
    rate[3] = 0;
}

/* k, c, F */
static void chain_field(const plant *s, real t, const real *x, real *rate) {
    const int n = s->dof;
    for (int i = 0; i < n; i++) {
        real left = i > 0 ? s->p[0] * x[i - 1] + s->p[1] * x[n + i - 1] : 0,
             own = s->p[0] * x[i] + s->p[1] * x[n + i];
        real right = i < n - 1 ? s->p[0] * x[i + 1] + s->p[1] * x[n + i + 1] : own;
        rate[i] = x[n + i];
        rate[n + i] = left - own + right - own + (i == 0 ? s->p[2] * swing(s, t).cosine : 0);
    }
}

/* kappa, delta, beta, q */
static void valve_field(const plant *s, real t, const real *x, real *rate) {
    (void)t;
    rate[0] = x[1];
    rate[1] = x[2] - s->p[1] - x[0] - s->p[0] * x[1];
    rate[2] = s->p[2] * (s->p[3] - x[0] * sqrtl(x[2]));
}

static const struct equations {
    const char *name; /* name of the model, or of a scene from text */
    void (*field)(const plant *, real, const real *, real *);
    const char *parameters[names_max];
    int dof; /* 0: the parameter N */
    real normal[2];
    const char *mass[2];
} known[] = {
    {.name = "pipe", .field = pipe_field, .parameters = {"alpha", "beta", "kappa", "u0", "sigma"}},
    {.name = "oscillator",
     .field = oscillator_field,
     .parameters = {"k", "c", "kz", "tz", "F", "F0", "k2", "c2", "F2", "F02"},
     .mass = {"m", "m2"}},
    {.name = "duffing", .field = duffing_field, .parameters = {"c", "k", "k3", "F"}, .dof = 1, .normal = {1}},
    {.name = "gear-rattle", .field = gear_field, .parameters = {"c", "F0", "A"}, .dof = 1, .normal = {1}},
    {.name = "impact-damper",
     .field = damper_field,
     .parameters = {"zeta", "F"},
     .dof = 2,
     .normal = {-1, 1},
     .mass = {NULL, "mu"}},
    {.name = "chain", .field = chain_field, .parameters = {"k", "c", "F"}},
    {.name = "relief-valve",
     .field = valve_field,
     .parameters = {"kappa", "delta", "beta", "q"},
     .dof = 1,
     .normal = {1}},
};

static const struct equations *equations_of(const char *scene, const saltus_spec *spec) {
    const char *names[] = {scene, saltus_model_name(spec->model)};
    for (int n = 0; n < 2; n++)
        for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
            if (strcmp(known[k].name, names[n]) == 0)
                return &known[k];
    fail_msg("%s: the simulator has no equations for it", scene);
    return NULL;
}

static real normal_of(const struct equations *e, const saltus_stop *stop, int dof, int i) {
    if (e->field == pipe_field)
        return sinl((i + 1) * pi * (real)stop->xi);
    if (e->field == oscillator_field)
        return stop->weight[i];
    return e->field == chain_field ? i == dof - 1 : e->normal[i];
}

static plant plant_of(const char *scene, const saltus_spec *spec, int dimension) {
    const struct equations *e = equations_of(scene, spec);
    plant s = {.field = e->field, .dof = e->dof ? e->dof : (int)saltus_spec_get(spec, "N"), .held = -1};
    s.extra = dimension - 2 * s.dof;
    assert_true(s.dof <= dof_max && s.extra >= 0 && s.extra <= 1);
    for (int k = 0; k < names_max && e->parameters[k]; k++)
        s.p[k] = saltus_spec_get(spec, e->parameters[k]);
    s.omega = e->field == valve_field ? 0 : saltus_spec_get(spec, "omega");
    for (int i = 0; i < s.dof; i++)
        s.mass[i] = i < 2 && e->mass[i] ? saltus_spec_get(spec, e->mass[i]) : 1;
    prepare_pipe(&s);
    for (int k = 0; k < spec->stop_count; k++)
        for (int side = 1; side >= -1; side -= 2) {
            const saltus_stop *stop = &spec->stops[k];
            if (!(stop->sides & (side > 0 ? SALTUS_UPPER : SALTUS_LOWER)))
                continue;
            for (int i = 0; i < s.dof; i++)
                s.face[s.faces].normal[i] = side * normal_of(e, stop, s.dof, i);
            s.face[s.faces].d = stop->d;
            s.face[s.faces++].r = stop->r;
        }
    return s;
}

static real along(const plant *s, int face, const real *vector) {
    real sum = 0;
    for (int i = 0; i < s->dof; i++)
        sum += s->face[face].normal[i] * vector[i];
    return sum;
}

/* Subtract `amount` of the normal direction from a vector of velocities or accelerations. */
static void push(const plant *s, int face, real amount, real *vector) {
    real compliance = 0;
    for (int i = 0; i < s->dof; i++)
        compliance += s->face[face].normal[i] * s->face[face].normal[i] / s->mass[i];
    for (int i = 0; i < s->dof; i++)
        vector[i] -= amount * s->face[face].normal[i] / s->mass[i] / compliance;
}

/* The field with the lasting contact, and the force that it requires. */
static real field_at(const plant *s, real t, const real *x, real *rate) {
    s->field(s, t, x, rate);
    if (s->held < 0)
        return 0;
    real force = along(s, s->held, rate + s->dof);
    push(s, s->held, force, rate + s->dof);
    return force;
}

/* One step by Gragg's method: the midpoint rule with 2, 4, 6, ... parts, extrapolated to none. */
static void step(const plant *s, real t, const real *from, real h, real *to) {
    enum { columns = 8 };
    const int n = 2 * s->dof + s->extra;
    real table[columns][state_max], rate[state_max];
    for (int k = 0; k < columns; k++) {
        const int parts = 2 * (k + 1);
        real before[state_max], now[state_max], next[state_max];
        field_at(s, t, from, rate);
        for (int i = 0; i < n; i++) {
            before[i] = from[i];
            now[i] = from[i] + h / parts * rate[i];
        }
        for (int m = 1; m < parts; m++) {
            field_at(s, t + h * m / parts, now, rate);
            for (int i = 0; i < n; i++) {
                next[i] = before[i] + 2 * h / parts * rate[i];
                before[i] = now[i];
                now[i] = next[i];
            }
        }
        memcpy(table[k], now, sizeof now);
        for (int j = k - 1; j >= 0; j--) {
            const real ratio = (real)parts / (2 * (j + 1));
            for (int i = 0; i < n; i++)
                table[j][i] = table[j + 1][i] + (table[j + 1][i] - table[j][i]) / (ratio * ratio - 1);
        }
    }
    memcpy(to, table[0], (size_t)n * sizeof *to);
}

/* The quantity sought on a step: the gap of a face, its rate, or the force of the lasting contact. */
typedef enum quantity { gap, gap_rate, force } quantity;

static real value(const plant *s, quantity what, int face, real t, const real *x) {
    real rate[state_max];
    if (what == gap)
        return along(s, face, x) - s->face[face].d;
    return what == gap_rate ? along(s, face, x + s->dof) : -field_at(s, t, x, rate);
}

/* Where `what` turns from negative at `low` to positive at `high` on the step from x; at `low` it may be
 * positive by rounding. Regula falsi with the Illinois modification. */
static real root(const plant *s, quantity what, int face, real t, const real *x, real low, real high) {
    real there[state_max], below, above;
    step(s, t, x, low, there);
    below = fminl(value(s, what, face, t + low, there), 0);
    step(s, t, x, high, there);
    above = value(s, what, face, t + high, there);
    for (int k = 0, side = 0; k < 100 && above > 0 && high - low > 1e-19L * high; k++) {
        const bool halve = k % 3 == 2 || below == 0;
        const real at = halve ? low + (high - low) / 2 : low - below * (high - low) / (above - below);
        step(s, t, x, at, there);
        const real now = value(s, what, face, t + at, there);
        if (now > 0) {
            high = at;
            above = now;
            below *= side == 1 ? 0.5L : 1;
            side = 1;
        } else {
            low = at;
            below = now;
            above *= side == -1 ? 0.5L : 1;
            side = -1;
            if (now == 0)
                return at;
        }
    }
    return high;
}

/* The first time on a step at which a face is reached, or the step's length. A flight that begins on the face
 * leaves it first. */
static real meeting(const plant *s, int face, real t, const real *x, const real *end, real h) {
    real there[state_max], low = 0;
    const real size = fabsl(s->face[face].d) + fabsl(value(s, gap, face, t, x) + s->face[face].d) + 1e-3L;
    if (value(s, gap, face, t, x) > -1e-15L * size) {
        if (value(s, gap_rate, face, t + h, end) <= 0)
            return h;
        low = root(s, gap_rate, face, t, x, 0, h);
    }
    if (value(s, gap, face, t + h, end) > 0)
        return root(s, gap, face, t, x, low, h);
    step(s, t, x, low, there);
    if (value(s, gap_rate, face, t + low, there) <= 0 || value(s, gap_rate, face, t + h, end) >= 0)
        return h;
    /* A maximum on the way may be a contact. */
    real rising = low, falling = h;
    for (int k = 0; k < 80; k++) {
        const real middle = rising + (falling - rising) / 2;
        step(s, t, x, middle, there);
        *(value(s, gap_rate, face, t + middle, there) > 0 ? &rising : &falling) = middle;
    }
    step(s, t, x, rising, there);
    return value(s, gap, face, t + rising, there) > 0 ? root(s, gap, face, t, x, low, rising) : h;
}

typedef struct met {
    saltus_event_kind kind;
    int face;
    real time, speed;
    real state[state_max]; /* after it */
} met;

/* From an impact with the outgoing speed v the rest of complete chatter takes 2 v / (a (1 - r)), to order
 * v^2. */
static bool comes_to_rest(const plant *s, int face, real t, real *x, real *rest) {
    real rate[state_max];
    field_at(s, t, x, rate);
    const real a = along(s, face, rate + s->dof), v = -along(s, face, x + s->dof);
    *rest = 2 * v / (a * (1 - s->face[face].r));
    return a > 0 && v < 1e-10L * sqrtl(a * 1e-3L) && s->face[face].r < 1;
}

/* One step, or up to an event; returns whether there was one. */
static bool go(plant *s, real *t, real *x, real h, met *event) {
    real end[state_max], rest;
    const int n = 2 * s->dof + s->extra;
    step(s, *t, x, h, end);
    if (s->held >= 0) {
        bool ends = value(s, force, s->held, *t + h, end) > 0;
        h = ends ? root(s, force, s->held, *t, x, 0, h) : h;
        step(s, *t, x, h, x);
        *t += h;
        *event = (met){.kind = SALTUS_RELEASE, .face = s->held, .time = *t};
        s->held = ends ? -1 : s->held;
        memcpy(event->state, x, (size_t)n * sizeof *x);
        return ends;
    }
    int face = -1;
    for (int k = 0; k < s->faces; k++) {
        const real first = meeting(s, k, *t, x, end, h);
        if (first < h) {
            h = first;
            face = k;
        }
    }
    step(s, *t, x, h, x);
    *t += h;
    if (face < 0)
        return false;
    const real speed = along(s, face, x + s->dof);
    push(s, face, (1 + s->face[face].r) * speed, x + s->dof);
    *event = (met){.kind = SALTUS_IMPACT, .face = face, .time = *t, .speed = speed};
    if (comes_to_rest(s, face, *t, x, &rest)) {
        push(s, face, along(s, face, x + s->dof), x + s->dof);
        s->held = face;
        step(s, *t, x, rest, x);
        *t += rest;
        *event = (met){.kind = SALTUS_STICK, .face = face, .time = *t};
    }
    memcpy(event->state, x, (size_t)n * sizeof *x);
    return true;
}

/* A simulation: its state and last event. */
typedef struct run {
    plant s;
    real unit, t, x[state_max];
    met last;
} run;

/* Run to the next event. A chatter is reported by its end, not by its last impacts. */
static void next_event(run *r, saltus_event_kind wanted) {
    int passed = 0;
    do {
        r->last.face = -1;
        while (!go(&r->s, &r->t, r->x, r->s.step, &r->last) && r->t < 400 * r->unit)
            ;
        assert_true(passed++ < 4000 && r->last.face >= 0);
    } while (r->last.kind == SALTUS_IMPACT && wanted == SALTUS_STICK);
}

/* The largest difference of two states, in units of the state's scale and size. */
static real distance(const double *scale, int n, const real *a, const real *b) {
    real largest = 0;
    for (int i = 0; i < n; i++)
        largest = fmaxl(largest, fabsl(a[i] - b[i]) / (scale[i] + fabsl(b[i])));
    return largest;
}

/* The same for a motion that meets no stop: after five periods. */
static void compare_flights(const char *name, const saltus_system *system, const double *start, run *own) {
    const int n = saltus_system_dimension(system);
    saltus_flow_options options = saltus_flow_defaults();
    double state[state_max];
    real there[state_max];
    options.rtol = 1e-14;
    saltus_flow *flow = open_flow(system, &options, 0, start);
    advance(flow, 5, 0);
    saltus_flow_state(flow, 0, state);
    for (int i = 0; i < n; i++)
        there[i] = state[i];
    for (real end = 5 * own->unit; own->t < end;)
        assert_false(go(&own->s, &own->t, own->x, fminl(own->s.step, end - own->t), &own->last));
    if (!(distance(saltus_system_scale(system), n, there, own->x) <= 1e-10L))
        fail_msg("%s: without contact it is off by %.3Lg", name,
                 distance(saltus_system_scale(system), n, there, own->x));
    saltus_flow_free(flow);
}

/* A scene's flow and the simulator agree to 1e-10. A second simulation, begun slightly off, shows how fast
 * differences grow; when they have grown a thousand times both take the flow's state and time, and one flight
 * may add 1e-13 times its own growth. */
static void compare(const char *name, const saltus_spec *spec, const saltus_system *system,
                    const double *start) {
    const real off = 1e-9L;
    const int n = saltus_system_dimension(system), count = getenv("SALTUS_SANITIZED") ? 6 : events_max;
    const double *scale = saltus_system_scale(system), period = saltus_system_period(system);
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = 1e-14;
    saltus_flow *flow = open_flow(system, &options, 0, start);
    run own = {.s = plant_of(name, spec, n)}, twin;
    own.unit = own.s.omega > 0 ? 2 * pi / own.s.omega : 1;
    own.s.step = own.unit / 64;
    if (own.s.field == pipe_field)
        own.s.step = fminl(own.s.step, 0.4L / (own.s.dof * own.s.dof * pi * pi));
    check_near(period, (double)own.unit, 1e-15 * period);
    double state[state_max];
    memcpy(state, start, (size_t)n * sizeof *state);
    bool take_over = true;
    for (int k = 0; k < count; k++) {
        if (take_over) {
            for (int i = 0; i < n; i++)
                own.x[i] = state[i];
            twin = own;
            for (int i = 0; i < n && own.s.held < 0; i++)
                twin.x[i] += i < own.s.dof ? -off * scale[i] : 0;
        }
        saltus_event event = advance(flow, 400, SALTUS_WATCH_CONTACT);
        if (event.kind == SALTUS_REACHED) {
            assert_int_equal(k, 0);
            compare_flights(name, system, start, &own);
            break;
        }
        next_event(&own, event.kind);
        next_event(&twin, event.kind);
        const real time = (real)event.time.cycle + event.time.phase;
        const real growth = distance(scale, n, twin.last.state, own.last.state) / off;
        const real allowed = fmaxl(1e-10L, 1e-13L * growth);
        if (own.last.kind != event.kind || own.last.face != event.face ||
            fabsl(time * own.unit - own.last.time) > allowed * own.unit)
            fail_msg("%s: event %d is %d on %d at %.14Lg T, not %d on %d at %.14Lg T", name, k, event.kind,
                     event.face, time, own.last.kind, own.last.face, own.last.time / own.unit);
        real there[state_max];
        saltus_flow_state(flow, 0, state);
        for (int i = 0; i < n; i++)
            there[i] = state[i];
        if (!(distance(scale, n, there, own.last.state) <= allowed))
            fail_msg("%s: after event %d the state is off by %.3Lg", name, k,
                     distance(scale, n, there, own.last.state));
        take_over = twin.last.kind != own.last.kind || growth > 1e3L;
        own.t = take_over ? time * own.unit : own.t;
    }
    saltus_flow_free(flow);
}

static void scenes_follow_their_equations(void **unused) {
    (void)unused;
    int compared = 0;
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        const char *name = saltus_scene_builtin_name(k);
        saltus_scene scene;
        saltus_message message = {.text = ""};
        double start[SALTUS_STATE_MAX];
        check_ok(saltus_scene_load(name, &scene, &message), &message);
        saltus_system *system = build(&scene.spec);
        check_ok(saltus_scene_state(&scene, system, start, &message), &message);
        if (scene.spec.stop_count > 0) {
            compare(name, &scene.spec, system, start);
            compared++;
        }
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
    assert_true(compared > 20);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(scenes_follow_their_equations)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
