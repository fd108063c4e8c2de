// SPDX-License-Identifier: BSD-2-Clause
#include "relay/layers/sockets.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <string>

namespace mlcca::relay {
namespace {

struct BatchTest : ::testing::Test {
  BatchTest() {
    std::array<int, 2> pair{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0, pair.data()), 0);
    near_ = Fd(pair[0]);
    far_ = Fd(pair[1]);
  }
  void send(const std::string& text) {
    ASSERT_EQ(::send(far_.get(), text.data(), text.size(), 0), static_cast<ssize_t>(text.size()));
  }
  void send_numbers(int count) {
    for (int i = 0; i < count; ++i) send(std::to_string(i));
  }
  std::string next() {
    const auto message = batch_.next(near_);
    if (message.received.size < 0) return errno == EAGAIN ? "nothing" : "failed";
    return {message.data, message.data + message.received.size};
  }

  Fd near_;
  Fd far_;
  Batch batch_{4};
};

TEST_F(BatchTest, GivesMessagesInTheirOrderThenNothing) {
  send_numbers(3);
  EXPECT_EQ(next(), "0");
  EXPECT_TRUE(batch_.pending());
  EXPECT_EQ(next(), "1");
  EXPECT_EQ(next(), "2");
  EXPECT_FALSE(batch_.pending());
  EXPECT_EQ(next(), "nothing");
  EXPECT_EQ(next(), "nothing");
}

TEST_F(BatchTest, DoesNotAskAgainAfterTheLastMessage) {
  send("0");
  EXPECT_EQ(next(), "0");
  send("1");
  EXPECT_EQ(next(), "nothing");  // a poll of the socket tells of it
  EXPECT_EQ(next(), "1");
}

TEST_F(BatchTest, GivesMoreMessagesThanItTakesAtOnce) {
  send_numbers(9);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(next(), std::to_string(i));
  EXPECT_EQ(next(), "nothing");
}

TEST_F(BatchTest, SaysThatALongMessageWasCut) {
  send("12345");
  const auto message = batch_.next(near_);
  EXPECT_EQ(message.received.size, 4);
  EXPECT_NE(message.received.flags & MSG_TRUNC, 0);
}

TEST_F(BatchTest, SaysWhyThereIsNone) {
  near_ = Fd();
  EXPECT_EQ(next(), "failed");
}

}  // namespace
}  // namespace mlcca::relay
