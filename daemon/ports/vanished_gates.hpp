// SPDX-License-Identifier: BSD-2-Clause
// Gates whose interface may have gone. One is let go when the kernel has reported that its
// interface went, or answers so when it is asked for this one: that a list lacks it proves nothing.
#pragma once
#include <cstdint>
#include <functional>
#include <set>

#include "daemon/net/links.hpp"
#include "daemon/ports/gate_set.hpp"

namespace mlcca {

class VanishedGates {
 public:
  /// Asks the kernel for one interface.
  using Presence = std::function<net::Presence(int ifindex)>;

  /// The kernel has reported that these went.
  void note(const std::set<int>& gone, const GateSet& gates);
  /// Forgets those gates of which that is certain, and removes their pins.
  void let_go(GateSet& gates, const net::LinkTable& links, const Presence& presence);
  void forget_all_but(const GateSet& gates);
  /// It is not certain of a gate whether its interface is there.
  [[nodiscard]] bool unconfirmed() const { return !unconfirmed_.empty(); }

 private:
  enum class Fate : std::uint8_t {
    stays,  ///< its interface is there, or that is not certain yet, or is not listed yet
    gone,
    /// Its interface went, and another one has the number, or it is back: a gate of its own finds
    /// out what is attached there.
    replaced,
  };
  [[nodiscard]] Fate fate_of(int ifindex, const net::LinkTable& links, const Presence& presence);

  std::set<int> unconfirmed_;  ///< interfaces with a gate that may have gone
};

}  // namespace mlcca
