# Time history with impacts and intervals of contact.
Trace = "lw 1.3"
if (Orbit) {
Trace = "lw 2"
}
Dots = ""
if (Impacts > 0) {
Dots = ", $impacts using 1:2:3:4 with points pt variable ps 0.9 lc rgb variable"
}
Bars = ""
if (Contacts > 0) {
Bars = ", $contacts using 1:2 with lines lc rgb '#e0a010' lw 8"
}
plot $history using 1:2 with lines lc rgb '#2c5f8a' @Trace @Dots @Bars
