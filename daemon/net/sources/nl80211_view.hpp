// SPDX-License-Identifier: BSD-2-Clause
// Turns the reports of a radio, poll by poll, into samples of links. No socket, no clock.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/sample.hpp"
#include "daemon/net/sources/nl80211_messages.hpp"

namespace mlcca::net::nl80211 {

/// Two increasing counters, one of which counts a part of the other.
class GrowingPart {
 public:
  /// Compares the latest poll with the one `polls` before it.
  explicit GrowingPart(std::size_t polls) : polls_(polls) {}

  /// Adds the counters of a poll. If one is smaller than before it was restarted, and the
  /// comparison restarts too.
  void add(std::uint64_t whole, std::uint64_t part);
  /// The growth of the part relative to that of the total, in 1/`scale`, rounded up, at most
  /// `scale`. nullopt if the total grew by less than `least` (1 or more).
  [[nodiscard]] std::optional<std::uint64_t> share(std::uint64_t least, std::uint64_t scale) const;

 private:
  struct Counters {
    std::uint64_t whole = 0;
    std::uint64_t part = 0;
  };
  std::size_t polls_;
  std::deque<Counters> seen_;
};

/// The reports of one poll of an interface.
struct Seen {
  Interface interface;
  std::vector<Station> stations;
  std::vector<MeshPath> paths;
  std::vector<Survey> surveys;
};

/// The rate in bit/s of a link with this 802.11s airtime metric, which is 1 + 8192 / (rate in
/// Mbit/s) in Linux (mac80211, airtime_link_metric_get()). nullopt for 0, 1, and the largest value,
/// which means "no link".
[[nodiscard]] std::optional<Value> rate_of_metric(std::uint32_t metric);

/// Keeps what counters and unconfirmed rates require from poll to poll.
class View {
 public:
  /// The snapshot after one poll. `now`: CLOCK_MONOTONIC ns of the poll.
  core::mesh::Snapshot update(const Seen& seen, std::uint64_t now);

  /// Whether a station in the latest poll sent more slowly than the throughput that is expected to
  /// get through. A further poll shortly afterwards shows whether this lasts.
  [[nodiscard]] bool unconfirmed() const { return unconfirmed_; }

 private:
  struct Memory {
    GrowingPart given_up;
    std::optional<std::uint32_t> slow_at;  ///< packets sent at the latest poll that found it slower
    unsigned slow_polls = 0;               ///< polls in a row that found it slower
    bool slower = false;                   ///< it sends more slowly than the expected throughput
  };
  struct Rate {
    Value rate = 0;
    core::mesh::RateKind kind = core::mesh::RateKind::phy;
  };
  Memory& memory_of(const std::string& mac);
  Rate judge(const Station& station, Memory& memory);
  std::optional<std::uint32_t> busy_of(const Seen& seen);

  std::map<std::string, Memory> stations_;
  std::optional<std::uint32_t> surveyed_;  ///< MHz
  std::optional<GrowingPart> busy_;
  bool unconfirmed_ = false;
};

}  // namespace mlcca::net::nl80211
