/* SPDX-License-Identifier: BSD-2-Clause */
/* What nth_call.so (LD_PRELOAD) and a test share: a file of this layout, named by NTH_CALL, which
 * both map. The first process that loads the library with an empty `pid` is the one that it
 * watches; its children are left alone. All fields are little-endian words of 64 bits:
 * struct.pack("=8Q", ...). */
#ifndef MLCCA_TESTS_FAULT_NTH_CALL_H
#define MLCCA_TESTS_FAULT_NTH_CALL_H
#include <stdint.h>

enum nth_call_mode {
  NTH_CALL_COUNT,    /* count only */
  NTH_CALL_KILL,     /* SIGKILL, in the place of call `at`, or `after_us` later */
  NTH_CALL_FAIL,     /* call `at` fails with `error` */
  NTH_CALL_FAIL_FROM /* call `at` and all behind it fail with `error` */
};

struct nth_call {
  uint64_t pid; /* of the process that is watched */
  uint64_t mode;
  uint64_t at;       /* 1 is the next call, once `calls` is set to 0 */
  uint64_t error;    /* errno */
  uint64_t after_us; /* KILL: so many microseconds after call `at` has begun */
  uint64_t calls;    /* so many were made */
  uint64_t done;     /* so many were failed */
  uint64_t kinds;    /* bits of enum nth_call_kind: which calls count; 0 is all */
};

enum nth_call_kind {
  NTH_CALL_BPF = 1,    /* syscall(2): bpf(2) of libbpf, perf, getrandom */
  NTH_CALL_SOCKET = 2, /* socket, bind, connect, send*, recv*, *sockopt */
  NTH_CALL_FILE = 4,   /* open, read, write, fsync, rename, unlink, mkdir, truncate */
  NTH_CALL_MEMORY = 8, /* mmap, munmap */
  NTH_CALL_DEVICE = 16 /* ioctl, setns, epoll */
};
#endif
