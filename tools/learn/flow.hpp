// SPDX-License-Identifier: BSD-2-Clause
// What is seen of the events of one publisher: how often they come, how unevenly, how long they
// are. Events are handed over in the order of time, in stretches (see Timeline); memory does not
// grow with their number.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "tools/learn/timeline.hpp"

namespace mlcca::learn {

/// A period, and how early events came to it at most, ns: a policer with that period and tolerance
/// (GCRA) would have let all of them pass.
struct Rate {
  std::uint64_t period = 0;
  std::uint64_t early = 0;
};

class Flow {
 public:
  /// An event at `ns`, of `bytes`. What is between two events of different stretches of time is no
  /// gap.
  void add(std::uint64_t ns, std::uint32_t bytes, Stretch stretch = {});

  [[nodiscard]] std::uint64_t events() const { return events_; }
  [[nodiscard]] std::uint64_t all_bytes() const { return all_bytes_; }
  [[nodiscard]] std::uint32_t least_bytes() const { return least_bytes_; }
  [[nodiscard]] std::uint32_t most_bytes() const { return most_bytes_; }
  /// Events of fewer bytes than the longest have.
  [[nodiscard]] std::uint64_t shorter_events() const { return events_ - longest_events_; }

  // Of the times between two events of a stretch, ns; 0 where there are none.
  [[nodiscard]] std::uint64_t gaps() const { return gaps_; }
  [[nodiscard]] std::uint64_t shortest_gap() const { return gaps_ == 0 ? 0 : shortest_; }
  [[nodiscard]] std::uint64_t longest_gap() const { return longest_; }
  /// To 2 %.
  [[nodiscard]] std::uint64_t median_gap() const { return quantile(0.5); }
  [[nodiscard]] std::uint64_t quantile(double share) const;
  /// Of all gaps, those within a quarter of the median of it, or of a whole multiple of it up to
  /// 10: events may be lost. A gate takes a gap for another number of periods from half a period
  /// on, and of gaps at random about a third are so near.
  [[nodiscard]] double regular_share() const;
  /// The longest gap in which by the median no event is missing: below one and a half of it.
  [[nodiscard]] std::uint64_t longest_of_one() const;

  // Of the first and the latest event: when, and by which clock.
  [[nodiscard]] std::uint64_t first() const { return first_; }
  [[nodiscard]] std::uint64_t last() const { return last_; }
  [[nodiscard]] std::uint32_t first_clock() const { return first_clock_; }
  [[nodiscard]] std::uint32_t last_clock() const { return stretch_.clock; }

  /// A quarter of the gaps or more are less than a tenth of their mean.
  [[nodiscard]] bool comes_in_bursts() const;

  // Of a flow with fewer than kFirst - 1 gaps:
  /// ns between two events.
  [[nodiscard]] std::uint64_t mean_of_few() const;
  /// How early events came to a period at most, ns.
  [[nodiscard]] std::uint64_t early_of_few(std::uint64_t period) const;

  /// For periods up to the median or mean of the first gaps, the longest first. Empty with less
  /// than kFirst - 1 gaps.
  [[nodiscard]] std::vector<Rate> rates() const;

  /// So many events are kept until their rate is known well enough to judge all others by it.
  static constexpr std::size_t kFirst = 33;

 private:
  // A gap of g ns counts in octave log2(g), each of 32 parts.
  static constexpr unsigned kParts = 32;
  static constexpr unsigned kLowest = 10;   // 1 us
  static constexpr unsigned kHighest = 40;  // 18 minutes
  using Histogram = std::array<std::uint32_t, std::size_t{kParts} * (kHighest - kLowest)>;

  /// When an event came, whether what is before it is no gap, and whether that has another clock.
  struct Moment {
    std::uint64_t ns = 0;
    bool is_new = false;
    bool is_reset = false;
  };

  static std::size_t part_of(std::uint64_t gap);
  static std::uint64_t middle_of(std::size_t part);
  void keep(Moment event);
  void count_gap(std::uint64_t gap);
  void choose_periods();
  void judge(const Moment& event);

  struct Policer {
    std::uint64_t period = 0;
    std::uint64_t due = 0;  ///< when the next event may come, ns; 0: at once
    std::uint64_t early = 0;
    void take(const Moment& event);
  };
  static constexpr std::size_t kPolicers = 12;

  std::uint64_t events_ = 0;
  std::uint64_t gaps_ = 0;
  std::uint64_t first_ = 0;
  std::uint32_t first_clock_ = 0;
  std::uint64_t last_ = 0;
  Stretch stretch_;
  std::uint64_t shortest_ = UINT64_MAX;
  std::uint64_t longest_ = 0;
  std::uint64_t sum_ = 0;  ///< of all gaps
  std::uint64_t all_bytes_ = 0;
  std::uint32_t least_bytes_ = UINT32_MAX;
  std::uint32_t most_bytes_ = 0;
  std::uint64_t longest_events_ = 0;  ///< of so many bytes
  std::vector<Moment> begin_;         ///< until the periods are chosen
  std::array<Policer, kPolicers> policers_{};
  std::unique_ptr<Histogram> histogram_;
};

}  // namespace mlcca::learn
