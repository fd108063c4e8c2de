// SPDX-License-Identifier: BSD-2-Clause
// Fragments as FAMOUSO's own programs make and take them.
#include "relay/afp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace mlcca::relay::afp {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr Form kMesh{.payload = 1392, .numbered = true};  // as FAMOUSO's for AWDS

/// Octet i is i, modulo 256.
Event event_of(std::size_t size) {
  Event out(size);
  std::iota(out.begin(), out.end(), std::uint8_t{0});
  return out;
}

std::vector<Event> cut(const Form& form, const Event& event, std::uint32_t number = 0) {
  auto fragments = Fragments::of(form, event, number);
  EXPECT_TRUE(fragments) << event.size();
  std::vector<Event> out;
  if (!fragments) return out;
  while (auto one = fragments->next()) out.push_back(std::move(*one));
  EXPECT_EQ(out.size(), fragments->count());
  return out;
}

std::string hex(const Event& octets, std::size_t most = 12) {
  static constexpr const char* kDigits = "0123456789ABCDEF";
  std::string out;
  for (const std::uint8_t octet : std::span(octets).first(std::min(octets.size(), most))) {
    out += kDigits[octet >> 4U];
    out += kDigits[octet & 15U];
  }
  return out;
}

std::optional<Event> put_together(Reassembly& reassembly, const std::vector<Event>& fragments,
                                  Reassembly::Source source = 1, std::uint64_t now = 0) {
  std::optional<Event> last;
  for (const Event& fragment : fragments)
    if (auto whole = reassembly.take(source, fragment, now)) {
      EXPECT_FALSE(last) << "an event comes once";
      last = std::move(whole);
    }
  return last;
}

// --- the octets ----------------------------------------------------------------------------------

TEST(Afp, EventsOnCanAreCutAsByFamouso) {
  const auto nine = cut(kCan, event_of(9));
  ASSERT_EQ(nine.size(), 2U);
  EXPECT_EQ(hex(nine[0]), "2100010203040506");
  EXPECT_EQ(hex(nine[1]), "000708");
  EXPECT_EQ(hex(cut(kCan, event_of(14))[1]), "000708090A0B0C0D");
  const auto twenty = cut(kCan, event_of(20));
  ASSERT_EQ(twenty.size(), 3U);
  EXPECT_EQ(hex(twenty[0]), "2200010203040506");
  EXPECT_EQ(hex(twenty[1]), "010708090A0B0C0D");
  EXPECT_EQ(hex(twenty[2]), "000E0F10111213");
}

TEST(Afp, TheHeaderIsAsShortAsTheNumberAllows) {
  const auto last_short = cut(kCan, event_of(224));
  ASSERT_EQ(last_short.size(), 32U);
  EXPECT_EQ(hex(last_short[0]), "3F00010203040506");
  EXPECT_EQ(hex(last_short[31]), "00D9DADBDCDDDEDF");
  const auto first_long = cut(kCan, event_of(225));
  ASSERT_EQ(first_long.size(), 33U);
  EXPECT_EQ(hex(first_long[0]), "9020000102030405");
  EXPECT_EQ(hex(first_long[1]), "1F060708090A0B0C");
  EXPECT_EQ(hex(first_long[32]), "00DFE0");
  const auto longer = cut(kCan, event_of(300));
  EXPECT_EQ(hex(longer[0]).substr(0, 4), "902C");
  EXPECT_EQ(hex(longer[1]).substr(0, 4), "802B");
}

TEST(Afp, EventsWithANumberAreCutAsByFamouso) {
  const auto udp = cut(kUdp, event_of(10'000), 0);
  ASSERT_EQ(udp.size(), 2U);
  EXPECT_EQ(hex(udp[0], 8), "6100000000000001");
  EXPECT_EQ(hex(udp[1], 6), "400000000000");
  EXPECT_EQ(udp[0].size(), 8183U);
  EXPECT_EQ(udp[1].size(), 6 + 1823U);
  const auto awds = cut(kMesh, event_of(3'000), 2);
  ASSERT_EQ(awds.size(), 3U);
  EXPECT_EQ(hex(awds[0], 6), "620000000002");
  EXPECT_EQ(hex(awds[1], 6), "410000000002");
  EXPECT_EQ(hex(awds[2], 6), "400000000002");
  EXPECT_EQ(awds[2].size(), 6 + 228U);
}

TEST(Afp, TheLongestEventIsTheLongestThatFamousoTakes) {
  EXPECT_EQ(longest_event(kCan), 24'608U);
  EXPECT_EQ(longest_event(kUdp), 65'535U);
  const auto all = cut(kCan, event_of(24'608));
  ASSERT_EQ(all.size(), kMostFragments);
  EXPECT_EQ(hex(all[0]).substr(0, 4), "9FFF");
  const auto longer = Fragments::of(kCan, event_of(24'609));
  ASSERT_FALSE(longer);
  EXPECT_EQ(longer.error().text, "an event of 24609 octets: at most 24608 fit 4096 fragments");
}

// --- both ways -----------------------------------------------------------------------------------

TEST(Afp, WhatIsCutIsPutTogether) {
  for (const Form& form : {kCan, kUdp, kMesh, Form{.payload = 64, .numbered = true}}) {
    Reassembly reassembly(form);
    std::uint32_t number = 7;
    for (const std::size_t size : {0, 1, 7, 8, 9, 224, 225, 1'000, 6'000, 24'608}) {
      if (size > longest_event(form)) continue;
      const Event event = event_of(size);
      EXPECT_EQ(put_together(reassembly, cut(form, event, ++number)), event) << size;
    }
    EXPECT_EQ(reassembly.begun(), 0U);
    EXPECT_EQ(reassembly.octets(), 0U);
    EXPECT_EQ(reassembly.losses(), Losses{});
  }
}

TEST(Afp, NumberedFragmentsComeInAnyOrderAndTwice) {
  std::mt19937 random(1);
  Reassembly reassembly(kMesh);
  for (std::uint32_t number = 0; number < 200; ++number) {
    const Event event = event_of(1'000 + random() % 8'000);
    auto fragments = cut(kMesh, event, number);
    fragments.push_back(fragments[random() % fragments.size()]);
    std::ranges::shuffle(fragments, random);
    EXPECT_EQ(put_together(reassembly, fragments), event) << number;
  }
  EXPECT_EQ(reassembly.losses().duplicates, 200U);
  EXPECT_EQ(reassembly.begun(), 0U);
}

/// What is late is missing: a subscriber sees events in their order.
TEST(Afp, AnEventThatIsOvertakenIsLostAndCountedOnce) {
  Reassembly reassembly(kMesh);
  const Event event = event_of(3'000);
  const auto first = cut(kMesh, event, 0xfffffffe);
  ASSERT_EQ(first.size(), 3U);
  EXPECT_FALSE(reassembly.take(1, first[0], 0));
  EXPECT_EQ(put_together(reassembly, cut(kMesh, event, 0xffffffff)), event);
  EXPECT_FALSE(put_together(reassembly, {first[1], first[2], first[0]}));
  EXPECT_EQ(reassembly.losses().late, 1U);
  EXPECT_EQ(reassembly.begun(), 0U);
  EXPECT_EQ(reassembly.octets(), 0U);
  // After the highest number 0 comes.
  EXPECT_EQ(put_together(reassembly, cut(kMesh, event, 1)), event);
  EXPECT_FALSE(put_together(reassembly, cut(kMesh, event, 0)));
  EXPECT_FALSE(put_together(reassembly, cut(kMesh, event, 0xfffffff0)));
  EXPECT_EQ(reassembly.losses().late, 3U);
  EXPECT_EQ(put_together(reassembly, cut(kMesh, event, 0), 2), event) << "another source";
  // A sender that begins again has other numbers; 3 s later nothing is remembered.
  EXPECT_EQ(put_together(reassembly, cut(kMesh, event, 0xfffff000)), event);
  EXPECT_EQ(put_together(reassembly, cut(kMesh, event, 0), 1, 3 * kSecond), event);
  EXPECT_EQ(reassembly.losses().late, 3U);
}

TEST(Afp, EventsOfANetworkThatReordersComeInTheirOrder) {
  std::mt19937 random(2);
  Reassembly reassembly(kMesh);
  std::vector<std::pair<std::uint32_t, Event>> sent;
  for (std::uint32_t number = 0; number < 300; ++number)
    for (Event& fragment : cut(kMesh, event_of(2'000), number)) {
      sent.emplace_back(number, fragment);
      if (random() % 10 == 0) sent.emplace_back(number, std::move(fragment));
    }
  for (std::size_t i = 0; i + 4 < sent.size(); ++i)
    if (random() % 5 == 0) std::swap(sent[i], sent[i + 1 + random() % 4]);
  std::optional<std::uint32_t> latest;
  std::size_t came = 0;
  for (const auto& [number, fragment] : sent) {
    if (!reassembly.take(1, fragment, 0)) continue;
    EXPECT_TRUE(!latest || number > *latest) << number;
    latest = number;
    ++came;
  }
  EXPECT_EQ(came + reassembly.losses().late, 300U);
  EXPECT_GT(reassembly.losses().late, 0U);
  EXPECT_GT(came, 200U);
}

TEST(Afp, SourcesAreApart) {
  Reassembly reassembly(kCan);
  const Event a = event_of(20);
  Event b = event_of(20);
  std::ranges::reverse(b);
  const auto of_a = cut(kCan, a);
  const auto of_b = cut(kCan, b);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_FALSE(reassembly.take(1, of_a[i], 0));
    EXPECT_FALSE(reassembly.take(2, of_b[i], 0));
  }
  EXPECT_EQ(reassembly.take(2, of_b[2], 0), b);
  EXPECT_EQ(reassembly.take(1, of_a[2], 0), a);
}

// --- what is lost --------------------------------------------------------------------------------

TEST(Afp, WithoutNumbersAGapEndsTheEventAndTheNextOneComesWhole) {
  Reassembly reassembly(kCan);
  const auto fragments = cut(kCan, event_of(27));
  ASSERT_EQ(fragments.size(), 4U);
  for (const std::size_t i : {0, 2, 3}) EXPECT_FALSE(reassembly.take(1, fragments[i], 0));
  EXPECT_EQ(reassembly.losses().incomplete, 1U) << "and not once for each fragment behind the gap";
  EXPECT_FALSE(reassembly.take(1, fragments[0], 0));
  EXPECT_FALSE(reassembly.take(1, fragments[0], 0)) << "the sender has begun again";
  EXPECT_EQ(reassembly.losses().incomplete, 2U);
  for (const std::size_t i : {1, 2}) EXPECT_FALSE(reassembly.take(1, fragments[i], 0));
  EXPECT_EQ(reassembly.take(1, fragments[3], 0), event_of(27));
}

TEST(Afp, AnEventThatIsNotCompleteInThreeSecondsIsGivenUp) {
  for (const Form& form : {kCan, kMesh}) {
    Reassembly reassembly(form);
    const auto fragments = cut(form, event_of(2'000), 9);
    EXPECT_FALSE(reassembly.take(1, fragments[0], 0));
    EXPECT_FALSE(reassembly.take(2, fragments[1], 3 * kSecond - 1));
    EXPECT_EQ(reassembly.losses().incomplete, 0U);
    EXPECT_FALSE(reassembly.take(1, fragments[1], 3 * kSecond));
    EXPECT_EQ(reassembly.losses().incomplete, 1U);
  }
}

TEST(Afp, ALateDuplicateOfAnEventIsNoEventForThreeSeconds) {
  Reassembly reassembly(kUdp);
  const auto fragments = cut(kUdp, event_of(100), 5);
  ASSERT_EQ(fragments.size(), 1U);
  EXPECT_TRUE(reassembly.take(1, fragments[0], 0));
  EXPECT_FALSE(reassembly.take(1, fragments[0], 3 * kSecond - 1));
  EXPECT_TRUE(reassembly.take(2, fragments[0], 3 * kSecond - 1)) << "another source";
  EXPECT_TRUE(reassembly.take(1, fragments[0], 3 * kSecond));
}

// --- a sender that starts again, with the same numbers, as FAMOUSO's own -------------------------

/// An event with these bytes.
Event filled(std::size_t size, std::uint8_t with) { return Event(size, with); }

TEST(Afp, ASenderThatStartsAgainIsKnownByItsData) {
  Reassembly reassembly(kUdp);
  for (std::uint32_t number = 0; number < 5; ++number) {
    const Event event = filled(20'000, static_cast<std::uint8_t>(number));
    EXPECT_EQ(put_together(reassembly, cut(kUdp, event, number)), event);
  }
  for (std::uint32_t number = 0; number < 5; ++number) {
    const Event event = filled(20'000, static_cast<std::uint8_t>(100 + number));
    EXPECT_EQ(put_together(reassembly, cut(kUdp, event, number)), event) << number;
  }
  EXPECT_EQ(reassembly.losses(), Losses{});
}

TEST(Afp, ASenderThatStartsAgainWithALongerEventIsKnown) {
  Reassembly reassembly(kUdp);
  const Event event = filled(9'000, 1);
  EXPECT_EQ(put_together(reassembly, cut(kUdp, event, 0)), event);
  const Event longer = filled(50'000, 1);
  EXPECT_EQ(put_together(reassembly, cut(kUdp, longer, 0)), longer);
  EXPECT_EQ(reassembly.losses(), Losses{});
}

/// It ended in the middle of an event, of which nothing may be mixed with that of the next one.
TEST(Afp, AnEventThatASenderBeganBeforeItStartedAgainIsLostAndCounted) {
  Reassembly reassembly(kUdp);
  const auto before = cut(kUdp, filled(20'000, 1), 0);
  EXPECT_FALSE(reassembly.take(1, before[0], 0));
  EXPECT_FALSE(reassembly.take(1, before[1], 0));
  const Event event = filled(20'000, 2);
  EXPECT_EQ(put_together(reassembly, cut(kUdp, event, 0)), event);
  EXPECT_EQ(reassembly.losses().incomplete, 1U);
  EXPECT_EQ(reassembly.begun(), 0U);
}

/// The same events could be old ones, so they do not come twice; but they are counted.
TEST(Afp, TheSameEventsOfASenderThatStartsAgainAreCounted) {
  Reassembly reassembly(kUdp);
  const Event event = filled(20'000, 1);
  for (std::uint32_t number = 0; number < 5; ++number)
    EXPECT_EQ(put_together(reassembly, cut(kUdp, event, number)), event);
  for (std::uint32_t number = 0; number < 5; ++number)
    EXPECT_FALSE(put_together(reassembly, cut(kUdp, event, number)));
  EXPECT_EQ(reassembly.losses().repeated, 5U);
  EXPECT_EQ(put_together(reassembly, cut(kUdp, event, 5)), event);
  EXPECT_EQ(reassembly.losses().repeated, 5U);
}

TEST(Afp, WhatANetworkDoublesIsNoLoss) {
  Reassembly reassembly(kUdp);
  for (std::uint32_t number = 0; number < 5; ++number) {
    const Event event = filled(20'000, static_cast<std::uint8_t>(number % 2));
    const auto fragments = cut(kUdp, event, number);
    EXPECT_EQ(put_together(reassembly, fragments), event);
    EXPECT_FALSE(put_together(reassembly, fragments));
  }
  EXPECT_EQ(reassembly.losses().repeated, 0U);
  EXPECT_EQ(reassembly.losses().duplicates, 15U);
}

TEST(Afp, ASenderThatStartsAgainBelowWhatIsRememberedIsLateAndKnownSoon) {
  Reassembly reassembly(kUdp);
  for (const std::uint32_t number : {100U, 101U}) {
    const Event event = filled(9'000, 1);
    EXPECT_EQ(put_together(reassembly, cut(kUdp, event, number)), event);
  }
  for (std::uint8_t run = 0; run < 2; ++run)
    EXPECT_FALSE(put_together(reassembly, cut(kUdp, filled(9'000, run), run)));
  EXPECT_EQ(reassembly.losses().late, 2U);
  const Event event = filled(9'000, 9);
  EXPECT_EQ(put_together(reassembly, cut(kUdp, event, 0)), event) << "it has started once more";
  EXPECT_EQ(put_together(reassembly, cut(kUdp, event, 1)), event);
}

TEST(Afp, OtherSourcesAreNotConcerned) {
  Reassembly reassembly(kUdp);
  const auto fragments = cut(kUdp, filled(9'000, 1), 0);
  EXPECT_TRUE(put_together(reassembly, fragments, 2));
  EXPECT_FALSE(reassembly.take(3, fragments[0], 0));
  EXPECT_TRUE(put_together(reassembly, fragments, 1));
  EXPECT_TRUE(put_together(reassembly, cut(kUdp, filled(9'000, 2), 0), 1));
  EXPECT_FALSE(put_together(reassembly, fragments, 2)) << "a duplicate";
  EXPECT_TRUE(reassembly.take(3, fragments[1], 0));
  EXPECT_EQ(reassembly.losses().incomplete, 0U);
}

TEST(Afp, WhatIsNoFragmentIsCounted) {
  Reassembly can(kCan);
  const std::vector<Event> none_on_can = {
      {},
      {0x21, 0, 1, 2, 3, 4, 5, 6, 7},  // longer than a frame
      {0x21, 0, 1},                    // not the last one, and does not fill its frame
      {0x60, 0, 0, 0, 0, 1, 2, 3},     // with an extension
      {0x90},                          // half a header
      {0x80, 0x1f, 0, 0, 0, 0, 0, 0},  // a longer header than is needed
      {0xc8, 0x10, 0, 0, 0, 0, 0, 0},  // three octets
      {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff},
  };
  for (const Event& octets : none_on_can) EXPECT_FALSE(can.take(1, octets, 0)) << hex(octets);
  EXPECT_EQ(can.losses().malformed, none_on_can.size());
  Reassembly udp(kUdp);
  const std::vector<Event> none_on_udp = {
      {0x20, 1, 2},                                        // without a number
      {0x60, 0, 0, 0, 0},                                  // half a number
      {0x60, 0x29, 0x32, 0, 0, 0, 4, 0, 22},               // error correction alone
      {0x65, 0x40, 0, 0, 0, 0, 0x29, 0x32, 0, 0, 0, 4, 0}  // behind a number
  };
  for (const Event& octets : none_on_udp) EXPECT_FALSE(udp.take(1, octets, 0)) << hex(octets);
  EXPECT_EQ(udp.losses().malformed, none_on_udp.size());
  EXPECT_EQ(can.begun() + udp.begun(), 0U);
}

TEST(Afp, FragmentsThatContradictEachOtherEndTheEvent) {
  const Form form{.payload = 16, .numbered = true};
  const auto three = cut(form, event_of(25), 1);
  const auto four = cut(form, event_of(35), 1);
  ASSERT_EQ(three.size(), 3U);
  ASSERT_EQ(four.size(), 4U);
  for (const auto& [first, second] : {std::pair(three[0], four[0]),
                                      {four[0], three[0]},
                                      {four[1], three[0]},
                                      {three[1], three[0]}}) {
    Reassembly reassembly(form);
    EXPECT_FALSE(reassembly.take(1, first, 0));
    EXPECT_FALSE(reassembly.take(1, second, 0));
    const bool fits = first == three[1] || first == four[1];
    EXPECT_EQ(reassembly.begun(), fits ? 1U : 0U) << hex(first) << ' ' << hex(second);
  }
}

// --- bounds --------------------------------------------------------------------------------------

TEST(Afp, WhoBeginsMostLosesFirst) {
  Reassembly reassembly(kMesh);
  const auto honest = cut(kMesh, event_of(2'000), 77);
  EXPECT_FALSE(reassembly.take(1, honest[0], 0));
  for (std::uint32_t number = 0; number < 10'000; ++number)
    EXPECT_FALSE(reassembly.take(2, cut(kMesh, event_of(2'000), number)[0], number));
  EXPECT_EQ(reassembly.begun(), 64U);
  EXPECT_LE(reassembly.octets(), std::size_t{1} << 20);
  EXPECT_EQ(reassembly.take(1, honest[1], 10'000), event_of(2'000));
}

TEST(Afp, MemoryIsBoundedWhateverComes) {
  std::mt19937 random(2);
  for (const Form& form : {kCan, kUdp, Form{.payload = 16, .numbered = true}}) {
    Reassembly reassembly(form, {.begun = 16, .octets = 50'000, .remembered = 32});
    std::vector<std::vector<Event>> events;
    for (std::uint32_t number = 0; number < 200; ++number)
      events.push_back(cut(form, event_of(random() % 3'000), number % 50));
    std::uint64_t now = 0;
    for (int i = 0; i < 30'000; ++i) {
      const auto& fragments = events[random() % events.size()];
      Event octets = fragments[random() % fragments.size()];
      if (random() % 4 == 0 && !octets.empty())
        octets[random() % std::min<std::size_t>(octets.size(), 7)] =
            static_cast<std::uint8_t>(random());
      if (random() % 8 == 0) octets.resize(random() % (form.payload + 2));
      static_cast<void>(reassembly.take(random() % 5, octets, now += random() % kSecond / 100));
      ASSERT_LE(reassembly.begun(), 16U);
      ASSERT_LE(reassembly.octets(), 50'000U);
      ASSERT_LE(reassembly.remembered(), 32U);
    }
    static_cast<void>(reassembly.take(9, Event{}, now + 4 * kSecond));
    EXPECT_EQ(reassembly.begun(), 0U);
    EXPECT_EQ(reassembly.octets(), 0U);
    EXPECT_EQ(reassembly.remembered(), 0U);
  }
}

}  // namespace
}  // namespace mlcca::relay::afp
