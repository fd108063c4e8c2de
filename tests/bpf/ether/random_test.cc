// SPDX-License-Identifier: BSD-2-Clause
// Random slots, states and packets of every length and with every octet changed: the programs and
// the plain rules must agree on every packet and on every counter.
#include <bpf/bpf.h>
#include <gtest/gtest.h>
#include <linux/batadv_packet.h>
#include <linux/pkt_cls.h>

#include <algorithm>
#include <array>
#include <random>

#include "daemon/gates/closed_programs.hpp"
#include "tests/bpf/ether/oracle.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr int kRounds = 250;  // 2.5 million packets
constexpr int kPackets = 10'000;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(engine_() % n); }
  bool chance(std::uint32_t one_in) { return below(one_in) == 0; }
  template <class T>
  T of(std::initializer_list<T> values) {
    return *(values.begin() + below(static_cast<std::uint32_t>(values.size())));
  }

 private:
  std::mt19937 engine_;
};

/// Few, so that packets and slots meet; half a bucket apart, and with all bits set.
constexpr std::array<std::uint64_t, 6> kSubjects = {0x44697374616e6365, 0x44697374616e6366, 1, 0,
                                                    ~std::uint64_t{0},  0x8000000000000000};

std::uint64_t random_station(Random& random) {
  return random.of<std::uint64_t>({0, 0, 0x0a000001, 0x0a000002, ETHER_MAC | kAwdsSource});
}

SlotSpec random_slot(Random& random) {
  SlotSpec s;
  s.direction = random.chance(2) ? Direction::ingress : Direction::egress;
  s.pass = !random.chance(4);
  s.subject = kSubjects.at(random.below(kSubjects.size()));
  s.max_len = random.of<std::uint16_t>({0, 8, 100, 300, ETHER_MAX_PAYLOAD});
  s.formats = random.of<std::uint8_t>(
      {ETHER_UNFRAGMENTED, ETHER_UNFRAGMENTED | ETHER_FRAGMENT, ETHER_FRAGMENT});
  s.station = random_station(random);
  if (s.direction == Direction::egress) {
    s.source = random.of<std::uint32_t>({0, 0, kOther, kIfindex});
    s.uid = random.of<std::uint32_t>({GATE_ANY_UID, 0, 1000});
  }
  return s;
}

Datagram random_datagram(Random& random) {
  Datagram d;
  d.subject = kSubjects.at(random.below(kSubjects.size()));
  d.flag = random.chance(4) ? 1 : 0;
  d.payload = random.of<std::size_t>({0, 1, 7, 8, 9, 100, 101, 263, 300, 301});
  d.port = random.of<std::uint16_t>({9999, 9999, 9999, 8888, 53});
  d.id = static_cast<std::uint16_t>(random.below(3));
  d.source = random.of<std::uint32_t>({0x0a000001, 0x0a000002});
  d.options = random.chance(4) ? static_cast<std::uint8_t>(4 * random.below(11)) : 0;
  if (random.chance(20)) d.protocol = random.of<std::uint8_t>({6, 1, 136});
  if (random.chance(30)) d.version = static_cast<std::uint8_t>(random.below(16));
  if (random.chance(30)) d.ihl = static_cast<std::uint8_t>(random.below(16));
  if (random.chance(20)) d.longer_udp = static_cast<int>(random.below(40)) - 20;
  if (random.chance(20)) d.longer_ip = static_cast<int>(random.below(40)) - 20;
  return d;
}

Bytes random_ip(Random& random) {
  const Datagram d = random_datagram(random);
  if (!random.chance(2)) return d.whole();
  const std::size_t size = d.content().size();
  const std::size_t from = 8 * random.below(static_cast<std::uint32_t>(size / 8 + 1));
  std::size_t to = std::min(size, from + 8 * (1 + random.below(20)));
  if (random.chance(30)) to = from + random.below(static_cast<std::uint32_t>(size - from + 1));
  return d.fragment(from, to);
}

std::vector<std::uint16_t> random_tags(Random& random) {
  std::vector<std::uint16_t> tags;
  while (random.chance(4)) tags.push_back(random.of<std::uint16_t>({0x8100, 0x88a8}));
  return tags;
}

Bytes random_awds(Random& random) {
  const std::uint8_t kind = random.of<std::uint8_t>(
      {98, 98, 98, 0x7b, 0x7c, 0, 42, 43, 44, 96, 97, 99, 100, 0x7d, 0x81, 0x82, 200});
  Bytes payload(20);
  if (kind == 98) payload = ethernet(0x0800, random_ip(random), random_tags(random));
  if (kind == 0x7b || kind == 0x7c)
    payload = awds_event(kSubjects.at(random.below(kSubjects.size())),
                         random.of<std::size_t>({0, 8, 9, 100, 101}),
                         random.chance(10) ? static_cast<int>(random.below(40)) - 20 : 0);
  Bytes packet = random.chance(2) ? awds_flood(kind, payload) : awds_unicast(kind, payload);
  if (random.chance(10)) packet[0] = static_cast<std::uint8_t>(random.below(256));
  return packet;
}

Bytes random_batman(Random& random) {
  const std::uint8_t type = random.of<std::uint8_t>(
      {BATADV_BCAST, BATADV_UNICAST, BATADV_UNICAST_4ADDR, BATADV_UNICAST_FRAG, BATADV_IV_OGM,
       BATADV_CODED, BATADV_ELP, BATADV_OGM2, BATADV_ICMP, BATADV_UNICAST_TVLV, 0x60});
  return batman(type, ethernet(0x0800, random_ip(random), random_tags(random)),
                random.chance(10) ? static_cast<std::uint8_t>(random.below(256)) : 15);
}

/// A test run does not take what is shorter than what its type promises.
bool is_runnable(const Bytes& bytes) {
  if (bytes.size() < 15) return false;
  const unsigned type = bytes[12] << 8U | bytes[13];
  return (type != 0x0800 && type != 0x86dd) || bytes.size() >= 14 + 40;
}

Bytes random_packet(Random& random) {
  const std::vector<std::uint16_t> tags = random_tags(random);
  Bytes bytes = !random.chance(3)  ? ethernet(0x0800, random_ip(random), tags)
                : random.chance(2) ? ethernet(0x8334, random_awds(random), tags)
                                   : ethernet(0x4305, random_batman(random), tags);
  if (random.chance(40)) bytes[12 + random.below(2)] = static_cast<std::uint8_t>(random.below(256));
  if (random.chance(3))
    bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] =
        static_cast<std::uint8_t>(random.below(256));
  if (random.chance(5)) bytes.resize(random.below(static_cast<std::uint32_t>(bytes.size() + 20)));
  return is_runnable(bytes) ? bytes : random_packet(random);
}

Sender random_sender(Random& random) {
  Sender s;
  s.local = random.chance(2);
  s.ingress_ifindex = s.local ? 0 : random.of<std::uint32_t>({0, kOther, kIfindex});
  if (random.chance(2))
    s.mark = gate_ingress_token(
        kToken, random.of<std::uint32_t>({kOther, kIfindex}),
        gate_origin(kSubjects.at(random.below(kSubjects.size())), random_station(random)));
  else if (random.chance(4))
    s.mark = gate_refused_token(kToken);
  return s;
}

class Round {
 public:
  Round(unsigned seed, const EtherOptions& options)
      : random_(seed), gate_(LoadedEther::with(options)) {}

  void play() {
    for (std::uint32_t i = 0, count = random_.below(20); i < count; ++i) add();
    for (int i = 0; i < kPackets && !::testing::Test::HasFailure(); ++i) {
      if (random_.chance(300)) change_state();
      if (random_.chance(100)) flip();
      if (random_.chance(300)) remove();
      if (random_.chance(300)) add();
      step();
    }
    compare_counters();
  }

 private:
  void add() {
    gates::SlotChanges changes;
    changes.add.push_back(random_slot(random_));
    if (!gate_.table().apply(changes)) return;  // there already, or the chain is full
    world_.slots.push_back(changes.add.front());
    counted_.emplace_back();
  }

  /// One that is there; none where the draw hits one that is gone.
  SlotSpec* any() {
    if (world_.slots.empty()) return nullptr;
    auto& s = world_.slots[random_.below(static_cast<std::uint32_t>(world_.slots.size()))];
    return s.formats == 0 ? nullptr : &s;
  }

  void remove() {
    SlotSpec* s = any();
    if (s == nullptr) return;
    gates::SlotChanges changes;
    changes.remove = {*s};
    ASSERT_TRUE(gate_.table().apply(changes));
    s->formats = 0;
  }

  void flip() {
    SlotSpec* s = any();
    if (s == nullptr) return;
    s->pass = !s->pass;
    gates::SlotChanges changes;
    (s->pass ? changes.open : changes.close).push_back(*s);
    ASSERT_TRUE(gate_.table().apply(changes));
  }

  void change_state() {
    auto& control = gate_.control();
    control.open = world_.open = !random_.chance(6);
    control.lapsed = random_.chance(12);
    control.deadline = random_.chance(12) ? 1 : ~0ULL;
    world_.lapsed = control.lapsed != 0 || control.deadline == 1;
    world_.audit = random_.chance(4);
    control.mode = world_.audit ? GATE_AUDIT : GATE_ENFORCE;
  }

  void step() {
    const auto direction = random_.chance(2) ? Direction::ingress : Direction::egress;
    const Bytes bytes = random_packet(random_);
    const Sender sender = random_sender(random_);
    if (direction == Direction::ingress && random_.chance(3)) {
      const auto early = world_.judge_early(bytes);
      ASSERT_EQ(gate_.dropped_early(bytes), early.has_value());
      if (early) return account(direction, *early);
    }
    const auto want = world_.judge(direction, bytes, sender);
    const auto got = gate_.run(direction, bytes, sender);
    ASSERT_EQ(got.dropped, want.dropped) << core::to_text(gates::reason_of(want.reason));
    ASSERT_EQ(got.mark, want.mark.value_or(sender.mark))
        << core::to_text(gates::reason_of(want.reason));
    account(direction, want);
  }

  void account(Direction direction, const Judgement& want) {
    const auto d = static_cast<std::size_t>(direction);
    const bool drop = core::is_drop(gates::reason_of(want.reason));
    ++(drop && world_.audit ? would_drop_ : reasons_).at(d).at(want.reason);
    if (!want.counts_in_slot) return;
    auto& counted = want.slot ? counted_[*want.slot] : own_[d];
    if (want.reason == GATE_R_PASSED) {
      ++counted.passed;
      counted.bytes += want.bytes;
    } else {
      ++(world_.audit ? counted.would_drop : counted.dropped);
      counted.last_reason = gates::reason_of(want.reason);
    }
  }

  static void compare(const gates::SlotCounters& got, const gates::SlotCounters& want) {
    EXPECT_EQ(got.passed, want.passed);
    EXPECT_EQ(got.dropped, want.dropped);
    EXPECT_EQ(got.would_drop, want.would_drop);
    EXPECT_EQ(got.bytes, want.bytes);
    EXPECT_EQ(got.last_reason, want.last_reason);
  }

  void compare_counters() {
    for (const auto direction : {Direction::ingress, Direction::egress}) {
      EXPECT_EQ(gate_.reasons(direction), reasons_.at(static_cast<std::size_t>(direction)));
      EXPECT_EQ(gate_.would_drop(direction), would_drop_.at(static_cast<std::size_t>(direction)));
      compare(gate_.counted(direction), own_.at(static_cast<std::size_t>(direction)));
    }
    for (std::size_t i = 0; i < world_.slots.size(); ++i)
      if (world_.slots[i].formats != 0) compare(gate_.counted(world_.slots[i]), counted_[i]);
  }

  Random random_;
  EtherWorld world_;
  LoadedEther& gate_;
  std::array<gates::ReasonCounters, 2> reasons_{};
  std::array<gates::ReasonCounters, 2> would_drop_{};
  std::array<gates::SlotCounters, 2> own_{};
  std::vector<gates::SlotCounters> counted_;
};

TEST(EtherAgainstPlainRules, AgreesOnRandomPackets) {
  for (unsigned seed = 1; seed <= kRounds && !HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    Round(seed, {.direct_access = seed % 4 != 0,
                 .atomic_counts = seed % 3 == 0,
                 .slots = seed % 5 == 0 ? std::size_t{ETHER_BANKED_SLOTS} : 0})
        .play();
  }
}

TEST(EtherBeforeThereIsADaemon, DropsWhatAClosedGateDrops) {
  for (unsigned seed = 1; seed <= 20 && !HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    LoadedEther& gate = LoadedEther::with();
    gate.control().open = 0;
    gate.control().mode = seed % 5 == 0 ? GATE_AUDIT : GATE_ENFORCE;
    const auto closed =
        gates::ClosedPrograms::of_ethernet({.control = gate.control_fd(), .events = -1}, false);
    ASSERT_TRUE(closed) << closed.error().text;
    std::size_t dropped = 0;
    for (int i = 0; i < kPackets && !HasFailure(); ++i) {
      const auto direction = random.chance(2) ? Direction::ingress : Direction::egress;
      const Bytes bytes = random_packet(random);
      const bool want = gate.run(direction, bytes).dropped;
      dropped += want ? 1 : 0;
      ASSERT_EQ(drops(*closed, direction, bytes), want);
    }
    EXPECT_EQ(dropped > kPackets / 4, seed % 5 != 0);
    EXPECT_LT(dropped, std::size_t{kPackets});
  }
}

}  // namespace
}  // namespace mlcca::test
