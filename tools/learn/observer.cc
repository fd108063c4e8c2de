// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/observer.hpp"

#include <algorithm>
#include <utility>

#include "base/hash.hpp"
#include "core/can/wire.hpp"
#include "core/profiles/profile.hpp"
#include "relay/fd_length.hpp"

namespace mlcca::learn {
namespace {

constexpr std::size_t kMostPriorities = 8;
constexpr std::uint64_t kFewestCopies = 3;
constexpr double kCopied = 0.9;  // share of a flow's events that must have been on another
                                 // interface

core::can::WireLength wire_length_of(const Frame& frame) {
  core::can::WireFrame wire{.id = frame.id & kIdentifierBits,
                            .extended = frame.is_extended(),
                            .fd = frame.fd,
                            .remote = (frame.id & kRemote) != 0,
                            .switches = frame.fd,
                            .size = static_cast<std::uint8_t>(frame.data.size())};
  std::ranges::copy(frame.data, wire.data.begin());
  return core::can::wire_length(wire);
}

/// A hash of identifier and data; never 0, which marks an empty entry.
std::uint64_t content_of(const Frame& frame) {
  std::uint64_t hash = kHashOfNothing;
  for (unsigned shift = 0; shift < 32; shift += 8)
    hash = hash_with(hash, static_cast<std::uint8_t>(frame.id >> shift & 0xffU));
  for (const std::uint8_t byte : frame.data) hash = hash_with(hash, byte);
  return hash | 1U;
}

/// A hash of length and first bytes; nullopt if these are not known. The length is rounded up to
/// one that CAN FD has, because events are padded with zeros there.
std::optional<std::uint64_t> content_of(const Event& event) {
  if (event.remote || event.head.size() < std::min<std::size_t>(event.bytes, kHead))
    return std::nullopt;
  const auto head = event.head.first(std::min(event.head.size(), kHead));
  const auto filled = relay::fd_length(event.bytes);
  const std::uint32_t bytes = filled ? *filled : event.bytes;
  std::uint64_t hash = kHashOfNothing;
  for (unsigned shift = 0; shift < 32; shift += 8)
    hash = hash_with(hash, static_cast<std::uint8_t>(bytes >> shift & 0xffU));
  for (const std::uint8_t byte : head) hash = hash_with(hash, byte);
  for (std::size_t i = head.size(); filled && i < bytes; ++i) hash = hash_with(hash, 0);
  return hash;
}

}  // namespace

// --- copies --------------------------------------------------------------------------------------

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
    // The latest occurrence counts, because copies are forwarded, too.
    if (!out || entry.ns > out->ns) out = Origin{other, entry.ns};
  }
  // A copy must not be recognised as origin of a frame on the interface that it came from.
  const std::uint64_t copied_to = out ? std::uint64_t{1} << out->interface : 0;
  (*recent_[frame.interface])[slot] = {hash, frame.ns, copied_to};
  return out;
}

std::optional<double> Observer::Interface::load_percent(std::uint32_t bitrate,
                                                        std::uint32_t data_bitrate) const {
  if (bitrate == 0 || (fast_bits != 0 && data_bitrate == 0) || !timeline.tells_rate(frames))
    return std::nullopt;
  double seconds = static_cast<double>(slow_bits) / bitrate;
  if (fast_bits != 0) seconds += static_cast<double>(fast_bits) / data_bitrate;
  return seconds * 1e9 / static_cast<double>(timeline.covered()) * 100;
}

// --- flows ---------------------------------------------------------------------------------------

Observer::Interface& Observer::at(std::uint32_t interface) {
  if (interfaces_.size() <= interface) {
    interfaces_.resize(interface + 1);
    kept_.resize(interface + 1);
  }
  return interfaces_[interface];
}

void Observer::state(std::uint32_t interface, core::Profile profile) {
  Interface& of = at(interface);
  of.is_stated = true;
  of.recognised = Recognised{profile, 100, "it is stated"};
  of.decoder = std::make_unique<Decoder>(profile);
}

std::optional<std::uint32_t> Observer::add(const Frame& frame) {
  Interface& of = at(frame.interface);
  ++of.frames;
  const Stretch stretch =
      of.timeline.take(frame.ns, static_cast<std::uint32_t>(recordings_.size() - 1));
  if (frame.datagram) {
    of.medium = Medium::ethernet;
    if (!of.datagrams) of.datagrams = std::make_unique<Datagrams>();
    of.datagrams->take(frame, [&](const Event& event) {
      Seen* const seen = record(frame.interface, event, stretch);
      if (seen != nullptr) seen->mac = event.mac;
    });
    return std::nullopt;
  }
  of.medium = Medium::can;
  const auto length = wire_length_of(frame);
  of.slow_bits += length.slow;
  of.fast_bits += length.fast;
  const auto origin = copies_.origin_of(frame);
  const auto before = origin ? std::optional(origin->interface) : std::nullopt;
  if (of.decoder) {
    follow(frame, origin, stretch);
    return before;
  }
  of.recogniser.add(frame);
  Kept& kept = kept_[frame.interface].emplace_back();
  std::ranges::copy(frame.data, kept.data.begin());
  kept.frame = frame;
  kept.origin = origin;
  kept.stretch = stretch;
  if (of.recogniser.frames() == Recogniser::kMost) decide(frame.interface);
  return before;
}

void Observer::decide(std::uint32_t interface) {
  Interface& of = interfaces_[interface];
  of.recognised = of.recogniser.result();
  of.decoder = std::make_unique<Decoder>(of.recognised->profile);
  for (Kept& kept : std::exchange(kept_[interface], {})) {
    kept.frame.data = {kept.data.data(), kept.frame.data.size()};
    follow(kept.frame, kept.origin, kept.stretch);
  }
}

void Observer::finish(std::size_t interfaces, std::span<const Medium> media) {
  if (interfaces != 0) at(static_cast<std::uint32_t>(interfaces - 1));
  for (std::uint32_t i = 0; i < interfaces_.size(); ++i) {
    Interface& of = interfaces_[i];
    if (of.medium == Medium::unknown && i < media.size()) of.medium = media[i];
    if (of.medium != Medium::ethernet) {
      if (!of.decoder) decide(i);
      continue;
    }
    if (!of.datagrams) of.datagrams = std::make_unique<Datagrams>();
    if (!of.is_stated || !core::has_datagrams(of.recognised->profile))
      of.recognised = of.datagrams->recognised();
  }
  find_origins();
}

Seen* Observer::record(std::uint32_t interface, const Event& event, Stretch stretch) {
  const FlowKey key{interface, event.number, event.node, event.local};
  auto known = flows_.find(key);
  if (known == flows_.end()) {
    if (flows_.size() == kMostFlows) {
      ++interfaces_[interface].unfollowed;
      return nullptr;
    }
    known = flows_.try_emplace(key).first;
    known->second.number = static_cast<std::uint32_t>(order_.size());
    order_.push_back(key);
  }
  Seen& seen = known->second;
  seen.flow.add(event.ns, event.bytes, stretch);
  seen.frame_bytes = std::max(seen.frame_bytes, event.frame_bytes);
  if (seen.priorities.size() < kMostPriorities) seen.priorities.insert(event.priority);
  if (event.fd) ++seen.fd;
  if (event.remote) ++seen.remote;
  if (event.broadcast) ++seen.broadcasts;
  seen.control = event.control;
  // Heart-beats of all nodes are alike, so they are only compared between buses, by identifier.
  if (const auto content = content_of(event); content && !event.control) {
    crossings_.add(seen.number, interface, event.ns, *content);
    if (interfaces_[interface].medium == Medium::can) seen.variety.add(event.head);
  }
  return &seen;
}

void Observer::follow(const Frame& frame, const std::optional<Copies::Origin>& origin,
                      Stretch stretch) {
  Interface& of = interfaces_[frame.interface];
  const std::uint64_t lost = of.decoder->lost_control_frames();
  of.decoder->take(frame, [&](const Event& event) {
    Seen* const seen = record(frame.interface, event, stretch);
    if (seen != nullptr && origin) seen->from[origin->interface].add(frame.ns - origin->ns);
  });
  if (!origin || of.decoder->lost_control_frames() == lost) return;
  const std::pair which(frame.id & (kExtended | kIdentifierBits), origin->interface);
  if (of.crossed_control.size() < kMostControl || of.crossed_control.contains(which))
    ++of.crossed_control[which];
}

// --- origins -------------------------------------------------------------------------------------

/// The flow on another bus on which most of the events of `seen` had been before; nullptr if there
/// is none.
const FlowKey* Observer::origin_on_can(const FlowKey& key, Seen& seen) const {
  const auto most =
      std::ranges::max_element(seen.from, {}, [](const auto& one) { return one.second.events; });
  const std::uint64_t events = seen.flow.events();
  if (most == seen.from.end() || events < kFewestCopies ||
      static_cast<double>(most->second.events) < kCopied * static_cast<double>(events))
    return nullptr;
  for (const bool local : {false, true}) {
    const auto before = flows_.find({most->first, key.number, key.node, local});
    if (before == flows_.end()) continue;
    seen.crossing = most->second;
    return &before->first;
  }
  return nullptr;
}

void Observer::find_origins() {
  std::vector<Crossings::Of> all(order_.size());
  for (auto& [key, seen] : flows_) {
    const bool ethernet = interfaces_[key.interface].medium == Medium::ethernet;
    const FlowKey* const origin = ethernet ? nullptr : origin_on_can(key, seen);
    if (origin != nullptr) seen.origin = *origin;
    all[seen.number] = {.interface = key.interface,
                        .ethernet = ethernet,
                        .number = key.number,
                        .local = key.local,
                        .changes = seen.variety.changes(),
                        .rich = seen.variety.is_rich(),
                        .origin = {}};
  }
  for (const auto& [key, seen] : flows_)
    if (seen.origin) all[seen.number].origin = flows_.at(*seen.origin).number;
  const auto crossings = crossings_.find(std::move(all));
  for (const Crossings::Found& found : crossings) {
    const FlowKey& copy = order_[found.copy];
    const FlowKey& origin = order_[found.origin];
    if (!found.sure) {
      alike_.push_back({copy, origin, found});
      continue;
    }
    Seen& seen = flows_.at(copy);
    seen.origin = origin;
    seen.crossing = found.crossing;
    if (found.renumbered) seen.renumbered = found;
  }
}

}  // namespace mlcca::learn
