// SPDX-License-Identifier: BSD-2-Clause
// A gate with one slot, which admits the frames of one identifier that come in.
#pragma once
#include <gtest/gtest.h>

#include <cstdint>

#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {

inline constexpr std::uint32_t kId = 0x123;

inline gates::SlotSpec one_slot() {
  gates::SlotSpec s;
  s.direction = gates::Direction::ingress;
  s.pass = true;
  s.id = kId;
  s.mask = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK;
  s.subject = 1;
  return s;
}

class OneSlot : public ::testing::Test {
 protected:
  void admit(const gates::SlotSpec& s) {
    gate_.reset();
    gate_.admit({s});
    slot_ = gate_.slots().find(s).value();
  }
  bool passes(unsigned length = 8) {
    return !gate_.run(gates::Direction::ingress, frame(kId, length)).dropped;
  }

  LoadedGate& gate_ = LoadedGate::with();
  std::uint32_t slot_ = 0;
};

}  // namespace mlcca::test
