// SPDX-License-Identifier: BSD-2-Clause
// Entries that are not understood are named, with the reason and what to do.
#include "core/cluster/strange.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "core/cluster/lease.hpp"
#include "tests/core/cluster/codec.hpp"
#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {
namespace {

class StrangeEntries : public testing::Test {
 protected:
  void put(const std::string& key, const std::string& value) {
    records.put(*keys, codec, {.key = key, .value = value, .create = 1, .mod = ++revision});
  }
  std::string readable() {
    return codec.write(Taken{.channel = {}, .publisher = {}, .part = part_of(0, 5), .through = {}});
  }
  /// What all keys of reservations of a gateway begin with.
  std::string folder(std::size_t gateway = 1) {
    const std::string key = keys->reservation(0, gateway, 7);
    return key.substr(0, key.size() - 1);
  }
  std::string words(std::size_t network = 0) { return unreadable_words(records, *keys, network); }
  std::string of_no_network() { return unreadable_words(records, *keys); }

  TextCodec codec;
  std::shared_ptr<const Keys> keys = keys_of(3);
  Records records{keys->gateways(), keys->networks()};
  std::int64_t revision = 0;
};

TEST_F(StrangeEntries, NothingIsSaidWhereAllCanBeRead) {
  put(keys->reservation(0, 1, 7), readable());
  EXPECT_EQ(words(), "");
  EXPECT_EQ(of_no_network(), "");
  EXPECT_EQ(too_many_words(records, *keys), "");
}

TEST_F(StrangeEntries, AReservationIsNamedWithItsGateway) {
  const std::string key = keys->reservation(0, 1, 7);
  put(key, "?");
  const std::string restart = ": restart mlccad on " + keys->gateway_name(1) +
                              ", which replaces or deletes it; if that gateway is off, the others "
                              "do so when its lease has ended";
  EXPECT_EQ(words(), key + " of gateway " + keys->gateway_name(1) +
                         " (it is damaged, or of another version)" + restart);
  EXPECT_EQ(words(1), "") << "the other network is not concerned";
  put(keys->reservation(0, 1, 8), std::string(kMostEntryBytes + 1, '7'));
  EXPECT_TRUE(words().contains(") and 1 more entry: restart")) << words();
  put(key, readable());
  EXPECT_EQ(words(), keys->reservation(0, 1, 8) + " of gateway " + keys->gateway_name(1) +
                         " (it has 65537 octets, and may have 65536)" + restart);
}

TEST_F(StrangeEntries, AReservationUnderAnotherDescriptionIsNotCalledDamaged) {
  const std::string key = keys->reservation(0, 1, 7);
  put(key, "of another");
  const std::string gateway = keys->gateway_name(1);
  EXPECT_EQ(words(), key + " of gateway " + gateway +
                         " (it belongs to another description): " + gateway +
                         " gives it back when it has the description in force; 'mlccactl cluster "
                         "members' shows which one each gateway has");
  EXPECT_TRUE(records.unreadable(0)) << "it is unknown what it holds";
  put(key, readable());
  EXPECT_EQ(words(), "");
}

TEST_F(StrangeEntries, WhatNobodyReplacesIsDeletedByACommand) {
  put(folder() + "x", "?");
  EXPECT_EQ(words(), folder() + "x of gateway " + keys->gateway_name(1) +
                         " (the description has nothing of that name): delete it as root of etcd: "
                         "etcdctl del " +
                         folder() + "x");
}

TEST_F(StrangeEntries, AKeyFromOutsideIsEscapedAndBounded) {
  put(folder() + "\x1b[2J' ;\xff", "?");
  EXPECT_TRUE(words().ends_with("etcdctl del $'" + folder() + "\\x1b[2J\\x27\\x20;\\xff'"))
      << words();
  records = Records(keys->gateways(), keys->networks());
  put(folder() + std::string(100'000, '\1'), "?");
  EXPECT_LT(words().size(), 2'000U);
  EXPECT_TRUE(words().contains("...")) << words();
  EXPECT_FALSE(words().contains("etcdctl del")) << "a part of a key is another key";
}

TEST_F(StrangeEntries, OneOfARemovedGatewayIsLeftToThoseWhoKnowWhenItIsDead) {
  const std::string own = keys->reservation(0, 1, 7);
  const std::string name = encoded(keys->gateway_name(1));
  std::string key = own;
  key.replace(key.find("/" + name + "/") + 1, name.size(), "gone");
  put(key, readable());
  EXPECT_EQ(words(),
            key +
                " of gone, which is not in the description (the description has nothing of "
                "that name): 'mlccactl cluster members' says how to delete it, and when");
}

TEST_F(StrangeEntries, ABeatWithALeaseThatIsTooLongIsNamed) {
  Beat beat;
  beat.lease = 2 * kMostLease;
  put(keys->member(2), codec.write(beat));
  EXPECT_EQ(of_no_network(),
            keys->member(2) + " of gateway " + keys->gateway_name(2) +
                " (it states a lease of 2 h, and 1 h is the longest: " + keys->gateway_name(2) +
                " counts as sending for so long): restart mlccad on " + keys->gateway_name(2) +
                " with a --lease of 2 s to 1 h");
  beat.lease = kLeastLease - 1;
  put(keys->member(2), codec.write(beat));
  EXPECT_TRUE(of_no_network().contains("2 s is the shortest")) << of_no_network();
  beat.lease = kMostLease;
  put(keys->member(2), codec.write(beat));
  EXPECT_EQ(of_no_network(), "");
  put("foreign/key", "?");
  EXPECT_EQ(of_no_network(), "") << "nobody needs it";
}

TEST_F(StrangeEntries, HoweverManyRequestsAndVotesThereAreTheyAreBounded) {
  const std::string vote =
      codec.write(VoteOf{.asked = 1, .vote = {.ok = true, .hop = {}, .reason = {}}});
  const std::string asked =
      codec.write(RouteRequest{.stage = Stage::granted, .admission = {}, .gateways = {}});
  for (std::uint64_t id = 0; id <= kMostReservations; ++id) {
    put(keys->vote(1, 2, id), vote);
    put(keys->asked(1, id), asked);
  }
  EXPECT_EQ(records.votes.size(), kMostReservations);
  EXPECT_EQ(records.asked.size(), kMostReservations);
  const std::string no =
      codec.write(VoteOf{.asked = 2, .vote = {.ok = false, .hop = {}, .reason = {}}});
  put(keys->vote(1, 2, 0), no);
  EXPECT_FALSE(records.votes.at({1, 2, 0}).value->vote.ok) << "one that is known can change";
  put(keys->asked(1, 0),
      codec.write(RouteRequest{.stage = Stage::ending, .admission = {}, .gateways = {}}));
  ASSERT_TRUE(records.asked.contains({1, 0}));
  EXPECT_EQ(records.asked.at({1, 0}).asked.stage, Stage::ending);
}

/// Of these, nothing of a gateway is lost because another one writes too many.
class OneWritesTooMany : public StrangeEntries {
 protected:
  static constexpr std::uint64_t kOthers = 50;
  std::string vote() {
    return codec.write(VoteOf{.asked = 1, .vote = {.ok = true, .hop = {}, .reason = {}}});
  }
  std::string asked() {
    return codec.write(RouteRequest{.stage = Stage::granted, .admission = {}, .gateways = {}});
  }
  void flood() {
    for (std::uint64_t id = 0; id <= kMostReservations; ++id) {
      put(keys->vote(1, 2, id), vote());
      put(keys->asked(1, id), asked());
    }
  }
  void some_of(std::size_t gateway) {
    for (std::uint64_t id = 0; id < kOthers; ++id) {
      put(keys->vote(gateway, 1, id), vote());
      put(keys->asked(gateway, id), asked());
    }
  }
  void expect_some_of(std::size_t gateway) const {
    for (std::uint64_t id = 0; id < kOthers; ++id) {
      EXPECT_TRUE(records.votes.contains({gateway, 1, id})) << id;
      EXPECT_TRUE(records.asked.contains({gateway, id})) << id;
    }
    EXPECT_EQ(records.votes.size(), kMostReservations);
    EXPECT_EQ(records.asked.size(), kMostReservations);
  }
};

TEST_F(OneWritesTooMany, WhatOthersHaveWrittenBeforeStays) {
  some_of(0);
  some_of(2);
  flood();
  expect_some_of(0);
  expect_some_of(2);
}

TEST_F(OneWritesTooMany, WhatOthersWriteThenHasRoom) {
  flood();
  some_of(0);
  some_of(2);
  expect_some_of(0);
  expect_some_of(2);
  EXPECT_FALSE(records.votes.contains({1, 2, kMostReservations - 1})) << "the last ones make room";
  EXPECT_TRUE(records.votes.contains({1, 2, 0}));
}

TEST_F(OneWritesTooMany, WhatIsDeletedMakesRoomForTheSameGateway) {
  flood();
  const auto drop = [this](const std::string& key) {
    records.put(*keys, codec, {.key = key, .value = {}, .mod = ++revision, .gone = true});
  };
  drop(keys->vote(1, 2, 5));
  drop(keys->asked(1, 5));
  put(keys->vote(1, 2, kMostReservations), vote());
  put(keys->asked(1, kMostReservations), asked());
  EXPECT_TRUE(records.votes.contains({1, 2, kMostReservations}));
  EXPECT_TRUE(records.asked.contains({1, kMostReservations}));
}

TEST_F(StrangeEntries, WhoHasTheMostOfTooManyIsNamed) {
  put(keys->reservation(0, 1, 7), "?");
  for (std::size_t i = 0; i < kMostStrange; ++i) put(folder(2) + "x" + std::to_string(i), "?");
  EXPECT_TRUE(records.unreadable(1));
  const std::string text = words(1);
  EXPECT_TRUE(text.starts_with("more than 4096 entries that cannot be read, 4095 of them of " +
                               keys->gateway_name(2)))
      << text;
  EXPECT_TRUE(text.ends_with("then 'systemctl restart mlcca-cluster' here reads everything again"))
      << text;
}

}  // namespace
}  // namespace mlcca::core::cluster::test
