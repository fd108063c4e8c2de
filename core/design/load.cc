// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/load.hpp"

#include <algorithm>

#include "core/mesh/medium_time.hpp"

namespace mlcca::core {

NetworkLoad load_of(const Ledger& ledger, const World& world, std::size_t network) {
  NetworkLoad load{.reserved = ledger.reserved(network)};
  if (const can::Schedule* bus = ledger.schedule(network)) load.time_ppm = bus->utilisation_ppm();
  const auto& mesh = world.meshes[network];
  if (!mesh) return load;
  constexpr Value part = mesh::kFullTime / mesh::kWhole;
  Value fullest = 0;
  for (std::size_t d = 0; d < mesh->domains().count(); ++d) {
    const Value taken = ledger.medium_time(network, d);
    fullest = std::max(fullest, taken);
    if (taken != 0)
      load.domains.push_back({mesh->domain_name(d), taken / part + (taken % part == 0 ? 0 : 1)});
  }
  load.time_ppm = fullest / part;
  return load;
}

}  // namespace mlcca::core
