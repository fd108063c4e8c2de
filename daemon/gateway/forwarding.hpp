// SPDX-License-Identifier: BSD-2-Clause
// Which rules can-gw must have so that what was granted from one CAN bus to another gets there, and
// what leads to them. No I/O; docs/adr/0019 says why they are as they are.
#pragma once
#include <cstdint>
#include <expected>
#include <map>
#include <string>
#include <vector>

#include "core/gates/plan.hpp"
#include "daemon/net/can_routes.hpp"

namespace mlcca {

/// The rules that carry the frames of a grant from one interface to another, or why can-gw cannot.
[[nodiscard]] std::expected<std::vector<net::CanRule>, std::string> rules_of(
    const core::Transit& transit, int from, int to);

/// Rules that are wanted, and the channel (a number of the caller's) of each.
using Wanted = std::map<net::CanRule, std::size_t>;

struct RuleChanges {
  std::vector<net::CanRuleThere> remove;  ///< only ours
  std::vector<net::CanRuleThere> add;
  /// A rule of another program carries some of its frames as well, or changes them. Where one
  /// carries all of them as they were granted none of ours is made.
  std::vector<net::CanRule> in_way;
};
/// Ours are known by their numbers, whoever made them: a daemon that died, too.
[[nodiscard]] RuleChanges difference(const Wanted& wanted,
                                     const std::vector<net::CanRuleThere>& there);

/// What a rule does to the identifier or the frame: "id to 101", empty: nothing.
[[nodiscard]] std::string change_of(const net::CanRuleThere& there);

}  // namespace mlcca
