// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/patience.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

namespace mlcca {
namespace {

constexpr int kBeats = 3;

TEST(Patience, GivesWhatTheWorkGives) {
  Patience patience([] {});
  for (int i = 0; i < 100; ++i) EXPECT_EQ(patience.wait_for([i] { return i; }), i);
  EXPECT_EQ(*patience.wait_for([] { return std::make_unique<std::string>("moved"); }), "moved");
}

TEST(Patience, BeatsWhileTheWorkHangs) {
  std::atomic<int> beats = 0;
  Patience patience([&] { ++beats; });
  for (int i = 1; i <= 2; ++i) {
    const bool done = patience.wait_for([&] {
      while (beats < i * kBeats) std::this_thread::yield();
      return true;
    });
    EXPECT_TRUE(done);
    EXPECT_GE(beats, i * kBeats);
  }
}

TEST(Patience, DoesNotBeatForWhatHangsTooLong) {
  std::atomic<int> beats = 0;
  Patience patience([&] { ++beats; }, 1);
  EXPECT_TRUE(patience.wait_for([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return true;
  }));
  EXPECT_EQ(beats, 0) << "1 ns is over before the first one";
}

TEST(Patience, WithoutPatienceTheCallerDoesTheWork) {
  Patience patience([] {}, 0);
  EXPECT_EQ(patience.wait_for([] { return std::this_thread::get_id(); }),
            std::this_thread::get_id());
}

TEST(Patience, CallsFromTheWaitingThread) {
  std::thread::id beats;
  std::thread::id works;
  std::atomic<bool> has_beaten = false;
  Patience patience([&] {
    beats = std::this_thread::get_id();
    has_beaten = true;
  });
  patience.wait_for([&] {
    works = std::this_thread::get_id();
    while (!has_beaten) std::this_thread::yield();
    return true;
  });
  EXPECT_EQ(beats, std::this_thread::get_id());
  EXPECT_NE(works, std::this_thread::get_id());
}

}  // namespace
}  // namespace mlcca
