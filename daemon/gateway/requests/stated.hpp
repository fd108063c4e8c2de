// SPDX-License-Identifier: BSD-2-Clause
// What an admission states of attributes, in addition to what its channel states: those of the
// table, and those that the description defines.
#pragma once
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/model/system.hpp"

namespace mlcca {

/// `base` with the stated attributes of the table. The error says which attributes there are.
[[nodiscard]] Result<AttributeSet> overridden(AttributeSet base, const core::System& system,
                                              const std::vector<control::Attribute>& changes);
/// `base` with the stated attributes that the description defines. A requirement is rounded towards
/// harder. The error says in which unit it is stated.
[[nodiscard]] Result<core::UserValues> overridden(core::UserValues base, const core::System& system,
                                                  const std::vector<control::Attribute>& changes);

}  // namespace mlcca
