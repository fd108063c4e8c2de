// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/unlisted_channels.hpp"

#include <algorithm>
#include <string>

#include "base/many.hpp"
#include "core/model/text.hpp"

namespace mlcca::core {

/// One that has no name was decided since it had one: nothing of it is granted, even if all
/// channels are about to be decided again.
std::optional<std::size_t> UnlistedChannels::free_index(const IsUsed& is_used) const {
  for (std::size_t end = system_.channels.size(); end > 0; --end) {
    const std::size_t c = end - 1;
    if (!system_.channels[c].unlisted) break;
    if (system_.channels[c].name.empty() || !is_used(c)) return c;
  }
  return std::nullopt;
}

Result<void> UnlistedChannels::check_room(std::size_t channel, const UnlistedChannel& wanted,
                                          const IsUsed& is_used) const {
  std::set<std::size_t> networks(wanted.networks.begin(), wanted.networks.end());
  for (const UnlistedBinding& b : wanted.bindings) networks.insert(b.network);
  for (const std::size_t n : networks) {
    const auto there = std::ranges::count_if(networks_, [&](const auto& other) {
      return other.first != channel && is_used(other.first) && other.second.contains(n);
    });
    if (static_cast<std::size_t>(there) >= system_.networks[n].unlisted.most)
      return fail(system_.networks[n].name + " has " +
                  many(there, "channel that is", "channels that are") +
                  " not described, and its Unlisted allows no more");
  }
  return {};
}

Result<void> UnlistedChannels::check_same_identifiers(std::size_t channel,
                                                      const UnlistedChannel& wanted) const {
  for (const UnlistedBinding& b : wanted.bindings) {
    const Binding* const there = system_.networks[b.network].binding_of(channel);
    if (there != nullptr && there->id != b.id)
      return fail("channel " + system_.channels[channel].name + " is admitted on " +
                  system_.networks[b.network].name + " with another identifier");
  }
  return {};
}

void UnlistedChannels::forget(std::size_t channel) {
  names_.remove(system_.channels[channel]);
  for (const std::size_t n : networks_[channel])
    std::erase_if(system_.networks[n].bindings,
                  [channel](const Binding& b) { return b.channel == channel; });
  networks_.erase(channel);
  system_.channels[channel] = {};
  system_.channels[channel].unlisted = true;
}

bool UnlistedChannels::remove_unused(const IsUsed& is_used) {
  std::vector<std::size_t> unused;
  for (const auto& [channel, networks] : networks_)
    if (!is_used(channel)) unused.push_back(channel);
  for (const std::size_t channel : unused) forget(channel);
  return !unused.empty();
}

Result<std::size_t> UnlistedChannels::list(const UnlistedChannel& wanted,
                                           const std::vector<cluster::Foreign>& foreign,
                                           const IsUsed& is_used) {
  const std::string name = format_subject(wanted.subject);
  if (wanted.subject == 0) return fail("subject 0 is not valid: a channel has another one");
  remove_unused(is_used);
  const auto known = names_.channel_of(wanted.subject);
  if (known && !system_.channels[*known].unlisted)
    return fail(name + " is described as channel " + system_.channels[*known].name + ": name that");
  if (!known && names_.has_channel(name))
    return fail("a channel of another subject is called " + name);
  const auto at = known ? known : free_index(is_used);
  if (!at) {
    // A client that is refused for lack of room asks again. So a refusal that lasts comes first: a
    // subject that a network does not allow never has room.
    if (auto allowed = check_unlisted(system_, system_.channels.size(), wanted); !allowed)
      return std::unexpected(allowed.error());
    return fail("there is no room for another channel that is not described: " +
                std::to_string(networks_.size()) + " are admitted");
  }
  if (auto allowed = check_unlisted(system_, *at, wanted); !allowed)
    return std::unexpected(allowed.error());
  if (auto room = check_room(*at, wanted, is_used); !room) return std::unexpected(room.error());
  if (auto same = check_same_identifiers(*at, wanted); !same) return std::unexpected(same.error());
  if (auto free = check_foreign(system_, foreign, wanted); !free)
    return std::unexpected(free.error());
  EventChannel& channel = system_.channels[*at];
  channel.name = name;
  channel.subject = wanted.subject;
  names_.add(channel, *at);
  auto& networks = networks_[*at];
  networks.insert(wanted.networks.begin(), wanted.networks.end());
  for (const UnlistedBinding& b : wanted.bindings) {
    networks.insert(b.network);
    Network& network = system_.networks[b.network];
    if (network.binding_of(*at) == nullptr) bind(network, *at, b);
  }
  return *at;
}

}  // namespace mlcca::core
