// SPDX-License-Identifier: BSD-2-Clause
// Names become indices, and what an entry says is held against the place it says it for.
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "description/attributes.hpp"
#include "description/draft.hpp"
#include "description/suggest.hpp"
#include "description/users.hpp"

namespace mlcca::description {
namespace {

using core::NetworkKind;
using core::Place;
using core::Profile;

constexpr unsigned kBrokerNode = 0x7f;
constexpr unsigned kMaxPriority = 0x7f;

/// Comparing names costs more than anything else here: a hostile file gets no more than these.
constexpr std::size_t kMostSuggestions = 50;

/// Names of one kind, in their order. The first of a name counts; rules.hpp reports the others.
class Index {
 public:
  explicit Index(std::string_view kind) : kind_(kind) {}

  /// `name` must outlive the index.
  void add(std::string_view name) {
    index_.try_emplace(name, names_.size());
    names_.push_back(name);
  }

  std::optional<std::size_t> find(std::string_view name, const core::Origin& origin,
                                  std::string_view element, Problems& problems) const {
    if (const auto found = index_.find(name); found != index_.end()) return found->second;
    std::string text = fmt::format("{} {} is not described", kind_, name);
    if (problems.size() < kMostSuggestions) text += "; " + known_names(name, names_);
    problems.add(origin.line, element, text);
    return std::nullopt;
  }

 private:
  std::string_view kind_;
  std::unordered_map<std::string_view, std::size_t> index_;
  std::vector<std::string_view> names_;
};

class Resolver {
 public:
  Resolver(Draft& draft, Problems& problems) : draft_(draft), problems_(problems) {
    for (const auto& c : draft_.channels) channels_.add(c.name);
    for (const auto& n : draft_.networks) networks_.add(n.network.name);
    for (const auto& g : draft_.gateways) gateways_.add(g.gateway.name);
  }

  core::System run() {
    for (const auto& network : draft_.networks) add(network);
    for (const auto& gateway : draft_.gateways) add(gateway);
    for (const auto& end : draft_.publishers) add_publisher(end);
    for (const auto& end : draft_.subscribers) add_subscriber(end);
    // Last: the index refers to the names until here.
    system_.name = draft_.name;
    system_.channels = std::move(draft_.channels);
    return std::move(system_);
  }

 private:
  void add(const NetworkDraft& from) {
    auto& network = system_.networks.emplace_back(from.network);
    for (const auto& b : from.bindings) {
      const auto channel = channels_.find(b.channel, b.binding.origin, "Binding", problems_);
      check_form(b, network);
      if (!channel) continue;
      network.bindings.push_back(b.binding);
      network.bindings.back().channel = *channel;
    }
  }

  void check_form(const BindingDraft& b, const core::Network& network) {
    const auto say = [&](std::string_view text) {
      problems_.add(b.binding.origin.line, "Binding", text);
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

  void add(const GatewayDraft& from) {
    auto& gateway = system_.gateways.emplace_back(from.gateway);
    for (const auto& p : from.ports) {
      const auto network = networks_.find(p.network, p.port.origin, "Port", problems_);
      if (!network) continue;
      gateway.ports.push_back(p.port);
      gateway.ports.back().network = *network;
    }
  }

  std::optional<Place> place_of(const EndDraft& end, std::string_view element) {
    if (end.network.empty() == end.gateway.empty()) {
      problems_.add(end.origin.line, element,
                    "it is at one place: either attribute network or attribute gateway is needed");
      return std::nullopt;
    }
    const bool on_network = !end.network.empty();
    const auto index = on_network ? networks_.find(end.network, end.origin, element, problems_)
                                  : gateways_.find(end.gateway, end.origin, element, problems_);
    if (!index) return std::nullopt;
    return Place{on_network ? Place::Kind::network : Place::Kind::gateway, *index};
  }

  std::string name_of(const EndDraft& end, std::string_view kind) {
    if (!end.name.empty()) return end.name;
    auto name = fmt::format("{}@{}", end.channel, end.network.empty() ? end.gateway : end.network);
    const auto count = ++unnamed_[fmt::format("{} {}", kind, name)];
    return count == 1 ? name : fmt::format("{}#{}", name, count);
  }

  void add_publisher(const EndDraft& end) {
    const auto channel = channels_.find(end.channel, end.origin, "Publisher", problems_);
    const auto place = place_of(end, "Publisher");
    std::optional<std::uint32_t> uid;
    if (place) {
      check_sender(end, *place);
      uid = uid_at(end, *place);
    }
    if (!channel || !place) return;
    // The channel's Jitter is what subscribers stand; a publisher's own is stated by itself.
    AttributeSet inherited = draft_.channels[*channel].attributes;
    inherited.clear(Attribute::jitter);
    core::Publisher out{.name = name_of(end, "publisher"),
                        .channel = *channel,
                        .place = *place,
                        .attributes = with_own(inherited, end.own),
                        .node = std::nullopt,
                        .uid = uid,
                        .origin = end.origin};
    if (end.node) out.node = static_cast<std::uint8_t>(*end.node);
    if (end.priority) out.priority = static_cast<std::uint8_t>(*end.priority);
    system_.publishers.push_back(std::move(out));
  }

  void add_subscriber(const EndDraft& end) {
    const auto channel = channels_.find(end.channel, end.origin, "Subscriber", problems_);
    const auto place = place_of(end, "Subscriber");
    if (!channel || !place) return;
    system_.subscribers.push_back(
        {.name = name_of(end, "subscriber"),
         .channel = *channel,
         .place = *place,
         .attributes = with_own(draft_.channels[*channel].attributes, end.own),
         .origin = end.origin});
  }

  [[nodiscard]] bool speaks_famouso(Place place) const {
    if (place.kind == Place::Kind::network)
      return system_.networks[place.index].profile == Profile::famouso;
    return std::ranges::any_of(system_.gateways[place.index].ports, [&](const core::Port& port) {
      return system_.networks[port.network].profile == Profile::famouso;
    });
  }

  /// Node and priority: where FAMOUSO is spoken, and only there.
  void check_sender(const EndDraft& end, Place place) {
    const auto say = [&](std::string_view text) {
      problems_.add(end.origin.line, "Publisher", text);
    };
    if (!speaks_famouso(place)) {
      if (end.node || end.priority)
        say("attributes node and priority are for profile famouso, which is not spoken here: "
            "remove them");
      return;
    }
    if (!end.node && place.kind == Place::Kind::network)
      say("attribute node is missing: on a network with profile famouso it is 0 to 126");
    if (end.node && *end.node >= kBrokerNode)
      say(fmt::format("attribute node: {} is not right: 0 to 126 (127 is the broker's)",
                      *end.node));
    if (end.priority && *end.priority > kMaxPriority)
      say(fmt::format("attribute priority: {} is not right: 0 (highest) to 127", *end.priority));
  }

  std::optional<std::uint32_t> uid_at(const EndDraft& end, Place place) {
    const auto say = [&](std::string_view text) {
      problems_.add(end.origin.line, "Publisher", text);
    };
    const bool local = place.kind == Place::Kind::gateway;
    if (end.user.empty()) {
      if (local) say("attribute user is missing: whose programs on the gateway may send");
      return std::nullopt;
    }
    if (!local) {
      say("attribute user is for a program on a gateway; nobody knows a user behind a bus: "
          "remove it");
      return std::nullopt;
    }
    auto& known = users_[end.user];
    if (!known) known = uid_of(end.user);
    if (*known) return **known;
    say(fmt::format("attribute user: {}", known->error()));
    return std::nullopt;
  }

  Draft& draft_;
  Problems& problems_;
  core::System system_;
  Index channels_{"channel"};
  Index networks_{"network"};
  Index gateways_{"gateway"};
  std::unordered_map<std::string, std::size_t> unnamed_;
  std::map<std::string, std::optional<std::expected<std::uint32_t, std::string>>> users_;
};

}  // namespace

core::System resolve(Draft draft, Problems& problems) { return Resolver(draft, problems).run(); }

}  // namespace mlcca::description
