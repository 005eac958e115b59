/* Networks of curves of special points: whatever the longest step, the same named points, and no curve that
 * ends without one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"

enum { steps = 3 };

typedef struct network {
    const char *scene, *settings;
    saltus_point_kind locus;
    const char *key[2];
    double low[2], high[2];
    int switches;
    double step_max[steps]; /* 0: no more */
    int named;              /* points of codimension two with the first of them; -1: any number */
} network;

static saltus_scene open_scene(const network *n) {
    saltus_message message = {.text = ""};
    saltus_scene scene = {.name = ""};
    char *settings = strdup(n->settings), *rest = settings;
    check_ok(saltus_scene_load(n->scene, &scene, &message), &message);
    for (char *word; (word = strtok_r(rest, " ", &rest));)
        check_ok(saltus_scene_set(&scene, word, &message), &message);
    free(settings);
    return scene;
}

/* The run of the network that begins with an orbit of so many periods through a state; 0: what the scene
 * settles on. */
static saltus_branch *begin(const network *n, const saltus_scene *scene, double step_max, int periods,
                            const double *at) {
    saltus_message message = {.text = ""};
    saltus_branch *branch = NULL;
    saltus_system *system = build(&scene->spec);
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_classify_options how = saltus_classify_defaults();
    how.transient = 2000;
    how.longest = 12;
    saltus_motion motion;
    check_ok(saltus_scene_state(scene, system, state, &message), &message);
    check_ok(saltus_classify(system, state, &how, &motion, &message), &message);
    saltus_branch_options options = branch_along(n->key[0], n->low[0], n->high[0]);
    snprintf(options.key[1], sizeof options.key[1], "%s", n->key[1]);
    options.low[1] = n->low[1];
    options.high[1] = n->high[1];
    options.locus = n->locus;
    options.switches = n->switches;
    options.step_max = step_max;
    options.step = step_max / 4;
    options.points = 400;
    check_ok(saltus_branch_new(&scene->spec, periods ? periods : motion.periods, periods ? at : motion.state,
                               &options, &branch, &message),
             &message);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return branch;
}

static branch_record follow(const network *n, double step_max, int periods, const double *at) {
    saltus_scene scene = open_scene(n);
    saltus_branch *branch = begin(n, &scene, step_max, periods, at);
    branch_record record = branch_collect(branch, branch_points_max);
    saltus_branch_free(branch);
    saltus_scene_clear(&scene);
    return record;
}

static bool is_named(const saltus_branch_point *p) {
    const bool contact = p->kind == SALTUS_POINT_CH || p->kind == SALTUS_POINT_ST;
    return contact || (p->kind >= SALTUS_POINT_CP && p->kind != p->locus);
}

/* The distance of two points in the plane, where the ranges of both parameters are 1. */
static double apart(const network *n, const saltus_branch_point *a, const saltus_branch_point *b) {
    return fmax(fabs(a->value[0] - b->value[0]) / (n->high[0] - n->low[0]),
                fabs(a->value[1] - b->value[1]) / (n->high[1] - n->low[1]));
}

/* Each end of a curve is at the border of the range, where the curve began, or at a named point. */
static void check_ends(const network *n, const branch_record *record) {
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *p = &record->point[k], *last = k ? p - 1 : p;
        const bool border = p->value[0] == n->low[0] || p->value[0] == n->high[0] ||
                            p->value[1] == n->low[1] || p->value[1] == n->high[1];
        if (p->kind == SALTUS_POINT_EP && !border && !strstr(p->reason, "come back") &&
            !strstr(p->reason, "shrink to a touch") &&
            !strstr(p->reason, "shrink to the begin of a contact") &&
            !(is_named(last) && last->branch == p->branch && apart(n, last, p) < 1e-9))
            fail_msg("%s: curve %d of %s ends at %.12g, %.12g: %s", n->settings, p->branch,
                     saltus_point_word(p->locus), p->value[0], p->value[1], p->reason);
    }
}

/* Each named point of one run is one of the other, but for the errors that both state, if these count. */
static void check_in(const network *n, const branch_record *one, const branch_record *other, bool counts) {
    for (int k = 0; k < one->count; k++) {
        const saltus_branch_point *p = &one->point[k];
        double nearest = INFINITY;
        for (int j = 0; j < other->count && is_named(p); j++) {
            const saltus_branch_point *q = &other->point[j];
            const double stated = counts ? (p->accuracy + q->accuracy) / (n->high[0] - n->low[0]) : 0;
            if (q->kind == p->kind && q->locus == p->locus && q->periods == p->periods && isfinite(stated))
                nearest = fmin(nearest, fmax(0, apart(n, p, q) - stated));
        }
        if (is_named(p) && !(nearest < 1e-9))
            fail_msg("%s: %s on curve %d of %s at %.12g, %.12g is %.2g off with other steps", n->settings,
                     saltus_point_word(p->kind), p->branch, saltus_point_word(p->locus), p->value[0],
                     p->value[1], nearest);
    }
}

static void check_network_as(const network *n, int periods, const double *at, bool counts) {
    branch_record record[steps];
    int runs = 0;
    for (; runs < steps && n->step_max[runs] > 0; runs++) {
        record[runs] = follow(n, n->step_max[runs], periods, at);
        check_ends(n, &record[runs]);
        int named = 0;
        for (int k = 0; k < record[runs].count; k++)
            named += is_named(&record[runs].point[k]);
        if (n->named >= 0)
            assert_int_equal(named, n->named);
    }
    for (int k = 1; k < runs; k++) {
        check_in(n, &record[0], &record[k], counts);
        check_in(n, &record[k], &record[0], counts);
    }
    for (int k = 0; k < runs; k++)
        branch_forget(&record[k]);
}

static void check_network(const network *n, int periods, const double *at) {
    check_network_as(n, periods, at, false);
}

static void check_networks(const network *networks, size_t count) {
    for (size_t k = 0; k < count; k++)
        check_network(&networks[k], 0, NULL);
}

/* Folds of orbits between equal stops pass where an impact happens half a period after the base: the state
 * there jumps, and with it that of its mirror image, but the orbits are no nearer to being symmetric. */
static void folds_pass_an_impact_half_a_period_away(void **unused) {
    (void)unused;
    static const network network = {"impact-oscillator",
                                    "d=0.872612 omega=0.748634 r=0.315508 c=0 sides=both",
                                    SALTUS_POINT_LP,
                                    {"omega", "d"},
                                    {0.524044, 0.436306},
                                    {1.04809, 1.30892},
                                    1,
                                    {0.02},
                                    0};
    check_network(&network, 0, NULL);
}

/* On a curve of grazing a branch point shortly after the first point of a step. */
static void branch_points_are_met_from_near_by(void **unused) {
    (void)unused;
    static const network network = {"duffing",
                                    "F=0.39632 omega=0.782592 d=1.51594 c=0.242216 r=0.719469",
                                    SALTUS_POINT_LP,
                                    {"omega", "d"},
                                    {0.547814, 1.06116},
                                    {1.09563, 2.12232},
                                    1,
                                    {0.04, 0.02, 0.01},
                                    5};
    check_network(&network, 0, NULL);
}

/* Between equal stops the curves of an impact's grazing and of its mirror image's are one, which is followed
 * once. */
static void mirror_images_graze_on_one_curve(void **unused) {
    (void)unused;
    static const network network = {"impact-oscillator",
                                    "d=0.997692 omega=0.997535 r=0.873776 c=0 sides=both",
                                    SALTUS_POINT_LP,
                                    {"omega", "d"},
                                    {0.698275, 0.498846},
                                    {1.39655, 1.49654},
                                    2,
                                    {0.04, 0.02, 0.01},
                                    18};
    check_network(&network, 0, NULL);
}

/* Where an orbit that is its own mirror image grazes twice at once, a multiplier of half of it is infinite
 * and passes from one sign to the other: folds and branch points meet grazing, flips do not. */
static void mirror_images_graze_at_once(void **unused) {
    (void)unused;
    static const network network = {"impact-oscillator",
                                    "d=0.696941 omega=1.03281 r=0.94041 c=0 sides=both",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {0.72297, 0.34847},
                                    {1.44594, 1.04541},
                                    1,
                                    {0.04, 0.02, 0.01},
                                    2};
    check_network(&network, 0, NULL);
}

/* Without damping x = 9/16 cos(t/3) - 1/16 cos t touches a stop at d = F = 1/2 with three derivatives zero.
 */
static void impacts_shrink_to_a_flat_touch(void **unused) {
    (void)unused;
    /* Of many impacts the last have no speed but rounding some way before. */
    static const double many[] = {0.4599735443323433, 0.020919702578443253};
    static const network networks[] = {
        {"impact-oscillator",
         "d=0.388822 omega=0.425623 r=0.305968 c=0 sides=both",
         SALTUS_POINT_GR,
         {"omega", "d"},
         {0.297936, 0.194411},
         {0.595872, 0.583233},
         1,
         {0.04, 0.02},
         -1},
        {"impact-oscillator",
         "d=0.4690541203154782 omega=0.31748188790203946 r=0.305968 c=0 sides=both",
         SALTUS_POINT_GR,
         {"omega", "d"},
         {0.31, 0.46},
         {0.35, 0.51},
         0,
         {0.02},
         1}};
    check_network(&networks[0], 0, NULL);
    check_network(&networks[1], 1, many);
    branch_record record = follow(&networks[0], 0.04, 0, NULL);
    int found = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (!strstr(p->reason, "shrink to a touch"))
            continue;
        check_near(p->value[0], 1. / 3, p->accuracy + 1e-14);
        check_near(p->value[1], 0.5, p->accuracy + 1e-14);
        found++;
    }
    /* Of a curve of grazing and one of folds, at least. */
    assert_true(found >= 2);
    branch_forget(&record);
}

/* Grazings that follow one another lead a curve to and fro: where it comes near its first point in the plane
 * with more impacts, it has not come back. */
static void places_come_again_with_more_impacts(void **unused) {
    (void)unused;
    skip_where_slow();
    static const double state[] = {0.45105424242242537, 0.030489239036128123};
    static const network network = {
        "impact-oscillator",
        "d=0.46397919546166966 omega=0.31473854276431323 r=0.305968 c=0 sides=both",
        SALTUS_POINT_GR,
        {"omega", "d"},
        {0.3, 0.2},
        {0.6, 0.58},
        0,
        {0.01},
        -1};
    branch_record record = follow(&network, network.step_max[0], 2, state);
    for (int k = 0; k < record.count; k++)
        assert_null(strstr(record.point[k].reason, "come back"));
    branch_forget(&record);
}

/* Where folds of orbits of twice the period end at a grazing that is not felt, their equations fail so near
 * that no place before tells it. */
static void folds_fade_from_near_by(void **unused) {
    (void)unused;
    skip_where_slow();
    static const double state[] = {0.6763387842638972, -0.22673528490867753};
    static const network network = {"impact-oscillator",
                                    "d=0.777563722133114 omega=0.6654696533924318 r=0.876673 c=0 sides=both",
                                    SALTUS_POINT_LP,
                                    {"omega", "d"},
                                    {0.6, 0.6},
                                    {0.86, 1.6},
                                    0,
                                    {0.02, 0.04},
                                    2};
    check_network(&network, 4, state);
}

/* Where folding orbits become their own mirror images is told by the branch points of such orbits. */
static void folds_end_at_symmetric_orbits(void **unused) {
    (void)unused;
    static const network network = {"impact-oscillator",
                                    "d=0.96835 omega=1.24957 r=0.730592 c=0 sides=both",
                                    SALTUS_POINT_LP,
                                    {"omega", "d"},
                                    {0.874698, 0.484175},
                                    {1.7494, 1.45253},
                                    1,
                                    {0.04, 0.02, 0.01},
                                    1};
    check_network(&network, 0, NULL);
}

/* Folds of two masses end where the flip of orbits of half the period changes its criticality; near there
 * those flips solve the equations of folds but for the fourth power of the distance. */
static void folds_end_at_flips(void **unused) {
    (void)unused;
    static const network network = {"two-mass",
                                    "d=0.82 omega=0.7252 r=0.922373",
                                    SALTUS_POINT_LP,
                                    {"omega", "d"},
                                    {0.7215, 0.7},
                                    {0.735, 1},
                                    1,
                                    {0.2, 0.02, 0.01},
                                    1};
    check_network(&network, 0, NULL);
}

/* Between equal stops an orbit whose impacts lose their speed becomes symmetric and touches the other stop at
 * once: which of the two is told first must not matter, nor must rounding, to which functions fall there. */
static void impacts_die_and_are_born_at_once(void **unused) {
    (void)unused;
    static const network network = {"impact-oscillator",
                                    "d=1.38716 omega=0.705162 r=0.46788 c=0.156811 sides=both",
                                    SALTUS_POINT_PD,
                                    {"omega", "d"},
                                    {0.493614, 0.693581},
                                    {0.987227, 2.08074},
                                    2,
                                    {0.04, 0.02, 0.01},
                                    8};
    check_network(&network, 0, NULL);
}

/* Without damping the multipliers of an orbit without impacts are on the unit circle all along a curve. */
static void undamped_pairs_are_on_the_circle(void **unused) {
    (void)unused;
    static const network network = {"impact-oscillator",
                                    "d=0.94388 omega=1.45559 r=0.418359 c=0 sides=both",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {1.01891, 0.47194},
                                    {2.03783, 1.41582},
                                    2,
                                    {0.04, 0.02, 0.01},
                                    0};
    check_network(&network, 0, NULL);
}

/* Undamped orbits without impacts have any amplitude at omega = 1/3, where impacts die, but no curve of
 * grazing begins, as all the orbits that touch the stops are equal. At omega = 2 those of twice the period
 * do. */
static void families_begin_no_curve(void **unused) {
    (void)unused;
    static const network networks[] = {{"impact-oscillator",
                                        "d=0.663404 omega=0.441134 r=0.435677 c=0 sides=both",
                                        SALTUS_POINT_GR,
                                        {"omega", "d"},
                                        {0.308794, 0.331702},
                                        {0.617587, 0.995106},
                                        1,
                                        {0.04, 0.02, 0.01},
                                        -1},
                                       {"budd-dux",
                                        "omega=2.27579 r=0.805465 d=0.139033",
                                        SALTUS_POINT_GR,
                                        {"omega", "d"},
                                        {1.59305, -0.160967},
                                        {2.95852, 0.439033},
                                        2,
                                        {0.04, 0.02},
                                        2}};
    check_networks(networks, 2);
}

/* Where the one impact in two periods dies at an orbit of one period at whose grazing an impact's infinite
 * multiplier is not felt, folds end slowly: the place is told by that orbit's curve of grazing. */
static void folds_end_where_grazing_is_not_felt(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network network = {"duffing",
                                    "F=0.531242 omega=1.725 d=1.278 c=0.132799 r=0.763278 sides=both",
                                    SALTUS_POINT_LP,
                                    {"omega", "d"},
                                    {1.7, 1.26},
                                    {1.74, 1.3},
                                    1,
                                    {0.4, 0.1, 0.05},
                                    -1};
    check_network(&network, 0, NULL);
}

/* Where orbits of twice the period leave shorter ones by so little that this shows only far from there, the
 * curve is followed from near by all the same: beyond the first step were special points that nobody saw. */
static void curves_begin_near_where_they_begin(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network network = {"duffing",
                                    "F=0.335645 omega=1.5576 d=1.54499 c=0.180415 r=0.865339 sides=both",
                                    SALTUS_POINT_PD,
                                    {"omega", "d"},
                                    {1.09032, 1.08149},
                                    {2.18064, 2.16299},
                                    2,
                                    {0.04, 0.02},
                                    29};
    check_network(&network, 0, NULL);
}

/* Orbits without lasting contacts have none that shrinks where their curve ends; and where an orbit is cut
 * into halves no impact may be at the cuts. */
static void halves_are_cut_in_free_flight(void **unused) {
    (void)unused;
    static const network network = {"impact-oscillator",
                                    "d=1.33745 omega=0.902944 r=0.530089 c=0.162395",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {0.63206, 0.668727},
                                    {1.26412, 2.00618},
                                    1,
                                    {0.04, 0.02},
                                    9};
    check_network(&network, 0, NULL);
}

/* Curves of orbits that have been doubled several times end, as all their impacts die, where the orbits of
 * one period flip: in one place, by the equations of these. */
static void doubled_orbits_end_at_the_first_flip(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network network = {"impact-oscillator",
                                    "d=1.31595 omega=0.900739 r=0.557482 c=0.126182",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {0.630518, 0.657977},
                                    {1.26104, 1.97393},
                                    2,
                                    {0},
                                    0};
    branch_record record = follow(&network, 0.02, 0, NULL);
    const saltus_branch_point *first = NULL;
    int ends = 0;
    for (int k = 1; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k - 1];
        first = !first && p->kind == SALTUS_POINT_GR_PD && p[1].kind == SALTUS_POINT_EP ? p : first;
        if (!first || p->periods < 4 || p[1].kind != SALTUS_POINT_EP || !(apart(&network, p, first) < 1e-3))
            continue;
        assert_true(apart(&network, p, first) < 1e-9 && p->accuracy < 1e-9);
        ends++;
    }
    assert_int_equal(ends, 3);
    branch_forget(&record);
}

/* As they come there, another impact may seem to graze just before. */
static void doubled_orbits_pass_no_other_grazing(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network network = {"impact-oscillator",
                                    "d=1.14621 omega=0.849203 r=0.404516 c=0.135527",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {0.594442, 0.573106},
                                    {1.18888, 1.71932},
                                    2,
                                    {0.04},
                                    17};
    check_network(&network, 0, NULL);
}

/* Between equal stops both impacts of folding orbits die at once where a free vibration comes back after the
 * period: the equations are singular there, and no function along the curve tells the place. */
static void impacts_die_at_once_where_vibrations_come_back(void **unused) {
    (void)unused;
    static const network network = {"impact-oscillator",
                                    "d=0.613698 omega=0.610564 r=0.807163 c=0 sides=both",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {0.427395, 0.306849},
                                    {0.854789, 0.920546},
                                    1,
                                    {0.04, 0.02, 0.01},
                                    2};
    check_network_as(&network, 0, NULL, true);
    branch_record record = follow(&network, 0.04, 0, NULL);
    for (int k = 0; k < record.count; k++)
        if (is_named(&record.point[k]) && record.point[k].locus == SALTUS_POINT_LP) {
            check_near(record.point[k].value[0], 0.5, 1e-12);
            check_near(record.point[k].value[1], 2. / 3, 1e-12);
        }
    branch_forget(&record);
}

/* Along orbits of several periods of slow forcing perturbations grow a thousandfold and shrink again, so that
 * the differences which are second derivatives say nothing, and orbits of twice the period leave those of
 * half of it by little at the section; special orbits among these are none of those. */
static void curves_begin_where_perturbations_grow(void **unused) {
    (void)unused;
    skip_where_slow();
    static const double state[] = {1.0002341599780877, 0.6583323007780392};
    const network network = {
        "duffing",
        "F=0.429311 omega=0.933283618081556 d=1.41746648191972 c=0.356772 r=0.701606 sides=both",
        SALTUS_POINT_GR,
        {"omega", "d"},
        {0.9325, 1.416},
        {0.934, 1.419},
        1,
        {0.1, 0.05},
        8};
    check_network(&network, 4, state);
}

/* Under slow forcing between two wells errors of the flow grow so much around an orbit that the state at its
 * base does not tell it: the curves of grazing that begin where it flips are found from the states at all
 * cuts. */
static void curves_begin_where_the_base_tells_nothing(void **unused) {
    (void)unused;
    const network network = {"duffing",
                             "F=0.44 omega=0.244 d=0.7 c=0.332 r=0.402 sides=both",
                             SALTUS_POINT_PD,
                             {"F", "omega"},
                             {0.4372, 0.2425},
                             {0.4522, 0.276},
                             1,
                             {0.1},
                             -1};
    check_network_as(&network, 0, NULL, true);
}

/* The last impacts of a long run have hardly a speed all along a curve of folds of orbits that are their own
 * mirror images, so that rounding hides where it falls to zero: that is told by the curve of their grazing.
 */
static void folds_meet_grazing_within_rounding(void **unused) {
    (void)unused;
    const network network = {"duffing",
                             "F=0.49 omega=0.305 d=0.793 c=0.08 r=0.26 sides=both",
                             SALTUS_POINT_LP,
                             {"F", "omega"},
                             {0.4, 0.29},
                             {0.5, 0.31},
                             0,
                             {0.1, 0.04},
                             1};
    check_network(&network, 0, NULL);
}

/* Beyond a long run of impacts rounding hides how orbits differ from their mirror images: where a curve of
 * grazing comes to such orbits is told by the curve of these alone. */
static void grazing_joins_images_within_rounding(void **unused) {
    (void)unused;
    skip_unless_long();
    const network network = {"duffing",
                             "F=0.448 omega=0.305 d=0.617 c=0.13 r=0.378 sides=both",
                             SALTUS_POINT_PD,
                             {"F", "omega"},
                             {0.444, 0.304},
                             {0.467, 0.347},
                             1,
                             {0.1, 0.05},
                             -1};
    check_network_as(&network, 0, NULL, true);
}

/* All impacts in several periods lose their speed at once where a free vibration comes back after so many
 * periods of a motion that touches the stop. Near there the flow forgets the orbits, and their equations lead
 * nowhere. */
static void impacts_fade_at_a_resonance(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network networks[] = {{"budd-dux",
                                        "omega=4.83582 r=0.91891 d=-0.0245213",
                                        SALTUS_POINT_LP,
                                        {"omega", "d"},
                                        {3.38507, -0.324521},
                                        {6.28657, 0.275479},
                                        1,
                                        {0.04, 0.02},
                                        1},
                                       {"budd-dux",
                                        "omega=4.83582 r=0.91891 d=-0.0245213",
                                        SALTUS_POINT_LP,
                                        {"omega", "d"},
                                        {3.38507, -0.324521},
                                        {6.28657, 0.275479},
                                        1,
                                        {0.01},
                                        2}};
    check_networks(networks, 2);
}

/* Without damping a free vibration at omega = 4 turns round in two periods of the motion that touches the
 * stop if d = 1/15. Orbits of six periods with three impacts end there, as these and all that is unlike in
 * the periods fall off faster than the distance. */
static void orbits_fade_where_vibrations_turn_round(void **unused) {
    (void)unused;
    skip_where_slow();
    static const double state[] = {-0.15140702972679407, -0.08475116528692535};
    const network network = {"budd-dux",
                             "omega=3.9497905077403015 d=0.07580537997803467 r=0.948745",
                             SALTUS_POINT_GR,
                             {"omega", "d"},
                             {3.93, 0.06},
                             {4.06, 0.08},
                             0,
                             {0.04, 0.02},
                             1};
    check_network(&network, 6, state);
    branch_record record = follow(&network, 0.04, 6, state);
    for (int k = 0; k < record.count; k++)
        if (is_named(&record.point[k])) {
            assert_true(fabs(record.point[k].value[0] - 4) < 1e-11);
            assert_true(fabs(record.point[k].value[1] - 1. / 15) < 1e-12);
        }
    branch_forget(&record);
}

/* Where a grazing impact is hardly felt, folds and flips meet at almost the same place, which rounding moves
 * along the curve of grazing. */
static void places_are_as_good_as_stated(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network network = {"budd-dux",
                                    "omega=5.09066 r=0.521489 d=-0.00454926",
                                    SALTUS_POINT_LP,
                                    {"omega", "d"},
                                    {3.56346, -0.304549},
                                    {6.61785, 0.295451},
                                    2,
                                    {0.04, 0.02},
                                    6};
    check_network_as(&network, 0, NULL, true);
}

/* Curves of orbits with impacts that follow one another closely have hairpins: no step leads across one to
 * another piece of the curve. */
static void no_step_leads_across_a_hairpin(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network network = {"impact-pair",
                                    "d=1.35456 omega=1 r=0.816613",
                                    SALTUS_POINT_GR,
                                    {"d", "r"},
                                    {0.812733, 0.566613},
                                    {2.16729, 0.98},
                                    2,
                                    {0.04, 0.01},
                                    -1};
    check_network(&network, 0, NULL);
}

/* Two pieces of curves of tori come so near to each other, at a turn of both, that a step would lead from one
 * to the other: its chord then is no chord of a smooth curve. */
static void no_step_leaps_to_another_piece(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network network = {"two-mass",
                                    "d=0.196018 omega=1.20454 r=0.739606",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {0.84318, 0.117611},
                                    {1.68636, 0.274425},
                                    2,
                                    {0.04, 0.02},
                                    11};
    check_network(&network, 0, NULL);
}

/* The last of many impacts that follow one another has hardly a speed, and one that grazes after it hardly an
 * effect: less than that of a residual of its speed. Steps' residuals are felt in the places of points on
 * curves of flips, too, and a double multiplier is known only to the root of an error. */
static void last_impacts_are_hardly_felt(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network networks[] = {{"two-mass",
                                        "d=0.332407 omega=0.539284 r=0.544366",
                                        SALTUS_POINT_GR,
                                        {"omega", "d"},
                                        {0.377499, 0.199444},
                                        {0.754998, 0.46537},
                                        0,
                                        {0.04, 0.02, 0.01},
                                        3},
                                       {"two-mass",
                                        "d=0.25 omega=0.504 r=0.544366",
                                        SALTUS_POINT_PD,
                                        {"omega", "d"},
                                        {0.4, 0.199444},
                                        {0.61, 0.46537},
                                        0,
                                        {0.04, 0.02, 0.01},
                                        3}};
    check_networks(networks, 2);
}

/* Where a curve of grazing joins that of orbits of half the period at a flip, the equations of these have the
 * place; places on the curve itself lead there only roughly, and some lie on the shorter orbits' curve. */
static void grazing_joins_at_flips(void **unused) {
    (void)unused;
    skip_where_slow();
    static const double state[] = {0.029608042991023265, -0.0025607386748760222, 0.19135124574612891,
                                   0.025406592292039346};
    const network network = {"fig7d",
                             "N=2 omega=16.364175560983895 d=0.036466001807622508 r=0.595023",
                             SALTUS_POINT_GR,
                             {"omega", "d"},
                             {16.3, 0.0364},
                             {16.5, 0.0366},
                             0,
                             {0.03, 0.02, 0.012},
                             1};
    check_network(&network, 4, state);
}

/* After a long run of impacts a fold is a fold, though the null vector hardly feels the parameters; and where
 * chatter ceases to complete curves of folds end in a named point, and those of grazing where the last orbit
 * is, not where one was not found from afar. */
static void folds_meet_grazing_after_chatter(void **unused) {
    (void)unused;
    skip_unless_long();
    static const network network = {"fig7d",
                                    "omega=45.95 d=0.0218154 r=0.655228 N=3 sides=both",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {43.9, 0.0207},
                                    {46.05, 0.0238},
                                    1,
                                    {0.04, 0.02},
                                    3};
    check_network(&network, 0, NULL);
}

/* In a long run of ever weaker impacts the last ones may all come to lie without speed where one grazes: then
 * the equations hold all along the curve of an orbit that has fewer, on which the curve would get lost. */
static void weak_impacts_stay_apart(void **unused) {
    (void)unused;
    static const network network = {"two-mass",
                                    "d=0.240974 omega=0.521979 r=0.616212",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {0.365385, 0.144584},
                                    {0.730771, 0.337363},
                                    0,
                                    {0.04, 0.02},
                                    6};
    check_network(&network, 0, NULL);
}

/* After such runs the equations of tori tell little where the pair of multipliers meets; those of the flips
 * on which it does tell the place. */
static void tori_end_on_the_curve_of_flips(void **unused) {
    (void)unused;
    skip_unless_long();
    static const network network = {"two-mass",
                                    "d=0.240974 omega=0.521979 r=0.616212",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {0.365385, 0.144584},
                                    {0.730771, 0.337363},
                                    2,
                                    {0},
                                    0};
    branch_record record = follow(&network, 0.02, 0, NULL);
    int ends = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        double nearest = INFINITY;
        if (p->kind != SALTUS_POINT_R2 || p->locus != SALTUS_POINT_NS)
            continue;
        for (int j = 0; j < record.count; j++)
            if (record.point[j].kind == SALTUS_POINT_R2 && record.point[j].locus == SALTUS_POINT_PD)
                nearest = fmin(nearest, apart(&network, p, &record.point[j]));
        assert_true(nearest < 1e-9);
        ends++;
    }
    assert_true(ends > 2);
    branch_forget(&record);
}

/* Such a curve may be so steep that its last orbit is still far from the shorter ones: the places on it lead
 * to the flip all the same. */
static void steep_curves_join_at_flips(void **unused) {
    (void)unused;
    skip_where_slow();
    const double place[] = {4.96549877149627, -0.00080668575940};
    const network network = {"budd-dux",
                             "omega=4.53198 r=0.86657 d=0.037894",
                             SALTUS_POINT_GR,
                             {"omega", "d"},
                             {3.17239, -0.262106},
                             {5.89158, 0.337894},
                             1,
                             {0},
                             -1};
    saltus_message message = {.text = ""};
    saltus_scene scene = open_scene(&network);
    saltus_branch *branch = begin(&network, &scene, 0.04, 0, NULL);
    const saltus_branch_point *point = NULL;
    saltus_point_kind before = SALTUS_POINT_REGULAR;
    for (;;) {
        check_ok(saltus_branch_step(branch, &point, &message), &message);
        assert_non_null(point);
        if (point->branch == 2 && point->kind == SALTUS_POINT_EP)
            break;
        before = point->kind;
    }
    assert_int_equal(before, SALTUS_POINT_GR_PD);
    assert_non_null(strstr(point->reason, "half the period"));
    for (int k = 0; k < 2; k++)
        check_near(point->value[k], place[k], 1e-9);
    saltus_branch_free(branch);
    saltus_scene_clear(&scene);
}

/* The pair of multipliers of an orbit that is its own mirror image passes -1 where that of its half is at a
 * quarter: no R2, and the curve of tori goes on until the half's pair meets at -1, where others branch off.
 */
static void tori_of_mirror_images_pass_minus_one(void **unused) {
    (void)unused;
    skip_where_slow();
    static const network network = {"fig7d",
                                    "omega=39.4447 d=0.0236915 r=0.686473 N=2 sides=both",
                                    SALTUS_POINT_LP,
                                    {"omega", "d"},
                                    {39.4, 0.0236},
                                    {42.9, 0.0249},
                                    2,
                                    {0},
                                    0};
    branch_record record = follow(&network, 0.02, 0, NULL);
    int met[3] = {0}, ends = 0, mirrored = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        const double re = p->multipliers[0].re;
        mirrored += p->locus == SALTUS_POINT_BP;
        if (p->locus != SALTUS_POINT_NS)
            continue;
        assert_int_not_equal(p->kind, SALTUS_POINT_R2);
        if (p->kind == SALTUS_POINT_R3)
            check_near(re, -0.5, 1e-7);
        if (p->kind == SALTUS_POINT_R4)
            check_near(re, 0, 1e-7);
        met[0] += p->kind == SALTUS_POINT_R3;
        met[1] += p->kind == SALTUS_POINT_R4;
        met[2] += p->kind == SALTUS_POINT_R1;
        ends += p->kind == SALTUS_POINT_EP;
    }
    assert_true(met[0] == 2 && met[1] == 2 && met[2] == 2 && ends == 2 && mirrored > 2);
    branch_forget(&record);
}

/* Where a mass in a double well is back at the stop, at d, after it left with no force, both times at rest:
 * gap and speed there. Where the same force is back, cos(omega t) = (d^3 - d) / F, the acceleration is zero,
 * too. */
static void fly(double omega, double d, double miss[2]) {
    enum { parts = 4000 };
    const double c = 0.263, F = 0.334, from = acos((d * d * d - d) / F) / omega,
                 h = (2 * M_PI / omega - 2 * from) / parts;
    double x = d, v = 0;
    for (int k = 0; k < parts; k++) {
        static const double share[] = {0, 0.5, 0.5, 1}, weight[] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
        double speed = v, force = 0, dx = 0, dv = 0;
        for (int j = 0; j < 4; j++) {
            const double own = x + share[j] * h * speed;
            speed = v + share[j] * h * force;
            force = F * cos(omega * (from + (k + share[j]) * h)) - c * speed + own - own * own * own;
            dx += weight[j] * h * speed;
            dv += weight[j] * h * force;
        }
        x += dx;
        v += dv;
    }
    miss[0] = x - d;
    miss[1] = v;
}

/* A touch that is followed by complete chatter loses its acceleration along its curve, and with it the
 * chatter. The curve ends there, at the place that Newton's method finds for the flight alone. */
static void a_touch_becomes_the_begin_of_a_contact(void **unused) {
    (void)unused;
    static const network network = {"duffing",
                                    "c=0.263 F=0.334 d=1.034 r=0.673 omega=0.308",
                                    SALTUS_POINT_GR,
                                    {"omega", "d"},
                                    {0.25, 0.9},
                                    {0.31, 1.04},
                                    0,
                                    {0.2, 0.05},
                                    -1};
    double place[2] = {0.26, 1.02};
    for (int k = 0; k < 20; k++) {
        const double apart = 1e-5;
        double miss[2], up[2], down[2], a[2][2];
        fly(place[0], place[1], miss);
        for (int j = 0; j < 2; j++) {
            fly(place[0] + (j == 0) * apart, place[1] + (j == 1) * apart, up);
            fly(place[0] - (j == 0) * apart, place[1] - (j == 1) * apart, down);
            for (int i = 0; i < 2; i++)
                a[i][j] = (up[i] - down[i]) / (2 * apart);
        }
        const double determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
        place[0] -= (miss[0] * a[1][1] - miss[1] * a[0][1]) / determinant;
        place[1] -= (miss[1] * a[0][0] - miss[0] * a[1][0]) / determinant;
    }
    for (int k = 0; k < 2; k++) {
        branch_record record = follow(&network, network.step_max[k], 0, NULL);
        int found = 0;
        check_ends(&network, &record);
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            if (!strstr(p->reason, "shrink to the begin of a contact"))
                continue;
            check_near(p->value[0], place[0], 1e-11);
            check_near(p->value[1], place[1], 1e-11);
            assert_true(p->accuracy < 1e-9);
            found++;
        }
        assert_int_equal(found, 1);
        branch_forget(&record);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(folds_pass_an_impact_half_a_period_away),
        cmocka_unit_test(branch_points_are_met_from_near_by),
        cmocka_unit_test(mirror_images_graze_on_one_curve),
        cmocka_unit_test(mirror_images_graze_at_once),
        cmocka_unit_test(impacts_shrink_to_a_flat_touch),
        cmocka_unit_test(places_come_again_with_more_impacts),
        cmocka_unit_test(folds_fade_from_near_by),
        cmocka_unit_test(folds_end_at_symmetric_orbits),
        cmocka_unit_test(folds_end_at_flips),
        cmocka_unit_test(impacts_die_and_are_born_at_once),
        cmocka_unit_test(undamped_pairs_are_on_the_circle),
        cmocka_unit_test(families_begin_no_curve),
        cmocka_unit_test(folds_end_where_grazing_is_not_felt),
        cmocka_unit_test(curves_begin_near_where_they_begin),
        cmocka_unit_test(halves_are_cut_in_free_flight),
        cmocka_unit_test(doubled_orbits_end_at_the_first_flip),
        cmocka_unit_test(impacts_die_at_once_where_vibrations_come_back),
        cmocka_unit_test(doubled_orbits_pass_no_other_grazing),
        cmocka_unit_test(curves_begin_where_perturbations_grow),
        cmocka_unit_test(curves_begin_where_the_base_tells_nothing),
        cmocka_unit_test(folds_meet_grazing_within_rounding),
        cmocka_unit_test(grazing_joins_images_within_rounding),
        cmocka_unit_test(impacts_fade_at_a_resonance),
        cmocka_unit_test(orbits_fade_where_vibrations_turn_round),
        cmocka_unit_test(places_are_as_good_as_stated),
        cmocka_unit_test(no_step_leads_across_a_hairpin),
        cmocka_unit_test(no_step_leaps_to_another_piece),
        cmocka_unit_test(last_impacts_are_hardly_felt),
        cmocka_unit_test(grazing_joins_at_flips),
        cmocka_unit_test(folds_meet_grazing_after_chatter),
        cmocka_unit_test(weak_impacts_stay_apart),
        cmocka_unit_test(tori_end_on_the_curve_of_flips),
        cmocka_unit_test(steep_curves_join_at_flips),
        cmocka_unit_test(tori_of_mirror_images_pass_minus_one),
        cmocka_unit_test(a_touch_becomes_the_begin_of_a_contact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
