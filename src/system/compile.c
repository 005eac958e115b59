/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/compile.h"

#include "base/memory.h"
#include "system/kept.h"

#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum {
    seconds_max = 60,       /* CPU time of the compiler */
    bytes_max = 1 << 30,    /* memory of the compiler */
    niceness = 10,          /* of the compiler, which must not slow down the run */
    descriptors_max = 4096, /* most file descriptors that a process is expected to have open */
    words_max = 24,         /* words of the compiler's command line */
    path_max = 1024,
    name_max = 64
};

typedef enum progress {
    progress_none,  /* the cache has not been searched yet */
    progress_wait,  /* not in the cache: waits until the run proves to be long */
    progress_runs,  /* the compiler is at work */
    progress_ready, /* the function can be called */
    progress_over   /* there will be no function */
} progress;

struct saltus_compiled {
    saltus_compile_shape shape;
    atomic_int owners;
    _Atomic(saltus_compiled_function *) function;
    atomic_int progress;
    pthread_mutex_t lock; /* protects the members below */
    struct timespec since;
    int outcome; /* pipe end that tells the compiler's outcome; -1: none */
    void *library;
    char path[path_max];
};

struct saltus_compiled_list {
    pthread_mutex_t lock;
    saltus_list items; /* saltus_compiled * */
};

/* A compiler and the folder where its output is kept. */
typedef struct toolchain {
    char compiler[path_max], folder[path_max];
    struct stat identity; /* of the compiler */
} toolchain;

/* Find the compiler by its path, or by its name in PATH. False: there is none. */
static bool find_compiler(const char *name, toolchain *w) {
    const char *path = strchr(name, '/') ? "" : getenv("PATH");
    if (strchr(name, '/'))
        snprintf(w->compiler, sizeof w->compiler, "%s", name);
    for (const char *part = path, *end; part && *part; part = *end ? end + 1 : end) {
        end = part + strcspn(part, ":");
        if (*part == '/' && end - part < path_max / 2 &&
            snprintf(w->compiler, sizeof w->compiler, "%.*s/%s", (int)(end - part), part, name) < path_max &&
            access(w->compiler, X_OK) == 0)
            break;
        w->compiler[0] = '\0';
    }
    return w->compiler[0] && access(w->compiler, X_OK) == 0 && stat(w->compiler, &w->identity) == 0 &&
           S_ISREG(w->identity.st_mode);
}

/* Whether a file belongs to the user and is not writable by others. */
static bool is_private(const struct stat *s) {
    return s->st_uid == geteuid() && (s->st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/* Find or create the cache folder. False: there is none, or it is not private. */
static bool find_folder(toolchain *w) {
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    struct stat s;
    bool own = cache && *cache == '/';
    if (!own && (!home || *home != '/'))
        return false;
    if (snprintf(w->folder, sizeof w->folder, "%s%s", own ? cache : home, own ? "" : "/.cache") >=
        path_max - 2 * name_max)
        return false;
    mkdir(w->folder, S_IRWXU);
    strcat(w->folder, "/saltus");
    mkdir(w->folder, S_IRWXU);
    return lstat(w->folder, &s) == 0 && S_ISDIR(s.st_mode) && is_private(&s) &&
           access(w->folder, W_OK | X_OK) == 0;
}

/* Find compiler and folder. Returns the obstacle, or NULL if there is none. */
static const char *open_toolchain(toolchain *w) {
    const char *name = getenv("SALTUS_COMPILE");
    *w = (toolchain){.compiler = ""};
    if (name && strcmp(name, "0") == 0)
        return "SALTUS_COMPILE is 0";
    if (getuid() != geteuid() || getgid() != getegid())
        return "the program runs with another user's rights";
    if (!find_compiler(name && *name ? name : "cc", w))
        return name && *name ? "SALTUS_COMPILE names no program" : "there is no cc on the path";
    if (!find_folder(w))
        return "there is no folder to keep it in that is the user's alone (XDG_CACHE_HOME or ~/.cache)";
    return NULL;
}

/* Options for all sources. The arithmetic is that of the library's own build. */
static const char *const options[] = {"-O3", "-std=c11", "-fPIC", "-shared", "-ffp-contract=off",
                                      "-w",  "-pipe"};
enum { option_count = sizeof options / sizeof options[0] };

/* FNV-1a. */
static unsigned long long hash(unsigned long long h, const void *bytes, size_t size) {
    for (const unsigned char *b = bytes; size > 0; size--)
        h = (h ^ *b++) * 0x100000001b3ULL;
    return h;
}

/* Beginning of the paths of one system's functions: a key from the source without a shape, the compiler and
 * its options. False: no memory, or the source cannot be compiled. */
static bool find_place(const toolchain *w, const char *flags, saltus_compile_source *make, const void *from,
                       char path[path_max]) {
    const long long identity[] = {(long long)w->identity.st_size, (long long)w->identity.st_mtim.tv_sec,
                                  (long long)w->identity.st_mtim.tv_nsec, (long long)w->identity.st_ino};
    const saltus_compile_shape any = {.flags = flags};
    char *source = make(from, &any);
    unsigned long long key[2];
    for (int k = 0; k < 2 && source; k++) {
        key[k] = 0xcbf29ce484222325ULL ^ (0x9e3779b97f4a7c15ULL * (unsigned)k);
        key[k] = hash(key[k], source, strlen(source));
        key[k] = hash(key[k], flags, strlen(flags) + 1);
        key[k] = hash(key[k], w->compiler, strlen(w->compiler) + 1);
        key[k] = hash(key[k], identity, sizeof identity);
        for (int j = 0; j < option_count; j++)
            key[k] = hash(key[k], options[j], strlen(options[j]) + 1);
    }
    if (source)
        snprintf(path, path_max, "%.*s/%016llx%016llx", path_max - name_max, w->folder, key[0], key[1]);
    free(source);
    return source != NULL;
}

/* Load the function from its file if that exists and is private. */
static bool load(saltus_compiled *c) {
    struct stat s;
    if (lstat(c->path, &s) != 0 || !S_ISREG(s.st_mode) || !is_private(&s))
        return false;
    c->library = dlopen(c->path, RTLD_NOW | RTLD_LOCAL);
    void *symbol = c->library ? dlsym(c->library, SALTUS_COMPILED_NAME) : NULL;
    saltus_compiled_function *function = NULL;
    /* POSIX allows this conversion from a data to a function pointer, ISO C does not. */
    memcpy(&function, &symbol, sizeof function);
    if (!function && c->library) {
        dlclose(c->library);
        c->library = NULL;
    }
    if (function)
        saltus_kept_use(c->path);
    atomic_store_explicit(&c->function, function, memory_order_release);
    return function != NULL;
}

/* An open, unnamed file that holds the source, positioned at its beginning; -1: there is none. */
static int keep_source(const toolchain *w, const char *source) {
    char name[path_max + name_max];
    snprintf(name, sizeof name, "%s/source.XXXXXX", w->folder);
    int file = mkstemp(name);
    if (file < 0)
        return -1;
    unlink(name);
    for (size_t left = strlen(source); left > 0;) {
        ssize_t count = write(file, source, left);
        if (count < 0 && errno == EINTR)
            continue;
        if (count <= 0) {
            close(file);
            return -1;
        }
        source += count;
        left -= (size_t)count;
    }
    lseek(file, 0, SEEK_SET);
    return file;
}

/* A compiler's place among those at work: a locked file. The process that runs the compiler inherits the lock
 * and keeps it for as long as it lives. */
typedef struct turn {
    int file; /* -1: there is none */
    char path[path_max + name_max];
} turn;

/* Take a place if one is free: there is one for each processor, for all processes of the user together. Where
 * files cannot be locked, no place is needed. False: the compiler has to wait. */
static bool take_turn(const toolchain *w, turn *t) {
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    struct stat s;
    for (long k = 0; k < (processors > 1 ? processors : 1); k++) {
        snprintf(t->path, sizeof t->path, "%s/busy.%ld", w->folder, k);
        t->file = open(t->path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR);
        const bool locked = t->file >= 0 && flock(t->file, LOCK_EX | LOCK_NB) == 0;
        if (t->file < 0 || (!locked && errno != EWOULDBLOCK && errno != EINTR))
            return true;
        /* The one before may have removed it meanwhile: then it is no place any more. */
        if (locked && fstat(t->file, &s) == 0 && s.st_nlink > 0)
            return true;
        close(t->file);
    }
    return false;
}

/* Runs in a process of its own: call the compiler and move its output into place. It shares only the end of a
 * pipe and its turn's lock with the run: other open files would stay open, and locked, as long as it lives.
 * Between fork and exec only async-signal-safe functions may be called. */
static void run_compiler(char *const *words, int source, const char *made, const char *path, int outcome,
                         const turn *t) {
    sigset_t none;
    /* Move all away from the descriptors 0, 3 and 4, which they get below. */
    source = fcntl(source, F_DUPFD, 5);
    outcome = fcntl(outcome, F_DUPFD, 5);
    const int lock = t->file >= 0 ? fcntl(t->file, F_DUPFD, 5) : -1;
    setsid();
    sigemptyset(&none);
    pthread_sigmask(SIG_SETMASK, &none, NULL);
    umask(S_IRWXG | S_IRWXO);
    int nothing = open("/dev/null", O_RDWR);
    if (nothing < 0 || dup2(nothing, 1) < 0 || dup2(nothing, 2) < 0 || dup2(source, 0) < 0 ||
        dup2(outcome, 3) < 0 || (lock >= 0 && dup2(lock, 4) < 0))
        _exit(1);
    for (int k = lock >= 0 ? 5 : 4; k < descriptors_max; k++)
        close(k);
    pid_t compiler = fork();
    if (compiler == 0) {
        const struct rlimit time = {seconds_max, seconds_max}, memory = {bytes_max, bytes_max};
        setrlimit(RLIMIT_CPU, &time);
        setrlimit(RLIMIT_AS, &memory);
        setpriority(PRIO_PROCESS, 0, niceness);
        close(3);
        close(4);
        execv(words[0], words);
        _exit(127);
    }
    int status = 1;
    while (compiler > 0 && waitpid(compiler, &status, 0) < 0 && errno == EINTR)
        continue;
    bool done = compiler > 0 && status == 0 && rename(made, path) == 0;
    if (!done)
        unlink(made);
    if (lock >= 0)
        unlink(t->path);
    ssize_t told = write(3, done ? "+" : "-", 1);
    _exit(told == 1 ? 0 : 1);
}

/* Start the compiler; returns the pipe end that will tell its outcome, or -1. A double fork hides its process
 * from whoever waits for children of this program. Signals wait until it has a session of its own. */
static int start(toolchain *w, const char *flags, const char *source, const char *path, const turn *t) {
    static const char *const rest[] = {"-x", "c", "-", "-o"};
    char made[path_max + name_max], own[256], *words[words_max] = {w->compiler};
    int told[2], file = keep_source(w, source), count = 1;
    struct timespec now;
    sigset_t all, before;
    clock_gettime(CLOCK_REALTIME, &now);
    snprintf(made, sizeof made, "%s.%lx.%lx", path, (unsigned long)getpid(),
             (unsigned long)now.tv_sec * 1000000000UL + (unsigned long)now.tv_nsec);
    snprintf(own, sizeof own, "%s", flags);
    for (int k = 0; k < option_count; k++)
        words[count++] = (char *)(size_t)options[k];
    for (char *next = own, *flag; (flag = strtok_r(next, " ", &next)) && count < words_max - 6;)
        words[count++] = flag;
    for (int k = 0; k < 4; k++)
        words[count++] = (char *)(size_t)rest[k];
    words[count] = made;
    if (file < 0 || pipe(told) != 0) {
        if (file >= 0)
            close(file);
        return -1;
    }
    fcntl(file, F_SETFD, FD_CLOEXEC);
    fcntl(told[0], F_SETFD, FD_CLOEXEC);
    fcntl(told[1], F_SETFD, FD_CLOEXEC);
    fcntl(told[0], F_SETFL, O_NONBLOCK);
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    pid_t between = fork();
    if (between == 0) {
        if (fork() == 0)
            run_compiler(words, file, made, path, told[1], t);
        _exit(0);
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    while (between > 0 && waitpid(between, NULL, 0) < 0 && errno == EINTR)
        continue;
    close(told[1]);
    close(file);
    if (between > 0)
        return told[0];
    close(told[0]);
    return -1;
}

/* The next state of a function that is not ready yet. */
static progress advance(saltus_compiled *c, progress now, saltus_compile_source *make, const void *from) {
    struct timespec time;
    toolchain w;
    clock_gettime(CLOCK_MONOTONIC, &time);
    if (now == progress_runs) {
        char said = '-'; /* stays '-' if the pipe closes without a word */
        if (read(c->outcome, &said, 1) < 0 && (errno == EAGAIN || errno == EINTR))
            return now;
        close(c->outcome);
        c->outcome = -1;
        return said == '+' && load(c) ? progress_ready : progress_over;
    }
    if (now == progress_none) {
        const saltus_compile_shape *shape = &c->shape;
        c->since = time;
        if (open_toolchain(&w) || !find_place(&w, shape->flags, make, from, c->path))
            return progress_over;
        const size_t used = strlen(c->path);
        snprintf(c->path + used, path_max - used, "-%s-%d-%d-%d.so", shape->wide ? "lanes" : "alone",
                 shape->order, shape->columns, shape->directions);
        return load(c) ? progress_ready : progress_wait;
    }
    if (1e3 * (double)(time.tv_sec - c->since.tv_sec) + 1e-6 * (double)(time.tv_nsec - c->since.tv_nsec) <
        c->shape.delay)
        return now;
    /* Another process may have compiled it meanwhile. */
    if (load(c))
        return progress_ready;
    if (open_toolchain(&w))
        return progress_over;
    turn own;
    if (!take_turn(&w, &own)) {
        c->since = time;
        return now;
    }
    char *source = make(from, &c->shape);
    if (source) {
        saltus_kept_trim(w.folder);
        c->outcome = start(&w, c->shape.flags, source, c->path, &own);
    }
    free(source);
    /* Give the place back if no compiler has got it. */
    if (own.file >= 0 && c->outcome < 0)
        unlink(own.path);
    if (own.file >= 0)
        close(own.file);
    return c->outcome >= 0 ? progress_runs : progress_over;
}

saltus_compiled_function *saltus_compiled_get(saltus_compiled *compiled) {
    return atomic_load_explicit(&compiled->function, memory_order_acquire);
}

saltus_compiled_function *saltus_compiled_ask(saltus_compiled *compiled, saltus_compile_source *source,
                                              const void *from) {
    const progress now = (progress)atomic_load_explicit(&compiled->progress, memory_order_acquire);
    if (now < progress_ready && pthread_mutex_trylock(&compiled->lock) == 0) {
        const progress still = (progress)atomic_load(&compiled->progress);
        if (still < progress_ready)
            atomic_store(&compiled->progress, advance(compiled, still, source, from));
        pthread_mutex_unlock(&compiled->lock);
    }
    return saltus_compiled_get(compiled);
}

saltus_compiled_list *saltus_compiled_list_new(void) {
    saltus_compiled_list *list = calloc(1, sizeof *list);
    if (list)
        pthread_mutex_init(&list->lock, NULL);
    return list;
}

void saltus_compiled_release(saltus_compiled *compiled) {
    if (!compiled || atomic_fetch_sub(&compiled->owners, 1) > 1)
        return;
    if (compiled->outcome >= 0)
        close(compiled->outcome);
    if (compiled->library)
        dlclose(compiled->library);
    pthread_mutex_destroy(&compiled->lock);
    free(compiled);
}

void saltus_compiled_list_free(saltus_compiled_list *list) {
    if (!list)
        return;
    for (int k = 0; k < list->items.count; k++)
        saltus_compiled_release(((saltus_compiled **)list->items.items)[k]);
    free(list->items.items);
    pthread_mutex_destroy(&list->lock);
    free(list);
}

saltus_compiled *saltus_compiled_hold(saltus_compiled_list *list, const saltus_compile_shape *shape) {
    saltus_compiled *found = NULL;
    if (!list)
        return NULL;
    pthread_mutex_lock(&list->lock);
    for (int k = 0; k < list->items.count && !found; k++) {
        saltus_compiled *own = ((saltus_compiled **)list->items.items)[k];
        const saltus_compile_shape *other = &own->shape;
        if (strcmp(other->flags, shape->flags) == 0 && other->wide == shape->wide &&
            other->order == shape->order && other->columns == shape->columns &&
            other->directions == shape->directions)
            found = own;
    }
    saltus_compiled *made = found ? NULL : calloc(1, sizeof *made);
    saltus_compiled **entry = made ? saltus_list_add(&list->items, sizeof *entry) : NULL;
    if (entry) {
        *entry = found = made;
        made->shape = *shape;
        made->outcome = -1;
        atomic_init(&made->owners, 1);
        atomic_init(&made->function, NULL);
        atomic_init(&made->progress, progress_none);
        pthread_mutex_init(&made->lock, NULL);
    } else
        free(made);
    if (found)
        atomic_fetch_add(&found->owners, 1);
    pthread_mutex_unlock(&list->lock);
    return found;
}

void saltus_compile_tell(const saltus_compile_shape *shape, saltus_compile_source *source, const void *from,
                         char *text, size_t size) {
    toolchain w;
    char path[path_max];
    const char *obstacle = open_toolchain(&w);
    if (!obstacle && !find_place(&w, shape->flags, source, from, path))
        obstacle = "there are too many equations, or too little memory";
    if (obstacle) {
        snprintf(text, size, "interpreted: %s", obstacle);
        return;
    }
    int kept = 0;
    DIR *folder = opendir(w.folder);
    const char *key = strrchr(path, '/') + 1;
    for (const struct dirent *d; folder && (d = readdir(folder));) {
        const char *end = strrchr(d->d_name, '.');
        kept += strncmp(d->d_name, key, strlen(key)) == 0 && end && strcmp(end, ".so") == 0;
    }
    if (folder)
        closedir(folder);
    snprintf(text, size,
             "interpreted at first, compiled by %s in runs of more than %d ms (functions of these equations "
             "kept in %s: %d)",
             w.compiler, shape->delay, w.folder, kept);
}
