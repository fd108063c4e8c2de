// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/drops.hpp"

#include <fmt/format.h>

namespace mlcca {

std::string frames_words(std::uint64_t frames) {
  return frames == 1 ? "1 frame" : fmt::format("{} frames", frames);
}

std::string dropped_line(Fate fate, std::uint64_t frames, const std::string& which) {
  return fate == Fate::let_through
             ? fmt::format("would be dropped: {} {}", frames_words(frames), which)
             : fmt::format("{} dropped {}", frames_words(frames), which);
}

}  // namespace mlcca
