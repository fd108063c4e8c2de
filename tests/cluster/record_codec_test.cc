// SPDX-License-Identifier: BSD-2-Clause
// Records of the store: what is written is read, and what is not of this description is not.
#include "daemon/cluster/record_codec.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

core::System described_pair() {
  core::System system;
  system.name = "pair";
  for (const char* name : {"can0", "mesh"}) {
    core::Network network;
    network.name = name;
    system.networks.push_back(network);
  }
  system.networks[1].mesh.emplace().nodes.resize(3);
  for (const char* name : {"gw1", "gw/2"}) {
    core::Gateway gateway;
    gateway.name = name;
    gateway.ports.emplace_back().network = 0;
    system.gateways.push_back(gateway);
  }
  system.publishers.resize(4);
  return system;
}
cc::Digest some_digest(std::uint8_t number) {
  cc::Digest digest{};
  digest.fill(number);
  return digest;
}

cc::Taken some_taken() {
  const cc::Source described{.publisher = 3, .admission = 0, .from = 2};
  const cc::Source admitted{.publisher = 0, .admission = 77};
  cc::Taken taken{.channel = "c", .publisher = "p", .part = {}, .through = {0, 1}};
  taken.part.rates = {{.bytes_per_second = 100, .source = described},
                      {.bytes_per_second = 5, .source = admitted}};
  cc::BusPart bus{.message = {.priority = 9,
                              .lowest_priority = 12,
                              .frames = 2,
                              .back_to_back = true,
                              .transmission = 500'000,
                              .longest_frame = 300'000,
                              .last_frame = 200'000,
                              .period = 1'000'000,
                              .deadline = 2'000'000,
                              .jitter = 1000,
                              .queue = 1},
                  .first_id = 9,
                  .last_id = 12,
                  .extended = true,
                  .subject = 1ULL << 60U,
                  .source = admitted};
  taken.part.bus = {bus};
  bus.message.queue = core::can::kOwnQueue;
  bus.message.sender = 0;
  taken.part.bus.push_back(bus);
  return taken;
}

class CodecTest : public testing::Test {
 protected:
  core::System system = described_pair();
  cluster::RecordCodec codec{system, some_digest(7)};
};

TEST_F(CodecTest, ABeatIsReadAsItWasWritten) {
  const cc::Beat beat{.incarnation = 12,
                      .session = ~0ULL,
                      .seq = 3,
                      .digest = some_digest(1),
                      .generation = 4,
                      .applied = 99,
                      .role = cc::Role::active,
                      .draining = true,
                      .lease = 10'000'000'000};
  const auto read = codec.beat(codec.write(beat));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->incarnation, 12);
  EXPECT_EQ(read->session, ~0ULL);
  EXPECT_EQ(read->seq, 3U);
  EXPECT_EQ(read->digest, beat.digest);
  EXPECT_EQ(read->generation, 4U);
  EXPECT_EQ(read->applied, 99);
  EXPECT_EQ(read->role, cc::Role::active);
  EXPECT_TRUE(read->draining);
  EXPECT_EQ(read->lease, beat.lease);
}

TEST_F(CodecTest, WhatIsTakenIsReadAsItWasWritten) {
  const cc::Taken taken = some_taken();
  const auto read = codec.taken(codec.write(taken), 0);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->part, taken.part);
  EXPECT_EQ(read->through, taken.through);
  EXPECT_EQ(read->channel, "c");
}

TEST_F(CodecTest, PathsAreOfNodesOfTheMesh) {
  cc::Taken taken{.channel = "c", .publisher = {}, .part = {}, .through = {}};
  taken.part.network = 1;
  taken.part.paths = {{.from = 0, .to = 2, .bytes_per_second = 9, .event_bytes = 8, .source = {}}};
  const auto read = codec.taken(codec.write(taken), 1);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->part, taken.part);
  taken.part.paths[0].to = 3;
  EXPECT_FALSE(codec.taken(codec.write(taken), 1));
}

TEST_F(CodecTest, NumbersOfAnotherDescriptionMeanNothingHere) {
  const cluster::RecordCodec other(system, some_digest(8));
  EXPECT_FALSE(other.taken(codec.write(some_taken()), 0));
  EXPECT_TRUE(other.of_other_description(codec.write(some_taken())));
  EXPECT_FALSE(codec.of_other_description(codec.write(some_taken())));
  EXPECT_FALSE(codec.of_other_description("?"));
  cc::Taken taken = some_taken();
  taken.part.rates[0].source.publisher = 4;
  EXPECT_FALSE(codec.taken(codec.write(taken), 0));
  taken = some_taken();
  taken.part.bus[0].message.queue = 2;
  EXPECT_FALSE(codec.taken(codec.write(taken), 0));
  taken = some_taken();
  taken.part.bus[0].message.period = 0;
  EXPECT_FALSE(codec.taken(codec.write(taken), 0));
}

TEST_F(CodecTest, AVoteThatIsAboutNoSingleHopNamesNone) {
  const auto vote = codec.vote(
      codec.write(cc::VoteOf{.asked = 5, .vote = {.ok = false, .hop = {}, .reason = "no way"}}));
  ASSERT_TRUE(vote);
  EXPECT_FALSE(vote->vote.hop);
  EXPECT_FALSE(vote->vote.gateway);
}

TEST_F(CodecTest, AnAgreementNamesNobodyWhoRefuses) {
  const auto vote =
      codec.vote(codec.write(cc::VoteOf{.asked = 5,
                                        .vote = {.ok = true,
                                                 .hop = core::Place{core::Place::Kind::network, 1},
                                                 .reason = {},
                                                 .gateway = 1}}));
  ASSERT_TRUE(vote);
  EXPECT_FALSE(vote->vote.hop);
  EXPECT_FALSE(vote->vote.gateway);
}

TEST_F(CodecTest, TheOthersAreReadAsTheyWereWritten) {
  const auto asked = codec.asked(codec.write(
      cc::RouteRequest{.stage = cc::Stage::ending, .admission = "text", .gateways = {1}}));
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->stage, cc::Stage::ending);
  EXPECT_EQ(asked->admission, "text");
  EXPECT_EQ(asked->gateways, std::vector<std::size_t>{1});
  const auto vote =
      codec.vote(codec.write(cc::VoteOf{.asked = 5,
                                        .vote = {.ok = false,
                                                 .hop = core::Place{core::Place::Kind::network, 1},
                                                 .reason = "no\nway",
                                                 .gateway = 1}}));
  ASSERT_TRUE(vote);
  EXPECT_EQ(vote->asked, 5);
  EXPECT_EQ(vote->vote.hop, (core::Place{core::Place::Kind::network, 1}));
  EXPECT_EQ(vote->vote.gateway, 1U);
  EXPECT_EQ(vote->vote.reason, "no?way");
  const auto current = codec.current(codec.write(cc::Current{
      .generation = 2, .digest = some_digest(1), .former = {}, .open = true, .waits = {"gw1"}}));
  ASSERT_TRUE(current);
  EXPECT_TRUE(current->open);
  EXPECT_EQ(current->digest, some_digest(1));
  EXPECT_EQ(current->former, cc::Digest{});
  EXPECT_EQ(current->waits, std::vector<std::string>{"gw1"});
  const auto next = codec.next(codec.write(cc::Next{.generation = 3,
                                                    .digest = some_digest(2),
                                                    .chunks = 7,
                                                    .by = "gw/2",
                                                    .without = {"gw1"},
                                                    .patience = 60,
                                                    .force = true}));
  ASSERT_TRUE(next);
  EXPECT_EQ(next->chunks, 7U);
  EXPECT_EQ(next->by, "gw/2");
  EXPECT_EQ(next->patience, 60U);
  EXPECT_TRUE(next->force);
  const auto judged =
      codec.rollout_vote(codec.write(cc::RolloutVote{.next = 4, .ok = true, .reason = {}}));
  ASSERT_TRUE(judged);
  EXPECT_EQ(judged->next, 4);
  EXPECT_TRUE(judged->ok);
  EXPECT_TRUE(codec.epoch(std::string(16, 'e')));
  EXPECT_FALSE(codec.epoch("short"));
}

/// Bytes of a reason are bounded, and a character of it is there or is not.
TEST_F(CodecTest, NoCharacterOfAReasonIsCut) {
  const std::string reason = std::string(511, 'a') + "\u00e9 and more";
  const auto judged =
      codec.rollout_vote(codec.write(cc::RolloutVote{.next = 4, .ok = false, .reason = reason}));
  ASSERT_TRUE(judged);
  EXPECT_EQ(judged->reason, std::string(511, 'a'));
  const auto vote = codec.vote(
      codec.write(cc::VoteOf{.asked = 1, .vote = {.ok = false, .hop = {}, .reason = reason}}));
  ASSERT_TRUE(vote);
  EXPECT_EQ(vote->vote.reason, std::string(511, 'a'));
}

TEST_F(CodecTest, WhatIsAskedForIsAdmissionsAlone) {
  control::Admit admit;
  admit.channel = "c";
  admit.key = "k";
  const cluster::StoredRequest asked{.channel = "c", .requests = {{.id = 7, .body = admit}}};
  const auto read = cluster::asked_in(cluster::text_of(asked));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->channel, "c");
  EXPECT_EQ(read->requests, asked.requests);
  EXPECT_FALSE(read->on_behalf);
  cluster::StoredRequest behalf = asked;
  behalf.on_behalf = true;
  behalf.for_gateway = "g1";
  behalf.for_number = 9;
  const auto again = cluster::asked_in(cluster::text_of(behalf));
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->on_behalf);
  EXPECT_EQ(again->for_gateway, "g1");
  EXPECT_EQ(again->for_number, 9U);
  const cluster::StoredRequest other{.channel = "c",
                                     .requests = {{.id = 7, .body = control::StatusRequest{}}}};
  EXPECT_FALSE(cluster::asked_in(cluster::text_of(other)));
  EXPECT_FALSE(cluster::asked_in("\xff"));
}

TEST_F(CodecTest, WhateverIsThereIsReadOrNot) {
  std::mt19937 random(17);
  const std::string good = codec.write(some_taken());
  for (int n = 0; n < 20'000; ++n) {
    std::string bad = good;
    for (int k = 0; k < 3; ++k) bad[random() % bad.size()] = static_cast<char>(random());
    bad.resize(random() % (bad.size() + 1));
    static_cast<void>(codec.taken(bad, random() % 2));
    static_cast<void>(codec.asked(bad));
    static_cast<void>(codec.beat(bad));
    static_cast<void>(codec.vote(bad));
    static_cast<void>(codec.current(bad));
    static_cast<void>(codec.next(bad));
    static_cast<void>(cluster::asked_in(bad));
  }
}

}  // namespace
}  // namespace mlcca::test
