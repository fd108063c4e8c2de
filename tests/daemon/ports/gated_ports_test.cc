// SPDX-License-Identifier: BSD-2-Clause
// The gates of the ports of a description, and of the next one.
#include "daemon/ports/gated_ports.hpp"

#include <gtest/gtest.h>

#include <string>

#include "daemon/ports/gate_slots.hpp"
#include "tests/daemon/ports/fake_gates.hpp"
#include "tests/daemon/ports/two_ports.hpp"

namespace mlcca {
namespace {

class GatedPortsTest : public ::testing::Test {
 protected:
  GatedPortsTest() {
    for (const int n : {0, 1})
      links_.emplace(10 + n, test::ethernet(10 + n, "eth" + std::to_string(n)));
    ports_.describe(test::two_ports(1), 0);
    follow();
  }
  void follow() {
    for (GatedPort& gated : ports_) {
      static_cast<void>(gated.port.match(links_, facts_of_));
      if (gated.port.problem().empty())
        ports_.attach(gated, *gated.port.link(links_), [](const auto&, const auto&, bool) {});
    }
  }
  Result<void> prepare(const core::System& system) {
    return ports_.prepare(system, 0, links_, facts_of_, [] {});
  }
  static core::GateRule rule(std::size_t port, std::optional<std::size_t> source_port = {}) {
    core::GateRule rule;
    rule.entry.port = port;
    rule.entry.source_port = source_port;
    rule.entry.subject = 0x4e6f626f64790000;
    if (source_port) rule.entry.direction = core::Direction::egress;
    return rule;
  }

  net::InterfaceTable links_;
  net::FactsOf facts_of_ = [](int) { return net::UdevFacts{}; };
  test::FakeHooks hooks_;
  GatedPorts ports_{test::load_into(hooks_), [](const std::string&) {
                      return Result<gates::Closing>(gates::Closing::closed);
                    }};
};

TEST_F(GatedPortsTest, APortOfTheSameNameKeepsItsGateInTheNextDescription) {
  ASSERT_TRUE(ports_.has_gate(1));
  core::System swapped = test::two_ports(1);
  std::swap(swapped.gateways[0].ports[0], swapped.gateways[0].ports[1]);
  ports_.describe(swapped, 0);
  EXPECT_EQ(ports_[0].ifindex(), 11);
  EXPECT_TRUE(ports_.has_gate(0)) << "before it is searched";
  EXPECT_EQ(hooks_.loaded, 2U);
}

TEST_F(GatedPortsTest, OfAnotherNetworkTheInterfaceIsMatchedAgain) {
  core::System renamed = test::two_ports(1);
  renamed.networks[0].name = "other";
  ports_.describe(renamed, 0);
  EXPECT_EQ(ports_[0].ifindex(), 0);
  EXPECT_FALSE(ports_.has_gate(0));
  EXPECT_FALSE(ports_.is_to_be_gated(10));
}

TEST_F(GatedPortsTest, WithoutMemoryForTheNextDescriptionNothingChanges) {
  hooks_.lacks_memory = true;
  EXPECT_TRUE(prepare(test::two_ports(1))) << "all it needs is there";
  ports_.gates().end_change();
  EXPECT_FALSE(prepare(test::two_ports(9)));
  EXPECT_FALSE(ports_.gates().must_go_back());
  EXPECT_EQ(hooks_.in_place[10], "eth0 for 2 slots");
}

TEST_F(GatedPortsTest, APortThatLacksItsGateAlreadyDoesNotStandInTheWay) {
  for (const int ifindex : {10, 11}) ports_.gates().forget(ifindex);
  EXPECT_TRUE(ports_.wants_gate(links_));
  hooks_.lacks_memory = true;
  EXPECT_TRUE(prepare(test::two_ports(9)));
}

TEST_F(GatedPortsTest, AnInterfaceOfAnotherKindGetsNoGate) {
  ports_.gates().forget(10);
  links_.at(10).is_ethernet = false;
  follow();
  EXPECT_FALSE(ports_.has_gate(0));
  EXPECT_FALSE(ports_.wants_gate(links_));
  EXPECT_EQ(
      ports_[0].problem(),
      "eth0 has no Ethernet frames, and there is a gate for CAN, Ethernet and IEEE 802.15.4 only");
}

TEST_F(GatedPortsTest, ASlotNamesTheInterfaceThatItsFramesComeFrom) {
  const auto slot = slot_of(rule(0, 1), ports_);
  ASSERT_TRUE(slot);
  EXPECT_EQ(slot->source, 11U);
  EXPECT_EQ(slot_of(rule(0), ports_)->source, 0U);
}

TEST_F(GatedPortsTest, FromAnInterfaceThatIsNotThereNoSlotIsNeeded) {
  links_.erase(11);
  follow();
  EXPECT_FALSE(slot_of(rule(0, 1), ports_));
  core::GateChanges changes;
  changes.add = {rule(0), rule(0, 1), rule(1)};
  const auto by_port = changes_by_port(changes, ports_);
  ASSERT_EQ(by_port.size(), 1U) << "port 1 has no gate";
  EXPECT_EQ(by_port.at(0).add.size(), 1U);
}

TEST_F(GatedPortsTest, WhatChangesGoesToTheGateOfItsPort) {
  core::GateChanges changes;
  changes.close = {rule(0).entry};
  changes.remove = {rule(1).entry};
  changes.open = {rule(1).entry};
  const auto by_port = changes_by_port(changes, ports_);
  ASSERT_EQ(by_port.size(), 2U);
  EXPECT_EQ(by_port.at(0).close.size(), 1U);
  EXPECT_TRUE(by_port.at(0).remove.empty());
  EXPECT_EQ(by_port.at(1).remove.size(), 1U);
  EXPECT_EQ(by_port.at(1).open.size(), 1U);
}

}  // namespace
}  // namespace mlcca
