// SPDX-License-Identifier: BSD-2-Clause
/* LD_PRELOAD: the n-th call of a function that touches kernel, disk, bus or memory ends the process
 * with SIGKILL, or fails. Calls that may wait without end are reported. See nth_call.h. */
#define _GNU_SOURCE
#include "nth_call.h"

#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/random.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <sys/timerfd.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static struct nth_call* control; /* NULL until the library is ready: the loader allocates, too */

static void* original(const char* name) {
  void* found = dlsym(RTLD_NEXT, name);

  if (!found) abort();
  return found;
}

/* By the system call itself: nothing here may be counted. */
static long raw(long number, long a, long b, long c, long d, long e, long f) {
  static long (*call)(long, ...);

  if (!call) call = (long (*)(long, ...))original("syscall");
  return call(number, a, b, c, d, e, f);
}

__attribute__((constructor)) static void begin(void) {
  const char* path = getenv("NTH_CALL");
  struct nth_call* shared;
  void* caller;
  long fd, at;

  if (!path) return;
  fd = raw(SYS_openat, AT_FDCWD, (long)path, O_RDWR | O_CLOEXEC, 0, 0, 0);
  if (fd < 0) return; /* a child that may not open it is not watched */
  at = raw(SYS_mmap, 0, sizeof(*control), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  raw(SYS_close, fd, 0, 0, 0, 0, 0);
  if (at == -1) abort();
  shared = (struct nth_call*)at;
  backtrace(&caller, 1); /* the first one allocates */
  if (!shared->pid) __atomic_store_n(&shared->pid, (uint64_t)getpid(), __ATOMIC_SEQ_CST);
  control = shared;
}

static void end_later(uint64_t microseconds) {
  struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGKILL};
  struct itimerspec when = {.it_value = {.tv_sec = (time_t)(microseconds / 1000000),
                                         .tv_nsec = (long)(microseconds % 1000000) * 1000}};
  timer_t timer;

  if (timer_create(CLOCK_MONOTONIC, &event, &timer) || timer_settime(timer, 0, &when, NULL))
    abort();
}

/* Counts a call; true: it is to fail, errno is set. */
static int hit(enum nth_call_class class) {
  uint64_t number;

  if (!control || (!control->children && control->pid != (uint64_t)getpid())) return 0;
  __atomic_add_fetch(&control->counts[class], 1, __ATOMIC_RELAXED);
  if (!(control->classes >> class & 1)) return 0;
  number = __atomic_add_fetch(&control->calls, 1, __ATOMIC_SEQ_CST);
  switch (control->mode) {
    case NTH_CALL_KILL:
      if (number != control->at) return 0;
      if (control->after_us)
        end_later(control->after_us);
      else
        raw(SYS_kill, getpid(), SIGKILL, 0, 0, 0, 0);
      return 0;
    case NTH_CALL_FAIL:
    case NTH_CALL_FAIL_FROM:
      if (number < control->at || (number > control->at && control->mode == NTH_CALL_FAIL))
        return 0;
      __atomic_add_fetch(&control->failed, 1, __ATOMIC_RELAXED);
      errno = (int)control->error;
      return 1;
  }
  return 0;
}

/* --- what may wait without end --- */

static __attribute__((noinline)) void report_wait(const char* name, int fd) {
  void* callers[16];
  int count, i;
  size_t used;

  if (__atomic_fetch_add(&control->waits, 1, __ATOMIC_SEQ_CST)) return;
  used = (size_t)snprintf(control->first_wait, sizeof(control->first_wait), "%s of descriptor %d\n",
                          name, fd);
  count = backtrace(callers, 16);
  for (i = 2; i < count; i++) { /* 0 and 1 are this function and the one below */
    Dl_info where;

    if (!dladdr(callers[i], &where) || !where.dli_fname) continue;
    if (used >= sizeof(control->first_wait)) return;
    used += (size_t)snprintf(control->first_wait + used, sizeof(control->first_wait) - used,
                             "%s+%#lx\n", where.dli_fname,
                             (unsigned long)((char*)callers[i] - (char*)where.dli_fbase));
  }
}

/*
 * A call that sends to, receives from or connects `fd`. What cannot be opened once more is written
 * to where it is ready (base/at_once.cc): while opening is made to fail nothing is reported of
 * write.
 */
static __attribute__((noinline)) void may_wait(const char* name, int fd, int flags) {
  const int before = errno;
  struct stat is;
  int domain = 0;
  socklen_t size = sizeof(domain);

  if (!control || control->pid != (uint64_t)getpid() || flags & MSG_DONTWAIT) return;
  if (control->failed && control->classes >> NTH_CALL_OPEN & 1 && !strcmp(name, "write")) return;
  if (!(raw(SYS_fcntl, fd, F_GETFL, 0, 0, 0, 0) & O_NONBLOCK) &&
      !raw(SYS_fstat, fd, (long)&is, 0, 0, 0, 0)) {
    if (S_ISSOCK(is.st_mode))
      raw(SYS_getsockopt, fd, SOL_SOCKET, SO_DOMAIN, (long)&domain, (long)&size, 0);
    if ((S_ISSOCK(is.st_mode) && domain != AF_NETLINK) || S_ISFIFO(is.st_mode) ||
        (S_ISCHR(is.st_mode) && major(is.st_rdev) != 1 /* /dev/null */))
      report_wait(name, fd);
  }
  errno = before;
}

#define WRAP_CHECKED(class, result, failed, name, parameters, arguments, check) \
  result name parameters {                                                      \
    static result(*call) parameters;                                            \
                                                                                \
    if (!call) call = (result(*) parameters)original(#name);                    \
    check;                                                                      \
    if (hit(class)) return failed;                                              \
    return call arguments;                                                      \
  }
#define WRAP(class, result, failed, name, parameters, arguments) \
  WRAP_CHECKED(class, result, failed, name, parameters, arguments, (void)0)
#define NUMBER(class, name, parameters, arguments) \
  WRAP(NTH_CALL_##class, int, -1, name, parameters, arguments)
#define BYTES(class, name, parameters, arguments) \
  WRAP(NTH_CALL_##class, ssize_t, -1, name, parameters, arguments)

/* --- files --- */

WRAP_CHECKED(NTH_CALL_READ, ssize_t, -1, read, (int fd, void* at, size_t size), (fd, at, size),
             may_wait("read", fd, 0))
BYTES(READ, pread, (int fd, void* at, size_t size, off_t from), (fd, at, size, from))
BYTES(READ, pread64, (int fd, void* at, size_t size, off64_t from), (fd, at, size, from))
WRAP_CHECKED(NTH_CALL_WRITE, ssize_t, -1, write, (int fd, const void* at, size_t size),
             (fd, at, size), may_wait("write", fd, 0))
BYTES(WRITE, pwrite, (int fd, const void* at, size_t size, off_t to), (fd, at, size, to))
BYTES(WRITE, pwrite64, (int fd, const void* at, size_t size, off64_t to), (fd, at, size, to))
WRAP_CHECKED(NTH_CALL_WRITE, ssize_t, -1, writev, (int fd, const struct iovec* parts, int count),
             (fd, parts, count), may_wait("writev", fd, 0))
NUMBER(WRITE, ftruncate, (int fd, off_t size), (fd, size))
NUMBER(WRITE, ftruncate64, (int fd, off64_t size), (fd, size))
NUMBER(SYNC, fsync, (int fd), (fd))
NUMBER(SYNC, fdatasync, (int fd), (fd))
NUMBER(NAME, rename, (const char* from, const char* to), (from, to))
NUMBER(NAME, renameat, (int a, const char* from, int b, const char* to), (a, from, b, to))
NUMBER(NAME, unlink, (const char* path), (path))
NUMBER(NAME, unlinkat, (int at, const char* path, int flags), (at, path, flags))
NUMBER(NAME, remove, (const char* path), (path))
NUMBER(NAME, mkdir, (const char* path, mode_t mode), (path, mode))
NUMBER(NAME, rmdir, (const char* path), (path))
WRAP(NTH_CALL_OPEN, DIR*, NULL, opendir, (const char* path), (path))
WRAP(NTH_CALL_OPEN, DIR*, NULL, fdopendir, (int fd), (fd))

#define OPEN(name)                                                     \
  int name(const char* path, int flags, ...) {                         \
    static int (*call)(const char*, int, ...);                         \
    mode_t mode;                                                       \
    va_list more;                                                      \
                                                                       \
    va_start(more, flags);                                             \
    mode = flags & (O_CREAT | __O_TMPFILE) ? va_arg(more, mode_t) : 0; \
    va_end(more);                                                      \
    if (!call) call = (int (*)(const char*, int, ...))original(#name); \
    return hit(NTH_CALL_OPEN) ? -1 : call(path, flags, mode);          \
  }
OPEN(open)
OPEN(open64)

#define OPENAT(name)                                                        \
  int name(int at, const char* path, int flags, ...) {                      \
    static int (*call)(int, const char*, int, ...);                         \
    mode_t mode;                                                            \
    va_list more;                                                           \
                                                                            \
    va_start(more, flags);                                                  \
    mode = flags & (O_CREAT | __O_TMPFILE) ? va_arg(more, mode_t) : 0;      \
    va_end(more);                                                           \
    if (!call) call = (int (*)(int, const char*, int, ...))original(#name); \
    return hit(NTH_CALL_OPEN) ? -1 : call(at, path, flags, mode);           \
  }
OPENAT(openat)
OPENAT(openat64)

/* --- sockets: those of netlink are a class of their own --- */

static uint8_t is_netlink[1024];
static enum nth_call_class class_of(int fd) {
  return fd >= 0 && fd < (int)sizeof(is_netlink) && is_netlink[fd] ? NTH_CALL_NETLINK
                                                                   : NTH_CALL_SOCKET;
}

int socket(int domain, int type, int protocol) {
  const enum nth_call_class class = domain == AF_NETLINK ? NTH_CALL_NETLINK : NTH_CALL_SOCKET;
  int fd;

  if (hit(class)) return -1;
  fd = (int)raw(SYS_socket, domain, type, protocol, 0, 0, 0);
  if (fd >= 0 && fd < (int)sizeof(is_netlink)) is_netlink[fd] = class == NTH_CALL_NETLINK;
  return fd;
}

#define SOCKETS(result, name, parameters, arguments) \
  WRAP(class_of(fd), result, -1, name, parameters, arguments)
#define TALKS(result, name, flags, parameters, arguments) \
  WRAP_CHECKED(class_of(fd), result, -1, name, parameters, arguments, may_wait(#name, fd, flags))
SOCKETS(int, bind, (int fd, const struct sockaddr* to, socklen_t size), (fd, to, size))
TALKS(int, connect, 0, (int fd, const struct sockaddr* to, socklen_t size), (fd, to, size))
SOCKETS(int, setsockopt, (int fd, int level, int name, const void* at, socklen_t size),
        (fd, level, name, at, size))
SOCKETS(int, getsockopt, (int fd, int level, int name, void* at, socklen_t* size),
        (fd, level, name, at, size))
TALKS(int, accept4, 0, (int fd, struct sockaddr* of, socklen_t* size, int flags),
      (fd, of, size, flags))
TALKS(ssize_t, send, flags, (int fd, const void* at, size_t size, int flags), (fd, at, size, flags))
TALKS(ssize_t, recv, flags, (int fd, void* at, size_t size, int flags), (fd, at, size, flags))
TALKS(ssize_t, sendto, flags,
      (int fd, const void* at, size_t size, int flags, const struct sockaddr* to, socklen_t length),
      (fd, at, size, flags, to, length))
TALKS(ssize_t, recvfrom, flags,
      (int fd, void* at, size_t size, int flags, struct sockaddr* of, socklen_t* length),
      (fd, at, size, flags, of, length))
TALKS(ssize_t, sendmsg, flags, (int fd, const struct msghdr* message, int flags),
      (fd, message, flags))
TALKS(ssize_t, recvmsg, flags, (int fd, struct msghdr* message, int flags), (fd, message, flags))

/* --- standard error by <stdio.h>: its writes have no name of their own in the C library --- */

size_t fwrite(const void* at, size_t size, size_t n, FILE* file) {
  static size_t (*call)(const void*, size_t, size_t, FILE*);

  if (!call) call = (size_t (*)(const void*, size_t, size_t, FILE*))original("fwrite");
  if (file == stderr) may_wait("fwrite", STDERR_FILENO, 0);
  return call(at, size, n, file);
}

int fputs(const char* text, FILE* file) {
  static int (*call)(const char*, FILE*);

  if (!call) call = (int (*)(const char*, FILE*))original("fputs");
  if (file == stderr) may_wait("fputs", STDERR_FILENO, 0);
  return call(text, file);
}

/* --- memory --- */

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);
void* malloc(size_t n) { return hit(NTH_CALL_MEMORY) ? NULL : __libc_malloc(n); }
void* calloc(size_t n, size_t size) { return hit(NTH_CALL_MEMORY) ? NULL : __libc_calloc(n, size); }
void* realloc(void* p, size_t n) { return hit(NTH_CALL_MEMORY) ? NULL : __libc_realloc(p, n); }
void* aligned_alloc(size_t to, size_t n) {
  return hit(NTH_CALL_MEMORY) ? NULL : __libc_memalign(to, n);
}

WRAP(NTH_CALL_MMAP, void*, MAP_FAILED, mmap,
     (void* at, size_t size, int access, int flags, int fd, off_t from),
     (at, size, access, flags, fd, from))
WRAP(NTH_CALL_MMAP, void*, MAP_FAILED, mmap64,
     (void* at, size_t size, int access, int flags, int fd, off64_t from),
     (at, size, access, flags, fd, from))
NUMBER(MMAP, munmap, (void* at, size_t size), (at, size))

/* --- waiting, clocks, chance, devices --- */

NUMBER(EPOLL, epoll_create1, (int flags), (flags))
NUMBER(EPOLL, epoll_ctl, (int set, int what, int fd, struct epoll_event* event),
       (set, what, fd, event))
NUMBER(EPOLL, epoll_wait, (int set, struct epoll_event* events, int most, int ms),
       (set, events, most, ms))
BYTES(RANDOM, getrandom, (void* at, size_t size, unsigned flags), (at, size, flags))
NUMBER(TIMER, timerfd_create, (clockid_t clock, int flags), (clock, flags))
NUMBER(TIMER, timerfd_settime,
       (int fd, int flags, const struct itimerspec* to, struct itimerspec* from),
       (fd, flags, to, from))
NUMBER(TIMER, eventfd, (unsigned from, int flags), (from, flags))
NUMBER(EPOLL, poll, (struct pollfd * of, nfds_t count, int ms), (of, count, ms))
NUMBER(EPOLL, ppoll,
       (struct pollfd * of, nfds_t count, const struct timespec* most, const sigset_t* mask),
       (of, count, most, mask))
NUMBER(DEVICE, setns, (int fd, int kind), (fd, kind))

int ioctl(int fd, unsigned long request, ...) {
  static int (*call)(int, unsigned long, ...);
  va_list more;
  void* argument;

  va_start(more, request);
  argument = va_arg(more, void*);
  va_end(more);
  if (!call) call = (int (*)(int, unsigned long, ...))original("ioctl");
  return hit(NTH_CALL_DEVICE) ? -1 : call(fd, request, argument);
}

/* --- what files and sockets are like --- */

NUMBER(STATE, stat, (const char* path, struct stat* is), (path, is))
NUMBER(STATE, stat64, (const char* path, struct stat64* is), (path, is))
NUMBER(STATE, lstat, (const char* path, struct stat* is), (path, is))
NUMBER(STATE, lstat64, (const char* path, struct stat64* is), (path, is))
NUMBER(STATE, fstat, (int fd, struct stat* is), (fd, is))
NUMBER(STATE, fstat64, (int fd, struct stat64* is), (fd, is))
NUMBER(STATE, fstatat, (int at, const char* path, struct stat* is, int flags),
       (at, path, is, flags))
NUMBER(STATE, statfs, (const char* path, struct statfs* is), (path, is))
NUMBER(STATE, fstatfs, (int fd, struct statfs* is), (fd, is))
NUMBER(STATE, access, (const char* path, int how), (path, how))
NUMBER(STATE, getsockname, (int fd, struct sockaddr* of, socklen_t* size), (fd, of, size))
BYTES(STATE, readlink, (const char* path, char* at, size_t size), (path, at, size))
WRAP(NTH_CALL_STATE, struct dirent*, NULL, readdir, (DIR * in), (in))
WRAP(NTH_CALL_STATE, struct dirent64*, NULL, readdir64, (DIR * in), (in))

/* --- handles --- */

NUMBER(HANDLE, flock, (int fd, int how), (fd, how))
NUMBER(HANDLE, dup, (int fd), (fd))
NUMBER(HANDLE, dup2, (int fd, int to), (fd, to))
NUMBER(HANDLE, dup3, (int fd, int to, int flags), (fd, to, flags))
NUMBER(HANDLE, signalfd, (int fd, const sigset_t* of, int flags), (fd, of, flags))
NUMBER(HANDLE, pipe2, (int ends[2], int flags), (ends, flags))
NUMBER(HANDLE, socketpair, (int domain, int type, int protocol, int ends[2]),
       (domain, type, protocol, ends))
NUMBER(HANDLE, memfd_create, (const char* name, unsigned flags), (name, flags))
NUMBER(HANDLE, fallocate, (int fd, int mode, off_t from, off_t size), (fd, mode, from, size))
NUMBER(HANDLE, chmod, (const char* path, mode_t mode), (path, mode))
NUMBER(HANDLE, fchmod, (int fd, mode_t mode), (fd, mode))
NUMBER(HANDLE, chown, (const char* path, uid_t user, gid_t group), (path, user, group))
NUMBER(HANDLE, fchown, (int fd, uid_t user, gid_t group), (fd, user, group))

#define FCNTL(name)                                        \
  int name(int fd, int command, ...) {                     \
    va_list more;                                          \
    long argument, done;                                   \
                                                           \
    va_start(more, command);                               \
    argument = va_arg(more, long);                         \
    va_end(more);                                          \
    if (hit(NTH_CALL_HANDLE)) return -1;                   \
    done = raw(SYS_fcntl, fd, command, argument, 0, 0, 0); \
    return (int)done;                                      \
  }
FCNTL(fcntl)
FCNTL(fcntl64)

/* --- processes --- */

NUMBER(PROCESS, fork, (void), ())
NUMBER(PROCESS, waitpid, (pid_t of, int* status, int flags), (of, status, flags))
NUMBER(PROCESS, kill, (pid_t whom, int with), (whom, with))

int prctl(int what, ...) {
  long a[4];
  va_list more;
  int i;

  va_start(more, what);
  for (i = 0; i < 4; i++) a[i] = va_arg(more, long);
  va_end(more);
  return hit(NTH_CALL_PROCESS) ? -1 : (int)raw(SYS_prctl, what, a[0], a[1], a[2], a[3], 0);
}

/* bpf(2) has no name of its own in the C library. */
long syscall(long number, ...) {
  long a[6];
  va_list more;
  int i;

  va_start(more, number);
  for (i = 0; i < 6; i++) a[i] = va_arg(more, long);
  va_end(more);
  if (number == SYS_bpf && hit(NTH_CALL_BPF)) return -1;
  return raw(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}
