// SPDX-License-Identifier: BSD-2-Clause
// Two gateways: g0 has admitted a publisher, and g1 subscribers of it on networks of its own.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/daemon/gateway/members_forged.hpp"

namespace mlcca::test {

inline constexpr std::size_t kThirdChannel = 3;
inline constexpr const char* kBusy = "it is busy";

/// g1 has another bus of its own, own2.
inline core::System with_a_third_bus() {
  core::System system = with_a_described_publisher();
  core::Network bus = some_bus("own2");
  bus.bindings = system.networks.back().bindings;
  system.networks.push_back(bus);
  core::Port port;
  port.network = system.networks.size() - 1;
  port.identity.name = bus.name;
  port.queue_length = 40;
  system.gateways[1].ports.push_back(port);
  return system;
}

class MembersPassing : public MembershipBench {
 protected:
  MembersPassing() : MembershipBench(with_a_third_bus()) {}

  static control::Admit subscriber(const std::string& to) {
    control::Admit request = subscriber_on_own1("c3", "on-" + to);
    request.to = to;
    request.key = to;
    return request;
  }
  /// Frames of c3 pass out on that network of g1.
  bool passes_on(const std::string& network) {
    const auto found = at(1).kernel.interfaces.find(network);
    if (found == at(1).kernel.interfaces.end() || !at(1).kernel.passes()) return false;
    return std::ranges::any_of(
        at(1).kernel.gates.at(found->second.ifindex).rules, [](const auto& one) {
          return one.first.subject == kThirdChannel + 1 &&
                 one.first.direction == core::Direction::egress && one.second.pass;
        });
  }
  /// The entries by which g1 has asked g0 for the subscriber on that network.
  std::vector<std::string> entries_for(const std::string& network) {
    std::vector<std::string> all;
    for (const auto& [name, entry] : store.entries) {
      if (!name.starts_with("/mlcca/pair/x/g1/")) continue;
      const auto asked = codec.asked(entry.value);
      const auto text = asked ? cluster::asked_in(asked->admission) : std::nullopt;
      if (text && std::get<control::Admit>(text->requests.front().body).to == network)
        all.push_back(name);
    }
    return all;
  }
  void vote(const std::string& network, const core::cluster::Vote& vote) {
    for (const std::string& name : entries_for(network))
      store.write({{.key = "/mlcca/pair/a/g0/g1/" + name.substr(name.rfind('/') + 1),
                    .value = codec.write(core::cluster::VoteOf{
                        .asked = store.entries.at(name).create, .vote = vote})}});
    run();
  }
  /// g0 does not agree any more to what g1 has asked for.
  void refuse(const std::string& network, bool final = false) {
    vote(network, {.ok = false, .hop = {}, .reason = kBusy, .final = final});
  }
  /// As g0 writes it each second, whatever its process does.
  void beat_of_g0(core::cluster::Role role = core::cluster::Role::active) {
    const auto& was = store.entries.at("/mlcca/pair/m/g0");
    auto beat = codec.beat(was.value).value_or(core::cluster::Beat{});
    if (beat.incarnation == 0) beat.incarnation = was.create;
    ++beat.seq;
    beat.role = role;
    beat.applied = store.revision;
    store.write({{.key = "/mlcca/pair/m/g0", .value = codec.write(beat)}});
  }
  std::size_t journalled(std::size_t g) { return at(g).recorded(random_).admissions.size(); }
  std::size_t said(std::size_t g, const std::string& text) {
    return static_cast<std::size_t>(
        std::ranges::count_if(at(g).published, [&](const control::Event& event) {
          return event.message.find(text) != std::string::npos;
        }));
  }
  std::string all_said(std::size_t g) {
    std::string all;
    for (const control::Event& event : at(g).published) all += event.message + '\n';
    return all;
  }
  void admit_publisher() {
    start_both();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  }
  void admit_both() {
    admit_publisher();
    ASSERT_EQ(asked(1, subscriber("own1")), "granted");
    ASSERT_TRUE(passes_on("own1"));
  }
  void end_all() {
    for (const auto& [g, name] :
         {std::pair<std::size_t, const char*>{1, "own1"}, {1, "own2"}, {0, "c3own0"}})
      at(g).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = name});
    pass(4 * kSecondNs);
    for (const char* kind : {"r/", "x/", "a/"}) EXPECT_EQ(entries(kind), 0U) << kind;
    for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(at(g).state().admissions().empty()) << g;
  }

  cluster::RecordCodec codec{with_a_third_bus(), core::cluster::Digest{1}};
  std::mt19937 random_;
};

}  // namespace mlcca::test
