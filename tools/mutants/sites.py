"""Where in C sources a small mistake can be made, and which: the places found by clang's parser.

A mutant is a replacement of a range of bytes of a file by an expression that chooses between the mistake and
what stood there, at run time, so that all mutants share one build.
SPDX-License-Identifier: GPL-3.0-or-later
"""

import os
import re
from dataclasses import dataclass, field

from clang.cindex import CursorKind as Kind
from clang.cindex import Index, StorageClass, TranslationUnitLoadError, TypeKind

ARITHMETIC = {"+": ["-"], "-": ["+"], "*": ["/"], "/": ["*"], "%": ["*"]}
RELATIONAL = {
    "<": ["<=", ">", ">="],
    "<=": ["<", ">"],
    ">": [">=", "<", "<="],
    ">=": [">", "<"],
    "==": ["!="],
    "!=": ["=="],
}
LOGICAL = {"&&": ["||"], "||": ["&&"]}
COMPOUND = {"+=": ["-="], "-=": ["+="], "*=": ["/="], "/=": ["*="], "|=": ["&="], "&=": ["|="]}
NUMBER = re.compile(r"^(\d[\d.eE+-]*|\.\d[\deE+-]*|0[xX][0-9a-fA-F]+)([uUlLfF]*)$")

SYMMETRIC = re.compile(r"(^calloc|^strcmp|distance|^strncmp|^memcmp|fma|fnma|smaller|larger|min|max|hypot|_add|_mul)$")


@dataclass(frozen=True)
class Mutant:
    """One mistake: in `file`, bytes start..end become `text` with the chooser's number in place of @."""

    file: str
    line: int
    start: int
    end: int
    kind: str
    text: str
    shown: str  # what the mistake is, for people

    def key(self, source):
        """What names it in the next run, as long as its line is as it was."""
        line = source[source.rfind(b"\n", 0, self.start) + 1 : source.find(b"\n", self.end)]
        return "|".join((self.file, self.kind, self.shown, line.decode(errors="replace").strip()))


@dataclass
class Place:
    """The state of the walk down a syntax tree."""

    constant: bool = False  # only constants may stand here
    result_void: bool = False
    statements: bool = False  # the node stands among the statements of a block


@dataclass
class Finder:
    root: str
    rooms: dict  # folder -> room
    found: list = field(default_factory=list)
    seen: set = field(default_factory=set)
    sources: dict = field(default_factory=dict)

    def source(self, file):
        if file not in self.sources:
            with open(os.path.join(self.root, file), "rb") as stream:
                self.sources[file] = stream.read()
        return self.sources[file]

    def parse(self, path, arguments):
        try:
            unit = Index.create().parse(path, args=arguments)
        except TranslationUnitLoadError:
            raise SystemExit(f"mutants: {path}: clang cannot parse it")
        for cursor in unit.cursor.get_children():
            if cursor.kind != Kind.FUNCTION_DECL or not cursor.is_definition() or not cursor.location.file:
                continue
            file = os.path.relpath(os.path.realpath(cursor.location.file.name), self.root)
            if not any(file.startswith(folder) for folder in self.rooms):
                continue
            mark = (file, cursor.extent.start.offset)
            if mark in self.seen:
                continue
            self.seen.add(mark)
            place = Place(result_void=cursor.result_type.kind == TypeKind.VOID)
            for child in cursor.get_children():
                if child.kind == Kind.COMPOUND_STMT:
                    self.walk(child, file, place)

    def text(self, file, start, end):
        return self.source(file)[start:end].decode()

    def add(self, file, cursor, kind, text, shown, start=None, end=None):
        start = cursor.extent.start.offset if start is None else start
        end = cursor.extent.end.offset if end is None else end
        line = self.source(file).count(b"\n", 0, start) + 1
        self.found.append(Mutant(file, line, start, end, kind, text, " ".join(shown.split())))

    def choose(self, file, cursor, kind, mistake):
        """An expression: the mistake or what stood there."""
        old = self.text(file, cursor.extent.start.offset, cursor.extent.end.offset)
        self.add(file, cursor, kind, f"(SALTUS_MUTANT(@) ? ({mistake}) : ({old}))", f"{old} -> {mistake}")

    def walk(self, cursor, file, place):
        kind = cursor.kind
        if not cursor.location.file or not cursor.location.file.name.endswith(os.path.basename(file)):
            return  # a list that lives in another file
        children = list(cursor.get_children())
        if not place.constant:
            self.look(cursor, children, file)
        if place.statements:
            self.statement(cursor, file, place)
        for number, child in enumerate(children):
            below = Place(place.constant, place.result_void, kind == Kind.COMPOUND_STMT)
            if kind == Kind.CASE_STMT and number == 0:
                below.constant = True
            if kind == Kind.VAR_DECL:
                static = cursor.storage_class == StorageClass.STATIC
                text = self.text(file, cursor.extent.start.offset, child.extent.start.offset)
                below.constant = static or "=" not in text
            if kind == Kind.CXX_UNARY_EXPR:  # sizeof
                below.constant = True
            self.walk(child, file, below)

    def look(self, cursor, children, file):
        kind = cursor.kind
        start, end = cursor.extent.start.offset, cursor.extent.end.offset
        text = self.text(file, start, end)
        if kind in (Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR) and len(children) == 2:
            left = self.text(file, start, children[0].extent.end.offset)
            right = self.text(file, children[1].extent.start.offset, end)
            operator = self.text(file, children[0].extent.end.offset, children[1].extent.start.offset).strip()
            if not left or not right or not text.startswith(left):
                return
            for name, table in (("arithmetic", ARITHMETIC), ("relational", RELATIONAL), ("logical", LOGICAL)):
                for other in table.get(operator, ()):
                    self.choose(file, cursor, name, f"{left} {other} {right}")
            if operator in LOGICAL:
                self.choose(file, cursor, "condition dropped", left)
                self.choose(file, cursor, "condition dropped", right)
            for other in COMPOUND.get(operator, ()):
                self.choose(file, cursor, "arithmetic", f"{left} {other} {right}")
        elif kind == Kind.UNARY_OPERATOR and len(children) == 1:
            operand = self.text(file, children[0].extent.start.offset, children[0].extent.end.offset)
            if text.startswith("-") and not NUMBER.match(operand.strip()):
                self.choose(file, cursor, "arithmetic", operand)
            elif text.startswith("!"):
                self.choose(file, cursor, "logical", operand)
        elif kind in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL):
            self.number(cursor, file, text)
        elif kind == Kind.IF_STMT and children:
            self.choose(file, children[0], "condition dropped", "1")
            self.choose(file, children[0], "condition dropped", "0")
        elif kind == Kind.MEMBER_REF_EXPR:
            self.member(cursor, file, text)
        elif kind == Kind.CALL_EXPR:
            self.arguments(cursor, file, start, end)

    def number(self, cursor, file, text):
        match = NUMBER.match(text)
        if not match:
            return
        body, suffix = match.groups()
        if cursor.kind == Kind.FLOATING_LITERAL:
            value = float(body)
            for mistake in {value * 2, value / 2 if value else 1.0, -value if value else -1.0}:
                self.choose(file, cursor, "constant", repr(mistake) + suffix)
        else:
            value = int(body, 16) if body[:2] in ("0x", "0X") else int(body, 10)
            for mistake in {value + 1, value - 1 if value else 2, 0 if value > 1 else value + 1}:
                if not (mistake < 0 and "u" in suffix.lower()):
                    self.choose(file, cursor, "constant", str(mistake) + suffix)

    def member(self, cursor, file, text):
        """Another field of the same type. Its address is chosen, so that it may be assigned to."""
        member = cursor.referenced
        if member is None or member.kind != Kind.FIELD_DECL or member.is_bitfield():
            return
        own = member.type.get_canonical()
        name = member.spelling
        if not text.endswith(name) or own.kind in (TypeKind.CONSTANTARRAY, TypeKind.RECORD):
            return
        fields = [f for f in member.semantic_parent.get_children() if f.kind == Kind.FIELD_DECL and f.spelling]
        others = [f.spelling for f in fields if f.spelling != name and not f.is_bitfield()
                  and f.type.get_canonical().spelling == own.spelling]
        stem = text[: -len(name)]
        for other in others:
            self.add(file, cursor, "wrong field",
                     f"(*(SALTUS_MUTANT(@) ? &({stem}{other}) : &({text})))", f"{text} -> {stem}{other}")

    def arguments(self, cursor, file, start, end):
        """Two neighbours of one type change places; where their order does not matter there is no mistake."""
        given = [] if SYMMETRIC.search(cursor.spelling) else list(cursor.get_arguments())
        for first, second in zip(given, given[1:]):
            types = {a.type.get_canonical().spelling.replace("const ", "") for a in (first, second)}
            a = self.text(file, first.extent.start.offset, first.extent.end.offset)
            b = self.text(file, second.extent.start.offset, second.extent.end.offset)
            if len(types) != 1 or a == b or not a or not b or '"' in a + b or first.extent.end.offset > second.extent.start.offset:
                continue
            swapped = (self.text(file, start, first.extent.start.offset) + b
                       + self.text(file, first.extent.end.offset, second.extent.start.offset) + a
                       + self.text(file, second.extent.end.offset, end))
            self.choose(file, cursor, "swapped arguments", swapped)

    def statement(self, cursor, file, place):
        """A statement of a block that can be left out."""
        start, end = cursor.extent.start.offset, cursor.extent.end.offset
        text = self.text(file, start, end)
        shown = text if len(text) < 80 else text[:77] + "..."
        assignment = cursor.kind in (Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR, Kind.CALL_EXPR)
        plain = cursor.kind == Kind.UNARY_OPERATOR and ("++" in text or "--" in text)
        leaves = cursor.kind in (Kind.CONTINUE_STMT, Kind.BREAK_STMT)
        leaves = leaves or (cursor.kind == Kind.RETURN_STMT and place.result_void)
        if assignment or plain or leaves:
            self.add(file, cursor, "statement deleted", "if (!SALTUS_MUTANT(@)) " + text, "deleted: " + shown)
