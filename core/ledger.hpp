// SPDX-License-Identifier: BSD-2-Clause
// What has been promised, as a value: `next = ledger.with(...)`, apply, then commit; dropping
// `next` is the rollback. Integers, so that a release restores exactly.
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/system.hpp"

namespace mlcca::core {

/// The traffic of one publisher on one resource (a network or gateway, see System::resource_of). It
/// is carried once, however many subscribers are behind it, but once more for each way in.
struct Flow {
  std::size_t publisher = 0;
  std::size_t resource = 0;
  std::size_t from = kOwn;  ///< the resource that it comes from; kOwn: the publisher itself

  static constexpr std::size_t kOwn = 0xffffffff;
  auto operator<=>(const Flow&) const = default;
};

class Ledger {
 public:
  explicit Ledger(std::size_t resources = 0) : reserved_(resources, 0) {}

  /// Payload bytes/s promised on a resource.
  [[nodiscard]] Value reserved(std::size_t resource) const { return reserved_[resource]; }
  [[nodiscard]] bool carries(const Flow& flow) const { return flows_.contains(flow); }

  /// This ledger and the flow. A flow that is carried already is not counted twice. The caller has
  /// checked the capacity: a sum beyond 2^64 - 1 bytes/s is a bug.
  [[nodiscard]] Ledger with(const Flow& flow, Value bytes_per_second) const;
  /// This ledger without anything of the publishers.
  [[nodiscard]] Ledger without(std::span<const std::size_t> publishers) const;

  /// The sums alone, without what the publishers reserve: all that a decision about these
  /// publishers' channel needs, at a cost that does not grow with the flows of others.
  [[nodiscard]] Ledger balance_without(std::span<const std::size_t> publishers) const;

  /// This ledger with the publishers' flows replaced by those of `decided`, which was derived from
  /// balance_without(publishers).
  [[nodiscard]] Ledger replaced(std::span<const std::size_t> publishers, const Ledger& decided) &&;

  bool operator==(const Ledger&) const = default;

 private:
  friend class LedgerBuilder;
  bool add(const Flow& flow, Value bytes_per_second);
  [[nodiscard]] auto flows_of(std::size_t publisher) const;

  std::vector<Value> reserved_;
  std::map<Flow, Value> flows_;
};

/// Fills a ledger of its own in place; for a decision over all channels.
class LedgerBuilder {
 public:
  explicit LedgerBuilder(Ledger start) : ledger_(std::move(start)) {}
  /// False if the flow is carried already.
  bool add(const Flow& flow, Value bytes_per_second) { return ledger_.add(flow, bytes_per_second); }
  /// Takes back what was added.
  void remove(const Flow& flow);
  [[nodiscard]] const Ledger& ledger() const { return ledger_; }
  [[nodiscard]] Ledger take() && { return std::move(ledger_); }

 private:
  Ledger ledger_;
};

}  // namespace mlcca::core
