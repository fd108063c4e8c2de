// SPDX-License-Identifier: BSD-2-Clause
// What a state must never exceed, whatever was admitted into it.
#pragma once
#include <string>
#include <vector>

#include "core/admission/state.hpp"

namespace mlcca::core::testing {

/// A message that is late, a resource above its bound, or a sum that is not that of what is held;
/// empty: nothing is wrong.
inline std::string beyond_bounds(const State& state) {
  const Ledger& ledger = state.ledger();
  const System& system = state.system();
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    const std::string& name = system.networks[n].name;
    if (const can::Schedule* bus = ledger.schedule(n)) {
      if (!bus->late().empty()) return "a message is late on " + name;
      const auto responses = can::analyse(bus->assumptions(), bus->messages());
      for (std::size_t m = 0; m < responses.size(); ++m)
        if (!can::fits(bus->assumptions(), bus->messages()[m], responses[m]))
          return "a message does not fit on " + name;
    }
    const auto& view = state.world().meshes[n];
    for (std::size_t d = 0; view && d < view->domains().count(); ++d)
      if (ledger.medium_time(n, d) > mesh::limit_of(*system.networks[n].mesh))
        return "more time is promised than there is on " + name;
    const AttributeSet& provided = system.networks[n].provision;
    if (provided.has(Attribute::bandwidth) && ledger.reserved(n) > provided[Attribute::bandwidth])
      return "more is promised than there is on " + name;
  }
  std::vector<Value> sums(system.resources(), 0);
  for (std::size_t c = 0; c < system.channels.size(); ++c)
    for (const std::size_t p : state.members().publishers_of(c))
      for (const Holding& h : ledger.holdings_of(p)) sums[h.resource] += h.bytes_per_second;
  for (std::size_t r = 0; r < sums.size(); ++r)
    if (ledger.reserved(r) != sums[r]) return "a sum is not that of what is held";
  return {};
}

/// Of each channel: which deliveries are granted, and in which attribute set.
inline std::string service(const State& state) {
  std::string all;
  for (const Decision& d : state.decisions()) {
    for (const Verdict& v : d.verdicts) all += v.granted ? 'g' : '-';
    all += std::to_string(d.set) + ' ';
  }
  return all;
}

}  // namespace mlcca::core::testing
