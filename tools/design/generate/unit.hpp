// SPDX-License-Identifier: BSD-2-Clause
// What code is generated for: components, and the ends of each place that belong to none.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "mlcca/der_format.hpp"

namespace mlcca::tools::design {

/// A publisher or subscriber of a system.
struct End {
  der::Role role = der::Role::subscriber;
  std::size_t index = 0;  ///< into publishers or subscribers
};

/// One header and one file of callbacks.
struct Unit {
  std::string name;   ///< of the component or place, as described
  std::string stem;   ///< of its files; unique
  std::string scope;  ///< its namespace in that of the system; unique
  std::string about;  ///< "component" or "the ends on network ... that belong to no component"
  core::Place place;
  std::vector<End> ends;  ///< publishers first, in the order of the description
};

/// One attribute set of an end.
struct EndSet {
  std::int32_t priority = 0;
  const AttributeSet* attributes = nullptr;
  const core::UserValues* user = nullptr;
};

/// The same for publishers and subscribers.
const std::string& name_of(const core::System& system, End end);
std::size_t channel_of(const core::System& system, End end);
core::Place place_of(const core::System& system, End end);
/// All of them, priorities falling; at least one.
std::vector<EndSet> sets_of(const core::System& system, End end);
/// Of a name: "" for the first of them, else "Priority5" or "PriorityMinus5".
std::string set_suffix(const std::vector<EndSet>& sets, std::size_t i);

/// Of every component and place that has ends, in the order of the description; of those named
/// `only`, if there are any. The error says which name is not known, or has no ends.
Result<std::vector<Unit>> units_of(const core::System& system,
                                   const std::vector<std::string>& only);

}  // namespace mlcca::tools::design
