// SPDX-License-Identifier: BSD-2-Clause
// Texts about dropped frames.
#pragma once
#include <cstdint>
#include <string>

namespace mlcca {

/// What has become of frames that a gate refuses. In audit mode they pass (passed).
enum class Fate : std::uint8_t { dropped, passed };

/// "3 frames dropped of x", or "would be dropped: 3 frames of x" for passed.
std::string dropped_line(Fate fate, std::uint64_t frames, const std::string& which);

}  // namespace mlcca
