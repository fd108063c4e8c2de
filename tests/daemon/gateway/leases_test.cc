// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/leases.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <vector>

namespace mlcca {
namespace {

using Ids = std::vector<std::uint64_t>;

TEST(Leases, EndAtTheirLength) {
  Leases leases;
  EXPECT_EQ(leases.next_deadline(), Leases::kUnbounded);
  leases.set(1, 100, 1000);
  EXPECT_EQ(leases.next_deadline(), 1100U);
  EXPECT_EQ(leases.expired(1099), Ids{});
  EXPECT_EQ(leases.expired(1100), Ids{1});
  EXPECT_EQ(leases.remaining(1, 1000), 100U);
  EXPECT_EQ(leases.remaining(1, 1099), 1U);
  EXPECT_EQ(leases.remaining(1, 1101), 0U);
}

TEST(Leases, AreRenewedForTheLengthThatWasSet) {
  Leases leases;
  leases.set(1, 100, 1000);
  leases.renew(1, 1090);
  EXPECT_EQ(leases.next_deadline(), 1190U);
  leases.renew(1, 5000);
  EXPECT_EQ(leases.expired(5099), Ids{}) << "also after it had ended";
  leases.set(1, 7, 5000);
  EXPECT_EQ(leases.next_deadline(), 5007U);
}

TEST(Leases, ExpireInTheOrderOfTheirEndsUntilTheyAreForgotten) {
  Leases leases;
  leases.set(1, 300, 0);
  leases.set(2, 100, 0);
  leases.set(3, 200, 0);
  EXPECT_EQ(leases.expired(250), (Ids{2, 3}));
  EXPECT_EQ(leases.expired(250), (Ids{2, 3}));
  leases.forget(2);
  EXPECT_EQ(leases.expired(300), (Ids{3, 1}));
  EXPECT_EQ(leases.next_deadline(), 200U);
}

TEST(Leases, OfNoSessionAreNone) {
  Leases leases;
  leases.renew(9, 5);
  leases.forget(9);
  EXPECT_EQ(leases.remaining(9, 5), std::nullopt);
  EXPECT_EQ(leases.next_deadline(), Leases::kUnbounded);
}

TEST(Leases, PastTheEndOfTimeNeverEnd) {
  Leases leases;
  leases.set(1, Leases::kUnbounded, 1);
  leases.set(2, Leases::kUnbounded - 10, 10);
  leases.set(3, Leases::kUnbounded - 11, 10);
  EXPECT_EQ(leases.remaining(1, 5), Leases::kUnbounded);
  EXPECT_EQ(leases.remaining(2, 5), Leases::kUnbounded);
  EXPECT_EQ(leases.next_deadline(), Leases::kUnbounded - 1);
  EXPECT_EQ(leases.expired(Leases::kUnbounded), Ids{3});
}

TEST(Leases, AgreeWithAListThatIsSearched) {
  struct Known {
    std::uint64_t length;
    std::uint64_t end;
  };
  std::mt19937 random(1);
  Leases leases;
  std::map<std::uint64_t, Known> known;
  std::uint64_t now = 0;
  for (int step = 0; step < 20'000; ++step) {
    now += random() % 5;
    const std::uint64_t id = random() % 40;
    const auto choice = random() % 4;
    if (choice == 0) {
      const std::uint64_t length = random() % 200;
      leases.set(id, length, now);
      known[id] = {length, now + length};
    } else if (choice == 1) {
      leases.renew(id, now);
      if (known.contains(id)) known[id].end = now + known[id].length;
    } else if (choice == 2) {
      leases.forget(id);
      known.erase(id);
    }
    std::uint64_t first = Leases::kUnbounded;
    Ids expired;
    for (const auto& [each, lease] : known) {
      first = std::min(first, lease.end);
      if (lease.end <= now) expired.push_back(each);
      ASSERT_EQ(leases.remaining(each, now), lease.end > now ? lease.end - now : 0);
    }
    std::ranges::stable_sort(expired, {}, [&](std::uint64_t i) { return known[i].end; });
    ASSERT_EQ(leases.next_deadline(), first);
    ASSERT_EQ(leases.expired(now), expired);
  }
}

}  // namespace
}  // namespace mlcca
