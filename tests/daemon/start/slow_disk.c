// SPDX-License-Identifier: BSD-2-Clause
// LD_PRELOAD: a disk that takes nothing as long as the file SLOW_DISK is there.
#define _GNU_SOURCE
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

int fdatasync(int fd) {
  const char* file = getenv("SLOW_DISK");

  while (file && access(file, F_OK) == 0) usleep(1000);
  return (int)syscall(SYS_fdatasync, fd);
}
