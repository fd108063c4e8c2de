// SPDX-License-Identifier: BSD-2-Clause
// Who competes with what is decided at run time is promised nothing by check, and refused nothing:
// a gateway decides it the one way or the other.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "core/admission/state.hpp"
#include "core/design/inspect.hpp"
#include "core/mesh/graph.hpp"
#include "description/read.hpp"
#include "tools/design/generate/checks.hpp"

namespace mlcca::testing {
namespace {

/// A channel x crosses a mesh whose links a source knows; v and w are on the network behind it,
/// which has room for `room` of them.
core::System system_with(const std::string& room) {
  const std::string text =
      R"(<System name="z">
  <EventChannel name="x"><SubjectUID>0x1</SubjectUID>
    <Attributes period="10ms" deadline="60ms" maxPayload="100"/></EventChannel>
  <EventChannel name="v"><SubjectUID>0x2</SubjectUID>
    <Attributes period="10ms" maxPayload="120"/></EventChannel>
  <EventChannel name="w"><SubjectUID>0x3</SubjectUID>
    <Attributes period="20ms" maxPayload="100"/></EventChannel>
  <Network name="mesh"><Kind>mesh</Kind><Mesh><PerHop latency="20ms" jitter="12ms"/>
    <Node name="a" address="02:00:00:00:00:01" gateway="g"/>
    <Node name="c" address="02:00:00:00:00:03"/>
    <Source kind="file" endpoint="/nowhere"/></Mesh></Network>
  <Network name="lan"><Kind>udp-multicast</Kind><Profile>famouso</Profile>
    <Provision period="1ms" latency="1ms" jitter="1ms" maxPayload="1000" bandwidth=")" +
      room + R"("/></Network>
  <Gateway name="g"><Provision latency="1ms" jitter="500us"/>
    <Port network="mesh"><Interface name="awds0"/></Port>
    <Port network="lan" sender="daemon"><Interface name="eth7"/></Port></Gateway>
  <Publisher channel="x" network="mesh" mesh-node="c"/><Subscriber channel="x" network="lan"/>
  <Publisher channel="v" network="lan"/><Subscriber channel="v" network="lan"/>
  <Publisher channel="w" network="lan"/><Subscriber channel="w" network="lan"/>
</System>)";
  auto system = description::read_memory(text, "z.xml", {}, description::Users::any);
  EXPECT_TRUE(system) << description::to_string(system.error().front());
  return std::move(*system);
}

using Outcomes = std::array<Outcome, 3>;

Outcomes checked(const core::System& system) {
  const core::Inspection inspection = core::inspect(system);
  return {inspection.channels[0].outcome, inspection.channels[1].outcome,
          inspection.channels[2].outcome};
}

/// Of x, v and w, with the link that x needs, or without any.
std::array<bool, 3> decided(const core::System& system, bool has_link) {
  core::State state(system);
  core::mesh::Graph graph;
  graph.nodes = 2;
  if (has_link) {
    core::mesh::Link& link = graph.links.emplace_back();
    link.from = 1;
    link.to = 0;
    link.quality.rate = 54'000'000;
  }
  state.set_graph(0, std::move(graph));
  state.decide();
  const auto granted = [&](std::size_t channel) {
    return state.decisions()[channel].verdicts.at(0).granted;
  };
  return {granted(0), granted(1), granted(2)};
}

constexpr auto kFits = Outcome::fit;
constexpr auto kLater = Outcome::run_time;
constexpr auto kNot = Outcome::unfit;

/// x takes 10 kB/s, v 12 and w 5.
TEST(Contested, WhoHasRoomOnlyWithoutWhatIsDecidedAtRunTimeIsDecidedThere) {
  const core::System system = system_with("20kB/s");
  EXPECT_EQ(checked(system), (Outcomes{kLater, kLater, kFits}));
  EXPECT_EQ(decided(system, true), (std::array{true, false, true}));
  EXPECT_EQ(decided(system, false), (std::array{false, true, true}));
}

TEST(Contested, WhoHasRoomOnlyBesideItIsDecidedThereToo) {
  const core::System system = system_with("16kB/s");
  EXPECT_EQ(checked(system), (Outcomes{kLater, kLater, kLater}));
  EXPECT_EQ(decided(system, true), (std::array{true, false, true}));
  EXPECT_EQ(decided(system, false), (std::array{false, true, false}));
}

TEST(Contested, WhoNeverHasRoomIsRefused) {
  const core::System system = system_with("13kB/s");
  EXPECT_EQ(checked(system), (Outcomes{kLater, kLater, kNot}));
  EXPECT_EQ(decided(system, true), (std::array{true, false, false}));
  EXPECT_EQ(decided(system, false), (std::array{false, true, false}));
}

TEST(Contested, WhereThereIsRoomForAllNothingIsContested) {
  const core::System system = system_with("27kB/s");
  EXPECT_EQ(checked(system), (Outcomes{kLater, kFits, kFits}));
  EXPECT_EQ(decided(system, true), (std::array{true, true, true}));
  EXPECT_EQ(decided(system, false), (std::array{false, true, true}));
}

TEST(Contested, GeneratedCodeRefusesNoneOfThem) {
  const core::System system = system_with("16kB/s");
  const tools::design::Decisions decisions(system);
  for (std::size_t p = 0; p < 3; ++p)
    EXPECT_TRUE(decisions.of(p, system.subscribers[p].place, 0).granted) << p;
}

}  // namespace
}  // namespace mlcca::testing
