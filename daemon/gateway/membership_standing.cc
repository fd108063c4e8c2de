// SPDX-License-Identifier: BSD-2-Clause
// A gateway's standing in its cluster, and the texts about it.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/cluster/lease.hpp"
#include "daemon/gateway/membership.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

constexpr Value kTroublesAgain = 10'000'000'000;  // ns

}  // namespace

std::string Membership::standing() const {
  if (leaving_) return leaving_words();
  if (parts_.scene.unchecked)
    return "all networks of this gateway are closed: whether its description takes others off one "
           "is not known before the store has the one in force";
  if (member_->standing(now()) == cc::Member::Standing::joined && store_.reachable) return {};
  return member_->why_not(now());
}

std::string Membership::bar(uid_t user) const {
  const std::string why = standing();
  return why.empty() ? reserving_->bar(user) : why;
}

std::string Membership::why_closed() const {
  const std::string why = standing();
  return why.empty() ? "the store has not answered lately" : why;
}

void Membership::expire() {
  if (!member_) return;
  // Before that, nobody can have called this gateway off.
  if (now() >= member_->valid_until()) lapsed_at_ = now();
  member_->on_time(now());
  static_cast<void>(bring_in_line());
}

/// Whether the store has not confirmed a beat since the gates closed by themselves. Another gateway
/// can have called this one off by then, and another description can be in force.
bool Membership::is_unheard() {
  if (lapsed_at_ && member_->valid_until() >= cc::valid_until(*lapsed_at_, parts_.lease))
    lapsed_at_.reset();
  return lapsed_at_.has_value();
}

std::string Membership::rollout_bar() const {
  using Standing = cc::Member::Standing;
  if (leaving_) return leaving_words();
  if (!member_) return "this gateway starts";
  const Standing standing = member_->standing(now());
  const bool here = standing == Standing::joined || standing == Standing::other_digest ||
                    standing == Standing::waiting;
  return here && store_.reachable ? std::string() : member_->why_not(now());
}

std::vector<std::string> Membership::problems() const {
  if (!member_) return {};
  std::vector<std::string> out;
  if (const std::string why = standing(); !why.empty())
    out.push_back(fmt::format("cluster {}: {}: {}", system_, closed_words(), why));
  add_troubles(out);
  return out;
}

/// What others write must not fill the log: the lines of a while are reported together.
void Membership::report_troubles() {
  if (now() < say_troubles_at_ || !looks_for_troubles_) return;
  looks_for_troubles_ = false;
  std::vector<std::string> troubles;
  add_troubles(troubles);
  for (const std::string& line : troubles) {
    if (std::ranges::find(said_troubles_, line) != said_troubles_.end()) continue;
    parts_.log.warning(Kind::gateway, line);
    say_troubles_at_ = add_saturating(now(), kTroublesAgain);
  }
  said_troubles_ = std::move(troubles);
}

void Membership::report() {
  report_troubles();
  const std::string why = standing();
  // While the store does not answer, the reason changes with each of its members that is tried.
  const bool lost = why.starts_with(cc::Member::kNoAnswer);
  const bool is_new = outage_.take(lost, now()) == Outage::Report::lost;
  if (lost ? !is_new : why == said_) return;
  said_ = why;
  if (why.empty())
    parts_.log.notice(Kind::gateway, fmt::format("cluster {}: this gateway takes part", system_));
  else
    parts_.log.warning(Kind::gateway, fmt::format("cluster {}: {}", system_, why));
}

}  // namespace mlcca
