// SPDX-License-Identifier: BSD-2-Clause
// The rules of channels, networks, publishers and subscribers; those of gateways are in ports.cc.
#include "description/rules.hpp"

#include <fmt/format.h>

#include <map>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace mlcca::description {
namespace {

using core::Binding;
using core::FrameFormat;
using core::NetworkKind;
using core::Place;
using core::Profile;

constexpr std::uint32_t kFirstEtag = 0x64;
constexpr std::uint32_t kLastEtag = 0x3fff;
constexpr std::uint32_t kLastStandard = 0x7ff;
constexpr std::uint32_t kLastExtended = 0x1fffffff;
constexpr Value kClassicBytes = 8;
constexpr Value kFdBytes = 64;
constexpr Value kFamousoBytes = 24608;  // 4064 fragments of 6 bytes, the last 32 of 7

void check_binding(const core::Network& network, const Binding& b, Problems& problems) {
  const auto say = [&](std::string_view text) { problems.add(b.origin.line, "Binding", text); };
  if (network.profile == Profile::famouso) {
    if (b.id < kFirstEtag || b.id > kLastEtag)
      say(
          fmt::format("ETag 0x{:x} is not right: 0x64 to 0x3fff (the smaller ones are the "
                      "protocol's own)",
                      b.id));
  } else if (b.id > (b.extended ? kLastExtended : kLastStandard)) {
    say(b.extended ? fmt::format("extended identifier 0x{:x} is too large: up to 0x1fffffff", b.id)
                   : fmt::format("standard identifier 0x{:x} is too large: up to 0x7ff, or "
                                 "form=\"extended\" up to 0x1fffffff",
                                 b.id));
  }
  if (b.remote_frames && b.format == FrameFormat::fd)
    say("there are no FD remote frames: remote-frames needs format classic or any");
}

std::string_view identifier_words(const core::Network& network, const Binding& b) {
  if (network.profile == Profile::famouso) return "ETag";
  return b.extended ? "extended identifier" : "standard identifier";
}

void check_bindings(const core::System& system, const core::Network& network, Problems& problems) {
  std::unordered_map<std::size_t, int> line_of_channel;
  std::map<std::pair<std::uint32_t, bool>, const Binding*> of_id;
  for (const auto& b : network.bindings) {
    const auto say = [&](std::string_view text) { problems.add(b.origin.line, "Binding", text); };
    if (const auto [it, fresh] = line_of_channel.try_emplace(b.channel, b.origin.line); !fresh)
      say(fmt::format("channel {} is already bound on {} in line {}: one binding is enough",
                      system.channels[b.channel].name, network.name, it->second));
    if (const auto [it, fresh] = of_id.try_emplace({b.id, b.extended}, &b); !fresh)
      say(fmt::format("{} 0x{:x} is already channel {}'s on {}, from line {}: choose another",
                      identifier_words(network, b), b.id, system.channels[it->second->channel].name,
                      network.name, it->second->origin.line));
    if (network.kind == NetworkKind::can) check_binding(network, b, problems);
  }
}

/// Which bindings there are, without a search for each publisher.
class Bindings {
 public:
  explicit Bindings(const core::System& system) {
    for (const auto& network : system.networks) {
      auto& of_channel = of_network_.emplace_back();
      for (const auto& b : network.bindings) of_channel.try_emplace(b.channel, &b);
    }
  }
  [[nodiscard]] const Binding* find(std::size_t network, std::size_t channel) const {
    const auto found = of_network_[network].find(channel);
    return found == of_network_[network].end() ? nullptr : found->second;
  }

 private:
  std::vector<std::unordered_map<std::size_t, const Binding*>> of_network_;
};

/// The binding of a publisher's or subscriber's channel on its own network, if it needs one.
template <class End>
const Binding* check_bound(const core::System& system, const Bindings& bindings, const End& end,
                           std::string_view element, Problems& problems) {
  if (end.place.kind != Place::Kind::network) return nullptr;
  const auto& network = system.networks[end.place.index];
  if (network.kind != NetworkKind::can) return nullptr;
  const auto* binding = bindings.find(end.place.index, end.channel);
  if (binding == nullptr) {
    const auto& channel = system.channels[end.channel].name;
    problems.add(end.origin.line, element,
                 fmt::format("channel {0} has no binding on {1}: add <Binding channel=\"{0}\"> to "
                             "Network {1}, line {2}",
                             channel, network.name, network.origin.line));
  }
  return binding;
}

/// What the frames of a binding carry of one event.
struct Room {
  Value bytes;
  std::string_view where;
};

Room room_in(const core::Network& network, const Binding& binding) {
  if (network.profile == Profile::famouso) return {kFamousoBytes, "in 4096 fragments"};
  if (binding.format == FrameFormat::classic)
    return {kClassicBytes, "in a classic frame (64 with format=\"fd\")"};
  return {kFdBytes, "in an FD frame"};
}

void check_payload(const core::Network& network, const Binding& binding,
                   const core::Publisher& publisher, Problems& problems) {
  if (!publisher.attributes.has(Attribute::max_payload)) return;
  const Value bytes = publisher.attributes[Attribute::max_payload];
  const auto room = room_in(network, binding);
  if (bytes <= room.bytes) return;
  problems.add(publisher.origin.line, "Publisher",
               fmt::format("MaxPayload {} bytes does not fit {}: at most {} bytes {}", bytes,
                           network.name, room.bytes, room.where));
}

template <class Ends>
void check_names(const Ends& ends, std::string_view element, Problems& problems) {
  std::unordered_map<std::string_view, int> line_of;
  for (const auto& end : ends)
    if (const auto [it, fresh] = line_of.try_emplace(end.name, end.origin.line); !fresh)
      problems.add(end.origin.line, element,
                   fmt::format("the name {} is already taken in line {}: names are unique",
                               end.name, it->second));
}

/// False where several senders are no harm, and where what tells them apart is missing (which is
/// reported already).
bool is_told_apart(const core::System& system, const core::Publisher& p) {
  if (p.place.kind == Place::Kind::gateway) return p.uid.has_value();
  const auto& network = system.networks[p.place.index];
  return network.profile == Profile::raw ||
         (network.profile == Profile::famouso && p.node.has_value());
}

std::string_view way_out(const core::Publisher& p) {
  if (p.place.kind == Place::Kind::gateway) return "another user or node is needed";
  return p.node ? "every publisher has a node of its own" : "an identifier has one sender on a bus";
}

void check_twice(const core::System& system, Problems& problems) {
  using Sender =
      std::tuple<std::size_t, Place, std::optional<std::uint8_t>, std::optional<std::uint32_t>>;
  std::map<Sender, int> line_of;
  for (const auto& p : system.publishers) {
    if (!is_told_apart(system, p)) continue;
    const auto [it, fresh] =
        line_of.try_emplace({p.channel, p.place, p.node, p.uid}, p.origin.line);
    if (fresh) continue;
    problems.add(p.origin.line, "Publisher",
                 fmt::format("channel {} is already published by this sender in line {}: {}",
                             system.channels[p.channel].name, it->second, way_out(p)));
  }
}

}  // namespace

void check_channels(const core::System& system, Problems& problems) {
  check_names(system.channels, "EventChannel", problems);
  std::unordered_map<core::Subject, const core::EventChannel*> of_subject;
  for (const auto& c : system.channels) {
    if (c.subject == 0)
      problems.add(c.origin.line, "EventChannel",
                   "SubjectUID 0 means no subject: choose another number");
    if (const auto [it, fresh] = of_subject.try_emplace(c.subject, &c); !fresh)
      problems.add(c.origin.line, "EventChannel",
                   fmt::format("SubjectUID 0x{:x} is already channel {}'s, from line {}: subjects "
                               "are unique",
                               c.subject, it->second->name, it->second->origin.line));
  }
  if (system.channels.size() > kMaxChannels)
    problems.add(
        system.channels[kMaxChannels].origin.line, "EventChannel",
        fmt::format("{} channels are too many: at most {}", system.channels.size(), kMaxChannels));
}

void check_networks(const core::System& system, Problems& problems) {
  check_names(system.networks, "Network", problems);
  for (const auto& n : system.networks) {
    const bool can = n.kind == NetworkKind::can;
    if (can && n.profile == Profile::none)
      problems.add(n.origin.line, "Network", "a CAN network needs a Profile: raw or famouso");
    if (!can && n.profile != Profile::none)
      problems.add(n.origin.line, "Network",
                   "only a CAN network has a Profile other than none: remove it");
    check_bindings(system, n, problems);
  }
  if (system.networks.size() > kMaxNetworks)
    problems.add(
        system.networks[kMaxNetworks].origin.line, "Network",
        fmt::format("{} networks are too many: at most {}", system.networks.size(), kMaxNetworks));
}

void check_ends(const core::System& system, Problems& problems) {
  check_names(system.publishers, "Publisher", problems);
  check_names(system.subscribers, "Subscriber", problems);
  check_twice(system, problems);
  const Bindings bindings(system);
  for (const auto& p : system.publishers)
    if (const auto* binding = check_bound(system, bindings, p, "Publisher", problems))
      check_payload(system.networks[p.place.index], *binding, p, problems);
  for (const auto& s : system.subscribers) check_bound(system, bindings, s, "Subscriber", problems);
}

void check_rules(const core::System& system, Problems& problems) {
  check_channels(system, problems);
  check_networks(system, problems);
  check_gateways(system, problems);
  check_ends(system, problems);
}

}  // namespace mlcca::description
