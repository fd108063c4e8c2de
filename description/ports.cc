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
  const auto say = [&](std::string_view text) { problems.add(p.origin.line, "Port", text); };
  const auto& network = system.networks[p.network];
  if (states_nothing(p.identity))
    say("Interface says nothing: one of name, id-path, serial, alias, port is needed");
  if (p.bitrate == 0) return;
  if (network.kind != NetworkKind::can)
    say(fmt::format("only CAN has a Bitrate here, and {} is no CAN network: remove it",
                    network.name));
  if (!p.managed) say("a Bitrate is only set on a managed port: add managed=\"true\" or remove it");
  if (p.data_bitrate != 0 && p.data_bitrate < p.bitrate)
    say(fmt::format("DataBitrate {} is below Bitrate {}: the data phase is not the slower one",
                    p.data_bitrate, p.bitrate));
}

void check_ports_of(const core::System& system, const Gateway& g, Problems& problems) {
  if (g.ports.size() > kMaxPorts)
    problems.add(g.ports[kMaxPorts].origin.line, "Port",
                 fmt::format("{} ports are too many for gateway {}: at most {}", g.ports.size(),
                             g.name, kMaxPorts));
  std::map<std::size_t, int> line_of;
  for (const auto& p : g.ports) {
    check_port(system, p, problems);
    if (const auto [it, fresh] = line_of.try_emplace(p.network, p.origin.line); !fresh)
      problems.add(p.origin.line, "Port",
                   fmt::format("gateway {} already has a port on {} in line {}: one is enough",
                               g.name, system.networks[p.network].name, it->second));
  }
}

/// Ports that can see the same interfaces: those of one gateway, and of gateways on one host.
using Machine = std::vector<const Port*>;

void check_claims(const Machine& ports, Problems& problems) {
  for (std::size_t i = 0; i < ports.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (!same_interface(ports[i]->identity, ports[j]->identity)) continue;
      problems.add(ports[i]->origin.line, "Port",
                   fmt::format("its Interface is already claimed by the port in line {}: an "
                               "interface is on one network",
                               ports[j]->origin.line));
      break;
    }
}

}  // namespace

void check_gateways(const core::System& system, Problems& problems) {
  std::unordered_map<std::string_view, int> network_line;
  for (const auto& n : system.networks) network_line.try_emplace(n.name, n.origin.line);
  std::unordered_map<std::string_view, int> gateway_line;
  std::map<std::string, Machine> machines;
  for (const auto& g : system.gateways) {
    if (const auto [it, fresh] = gateway_line.try_emplace(g.name, g.origin.line); !fresh)
      problems.add(g.origin.line, "Gateway",
                   fmt::format("the name {} is already taken in line {}: names are unique", g.name,
                               it->second));
    if (const auto it = network_line.find(g.name); it != network_line.end())
      problems.add(g.origin.line, "Gateway",
                   fmt::format("{} is already a network's name, in line {}: both are places, and "
                               "a place is asked for by name",
                               g.name, it->second));
    check_ports_of(system, g, problems);
    const auto number = static_cast<std::size_t>(&g - system.gateways.data());
    if (number >= kMaxGateways) continue;
    // A host name cannot begin with '#': gateways without a stated host are machines of their own.
    auto& machine = machines[g.host.empty() ? fmt::format("#{}", number) : g.host];
    for (const auto& p : std::span(g.ports).first(std::min(g.ports.size(), kMaxPorts)))
      machine.push_back(&p);
  }
  for (const auto& [host, ports] : machines) check_claims(ports, problems);
  if (system.gateways.size() > kMaxGateways)
    problems.add(
        system.gateways[kMaxGateways].origin.line, "Gateway",
        fmt::format("{} gateways are too many: at most {}", system.gateways.size(), kMaxGateways));
}

}  // namespace mlcca::description
