#!/bin/sh
# The order of rooms and of files: a file includes and calls only what lies in its own room or in one above it in
# src/README.md's table, and no files of a room depend on one another in a circle. A public header belongs to the room that
# defines its functions. A type's name has one meaning in the library; names without its prefix are a file's own.
# Arguments: the folder of the sources, the library's object files.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
LC_ALL=C
export LC_ALL

# Who calls whom: lines "FILE FILE SYMBOL" and "defines FILE SYMBOL", files as room/name. Stdin: what nm -A -g tells of
# all objects.
calls() {
    awk '$NF ~ /^saltus_/ {
        file = $1
        sub(/\.o:.*/, "", file)
        count = split(file, part, "/")
        file = part[count - 1] "/" part[count]
        if ($(NF - 1) == "U")
            needs[file " " $NF]
        else
            home[$NF] = file
    }
    END {
        for (need in needs) {
            split(need, part, " ")
            if (part[2] in home && home[part[2]] != part[1])
                print part[1], home[part[2]], part[2]
        }
        for (symbol in home)
            print "defines", home[symbol], symbol
    }'
}

# Who includes whom: lines "FILE FILE included", and "declares HEADER SYMBOL" for public headers, which are saltus/name.
# Argument: the folder of the sources.
includes() {
    (cd "$1/src" && awk -F '[<">]' '/^#include ("|<saltus\/)/ {print FILENAME, $2, "included"}' */*.[ch])
    (cd "$1/include" && awk -F '[<">]' '
        /^#include ("|<saltus\/)/ {print FILENAME, $2, "included"}
        {for (line = $0; match(line, /saltus_[a-z0-9_]*\(/); line = substr(line, RSTART + RLENGTH))
            print "declares", FILENAME, substr(line, RSTART, RLENGTH - 1)}' saltus/*.h)
}

# Names that more than one file gives to a type. Argument: the folder of the sources.
types() {
    (cd "$1" && awk '
        match($0, /(struct|enum|union) saltus_[a-z0-9_]+ *\{/) ||
        match($0, /^\} saltus_[a-z0-9_]+;/) {
            name = substr($0, RSTART, RLENGTH)
            sub(/ *[{;]$/, "", name)
            sub(/^.* /, "", name)
            if (!((name, FILENAME) in seen))
                files[name] = files[name] " " FILENAME
            if (!((name, FILENAME) in seen) && count[name]++ == 1)
                twice[++names] = name
            seen[name, FILENAME]
        }
        END {
            for (i = 1; i <= names; i++)
                print twice[i] " has more than one meaning:" files[twice[i]]
        }' src/*/*.[ch] include/saltus/*.h)
}

# What is wrong with the dependencies on stdin. Argument: the rooms in their order.
judge() {
    sort | awk -v order="$1" '
    function room(file) {
        return file in owner ? owner[file] : substr(file, 1, index(file, "/") - 1)
    }
    # Mark all that a file leads to inside its room.
    function visit(start, file, below_it, count, i) {
        count = split(below[file], below_it, " ")
        for (i = 1; i <= count; i++)
            if (!((start, below_it[i]) in leads_to)) {
                leads_to[start, below_it[i]]
                visit(start, below_it[i])
            }
    }
    BEGIN {
        count = split(order, rooms, " ")
        for (i = 1; i <= count; i++)
            rank[rooms[i]] = i
    }
    $1 == "defines" {home[$3] = room($2); next}
    $1 == "declares" {declared[++declarations] = $2 " " $3; next}
    !(($1, $2) in why) {edge[++edges] = $1 " " $2}
    {why[$1, $2] = why[$1, $2] " " $3}
    END {
        for (i = 1; i <= declarations; i++) {
            split(declared[i], part, " ")
            if (!(part[2] in home))
                continue
            if (part[1] in owner && owner[part[1]] != home[part[2]])
                print part[1] " belongs to two rooms, " owner[part[1]] " and " home[part[2]] ": " part[2]
            owner[part[1]] = home[part[2]]
        }
        for (i = 1; i <= edges; i++) {
            split(edge[i], end, " ")
            if (end[1] == "saltus/saltus.h")
                continue
            if (!(room(end[1]) in rank) || !(room(end[2]) in rank))
                print end[1] " -> " end[2] ": not a room of the table"
            else if (rank[room(end[1])] < rank[room(end[2])])
                print end[1] " -> " end[2] " goes up:" why[end[1], end[2]]
            else if (room(end[1]) == room(end[2]))
                below[end[1]] = below[end[1]] " " end[2]
        }
        for (file in below)
            visit(file, file)
        for (i = 1; i <= edges; i++) {
            split(edge[i], end, " ")
            if ((end[2], end[1]) in leads_to)
                print end[1] " -> " end[2] " is part of a circle:" why[end[1], end[2]]
        }
    }'
}

# A made-up library in which all is wrong: three files and two headers in circles, calls and includes that go up, a
# header of two rooms, a file of no room, types of one name.
made=$(mktemp -d)
trap 'rm -rf "$made"' EXIT
mkdir -p "$made/src/low" "$made/src/high" "$made/src/more" "$made/include/saltus"
echo '#include "low/b.h"' >"$made/src/low/a.h"
echo '#include "low/a.h"' >"$made/src/low/b.h"
printf '#include "high/d.h"\n#include <saltus/high.h>\n' >"$made/src/low/c.c"
echo '#include "low/a.h"' >"$made/src/high/d.h"
echo '#include "high/d.h"' >"$made/src/more/e.h"
echo 'int saltus_d(void), saltus_e(void);' >"$made/include/saltus/high.h"
printf 'int saltus_a(void), saltus_d(void);\ntypedef struct saltus_g saltus_g;\n' >"$made/include/saltus/two.h"
printf 'typedef struct {\n    int f;\n} saltus_f;\nstruct saltus_g {\n    int g;\n};\n' >"$made/src/low/f.c"
printf 'typedef struct saltus_f {\n    int f;\n} saltus_f;\nstruct own {\n    int own;\n};\n' >"$made/src/high/f.c"
printf 'enum saltus_f { F };\nstruct own {\n    int own;\n};\n' >"$made/src/more/f.h"
expected="saltus/two.h belongs to two rooms, low and high: saltus_d
low/c.c -> high/d.c goes up: saltus_d
low/c.c -> high/d.h goes up: included
low/c.c -> saltus/high.h goes up: included
more/e.h -> high/d.h: not a room of the table
high/d.c -> high/e.c is part of a circle: saltus_e
high/e.c -> high/d.c is part of a circle: saltus_d
low/a.c -> low/b.c is part of a circle: saltus_b
low/a.h -> low/b.h is part of a circle: included
low/b.c -> low/c.c is part of a circle: saltus_c
low/b.h -> low/a.h is part of a circle: included
low/c.c -> low/a.c is part of a circle: saltus_a saltus_a2
saltus_f has more than one meaning: src/high/f.c src/low/f.c src/more/f.h"
found=$({
    includes "$made"
    calls <<END
x.dir/src/low/a.c.o:0000 T saltus_a
x.dir/src/low/a.c.o:0000 T saltus_a2
x.dir/src/low/a.c.o:          U saltus_b
x.dir/src/low/b.c.o:0000 T saltus_b
x.dir/src/low/b.c.o:          U saltus_c
x.dir/src/low/b.c.o:          U printf
x.dir/src/low/c.c.o:0000 T saltus_c
x.dir/src/low/c.c.o:          U saltus_a
x.dir/src/low/c.c.o:          U saltus_a2
x.dir/src/low/c.c.o:          U saltus_d
x.dir/src/high/d.c.o:0000 T saltus_d
x.dir/src/high/d.c.o:          U saltus_a
x.dir/src/high/d.c.o:          U saltus_e
x.dir/src/high/e.c.o:0000 T saltus_e
x.dir/src/high/e.c.o:          U saltus_d
END
} | judge "low high" && types "$made")
if [ "$found" != "$expected" ]; then
    echo "of a made-up library this test should say"
    echo "$expected"
    echo "but it says"
    echo "$found"
    exit 1
fi

sources=$1
shift
# shellcheck disable=SC2016
rooms=$(sed -n 's/^| `src\/\([a-z]*\)` |.*/\1/p' "$sources/src/README.md" | tr '\n' ' ')
called=$(nm -A -g "$@" | calls)
for file in "$sources"/src/*/*.c; do
    file=${file#"$sources/src/"}
    case $called in
    *"defines $file "*) ;;
    *) echo "$file: no object defines anything of it" && exit 1 ;;
    esac
done
wrong=$({
    echo "$called"
    includes "$sources"
} | judge "$rooms" && types "$sources")
if [ -n "$wrong" ]; then
    echo "rooms, each may use those before it: $rooms"
    echo "$wrong"
    exit 1
fi
echo "every file depends on files above it only, and every type has one meaning"
