// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's events in UDP datagrams to port 9999 and a multicast group of their own, or to port
// 8888 and everybody; datagram.hpp says what they hold.
#pragma once
#include <netinet/in.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "relay/afp.hpp"
#include "relay/layers/datagram.hpp"
#include "relay/layers/followers.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

class UdpLayer : public Layer {
 public:
  static Result<std::unique_ptr<Layer>> open(const control::Endpoint& endpoint);

  [[nodiscard]] int fd() const override { return socket_.get(); }
  [[nodiscard]] Result<void> follow(Follower follower, const control::Endpoint& endpoint,
                                    std::uint64_t subject, std::size_t longest) override;
  void leave(Follower follower, const control::Endpoint& endpoint, std::uint64_t subject) override;
  bool receive(std::size_t most, const OnEvent& on_event) override;
  void expire() override;
  [[nodiscard]] bool holds_parts() const override { return fragments_.begun() != 0; }
  Sent send(const control::Endpoint& endpoint, std::uint64_t subject, Octets event) override;
  [[nodiscard]] Losses losses() const override;

 private:
  /// Sockets that do nothing but stay in groups: one socket may be in 20 (igmp_max_memberships).
  struct Member {
    Fd socket;
    std::size_t groups = 0;
  };

  UdpLayer(Fd socket, const control::Endpoint& endpoint);
  [[nodiscard]] Result<void> join(std::uint32_t group);
  void read_errors();
  [[nodiscard]] bool is_own(std::uint32_t from, std::uint64_t now);
  void take(Octets octets, std::uint32_t from, std::uint64_t unix_ns, const OnEvent& on_event);
  Sent send_one(const sockaddr_in& to, std::uint64_t subject, bool is_fragment, Octets data);

  Fd socket_;
  std::uint32_t ifindex_;
  std::string interface_;
  bool broadcasts_;
  std::uint32_t own_ = 0;     ///< address, where it broadcasts
  std::uint64_t own_at_ = 0;  ///< when it was looked at; 0: never
  std::vector<Member> members_;
  std::set<std::uint32_t> groups_;
  Followers<std::uint32_t> followers_;  ///< by IPv4 address, in the order of the host
  afp::Reassembly fragments_{afp::kUdp};
  std::uint64_t salt_;    ///< so that nobody can make two sources one
  std::uint32_t number_;  ///< of the next event that is fragmented
  Losses losses_;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace mlcca::relay
