// SPDX-License-Identifier: BSD-2-Clause
// Gateways that announce themselves over SUBSCRIB: the message, and when what is sent and passed
// on.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "relay/famouso/announcer.hpp"
#include "tests/relay/bytes.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint64_t kHalfASecond = 500'000'000;
const std::string kHead = "53554253435249420105";

TEST(AnnouncementTest, IsAsTheReferenceSays) {
  const Announcement main{.gateway = "main", .lasts_ns = 2'500'000'000, .forwards = true};
  EXPECT_EQ(hex(encode(main)), kHead + "000000009502f900" + "01" + "046d61696e");
  EXPECT_EQ(parse_announcement(encode(main)), main);
  const Announcement back{.gateway = "b",
                          .lasts_ns = ~std::uint64_t{0},
                          .forwards = false,
                          .not_received = {"a", "c.d_e-f"}};
  EXPECT_EQ(hex(encode(back)),
            kHead + "ffffffffffffffff" + "00" + "0162" + "0161" + "07632e645f652d66");
  EXPECT_EQ(parse_announcement(encode(back)), back);
}

TEST(AnnouncementTest, NamesThatDoNotFitAreLeftOut) {
  Announcement many{.gateway = std::string(63, 'a'), .lasts_ns = 1, .forwards = true};
  for (const char name : {'b', 'c', 'd', 'e'}) many.not_received.emplace_back(63, name);
  const auto event = encode(many);
  EXPECT_LE(event.size(), kLongestSubscription);
  many.not_received.resize(2);
  EXPECT_EQ(parse_announcement(event), many);
}

TEST(AnnouncementTest, WhatIsNotOneIsNone) {
  const std::string lasts = "0000000000000001";
  const std::string good = kHead + lasts + "01" + "0161";
  ASSERT_TRUE(parse_announcement(bytes(good)));
  for (const std::string& bad :
       {std::string(), kHead, kHead + lasts, kHead + lasts + "01", kHead + lasts + "02" + "0161",
        kHead + lasts + "01" + "00", kHead + lasts + "01" + "0261", kHead + lasts + "01" + "0120",
        kHead + lasts + "01" + "0161" + "02",
        std::string("5355425343524942") + "0205" + lasts + "010161",
        std::string("5355425343524942") + "0104" + lasts + "010161",
        std::string("4469737461") + "6e6365" + "0105" + lasts + "010161"})
    EXPECT_FALSE(parse_announcement(bytes(bad))) << bad;
  // Subscriptions know nothing of it.
  EXPECT_FALSE(parse_subscription(bytes(good)));
}

class AnnouncerTest : public ::testing::Test {
 protected:
  /// The daemon answers the latest question.
  void answer(control::Presence own) {
    control::Reply reply;
    reply.body = std::move(own);
    EXPECT_TRUE(announcer_.answered(number_, reply, now_));
  }
  static control::Presence own() {
    control::Presence out;
    out.gateway = "a";
    out.interval_ns = kHalfASecond;
    out.lasts_ns = 3'500'000'000;
    out.forwards = true;
    out.others = {"b"};
    out.networks = {"bus", "lan"};
    return out;
  }
  bool receive(const std::string& network, const Announcement& message) {
    return announcer_.receive(network, encode(message), now_);
  }

  std::uint64_t now_ = 1'000'000'000;
  std::uint64_t number_ = 0;
  bool there_ = true;
  std::vector<control::PresenceRequest> asked_;
  std::vector<std::pair<std::string, std::string>> sent_;  ///< network, octets
  Announcer announcer_{{.send = [this](const std::string& network,
                                       Octets event) { sent_.emplace_back(network, hex(event)); },
                        .ask =
                            [this](control::PresenceRequest request) {
                              if (!there_) return std::uint64_t{0};
                              asked_.push_back(std::move(request));
                              return ++number_;
                            }}};
};

TEST_F(AnnouncerTest, AsksOnceInAnIntervalAndSendsWhatIsAnswered) {
  announcer_.turn(now_);
  ASSERT_EQ(asked_.size(), 1U);
  EXPECT_EQ(asked_[0], control::PresenceRequest{});
  answer(own());
  const std::string event =
      hex(encode(Announcement{.gateway = "a", .lasts_ns = 3'500'000'000, .forwards = true}));
  EXPECT_EQ(sent_, (decltype(sent_){{"bus", event}, {"lan", event}}));
  EXPECT_EQ(announcer_.due_at(), now_ + kHalfASecond);
  now_ += kHalfASecond - 1;
  announcer_.turn(now_);
  EXPECT_EQ(asked_.size(), 1U);
  now_ += 1;
  announcer_.turn(now_);
  EXPECT_EQ(asked_.size(), 2U);
  // While that is not answered nothing is sent, and nothing more asked.
  now_ += 10 * kHalfASecond;
  announcer_.turn(now_);
  EXPECT_EQ(asked_.size(), 2U);
  EXPECT_EQ(sent_.size(), 2U);
}

TEST_F(AnnouncerTest, AGatewayWithoutPresenceIsAskedAgainLater) {
  announcer_.turn(now_);
  answer({});
  EXPECT_TRUE(sent_.empty());
  EXPECT_EQ(announcer_.due_at(), now_ + Announcer::kAskAgain);
  announcer_.ask_now();
  announcer_.turn(now_);
  EXPECT_EQ(asked_.size(), 2U);
}

TEST_F(AnnouncerTest, TellsTheDaemonWhatOthersAnnounceAndNothingElse) {
  announcer_.turn(now_);
  answer(own());
  asked_.clear();
  const Announcement b{.gateway = "b", .lasts_ns = 7, .forwards = false, .not_received = {"a"}};
  EXPECT_TRUE(receive("lan", b));
  ASSERT_EQ(asked_.size(), 1U);
  EXPECT_EQ(asked_[0], (control::PresenceRequest{.network = "lan",
                                                 .gateway = "b",
                                                 .lasts_ns = 7,
                                                 .forwards = false,
                                                 .not_received = {"a"}}));
  EXPECT_TRUE(receive("lan", b)) << "it is one, and comes too soon";
  EXPECT_TRUE(receive("elsewhere", b));
  EXPECT_TRUE(receive("lan", {.gateway = "z", .lasts_ns = 7, .forwards = true}));
  EXPECT_EQ(asked_.size(), 1U);
  EXPECT_TRUE(receive("bus", b));
  now_ += Announcer::kPause;
  EXPECT_TRUE(receive("lan", b));
  EXPECT_EQ(asked_.size(), 3U);
  EXPECT_FALSE(announcer_.receive("lan", bytes("44697374616e6365"), now_));
}

TEST_F(AnnouncerTest, WithoutADaemonNothingIsAnnounced) {
  announcer_.turn(now_);
  answer(own());
  sent_.clear();
  there_ = false;
  announcer_.daemon_gone();
  now_ += kHalfASecond;
  announcer_.turn(now_);
  EXPECT_TRUE(sent_.empty());
  EXPECT_TRUE(receive("lan", {.gateway = "b", .lasts_ns = 7, .forwards = true}));
  there_ = true;
  announcer_.ask_now();
  announcer_.turn(now_);
  answer(own());
  EXPECT_EQ(sent_.size(), 2U);
}

}  // namespace
}  // namespace mlcca::relay
