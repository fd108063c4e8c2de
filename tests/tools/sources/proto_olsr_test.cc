// SPDX-License-Identifier: BSD-2-Clause
// What olsrd2 answers, and what comes of it. The answer was written by olsrd2 0.15 at the end of
// a chain 10.7.0.1 - 10.7.0.2 - 10.7.1.3; only the raw metrics were set afterwards.
#include <gtest/gtest.h>

#include "tests/tools/sources/proto_loop.hpp"
#include "tests/tools/sources/proto_server.hpp"
#include "tools/sources/olsr.hpp"

namespace mlcca::net::olsr {
namespace {

using core::mesh::RateKind;

std::string originators() {
  return "{\"originator\": [{\n\"originator\":\"10.7.0.1\"},{\n\"originator\":\"-\"}]}";
}

std::string neighbour(const std::string& originator, unsigned in, unsigned out,
                      const std::string& metric = "ff_dat_metric") {
  return "{\n\"neighbor_originator\":\"" + originator +
         "\",\n\"neighbor_dualstack\":\"-\",\n\"neighbor_symmetric\":\"true\",\n"
         "\"neighbor_linkcount\":1,\n\"domain\":0,\n\"domain_metric\":\"" +
         metric +
         "\",\n\"domain_metric_in\":\"386bit/s\",\n\"domain_metric_in_raw\":" + std::to_string(in) +
         ",\n\"domain_metric_out\":\"349bit/s\",\n\"domain_metric_out_raw\":" +
         std::to_string(out) +
         ",\n\"domain_mpr\":\"mpr\",\n\"domain_mpr_local\":\"false\",\n"
         "\"domain_mpr_remote\":\"true\",\n\"domain_mpr_willingness\":7}";
}

std::string edge(const std::string& from, const std::string& to, unsigned metric) {
  return "{\n\"node\":\"" + from + "\",\n\"edge\":\"" + to +
         "\",\n\"edge_ansn\":9956,\n\"domain\":\"0\",\n\"domain_metric\":\"ff_dat_metric\",\n"
         "\"domain_metric_out\":\"312bit/s\",\n\"domain_metric_out_raw\":" +
         std::to_string(metric) + "}";
}

/// A neighbour at 24 Mbit/s out, 11 in, and its link to a third node.
std::string answer() {
  return originators() + "{\"neighbor\": [" + neighbour("-", 7470848, 7470848) + "," +
         neighbour("10.7.0.2", 195, 89) + "]}{\"edge\": [" + edge("10.7.0.2", "10.7.0.1", 200) +
         "," + edge("10.7.0.2", "10.7.1.3", 195) + "]}";
}

TEST(Olsr, TheMetricIsTheTimeOfABit) {
  // 2^31 = 2147483648
  EXPECT_EQ(rate_of(89), 24'129'029U);
  EXPECT_EQ(rate_of(195), 11'012'736U);
  EXPECT_EQ(rate_of(1), 2'147'483'648U);
  EXPECT_EQ(rate_of(7'470'848), 287U);  // olsrd2 calls it "287bit/s"
  EXPECT_EQ(rate_of(0), 0U);
  EXPECT_EQ(rate_of(0xffffff), 0U);  // infinite
}

TEST(Olsr, OwnLinksAndThoseOfOthersMakeTheGraph) {
  const auto read = parse(answer());
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(read->links.size(), 3U);
  const auto* out = test::find(*read, "10.7.0.1", "10.7.0.2");
  const auto* in = test::find(*read, "10.7.0.2", "10.7.0.1");
  const auto* two_hop = test::find(*read, "10.7.0.2", "10.7.1.3");
  ASSERT_TRUE(out != nullptr && in != nullptr && two_hop != nullptr);
  EXPECT_EQ(out->rate, 24'129'029U);
  EXPECT_EQ(out->kind, RateKind::derived);
  EXPECT_FALSE(out->loss);  // is part of the metric
  EXPECT_EQ(out->weight, 89U);
  EXPECT_EQ(in->rate, 11'012'736U);  // what we count ourselves, not what is flooded
  EXPECT_EQ(two_hop->rate, 11'012'736U);
  EXPECT_EQ(test::find(*read, "10.7.1.3", "10.7.0.2"), nullptr);  // not reported
}

TEST(Olsr, AnotherMetricHasNoRate) {
  const auto read = parse(originators() + "{\"neighbor\": [" +
                          neighbour("10.7.0.2", 100, 100, "hopcount") + "]}{\"edge\": []}");
  ASSERT_TRUE(read) << read.error().text;
  ASSERT_EQ(read->links.size(), 2U);
  EXPECT_EQ(read->links[0].rate, 0U);
  EXPECT_EQ(read->links[0].weight, 100U);
}

TEST(Olsr, AnInfiniteMetricIsNoLink) {
  const auto read = parse(originators() + "{\"neighbor\": [" + neighbour("10.7.0.2", 0xffffff, 89) +
                          "]}{\"edge\": []}");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->links.size(), 1U);
  EXPECT_EQ(read->links[0].from, "10.7.0.1");
}

TEST(Olsr, WhatIsNotAnAnswerIsAnError) {
  for (const std::string& text :
       {std::string(), std::string("Error, unknown command 'olsrv2info'\n"), std::string("[1,2]"),
        std::string("{\"originator\": 7}"), std::string("{\"originator\": [7]}"),
        originators() + "{\"neighbor\": [7]}",
        originators() + "{\"edge\": [{\"node\": 1, \"edge\": {}}]}",
        std::string("{\"originator\": [{\n\"originator\":\"-\"}]}")})
    EXPECT_FALSE(parse(text)) << text;
}

TEST(Olsr, AnAnswerThatIsCutOffInATableIsAnError) {
  const std::string whole = answer();
  const auto first_end = originators().size();
  for (std::size_t size = 0; size < first_end; ++size)
    EXPECT_FALSE(parse(std::string_view(whole).substr(0, size))) << size;
  EXPECT_FALSE(parse(std::string_view(whole).substr(0, whole.size() - 1)));
}

TEST(Olsr, TheServerIsAskedAgainAndAgainAndItsLossIsReported) {
  std::unique_ptr<test::Server> server;
  std::string asked;
  std::string text = answer();
  sd_event* raw = nullptr;
  ASSERT_GE(sd_event_new(&raw), 0);
  const std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop(raw);
  server = std::make_unique<test::Server>(raw, "", true, [&](const std::string& line) {
    asked = line;
    return text;
  });
  core::mesh::Source source;
  source.kind = core::mesh::SourceKind::olsr;
  source.endpoint = server->endpoint();
  test::Watched watched(source, {}, raw);
  ASSERT_EQ(watched.error(), "");
  const auto first = watched.await([](const auto& s) { return s.links.size() == 3; });
  ASSERT_TRUE(first) << watched.last();
  EXPECT_EQ(asked + "\n", kRequest);
  text = originators() + "{\"neighbor\": []}{\"edge\": []}";
  const auto second = watched.await([](const auto& s) { return s.links.empty(); });
  ASSERT_TRUE(second) << watched.last();
  EXPECT_EQ(second->problem, "");
  server.reset();
  EXPECT_TRUE(watched.await([](const auto& s) {
    return s.problem.find("refused") != std::string::npos;
  })) << watched.last();
}

TEST(Olsr, AnEndpointThatIsNoneIsRefusedAtOnce) {
  core::mesh::Source source;
  source.kind = core::mesh::SourceKind::olsr;
  for (const char* endpoint : {"", "localhost:2009", "127.0.0.1", "127.0.0.1:0", "127.0.0.1:x",
                               "127.0.0.1:70000", "1.2.3:4"}) {
    source.endpoint = endpoint;
    EXPECT_NE(test::Watched(source, {}).error(), "") << endpoint;
  }
}

}  // namespace
}  // namespace mlcca::net::olsr
