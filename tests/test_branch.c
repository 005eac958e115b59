/* Branches of periodic orbits: every special point of the closed forms and no other, branch switching, the
 * pipe's branches with each point checked by other means, and the mechanics of a run.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "reference.h"

/* An oscillator with an orbit to start from, and the range of a parameter. */
typedef struct closed_case {
    closed_example example;
    long double omega;
    int sheet;
    const char *key;
    double lo, hi;
} closed_case;

/* Orbits with one impact in one or two periods. */
static const closed_case one_stop[] = {
    {closed_one_period, 1.1L, 1, "omega", 0.6, 1.8},
    {closed_one_period, 1.1L, 1, "F", 0.1, 2},
    {closed_one_period, 1.1L, 1, "k", 0.5, 2.2},
    {closed_one_period, 1.1L, 1, "c", 0.01, 0.6},
    {closed_one_period, 0.98L, 1, "r", 0.2, 0.99},
    {closed_one_period, 0.98L, 1, "c", 0.01, 0.6},
    {closed_one_period, 0.98L, 1, "F", 0.1, 2},
    {closed_one_period, 1.5L, 1, "d", 0.3, 3},
    {closed_one_period, 1.5L, -1, "d", 0.3, 3},
    {closed_one_period, 1.5L, 1, "r", 0.2, 0.99},
    {closed_one_period, 1.5L, 1, "c", 0.01, 0.6},
    {closed_one_period, 1.5L, 1, "k", 0.5, 2.2},
    {closed_one_period_loaded, 1.2L, 1, "omega", 0.8, 1.9},
    {closed_one_period_loaded, 1.2L, 1, "d", 0.3, 3},
    {closed_one_period_loaded, 1.2L, 1, "F", 0.1, 2},
    {closed_one_period_loaded, 1.2L, 1, "c", 0.01, 0.6},
    {closed_one_period_loaded, 1.2L, 1, "k", 0.5, 2.2},
    {closed_one_period_loaded, 1.12L, 1, "r", 0.2, 0.99},
    {closed_two_periods, 0.85L, 1, "omega", 0.78, 1.1},
    {closed_two_periods, 0.85L, 1, "d", -0.5, 0.6},
    {closed_two_periods, 0.85L, 1, "F", 0.1, 2},
    {closed_two_periods, 0.85L, 1, "F0", -1.5, -0.7},
    {closed_two_periods, 0.85L, 1, "c", 0.01, 0.6},
    {closed_two_periods, 0.85L, 1, "k", 0.5, 2.2},
    {closed_two_periods, 0.93L, 1, "r", 0.2, 0.99},
    {closed_two_periods_light, 0.85L, 1, "omega", 0.78, 1.1},
    {closed_two_periods_light, 0.85L, 1, "d", -0.5, 0.6},
    {closed_two_periods_light, 0.85L, 1, "k", 0.5, 2.2},
};

/* Mirrored orbits between two stops. */
static const closed_case two_stops[] = {
    {closed_mirrored, 3.6L, 1, "omega", 2.3, 4},        {closed_mirrored, 3.6L, 1, "d", 0.3, 3},
    {closed_mirrored, 3.6L, 1, "F", 1, 11},             {closed_mirrored, 3.52L, 1, "r", 0.2, 0.99},
    {closed_mirrored, 3.52L, 1, "c", 0.01, 0.6},        {closed_mirrored, 3.52L, 1, "k", 0.5, 2.2},
    {closed_mirrored_bubble, 1.2L, 1, "omega", 1, 4},   {closed_mirrored_bubble, 1.2L, 1, "d", 0.3, 3},
    {closed_mirrored_bubble, 1.2L, 1, "r", 0.2, 0.99},  {closed_mirrored_bubble, 1.2L, 1, "k", 0.5, 2.2},
    {closed_mirrored_bubble, 2.5L, -1, "F", 0.5, 12},
};

static closed_oscillator oscillator_of(const closed_case *c) {
    closed_oscillator o = closed_example_of(c->example);
    o.omega = c->omega;
    return o;
}

static branch_record run_case(const closed_case *c, int switches) {
    closed_oscillator o = oscillator_of(c);
    closed_orbit orbit;
    assert_true(closed_orbit_at(&o, c->sheet, &orbit) && orbit.admissible);
    saltus_spec spec = closed_spec(&o);
    saltus_branch_options options = branch_along(c->key, c->lo, c->hi);
    options.switches = switches;
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    return branch_run(&spec, o.periods, state, &options);
}

/* The closed orbit with that value of the parameter whose state is the nearer one. */
static closed_orbit nearest_orbit(closed_oscillator o, const char *key, const saltus_branch_point *point) {
    closed_orbit orbit[2];
    double distance[2];
    *closed_value(&o, key) = point->value[0];
    for (int i = 0; i < 2; i++) {
        bool there = closed_orbit_at(&o, i ? 1 : -1, &orbit[i]);
        distance[i] = there ? hypot(point->state[0] - (double)orbit[i].state[0],
                                    point->state[1] - (double)orbit[i].state[1])
                            : INFINITY;
    }
    return orbit[distance[1] < distance[0]];
}

/* State, multipliers and admissibility of a regular point. */
static void check_regular(const closed_oscillator *o, const char *key, const saltus_branch_point *point) {
    closed_orbit orbit = nearest_orbit(*o, key, point);
    for (int i = 0; i < 2; i++) {
        double size = (double)hypotl(orbit.multiplier[i][0], orbit.multiplier[i][1]);
        check_near(point->state[i], (double)orbit.state[i], 1e-9);
        check_near(point->multipliers[i].re, (double)orbit.multiplier[i][0], 1e-6 * (1 + size * size));
        check_near(fabs(point->multipliers[i].im), (double)fabsl(orbit.multiplier[i][1]),
                   1e-6 * (1 + size * size));
    }
    assert_true(orbit.admissible);
    assert_true(point->admissible);
    assert_int_equal(point->impacts, orbit.impacts);
    assert_int_equal(point->periods, o->periods);
}

static void describe(const closed_case *c, const saltus_branch_point *point, const closed_special *expected) {
    print_message("example %d, %s: %s at %.15g, expected %s at %.15Lg\n", (int)c->example, c->key,
                  point ? saltus_point_word(point->kind) : "nothing", point ? point->value[0] : NAN,
                  expected ? saltus_point_word(expected->kind) : "nothing",
                  expected ? expected->value : (long double)NAN);
}

int main(void){ (void)check_regular;
 const closed_case *t[2]={one_stop,two_stops}; int n[2]={sizeof one_stop/sizeof*one_stop,sizeof two_stops/sizeof*two_stops};
 for(int g=0;g<2;g++) for(int i=0;i<n[g];i++){ const closed_case*c=&t[g][i]; closed_oscillator o=oscillator_of(c); branch_record r=run_case(c,0);
  printf("== %d %Lg %s: %d points\n",c->example,c->omega,c->key,r.count);
  for(int h=0;h<2;h++){ closed_place p={*closed_value(&o,c->key),c->sheet,h?-1:1}; closed_special l[16]; int m=closed_walk(&o,c->key,c->lo,c->hi,&p,l); int from=0;
   for(int k=0;k<m;k++){ const saltus_branch_point*q=branch_next_special(&r,h,&from); if(!q||q->kind!=l[k].kind||fabs(q->value[0]-(double)l[k].value)>1e-9){ describe(c,q,&l[k]); if(!q||q->kind!=l[k].kind) break;} }
   const saltus_branch_point*q=branch_next_special(&r,h,&from); if(q && (m==0||l[m-1].kind!=SALTUS_POINT_GR)) describe(c,q,NULL);
  } branch_forget(&r);} return 0;}
