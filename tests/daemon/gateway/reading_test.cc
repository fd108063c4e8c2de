// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/reading.hpp"

#include <gtest/gtest.h>

#include <latch>
#include <memory>
#include <optional>
#include <thread>

namespace mlcca {
namespace {

class ReadingTest : public ::testing::Test {
 protected:
  void SetUp() override {
    sd_event* raw = nullptr;
    ASSERT_GE(sd_event_new(&raw), 0);
    loop_.reset(raw);
    reading_.emplace(raw);
  }
  void turn_until_idle() {
    while (reading_->busy()) ASSERT_GE(sd_event_run(loop_.get(), ~0ULL), 0);
  }

  std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop_;
  std::optional<Reading> reading_;
};

TEST_F(ReadingTest, WorksOnAThreadAndEndsInTheLoop) {
  const auto loop = std::this_thread::get_id();
  auto worked = loop;
  auto ended = std::thread::id();
  ASSERT_TRUE(reading_->begin([&] { worked = std::this_thread::get_id(); },
                              [&] { ended = std::this_thread::get_id(); }));
  EXPECT_TRUE(reading_->waits());
  turn_until_idle();
  EXPECT_NE(worked, loop);
  EXPECT_EQ(ended, loop);
  EXPECT_FALSE(reading_->waits());
}

TEST_F(ReadingTest, DoesOneThingAtATime) {
  const auto goes_on = std::make_shared<std::latch>(1);
  int first = 0;
  int second = 0;
  ASSERT_TRUE(reading_->begin([goes_on] { goes_on->wait(); }, [&] { ++first; }));
  EXPECT_FALSE(reading_->begin([] {}, [&] { ++second; }));
  goes_on->count_down();
  turn_until_idle();
  EXPECT_EQ(first, 1);
  EXPECT_EQ(second, 0) << "was refused";
  ASSERT_TRUE(reading_->begin([] {}, [&] { ++second; }));
  turn_until_idle();
  EXPECT_EQ(second, 1);
}

TEST_F(ReadingTest, WhatIsForgottenGoesOnAndIsNotWaitedFor) {
  const auto goes_on = std::make_shared<std::latch>(1);
  bool done = false;
  ASSERT_TRUE(reading_->begin([goes_on] { goes_on->wait(); }, [&] { done = true; }));
  reading_->forget();
  EXPECT_FALSE(reading_->waits());
  EXPECT_TRUE(reading_->busy()) << "the thread is under way";
  EXPECT_FALSE(reading_->begin([] {}, [] {}));
  goes_on->count_down();
  turn_until_idle();
  EXPECT_FALSE(done);
}

TEST_F(ReadingTest, TheEndMayBeginTheNext) {
  bool again = false;
  ASSERT_TRUE(
      reading_->begin([] {}, [&] { EXPECT_TRUE(reading_->begin([] {}, [&] { again = true; })); }));
  turn_until_idle();
  EXPECT_TRUE(again);
}

TEST_F(ReadingTest, WhatTheWorkHoldsIsGivenBackBeforeItsEnd) {
  const auto held = std::make_shared<int>(0);
  long holders = 0;
  ASSERT_TRUE(reading_->begin([held] {}, [&] { holders = held.use_count(); }));
  turn_until_idle();
  EXPECT_EQ(holders, 1);
}

}  // namespace
}  // namespace mlcca
