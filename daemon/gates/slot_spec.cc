// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/slot_spec.hpp"

#include <algorithm>
#include <ranges>
#include <tuple>

#include "core/gates/difference.hpp"
#include "core/model/progress.hpp"

namespace mlcca::gates {
namespace {

auto grant(const SlotSpec& s) {
  return std::tie(s.direction, s.max_len, s.formats, s.id, s.mask, s.source, s.uid, s.origin,
                  s.station, s.subject);
}

bool precedes(const SlotSpec& a, const SlotSpec& b) {
  core::Progress::step();
  return grant(a) < grant(b);
}

/// Sorted pointers, without copying the slots.
std::vector<const SlotSpec*> sorted(std::span<const SlotSpec> specs) {
  std::vector<const SlotSpec*> out;
  out.reserve(specs.size());
  for (const SlotSpec& s : specs) out.push_back(&s);
  std::ranges::sort(out, [](const auto* a, const auto* b) { return precedes(*a, *b); });
  return out;
}

/// Sorted, with equal grants joined: two publishers with the same grant share a slot, which passes
/// if either may.
std::vector<SlotSpec> joined(std::span<const SlotSpec> specs) {
  std::vector<SlotSpec> out(specs.begin(), specs.end());
  std::ranges::stable_sort(out, precedes);
  std::size_t count = 0;
  for (const SlotSpec& s : out) {
    core::Progress::step();
    if (count != 0 && out[count - 1].same_grant(s))
      out[count - 1].pass = out[count - 1].pass || s.pass;
    else
      out[count++] = s;
  }
  out.resize(count);
  return out;
}

}  // namespace

bool ByGrant::operator()(const SlotSpec& a, const SlotSpec& b) const { return grant(a) < grant(b); }

bool SlotSpec::same_traffic(const SlotSpec& other) const {
  const auto traffic = [](const SlotSpec& s) {
    return std::tie(s.per_frame, s.per_byte, s.tolerance, s.excess_passes, s.period, s.silence,
                    s.together);
  };
  return traffic(*this) == traffic(other);
}

bool SlotSpec::same_grant(const SlotSpec& other) const { return grant(*this) == grant(other); }

SlotChanges slot_changes_between(std::span<const SlotSpec> present,
                                 std::span<const SlotSpec> wanted) {
  const auto now = sorted(present);
  return core::difference_of<SlotChanges>(
      std::views::transform(now, [](const SlotSpec* s) -> const SlotSpec& { return *s; }),
      joined(wanted), ByGrant{}, [](const SlotSpec& s) { return s; },
      [](const SlotSpec& a, const SlotSpec& b) { return a.same_traffic(b); });
}

}  // namespace mlcca::gates
