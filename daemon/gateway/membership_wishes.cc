// SPDX-License-Identifier: BSD-2-Clause
// The wishes of this gateway: reservations on shared networks for channels that exist already.
#include <algorithm>
#include <utility>

#include "core/cluster/footprint.hpp"
#include "daemon/gateway/membership.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

constexpr Value kWishAgain = 2'000'000'000;          // when it may fit
constexpr Value kRefusedWishAgain = 5'000'000'000;   // ns
constexpr Value kGrantedWishAgain = 60'000'000'000;  // after a grant with which it should fit

}  // namespace

/// Asks for a channel that would be given more with a reservation: one that has lost its
/// reservation, or for which others leave more room than the description promises. True if one was
/// asked for.
bool Membership::wish_some() {
  if (!joined_ || leaving_ || !looks_for_wishes_ || !reserving_->idle() ||
      !member_->why_not(now()).empty() || !networks_->permits().is_open())
    return false;
  for (const std::size_t channel : state().wishes()) {
    const auto again = wish_again_.find(state().system().channels[channel].name);
    if (again != wish_again_.end() && again->second > now()) continue;
    wish(channel);
    return true;
  }
  looks_for_wishes_ = false;
  return false;
}

/// A gateway has failed: what it carried is to be reserved now, even if that was tried a short time
/// ago.
void Membership::take_over() {
  wish_again_.clear();
  looks_for_wishes_ = true;
}

void Membership::wish(std::size_t channel) {
  const std::string name = state().system().channels[channel].name;
  wish_again_[name] = add_saturating(now(), kWishAgain);
  const auto decide = [this, name]() -> std::optional<Reserving::Wish> {
    const auto there = state().find_channel(name);
    if (!there) return std::nullopt;
    const core::Proposal proposal = state().wish(*there);
    if (!proposal.fit()) return std::nullopt;
    auto footprint = core::cluster::footprint_of(proposal, baseline(), self_);
    if (footprint.parts.empty()) return std::nullopt;
    cluster::Asked asked = asked_of(*there);
    add_publishers(footprint, asked);
    return Reserving::Wish{
        .footprint = std::move(footprint), .publisher = {}, .asked = std::move(asked)};
  };
  const auto granted = [this, name] {
    wish_again_[name] = add_saturating(now(), kGrantedWishAgain);
    const auto there = state().find_channel(name);
    return there && !core::cluster::footprint_of(state(), *there, baseline(), self_).parts.empty();
  };
  const auto refused = [this, name](const std::string& why) {
    wish_again_[name] = add_saturating(now(), kRefusedWishAgain);
    parts_.log.info(Kind::gateway, name + " waits: " + why);
  };
  ask({.decide = decide, .granted = granted, .refused = refused});
}

cluster::Asked Membership::asked_of(std::size_t channel) const {
  cluster::Asked asked{.channel = state().system().channels[channel].name, .requests = {}};
  for (const auto& [id, of] : state().admissions()) {
    const control::Request* const request = parts_.recorder.contents().admissions.find(id);
    if (of == channel && request != nullptr) asked.requests.push_back(*request);
  }
  return asked;
}

void Membership::add_publishers(const core::cluster::Footprint& footprint,
                                cluster::Asked& to) const {
  const auto has = [](const std::vector<control::Request>& all, core::AdmissionId id) {
    return std::ranges::find(all, id, &control::Request::id) != all.end();
  };
  for (const core::cluster::Part& part : footprint.parts)
    for (const core::cluster::RatePart& rate : part.rates) {
      const core::AdmissionId id = rate.source.admission;
      if (id == 0 || has(to.requests, id) || has(to.also, id)) continue;
      const auto* const request = parts_.recorder.contents().admissions.find(id);
      if (request != nullptr) to.also.push_back(*request);
    }
}

bool Membership::is_known(const cluster::Asked& asked) const {
  const auto known = [this](const control::Request& request) {
    const auto* const there = parts_.recorder.contents().admissions.find(request.id);
    return there != nullptr && *there == request;
  };
  return state().find_channel(asked.channel) && std::ranges::all_of(asked.requests, known) &&
         std::ranges::all_of(asked.also, known);
}

/// Whether the channel uses something that only this reservation allows.
bool Membership::needs(const std::string& channel, Number number) const {
  const auto there = state().find_channel(channel);
  if (!there) return false;
  const auto used = core::cluster::footprint_of(state(), *there, baseline(), self_);
  return std::ranges::any_of(used.parts, [&](const core::cluster::Part& part) {
    return std::ranges::any_of(part.rates, [&](const core::cluster::RatePart& rate) {
      const auto bus = std::ranges::find(part.bus, rate.source, &core::cluster::BusPart::source);
      std::vector<core::cluster::PathPart> paths;
      for (const auto& path : part.paths)
        if (path.source == rate.source) paths.push_back(path);
      return !networks_->permits().allow(
          {.network = part.network,
           .source = rate.source,
           .bytes_per_second = rate.bytes_per_second,
           .message = bus == part.bus.end() ? nullptr : &bus->message,
           .paths = paths},
          number);
    });
  });
}

}  // namespace mlcca
