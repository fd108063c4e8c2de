// SPDX-License-Identifier: BSD-2-Clause
// Elects the gateway that carries what several gateways could carry. All choose by the same order
// among those that have not failed, so they only have to agree on who has failed. A gateway that
// comes back must be acknowledged by the others first.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cluster/view.hpp"

namespace mlcca::core::cluster {

/// The role of this gateway (standby, taking, active) and which other gateways have failed.
class Election {
 public:
  Election(std::size_t self, std::size_t gateways) : self_(self), failed_(gateways, true) {}

  /// Sets whether this gateway can carry. Before the caller sets false, it must have closed all
  /// that this gateway carries in the place of others.
  void set_able(bool able) { able_ = able; }
  /// Begins as standby, or as active if the incarnation that goes on was active.
  void begin(Role role) { role_ = role == Role::active ? role : Role::standby; }
  void lose() { role_ = Role::standby; }
  /// The role that the next beat is to state.
  [[nodiscard]] Role wanted(const View& view, Value now, bool draining) const;
  [[nodiscard]] Role role() const { return role_; }
  /// The transaction with this role was committed at `revision`.
  void on_committed(Role role, std::int64_t revision);
  /// Reports changes of Failed as events. `joined`: this gateway is a member.
  void step(const View& view, Value now, bool joined, std::vector<Event>& events);

  /// Visits all state that affects its behaviour, for the model checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(able_, role_, taking_since_, failed_);
  }

 private:
  [[nodiscard]] bool all_know(const View& view, Value now) const;

  std::size_t self_;
  bool able_ = true;
  Role role_ = Role::standby;
  std::int64_t taking_since_ = 0;
  std::vector<bool> failed_;
};

}  // namespace mlcca::core::cluster
