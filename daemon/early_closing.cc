// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/early_closing.hpp"

#include <net/if.h>
#include <sys/fsuid.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <optional>
#include <sstream>
#include <string>

#include "daemon/gates/interfaces.hpp"
#include "daemon/manager.hpp"

namespace mlcca {
namespace {

constexpr int kFailed = 1;
constexpr int kTries = 3;
constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 250'000'000};

/// What root pins here must be the service user's: it is the owner of the bpffs.
void pin_as_owner_of(const std::string& root) {
  struct stat owner{};
  if (::geteuid() != 0 || ::stat(root.c_str(), &owner) < 0) return;
  ::setfsgid(owner.st_gid);
  ::setfsuid(owner.st_uid);
}

/// The next one is closed also where nobody reads what is said of this one.
void say(const std::string& name, const std::string& text) {
  write_at_once(STDERR_FILENO, name + ": " + text + '\n');
}

/// False: it may be open.
bool close_one(const std::string& name, const std::string& root) {
  if (::if_nametoindex(name.c_str()) == 0) {
    if (errno == ENODEV) {
      say(name, "not there yet; the udev rule closes it when it appears");
      return true;
    }
    say(name, std::string("cannot be asked for: ") +
                  std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
    return false;
  }
  const auto done = enforce::close_interface(name, root);
  if (!done) {
    say(name, done.error().text);
    return false;
  }
  say(name, *done == enforce::Closing::closed ? "closed" : "has a gate already, left as it is");
  return true;
}

/// What udev has read from gate.conf is one text.
bool is_meant(const std::string& name, const std::optional<std::string>& among) {
  if (!among) return true;
  std::istringstream list(*among);
  for (std::string one; list >> one;)
    if (one == name) return true;
  return false;
}

int close_all(const Options& options) {
  int status = 0;
  pin_as_owner_of(options.bpf_root);
  for (const std::string& name : options.close)
    if (!name.empty() && is_meant(name, options.among) && !close_one(name, options.bpf_root))
      status = kFailed;
  return status;
}

/// In a process of its own: libbpf keeps for the life of a process that a probe of the kernel has
/// failed once.
int close_all_apart(const Options& options) {
  const pid_t child = ::fork();
  if (child < 0) return close_all(options);
  if (child == 0) std::_Exit(close_all(options));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return kFailed;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kFailed;
}

}  // namespace

int close_early(const Options& options) {
  for (int tries = 1;; ++tries) {
    const int status = close_all_apart(options);
    if (status == 0 || tries == kTries) return status;
    ::nanosleep(&kPause, nullptr);
  }
}

}  // namespace mlcca
