// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/sandbox.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>

#include <array>
#include <utility>

#include "base/sandbox.hpp"
#include "base/system_error.hpp"

namespace mlcca::cluster {
namespace {

constexpr rlim_t kMemory = rlim_t{512} << 20U;  // bytes of address space, including the stacks of
                                                // threads
constexpr rlim_t kDescriptors = 64;

Result<void> limit_resources() {
  for (const auto& [what, most] :
       {std::pair{RLIMIT_NOFILE, kDescriptors}, std::pair{RLIMIT_CORE, rlim_t{0}},
        std::pair{RLIMIT_MEMLOCK, rlim_t{0}}})
    if (auto limited = limit_resource(what, most); !limited) return limited;
  return kSanitized ? Result<void>{} : limit_resource(RLIMIT_AS, kMemory);
}

/// System calls that are allowed with any arguments.
constexpr std::array kAllowedCalls{
    SYS_read,
    SYS_write,
    SYS_writev,
    SYS_close,
    SYS_recvfrom,
    SYS_recvmsg,
    SYS_sendto,
    SYS_sendmsg,
    SYS_sendmmsg,
    SYS_connect,
    SYS_bind,
    SYS_accept4,
    SYS_shutdown,
    SYS_getsockopt,
    SYS_setsockopt,
    SYS_getsockname,
    SYS_getpeername,
    SYS_socketpair,
    SYS_epoll_create1,
    SYS_epoll_ctl,
    SYS_epoll_pwait,
    SYS_timerfd_create,
    SYS_timerfd_settime,
    SYS_timerfd_gettime,
    SYS_signalfd4,
    SYS_clock_gettime,
    SYS_gettimeofday,
    SYS_fstat,
    SYS_newfstatat,
    SYS_statx,
    SYS_lseek,
    SYS_munmap,
    SYS_mremap,
    SYS_brk,
    SYS_madvise,
    SYS_futex,
    SYS_rt_sigprocmask,
    SYS_rt_sigaction,
    SYS_rt_sigreturn,
    SYS_exit,
    SYS_exit_group,
    SYS_getrandom,
    SYS_getpid,
    SYS_gettid,
    SYS_getuid,
    SYS_geteuid,
    SYS_uname,
    SYS_restart_syscall,
    SYS_fcntl,
    SYS_ppoll,
    SYS_clock_nanosleep,
    // Calls that every thread makes when it starts.
    SYS_set_robust_list,
    SYS_sched_getaffinity,
    SYS_prlimit64,
#ifdef SYS_rseq
    SYS_rseq,
#endif
#ifdef SYS_epoll_pwait2
    SYS_epoll_pwait2,
#endif
#ifdef __x86_64__
    SYS_epoll_wait,
    SYS_poll,
    SYS_stat,
    SYS_lstat,
    SYS_time,
#endif
};

Result<void> filter_calls() {
  SystemCallFilter filter;
  for (const long call : kAllowedCalls) filter.allow(call);
  for (const int family : {AF_UNIX, AF_INET, AF_INET6})
    filter.allow_with(SYS_socket, static_cast<std::uint32_t>(family));
  filter.allow_without(SYS_openat, 2, O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND);
  filter.allow_without(SYS_mmap, 2, PROT_EXEC);
  filter.allow_without(SYS_mprotect, 2, PROT_EXEC);
  filter.allow_with(SYS_ioctl, FIONREAD, 1);
  // A filter cannot read the flags of clone3, which are in memory; the C library then uses clone.
  filter.hide(SYS_clone3);
  filter.allow_having(SYS_clone, 0, CLONE_THREAD);
  return filter.install();
}

}  // namespace

Result<void> enter_sandbox() {
  if (::prctl(PR_SET_DUMPABLE, 0) < 0) return system_error("prctl");  // NOLINT(*-vararg)
  if (auto limited = limit_resources(); !limited) return limited;
  if (auto dropped = drop_capabilities(); !dropped) return dropped;
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) < 0)  // NOLINT(*-vararg)
    return system_error("no new privileges");
  return kSanitized ? Result<void>{} : filter_calls();
}

}  // namespace mlcca::cluster
