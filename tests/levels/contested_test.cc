// SPDX-License-Identifier: BSD-2-Clause
// Who competes with what is decided at run time is promised nothing by check, and refused nothing:
// a gateway decides it the one way or the other.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/state.hpp"
#include "core/design/inspect.hpp"
#include "core/mesh/graph.hpp"
#include "description/read.hpp"
#include "tests/description/twin/random_values.hpp"
#include "tools/design/generate/checks.hpp"

namespace mlcca::testing {
namespace {

/// A channel x crosses a mesh whose links a source knows; v and w are on the network behind it,
/// which has room for `room` of them.
std::string text_with(const std::string& room) {
  return R"(<System name="z">
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
}

core::System system_with(const std::string& room) {
  auto system = description::read_memory(text_with(room), "z.xml", {}, description::Users::any);
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

constexpr std::uint64_t kSystems = 3000;
constexpr std::size_t kNodes = 3;  // of the mesh, beside that of the gateway

/// Channels want room on one network; those of a node of the mesh come to it if that node has a
/// link.
std::string random_contest(Random& random, std::uint64_t count) {
  std::string channels;
  std::string ends;
  const bool several_sets = random.one_in(2);
  const bool importances = random.one_in(3);
  for (std::uint64_t c = 0; c < count; ++c) {
    channels +=
        fmt::format("<EventChannel name=\"c{0}\"{1}><SubjectUID>0x{2}</SubjectUID>", c,
                    importances ? fmt::format(" importance=\"{}\"", random.below(3)) : "", c + 1);
    const std::uint64_t sets = several_sets ? 1 + random.below(3) : 1;
    for (std::uint64_t set = 0; set < sets; ++set)
      channels += fmt::format("<Attributes{} period=\"10ms\" deadline=\"60ms\" maxPayload=\"{}\"/>",
                              sets > 1 ? fmt::format(" priority=\"{}\"", 9 - set) : "",
                              10 * (1 + random.below(20)));
    channels += "</EventChannel>\n";
    const std::uint64_t publishers = random.one_in(3) ? 2 : 1;
    for (std::uint64_t p = 0; p < publishers; ++p) {
      const std::uint64_t node = random.below(kNodes + 2);
      ends += fmt::format("<Publisher name=\"p{0}x{1}\" channel=\"c{0}\" {2}/>\n", c, p,
                          node < kNodes
                              ? fmt::format("network=\"mesh\" mesh-node=\"n{}\"", node)
                              : fmt::format("network=\"lan\" address=\"10.0.{}.{}\"", c, p + 1));
    }
    ends += fmt::format("<Subscriber channel=\"c{}\" network=\"lan\"/>\n", c);
  }
  std::string nodes;
  for (std::size_t n = 0; n < kNodes; ++n)
    nodes += fmt::format("<Node name=\"n{}\" address=\"02:00:00:00:00:0{}\"/>", n, n + 2);
  return fmt::format(
      "<System name=\"z\">{}"
      "<Network name=\"mesh\"><Kind>mesh</Kind><Mesh><PerHop latency=\"20ms\" jitter=\"12ms\"/>"
      "<Node name=\"own\" address=\"02:00:00:00:00:01\" gateway=\"g\"/>{}"
      "<Source kind=\"file\" endpoint=\"/nowhere\"/></Mesh></Network>"
      "<Network name=\"lan\"><Kind>udp-multicast</Kind><Profile>famouso</Profile>"
      "<Provision period=\"1ms\" latency=\"1ms\" jitter=\"1ms\" maxPayload=\"1000\" "
      "bandwidth=\"{}kB/s\"/></Network>"
      "<Gateway name=\"g\"><Provision latency=\"1ms\" jitter=\"500us\"/>"
      "<Port network=\"mesh\"><Interface name=\"awds0\"/></Port>"
      "<Port network=\"lan\" sender=\"daemon\"><Interface name=\"eth7\"/></Port></Gateway>{}"
      "</System>",
      channels, nodes, 5 + random.below(40), ends);
}

/// These nodes have a link to the gateway.
core::mesh::Graph graph_of(unsigned linked) {
  core::mesh::Graph graph;
  graph.nodes = kNodes + 1;
  for (std::uint32_t n = 0; n < kNodes; ++n) {
    if ((linked >> n & 1U) == 0) continue;
    core::mesh::Link& link = graph.links.emplace_back();
    link.from = n + 1;
    link.to = 0;
    link.quality.rate = 540'000'000;
  }
  return graph;
}

/// What a publisher gets over all that the run time may find.
struct Range {
  std::set<bool> granted;
  std::set<std::size_t> sets;
  bool stays = true;  ///< it is granted whichever links come and go then
};

/// Each has one delivery.
template <class Each>
void each_delivery(const core::State& state, const Each& each) {
  for (const core::Decision& decision : state.decisions())
    for (const core::Verdict& v : decision.verdicts) each(decision, v);
}

/// By publisher. Whichever links a gateway finds at its start. Later it keeps what it has granted,
/// so that more may be granted than after a start, and another set be used; but who is granted
/// something for certain keeps it.
std::vector<Range> ranges_of(const core::System& system) {
  std::vector<Range> ranges(system.publishers.size());
  constexpr unsigned cases = 1U << kNodes;
  for (unsigned linked = 0; linked < cases; ++linked) {
    core::State state(system);
    state.set_graph(0, graph_of(linked));
    state.decide();
    each_delivery(state, [&](const core::Decision& decision, const core::Verdict& v) {
      ranges[v.publisher].granted.insert(v.granted);
      if (v.granted) ranges[v.publisher].sets.insert(decision.set);
    });
    for (const unsigned then : {(linked + 1) % cases, cases - 1, linked, 0U, linked}) {
      state.set_graph(0, graph_of(then));
      state.settle();
      each_delivery(state, [&](const core::Decision&, const core::Verdict& v) {
        ranges[v.publisher].stays = ranges[v.publisher].stays && v.granted;
      });
    }
  }
  return ranges;
}

/// What check says of publishers that have no best case themselves.
struct Said {
  std::map<Outcome, std::size_t> outcomes;
  std::size_t open_sets = 0;
};

/// What it says with certainty is so in all cases.
void compare(const std::string& text, Said& said) {
  const auto system = description::read_memory(text, "z.xml", {}, description::Users::any);
  ASSERT_TRUE(system) << description::to_string(system.error().front()) << text;
  std::map<std::size_t, std::pair<Outcome, std::size_t>> checked;  // by publisher, with the set
  const core::Inspection inspection = core::inspect(
      *system, {},
      [&](std::size_t, const core::Decision& decision, std::span<const core::Finding>) {
        for (const core::Verdict& v : decision.verdicts)
          checked.try_emplace(v.publisher, v.outcome, decision.set);
      });
  const auto ranges = ranges_of(*system);
  for (const auto& [publisher, what] : checked) {
    const auto& [outcome, set] = what;
    const Range& range = ranges[publisher];
    const std::size_t channel = system->publishers[publisher].channel;
    const bool open_set = inspection.channels[channel].open_set;
    if (outcome != Outcome::run_time) {
      ASSERT_EQ(range.granted, std::set{outcome == Outcome::fit}) << publisher << text;
    }
    if (outcome == Outcome::fit) {
      ASSERT_TRUE(range.stays) << publisher << text;
    }
    if (outcome == Outcome::fit && !open_set) {
      ASSERT_EQ(range.sets, std::set{set}) << publisher << text;
    }
    if (system->publishers[publisher].place.index != 1) continue;
    ++said.outcomes[outcome];
    said.open_sets += open_set ? 1 : 0;
  }
}

TEST(Contested, CheckIsCertainOnlyOfWhatIsTheSameInAllCases) {
  Said said;
  Random random(1);
  for (std::uint64_t i = 0; i < kSystems; ++i) {
    compare(random_contest(random, 2 + random.below(4)), said);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(said.outcomes[Outcome::run_time], kSystems / 20);
  EXPECT_GT(said.outcomes[Outcome::fit], kSystems / 3);
  EXPECT_GT(said.outcomes[Outcome::unfit], kSystems / 20);
  EXPECT_GT(said.open_sets, kSystems / 50);
}

/// Not all cases can be tried then.
TEST(Contested, CheckIsAsCarefulWhereThereAreManyBestCases) {
  Said said;
  Random random(1);
  for (std::uint64_t i = 0; i < kSystems / 10; ++i) {
    compare(random_contest(random, 15 + random.below(10)), said);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(said.outcomes[Outcome::run_time], kSystems / 20);
}

/// Beside x, v has room for its lower set alone.
TEST(Contested, WhichAttributeSetIsUsedMayBeOpen) {
  std::string text = text_with("20kB/s");
  const std::string stated = R"(<Attributes period="10ms" maxPayload="120"/>)";
  text.replace(text.find(stated), stated.size(),
               R"(<Attributes priority="2" period="10ms" maxPayload="120"/>)"
               R"(<Attributes priority="1" period="100ms" maxPayload="120"/>)");
  const auto system = description::read_memory(text, "z.xml", {}, description::Users::any);
  ASSERT_TRUE(system) << description::to_string(system.error().front());
  const core::Inspection inspection = core::inspect(*system);
  EXPECT_EQ(inspection.channels[1].outcome, Outcome::fit);
  EXPECT_TRUE(inspection.channels[1].open_set);
  const auto said = std::ranges::count_if(inspection.findings, [](const core::Finding& f) {
    return f.text.starts_with(
        "channel v: which of its attribute sets is used is decided at run time");
  });
  EXPECT_EQ(said, 1);
}

TEST(Contested, GeneratedCodeRefusesNoneOfThem) {
  const core::System system = system_with("16kB/s");
  const tools::design::Decisions decisions(system);
  for (std::size_t p = 0; p < 3; ++p)
    EXPECT_TRUE(decisions.of(p, system.subscribers[p].place, 0).granted) << p;
}

}  // namespace
}  // namespace mlcca::testing
