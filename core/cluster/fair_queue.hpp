// SPDX-License-Identifier: BSD-2-Clause
// Something to do for admissions of several gateways, which take turns.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace mlcca::core::cluster {

/// Admissions that wait for their turn, by the gateway that has asked for them. Nobody has to wait
/// for all that another gateway has asked for.
class FairQueue {
 public:
  void add(std::size_t gateway, std::uint64_t id) { waiting_[gateway].insert(id); }
  void remove(std::size_t gateway, std::uint64_t id) {
    const auto it = waiting_.find(gateway);
    if (it == waiting_.end()) return;
    it->second.erase(id);
    if (it->second.empty()) waiting_.erase(it);
  }
  void clear() { waiting_.clear(); }
  [[nodiscard]] bool empty() const { return waiting_.empty(); }

  /// The gateway whose turn it is; nullopt: nothing waits.
  [[nodiscard]] std::optional<std::size_t> next() const {
    if (waiting_.empty()) return std::nullopt;
    const auto it = waiting_.upper_bound(latest_);
    return it == waiting_.end() ? waiting_.begin()->first : it->first;
  }
  /// What waits of that gateway.
  [[nodiscard]] const std::set<std::uint64_t>& of(std::size_t gateway) const {
    return waiting_.at(gateway);
  }
  /// That gateway has had its turn.
  void took(std::size_t gateway) { latest_ = gateway; }

  /// Visits all state that affects its behaviour, for the model checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(waiting_, latest_);
  }

 private:
  std::map<std::size_t, std::set<std::uint64_t>> waiting_;
  std::size_t latest_ = 0;
};

}  // namespace mlcca::core::cluster
