// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/gate_set.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

namespace mlcca {

Result<void> GateSet::hold(const GateSpec& spec) {
  if (must_go_back()) return change_;
  auto done = replace(spec);
  // A failure while going back cannot be undone again: what cannot be held then is closed, as
  // always.
  if (!done && phase_ == Phase::changing) change_ = done;
  return done;
}

Result<void> GateSet::replace(const GateSpec& spec) {
  HeldGate* const old = find(ifindex_of(spec));
  if (old != nullptr && old->is(spec)) return {};
  const auto spare = spare_of(spec);
  if (!spare) return std::unexpected(spare.error());
  if (auto put = (*spare)->second->put(); !put) {
    // If that fails, a repair finds the missing gate.
    if (old != nullptr) static_cast<void>(old->reattach());
    if (phase_ == Phase::settled) spares_.erase(*spare);
    return put;
  }
  take_in(*spare);
  return {};
}

Result<GateSet::Spares::iterator> GateSet::spare_of(const GateSpec& spec) {
  const int ifindex = ifindex_of(spec);
  const auto [first, last] = spares_.equal_range(ifindex);
  const auto spare =
      std::find_if(first, last, [&](const auto& entry) { return entry.second->is(spec); });
  if (spare != last) return spare;
  auto made = load_(spec);
  if (!made) return std::unexpected(made.error());
  return spares_.emplace(ifindex, std::move(*made));
}

/// Takes a spare into gates_ after it was put in place.
void GateSet::take_in(Spares::iterator spare) {
  const int ifindex = spare->first;
  Gate gate = std::move(spare->second);
  spares_.erase(spare);
  std::swap(gates_[ifindex], gate);
  if (gate && phase_ != Phase::settled) spares_.emplace(ifindex, std::move(gate));
}

Result<void> GateSet::make_spare(const GateSpec& spec) {
  const HeldGate* const old = find(ifindex_of(spec));
  if (old != nullptr && old->is(spec)) return {};
  auto made = load_(spec);
  if (!made) return std::unexpected(made.error());
  spares_.emplace(ifindex_of(spec), std::move(*made));
  return {};
}

void GateSet::begin_change() {
  phase_ = Phase::changing;
  change_ = {};
}

void GateSet::go_back() {
  phase_ = Phase::going_back;
  change_ = {};
}

void GateSet::end_change() {
  spares_.clear();
  phase_ = Phase::settled;
  change_ = {};
}

HeldGate* GateSet::find(int ifindex) const {
  const auto found = gates_.find(ifindex);
  return found == gates_.end() ? nullptr : found->second.get();
}

std::vector<int> GateSet::interfaces() const {
  const auto keys = std::views::keys(gates_);
  return {keys.begin(), keys.end()};
}

std::optional<int> GateSet::next(int ifindex) const {
  const auto next = gates_.upper_bound(ifindex);
  if (next == gates_.end()) return std::nullopt;
  return next->first;
}

void GateSet::deny(int ifindex) {
  if (HeldGate* const gate = find(ifindex)) gate->deny_all();
  const auto [first, last] = spares_.equal_range(ifindex);
  std::for_each(first, last, [](const auto& spare) { spare.second->deny_all(); });
}

}  // namespace mlcca
