// SPDX-License-Identifier: BSD-2-Clause
// The subjects of one Ethernet-like interface, edited in memory that the gate program reads at the
// same time. Pure pointer logic, as SlotTable: tested without a kernel.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "bpf/ether.h"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/gates/table.hpp"

namespace mlcca::gates {

/// The sizes of the maps of an interface.
struct EtherSizes {
  std::uint32_t slots = ETHER_MIN_SLOTS;
  std::uint32_t buckets = ETHER_MIN_SLOTS;  ///< a power of two
  std::uint32_t contracts = ETHER_MIN_SLOTS;
  std::uint32_t banks = 1;  ///< banks of counters

  /// Entries of the prefilter map. A table that needs none has one entry, which nothing reads.
  [[nodiscard]] std::uint32_t prefilters() const {
    return has_prefilter() ? buckets / ETHER_PREFILTER_BUCKETS : 1;
  }
  [[nodiscard]] bool has_prefilter() const { return slots > ETHER_PREFILTERED_SLOTS; }

  /// The sizes for that many subjects, between ETHER_MIN_SLOTS and ETHER_MAX_SLOTS.
  static EtherSizes for_slots(std::size_t slots, std::uint32_t cpus);
  bool operator==(const EtherSizes&) const = default;
};

/// The values of the maps of one interface, mapped by the caller.
struct EtherMemory {
  ether_table* table = nullptr;
  std::span<std::uint64_t> buckets;
  std::span<ether_prefilter_part> prefilters;
  std::span<ether_slot> slots;
  std::span<ether_contract> contracts;
  std::span<gate_count> counts;
  std::span<gate_audit> audits;
  std::span<gate_watch> watches;
  std::uint32_t* generation = nullptr;  ///< of the verdicts, in gate_control
};

/// The table of an Ethernet gate: a hash table of slots whose traffic is in shared contracts.
class EtherTable final : public VerdictTable {
 public:
  /// Adopts the memory as it is. `fresh`: writes its header first, with `seed` for the hash.
  /// Errors: another layout or size, broken chains.
  static Result<EtherTable> read(const EtherMemory& memory, const EtherSizes& sizes, bool fresh,
                                 std::uint64_t seed, GracePeriod wait);

  // In a SlotSpec for this table the identifier and its mask are 0, and formats are
  // ETHER_UNFRAGMENTED and ETHER_FRAGMENT. Errors of apply(): a slot that is present twice or not
  // at all; more slots than room, ETHER_CHAIN of one subject, or GATE_WALK of one bucket; more
  // different contracts than room.

  [[nodiscard]] std::vector<SlotSpec> present() const override;
  [[nodiscard]] std::size_t size() const override { return used_; }
  [[nodiscard]] std::size_t room() const override { return sizes_.slots - ETHER_FIRST_SLOT; }
  [[nodiscard]] std::optional<std::uint32_t> find(const SlotSpec& spec) const override;

  [[nodiscard]] std::uint16_t watch_of(std::uint32_t slot) const override;
  /// Slots that wait for one of the ETHER_WATCHES - 1 watches. The apply() that frees a watch gives
  /// it to them after a grace period.
  [[nodiscard]] std::size_t unwatched() const override { return waiting_.size(); }
  [[nodiscard]] std::vector<std::uint16_t> watched() const override;

 private:
  EtherTable(const EtherMemory& memory, const EtherSizes& sizes, GracePeriod wait);

  /// The content of an ether_contract, as a key.
  struct Contract {
    std::uint32_t uid = 0;
    std::uint32_t source = 0;
    std::uint32_t station_high = 0;
    std::uint16_t max_len = 0;
    std::uint16_t forms = 0;
    std::uint64_t per_frame = 0;
    std::uint64_t per_byte = 0;
    std::uint64_t tolerance = 0;
    auto operator<=>(const Contract&) const = default;
  };
  struct Use {
    std::uint16_t number = 0;
    std::uint32_t slots = 0;
  };
  /// How events are expected, as in SlotSpec.
  struct Expected {
    std::uint64_t period = 0;
    std::uint64_t silence = 0;
    std::uint64_t together = 0;
  };
  /// Unused entries of a map. A running program may still read those in quarantine.
  template <class Number>
  struct Unused {
    std::vector<Number> free;
    std::vector<Number> quarantine;
    [[nodiscard]] std::size_t size() const { return free.size() + quarantine.size(); }
    void release() {
      free.insert(free.end(), quarantine.begin(), quarantine.end());
      quarantine.clear();
    }
  };

  Result<void> adopt(bool fresh);
  Result<void> adopt_chain(std::size_t bucket, std::vector<bool>& seen);
  [[nodiscard]] Result<void> check_adopted(std::uint32_t at, std::size_t bucket) const;
  Result<void> adopt_contract(std::uint32_t at);
  [[nodiscard]] Result<void> check(const SlotChanges& changes) const override;
  [[nodiscard]] Result<void> check_adds(const std::vector<SlotSpec>& adds) const;
  [[nodiscard]] Result<void> check_room(const SlotChanges& changes) const;
  [[nodiscard]] Result<void> check_publishers(const SlotChanges& changes) const;
  [[nodiscard]] Result<void> check_contracts(const SlotChanges& changes) const;
  [[nodiscard]] Result<void> check_chains(const SlotChanges& changes, bool removed_first) const;
  [[nodiscard]] std::set<Contract> new_contracts(const SlotChanges& changes) const;
  [[nodiscard]] bool fits_at_once(const SlotChanges& changes) const override;
  Result<void> reclaim(const SlotChanges& changes) override;
  Result<void> release_what_was_left();
  void put_what_comes(const SlotChanges& changes) override;
  void remove_what_goes(const SlotChanges& changes) override;
  [[nodiscard]] std::uint8_t* verdicts(std::uint32_t slot) const override {
    return memory_.slots[slot].verdict;
  }
  [[nodiscard]] std::uint32_t slots_end() const override { return sizes_.slots; }
  void forget_events(std::uint32_t slot) override;
  [[nodiscard]] std::uint16_t supervised_watch(std::uint32_t slot) const override;
  [[nodiscard]] std::uint32_t last_of_stations(std::uint64_t bucket, const SlotSpec& spec) const;
  void link(const SlotSpec& spec);
  void unlink(const SlotSpec& spec);
  void set_traffic(const SlotSpec& spec);
  void set_watch(std::uint32_t slot, const SlotSpec& spec);
  void leave_watch(std::uint32_t slot);
  void watch_what_waits() override;
  [[nodiscard]] bool lacks_watch(const SlotSpec& spec) const;
  std::uint16_t take_contract(const SlotSpec& spec);
  void leave_contract(std::uint16_t number);
  [[nodiscard]] static Contract contract_of(const SlotSpec& spec);
  [[nodiscard]] std::uint64_t hash_of(std::uint64_t subject, Direction direction) const;
  [[nodiscard]] std::uint64_t& bucket_of(std::uint64_t hash) const;
  [[nodiscard]] std::uint64_t station_of(std::uint32_t at) const;
  [[nodiscard]] SlotSpec spec_of(std::uint32_t at) const;
  [[nodiscard]] std::uint64_t fingerprints_of(std::uint32_t first) const;
  [[nodiscard]] std::uint8_t prefilter_of(std::uint32_t first) const;
  /// The prefilter of a bucket; nullptr if the table has none.
  [[nodiscard]] std::uint8_t* prefilter_at(std::uint64_t hash) const;
  [[nodiscard]] std::uint64_t hash_at(std::uint32_t slot) const;

  EtherMemory memory_;
  EtherSizes sizes_;
  GracePeriod wait_;
  std::size_t used_ = 0;
  std::map<Contract, Use> contracts_;
  Unused<std::uint32_t> slots_;
  Unused<std::uint16_t> contract_numbers_;
  Unused<std::uint16_t> watches_;
  std::map<std::uint32_t, Expected> waiting_;  ///< slots that wait for a watch
};

}  // namespace mlcca::gates
