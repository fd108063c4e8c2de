// SPDX-License-Identifier: BSD-2-Clause
// The bounds of what sources may say, from both sides: docs/reference/sources.md lists them.
#include <gtest/gtest.h>

#include "core/mesh/bounds.hpp"
#include "tests/tools/sources/proto_loop.hpp"
#include "tests/tools/sources/proto_server.hpp"
#include "tools/sources/awds_packet.hpp"
#include "tools/sources/babel.hpp"
#include "tools/sources/file.hpp"
#include "tools/sources/line_client.hpp"
#include "tools/sources/olsr.hpp"

namespace mlcca::net {
namespace {

using core::mesh::bounded;
using core::mesh::bounded_text;
using core::mesh::is_address;
using core::mesh::kMaxAddress;
using core::mesh::kMaxFacts;
using core::mesh::kMaxProblem;
using core::mesh::kMaxRate;
using core::mesh::kMaxValidity;
using core::mesh::kMaxWeight;
using core::mesh::Sample;
using core::mesh::Snapshot;

constexpr std::uint64_t kNow = 1'000'000'000'000;

Sample sample(const std::string& from, const std::string& to) {
  Sample out;
  out.from = from;
  out.to = to;
  out.rate = 1'000'000;
  out.taken = kNow;
  return out;
}

Snapshot of(Sample link) {
  Snapshot out;
  out.links.push_back(std::move(link));
  return out;
}

Snapshot crowd(std::size_t links) {
  Snapshot out;
  for (std::size_t i = 0; i < links; ++i)
    out.links.push_back(sample("x" + std::to_string(i), "y" + std::to_string(i)));
  return out;
}

TEST(SourceBounds, WhatIsWithinThemIsLeftAsItIs) {
  Sample most = sample(std::string(kMaxAddress, 'a'), "b");
  most.rate = kMaxRate;
  most.loss = 1'000'000'000;
  most.busy = core::mesh::kWhole;
  most.weight = kMaxWeight;
  most.valid = kMaxValidity;
  EXPECT_EQ(bounded(of(most), {}, kNow), of(most));
  EXPECT_EQ(bounded(crowd(kMaxFacts), {}, kNow), crowd(kMaxFacts));
}

TEST(SourceBounds, ANumberOutOfRangeBecomesTheWorst) {
  Sample wrong = sample("a", "b");
  wrong.rate = kMaxRate + 1;
  wrong.loss = 1'000'000'001;
  wrong.busy = core::mesh::kWhole + 1;
  wrong.weight = kMaxWeight + 1;
  wrong.valid = kMaxValidity + 1;
  wrong.taken = kNow + 1;
  const auto reported = bounded(of(wrong), {}, kNow);
  ASSERT_EQ(reported.links.size(), 1U);
  EXPECT_EQ(reported.links[0].rate, 0U);
  EXPECT_EQ(reported.links[0].loss, 1'000'000'000U);
  EXPECT_EQ(reported.links[0].busy, core::mesh::kWhole);
  EXPECT_EQ(reported.links[0].weight, kMaxWeight);
  EXPECT_EQ(reported.links[0].valid, kMaxValidity);
  EXPECT_EQ(reported.links[0].taken, kNow);
  EXPECT_EQ(reported.problem, "some of its numbers are out of range");
}

TEST(SourceBounds, AnAddressIsShortAndVisible) {
  for (const auto& address : {std::string(), std::string(kMaxAddress + 1, 'a'), std::string("a b"),
                              std::string("a\x1b[2J"), std::string("\xc3\xa4")}) {
    EXPECT_FALSE(is_address(address)) << address;
    const auto reported = bounded(of(sample("a", address)), {}, kNow);
    EXPECT_TRUE(reported.links.empty());
    EXPECT_EQ(reported.problem, "some of its links have no address: ignored");
  }
}

TEST(SourceBounds, AProblemIsShortAndVisible) {
  EXPECT_EQ(bounded_text(std::string(kMaxProblem, 'a')), std::string(kMaxProblem, 'a'));
  EXPECT_EQ(bounded_text(std::string(kMaxProblem + 1, 'a')), std::string(kMaxProblem, 'a'));
  EXPECT_EQ(bounded_text("a\n\x1b[2Jb\x7f"), "a??[2Jb?");
}

TEST(SourceBounds, OfTooManyLinksThoseOfDescribedNodesAreKept) {
  Snapshot many = crowd(kMaxFacts);
  many.links.push_back(sample("x0", "b"));
  many.links.push_back(sample("a", "b"));
  for (std::size_t i = 0; i <= kMaxFacts; ++i)
    many.next_hops.push_back({.from = "x", .to = "y" + std::to_string(i), .via = "z"});
  many.next_hops.push_back({.from = "a", .to = "b", .via = "z"});
  const auto reported = bounded(many, {"a", "b"}, kNow);
  ASSERT_EQ(reported.links.size(), kMaxFacts);
  EXPECT_EQ(reported.links[0], sample("a", "b"));
  EXPECT_EQ(reported.links[1], sample("x0", "b"));
  ASSERT_EQ(reported.next_hops.size(), kMaxFacts);
  EXPECT_EQ(reported.next_hops[0].to, "b");
  EXPECT_NE(reported.problem.find("more than 8192"), std::string::npos);
}

// --- AWDS ----------------------------------------------------------------------------------------

awds::NodeId node(std::size_t number) {
  return {2, 0, 0, 0, static_cast<std::uint8_t>(number >> 8U), static_cast<std::uint8_t>(number)};
}

awds::Topology says(std::size_t number, std::uint32_t validity_ms = 3600) {
  return {.source = node(number),
          .sequence = 1,
          .validity = validity_ms,
          .neighbours = {{.id = node(0xffff), .quality = 1}},
          .name = {}};
}

TEST(AwdsBounds, InventedNodesDoNotCrowdOutTheDescribedAndTheKnown) {
  const core::mesh::DescribedNodes described{awds::address_of(node(0xf000))};
  awds::Graph graph(core::mesh::AwdsMetric::hops, described);
  ASSERT_TRUE(graph.take(says(1), kNow));
  for (std::size_t i = 2; i <= awds::kMaxNodes; ++i) ASSERT_TRUE(graph.take(says(i), kNow + i));
  EXPECT_EQ(graph.snapshot(kNow + 2000).problem, "");
  EXPECT_FALSE(graph.take(says(0xe000), kNow + 3000));
  EXPECT_TRUE(graph.take(says(0xf000), kNow + 3000));
  const auto reported = graph.snapshot(kNow + 3000);
  EXPECT_EQ(reported.links.size(), awds::kMaxNodes);
  const auto link_from = [&](std::size_t number) {
    return test::find(reported, awds::address_of(node(number)), awds::address_of(node(0xffff)));
  };
  EXPECT_NE(link_from(0xf000), nullptr) << "described";
  EXPECT_NE(link_from(1), nullptr) << "known longest";
  EXPECT_EQ(link_from(awds::kMaxNodes), nullptr) << "one that is not described, which came last";
  EXPECT_EQ(link_from(0xe000), nullptr);
  EXPECT_NE(reported.problem.find("more than 1024 nodes"), std::string::npos);
  EXPECT_EQ(graph.snapshot(kNow + 3001).problem, "") << "said once";
}

TEST(AwdsBounds, ValidityIsTenMinutesAtMost) {
  awds::Graph graph(core::mesh::AwdsMetric::hops);
  ASSERT_TRUE(graph.take(says(1, 0xffff'ffff), kNow));
  const auto reported = graph.snapshot(kNow + kMaxValidity - 1);
  ASSERT_EQ(reported.links.size(), 1U);
  EXPECT_EQ(reported.links[0].valid, kMaxValidity);
  EXPECT_TRUE(graph.snapshot(kNow + kMaxValidity).links.empty());
}

// --- babel ---------------------------------------------------------------------------------------

std::string neighbour(std::size_t i) {
  return "add neighbour " + std::to_string(i) + " address fe80::" + std::to_string(i) +
         " if mesh0 rxcost 256 txcost 256 cost 256";
}

TEST(BabelBounds, NeighboursAndRoutesAreCounted) {
  babel::State state({});
  for (std::size_t i = 0; i < babel::kMaxNeighbours; ++i)
    ASSERT_EQ(state.take(neighbour(i)), babel::Line::fact);
  EXPECT_EQ(state.take(neighbour(babel::kMaxNeighbours)), babel::Line::too_much);
  EXPECT_EQ(state.take(neighbour(0)), babel::Line::fact) << "it is known";
  const auto route = [](std::size_t i, const char* length) {
    return "add route " + std::to_string(i) + " prefix 10.0." + std::to_string(i / 256) + "." +
           std::to_string(i % 256) + length + " installed yes refmetric 0 via fe80::1";
  };
  for (std::size_t i = 0; i < babel::kMaxRoutes; ++i)
    ASSERT_EQ(state.take(route(i, "/32")), babel::Line::fact);
  EXPECT_EQ(state.take(route(babel::kMaxRoutes, "/24")), babel::Line::fact) << "no host";
  EXPECT_EQ(state.take(route(babel::kMaxRoutes, "/32")), babel::Line::too_much);
  EXPECT_EQ(state.take(route(0, "/24")), babel::Line::fact) << "leads to no single host any more";
  EXPECT_EQ(state.take(route(babel::kMaxRoutes, "/32")), babel::Line::fact);
  for (std::size_t i = 0; i < babel::kMaxInterfaces; ++i)
    ASSERT_EQ(state.take("add interface i" + std::to_string(i) + " up true"), babel::Line::fact);
  EXPECT_EQ(state.take("add interface more up true"), babel::Line::too_much);
  for (std::size_t i = 0; i < babel::kMaxRoutes; ++i)
    ASSERT_EQ(state.take("add xroute " + std::to_string(i) + " prefix 10.1.1.1/32"),
              babel::Line::fact);
  EXPECT_EQ(state.take("add xroute more prefix 10.1.1.1/32"), babel::Line::too_much);
}

TEST(BabelBounds, WordsAreCountedAndMeasured) {
  const auto with = [](std::size_t pairs, std::size_t size) {
    std::string line = "add interface mesh0";
    for (std::size_t i = 0; i < pairs; ++i)
      line += " k" + std::to_string(i) + " " + std::string(size, 'v');
    return babel::State({}).take(line);
  };
  EXPECT_EQ(with(babel::kMaxWords / 2, babel::kMaxWord), babel::Line::fact);
  EXPECT_EQ(with(babel::kMaxWords / 2 + 1, 1), babel::Line::too_much);
  EXPECT_EQ(with(1, babel::kMaxWord + 1), babel::Line::too_much);
}

/// What a babel source reports of a server that greets so and answers nothing.
std::string problem_with_server(const std::string& greeting) {
  sd_event* raw = nullptr;
  if (sd_event_new(&raw) < 0) return "no loop";
  const std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop(raw);
  test::Server server(raw, greeting, false, [](const std::string&) { return "ok\n"; });
  core::mesh::Source source;
  source.kind = core::mesh::SourceKind::babel;
  source.endpoint = server.endpoint();
  test::Watched watched(source, {}, raw);
  const auto reported = watched.await([](const auto& s) { return !s.problem.empty(); });
  return reported ? reported->problem : watched.last();
}

TEST(BabelBounds, AnAnswerWithoutAnEndIsLeft) {
  sd_event* raw = nullptr;
  ASSERT_GE(sd_event_new(&raw), 0);
  const std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop(raw);
  test::Server server(raw, "", false, [](const std::string&) { return ""; });
  bool connected = false;
  std::size_t received = 0;
  std::string why;
  LineClient client(*parse_endpoint(server.endpoint()), 60'000'000, 600'000'000,
                    {.connected = [&] { connected = true; },
                     .line = [&](std::string_view line) { received += line.size() + 1; },
                     .ended = [&](const std::string& reason) { why = reason; }});
  ASSERT_TRUE(client.start(raw));
  const std::string lines = std::string(1023, 'x') + "\n";
  while (why.empty()) {
    if (connected) server.send_all(lines);
    ASSERT_GE(sd_event_run(raw, 1'000'000), 0);
  }
  EXPECT_EQ(why, "its answer is longer than 4194304 bytes");
  EXPECT_LE(received, LineClient::kLongestAnswer);
  EXPECT_GE(received, LineClient::kLongestAnswer - LineClient::kTurn - lines.size());
}

TEST(BabelBounds, TooManyNeighboursAreAProblemWithoutLinks) {
  std::string many;
  for (std::size_t i = 0; i <= babel::kMaxNeighbours; ++i) many += neighbour(i) + "\n";
  EXPECT_NE(problem_with_server(many).find("at most 1024 neighbours"), std::string::npos);
}

// --- olsr ----------------------------------------------------------------------------------------

const char* const kOriginator = R"({"originator":[{"originator":"10.0.0.1"}]})";

std::string edges(std::size_t count) {
  std::string out = "{\"edge\":[";
  for (std::size_t i = 0; i < count; ++i)
    out += std::string(i == 0 ? "" : ",") + R"({"node":"a","edge":"b","domain_metric_out_raw":)" +
           std::to_string(i + 1) + "}";
  return out + "]}";
}

TEST(OlsrBounds, DepthCostsNothing) {
  for (const char* open : {"[", "{\"a\":", "{\"edge\":[", "{\"edge\":[{\"node\":["}) {
    std::string deep = kOriginator;
    for (int i = 0; i < 200'000; ++i) deep += open;
    const auto read = olsr::parse(deep);
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().text.find("not understood"), std::string::npos);
  }
}

TEST(OlsrBounds, RowsAreCounted) {
  const auto all = olsr::parse(kOriginator + edges(olsr::kMaxRows - 1));
  ASSERT_TRUE(all) << all.error().text;
  EXPECT_EQ(all->links.size(), olsr::kMaxRows - 1);
  const auto read = olsr::parse(kOriginator + edges(olsr::kMaxRows));
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().text, "its tables have more than 16384 rows");
}

TEST(OlsrBounds, TextsAndOwnAddressesAreBounded) {
  const auto with_text = [](std::size_t size) {
    return olsr::parse(kOriginator + std::string(R"({"edge":[{"any":")") + std::string(size, 'x') +
                       "\"}]}")
        .has_value();
  };
  EXPECT_TRUE(with_text(olsr::kMaxText));
  EXPECT_FALSE(with_text(olsr::kMaxText + 1));
  const auto with_own = [](std::size_t count) {
    std::string text;
    for (std::size_t i = 0; i < count; ++i) text += kOriginator;
    return olsr::parse(text).has_value();
  };
  EXPECT_TRUE(with_own(olsr::kMaxOwn));
  EXPECT_FALSE(with_own(olsr::kMaxOwn + 1));
}

// --- file ----------------------------------------------------------------------------------------

TEST(FileBounds, LinksAreCounted) {
  std::vector<std::string> addresses(92);
  for (std::size_t i = 0; i < addresses.size(); ++i) addresses[i] = "10.0.0." + std::to_string(i);
  const auto mesh = test::mesh_of(addresses);
  std::string text;
  std::size_t stated = 0;
  for (std::size_t i = 0; i < addresses.size(); ++i)
    for (std::size_t j = 0; j < addresses.size() && stated <= kMaxFacts; ++j) {
      if (i == j) continue;
      if (stated == kMaxFacts) {
        EXPECT_EQ(parse_links(text, "f", mesh)->size(), kMaxFacts);
      }
      text += addresses[i] + " " + addresses[j] + " 1Mbit/s\n";
      ++stated;
    }
  const auto read = parse_links(text, "f", mesh);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().text, "f:8193: the file states more than 8192 links");
}

TEST(FileBounds, RatesAndWeightsHaveARange) {
  const auto mesh = test::mesh_of({"a", "b"});
  EXPECT_TRUE(parse_links("n1 n2 1000Gbit/s weight=4294967295", "f", mesh));
  EXPECT_FALSE(parse_links("n1 n2 1000.000000001Gbit/s", "f", mesh));
  EXPECT_FALSE(parse_links("n1 n2 1Gbit/s weight=4294967296", "f", mesh));
}

}  // namespace
}  // namespace mlcca::net
