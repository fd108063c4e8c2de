// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/kernel_copies.hpp"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/gw.h>

#include <algorithm>

namespace mlcca::learn {
namespace {

/// Applies a struct can_filter; an inverted one takes identifiers that do not match.
bool takes(std::uint32_t id, std::uint32_t mask, std::uint32_t can_id) {
  const bool inverted = (id & CAN_INV_FILTER) != 0;
  const std::uint32_t wanted = id & ~CAN_INV_FILTER & mask;
  return ((can_id & mask) == wanted) != inverted;
}

/// Why the copies of a rule cannot be in a draft; empty: they can.
std::string obstacle(const net::CanRuleThere& there) {
  if (there.changes_more)
    return "changes them: mlccad carries frames as they are, so the draft does not have what "
           "crosses there";
  if (there.rule.translates())
    return (there.flags & CGW_FLAGS_CAN_ECHO) != 0
               ? "gives them other identifiers: the draft has one channel of both only where their "
                 "data says so, which a note names"
               : "gives them other identifiers: state these on both networks, the draft does not "
                 "have what crosses there";
  return {};
}

}  // namespace

KernelCopies::KernelCopies(std::span<const net::CanRuleThere> rules,
                           const std::vector<std::string>& listened, Interfaces& numbers,
                           const NameOf& name_of) {
  const auto is_listened = [&](const std::string& name) {
    return std::ranges::find(listened, name) != listened.end();
  };
  for (const net::CanRuleThere& there : rules) {
    const std::string from = name_of(there.rule.from);
    const std::string to = name_of(there.rule.to);
    if (!is_listened(from)) continue;
    const auto note = [&](std::string_view what) {
      std::string text = fmt::format("a rule of can-gw carries frames of {} to {} and {}", from,
                                     to.empty() ? "an interface that is gone" : to, what);
      if (std::ranges::find(notes_, text) == notes_.end()) notes_.push_back(std::move(text));
    };
    if (!is_listened(to)) {
      note("learn does not listen there: name both interfaces");
    } else if (const std::string why = obstacle(there); !why.empty()) {
      note(why);
    } else {
      rules_.push_back({numbers.number_of(from), numbers.number_of(to), there.rule.id,
                        there.rule.mask, there.rule.fd, (there.flags & CGW_FLAGS_CAN_ECHO) != 0});
    }
  }
}

bool KernelCopies::Rule::carries(const Frame& frame) const {
  return fd == frame.fd && takes(id, mask, frame.id);
}

void KernelCopies::copies_of(const Frame& frame, std::optional<std::uint32_t> origin,
                             const OnFrame& on_copy) const {
  if (frame.datagram) return;
  for (const Rule& rule : rules_)
    if (rule.seen && rule.to == frame.interface && origin == rule.from && rule.carries(frame))
      return;
  std::uint64_t made = 0;  // one bit for each interface: two rules may forward the same frame to it
  for (const Rule& rule : rules_) {
    const std::uint64_t bit = std::uint64_t{1} << rule.to;
    if (rule.seen || rule.from != frame.interface || (made & bit) != 0 || !rule.carries(frame))
      continue;
    made |= bit;
    Frame copy = frame;
    copy.interface = rule.to;
    copy.local = false;
    on_copy(copy);
  }
}

}  // namespace mlcca::learn
