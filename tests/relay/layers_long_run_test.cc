// SPDX-License-Identifier: BSD-2-Clause
// An hour of the relay in fast-forward: a bus of each profile, a UDP network and a radio, channels
// that come and go with other subjects each time, frames that are lost and doubled. What is kept
// does not grow.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "relay/carrier.hpp"
#include "relay/cyphal.hpp"
#include "relay/j1939.hpp"
#include "relay/layers/can_layer.hpp"
#include "relay/layers/udp_layer.hpp"
#include "relay/layers/wpan_layer.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint64_t kTick = 20'000'000;  // ns
constexpr std::uint64_t kOneMinute = 60'000'000'000;

std::uint64_t hour_now = 1;
std::uint64_t now_of_hour() { return hour_now; }

/// Buses, a UDP network and a radio, by interface. What one sends is gone.
using Where = std::uint32_t;
constexpr Where kFamousoBus = 1;
constexpr Where kJ1939Bus = 2;
constexpr Where kCyphalBus = 3;
constexpr Where kRawBus = 4;
constexpr Where kAir = 5;
constexpr Where kLan = 6;

struct Wire {
  std::deque<FrameSocket::Frame> frames;
  std::deque<WpanSocket::Frame> radio;
  std::deque<std::vector<std::uint8_t>> datagrams;
  std::set<std::uint32_t> groups;  ///< that are joined
  std::uint64_t sent = 0;
};

class WireSocket : public FrameSocket {
 public:
  explicit WireSocket(Wire& wire) : wire_(wire) {}
  [[nodiscard]] int fd() const override { return -1; }
  [[nodiscard]] Result<void> filter(const std::vector<can_filter>& /*filters*/) override {
    return {};
  }
  Got receive(Frame& to) override {
    if (wire_.frames.empty()) return Got::nothing;
    to = wire_.frames.front();
    wire_.frames.pop_front();
    return Got::frame;
  }
  Sent send(const canfd_frame& /*frame*/, bool /*fd*/) override {
    return ++wire_.sent % 50 == 0 ? Sent::dropped : Sent::sent;
  }
  [[nodiscard]] std::uint64_t dropped() const override { return 0; }

 private:
  Wire& wire_;
};

class WireRadio : public WpanSocket {
 public:
  explicit WireRadio(Wire& wire) : wire_(wire) {}
  [[nodiscard]] int fd() const override { return -1; }
  Got receive(Frame& to) override {
    if (wire_.radio.empty()) return Got::nothing;
    to = wire_.radio.front();
    wire_.radio.pop_front();
    return Got::frame;
  }
  Sent send(Octets /*payload*/) override {
    ++wire_.sent;
    return Sent::sent;
  }
  [[nodiscard]] std::uint64_t dropped() const override { return 0; }

 private:
  Wire& wire_;
};

class WireLan : public UdpSocket {
 public:
  explicit WireLan(Wire& wire) : wire_(wire) {}
  [[nodiscard]] int fd() const override { return -1; }
  [[nodiscard]] Result<void> join(std::uint32_t group) override {
    EXPECT_TRUE(wire_.groups.insert(group).second) << "joined twice";
    return {};
  }
  void leave(std::uint32_t group) override {
    EXPECT_EQ(wire_.groups.erase(group), 1U) << "left, and not joined";
  }
  Got receive(Datagram& to) override {
    if (wire_.datagrams.empty()) return Got::nothing;
    latest_ = std::move(wire_.datagrams.front());
    wire_.datagrams.pop_front();
    to.octets = latest_;
    to.from = 0xc0000200 | (latest_.size() & 0xfU);
    to.unix_ns = hour_now;
    return Got::datagram;
  }
  void read_errors() override {}
  Sent send(std::uint32_t /*to*/, Octets /*header*/, Octets /*data*/) override {
    return ++wire_.sent % 50 == 0 ? Sent::dropped : Sent::sent;
  }
  [[nodiscard]] std::uint32_t own_address() const override { return 0; }
  [[nodiscard]] std::uint64_t dropped() const override { return 0; }

 private:
  Wire& wire_;
  std::vector<std::uint8_t> latest_;
};

control::Endpoint on_bus(Where where, std::uint32_t id) {
  static constexpr std::array names{"", "famouso", "j1939", "cyphal", "raw"};
  control::Endpoint out;
  out.ifindex = where;
  out.interface = "can" + std::to_string(where);
  out.can = true;
  out.profile = names.at(where);
  out.id = id;
  out.mask = 0x9fffffff;
  out.classic = out.fragmented = true;
  out.frame_bytes = 8;
  if (where == kRawBus) out.fragmented = false;
  return out;
}
control::Endpoint on_air() {
  control::Endpoint out;
  out.ifindex = kAir;
  out.interface = "wpan0";
  out.wpan = true;
  out.frame_bytes = 102;
  return out;
}

control::Endpoint on_lan() {
  control::Endpoint out;
  out.ifindex = kLan;
  out.interface = "eth0";
  return out;
}

class Hour {
 public:
  void go_on_until(std::uint64_t end) {
    for (; hour_now < end; hour_now += kTick) {
      const auto channel = static_cast<std::uint32_t>(random_() % kChannels);
      famouso(channel);
      message(channel);
      transfer(channel);
      wires_[kRawBus].frames.push_back(frame(0x80000700 | channel, {1, 2, 3}));
      air(channel);
      lan(channel);
      for (const Where where : {kFamousoBus, kJ1939Bus, kCyphalBus, kRawBus, kAir, kLan})
        for (int i = 0; i < 4; ++i) carrier_.receive(where);
      if (hour_now / kTick % 50 == 0) {
        carrier_.expire();
        carrier_.take_delays(hour_now, 10'000'000'000, [](const auto&, const auto&) {});
      }
      if (random_() % 40 == 0) another_channel(channel);
    }
  }
  [[nodiscard]] std::uint64_t carried() const {
    std::uint64_t sum = gone_;
    carrier_.each([&](const auto&, const Carried& one) { sum += one.events; });
    return sum;
  }
  [[nodiscard]] std::size_t transfers() const { return carrier_.transfers(); }
  [[nodiscard]] std::size_t groups() const { return wires_[kLan].groups.size(); }

 private:
  static constexpr std::uint32_t kChannels = 16;

  static FrameSocket::Frame frame(std::uint32_t id, const std::vector<std::uint8_t>& data) {
    FrameSocket::Frame out;
    out.frame.can_id = id;
    out.frame.len = static_cast<std::uint8_t>(data.size());
    std::ranges::copy(data, std::begin(out.frame.data));
    out.unix_ns = hour_now;
    return out;
  }
  /// Of a hundred frames 3 are lost and 5 come twice.
  template <class Frame>
  void put(std::deque<Frame>& to, const Frame& one) {
    const auto fate = random_() % 100;
    if (fate < 3) return;
    to.push_back(one);
    if (fate < 8) to.push_back(one);
  }
  void put(Where where, const FrameSocket::Frame& one) { put(wires_[where].frames, one); }
  std::vector<std::uint8_t> event_of(std::size_t least, std::size_t most) {
    return std::vector<std::uint8_t>(least + random_() % (most - least), 7);
  }
  void famouso(std::uint32_t channel) {
    const auto event = event_of(9, 200);
    auto fragments = afp::Fragments::of(afp::kCan, event);
    while (const auto fragment = fragments->next())
      put(kFamousoBus, frame(famouso_id(channel) | 1U << 21U, *fragment));
  }
  void message(std::uint32_t channel) {
    const auto event = event_of(9, 60);
    const std::uint32_t id = j1939_id(channel);
    bool is_first = true;
    for (const auto& data : j1939::frames_of(event, id)) {
      put(kJ1939Bus,
          frame(CAN_EFF_FLAG | (std::exchange(is_first, false) ? j1939::announcement_of(id)
                                                               : j1939::packet_of(id)),
                {data.begin(), data.end()}));
    }
  }
  void transfer(std::uint32_t channel) {
    const auto frames = cyphal::frames_of(event_of(9, 60), 8, number_++ & cyphal::kNumbers);
    for (const auto& data : *frames) put(kCyphalBus, frame(cyphal_id(channel), data));
  }
  void air(std::uint32_t channel) {
    WpanSocket::Frame one;
    one.size = 20;
    const std::uint64_t subject = subjects_.at(channel);
    for (unsigned i = 0; i < 8; ++i)
      one.payload.at(i) = static_cast<std::uint8_t>(subject >> (8 * (7 - i)));
    one.from = short_address(0xbeef, static_cast<std::uint16_t>(random_()));
    one.unix_ns = hour_now;
    wires_[kAir].radio.push_back(one);
  }

  /// One event of 50 is too long for a datagram.
  void lan(std::uint32_t channel) {
    const auto event = random_() % 50 == 0 ? event_of(9'000, 20'000) : event_of(9, 200);
    const auto add = [&](bool is_fragment, const auto& data) {
      const auto header = datagram_header(subjects_.at(channel), is_fragment);
      std::vector<std::uint8_t> datagram(header.begin(), header.end());
      datagram.insert(datagram.end(), data.begin(), data.end());
      put(wires_[kLan].datagrams, datagram);
    };
    if (event.size() <= afp::kUdp.payload) return add(false, event);
    auto fragments = afp::Fragments::of(afp::kUdp, event, fragmented_++);
    while (const auto fragment = fragments->next()) add(true, *fragment);
  }

  static std::uint32_t famouso_id(std::uint32_t channel) { return 0x9f414100 | channel; }
  static std::uint32_t j1939_id(std::uint32_t channel) {
    return CAN_EFF_FLAG | 0x18ff0000 | channel << 8U | channel;
  }
  static std::uint32_t cyphal_id(std::uint32_t channel) { return 0x90000007 | channel << 8U; }

  /// From each network to each of two others.
  void another_channel(std::uint32_t channel) {
    carrier_.each([&](const control::Transfer& transfer, const Carried& one) {
      if (transfer.subject == subjects_.at(channel)) gone_ += one.events;
    });
    carrier_.set(subjects_.at(channel), {});
    subjects_.at(channel) = random_() | std::uint64_t{1} << 32U;
    const std::array ends{on_bus(kFamousoBus, famouso_id(channel)),
                          on_bus(kJ1939Bus, j1939_id(channel)),
                          on_bus(kCyphalBus, cyphal_id(channel)),
                          on_bus(kRawBus, 0x80000700 | channel),
                          on_air(),
                          on_lan()};
    std::vector<control::Transfer> transfers;
    for (std::size_t from = 0; from < ends.size(); ++from)
      for (std::size_t to = 1; to <= 2; ++to) {
        control::Transfer& one = transfers.emplace_back();
        one.subject = subjects_.at(channel);
        one.channel = "channel " + std::to_string(channel);
        one.from = ends.at(from);
        one.to = ends.at((from + to) % ends.size());
        one.event_bytes = ends.at(from).ifindex == kLan ? 20'000 : 1'000;
        one.latency_ns = 1;
      }
    carrier_.set(subjects_.at(channel), transfers);
  }

  Result<std::unique_ptr<Layer>> open(const control::Endpoint& endpoint) {
    Wire& wire = wires_.at(endpoint.ifindex);
    if (endpoint.wpan)
      return std::unique_ptr<Layer>(new WpanLayer(std::make_unique<WireRadio>(wire)));
    if (!endpoint.can)
      return std::unique_ptr<Layer>(
          new UdpLayer(std::make_unique<WireLan>(wire), false, now_of_hour));
    return std::unique_ptr<Layer>(
        new CanLayer(std::make_unique<WireSocket>(wire), nullptr, now_of_hour));
  }

  std::mt19937_64 random_{2026};
  std::array<Wire, 7> wires_;
  std::array<std::uint64_t, kChannels> subjects_{};
  std::uint8_t number_ = 0;
  std::uint32_t fragmented_ = 0;
  std::uint64_t gone_ = 0;  ///< events of channels that are no more
  Carrier carrier_{{.open = [this](const auto& endpoint) { return open(endpoint); },
                    .watch = [](std::uint32_t, int) {},
                    .log = [](const std::string&) {},
                    .unix_ns = [] { return hour_now + 5; }}};
};

TEST(LongRunTest, AnHourOfTheLayersKeepsNoMoreThanItsFirstMinutes) {
  hour_now = 1;
  Hour hour;
  hour.go_on_until(10 * kOneMinute);
  const std::size_t heap = ::mallinfo2().uordblks;
  const std::uint64_t before = hour.carried();
  EXPECT_GT(before, 50'000U);
  hour.go_on_until(60 * kOneMinute);
  EXPECT_GT(hour.carried(), 5 * before);
  EXPECT_LE(hour.transfers(), 16U * 12);
  EXPECT_LE(hour.groups(), 16U + 64) << "those of the channels, and the latest of others";
  // All numbers are memory by which nothing else grows. Under a sanitizer it says 0.
  EXPECT_LE(::mallinfo2().uordblks, heap + (std::size_t{128} << 10U));
}

}  // namespace
}  // namespace mlcca::relay
