// SPDX-License-Identifier: BSD-2-Clause
// Each finding about a route names the place that it is about, and the numbers.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/design/inspected.hpp"

namespace mlcca::core::testing {
namespace {

const Finding& of(const Inspection& inspection, FindingId id) {
  static const Finding none;
  const auto it = std::ranges::find(inspection.findings, id, &Finding::id);
  EXPECT_NE(it, inspection.findings.end()) << code_of(id);
  return it == inspection.findings.end() ? none : *it;
}

void expect_place(const Finding& f, Place place, const std::string& attribute) {
  EXPECT_TRUE(f.has_place) << f.text;
  EXPECT_EQ(f.place, place) << f.text;
  EXPECT_EQ(f.attribute, attribute) << f.text;
}

TEST(FindingPlace, OfAHopIsTheHop) {
  const Inspection found = inspect(described(5));
  const Finding& f = of(found, Id::hop_unfit);
  expect_place(f, gateway(kBridge), "Omission");
  EXPECT_EQ(f.required, "2");
  EXPECT_EQ(f.provided, "5");
}

TEST(FindingPlace, OfTheWholeWayThereIsNone) {
  System system = described(1);
  for (Network& n : system.networks) n.provision.set(Attribute::omission, 1);
  const Inspection found = inspect(system);
  const Finding& f = of(found, Id::route_unfit);
  EXPECT_FALSE(f.has_place);
  EXPECT_EQ(f.attribute, "Omission");
}

TEST(FindingPlace, OfACapacityIsTheNetworkThatIsFull) {
  System system = described(0);
  system.networks[kRobotCan].provision.set(Attribute::bandwidth, 159);
  const Inspection found = inspect(system);
  const Finding& f = of(found, Id::capacity);
  expect_place(f, network(kRobotCan), "Bandwidth");
  EXPECT_EQ(f.required, "160 B/s");
  EXPECT_EQ(f.provided, "159 B/s");
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
  const Finding& f = of(found, Id::run_time);
  EXPECT_TRUE(f.has_place);
  EXPECT_EQ(f.place, network(kSecondCan)) << "the publisher's";
  EXPECT_EQ(f.text.find("Omission"), f.text.rfind("Omission")) << "each attribute is named once";
}

}  // namespace
}  // namespace mlcca::core::testing
