// SPDX-License-Identifier: BSD-2-Clause
#include "tools/sources/sandbox.hpp"

#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>

#include "base/sandbox.hpp"
#include "base/system_error.hpp"

namespace mlcca::sources {
namespace {

constexpr SandboxLimits kLimits{.memory = rlim_t{256} << 20U, .descriptors = 16};

Result<void> filter_system_calls() {
  SystemCallFilter filter;
  filter.allow_usual();
  for (const long call : {SYS_inotify_init1, SYS_inotify_add_watch, SYS_inotify_rm_watch})
    filter.allow(call);
  return filter.install();
}

}  // namespace

Result<void> enter_sandbox() {
  if (::close_range(3, ~0U, 0) < 0) return system_error("closing descriptors");
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) < 0) return system_error("prctl");
  if (auto done = give_up_privileges(kLimits); !done) return done;
  return kSanitized ? Result<void>{} : filter_system_calls();
}

}  // namespace mlcca::sources
