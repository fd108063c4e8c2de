// SPDX-License-Identifier: BSD-2-Clause
// Publishers of one subject on one bus, planned as the daemon does it: what came in as a frame of
// one of them leaves as a frame of that one, whatever was done to its identifier on the way.
#include <gtest/gtest.h>

#include "daemon/gates/entry_slot.hpp"
#include "tests/bpf/loaded_gate.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::test {
namespace {

using core::testing::kBridge;
using core::testing::kRobotCan;
using core::testing::kSecondCan;
using gates::Direction;

constexpr std::uint8_t kFirst = core::testing::kSwitchNode;
constexpr std::uint8_t kSecond = 9;

constexpr std::uint32_t famouso(std::uint8_t node, std::uint32_t etag = core::testing::kEtag) {
  return CAN_EFF_FLAG | 0x1f400000U | std::uint32_t{node} << 14 | etag;
}

/// Two switches on the second bus.
core::System two_switches() {
  core::System system = core::testing::robot(0);
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "second switch";
  system.publishers[1].node = kSecond;
  return system;
}

/// Gates of the bridge, both on the interface kIfindex: what one passes the other may let out.
class Publishers : public ::testing::Test {
 protected:
  void plan(const core::System& system) {
    const bool raw = system.networks[kRobotCan].profile == core::Profile::raw;
    exit_ = raw ? &LoadedGate::with() : &entry_;
    for (const core::GateRule& rule : core::State(system).gate_state(kBridge)) {
      gates::SlotSpec slot = gates::slot_of(rule, core::NetworkKind::can, kIfindex);
      slot.per_frame = slot.per_byte = slot.tolerance = 0;
      (rule.entry.direction == core::Direction::ingress ? &entry_ : exit_)->admit({slot});
    }
  }

  /// What enters with one identifier leaves with another.
  bool passes(std::uint32_t entering, std::uint32_t leaving) {
    const auto entered = entry_.run(Direction::ingress, frame(entering, 8));
    EXPECT_FALSE(entered.dropped);
    return !exit_
                ->run(Direction::egress, frame(leaving, 8),
                      {.mark = entered.mark, .ingress_ifindex = kIfindex})
                .dropped;
  }

  LoadedGate& entry_ = LoadedGate::with({.profile = GATE_PROFILE_FAMOUSO});
  LoadedGate* exit_ = nullptr;
};

TEST_F(Publishers, DoNotLeaveAsOneAnother) {
  plan(two_switches());
  EXPECT_TRUE(passes(famouso(kFirst), famouso(kFirst)));
  EXPECT_TRUE(passes(famouso(kSecond), famouso(kSecond)));
  EXPECT_FALSE(passes(famouso(kFirst), famouso(kSecond)));
  EXPECT_FALSE(passes(famouso(kSecond), famouso(kFirst)));
}

TEST_F(Publishers, LeaveWithTheIdentifierThatTheOtherBusHasForThem) {
  core::System system = two_switches();
  constexpr std::uint32_t etag = core::testing::kEtag + 1;
  system.networks[kRobotCan].bindings[0].id = etag;
  plan(system);
  EXPECT_TRUE(passes(famouso(kFirst), famouso(kFirst, etag)));
  EXPECT_TRUE(passes(famouso(kSecond), famouso(kSecond, etag)));
  EXPECT_FALSE(passes(famouso(kFirst), famouso(kSecond, etag)));
}

TEST_F(Publishers, ThatShareAnIdentifierOnTheOtherBusLeaveAsFarAsTheyAreGranted) {
  core::System system = two_switches();
  system.networks[kRobotCan].profile = core::Profile::raw;
  constexpr std::uint32_t one = CAN_EFF_FLAG | core::testing::kEtag;
  plan(system);
  EXPECT_TRUE(passes(famouso(kFirst), one));
  EXPECT_TRUE(passes(famouso(kSecond), one));
  entry_.reset();
  exit_->reset();
  // Less often than it is needed.
  system.publishers[1].attributes.set(Attribute::period, 51 * core::testing::kMs);
  core::Subscriber logger = system.subscribers[0];
  logger.name = "logger";
  logger.place = core::testing::gateway(kBridge);
  logger.attributes = AttributeSet{};
  system.subscribers.push_back(logger);
  plan(system);
  EXPECT_TRUE(passes(famouso(kFirst), one));
  EXPECT_FALSE(passes(famouso(kSecond), one));
}

}  // namespace
}  // namespace mlcca::test
