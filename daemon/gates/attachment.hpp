// SPDX-License-Identifier: BSD-2-Clause
// The programs of a gate in the two hooks of an interface: in the program list of TCX where the
// kernel has it (Linux 6.6), otherwise as filters of clsact. Both may exist for a moment, while one
// takes over from the other. In either hook only the interface holds the programs: they outlive
// this process and all pins.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::gates {

enum class Hook : std::uint8_t { clsact, tcx };
const char* to_text(Hook hook);

/// TCX where the kernel has it, because it runs before clsact.
Hook best_hook();

/// Egress comes first, so that a start that is interrupted leaves open the way in, not the way out.
inline constexpr std::array kBothDirections = {Direction::egress, Direction::ingress};

/// The place of a gate: interface, hook, and the directory of its pins.
struct GateLocation {
  std::uint32_t ifindex = 0;
  std::string directory;  ///< in a bpffs; where the programs are pinned
  Hook hook = Hook::clsact;
};

/// The ids of the programs in our places; 0 for none. In TCX, only programs that a pin of ours
/// names.
struct InPlace {
  std::uint32_t ingress = 0;
  std::uint32_t egress = 0;
  [[nodiscard]] std::uint32_t of(Direction direction) const {
    return direction == Direction::ingress ? ingress : egress;
  }
  /// One program in both directions means an ingress qdisc, which has no egress hook.
  [[nodiscard]] bool is_gate() const { return ingress != 0 && egress != 0 && ingress != egress; }
};
/// Reads the programs that are in our places.
Result<InPlace> in_place(const GateLocation& place);

/// Puts a program in our place, replacing what is there: at every moment the old or the new program
/// runs. The directory must exist. For clsact the hooks are made.
Result<void> put_in_place(const GateLocation& place, Direction direction, int program_fd);
/// Puts a program in our place if that is empty; false if it is not. In TCX the program is pinned
/// here.
Result<bool> put_in_empty_place(const GateLocation& place, Direction direction, int program_fd);
/// Removes what we have in this place, and never anything else.
void withdraw(const GateLocation& place);

/// The descriptors of the two programs of a gate.
struct GatePrograms {
  int ingress = -1;
  int egress = -1;
  [[nodiscard]] int of(Direction direction) const {
    return direction == Direction::ingress ? ingress : egress;
  }
};
/// Whether both programs are in their places. An `ingress` qdisc instead of clsact would use the
/// egress filter for ingress; then the result is false.
Result<bool> are_in_place(const GateLocation& place, const GatePrograms& programs);
/// Whether neither program is in its place.
Result<bool> are_both_removed(const GateLocation& place, const GatePrograms& programs);
/// Removes from the TCX list all programs of gates except `ours`. The error: the list or the
/// programs cannot be read.
Result<void> remove_orphans(std::uint32_t ifindex, Direction direction, std::uint32_t ours);

/// Puts both programs in place. Then removes what we have in the other hook, and other programs of
/// ours from TCX: of a daemon whose pins are gone, or of another layout.
Result<void> put_gate_in_place(const GateLocation& place, const GatePrograms& programs);

/// A program of another owner that runs before ours, in the same hook or in an earlier one, and may
/// let frames pass before the gate.
struct Ahead {
  Direction direction = Direction::ingress;
  Hook hook = Hook::clsact;
  std::uint32_t program = 0;
  bool operator==(const Ahead&) const = default;
};
/// The programs before ours in TCX. For clsact, see net/filter_order.
Result<std::vector<Ahead>> tcx_ahead(const GateLocation& place, const InPlace& ours);

/// Puts programs before all others of their hook, in place of our `former` ones. Both run for a
/// moment: a frame that is forwarded then may be dropped, but none passes unchecked. For TCX,
/// `programs` must differ from those in place.
Result<void> put_gate_first(const GateLocation& place, const GatePrograms& programs,
                            const GatePrograms& former);

/// The ids of the programs of a gate. An error if the kernel does not state one of them: without
/// it, the gate's own program cannot be distinguished from another one that is to be removed.
Result<InPlace> ids_of(const GatePrograms& programs);

}  // namespace mlcca::gates
