// SPDX-License-Identifier: BSD-2-Clause
// Two gateways with complete daemons on benches that share a bus by a store.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/daemon/gateway/bench.hpp"
#include "tests/daemon/gateway/fake_store.hpp"

namespace mlcca::test {

inline constexpr std::uint64_t kSecondNs = 1'000'000'000;
inline constexpr std::uint64_t kStepNs = 100'000'000;
inline constexpr std::uint64_t kLease = 10 * kSecondNs;
inline constexpr std::size_t kSharedBus = 0;

inline AttributeSet each(Value period, Value deadline = 400 * kMs) {
  return AttributeSet{}
      .set(Attribute::period, period)
      .set(Attribute::max_payload, 8)
      .set(Attribute::deadline, deadline);
}

inline core::Network some_bus(const std::string& name) {
  core::Network out;
  out.name = name;
  out.profile = core::Profile::raw;
  out.bus.bitrate = 125'000;
  out.provision.set(Attribute::max_payload, 8);
  return out;
}

/// "shared" is a bus of g0 and g1; "own0" and "own1" are of one each. c0 goes from own0 to shared,
/// c1 from own0 to programs on g0, as described; nobody uses the others.
inline core::System two_gateways() {
  core::System system;
  system.name = "pair";
  for (const char* name : {"shared", "own0", "own1"}) system.networks.push_back(some_bus(name));
  for (std::size_t g = 0; g < 2; ++g) {
    core::Gateway gateway;
    gateway.name = "g" + std::to_string(g);
    gateway.provision.set(Attribute::latency, kMs).set(Attribute::jitter, kMs);
    for (const std::size_t n : {kSharedBus, 1 + g}) {
      core::Port port;
      port.network = n;
      port.identity.name = system.networks[n].name;
      port.queue_length = 40;
      gateway.ports.push_back(port);
    }
    system.gateways.push_back(gateway);
  }
  for (std::size_t c = 0; c < 6; ++c) {
    core::EventChannel channel;
    channel.name = "c" + std::to_string(c);
    channel.subject = c + 1;
    channel.attributes = each(50 * kMs);
    system.channels.push_back(channel);
    for (core::Network& n : system.networks) {
      core::Binding binding;
      binding.channel = c;
      binding.id = static_cast<std::uint32_t>(0x10 + c);
      n.bindings.push_back(binding);
    }
  }
  for (std::size_t c = 0; c < 2; ++c) {
    core::Publisher p;
    p.name = "p" + std::to_string(c);
    p.channel = c;
    p.place = {core::Place::Kind::network, 1};
    p.attributes = each(50 * kMs);
    system.publishers.push_back(p);
    core::Subscriber s;
    s.name = "s" + std::to_string(c);
    s.channel = c;
    s.place = c == 0 ? core::Place{core::Place::Kind::network, kSharedBus}
                     : core::Place{core::Place::Kind::gateway, 0};
    s.attributes = each(50 * kMs);
    system.subscribers.push_back(s);
  }
  return system;
}

/// The same with a described publisher of c2 on own0, and no subscriber of it.
inline core::System with_a_described_publisher() {
  core::System system = two_gateways();
  core::Publisher p;
  p.name = "p2";
  p.channel = 2;
  p.place = {core::Place::Kind::network, 1};
  p.attributes = each(50 * kMs);
  system.publishers.push_back(p);
  return system;
}

/// Somebody on the own bus of a gateway sends to somebody on another one.
inline control::Admit wanted(const std::string& channel, const std::string& from,
                             const std::string& to) {
  control::Admit request;
  request.channel = channel;
  request.from = from;
  request.to = to;
  request.publisher = "new";
  request.subscriber = "late";
  request.key = channel + from;
  return request;
}

inline control::Attribute attribute_of(const std::string& name, std::uint64_t value) {
  control::Attribute out;
  out.name = name;
  out.value = value;
  return out;
}

class MembershipBench : public testing::Test {
 protected:
  struct Node {
    Node(FakeStore& store, std::size_t self, const core::System& system)
        : bench(system), link(store, bench.clock) {
      bench.self = self;
      bench.cluster = &link;
      bench.lease_ns = kLease;
      bench.digest = 1;
    }
    Bench bench;
    FakeLink link;
    std::vector<std::uint64_t> ready;  ///< sessions
    bool hangs = false;                ///< its daemon does nothing, and its kernel goes on
  };

  explicit MembershipBench(const core::System& system = two_gateways()) {
    for (std::size_t g = 0; g < 2; ++g) nodes.push_back(std::make_unique<Node>(store, g, system));
  }

  void start(std::size_t g) {
    ASSERT_FALSE(at(g).start());
    at(g).daemon().on_slice(
        [this, g](std::uint64_t session) { nodes[g]->ready.push_back(session); });
  }
  void start_both() {
    start(0);
    start(1);
    pass(4 * kSecondNs);
  }
  Bench& at(std::size_t g) { return nodes[g]->bench; }
  FakeLink& link(std::size_t g) { return nodes[g]->link; }

  /// Until nothing is to be done now.
  void run() {
    for (bool more = true; more;) {
      more = false;
      for (auto& node : nodes) {
        if (!node->bench.runs() || node->hangs) continue;
        more = node->link.deliver() || more;
        const std::size_t sent = node->link.sent.size();
        node->bench.act();
        if (finish_reading && node->bench.reading().busy()) {
          node->bench.reading().finish();
          more = true;
        }
        more = more || (node->link.answers && node->link.sent.size() != sent);
      }
    }
  }
  void pass(std::uint64_t time) {
    for (std::uint64_t gone = 0; gone < time; gone += kStepNs) {
      for (auto& node : nodes) {
        node->bench.clock.monotonic += kStepNs;
        node->bench.kernel.advance_to(node->bench.clock.monotonic);
        if (!node->bench.runs() || node->hangs) continue;
        node->bench.daemon().beat();
        if (gone % kSecondNs == 0) node->bench.round();
      }
      run();
    }
  }

  /// What it is answered in the end.
  std::string asked(std::size_t g, control::Admit request, const serve::Peer& peer = member()) {
    auto answer = at(g).ask(std::move(request), peer);
    run();
    return text_of(answer);
  }
  static std::string text_of(serve::Answer& answer) {
    auto body = answer.reply.body;
    if (answer.slices) {
      const auto slice = answer.slices();
      if (!slice) return "nothing yet";
      body = slice->body;
    }
    if (const auto* error = std::get_if<control::Error>(&body)) return error->message;
    const auto* channels = std::get_if<control::Channels>(&body);
    if (channels == nullptr || channels->channels.empty()) return "something else";
    const control::Channel& first = channels->channels.front();
    return first.granted ? "granted" : first.reason;
  }

  bool granted(std::size_t g, std::size_t channel) {
    return at(g).state().decisions()[channel].granted != 0;
  }
  /// Rules that pass frames of a channel out on the shared bus.
  bool passes(std::size_t g, std::size_t channel) {
    const auto* const found = at(g).kernel.interfaces.contains("shared")
                                  ? &at(g).kernel.interfaces.at("shared")
                                  : nullptr;
    if (found == nullptr || !at(g).kernel.passes()) return false;
    return std::ranges::any_of(at(g).kernel.gates.at(found->ifindex).rules, [&](const auto& one) {
      return one.first.subject == channel + 1 && one.second.pass;
    });
  }
  [[nodiscard]] std::size_t entries(const std::string& kind) const {
    std::size_t n = 0;
    for (const auto& [key, entry] : store.entries)
      if (key.starts_with("/mlcca/pair/" + kind)) ++n;
    return n;
  }

  bool finish_reading = false;  ///< what is read beside the loop is there at once
  FakeStore store;
  std::vector<std::unique_ptr<Node>> nodes;
};

}  // namespace mlcca::test
