// SPDX-License-Identifier: BSD-2-Clause
// Converts decimal attributes to integers in the scale that the schema states for them.
#pragma once
#include <string_view>

#include "description/problems.hpp"
#include "description/xml.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::description {

/// The attribute's value as an integer, e.g. 500000000 for "0.5" with 9 digits. If it is absent,
/// the default of the schema, or 0 without one; the same if it is out of range, which is reported.
[[nodiscard]] Value decimal_of(const Element& e, std::string_view attribute, Problems& problems);

}  // namespace mlcca::description
