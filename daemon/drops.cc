// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/drops.hpp"

#include <fmt/format.h>

namespace mlcca {

std::optional<std::uint64_t> DropWatch::look(const std::string& name, std::uint64_t dropped,
                                             std::int64_t now) {
  auto [it, fresh] = seen_.try_emplace(name);
  Seen& seen = it->second;
  if (fresh || dropped < seen.mentioned) {
    seen = {dropped, now, false};
    return std::nullopt;
  }
  if (dropped == seen.mentioned || (seen.ever && now - seen.at < kRepeat)) return std::nullopt;
  const std::uint64_t since = dropped - seen.mentioned;
  seen = {dropped, now, true};
  return since;
}

void DropWatch::wake() {
  for (auto& [name, seen] : seen_) seen.ever = false;
}

std::string dropped_line(bool audit, std::uint64_t frames, const std::string& which) {
  return audit ? fmt::format("would be dropped: {} frames {}", frames, which)
               : fmt::format("{} frames dropped {}", frames, which);
}

}  // namespace mlcca
