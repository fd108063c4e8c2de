// SPDX-License-Identifier: BSD-2-Clause
#include "relay/layers/sockets.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

namespace mlcca::relay {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr int kRoom = 1 << 20;  // bytes; the kernel limits it to net.core.rmem_max

}  // namespace

Beside beside(msghdr& message) {
  Beside out;
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET) continue;
    if (part->cmsg_type == SCM_TIMESTAMPNS) {
      timespec time{};
      std::memcpy(&time, CMSG_DATA(part), sizeof time);
      out.unix_ns = static_cast<std::uint64_t>(time.tv_sec) * kSecond +
                    static_cast<std::uint64_t>(time.tv_nsec);
    } else if (part->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&out.dropped, CMSG_DATA(part), sizeof out.dropped);
      out.says_dropped = true;
    }
  }
  return out;
}

Received receive_into(const Fd& socket, void* data, std::size_t room, void* from,
                      socklen_t from_size, int flags) {
  iovec part{.iov_base = data, .iov_len = room};
  BesideRoom control{};
  msghdr message{};
  message.msg_name = from;
  message.msg_namelen = from_size;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.bytes.data();
  message.msg_controllen = control.bytes.size();
  const ssize_t size = ::recvmsg(socket.get(), &message, MSG_DONTWAIT | flags);
  if (size < 0) return {};
  return {size, message.msg_flags, beside(message)};
}

Batch::Batch(std::size_t room) : data_(kMost * room) {
  for (std::size_t i = 0; i < kMost; ++i) {
    parts_.at(i) = {.iov_base = &data_.at(i * room), .iov_len = room};
    msghdr& message = messages_.at(i).msg_hdr;
    message.msg_name = &from_.at(i);
    message.msg_iov = &parts_.at(i);
    message.msg_iovlen = 1;
    message.msg_control = control_.at(i).bytes.data();
  }
}

Batch::Message Batch::next(const Fd& socket) {
  if (at_ == count_) {
    at_ = count_ = 0;
    if (std::exchange(drained_, false)) {
      errno = EAGAIN;
      return {};
    }
    for (mmsghdr& one : messages_) {
      one.msg_hdr.msg_namelen = sizeof(sockaddr_storage);
      one.msg_hdr.msg_controllen = sizeof(BesideRoom::bytes);
    }
    const int n = ::recvmmsg(socket.get(), messages_.data(), kMost, MSG_DONTWAIT, nullptr);
    if (n <= 0) return {};
    count_ = static_cast<std::size_t>(n);
    drained_ = count_ < kMost;
  }
  const std::size_t which = at_++;
  msghdr& message = messages_.at(which).msg_hdr;
  return {.received = {static_cast<ssize_t>(messages_.at(which).msg_len), message.msg_flags,
                       beside(message)},
          .data = static_cast<const std::uint8_t*>(parts_.at(which).iov_base),
          .from = &from_.at(which)};
}

Result<void> ask_for_times(const Fd& socket) {
  const int on = 1;
  for (const int option : {SO_TIMESTAMPNS, SO_RXQ_OVFL})
    if (::setsockopt(socket.get(), SOL_SOCKET, option, &on, sizeof on) != 0)
      return system_error("setsockopt");
  return {};
}

void widen(const Fd& socket) {
  const int room = kRoom;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
}

Sent failure_of_send() {
  switch (errno) {
    case EAGAIN:
    case ENOBUFS:
    case ENOMEM:
    case EPERM:
      return Sent::dropped;
    case EMSGSIZE:
      return Sent::too_long;
    default:
      return Sent::failed;
  }
}

}  // namespace mlcca::relay
