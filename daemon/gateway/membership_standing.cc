// SPDX-License-Identifier: BSD-2-Clause
// The texts about a gateway's standing in its cluster.
#include <fmt/format.h>

#include "daemon/gateway/membership.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

}  // namespace

std::string Membership::standing() const {
  if (leaving_) return leaving_words();
  if (parts_.scene.unchecked)
    return "all networks of this gateway are closed: whether its description takes others off one "
           "is not known before the store has the one in force";
  if (member_->standing(now()) == cc::Member::Standing::joined && store_.reachable) return {};
  return member_->why_not(now());
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
