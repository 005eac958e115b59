/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "target.h"

#include "interrupt.h"
#include "record/output.h"

#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* An output file, with the option that names it. */
typedef struct place {
    const char *option, *path;
    const char *const *endings;
} place;

/* What cannot be written, or may not be, is bad input: nothing has been computed yet. */
__attribute__((format(printf, 2, 3))) static int refuse(const place *p, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "saltus: %s %s: ", p->option, p->path);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    return CLI_BAD_INPUT;
}

/* Write a list of endings: ".png, .pdf or .svg". */
static void list_endings(const char *const *endings, char text[64]) {
    size_t used = 0;
    for (int k = 0; endings[k]; k++)
        used += (size_t)snprintf(text + used, 64 - used, "%s%s",
                                 k == 0           ? ""
                                 : endings[k + 1] ? ", "
                                                  : " or ",
                                 endings[k]);
}

/* Whether an input, possibly followed by ":" and a part, is this file. */
static bool is_file(const char *input, const struct stat *file) {
    struct stat facts;
    char path[4096];
    const char *colon = strrchr(input, ':');
    bool there = strcmp(input, "-") == 0 ? fstat(STDIN_FILENO, &facts) == 0 : stat(input, &facts) == 0;
    if (!there && colon && (size_t)(colon - input) < sizeof path) {
        snprintf(path, sizeof path, "%.*s", (int)(colon - input), input);
        there = stat(path, &facts) == 0;
    }
    return there && facts.st_dev == file->st_dev && facts.st_ino == file->st_ino;
}

/* An existing file may be replaced only if it is finished and of the kind to be written. */
static int check_earlier(const cli_command *command, const cli_request *request, const place *p, bool there) {
    saltus_file_facts facts = {.kind = "empty", .complete = true};
    char kind[32], journal[4096];
    if (cli_given(request, "--resume") || cli_given(request, "--force"))
        return CLI_DONE;
    if (there)
        facts = saltus_file_identify(p->path);
    const char *known = facts.locus ? "locus" : facts.kind;
    /* The kind of file that the command writes here, as saltus_file_identify calls it, and a locus by that
     * word. "": it will write nothing and explain why. */
    const bool table = saltus_path_ends(p->path, ".csv");
    kind[0] = '\0';
    if (!table && !saltus_path_ends(p->path, ".h5"))
        strcpy(kind, saltus_path_ends(p->path, ".gp") ? "script" : "picture");
    else if (command->kind)
        snprintf(kind, sizeof kind, "%s%s", cli_given(request, "--locus") ? "locus" : command->kind,
                 table ? " table" : "");
    else if (request->input_count) {
        const saltus_file_facts input = saltus_file_identify(request->inputs[0]);
        saltus_table_kind(&input, cli_text(request, "--table"), kind);
    }
    if (strcmp(known, "hdf5") == 0)
        return refuse(p, "is there, an HDF5 file that is damaged or cut off; another name, or --force to "
                         "replace it");
    if (strcmp(known, "empty") != 0 && kind[0] && strcmp(known, kind) != 0)
        return refuse(
            p, "is there and another kind of file (%s, not %s); another name, or --force to replace it",
            known[0] ? known : "not one of Saltus", kind);
    /* A table of a sweep's unfinished file can be exported again; that of an interrupted simulation may be
     * all there is. */
    const bool again = !command->kind && strncmp(facts.kind, "trajectory", strlen("trajectory")) != 0;
    const int length = snprintf(journal, sizeof journal, "%s.journal", p->path);
    if ((!facts.complete && !again) || ((size_t)length < sizeof journal && access(journal, F_OK) == 0))
        return refuse(p, "holds an interrupted run; %s--force begins anew",
                      command->resumes ? "--resume goes on with it, " : "");
    return CLI_DONE;
}

static int check_place(const cli_command *command, const cli_request *request, const place *p) {
    struct stat facts;
    char endings[64], folder[4096] = ".";
    bool there = stat(p->path, &facts) == 0, ends = !p->endings;
    if (there && S_ISDIR(facts.st_mode))
        return refuse(p, "is a folder, not a file that can be written");
    for (int k = 0; p->endings && p->endings[k]; k++)
        ends = ends || saltus_path_ends(p->path, p->endings[k]);
    if (!ends) {
        list_endings(p->endings, endings);
        return refuse(p, "the ending must be %s", endings);
    }
    const cli_list *over = cli_values(request, "--over");
    const char *from = cli_text(request, "--from"), *input = NULL;
    for (int k = 0; k < request->input_count + over->count && there && !input; k++) {
        const char *one =
            k < request->input_count ? request->inputs[k] : over->items[k - request->input_count];
        input = is_file(one, &facts) ? one : NULL;
    }
    if (there && !input && from && is_file(from, &facts))
        input = from;
    if (input)
        return refuse(p, "is the same file as the input %s, which would be lost", input);
    /* Devices and pipes are written to directly. */
    if (there && !S_ISREG(facts.st_mode))
        return CLI_DONE;
    if (there && access(p->path, W_OK) != 0)
        return refuse(p, "cannot be written: %s", strerror(errno));
    /* The folder that it is, or will be, in. */
    const char *slash = strrchr(p->path, '/');
    if (slash && (size_t)(slash - p->path) + 1 >= sizeof folder)
        return refuse(p, "the name is too long");
    if (slash)
        snprintf(folder, sizeof folder, "%.*s", (int)(slash > p->path ? slash - p->path : 1), p->path);
    const char *called = slash ? "the folder " : "the current folder", *name = slash ? folder : "";
    if (stat(folder, &facts) != 0)
        return refuse(p, "%s%s cannot be used: %s", called, name, strerror(errno));
    if (!S_ISDIR(facts.st_mode))
        return refuse(p, "%s is no folder", folder);
    if (access(folder, W_OK | X_OK) != 0)
        return refuse(p, "in %s%s nothing can be written: %s", called, name, strerror(errno));
    return check_earlier(command, request, p, there);
}

static void go_on(int number) {
    (void)number;
}

/* Redirect output to a temporary file for standard output, with the ending of --format or the first suitable
 * one. */
static int divert(const cli_command *command, cli_request *request, target *out) {
    const char *format = cli_text(request, "--format"), *base = getenv("TMPDIR"), *ending = NULL;
    const place p = {"-o", "-", NULL};
    for (int k = 0; command->endings[k] && !ending; k++)
        if (format ? strcmp(command->endings[k] + 1, format) == 0 : strcmp(command->endings[k], ".h5") != 0)
            ending = command->endings[k];
    if (!ending && format) {
        char endings[64];
        list_endings(command->endings, endings);
        return cli_refuse(CLI_BAD_INPUT, "--format %s: the formats of saltus %s are %s", format,
                          command->name, endings);
    }
    if (!ending || strcmp(ending, ".h5") == 0)
        return refuse(&p,
                      "HDF5 cannot be written to standard output, only to a file that can be gone back in; "
                      "name one");
    if (cli_given(request, "--json"))
        return refuse(&p, "--json writes to standard output, too; one of them");
    if (cli_given(request, "--resume"))
        return refuse(&p, "--resume needs the file of the interrupted run");
    if (!base || !*base || strlen(base) > sizeof out->folder - 16)
        base = "/tmp";
    snprintf(out->folder, sizeof out->folder, "%s/saltus-XXXXXX", base);
    fflush(stdout);
    if (!mkdtemp(out->folder)) {
        out->folder[0] = '\0';
        return cli_refuse(CLI_FAILED, "-o -: no temporary folder can be made in %s: %s", base,
                          strerror(errno));
    }
    snprintf(out->path, sizeof out->path, "%s/result%s", out->folder, ending);
    snprintf(out->journal, sizeof out->journal, "%s.journal", out->path);
    interrupt_clears((const char *const[INTERRUPT_CLEARED]){out->path, out->journal, out->folder});
    out->descriptor = dup(STDOUT_FILENO);
    dup2(STDERR_FILENO, STDOUT_FILENO);
    /* Where nobody reads any more, the folder must still go before the program does. A caught signal, unlike
     * an ignored one, is as usual again in the programs started from here. */
    out->broken_pipe = signal(SIGPIPE, go_on);
    if (out->broken_pipe == SIG_IGN)
        signal(SIGPIPE, SIG_IGN);
    request->output = out->path;
    request->to_stdout = true;
    return CLI_DONE;
}

int target_open(const cli_command *command, cli_request *request, target *out) {
    *out = (target){.descriptor = -1};
    if (cli_given(request, "--resume") && cli_given(request, "--force"))
        return cli_refuse(CLI_BAD_INPUT, "--resume and --force: one of them");
    if (!command->endings)
        return CLI_DONE;
    bool to_stdout = request->output && strcmp(request->output, "-") == 0;
    if (cli_given(request, "--format") && !to_stdout)
        return cli_refuse(CLI_BAD_INPUT, "--format %s: is of -o - only; the ending of a file says its format",
                          cli_text(request, "--format"));
    if (!request->output)
        return CLI_DONE;
    static const char *const script_endings[] = {".gp", NULL}, *const data_endings[] = {".h5", NULL};
    const place result = {"-o", request->output, command->endings},
                script = {"--keep-script", cli_text(request, "--keep-script"), script_endings};
    int code = to_stdout ? divert(command, request, out) : check_place(command, request, &result);
    if (code == CLI_DONE && script.path)
        code = check_place(command, request, &script);
    const char *path = cli_text(request, "--data");
    if (code != CLI_DONE || !path)
        return code;
    /* The record of --data, and gnuplot's script beside it. */
    char beside[4096];
    struct stat one, other;
    const place data = {"--data", path, data_endings}, data_script = {"--data", beside, NULL};
    if ((code = check_place(command, request, &data)) != CLI_DONE)
        return code;
    if ((size_t)snprintf(beside, sizeof beside, "%.*s.gp", (int)(strlen(path) - strlen(".h5")), path) >=
        sizeof beside)
        return refuse(&data, "the name is too long");
    if (stat(path, &one) == 0 && stat(request->output, &other) == 0 && one.st_dev == other.st_dev &&
        one.st_ino == other.st_ino)
        return refuse(&data, "is the same file as -o %s", request->output);
    return script.path ? CLI_DONE : check_place(command, request, &data_script);
}

int target_close(target *out, int code) {
    char block[65536];
    size_t length;
    int reason = 0, writing = 0; /* the errno of a failure, and of one in writing */
    if (!out->folder[0])
        return code;
    fflush(stdout);
    dup2(out->descriptor, STDOUT_FILENO);
    close(out->descriptor);
    FILE *file = fopen(out->path, "rb");
    if (!file && errno != ENOENT)
        reason = errno;
    while (file && !reason && (length = fread(block, 1, sizeof block, file)) > 0)
        for (size_t done = 0; done < length && !reason;) {
            const ssize_t put = write(STDOUT_FILENO, block + done, length - done);
            if (put >= 0)
                done += (size_t)put;
            else if (errno != EINTR)
                reason = writing = errno;
        }
    if (file && !reason && ferror(file))
        reason = errno;
    if (file)
        fclose(file);
    unlink(out->path);
    unlink(out->journal);
    rmdir(out->folder);
    interrupt_clears(NULL);
    signal(SIGPIPE, out->broken_pipe);
    if (writing == EPIPE && out->broken_pipe == SIG_DFL)
        raise(SIGPIPE);
    if (reason)
        code = cli_refuse(code ? code : CLI_FAILED,
                          writing ? "standard output could not be written: %s"
                                  : "the result for standard output could not be read back: %s",
                          strerror(reason));
    return code;
}
