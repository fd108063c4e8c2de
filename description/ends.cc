// SPDX-License-Identifier: BSD-2-Clause
// Resolves publishers and subscribers: their places, who may send, and what they state in each
// attribute set of their channel.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <expected>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "description/resolve.hpp"
#include "description/users.hpp"

namespace mlcca::description {
namespace {

using core::FindingId;
using core::Place;
using core::Profile;

constexpr unsigned kMaxPriority = 0x7f;
constexpr std::string_view kOnePlace =
    "it is at one place: either attribute network or attribute gateway is needed";

/// Numbers ends without a name of their own, for each channel and place.
class Counter {
 public:
  void reset(std::size_t channels) { first_.assign(channels, {}); }

  /// Returns 1 for the first end of the channel at that place, 2 for the second, and so on.
  unsigned next(std::size_t channel, const std::string& where) {
    const auto hash = std::hash<std::string>{}(where);
    auto& first = first_[channel];
    if (first.count == 0) first.hash = hash;
    if (first.hash == hash) return ++first.count;
    // If two texts have the same hash, the second gets a number without need, which does no harm.
    return ++others_[{channel, hash}];
  }

 private:
  struct First {
    std::size_t hash = 0;
    unsigned count = 0;
  };
  std::vector<First> first_;  ///< for each channel; nearly all have one place only
  std::map<std::pair<std::size_t, std::size_t>, unsigned> others_;
};

class Ends {
 public:
  Ends(Draft& draft, Resolved& to, Problems& problems, Users users)
      : draft_(draft), to_(to), problems_(problems), users_of_(users) {}

  void run() {
    add_senders();
    place_components();
    to_.system.publishers.reserve(draft_.publishers.size());
    unnamed_publishers_.reset(to_.system.channels.size());
    for (; !draft_.publishers.empty(); draft_.publishers.pop_front())
      add_publisher(draft_.publishers.front());
    to_.system.subscribers.reserve(draft_.subscribers.size());
    unnamed_subscribers_.reset(to_.system.channels.size());
    for (; !draft_.subscribers.empty(); draft_.subscribers.pop_front())
      add_subscriber(draft_.subscribers.front());
    for (auto& component : draft_.components)
      to_.system.components.push_back(std::move(component.component));
  }

 private:
  void say(FindingId id, core::Origin origin, std::string_view element, std::string_view text) {
    problems_.add(origin, element, text, id);
  }

  // --- components --------------------------------------------------------------------------------

  void place_components() {
    Index names("component");
    for (const auto& c : draft_.components) names.add(c.component.name);
    // Where it was stated at which place, and at which node of a mesh, a component is.
    using Where = std::pair<core::Origin, std::string_view>;
    struct Stated {
      Where place;
      Where node;
    };
    std::vector<Stated> stated;
    stated.reserve(draft_.components.size());
    for (const auto& c : draft_.components) {
      const Where own{c.component.origin, "Component"};
      stated.push_back({own, own});
    }
    for (auto& placement : draft_.placements) {
      const auto found = names.find(placement.component, placement.origin, "Placement", problems_);
      if (!found) continue;
      auto& component = draft_.components[*found];
      if (has_place(component.seat)) {
        say(FindingId::unplaced, placement.origin, "Placement",
            fmt::format("component {} already has its place: one is enough", placement.component));
        continue;
      }
      const Where here{placement.origin, "Placement"};
      stated[*found].place = here;
      if (!placement.seat.mesh_node.empty()) stated[*found].node = here;
      inherit_sender(placement.seat, component.seat);
      if (placement.seat.mesh_node.empty()) placement.seat.mesh_node = component.seat.mesh_node;
      component.seat = std::move(placement.seat);
    }
    for (std::size_t i = 0; i < draft_.components.size(); ++i) {
      auto& c = draft_.components[i];
      const auto& [place, node] = stated[i];
      mesh_nodes_.emplace_back();
      places_.emplace_back();
      if (has_place(c.seat))
        places_.back() = place_of(c.seat, place.first, place.second);
      else
        say(FindingId::unplaced, c.component.origin, "Component",
            fmt::format("component {0} sits nowhere: add attribute network or gateway, or "
                        "<Placement component=\"{0}\" network=\"…\"/>",
                        c.component.name));
      if (!places_.back()) continue;
      c.component.place = *places_.back();
      mesh_nodes_.back() = mesh_node_of(c.seat, *places_.back(), node.first, node.second);
    }
  }

  static bool has_place(const SeatDraft& seat) {
    return !seat.network.empty() || !seat.gateway.empty();
  }

  /// Takes over what identifies a sender from the outer seat, unless the own one states it.
  static void inherit_sender(SeatDraft& own, const SeatDraft& outer) {
    if (own.user.empty()) own.user = outer.user;
    if (own.address.empty()) own.address = outer.address;
    if (!own.node) own.node = outer.node;
    if (!own.priority) own.priority = outer.priority;
  }

  // --- places ------------------------------------------------------------------------------------

  std::optional<Place> place_of(const SeatDraft& seat, core::Origin origin,
                                std::string_view element) {
    if (seat.network.empty() == seat.gateway.empty()) {
      say(FindingId::wrong_place, origin, element, kOnePlace);
      return std::nullopt;
    }
    const bool on_network = !seat.network.empty();
    const auto index = on_network ? to_.networks.find(seat.network, origin, element, problems_)
                                  : to_.gateways.find(seat.gateway, origin, element, problems_);
    if (!index) return std::nullopt;
    return Place{on_network ? Place::Kind::network : Place::Kind::gateway, *index};
  }

  /// The place of an end. An end in a component is where the component is, and must not state a
  /// place.
  std::optional<Place> place_of(const EndDraft& end, std::string_view element) {
    if (end.component == core::kNoComponent) return place_of(end.seat, end.origin, element);
    if (has_place(end.seat))
      say(FindingId::wrong_place, end.origin, element,
          fmt::format("it sits where component {} sits: remove its own network or gateway",
                      draft_.components[end.component].component.name));
    return places_[end.component];
  }

  /// The mesh node that a seat names; nullopt if it names none.
  std::optional<std::uint32_t> mesh_node_of(const SeatDraft& seat, Place place, core::Origin origin,
                                            std::string_view element) {
    if (seat.mesh_node.empty()) return std::nullopt;
    if (place.kind == Place::Kind::gateway) {
      say(FindingId::wrong_place, origin, element,
          "attribute mesh-node is for what sits on a network; the node of a gateway says so by its "
          "attribute gateway: remove it");
      return std::nullopt;
    }
    const auto nodes = to_.mesh_nodes.find(place.index);
    if (nodes == to_.mesh_nodes.end() || nodes->second.empty()) {
      say(FindingId::wrong_place, origin, element,
          fmt::format("attribute mesh-node is for a network with a Mesh that has nodes, and {} has "
                      "none: remove it",
                      to_.system.networks[place.index].name));
      return std::nullopt;
    }
    const auto found = nodes->second.find(seat.mesh_node, origin, element, problems_);
    return found ? std::optional(static_cast<std::uint32_t>(*found)) : std::nullopt;
  }

  /// The mesh node of an end. An end in a component is at the component's node unless it names one.
  std::optional<std::uint32_t> mesh_node_of(const EndDraft& end, Place place,
                                            std::string_view element) {
    if (end.component != core::kNoComponent && end.seat.mesh_node.empty())
      return mesh_nodes_[end.component];
    return mesh_node_of(end.seat, place, end.origin, element);
  }

  /// The name of an end: its own, or channel@place or channel@component, numbered from the second
  /// one on. Publishers and subscribers are numbered separately.
  std::string name_of(const EndDraft& end, std::size_t channel, Counter& counter) {
    if (!end.name.empty()) return end.name;
    const auto& where = name_of_place(end);
    std::string name = to_.system.channels[channel].name;
    name.append(1, '@').append(where);
    const auto count = counter.next(channel, where);
    return count == 1 ? name : fmt::format("{}#{}", name, count);
  }

  [[nodiscard]] const std::string& name_of_place(const EndDraft& end) const {
    if (end.component != core::kNoComponent) return draft_.components[end.component].component.name;
    return end.seat.network.empty() ? end.seat.gateway : end.seat.network;
  }

  // --- attribute sets ----------------------------------------------------------------------------

  /// Checks the attribute sets of an end: each must be for one of the channel's alternatives, and
  /// stated once.
  void check_sets(const core::EventChannel& channel, const EndDraft& end) {
    for (auto own = end.own.begin(); own != end.own.end(); ++own) {
      if (std::ranges::find(end.own.begin(), own, own->priority, &StatedDraft::priority) != own)
        say(FindingId::name_twice, own->origin, "Attributes",
            own->priority ? fmt::format("priority {} stands here a second time: state it once",
                                        *own->priority)
                          : "stands here a second time without a priority: state it once");
      if (own->priority && !has_set(channel, *own->priority))
        say(FindingId::unknown_name, own->origin, "Attributes",
            fmt::format("channel {} has no set of priority {}", channel.name, *own->priority));
    }
  }

  static bool has_set(const core::EventChannel& channel, int priority) {
    return (channel.priority == priority && !channel.lower.empty()) ||
           std::ranges::find(channel.lower, priority, &core::Alternative::priority) !=
               channel.lower.end();
  }

  /// What an end states in the channel's set of that priority.
  core::Alternative own_set(const core::Alternative& of_channel, const EndDraft& end) {
    core::Alternative out = of_channel;
    const auto add = [&](const StatedDraft& own) {
      out.attributes = description::with_own(out.attributes, own.set);
      out.user = description::with_own(
          out.user, user_values(own.user, to_.user_attributes, Side::requirement, problems_));
    };
    for (const auto& own : end.own)
      if (!own.priority) add(own);
    for (const auto& own : end.own)
      if (own.priority == of_channel.priority) add(own);
    return out;
  }

  /// Sets the attributes of an end for all alternatives. The channel's Jitter is what subscribers
  /// accept, and a publisher states its own; so `prepare` removes the channel's Jitter for
  /// publishers.
  template <class End, class Prepare>
  void set_attributes(End& out, const EndDraft& end, const Prepare& prepare) {
    const auto& channel = to_.system.channels[out.channel];
    if (!end.own.empty()) check_sets(channel, end);
    auto first = own_set(
        prepare(core::Alternative{channel.priority, channel.attributes, channel.user}), end);
    out.attributes = first.attributes;
    out.user = std::move(first.user);
    for (const auto& lower : channel.lower) out.lower.push_back(own_set(prepare(lower), end));
  }

  // --- ends --------------------------------------------------------------------------------------

  void add_publisher(EndDraft& end) {
    if (end.component != core::kNoComponent)
      inherit_sender(end.seat, draft_.components[end.component].seat);
    const auto channel = to_.channel_named(end.channel, end.origin, "Publisher", problems_);
    const auto place = place_of(end, "Publisher");
    std::optional<std::uint32_t> uid;
    std::optional<std::uint32_t> mesh_node;
    core::Station station;
    if (place) {
      mesh_node = mesh_node_of(end, *place, "Publisher");
      station = station_at(end, *place);
      check_sender(end, *place);
      uid = uid_at(end, *place);
    }
    if (!channel || !place) return;
    auto& out = to_.system.publishers.emplace_back();
    out.name = name_of(end, *channel, unnamed_publishers_);
    out.channel = *channel;
    out.place = *place;
    out.uid = uid;
    out.program_rule = program_rule_of(end, *place, "Publisher");
    out.mesh_node = mesh_node;
    out.station = station;
    out.component = end.component;
    out.origin = end.origin;
    if (end.seat.node) out.node = static_cast<std::uint8_t>(*end.seat.node);
    if (end.seat.priority) out.priority = static_cast<std::uint8_t>(*end.seat.priority);
    set_attributes(out, end, [](core::Alternative set) {
      set.attributes.clear(Attribute::jitter);
      return set;
    });
  }

  void add_subscriber(const EndDraft& end) {
    const auto channel = to_.channel_named(end.channel, end.origin, "Subscriber", problems_);
    const auto place = place_of(end, "Subscriber");
    std::optional<std::uint32_t> mesh_node;
    if (place) mesh_node = mesh_node_of(end, *place, "Subscriber");
    if (!channel || !place) return;
    auto& out = to_.system.subscribers.emplace_back();
    out.name = name_of(end, *channel, unnamed_subscribers_);
    out.channel = *channel;
    out.place = *place;
    out.mesh_node = mesh_node;
    out.component = end.component;
    out.program_rule = program_rule_of(end, *place, "Subscriber");
    out.origin = end.origin;
    set_attributes(out, end, std::identity{});
  }

  /// Checks the attributes node and priority of a publisher. A node is required if the profile of
  /// its network has nodes, and allowed if its events may reach such a network; only FAMOUSO has
  /// priorities.
  void check_sender(EndDraft& end, Place place) {
    const auto wrong = [&](std::string_view text) {
      say(FindingId::wrong_place, end.origin, "Publisher", text);
    };
    const auto& seat = end.seat;
    const auto& networks = to_.system.networks;
    // Networks whose frames carry the subject need no node.
    const auto of_frames = [](const core::Network& n) {
      return n.carries_subjects() ? Profile::none : n.profile;
    };
    const Profile here =
        place.kind == Place::Kind::network ? of_frames(networks[place.index]) : Profile::none;
    if (core::has_nodes(here) && !seat.node)
      say(FindingId::no_node, end.origin, "Publisher",
          fmt::format("attribute node is missing: on a network with profile {} it is {}",
                      core::words::kProfiles.of(here), core::traits_of(here).nodes));
    if (seat.node) {
      // The node may be needed on a network that the events reach, so the widest range is allowed.
      const core::ProfileTraits* widest = &core::traits_of(here);
      if (!core::has_nodes(here))
        for (const auto& network : networks)
          if (const auto& spoken = core::traits_of(of_frames(network));
              spoken.last_node > widest->last_node)
            widest = &spoken;
      if (widest->last_node < 0)
        wrong(
            fmt::format("attribute node is for {}, and no CAN network speaks one of them here: "
                        "remove it",
                        core::for_profiles_with([](const auto& p) { return p.last_node >= 0; })));
      else if (*seat.node > static_cast<unsigned>(widest->last_node))
        wrong(fmt::format("attribute node: {} is not right: {}", *seat.node, widest->nodes));
    }
    if (!seat.priority) return;
    if (std::ranges::none_of(networks, [&](const core::Network& n) {
          return core::traits_of(of_frames(n)).has_sender_priority;
        }))
      wrong(
          fmt::format("attribute priority is for {}, which no CAN network speaks here: remove it "
                      "({} have a priority in their Binding)",
                      core::for_profiles_with([](const auto& p) { return p.has_sender_priority; }),
                      core::elements_with([](const auto& p) { return p.has_number_priority; })));
    else if (*seat.priority > kMaxPriority)
      wrong(fmt::format("attribute priority: {} is not right: 0 (highest) to 127", *seat.priority));
  }

  core::Station station_at(const EndDraft& end, Place place) {
    const std::string& address = end.seat.address;
    if (address.empty()) return {};
    if (place.kind != Place::Kind::network ||
        !to_.system.networks[place.index].carries_subjects()) {
      say(FindingId::wrong_place, end.origin, "Publisher",
          fmt::format(
              "attribute address is for publishers on a network of kind udp-multicast, "
              "udp-broadcast, mesh or ieee802154 with {}: remove it",
              core::for_profiles_with([](const auto& p) { return p.datagrams != nullptr; })));
      return {};
    }
    const core::NetworkKind kind = to_.system.networks[place.index].kind;
    const auto station = core::station_on(kind, address);
    if (!station)
      say(FindingId::wrong_place, end.origin, "Publisher",
          fmt::format("attribute address: nobody sends from {}: state {}", address,
                      core::station_words(kind)));
    return station.value_or(core::Station{});
  }

  std::optional<std::uint32_t> uid_at(const EndDraft& end, Place place) {
    const auto wrong = [&](std::string_view text) {
      say(FindingId::wrong_place, end.origin, "Publisher", text);
    };
    const auto& user = end.seat.user;
    const bool local = place.kind == Place::Kind::gateway;
    if (user.empty()) {
      if (local) wrong("attribute user is missing: whose programs on the gateway may send");
      return std::nullopt;
    }
    if (!local) {
      wrong(
          "attribute user is for a program on a gateway; nobody knows a user behind a bus: "
          "remove it");
      return std::nullopt;
    }
    const auto& uid = user_named(user);
    if (uid) return *uid;
    say(uid.error().id, end.origin, "Publisher",
        fmt::format("attribute user: {}", uid.error().text));
    return std::nullopt;
  }

  /// Index of the rule in the system that restricts the programs of an end to a group or unit.
  std::uint32_t program_rule_of(const EndDraft& end, Place place, std::string_view element) {
    if (end.group.empty() && end.unit.empty()) return core::kAnyProgram;
    if (place.kind != Place::Kind::gateway) {
      say(FindingId::wrong_place, end.origin, element,
          fmt::format("attribute {} is for a program on a gateway: remove it",
                      end.group.empty() ? "unit" : "group"));
      return core::kAnyProgram;
    }
    core::ProgramRule rule{.gid = {}, .group = end.group, .unit = end.unit};
    if (!end.unit.empty() && !end.unit.ends_with(".service") && !end.unit.ends_with(".scope"))
      say(FindingId::wrong_place, end.origin, element,
          fmt::format("attribute unit: {} runs no programs: name a unit such as camera.service",
                      end.unit));
    if (!end.group.empty()) {
      const auto gid = users_of_ == Users::of_this_machine
                           ? gid_of(end.group)
                           : std::expected<std::uint32_t, NoUser>(0);  // no look-up is needed
      if (!gid)
        say(gid.error().id, end.origin, element,
            fmt::format("attribute group: {}", gid.error().text));
      else
        rule.gid = *gid;
    }
    auto& rules = to_.system.program_rules;
    const auto known = std::ranges::find(rules, rule);
    if (known != rules.end()) return static_cast<std::uint32_t>(known - rules.begin());
    rules.push_back(std::move(rule));
    return static_cast<std::uint32_t>(rules.size() - 1);
  }

  const std::expected<std::uint32_t, NoUser>& user_named(const std::string& user) {
    auto& known = known_users_[user];
    if (!known)
      known = users_of_ == Users::of_this_machine
                  ? uid_of(user)
                  : static_cast<std::uint32_t>(known_users_.size());  // only distinguishes users
    return *known;
  }

  void add_senders() {
    for (const PortSender& s : to_.port_senders) {
      core::Port& port = to_.system.gateways[s.gateway].ports[s.port];
      const auto& uid = user_named(s.user);
      if (uid)
        port.sender = *uid;
      else
        say(uid.error().id, port.origin, "Port",
            fmt::format("attribute sender: {}", uid.error().text));
    }
    // Without that user, only what mlcca-relay would carry is refused.
    for (core::Gateway& gateway : to_.system.gateways)
      if (gateway.forwarder == core::Forwarder::relay && needs_program(gateway))
        if (const auto& uid = user_named("mlcca-relay")) gateway.relay = *uid;
  }

  [[nodiscard]] bool needs_program(const core::Gateway& gateway) const {
    return gateway.ports.size() > 1 &&
           std::ranges::any_of(gateway.ports, [this](const core::Port& port) {
             return to_.system.networks[port.network].kind != core::NetworkKind::can;
           });
  }

  Draft& draft_;
  Resolved& to_;
  Problems& problems_;
  Users users_of_;
  std::vector<std::optional<Place>> places_;              ///< of the components
  std::vector<std::optional<std::uint32_t>> mesh_nodes_;  ///< of the components
  Counter unnamed_publishers_;
  Counter unnamed_subscribers_;
  std::map<std::string, std::optional<std::expected<std::uint32_t, NoUser>>> known_users_;
};

}  // namespace

void add_ends(Draft& draft, Resolved& to, Problems& problems, Users users) {
  Ends(draft, to, problems, users).run();
}

}  // namespace mlcca::description
