// SPDX-License-Identifier: BSD-2-Clause
// The daemon asks FAMOUSO's brokers for tags, and says why where it cannot.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "bpf/gate.h"
#include "tests/core/robot.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

using core::testing::kBridge;
using core::testing::kSecondCan;
using core::testing::robot;

/// The broker of the second bus deals the switch its tag.
core::System machine() {
  core::System system = robot(0);
  system.networks[kSecondCan].bindings.at(0).dynamic = true;
  system.networks[kSecondCan].bindings.at(0).id = 0;
  for (core::Port& port : system.gateways[kBridge].ports) {
    port.identity.name = system.networks[port.network].name;
    if (port.network == kSecondCan) port.node = 9;
  }
  return system;
}

class AskingForTags : public ::testing::Test {
 protected:
  void SetUp() override {
    bench_.self = kBridge;
    ASSERT_FALSE(bench_.start());
    for (std::size_t p = 0; p < bench_.gates().size(); ++p) {
      auto table = std::make_unique<gate_table>();
      bench_.gates().tables.push_back(std::move(table));
    }
  }
  /// Once a second.
  void second() {
    bench_.clock.monotonic += 1'000'000'000;
    bench_.round();
  }
  [[nodiscard]] std::vector<std::string> reasons() {
    auto all =
        std::get<control::Status>(bench_.ask(control::StatusRequest{}).reply.body).health.reasons;
    std::erase_if(all, [](const std::string& line) { return !line.contains("asked for a tag"); });
    return all;
  }
  [[nodiscard]] std::ptrdiff_t reports(const std::string& message) const {
    return std::ranges::count(bench_.published, message, &control::Event::message);
  }

  Bench bench_{machine()};
};

constexpr auto* kWhy =
    "no broker can be asked for a tag (systemctl status mlcca-can.socket): nobody listens";

TEST_F(AskingForTags, IsRepeatedUntilTheBrokerAnswers) {
  for (int i = 0; i < 4; ++i) second();
  ASSERT_GE(bench_.can.sent.size(), 2U);
  EXPECT_EQ(reasons(), std::vector<std::string>{});
}

TEST_F(AskingForTags, WhatHindersItIsAReasonOfTheHealthAndReportedOnce) {
  bench_.can.missing = "nobody listens";
  for (int i = 0; i < 8; ++i) second();
  EXPECT_EQ(bench_.can.sent.size(), 0U);
  EXPECT_EQ(reasons(), std::vector<std::string>{kWhy});
  EXPECT_EQ(reports(kWhy), 1);
  bench_.can.missing.clear();
  for (int i = 0; i < 40; ++i) second();
  EXPECT_GE(bench_.can.sent.size(), 1U);
  EXPECT_EQ(reasons(), std::vector<std::string>{});
  EXPECT_EQ(reports("brokers can be asked for tags again"), 1);
}

}  // namespace
}  // namespace mlcca::test
