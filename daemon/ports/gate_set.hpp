// SPDX-License-Identifier: BSD-2-Clause
// The gates that this daemon commands, by interface, and how one gate replaces another. It does not
// know the description: the caller states what a gate must be.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "daemon/ports/held_gate.hpp"

namespace mlcca {

/// Loads gates, puts them in place, and keeps replaced ones during a change so that it can go back.
class GateSet {
 public:
  using Load = std::function<Result<std::unique_ptr<HeldGate>>(const GateSpec& spec)>;
  explicit GateSet(Load load) : load_(std::move(load)) {}

  /// Puts the gate in place unless it is there. The former gate is removed when the new one is in
  /// place; after an error it is there as before.
  Result<void> hold(const GateSpec& spec);

  // A change of many gates that can be undone: make_spare() for each, begin_change(), hold() for
  // each. If one could not be put in place: go_back(), and hold() for the former ones. At the end,
  // and after an error of make_spare(), end_change().

  /// Makes what hold() will need, without putting it in place. The error: no memory or no right.
  Result<void> make_spare(const GateSpec& spec);
  /// From now on replaced gates are kept.
  void begin_change();
  /// Whether hold() has failed since begin_change(). Until go_back() it changes nothing any more,
  /// and returns the same error.
  [[nodiscard]] bool must_go_back() const { return !change_; }
  void go_back();
  void end_change();

  /// The gate in place; nullptr if there is none of ours.
  [[nodiscard]] HeldGate* find(int ifindex) const;
  [[nodiscard]] bool contains(int ifindex) const { return gates_.contains(ifindex); }
  [[nodiscard]] std::vector<int> interfaces() const;
  /// The interface after this one, by index; nullopt after the last one.
  [[nodiscard]] std::optional<int> next(int ifindex) const;
  /// Denies everything on an interface, also by spare gates for it, which may use the same slots or
  /// a copy of them.
  void deny(int ifindex);
  /// Stops commanding the gate, which stays in the kernel as it is.
  void forget(int ifindex) { gates_.erase(ifindex); }

 private:
  enum class Phase : std::uint8_t { settled, changing, going_back };
  using Gate = std::unique_ptr<HeldGate>;
  using Spares = std::multimap<int, Gate>;

  Result<void> replace(const GateSpec& spec);
  Result<Spares::iterator> spare_of(const GateSpec& spec);
  void take_in(Spares::iterator spare);

  Load load_;
  std::map<int, Gate> gates_;  ///< in place, by ifindex
  Spares spares_;              ///< not in place
  Phase phase_ = Phase::settled;
  Result<void> change_;  ///< the first error of hold() in a change
};

}  // namespace mlcca
