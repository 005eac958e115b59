# Time history of a record, with dots where a period of the forcing begins.
Trace = "lw 1.3"
Dot = "ps 0.5"
if (Orbit) {
Trace = "lw 2"
Dot = "ps 1.0"
}
plot $orbit using 1:2 with lines lc rgb '#2c5f8a' @Trace, \
     $strobe using 3:1 with points pt 7 @Dot lc rgb '#1c1c1c'
