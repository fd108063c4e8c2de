// SPDX-License-Identifier: BSD-2-Clause
// LD_PRELOAD: of the calls that give types to the kernel (BPF_BTF_LOAD), the one whose number is
// FAILING_TYPES fails once with ENOMEM, and says so.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <linux/bpf.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

long syscall(long number, ...) {
  static const char said[] = "types failed\n";
  static long (*real)(long, ...);
  static int calls;
  long arguments[6];
  va_list more;

  va_start(more, number);
  for (int i = 0; i < 6; i++) arguments[i] = va_arg(more, long);
  va_end(more);
  if (number == SYS_bpf && arguments[0] == BPF_BTF_LOAD &&
      ++calls == atoi(getenv("FAILING_TYPES"))) {
    if (write(STDERR_FILENO, said, sizeof(said) - 1) < 0) abort();
    errno = ENOMEM;
    return -1;
  }
  if (!real) real = dlsym(RTLD_NEXT, "syscall");
  return real(number, arguments[0], arguments[1], arguments[2], arguments[3], arguments[4],
              arguments[5]);
}
