// SPDX-License-Identifier: BSD-2-Clause
// One answer at every level: what check grants is granted by the daemon and compiles, and what it
// refuses is refused by both.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "core/admission/allocation.hpp"
#include "core/admission/state.hpp"
#include "core/admission/world.hpp"
#include "core/can/analysis.hpp"
#include "core/can/of_system.hpp"
#include "core/design/inspect.hpp"
#include "tests/description/twin/random_values.hpp"
#include "tests/description/twin/twin.hpp"
#include "tests/levels/checked.hpp"
#include "tools/design/analyse_bus/bus.hpp"
#include "tools/design/generate/checks.hpp"
#include "tools/design/generate/header.hpp"
#include "tools/design/generate/unit.hpp"

namespace mlcca::testing {
namespace {
namespace design = mlcca::tools::design;
namespace mesh = mlcca::core::mesh;

constexpr std::uint64_t kCompiled = 200;  // of them
constexpr std::size_t kRefused = 40;      // headers, each compiled alone

/// Whether check has an error for a delivery of the channel in which the end takes part.
bool has_error_of(const Checked& checked, design::End end) {
  const auto channel = design::channel_of(checked.system, end);
  const bool publishes = end.role == der::Role::publisher;
  for (const auto& [delivery, granted] : checked.granted) {
    const auto& [c, publisher, place] = delivery;
    if (c != channel || granted) continue;
    if (publishes ? publisher == end.index : place == design::place_of(checked.system, end))
      return true;
  }
  for (const auto& f : checked.inspection.findings) {
    if (f.channel != channel) continue;
    if (f.id == core::FindingId::sender_twice || f.id == core::FindingId::too_many) return true;
    if (f.id == core::FindingId::no_publisher && !publishes) return true;
  }
  return false;
}

/// A source beside the description knows its links.
bool is_measured(const core::Network& network) {
  if (!network.mesh) return false;
  return std::ranges::any_of(network.mesh->sources, [](const mesh::Source& source) {
    return source.kind != mesh::SourceKind::description;
  });
}

enum class Knows : std::uint8_t { described_links, no_measured_links, random_links };

/// Of any two nodes, or not, and better ones and worse than those that are described.
mesh::Graph random_graph(std::size_t nodes, Random& random) {
  mesh::Graph graph;
  graph.nodes = nodes;
  for (std::uint32_t from = 0; from < graph.nodes; ++from)
    for (std::uint32_t to = 0; to < graph.nodes; ++to) {
      if (from == to || random.one_in(3)) continue;
      mesh::Link& link = graph.links.emplace_back();
      link.from = from;
      link.to = to;
      link.quality.rate = 500'000 << random.below(10);
      link.quality.loss_known = random.one_in(2);
      if (link.quality.loss_known) link.quality.loss = random.below(4) * 10'000'000;
    }
  return graph;
}

/// What a gateway decides when it knows the links that are described, while no source has reported
/// any, or when others have been measured.
std::unique_ptr<core::State> daemon_of(const core::System& system, Random& random,
                                       Knows knows = Knows::described_links) {
  auto state = std::make_unique<core::State>(system);
  const core::World world = core::described_world(system);
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    if (!world.meshes[n]) continue;
    mesh::Graph graph = world.meshes[n]->graph;
    if (system.networks[n].mesh->sources.empty() ||
        (knows == Knows::no_measured_links && is_measured(system.networks[n])))
      graph.links.clear();
    if (knows == Knows::random_links && is_measured(system.networks[n]))
      graph = random_graph(graph.nodes, random);
    state->set_graph(n, std::move(graph));
  }
  state->decide();
  return state;
}

/// The same without the publishers and subscribers of other channels, which take of what there is.
core::System alone(core::System system, std::size_t channel) {
  std::erase_if(system.publishers, [&](const auto& p) { return p.channel != channel; });
  std::erase_if(system.subscribers, [&](const auto& s) { return s.channel != channel; });
  return system;
}

TEST_F(Levels, TheDaemonRefusesOneOfTwoSendersOfOneIdentifier) {
  std::size_t found = 0;
  for (const auto& one : all_)
    for (const auto& f : one.inspection.findings) {
      if (f.id != core::FindingId::sender_twice) continue;
      ++found;
      Random random(1);
      const auto state = daemon_of(one.system, random);
      EXPECT_FALSE(state->decisions()[f.channel].all_granted()) << f.text;
    }
  EXPECT_GT(found, 0U);
}

TEST_F(Levels, BothAnswersOfCheckAreFrequent) {
  std::map<Outcome, std::size_t> channels;
  std::size_t computed = 0;
  for (const auto& one : all_) {
    for (const auto& channel : one.inspection.channels)
      if (channel.deliveries != 0) ++channels[channel.outcome];
    for (const auto& network : one.system.networks)
      computed += network.mesh || core::can::timing_of(network).bitrate != 0 ? 1 : 0;
  }
  EXPECT_GT(channels[Outcome::fit], kSystems / 5);
  EXPECT_GT(channels[Outcome::unfit], kSystems / 5);
  EXPECT_GT(channels[Outcome::run_time], kSystems / 30);
  EXPECT_GT(computed, kSystems);
}

/// Two gateways join the same two networks.
bool has_several_ways(const core::System& system) {
  for (std::size_t a = 0; a < system.gateways.size(); ++a)
    for (std::size_t b = a + 1; b < system.gateways.size(); ++b) {
      std::size_t common = 0;
      for (std::size_t n = 0; n < system.networks.size(); ++n)
        common +=
            system.gateways[a].port_on(n) != nullptr && system.gateways[b].port_on(n) != nullptr
                ? 1
                : 0;
      if (common > 1) return true;
    }
  return false;
}

/// What no system has would never be compared.
TEST_F(Levels, EverythingThatIsComputedOrChosenIsFrequent) {
  for (const std::string_view what : {"<Bus bitrate",
                                      "<PerHop>",
                                      "<Link ",
                                      " both-ways=",
                                      "k-hop",
                                      "packet-time",
                                      "<Source kind=\"file\"",
                                      "<Attributes priority",
                                      "<Composition>sum",
                                      "<Composition>maximum",
                                      "<Composition>minimum",
                                      "<Composition>survival",
                                      "<Name>Jitter",
                                      "<Name>PacketLoss",
                                      "<Name>Omission",
                                      "<Name>Bandwidth",
                                      " period=\"",
                                      " jitter=\"",
                                      " bandwidth=\"",
                                      " maxPayload=\"",
                                      "<PerHop latency=",
                                      "dynamic=\"true\"",
                                      "importance=",
                                      "format=\"fd\"",
                                      " unknown-senders",
                                      " errors=",
                                      " background-load=",
                                      "queue=\"priority\"",
                                      " fifo-depth=",
                                      " queue-length=",
                                      " sender=",
                                      "<Route ",
                                      ">udp-multicast<",
                                      ">famouso<",
                                      ">raw<",
                                      ">j1939<",
                                      ">cyphal<",
                                      ">canopen<",
                                      ">udp-broadcast<",
                                      ">ieee802154<",
                                      "<Value>70000<"}) {
    const auto with = static_cast<std::size_t>(std::ranges::count_if(
        texts_, [&](const std::string& text) { return text.contains(what); }));
    EXPECT_GT(with, kSystems / 50) << what;
  }
  EXPECT_GT(std::ranges::count_if(all_, has_several_ways, &Checked::system), kSystems / 10);
}

/// An error names what keeps each delivery from being granted: a count alone helps nobody.
TEST_F(Levels, WhatCheckRefusesItHasAnErrorFor) {
  std::size_t refused = 0;
  for (std::size_t i = 0; i < all_.size(); ++i)
    for (const auto& [delivery, granted] : all_[i].granted) {
      if (granted) continue;
      const auto& [channel, publisher, to] = delivery;
      ++refused;
      ASSERT_TRUE(std::ranges::any_of(
          all_[i].inspection.findings,
          [&](const core::Finding& f) {
            return f.channel == channel && core::info(f.id).severity == core::Severity::error &&
                   (f.publisher == core::kNone || f.publisher == publisher);
          }))
          << "channel " << channel << "\n"
          << texts_[i];
    }
  EXPECT_GT(refused, kSystems);
}

/// What check says with certainty holds whatever the run time finds.
void compare(const Checked& checked, const core::State& daemon, const std::string& text,
             std::size_t& compared) {
  for (std::size_t c = 0; c < daemon.decisions().size(); ++c) {
    const core::Decision& decision = daemon.decisions()[c];
    for (const core::Verdict& v : decision.verdicts) {
      const Delivery delivery{c, v.publisher, v.to};
      if (checked.at_run_time.contains(delivery)) continue;
      ++compared;
      ASSERT_EQ(v.granted, checked.granted.at(delivery)) << "channel " << c << "\n" << text;
    }
    const core::ChannelResult& result = checked.inspection.channels[c];
    if (result.outcome == Outcome::fit && !result.open_set && result.deliveries != 0) {
      ASSERT_EQ(decision.set, result.set) << "channel " << c << "\n" << text;
    }
  }
}

TEST_F(Levels, TheDaemonDecidesAsCheckSays) {
  Random random(1);
  std::size_t compared = 0;
  for (std::size_t i = 0; i < all_.size(); ++i)
    for (const Knows knows : {Knows::described_links, Knows::no_measured_links, Knows::random_links,
                              Knows::random_links}) {
      if (knows != Knows::described_links &&
          std::ranges::none_of(all_[i].system.networks, is_measured))
        continue;
      compare(all_[i], *daemon_of(all_[i].system, random, knows), texts_[i], compared);
      if (HasFatalFailure()) return;
    }
  EXPECT_GT(compared, kSystems);
}

TEST_F(Levels, NothingWaitsForLinksThatNothingCanKnow) {
  std::size_t without = 0;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    without += all_[i].without_links;
    ASSERT_EQ(all_[i].awaits_links, 0U) << texts_[i];
  }
  EXPECT_GT(without, kSystems / 100);
}

/// MLCCA042 is no error beside channels that fit: where events stay at one node no link is missing.
TEST_F(Levels, LinksAreMissingWhereSomethingIsRefusedForThem) {
  std::size_t missing = 0;
  std::size_t granted = 0;
  for (std::size_t i = 0; i < all_.size(); ++i)
    for (const auto& [network, misses] : all_[i].misses_links) {
      const bool said = std::ranges::any_of(
          all_[i].inspection.findings, [network = network](const core::Finding& f) {
            return f.id == core::FindingId::no_links &&
                   f.place == core::Place{core::Place::Kind::network, network};
          });
      const bool all_granted = !all_[i].refused_over.contains(network);
      ASSERT_TRUE(said || !misses) << texts_[i];
      ASSERT_FALSE(said && all_granted) << texts_[i];
      missing += misses ? 1 : 0;
      granted += all_granted ? 1 : 0;
    }
  EXPECT_GT(missing, kSystems / 100);
  EXPECT_GT(granted, kSystems / 1000);
}

TEST_F(Levels, TheDaemonRefusesWhatCheckRefuses) {
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (!core::is_plain(all_[i].system)) continue;
    bool only_errors = true;
    for (const auto& [delivery, granted] : all_[i].granted) only_errors &= !granted;
    if (!only_errors) continue;
    Random random(1);
    const auto daemon = daemon_of(all_[i].system, random);
    for (const auto& decision : daemon->decisions()) ASSERT_EQ(decision.granted, 0U) << texts_[i];
  }
}

TEST_F(Levels, ADaemonThatMeasuresLinksRefusesWhatCheckRefuses) {
  Random random(1);
  std::size_t granted = 0;
  std::size_t refuted = 0;  // although there are links
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (!core::is_plain(all_[i].system)) continue;
    if (std::ranges::none_of(all_[i].system.networks, is_measured)) continue;
    for (std::size_t c = 0; c < all_[i].system.channels.size(); ++c) {
      const core::System system = alone(all_[i].system, c);
      const auto daemon = daemon_of(system, random, Knows::random_links);
      std::size_t fit = 0;
      std::ignore = core::inspect(system, {},
                                  [&](std::size_t, const core::Decision& decision,
                                      std::span<const core::Finding>) { fit += decision.granted; });
      const auto by_daemon = daemon->decisions()[c].granted;
      ASSERT_TRUE(fit != 0 || by_daemon == 0) << "channel " << c << "\n" << texts_[i];
      granted += by_daemon != 0 ? 1 : 0;
      refuted += fit == 0 && !daemon->decisions()[c].verdicts.empty() ? 1 : 0;
    }
  }
  EXPECT_GT(granted, kSystems / 100);
  EXPECT_GT(refuted, kSystems / 100);
}

TEST_F(Levels, TheChecksOfGeneratedCodeGrantWhatCheckGrants) {
  for (std::size_t i = 0; i < all_.size(); ++i) {
    const auto& system = all_[i].system;
    const design::Decisions decisions(system);
    for (std::size_t p = 0; p < system.publishers.size(); ++p)
      for (std::size_t s = 0; s < system.subscribers.size(); ++s) {
        if (system.publishers[p].channel != system.subscribers[s].channel) continue;
        const auto channel = system.publishers[p].channel;
        const auto set = decisions.set_of(channel);
        const auto place = system.subscribers[s].place;
        const auto& delivery = decisions.of(p, place, set);
        ASSERT_EQ(delivery.granted, all_[i].granted.at({channel, p, place})) << texts_[i];
        const bool refused = design::is_refused_by_types(system, p, s, set, delivery.hops);
        ASSERT_FALSE(delivery.granted && refused && !decisions.has_open_set(channel)) << texts_[i];
      }
  }
}

std::string complaints(const std::string& compiler, const std::string& files) {
  return output_of(
      fmt::format("{} -std=c++14 -fsyntax-only -Iinclude {} 2>&1; true", compiler, files));
}

TEST_F(Levels, GeneratedCodeCompilesWhereCheckFindsNoError) {
  const Folder folder;
  std::string fine;  // all of them in one translation unit
  std::size_t fine_ones = 0;
  std::map<std::string, std::string> refused;  // by path: description and header
  for (std::size_t i = 0; i < kCompiled; ++i) {
    const auto& system = all_[i].system;
    const design::Decisions decisions(system);
    const auto units = design::units_of(system, {});
    if (!units) continue;
    for (const auto& unit : *units) {
      const auto header = design::header_of(system, decisions, unit);
      ASSERT_TRUE(header) << header.error().text << texts_[i];
      const auto path = folder.add(fmt::format("s{}_{}.hpp", i + 1, unit.stem), header->text);
      bool wrong = false;
      for (const auto end : unit.ends) wrong |= has_error_of(all_[i], end);
      if (wrong && refused.size() < kRefused) refused[path] = texts_[i] + header->text;
      if (wrong) continue;
      fine += "#include \"" + path + "\"\n";
      ++fine_ones;
    }
  }
  EXPECT_GT(fine_ones, kCompiled / 6);
  EXPECT_EQ(refused.size(), kRefused);
  const auto together = folder.add("fine.cpp", fine);
  for (const char* compiler : {"g++", "clang++-19"})
    EXPECT_EQ(complaints(compiler, "'" + together + "'"), "") << compiler;
  for (const auto& [path, text] : refused)
    EXPECT_TRUE(complaints("g++", "-x c++ '" + path + "'").contains("error: ")) << text;
}

/// On every bus of every system that analyse-bus takes: the times of what check grants are those
/// that check has, and what check refuses for a bus is late there.
TEST_F(Levels, AnalyseBusHasTheResponseTimesOfCheck) {
  const Folder folder;
  std::size_t same = 0;
  std::size_t behind = 0;  // of these: behind another hop
  std::size_t whole = 0;   // of these: in systems in which everything is granted
  std::size_t refused = 0;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    const auto& system = all_[i].system;
    const auto read = design::read_description(folder.add("s.xml", texts_[i]), {});
    const bool all_granted = std::ranges::all_of(read.buses, [](const design::Bus& bus) {
      return std::ranges::all_of(bus.messages, [](const auto& m) { return *m.granted; });
    });
    for (const design::Bus& bus : read.buses) {
      const auto n = static_cast<std::size_t>(
          std::ranges::find(system.networks, bus.network, &core::Network::name) -
          system.networks.begin());
      std::vector<core::can::Message> messages;
      for (const auto& m : bus.messages) messages.push_back(m.message);
      const auto responses = core::can::analyse(bus.assumptions, messages);
      bool fits = true;
      for (std::size_t m = 0; m < messages.size(); ++m) {
        fits = fits && core::can::fits(bus.assumptions, messages[m], responses[m]);
        const auto use = all_[i].on_bus.find({n, messages[m].key});
        if (use == all_[i].on_bus.end() || !*bus.messages[m].granted) continue;
        ASSERT_TRUE(bus.messages[m].granted_response) << texts_[i];
        ASSERT_EQ(bus.messages[m].granted_on_bus, use->second.response) << texts_[i];
        if (responses[m].bounded) {
          ASSERT_GE(responses[m].response, *bus.messages[m].granted_response) << texts_[i];
        }
        ++same;
        if (messages[m].jitter != 0) ++behind;
        if (!all_granted) continue;
        ASSERT_EQ(responses[m].response, *bus.messages[m].granted_response) << texts_[i];
        ++whole;
      }
      ASSERT_TRUE(fits || !all_granted) << texts_[i];
      ASSERT_FALSE(fits && !bus.findings.empty()) << bus.findings.front() << "\n" << texts_[i];
      if (!bus.findings.empty()) ++refused;
    }
  }
  EXPECT_GT(same, 500U);
  EXPECT_GT(behind, 50U);
  EXPECT_GT(whole, 100U);
  EXPECT_GT(refused, 50U);
}

}  // namespace
}  // namespace mlcca::testing
