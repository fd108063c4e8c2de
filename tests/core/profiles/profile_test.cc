// SPDX-License-Identifier: BSD-2-Clause
// Identifiers that a description means, on each profile: of the gate, of the analysis, in frames.
#include "core/profiles/profile.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/can/of_system.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/model/medium.hpp"
#include "core/model/text.hpp"
#include "tests/support/source_tree.hpp"

namespace mlcca::core {
namespace {

Network on(Profile profile) {
  Network n;
  n.profile = profile;
  return n;
}
Binding named(std::uint32_t id, bool extended = true) {
  Binding b;
  b.id = id;
  b.extended = extended;
  return b;
}
Publisher sender(std::optional<std::uint8_t> node = {}) {
  Publisher p;
  p.node = node;
  return p;
}

TEST(Profiles, HaveAnElementOfTheirOwn) {
  for (std::size_t i = 0; i < kProfileCount; ++i) {
    const ProfileTraits& traits = traits_of(static_cast<Profile>(i));
    const auto word = traits.element.substr(traits.element.find(' ') + 1);
    EXPECT_EQ(profile_with_element(word), &traits) << word;
  }
  EXPECT_EQ(profile_with_element("Network"), nullptr);
}

TEST(Profiles, AreNamedByWhatTheyHave) {
  EXPECT_EQ(profiles_with([](const auto& p) { return p.remote_frames; }), "raw and canopen");
  EXPECT_EQ(profiles_with([](const auto& p) { return p.last != 0; }, " or "),
            "raw, famouso, j1939, cyphal or canopen");
  EXPECT_EQ(for_profiles_with([](const auto& p) { return p.xl; }), "profile raw");
  EXPECT_EQ(for_profiles_with([](const auto& p) { return p.last_node >= 0; }),
            "profiles famouso, j1939 and cyphal");
  EXPECT_EQ(elements_with([](const auto& p) { return p.has_number_priority; }),
            "a PGN and a SubjectID");
}

TEST(Profiles, CarryDatagramsOnlyWhereTheyHaveSome) {
  Network network = on(Profile::famouso);
  EXPECT_FALSE(network.carries_subjects()) << "a CAN network";
  network.kind = NetworkKind::mesh;
  EXPECT_TRUE(network.carries_subjects());
  network.profile = Profile::j1939;
  EXPECT_FALSE(network.carries_subjects());
}

TEST(FrameIdentity, OfJ1939HasPriorityGroupAndSource) {
  // EEC1, PGN 61444, priority 3, from the engine (0).
  auto eec1 = named(61444);
  eec1.priority = 3;
  const auto identity = identity_of(sender(0), on(Profile::j1939), eec1, false);
  EXPECT_EQ(identity->id, kExtendedFlag | 0x0cf00400U);
  EXPECT_EQ(identity->mask, kExtendedFlag | kExtendedBits);
}

TEST(FrameIdentity, OfJ1939LeavesOpenWhatIsNotStated) {
  auto to_one = named(0xef00);
  to_one.destination = 0x21;
  const auto one = identity_of(sender(0x80), on(Profile::j1939), to_one, false);
  EXPECT_EQ(one->id, kExtendedFlag | 0x00ef2180U);
  EXPECT_EQ(one->mask, kExtendedFlag | 0x03ffffffU) << "any priority";
  const auto any = identity_of(sender(0x80), on(Profile::j1939), named(0xef00), false);
  EXPECT_EQ(any->mask, kExtendedFlag | 0x03ff00ffU) << "any destination, too";
  const auto all = identity_of(sender(0x80), on(Profile::j1939), named(0xf000), false);
  EXPECT_EQ(all->mask, kExtendedFlag | 0x03ffffffU) << "PDU2 has none";
}

TEST(FrameIdentity, OfCyphalHasNoServiceAndNoAnonymousSender) {
  auto heartbeat = named(7509);
  heartbeat.priority = 4;
  const auto identity = identity_of(sender(42), on(Profile::cyphal), heartbeat, false);
  EXPECT_EQ(0x107d552aU & identity->mask, identity->id & kExtendedBits);
  EXPECT_NE(0x117d552aU & identity->mask, identity->id & kExtendedBits) << "anonymous";
  EXPECT_NE(0x127d552aU & identity->mask, identity->id & kExtendedBits) << "service";
}

TEST(FrameIdentity, OfAMaskedIdentifierIsItsRange) {
  auto range = named(0x120, false);
  range.mask = 0x7f0;
  const auto identity = identity_of(sender(), on(Profile::raw), range, false);
  EXPECT_EQ(identity->id, 0x120U);
  EXPECT_EQ(identity->mask, kExtendedFlag | 0x1ffffff0U);
}

TEST(FrameIdentity, NeedsANodeOfTheProfile) {
  EXPECT_FALSE(identity_of(sender(), on(Profile::j1939), named(1), false));
  EXPECT_TRUE(identity_of(sender(253), on(Profile::j1939), named(1), false));
  EXPECT_FALSE(identity_of(sender(254), on(Profile::j1939), named(1), false));
  EXPECT_TRUE(identity_of(sender(127), on(Profile::cyphal), named(1), false));
  EXPECT_FALSE(identity_of(sender(128), on(Profile::cyphal), named(1), false));
  EXPECT_FALSE(identity_of(sender(127), on(Profile::famouso), named(0x64), false));
  EXPECT_TRUE(identity_of(sender(), on(Profile::canopen), named(0x181, false), false));
  EXPECT_FALSE(identity_of(sender(1), on(Profile::none), named(1), false));
}

TEST(FrameIdentity, ThatLeavesBitsOpenDisturbsWithTheFirstAndSuffersWithTheLast) {
  const auto network = on(Profile::j1939);
  const auto open = can::identifier_of(sender(0), network, named(61444), false);
  EXPECT_EQ(open->id, 0x00f00400U);
  EXPECT_EQ(open->last, 0x1cf00400U);
  auto stated = named(61444);
  stated.priority = 3;
  const auto fixed = can::identifier_of(sender(0), network, stated, false);
  EXPECT_EQ(fixed->id, fixed->last);
}

std::size_t problems_of(Profile profile, const Binding& b) {
  return traits_of(profile).problems(b).size();
}

TEST(Problems, OfANumberAreThatItIsNoneOfTheProfile) {
  EXPECT_EQ(problems_of(Profile::famouso, named(0x63)), 1U);
  EXPECT_EQ(problems_of(Profile::famouso, named(0x64)), 0U);
  EXPECT_EQ(problems_of(Profile::famouso, named(0x3fff)), 0U);
  EXPECT_EQ(problems_of(Profile::famouso, named(0x4000)), 1U);
  EXPECT_EQ(problems_of(Profile::cyphal, named(8191)), 0U);
  EXPECT_EQ(problems_of(Profile::cyphal, named(8192)), 1U);
  EXPECT_EQ(problems_of(Profile::canopen, named(0x7ff, false)), 0U);
  EXPECT_EQ(problems_of(Profile::canopen, named(0x800, false)), 1U);
  EXPECT_EQ(problems_of(Profile::raw, named(0x7ff, false)), 0U);
  EXPECT_EQ(problems_of(Profile::raw, named(0x800, false)), 1U);
  EXPECT_EQ(problems_of(Profile::raw, named(0x1fffffff)), 0U);
  EXPECT_EQ(problems_of(Profile::raw, named(0x20000000)), 1U);
}

TEST(Problems, OfAnXlFrameAreThatItHasAPriorityOf11Bits) {
  auto b = named(0x100, false);
  b.format = FrameFormat::xl;
  EXPECT_EQ(problems_of(Profile::raw, b), 0U);
  b.extended = true;
  EXPECT_EQ(problems_of(Profile::raw, b), 1U);
}

TEST(Problems, OfAMaskAreThatItIsEmptyOrLeavesBitsOfTheIdentifierOpen) {
  auto b = named(0x120, false);
  b.mask = 0x7f0;
  EXPECT_EQ(problems_of(Profile::raw, b), 0U);
  b.id = 0x121;
  EXPECT_EQ(problems_of(Profile::raw, b), 1U);
  b.mask = 0;
  EXPECT_EQ(problems_of(Profile::raw, b), 1U);
}

TEST(Problems, OfAPgnAreADestinationInItAndOneThatItCannotHave) {
  EXPECT_EQ(problems_of(Profile::j1939, named(0x3ffff)), 0U);
  EXPECT_EQ(problems_of(Profile::j1939, named(0x40000)), 1U);
  const auto to_one = traits_of(Profile::j1939).problems(named(0xef21));
  ASSERT_EQ(to_one.size(), 1U);
  EXPECT_TRUE(to_one[0].contains("write 0xef00, with destination=\"0x21\"")) << to_one[0];
  EXPECT_EQ(problems_of(Profile::j1939, named(0xef00)), 0U);
  EXPECT_EQ(problems_of(Profile::j1939, named(0xf001)), 0U) << "PDU2 has its low byte";
  auto destined = named(0xef00);
  destined.destination = 0x21;
  EXPECT_EQ(problems_of(Profile::j1939, destined), 0U);
  destined.id = 0xf000;
  EXPECT_EQ(problems_of(Profile::j1939, destined), 1U);
  EXPECT_EQ(traits_of(Profile::j1939).unlisted_problem(named(0xef00)), "");
  EXPECT_NE(traits_of(Profile::j1939).unlisted_problem(named(0xef21)), "");
  EXPECT_EQ(traits_of(Profile::j1939).unlisted_problem(named(0xf021)), "");
}

TEST(Senders, AreToldApartByWhatFramesOrTheKernelSayOfThem) {
  System system;
  system.networks = {on(Profile::j1939), on(Profile::raw), on(Profile::none)};
  Publisher p = sender(5);
  p.uid = 1000;
  p.place = {Place::Kind::gateway, 0};
  ASSERT_TRUE(sender_of(system, p));
  EXPECT_EQ(sender_of(system, p)->uid, 1000U);
  EXPECT_EQ(sender_of(system, p)->node, 5);
  p.uid.reset();
  EXPECT_FALSE(sender_of(system, p)) << "a program without a user";
  p.place = {Place::Kind::network, 0};
  ASSERT_TRUE(sender_of(system, p));
  EXPECT_EQ(sender_of(system, p)->node, 5);
  p.place.index = 1;
  ASSERT_TRUE(sender_of(system, p));
  EXPECT_EQ(sender_of(system, p)->node, std::nullopt) << "no raw frame names a node";
  p.place.index = 2;
  EXPECT_FALSE(sender_of(system, p)) << "no gate";
  p.place.index = 0;
  p.node.reset();
  EXPECT_FALSE(sender_of(system, p));
}

TEST(Clash, IsAFrameThatCouldBeBoth) {
  auto a = named(0x120, false);
  a.mask = 0x7f0;
  EXPECT_TRUE(clash(Profile::raw, a, named(0x12f, false)));
  EXPECT_FALSE(clash(Profile::raw, a, named(0x130, false)));
  EXPECT_FALSE(clash(Profile::raw, a, named(0x12f, true)));
  auto one = named(0xef00);
  one.destination = 1;
  auto two = one;
  two.destination = 2;
  EXPECT_FALSE(clash(Profile::j1939, one, two));
  EXPECT_TRUE(clash(Profile::j1939, one, named(0xef00)));
}

TEST(CyphalTransfer, OfOneFrameHasATailAndOfSeveralACrc) {
  const auto network = on(Profile::cyphal);
  const auto b = named(1);
  EXPECT_EQ(frames_per_event(network, &b, 7), 1U);
  EXPECT_EQ(frames_per_event(network, &b, 8), 2U);
  EXPECT_EQ(frames_per_event(network, &b, 12), 2U);
  EXPECT_EQ(frames_per_event(network, &b, 13), 3U);
  EXPECT_EQ(frame_bytes(network, b, 0), 1U);
  EXPECT_EQ(frame_bytes(network, b, 7), 8U);
  EXPECT_EQ(event_bytes(network, b), 28670U);
  EXPECT_EQ(frames_per_event(network, &b, 28670), kMaxFrames);
}

TEST(FrameBytes, OfFdAreSizesThatExist) {
  auto b = named(0x123, false);
  b.format = FrameFormat::fd;
  const auto network = on(Profile::raw);
  for (const auto& [bytes, size] : {std::pair{0U, 0U}, {8U, 8U}, {9U, 12U}, {33U, 48U}, {64U, 64U}})
    EXPECT_EQ(frame_bytes(network, b, bytes), size);
  b.format = FrameFormat::xl;
  EXPECT_EQ(frame_bytes(network, b, 9), 9U);
  EXPECT_EQ(event_bytes(network, b), 2048U);
}

// --- control traffic -----------------------------------------------------------------------------

System bus_of(Profile profile) {
  System s;
  s.networks.push_back(on(profile));
  s.gateways.emplace_back().ports.emplace_back();
  return s;
}

std::size_t passing(const GateState& rules) {
  return static_cast<std::size_t>(std::ranges::count_if(rules, &GateRule::pass));
}

TEST(ControlTraffic, PassesBothWaysAtItsOwnRate) {
  const auto rules = control_rules(bus_of(Profile::canopen), 0);
  ASSERT_EQ(rules.size(), 10U);
  EXPECT_EQ(passing(rules), 10U);
  for (const auto& rule : rules) {
    EXPECT_TRUE(rule.policing.any());
    EXPECT_EQ(rule.entry.subject, kControlSubject);
    EXPECT_FALSE(rule.entry.source_port);
  }
  EXPECT_TRUE(control_rules(bus_of(Profile::raw), 0).empty());
}

TEST(ControlTraffic, ThatCarriesAnythingPassesOnlyWhereItIsNamed) {
  auto s = bus_of(Profile::j1939);
  const auto kinds = control_kinds(Profile::j1939);
  EXPECT_EQ(passing(control_rules(s, 0)), 6U) << "claim, request, acknowledgement, in and out";
  s.networks[0].control.kinds = (1U << kinds.size()) - 1;
  EXPECT_EQ(passing(control_rules(s, 0)), control_rules(s, 0).size());
}

struct Control {
  Profile profile;
  std::uint32_t can_id;
  const char* kind;  ///< nullptr: it is no control traffic
  std::uint16_t bytes = 8;
};

/// As they are on a bus.
TEST(ControlTraffic, IsKnownByItsIdentifierAndLength) {
  constexpr std::uint32_t extended = kExtendedFlag;
  const std::vector<Control> all = {
      {Profile::famouso, extended | 0x1f400000U | 5U << 14U, "configuration"},
      {Profile::famouso, extended | 0x1f7fc000U, "configuration"},
      {Profile::famouso, extended | 0x1f400001U | 5U << 14U, "configuration", 0},
      {Profile::famouso, extended | 0x1f400002U | 5U << 14U, "binding"},
      {Profile::famouso, extended | 0x1f5fc004U, "binding"},
      {Profile::famouso, extended | 0x1f400004U | 5U << 14U, nullptr},
      {Profile::famouso, extended | 0x1f400003U | 5U << 14U, nullptr},
      {Profile::famouso, extended | 0x1f000000U | 5U << 14U, nullptr},
      {Profile::j1939, extended | 0x18eefffeU, "address-claim"},
      {Profile::j1939, extended | 0x18ee21feU, nullptr},
      {Profile::j1939, extended | 0x18ea2105U, "request"},
      {Profile::j1939, extended | 0x00eaff05U, "request"},
      {Profile::j1939, extended | 0x19ea2105U, nullptr},
      {Profile::j1939, extended | 0x18e8ff05U, "acknowledgement"},
      {Profile::j1939, extended | 0x18ec2105U, "transport"},
      {Profile::j1939, extended | 0x18eb2105U, "transport"},
      {Profile::j1939, extended | 0x18c82105U, "extended-transport"},
      {Profile::j1939, extended | 0x18c72105U, "extended-transport"},
      {Profile::j1939, extended | 0x18ef2105U, nullptr},
      {Profile::cyphal, extended | 0x107d552aU, "heartbeat"},
      {Profile::cyphal, extended | 0x101d552aU, "heartbeat"},
      {Profile::cyphal, extended | 0x117d552aU, nullptr},
      {Profile::cyphal, extended | 0x107fe52aU, "allocation", 64},
      {Profile::cyphal, extended | 0x117fe5aaU, nullptr},
      {Profile::cyphal, extended | 0x117fe62aU, "allocation"},
      {Profile::cyphal, extended | 0x107fe72aU, nullptr},
      {Profile::canopen, 0x000, "nmt", 2},
      {Profile::canopen, 0x001, nullptr},
      {Profile::canopen, 0x080, "sync", 1},
      {Profile::canopen, 0x081, "emergency"},
      {Profile::canopen, 0x0ff, "emergency"},
      {Profile::canopen, 0x100, "time", 6},
      {Profile::canopen, 0x101, nullptr},
      {Profile::canopen, 0x701, "error-control", 1},
      {Profile::canopen, 0x77f, "error-control", 1},
      {Profile::canopen, 0x780, nullptr},
      {Profile::canopen, 0x602, nullptr},
      {Profile::canopen, extended | 0x100, nullptr}};
  for (const Control& c : all) {
    const ControlKind* kind = nullptr;
    const ControlFrames* frames = nullptr;
    for (const ControlKind& k : control_kinds(c.profile))
      for (const ControlFrames& f : k.frames)
        if (kind == nullptr && !k.is_tagged &&
            ((c.can_id ^ f.identity.id) & f.identity.mask) == 0) {
          kind = &k;
          frames = &f;
        }
    ASSERT_EQ(kind != nullptr, c.kind != nullptr) << to_text(c.profile) << ' ' << c.can_id;
    if (kind == nullptr) continue;
    EXPECT_EQ(kind->name, c.kind) << to_text(c.profile) << ' ' << c.can_id;
    EXPECT_EQ(frames->max_length, c.bytes) << to_text(c.profile) << ' ' << c.can_id;
  }
}

/// Rows of the table of docs/reference/can-profiles.md: "profile kind rate burst", carriers "off".
std::vector<std::string> rows_of_reference() {
  std::ifstream page(mlcca::testing::source_tree() / "docs/reference/can-profiles.md");
  std::vector<std::string> rows;
  std::string profile;
  for (std::string line; std::getline(page, line);) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, '|');) {
      std::erase_if(cell, [](char c) { return c == ' ' || c == '`'; });
      cells.push_back(cell);
    }
    if (cells.size() != 6 || cells[4].find_first_not_of("0123456789") != std::string::npos)
      continue;
    if (!cells[1].empty()) profile = cells[1];
    rows.push_back(profile + " " + cells[2] + " " + cells[4] + " " + cells[5] +
                   (cells[3].ends_with("off") ? " off" : ""));
  }
  return rows;
}

TEST(ControlTraffic, HasTheRatesThatTheReferenceStates) {
  std::vector<std::string> rows;
  for (const Profile profile :
       {Profile::famouso, Profile::j1939, Profile::cyphal, Profile::canopen})
    for (const ControlKind& kind : control_kinds(profile))
      rows.push_back(std::string(to_text(profile)) + " " + std::string(kind.name) + " " +
                     std::to_string(kind.rate) + " " + std::to_string(kind.burst) +
                     (kind.is_carrier ? " off" : ""));
  EXPECT_EQ(rows, rows_of_reference());
  // The limit of a slot: so many at once in addition to one.
  const auto rules = control_rules(bus_of(Profile::canopen), 0);
  const auto nmt = std::ranges::find_if(rules, [](const GateRule& r) { return r.entry.id == 0; });
  ASSERT_NE(nmt, rules.end());
  EXPECT_EQ(nmt->policing.per_frame, 20'000'000U);
  EXPECT_EQ(nmt->policing.tolerance, 10 * 20'000'000U);
}

/// Frames of a carrier may come from the kernel itself, whose protocol makes them.
TEST(ControlTraffic, ThatCarriesAnythingIsSentByTheKernelToo) {
  auto s = bus_of(Profile::j1939);
  const auto kinds = control_kinds(Profile::j1939);
  s.networks[0].control.kinds = (1U << kinds.size()) - 1;
  s.gateways[0].ports[0].control_uid = 7;
  std::size_t frames = 0;
  std::size_t of_carriers = 0;
  for (const ControlKind& kind : kinds) {
    frames += kind.frames.size();
    of_carriers += kind.is_carrier ? kind.frames.size() : 0;
  }
  ASSERT_GT(of_carriers, 0U);
  std::size_t in = 0;
  std::size_t from_program = 0;
  std::size_t from_kernel = 0;
  for (const GateRule& rule : control_rules(s, 0)) {
    EXPECT_FALSE(rule.policing.counts_only);
    if (rule.entry.direction == Direction::ingress) {
      ++in;
      EXPECT_FALSE(rule.entry.from_kernel);
    } else if (rule.entry.from_kernel) {
      ++from_kernel;
      EXPECT_EQ(rule.entry.uid, 0U);
    } else {
      ++from_program;
      EXPECT_EQ(rule.entry.uid, 7U);
    }
  }
  EXPECT_EQ(in, frames);
  EXPECT_EQ(from_program, frames);
  EXPECT_EQ(from_kernel, of_carriers);
}

TEST(ControlTraffic, ThatIsTooMuchPassesWhereExcessDoes) {
  auto s = bus_of(Profile::canopen);
  s.gateways[0].ports[0].excess = Excess::pass;
  for (const GateRule& rule : control_rules(s, 0)) EXPECT_TRUE(rule.policing.counts_only);
}

TEST(ControlTraffic, OfAPortGoesBeforeThatOfItsNetwork) {
  auto s = bus_of(Profile::canopen);
  s.networks[0].control = {.kinds = 0, .rate = 10};
  EXPECT_EQ(passing(control_rules(s, 0)), 0U);
  s.gateways[0].ports[0].control.kinds = 2;  // sync
  const auto rules = control_rules(s, 0);
  EXPECT_EQ(passing(rules), 2U);
  for (const auto& rule : rules) EXPECT_EQ(rule.policing.per_frame, 100'000'000U);
  s.gateways[0].ports[0].control.rate = 1;
  EXPECT_EQ(control_rules(s, 0)[0].policing.per_frame, 1'000'000'000U);
}

TEST(ControlTraffic, ThatIsBoundIsTheChannels) {
  const auto without = [](Profile profile, std::uint32_t id, bool extended) {
    auto s = bus_of(profile);
    const auto before = control_rules(s, 0).size();
    s.networks[0].bindings.push_back(named(id, extended));
    return before - control_rules(s, 0).size();
  };
  EXPECT_EQ(without(Profile::canopen, 0x080, false), 2U) << "SYNC, in and out";
  EXPECT_EQ(without(Profile::canopen, 0x181, false), 0U);
  EXPECT_EQ(without(Profile::cyphal, 7509, true), 2U);
  EXPECT_EQ(without(Profile::j1939, 0xea00, true), 2U);
  EXPECT_EQ(without(Profile::famouso, 0x64, true), 0U);
}

TEST(ControlTraffic, OfSubscriptionsHasATagOnceThatIsKnown) {
  auto s = bus_of(Profile::famouso);
  const auto subscriptions = [&s] {
    std::vector<GateRule> found;
    for (const auto& rule : control_rules(s, 0))
      if (control_kind_of(Profile::famouso, rule.entry.id, rule.entry.mask) == "subscribe")
        found.push_back(rule);
    return found;
  };
  EXPECT_TRUE(subscriptions().empty());
  s.networks[0].subscribe_tag = 0x3fff;
  const auto rules = subscriptions();
  ASSERT_EQ(rules.size(), 2U);
  for (const auto& rule : rules) {
    EXPECT_EQ(rule.entry.id, kExtendedFlag | 0x1f403fffU);
    EXPECT_EQ(rule.entry.mask, kExtendedFlag | kRemoteFlag | 0x1fe03fffU) << "any node";
    EXPECT_EQ(rule.entry.max_length, 8U);
    EXPECT_TRUE(rule.pass);
  }
  s.networks[0].control.kinds = 3;  // configuration and binding
  EXPECT_FALSE(subscriptions().at(0).pass);
  s.networks[0].bindings.push_back(named(0x3fff));
  EXPECT_TRUE(subscriptions().empty()) << "the tag is a channel's";
  s.networks[0].bindings.clear();
  s.channels.emplace_back().subject = kSubscribeSubject;
  EXPECT_TRUE(subscriptions().empty()) << "the subject is a channel's";
}

TEST(ControlTraffic, OnlyTheKernelSendsWithoutAUser) {
  for (const auto profile : {Profile::famouso, Profile::j1939, Profile::cyphal, Profile::canopen})
    for (const auto& rule : control_rules(bus_of(profile), 0)) {
      const auto kind = control_kind_of(profile, rule.entry.id, rule.entry.mask);
      EXPECT_FALSE(kind.empty());
      EXPECT_TRUE(!rule.entry.from_kernel || kind.ends_with("transport")) << kind;
    }
}

}  // namespace
}  // namespace mlcca::core
