// SPDX-License-Identifier: BSD-2-Clause
// Drafts of buses with a profile: the transport protocol of J1939, heart-beats of CANopen; and what
// a table says of channels and buses.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/learn/drafted.hpp"
#include "tests/tools/learn/traffic.hpp"

namespace mlcca::learn {
namespace {

using mlcca::test::Folder;
using mlcca::test::Ran;
using mlcca::test::run;
using test::drafted;
using test::in_order;
using test::kMs;
using test::kSecond;
using test::refused_in;
using test::Sent;
using test::Traffic;

const DraftChannel* find(const Draft& draft, std::string_view name) {
  const auto found = std::ranges::find(draft.channels, name, &DraftChannel::name);
  return found == draft.channels.end() ? nullptr : &*found;
}

bool notes(const Draft& draft, std::string_view text) {
  return std::ranges::any_of(draft.left_out,
                             [&](const std::string& note) { return note.contains(text); });
}

// --- J1939 ---------------------------------------------------------------------------------------

/// A broadcast announcement, and three packets behind it.
void put_broadcast(std::vector<Sent>& to, std::uint64_t ns, std::uint8_t content) {
  to.push_back({ns, 0, 0x1cecff00U | kExtended, {0x20, 20, 0, 3, 0xff, 0xca, 0xfe, 0}});
  for (std::uint8_t packet = 1; packet <= 3; ++packet)
    to.push_back({ns + packet * 50 * kMs,
                  0,
                  0x1cebff00U | kExtended,
                  {packet, content, content, content, content, content, content, content}});
}

TEST(ProfileDraft, FewMessagesOfATransportProtocolHaveAPeriodThatItCanKeep) {
  auto sent = Traffic(1).periodic(0, 0x0cf00403 | kExtended, 20 * kMs, kMs, 8, 30).sent();
  sent.push_back({1, 0, 0x18eeff00U | kExtended, std::vector<std::uint8_t>(8)});
  for (std::uint8_t i = 0; i < 30; ++i) put_broadcast(sent, i * kSecond + 50 * kMs, i);
  const Draft draft = drafted(in_order(sent), {}, {"can0"});
  const DraftChannel* const long_one = find(draft, "can0-pgn-FECA");
  ASSERT_NE(long_one, nullptr) << draft.xml;
  EXPECT_EQ(long_one->period, kSecond);
  EXPECT_EQ(refused_in(draft), 0U) << draft.xml;
}

// --- CANopen -------------------------------------------------------------------------------------

/// Two nodes with their heart-beats, and PDOs that say them apart.
std::vector<Sent> nodes(bool crosses) {
  std::vector<Sent> sent;
  for (std::uint64_t ms = 0; ms < 30'000; ms += 10) {
    sent.push_back({ms * kMs, 0, 0x181, std::vector<std::uint8_t>(4, ms / 10 & 0xffU)});
    if (ms % 500 == 0) sent.push_back({(ms + 1) * kMs, 0, 0x701, {5}});
    if (ms % 500 == 0) sent.push_back({(ms + 2) * kMs, 1, 0x702, {5}});
    if (!crosses) continue;
    sent.push_back({ms * kMs + kMs / 2, 1, 0x181, std::vector<std::uint8_t>(4, ms / 10 & 0xffU)});
    if (ms % 500 == 0) sent.push_back({(ms + 1) * kMs + kMs / 2, 1, 0x701, {5}});
    if (ms % 1000 == 0) sent.push_back({(ms + 3) * kMs, 0, 0x080, {}});
    if (ms % 1000 == 0) sent.push_back({(ms + 3) * kMs + kMs / 2, 1, 0x080, {}});
  }
  return in_order(sent);
}

TEST(ProfileDraft, HeartBeatsThatCrossAreChannels) {
  const Draft draft = drafted(nodes(true));
  const DraftChannel* const beat = find(draft, "can0-cob-701");
  ASSERT_NE(beat, nullptr) << draft.xml;
  EXPECT_EQ(beat->period, 500 * kMs);
  EXPECT_EQ(beat->crosses_to, std::vector<std::string>{"can1"});
  EXPECT_TRUE(notes(draft, "heart-beats 0x701 go from can0 to can1")) << draft.xml;
  EXPECT_EQ(find(draft, "can1-cob-702"), nullptr) << "it stays where it is";
  EXPECT_EQ(refused_in(draft), 0U) << draft.xml;
}

TEST(ProfileDraft, OtherControlTrafficThatCrossesIsNamed) {
  const Draft draft = drafted(nodes(true));
  EXPECT_EQ(find(draft, "can0-cob-080"), nullptr);
  EXPECT_TRUE(notes(draft, "can1: control traffic came from another interface")) << draft.xml;
  EXPECT_TRUE(notes(draft, "0x080 from can0 (30)"));
}

TEST(ProfileDraft, HeartBeatsThatStayNeedNoChannel) {
  const Draft draft = drafted(nodes(false));
  EXPECT_EQ(draft.channels.size(), 1U) << draft.xml;
  EXPECT_TRUE(draft.left_out.empty());
}

// --- what is said of channels --------------------------------------------------------------------

TEST(ProfileDraft, BurstsAreTold) {
  Traffic traffic(4);
  traffic.bursts(0, 0x3e8, 4, kMs / 2, kSecond, 60).periodic(0, 0x100, 20 * kMs, kMs, 8, 60);
  std::uint64_t ns = 0;
  std::vector<Sent> sent = traffic.sent();
  for (unsigned i = 0; i < 100; ++i) {
    ns += 100 * kMs + traffic.below(900 * kMs);
    sent.push_back({ns, 0, 0x200, {1}});
  }
  const Draft draft = drafted(in_order(sent), {}, {"can0"});
  EXPECT_TRUE(find(draft, "can0-3E8")->bursts);
  EXPECT_TRUE(draft.xml.contains("aperiodic, in bursts: ")) << draft.xml;
  EXPECT_FALSE(find(draft, "can0-100")->bursts);
  EXPECT_FALSE(find(draft, "can0-200")->bursts);
  EXPECT_FALSE(find(draft, "can0-200")->periodic);
}

TEST(ProfileDraft, AChannelHasTheBandwidthThatWasSeen) {
  const Draft draft =
      drafted(Traffic(5).periodic(0, 0x100, 10 * kMs, 0, 8, 60).sent(), {}, {"can0"});
  EXPECT_NEAR(draft.channels.at(0).bytes_per_second.value_or(0), 800, 5);
}

TEST(ProfileDraft, OfAFewEventsInAShortTimeNoBandwidthIsStated) {
  const auto rate_of = [](std::uint64_t gap, std::uint64_t events) {
    std::vector<Sent> sent;
    for (std::uint64_t i = 0; i < events; ++i) sent.push_back({i * gap, 0, 0x123, {1, 2}});
    return drafted(sent, {}, {"can0"}).channels.at(0).bytes_per_second;
  };
  EXPECT_EQ(rate_of(5'000, 2), std::nullopt);
  EXPECT_EQ(rate_of(30 * kMs, 32), std::nullopt) << "0.93 s";
  EXPECT_NEAR(rate_of(30 * kMs, 35).value_or(0), 68.6, 0.1) << "1.02 s";
  EXPECT_EQ(rate_of(1 * kMs, 100), std::nullopt) << "0.099 s";
  EXPECT_NEAR(rate_of(2 * kMs, 100).value_or(0), 1010, 1) << "many";
  EXPECT_NEAR(rate_of(2'000 * kMs, 2).value_or(0), 2, 0.1) << "2 s";
}

TEST(ProfileDraft, TheMedianIsNoLessThanTheShortestGapAndNoMoreThanTheLongest) {
  std::vector<Sent> sent;
  for (std::uint64_t i = 0; i < 100; ++i)
    sent.push_back({i * 50'200'000 + i % 2 * 1000, 0, 0x123, {1}});
  const Draft draft = drafted(sent, {}, {"can0"});
  EXPECT_TRUE(draft.xml.contains("median gap 50.2ms, shortest 50.2ms")) << draft.xml;
}

TEST(ProfileDraft, TheTableHasLoadAndBandwidth) {
  const Folder folder;
  std::string text;
  for (unsigned i = 0; i < 1000; ++i)
    text += "(1700000" + std::to_string(100 + i / 100) + "." +
            std::to_string(100 + i % 100).substr(1) + "0000) can0 123#5555555555555555\n";
  const auto log = folder.write("a.log", text);
  const Ran ran = run({"learn", log, "--bitrate", "can0=100k", "--output", folder.path("a.xml")});
  EXPECT_EQ(ran.status, 0) << ran.error;
  // 111 bits and hardly any stuff bits, 100 times a second.
  EXPECT_TRUE(ran.out.contains("can0: 1000 frames, load 11.")) << ran.out;
  EXPECT_TRUE(ran.out.contains("BYTES/S")) << ran.out;
  EXPECT_TRUE(ran.out.contains("    801  periodic")) << ran.out;
  const Ran json = run({"learn", log, "--bitrate", "can0=100k", "--json"});
  EXPECT_TRUE(json.out.contains(R"("load_percent":11.)")) << json.out;
  EXPECT_TRUE(json.out.contains(R"("kind":"periodic")")) << json.out;
  EXPECT_TRUE(json.out.contains(R"("bytes_per_second":800.8)")) << json.out;
  EXPECT_TRUE(
      run({"learn", log, "--output", folder.path("b.xml")}).out.contains("1000 frames, profile"))
      << "no bit rate is known";
}

TEST(ProfileDraft, OfTwoFramesTheTableHasNeitherLoadNorBandwidth) {
  const Folder folder;
  const auto log = folder.write("a.log", "(1.000001) can0 123#11\n(1.000006) can0 123#11\n");
  const Ran ran = run({"learn", log, "--bitrate", "can0=100k", "--output", folder.path("a.xml")});
  EXPECT_EQ(ran.status, 0) << ran.error;
  EXPECT_TRUE(ran.out.contains("can0: 2 frames, profile ")) << ran.out;
  EXPECT_TRUE(ran.out.contains("  too few  ")) << ran.out;
  const Ran json = run({"learn", log, "--bitrate", "can0=100k", "--json"});
  EXPECT_FALSE(json.out.contains("load_percent")) << json.out;
  EXPECT_TRUE(json.out.contains(R"("bytes_per_second":null)")) << json.out;
}

}  // namespace
}  // namespace mlcca::learn
