// SPDX-License-Identifier: BSD-2-Clause
// A million subjects on one interface: what they take, and that each is found.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <random>

#include "tests/bpf/ether/loaded_ether.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr std::size_t kMillion = 1'000'000;

TEST(EtherMemory, AMillionSubjectsTakeLessThan100BytesEach) {
  LoadedEther gate({.slots = kMillion});
  std::mt19937_64 random(1);
  gates::SlotChanges batch;
  for (std::size_t i = 0; i < kMillion; ++i) {
    SlotSpec s;
    s.direction = Direction::ingress;
    s.pass = true;
    s.subject = random();
    s.formats = ETHER_UNFRAGMENTED;
    s.per_frame = 1 + i % 1000;
    s.period = 1'000'000'000;
    batch.add.push_back(s);
  }
  const auto start = std::chrono::steady_clock::now();
  const auto done = gate.table().apply(batch);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  ASSERT_TRUE(done) << done.error().text;
  const double each = static_cast<double>(gate.map_bytes()) / kMillion;
  std::printf("%zu subjects: %.1f bytes each, %.2f s to insert\n", kMillion, each, took.count());
  EXPECT_LT(each, 100);
  EXPECT_GT(each, 64) << "the slots and counters alone are that large";
  EXPECT_EQ(gate.table().size(), kMillion);
  EXPECT_EQ(gate.table().unwatched(), kMillion - (ETHER_WATCHES - 1));

  std::size_t passed = 0;
  for (std::size_t i = 0; i < kMillion; i += 100) {
    const Datagram d{.subject = batch.add[i].subject};
    passed += gate.run(Direction::ingress, frame(d.whole())).dropped ? 0 : 1;
  }
  EXPECT_EQ(passed, kMillion / 100);
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < kMillion / 100; ++i)
    dropped += gate.run(Direction::ingress, frame(Datagram{.subject = random()}.whole())).dropped;
  EXPECT_EQ(dropped, kMillion / 100);
}

}  // namespace
}  // namespace mlcca::test
