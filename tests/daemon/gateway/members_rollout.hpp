// SPDX-License-Identifier: BSD-2-Clause
// Two gateways that roll out a description: 1 is in force, 2 and 3 are the same with one channel
// more, 4 has another name.
#pragma once
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {

/// The same with c5 from own0 to the shared bus.
inline core::System grown_system() {
  core::System system = two_gateways();
  core::Publisher p = system.publishers.front();
  p.name = "p5";
  p.channel = 5;
  system.publishers.push_back(p);
  core::Subscriber s = system.subscribers.front();
  s.name = "s5";
  s.channel = 5;
  system.subscribers.push_back(s);
  return system;
}

class MembersRollout : public MembershipBench {
 protected:
  MembersRollout() {
    finish_reading = true;
    core::System renamed = grown_system();
    renamed.name = "other";
    for (std::size_t g = 0; g < 2; ++g)
      at(g).handed_on = {
          {1, two_gateways()}, {2, grown_system()}, {3, grown_system()}, {4, renamed}};
  }

  std::string rolled(std::size_t g, control::RolloutRequest request) {
    const auto body = at(g).ask(std::move(request)).reply.body;
    if (const auto* error = std::get_if<control::Error>(&body)) return error->message;
    if (const auto* done = std::get_if<control::Done>(&body)) return done->message;
    return std::get<control::Rollout>(body).state;
  }
  std::string roll_out(std::size_t g, const std::string& text,
                       std::vector<std::string> without = {}) {
    return rolled(g, {.part = text, .without = std::move(without)});
  }
  control::Rollout state_of(std::size_t g) {
    return std::get<control::Rollout>(at(g).ask(control::RolloutStateRequest{}).reply.body);
  }
  void start_again(std::size_t g) {
    at(g).end();
    start(g);
  }
  bool has(std::size_t g, std::uint8_t description) {
    return at(g).daemon().scene().digest == Sha256::Digest{description};
  }
  /// The first gateway has proposed the second description, and nobody has answered.
  void propose_to_both() {
    start_both();
    finish_reading = false;
    ASSERT_EQ(roll_out(0, "2"), "checking");
    run();
    at(0).reading().finish();
    run();
    ASSERT_EQ(state_of(0).state, "judged");
  }
  /// Another gateway has given its vote, or not yet.
  void until_judged(std::size_t g) {
    for (int n = 0; n < 20 && state_of(g).state != "judged"; ++n) pass(kStepNs);
  }
};

}  // namespace mlcca::test
