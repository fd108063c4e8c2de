// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/bypass.hpp"

#include <algorithm>

namespace mlcca {

std::uint64_t Bypass::update(const Counts& counts) {
  const auto behind = static_cast<std::int64_t>(counts.sent + counts.waiting);
  const std::int64_t least = behind - static_cast<std::int64_t>(counts.let_out_after);
  const std::int64_t most = behind - static_cast<std::int64_t>(counts.let_out_before);
  const bool set_back = counts.sent < last_.sent || counts.let_out_before < last_.let_out_after;
  last_ = counts;
  if (!base_ || set_back) {
    base_ = most;
    return 0;
  }
  const std::int64_t bypassed = least - *base_;
  if (bypassed > static_cast<std::int64_t>(kInDriver)) {
    *base_ = least;
    return static_cast<std::uint64_t>(bypassed);
  }
  *base_ = std::min(*base_, most);
  return 0;
}

}  // namespace mlcca
