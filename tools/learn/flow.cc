// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/flow.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <utility>

#include "tools/elements.hpp"

namespace mlcca::learn {

std::size_t Flow::part_of(std::uint64_t gap) {
  const std::uint64_t clamped =
      std::clamp(gap, std::uint64_t{1} << kLowest, (std::uint64_t{1} << kHighest) - 1);
  const auto octave = static_cast<unsigned>(std::bit_width(clamped)) - 1;
  const std::uint64_t within = (clamped >> (octave - 5)) & (kParts - 1);  // 5 bits for 32 parts
  return std::size_t{octave - kLowest} * kParts + within;
}

std::uint64_t Flow::middle_of(std::size_t part) {
  const auto octave = static_cast<unsigned>(part / kParts) + kLowest;
  const std::uint64_t low = (kParts + part % kParts) << (octave - 5);
  return low + (std::uint64_t{1} << (octave - 5)) / 2;
}

std::uint64_t Flow::end_of(std::size_t part) {
  const auto octave = static_cast<unsigned>(part / kParts) + kLowest;
  return (kParts + part % kParts + 1) << (octave - 5);
}

void Flow::add(std::uint64_t ns, std::uint32_t bytes, Stretch stretch) {
  // Frames from several queues may be out of order by so much, in ns.
  constexpr std::uint64_t disorder = 1'000'000;
  all_bytes_ += bytes;
  least_bytes_ = std::min(least_bytes_, bytes);
  if (bytes > most_bytes_) longest_events_ = 0;
  most_bytes_ = std::max(most_bytes_, bytes);
  longest_events_ += bytes == most_bytes_ ? 1 : 0;
  const bool is_reset = events_++ == 0 || stretch.clock != stretch_.clock || ns + disorder < last_;
  if (events_ == 1) {
    first_ = ns;
    first_clock_ = stretch.clock;
  }
  const bool is_new = is_reset || stretch != stretch_;
  stretch_ = stretch;
  if (!is_reset) ns = std::max(ns, last_);
  const std::uint64_t gap = ns - std::exchange(last_, ns);
  if (!is_new) count_gap(gap);
  if (gaps_ + 1 >= kFirst && begin_.empty()) {
    judge({ns, is_new, is_reset});
    return;
  }
  keep({ns, is_new, is_reset});
  if (gaps_ + 1 == kFirst) choose_periods();
}

void Flow::count_gap(std::uint64_t gap) {
  if (!histogram_) histogram_ = std::make_unique<Histogram>();
  ++gaps_;
  sum_ += gap;
  shortest_ = std::min(shortest_, gap);
  longest_ = std::max(longest_, gap);
  std::uint32_t& count = (*histogram_)[part_of(gap)];
  if (count != UINT32_MAX) ++count;
}

/// Keeps an event, unless it is alone in its stretch: such events say nothing about gaps.
void Flow::keep(Moment event) {
  if (event.is_new && !begin_.empty() && begin_.back().is_new) {
    event.is_reset = event.is_reset || begin_.back().is_reset;
    begin_.pop_back();
  }
  begin_.push_back(event);
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

double Flow::regular_share(std::uint64_t longest) const {
  if (gaps_ == 0) return 0;
  constexpr double near = 0.25;
  const auto median = static_cast<double>(median_gap());
  std::uint64_t regular = 0;
  std::uint64_t all = 0;
  for (std::size_t part = 0; part < histogram_->size(); ++part) {
    if ((*histogram_)[part] == 0 || middle_of(part) > longest) continue;
    all += (*histogram_)[part];
    const double times = static_cast<double>(middle_of(part)) / median;
    const double nearest = std::round(times);
    if (nearest >= 1 && nearest <= 10 && std::abs(times - nearest) <= near)
      regular += (*histogram_)[part];
  }
  return all == 0 ? 0 : static_cast<double>(regular) / static_cast<double>(all);
}

std::uint64_t Flow::longest_of_one() const {
  if (gaps_ == 0) return 0;
  const std::uint64_t limit = median_gap() + median_gap() / 2;
  std::uint64_t longest = 0;
  for (std::size_t part = 0; part < histogram_->size() && middle_of(part) < limit; ++part)
    if ((*histogram_)[part] != 0) longest = middle_of(part);
  return std::min(longest, longest_);
}

Flow::Pauses Flow::pauses(const Run& least) const {
  // The longest gap that is none, as a gap of so many medians may have a rest.
  const std::uint64_t longest = (median_gap() + 1) * kPause;
  if (longest_ < longest) return {.longest_other = longest_};
  Pauses out;
  std::uint64_t cycles = 0;
  std::uint64_t active = 0;
  for (std::size_t part = 0; part < histogram_->size(); ++part) {
    const std::uint64_t count = (*histogram_)[part];
    if (count == 0) continue;
    if (end_of(part) > longest) {
      out.count += count;
      continue;
    }
    cycles += count;
    active += count * middle_of(part);
    out.longest_other = std::min(end_of(part), longest_);
  }
  const std::uint64_t runs = out.count + 1;
  if (cycles < runs * least.cycles || active < runs * least.ns) return {.longest_other = longest_};
  return out;
}

std::uint64_t Flow::gaps_below(std::uint64_t ns) const {
  std::uint64_t count = 0;
  for (std::size_t part = 0; gaps_ != 0 && part < histogram_->size() && middle_of(part) < ns;
       ++part)
    count += (*histogram_)[part];
  return count;
}

bool Flow::comes_in_bursts() const {
  constexpr std::uint64_t fewest = 4;
  if (gaps_ < fewest) return false;
  return gaps_below(sum_ / gaps_ / 10) * 4 >= gaps_;
}

namespace {

/// The cycle of gaps of which most are near their median or a multiple of it. Gaps longer than
/// kPause medians do not count. 0: they have none.
std::uint64_t cycle_of_gaps(std::span<const std::uint64_t> gaps, std::uint64_t median) {
  constexpr std::uint64_t most_irregular = 10;  // one of so many
  std::uint64_t sum = 0;
  std::uint64_t periods = 0;
  std::uint64_t irregular = 0;
  for (const std::uint64_t gap : gaps) {
    if (median == 0 || gap / median >= Flow::kPause) continue;
    const std::uint64_t times = (gap + median / 2) / median;
    const std::uint64_t nearest = times * median;
    if (times == 0 || std::max(gap, nearest) - std::min(gap, nearest) > median / 4) {
      ++irregular;
      continue;
    }
    sum += gap;
    periods += times;
  }
  return periods == 0 || irregular * most_irregular > gaps.size() ? 0 : sum / periods;
}

}  // namespace

/// Chooses the periods, from the cycle or the mean of the first gaps downwards.
void Flow::choose_periods() {
  std::vector<std::uint64_t> gaps;
  for (std::size_t i = 1; i < begin_.size(); ++i)
    if (!begin_[i].is_new) gaps.push_back(begin_[i].ns - begin_[i - 1].ns);
  std::ranges::nth_element(gaps, gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2));
  const std::uint64_t middle = gaps[gaps.size() / 2];
  const std::uint64_t cycle = cycle_of_gaps(gaps, middle);
  const bool pauses = std::ranges::max(gaps) > middle * kPause;
  // For bursts the median is the gap within a burst, and the mean corresponds to their load on the
  // bus.
  const std::uint64_t first = cycle != 0 && !pauses
                                  ? std::max(cycle, std::uint64_t{1000})
                                  : std::max({middle, mean_of_few(), std::uint64_t{1000}});
  constexpr std::array<unsigned, kPolicers> percent = {100, 99, 98, 95, 90, 80,
                                                       67,  50, 33, 25, 10, 5};
  const std::uint64_t period = tools::nominal(first);
  for (std::size_t i = 0; i < kPolicers; ++i)
    policers_[i].period = std::max<std::uint64_t>(period * percent[i] / 100, 1);
  constexpr std::uint64_t longest = 1'000'000'000;
  for (std::uint64_t times = 2; period * times <= longest; times *= 2)
    longer_.push_back({.period = period * times});
  std::ranges::reverse(longer_);
  const std::uint64_t cyclic =
      std::max<std::uint64_t>(tools::nominal(cycle == 0 ? middle : cycle), 1000);
  if (period > cyclic && pauses)
    for (const unsigned part : percent)
      cyclic_.push_back({.period = std::max<std::uint64_t>(cyclic * part / 100, 1)});
  for (const Moment& one : begin_) judge(one);
  begin_ = {};
}

void Flow::judge(const Moment& event) {
  for (Policer& p : policers_) p.take(event);
  for (Policer& p : longer_) p.take(event);
  for (Policer& p : cyclic_) p.take(event);
}

void Flow::Policer::take(const Moment& event) {
  const std::uint64_t ns = event.ns;
  if (event.is_reset) due = 0;
  if (ns < due) early = std::max(early, due - ns);
  due = std::max(due, ns) + period;
}

std::uint64_t Flow::mean_of_few(std::uint64_t longest) const {
  std::uint64_t sum = 0;
  std::uint64_t count = 0;
  for (std::size_t i = 1; i < begin_.size(); ++i) {
    if (begin_[i].is_new || begin_[i].ns - begin_[i - 1].ns > longest) continue;
    sum += begin_[i].ns - begin_[i - 1].ns;
    ++count;
  }
  return count == 0 ? 0 : sum / count;
}

std::uint64_t Flow::early_of(std::span<const Moment> events, std::uint64_t period) {
  Policer policer{.period = period};
  for (const Moment& one : events) policer.take(one);
  return policer.early;
}

std::vector<Rate> Flow::of_each(std::span<const Policer> policers) {
  std::vector<Rate> out;
  out.reserve(policers.size());
  for (const Policer& p : policers) out.push_back({p.period, p.early});
  return out;
}

std::vector<Rate> Flow::rates() const {
  return gaps_ + 1 < kFirst ? std::vector<Rate>() : of_each(policers_);
}

std::vector<Rate> Flow::cyclic_rates() const {
  return cyclic_.empty() ? rates() : of_each(cyclic_);
}

std::vector<Rate> Flow::longer_rates() const { return of_each(longer_); }

std::vector<Rate> Flow::all_rates() const {
  std::vector<Rate> out = longer_rates();
  std::ranges::copy(rates(), std::back_inserter(out));
  return out;
}

}  // namespace mlcca::learn
