// SPDX-License-Identifier: BSD-2-Clause
// Attributes of the protocol, which have names, and those of the core.
#pragma once
#include <optional>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::control {

/// As the table of attributes has it.
[[nodiscard]] std::optional<mlcca::Attribute> attribute_named(std::string_view name);
/// In the order of the table.
[[nodiscard]] std::vector<Attribute> attributes_of(const AttributeSet& set);
/// Error: there is no attribute of a name.
[[nodiscard]] Result<AttributeSet> set_of(const std::vector<Attribute>& attributes);

}  // namespace mlcca::control
