// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/shared_networks.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/can/cover.hpp"
#include "core/cluster/footprint.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

}  // namespace

SharedNetworks::SharedNetworks(const core::System& system, std::size_t self)
    : self_(self),
      networks_(system.networks.size()),
      baseline_(system),
      permits_(system, self),
      has_elected_(std::ranges::any_of(baseline_.all(), [](const auto& standing) {
        return std::ranges::any_of(standing, &core::cluster::Standing::elected);
      })) {
  permits_.set_standing(baseline_.all());
  permits_.need_agreements();
  permits_.close(true);
}

void SharedNetworks::touch(const core::cluster::Footprint& footprint) {
  for (const core::cluster::Part& part : footprint.parts) touch(part.network);
}

void SharedNetworks::touch_all() {
  for (std::size_t n = 0; n < networks_; ++n) touch(n);
}

void SharedNetworks::hold(Number number, const cc::Footprint& footprint,
                          const std::vector<core::AdmissionId>& agreed) {
  drop(number);
  touch(footprint);
  permits_.put(number, footprint, false, {.admissions = agreed, .gateways = footprint.gateways});
  held_.emplace(number, Held{.footprint = footprint, .gateway = self_, .theirs = footprint});
}

void SharedNetworks::carry(Number number, const cc::Footprint& footprint, std::size_t gateway,
                           const cc::Footprint& theirs, std::vector<core::AdmissionId> agreed,
                           std::vector<core::AdmissionId> all) {
  // It may be what drop() forgets.
  Held held{.footprint = footprint, .gateway = gateway, .theirs = theirs};
  drop(number);
  touch(held.footprint);
  core::Agreement agreement{
      .admissions = std::move(agreed), .gateways = held.theirs.gateways, .left = std::move(all)};
  agreement.gateways.push_back(gateway);
  permits_.put(number, held.footprint, true, std::move(agreement));
  held_.emplace(number, std::move(held));
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
    touch(it->second.footprint);
    permits_.erase(number);
    held_.erase(it);
  }
  if (const auto it = counted_.find(number); it != counted_.end()) {
    touch(it->second.footprint);
    counted_.erase(it);
  }
}

const core::cluster::Footprint* SharedNetworks::footprint(Number number) const {
  if (const auto it = held_.find(number); it != held_.end()) return &it->second.footprint;
  const auto it = counted_.find(number);
  return it == counted_.end() ? nullptr : &it->second.footprint;
}

void SharedNetworks::leave_out(std::optional<Number> number) {
  if (number == left_out_) return;
  for (const auto& one : {std::exchange(left_out_, number), number})
    if (const auto* const there = one ? footprint(*one) : nullptr) touch(*there);
}

namespace {

const cc::Part* part_on(const cc::Footprint& footprint, std::size_t network) {
  const auto it = std::ranges::find(footprint.parts, network, &cc::Part::network);
  return it == footprint.parts.end() ? nullptr : &*it;
}

using Whose = std::pair<std::size_t, cc::Source>;

/// Of what does not count beside what is decided: that of admissions, since what is of described
/// publishers counts with their promises, or that of all.
enum class Of : std::uint8_t { admissions, all };

/// What is decided, in the numbers of the gateway that has reserved it: whatever else has as much
/// of the same traffic does not count beside it.
void leave_out_same(const cc::Part& decided, std::size_t gateway, Of of, cc::Foreign& all) {
  const auto drop = [&](auto& from, const auto& what, auto covers) {
    std::erase_if(from, [&](const auto& one) {
      return one.gateway == gateway && (of == Of::all || one.source.admission != 0) &&
             std::ranges::any_of(what, [&](const auto& known) {
               return known.source == one.source && covers(known, one);
             });
    });
  };
  drop(all.rates, decided.rates, [](const cc::RatePart& known, const cc::RatePart& one) {
    return known.bytes_per_second >= one.bytes_per_second;
  });
  drop(all.bus, decided.bus, [](const cc::BusPart& known, const cc::BusPart& one) {
    return core::can::covers(known.message, one.message);
  });
  drop(all.paths, decided.paths,
       [](const cc::PathPart& known, const cc::PathPart& one) { return core::covers(known, one); });
}

}  // namespace

/// Of publishers of other gateways that are carried here, in numbers of this gateway: then it
/// counts with them, once.
void SharedNetworks::name_carried(cc::Foreign& all, std::size_t network,
                                  const core::Members& members) const {
  std::map<Whose, cc::Source> ours;
  std::set<std::size_t> gateways;
  for (const auto& [number, held] : held_) {
    const cc::Part* const here = part_on(held.footprint, network);
    const cc::Part* const there = part_on(held.theirs, network);
    if (held.gateway == self_ || here == nullptr || there == nullptr) continue;
    for (std::size_t i = 0; i < there->rates.size(); ++i)
      if (members.admitted(here->rates[i].source.admission).publisher)
        ours.emplace(Whose(held.gateway, there->rates[i].source), here->rates[i].source);
    gateways.insert(held.gateway);
  }
  if (ours.empty()) return;
  const auto name = [&](auto& parts) {
    for (auto& part : parts) {
      if (!gateways.contains(part.gateway)) continue;
      const auto known = ours.find({part.gateway, part.source});
      if (known == ours.end()) continue;
      part.gateway = self_;
      part.source = known->second;
    }
  };
  name(all.rates);
  name(all.bus);
  name(all.paths);
}

/// What is held counts with its publisher. One that has gone may have left frames in queues, and
/// the store has it until it is given back.
void SharedNetworks::add_without_publisher(cc::Foreign& all, std::size_t network,
                                           const core::Members& members) const {
  const auto append = [&](const auto& here, const auto& there, std::size_t gateway, auto& to) {
    for (std::size_t i = 0; i < here.size(); ++i) {
      const core::AdmissionId id = here[i].source.admission;
      if (id != 0 && !members.admitted(id).publisher) to.emplace_back(there[i]).gateway = gateway;
    }
  };
  for (const auto& [number, held] : held_) {
    const cc::Part* const here = part_on(held.footprint, network);
    const cc::Part* const there = part_on(held.theirs, network);
    if (number == left_out_ || here == nullptr || there == nullptr) continue;
    append(here->rates, there->rates, held.gateway, all.rates);
    append(here->bus, there->bus, held.gateway, all.bus);
    append(here->paths, there->paths, held.gateway, all.paths);
  }
}

/// What is to replace something, or brings a publisher that is not there yet.
SharedNetworks::Decided SharedNetworks::decided(std::size_t network) const {
  if (!left_out_) return {};
  if (const auto held = held_.find(*left_out_); held != held_.end())
    return {part_on(held->second.theirs, network), held->second.gateway};
  const auto counted = counted_.find(*left_out_);
  if (counted == counted_.end()) return {};
  return {part_on(counted->second.footprint, network), counted->second.gateway};
}

cc::Foreign SharedNetworks::of_others(std::size_t network, const cc::View& view) const {
  cc::Foreign all = view.of_others(network);
  if (const auto [part, gateway] = decided(network); part != nullptr)
    leave_out_same(*part, gateway, Of::all, all);
  return all;
}

/// With what the store still has of this gateway from a process before.
cc::Foreign SharedNetworks::foreign(std::size_t network, const core::Members& members,
                                    const cc::View& view) const {
  cc::Foreign all = view.foreign(network);
  const auto& records = view.records().reservations;
  for (auto it = records.lower_bound({.network = network, .gateway = self_, .id = 0});
       it != records.end() && it->first.network == network && it->first.gateway == self_; ++it) {
    const Number number = it->first.id;
    if (held_.contains(number) || counted_.contains(number) || number == left_out_) continue;
    if (it->second.taken)
      cc::add(all, it->second.taken->part, self_);
    else
      all.unreadable = true;
  }
  for (const auto& [number, counted] : counted_) {
    if (number == left_out_) continue;
    if (const cc::Part* const part = part_on(counted.footprint, network))
      cc::add(all, *part, counted.gateway);
  }
  add_without_publisher(all, network, members);
  if (const auto [part, gateway] = decided(network); part != nullptr)
    leave_out_same(*part, gateway, Of::admissions, all);
  name_carried(all, network, members);
  return all;
}

void SharedNetworks::put_foreign(core::State& state, const core::cluster::View& view) {
  for (const std::size_t n : std::exchange(stale_, {}))
    if (state.world().shared[n]) state.set_foreign(n, foreign(n, state.members(), view));
}

}  // namespace mlcca
