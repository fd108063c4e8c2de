// SPDX-License-Identifier: BSD-2-Clause
// A program takes up the end that is meant for it, and no other one.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

using control::AnnounceRequest;
using control::Role;

constexpr core::Place kGateway{core::Place::Kind::gateway, 0};
constexpr uid_t kUser = 1000;

core::Publisher publisher(const core::System& system, const std::string& name, uid_t user) {
  core::Publisher p;
  p.name = name;
  p.place = kGateway;
  p.uid = user;
  p.attributes = system.channels[0].attributes;
  return p;
}

/// Channel c0 (Period 50 ms, MaxPayload 8) of a local program "lever", to a bus and to a local
/// program "lamp".
core::System with_programs() {
  core::System system = small_system();
  system.publishers = {publisher(system, "lever", kUser)};
  core::Subscriber lamp = system.subscribers[0];
  lamp.name = "lamp";
  lamp.place = kGateway;
  system.subscribers.push_back(lamp);
  return system;
}

serve::Peer program(uid_t uid = kUser) { return {.pid = 7, .uid = uid}; }

control::Attribute attribute(const std::string& name, Value value) {
  return {.name = name, .value = value, .unit = {}, .dynamic = false};
}

class Announce : public ::testing::Test {
 protected:
  serve::Answer ask(const AnnounceRequest& request, serve::Peer peer = program()) {
    return bench_.ask(request, peer);
  }
  /// The error; empty: it was taken up.
  std::string refusal(const AnnounceRequest& request, serve::Peer peer = program()) {
    const serve::Answer answer = ask(request, peer);
    const auto* error = std::get_if<control::Error>(&answer.reply.body);
    EXPECT_EQ(answer.follows.has_value(), error == nullptr);
    return error == nullptr ? "" : error->message;
  }
  std::string stating(Role role, const std::string& name, Value value) {
    return refusal({"c0", role, "", {attribute(name, value)}});
  }
  void reload() {
    static_cast<void>(bench_.ask(control::ReloadRequest{}));
    bench_.reading().finish();
  }
  void SetUp() override { ASSERT_FALSE(bench_.start()); }

  Bench bench_{with_programs()};
};

TEST_F(Announce, APublisherGetsItsDeliveriesAndTheEventsOfItsChannel) {
  const serve::Answer answer = ask({"c0", Role::publisher, "", {}});
  const auto& channels = std::get<control::Channels>(answer.reply.body);
  ASSERT_EQ(channels.channels.size(), 2U);
  for (const auto& c : channels.channels) {
    EXPECT_EQ(c.publisher, "lever");
    EXPECT_TRUE(c.granted) << c.reason;
  }
  EXPECT_EQ(channels.grace_ns, bench_.kernel.grace) << "how long this holds without a daemon";
  EXPECT_NE(channels.grace_ns, 0U);
  EXPECT_EQ(answer.follows, 1U);
  EXPECT_FALSE(answer.held);
}

TEST_F(Announce, ASubscriberGetsTheDeliveriesToIt) {
  const serve::Answer answer = ask({"0x1", Role::subscriber, "lamp", {}}, program(4711));
  const auto& channels = std::get<control::Channels>(answer.reply.body);
  ASSERT_EQ(channels.channels.size(), 1U);
  EXPECT_EQ(channels.channels[0].to, "g");
  EXPECT_EQ(answer.follows, 1U);
}

TEST_F(Announce, NothingIsDecidedAgain) {
  const auto before = bench_.wanted();
  const std::size_t events = bench_.events.size();
  EXPECT_EQ(refusal({"c0", Role::publisher, "", {}}), "");
  EXPECT_EQ(bench_.wanted(), before);
  EXPECT_EQ(bench_.events.size(), events);
}

TEST_F(Announce, APublisherIsOnlyForItsUser) {
  for (const uid_t other : {uid_t{0}, uid_t{1001}})
    EXPECT_EQ(
        refusal({"c0", Role::publisher, "", {}}, program(other)),
        "lever is for programs of user 1000, and this one is of user " + std::to_string(other));
}

/// In a group of that number and in that unit; or one that has ended.
class FakeProcess final : public serve::Process {
 public:
  FakeProcess(gid_t group, std::string unit, bool lives = true)
      : group_(group), unit_(std::move(unit)), lives_(lives) {}
  [[nodiscard]] bool is_in(gid_t group) const override { return group == group_; }
  [[nodiscard]] Result<std::string> unit() const override {
    if (!lives_) return fail("the process that connected has ended");
    return unit_;
  }

 private:
  gid_t group_;
  std::string unit_;
  bool lives_;
};

serve::Peer program_in(gid_t group, const std::string& unit, bool lives = true) {
  return {
      .pid = 7, .uid = kUser, .process = std::make_shared<const FakeProcess>(group, unit, lives)};
}

TEST_F(Announce, AnEndMayBeForAGroupAndAUnitAlone) {
  bench_.system.program_rules = {{.gid = 44, .group = "drivers", .unit = ""},
                                 {.gid = {}, .group = "", .unit = "lamp.service"}};
  bench_.system.publishers[0].program_rule = 0;
  bench_.system.subscribers.back().program_rule = 1;
  reload();
  const AnnounceRequest lever{"c0", Role::publisher, "", {}};
  EXPECT_EQ(refusal(lever, program_in(44, "")), "");
  const std::string not_in = "lever is for programs in group drivers, and this one is not in it";
  EXPECT_EQ(refusal(lever, program_in(45, "")), not_in);
  EXPECT_EQ(refusal(lever), not_in) << "nobody knows its groups";
  EXPECT_EQ(refusal(lever, {.pid = 7, .uid = 0}),
            "lever is for programs of user 1000, and this one is of user 0");
  const AnnounceRequest lamp{"c0", Role::subscriber, "", {}};
  EXPECT_EQ(refusal(lamp, program_in(1, "lamp.service")), "");
  EXPECT_EQ(refusal(lamp, program_in(1, "other.service")),
            "lamp is for programs of unit lamp.service, and this one is of other.service");
  EXPECT_EQ(refusal(lamp, program_in(1, "")),
            "lamp is for programs of unit lamp.service, and this one is of none");
  EXPECT_EQ(refusal(lamp, program_in(1, "lamp.service", false)),
            "lamp is for programs of unit lamp.service: the process that connected has ended");
  EXPECT_NE(refusal(lamp), "");
}

/// A group that this machine does not know is nobody's.
TEST_F(Announce, AGroupWithoutANumberHasNoMembers) {
  bench_.system.program_rules = {{.gid = {}, .group = "drivers", .unit = ""}};
  bench_.system.publishers[0].program_rule = 0;
  reload();
  EXPECT_NE(refusal({"c0", Role::publisher, "", {}}, program_in(0, "")), "");
}

TEST_F(Announce, WhatIsNotThereIsRefusedWithWhatIs) {
  EXPECT_EQ(refusal({"c1", Role::publisher, "", {}}),
            "no publisher of this channel is on g: describe one there, or admit one");
  EXPECT_EQ(refusal({"c0", Role::publisher, "leever", {}}),
            "no publisher 'leever' of this channel is on g (there are: lever)");
  EXPECT_EQ(refusal({"c0", Role::subscriber, "lever", {}}),
            "no subscriber 'lever' of this channel is on g (there are: lamp)");
  EXPECT_EQ(refusal({"c0", Role::unspecified, "", {}}), "say the role: publisher or subscriber");
  EXPECT_NE(refusal({"c9", Role::publisher, "", {}}).find("c9"), std::string::npos);
  EXPECT_EQ(refusal({"c9\x1b[2J" + std::string(10'000, 'a'), Role::publisher, "", {}}),
            "no event channel is called 'c9?[2J" + std::string(58, 'a') + "…' (channels: c0, c1)");
  EXPECT_EQ(refusal({"c0", Role::publisher, "lee\nver", {}}),
            "no publisher 'lee?ver' of this channel is on g (there are: lever)");
}

TEST_F(Announce, OfSeveralEndsOneUserSaysWhich) {
  bench_.system.publishers.push_back(publisher(bench_.system, "handle", kUser));
  bench_.system.publishers.push_back(publisher(bench_.system, "pedal", 1001));
  reload();
  EXPECT_EQ(refusal({"c0", Role::publisher, "", {}}), "user 1000 may be lever, handle: say which");
  EXPECT_EQ(refusal({"c0", Role::publisher, "handle", {}}), "");
  EXPECT_EQ(refusal({"c0", Role::publisher, "", {}}, program(1001)), "");
}

TEST_F(Announce, AnEndThatAnOperatorHasAdmittedCanBeTakenUp) {
  control::Admit request;
  request.channel = "c0";
  request.from = "g";
  request.user = "1002";
  request.publisher = "spare";
  const serve::Answer admitted = bench_.ask(request);
  ASSERT_TRUE(std::holds_alternative<control::Channels>(admitted.reply.body));
  EXPECT_EQ(refusal({"c0", Role::publisher, "", {}}, program(1002)), "");
}

TEST_F(Announce, WhoStatesAsMuchOrLessIsTakenUp) {
  EXPECT_EQ(stating(Role::publisher, "Period", 50 * kMs), "");
  EXPECT_EQ(stating(Role::publisher, "Deadline", 50 * kMs), "") << "the Period implies it";
  EXPECT_EQ(stating(Role::publisher, "MaxPayload", 7), "");
  EXPECT_EQ(stating(Role::subscriber, "Period", 51 * kMs), "");
  EXPECT_EQ(stating(Role::subscriber, "MaxPayload", 9), "");
}

TEST_F(Announce, WhoStatesMoreIsRefusedWithBothValues) {
  EXPECT_EQ(stating(Role::publisher, "Period", 49 * kMs),
            "Period 49 ms is announced, and 50 ms is stated for this end: state what the program "
            "needs in the description");
  EXPECT_NE(stating(Role::publisher, "MaxPayload", 9), "");
  EXPECT_NE(stating(Role::subscriber, "Period", 49 * kMs), "");
  EXPECT_NE(stating(Role::subscriber, "MaxPayload", 7), "") << "events may have 8 bytes";
  EXPECT_EQ(stating(Role::publisher, "Latency", kMs),
            "Latency 1 ms is announced, and nothing is stated for this end: state it in the "
            "description");
  EXPECT_EQ(stating(Role::publisher, "Speed", 1), "there is no attribute 'Speed'");
}

/// Subscribers are promised an event every 50 ms.
TEST_F(Announce, APublisherThatSendsMoreSeldomIsRefused) {
  EXPECT_EQ(stating(Role::publisher, "Period", 51 * kMs),
            "Period 51 ms is announced, and 50 ms is stated for this end: state what the program "
            "needs in the description");
}

/// A program that was made for a Deadline of its Period relies on it.
TEST_F(Announce, AnImpliedDeadlineCounts) {
  for (core::Publisher& p : bench_.system.publishers)
    p.attributes.set(Attribute::deadline, 200 * kMs);
  reload();
  EXPECT_EQ(stating(Role::publisher, "Period", 50 * kMs),
            "Deadline 50 ms is announced (implied by the Period), and 200 ms is stated for this "
            "end: state what the program needs in the description");
  EXPECT_EQ(stating(Role::publisher, "MaxPayload", 8), "");
}

/// 8 bytes every 50 ms or, where that cannot be, 4 bytes every 200 ms.
TEST_F(Announce, WhatOneOfTheAttributeSetsHasIsInOrderWhicheverIsInUse) {
  core::System& system = bench_.system;
  const AttributeSet lower =
      AttributeSet{}.set(Attribute::period, 200 * kMs).set(Attribute::max_payload, 4);
  system.channels[0].lower = {{-1, lower, {}}};
  for (core::Publisher& p : system.publishers) p.lower = system.channels[0].lower;
  for (core::Subscriber& s : system.subscribers) s.lower = system.channels[0].lower;
  reload();
  EXPECT_EQ(stating(Role::publisher, "MaxPayload", 8), "");
  EXPECT_EQ(stating(Role::publisher, "Period", 200 * kMs), "") << "the preferred set is in use";
  EXPECT_NE(stating(Role::publisher, "Period", 100 * kMs), "") << "no set has that";
  system.subscribers.pop_back();  // only what leads to the bus, which carries 4 bytes
  for (core::Network& n : system.networks) n.provision.set(Attribute::max_payload, 4);
  reload();
  const core::Verdict& v = bench_.state().decisions()[0].verdicts.at(0);
  ASSERT_TRUE(v.granted);
  ASSERT_EQ(v.set, 1U);
  EXPECT_EQ(stating(Role::publisher, "Period", 200 * kMs), "");
  EXPECT_EQ(stating(Role::publisher, "MaxPayload", 8), "");
  EXPECT_EQ(stating(Role::publisher, "MaxPayload", 9),
            "MaxPayload 9 bytes is announced, and 8 bytes is stated for this end: state what the "
            "program needs in the description");
}

TEST_F(Announce, AWithdrawalNamesTheNetworkThatIsDown) {
  bench_.published.clear();
  const std::string second = bench_.state().system().networks[1].name;
  bench_.kernel.interfaces[second].up = false;
  bench_.daemon().links_changed();
  const auto withdrawn = std::ranges::find(bench_.published, "network-down", &control::Event::kind);
  ASSERT_NE(withdrawn, bench_.published.end());
  EXPECT_EQ(withdrawn->network_down, second);
  EXPECT_EQ(withdrawn->publisher, "lever");
  EXPECT_NE(withdrawn->message.find("is down"), std::string::npos) << withdrawn->message;
  bench_.kernel.interfaces[second].up = true;
  bench_.daemon().links_changed();
  bench_.published.clear();
  bench_.ask(control::WithdrawRequest{.channel = "c0"});
  EXPECT_EQ(std::ranges::count(bench_.published, "withdrawn", &control::Event::kind), 0);
  const auto by_hand = std::ranges::find(bench_.published, "revoked", &control::Event::kind);
  ASSERT_NE(by_hand, bench_.published.end());
  EXPECT_EQ(by_hand->network_down, "");
}

/// Its interfaces are others, and an abstract address there is another one.
TEST_F(Announce, AProgramInAnotherNetworkNamespaceIsRefused) {
  serve::Peer peer = program();
  EXPECT_EQ(refusal({"c0", Role::publisher, "lever", {}}, peer), "");
  peer.is_in_other_network = true;
  for (const Role role : {Role::publisher, Role::subscriber})
    EXPECT_EQ(refusal({"c0", role, "", {}}, peer),
              "this program is in another network namespace than mlccad, so its events do not pass "
              "the gates of this gateway: run it in that of mlccad");
}

/// The address of a session.
std::string address_of(std::uint64_t session) {
  return fmt::format("{:05x}{:016x}", session, session);
}

/// Channel c0 with the subscribers "lamp", which every program may be, and "motor", for a group.
class AnnouncePlaces : public Announce {
 protected:
  void SetUp() override {
    core::Subscriber motor = bench_.system.subscribers.back();
    motor.name = "motor";
    motor.program_rule = 0;
    bench_.system.program_rules = {{.gid = kGroup, .group = "drivers", .unit = ""}};
    bench_.system.subscribers.push_back(motor);
    ASSERT_FALSE(bench_.start());
  }
  control::Channels subscribe(const std::string& name, uid_t user, bool is_member = false) {
    serve::Peer peer = program_in(kGroup, "");
    peer.uid = user;
    peer.session = ++session_;
    peer.may_change = is_member || user == 0;
    AnnounceRequest request{"c0", Role::subscriber, name, {}};
    request.local = address_of(session_);
    return std::get<control::Channels>(ask(request, peer).reply.body);
  }
  std::string problem(const std::string& name, uid_t user, bool is_member = false) {
    return subscribe(name, user, is_member).local_problem;
  }
  std::size_t receivers() {
    const serve::Answer answer = ask({"c0", Role::publisher, "", {}});
    const auto& all = std::get<control::Channels>(answer.reply.body).endpoints;
    return static_cast<std::size_t>(
        std::ranges::count_if(all, [](const auto& one) { return !one.local.empty(); }));
  }

  static constexpr gid_t kGroup = 44;
  std::uint64_t session_ = 0;
};

TEST_F(AnnouncePlaces, OneUserHasAShare) {
  for (std::size_t i = 0; i < LocalEnds::kMostOfUser; ++i) EXPECT_EQ(problem("lamp", 1000), "");
  EXPECT_EQ(problem("lamp", 1000),
            "user 1000 has 16 of the 64 places of c0 for subscribers on this gateway, which is the "
            "most of one user");
  session_ = 0;
  EXPECT_EQ(problem("lamp", 1000), "") << "it has its place";
  session_ = LocalEnds::kMostOfUser;
  EXPECT_EQ(problem("lamp", 1001), "");
  bench_.daemon().session_closed(1);
  EXPECT_EQ(problem("lamp", 1000), "");
}

TEST_F(AnnouncePlaces, WhoNeedsNoRightTakesNoPlaceOfThoseWhoHaveOne) {
  for (const uid_t user : {1000U, 1001U})
    for (std::size_t i = 0; i < 16; ++i) ASSERT_EQ(problem("lamp", user), "");
  const std::string all_taken =
      "the 32 places of c0 for subscribers on this gateway are taken that every program can have";
  EXPECT_EQ(problem("lamp", 1002), all_taken);
  for (const uid_t user : {2000U, 2001U})
    for (std::size_t i = 0; i < 12; ++i) ASSERT_EQ(problem("motor", user), "");
  EXPECT_EQ(problem("motor", 2002),
            "the 56 places of c0 for subscribers on this gateway are taken that programs of other "
            "users than root and members can have");
  EXPECT_EQ(problem("lamp", 1002, true), "") << "a member";
  for (std::size_t i = 57; i < LocalEnds::kMostOfChannel; ++i) ASSERT_EQ(problem("lamp", 0), "");
  EXPECT_EQ(problem("lamp", 0), "the 64 places of c0 for subscribers on this gateway are taken");
  EXPECT_EQ(receivers(), 64U);
  bench_.daemon().session_closed(1);
  EXPECT_EQ(problem("motor", 2002), "") << "one of all places is free";
}

/// Root and members that have the ends of everyone take no place from them.
TEST_F(AnnouncePlaces, WhoHasARightTakesNoPlaceOfThoseWhoNeedNone) {
  for (std::size_t i = 0; i < 32; ++i) ASSERT_EQ(problem("lamp", 0), "");
  EXPECT_EQ(problem("lamp", 1000), "");
}

/// Events of networks arrive.
TEST_F(AnnouncePlaces, WhoHasNoPlaceIsAnsweredNevertheless) {
  const control::Channels before = subscribe("lamp", 0);
  for (std::size_t i = 0; i < 16; ++i) ASSERT_EQ(problem("lamp", 1000), "");
  const control::Channels answer = subscribe("lamp", 1000);
  ASSERT_NE(answer.local_problem, "");
  EXPECT_EQ(answer.endpoints, before.endpoints);
  ASSERT_EQ(answer.channels.size(), 1U);
  EXPECT_TRUE(answer.channels[0].granted);
  ASSERT_FALSE(answer.channels[0].problems.empty());
  EXPECT_EQ(answer.channels[0].problems[0], "its events do not arrive: " + answer.local_problem);
  EXPECT_EQ(receivers(), 17U);
}

TEST_F(AnnouncePlaces, ChangesOfAnAddressAreFew) {
  const auto state = [this](std::uint64_t address) {
    AnnounceRequest request{"c0", Role::subscriber, "lamp", {}};
    request.local = address_of(address);
    const auto answer = ask(request, {.pid = 7, .uid = 1000, .session = 5});
    return std::get<control::Channels>(answer.reply.body).local_problem;
  };
  std::uint64_t address = 0;
  for (std::uint64_t n = 0; n <= LocalEnds::kChangesAtOnce; ++n) EXPECT_EQ(state(++address), "");
  const std::string too_often =
      "its address for c0 was changed 4 times in a few seconds, and may be once a second";
  EXPECT_EQ(state(address + 1), too_often);
  EXPECT_EQ(state(address), "") << "it is the former one";
  bench_.clock.monotonic += LocalEnds::kChange;
  EXPECT_EQ(state(++address), "");
  EXPECT_EQ(state(address + 1), too_often);
}

TEST_F(AnnouncePlaces, ChangesThatFollowEachOtherAreReportedAsOne) {
  const auto reports = [this] {
    return std::ranges::count(bench_.published, "local", &control::Event::kind);
  };
  for (int i = 0; i < 10; ++i) ASSERT_EQ(problem("lamp", 1000), "");
  EXPECT_EQ(reports(), 1) << "the first one at once";
  const auto due = bench_.daemon().due();
  ASSERT_TRUE(due);
  EXPECT_EQ(*due, bench_.clock.monotonic + LocalEnds::kReport);
  bench_.clock.monotonic = *due - 1;
  bench_.act();
  EXPECT_EQ(reports(), 1);
  bench_.clock.monotonic = *due;
  bench_.act();
  EXPECT_EQ(reports(), 2) << "the others together";
  bench_.clock.monotonic += LocalEnds::kReport;
  bench_.act();
  EXPECT_EQ(reports(), 2) << "nothing has changed since";
  EXPECT_FALSE(bench_.daemon().due());
  bench_.daemon().session_closed(1);
  EXPECT_EQ(reports(), 3);
  EXPECT_EQ(bench_.published.back().channel, "c0");
}

/// The Jitter of a publisher is its own: more of it is worse.
TEST_F(Announce, APublisherWithMoreJitterThanIsStatedIsRefused) {
  bench_.system.publishers[0].attributes.set(Attribute::jitter, kMs);
  reload();
  EXPECT_EQ(stating(Role::publisher, "Jitter", kMs), "");
  EXPECT_NE(stating(Role::publisher, "Jitter", 2 * kMs), "");
}

}  // namespace
}  // namespace mlcca::test
