# Lines as stems from the panel's lower edge, with a dot on each, or a square at multiples of the forcing frequency; or a
# density in its confidence band. Grey from the highest trustworthy frequency on. Block is $low1, $whole1, ...
if (Edge < End) {
set object rectangle from Grey, graph 0 to End, graph 1 back fc rgb '#ececec' fs solid noborder
}
if (Edge < End && Edge > Begin) {
set arrow from Edge, graph 0 to Edge, graph 1 nohead back lc rgb '#808080' lw 1.5
set label EdgeName at Edge, graph 0.94 @EdgeSide front tc rgb '#505050'
}
Stems0 = "using ($3 == 0 && $2 > Floor && $1 <= Stems ? $1 : NaN):(Floor):(0):($2 - Floor) with vectors nohead lc rgb '#2c5f8a' lw 1.3"
Dots0 = "using ($3 == 0 ? $1 : NaN):2 with points pt 7 ps Dot lc rgb '#2c5f8a'"
Stems1 = "using ($3 == 1 && $2 > Floor && $1 <= Stems ? $1 : NaN):(Floor):(0):($2 - Floor) with vectors nohead lc rgb '#c44e2a' lw 1.3"
Dots1 = "using ($3 == 1 ? $1 : NaN):2 with points pt 5 ps 1.15*Dot lc rgb '#c44e2a'"
Band = "using 1:3:4 with filledcurves fc rgb '#c3d4e4'"
Curve = "using 1:2 with lines lc rgb '#2c5f8a' lw 1.3"
