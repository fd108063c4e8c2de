// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/checks.hpp"

#include <algorithm>

#include "core/medium.hpp"
#include "mlcca/check.hpp"

namespace mlcca::tools::design {
namespace {

class Finder {
 public:
  Finder(const core::System& system, const core::Topology& topology)
      : system_(system), topology_(topology) {}

  [[nodiscard]] Pair pair(End publisher, End subscriber) const {
    Pair out{.publisher = publisher, .subscriber = subscriber, .hops = {}, .connected = true};
    const auto& routes =
        topology_.routes(place_of(system_, publisher), place_of(system_, subscriber));
    out.connected = !routes.empty();
    if (!out.connected) return out;
    const auto found = std::ranges::find_if(routes, [&](const core::Route& r) {
      return fits(hops(r, publisher), publisher, subscriber);
    });
    out.hops = hops(found == routes.end() ? routes.front() : *found, publisher);
    return out;
  }

  [[nodiscard]] Pair alone(End end) const {
    Pair out;
    const bool publishes = end.role == der::Role::publisher;
    (publishes ? out.publisher : out.subscriber) = end;
    const core::Route here = {place_of(system_, end)};
    out.hops = hops(here, end);
    return out;
  }

 private:
  [[nodiscard]] std::vector<RouteHop> hops(const core::Route& route, End sender) const {
    const auto channel = channel_of(system_, sender);
    // What a subscriber takes says nothing about what is sent.
    const Value bytes = sender.role == der::Role::publisher
                            ? system_.publishers[sender.index].attributes[Attribute::max_payload]
                            : 0;
    std::vector<RouteHop> out;
    for (const auto place : core::hops_of(route)) {
      RouteHop hop{.place = place, .frames = 1};
      if (place.kind == core::Place::Kind::network) {
        const auto& network = system_.networks[place.index];
        const auto bound = std::ranges::find(network.bindings, channel, &core::Binding::channel);
        hop.frames = static_cast<std::uint16_t>(core::frames_per_event(
            network, bound == network.bindings.end() ? nullptr : &*bound, bytes));
      }
      out.push_back(hop);
    }
    return out;
  }

  /// Of the built-in attributes of the first sets.
  [[nodiscard]] bool fits(const std::vector<RouteHop>& route, End publisher, End subscriber) const {
    const auto& offered = system_.publishers[publisher.index].attributes;
    const auto requirement =
        requirement_between(offered, system_.subscribers[subscriber.index].attributes);
    std::vector<Hop> hops;
    for (const auto& hop : route) {
      Hop& out = hops.emplace_back();
      out.gateway = hop.place.kind == core::Place::Kind::gateway;
      out.provision = system_.provision_of(hop.place);
      out.medium = static_cast<std::uint16_t>(hops.size());
      out.frames = hop.frames;
      if (check_hop(requirement, out).outcome == Outcome::unfit) return false;
    }
    return hops.empty() ||
           check_route(requirement, hops.data(), hops.size(), offered[Attribute::jitter]).outcome !=
               Outcome::unfit;
  }

  const core::System& system_;
  const core::Topology& topology_;
};

}  // namespace

std::vector<Pair> pairs_of(const core::System& system, const core::Topology& topology,
                           const Unit& unit) {
  const Finder finder(system, topology);
  std::vector<Pair> out;
  const auto is_own = [&](End end) {
    return std::ranges::any_of(unit.ends,
                               [&](End e) { return e.role == end.role && e.index == end.index; });
  };
  for (const auto own : unit.ends) {
    const bool publishes = own.role == der::Role::publisher;
    const auto others = publishes ? der::Role::subscriber : der::Role::publisher;
    const auto count = publishes ? system.subscribers.size() : system.publishers.size();
    bool alone = true;
    for (std::size_t i = 0; i < count; ++i) {
      const End other{others, i};
      if (channel_of(system, other) != channel_of(system, own)) continue;
      alone = false;
      // Two of the same unit meet when it is the publisher's turn.
      if (!publishes && is_own(other)) continue;
      out.push_back(publishes ? finder.pair(own, other) : finder.pair(other, own));
    }
    if (alone) out.push_back(finder.alone(own));
  }
  return out;
}

}  // namespace mlcca::tools::design
