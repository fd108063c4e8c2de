// SPDX-License-Identifier: BSD-2-Clause
// LD_PRELOAD: of files whose path ends in FAILING_FILE, each call named FAILING_CALL (open, read or
// write) fails with the errno FAILING_ERRNO, a number; getpwnam_r and getgrnam_r, which have no
// file, do always.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

static int fails(const char* call, const char* path) {
  const char* end = getenv("FAILING_FILE");
  const char* which = getenv("FAILING_CALL");
  const size_t size = strlen(path);

  if (!end || !which || strcmp(which, call) || strlen(end) > size) return 0;
  if (strcmp(path + size - strlen(end), end)) return 0;
  errno = atoi(getenv("FAILING_ERRNO"));
  return 1;
}

static int fails_of(const char* call, int fd) {
  char link[64], path[4096];
  ssize_t size;

  snprintf(link, sizeof(link), "/proc/self/fd/%d", fd);
  size = readlink(link, path, sizeof(path) - 1);
  if (size < 0) return 0;
  path[size] = 0;
  return fails(call, path);
}

#define OPEN(name)                                                \
  int name(const char* path, int flags, ...) {                    \
    va_list more;                                                 \
    mode_t mode;                                                  \
                                                                  \
    va_start(more, flags);                                        \
    mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;            \
    va_end(more);                                                 \
    if (fails("open", path)) return -1;                           \
    return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode); \
  }
OPEN(open)
OPEN(open64)

ssize_t read(int fd, void* to, size_t size) {
  return fails_of("read", fd) ? -1 : syscall(SYS_read, fd, to, size);
}

int getpwnam_r(const char* name, struct passwd* entry, char* buffer, size_t size,
               struct passwd** found) {
  (void)name, (void)entry, (void)buffer, (void)size;
  *found = NULL;
  return fails("getpwnam_r", "") ? errno : 0;
}

int getgrnam_r(const char* name, struct group* entry, char* buffer, size_t size,
               struct group** found) {
  static int (*real)(const char*, struct group*, char*, size_t, struct group**);

  *found = NULL;
  if (fails("getgrnam_r", "")) return errno;
  if (!real) real = dlsym(RTLD_NEXT, "getgrnam_r");
  return real(name, entry, buffer, size, found);
}

#define PREAD(name)                                                              \
  ssize_t name(int fd, void* to, size_t size, off_t from) {                      \
    return fails_of("read", fd) ? -1 : syscall(SYS_pread64, fd, to, size, from); \
  }
PREAD(pread)
PREAD(pread64)

#define PWRITE(name)                                                               \
  ssize_t name(int fd, const void* from, size_t size, off_t to) {                  \
    return fails_of("write", fd) ? -1 : syscall(SYS_pwrite64, fd, from, size, to); \
  }
PWRITE(pwrite)
PWRITE(pwrite64)
