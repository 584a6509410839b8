/* A disk, a network and a clock that fail by a plan. The library is preloaded into the program (LD_PRELOAD) and intercepts libc's calls.
 *
 * In (environment):
 *   FAULTS_ROOT     folder; only files below it count. Sockets of the loopback count everywhere.
 *   FAULTS_PLAN     faults, one per line: KIND NAME N ACTION [NUMBER]; the N-th call of this kind on files whose name ends with
 *                   NAME (* for any). Kinds: open read write sync rename unlink mkdir truncate stat list connect send
 *                   recv clock.
 *                   Actions: an errno's name (followed by +, also for every later call), short BYTES, slow MILLISECONDS,
 *                   kill, kill-after, power [SEED], power-after [SEED], jump SECONDS.
 *   FAULTS_TRACE    file that lists every counted call: "KIND NAME ok" or the fault.
 *   FAULTS_SIDE     folder on the same disk, outside of FAULTS_ROOT, for files that a rename or an unlink has removed.
 *   FAULTS_STEP_US  step of the monotonic clock at each reading; it does not advance otherwise.
 * Out: the program's calls fail, are short or slow, or the process dies. `power` is a power cut: data that were not synced are
 * lost. Files keep their synced bytes, folders their synced names. The seed selects what else has reached the disk: the first
 * few names that changed, a part of the bytes, or all but one sector; nothing with seed 0. Children of the program are not
 * affected.
 */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static __thread int inside;
static int is_on, trace_file = -1;
static char root[PATH_MAX], side[PATH_MAX];
static atomic_long readings, jump_s;
static int64_t began_ns, step_ns;

static void stop(const char *why, const char *what) {
    dprintf(2, "faults: %s: %s\n", why, what);
    _exit(97);
}

#include "plan.h"

static int64_t now_ns(clockid_t clock) {
    struct timespec now;
    syscall(SYS_clock_gettime, clock, &now);
    return now.tv_sec * 1000000000LL + now.tv_nsec;
}

__attribute__((constructor)) static void begin(void) {
    const char *folder = getenv("FAULTS_ROOT"), *step = getenv("FAULTS_STEP_US"), *trace = getenv("FAULTS_TRACE");
    if (!folder || getenv("FAULTS_PROCESS")) return;
    setenv("FAULTS_PROCESS", "1", 1);
    snprintf(root, sizeof root, "%s/", folder);
    snprintf(side, sizeof side, "%s", getenv("FAULTS_SIDE") ?: "/tmp");
    char *plan = strdup(getenv("FAULTS_PLAN") ?: ""), *rest = plan, *line;
    while ((line = strsep(&rest, "\n")))
        if (*line) parse(line);
    free(plan);
    if (trace) trace_file = syscall(SYS_openat, AT_FDCWD, trace, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    step_ns = step ? atol(step) * 1000 : 0;
    began_ns = now_ns(CLOCK_MONOTONIC);
    is_on = 1;
}

/* Returns the path relative to the root; null outside the root. */
static const char *below(const char *path) {
    size_t length = strlen(root);
    return !strncmp(path, root, length) ? path + length : NULL;
}

static int path_of(int fd, char *path) {
    char link[32];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = syscall(SYS_readlinkat, AT_FDCWD, link, path, PATH_MAX - 1);
    path[length < 0 ? 0 : length] = 0;
    return length > 0;
}

static void full(int folder, const char *name, char *path) {
    char base[PATH_MAX];
    if (*name == '/') { snprintf(path, PATH_MAX, "%s", name); return; }
    if (folder == AT_FDCWD) { if (!getcwd(base, sizeof base)) *base = 0; }
    else path_of(folder, base);
    if (snprintf(path, PATH_MAX, "%s/%s", base, name) >= PATH_MAX) *path = 0;
}

static void note(const char *kind, const char *name, const char *what) {
    char text[PATH_MAX + 96];
    int length = snprintf(text, sizeof text, "%s %s %s\n", kind, name, what);
    if (trace_file >= 0) syscall(SYS_write, trace_file, text, length);
}

#include "disk.h"

/* -- Faults ------------------------------------------------------------------------------------------------------------ */

static int ends_with(const char *path, const char *name) {
    size_t length = strlen(path), end = strlen(name);
    return !strcmp(name, "*") || (length >= end && !strcmp(path + length - end, name));
}

static void die(const struct fault *fault) {
    inside = 1;
    if (fault->action == POWER) power(fault->number);
    kill(getpid(), SIGKILL);
    for (;;) pause();
}

/* Counts the call. Returns the fault that is due, or null. */
static struct fault *due(const char *kind, const char *name) {
    struct fault *found = NULL;
    for (int i = 0; i < fault_count; i++) {
        struct fault *fault = &faults[i];
        if (strcmp(fault->kind, kind) || !ends_with(name, fault->name)) continue;
        fault->seen++;
        if (!found && (fault->seen == fault->at || (fault->stays && fault->seen > fault->at))) found = fault;
    }
    return found;
}

/* Applies a fault before a call, with the lock held: dies, fails (then true), or lets the call proceed. */
static int fails(struct fault *fault, const char *kind, const char *name) {
    if (!fault) return 0;
    if (fault->action == SLOW) {
        struct timespec wait = {fault->number / 1000, fault->number % 1000 * 1000000};
        note(kind, name, "slow");
        pthread_mutex_unlock(&lock);
        syscall(SYS_nanosleep, &wait, NULL);
        pthread_mutex_lock(&lock);
    }
    if (fault->after) return 0;
    if (fault->action == KILL || fault->action == POWER) { note(kind, name, fault->what); die(fault); }
    if (fault->action != FAIL) return 0;
    note(kind, name, fault->what);
    errno = fault->error;
    return 1;
}

/* Records the result after a call, and applies faults that come after it. */
static void passed(const struct fault *fault, const char *kind, const char *name, long result) {
    note(kind, name, result < 0 ? "refused" : fault && fault->action == SHORT ? "short" : "ok");
    if (fault && fault->after) { note(kind, name, fault->what); die(fault); }
}

static size_t shorter(const struct fault *fault, size_t length) {
    int is_short = fault && fault->action == SHORT && length > 1;
    return is_short && (size_t)fault->number < length ? (fault->number > 0 ? (size_t)fault->number : 1) : length;
}

#define BEGIN int before = errno; inside = 1; pthread_mutex_lock(&lock); struct fault *fault = NULL
#define END pthread_mutex_unlock(&lock); inside = 0; if (result >= 0) errno = before; return result

/* -- Files ------------------------------------------------------------------------------------------------------------- */

static int opened(int folder, const char *name, int flags, mode_t mode) {
    char path[PATH_MAX];
    const char *within = NULL;
    if (is_on && !inside) { full(folder, name, path); within = below(path); }
    if (!within) return syscall(SYS_openat, folder, name, flags, mode);
    BEGIN;
    int result = -1;
    int was_there = !syscall(SYS_faccessat, AT_FDCWD, path, F_OK);
    fault = due("open", within);
    if (!fails(fault, "open", within)) {
        result = syscall(SYS_openat, AT_FDCWD, path, flags, mode);
        int error = errno;
        if (result >= 0 && (flags & O_CREAT)) {
            know(result, !was_there || (flags & O_TRUNC));
            if (!was_there) changed(CREATED, path, NULL, NULL);
        } else if (result >= 0) know(result, flags & O_TRUNC);
        errno = error;
        passed(fault, "open", within, result);
    }
    END;
}

#define MODE va_list more; va_start(more, flags); mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0; va_end(more)
int open(const char *name, int flags, ...) { MODE; return opened(AT_FDCWD, name, flags, mode); }
int open64(const char *name, int flags, ...) { MODE; return opened(AT_FDCWD, name, flags, mode); }
int openat(int folder, const char *name, int flags, ...) { MODE; return opened(folder, name, flags, mode); }
int openat64(int folder, const char *name, int flags, ...) { MODE; return opened(folder, name, flags, mode); }

/* Returns the name of a file relative to the root; null outside the root. */
static const char *watched(int fd, char *path) {
    if (!is_on || inside || !path_of(fd, path)) return NULL;
    return below(path);
}

/* Notes the first byte that a write changes: the disk does not have the file from there on. */
static void writes_at(int fd, off_t offset) {
    struct file *file = know(fd, 0);
    if (!file) return;
    if (offset < 0) {
        struct stat about;
        offset = fcntl(fd, F_GETFL) & O_APPEND ? (fstat(fd, &about), about.st_size) : lseek(fd, 0, SEEK_CUR);
    }
    if (offset < file->durable) file->durable = offset;
}

/* Reads or writes, with faults: by `call` at the file's position, by `call_at` at an offset of 0 or more. */
static ssize_t moved(const char *kind, long call, long call_at, int fd, void *bytes, size_t length, off_t offset) {
    char path[PATH_MAX];
    const char *name = watched(fd, path);
    if (!name) return offset < 0 ? syscall(call, fd, bytes, length) : syscall(call_at, fd, bytes, length, offset);
    BEGIN;
    ssize_t result = -1;
    fault = due(kind, name);
    if (!fails(fault, kind, name)) {
        size_t some = shorter(fault, length);
        if (call == SYS_write) writes_at(fd, offset);
        result = offset < 0 ? syscall(call, fd, bytes, some) : syscall(call_at, fd, bytes, some, offset);
        passed(fault, kind, name, result);
    }
    END;
}

static ssize_t written(int fd, const void *bytes, size_t length, off_t offset) {
    return moved("write", SYS_write, SYS_pwrite64, fd, (void *)bytes, length, offset);
}

ssize_t write(int fd, const void *bytes, size_t length) { return written(fd, bytes, length, -1); }
ssize_t pwrite(int fd, const void *bytes, size_t length, off_t at) { return written(fd, bytes, length, at); }
ssize_t pwrite64(int fd, const void *bytes, size_t length, off64_t at) { return written(fd, bytes, length, at); }

/* Writes only the first part that is not empty: callers of writev must expect short writes. */
ssize_t writev(int fd, const struct iovec *parts, int count) {
    char path[PATH_MAX];
    if (!watched(fd, path)) return syscall(SYS_writev, fd, parts, count);
    for (int i = 0; i < count; i++)
        if (parts[i].iov_len) return written(fd, parts[i].iov_base, parts[i].iov_len, -1);
    return 0;
}

ssize_t copy_file_range(int in, off64_t *from, int out, off64_t *to, size_t length, unsigned flags) {
    char path[PATH_MAX];
    /* The caller then copies by reading and writing. */
    if (watched(out, path) || watched(in, path)) { errno = ENOSYS; return -1; }
    return syscall(SYS_copy_file_range, in, from, out, to, length, flags);
}

ssize_t sendfile64(int out, int in, off64_t *from, size_t length) {
    char path[PATH_MAX];
    if (watched(out, path) || watched(in, path)) { errno = EINVAL; return -1; }
    return syscall(SYS_sendfile, out, in, from, length);
}

static ssize_t got(int fd, void *bytes, size_t length, off_t offset) {
    return moved("read", SYS_read, SYS_pread64, fd, bytes, length, offset);
}

ssize_t read(int fd, void *bytes, size_t length) { return got(fd, bytes, length, -1); }
ssize_t pread(int fd, void *bytes, size_t length, off_t at) { return got(fd, bytes, length, at); }
ssize_t pread64(int fd, void *bytes, size_t length, off64_t at) { return got(fd, bytes, length, at); }

static int synced(int fd, long call) {
    char path[PATH_MAX];
    const char *name = watched(fd, path);
    if (!name) {
        /* The root itself is also a folder. */
        if (is_on && !inside && !strncmp(path, root, strlen(root) - 1) && strlen(path) == strlen(root) - 1) name = ".";
        else return syscall(call, fd);
    }
    BEGIN;
    int result = -1;
    fault = due("sync", name);
    struct file *file = know(fd, 0);
    if (fails(fault, "sync", name)) { if (file && errno != EINTR) file->poisoned = 1; }
    else {
        /* No real sync: the disk is simulated, and no call should wait for the machine's disk. */
        struct stat about;
        result = fstat(fd, &about);
        if (S_ISDIR(about.st_mode)) folder_synced(path);
        else if (file && !file->poisoned) file->durable = about.st_size;
        passed(fault, "sync", name, result);
    }
    END;
}

int fsync(int fd) { return synced(fd, SYS_fsync); }
int fdatasync(int fd) { return synced(fd, SYS_fdatasync); }
static int truncated(int fd, off_t length) {
    char path[PATH_MAX];
    const char *name = watched(fd, path);
    if (!name) return syscall(SYS_ftruncate, fd, length);
    BEGIN;
    int result = -1;
    fault = due("truncate", name);
    if (!fails(fault, "truncate", name)) {
        struct file *file = know(fd, 0);
        result = syscall(SYS_ftruncate, fd, length);
        if (!result && file && length < file->durable) file->durable = length;
        passed(fault, "truncate", name, result);
    }
    END;
}

int ftruncate(int fd, off_t length) { return truncated(fd, length); }
int ftruncate64(int fd, off64_t length) { return truncated(fd, length); }

/* -- Names ------------------------------------------------------------------------------------------------------------- */

static int renamed(int old_folder, const char *old_name, int folder, const char *name, unsigned flags) {
    char from[PATH_MAX], to[PATH_MAX], place[PATH_MAX];
    const char *within = NULL;
    if (is_on && !inside) { full(old_folder, old_name, from); full(folder, name, to); within = below(to); }
    if (!within) return syscall(SYS_renameat2, old_folder, old_name, folder, name, flags);
    BEGIN;
    int result = -1;
    fault = due("rename", within);
    if (!fails(fault, "rename", within)) {
        const char *saved = save(to, place);
        result = syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, flags);
        int error = errno;
        if (!result) changed(RENAMED, to, from, saved);
        errno = error;
        passed(fault, "rename", within, result);
    }
    END;
}

int rename(const char *from, const char *to) { return renamed(AT_FDCWD, from, AT_FDCWD, to, 0); }
int renameat(int old, const char *from, int folder, const char *to) { return renamed(old, from, folder, to, 0); }
int renameat2(int old, const char *from, int folder, const char *to, unsigned flags) { return renamed(old, from, folder, to, flags); }

static int unlinked(int folder, const char *name, int flags) {
    char path[PATH_MAX], place[PATH_MAX];
    const char *within = NULL;
    if (is_on && !inside) { full(folder, name, path); within = below(path); }
    if (!within) return syscall(SYS_unlinkat, folder, name, flags);
    BEGIN;
    int result = -1;
    fault = due("unlink", within);
    if (!fails(fault, "unlink", within)) {
        const char *saved = flags & AT_REMOVEDIR ? NULL : save(path, place);
        result = syscall(SYS_unlinkat, AT_FDCWD, path, flags);
        int error = errno;
        if (!result) changed(flags & AT_REMOVEDIR ? REMOVED_FOLDER : UNLINKED, path, NULL, saved);
        errno = error;
        /* Removing a missing file is a normal operation. */
        passed(fault, "unlink", within, result);
    }
    END;
}

int unlink(const char *name) { return unlinked(AT_FDCWD, name, 0); }
int rmdir(const char *name) { return unlinked(AT_FDCWD, name, AT_REMOVEDIR); }
int unlinkat(int folder, const char *name, int flags) { return unlinked(folder, name, flags); }

int mkdir(const char *name, mode_t mode) {
    char path[PATH_MAX];
    const char *within = NULL;
    if (is_on && !inside) { full(AT_FDCWD, name, path); within = below(path); }
    if (!within) return syscall(SYS_mkdirat, AT_FDCWD, name, mode);
    BEGIN;
    int result = -1;
    fault = due("mkdir", within);
    if (!fails(fault, "mkdir", within)) {
        result = syscall(SYS_mkdirat, AT_FDCWD, path, mode);
        int error = errno;
        if (!result) changed(MADE_FOLDER, path, NULL, NULL);
        errno = error;
        passed(fault, "mkdir", within, result);
    }
    END;
}

/* Answers queries for the existence and size of a file. */
static int asked(int folder, const char *name) {
    char path[PATH_MAX];
    const char *within = NULL;
    if (is_on && !inside && name && *name) { full(folder, name, path); within = below(path); }
    if (!within) return 0;
    BEGIN;
    int result = 0;
    fault = due("stat", within);
    if (fails(fault, "stat", within)) result = -1;
    else passed(fault, "stat", within, 0);
    END;
}

int statx(int folder, const char *restrict name, int flags, unsigned wanted, struct statx *restrict about) {
    return asked(folder, name) ? -1 : syscall(SYS_statx, folder, name, flags, wanted, about);
}

DIR *opendir(const char *name) {
    static DIR *(*real)(const char *);
    if (!real) real = (DIR *(*)(const char *))dlsym(RTLD_NEXT, "opendir");
    char path[PATH_MAX];
    const char *within = NULL;
    if (is_on && !inside) { full(AT_FDCWD, name, path); within = below(path); }
    if (!within) return real(name);
    inside = 1;
    pthread_mutex_lock(&lock);
    struct fault *fault = due("list", within);
    DIR *result = NULL;
    if (!fails(fault, "list", within)) {
        result = real(name);
        int error = errno;
        passed(fault, "list", within, result ? 0 : -1);
        errno = error;
    }
    pthread_mutex_unlock(&lock);
    inside = 0;
    return result;
}

/* -- Network ----------------------------------------------------------------------------------------------------------- */

static int is_loopback(const struct sockaddr *address) {
    const struct sockaddr_in *internet = (const void *)address;
    return address && address->sa_family == AF_INET && ntohl(internet->sin_addr.s_addr) >> 24 == 127;
}

static int is_peer_loopback(int fd) {
    struct sockaddr_storage peer;
    socklen_t length = sizeof peer;
    return is_on && !inside && !getpeername(fd, (void *)&peer, &length) && is_loopback((void *)&peer);
}

int connect(int fd, const struct sockaddr *address, socklen_t length) {
    if (!is_on || inside || !is_loopback(address)) return syscall(SYS_connect, fd, address, length);
    BEGIN;
    int result = -1;
    fault = due("connect", "socket");
    if (!fails(fault, "connect", "socket")) {
        result = syscall(SYS_connect, fd, address, length);
        passed(fault, "connect", "socket", result);
    }
    END;
}

ssize_t send(int fd, const void *bytes, size_t length, int flags) {
    if (!is_peer_loopback(fd)) return syscall(SYS_sendto, fd, bytes, length, flags, NULL, 0);
    BEGIN;
    ssize_t result = -1;
    fault = due("send", "socket");
    if (!fails(fault, "send", "socket")) {
        result = syscall(SYS_sendto, fd, bytes, shorter(fault, length), flags, NULL, 0);
        passed(fault, "send", "socket", result);
    }
    END;
}

/* The lock is not held during the call, as a response may take long. */
ssize_t recv(int fd, void *bytes, size_t length, int flags) {
    if (!is_peer_loopback(fd)) return syscall(SYS_recvfrom, fd, bytes, length, flags, NULL, NULL);
    BEGIN;
    ssize_t result = -1;
    fault = due("recv", "socket");
    int refused = fails(fault, "recv", "socket");
    pthread_mutex_unlock(&lock);
    if (!refused) result = syscall(SYS_recvfrom, fd, bytes, shorter(fault, length), flags, NULL, NULL);
    pthread_mutex_lock(&lock);
    if (!refused) passed(fault, "recv", "socket", result);
    END;
}

/* -- Clock ------------------------------------------------------------------------------------------------------------- */

int clock_gettime(clockid_t clock, struct timespec *now) {
    int result = syscall(SYS_clock_gettime, clock, now);
    if (!is_on || inside || result) return result;
    if (clock == CLOCK_MONOTONIC && step_ns) {
        int64_t ns = began_ns + atomic_fetch_add(&readings, 1) * step_ns;
        *now = (struct timespec){ns / 1000000000, ns % 1000000000};
    } else if (clock == CLOCK_REALTIME) {
        BEGIN;
        fault = due("clock", "*");
        note("clock", "*", fault && fault->action == JUMP ? "jump" : "ok");
        if (fault && fault->action == JUMP) atomic_fetch_add(&jump_s, fault->number);
        now->tv_sec += atomic_load(&jump_s);
        END;
    }
    return 0;
}

time_t time(time_t *place) {
    struct timespec now = {0, 0};
    clock_gettime(CLOCK_REALTIME, &now);
    if (place) *place = now.tv_sec;
    return now.tv_sec;
}
