// SPDX-License-Identifier: BSD-2-Clause
// What the audit report proposes for unknown frames.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/control/messages.hpp"
#include "tools/audit.hpp"
#include "tools/json.hpp"

namespace mlcca::tools {
namespace {

class AuditDraft : public ::testing::Test {
 protected:
  /// The additions for one finding only.
  [[nodiscard]] std::string addition_for(const control::Finding& finding) const {
    control::Audit alone = audit_;
    alone.findings = {finding};
    return additions(alone);
  }
  static std::size_t channels_in(const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = 0; (at = text.find("<EventChannel ", at)) != std::string::npos; ++at)
      ++found;
    return found;
  }

  control::Audit audit_ = test::full_audit();
};

/// PGN 0xef00 of node 0x33, to the nodes 0x44 and 0x45. The description may have others.
TEST_F(AuditDraft, EachDestinationOfAPgnIsAChannel) {
  audit_.findings = {audit_.findings[1], audit_.findings[1]};
  audit_.findings[0].can_id = 0x8cef4433;
  audit_.findings[1].can_id = 0x8cef4533;
  const std::string text = additions(audit_);
  EXPECT_TRUE(
      text.contains("<Binding channel=\"truck-pgn-EF00-to-44\"><PGN priority=\"3\" "
                    "destination=\"0x44\">0xef00</PGN></Binding>"))
      << text;
  EXPECT_TRUE(text.contains("destination=\"0x45\">0xef00</PGN>")) << text;
  EXPECT_EQ(channels_in(text), 2U) << text;
}

/// In a second there may be 21 events of a Period of 50 ms.
TEST_F(AuditDraft, ThePeriodIsOneThatNetworkAndGatewayProvideOrItSaysThatItIsNot) {
  control::Finding f = audit_.findings[2];
  f.busy_gap_ns = 48'000'000;
  EXPECT_TRUE(addition_for(f).contains("one every 48ms: the Period is that.")) << addition_for(f);
  f.provided_period_ns = 50'000'000;
  std::string text = addition_for(f);
  EXPECT_TRUE(
      text.contains("one every 48ms: the Period is 50ms, which network and gateway provide."))
      << text;
  EXPECT_TRUE(text.contains("<Attributes period=\"50ms\" ")) << text;
  f.provided_period_ns = 48'000'000;
  EXPECT_TRUE(addition_for(f).contains("one every 48ms: the Period is that."));
  f.provided_period_ns = 70'000'000;
  text = addition_for(f);
  EXPECT_TRUE(
      text.contains("the Period is 48ms. It is refused, because network and gateway provide "
                    "a Period of 70ms."))
      << text;
  EXPECT_TRUE(text.contains("<Attributes period=\"48ms\" ")) << text;
  f.busy_gap_ns = 0;
  f.provided_period_ns = 200'000'000;
  EXPECT_TRUE(addition_for(f).contains("<Attributes period=\"200ms\" ")) << addition_for(f);
}

TEST_F(AuditDraft, ADatagramOfSubject0IsNoCanFrame) {
  control::Finding f = audit_.findings[2];
  f.subject = 0;
  EXPECT_EQ(name_of(f), "0x0000000000000000");
  EXPECT_EQ(addition_for(f), "");
  audit_.findings = {f};
  const auto json = nlohmann::json::parse(to_json(control::Reply{1, audit_}));
  EXPECT_TRUE(json["findings"][0]["identifier"].is_null());
  EXPECT_EQ(json["findings"][0]["subject"], "0x0000000000000000");
}

TEST_F(AuditDraft, WhoHasNoAddressIsNoPublisher) {
  control::Finding f = audit_.findings[2];
  f.address = "0.0.0.0";
  EXPECT_EQ(addition_for(f), "");
}

}  // namespace
}  // namespace mlcca::tools
