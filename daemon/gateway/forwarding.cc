// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/forwarding.hpp"

#include <fmt/core.h>
#include <linux/can.h>

#include <algorithm>
#include <set>

#include "core/profiles/profile.hpp"

namespace mlcca {
namespace {

using net::CanRule;
using net::CanRuleThere;

const char* format_of(const core::GateEntry& e) {
  if (e.classic && e.fd) return "classic or FD";
  return e.fd ? "FD" : "classic";
}

/// Which frames of a rule match the filter of another rule between the same interfaces.
enum class Meets : std::uint8_t { never, sometimes, always };

Meets meets(const CanRule& ours, const CanRule& other) {
  if (ours.from != other.from || ours.to != other.to || ours.fd != other.fd) return Meets::never;
  const std::uint32_t mask = other.mask & ~CAN_ERR_FLAG;
  // A filter that compares the form of the identifier and states the 11-bit form compares only 11
  // bits.
  const bool standard = (mask & CAN_EFF_FLAG) != 0 && (other.id & CAN_EFF_FLAG) == 0;
  const std::uint32_t compared =
      standard ? mask & (CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG) : mask;
  const bool agree = ((ours.id ^ other.id) & ours.mask & compared) == 0;
  const bool within = agree && (compared & ~ours.mask) == 0;
  const bool inverted = (other.id & CAN_INV_FILTER) != 0;
  if (!agree) return inverted ? Meets::always : Meets::never;
  if (!within) return Meets::sometimes;
  return inverted ? Meets::never : Meets::always;
}

/// The rules of other programs, by interfaces.
using Others = std::map<std::pair<int, int>, std::vector<const CanRuleThere*>>;

Others rules_of_others(const std::vector<CanRuleThere>& there) {
  Others others;
  for (const CanRuleThere& t : there)
    if (!t.is_ours()) others[{t.rule.from, t.rule.to}].push_back(&t);
  return others;
}

/// What rules of other programs do with the frames of a rule.
struct Carried {
  bool all = false;        ///< one rule carries all of them as they were granted: we need none
  bool disturbed = false;  ///< some frames are carried twice, or changed
};

Carried carried(const CanRule& rule, const Others& others) {
  Carried out;
  const auto known = others.find({rule.from, rule.to});
  if (known == others.end()) return out;
  for (const CanRuleThere* other : known->second) {
    const Meets met = meets(rule, other->rule);
    const bool same =
        !other->changes_more && other->rule.keep == rule.keep && other->rule.set == rule.set;
    if (met == Meets::always && same)
      out.all = true;
    else if (met != Meets::never)
      out.disturbed = true;
  }
  return out;
}

/// Adds rules for the frames of J1939's transport protocol. Those that carry messages of several
/// PGNs of one source have one rule for all priorities, so that nothing is carried twice. The gate
/// of the other bus distinguishes the PGNs.
void add_carriers(const core::GateEntry& in, std::vector<CanRule>& rules) {
  constexpr std::uint32_t priority = 0x1c000000;
  const core::Fragmentation& transport = core::transport_protocol();
  CanRule rule = rules.front();
  rule.fd = false;
  for (const core::FrameIdentity& carrier : transport.carriers({.id = in.id, .mask = in.mask})) {
    rule.mask = (carrier.mask & ~priority) | core::kRemoteFlag;
    rule.id = carrier.id & rule.mask;
    rules.push_back(rule);
  }
}

std::uint32_t free_uid(std::set<std::uint32_t>& taken, std::uint32_t& from) {
  while (from < net::kLastUid && taken.contains(from)) ++from;
  taken.insert(from);
  return from;
}

}  // namespace

std::expected<std::vector<CanRule>, std::string> rules_of(const core::Transit& transit, int from,
                                                          int to) {
  const core::GateEntry& in = transit.in;
  const core::GateEntry& out = transit.out;
  if (in.xl || out.xl) return std::unexpected(std::string("can-gw carries no CAN XL frames"));
  if (!(in.classic && out.classic) && !(in.fd && out.fd))
    return std::unexpected(
        fmt::format("can-gw makes no {} frames of {} ones", format_of(out), format_of(in)));
  // One side may leave open whether frames are remote, which then simply stay behind. It may not
  // leave open whether events are fragmented, or anything else that a profile leaves to the sender.
  if (((in.mask ^ out.mask) & ~core::kRemoteFlag) != 0)
    return std::unexpected(
        std::string("can-gw carries frames as they are, and only one of the buses has events "
                    "in several fragments, or leaves that part of the identifier to the sender"));
  CanRule rule;
  rule.from = from;
  rule.to = to;
  rule.mask = in.mask | out.mask;
  rule.id = in.id & rule.mask;
  if (in.id != out.id) {
    rule.keep = ~rule.mask;
    rule.set = out.id;
  }
  if (in.transport != out.transport || (in.transport && (in.id != out.id || in.mask != out.mask)))
    return std::unexpected(
        std::string("can-gw carries frames as they are, and a message of the transport protocol "
                    "names its PGN within them"));
  std::vector<CanRule> rules;
  for (const bool fd : {false, true}) {
    rule.fd = fd;
    if (fd ? in.fd && out.fd : in.classic && out.classic) rules.push_back(rule);
  }
  if (in.transport) add_carriers(in, rules);
  return rules;
}

RuleChanges rule_changes_between(const Wanted& wanted, const std::vector<CanRuleThere>& there) {
  RuleChanges changes;
  const Others others = rules_of_others(there);
  std::set<CanRule> missing;
  for (const auto& [rule, channel] : wanted) {
    const Carried by_others = carried(rule, others);
    // What was granted arrives, whatever rules of other programs do with further copies.
    if (!by_others.all) missing.insert(rule);
    if (by_others.disturbed) changes.in_way.push_back(rule);
  }
  std::set<std::uint32_t> taken;
  for (const CanRuleThere& t : there) {
    if (!t.is_ours()) continue;
    taken.insert(t.uid);  // also the number of a rule that is removed: the removal may fail
    if (t.changes_more || missing.erase(t.rule) == 0) changes.remove.push_back(t);
  }
  std::uint32_t next = net::kFirstUid;
  for (const CanRule& rule : missing)
    if (taken.size() <= net::kLastUid - net::kFirstUid)
      changes.add.push_back(net::ours(rule, free_uid(taken, next)));
  return changes;
}

std::string change_of(const CanRuleThere& there) {
  if (there.changes_more) return "the frame";
  if (!there.rule.translates()) return {};
  const std::uint32_t id = there.rule.set;
  const bool extended = (id & CAN_EFF_FLAG) != 0;
  const std::uint32_t bits = extended ? CAN_EFF_MASK : CAN_SFF_MASK;
  const int digits = extended ? 8 : 3;
  const std::uint32_t changed = (~there.rule.keep | id) & bits;
  const auto to = fmt::format("id to {:0{}x}", id & bits, digits);
  return changed == bits ? to : to + fmt::format("/{:0{}x}", changed, digits);
}

}  // namespace mlcca
