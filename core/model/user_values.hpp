// SPDX-License-Identifier: BSD-2-Clause
// The rules for user-defined attributes. They are those of the built-in attributes: union of two
// requirements, composition along a route, comparison.
#pragma once
#include <span>

#include "core/model/system.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca::core {

/// The strictest union of two requirements: all attributes that either states, with the harder
/// value where both do.
[[nodiscard]] UserValues strictest(const System& system, const UserValues& a, const UserValues& b);

/// One hop of a route for composed(). If a gateway does not state an attribute that is composed by
/// maximum or minimum, it does not limit it.
struct UserHop {
  const UserValues* provision = nullptr;
  bool gateway = false;
  unsigned frames = 1;  ///< frames of one event, used by composition survival
};

/// Composes the provisions of a route of at most kMaxHops hops. An attribute that some hop does not
/// provide is missing in the result.
[[nodiscard]] UserValues composed(const System& system, std::span<const UserHop> hops);

/// Compares a requirement with a provision. The field `attribute` of the result has no meaning; the
/// caller knows which user-defined attribute it passed.
[[nodiscard]] Comparison compare(const System& system, const UserValue& required,
                                 const UserValues& provision);

}  // namespace mlcca::core
