// SPDX-License-Identifier: BSD-2-Clause
// Every file of tests/corpus/description is a case. A bad one says in comments which problems are
// found (expect: LINE: ELEMENT: REGEX), all of them; a good one states facts of the System that is
// read (expect-FACT: VALUE, see facts()).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "core/model/words.hpp"
#include "description/read.hpp"
#include "tests/description/pattern.hpp"

namespace mlcca::description {
namespace {

std::vector<std::string> files(const std::string& folder) {
  std::vector<std::string> out;
  for (const auto& entry :
       std::filesystem::directory_iterator("tests/corpus/description/" + folder))
    if (entry.path().extension() == ".xml") out.push_back(entry.path().string());
  std::ranges::sort(out);
  return out;
}

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string case_name(const ::testing::TestParamInfo<std::string>& info) {
  auto name = std::filesystem::path(info.param).stem().string();
  std::ranges::replace(name, '-', '_');
  return name;
}

struct Expectation {
  int line;
  std::string element;
  std::string regex;

  [[nodiscard]] bool fits(const Problem& p) const {
    return p.line == line && p.element == element && Pattern(regex).matches_whole(p.text);
  }
};

std::vector<Expectation> expectations(const std::string& text) {
  const Pattern form("<!-- expect: ([0-9]+): ([A-Za-z]*): (.*) -->");
  std::vector<Expectation> out;
  for (auto& [line, element, regex] : form.find_all(text))
    out.push_back({std::stoi(line), element, regex});
  return out;
}

void add_attributes(std::set<std::string>& out, const std::string& owner, const AttributeSet& set) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto a = attribute_at(i);
    if (!set.has(a)) continue;
    out.insert(fmt::format("{} {} {}", owner, info(a).name, set[a]));
    if (owner.starts_with("provision"))
      out.insert(fmt::format("{}:{} {}", set.is_dynamic(a) ? "dynamic" : "static",
                             owner.substr(owner.find(':') + 1), info(a).name));
  }
}

constexpr std::array kInterferences = {"single-domain", "k-hop", "channel", "explicit"};
constexpr std::array kRateKinds = {"phy", "effective", "derived"};
constexpr std::array kSourceKinds = {"description", "file",  "nl80211", "batman",
                                     "awds",        "babel", "olsr",    "wire"};
constexpr std::array kMetrics = {"etx", "hops", "packet-pair", "transmission-time"};

/// The word of an enumerator, in the order of its header.
template <class Enum, std::size_t N>
const char* word(const std::array<const char*, N>& words, Enum value) {
  return words.at(static_cast<std::size_t>(value));
}

std::string words_of(const core::mesh::Source& s) {
  auto out = std::string(word(kSourceKinds, s.kind));
  if (!s.interface.empty()) out += " " + s.interface;
  if (!s.endpoint.empty()) out += " " + s.endpoint;
  if (s.kind == core::mesh::SourceKind::awds)
    out += std::string(" metric ") + word(kMetrics, s.metric);
  return out;
}

void add_mesh(std::set<std::string>& out, std::size_t i, const core::mesh::Mesh& m) {
  const auto node = [&](std::uint32_t number) { return m.nodes.at(number).name; };
  out.insert(fmt::format(
      "mesh: {} {} hops {} limit {} packet {}+{} bytes {} ns stale {} hold {} tolerance {}", i,
      word(kInterferences, m.interference), m.hops, m.limit, m.packet_bytes, m.header_bytes,
      m.packet_time, m.stale_after, m.hold_up, m.tolerance));
  add_attributes(out, fmt::format("per-hop: {}", i), m.per_hop);
  out.insert(fmt::format("mesh-nodes: {} {}", i, m.nodes.size()));
  for (const auto& n : m.nodes)
    out.insert(fmt::format("mesh-node: {} {} {}{}", i, n.name, n.address,
                           n.gateway ? fmt::format(" gateway {}", *n.gateway) : ""));
  out.insert(fmt::format("mesh-links: {} {}", i, m.links.size()));
  for (const auto& l : m.links)
    out.insert(fmt::format("mesh-link: {} {} {} {} loss {} channel {} {}", i, node(l.from),
                           node(l.to), l.rate, l.loss, l.channel, word(kRateKinds, l.kind)));
  for (const auto& d : m.domains) {
    auto fact = fmt::format("domain: {} {}", i, d.name);
    for (const auto& [from, to] : d.links) fact += fmt::format(" {}-{}", node(from), node(to));
    out.insert(fact);
  }
  out.insert(fmt::format("sources: {} {}", i, m.sources.size()));
  for (std::size_t n = 0; n < m.sources.size(); ++n)
    out.insert(fmt::format("source: {} {} {}", i, n, words_of(m.sources[n])));
}

void add_network(std::set<std::string>& out, std::size_t i, const core::Network& n) {
  out.insert(fmt::format("bindings: {} {}", i, n.bindings.size()));
  for (const auto& b : n.bindings)
    if (b.dynamic) out.insert(fmt::format("dynamic: {} c{}", i, b.channel));
  if (n.states_subscribe_tag) out.insert(fmt::format("subscribe-etag: {} {}", i, n.subscribe_tag));
  add_attributes(out, fmt::format("provision: {}", i), n.provision);
  out.insert(fmt::format("bus: {} bitrate {} data {} unknown {} background {} errors {} in {}", i,
                         n.bus.bitrate, n.bus.data_bitrate, n.bus.unknown_senders ? "yes" : "no",
                         n.bus.background, n.bus.faults.count, n.bus.faults.interval));
  if (n.mesh) add_mesh(out, i, *n.mesh);
}

void add_gateway(std::set<std::string>& out, std::size_t i, const core::Gateway& g) {
  out.insert(fmt::format("ports: {} {}", i, g.ports.size()));
  if (g.forwarder == core::Forwarder::none) out.insert(fmt::format("forward: {} none", i));
  for (std::size_t n = 0; n < g.ports.size(); ++n) {
    const auto& port = g.ports[n];
    out.insert(fmt::format("queue: {} {} {} {} {}", i, n,
                           port.queueing == core::Queueing::priority ? "priority" : "fifo",
                           port.fifo_depth, port.queue_length));
    if (port.sender) out.insert(fmt::format("sender: {} {} {}", i, n, *port.sender));
    if (port.excess == core::Excess::pass) out.insert(fmt::format("excess: {} {} pass", i, n));
    if (port.node) out.insert(fmt::format("port-node: {} {} {}", i, n, *port.node));
    if (port.refused == core::Refused::silent)
      out.insert(fmt::format("refused: {} {} silent", i, n));
  }
}

/// The name of the node where an end sits.
template <class End>
std::string node_of(const core::System& s, const End& end) {
  return end.mesh_node ? s.networks[end.place.index].mesh.value().nodes.at(*end.mesh_node).name
                       : "anywhere";
}

/// What can be stated, as "name: value"; lists begin with the index of the entry.
std::set<std::string> facts(const core::System& s) {
  std::set<std::string> out{fmt::format("channels: {}", s.channels.size()),
                            fmt::format("networks: {}", s.networks.size()),
                            fmt::format("gateways: {}", s.gateways.size()),
                            fmt::format("publishers: {}", s.publishers.size()),
                            fmt::format("subscribers: {}", s.subscribers.size())};
  for (std::size_t i = 0; i < s.channels.size(); ++i) {
    out.insert(fmt::format("subject: {} 0x{:x}", i, s.channels[i].subject));
    out.insert(fmt::format("channel-text: {} {}", i, s.channels[i].description));
    out.insert(fmt::format("importance: {} {}", i, s.channels[i].importance));
    out.insert(fmt::format("arrival: {} {}", i, core::words::kArrivals.of(s.channels[i].arrival)));
    add_attributes(out, fmt::format("channel-attribute: {}", i), s.channels[i].attributes);
  }
  for (std::size_t i = 0; i < s.networks.size(); ++i) add_network(out, i, s.networks[i]);
  for (std::size_t i = 0; i < s.gateways.size(); ++i) add_gateway(out, i, s.gateways[i]);
  for (std::size_t i = 0; i < s.publishers.size(); ++i) {
    const auto& p = s.publishers[i];
    out.insert(fmt::format("publisher-name: {} {}", i, p.name));
    out.insert(fmt::format("priority: {} {}", i, p.priority));
    if (p.node) out.insert(fmt::format("node: {} {}", i, *p.node));
    out.insert(fmt::format("publisher-on: {} {}", i, node_of(s, p)));
    if (!p.station.is_wildcard())
      out.insert(fmt::format("address: {} {}", i, core::to_text(p.station)));
    if (p.uid) out.insert(fmt::format("uid: {} {}", i, *p.uid));
    add_attributes(out, fmt::format("publisher-attribute: {}", i), p.attributes);
  }
  for (std::size_t i = 0; i < s.subscribers.size(); ++i) {
    out.insert(fmt::format("subscriber-on: {} {}", i, node_of(s, s.subscribers[i])));
    add_attributes(out, fmt::format("subscriber-attribute: {}", i), s.subscribers[i].attributes);
  }
  return out;
}

class BadDescription : public ::testing::TestWithParam<std::string> {};

TEST_P(BadDescription, IsRefusedWithExactlyTheExpectedProblems) {
  const auto expected = expectations(text_of(GetParam()));
  ASSERT_FALSE(expected.empty()) << GetParam() << " states no expectation";
  const auto result = read(GetParam());
  ASSERT_FALSE(result) << GetParam() << " was read without a problem";
  auto problems = result.error();
  EXPECT_TRUE(std::ranges::is_sorted(problems, {}, &Problem::line));
  for (const auto& e : expected) {
    const auto found = std::ranges::find_if(problems, [&](const Problem& p) { return e.fits(p); });
    if (found == problems.end())
      ADD_FAILURE() << "not found: " << e.line << ": " << e.element << ": " << e.regex;
    else
      problems.erase(found);
  }
  for (const auto& p : problems) ADD_FAILURE() << "not expected: " << to_string(p);
}

INSTANTIATE_TEST_SUITE_P(Corpus, BadDescription, ::testing::ValuesIn(files("bad")), case_name);

class GoodDescription : public ::testing::TestWithParam<std::string> {};

TEST_P(GoodDescription, IsReadAsItsFactsSay) {
  const auto result = read(GetParam());
  if (!result)
    for (const auto& p : result.error()) ADD_FAILURE() << to_string(p);
  ASSERT_TRUE(result);
  const auto stated = facts(*result);
  const auto text = text_of(GetParam());
  const auto expected = Pattern("expect-([a-z-]+: .*)").find_all(text);
  for (const auto& fact : expected) EXPECT_TRUE(stated.contains(fact[0])) << fact[0];
  EXPECT_FALSE(expected.empty()) << GetParam() << " states no fact";
}

INSTANTIATE_TEST_SUITE_P(Corpus, GoodDescription, ::testing::ValuesIn(files("good")), case_name);

}  // namespace
}  // namespace mlcca::description
