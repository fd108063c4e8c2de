// SPDX-License-Identifier: BSD-2-Clause
// Many verdicts change as one step: one thread flips them, frames are decided on another CPU.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotChanges;
using gates::SlotSpec;

constexpr std::uint32_t kPairs = 1000;
constexpr std::uint32_t kMask = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK;

SlotSpec slot(std::uint32_t id, std::uint64_t subject, bool pass) {
  SlotSpec s;
  s.direction = Direction::ingress;
  s.pass = pass;
  s.id = id;
  s.mask = kMask;
  s.subject = subject;
  return s;
}

/// Of two sets of slots always one passes and one does not; a thread swaps them until it is
/// destroyed.
class Swapping {
 public:
  Swapping(gates::SlotTable& slots, const std::vector<SlotSpec>& first,
           const std::vector<SlotSpec>& second)
      : thread_([this, &slots, &first, &second] {
          SlotChanges change;
          while (!done_) {
            change.close = steps_ % 2 == 0 ? first : second;
            change.open = steps_ % 2 == 0 ? second : first;
            if (!slots.apply(change)) std::abort();
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

class Pairs : public ::testing::TestWithParam<std::uint32_t> {};

/// Many pairs: a step takes far longer than a decision. One: hardly longer.
TEST_P(Pairs, FrameOfTwoSlotsOfOppositeVerdictsIsNeverDecidedByHalfAStep) {
  auto& gate = LoadedGate::with();
  std::vector<SlotSpec> first;
  std::vector<SlotSpec> second;
  for (std::uint32_t id = 0; id < GetParam(); ++id) {
    first.push_back(slot(id, 1, true));
    second.push_back(slot(id, 2, false));
  }
  gate.admit(first);
  gate.admit(second);
  constexpr std::uint32_t rounds = 60;
  constexpr int repeat = 20'000;
  std::uint64_t steps = 0;
  {
    const Swapping swapping(gate.slots(), first, second);
    for (std::uint32_t i = 0; i < rounds || swapping.steps() < 100; ++i)
      gate.time(Direction::ingress, frame(i % GetParam(), 8), {}, repeat);
    steps = swapping.steps();
  }
  EXPECT_GE(steps, 100U);
  std::uint64_t passed = 0;
  std::uint64_t others = 0;
  for (const gate_cpu& cpu : gate.cpus())
    for (std::uint32_t r = 0; r < GATE_REASONS; ++r)
      (r == GATE_R_PASSED ? passed : others) += cpu.reasons[GATE_INGRESS][r];
  EXPECT_EQ(others, 0U) << "of " << passed << " frames, in " << steps << " steps";
}

INSTANTIATE_TEST_SUITE_P(Generation, Pairs, ::testing::Values(1, 1000));

TEST(Generation, VerdictsOfAWholeGenerationAreSeenTogether) {
  auto& gate = LoadedGate::with();
  std::vector<SlotSpec> first;
  std::vector<SlotSpec> second;
  for (std::uint32_t id = 0; id < kPairs; ++id) {
    first.push_back(slot(id, 1, true));
    second.push_back(slot(kPairs + id, 2, false));
  }
  gate.admit(first);
  gate.admit(second);
  const auto generation = [&] {
    return __atomic_load_n(&gate.control().generation, __ATOMIC_ACQUIRE);
  };
  // Which half is the one where the first set passes.
  const auto of_the_first = generation() & 1;
  int whole = 0;
  const Swapping swapping(gate.slots(), first, second);
  for (std::uint32_t i = 0; whole < 20'000 || swapping.steps() < 100; ++i) {
    const auto before = generation();
    const bool one = !gate.run(Direction::ingress, frame(i % kPairs, 8)).dropped;
    const bool other = !gate.run(Direction::ingress, frame(kPairs + (i + 1) % kPairs, 8)).dropped;
    if (generation() != before) continue;
    ++whole;
    ASSERT_EQ(one, (before & 1) == of_the_first) << "frame " << i;
    ASSERT_EQ(other, !one) << "frame " << i;
  }
}

}  // namespace
}  // namespace mlcca::test
