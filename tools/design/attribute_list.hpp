// SPDX-License-Identifier: BSD-2-Clause
// Attributes as a description has them: the one place that knows how they are written.
#pragma once
#include <string>
#include <string_view>

#include "mlcca/attribute.hpp"

namespace mlcca::tools::design {

/// `element` (Attributes, Provision or PerHop) with these attributes, exactly, each line behind
/// `indent` and with an end. Without attributes: nothing.
std::string attribute_list(std::string_view element, const AttributeSet& attributes,
                           std::string_view indent);

}  // namespace mlcca::tools::design
