// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/misfit_causes.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace mlcca {
namespace {

std::uint64_t counted(const Refusals& refusals, Fate fate) {
  return fate == Fate::dropped ? refusals.frames.dropped : refusals.frames.would_drop;
}

/// The growth of a counter since `before`. One that is less than before has started again from 0.
std::uint64_t grown(const Refusals& now, const std::vector<Refusals>& before, Fate fate) {
  const auto old = std::ranges::find_if(before, [&now](const Refusals& one) {
    return one.egress == now.egress && one.reason == now.reason;
  });
  const std::uint64_t from = old == before.end() ? 0 : counted(*old, fate);
  const std::uint64_t to = counted(now, fate);
  return to >= from ? to - from : to;
}

}  // namespace

void MisfitCauses::begin_round() {
  Counts now;
  for (std::size_t p = 0; p < gates_.size(); ++p) now[p] = gates_.misfits(p);
  before_ = began_.empty() ? now : std::move(began_);
  began_ = std::move(now);
  explained_.clear();
}

void MisfitCauses::explain(const core::GateEntry& entry, Fate fate, core::FrameReason reason,
                           std::uint64_t frames) {
  explained_[{entry.port, entry.direction == core::Direction::egress, fate, reason}] += frames;
}

std::vector<MisfitCauses::Cause> MisfitCauses::of(const core::GateEntry& entry, Fate fate,
                                                  std::uint64_t frames,
                                                  std::optional<core::FrameReason> latest) const {
  const auto before = before_.find(entry.port);
  std::vector<Cause> causes;
  if (before != before_.end())
    for (const Refusals& now : gates_.misfits(entry.port)) {
      if (now.egress != (entry.direction == core::Direction::egress)) continue;
      const std::tuple key{entry.port, now.egress, fate, now.reason};
      std::uint64_t fresh = grown(now, before->second, fate);
      if (const auto known = explained_.find(key); known != explained_.end())
        fresh -= std::min(fresh, known->second);
      if (fresh != 0) causes.push_back({{now.reason}, fresh});
    }
  const std::uint64_t all =
      std::accumulate(causes.begin(), causes.end(), std::uint64_t{0},
                      [](std::uint64_t sum, const Cause& cause) { return sum + cause.frames; });
  if (causes.size() == 1 && all >= frames) return {{causes.front().reason, frames}};
  if (all == frames) return causes;
  // The latest frame may be excess, which fits the slot.
  if (!latest || latest == core::FrameReason::excess) return {{core::StatedReason{}, frames}};
  const bool is_latest = !causes.empty() && frames != 1;
  return {{{.reason = latest, .is_latest = is_latest}, frames}};
}

}  // namespace mlcca
