// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/shared_networks.hpp"

#include <algorithm>
#include <utility>

#include "core/cluster/footprint.hpp"

namespace mlcca {

SharedNetworks::SharedNetworks(const core::System& system, std::size_t self)
    : self_(self),
      networks_(system.networks.size()),
      baseline_(system),
      permits_(system, self),
      has_elected_(std::ranges::any_of(baseline_.all(), [](const auto& standing) {
        return std::ranges::any_of(standing, &core::cluster::Standing::elected);
      })) {
  permits_.set_standing(baseline_.all());
  permits_.close(true);
}

void SharedNetworks::touch(const core::cluster::Footprint& footprint) {
  for (const core::cluster::Part& part : footprint.parts) touch(part.network);
}

void SharedNetworks::touch_all() {
  for (std::size_t n = 0; n < networks_; ++n) touch(n);
}

void SharedNetworks::hold(Number number, const core::cluster::Footprint& footprint) {
  drop(number);
  touch(footprint);
  permits_.put(number, footprint);
  held_.emplace(number, footprint);
}

void SharedNetworks::count(Number number, const core::cluster::Footprint& footprint,
                           std::size_t gateway) {
  // It may be what drop() forgets.
  Counted counted{.footprint = footprint, .gateway = gateway};
  drop(number);
  touch(counted.footprint);
  counted_.emplace(number, std::move(counted));
}

void SharedNetworks::drop(Number number) {
  if (const auto it = held_.find(number); it != held_.end()) {
    touch(it->second);
    permits_.erase(number);
    held_.erase(it);
  }
  if (const auto it = counted_.find(number); it != counted_.end()) {
    touch(it->second.footprint);
    counted_.erase(it);
  }
}

const core::cluster::Footprint* SharedNetworks::footprint(Number number) const {
  if (const auto it = held_.find(number); it != held_.end()) return &it->second;
  const auto it = counted_.find(number);
  return it == counted_.end() ? nullptr : &it->second.footprint;
}

void SharedNetworks::leave_out(std::optional<Number> number) {
  if (number == left_out_) return;
  for (const auto& one : {std::exchange(left_out_, number), number})
    if (const auto* const there = one ? footprint(*one) : nullptr) touch(*there);
}

/// With what the store still has of this gateway from a process before.
core::cluster::Foreign SharedNetworks::foreign(std::size_t network,
                                               const core::cluster::View& view) const {
  core::cluster::Foreign all = view.foreign(network);
  const auto& records = view.records().reservations;
  for (auto it = records.lower_bound({.network = network, .gateway = self_, .id = 0});
       it != records.end() && it->first.network == network && it->first.gateway == self_; ++it) {
    const Number number = it->first.id;
    if (held_.contains(number) || counted_.contains(number) || number == left_out_) continue;
    if (it->second.taken)
      core::cluster::add(all, it->second.taken->part, self_);
    else
      all.unreadable = true;
  }
  for (const auto& [number, counted] : counted_) {
    if (number == left_out_) continue;
    const auto part =
        std::ranges::find(counted.footprint.parts, network, &core::cluster::Part::network);
    if (part != counted.footprint.parts.end()) core::cluster::add(all, *part, counted.gateway);
  }
  return all;
}

void SharedNetworks::put_foreign(core::State& state, const core::cluster::View& view) {
  for (const std::size_t n : std::exchange(stale_, {}))
    if (state.world().shared[n]) state.set_foreign(n, foreign(n, view));
}

}  // namespace mlcca
