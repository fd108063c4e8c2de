// SPDX-License-Identifier: BSD-2-Clause
#include "tools/awds/capture.hpp"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <utility>

#include "base/system_error.hpp"
#include "tools/sources/awds_packet.hpp"

namespace mlcca::awds {
namespace {

sock_filter step(std::uint16_t code, std::uint32_t k, std::uint8_t yes = 0, std::uint8_t no = 0) {
  return {.code = code, .jt = yes, .jf = no, .k = k};
}

/// Attaches a filter that passes only packets of sufficient length with octet 0 "flood" and octet
/// 16 "topology".
Result<void> filter(int fd) {
  std::array program{
      step(BPF_LD | BPF_W | BPF_LEN, 0),
      step(BPF_JMP | BPF_JGE | BPF_K, net::awds::kShortest, 0, 6),
      step(BPF_LD | BPF_B | BPF_ABS, 0),
      step(BPF_ALU | BPF_AND | BPF_K, 0x03),
      step(BPF_JMP | BPF_JEQ | BPF_K, 1, 0, 3),
      step(BPF_LD | BPF_B | BPF_ABS, 16),
      step(BPF_JMP | BPF_JEQ | BPF_K, 0, 0, 1),
      step(BPF_RET | BPF_K, net::awds::kLongest),
      step(BPF_RET | BPF_K, 0),
  };
  const sock_fprog filter{.len = program.size(), .filter = program.data()};
  if (::setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) < 0)
    return system_error("SO_ATTACH_FILTER");
  return {};
}

}  // namespace

Result<Capture> Capture::open(std::string interface) {
  if (interface.empty() || interface.size() >= IFNAMSIZ)
    return fail("\"" + interface + "\" is no name of an interface");
  // Protocol 0: it receives nothing until it is bound to an interface.
  Fd socket(::socket(AF_PACKET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return system_error("packet socket (needs CAP_NET_RAW)");
  if (auto filtered = filter(socket.get()); !filtered) return std::unexpected(filtered.error());
  return Capture(std::move(interface), std::move(socket));
}

Result<void> Capture::follow() {
  ifreq request{};
  interface_.copy(request.ifr_name, IFNAMSIZ - 1);
  if (::ioctl(fd(), SIOCGIFINDEX, &request) < 0) return system_error(interface_);
  sockaddr_ll address{};
  socklen_t size = sizeof address;
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  // The kernel unbinds the socket when its interface disappears; the index may be used again.
  const bool bound = ::getsockname(fd(), generic, &size) == 0 &&
                     address.sll_protocol == htons(net::awds::kEthertype) &&
                     address.sll_ifindex == request.ifr_ifindex;
  if (bound) return {};
  address = {};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(net::awds::kEthertype);
  address.sll_ifindex = request.ifr_ifindex;
  if (::bind(fd(), generic, sizeof address) < 0) return system_error(interface_);
  return {};
}

std::span<const std::uint8_t> Capture::next(std::span<std::uint8_t> buffer) const {
  // An error of the interface (it is down) is reported once instead of a packet.
  for (int attempt = 0; attempt < 2; ++attempt) {
    const auto size = ::recv(fd(), buffer.data(), buffer.size(), 0);
    if (size > 0) return buffer.first(static_cast<std::size_t>(size));
    if (size == 0 || errno != ENETDOWN) break;
  }
  return {};
}

}  // namespace mlcca::awds
