// SPDX-License-Identifier: BSD-2-Clause
// Random slots, states and frames: the program and the plain rules must agree on every frame and
// on every counter.
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "daemon/gates/counters.hpp"
#include "tests/bpf/closed_gate.hpp"
#include "tests/bpf/oracle.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr int kRounds = 800;  // 4 million frames
constexpr int kFrames = 5000;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(engine_() % n); }
  bool chance(std::uint32_t one_in) { return below(one_in) == 0; }
  std::uint32_t of(std::initializer_list<std::uint32_t> values) {
    return *(values.begin() + below(static_cast<std::uint32_t>(values.size())));
  }

 private:
  std::mt19937 engine_;
};

/// Few values, so that frames and slots meet.
std::uint32_t identifier(Random& random, std::uint32_t profile) {
  switch (profile) {
    case GATE_PROFILE_FAMOUSO:
      return CAN_EFF_FLAG | random.of({0, 0x7d}) << 22 | random.below(2) << 21 |
             random.of({5, 6, 0x7f}) << 14 | random.of({0, 1, 0x64, 0x65, 0x3fff});
    case GATE_PROFILE_J1939:
      return CAN_EFF_FLAG | random.of({3, 6}) << 26 |
             random.of({0xee00, 0xeaff, 0xef21, 0xef22, 0xf004, 0xf005, 0x1f004, 0x3ffff}) << 8 |
             random.of({0, 0x21, 0xfe});
    case GATE_PROFILE_CYPHAL:
      return CAN_EFF_FLAG | random.of({0, 4}) << 26 | random.of({0, 0, 0, 1, 2}) << 24 |
             random.of({0, 0x600000, 0x800000}) | random.of({0, 7509, 8191}) << 8 |
             random.of({0, 42, 127, 128});
    default:
      break;
  }
  if (random.chance(2)) return random.of({0, 0x80, 0x81, 0x123, 0x124, 0x701, 0x7ff});
  return CAN_EFF_FLAG | random.of({0x123, 0x1abcdef, 0x1fffffff, 0x64});
}

/// Bits that a grant of the profile may leave open.
std::uint32_t open_bits(Random& random, std::uint32_t profile) {
  switch (profile) {
    case GATE_PROFILE_FAMOUSO:
      return random.of({0x1fc000, 0x200000, 0x1fc00000});
    case GATE_PROFILE_J1939:
      return random.of({0x1c000000, 0xff, 0xff00});
    case GATE_PROFILE_CYPHAL:
      return random.of({0x1c000000, 0x7f, 0x1000000, 0x600000});
    default:
      return random.of({1, 0x7f, 0x780, 0x1ffff800, 0x1fffffff});
  }
}

std::uint8_t byte(std::uint32_t v) { return static_cast<std::uint8_t>(v); }

SlotSpec random_slot(Random& random, std::uint32_t profile) {
  SlotSpec s;
  s.direction = random.chance(2) ? Direction::ingress : Direction::egress;
  s.pass = !random.chance(4);
  s.id = identifier(random, profile);
  s.mask = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_EFF_MASK;
  if (random.chance(4)) s.mask &= ~CAN_RTR_FLAG;
  if (random.chance(3)) s.mask &= ~open_bits(random, profile);
  s.id &= s.mask;
  s.max_len = static_cast<std::uint16_t>(random.of({0, 4, 8, 64, 2048}));
  s.formats = byte(random.of(
      {GATE_CLASSIC, GATE_FD, GATE_CLASSIC | GATE_FD, GATE_XL, GATE_CLASSIC | GATE_FD | GATE_XL}));
  s.source = random.of({0, kOther, 11, GATE_NO_SOURCE});
  s.subject = random.of({1, 1, 2});
  if (gate_has_origin(static_cast<std::uint32_t>(s.direction), s.source) != 0)
    s.origin = gate_origin(s.subject, random.of({1, 1, 2}));
  else
    s.uid = random.of({GATE_ANY_UID, 0, 1000});
  return s;
}

Bytes random_xl_frame(Random& random, std::uint32_t profile) {
  std::uint32_t id = identifier(random, profile) & CAN_SFF_MASK;
  if (random.chance(20)) id |= 1U << random.below(32);
  // 2 bytes make the least that BPF_PROG_TEST_RUN takes.
  auto bytes = xl_frame(id, random.of({2, 4, 5, 8, 64, 65, 2047, 2048}), random.of({0, 0, 16, 24}));
  if (random.chance(20)) bytes[4] ^= 0x80;
  if (random.chance(40)) bytes[random.below(32) % bytes.size()] = byte(random.below(256));
  if (random.chance(40)) bytes.resize(14 + random.below(2100));
  return bytes;
}

Bytes random_frame(Random& random, std::uint32_t profile, bool xl) {
  if (xl) return random_xl_frame(random, profile);
  std::uint32_t id = identifier(random, profile);
  if (random.chance(8)) id |= CAN_RTR_FLAG;
  if (random.chance(30)) id |= CAN_ERR_FLAG;
  if (random.chance(30)) id ^= 1U << random.below(32);
  const bool fd = random.chance(3);
  auto bytes = frame(id, random.below(fd ? 65 : 9), fd);
  if (random.chance(40)) bytes[4] = byte(random.below(256));
  if (random.chance(60)) bytes.resize(14 + random.below(80));
  if (random.chance(6)) bytes.insert(bytes.begin(), random.of({16, 24, 32, 40}), 0x5a);
  return bytes;
}

Sender random_sender(Random& random) {
  Sender s;
  s.local = random.chance(3);
  s.xl = random.chance(4);
  const auto from = [](std::uint32_t ifindex, std::uint64_t subject, std::uint64_t publisher = 1) {
    return gate_ingress_token(kToken, ifindex, gate_origin(subject, publisher));
  };
  s.mark =
      random.of({0, from(kOther, 1), from(kOther, 1, 2), from(kOther, 2), from(11, 1), from(11, 2),
                 from(11, 2, 2), from(kIfindex, 1), kToken, ~kToken, kReportedBefore, 7});
  s.ingress_ifindex = random.of({0, kOther, kOther, 11, kIfindex});
  return s;
}

struct Counted {
  std::uint64_t passed = 0;
  std::uint64_t dropped = 0;
  std::uint64_t bytes = 0;
  std::uint64_t would_drop = 0;
  core::FrameReason last_reason = core::FrameReason::passed;
};

class Round {
 public:
  Round(unsigned seed, const GateOptions& options)
      : random_(seed), gate_(LoadedGate::with(options)), own_(2) {
    world_.profile = options.profile;
    world_.echo_by_mark = options.echo_by_mark;
    const auto slots = random_.below(40);
    for (std::uint32_t i = 0; i < slots; ++i) add(random_slot(random_, world_.profile));
  }

  void play() {
    for (int i = 0; i < kFrames && !::testing::Test::HasFailure(); ++i) {
      if (random_.chance(200)) change_state();
      if (random_.chance(100)) flip();
      step();
    }
    compare_counters();
  }

 private:
  void add(const SlotSpec& spec) {
    gates::SlotChanges changes;
    changes.add.push_back(spec);
    if (!gate_.slots().apply(changes)) return;  // there already, or the chain is full
    world_.slots.push_back(spec);
    counted_.emplace_back();
  }

  void change_state() {
    auto& control = gate_.control();
    control.open = world_.open = !random_.chance(4);
    control.lapsed = random_.chance(8);
    control.deadline = random_.chance(8) ? 1 : ~0ULL;
    world_.lapsed = control.lapsed != 0 || control.deadline == 1;
    world_.audit = random_.chance(3);
    control.mode = world_.audit ? GATE_AUDIT : GATE_ENFORCE;
  }

  void flip() {
    if (world_.slots.empty()) return;
    auto& s = world_.slots[random_.below(static_cast<std::uint32_t>(world_.slots.size()))];
    s.pass = !s.pass;
    gates::SlotChanges changes;
    (s.pass ? changes.open : changes.close).push_back(s);
    ASSERT_TRUE(gate_.slots().apply(changes));
  }

  void step() {
    const auto direction = random_.chance(2) ? Direction::ingress : Direction::egress;
    const auto sender = random_sender(random_);
    const auto bytes = random_frame(random_, world_.profile, sender.xl);
    const auto want = judge(world_, direction, bytes, sender);
    const auto got = gate_.run(direction, bytes, sender);
    ASSERT_EQ(got.dropped, want.outcome.dropped) << core::to_text(gates::reason_of(want.reason));
    ASSERT_EQ(got.mark, want.outcome.mark) << core::to_text(gates::reason_of(want.reason));

    const auto d = static_cast<std::size_t>(direction);
    const bool drop = core::is_drop(gates::reason_of(want.reason));
    ++(drop && world_.audit ? would_drop_ : reasons_).at(d).at(want.reason);
    auto& counted = want.slot ? counted_[*want.slot] : own_[d];
    if (want.reason == GATE_R_PASSED) {
      ++counted.passed;
      counted.bytes += want.bytes;
    } else if (drop) {
      ++(world_.audit ? counted.would_drop : counted.dropped);
      counted.last_reason = gates::reason_of(want.reason);
    }
  }

  void compare(std::uint32_t slot, const Counted& want) const {
    const auto got = gates::slot_counters(gate_.table(), gate_.cpus(), slot);
    EXPECT_EQ(got.passed, want.passed);
    EXPECT_EQ(got.dropped, want.dropped);
    EXPECT_EQ(got.would_drop, want.would_drop);
    EXPECT_EQ(got.bytes, want.bytes);
    EXPECT_EQ(got.last_reason, want.last_reason);
  }

  void compare_counters() {
    for (const auto direction : {Direction::ingress, Direction::egress}) {
      const auto d = static_cast<std::uint16_t>(direction);
      EXPECT_EQ(gates::reason_counters(gate_.cpus(), direction), reasons_.at(d));
      EXPECT_EQ(gates::would_drop_counters(gate_.table(), direction), would_drop_.at(d));
      compare(d, own_[d]);
    }
    for (std::size_t i = 0; i < world_.slots.size(); ++i)
      compare(gate_.slots().find(world_.slots[i]).value(), counted_[i]);
  }

  Random random_;
  World world_;
  LoadedGate& gate_;
  std::array<gates::ReasonCounters, 2> reasons_{};
  std::array<gates::ReasonCounters, 2> would_drop_{};
  std::vector<Counted> own_;
  std::vector<Counted> counted_;
};

TEST(GateAgainstPlainRules, AgreesOnRandomFrames) {
  for (unsigned seed = 1; seed <= kRounds && !HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const GateOptions options{.profile = GATE_PROFILE_RAW + seed % 5,
                              .direct_access = seed % 4 != 0,
                              .echo_by_mark = seed % 2 == 0};
    Round(seed, options).play();
  }
}

TEST(GateBeforeThereIsADaemon, DropsWhatAClosedGateDrops) {
  for (unsigned seed = 1; seed <= 20 && !HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    LoadedGate& gate = LoadedGate::with();
    gate.control().open = 0;
    gate.control().mode = seed % 5 == 0 ? GATE_AUDIT : GATE_ENFORCE;
    const ClosedGate closed(gate.control_fd());
    for (int i = 0; i < kFrames && !HasFailure(); ++i) {
      const auto direction = random.chance(2) ? Direction::ingress : Direction::egress;
      const Sender sender = random_sender(random);
      const Bytes bytes = random_frame(random, GATE_PROFILE_RAW, sender.xl);
      ASSERT_EQ(closed.drops(direction, bytes, sender), gate.run(direction, bytes, sender).dropped);
    }
  }
}

}  // namespace
}  // namespace mlcca::test
