// SPDX-License-Identifier: BSD-2-Clause
// Topology packets, with big-endian integers. Octets: 0 type (1 flood, bit 7 trace), 1-6 source,
// 7-8 sequence, 9-14 last hop, 15 TTL, 16 kind of flood (0 topology), 17-20 validity, 21 number of
// links, 8 for each link, length of the name, name.
#include "tools/sources/awds_packet.hpp"

#include <algorithm>
#include <utility>

namespace mlcca::net::awds {
namespace {

using core::mesh::AwdsMetric;
using core::mesh::Sample;

constexpr std::uint8_t kTypeMask = 0x03;
constexpr std::uint8_t kFlood = 1;
constexpr std::uint8_t kTopologyFlood = 0;
constexpr std::uint64_t kNanosPerMilli = 1'000'000;
constexpr std::uint64_t kNoBackward = (std::uint64_t{1} << 22) - 1;

/// Reads integers and octets from the front. After the first one beyond the end every value is 0.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool complete() const { return complete_; }
  std::span<const std::uint8_t> octets(std::size_t count) {
    if (count > bytes_.size()) {
      complete_ = false;
      bytes_ = {};
      return {};
    }
    const auto front = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return front;
  }
  std::uint32_t integer(std::size_t size) {
    std::uint32_t value = 0;
    for (const std::uint8_t octet : octets(size)) value = (value << 8U) | octet;
    return value;
  }
  NodeId id() {
    NodeId id{};
    std::ranges::copy(octets(id.size()), id.begin());
    return id;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  bool complete_ = true;
};

/// The loss of a link whose `quality` states how many of 32 beacons were lost.
std::optional<Value> etx_loss(std::uint16_t quality) {
  constexpr std::uint32_t step = 2047;
  constexpr std::uint32_t window = 32;
  if (quality == 1) return 0;  // no loss: AWDS does not send 0
  if (quality == 0 || quality % step != 0 || quality > step * window) return std::nullopt;
  return Value{1'000'000'000} * (quality / step) / window;  // exact, because 32 divides 1e9
}

/// The rate in bit/s of a link on which 800 octets take quality / `per_second` seconds.
Value probe_rate(std::uint16_t quality, Value per_second) {
  constexpr Value probe_bits = 6400;
  const bool measured = quality != 0 && quality != 0xffff;
  return measured ? probe_bits * per_second / quality : 0;
}

}  // namespace

std::string address_of(const NodeId& id) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t octet : id) {
    if (!text.empty()) text += ':';
    text += digits[octet >> 4U];
    text += digits[octet & 0xfU];
  }
  return text;
}

std::optional<Topology> parse(std::span<const std::uint8_t> packet) {
  Reader reader(packet);
  if ((reader.integer(1) & kTypeMask) != kFlood) return std::nullopt;
  Topology out;
  out.source = reader.id();
  out.sequence = static_cast<std::uint16_t>(reader.integer(2));
  reader.octets(6 + 1);  // last hop and TTL do not matter: it is the same flood whoever relays it
  if (reader.integer(1) != kTopologyFlood) return std::nullopt;
  out.validity = reader.integer(4);
  const std::uint32_t links = reader.integer(1);
  if (links > kMaxNeighbours) return std::nullopt;
  for (std::uint32_t i = 0; i < links; ++i) {
    Neighbour neighbour;
    neighbour.id = reader.id();
    neighbour.quality = static_cast<std::uint16_t>(reader.integer(2));
    const bool twice =
        std::ranges::find(out.neighbours, neighbour.id, &Neighbour::id) != out.neighbours.end();
    if (twice || neighbour.id == out.source) return std::nullopt;
    out.neighbours.push_back(neighbour);
  }
  const std::uint32_t length = reader.integer(1);
  if (length > kMaxName) return std::nullopt;
  const auto name = reader.octets(length);
  out.name.assign(name.begin(), name.end());
  if (!reader.complete()) return std::nullopt;
  return out;
}

std::optional<Sample> sample_of(AwdsMetric metric, const NodeId& reporter,
                                const Neighbour& neighbour) {
  Sample sample;
  sample.from = address_of(reporter);
  sample.to = address_of(neighbour.id);
  sample.kind = core::mesh::RateKind::effective;
  switch (metric) {
    case AwdsMetric::hops:
      break;
    case AwdsMetric::etx:
      sample.loss = etx_loss(neighbour.quality);
      if (!sample.loss) return std::nullopt;
      std::swap(sample.from, sample.to);
      break;
    case AwdsMetric::packet_pair:
      sample.rate = probe_rate(neighbour.quality, 655'350);
      break;
    case AwdsMetric::transmission_time:
      sample.rate = probe_rate(neighbour.quality, 65'535);
      break;
  }
  return sample;
}

std::uint64_t weight_of(AwdsMetric metric, std::uint16_t forward,
                        std::optional<std::uint16_t> backward) {
  if (!backward) return kNoBackward;
  switch (metric) {
    case AwdsMetric::hops:
      return 1;
    case AwdsMetric::etx: {
      // 2048 / (n/32 * m/32) for n and m received beacons; 0 received beacons give the largest
      // cost.
      const std::uint64_t both = std::uint64_t{32U - std::min(32U, forward / 2047U)} *
                                 (32U - std::min(32U, *backward / 2047U));
      return both == 0 ? kNoBackward : std::min(kNoBackward, (std::uint64_t{1} << 21) / both);
    }
    case AwdsMetric::packet_pair:
      return std::uint64_t{forward} + *backward;
    case AwdsMetric::transmission_time:
      return forward;
  }
  return kNoBackward;
}

std::uint64_t Graph::Received::valid() const {
  return std::min(topology.validity * kNanosPerMilli, core::mesh::kMaxValidity);
}

void Graph::forget_expired(std::uint64_t now) {
  std::erase_if(nodes_,
                [now](const auto& node) { return now - node.second.at >= node.second.valid(); });
}

/// Makes room for a node. False: all known nodes have precedence.
bool Graph::make_room(bool for_described) {
  if (nodes_.size() < kMaxNodes) return true;
  crowded_ = true;
  if (!for_described) return false;
  auto last = nodes_.end();
  for (auto it = nodes_.begin(); it != nodes_.end(); ++it)
    if (!it->second.described && (last == nodes_.end() || it->second.since > last->second.since))
      last = it;
  if (last == nodes_.end()) return false;
  nodes_.erase(last);
  return true;
}

bool Graph::take(Topology topology, std::uint64_t now) {
  forget_expired(now);
  const auto known = nodes_.find(topology.source);
  // Sequence numbers wrap: the smaller distance shows which one is newer. A node that has restarted
  // counts from 0 and is accepted when its former packet has expired.
  if (known != nodes_.end() &&
      static_cast<std::int16_t>(topology.sequence - known->second.topology.sequence) <= 0)
    return false;
  if (known != nodes_.end()) {
    known->second.topology = std::move(topology);
    known->second.at = now;
    return true;
  }
  const NodeId source = topology.source;
  const bool described = described_.contains(address_of(source));
  if (!make_room(described)) return false;
  nodes_.emplace(source, Received{std::move(topology), now, now, described});
  return true;
}

std::optional<std::uint16_t> Graph::quality(const NodeId& reporter, const NodeId& neighbour) const {
  const auto node = nodes_.find(reporter);
  if (node == nodes_.end()) return std::nullopt;
  const auto& all = node->second.topology.neighbours;
  const auto it = std::ranges::find(all, neighbour, &Neighbour::id);
  if (it == all.end()) return std::nullopt;
  return it->quality;
}

core::mesh::Snapshot Graph::snapshot(std::uint64_t now) {
  forget_expired(now);
  core::mesh::Snapshot out;
  bool foreign = false;
  for (const auto& [reporter, received] : nodes_) {
    for (const auto& neighbour : received.topology.neighbours) {
      auto sample = sample_of(metric_, reporter, neighbour);
      if (!sample) {
        foreign = true;
        continue;
      }
      sample->weight = weight_of(metric_, neighbour.quality, quality(neighbour.id, reporter));
      sample->taken = received.at;
      sample->valid = received.valid();
      out.links.push_back(std::move(*sample));
    }
  }
  if (nodes_.empty()) out.problem = "no topology packet was received";
  if (std::exchange(crowded_, false))
    out.problem = "more than " + std::to_string(kMaxNodes) +
                  " nodes are known: further ones that are not described are ignored";
  if (out.links.empty() && foreign)
    out.problem = "the qualities that are sent are none of the described metric";
  return out;
}

}  // namespace mlcca::net::awds
