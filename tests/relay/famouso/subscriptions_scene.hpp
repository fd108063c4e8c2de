// SPDX-License-Identifier: BSD-2-Clause
// Subscriptions of a gateway among peers, a daemon and other gateways that are none.
#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "relay/famouso/subscriptions.hpp"

namespace mlcca::relay {

using Kind = Subscription::Kind;

inline constexpr std::uint64_t kDistance = 0x44697374616e6365;
inline constexpr std::uint64_t kSecond = 1'000'000'000;

/// Two networks, a bus and a lan, between which events go.
class SubscriptionsTest : public ::testing::Test {
 protected:
  struct Sent {
    std::string network;
    Subscription message;
  };

  SubscriptionsTest() {
    for (const char* name : {"bus", "lan"}) {
      said_.networks.emplace_back();
      said_.networks.back().network = name;
      said_.networks.back().most = 4;
    }
    subscriptions_.set(said_, 0);
  }

  static control::Reply granted() {
    control::Channels out;
    out.channels.emplace_back();
    out.channels.back().granted = true;
    return {0, std::move(out)};
  }
  static control::Reply refused(const std::string& why) {
    control::Channels out;
    out.channels.emplace_back();
    out.channels.back().from = "lan";
    out.channels.back().to = "bus";
    out.channels.back().reason = why;
    return {0, std::move(out)};
  }
  static Subscription wanted(std::uint32_t number, Value latency = 10'000'000) {
    Subscription out{
        .kind = Kind::subscribe, .subject = kDistance, .number = number, .lease_s = 60, .hops = 8};
    out.required.set(Attribute::latency, latency);
    return out;
  }
  void come(const std::string& source, const Subscription& message, std::uint64_t now = 0,
            const std::string& network = "bus") {
    subscriptions_.receive(network, source, encode(message), now);
  }
  /// The daemon answers what it was asked first.
  void answer(const control::Reply& reply, std::uint64_t now = 0) {
    ASSERT_FALSE(open_.empty());
    const std::uint64_t number = open_.front();
    open_.erase(open_.begin());
    subscriptions_.answered(number, reply, now);
  }
  std::vector<Sent> take_sent() { return std::exchange(sent_, {}); }
  /// What was sent to the network, in words.
  std::vector<std::string> told(const std::string& network) {
    std::vector<std::string> out;
    for (const Sent& one : take_sent()) {
      const bool no = one.message.kind == Kind::refused;
      if (one.network == network && (no || one.message.kind == Kind::granted))
        out.push_back(std::to_string(one.message.number) +
                      (no ? " refused: " + one.message.reason : " granted"));
    }
    return out;
  }
  /// The number of our latest subscription on the lan; 0: none was sent.
  std::uint32_t sent_on_lan() {
    std::uint32_t number = 0;
    for (const Sent& one : take_sent())
      if (one.network == "lan" && one.message.kind == Kind::subscribe) number = one.message.number;
    return number;
  }
  /// A peer on the bus that the daemon grants it; then there is this to pass on.
  std::uint32_t subscribe_and_pass_on(const std::string& source, std::uint32_t number,
                                      Value latency, std::uint64_t now = 0) {
    come(source, wanted(number, latency), now);
    answer(granted(), now);
    say_onward(latency);
    subscriptions_.set(said_, now);
    return sent_on_lan();
  }
  void answer_further_on(Kind kind, std::uint32_t number, const std::string& reason = "",
                         const std::string& source = "192.0.2.9", std::uint64_t now = 0) {
    Subscription message{.kind = kind, .subject = kDistance, .number = number};
    message.reason = reason;
    come(source, message, now, "lan");
  }
  void say_onward(Value latency, bool begins_here = false) {
    said_.onward.clear();
    control::OnwardSubscription one;
    one.subject = kDistance;
    one.channel = "distance";
    one.network = "lan";
    one.begins_here = begins_here;
    one.required.push_back({.name = "Latency", .value = latency, .unit = {}, .dynamic = false});
    said_.onward.push_back(one);
  }

  control::Subscriptions said_;
  std::vector<control::SubscribeRequest> asked_;
  std::vector<std::uint64_t> open_;
  std::vector<Sent> sent_;
  std::vector<control::RefusalRequest> reports_;
  std::vector<std::string> log_;
  bool connected_ = true;
  Subscriptions subscriptions_{
      {.send =
           [this](const std::string& network, Octets event) {
             const auto message = parse_subscription(event);
             ASSERT_TRUE(message);
             sent_.push_back({network, *message});
           },
       .ask = [this](control::SubscribeRequest request) -> std::uint64_t {
         if (!connected_) return 0;
         asked_.push_back(std::move(request));
         open_.push_back(asked_.size());
         return asked_.size();
       },
       .report =
           [this](control::RefusalRequest request) { reports_.push_back(std::move(request)); },
       .log = [this](const std::string& line) { log_.push_back(line); },
       .random = [] { return 77U; }}};
};

}  // namespace mlcca::relay
