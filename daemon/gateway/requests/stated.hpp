// SPDX-License-Identifier: BSD-2-Clause
// What a newcomer states of attributes, over what its channel states: those of the table, and those
// that the description defines.
#pragma once
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/model/system.hpp"

namespace mlcca {

/// Of those of the table. The error says which attributes there are.
[[nodiscard]] Result<AttributeSet> overridden(AttributeSet base, const core::System& system,
                                              const std::vector<control::Attribute>& changes);
/// Of those that the description defines: a requirement is rounded towards harder. The error says
/// in which unit it is stated.
[[nodiscard]] Result<core::UserValues> overridden(core::UserValues base, const core::System& system,
                                                  const std::vector<control::Attribute>& changes);

}  // namespace mlcca
