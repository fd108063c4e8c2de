// SPDX-License-Identifier: BSD-2-Clause
// Drafts of buses between which frames go on under another identifier, as rules of can-gw with
// "-m SET:I" make them.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/tools/learn/drafted.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/variety.hpp"

namespace mlcca::learn {
namespace {

using test::described;
using test::drafted;
using test::kMs;
using test::kSecond;
using test::refused_in;
using test::Sent;
using test::Traffic;

/// Values as sensors have them, every 20 ms for 20 s.
std::vector<Sent> measured(Traffic& random, std::uint32_t interface, std::uint32_t id) {
  std::vector<Sent> out;
  std::uint32_t value = 30'000;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    value = value + static_cast<std::uint32_t>(random.below(201)) - 100;
    out.push_back({kSecond + i * 20 * kMs + random.below(kMs),
                   interface,
                   id,
                   {static_cast<std::uint8_t>(value >> 8U), static_cast<std::uint8_t>(value), 0,
                    static_cast<std::uint8_t>(i)}});
  }
  return out;
}

/// A counter of 8 bits with a check sum.
std::vector<Sent> counted(Traffic& random, std::uint32_t interface, std::uint32_t id) {
  std::vector<Sent> out;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const auto count = static_cast<std::uint8_t>(i);
    out.push_back({kSecond + i * 20 * kMs + random.below(kMs),
                   interface,
                   id,
                   {count, 0, static_cast<std::uint8_t>(count ^ 0xa5U)}});
  }
  return out;
}

/// The same a little later, on another bus under another identifier.
std::vector<Sent> carried(Traffic& random, std::vector<Sent> of, std::uint32_t to,
                          std::uint32_t id) {
  for (Sent& one : of) {
    one.ns += kMs / 5 + random.below(kMs / 5);
    one.interface = to;
    one.id = id;
  }
  return of;
}

Draft drafted_from(std::vector<std::vector<Sent>> parts) {
  std::vector<Sent> all;
  for (auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  std::ranges::stable_sort(all, {}, &Sent::ns);
  return drafted(all);
}

std::vector<std::string> notes_with(const Draft& draft, std::string_view text) {
  std::vector<std::string> out;
  std::ranges::copy_if(draft.left_out, std::back_inserter(out),
                       [&](const std::string& note) { return note.contains(text); });
  return out;
}

TEST(Renumbered, IsOneChannelBoundOnEachBus) {
  Traffic random(1);
  const auto speed = measured(random, 0, 0x123);
  const Draft draft =
      drafted_from({speed, carried(random, speed, 1, 0x456), measured(random, 0, 0x124),
                    measured(random, 1, 0x457), counted(random, 1, 0x458)});
  ASSERT_EQ(draft.channels.size(), 4U) << draft.xml;
  const DraftChannel& one = draft.channels[0];
  EXPECT_EQ(one.name, "can0-123");
  EXPECT_EQ(one.crosses_to, std::vector<std::string>{"can1"});
  EXPECT_EQ(one.numbers.at("can0"), 0x123U);
  EXPECT_EQ(one.numbers.at("can1"), 0x456U);
  ASSERT_EQ(one.publishers.size(), 1U) << "who copies is none";
  const auto notes = notes_with(draft, "can1 0x456 is can0 0x123 under another identifier (99 % ");
  ASSERT_EQ(notes.size(), 1U) << draft.xml;
  EXPECT_TRUE(notes[0].contains("1000 of 1000 events had its data up to ")) << notes[0];
  EXPECT_TRUE(notes[0].contains("the draft has the channel can0-123 for both")) << notes[0];
  EXPECT_EQ(refused_in(draft), 0U) << draft.xml;
  EXPECT_EQ(described(draft).networks.size(), 2U);
}

TEST(Renumbered, MayGoOnOverSeveralBuses) {
  Traffic random(2);
  const auto speed = measured(random, 0, 0x123);
  const auto second = carried(random, speed, 1, 0x456);
  std::vector<Sent> all;
  for (const auto& part : {speed, second, carried(random, second, 2, 0x789)})
    all.insert(all.end(), part.begin(), part.end());
  std::ranges::stable_sort(all, {}, &Sent::ns);
  const Draft draft = drafted(all, {}, {"can0", "can1", "can2"});
  ASSERT_EQ(draft.channels.size(), 1U) << draft.xml;
  EXPECT_EQ(draft.channels[0].numbers.at("can2"), 0x789U);
  EXPECT_EQ(refused_in(draft), 0U) << draft.xml;
}

TEST(Renumbered, CountersThatBeganTogetherAreTwoChannelsAndANote) {
  Traffic random(3);
  const auto count = counted(random, 0, 0x123);
  const Draft draft = drafted_from({count, carried(random, count, 1, 0x456)});
  EXPECT_EQ(draft.channels.size(), 2U) << draft.xml;
  EXPECT_EQ(notes_with(draft, "under another identifier, which is not certain").size(), 1U)
      << draft.xml;
}

TEST(Renumbered, WhatHardlyChangesIsNotNamed) {
  Traffic random(4);
  std::vector<std::vector<Sent>> parts;
  for (std::uint32_t i = 0; i < 8; ++i) {
    parts.push_back(measured(random, i % 2, 0x100 + i));
    for (auto& one : parts.back()) one.data = {0, static_cast<std::uint8_t>(one.ns / kSecond % 2)};
  }
  const Draft draft = drafted_from(parts);
  EXPECT_EQ(draft.channels.size(), 8U);
  EXPECT_TRUE(notes_with(draft, "identifier").empty()) << draft.xml;
}

TEST(Renumbered, ManyNodesThatCountAreNeverTakenForOne) {
  Traffic random(5);
  std::vector<std::vector<Sent>> parts;
  for (std::uint32_t i = 0; i < 40; ++i) parts.push_back(counted(random, i % 2, 0x100 + i));
  const Draft draft = drafted_from(parts);
  EXPECT_EQ(draft.channels.size(), 40U);
  EXPECT_LE(notes_with(draft, "not certain").size(), 8U);
}

// --- how much contents say -----------------------------------------------------------------------

TEST(Variety, OfCountersIsLittle) {
  for (const bool wide : {false, true}) {
    Variety variety;
    for (std::uint32_t i = 0; i < 100'000; ++i) {
      const auto low = static_cast<std::uint8_t>(i);
      const auto high = static_cast<std::uint8_t>(wide ? i >> 8U : 7U);
      variety.add(std::vector<std::uint8_t>{high, low, static_cast<std::uint8_t>(high ^ low)});
    }
    EXPECT_TRUE(variety.changes());
    EXPECT_FALSE(variety.is_rich()) << wide;
  }
}

TEST(Variety, OfWhatStaysIsNone) {
  Variety variety;
  for (unsigned i = 0; i < 1000; ++i) variety.add(std::vector<std::uint8_t>{1, 2});
  EXPECT_FALSE(variety.changes());
}

TEST(Variety, OfMeasuredValuesIsRich) {
  Traffic random(6);
  Variety variety;
  for (const Sent& one : measured(random, 0, 1)) variety.add(one.data);
  EXPECT_TRUE(variety.is_rich());
}

}  // namespace
}  // namespace mlcca::learn
