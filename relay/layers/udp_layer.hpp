// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's events in UDP datagrams: to port 9999 of a multicast group for each subject, or as
// broadcasts to port 8888. datagram.hpp describes the datagrams.
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

/// The interface between a layer and its network, which tests replace. Addresses are IPv4 in host
/// byte order.
class UdpSocket {
 public:
  /// A received datagram.
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
  /// Receives datagrams to the group from now on.
  [[nodiscard]] virtual Result<void> join(std::uint32_t group) = 0;
  /// Ends join().
  virtual void leave(std::uint32_t group) = 0;
  /// `failed`: an error of an earlier send was reported; datagrams may follow. `gone`: the
  /// interface is gone.
  enum class Got : std::uint8_t { datagram, nothing, failed, gone };
  virtual Got receive(Datagram& to) = 0;
  /// Whether receive() has datagrams that a poll of the descriptor does not report.
  [[nodiscard]] virtual bool pending() const { return false; }
  /// Reads the reported errors of earlier sends, which keep the socket readable until they are
  /// read.
  virtual void read_errors() = 0;
  /// Sends one datagram that consists of the header and the data.
  virtual Sent send(std::uint32_t to, Octets header, Octets data) = 0;
  /// The interface's present address; 0: none.
  [[nodiscard]] virtual std::uint32_t own_address() const = 0;
  [[nodiscard]] virtual std::uint64_t dropped() const = 0;
};

[[nodiscard]] Result<std::unique_ptr<UdpSocket>> open_udp_socket(const control::Endpoint& endpoint);

/// The layer of a UDP network.
class UdpLayer : public Layer {
 public:
  static Result<std::unique_ptr<Layer>> open(const control::Endpoint& endpoint);
  /// `now`: CLOCK_MONOTONIC in ns.
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
  std::uint32_t own_ = 0;     ///< the interface's own address, used if it broadcasts
  std::uint64_t own_at_ = 0;  ///< when `own_` was read; 0: never
  std::map<std::uint32_t, std::set<std::uint64_t>> groups_;  ///< joined groups and the subjects
                                                             ///< followed in each
  std::deque<std::uint32_t> idle_;  ///< joined groups without followed subjects; the one used last
                                    ///< is at the end
  Followers<std::uint32_t> followers_;
  afp::Reassembly fragments_{afp::kUdp};
  std::uint64_t salt_;    ///< random, so that no sender can provoke a collision of two sources
  std::uint32_t number_;  ///< number of the next event that is fragmented
  Losses losses_;
};

}  // namespace mlcca::relay
