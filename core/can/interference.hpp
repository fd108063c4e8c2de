// SPDX-License-Identifier: BSD-2-Clause
// What messages demand of the bus in a time, as flat arrays: the innermost loop of the analysis.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/can/message.hpp"

namespace mlcca::core::can {

/// Parts of the bus time, as multiples of 2^-40, rounded up. More than all is all.
using Share = std::uint64_t;
inline constexpr unsigned kShareBits = 40;
inline constexpr Share kAllShare = Share{1} << kShareBits;
/// part / whole; whole is not 0 and neither is more than kLongestTime.
[[nodiscard]] Share share_of(Time part, Time whole);

/// Streams in an order that the caller chooses. Divisions by a period are multiplications with its
/// reciprocal, which is exact here: Granlund and Montgomery, "Division by invariant integers using
/// multiplication", PLDI 1994.
class Interference {
 public:
  Interference() = default;
  /// `bit`: bit time of the bus, not 0.
  explicit Interference(Time bit) : bit_(bit) {}

  /// The message is usable(). `jitter`: how much later than its nominal release a frame may be
  /// offered.
  void insert(std::size_t at, const Message& message, Time jitter);
  void erase(std::size_t at);
  void swap(std::size_t a, std::size_t b);
  void set_jitter(std::size_t at, Time jitter);

  /// Time that the frames of streams [first, last) take which are offered from an idle start to a
  /// bit after `until`: sum of ceil((until + jitter + bit) / period) * transmission. None of these
  /// takes all of the bus, and `until` is at most 2^42.
  [[nodiscard]] Time demand(std::size_t first, std::size_t last, Time until) const {
    Time sum = 0;
    for (std::size_t i = first; i < last; ++i)
      sum += (periods(i, until + offset_[i]) + 1) * cost_[i];
    return sum;
  }
  /// As above for one stream with another jitter.
  [[nodiscard]] Time demand_of(std::size_t i, Time until, Time jitter) const {
    return (periods(i, until + jitter + bit_ - 1) + 1) * cost_[i];
  }
  /// Events of a stream that are queued from an idle start to `until`, that moment included.
  [[nodiscard]] Time events(std::size_t i, Time until, Time jitter) const {
    return periods(i, until + jitter) + 1;
  }

  /// Bus share of one stream; and of all in the range.
  [[nodiscard]] Share share(std::size_t i) const { return share_[i]; }
  [[nodiscard]] Share share(std::size_t first, std::size_t last) const;
  /// A line that demand(i, i + 1, until) never exceeds: fixed(i) + share(i) * until.
  [[nodiscard]] Time fixed(std::size_t i) const { return fixed_[i]; }

  [[nodiscard]] std::size_t size() const { return cost_.size(); }
  [[nodiscard]] Time bit() const { return bit_; }

 private:
  __extension__ using Product = unsigned __int128;
  /// time / period, rounded down; right for times below 2^63.
  [[nodiscard]] std::uint64_t periods(std::size_t i, Time time) const {
    return static_cast<std::uint64_t>(Product{time} * reciprocal_[i] >> 64U) >> shift_[i];
  }
  void set_fixed(std::size_t i);

  Time bit_ = 1;
  std::vector<Time> offset_;  ///< jitter + bit - 1
  std::vector<std::uint64_t> reciprocal_;
  std::vector<std::uint32_t> shift_;
  std::vector<Time> cost_;  ///< transmission
  std::vector<Share> share_;
  std::vector<Time> fixed_;
};

}  // namespace mlcca::core::can
