// SPDX-License-Identifier: BSD-2-Clause
// The slots of one interface, and how those of several change in one step for frames (ADR 20).
#pragma once
#include <cstdint>
#include <expected>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/slot_spec.hpp"

namespace mlcca::enforce {

class Table {
 public:
  Table(Table&&) = default;
  Table& operator=(Table&&) = default;
  Table(const Table&) = default;
  Table& operator=(const Table&) = default;
  virtual ~Table() = default;

  /// All or nothing, and for a frame all at once: every decision is by the verdicts before the call
  /// or by those after it. After an error nothing was changed, unless waiting for the grace period
  /// failed; then what goes is denied. Where a table is too full to hold old and new slots side by
  /// side there are two steps: what goes is denied and removed, and then comes what is new.
  /// What is policed changes word by word, before the verdicts. A channel that is not mentioned is
  /// not touched. May wait for one grace period (some 10 ms), when only lately removed slots are
  /// free.
  Result<void> apply(const SlotChanges& changes);

  struct Change {
    Table* table;
    const SlotChanges* changes;
  };
  struct Refusal {
    std::size_t change;  ///< which one
    Error error;
  };
  /// As apply(), of tables of any kind with one generation, each mentioned once.
  static std::expected<void, Refusal> apply_together(std::span<const Change> changes);

  /// What the kernel obeys now.
  [[nodiscard]] virtual std::vector<SlotSpec> present() const = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// So many slots there can be.
  [[nodiscard]] virtual std::size_t room() const = 0;
  /// Number of the slot with this grant.
  [[nodiscard]] virtual std::optional<std::uint32_t> find(const SlotSpec& spec) const = 0;
  /// The slot is found by a mask, and not by a key or subject.
  [[nodiscard]] virtual bool is_masked(const SlotSpec& /*spec*/) const { return false; }
  /// Every verdict deny; the slots stay.
  void deny_all();

  /// Watches of slots that pass and whose silence matters: all of them, or those of which that was
  /// changed since the last call.
  [[nodiscard]] virtual std::vector<std::uint16_t> watched() const = 0;
  [[nodiscard]] std::vector<std::uint16_t> take_newly_watched();
  /// Number of the watch of a slot; 0: not supervised.
  [[nodiscard]] virtual std::uint16_t watch_of(std::uint32_t slot) const = 0;
  /// Slots whose events ought to be watched, beyond those that can be.
  [[nodiscard]] virtual std::size_t unwatched() const { return 0; }

 protected:
  /// `generation`: of the verdicts (gate_control). Tables that share one are changed by one thread.
  explicit Table(std::uint32_t& generation) : generation_(&generation) {}

  [[nodiscard]] bool passes(std::uint32_t slot) const;
  /// Whoever wrote the slot may have ended halfway to the next generation.
  void undo_step(std::uint32_t slot) const;
  /// If events of the slot can come and their absence is supervised, its timer is to start.
  void note_watched(std::uint32_t slot);
  void forget_watched(std::uint16_t watch) { newly_watched_.erase(watch); }

 private:
  struct Staged {
    std::uint32_t slot;
    std::uint8_t verdict;
  };

  /// Nothing is wrong with the changes, and there is room for what is there after them.
  [[nodiscard]] virtual Result<void> check(const SlotChanges& changes) const = 0;
  /// Old and new slots have room side by side, so that a successor opens before its forerunner
  /// goes.
  [[nodiscard]] virtual bool fits_at_once(const SlotChanges& changes) const = 0;
  /// Makes room for what comes.
  virtual Result<void> reclaim(const SlotChanges& changes) = 0;
  /// Adds slots that are denied, and polices those that stay.
  virtual void put_what_comes(const SlotChanges& changes) = 0;
  /// What is there of the slots to be removed, which are denied.
  virtual void remove_what_goes(const SlotChanges& changes) = 0;
  /// The two halves of a slot's verdict.
  [[nodiscard]] virtual std::uint8_t* verdicts(std::uint32_t slot) const = 0;
  [[nodiscard]] virtual std::uint32_t slots_end() const = 0;
  /// A slot that opens has had no events yet.
  virtual void forget_events(std::uint32_t slot) = 0;
  /// What waits for a watch gets one that was left.
  virtual void watch_what_waits() {}
  /// Its watch, if silence is supervised; otherwise 0.
  [[nodiscard]] virtual std::uint16_t supervised_watch(std::uint32_t slot) const = 0;

  /// From the next generation on.
  void stage(std::uint32_t slot, std::uint8_t verdict);
  void stage(const std::vector<SlotSpec>& specs, std::uint8_t verdict);
  void stage_what_goes(const SlotChanges& changes);
  void stage_what_comes(const SlotChanges& changes);
  static void deny_what_goes(std::span<const Change> changes);
  void next_generation();
  /// The next generation is there: no program reads the other half of what was staged.
  void settle();

  std::uint32_t* generation_;
  std::vector<Staged> staged_;
  std::set<std::uint16_t> newly_watched_;
};

}  // namespace mlcca::enforce
