/* SPDX-License-Identifier: BSD-2-Clause */
/* What nth_call.so (LD_PRELOAD) and a test share: a file of this layout, named by NTH_CALL, which
 * both map. The first process that loads the library while `pid` is 0 is the one that it watches.
 * All fields but the last are words of 64 bits: struct.pack("=26Q", ...). What is behind those 26
 * is reported, never read: a file may end before it. */
#ifndef MLCCA_TESTS_FAULT_NTH_CALL_H
#define MLCCA_TESTS_FAULT_NTH_CALL_H
#include <stdint.h>

enum nth_call_mode {
  NTH_CALL_COUNT,    /* count only */
  NTH_CALL_KILL,     /* SIGKILL, in the place of call `at`, or `after_us` later */
  NTH_CALL_FAIL,     /* call `at` fails with `error` */
  NTH_CALL_FAIL_FROM /* call `at` and all behind it fail with `error` */
};

/* In the order of CLASSES in tests/fault/nth-call. */
enum nth_call_class {
  NTH_CALL_NETLINK, /* socket, bind, setsockopt, send*, recv* of AF_NETLINK */
  NTH_CALL_SOCKET,  /* the same of other families; connect, accept4, getsockopt */
  NTH_CALL_BPF,     /* bpf(2) */
  NTH_CALL_MMAP,    /* mmap, munmap */
  NTH_CALL_OPEN,    /* open, openat, opendir, fdopendir */
  NTH_CALL_READ,    /* read, pread */
  NTH_CALL_WRITE,   /* write, pwrite, writev, ftruncate */
  NTH_CALL_SYNC,    /* fsync, fdatasync */
  NTH_CALL_NAME,    /* rename, unlink, remove, mkdir, rmdir */
  NTH_CALL_EPOLL,   /* epoll_*, poll, ppoll */
  NTH_CALL_MEMORY,  /* malloc and its kin */
  NTH_CALL_RANDOM,  /* getrandom */
  NTH_CALL_TIMER,   /* timerfd, eventfd */
  NTH_CALL_DEVICE,  /* ioctl, setns */
  NTH_CALL_STATE,  /* stat, fstat, lstat, access, readlink, readdir, statfs, fstatfs, getsockname */
  NTH_CALL_HANDLE, /* fcntl, flock, dup, signalfd, pipe2, memfd_create, fallocate, chmod, chown */
  NTH_CALL_PROCESS, /* fork, waitpid, kill, prctl */
  NTH_CALL_CLASSES
};

struct nth_call {
  uint64_t pid; /* of the process that is watched */
  uint64_t mode;
  uint64_t at;       /* 1 is the next call, once `calls` is set to 0 */
  uint64_t error;    /* errno */
  uint64_t after_us; /* KILL: so many microseconds after call `at` has begun */
  uint64_t calls;    /* so many calls of `classes` were made */
  uint64_t failed;   /* so many were failed */
  uint64_t classes;  /* bits of 1 << enum nth_call_class: which calls are numbered */
  uint64_t children; /* 1: what the watched process forks or starts is watched, too */
  uint64_t counts[NTH_CALL_CLASSES]; /* of each class, whether numbered or not */
  /* Calls of the watched process itself that may wait without end for another one: on a socket,
   * pipe or terminal, neither with O_NONBLOCK nor with MSG_DONTWAIT. Not counted: netlink, where
   * the kernel answers; files, where the disk does; children that were forked to wait in the place
   * of the process. */
  uint64_t waits;
  char first_wait[1024]; /* "NAME of descriptor N", then a line "FILE+0xOFFSET" for each caller */
};
#endif
