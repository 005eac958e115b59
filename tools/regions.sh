#!/bin/sh
# Draws the borders of the stable 5/2, 4/4, 3/5 and 4/5 motions of the pipe in the plane of pulsation frequency and
# clearance, each as a locus of folds (LP), flips (PD) or grazing points (GR).
# Arguments: the saltus program and a folder, which receives the curves and the figure regions.png.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
saltus=$1
place=$2
# The figure is drawn in the folder of the curves: a path to the program must lead there from anywhere.
case $saltus in
*/*) saltus=$(cd "$(dirname "$saltus")" && pwd)/$(basename "$saltus") ;;
esac
mkdir -p "$place"

# follow NAME ARGUMENTS...: compute a branch of the pipe's orbits or a locus of special points, as NAME.h5.
follow() {
    name=$1
    shift
    echo "$name: saltus continue pipe $*"
    "$saltus" continue pipe "$@" --quiet -o "$place/$name.h5" >"$place/$name.txt"
}

d=d=0.026:0.04

# 5/2: grazing where the fifth impact vanishes or a sixth appears; folds and flips just before the former.
omega=omega=14:32
follow 5-2-birth --set omega=20 d=0.034 --in $d --locus GR --and $omega --step-max 0.01
follow 5-2-death --set omega=20 d=0.035 --in $d --locus GR --and $omega --step-max 0.01
follow 5-2-flip --set omega=24 d=0.037 --in $d --locus PD --and $omega
follow 5-2-fold --set omega=18 d=0.034 --in $d --locus LP --and $omega

# 4/4: the same with the fourth and a fifth impact, and a second fold on the other side.
omega=omega=28:55
follow 4-4-fold --set omega=42 d=0.035 --in $omega --locus LP --and $d --step-max 0.01
follow 4-4-birth --set omega=36.5 d=0.0325 --in $d --locus GR --and $omega --step-max 0.01
follow 4-4-death --set omega=42 d=0.035 --in $d --locus GR --and $omega --step-max 0.01
follow 4-4-flip --set omega=42 d=0.035 --in $d --locus PD --and $omega
follow 4-4-fold-high --set omega=47 d=0.0358 --in $d --locus LP --and $omega
follow 4-4-fold-low --set omega=36 d=0.0326 --in $d --locus LP --and $omega
follow 4-4 --set omega=52 d=0.036 --in omega=50:55 --direction up --at 54.99
follow 4-4-birth-high --from "$place/4-4.h5:UZ1" --in $d --direction down --locus GR --and $omega --step-max 0.01

# 3/5 and 4/5.
omega=omega=36:46
follow 3-5-flip --set omega=43 d=0.03 --in $d --locus PD --and $omega
follow 3-5-fold --set omega=43 d=0.03 --in $omega --locus LP --and $d
follow 3-5-birth --set omega=43 d=0.0293 --in $d --locus GR --and $omega --step-max 0.01
follow 4-5-flip --set omega=43 d=0.0293 --in $d --locus PD --and $omega
follow 4-5-fold-high --set omega=43 d=0.0293 --in $omega --locus LP --and $d
follow 4-5 --set omega=43 d=0.0293 --in $d --direction down --points 40
follow 4-5-fold-low --from "$place/4-5.h5:LP1" --in $d --locus LP --and $omega

cd "$place"
"$saltus" plot 4-4-fold.h5 4-4-fold-*.h5 4-4-birth*.h5 4-4-death.h5 4-4-flip.h5 5-2-*.h5 3-5-*.h5 4-5-*.h5 \
    --range omega=14:55 --range d=0.0275:0.04 -o regions.png \
    --label omega=26,d=0.0377,5/2 --label omega=45,d=0.0354,4/4 \
    --label omega=43.2,d=0.0302,3/5 --label omega=42,d=0.0294,4/5
