// SPDX-License-Identifier: BSD-2-Clause
// The paper's robot as a System: two CAN buses and a bridge between them, to be varied by tests.
#pragma once
#include <string>

#include "core/admission/state.hpp"

namespace mlcca::core::testing {

inline constexpr Value kMs = 1'000'000;
inline constexpr std::size_t kRobotCan = 0;
inline constexpr std::size_t kSecondCan = 1;
inline constexpr std::size_t kBridge = 0;
inline constexpr std::uint32_t kEtag = 0x64;
inline constexpr std::uint8_t kSwitchNode = 0x20;
inline constexpr Subject kEmergency = 0xa4efeccc3210b497;

inline Place network(std::size_t i) { return {Place::Kind::network, i}; }
inline Place gateway(std::size_t i) { return {Place::Kind::gateway, i}; }

inline AttributeSet can_provision(Value omission = 0) {
  return AttributeSet{}
      .set(Attribute::latency, 5 * kMs)
      .set(Attribute::period, 1 * kMs)
      .set(Attribute::omission, omission)
      .set(Attribute::bandwidth, 10'000)
      .set(Attribute::max_payload, 8);
}

inline AttributeSet heart_beat() {
  return AttributeSet{}
      .set(Attribute::period, 50 * kMs)
      .set(Attribute::omission, 2)
      .set(Attribute::max_payload, 8);
}

inline Network can_network(const std::string& name) {
  Network n;
  n.name = name;
  n.profile = Profile::famouso;
  n.provision = can_provision();
  Binding binding;
  binding.id = kEtag;
  binding.extended = true;
  n.bindings.push_back(binding);
  return n;
}

inline Subscriber subscriber(const std::string& name, Place place, AttributeSet attributes) {
  Subscriber s;
  s.name = name;
  s.place = place;
  s.attributes = attributes;
  return s;
}

/// The switch on the second bus, the motors on the robot's; the bridge promises `omission`.
inline System robot(Value omission) {
  System system;
  system.name = "volksbot";
  EventChannel channel;
  channel.name = "emergency-switch";
  channel.subject = kEmergency;
  channel.attributes = heart_beat();
  system.channels.push_back(channel);
  system.networks = {can_network("robot-can"), can_network("second-can")};
  Gateway bridge;
  bridge.name = "bridge";
  bridge.provision =
      AttributeSet{}.set(Attribute::latency, 2 * kMs).set(Attribute::omission, omission);
  for (const std::size_t n : {kRobotCan, kSecondCan}) {
    Port port;
    port.network = n;
    port.identity.name = "can" + std::to_string(n);
    bridge.ports.push_back(port);
  }
  system.gateways.push_back(bridge);
  Publisher publisher;
  publisher.name = "switch";
  publisher.place = network(kSecondCan);
  publisher.attributes = heart_beat();
  publisher.node = kSwitchNode;
  system.publishers.push_back(publisher);
  system.subscribers.push_back(subscriber("motors", network(kRobotCan), heart_beat()));
  return system;
}

inline const Verdict& only_verdict(const State& state) {
  return state.decisions()[0].verdicts.at(0);
}

}  // namespace mlcca::core::testing
