// SPDX-License-Identifier: BSD-2-Clause
// The units of code generation: components, and for each place the ends that belong to no
// component.
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
  std::size_t index = 0;  ///< index of the publisher or subscriber
};

/// A unit, for which one header and one file of callbacks are generated.
struct Unit {
  std::string name;   ///< name of the component or place in the description
  std::string stem;   ///< unique beginning of its file names
  std::string scope;  ///< unique name of its namespace within that of the system
  std::string about;  ///< for comments: "component" or "the ends on network ... that belong to no
                      ///< component"
  core::Place place;
  std::vector<End> ends;  ///< publishers first, in the order of the description
};

/// An attribute set of an end.
struct EndSet {
  std::int32_t priority = 0;
  const AttributeSet* attributes = nullptr;
  const core::UserValues* user = nullptr;
};

/// Attributes that publishers and subscribers have in common.
const std::string& name_of(const core::System& system, End end);
std::size_t channel_of(const core::System& system, End end);
core::Place place_of(const core::System& system, End end);
/// The attribute sets of an end by falling priority; at least one.
std::vector<EndSet> sets_of(const core::System& system, End end);
/// The suffix of the names for set `i`: empty for the first one, else "Priority5" or
/// "PriorityMinus5".
std::string set_suffix(const std::vector<EndSet>& sets, std::size_t i);

/// The units of every component and place that has ends, in the order of the description; if `only`
/// is not empty, those that it names. An error if a name of `only` is unknown or has no ends.
Result<std::vector<Unit>> units_of(const core::System& system,
                                   const std::vector<std::string>& only);

}  // namespace mlcca::tools::design
