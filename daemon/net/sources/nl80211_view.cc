// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/nl80211_view.hpp"

#include <linux/nl80211.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <string_view>

namespace mlcca::net::nl80211 {
namespace {

using core::mesh::RateKind;
using core::mesh::Sample;

constexpr std::size_t kLossPolls = 10;
constexpr std::uint64_t kLossPackets = 20;  // fewer packets do not give a meaningful share
constexpr std::uint64_t kLossScale = 1'000'000'000;
constexpr unsigned kSlowPolls = 3;
constexpr std::size_t kBusyPolls = 2;
constexpr std::uint64_t kBusyTime = 500;  // ms
constexpr std::uint64_t kNanosPerMilli = 1'000'000;

constexpr std::uint64_t kMetricBits = 8192;
constexpr std::uint64_t kNoLink = std::numeric_limits<std::uint32_t>::max();

bool is_peer(const Station& station, bool mesh) {
  return !mesh || station.plink_state == std::optional<std::uint8_t>(NL80211_PLINK_ESTAB);
}

/// The metric of a path is that of a link only if the path consists of that link.
std::map<std::string_view, std::uint32_t> metrics_of_links(const Seen& seen) {
  std::map<std::string_view, std::uint32_t> out;
  for (const MeshPath& path : seen.paths)
    if (path.destination == path.next_hop && path.hops == 1 &&
        (path.flags & NL80211_MPATH_FLAG_ACTIVE) != 0)
      out.try_emplace(path.destination, path.metric);
  return out;
}

}  // namespace

void GrowingPart::add(std::uint64_t whole, std::uint64_t part) {
  if (!seen_.empty() && (whole < seen_.back().whole || part < seen_.back().part)) seen_.clear();
  seen_.push_back({.whole = whole, .part = part});
  if (seen_.size() > polls_ + 1) seen_.pop_front();
}

std::optional<std::uint64_t> GrowingPart::share(std::uint64_t least, std::uint64_t scale) const {
  if (seen_.empty()) return {};
  const std::uint64_t whole = seen_.back().whole - seen_.front().whole;
  const std::uint64_t part = seen_.back().part - seen_.front().part;
  if (whole < least) return {};
  if (part >= whole) return scale;
  return (part * scale + whole - 1) / whole;
}

std::optional<Value> rate_of_metric(std::uint32_t metric) {
  if (metric <= 1 || metric == kNoLink) return {};
  return kMetricBits * 1'000'000 / (metric - 1);
}

View::Memory& View::memory_of(const std::string& mac) {
  return stations_.try_emplace(mac, Memory{.given_up = GrowingPart(kLossPolls), .slow_at = {}})
      .first->second;
}

View::Rate View::judge(const Station& station, Memory& memory) {
  const Rate sent{.rate = station.tx_bitrate.value_or(0), .kind = RateKind::phy};
  if (!station.expected_throughput) return sent;
  const Rate expected{.rate = *station.expected_throughput, .kind = RateKind::effective};
  if (!station.tx_bitrate || sent.rate >= expected.rate) {
    memory.slow_at.reset();
    memory.slow_polls = 0;
    memory.slower = false;
    return expected;
  }
  // No more can get through than is sent. If rates are fixed manually, the rate control still
  // expects what it learned before. But a single slow frame may only have tested a rate, so several
  // in a row are required, each sent after the one before.
  const std::uint32_t packets = station.tx_packets.value_or(0);
  if (!memory.slower && memory.slow_at != packets) {
    memory.slow_at = packets;
    memory.slower = ++memory.slow_polls >= kSlowPolls;
    unconfirmed_ |= !memory.slower;
  }
  return memory.slower ? sent : expected;
}

std::optional<std::uint32_t> View::busy_of(const Seen& seen) {
  const auto used = std::ranges::find_if(seen.surveys, &Survey::in_use);
  if (used == seen.surveys.end() || !used->time || !used->busy) {
    busy_.reset();
    return {};
  }
  if (!busy_ || surveyed_ != used->frequency) busy_.emplace(kBusyPolls);
  surveyed_ = used->frequency;
  // What this radio sends is reserved, so it must not count as busy time of others.
  busy_->add(*used->time, *used->busy - std::min(*used->busy, used->sent.value_or(0)));
  const auto share = busy_->share(kBusyTime, core::mesh::kWhole);
  if (!share) return {};
  return static_cast<std::uint32_t>(*share);
}

core::mesh::Snapshot View::update(const Seen& seen, std::uint64_t now) {
  core::mesh::Snapshot out;
  const std::string& own = seen.interface.mac;
  unconfirmed_ = false;
  const auto busy = busy_of(seen);
  const auto metrics = metrics_of_links(seen);
  for (const Station& station : seen.stations) {
    if (!is_peer(station, seen.interface.mesh)) continue;
    Memory& memory = memory_of(station.mac);
    Rate rate = judge(station, memory);
    if (rate.rate == 0) {
      if (const auto path = metrics.find(station.mac); path != metrics.end())
        rate = {.rate = rate_of_metric(path->second).value_or(0), .kind = RateKind::derived};
    }
    // A peer that stops sending remains a station for a long time. The age of the sample is the
    // time since something was received from it.
    const std::uint64_t inactive = station.inactive.value_or(0) * kNanosPerMilli;
    Sample there;
    there.from = own;
    there.to = station.mac;
    there.rate = rate.rate;
    there.kind = rate.kind;
    there.channel = seen.interface.frequency;
    there.taken = now - std::min(now, inactive);
    Sample back = there;
    std::swap(back.from, back.to);
    back.rate = station.rx_bitrate.value_or(0);
    back.kind = RateKind::phy;
    there.busy = busy;
    if (station.tx_packets && station.tx_failed) {
      memory.given_up.add(*station.tx_packets, *station.tx_failed);
      there.loss = memory.given_up.share(kLossPackets, kLossScale);
    }
    if (station.airtime_metric && *station.airtime_metric != kNoLink)
      there.weight = station.airtime_metric;
    out.links.push_back(std::move(there));
    out.links.push_back(std::move(back));
  }
  std::set<std::string_view> there;
  for (const Station& station : seen.stations) there.insert(station.mac);
  std::erase_if(stations_, [&](const auto& known) { return !there.contains(known.first); });
  for (const MeshPath& path : seen.paths)
    if ((path.flags & NL80211_MPATH_FLAG_ACTIVE) != 0)
      out.next_hops.push_back({.from = own, .to = path.destination, .via = path.next_hop});
  return out;
}

}  // namespace mlcca::net::nl80211
