// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/flow.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "tools/elements.hpp"

namespace mlcca::learn {

std::size_t Flow::part_of(std::uint64_t gap) {
  const std::uint64_t clamped =
      std::clamp(gap, std::uint64_t{1} << kLowest, (std::uint64_t{1} << kHighest) - 1);
  const auto octave = static_cast<unsigned>(std::bit_width(clamped)) - 1;
  const std::uint64_t within = (clamped >> (octave - 5)) & (kParts - 1);  // 5 bits: 32 parts
  return std::size_t{octave - kLowest} * kParts + within;
}

std::uint64_t Flow::middle_of(std::size_t part) {
  const auto octave = static_cast<unsigned>(part / kParts) + kLowest;
  const std::uint64_t low = (kParts + part % kParts) << (octave - 5);
  return low + (std::uint64_t{1} << (octave - 5)) / 2;
}

void Flow::add(std::uint64_t ns, std::uint32_t bytes) {
  least_bytes_ = std::min(least_bytes_, bytes);
  most_bytes_ = std::max(most_bytes_, bytes);
  if (events_++ == 0) {
    last_ = ns;
    begin_.push_back(ns);
    return;
  }
  ns = std::max(ns, last_);  // recordings of several interfaces may be a little out of order
  const std::uint64_t gap = ns - std::exchange(last_, ns);
  if (!histogram_) histogram_ = std::make_unique<Histogram>();
  ++gaps_;
  shortest_ = std::min(shortest_, gap);
  longest_ = std::max(longest_, gap);
  std::uint32_t& count = (*histogram_)[part_of(gap)];
  if (count != UINT32_MAX) ++count;
  if (events_ < kFirst) {
    begin_.push_back(ns);
    return;
  }
  if (events_ == kFirst) choose_periods();
  judge(ns);
}

std::uint64_t Flow::quantile(double share) const {
  if (gaps_ == 0) return 0;
  const auto wanted = static_cast<std::uint64_t>(std::ceil(static_cast<double>(gaps_) * share));
  std::uint64_t sum = 0;
  for (std::size_t part = 0; part < histogram_->size(); ++part) {
    sum += (*histogram_)[part];
    if (sum >= wanted && sum != 0) return std::clamp(middle_of(part), shortest_, longest_);
  }
  return longest_;
}

double Flow::regular_share() const {
  if (gaps_ == 0) return 0;
  const auto median = static_cast<double>(median_gap());
  std::uint64_t regular = 0;
  for (std::size_t part = 0; part < histogram_->size(); ++part) {
    if ((*histogram_)[part] == 0) continue;
    const double times = static_cast<double>(middle_of(part)) / median;
    const double nearest = std::round(times);
    if (nearest >= 1 && nearest <= 10 && std::abs(times - nearest) <= 0.1 * std::min(nearest, 2.0))
      regular += (*histogram_)[part];
  }
  return static_cast<double>(regular) / static_cast<double>(gaps_);
}

/// From the median or mean of the first gaps downwards.
void Flow::choose_periods() {
  std::vector<std::uint64_t> gaps;
  for (std::size_t i = 1; i < begin_.size(); ++i) gaps.push_back(begin_[i] - begin_[i - 1]);
  std::ranges::nth_element(gaps, gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2));
  // Of bursts the median is the time within one, and the mean is what they take of the bus.
  const std::uint64_t mean = (begin_.back() - begin_.front()) / gaps.size();
  const std::uint64_t first = std::max({gaps[gaps.size() / 2], mean, std::uint64_t{1000}});
  constexpr std::array<unsigned, kPolicers> percent = {100, 99, 98, 95, 90, 80,
                                                       67,  50, 33, 25, 10, 5};
  const std::uint64_t period = tools::nominal(first);
  for (std::size_t i = 0; i < kPolicers; ++i)
    policers_[i].period = std::max<std::uint64_t>(period * percent[i] / 100, 1);
  for (const std::uint64_t ns : begin_) judge(ns);
  begin_ = {};
}

void Flow::judge(std::uint64_t ns) {
  for (Policer& p : policers_) p.take(ns);
}

void Flow::Policer::take(std::uint64_t ns) {
  if (ns < due) early = std::max(early, due - ns);
  due = std::max(due, ns) + period;
}

std::uint64_t Flow::mean_of_few() const {
  if (begin_.size() < 2) return 0;
  return (begin_.back() - begin_.front()) / (begin_.size() - 1);
}

std::uint64_t Flow::early_of_few(std::uint64_t period) const {
  Policer policer{.period = period};
  for (const std::uint64_t ns : begin_) policer.take(ns);
  return policer.early;
}

std::vector<Rate> Flow::rates() const {
  std::vector<Rate> out;
  if (events_ < kFirst) return out;
  for (const Policer& p : policers_) out.push_back({p.period, p.early});
  return out;
}

}  // namespace mlcca::learn
