// SPDX-License-Identifier: BSD-2-Clause
// Frames of IEEE 802.15.4, without a radio. The guest case relay-wpan has radios.
#include "relay/layers/wpan_layer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <string>
#include <utility>
#include <vector>

namespace mlcca::relay {
namespace {

constexpr std::uint64_t kSubject = 0x44697374616e6365;  // "Distance"

class Radio : public WpanSocket {
 public:
  [[nodiscard]] int fd() const override { return -1; }
  Got receive(Frame& to) override {
    if (in.empty()) return is_there ? Got::nothing : Got::gone;
    to = in.front();
    in.pop_front();
    return Got::frame;
  }
  Sent send(Octets payload) override {
    out.emplace_back(payload.begin(), payload.end());
    return Sent::sent;
  }
  [[nodiscard]] std::uint64_t dropped() const override { return 3; }

  void bring(const std::string& payload, const std::string& from = "") {
    Frame frame;
    frame.size = payload.size();
    std::ranges::copy(payload.substr(0, frame.payload.size()), frame.payload.begin());
    frame.from = from;
    frame.unix_ns = 7;
    in.push_back(frame);
  }

  std::deque<Frame> in;
  std::vector<std::string> out;
  bool is_there = true;
};

class WpanLayerTest : public ::testing::Test {
 protected:
  WpanLayerTest() {
    auto radio = std::make_unique<Radio>();
    radio_ = radio.get();
    layer_ = std::make_unique<WpanLayer>(std::move(radio));
  }
  void follow(Layer::Follower follower, const std::string& address, std::size_t longest = 102) {
    ASSERT_TRUE(layer_->follow(follower, endpoint(address), kSubject, longest));
  }
  static control::Endpoint endpoint(const std::string& address) {
    control::Endpoint out;
    out.wpan = true;
    out.address = address;
    return out;
  }
  /// "FOLLOWER:EVENT" each.
  std::vector<std::string> received() {
    std::vector<std::string> out;
    EXPECT_TRUE(layer_->receive(64, [&](const Layer::Arrival& arrival) {
      EXPECT_EQ(arrival.unix_ns, 7U);
      out.push_back(std::to_string(arrival.follower) + ':' +
                    std::string(arrival.event.begin(), arrival.event.end()));
    }));
    return out;
  }
  using Strings = std::vector<std::string>;

  Radio* radio_ = nullptr;
  std::unique_ptr<WpanLayer> layer_;
};

TEST_F(WpanLayerTest, AFrameIsSubjectAndEvent) {
  const std::string event = "hello";
  EXPECT_EQ(layer_->send({}, kSubject,
                         Octets(reinterpret_cast<const std::uint8_t*>(event.data()), event.size())),
            Sent::sent);
  EXPECT_EQ(radio_->out, Strings{"Distancehello"});
  follow(1, "");
  radio_->bring("Distancehello", "0xbeef:0x0002");
  radio_->bring("Distance");
  radio_->bring("Velocityhello");
  EXPECT_EQ(received(), (Strings{"1:hello", "1:"}));
  EXPECT_EQ(layer_->losses().malformed, 0U);
}

TEST_F(WpanLayerTest, WhatIsNoFrameOfAnEventIsCounted) {
  follow(1, "", 5);
  radio_->bring("Distanc");
  radio_->bring("");
  radio_->bring("Distance" + std::string(kWpanPayload, '.'));
  radio_->bring("Distance......");
  radio_->bring("Distance.....");
  EXPECT_EQ(received(), Strings{"1:....."});
  EXPECT_EQ(layer_->losses().malformed, 3U);
  EXPECT_EQ(layer_->losses().too_long, 1U);
  EXPECT_EQ(layer_->losses().in_socket, 3U);
}

TEST_F(WpanLayerTest, AnEventThatFitsNoFrameIsNotSent) {
  const std::vector<std::uint8_t> event(kWpanPayload - 8 + 1);
  EXPECT_EQ(layer_->send({}, kSubject, event), Sent::too_long);
  EXPECT_EQ(layer_->send({}, kSubject, Octets(event).first(kWpanPayload - 8)), Sent::sent);
  ASSERT_EQ(radio_->out.size(), 1U);
  EXPECT_EQ(radio_->out[0].size(), kWpanPayload);
}

TEST_F(WpanLayerTest, WhoFollowsASenderGetsItsEventsAlone) {
  follow(1, "0xbeef:0x0002");
  follow(2, "02:00:00:00:00:00:00:01");
  follow(3, "");
  radio_->bring("Distancea", "0xbeef:0x0002");
  radio_->bring("Distanceb", "02:00:00:00:00:00:00:01");
  radio_->bring("Distancec", "0xbee0:0x0002");
  radio_->bring("Distanced", "");
  EXPECT_EQ(received(), (Strings{"1:a", "2:b", "3:c", "3:d"}));
  layer_->leave(1, endpoint("0xbeef:0x0002"), kSubject);
  radio_->bring("Distancee", "0xbeef:0x0002");
  EXPECT_EQ(received(), Strings{"3:e"});
  layer_->leave(2, endpoint("02:00:00:00:00:00:00:01"), kSubject);
  layer_->leave(3, endpoint(""), kSubject);
  layer_->leave(3, endpoint(""), kSubject);
  radio_->bring("Distancef");
  EXPECT_EQ(received(), Strings{});
}

TEST_F(WpanLayerTest, AnInterfaceThatIsGoneIsReported) {
  radio_->is_there = false;
  EXPECT_FALSE(layer_->receive(1, [](const Layer::Arrival&) {}));
}

TEST(WpanAddresses, AreWrittenAsTheDescriptionHasThem) {
  EXPECT_EQ(extended_address({0x02, 0, 0, 0, 0, 0, 0xab, 0x01}), "02:00:00:00:00:00:ab:01");
  EXPECT_EQ(short_address(0xbeef, 0x1), "0xbeef:0x0001");
  EXPECT_EQ(short_address(0, 0xfffd), "0x0000:0xfffd");
}

}  // namespace
}  // namespace mlcca::relay
