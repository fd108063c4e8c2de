// SPDX-License-Identifier: BSD-2-Clause
// What became of a frame: it arrived, a gate dropped it, or the kernel lost it on the way.
#include "tools/readback/fate.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <functional>

namespace mlcca::readback {
namespace {

using namespace std::chrono_literals;

/// A way from one end to the other one that does with each frame what the test says.
class FateTest : public testing::Test {
 protected:
  void SetUp() override {
    std::array<int, 2> ends{};
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, ends.data()), 0);
    near_ = Fd(ends[0]);
    far_ = Fd(ends[1]);
  }

  /// `with` is given the number of the frame, from 1 on.
  Fate became(const std::function<void(int)>& with, std::chrono::milliseconds patience = 20ms) {
    return fate_of(
        far_, [&] { return drops_; },
        [&] {
          with(++sent_);
          return taken_;
        },
        [&] {
          char octet = 0;
          return ::read(far_.get(), &octet, 1) == 1;
        },
        patience);
  }
  void arrives() { ASSERT_EQ(::write(near_.get(), "x", 1), 1); }

  Fd near_, far_;
  std::uint64_t drops_ = 7;
  int sent_ = 0;
  bool taken_ = true;  ///< by the kernel
};

TEST_F(FateTest, WhatArrivesHasPassed) {
  EXPECT_EQ(became([&](int) { arrives(); }), Fate::passed);
  EXPECT_EQ(sent_, 1);
}

TEST_F(FateTest, WhatIsCountedWasDropped) {
  EXPECT_EQ(became([&](int) { ++drops_; }), Fate::dropped);
  EXPECT_EQ(sent_, 1);
}

TEST_F(FateTest, WhatTheKernelLosesIsSentAgain) {
  EXPECT_EQ(became([&](int number) {
              if (number == 3) arrives();
            }),
            Fate::passed);
  EXPECT_EQ(sent_, 3);
}

TEST_F(FateTest, WhatIsDroppedWhenItIsSentAgainWasDropped) {
  EXPECT_EQ(became([&](int number) { drops_ += number == 2 ? 1 : 0; }), Fate::dropped);
  EXPECT_EQ(sent_, 2);
}

TEST_F(FateTest, WhatIsLostThreeTimesIsLost) {
  EXPECT_EQ(became([](int) {}), Fate::lost);
  EXPECT_EQ(sent_, 3);
}

TEST_F(FateTest, NobodyWaitsForWhatTheKernelDoesNotTake) {
  taken_ = false;
  EXPECT_EQ(became([](int) {}, 10h), Fate::lost);
  EXPECT_EQ(sent_, 3);
}

TEST_F(FateTest, WhatTheKernelDoesNotTakeBecauseAGateDropsItWasDropped) {
  taken_ = false;
  EXPECT_EQ(became([&](int) { ++drops_; }, 10h), Fate::dropped);
}

TEST_F(FateTest, AFrameArrivesAlsoWherePollFails) {
  const Fd closed;
  EXPECT_EQ(fate_of(
                closed, [] { return 0U; }, [] { return true; }, [] { return true; }, 20ms),
            Fate::passed);
}

}  // namespace
}  // namespace mlcca::readback
