// SPDX-License-Identifier: BSD-2-Clause
#include "base/at_once.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

#include "base/handle.hpp"
#include "base/unix_address.hpp"

namespace mlcca {
namespace {

Fd opened_again(int fd) {
  std::array<char, 32> path{};  // there may be no memory left to allocate
  if (std::snprintf(path.data(), path.size(), "/proc/self/fd/%d", fd) < 0) return {};
  return Fd(::open(path.data(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
}

/// Writes at most PIPE_BUF bytes, which a ready pipe takes without waiting unless another writer is
/// faster. Needed where a pipe cannot be opened again (in the sandbox of mlcca-sources).
ssize_t write_where_ready(int fd, std::string_view text) {
  pollfd ready{.fd = fd, .events = POLLOUT, .revents = 0};
  if (::poll(&ready, 1, 0) != 1 || ready.revents != POLLOUT) return -1;
  return ::write(fd, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
}

/// Calls `write` for the rest until everything is written. False if it writes no more.
bool write_all(std::string_view text, auto write) {
  while (!text.empty()) {
    const ssize_t n = write(text);
    if (n <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace

Fd opened_at_once(int fd) {
  struct stat is{};
  const bool may_wait = ::fstat(fd, &is) == 0 && (S_ISFIFO(is.st_mode) || S_ISCHR(is.st_mode));
  return may_wait ? opened_again(fd) : Fd();
}

bool send_at_once(const std::string& path, std::span<const iovec> parts) {
  auto address = unix_address(path);
  const Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!address || !socket) return false;
  if (path.front() == '@') address->sun_path[0] = '\0';
  msghdr message{};
  message.msg_name = &*address;
  message.msg_namelen = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  message.msg_iov = const_cast<iovec*>(parts.data());  // NOLINT(*-const-cast): it is only read
  message.msg_iovlen = parts.size();
  return ::sendmsg(socket.get(), &message, MSG_NOSIGNAL | MSG_DONTWAIT) >= 0;
}

bool notify(std::string_view lines) {
  const char* path = std::getenv("NOTIFY_SOCKET");  // NOLINT(concurrency-mt-unsafe)
  if (path == nullptr || *path == '\0') return true;
  const std::string text(lines);
  const iovec part{const_cast<char*>(text.data()), text.size()};  // NOLINT(*-const-cast)
  return send_at_once(path, {&part, 1});
}

bool write_at_once(int fd, std::string_view text) {
  struct stat is{};
  if (::fstat(fd, &is) < 0) return false;
  if (S_ISSOCK(is.st_mode))
    return write_all(text, [fd](std::string_view rest) {
      return ::send(fd, rest.data(), rest.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    });
  const bool waits = (::fcntl(fd, F_GETFL) & O_NONBLOCK) == 0;
  const Fd own = waits ? opened_at_once(fd) : Fd();
  const int to = own ? own.get() : fd;
  return write_all(text, [to](std::string_view rest) { return write_where_ready(to, rest); });
}

}  // namespace mlcca
