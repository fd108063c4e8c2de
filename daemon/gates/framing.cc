// SPDX-License-Identifier: BSD-2-Clause
// Asks by index over netlink. An ioctl asks by name; if the interface has gone, the kernel runs
// modprobe for that name, and the caller waits for it. net::Rtnl is not used: the programs that
// close gates in early boot are linked without libnl, which daemon/net alone may use.
#include <fmt/format.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if_arp.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/handle.hpp"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/failure.hpp"

namespace mlcca::gates {
namespace {

struct Question {
  nlmsghdr head;
  ifinfomsg link;
};

constexpr timeval kPatience{.tv_sec = 1, .tv_usec = 0};

/// 0 if `type` was set; otherwise an errno.
int ask_for_type(std::uint32_t ifindex, std::uint16_t& type) {
  const Fd socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
  if (!socket ||
      ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience) != 0)
    return errno;
  Question question{};
  question.head = {.nlmsg_len = sizeof question,
                   .nlmsg_type = RTM_GETLINK,
                   .nlmsg_flags = NLM_F_REQUEST,
                   .nlmsg_seq = 1,
                   .nlmsg_pid = 0};
  question.link.ifi_index = static_cast<int>(ifindex);
  if (::send(socket.get(), &question, sizeof question, 0) < 0) return errno;
  alignas(nlmsghdr) std::array<char, 32768> bytes{};
  const ssize_t received = ::recv(socket.get(), bytes.data(), bytes.size(), 0);
  if (received < 0) return errno;
  const auto size = static_cast<std::size_t>(received);
  nlmsghdr head{};
  if (size < sizeof head) return EBADMSG;
  std::memcpy(&head, bytes.data(), sizeof head);
  const char* const body = bytes.data() + NLMSG_HDRLEN;
  if (head.nlmsg_type == NLMSG_ERROR && size >= NLMSG_LENGTH(sizeof(nlmsgerr))) {
    nlmsgerr refused{};
    std::memcpy(&refused, body, sizeof refused);
    return refused.error < 0 ? -refused.error : EBADMSG;
  }
  if (head.nlmsg_type != RTM_NEWLINK || size < NLMSG_LENGTH(sizeof(ifinfomsg))) return EBADMSG;
  ifinfomsg link{};
  std::memcpy(&link, body, sizeof link);
  if (link.ifi_index != static_cast<int>(ifindex)) return EBADMSG;
  type = link.ifi_type;
  return 0;
}

}  // namespace

Result<Framing> framing_of(std::uint32_t ifindex) {
  std::uint16_t type = 0;
  if (const int error = ask_for_type(ifindex, type); error != 0)
    return failure(fmt::format("ask for the hardware type of interface {}", ifindex), error);
  if (type == ARPHRD_IEEE802154) return Framing::wpan;
  return type == ARPHRD_ETHER ? Framing::ethernet : Framing::other;
}

}  // namespace mlcca::gates
