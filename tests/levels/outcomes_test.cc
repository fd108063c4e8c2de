// SPDX-License-Identifier: BSD-2-Clause
// One outcome at every level where channels compete on a bus with what is decided at run time: in
// the summary of check, on its page, in analyse-bus and in generated code. And what may be granted
// there is late in no case that check does not warn of.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/allocation.hpp"
#include "core/admission/world.hpp"
#include "core/can/analysis.hpp"
#include "core/can/of_system.hpp"
#include "core/design/inspect.hpp"
#include "description/read.hpp"
#include "tests/description/twin/random_values.hpp"
#include "tests/description/twin/twin.hpp"
#include "tests/levels/checked.hpp"
#include "tests/tools/design/check/program.hpp"
#include "tools/design/generate/checks.hpp"
#include "tools/design/generate/header.hpp"
#include "tools/design/generate/unit.hpp"

namespace mlcca::testing {
namespace {
namespace design = mlcca::tools::design;

constexpr std::uint64_t kRows = 1500;       // random rows of buses
constexpr std::uint64_t kRowsByCase = 400;  // of them: all their cases are decided

/// Publishers of buses in a row and of the gateways between them, some of which give best cases.
std::string random_row(Random& random) {
  const std::uint64_t buses = 2 + random.below(2);
  std::vector<unsigned> identifiers{1, 2, 3, 4, 5, 6, 7, 8};
  const bool several_sets = random.one_in(4);
  std::string channels;
  std::string ends;
  std::string bindings;
  const std::uint64_t count = 3 + random.below(3);
  for (std::uint64_t c = 0; c < count; ++c) {
    const auto at =
        identifiers.begin() + static_cast<std::ptrdiff_t>(random.below(identifiers.size()));
    bindings += fmt::format(
        R"(<Binding channel="c{}"><Identifier form="standard">0x{}0</Identifier></Binding>)", c,
        *at);
    identifiers.erase(at);
    channels += fmt::format("<EventChannel name=\"c{}\"><SubjectUID>0x{}</SubjectUID>", c, c + 1);
    const std::uint64_t sets = several_sets ? 1 + random.below(2) : 1;
    for (std::uint64_t set = 0; set < sets; ++set)
      channels += fmt::format(R"(<Attributes{} period="{}ms" deadline="{}us" maxPayload="{}"/>)",
                              sets > 1 ? fmt::format(" priority=\"{}\"", 9 - set) : "",
                              random.one_of(std::array{2, 5, 20}),
                              random.one_of(std::array{350, 500, 600, 900, 1200, 1900, 5000}),
                              1 + random.below(8));
    channels += "</EventChannel>\n";
    const std::uint64_t near = random.below(buses);
    const std::uint64_t far = near == 0 ? 1 : near - random.below(2);
    const std::uint64_t gateway = std::min(near, buses - 2);
    const bool by_program = random.one_in(4);
    ends += fmt::format(R"(<Publisher name="p{0}" channel="c{0}" {1}/>)", c,
                        by_program ? fmt::format(R"(gateway="g{}" user="u{}")", gateway, c)
                                   : fmt::format("network=\"b{}\"", near));
    ends += fmt::format("<Subscriber channel=\"c{}\" network=\"b{}\"/>\n", c,
                        by_program ? gateway : far);
    if (!by_program && far != near && random.one_in(4))
      ends += fmt::format("<Subscriber channel=\"c{}\" network=\"b{}\"/>\n", c, near);
  }
  for (std::uint64_t b = 0; b < buses; ++b)
    channels += fmt::format(
        "<Network name=\"b{}\"><Kind>can</Kind><Profile>raw</Profile><Bus bitrate=\"500000\"/>{}"
        "</Network>\n",
        b, bindings);
  for (std::uint64_t g = 0; g + 1 < buses; ++g)
    channels += fmt::format(
        "<Gateway name=\"g{0}\"><Provision{2} latency=\"10us\" jitter=\"10us\"/><Port "
        "network=\"b{0}\"><Interface name=\"can0\"/></Port><Port network=\"b{1}\"><Interface "
        "name=\"can1\"/></Port></Gateway>\n",
        g, g + 1, g == 0 || random.one_in(2) ? " dynamic=\"true\"" : "");
  return "<System name=\"z\">" + channels + ends + "</System>";
}

core::System read(const std::string& text) {
  auto system = description::read_memory(text, "z.xml", {}, description::Users::any);
  EXPECT_TRUE(system) << description::to_string(system.error().front()) << text;
  system->sort_bindings();
  return std::move(*system);
}

/// Of a channel there is more to refuse than deliveries.
bool is_refused_as_a_whole(const core::Inspection& inspection, std::size_t channel) {
  using enum core::FindingId;
  return std::ranges::any_of(inspection.findings, [channel](const core::Finding& f) {
    return f.channel == channel &&
           (f.id == sender_twice || f.id == too_many || f.id == no_publisher);
  });
}

bool is_found_wrong(const core::Inspection& inspection, std::size_t channel) {
  return std::ranges::any_of(inspection.findings, [channel](const core::Finding& f) {
    return f.channel == channel && core::info(f.id).severity == core::Severity::error;
  });
}

/// What is reported of each channel, for the page and for generated code, and what the summary
/// counts it as.
struct Reported {
  core::Inspection inspection;
  core::InspectedBuses buses;
  std::map<std::size_t, core::Decision> decisions;  ///< by channel
};

Reported reported(const core::System& system) {
  Reported out;
  out.inspection = core::inspect(
      system, {},
      [&out](std::size_t channel, const core::Decision& decision, std::span<const core::Finding>) {
        out.decisions.try_emplace(channel, decision);
      },
      &out.buses);
  return out;
}

Outcome worst_of(const core::Decision& decision) {
  Outcome worst = Outcome::fit;
  for (const core::Verdict& v : decision.verdicts) worst = worse(worst, v.outcome);
  return worst;
}

using Counts = std::map<Outcome, std::size_t>;

void compare_channels(const core::System& system, const std::string& text, Counts& counts) {
  const Reported all = reported(system);
  for (const auto& [channel, decision] : all.decisions) {
    if (is_refused_as_a_whole(all.inspection, channel)) continue;
    const Outcome outcome = all.inspection.channels[channel].outcome;
    ++counts[outcome];
    ASSERT_EQ(worst_of(decision), outcome) << "channel " << channel << "\n" << text;
    ASSERT_EQ(is_found_wrong(all.inspection, channel), outcome == Outcome::unfit)
        << "channel " << channel << "\n"
        << text;
    if (decision.verdicts.size() != 1) continue;
    for (const core::BusMessage& m : all.buses.messages) {
      if (m.publisher != decision.verdicts.front().publisher) continue;
      ASSERT_EQ(m.outcome, outcome) << "channel " << channel << "\n" << text;
    }
  }
}

TEST(Outcomes, OnBusesAreThoseOfTheSummary) {
  Counts counts;
  Random random(1);
  for (std::uint64_t i = 0; i < kRows; ++i) {
    const std::string text = random_row(random);
    compare_channels(read(text), text, counts);
    if (HasFatalFailure()) return;
  }
  for (const Outcome outcome : {Outcome::fit, Outcome::run_time, Outcome::unfit})
    EXPECT_GT(counts[outcome], kRows / 5);
}

TEST_F(Levels, TheOutcomeOfAChannelIsTheWorstOfItsDeliveries) {
  Counts counts;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    compare_channels(all_[i].system, texts_[i], counts);
    if (HasFatalFailure()) return;
  }
  for (const Outcome outcome : {Outcome::fit, Outcome::run_time, Outcome::unfit})
    EXPECT_GT(counts[outcome], kSystems / 30);
}

/// Which buses have something that is granted and late if those best cases hold: what their nodes
/// send is there though it is refused.
class Cases {
 public:
  explicit Cases(const core::System& system)
      : s_(system),
        topology_(system),
        members_(system),
        world_(core::described_world(system)),
        withdrawn_(system.channels.size(), false) {
    for (std::size_t p = 0; p < s_.publishers.size(); ++p)
      for (const core::Subscriber& s : s_.subscribers)
        if (s.channel == s_.publishers[p].channel) ends_.emplace_back(p, s.place);
  }

  std::set<std::size_t> harmed() const {
    std::set<std::size_t> out;
    for (unsigned which = 0; which < 1U << ends_.size(); ++which) add_harmed(which, out);
    return out;
  }

 private:
  [[nodiscard]] bool holds(unsigned which, const core::Verdict& v) const {
    const auto found = std::ranges::find(ends_, std::pair(v.publisher, v.to));
    return (which >> (found - ends_.begin()) & 1U) != 0;
  }

  void add_harmed(unsigned which, std::set<std::size_t>& out) const {
    core::Situation situation{s_, topology_, members_, world_, withdrawn_, true};
    const core::BestCasesHold hold = [&](const core::Verdict& v) { return holds(which, v); };
    situation.hold = &hold;
    core::Ledger ledger = core::empty_ledger(s_, world_);
    std::vector<core::Verdict> verdicts;
    core::decide_each(situation, ledger, [&](std::size_t, const core::Decision& decision) {
      verdicts.insert(verdicts.end(), decision.verdicts.begin(), decision.verdicts.end());
    });
    for (std::size_t n = 0; n < s_.networks.size(); ++n)
      if (is_harmed(*ledger.schedule(n), n, verdicts)) out.insert(n);
  }

  [[nodiscard]] bool is_harmed(const core::can::Schedule& bus, std::size_t network,
                               const std::vector<core::Verdict>& verdicts) const {
    std::vector<core::can::Message> messages(bus.messages().begin(), bus.messages().end());
    const std::size_t granted = messages.size();
    for (const core::Verdict& v : verdicts) {
      const core::Publisher& p = s_.publishers[v.publisher];
      const std::uint64_t key = core::Ledger::key_of({v.publisher, network, core::Flow::kOwn});
      if (p.place != core::Place{core::Place::Kind::network, network} ||
          std::ranges::find(messages, key, &core::can::Message::key) != messages.end())
        continue;
      messages.push_back(*core::can::message_of(s_, p, v.set, network, bus.assumptions().timing));
      messages.back().key = key;
    }
    const auto responses = core::can::analyse(bus.assumptions(), messages);
    for (std::size_t i = 0; i < granted; ++i)
      if (!core::can::fits(bus.assumptions(), messages[i], responses[i])) return true;
    return false;
  }

  const core::System& s_;
  core::Topology topology_;
  core::Members members_;
  core::World world_;
  std::vector<bool> withdrawn_;
  std::vector<std::pair<std::size_t, core::Place>> ends_;
};

struct Warned {
  std::size_t rightly = 0;
  std::size_t in_vain = 0;
  std::size_t of_open = 0;  ///< senders that may be refused
};

void compare_warnings(const core::System& system, const std::string& text, Warned& warned) {
  const core::Inspection inspection = core::inspect(system);
  // What is sent in other sets than that of all best cases is not known.
  for (std::size_t c = 0; c < system.channels.size(); ++c)
    if (inspection.channels[c].open_set ||
        (core::sets_of(system, c) > 1 && inspection.channels[c].outcome != Outcome::fit))
      return;
  const std::set<std::size_t> harmed = Cases(system).harmed();
  std::set<std::size_t> said;
  for (const core::Finding& f : inspection.findings) {
    if (f.id != core::FindingId::refused_on_bus) continue;
    said.insert(f.place.index);
    warned.of_open += f.text.contains(" may be refused") ? 1 : 0;
  }
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    ASSERT_TRUE(said.contains(n) || !harmed.contains(n)) << system.networks[n].name << "\n" << text;
    if (said.contains(n)) ++(harmed.contains(n) ? warned.rightly : warned.in_vain);
  }
}

TEST(Outcomes, WhoeverMayBeGrantedAndBeLateThenIsWarnedOf) {
  Warned warned;
  Random random(1);
  for (std::uint64_t i = 0; i < kRowsByCase; ++i) {
    const std::string text = random_row(random);
    compare_warnings(read(text), text, warned);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(warned.rightly, kRowsByCase / 20);
  EXPECT_GT(warned.of_open, kRowsByCase / 100);
  EXPECT_LT(warned.in_vain, warned.rightly / 4) << warned.rightly;
}

/// While x is away v is granted and w refused, and otherwise w and not v.
constexpr const char* kMix = R"(<System name="mix">
  <EventChannel name="x"><SubjectUID>0x1</SubjectUID>
    <Attributes period="5ms" deadline="60ms" maxPayload="8"/></EventChannel>
  <EventChannel name="v"><SubjectUID>0x2</SubjectUID>
    <Attributes period="2ms" deadline="500us" maxPayload="8"/></EventChannel>
  <EventChannel name="w"><SubjectUID>0x3</SubjectUID>
    <Attributes period="20ms" maxPayload="8"/></EventChannel>
  <Network name="mesh"><Kind>mesh</Kind><Profile>famouso</Profile>
    <Mesh><PerHop latency="20ms" jitter="12ms"/>
      <Node name="a" address="02:00:00:00:00:01" gateway="g"/>
      <Node name="c" address="02:00:00:00:00:03"/>
      <Source kind="file" endpoint="/nowhere"/></Mesh></Network>
  <Network name="b"><Kind>can</Kind><Profile>raw</Profile><Bus bitrate="500000"/>
    <Binding channel="x"><Identifier form="standard">0x10</Identifier></Binding>
    <Binding channel="v"><Identifier form="standard">0x20</Identifier></Binding>
    <Binding channel="w"><Identifier form="standard">0x30</Identifier></Binding></Network>
  <Gateway name="g"><Provision latency="1ms" jitter="500us"/>
    <Port network="mesh"><Interface name="awds0"/></Port>
    <Port network="b"><Interface name="can0"/></Port></Gateway>
  <Publisher channel="x" network="mesh" mesh-node="c"/><Subscriber channel="x" network="b"/>
  <Publisher channel="v" gateway="g" user="nobody"/><Subscriber channel="v" network="b"/>
  <Publisher channel="w" network="b"/><Subscriber channel="w" network="b"/>
</System>)";

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

class Mix : public test::CheckTest {
 protected:
  [[nodiscard]] std::string path() const { return file("mix.xml", kMix); }
};

TEST_F(Mix, IsLeftToTheRunTimeByCheck) {
  const auto checked = test::run({"check", path()});
  EXPECT_TRUE(checked.out.contains("0 errors, 1 warning, 3 notes")) << checked.out;
  EXPECT_TRUE(checked.out.contains("0 fit, 3 decided at run time, 0 do not fit")) << checked.out;
  for (const char* ends : {"x@mesh to b", "v@g to b", "w@b to b"})
    EXPECT_TRUE(checked.out.contains(ends)) << ends << checked.out;
  EXPECT_TRUE(checked.out.contains(
      "MLCCA044: w@b may be refused, and no gate keeps its frames off b: while they are sent, v@g "
      "could take 540 us of the 500 us"))
      << checked.out;
}

TEST_F(Mix, IsLeftToTheRunTimeByThePage) {
  const auto page = test::run({"check", "--format", "html", path()}).out;
  EXPECT_EQ(count_of(page, "\"outcome\":\"run-time\""), 3U) << page;
  EXPECT_EQ(count_of(page, "\"outcome\":\"unfit\""), 0U);
}

TEST_F(Mix, IsLeftToTheRunTimeByAnalyseBus) {
  const auto json = test::run({"analyse-bus", "--json", path()}).out;
  EXPECT_EQ(count_of(json, "\"outcome\":\"run-time\""), 3U) << json;
  EXPECT_EQ(count_of(json, "\"outcome\":"), 3U) << json;
}

TEST_F(Mix, IsRefusedByNoCompiler) {
  const core::System system = read(kMix);
  const design::Decisions decisions(system);
  const auto units = design::units_of(system, {});
  ASSERT_TRUE(units);
  std::string all;
  for (const auto& unit : *units) {
    const auto header = design::header_of(system, decisions, unit);
    ASSERT_TRUE(header) << header.error().text;
    all += "#include \"" + file(unit.stem + ".hpp", header->text) + "\"\n";
  }
  EXPECT_EQ(output_of(fmt::format("g++ -std=c++14 -fsyntax-only -Iinclude '{}' 2>&1; true",
                                  file("all.cpp", all))),
            "");
}

TEST_F(Mix, IsRefusedByNoStylesheet) {
  for (const Key& key : twin_findings({path()}).front())
    EXPECT_TRUE(is_note(key)) << to_string(key);
}

}  // namespace
}  // namespace mlcca::testing
