// SPDX-License-Identifier: BSD-2-Clause
// Response times that check and analyse-bus print hold whichever best cases do, and however long
// the delays are that nobody knows before the run time: of random systems each case is decided, and
// what is then on the bus is analysed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/admission/allocation.hpp"
#include "core/admission/world.hpp"
#include "core/can/analysis.hpp"
#include "core/can/of_system.hpp"
#include "core/design/bus_responses.hpp"
#include "core/design/inspect.hpp"
#include "description/read.hpp"
#include "tests/description/twin/random_values.hpp"

namespace mlcca::testing {
namespace {

constexpr std::uint64_t kSystems = 1500;
constexpr std::size_t kB = 1;  // the bus where they meet

/// Channels to b: from a over a gateway whose Latency is a best case, from c over another one, and
/// of nodes of b, whose events go on to a or not.
std::string random_buses(Random& random) {
  std::string text;
  std::string ends;
  std::map<char, std::string> bindings;
  std::vector<unsigned> identifiers{1, 2, 3, 4, 5, 6, 7, 8};
  const bool several_sets = random.one_in(4);
  const bool importances = random.one_in(3);
  const std::uint64_t count = 3 + random.below(4);
  for (std::uint64_t c = 0; c < count; ++c) {
    const auto at =
        identifiers.begin() + static_cast<std::ptrdiff_t>(random.below(identifiers.size()));
    const unsigned id = *at;
    identifiers.erase(at);
    text +=
        fmt::format("<EventChannel name=\"c{}\"{}><SubjectUID>0x{}</SubjectUID>", c,
                    importances ? fmt::format(" importance=\"{}\"", random.below(3)) : "", c + 1);
    const std::uint64_t sets = several_sets ? 1 + random.below(2) : 1;
    for (std::uint64_t set = 0; set < sets; ++set)
      text += fmt::format("<Attributes{} period=\"{}ms\" deadline=\"{}us\" maxPayload=\"{}\"/>",
                          sets > 1 ? fmt::format(" priority=\"{}\"", 9 - set) : "",
                          random.one_of(std::array{2, 5, 20}),
                          random.one_of(std::array{350, 600, 900, 1200, 1900, 5000}),
                          1 + random.below(8));
    text += "</EventChannel>\n";
    constexpr std::array<const char*, 5> ways{"ab", "ab", "cb", "bb", "ba"};
    const std::string way = random.one_of(ways);
    for (const char bus : way == "bb" ? std::string("b") : way)
      bindings[bus] += fmt::format(
          "<Binding channel=\"c{}\"><Identifier form=\"standard\">{}</Identifier></Binding>", c,
          fmt::format("0x{}0", id));
    ends += fmt::format(
        "<Publisher name=\"p{0}\" channel=\"c{0}\" network=\"{1}\"/><Subscriber channel=\"c{0}\" "
        "network=\"{2}\"/>\n",
        c, way.front(), way.back());
    // A second place behind the bus, which is decided for itself.
    if (way == "ab" && random.one_in(4)) {
      bindings['c'] += fmt::format(
          "<Binding channel=\"c{}\"><Identifier form=\"standard\">0x{}0</Identifier></Binding>", c,
          id);
      ends += fmt::format(
          "<Subscriber channel=\"c{}\" network=\"c\"><Attributes deadline=\"{}us\"/>"
          "</Subscriber>\n",
          c, random.one_of(std::array{900, 1200, 1900, 5000}));
    }
  }
  const bool both_ways = random.one_in(2);
  for (const char bus : {'a', 'b', 'c'})
    text += fmt::format(
        "<Network name=\"{}\"><Kind>can</Kind><Profile>raw</Profile><Bus bitrate=\"500000\"/>{}"
        "</Network>\n",
        bus, bindings[bus]);
  for (const char from : {'a', 'c'})
    text += fmt::format(
        "<Gateway name=\"g{0}\"><Provision{1} latency=\"10us\" jitter=\"10us\"/><Port "
        "network=\"{0}\">"
        "<Interface name=\"can0\"/></Port><Port network=\"b\"><Interface name=\"can1\"/></Port>"
        "</Gateway>\n",
        from, from == 'a' || both_ways ? " dynamic=\"true\"" : "");
  return "<System name=\"z\">" + text + ends + "</System>";
}

struct Bound {
  bool counted = false;
  core::SentMessage sent;
};

struct Bounds {
  std::map<std::tuple<std::size_t, std::size_t>, Bound> of;  ///< by publisher and from
  bool sure = false;
  bool all_known = false;
  bool forms_known = false;
};

Bounds bounds_on(const core::InspectedBuses& buses, std::size_t network) {
  Bounds out;
  for (const core::SentMessage& sent : core::sent_beside(buses, network))
    out.of[{sent.message->publisher, sent.message->from}] = {sent.message->is_counted(), sent};
  out.all_known = buses.all_known[network];
  out.forms_known = buses.forms_known[network];
  out.sure = buses.guarded[network] || out.all_known;
  return out;
}

struct Met {
  std::size_t compared = 0;
  std::size_t by_admission = 0;
  std::size_t contested = 0;
  std::size_t reached = 0;
  std::size_t several = 0;
  std::size_t delayed = 0;  ///< compared beside a delay that was not known
};

using Ends = std::pair<std::size_t, core::Place>;  ///< a publisher, and where its events go

/// Each of which is decided for itself.
std::vector<Ends> all_ends(const core::System& system) {
  std::vector<Ends> out;
  for (std::size_t p = 0; p < system.publishers.size(); ++p)
    for (const core::Subscriber& s : system.subscribers)
      if (s.channel == system.publishers[p].channel) out.emplace_back(p, s.place);
  return out;
}

/// What is on b if those best cases hold: what is granted, and what its nodes send though refused.
std::vector<core::can::Message> messages_on_b(const core::System& system,
                                              const std::vector<Ends>& holding,
                                              std::vector<core::Decision>& decisions) {
  const core::Topology topology(system);
  const core::Members members(system);
  const core::World world = core::described_world(system);
  const std::vector<bool> withdrawn(system.channels.size(), false);
  core::Situation situation{system, topology, members, world, withdrawn, true};
  const core::BestCasesHold hold = [&holding](const core::Verdict& v) {
    return std::ranges::find(holding, Ends{v.publisher, v.to}) != holding.end();
  };
  situation.hold = &hold;
  core::Ledger ledger = core::empty_ledger(system, world);
  decisions.assign(system.channels.size(), {});
  core::decide_each(situation, ledger, [&](std::size_t channel, const core::Decision& decision) {
    decisions[channel] = decision;
  });
  const core::can::Schedule& bus = *ledger.schedule(kB);
  std::vector<core::can::Message> messages(bus.messages().begin(), bus.messages().end());
  for (const core::Decision& decision : decisions)
    for (const core::Verdict& v : decision.verdicts) {
      const core::Publisher& p = system.publishers[v.publisher];
      if (v.granted || p.place != core::Place{core::Place::Kind::network, kB}) continue;
      auto message = core::can::message_of(system, p, v.set, kB, bus.assumptions().timing);
      message->key = core::Ledger::key_of({v.publisher, kB, core::Flow::kOwn});
      message->deadline = core::can::kNever;
      messages.push_back(*message);
    }
  return messages;
}

/// What is then on b is no later than the bounds say. `delays`: those of gateways are other ones
/// than the best cases that rows of messages over them count with.
void compare(const core::System& system, const Bounds& bounds,
             const core::can::Assumptions& assumptions, const std::vector<Ends>& holding,
             bool delays, Met& met) {
  std::vector<core::Decision> decisions;
  const auto messages = messages_on_b(system, holding, decisions);
  const auto responses = core::can::analyse(assumptions, messages);
  const bool known = delays ? bounds.forms_known : bounds.all_known;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const std::size_t publisher = core::Ledger::publisher_of(messages[i].key);
    const auto found = std::ranges::find_if(
        bounds.of, [&](const auto& one) { return std::get<0>(one.first) == publisher; });
    if (!known && found == bounds.of.end()) continue;
    ASSERT_NE(found, bounds.of.end()) << publisher;
    const Bound& bound = found->second;
    ASSERT_TRUE(bound.counted || !known) << publisher;
    const auto& decision = decisions[system.publishers[publisher].channel];
    if (!bound.counted || decision.set != bound.sent.message->set) continue;
    if (!bound.sent.response.bounded) continue;
    if (delays && !bound.sent.message->unknown.empty()) continue;
    ASSERT_TRUE(responses[i].bounded) << publisher;
    ASSERT_LE(responses[i].response, bound.sent.response.response) << publisher;
    ++met.compared;
    met.by_admission += bound.sent.by_admission ? 1 : 0;
    met.reached += responses[i].response == bound.sent.response.response ? 1 : 0;
    met.delayed += delays && !bounds.all_known && !bound.sent.by_admission ? 1 : 0;
  }
}

/// The system as it may turn out: each gateway delays events by a time of its own.
core::System with_delays(core::System system, Random& random) {
  for (core::Gateway& gateway : system.gateways) {
    if (!gateway.provision.is_dynamic(Attribute::latency)) continue;
    const Value delay = random.one_of(
        std::array<Value, 6>{10'000, 100'000, 300'000, 700'000, 1'500'000, 4'000'000});
    gateway.provision.set(Attribute::latency, delay);
    gateway.provision.set(Attribute::jitter, random.one_in(2) ? delay : delay / 2);
  }
  return system;
}

void compare(const std::string& text, Met& met, Random& random) {
  auto system = description::read_memory(text, "z.xml", {}, description::Users::any);
  ASSERT_TRUE(system) << description::to_string(system.error().front()) << text;
  core::InspectedBuses buses;
  static_cast<void>(core::inspect(*system, {}, {}, &buses));
  const Bounds bounds = bounds_on(buses, kB);
  if (!bounds.sure) return;
  const core::can::Assumptions& assumptions = *buses.assumptions[kB];
  met.contested += std::ranges::count_if(
      buses.messages, [](const auto& m) { return m.is_counted() && !m.present; });
  const std::vector<Ends> all = all_ends(*system);
  met.several += all.size() > system->publishers.size() ? 1 : 0;
  for (unsigned which = 0; which < 1U << all.size(); ++which) {
    std::vector<Ends> holding;
    for (std::size_t e = 0; e < all.size(); ++e)
      if ((which >> e & 1U) != 0) holding.push_back(all[e]);
    compare(*system, bounds, assumptions, holding, false, met);
    if (::testing::Test::HasFatalFailure()) FAIL() << " if " << which << "\n" << text;
  }
  constexpr unsigned turns = 12;
  for (unsigned turn = 0; turn < turns; ++turn) {
    const core::System delayed = with_delays(*system, random);
    compare(delayed, bounds, assumptions, {}, true, met);
    if (!::testing::Test::HasFatalFailure()) continue;
    for (const core::Gateway& gateway : delayed.gateways)
      ADD_FAILURE() << gateway.name << " takes " << gateway.provision[Attribute::latency];
    FAIL() << text;
  }
}

TEST(BusBounds, NothingIsLaterThanItsRowSaysWhicheverBestCasesHold) {
  Met met;
  Random random(1);
  for (std::uint64_t i = 0; i < kSystems; ++i) {
    compare(random_buses(random), met, random);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(met.compared, kSystems * 10);
  EXPECT_GT(met.by_admission, kSystems / 10);
  EXPECT_GT(met.contested, kSystems / 20);
  EXPECT_GT(met.reached, met.compared / 10);
  EXPECT_GT(met.several, kSystems / 100);
  EXPECT_GT(met.delayed, kSystems / 2);
}

}  // namespace
}  // namespace mlcca::testing
