/* Options take effect: each option of each command, with another value than its default, is found in the file
 * or changes the result as its help says. The options are those of `saltus COMMAND --help`, so one without a
 * row in the table below fails.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _XOPEN_SOURCE 700
#include "folder.h"
#include "json.h"

#include <fcntl.h>
#include <hdf5.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { commands_max = 32, options_max = 256 };

/* Inputs lie in `in`; each command is run without the option in `base` and with it in `with`. */
typedef struct fixture {
    char folder[64], last[512], with[1024]; /* the last runs in both */
    int status, changed;                    /* how these ended */
    int listed_count;
    unsigned short columns; /* columns of the terminal; 0: unknown */
} fixture;

/* What shows that an option has been heeded, of the run with it as against the one without:
 *   json:PATH=VALUE, count:PATH=N       a value, or how many there are, in the JSON object on stdout
 *   attr:FILE:GROUP:NAME=VALUE          an attribute
 *   rows:FILE:DATASET=N                 a dataset's first extent
 *   lines:FILE=N, text:FILE:TEXT        lines of a file, a text in it (`out` and `err` are the streams)
 *   differs:FILE, same:FILE, made:FILE  a file
 *   refused                             exit status 2 */
typedef struct option_case {
    const char *command, *option, *before, *base, *more, *witness;
} option_case;

#define CHAOS "../in/chaos.yaml"
#define TWICE "../in/twice.yaml"
#define SWEEP "sweep impact-oscillator --over omega=0.9:1.1:2 --threads 1 --quiet -o s.h5"
#define BASINS "basins impact-oscillator --over q1=0:0.2:2 --over v1=0:0.2:2 --threads 1 --quiet -o s.h5"
#define CONTINUE "continue impact-oscillator --in omega=0.99:1.01 --points 2 -o b.h5"
#define LYAPUNOV "lyapunov " CHAOS " --transient 20 --periods 1800 --json"
#define DIAGNOSE "diagnose impact-oscillator -o s.png --data d.h5"
#define SIMULATE "simulate impact-oscillator --periods 2 -o r.h5"

/* Options whose effects can be seen in one run, each with its value. */
#define FLOW "--rtol 1e-6 --atol 1e-7 --integrator radau"
#define SWEEP_SETS                                                                                           \
    "--set F=0.6 --seeds 3 --seed 7 --what impacts,lyapunov --at-most 300 --longest 9 --record 12 "          \
    "--measure 4321 --lifetime 1234 " FLOW
#define SWEEP_OVER "--over c=0.1:0.2:3:log --start both --what stroboscopic"
#define SWEEP_LIST "--over c=0.1,0.2,0.4 --start carry --what turning,class"
#define BASINS_SETS "--set F=0.6 --at-most 300 --longest 9 " FLOW
#define CONTINUE_SETS                                                                                        \
    "--set F=0.6 --in omega=0.98:1.03 --periods 2 --step 0.007 --step-max 0.2 --points 4 --direction up "    \
    "--switch 1 --at 0.995,1.005 --rtol 1e-11 --atol 1e-13 --integrator radau"
#define CONTINUE_DOWN "--in c=0.05:0.2 --direction down"
#define LYAPUNOV_SETS                                                                                        \
    "--set F=1.1 --precision 0.5 --transient 31 --periods 3200 --members 3 --interval 2 --seed 4 "           \
    "--rtol 1e-7 --atol 1e-8"
#define SIMULATE_SETS "--periods 3 " FLOW
#define SPECTRUM "spectrum impact-oscillator --samples 64 -o s.csv"
#define SPECTRUM_SETS "--rtol 1e-6 --atol 0.0009765625 --integrator radau"
#define SPECTRUM_JSON "spectrum impact-oscillator --samples 64 --json"
#define SPECTRUM_LOOKS "--of v1 --periods 4 --samples 128"

static const option_case cases[] = {
    {"classify", "--set", "", "classify impact-oscillator --json", "--set F=0.6", "json:parameters.F=0.6"},
    {"classify", "--section", "", "classify relief-valve --set q=6.8 --json", "--section 'impact: 1'",
     "json:periods=1"},
    {"orbit", "--section", "", "orbit relief-valve --set q=6.8 --periods 1 --transient 300 --json",
     "--section 'zero: x - 2'", "json:state.0=2"},
    {"sweep", "--section", "", "sweep relief-valve --over q=6.8,6.7 --threads 1 --quiet -o s.csv",
     "--section 'impact: 1'", "text:s.csv:,1/1"},
    {"basins", "--section", "",
     "basins relief-valve --set q=6.8 --over p=19:20:2 --over x=0.4:0.5:2 --threads 1 -o s.h5",
     "--section 'impact: 1'", "text:out:1/1"},
    {"continue", "--section", "", "continue relief-valve --set q=6.8 --in q=6.7:6.9 --points 2 -o b.h5",
     "--section 'impact: 1'", "text:out:1/1"},
    {"diagnose", "--section", "", "diagnose relief-valve --set q=6.8 -o s.png", "--section 'impact: 1'",
     "text:out:1/1"},
    {"simulate", "--section", "", "simulate relief-valve --periods 2 -o r.h5", "--section 'impact: 1'",
     "differs:r.h5"},
    {"lyapunov", "--section", "", "lyapunov relief-valve --set q=6.8 --json", "--section 'impact: 1'",
     "differs:out"},
    {"spectrum", "--section", "", "spectrum relief-valve --set q=6.8 --json", "--section 'impact: 1'",
     "differs:out"},
    {"classify", "--json", "", "classify impact-oscillator", "--json", "text:out:{\"version\": "},
    {"classify", "--seeds", "", "classify impact-oscillator --json", "--seeds 2", "json:seeds=2"},
    {"classify", "--seed", "", "classify " TWICE " --seeds 2 --json", "--seed 5", "differs:out"},
    {"classify", "--transient", "", "classify " TWICE " --json --measure 0", "--transient 3",
     "json:kind=irregular"},
    {"classify", "--longest", "", "classify " TWICE " --json --transient 200 --measure 0", "--longest 1",
     "json:kind=irregular"},
    {"classify", "--measure", "", "classify " CHAOS " --json --transient 100 --measure 8000 --lifetime 300",
     "--measure 0", "json:kind=irregular"},
    {"classify", "--measure", "", "classify " CHAOS " --json --transient 100 --lifetime 300 --measure 0",
     "--measure 8000", "json:kind=chaotic"},
    {"classify", "--lifetime", "", "classify " CHAOS " --json --transient 100 --measure 8000",
     "--lifetime 300", "json:kind=chaotic"},
    {"classify", "--rtol", "", "classify impact-oscillator --json", "--rtol 1e-4", "differs:out"},
    {"classify", "--atol", "", "classify impact-oscillator --json", "--atol 1e-3", "differs:out"},
    {"classify", "--integrator", "", "classify impact-oscillator --json", "--integrator radau",
     "json:integrator=radau"},
    {"classify", "--integrator", "", "classify impact-oscillator --json", "--integrator radau",
     "differs:out"},
    {"classify", "--integrator", "", "classify impact-oscillator", "--integrator radau", "text:out:(radau)"},

    {"diagnose", "--set", "", DIAGNOSE, "--set F=0.6", "differs:script"},
    {"diagnose", "-o", "", "diagnose impact-oscillator", "-o x.png", "made:x.png"},
    {"diagnose", "--data", "", "diagnose impact-oscillator -o s.png", "--data d.h5", "made:d.h5"},
    {"diagnose", "--data", "", "diagnose impact-oscillator -o s.png", "--data d.h5", "made:d.gp"},
    {"diagnose", "--transient", "", "diagnose " TWICE " --measure 0 -o s.png", "--transient 3",
     "differs:out"},
    {"diagnose", "--longest", "", "diagnose " TWICE " --measure 0 --transient 100 -o s.png", "--longest 1",
     "differs:out"},
    {"diagnose", "--measure", "", "diagnose " CHAOS " --transient 100 --measure 0 -o s.png", "--measure 8000",
     "differs:out"},
    {"diagnose", "--lifetime", "", "diagnose " CHAOS " --transient 100 --measure 8000 -o s.png",
     "--lifetime 300", "differs:out"},
    {"diagnose", "--rtol", "", DIAGNOSE, FLOW, "attr:d.h5:/:rtol=1e-6"},
    {"diagnose", "--atol", "", DIAGNOSE, FLOW, "attr:d.h5:/:atol=1e-7"},
    {"diagnose", "--integrator", "", DIAGNOSE, FLOW, "attr:d.h5:/:integrator=radau"},

    {"simulate", "--set", "", SIMULATE, "--set F=0.6", "differs:r.h5"},
    {"simulate", "--transient", "", SIMULATE, "--transient 1", "differs:r.h5"},
    {"simulate", "--samples", "", "simulate impact-oscillator --set d=9 --periods 2 -o r.h5", "--samples 16",
     "rows:r.h5:trajectory/time=33"},
    {"simulate", "-o", "", "simulate impact-oscillator --periods 2", "-o x.csv", "made:x.csv"},
    {"simulate", "--periods", "", SIMULATE, SIMULATE_SETS, "rows:r.h5:strobe/states=3"},
    {"simulate", "--rtol", "", SIMULATE, SIMULATE_SETS, "attr:r.h5:/:rtol=1e-6"},
    {"simulate", "--atol", "", SIMULATE, SIMULATE_SETS, "attr:r.h5:/:atol=1e-7"},
    {"simulate", "--integrator", "", SIMULATE, SIMULATE_SETS, "attr:r.h5:/:integrator=radau"},

    {"orbit", "--set", "", "orbit impact-oscillator --periods 1 --json", "--set F=0.6",
     "json:parameters.F=0.6"},
    {"orbit", "--periods", "", "orbit " TWICE " --periods 1 --json", "--periods 2", "json:periods=2"},
    {"orbit", "--from", "", "orbit impact-oscillator --periods 1 --json", "--from ../in/orbit.json",
     "json:parameters.omega=1.01"},
    {"diagnose", "--from", "", DIAGNOSE, "--from ../in/orbit.json", "differs:script"},
    {"simulate", "--from", "", SIMULATE, "--from ../in/orbit.json", "differs:r.h5"},
    {"lyapunov", "--from", "", LYAPUNOV " --set c=0.1", "--from ../in/chaotic.json", "json:members=0"},
    {"spectrum", "--from", "", SPECTRUM_JSON, "--from ../in/orbit.json", "json:parameters.omega=1.01"},
    {"orbit", "--transient", "", "orbit impact-oscillator --periods 1 --verbose", "--transient 3",
     "differs:err"},
    {"orbit", "--mirror", "", "orbit ../in/sides.yaml --periods 1 --json", "--mirror", "differs:out"},
    {"orbit", "--unstable", "", "orbit " CHAOS " --periods 2 --search 500 --transient 50 --json",
     "--unstable", "lines:out=2"},
    {"orbit", "--search", "", "orbit " CHAOS " --periods 2 --unstable --search 500", "--search 300",
     "differs:out"},
    {"orbit", "--most", "", "orbit " CHAOS " --periods 2 --unstable --search 500 --json", "--most 1",
     "lines:out=1"},
    {"orbit", "--segments", "", "orbit impact-oscillator --periods 4 --transient 3 --verbose", "--segments 3",
     "differs:err"},
    {"orbit", "--json", "", "orbit impact-oscillator --periods 1", "--json", "text:out:{\"version\": "},
    {"orbit", "--verbose", "", "orbit impact-oscillator --periods 1", "--verbose", "differs:err"},
    {"orbit", "--rtol", "", "orbit impact-oscillator --periods 1 --json", "--rtol 1e-4", "differs:out"},
    {"orbit", "--atol", "", "orbit impact-oscillator --periods 1 --json", "--atol 1e-3", "differs:out"},
    {"orbit", "--integrator", "", "orbit impact-oscillator --periods 1 --json", "--integrator radau",
     "json:integrator=radau"},

    {"continue", "--from", "", CONTINUE, "--from ../in/orbit.json", "attr:b.h5:/parameters:omega=1.01"},
    {"continue", "--in", "", CONTINUE, CONTINUE_DOWN, "attr:b.h5:/continuation:key1=c"},
    {"continue", "--direction", "", CONTINUE, CONTINUE_DOWN, "attr:b.h5:/continuation:direction=down"},
    {"continue", "--direction", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:direction=up"},
    {"continue", "--in", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:low1=0.98"},
    {"continue", "--in", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:high1=1.03"},
    {"continue", "--set", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/parameters:F=0.6"},
    {"continue", "--periods", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/start:periods=2"},
    {"continue", "--step", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:step=0.007"},
    {"continue", "--step-max", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:step_max=0.2"},
    {"continue", "--points", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:points=4"},
    {"continue", "--switch", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:switches=1"},
    {"continue", "--at", "", CONTINUE, CONTINUE_SETS, "rows:b.h5:continuation/values=2"},
    {"continue", "--rtol", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:rtol=1e-11"},
    {"continue", "--atol", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:atol=1e-13"},
    {"continue", "--integrator", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/continuation:integrator=radau"},
    {"continue", "--integrator", "", CONTINUE, CONTINUE_SETS, "attr:b.h5:/:integrator=radau"},
    {"continue", "--json", "", CONTINUE, "--json", "text:out:\"arclength\": "},
    {"continue", "--locus", "", "continue ../in/flip.yaml --from ../in/flip.json --in omega=2.55:2.7 -o b.h5",
     "--locus PD --and r=0.79:0.81", "attr:b.h5:/continuation:locus=PD"},
    {"continue", "--and", "", "continue ../in/flip.yaml --from ../in/flip.json --in omega=2.55:2.7 -o b.h5",
     "--locus PD --and r=0.79:0.81", "attr:b.h5:/continuation:high2=0.81"},
    {"continue", "--resume", CONTINUE, "continue impact-oscillator --in omega=0.99:1.01 --points 5 -o b.h5",
     "--resume", "attr:b.h5:/continuation:points=2"},
    {"continue", "--transient", "", "continue " TWICE " --in omega=2.69:2.71 --points 2 -o b.h5",
     "--transient 3", "refused"},
    {"continue", "--longest", "",
     "continue " TWICE " --in omega=2.69:2.71 --points 2 --transient 200 -o b.h5", "--longest 1", "refused"},
    {"continue", "-o", "", "continue impact-oscillator --in omega=0.99:1.01 --points 2", "-o x.h5",
     "made:x.h5"},

    {"sweep", "--set", "", SWEEP, SWEEP_SETS, "attr:s.h5:/parameters:F=0.6"},
    {"sweep", "--seeds", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:seeds=3"},
    {"sweep", "--seed", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:seed=7"},
    {"sweep", "--what", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:keep=impacts,lyapunov"},
    {"sweep", "--at-most", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:transient=300"},
    {"sweep", "--longest", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:longest=9"},
    {"sweep", "--record", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:record=12"},
    {"sweep", "--measure", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:measure=4321"},
    {"sweep", "--lifetime", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:lifetime=1234"},
    {"sweep", "--rtol", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:rtol=1e-6"},
    {"sweep", "--atol", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:atol=1e-7"},
    {"sweep", "--integrator", "", SWEEP, SWEEP_SETS, "attr:s.h5:/sweep:integrator=radau"},
    {"sweep", "--over", "", SWEEP, SWEEP_OVER, "attr:s.h5:/sweep:key2=c"},
    {"sweep", "--over", "", SWEEP, SWEEP_OVER, "attr:s.h5:/sweep:spacing2=logarithmic"},
    {"sweep", "--start", "", SWEEP, SWEEP_OVER, "attr:s.h5:/sweep:passes=reset,up,down"},
    {"sweep", "--what", "", SWEEP, SWEEP_OVER, "attr:s.h5:/sweep:keep=stroboscopic"},
    {"sweep", "--over", "", SWEEP, SWEEP_LIST, "rows:s.h5:axes/axis2=3"},
    {"sweep", "--start", "", SWEEP, SWEEP_LIST, "attr:s.h5:/sweep:passes=up,down"},
    {"sweep", "--what", "", SWEEP, SWEEP_LIST, "attr:s.h5:/sweep:keep=turning"},
    {"sweep", "--transient", "", SWEEP, "--transient 33", "attr:s.h5:/sweep:transient=33"},
    {"sweep", "--transient", "", SWEEP, "--transient 33", "attr:s.h5:/sweep:adaptive=0"},
    {"sweep", "--threads", "", SWEEP, "--threads 2", "same:s.h5"},
    {"sweep", "--json", "", SWEEP, "--json", "text:out:{\"version\": "},
    {"sweep", "-o", "", "sweep impact-oscillator --over omega=0.9:1.1:2 --quiet", "-o x.csv", "made:x.csv"},
    {"sweep", "--resume", SWEEP, SWEEP " --json", "--resume", "json:computed=0"},
    {"sweep", "--lanes", "", SWEEP " --lanes 1", "--lanes 2", "same:s.h5"},

    {"basins", "--set", "", BASINS, BASINS_SETS, "attr:s.h5:/parameters:F=0.6"},
    {"basins", "--at-most", "", BASINS, BASINS_SETS, "attr:s.h5:/sweep:transient=300"},
    {"basins", "--longest", "", BASINS, BASINS_SETS, "attr:s.h5:/sweep:longest=9"},
    {"basins", "--rtol", "", BASINS, BASINS_SETS, "attr:s.h5:/sweep:rtol=1e-6"},
    {"basins", "--atol", "", BASINS, BASINS_SETS, "attr:s.h5:/sweep:atol=1e-7"},
    {"basins", "--integrator", "", BASINS, BASINS_SETS, "attr:s.h5:/sweep:integrator=radau"},
    {"basins", "--threads", "", BASINS, "--threads 2", "same:s.h5"},
    {"basins", "--json", "", BASINS, "--json", "text:out:{\"version\": "},
    {"basins", "--over", "", "basins impact-oscillator --over q1=0:0.2:2 --quiet -o s.h5",
     "--over v1=0:0.2:3", "rows:s.h5:axes/axis2=3"},
    {"basins", "-o", "", "basins impact-oscillator --over q1=0:0.2:2 --over v1=0:0.2:2 --quiet", "-o x.h5",
     "made:x.h5"},
    {"basins", "--resume", BASINS, BASINS " --json", "--resume", "json:computed=0"},
    {"basins", "--lanes", "", BASINS " --lanes 1", "--lanes 2", "same:s.h5"},

    {"lyapunov", "--set", "", LYAPUNOV, LYAPUNOV_SETS, "json:parameters.F=1.1"},
    {"lyapunov", "--precision", "", LYAPUNOV, LYAPUNOV_SETS, "json:options.precision=0.5"},
    {"lyapunov", "--transient", "", LYAPUNOV, LYAPUNOV_SETS, "json:options.transient=31"},
    {"lyapunov", "--periods", "", LYAPUNOV, LYAPUNOV_SETS, "json:options.periods=3200"},
    {"lyapunov", "--members", "", LYAPUNOV, LYAPUNOV_SETS, "json:options.members=3"},
    {"lyapunov", "--interval", "", LYAPUNOV, LYAPUNOV_SETS, "json:options.interval=2"},
    {"lyapunov", "--seed", "", LYAPUNOV, LYAPUNOV_SETS, "json:options.seed=4"},
    {"lyapunov", "--rtol", "", LYAPUNOV, LYAPUNOV_SETS, "json:options.rtol=1e-7"},
    {"lyapunov", "--atol", "", LYAPUNOV, LYAPUNOV_SETS, "json:options.atol=1e-8"},
    {"lyapunov", "--all", "", LYAPUNOV, "--all", "count:exponents=2"},
    {"lyapunov", "--exponents", "", LYAPUNOV, "--exponents 2", "count:exponents=2"},
    {"lyapunov", "--integrator", "", LYAPUNOV, "--integrator radau", "json:options.integrator=radau"},
    {"lyapunov", "--integrator", "", LYAPUNOV, "--integrator radau", "json:integrator=radau"},
    {"lyapunov", "--json", "", "lyapunov impact-oscillator --transient 20 --periods 1800", "--json",
     "text:out:{\"version\": "},
    {"lyapunov", "-o", "", LYAPUNOV, "-o x.csv", "made:x.csv"},

    {"spectrum", "--set", "", SPECTRUM_JSON, "--set F=0.6", "differs:out"},
    {"spectrum", "--of", "", SPECTRUM_JSON, SPECTRUM_LOOKS, "json:spectra.0.quantity=v1"},
    {"spectrum", "--periods", "", SPECTRUM_JSON, SPECTRUM_LOOKS, "json:analysed_periods=4"},
    {"spectrum", "--samples", "", SPECTRUM_JSON, SPECTRUM_LOOKS, "json:samples_per_period=128"},
    {"spectrum", "--integrator", "", SPECTRUM_JSON, "--integrator radau", "json:integrator=radau"},
    {"spectrum", "--segment", "", "spectrum " CHAOS " --transient 60 --periods 128 --samples 32 --json",
     "--segment 16", "json:spectra.0.resolution=0.0625"},
    {"spectrum", "--json", "", "spectrum impact-oscillator --samples 64", "--json",
     "text:out:{\"version\": "},
    {"spectrum", "-o", "", "spectrum impact-oscillator --samples 64", "-o x.csv", "made:x.csv"},
    {"spectrum", "--rtol", "", SPECTRUM, SPECTRUM_SETS, "text:s.csv:rtol = 9.99999999999999"},
    {"spectrum", "--atol", "", SPECTRUM, SPECTRUM_SETS, "text:s.csv:atol = 0.0009765625,"},
    {"spectrum", "--integrator", "", SPECTRUM, SPECTRUM_SETS, "text:s.csv:integrator = radau (radau)"},
    {"spectrum", "--transient", "", "spectrum " TWICE " --samples 64 --json --periods 128", "--transient 3",
     "differs:out"},
    {"spectrum", "--longest", "", "spectrum " TWICE " --samples 64 --json --periods 128 --transient 200",
     "--longest 1", "differs:out"},

    {"diagnose", "--size", "", "diagnose impact-oscillator -o x.png", "--size column", "differs:script"},
    {"diagnose", "--no-heading", "", "diagnose impact-oscillator -o x.png", "--no-heading", "differs:script"},
    {"diagnose", "--title", "", "diagnose impact-oscillator -o x.png", "--title own", "differs:script"},
    {"diagnose", "--keep-script", "", "diagnose impact-oscillator -o x.png", "--keep-script x.gp",
     "made:x.gp"},
    {"spectrum", "--size", "", "spectrum impact-oscillator --samples 64 -o x.png", "--size column",
     "differs:script"},
    {"spectrum", "--no-heading", "", "spectrum impact-oscillator --samples 64 -o x.png", "--no-heading",
     "differs:script"},
    {"spectrum", "--title", "", "spectrum impact-oscillator --samples 64 -o x.png", "--title own",
     "differs:script"},
    {"spectrum", "--keep-script", "", "spectrum impact-oscillator --samples 64 -o x.png",
     "--keep-script x.gp", "made:x.gp"},
    {"lyapunov", "--size", "", "lyapunov impact-oscillator --periods 1800 --transient 20 -o x.png",
     "--size column", "differs:script"},
    {"lyapunov", "--no-heading", "", "lyapunov impact-oscillator --periods 1800 --transient 20 -o x.png",
     "--no-heading", "differs:script"},
    {"lyapunov", "--title", "", "lyapunov impact-oscillator --periods 1800 --transient 20 -o x.png",
     "--title own", "differs:script"},
    {"lyapunov", "--keep-script", "", "lyapunov impact-oscillator --periods 1800 --transient 20 -o x.png",
     "--keep-script x.gp", "made:x.gp"},
    {"plot", "--size", "", "plot ../in/branch.h5 -o x.png", "--size column", "differs:script"},
    {"plot", "--no-heading", "", "plot ../in/branch.h5 -o x.png", "--no-heading", "differs:script"},
    {"plot", "--title", "", "plot ../in/branch.h5 -o x.png", "--title own", "differs:script"},
    {"plot", "--keep-script", "", "plot ../in/branch.h5 -o x.png", "--keep-script x.gp", "made:x.gp"},
    {"plot", "--swap", "", "plot ../in/branch.h5 -o x.png", "--swap", "differs:script"},
    {"plot", "--log", "", "plot ../in/branch.h5 -o x.png", "--log omega", "differs:script"},
    {"plot", "-o", "", "plot ../in/branch.h5", "-o x.png", "made:x.png"},
    {"plot", "--show", "", "plot ../in/branch.h5 -o x.png", "--show displacement", "differs:script"},
    {"plot", "--show", "", "plot ../in/branch.h5 -o x.png", "--show velocity", "differs:script"},
    {"plot", "--show", "", "plot ../in/branch.h5 -o x.png", "--show period", "differs:script"},
    {"plot", "--range", "", "plot ../in/branch.h5 -o x.png", "--range omega=0.995:1.003", "differs:script"},
    {"plot", "--label", "", "plot ../in/plane.h5 -o x.png", "--label r=0.8,omega=2.6562,here",
     "text:script:here"},
    {"plot", "--label", "", "plot ../in/sweep.h5 --view impacts --over ../in/branch.h5 -o x.png",
     "--label omega=1,impacts=1.1,Mine", "text:script:Mine"},
    {"plot", "--view", "", "plot ../in/sweep.h5 -o x.png", "--view impacts", "differs:script"},
    {"plot", "--view", "", "plot ../in/sweep.h5 -o x.png", "--view stroboscopic", "differs:script"},
    {"plot", "--view", "", "plot ../in/map.h5 -o x.png", "--view attractors", "differs:script"},
    {"plot", "--view", "", "plot ../in/map.h5 -o x.png", "--view largest", "differs:script"},
    {"plot", "--view", "", "plot ../in/map.h5 -o x.png", "--view speed", "differs:script"},
    {"plot", "--view", "", "plot ../in/map.h5 -o x.png", "--view rate", "differs:script"},
    {"plot", "--view", "", "plot ../in/map.h5 -o x.png", "--view contact", "differs:script"},
    {"plot", "--view", "", "plot ../in/map.h5 -o x.png", "--view lyapunov", "differs:script"},
    {"plot", "--view", "", "plot ../in/map.h5 -o x.png", "--view settled", "differs:script"},
    {"plot", "--title", "", "plot ../in/sweep.h5 -o x.png", "--title 'of one more kind'",
     "text:script:of one more kind"},
    {"plot", "--over", "", "plot ../in/sweep.h5 --view impacts -o x.png", "--over ../in/branch.h5",
     "differs:script"},

    {"export", "--table", "", "export ../in/sweep.h5 -o x.csv", "--table turning", "differs:x.csv"},
    {"export", "--table", "", "export ../in/sweep.h5 -o x.csv", "--table impacts", "differs:x.csv"},
    {"export", "--table", "", "export ../in/sweep.h5 -o x.csv", "--table stroboscopic", "differs:x.csv"},
    {"export", "-o", "", "export ../in/sweep.h5", "-o x.csv", "made:x.csv"},

    {"paper", "--figure", "", "paper --figure 3 -o p", "--figure 3 --format svg", "made:p/fig3.svg"},
    {"paper", "-o", "", "paper --figure 3", "-o elsewhere", "made:elsewhere/fig3.png"},
    {"paper", "--format", "", "paper --figure 3 -o p", "--format pdf", "made:p/fig3.pdf"},
    {"paper", "--size", "", "paper --figure 3 -o p", "--size column", "differs:script"},
    {"paper", "--no-heading", "", "paper --figure 3 -o p", "--no-heading", "differs:script"},

    {"check", "--set", "", "check impact-oscillator", "--set F=0.6", "differs:out"},
    {"check", "--derivatives", "", "check impact-oscillator", "--derivatives", "differs:out"},
};

/* Options that have their own case below. */
static const char *const others[] = {"paper --quick", "paper --resume"};

static void put_text(const fixture *f, const char *name, const char *text) {
    char path[320];
    snprintf(path, sizeof path, "%s/%s", f->folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* A command line with additional options: those that may be given once replace the line's own, with their
 * values. */
static void join(const char *line, const char *more, char *text, size_t room) {
    static const char *const repeated[] = {"--set", "--over", "--of", "--label", "--range"};
    size_t used = 0;
    for (const char *at = line; *at;) {
        size_t length = strcspn(at, " ");
        char name[32];
        snprintf(name, sizeof name, "%.*s", (int)(length < 31 ? length : 31), at);
        const char *same = at[0] == '-' ? strstr(more, name) : NULL;
        while (same && ((same > more && same[-1] != ' ') || (same[length] && same[length] != ' ')))
            same = strstr(same + 1, name);
        for (size_t k = 0; k < sizeof repeated / sizeof repeated[0]; k++)
            same = strcmp(name, repeated[k]) == 0 ? NULL : same;
        const char *next = at + length + (at[length] == ' ');
        if (same && next[0] != '-') /* its value */
            next += strcspn(next, " ") + (next[strcspn(next, " ")] == ' ');
        if (!same)
            used += (size_t)snprintf(text + used, room - used, "%.*s ", (int)length, at);
        at = next;
    }
    snprintf(text + used, room - used, "%s", more);
}

/* The exit status of a command line in one of the fixture's folders; the program's path is added. */
static int run_in(const fixture *f, const char *where, const char *command, const char *more) {
    char text[1600], line[1200];
    join(command, more, line, sizeof line);
    snprintf(text, sizeof text, "cd %s/%s && PATH=%s/tools:$PATH && export PATH && { %s %s; } >out 2>err",
             f->folder, where, f->folder, SALTUS_COMMAND, line);
    int outcome = system(text);
    return WIFEXITED(outcome) ? WEXITSTATUS(outcome) : 128;
}

static void *text_of(const fixture *f, const char *where, const char *name, size_t *length) {
    char path[320];
    snprintf(path, sizeof path, "%s/%s/%s", f->folder, where, name);
    return read_all(path, length);
}

static bool is_there(const fixture *f, const char *where, const char *name) {
    char path[320];
    snprintf(path, sizeof path, "%s/%s/%s", f->folder, where, name);
    return access(path, F_OK) == 0;
}

static void clear(const fixture *f, const char *where) {
    char path[96], text[128];
    snprintf(path, sizeof path, "%s/%s", f->folder, where);
    if (folder_files(path, true) > 0 && folder_files(path, false) > 0) {
        snprintf(text, sizeof text, "rm -rf %s/*", path); /* folders of figures */
        assert_int_equal(system(text), 0);
    }
}

static void must(const fixture *f, const char *line) {
    size_t length;
    if (run_in(f, "in", line, "") != 0)
        fail_msg("%s: %s", line, (char *)text_of(f, "in", "err", &length));
}

static void prepare(const fixture *f) {
    static const char oscillator[] = "model: oscillator\nc: 0.05\nF: 1\nomega: %s\nstop: {d: 0, r: 0.8}\n";
    char text[256];
    put_text(f, "tools/gnuplot",
             "#!/bin/sh\ncat >script\nprintf '\\211PNG\\r\\n'\nprintf %080d 0\nprintf 'IEND....'\n");
    snprintf(text, sizeof text, "%s/tools/gnuplot", f->folder);
    chmod(text, 0755);
    snprintf(text, sizeof text, oscillator, "2.8");
    put_text(f, "in/chaos.yaml", text);
    snprintf(text, sizeof text, oscillator, "2.7");
    put_text(f, "in/twice.yaml", text);
    snprintf(text, sizeof text, oscillator, "2.6");
    put_text(f, "in/flip.yaml", text);
    put_text(f, "in/sides.yaml",
             "model: oscillator\nc: 0.1\nF: 0.5\nomega: 1\nstop: {d: 1, r: 0.8, sides: both}\n");
    must(f, "orbit impact-oscillator --set omega=1.01 --periods 1 --json >orbit.json");
    must(f, "orbit chaos.yaml --periods 1 --json >chaotic.json");
    must(f, "orbit flip.yaml --periods 1 --json >flip.json");
    must(f, "continue impact-oscillator --in omega=0.99:1.01 -o branch.h5");
    must(f,
         "continue flip.yaml --from flip.json --in omega=2.55:2.7 --locus PD --and r=0.79:0.81 -o plane.h5");
    must(f, "sweep impact-oscillator --over omega=0.9:1.1:5 --what turning,impacts,stroboscopic --quiet -o "
            "sweep.h5");
    must(f, "sweep impact-oscillator --over omega=0.9:2.9:3 --over F=0.3:0.6:2 --what lyapunov --quiet -o "
            "map.h5");
}

static int open_fixture(void **state) {
    static const char *const rooms[] = {"in", "base", "with", "tools"};
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    for (int k = 0; k < 4; k++) {
        char path[320];
        snprintf(path, sizeof path, "%s/%s", f->folder, rooms[k]);
        mkdir(path, 0777);
    }
    /* Equal results give equal files at any time. */
    setenv("SOURCE_DATE_EPOCH", "0", 1);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    prepare(f);
    *state = f;
    return 0;
}

static int close_fixture(void **state) {
    fixture *f = *state;
    char text[128];
    snprintf(text, sizeof text, "rm -rf %s", f->folder);
    int outcome = system(text);
    free(f);
    return outcome;
}

/* Whether a value is the witness's: numbers compare as numbers. */
static bool is_value(const char *wanted, bool number, double value, const char *text) {
    return number ? value == strtod(wanted, NULL) : text && strcmp(text, wanted) == 0;
}

static bool json_tells(const fixture *f, const char *where, const char *path, const char *wanted,
                       bool count) {
    size_t length;
    char *text = text_of(f, where, "out", &length);
    const char *at = text;
    json *object = json_value(&at); /* the first where there are several */
    const json *found = json_find(object, path);
    bool told = found && (count ? json_count(found) == atoi(wanted)
                                : is_value(wanted, found->kind == JSON_NUMBER, found->number, found->text));
    json_free(object);
    free(text);
    return told;
}

static bool attribute_tells(const char *file, const char *group, const char *name, const char *wanted) {
    double number = 0;
    char text[256] = "";
    hid_t from = H5Fopen(file, H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(from >= 0);
    bool told = H5Aexists_by_name(from, group, name, H5P_DEFAULT) > 0;
    if (told) {
        hid_t attribute = H5Aopen_by_name(from, group, name, H5P_DEFAULT, H5P_DEFAULT);
        hid_t type = H5Aget_type(attribute);
        bool words = H5Tget_class(type) == H5T_STRING;
        if (words)
            H5Aread(attribute, type, text);
        else
            H5Aread(attribute, H5T_NATIVE_DOUBLE, &number);
        told = is_value(wanted, !words, number, text);
        H5Tclose(type);
        H5Aclose(attribute);
    }
    H5Fclose(from);
    return told;
}

static bool rows_tell(const char *file, const char *name, const char *wanted) {
    hsize_t extent[8] = {0};
    hid_t from = H5Fopen(file, H5F_ACC_RDONLY, H5P_DEFAULT);
    bool there = from >= 0 && H5Lexists(from, name, H5P_DEFAULT) > 0;
    if (there) {
        hid_t set = H5Dopen2(from, name, H5P_DEFAULT), space = H5Dget_space(set);
        H5Sget_simple_extent_dims(space, extent, NULL);
        H5Sclose(space);
        H5Dclose(set);
    }
    if (from >= 0)
        H5Fclose(from);
    return there && extent[0] == strtoull(wanted, NULL, 10);
}

static bool text_tells(const fixture *f, const char *where, const char *name, const char *wanted,
                       bool lines) {
    size_t length;
    char *text = text_of(f, where, name, &length);
    int count = 0;
    for (size_t k = 0; k < length; k++)
        count += text[k] == '\n';
    bool told = lines ? count == atoi(wanted) : strstr(text, wanted) != NULL;
    free(text);
    return told;
}

/* Compare two HDF5 files object by object, datasets by their bytes; stops at a difference. */
static herr_t same_attribute(hid_t first, const char *name, const H5A_info_t *info, void *context) {
    char bytes[2][4096] = {{0}};
    hid_t owner[2] = {first, *(hid_t *)context};
    (void)info;
    for (int k = 0; k < 2; k++) {
        hid_t attribute = H5Aexists(owner[k], name) > 0 ? H5Aopen(owner[k], name, H5P_DEFAULT) : -1;
        hid_t type = attribute >= 0 ? H5Aget_type(attribute) : -1;
        bool read = type >= 0 && H5Aget_storage_size(attribute) <= sizeof bytes[k] &&
                    H5Aread(attribute, type, bytes[k]) >= 0;
        H5Tclose(type);
        H5Aclose(attribute);
        if (!read)
            return 1;
    }
    return memcmp(bytes[0], bytes[1], sizeof bytes[0]) != 0;
}

static bool same_dataset(const hid_t set[2]) {
    unsigned char *bytes[2];
    size_t size[2];
    bool read = true;
    for (int k = 0; k < 2; k++) {
        hid_t type = H5Dget_type(set[k]), space = H5Dget_space(set[k]);
        size[k] = (size_t)H5Sget_simple_extent_npoints(space) * H5Tget_size(type);
        bytes[k] = calloc(size[k] + 1, 1);
        read = read && (size[k] == 0 || H5Dread(set[k], type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes[k]) >= 0);
        H5Sclose(space);
        H5Tclose(type);
    }
    bool same = read && size[0] == size[1] && memcmp(bytes[0], bytes[1], size[0]) == 0;
    free(bytes[0]);
    free(bytes[1]);
    return same;
}

static herr_t same_object(hid_t first, const char *name, const H5O_info_t *info, void *context) {
    const hid_t second = *(hid_t *)context;
    if (strcmp(name, "command") == 0)
        return 0; /* it lists the options, whatever their effect */
    if (strcmp(name, ".") != 0 && H5Lexists(second, name, H5P_DEFAULT) <= 0)
        return 1;
    hid_t object[2] = {H5Oopen(first, name, H5P_DEFAULT), H5Oopen(second, name, H5P_DEFAULT)};
    bool same = object[0] >= 0 && object[1] >= 0 &&
                H5Aiterate2(object[0], H5_INDEX_NAME, H5_ITER_INC, NULL, same_attribute, &object[1]) == 0 &&
                (info->type != H5O_TYPE_DATASET || same_dataset(object));
    H5Oclose(object[0]);
    H5Oclose(object[1]);
    return !same;
}

static bool same_results(const fixture *f, const char *name) {
    char path[320];
    hid_t file[2];
    hsize_t members[2];
    bool same = true;
    for (int k = 0; k < 2; k++) {
        H5G_info_t group;
        snprintf(path, sizeof path, "%s/%s/%s", f->folder, k ? "with" : "base", name);
        file[k] = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
        assert_true(file[k] >= 0 && H5Gget_info(file[k], &group) >= 0);
        members[k] = group.nlinks;
    }
    same = members[0] == members[1] &&
           H5Ovisit1(file[0], H5_INDEX_NAME, H5_ITER_INC, same_object, &file[1]) == 0;
    H5Fclose(file[0]);
    H5Fclose(file[1]);
    return same;
}

static bool same_files(const fixture *f, const char *name) {
    size_t a, b;
    if (strstr(name, ".h5"))
        return same_results(f, name);
    void *first = text_of(f, "base", name, &a), *second = text_of(f, "with", name, &b);
    bool same = a == b && memcmp(first, second, a) == 0;
    free(first);
    free(second);
    return same;
}

/* Whether a run in one of the folders shows the witness's effect. */
static bool tells(const fixture *f, const char *where, const char *witness) {
    char copy[256], path[320], *part[4] = {NULL}, *rest = copy;
    snprintf(copy, sizeof copy, "%s", witness);
    bool words = strncmp(witness, "text:", 5) == 0;
    for (int k = 0; k < (words ? 2 : 4) && *rest; k++) {
        part[k] = rest;
        rest += strcspn(rest, k || words ? ":=" : ":");
        if (*rest)
            *rest++ = '\0';
    }
    if (words)
        part[2] = rest;
    snprintf(path, sizeof path, "%s/%s/%s", f->folder, where, part[1] ? part[1] : "");
    if (strcmp(part[0], "json") == 0 || strcmp(part[0], "count") == 0)
        return json_tells(f, where, part[1], part[2], part[0][0] == 'c');
    if (strcmp(part[0], "rows") == 0)
        return rows_tell(path, part[2], part[3]);
    if (strcmp(part[0], "attr") == 0) {
        const char *wanted = strrchr(witness, '=') + 1;
        char name[64];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(part[3], "="), part[3]);
        return attribute_tells(path, part[2], name, wanted);
    }
    if (strcmp(part[0], "made") == 0)
        return is_there(f, where, part[1]);
    assert_true(words || strcmp(part[0], "lines") == 0);
    return text_tells(f, where, part[1], part[2], !words);
}

/* What is wrong, or NULL. */
static const char *check_case(fixture *f, const option_case *c) {
    char key[sizeof f->last], changed[sizeof f->with];
    bool made = strncmp(c->witness, "made:", 5) == 0, rows = strncmp(c->witness, "rows:", 5) == 0;
    snprintf(key, sizeof key, "%s; %s", c->before, c->base);
    snprintf(changed, sizeof changed, "%s; %s", key, c->more);
    if (!made && strcmp(key, f->last) != 0) {
        clear(f, "base");
        if (c->before[0])
            assert_int_equal(run_in(f, "base", c->before, ""), 0);
        f->status = run_in(f, "base", c->base, "");
        strcpy(f->last, key);
    }
    if (strcmp(changed, f->with) != 0) {
        clear(f, "with");
        if (c->before[0])
            assert_int_equal(run_in(f, "with", c->before, ""), 0);
        f->changed = run_in(f, "with", c->base, c->more);
        strcpy(f->with, changed);
    }
    int status = f->changed;
    if (!made && !rows && f->status != 0)
        return "fails without the option";
    if (strcmp(c->witness, "refused") == 0)
        return status == 2 ? NULL : "is accepted with the option";
    if (status != 0)
        return "fails with the option";
    const char *name = strchr(c->witness, ':') + 1;
    if (strncmp(c->witness, "differs:", 8) == 0)
        return same_files(f, name) ? "gives the same with the option" : NULL;
    if (strncmp(c->witness, "same:", 5) == 0)
        return same_files(f, name) ? NULL : "gives something else with the option";
    if (!tells(f, "with", c->witness))
        return "does not show it with the option";
    return !made && tells(f, "base", c->witness) ? "shows it without the option, too" : NULL;
}

static void each_option_takes_effect(void **state) {
    /* Sanitizers are slow, and the code behind most options is the same. */
    const size_t stride = getenv("SALTUS_SANITIZED") ? 12 : 1;
    int wrong = 0;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k += stride) {
        const char *what = check_case(*state, &cases[k]);
        if (what)
            print_error("%s %s: %s: %s\n", cases[k].base, cases[k].more, what, cases[k].witness);
        wrong += what != NULL;
    }
    assert_int_equal(wrong, 0);
}

/* An option as the help lists it. */
typedef struct listed {
    char command[16], name[24], argument[24], line[256];
} listed;

/* All options of all commands, from their help, which is read once; returns their number. */
static int list_options(fixture *f, const listed **list) {
    static listed options[options_max];
    char commands[commands_max][16];
    *list = options;
    if (f->listed_count)
        return f->listed_count;
    size_t length;
    int count = 0, found = 0;
    assert_int_equal(run_in(f, "in", "--help", ""), 0);
    char *text = text_of(f, "in", "out", &length), *rest = text;
    for (char *line = strtok_r(rest, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest))
        if (strncmp(line, "  saltus ", 9) == 0 && count < commands_max)
            assert_int_equal(sscanf(line, "  saltus %15s", commands[count++]), 1);
    free(text);
    for (int k = 0; k < count; k++) {
        assert_int_equal(run_in(f, "in", commands[k], "--help"), 0);
        text = rest = text_of(f, "in", "out", &length);
        for (char *line = strtok_r(rest, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
            listed *o = &options[found];
            if (strncmp(line, "  -", 3) != 0)
                continue;
            assert_true(found < options_max);
            *o = (listed){.argument = ""};
            strcpy(o->command, commands[k]);
            snprintf(o->line, sizeof o->line, "%s", line);
            sscanf(line, "  %23s", o->name);
            const char *after = line + 2 + strlen(o->name);
            if (after[0] == ' ' && after[1] != ' ')
                sscanf(after, " %23s", o->argument);
            found++;
        }
        free(text);
    }
    assert_true(count >= 14 && found > 100);
    return f->listed_count = found;
}

static bool has_case(const listed *o) {
    char name[48];
    snprintf(name, sizeof name, "%.15s %.23s", o->command, o->name);
    for (size_t k = 0; k < sizeof others / sizeof others[0]; k++)
        if (strcmp(others[k], name) == 0)
            return true;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        if (strcmp(cases[k].command, o->command) == 0 && strcmp(cases[k].option, o->name) == 0)
            return true;
    /* quiet_commands_are_silent, and the tests of what a command may write to */
    return strcmp(o->name, "--quiet") == 0 || strcmp(o->name, "--force") == 0 ||
           (strcmp(o->name, "--format") == 0 && strcmp(o->command, "paper") != 0);
}

static void each_listed_option_has_a_case(void **state) {
    const listed *options;
    int count = list_options(*state, &options);
    for (int k = 0; k < count; k++)
        if (!has_case(&options[k]))
            fail_msg("nothing shows that %s %s takes effect", options[k].command, options[k].name);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        bool known = false;
        for (int k = 0; k < count && !known; k++)
            known = strcmp(cases[i].command, options[k].command) == 0 &&
                    strcmp(cases[i].option, options[k].name) == 0;
        if (!known)
            fail_msg("%s --help does not list %s", cases[i].command, cases[i].option);
    }
}

/* The default in the help of an option with a value: one word; its length, or 0. */
static int default_of(const listed *o, const char **word) {
    const char *at = strstr(o->line, "(default ");
    *word = at ? at + strlen("(default ") : NULL;
    int length = at ? (int)strcspn(*word, " )") : 0;
    return length && o->argument[0] && (*word)[length] == ')' ? length : 0;
}

/* Giving the default value explicitly changes nothing. */
static void told_defaults_change_nothing(void **state) {
    static const struct {
        const char *command, *line, *file;
    } runs[] = {{"classify", "classify impact-oscillator --json", "out"},
                {"simulate", SIMULATE, "r.h5"},
                {"orbit", "orbit impact-oscillator --periods 1 --json", "out"},
                {"continue", "continue impact-oscillator --in omega=0.996:1.004 -o b.h5", "b.h5"},
                {"lyapunov", "lyapunov " CHAOS " --precision 0.3 --transient 20 --json", "out"},
                {"spectrum", SPECTRUM_JSON, "out"},
                {"sweep", SWEEP, "s.h5"},
                {"basins", BASINS, "s.h5"}};
    const listed *options;
    const fixture *f = *state;
    int count = list_options(*state, &options);
    ((fixture *)*state)->last[0] = ((fixture *)*state)->with[0] = '\0';
    for (size_t k = 0; k < sizeof runs / sizeof runs[0]; k++) {
        char more[512] = "";
        size_t used = 0;
        int said = 0, length;
        for (int i = 0; i < count; i++) {
            const char *word;
            if (strcmp(options[i].command, runs[k].command) != 0 || strstr(runs[k].line, options[i].name) ||
                (length = default_of(&options[i], &word)) == 0)
                continue;
            used +=
                (size_t)snprintf(more + used, sizeof more - used, " %s %.*s", options[i].name, length, word);
            said++;
        }
        assert_true(said > 0 && used < sizeof more);
        clear(f, "base");
        clear(f, "with");
        if (run_in(f, "base", runs[k].line, "") != 0 || run_in(f, "with", runs[k].line, more) != 0 ||
            !same_files(f, runs[k].file))
            fail_msg("%s:%s is something else than nothing", runs[k].line, more);
    }
}

/* A complete command except for the option. */
static const char *beginning_of(const char *command) {
    static const char *const lines[][2] = {
        {"classify", "classify impact-oscillator"},
        {"diagnose", "diagnose impact-oscillator -o never.png"},
        {"simulate", "simulate impact-oscillator --periods 2 -o never.h5"},
        {"orbit", "orbit impact-oscillator --periods 1"},
        {"continue", "continue impact-oscillator --in omega=0.9:1.1 --locus GR --and d=0.9:1.1 -o never.h5"},
        {"sweep", "sweep impact-oscillator --over omega=0.9:1.1:2 -o never.h5"},
        {"basins", "basins impact-oscillator --over q1=0:1:2 --over v1=0:1:2 -o never.h5"},
        {"lyapunov", "lyapunov impact-oscillator"},
        {"spectrum", "spectrum impact-oscillator"},
        {"plot", "plot ../in/sweep.h5 --view impacts -o never.png"},
        {"export", "export ../in/sweep.h5 -o never.csv"},
        {"paper", "paper -o never"},
        {"scenes", "scenes"},
        {"check", "check impact-oscillator"}};
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++)
        if (strcmp(lines[k][0], command) == 0)
            return lines[k][1];
    fail_msg("no beginning for %s", command);
    return NULL;
}

/* Check exit status 2, nothing on stdout, one message on stderr with both words, and no file. */
static char *check_refused(const fixture *f, const char *line, const char *more, const char *one,
                           const char *other) {
    size_t length;
    clear(f, "with");
    int status = run_in(f, "with", line, more);
    char *out = text_of(f, "with", "out", &length), *err = text_of(f, "with", "err", &length);
    char *end = strchr(err, '\n');
    if (status != 2 || out[0] || strncmp(err, "saltus: ", 8) != 0 || !end || end[1] || !strstr(err, one) ||
        !strstr(err, other))
        fail_msg("%s %s: exit status %d, stdout '%s', stderr '%s'", line, more, status, out, err);
    char path[96];
    snprintf(path, sizeof path, "%s/with", f->folder);
    assert_int_equal(folder_files(path, false), 2);
    free(out);
    return err;
}

/* These accept any file or text. */
static bool takes_anything(const listed *o) {
    static const char *const names[] = {"-o", "--data", "--title"};
    for (int k = 0; k < 3; k++)
        if (strcmp(o->name, names[k]) == 0)
            return true;
    return false;
}

/* A command's numbers, all within their bounds, at the lower or the upper ones. */
typedef struct bounds {
    char at[2][1024];
} bounds;

/* A command line with a missing scene: with valid options it gets as far as that. */
static void without_scene(const char *command, char line[160]) {
    const char *beginning = beginning_of(command), *scene = strstr(beginning, "impact-oscillator");
    assert_non_null(scene);
    snprintf(line, 160, "%.*snosuchscene%s", (int)(scene - beginning), beginning,
             scene + strlen("impact-oscillator"));
}

/* The range of each number. An option with the same name and help line is the same in all commands: it is
 * listed with the first of them. */
static const struct {
    const char *command, *name;
    double low, high;
} promised[] = {
    {"classify", "--seeds", 1, 1000000},  {"classify", "--seed", 0, 4294967295.0},
    {"classify", "--transient", 1, 1e12}, {"classify", "--longest", 1, 1024},
    {"classify", "--measure", 0, 1e12},   {"classify", "--rtol", 1e-15, 1e-3},
    {"classify", "--lifetime", 0, 1e11},  {"sweep", "--lifetime", 0, 1e11},
    {"classify", "--atol", 0, 1},         {"simulate", "--periods", 1, 1e6},
    {"simulate", "--transient", 0, 1e12}, {"simulate", "--samples", 1, 1e5},
    {"orbit", "--periods", 1, 1e6},       {"orbit", "--transient", 0, 1e12},
    {"orbit", "--search", 1, 1e9},        {"orbit", "--most", 1, 1e6},
    {"orbit", "--segments", 0, 1e5},      {"continue", "--periods", 1, 1e6},
    {"continue", "--step", 0, 1},         {"continue", "--step-max", 0, 1},
    {"continue", "--points", 1, 1e7},     {"continue", "--switch", 0, 1000},
    {"sweep", "--seeds", 1, 10000},       {"sweep", "--at-most", 0, 1e9},
    {"sweep", "--longest", 1, 256},       {"sweep", "--transient", 0, 1e9},
    {"sweep", "--record", 1, 1e9},        {"sweep", "--measure", 0, 1e9},
    {"sweep", "--lanes", 0, 4096},        {"sweep", "--threads", 0, 4096},
    {"sweep", "--rtol", 1e-15, 1e-3},     {"sweep", "--atol", 0, 1},
    {"lyapunov", "--exponents", 0, 1000}, {"lyapunov", "--precision", 0, 1e6},
    {"lyapunov", "--transient", 0, 1e12}, {"lyapunov", "--periods", 1, 1e15},
    {"lyapunov", "--members", 1, 64},     {"lyapunov", "--interval", 0, 1000000},
    {"lyapunov", "--seed", 0, INFINITY},  {"spectrum", "--periods", 0, 1e6},
    {"spectrum", "--segment", 0, 1e6},    {"spectrum", "--samples", 16, 65536},
};

static void check_promised(const listed *o, const double bound[2]) {
    for (size_t k = 0; k < sizeof promised / sizeof promised[0]; k++)
        if (strcmp(promised[k].command, o->command) == 0 && strcmp(promised[k].name, o->name) == 0) {
            if (bound[0] != promised[k].low || bound[1] != promised[k].high)
                fail_msg("%s %s takes %.17g to %.17g", o->command, o->name, bound[0], bound[1]);
            return;
        }
    fail_msg("nothing is promised of %s %s", o->command, o->name);
}

/* Values beyond the bounds that the message states are refused. */
static void check_beyond(const fixture *f, const listed *o, const char *sentence, bounds *known) {
    const char *at = strstr(sentence, "number ");
    char line[160], more[128], whole = strstr(sentence, "whole number") != NULL, value[48];
    double bound[2];
    if (!at)
        return;
    /* With "number greater than 0 and at most 1" the lower bound is refused too. */
    bool open = sscanf(at, "number greater than %lf and %*s %*s %lf", &bound[0], &bound[1]) == 2;
    if (sscanf(at, "number of at least %lf", &bound[0]) == 1)
        bound[1] = INFINITY;
    else if (!open)
        assert_int_equal(sscanf(at, "number from %lf to %lf", &bound[0], &bound[1]), 2);
    check_promised(o, bound);
    without_scene(o->command, line);
    for (int k = 0; k < 2 && isfinite(bound[k]); k++) {
        double step = whole ? 1 : fmax(fabs(bound[k]), 1e-300) * 1e-9, beyond = bound[k] + (k      ? step
                                                                                            : open ? 0
                                                                                                   : -step);
        size_t used = strlen(known->at[k]);
        /* A sweep's --transient cannot be combined with the others. */
        bool alone = strcmp(o->command, "sweep") == 0 && strcmp(o->name, "--transient") == 0;
        snprintf(more, sizeof more, " %s %.17g", o->name, bound[k]);
        if (open && k == 0)
            used = 0; /* is not accepted */
        else if (alone)
            free(check_refused(f, line, more, "nosuchscene", ""));
        else
            snprintf(known->at[k] + used, sizeof known->at[k] - used, "%s", more);
        snprintf(value, sizeof value, "%.17g", beyond);
        snprintf(more, sizeof more, "%.23s %.47s", o->name, value);
        free(check_refused(f, line, more, o->name, value));
    }
    if (whole) {
        snprintf(more, sizeof more, "%.23s %.1f", o->name, bound[0] + 0.5);
        free(check_refused(f, line, more, o->name, "whole"));
    }
}

/* ... and the bounds themselves are accepted. */
static void check_accepted(const fixture *f, const char *command, bounds *known) {
    char line[160];
    for (int k = 0; k < 2 && known->at[k][0]; k++) {
        without_scene(command, line);
        free(check_refused(f, line, known->at[k], "nosuchscene", ""));
    }
    *known = (bounds){{""}};
}

static void bad_values_are_refused_by_name(void **state) {
    static char tried[options_max][128]; /* many commands share an option */
    int tries = 0;
    const listed *options;
    const fixture *f = *state;
    int count = list_options(*state, &options);
    bounds known = {{""}};
    bool lacking = true;
    for (int k = 0; k < count; k++) {
        const listed *o = &options[k];
        const char *line = beginning_of(o->command);
        char more[64];
        if (k && strcmp(o->command, options[k - 1].command) != 0) {
            check_accepted(f, options[k - 1].command, &known);
            lacking = true;
        }
        if (strcmp(o->command, "basins") == 0 && strcmp(o->name, "--over") == 0)
            line = "basins impact-oscillator --over q1=0:1:2 -o never.h5"; /* exactly two are required */
        /* Numbers are parsed in one place, from the same entry for all commands that list them alike. */
        bool shared = strcmp(o->name, "--integrator") != 0 && strcmp(o->name, "--from") != 0 &&
                      strcmp(o->name, "--over") != 0;
        for (int earlier = 0; earlier < k && shared; earlier++)
            if (strcmp(options[earlier].line, o->line) == 0)
                o = &options[earlier];
        if (!o->argument[0] || o != &options[k])
            continue;
        /* A missing value too; once for each command. */
        if (lacking)
            free(check_refused(f, line, o->name, o->name, ""));
        lacking = false;
        if (takes_anything(o))
            continue;
        snprintf(more, sizeof more, "%.23s not~good", o->name);
        bool file = strcmp(o->name, "--from") == 0 || (strcmp(o->name, "--over") == 0 && line[0] == 'p');
        char *sentence = check_refused(f, line, more, file ? "" : o->name, "not~good");
        int same = 0;
        while (same < tries && strncmp(tried[same], sentence, sizeof tried[0] - 1) != 0)
            same++;
        if (same == tries) {
            snprintf(tried[tries++], sizeof tried[0], "%.127s", sentence);
            check_beyond(f, o, sentence, &known);
        }
        free(sentence);
    }
    check_accepted(f, options[count - 1].command, &known);
}

/* Repeatable options have a limit: all values up to it are used, one more is refused by its text. */
static void lists_are_taken_up_to_their_room(void **state) {
    static const struct {
        const char *line, *before, *item, *last, *refused;
        int room;
    } lists[] = {
        {"check impact-oscillator --set", " ", "w%d=0.25", "F=0.75", "--set F=0.75: only 256 ", 256},
        {"plot ../in/branch.h5 -o x.png", " --label ", "r=1,omega=1,%d", "r=1,omega=1",
         "--label r=1,omega=1: only 256 ", 256},
        {"plot ../in/branch.h5 -o x.png", " --range ", "o%d=1:2", "omega=3", "--range omega=3: only 256 ",
         256},
        {"plot -o x.png", " ", "../in/link%d.h5", "nothere.h5", "nothere.h5: only 256 files ", 256},
        {"continue impact-oscillator --in omega=0.99:1.01 -o x.h5 --at 1", ",", "1", "2", "--at 2: only 256 ",
         256},
    };
    const fixture *f = *state;
    ((fixture *)*state)->last[0] = ((fixture *)*state)->with[0] = '\0';
    /* The same file under as many names. */
    for (int i = 0; i < 256; i++) {
        char name[512];
        snprintf(name, sizeof name, "%s/in/link%d.h5", f->folder, i);
        assert_int_equal(symlink("branch.h5", name), 0);
    }
    for (size_t k = 0; k < sizeof lists / sizeof lists[0]; k++) {
        const char *items = lists[k].before;
        for (int more = 0; more < 2; more++) {
            char line[8192];
            /* The first value of --at is in the line. */
            int count = lists[k].room + more - (items[0] == ','),
                used = snprintf(line, sizeof line, "%s", lists[k].line);
            for (int i = 0; i < count; i++) {
                char item[48];
                snprintf(item, sizeof item, i == count - 1 ? lists[k].last : lists[k].item, i);
                used += snprintf(line + used, sizeof line - (size_t)used, "%s%s", items, item);
            }
            assert_true(used < (int)sizeof line);
            put_text(f, "in/line", line);
            clear(f, "with");
            char text[512];
            size_t length;
            snprintf(text, sizeof text, "cd %s/with && %s $(cat ../in/line) >out 2>err", f->folder,
                     SALTUS_COMMAND);
            int outcome = system(text);
            char *err = text_of(f, "with", "err", &length), *out = text_of(f, "with", "out", &length);
            assert_true(WIFEXITED(outcome));
            bool refused = strncmp(err, "saltus: ", 8) == 0 &&
                           strncmp(err + 8, lists[k].refused, strlen(lists[k].refused)) == 0;
            if (refused != (more == 1) || WEXITSTATUS(outcome) != 2)
                fail_msg("%d times%s: status %d, %s%s", lists[k].room + more, items, WEXITSTATUS(outcome),
                         out, err);
            free(err);
            free(out);
        }
    }
}

static void unknown_options_are_refused_by_every_command(void **state) {
    const listed *options;
    const fixture *f = *state;
    int count = list_options(*state, &options);
    for (int k = 0; k < count; k++)
        if (k == 0 || strcmp(options[k].command, options[k - 1].command) != 0)
            free(check_refused(f, beginning_of(options[k].command), "--unheard-of", "--unheard-of",
                               options[k].command));
    free(check_refused(f, "scenes", "--json", "--json", "scenes"));
    free(check_refused(f, "unheard-of", "", "unheard-of", ""));
}

/* Giving an option twice is an error, for any values: one would be lost. Settings, axes and parts of ranges
 * accumulate, but each key is given once. */
static void no_option_is_given_twice(void **state) {
    static const char *const twice[][3] = {
        {"classify impact-oscillator", "--json --json", "--json: "},
        {"classify impact-oscillator", "--rtol 1e-9 --json --rtol 1e-9", "--rtol: "},
        {"classify impact-oscillator", "--quiet --quiet", "--quiet: "},
        {"lyapunov impact-oscillator", "--members 2 --members 3", "--members: "},
        {"simulate impact-oscillator --periods 2", "-o never.h5 -o never.csv", "-o: "},
        {"check impact-oscillator", "--set F=0.7 c=0.2 F=0.6", "--set F=0.6: F is "},
        {"check impact-oscillator", "--set F=0.7 --set c=0.2 --set F=0.7", "--set F=0.7: F is "},
        {"sweep impact-oscillator -o never.h5", "--over d=1:2:3 --over d=3,4", "--over d=3,4: d is "},
        {"plot ../in/branch.h5 -o never.png", "--range omega=1:2 --range omega=2:3",
         "--range omega=2:3: omega is "},
        {"spectrum impact-oscillator", "--of q1 --of q1", "--of q1: q1 is "},
        /* One value by two names. */
        {"check duffing", "--set q1=0.1 x=0.2", "--set x=0.2: leaves nothing of --set q1=0.1, the same is "},
        {"classify fig7d", "--set d=0.03 d1=0.04", "--set d1=0.04: leaves nothing of --set d=0.03, "},
        {"check two-stops", "--set d2=0.8 --set d=0.9", "--set d=0.9: leaves nothing of --set d2=0.8, "},
        {"check two-stops", "--set r1=0.8 sides=none", "--set sides=none: leaves nothing of --set r1=0.8, "},
        {"sweep fig6 -o never.h5", "--over d=0.03:0.04:2 --over d1=0.02:0.025:2", "d and d1: the same is "},
        {"sweep duffing -o never.h5", "--over x=0:1:2 --over q1=0:0.5:2", "x and q1: the same is "},
        {"sweep fig6 -o never.h5", "--set omega=40 --over omega=40:41:3",
         "--over omega=40:41:3: leaves nothing of --set omega=40, "},
        {"sweep two-stops -o never.h5", "--set d2=0.8 --over d=0.8:0.9:2",
         "--over d=0.8:0.9:2: leaves nothing "},
        {"basins duffing -o never.h5", "--set q1=0.1 --over x=0:1:2 --over v1=0:1:2",
         "--over x=0:1:2: leaves nothing of --set q1=0.1, "},
        {"classify relief-valve", "--set section=maxima --section maxima",
         "--section section=maxima: leaves "}};
    const fixture *f = *state;
    for (size_t k = 0; k < sizeof twice / sizeof twice[0]; k++)
        free(check_refused(f, twice[k][0], twice[k][1], twice[k][2], "given twice"));
    clear(f, "base");
    clear(f, "with");
    /* All stops, then one of them. */
    assert_int_equal(run_in(f, "base", "check two-stops", "--set d1=0.9 d2=0.8"), 0);
    assert_int_equal(run_in(f, "with", "check two-stops", "--set d=0.9 d2=0.8"), 0);
    clear(f, "base");
    clear(f, "with");
    assert_int_equal(run_in(f, "base", "check impact-oscillator", "--set F=0.7 c=0.2"), 0);
    assert_int_equal(run_in(f, "with", "check impact-oscillator", "--set F=0.7 --set c=0.2"), 0);
    assert_true(same_files(f, "out"));
    free(check_refused(f, "classify impact-oscillator", "--rtol 1 --rtol 1e-9", "--rtol", "1:"));
    ((fixture *)*state)->last[0] = ((fixture *)*state)->with[0] = '\0';
}

/* How many bytes a command writes to stderr on a terminal; as many as fit are stored in `said`, which may be
 * NULL. */
static size_t words_on_terminal(const fixture *f, const char *line, const char *more, char *said,
                                size_t room) {
    int master = posix_openpt(O_RDWR | O_NOCTTY);
    char text[1024], block[4096];
    size_t heard = 0;
    assert_true(master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0);
    snprintf(text, sizeof text, "cd %s/with && PATH=%s/tools:$PATH %s %s %s >out", f->folder, f->folder,
             SALTUS_COMMAND, line, more);
    const char *name = ptsname(master);
    int slave = open(name, O_RDWR | O_NOCTTY);
    const struct winsize size = {.ws_row = 24, .ws_col = f->columns};
    assert_true(f->columns == 0 || ioctl(slave, TIOCSWINSZ, &size) == 0);
    pid_t child = fork();
    if (child == 0) {
        dup2(slave, STDERR_FILENO);
        close(slave);
        close(master);
        execl("/bin/sh", "sh", "-c", text, (char *)NULL);
        _exit(99);
    }
    close(slave);
    for (ssize_t got; (got = read(master, block, sizeof block)) > 0;) {
        if (said && heard + (size_t)got < room) {
            memcpy(said + heard, block, (size_t)got);
            said[heard + (size_t)got] = '\0';
        }
        heard += (size_t)got;
    }
    int outcome = 0;
    waitpid(child, &outcome, 0);
    close(master);
    if (outcome != 0)
        fail_msg("%s %s on a terminal: %#x: %.300s", line, more, (unsigned)outcome, block);
    return heard;
}

/* The final content of a terminal's line: a newline begins an empty one, a return goes back to its begin,
 * where it may be cleared to its end. */
static void last_line(const char *said, char *shown, size_t room) {
    size_t at = 0;
    memset(shown, 0, room);
    for (const char *c = said; *c; c++)
        if (*c == '\r')
            at = 0;
        else if (strncmp(c, "\033[K", 3) == 0) {
            memset(shown + at, 0, room - at);
            c += 2;
        } else if (*c == '\n') {
            memset(shown, 0, room);
            at = 0;
        } else {
            assert_true(at + 1 < room);
            shown[at++] = *c;
        }
    for (size_t k = strlen(shown); k > 0 && shown[k - 1] == ' '; k--)
        shown[k - 1] = '\0';
    if (at != 0)
        shown[0] = shown[0] ? shown[0] : '?';
}

/* On a terminal there is a progress line, which is gone in the end; --quiet suppresses it in every command
 * that lists it, and stderr is empty otherwise. */
static void quiet_commands_are_silent(void **state) {
    static const char *const lines[][2] = {
        {"classify", "classify impact-oscillator"},
        {"diagnose", "diagnose impact-oscillator -o x.png"},
        {"continue", "continue impact-oscillator --in omega=0.99:1.01 --points 2 -o x.h5"},
        {"sweep", "sweep impact-oscillator --over omega=0.9:1.1:2 -o x.h5"},
        {"basins", "basins impact-oscillator --over q1=0:1:2 --over v1=0:1:2 -o x.h5"},
        {"lyapunov", "lyapunov impact-oscillator --transient 20 --periods 1800"},
        {"spectrum", "spectrum impact-oscillator --samples 64"},
        {"simulate", "simulate impact-oscillator --periods 2000 --samples 4 -o x.h5"},
        {"paper", "paper --figure 3 -o p"}};
    static char words[65536], shown[512];
    const listed *options;
    const fixture *f = *state;
    int count = list_options(*state, &options), quiet = 0;
    for (int k = 0; k < count; k++)
        quiet += strcmp(options[k].name, "--quiet") == 0;
    assert_int_equal(quiet, 14); /* every command */
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
        clear(f, "with");
        if (words_on_terminal(f, lines[k][1], "", words, sizeof words) == 0)
            fail_msg("%s shows no progress on a terminal", lines[k][0]);
        last_line(words, shown, sizeof shown);
        if (shown[0])
            fail_msg("%s leaves '%s' on the terminal", lines[k][0], shown);
        if (words_on_terminal(f, lines[k][1], "--quiet", NULL, 0) != 0)
            fail_msg("%s --quiet is not silent", lines[k][0]);
        size_t length;
        assert_int_equal(run_in(f, "with", lines[k][1], ""), 0);
        free(text_of(f, "with", "err", &length));
        if (length)
            fail_msg("%s writes to stderr where that is no terminal", lines[k][0]);
    }
}

/* On a narrow terminal no line is longer than it, and the most important part is first: seeds that are done,
 * ... */
static void progress_fits_a_narrow_terminal(void **state) {
    skip_where_slow();
    static const struct {
        const char *line, *begin;
    } cases[] = {
        {"classify impact-oscillator --seeds 3", "2 of 3 seeds done"},
        {"simulate impact-oscillator --periods 2000 --samples 4 -o x.csv", " of 2000 periods"},
        {"continue impact-oscillator --in omega=0.99:1.01 --points 4 -o x.h5", "\romega=1 step 0 1/1"},
        {"lyapunov " CHAOS " --transient 20 --periods 1800", "\r100 % of at most 1800"},
        {"sweep " CHAOS " --over F=0.9:1.1:30000 --transient 40 --record 10 --threads 1 --lanes 1 "
         "--what class -o s.h5",
         " s left"}};
    static char said[65536];
    fixture *f = *state;
    clear(f, "with");
    f->columns = 30;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        assert_true(words_on_terminal(f, cases[k].line, "", said, sizeof said) > 0);
        assert_non_null(strstr(said, cases[k].begin));
        for (const char *at = said; *at;) {
            size_t length = strcspn(at, "\r\n"), shown = 0;
            for (size_t i = 0; i < length; i++)
                shown += (unsigned char)at[i] >= ' ';
            const char *wipe = strstr(at, "\033[K");
            shown -= wipe && wipe < at + length ? 2 : 0;
            if (shown >= 30)
                fail_msg("%s: '%.*s'", cases[k].line, (int)length, at);
            at += length + (at[length] != '\0');
        }
    }
    f->columns = 0;
}

/* Whether a number is that of a text with its digits. */
static bool is_rounded(double value, double exact, int digits) {
    return fabs(value - exact) <= 0.51 * pow(10, 1 - digits) * fmax(fabs(exact), fabs(value));
}

/* The progress shows the points found, in order, and the work done. */
static void progress_lines_tell_what_is_found(void **state) {
    static char said[65536];
    size_t length;
    clear(*state, "with");
    words_on_terminal(
        *state, "continue impact-oscillator --in omega=0.99:1.01 --points 6 --at 1.00005,0.99993 -o x.h5",
        "--json", said, sizeof said);
    char *text = text_of(*state, "with", "out", &length), label[16], mark[16];
    const char *at = text, *line = said;
    int points = 0, marked = 0;
    for (; *at; at += *at == '\n', points++) {
        int branch, step, used = 0;
        double omega, multiplier;
        json *point = json_value(&at);
        const char *kind = json_text_at(point, "label");
        line = strstr(line, "\romega = ");
        assert_non_null(line);
        assert_int_equal(sscanf(++line, "omega = %lf  branch %d  step %d  %15s  largest multiplier %lf%n",
                                &omega, &branch, &step, label, &multiplier, &used),
                         5);
        assert_true(branch == json_number_at(point, "branch") && step == json_number_at(point, "step"));
        assert_true(is_rounded(omega, json_number_at(point, "values.0"), 9));
        assert_string_equal(label, json_text_at(point, "motion"));
        assert_true(is_rounded(multiplier, exp(json_number_at(point, "log_moduli.0")), 4));
        snprintf(mark, sizeof mark, "%s%.2s\033[K", kind[0] ? "  " : "", kind);
        assert_int_equal(strncmp(line + used, mark, strlen(mark)), 0);
        marked += kind[0] != '\0';
        json_free(point);
    }
    assert_true(points > 8 && marked >= 4 && !strstr(line, "\romega = "));
    free(text);
    /* The periods of a search and of a measurement only increase, up to the limit. */
    words_on_terminal(*state, "classify " CHAOS, "--transient 300 --measure 4000", said, sizeof said);
    double last = 0, most = 0;
    int lines = 0;
    for (line = said; (line = strstr(line, " of at most ")); line++, lines++) {
        const char *number = line;
        while (number[-1] != '\r')
            number--;
        /* A share in percent. */
        double done = strtod(number, NULL), allowed = strtod(line + 12, NULL);
        assert_true(done <= 100 && (allowed == most ? done >= last : allowed == (most == 0 ? 300 : 4000)));
        last = done;
        most = allowed;
    }
    assert_true(lines >= 3 && most == 4000);
    words_on_terminal(*state, LYAPUNOV, "", said, sizeof said);
    assert_int_equal(strncmp(said, "\rsettling: 20 periods", 21), 0);
    double value = NAN, error = NAN;
    last = -1;
    for (line = said; (line = strstr(line, " % of at most ")); line++) {
        double done, allowed;
        const char *begin = line;
        while (*begin != '\r')
            begin--;
        int told = sscanf(begin, "\r%lf %% of at most %lf periods, exponent %lf +- %lf", &done, &allowed,
                          &value, &error);
        assert_true(told == (last < 0 ? 2 : 4) && done >= last && done <= 100 && allowed == 1800);
        last = done;
    }
    text = text_of(*state, "with", "out", &length);
    json *result = json_read(text);
    check_near(last, 100 * json_number_at(result, "periods") / 1800, 0.5);
    assert_true(is_rounded(value, json_number_at(result, "largest"), 5));
    assert_true(is_rounded(error, json_number_at(result, "standard_error"), 2));
    json_free(result);
    free(text);
    /* A search's share of its work. */
    words_on_terminal(*state, "orbit " CHAOS " --periods 2 --unstable", "--search 500", said, sizeof said);
    last = 0;
    lines = 0;
    for (line = said; (line = strstr(line, "\rsearching: ")); line++, lines++) {
        double share = strtod(line + 12, NULL);
        assert_true(share >= last && share <= 100);
        last = share;
    }
    assert_true(lines >= 3 && last >= 50);
}

static double seconds_of(struct timeval time) {
    return (double)time.tv_sec + 1e-6 * (double)time.tv_usec;
}

/* The bar of a sweep has the length of the part done, which grows; the time left is that of the rest at the
 * shown speed; at the end the line is cleared. */
static void a_progress_bar_tells_the_part_done(void **state) {
    static char said[65536];
    int seen = 0;
    /* Updates are a quarter of a second apart. */
    for (int points = 3000; points < 1000000 && seen < 2; points *= 3) {
        char line[160];
        double last = 0;
        seen = 0;
        snprintf(line, sizeof line,
                 "sweep " CHAOS " --over F=0.9:1.1:%d --transient 40 --record 10 --threads 1 --lanes 1 "
                 "--what class -o x.h5",
                 points);
        clear(*state, "with");
        struct rusage before, after;
        getrusage(RUSAGE_CHILDREN, &before);
        assert_true(words_on_terminal(*state, line, "", said, sizeof said) > 0);
        getrusage(RUSAGE_CHILDREN, &after);
        /* The reporting thread sleeps meanwhile, without polling the system. */
        double user = seconds_of(after.ru_utime) - seconds_of(before.ru_utime),
               asking = seconds_of(after.ru_stime) - seconds_of(before.ru_stime);
        assert_true(asking <= 0.1 + 0.25 * user);
        for (const char *at = said; (at = strstr(at, "\r[")); at++) {
            double part, speed, left;
            int cells = (int)strspn(at + 2, "#"), dots = (int)strspn(at + 2 + cells, ".");
            assert_int_equal(cells + dots, 30);
            assert_int_equal(sscanf(at + 32, "] %lf %%  %lf points/s  %lf s left", &part, &speed, &left), 3);
            assert_true(part >= last && part <= 100 && speed > 0);
            assert_true(fabs(0.3 * part - cells - 0.5) <= 0.5 + 0.3 * 0.06);
            /* The part is shown to 0.1 %, the speed to four digits, the time in whole seconds. */
            double wanted = points * (1 - part / 100) / speed,
                   slack = points * 5.1e-4 / speed + 1e-3 * wanted;
            assert_true(left >= wanted - slack && left < wanted + 1 + slack);
            last = part;
            seen++;
            /* The part done took the time since the beginning at this speed. */
            assert_true(part / 100 * points / speed >= 0.2 * seen);
        }
        assert_true(strcmp(said + strlen(said) - 4, "\r\033[K") == 0);
    }
    assert_true(seen >= 2);
}

/* Start the paper's second figure, end it when its sweep has begun, and read that sweep's options. */
static void begin_figure(const fixture *f, const char *more, const char *transient, const char *values) {
    char text[1024], path[320];
    clear(f, "with");
    snprintf(path, sizeof path, "%s/with/p/fig2.h5", f->folder);
    snprintf(text, sizeof text,
             "cd %s/with && { PATH=%s/tools:$PATH %s paper --quiet --figure 2 -o p %s >out 2>err & child=$!; "
             "while kill -0 $child 2>/dev/null && [ ! -e p/fig2.h5.journal ]; do :; done; kill -TERM $child; "
             "wait $child; }",
             f->folder, f->folder, SALTUS_COMMAND, more);
    assert_int_equal(WEXITSTATUS(system(text)), 1);
    assert_true(attribute_tells(path, "/sweep", "transient", transient));
    assert_true(rows_tell(path, "axes/axis1", values));
}

/* --quick runs fewer values for shorter times; --resume continues, without it all begins again. */
static void paper_is_quick_and_resumes(void **state) {
    fixture *f = *state;
    char path[320];
    struct stat before, after;
    begin_figure(f, "", "500", "1000");
    begin_figure(f, "--quick", "200", "125");
    snprintf(path, sizeof path, "%s/with/p/fig2.h5", f->folder);
    assert_int_equal(run_in(f, "with", "paper --quiet --figure 2 -o p --quick", "--resume"), 0);
    assert_true(attribute_tells(path, "/", "complete", "1"));
    assert_int_equal(stat(path, &before), 0);
    assert_int_equal(run_in(f, "with", "paper --quiet --figure 2 -o p --quick", "--resume"), 0);
    assert_int_equal(stat(path, &after), 0);
    size_t length;
    char *told = text_of(f, "with", "out", &length);
    assert_non_null(strstr(told, "all were there"));
    free(told);
    assert_int_equal(before.st_size, after.st_size);
}

/* The state after some time from a scene with one more setting; the test fails if the scene refuses it. */
static void settle(const saltus_scene *scene, const char *setting, double *state) {
    saltus_message message = {.text = ""};
    saltus_scene changed = *scene;
    saltus_trajectory record;
    saltus_flow_options options = saltus_flow_defaults();
    double start[SALTUS_SCENE_STATE_MAX] = {0};
    if (setting)
        check_ok(saltus_scene_set(&changed, setting, &message), &message);
    saltus_system *system = build(&changed.spec);
    int n = saltus_system_dimension(system);
    start[n / 2] = -1;
    for (int i = 0; i < changed.initial_count; i++)
        start[i] = isnan(changed.initial[i]) ? start[i] : changed.initial[i];
    check_ok(saltus_trajectory_record(system, start, &options, 0, 3, 16, &record, &message), &message);
    memset(state, 0, SALTUS_SCENE_STATE_MAX * sizeof *state);
    memcpy(state, record.states + (record.samples - 1) * n, (size_t)n * sizeof *state);
    saltus_trajectory_clear(&record);
    saltus_system_free(system);
}

/* Every parameter, every key of a stop and every entry of the initial state affects the trajectory. */
static void each_key_of_a_scene_changes_the_motion(void **state) {
    static const char *const pipe[] = {"N=3",        "alpha=0.006", "beta=0.6",   "kappa=5100", "u0=4.4",
                                       "sigma=0.3",  "omega=43",    "xi=0.45",    "d=0.0195",   "r=0.85",
                                       "sides=both", "sides=lower", "sides=none", "d1=0.0195",  "r1=0.85",
                                       "xi1=0.45",   "q1=0.001",    "v2=0.01"};
    static const char *const masses[] = {
        "m=1.1",      "c=0.12",        "k=1.1",   "F=0.6",   "F0=0.1",    "m2=1.2",  "c2=0.12",
        "k2=1.1",     "F2=0.1",        "F02=0.1", "kz=0.2",  "omega=1.5", "d=0.25",  "r=0.7",
        "sides=both", "weight=1,-0.9", "d1=0.25", "q1=0.01", "v1=0.01",   "q2=0.01", "v2=0.01"};
    static const struct {
        const char *name;
        const char *const *keys;
        size_t count;
    } scenes[] = {{"pipe", pipe, sizeof pipe / sizeof pipe[0]},
                  {"two-mass", masses, sizeof masses / sizeof masses[0]}};
    (void)state;
    for (int s = 0; s < 2; s++) {
        saltus_message message = {.text = ""};
        saltus_scene scene;
        double plain[SALTUS_SCENE_STATE_MAX], moved[SALTUS_SCENE_STATE_MAX];
        int parameters;
        check_ok(saltus_scene_load(scenes[s].name, &scene, &message), &message);
        scene.initial_count = 0;
        if (s == 0) {
            check_ok(saltus_scene_set(&scene, "N=2", &message), &message);
            check_ok(saltus_scene_set(&scene, "d=0.02", &message), &message);
        }
        settle(&scene, NULL, plain);
        for (size_t k = 0; k < scenes[s].count; k++) {
            settle(&scene, scenes[s].keys[k], moved);
            if (memcmp(plain, moved, sizeof plain) == 0)
                fail_msg("%s: %s changes nothing", scenes[s].name, scenes[s].keys[k]);
        }
        const saltus_parameter *p = saltus_model_parameters(scene.spec.model, &parameters);
        for (int k = 0; k < parameters; k++) {
            /* With one mass there is no stop between two; tz counts with kz only, see below. */
            bool tried = strcmp(p[k].name, "tz") == 0 || (s == 1 && strcmp(p[k].name, "N") == 0);
            for (size_t i = 0; i < scenes[s].count && !tried; i++)
                tried = strncmp(scenes[s].keys[i], p[k].name, strlen(p[k].name)) == 0 &&
                        scenes[s].keys[i][strlen(p[k].name)] == '=';
            if (!tried)
                fail_msg("%s: %s is not tried", scenes[s].name, p[k].name);
        }
        if (s == 1) {
            check_ok(saltus_scene_set(&scene, "kz=0.2", &message), &message);
            settle(&scene, NULL, plain);
            settle(&scene, "tz=2", moved);
            assert_memory_not_equal(plain, moved, sizeof plain);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_listed_option_has_a_case),
        cmocka_unit_test(each_option_takes_effect),
        cmocka_unit_test(told_defaults_change_nothing),
        cmocka_unit_test(bad_values_are_refused_by_name),
        cmocka_unit_test(lists_are_taken_up_to_their_room),
        cmocka_unit_test(unknown_options_are_refused_by_every_command),
        cmocka_unit_test(no_option_is_given_twice),
        cmocka_unit_test(quiet_commands_are_silent),
        cmocka_unit_test(progress_fits_a_narrow_terminal),
        cmocka_unit_test(progress_lines_tell_what_is_found),
        cmocka_unit_test(a_progress_bar_tells_the_part_done),
        cmocka_unit_test(paper_is_quick_and_resumes),
        cmocka_unit_test(each_key_of_a_scene_changes_the_motion),
    };

    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
