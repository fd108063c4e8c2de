// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/arrivals.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace mlcca::learn {
namespace {

double mean_of(const Flow& flow) {
  return static_cast<double>(flow.active()) / static_cast<double>(flow.gaps());
}

/// Two standard errors of the mean gap, as a part of it, if the coefficient of variation is at
/// least `least`.
double errors_of_mean(const Flow& flow, double least) {
  constexpr double errors = 2;
  const double mean = mean_of(flow);
  double squares = 0;
  flow.for_each_gap([&](std::uint64_t ns, std::uint64_t count) {
    const double gap = static_cast<double>(ns) - mean;
    squares += static_cast<double>(count) * gap * gap;
  });
  const auto gaps = static_cast<double>(flow.gaps());
  const double variation = mean == 0 ? least : std::max(std::sqrt(squares / gaps) / mean, least);
  return errors * variation / std::sqrt(gaps);
}

/// Gaps (ns) by which fewer need be counted, and how often they occurred.
using Counts = std::vector<std::pair<double, double>>;

Counts counts_of(const Flow& flow) {
  Counts out;
  flow.for_each_gap([&out](std::uint64_t ns, std::uint64_t count) {
    const auto gap = static_cast<double>(ns);
    const auto times = static_cast<double>(count);
    // An eighth of the shorter gap makes no difference to what they say together.
    if (!out.empty() && gap < out.back().first * 1.125) {
      auto& [before, all] = out.back();
      before = (before * all + gap * times) / (all + times);
      all += times;
    } else {
      out.emplace_back(gap, times);
    }
  });
  return out;
}

/// ln E[e^(t * (period - gap))]
double exponent(const Counts& counts, double gaps, double period, double t) {
  double sum = 0;
  for (const auto& [gap, count] : counts) sum += count * std::exp(-t * gap);
  return t * period + std::log(sum / gaps);
}

}  // namespace

std::uint64_t longest_period(const Flow& flow) {
  constexpr double part = 0.75;
  constexpr double least = 0.25;
  const double sure = std::max(1 - errors_of_mean(flow, 1), least);
  return std::max<std::uint64_t>(static_cast<std::uint64_t>(part * mean_of(flow) * sure), 1);
}

std::uint64_t shortest_mean(const Flow& flow) {
  const double sure = std::max(1 - errors_of_mean(flow, 0), 0.0);
  return static_cast<std::uint64_t>(mean_of(flow) * sure);
}

std::uint64_t jitter_of_queue(const Flow& flow, std::uint64_t period) {
  const auto by = static_cast<double>(period);
  if (by >= mean_of(flow)) return UINT64_MAX;
  if (flow.shortest_gap() >= period) return 0;
  const Counts counts = counts_of(flow);
  const auto gaps = static_cast<double>(flow.gaps());
  // The exponent is convex, 0 at 0 and falls there: it has one other zero, or none if no gap that
  // counts is shorter than the Period.
  double low = 0;
  double high = 1 / by;
  constexpr int most_doublings = 10;
  for (int i = 0; i < most_doublings && exponent(counts, gaps, by, high) < 0; ++i) {
    low = high;
    high *= 2;
  }
  constexpr int halvings = 8;
  for (int i = 0; i < halvings; ++i) {
    const double middle = (low + high) / 2;
    (exponent(counts, gaps, by, middle) < 0 ? low : high) = middle;
  }
  return low == 0 ? UINT64_MAX
                  : static_cast<std::uint64_t>(std::log(static_cast<double>(kOneOf)) / low);
}

std::uint64_t longest_cycle(const Flow& flow) {
  constexpr double clocks = 1 + 0.00025;
  constexpr double tenth = 0.1;
  const auto median = static_cast<double>(flow.median_gap());
  double periods = 0;
  double cyclic = 0;
  std::uint64_t pauses = 0;
  flow.for_each_gap([&](std::uint64_t ns, std::uint64_t count) {
    const auto gap = static_cast<double>(ns);
    const double times = std::round(gap / median);
    if (times > Flow::kPause) {
      pauses += count;
      return;
    }
    cyclic += static_cast<double>(count) * gap;
    periods += static_cast<double>(count) * times;
  });
  if (periods == 0) return flow.longest_gap();
  // The sum of all gaps and the longest one are exact, and a gap in these counts to 1.6 %.
  constexpr double counted = 1 + 1.0 / 64;
  double sum = cyclic * counted;
  if (pauses < 2) sum = static_cast<double>(flow.active() - (pauses == 0 ? 0 : flow.longest_gap()));
  const auto spread =
      static_cast<double>(flow.quantile(1 - tenth)) - static_cast<double>(flow.quantile(tenth));
  return static_cast<std::uint64_t>(sum / periods * clocks + spread / periods);
}

}  // namespace mlcca::learn
