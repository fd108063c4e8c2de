// SPDX-License-Identifier: BSD-2-Clause
// Resolves names to indices: user-defined attributes, channels, networks, gateways. mesh.cc does
// that for meshes, ends.cc for publishers and subscribers, and routes.cc for declared routes.
#include "description/resolve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>
#include <utility>

#include "base/number.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "description/users.hpp"

namespace mlcca::description {
namespace {

using core::FindingId;
using core::NetworkKind;

constexpr unsigned kLastAddress = 255;  // of J1939: the global address

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
  // The vector is complete, so pointers to its elements stay valid.
  for (std::size_t i = 0; i < draft.user_attributes.size(); ++i)
    to.user_attributes.push_back(
        {&to.system.user_attributes[i], draft.user_attributes[i].dimension.unit});
}

/// Checks that each of several sets has a priority, and sorts them by it.
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

/// Checks that the binding has the element of the network's profile, and nothing that its profile
/// does not have.
void check_form(const BindingDraft& b, const core::Network& network, Problems& problems) {
  const auto say = [&](std::string_view text) {
    problems.add(b.binding.origin, "Binding", text, FindingId::wrong_place);
  };
  if (network.kind != NetworkKind::can)
    say(fmt::format("only a CAN network has bindings, and {} is none: remove it", network.name));
  if (b.destination && *b.destination > kLastAddress)
    say(fmt::format("attribute destination: {} is not right: 0 to 255 (255 is the global address)",
                    *b.destination));
  if (!core::names_channels(network.profile)) return;
  const auto& traits = core::traits_of(network.profile);
  const auto profile = core::words::kProfiles.of(network.profile);
  const auto deals_tags = [](const core::ProfileTraits& p) { return p.deals_tags; };
  if (b.binding.dynamic && !traits.deals_tags)
    say(fmt::format("dynamic is for {}, whose broker deals tags: profile {} needs {}",
                    core::for_profiles_with(deals_tags), profile, traits.element));
  else if (b.binding.dynamic && !b.element.empty())
    say("a dynamic binding has the tag that the broker deals: remove the ETag, or dynamic");
  else if (!b.binding.dynamic && b.element.empty())
    say(fmt::format("profile {} needs {}{}", profile, traits.element,
                    traits.deals_tags ? ", or dynamic=\"true\"" : ""));
  else if (!b.element.empty() && !traits.element.ends_with(" " + b.element)) {
    const auto* const owner =
        std::ranges::find_if(core::words::kProfiles, [&](std::string_view word) {
          return core::traits_of(core::words::kProfiles.or_first(word))
              .element.ends_with(" " + b.element);
        });
    say(fmt::format("{} is for profile {}: profile {} needs {}",
                    core::traits_of(core::words::kProfiles.or_first(*owner)).element, *owner,
                    profile, traits.element));
  }
  if (b.binding.remote_frames && !traits.remote_frames)
    say(fmt::format("remote-frames is for {}: {} has no remote frames",
                    core::for_profiles_with([](const auto& p) { return p.remote_frames; }),
                    profile));
  if (b.binding.format == core::FrameFormat::xl && !traits.xl)
    say(fmt::format("format xl is for {}: {} has no CAN XL frames",
                    core::for_profiles_with([](const auto& p) { return p.xl; }), profile));
}

/// The named kinds of control traffic as bits; nullopt if the attribute is absent or wrong.
std::optional<std::uint32_t> kinds_named(const std::string& words, const core::Network& network,
                                         const auto& say) {
  const auto kinds = core::control_kinds(network);
  const auto all = (std::uint32_t{1} << kinds.size()) - 1;
  if (words.empty()) return std::nullopt;
  if (words == "all") return all;
  if (words == "none") return 0;
  std::uint32_t bits = 0;
  for (const auto part : std::views::split(words, ' ')) {
    const std::string_view word(part.begin(), part.end());
    const auto found = std::ranges::find(kinds, word, &core::ControlKind::name);
    if (found != kinds.end()) {
      bits |= std::uint32_t{1} << (found - kinds.begin());
      continue;
    }
    std::string known;
    for (const auto& kind : kinds) known.append(known.empty() ? "" : ", ").append(kind.name);
    say(fmt::format(
        "attribute control: '{}' is no control traffic of profile {}: all, none, or some "
        "of {}",
        word, core::words::kProfiles.of(network.profile), known));
  }
  return bits;
}

core::ControlPolicy control_policy(const ControlDraft& from, const core::Network& network,
                                   core::Origin origin, std::string_view element,
                                   Problems& problems) {
  const auto say = [&](std::string_view text) {
    problems.add(origin, element, text, FindingId::wrong_place);
  };
  if (!from.states_something()) return {};
  if (core::control_kinds(network).empty()) {
    say(fmt::format(
        "{} has no control traffic: remove control, control-rate and control-user, which "
        "are for {}",
        network.name, core::for_profiles_with([](const auto& p) { return !p.control.empty(); })));
    return {};
  }
  return {.kinds = kinds_named(from.kinds, network, say), .rate = from.rate};
}

void add_network(const NetworkDraft& from, Resolved& to, Problems& problems) {
  auto& network = to.system.networks.emplace_back(from.network);
  network.control = control_policy(from.control, network, network.origin, "Network", problems);
  network.provision = from.provision.set;
  network.user = user_values(from.provision.user, to.user_attributes, Side::provision, problems);
  network.bindings.reserve(from.bindings.size());
  for (const auto& b : from.bindings) {
    const auto channel = to.channel_named(b.channel, b.binding.origin, "Binding", problems);
    check_form(b, network, problems);
    if (!channel) continue;
    auto& binding = network.bindings.emplace_back(b.binding);
    binding.channel = *channel;
    // A binding without identifier is reported already. It counts as one whose tag is not known
    // yet, so that its channel is not reported as unbound, too.
    if (b.element.empty()) binding.dynamic = true;
    if (b.destination) binding.destination = static_cast<std::uint8_t>(*b.destination);
  }
}

/// The user whose programs may send control traffic: root unless another one is named.
std::uint32_t control_user(const PortDraft& p, Users users, Problems& problems) {
  if (p.control.user.empty() || users != Users::of_this_machine) return 0;
  const auto uid = uid_of(p.control.user);
  if (uid) return *uid;
  problems.add(p.port.origin, "Port", fmt::format("attribute control-user: {}", uid.error().text),
               uid.error().id);
  return 0;
}

void set_node(const PortDraft& p, const core::Network& network, core::Port& port,
              Problems& problems) {
  if (!p.node) return;
  const bool has_broker = core::has_broker(network);
  const int last = core::traits_of(network.profile).last_node;
  if (has_broker && static_cast<int>(*p.node) <= last) {
    port.node = static_cast<std::uint8_t>(*p.node);
    return;
  }
  problems.add(
      port.origin, "Port",
      has_broker ? fmt::format("attribute node: {} is too large: at most {}", *p.node, last)
                 : fmt::format("attribute node: {} is no CAN network of {}: remove it", p.network,
                               core::for_profiles_with([](const auto& t) { return t.deals_tags; })),
      FindingId::wrong_place);
}

void add_gateway(const GatewayDraft& from, Resolved& to, Users users, Problems& problems) {
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
    if (!p.sender.empty())
      to.port_senders.push_back({to.system.gateways.size() - 1, gateway.ports.size(), p.sender});
    auto& port = gateway.ports.emplace_back(p.port);
    port.network = *network;
    port.control =
        control_policy(p.control, to.system.networks[*network], port.origin, "Port", problems);
    port.control_uid = control_user(p, users, problems);
    set_node(p, to.system.networks[*network], port, problems);
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
  const auto subject = number_in<core::Subject>(name.substr(2), kHexadecimalBase);
  if (const auto found = by_subject.find(subject.value_or(0)); found != by_subject.end())
    return found->second;
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
  for (const auto& g : draft.gateways) add_gateway(g, to, users, problems);
  add_meshes(draft, to, problems);
  add_ends(draft, to, problems, users);
  add_routes(draft, to, problems);
  return std::move(to.system);
}

}  // namespace mlcca::description
