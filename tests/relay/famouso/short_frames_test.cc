// SPDX-License-Identifier: BSD-2-Clause
// Subscriptions where a message has to fit a frame of IEEE 802.15.4.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "relay/famouso/announcement.hpp"
#include "relay/famouso/subscriptions.hpp"
#include "tests/relay/famouso/subscriptions_scene.hpp"

namespace mlcca::relay {
namespace {

constexpr std::size_t kFrame = 102;

class ShortFramesTest : public SubscriptionsTest {
 protected:
  ShortFramesTest() {
    for (auto& network : said_.networks) {
      network.endpoint.wpan = true;
      network.endpoint.frame_bytes = kFrame;
    }
    subscriptions_.set(said_, 0);
  }
  /// Of every attribute, all as large as a number may be or all small.
  void pass_on(bool large) {
    said_.onward.clear();
    control::OnwardSubscription one;
    one.subject = kDistance;
    one.channel = "distance";
    one.network = "lan";
    one.begins_here = true;
    for (std::size_t i = 0; i < kAttributes; ++i)
      one.required.push_back({.name = std::string(info(attribute_at(i)).name),
                              .value = large ? ~Value{0} >> 1U : Value{1'000'000},
                              .unit = {},
                              .dynamic = false});
    said_.onward.push_back(one);
    subscriptions_.set(said_, 0);
  }
};

TEST_F(ShortFramesTest, WhatFitsAFrameIsPassedOn) {
  pass_on(false);
  EXPECT_EQ(sent_on_lan(), 77U);
  EXPECT_TRUE(reports_.empty());
}

TEST_F(ShortFramesTest, WhatDoesNotFitIsRefusedHere) {
  pass_on(true);
  EXPECT_TRUE(take_sent().empty());
  ASSERT_EQ(reports_.size(), 1U);
  EXPECT_EQ(reports_[0].network, "lan");
  EXPECT_EQ(reports_[0].source, "this gateway");
  EXPECT_EQ(reports_[0].reason, "what is required takes 117 octets, and a frame has 102");
  pass_on(false);
  EXPECT_EQ(sent_on_lan(), 78U) << "it may be less later";
}

TEST_F(ShortFramesTest, AReasonIsCutOff) {
  come("0xbeef:0x0002", wanted(5));
  answer(refused(std::string(200, 'x')));
  const auto sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(encode(sent[0].message).size(), kFrame);
  EXPECT_EQ(asked_.at(0).source, "0xbeef:0x0002");
}

TEST_F(ShortFramesTest, NamesOfGatewaysThatDoNotFitAreLeftOut) {
  const Announcement full{.gateway = std::string(60, 'g'),
                          .lasts_ns = 1,
                          .forwards = true,
                          .not_received = {std::string(40, 'h'), std::string(20, 'i')}};
  const auto event = encode(full, kFrame);
  EXPECT_LE(event.size(), kFrame);
  const auto read = parse_announcement(event);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->gateway, full.gateway);
  EXPECT_EQ(read->not_received, std::vector<std::string>{std::string(20, 'i')});
}

}  // namespace
}  // namespace mlcca::relay
