// SPDX-License-Identifier: BSD-2-Clause
#include "client/local_socket.hpp"

#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cstring>
#include <utility>

#include "base/big_endian.hpp"
#include "base/system_error.hpp"
#include "base/unix_address.hpp"

namespace mlcca::client {
namespace {

/// The user who has sent a message; nobody where the kernel does not say.
uid_t sender_of(msghdr& message) {
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_CREDENTIALS) continue;
    ucred who{};
    std::memcpy(&who, CMSG_DATA(part), sizeof who);
    return who.uid;
  }
  return static_cast<uid_t>(-1);
}

}  // namespace

Result<LocalSocket> LocalSocket::open() {
  Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket) return system_error("socket");
  const int on = 1;
  if (::setsockopt(socket.get(), SOL_SOCKET, SO_PASSCRED, &on, sizeof on) != 0)
    return system_error("SO_PASSCRED");
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (::bind(socket.get(), generic(address), sizeof address.sun_family) != 0)
    return system_error("bind");
  socklen_t size = sizeof address;
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0)
    return system_error("getsockname");
  const std::size_t before = offsetof(sockaddr_un, sun_path) + 1;  // and the null byte
  if (size <= before) return fail("the kernel gave no address to a socket");
  return LocalSocket(std::move(socket), std::string(&address.sun_path[1], size - before));
}

std::size_t LocalSocket::receive(std::size_t most, const OnEvent& on_event) {
  for (std::size_t count = 0; count < most; ++count) {
    iovec data{.iov_base = buffer_.data(), .iov_len = buffer_.size()};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(ucred))> control{};
    msghdr message{};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t n = ::recvmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (n < 0) return count;
    const auto bytes = static_cast<std::size_t>(n);
    if (bytes < kHeader || (message.msg_flags & MSG_TRUNC) != 0) continue;
    const Octets all(buffer_.data(), bytes);
    on_event(from_big_endian(all.first(kHeader)), sender_of(message), all.subspan(kHeader));
  }
  return most;
}

bool LocalSocket::send(const std::string& to, std::uint64_t subject, Octets event) {
  auto header = big_endian(subject);
  // The kernel reads them, and nothing else.
  std::array<iovec, 2> data{
      iovec{.iov_base = header.data(), .iov_len = header.size()},
      iovec{.iov_base = const_cast<std::uint8_t*>(event.data()),  // NOLINT(*-const-cast)
            .iov_len = event.size()}};
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (to.size() + 2 > sizeof address.sun_path) return false;
  to.copy(&address.sun_path[1], to.size());
  msghdr message{};
  message.msg_name = &address;
  message.msg_namelen = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + to.size());
  message.msg_iov = data.data();
  message.msg_iovlen = data.size();
  return ::sendmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
}

}  // namespace mlcca::client
