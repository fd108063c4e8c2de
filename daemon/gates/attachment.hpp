// SPDX-License-Identifier: BSD-2-Clause
// Our place in the two hooks of an interface: programs in the order of TCX where the kernel has it
// (6.6), else filters of clsact. Both can be there for a moment, when one takes over from the
// other. In either nothing but the interface holds what is there: it outlives this process and all
// pins.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::enforce {

enum class Hook : std::uint8_t { clsact, tcx };
const char* to_text(Hook hook);

/// TCX where the kernel has it: it runs before clsact.
Hook best_hook();

/// Egress first: what a half-finished start leaves open is the way in, not the way out.
inline constexpr std::array kBothDirections = {Direction::egress, Direction::ingress};

struct Place {
  std::uint32_t ifindex = 0;
  std::string directory;  ///< in a bpffs; where the programs have their names
  Hook hook = Hook::clsact;
};

/// Ids of the programs in our two places, 0 for none. Of TCX, those that a pin names.
struct InPlace {
  std::uint32_t ingress = 0;
  std::uint32_t egress = 0;
  [[nodiscard]] std::uint32_t of(Direction direction) const {
    return direction == Direction::ingress ? ingress : egress;
  }
  /// One program in both means an ingress qdisc, which has no egress hook.
  [[nodiscard]] bool is_gate() const { return ingress != 0 && egress != 0 && ingress != egress; }
};
Result<InPlace> in_place(const Place& place);

/// Puts a program in our place, instead of what is there: at every moment the old one or the new
/// one runs. The directory must be there. In clsact with its hooks.
Result<void> put_in_place(const Place& place, Direction direction, int program_fd);
/// Only where our place is empty: false when it is not. In TCX it gets its name here.
Result<bool> put_in_empty_place(const Place& place, Direction direction, int program_fd);
/// Removes what we have there; never anything else.
void withdraw(const Place& place);

/// The two programs of a gate.
struct GatePrograms {
  int ingress = -1;
  int egress = -1;
  [[nodiscard]] int of(Direction direction) const {
    return direction == Direction::ingress ? ingress : egress;
  }
};
/// Both are in their places, each in its own. They are not where an `ingress` qdisc instead of
/// clsact takes the egress filter for an ingress one.
Result<bool> are_in_place(const Place& place, const GatePrograms& programs);
/// Neither is in its place.
Result<bool> are_both_removed(const Place& place, const GatePrograms& programs);
/// Takes what is of any gate out of the order of TCX, but not `ours`. Error: it cannot be known.
Result<void> remove_orphans(std::uint32_t ifindex, Direction direction, std::uint32_t ours);

/// Puts both in place, and then withdraws what we have in the other hook, and what else of ours is
/// in TCX: of a daemon whose pins are gone, or of another layout.
Result<void> put_gate_in_place(const Place& place, const GatePrograms& programs);

/// Programs that run before ours in its own hook, or in a hook before it, and may let frames by.
struct Ahead {
  Direction direction = Direction::ingress;
  Hook hook = Hook::clsact;
  std::uint32_t program = 0;
  bool operator==(const Ahead&) const = default;
};
/// Of TCX only: libnl knows the order of clsact (net/filters).
Result<std::vector<Ahead>> tcx_ahead(const Place& place, const InPlace& ours);

/// Puts programs before all others of their hook, in the place of `former` ones of ours. Both run
/// for a moment; a frame that is forwarded in it can be dropped, none passes unjudged. With TCX
/// they must be other programs than those in place.
Result<void> put_gate_first(const Place& place, const GatePrograms& programs,
                            const GatePrograms& former);

/// Ids of the programs of a gate. An error where the kernel does not tell one of them: without it,
/// the gate's own program cannot be distinguished from another one that is to go.
Result<InPlace> ids_of(const GatePrograms& programs);

}  // namespace mlcca::enforce
