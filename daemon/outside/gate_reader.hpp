// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "bpf/gate.h"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "core/gates/plan.hpp"
#include "daemon/gates/bindings.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/outside/frames.hpp"
#include "daemon/outside/port_facts.hpp"

namespace mlcca {

/// What the gates of a gateway hold, and what they have counted.
class GateReader : public PortFacts {
 public:
  /// The slots of the gates for these rules, in the order of the rules.
  [[nodiscard]] virtual std::vector<gates::PlacedSlot> slots(
      std::span<const core::GateRule> rules) const = 0;
  /// The frames that came in and left by these rules. A frame that leaves is counted once: where it
  /// leaves; or, if that entry is among those `shared` with others, where it came in.
  [[nodiscard]] virtual Frames frames(const core::GateState& rules,
                                      const std::vector<core::GateEntry>& shared) const = 0;
  [[nodiscard]] Frames frames(const core::GateState& rules) const { return frames(rules, {}); }
  /// How the events of a delivery come to the slot by which they enter; nullopt if they are not
  /// watched.
  [[nodiscard]] virtual std::optional<control::Watch> watch(const core::GateState& rules) const = 0;
  /// If events of a delivery are missing, makes the kernel report it once more, for a client that
  /// has not received the report.
  [[nodiscard]] virtual Result<void> report_again(const core::GateState& rules) const = 0;
  /// Whether the event is of the slot of one of these rules.
  [[nodiscard]] virtual bool is_of(const gate_event& event, const core::GateState& rules) const = 0;
  /// The contents of the slots of all gates, for `mlccactl gate`. `place` is an interface or a
  /// network; empty: all.
  [[nodiscard]] virtual control::Gates gates(const core::State& state,
                                             const std::string& place) const = 0;
  /// The interfaces and networks that have gates, in words.
  [[nodiscard]] virtual std::string gated_places() const = 0;
  /// The number of slots of all gates.
  [[nodiscard]] virtual std::size_t slot_count() const = 0;

  /// Whether an interface that must have a gate has none that this daemon commands. Then everything
  /// must be closed.
  [[nodiscard]] virtual bool out_of_hand() const = 0;
  /// Why it is unknown whether gates without pins are left; empty if it is known.
  [[nodiscard]] virtual const std::string& orphans_unknown() const = 0;
  /// Interfaces that have a gate but are not described, or have no profile. They are closed.
  [[nodiscard]] virtual std::vector<std::string> undescribed() const = 0;

  // Of the gate of one port:

  /// The count of frames without a slot on a port.
  [[nodiscard]] virtual UnknownFrames unknown_frames(std::size_t port) const = 0;
  /// The latest of these frames, each kind with a lower bound of its count.
  [[nodiscard]] virtual std::vector<gates::UnknownFrame> seen_unknown(std::size_t port) const = 0;
  /// The latest senders whose frames a port has refused: slots of it, or the port because they
  /// belong to no slot.
  [[nodiscard]] virtual std::vector<gates::RefusedSender> refused_senders(
      std::size_t port) const = 0;
  /// The number of the slot of an entry, as in these senders; nullopt if it has none.
  [[nodiscard]] virtual std::optional<std::uint32_t> slot_number(
      const core::GateEntry& entry) const = 0;
  /// The frames that were refused for reasons that concern no slot.
  [[nodiscard]] virtual std::vector<Refusals> refusals(std::size_t port) const = 0;
  /// What was refused and belongs to no slot, in both directions. `all` of a gate never decreases;
  /// `parts` may, by frames that come while it is read.
  [[nodiscard]] virtual std::vector<WithoutSlot> without_slot(std::size_t port) const = 0;
  /// The refused frames of all slots of a port by reason, without excess. Frames of no slot may be
  /// among them.
  [[nodiscard]] virtual std::vector<Refusals> misfits(std::size_t port) const = 0;
  /// The latest frame without a slot that came in, for example "123" or "0x4e6f626f64790000 from
  /// 10.0.0.7".
  [[nodiscard]] virtual std::string latest_unknown(std::size_t port) const = 0;
  /// FAMOUSO's tags in the gate of a port; nullopt if no gate there holds any.
  [[nodiscard]] virtual std::optional<gates::Bindings> bindings(std::size_t port) const = 0;
};

}  // namespace mlcca
