// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/drops.hpp"

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

}  // namespace mlcca
