// SPDX-License-Identifier: BSD-2-Clause
// The gate of one port, whatever link it has: two programs in the hooks of the interface and the
// memory that they obey, from loading until the interface is gone. Destroying the object leaves the
// gate in the kernel as it is.
#pragma once
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/attachment.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/gate_kind.hpp"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/gates/table.hpp"
#include "daemon/gates/watches.hpp"

namespace mlcca::gates {

class PortGate {
 public:
  PortGate(const PortGate&) = delete;
  PortGate& operator=(const PortGate&) = delete;
  PortGate(PortGate&&) noexcept;
  PortGate& operator=(PortGate&&) noexcept;
  virtual ~PortGate();

  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] std::uint32_t ifindex() const;
  /// Whether the slots of the gate that was attached before were taken over: see present().
  [[nodiscard]] bool reused() const;

  /// Puts the loaded gate in place, or puts it back if another gate of this interface has replaced
  /// it since. Replaces programs of ours that are there; then removes those that an earlier daemon
  /// had in the other hook. After an error the other gate may have partly lost its place; its
  /// reattach() restores it.
  Result<void> put();
  /// Whether both programs of this object are in their places.
  [[nodiscard]] Result<bool> attached() const;
  /// Whether neither of them is in its place.
  [[nodiscard]] Result<bool> is_taken_off() const;
  /// Puts the programs back after another program has removed or replaced them. Slots and counters
  /// stay.
  Result<void> reattach();
  [[nodiscard]] Hook hook() const;
  /// TCX programs of others that may let frames pass before our programs see them.
  [[nodiscard]] Result<std::vector<Ahead>> ahead() const;
  /// Undoes the mark of a gate whose interface has left, which lets everything pass and which only
  /// unpin() may set. False if the gate was not marked.
  bool judge_again();
  /// Takes the gate back after another program has given it to another daemon, or to none, so that
  /// it was closed. False if none has.
  bool hold_again();
  /// Puts our programs before all others of their hook; see put_gate_first().
  Result<void> go_first();
  /// Whether all frames that leave are counted. An Ethernet gate counts only those that carry
  /// events.
  [[nodiscard]] bool judges_everything() const;

  /// The id of our XDP program; 0 if this kind of link has none.
  [[nodiscard]] std::uint32_t early() const;
  /// Whether the driver drops what is refused, before anything else sees it.
  [[nodiscard]] bool drops_early() const;
  /// Whether our XDP program was in the driver and has been removed. The filters still enforce
  /// everything.
  [[nodiscard]] bool lost_early() const;
  /// Puts the XDP program back if no other program is there: see drops_early().
  Result<void> put_early_back();

  /// See VerdictTable::apply(). Then arms the timers of newly watched slots.
  Result<void> apply(const SlotChanges& changes);
  [[nodiscard]] std::vector<SlotSpec> present() const;
  [[nodiscard]] std::size_t size() const;
  /// The most slots that there can be.
  [[nodiscard]] std::size_t room() const;
  /// Whether the slot is found by a mask, not by a key or subject.
  [[nodiscard]] bool is_masked(const SlotSpec& spec) const;
  void deny_all();
  /// Pins again what has lost its pin, and returns the names. Without pins the next daemon would
  /// start with another gate, and timers would end with this process. Slots and frames are not
  /// touched.
  [[nodiscard]] Result<std::vector<std::string>> keep_pinned() const;

  /// The counters of the slot with this grant (the verdict is not compared); nullopt if there is
  /// none.
  [[nodiscard]] std::optional<SlotCounters> counters(const SlotSpec& spec) const;
  /// The number of the slot with this grant, as events state it; nullopt if there is none.
  [[nodiscard]] std::optional<std::uint32_t> number_of(const SlotSpec& spec) const;
  /// The same; nullopt also if the slot is not supervised.
  [[nodiscard]] std::optional<std::uint32_t> watched_as(const SlotSpec& spec) const;
  /// How the events of a watched slot have come. `now`: CLOCK_MONOTONIC, ns.
  [[nodiscard]] Arrivals arrivals(std::uint32_t slot, std::uint64_t now) const;
  /// If events of a watched slot are missing, makes the kernel report it once more.
  [[nodiscard]] Result<void> report_again(std::uint32_t slot) const;
  /// The number of slots that should be watched but have no watch.
  [[nodiscard]] std::size_t unwatched() const;
  /// The counters of the frames of a direction that were refused and belong to no slot.
  [[nodiscard]] SlotCounters without_slot(Direction direction) const;
  [[nodiscard]] ReasonCounters reasons(Direction direction) const;
  /// Frames that passed in audit mode, by the reason for which they would have been dropped.
  [[nodiscard]] ReasonCounters would_drop(Direction direction) const;
  /// The frames without a slot, the newest first.
  [[nodiscard]] std::vector<UnknownFrame> unknown() const;
  /// The senders of refused frames; see gates::refused_senders().
  [[nodiscard]] std::vector<RefusedSender> refused_senders() const;

  /// Removes the pins, not the programs. On an interface that has gone to another network
  /// namespace, the programs stay with it and let everything pass. On one that is here they stay in
  /// force.
  void unpin();
  /// Removes what is left of a gate that was taken off an interface that is here: its program in
  /// the driver, and the pins.
  void give_up();

  struct Change {
    PortGate* gate;
    SlotChanges changes;
  };
  struct Refusal {
    PortGate* gate;
    Error error;
  };
  /// See VerdictTable::apply_together(): one step for frames on all gates, CAN and Ethernet. All
  /// must have the same Control.
  static std::expected<void, Refusal> apply_together(std::span<const Change> changes);

 protected:
  struct Config {
    std::uint32_t ifindex = 0;
    std::string name;  ///< for error texts
    std::optional<Hook> hook;
  };

  /// Does everything that takes memory; nothing is pinned or attached before put(). Takes over
  /// slots and counters of the attached gate if that is of this kind, and only the slots if its
  /// maps are too small. Otherwise the gate starts without slots, so that no stale grant passes.
  /// Pins are in `control.directory()`/if<ifindex>. Acts in the network namespace of the calling
  /// thread.
  static Result<PortGate> load(const Config& config, GateKind& kind, const Control& control);
  template <class Gate>
  static Result<Gate> put_new(Result<Gate> gate) {
    if (!gate) return gate;
    if (auto put = gate->put(); !put) return std::unexpected(put.error());
    return gate;
  }
  [[nodiscard]] const GateObject& object() const;

 private:
  struct State;
  explicit PortGate(std::unique_ptr<State> state);
  [[nodiscard]] const VerdictTable& table() const;
  Result<void> arm_what_is_new();
  std::unique_ptr<State> state_;
};

}  // namespace mlcca::gates
