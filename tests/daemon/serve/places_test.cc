// SPDX-License-Identifier: BSD-2-Clause
// Who may have a connection, and whose is closed for it.
#include "daemon/serve/places.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace mlcca::serve {
namespace {

constexpr uid_t kNewcomer = 999;

class PlacesTest : public ::testing::Test {
 protected:
  void hold(uid_t uid, Standing standing, std::size_t connections, Use use = Use::idle) {
    for (std::size_t i = 0; i < connections; ++i, ++last_)
      held_.push_back({last_, uid, standing, use, 1000U - static_cast<std::uint64_t>(last_)});
  }
  [[nodiscard]] Admittance ask(uid_t uid, Standing standing) const {
    return place_for(uid, standing, held_);
  }
  std::vector<Held> held_;
  int last_ = 0;
};

TEST_F(PlacesTest, OneUserHasSoManyAndRootAll) {
  hold(1000, Standing::other, kMostOfOther);
  hold(2000, Standing::member, kMostOfMember);
  EXPECT_EQ(ask(1000, Standing::other).refused,
            "you hold 32 connections, and one user may hold 32");
  EXPECT_FALSE(ask(2000, Standing::member).refused.empty());
  EXPECT_TRUE(ask(1001, Standing::other).refused.empty());
  held_.clear();
  hold(0, Standing::root, kMostPlaces - 1);
  EXPECT_TRUE(ask(0, Standing::root).refused.empty());
  hold(0, Standing::root, 1);
  EXPECT_FALSE(ask(0, Standing::root).refused.empty());
}

TEST_F(PlacesTest, RootAndTheGroupFindAPlaceWhateverOthersHold) {
  std::size_t taken = 0;
  for (uid_t uid = 1000; ask(uid, Standing::other).refused.empty(); ++uid, ++taken)
    hold(uid, Standing::other, 1, Use::owns);
  EXPECT_EQ(taken, kMostPlaces - kPlacesOfRoot - kPlacesOfMembers);
  for (uid_t uid = 2000; ask(uid, Standing::member).refused.empty(); ++uid, ++taken)
    hold(uid, Standing::member, 1, Use::owns);
  EXPECT_EQ(taken, kMostPlaces - kPlacesOfRoot);
  for (; ask(0, Standing::root).refused.empty(); ++taken) hold(0, Standing::root, 1, Use::owns);
  EXPECT_EQ(taken, kMostPlaces);
}

TEST_F(PlacesTest, OthersFindAPlaceWhateverMembersHold) {
  std::size_t taken = 0;
  for (uid_t uid = 2000; ask(uid, Standing::member).refused.empty(); ++uid, ++taken)
    hold(uid, Standing::member, 1, Use::owns);
  EXPECT_EQ(taken, kMostPlaces - kPlacesOfRoot - kPlacesOfOthers);
  EXPECT_TRUE(ask(1000, Standing::other).refused.empty());
}

TEST_F(PlacesTest, WhoHoldsMostGivesWayByWhatHasBeenIdleLongest) {
  hold(1000, Standing::other, 31);
  hold(1001, Standing::other, 32);
  for (uid_t uid = 1002; uid < 1007; ++uid) hold(uid, Standing::other, 29);
  const Admittance place = ask(kNewcomer, Standing::other);
  ASSERT_TRUE(place.closes);
  EXPECT_EQ(place.closes->uid, 1001U);
  EXPECT_EQ(place.closes->id, 62) << "the last one of his has the smallest time";
  EXPECT_EQ(place.of_its_user, 32U);
}

TEST_F(PlacesTest, WhatIsIdleGoesFirstAndWhatOwnsAnAdmissionNever) {
  hold(2000, Standing::member, 125, Use::owns);
  hold(2000, Standing::member, 1, Use::asks);
  hold(2000, Standing::member, 1, Use::listens);
  hold(2000, Standing::member, 1, Use::idle);
  hold(2001, Standing::member, 80, Use::owns);
  for (const Use use : {Use::idle, Use::listens, Use::asks}) {
    const Admittance place = ask(kNewcomer, Standing::member);
    ASSERT_TRUE(place.closes);
    EXPECT_EQ(place.closes->use, use);
    std::erase_if(held_, [&](const Held& h) { return h.id == place.closes->id; });
    hold(kNewcomer, Standing::member, 1, Use::owns);
  }
  EXPECT_FALSE(ask(kNewcomer + 1, Standing::member).refused.empty());
}

TEST_F(PlacesTest, NoUserLosesAPlaceToOneThatHasAsMany) {
  for (uid_t uid = 1000; uid < 1104; ++uid) hold(uid, Standing::other, 2);
  EXPECT_TRUE(ask(kNewcomer, Standing::other).closes);
  EXPECT_FALSE(ask(1000, Standing::other).refused.empty());
  hold(kNewcomer, Standing::other, 1);
  EXPECT_FALSE(ask(kNewcomer, Standing::other).refused.empty()) << "it would only change sides";
}

TEST_F(PlacesTest, PlacesOfOthersAreOfNoUseToWhoMayNotHaveThem) {
  hold(0, Standing::root, 40);
  hold(2000, Standing::member, 8);
  for (uid_t uid = 1000; uid < 1013; ++uid) hold(uid, Standing::other, 16);
  const Admittance place = ask(kNewcomer, Standing::other);
  ASSERT_TRUE(place.closes);
  EXPECT_EQ(place.closes->standing, Standing::other);
}

}  // namespace
}  // namespace mlcca::serve
