// SPDX-License-Identifier: BSD-2-Clause
// The gate on real devices of a private network namespace, with real frames, sockets and
// forwarding.
#include <bpf/bpf.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <filesystem>
#include <numeric>
#include <thread>

#include "daemon/enforce/gate.hpp"
#include "daemon/enforce/grace_period.hpp"
#include "daemon/enforce/mapped.hpp"
#include "enforce/sandbox.hpp"

namespace mlcca::enforce {
namespace {

using test::Bus;
using test::Bytes;
using test::forward;
using test::frame;
using test::Program;

constexpr std::uint32_t kMask = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK;

SlotSpec slot(Direction direction, std::uint32_t id) {
  SlotSpec s;
  s.direction = direction;
  s.pass = true;
  s.id = id;
  s.mask = kMask;
  s.subject = id;
  return s;
}
SlotSpec in(std::uint32_t id) { return slot(Direction::ingress, id); }
SlotSpec out(std::uint32_t id, std::uint32_t source) {
  auto s = slot(Direction::egress, id);
  s.source = source;
  return s;
}
SlotSpec user(SlotSpec s, std::uint32_t uid) {
  s.uid = uid;
  return s;
}

std::uint64_t seen(const Gate& gate) {
  const auto reasons = gate.reasons(Direction::ingress);
  return std::accumulate(reasons.begin(), reasons.end(), std::uint64_t{0});
}

/// Frames from the bus as fast as they go, from another thread.
class Traffic {
 public:
  Traffic(const Bus& bus, const Gate& gate, std::vector<std::uint32_t> ids)
      : thread_([this, &bus, &gate, ids = std::move(ids)] {
          const auto before = seen(gate);
          while (!done_) {
            for (const auto id : ids) bus.inject(frame(id));
            ++rounds_;
            // The kernel's queue is finite: a frame lost there was not lost by the gate.
            while (before + rounds_ * ids.size() - seen(gate) > 200) std::this_thread::yield();
          }
        }) {}
  Traffic(const Traffic&) = delete;
  Traffic& operator=(const Traffic&) = delete;
  ~Traffic() { stop(); }

  /// How often each identifier was sent.
  std::uint64_t stop() {
    done_ = true;
    if (thread_.joinable()) thread_.join();
    return rounds_;
  }

 private:
  std::atomic<bool> done_ = false;
  std::uint64_t rounds_ = 0;
  std::thread thread_;
};

class Attach : public testing::Test {
 protected:
  Attach() : root_(test::new_bpf_root()), control_(create(root_)) { control_.open(); }

  static Control create(const std::string& root) {
    auto control = Control::create(root);
    EXPECT_TRUE(control) << control.error().text;
    return std::move(*control);
  }
  Gate attach(const Bus& bus, core::Profile profile = core::Profile::raw) {
    GateConfig config;
    config.ifindex = bus.ifindex();
    config.name = bus.name();
    config.profile = profile;
    auto gate = Gate::attach(config, control_);
    EXPECT_TRUE(gate) << gate.error().text;
    return std::move(*gate);
  }
  static void admit(Gate& gate, const std::vector<SlotSpec>& specs) {
    SlotChanges changes;
    changes.add = specs;
    const auto applied = gate.apply(changes);
    ASSERT_TRUE(applied) << applied.error().text;
  }
  /// The number once it is what it should be; else, after a generous time, what it is.
  static std::uint64_t eventually(std::uint64_t wanted, auto number) {
    for (int i = 0; i < 10'000 && number() != wanted; ++i) poll(nullptr, 0, 1);
    return number();
  }
  static void expect_passed(const Gate& gate, const SlotSpec& spec, std::uint64_t frames) {
    EXPECT_EQ(eventually(frames, [&] { return gate.counters(spec).value().passed; }), frames);
  }
  static void expect_dropped(const Gate& gate, const SlotSpec& spec, std::uint64_t frames) {
    EXPECT_EQ(eventually(frames, [&] { return gate.counters(spec).value().dropped; }), frames);
  }
  static void expect_ingress(const Gate& gate, gate_reason reason, std::uint64_t frames) {
    const auto number = [&] { return gate.reasons(Direction::ingress).at(reason); };
    EXPECT_EQ(eventually(frames, number), frames) << reason_text(reason);
  }
  static void expect_egress(const Gate& gate, gate_reason reason, std::uint64_t frames) {
    const auto number = [&] { return gate.reasons(Direction::egress).at(reason); };
    EXPECT_EQ(eventually(frames, number), frames) << reason_text(reason);
  }
  [[nodiscard]] std::string pins(const Bus& bus) const {
    return control_.directory() + "/if" + std::to_string(bus.ifindex());
  }

  std::string root_;
  Control control_;
};

TEST_F(Attach, NewGateIsInPlaceAndEmpty) {
  const Bus bus("bus0");
  const auto gate = attach(bus);
  EXPECT_TRUE(gate.attached().value());
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.present().empty());
  EXPECT_EQ(gate.name(), "bus0");
  EXPECT_EQ(gate.ifindex(), bus.ifindex());
}

TEST_F(Attach, AdmittedFramePassesIngressAndNoOther) {
  const Bus bus("bus0");
  const Program listener(bus);
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  bus.inject(frame(0x124));
  bus.inject(frame(0x123));
  EXPECT_EQ(listener.received(), frame(0x123)) << "the first that arrives is the admitted one";
  expect_ingress(gate, GATE_R_PASSED, 1);
  expect_ingress(gate, GATE_R_UNKNOWN, 1);
  ASSERT_EQ(gate.unknown().size(), 1U);
  EXPECT_EQ(gate.unknown().front().can_id, 0x124U);
}

TEST_F(Attach, BufferThatIsNoCanFrameIsMalformed) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  // 72 bytes are an FD frame only under the FD protocol.
  for (const std::size_t size : {1U, 4U, 8U, 15U, 17U, 71U, 72U, 73U, 2000U})
    bus.inject(Bytes(size));
  expect_ingress(gate, GATE_R_MALFORMED, 9);
}

TEST_F(Attach, ForwardedFrameLeavesWhereItsSourceIsGranted) {
  const Bus from("from");
  const Bus to("to");
  auto ingress = attach(from);
  auto egress = attach(to);
  forward(from, to);
  admit(ingress, {in(0x123), in(0x124)});
  admit(egress, {out(0x123, from.ifindex())});
  from.inject(frame(0x125));
  from.inject(frame(0x124));
  from.inject(frame(0x123));
  EXPECT_EQ(to.sent(), frame(0x123));
  expect_passed(egress, out(0x123, from.ifindex()), 1);
  expect_egress(egress, GATE_R_UNKNOWN, 1);  // 0x124; the other never came here
}

TEST_F(Attach, ThirdBusDoesNotReachTheNetwork) {
  const Bus from("from");
  const Bus third("third");
  const Bus to("to");
  auto ingress = attach(from);
  auto other = attach(third);
  auto egress = attach(to);
  forward(from, to);
  forward(third, to);
  admit(ingress, {in(0x123)});
  admit(other, {in(0x123)});
  admit(egress, {out(0x123, from.ifindex())});
  third.inject(frame(0x123));
  from.inject(frame(0x123));
  EXPECT_EQ(to.sent(), frame(0x123));
  expect_egress(egress, GATE_R_SOURCE, 1);
  expect_egress(egress, GATE_R_PASSED, 1);
}

TEST_F(Attach, BusWithoutAGateDoesNotReachTheNetwork) {
  const Bus from("from");
  const Bus to("to");
  test::add_clsact(from);
  forward(from, to);
  auto egress = attach(to);
  admit(egress, {out(0x123, from.ifindex())});
  from.inject(frame(0x123));
  expect_egress(egress, GATE_R_SOURCE, 1);
}

TEST_F(Attach, LocalProgramLeavesOnlyWhereItsUserIsGranted) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {user(out(0x123, 0), 1000), out(0x124, 0), out(0x125, 99)});
  const Program granted(bus, 1000);
  const Program other(bus, 1001);
  EXPECT_FALSE(other.send(frame(0x123)));
  EXPECT_TRUE(granted.send(frame(0x123)));
  EXPECT_EQ(bus.sent(), frame(0x123));
  EXPECT_TRUE(other.send(frame(0x124)));
  EXPECT_EQ(bus.sent(), frame(0x124));
  EXPECT_FALSE(granted.send(frame(0x125))) << "granted to forwarded frames only";
  expect_egress(gate, GATE_R_SOURCE, 2);
}

TEST_F(Attach, RestartFindsSlotsVerdictsAndCounts) {
  const Bus bus("bus0");
  auto refused = in(0x200);
  refused.pass = false;
  std::vector<SlotSpec> before;
  {
    auto gate = attach(bus);
    admit(gate, {in(0x123), refused});
    bus.inject(frame(0x123));
    before = gate.present();
  }
  bus.inject(frame(0x123));  // no daemon runs
  auto gate = attach(bus);
  EXPECT_TRUE(gate.reused());
  EXPECT_TRUE(gate.attached().value());
  EXPECT_EQ(gate.present(), before);
  expect_passed(gate, in(0x123), 2);
  bus.inject(frame(0x123));
  bus.inject(frame(0x200));
  expect_passed(gate, in(0x123), 3);
  expect_dropped(gate, refused, 1);
}

TEST_F(Attach, ReplacementUnderTrafficLosesAndLeaksNothing) {
  const Bus bus("bus0");
  auto first = attach(bus);
  admit(first, {in(0x123)});
  Traffic traffic(bus, first, {0x123, 0x124});
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(attach(bus).reused());
  const auto sent = traffic.stop();
  const auto gate = attach(bus);
  EXPECT_GT(sent, 1000U);
  expect_passed(gate, in(0x123), sent);
  expect_dropped(gate, in(0x123), 0);
  expect_ingress(gate, GATE_R_UNKNOWN, sent);
}

TEST_F(Attach, VerdictsFlipUnderTrafficAndEveryFrameIsCounted) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123), in(0x124)});
  Traffic traffic(bus, gate, {0x123, 0x124});
  SlotChanges close;
  SlotChanges open;
  close.close = open.open = {in(0x124)};
  for (int i = 0; i < 20'000; ++i) {
    ASSERT_TRUE(gate.apply(close));
    ASSERT_TRUE(gate.apply(open));
  }
  const auto sent = traffic.stop();
  expect_passed(gate, in(0x123), sent);
  EXPECT_EQ(eventually(2 * sent, [&] { return seen(gate); }), 2 * sent);
  const auto flipped = gate.counters(in(0x124)).value();
  EXPECT_EQ(flipped.passed + flipped.dropped, sent);
  EXPECT_EQ(flipped.bytes, 8 * flipped.passed);
}

TEST_F(Attach, SlotsComeAndGoUnderTrafficOfOthers) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  auto narrow = in(0x123);
  narrow.max_len = 4;
  admit(gate, {in(0x123)});
  Traffic traffic(bus, gate, {0x123});
  // Neighbours in the same chain, so that the program walks over slots that go.
  SlotChanges add;
  SlotChanges remove;
  add.add = remove.remove = {narrow};
  for (int i = 0; i < 20'000; ++i) {
    ASSERT_TRUE(gate.apply(add));
    ASSERT_TRUE(gate.apply(remove));
  }
  expect_passed(gate, in(0x123), traffic.stop());
}

TEST_F(Attach, PinsOfAVanishedDeviceAreNotUsedForItsSuccessor) {
  constexpr std::uint32_t kIfindex = 4000;
  {
    const Bus bus("bus0", kIfindex);
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
  }
  ASSERT_TRUE(std::filesystem::exists(control_.directory() + "/if4000/table"));
  const Bus successor("bus0", kIfindex);
  const auto gate = attach(successor);
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.present().empty());
  successor.inject(frame(0x123));
  expect_ingress(gate, GATE_R_UNKNOWN, 1);
}

TEST_F(Attach, PinsOfVanishedDevicesAreRemovedAndOthersStay) {
  const Bus stays("stays");
  const auto gate = attach(stays);
  std::string gone;
  {
    const Bus vanishes("vanishes");
    attach(vanishes);
    gone = pins(vanishes);
  }
  ASSERT_TRUE(unpin_vanished(control_));
  EXPECT_FALSE(std::filesystem::exists(gone));
  EXPECT_TRUE(std::filesystem::exists(pins(stays) + "/table"));
  EXPECT_TRUE(std::filesystem::exists(control_.directory() + "/control"));
}

TEST_F(Attach, UnpinnedGateStaysInPlace) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  gate.unpin();
  EXPECT_FALSE(std::filesystem::exists(pins(bus)));
  EXPECT_TRUE(gate.attached().value());
}

TEST_F(Attach, ForeignFiltersAreLeftAlone) {
  const Bus bus("bus0");
  test::add_clsact(bus);
  test::add_foreign_filter(bus, 7, 1);
  test::add_foreign_filter(bus, GATE_TC_PRIORITY, 2);
  const auto other = test::filter_at(bus, true, 7, 1);
  const auto beside = test::filter_at(bus, true, GATE_TC_PRIORITY, 2);
  ASSERT_NE(other, 0U);
  ASSERT_NE(beside, 0U);
  attach(bus);
  const auto gate = attach(bus);
  EXPECT_TRUE(gate.attached().value());
  EXPECT_EQ(test::filter_at(bus, true, 7, 1), other);
  EXPECT_EQ(test::filter_at(bus, true, GATE_TC_PRIORITY, 2), beside);
}

TEST_F(Attach, RemovedClsactIsNoticedAndRepaired) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  test::remove_clsact(bus);
  EXPECT_FALSE(gate.attached().value());
  ASSERT_TRUE(gate.reattach());
  EXPECT_TRUE(gate.attached().value());
  bus.inject(frame(0x123));
  bus.inject(frame(0x124));
  expect_passed(gate, in(0x123), 1);
  expect_ingress(gate, GATE_R_UNKNOWN, 1);
}

TEST_F(Attach, OneRemovedFilterIsNoticedAndTheSlotsSurviveARestart) {
  for (const bool ingress : {true, false}) {
    const Bus bus("bus0");
    {
      auto gate = attach(bus);
      admit(gate, {in(0x123)});
      test::remove_our_filter(bus, ingress);
      EXPECT_FALSE(gate.attached().value());
    }
    const auto gate = attach(bus);
    EXPECT_TRUE(gate.reused());
    EXPECT_TRUE(gate.attached().value());
    EXPECT_EQ(gate.present(), std::vector{in(0x123)});
  }
}

TEST_F(Attach, FilterOfAnotherInOurPlaceIsNoticed) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  test::remove_our_filter(bus, true);
  test::add_foreign_filter(bus, GATE_TC_PRIORITY, GATE_TC_HANDLE);
  EXPECT_FALSE(gate.attached().value());
  ASSERT_TRUE(gate.reattach());
  EXPECT_TRUE(gate.attached().value());
}

TEST_F(Attach, CrashBetweenAttachingAndNamingKeepsTheSlots) {
  const Bus bus("bus0");
  {
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
  }
  // As left by a daemon that died there: the attached programs have their next names only.
  std::filesystem::rename(pins(bus) + "/egress", pins(bus) + "/egress_next");
  std::filesystem::rename(pins(bus) + "/ingress", pins(bus) + "/ingress_next");
  const auto gate = attach(bus);
  EXPECT_TRUE(gate.reused());
  EXPECT_EQ(gate.present(), std::vector{in(0x123)});
  EXPECT_TRUE(attach(bus).reused());
}

TEST_F(Attach, MapsOfAnotherGateUnderOurNamesAreNotUsed) {
  const Bus bus("bus0");
  const Bus other("other");
  attach(bus);
  auto gate = attach(other);
  admit(gate, {in(0x123)});
  std::filesystem::rename(pins(other) + "/table", pins(bus) + "/table");
  EXPECT_FALSE(attach(bus).reused());
}

TEST_F(Attach, AnotherProfileStartsWithoutSlots) {
  const Bus bus("bus0");
  {
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
  }
  const auto gate = attach(bus, core::Profile::famouso);
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.present().empty());
}

TEST_F(Attach, DamagedTableIsReplacedByAnEmptyOne) {
  const Bus bus("bus0");
  {
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
  }
  const Fd map(bpf_obj_get((pins(bus) + "/table").c_str()));
  {
    const Mapped<gate_table> table(map.get(), 1);
    table[0].head[GATE_INGRESS][5] = GATE_SLOTS;
  }
  const auto gate = attach(bus);
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.present().empty());
  EXPECT_TRUE(gate.attached().value());
}

TEST_F(Attach, OneWordClosesEveryGate) {
  const Bus a("a");
  const Bus b("b");
  auto gate_a = attach(a);
  auto gate_b = attach(b);
  admit(gate_a, {in(0x123)});
  admit(gate_b, {in(0x123)});
  control_.close_all();
  a.inject(frame(0x123));
  b.inject(frame(0x123));
  expect_ingress(gate_a, GATE_R_CLOSED, 1);
  expect_ingress(gate_b, GATE_R_CLOSED, 1);
  control_.open();
  a.inject(frame(0x123));
  expect_passed(gate_a, in(0x123), 1);
}

TEST_F(Attach, AuditLetsThroughWhatItCounts) {
  const Bus bus("bus0");
  const Program listener(bus);
  const auto gate = attach(bus);
  control_.set_mode(Mode::audit);
  bus.inject(frame(0x124));
  EXPECT_EQ(listener.received(), frame(0x124));
  expect_ingress(gate, GATE_R_UNKNOWN, 1);
}

TEST_F(Attach, DenyAllStopsEverythingAndKeepsTheGate) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  gate.deny_all();
  bus.inject(frame(0x123));
  expect_ingress(gate, GATE_R_DENIED, 1);
  EXPECT_EQ(gate.counters(in(0x123)).value().last_reason, GATE_R_DENIED);
  EXPECT_TRUE(gate.attached().value());
}

TEST_F(Attach, AbsentInterfaceIsAnErrorInWords) {
  GateConfig config;
  config.ifindex = 31337;
  config.name = "nowhere";
  const auto gate = Gate::attach(config, control_);
  ASSERT_FALSE(gate);
  EXPECT_NE(gate.error().text.find("gate of nowhere"), std::string::npos) << gate.error().text;
  EXPECT_NE(gate.error().text.find("No such device"), std::string::npos) << gate.error().text;
}

TEST_F(Attach, CountersOfAnAbsentSlotAreNone) {
  const Bus bus("bus0");
  EXPECT_FALSE(attach(bus).counters(in(0x123)));
}

TEST_F(Attach, ClosedInterfaceDropsAndIsClosedOnce) {
  const Bus bus("bus0");
  const Program local(bus);
  EXPECT_EQ(close_interface("bus0", root_).value(), Closing::closed);
  const auto ingress = test::filter_at(bus, true, GATE_TC_PRIORITY, GATE_TC_HANDLE);
  EXPECT_NE(ingress, 0U);
  EXPECT_FALSE(local.send(frame(0x123)));
  EXPECT_EQ(close_interface("bus0", root_).value(), Closing::was_gated);
  EXPECT_EQ(test::filter_at(bus, true, GATE_TC_PRIORITY, GATE_TC_HANDLE), ingress);
}

TEST_F(Attach, ClosingAGatedInterfaceChangesNothing) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  EXPECT_EQ(close_interface("bus0", root_).value(), Closing::was_gated);
  EXPECT_TRUE(gate.attached().value());
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
}

TEST_F(Attach, ClosingFillsTheSideThatIsOpenOnly) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  test::remove_our_filter(bus, false);
  EXPECT_EQ(close_interface("bus0", root_).value(), Closing::closed);
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
  EXPECT_FALSE(Program(bus).send(frame(0x123)));
}

TEST_F(Attach, DaemonTakesOverAClosedInterface) {
  const Bus bus("bus0");
  ASSERT_TRUE(close_interface("bus0", root_));
  auto gate = attach(bus);
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.attached().value());
  admit(gate, {in(0x123)});
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
}

TEST_F(Attach, ClosingAnAbsentInterfaceIsAnErrorInWords) {
  const auto closing = close_interface("nowhere", root_);
  ASSERT_FALSE(closing);
  EXPECT_NE(closing.error().text.find("close nowhere"), std::string::npos);
}

TEST(GracePeriod, BothWaysToItWork) {
  EXPECT_TRUE(wait_for_grace_period());
  EXPECT_TRUE(detail::wait_by_membarrier());
  EXPECT_TRUE(detail::wait_by_map_of_maps());
}

}  // namespace
}  // namespace mlcca::enforce
