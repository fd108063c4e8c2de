// SPDX-License-Identifier: BSD-2-Clause
// Derives the event channels from the observed traffic.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tools/elements.hpp"
#include "tools/learn/observer.hpp"

namespace mlcca::learn {

/// The timing that is stated for a flow.
struct Times {
  std::uint64_t period = 0;  ///< ns between events
  std::uint64_t jitter = 0;  ///< ns
  bool periodic = false;
  bool on_events = false;           ///< periodic, with further events in between
  bool bursts = false;              ///< not periodic, and many events come in quick succession
  bool assumed = false;             ///< the traffic does not show how often events come
  std::uint64_t pauses = 0;         ///< times in which what is cyclic paused, see Flow::Pauses
  std::uint64_t longest_pause = 0;  ///< ns
  std::string seen;                 ///< the observation in words, with the margin
};
/// How the Period of a flow with few events follows from the mean of its gaps.
enum class OfFew : std::uint8_t { half_the_mean, the_mean };
/// What is assumed of how often events come.
struct TimesOptions {
  OfFew few = OfFew::half_the_mean;
  /// The Period (ns) of what was seen so seldom that the traffic does not show how often it comes.
  std::uint64_t assumed_period = tools::kPeriodOfOne;
  /// The shortest Period (ns) of bursts that came in a small part of the recording, unless the
  /// number of their events shows that it must be shorter.
  std::uint64_t period_of_bursts = 10'000'000;
  std::uint64_t at_once = 32;  ///< most events of a burst of an aperiodic flow
  /// Regular events count as a burst also if the recording may have cut off a cycle.
  bool all_bursts = false;
  /// Bursts that have a cycle for a tenth of a second or more have it as Period.
  bool cycles_of_bursts = true;
  std::uint64_t listened = 0;  ///< ns; counts if it exceeds the time that was recorded
};
/// What was seen of a flow, in words that claim nothing.
[[nodiscard]] std::string seen_in_words(const Flow& flow);
/// Whether a comment says what was seen of a channel, as a draft and seen_in_words() do.
[[nodiscard]] bool says_what_was_seen(std::string_view comment);
[[nodiscard]] Times times_of(const Flow& flow, const Timeline& timeline,
                             const TimesOptions& options = {});
/// The most events that were lost in a row, if one was sent in each `period` (ns) except during
/// pauses.
[[nodiscard]] std::uint64_t omission_of(const Flow& flow, std::uint64_t period);

/// A time for people, with three digits.
[[nodiscard]] std::string about(std::uint64_t ns);
/// The value rounded up to two significant digits.
[[nodiscard]] std::uint64_t rounded_up(std::uint64_t value);
/// The value plus a margin in percent, rounded up to two significant digits.
[[nodiscard]] std::uint64_t with_margin(std::uint64_t value, unsigned percent);

/// One publisher of a channel.
struct Source {
  FlowKey key;
  const Seen* seen = nullptr;
  Times times;
};

/// The frames of a channel on one interface, whoever sends them there.
struct InterfaceTraffic {
  std::uint64_t number = 0;  ///< see Event::number
  bool fd = false;
  bool classic = false;
  bool remote = false;
  bool local = false;  ///< a program of this host sends there, not only copies
  std::set<std::uint32_t> priorities;
  std::optional<Crossing> crossing;  ///< copies of frames from another interface were seen there
  std::uint32_t node = 0;            ///< node number in the copies
  /// The copies have another identifier than on the bus from which they came.
  std::optional<Crossings::Found> renumbered;
};

/// A channel, with everything that was observed of it on all interfaces.
struct Channel {
  std::uint32_t interface = 0;                       ///< the first interface where it begins
  std::uint64_t number = 0;                          ///< its number there
  std::optional<std::uint64_t> subject;              ///< known only if it was seen on Ethernet
  std::vector<Source> sources;                       ///< at least one
  std::map<std::uint32_t, InterfaceTraffic> places;  ///< by interface
};

/// The observed channels, in the order of interface and number. Ethernet traffic that is not
/// FAMOUSO's is left out.
[[nodiscard]] std::vector<Channel> channels_of(const Observer& observer,
                                               const TimesOptions& options = {});

}  // namespace mlcca::learn
