// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/shared.hpp"

#include <algorithm>

namespace mlcca::core::cluster {
namespace {

bool is_shared(const System& system, std::size_t network) {
  return std::ranges::count_if(system.gateways, [network](const Gateway& gateway) {
           return gateway.port_on(network) != nullptr;
         }) > 1;
}

}  // namespace

std::string no_longer_shared(const System& before, std::size_t self_before, const System& after,
                             std::size_t self_after) {
  for (const Port& was : before.gateways[self_before].ports) {
    if (!is_shared(before, was.network)) continue;
    const std::string& name = before.networks[was.network].name;
    for (const Port& is : after.gateways[self_after].ports) {
      const bool same = is.identity == was.identity || after.networks[is.network].name == name;
      if (same && !is_shared(after, is.network))
        return "others are on " + name +
               " by the description in force, and would not be any more: "
               "roll out one without that network first, and then this one";
    }
  }
  return {};
}

}  // namespace mlcca::core::cluster
