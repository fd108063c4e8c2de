// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/program/described_tags.hpp"

#include <algorithm>

#include "core/profiles/profile.hpp"
#include "relay/famouso/subscription.hpp"

namespace mlcca::relay {

Result<std::vector<TagBroker::Dealt>> described_tags(const core::System& system,
                                                     const std::string& network) {
  const auto there = std::ranges::find(system.networks, network, &core::Network::name);
  if (there == system.networks.end()) return fail("there is no network '" + network + "'");
  if (!core::has_broker(*there)) return fail(network + " is no CAN network of profile famouso");
  std::vector<TagBroker::Dealt> out;
  for (const core::Binding& binding : there->bindings)
    if (!binding.dynamic)
      out.emplace_back(system.channels[binding.channel].subject,
                       static_cast<TagNumber>(binding.id));
  if (there->subscribe_tag != 0)
    out.emplace_back(kSubscriptionSubject, static_cast<TagNumber>(there->subscribe_tag));
  return out;
}

}  // namespace mlcca::relay
