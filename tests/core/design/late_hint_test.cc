// SPDX-License-Identifier: BSD-2-Clause
// What is said of messages that come too late: J1939 transport, and gateways that take the time.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/design/inspect.hpp"
#include "tests/core/design/inspected.hpp"

namespace mlcca::core::testing {
namespace {

constexpr Value kMillisecond = 1'000'000;

/// 20 bytes: an announcement and three packets, with up to 200 ms between two of the four.
System transported(Value period, Value deadline) {
  System system;
  system.name = "tractor";
  system.files = {"s.xml"};
  EventChannel& channel = system.channels.emplace_back();
  channel.name = "identity";
  channel.subject = 1;
  channel.attributes = AttributeSet{}
                           .set(Attribute::period, period)
                           .set(Attribute::deadline, deadline)
                           .set(Attribute::max_payload, 20);
  Network& bus = system.networks.emplace_back();
  bus.name = "drive";
  bus.profile = Profile::j1939;
  bus.bus.bitrate = 250'000;
  Binding& pgn = bus.bindings.emplace_back();
  pgn.id = 65'001;
  pgn.extended = true;
  pgn.priority = 3;
  Publisher& publisher = system.publishers.emplace_back();
  publisher.name = "engine";
  publisher.place = {Place::Kind::network, 0};
  publisher.node = 3;
  publisher.attributes = channel.attributes;
  Subscriber& subscriber = system.subscribers.emplace_back();
  subscriber.name = "panel";
  subscriber.place = {Place::Kind::network, 0};
  subscriber.attributes = channel.attributes;
  return system;
}

TEST(TransportHintTest, PausesThatAreLongerThanTheDeadlineAreTheCause) {
  const Inspection inspection = inspect(transported(700 * kMillisecond, 500 * kMillisecond));
  const Finding& found = only(inspection);
  EXPECT_EQ(found.id, Id::deadline_missed);
  EXPECT_TRUE(found.text.contains("602.56 ms of the 500 ms they may take at most")) << found.text;
  EXPECT_EQ(found.hint,
            "allow engine more time, or let its events fit one frame: the transport protocol sends "
            "4 frames for each, which take up to 602.56 ms with the pauses between them");
}

TEST(TransportHintTest, PausesThatAreLongerThanThePeriodAreTheCause) {
  const Inspection inspection = inspect(transported(500 * kMillisecond, 2'000 * kMillisecond));
  const Finding& found = only(inspection);
  EXPECT_EQ(found.hint,
            "let engine send less often, or let its events fit one frame: the transport protocol "
            "sends 4 frames for each, which take up to 602.56 ms with the pauses between them, and "
            "the next event comes after 500 ms");
}

TEST(TransportHintTest, TheyFitWhereThereIsTime) {
  EXPECT_TRUE(inspect(transported(700 * kMillisecond, 603 * kMillisecond)).findings.empty());
}

/// Neither frames nor identifiers help where a gateway takes nearly all of the time.
TEST(LateHintTest, TheGatewaysOfTheWayAreNamedWhereTheyTakeMostOfTheTime) {
  System system = described(0);
  for (const std::size_t n : {kRobotCan, kSecondCan}) {
    system.networks[n].bus.bitrate = 500'000;
    system.networks[n].provision = AttributeSet{}.set(Attribute::omission, 0);
  }
  system.gateways[kBridge]
      .provision.set(Attribute::latency, 5 * kMillisecond)
      .set(Attribute::jitter, 0);
  system.publishers[0].attributes.set(Attribute::deadline, 5 * kMillisecond + 100'000);
  const Inspection inspection = inspect(system);
  const auto late = std::ranges::find(inspection.findings, Id::deadline_missed, &Finding::id);
  ASSERT_NE(late, inspection.findings.end());
  EXPECT_TRUE(
      late->hint.ends_with("let the gateways on its way take less: they take 5 ms of its "
                           "5.1 ms"))
      << late->hint;
}

/// 8 bytes each 50 ms on one bus of 500 kbit/s: 270 us.
System one_message(AttributeSet provision, AttributeSet required = {}) {
  System system = transported(50 * kMillisecond, 50 * kMillisecond);
  Network& bus = system.networks[0];
  bus.profile = Profile::raw;
  bus.bus.bitrate = 500'000;
  bus.provision = provision;
  bus.bindings[0].id = 0x10;
  bus.bindings[0].extended = false;
  for (AttributeSet* set : {&system.channels[0].attributes, &system.publishers[0].attributes,
                            &system.subscribers[0].attributes})
    set->set(Attribute::max_payload, 8);
  if (required.has(Attribute::jitter))
    system.subscribers[0].attributes.set(Attribute::jitter, required[Attribute::jitter]);
  return system;
}

/// More time would help nothing.
TEST(LateHintTest, AJitterThatIsTheCauseIsNamed) {
  const auto hint_of = [](const System& system) {
    const Inspection inspection = inspect(system);
    const auto late = std::ranges::find(inspection.findings, Id::deadline_missed, &Finding::id);
    return late == inspection.findings.end() ? std::string("none") : late->hint;
  };
  const auto promises = [](Value latency, Value jitter) {
    return AttributeSet{}.set(Attribute::latency, latency).set(Attribute::jitter, jitter);
  };
  EXPECT_EQ(hint_of(one_message(promises(3 * kMillisecond, 100'000))),
            "state a larger Jitter of drive, or none: what it delays counts as Jitter too, and 100 "
            "us is what it promises");
  EXPECT_EQ(
      hint_of(one_message(promises(3 * kMillisecond, 0))),
      "state a larger Jitter of drive, or none: what it delays counts as Jitter too, and 0 ns "
      "is what it promises");
  EXPECT_EQ(hint_of(one_message({}, AttributeSet{}.set(Attribute::jitter, 200'000))),
            "allow more Jitter: what a bus delays counts as Jitter, and 200 us is required");
  EXPECT_EQ(hint_of(one_message(promises(3 * kMillisecond, kMillisecond))), "none");
}

/// The bus of the robot with a bit rate, and times that follow from it.
System on_bus(std::uint32_t bitrate, Value deadline) {
  System system = described(0);
  Network& bus = system.networks[kRobotCan];
  bus.bus.bitrate = bitrate;
  bus.provision = AttributeSet{}.set(Attribute::omission, 0);
  system.publishers[0].attributes.set(Attribute::deadline, deadline);
  return system;
}

const Finding& late_in(const Inspection& inspection) {
  const auto f = std::ranges::find(inspection.findings, Id::deadline_missed, &Finding::id);
  EXPECT_NE(f, inspection.findings.end());
  static const Finding none;
  return f == inspection.findings.end() ? none : *f;
}

TEST(LateHintTest, ABusThatIsOverloadedIsNotHelpedByAnIdentifier) {
  const Inspection result = inspect(on_bus(2'000, 50 * kMs));
  EXPECT_EQ(
      late_in(result).hint,
      "send less often, or use a faster bus: what is granted there and these frames would take "
      "160.0 % of the time");
}

TEST(LateHintTest, FramesThatAloneTakeTooLongAreNotHelpedByAnIdentifier) {
  const Inspection result = inspect(on_bus(5'000, 20 * kMs));
  EXPECT_EQ(late_in(result).hint,
            "allow switch more time, let it send smaller events, or use a faster bus: its frames "
            "alone take 32 ms");
}

TEST(LateHintTest, FramesThatOthersDelayAreHelpedByAnIdentifier) {
  System system = heart_beats(2, 100'000);
  Network& bus = system.networks[kRobotCan];
  bus.bus.bitrate = 8'000;
  bus.provision = AttributeSet{}.set(Attribute::omission, 0);
  system.publishers[1].attributes.set(Attribute::deadline, 30 * kMs);
  const Inspection result = inspect(system);
  EXPECT_TRUE(late_in(result).hint.starts_with("give sender-1 a better identifier"))
      << late_in(result).hint;
}

/// Five messages of 32 % of the bus each, three of which would be granted: whichever goes first,
/// another one is late.
TEST(LateHintTest, AnotherOrderIsNotAdvisedWhereAllTogetherAreTooMuch) {
  System system = heart_beats(5, 100'000);
  Network& bus = system.networks[kRobotCan];
  bus.bus.bitrate = 8'000;
  bus.provision = AttributeSet{}.set(Attribute::omission, 0);
  system.publishers[1].attributes.set(Attribute::deadline, 30 * kMs);
  EXPECT_EQ(late_in(inspect(system)).hint,
            "send less often, or use a faster bus: all that is described for robot-can takes more "
            "than all of its time, so another order of identifiers only lets others be late");
}

TEST(LateHintTest, FramesThatHaveTheBestIdentifierAreNotHelpedByAnother) {
  System system = heart_beats(2, 100'000);
  Network& bus = system.networks[kRobotCan];
  bus.bus.bitrate = 8'000;
  bus.provision = AttributeSet{}.set(Attribute::omission, 0);
  system.publishers[0].attributes.set(Attribute::deadline, 30 * kMs);
  const std::string hint = late_in(inspect(system)).hint;
  EXPECT_TRUE(hint.starts_with("allow switch more time, send smaller events")) << hint;
}

TEST(LateHintTest, FramesOfTooMuchJitterAreNotHelpedByABiggerPeriod) {
  constexpr Value second = 1000 * kMs;
  System system = on_bus(500'000, 9000 * second);
  system.publishers[0].attributes.set(Attribute::jitter, 2000 * second);
  EXPECT_EQ(late_in(inspect(system)).hint,
            "state a smaller Jitter of switch: 2000 s is more than what is analysed");
}

}  // namespace
}  // namespace mlcca::core::testing
