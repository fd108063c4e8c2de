// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/slot_spec.hpp"

#include <map>
#include <set>
#include <tuple>

#include "core/model/progress.hpp"

namespace mlcca::enforce {
namespace {

auto grant(const SlotSpec& s) {
  return std::tie(s.direction, s.max_len, s.formats, s.id, s.mask, s.source, s.uid, s.origin,
                  s.station, s.subject);
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

SlotChanges difference(std::span<const SlotSpec> present, std::span<const SlotSpec> wanted) {
  // Two publishers with one grant share a slot; it passes when one of them may.
  std::map<SlotSpec, bool, ByGrant> want;
  using Succession = std::tuple<Direction, std::uint64_t, std::uint32_t, std::uint32_t,
                                std::uint32_t, std::uint64_t>;
  const auto succession = [](const SlotSpec& s) {
    return Succession{s.direction, s.subject, s.id, s.source, s.origin, s.station};
  };
  std::set<Succession> passing;
  for (const auto& s : wanted) {
    want[s] = want[s] || s.pass;
    if (s.pass) passing.insert(succession(s));
    core::Progress::step();
  }

  SlotChanges changes;
  for (const auto& s : present) {
    core::Progress::step();
    const auto found = want.find(s);
    if (found == want.end()) {
      if (s.pass && !passing.contains(succession(s))) changes.close.push_back(s);
      changes.remove.push_back(s);
      continue;
    }
    if (s.pass && !found->second) changes.close.push_back(s);
    if (!s.pass && found->second) changes.open.push_back(s);
    if (!s.same_traffic(found->first)) changes.police.push_back(found->first);
    want.erase(found);
  }
  for (const auto& [spec, pass] : want) {
    changes.add.push_back(spec);
    changes.add.back().pass = pass;
    core::Progress::step();
  }
  return changes;
}

}  // namespace mlcca::enforce
