// SPDX-License-Identifier: BSD-2-Clause
// Each finding about a route names the place that it is about, and the numbers.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/design/inspected.hpp"

namespace mlcca::core::testing {
namespace {

Finding of(const Inspection& inspection, FindingId id) {
  const auto it = std::ranges::find(inspection.findings, id, &Finding::id);
  EXPECT_NE(it, inspection.findings.end()) << code_of(id);
  return it == inspection.findings.end() ? Finding{} : *it;
}

void expect_place(const Finding& f, Place place, const std::string& attribute) {
  EXPECT_TRUE(f.has_place) << f.text;
  EXPECT_EQ(f.place, place) << f.text;
  EXPECT_EQ(f.attribute, attribute) << f.text;
}

TEST(FindingPlace, OfAHopIsTheHop) {
  const Inspection found = inspect(described(5));
  const Finding f = of(found, Id::hop_unfit);
  expect_place(f, gateway(kBridge), "Omission");
  EXPECT_EQ(f.required, "2");
  EXPECT_EQ(f.provided, "5");
}

TEST(FindingPlace, OfTheWholeWayThereIsNone) {
  System system = described(1);
  for (Network& n : system.networks) n.provision.set(Attribute::omission, 1);
  const Inspection found = inspect(system);
  const Finding f = of(found, Id::route_unfit);
  EXPECT_FALSE(f.has_place);
  EXPECT_EQ(f.attribute, "Omission");
}

TEST(FindingPlace, OfACapacityIsTheNetworkThatIsFull) {
  System system = described(0);
  system.networks[kRobotCan].provision.set(Attribute::bandwidth, 159);
  const Inspection found = inspect(system);
  const Finding f = of(found, Id::capacity);
  expect_place(f, network(kRobotCan), "Bandwidth");
  EXPECT_EQ(f.required, "160 B/s");
  EXPECT_EQ(f.provided, "159 B/s");
  EXPECT_EQ(f.text, "switch needs 160 B/s on robot-can, which carries 159 B/s in all");

  // Another channel that needs as much comes first.
  system.networks[kRobotCan].provision.set(Attribute::bandwidth, 200);
  system.channels.insert(system.channels.begin(), system.channels[0]);
  system.publishers.push_back(system.publishers[0]);
  system.subscribers.push_back(system.subscribers[0]);
  system.publishers[0].channel = system.subscribers[0].channel = 1;
  for (Network& n : system.networks) {
    n.bindings.push_back(n.bindings[0]);
    n.bindings[1].channel = 1;
    n.bindings[1].id = kEtag + 1;
  }
  const Inspection shared = inspect(system);
  EXPECT_TRUE(of(shared, Id::capacity)
                  .text.ends_with("where 40 B/s of 200 B/s are left (160 B/s for other channels)"))
      << of(shared, Id::capacity).text;
}

/// Each place in turn, the first of them as well.
TEST(FindingPlace, OfANetworkOrAGatewayIsItself) {
  for (const std::size_t n : {0, 1}) {
    System system = described(0);
    std::erase_if(system.gateways[kBridge].ports, [&](const Port& p) { return p.network == n; });
    expect_place(of(inspect(system), Id::unreachable_network), network(n), "");
  }
  for (const std::size_t n : {0, 1}) {
    System system = described(0);
    Network& air = system.networks[n];
    air.kind = NetworkKind::mesh;
    air.bindings.clear();
    air.mesh.emplace();
    air.mesh->nodes = {{"a", "a", 0, {}}, {"b", "b", {}, {}}};
    expect_place(of(inspect(system), Id::no_links), network(n), "");
    air.mesh->sources.resize(1);
    air.mesh->sources[0].kind = mesh::SourceKind::babel;
    const auto is_relay = [](const Finding& f) { return f.id == Id::relay_gated; };
    EXPECT_TRUE(std::ranges::none_of(inspect(system).findings, is_relay)) << "of two nodes";
    air.mesh->nodes.push_back({"c", "c", {}, {}});
    expect_place(of(inspect(system), Id::relay_gated), gateway(kBridge), "");
  }
}

TEST(FindingPlace, OfAPortThatCannotBeMeantSoIsItsGateway) {
  System system = described(0);
  system.networks[kSecondCan].kind = NetworkKind::udp_multicast;
  system.networks[kSecondCan].bindings.clear();
  system.publishers[0].node = 5;
  for (Port& port : system.gateways[kBridge].ports) {
    port.managed = true;
    port.sender = 1000;
  }
  const Inspection found = inspect(system);
  std::size_t managed = 0;
  std::size_t senders = 0;
  for (const Finding& f : found.findings) {
    managed += f.id == Id::managed_in_vain ? 1 : 0;
    senders += f.id == Id::unstarted_sender ? 1 : 0;
    if (f.id == Id::managed_in_vain || f.id == Id::unstarted_sender)
      expect_place(f, gateway(kBridge), "");
  }
  EXPECT_TRUE(of(found, Id::unstarted_sender)
                  .hint.ends_with("or remove sender: then mlcca-relay carries them"));
  for (const Forwarder other : {Forwarder::can_gw, Forwarder::none}) {
    system.gateways[kBridge].forwarder = other;
    EXPECT_TRUE(of(inspect(system), Id::unstarted_sender)
                    .hint.ends_with(
                        "or state forward=\"relay\" in place of sender: then mlcca-relay carries "
                        "them"));
  }
  system.gateways[kBridge].forwarder = Forwarder::relay;
  EXPECT_EQ(managed, 1U) << "of the port that is not on CAN";
  EXPECT_EQ(senders, 2U) << "a program carries events either way";
  system.networks[kSecondCan] = can_network("second-can");
  for (const Finding& f : inspect(system).findings)
    EXPECT_FALSE(f.id == Id::managed_in_vain || f.id == Id::unstarted_sender) << f.text;
}

TEST(NoSender, IsAnsweredByWhatTheGatewayCanHave) {
  System system = described(0);
  system.networks[kSecondCan].kind = NetworkKind::udp_multicast;
  system.networks[kSecondCan].bindings.clear();
  system.publishers[0].node = 5;
  const auto found = [&](Forwarder forwarder) {
    system.gateways[kBridge].forwarder = forwarder;
    return of(inspect(system), Id::no_route);
  };
  const Finding relay = found(Forwarder::relay);
  EXPECT_TRUE(
      relay.text.ends_with("there is none: install mlcca-relay, whose user it runs as, or "
                           "state a sender of its Port"))
      << relay.text;
  EXPECT_EQ(relay.hint, "add sender=\"USER\" to the Port that the events leave by");
  for (const Forwarder other : {Forwarder::can_gw, Forwarder::none}) {
    const Finding none = found(other);
    EXPECT_TRUE(none.text.ends_with(
        "there is none: state a sender of its Port, or forward=\"relay\" of the Gateway"))
        << none.text;
    EXPECT_EQ(none.hint,
              "add sender=\"USER\" to the Port that the events leave by, or forward=\"relay\" to "
              "the Gateway: then mlcca-relay carries them");
  }
}

/// Frames of CAN name their publisher by node or identifier.
TEST(SharedLimit, IsOfPublishersThatLookAlikeToAGateOfEthernet) {
  System system = described(0);
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "second";
  const auto is_shared = [](const System& s) {
    const Inspection found = inspect(s);
    return std::ranges::find(found.findings, Id::shared_limit, &Finding::id) !=
           found.findings.end();
  };
  EXPECT_FALSE(is_shared(system));
  for (Network& n : system.networks) {
    n.kind = NetworkKind::udp_multicast;
    n.bindings.clear();
  }
  EXPECT_TRUE(is_shared(system));
  system.publishers[1].station = station_of("192.0.2.7").value();
  EXPECT_FALSE(is_shared(system));
  system.publishers[0].station = system.publishers[1].station;
  EXPECT_TRUE(is_shared(system));
  std::erase_if(system.gateways[kBridge].ports,
                [](const Port& p) { return p.network == kSecondCan; });
  EXPECT_FALSE(is_shared(system)) << "there is no gate";
}

TEST(FindingPlace, OfALateMessageIsItsBus) {
  System system = described(0);
  system.networks[kRobotCan].bus.bitrate = 1000;  // 160 ms a frame
  const Inspection found = inspect(system);
  const auto f = std::ranges::find_if(
      found.findings, [](const Finding& x) { return x.attribute == "Deadline" && x.has_place; });
  ASSERT_NE(f, found.findings.end());
  EXPECT_EQ(f->place, network(kRobotCan));
}

TEST(FindingPlace, OfAnOverhearingSubscriberIsItsNetwork) {
  System system = described(0);
  system.networks.push_back(can_network("far-can"));
  Gateway behind = system.gateways[kBridge];
  behind.name = "behind";
  behind.ports[0].network = kRobotCan;
  behind.ports[1].network = 2;
  behind.provision.set(Attribute::omission, 0);
  system.gateways.push_back(behind);
  // Nothing is lost before the network itself.
  system.networks[kRobotCan].provision.set(Attribute::omission, 2);
  system.subscribers[0].attributes.set(Attribute::omission, 1);
  system.subscribers.push_back(subscriber("far", network(2), heart_beat()));
  const Inspection found = inspect(system);
  expect_place(of(found, Id::overhearing_unfit), network(kRobotCan), "Omission");
}

TEST(FindingPlace, OfWhatTheRunTimeDecidesIsTheFirstThatIsNotKnown) {
  System system = described(0);
  for (Network& n : system.networks) n.provision.set(Attribute::omission, 0, true);
  const Inspection found = inspect(system);
  const Finding f = of(found, Id::run_time);
  EXPECT_TRUE(f.has_place);
  EXPECT_EQ(f.place, network(kSecondCan)) << "the publisher's";
  EXPECT_EQ(f.text.find("Omission"), f.text.rfind("Omission")) << "each attribute is named once";
}

}  // namespace
}  // namespace mlcca::core::testing
