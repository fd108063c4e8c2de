// SPDX-License-Identifier: BSD-2-Clause
// User-defined attributes through the same rules as the built-in ones: the harder of two
// requirements, the provision of a route, the comparison.
#pragma once
#include <span>

#include "core/model/system.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca::core {

/// The union of two requirements: of an attribute that both state, the harder value.
[[nodiscard]] UserValues strictest(const System& system, const UserValues& a, const UserValues& b);

/// What one hop provides, and whether it is a gateway: one that does not state an attribute
/// composed by maximum or minimum does not limit it.
struct UserHop {
  const UserValues* provision = nullptr;
  bool gateway = false;
  unsigned frames = 1;  ///< of one event, for composition survival
};

/// What a route of at most kMaxHops hops provides; what a hop does not state, it does not.
[[nodiscard]] UserValues composed(const System& system, std::span<const UserHop> hops);

/// A requirement against a provision. The attribute of the Comparison has no meaning.
[[nodiscard]] Comparison compare(const System& system, const UserValue& required,
                                 const UserValues& provision);

}  // namespace mlcca::core
