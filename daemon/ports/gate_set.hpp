// SPDX-License-Identifier: BSD-2-Clause
// The gates that this daemon commands, by interface, and how one takes the place of another. It
// knows nothing of what is described: whoever asks for a gate says what it must be.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "daemon/ports/held_gate.hpp"

namespace mlcca {

class GateSet {
 public:
  using Load = std::function<Result<std::unique_ptr<HeldGate>>(const GateSpec& spec)>;
  explicit GateSet(Load load) : load_(std::move(load)) {}

  /// Puts such a gate in place, unless it is there. The one that was there goes when the other is
  /// in its place; after an error it is there as before.
  Result<void> hold(const GateSpec& spec);

  // A change of many gates at once, with a way back: make_spare() of each, begin_change(), hold()
  // of each, and, where change() says that one could not be put in place, go_back() and hold() of
  // what was there; end_change() at last, and after an error of make_spare().

  /// Makes what hold() will need, without putting it in place. Error: there is no memory for it, or
  /// no right.
  Result<void> make_spare(const GateSpec& spec);
  /// From now on gates that are displaced are kept.
  void begin_change();
  /// Why hold() has failed since begin_change(); until go_back() it changes nothing any more.
  [[nodiscard]] const Result<void>& change() const { return change_; }
  void go_back();
  void end_change();

  /// The gate in place; none: there is none of ours.
  [[nodiscard]] HeldGate* find(int ifindex) const;
  [[nodiscard]] bool contains(int ifindex) const { return gates_.contains(ifindex); }
  [[nodiscard]] std::vector<int> interfaces() const;
  /// The one behind this interface, by ifindex; nothing behind the last one.
  [[nodiscard]] std::optional<int> next(int ifindex) const;
  /// Denies everything on an interface, and by what may be put in place there as well: that may
  /// read the same slots, or have a copy.
  void deny(int ifindex);
  /// The gate is not commanded any more; it stays in the kernel as it is.
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
  Spares spares_;              ///< those that are not
  Phase phase_ = Phase::settled;
  Result<void> change_;
};

}  // namespace mlcca
