# Phase portrait: velocity jumps, the trajectory, and its stroboscopic points with a white rim.
Jumps = ""
if (Impacts > 0) {
Jumps = "$jumps using 1:2:3 with lines lc rgb variable lw 1.5, "
}
Trace = "lc rgb '#a02c5f8a' lw 0.7"
if (Orbit) {
Trace = "lc rgb '#2c5f8a' lw 2"
}
Rim = "ps 0.6"
Dot = "ps 0.5"
if (Settled) {
Rim = "ps 1.5"
Dot = "ps 1.0"
}
plot @Jumps $orbit using 2:3 with lines @Trace, \
     $strobe using 1:2 with points pt 7 @Rim lc rgb '#ffffff', \
     $strobe using 1:2 with points pt 7 @Dot lc rgb '#1c1c1c'
