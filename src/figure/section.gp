plot $section using 1:2 with points pt 7 ps 0.25 lc rgb '#1c1c1c'
