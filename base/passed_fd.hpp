// SPDX-License-Identifier: BSD-2-Clause
// Passes one file descriptor to another process over a local socket (SCM_RIGHTS, see unix(7)).
#pragma once
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "base/handle.hpp"

namespace mlcca {

/// A message of one byte with room for exactly one file descriptor. The length is CMSG_LEN and not
/// CMSG_SPACE, whose padding would have room for a second descriptor; the kernel closes descriptors
/// that have no room.
struct FdMessage {
  FdMessage() {
    head.msg_iov = &data;
    head.msg_iovlen = 1;
    head.msg_control = control.data();
    head.msg_controllen = CMSG_LEN(sizeof(int));
  }
  FdMessage(const FdMessage&) = delete;
  FdMessage& operator=(const FdMessage&) = delete;
  FdMessage(FdMessage&&) = delete;
  FdMessage& operator=(FdMessage&&) = delete;
  ~FdMessage() = default;

  char byte = 0;
  iovec data{.iov_base = &byte, .iov_len = 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr head{};
};

/// Sends `fd` without waiting. False: it was not sent. The caller keeps its own descriptor.
inline bool send_fd(int socket, const Fd& fd) {
  FdMessage message;
  cmsghdr* const part = CMSG_FIRSTHDR(&message.head);
  part->cmsg_level = SOL_SOCKET;
  part->cmsg_type = SCM_RIGHTS;
  part->cmsg_len = CMSG_LEN(sizeof(int));
  const int number = fd.get();
  std::memcpy(CMSG_DATA(part), &number, sizeof number);
  return ::sendmsg(socket, &message.head, MSG_DONTWAIT | MSG_NOSIGNAL) == 1;
}

/// Receives a descriptor without waiting. Nullopt: no message has come yet. An empty Fd: the other
/// end has closed the socket, or its message does not have exactly one descriptor.
inline std::optional<Fd> receive_fd(const Fd& socket) {
  FdMessage message;
  const auto size = ::recvmsg(socket.get(), &message.head, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (size <= 0) return Fd();
  const cmsghdr* const part = CMSG_FIRSTHDR(&message.head);
  if (part == nullptr || part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS ||
      part->cmsg_len != CMSG_LEN(sizeof(int)))
    return Fd();
  int number = -1;
  std::memcpy(&number, CMSG_DATA(part), sizeof number);
  Fd fd(number);
  if ((message.head.msg_flags & MSG_CTRUNC) != 0) return Fd();
  return fd;
}

}  // namespace mlcca
