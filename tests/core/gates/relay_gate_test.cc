// SPDX-License-Identifier: BSD-2-Clause
// Whether the gate of a Port is in the way of what its node relays in a mesh.
#include "core/gates/relay_gate.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace mlcca::core {
namespace {

struct Named {
  mesh::SourceKind kind;
  std::string interface;
};

/// A gateway with a port on a mesh that these sources know.
System with_mesh(const std::vector<Named>& sources, const InterfaceIdentity& identity) {
  System system;
  Network& n = system.networks.emplace_back();
  n.name = "air";
  n.kind = NetworkKind::mesh;
  n.profile = Profile::famouso;
  n.mesh.emplace();
  for (const Named& named : sources) {
    mesh::Source& source = n.mesh->sources.emplace_back();
    source.kind = named.kind;
    source.interface = named.interface;
  }
  Gateway& g = system.gateways.emplace_back();
  g.name = "g";
  g.ports.emplace_back().identity = identity;
  return system;
}

RelayGate gate_of(const std::vector<Named>& sources, const InterfaceIdentity& identity) {
  return relay_gate(with_mesh(sources, identity), 0, 0);
}

InterfaceIdentity identity(auto change) {
  InterfaceIdentity out;
  change(out);
  return out;
}
InterfaceIdentity named(const std::string& name) {
  return identity([&](InterfaceIdentity& i) { i.name = name; });
}

const InterfaceIdentity kNoName;
const InterfaceIdentity kRadio = named("wlan0");
const InterfaceIdentity kMesh = named("mesh0");

TEST(RelayGate, WhatIsRecognisedByItsHardwareIsTheRadio) {
  const std::vector<InterfaceIdentity> hardware = {
      identity([](InterfaceIdentity& i) { i.id_path = "pci-0"; }),
      identity([](InterfaceIdentity& i) { i.serial = "7"; }),
      identity([](InterfaceIdentity& i) { i.port = 0; }),
      identity([](InterfaceIdentity& i) { i.name = "mesh0", i.serial = "7"; })};
  for (const InterfaceIdentity& one : hardware) {
    EXPECT_EQ(gate_of({{mesh::SourceKind::batman, "mesh0"}}, one), RelayGate::radio);
    EXPECT_EQ(gate_of({{mesh::SourceKind::awds, "wlan0"}}, one), RelayGate::radio);
    EXPECT_EQ(gate_of({}, one), RelayGate::none);
  }
  const auto alias = identity([](InterfaceIdentity& i) { i.alias = "mesh"; });
  EXPECT_EQ(gate_of({{mesh::SourceKind::batman, "mesh0"}}, alias), RelayGate::none);
}

TEST(RelayGate, AwdsListensToTheRadioAndBatmanIsAskedForItsOwnDevice) {
  EXPECT_EQ(gate_of({{mesh::SourceKind::awds, "wlan0"}}, kRadio), RelayGate::radio);
  EXPECT_EQ(gate_of({{mesh::SourceKind::awds, "wlan0"}}, kMesh), RelayGate::none);
  EXPECT_EQ(gate_of({{mesh::SourceKind::batman, "mesh0"}}, kRadio), RelayGate::radio);
  EXPECT_EQ(gate_of({{mesh::SourceKind::batman, "mesh0"}}, kMesh), RelayGate::none);
  EXPECT_EQ(gate_of({{mesh::SourceKind::batman, "mesh0"}}, kNoName), RelayGate::none);
  const std::vector<Named> two = {{mesh::SourceKind::batman, "mesh0"},
                                  {mesh::SourceKind::batman, "mesh1"}};
  EXPECT_EQ(gate_of(two, named("mesh1")), RelayGate::none);
  EXPECT_EQ(gate_of({{mesh::SourceKind::nl80211, "wlan0"}}, kRadio), RelayGate::none);
}

TEST(RelayGate, WhatBabelAndOlsrRelayIsRouted) {
  for (const mesh::SourceKind kind : {mesh::SourceKind::babel, mesh::SourceKind::olsr}) {
    EXPECT_EQ(gate_of({{kind, ""}}, kMesh), RelayGate::routed);
    EXPECT_EQ(gate_of({{kind, ""}}, kNoName), RelayGate::routed);
    EXPECT_EQ(gate_of({{kind, ""}, {mesh::SourceKind::batman, "mesh0"}}, kRadio), RelayGate::radio);
  }
}

TEST(RelayGate, WhereThereIsNoGateNoneIsInTheWay) {
  System system = with_mesh({{mesh::SourceKind::babel, ""}}, kMesh);
  system.networks[0].profile = Profile::none;
  EXPECT_EQ(relay_gate(system, 0, 0), RelayGate::none);
  system = with_mesh({{mesh::SourceKind::babel, ""}}, kMesh);
  system.gateways[0].ports.clear();
  EXPECT_EQ(relay_gate(system, 0, 0), RelayGate::none);
  system = with_mesh({}, kMesh);
  system.networks[0].mesh.reset();
  EXPECT_EQ(relay_gate(system, 0, 0), RelayGate::none);
}

TEST(RelayGate, TheHintNamesWhatIsToBeDone) {
  EXPECT_EQ(relay_hint(with_mesh({{mesh::SourceKind::babel, ""}}, kMesh), 0, 0),
            "let other nodes relay: the gate of gateway g drops what that gateway only routes");
  EXPECT_EQ(relay_hint(with_mesh({{mesh::SourceKind::batman, "bat7"}}, kRadio), 0, 0),
            "give the Port the mesh's own device: <Interface name=\"bat7\"/>");
  EXPECT_EQ(relay_hint(with_mesh({{mesh::SourceKind::awds, "wlan0"}}, kRadio), 0, 0),
            "give the Port the mesh's own device: <Interface name=\"awds0\"/>");
  System own = with_mesh({{mesh::SourceKind::awds, "awds0"}}, kRadio);
  own.gateways[0].ports[0].identity.name = "awds0";
  EXPECT_EQ(relay_hint(own, 0, 0),
            "name the radio in <Source kind=\"awds\" interface=\"…\"/>: awds0 is the mesh's own "
            "device, which AWDS makes");
}

TEST(RelayGate, IsAProblemWhereANodeMayRelay) {
  System system = with_mesh({{mesh::SourceKind::batman, "bat0"}}, kRadio);
  system.networks[0].mesh->nodes.resize(2);
  EXPECT_EQ(relay_problem(system, 0, 0), "") << "between two nodes nobody relays";
  system.networks[0].mesh->nodes.resize(3);
  EXPECT_EQ(relay_problem(system, 0, 0),
            "the gate of gateway g on mesh air is below the mesh: events that its node only relays "
            "are dropped there");
  system.gateways[0].ports[0].identity.name = "bat0";
  EXPECT_EQ(relay_problem(system, 0, 0), "");
}

}  // namespace
}  // namespace mlcca::core
