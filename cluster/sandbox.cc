// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/sandbox.hpp"

#include <sched.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>

#include <array>

#include "base/sandbox.hpp"

namespace mlcca::cluster {
namespace {

constexpr SandboxLimits kLimits{.memory = rlim_t{512} << 20U, .descriptors = 64};

/// System calls that are allowed with any arguments, beside kUsualCalls.
constexpr std::array kMoreCalls{
    SYS_sendmmsg,
    SYS_bind,
    SYS_accept4,
    SYS_shutdown,
    SYS_setsockopt,
    SYS_socketpair,
    SYS_signalfd4,
    SYS_rt_sigaction,
    SYS_uname,
    // Calls that every thread makes when it starts.
    SYS_set_robust_list,
    SYS_sched_getaffinity,
    SYS_prlimit64,
#ifdef SYS_rseq
    SYS_rseq,
#endif
};

Result<void> filter_calls() {
  SystemCallFilter filter;
  filter.allow_usual();
  for (const long call : kMoreCalls) filter.allow(call);
  filter.allow_with(SYS_ioctl, FIONREAD, 1);
  // A filter cannot read the flags of clone3, which are in memory; the C library then uses clone.
  filter.hide(SYS_clone3);
  filter.allow_having(SYS_clone, 0, CLONE_THREAD);
  return filter.install();
}

}  // namespace

Result<void> enter_sandbox() {
  if (auto done = give_up_privileges(kLimits); !done) return done;
  return kSanitized ? Result<void>{} : filter_calls();
}

}  // namespace mlcca::cluster
