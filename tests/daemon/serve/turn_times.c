// SPDX-License-Identifier: BSD-2-Clause
// Preloaded into a daemon: how much processor time its loop takes between two waits, and between
// two heart-beats or waits, whatever else runs on the machine.  MLCCA_TURN_TIMES=FILE, mapped:
// 64-bit numbers in the order of `struct turns`.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <linux/bpf.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

enum { BUCKETS = 512, BUCKET_NS = 100000 };
struct turns {
  uint64_t longest;             // ns
  uint64_t longest_by_clock;    // ns, with what the processor did for others meanwhile
  uint64_t longest_silent;      // ns without a heart-beat
  uint64_t of_bucket[BUCKETS];  // turns by their length; the last one has all that are longer
};
static struct turns* turns;
static uint64_t began;
static uint64_t began_by_clock;
static uint64_t beaten;

static uint64_t now(clockid_t clock) {
  struct timespec t;
  clock_gettime(clock, &t);
  return (uint64_t)t.tv_sec * 1000000000 + (uint64_t)t.tv_nsec;
}

__attribute__((constructor)) static void open_counts(void) {
  const char* const path = getenv("MLCCA_TURN_TIMES");
  const int fd = path != NULL ? open(path, O_RDWR | O_CLOEXEC) : -1;
  if (fd < 0) return;
  void* const mapped = mmap(NULL, sizeof *turns, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  if (mapped != MAP_FAILED) turns = mapped;
}

static void begin_turn(void) {
  beaten = began = now(CLOCK_THREAD_CPUTIME_ID);
  began_by_clock = now(CLOCK_MONOTONIC);
}

static void end_silence(uint64_t at) {
  if (at - beaten > turns->longest_silent) turns->longest_silent = at - beaten;
  beaten = at;
}

static int is_loop(void) { return turns != NULL && began != 0 && getpid() == gettid(); }

/// Only the loop waits in epoll, and it is the first thread.
static void end_turn(void) {
  if (!is_loop()) return;
  const uint64_t at = now(CLOCK_THREAD_CPUTIME_ID);
  end_silence(at);
  const uint64_t length = at - began;
  const uint64_t by_clock = now(CLOCK_MONOTONIC) - began_by_clock;
  const uint64_t bucket = length / BUCKET_NS;
  turns->of_bucket[bucket < BUCKETS ? bucket : BUCKETS - 1]++;
  if (length > turns->longest) turns->longest = length;
  if (by_clock > turns->longest_by_clock) turns->longest_by_clock = by_clock;
}

int epoll_wait(int fd, struct epoll_event* events, int most, int timeout) {
  end_turn();
  int (*const real)(int, struct epoll_event*, int, int) = dlsym(RTLD_NEXT, "epoll_wait");
  const int found = real(fd, events, most, timeout);
  begin_turn();
  return found;
}

int epoll_pwait2(int fd, struct epoll_event* events, int most, const struct timespec* timeout,
                 const sigset_t* mask) {
  end_turn();
  int (*const real)(int, struct epoll_event*, int, const struct timespec*, const sigset_t*) =
      dlsym(RTLD_NEXT, "epoll_pwait2");
  const int found = real(fd, events, most, timeout, mask);
  begin_turn();
  return found;
}

/// A heart-beat is a run of a program. So is the start of a timer, which comes with others like it.
long syscall(long number, ...) {
  long (*const real)(long, ...) = dlsym(RTLD_NEXT, "syscall");
  long a[6];
  va_list more;
  va_start(more, number);
  for (int i = 0; i < 6; i++) a[i] = va_arg(more, long);
  va_end(more);
  if (number == SYS_bpf && a[0] == BPF_PROG_TEST_RUN && is_loop())
    end_silence(now(CLOCK_THREAD_CPUTIME_ID));
  return real(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}
