// SPDX-License-Identifier: BSD-2-Clause
#include "tools/doctor/probe.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <span>
#include <string_view>
#include <utility>

#include "base/number.hpp"
#include "base/system_error.hpp"

namespace mlcca::doctor {
namespace {

constexpr unsigned kClassicBytes = CAN_MAX_DLEN;
constexpr unsigned kFdBytes = CANFD_MAX_DLEN;
constexpr unsigned kNumberBytes = 4;
/// A value whose bits alternate, so that it needs no stuff bits.
constexpr std::uint8_t kFiller = 0x55;
/// Receive buffer in bytes, for all frames of a measurement at 768 bytes each.
constexpr int kBuffer = 8 << 20;

template <class T>
bool set(int fd, int level, int option, const T& value) {
  return ::setsockopt(fd, level, option, &value, sizeof value) == 0;
}

/// Enlarges the socket buffers, beyond the limit for users if the process has CAP_NET_ADMIN.
void enlarge(int fd) {
  for (const auto& [forced, asked] :
       {std::pair(SO_RCVBUFFORCE, SO_RCVBUF), std::pair(SO_SNDBUFFORCE, SO_SNDBUF)})
    if (!set(fd, SOL_SOCKET, forced, kBuffer)) set(fd, SOL_SOCKET, asked, kBuffer);
}

std::uint64_t time_of(msghdr& message) {
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c))
    if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_TIMESTAMPNS) {
      timespec at{};
      std::memcpy(&at, CMSG_DATA(c), sizeof at);
      return static_cast<std::uint64_t>(at.tv_sec) * 1'000'000'000 +
             static_cast<std::uint64_t>(at.tv_nsec);
    }
  return 0;
}

Seen understood(const canfd_frame& raw, bool fd) {
  Seen seen;
  if ((raw.can_id & CAN_ERR_FLAG) != 0) {
    seen.error = raw.can_id & CAN_ERR_MASK;
    return seen;
  }
  auto& frame = seen.frame;
  frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.id = raw.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.fd = fd;
  frame.remote = !fd && (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.switches = fd && (raw.flags & CANFD_BRS) != 0;
  frame.passive = fd && (raw.flags & CANFD_ESI) != 0;
  frame.size = std::min<std::uint8_t>(raw.len, fd ? kFdBytes : kClassicBytes);
  std::copy_n(raw.data, frame.size, frame.data.begin());
  for (unsigned i = 0; i < kNumberBytes; ++i) seen.number = seen.number << 8U | frame.data[i];
  return seen;
}

}  // namespace

Result<Identifier> read_identifier(const std::string& text) {
  std::string_view digits = text;
  if (digits.starts_with("0x") || digits.starts_with("0X")) digits.remove_prefix(2);
  const auto value = number_in<std::uint32_t>(digits, kHexadecimalBase);
  if (!value || *value > CAN_EFF_MASK)
    return fail("--id " + text +
                ": must be hexadecimal, up to 7FF (11 bits) or 1FFFFFFF (29 bits)");
  return Identifier{.value = *value, .extended = *value > CAN_SFF_MASK};
}

Result<Probe> Probe::open(int ifindex, Identifier id, bool fd) {
  Fd socket(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!socket) return system_error("CAN socket");
  const int s = socket.get();
  enlarge(s);
  const can_err_mask_t errors = CAN_ERR_MASK;
  if (!set(s, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 1) ||
      !set(s, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, errors) || !set(s, SOL_SOCKET, SO_TIMESTAMPNS, 1))
    return system_error("options of a CAN socket");
  if (fd && !set(s, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1)) return system_error("CAN_RAW_FD_FRAMES");
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = ifindex;
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::bind(s, reinterpret_cast<const sockaddr*>(&address), sizeof address) < 0)
    return system_error("binding a CAN socket");
  return Probe(std::move(socket), id);
}

core::can::WireFrame Probe::frame(std::uint32_t number, bool fd) const {
  core::can::WireFrame frame{.id = id_.value,
                             .extended = id_.extended,
                             .fd = fd,
                             .switches = fd,
                             .size = static_cast<std::uint8_t>(fd ? kFdBytes : kClassicBytes)};
  std::fill_n(frame.data.begin(), frame.size, kFiller);
  for (unsigned i = 0; i < kNumberBytes; ++i)
    frame.data[i] = static_cast<std::uint8_t>(number >> (8 * (kNumberBytes - 1 - i)));
  return frame;
}

Result<bool> Probe::send(std::uint32_t number, bool fd) const {
  const auto wire = frame(number, fd);
  canfd_frame raw{};
  raw.can_id = wire.id | (wire.extended ? CAN_EFF_FLAG : 0);
  raw.len = wire.size;
  raw.flags = fd ? CANFD_BRS : 0;
  std::copy_n(wire.data.begin(), wire.size, raw.data);
  if (::send(socket_.get(), &raw, fd ? CANFD_MTU : CAN_MTU, 0) >= 0) return true;
  if (errno == ENOBUFS || errno == EAGAIN) return false;
  return system_error("sending a frame");
}

Result<std::optional<Seen>> Probe::next(unsigned patience_ms) const {
  pollfd ready{.fd = fd(), .events = POLLIN, .revents = 0};
  const int count = ::poll(&ready, 1, static_cast<int>(patience_ms));
  if (count < 0 && errno != EINTR) return system_error("waiting for frames");
  if (count <= 0) return std::nullopt;
  canfd_frame raw{};
  iovec where{.iov_base = &raw, .iov_len = sizeof raw};
  alignas(cmsghdr) std::array<char, 256> control{};
  msghdr message{};
  message.msg_iov = &where;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const auto size = ::recvmsg(fd(), &message, 0);
  // An interface that goes down reports that once; it may come up again.
  if (size < 0 && (errno == EAGAIN || errno == ENETDOWN)) return std::nullopt;
  if (size < 0) return system_error("receiving a frame");
  Seen seen = understood(raw, static_cast<std::size_t>(size) == CANFD_MTU);
  seen.own = (message.msg_flags & MSG_CONFIRM) != 0;
  seen.ns = time_of(message);
  return seen;
}

}  // namespace mlcca::doctor
