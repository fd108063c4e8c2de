// SPDX-License-Identifier: BSD-2-Clause
// Writes attributes in the syntax of descriptions; no other code does.
#pragma once
#include <string>
#include <string_view>

#include "mlcca/attribute.hpp"

namespace mlcca::tools::design {

/// An `element` (Attributes, Provision or PerHop) with the exact values of `attributes`. Each line
/// begins with `indent` and ends with a newline. Empty if there are no attributes.
std::string attribute_list(std::string_view element, const AttributeSet& attributes,
                           std::string_view indent);

}  // namespace mlcca::tools::design
