/* saltus export: tables of files as CSV.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include <string.h>

/* Those of a sweep in the order of saltus_table, then those of branches and trajectories. */
static const char *const words[] = {"rows",    "turning", "impacts", "stroboscopic", "points", "events",
                                    "samples", "strobe",  NULL};
static const cli_option table =
    CLI_CHOICE("--table", "which",
               "of a sweep rows (default), turning, impacts or stroboscopic; of a "
               "branch points (default) or events; of a trajectory samples (default), events or strobe",
               words);

static int run(const cli_request *request) {
    static const char *const tables[] = {"rows", "turning", "impacts", "stroboscopic", NULL};
    const char *input = request->inputs[0];
    saltus_sweep_file file = {.row_count = 0};
    saltus_message message = {.text = ""};
    saltus_status status;
    int wanted = SALTUS_TABLE_ROWS;
    if (!input || !request->output)
        return cli_refuse(CLI_BAD_INPUT, "export: needs a file and -o table.csv");
    if (!cli_choose(request, "--table", words, &wanted))
        return CLI_BAD_INPUT;
    const saltus_file_facts facts = saltus_file_identify(input);
    if (strcmp(facts.kind, "branch") == 0 || strcmp(facts.kind, "trajectory") == 0)
        status = saltus_write_csv(request->output, input, cli_text(request, "--table"), &message);
    else {
        if (!cli_choose(request, "--table", tables, &wanted))
            return CLI_BAD_INPUT;
        status = saltus_sweep_file_read(input, &file, &message);
        if (status == SALTUS_OK) {
            saltus_message reason = {.text = ""};
            status = saltus_write_sweep_csv(request->output, &file, (saltus_table)wanted, &reason);
            if (status == SALTUS_BAD_INPUT)
                saltus_fail(&message, status, "%.300s: %.200s", input, reason.text);
            else
                message = reason;
        }
        saltus_sweep_file_clear(&file);
    }
    return cli_report(cli_tell_written(request, "table", status), &message);
}

const cli_command cmd_export = {
    .name = "export",
    .summary = "tables of files as CSV",
    .usage = "FILE.h5 [--table name] -o table.csv",
    .help = "Write a table of a file of saltus sweep, basins, continue or simulate as CSV; of a sweep: one "
            "line for each trajectory, or for each point of a cloud, with the values of the axes, the pass "
            "and the seed before it. Comments at its head say what it is, and of branches and trajectories "
            "what each column is.",
    .endings = (const char *const[]){".csv", NULL},
    .options = CLI_OPTIONS(&table, &cli_output),
    .examples =
        CLI_EXAMPLES({"sweep impact-oscillator --over omega=0.9:1.1:21 -o sweep.h5", "something to read"},
                     {"export sweep.h5 -o rows.csv", "one line for each trajectory"},
                     {"export sweep.h5 --table impacts -o impacts.csv", "one line for each impact"}),
    .see = "sweep continue simulate plot",
    .run = run,
};
