// SPDX-License-Identifier: BSD-2-Clause
// Which signals end listening.
#include <gtest/gtest.h>

#include <csignal>

#include "tools/design/learn_options.hpp"

namespace mlcca::tools::design {
namespace {

volatile std::sig_atomic_t ended = 0;

struct EndOfListening : ::testing::Test {
  EndOfListening() { ended = 0; }
  ~EndOfListening() override {
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, SIG_DFL);
  }
};

TEST_F(EndOfListening, IsAlsoThatOfTheTerminal) {
  // Whoever runs the tests by nohup or in the background has these ignored.
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, SIG_DFL);
  on_end([](int) { ended = ended + 1; });
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::raise(number);
  EXPECT_EQ(ended, 3);
}

TEST_F(EndOfListening, IsNotThatOfTheTerminalByNohup) {
  std::signal(SIGHUP, SIG_IGN);
  on_end([](int) { ended = ended + 1; });
  std::raise(SIGHUP);
  EXPECT_EQ(ended, 0);
}

}  // namespace
}  // namespace mlcca::tools::design
