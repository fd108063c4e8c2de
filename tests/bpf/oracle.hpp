// SPDX-License-Identifier: BSD-2-Clause
// The gate's rules once more, as plainly as possible: what the kernel program is held against.
#pragma once
#include <optional>
#include <vector>

#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {

struct World {
  std::uint32_t profile = GATE_PROFILE_RAW;
  bool echo_by_mark = false;
  bool open = true;
  bool lapsed = false;
  bool audit = false;
  std::vector<gates::SlotSpec> slots;  ///< in the order they were added
};

struct Judgement {
  Outcome outcome;
  gate_reason reason = GATE_R_PASSED;
  std::optional<std::size_t> slot;  ///< that counts the frame; none: the direction's own
  std::uint64_t bytes = 0;
};

Judgement judge(const World& world, gates::Direction direction, const Bytes& bytes,
                const Sender& sender);

}  // namespace mlcca::test
