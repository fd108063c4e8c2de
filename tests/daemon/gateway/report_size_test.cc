// SPDX-License-Identifier: BSD-2-Clause
// However much is described, what is said at once of it is bounded, and says what it leaves out.
#include "daemon/gateway/report_size.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "daemon/gateway/report.hpp"
#include "description/read.hpp"

namespace mlcca {
namespace {

std::string attribute(const char* name, int value, const char* dimension = "") {
  return fmt::format("<Attribute><Name>{}</Name>{}<Value>{}</Value></Attribute>", name, dimension,
                     value);
}

std::string omission(int events) { return attribute("Omission", events); }

std::string payload(int bytes) {
  return attribute("MaxPayload", bytes, "<Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>");
}

core::State state_of(const std::string& body) {
  auto system = description::read_memory("<System name=\"test\">" + body + "</System>", "test.xml");
  if (!system) throw std::runtime_error(to_string(system.error().front()));
  return core::State(std::move(*system));
}

/// The last subscriber accepts shorter events than the publishers send.
std::string wide(int publishers, int subscribers) {
  std::string body =
      "<EventChannel name=\"wide\"><SubjectUID>0x4300000000000000</SubjectUID><Attributes>" +
      omission(2) + payload(64) +
      "</Attributes></EventChannel><Network name=\"lan\"><Kind>udp-multicast</Kind><Provision>" +
      omission(1) + payload(65535) + "</Provision></Network><Gateway name=\"bridge\"><Provision>" +
      omission(0) + "</Provision><Port network=\"lan\"><Interface name=\"eth1\"/></Port></Gateway>";
  for (int p = 0; p < publishers; ++p)
    body += fmt::format("<Publisher name=\"p{}\" channel=\"wide\" network=\"lan\"/>", p);
  for (int s = 0; s < subscribers; ++s)
    body +=
        fmt::format("<Subscriber name=\"s{}\" channel=\"wide\" gateway=\"bridge\">{}</Subscriber>",
                    s, s + 1 == subscribers ? "<Attributes>" + payload(32) + "</Attributes>" : "");
  return body;
}

bool is_unfit(const control::Row& row) { return row.outcome != control::Outcome::fit; }

TEST(ReportSizeTest, ADeliveryListsSomeComparisonsAndCountsTheOthers) {
  const core::State state = state_of(wide(1, 1000));
  const core::Verdict& v = state.decisions()[0].verdicts.front();
  ASSERT_GE(v.rows.size(), 1000U);
  const control::Channel said = channel_report(state, v, {});
  EXPECT_EQ(said.rows.size(), control::Channel::kMostRows);
  EXPECT_EQ(said.rows.size() + said.rows_left_out, v.rows.size());
  EXPECT_EQ(said.subscribers.size() + said.subscribers_left_out, 1000U);
}

TEST(ReportSizeTest, WhatDoesNotFitIsListedAlthoughItStandsLast) {
  const core::State state = state_of(wide(1, 1000));
  const core::Verdict& v = state.decisions()[0].verdicts.front();
  const auto unfit = std::ranges::count_if(
      v.rows, [](const core::Row& row) { return row.comparison.outcome != Outcome::fit; });
  ASSERT_GT(unfit, 0);
  ASSERT_LT(unfit, 256);
  EXPECT_EQ(std::ranges::count_if(channel_report(state, v, {}).rows, is_unfit), unfit);
}

TEST(ReportSizeTest, AFewComparisonsAreListedInTheirOrder) {
  const core::State state = state_of(wide(1, 3));
  const core::Verdict& v = state.decisions()[0].verdicts.front();
  const control::Channel said = channel_report(state, v, {});
  ASSERT_EQ(said.rows.size(), v.rows.size());
  EXPECT_EQ(said.rows_left_out, 0U);
  for (std::size_t i = 0; i < v.rows.size(); ++i)
    EXPECT_EQ(said.rows[i].required, v.rows[i].comparison.required) << i;
}

TEST(ReportSizeTest, TheReplyToANewEndListsSomeDeliveriesAndTheRefusedFirst) {
  const core::State state = state_of(wide(40, 300));
  std::vector<core::Verdict> verdicts = state.decisions()[0].verdicts;
  ASSERT_EQ(verdicts.size(), 40U);
  for (core::Verdict& v : verdicts) v.granted = true;
  verdicts.back().granted = false;
  std::vector<const core::Verdict*> said;
  for (const core::Verdict& v : verdicts) said.push_back(&v);
  const std::uint32_t left_out = leave_out(state, said);
  EXPECT_EQ(said.size() + left_out, 40U);
  EXPECT_GT(left_out, 0U);
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said.front(), &verdicts.back());
  std::size_t lines = 0;
  for (const core::Verdict* v : said) lines += lines_of(state, *v);
  EXPECT_LE(lines, kMostLines);
}

TEST(ReportSizeTest, AReplyThatFitsIsWholeAndInItsOrder) {
  const core::State state = state_of(wide(4, 3));
  std::vector<const core::Verdict*> said;
  for (const core::Verdict& v : state.decisions()[0].verdicts) said.push_back(&v);
  const auto before = said;
  EXPECT_EQ(leave_out(state, said), 0U);
  EXPECT_EQ(said, before);
}

TEST(ReportSizeTest, NodesAndLinksOfAMeshCountAsMuchAsChannels) {
  std::string mesh =
      "<Network name=\"mesh\"><Kind>mesh</Kind><Mesh><PerHop>" + omission(0) + "</PerHop>";
  for (int n = 0; n < 400; ++n)
    mesh += fmt::format("<Node name=\"n{}\" address=\"10.0.{}.{}\"/>", n, n / 250, n % 250 + 1);
  std::string links;
  for (int n = 0; n < 1200; ++n)
    links += fmt::format("<Link from=\"n{}\" to=\"n{}\" rate=\"24000000\"/>", n % 400,
                         (n + 1 + n / 400) % 400);
  const core::State small = state_of(mesh + "</Mesh></Network>");
  EXPECT_LE(lines_of(small, kMostLines), kMostLines);
  EXPECT_GE(lines_of(small, kMostLines), 400U);
  const core::State large = state_of(mesh + links + "</Mesh></Network>");
  EXPECT_GT(lines_of(large, kMostLines), kMostLines);
}

TEST(ReportSizeTest, OneChannelOfManyEndsIsMuchToSay) {
  EXPECT_LE(lines_of(state_of(wide(2, 3)), kMostLines), kMostLines);
  EXPECT_GT(lines_of(state_of(wide(8, 200)), kMostLines), kMostLines);
}

}  // namespace
}  // namespace mlcca
