// SPDX-License-Identifier: BSD-2-Clause
// The rules for channels, networks, publishers and subscribers. Those for gateways are in ports.cc,
// those for meshes in mesh_rules.cc.
#include "description/rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/gates/control_traffic.hpp"
#include "core/model/medium.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "description/names.hpp"

namespace mlcca::description {
namespace {

using core::Binding;
using core::FindingId;
using core::FrameFormat;
using core::NetworkKind;
using core::Place;

void check_binding(const core::Network& network, const Binding& b, Problems& problems) {
  const auto say = [&](std::string_view text) {
    problems.add(b.origin, "Binding", text, FindingId::wrong_place);
  };
  if (!b.dynamic)  // otherwise its tag is not known yet
    for (const auto& problem : core::traits_of(network.profile).problems(b)) say(problem);
  if (b.remote_frames && b.format != FrameFormat::classic && b.format != FrameFormat::any)
    say("there are no FD remote frames: remote-frames needs format classic or any");
}

std::string identifier_words(const core::Network& network, const Binding& b) {
  const auto& traits = core::traits_of(network.profile);
  if (traits.form != core::IdentifierForm::stated)
    return std::string(traits.element.substr(traits.element.find(' ') + 1));
  const std::string mask = b.is_masked() ? fmt::format(" of mask 0x{:x}", b.mask) : "";
  return (b.extended ? "extended identifier" : "standard identifier") + mask;
}

/// The bindings of a network, sorted by a key, so that those with equal keys are neighbours.
template <class Key>
std::vector<const Binding*> sorted_by(const core::Network& network, const Key& key) {
  std::vector<const Binding*> out;
  out.reserve(network.bindings.size());
  for (const auto& b : network.bindings) out.push_back(&b);
  // Most descriptions are sorted already.
  if (!std::ranges::is_sorted(out, {}, key)) std::ranges::stable_sort(out, {}, key);
  return out;
}

/// Checks that no range of identifiers contains the identifier of another binding.
void check_masks(const core::System& system, const core::Network& network, Problems& problems) {
  std::vector<const Binding*> masked;
  for (const auto& b : network.bindings)
    if (b.is_masked()) masked.push_back(&b);
  if (masked.size() > kMaxMasks) {
    problems.add(masked[kMaxMasks]->origin, "Binding",
                 fmt::format("{} masks on {} are too many: at most {}", masked.size(), network.name,
                             kMaxMasks),
                 FindingId::too_many);
    return;
  }
  for (const auto* m : masked)
    for (const auto& b : network.bindings) {
      // Of two masks the later one is reported. Equal identifiers are reported elsewhere.
      const bool reported = &b == m || (b.is_masked() && &b > m) || b.id == m->id;
      if (reported || !core::clash(network.profile, *m, b)) continue;
      problems.add(
          m->origin, "Binding",
          fmt::format("{} 0x{:x} has {} 0x{:x} of channel {} in it, from {}: each "
                      "identifier is one channel's",
                      identifier_words(network, *m), m->id, identifier_words(network, b), b.id,
                      system.channels[b.channel].name, line_words(system, m->origin, b.origin)),
          FindingId::identifier_clash);
      break;
    }
}

/// Checks the tag of FAMOUSO's subject SUBSCRIB: it must be a valid tag that no channel has.
void check_subscribe_tag(const core::System& system, const core::Network& network,
                         Problems& problems) {
  if (!network.states_subscribe_tag) return;
  const auto say = [&](std::string_view text, FindingId id) {
    problems.add(network.origin, "Network", fmt::format("attribute subscribe-etag: {}", text), id);
  };
  if (!core::has_broker(network)) {
    say(fmt::format("{} is no CAN network of {}: remove it", network.name,
                    core::for_profiles_with([](const auto& p) { return p.deals_tags; })),
        FindingId::wrong_place);
    return;
  }
  const auto& traits = core::traits_of(network.profile);
  if (network.subscribe_tag < traits.first || network.subscribe_tag > traits.last)
    say(fmt::format("0x{:x} is not right: 0x{:x} to 0x{:x}", network.subscribe_tag, traits.first,
                    traits.last),
        FindingId::wrong_place);
  for (const auto& b : network.bindings)
    if (b.id == network.subscribe_tag)
      say(fmt::format("0x{:x} is channel {}'s, from {}: each tag is one subject's", b.id,
                      system.channels[b.channel].name,
                      line_words(system, network.origin, b.origin)),
          FindingId::identifier_clash);
  for (const auto& c : system.channels)
    if (c.subject == core::kSubscribeSubject)
      say(fmt::format("channel {} has the subject SUBSCRIB: remove it, and bind the channel",
                      c.name),
          FindingId::wrong_place);
}

void check_subscriptions(const core::Network& network, Problems& problems) {
  const core::SubscriptionPolicy& policy = network.subscriptions;
  if (policy.accept == core::Subscribing::nobody) return;
  if (!core::has_subscriptions(network))
    problems.add(
        policy.origin, "Subscriptions",
        fmt::format(
            "{} is not of profile famouso on CAN, Ethernet, IEEE 802.15.4 or a mesh, whose nodes "
            "subscribe: remove it",
            network.name),
        FindingId::wrong_place);
}

void check_bindings(const core::System& system, const core::Network& network, Problems& problems) {
  const auto say = [&](const Binding& b, std::string_view text) {
    problems.add(b.origin, "Binding", text, FindingId::identifier_clash);
  };
  const auto by_channel = sorted_by(network, [](const Binding* b) { return b->channel; });
  const Binding* first = nullptr;
  for (const auto* b : by_channel) {
    if (first == nullptr || first->channel != b->channel)
      first = b;
    else
      say(*b, fmt::format("channel {} is already bound on {} in {}: one binding is enough",
                          system.channels[b->channel].name, network.name,
                          line_words(system, b->origin, first->origin)));
  }
  const auto taken = [&](const Binding& b, const Binding& by) {
    say(b, fmt::format("{} 0x{:x} is already channel {}'s on {}, from {}: choose another",
                       identifier_words(network, b), b.id, system.channels[by.channel].name,
                       network.name, line_words(system, b.origin, by.origin)));
  };
  const auto by_id = sorted_by(
      network, [](const Binding* b) { return std::tuple(b->id, b->extended, b->destination); });
  first = nullptr;
  const Binding* previous = nullptr;
  for (const auto* b : by_id) {
    if (b->waits_for_tag()) continue;
    const bool same = first != nullptr && first->id == b->id && first->extended == b->extended;
    if (same && core::clash(network.profile, *first, *b))
      taken(*b, *first);
    else if (same && core::clash(network.profile, *previous, *b))
      taken(*b, *previous);
    if (!same) first = b;
    previous = b;
  }
  check_masks(system, network, problems);
  if (network.kind == NetworkKind::can)
    for (const auto& b : network.bindings) check_binding(network, b, problems);
}

/// Finds the binding of a channel on a network without a search through all of them.
class Bindings {
 public:
  explicit Bindings(const core::System& system) {
    for (const auto& network : system.networks)
      of_network_.push_back({sorted_by(network, [](const Binding* b) { return b->channel; }), 0});
  }
  const Binding* find(std::size_t network, std::size_t channel) {
    auto& [all, next] = of_network_[network];
    // Publishers and subscribers mostly are in the order of their channels.
    if (next >= all.size() || all[next]->channel != channel)
      next = static_cast<std::size_t>(
          std::ranges::lower_bound(all, channel, {}, [](const Binding* b) { return b->channel; }) -
          all.begin());
    return next < all.size() && all[next]->channel == channel ? all[next++] : nullptr;
  }

 private:
  struct Sorted {
    std::vector<const Binding*> bindings;
    std::size_t next;  ///< index behind the binding that was found last
  };
  std::vector<Sorted> of_network_;
};

/// Returns the binding of an end's channel on its own network, and reports it if it is missing;
/// null if the end needs none.
template <class End>
const Binding* check_bound(const core::System& system, Bindings& bindings, const End& end,
                           std::string_view element, Problems& problems) {
  if (end.place.kind != Place::Kind::network) return nullptr;
  const auto& network = system.networks[end.place.index];
  if (network.kind != NetworkKind::can) return nullptr;
  const auto* binding = bindings.find(end.place.index, end.channel);
  if (binding == nullptr) {
    const auto& channel = system.channels[end.channel].name;
    problems.add(end.origin, element,
                 fmt::format("channel {0} has no binding on {1}: add <Binding channel=\"{0}\"> to "
                             "Network {1}, {2}",
                             channel, network.name, line_words(system, end.origin, network.origin)),
                 FindingId::unbound);
  }
  return binding;
}

/// How large an event the network carries, in words.
std::string room_words(const core::Network& network, const Binding& binding) {
  if (const auto* several = core::fragmentation_of(network, binding); several != nullptr)
    return std::string(several->room);
  if (const auto* several = core::traits_of(network.profile).fragmentation; several != nullptr)
    return (binding.format == FrameFormat::classic ? "in a frame: " : "in an FD frame: ") +
           std::string(several->obstacle(binding));
  if (binding.format == FrameFormat::classic)
    return "in a classic frame (64 with format=\"fd\", where the bus has a data bit rate)";
  return binding.format == FrameFormat::xl ? "in a CAN XL frame" : "in an FD frame";
}

void check_payload(const core::Network& network, const Binding& binding,
                   const core::Publisher& publisher, Problems& problems) {
  // If there are several sets, another one may fit: that is decided at run time and is no rule.
  if (!publisher.attributes.has(Attribute::max_payload) || !publisher.lower.empty()) return;
  const Value bytes = publisher.attributes[Attribute::max_payload];
  const Value most = core::event_bytes(network, binding);
  if (bytes <= most) return;
  problems.add(publisher.origin, "Publisher",
               fmt::format("MaxPayload {} bytes does not fit {}: at most {} bytes {}", bytes,
                           network.name, most, room_words(network, binding)),
               FindingId::too_long);
}

template <class Things>
void check_names(const core::System& system, const Things& things, std::string_view element,
                 Problems& problems) {
  for_each_twice(things, [&](std::size_t first, std::size_t again) {
    const auto& thing = things[again];
    problems.add(thing.origin, element,
                 fmt::format("the name {} is already taken in {}: names are unique", thing.name,
                             line_words(system, thing.origin, things[first].origin)),
                 FindingId::name_twice);
  });
}

void check_twice(const core::System& system, Problems& problems) {
  // A publisher that is alone in its channel needs no comparison.
  std::vector<std::uint32_t> senders(system.channels.size(), 0);
  for (const auto& p : system.publishers) ++senders[p.channel];
  std::vector<std::pair<core::Sender, const core::Publisher*>> identified;
  for (const auto& p : system.publishers)
    if (senders[p.channel] > 1)
      if (const auto sender = core::sender_of(system, p)) identified.emplace_back(*sender, &p);
  std::ranges::stable_sort(identified, {}, [](const auto& entry) { return entry.first; });
  for (std::size_t i = 1, first = 0; i < identified.size(); ++i) {
    if (identified[i].first != identified[first].first) {
      first = i;
      continue;
    }
    const core::Publisher& p = *identified[i].second;
    problems.add(p.origin, "Publisher",
                 fmt::format("nothing distinguishes it from the publisher of channel {} in {}: {}",
                             system.channels[p.channel].name,
                             line_words(system, p.origin, identified[first].second->origin),
                             core::way_to_differ(p)),
                 FindingId::sender_twice);
  }
}

/// Limits the pairs of publishers and subscribers of a channel, because each pair is checked.
void check_pairs(const core::System& system, Problems& problems) {
  struct Ends {
    std::size_t publishers = 0;
    std::size_t subscribers = 0;
  };
  std::vector<Ends> ends(system.channels.size());
  for (const auto& p : system.publishers) ++ends[p.channel].publishers;
  for (const auto& s : system.subscribers) ++ends[s.channel].subscribers;
  for (std::size_t c = 0; c < ends.size(); ++c)
    if (ends[c].publishers * ends[c].subscribers > kMaxPairs)
      problems.add(
          system.channels[c].origin, "EventChannel",
          fmt::format("{} publishers and {} subscribers of channel {} are too many: at "
                      "most {} pairs",
                      ends[c].publishers, ends[c].subscribers, system.channels[c].name, kMaxPairs),
          FindingId::too_many);
}

/// Checks the MaxPayload that a network provides if it cannot fragment events.
void check_provided_payload(const core::Network& n, Problems& problems) {
  if (n.kind != NetworkKind::ieee802154 || !n.carries_subjects()) return;
  const Value most = core::event_bytes(n);
  if (!n.provision.has(Attribute::max_payload) || n.provision[Attribute::max_payload] <= most)
    return;
  problems.add(n.origin, "Network",
               fmt::format("MaxPayload {} bytes is more than a frame of IEEE 802.15.4 holds: at "
                           "most {} bytes beside its header and the subject",
                           n.provision[Attribute::max_payload], most));
}

}  // namespace

void check_channels(const core::System& system, Problems& problems) {
  check_names(system, system.channels, "EventChannel", problems);
  check_names(system, system.user_attributes, "UserAttribute", problems);
  check_names(system, system.components, "Component", problems);
  std::vector<const core::EventChannel*> by_subject;
  by_subject.reserve(system.channels.size());
  for (const auto& c : system.channels) by_subject.push_back(&c);
  const auto subject = [](const core::EventChannel* c) { return c->subject; };
  if (!std::ranges::is_sorted(by_subject, {}, subject))
    std::ranges::stable_sort(by_subject, {}, subject);
  const core::EventChannel* first = nullptr;
  for (const auto* c : by_subject) {
    if (c->subject == 0)
      problems.add(c->origin, "EventChannel",
                   "SubjectUID 0 means no subject: choose another number");
    if (first == nullptr || first->subject != c->subject)
      first = c;
    else
      problems.add(
          c->origin, "EventChannel",
          fmt::format("SubjectUID 0x{:x} is already channel {}'s, from {}: subjects are "
                      "unique",
                      c->subject, first->name, line_words(system, c->origin, first->origin)),
          FindingId::subject_twice);
  }
  for (const auto& c : system.channels)
    if (c.safe_side == core::SafeSide::drop && c.arrival == core::Arrival::sporadic)
      problems.add(c.origin, "EventChannel",
                   "silence of sporadic events says nothing, so it cannot make the receivers safe: "
                   "remove arrival=\"sporadic\" or safe-side=\"drop\"");
  check_count(system.channels, kMaxChannels, "EventChannel", "channels", problems);
  check_count(system.user_attributes, kMaxUserAttributes, "UserAttribute", "user attributes",
              problems);
}

void check_networks(const core::System& system, Problems& problems) {
  check_names(system, system.networks, "Network", problems);
  for (const auto& n : system.networks) {
    const bool can = n.kind == NetworkKind::can;
    const bool datagrams = core::traits_of(n.profile).datagrams != nullptr;
    if (can && !core::names_channels(n.profile))
      problems.add(n.origin, "Network",
                   "a CAN network needs a Profile: " +
                       core::profiles_with([](const auto& p) { return p.last != 0; }, " or "));
    const auto profile = core::words::kProfiles.of(n.profile);
    if (!can && core::names_channels(n.profile) && !datagrams)
      problems.add(n.origin, "Network",
                   fmt::format("Profile {} is for CAN: remove it, or say {}", profile,
                               core::profiles_with(
                                   [](const auto& p) { return p.datagrams != nullptr; }, " or ")));
    if (n.kind == NetworkKind::other && datagrams)
      problems.add(
          n.origin, "Network",
          fmt::format("Profile {} is for the kinds can, udp-multicast, udp-broadcast, mesh "
                      "and ieee802154: remove it",
                      profile));
    check_provided_payload(n, problems);
    check_bindings(system, n, problems);
    check_subscribe_tag(system, n, problems);
    check_subscriptions(n, problems);
  }
  check_count(system.networks, kMaxNetworks, "Network", "networks", problems);
}

void check_ends(const core::System& system, Problems& problems) {
  check_names(system, system.publishers, "Publisher", problems);
  check_names(system, system.subscribers, "Subscriber", problems);
  check_twice(system, problems);
  check_pairs(system, problems);
  Bindings bindings(system);
  for (const auto& p : system.publishers)
    if (const auto* binding = check_bound(system, bindings, p, "Publisher", problems))
      check_payload(system.networks[p.place.index], *binding, p, problems);
  for (const auto& s : system.subscribers) check_bound(system, bindings, s, "Subscriber", problems);
}

void check_rules(const core::System& system, Problems& problems) {
  check_channels(system, problems);
  check_networks(system, problems);
  check_gateways(system, problems);
  check_presence(system, problems);
  check_meshes(system, problems);
  check_ends(system, problems);
}

}  // namespace mlcca::description
