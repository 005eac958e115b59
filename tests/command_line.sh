#!/bin/sh
# The command line: bad input gets one clear sentence, the right exit status and no file; good input works. The
# commands' own sentences are those of test_refusals.
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
printf 'model: pipe\nomega: 42\nstop: {d: 0.01}\ninitial: {q: [0.02]}\n' >beyond.yaml
# x'' + 0.05 x' + x = cos(omega t) with a stop at rest: chaos, and a flip near omega = 2.656.
printf 'model: oscillator\nc: 0.05\nF: 1\nomega: 2.8\nstop: {d: 0, r: 0.8}\n' >chaos.yaml
printf 'model: oscillator\nc: 0.05\nF: 1\nomega: 2.6\nstop: {d: 0, r: 0.8}\n' >flip.yaml
: >empty.yaml
head -c 4096 /dev/urandom >binary.yaml
mkdir folder

refuse 2 colour classify unknown.yaml
refuse 2 omega classify type.yaml
refuse 2 beyond classify beyond.yaml
refuse 2 empty.yaml classify empty.yaml
refuse 2 binary.yaml classify binary.yaml
refuse 2 folder classify ./folder
refuse 2 missing.yaml classify missing.yaml
refuse 2 nosuchscene classify nosuchscene
refuse 2 "colour=1" classify pipe --set colour=1
refuse 2 "d = -0.01" classify pipe --set d=-0.01 sides=both
refuse 2 "q1=" classify pipe --set q1=
refuse 2 "missing.json" orbit fig7d --from missing.json
refuse 2 "unknown.yaml" orbit fig7d --from unknown.yaml
refuse 2 "binary.yaml" orbit fig7d --from binary.yaml
refuse 2 "empty.yaml" orbit fig7d --from empty.yaml
refuse 2 "folder" orbit fig7d --from folder
refuse 2 "mirror" orbit fig7d --periods 4 --mirror
refuse 1 "Newton" orbit fig7a --periods 9 --transient 11
refuse 2 "omega=50:56" continue fig7d --in omega=50:56 -o branch.h5
refuse 2 "frequency" continue fig7d --in frequency=50:56 -o branch.h5
refuse 2 "whole number" continue fig7d --in N=3:6 -o branch.h5
refuse 2 "--of q9" spectrum fig7d --of q9
refuse 2 "--of speed" spectrum fig7d --of speed
refuse 2 "--segment -1" spectrum fig7d --segment -1
refuse 2 "two orbits take 8" spectrum fig7d --periods 7
refuse 2 "segment = 9" spectrum fig7d --segment 9 --periods 8
refuse 2 "1000000 periods" spectrum fig7d --periods 1000000
refuse 2 "nowhere/spectrum.csv" spectrum fig7d -o nowhere/spectrum.csv
refuse 2 "--precision 0" lyapunov fig7d --precision 0
refuse 2 "--interval -1" lyapunov fig7d --interval -1
refuse 2 "interval = 0.3" lyapunov fig7d --interval 0.3
refuse 2 "periods = 100" lyapunov fig7d --periods 100
refuse 2 "x.bmp" lyapunov fig7c --precision 1e-6 -o x.bmp
refuse 2 "nowhere/x.png" lyapunov fig7c --precision 1e-6 -o nowhere/x.png
refuse 2 "irregular" continue fig7c --in omega=5:15 --transient 500 -o branch.h5
refuse 2 "branch.txt" continue fig7d --in omega=35:56 -o branch.txt
refuse 2 "nowhere/branch.h5" continue fig7d --in omega=35:56 -o nowhere/branch.h5
refuse 2 "branch.h5" continue fig7d --in omega=35:56 -o branch.h5 --resume
refuse 2 "unknown.yaml" plot unknown.yaml -o branch.png
refuse 2 "missing.h5" plot missing.h5 -o branch.png
refuse 2 "sheet.bmp" diagnose fig3 -o sheet.bmp
refuse 2 "run.txt" simulate fig3 --periods 2 -o run.txt
refuse 2 "nowhere/run.csv" simulate fig3 --periods 2 -o nowhere/run.csv
refuse 2 "nowhere/run.h5" simulate fig3 --periods 2 -o nowhere/run.h5
refuse 2 "nowhere/sheet.png" diagnose fig3 -o nowhere/sheet.png

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
accept "model: pipe (" check fig7d
accept "4/4" classify fig7d
accept '"label": "4/4"' classify fig7d --json
accept "3/5" classify fig7b --json
accept "chatter/2" classify chatter --json
accept "2/2" classify fig3 --json
accept "4/4" classify pipe --set N=5 omega=42 --set d=0.035 r=0.9 xi=0.5 sides=upper --json
accept "equilibrium" classify pipe --set sigma=0 --set sides=none --json
accept "held" classify pipe --set sigma=0 d=0.01 --json
accept "chaotic" classify chaos.yaml --json --transient 300 --measure 8000 --lifetime 300
accept "irregular" classify chaos.yaml --json --transient 300 --measure 0
accept "positive: nearby trajectories separate" lyapunov fig7c --precision 0.05
accept '"sign": "negative"' lyapunov fig7d --json
accept "trace and restitution give" lyapunov impact-oscillator --all
accept "2 of 10 directions are lost in lasting contacts" lyapunov chatter --all --members 1 --periods 200 --transient 50
accept "every direction is lost in lasting contacts" lyapunov bouncing-ball
accept "precision     NOT reached" lyapunov fig7c --precision 1e-4 --periods 4000
for kind in svg csv; do
    accept "convergence: conv.$kind" lyapunov fig7c --precision 0.1 -o conv.$kind
    [ -s conv.$kind ] || fail "conv.$kind is empty"
done
awk -F, '!/^#/ {print NF}' conv.csv | sort -u | grep -q '^3$' || fail "conv.csv has ragged rows"
accept "multiples of omega/4" spectrum fig7d
accept '"between_lines"' spectrum impact-oscillator --json
accept "spectrum.csv" spectrum fig7d --of q3 -o spectrum.csv
awk -F, '!/^#/ {print NF}' spectrum.csv | sort -u | wc -l | grep -q '^1$' || fail "spectrum.csv has ragged rows"
accept "degrees of freedom" spectrum chaos.yaml --transient 100 --periods 128 --samples 32
accept "does not move" spectrum pipe --set sigma=0 d=0.01
for kind in png pdf svg; do
    accept "spectrum.$kind" spectrum impact-oscillator -o spectrum.$kind
    [ -s spectrum.$kind ] || fail "spectrum.$kind is empty"
done
accept '"seeds"' classify fig3 --seeds 5 --json
accept "2/2" classify fig3 --seeds 5
accept "saltus classify" --help
accept "run.csv" simulate fig7d --periods 3 --transient 2 -o run.csv
accept "run.h5" simulate chatter --periods 3 -o run.h5
accept "sheet.pdf" diagnose fig3 -o sheet.pdf
[ -s sheet.pdf ] || fail "sheet.pdf is empty"
accept "sheet.png" diagnose fig3 -o sheet.png --data sheet.h5
[ -s sheet.h5 ] && [ -s sheet.gp ] || fail "--data leaves no sheet.h5 and sheet.gp"
grep -q "multiples of" sheet.gp || fail "the page of fig3 has no spectrum"
grep -q "stroboscopic section" sheet.gp && fail "the page of an orbit has a section"
accept "quasi-periodic" diagnose impact-oscillator --set c=0 omega=0.618034 d=3 -o torus.svg --data torus.h5
for word in "stroboscopic section, 2000 points" "95 % band" "convergence of the largest exponent"; do
    grep -q "$word" torus.gp || fail "the page of a torus has no '$word'"
done
accept "4/4, stable" orbit fig7d --periods 4
accept "4/4" orbit fig7d --periods 8
accept "not inside the unit circle" orbit fig7a --periods 1
accept "2/2" orbit fig3 --periods 2 --mirror
accept "eigenvalues" orbit pipe --set sigma=0 d=0.01
accept "n/p" orbit fig7a --unstable --periods 5 --search 2000

# keep FILE ARGUMENTS...: success, and stdout goes to the file.
keep() {
    file=$1
    shift
    count=$((count + 1))
    "$saltus" "$@" >"$file" 2>err || fail "$* fails: $(cat err)"
    rm -f err
}

# An orbit file starts a branch, a branch starts an orbit, and both keep the parameters.
keep orbit.json orbit fig7d --periods 4 --json
keep points.json continue fig7d --from orbit.json --in omega=41:42.5 --at 42.25 --step-max 0.05 --json -o branch.h5
grep -q '"label": "PD"' points.json || fail "continue finds no flip between omega = 41 and 42.5"
grep -q '"label": "GR"' points.json || fail "continue finds no grazing between omega = 41 and 42.5"
accept "omega = 42.25" orbit fig7d --from branch.h5:UZ1
accept "omega = 41.11059" orbit fig7d --from branch.h5:PD1
accept "omega = 42.1" orbit fig7d --from branch.h5:PD1 --set omega=42.1
accept "4/4" orbit fig7d --from points.json:2
accept "branch.h5:PD1" orbit --help
accept "branch.png" plot branch.h5 -o branch.png
accept "branch.svg" plot branch.h5 -o branch.svg --show impacts --range omega=41:41.3
keep start.json orbit flip.yaml --periods 1 --json
keep flip.txt continue flip.yaml --from start.json --in omega=2.55:2.7 --locus PD --and r=0.79:0.81 -o flip.h5
keep turned.txt continue flip.yaml --from start.json --set omega=2.656 --in r=0.78:0.82 --locus PD --and omega=2.6:2.7 -o turned.h5
grep -q "PD of 1/1" flip.txt || fail "continue does not say what it follows: $(cat flip.txt)"
accept "plane.png" plot flip.h5 turned.h5 -o plane.png --label r=0.8,omega=2.6562,1/1 --range r=0.795:0.81
keep out continue flip.yaml --from start.json --in omega=2.59:2.61 -o short.h5
rm -f out
refuse 2 "axes" plot short.h5 flip.h5 -o x.png
refuse 2 "--label 4/4" plot flip.h5 -o x.png --label 4/4
refuse 2 "in what the figure shows, omega and speed" plot branch.h5 -o x.png --label omega=42,d=0.035,4/4
refuse 2 "shows omega and r" plot flip.h5 -o x.png --range d=0.5:0.9
refuse 2 "--range omega" plot flip.h5 -o x.png --range omega
refuse 2 "--show colours" plot branch.h5 -o x.png --show colours
refuse 2 "no point" plot branch.h5 -o x.png --range omega=50:51
accept "run.png" plot run.h5 -o run.png
refuse 2 "name one" orbit fig7d --from branch.h5
refuse 2 "NS1" orbit fig7d --from branch.h5:NS1
refuse 2 "model" orbit impact-oscillator --from orbit.json
refuse 2 "N = 5" orbit fig7d --from orbit.json --set N=4
keep chain.json orbit chain --set N=3 --periods 1 --json
accept '"N": 3' orbit chain --from chain.json --json
refuse 2 "no orbit of period 7 T" continue fig7d --from orbit.json --periods 7 --in omega=35:56 -o branch.h5
refuse 2 "another run" continue fig7d --in omega=35:56 -o branch.h5 --resume
refuse 2 "another run" continue fig7d --set d=0.03 --in omega=41:42.5 -o branch.h5 --resume
head -c 3000 orbit.json >cut.json
refuse 2 "cut off" continue fig7d --from cut.json --in omega=35:56 -o branch.h5
head -c 9000 branch.h5 >cut.h5
refuse 2 "cut off" continue fig7d --from cut.h5:1 --in omega=35:56 -o branch.h5
refuse 2 "cut off" plot cut.h5 -o x.png
accept "PD     41.1105994075" continue fig7d --in omega=41:42.5 -o branch.h5 --resume

# wait_for FILE: until the first point is in it.
wait_for() {
    tries=0
    while ! "$saltus" orbit impact-oscillator --from "$1:1" >/dev/null 2>&1 && [ $tries -lt 1000 ]; do
        sleep 0.02
        tries=$((tries + 1))
    done
}

# A killed run leaves a file that can be read, and --resume completes it; an interrupted one says so itself.
long='continue impact-oscillator --in omega=0.95:1.05 --step-max 0.0002 --points 20000'
for signal in KILL TERM; do
    count=$((count + 1))
    # shellcheck disable=SC2086
    "$saltus" $long -o long.h5 >out 2>err &
    wait_for long.h5
    kill -$signal $!
    wait $!
    got=$?
    [ $signal = KILL ] || [ $got -eq 1 ] || fail "continue exits with $got after SIG$signal"
    [ $signal = KILL ] || grep -q -- --resume err || fail "continue says nothing after SIG$signal: $(cat err)"
    "$saltus" orbit impact-oscillator --from long.h5:1 >/dev/null || fail "SIG$signal leaves no readable file"
    # As many points as are told, and not one more.
    if [ $signal = TERM ]; then
        there=$(sed -n 's/^saltus: interrupted; long.h5 holds the \([0-9]*\) points so far.*/\1/p' err)
        "$saltus" orbit impact-oscillator --from "long.h5:$there" >/dev/null || fail "$there points are told, there are less"
        "$saltus" orbit impact-oscillator --from "long.h5:$((there + 1))" >out 2>&1 && fail "$there points are told, there are more"
    fi
    # shellcheck disable=SC2086
    keep out $long -o long.h5 --resume
    grep -q "end of the parameter's range" out || fail "the run is not completed after SIG$signal: $(cat out)"
    rm -f long.h5 out err
done
awk -F, '!/^#/ && NR > 3 {print NF}' run.csv | sort -u | wc -l | grep -q '^1$' || fail "run.csv has ragged rows"

# The same classification twice gives the same bytes.
count=$((count + 1))
"$saltus" classify fig7d --json >first && "$saltus" classify fig7d --json >second && cmp -s first second ||
    fail "two runs differ"

echo "$((count - failures)) passed, $failures failed"
[ "$failures" -eq 0 ]
