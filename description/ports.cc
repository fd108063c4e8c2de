// SPDX-License-Identifier: BSD-2-Clause
// The rules for gateways and their ports: places, interfaces, bit rates.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "description/names.hpp"
#include "description/rules.hpp"

namespace mlcca::description {
namespace {

using core::Gateway;
using core::InterfaceIdentity;
using core::NetworkKind;
using core::Port;

bool states_nothing(const InterfaceIdentity& i) { return i == InterfaceIdentity{}; }

void check_port(const core::System& system, const Port& p, Problems& problems) {
  const auto say = [&](std::string_view text) { problems.add(p.origin, "Port", text); };
  const auto& network = system.networks[p.network];
  if (states_nothing(p.identity))
    say("Interface says nothing: one of name, id-path, serial, alias, port is needed");
  if (p.bitrate == 0) return;
  if (network.kind != NetworkKind::can)
    say(fmt::format("only CAN has a Bitrate here, and {} is no CAN network: remove it",
                    network.name));
  if (!p.managed) say("a Bitrate is only set on a managed port: add managed=\"true\" or remove it");
  const auto check_rate = [&](std::string_view element, std::uint32_t own, std::uint32_t of_bus) {
    if (own != 0 && of_bus != 0 && own != of_bus)
      say(fmt::format("{} {} is not that of {}, whose Bus has {}: all on a bus send alike", element,
                      own, network.name, of_bus));
  };
  check_rate("Bitrate", p.bitrate, network.bus.bitrate);
  check_rate("DataBitrate", p.data_bitrate, network.bus.data_bitrate);
  if (p.data_bitrate != 0 && p.data_bitrate < p.bitrate)
    say(fmt::format("DataBitrate {} is below Bitrate {}: the data phase is not the slower one",
                    p.data_bitrate, p.bitrate));
}

void check_ports_of(const core::System& system, const Gateway& g, Problems& problems) {
  check_count(g.ports, kMaxPorts, "Port", fmt::format("ports of gateway {}", g.name), problems);
  std::map<std::size_t, core::Origin> seen;
  for (const auto& p : g.ports) {
    check_port(system, p, problems);
    if (const auto [it, fresh] = seen.try_emplace(p.network, p.origin); !fresh)
      problems.add(
          p.origin, "Port",
          fmt::format("gateway {} already has a port on {} in {}: one is enough", g.name,
                      system.networks[p.network].name, line_words(system, p.origin, it->second)));
  }
}

/// Ports that can have the same interfaces: those of one gateway, or of gateways on the same host.
using Machine = std::vector<const Port*>;

/// Finds ports that claim the same interface. Two identities may be of one interface if the
/// properties that one of them states are all stated alike by the other. Properties are converted
/// to numbers, so that not all pairs of up to 65536 ports need to be compared.
class Claims {
 public:
  explicit Claims(const Machine& ports) {
    for (const Port* port : ports) {
      keys_.push_back(key_of(port->identity));
      groups_.try_emplace(keys_.back(), Group{.first = keys_.size() - 1});
    }
    for (std::size_t i = 0; i < keys_.size(); ++i) first_.push_back(look_for_narrower(i));
  }

  /// The first port before `i` that claims the same interface; kNone if there is none.
  [[nodiscard]] std::size_t before(std::size_t i) const {
    const Group& alike = groups_.at(keys_[i]);
    const std::size_t first = std::min({first_[i], alike.first, alike.first_closer});
    return keys_[i] == Key{} || first >= i ? kNone : first;
  }

  static constexpr std::size_t kNone = ~std::size_t{0};

 private:
  static constexpr std::size_t kProperties = 5;
  using Key = std::array<std::size_t, kProperties>;  ///< a number for each property; 0: not stated

  struct Group {
    std::size_t first = kNone;         ///< first port with this identity
    std::size_t first_closer = kNone;  ///< first port that states these properties and more
  };

  std::size_t number_of(const std::string& text) {
    return text.empty() ? 0 : texts_.try_emplace(text, texts_.size() + 1).first->second;
  }
  Key key_of(const InterfaceIdentity& i) {
    return {number_of(i.name), number_of(i.id_path), number_of(i.serial), number_of(i.alias),
            i.port ? std::size_t{*i.port} + 1 : 0};
  }

  /// The first port that states only some of the properties of `i`, all alike. Such ports learn of
  /// `i` as one that states more.
  std::size_t look_for_narrower(std::size_t i) {
    std::size_t first = kNone;
    for (unsigned part = 1; part + 1 < 1U << kProperties; ++part) {
      Key less = keys_[i];
      bool stated = true;
      for (std::size_t p = 0; p < kProperties; ++p) {
        if ((part >> p & 1U) == 0)
          less.at(p) = 0;
        else
          stated = stated && less.at(p) != 0;
      }
      const auto found = stated && less != keys_[i] ? groups_.find(less) : groups_.end();
      if (found == groups_.end()) continue;
      first = std::min(first, found->second.first);
      found->second.first_closer = std::min(found->second.first_closer, i);
    }
    return first;
  }

  std::unordered_map<std::string_view, std::size_t> texts_;
  std::vector<Key> keys_;
  std::map<Key, Group> groups_;
  std::vector<std::size_t> first_;
};

void check_claims(const core::System& system, const Machine& ports, Problems& problems) {
  const Claims claims(ports);
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const std::size_t before = claims.before(i);
    if (before == Claims::kNone) continue;
    problems.add(ports[i]->origin, "Port",
                 fmt::format("its Interface is already claimed by the port in {}: an interface "
                             "is on one network",
                             line_words(system, ports[i]->origin, ports[before]->origin)),
                 core::FindingId::interface_twice);
  }
}

/// Node numbers of gateways must be unique on a bus, since a gateway asks the broker for tags with
/// its number: two senders with the same number would send the same identifier.
void check_nodes(const core::System& system, Problems& problems) {
  std::map<std::pair<std::size_t, unsigned>, std::pair<const Gateway*, const Port*>> taken;
  const auto say = [&](core::Origin origin, std::string_view element, std::string_view by,
                       const auto& of) {
    const auto& [at, owner] = of;
    problems.add(origin, element,
                 fmt::format("attribute node: {} on {} is {}gateway {}'s, from {}: choose another",
                             at.second, system.networks[at.first].name, by, owner.first->name,
                             line_words(system, origin, owner.second->origin)),
                 core::FindingId::sender_twice);
  };
  for (const Gateway& g : system.gateways)
    for (const Port& p : g.ports) {
      if (!p.node) continue;
      const auto [it, fresh] = taken.try_emplace({p.network, *p.node}, &g, &p);
      if (!fresh && it->second.first != &g) say(p.origin, "Port", "already ", *it);
    }
  if (taken.empty()) return;
  for (const core::Publisher& p : system.publishers) {
    if (p.place.kind != core::Place::Kind::network || !p.node) continue;
    const auto it = taken.find({p.place.index, *p.node});
    if (it != taken.end()) say(p.origin, "Publisher", "", *it);
  }
}

}  // namespace

void check_gateways(const core::System& system, Problems& problems) {
  std::unordered_map<std::string_view, core::Origin> networks;
  for (const auto& n : system.networks) networks.try_emplace(n.name, n.origin);
  std::unordered_map<std::string_view, core::Origin> gateways;
  std::map<std::string, Machine> machines;
  for (const auto& g : system.gateways) {
    if (const auto [it, fresh] = gateways.try_emplace(g.name, g.origin); !fresh)
      problems.add(g.origin, "Gateway",
                   fmt::format("the name {} is already taken in {}: names are unique", g.name,
                               line_words(system, g.origin, it->second)),
                   core::FindingId::name_twice);
    if (const auto it = networks.find(g.name); it != networks.end())
      problems.add(g.origin, "Gateway",
                   fmt::format("{} is already a network's name, in {}: both are places, and a "
                               "place is asked for by name",
                               g.name, line_words(system, g.origin, it->second)),
                   core::FindingId::name_twice);
    check_ports_of(system, g, problems);
    const auto number = static_cast<std::size_t>(&g - system.gateways.data());
    if (number >= kMaxGateways) continue;
    // A gateway without a host is a machine of its own; no host name begins with '#'.
    auto& machine = machines[g.host.empty() ? fmt::format("#{}", number) : g.host];
    for (const auto& p : std::span(g.ports).first(std::min(g.ports.size(), kMaxPorts)))
      machine.push_back(&p);
  }
  for (const auto& [host, ports] : machines) check_claims(system, ports, problems);
  check_nodes(system, problems);
  check_count(system.gateways, kMaxGateways, "Gateway", "gateways", problems);
}

}  // namespace mlcca::description
