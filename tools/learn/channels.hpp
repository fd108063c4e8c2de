// SPDX-License-Identifier: BSD-2-Clause
// Which channels were seen: what begins somewhere and what goes on to other interfaces, put
// together, and what is stated of the times of each publisher.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/learn/observer.hpp"

namespace mlcca::learn {

/// What is stated of the times of a flow.
struct Times {
  std::uint64_t period = 0;  ///< ns
  std::uint64_t jitter = 0;  ///< ns
  bool periodic = false;
  bool on_events = false;  ///< periodic, and further events come in between
  bool bursts = false;     ///< not periodic, and many events come soon after another
  bool assumed = false;    ///< nothing says how often it comes
  std::string seen;        ///< in words, with the margin
};
/// What the Period of a flow with few events is.
enum class OfFew : std::uint8_t { half_the_mean, the_mean };
[[nodiscard]] Times times_of(const Flow& flow, OfFew few = OfFew::half_the_mean);
/// Events that were lost in a row at most, of one in each `period`, ns.
[[nodiscard]] std::uint64_t omission_of(const Flow& flow, std::uint64_t period);

/// To three digits, for people.
[[nodiscard]] std::string about(std::uint64_t ns);
/// To two digits.
[[nodiscard]] std::uint64_t rounded_up(std::uint64_t value);
/// So many percent more, rounded up to two digits.
[[nodiscard]] std::uint64_t with_margin(std::uint64_t value, unsigned percent);

/// One publisher of a channel.
struct Source {
  FlowKey key;
  const Seen* seen = nullptr;
  Times times;
};

/// What a channel has on one interface, whoever sends it there.
struct Place {
  std::uint64_t number = 0;  ///< see Event
  bool fd = false;
  bool classic = false;
  bool remote = false;
  bool local = false;  ///< a program of this host sends there, of its own
  std::set<std::uint32_t> priorities;
  std::optional<Crossing> crossing;  ///< copies were seen there
  std::uint32_t node = 0;            ///< of who sent the copies
  /// The copies have another identifier than on the bus that they came from.
  std::optional<Crossings::Found> renumbered;
};

struct Channel {
  std::uint32_t interface = 0;            ///< where it begins, the first one
  std::uint64_t number = 0;               ///< there
  std::optional<std::uint64_t> subject;   ///< where it was seen on Ethernet
  std::vector<Source> sources;            ///< at least one
  std::map<std::uint32_t, Place> places;  ///< by interface
};

/// In the order of interface and number. What is on an Ethernet whose traffic is not FAMOUSO's is
/// left out.
[[nodiscard]] std::vector<Channel> channels_of(const Observer& observer);

}  // namespace mlcca::learn
