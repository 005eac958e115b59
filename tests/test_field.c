/* Fields: every kind of member goes to text and back, options have their defaults and are checked.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "base/field.h"
#include "branch/options.h"
#include "flow/options.h"
#include "motion/options.h"
#include "orbit/options.h"
#include "sweep/options.h"

#include <limits.h>

typedef enum fruit { APPLE = 2, PEAR = 5 } fruit;

typedef struct part {
    double pair[2], other;
} part;

typedef struct sample {
    double real;
    int whole;
    long long wide;
    unsigned long natural;
    bool flag;
    fruit choice;
    unsigned set;
    char text[8];
    part parts[3], *there;
} sample;

static const saltus_word fruits[] = {{"apple", APPLE}, {"pear", PEAR}, {NULL, 0}};
static const saltus_word colours[] = {{"red", 1}, {"green", 4}, {NULL, 0}};

#define MEMBER(member, ...) SALTUS_MEMBER(sample, member, #member, "1", "", __VA_ARGS__)
static const saltus_option options[] = {
    {.field = MEMBER(real, SALTUS_REAL), .fallback = 0.5, .high = 1, .above = true},
    {.field = MEMBER(whole, SALTUS_INT), .low = 8, .high = 40, .automatic = true},
    {.field = MEMBER(wide, SALTUS_LONG), .fallback = 7, .low = 1, .high = INFINITY},
    {.field = MEMBER(natural, SALTUS_NATURAL), .high = INFINITY},
    {.field = MEMBER(flag, SALTUS_FLAG), .fallback = 1},
    {.field = MEMBER(choice, SALTUS_CHOICE, .words = fruits), .fallback = PEAR},
    {.field = MEMBER(set, SALTUS_SET, .words = colours), .fallback = 4},
    {.field = MEMBER(text, SALTUS_TEXT, sizeof((sample *)0)->text)},
};
enum { count = sizeof options / sizeof *options };
static const saltus_option_table table = SALTUS_TABLE(options);

static void defaults_fill_every_option(void **unused) {
    (void)unused;
    sample s;
    saltus_message message = {.text = ""};
    memset(&s, 0x55, sizeof s);
    saltus_options_fill(&table, &s);
    check_ok(saltus_options_check(&table, &s, &message), &message);
    assert_true(s.real == 0.5 && s.whole == 0 && s.wide == 7 && s.natural == 0 && s.flag);
    assert_true(s.choice == PEAR && s.set == 4 && s.text[0] == '\0');
    assert_ptr_equal(saltus_option_find(&table, "set"), &options[6]);
    assert_null(saltus_option_find(&table, "se"));
}

/* Text goes to the member and back unchanged. */
static void values_read_back_as_the_same(void **unused) {
    (void)unused;
    static const char *const good[count][4] = {{"0.10000000000000001", "-2.5e-300", "nan"},
                                               {"-2147483648", "2147483647", "12"},
                                               {"-9223372036854775808", "9223372036854775807", "0"},
                                               {"18446744073709551615", "0", "3"},
                                               {"yes", "no"},
                                               {"apple", "pear"},
                                               {"red,green", "green", ""},
                                               {"", "1234567"}};
    static const char *const bad[count][5] = {{"", "1x", " 1", "one"},
                                              {"2147483648", "-2147483649", "1.5", "", "1 "},
                                              {"9223372036854775808", "1e3", "", " 1"},
                                              {"-1", "18446744073709551616", "", "1.0"},
                                              {"", "1", "true", "nope"},
                                              {"", "appl", "apples", "2"},
                                              {"blue", "red,blue", ",red", "re"},
                                              {"12345678"}};
    sample s = {0}, before;
    char text[SALTUS_FIELD_TEXT_MAX];
    for (int k = 0; k < count; k++) {
        const saltus_field *f = &options[k].field;
        for (int i = 0; i < 4 && good[k][i]; i++) {
            assert_true(saltus_field_read(f, good[k][i], &s));
            assert_string_equal(saltus_field_text(f, &s, text), good[k][i]);
        }
        before = s;
        for (int i = 0; i < 5 && bad[k][i]; i++) {
            if (saltus_field_read(f, bad[k][i], &s))
                fail_msg("%s takes '%s'", f->name, bad[k][i]);
            assert_memory_equal(&s, &before, sizeof s);
        }
    }
}

static void whole_numbers_fit_or_are_refused(void **unused) {
    (void)unused;
    sample s = {0};
    const saltus_field *whole = &options[1].field, *flag = &options[4].field, *choice = &options[5].field,
                       *set = &options[6].field;
    assert_true(saltus_field_set_whole(whole, INT_MIN, &s) && s.whole == INT_MIN);
    assert_false(saltus_field_set_whole(whole, (long long)INT_MAX + 1, &s));
    assert_false(saltus_field_set_whole(flag, 2, &s));
    assert_true(saltus_field_set_whole(choice, PEAR, &s) && s.choice == PEAR);
    assert_false(saltus_field_set_whole(choice, 3, &s) ||
                 saltus_field_set_whole(choice, PEAR + (1LL << 32), &s));
    assert_true(saltus_field_set_whole(set, 5, &s) && s.set == 5);
    assert_false(saltus_field_set_whole(set, 2, &s) || saltus_field_set_whole(set, -1, &s));
    assert_false(saltus_field_set_number(whole, 1.5, &s) || saltus_field_set_number(whole, NAN, &s) ||
                 saltus_field_set_number(whole, 1e300, &s));
    s.natural = 7;
    assert_false(saltus_field_set_number(&options[3].field, -1, &s));
    assert_true(s.natural == 7);
    assert_true(saltus_field_set_number(whole, 40, &s) && saltus_field_number(whole, &s) == 40);
    s.natural = ULONG_MAX;
    assert_true(saltus_field_number(&options[3].field, &s) == (double)ULONG_MAX);
}

static void sentences_name_the_option_and_its_range(void **unused) {
    (void)unused;
    static const struct {
        int option;
        double value;
        const char *sentence;
    } cases[] = {{0, 0, "real = 0: must be greater than 0 and at most 1"},
                 {0, NAN, "real = nan: must be greater than 0 and at most 1"},
                 {1, 7, "whole = 7: must be 0 or from 8 to 40"},
                 {1, 41, "whole = 41: must be 0 or from 8 to 40"},
                 {2, 0, "wide = 0: must be at least 1"}};
    static const double good[][2] = {{0, 1}, {0, 1e-300}, {1, 0}, {1, 8}, {1, 40}, {2, 1}, {2, 1e18}};
    saltus_message message = {.text = ""};
    sample s;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        saltus_options_fill(&table, &s);
        assert_true(saltus_field_set_number(&options[cases[k].option].field, cases[k].value, &s));
        assert_int_equal(saltus_options_check(&table, &s, &message), SALTUS_BAD_INPUT);
        assert_string_equal(message.text, cases[k].sentence);
    }
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
        saltus_options_fill(&table, &s);
        assert_true(saltus_field_set_number(&options[(int)good[k][0]].field, good[k][1], &s));
        check_ok(saltus_options_check(&table, &s, &message), &message);
    }
    saltus_options_fill(&table, &s);
    s.choice = (fruit)3;
    assert_int_equal(saltus_options_check(&table, &s, &message), SALTUS_BAD_INPUT);
    assert_string_equal(message.text, "choice = 3: must be apple or pear");
    s.choice = APPLE;
    s.set = 2;
    assert_int_equal(saltus_options_check(&table, &s, &message), SALTUS_BAD_INPUT);
    assert_string_equal(message.text, "set = 2: must be red or green, with commas between them");
}

/* Lists and matrices, in the struct or behind a pointer, contiguous or not. */
static void entries_are_gathered_and_spread(void **unused) {
    (void)unused;
    static const saltus_field fields[] = {MEMBER(parts, SALTUS_REAL, -1, 2, .stride = sizeof(part)),
                                          MEMBER(there, SALTUS_REAL, -1, .stride = sizeof(part),
                                                 .indirect = true, .inner = offsetof(part, other)),
                                          MEMBER(parts, SALTUS_REAL, 2)};
    const int counts[] = {3}, none[] = {0};
    part behind[3] = {{.other = 10}, {.other = 11}, {.other = 12}};
    sample s = {.there = behind}, t = {0};
    double entries[6] = {0};
    int length[2];
    for (int k = 0; k < 3; k++)
        s.parts[k] = (part){{2 * k, 2 * k + 1}, -1};
    assert_int_equal(saltus_field_shape(&fields[0], counts, length), 6);
    assert_true(length[0] == 3 && length[1] == 2);
    saltus_field_pack(&fields[0], counts, &s, entries);
    for (int k = 0; k < 6; k++)
        assert_true(entries[k] == k);
    saltus_field_unpack(&fields[0], counts, entries, &t);
    for (int k = 0; k < 3; k++)
        assert_true(t.parts[k].pair[0] == 2 * k && t.parts[k].pair[1] == 2 * k + 1 && t.parts[k].other == 0);
    saltus_field_pack(&fields[1], counts, &s, entries);
    assert_true(entries[0] == 10 && entries[1] == 11 && entries[2] == 12 && entries[3] == 3);
    entries[1] = 20;
    saltus_field_unpack(&fields[1], counts, entries, &s);
    assert_true(behind[1].other == 20 && behind[1].pair[0] == 0);
    saltus_field_pack(&fields[2], NULL, &s, entries);
    assert_true(entries[0] == 0 && entries[1] == 1 && entries[2] == 12);
    assert_int_equal(saltus_field_shape(&fields[0], none, length), 0);
    s.there = NULL;
    saltus_field_pack(&fields[1], none, &s, entries);
    assert_true(entries[0] == 0);
}

/* The library's tables: names are distinct, defaults admissible, command line options explained, values
 * beyond a bound refused by name. */
static void options_of_the_library_are_sound(void **unused) {
    (void)unused;
    static const saltus_option_table *const tables[] = {
        &saltus_flow_table,  &saltus_orbit_table,    &saltus_harvest_table,  &saltus_branch_table,
        &saltus_sweep_table, &saltus_classify_table, &saltus_lyapunov_table, &saltus_spectrum_table};
    static double record[512]; /* as large as the largest struct */
    saltus_message message = {.text = ""};
    for (size_t t = 0; t < sizeof tables / sizeof *tables; t++) {
        saltus_options_fill(tables[t], record);
        check_ok(saltus_options_check(tables[t], record, &message), &message);
        for (int k = 0; k < tables[t]->count; k++) {
            const saltus_option *o = &tables[t]->options[k];
            const saltus_field *f = &o->field;
            assert_ptr_equal(saltus_option_find(tables[t], f->name), o);
            assert_true(f->meaning[0] && f->offset + saltus_field_bytes(f) <= sizeof record);
            assert_true(!o->flag || (strncmp(o->flag, "--", 2) == 0 && o->argument));
            if (f->words || f->type == SALTUS_FLAG || f->type == SALTUS_TEXT || !isfinite(o->low))
                continue;
            assert_true(o->low < o->high);
            for (int end = 0; end < 2 && f->type != SALTUS_NATURAL; end++) {
                double bound = end ? o->high : o->low,
                       step = f->type == SALTUS_REAL ? 1e-3 * (o->high - o->low) : 1;
                if (!isfinite(bound))
                    continue;
                step = isfinite(step) ? step : 1;
                saltus_options_fill(tables[t], record);
                saltus_field_set_number(f, end ? bound + step : bound - step, record);
                assert_int_equal(saltus_options_check(tables[t], record, &message), SALTUS_BAD_INPUT);
                assert_int_equal(strncmp(message.text, f->name, strlen(f->name)), 0);
                saltus_field_set_number(f, bound, record);
                assert_int_equal(saltus_option_admits(o, record), end ? !o->below : !o->above);
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_fill_every_option),
        cmocka_unit_test(values_read_back_as_the_same),
        cmocka_unit_test(whole_numbers_fit_or_are_refused),
        cmocka_unit_test(sentences_name_the_option_and_its_range),
        cmocka_unit_test(entries_are_gathered_and_spread),
        cmocka_unit_test(options_of_the_library_are_sound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
