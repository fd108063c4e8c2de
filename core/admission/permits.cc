// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/permits.hpp"

#include <algorithm>
#include <utility>

#include "core/can/cover.hpp"

namespace mlcca::core {

/// What one reason allows of a use.
struct Permits::Allowed {
  bool rate = false;
  bool message = false;
  std::vector<bool> paths;

  void take(const Allowed& other) {
    rate = rate || other.rate;
    message = message || other.message;
    for (std::size_t i = 0; i < paths.size(); ++i) paths[i] = paths[i] || other.paths[i];
  }
  [[nodiscard]] bool all() const {
    return rate && message && std::ranges::all_of(paths, [](bool path) { return path; });
  }
};

bool covers(const cluster::PathPart& promised, const cluster::PathPart& wanted) {
  return promised.from == wanted.from && promised.to == wanted.to &&
         promised.bytes_per_second >= wanted.bytes_per_second &&
         promised.event_bytes == wanted.event_bytes;
}

namespace {

std::vector<bool> covered(std::span<const cluster::PathPart> promised,
                          std::span<const cluster::PathPart> wanted) {
  std::vector<bool> all;
  all.reserve(wanted.size());
  for (const cluster::PathPart& path : wanted)
    all.push_back(
        std::ranges::any_of(promised, [&](const cluster::PathPart& p) { return covers(p, path); }));
  return all;
}

/// Removes a reservation from those of `key`, and the key with the last one.
template <class Key>
void take_out(std::map<Key, std::set<std::uint64_t>>& from, const Key& key,
              std::uint64_t reservation) {
  const auto it = from.find(key);
  if (it == from.end()) return;
  it->second.erase(reservation);
  if (it->second.empty()) from.erase(it);
}

}  // namespace

Permits::Allowed Permits::allowed_by(const cluster::Standing& standing, const Use& use) const {
  if (!standing_open_ || (!open_ && (use.elected || standing.elected)))
    return {.paths = std::vector<bool>(use.paths.size(), false)};
  return {.rate = standing.bytes_per_second >= use.bytes_per_second,
          .message = use.message == nullptr ||
                     (standing.message && can::covers(*standing.message, *use.message)),
          .paths = covered(standing.paths, use.paths)};
}

Permits::Allowed Permits::allowed_by(const cluster::Part& part, const Use& use) {
  Allowed allowed{.rate = false, .message = use.message == nullptr, .paths = {}};
  for (const cluster::RatePart& rate : part.rates)
    if (rate.source == use.source && rate.bytes_per_second >= use.bytes_per_second)
      allowed.rate = true;
  for (const cluster::BusPart& bus : part.bus)
    if (use.message != nullptr && bus.source == use.source &&
        can::covers(bus.message, *use.message))
      allowed.message = true;
  std::vector<cluster::PathPart> paths;
  std::ranges::copy_if(part.paths, std::back_inserter(paths),
                       [&](const cluster::PathPart& p) { return p.source == use.source; });
  allowed.paths = covered(paths, use.paths);
  return allowed;
}

bool Permits::allow(const Use& use, std::optional<std::uint64_t> without) const {
  Allowed allowed{.message = use.message == nullptr,
                  .paths = std::vector<bool>(use.paths.size(), false)};
  if (use.source.admission == 0) {
    const Flow flow{use.source.publisher, use.network, use.source.from};
    const auto& all = standing_[use.network];
    const auto it = std::ranges::lower_bound(all, flow, {}, &cluster::Standing::flow);
    if (it != all.end() && it->flow == flow) allowed.take(allowed_by(*it, use));
  }
  const auto reserved = of_source_[use.network].find(use.source);
  if (open_ && reserved != of_source_[use.network].end())
    for (const std::uint64_t number : reserved->second)
      if (number != without) allowed.take(allowed_by(reserved_[use.network].at(number), use));
  return allowed.all();
}

bool Permits::is_reserved_by_another(const Use& use) const {
  Allowed allowed{.message = use.message == nullptr,
                  .paths = std::vector<bool>(use.paths.size(), false)};
  const auto reserved = of_source_[use.network].find(use.source);
  if (reserved == of_source_[use.network].end()) return false;
  for (const std::uint64_t number : reserved->second)
    if (by_another_.contains(number))
      allowed.take(allowed_by(reserved_[use.network].at(number), use));
  return allowed.all();
}

void Permits::changed() {
  for (std::uint64_t& count : grown_) ++count;
  for (auto& ended : ended_) ended.add_any();
  ++more_agreed_;
  disagreed_.add_any();
}

void Permits::agree(std::uint64_t reservation, Agreement agreement) {
  if (agreement.empty()) return;
  for (const AdmissionId id : agreement.left) left_[id].insert(reservation);
  for (const AdmissionId id : agreement.admissions)
    for (const std::size_t gateway : agreement.gateways) agreed_[{id, gateway}].insert(reservation);
  agreements_.insert_or_assign(reservation, std::move(agreement));
  ++more_agreed_;
}

void Permits::disagree(std::uint64_t reservation) {
  const auto gone = agreements_.extract(reservation);
  if (!gone) return;
  const Agreement& agreement = gone.mapped();
  for (const AdmissionId id : agreement.left) {
    disagreed_.add(id);
    take_out(left_, id, reservation);
  }
  for (const AdmissionId id : agreement.admissions) {
    disagreed_.add(id);
    for (const std::size_t gateway : agreement.gateways)
      take_out(agreed_, std::pair(id, gateway), reservation);
  }
}

void Permits::set_standing(std::vector<std::vector<cluster::Standing>> standing) {
  standing_ = std::move(standing);
  changed();
}

void Permits::put(std::uint64_t reservation, cluster::Footprint footprint, bool by_another,
                  Agreement agreed) {
  erase(reservation);
  agree(reservation, std::move(agreed));
  if (by_another) by_another_.insert(reservation);
  for (cluster::Part& part : footprint.parts) {
    const std::size_t network = part.network;
    for (const cluster::RatePart& rate : part.rates)
      of_source_[network][rate.source].insert(reservation);
    reserved_[network].insert_or_assign(reservation, std::move(part));
    ++grown_[network];
  }
}

void Permits::erase(std::uint64_t reservation) {
  by_another_.erase(reservation);
  disagree(reservation);
  for (std::size_t n = 0; n < reserved_.size(); ++n) {
    const auto gone = reserved_[n].extract(reservation);
    if (!gone) continue;
    auto& sources = of_source_[n];
    if (gone.mapped().rates.empty()) ended_[n].add_any();
    for (const cluster::RatePart& rate : gone.mapped().rates) {
      const auto it = sources.find(rate.source);
      ended_[n].add(rate.source);
      if (it == sources.end()) continue;
      it->second.erase(reservation);
      if (it->second.empty()) sources.erase(it);
    }
  }
}

void Permits::close(bool standing_too) {
  if (!open_ && standing_open_ != standing_too) return;
  open_ = false;
  standing_open_ = !standing_too;
  changed();
}

void Permits::open() {
  if (open_ && standing_open_) return;
  open_ = true;
  standing_open_ = true;
  changed();
}

}  // namespace mlcca::core
