// SPDX-License-Identifier: BSD-2-Clause
#include "tools/sources/sandbox.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <utility>

#include "base/sandbox.hpp"
#include "base/system_error.hpp"

namespace mlcca::sources {
namespace {

constexpr rlim_t kMemory = rlim_t{256} << 20U;  // bytes of address space
constexpr rlim_t kDescriptors = 16;

Result<void> limit_resources() {
  for (const auto& [what, most] :
       {std::pair{RLIMIT_NOFILE, kDescriptors}, std::pair{RLIMIT_CORE, rlim_t{0}},
        std::pair{RLIMIT_MEMLOCK, rlim_t{0}}})
    if (auto limited = limit_resource(what, most); !limited) return limited;
  return kSanitized ? Result<void>{} : limit_resource(RLIMIT_AS, kMemory);
}

/// System calls that are allowed with any arguments.
constexpr std::array kAllowed{
    SYS_read,
    SYS_write,
    SYS_writev,
    SYS_close,
    SYS_recvfrom,
    SYS_recvmsg,
    SYS_sendto,
    SYS_sendmsg,
    SYS_connect,
    SYS_getsockopt,
    SYS_getsockname,
    SYS_getpeername,
    SYS_epoll_create1,
    SYS_epoll_ctl,
    SYS_epoll_pwait,
    SYS_timerfd_create,
    SYS_timerfd_settime,
    SYS_timerfd_gettime,
    SYS_clock_gettime,
    SYS_gettimeofday,
    SYS_fstat,
    SYS_newfstatat,
    SYS_statx,
    SYS_lseek,
    SYS_inotify_init1,
    SYS_inotify_add_watch,
    SYS_inotify_rm_watch,
    SYS_munmap,
    SYS_mremap,
    SYS_brk,
    SYS_madvise,
    SYS_futex,
    SYS_rt_sigprocmask,
    SYS_rt_sigreturn,
    SYS_exit,
    SYS_exit_group,
    SYS_getrandom,
    SYS_getpid,
    SYS_gettid,
    SYS_getuid,
    SYS_geteuid,
    SYS_restart_syscall,
    SYS_fcntl,
    SYS_ppoll,
    SYS_clock_nanosleep,
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

Result<void> filter_system_calls() {
  SystemCallFilter filter;
  for (const long call : kAllowed) filter.allow(call);
  for (const int family : {AF_UNIX, AF_INET, AF_INET6})
    filter.allow_with(SYS_socket, static_cast<std::uint32_t>(family));
  filter.allow_without(SYS_openat, 2, O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND);
  filter.allow_without(SYS_mmap, 2, PROT_EXEC);
  filter.allow_without(SYS_mprotect, 2, PROT_EXEC);
  return filter.install();
}

}  // namespace

Result<void> enter_sandbox() {
  if (::close_range(3, ~0U, 0) < 0) return system_error("closing descriptors");
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) < 0 || ::prctl(PR_SET_DUMPABLE, 0) < 0)
    return system_error("prctl");
  if (auto limited = limit_resources(); !limited) return limited;
  if (auto dropped = drop_capabilities(); !dropped) return dropped;
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) < 0) return system_error("no new privileges");
  return kSanitized ? Result<void>{} : filter_system_calls();
}

}  // namespace mlcca::sources
