// SPDX-License-Identifier: BSD-2-Clause
// The slots of one CAN interface, edited in memory that the gate program reads at the same time.
// Pure pointer logic on any gate_table, so it is tested without a kernel.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "bpf/gate.h"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/gates/table.hpp"

namespace mlcca::gates {

/// The table of a CAN gate: chains of slots by key.
class SlotTable final : public VerdictTable {
 public:
  /// The table, its counters, and the generation of the verdicts (in gate_control). Tables that
  /// share a generation must be changed by one thread.
  struct Memory {
    gate_table& table;
    std::span<gate_cpu> cpus;
    std::uint32_t& generation;
  };

  /// Adopts the table as it is. `fresh`: no program can have seen its slots; otherwise free slots
  /// are reused only after a grace period. Errors: another layout or profile, broken chains.
  static Result<SlotTable> read(const Memory& memory, std::uint32_t profile, bool fresh,
                                GracePeriod wait);
  /// For reading only: slots may be in chains to which their identifiers do not lead.
  static Result<SlotTable> read_as_found(const Memory& memory, std::uint32_t profile);

  // Errors of apply(): a slot that has no key in this profile, is present twice or not at all; more
  // than GATE_SLOTS - 2 slots, GATE_CHAIN of one key, GATE_WALK of one bucket, or GATE_WALK masked
  // ones of one direction.

  [[nodiscard]] std::vector<SlotSpec> present() const override;
  [[nodiscard]] std::size_t size() const override { return used_; }
  [[nodiscard]] std::size_t room() const override { return GATE_SLOTS - GATE_FIRST_SLOT; }
  [[nodiscard]] bool is_masked(const SlotSpec& spec) const override;
  [[nodiscard]] std::optional<std::uint32_t> find(const SlotSpec& spec) const override;
  [[nodiscard]] std::vector<std::uint16_t> watched() const override;
  /// Each slot has its own watch.
  [[nodiscard]] std::uint16_t watch_of(std::uint32_t slot) const override;

 private:
  SlotTable(const Memory& memory, std::uint32_t profile, GracePeriod wait);

  static Result<SlotTable> read(const Memory& memory, std::uint32_t profile, bool fresh,
                                bool as_found, GracePeriod wait);
  Result<void> adopt(bool fresh, bool as_found);
  [[nodiscard]] Result<void> check(const SlotChanges& changes) const override;
  [[nodiscard]] Result<void> check_room(const SlotChanges& changes) const;
  [[nodiscard]] bool fits_at_once(const SlotChanges& changes) const override;
  Result<void> reclaim(const SlotChanges& changes) override;
  void put_what_comes(const SlotChanges& changes) override;
  void remove_what_goes(const SlotChanges& changes) override;
  [[nodiscard]] std::uint8_t* verdicts(std::uint32_t slot) const override {
    return table_->slots[slot].verdict;
  }
  [[nodiscard]] std::uint32_t slots_end() const override { return GATE_SLOTS; }
  void forget_events(std::uint32_t slot) override;
  [[nodiscard]] std::uint16_t supervised_watch(std::uint32_t slot) const override;
  void link(const SlotSpec& spec);
  void unlink(const SlotSpec& spec);
  void set_traffic(const SlotSpec& spec);
  /// Calls `use` with the direction, the bucket (GATE_NO_BUCKET: the masked slots) and the first
  /// slot of every chain that is not empty.
  template <class Use>
  void for_each_chain(const Use& use) const;
  [[nodiscard]] std::uint16_t* head(const SlotSpec& spec) const;
  [[nodiscard]] std::vector<std::uint16_t> chain(const SlotSpec& spec) const;
  [[nodiscard]] SlotSpec spec_of(std::uint16_t slot, Direction direction) const;

  gate_table* table_;
  std::span<gate_cpu> cpus_;
  std::uint32_t profile_;
  GracePeriod wait_;
  std::size_t used_ = 0;
  std::vector<std::uint16_t> free_;        ///< no program can read them
  std::vector<std::uint16_t> quarantine_;  ///< a running program may still read them
};

}  // namespace mlcca::gates
