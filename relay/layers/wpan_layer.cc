// SPDX-License-Identifier: BSD-2-Clause
#include "relay/layers/wpan_layer.hpp"

#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/big_endian.hpp"
#include "base/handle.hpp"
#include "relay/layers/sockets.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint16_t kBroadcast = 0xffff;
constexpr std::uint16_t kFirstGroup = 0xfffe;  // short addresses from here on are not assignable;
                                               // 0xfffe: none is assigned

// Definitions of the kernel's <net/af_ieee802154.h>, which no header of user space has.
constexpr int kShort = 2;
constexpr int kExtended = 3;
constexpr int kLevel = 0;              // SOL_IEEE802154
constexpr int kAskForAcknowledge = 0;  // WPAN_WANTACK

struct WpanAddress {
  sa_family_t family;
  int type;
  std::uint16_t pan;
  union {
    std::array<std::uint8_t, 8> extended;
    std::uint16_t brief;
  };
};
static_assert(sizeof(WpanAddress) == 20);

std::string hexadecimal(unsigned number, unsigned digits) {
  constexpr unsigned bits = 4;
  std::string out;
  while (digits-- > 0) out += "0123456789abcdef"[number >> bits * digits & 0xfU];
  return out;
}

std::string text_of(const WpanAddress& address) {
  if (address.type == kShort) return short_address(address.pan, address.brief);
  if (address.type == kExtended) return extended_address(address.extended);
  return {};
}

/// The PAN and the short address of an interface.
Result<WpanAddress> own_address(const Fd& socket, const std::string& interface) {
  ifreq asked{};
  interface.copy(asked.ifr_name, sizeof asked.ifr_name - 1);
  // NOLINTNEXTLINE(*-vararg): the sockets API
  const bool has_address = ::ioctl(socket.get(), SIOCGIFADDR, &asked) == 0;
  if (!has_address && errno != EADDRNOTAVAIL) return system_error(interface);
  WpanAddress own{};
  std::memcpy(&own, &asked.ifr_addr, sizeof own);
  if (!has_address || own.brief >= kFirstGroup)
    return fail(interface + " has no PAN or no short address: set both by iwpan while it is down");
  return own;
}

class DatagramSocket : public WpanSocket {
 public:
  DatagramSocket(Fd socket, std::uint16_t pan) : socket_(std::move(socket)) {
    to_.family = AF_IEEE802154;
    to_.type = kShort;
    to_.pan = pan;
    to_.brief = kBroadcast;
  }

  [[nodiscard]] int fd() const override { return socket_.get(); }
  Got receive(Frame& to) override;
  Sent send(Octets payload) override {
    // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
    const auto* const broadcast = reinterpret_cast<const sockaddr*>(&to_);
    const ssize_t n = ::sendto(socket_.get(), payload.data(), payload.size(),
                               MSG_DONTWAIT | MSG_NOSIGNAL, broadcast, sizeof to_);
    return n >= 0 ? Sent::sent : failure_of_send();
  }
  [[nodiscard]] std::uint64_t dropped() const override { return dropped_; }

 private:
  Fd socket_;
  WpanAddress to_{};
  std::uint64_t dropped_ = 0;
};

WpanSocket::Got DatagramSocket::receive(Frame& to) {
  WpanAddress from{};
  const auto [n, flags, said] =
      receive_into(socket_, to.payload.data(), to.payload.size(), &from, sizeof from, MSG_TRUNC);
  if (n < 0) return errno == ENODEV || errno == ENXIO ? Got::gone : Got::nothing;
  if (said.says_dropped) dropped_ = said.dropped;
  to.size = static_cast<std::size_t>(n);
  if ((flags & MSG_TRUNC) != 0) to.size = kWpanPayload + 1;
  to.from = text_of(from);
  to.unix_ns = said.unix_ns;
  return Got::frame;
}

}  // namespace

std::string extended_address(const std::array<std::uint8_t, 8>& octets) {
  std::string out;
  for (const std::uint8_t octet : octets) {
    if (!out.empty()) out += ':';
    out += hexadecimal(octet, 2);
  }
  return out;
}

std::string short_address(std::uint16_t pan, std::uint16_t address) {
  return "0x" + hexadecimal(pan, 4) + ":0x" + hexadecimal(address, 4);
}

Result<std::unique_ptr<WpanSocket>> open_wpan_socket(const std::string& interface) {
  Fd socket(::socket(AF_IEEE802154, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket && errno == EAFNOSUPPORT)
    return fail(
        "the kernel has no sockets of IEEE 802.15.4 here: load the module "
        "ieee802154_socket, and run in the first network namespace");
  if (!socket) return system_error("a socket of IEEE 802.15.4");
  const auto own = own_address(socket, interface);
  if (!own) return std::unexpected(own.error());
  // Broadcasts are not acknowledged.
  const int no = 0;
  if (::setsockopt(socket.get(), kLevel, kAskForAcknowledge, &no, sizeof no) != 0)
    return system_error("WPAN_WANTACK");
  if (const auto done = ask_for_times(socket); !done) return std::unexpected(done.error());
  widen(socket);
  // This socket family identifies the interface by its address.
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&*own), sizeof *own) != 0)
    return system_error("bind to " + text_of(*own));
  return std::unique_ptr<WpanSocket>(new DatagramSocket(std::move(socket), own->pan));
}

Result<std::unique_ptr<Layer>> WpanLayer::open(const control::Endpoint& endpoint) {
  auto socket = open_wpan_socket(endpoint.interface);
  if (!socket) return std::unexpected(socket.error());
  return std::unique_ptr<Layer>(new WpanLayer(std::move(*socket)));
}

Result<void> WpanLayer::follow(Follower follower, const control::Endpoint& endpoint,
                               std::uint64_t subject, std::size_t longest) {
  followers_.add(follower, subject, endpoint.address, longest);
  return {};
}

void WpanLayer::leave(Follower follower, const control::Endpoint& /*endpoint*/,
                      std::uint64_t subject) {
  followers_.remove(follower, subject);
}

bool WpanLayer::receive(std::size_t most, const OnEvent& on_event) {
  WpanSocket::Frame frame;
  for (std::size_t count = 0; count < most; ++count) {
    const auto got = socket_->receive(frame);
    if (got == WpanSocket::Got::gone) return false;
    if (got == WpanSocket::Got::nothing) return true;
    if (frame.size < kSubjectOctets || frame.size > kWpanPayload) {
      ++losses_.malformed;
      continue;
    }
    const Octets payload = Octets(frame.payload).first(frame.size);
    followers_.hand_over(from_big_endian(payload.first(kSubjectOctets)), frame.from,
                         payload.subspan(kSubjectOctets), frame.unix_ns, on_event, losses_);
  }
  return true;
}

Sent WpanLayer::send(const control::Endpoint& /*endpoint*/, std::uint64_t subject, Octets event) {
  std::array<std::uint8_t, kWpanPayload> payload{};
  if (event.size() > payload.size() - kSubjectOctets) return Sent::too_long;
  std::ranges::copy(big_endian(subject), payload.begin());
  std::ranges::copy(event, payload.begin() + kSubjectOctets);
  return socket_->send(Octets(payload).first(kSubjectOctets + event.size()));
}

Losses WpanLayer::losses() const {
  Losses out = losses_;
  out.in_socket = socket_->dropped();
  return out;
}

}  // namespace mlcca::relay
