// SPDX-License-Identifier: BSD-2-Clause
#include "core/gates/relay_gate.hpp"

#include <algorithm>

#include "core/profiles/profile.hpp"

namespace mlcca::core {
namespace {

using mesh::Source;
using mesh::SourceKind;

bool has(const mesh::Mesh& mesh, SourceKind kind) {
  return std::ranges::find(mesh.sources, kind, &Source::kind) != mesh.sources.end();
}

bool has(const mesh::Mesh& mesh, SourceKind kind, const std::string& interface) {
  return std::ranges::any_of(
      mesh.sources, [&](const Source& s) { return s.kind == kind && s.interface == interface; });
}

/// Whether the interface is recognised by properties that only hardware has.
bool is_hardware(const InterfaceIdentity& identity) {
  return !identity.id_path.empty() || !identity.serial.empty() || identity.port.has_value();
}

}  // namespace

RelayGate relay_gate(const System& system, std::size_t network, std::size_t gateway) {
  const Network& n = system.networks[network];
  const Port* port = system.gateways[gateway].port_on(network);
  if (!n.mesh || !names_channels(n.profile) || port == nullptr) return RelayGate::none;
  const InterfaceIdentity& identity = port->identity;
  // AWDS uses the radio, and its own device is a different one.
  if (has(*n.mesh, SourceKind::awds) &&
      (is_hardware(identity) || has(*n.mesh, SourceKind::awds, identity.name)))
    return RelayGate::radio;
  // batman-adv as a source is named by its own device.
  const bool named = !identity.name.empty();
  if (has(*n.mesh, SourceKind::batman) &&
      (is_hardware(identity) || (named && !has(*n.mesh, SourceKind::batman, identity.name))))
    return RelayGate::radio;
  if (has(*n.mesh, SourceKind::babel) || has(*n.mesh, SourceKind::olsr)) return RelayGate::routed;
  return RelayGate::none;
}

std::string relay_problem(const System& system, std::size_t network, std::size_t gateway) {
  const Network& n = system.networks[network];
  if (!n.mesh || n.mesh->nodes.size() < 3 ||
      relay_gate(system, network, gateway) == RelayGate::none)
    return {};
  return "the gate of gateway " + system.gateways[gateway].name + " on mesh " + n.name +
         " is below the mesh: events that its node only relays are dropped there";
}

std::string relay_hint(const System& system, std::size_t network, std::size_t gateway) {
  if (relay_gate(system, network, gateway) == RelayGate::routed)
    return "let other nodes relay: the gate of gateway " + system.gateways[gateway].name +
           " drops what that gateway only routes";
  const auto& sources = system.networks[network].mesh->sources;
  // If the source names the device of AWDS itself, the source is wrong and the Port is right.
  const std::string& named = system.gateways[gateway].port_on(network)->identity.name;
  if (named.starts_with("awds") &&
      has(system.networks[network].mesh.value(), SourceKind::awds, named))
    return "name the radio in <Source kind=\"awds\" interface=\"…\"/>: " + named +
           " is the mesh's own device, which AWDS makes";
  const auto batman = std::ranges::find(sources, SourceKind::batman, &Source::kind);
  return "give the Port the mesh's own device: <Interface name=\"" +
         (batman != sources.end() ? batman->interface : std::string("awds0")) + "\"/>";
}

}  // namespace mlcca::core
