// SPDX-License-Identifier: BSD-2-Clause
// Gates whose interface may have gone. A gate is given up only when the kernel has reported that
// its interface has gone, or says so when asked for it. A list without the interface proves
// nothing.
#pragma once
#include <cstdint>
#include <functional>
#include <set>

#include "daemon/net/links.hpp"
#include "daemon/ports/gate_set.hpp"

namespace mlcca {

/// Keeps which interfaces with a gate may have gone.
class VanishedGates {
 public:
  /// Asks the kernel for one interface.
  using Presence = std::function<net::Presence(int ifindex)>;

  /// The kernel has reported that these interfaces have gone.
  void note(const std::set<int>& gone, const GateSet& gates);
  /// Gives up the gates for which that is certain, and removes their pins.
  void let_go(GateSet& gates, const net::InterfaceTable& links, const Presence& presence);
  void forget_all_but(const GateSet& gates);
  /// Whether it is uncertain for any gate if its interface exists.
  [[nodiscard]] bool unconfirmed() const { return !unconfirmed_.empty(); }

 private:
  enum class Fate : std::uint8_t {
    stays,  ///< its interface exists, or that is uncertain, or it is not listed yet
    gone,
    /// Its interface has gone, and the index belongs to another one, or the interface is back.
    /// Loading its new gate finds out what is attached there.
    replaced,
  };
  [[nodiscard]] Fate fate_of(int ifindex, const net::InterfaceTable& links,
                             const Presence& presence);

  std::set<int> unconfirmed_;  ///< interfaces with a gate that may have gone
};

}  // namespace mlcca
