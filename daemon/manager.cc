// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/manager.hpp"

#include <sys/socket.h>

#include <cstddef>
#include <cstdlib>

#include "core/handle.hpp"
#include "core/unix_address.hpp"

namespace mlcca {

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

}  // namespace mlcca
