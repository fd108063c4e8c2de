// SPDX-License-Identifier: BSD-2-Clause
// Computes which rules can-gw must have for what was granted from one CAN bus to another, and the
// changes that lead to them. No I/O; docs/adr/0019 gives the reasons.
#pragma once
#include <cstdint>
#include <expected>
#include <map>
#include <string>
#include <vector>

#include "core/gates/plan.hpp"
#include "daemon/net/can_routes.hpp"

namespace mlcca {

/// The rules that carry the frames of a grant from interface index `from` to `to`. The error says
/// why can-gw cannot carry them.
[[nodiscard]] std::expected<std::vector<net::CanRule>, std::string> rules_of(
    const core::Transit& transit, int from, int to);

/// The wanted rules, each with a channel (a number of the caller's) that needs it.
using Wanted = std::map<net::CanRule, std::size_t>;

/// The changes that make the rules of the kernel those that are wanted.
struct RuleChanges {
  std::vector<net::CanRuleThere> remove;  ///< only our own rules
  std::vector<net::CanRuleThere> add;
  /// Wanted rules for which a rule of another program carries some of the frames as well, or
  /// changes them. If such a rule carries all of them as they were granted, we make none.
  std::vector<net::CanRule> in_way;
};
/// Compares wanted rules with those of the kernel. Our own rules are recognised by their numbers,
/// also those that a daemon has left that died.
[[nodiscard]] RuleChanges rule_changes_between(const Wanted& wanted,
                                               const std::vector<net::CanRuleThere>& there);

/// What a rule changes in the frame, for example "id to 101"; empty if nothing.
[[nodiscard]] std::string change_of(const net::CanRuleThere& there);

}  // namespace mlcca
