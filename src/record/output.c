/* Files that are written completely or not at all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _GNU_SOURCE /* O_TMPFILE */
#include "record/output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

bool saltus_path_ends(const char *path, const char *ending) {
    size_t length = strlen(saltus_path_name(path)), tail = strlen(ending);
    return length > tail && strcmp(saltus_path_name(path) + length - tail, ending) == 0;
}

const char *saltus_path_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

FILE *saltus_nameless_file(void) {
    const char *folder = getenv("TMPDIR");
    char name[4096];
    int length = snprintf(name, sizeof name, "%s/saltus-XXXXXX", folder && *folder ? folder : "/tmp");
    if (length < 0 || (size_t)length >= sizeof name) {
        errno = ENAMETOOLONG;
        return NULL;
    }
    int descriptor = mkstemp(name);
    if (descriptor < 0)
        return NULL;
    unlink(name);
    FILE *file = fdopen(descriptor, "w+b");
    if (!file)
        close(descriptor);
    return file;
}

/* Room for the names of a file that is not complete. */
static size_t room_of(const saltus_output *output) {
    return strlen(output->path) + 32;
}

/* Take an unused name beside the target: with a new file, or for the one without a name. Returns a descriptor
 * or zero; negative on failure. */
static int take_name(saltus_output *output, char *name) {
    int result = -1;
    for (int k = 0; k < 1000; k++) {
        snprintf(name, room_of(output), "%s.part%ld-%d", output->path, (long)getpid(), k);
        result = output->nameless ? linkat(AT_FDCWD, output->temporary, AT_FDCWD, name, AT_SYMLINK_FOLLOW)
                                  : open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (result >= 0 || errno != EEXIST)
            break;
    }
    return result;
}

static void release(saltus_output *output) {
    free(output->path);
    free(output->temporary);
    *output = (saltus_output){0};
}

static saltus_status refuse(const char *path, int reason, saltus_message *message) {
    if (reason == ENOMEM)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for writing %s", path);
    return saltus_fail(message, SALTUS_IO, "%s cannot be written: %s", path, strerror(reason));
}

saltus_status saltus_output_open(saltus_output *output, const char *path, saltus_message *message) {
    struct stat facts;
    bool exists = stat(path, &facts) == 0;
    *output = (saltus_output){0};
    if (exists && S_ISDIR(facts.st_mode))
        return saltus_fail(message, SALTUS_IO, "%s is a folder, not a file that can be written", path);
    /* Follow links, so that the file they point to is replaced and the link stays. */
    output->path = exists ? realpath(path, NULL) : strdup(path);
    if (!output->path)
        return refuse(path, exists ? errno : ENOMEM, message);
    int descriptor = -1;
    if (exists && !S_ISREG(facts.st_mode))
        descriptor = open(output->path, O_WRONLY | O_CLOEXEC);
    else if (exists && access(output->path, W_OK) != 0)
        errno = EACCES;
    else if (!(output->temporary = malloc(room_of(output))))
        errno = ENOMEM;
    else {
        /* Beside the target; permissions follow the umask. It has no name yet, but where there are no such
         * files, or where the running program cannot name its open files (without /proc). */
#ifdef O_TMPFILE
        const char *name = saltus_path_name(output->path);
        snprintf(output->temporary, room_of(output), "%.*s.", (int)(name - output->path), output->path);
        descriptor = open(output->temporary, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
        snprintf(output->temporary, room_of(output), "/proc/self/fd/%d", descriptor);
        if (descriptor >= 0 && access(output->temporary, F_OK) != 0) {
            close(descriptor);
            descriptor = -1;
        }
#endif
        output->nameless = descriptor >= 0;
        if (!output->nameless)
            descriptor = take_name(output, output->temporary);
    }
    output->file = descriptor >= 0 ? fdopen(descriptor, "wb") : NULL;
    if (output->file)
        return SALTUS_OK;
    int reason = errno;
    if (descriptor >= 0) {
        close(descriptor);
        if (output->temporary && !output->nameless)
            unlink(output->temporary);
    }
    release(output);
    return refuse(path, reason, message);
}

saltus_status saltus_output_close(saltus_output *output, saltus_status status, saltus_message *message) {
    bool sound = !ferror(output->file);
    int earlier = sound ? 0 : errno;
    errno = 0;
    sound = fflush(output->file) == 0 && sound;
    if (output->nameless && status == SALTUS_OK && sound) {
        /* A new file is named at once. To take the place of another it needs a name of its own first: the
         * only moment in which a kill leaves that behind. */
        if (linkat(AT_FDCWD, output->temporary, AT_FDCWD, output->path, AT_SYMLINK_FOLLOW) != 0) {
            char *name = malloc(room_of(output));
            sound = name && take_name(output, name) == 0;
            if (sound && rename(name, output->path) != 0) {
                const int reason = errno;
                unlink(name);
                errno = reason;
                sound = false;
            }
            free(name);
        }
        free(output->temporary);
        output->temporary = NULL;
    }
    sound = fclose(output->file) == 0 && sound;
    if (status == SALTUS_OK && sound && output->temporary)
        sound = rename(output->temporary, output->path) == 0;
    int reason = earlier ? earlier : errno ? errno : EIO;
    if ((status != SALTUS_OK || !sound) && output->temporary && !output->nameless)
        unlink(output->temporary);
    if (status == SALTUS_OK && !sound)
        status = reason == ENOMEM ? refuse(output->path, reason, message)
                                  : saltus_fail(message, SALTUS_IO, "%s could not be written completely: %s",
                                                output->path, strerror(reason));
    release(output);
    return status;
}

saltus_status saltus_output_test(const char *path, bool plain, saltus_message *message) {
    struct stat facts;
    saltus_output output;
    if (plain && stat(path, &facts) == 0 && !S_ISREG(facts.st_mode) && !S_ISDIR(facts.st_mode))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: is not a plain file", path);
    saltus_status status = saltus_output_open(&output, path, message);
    if (status == SALTUS_OK)
        saltus_output_close(&output, SALTUS_IO, NULL);
    return status;
}

size_t saltus_read_at(int descriptor, void *data, size_t size, long long place) {
    unsigned char *bytes = data;
    size_t done = 0;
    while (done < size) {
        ssize_t got = pread(descriptor, bytes + done, size - done, (off_t)(place + (long long)done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got == 0)
            errno = EIO;
        if (got <= 0)
            break;
        done += (size_t)got;
    }
    return done;
}

bool saltus_write_at(int descriptor, const void *data, size_t size, long long place) {
    const unsigned char *bytes = data;
    size_t done = 0;
    while (done < size) {
        ssize_t put = pwrite(descriptor, bytes + done, size - done, (off_t)(place + (long long)done));
        if (put < 0 && errno == EINTR)
            continue;
        if (put == 0)
            errno = ENOSPC;
        if (put <= 0)
            return false;
        done += (size_t)put;
    }
    return true;
}
