// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's tags in the memory of a gate: what is stated about them, and what the gate has found in
// the broker's replies (gate_binding in bpf/gate.h). Works on any gate_table, so it is tested
// without a kernel.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "bpf/gate.h"

namespace mlcca::gates {

/// The tag that the frames of a subject have on a bus, as user space states it.
struct StatedBinding {
  std::uint64_t subject = 0;
  std::uint16_t etag = 0;  ///< 0: not known yet
  // For a gate that has not seen the broker's replies itself:
  bool contradicted = false;
  std::uint16_t dealt = 0;  ///< the tag that the broker has last dealt to the subject; 0: none
  bool operator==(const StatedBinding&) const = default;
};

/// What a gate has found about one tag.
struct FoundBinding {
  std::uint64_t subject = 0;
  std::uint16_t etag = 0;
  /// The broker has dealt the tag to another subject, or another tag to the subject. The kernel
  /// refuses frames with the tag until end_contradictions().
  bool contradicted = false;
  bool confirmed = false;   ///< since then a complete reply has dealt the tag as stated
  std::uint16_t dealt = 0;  ///< tag that a complete reply has last dealt to the subject; 0: none
  std::uint64_t other = 0;  ///< the subject to which the tag was dealt, if `halves` is not 0
  std::uint8_t halves = 0;  ///< known parts of `other`: 1: first 4 bytes, 2: last 4, 3: all
  std::uint32_t contradictions = 0;  ///< count so far, for move()
  bool operator==(const FoundBinding&) const = default;
};

/// States tags in the memory of a gate, and reads what the gate has found.
class Bindings {
 public:
  explicit Bindings(gate_table& table) : table_(&table) {}

  /// Replaces what is stated: each subject once, at most GATE_BINDINGS of them. The findings of a
  /// binding that does not change stay; with another tag its contradictions end. A tag may be given
  /// up only if no slot passes frames with it.
  void state(std::span<const StatedBinding> bindings);
  /// Gives the subject of `seen` another tag, or none (0), because of what `seen` reports. Findings
  /// after `seen` count against the new tag.
  void move(const FoundBinding& seen, std::uint16_t etag);
  /// A value that changes whenever something is found. It may also change without a finding.
  [[nodiscard]] std::uint32_t news() const;
  [[nodiscard]] std::vector<FoundBinding> found() const;
  /// Ends the contradictions of a subject up to now: its slots, which must deny, may pass again.
  /// False if there is a new contradiction; then they stay closed.
  bool end_contradictions(std::uint64_t subject);
  /// Whether the kernel refuses frames of the slot. To be asked after a slot was linked: whichever
  /// of program and caller comes later sees the effect of the other.
  [[nodiscard]] bool is_contradicted(const gate_slot& slot) const;

 private:
  [[nodiscard]] std::span<gate_binding> used() const;
  [[nodiscard]] gate_binding* find(std::uint64_t subject) const;
  void mark_slots(const gate_binding& binding, std::uint8_t contradicted) const;

  gate_table* table_;
};

}  // namespace mlcca::gates
