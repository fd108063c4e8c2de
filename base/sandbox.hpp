// SPDX-License-Identifier: BSD-2-Clause
// Parts of a sandbox: what a process gives up for good before it reads untrusted input.
#pragma once
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/result.hpp"
#include "base/system_error.hpp"

namespace mlcca {

/// Whether this is a build with a sanitizer, which maps terabytes and makes system calls of its
/// own: no limit of memory and no filter of system calls is possible then.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

namespace detail {

#if defined(__x86_64__)
inline constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
inline constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#elif defined(__riscv)
inline constexpr std::uint32_t kArchitecture = AUDIT_ARCH_RISCV64;
#else
#error "state the architecture and look through the system calls below"
#endif

}  // namespace detail

/// Sets the soft and the hard limit of a resource to `most`.
inline Result<void> limit_resource(__rlimit_resource what, rlim_t most) {
  const rlimit both{.rlim_cur = most, .rlim_max = most};
  if (::setrlimit(what, &both) < 0) return system_error("setrlimit");
  return {};
}

/// Gives up all capabilities, the bounding and the ambient set included. Clearing those two is not
/// an error where the process may not do it: without a permitted capability they give nothing.
inline Result<void> drop_capabilities() {
  for (unsigned long c = 0; ::prctl(PR_CAPBSET_READ, c) >= 0; ++c) ::prctl(PR_CAPBSET_DROP, c);
  ::prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
  __user_cap_header_struct header{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  const std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> none{};
  if (::syscall(SYS_capset, &header, none.data()) < 0)
    return system_error("giving up capabilities");
  return {};
}

/// The most that a process may take.
struct SandboxLimits {
  rlim_t memory = 0;       ///< bytes of address space, including the stacks of threads
  rlim_t descriptors = 0;  ///< open at the same time
};

/// Gives up for good what nobody needs who only reads and computes: capabilities, new privileges,
/// core dumps, locked memory, and more than `limits`. Nobody can trace the process any more.
inline Result<void> give_up_privileges(const SandboxLimits& limits) {
  if (::prctl(PR_SET_DUMPABLE, 0) < 0) return system_error("prctl");  // NOLINT(*-vararg)
  if (auto done = limit_resource(RLIMIT_NOFILE, limits.descriptors); !done) return done;
  if (auto done = limit_resource(RLIMIT_CORE, 0); !done) return done;
  if (auto done = limit_resource(RLIMIT_MEMLOCK, 0); !done) return done;
  if constexpr (!kSanitized)
    if (auto done = limit_resource(RLIMIT_AS, limits.memory); !done) return done;
  if (auto dropped = drop_capabilities(); !dropped) return dropped;
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) < 0)  // NOLINT(*-vararg)
    return system_error("no new privileges");
  return {};
}

/// System calls that every program needs which reads from sockets, with any arguments.
inline constexpr std::array kUsualCalls{
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

/// A seccomp filter (seccomp(2)) that permits the system calls that were allowed; all others fail
/// with EPERM, and those of another architecture kill the process. allow_with() can be repeated for
/// one call; after allow_with(), one of the other functions may follow for it, and nothing after
/// that.
class SystemCallFilter {
 public:
  SystemCallFilter() {
    load(offsetof(seccomp_data, arch));
    add(BPF_JMP | BPF_JEQ | BPF_K, detail::kArchitecture, 1, 0);
    add(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS);
    load(offsetof(seccomp_data, nr));
  }
  /// Allows the call with any arguments.
  void allow(long call) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 1);
    add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  }
  /// Allows the call if no bit of `mask` is set in the lower 32 bits of argument `argument` (from
  /// 0).
  void allow_without(long call, unsigned argument, std::uint32_t mask) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4);
    load_argument(argument);
    add(BPF_JMP | BPF_JSET | BPF_K, mask, 1, 0);
    add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    refuse();
  }
  /// Allows the call if a bit of `mask` is set in the lower 32 bits of argument `argument` (from
  /// 0).
  void allow_having(long call, unsigned argument, std::uint32_t mask) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4);
    load_argument(argument);
    add(BPF_JMP | BPF_JSET | BPF_K, mask, 0, 1);
    add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    refuse();
  }
  /// Makes the call fail with ENOSYS, as if the kernel did not have it, so that a library uses an
  /// older call instead.
  void hide(long call) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 1);
    add(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS);
  }
  /// Allows the call if the lower 32 bits of argument `argument` (from 0) equal `value`.
  void allow_with(long call, std::uint32_t value, unsigned argument = 0) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4);
    load_argument(argument);
    add(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
    add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    load(offsetof(seccomp_data, nr));
  }
  /// Allows kUsualCalls, sockets of this host and of IP, to open files for reading, and memory that
  /// is not executable.
  void allow_usual() {
    for (const long call : kUsualCalls) allow(call);
    for (const int family : {AF_UNIX, AF_INET, AF_INET6})
      allow_with(SYS_socket, static_cast<std::uint32_t>(family));
    allow_without(SYS_openat, 2, O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND);
    allow_without(SYS_mmap, 2, PROT_EXEC);
    allow_without(SYS_mprotect, 2, PROT_EXEC);
  }
  /// Puts the filter in force for this thread and those that it starts. The process must have set
  /// PR_SET_NO_NEW_PRIVS.
  Result<void> install() {
    refuse();
    const sock_fprog program{.len = static_cast<unsigned short>(steps_.size()),
                             .filter = steps_.data()};
    if (::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) < 0) return system_error("seccomp");
    return {};
  }

 private:
  void add(std::uint16_t code, std::uint32_t k, std::uint8_t yes = 0, std::uint8_t no = 0) {
    steps_.push_back({.code = code, .jt = yes, .jf = no, .k = k});
  }
  void load(std::size_t offset) {
    add(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
  }
  /// Loads the lower half of an argument: all arguments that are compared are of type int.
  /// Little-endian machines only.
  void load_argument(unsigned number) {
    load(offsetof(seccomp_data, args) + std::size_t{number} * sizeof(std::uint64_t));
  }
  void refuse() { add(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM); }

  std::vector<sock_filter> steps_;
};

}  // namespace mlcca
