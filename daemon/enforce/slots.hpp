// SPDX-License-Identifier: BSD-2-Clause
// The slots of one interface, edited in the memory that the gate program reads at the same time.
// Pure pointer logic: works on any gate_table, so that it is tested without a kernel.
#pragma once
#include <cstdint>
#include <expected>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "bpf/gate.h"
#include "core/result.hpp"

namespace mlcca::enforce {

enum class Direction : std::uint8_t { ingress = GATE_INGRESS, egress = GATE_EGRESS };

/// What one slot admits. A frame fits when (can_id & mask) == id, with the flags of <linux/can.h>.
/// Its key is what the profile makes the subject: gate_key_mask().
struct SlotSpec {
  Direction direction = Direction::ingress;
  bool pass = false;
  std::uint16_t max_len = 8;            ///< payload bytes
  std::uint8_t formats = GATE_CLASSIC;  ///< GATE_CLASSIC | GATE_FD | GATE_XL; Ethernet: ETHER_*
  std::uint32_t id = 0;                 ///< with CAN_EFF_FLAG for 29 bits
  std::uint32_t mask = 0;               ///< has CAN_EFF_FLAG and the key (a masked slot: a part of
                                        ///< it); RTR unless declared
  std::uint32_t source = 0;             ///< egress: ifindex it entered by, 0: a local program,
                                        ///< GATE_NO_SOURCE: the kernel itself
  std::uint32_t uid = GATE_ANY_UID;     ///< local program's user
  std::uint64_t subject = 0;
  // How much passes, see gate_slot; all 0: not policed.
  std::uint64_t per_frame = 0;
  std::uint64_t per_byte = 0;
  std::uint64_t tolerance = 0;
  bool excess_passes = false;
  // How its events are expected, see gate_watch; all 0: nobody looks.
  std::uint64_t period = 0;  ///< at most GATE_LONGEST_PERIOD
  std::uint64_t silence = 0;
  std::uint64_t together = 0;

  bool operator==(const SlotSpec&) const = default;
  /// The same traffic is admitted and expected.
  [[nodiscard]] bool same_traffic(const SlotSpec& other) const;
  /// Equal but for the verdict and the traffic.
  [[nodiscard]] bool same_grant(const SlotSpec& other) const;
};

/// Changes of one interface. `close`, `remove` and `open` name slots by everything but the verdict
/// and the traffic.
struct SlotChanges {
  std::vector<SlotSpec> close;
  std::vector<SlotSpec> add;  ///< opened at the end where `pass` is set
  std::vector<SlotSpec> remove;
  std::vector<SlotSpec> open;
  std::vector<SlotSpec> police;  ///< slots that stay, with the traffic that they get

  [[nodiscard]] bool empty() const {
    return close.empty() && add.empty() && remove.empty() && open.empty() && police.empty();
  }
};

/// What turns `present` into `wanted`. Slots that are in both with one verdict are not mentioned.
/// A passing slot that goes without a passing successor (same direction, subject, identifier and
/// source) is closed before anything opens; one with a successor stays until that has opened.
SlotChanges difference(std::span<const SlotSpec> present, std::span<const SlotSpec> wanted);

/// Waits until no CPU runs a program that began before the call (one RCU grace period).
using GracePeriod = std::function<Result<void>()>;

class SlotTable {
 public:
  /// The table, and where the generation of the verdicts stands (gate_control). Several tables may
  /// share one, and must then be changed by one thread.
  struct Memory {
    gate_table& table;
    std::span<gate_cpu> cpus;
    std::uint32_t& generation;
  };

  /// Takes the table as it is. `fresh`: no program can have seen its slots; otherwise free slots
  /// are reused only after a grace period. Errors: another layout or profile, broken chains.
  static Result<SlotTable> read(const Memory& memory, std::uint32_t profile, bool fresh,
                                GracePeriod wait);

  /// All or nothing, and for a frame all at once: every decision is by the verdicts before the call
  /// or by those after it. After an error nothing was changed, unless waiting for the grace period
  /// failed; then what goes is denied. Where a table is too full to hold old and new slots side by
  /// side there are two steps: what goes is denied and removed, and then comes what is new.
  /// What is policed changes word by word, before the verdicts. A channel that is not mentioned is
  /// not touched. Errors: a slot that the profile has no key for, is there twice or is not there;
  /// more than GATE_SLOTS - 2 slots, GATE_CHAIN of one key, GATE_WALK of one bucket, GATE_WALK
  /// masked ones of one direction. May wait for one grace period (some 10 ms), when only lately
  /// removed slots are free.
  Result<void> apply(const SlotChanges& changes);

  struct Change {
    SlotTable* table;
    const SlotChanges* changes;
  };
  struct Refusal {
    std::size_t change;  ///< which one
    Error error;
  };
  /// As apply(), of tables with one generation, each mentioned once.
  static std::expected<void, Refusal> apply_together(std::span<const Change> changes);

  /// What the kernel obeys now.
  [[nodiscard]] std::vector<SlotSpec> present() const;
  [[nodiscard]] std::size_t size() const { return used_; }
  /// Whether the slot is found by its mask, and not by its key.
  [[nodiscard]] bool is_masked(const SlotSpec& spec) const;
  /// Number of the slot with this grant.
  [[nodiscard]] std::optional<std::uint16_t> find(const SlotSpec& spec) const;

  /// Every verdict deny; the slots stay.
  void deny_all();

  /// Slots that pass and whose silence matters: all of them, or those of which that was changed
  /// since the last call.
  [[nodiscard]] std::vector<std::uint16_t> watched() const;
  [[nodiscard]] std::vector<std::uint16_t> take_newly_watched();

 private:
  SlotTable(const Memory& memory, std::uint32_t profile, GracePeriod wait);

  Result<void> adopt(bool fresh);
  [[nodiscard]] Result<void> check(const SlotChanges& changes) const;
  [[nodiscard]] Result<void> check_room(const SlotChanges& changes) const;
  [[nodiscard]] bool fits_at_once(const SlotChanges& changes) const;
  Result<void> reclaim(std::size_t wanted);
  void link(const SlotSpec& spec);
  void unlink(const SlotSpec& spec);
  /// From the next generation on.
  void stage(std::uint16_t slot, gate_verdict verdict);
  void stage(const SlotSpec& spec, gate_verdict verdict);
  void stage_what_goes(const SlotChanges& changes);
  static void deny_what_goes(std::span<const Change> changes);
  /// The next generation is there: nobody reads the other half of what was staged.
  void settle();
  void next_generation();
  void set_traffic(const SlotSpec& spec);
  [[nodiscard]] bool is_watched(std::uint16_t slot) const;
  /// Calls `use` with the direction, the bucket (GATE_NO_BUCKET: the masked slots) and the first
  /// slot of every chain that is not empty.
  template <class Use>
  void for_each_chain(const Use& use) const;
  [[nodiscard]] std::uint16_t* head(const SlotSpec& spec) const;
  [[nodiscard]] std::vector<std::uint16_t> chain(const SlotSpec& spec) const;
  [[nodiscard]] SlotSpec spec_of(std::uint16_t slot, Direction direction) const;

  struct Staged {
    std::uint16_t slot;
    std::uint8_t verdict;
  };

  gate_table* table_;
  std::span<gate_cpu> cpus_;
  std::uint32_t* generation_;
  std::vector<Staged> staged_;
  std::uint32_t profile_;
  GracePeriod wait_;
  std::size_t used_ = 0;
  std::vector<std::uint16_t> free_;        ///< no program can hold them
  std::vector<std::uint16_t> quarantine_;  ///< a running program may still look at them
  std::set<std::uint16_t> newly_watched_;
};

}  // namespace mlcca::enforce
