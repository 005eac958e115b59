/* Lyapunov exponents as a few lines for people and as one JSON object.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/options.h"
#include "record/fields.h"
#include "record/json.h"

#include <math.h>
#include <string.h>

static int clamped(double value, int low, int high) {
    return value < low ? low : value > high ? high : (int)value;
}

saltus_uncertain saltus_uncertain_text(double value, double error) {
    saltus_uncertain text;
    const size_t room = sizeof text.value;
    if (!isfinite(value) || !isfinite(error) || !(error > 0)) {
        if (isinf(value))
            snprintf(text.value, room, "%sinfinity", value < 0 ? "-" : "");
        else
            snprintf(text.value, room, "%.6g", value);
        snprintf(text.error, room, "%s", error == 0 ? "0" : "unknown");
        return text;
    }
    /* Power of ten of the first digit of the error, after rounding to two digits. */
    const double power = floor(log10(error));
    int first = (int)(error / pow(10, power) >= 9.95 ? power + 1 : power), last = first - 1;
    double size = fmax(fabs(value), error);
    if (size >= 1e-3 && size < 1e6) {
        int decimals = clamped(-last, 0, 15);
        snprintf(text.value, room, "%.*f", decimals, value);
        if (first >= -4)
            snprintf(text.error, room, "%.*f", decimals, error);
        else
            snprintf(text.error, room, "%.1e", error);
        return text;
    }
    double lead = value == 0 ? first : floor(log10(fabs(value)));
    snprintf(text.value, room, "%.*e", clamped(lead - last, 0, 15), value);
    snprintf(text.error, room, "%.1e", error);
    return text;
}

saltus_sense saltus_lyapunov_sense(const saltus_lyapunov *l) {
    double exponent = l->exponents[0], error = l->standard_errors[0];
    if (exponent == -INFINITY)
        return SALTUS_SENSE_MEET;
    if (fabs(exponent) > 3 * error)
        return exponent > 0 ? SALTUS_SENSE_SEPARATE : SALTUS_SENSE_APPROACH;
    return l->precise ? SALTUS_SENSE_KEEP : SALTUS_SENSE_UNRESOLVED;
}

const char *saltus_sense_word(saltus_sense sense) {
    static const char *const words[] = {"positive", "negative", "zero", "unresolved", "lost"};
    return words[sense];
}

const char *saltus_lost_words(const saltus_system *system) {
    for (int f = 0; f < saltus_system_face_count(system); f++)
        if (saltus_system_face(system, f).r == 0)
            return "lost in lasting contacts or impacts without rebound";
    return "lost in lasting contacts";
}

static void put_meaning(FILE *file, const saltus_system *system, const saltus_lyapunov *l) {
    static const char *const meanings[] = {
        [SALTUS_SENSE_SEPARATE] = "positive: nearby trajectories separate",
        [SALTUS_SENSE_APPROACH] = "negative: nearby trajectories approach each other",
        [SALTUS_SENSE_KEEP] =
            "zero within the error: nearby trajectories neither separate nor approach each other",
        [SALTUS_SENSE_UNRESOLVED] = "undecided: "};
    const saltus_sense sense = saltus_lyapunov_sense(l);
    saltus_put_word(file, "meaning");
    if (sense == SALTUS_SENSE_MEET) {
        fprintf(file, "every direction is %s: nearby trajectories become one\n", saltus_lost_words(system));
        return;
    }
    fputs(meanings[sense], file);
    if (sense == SALTUS_SENSE_SEPARATE || sense == SALTUS_SENSE_APPROACH)
        fprintf(file, ", e-fold in %.4g periods", 1 / fabs(l->exponents[0] * l->period));
    if (sense == SALTUS_SENSE_UNRESOLVED)
        fputs(isfinite(l->standard_errors[0]) ? "not told from zero by more than three standard errors"
                                              : "too few values for a standard error",
              file);
    fputc('\n', file);
    if (!saltus_system_forced(system) && l->periods > 0)
        fprintf(
            file,
            "  %-14snot forced: unless the system is at rest, one exponent is that of time itself, zero\n",
            "");
}

/* If several exponents were computed: all of them, and their sum. */
static void put_spectrum(FILE *file, const saltus_system *system, const saltus_lyapunov *l) {
    if (l->count < 2)
        return;
    fprintf(file, "  %-14s  per unit of time  standard error        per period\n", "exponents");
    for (int k = 0; k < l->count; k++) {
        saltus_uncertain own = saltus_uncertain_text(l->exponents[k], l->standard_errors[k]),
                         period = saltus_uncertain_text(l->exponents[k] * l->period,
                                                        l->standard_errors[k] * l->period);
        fprintf(file, "  %13d %18s", k + 1, own.value);
        if (l->exponents[k] == -INFINITY)
            fprintf(file, "  %s\n", saltus_lost_words(system));
        else
            fprintf(file, "  %14s  %16s\n", own.error, period.value);
    }
    saltus_put_word(file, "sum rule");
    if (l->count < l->dimension)
        fprintf(file, "needs all %d exponents\n", l->dimension);
    else if (l->lost)
        fprintf(file, "does not apply: %d of %d directions are %s\n", l->lost, l->dimension,
                saltus_lost_words(system));
    else if (l->periods == 0)
        fprintf(file, "the eigenvalues add up to the trace of the linear motion, %.10g\n", l->sum);
    else if (isnan(l->sum_rule))
        fprintf(file, "not checked: the trace is not known; exponents add up to %.10g\n", l->sum);
    else
        fprintf(file, "exponents add up to %.10g; trace and restitution give %.10g (difference %.1e)\n",
                l->sum, l->sum_rule, l->sum - l->sum_rule);
    if (l->members == 0)
        return;
    saltus_put_word(file, "dimension");
    if (isnan(l->kaplan_yorke))
        fputs("Kaplan-Yorke: needs more exponents, until they add up to less than zero\n", file);
    else if (saltus_system_forced(system))
        fprintf(file, "Kaplan-Yorke %.4g in the stroboscopic section, %.4g with time\n", l->kaplan_yorke,
                l->kaplan_yorke + 1);
    else
        fprintf(file, "Kaplan-Yorke %.4g\n", l->kaplan_yorke);
}

/* How long was measured and, of a finite exponent, how precisely. */
static void put_measured(FILE *file, const saltus_system *system, const saltus_lyapunov_options *o,
                         const saltus_lyapunov *l) {
    const double error = l->standard_errors[0], part = error / fabs(l->exponents[0]);
    fprintf(file, "  %-14s%.6g per period; sticks: %.6g per period\n", "impacts", l->impacts_per_period,
            l->sticks_per_period);
    if (l->members == 0) {
        if (l->periods == 0)
            fprintf(file, "  %-14snothing: these are the eigenvalues of an equilibrium\n", "measured");
        else
            fprintf(file, "  %-14snothing: these are the multipliers of an orbit of period %lld T\n",
                    "measured", l->periods);
        return;
    }
    fprintf(file, "  %-14s%lld periods (%.6g units of time) by all trajectories together (%s)%s\n",
            "measured", l->periods, l->time, saltus_integrator_used(system, o->flow.integrator),
            l->interrupted ? "; interrupted" : "");
    fprintf(file, "  %-14s%lld period%s", "transient", l->transient, saltus_plural(l->transient));
    if (l->transient > o->transient)
        fprintf(file, ": %lld as asked for, then until directions and exponent had settled", o->transient);
    fputc('\n', file);
    if (saltus_lyapunov_sense(l) == SALTUS_SENSE_MEET)
        return;
    saltus_put_word(file, "precision");
    if (!isfinite(error))
        fputs("NOT reached: too few values for a standard error\n", file);
    else if (!l->precise && part <= o->precision)
        fprintf(file, "NOT reached: too few values, though the standard error is %.2g %% of the exponent\n",
                100 * part);
    else if (!l->precise)
        fprintf(file, "NOT reached: the standard error is %.2g %% of the exponent, %.2g %% was asked for\n",
                100 * part, 100 * o->precision);
    else if (part > o->precision)
        fprintf(file, "reached: the standard error is %.1e per period\n", error * l->period);
    else
        fprintf(file, "reached: the standard error is %.2g %% of the exponent\n", 100 * part);
    if (l->slow)
        fprintf(
            file,
            "  %-14sthe run ends here, as its error has hardly fallen since it was eight times as short: "
            "neighbours separate in bursts, between quiet stretches of all lengths; more --periods go on\n",
            "");
}

void saltus_write_lyapunov_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                const saltus_lyapunov_options *options, const saltus_lyapunov *l) {
    const bool finite = saltus_lyapunov_sense(l) != SALTUS_SENSE_MEET;
    const double value = l->exponents[0], error = l->standard_errors[0];
    const saltus_uncertain own = saltus_uncertain_text(value, error),
                           period = saltus_uncertain_text(value * l->period, error * l->period);
    fprintf(file, "%s: largest Lyapunov exponent ", scene->name);
    if (finite)
        fprintf(file, "%s +- %s\n", own.value, own.error);
    else
        fputs("-infinity\n", file);
    saltus_put_scene(file, scene, system);
    if (finite)
        fprintf(file, "  %-14s%s +- %s per unit of time, %s +- %s per period (T = %.10g)\n", "exponent",
                own.value, own.error, period.value, period.error, l->period);
    put_meaning(file, system, l);
    put_spectrum(file, system, l);
    if (finite && l->members > 0) {
        /* Whether the two halves of the run, and the trajectories that share the work, agree. */
        const saltus_uncertain first = saltus_uncertain_text(l->half[0], l->half_errors[0]),
                               second = saltus_uncertain_text(l->half[1], l->half_errors[1]);
        const double both = hypot(l->half_errors[0], l->half_errors[1]);
        double low = INFINITY, high = -INFINITY;
        fprintf(file, "  %-14s%s +- %s in the first half, %s +- %s in the second", "halves", first.value,
                first.error, second.value, second.error);
        if (isfinite(both) && both > 0)
            fprintf(file, " (%.1f standard errors apart)", fabs(l->half[0] - l->half[1]) / both);
        fprintf(file, "\n  %-14s%d", "trajectories", l->members);
        for (int m = 0; m < l->members; m++) {
            low = fmin(low, l->member_exponents[m]);
            high = fmax(high, l->member_exponents[m]);
        }
        if (l->members > 1)
            fprintf(file, ", each alone from %.6g to %.6g: they %s", low, high,
                    l->agree ? "agree" : "DO NOT AGREE");
        fputc('\n', file);
        if (l->members > 1 && !l->agree)
            fprintf(file,
                    "  %-14sthey do not measure the same motion: there are coexisting attractors, or the "
                    "transient is longer%s\n",
                    "", l->slow ? ", or quiet stretches are as long as the run" : "");
    }
    put_measured(file, system, options, l);
}

void saltus_write_lyapunov_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                const saltus_lyapunov_options *options, const saltus_lyapunov *l) {
    /* JSON null for exponents that are -infinity and have no error. */
    double errors[SALTUS_STATE_MAX];
    for (int k = 0; k < l->count; k++)
        errors[k] = isfinite(l->exponents[k]) ? l->standard_errors[k] : NAN;
    saltus_json_begin(file, scene);
    if (l->interrupted)
        fputs(", \"complete\": false", file);
    saltus_json_member(file, "largest", l->exponents[0]);
    saltus_json_member(file, "standard_error", errors[0]);
    saltus_json_text(file, "sign", saltus_sense_word(saltus_lyapunov_sense(l)));
    saltus_json_list(file, "exponents", l->exponents, l->count);
    saltus_json_list(file, "standard_errors", errors, l->count);
    saltus_json_fields(file, ", ", &saltus_exponent_fields, (const int[]){l->dimension, l->members}, l);
    /* All options except the Taylor order and the number of exponents, which the result contains. */
    saltus_json_key(file, "options");
    for (int k = 0; k < saltus_lyapunov_table.count; k++) {
        const saltus_field *field = &saltus_lyapunov_table.options[k].field;
        const saltus_field_table one = {field, 1};
        if (strcmp(field->name, "order") != 0 && strcmp(field->name, "exponents") != 0)
            saltus_json_fields(file, k ? ", " : "{", &one, NULL, options);
    }
    fputc('}', file);
    saltus_json_end(file, saltus_system_spec(system),
                    saltus_integrator_used(system, options->flow.integrator));
}
