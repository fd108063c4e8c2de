// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/drops.hpp"

#include <fmt/format.h>

namespace mlcca {

std::string dropped_line(Fate fate, std::uint64_t frames, const std::string& which) {
  return fate == Fate::let_through ? fmt::format("would be dropped: {} frames {}", frames, which)
                                   : fmt::format("{} frames dropped {}", frames, which);
}

}  // namespace mlcca
