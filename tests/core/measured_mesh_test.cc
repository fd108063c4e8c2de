// SPDX-License-Identifier: BSD-2-Clause
// Meshes whose links are measured: what is said of them before anything is known, and why they
// carry nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>

#include "core/inspect.hpp"
#include "core/text.hpp"
#include "tests/core/inspected.hpp"

namespace mlcca::core::testing {
namespace {

constexpr std::size_t kBus = 0;
constexpr std::size_t kAir = 1;
constexpr Value kFiftyMs = 50 * kMs;

/// A heart-beat every 50 ms, from a bus of 500 kbit/s into a mesh: gateway g, then two links.
System measured() {
  System system;
  system.files = {"s.xml"};
  EventChannel channel;
  channel.name = "beat";
  channel.subject = 1;
  channel.attributes.set(Attribute::period, kFiftyMs)
      .set(Attribute::max_payload, 8)
      .set(Attribute::omission, 4);
  system.channels = {channel};

  Network bus;
  bus.name = "bus";
  bus.profile = Profile::raw;
  bus.bus.bitrate = 500'000;
  bus.provision.set(Attribute::omission, 0);
  Binding binding;
  binding.id = 1;
  bus.bindings = {binding};

  Network air;
  air.name = "air";
  air.kind = NetworkKind::mesh;
  air.mesh.emplace();
  air.mesh->per_hop.set(Attribute::latency, 10 * kMs)
      .set(Attribute::jitter, 5 * kMs)
      .set(Attribute::omission, 1);
  air.mesh->nodes = {{"a", "a", 0, {}}, {"b", "b", {}, {}}, {"c", "c", {}, {}}};
  air.mesh->sources.resize(1);
  air.mesh->sources[0].kind = mesh::SourceKind::nl80211;
  air.mesh->sources[0].interface = "mesh0";
  system.networks = {bus, air};

  Gateway gateway;
  gateway.name = "g";
  gateway.provision.set(Attribute::latency, kMs)
      .set(Attribute::jitter, 0)
      .set(Attribute::omission, 0);
  gateway.ports.resize(2);
  gateway.ports[kAir].network = kAir;
  gateway.ports[kAir].identity.name = "mesh0";
  system.gateways = {gateway};

  Publisher publisher;
  publisher.name = "p";
  publisher.place = network(kBus);
  publisher.attributes = channel.attributes;
  system.publishers = {publisher};
  system.subscribers = {subscriber("s", network(kAir), channel.attributes)};
  system.subscribers[0].mesh_node = 2;
  return system;
}

/// The same the other way round.
System measured_first() {
  System system = measured();
  system.publishers[0].place = network(kAir);
  system.publishers[0].mesh_node = 2;
  system.subscribers[0].place = network(kBus);
  system.subscribers[0].mesh_node.reset();
  return system;
}

struct Checked {
  Inspection inspection;
  Verdict verdict;
};

Checked check(const System& system) {
  Checked out;
  out.inspection =
      inspect(system, {}, [&](std::size_t, const Decision& decision, std::span<const Finding>) {
        out.verdict = decision.verdicts.at(0);
      });
  return out;
}

Value provided(const Verdict& verdict, std::size_t hop, Attribute attribute) {
  return verdict.hops.at(hop).provision[attribute];
}

TEST(MeasuredMeshTest, AtDesignTimeItGivesAtBestWhatOneLinkStates) {
  const Checked checked = check(measured());
  EXPECT_EQ(only(checked.inspection).id, Id::run_time) << only(checked.inspection).text;
  const std::size_t mesh_hop = 2;
  EXPECT_EQ(provided(checked.verdict, mesh_hop, Attribute::omission), 1U);
  EXPECT_EQ(provided(checked.verdict, mesh_hop, Attribute::latency), 10 * kMs);
  EXPECT_TRUE(checked.verdict.hops.at(mesh_hop).provision.is_dynamic(Attribute::latency));
}

TEST(MeasuredMeshTest, AtDesignTimeItLeavesTheBusBeforeItTheRestOfTheDeadline) {
  const Checked checked = check(measured());
  ASSERT_EQ(checked.verdict.media.size(), 1U);
  EXPECT_EQ(checked.verdict.media[0].guaranteed, kFiftyMs - 10 * kMs - kMs);
}

TEST(MeasuredMeshTest, AtDesignTimeTheBusBehindItInheritsTheJitterThatOneLinkStates) {
  InspectedBuses buses;
  const System system = measured_first();
  const Inspection inspection = inspect(system, {}, {}, &buses);
  EXPECT_EQ(only(inspection).id, Id::run_time) << only(inspection).text;
  ASSERT_EQ(buses.messages.size(), 1U);
  EXPECT_EQ(buses.messages[0].message.value().jitter, 5 * kMs);
}

TEST(MeasuredMeshTest, WhatOneLinkCannotGiveNoWayCan) {
  System system = measured();
  system.networks[kAir].mesh->per_hop.set(Attribute::latency, 2 * kFiftyMs);
  const Checked checked = check(system);
  ASSERT_FALSE(checked.inspection.findings.empty());
  EXPECT_EQ(checked.inspection.findings[0].id, Id::hop_unfit);
  EXPECT_EQ(checked.inspection.findings[0].provided, "100 ms");
}

TEST(MeasuredMeshTest, WhatNoLinkStatesIsToBeStatedInPerHop) {
  System system = measured();
  system.networks[kAir].mesh->per_hop.clear(Attribute::omission);
  const Checked checked = check(system);
  ASSERT_FALSE(checked.inspection.findings.empty());
  EXPECT_TRUE(checked.inspection.findings[0].hint.starts_with("state Omission of PerHop of air"))
      << checked.inspection.findings[0].hint;
}

TEST(MeasuredMeshTest, LossMayBeMeasured) {
  System system = measured();
  system.channels[0].attributes.set(Attribute::packet_loss, kPercent);
  system.subscribers[0].attributes.set(Attribute::packet_loss, kPercent);
  system.networks[kBus].provision.set(Attribute::packet_loss, 0);
  system.gateways[0].provision.set(Attribute::packet_loss, 0);
  EXPECT_EQ(only(check(system).inspection).id, Id::run_time);
}

TEST(MeasuredMeshTest, WithoutDescribedNodesNothingEntersIt) {
  System system = measured();
  system.networks[kAir].mesh->nodes.clear();
  system.subscribers[0].mesh_node.reset();
  const Checked checked = check(system);
  EXPECT_EQ(checked.verdict.obstacle, Obstacle::no_path);
  EXPECT_TRUE(only(checked.inspection)
                  .text.ends_with(
                      "no nodes of air are described: nobody knows where events enter and leave"))
      << only(checked.inspection).text;
  EXPECT_EQ(only(checked.inspection).hint, "describe the nodes of the mesh");
}

}  // namespace
}  // namespace mlcca::core::testing
