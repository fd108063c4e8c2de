// SPDX-License-Identifier: BSD-2-Clause
// The rules of gateways and their ports: places, interfaces, bit rates.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
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

/// Every interface that fits `wide` fits `narrow` too: what narrow states, wide states alike.
bool covers(const InterfaceIdentity& narrow, const InterfaceIdentity& wide) {
  const auto same = [](const auto& a, const auto& b) { return a.empty() || a == b; };
  return same(narrow.name, wide.name) && same(narrow.id_path, wide.id_path) &&
         same(narrow.serial, wide.serial) && same(narrow.alias, wide.alias) &&
         (!narrow.port || narrow.port == wide.port);
}

bool same_interface(const InterfaceIdentity& a, const InterfaceIdentity& b) {
  if (states_nothing(a) || states_nothing(b)) return false;  // reported on its own
  return covers(a, b) || covers(b, a);
}

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

/// Ports that can see the same interfaces: those of one gateway, and of gateways on one host.
using Machine = std::vector<const Port*>;

void check_claims(const core::System& system, const Machine& ports, Problems& problems) {
  for (std::size_t i = 0; i < ports.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (!same_interface(ports[i]->identity, ports[j]->identity)) continue;
      problems.add(ports[i]->origin, "Port",
                   fmt::format("its Interface is already claimed by the port in {}: an interface "
                               "is on one network",
                               line_words(system, ports[i]->origin, ports[j]->origin)),
                   core::FindingId::interface_twice);
      break;
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
    // A host name cannot begin with '#': gateways without a stated host are machines of their own.
    auto& machine = machines[g.host.empty() ? fmt::format("#{}", number) : g.host];
    for (const auto& p : std::span(g.ports).first(std::min(g.ports.size(), kMaxPorts)))
      machine.push_back(&p);
  }
  for (const auto& [host, ports] : machines) check_claims(system, ports, problems);
  check_count(system.gateways, kMaxGateways, "Gateway", "gateways", problems);
}

}  // namespace mlcca::description
