// SPDX-License-Identifier: BSD-2-Clause
// Events of a CAN bus without a bus: frames as they stand in the reference of FAMOUSO.
#include "relay/layers/can_layer.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <deque>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace mlcca::relay {
namespace {

constexpr std::uint32_t kId = 0x9f414065;  // node 5, tag 0x65, 29 bits
constexpr std::uint32_t kMask = 0xdfffffff;
constexpr std::uint32_t kFragment = 1U << 21U;

class FakeSocket : public FrameSocket {
 public:
  [[nodiscard]] int fd() const override { return -1; }
  [[nodiscard]] Result<void> filter(const std::vector<can_filter>& filters) override {
    filters_ = filters;
    return {};
  }
  Got receive(Frame& to) override {
    if (in_.empty()) return gone_ ? Got::gone : Got::nothing;
    to = in_.front();
    in_.pop_front();
    return Got::frame;
  }
  Sent send(const canfd_frame& frame, bool fd) override {
    if (outcome_ != Sent::sent) return outcome_;
    out_.push_back({frame, fd, false, 7});
    return Sent::sent;
  }
  [[nodiscard]] bool pending() const override { return in_batches_ && !in_.empty(); }
  [[nodiscard]] std::uint64_t dropped() const override { return 3; }

  std::deque<Frame> in_;
  std::vector<Frame> out_;
  std::vector<can_filter> filters_;
  Sent outcome_ = Sent::sent;
  bool gone_ = false;
  bool in_batches_ = false;
};

FrameSocket::Frame frame(std::uint32_t id, std::vector<std::uint8_t> data, bool fd = false) {
  FrameSocket::Frame out;
  out.frame.can_id = id;
  out.frame.len = static_cast<std::uint8_t>(data.size());
  std::ranges::copy(data, out.frame.data);
  out.fd = fd;
  out.unix_ns = 7;
  return out;
}

control::Endpoint endpoint(const std::string& profile, std::uint32_t id = kId,
                           std::uint32_t mask = kMask) {
  control::Endpoint out;
  out.network = "bus";
  out.can = true;
  out.profile = profile;
  out.id = id;
  out.mask = mask;
  out.classic = true;
  out.frame_bytes = 8;
  return out;
}

std::vector<std::uint8_t> counting(std::size_t size) {
  std::vector<std::uint8_t> out(size);
  std::iota(out.begin(), out.end(), std::uint8_t{0});
  return out;
}

class CanLayerTest : public ::testing::Test {
 protected:
  CanLayerTest() {
    auto socket = std::make_unique<FakeSocket>();
    socket_ = socket.get();
    layer_ = std::make_unique<CanLayer>(std::move(socket));
  }
  using Events = std::vector<std::pair<Layer::Follower, std::vector<std::uint8_t>>>;
  Events events(std::vector<FrameSocket::Frame> frames) {
    for (auto& one : frames) socket_->in_.push_back(one);
    Events out;
    layer_->receive(100, [&](const Layer::Arrival& a) {
      out.emplace_back(a.follower, std::vector(a.event.begin(), a.event.end()));
      EXPECT_EQ(a.unix_ns, 7U);
    });
    return out;
  }
  std::string sent() const {
    static constexpr const char* digits = "0123456789abcdef";
    std::string out;
    for (const auto& one : socket_->out_) {
      for (std::uint8_t i = 0; i < one.frame.len; ++i) {
        out += digits[one.frame.data[i] >> 4U];
        out += digits[one.frame.data[i] & 0xfU];
      }
      out += ' ';
    }
    return out;
  }

  FakeSocket* socket_ = nullptr;
  std::unique_ptr<CanLayer> layer_;
};

TEST_F(CanLayerTest, ALongEventOfFamousoIsTheFragmentsOfTheReference) {
  const auto to = endpoint("famouso");
  ASSERT_EQ(layer_->send(to, 1, counting(20)), Sent::sent);
  EXPECT_EQ(sent(), "2200010203040506 010708090a0b0c0d 000e0f10111213 ");
  for (const auto& one : socket_->out_) EXPECT_EQ(one.frame.can_id, kId | kFragment);
  socket_->out_.clear();
  ASSERT_EQ(layer_->send(to, 1, counting(8)), Sent::sent);
  EXPECT_EQ(sent(), "0001020304050607 ");
  EXPECT_EQ(socket_->out_[0].frame.can_id, kId);
  socket_->out_.clear();
  ASSERT_EQ(layer_->send(to, 1, {}), Sent::sent);
  EXPECT_EQ(socket_->out_[0].frame.len, 0);
  EXPECT_EQ(layer_->send(to, 1, counting(24'609)), Sent::too_long);
}

TEST_F(CanLayerTest, FramesOfWhichNoPollTellsAreReceivedBeyondTheMost) {
  const auto from = endpoint("raw");
  ASSERT_TRUE(layer_->follow(1, from, 1, 8));
  FrameSocket::Frame one;
  one.frame.can_id = kId;
  std::size_t count = 0;
  const auto receive_two = [&] { layer_->receive(2, [&](const Layer::Arrival&) { ++count; }); };
  for (int i = 0; i < 5; ++i) socket_->in_.push_back(one);
  receive_two();
  EXPECT_EQ(count, 2U);
  socket_->in_batches_ = true;
  receive_two();
  EXPECT_EQ(count, 5U);
}

TEST_F(CanLayerTest, AnEmptyEventIsAnEmptyFrame) {
  for (const char* const profile : {"famouso", "raw"}) {
    ASSERT_EQ(layer_->send(endpoint(profile), 1, {}), Sent::sent) << profile;
    ASSERT_EQ(socket_->out_.size(), 1U);
    EXPECT_EQ(socket_->out_[0].frame.len, 0) << profile;
    socket_->out_.clear();
  }
  EXPECT_EQ(events({frame(kId, {})}), Events{}) << "followed by nobody";
}

TEST_F(CanLayerTest, FragmentsBecomeAnEventAndTwoSendersAreDistinguished) {
  auto from = endpoint("famouso", kId, kMask & ~kFragment);
  auto other = endpoint("famouso", kId + (1U << 14U), kMask & ~kFragment);
  ASSERT_TRUE(layer_->follow(1, from, 1, 100));
  ASSERT_TRUE(layer_->follow(2, other, 1, 100));
  const std::uint32_t a = kId | kFragment;
  const std::uint32_t b = a + (1U << 14U);
  const auto got =
      events({frame(a, {0x21, 0, 1, 2, 3, 4, 5, 6}), frame(b, {0x21, 9, 9, 9, 9, 9, 9, 9}),
              frame(a, {0x00, 7, 8}), frame(b, {0x00, 8}), frame(kId, {1, 2})});
  ASSERT_EQ(got.size(), 3U);
  EXPECT_EQ(got[0], (std::pair{Layer::Follower{1}, counting(9)}));
  EXPECT_EQ(got[1].first, 2U);
  EXPECT_EQ(got[1].second.size(), 8U);
  EXPECT_EQ(got[2].second, (std::vector<std::uint8_t>{1, 2}));
}

TEST(CanLayerParts, WhatNothingFollowsIsGivenUpOnTime) {
  static std::uint64_t now;
  now = 1'000'000'000;
  auto socket = std::make_unique<FakeSocket>();
  FakeSocket& bus = *socket;
  CanLayer layer(std::move(socket), nullptr, [] { return now; });
  control::Endpoint cyphal = endpoint("cyphal", 0x90006400 | 7, 0x9fffffff);
  cyphal.fragmented = true;
  ASSERT_TRUE(layer.follow(1, endpoint("famouso", kId, kMask & ~kFragment), 1, 100));
  ASSERT_TRUE(layer.follow(2, cyphal, 2, 100));
  EXPECT_FALSE(layer.holds_parts());
  bus.in_.push_back(frame(kId | kFragment, {0x21, 0, 1, 2, 3, 4, 5, 6}));
  bus.in_.push_back(frame(cyphal.id, {0, 1, 2, 3, 4, 5, 6, 0xa1}));
  layer.receive(100, [](const Layer::Arrival&) {});
  EXPECT_TRUE(layer.holds_parts());
  now += 2'500'000'000;
  layer.expire();
  EXPECT_TRUE(layer.holds_parts()) << "fragments have 3 s, transfers 2 s";
  EXPECT_EQ(layer.losses().incomplete, 1U);
  now += 500'000'000;
  layer.expire();
  EXPECT_FALSE(layer.holds_parts());
  EXPECT_EQ(layer.losses().incomplete, 2U);
}

TEST_F(CanLayerTest, WhoeverFollowsGetsAnEventOnce) {
  const auto from = endpoint("famouso", kId, kMask & ~kFragment);
  ASSERT_TRUE(layer_->follow(1, from, 1, 100));
  ASSERT_TRUE(layer_->follow(2, from, 1, 100));
  ASSERT_TRUE(layer_->follow(3, endpoint("famouso", kId, 0xc0003fff), 1, 100));
  const std::uint32_t id = kId | kFragment;
  EXPECT_EQ(events({frame(id, {0x21, 0, 1, 2, 3, 4, 5, 6}), frame(id, {0x00, 7})}).size(), 3U);
  EXPECT_EQ(layer_->losses().malformed, 0U);
}

TEST_F(CanLayerTest, OnlyWhatIsFollowedAndCameFromTheBusIsAnEvent) {
  ASSERT_TRUE(layer_->follow(1, endpoint("raw", 0x123, 0xc00007ff), 1, 4));
  auto own = frame(0x123, {1});
  own.local = true;
  const auto got =
      events({own, frame(0x124, {1}), frame(0x123 | CAN_EFF_FLAG, {1}),
              frame(0x123 | CAN_RTR_FLAG, {}), frame(CAN_ERR_FLAG | 0x123, {1}),
              frame(0x123, {1}, true), frame(0x123, {1, 2, 3, 4, 5}), frame(0x123, {5})});
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].second, std::vector<std::uint8_t>{5});
  EXPECT_EQ(layer_->losses().too_long, 1U);
  EXPECT_EQ(layer_->losses().in_socket, 3U) << "what the socket has dropped";
}

TEST_F(CanLayerTest, CyphalHasATailThatIsNotOfTheEvent) {
  const auto at = endpoint("cyphal");
  ASSERT_TRUE(layer_->follow(1, at, 1, 8));
  const auto got = events({frame(kId, {1, 2, 0xe5}), frame(kId, {1, 2, 0xa5}), frame(kId, {})});
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].second, (std::vector<std::uint8_t>{1, 2}));
  EXPECT_EQ(layer_->losses().malformed, 2U);
  for (int i = 0; i < 33; ++i) ASSERT_EQ(layer_->send(at, 1, counting(2)), Sent::sent);
  const auto other = endpoint("cyphal", kId + 1);
  ASSERT_EQ(layer_->send(other, 2, counting(7)), Sent::sent);
  EXPECT_TRUE(sent().starts_with("0001e0 0001e1 ")) << sent();
  EXPECT_TRUE(sent().ends_with("0001ff 0001e0 00010203040506e0 ")) << sent();
  EXPECT_EQ(layer_->send(at, 1, counting(8)), Sent::too_long);
}

TEST_F(CanLayerTest, ALongEventOfCyphalIsATransferOfSeveralFrames) {
  auto at = endpoint("cyphal");
  at.fragmented = true;
  ASSERT_EQ(layer_->send(at, 1, counting(9)), Sent::sent);
  ASSERT_EQ(layer_->send(at, 1, counting(9)), Sent::sent);
  EXPECT_EQ(sent(), "00010203040506a0 07086ede40 00010203040506a1 07086ede41 ");
  ASSERT_TRUE(layer_->follow(1, at, 1, 9));
  ASSERT_TRUE(layer_->follow(2, at, 1, 100));
  const auto got = events(std::exchange(socket_->out_, {}));
  ASSERT_EQ(got.size(), 4U) << "both follow, and each frame is taken once";
  for (const auto& one : got) EXPECT_EQ(one.second, counting(9));
}

// --- J1939 ---------------------------------------------------------------------------------------

constexpr std::uint32_t kDm1 = CAN_EFF_FLAG | 0x18feca05;
constexpr std::uint32_t kAllOfIt = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_EFF_MASK;

std::uint64_t time_now = 0;  // of the layer, ns

class J1939LayerTest : public CanLayerTest {
 protected:
  J1939LayerTest() {
    time_now = 1'000'000'000;
    auto socket = std::make_unique<FakeSocket>();
    socket_ = socket.get();
    layer_ = std::make_unique<CanLayer>(std::move(socket), nullptr, [] { return time_now; });
    at_.fragmented = true;
  }
  /// Everything that waits, and the time of each frame is that of the pause.
  std::vector<FrameSocket::Frame> all_sent() {
    for (int i = 0; i < 300; ++i) {
      time_now += j1939::kPause;
      events({});
    }
    return std::exchange(socket_->out_, {});
  }

  control::Endpoint at_ = endpoint("j1939", kDm1, kAllOfIt);
};

TEST_F(J1939LayerTest, AShortEventIsAFrame) {
  ASSERT_TRUE(layer_->follow(1, at_, 1, 20));
  ASSERT_EQ(layer_->send(at_, 1, counting(8)), Sent::sent);
  EXPECT_EQ(socket_->out_[0].frame.can_id, kDm1);
  const auto got = events(std::exchange(socket_->out_, {}));
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].second, counting(8));
}

TEST_F(J1939LayerTest, ALongEventGoesFrameByFrameAndComesWhole) {
  ASSERT_TRUE(layer_->follow(1, at_, 1, 20));
  ASSERT_TRUE(layer_->follow(2, at_, 1, 19));
  ASSERT_EQ(layer_->send(at_, 1, counting(20)), Sent::sent);
  EXPECT_EQ(sent(), "20140003ffcafe00 ") << "the packets follow, each after a pause";
  EXPECT_TRUE(events({}).empty());
  EXPECT_EQ(socket_->out_.size(), 1U);
  time_now += j1939::kPause;
  EXPECT_TRUE(events({}).empty());
  EXPECT_EQ(socket_->out_.size(), 2U);
  const auto frames = all_sent();
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0].frame.can_id, CAN_EFF_FLAG | 0x18ecff05);
  EXPECT_EQ(frames[3].frame.can_id, CAN_EFF_FLAG | 0x18ebff05);
  const auto got = events(frames);
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].first, 1U);
  EXPECT_EQ(got[0].second, counting(20));
  EXPECT_EQ(layer_->losses().too_long, 1U) << "for the other follower";
}

TEST_F(J1939LayerTest, MessagesOfOneSourceWaitForEachOther) {
  auto other = endpoint("j1939", CAN_EFF_FLAG | 0x18fecb05, kAllOfIt);
  auto elsewhere = endpoint("j1939", CAN_EFF_FLAG | 0x18feca06, kAllOfIt);
  other.fragmented = elsewhere.fragmented = true;
  ASSERT_TRUE(layer_->follow(1, at_, 1, 20));
  ASSERT_TRUE(layer_->follow(2, other, 2, 20));
  ASSERT_TRUE(layer_->follow(3, elsewhere, 1, 20));
  for (const auto& to : {at_, other, elsewhere})
    ASSERT_EQ(layer_->send(to, 1, counting(9 + (to == other ? 1 : 0))), Sent::sent);
  EXPECT_EQ(socket_->out_.size(), 2U) << "those of two sources are under way";
  const auto got = events(all_sent());
  ASSERT_EQ(got.size(), 3U);
  EXPECT_EQ(got[0].second, counting(9));
  EXPECT_EQ(got[2].first, 2U);
  EXPECT_EQ(got[2].second, counting(10));
}

TEST_F(J1939LayerTest, WhatCannotBeSentIsSaid) {
  EXPECT_EQ(layer_->send(at_, 1, counting(1786)), Sent::too_long);
  socket_->outcome_ = Sent::dropped;
  EXPECT_EQ(layer_->send(at_, 1, counting(20)), Sent::dropped) << "the announcement";
  EXPECT_EQ(layer_->losses().unsent, 0U);
  socket_->outcome_ = Sent::sent;
  time_now += j1939::kPause;
  EXPECT_EQ(layer_->send(at_, 1, counting(20)), Sent::sent);
  socket_->outcome_ = Sent::dropped;
  EXPECT_TRUE(all_sent().size() == 1U);
  EXPECT_EQ(layer_->losses().unsent, 1U) << "a packet";
  socket_->outcome_ = Sent::sent;
  for (std::size_t i = 0; i < j1939::Sending::kMostWaiting; ++i)
    EXPECT_EQ(layer_->send(at_, 1, counting(20)), Sent::sent);
  EXPECT_EQ(layer_->send(at_, 1, counting(20)), Sent::dropped) << "too many wait";
}

TEST_F(J1939LayerTest, AnOpenPriorityIsThatOfTheTransportProtocol) {
  const auto open = [](std::uint32_t id, std::uint32_t bits) {
    auto out = endpoint("j1939", CAN_EFF_FLAG | id, kAllOfIt & ~bits);
    out.fragmented = true;
    return out;
  };
  ASSERT_EQ(layer_->send(open(0x00feca05, 0x1c000000), 1, counting(9)), Sent::sent);
  EXPECT_EQ(socket_->out_[0].frame.can_id, CAN_EFF_FLAG | 0x1cecff05);
  ASSERT_EQ(layer_->send(open(0x18120006, 0xff00), 1, counting(9)), Sent::sent);
  EXPECT_EQ(socket_->out_[1].frame.can_id, CAN_EFF_FLAG | 0x18ecff06);
  EXPECT_EQ(socket_->out_[1].frame.data[6], 0x12);
  EXPECT_EQ(socket_->out_[1].frame.data[5], 0) << "the destination is not in the PGN";
}

TEST_F(J1939LayerTest, OnlyWhatIsFollowedIsPutTogether) {
  ASSERT_TRUE(layer_->follow(1, at_, 1, 20));
  EXPECT_EQ(socket_->filters_.size(), 3U) << "the PGN, announcements and packets of its source";
  auto other = endpoint("j1939", CAN_EFF_FLAG | 0x18fecb05, kAllOfIt);
  other.fragmented = true;
  ASSERT_EQ(layer_->send(other, 2, counting(20)), Sent::sent);
  EXPECT_TRUE(events(all_sent()).empty());
  EXPECT_EQ(layer_->losses().all(), 3U) << "those of the socket";
  // Another PGN that its source announces meanwhile is the end of the one before.
  ASSERT_EQ(layer_->send(at_, 1, counting(20)), Sent::sent);
  auto frames = all_sent();
  frames.insert(frames.begin() + 2,
                frame(CAN_EFF_FLAG | 0x18ecff05, {0x20, 9, 0, 2, 0xff, 0xcb, 0xfe, 0}));
  EXPECT_TRUE(events(frames).empty());
  EXPECT_EQ(layer_->losses().incomplete, 1U);
  ASSERT_TRUE(layer_->follow(2, other, 2, 20));
  EXPECT_EQ(socket_->filters_.size(), 4U) << "one more PGN of the source";
  layer_->leave(1, at_, 1);
  EXPECT_EQ(socket_->filters_.size(), 3U);
  layer_->leave(2, other, 2);
  EXPECT_TRUE(socket_->filters_.empty());
}

TEST(Alarm, CanBeReadWhenTheTimeHasComeOrTheSocketCan) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const Fd from(ends[0]);
  const Fd to(ends[1]);
  const auto alarm = Alarm::beside(from.get());
  ASSERT_TRUE(alarm);
  const auto ready = [&](int wait) {
    pollfd one{.fd = (*alarm)->fd(), .events = POLLIN, .revents = 0};
    return ::poll(&one, 1, wait) == 1;
  };
  EXPECT_FALSE(ready(0));
  (*alarm)->set(0);
  EXPECT_TRUE(ready(-1)) << "a time that has been";
  (*alarm)->set(monotonic_ns() + 3'600'000'000'000);
  EXPECT_FALSE(ready(0));
  (*alarm)->set(monotonic_ns() + 1'000'000);
  EXPECT_TRUE(ready(-1));
  (*alarm)->set(std::nullopt);
  EXPECT_FALSE(ready(0));
  ASSERT_EQ(::write(to.get(), "", 1), 1);
  EXPECT_TRUE(ready(-1));
}

TEST_F(CanLayerTest, PaddingOfFdFramesIsNotOfTheEvent) {
  for (const char* profile : {"raw", "cyphal"}) {
    auto at = endpoint(profile);
    at.classic = false;
    at.fd = true;
    at.frame_bytes = 64;
    at.fragmented = profile == std::string("cyphal");
    for (const std::size_t size : {std::size_t{9}, std::size_t{33}, std::size_t{70}}) {
      if (size > 64 && !at.fragmented) continue;
      ASSERT_TRUE(layer_->follow(1, at, 1, size));
      ASSERT_EQ(layer_->send(at, 1, counting(size)), Sent::sent);
      const auto got = events(std::exchange(socket_->out_, {}));
      ASSERT_EQ(got.size(), 1U) << profile << ' ' << size;
      EXPECT_EQ(got[0].second, counting(size));
      layer_->leave(1, at, 1);
    }
  }
}

TEST_F(CanLayerTest, AnFdFrameHasOneOfItsLengths) {
  auto to = endpoint("raw");
  to.classic = false;
  to.fd = true;
  to.frame_bytes = 64;
  ASSERT_EQ(layer_->send(to, 1, counting(13)), Sent::sent);
  EXPECT_TRUE(socket_->out_[0].fd);
  EXPECT_EQ(socket_->out_[0].frame.len, 16);
  EXPECT_EQ(layer_->send(to, 1, counting(65)), Sent::too_long);
}

TEST_F(CanLayerTest, WhatCannotBeCarriedIsRefusedWithTheReason) {
  auto long_events = endpoint("raw");
  long_events.fragmented = true;
  const auto refused = layer_->follow(1, long_events, 1, 100);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text,
            "events of several frames are not carried on buses of profile raw, as bus is one");
  EXPECT_EQ(layer_->send(long_events, 1, counting(1)), Sent::failed);
  long_events.profile = "j1939";
  long_events.classic = false;
  long_events.fd = true;
  EXPECT_FALSE(layer_->follow(1, long_events, 1, 100)) << "the transport protocol is not for FD";
}

TEST_F(CanLayerTest, TheSocketLetsThroughWhatIsFollowed) {
  ASSERT_TRUE(layer_->follow(1, endpoint("raw", 0x1, 0xc00007ff), 1, 8));
  ASSERT_TRUE(layer_->follow(2, endpoint("raw", 0x1, 0xc00007ff), 1, 8));
  ASSERT_EQ(socket_->filters_.size(), 1U);
  EXPECT_EQ(socket_->filters_[0].can_id, 1U);
  EXPECT_EQ(socket_->filters_[0].can_mask, 0xc00007ffU);
  layer_->leave(1, endpoint("raw", 0x1, 0xc00007ff), 1);
  EXPECT_EQ(socket_->filters_.size(), 1U);
  layer_->leave(2, endpoint("raw", 0x1, 0xc00007ff), 1);
  EXPECT_TRUE(socket_->filters_.empty());
  // One socket has 512 filters: with more channels all frames come.
  for (std::uint32_t i = 0; i < 513; ++i)
    ASSERT_TRUE(layer_->follow(i, endpoint("raw", i, 0xc00007ff), 1, 8));
  ASSERT_EQ(socket_->filters_.size(), 1U);
  EXPECT_EQ(socket_->filters_[0].can_mask, 0U);
  EXPECT_EQ(events({frame(0x1ff, {1}), frame(0x7ff, {1})}).size(), 1U);
  layer_->leave(512, endpoint("raw", 512, 0xc00007ff), 1);
  EXPECT_EQ(socket_->filters_.size(), 512U);
}

TEST_F(CanLayerTest, AnInterfaceThatIsGoneAndAQueueThatIsFullAreSaid) {
  socket_->gone_ = true;
  EXPECT_FALSE(layer_->receive(1, [](const auto&) {}));
  socket_->outcome_ = Sent::dropped;
  EXPECT_EQ(layer_->send(endpoint("famouso"), 1, counting(20)), Sent::dropped);
}

}  // namespace
}  // namespace mlcca::relay
