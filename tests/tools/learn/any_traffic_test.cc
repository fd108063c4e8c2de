// SPDX-License-Identifier: BSD-2-Clause
// Tests that for any traffic the draft is a description in which a check finds no errors, or a note
// says what could not be described.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/gates/plan.hpp"
#include "tests/tools/learn/drafted.hpp"
#include "tests/tools/learn/traffic.hpp"

namespace mlcca::learn {
namespace {

using test::drafted;
using test::in_order;
using test::kMs;
using test::kSecond;
using test::refused_in;
using test::Sent;
using test::Traffic;

bool is_noted(const Draft& draft, std::string_view text) {
  return std::ranges::any_of(draft.left_out,
                             [&](const std::string& note) { return note.contains(text); });
}

/// Diagnostic messages of `units` control units, the first of which send more often, and traffic by
/// which J1939 is recognised.
std::vector<Sent> trucks(std::uint32_t units) {
  Traffic traffic(units);
  traffic.periodic(0, 0x0cf00400 | kExtended, 20 * kMs, kMs, 8, 20)
      .periodic(0, 0x18eeff00 | kExtended, kSecond, 0, 8, 20);
  for (std::uint32_t unit = 0; unit < units; ++unit)
    traffic.periodic(0, (0x18feca00U + unit) | kExtended, (300 + 10 * unit) * kMs, kMs, 8, 20);
  return traffic.sent();
}

const DraftChannel& diagnostics(const Draft& draft) {
  const auto found = std::ranges::find(draft.channels, "can0-pgn-FECA", &DraftChannel::name);
  EXPECT_NE(found, draft.channels.end());
  return *found;
}

TEST(AnyTraffic, OfManySendersTheOnesWithMostEventsAreDescribed) {
  constexpr auto most = static_cast<std::uint32_t>(core::kMostBusEntries);
  const Draft full = drafted(trucks(most), {}, {"can0"});
  EXPECT_EQ(diagnostics(full).publishers.size(), most);
  EXPECT_TRUE(full.left_out.empty()) << full.left_out.front();
  for (const std::uint32_t units : {most + 1, 40U}) {
    const Draft draft = drafted(trucks(units), {}, {"can0"});
    const DraftChannel& channel = diagnostics(draft);
    ASSERT_EQ(channel.publishers.size(), most);
    for (std::uint32_t i = 0; i < most; ++i) EXPECT_EQ(channel.publishers[i].node, i);
    EXPECT_TRUE(is_noted(draft, "can0 0xfeca: " + std::to_string(units) + " senders"));
    EXPECT_TRUE(is_noted(draft, "drops what comes from node " + std::to_string(most)));
    EXPECT_TRUE(is_noted(draft, "with --profile can0=raw each has a channel of its own"));
    EXPECT_EQ(refused_in(draft), 0U);
  }
}

TEST(AnyTraffic, ByIdentifiersEachOfManySendersHasAChannel) {
  Observer observer;
  observer.state(0, core::Profile::raw);
  for (const Sent& one : trucks(40)) observer.add(one.frame());
  observer.finish(1);
  const Draft draft = tools::design::draft_that_holds(observer, {"can0"}, {});
  test::expect_no_errors(draft);
  EXPECT_EQ(draft.channels.size(), 42U);
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(AnyTraffic, WhoHasNoAddressIsNoPublisher) {
  auto sent = trucks(3);
  for (std::uint64_t i = 0; i < 10; ++i) {
    sent.push_back({i * kSecond, 0, 0x18fecafeU | kExtended, {1}});
    sent.push_back({i * kSecond, 0, 0x18fee6ffU | kExtended, {1}});
  }
  const Draft draft = drafted(in_order(std::move(sent)), {}, {"can0"});
  EXPECT_EQ(diagnostics(draft).publishers.size(), 3U);
  EXPECT_FALSE(draft.xml.contains("FEE6"));
  EXPECT_TRUE(is_noted(draft,
                       "can0: 20 events of 0xfeca, 0xfee6 from nodes that no publisher can "
                       "be, which a gate drops: nodes are 0 to 253"))
      << draft.left_out.front();
}

TEST(AnyTraffic, ABusThatTheAssumedBitRateCannotCarryIsAssumedToBeFaster) {
  Traffic traffic(1);
  for (std::uint32_t id = 0; id < 12; ++id) traffic.periodic(0, 0x100 + id, 2 * kMs, 0, 8, 5);
  const Draft draft = drafted(traffic.sent(), {}, {"can0"});
  EXPECT_TRUE(draft.xml.contains("<Bus bitrate=\"1000000\"/>")) << draft.xml;
  EXPECT_TRUE(draft.xml.contains("as 500 kbit/s cannot carry this: state the real one"));
  // A stated bit rate is used, and a note says what it cannot carry.
  Observer observer;
  for (const Sent& one : traffic.sent()) observer.add(one.frame());
  observer.finish(1);
  const Draft stated =
      tools::design::draft_that_holds(observer, {"can0"}, {.bitrates = {{"can0", 125'000}}});
  EXPECT_TRUE(stated.xml.contains("<Bus bitrate=\"125000\"/>"));
  EXPECT_TRUE(is_noted(stated, "'mlccactl check' refuses a part of this draft: "));
}

TEST(AnyTraffic, WhatWasSeenOnceIsAssumedToBeSeldomWhereThereIsMuchOfIt) {
  std::vector<Sent> sent;
  for (std::uint32_t id = 0; id < 600; ++id)
    sent.push_back({id * kMs, 0, (0x10000 + id * 7) | kExtended, {1, 2, 3, 4, 5, 6, 7, 8}});
  const Draft draft = drafted(sent, {.bitrates = {{"can0", 500'000}}}, {"can0"});
  EXPECT_EQ(draft.channels.size(), 600U);
  EXPECT_EQ(draft.channels.front().period, kSecond);
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(AnyTraffic, DeadlinesHoldAlsoForWhatTheyLetBeGranted) {
  Traffic traffic(60);
  for (std::uint32_t id = 0; id < 60; ++id)
    traffic.periodic(0, 0x100 + id, 15 * kMs, kMs / 2, 8, 20).forwarded(0, 0x100 + id, 1);
  EXPECT_EQ(refused_in(drafted(traffic.sent())), 0U);
}

TEST(AnyTraffic, NamesOfInterfacesThatAreAlikeAreMadeDifferent) {
  const std::string same(60, 'x');
  std::vector<std::string> names = {"gateway", "can0-100", "can0"};
  for (char c = 'a'; c <= 'z'; ++c) names.push_back(same + c);
  std::vector<Sent> sent;
  for (std::uint32_t i = 0; i < names.size(); ++i)
    for (std::uint64_t n = 0; n < 40; ++n)
      sent.push_back({n * 100 * kMs + i, i, 0x100, {static_cast<std::uint8_t>(i), 1}});
  const auto system = test::described(drafted(in_order(std::move(sent)), {}, names));
  std::set<std::string> networks;
  for (const auto& network : system.networks) networks.insert(network.name);
  EXPECT_EQ(networks.size(), names.size());
}

TEST(AnyTraffic, RemoteFramesOfAProfileThatHasNoneAreNoEvents) {
  auto sent = trucks(2);
  for (std::uint64_t i = 0; i < 40; ++i)
    sent.push_back({i * 100 * kMs, 0, 0x18feca07U | kExtended | kRemote, {}});
  const Draft draft = drafted(in_order(std::move(sent)), {}, {"can0"});
  EXPECT_FALSE(draft.xml.contains("remote-frames")) << draft.xml;
  EXPECT_TRUE(is_noted(draft, "can0: 40 frames that no channel of profile j1939 can have"));
}

// --- at random -----------------------------------------------------------------------------------

class Random {
 public:
  explicit Random(std::uint64_t seed) : random_(seed) {}
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }
  bool one_in(std::uint32_t n) { return below(n) == 0; }

 private:
  std::mt19937_64 random_;
};

std::string name_of_interface(Random& random) {
  constexpr std::array<const char*, 8> names = {"can0",
                                                "vcan-1",
                                                "gateway",
                                                "learned",
                                                "a name that is longer than any interface has",
                                                "a name that is longer than any interface hat",
                                                "-->",
                                                "can0-100"};
  return names[random.below(names.size())] + std::string(random.below(3), 'x');
}

/// An identifier that frames of a profile, or of none, have.
std::uint32_t identifier(Random& random, core::Profile profile) {
  const std::uint32_t any = random.below(1U << 29U);
  switch (profile) {
    case core::Profile::j1939:  // few PGNs, any source address
      return kExtended | (any & 0x1c000000U) | (0xfec0U + random.below(4)) << 8U | (any & 0xffU);
    case core::Profile::cyphal:
      return kExtended | (any & 0x1c000000U) | 0x600000U | random.below(40) << 8U | (any & 0x7fU);
    case core::Profile::famouso:
      return kExtended | (any & 0x1fc00000U) | (any & 0x1fc000U) | (0x64 + random.below(6));
    case core::Profile::canopen:
      return random.below(0x800);
    default:
      return random.one_in(2) ? random.below(0x800) : kExtended | any;
  }
}

struct AnyTrafficTest : ::testing::TestWithParam<std::uint32_t> {};

TEST_P(AnyTrafficTest, IsADraftOfWhichACheckRefusesNothing) {
  constexpr std::array profiles = {core::Profile::raw, core::Profile::j1939, core::Profile::cyphal,
                                   core::Profile::famouso, core::Profile::canopen};
  Random random(GetParam());
  std::vector<std::string> names;
  while (names.size() < 1 + GetParam() % 4) {
    const std::string name = name_of_interface(random);
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  const auto interfaces = static_cast<std::uint32_t>(names.size());
  Observer observer;
  std::vector<core::Profile> of;
  for (std::uint32_t i = 0; i < interfaces; ++i) {
    of.push_back(profiles[random.below(profiles.size())]);
    if (!random.one_in(4)) observer.state(i, of.back());
  }
  Traffic traffic(GetParam());
  const bool fd = random.one_in(3);
  const std::uint32_t senders = 5 + random.below(60);
  for (std::uint32_t n = 0; n < senders; ++n) {
    const std::uint32_t on = random.below(interfaces);
    const std::uint32_t id = identifier(random, of[on]);
    const std::size_t bytes = fd && of[on] == core::Profile::raw && random.one_in(4)
                                  ? 12 + random.below(4) * 4
                                  : random.below(9);
    if (random.one_in(3))
      traffic.bursts(on, id, 1 + random.below(4), kMs, (1 + random.below(5)) * kSecond, 15);
    else
      traffic.periodic(on, id, (100 + random.below(900)) * kMs, kMs * random.below(20), bytes, 15);
    if (interfaces > 1 && random.one_in(4)) traffic.forwarded(on, id, (on + 1) % interfaces);
  }
  auto sent = traffic.sent();
  for (Sent& one : sent) {
    one.fd = one.data.size() > 8;
    if (random.one_in(50) && !one.fd) {
      one.id |= kRemote;
      one.data.clear();
    }
    one.local = random.one_in(200);
    observer.add(one.frame());
  }
  observer.finish(interfaces);
  const Draft draft = tools::design::draft_that_holds(observer, names, {});
  auto system = test::described(draft);
  system.sort_bindings();
  for (const core::Finding& f : core::inspect(system).findings)
    EXPECT_NE(core::info(f.id).severity, core::Severity::error) << f.text << "; " << f.hint << '\n'
                                                                << draft.xml;
}

INSTANTIATE_TEST_SUITE_P(Seeds, AnyTrafficTest, ::testing::Range(1U, 121U));
// Here an event is longer than those that were seen to cross.
INSTANTIATE_TEST_SUITE_P(Found, AnyTrafficTest, ::testing::Values(2517U));

}  // namespace
}  // namespace mlcca::learn
