// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/child.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <string_view>
#include <vector>

#include "base/system_error.hpp"
#include "base/unix_address.hpp"

namespace mlcca::net {
namespace {

/// The children that were killed, and not waited for yet.
std::vector<pid_t>& ended() {
  static std::vector<pid_t> all;
  return all;
}

/// The environment of a child: it finds signals and descriptors as it would when started from a
/// shell.
class StartAs {
 public:
  explicit StartAs(int input) {
    posix_spawn_file_actions_init(&files_);
    posix_spawn_file_actions_adddup2(&files_, input, STDIN_FILENO);
    posix_spawnattr_init(&attributes_);
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  StartAs(const StartAs&) = delete;
  StartAs& operator=(const StartAs&) = delete;
  ~StartAs() {
    posix_spawn_file_actions_destroy(&files_);
    posix_spawnattr_destroy(&attributes_);
  }
  /// 0 or an errno.
  int start(const std::string& program, pid_t& pid) const {
    std::string name = program;
    std::array<char*, 2> arguments{name.data(), nullptr};
    std::array<char*, 1> environment{nullptr};
    return posix_spawn(&pid, program.c_str(), &files_, &attributes_, arguments.data(),
                       environment.data());
  }

 private:
  posix_spawn_file_actions_t files_{};
  posix_spawnattr_t attributes_{};
};

}  // namespace

void Child::end() {
  if (pid_ == 0) return;
  ::kill(pid_, SIGKILL);
  ended().push_back(std::exchange(pid_, 0));
  collect();
}

void Child::collect() {
  std::erase_if(ended(), [](pid_t pid) { return ::waitpid(pid, nullptr, WNOHANG) != 0; });
}

Result<Peer> connect_to_helper(const std::string& path, const std::string& unit) {
  const auto address = unix_address(path);
  if (!address) return std::unexpected(address.error());
  Fd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket || ::connect(socket.get(), generic(*address), sizeof *address) < 0)
    return system_error(path);
  ucred owner{};
  socklen_t size = sizeof owner;
  if (::getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &owner, &size) < 0)
    return system_error(path);
  if (owner.uid != 0 && owner.uid != ::geteuid())
    return fail(path + ": uid " + std::to_string(owner.uid) + " listens there; it must be root (" +
                unit + ")");
  return Peer{.socket = std::move(socket), .child = {}};
}

Result<Peer> start_helper(const std::string& program) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) < 0)
    return system_error("socketpair");
  Fd ours(ends[0]);
  const Fd theirs(ends[1]);
  ::fcntl(ours.get(), F_SETFL, O_NONBLOCK);
  pid_t pid = 0;
  if (const int e = StartAs(theirs.get()).start(program, pid); e != 0)
    return system_error(program, e);
  return Peer{.socket = std::move(ours), .child = Child(pid)};
}

std::string find_helper() {
  std::array<char, 4096> path{};
  const auto size = ::readlink("/proc/self/exe", path.data(), path.size());
  const std::string_view whole(path.data(), size <= 0 ? 0 : static_cast<std::size_t>(size));
  const std::string folder(whole.substr(0, whole.rfind('/') + 1));
  std::string program;
  for (const char* place : {"", "../", "../libexec/mlcca/"}) {
    program = folder + place + "mlcca-sources";
    if (::access(program.c_str(), X_OK) == 0) break;
  }
  return program;
}

}  // namespace mlcca::net
