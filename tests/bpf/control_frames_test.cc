// SPDX-License-Identifier: BSD-2-Clause
// Control traffic of each profile through the real gate, as the gateway sets it up: frames from the
// documents pass in both directions, their neighbours do not, and neither does more than the rate.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/clock.hpp"
#include "core/gates/control_traffic.hpp"
#include "daemon/gates/counters.hpp"
#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {
namespace {

using core::Profile;
using gates::Direction;

constexpr std::uint32_t kEff = CAN_EFF_FLAG;

struct Row {
  std::string name;
  Profile profile;
  std::uint32_t can_id;
  unsigned length;
  bool passes;
};

std::uint32_t gate_profile(Profile profile) {
  switch (profile) {
    case Profile::famouso:
      return GATE_PROFILE_FAMOUSO;
    case Profile::j1939:
      return GATE_PROFILE_J1939;
    case Profile::cyphal:
      return GATE_PROFILE_CYPHAL;
    default:
      return GATE_PROFILE_CANOPEN;
  }
}

std::vector<gates::SlotSpec> slots_of(Profile profile) {
  core::System system;
  system.networks.emplace_back().profile = profile;
  if (profile == Profile::famouso) system.networks[0].subscribe_tag = 0x3fff;
  system.gateways.emplace_back().ports.emplace_back();
  std::vector<gates::SlotSpec> slots;
  for (const auto& rule : core::control_rules(system, 0)) {
    gates::SlotSpec s;
    const bool in = rule.entry.direction == core::Direction::ingress;
    s.direction = in ? Direction::ingress : Direction::egress;
    s.pass = rule.pass;
    s.max_len = rule.entry.max_length;
    s.formats = static_cast<std::uint8_t>(GATE_CLASSIC | (rule.entry.fd ? GATE_FD : 0));
    s.id = rule.entry.id;
    s.mask = rule.entry.mask;
    if (!in) s.source = rule.entry.from_kernel ? GATE_NO_SOURCE : 0;
    if (!in && !rule.entry.from_kernel) s.uid = rule.entry.uid;
    s.per_frame = rule.policing.per_frame;
    s.tolerance = rule.policing.tolerance;
    slots.push_back(s);
  }
  return slots;
}

std::vector<Row> rows() {
  constexpr auto fam = Profile::famouso;
  constexpr auto j = Profile::j1939;
  constexpr auto cy = Profile::cyphal;
  constexpr auto co = Profile::canopen;
  return {
      // FAMOUSO's configuration of the node "node0001", from its first stage to its last.
      {"FirstStage", fam, kEff | 0x1f7d8001, 0, true},
      {"FirstStageAnswer", fam, kEff | 0x1f7fc000, 8, true},
      {"LastStage", fam, kEff | 0x1f404001, 0, true},
      {"NodeIsAssigned", fam, kEff | 0x1f5f4000, 8, true},
      {"StageWithPayload", fam, kEff | 0x1f7d8001, 1, false},
      {"StageOfRealTime", fam, kEff | 0x003d8001, 0, false},
      {"TagIsAskedFor", fam, kEff | 0x1f5f4002, 8, true},
      {"TagIsGiven", fam, kEff | 0x1f5fc004, 8, true},
      {"TagIsGivenByANode", fam, kEff | 0x1f5f4004, 8, false},
      {"OldSupply", fam, kEff | 0x1f5fc003, 8, false},
      {"Event", fam, kEff | 0x1f5f7ffe, 8, false},
      // A node announces what it subscribes by an event of the subject SUBSCRIB, whose tag is
      // 0x3fff.
      {"Subscription", fam, kEff | 0x1f5fbfff, 8, true},
      {"SubscriptionOfAnotherNode", fam, kEff | 0x1f403fff, 8, true},
      {"SubscriptionInFragments", fam, kEff | 0x1f7fbfff, 8, false},
      {"SubscriptionOfRealTime", fam, kEff | 0x001fbfff, 8, false},
      // SAE J1939-81: address claimed and cannot claim; J1939-21: request, acknowledgement, and a
      // broadcast announcement with its packet, which no description here has named.
      {"AddressClaimed", j, kEff | 0x18eeff80, 8, true},
      {"CannotClaim", j, kEff | 0x18eefffe, 8, true},
      {"ClaimToSomebody", j, kEff | 0x18ee2180, 8, false},
      {"Request", j, kEff | 0x18eafffe, 3, true},
      {"RequestToSomebody", j, kEff | 0x18ea2180, 3, true},
      {"Acknowledgement", j, kEff | 0x18e8ff21, 8, true},
      {"Announcement", j, kEff | 0x1cecff80, 8, false},
      {"Packet", j, kEff | 0x1cebff80, 8, false},
      {"ProprietaryGroup", j, kEff | 0x18ef2180, 8, false},
      {"ClaimOfTheOtherPage", j, kEff | 0x19eeff80, 8, false},
      // Cyphal Specification v1.0: heartbeat of node 42; node-id allocation, asked anonymously.
      {"CyphalHeartbeat", cy, kEff | 0x107d552a, 8, true},
      {"Allocation", cy, kEff | 0x117fe655, 8, true},
      {"AnonymousHeartbeat", cy, kEff | 0x117d552a, 8, false},
      {"GetInfo", cy, kEff | 0x136b957b, 1, false},
      {"OtherSubject", cy, kEff | 0x1013373b, 8, false},
      // CiA 301, table 39.
      {"Nmt", co, 0x000, 2, true},
      {"NmtTooLong", co, 0x000, 3, false},
      {"Sync", co, 0x080, 0, true},
      {"SyncWithCounter", co, 0x080, 1, true},
      {"EmergencyOfNode1", co, 0x081, 8, true},
      {"EmergencyOfNode127", co, 0x0ff, 8, true},
      {"Time", co, 0x100, 6, true},
      {"BehindTime", co, 0x101, 6, false},
      {"HeartbeatOfNode127", co, 0x77f, 1, true},
      {"HeartbeatTooLong", co, 0x701, 2, false},
      {"NodeGuarding", co, CAN_RTR_FLAG | 0x701, 1, false},
      {"Pdo", co, 0x181, 8, false},
      {"Sdo", co, 0x601, 8, false},
  };
}

class ControlFrames : public ::testing::TestWithParam<Row> {};

TEST_P(ControlFrames, PassBothWaysOrNeither) {
  auto& gate = LoadedGate::with({.profile = gate_profile(GetParam().profile)});
  gate.admit(slots_of(GetParam().profile));
  const auto bytes = frame(GetParam().can_id, GetParam().length);
  const auto in = gate.run(Direction::ingress, bytes);
  EXPECT_EQ(in.dropped, !GetParam().passes);
  EXPECT_EQ(gate.run(Direction::egress, bytes, {.local = true}).dropped, !GetParam().passes);
  EXPECT_TRUE(
      gate.run(Direction::egress, bytes, {.mark = in.mark, .ingress_ifindex = kIfindex}).dropped)
      << "it never crosses a gateway";
}

INSTANTIATE_TEST_SUITE_P(Documents, ControlFrames, ::testing::ValuesIn(rows()),
                         [](const auto& row) { return row.param.name; });

TEST(ControlRate, IsKeptByTheGate) {
  auto& gate = LoadedGate::with({.profile = GATE_PROFILE_CANOPEN});
  gate.admit(slots_of(Profile::canopen));
  // TIME: ten a second, and two more at once.
  int passed = 0;
  const std::uint64_t began = monotonic_ns();
  for (int i = 0; i < 50; ++i)
    if (!gate.run(Direction::ingress, frame(0x100, 6)).dropped) ++passed;
  const auto tenths = static_cast<int>((monotonic_ns() - began) / 100'000'000);
  EXPECT_GE(passed, 3);
  EXPECT_LE(passed, 3 + tenths + 1);
  EXPECT_EQ(gates::reason_counters(gate.cpus(), Direction::ingress).at(GATE_R_EXCESS),
            static_cast<unsigned>(50 - passed));
}

}  // namespace
}  // namespace mlcca::test
