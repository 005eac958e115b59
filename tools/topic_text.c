/* saltus help text: the language for systems written as equations.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "manual.h"

static const manual_part parts[] = {
    {MANUAL_WORDS,
     "The model of a scene may be a mapping that holds its equations. From them Saltus makes Taylor series, "
     "tangent vectors and the derivatives by every parameter, so all commands work as for a built-in model. "
     "Names are the scene's own: every parameter, displacement, velocity and state is a key of --set, an "
     "axis of --over, a column of tables. saltus check tells how a scene was understood, and with "
     "--derivatives that all derivatives are right."},
    {MANUAL_HEAD, "KEYS OF MODEL"},
    {MANUAL_TERM, "parameters"},
    {MANUAL_WORDS, "name: default, or {default: 1, min: 0, max: 2, integer: true, meaning: one phrase}; "
                   "default is needed, the others are not. All are keys of --set; all but whole numbers can "
                   "be continued in and swept over. A parameter that no equation has is refused."},
    {MANUAL_TERM, "constants"},
    {MANUAL_WORDS, "numbers, vectors [1, 2] and matrices [[1, 2], [3, 4]]; K[i, j] is an entry, from 1 on."},
    {MANUAL_TERM, "families"},
    {MANUAL_WORDS, "{x: N}: displacements or states x[1] to x[N], where N is a number or a whole-number "
                   "parameter. One equation x[i]: ... serves all, x[1]: ... is one member's own. Outside of "
                   "equations the members are x1 to xN."},
    {MANUAL_TERM, "let"},
    {MANUAL_WORDS, "abbreviations, which may use each other but not in circles; of families w[i]: ..."},
    {MANUAL_TERM, "motion"},
    {MANUAL_WORDS, "displacement: acceleration. x' is the velocity of x, x[i]' that of a member; x_dot is "
                   "the same, for the shell's sake. With mass the right side is a force."},
    {MANUAL_TERM, "mass"},
    {MANUAL_WORDS, "{x: m1, y: m2}, or a symmetric matrix {x: {x: 2, y: 0.5}, y: {y: 1}}, of numbers and "
                   "parameters. Impulses of stops divide by it, too; without it all masses are 1."},
    {MANUAL_TERM, "states"},
    {MANUAL_WORDS, "further quantities of first order: their rates."},
    {MANUAL_TERM, "forcing"},
    {MANUAL_WORDS,
     "the parameter that is the angular frequency. Then t is the time and phase = t/T, T = 2 pi/omega; time "
     "must enter with the period T, which is checked. Without it t and phase are refused, and orbits have "
     "periods of their own, found and counted by their returns to a section."},
    {MANUAL_TERM, "observe"},
    {MANUAL_WORDS, "named quantities, columns of saltus simulate -o run.csv. The first one, where it is a "
                   "sum of displacements, is what diagrams show; otherwise the first stop's coordinate, or "
                   "the first displacement. --set observe=NAME chooses another."},
    {MANUAL_TERM, "section"},
    {MANUAL_WORDS, "without forcing: what the returns are that orbits are counted by. maxima (of the "
                   "observed displacement, smooth or by an impact; the default), {impact: 1, side: lower} "
                   "(impacts on a stop; either side unless one is named), or {zero: x - 1, direction: up} "
                   "(an expression of the state passes through zero, rising, or falling with down; also by "
                   "the jump of an impact). A lasting contact or complete chatter counts once, with all the "
                   "impacts in a row before it; not at all where these are minima, with the maxima "
                   "between them. Periods, multipliers and exponents do not depend on it. --section "
                   "chooses another."},
    {MANUAL_TERM, "scale"},
    {MANUAL_WORDS, "typical sizes by the names of the state, for random starts and distances, where the "
                   "program's guess will not do."},
    {MANUAL_HEAD, "EXPRESSIONS"},
    {MANUAL_WORDS,
     "+ - * / ^ and parentheses; -x^2 is -(x^2); a product needs its *. sqrt exp log sin cos tan asin acos "
     "atan atan2 sinh cosh tanh; pi; sum(i, 1, N, expression), where i is a name of your choice; if(a < b, "
     "yes, no) with < <= > >= == !=, whose branch that is not taken is not looked at where numbers decide. "
     "abs, sign, min, max, step and mod, and what if compares, may have parameters, constants and indices in "
     "them, but neither states nor time."},
    {MANUAL_WORDS, "Reserved are the names of functions, t, phase, pi, speed, observe, and d, r, xi, sides "
                   "with or without a number. Where an expression has no value, as sqrt(p) below zero, the "
                   "motion ends, and the message tells the part and the time."},
    {MANUAL_HEAD, "THE REST OF THE SCENE"},
    {MANUAL_TERM, "stop, stops"},
    {MANUAL_WORDS,
     "coordinate: a sum of displacements with constant factors, such as y - x, and a constant, which shifts "
     "the stop. d is the clearance (upper forbids coordinate > d, lower coordinate < -d), r the restitution; "
     "each is a number, which --set d= or r= changes, or an expression of parameters, which are then what is "
     "set. r may use speed, the closing speed: r0/(1 + speed/s0)^0.25; complete chatter takes its limit at "
     "0, which must be below 1. sides: upper, lower or both."},
    {MANUAL_TERM, "initial"},
    {MANUAL_WORDS, "by names: {x: 0.5, x': 0, p: 2*delta}; parameters may stand in it. What is not set "
                   "starts as it does everywhere else: near rest."},
    {MANUAL_TERM, "model: file.yaml"},
    {MANUAL_WORDS, "a path relative to the scene's own file, in place of the mapping: equations in a file of "
                   "their own, or those of another scene."},
    {MANUAL_WORDS, "A number anywhere in any scene may be an expression of numbers, omega: 2*pi/5, and so "
                   "may those of --set, --over, --in, --and, --at: --in omega=pi/2:2*pi."},
    {MANUAL_HEAD, "YAML"},
    {MANUAL_WORDS, "Inside { } and [ ] a comma ends a value, also between parentheses: write {x: \"min(a, "
                   "b)\"}, or one key in a line. An expression needs quotation marks, too, where it begins "
                   "with *, & or [, or with a minus and a blank, or holds a colon and a blank. A blank and # "
                   "begin a comment, also behind an expression."},
    {MANUAL_HEAD, "SPEED"},
    {MANUAL_WORDS,
     "Equations run at once, interpreted. In runs of more than 50 ms (somewhat more where there are many "
     "equations) a C compiler, if there is one, makes functions of them in the background: a second or a few "
     "for each way of running them, alone, side by side, with so many derivatives. The run goes on and takes "
     "each over when it is there. The results are the same to the last bit. The functions are kept for later "
     "runs in $XDG_CACHE_HOME/saltus or ~/.cache/saltus, which must be the user's alone; those that no run "
     "has used for 60 days, and of more than 1000 those used longest ago, are removed when another one is "
     "made, and all may be deleted at any time. saltus check tells how it stands."},
    {MANUAL_TERM, "SALTUS_COMPILE"},
    {MANUAL_WORDS, "environment variable: 0 for no compiling, or the compiler's name or path; default cc."},
    {MANUAL_HEAD, "FROM A BLANK FILE TO A DIAGRAM"},
    {MANUAL_WORDS, "A Duffing oscillator that hits a stop. The minus of -c*x' needs no quotation marks, as "
                   "no blank follows it. The first command shows the equation, the second finds what the "
                   "motion is, the others draw where x turns, for 100 amplitudes of the force."},
    {MANUAL_FILE, "duffing.yaml"},
    {MANUAL_LINES, "title: Duffing oscillator with a stop\n"
                   "model:\n"
                   "  parameters:\n"
                   "    c: {default: 0.2, min: 0, meaning: damping}\n"
                   "    k3: 1\n"
                   "    F: {default: 0.3, meaning: force amplitude}\n"
                   "    omega: {default: 1.2, min: 0.01, meaning: forcing frequency}\n"
                   "  motion:\n"
                   "    x: -c*x' + x - k3*x^3 + F*cos(omega*t)\n"
                   "  forcing: omega\n"
                   "stop: {coordinate: x, d: 1.3, r: 0.8}\n"},
    {MANUAL_COMMAND, "check duffing.yaml --derivatives"},
    {MANUAL_COMMAND, "classify duffing.yaml --set F=0.25"},
    {MANUAL_COMMAND, "sweep duffing.yaml --over F=0.2:0.5:100 --what turning -o duffing.h5"},
    {MANUAL_COMMAND, "plot duffing.h5 -o duffing.png"},
    {MANUAL_WORDS, "An impact damper: a ball in a box on a spring. Two displacements with masses, a gap with "
                   "two sides, of which half lies on each; the ball begins to move, or it would lie still "
                   "for ever. The diagram shows the velocity of the impacts."},
    {MANUAL_FILE, "damper.yaml"},
    {MANUAL_LINES, "title: a ball in a box on a spring\n"
                   "model:\n"
                   "  parameters: {m: 0.1, c: 0.05, k: 1, F: 0.2, omega: {default: 1, min: 0.01}, gap: "
                   "{default: 1, min: 0}}\n"
                   "  motion:\n"
                   "    x: -c*x' - k*x + F*cos(omega*t)\n"
                   "    y: -0.001*y'\n"
                   "  mass: {x: 1, y: m}\n"
                   "  forcing: omega\n"
                   "stop: {coordinate: y - x, d: gap/2, r: 0.7, sides: both}\n"
                   "initial: {x: 0, y': 0.3}\n"},
    {MANUAL_COMMAND, "classify damper.yaml --set omega=0.95 gap=0.8"},
    {MANUAL_COMMAND, "sweep damper.yaml --over omega=0.6:1.4:100 --what impacts -o damper.h5"},
    {MANUAL_COMMAND, "plot damper.h5 -o damper.png"},
    {MANUAL_WORDS,
     "A row of masses whose last one hangs on a creeping support: a family of N, a state of first order, "
     "quantities that are observed. Here one orbit is followed, stable or not, through its bifurcations."},
    {MANUAL_FILE, "row.yaml"},
    {MANUAL_LINES, "title: masses in a row, the last one on a creeping support\n"
                   "model:\n"
                   "  parameters:\n"
                   "    N: {default: 3, min: 2, max: 20, integer: true}\n"
                   "    c: 0.05\n"
                   "    tau: {default: 2, min: 0.1, meaning: relaxation time}\n"
                   "    F: 0.5\n"
                   "    omega: {default: 0.7, min: 0.01}\n"
                   "  families: {x: N}\n"
                   "  let:\n"
                   "    pull[i]: if(i > 1, x[i-1], 0) - 2*x[i] + if(i < N, x[i+1], z)\n"
                   "  motion:\n"
                   "    x[i]: pull[i] - c*x[i]' + if(i == 1, F*cos(omega*t), 0)\n"
                   "  states:\n"
                   "    z: (x[N] - z)/tau\n"
                   "  forcing: omega\n"
                   "  observe: {end: \"x[N]\", energy: \"sum(i, 1, N, x[i]'^2)/2\"}\n"
                   "stop:\n"
                   "  coordinate: x[N]\n"
                   "  d: 0.5\n"
                   "  r: 0.8\n"},
    {MANUAL_COMMAND, "simulate row.yaml --periods 10 -o row.csv"},
    {MANUAL_COMMAND, "continue row.yaml --in omega=0.4:1 -o row.h5"},
    {MANUAL_COMMAND, "plot row.h5 -o row.png"},
    {MANUAL_END, NULL}};

const manual_topic topic_text = {
    .name = "text",
    .summary = "systems written as equations",
    .parts = parts,
    .see = "scenes check",
};
