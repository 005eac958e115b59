#!/bin/sh
# Measures again and puts the tables between the README's two bench marks.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/../.."
tables=$(mktemp)
trap 'rm -f "$tables"' EXIT
./build/saltus_bench data/reference >"$tables"
awk -v tables="$tables" '
    /<!-- bench -->/ {print; while ((getline line <tables) > 0) print line; skip = 1; next}
    /<!-- \/bench -->/ {print ""; skip = 0}
    !skip' README.md >"$tables.new"
mv "$tables.new" README.md
