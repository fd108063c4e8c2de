// SPDX-License-Identifier: BSD-2-Clause
// Tests of gateways that reserve on one network at the same time, with a slow store.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/cluster/members.hpp"

namespace mlcca::core::cluster::test {
namespace {

constexpr Value kMilli = 1'000'000;
constexpr std::uint64_t kId = 7;

/// Each gateway reserves one byte per second of the network. Everything takes a random time of 0.5
/// to 1.5 times the latency.
class Contention {
 public:
  Contention(std::size_t gateways, std::size_t room, Value latency, std::uint64_t seed)
      : room_(room), latency_(latency), random_(seed), keys_(keys_of(gateways)) {
    store_.write(
        {{.key = keys_->current(),
          .value = codec_.write(Current{
              .generation = 1, .digest = TextCodec::digest(1), .open = true, .waits = {}})}});
    answers_.resize(gateways);
    for (std::size_t g = 0; g < gateways; ++g) {
      members_.push_back(std::make_unique<Member>(keys_, codec_,
                                                  Member::Identity{.gateway = g,
                                                                   .digest = TextCodec::digest(1),
                                                                   .session = (seed * 1000) + g,
                                                                   .lease = 10'000 * kMilli,
                                                                   .was = {}}));
      Member& member = *members_[g];
      member.on_state({.reachable = true, .endpoint = {}, .problem = {}}, now_);
      member.on_snapshot_begin(store_.revision, now_);
      member.on_batch(store_.snapshot(), now_);
      member.on_snapshot_end(now_);
      seen_.push_back(store_.log.size());
      watched_.push_back(now_);
    }
    for (std::size_t g = 0; g < gateways; ++g) turn(g);
    run(20 * latency_);
  }

  void ask_all() {
    begun_ = now_;
    for (std::size_t g = 0; g < members_.size(); ++g) {
      members_[g]->reserve(wanted(), now_);
      turn(g);
    }
    run(2 * Admissions::kPatience);
  }
  /// "granted", or the reason for the refusal, of each request.
  [[nodiscard]] const std::vector<std::string>& answers() const { return answers_; }
  [[nodiscard]] std::size_t granted() const {
    return static_cast<std::size_t>(std::ranges::count(answers_, "granted"));
  }
  /// The time until the last answer.
  [[nodiscard]] Value took() const { return ended_ - begun_; }

 private:
  static Wanted wanted() {
    return {
        .id = kId, .footprint = {.parts = {part_of(0, 1)}, .gateways = {}}, .admission = "request"};
  }
  Value some_time() {
    random_ = random_ * 6364136223846793005U + 1442695040888963407U;
    return (latency_ / 2) + ((random_ >> 33U) % latency_);
  }
  void at(Value time, std::function<void()> what) { due_.emplace(time, std::move(what)); }

  void run(Value time) {
    for (const Value end = now_ + time; now_ < end;) {
      Value next = due_.empty() ? end : std::min(end, due_.begin()->first);
      for (const auto& member : members_) next = std::min(next, member->next_time(now_));
      now_ = std::max(now_, next);
      for (std::size_t g = 0; g < members_.size(); ++g) {
        members_[g]->on_time(now_);
        turn(g);
      }
      while (!due_.empty() && due_.begin()->first <= now_) {
        const auto what = std::move(due_.begin()->second);
        due_.erase(due_.begin());
        what();
      }
    }
  }
  void turn(std::size_t g) {
    for (auto events = members_[g]->take_events(); !events.empty();
         events = members_[g]->take_events())
      for (const Event& event : events) act(g, event);
    members_[g]->applied(members_[g]->view().revision());
    for (Txn& txn : members_[g]->take_txns(now_))
      at(now_ + some_time(), [this, g, txn = std::move(txn)] { arrive(g, txn); });
  }
  void arrive(std::size_t g, const Txn& txn) {
    const TxnResult result = store_.apply(txn);
    at(now_ + some_time(), [this, g, result] {
      members_[g]->on_result(result, now_);
      turn(g);
    });
    for (std::size_t other = 0; other < members_.size(); ++other) watch(other);
  }
  /// Passes the changes of the store to a gateway, in their order.
  void watch(std::size_t g) {
    for (; seen_[g] < store_.log.size(); ++seen_[g]) {
      watched_[g] = std::max(watched_[g], now_ + some_time());
      at(watched_[g], [this, g, batch = store_.log[seen_[g]]] {
        members_[g]->on_batch(batch, now_);
        turn(g);
      });
    }
  }
  void act(std::size_t g, const Event& event) {
    if (std::holds_alternative<Reserved>(event)) {
      answer(g, "granted");
    } else if (const auto* refused = std::get_if<Refused>(&event)) {
      answer(g, refused->why.reason);
    } else if (std::holds_alternative<Conflict>(event)) {
      if (bytes_of(members_[g]->view().foreign(0).rates) < room_) {
        members_[g]->reserve(wanted(), now_);
      } else {
        answer(g, "no room");
        members_[g]->release(kId, now_);
      }
    }
  }
  void answer(std::size_t g, std::string what) {
    EXPECT_EQ(answers_[g], "") << "another answer";
    answers_[g] = std::move(what);
    ended_ = now_;
  }

  std::size_t room_;
  Value latency_;
  std::uint64_t random_;
  TextCodec codec_;
  std::shared_ptr<const Keys> keys_;
  StoreStub store_;
  std::vector<std::unique_ptr<Member>> members_;
  std::vector<std::size_t> seen_;
  std::vector<Value> watched_;
  std::vector<std::string> answers_;
  std::multimap<Value, std::function<void()>> due_;
  Value now_ = 1'000'000 * kMilli;
  Value begun_ = 0, ended_ = 0;
};

TEST(ClusterContention, OfTenThatAskAtOnceAllThatFitAreGranted) {
  for (const Value latency : {1 * kMilli, 5 * kMilli, 30 * kMilli})
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
      Contention all(10, 10, latency, seed);
      all.ask_all();
      EXPECT_EQ(all.granted(), 10U)
          << "seed " << seed << ": " << testing::PrintToString(all.answers());
      EXPECT_LT(all.took(), Admissions::kPatience) << "seed " << seed;
    }
}

TEST(ClusterContention, OfTenThatAskAtOnceNoMoreAreGrantedThanThereIsRoom) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Contention all(10, 6, 5 * kMilli, seed);
    all.ask_all();
    EXPECT_EQ(all.granted(), 6U) << "seed " << seed;
    EXPECT_EQ(std::ranges::count(all.answers(), "no room"), 4) << "seed " << seed;
  }
}

TEST(ClusterContention, EachProcessWaitsForOtherTimesAndTheSameOneForTheSame) {
  const auto took = [](std::uint64_t seed) {
    Contention all(10, 10, 5 * kMilli, seed);
    all.ask_all();
    return all.took();
  };
  EXPECT_EQ(took(1), took(1));
  EXPECT_NE(took(1), took(2));
}

class ClusterQuicker : public ClusterMember {
 protected:
  /// Lets another gateway reserve on the network before each transaction of gateway 0, until that
  /// one is answered. Returns how often.
  std::size_t be_quicker(Value step) {
    nodes[0].cut_off = true;
    std::size_t times = 0;
    while (times < 1000 && answers_.empty()) {
      while (nodes[0].seen < store.log.size()) at(0).on_batch(store.log[nodes[0].seen++], now);
      turn(nodes[0]);
      for (const Txn& txn : std::exchange(nodes[0].lost, {})) {
        const bool reserves =
            std::ranges::any_of(txn.puts, [](const Put& put) { return put.key[0] == 'r'; });
        if (reserves) {
          store.write({{.key = keys->version(0), .value = "B " + std::to_string(++times)}});
        }
        at(0).on_result(store.apply(txn), now);
      }
      while (nodes[0].seen < store.log.size()) at(0).on_batch(store.log[nodes[0].seen++], now);
      turn(nodes[0]);
      if (!nodes[0].take<Conflict>().empty()) at(0).reserve(unit(1), now);
      answers_ = nodes[0].take<Refused>();
      now += step;
      at(0).on_time(now);
    }
    return times;
  }

  std::vector<Refused> answers_;
};

TEST_F(ClusterQuicker, AfterSoManyTriesTheRefusalNamesTheLatest) {
  in_force(1);
  start(0);
  at(0).reserve(unit(1), now);
  EXPECT_EQ(be_quicker(kMilli), Admissions::kMostTries);
  ASSERT_EQ(answers_.size(), 1U);
  EXPECT_EQ(answers_[0].why.reason, "taken by B 64 meanwhile: others were quicker 64 times");
}

/// What B makes for A says so.
TEST_F(ClusterQuicker, WhatAnotherGatewayHasTakenForOneSaysForWhom) {
  in_force(1);
  start(0);
  start(1);
  Wanted wanted = unit(7, {0});
  wanted.made_for = 0;
  at(1).reserve(wanted, now);
  run();
  EXPECT_EQ(store.entries.at(keys->version(0)).value, "B 7 (for A)");
}

TEST_F(ClusterQuicker, AfterSoMuchTimeTheRefusalNamesTheLatest) {
  in_force(1);
  start(0);
  const Value begun = now;
  at(0).reserve(unit(1), now);
  const std::size_t times = be_quicker(kSecond / 4);
  EXPECT_LT(times, Admissions::kMostTries);
  EXPECT_LE(now - begun, Admissions::kPatience + kSecond);
  ASSERT_EQ(answers_.size(), 1U);
  EXPECT_EQ(answers_[0].why.reason, "taken by B " + std::to_string(times) +
                                        " meanwhile: others were quicker " + std::to_string(times) +
                                        " times");
}

TEST_F(ClusterQuicker, NobodyElseOfTheGatewayIsDecidedWhileOneWaits) {
  in_force(1);
  start(0);
  start(1);
  at(0).reserve(unit(1), now);
  at(1).reserve(unit(2), now);
  turn(nodes[0]);
  turn(nodes[1]);
  ASSERT_TRUE(nodes[1].take<Conflict>().empty()) << "it waits for a moment";
  EXPECT_EQ(at(1).why_not(now), "another admission is being decided");
  pass(kSecond / 4);
  EXPECT_EQ(nodes[1].take<Conflict>().size(), 1U);
  at(1).reserve(unit(2), now);
  run();
  EXPECT_EQ(nodes[1].take<Reserved>().size(), 1U);
  EXPECT_EQ(at(1).why_not(now), "");
}

}  // namespace
}  // namespace mlcca::core::cluster::test
