// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's tags: what is stated of them in the memory of a gate, and what the gate has found in
// the replies of the broker. See gate_binding in bpf/gate.h. Works on any gate_table, so that it is
// tested without a kernel.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "bpf/gate.h"

namespace mlcca::enforce {

/// What the frames of a subject have on a bus.
struct StatedBinding {
  std::uint64_t subject = 0;
  std::uint16_t etag = 0;  ///< 0: not known yet
  // For a gate that has not seen the traffic itself:
  bool contradicted = false;
  std::uint16_t dealt = 0;  ///< the tag that the broker has dealt it last; 0: none
  bool operator==(const StatedBinding&) const = default;
};

/// What a gate has found of one.
struct FoundBinding {
  std::uint64_t subject = 0;
  std::uint16_t etag = 0;
  /// The broker has dealt the tag to another subject, or the subject another tag. Frames of the tag
  /// are refused by the kernel until settle().
  bool contradicted = false;
  bool confirmed = false;   ///< since then a whole reply has dealt the tag as stated again
  std::uint16_t dealt = 0;  ///< the tag that a whole reply has dealt to the subject last; 0: none
  std::uint64_t other = 0;  ///< subject that the tag was dealt to, where `halves` is not 0
  std::uint8_t halves = 0;  ///< 1: only the first 4 bytes of it are known, 2: only the last, 3: all
  std::uint32_t contradictions = 0;  ///< so far, for move()
  bool operator==(const FoundBinding&) const = default;
};

class Bindings {
 public:
  explicit Bindings(gate_table& table) : table_(&table) {}

  /// Replaces what is stated; each subject once, at most GATE_BINDINGS. What was found of a binding
  /// that stays as it is stays, too; where another tag is stated, contradictions are over. Give a
  /// tag up only where no slot of it passes.
  void state(std::span<const StatedBinding> bindings);
  /// The subject of `seen` has another tag, or none (0), because of what was found then. What was
  /// found since counts against the new tag.
  void move(const FoundBinding& seen, std::uint16_t etag);
  /// Changes whenever something is found; may change without.
  [[nodiscard]] std::uint32_t news() const;
  [[nodiscard]] std::vector<FoundBinding> found() const;
  /// The contradictions of a subject so far are over: its slots, which must deny, may pass again.
  /// False: there is a new one, and they stay shut.
  bool settle(std::uint64_t subject);
  /// The kernel refuses frames of the slot. To be asked after a slot was linked: whichever of the
  /// two comes later, program or caller, sees the other one.
  [[nodiscard]] bool is_contradicted(const gate_slot& slot) const;

 private:
  [[nodiscard]] std::span<gate_binding> used() const;
  [[nodiscard]] gate_binding* find(std::uint64_t subject) const;
  void mark_slots(const gate_binding& binding, std::uint8_t contradicted) const;

  gate_table* table_;
};

}  // namespace mlcca::enforce
