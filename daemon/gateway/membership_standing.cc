// SPDX-License-Identifier: BSD-2-Clause
// How a gateway stands to the others, and how it leaves them.
#include <fmt/format.h>

#include "daemon/gateway/membership.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

constexpr Value kLeaveLimit = 5'000'000'000;  // ns

}  // namespace

void Membership::leave() {
  if (!member_ || leaving_) return;
  leaving_ = true;
  leave_until_ = add_saturating(now(), kLeaveLimit);
  reserving_->refuse_all("nothing was changed: this gateway is being drained");
  static_cast<void>(bring_in_line());
  drain_when_closed();
}

void Membership::drain_when_closed() {
  if (!leaving_ || draining_ || !parts_.turn.in_line()) return;
  draining_ = true;
  reserving_->lost();
  member_->drain(now());
}

bool Membership::may_end() const {
  return !member_ || left_ || !store_.reachable || now() >= leave_until_;
}

/// Empty: all is well.
std::string Membership::standing() const {
  if (member_->standing(now()) == cc::Member::Standing::joined && store_.reachable) return {};
  return member_->why_not(now());
}

std::string Membership::rollout_bar() const {
  using Standing = cc::Member::Standing;
  if (leaving_) return "this gateway is being drained";
  if (!member_) return "this gateway starts";
  const Standing standing = member_->standing(now());
  const bool here = standing == Standing::joined || standing == Standing::other_digest ||
                    standing == Standing::waiting;
  return here && store_.reachable ? std::string() : member_->why_not(now());
}

std::vector<std::string> Membership::problems() const {
  if (!member_) return {};
  const std::string why = standing();
  if (why.empty()) return {};
  return {fmt::format("cluster {}: nothing new is granted on networks of several gateways: {}",
                      system_, why)};
}

void Membership::report() {
  const std::string why = standing();
  if (why == said_) return;
  said_ = why;
  if (why.empty())
    parts_.log.notice(Kind::gateway, fmt::format("cluster {}: this gateway takes part", system_));
  else
    parts_.log.warning(Kind::gateway, fmt::format("cluster {}: {}", system_, why));
}

}  // namespace mlcca
