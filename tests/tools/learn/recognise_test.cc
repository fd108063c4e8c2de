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

TEST(Recogniser, TagsThatAreAskedForAreFamouso) {
  std::vector<test::Sent> sent = {frame(0x1f480002U | kExtended, {1, 2, 3, 4, 5, 6, 7, 8}),
                                  frame(0x1f5fc004U | kExtended, {1, 2, 3, 4, 5, 6, 7, 8})};
  for (std::uint8_t i = 0; i < 100; ++i) sent.push_back(frame(0x1f480064U | kExtended, {i}));
  EXPECT_EQ(recognised(sent).profile, Profile::famouso);
}

TEST(Recogniser, WithoutFramesNothingIsSure) { EXPECT_EQ(Recogniser().result().percent, 0U); }

}  // namespace
}  // namespace mlcca::learn
