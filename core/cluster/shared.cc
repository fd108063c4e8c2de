// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/shared.hpp"

#include <vector>

namespace mlcca::core::cluster {
std::string no_longer_shared(const System& before, std::size_t self_before, const System& after,
                             std::size_t self_after) {
  const std::vector<bool> shared_before = shared_networks(before);
  const std::vector<bool> shared_after = shared_networks(after);
  for (const Port& was : before.gateways[self_before].ports) {
    if (!shared_before[was.network]) continue;
    const std::string& name = before.networks[was.network].name;
    for (const Port& is : after.gateways[self_after].ports) {
      const bool same = is.identity == was.identity || after.networks[is.network].name == name;
      if (same && !shared_after[is.network])
        return "others are on " + name +
               " by the description in force, and would not be any more: "
               "roll out one without that network first, and then this one";
    }
  }
  return {};
}

}  // namespace mlcca::core::cluster
