// SPDX-License-Identifier: BSD-2-Clause
// Statistics of the events of one publisher: how often and how regularly they come, and their size.
// Events are added in order of time, in stretches (see Timeline). Memory does not grow with their
// number.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tools/learn/timeline.hpp"

namespace mlcca::learn {

/// A period and the tolerance, both in ns, with which a policer (GCRA) would have passed all
/// events.
struct Rate {
  std::uint64_t period = 0;
  std::uint64_t early = 0;
};

/// The statistics of one flow.
class Flow {
 public:
  /// Adds an event at `ns` of `bytes` bytes. The time between events of different stretches is not
  /// a gap.
  void add(std::uint64_t ns, std::uint32_t bytes, Stretch stretch = {});

  [[nodiscard]] std::uint64_t events() const { return events_; }
  [[nodiscard]] std::uint64_t all_bytes() const { return all_bytes_; }
  [[nodiscard]] std::uint32_t least_bytes() const { return least_bytes_; }
  [[nodiscard]] std::uint32_t most_bytes() const { return most_bytes_; }
  /// The number of events that are shorter than the longest.
  [[nodiscard]] std::uint64_t shorter_events() const { return events_ - longest_events_; }

  // Times between two events of a stretch, in ns; 0 if there are none.
  [[nodiscard]] std::uint64_t gaps() const { return gaps_; }
  [[nodiscard]] std::uint64_t shortest_gap() const { return gaps_ == 0 ? 0 : shortest_; }
  [[nodiscard]] std::uint64_t longest_gap() const { return longest_; }
  [[nodiscard]] std::uint64_t mean_gap() const { return gaps_ == 0 ? 0 : sum_ / gaps_; }
  /// The sum of them.
  [[nodiscard]] std::uint64_t active() const { return sum_; }
  /// The median, accurate to 2 %.
  [[nodiscard]] std::uint64_t median_gap() const { return quantile(0.5); }
  [[nodiscard]] std::uint64_t quantile(double share) const;
  /// Calls `with` for the gaps in ascending order: the middle of a range of gaps that differ by 3 %
  /// at most, in ns, and how many there are.
  template <class With>
  void for_each_gap(const With& with) const {
    for (std::size_t part = 0; gaps_ != 0 && part < histogram_->size(); ++part)
      if (const std::uint64_t count = (*histogram_)[part]; count != 0)
        with(std::clamp(middle_of(part), shortest_, longest_), count);
  }
  /// The share of gaps within a quarter of the median around the median or a multiple of it up to
  /// 10 (events may be lost). A gate assigns a gap to the nearest number of periods, and about a
  /// third of random gaps would be within these ranges.
  /// Gaps longer than `longest` (ns) do not count.
  [[nodiscard]] double regular_share(std::uint64_t longest = UINT64_MAX) const;
  /// The longest gap within which, judged by the median, no event is missing: below 1.5 times the
  /// median.
  [[nodiscard]] std::uint64_t longest_of_one() const;

  /// Times in which cyclic traffic paused: gaps of more than kPause times the median.
  struct Pauses {
    std::uint64_t count = 0;
    std::uint64_t longest_other =
        0;  ///< ns: the longest of all other gaps, rounded up by up to 3 %
  };
  /// The events between two pauses: so many cycles, for so many ns.
  struct Run {
    std::uint64_t cycles = 0;
    std::uint64_t ns = 0;
  };
  /// Its pauses, if the runs between them are at least that long on average. `count` is 0 if it has
  /// no pauses, or if its runs are shorter, which are bursts then.
  [[nodiscard]] Pauses pauses(const Run& least) const;
  /// A gap of so many times the median, or less, may be due to lost events.
  static constexpr std::uint64_t kPause = 10;

  // The times of the first and the latest event, and the clocks that they are from.
  [[nodiscard]] std::uint64_t first() const { return first_; }
  [[nodiscard]] std::uint64_t last() const { return last_; }
  [[nodiscard]] std::uint32_t first_clock() const { return first_clock_; }
  [[nodiscard]] std::uint32_t last_clock() const { return stretch_.clock; }

  /// Whether at least a quarter of the gaps are shorter than a tenth of the mean; false for fewer
  /// than 4 gaps.
  [[nodiscard]] bool comes_in_bursts() const;

  /// The number of gaps shorter than `ns`, accurate to 3 % of that time.
  [[nodiscard]] std::uint64_t gaps_below(std::uint64_t ns) const;

  // For a flow with fewer than kFirst - 1 gaps:
  /// The mean time between two events, in ns. Gaps longer than `longest` do not count.
  [[nodiscard]] std::uint64_t mean_of_few(std::uint64_t longest = UINT64_MAX) const;
  /// The tolerance in ns with which all events conform to `period`.
  [[nodiscard]] std::uint64_t early_of_few(std::uint64_t period) const {
    return early_of(begin_, period);
  }
  /// The time of an event, whether the time before it is not a gap, and whether that is because of
  /// another clock.
  struct Moment {
    std::uint64_t ns = 0;
    bool is_new = false;
    bool is_reset = false;
  };
  /// Its events, without some that are alone in their stretch. Empty with more gaps.
  [[nodiscard]] std::span<const Moment> few() const { return begin_; }
  /// The tolerance in ns with which all these events conform to `period`.
  [[nodiscard]] static std::uint64_t early_of(std::span<const Moment> events, std::uint64_t period);

  /// Rates for several periods up to the median or mean of the first gaps, the longest period
  /// first. Empty with fewer than kFirst - 1 gaps.
  [[nodiscard]] std::vector<Rate> rates() const;
  /// The same for periods up to the median, whatever the mean: of cyclic traffic that paused.
  [[nodiscard]] std::vector<Rate> cyclic_rates() const;
  /// The same for longer periods up to a second: of bursts that the first gaps are within.
  [[nodiscard]] std::vector<Rate> longer_rates() const;
  /// The longer rates, then those of rates().
  [[nodiscard]] std::vector<Rate> all_rates() const;

  /// So many events are kept before periods are chosen, by which all further events are judged.
  static constexpr std::size_t kFirst = 33;

 private:
  // A gap of g ns is counted in octave log2(g), each divided into 32 parts.
  static constexpr unsigned kParts = 32;
  static constexpr unsigned kLowest = 10;   // 1 us
  static constexpr unsigned kHighest = 40;  // 18 minutes
  using Histogram = std::array<std::uint32_t, std::size_t{kParts} * (kHighest - kLowest)>;

  static std::size_t part_of(std::uint64_t gap);
  static std::uint64_t middle_of(std::size_t part);
  static std::uint64_t end_of(std::size_t part);
  void keep(Moment event);
  void count_gap(std::uint64_t gap);
  void choose_periods();
  void judge(const Moment& event);

  struct Policer {
    std::uint64_t period = 0;
    std::uint64_t due = 0;  ///< the time in ns from which the next event conforms; 0: at once
    std::uint64_t early = 0;
    void take(const Moment& event);
  };
  static constexpr std::size_t kPolicers = 12;
  static std::vector<Rate> of_each(std::span<const Policer> policers);

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
  std::uint64_t longest_events_ = 0;  ///< number of events with most_bytes_
  std::vector<Moment> begin_;         ///< the first events, until periods are chosen
  std::array<Policer, kPolicers> policers_{};
  std::vector<Policer> longer_;  ///< the longest period first
  std::vector<Policer> cyclic_;  ///< from the median, if the mean is longer because of a pause
  std::unique_ptr<Histogram> histogram_;
};

}  // namespace mlcca::learn
