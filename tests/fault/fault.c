// SPDX-License-Identifier: BSD-2-Clause
// Preloaded into a daemon: counts its calls by class, and lets the n-th of one class fail, or all
// from the n-th on.  MLCCA_FAULT=CLASS:N:ERRNO:once|on   MLCCA_FAULT_COUNTS=FILE (32 counters of 64
// bits, mapped, so that they outlive the process; the first one tells how often a call failed).
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <sys/uio.h>
#include <unistd.h>

// In the order of the driver's list.
enum kind {
  HITS,
  NETLINK,
  SOCKET,
  BPF,
  MMAP,
  OPEN,
  WRITE,
  SYNC,
  NAME,
  EPOLL,
  MEMORY,
  RANDOM,
  TIMER,
  KINDS
};
static const char* const kNames[KINDS] = {"hits",   "netlink", "socket", "bpf",  "mmap",
                                          "open",   "write",   "sync",   "name", "epoll",
                                          "memory", "random",  "timer"};

static uint64_t own[KINDS];
static uint64_t* counts = own;
static enum kind chosen = KINDS;
static uint64_t number;
static int error_to_give;
static bool from_then_on;
static bool armed;  // not before this library is ready: the loader allocates, too

static bool fails(enum kind kind) {
  if (!armed) return false;
  const uint64_t n = __atomic_add_fetch(&counts[kind], 1, __ATOMIC_RELAXED);
  if (kind != chosen || (from_then_on ? n < number : n != number)) return false;
  __atomic_add_fetch(&counts[HITS], 1, __ATOMIC_RELAXED);
  errno = error_to_give;
  return true;
}

__attribute__((constructor)) static void prepare(void) {
  const char* file = getenv("MLCCA_FAULT_COUNTS");
  if (file != NULL) {
    const int fd = (int)syscall(SYS_openat, AT_FDCWD, file, O_RDWR | O_CLOEXEC, 0);
    void* shared =
        fd < 0 ? MAP_FAILED : mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (shared != MAP_FAILED) counts = shared;
    if (fd >= 0) close(fd);
  }
  const char* fault = getenv("MLCCA_FAULT");
  if (fault != NULL) {
    const size_t length = strcspn(fault, ":");
    for (int k = 1; k < KINDS; ++k)
      if (strlen(kNames[k]) == length && strncmp(kNames[k], fault, length) == 0)
        chosen = (enum kind)k;
    char* next = NULL;
    if (fault[length] == ':') number = strtoull(fault + length + 1, &next, 10);
    if (next != NULL && *next == ':') error_to_give = (int)strtol(next + 1, &next, 10);
    from_then_on = next != NULL && strcmp(next, ":on") == 0;
  }
  armed = true;
}

#define REAL(name, ...)                                                \
  static __typeof__(name)* real;                                       \
  if (real == NULL) real = (__typeof__(name)*)dlsym(RTLD_NEXT, #name); \
  return real(__VA_ARGS__)
#define FAIL_OR(kind, failed, name, ...) \
  if (fails(kind)) return failed;        \
  REAL(name, __VA_ARGS__)

// --- sockets: those of netlink are a class of their own ------------------------------------------

static uint8_t is_netlink[1024];
static enum kind class_of(int fd) {
  return fd >= 0 && fd < (int)sizeof is_netlink && is_netlink[fd] ? NETLINK : SOCKET;
}
int socket(int domain, int type, int protocol) {
  const enum kind kind = domain == AF_NETLINK ? NETLINK : SOCKET;
  if (fails(kind)) return -1;
  const int fd = (int)syscall(SYS_socket, domain, type, protocol);
  if (fd >= 0 && fd < (int)sizeof is_netlink) is_netlink[fd] = kind == NETLINK;
  return fd;
}
int bind(int fd, const struct sockaddr* a, socklen_t n) {
  FAIL_OR(class_of(fd), -1, bind, fd, a, n);
}
int setsockopt(int fd, int level, int name, const void* value, socklen_t n) {
  FAIL_OR(class_of(fd), -1, setsockopt, fd, level, name, value, n);
}
ssize_t send(int fd, const void* b, size_t n, int f) {
  FAIL_OR(class_of(fd), -1, send, fd, b, n, f);
}
ssize_t sendto(int fd, const void* b, size_t n, int f, const struct sockaddr* a, socklen_t l) {
  FAIL_OR(class_of(fd), -1, sendto, fd, b, n, f, a, l);
}
ssize_t sendmsg(int fd, const struct msghdr* m, int f) {
  FAIL_OR(class_of(fd), -1, sendmsg, fd, m, f);
}
ssize_t recv(int fd, void* b, size_t n, int f) { FAIL_OR(class_of(fd), -1, recv, fd, b, n, f); }
ssize_t recvfrom(int fd, void* b, size_t n, int f, struct sockaddr* a, socklen_t* l) {
  FAIL_OR(class_of(fd), -1, recvfrom, fd, b, n, f, a, l);
}
ssize_t recvmsg(int fd, struct msghdr* m, int f) { FAIL_OR(class_of(fd), -1, recvmsg, fd, m, f); }
int accept4(int fd, struct sockaddr* a, socklen_t* n, int f) {
  FAIL_OR(SOCKET, -1, accept4, fd, a, n, f);
}

// --- bpf(2), which has no name of its own in the C library ---------------------------------------

long syscall(long call, ...) {
  va_list list;
  va_start(list, call);
  const long a = va_arg(list, long), b = va_arg(list, long), c = va_arg(list, long);
  const long d = va_arg(list, long), e = va_arg(list, long), f = va_arg(list, long);
  va_end(list);
  if (call == SYS_bpf && fails(BPF)) return -1;
  static long (*real)(long, ...);
  if (real == NULL) real = (long (*)(long, ...))dlsym(RTLD_NEXT, "syscall");
  return real(call, a, b, c, d, e, f);
}

// --- memory --------------------------------------------------------------------------------------

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);
void* malloc(size_t n) { return fails(MEMORY) ? NULL : __libc_malloc(n); }
void* calloc(size_t n, size_t size) { return fails(MEMORY) ? NULL : __libc_calloc(n, size); }
void* realloc(void* p, size_t n) { return fails(MEMORY) ? NULL : __libc_realloc(p, n); }
void* aligned_alloc(size_t to, size_t n) { return fails(MEMORY) ? NULL : __libc_memalign(to, n); }
void* mmap(void* at, size_t n, int p, int f, int fd, off_t o) {
  if (fails(MMAP)) return MAP_FAILED;
  return (void*)syscall(SYS_mmap, at, n, p, f, fd, o);
}
void* mmap64(void* at, size_t n, int p, int f, int fd, off_t o) { return mmap(at, n, p, f, fd, o); }

// --- files ---------------------------------------------------------------------------------------

static int mode_in(int flags, va_list list) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, int) : 0;
}
#define OPENS(name)                                               \
  int name(const char* path, int flags, ...) {                    \
    va_list list;                                                 \
    va_start(list, flags);                                        \
    const int mode = mode_in(flags, list);                        \
    va_end(list);                                                 \
    if (fails(OPEN)) return -1;                                   \
    return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode); \
  }
OPENS(open)
OPENS(open64)
#define OPENS_AT(name)                                      \
  int name(int at, const char* path, int flags, ...) {      \
    va_list list;                                           \
    va_start(list, flags);                                  \
    const int mode = mode_in(flags, list);                  \
    va_end(list);                                           \
    if (fails(OPEN)) return -1;                             \
    return (int)syscall(SYS_openat, at, path, flags, mode); \
  }
OPENS_AT(openat)
OPENS_AT(openat64)
DIR* opendir(const char* path) { FAIL_OR(OPEN, NULL, opendir, path); }
DIR* fdopendir(int fd) { FAIL_OR(OPEN, NULL, fdopendir, fd); }
ssize_t write(int fd, const void* b, size_t n) { FAIL_OR(WRITE, -1, write, fd, b, n); }
ssize_t pwrite(int fd, const void* b, size_t n, off_t o) {
  FAIL_OR(WRITE, -1, pwrite, fd, b, n, o);
}
ssize_t pwrite64(int fd, const void* b, size_t n, off64_t o) {
  FAIL_OR(WRITE, -1, pwrite64, fd, b, n, o);
}
ssize_t writev(int fd, const struct iovec* v, int n) { FAIL_OR(WRITE, -1, writev, fd, v, n); }
int ftruncate(int fd, off_t n) { FAIL_OR(WRITE, -1, ftruncate, fd, n); }
int fsync(int fd) { FAIL_OR(SYNC, -1, fsync, fd); }
int fdatasync(int fd) { FAIL_OR(SYNC, -1, fdatasync, fd); }
int rename(const char* a, const char* b) { FAIL_OR(NAME, -1, rename, a, b); }
int unlink(const char* path) { FAIL_OR(NAME, -1, unlink, path); }
int unlinkat(int at, const char* path, int f) { FAIL_OR(NAME, -1, unlinkat, at, path, f); }
int remove(const char* path) { FAIL_OR(NAME, -1, remove, path); }
int mkdir(const char* path, mode_t mode) { FAIL_OR(NAME, -1, mkdir, path, mode); }

// --- waiting, clocks, chance ---------------------------------------------------------------------

int epoll_create1(int f) { FAIL_OR(EPOLL, -1, epoll_create1, f); }
int epoll_ctl(int e, int op, int fd, struct epoll_event* v) {
  FAIL_OR(EPOLL, -1, epoll_ctl, e, op, fd, v);
}
int epoll_wait(int e, struct epoll_event* v, int n, int t) {
  FAIL_OR(EPOLL, -1, epoll_wait, e, v, n, t);
}
ssize_t getrandom(void* b, size_t n, unsigned f) { FAIL_OR(RANDOM, -1, getrandom, b, n, f); }
int timerfd_create(clockid_t clock, int f) { FAIL_OR(TIMER, -1, timerfd_create, clock, f); }
int timerfd_settime(int fd, int f, const struct itimerspec* a, struct itimerspec* b) {
  FAIL_OR(TIMER, -1, timerfd_settime, fd, f, a, b);
}
int eventfd(unsigned n, int f) { FAIL_OR(TIMER, -1, eventfd, n, f); }
