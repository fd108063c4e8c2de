// SPDX-License-Identifier: BSD-2-Clause
// Names become indices: user-defined attributes, channels, networks, gateways. Meshes follow in
// mesh.cc, publishers and subscribers in ends.cc, declared routes in routes.cc.
#include "description/resolve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string_view>
#include <utility>

namespace mlcca::description {
namespace {

using core::FindingId;
using core::NetworkKind;
using core::Profile;

void add_user_attributes(const Draft& draft, Resolved& to, Problems& problems) {
  for (const auto& d : draft.user_attributes) {
    const auto& attribute = d.attribute;
    if (attribute_named(attribute.name) != nullptr)
      problems.add(attribute.origin, "UserAttribute",
                   fmt::format("{} is built in: choose another name", attribute.name),
                   FindingId::name_twice);
    if (attribute.composition == Composition::survival &&
        (d.dimension.unit != Unit{} || d.dimension.magnitude != kSurvivalMagnitude))
      problems.add(attribute.origin, "UserAttribute",
                   "Composition survival is for a fraction up to 1: a Dimension without SIUnit and "
                   "with Magnitude -9",
                   FindingId::wrong_place);
    if ((attribute.better == Better::larger) != (attribute.composition == Composition::smallest))
      problems.add(attribute.origin, "UserAttribute",
                   "a way must not be better than its hops: Better larger goes with Composition "
                   "minimum, Better smaller with sum, maximum or survival");
    to.system.user_attributes.push_back(attribute);
  }
  // The System's are complete now: their addresses stay.
  for (std::size_t i = 0; i < draft.user_attributes.size(); ++i)
    to.user_attributes.push_back(
        {&to.system.user_attributes[i], draft.user_attributes[i].dimension.unit});
}

/// Several sets have a priority each, and are sorted by it.
void order_sets(ChannelDraft& draft, const std::vector<std::string>& files, Problems& problems) {
  auto& sets = draft.sets;
  if (sets.size() < 2) return;
  for (const auto& set : sets)
    if (!set.priority)
      problems.add(set.origin, "Attributes",
                   "attribute priority is missing: with several sets each has one",
                   FindingId::rule);
  std::ranges::stable_sort(sets, std::ranges::greater{},
                           [](const StatedDraft& s) { return s.priority.value_or(0); });
  for (std::size_t i = 1; i < sets.size(); ++i)
    if (sets[i].priority && sets[i].priority == sets[i - 1].priority)
      problems.add(
          sets[i].origin, "Attributes",
          fmt::format("priority {} is already that of the set in {}: each has its own",
                      *sets[i].priority, line_words(files, sets[i].origin, sets[i - 1].origin)),
          FindingId::name_twice);
}

void add_channels(Draft& draft, Resolved& to, Problems& problems) {
  to.system.channels.reserve(draft.channels.size());
  for (; !draft.channels.empty(); draft.channels.pop_front()) {
    auto& d = draft.channels.front();
    order_sets(d, problems.files(), problems);
    auto& channel = to.system.channels.emplace_back(std::move(d.channel));
    for (std::size_t i = 0; i < d.sets.size(); ++i) {
      auto user = user_values(d.sets[i].user, to.user_attributes, Side::requirement, problems);
      const int priority = d.sets[i].priority.value_or(0);
      if (i == 0) {
        channel.attributes = d.sets[i].set;
        channel.user = std::move(user);
        channel.priority = priority;
      } else {
        channel.lower.push_back({priority, d.sets[i].set, std::move(user)});
      }
    }
  }
  to.channels.reserve(to.system.channels.size());
  for (const auto& c : to.system.channels) to.channels.add(c.name);
}

void check_form(const BindingDraft& b, const core::Network& network, Problems& problems) {
  const auto say = [&](std::string_view text) {
    problems.add(b.binding.origin, "Binding", text, FindingId::wrong_place);
  };
  if (network.kind != NetworkKind::can)
    say(fmt::format("only a CAN network has bindings, and {} is none: remove it", network.name));
  if (network.profile == Profile::famouso && !b.etag)
    say("an Identifier is for profile raw: profile famouso needs an ETag");
  if (network.profile == Profile::raw && b.etag)
    say("an ETag is for profile famouso: profile raw needs an Identifier");
  if (network.profile == Profile::famouso && b.binding.remote_frames)
    say("remote-frames is for profile raw: FAMOUSO has no remote frames");
}

void add_network(const NetworkDraft& from, Resolved& to, Problems& problems) {
  auto& network = to.system.networks.emplace_back(from.network);
  network.provision = from.provision.set;
  network.user = user_values(from.provision.user, to.user_attributes, Side::provision, problems);
  network.bindings.reserve(from.bindings.size());
  for (const auto& b : from.bindings) {
    const auto channel = to.channel_named(b.channel, b.binding.origin, "Binding", problems);
    check_form(b, network, problems);
    if (!channel) continue;
    network.bindings.push_back(b.binding);
    network.bindings.back().channel = *channel;
  }
}

void add_gateway(const GatewayDraft& from, Resolved& to, Problems& problems) {
  auto& gateway = to.system.gateways.emplace_back(from.gateway);
  gateway.provision = from.provision.set;
  gateway.user = user_values(from.provision.user, to.user_attributes, Side::provision, problems);
  for (const auto& p : from.ports) {
    const auto network = to.networks.find(p.network, p.port.origin, "Port", problems);
    if (!network) continue;
    if (p.states_queue && to.system.networks[*network].kind != NetworkKind::can)
      problems.add(p.port.origin, "Port",
                   fmt::format("queue, fifo-depth and queue-length are for CAN, and {} is no CAN "
                               "network: remove them",
                               p.network),
                   FindingId::wrong_place);
    gateway.ports.push_back(p.port);
    gateway.ports.back().network = *network;
  }
}

}  // namespace

std::optional<std::size_t> Resolved::channel_named(std::string_view name, core::Origin origin,
                                                   std::string_view element, Problems& problems) {
  if (const auto found = channels.find(name)) return found;
  if (!name.starts_with("0x")) return channels.find(name, origin, element, problems);
  if (by_subject.empty())
    for (std::size_t i = 0; i < system.channels.size(); ++i)
      by_subject.try_emplace(system.channels[i].subject, i);
  core::Subject subject = 0;
  std::from_chars(name.begin() + 2, name.end(), subject, 16);
  if (const auto found = by_subject.find(subject); found != by_subject.end()) return found->second;
  return channels.find(name, origin, element, problems);
}

core::System resolve(Draft draft, Problems& problems, Users users) {
  Resolved to;
  to.system.name = draft.name;
  to.system.files = problems.files();
  add_user_attributes(draft, to, problems);
  add_channels(draft, to, problems);
  for (const auto& n : draft.networks) to.networks.add(n.network.name);
  for (const auto& n : draft.networks) add_network(n, to, problems);
  for (const auto& g : draft.gateways) to.gateways.add(g.gateway.name);
  for (const auto& g : draft.gateways) add_gateway(g, to, problems);
  add_meshes(draft, to, problems);
  add_ends(draft, to, problems, users);
  add_routes(draft, to, problems);
  return std::move(to.system);
}

}  // namespace mlcca::description
