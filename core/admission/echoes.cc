// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/echoes.hpp"

#include <algorithm>
#include <vector>

namespace mlcca::core {
namespace {

bool carries_subjects(const System& system, Place place) {
  return place.kind == Place::Kind::network && system.networks[place.index].carries_subjects();
}

/// Calls `crosses` with the route index of each gateway that forwards events from one network to
/// the next.
void each_crossing(const Route& route, auto crosses) {
  for (std::size_t i = 1; i + 1 < route.size(); ++i)
    if (route[i].kind == Place::Kind::gateway) crosses(i);
}

/// Whether the gateway at that index must take the events from any sender. The gate knows the
/// address of a publisher on the network itself if it is stated; of events that a gateway has sent
/// it knows none.
bool is_wildcard(const System& system, const Publisher& publisher, const Route& route,
                 std::size_t hop) {
  return carries_subjects(system, route[hop - 1]) && (hop > 1 || publisher.station.is_wildcard());
}

constexpr std::size_t kNoGateway = ~std::size_t{0};

/// A flow at a network: events of a publisher that a gateway takes from it, or sends on it.
struct At {
  std::size_t network = 0;
  std::size_t gateway = 0;
  std::size_t publisher = 0;
  auto operator<=>(const At&) const = default;
};

/// The flows of a channel. All lists except `sent` are sorted.
struct Flows {
  std::vector<At> taken;
  std::vector<At> carried;  ///< `taken` without the gateway (kNoGateway)
  std::vector<At> any;      ///< those of `taken` that are taken from any sender
  std::vector<At> brought;  ///< those of `any` that another gateway has sent
  std::vector<At> sent;     ///< kNoGateway: by the publisher itself, granted or not
};

Flows flows_of(const System& system, const Members& members, std::span<const Verdict> verdicts) {
  Flows flows;
  for (const Verdict& v : verdicts) {
    if (!v.granted) continue;
    const Publisher& publisher = members.publisher(v.publisher);
    each_crossing(v.route, [&](std::size_t i) {
      const std::size_t gateway = v.route[i].index;
      flows.taken.push_back({v.route[i - 1].index, gateway, v.publisher});
      flows.carried.push_back({v.route[i - 1].index, kNoGateway, v.publisher});
      if (!is_wildcard(system, publisher, v.route, i)) return;
      flows.any.push_back(flows.taken.back());
      if (i > 1) flows.brought.push_back(flows.taken.back());
    });
    for (std::size_t i = 1; i < v.route.size(); ++i)
      if (carries_subjects(system, v.route[i]))
        flows.sent.push_back({v.route[i].index, v.route[i - 1].index, v.publisher});
  }
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    const std::size_t number = verdicts[i].publisher;
    const Publisher& publisher = members.publisher(number);
    // A gate knows a stated address, and refuses it where it was not admitted.
    if ((i == 0 || verdicts[i - 1].publisher != number) && publisher.station.is_wildcard() &&
        carries_subjects(system, publisher.place))
      flows.sent.push_back({publisher.place.index, kNoGateway, number});
  }
  std::ranges::sort(flows.taken);
  std::ranges::sort(flows.carried);
  std::ranges::sort(flows.any);
  std::ranges::sort(flows.brought);
  return flows;
}

bool has_several_gateways(std::span<const Verdict> verdicts) {
  std::optional<std::size_t> only;
  bool several = false;
  for (const Verdict& v : verdicts)
    if (v.granted)
      each_crossing(v.route, [&](std::size_t i) {
        several = several || (only && *only != v.route[i].index);
        only = v.route[i].index;
      });
  return several;
}

}  // namespace

bool takes_any_sender(const System& system, const Publisher& publisher, const Route& route,
                      std::size_t gateway) {
  bool found = false;
  each_crossing(route, [&](std::size_t i) {
    found = found || (route[i].index == gateway && is_wildcard(system, publisher, route, i));
  });
  return found;
}

std::optional<std::size_t> find_echo(const System& system, const Members& members,
                                     std::span<const Verdict> verdicts) {
  if (verdicts.size() < 2 || !has_several_gateways(verdicts)) return std::nullopt;
  const Flows flows = flows_of(system, members, verdicts);
  for (const At& copy : flows.sent) {
    // A publisher whose events are forwarded by no gateway shares the grants of those on its
    // network that are indistinguishable from it (MLCCA033).
    const bool shares =
        copy.gateway == kNoGateway && !std::ranges::binary_search(flows.carried, copy);
    const auto& takers = shares ? flows.brought : flows.any;
    auto at = std::ranges::lower_bound(takers, At{.network = copy.network});
    while (at != takers.end() && at->network == copy.network) {
      const std::size_t gateway = at->gateway;
      if (gateway != copy.gateway &&
          !std::ranges::binary_search(flows.taken, At{copy.network, gateway, copy.publisher}))
        return gateway;
      at = std::ranges::lower_bound(takers, At{copy.network, gateway + 1, 0});
    }
  }
  return std::nullopt;
}

}  // namespace mlcca::core
