# Kinds of motion against the pulsation frequency, figure by figure, and against the clearance, with the ranges that the
# paper names above. Run in the folder of the page: reads paper/classes.csv, writes figures/trial.png and
# figures/trial-clearance.png.
# SPDX-License-Identifier: GPL-3.0-or-later
set datafile separator ','
set style fill solid 1 noborder
set ylabel 'share of starts, %'
set tics out
set key outside right center vertical Left reverse samplen 2 spacing 1.2
set lmargin 10
set rmargin 24
share(k) = 100.0 * column(k) / (column(3) + column(4) + column(5) + column(6) + column(7) + column(8))

free = '#d9d9d9'
impacts = '#4393c3'
chatter = '#eac35a'
held = '#303030'
irregular = '#cf4a3c'

# Of each figure: its title, and what the paper says, from where to where.
title_2 = 'no stop (Figure 2); bars above: what the paper says'
said_2 = '4 14 irregular 14 55 free'
title_5 = 'd = 0.03, r = 0.9 (Figure 5)'
said_5 = '3 24.6 irregular 24.7 35 free 35.1 40.4 irregular 40.5 43.7 impacts 43.8 52 held 52.1 54.4 irregular'
title_6 = 'd = 0.035, r = 0.9 (Figure 6)'
said_6 = '15.3 20.5 impacts 20.6 24.6 chatter 35.6 46.3 impacts 46.7 49.1 irregular'
title_8a = 'd = 0.035, r = 0.8 (Figure 8)'
title_8b = 'd = 0.035, r = 0.7'
title_8c = 'd = 0.035, r = 0.6'
said_8a = ''
said_8b = ''
said_8c = ''
title_4a = '{/:Italic ω} = 10 (Figure 4a); bars above: what the paper says'
said_4a = '0 0.025 held 0.026 0.046 irregular'
title_4b = '{/:Italic ω} = 20 (Figure 4b)'
said_4b = '0 0.027 held 0.028 0.035 irregular 0.036 0.040 impacts 0.040 0.046 free'

do for [picture in 'trial trial-clearance'] {
    frequency = picture eq 'trial'
    figures = frequency ? '2 5 6 8a 8b 8c' : '4a 4b'
    set terminal pngcairo size 1600,(frequency ? 1700 : 800) enhanced font 'DejaVu Sans,13' background '#ffffff' rounded
    set output 'figures/'.picture.'.png'
    set xrange [0:frequency ? 55 : 0.046]
    between = frequency ? 5 : 0.005
    set xtics between nomirror
    unset mxtics
    if (frequency) { set mxtics 5 }
    set multiplot layout words(figures),1
    unset xlabel
    do for [k=1:words(figures)] {
        name = word(figures, k)
        said = value('said_'.name)
        set title value('title_'.name)
        set boxwidth frequency ? (said eq '' ? 0.212 : 0.106) : 0.000212
        set yrange [0:said eq '' ? 100 : 115]
        set ytics 0,25,100
        do for [c=1:words(said):3] {
            set object (c + 2) / 3 rectangle from word(said, c) + 0, 104 to word(said, c + 1) + 0, 112 \
                fc rgb value(word(said, c + 2)) fs solid noborder front
        }
        if (k == words(figures)) { set xlabel frequency ? 'pulsation frequency {/:Italic ω}' : 'clearance {/:Italic d}' }
        rows = sprintf("< awk -F, '$1 == \"%s\"' paper/classes.csv", name)
        plot rows using 2:(100) with boxes lc rgb irregular title 'no period up to 20', \
             '' using 2:(share(3) + share(4) + share(5) + share(6)) with boxes lc rgb held title 'held', \
             '' using 2:(share(3) + share(4) + share(5)) with boxes lc rgb chatter title 'chatter', \
             '' using 2:(share(3) + share(4)) with boxes lc rgb impacts title 'n/p', \
             '' using 2:(share(3)) with boxes lc rgb free title 'no contact'
        unset object
    }
    unset multiplot
}
