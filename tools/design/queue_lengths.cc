// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/queue_lengths.hpp"

#include <algorithm>
#include <tuple>

#include "core/design/inspect.hpp"

namespace mlcca::tools::design {
namespace {

/// The longest queue on a bus, in frames; 0 if nothing there has a bound.
std::uint32_t longest_queue(const core::InspectedBuses& buses, std::size_t network) {
  constexpr std::uint32_t most = 10'000;  // limit of the schema
  std::uint32_t longest = 0;
  for (const core::SentMessage& sent : core::all_sent(buses, network))
    if (sent.message->message->queue != core::can::kOwnQueue && sent.response.bounded)
      longest = std::max(longest, sent.response.queued_frames);
  return std::min(longest, most);
}

/// Lengthens the queues of the ports on the network. False if none was shorter than `frames`.
bool lengthen(core::System& system, std::size_t network, std::uint32_t frames) {
  bool changed = false;
  for (core::Gateway& gateway : system.gateways)
    for (core::Port& port : gateway.ports) {
      if (port.network != network || port.queue_length >= frames) continue;
      port.queue_length = frames;
      changed = true;
    }
  return changed;
}

}  // namespace

bool needs_longer_queues(const core::System& system, const core::InspectedBuses& buses) {
  for (std::size_t n = 0; n < buses.assumptions.size(); ++n) {
    const std::uint32_t frames = longest_queue(buses, n);
    if (frames <= core::Port().queue_length) continue;
    for (const core::Gateway& gateway : system.gateways)
      for (const core::Port& port : gateway.ports)
        if (port.network == n && port.queue_length < frames) return true;
  }
  return false;
}

std::map<std::size_t, std::uint32_t> lengthen_queues(core::System& system) {
  std::map<std::size_t, std::uint32_t> out;
  // With a longer queue more is granted, which delays other messages, so that their queues grow,
  // too.
  constexpr int rounds = 16;
  bool changed = true;
  for (int round = 0; changed && round < rounds; ++round) {
    changed = false;
    core::InspectedBuses buses;
    std::ignore = core::inspect(system, {}, {}, &buses);
    for (std::size_t n = 0; n < buses.assumptions.size(); ++n) {
      const std::uint32_t frames = longest_queue(buses, n);
      if (frames <= core::Port().queue_length || !lengthen(system, n, frames)) continue;
      out[n] = frames;
      changed = true;
    }
  }
  return out;
}

}  // namespace mlcca::tools::design
