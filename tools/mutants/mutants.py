"""Plants random mistakes in a copy of the sources, all in one build, and sees which the tests catch.

Every mutant is an expression that asks at run time whether it is the one to go wrong. The build is run once without
a mistake, each test case by itself, to learn how long it takes and which mutants it reaches; then every mutant is
run against the cases that reach it, the shortest first, until one fails.
SPDX-License-Identifier: GPL-3.0-or-later
"""

import argparse
import concurrent.futures
import itertools
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from sites import Finder

ROOMS = ("base", "signal", "system", "scene", "flow", "map", "orbit", "branch", "motion", "sweep", "record",
         "figure")
MUST_REACH = ("flow", "orbit", "motion", "sweep")
COPIED = ("CMakeLists.txt", "CMakePresets.json", "src", "include", "tools", "tests", "data")

SELECTOR_H = """#ifndef SALTUS_MUTANT_H
#define SALTUS_MUTANT_H
extern int saltus_mutant;
extern unsigned char *saltus_mutant_reached;
#define SALTUS_MUTANT(k) (saltus_mutant_reached[k] = 1, saltus_mutant == (k))
#endif
"""
# Marks go to a shared file, so that those of a process that is killed are kept, too.
SELECTOR_C = """#include "saltus_mutant.h"
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>
enum { room = %d };
static unsigned char nowhere[room];
int saltus_mutant = -1;
unsigned char *saltus_mutant_reached = nowhere;
extern void cmocka_set_test_filter(const char *pattern) __attribute__((weak));
__attribute__((constructor)) static void saltus_mutant_choose(void) {
    const char *number = getenv("SALTUS_MUTANT"), *path = getenv("SALTUS_MUTANTS_REACHED");
    const char *only = getenv("SALTUS_MUTANTS_CASE");
    if (number)
        saltus_mutant = atoi(number);
    if (only && cmocka_set_test_filter)
        cmocka_set_test_filter(only);
    int file = path ? open(path, O_RDWR) : -1;
    if (file >= 0) {
        void *marks = mmap(NULL, room, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
        if (marks != MAP_FAILED)
            saltus_mutant_reached = marks;
        close(file);
    }
}
"""


def run(command, **options):
    return subprocess.run(command, capture_output=True, text=True, errors="replace", **options)


def find_sites(root, build):
    """All mutants there could be, by room."""
    configured = run(["cmake", "-S", root, "-B", build, "-G", "Ninja", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON",
                      "-DSALTUS_ALL_ISAS=OFF", "-DCMAKE_C_FLAGS=-march=native"])
    if configured.returncode:
        raise SystemExit("mutants: cmake failed:\n" + configured.stderr)
    rooms = {f"src/{room}/": room for room in ROOMS if os.path.isdir(os.path.join(root, "src", room))}
    rooms["tools/"] = "commands"
    finder = Finder(os.path.realpath(root), rooms)
    with open(os.path.join(build, "compile_commands.json")) as stream:
        commands = json.load(stream)
    done = set()
    include = run(["clang", "-print-resource-dir"]).stdout.strip() + "/include"
    for entry in commands:
        file = os.path.relpath(entry["file"], root)
        part = re.match(r"tools/[^/]+\.c$|src/[a-z]+/", file)
        flags = [word for word in entry["command"].split() if re.match(r"-(D|I|isystem|std|march)", word)]
        if not part or (file, tuple(flags)) in done:
            continue
        done.add((file, tuple(flags)))
        words = entry["command"].split()
        for at, word in enumerate(words):
            if word == "-isystem":
                flags += ["-isystem", words[at + 1]]
        flags = [f.replace('\\"', '"') for f in flags if f != "-isystem"] + ["-isystem", include]
        finder.parse(entry["file"], [f.strip("'") for f in flags])
    sites = defaultdict(list)
    for mutant in finder.found:
        if not re.match(r"tools/[a-z]+/", mutant.file):
            sites[next(rooms[folder] for folder in rooms if mutant.file.startswith(folder))].append(mutant)
    return sites, finder


def deal(sites, seed):
    """An endless deal: one room after the other, in it one kind after the other, each mutant once."""
    shuffler = random.Random(seed)
    hands = {}
    for room in sorted(sites):
        kinds = defaultdict(list)
        for mutant in sorted(sites[room], key=lambda m: (m.file, m.start, m.end, m.kind, m.shown)):
            kinds[mutant.kind].append(mutant)
        order = sorted(kinds)
        shuffler.shuffle(order)
        for kind in order:
            shuffler.shuffle(kinds[kind])
        rounds = itertools.zip_longest(*(kinds[kind] for kind in order))
        hands[room] = iter([m for one in rounds for m in one if m])
    while hands:
        for room in list(hands):
            try:
                yield room, next(hands[room])
            except StopIteration:
                del hands[room]


def choose(sites, seed, count, refused):
    """`count` mutants on lines of their own, none of them refused by the compiler before."""
    chosen, lines, line_of = [], set(), set()
    for room, mutant in deal(sites, seed):
        if len(chosen) == count:
            break
        spans = {(mutant.file, mutant.line + k) for k in range(mutant.text.count("\n") + 1)}
        if mutant in refused or spans & lines:
            continue
        lines |= spans
        chosen.append((room, mutant))
    return chosen


def write_tree(root, tree, chosen, finder):
    """A copy of the sources with all mutants in it; files that did not change keep their time."""
    edits = defaultdict(list)
    for number, (_, mutant) in enumerate(chosen):
        edits[mutant.file].append((mutant.start, mutant.end, mutant.text.replace("@", str(number), 1)))
    os.makedirs(tree, exist_ok=True)
    wanted = set()
    for top in COPIED:
        path = os.path.join(root, top)
        names = [top] if os.path.isfile(path) else [
            os.path.relpath(os.path.join(folder, name), root)
            for folder, _, files in os.walk(path) for name in files]
        for name in names:
            with open(os.path.join(root, name), "rb") as stream:
                text = stream.read()
            for start, end, new in sorted(edits.get(name, []), reverse=True):
                text = text[:start] + new.encode() + text[end:]
            put(os.path.join(tree, name), text, os.stat(os.path.join(root, name)).st_mode)
            wanted.add(name)
    put(os.path.join(tree, "src/base/saltus_mutant.h"), SELECTOR_H.encode(), 0o644)
    put(os.path.join(tree, "src/base/saltus_mutant.c"), (SELECTOR_C % max(len(chosen), 1)).encode(), 0o644)
    for top in ("src", "tests"):
        for folder, _, files in os.walk(os.path.join(tree, top)):
            for name in files:
                path = os.path.join(folder, name)
                if os.path.relpath(path, tree) not in wanted and "saltus_mutant" not in name:
                    os.remove(path)


def written_lines(chosen, finder):
    """The line of each mutant in the tree: those before it in its file may have made that longer."""
    def longer(mutant):
        return mutant.text.count("\n") - finder.source(mutant.file)[mutant.start:mutant.end].count(b"\n")

    return [mutant.line + sum(longer(m) for _, m in chosen if m.file == mutant.file and m.start < mutant.start)
            for _, mutant in chosen]


def put(path, text, mode):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    try:
        with open(path, "rb") as stream:
            if stream.read() == text:
                return
    except FileNotFoundError:
        pass
    with open(path, "wb") as stream:
        stream.write(text)
    os.chmod(path, mode)


def build(tree, into):
    """Build the tests of a tree. Returns the lines that the compiler refused, as (file, line)."""
    launcher = ["-DCMAKE_C_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    flags = f"-O2 -march=native -w -fsanitize=leak -include {tree}/src/base/saltus_mutant.h"
    configured = run(["cmake", "-S", tree, "-B", into, "-G", "Ninja", "-DSALTUS_ALL_ISAS=OFF", "-DSALTUS_TESTS=ON",
                      f"-DCMAKE_C_FLAGS={flags}", "-DCMAKE_C_FLAGS_RELEASE=-DNDEBUG",
                      "-DCMAKE_EXE_LINKER_FLAGS=-Wl,-u,saltus_mutant", *launcher])
    if configured.returncode:
        raise SystemExit("mutants: cmake failed:\n" + configured.stderr)
    made = run(["cmake", "--build", into, "--", "-k", "0"])
    if made.returncode == 0:
        return set()
    refused = {(os.path.relpath(os.path.realpath(os.path.join(into, file)), os.path.realpath(tree)), int(line))
               for file, line in re.findall(r"^(\S+?):(\d+):\d+: (?:fatal )?error:", made.stdout, re.M)}
    if not refused:
        raise SystemExit("mutants: the build failed:\n" + made.stdout[-4000:])
    return refused


def list_tests(into):
    """(name, command, folder, environment) of every test, the cases of cmocka programs one by one."""
    listed = json.loads(run(["ctest", "--test-dir", into, "--show-only=json-v1"]).stdout)
    tests = []
    for test in listed["tests"]:
        properties = {p["name"]: p["value"] for p in test.get("properties", [])}
        folder = properties.get("WORKING_DIRECTORY", into)
        pattern = properties.get("PASS_REGULAR_EXPRESSION", [])
        command = test.get("command")
        source = os.path.join(os.path.dirname(into), "tree", "tests", test["name"] + ".c")
        cases = []
        if os.path.exists(source):
            with open(source) as stream:
                text = stream.read()
            cases = re.findall(r"cmocka_unit_test\w*\(\s*(\w+)", text) if "cmocka_unit_test(test_##" not in text else []
        for case in cases or [None]:
            tests.append({"name": test["name"] + (f":{case}" if case else ""), "command": command, "folder": folder,
                          "case": case, "pattern": pattern})
    return tests


def attempt(test, mutant, limit, reached=None):
    """Run a test. Returns (passed, seconds, what it said)."""
    with tempfile.TemporaryDirectory() as place:
        environment = dict(os.environ, TMPDIR=place, CMOCKA_TEST_ABORT="1", SALTUS_MUTANT=str(mutant))
        if test["case"]:
            environment["SALTUS_MUTANTS_CASE"] = test["case"]
        if reached:
            environment["SALTUS_MUTANTS_REACHED"] = reached
        begin = time.monotonic()
        with open(os.path.join(place, "said"), "w+", errors="replace") as said:
            child = subprocess.Popen(test["command"], cwd=test["folder"], env=environment, stdin=subprocess.DEVNULL,
                                     stdout=said, stderr=subprocess.STDOUT, start_new_session=True)
            try:
                status = child.wait(limit)
            except subprocess.TimeoutExpired:
                os.killpg(child.pid, 9)
                child.wait()
                status = None
            said.seek(0)
            text = said.read()
    passed = status == 0
    if passed and test["pattern"]:
        passed = any(re.search(p, text, re.S) for p in test["pattern"])
    if passed and test["case"]:
        passed = "[  PASSED  ] 1 test(s)" in text
    return passed, time.monotonic() - begin, text if status is not None else "no end"


def survey(tests, count, jobs):
    """Every test without a mistake: its time and the mutants it reaches. Returns those that pass."""
    def one(test):
        with tempfile.NamedTemporaryFile() as marks:
            marks.truncate(count)
            passed, seconds, text = attempt(test, -1, 900, marks.name)
            marks.seek(0)
            reached = {k for k, mark in enumerate(marks.read()) if mark}
        return dict(test, passed=passed, seconds=seconds, reached=reached, said=text)

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        done = list(pool.map(one, tests))
    for test in done:
        if not test["passed"]:
            print(f"left out, it fails without a mistake: {test['name']}", flush=True)
    return sorted((t for t in done if t["passed"]), key=lambda t: t["seconds"])


def judge(number, tests):
    """(killed, survived or not reached, the test that killed it)"""
    reaching = [t for t in tests if number in t["reached"]]
    if not reaching:
        return "not reached", ""
    for test in reaching:
        passed, _, text = attempt(test, number, 10 + 5 * test["seconds"])
        if not passed:
            return "killed", test["name"] + (" (no end)" if text == "no end" else "")
    return "survived", f"{len(reaching)} tests"


def table(chosen, verdicts):
    rooms = defaultdict(Counter)
    kinds = defaultdict(Counter)
    for (room, mutant), (verdict, _) in zip(chosen, verdicts):
        for counter in (rooms[room], kinds[mutant.kind], rooms["all"]):
            counter[verdict] += 1
    lines = []
    for title, rows in (("room", rooms), ("kind", kinds)):
        lines += ["", f"| {title} | mutants | killed | survived | not reached | killed of reached |",
                  "| --- | --- | --- | --- | --- | --- |"]
        for name in sorted(rows, key=lambda n: (n == "all", n)):
            row = rows[name]
            reached = row["killed"] + row["survived"]
            share = f"{100 * row['killed'] / reached:.0f} %" if reached else "-"
            lines.append(f"| {name} | {sum(row.values())} | {row['killed']} | {row['survived']} | "
                         f"{row['not reached']} | {share} |")
    return lines


def main():
    parser = argparse.ArgumentParser(prog="tools/mutants.sh", description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=200, help="mutants (default 200)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default 1)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="tests run at once (default: all cores)")
    parser.add_argument("--rooms", help="only these, separated by commas")
    parser.add_argument("--tests", default="", help="only tests whose name matches this regular expression")
    parser.add_argument("--again", action="store_true",
                        help="run only those of this draw that were not killed the last time")
    parser.add_argument("--folder", default="build-mutants", help="where all is built (default build-mutants)")
    parser.add_argument("--list", action="store_true", help="print the mutants and stop")
    options = parser.parse_args()
    root, folder = os.getcwd(), os.path.abspath(options.folder)
    tree, into, report = (os.path.join(folder, name) for name in ("tree", "build", "report.txt"))
    os.makedirs(folder, exist_ok=True)

    sites, finder = find_sites(root, os.path.join(folder, "sites"))
    if options.rooms:
        sites = {room: sites[room] for room in options.rooms.split(",")}
    print("places: " + ", ".join(f"{room} {len(sites[room])}" for room in sorted(sites)), flush=True)
    refused = set()
    while True:
        chosen = choose(sites, options.seed, options.count, refused)
        if options.list:
            for room, mutant in chosen:
                print(f"{mutant.file}:{mutant.line}: {mutant.kind}: {mutant.shown}")
            return
        write_tree(root, tree, chosen, finder)
        bad = build(tree, into)
        if not bad:
            break
        out = {mutant for (_, mutant), line in zip(chosen, written_lines(chosen, finder))
               if any((mutant.file, line + k) in bad for k in range(mutant.text.count("\n") + 1))}
        if not out:
            raise SystemExit(f"mutants: no mutant stands at {sorted(bad)}")
        refused |= out
        print(f"{len(out)} do not compile and are replaced", flush=True)

    results = os.path.join(folder, f"results-{options.seed}.json")
    before = {}
    if options.again and os.path.exists(results):
        with open(results) as stream:
            before = json.load(stream)
    keys = [mutant.key(finder.source(mutant.file)) for _, mutant in chosen]
    begin = time.monotonic()
    print("built; every test by itself ...", flush=True)
    tests = survey([t for t in list_tests(into) if re.search(options.tests, t["name"])], len(chosen), options.jobs)
    print(f"{len(tests)} test cases, {sum(t['seconds'] for t in tests):.0f} s one after the other", flush=True)

    def one(number):
        if before.get(keys[number], [""])[0] == "killed":
            return before[keys[number]]
        verdict = judge(number, tests)
        _, mutant = chosen[number]
        print(f"{number:4} {verdict[0]:11} {mutant.file}:{mutant.line}: {mutant.kind}: {mutant.shown[:140]}"
              f"  [{verdict[1]}]", flush=True)
        return verdict

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        verdicts = list(pool.map(one, range(len(chosen))))
    with open(results, "w") as stream:
        json.dump(dict(zip(keys, verdicts)), stream, indent=1)

    lines = [f"{len(chosen)} mutants, seed {options.seed}, {len(tests)} test cases, "
             f"{(time.monotonic() - begin) / 60:.0f} min"] + table(chosen, verdicts)
    for verdict in ("survived", "not reached"):
        lines += ["", f"{verdict}:"]
        lines += [f"{m.file}:{m.line}: {m.kind}: {m.shown}" for (room, m), v in zip(chosen, verdicts)
                  if v[0] == verdict]
    with open(report, "w") as stream:
        stream.write("\n".join(lines) + "\n")
    print("\n".join(lines))
    unreached = {room for (room, _), v in zip(chosen, verdicts) if v[0] == "not reached"} & set(MUST_REACH)
    if unreached:
        print(f"mutants: not all are reached in {', '.join(sorted(unreached))}")


if __name__ == "__main__":
    main()
