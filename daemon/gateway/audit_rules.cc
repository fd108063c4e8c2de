// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/audit_rules.hpp"

#include <algorithm>
#include <limits>

#include "core/gates/control_traffic.hpp"
#include "core/model/text.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca {
namespace {

/// The bits of an identifier that hold the node number of the sender; 0 if the profile has none.
std::uint32_t node_bits(const core::ProfileTraits& traits) {
  const auto id_of = [&traits](std::uint8_t node) {
    core::Publisher publisher;
    publisher.node = node;
    return traits.identity(publisher, core::Binding{}, false).id;
  };
  std::uint32_t bits = 0;
  for (int node = 1; node <= traits.last_node; node *= 2)
    bits |= id_of(0) ^ id_of(static_cast<std::uint8_t>(node));
  return bits;
}

void add_identifiers(const core::Network& network,
                     std::map<std::uint32_t, std::unordered_map<std::uint32_t, std::size_t>>& to) {
  core::Publisher anyone;
  anyone.node = 0;
  const core::ProfileTraits& traits = core::traits_of(network.profile);
  const std::uint32_t number = traits.deals_tags ? traits.last : traits.number_bits;
  for (const core::Binding& binding : network.bindings) {
    if (binding.waits_for_tag()) continue;
    const core::FrameIdentity of = traits.identity(anyone, binding, false);
    const std::uint32_t id = of.id | (binding.extended ? core::kExtendedFlag : 0U);
    const std::uint32_t mask = (of.mask & number) | core::kExtendedFlag;
    to[mask].try_emplace(id & mask, binding.channel);
  }
}

}  // namespace

// --- rules ---------------------------------------------------------------------------------------

AuditRules::AuditRules(const Scene& scene, const GateDriver& gates) : gates_(gates) {
  const core::State& state = *scene.state;
  add(core::control_rules(state.system(), scene.self));
  add(core::gate_state(state.system(), state.members(), state.decisions(), scene.self));
}

void AuditRules::add(const core::GateState& rules) {
  for (const core::GateRule& rule : rules) {
    const core::GateEntry& e = rule.entry;
    by_gate_[{e.port, e.direction == core::Direction::egress, e.mask}].emplace(
        e.mask != 0 ? e.id : e.subject, Sender{.station = e.station,
                                               .source_port = e.source_port,
                                               .uid = e.uid,
                                               .from_kernel = e.from_kernel});
  }
}

bool AuditRules::any(std::size_t port, const control::Finding& frame, auto&& is_meant) const {
  const bool has_subject = frame.subject != 0;
  for (auto it = by_gate_.lower_bound({port, frame.egress, has_subject ? 0 : 1});
       it != by_gate_.end(); ++it) {
    const auto& [of_port, egress, mask] = it->first;
    if (of_port != port || egress != frame.egress || (has_subject && mask != 0)) break;
    const auto [first, last] =
        it->second.equal_range(has_subject ? frame.subject : frame.can_id & mask);
    if (std::any_of(first, last, [&](const auto& one) { return is_meant(one.second); }))
      return true;
  }
  return false;
}

bool AuditRules::has(std::size_t port, const control::Finding& frame) const {
  return any(port, frame, [](const Sender&) { return true; });
}

bool AuditRules::has_from_sender(std::size_t port, const control::Finding& frame) const {
  return any(port, frame, [&](const Sender& sender) { return is_of(sender, frame); });
}

bool AuditRules::is_of(const Sender& sender, const control::Finding& frame) const {
  if (!sender.station.is_wildcard()) {
    const std::string station = core::to_text(sender.station);
    if (station != frame.address && station != frame.mac) return false;
  }
  if (!frame.egress) return true;
  if (sender.from_kernel) return frame.entered_by == kFromKernel;
  if (sender.source_port) return gates_.interface_name(*sender.source_port) == frame.entered_by;
  return frame.user == std::to_string(sender.uid) ||
         (frame.entered_by.empty() && sender.uid == GATE_ANY_UID);
}

// --- names ---------------------------------------------------------------------------------------

std::string AuditNames::channel_of(const control::Finding& frame) {
  const core::State& state = *scene_.state;
  std::optional<std::size_t> channel;
  if (frame.subject != 0)
    channel = state.channel_of(frame.subject);
  else
    for (const auto& [mask, channels] : identifiers_of(frame.network))
      if (const auto found = channels.find(frame.can_id & mask); found != channels.end())
        channel = std::min(channel.value_or(found->second), found->second);
  return channel ? state.system().channels[*channel].name : std::string();
}

const core::Network* AuditNames::network_named(const std::string& name) const {
  const auto& networks = scene_.state->system().networks;
  const auto of = std::ranges::find(networks, name, &core::Network::name);
  return of == networks.end() ? nullptr : &*of;
}

const AuditNames::Identifiers& AuditNames::identifiers_of(const std::string& network) {
  const auto [known, fresh] = by_network_.try_emplace(network);
  if (!fresh) return known->second;
  const core::Network* const of = network_named(network);
  if (of != nullptr && of->profile != core::Profile::none) add_identifiers(*of, known->second);
  return known->second;
}

std::optional<std::size_t> AuditNames::channel_named(const std::string& name) {
  const auto& channels = scene_.state->system().channels;
  if (channels_.empty())
    for (std::size_t c = 0; c < channels.size(); ++c) channels_.emplace(channels[c].name, c);
  const auto found = channels_.find(name);
  return found == channels_.end() ? std::nullopt : std::optional(found->second);
}

bool AuditNames::has_channel(const std::string& name) { return channel_named(name).has_value(); }

std::string AuditNames::network_of(const std::string& interface) const {
  for (std::size_t p = 0; p < gates_.size(); ++p)
    if (gates_.interface_name(p) == interface) return gates_.network_of(p);
  return {};
}

std::string AuditNames::same_publisher(const control::Finding& frame) {
  const core::State& state = *scene_.state;
  const core::System& system = state.system();
  const auto channel = channel_named(frame.described);
  const bool is_local = frame.egress && frame.entered_by.empty();
  const core::Network* const network =
      network_named(frame.entered_network.empty() ? frame.network : frame.entered_network);
  if (!channel || network == nullptr || network->profile == core::Profile::none) return {};
  const core::Place place =
      is_local ? core::Place{core::Place::Kind::gateway, scene_.self}
               : core::Place{core::Place::Kind::network,
                             static_cast<std::size_t>(network - system.networks.data())};
  const core::ProfileTraits& traits = core::traits_of(network->profile);
  const std::uint32_t bits = node_bits(traits);
  for (const std::size_t p : state.members().publishers_of(*channel)) {
    const core::Publisher& publisher = state.members().publisher(p);
    if (publisher.place != place || (bits != 0 && !publisher.node)) continue;
    if (is_local && publisher.uid && frame.user != std::to_string(*publisher.uid)) continue;
    const std::uint32_t id = traits.identity(publisher, core::Binding{}, false).id;
    if (((id ^ frame.can_id) & bits) == 0) return publisher.name;
  }
  return {};
}

}  // namespace mlcca
