// SPDX-License-Identifier: BSD-2-Clause
// Which gateways can be chosen to carry what several could carry. All choose by the same order
// among those that have not failed, so the only question is who has: and whoever comes back must
// hear from the others that they know it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cluster/view.hpp"

namespace mlcca::core::cluster {

class Election {
 public:
  Election(std::size_t self, std::size_t gateways) : self_(self), failed_(gateways, true) {}

  /// It can carry. The caller has closed everything of that before it says that it cannot.
  void set_able(bool able) { able_ = able; }
  /// An incarnation goes on, or a new one begins.
  void begin(Role role) { role_ = role == Role::active ? role : Role::standby; }
  void lose() { role_ = Role::standby; }
  /// What the next beat is to say.
  [[nodiscard]] Role wanted(const View& view, Value now, bool draining) const;
  [[nodiscard]] Role role() const { return role_; }
  void on_committed(Role role, std::int64_t revision);
  void step(const View& view, Value now, bool joined, std::vector<Event>& events);

  /// All that it acts on, for a checker.
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
