/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/expression.h"

#include "base/word.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    saltus_operation operation;
    int least, most;
} functions[] = {
#define ENTRY(name, operation, least, most) {#name, SALTUS_OP_##operation, least, most},
    SALTUS_FUNCTIONS(ENTRY)
#undef ENTRY
};

/* Binary operators. The right operand extends over operators that bind at least as strongly as `right`. */
static const struct {
    char symbol[3];
    saltus_syntax kind;
    int left, right;
} operators[] = {
    {"<=", SALTUS_SYNTAX_LESS_EQUAL, 1, 2}, {">=", SALTUS_SYNTAX_GREATER_EQUAL, 1, 2},
    {"==", SALTUS_SYNTAX_EQUAL, 1, 2},      {"!=", SALTUS_SYNTAX_UNEQUAL, 1, 2},
    {"<", SALTUS_SYNTAX_LESS, 1, 2},        {">", SALTUS_SYNTAX_GREATER, 1, 2},
    {"+", SALTUS_SYNTAX_ADD, 3, 4},         {"-", SALTUS_SYNTAX_SUBTRACT, 3, 4},
    {"*", SALTUS_SYNTAX_MULTIPLY, 5, 6},    {"/", SALTUS_SYNTAX_DIVIDE, 5, 6},
    {"^", SALTUS_SYNTAX_POWER, 9, 7},
};

/* Signs bind weaker than powers and stronger than products: -x^2 is -(x^2); x^-2 and 2*-x are possible. */
enum { sign_binds = 7 };

/* A text being parsed. */
typedef struct parser {
    saltus_expression *made;
    int place, room, depth;
    saltus_status status;
    saltus_message *message;
} parser;

/* Report a parse error. Returns -1, which stands for no term. */
static int refuse(parser *self, int place, const char *complaint) {
    self->status = saltus_fail(self->message, SALTUS_BAD_INPUT, "column %d: %s", place + 1, complaint);
    return -1;
}

static bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

static const char *rest_of(parser *self) {
    while (self->made->text[self->place] && strchr(" \t\r\n", self->made->text[self->place]))
        self->place++;
    return self->made->text + self->place;
}

static int add_term(parser *self, saltus_syntax kind, int begin, int length, int first) {
    saltus_expression *made = self->made;
    if (made->count == self->room) {
        int room = 2 * self->room + 16;
        saltus_expression_term *terms = realloc(made->terms, (size_t)room * sizeof *terms);
        if (!terms) {
            self->status = saltus_fail(self->message, SALTUS_NO_MEMORY, "no memory for an expression");
            return -1;
        }
        made->terms = terms;
        self->room = room;
    }
    made->terms[made->count] =
        (saltus_expression_term){.kind = kind, .begin = begin, .length = length, .first = first, .next = -1};
    return made->count++;
}

static bool is_comparison(const parser *self, int term) {
    return self->made->terms[term].kind >= SALTUS_SYNTAX_LESS;
}

static int parse_operand(parser *self, int binds);

/* Parse an expression that is a number, not a comparison. */
static int parse_number_valued(parser *self, int binds) {
    int begin = (int)(rest_of(self) - self->made->text), term = parse_operand(self, binds);
    if (term >= 0 && is_comparison(self, term))
        return refuse(self, begin, "a comparison can only be the first argument of if");
    return term;
}

/* Parse a decimal number, with a point in any locale. */
static int parse_number(parser *self) {
    const char *text = self->made->text + self->place, *c = text;
    char digits[64], *end;
    while (is_digit(*c))
        c++;
    const char *point = *c == '.' ? c++ : NULL;
    while (is_digit(*c))
        c++;
    if (c == text + (point != NULL))
        return refuse(self, self->place, "a number has no digits");
    if ((*c == 'e' || *c == 'E') && is_digit(c[1 + (c[1] == '-' || c[1] == '+')]))
        for (c += 2; is_digit(*c);)
            c++;
    int length = (int)(c - text);
    const char *mark = localeconv()->decimal_point;
    if ((size_t)length + strlen(mark) >= sizeof digits)
        return refuse(self, self->place, "a number has too many digits");
    int before = point ? (int)(point - text) : length;
    snprintf(digits, sizeof digits, "%.*s%s%.*s", before, text, point ? mark : "",
             point ? length - before - 1 : 0, point ? point + 1 : "");
    double value = strtod(digits, &end);
    if (!isfinite(value))
        return refuse(self, self->place, "the number is too large");
    if (is_letter(*c))
        return refuse(self, self->place + length, "an operator is missing between a number and a name");
    const int term = add_term(self, SALTUS_SYNTAX_NUMBER, self->place, length, -1);
    self->place += length;
    if (term >= 0)
        self->made->terms[term].number = value;
    return term;
}

/* Parse arguments up to the closing bracket, chained to the term. Returns their number, 0 after an error. */
static int parse_arguments(parser *self, int term, char closing) {
    int count = 0, last = -1, opened = self->place - 1;
    const bool chooses = self->made->terms[term].kind == SALTUS_SYNTAX_CALL &&
                         self->made->terms[term].function == SALTUS_FUNCTION_if;
    for (;;) {
        int argument = chooses && count == 0 ? parse_operand(self, 0) : parse_number_valued(self, 0);
        if (argument < 0)
            return 0;
        if (chooses && count == 0 && !is_comparison(self, argument))
            return refuse(self, opened + 1, "the first argument of if must be a comparison, such as x < 0"),
                   0;
        *(last < 0 ? &self->made->terms[term].first : &self->made->terms[last].next) = argument;
        last = argument;
        count++;
        char c = *rest_of(self);
        if (c == closing) {
            self->place++;
            return count;
        }
        if (c != ',')
            return refuse(self, c ? self->place : opened,
                          c                ? "a comma, an operator or a closing bracket is expected"
                          : closing == ')' ? "this parenthesis is not closed"
                                           : "this bracket is not closed"),
                   0;
        self->place++;
    }
}

static int parse_call(parser *self, int begin, int length) {
    const char *names[SALTUS_FUNCTION_COUNT];
    char name[32], complaint[160];
    int k = 0;
    for (int j = 0; j < SALTUS_FUNCTION_COUNT; j++)
        names[j] = functions[j].name;
    snprintf(name, sizeof name, "%.*s", length, self->made->text + begin);
    while (k < SALTUS_FUNCTION_COUNT && strcmp(names[k], name) != 0)
        k++;
    if (k == SALTUS_FUNCTION_COUNT) {
        const char *meant = saltus_nearest_word(name, names, SALTUS_FUNCTION_COUNT);
        snprintf(complaint, sizeof complaint, "there is no function of this name; %s%s%s",
                 meant ? "did you mean " : "a product needs a *", meant ? meant : "", meant ? "?" : "");
        return refuse(self, begin, complaint);
    }
    const int term = add_term(self, SALTUS_SYNTAX_CALL, begin, length, -1);
    if (term >= 0)
        self->made->terms[term].function = (saltus_function)k;
    const int count = term < 0 ? 0 : parse_arguments(self, term, ')');
    if (count == 0)
        return -1;
    if (count >= functions[k].least && count <= functions[k].most)
        return term;
    snprintf(complaint, sizeof complaint, "%s takes %d%s argument%s, not %d", functions[k].name,
             functions[k].least, functions[k].most > functions[k].least ? " or more" : "",
             functions[k].least == 1 && functions[k].most == 1 ? "" : "s", count);
    return refuse(self, begin, complaint);
}

/* Parse a name (x, x[i], x', x[i]' or, for use in shells, x_dot) or a function call. */
static int parse_name(parser *self) {
    const char *text = self->made->text;
    int begin = self->place, end = begin;
    while (is_letter(text[end]) || is_digit(text[end]))
        end++;
    self->place = end;
    if (*rest_of(self) == '(') {
        self->place++;
        return parse_call(self, begin, end - begin);
    }
    bool dotted = end - begin > 4 && memcmp(text + end - 4, "_dot", 4) == 0;
    const int term = add_term(self, SALTUS_SYNTAX_NAME, begin, end - begin - (dotted ? 4 : 0), -1);
    if (term >= 0)
        self->made->terms[term].rate = dotted;
    if (term >= 0 && *rest_of(self) == '[') {
        self->place++;
        if (parse_arguments(self, term, ']') == 0)
            return -1;
    }
    if (term >= 0 && *rest_of(self) == '\'') {
        if (dotted)
            return refuse(self, self->place, "a rate has no rate of its own");
        self->place++;
        self->made->terms[term].rate = true;
    }
    return term;
}

static int parse_first(parser *self) {
    const char *c = rest_of(self);
    if (*c == '(') {
        int opened = self->place++, term = parse_number_valued(self, 0);
        if (term >= 0 && *rest_of(self) != ')')
            return refuse(self, *rest_of(self) ? self->place : opened,
                          *rest_of(self) ? "an operator or a closing parenthesis is expected"
                                         : "this parenthesis is not closed");
        self->place++;
        return term;
    }
    if (*c == '-' || *c == '+') {
        int begin = self->place++, operand = parse_number_valued(self, sign_binds);
        if (operand < 0 || *c == '+')
            return operand;
        return add_term(self, SALTUS_SYNTAX_NEGATE, begin, 1, operand);
    }
    if (is_digit(*c) || *c == '.')
        return parse_number(self);
    if (is_letter(*c))
        return parse_name(self);
    return refuse(self, self->place,
                  *c ? "a number, a name or a parenthesis is expected" : "the expression ends too early");
}

/* Parse operands joined by operators that bind at least as strongly as `binds`. */
static int parse_operand(parser *self, int binds) {
    enum { count = sizeof operators / sizeof operators[0] };
    if (++self->depth > SALTUS_EXPRESSION_DEPTH_MAX)
        return refuse(self, self->place, "the expression is nested too deeply");
    int left = parse_first(self);
    while (left >= 0) {
        const char *c = rest_of(self);
        int k = 0, begin = self->place;
        while (k < count && strncmp(c, operators[k].symbol, strlen(operators[k].symbol)) != 0)
            k++;
        if (k == count || operators[k].left < binds)
            break;
        if (is_comparison(self, left))
            return refuse(self, begin, "a comparison cannot be compared");
        const int length = (int)strlen(operators[k].symbol);
        self->place += length;
        int right = parse_number_valued(self, operators[k].right);
        if (right < 0)
            return -1;
        self->made->terms[left].next = right;
        left = add_term(self, operators[k].kind, begin, length, left);
    }
    self->depth--;
    return left;
}

saltus_status saltus_expression_parse(const char *text, saltus_expression *expression,
                                      saltus_message *message) {
    parser self = {.made = expression, .message = message};
    *expression = (saltus_expression){.text = text, .root = -1};
    if (strlen(text) > SALTUS_EXPRESSION_BYTES_MAX)
        return saltus_fail(message, SALTUS_BAD_INPUT, "an expression of more than %d characters",
                           SALTUS_EXPRESSION_BYTES_MAX);
    int root = parse_number_valued(&self, 0);
    if (root >= 0 && *rest_of(&self))
        refuse(&self, self.place,
               *rest_of(&self) == '=' ? "= cannot stand here; equality is ==" : "an operator is expected");
    if (self.status != SALTUS_OK)
        saltus_expression_clear(expression);
    else
        expression->root = root;
    return self.status;
}

void saltus_expression_clear(saltus_expression *expression) {
    free(expression->terms);
    *expression = (saltus_expression){.root = -1};
}

const char *saltus_function_name(saltus_function function) {
    return functions[function].name;
}

saltus_operation saltus_function_operation(saltus_function function) {
    return functions[function].operation;
}
