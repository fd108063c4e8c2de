// SPDX-License-Identifier: BSD-2-Clause
// Two gateways on a network that carries all that the description promises: an admission over both
// has nothing to reserve, and needs the agreement of the other gateway all the same.
#pragma once
#include <string>

#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {

/// Programs on g0 send c0 to a network of datagrams, where somebody receives it.
inline core::System with_datagrams() {
  core::System system = two_gateways();
  core::Network& lan = system.networks[kSharedBus];
  lan.kind = core::NetworkKind::udp_multicast;
  lan.profile = core::Profile::famouso;
  lan.bus = {};
  lan.bindings.clear();
  lan.provision = AttributeSet{}
                      .set(Attribute::latency, kMs)
                      .set(Attribute::period, kMs)
                      .set(Attribute::max_payload, 64);
  system.publishers.front().place = {core::Place::Kind::gateway, 0};
  system.publishers.front().uid = 1000;
  return system;
}

class MembersAcross : public MembershipBench {
 protected:
  MembersAcross() : MembershipBench(with_datagrams()) {}
  static control::Admit program_on(const std::string& gateway) {
    control::Admit request;
    request.channel = "c0";
    request.to = gateway;
    request.subscriber = request.key = "program";
    return request;
  }
};

}  // namespace mlcca::test
