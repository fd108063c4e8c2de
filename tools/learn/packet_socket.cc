// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/packet_socket.hpp"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <utility>

#include "base/system_error.hpp"
#include "tools/learn/ether.hpp"

namespace mlcca::learn {
namespace {

sock_filter load(std::uint16_t size, std::uint32_t at) {
  return {static_cast<std::uint16_t>(BPF_LD | size | BPF_ABS), 0, 0, at};
}
/// A jump over `yes` instructions if the test is true, over `no` otherwise.
sock_filter jump(std::uint16_t test, std::uint32_t value, std::uint8_t yes, std::uint8_t no) {
  return {static_cast<std::uint16_t>(BPF_JMP | test | BPF_K), yes, no, value};
}
sock_filter give(std::uint32_t bytes) { return {BPF_RET | BPF_K, 0, 0, bytes}; }

constexpr std::size_t kTests = 5;  // instructions that examine an IPv4 packet

/// Accepts the IPv4 packet at offset `at` if it is UDP and not a later fragment.
std::array<sock_filter, kTests + 1> is_datagram(std::uint32_t at) {
  constexpr std::uint32_t protocol = 9;
  constexpr std::uint32_t fragment = 6;
  constexpr std::uint32_t offset_bits = 0x1fff;
  return {load(BPF_B, at + protocol), jump(BPF_JEQ, IPPROTO_UDP, 0, 3),
          load(BPF_H, at + fragment), jump(BPF_JSET, offset_bits, 1, 0),
          give(kFrameRead),           give(0)};
}

/// The filter: for each number of VLAN tags a block that examines the EtherType and then the
/// packet.
template <std::size_t Blocks>
auto datagrams_only() {
  constexpr std::size_t test = 4;  // instructions of a block before its is_datagram()
  constexpr std::size_t block = test + kTests + 1;
  std::array<sock_filter, Blocks * block + 1> out{};
  for (std::size_t i = 0; i < Blocks; ++i) {
    auto* at = out.data() + i * block;
    const auto type = static_cast<std::uint32_t>(ETH_HLEN - 2 + 4 * i);
    constexpr std::uint8_t next = block - 2;  // distance to the next block, behind the tests of the
                                              // tag
    *at++ = load(BPF_H, type);
    *at++ = jump(BPF_JEQ, ETH_P_IP, 2, 0);
    *at++ = jump(BPF_JEQ, ETH_P_8021Q, next - 1, 0);
    *at++ = jump(BPF_JEQ, ETH_P_8021AD, next - 2, next - 3);
    for (const sock_filter& one : is_datagram(type + 2)) *at++ = one;
  }
  out.back() = give(0);
  return out;
}

}  // namespace

Result<Fd> open_packet_socket(const std::string& interface) {
  // Protocol 0: the socket receives nothing before the filter is attached.
  Fd socket(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket && errno == EPERM)
    return fail(interface +
                ": listening to Ethernet needs CAP_NET_RAW, which CAN does not: take sudo, or "
                "record with tcpdump and learn from the file");
  if (!socket) return system_error(interface + ": socket");
  auto program = datagrams_only<3>();
  const sock_fprog filter{.len = static_cast<unsigned short>(program.size()),
                          .filter = program.data()};
  if (::setsockopt(socket.get(), SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) != 0)
    return system_error(interface + ": filter");
  return socket;
}

Result<void> bind_packet_socket(const Fd& socket, const std::string& interface, int index) {
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  address.sll_ifindex = index;
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return system_error(interface + ": bind");
  return {};
}

bool read_packet(std::span<const std::uint8_t> bytes, unsigned type, Frame& out) {
  out.local = type == PACKET_OUTGOING;
  return read_ethernet(bytes, out) == Carries::datagram;
}

}  // namespace mlcca::learn
