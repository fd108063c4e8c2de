// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's events in UDP datagrams to port 9999 and a multicast group of their own, or to port
// 8888 and everybody; datagram.hpp says what they hold.
#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "relay/afp.hpp"
#include "relay/layers/datagram.hpp"
#include "relay/layers/followers.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// Between a layer and its interface, so that a test needs none. Addresses are of IPv4, in the
/// order of the host.
class UdpSocket {
 public:
  struct Datagram {
    Octets octets;  ///< valid until the next call
    std::uint32_t from = 0;
    std::uint64_t unix_ns = 0;
  };

  UdpSocket() = default;
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;
  UdpSocket(UdpSocket&&) = delete;
  UdpSocket& operator=(UdpSocket&&) = delete;
  virtual ~UdpSocket() = default;

  [[nodiscard]] virtual int fd() const = 0;
  /// Datagrams to the group come from now on.
  [[nodiscard]] virtual Result<void> join(std::uint32_t group) = 0;
  /// A group that was joined.
  virtual void leave(std::uint32_t group) = 0;
  /// `failed`: an earlier datagram that was sent; there may be more.
  enum class Got : std::uint8_t { datagram, nothing, failed, gone };
  virtual Got receive(Datagram& to) = 0;
  /// What is reported of datagrams that were sent before makes the socket readable until it is
  /// read.
  virtual void read_errors() = 0;
  virtual Sent send(std::uint32_t to, Octets header, Octets data) = 0;
  /// That the interface has now; 0: none.
  [[nodiscard]] virtual std::uint32_t own_address() const = 0;
  [[nodiscard]] virtual std::uint64_t dropped() const = 0;
};

[[nodiscard]] Result<std::unique_ptr<UdpSocket>> open_udp_socket(const control::Endpoint& endpoint);

class UdpLayer : public Layer {
 public:
  static Result<std::unique_ptr<Layer>> open(const control::Endpoint& endpoint);
  /// `now`: CLOCK_MONOTONIC, ns.
  UdpLayer(std::unique_ptr<UdpSocket> socket, bool broadcasts,
           std::uint64_t (*now)() = monotonic_ns);

  [[nodiscard]] int fd() const override { return socket_->fd(); }
  [[nodiscard]] Result<void> follow(Follower follower, const control::Endpoint& endpoint,
                                    std::uint64_t subject, std::size_t longest) override;
  void leave(Follower follower, const control::Endpoint& endpoint, std::uint64_t subject) override;
  bool receive(std::size_t most, const OnEvent& on_event) override;
  void expire() override;
  [[nodiscard]] bool holds_parts() const override { return fragments_.begun() != 0; }
  Sent send(const control::Endpoint& endpoint, std::uint64_t subject, Octets event) override;
  [[nodiscard]] Losses losses() const override;

 private:
  [[nodiscard]] Result<void> follow_group(std::uint64_t subject);
  void leave_group(std::uint64_t subject);
  [[nodiscard]] bool is_own(std::uint32_t from);
  void take(const UdpSocket::Datagram& came, const OnEvent& on_event);

  std::unique_ptr<UdpSocket> socket_;
  bool broadcasts_;
  std::uint64_t (*now_)();
  std::uint32_t own_ = 0;                                    ///< address, where it broadcasts
  std::uint64_t own_at_ = 0;                                 ///< when it was read; 0: never
  std::map<std::uint32_t, std::set<std::uint64_t>> groups_;  ///< and what is followed in each
  std::deque<std::uint32_t> idle_;                           ///< nothing is; the latest is last
  Followers<std::uint32_t> followers_;
  afp::Reassembly fragments_{afp::kUdp};
  std::uint64_t salt_;    ///< so that nobody can make two sources one
  std::uint32_t number_;  ///< of the next event that is fragmented
  Losses losses_;
};

}  // namespace mlcca::relay
