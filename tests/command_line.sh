#!/bin/sh
# The command line: bad input gets one clear sentence, the right exit status and no file; good input works.
# Argument: the saltus program.
# SPDX-License-Identifier: GPL-3.0-or-later
set -u
saltus=$1
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place" || exit 1
failures=0
count=0

fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
}

# refuse STATUS WORD ARGUMENTS...: exit status, one line on stderr that holds the word, nothing on stdout.
refuse() {
    status=$1 word=$2
    shift 2
    count=$((count + 1))
    "$saltus" "$@" >out 2>err
    got=$?
    [ "$got" -eq "$status" ] || fail "$* exits with $got, not $status: $(cat err)"
    [ "$(wc -l <err)" -eq 1 ] || fail "$* says more or less than one line: $(cat err)"
    grep -q -F -- "$word" err || fail "$* does not name '$word': $(cat err)"
    [ ! -s out ] || fail "$* writes to stdout: $(cat out)"
    rm -f out err
}

# accept WORD ARGUMENTS...: success, and the word on stdout.
accept() {
    word=$1
    shift
    count=$((count + 1))
    "$saltus" "$@" >out 2>err || fail "$* fails: $(cat err)"
    grep -q -F -- "$word" out || fail "$* does not say '$word': $(cat out)"
    rm -f out err
}

printf 'model: pipe\nomega: 42\ncolour: blue\nstop: {d: 0.035}\n' >unknown.yaml
printf 'model: pipe\nomega: fast\nstop: {d: 0.035}\n' >type.yaml
printf 'model: pipe\nomega: 42\nstop: {d: 0.035, r: 1.2}\n' >range.yaml
printf 'model: pipe\nomega: nan\n' >nan.yaml
printf 'model: pipe\nomega: 42\nN: 0\n' >modes.yaml
printf 'model: pipe\nomega: 42\nbeta: 1\n' >beta.yaml
printf 'model: pipe\nomega: 42\nstop: {d: -0.01, sides: both}\n' >sides.yaml
printf 'model: pipe\nomega: 42\nstop: {d: 0.01, xi: 0}\n' >place.yaml
printf 'model: pipe\nomega: -1\n' >omega.yaml
printf 'model: pipe\nomega: 42\nstop: {d: 0.01}\ninitial: {q: [0.02]}\n' >beyond.yaml
: >empty.yaml
head -c 4096 /dev/urandom >binary.yaml
mkdir folder

refuse 2 colour classify unknown.yaml
refuse 2 omega classify type.yaml
refuse 2 "r = 1.2" classify range.yaml
refuse 2 omega classify nan.yaml
refuse 2 "N = 0" classify modes.yaml
refuse 2 "beta = 1" classify beta.yaml
refuse 2 "d = -0.01" classify sides.yaml
refuse 2 xi classify place.yaml
refuse 2 "omega = -1" classify omega.yaml
refuse 2 beyond classify beyond.yaml
refuse 2 empty.yaml classify empty.yaml
refuse 2 binary.yaml classify binary.yaml
refuse 2 folder classify ./folder
refuse 2 missing.yaml classify missing.yaml
refuse 2 nosuchscene classify nosuchscene
refuse 2 "r=1.2" classify pipe --set r=1.2
refuse 2 "beta=1" classify pipe --set beta=1
refuse 2 "N=0" classify pipe --set N=0
refuse 2 "omega=0" classify pipe --set omega=0
refuse 2 "omega=nan" classify pipe --set omega=nan
refuse 2 "omega=4x" classify pipe --set omega=4x
refuse 2 "colour=1" classify pipe --set colour=1
refuse 2 "d = -0.01" classify pipe --set d=-0.01 sides=both
refuse 2 "xi=0" classify pipe --set xi=0
refuse 2 "sides=left" classify pipe --set sides=left
refuse 2 "q1=" classify pipe --set q1=
refuse 2 "--set" classify pipe --set
refuse 2 "--seeds 0" classify pipe --seeds 0
refuse 2 "--seeds many" classify pipe --seeds many
refuse 2 "--seeds" classify pipe --seeds
refuse 2 "--rtol 1" classify pipe --rtol 1
refuse 2 "--frobnicate" classify pipe --frobnicate
refuse 2 "--integrator euler" classify pipe --integrator euler
refuse 2 "second" classify pipe second
refuse 2 "scene" classify
refuse 2 "nonsense" nonsense
refuse 2 "-o" diagnose pipe
refuse 2 "--periods" simulate pipe -o run.csv
refuse 2 "sheet.bmp" diagnose fig3 -o sheet.bmp
refuse 2 "run.txt" simulate fig3 --periods 2 -o run.txt
refuse 1 "nowhere/run.csv" simulate fig3 --periods 2 -o nowhere/run.csv
refuse 1 "nowhere/run.h5" simulate fig3 --periods 2 -o nowhere/run.h5
refuse 1 "nowhere/sheet.png" diagnose fig3 -o nowhere/sheet.png

# Without gnuplot: a sentence, exit status 1, no file.
count=$((count + 1))
PATH=/nonexistent "$saltus" diagnose fig3 -o sheet.png >out 2>err
[ $? -eq 1 ] || fail "diagnose without gnuplot does not exit with 1"
grep -q gnuplot err || fail "diagnose without gnuplot does not name it: $(cat err)"
rm -f out err

# A full disk.
if [ -w /dev/full ]; then
    count=$((count + 1))
    "$saltus" classify fig3 --json >/dev/full 2>err
    [ $? -eq 1 ] || fail "classify onto a full disk does not exit with 1"
    rm -f err
fi

left=$(find . -type f ! -name '*.yaml')
[ -z "$left" ] || fail "files are left behind: $left"

accept "pipe" scenes
accept "omega" scenes fig7d
accept "ok" check fig7d
accept "4/4" classify fig7d
accept '"label": "4/4"' classify fig7d --json
accept "3/5" classify fig7b --json
accept "chatter/2" classify chatter --json
accept "2/2" classify fig3 --json
accept "4/4" classify pipe --set N=5 omega=42 --set d=0.035 r=0.9 xi=0.5 sides=upper --json
accept "equilibrium" classify pipe --set sigma=0 --set sides=none --json
accept "held" classify pipe --set sigma=0 d=0.01 --json
accept "undecided" classify fig7c --json --transient 500
accept '"seeds"' classify fig3 --seeds 5 --json
accept "2/2" classify fig3 --seeds 5
accept "saltus classify" --help
accept "run.csv" simulate fig7d --periods 3 --transient 2 -o run.csv
accept "run.h5" simulate chatter --periods 3 -o run.h5
for kind in png pdf svg; do
    accept "sheet.$kind" diagnose fig3 -o sheet.$kind
    [ -s sheet.$kind ] || fail "sheet.$kind is empty"
done
accept "sheet.png" diagnose fig3 -o sheet.png --data sheet.h5
[ -s sheet.h5 ] && [ -s sheet.gp ] || fail "--data leaves no sheet.h5 and sheet.gp"
awk -F, '!/^#/ && NR > 3 {print NF}' run.csv | sort -u | wc -l | grep -q '^1$' || fail "run.csv has ragged rows"

# The same classification twice gives the same bytes.
count=$((count + 1))
"$saltus" classify fig7d --json >first && "$saltus" classify fig7d --json >second && cmp -s first second ||
    fail "two runs differ"

echo "$((count - failures)) passed, $failures failed"
[ "$failures" -eq 0 ]
