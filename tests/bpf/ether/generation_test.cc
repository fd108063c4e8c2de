// SPDX-License-Identifier: BSD-2-Clause
// Many verdicts of Ethernet and CAN change as one step: one thread flips them, packets and frames
// are decided on another CPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "tests/bpf/ether/can_twin.hpp"
#include "tests/bpf/ether/events.hpp"

namespace mlcca::test {
namespace {

using gates::SlotChanges;
using gates::VerdictTable;

struct Sets {
  std::vector<SlotSpec> first;
  std::vector<SlotSpec> second;
};

SlotChanges swapping(const Sets& sets, std::uint64_t step) {
  SlotChanges change;
  change.close = step % 2 == 0 ? sets.first : sets.second;
  change.open = step % 2 == 0 ? sets.second : sets.first;
  return change;
}

/// Of two sets of slots of each table always one passes and one does not; a thread swaps them, in
/// all tables at once, until it is destroyed.
class Swapping {
 public:
  struct Side {
    VerdictTable* table;
    const Sets* sets;
  };
  explicit Swapping(std::vector<Side> sides)
      : thread_([this, sides = std::move(sides)] {
          while (!done_) {
            std::vector<SlotChanges> swaps;
            for (const Side& side : sides) swaps.push_back(swapping(*side.sets, steps_));
            std::vector<VerdictTable::Change> changes;
            for (std::size_t i = 0; i < sides.size(); ++i)
              changes.push_back({sides[i].table, &swaps[i]});
            if (!VerdictTable::apply_together(changes)) std::abort();
            ++steps_;
          }
        }) {}
  Swapping(const Swapping&) = delete;
  Swapping& operator=(const Swapping&) = delete;
  ~Swapping() {
    done_ = true;
    thread_.join();
  }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }

 private:
  std::atomic<bool> done_ = false;
  std::atomic<std::uint64_t> steps_ = 0;
  std::thread thread_;
};

SlotSpec of_length(std::uint64_t subject, std::uint16_t length, bool pass) {
  return with(in(), [=](SlotSpec& s) {
    s.subject = subject;
    s.max_len = length;
    s.pass = pass;
  });
}
Bytes of_subject(std::uint64_t subject) {
  return packet([=](Datagram& d) { d.subject = subject; });
}

class EtherPairs : public ::testing::TestWithParam<std::uint64_t> {};

/// Many pairs: a step takes far longer than a decision. One: hardly longer.
TEST_P(EtherPairs, EventOfTwoSlotsOfOppositeVerdictsIsNeverDecidedByHalfAStep) {
  auto& gate = LoadedEther::with();
  Sets sets;
  for (std::uint64_t subject = 1; subject <= GetParam(); ++subject) {
    sets.first.push_back(of_length(subject, 100, true));
    sets.second.push_back(of_length(subject, 101, false));
  }
  gate.admit(sets.first);
  gate.admit(sets.second);
  std::uint64_t steps = 0;
  {
    const Swapping swapping({{&gate.table(), &sets}});
    for (std::uint64_t i = 0; i < 60 || swapping.steps() < 100; ++i)
      gate.repeat(kIn, of_subject(1 + i % GetParam()), 20'000);
    steps = swapping.steps();
  }
  EXPECT_GE(steps, 100U);
  const auto reasons = gate.reasons(kIn);
  std::uint64_t others = 0;
  for (std::size_t r = 0; r < reasons.size(); ++r) others += r == GATE_R_PASSED ? 0 : reasons[r];
  EXPECT_EQ(others, 0U) << "of " << reasons[GATE_R_PASSED] << " events, in " << steps << " steps";
}

INSTANTIATE_TEST_SUITE_P(EtherGeneration, EtherPairs, ::testing::Values(1, 1000));

/// In the driver, in tc and by a later IP fragment: the same half.
TEST(EtherGeneration, VerdictsOfAWholeGenerationAreSeenTogetherWithThoseOfCan) {
  auto& gate = LoadedEther::with();
  CanTwin can(gate.control_fd());
  constexpr std::uint32_t pairs = 500;
  Sets ether;
  Sets raw;
  for (std::uint32_t i = 1; i <= pairs; ++i) {
    ether.first.push_back(of_length(i, ETHER_MAX_PAYLOAD, true));
    ether.second.push_back(of_length(pairs + i, ETHER_MAX_PAYLOAD, false));
    raw.first.push_back(CanTwin::slot(i, true));
    raw.second.push_back(CanTwin::slot(pairs + i, false));
  }
  gate.admit(ether.first);
  gate.admit(ether.second);
  can.admit(raw.first);
  can.admit(raw.second);
  const auto generation = [&] {
    return __atomic_load_n(&gate.control().generation, __ATOMIC_ACQUIRE);
  };
  const auto of_the_first = generation() & 1;  // the half where the first set passes
  // First parts are remembered while the first set passes; each has octets left for many a later.
  std::vector<Bytes> later_parts;
  for (std::uint16_t id = 0; id < 200; ++id) {
    const Datagram parts = event([id](Datagram& d) {
      d.subject = 1;
      d.payload = ETHER_MAX_PAYLOAD;
      d.id = id;
    });
    ASSERT_FALSE(gate.run(kIn, frame(parts.fragment(0, 400))).dropped);
    later_parts.push_back(frame(parts.fragment(400, 408)));
  }
  int whole = 0;
  const Swapping swapping({{&gate.table(), &ether}, {&can.table(), &raw}});
  for (std::uint32_t i = 0; whole < 5'000 || swapping.steps() < 100; ++i) {
    const auto before = generation();
    const bool first = !gate.run(kIn, of_subject(1 + i % pairs)).dropped;
    const bool second = !gate.run(kIn, of_subject(pairs + 1 + (i + 1) % pairs)).dropped;
    const bool early = !gate.dropped_early(of_subject(1 + (i + 2) % pairs));
    const bool later = !gate.run(kIn, later_parts[i % later_parts.size()]).dropped;
    const bool on_can = can.passes(1 + (i + 3) % pairs);
    if (generation() != before) continue;
    ++whole;
    ASSERT_EQ(first, (before & 1) == of_the_first) << "event " << i;
    ASSERT_EQ(second, !first) << "event " << i;
    ASSERT_EQ(early, first) << "event " << i;
    ASSERT_EQ(later, first) << "event " << i;
    ASSERT_EQ(on_can, first) << "event " << i;
  }
}

}  // namespace
}  // namespace mlcca::test
