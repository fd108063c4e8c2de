// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/observer.hpp"

#include <algorithm>
#include <utility>

#include "base/hash.hpp"

namespace mlcca::learn {
namespace {

constexpr std::size_t kMostPriorities = 8;

/// Of identifier and data; 0 stands for nothing.
std::uint64_t content_of(const Frame& frame) {
  std::uint64_t hash = kHashOfNothing;
  for (unsigned shift = 0; shift < 32; shift += 8)
    hash = hash_with(hash, static_cast<std::uint8_t>(frame.id >> shift & 0xffU));
  for (const std::uint8_t byte : frame.data) hash = hash_with(hash, byte);
  return hash | 1U;
}

}  // namespace

// --- copies
// ----------------------------------------------------------------------------------------

std::optional<Copies::Origin> Copies::origin_of(const Frame& frame) {
  while (recent_.size() <= frame.interface)
    recent_.push_back(std::make_unique<std::array<Entry, kEntries>>());
  const std::uint64_t hash = content_of(frame);
  const std::size_t slot = (hash >> 20U) % kEntries;
  std::optional<Origin> out;
  for (std::uint32_t other = 0; other < recent_.size(); ++other) {
    if (other == frame.interface) continue;
    Entry& entry = (*recent_[other])[slot];
    const std::uint64_t bit = std::uint64_t{1} << frame.interface;
    if (entry.hash != hash || frame.ns < entry.ns || frame.ns - entry.ns > kWindow ||
        (entry.copied_to & bit) != 0)
      continue;
    entry.copied_to |= bit;
    // The latest one before it: a copy is made of a copy, too.
    if (!out || entry.ns > out->ns) out = Origin{other, entry.ns};
  }
  // What is a copy has been where it came from.
  const std::uint64_t copied_to = out ? std::uint64_t{1} << out->interface : 0;
  (*recent_[frame.interface])[slot] = {hash, frame.ns, copied_to};
  return out;
}

// --- flows
// -----------------------------------------------------------------------------------------

Observer::Interface& Observer::at(std::uint32_t interface) {
  if (interfaces_.size() <= interface) {
    interfaces_.resize(interface + 1);
    kept_.resize(interface + 1);
  }
  return interfaces_[interface];
}

void Observer::state(std::uint32_t interface, core::Profile profile) {
  Interface& of = at(interface);
  of.recognised = Recognised{profile, 100, "it is stated"};
  of.decoder = std::make_unique<Decoder>(profile);
}

void Observer::add(const Frame& frame) {
  Interface& of = at(frame.interface);
  ++of.frames;
  const auto origin = copies_.origin_of(frame);
  if (of.decoder) {
    follow(frame, origin);
    return;
  }
  of.recogniser.add(frame);
  Kept& kept = kept_[frame.interface].emplace_back();
  std::ranges::copy(frame.data, kept.data.begin());
  kept.frame = frame;
  kept.origin = origin;
  if (of.recogniser.frames() == Recogniser::kMost) decide(frame.interface);
}

void Observer::decide(std::uint32_t interface) {
  Interface& of = interfaces_[interface];
  of.recognised = of.recogniser.result();
  of.decoder = std::make_unique<Decoder>(of.recognised->profile);
  for (Kept& kept : std::exchange(kept_[interface], {})) {
    kept.frame.data = {kept.data.data(), kept.frame.data.size()};
    follow(kept.frame, kept.origin);
  }
}

void Observer::finish(std::size_t interfaces) {
  if (interfaces != 0) at(static_cast<std::uint32_t>(interfaces - 1));
  for (std::uint32_t i = 0; i < interfaces_.size(); ++i)
    if (!interfaces_[i].decoder) decide(i);
}

void Observer::follow(const Frame& frame, const std::optional<Copies::Origin>& origin) {
  interfaces_[frame.interface].decoder->take(frame, [&](const Event& event) {
    const FlowKey key{frame.interface, event.number, event.node, event.local};
    auto known = flows_.find(key);
    if (known == flows_.end()) {
      if (flows_.size() == kMostFlows) {
        ++interfaces_[frame.interface].unfollowed;
        return;
      }
      known = flows_.try_emplace(key).first;
    }
    Seen& seen = known->second;
    seen.flow.add(event.ns, event.bytes);
    seen.frame_bytes = std::max(seen.frame_bytes, event.frame_bytes);
    if (seen.priorities.size() < kMostPriorities) seen.priorities.insert(event.priority);
    if (event.fd) ++seen.fd;
    if (event.remote) ++seen.remote;
    if (!origin) return;
    Crossing& crossing = seen.from[origin->interface];
    const std::uint64_t took = frame.ns - origin->ns;
    ++crossing.events;
    crossing.longest_ns = std::max(crossing.longest_ns, took);
    crossing.shortest_ns = std::min(crossing.shortest_ns, took);
  });
}

}  // namespace mlcca::learn
