// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <string>

#include "base/result.hpp"

namespace mlcca::gates {

/// After an upgrade: closes and unpins the control words of other layouts, which get no heart-beat
/// any more. Their gates are replaced where a gate of ours is attached; elsewhere they stay,
/// closed. The error: what is there cannot be read.
Result<void> close_former_layouts(const std::string& root);
/// Closes all gates that obey this control word, of any layout.
void close_word(int map);

}  // namespace mlcca::gates
