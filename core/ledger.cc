// SPDX-License-Identifier: BSD-2-Clause
#include "core/ledger.hpp"

#include <cassert>
#include <ranges>

namespace mlcca::core {

bool Ledger::add(const Flow& flow, Value bytes_per_second) {
  // Whoever decides all channels adds in rising order: the end is where the next one belongs.
  const std::size_t before = flows_.size();
  flows_.try_emplace(flows_.end(), flow, bytes_per_second);
  if (flows_.size() == before) return false;
  Value& sum = reserved_[flow.resource];
  assert(bytes_per_second <= kUnbounded - sum);
  sum += bytes_per_second;
  return true;
}

void LedgerBuilder::remove(const Flow& flow) {
  const auto it = ledger_.flows_.find(flow);
  if (it == ledger_.flows_.end()) return;
  ledger_.reserved_[flow.resource] -= it->second;
  ledger_.flows_.erase(it);
}

Ledger Ledger::with(const Flow& flow, Value bytes_per_second) const {
  Ledger next = *this;
  next.add(flow, bytes_per_second);
  return next;
}

auto Ledger::flows_of(std::size_t publisher) const {
  return std::ranges::subrange(flows_.lower_bound({publisher, 0, 0}),
                               flows_.lower_bound({publisher + 1, 0, 0}));
}

Ledger Ledger::balance_without(std::span<const std::size_t> publishers) const {
  Ledger balance;
  balance.reserved_ = reserved_;
  for (const std::size_t p : publishers)
    for (const auto& [flow, bytes] : flows_of(p)) balance.reserved_[flow.resource] -= bytes;
  return balance;
}

Ledger Ledger::without(std::span<const std::size_t> publishers) const {
  return Ledger(*this).replaced(publishers, balance_without(publishers));
}

Ledger Ledger::replaced(std::span<const std::size_t> publishers, const Ledger& decided) && {
  for (const std::size_t p : publishers) {
    const auto gone = flows_of(p);
    flows_.erase(gone.begin(), gone.end());
  }
  flows_.insert(decided.flows_.begin(), decided.flows_.end());
  reserved_ = decided.reserved_;
  return std::move(*this);
}

}  // namespace mlcca::core
