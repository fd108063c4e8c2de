// SPDX-License-Identifier: BSD-2-Clause
// What the audit report proposes for unknown frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/gates/plan.hpp"
#include "core/model/text.hpp"
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
  f.dropped = 1;
  f.would_drop = 0;
  f.provided_period_ns = 200'000'000;
  EXPECT_TRUE(addition_for(f).contains("<Attributes period=\"200ms\" ")) << addition_for(f);
}

constexpr std::uint64_t kNsOfMs = 1'000'000;
constexpr std::uint64_t kNsOfSecond = 1000 * kNsOfMs;

/// When the frames came, in ns.
using Arrivals = std::vector<std::uint64_t>;

/// What the daemon notes of frames if it reads the counters of the gate each second.
control::Finding noted(control::Finding f, const Arrivals& times) {
  std::map<std::uint64_t, std::uint64_t> readings;
  for (const std::uint64_t t : times) ++readings[t / kNsOfSecond];
  f.dropped = 0;
  f.would_drop = times.size();
  f.first_unix_s = readings.begin()->first + 1;
  f.last_unix_s = readings.rbegin()->first + 1;
  f.busy_gap_ns = 0;
  std::uint64_t before = 0;
  for (const auto& [second, frames] : readings) {
    const std::uint64_t since = before == 0 ? 0 : (second + 1 - before) * kNsOfSecond;
    const std::uint64_t gap = frames > 1 ? kNsOfSecond / frames : since;
    before = second + 1;
    if (gap != 0 && (f.busy_gap_ns == 0 || gap < f.busy_gap_ns)) f.busy_gap_ns = gap;
  }
  return f;
}

/// The value of an XML attribute in ns; 0 if it is not there.
std::uint64_t time_in(const std::string& text, const std::string& attribute) {
  const std::size_t at = text.find(' ' + attribute + "=\"");
  if (at == std::string::npos) return 0;
  const std::size_t from = at + attribute.size() + 3;
  const std::string words = text.substr(from, text.find('"', from) - from);
  static const std::map<std::string, std::uint64_t> units = {
      {"ns", 1}, {"us", 1000}, {"ms", kNsOfMs}, {"s", kNsOfSecond}};
  const std::size_t unit = words.find_first_not_of("0123456789.");
  return static_cast<std::uint64_t>(std::strtod(words.c_str(), nullptr) *
                                    static_cast<double>(units.at(words.substr(unit))));
}

/// How many of these frames a gate drops that enforces the addition.
std::size_t policed(const std::string& addition, const Arrivals& times) {
  AttributeSet offered;
  offered.set(Attribute::period, time_in(addition, "period"));
  offered.set(Attribute::jitter, time_in(addition, "jitter"));
  const core::Policing p = core::policing_of(offered, 1, 8);
  std::size_t dropped = 0;
  std::uint64_t next = 0;  // as take_turn() of bpf/police.bpf.h
  for (const std::uint64_t now : times) {
    const std::uint64_t turn = std::max(next, now);
    if (turn - now > p.tolerance)
      ++dropped;
    else
      next = turn + p.per_frame;
  }
  return dropped;
}

/// Wherever the daemon reads the counters meanwhile.
TEST_F(AuditDraft, ABurstPassesTheGatesWithTheAdditionThatWasMadeFromIt) {
  for (std::uint64_t n = 2; n <= 30; ++n)
    for (std::uint64_t d = 1; d <= 100; ++d)
      for (std::uint64_t start = kNsOfSecond; start < 2 * kNsOfSecond; start += 125 * kNsOfMs) {
        Arrivals times;
        for (std::uint64_t i = 0; i < n; ++i) times.push_back(start + i * d * kNsOfMs);
        const std::string addition = addition_for(noted(audit_.findings[0], times));
        ASSERT_EQ(policed(addition, times), 0U) << n << " each " << d << " ms:\n" << addition;
      }
}

/// Each second has such a burst, at its end or at its begin.
TEST_F(AuditDraft, BurstsInEachSecondPassTheGatesWithTheAdditionThatWasMadeFromThem) {
  for (std::uint64_t n = 2; n <= 60; n += 3) {
    Arrivals times;
    for (std::uint64_t second = 1; second < 200; ++second)
      for (std::uint64_t i = 0; i < n; ++i)
        times.push_back(second * kNsOfSecond + (second % 3 == 0 ? 900 * kNsOfMs : 0) + i * kNsOfMs);
    const std::string addition = addition_for(noted(audit_.findings[0], times));
    ASSERT_EQ(policed(addition, times), 0U) << n << ":\n" << addition;
  }
}

/// Also one whose Period is near a round one, and near what the network provides.
TEST_F(AuditDraft, APeriodicSenderPassesTheGatesWithTheAdditionThatWasMadeFromIt) {
  for (const std::uint64_t us : {1000U, 9850U, 9950U, 19700U, 20000U, 48000U, 733000U, 4000000U}) {
    Arrivals times;
    for (std::uint64_t i = 0; i < 20'000; ++i) times.push_back(kNsOfSecond + i * us * 1000);
    control::Finding f = noted(audit_.findings[0], times);
    const std::string addition = addition_for(f);
    EXPECT_EQ(policed(addition, times), 0U) << us << " us:\n" << addition;
    f.provided_period_ns = (us + us / 100) * 1000;
    EXPECT_EQ(policed(addition_for(f), times), 0U) << us << " us:\n" << addition_for(f);
  }
}

TEST_F(AuditDraft, SilenceOfWhatIsOnlyCountedIsNoFaultAndTheCommentSaysWhatWasNotMeasured) {
  const std::string text = addition_for(audit_.findings[0]);
  EXPECT_TRUE(text.contains(" arrival=\"sporadic\">")) << text;
  EXPECT_TRUE(text.contains("<Attributes jitter=\"1.951s\"/>\n</Publisher>")) << text;
  EXPECT_TRUE(text.contains("When within a second they came was not measured")) << text;
  EXPECT_EQ(text.find("--", text.find("<!--") + 4), text.find("-->")) << text;
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
