// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/holders.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "core/can/cover.hpp"
#include "core/can/level.hpp"
#include "core/model/text.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core {
namespace {

/// The most gateways that are named.
constexpr std::size_t kMostNamed = 3;
/// The whole of a bus, in the unit of HeldBy::bus_time.
constexpr Value kWholeBus = 1'000'000;
constexpr Value kTenthOfPercent = 1000;  // in 1e-6
constexpr Value kNanosInPpm = 1000;      // parts in 1e-9 of one in 1e-6

/// What one gateway holds, by the publisher of the traffic.
struct Sums {
  std::map<cluster::Source, Value> rates;
  std::map<cluster::Source, can::Message> messages;
  std::map<cluster::Source, std::vector<cluster::PathPart>> paths;
};

std::map<std::size_t, Sums> sums_of(const cluster::Foreign& parts) {
  std::map<std::size_t, Sums> all;
  for (const cluster::RatePart& part : parts.rates) {
    Value& most = all[part.gateway].rates[part.source];
    most = std::max(most, part.bytes_per_second);
  }
  for (const cluster::BusPart& part : parts.bus) {
    auto& messages = all[part.gateway].messages;
    const auto [it, fresh] = messages.try_emplace(part.source, part.message);
    if (!fresh) it->second = can::strictest(it->second, part.message);
  }
  for (const cluster::PathPart& part : parts.paths)
    join(all[part.gateway].paths[part.source], part);
  return all;
}

void add_messages(const Sums& sums, const std::optional<can::Assumptions>& bus, HeldBy& to) {
  to.messages = sums.messages.size();
  for (const auto& [source, message] : sums.messages) {
    if (!bus || !can::usable(*bus, message))
      ++to.uncountable;
    else
      to.bus_time =
          add_saturating(to.bus_time, mul_div_up(message.transmission, kWholeBus, message.period));
  }
}

void add_paths(const Sums& sums, const Network& network, const MeshView* view, HeldBy& to) {
  std::map<std::uint32_t, Value> times;
  for (const auto& [source, paths] : sums.paths) {
    const auto shares = view == nullptr || !network.mesh
                            ? std::nullopt
                            : shares_of_joined(*network.mesh, *view, paths);
    if (!shares) {
      ++to.uncountable;
      continue;
    }
    for (const mesh::Share& share : *shares)
      times[share.domain] = add_saturating(times[share.domain], share.time);
  }
  for (const auto& [domain, time] : times) to.shares.push_back({domain, time});
}

/// Of all domains the largest share of the time, in ps/s.
Value most_time(const HeldBy& held) {
  Value most = 0;
  for (const mesh::Share& share : held.shares) most = std::max(most, share.time);
  return most;
}

/// By which of its amounts a gateway is among the largest.
Value weight_of(const Network& network, const HeldBy& held) {
  if (network.kind == NetworkKind::can && held.bus_time != 0) return held.bus_time;
  if (network.mesh && !held.shares.empty()) return most_time(held);
  return held.bytes_per_second;
}

/// `ppm`: 1e-6 of a whole. Rounded up to a tenth of a percent.
std::string percent(Value ppm) {
  const Value rounded = mul_saturating(div_up(ppm, kTenthOfPercent), kTenthOfPercent);
  return format_value(Attribute::packet_loss, mul_saturating(rounded, kNanosInPpm));
}

std::string amount_of(const Network& network, const HeldBy& held) {
  if (network.kind == NetworkKind::can && held.messages != 0)
    return std::to_string(held.messages) + (held.messages == 1 ? " message, " : " messages, ") +
           percent(held.bus_time) + " of the time";
  if (network.mesh && !held.shares.empty())
    return percent(mul_div_up(most_time(held), kWholeBus, mesh::kFullTime)) + " of the time";
  return format_value(Attribute::bandwidth, held.bytes_per_second);
}

/// The name of a gateway may come from a record in the store.
std::string name_of_gateway(const System& system, std::size_t gateway) {
  return gateway < system.gateways.size() ? system.gateways[gateway].name : "another gateway";
}

/// The end of the words about a gateway that holds it for others as well.
std::string for_whom(const System& system, const MadeFor& made_for) {
  if (made_for.gateways.empty()) return {};
  std::string words = made_for.all ? ", for " : ", in part for ";
  std::size_t named = 0;
  for (const std::size_t gateway : made_for.gateways) {
    if (named == kMostNamed) break;
    words += (named++ == 0 ? "" : " and ") + name_of_gateway(system, gateway);
  }
  const std::size_t more = made_for.gateways.size() - named;
  return more == 0 ? words : words + " and " + std::to_string(more) + " more";
}

std::vector<const HeldBy*> largest_first(const Network& network, std::span<const HeldBy> held) {
  std::vector<const HeldBy*> order;
  for (const HeldBy& one : held) order.push_back(&one);
  std::ranges::stable_sort(order, [&](const HeldBy* a, const HeldBy* b) {
    return weight_of(network, *a) > weight_of(network, *b);
  });
  return order;
}

template <class Text>
std::string listed(const System& system, const std::vector<const HeldBy*>& all, Text text) {
  std::string out;
  const std::size_t named = std::min(all.size(), kMostNamed);
  for (std::size_t i = 0; i < named; ++i) {
    if (i != 0) out += i + 1 == all.size() ? " and " : ", ";
    out += name_of_gateway(system, all[i]->gateway) + text(*all[i]);
  }
  const std::size_t more = all.size() - named;
  if (more == 0) return out;
  return out + " and " + std::to_string(more) + (more == 1 ? " more gateway" : " more gateways");
}

}  // namespace

std::vector<HeldBy> held_by(const System& system, const World& world, std::size_t network,
                            const cluster::Foreign& parts) {
  const Network& medium = system.networks[network];
  const auto bus = bus_of(system, world.conditions[network], network);
  std::vector<HeldBy> all;
  for (const auto& [gateway, sums] : sums_of(parts)) {
    HeldBy& held = all.emplace_back();
    held.gateway = gateway;
    for (const auto& [source, bytes] : sums.rates)
      held.bytes_per_second = add_saturating(held.bytes_per_second, bytes);
    add_messages(sums, bus, held);
    add_paths(sums, medium, world.meshes[network].get(), held);
  }
  return all;
}

std::string holders_words(const System& system, std::size_t network, std::span<const HeldBy> held) {
  const Network& medium = system.networks[network];
  return listed(system, largest_first(medium, held), [&](const HeldBy& one) {
    return " (" + amount_of(medium, one) + for_whom(system, one.made_for) + ")";
  });
}

std::string excess_words(const System& system, const World& world, std::size_t network,
                         std::span<const HeldBy> held) {
  const Network& medium = system.networks[network];
  constexpr Attribute rate = Attribute::bandwidth;
  std::string much;
  const auto sum_of = [&](auto member) {
    return std::accumulate(held.begin(), held.end(), Value{0}, [&](Value sum, const HeldBy& one) {
      return add_saturating(sum, one.*member);
    });
  };
  const Value bytes = sum_of(&HeldBy::bytes_per_second);
  const Value bus_time = sum_of(&HeldBy::bus_time);
  if (medium.provision.has(rate) && !medium.provision.is_dynamic(rate) &&
      bytes > medium.provision[rate])
    much = format_value(rate, bytes) + " of " + format_value(rate, medium.provision[rate]);
  else if (bus_time > kWholeBus)
    much = percent(bus_time) + " of its time";
  else if (world.meshes[network] != nullptr && medium.mesh) {
    std::map<std::uint32_t, Value> times;
    Value most = 0;
    for (const HeldBy& one : held)
      for (const mesh::Share& share : one.shares) {
        Value& sum = times[share.domain];
        sum = add_saturating(sum, share.time);
        most = std::max(most, sum);
      }
    if (most <= mesh::limit_of(*medium.mesh)) return {};
    much = percent(mul_div_up(most, kWholeBus, mesh::kFullTime)) + " of its time where it may be " +
           percent(mul_div_up(mesh::limit_of(*medium.mesh), kWholeBus, mesh::kFullTime));
  }
  if (much.empty()) return {};
  return "other gateways have reserved more of " + medium.name + " than it has (" + much +
         "): " + holders_words(system, network, held);
}

std::string uncountable_words(const System& system, std::span<const HeldBy> held) {
  std::vector<const HeldBy*> which;
  for (const HeldBy& one : held)
    if (one.uncountable != 0) which.push_back(&one);
  std::ranges::stable_sort(
      which, [](const HeldBy* a, const HeldBy* b) { return a->uncountable > b->uncountable; });
  return listed(system, which,
                [](const HeldBy& one) { return " (" + std::to_string(one.uncountable) + ")"; });
}

}  // namespace mlcca::core
