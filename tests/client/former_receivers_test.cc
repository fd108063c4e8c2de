// SPDX-License-Identifier: BSD-2-Clause
// How long events are sent to receivers that the present daemon has not stated.
#include "client/former_receivers.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace mlcca::client {
namespace {

using Until = std::optional<std::uint64_t>;

class FormerReceiversTest : public ::testing::Test {
 protected:
  static SharedEndpoint receiver() { return std::make_shared<const control::Endpoint>(); }

  std::shared_ptr<int> lever_ = std::make_shared<int>();
  std::shared_ptr<int> button_ = std::make_shared<int>();
  SharedEndpoint motor_ = receiver(), camera_ = receiver();
  FormerReceivers former_;
};

TEST_F(FormerReceiversTest, OneThatIsKeptAgainKeepsItsEnd) {
  former_.keep(lever_, {motor_}, 10);
  former_.keep(lever_, {motor_, camera_}, 20);
  EXPECT_EQ(former_.until(lever_, motor_), Until(10)) << "else it would never end";
  EXPECT_EQ(former_.until(lever_, camera_), Until(20));
}

TEST_F(FormerReceiversTest, WhoIsNotKeptAgainIsStatedOrGone) {
  former_.keep(lever_, {motor_, camera_}, 10);
  former_.keep(lever_, {camera_}, 20);
  EXPECT_EQ(former_.until(lever_, motor_), std::nullopt);
  former_.keep(lever_, {motor_}, 30);
  EXPECT_EQ(former_.until(lever_, motor_), Until(30)) << "it begins anew";
}

TEST_F(FormerReceiversTest, EachPublisherHasItsOwn) {
  former_.keep(lever_, {motor_}, 10);
  former_.keep(button_, {motor_}, 20);
  EXPECT_EQ(former_.until(lever_, motor_), Until(10));
  EXPECT_TRUE(former_.forget(button_, motor_));
  EXPECT_FALSE(former_.forget(button_, motor_));
  EXPECT_EQ(former_.until(button_, motor_), std::nullopt);
  EXPECT_EQ(former_.until(lever_, motor_), Until(10));
}

TEST_F(FormerReceiversTest, ThoseOfAPublisherThatHasEndedGoWithTheNextAnswer) {
  former_.keep(lever_, {motor_}, 10);
  const std::weak_ptr<int> ended = lever_;
  lever_.reset();
  former_.keep(button_, {}, 20);
  EXPECT_EQ(former_.until(ended, motor_), std::nullopt);
}

}  // namespace
}  // namespace mlcca::client
