/* saltus export: the tables of a sweep file as CSV.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include <string.h>

static const cli_option table = {"--table",
                                 CLI_TEXT,
                                 offsetof(cli_request, table),
                                 0,
                                 0,
                                 0,
                                 "which",
                                 "rows, turning, impacts or stroboscopic (default rows)"};

static const cli_option *const options[] = {&table, &cli_output, NULL};

static bool read_table(const char *text, saltus_table *wanted) {
    static const char *const words[] = {[SALTUS_TABLE_ROWS] = "rows",
                                        [SALTUS_TABLE_TURNING] = "turning",
                                        [SALTUS_TABLE_IMPACTS] = "impacts",
                                        [SALTUS_TABLE_STROBES] = "stroboscopic"};
    for (int k = 0; k < (int)(sizeof words / sizeof words[0]); k++)
        if (!text || strcmp(text, words[k]) == 0) {
            *wanted = (saltus_table)k;
            return true;
        }
    fprintf(stderr, "saltus: --table %s: must be rows, turning, impacts or stroboscopic\n", text);
    return false;
}

static int run(const cli_request *request) {
    saltus_message message = {""};
    saltus_table wanted;
    if (!request->input_count || !request->output) {
        fprintf(stderr, "saltus: export: needs a file and -o table.csv\n");
        return CLI_BAD_INPUT;
    }
    if (!read_table(request->table, &wanted))
        return CLI_BAD_INPUT;
    saltus_sweep_file file;
    saltus_status status = saltus_sweep_file_read(request->inputs[0], &file, &message);
    if (status != SALTUS_OK)
        return cli_report(status, &message);
    status = saltus_sweep_file_csv(&file, wanted, request->output, &message);
    saltus_sweep_file_clear(&file);
    if (status == SALTUS_OK)
        printf("%s\n", request->output);
    return cli_report(status, &message);
}

const cli_command cmd_export = {
    .name = "export",
    .usage = "FILE.h5 [--table rows|turning|impacts|stroboscopic] -o table.csv",
    .help = "Write a table of a file of saltus sweep or saltus basins as CSV: one line for each trajectory, "
            "or for each\n"
            "point of a cloud, with the values of the axes, the pass and the seed before it.",
    .options = options,
    .run = run,
};
