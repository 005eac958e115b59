/* The document reader: the meaning of a text, the places of its values, refusals with their places.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "scene/document.h"

static saltus_status read_as(const char *text, size_t length, int lines_before, saltus_document *document,
                             saltus_message *message) {
    saltus_source source = {.text = text,
                            .length = length,
                            .origin = "o",
                            .language = "JSON",
                            .lines_before = lines_before,
                            .message = message};
    return saltus_document_read(&source, document);
}

static saltus_document read_text(const char *text) {
    saltus_document document;
    saltus_message message;
    if (read_as(text, strlen(text), 0, &document, &message) != SALTUS_OK)
        fail_msg("%s\n%s", message.text, text);
    return document;
}

/* A refused text leaves the document empty; the message begins with its line and these words. */
static void refused_as(const char *text, size_t length, int line, const char *words, saltus_cause cause) {
    saltus_document document;
    saltus_message message;
    char wanted[160];
    snprintf(wanted, sizeof wanted, "o:%d: %s", line, words);
    assert_int_equal(read_as(text, length, 0, &document, &message), SALTUS_BAD_INPUT);
    assert_true(!document.root && !document.memory);
    if (strncmp(message.text, wanted, strlen(wanted)) != 0 || message.line != line || message.cause != cause)
        fail_msg("'%s' (line %d, cause %d) instead of '%s' for\n%s", message.text, message.line,
                 message.cause, wanted, text);
    assert_null(strchr(message.text, '\n'));
    /* A part of a file also counts the lines before it. */
    assert_int_equal(read_as(text, length, 30, &document, &message), SALTUS_BAD_INPUT);
    assert_int_equal(message.line, line + 30);
    /* A message is not required. */
    assert_int_equal(read_as(text, length, 0, &document, NULL), SALTUS_BAD_INPUT);
}

static void refused(const char *text, int line, const char *words) {
    refused_as(text, strlen(text), line, words, SALTUS_CAUSE_OTHER);
}

/* Whether two trees hold the same keys, words and kinds; places and quotation marks aside. */
static bool same(const saltus_node *a, const saltus_node *b) {
    if (!a || !b)
        return a == b;
    if (a->kind != b->kind || a->count != b->count || !a->key != !b->key ||
        (a->key && strcmp(a->key, b->key) != 0) || (a->text && strcmp(a->text, b->text) != 0))
        return false;
    const saltus_node *x = a->first, *y = b->first;
    for (; x && y && same(x, y); x = x->next)
        y = y->next;
    return !x && !y;
}

/* One tree in block style, in flow style, as JSON, behind a byte order mark and with carriage returns. */
static void one_tree_has_many_texts(void **state) {
    static const char *const texts[] = {
        "# first\na: 1\nb:\n- x\n- [2, -3e5]\n-\n- {c: d}\n'e f': \"g\\u00e9\\n\"\nlast: {}\n",
        "{a: 1, b: [x, [2, -3e5], '', {c: d}], e f: \"g\303\251\\n\", last: {}}",
        "{\"a\":1,\"b\":[\"x\",[2,-3e5],\"\",{\"c\":\"d\"}],\"e f\":\"g\\u00e9\\n\",\"last\":{}}",
        "\xef\xbb\xbf{\"a\" : 1, \"b\" : [\"x\", [2,\n\t-3e5], \"\",\n {\"c\": \"d\"} ],\n\"e f\":\n"
        "\"g\\u00E9\\n\", \"last\": { }}\r\n",
        "---\r\na: 1\r\nb: [x, [2,\r\n -3e5], '', {c: d}]\r\ne f: \"g\xc3\xa9\\n\"\r\nlast: {\r\n "
        "}\r\n...\r\n"};
    (void)state;
    saltus_document first = read_text(texts[0]);
    const saltus_node *b = saltus_node_member(first.root, "b");
    assert_true(first.root->kind == SALTUS_NODE_MAPPING && first.root->count == 4 && !first.root->key);
    assert_true(b->kind == SALTUS_NODE_LIST && b->count == 4 && !saltus_node_child(b, 4));
    assert_string_equal(saltus_node_child(saltus_node_child(b, 1), 1)->text, "-3e5");
    assert_string_equal(saltus_node_member(first.root, "e f")->text, "g\xc3\xa9\n");
    assert_string_equal(saltus_node_child(b, 2)->text, "");
    assert_null(saltus_node_member(first.root, "c"));
    assert_null(saltus_node_member(b, "a"));
    assert_null(saltus_node_member(NULL, "a"));
    assert_null(saltus_node_child(b, -1));
    for (size_t k = 1; k < sizeof texts / sizeof texts[0]; k++) {
        saltus_document other = read_text(texts[k]);
        assert_true(same(first.root, other.root));
        saltus_document_close(&other);
        assert_true(!other.root && !other.memory);
    }
    saltus_document_close(&first);
    static const char *const empty[] = {"", "\n\n", "# nothing\n", "\xef\xbb\xbf"};
    for (int k = 0; k < 4; k++) {
        first = read_text(empty[k]);
        assert_null(first.root);
        saltus_document_close(&first);
    }
}

static void values_know_their_places(void **state) {
    (void)state;
    saltus_document d = read_text("# é\na:   1\nlist: [x, \"y\",\n   {k: 'v'}]\nbelow:\n\n   3\nb: |\n  1\n");
    static const struct {
        const char *key;
        int key_line, line, column;
        bool quoted;
    } places[] = {
        {"a", 2, 2, 6, false}, {"list", 3, 3, 7, false}, {"below", 5, 7, 4, false}, {"b", 8, 8, 4, true}};
    for (size_t k = 0; k < sizeof places / sizeof places[0]; k++) {
        const saltus_node *node = saltus_node_member(d.root, places[k].key);
        assert_int_equal(node->key_line, places[k].key_line);
        assert_int_equal(node->line, places[k].line);
        assert_int_equal(node->column, places[k].column);
        assert_int_equal(node->quoted, places[k].quoted);
    }
    const saltus_node *list = saltus_node_member(d.root, "list"), *inner = saltus_node_child(list, 2);
    assert_true(!list->first->quoted && list->first->next->quoted && list->first->column == 8);
    assert_true(inner->line == 4 && inner->key_line == 4 && inner->column == 4 && !inner->key);
    assert_true(inner->first->quoted && inner->first->key_line == 4 && inner->first->column == 8);
    saltus_document_close(&d);
}

static void refusals_have_their_line(void **state) {
    (void)state;
    refused("a: 1\nb: 2\n\na: 3\n", 4, "a: given twice, first in line 1; keep one of them");
    refused("[{x: 1,\n x: 2}]", 2, "x: given twice, first in line 1");
    refused("{\"x\": 1, \"\\u0078\": 2}", 1, "x: given twice, first in line 1");
    refused("{\"a\\nb\": 1,\n\"a\\nb\": 2}", 2, "a b: given twice, first in line 1");
    refused("a: &x 1\nb: *x\n", 2, "aliases (*name) are not possible; write the value itself");
    refused("*x : 1\n", 1, "aliases");
    refused("a: 1\nb: *x*y\n", 2,
            "not valid JSON here or below: no value begins with *; put it in quotation");
    refused("a: [* x]\n", 1, "not valid JSON here or below: no value begins with *");
    refused("a: >y\n", 1, "not valid JSON here or below: no value begins with >");
    refused("a: 1\nb: !!int 2\n", 2, "tags (!name) are not possible");
    refused("a: 1\nb: ! [2]\n", 2, "tags");
    refused("!x {a: 1}\n", 1, "tags");
    refused("!x a: 1\n", 1, "tags");
    refused("a: 1\n? [b]\n: 2\n", 2, "keys must be single words");
    refused("\na: \"b\\0c\"\n", 2, "a text with the character NUL");
    refused("\"b\\u0000\": 1\n", 1, "a text with the character NUL");
    refused("a: 1\n\nb: \xc2\x80\n", 3, "not valid JSON: the character U+0080");
    refused("a: 1\n\xef\xbf\xbe\n", 2, "not valid JSON: the character U+FFFE");
    refused("a: [1, 2\nb: 3\n", 2,
            "not valid JSON here or below: a comma is missing, or the [ of line 1 is not");
    refused("{\"a\": 1\n\"b\": 2}", 2,
            "not valid JSON here or below: a comma is missing, or the { of line 1");
    refused("a: 1\nb 2\nc: 3\n", 2, "not valid JSON here or below: line 2 has no value; write key: value");
    refused("a: 1\nb: \"\\q\"\n", 2, "not valid JSON here or below: what follows the backslash is no escape");
    refused("a: 1\nb: [x] + 1\n", 2,
            "not valid JSON here or below: no value goes on like this; put one that");
    refused("a: 1\nb: 'x' + 1\n", 2, "not valid JSON here or below: no value goes on like this");
    refused("a: 1\nb: [x]]\n", 2, "not valid JSON here or below: found ], but no bracket is open");
    refused("a: 1\n b: 2\n", 2, "not valid JSON here or below: this does not go with what stands above");
    refused("a:\n- b: 1\n c: 2\n", 3,
            "not valid JSON here or below: this does not go with what stands above");
    refused("a:\n  - 1\n - 2\n", 3, "not valid JSON here or below: this does not go with what stands above");
    refused("a: - 1\n", 1, "not valid JSON here or below: no value goes on like this");
    refused("a: 1\nb: [1,\n\n {c: 2]\n", 4,
            "not valid JSON here or below: found ], but the { of line 4 is not");
    refused("a: b: c\n", 1, "not valid JSON here or below: no value goes on like this");
    refused("a: 1\nb: 'x\n\n", 2, "not valid JSON here or below: the quotation mark (') of line 2 is not");
    refused("a: 1\nb: `x\n", 2, "not valid JSON here or below: no value begins with `; put it in quotation");
    refused("a: 1\n\tb: 2\n", 2, "not valid JSON here or below: found a tab; indent with spaces");
    refused("a: 1\nb: [1, 2,\n 3\n", 4, "not valid JSON here or below: the [ of line 2 is not closed");
    refused_as("a: 1\n\0", 6, 2, "not a text file (it holds the byte 0x00)", SALTUS_CAUSE_OTHER);
    refused_as("a: \xc3", 4, 1, "not a text file in UTF-8 (byte 0xc3)", SALTUS_CAUSE_OTHER);
}

/* A second value, in any form, is reported with the line in which it begins. */
static void several_values_are_told(void **state) {
    static const char *const firsts[] = {"{\"a\": 1}", "[1,\n 2]", "{a: {b: 'c\xc3\xa9'}}"};
    static const char *const seconds[] = {"{\"a\": 1}", "[", "x: 1",        "3",
                                          "\"y\"",      "}", "---\nx: 1\n", "--- 5"};
    (void)state;
    for (size_t a = 0; a < 3; a++)
        for (size_t b = 0; b < sizeof seconds / sizeof seconds[0]; b++)
            for (int blank = 0; blank < 3; blank++) {
                char text[80];
                snprintf(text, sizeof text, "%s\n%.*s%s", firsts[a], blank, "\n\n", seconds[b]);
                refused_as(text, strlen(text), 2 + (a == 1) + blank, "holds more than one JSON document",
                           SALTUS_CAUSE_SEVERAL);
            }
}

/* JSON that ends too early is reported as truncated, wherever it ends; no valid JSON and no other damage
 * is. */
static void texts_that_break_off_are_told(void **state) {
    static const char whole[] =
        "\n {\"a\": [1, -2.5e-3, null, true], \"b\" : {\"c\\\"\\u00e9\": \"d: \\\\ \xc3\xa9\"},\n"
        " \"e\": [[], {}], \"f\": \"\"}";
    (void)state;
    saltus_document document;
    saltus_message message;
    for (size_t length = 3; length <= sizeof whole - 1; length++) {
        saltus_status status = read_as(whole, length, 0, &document, &message);
        if (length == sizeof whole - 1) {
            assert_int_equal(status, SALTUS_OK);
            saltus_document_close(&document);
        } else if (((unsigned char)whole[length] & 0xc0) != 0x80) { /* not within a character */
            assert_int_equal(status, SALTUS_BAD_INPUT);
            if (message.cause != SALTUS_CAUSE_CUT_OFF)
                fail_msg("%.*s: %s", (int)length, whole, message.text);
        }
    }
    static const char *const others[] = {"{\"a\": [1}",  "{\"a\": ]}", "{a: @}", "{a: 1}}",
                                         "{\"a\" 1, }:", "a: [1",      "a: 'b"};
    for (size_t k = 0; k < sizeof others / sizeof others[0]; k++) {
        assert_int_equal(read_as(others[k], strlen(others[k]), 0, &document, &message), SALTUS_BAD_INPUT);
        assert_int_not_equal(message.cause, SALTUS_CAUSE_CUT_OFF);
    }
}

/* The largest number of levels and keys, and one more. */
static void bounds_hold(void **state) {
    enum { levels = 65, keys = 1024 };
    (void)state;
    saltus_document document;
    saltus_message message;
    char text[keys * 8 + 64];
    for (int style = 0; style < 3; style++)
        for (int depth = levels; depth <= levels + 1; depth++) {
            size_t used = 0;
            for (int k = 0; k < depth; k++)
                used += (size_t)sprintf(text + used, style == 0 ? "[" : style == 1 ? "{a: " : "- ");
            used += (size_t)sprintf(text + used, style == 2 ? "1" : style == 1 ? "1" : "");
            for (int k = 0; k < depth && style < 2; k++)
                text[used++] = style ? '}' : ']';
            saltus_status status = read_as(text, used, 0, &document, &message);
            assert_int_equal(status, depth > levels ? SALTUS_BAD_INPUT : SALTUS_OK);
            assert_true(!status || strstr(message.text, "o:1: lists and mappings are nested too deep"));
            saltus_document_close(&document);
        }
    for (int count = keys; count <= keys + 1; count++) {
        size_t used = 0;
        for (int k = 0; k < count; k++)
            used += (size_t)sprintf(text + used, "k%d:\n", k);
        saltus_status status = read_as(text, used, 0, &document, &message);
        assert_int_equal(status, count > keys ? SALTUS_BAD_INPUT : SALTUS_OK);
        assert_true(!status || strstr(message.text, "o:1025: too many keys in one mapping"));
        saltus_document_close(&document);
    }
}

/* Damaged texts are read, or refused with a message; values read have valid places. */
static int check_tree(const saltus_node *node, int lines) {
    int nodes = 1, children = 0;
    assert_true(node->line >= 1 && node->line <= lines && node->key_line >= 1 &&
                node->key_line <= node->line);
    assert_true(node->column >= 1 && (node->kind == SALTUS_NODE_SCALAR) == (node->text != NULL));
    for (const saltus_node *child = node->first; child; child = child->next, children++) {
        assert_int_equal(child->key != NULL, node->kind == SALTUS_NODE_MAPPING);
        nodes += check_tree(child, lines);
    }
    assert_int_equal(children, node->count);
    return nodes;
}

static void damaged_texts_are_read_or_refused(void **state) {
    static const char *const seeds[] = {
        "model: pipe\nstops:\n- {d: 0.03, sides: both}\n- d: 1\n  xi: '0.5'\ntitle: \"a b\"\n",
        "{\"a\": [1, 2, {\"b\": null}], \"c\": \"d\\u00e9\"}\n",
        "a: |\n  x\n  y\nb: >-\n  z\n? c\n: d\ne: [f, g: h]\n"};
    static const char letters[] = "{}[]:,-?*&!|>'\"%@`# \n\t\\a0.\xc3\xa9";
    (void)state;
    unsigned seed = 1;
    int read = 0, all = 0;
    for (int trial = 0; trial < 30000; trial++) {
        char text[256];
        strcpy(text, seeds[trial % 3]);
        size_t length = strlen(text);
        for (int k = 0; k < 1 + trial % 4; k++) {
            seed = seed * 1664525u + 1013904223u;
            text[(seed >> 8) % length] = letters[(seed >> 20) % (sizeof letters - 1)];
        }
        int lines = 2;
        for (size_t k = 0; k < length; k++)
            lines += text[k] == '\n';
        saltus_document document;
        saltus_message message;
        saltus_status status = read_as(text, length, 0, &document, &message);
        assert_true(status == SALTUS_OK || status == SALTUS_BAD_INPUT);
        if (status == SALTUS_OK && document.root)
            read += check_tree(document.root, lines) > 0;
        if (status != SALTUS_OK &&
            (strncmp(message.text, "o:", 2) != 0 || message.line < 1 || message.line > lines))
            fail_msg("%s\n%s", message.text, text);
        all++;
        saltus_document_close(&document);
    }
    assert_true(read > all / 10 && read < 9 * all / 10);
}

/* The given fields of a message are set, all others are cleared. */
static void messages_say_what_they_are_about(void **state) {
    (void)state;
    saltus_message message;
    memset(&message, 0x5a, sizeof message);
    saltus_fault fault = {SALTUS_CAUSE_SEVERAL, "a key that is longer than any key of a scene", 3, 7};
    assert_int_equal(saltus_fail_at(&message, SALTUS_SINGULAR, fault, "x %d", 5), SALTUS_SINGULAR);
    assert_string_equal(message.text, "x 5");
    assert_true(message.cause == SALTUS_CAUSE_SEVERAL && message.stop == 3 && message.line == 7);
    assert_true(strlen(message.key) == sizeof message.key - 1 &&
                strncmp(message.key, fault.key, sizeof message.key - 1) == 0);
    assert_int_equal(saltus_fail(&message, SALTUS_IO, "y"), SALTUS_IO);
    assert_true(message.cause == SALTUS_CAUSE_OTHER && message.stop == 0 && message.line == 0 &&
                !message.key[0]);
    assert_int_equal(saltus_fail_at(NULL, SALTUS_IO, fault, "z"), SALTUS_IO);
    /* Refusals by a system or scene contain the key and the stop. */
    static const struct {
        const char *text, *key;
        int stop, line;
    } known[] = {
        {"model: pipe\nomega: -1\n", "omega", 0, 2},
        {"model: pipe\nomega: x\n", "omega", 0, 2},
        {"model: pipe\nstop:\n  d: 1\n  r: 7\n", "r", 1, 4},
        {"model: pipe\nstops:\n- d: 1\n- d: 2\n  xi: 3\n", "xi", 2, 5},
        {"model: pipe\nstops:\n- d: 1\n- d: -2\n  sides: both\n", "d", 2, 4},
        {"model: oscillator\nstop: {d: 1,\n weight: [0, 0]}\n", "weight", 1, 3},
        {"model: oscillator\nstops:\n- {d: 1}\n- {d: 1}\n", "stops", 0, 2},
        {"model: pipe\nwierd: 1\n", "wierd", 0, 2},
    };
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        saltus_scene scene;
        assert_int_equal(saltus_scene_parse(known[k].text, strlen(known[k].text), "s", &scene, &message),
                         SALTUS_BAD_INPUT);
        if (strcmp(message.key, known[k].key) != 0 || message.stop != known[k].stop ||
            message.line != known[k].line)
            fail_msg("%s: key %s, stop %d, line %d", message.text, message.key, message.stop, message.line);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_tree_has_many_texts),
        cmocka_unit_test(values_know_their_places),
        cmocka_unit_test(refusals_have_their_line),
        cmocka_unit_test(several_values_are_told),
        cmocka_unit_test(texts_that_break_off_are_told),
        cmocka_unit_test(bounds_hold),
        cmocka_unit_test(damaged_texts_are_read_or_refused),
        cmocka_unit_test(messages_say_what_they_are_about),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
