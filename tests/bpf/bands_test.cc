// SPDX-License-Identifier: BSD-2-Clause
// The band of a queueing discipline that a leaving frame goes into, by the real gate program.
#include <gtest/gtest.h>

#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {
namespace {

/// Each band but the last has a limit: the arbitration of the last frame that goes into it.
TEST(GateBands, AFrameGoesIntoTheFirstBandWhoseLimitIsNotBelowIt) {
  auto& gate = LoadedGate::with();
  gates::SlotSpec any;
  any.direction = gates::Direction::egress;
  any.pass = true;
  any.mask = CAN_EFF_FLAG | CAN_RTR_FLAG;  // any identifier of 11 bits, of a program of user 0
  any.subject = 1;
  gate.admit({any});
  constexpr Sender local{.local = true};
  gate_table& table = gate.table();
  constexpr std::uint32_t step = 0x10;
  for (std::uint32_t i = 0; i + 1 < GATE_BANDS; ++i)
    table.band_limit[i] = gate_arbitration((i + 1) * step);
  EXPECT_EQ(gate.band(frame(0x7ff, 8), local), priority_of(local)) << "no bands: left alone";
  table.bands = GATE_BANDS;
  for (std::uint32_t i = 0; i + 1 < GATE_BANDS; ++i) {
    EXPECT_EQ(gate.band(frame((i + 1) * step, 8), local), i);
    EXPECT_EQ(gate.band(frame((i + 1) * step + 1, 8), local), i + 1);
  }
  EXPECT_EQ(gate.band(frame(0, 8), local), 0U);
  EXPECT_EQ(gate.band(frame(0x7ff, 8), local), GATE_BANDS - 1U) << "the last one";
  gate.reset();
}

}  // namespace
}  // namespace mlcca::test
