// SPDX-License-Identifier: BSD-2-Clause
#include "control/slices.hpp"

#include <gtest/gtest.h>

#include "control/codec.hpp"
#include "tests/control/messages.hpp"

namespace mlcca::test {
namespace {

using control::Reply;

TEST(SlicesTest, PutTogetherAreWhatWasSplit) {
  for (const NamedReply& named : all_replies())
    for (const std::size_t rows : {1UL, 2UL, 3UL, 1000UL}) {
      const auto slices = control::slices_of(named.reply, rows);
      ASSERT_FALSE(slices.empty()) << named.name;
      std::optional<Reply> whole;
      for (std::size_t i = 0; i < slices.size(); ++i) {
        EXPECT_EQ(slices[i].more, i + 1 < slices.size()) << named.name;
        control::Buffer wire;
        wire.append(control::encode(slices[i]));
        auto read = control::decode_reply(wire);
        ASSERT_TRUE(read && *read) << named.name;
        ASSERT_TRUE(control::join(whole, std::move(**read))) << named.name;
      }
      EXPECT_EQ(whole, named.reply) << named.name << " by " << rows;
    }
}

TEST(SlicesTest, ARowCountsWithItsNames) {
  control::Channels channels;
  channels.channels.resize(4);
  for (control::Channel& channel : channels.channels) channel.subscribers.resize(60, "name");
  EXPECT_EQ(control::slices_of({7, channels}, 100).size(), 2U);
  for (control::Channel& channel : channels.channels) channel.subscribers.clear();
  EXPECT_EQ(control::slices_of({7, channels}, 100).size(), 1U);
}

TEST(SlicesTest, AWayCountsWithItsNodes) {
  control::MediumUse use;
  use.path.resize(60, "node");
  control::Routes routes;
  routes.routes.resize(4);
  for (control::RouteReport& route : routes.routes) route.media = {use};
  EXPECT_EQ(control::slices_of({7, routes}, 100).size(), 2U);
  control::Channels channels;
  channels.channels.resize(4);
  for (control::Channel& channel : channels.channels) channel.media = {use};
  EXPECT_EQ(control::slices_of({7, channels}, 100).size(), 2U);
}

TEST(SlicesTest, AnErrorTakesThePlaceOfEverything) {
  std::optional<Reply> whole;
  ASSERT_TRUE(control::join(whole, Reply{7, full_networks(), true}));
  const Reply error{7, control::Error{control::ErrorKind::world, "reloaded", {}}};
  ASSERT_TRUE(control::join(whole, error));
  EXPECT_EQ(whole, error);
}

TEST(SlicesTest, TwoKindsDoNotFitTogether) {
  std::optional<Reply> whole;
  ASSERT_TRUE(control::join(whole, Reply{7, full_networks(), true}));
  EXPECT_FALSE(control::join(whole, Reply{7, full_history()}));
}

}  // namespace
}  // namespace mlcca::test
