// SPDX-License-Identifier: BSD-2-Clause
// From what a radio reports, poll by poll, to samples of links. No socket, no clock.
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

/// Two counters that only grow, of which one counts a part of what the other counts.
class GrowingPart {
 public:
  /// Compares the latest poll with the one `polls` before it.
  explicit GrowingPart(std::size_t polls) : polls_(polls) {}

  /// A counter that is smaller than before was restarted, and so is this.
  void add(std::uint64_t whole, std::uint64_t part);
  /// By how much of `whole` the part grew, in 1/`scale`, rounded up, at most `scale`. Nothing if
  /// the whole grew by less than `least` (1 or more).
  [[nodiscard]] std::optional<std::uint64_t> share(std::uint64_t least, std::uint64_t scale) const;

 private:
  struct Counters {
    std::uint64_t whole = 0;
    std::uint64_t part = 0;
  };
  std::size_t polls_;
  std::deque<Counters> seen_;
};

/// One poll of an interface.
struct Seen {
  Interface interface;
  std::vector<Station> stations;
  std::vector<MeshPath> paths;
  std::vector<Survey> surveys;
};

/// bit/s of a link with this 802.11s airtime metric, which is 1 + 8192 / (rate in Mbit/s) in Linux
/// (mac80211, airtime_link_metric_get()). Nothing for 0, 1 and the largest value, "no link".
[[nodiscard]] std::optional<Value> rate_of_metric(std::uint32_t metric);

/// Remembers what counters and doubts need from poll to poll.
class View {
 public:
  /// `now`: CLOCK_MONOTONIC ns of the poll.
  core::mesh::Snapshot update(const Seen& seen, std::uint64_t now);

  /// The latest poll saw a station send slower than what is expected to get through. Whether that
  /// will last is known after a further poll, which comes soon.
  [[nodiscard]] bool doubtful() const { return doubtful_; }

 private:
  struct Memory {
    GrowingPart given_up;
    std::optional<std::uint32_t> doubted;  ///< packets sent at the latest doubtful poll
    unsigned doubts = 0;                   ///< doubtful polls in a row
    bool slower = false;                   ///< it sends slower than what is expected to get through
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
  bool doubtful_ = false;
};

}  // namespace mlcca::net::nl80211
