// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/recognise.hpp"

#include <gtest/gtest.h>

#include "tests/tools/learn/traffic.hpp"

namespace mlcca::learn {
namespace {

using core::Profile;
using test::kMs;

Recognised recognised(const std::vector<test::Sent>& sent) {
  Recogniser recogniser;
  for (const auto& one : sent) recogniser.add(one.frame());
  return recogniser.result();
}

test::Sent frame(std::uint32_t id, std::vector<std::uint8_t> data) {
  return {0, 0, id, std::move(data)};
}

TEST(Recogniser, ElevenBitsWithoutMoreAreRaw) {
  test::Traffic traffic(1);
  EXPECT_EQ(recognised(traffic.periodic(0, 0x123, 10 * kMs, 0, 8, 10).sent()).profile,
            Profile::raw);
}

TEST(Recogniser, NodesThatAreAliveAreCanopen) {
  std::vector<test::Sent> sent;
  for (int i = 0; i < 50; ++i) {
    sent.push_back(frame(0x80, {}));
    for (const std::uint32_t node : {1U, 5U}) {
      sent.push_back(frame(0x180 + node, {1, 2, 3, 4}));
      sent.push_back(frame(0x280 + node, {1, 2}));
    }
    if (i % 10 == 0)
      for (const std::uint32_t node : {1U, 5U}) sent.push_back(frame(0x700 + node, {5}));
  }
  const auto is = recognised(sent);
  EXPECT_EQ(is.profile, Profile::canopen);
  EXPECT_GE(is.percent, 80U);
  EXPECT_TRUE(is.why.contains("2 nodes send heart-beats")) << is.why;
  // A single frame that looks like one among others is no reason.
  sent.clear();
  for (std::uint32_t i = 0; i < 100; ++i) sent.push_back(frame(0x100 + i, {1, 2, 3}));
  sent.push_back(frame(0x705, {5}));
  EXPECT_EQ(recognised(sent).profile, Profile::raw);
}

TEST(Recogniser, TransferIdsThatCountAreCyphal) {
  std::vector<test::Sent> sent;
  for (std::uint8_t i = 0; i < 100; ++i)
    for (const std::uint32_t id : {0x107d552aU, 0x10606b7fU})
      sent.push_back(frame(id | kExtended, {1, 2, static_cast<std::uint8_t>(0xe0 | (i & 0x1f))}));
  const auto is = recognised(sent);
  EXPECT_EQ(is.profile, Profile::cyphal);
  EXPECT_GE(is.percent, 90U);
}

TEST(Recogniser, ParameterGroupsAndClaimsAreJ1939) {
  std::vector<test::Sent> sent;
  for (std::uint8_t i = 0; i < 100; ++i) {
    sent.push_back(frame(0x0cf00400U | kExtended, {1, 2, 3, 4, 5, 6, 7, i}));
    sent.push_back(frame(0x18fef121U | kExtended, {1, 2, 3, 4, 5, 6, 7, 8}));
  }
  EXPECT_EQ(recognised(sent).profile, Profile::j1939);
  EXPECT_LE(recognised(sent).percent, 70U) << "no claim was seen";
  sent.push_back(frame(0x18eeff21U | kExtended, {1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_GE(recognised(sent).percent, 90U);
}

/// One message that goes to a single node (TSC1) may be most of the frames.
TEST(Recogniser, OfABusWithOneFastMessageToANodeTheIdentifiersCount) {
  std::vector<test::Sent> sent;
  const auto repeat = [&](std::uint32_t id, int times) {
    for (int i = 0; i < times; ++i)
      sent.push_back(frame(id | kExtended, {1, 2, 3, 4, 5, 6, 7, static_cast<std::uint8_t>(i)}));
  };
  repeat(0x0c000003, 1000);
  for (const std::uint32_t id : {0x0cf00203U, 0x0cf00300U, 0x18f0010bU, 0x18fef100U, 0x18fef200U})
    repeat(id, 100);
  const auto is = recognised(sent);
  EXPECT_EQ(is.profile, Profile::j1939);
  EXPECT_TRUE(is.why.contains("83 % of the identifiers of broadcast PGNs")) << is.why;
  repeat(0x18eafff9, 1);
  EXPECT_GE(recognised(sent).percent, 90U) << "and requests";
}

TEST(Recogniser, WhatMayBeJ1939IsSaidToBePerhaps) {
  std::vector<test::Sent> sent;
  for (std::uint8_t i = 0; i < 100; ++i)
    for (const std::uint32_t id : {0x0c000003U, 0x0cf00400U})
      sent.push_back(frame(id | kExtended, {1, 2, 3, 4, 5, 6, 7, i}));
  const auto is = recognised(sent);
  EXPECT_EQ(is.profile, Profile::raw);
  EXPECT_EQ(is.perhaps, Profile::j1939);
  EXPECT_TRUE(is.why.contains("50 % of the frames of broadcast PGNs")) << is.why;
}

TEST(Recogniser, OfOneFastMessageBesideCanopenTheIdentifiersCount) {
  std::vector<test::Sent> sent;
  for (std::uint8_t i = 0; i < 100; ++i) {
    for (int n = 0; n < 20; ++n) sent.push_back(frame(0x123, {i, 2}));
    for (const std::uint32_t id : {0x185U, 0x285U, 0x385U, 0x485U}) sent.push_back(frame(id, {i}));
    sent.push_back(frame(0x705, {5}));
  }
  const auto is = recognised(sent);
  EXPECT_EQ(is.profile, Profile::canopen);
  EXPECT_TRUE(is.why.starts_with("1 node sends heart-beats")) << is.why;
  EXPECT_TRUE(is.why.contains("83 % of the identifiers are theirs")) << is.why;
}

TEST(Recogniser, OfFewFramesItIsLessSure) {
  const auto one = recognised({frame(0x123, {1})});
  EXPECT_LE(one.percent, 50U);
  EXPECT_TRUE(one.why.ends_with("in 1 frame only")) << one.why;
}

TEST(Recogniser, TagsThatAreAskedForAreFamouso) {
  std::vector<test::Sent> sent = {frame(0x1f480002U | kExtended, {1, 2, 3, 4, 5, 6, 7, 8}),
                                  frame(0x1f5fc004U | kExtended, {1, 2, 3, 4, 5, 6, 7, 8})};
  for (std::uint8_t i = 0; i < 100; ++i) sent.push_back(frame(0x1f480064U | kExtended, {i}));
  EXPECT_EQ(recognised(sent).profile, Profile::famouso);
}

TEST(Recogniser, WithoutFramesNothingIsSure) { EXPECT_EQ(Recogniser().result().percent, 0U); }

}  // namespace
}  // namespace mlcca::learn
