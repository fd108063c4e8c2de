// SPDX-License-Identifier: BSD-2-Clause
#include "tools/sources/sandbox.hpp"

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
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "daemon/net/sources/timer.hpp"

namespace mlcca::sources {
namespace {

using net::error_words;

// A sanitizer maps terabytes and makes system calls of its own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

constexpr rlim_t kMemory = rlim_t{256} << 20U;  // bytes of address space
constexpr rlim_t kDescriptors = 16;

Result<void> limit(__rlimit_resource what, rlim_t most) {
  const rlimit both{.rlim_cur = most, .rlim_max = most};
  if (::setrlimit(what, &both) < 0) return fail(error_words("setrlimit", errno));
  return {};
}

Result<void> limit_resources() {
  for (const auto& [what, most] :
       {std::pair{RLIMIT_NOFILE, kDescriptors}, std::pair{RLIMIT_CORE, rlim_t{0}},
        std::pair{RLIMIT_MEMLOCK, rlim_t{0}}})
    if (auto limited = limit(what, most); !limited) return limited;
  return kSanitized ? Result<void>{} : limit(RLIMIT_AS, kMemory);
}

/// All of them. Those that may never be had again go first, as far as they are there to be given
/// up.
Result<void> drop_capabilities() {
  for (unsigned long c = 0; ::prctl(PR_CAPBSET_READ, c) >= 0; ++c) ::prctl(PR_CAPBSET_DROP, c);
  ::prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
  __user_cap_header_struct header{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  const std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> none{};
  if (::syscall(SYS_capset, &header, none.data()) < 0)
    return fail(error_words("giving up capabilities", errno));
  return {};
}

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#elif defined(__riscv)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_RISCV64;
#else
#error "state the architecture and look through the system calls below"
#endif

/// Whatever their arguments.
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

class Filter {
 public:
  Filter() {
    load(offsetof(seccomp_data, arch));
    add(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0);
    add(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS);
    load(offsetof(seccomp_data, nr));
  }
  void allow(long call) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 1);
    add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  }
  /// If no bit of `mask` is set in this argument.
  void allow_without(long call, unsigned argument, std::uint32_t mask) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4);
    load_argument(argument);
    add(BPF_JMP | BPF_JSET | BPF_K, mask, 1, 0);
    add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    refuse();
  }
  /// If its first argument is this.
  void allow_with(long call, std::uint32_t value) {
    add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4);
    load_argument(0);
    add(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
    add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    load(offsetof(seccomp_data, nr));
  }
  Result<void> install() {
    refuse();
    const sock_fprog program{.len = static_cast<unsigned short>(steps_.size()),
                             .filter = steps_.data()};
    if (::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) < 0)
      return fail(error_words("seccomp", errno));
    return {};
  }

 private:
  void add(std::uint16_t code, std::uint32_t k, std::uint8_t yes = 0, std::uint8_t no = 0) {
    steps_.push_back({.code = code, .jt = yes, .jf = no, .k = k});
  }
  void load(std::size_t offset) {
    add(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
  }
  /// Its lower half: all arguments that are compared are ints.
  void load_argument(unsigned number) {
    load(offsetof(seccomp_data, args) + std::size_t{number} * sizeof(std::uint64_t));
  }
  void refuse() { add(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM); }

  std::vector<sock_filter> steps_;
};

Result<void> filter_system_calls() {
  Filter filter;
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
  if (::close_range(3, ~0U, 0) < 0) return fail(error_words("closing descriptors", errno));
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) < 0 || ::prctl(PR_SET_DUMPABLE, 0) < 0)
    return fail(error_words("prctl", errno));
  if (auto limited = limit_resources(); !limited) return limited;
  if (auto dropped = drop_capabilities(); !dropped) return dropped;
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) < 0)
    return fail(error_words("no new privileges", errno));
  return kSanitized ? Result<void>{} : filter_system_calls();
}

}  // namespace mlcca::sources
