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
