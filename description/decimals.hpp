// SPDX-License-Identifier: BSD-2-Clause
// Attributes that are decimals, as whole numbers in the scale that the schema states for them.
#pragma once
#include <string_view>

#include "description/problems.hpp"
#include "description/xml.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::description {

/// As it is stated, such as 500000000 for "0.5" with 9 digits; where that is absent or out of its
/// range, which is a problem, the default, or 0 without one.
[[nodiscard]] Value decimal_of(const Element& e, std::string_view attribute, Problems& problems);

}  // namespace mlcca::description
