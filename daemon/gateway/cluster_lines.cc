// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/cluster_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

constexpr Value kTroublesAgain = 10'000'000'000;  // ns

}  // namespace

void ClusterLines::standing(const std::string& system, const std::string& why, bool lost,
                            Value now) {
  const bool is_new = outage_.take(lost, now) == Outage::Report::lost;
  if (lost ? !is_new : why == said_) return;
  said_ = why;
  if (why.empty())
    log_.notice(Kind::gateway, fmt::format("cluster {}: this gateway takes part", system));
  else
    log_.warning(Kind::gateway, fmt::format("cluster {}: {}", system, why));
}

/// What others write must not fill the log: the lines of a while are reported together.
void ClusterLines::troubles(const std::function<std::vector<std::string>()>& find, Value now) {
  if (now < next_ || !invalid_) return;
  invalid_ = false;
  std::vector<std::string> found = find();
  for (const std::string& line : found) {
    if (std::ranges::find(troubles_, line) != troubles_.end()) continue;
    log_.warning(Kind::gateway, line);
    next_ = add_saturating(now, kTroublesAgain);
  }
  troubles_ = std::move(found);
}

}  // namespace mlcca
