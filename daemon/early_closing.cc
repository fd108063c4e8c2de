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
#include <string>
#include <vector>

#include "base/at_once.hpp"
#include "base/standard_streams.hpp"
#include "daemon/gates/interfaces.hpp"
#include "daemon/interface_files.hpp"

namespace mlcca {
namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr int kTries = 3;
constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 250'000'000};

/// Acts as the owner of the bpffs, the user of the service, so that pins that root makes here
/// belong to it.
void pin_as_owner_of(const std::string& root) {
  struct stat owner{};
  if (::geteuid() != 0 || ::stat(root.c_str(), &owner) < 0) return;
  ::setfsgid(owner.st_gid);
  ::setfsuid(owner.st_uid);
}

/// Reports without waiting for a reader, so that the next interface is closed in any case.
void say(const std::string& name, const std::string& text) {
  write_at_once(STDERR_FILENO, name + ": " + text + '\n');
}

/// False if the interface may be open.
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
  const auto done = gates::close_interface(name, root);
  if (!done) {
    say(name, done.error().text);
    return false;
  }
  say(name, *done == gates::Closing::closed ? "closed" : "has a gate already, left as it is");
  return true;
}

int close_all(const std::vector<std::string>& names, const std::string& root) {
  int status = 0;
  pin_as_owner_of(root);
  for (const std::string& name : names)
    if (!close_one(name, root)) status = kFailed;
  return status;
}

/// Runs in a child process, because libbpf keeps the failure of a probe of the kernel for the life
/// of a process.
int close_all_apart(const std::vector<std::string>& names, const std::string& root) {
  const pid_t child = ::fork();
  if (child < 0) return close_all(names, root);
  if (child == 0) std::_Exit(close_all(names, root));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return kFailed;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kFailed;
}

int close_with_patience(const std::vector<std::string>& names, const std::string& root) {
  for (int tries = 1;; ++tries) {
    const int status = close_all_apart(names, root);
    if (status == 0 || tries == kTries) return status;
    ::nanosleep(&kPause, nullptr);
  }
}

/// The interfaces to close. If a file has a mistake, it is not known which ones it names; then all
/// requested ones are closed.
std::vector<std::string> meant(const Options& options, const InterfaceFiles& files) {
  std::vector<std::string> names = options.close;
  if (!options.named_in) return names;
  if (names.empty())
    for (const auto& one : files.named) names.push_back(one.name);
  else if (files.mistakes.empty())
    std::erase_if(names, [&files](const std::string& name) { return !files.names(name); });
  return names;
}

}  // namespace

int close_early(const Options& options) {
  InterfaceFiles files;
  if (options.named_in) files = read_interface_files(*options.named_in);
  for (const std::string& mistake : files.mistakes) write_at_once(STDERR_FILENO, mistake + '\n');
  const int wrong = files.mistakes.empty() ? 0 : kBadInput;
  if (options.check_only) {
    std::string lines;
    for (const auto& one : files.named) lines += one.place + ": " + one.name + '\n';
    return printed("mlccad", lines) ? wrong : kFailed;
  }
  const int status = close_with_patience(meant(options, files), options.bpf_root);
  return status != 0 ? status : wrong;
}

}  // namespace mlcca
