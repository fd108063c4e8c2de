// SPDX-License-Identifier: BSD-2-Clause
// Supervision and policing of events that come from programs on the gateway.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "control/messages.hpp"

namespace mlcca::client {

/// What the programs of one user on the gateway send to one subscriber of this program. No gate
/// lies in between, so the receiving program applies the rules of a gate itself: maximum length,
/// policing (GCRA) and the silence timer, with the values that the daemon has granted.
class LocalSource {
 public:
  /// How long (ns) events must arrive without a gap before `restored` is reported, as at a gate.
  static constexpr std::uint64_t kHold = 1'000'000'000;
  /// Least time (ns) between two reports of excess, or of missed events.
  static constexpr std::uint64_t kPause = 1'000'000'000;

  /// `now` is CLOCK_MONOTONIC in ns, here and in all functions below.
  LocalSource(control::Endpoint granted, std::uint64_t now)
      : granted_(std::move(granted)), last_(now) {}

  [[nodiscard]] const control::Endpoint& granted() const { return granted_; }
  /// Replaces the granted values; the user is the same.
  void grant(control::Endpoint granted) { granted_ = std::move(granted); }

  /// Whether the event is admitted; false: it is too long or exceeds the rate, and is to be
  /// dropped. `unix_ns`: when the kernel received it.
  [[nodiscard]] bool takes(std::size_t bytes, std::uint64_t unix_ns, std::uint64_t now);

  /// Counts events that were lost before this one because the kernel had no room for them.
  void miss(std::uint64_t events, std::uint64_t now);

  /// The next event to report, of kind policed, missed, missing or restored. Call it until it
  /// returns nullopt.
  [[nodiscard]] std::optional<control::Event> happened(std::uint64_t now);
  /// When happened() may return something next; nullopt: not before another event has arrived.
  [[nodiscard]] std::optional<std::uint64_t> due() const;

 private:
  [[nodiscard]] bool is_in_turn(std::size_t bytes, std::uint64_t unix_ns);
  [[nodiscard]] control::Event event(const char* kind) const;
  [[nodiscard]] control::Event excess();
  [[nodiscard]] control::Event missed();
  [[nodiscard]] control::Event missing(std::uint64_t now);
  [[nodiscard]] control::Event restored();

  control::Endpoint granted_;
  std::uint64_t last_;           ///< when the latest event arrived, or this object was made
  std::uint64_t silent_at_ = 0;  ///< arrival of the last event before the reported silence; 0: no
                                 ///< silence is reported
  std::uint64_t back_at_ = 0;    ///< since when events arrive again after it; 0: they do not
  std::uint64_t turn_ = 0;  ///< theoretical arrival time (GCRA) of the next event, Unix time in ns
  std::uint64_t seen_ = 0;  ///< Unix time in ns at which the latest event was received
  std::uint64_t excess_ = 0;     ///< events in excess that are not reported yet
  std::uint64_t excess_at_ = 0;  ///< when the first of them arrived
  std::uint64_t missed_ = 0;     ///< lost events that are not reported yet
  std::uint64_t missed_at_ = 0;  ///< when the first of these losses was noticed
};

}  // namespace mlcca::client
