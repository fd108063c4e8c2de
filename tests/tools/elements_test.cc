// SPDX-License-Identifier: BSD-2-Clause
#include "tools/elements.hpp"

#include <gtest/gtest.h>

#include "core/profiles/profile.hpp"

namespace mlcca::tools {
namespace {

using core::Profile;

constexpr std::uint64_t kMs = 1'000'000;
constexpr std::uint32_t kLong = core::kExtendedFlag;

TEST(Elements, NominalPeriodsAreThoseThatPeopleChoose) {
  EXPECT_EQ(nominal(10 * kMs), 10 * kMs);
  EXPECT_EQ(nominal(9'998'000), 10 * kMs);
  EXPECT_EQ(nominal(10'150'000), 10 * kMs);
  EXPECT_EQ(nominal(99'000'000), 100 * kMs);
  EXPECT_EQ(nominal(24'900'000), 25 * kMs);
  EXPECT_EQ(nominal(733'333'333), 730 * kMs);
  EXPECT_EQ(nominal(1), 1U);
}

TEST(Elements, TimesAreExact) {
  EXPECT_EQ(time_words(50 * kMs), "50ms");
  EXPECT_EQ(time_words(1'250'000), "1.25ms");
  EXPECT_EQ(time_words(320'000), "320us");
  EXPECT_EQ(time_words(1'000'000'001), "1.000000001s");
  EXPECT_EQ(time_words(7), "7ns");
  EXPECT_EQ(time_words(0), "0ns");
}

TEST(Elements, AnIdentifierSaysChannelSenderAndPriority) {
  const auto j1939 = parts_of(Profile::j1939, kLong | 0x0cf00417U);
  ASSERT_TRUE(j1939);
  EXPECT_EQ(j1939->number, 0xf004U);
  EXPECT_EQ(j1939->node, 0x17U);
  EXPECT_EQ(j1939->priority, 3U);
  // Below PDU format 240 the low byte of the PGN is the address that it is for.
  EXPECT_EQ(parts_of(Profile::j1939, kLong | 0x18ef2a17U)->number, 0xef00U);
  const auto cyphal = parts_of(Profile::cyphal, kLong | 4U << 26U | 1234U << 8U | 42U);
  ASSERT_TRUE(cyphal);
  EXPECT_EQ(cyphal->number, 1234U);
  EXPECT_EQ(cyphal->node, 42U);
  EXPECT_EQ(cyphal->priority, 4U);
  const auto famouso = parts_of(Profile::famouso, kLong | 0x7dU << 22U | 0x21U << 14U | 0x3fffU);
  ASSERT_TRUE(famouso);
  EXPECT_EQ(famouso->number, 0x3fffU);
  EXPECT_EQ(famouso->node, 0x21U);
  EXPECT_EQ(famouso->priority, 0x7dU);
  EXPECT_FALSE(famouso->is_fragment);
  EXPECT_TRUE(parts_of(Profile::famouso, kLong | 1U << 21U | 0x100U)->is_fragment);
  EXPECT_EQ(parts_of(Profile::raw, 0x123)->number, 0x123U);
  EXPECT_EQ(parts_of(Profile::raw, kLong | 0x123U)->number, kLong | 0x123U);
}

TEST(Elements, WhatNoChannelCanHaveIsNone) {
  EXPECT_FALSE(parts_of(Profile::j1939, 0x123)) << "11 bits";
  EXPECT_FALSE(parts_of(Profile::canopen, kLong | 0x181U)) << "29 bits";
  EXPECT_FALSE(parts_of(Profile::cyphal, kLong | 1U << 25U)) << "a service";
  EXPECT_FALSE(parts_of(Profile::cyphal, kLong | 1U << 24U)) << "no node";
  EXPECT_FALSE(parts_of(Profile::famouso, kLong | 0x63U)) << "of management";
  EXPECT_TRUE(parts_of(Profile::famouso, kLong | 0x64U));
}

TEST(Elements, ControlTrafficIsThatOfTheProfile) {
  EXPECT_TRUE(is_control(Profile::j1939, kLong | 0x18eeff17U)) << "an address claim";
  EXPECT_FALSE(is_control(Profile::j1939, kLong | 0x0cf00417U));
  EXPECT_TRUE(is_control(Profile::canopen, 0x000)) << "NMT";
  EXPECT_FALSE(is_control(Profile::canopen, 0x181));
  EXPECT_TRUE(is_control(Profile::famouso, kLong | 0x1f5fc004U)) << "a reply of the broker";
  // The heart-beat of the paper: SUBSCRIB has the same priority, and a tag that is dealt.
  EXPECT_FALSE(is_control(Profile::famouso, kLong | 0x1f480064U));
  EXPECT_FALSE(is_control(Profile::raw, 0x123));
}

}  // namespace
}  // namespace mlcca::tools
