// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/members.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace mlcca::core {
namespace {

/// An admission id that counts how often two of its kind are compared.
struct Counted {
  AdmissionId id = 0;
  friend bool operator==(const Counted& a, const Counted& b) {
    ++compared;
    return a.id == b.id;
  }
  static inline std::size_t compared = 0;
};

std::vector<AdmissionId> ids_of(AdmissionId publisher, const std::vector<AdmissionId>& others) {
  std::vector<std::size_t> subscribers(others.size());
  std::iota(subscribers.begin(), subscribers.end(), std::size_t{0});
  return each_once(publisher, std::span<const std::size_t>(subscribers),
                   [&](std::size_t s) { return others[s]; });
}

TEST(MembersTest, TheAdmissionsOfADeliveryAreReportedOnceAndDescribedEndsNot) {
  EXPECT_EQ(ids_of(0, {0, 7, 8}), (std::vector<AdmissionId>{7, 8}));
  EXPECT_EQ(ids_of(7, {0, 7, 8}), (std::vector<AdmissionId>{7, 8}));
  EXPECT_EQ(ids_of(9, {}), (std::vector<AdmissionId>{9}));
  EXPECT_TRUE(ids_of(0, {0, 0}).empty());
}

TEST(MembersTest, ToCollectAdmissionsIsLinearInTheirNumber) {
  for (const std::size_t many : {100UL, 1'000UL, 10'000UL}) {
    std::vector<std::size_t> subscribers(many);
    std::iota(subscribers.begin(), subscribers.end(), std::size_t{1});
    Counted::compared = 0;
    const auto ids = each_once(Counted{many + 1}, std::span<const std::size_t>(subscribers),
                               [](std::size_t s) { return Counted{s}; });
    EXPECT_EQ(ids.size(), many + 1);
    EXPECT_LE(Counted::compared, 2 * many + 1);
  }
}

TEST(MembersTest, PairsThatAdmissionsAddAreCountedWhicheverGoesFirst) {
  const auto publisher = [](std::size_t channel) {
    Publisher p;
    p.channel = channel;
    return p;
  };
  const auto subscriber = [](std::size_t channel) {
    Subscriber s;
    s.channel = channel;
    return s;
  };
  System system;
  system.channels.resize(2);
  system.publishers = {publisher(0)};
  system.subscribers = {subscriber(0), subscriber(0), subscriber(1)};
  Members members(system);
  EXPECT_EQ(members.admitted_pairs(), 0U);
  members.add(publisher(0), 1);
  EXPECT_EQ(members.admitted_pairs(), 2U);
  members.add(subscriber(0), 2);
  EXPECT_EQ(members.admitted_pairs(), 4U) << "2 publishers and 3 subscribers instead of 1 and 2";
  members.add(publisher(1), 3);
  members.add(subscriber(1), 3);
  EXPECT_EQ(members.admitted_pairs(), 6U);
  members.remove(1);
  EXPECT_EQ(members.admitted_pairs(), 3U);
  members.remove(3);
  members.remove(2);
  EXPECT_EQ(members.admitted_pairs(), 0U);
}

}  // namespace
}  // namespace mlcca::core
