// SPDX-License-Identifier: BSD-2-Clause
// The robot with lines, and what an inspection of it finds.
#pragma once
#include <gtest/gtest.h>

#include <vector>

#include "core/design/inspect.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {

using Ids = std::vector<FindingId>;
using Id = FindingId;

inline constexpr Value kPercent = 10'000'000;  // of a loss, in 1e-9
inline constexpr int kPublisherLine = 50;
inline constexpr int kSubscriberLine = 60;

/// robot() with lines, as a description has them.
inline System described(Value omission) {
  System system = robot(omission);
  system.files = {"s.xml"};
  system.channels[0].origin = {0, 1};
  system.networks[kRobotCan].origin = {0, 10};
  system.networks[kSecondCan].origin = {0, 20};
  system.gateways[kBridge].origin = {0, 30};
  system.publishers[0].origin = {0, kPublisherLine};
  system.subscribers[0].origin = {0, kSubscriberLine};
  return system;
}

/// `count` heart-beats, each 160 bytes/s, where the first bus has `capacity`.
inline System heart_beats(std::size_t count, Value capacity) {
  System system = described(0);
  system.networks[kRobotCan].provision.set(Attribute::bandwidth, capacity);
  for (std::size_t i = 1; i < count; ++i) {
    auto channel = system.channels[0];
    channel.name = "channel-" + std::to_string(i);
    channel.subject += i;
    system.channels.push_back(channel);
    for (Network& n : system.networks) {
      auto binding = n.bindings[0];
      binding.channel = i;
      binding.id += static_cast<std::uint32_t>(i);
      n.bindings.push_back(binding);
    }
    auto publisher = system.publishers[0];
    publisher.name = "sender-" + std::to_string(i);
    publisher.channel = i;
    system.publishers.push_back(publisher);
    auto listener = system.subscribers[0];
    listener.name = "listener-" + std::to_string(i);
    listener.channel = i;
    system.subscribers.push_back(listener);
  }
  return system;
}

inline Ids ids_of(const Inspection& inspection) {
  Ids out;
  for (const Finding& f : inspection.findings) out.push_back(f.id);
  return out;
}

inline const Finding& only(const Inspection& inspection) {
  EXPECT_EQ(inspection.findings.size(), 1U);
  static const Finding none;
  return inspection.findings.empty() ? none : inspection.findings.front();
}

}  // namespace mlcca::core::testing
