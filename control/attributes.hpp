// SPDX-License-Identifier: BSD-2-Clause
// Conversion of attributes between control messages, which name them, and the core, which has a
// table.
#pragma once
#include <optional>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::control {

/// The attribute of that name in the attribute table; nullopt if there is none.
[[nodiscard]] std::optional<mlcca::Attribute> attribute_named(std::string_view name);
/// The attributes that `set` states, in the order of the table.
[[nodiscard]] std::vector<Attribute> attributes_of(const AttributeSet& set);
/// The same the other way; an error if a name is not in the table.
[[nodiscard]] Result<AttributeSet> set_of(const std::vector<Attribute>& attributes);

}  // namespace mlcca::control
