// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/process.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <systemd/sd-login.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "base/handle.hpp"

namespace mlcca::serve {
namespace {

std::vector<gid_t> groups_of(int fd, gid_t primary) {
  std::vector<gid_t> groups(64);
  auto size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
  int error = ::getsockopt(fd, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) < 0 ? errno : 0;
  if (error == ERANGE) {
    groups.resize(size / sizeof(gid_t));
    error = ::getsockopt(fd, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) < 0 ? errno : 0;
  }
  groups.resize(error == 0 ? size / sizeof(gid_t) : 0);
  groups.push_back(primary);
  return groups;
}

class Connected final : public Process {
 public:
  Connected(pid_t pid, Fd process, std::vector<gid_t> groups)
      : pid_(pid), process_(std::move(process)), groups_(std::move(groups)) {}

  [[nodiscard]] bool is_in(gid_t group) const override {
    return std::ranges::find(groups_, group) != groups_.end();
  }
  [[nodiscard]] Result<std::string> unit() const override {
    if (!lives()) return fail("the process that connected has ended");
    char* name = nullptr;
    const int error = ::sd_pid_get_unit(pid_, &name);
    const std::unique_ptr<char, decltype(&std::free)> owned(name, std::free);
    // What was read belongs to this process only if it has not ended meanwhile.
    if (!lives()) return fail("the process that connected has ended");
    if (error == -ENODATA) return std::string();
    if (error < 0)
      return fail(std::string("the unit of the process: ") +
                  std::strerror(-error));  // NOLINT(concurrency-mt-unsafe)
    return std::string(owned.get());
  }

 private:
  [[nodiscard]] bool lives() const {
    if (!process_) return false;
    pollfd ended{.fd = process_.get(), .events = POLLIN, .revents = 0};
    return ::poll(&ended, 1, 0) == 0;
  }

  pid_t pid_;
  Fd process_;  ///< pidfd
  std::vector<gid_t> groups_;
};

}  // namespace

std::shared_ptr<const Process> process_of(int fd, pid_t pid, gid_t primary) {
  Fd process(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
  return std::make_shared<Connected>(pid, std::move(process), groups_of(fd, primary));
}

}  // namespace mlcca::serve
