// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/audit_rules.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "bpf/gate.h"
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

/// The bits that hold the priority; 0 if the profile has none.
std::uint32_t priority_bits(const core::ProfileTraits& traits) {
  const auto id_of = [&traits](std::uint8_t priority) {
    core::Publisher publisher;
    publisher.node = 0;
    core::Binding binding;
    if (traits.has_sender_priority) publisher.priority = priority;
    if (traits.has_number_priority) binding.priority = priority;
    return traits.identity(publisher, binding, false).id;
  };
  std::uint32_t bits = 0;
  for (unsigned priority = 1; priority < 256; priority *= 2)
    bits |= id_of(0) ^ id_of(static_cast<std::uint8_t>(priority));
  return bits & core::kExtendedBits;
}

/// The bits that say whether a frame is a fragment; 0 if the profile has none.
std::uint32_t fragment_bits(const core::ProfileTraits& traits) {
  core::Publisher publisher;
  publisher.node = 0;
  const auto mask_of = [&](bool fragmented) {
    return traits.identity(publisher, core::Binding{}, fragmented).mask;
  };
  return mask_of(false) ^ mask_of(true);
}

/// In what a frame differs from one of a publisher's; nullopt if it is none of its channel.
std::optional<std::vector<std::string>> names_of(std::uint32_t different,
                                                 const core::ProfileTraits& traits) {
  std::vector<std::string> out;
  const auto take = [&](std::uint32_t bits, const char* name) {
    if ((different & bits) != 0) out.emplace_back(name);
    different &= ~bits;
  };
  take(priority_bits(traits), "priority");
  take(fragment_bits(traits), "fragment");
  take(core::kRemoteFlag, "remote");
  if (different != 0) return std::nullopt;
  return out;
}

void add_identifiers(const core::Network& network,
                     std::map<std::uint32_t, std::unordered_map<std::uint32_t, std::size_t>>& to) {
  core::Publisher anyone;
  anyone.node = 0;
  const core::ProfileTraits& traits = core::traits_of(network.profile);
  const std::uint32_t number =
      traits.deals_tags ? traits.last : traits.number_bits | traits.destination_bits;
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

AuditRules::AuditRules(const Scene& scene, const PortFacts& gates) : gates_(gates) {
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
    // The MAC address of a frame with another address is not its station.
    const std::string& station = frame.address.empty() ? frame.mac : frame.address;
    if (core::to_text(sender.station) != station) return false;
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
  if (of != nullptr && core::names_channels(of->profile)) add_identifiers(*of, known->second);
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

bool AuditNames::has_number(const control::Finding& frame) {
  const auto channel = channel_named(frame.described);
  const core::Network* const network = network_named(frame.network);
  const core::Binding* const binding =
      channel && network != nullptr ? network->binding_of(*channel) : nullptr;
  return binding != nullptr && !binding->waits_for_tag();
}

std::string AuditNames::network_of(const std::string& interface) const {
  for (std::size_t p = 0; p < gates_.size(); ++p)
    if (gates_.interface_name(p) == interface) return gates_.network_of(p);
  return {};
}

/// The bits of the frame that the rules of a publisher do not admit, of the rule that is nearest;
/// nullopt if it has none there.
std::optional<std::uint32_t> AuditNames::difference(std::size_t port, std::size_t channel,
                                                    std::size_t publisher,
                                                    const control::Finding& frame) const {
  const core::State& state = *scene_.state;
  std::optional<std::uint32_t> least;
  for (const core::Verdict& v : state.decisions()[channel].verdicts) {
    if (v.publisher != publisher) continue;
    for (const core::GateRule& rule :
         core::gate_state(state.system(), state.members(), v, scene_.self)) {
      const core::GateEntry& e = rule.entry;
      if (e.port != port || (e.direction == core::Direction::egress) != frame.egress) continue;
      const std::uint32_t different = (e.id ^ frame.can_id) & e.mask;
      if (!least || std::popcount(different) < std::popcount(*least)) least = different;
    }
  }
  return least;
}

void AuditNames::compare(std::size_t port, control::Finding& frame) {
  const core::State& state = *scene_.state;
  const core::System& system = state.system();
  frame.publisher.clear();
  frame.differs.clear();
  const auto channel = channel_named(frame.described);
  const bool is_local = frame.egress && frame.entered_by.empty();
  const core::Network* const network =
      network_named(frame.entered_network.empty() ? frame.network : frame.entered_network);
  const core::Profile profile = gates_.profile(port);
  if (!channel || network == nullptr || !core::names_channels(network->profile) ||
      !core::names_channels(profile))
    return;
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
    if (((id ^ frame.can_id) & bits) != 0) continue;
    const auto different = difference(port, *channel, p, frame);
    auto names = names_of(different.value_or(0), core::traits_of(profile));
    if (!names) continue;
    frame.publisher = publisher.name;
    frame.differs = std::move(*names);
    return;
  }
}

std::uint64_t AuditNames::provided_period(const control::Finding& frame) const {
  Value longest = 0;
  const auto take = [&longest](const AttributeSet& provision) {
    if (provision.has(Attribute::period))
      longest = std::max<Value>(longest, provision[Attribute::period]);
  };
  for (const std::string& name : {frame.network, frame.entered_network})
    if (const core::Network* const network = network_named(name)) take(network->provision);
  take(scene_.state->system().gateways[scene_.self].provision);
  return longest;
}

}  // namespace mlcca
