// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/drops.hpp"

#include <fmt/format.h>

#include "base/many.hpp"

namespace mlcca {

std::string dropped_line(Fate fate, std::uint64_t frames, const std::string& which) {
  return fate == Fate::passed ? fmt::format("would be dropped: {} {}", many(frames, "frame"), which)
                              : fmt::format("{} dropped {}", many(frames, "frame"), which);
}

}  // namespace mlcca
