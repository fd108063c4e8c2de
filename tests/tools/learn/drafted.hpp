// SPDX-License-Identifier: BSD-2-Clause
// What is drafted from traffic, as a description and as a gate.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/state.hpp"
#include "core/design/inspect.hpp"
#include "core/gates/plan.hpp"
#include "description/read.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/design/learn_deadlines.hpp"
#include "tools/learn/draft.hpp"
#include "tools/learn/observer.hpp"

namespace mlcca::learn::test {

inline const std::vector<std::string> kNames = {"can0", "can1"};

inline core::System described(const Draft& draft) {
  auto system = description::read_memory(draft.xml, "draft.xml", {}, description::Users::any);
  if (!system) {
    for (const auto& problem : system.error()) ADD_FAILURE() << description::to_string(problem);
    ADD_FAILURE() << draft.xml;
    return {};
  }
  return std::move(*system);
}

/// What is drafted passes a check.
inline void expect_no_errors(const Draft& draft) {
  auto system = described(draft);
  system.sort_bindings();
  for (const core::Finding& f : core::inspect(system).findings)
    EXPECT_NE(core::info(f.id).severity, core::Severity::error) << f.text << "; " << f.hint;
}

inline Draft drafted(const std::vector<Sent>& sent, DraftOptions options = {},
                     std::vector<std::string> names = kNames) {
  Observer observer;
  for (const Sent& one : sent) observer.add(one.frame());
  observer.finish(names.size());
  Draft draft = tools::design::draft_that_holds(observer, names, options);
  expect_no_errors(draft);
  return draft;
}

/// Deliveries that are refused.
inline std::size_t refused_in(const Draft& draft) {
  const core::State state(described(draft));
  std::size_t refused = 0;
  for (const auto& decision : state.decisions())
    refused += static_cast<std::size_t>(
        std::ranges::count(decision.verdicts, false, &core::Verdict::granted));
  return refused;
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
      rules_.push_back({network, rule, 0, 0});
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
      watch(held, frame.ns);
      return true;
    }
    return false;
  }

  /// Events that did not come, as bpf/gate_watch.bpf.h counts them.
  [[nodiscard]] std::uint64_t missing() const { return missing_; }
  /// Times without an event that were longer than the Omission allows.
  [[nodiscard]] std::uint64_t silences() const { return silences_; }

 private:
  struct Held {
    std::size_t network;
    core::GateRule rule;
    std::uint64_t due;
    std::uint64_t last;
  };
  void watch(Held& held, std::uint64_t now) {
    const core::Watching& watching = held.rule.watching;
    const std::uint64_t last = std::exchange(held.last, now);
    if (last == 0 || watching.period == 0) return;
    const std::uint64_t gap = now - last;
    if (watching.silence != 0 && gap >= watching.silence) ++silences_;
    if (2 * gap >= 3 * watching.period)
      missing_ += (gap + watching.period / 2) / watching.period - 1;
  }
  core::State state_;
  std::vector<Held> rules_;
  std::uint64_t missing_ = 0;
  std::uint64_t silences_ = 0;
};

inline std::vector<Sent> before(const std::vector<Sent>& sent, std::uint64_t ns) {
  std::vector<Sent> first;
  std::ranges::copy_if(sent, std::back_inserter(first),
                       [ns](const Sent& one) { return one.ns < ns; });
  return first;
}

/// So many of so many frames.
struct Share {
  std::uint64_t frames = 0;
  std::uint64_t of = 0;
  Share& operator+=(const Share& other) {
    frames += other.frames;
    of += other.of;
    return *this;
  }
};
/// What a gate drops of the frames from a time on that count.
template <class AnyGate, class Counts>
Share from(const std::vector<Sent>& sent, std::uint64_t ns, AnyGate& gate, const Counts& counts) {
  Share dropped;
  for (const Sent& one : sent) {
    if (one.ns < ns || !counts(one)) continue;
    ++dropped.of;
    if (!gate.passes(one)) ++dropped.frames;
  }
  return dropped;
}

}  // namespace mlcca::learn::test
