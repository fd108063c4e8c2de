// SPDX-License-Identifier: BSD-2-Clause
// Meshes whose links are measured: what is said of them before anything is known, and why they
// carry nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string>

#include "core/design/inspect.hpp"
#include "core/model/text.hpp"
#include "tests/core/design/inspected.hpp"

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
  for (const Attribute a : {Attribute::latency, Attribute::max_payload, Attribute::period})
    EXPECT_TRUE(checked.verdict.hops.at(mesh_hop).provision.is_dynamic(a)) << info(a).name;
}

/// From a over a node that the description does not have to c.
TEST(MeasuredMeshTest, NodesThatAreNotDescribedRelay) {
  for (const std::uint32_t more : {0, 1}) {
    State state(measured());
    mesh::Graph graph;
    graph.nodes = 5;
    const std::uint32_t between = 3 + more;
    for (const auto& [from, to] : {std::pair(0U, between), {between, 2U}}) {
      mesh::Link& link = graph.links.emplace_back();
      link.from = from;
      link.to = to;
      link.quality.rate = 1'000'000;
    }
    state.set_graph(kAir, graph);
    state.settle();
    EXPECT_TRUE(state.decisions()[0].all_granted()) << between;
  }
}

TEST(MeasuredMeshTest, AtDesignTimeTheRunTimeDecidesOfItsMediumTime) {
  const Checked checked = check(measured());
  std::size_t found = 0;
  for (const Row& row : checked.verdict.rows) {
    if (row.against != Against::medium_time) continue;
    ++found;
    EXPECT_EQ(row.place, network(kAir));
    EXPECT_EQ(row.comparison.attribute, Attribute::bandwidth);
    EXPECT_EQ(row.comparison.outcome, Outcome::run_time);
    EXPECT_TRUE(row.comparison.known);
    EXPECT_TRUE(row.comparison.dynamic);
    EXPECT_EQ(row.comparison.required, 160U) << "8 bytes every 50 ms";
    EXPECT_EQ(row.comparison.provided, kUnbounded);
  }
  EXPECT_EQ(found, 1U);
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

/// A way of two links of 10 ms takes 20 ms, whatever is said of the mesh as a whole.
TEST(MeasuredMeshTest, WhatAMeshStatesForGoodIsNoBetterThanWhatItsLinksGive) {
  System system = measured();
  system.networks[kAir].provision.set(Attribute::latency, kMs);
  EXPECT_EQ(only(check(system).inspection).id, Id::run_time);
  system.subscribers[0].attributes.set(Attribute::deadline, 8 * kMs);
  const Checked checked = check(system);
  ASSERT_FALSE(checked.inspection.findings.empty());
  const Finding& finding = checked.inspection.findings[0];
  EXPECT_EQ(finding.id, Id::hop_unfit);
  EXPECT_EQ(finding.provided, "10 ms");
}

TEST(MeasuredMeshTest, WhatAMeshStatesForGoodCountsWhereItIsWorse) {
  System system = measured();
  system.networks[kAir].provision.set(Attribute::latency, 2 * kFiftyMs);
  const Checked checked = check(system);
  ASSERT_FALSE(checked.inspection.findings.empty());
  EXPECT_EQ(checked.inspection.findings[0].id, Id::hop_unfit);
  EXPECT_EQ(checked.inspection.findings[0].provided, "100 ms");
  EXPECT_TRUE(checked.inspection.findings[0].hint.starts_with("let air provide"))
      << checked.inspection.findings[0].hint;
}

TEST(MeasuredMeshTest, WhatNoLinkStatesIsToBeStatedInPerHop) {
  System system = measured();
  system.networks[kAir].mesh->per_hop.clear(Attribute::omission);
  const Checked checked = check(system);
  ASSERT_FALSE(checked.inspection.findings.empty());
  EXPECT_TRUE(checked.inspection.findings[0].hint.starts_with("state Omission of PerHop of air"))
      << checked.inspection.findings[0].hint;
}

TEST(MeasuredMeshTest, PerHopHasNoAttributesOfTheUser) {
  System system = measured();
  UserAttribute energy;
  energy.name = "Energy";
  energy.composition = Composition::sum;
  energy.better = Better::smaller;
  system.user_attributes = {energy};
  system.subscribers[0].user = {{0, false, 5}};
  system.networks[kBus].user = {{0, false, 1}};
  system.gateways[0].user = {{0, false, 1}};
  const Checked checked = check(system);
  ASSERT_FALSE(checked.inspection.findings.empty());
  EXPECT_TRUE(
      checked.inspection.findings[0].hint.starts_with("state Energy of the Provision of air"))
      << checked.inspection.findings[0].hint;
}

TEST(MeasuredMeshTest, NoLatencyFollowsFromThePeriodOfThePublisher) {
  System system = measured();
  system.networks[kAir].mesh->per_hop.clear(Attribute::latency);
  const Checked checked = check(system);
  const Finding& finding = only(checked.inspection);
  EXPECT_EQ(finding.id, Id::hop_unfit);
  EXPECT_TRUE(finding.text.ends_with("air provides none")) << finding.text;
  EXPECT_TRUE(finding.hint.starts_with("state Latency of PerHop of air")) << finding.hint;
}

TEST(MeasuredMeshTest, LossMayBeMeasured) {
  System system = measured();
  system.channels[0].attributes.set(Attribute::packet_loss, kPercent);
  system.subscribers[0].attributes.set(Attribute::packet_loss, kPercent);
  system.networks[kBus].provision.set(Attribute::packet_loss, 0);
  system.gateways[0].provision.set(Attribute::packet_loss, 0);
  EXPECT_EQ(only(check(system).inspection).id, Id::run_time);
}

const Verdict& decided(State& state, mesh::Graph graph) {
  state.set_graph(kAir, std::move(graph));
  state.settle();
  return state.decisions().at(0).verdicts.at(0);
}

/// Links of 8 kbit/s from a over b to c are described; `sources` know of links.
System slowly_linked(std::initializer_list<mesh::SourceKind> sources) {
  System system = measured();
  system.networks[kBus].provision.set(Attribute::bandwidth, 50'000);
  mesh::Mesh& air = *system.networks[kAir].mesh;
  air.sources.clear();
  for (const mesh::SourceKind kind : sources) {
    mesh::Source& source = air.sources.emplace_back();
    source.kind = kind;
    source.metric = mesh::AwdsMetric::packet_pair;
  }
  for (const std::uint32_t from : {0U, 1U}) {
    mesh::DescribedLink link;
    link.from = from;
    link.to = from + 1;
    link.rate = 8'000;
    air.links.push_back(link);
  }
  return system;
}

TEST(MeasuredMeshTest, DescribedLinksDoNotRefuteWhatMeasuredOnesMayCarry) {
  using enum mesh::SourceKind;
  for (const mesh::SourceKind kind : {file, awds, wire, nl80211, batman, babel, olsr}) {
    System system = slowly_linked({kind, description});
    system.networks[kAir].mesh->per_hop.set(Attribute::latency, 30 * kMs);
    // Two links take 60 ms, carry 500 bytes/s and lose three in a row; one link need not.
    for (AttributeSet* ends : {&system.publishers[0].attributes, &system.subscribers[0].attributes})
      ends->set(Attribute::omission, 1).set(Attribute::bandwidth, 10'000);
    EXPECT_EQ(only(check(system).inspection).id, Id::run_time)
        << only(check(system).inspection).text;
    mesh::Graph direct;
    direct.nodes = 3;
    mesh::Link& link = direct.links.emplace_back();
    link.to = 2;
    link.quality.rate = 100'000'000;
    State state(system);
    EXPECT_TRUE(decided(state, direct).granted);
  }
}

TEST(MeasuredMeshTest, DescribedLinksRefuteWhereNothingElseKnowsAny) {
  System system = slowly_linked({mesh::SourceKind::description});
  system.publishers[0].attributes.set(Attribute::bandwidth, 10'000);
  EXPECT_EQ(only(check(system).inspection).id, Id::medium_time);
}

TEST(MeasuredMeshTest, WithoutDescribedNodesNothingEntersIt) {
  System system = measured();
  system.networks[kAir].mesh->nodes.clear();
  system.subscribers[0].mesh_node.reset();
  const Checked checked = check(system);
  EXPECT_EQ(checked.verdict.obstacle, Obstacle::no_path);
  EXPECT_TRUE(only(checked.inspection)
                  .text.ends_with(
                      "no nodes of air are described: it is unknown where events enter and leave"))
      << only(checked.inspection).text;
  EXPECT_EQ(only(checked.inspection).hint, "describe the nodes of the mesh");
}

/// Links between a, b and c in a row, in that direction; `lack`: those of b carry nothing.
mesh::Graph row_of_links(std::optional<mesh::Lack> lack = std::nullopt) {
  mesh::Graph graph;
  graph.nodes = 3;
  for (const std::uint32_t from : {0U, 1U}) {
    if (lack && from == 1) {
      graph.unusable.push_back({from, from + 1, std::nullopt, *lack});
      continue;
    }
    mesh::Link link;
    link.from = from;
    link.to = from + 1;
    link.quality.rate = 24'000'000;
    graph.links.push_back(link);
  }
  return graph;
}

TEST(MeasuredMeshTest, LinksWithoutARateAreNotUnknown) {
  State state(measured());
  EXPECT_EQ(decided(state, row_of_links(mesh::Lack::gone)).obstacle, Obstacle::no_path);
  const Verdict& v = decided(state, row_of_links(mesh::Lack::rate));
  EXPECT_EQ(v.obstacle, Obstacle::no_rate);
  EXPECT_EQ(reason(state.system(), state.members(), v),
            "rate unknown: no source knows what the links that lead through air carry");
  const Verdict& absent = decided(state, row_of_links(mesh::Lack::absent));
  EXPECT_EQ(absent.obstacle, Obstacle::links_absent);
  EXPECT_EQ(reason(state.system(), state.members(), absent),
            "links that would lead through air are known, and the source that knows which are "
            "there does not report them");
  const Verdict& back = decided(state, row_of_links(mesh::Lack::time));
  EXPECT_EQ(back.obstacle, Obstacle::links_must_last);
  EXPECT_EQ(reason(state.system(), state.members(), back),
            "links that lead through air were lost, and must last 5 s before they count again");
  EXPECT_TRUE(decided(state, row_of_links()).granted);
  EXPECT_EQ(decided(state, row_of_links(mesh::Lack::rate)).obstacle, Obstacle::no_rate);
}

TEST(MeasuredMeshTest, WhereNoSourceKnowsRatesNothingWillEverBeGranted) {
  System system = measured();
  mesh::Source& source = system.networks[kAir].mesh->sources[0];
  source.kind = mesh::SourceKind::awds;
  for (const auto& [metric, id] : {std::pair(mesh::AwdsMetric::etx, Id::no_route),
                                   std::pair(mesh::AwdsMetric::hops, Id::no_route),
                                   std::pair(mesh::AwdsMetric::packet_pair, Id::run_time)}) {
    source.metric = metric;
    EXPECT_EQ(only(check(system).inspection).id, id);
  }
  source.metric = mesh::AwdsMetric::etx;
  EXPECT_TRUE(only(check(system).inspection).text.contains("rate unknown"));
}

/// All of it in the mesh, from a to c; the gateway is b, with its gate on `interface`.
System relaying(mesh::SourceKind kind, const std::string& device, const std::string& interface) {
  System system = measured();
  Network& air = system.networks[kAir];
  air.profile = Profile::famouso;
  air.mesh->nodes[0].gateway.reset();
  air.mesh->nodes[1].gateway = 0;
  air.mesh->sources[0].kind = kind;
  air.mesh->sources[0].interface = device;
  air.mesh->sources[0].metric = mesh::AwdsMetric::packet_pair;
  system.gateways[0].ports[kAir].identity.name = interface;
  system.publishers[0].place = network(kAir);
  system.publishers[0].mesh_node = 0;
  return system;
}

TEST(MeasuredMeshTest, WhatOurOwnGateDropsOnTheWayIsNotGranted) {
  for (const auto& [kind, device, interface] :
       {std::tuple(mesh::SourceKind::awds, "wlan0", "wlan0"),
        std::tuple(mesh::SourceKind::batman, "bat0", "wlan0")}) {
    const System system = relaying(kind, device, interface);
    State state(system);
    const Verdict& v = decided(state, row_of_links());
    EXPECT_EQ(v.obstacle, Obstacle::relay_gated);
    EXPECT_EQ(v.obstacle_at, gateway(0));
    EXPECT_TRUE(reason(state.system(), state.members(), v).starts_with("gateway g has its gate"));
    const Inspection inspection = inspect(system);
    const auto found = std::ranges::find(inspection.findings, Id::relay_gated, &Finding::id);
    ASSERT_NE(found, inspection.findings.end());
    EXPECT_TRUE(found->hint.contains(kind == mesh::SourceKind::awds ? "\"awds0\"" : "\"bat0\""));
  }
}

TEST(MeasuredMeshTest, TheMeshsOwnDeviceDoesNotSeeWhatIsRelayed) {
  for (const auto& [kind, device, interface] :
       {std::tuple(mesh::SourceKind::awds, "wlan0", "awds0"),
        std::tuple(mesh::SourceKind::batman, "bat0", "bat0"),
        std::tuple(mesh::SourceKind::nl80211, "mesh0", "mesh0")}) {
    const System system = relaying(kind, device, interface);
    State state(system);
    EXPECT_TRUE(decided(state, row_of_links()).granted);
    EXPECT_EQ(only(inspect(system)).id, Id::run_time);
  }
}

TEST(MeasuredMeshTest, AGateOnTheRadioOfAnEndDropsNothingOnTheWay) {
  System system = relaying(mesh::SourceKind::awds, "wlan0", "wlan0");
  system.networks[kAir].mesh->nodes[1].gateway.reset();
  system.networks[kAir].mesh->nodes[0].gateway = 0;
  State state(system);
  EXPECT_TRUE(decided(state, row_of_links()).granted);
}

TEST(MeasuredMeshTest, AStreamThatIsTooFastHasOneCapacityAsItsReason) {
  System system = measured();
  Network& air = system.networks[kAir];
  air.mesh->sources[0].kind = mesh::SourceKind::description;
  for (const std::uint32_t from : {0U, 1U}) {
    mesh::DescribedLink link;
    link.from = from;
    link.to = from + 1;
    link.rate = 8'000;
    air.mesh->links.push_back(link);
  }
  const Inspection inspection = inspect(system);
  EXPECT_EQ(only(inspection).id, Id::medium_time) << inspection.findings.at(0).text;
}

}  // namespace
}  // namespace mlcca::core::testing
