// SPDX-License-Identifier: BSD-2-Clause
#include "relay/layers/udp_layer.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/random.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "relay/layers/sockets.hpp"

namespace mlcca::relay {
namespace {

constexpr std::size_t kMostDatagram = kDatagramHeader + afp::kUdp.payload;
/// `net.ipv4.igmp_max_memberships` is not less unless somebody makes it so; then joining says it.
constexpr std::size_t kMostGroups = 20;

std::uint64_t random_number() {
  std::uint64_t out = 0;
  if (::getrandom(&out, sizeof out, GRND_NONBLOCK) != sizeof out) out = monotonic_ns();
  return out;
}

/// The address of dotted digits; 0: any.
std::uint32_t address_in(const std::string& text) {
  in_addr address{};
  return ::inet_pton(AF_INET, text.c_str(), &address) == 1 ? ntohl(address.s_addr) : 0;
}

template <class T>
bool set(const Fd& socket, int level, int option, const T& value) {
  return ::setsockopt(socket.get(), level, option, &value, sizeof value) == 0;
}

Result<Fd> event_socket(const control::Endpoint& endpoint) {
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
      // Otherwise the kernel reports success of what a gate or a queue drops.
      !set(socket, IPPROTO_IP, IP_RECVERR, on) ||
      !set(socket, IPPROTO_IP, IP_MULTICAST_IF, outgoing))
    return system_error("setsockopt");
  if (const auto done = ask_for_times(socket); !done) return std::unexpected(done.error());
  widen(socket);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const std::uint16_t port = endpoint.broadcast ? kBroadcastPort : kEventPort;
  address.sin_port = htons(port);
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return system_error("bind to port " + std::to_string(port));
  return socket;
}

}  // namespace

Result<std::unique_ptr<Layer>> UdpLayer::open(const control::Endpoint& endpoint) {
  auto socket = event_socket(endpoint);
  if (!socket) return std::unexpected(socket.error());
  return std::unique_ptr<Layer>(new UdpLayer(std::move(*socket), endpoint));
}

UdpLayer::UdpLayer(Fd socket, const control::Endpoint& endpoint)
    : socket_(std::move(socket)),
      ifindex_(endpoint.ifindex),
      interface_(endpoint.interface),
      broadcasts_(endpoint.broadcast),
      salt_(random_number() | 1),
      number_(static_cast<std::uint32_t>(random_number())),
      buffer_(kMostDatagram + 1) {}

// --- who follows ---------------------------------------------------------------------------------

Result<void> UdpLayer::join(std::uint32_t group) {
  if (groups_.contains(group)) return {};
  if (members_.empty() || members_.back().groups >= kMostGroups) {
    Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    if (!socket) return system_error("socket");
    members_.push_back({std::move(socket), 0});
  }
  ip_mreqn request{};
  request.imr_multiaddr.s_addr = htonl(group);
  request.imr_ifindex = static_cast<int>(ifindex_);
  if (!set(members_.back().socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, request) && errno != EADDRINUSE)
    return system_error("joining a multicast group");
  ++members_.back().groups;
  groups_.insert(group);
  return {};
}

Result<void> UdpLayer::follow(Follower follower, const control::Endpoint& endpoint,
                              std::uint64_t subject, std::size_t longest) {
  if (const auto joined = broadcasts_ ? Result<void>() : join(group_of(subject)); !joined)
    return joined;
  followers_.add(follower, subject, address_in(endpoint.address), longest);
  return {};
}

/// Groups are never left: who subscribes again is in them at once, and they cost 32 bytes each.
void UdpLayer::leave(Follower follower, const control::Endpoint& /*endpoint*/,
                     std::uint64_t subject) {
  followers_.remove(follower, subject);
}

// --- what comes ----------------------------------------------------------------------------------

bool UdpLayer::receive(std::size_t most, const OnEvent& on_event) {
  for (std::size_t count = 0; count < most; ++count) {
    sockaddr_in from{};
    const auto [n, flags, said] =
        receive_into(socket_, buffer_.data(), buffer_.size(), &from, sizeof from);
    if (n < 0 && (errno == ENODEV || errno == ENXIO)) return false;
    if (n < 0 && errno != EAGAIN) continue;  // of an earlier datagram: ENETDOWN, ECONNREFUSED
    if (n < 0) {
      if (count == 0) read_errors();
      return true;
    }
    if (said.says_dropped) losses_.in_socket = said.dropped;
    if (static_cast<std::size_t>(n) > kMostDatagram)
      ++losses_.malformed;
    else
      take(Octets(buffer_).first(static_cast<std::size_t>(n)), ntohl(from.sin_addr.s_addr),
           said.unix_ns, on_event);
  }
  return true;
}

/// What is reported of datagrams that were sent before makes the socket readable until it is read.
void UdpLayer::read_errors() {
  constexpr unsigned most = 64;
  for (unsigned i = 0; i < most; ++i)
    if (receive_into(socket_, buffer_.data(), buffer_.size(), nullptr, 0, MSG_ERRQUEUE).size < 0)
      return;
}

void UdpLayer::expire() { fragments_.expire(monotonic_ns()); }

/// What was broadcast on the interface comes back to it. An address that has just changed is known
/// a second later at the latest.
bool UdpLayer::is_own(std::uint32_t from, std::uint64_t now) {
  constexpr std::uint64_t second = 1'000'000'000;
  if (own_at_ == 0 || now - own_at_ >= second) {
    ifreq asked{};
    interface_.copy(std::begin(asked.ifr_name), IFNAMSIZ - 1);
    sockaddr_in own{};
    if (::ioctl(socket_.get(), SIOCGIFADDR, &asked) == 0)
      std::memcpy(&own, &asked.ifr_addr, sizeof own);
    own_ = ntohl(own.sin_addr.s_addr);
    own_at_ = now;
  }
  return own_ != 0 && from == own_;
}

void UdpLayer::take(Octets octets, std::uint32_t from, std::uint64_t unix_ns,
                    const OnEvent& on_event) {
  const auto datagram = parse_datagram(octets);
  if (!datagram) {
    ++losses_.malformed;
    return;
  }
  if (!followers_.any(datagram->subject)) return;
  if (broadcasts_ && is_own(from, monotonic_ns())) return;
  if (!datagram->is_fragment) {
    followers_.hand_over(datagram->subject, from, datagram->data, unix_ns, on_event, losses_);
    return;
  }
  const auto source = std::rotl(datagram->subject * salt_, 32) * salt_ + from;
  if (const auto event = fragments_.take(source, datagram->data, monotonic_ns()))
    followers_.hand_over(datagram->subject, from, *event, unix_ns, on_event, losses_);
}

// --- what goes -----------------------------------------------------------------------------------

Sent UdpLayer::send_one(const sockaddr_in& to, std::uint64_t subject, bool is_fragment,
                        Octets data) {
  auto header = datagram_header(subject, is_fragment);
  std::array<iovec, 2> parts{
      iovec{.iov_base = header.data(), .iov_len = header.size()},
      iovec{.iov_base = const_cast<std::uint8_t*>(data.data()),  // NOLINT(*-const-cast): read only
            .iov_len = data.size()}};
  sockaddr_in address = to;
  msghdr message{};
  message.msg_name = &address;
  message.msg_namelen = sizeof address;
  message.msg_iov = parts.data();
  message.msg_iovlen = parts.size();
  const ssize_t n = ::sendmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_NOSIGNAL);
  return n >= 0 ? Sent::sent : failure_of_send();
}

Sent UdpLayer::send(const control::Endpoint& /*endpoint*/, std::uint64_t subject, Octets event) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(broadcasts_ ? kBroadcastPort : kEventPort);
  to.sin_addr.s_addr = htonl(broadcasts_ ? INADDR_BROADCAST : group_of(subject));
  if (event.size() <= afp::kUdp.payload) return send_one(to, subject, false, event);
  auto fragments = afp::Fragments::of(afp::kUdp, event, number_++);
  if (!fragments) return Sent::too_long;
  while (const auto fragment = fragments->next())
    if (const Sent sent = send_one(to, subject, true, *fragment); sent != Sent::sent) return sent;
  return Sent::sent;
}

Losses UdpLayer::losses() const {
  Losses out = losses_;
  const afp::Losses& of_fragments = fragments_.losses();
  out.malformed += of_fragments.malformed;
  out.incomplete += of_fragments.incomplete + of_fragments.late;
  out.crowded += of_fragments.crowded;
  return out;
}

}  // namespace mlcca::relay
