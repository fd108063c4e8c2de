// SPDX-License-Identifier: BSD-2-Clause
/* LD_PRELOAD: the n-th call of a function that touches kernel, disk, bus or memory ends the process
 * with SIGKILL, or fails. See nth_call.h. */
#define _GNU_SOURCE
#include "nth_call.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

static struct nth_call* control;

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
  long fd, at;

  if (!path) return;
  fd = raw(SYS_openat, AT_FDCWD, (long)path, O_RDWR | O_CLOEXEC, 0, 0, 0);
  if (fd < 0) abort();
  at = raw(SYS_mmap, 0, sizeof(*control), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  raw(SYS_close, fd, 0, 0, 0, 0, 0);
  if (at == -1) abort();
  control = (struct nth_call*)at;
  if (!control->pid) __atomic_store_n(&control->pid, (uint64_t)getpid(), __ATOMIC_SEQ_CST);
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
static int hit(uint64_t kind) {
  uint64_t number;

  if (!control || (control->kinds && !(control->kinds & kind)) ||
      control->pid != (uint64_t)getpid())
    return 0;
  number = __atomic_add_fetch(&control->calls, 1, __ATOMIC_SEQ_CST);
  switch (control->mode) {
    case NTH_CALL_KILL:
      if (number != control->at) return 0;
      if (control->after_us)
        end_later(control->after_us);
      else
        kill(getpid(), SIGKILL);
      return 0;
    case NTH_CALL_FAIL:
    case NTH_CALL_FAIL_FROM:
      if (number < control->at || (number > control->at && control->mode == NTH_CALL_FAIL))
        return 0;
      control->done++;
      errno = (int)control->error;
      return 1;
  }
  return 0;
}

#define WRAP(kind, result, failed, name, parameters, arguments) \
  result name parameters {                                      \
    static result(*call) parameters;                            \
                                                                \
    if (!call) call = (result(*) parameters)original(#name);    \
    if (hit(kind)) return failed;                               \
    return call arguments;                                      \
  }

#define FILES(name, parameters, arguments) WRAP(NTH_CALL_FILE, int, -1, name, parameters, arguments)
#define BYTES(kind, name, parameters, arguments) \
  WRAP(kind, ssize_t, -1, name, parameters, arguments)
#define SOCKETS(name, parameters, arguments) \
  WRAP(NTH_CALL_SOCKET, int, -1, name, parameters, arguments)

BYTES(NTH_CALL_FILE, read, (int fd, void* at, size_t size), (fd, at, size))
BYTES(NTH_CALL_FILE, write, (int fd, const void* at, size_t size), (fd, at, size))
BYTES(NTH_CALL_FILE, pread, (int fd, void* at, size_t size, off_t from), (fd, at, size, from))
BYTES(NTH_CALL_FILE, pread64, (int fd, void* at, size_t size, off64_t from), (fd, at, size, from))
BYTES(NTH_CALL_FILE, pwrite, (int fd, const void* at, size_t size, off_t to), (fd, at, size, to))
BYTES(NTH_CALL_FILE, pwrite64, (int fd, const void* at, size_t size, off64_t to),
      (fd, at, size, to))
BYTES(NTH_CALL_FILE, writev, (int fd, const struct iovec* parts, int count), (fd, parts, count))
FILES(fsync, (int fd), (fd))
FILES(fdatasync, (int fd), (fd))
FILES(ftruncate, (int fd, off_t size), (fd, size))
FILES(ftruncate64, (int fd, off64_t size), (fd, size))
FILES(rename, (const char* from, const char* to), (from, to))
FILES(renameat, (int a, const char* from, int b, const char* to), (a, from, b, to))
FILES(unlink, (const char* path), (path))
FILES(unlinkat, (int at, const char* path, int flags), (at, path, flags))
FILES(mkdir, (const char* path, mode_t mode), (path, mode))
FILES(rmdir, (const char* path), (path))

SOCKETS(socket, (int domain, int type, int protocol), (domain, type, protocol))
SOCKETS(bind, (int fd, const struct sockaddr* to, socklen_t size), (fd, to, size))
SOCKETS(connect, (int fd, const struct sockaddr* to, socklen_t size), (fd, to, size))
SOCKETS(setsockopt, (int fd, int level, int name, const void* at, socklen_t size),
        (fd, level, name, at, size))
SOCKETS(getsockopt, (int fd, int level, int name, void* at, socklen_t* size),
        (fd, level, name, at, size))
SOCKETS(accept4, (int fd, struct sockaddr* of, socklen_t* size, int flags), (fd, of, size, flags))
BYTES(NTH_CALL_SOCKET, send, (int fd, const void* at, size_t size, int flags),
      (fd, at, size, flags))
BYTES(NTH_CALL_SOCKET, recv, (int fd, void* at, size_t size, int flags), (fd, at, size, flags))
BYTES(NTH_CALL_SOCKET, sendto,
      (int fd, const void* at, size_t size, int flags, const struct sockaddr* to, socklen_t length),
      (fd, at, size, flags, to, length))
BYTES(NTH_CALL_SOCKET, recvfrom,
      (int fd, void* at, size_t size, int flags, struct sockaddr* of, socklen_t* length),
      (fd, at, size, flags, of, length))
BYTES(NTH_CALL_SOCKET, sendmsg, (int fd, const struct msghdr* message, int flags),
      (fd, message, flags))
BYTES(NTH_CALL_SOCKET, recvmsg, (int fd, struct msghdr* message, int flags), (fd, message, flags))

WRAP(NTH_CALL_MEMORY, void*, MAP_FAILED, mmap,
     (void* at, size_t size, int access, int flags, int fd, off_t from),
     (at, size, access, flags, fd, from))
WRAP(NTH_CALL_MEMORY, void*, MAP_FAILED, mmap64,
     (void* at, size_t size, int access, int flags, int fd, off64_t from),
     (at, size, access, flags, fd, from))
WRAP(NTH_CALL_MEMORY, int, -1, munmap, (void* at, size_t size), (at, size))
WRAP(NTH_CALL_DEVICE, int, -1, setns, (int fd, int kind), (fd, kind))

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
    return hit(NTH_CALL_FILE) ? -1 : call(path, flags, mode);          \
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
    return hit(NTH_CALL_FILE) ? -1 : call(at, path, flags, mode);           \
  }
OPENAT(openat)
OPENAT(openat64)

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
