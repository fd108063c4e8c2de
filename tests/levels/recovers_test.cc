// SPDX-License-Identifier: BSD-2-Clause
// What check grants is granted by a gateway whatever it went through before: when links come back,
// a channel gets the attribute set in which most of it is served.
#include <gtest/gtest.h>

#include "core/admission/state.hpp"
#include "core/admission/world.hpp"
#include "core/design/inspect.hpp"
#include "description/read.hpp"

namespace mlcca::testing {
namespace {

constexpr const char* kTwoPublishers = R"(<System name="z">
  <EventChannel name="c"><SubjectUID>0x1</SubjectUID>
    <Attributes priority="5" period="10ms" maxPayload="1"/>
    <Attributes priority="4" period="1s" maxPayload="8"/></EventChannel>
  <Network name="lan"><Kind>udp-multicast</Kind><Profile>famouso</Profile>
    <Provision latency="1ms" period="1ms" bandwidth="3kB/s" maxPayload="64"/></Network>
  <Network name="mesh"><Kind>mesh</Kind><Profile>famouso</Profile>
    <Mesh><PerHop latency="1ms" jitter="600us"/>
      <Node name="g" address="02:00:00:00:03:01" gateway="g0"/>
      <Node name="a" address="02:00:00:00:03:03"/>
      <Link from="a" to="g" rate="20000"/></Mesh></Network>
  <Gateway name="g0"><Provision latency="1ms"/>
    <Port network="lan"><Interface name="x0n0"/></Port>
    <Port network="mesh"><Interface name="x0n3"/></Port></Gateway>
  <Publisher name="slow" channel="c" network="mesh">
    <Attributes period="50ms" maxPayload="8"/></Publisher>
  <Publisher name="plain" channel="c" network="lan"/>
  <Subscriber name="q" channel="c" gateway="g0"/>
</System>)";

TEST(Recovers, AChannelOfWhichAPublisherWasGoneIsServedWholeAgain) {
  const auto system =
      description::read_memory(kTwoPublishers, "z.xml", {}, description::Users::any);
  ASSERT_TRUE(system);
  EXPECT_EQ(core::inspect(*system).channels[0].outcome, Outcome::fit);
  EXPECT_EQ(core::inspect(*system).channels[0].set, 1U);
  const core::World world = core::described_world(*system);
  core::State state(*system);
  const auto set_links = [&](bool there) {
    core::mesh::Graph graph = world.meshes[1]->graph;
    if (!there) graph.links.clear();
    state.set_graph(1, std::move(graph));
  };
  set_links(false);
  state.decide();
  EXPECT_EQ(state.decisions()[0].granted, 1U);
  EXPECT_EQ(state.decisions()[0].set, 0U) << "of those that are there the better set";
  for (int times = 0; times < 2; ++times) {
    set_links(true);
    state.settle();
    EXPECT_EQ(state.decisions()[0].granted, 2U);
    EXPECT_EQ(state.decisions()[0].set, 1U);
    set_links(false);
    state.settle();
    EXPECT_EQ(state.decisions()[0].granted, 1U);
  }
}

}  // namespace
}  // namespace mlcca::testing
