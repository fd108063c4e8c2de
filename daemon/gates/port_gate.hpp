// SPDX-License-Identifier: BSD-2-Clause
// The gate of one port, whatever runs on its wire.
#pragma once
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/attachment.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/gates/table.hpp"
#include "daemon/gates/watches.hpp"

namespace mlcca::enforce {

class PortGate {
 public:
  PortGate() = default;
  PortGate(const PortGate&) = delete;
  PortGate& operator=(const PortGate&) = delete;
  PortGate(PortGate&&) = default;
  PortGate& operator=(PortGate&&) = default;
  virtual ~PortGate() = default;

  [[nodiscard]] virtual const std::string& name() const = 0;
  [[nodiscard]] virtual std::uint32_t ifindex() const = 0;
  /// Puts what was loaded in place, or what another gate of this interface has displaced since; by
  /// replacement, like attach(). After an error the other one may have lost its place in part: its
  /// reattach() gives it back.
  virtual Result<void> put() = 0;
  /// Both filters are there now and are the programs of this object.
  [[nodiscard]] virtual Result<bool> attached() const = 0;
  /// Puts the same programs back after somebody removed or replaced them; slots and counters stay.
  virtual Result<void> reattach() = 0;
  [[nodiscard]] virtual Hook hook() const = 0;
  /// TCX programs of others that may let frames pass before ours have seen them.
  [[nodiscard]] virtual Result<std::vector<Ahead>> ahead() const = 0;
  /// Somebody has told the gate that its interface has left, for which unpin() is there, so that
  /// everything passes: it judges again. False: nobody has.
  virtual bool judge_again() = 0;
  /// Puts our programs before all others of their hook; see enforce::put_first().
  virtual Result<void> go_first() = 0;
  /// Whatever leaves is counted; of Ethernet only what carries events is.
  [[nodiscard]] virtual bool judges_everything() const { return true; }
  /// Id of our program for the driver; 0: there is none of this kind of link.
  [[nodiscard]] virtual std::uint32_t early() const { return 0; }
  /// The driver drops what is refused before anything else sees it.
  [[nodiscard]] virtual bool drops_early() const { return false; }
  /// It did, until somebody took our program away from there. Both filters hold all of it.
  [[nodiscard]] virtual bool lost_early() const { return false; }
  /// Where nobody else's program is: see drops_early().
  virtual Result<void> put_early_back() { return {}; }

  /// See Table::apply(); then the timers of what is newly watched.
  Result<void> apply(const SlotChanges& changes);
  [[nodiscard]] virtual std::vector<SlotSpec> present() const = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// So many slots there can be.
  [[nodiscard]] virtual std::size_t room() const = 0;
  /// The slot is found by a mask, and not by a key or subject.
  [[nodiscard]] virtual bool is_masked(const SlotSpec& /*spec*/) const { return false; }
  virtual void deny_all() = 0;
  /// Unless it is pinned the next daemon begins with another gate, and timers end with this
  /// process. Gives the names of what had to be pinned again; slots and frames are not touched.
  [[nodiscard]] virtual Result<std::vector<std::string>> keep_pinned() const = 0;

  /// Of the slot with this grant (verdict not compared); nothing where there is none.
  [[nodiscard]] virtual std::optional<SlotCounters> counters(const SlotSpec& spec) const = 0;
  /// The slot with this grant, by the number that events name it by; nothing where nobody looks.
  [[nodiscard]] virtual std::optional<std::uint32_t> watched_as(const SlotSpec& spec) const = 0;
  /// How the events of a watched slot have come. `now`: CLOCK_MONOTONIC.
  [[nodiscard]] virtual Arrivals arrivals(std::uint32_t slot, std::uint64_t now) const = 0;
  /// If events of a watched slot are missing that is told once more.
  [[nodiscard]] virtual Result<void> tell_again(std::uint32_t slot) const = 0;
  /// Slots whose events ought to be watched, beyond those that can be.
  [[nodiscard]] virtual std::size_t unwatched() const { return 0; }
  [[nodiscard]] virtual ReasonCounters reasons(Direction direction) const = 0;
  /// What audit mode has let through, by why it would have been dropped.
  [[nodiscard]] virtual ReasonCounters would_drop(Direction direction) const = 0;
  /// Frames without a slot, newest first.
  [[nodiscard]] virtual std::vector<UnknownFrame> unknown() const = 0;

  /// Removes the pins, not the filters: for an interface that is gone.
  virtual void unpin() = 0;

  struct Change {
    PortGate* gate;
    SlotChanges changes;
  };
  struct Refusal {
    PortGate* gate;
    Error error;
  };
  /// See Table: one step for frames on all of them, CAN and Ethernet. They are of one Control.
  static std::expected<void, Refusal> apply_together(std::span<const Change> changes);

 protected:
  [[nodiscard]] virtual Table& table() = 0;
  /// Starts the timer of a watch.
  [[nodiscard]] virtual Result<void> arm(std::uint16_t watch) const = 0;

 private:
  Result<void> arm_what_is_new();
};

}  // namespace mlcca::enforce
