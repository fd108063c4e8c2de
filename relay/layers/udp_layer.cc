// SPDX-License-Identifier: BSD-2-Clause
#include "relay/layers/udp_layer.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/random.h>

#include <bit>
#include <optional>
#include <string>
#include <utility>

namespace mlcca::relay {
namespace {

constexpr std::size_t kMostDatagram = kDatagramHeader + afp::kUdp.payload;
/// Groups that stay joined without followers, so that a subject that is followed again arrives at
/// once.
constexpr std::size_t kMostIdle = 64;

std::uint64_t random_number() {
  std::uint64_t out = 0;
  if (::getrandom(&out, sizeof out, GRND_NONBLOCK) != sizeof out) out = monotonic_ns();
  return out;
}

/// Parses a dotted address; 0: any.
std::uint32_t ipv4_in(const std::string& text) {
  in_addr address{};
  return ::inet_pton(AF_INET, text.c_str(), &address) == 1 ? ntohl(address.s_addr) : 0;
}

}  // namespace

Result<std::unique_ptr<Layer>> UdpLayer::open(const control::Endpoint& endpoint) {
  auto socket = open_udp_socket(endpoint);
  if (!socket) return std::unexpected(socket.error());
  return std::unique_ptr<Layer>(new UdpLayer(std::move(*socket), endpoint.broadcast));
}

UdpLayer::UdpLayer(std::unique_ptr<UdpSocket> socket, bool broadcasts, std::uint64_t (*now)())
    : socket_(std::move(socket)),
      broadcasts_(broadcasts),
      now_(now),
      salt_(random_number() | 1),
      number_(static_cast<std::uint32_t>(random_number())) {}

// --- who follows ---------------------------------------------------------------------------------

Result<void> UdpLayer::follow_group(std::uint64_t subject) {
  const std::uint32_t group = group_of(subject);
  const auto known = groups_.find(group);
  if (known == groups_.end()) {
    if (auto joined = socket_->join(group); !joined) return joined;
  } else if (known->second.empty()) {
    std::erase(idle_, group);
  }
  groups_[group].insert(subject);
  return {};
}

void UdpLayer::leave_group(std::uint64_t subject) {
  const auto known = groups_.find(group_of(subject));
  if (known == groups_.end() || known->second.erase(subject) == 0 || !known->second.empty()) return;
  idle_.push_back(known->first);
  if (idle_.size() <= kMostIdle) return;
  socket_->leave(idle_.front());
  groups_.erase(idle_.front());
  idle_.pop_front();
}

Result<void> UdpLayer::follow(Follower follower, const control::Endpoint& endpoint,
                              std::uint64_t subject, std::size_t longest) {
  if (!broadcasts_)
    if (auto followed = follow_group(subject); !followed) return followed;
  followers_.add(follower, subject, ipv4_in(endpoint.address), longest);
  return {};
}

void UdpLayer::leave(Follower follower, const control::Endpoint& /*endpoint*/,
                     std::uint64_t subject) {
  followers_.remove(follower, subject);
  if (!broadcasts_ && !followers_.any(subject)) leave_group(subject);
}

// --- what comes ----------------------------------------------------------------------------------

bool UdpLayer::receive(std::size_t most, const OnEvent& on_event) {
  for (std::size_t count = 0; count < most || socket_->pending(); ++count) {
    UdpSocket::Datagram datagram;
    switch (socket_->receive(datagram)) {
      case UdpSocket::Got::gone:
        return false;
      case UdpSocket::Got::failed:
        continue;
      case UdpSocket::Got::nothing:
        if (count == 0) socket_->read_errors();
        return true;
      case UdpSocket::Got::datagram:
        take(datagram, on_event);
    }
  }
  return true;
}

void UdpLayer::expire() { fragments_.expire(now_()); }

/// Whether a broadcast was sent from this interface, which receives it as well. A change of the
/// address is noticed within a second.
bool UdpLayer::is_own(std::uint32_t from) {
  constexpr std::uint64_t second = 1'000'000'000;
  const std::uint64_t now = now_();
  if (own_at_ == 0 || now - own_at_ >= second) {
    own_ = socket_->own_address();
    own_at_ = now;
  }
  return own_ != 0 && from == own_;
}

void UdpLayer::take(const UdpSocket::Datagram& came, const OnEvent& on_event) {
  const auto datagram =
      came.octets.size() > kMostDatagram ? std::nullopt : parse_datagram(came.octets);
  if (!datagram) {
    ++losses_.malformed;
    return;
  }
  if (!followers_.any(datagram->subject)) return;
  if (broadcasts_ && is_own(came.from)) return;
  if (!datagram->is_fragment) {
    followers_.hand_over(datagram->subject, came.from, datagram->data, came.unix_ns, on_event,
                         losses_);
    return;
  }
  const auto source = std::rotl(datagram->subject * salt_, 32) * salt_ + came.from;
  if (const auto event = fragments_.take(source, datagram->data, now_()))
    followers_.hand_over(datagram->subject, came.from, *event, came.unix_ns, on_event, losses_);
}

// --- what goes -----------------------------------------------------------------------------------

Sent UdpLayer::send(const control::Endpoint& /*endpoint*/, std::uint64_t subject, Octets event) {
  const std::uint32_t to = broadcasts_ ? INADDR_BROADCAST : group_of(subject);
  if (event.size() <= afp::kUdp.payload)
    return socket_->send(to, datagram_header(subject, false), event);
  auto fragments = afp::Fragments::of(afp::kUdp, event, number_++);
  if (!fragments) return Sent::too_long;
  const auto header = datagram_header(subject, true);
  while (const auto fragment = fragments->next())
    if (const Sent sent = socket_->send(to, header, *fragment); sent != Sent::sent) return sent;
  return Sent::sent;
}

Losses UdpLayer::losses() const {
  Losses out = losses_;
  const afp::Losses& of_fragments = fragments_.losses();
  out.malformed += of_fragments.malformed;
  out.incomplete += of_fragments.incomplete + of_fragments.late + of_fragments.repeated;
  out.crowded += of_fragments.crowded;
  out.in_socket = socket_->dropped();
  return out;
}

}  // namespace mlcca::relay
