// SPDX-License-Identifier: BSD-2-Clause
// The slots of one interface, and how the slots of several interfaces change in one step for frames
// (ADR 20).
#pragma once
#include <cstdint>
#include <expected>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/slot_spec.hpp"

namespace mlcca::gates {

/// The base of the tables of both kinds of gate. Derived classes know the memory; this class has
/// the order of the steps: write the verdicts of the next generation, switch the generation, write
/// the other verdicts.
class VerdictTable {
 public:
  VerdictTable(VerdictTable&&) = default;
  VerdictTable& operator=(VerdictTable&&) = default;
  VerdictTable(const VerdictTable&) = default;
  VerdictTable& operator=(const VerdictTable&) = default;
  virtual ~VerdictTable() = default;

  /// Makes all changes or none, and for a frame all at once: each decision uses either the verdicts
  /// before or those after the call. After an error nothing has changed, unless waiting for the
  /// grace period failed; then what goes is denied. If a table is too full to hold old and new
  /// slots side by side there are two steps: what goes is denied and removed, then what is new
  /// comes.
  /// Policing changes word by word, before the verdicts. Slots that are not mentioned are not
  /// touched. May wait for one grace period (about 10 ms) if only recently removed slots are free.
  Result<void> apply(const SlotChanges& changes);

  struct Change {
    VerdictTable* table;
    const SlotChanges* changes;
  };
  struct Refusal {
    std::size_t change;  ///< index of the refused change
    Error error;
  };
  /// As apply(), for tables of any kind that share a generation, each mentioned once.
  static std::expected<void, Refusal> apply_together(std::span<const Change> changes);

  /// The slots that the kernel obeys now.
  [[nodiscard]] virtual std::vector<SlotSpec> present() const = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// The most slots that there can be.
  [[nodiscard]] virtual std::size_t room() const = 0;
  /// The number of the slot with this grant; nullopt if there is none.
  [[nodiscard]] virtual std::optional<std::uint32_t> find(const SlotSpec& spec) const = 0;
  /// Whether the slot is found by a mask, not by a key or subject.
  [[nodiscard]] virtual bool is_masked(const SlotSpec& /*spec*/) const { return false; }
  /// Sets every verdict to deny. The slots stay.
  void deny_all();

  /// The watches of slots that pass and whose silence is supervised: all of them, or those that
  /// have changed since the last call.
  [[nodiscard]] virtual std::vector<std::uint16_t> watched() const = 0;
  [[nodiscard]] std::vector<std::uint16_t> take_newly_watched();
  /// The number of the watch of a slot; 0 if it has none.
  [[nodiscard]] virtual std::uint16_t watch_of(std::uint32_t slot) const = 0;
  /// The number of slots that should be watched but have no watch.
  [[nodiscard]] virtual std::size_t unwatched() const { return 0; }

 protected:
  /// `generation` is that of the verdicts (in gate_control). Tables that share one are changed by
  /// one thread.
  explicit VerdictTable(std::uint32_t& generation) : generation_(&generation) {}

  [[nodiscard]] bool passes(std::uint32_t slot) const;
  /// Reverts what was written for the next generation: its writer may have died before the step.
  void undo_step(std::uint32_t slot) const;
  /// Notes that the timer of a slot is to start, if its events can come and their absence is
  /// supervised.
  void note_watched(std::uint32_t slot);
  void forget_watched(std::uint16_t watch) { newly_watched_.erase(watch); }

 private:
  struct Staged {
    std::uint32_t slot;
    std::uint8_t verdict;
  };

  /// Checks that the changes are valid, and that there is room for the result.
  [[nodiscard]] virtual Result<void> check(const SlotChanges& changes) const = 0;
  /// Whether old and new slots fit side by side, so that a new slot opens before the old one goes.
  [[nodiscard]] virtual bool fits_at_once(const SlotChanges& changes) const = 0;
  /// Makes room for new slots. May wait for a grace period.
  virtual Result<void> reclaim(const SlotChanges& changes) = 0;
  /// Adds new slots, denied, and sets the traffic of those that stay.
  virtual void put_what_comes(const SlotChanges& changes) = 0;
  /// Removes those slots to be removed that are present. They are denied already.
  virtual void remove_what_goes(const SlotChanges& changes) = 0;
  /// The two verdicts of a slot, for even and odd generations.
  [[nodiscard]] virtual std::uint8_t* verdicts(std::uint32_t slot) const = 0;
  [[nodiscard]] virtual std::uint32_t slots_end() const = 0;
  /// Forgets the events of a slot that opens.
  virtual void forget_events(std::uint32_t slot) = 0;
  /// Gives free watches to slots that wait for one.
  virtual void watch_what_waits() {}
  /// The watch of a slot if its silence is supervised; otherwise 0.
  [[nodiscard]] virtual std::uint16_t supervised_watch(std::uint32_t slot) const = 0;

  /// Writes a verdict for the next generation.
  void stage(std::uint32_t slot, std::uint8_t verdict);
  void stage(const std::vector<SlotSpec>& specs, std::uint8_t verdict);
  void stage_what_goes(const SlotChanges& changes);
  void stage_what_comes(const SlotChanges& changes);
  static void deny_what_goes(std::span<const Change> changes);
  void next_generation();
  /// After the step to the next generation: no program reads the other half of the staged verdicts,
  /// so they are written too.
  void write_other_half();

  std::uint32_t* generation_;
  std::vector<Staged> staged_;
  std::set<std::uint16_t> newly_watched_;
};

}  // namespace mlcca::gates
