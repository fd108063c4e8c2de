// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/parsed_request.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "base/number.hpp"
#include "base/text.hpp"
#include "core/profiles/profile.hpp"
#include "daemon/gateway/requests/stated.hpp"
#include "mlcca/der_format.hpp"

namespace mlcca {
namespace {

constexpr std::size_t kNamesShown = 8;
constexpr std::uint32_t kHighestNode = 253;  // the highest one of any profile
constexpr std::uint32_t kLowestPriority = 127;
constexpr std::uint32_t kAnyUser = 0xffffffff;  // in a slot: every user may send

template <class Range>
std::string known(const Range& things) {
  std::vector<std::string> names;
  for (const auto& thing : things) {
    if (names.size() == kNamesShown) {
      names.emplace_back("…");
      break;
    }
    if (const std::string name(thing.name); !name.empty()) names.push_back(name);
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

Result<core::Place> place_named(const core::State& state, const std::string& name) {
  if (const auto place = state.find_place(name)) return *place;
  return fail(fmt::format("no network or gateway is called '{}' (networks: {}; gateways: {})",
                          echoed(name), known(state.system().networks),
                          known(state.system().gateways)));
}

/// The node of a mesh at which an end is; nullopt if the request states none.
Result<std::optional<std::uint32_t>> mesh_node_named(const core::State& state, core::Place place,
                                                     const std::string& name) {
  if (name.empty()) return std::nullopt;
  const core::System& system = state.system();
  const bool network = place.kind == core::Place::Kind::network;
  if (!network || !system.networks[place.index].mesh)
    return fail(
        fmt::format("{} is no mesh, and so has no node '{}'",
                    network ? system.networks[place.index].name : system.gateways[place.index].name,
                    echoed(name)));
  const auto& nodes = system.networks[place.index].mesh->nodes;
  const auto it = std::ranges::find(nodes, name, &core::mesh::Node::name);
  if (it == nodes.end())
    return fail(fmt::format("{} has no node '{}' (nodes: {})", system.networks[place.index].name,
                            echoed(name), known(nodes)));
  return static_cast<std::uint32_t>(it - nodes.begin());
}

/// The name of an end. Names are logged in one line, so control characters are not allowed.
Result<std::string> end_name(const std::string& given, const std::string& otherwise) {
  if (given.empty()) return otherwise;
  const bool plain = std::ranges::all_of(given, [](char c) { return c > ' ' && c < 127; });
  if (!plain || given.size() > der::kMaxName)
    return fail(
        fmt::format("a name has 1 to {} printable characters without blanks", der::kMaxName));
  return given;
}

/// Sets the attributes of a new end in each of the channel's attribute sets: those of the request,
/// and for all others what `kept` takes over from the channel.
template <class End, class Kept>
Result<void> set_attributes(End& end, const core::System& system,
                            const std::vector<control::Attribute>& stated, const Kept& kept) {
  const core::EventChannel& channel = system.channels[end.channel];
  auto first = overridden(kept(channel.attributes), system, stated);
  if (!first) return std::unexpected(first.error());
  auto own = overridden(channel.user, system, stated);
  if (!own) return std::unexpected(own.error());
  end.attributes = *first;
  end.user = std::move(*own);
  for (const core::Alternative& lower : channel.lower) {
    auto set = overridden(kept(lower.attributes), system, stated);
    if (!set) return std::unexpected(set.error());
    auto user = overridden(lower.user, system, stated);
    if (!user) return std::unexpected(user.error());
    end.lower.push_back({lower.priority, *set, std::move(*user)});
  }
  return {};
}

Result<core::Station> station_named(const core::State& state, core::Place place,
                                    const std::string& address) {
  if (address.empty()) return core::Station{};
  if (place.kind != core::Place::Kind::network ||
      !state.system().networks[place.index].carries_subjects())
    return fail(
        "an address is said only for a publisher on a network of kind udp-multicast, "
        "udp-broadcast, mesh or ieee802154 with " +
        core::for_profiles_with([](const auto& p) { return p.datagrams != nullptr; }));
  const core::NetworkKind kind = state.system().networks[place.index].kind;
  const auto station = core::station_on(kind, address);
  if (!station)
    return fail(
        fmt::format("no station sends from '{}': state {}", address, core::station_words(kind)));
  return *station;
}

Result<core::Publisher> new_publisher(const core::State& state,
                                      const control::ChannelRequest& request, std::size_t channel,
                                      core::Place from, core::AdmissionId id) {
  core::Publisher p;
  p.channel = channel;
  p.place = from;
  // The channel's Jitter is the requirement of subscribers. A publisher's Jitter is its own
  // statement.
  const auto stated = set_attributes(p, state.system(), request.offered, [](AttributeSet base) {
    return base.clear(Attribute::jitter);
  });
  if (!stated) return std::unexpected(stated.error());
  auto name = end_name(request.publisher, fmt::format("publisher-{}", id));
  if (!name) return std::unexpected(name.error());
  p.name = *name;
  const auto at = mesh_node_named(state, from, request.from_node);
  if (!at) return std::unexpected(at.error());
  p.mesh_node = *at;
  const auto station = station_named(state, from, request.address);
  if (!station) return std::unexpected(station.error());
  p.station = *station;
  if (request.node) {
    if (*request.node > kHighestNode)
      return fail(fmt::format("node {} is out of range: 0 to {}", *request.node, kHighestNode));
    p.node = static_cast<std::uint8_t>(*request.node);
  }
  if (request.priority) {
    if (*request.priority > kLowestPriority)
      return fail(fmt::format("priority {} is out of range: 0 (highest) to {}", *request.priority,
                              kLowestPriority));
    p.priority = static_cast<std::uint8_t>(*request.priority);
  }
  if (from.kind == core::Place::Kind::gateway) {
    if (request.user.empty())
      return fail("a publisher on a gateway is a local program: say as which user it runs");
    if (const auto number = number_in<std::uint32_t>(request.user)) {
      if (*number == kAnyUser)
        return fail(fmt::format("{} is not a user number: at most {}", *number, kAnyUser - 1));
      p.uid = number;
      return p;
    }
    // The name is not looked up here, because a directory service may take any time.
    return fail(
        fmt::format("user '{}': a request says a user by number, such as 1000 (mlccactl "
                    "turns names into numbers)",
                    request.user));
  }
  if (!request.user.empty()) return fail("a user is said only for a publisher on a gateway");
  return p;
}

Result<core::Subscriber> new_subscriber(const core::State& state,
                                        const control::ChannelRequest& request, std::size_t channel,
                                        core::Place to, core::AdmissionId id) {
  core::Subscriber s;
  s.channel = channel;
  s.place = to;
  const auto stated = set_attributes(s, state.system(), request.required,
                                     [](const AttributeSet& base) { return base; });
  if (!stated) return std::unexpected(stated.error());
  auto name = end_name(request.subscriber, fmt::format("subscriber-{}", id));
  if (!name) return std::unexpected(name.error());
  s.name = *name;
  const auto at = mesh_node_named(state, to, request.to_node);
  if (!at) return std::unexpected(at.error());
  s.mesh_node = *at;
  return s;
}

bool describes_subscriber(const control::ChannelRequest& r) {
  return !r.required.empty() || !r.subscriber.empty() || !r.to_node.empty();
}

/// The index of the network with this name; nullopt for a gateway.
Result<std::optional<std::size_t>> network_named(const core::State& state,
                                                 const std::string& name) {
  const auto place = place_named(state, name);
  if (!place) return std::unexpected(place.error());
  if (place->kind == core::Place::Kind::gateway) return std::nullopt;
  return place->index;
}

Result<void> add_identifier(const core::State& state, const control::Identifier& identifier,
                            core::UnlistedChannel& wanted) {
  const auto network = network_named(state, identifier.network);
  if (!network) return std::unexpected(network.error());
  if (!*network)
    return fail(
        fmt::format("{} is a gateway: identifiers are of CAN networks", identifier.network));
  if (std::ranges::find(wanted.bindings, **network, &core::UnlistedBinding::network) !=
      wanted.bindings.end())
    return fail(fmt::format("{} is given two identifiers", identifier.network));
  wanted.bindings.push_back({**network, identifier.id, identifier.extended});
  return {};
}

}  // namespace

bool describes_publisher(const control::ChannelRequest& request) {
  return request.node || request.priority || !request.user.empty() || !request.offered.empty() ||
         !request.publisher.empty() || !request.from_node.empty() || !request.address.empty();
}

Result<void> list(core::State& state, const control::ChannelRequest& request) {
  if (!request.unlisted) {
    if (request.identifiers.empty()) return {};
    return fail("identifiers of a channel are described, except for one that is not described");
  }
  constexpr std::size_t most_identifiers = 16;
  if (request.identifiers.size() > most_identifiers)
    return fail(fmt::format("at most {} identifiers", most_identifiers));
  const auto subject = core::parse_subject(request.channel);
  if (!subject)
    return fail(fmt::format("'{}' is no subject: 0x and up to 16 hexadecimal digits",
                            echoed(request.channel)));
  core::UnlistedChannel wanted{.subject = *subject, .networks = {}, .bindings = {}};
  for (const std::string& end : {request.from, request.to}) {
    if (end.empty()) continue;
    const auto network = network_named(state, end);
    if (!network) return std::unexpected(network.error());
    if (*network) wanted.networks.push_back(**network);
  }
  for (const control::Identifier& identifier : request.identifiers)
    if (const auto added = add_identifier(state, identifier, wanted); !added)
      return std::unexpected(added.error());
  const auto listed = state.list(wanted);
  if (!listed) return std::unexpected(listed.error());
  return {};
}

std::string echoed(const std::string& name) {
  constexpr std::size_t most = 64;
  return printable(name, most) + (name.size() > most ? "…" : "");
}

Result<std::size_t> channel_named(const core::State& state, const std::string& name) {
  if (const auto channel = state.find_channel(name)) return *channel;
  return fail(fmt::format("no event channel is called '{}' (channels: {})", echoed(name),
                          known(state.system().channels)));
}

namespace {

/// The gateway that has the publisher's node number on the publisher's network: it uses this number
/// to ask for tags. nullptr if there is none.
const core::Gateway* gateway_with_node_of(const core::System& system, const core::Publisher& p) {
  const auto found = std::ranges::find_if(system.gateways, [&](const core::Gateway& g) {
    return std::ranges::any_of(g.ports, [&](const core::Port& port) {
      return p.node && port.node == p.node && port.network == p.place.index;
    });
  });
  return found == system.gateways.end() ? nullptr : &*found;
}

/// Refuses a publisher on a network that cannot be distinguished from another one, because each
/// would use the other's grant. Several programs of one user on a gateway are allowed, and share
/// their limit.
Result<void> check_sender(const core::State& state, const core::Publisher& newcomer) {
  if (newcomer.place.kind == core::Place::Kind::gateway) return {};
  if (const auto* const other = gateway_with_node_of(state.system(), newcomer))
    return fail(fmt::format("node {} on {} is gateway {}'s: choose another", *newcomer.node,
                            state.system().networks[newcomer.place.index].name, other->name));
  const auto sender = core::sender_of(state.system(), newcomer);
  if (!sender) return {};
  const auto& members = state.members();
  for (const std::size_t p : members.publishers_of(newcomer.channel))
    if (core::sender_of(state.system(), members.publisher(p)) == sender)
      return fail(fmt::format(
          "nothing distinguishes it from publisher {} of channel {}: {}", members.publisher(p).name,
          state.system().channels[newcomer.channel].name, core::way_to_differ(newcomer)));
  return {};
}

/// Whether a new publisher states its traffic, so that it can be policed. Without that it could
/// fill a network.
bool states_traffic(const core::Publisher& p) {
  return p.attributes.has(Attribute::bandwidth) ||
         (p.attributes.has(Attribute::period) && p.attributes.has(Attribute::max_payload));
}

/// Finds the publisher that the request means: an existing one, or a new one, which is added to
/// `admission`.
Result<void> understand_publisher(const core::State& state, const control::ChannelRequest& request,
                                  ParsedRequest& asked, core::Admission& admission) {
  if (request.from.empty()) {
    if (!describes_publisher(request)) return {};
    return fail("a new publisher needs its place: say from which network or gateway");
  }
  const auto from = place_named(state, request.from);
  if (!from) return std::unexpected(from.error());
  const auto& members = state.members();
  const bool there = std::ranges::any_of(members.publishers_of(asked.channel), [&](std::size_t p) {
    return members.publisher(p).place == *from;
  });
  if (there && !describes_publisher(request)) {
    asked.from = *from;
    return {};
  }
  auto publisher = new_publisher(state, request, asked.channel, *from, admission.id);
  if (!publisher) return std::unexpected(publisher.error());
  if (const auto alone = check_sender(state, *publisher); !alone)
    return std::unexpected(alone.error());
  if (state.system().channels[asked.channel].unlisted && !states_traffic(*publisher))
    return fail(
        "a channel that is not described needs the traffic of its publisher: offer Period and "
        "MaxPayload, or Bandwidth");
  admission.publisher = std::move(*publisher);
  return {};
}

Result<void> understand_subscriber(const core::State& state, const control::ChannelRequest& request,
                                   ParsedRequest& asked, core::Admission& admission) {
  if (request.to.empty()) {
    if (!describes_subscriber(request)) return {};
    return fail("a new subscriber needs its place: say to which network or gateway");
  }
  const auto to = place_named(state, request.to);
  if (!to) return std::unexpected(to.error());
  const auto& members = state.members();
  const bool there = std::ranges::any_of(members.subscribers_of(asked.channel), [&](std::size_t s) {
    return members.subscriber(s).place == *to;
  });
  if (there && !describes_subscriber(request)) {
    asked.to = *to;
    return {};
  }
  auto subscriber = new_subscriber(state, request, asked.channel, *to, admission.id);
  if (!subscriber) return std::unexpected(subscriber.error());
  admission.subscriber = std::move(*subscriber);
  return {};
}

}  // namespace

Result<ParsedRequest> understand(const core::State& state, const control::ChannelRequest& request,
                                 core::AdmissionId id) {
  const auto channel = channel_named(state, request.channel);
  if (!channel) return std::unexpected(channel.error());
  ParsedRequest asked{.channel = *channel, .from = {}, .to = {}, .admission = {}};
  core::Admission admission{.id = id, .channel = *channel, .publisher = {}, .subscriber = {}};
  if (const auto ok = understand_publisher(state, request, asked, admission); !ok)
    return std::unexpected(ok.error());
  if (const auto ok = understand_subscriber(state, request, asked, admission); !ok)
    return std::unexpected(ok.error());
  if (admission.publisher || admission.subscriber) asked.admission = std::move(admission);
  return asked;
}

Result<void> check_key(const std::string& key) {
  constexpr std::size_t longest = 255;
  const auto is_control = [](unsigned char c) { return c < ' ' || c == 127; };
  if (key.size() <= longest && std::ranges::none_of(key, is_control)) return {};
  return fail(fmt::format("a key has up to {} bytes, none of them a control character", longest));
}

std::uint64_t lease_of(const control::Admit& request) {
  constexpr std::uint64_t of_a_connection = 10'000'000'000;
  return request.hold && request.lease_ns == 0 ? of_a_connection : request.lease_ns;
}

}  // namespace mlcca
