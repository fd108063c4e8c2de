// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/crossings.hpp"

#include <gtest/gtest.h>

#include "tests/tools/learn/traffic.hpp"

namespace mlcca::learn {
namespace {

using test::kMs;
using test::kSecond;

/// Flow 0 is on a bus, flow 1 on an Ethernet, as are further ones.
std::vector<Crossings::Of> flows_on(std::size_t count, bool local = false) {
  std::vector<Crossings::Of> out;
  for (std::uint32_t i = 0; i < count; ++i)
    out.push_back({.interface = i, .ethernet = i != 0, .number = 7, .local = local, .origin = {}});
  return out;
}

TEST(Crossings, WhatHadBeenThereShortlyBeforeIsACopy) {
  Crossings crossings;
  for (std::uint64_t i = 0; i < 100; ++i) {
    crossings.add(0, 0, kSecond + i * 10 * kMs, i);
    crossings.add(1, 1, kSecond + i * 10 * kMs + kMs / 2 + i, i);
  }
  const auto found = crossings.find(flows_on(2));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].copy, 1U);
  EXPECT_EQ(found[0].origin, 0U);
  EXPECT_TRUE(found[0].sure);
  EXPECT_EQ(found[0].crossing.events, 100U);
  EXPECT_EQ(found[0].crossing.shortest_ns, kMs / 2);
  EXPECT_EQ(found[0].crossing.longest_ns, kMs / 2 + 99);
}

TEST(Crossings, TheOrderInWhichInterfacesAreReadDoesNotMatter) {
  Crossings crossings;
  for (std::uint64_t i = 0; i < 100; ++i) crossings.add(1, 1, i * 10 * kMs + kMs, i);
  for (std::uint64_t i = 0; i < 100; ++i) crossings.add(0, 0, i * 10 * kMs, i);
  ASSERT_EQ(crossings.find(flows_on(2)).size(), 1U);
}

TEST(Crossings, SomeOfTheEventsMayBeLost) {
  Crossings crossings;
  for (std::uint64_t i = 0; i < 100; ++i) {
    crossings.add(0, 0, i * 10 * kMs, i);
    if (i % 10 != 0) crossings.add(1, 1, i * 10 * kMs + kMs, i);
  }
  EXPECT_EQ(crossings.find(flows_on(2)).size(), 1U);
}

TEST(Crossings, OtherContentOrOtherTimesAreNoCopies) {
  Crossings late;
  Crossings other;
  Crossings half;
  for (std::uint64_t i = 0; i < 100; ++i) {
    late.add(0, 0, i * 10 * kMs, i);
    late.add(1, 1, i * 10 * kMs + 101 * kMs, i);
    other.add(0, 0, i * 10 * kMs, i);
    other.add(1, 1, i * 10 * kMs + kMs, i + 1000);
    half.add(0, 0, i * 10 * kMs, i);
    half.add(1, 1, i * 10 * kMs + kMs, i % 2 == 0 ? i : i + 1000);
  }
  EXPECT_TRUE(late.find(flows_on(2)).empty());
  EXPECT_TRUE(other.find(flows_on(2)).empty());
  EXPECT_TRUE(half.find(flows_on(2)).empty()) << "half of them are its own";
}

TEST(Crossings, AFewEventsThatHaveTheContentOfManyAreNoCopies) {
  Crossings crossings;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    crossings.add(0, 0, i * kMs, i % 4);
    if (i % 100 == 0) crossings.add(1, 1, i * kMs + kMs / 2, i / 100 % 4);
  }
  EXPECT_TRUE(crossings.find(flows_on(2)).empty());
}

TEST(Crossings, WhatNeverChangesIsSureOnlyWhereThisHostSendsIt) {
  for (const bool local : {false, true}) {
    Crossings crossings;
    for (std::uint64_t i = 0; i < 100; ++i) {
      crossings.add(0, 0, i * 50 * kMs, 1);
      crossings.add(1, 1, i * 50 * kMs + kMs, 1);
    }
    const auto found = crossings.find(flows_on(2, local));
    ASSERT_EQ(found.size(), 1U) << "and not the other way round as well";
    EXPECT_EQ(found[0].copy, 1U) << "the one that is nearer in time";
    EXPECT_EQ(found[0].sure, local);
  }
}

TEST(Crossings, OverSeveralEthernetsEachCopyIsOfTheOneBefore) {
  Crossings crossings;
  for (std::uint64_t i = 0; i < 100; ++i)
    for (std::uint32_t flow = 0; flow < 3; ++flow)
      crossings.add(flow, flow, i * 10 * kMs + flow * kMs, i);
  const auto found = crossings.find(flows_on(3));
  ASSERT_EQ(found.size(), 2U);
  for (const auto& one : found) EXPECT_EQ(one.origin, one.copy - 1);
}

TEST(Crossings, EventsOfAnotherSubjectAreNoCopiesOnAnotherEthernet) {
  auto flows = flows_on(3);
  flows[1].number = 8;
  Crossings crossings;
  for (std::uint64_t i = 0; i < 100; ++i)
    for (std::uint32_t flow = 1; flow < 3; ++flow)
      crossings.add(flow, flow, i * 10 * kMs + flow * kMs, i);
  EXPECT_TRUE(crossings.find(flows).empty());
}

TEST(Crossings, OfWhatWasHeardAtDifferentTimesTheCommonPartCounts) {
  Crossings crossings;
  for (std::uint64_t i = 0; i < 200; ++i) {
    if (i < 120) crossings.add(0, 0, i * 100 * kMs, i);
    if (i >= 80) crossings.add(1, 1, i * 100 * kMs + kMs, i);
  }
  EXPECT_EQ(crossings.find(flows_on(2)).size(), 1U);
}

TEST(Crossings, OfMuchTrafficStretchesOfTimeAreEnough) {
  Crossings crossings(2000);
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    crossings.add(0, 0, i * 10 * kMs, i);
    crossings.add(1, 1, i * 10 * kMs + kMs, i);
    // A slow one beside it.
    if (i % 100 == 0) crossings.add(2, 2, i * 10 * kMs + 2 * kMs, i);
  }
  auto flows = flows_on(3);
  flows[2].number = 8;
  const auto found = crossings.find(flows);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LE(found[0].crossing.events, 2000U);
  EXPECT_GE(found[0].crossing.events, 100U);
}

// --- from one bus to another, under another identifier
// --------------------------------------------

std::vector<Crossings::Of> buses(bool rich = true, bool local = false) {
  return {{.interface = 0, .number = 0x100, .rich = rich, .origin = {}},
          {.interface = 1, .number = 0x200, .local = local, .rich = rich, .origin = {}}};
}

/// So many contents in turn, of which one copy in `lost` does not come, and one in `own` is
/// another.
Crossings copied(std::uint64_t contents, std::uint64_t lost = 0, std::uint64_t own = 0) {
  Crossings out;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    out.add(0, 0, i * 10 * kMs, i % contents);
    if (lost != 0 && i % lost == 0) continue;
    out.add(1, 1, i * 10 * kMs + kMs / 2, own != 0 && i % own == 0 ? i + 10'000 : i % contents);
  }
  return out;
}

TEST(Crossings, FromBusToBusManyContentsAreEvidence) {
  const auto found = copied(1000, 50).find(buses());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].copy, 1U);
  EXPECT_TRUE(found[0].sure);
  EXPECT_TRUE(found[0].renumbered);
  EXPECT_EQ(found[0].of, 980U);
  EXPECT_EQ(found[0].contents, 980U);
  EXPECT_EQ(found[0].percent(), 98U) << "of the origin one in 50 has no copy";
  EXPECT_EQ(copied(1000).find(buses())[0].percent(), 99U) << "nothing is certain";
}

TEST(Crossings, FromBusToBusACounterIsNone) {
  const auto found = copied(256).find(buses(false));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(found[0].sure) << "nodes that are switched on together count alike";
  EXPECT_TRUE(copied(256).find(buses(false, true))[0].sure) << "this host sends the copies";
}

TEST(Crossings, FromBusToBusFewContentsAreNotEvenNamed) {
  EXPECT_TRUE(copied(7).find(buses()).empty());
  const auto found = copied(8).find(buses());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(found[0].sure);
  auto same = buses();
  same[1].changes = false;
  EXPECT_TRUE(copied(1000).find(same).empty());
}

TEST(Crossings, FromBusToBusNoMoreAgreeThanCouldBeCompared) {
  Crossings crossings(2000);
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    crossings.add(0, 0, i * 10 * kMs, i);
    crossings.add(1, 1, i * 10 * kMs + kMs, i);
  }
  const auto found = crossings.find(buses());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_GT(found[0].of, 100U);
  EXPECT_LE(found[0].agreed(), found[0].of);
  EXPECT_EQ(found[0].percent(), 99U);
}

TEST(Crossings, FromBusToBusNearlyAllMustAgree) {
  EXPECT_TRUE(copied(1000, 9).find(buses()).empty()) << "of the origin";
  EXPECT_TRUE(copied(1000, 0, 19).find(buses()).empty()) << "of the copy";
  EXPECT_EQ(copied(1000, 20, 40).find(buses()).size(), 1U);
}

TEST(Crossings, OneInstantWithEverythingInItIsBounded) {
  Crossings crossings(10'000);
  for (std::uint64_t i = 0; i < 100'000; ++i)
    crossings.add(static_cast<std::uint32_t>(i % 2), static_cast<std::uint32_t>(i % 2), 42, 1);
  EXPECT_LE(crossings.find(flows_on(2)).size(), 1U);
}

}  // namespace
}  // namespace mlcca::learn
