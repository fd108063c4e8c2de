// SPDX-License-Identifier: BSD-2-Clause
// The gate of one port, whatever runs on its wire: two programs of ours in its hooks and the memory
// they obey, from being loaded until the interface is gone. Closing the object leaves the gate in
// the kernel as it is.
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

namespace mlcca::enforce {

class PortGate {
 public:
  PortGate(const PortGate&) = delete;
  PortGate& operator=(const PortGate&) = delete;
  PortGate(PortGate&&) noexcept;
  PortGate& operator=(PortGate&&) noexcept;
  virtual ~PortGate();

  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] std::uint32_t ifindex() const;
  /// The slots of the gate that was attached before were taken over: see present().
  [[nodiscard]] bool reused() const;

  /// Puts what was loaded in place, or what another gate of this interface has displaced since: by
  /// replacement where our programs are there already; those that an earlier daemon had in the
  /// other hook go after that. After an error the other gate may have lost its place in part: its
  /// reattach() gives it back.
  Result<void> put();
  /// Both programs are in their places now and are those of this object.
  [[nodiscard]] Result<bool> attached() const;
  /// Neither of them is in its place.
  [[nodiscard]] Result<bool> is_taken_off() const;
  /// Puts the same programs back after another program removed or replaced them; slots and counters
  /// stay.
  Result<void> reattach();
  [[nodiscard]] Hook hook() const;
  /// TCX programs of others that may let frames pass before ours have seen them.
  [[nodiscard]] Result<std::vector<Ahead>> ahead() const;
  /// The gate was marked as that of an interface that has left, which only unpin() may do, so that
  /// everything passes: it judges again. False: it was not marked.
  bool judge_again();
  /// Another program has given the gate to another daemon, or to none, so that it was closed: it is
  /// held by this one again. False: none has.
  bool hold_again();
  /// Puts our programs before all others of their hook; see put_gate_first().
  Result<void> go_first();
  /// Whatever leaves is counted; of Ethernet only what carries events is.
  [[nodiscard]] bool judges_everything() const;

  /// Id of our program for the driver; 0: there is none of this kind of link.
  [[nodiscard]] std::uint32_t early() const;
  /// The driver drops what is refused before anything else sees it.
  [[nodiscard]] bool drops_early() const;
  /// It did, until our program was removed from there. Both filters hold all of it.
  [[nodiscard]] bool lost_early() const;
  /// Where no other program is: see drops_early().
  Result<void> put_early_back();

  /// See Table::apply(); then the timers of what is newly watched.
  Result<void> apply(const SlotChanges& changes);
  [[nodiscard]] std::vector<SlotSpec> present() const;
  [[nodiscard]] std::size_t size() const;
  /// So many slots there can be.
  [[nodiscard]] std::size_t room() const;
  /// The slot is found by a mask, and not by a key or subject.
  [[nodiscard]] bool is_masked(const SlotSpec& spec) const;
  void deny_all();
  /// Unless it is pinned the next daemon begins with another gate, and timers end with this
  /// process. Gives the names of what had to be pinned again; slots and frames are not touched.
  [[nodiscard]] Result<std::vector<std::string>> keep_pinned() const;

  /// Of the slot with this grant (verdict not compared); nothing where there is none.
  [[nodiscard]] std::optional<SlotCounters> counters(const SlotSpec& spec) const;
  /// Number of the slot with this grant, as events name it.
  [[nodiscard]] std::optional<std::uint32_t> number_of(const SlotSpec& spec) const;
  /// The same; nothing if it is not supervised.
  [[nodiscard]] std::optional<std::uint32_t> watched_as(const SlotSpec& spec) const;
  /// How the events of a watched slot have come. `now`: CLOCK_MONOTONIC.
  [[nodiscard]] Arrivals arrivals(std::uint32_t slot, std::uint64_t now) const;
  /// If events of a watched slot are missing that is reported once more.
  [[nodiscard]] Result<void> report_again(std::uint32_t slot) const;
  /// Slots whose events ought to be watched, beyond those that can be.
  [[nodiscard]] std::size_t unwatched() const;
  [[nodiscard]] ReasonCounters reasons(Direction direction) const;
  /// What audit mode has let through, by why it would have been dropped.
  [[nodiscard]] ReasonCounters would_drop(Direction direction) const;
  /// Frames without a slot, newest first.
  [[nodiscard]] std::vector<UnknownFrame> unknown() const;

  /// Removes the pins, not the programs. Of an interface that is gone, to another network
  /// namespace, they go on with it, and let everything pass; of one that is here they stay in
  /// force.
  void unpin();
  /// Removes what is left of a gate that was taken off an interface which is here: its program in
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
  /// See Table: one step for frames on all of them, CAN and Ethernet. They are of one Control.
  static std::expected<void, Refusal> apply_together(std::span<const Change> changes);

 protected:
  struct Config {
    std::uint32_t ifindex = 0;
    std::string name;  ///< for error texts
    std::optional<Hook> hook;
  };

  /// All that takes memory: nothing is pinned or attached before put(). The slots and counters of
  /// what is attached now are taken over when they are of this kind, the slots alone where it is
  /// too small; otherwise the gate starts without slots, so that nothing stale passes. Pins live in
  /// `control.directory()`/if<ifindex>. Acts in the calling thread's network namespace.
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
  [[nodiscard]] const Table& table() const;
  Result<void> arm_what_is_new();
  std::unique_ptr<State> state_;
};

}  // namespace mlcca::enforce
