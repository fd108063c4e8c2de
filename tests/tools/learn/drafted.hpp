// SPDX-License-Identifier: BSD-2-Clause
// What is drafted from traffic, as a description and as a gate.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/state.hpp"
#include "core/gates/plan.hpp"
#include "description/read.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/design/learn_deadlines.hpp"
#include "tools/learn/draft.hpp"
#include "tools/learn/observer.hpp"

namespace mlcca::learn::test {

inline const std::vector<std::string> kNames = {"can0", "can1"};

inline Draft drafted(const std::vector<Sent>& sent, DraftOptions options = {},
                     std::vector<std::string> names = kNames) {
  Observer observer;
  for (const Sent& one : sent) observer.add(one.frame());
  observer.finish(names.size());
  return tools::design::draft_that_holds(observer, names, options);
}

inline core::System described(const Draft& draft) {
  auto system = description::read_memory(draft.xml, "draft.xml", {}, description::Users::any);
  if (!system) {
    for (const auto& problem : system.error()) ADD_FAILURE() << description::to_string(problem);
    ADD_FAILURE() << draft.xml;
    return {};
  }
  return std::move(*system);
}

/// A gate that holds what the draft grants, as far as it polices and measures. What it drops of
/// what comes in on the interfaces.
class Gate {
 public:
  explicit Gate(const Draft& draft) : state_(described(draft)) {
    const core::System& system = state_.system();
    for (const core::GateRule& rule : state_.gate_state(0)) {
      if (rule.entry.direction != core::Direction::ingress || !rule.pass) continue;
      const auto network = system.gateways[0].ports[rule.entry.port].network;
      rules_.push_back({network, rule, 0});
    }
  }

  bool passes(const Sent& frame) {
    for (Held& held : rules_) {
      const auto id = frame.id;
      if (held.network != frame.interface || (id & held.rule.entry.mask) != held.rule.entry.id)
        continue;
      if (frame.data.size() > held.rule.entry.frame_length()) return false;
      const auto& policing = held.rule.policing;
      if (policing.per_frame == 0) return true;
      if (frame.ns + policing.tolerance < held.due) return false;
      held.due = std::max(held.due, frame.ns) + policing.per_frame;
      return true;
    }
    return false;
  }

 private:
  struct Held {
    std::size_t network;
    core::GateRule rule;
    std::uint64_t due;
  };
  core::State state_;
  std::vector<Held> rules_;
};

}  // namespace mlcca::learn::test
