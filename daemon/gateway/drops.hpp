// SPDX-License-Identifier: BSD-2-Clause
// Texts about dropped frames.
#pragma once
#include <cstdint>
#include <string>

namespace mlcca {

/// What has become of frames that a gate refuses. In audit mode they pass (let_through).
enum class Fate : std::uint8_t { dropped, let_through };

/// "3 frames dropped of x", or "would be dropped: 3 frames of x" for let_through.
std::string dropped_line(Fate fate, std::uint64_t frames, const std::string& which);

}  // namespace mlcca
