#!/bin/sh
# Faults from outside, for every command: streams and files that cannot be written, signals that ask to stop.
# What is asked of each: the right exit status, one clear sentence, no part of a file under its final name,
# nothing left behind, and what was found so far printed or saved.
# Argument: the saltus program. SALTUS_LONG_TESTS=1: both signals for every command, later and at more moments.
# SPDX-License-Identifier: GPL-3.0-or-later
set -u
saltus=$1
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place" || exit 1
mkdir temporary
TMPDIR=$place/temporary
export TMPDIR
failures=0
count=0
# Signals come after this many seconds; a program that has not ended 30 s after one is killed.
wait_for=0.12
signals=
delays='0.02 0.06'
if [ -n "${SALTUS_LONG_TESTS:-}" ]; then
    wait_for=0.8
    signals='INT TERM'
    delays='0.01 0.03 0.05 0.1 0.2 0.4'
fi
if [ -n "${SALTUS_SANITIZED:-}" ]; then
    wait_for=3
    signals=INT
    delays='0.1 0.4'
fi

fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
}

# Files to read.
"$saltus" orbit fig7d --periods 4 --json >orbit.json || fail "orbit"
"$saltus" continue fig7d --from orbit.json --in omega=41.9:42.1 -o branch.h5 >/dev/null || fail "continue"
"$saltus" sweep impact-oscillator --over omega=0.9:1.1:4 -o sweep.h5 --quiet >/dev/null || fail "sweep"
mkdir known out
mv orbit.json branch.h5 sweep.h5 known

# Every command once, short. The figure of fig3 is that of a periodic motion.
commands='scenes
check fig7d
classify fig3
classify fig3 --json
classify impact-oscillator --seeds 2
diagnose impact-oscillator -o out/sheet.svg
simulate fig3 --periods 2 -o out/run.csv
simulate fig3 --periods 2 -o out/run.h5
orbit fig7d --from known/orbit.json
orbit impact-oscillator --unstable --periods 1 --search 100
continue fig7d --from known/orbit.json --in omega=41.9:42.1 -o out/branch.h5
continue fig7d --from known/orbit.json --in omega=41.99:42.01 --json -o out/branch.h5
lyapunov impact-oscillator
lyapunov impact-oscillator -o out/convergence.csv
spectrum impact-oscillator
spectrum impact-oscillator -o out/spectrum.csv
sweep impact-oscillator --over omega=0.9:1.1:4 --quiet -o out/sweep.h5
sweep impact-oscillator --over omega=0.9:1.1:4 --quiet -o out/sweep.csv
basins impact-oscillator --over q1=0:0.5:3 --over v1=0:0.5:3 --quiet -o out/basins.h5
plot known/branch.h5 -o out/branch.svg
plot known/sweep.h5 -o out/sweep.svg
export known/sweep.h5 -o out/rows.csv
paper --quick --figure 7 -o out
--help
classify --help
--version'
shorter=$(echo "$commands" | grep -v '^paper') # which takes some seconds

# said STATUS WHAT: the last run ended with this status and one sentence on stderr.
said() {
    count=$((count + 1))
    [ "$got" -eq "$1" ] || fail "$2: exit status $got, not $1: $(cat err)"
    [ "$(wc -l <err)" -eq 1 ] && grep -q '^saltus: ' err || fail "$2: says '$(cat err)'"
}

# failed WHAT: by itself, which is not told as an interruption.
failed() {
    said 1 "$1"
    ! grep -q interrupted err || fail "$1: nobody interrupts it, but it says '$(cat err)'"
}

# clean WHAT: nothing but whole files and journals, which a later run takes up.
clean() {
    left=$(find . \( -name '*.part*' -o -path './temporary/*' \) -print)
    [ -z "$left" ] || fail "$1 leaves $left"
    rm -rf out temporary
    mkdir out temporary
}

# Standard output that cannot be written: full, closed, a pipe whose reader has gone.
full() {
    # shellcheck disable=SC2086
    "$saltus" $1 >/dev/full 2>err
    got=$?
    failed "$1 >/dev/full"
    grep -q 'standard output' err || fail "$1 >/dev/full says '$(cat err)'"
    clean "$1 >/dev/full"
}

closed() {
    # shellcheck disable=SC2086
    "$saltus" $1 >&- 2>err
    got=$?
    failed "$1 >&-"
    [ -z "$(find out -name '*.csv' -exec grep -l '^figure: \|^out/' {} +)" ] || fail "$1 >&- prints into its file"
    clean "$1 >&-"
}

broken() {
    # shellcheck disable=SC2086
    { "$saltus" $1 2>err; echo $? >status; } | head -1 >/dev/null
    count=$((count + 1))
    got=$(cat status)
    # A short text fits into the pipe; otherwise SIGPIPE ends the program.
    [ "$got" -eq 0 ] || [ "$got" -eq 141 ] || [ "$got" -eq 1 ] || fail "$1 | head -1: exit status $got"
    clean "$1 | head -1"
}

# each FUNCTION LIST
each() {
    while read -r line; do
        "$1" "$line" <&3
    done 3<&0 <<LIST
$2
LIST
}

[ ! -w /dev/full ] || each full "$shorter"
each closed "$shorter"
each broken "$shorter"

# Files that cannot be written: no such folder, a folder of that name, no room on the disk. What was there
# before stays.
absent() {
    target=${1##*-o out/}
    # shellcheck disable=SC2086
    "$saltus" ${1%-o *}-o absent/"$target" >stdout 2>err
    got=$?
    said 2 "$1 (absent folder)"
    grep -q "absent" err || fail "$1 (absent folder) says '$(cat err)'"
    mkdir "out/$target"
    # shellcheck disable=SC2086
    "$saltus" $1 >stdout 2>err
    got=$?
    said 2 "$1 (a folder)"
    rmdir "out/$target"
    clean "$1 (a folder)"
}

no_room() {
    target=${1##*-o }
    echo before >"$target"
    # shellcheck disable=SC2086
    (ulimit -f 1 && exec "$saltus" $1 --force >stdout 2>err)
    got=$?
    failed "$1 (no room)"
    # A sweep that begins anew replaces what was there.
    case $1 in
    sweep* | basins*) ;;
    *) [ "$(cat "$target")" = before ] || fail "$1 (no room) has damaged the file that was there" ;;
    esac
    clean "$1 (no room)"
}

# Texts of less than a block fit.
writers=$(echo "$shorter" | grep -e '-o out/' | grep -v -e '--json')
each absent "$writers"
each no_room "$(echo "$writers" | grep -v 'spectrum.csv\|sweep.csv\|rows.csv\|run.csv\|convergence.csv')"
each no_room "simulate fig3 --periods 20 -o out/run.csv
spectrum impact-oscillator --segment 8 --periods 64 -o out/spectrum.csv"

# Long runs of every command that computes. SIGINT reaches what gnuplot there is, too.
long='classify fig7c --transient 100000000 --measure 0
classify fig7c --measure 1000000000 --lifetime 100000000
classify fig7d --json --seeds 100000
diagnose fig7c --measure 1000000000 --lifetime 100000000 -o out/sheet.png
simulate fig7c --periods 1000000 --samples 1 -o out/run.csv
simulate fig7c --periods 1000000 --samples 1 -o out/run.h5
simulate fig7c --periods 10 --transient 100000000 -o out/never.csv
orbit fig7d --periods 4 --transient 100000000
orbit fig7a --unstable --search 100000000
continue fig7d --from known/orbit.json --in omega=38:46 --step-max 0.0003 -o out/branch.h5
continue fig7d --from known/orbit.json --in omega=38:46 --step-max 0.0003 --json -o out/branch.h5
continue fig7d --from known/orbit.json --in omega=38:46 --step-max 0.0003 --locus PD --and d=0.03:0.04 -o out/never.h5
lyapunov fig7c --precision 1e-8 --periods 1000000000
lyapunov fig7c --transient 1000000000
spectrum fig7c --transient 100000000 --periods 1000000 -o out/never.png
sweep fig6 --over omega=12:54:5000 --quiet -o out/sweep.h5
sweep fig6 --over omega=12:54:5000 --quiet -o out/sweep.csv
basins fig6 --over q1=-0.01:0.01:300 --over v1=-1:1:300 --quiet -o out/basins.h5
paper --quiet -o out'

# readable COMMAND: what an interrupted run has saved can be read, printed or taken up again.
readable() {
    [ -z "$(find out -name 'never*')" ] || fail "$1 writes $(find out -name 'never*')"
    case $1 in
    *run.csv) [ "$(awk -F, '!/^#/ {print NF}' out/run.csv | sort -u | wc -l)" -eq 1 ] || fail "$1: ragged rows" ;;
    *branch.h5)
        "$saltus" orbit fig7d --from out/branch.h5:1 >stdout 2>err || fail "$1: $(cat err)"
        ! grep -q 'interrupt' out/branch.h5 || fail "$1: the interruption is in the file"
        ;;
    *run.h5) [ "$(tail -c 24 out/run.h5 | head -c 7)" = saltus: ] || fail "$1: no whole file" ;;
    *never*) ;;
    *.h5 | *.csv) [ -s "out/${1##*out/}.journal" ] || fail "$1: no journal to go on with" ;;
    classify*--json*) grep -q '"attractors"' stdout || fail "$1 prints '$(cat stdout)'" ;;
    classify* | diagnose*) grep -q 'undecided\|irregular\|%' stdout || fail "$1 prints '$(cat stdout)'" ;;
    "lyapunov fig7c --p"*) grep -q 'exponent' stdout || fail "$1 prints '$(cat stdout)'" ;;
    esac
}

# A leak check at the end of a program holds it by ptrace, and a signal that comes just then is never delivered.
ASAN_OPTIONS=detect_leaks=0 LSAN_OPTIONS=detect_leaks=0
export ASAN_OPTIONS LSAN_OPTIONS

# The signals take turns where not every command gets both. One that comes before the program looks for it ends
# it at once, on a busy machine: then it comes later.
turn=TERM
interrupted() {
    [ "$turn" = INT ] && turn=TERM || turn=INT
    for signal in ${signals:-$turn}; do
        for wait in $wait_for 1 3; do
            # shellcheck disable=SC2086
            timeout --preserve-status -k 30 -s "$signal" "$wait" "$saltus" $1 >stdout 2>err
            got=$?
            [ "$got" -eq 130 ] || [ "$got" -eq 143 ] || break
            clean "$1 (SIG$signal at once)"
        done
        said 1 "$1 (SIG$signal)"
        grep -q '^saltus: interrupted' err || fail "$1 (SIG$signal) says '$(cat err)'"
        readable "$1"
        clean "$1 (SIG$signal)"
    done
}
each interrupted "$long"

# Short runs at any moment: they end as they should or by the signal, and leave nothing.
for delay in $delays; do
    while read -r line; do
        # shellcheck disable=SC2086
        timeout --preserve-status -k 30 -s TERM $delay "$saltus" $line >stdout 2>err
        got=$?
        count=$((count + 1))
        case $got in
        0 | 1 | 143) ;;
        *) fail "$line (SIGTERM after $delay s): exit status $got: $(cat err)" ;;
        esac
        clean "$line (SIGTERM after $delay s)"
    done <<LIST
$shorter
LIST
done

echo "$((count - failures)) passed, $failures failed"
[ "$failures" -eq 0 ]
