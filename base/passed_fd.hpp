// SPDX-License-Identifier: BSD-2-Clause
// One file descriptor from a process to another, over a local socket (SCM_RIGHTS, unix(7)).
#pragma once
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "base/handle.hpp"

namespace mlcca {

/// With a message of one byte. Does not wait; false: it was not sent.
inline bool send_fd(int socket, const Fd& fd) {
  char byte = 0;
  iovec data{.iov_base = &byte, .iov_len = 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const part = CMSG_FIRSTHDR(&message);
  part->cmsg_level = SOL_SOCKET;
  part->cmsg_type = SCM_RIGHTS;
  part->cmsg_len = CMSG_LEN(sizeof(int));
  const int number = fd.get();
  std::memcpy(CMSG_DATA(part), &number, sizeof number);
  return ::sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL) == 1;
}

/// Does not wait. Nothing: no message has come. An Fd without one: the other end has gone, or its
/// message has no file descriptor, or several.
inline std::optional<Fd> receive_fd(const Fd& socket) {
  char byte = 0;
  iovec data{.iov_base = &byte, .iov_len = 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  // Without the padding, in which there is room for a second one. The kernel closes what has no
  // room.
  message.msg_controllen = CMSG_LEN(sizeof(int));
  const auto size = ::recvmsg(socket.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (size <= 0) return Fd();
  const cmsghdr* const part = CMSG_FIRSTHDR(&message);
  if (part == nullptr || part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS ||
      part->cmsg_len != CMSG_LEN(sizeof(int)))
    return Fd();
  int number = -1;
  std::memcpy(&number, CMSG_DATA(part), sizeof number);
  Fd fd(number);
  if ((message.msg_flags & MSG_CTRUNC) != 0) return Fd();
  return fd;
}

}  // namespace mlcca
