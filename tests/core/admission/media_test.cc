// SPDX-License-Identifier: BSD-2-Clause
// Buses and meshes as part of a decision: what is computed takes the place of what is only stated.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "core/design/inspect.hpp"
#include "core/model/text.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

constexpr Value kMs = 1'000'000;

AttributeSet every(Value period) {
  return AttributeSet{}.set(Attribute::period, period).set(Attribute::max_payload, 8);
}

/// `count` channels on one raw bus of 125 kbit/s, where a frame takes 1.08 ms; identifiers rising.
System one_bus(std::size_t count, Value period) {
  System system;
  Network bus;
  bus.name = "bus";
  bus.profile = Profile::raw;
  bus.bus.bitrate = 125'000;
  bus.provision.set(Attribute::max_payload, 8);
  for (std::size_t c = 0; c < count; ++c) {
    EventChannel channel;
    channel.name = "c" + std::to_string(c);
    channel.subject = c + 1;
    channel.attributes = every(period);
    system.channels.push_back(channel);
    Binding binding;
    binding.channel = c;
    binding.id = static_cast<std::uint32_t>(c);
    bus.bindings.push_back(binding);
    Publisher p;
    p.name = "p" + std::to_string(c);
    p.channel = c;
    p.place = network(0);
    p.attributes = channel.attributes;
    system.publishers.push_back(p);
    system.subscribers.push_back(subscriber("s" + std::to_string(c), network(0), every(period)));
    system.subscribers.back().channel = c;
  }
  system.networks.push_back(bus);
  return system;
}

std::size_t granted(const State& state) {
  std::size_t n = 0;
  for (const Decision& d : state.decisions()) n += d.granted;
  return n;
}

TEST(BusTest, GrantsWhatMeetsItsDeadlineAndNothingMore) {
  // 135 bits of 8 us: in 5 ms four frames of 1.08 ms end, a fifth does not.
  const State state(one_bus(6, 5 * kMs));
  EXPECT_EQ(granted(state), 4U);
  const Verdict& first = state.decisions()[0].verdicts.at(0);
  EXPECT_EQ(first.media.at(0).guaranteed, 5 * kMs);
  const Verdict& refused = state.decisions()[4].verdicts.at(0);
  const Row* row = deciding_row(refused);
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->against, Against::schedule);
  EXPECT_NE(reason(state.system(), state.members(), refused).find("could wait without a bound"),
            std::string::npos)
      << reason(state.system(), state.members(), refused);
}

TEST(BusTest, WhatAGrantPromisesIsTheResponseTimeOfItsFrames) {
  const State state(one_bus(2, 50 * kMs));
  // A frame takes 1.08 ms. The first is blocked by one of the second, which waits for the first.
  for (const Decision& d : state.decisions()) {
    const Verdict& v = d.verdicts.at(0);
    ASSERT_TRUE(v.granted);
    ASSERT_EQ(v.media.size(), 1U);
    EXPECT_EQ(v.media[0].network, 0U);
    EXPECT_EQ(v.media[0].guaranteed, 50 * kMs);
  }
  // The first was alone when it was decided, the second was not.
  EXPECT_EQ(state.decisions()[0].verdicts[0].media[0].response, 1'080'000U);
  EXPECT_EQ(state.decisions()[0].verdicts[0].provision[Attribute::latency], 1'080'000U);
  EXPECT_EQ(state.decisions()[0].verdicts[0].provision[Attribute::jitter], 1'080'000U);
  EXPECT_EQ(state.decisions()[1].verdicts[0].media[0].response, 2'160'000U);
  EXPECT_EQ(state.decisions()[1].verdicts[0].provision[Attribute::latency], 2'160'000U);
  EXPECT_EQ(state.decisions()[1].verdicts[0].provision[Attribute::period], 50 * kMs);
}

/// One message of 36 % of the bus, and one of 5 %.
System loud_and_quiet() {
  System system = one_bus(2, 20 * kMs);
  system.channels[0].attributes = every(3 * kMs);
  system.publishers[0].attributes = every(3 * kMs);
  system.subscribers[0].attributes = every(3 * kMs);
  return system;
}
bool is_granted(const State& state, std::size_t channel) {
  return state.decisions()[channel].granted != 0;
}
Condition carrying(std::uint32_t background, std::vector<ObservedLoad> observed = {}) {
  Condition condition;
  condition.background = background;
  condition.observed = std::move(observed);
  return condition;
}

TEST(BusTest, WhoIsRefusedAndSendsAllTheSameIsNotUnaccountedToHimself) {
  State state(loud_and_quiet());
  EXPECT_TRUE(is_granted(state, 0));
  state.set_condition(0, carrying(600'000));
  state.settle();
  EXPECT_FALSE(is_granted(state, 0));
  // The unadmitted sender has gone, and the refused publisher goes on sending: as background it
  // would be in its own way for ever.
  state.set_condition(0, carrying(360'000));
  state.settle();
  EXPECT_FALSE(is_granted(state, 0));
  state.set_condition(0, carrying(360'000, {{0, 360'000}}));
  state.settle();
  EXPECT_TRUE(is_granted(state, 0));
  EXPECT_EQ(state.ledger().schedule(0)->assumptions().background, 0U);
  // From now on it is analysed; a measurement that says the same changes nothing.
  state.set_condition(0, carrying(0));
  state.settle();
  EXPECT_TRUE(is_granted(state, 0));
}

TEST(BusTest, ObservedLoadIsBackgroundToAllOthers) {
  State state(loud_and_quiet());
  state.set_withdrawn(0, true);
  state.set_condition(0, carrying(990'000, {{0, 990'000}}));
  state.settle();
  EXPECT_FALSE(is_granted(state, 1)) << "0.99 of the bus is taken by an unadmitted sender";
  state.set_condition(0, carrying(360'000, {{0, 360'000}}));
  state.settle();
  EXPECT_TRUE(is_granted(state, 1));
  EXPECT_EQ(state.ledger().schedule(0)->assumptions().background, 360'000U);
  state.set_withdrawn(0, false);
  state.settle();
  EXPECT_TRUE(is_granted(state, 0));
  EXPECT_TRUE(is_granted(state, 1));
  EXPECT_EQ(state.ledger().schedule(0)->assumptions().background, 0U);
  state.set_withdrawn(0, true);
  state.settle();
  EXPECT_EQ(state.ledger().schedule(0)->assumptions().background, 360'000U)
      << "it goes on sending as far as anyone knows";
}

TEST(BusTest, AtDesignTimeResponseTimesAreThoseOfAllMessagesThatAreGranted) {
  const System system = one_bus(3, 50 * kMs);
  const State daemon(system);
  std::size_t reports = 0;
  static_cast<void>(inspect(
      system, {}, [&](std::size_t channel, const Decision& decision, std::span<const Finding> why) {
        ++reports;
        EXPECT_TRUE(why.empty());
        const Verdict& v = decision.verdicts.at(0);
        const Value response = daemon.ledger().schedule(0)->response(v.media.at(0).key);
        EXPECT_EQ(v.media.at(0).response, response) << channel;
        EXPECT_EQ(v.hops.at(0).provision[Attribute::latency], response);
        const auto end = std::ranges::find(v.rows, Against::end_to_end, &Row::against);
        ASSERT_NE(end, v.rows.end());
        EXPECT_EQ(end->comparison.provided, response);
      }));
  EXPECT_EQ(reports, 3U);
  EXPECT_TRUE(daemon.decisions()[0].verdicts.at(0).hops.empty()) << "kept at design time only";
}

TEST(BusTest, AStatedLatencyIsHeldAgainstTheAnalysis) {
  System system = one_bus(4, 50 * kMs);
  system.networks[0].provision.set(Attribute::latency, 3 * kMs).set(Attribute::period, kMs);
  // Blocked by one lower frame, or behind two higher ones: three frames in 3 ms are too many.
  const State state(std::move(system));
  EXPECT_EQ(granted(state), 2U);
}

TEST(BusTest, AnotherBitRateDecidesAgain) {
  State state(one_bus(4, 5 * kMs));
  ASSERT_EQ(granted(state), 4U);
  Condition slow;
  slow.timing.bitrate = 50'000;  // 2.7 ms a frame
  state.set_condition(0, slow);
  state.settle();
  EXPECT_EQ(granted(state), 1U);
  state.set_condition(0, {});
  state.settle();
  EXPECT_EQ(granted(state), 4U);
}

TEST(BusTest, UnaccountedLoadWithdrawsWhatCanNoLongerBeGuaranteed) {
  State state(one_bus(4, 5 * kMs));
  Condition loaded;
  loaded.background = 500'000;
  state.set_condition(0, loaded);
  state.settle();
  EXPECT_LT(granted(state), 4U);
}

TEST(BusTest, WhoDoesNotSayHowOftenHeSendsIsRefused) {
  System system = one_bus(1, 5 * kMs);
  system.publishers[0].attributes.clear(Attribute::period);
  system.subscribers[0].attributes.clear(Attribute::period);
  const State state(std::move(system));
  EXPECT_EQ(state.decisions()[0].verdicts.at(0).obstacle, Obstacle::no_period);
}

/// A bus as the first one, and the gateway between them, which takes `latency`.
Gateway& join_a_second_bus(System& system, Value latency) {
  Network second = system.networks[0];
  second.name = "second";
  system.networks.push_back(second);
  Gateway gateway;
  gateway.name = "g";
  gateway.provision.set(Attribute::latency, latency).set(Attribute::jitter, 0);
  for (const std::size_t n : {0, 1}) {
    Port port;
    port.network = n;
    gateway.ports.push_back(port);
  }
  return system.gateways.emplace_back(std::move(gateway));
}

TEST(BusTest, AQueueThatCanOverflowLosesEvents) {
  System system = one_bus(4, 100 * kMs);
  for (Port& port : join_a_second_bus(system, 0).ports) port.queue_length = 3;
  for (Subscriber& s : system.subscribers) s.place = network(1);
  const State state(std::move(system));
  EXPECT_EQ(granted(state), 3U);
  const Verdict& refused = state.decisions()[3].verdicts.at(0);
  const std::string why = reason(state.system(), state.members(), refused);
  EXPECT_TRUE(why.contains("queue of their gateway full")) << why;
  EXPECT_TRUE(why.contains("it holds 3 frames, and up to 4 wait in it")) << why;
}

TEST(BusTest, FramesWithADataPhaseNeedItsBitRate) {
  System system = one_bus(1, 50 * kMs);
  for (const FrameFormat format : {FrameFormat::fd, FrameFormat::any, FrameFormat::xl}) {
    system.networks[0].bindings[0].format = format;
    State state(system);
    EXPECT_EQ(state.decisions()[0].verdicts.at(0).obstacle, Obstacle::no_data_rate);
    // The interface has one, and another time it has none.
    for (const std::uint32_t rate : {500'000U, 0U}) {
      Condition condition;
      condition.timing = {.bitrate = 125'000, .data_bitrate = rate};
      state.set_condition(0, condition);
      state.settle();
      EXPECT_EQ(granted(state), rate == 0 ? 0U : 1U);
    }
    const Verdict& refused = state.decisions()[0].verdicts.at(0);
    const std::string forms = format == FrameFormat::fd   ? "are FD frames"
                              : format == FrameFormat::xl ? "are XL frames"
                                                          : "may be FD frames";
    EXPECT_EQ(reason(state.system(), state.members(), refused),
              "frames of channel c0 " + forms + ", and bus has no bit rate for their data phase");
  }
}

TEST(BusTest, WithoutAnyBitRateTheDataPhaseIsDecidedAtRunTime) {
  System system = one_bus(1, 50 * kMs);
  system.networks[0].bus = {};
  system.networks[0].provision.set(Attribute::period, kMs);
  EXPECT_EQ(inspect(system).channels.at(0).outcome, Outcome::fit);
  system.networks[0].bindings[0].format = FrameFormat::fd;
  const Inspection inspection = inspect(system);
  EXPECT_EQ(inspection.channels.at(0).outcome, Outcome::run_time);
  ASSERT_EQ(inspection.findings.size(), 1U);
  EXPECT_EQ(inspection.findings[0].id, FindingId::run_time);
  EXPECT_TRUE(inspection.findings[0].has_place);
  EXPECT_EQ(inspection.findings[0].place, network(0));
  EXPECT_TRUE(inspection.findings[0].text.ends_with("(the data bit rate of bus)"))
      << inspection.findings[0].text;
}

TEST(BusTest, WhereTheOtherHopsTakeAllOfTheTimeNoneIsLeft) {
  System system = one_bus(1, 50 * kMs);
  join_a_second_bus(system, 50 * kMs);
  system.subscribers[0].place = network(1);
  const State state(std::move(system));
  const Verdict& refused = state.decisions()[0].verdicts.at(0);
  const auto row = std::ranges::find(refused.rows, Against::schedule, &Row::against);
  ASSERT_NE(row, refused.rows.end());
  EXPECT_EQ(schedule_text(state.system(), state.members(), *row),
            "no time is left for the frames of p0 (c0) on bus: they take up to 1.08 ms there, and "
            "the rest of their way may take all that they are allowed");
}

/// One mesh of two nodes, one link of 8 kbit/s: 1000 bytes/s.
System air(AttributeSet attributes) {
  System system = one_bus(1, 5 * kMs);
  Network& net = system.networks[0];
  net = {};
  net.name = "air";
  net.kind = NetworkKind::mesh;
  mesh::Mesh m;
  m.limit = mesh::kWhole;
  m.header_bytes = 0;
  m.nodes = {{"a", "a", {}, {}}, {"b", "b", {}, {}}};
  net.mesh = m;
  system.channels[0].attributes = attributes;
  system.publishers[0].attributes = attributes;
  system.publishers[0].mesh_node = 0;
  system.subscribers[0].attributes = {};
  system.subscribers[0].mesh_node = 1;
  return system;
}

mesh::Graph link_of(Value bits_per_second, Value busy = 0) {
  mesh::Graph graph;
  graph.nodes = 2;
  mesh::Link link;
  link.from = 0;
  link.to = 1;
  link.quality.rate = bits_per_second;
  link.busy = busy;
  graph.links = {link};
  return graph;
}

TEST(MeshTest, AMeshWithoutDescribedNodesGrantsNothing) {
  AttributeSet slow;
  slow.set(Attribute::bandwidth, 400).set(Attribute::max_payload, 100);
  System system = air(slow);
  system.networks[0].mesh->nodes.clear();
  system.publishers[0].mesh_node.reset();
  system.subscribers[0].mesh_node.reset();
  State state(std::move(system));
  state.set_graph(0, link_of(8000));
  state.settle();
  EXPECT_EQ(state.decisions()[0].verdicts.at(0).obstacle, Obstacle::no_path);
}

TEST(MeshTest, WhatEachLinkStatesCountsBeforeWhatFollowsFromTheTime) {
  AttributeSet often;
  often.set(Attribute::period, 10 * kMs)
      .set(Attribute::max_payload, 1)
      .set(Attribute::deadline, 1000 * kMs);
  for (const Value period : {5 * kMs, 20 * kMs}) {
    System system = air(often);
    system.networks[0].mesh->per_hop.set(Attribute::period, period).set(Attribute::latency, kMs);
    State state(std::move(system));
    state.set_graph(0, link_of(8000));
    state.settle();
    EXPECT_EQ(state.decisions()[0].all_granted(), period == 5 * kMs);
  }
}

TEST(MeshTest, ThePeriodOfThePublisherPromisesNoLatency) {
  System system = air(every(50 * kMs));
  system.networks[0].mesh->per_hop.set(Attribute::omission, 0);
  State state(std::move(system));
  state.set_graph(0, link_of(8000));
  state.settle();
  const Verdict& v = state.decisions()[0].verdicts.at(0);
  EXPECT_FALSE(v.granted);
  EXPECT_EQ(reason(state.system(), state.members(), v),
            "Deadline 50 ms required, air provides none");
}

TEST(MeshTest, APeriodThatTheDescriptionStatesPromisesALatency) {
  System system = air(every(50 * kMs));
  system.networks[0].provision.set(Attribute::period, 20 * kMs);
  State state(std::move(system));
  state.set_graph(0, link_of(8000));
  state.settle();
  const Verdict& v = state.decisions()[0].verdicts.at(0);
  EXPECT_TRUE(v.granted);
  EXPECT_EQ(v.provision[Attribute::latency], 20 * kMs);
}

TEST(MeshTest, AGrantIsSummedUpByWhatIsNearest) {
  System system = air(every(50 * kMs));
  system.networks[0].mesh->per_hop.set(Attribute::latency, 45 * kMs);
  State state(std::move(system));
  state.set_graph(0, link_of(8000));
  state.settle();
  const Verdict& v = state.decisions()[0].verdicts.at(0);
  ASSERT_TRUE(v.granted);
  EXPECT_EQ(deciding_row(v)->comparison.attribute, Attribute::deadline);
}

TEST(MeshTest, AStreamThatIsTooFastIsRefusedForWhatIsLeft) {
  AttributeSet fast;
  fast.set(Attribute::bandwidth, 2000).set(Attribute::max_payload, 100);
  State state(air(fast));
  state.set_graph(0, link_of(8000, 500'000));
  state.settle();
  const Verdict& v = state.decisions()[0].verdicts.at(0);
  EXPECT_EQ(reason(state.system(), state.members(), v),
            "2 kB/s needed on air, whose links have time for 500 B/s");
}

TEST(MeshTest, BetweenProgramsOfOneNodeThereIsNothingToWaitFor) {
  AttributeSet often;
  often.set(Attribute::period, 10 * kMs)
      .set(Attribute::max_payload, 1)
      .set(Attribute::deadline, 1)
      .set(Attribute::omission, 0)
      .set(Attribute::packet_loss, 0);
  System system = air(often);
  system.networks[0].provision.set(Attribute::latency, 20 * kMs, true);
  system.subscribers[0].mesh_node = 0;
  system.subscribers[0].attributes.set(Attribute::bandwidth, 100);
  State state(std::move(system));
  state.set_graph(0, link_of(8000));
  state.settle();
  EXPECT_TRUE(state.decisions()[0].all_granted())
      << reason(state.system(), state.members(), state.decisions()[0].verdicts.at(0));
}

TEST(MeshTest, EventsWithoutPayloadTakeTimeAllTheSame) {
  AttributeSet often;
  often.set(Attribute::max_payload, 0).set(Attribute::bandwidth, 0);
  State state(air(often.set(Attribute::period, 100'000).set(Attribute::deadline, 1000 * kMs)));
  state.set_graph(0, link_of(8000));
  state.settle();
  const Verdict& v = state.decisions()[0].verdicts.at(0);
  bool found = false;
  for (const Row& row : v.rows)
    if (row.against == Against::medium_time) {
      found = true;
      EXPECT_EQ(row.comparison.required, 10'000U) << "10000 events/s, a byte each";
      EXPECT_EQ(row.comparison.outcome, Outcome::unfit);
    }
  EXPECT_TRUE(found);
  EXPECT_FALSE(v.granted);
}

TEST(MeshTest, WithoutAPeriodTheBandwidthSaysHowOftenEmptyEventsAre) {
  AttributeSet slow;
  slow.set(Attribute::max_payload, 0).set(Attribute::bandwidth, 7);
  State state(air(slow));
  state.set_graph(0, link_of(8000));
  state.settle();
  const Verdict& v = state.decisions()[0].verdicts.at(0);
  EXPECT_TRUE(v.granted);
  const auto row = std::ranges::find(v.rows, Against::medium_time, &Row::against);
  ASSERT_NE(row, v.rows.end());
  EXPECT_EQ(row->comparison.required, 7U);
}

/// Of a chain a, b, c: a link that goes to b carries what goes on to c as well.
TEST(MeshTest, ALinkOnTheWayToTwoNodesIsTakenOnce) {
  AttributeSet slow;
  slow.set(Attribute::bandwidth, 100).set(Attribute::max_payload, 100);
  const auto taken_by = [&](const std::vector<std::uint32_t>& listeners) {
    System system = air(slow);
    system.networks[0].mesh->nodes.push_back({"c", "c", {}, {}});
    const Subscriber one = system.subscribers[0];
    system.subscribers.clear();
    for (const std::uint32_t node : listeners) {
      system.subscribers.push_back(one);
      system.subscribers.back().mesh_node = node;
    }
    State state(std::move(system));
    mesh::Graph graph = link_of(8000);
    graph.nodes = 3;
    graph.links.push_back(graph.links[0]);
    graph.links[1].from = 1;
    graph.links[1].to = 2;
    state.set_graph(0, graph);
    state.settle();
    EXPECT_TRUE(state.decisions()[0].all_granted());
    return state.ledger().medium_time(0, 0);
  };
  const Value near = taken_by({1});
  const Value far = taken_by({2});
  EXPECT_GT(near, 0U);
  EXPECT_EQ(far, 2 * near) << "two links, each as long";
  EXPECT_EQ(taken_by({1, 2}), far);
  EXPECT_EQ(taken_by({2, 1}), far);
}

TEST(MeshTest, WhatIsMeasuredBusyIsTakenWhateverIsReserved) {
  AttributeSet slow;
  slow.set(Attribute::bandwidth, 400).set(Attribute::max_payload, 100);
  State state(air(slow));
  state.set_graph(0, link_of(8000, 500'000));
  state.settle();
  EXPECT_TRUE(state.decisions()[0].all_granted()) << "400 beside 500 of 1000";
  // The same load as before, the link a little slower: nothing is taken off for the reservation.
  state.set_graph(0, link_of(7900, 500'000));
  state.settle();
  EXPECT_EQ(state.world().meshes[0]->background[0], mesh::kFullTime / 2);
  state.set_graph(0, link_of(8000, 700'000));
  state.settle();
  EXPECT_FALSE(state.decisions()[0].all_granted());
}

}  // namespace
}  // namespace mlcca::core::testing
