// SPDX-License-Identifier: BSD-2-Clause
// What the gates of a bench hold, against what is granted.
#pragma once
#include <algorithm>
#include <string>

#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {

/// A gate that holds something else than what is granted, without denying it; empty: there is none.
/// A gate that has refused may deny what is granted.
inline std::string wrong_gate(Bench& bench) {
  FakeGates& gates = bench.gates();
  if (gates.out_of_hand() && bench.kernel.open) return "out of hand, and not closed";
  const core::GateState wanted = bench.wanted();
  for (std::size_t p = 0; p < gates.size(); ++p) {
    const auto share = gates.share_of(p, wanted);
    if (!share) continue;
    const auto& rules = bench.kernel.gates.at(gates.gated_interface(p)).rules;
    for (const auto& [entry, rule] : rules) {
      if (!rule.pass) continue;
      const auto granted = std::ranges::lower_bound(*share, entry, {}, &core::GateRule::entry);
      if (granted == share->end() || granted->entry != entry || !granted->pass)
        return gates.network_of(p) + " passes what is not granted";
    }
    if (gates.has_refused(p)) continue;
    if (!std::ranges::equal(rules, *share, {}, [](const auto& held) { return held.second; }))
      return gates.network_of(p) + " does not hold what is granted";
  }
  for (const auto& [ifindex, gate] : bench.kernel.gates) {
    if (gates.next_gate(ifindex - 1) == ifindex || !bench.kernel.passes()) continue;
    if (std::ranges::any_of(gate.rules, [](const auto& held) { return held.second.pass; }))
      return "a gate that no daemon commands passes something";
  }
  return {};
}

}  // namespace mlcca::test
