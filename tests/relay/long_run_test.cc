// SPDX-License-Identifier: BSD-2-Clause
// An hour of mixed traffic, in fast-forward: fragments and transfers of many senders over networks
// that lose, double and reorder, nodes and subscribers that come and go. What is kept does not
// grow.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "relay/afp.hpp"
#include "relay/cyphal.hpp"
#include "relay/famouso/node_numbers.hpp"
#include "relay/famouso/subscriptions.hpp"
#include "tests/relay/famouso/node_client.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint64_t kStep = 20'000'000;  // ns between two events of a sender
constexpr std::uint64_t kMinute = 60'000'000'000;
constexpr std::uint64_t kHour = 60 * kMinute;
constexpr std::size_t kSenders = 20;

using Bytes = std::vector<std::uint8_t>;

/// What a network does to frames: of a hundred it loses 3, doubles 5, and swaps 10 with the next.
class Network {
 public:
  explicit Network(std::mt19937& random) : random_(random) {}
  void put(Bytes frame, bool reorders) {
    const auto fate = static_cast<unsigned>(random_() % 100);
    if (fate < 3) return;
    if (fate < 8) frames_.push_back(frame);
    frames_.push_back(std::move(frame));
    if (reorders && fate < 18 && frames_.size() > 1)
      std::swap(frames_.back(), frames_[frames_.size() - 2]);
  }
  std::vector<Bytes> take() { return std::exchange(frames_, {}); }

 private:
  std::mt19937& random_;
  std::vector<Bytes> frames_;
};

class Traffic {
 public:
  void go_on_until(std::uint64_t end) {
    for (; now_ < end; now_ += kStep) {
      const auto sender = static_cast<std::uint32_t>(random_() % kSenders);
      fragments_of_can(sender);
      datagrams(sender);
      transfers(sender);
      if (random_() % 50 == 0) subscribers(sender);
      if (random_() % 500 == 0) a_node_joins();
    }
  }

  [[nodiscard]] std::uint64_t events() const { return events_; }
  [[nodiscard]] std::uint64_t wrong() const { return wrong_; }
  [[nodiscard]] std::size_t nodes() const { return broker_.dealt().size(); }
  /// What all of it keeps, octets and things.
  [[nodiscard]] std::vector<std::size_t> kept() const {
    return {on_can_.begun(),     on_can_.octets(),      on_udp_.begun(),
            on_udp_.octets(),    on_udp_.remembered(),  on_cyphal_.sources(),
            on_cyphal_.octets(), subscriptions_.peers()};
  }

 private:
  Bytes event_of(std::size_t most) {
    Bytes out(1 + random_() % most);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(i + out.size());
    return out;
  }
  /// Whole and as it was sent, or not at all.
  void arrived(const Bytes& event) {
    ++events_;
    for (std::size_t i = 0; i < event.size(); ++i)
      if (event[i] != static_cast<std::uint8_t>(i + event.size())) {
        ++wrong_;
        return;
      }
  }
  void fragments_of_can(std::uint32_t sender) {
    const Bytes event = event_of(200);
    auto fragments = afp::Fragments::of(afp::kCan, event);
    while (auto fragment = fragments->next()) network_.put(std::move(*fragment), false);
    for (const Bytes& frame : network_.take())
      if (const auto whole = on_can_.take(sender, frame, now_)) ++events_;
  }
  void datagrams(std::uint32_t sender) {
    const Bytes event = event_of(30'000);
    auto fragments = afp::Fragments::of(afp::kUdp, event, number_++);
    while (auto fragment = fragments->next()) network_.put(std::move(*fragment), true);
    for (const Bytes& frame : network_.take())
      if (const auto whole = on_udp_.take(sender, frame, now_)) arrived(*whole);
  }
  void transfers(std::uint32_t sender) {
    const Bytes event = event_of(100);
    const auto frames = cyphal::frames_of(event, 8, number_ & cyphal::kNumbers);
    for (const Bytes& frame : *frames) network_.put(frame, false);
    for (const Bytes& frame : network_.take())
      if (const auto whole = on_cyphal_.take(sender, frame, now_)) arrived(*whole);
  }
  void subscribers(std::uint32_t sender) {
    Subscription message{
        .kind = random_() % 4 == 0 ? Subscription::Kind::end : Subscription::Kind::subscribe,
        .subject = 1 + random_() % 8,
        .number = sender};
    message.lease_s = 20;
    subscriptions_.receive("bus", "node-" + std::to_string(random_() % 200), encode(message), now_);
    subscriptions_.turn(now_);
    for (const std::uint64_t asked : std::exchange(asked_, {})) {
      control::Channels answer;
      answer.channels.emplace_back();
      answer.channels.back().granted = random_() % 3 != 0;
      subscriptions_.answered(asked, {0, answer}, now_);
    }
  }
  /// Some begin and stop in the middle.
  void a_node_joins() {
    NodeClient client({1, 2, static_cast<std::uint8_t>(random_() % 250), 4, 5, 6, 7, 8});
    std::optional<Frame> request = client.start(now_);
    for (auto stage = random_() % 20; request && stage > 0; --stage) {
      const auto answer = broker_.take(*request, now_);
      request = answer ? client.take(*answer, now_) : std::nullopt;
    }
    static_cast<void>(broker_.expire(now_ + kStep));
  }

  std::mt19937 random_{2026};
  Network network_{random_};
  std::uint64_t now_ = 1;
  std::uint32_t number_ = 0;
  std::uint64_t events_ = 0;
  std::uint64_t wrong_ = 0;
  afp::Reassembly on_can_{afp::kCan};
  afp::Reassembly on_udp_{afp::kUdp};
  cyphal::Reassembly on_cyphal_;
  NodeBroker broker_{{1}};
  std::vector<std::uint64_t> asked_;
  std::uint64_t last_ = 0;
  Subscriptions subscriptions_{{.send = [](const std::string&, Octets) {},
                                .ask =
                                    [this](const control::SubscribeRequest&) {
                                      asked_.push_back(++last_);
                                      return last_;
                                    },
                                .report = [](const control::RefusalRequest&) {},
                                .log = [](const std::string&) {},
                                .random = [] { return 7U; }}};
};

TEST(LongRunTest, AnHourOfMixedTrafficKeepsNoMoreThanItsFirstMinutes) {
  Traffic traffic;
  traffic.go_on_until(5 * kMinute);
  std::vector<std::size_t> most = traffic.kept();
  for (std::uint64_t at = 6 * kMinute; at <= 10 * kMinute; at += kMinute) {
    traffic.go_on_until(at);
    const auto now = traffic.kept();
    for (std::size_t i = 0; i < most.size(); ++i) most[i] = std::max(most[i], now[i]);
  }
  const std::size_t heap = ::mallinfo2().uordblks;
  traffic.go_on_until(kHour);
  EXPECT_GT(traffic.events(), 100'000U);
  EXPECT_EQ(traffic.wrong(), 0U);
  const auto now = traffic.kept();
  EXPECT_LE(traffic.nodes(), 127U);  // they keep their numbers for ever
  // Each fluctuates; none of them grows with time, six times as long.
  for (std::size_t i = 0; i < most.size(); ++i) EXPECT_LE(now[i], 2 * most[i] + 8) << "part " << i;
  // All numbers are memory by which nothing else grows. Under a sanitizer it says 0.
  EXPECT_LE(::mallinfo2().uordblks, heap + (std::size_t{1} << 20U));
}

}  // namespace
}  // namespace mlcca::relay
