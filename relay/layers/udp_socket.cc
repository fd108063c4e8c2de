// SPDX-License-Identifier: BSD-2-Clause
// The sockets of a UDP network: one for the data, and as many members as the groups need.
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "relay/layers/sockets.hpp"
#include "relay/layers/udp_layer.hpp"

namespace mlcca::relay {
namespace {

constexpr std::size_t kReceived = kDatagramHeader + afp::kUdp.payload + 1;  // octets
/// Groups that one socket can join. net.ipv4.igmp_max_memberships is 20 unless it was lowered; then
/// join() fails.
constexpr std::size_t kMostGroups = 20;

template <class T>
bool set(const Fd& socket, int level, int option, const T& value) {
  return ::setsockopt(socket.get(), level, option, &value, sizeof value) == 0;
}

Result<Fd> event_socket(const control::Endpoint& endpoint, std::uint16_t port) {
  Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket) return system_error("socket");
  const int on = 1;
  const int off = 0;
  const auto& name = endpoint.interface;
  ip_mreqn outgoing{};
  outgoing.imr_ifindex = static_cast<int>(endpoint.ifindex);
  if (::setsockopt(socket.get(), SOL_SOCKET, SO_BINDTODEVICE, name.c_str(),
                   static_cast<socklen_t>(name.size() + 1)) != 0)
    return system_error(name);
  if (!set(socket, SOL_SOCKET, SO_REUSEADDR, on) || !set(socket, SOL_SOCKET, SO_BROADCAST, on) ||
      !set(socket, IPPROTO_IP, IP_MULTICAST_LOOP, off) ||
      // Without IP_RECVERR the kernel reports success for datagrams that a gate or a queue drops.
      !set(socket, IPPROTO_IP, IP_RECVERR, on) ||
      !set(socket, IPPROTO_IP, IP_MULTICAST_IF, outgoing))
    return system_error("setsockopt");
  if (const auto done = ask_for_times(socket); !done) return std::unexpected(done.error());
  widen(socket);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return system_error("bind to port " + std::to_string(port));
  return socket;
}

class EventSockets : public UdpSocket {
 public:
  EventSockets(Fd socket, const control::Endpoint& endpoint, std::uint16_t port)
      : socket_(std::move(socket)),
        ifindex_(endpoint.ifindex),
        interface_(endpoint.interface),
        port_(port) {}

  [[nodiscard]] int fd() const override { return socket_.get(); }
  [[nodiscard]] Result<void> join(std::uint32_t group) override;
  void leave(std::uint32_t group) override;
  Got receive(Datagram& to) override;
  [[nodiscard]] bool pending() const override { return batch_.pending(); }
  void read_errors() override;
  Sent send(std::uint32_t to, Octets header, Octets data) override;
  [[nodiscard]] std::uint32_t own_address() const override;
  [[nodiscard]] std::uint64_t dropped() const override { return dropped_; }

 private:
  /// A socket that only stays in groups, since one socket can join 20 (igmp_max_memberships).
  struct Member {
    Fd socket;
    std::set<std::uint32_t> groups;
  };
  [[nodiscard]] ip_mreqn request(std::uint32_t group) const {
    ip_mreqn out{};
    out.imr_multiaddr.s_addr = htonl(group);
    out.imr_ifindex = static_cast<int>(ifindex_);
    return out;
  }

  Fd socket_;
  std::uint32_t ifindex_;
  std::string interface_;
  std::uint16_t port_;
  std::vector<Member> members_;
  std::uint64_t dropped_ = 0;
  Batch batch_{kReceived};
};

Result<void> EventSockets::join(std::uint32_t group) {
  auto member = std::ranges::find_if(
      members_, [](const Member& one) { return one.groups.size() < kMostGroups; });
  if (member == members_.end()) {
    Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    if (!socket) return system_error("socket");
    members_.push_back({std::move(socket), {}});
    member = std::prev(members_.end());
  }
  if (!set(member->socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, request(group)) && errno != EADDRINUSE)
    return system_error("joining a multicast group");
  member->groups.insert(group);
  return {};
}

void EventSockets::leave(std::uint32_t group) {
  for (Member& member : members_)
    if (member.groups.erase(group) != 0)
      // Fails if the interface is gone, which has ended its memberships.
      static_cast<void>(set(member.socket, IPPROTO_IP, IP_DROP_MEMBERSHIP, request(group)));
}

UdpSocket::Got EventSockets::receive(Datagram& to) {
  const Batch::Message message = batch_.next(socket_);
  const auto [n, flags, said] = message.received;
  if (n < 0 && (errno == ENODEV || errno == ENXIO)) return Got::gone;
  if (n < 0) return errno == EAGAIN ? Got::nothing : Got::failed;  // e.g. ENETDOWN or ECONNREFUSED
  if (said.says_dropped) dropped_ = said.dropped;
  sockaddr_in from{};
  std::memcpy(&from, message.from, sizeof from);
  to.octets = Octets(message.data, static_cast<std::size_t>(n));
  to.from = ntohl(from.sin_addr.s_addr);
  to.unix_ns = said.unix_ns;
  return Got::datagram;
}

void EventSockets::read_errors() {
  constexpr unsigned most = 64;
  std::array<std::uint8_t, 64> unused{};
  for (unsigned i = 0; i < most; ++i)
    if (receive_into(socket_, unused.data(), unused.size(), nullptr, 0, MSG_ERRQUEUE).size < 0)
      return;
}

Sent EventSockets::send(std::uint32_t to, Octets header, Octets data) {
  std::array<iovec, 2> parts{};
  std::size_t count = 0;
  for (const Octets part : {header, data})
    parts.at(count++) = {
        .iov_base = const_cast<std::uint8_t*>(part.data()),  // NOLINT(*-const-cast): read only
        .iov_len = part.size()};
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port_);
  address.sin_addr.s_addr = htonl(to);
  msghdr message{};
  message.msg_name = &address;
  message.msg_namelen = sizeof address;
  message.msg_iov = parts.data();
  message.msg_iovlen = parts.size();
  const ssize_t n = ::sendmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_NOSIGNAL);
  return n >= 0 ? Sent::sent : failure_of_send();
}

std::uint32_t EventSockets::own_address() const {
  ifreq asked{};
  interface_.copy(std::begin(asked.ifr_name), IFNAMSIZ - 1);
  sockaddr_in own{};
  if (::ioctl(socket_.get(), SIOCGIFADDR, &asked) == 0)
    std::memcpy(&own, &asked.ifr_addr, sizeof own);
  return ntohl(own.sin_addr.s_addr);
}

}  // namespace

Result<std::unique_ptr<UdpSocket>> open_udp_socket(const control::Endpoint& endpoint) {
  const std::uint16_t port = endpoint.broadcast ? kBroadcastPort : kEventPort;
  auto socket = event_socket(endpoint, port);
  if (!socket) return std::unexpected(socket.error());
  return std::unique_ptr<UdpSocket>(new EventSockets(std::move(*socket), endpoint, port));
}

}  // namespace mlcca::relay
