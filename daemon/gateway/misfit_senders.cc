// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/misfit_senders.hpp"

#include <algorithm>
#include <tuple>

namespace mlcca {
namespace {

auto identity_of(const enforce::RefusedSender& sender) {
  const enforce::UnknownFrame& f = sender.frame;
  return std::tie(sender.slot, sender.reason, sender.source, sender.uid, f.can_id, f.format,
                  f.direction, f.subject, f.station, f.mac);
}

}  // namespace

void MisfitSenders::begin_round() {
  for (std::size_t p = 0; p < gates_.size(); ++p) {
    const int ifindex = gates_.gated_interface(p);
    const auto [known, fresh] = of_ports_.try_emplace(p);
    OfPort& port = known->second;
    port.reads = 0;
    if (!fresh && port.ifindex == ifindex) continue;
    port = {.ifindex = ifindex, .reads = 0, .latest = {}, .sampled = {}};
    for (const enforce::RefusedSender& sender : gates_.refused_senders(p))
      port.sampled[sender.place] = sender;
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
  for (const enforce::RefusedSender& sender : port.latest) {
    if (sender.slot != *slot) continue;
    enforce::RefusedSender& before = port.sampled[sender.place];
    const bool is_same =
        identity_of(before) == identity_of(sender) && sender.frame.count >= before.frame.count;
    const std::uint64_t counted = is_same ? before.frame.count : 0;
    const std::uint64_t given = std::min(frames, sender.frame.count - counted);
    before = sender;
    before.frame.count = counted + given;
    frames -= given;
    if (given != 0) out.push_back({sender, given});
  }
  return out;
}

}  // namespace mlcca
