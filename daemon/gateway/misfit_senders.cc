// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/misfit_senders.hpp"

#include <algorithm>
#include <utility>

namespace mlcca {
namespace {

/// How many of a sender's frames a former state of the table contains.
std::uint64_t counted_in(const std::map<std::size_t, gates::RefusedSender>& table,
                         const gates::RefusedSender& sender) {
  const auto before = table.find(sender.place);
  const bool is_same = before != table.end() && gates::is_same(before->second, sender) &&
                       sender.frame.count >= before->second.frame.count;
  return is_same ? before->second.frame.count : 0;
}

}  // namespace

void MisfitSenders::begin_round() {
  for (std::size_t p = 0; p < gates_.size(); ++p) {
    const int ifindex = gates_.gated_interface(p);
    const auto [known, fresh] = of_ports_.try_emplace(p);
    OfPort& port = known->second;
    BySender now;
    for (const gates::RefusedSender& sender : gates_.refused_senders(p))
      now.emplace(sender.place, sender);
    if (fresh || port.ifindex != ifindex) {
      port = OfPort{};
      port.ifindex = ifindex;
      port.began = now;
    }
    port.reads = 1;
    port.before = std::exchange(port.began, std::move(now));
  }
}

/// What is more than `frames` is left to the next sample: the slot has not counted it yet.
std::vector<MisfitSenders::Sent> MisfitSenders::of(const core::GateEntry& entry,
                                                   std::uint64_t frames) {
  std::vector<Sent> out;
  const auto slot = gates_.slot_number(entry);
  const auto known = of_ports_.find(entry.port);
  if (!slot || known == of_ports_.end()) return out;
  OfPort& port = known->second;
  if (port.reads < kReadsOfRound) {
    ++port.reads;
    port.latest = gates_.refused_senders(entry.port);
  }
  for (const gates::RefusedSender& sender : port.latest) {
    if (sender.slot != *slot) continue;
    const std::uint64_t counted =
        std::max(counted_in(port.sampled, sender), counted_in(port.before, sender));
    const std::uint64_t given = std::min(frames, sender.frame.count - counted);
    gates::RefusedSender& taken = port.sampled[sender.place];
    taken = sender;
    taken.frame.count = counted + given;
    frames -= given;
    if (given != 0) out.push_back({sender, given});
  }
  return out;
}

}  // namespace mlcca
