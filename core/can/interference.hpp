// SPDX-License-Identifier: BSD-2-Clause
// What messages demand of the bus in a given time, in flat arrays. This is the innermost loop of
// the analysis.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/can/message.hpp"

namespace mlcca::core::can {

/// A share of the bus time in units of 2^-40, rounded up and limited to kAllShare.
using Share = std::uint64_t;
inline constexpr unsigned kShareBits = 40;
inline constexpr Share kAllShare = Share{1} << kShareBits;
/// part / whole. `whole` is not 0, and neither exceeds kLongestTime.
[[nodiscard]] Share share_of(Time part, Time whole);

/// The demand of streams, in an order that the caller chooses. A division by a period is a
/// multiplication with its reciprocal, which is exact here: Granlund and Montgomery, "Division by
/// invariant integers using multiplication", PLDI 1994.
class Interference {
 public:
  Interference() = default;
  /// `bit`: bit time of the bus in ns, not 0.
  explicit Interference(Time bit) : bit_(bit) {}

  /// Inserts a usable() message. `jitter`: ns from the nominal release until a frame is offered at
  /// the latest.
  void insert(std::size_t at, const Message& message, Time jitter);
  void erase(std::size_t at);
  void swap(std::size_t a, std::size_t b);
  void set_jitter(std::size_t at, Time jitter);

  /// The time (ns) of all frames of streams [first, last) that are offered within `until` and one
  /// more bit time from an idle start: sum of ceil((until + jitter + bit) / period) * transmission.
  /// No single stream takes the entire bus, and `until` is at most 2^42.
  [[nodiscard]] Time demand(std::size_t first, std::size_t last, Time until) const {
    Time sum = 0;
    for (std::size_t i = first; i < last; ++i)
      sum += (periods(i, until + offset_[i]) + 1) * cost_[i];
    return sum;
  }
  /// The demand of one stream with another jitter.
  [[nodiscard]] Time demand_of(std::size_t i, Time until, Time jitter) const {
    return (periods(i, until + jitter + bit_ - 1) + 1) * cost_[i];
  }
  /// The number of events of a stream that are queued from an idle start until `until`, inclusive.
  [[nodiscard]] Time events(std::size_t i, Time until, Time jitter) const {
    return periods(i, until + jitter) + 1;
  }

  /// The share of bus time of one stream, or of all in a range.
  [[nodiscard]] Share share(std::size_t i) const { return share_[i]; }
  [[nodiscard]] Share share(std::size_t first, std::size_t last) const;
  /// Intercept (ns) of a line that demand(i, i + 1, until) never exceeds: fixed(i) + share(i) *
  /// until.
  [[nodiscard]] Time fixed(std::size_t i) const { return fixed_[i]; }

  [[nodiscard]] std::size_t size() const { return cost_.size(); }
  [[nodiscard]] Time bit() const { return bit_; }

 private:
  __extension__ using Product = unsigned __int128;
  /// floor(time / period), exact for times below 2^63.
  [[nodiscard]] std::uint64_t periods(std::size_t i, Time time) const {
    return static_cast<std::uint64_t>(Product{time} * reciprocal_[i] >> 64U) >> shift_[i];
  }
  void set_fixed(std::size_t i);

  Time bit_ = 1;
  std::vector<Time> offset_;  ///< jitter + bit - 1, in ns
  std::vector<std::uint64_t> reciprocal_;
  std::vector<std::uint32_t> shift_;
  std::vector<Time> cost_;  ///< transmission, in ns
  std::vector<Share> share_;
  std::vector<Time> fixed_;
};

}  // namespace mlcca::core::can
